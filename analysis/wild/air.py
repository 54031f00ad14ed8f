"""The law of the air, for simulators that have none of their own or another one."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from analysis import Array


def push_of_air(
    state: Sequence[float], p: Mapping[str, float]
) -> Callable[[float, float, float], Array]:
    """Return the acceleration, m/s², by drag and lift at a velocity: docs/model.md.

    The axis of the lift is horizontal, across the launch, and stays as it is.
    """
    k = p.get("air.density", 0.0) * math.pi * p["ball.radius"] ** 2 / (2.0 * p["ball.mass"])
    drag, lift = (k * p.get(f"air.{name}_coefficient", 0.0) for name in ("drag", "lift"))
    axis = np.array([state[4], -state[3], 0.0]) / (math.hypot(state[3], state[4]) or 1.0)

    def push(u: float, v: float, w: float) -> Array:
        velocity = np.array([u, v, w])
        return math.hypot(u, v, w) * (lift * np.cross(axis, velocity) - drag * velocity)

    return push
