"""ballistics-engine: a table with one C_D; density by its atmosphere, g as it is built in."""

import math
from typing import Any

import ballistics_engine as be

INCH, GRAIN, YARD = 0.0254, 6.479891e-5, 0.9144


def fly(state: Any, p: Any, method: str, step: float) -> Any:
    x, y, z, vx, vy, vz = state
    along, ground = math.hypot(vx, vy), p["ground.height"]
    fields = {"bc": 0.5, "sight_height_inches": 0.0, "zero_distance_yards": 0.0}
    fields["bullet_weight_grains"] = p["ball.mass"] / GRAIN
    fields["bullet_diameter_inches"] = 2.0 * p["ball.radius"] / INCH
    fields["muzzle_velocity_fps"] = math.hypot(vx, vy, vz) / 0.3048
    fields["muzzle_angle"] = math.degrees(math.atan2(vz, along))
    fields |= {"muzzle_height_inches": (z - ground) / INCH, "ground_threshold": 0.0}
    table = [[mach, p["air.drag_coefficient"]] for mach in (0.0, 5.0)]
    chosen = {"use_rk4": method != "euler", "use_adaptive_rk45": method == "rk45"}
    inputs = be.BallisticInputs.from_dict(fields | chosen | {"custom_drag_table": table})
    pressure = 1000.0  # hPa
    for _ in range(5):  # the density is all but proportional to it
        pressure *= p["air.density"] / be.calculate_air_density_cipm(15.0, pressure, 0.0)
    air = be.AtmosphericConditions(59.0, pressure / 33.86389, 0.0, 0.0)
    solver = be.TrajectorySolver(inputs, atmosphere=air)
    solver.set_time_step(step)
    solver.set_max_range(1000.0)
    c, s, points = YARD * vx / along, YARD * vy / along, solver.solve().points
    return [[d.time, x + c * d.x, y + s * d.x, ground + YARD * d.y] for d in points]
