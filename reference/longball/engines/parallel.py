"""Work shared among processes or threads."""

from __future__ import annotations

import gc
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from itertools import chain, islice, starmap
from typing import Any, TypeVar

from longball.engines import of_type
from longball.extras import naming_extras

T = TypeVar("T")


def in_parallel(
    function: Callable[..., T],
    calls: Iterable[tuple[Any, ...]],
    # Number of simultaneous calls; -1: one per core. It never exceeds that of cores or calls.
    workers: int,
    threads: bool = False,  # True for threads, False for processes
) -> Iterator[T]:
    """Yield a function's value for each tuple of arguments, in order.

    Raises `TypeError` or `ValueError` for an invalid number of workers, and `MissingExtra` for
    several workers without joblib (extra ``fast``).
    """
    workers = checked(workers)
    # One worker does not need joblib.
    try:
        from joblib import Parallel, delayed, effective_n_jobs  # slow to import
    except ImportError:
        if workers in (1, -1):
            return starmap(function, calls)
        with naming_extras():
            raise
    cores, calls = effective_n_jobs(-1), iter(calls)  # cores of the cluster, if there is one
    workers = cores if workers == -1 else min(workers, cores)
    # Not more processes than calls. Calls may be an endless stream, so only the first ones are
    # counted.
    first = list(islice(calls, workers))
    workers = max(1, len(first))
    tasks = (delayed(function)(*arguments) for arguments in chain(first, calls))
    prefer = "threads" if threads else "processes"
    with nullcontext() if threads or workers == 1 else _interrupts_held():
        results: Iterator[T] = Parallel(n_jobs=workers, return_as="generator", prefer=prefer)(tasks)
    return results


def checked(workers: object) -> int:
    """Return a number of workers: positive, or -1 for one per core.

    Raises `TypeError` or `ValueError` if it is none.
    """
    number: int = of_type(int, "workers", workers)
    if number < 1 and number != -1:
        raise ValueError(f"workers = {number}: a positive number, or -1 for one per core")
    return number


@contextmanager
def without_collection() -> Iterator[None]:
    """Pause the garbage collector, which would search many results for cycles; they have none."""
    active = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if active:
            gc.enable()


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Block Ctrl-C while processes are started: they inherit that, and this one gets it afterwards.

    A terminal sends it to all processes. Workers would print tracebacks; this process ends them.
    """
    if not hasattr(signal, "pthread_sigmask"):  # not POSIX
        yield
        return
    from multiprocessing import resource_tracker  # slow to import, as joblib is

    from joblib.externals.loky.backend import resource_tracker as tracker_of_joblib

    # Starting one of these trackers unblocks the signal, so they are started first.
    for tracker in (resource_tracker, tracker_of_joblib):
        tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
