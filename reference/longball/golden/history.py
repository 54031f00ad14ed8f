"""Time histories of flights: tables to plot an implementation against."""

from __future__ import annotations

from decimal import Decimal, localcontext

from longball.engines.enclosure import Enclosure
from longball.engines.engine import Stops
from longball.model.motion import forces, into_plane
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
        x, y, z = (numbers.exact(value) for value in scene.launch.position)
        vx, vy, vz = (numbers.exact(value) for value in scene.launch.velocity)
        plane, state = into_plane((x, y, z), (vx, vy, vz), numbers)
        always_up = scene.reading.lift_direction == "always_up"
        field = forces(scene.ball, scene.air, scene.gravity, always_up, numbers)
        step = Stops(time_limit=numbers.exact(1.0) / PER_SECOND)
        row = 0
        while row <= until * PER_SECOND:
            components = (*plane.position(state), *plane.velocity(state))
            shown = [_shown(numbers.report(x)) for x in components]
            lines.append(",".join([f"{row / PER_SECOND:.2f}", *shown]))
            state = engine.fly(state, field, step).state
            row += 1
    return "\n".join(lines) + "\n"


def _shown(number: Bounded) -> str:
    with localcontext(prec=DIGITS):
        return str(+Decimal(number.value))
