"""P(e) by three methods: what a smaller error costs in time."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from analysis.writing import STYLES, figure, render
from longball import golden
from longball.engines.batch import Batch
from longball.home_run import (
    RESTITUTIONS,
    estimate,
    integrals,
    monte_carlo,
    paper_at_bats,
    scrambled,
)
from longball.home_run.randomised import SCRAMBLES
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

N = TypeVar("N", int, float)
T = TypeVar("T")

E = 0.42
SEED = 1
SAMPLES, FULL_SAMPLES = (10_000, 100_000, 1_000_000), (10_000, 100_000, 1_000_000, 10_000_000)
LINES, FULL_LINES = (64, 256, 1024), (64, 256, 1024, 4096)
TOLERANCES = (1e-3, 1e-7)

BASE = AtBatScene(id="base")
PAPER = paper_at_bats(SamplingReading())


def run(report: Path, full: bool) -> str:
    """Compute P(0.42) by each method at several costs, and the curve by quadrature."""
    # What is compiled and imported at the first call is not timed.
    integrated(TOLERANCES[0])
    through_lines(LINES[0])
    samples = FULL_SAMPLES if full else SAMPLES
    lines = FULL_LINES if full else LINES
    rows = [
        *(_timed("Monte Carlo", f"{n:,} at-bats", counted, n) for n in samples),
        *(_timed("scrambled points", f"{n * SCRAMBLES:,} lines", through_lines, n) for n in lines),
        *(_timed("quadrature", f"tolerance {x:.0e}", integrated, x) for x in TOLERANCES),
    ]
    draw(report, pd.DataFrame(rows))
    took, curve = _took(lambda: integrals(BASE, PAPER, RESTITUTIONS, workers=-1))
    million, _ = _took(lambda: counted(1_000_000))
    p, best = _golden(), min(row["error"] for row in rows if row["method"] == "quadrature")
    return render(
        report,
        "quadrature",
        engine=Batch().description,
        e=E,
        rows=rows,
        best=best,
        needed=p * (1 - p) / best**2,
        million=million,
        took=took,
        curve=curve,
    )


def counted(samples: int) -> tuple[float, float]:
    """Return P and its standard error from a sample."""
    (struck,) = monte_carlo(BASE, PAPER, [E], samples, SEED, workers=-1)
    p = estimate(E, struck).p
    return p, float(np.sqrt(p * (1 - p) / samples))


def through_lines(lines: int) -> tuple[float, float]:
    """Return P and its standard error from scrambled points."""
    (found,) = scrambled(BASE, PAPER, [E], lines, SEED, workers=-1)
    return found.p, found.standard_error


def integrated(tolerance: float) -> tuple[float, float]:
    """Return P and its error by quadrature."""
    (found,) = integrals(BASE, PAPER, [E], tolerance=tolerance, workers=-1)
    return found.p, found.error


def _golden() -> float:
    """Return the golden P(0.42) of the default reading."""
    default, *_ = golden.probabilities().cases
    return next(row.p for row in default.rows if row.e == E)


def _took(compute: Callable[[], T]) -> tuple[float, T]:
    start = time.perf_counter()
    found = compute()
    return time.perf_counter() - start, found


def _timed(
    method: str, size: str, compute: Callable[[N], tuple[float, float]], cost: N
) -> dict[str, Any]:
    """Return a row of the table."""
    took, (p, error) = _took(lambda: compute(cost))
    return {
        "method": method,
        "of": size,
        "time": took,
        "p": p,
        "error": error,
        "off": abs(p - _golden()),
    }


def draw(report: Path, frame: pd.DataFrame) -> None:
    """Draw error against time."""
    with figure(report, "quadrature", size=(6.0, 3.8)) as (axes,):
        for method, rows in frame.groupby("method", sort=False):
            axes.plot(rows["time"], rows["error"], **STYLES[str(method)], label=str(method))
        axes.set(xscale="log", yscale="log", xlabel="time, s", ylabel=f"error of P({E})")
        axes.legend()
