"""Settings of all tests."""

from __future__ import annotations

import gc
import io
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# The same examples in every run: a change of the code is what makes a test fail, not the day. Who
# hunts for new ones runs `pytest --hypothesis-profile=default`.
SAME = settings(derandomize=True, database=None, deadline=None)
settings.register_profile("same", SAME, max_examples=10)
settings.register_profile("nightly", SAME, max_examples=100)
settings.load_profile("same")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option of `make nightly`."""
    parser.addoption(
        "--nightly", action="store_true", help="try all scenes where `make test` tries a sample"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marks of what waits for `make nightly`."""
    config.addinivalue_line("markers", "nightly: run with --nightly only")
    config.addinivalue_line("markers", "sampled(every): run the others with --nightly only")
    # Golden data are hundreds of thousands of objects, through which each full collection walks.
    gc.set_threshold(100_000, 20, 100)
    if config.getoption("--nightly"):
        settings.load_profile("nightly")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is for `make nightly`."""
    if config.getoption("--nightly"):
        return
    seen: Counter[str] = Counter()  # sets of parameters of each sampled test
    by_day, waiting = [], []
    for item in items:
        waits = item.get_closest_marker("nightly") is not None
        if not waits and (sampled := item.get_closest_marker("sampled")):
            test, _, _ = item.nodeid.partition("[")
            waits = seen[test] % sampled.kwargs["every"] > 0
            seen[test] += 1
        (waiting if waits else by_day).append(item)
    config.hook.pytest_deselected(items=waiting)
    items[:] = by_day


@pytest.fixture(autouse=True, scope="session")
def as_it_is(pytestconfig: pytest.Config) -> Iterator[None]:
    """Let the series of a law run as they are ten times longer before they are compiled.

    That takes up to ten seconds a law, more than the few flights of a day would save.
    """
    with pytest.MonkeyPatch.context() as patch:
        if not pytestconfig.getoption("--nightly"):
            patch.setattr("longball.engines.taylor._ENOUGH", 20_000)
        yield


@pytest.fixture
def nightly(request: pytest.FixtureRequest) -> bool:
    """True if all scenes are asked for."""
    return request.config.getoption("--nightly")


@pytest.fixture
def called(monkeypatch, capsys) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Return a function that calls the command line in this process.

    For what does not hang on the process: to start one takes longer, with libraries some seconds.
    """
    from longball.__main__ import STOPPED, main

    def call(*arguments: str | Path, stdin: bytes = b"") -> subprocess.CompletedProcess[str]:
        monkeypatch.setattr(sys, "argv", ["longball", *map(str, arguments)])
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin)))
        handlers = {number: signal.getsignal(number) for number in STOPPED}
        capsys.readouterr()
        try:
            with pytest.raises(SystemExit) as left:
                main()
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
            gc.unfreeze()
        said = capsys.readouterr()
        return subprocess.CompletedProcess(sys.argv, left.value.code, said.out, said.err)

    return call
