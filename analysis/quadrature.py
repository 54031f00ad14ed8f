"""P(e) by three methods: what a smaller error costs in time."""

import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from analysis.paper.printed import AT_BATS, BASE
from analysis.writing import STYLES, Report
from longball import golden, home_run
from longball.engines.batch import Batch
from longball.home_run.randomised import SCRAMBLES

E = 0.42
SEED = 1
SAMPLES, FULL_SAMPLES = (10_000, 100_000, 1_000_000), (10_000, 100_000, 1_000_000, 10_000_000)
LINES, FULL_LINES = (64, 256, 1024), (64, 256, 1024, 4096)
TOLERANCES = (1e-3, 1e-7)
PROBLEM = BASE, AT_BATS


def run(report: Report, full: bool) -> str:
    """Compute P(0.42) by each method at several costs, and the curve by quadrature."""
    # What is compiled and imported at the first call is not timed.
    integrated(TOLERANCES[0])
    through_lines(LINES[0])
    default, *_ = golden.probabilities().cases
    true = next(row.p for row in default.rows if row.e == E)
    samples, lines = (FULL_SAMPLES, FULL_LINES) if full else (SAMPLES, LINES)
    calls: list[tuple[str, str, Callable[[Any], tuple[float, float]], Any]] = [
        *(("Monte Carlo", f"{n:,} at-bats", counted, n) for n in samples),
        *(("scrambled points", f"{n * SCRAMBLES:,} lines", through_lines, n) for n in lines),
        *(("quadrature", f"tolerance {x:.0e}", integrated, x) for x in TOLERANCES),
    ]
    rows = [(method, of, *timed(compute, cost)) for method, of, compute, cost in calls]
    found = pd.DataFrame(rows, columns=["method", "of", "time", "p", "error"])
    with report.figure("quadrature", size=(6.0, 3.8)) as (axes,):
        for name, of_method in found.groupby("method", sort=False):
            style = STYLES[str(name)]
            axes.plot(of_method["time"], of_method["error"], **style, label=str(name))
        axes.set(xscale="log", yscale="log", xlabel="time, s", ylabel=f"error of P({E})")
        axes.legend()
    took, *curve = timed(partial(home_run.integrals, *PROBLEM, workers=-1), home_run.RESTITUTIONS)
    return report.render(
        "quadrature", globals(), engine=Batch().description, rows=found, known=true,
        took=took, curve=curve,
    )  # fmt: skip


def counted(samples: int) -> tuple[float, float]:
    """Return P and its standard error from a sample."""
    (found,) = home_run.estimates(*PROBLEM, [E], samples, SEED, workers=-1)
    return found.p, float(np.sqrt(found.p * (1 - found.p) / samples))


def through_lines(lines: int) -> tuple[float, float]:
    """Return P and its standard error from scrambled points."""
    (found,) = home_run.scrambled(*PROBLEM, [E], lines, SEED, workers=-1)
    return found.p, found.standard_error


def integrated(tolerance: float) -> tuple[float, float]:
    """Return P and its error by quadrature."""
    (found,) = home_run.integrals(*PROBLEM, [E], tolerance=tolerance, workers=-1)
    return found.p, found.error


def timed(compute: Callable[[Any], Iterable[Any]], cost: object) -> tuple[Any, ...]:
    """Return the time of a computation, s, and its value."""
    start = time.perf_counter()
    found = compute(cost)
    return time.perf_counter() - start, *found
