"""The law of the air, for simulators that have none of their own or another one."""

import math
from collections.abc import Callable, Mapping, Sequence

Vector = tuple[float, float, float]


def push_of_air(
    state: Sequence[float], p: Mapping[str, float]
) -> Callable[[float, float, float], Vector]:
    """Return the acceleration, m/s², by drag and lift at a velocity: docs/model.md.

    The axis of the lift is horizontal, across the launch, and stays as it is.
    """
    k = p.get("air.density", 0.0) * math.pi * p["ball.radius"] ** 2 / (2.0 * p["ball.mass"])
    drag = k * p.get("air.drag_coefficient", 0.0)
    lift = k * p.get("air.lift_coefficient", 0.0)
    along = math.hypot(state[3], state[4]) or 1.0
    a, b = state[4] / along, -state[3] / along

    def push(u: float, v: float, w: float) -> Vector:
        speed = math.sqrt(u * u + v * v + w * w)
        return (
            speed * (lift * b * w - drag * u),
            speed * (-lift * a * w - drag * v),
            speed * (lift * (a * v - b * u) - drag * w),
        )

    return push
