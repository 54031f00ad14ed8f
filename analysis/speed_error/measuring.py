"""Time and error of contenders, side by side."""

import itertools
import math
import os
import platform
import re
import statistics
import time
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

import numpy as np

from analysis.speed_error.contenders import Answers, Contender
from analysis.speed_error.work import Work
from analysis.stability import exactly
from longball.engines.compiled import compile_at_once
from longball.model.result import Number, Result

VERSIONS = ("numpy", "scipy", "numba", "python-flint", "heyoka", "diffrax", "jax", "scikit-sundae")


class Errors(NamedTuple):
    """Errors of a contender in scenes whose truth is known.

    Errors are |D - true D| where both have landed, m; NaN if there is none.
    """

    scenes: int
    median: float
    most: float  # the 99th percentile
    worst: float
    contacts: int  # scenes in which the ball truly meets the bat between its ends
    missed: int  # of those, how many are answered with that it does not
    unanswered: int  # scenes without an answer


class Measured(NamedTuple):
    """Times of a contender by round, s per scene, and its errors."""

    contender: Contender
    seconds: list[float]
    errors: Errors

    @property
    def microseconds(self) -> float:
        """The median time of a scene, µs."""
        return 1e6 * statistics.median(self.seconds)


def measure(turns: Sequence[tuple[Contender, Work]], rounds: int) -> list[Measured]:
    """Time contenders at the first scenes of their work, and hold their answers against the truth.

    In a round everyone takes a turn, so that what the machine does besides slows all alike. A
    first round, in which code is compiled, does not count.
    """
    compile_at_once()
    portions = [(entrant, work[: entrant.turn]) for entrant, work in turns]
    for entrant, portion in portions:
        entrant.solve(portion)
    seconds: list[list[float]] = [[] for _ in portions]
    for _, (i, (entrant, portion)) in itertools.product(range(rounds), enumerate(portions)):
        begin = time.perf_counter()
        entrant.solve(portion)
        seconds[i].append((time.perf_counter() - begin) / len(portion))
    found = []
    for (entrant, work), mine in zip(turns, seconds, strict=True):
        true = work.true[: entrant.most]
        answers = entrant.solve(work[: len(true)])
        found.append(Measured(entrant, mine, errors(answers, true)))
    return found


def ratio(mine: Sequence[float], measure: Sequence[float]) -> float:
    """Return the median of the rounds' ratios: a slow moment counts on both sides."""
    return statistics.median(a / b for a, b in zip(mine, measure, strict=True))


CONTACT = ("batted", "separating", "airborne")


def errors(answers: Answers, true: Sequence[Result]) -> Errors:
    """Hold answers against the truth."""
    pairs = zip(answers.distances, (result.landing for result in true), strict=True)
    both = ((x, y.distance) for x, y in pairs if x is not None and y is not None)
    off = [difference(*pair) for pair in both] or [math.nan]
    met = [
        outcome
        for outcome, result in zip(answers.outcomes, true, strict=True)
        if result.contact is not None and result.outcome in CONTACT
    ]
    return Errors(
        scenes=len(true),
        median=float(np.median(off)),
        most=float(np.quantile(off, 0.99)),
        worst=max(off),
        contacts=len(met),
        missed=sum(outcome not in (*CONTACT, "") for outcome in met),
        unanswered=sum(outcome == "" for outcome in answers.outcomes),
    )


def difference(found: Number, true: Number) -> float:
    """Return the size of a difference, whatever kinds of numbers the two are."""
    return abs(float(exactly(found) - exactly(true)))


def machine() -> str:
    """Describe the kind of machine."""
    info = Path("/proc/cpuinfo")
    named = re.search(r"model name\s*:(.*)", info.read_text() if info.exists() else "")
    processor = named[1].strip() if named else platform.processor() or platform.machine()
    return f"{processor}, {os.cpu_count()} cores"


def versions() -> str:
    """Return the versions of what is compared."""
    found = [f"Python {platform.python_version()}"]
    for package in VERSIONS:
        with suppress(PackageNotFoundError):
            found.append(f"{package} {version(package)}")
    return ", ".join(found)
