"""freefall, in two dimensions: its points, up to the first below the ground."""

import math
from typing import Any

from freefall import falling_objects, simulators


def fly(state: Any, p: Any, _: str, step: float) -> Any:
    x, y, z, vx, vy, vz = state
    along = math.hypot(vx, vy)
    area = math.pi * p["ball.radius"] ** 2
    drag = 0.5 * p.get("air.density", 0.0) * p.get("air.drag_coefficient", 0.0) * area
    flown = simulators.simulate_earth_surface(
        falling_objects.FallingObject(p["ball.mass"], drag),
        0.0, z, along, vz, step, p["gravity"],
        lambda x, y, vx, vy, ax, ay, t: y[-1] < p["ground.height"],
    )  # fmt: skip
    c, s = vx / along, vy / along
    return [
        [t, x + c * r, y + s * r, up] for t, r, up in zip(flown.t, flown.x, flown.y, strict=True)
    ]
