"""``--scheduler``: the same work on a Dask cluster of two worker processes on this machine."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

distributed = pytest.importorskip("distributed")

# Enough for a hundred tasks; a worker does one in some tenths of a second.
HOME_RUN = ("homerun", "--samples", "200000", "--e", "0.41,0.45", "--json")
PATIENCE = 60.0  # s, far beyond what anything here takes


def longball(*arguments: str, stdin: bytes = b"") -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "longball", *arguments],
        input=stdin,
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )


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


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    about = tmp_path / "scheduler.json"

    def start(what: str, *arguments: str) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments]
        process = subprocess.Popen(
            [*command, "--no-dashboard"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        stack.callback(process.wait)
        stack.callback(process.kill)
        return process

    with ExitStack() as stack:
        start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(about))
        wait_until(lambda: about.exists() and about.read_text().endswith("}"))
        address = json.loads(about.read_text())["address"]
        for _ in range(2):
            start("worker", address, "--nthreads", "1", "--no-nanny", "--host", "127.0.0.1")
        client = stack.enter_context(distributed.Client(address, set_as_default=False))
        client.wait_for_workers(2, timeout=PATIENCE)
        yield Cluster(address, client)


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


def test_lines_have_the_same_answers(cluster: Cluster) -> None:
    scenes = b"".join(
        b'{"id": "%d", "kind": "at-bat", "swing": {"height_offset": %f}}\n' % (i, 0.001 * i - 0.05)
        for i in range(100)
    )
    here = longball("solve", "-", stdin=scenes)
    there = longball("solve", "-", "--scheduler", cluster.address, stdin=scenes)
    assert there.returncode == 0
    assert there.stdout == here.stdout


@pytest.mark.parametrize(
    ("address", "named"),
    [
        ("tcp://127.0.0.1:1", "no scheduler"),
        ("127.0.0.1:8786", "tcp://HOST:PORT"),
        ("tcp://127.0.0.1", "port"),
        ("tls://127.0.0.1:1", "certificates"),
    ],
)
def test_an_address_where_nobody_answers_is_refused(address: str, named: str) -> None:
    run = longball("homerun", "--samples", "10", "--scheduler", address)
    assert run.returncode == 2
    assert run.stdout == b""
    assert named in run.stderr.decode()
    assert b"Traceback" not in run.stderr


def test_without_dask_the_extra_is_named() -> None:
    code = (
        "import sys; sys.modules['distributed'] = None; from longball.cli import main;"
        "sys.argv = ['longball', 'homerun', '--scheduler', 'tcp://127.0.0.1:1']; main()"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert run.returncode == 2
    assert b"longball[dask]" in run.stderr
