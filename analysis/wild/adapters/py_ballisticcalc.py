"""py-ballisticcalc: a table with one C_D, one density at every height."""

import math
from typing import Any

import py_ballisticcalc as pbc

FOOT, INCH, POUND = 0.3048, 0.0254, 0.45359237


class Even(pbc.Atmo):  # type: ignore[misc]
    ratio = 0.0

    def get_density_and_mach_for_altitude(self, altitude: float) -> tuple[float, float]:
        return self.ratio, 1116.0


def fly(state: Any, p: Any, method: str, multiplier: float) -> Any:
    x, y, z, vx, vy, vz = state
    along, speed = math.hypot(vx, vy), math.hypot(vx, vy, vz)
    c, s = vx / along * FOOT, vy / along * FOOT
    density = p["ball.mass"] / POUND / (2.0 * p["ball.radius"] / INCH) ** 2
    table = [{"Mach": m, "CD": p.get("air.drag_coefficient", 0.0)} for m in (0.0, 0.5, 1.0)]
    ammo = pbc.Ammo(pbc.DragModel(density, table), pbc.Velocity.MPS(speed))
    air, up = Even(), pbc.Angular.Radian(math.atan2(vz, along))
    air.ratio = p.get("air.density", 0.0) / 1.225
    shot = pbc.Shot(ammo=ammo, atmo=air, relative_angle=up)
    config = {"cGravityConstant": -p["gravity"] / FOOT, "cMinimumVelocity": 0.0}
    config |= {"cMaximumDrop": (p["ground.height"] - z) / FOOT, "cStepMultiplier": multiplier}
    flown = pbc.Calculator(config=config, engine=method).fire(
        shot, pbc.Distance.Meter(1e5), dense_output=True, raise_range_error=False
    )
    rows = [(d.time, d.position.x, d.position.y, *d.velocity) for d in flown.base_data]
    return [
        [t, x + c * r, y + s * r, z + FOOT * h, c * u, s * u, FOOT * w] for t, r, h, u, w, _ in rows
    ]
