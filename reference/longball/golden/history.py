"""Time histories of flights: tables to plot an implementation against."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

from longball.engines.chain import solve_with_path
from longball.engines.enclosure import Enclosure
from longball.model.result import Bounded
from longball.model.scene import FlightScene

COLUMNS = ("time_s", "x_m", "y_m", "z_m", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s")
DIGITS = 20
PER_SECOND = 20  # rows; the paper's Δt = 0.05 s

ABOUT = (
    "Position and velocity of the case's ball every 0.05 s from launch up to the last full step "
    f"before landing. {DIGITS} digits; the last one may be off by one."
)


def history(scene: FlightScene, until: float) -> str:
    """Return the table of a flight, as CSV, for times up to `until`, s."""
    engine = Enclosure(DIGITS + 10)
    numbers = engine.numbers
    lines = [",".join(COLUMNS)]
    with numbers.arithmetic():
        _, way = solve_with_path(scene, engine)
        rows = range(math.floor(until * PER_SECOND) + 1)
        times = [numbers.exact(row) / PER_SECOND for row in rows]
        for row, state in zip(rows, way.sample(times), strict=True):
            shown = [_shown(numbers.report(x)) for x in state]
            lines.append(",".join([f"{row / PER_SECOND:.2f}", *shown]))
    return "\n".join(lines) + "\n"


def _shown(number: Bounded) -> str:
    with localcontext(prec=DIGITS):
        return str(+Decimal(number.value))
