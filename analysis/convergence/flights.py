"""The six treatments of the force on a flight, from the printed step down to rounding."""

import math
from dataclasses import replace

import numpy as np
import pandas as pd

from analysis.convergence.pieces import distance, each
from analysis.speed_error.work import launches
from analysis.writing import STYLES, Report
from longball.convergence import converge
from longball.convergence.report import Order
from longball.engines import create
from longball.engines.chain import solve
from longball.engines.engine import Engine
from longball.engines.verlet import TREATMENTS, Verlet

PRINTED = 0.05  # s, the paper's step
FINEST, FULL_FINEST = 5e-7, 5e-8  # s
PER_DECADE = 4
# Proves its digits: what is shown goes down to 1e-11 m and less.
PROVEN: Engine = create("enclosure", digits=20)

(ONE,) = launches(np.array([45.0]), math.radians(30.0)).scenes
# Two speeds at 25° and 45° each. The fit of the orders identifies results by their ids.
_LAUNCHES = launches(np.array([30.0, 30.0, 45.0, 45.0]), np.radians([25.0, 45.0] * 2))
FOUR = [one.model_copy(update={"id": str(i)}) for i, one in enumerate(_LAUNCHES.scenes)]


def run(report: Report, full: bool) -> str:
    """Find the orders, and the errors of one flight at the printed step."""
    finest = FULL_FINEST if full else FINEST
    calls = [(Verlet(forces=treatment), finest, 2) for treatment in TREATMENTS]
    orders = dict(zip(TREATMENTS, each(report, "orders", converged, calls), strict=True))
    with report.figure("convergence_flights", size=(6.4, 4.6)) as (axes,):
        for name, found in orders.items():
            # Two of the treatments coincide: one is seen round the other.
            size = 9 if name == "old_recomputed" else 5
            style, label = STYLES[f"verlet {name}"], f"{name}: order {found.order:.2f}"
            errors = pd.DataFrame(found.errors, columns=["step", "error", "use"])
            fitted = errors["use"] == "fitted"
            step, error, left = errors["step"], errors["error"], {"linestyle": "none", "alpha": 0.5}
            axes.plot(step[fitted], error[fitted], **style, markersize=size, label=label)
            hollow = style | left | {"markerfacecolor": "none"}
            axes.plot(step[~fitted], error[~fitted], **hollow, markersize=size)
        axes.set(xscale="log", yscale="log", xlabel="step Δt, s", ylabel="error of D, m")
        axes.legend(fontsize="small")
    below = Verlet(PRINTED, "implicit", "first_below")
    true = distance(ONE, PROVEN)
    return report.render(
        "flights", globals(), orders=orders, distance=true,
        off={name: distance(ONE, Verlet(PRINTED, name)) - true for name in TREATMENTS},
        below=distance(ONE, below) - distance(ONE, Verlet(PRINTED, "implicit")),
        jump=converged(below, 1e-4, phases=8),
    )  # fmt: skip


def converged(scheme: Verlet, finest: float, phases: int) -> Order:
    """Return the convergence of D by a scheme, from the printed step down to the finest one."""
    steps = np.geomspace(PRINTED, finest, 1 + round(PER_DECADE * math.log10(PRINTED / finest)))
    report = converge(
        lambda step: [solve(scene, replace(scheme, dt=step)) for scene in FOUR],
        FOUR, steps.tolist(), [solve(scene, PROVEN) for scene in FOUR], phases=phases,
    )  # fmt: skip
    return next(found for found in report.orders if found.quantity == "distance")
