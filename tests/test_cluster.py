"""``--scheduler``: the same work on a Dask cluster of two workers on this machine."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import longball as longball_package
from tests.test_environment import PATIENCE, longball

distributed = pytest.importorskip("distributed")

# Enough for dozens of tasks; a worker does one in some tenths of a second.
HOME_RUN = ("homerun", "--samples", "80000", "--e", "0.41,0.45", "--json")


def wait_until(condition: Callable[[], Any]) -> Any:
    deadline = time.monotonic() + PATIENCE
    while not (found := condition()):
        assert time.monotonic() < deadline, "nothing happens"
        time.sleep(0.02)
    return found


@dataclass
class Cluster:
    address: str
    client: Any

    def workers(self) -> dict[str, Any]:
        """By address, with the name and the process of each."""
        return self.client.scheduler_info()["workers"]


Start = Callable[..., None]


@contextmanager
def starting() -> Iterator[Start]:
    """Yield what starts parts of a cluster, which end with the context."""

    def start(what: str, *arguments: str, **options: Any) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments]
        process = subprocess.Popen(
            [*command, "--no-dashboard"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            **options,
        )
        stack.callback(process.wait)
        stack.callback(process.kill)

    with ExitStack() as stack:
        yield start


def start_scheduler(start: Start, folder: Path) -> str:
    """Return the address of a scheduler without workers."""
    about = folder / "scheduler.json"
    start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(about))
    wait_until(lambda: about.exists() and about.read_text().endswith("}"))
    return json.loads(about.read_text())["address"]


def start_worker(start: Start, address: str, **options: Any) -> None:
    start("worker", address, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1", **options)


@pytest.fixture(scope="module")
def cluster(
    tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config
) -> Iterator[Cluster]:
    if not pytestconfig.getoption("--nightly"):
        # In threads of this process, which are there at once; what is sent goes through sockets.
        with (
            distributed.LocalCluster(
                n_workers=2, threads_per_worker=1, processes=False, protocol="tcp",
                host="127.0.0.1", dashboard_address=":0",
            ) as local,
            distributed.Client(local, set_as_default=False) as client,
        ):  # fmt: skip
            yield Cluster(local.scheduler_address, client)
        return
    with starting() as start:
        scheduler = start_scheduler(start, tmp_path_factory.mktemp("cluster"))
        for _ in range(2):
            start_worker(start, scheduler)
        with distributed.Client(scheduler, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=PATIENCE)
            yield Cluster(scheduler, client)


AT_BATS = b"".join(
    b'{"kind": "at-bat", "swing": {"height_offset": %f}}\n' % (0.001 * i - 0.05) for i in range(100)
)
BALLS = b"".join(
    b'{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [%d, 5, 22]}}\n' % speed
    for speed in (30, 40)
)


@pytest.mark.parametrize(
    ("call", "stdin"),
    [
        ("solve -", AT_BATS),
        ("parks - --json", BALLS),
        ("movement --example --json", b""),
        ("spin --example --json", b""),
        ("measured --example --json", b""),
    ],
)
def test_answers_are_the_same(called, cluster: Cluster, call: str, stdin: bytes) -> None:
    here = called(*call.split(), stdin=stdin)
    there = called(*call.split(), "--scheduler", cluster.address, stdin=stdin)
    assert there.returncode == 0, there.stderr
    assert there.stdout == here.stdout


# The last that needs both workers.
@pytest.mark.nightly
def test_a_worker_that_is_killed_in_mid_run_changes_no_bit(cluster: Cluster) -> None:
    here = longball(*HOME_RUN)
    with subprocess.Popen(
        [sys.executable, "-m", "longball", *HOME_RUN, "--scheduler", cluster.address],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as there:
        victim, _ = wait_until(
            lambda: [
                (worker, tasks)
                for worker, tasks in cluster.client.processing().items()
                if any("strike" in task for task in tasks)
            ]
        )[0]
        os.kill(cluster.client.run(os.getpid, workers=[victim])[victim], signal.SIGKILL)
        assert there.poll() is None, "the run was over before"
        output, words = there.communicate(timeout=PATIENCE)
    assert there.returncode == here.returncode == 0, words
    assert output == here.stdout
    wait_until(lambda: victim not in cluster.workers() and len(cluster.workers()) == 1)


@pytest.mark.parametrize(
    ("address", "named"),
    [
        ("tcp://127.0.0.1:1", "no scheduler"),
        ("127.0.0.1:8786", "tcp://HOST:PORT"),
        ("tcp://127.0.0.1", "port"),
        ("tls://127.0.0.1:1", "certificates"),
    ],
)
@pytest.mark.sampled(every=3)
@pytest.mark.nightly
def test_an_address_where_nobody_answers_is_refused(called, address: str, named: str) -> None:
    run = called("homerun", "--samples", "10", "--scheduler", address)
    assert run.returncode == 2
    assert run.stdout == ""
    assert named in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.nightly
def test_workers_that_are_none_or_have_other_code_are_refused(called, tmp_path: Path) -> None:
    package = Path(longball_package.__file__).parent
    other = tmp_path / "longball"
    shutil.copytree(package, other, ignore=shutil.ignore_patterns("data", "__pycache__"))
    with open(other / "engines" / "enclosure" / "lemmas.py", "a") as file:
        file.write("# other code\n")
    with starting() as start:
        scheduler = start_scheduler(start, tmp_path)
        run = called("solve", "--scheduler", scheduler, stdin=b"{}")
        assert run.returncode == 2
        assert "has no workers, or none that answers within 8 s" in run.stderr
        start_worker(start, scheduler, env={**os.environ, "PYTHONPATH": str(tmp_path)})
        run = called("solve", "--scheduler", scheduler, stdin=b"{}")
        assert run.returncode == 2
        assert "1 of 1 workers have other code than this longball" in run.stderr
        assert run.stdout == ""
