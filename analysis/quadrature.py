"""P(e) by three methods: what a smaller error costs in time."""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from analysis.writing import STYLES, figure, render
from longball import golden, home_run
from longball.engines.batch import Batch
from longball.home_run.randomised import SCRAMBLES
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

E = 0.42
SEED = 1
SAMPLES, FULL_SAMPLES = (10_000, 100_000, 1_000_000), (10_000, 100_000, 1_000_000, 10_000_000)
LINES, FULL_LINES = (64, 256, 1024), (64, 256, 1024, 4096)
TOLERANCES = (1e-3, 1e-7)
PROBLEM = AtBatScene(id="base"), home_run.paper_at_bats(SamplingReading())


def run(report: Path, full: bool) -> str:
    """Compute P(0.42) by each method at several costs, and the curve by quadrature."""
    # What is compiled and imported at the first call is not timed.
    integrated(TOLERANCES[0])
    through_lines(LINES[0])
    default, *_ = golden.probabilities().cases
    true = next(row.p for row in default.rows if row.e == E)
    samples, lines = (FULL_SAMPLES, FULL_LINES) if full else (SAMPLES, LINES)
    methods: dict[str, tuple[Callable[[Any], tuple[float, float]], dict[str, Any]]] = {
        "Monte Carlo": (counted, {f"{n:,} at-bats": n for n in samples}),
        "scrambled points": (through_lines, {f"{n * SCRAMBLES:,} lines": n for n in lines}),
        "quadrature": (integrated, {f"tolerance {x:.0e}": x for x in TOLERANCES}),
    }
    rows = []
    for method, (compute, costs) in methods.items():
        for of, cost in costs.items():
            took, (p, error) = _took(compute, cost)
            row = {"method": method, "of": of, "time": took, "p": p, "error": error}
            rows.append(row | {"off": abs(p - true)})
    with figure(report, "quadrature", size=(6.0, 3.8)) as (axes,):
        for name, of_method in pd.DataFrame(rows).groupby("method", sort=False):
            style = STYLES[str(name)]
            axes.plot(of_method["time"], of_method["error"], **style, label=str(name))
        axes.set(xscale="log", yscale="log", xlabel="time, s", ylabel=f"error of P({E})")
        axes.legend()
    integrals = partial(home_run.integrals, *PROBLEM, workers=-1)
    took, curve = _took(integrals, home_run.RESTITUTIONS)
    return render(
        report, "quadrature", globals(), engine=Batch().description, rows=rows, known=true,
        took=took, curve=curve,
        best=min(row["error"] for row in rows if row["method"] == "quadrature"),
    )  # fmt: skip


def counted(samples: int) -> tuple[float, float]:
    """Return P and its standard error from a sample."""
    (struck,) = home_run.monte_carlo(*PROBLEM, [E], samples, SEED, workers=-1)
    p = home_run.estimate(E, struck).p
    return p, float(np.sqrt(p * (1 - p) / samples))


def through_lines(lines: int) -> tuple[float, float]:
    """Return P and its standard error from scrambled points."""
    (found,) = home_run.scrambled(*PROBLEM, [E], lines, SEED, workers=-1)
    return found.p, found.standard_error


def integrated(tolerance: float) -> tuple[float, float]:
    """Return P and its error by quadrature."""
    (found,) = home_run.integrals(*PROBLEM, [E], tolerance=tolerance, workers=-1)
    return found.p, found.error


def _took(compute: Callable[[Any], Any], cost: object) -> tuple[float, Any]:
    start = time.perf_counter()
    found = compute(cost)
    return time.perf_counter() - start, found
