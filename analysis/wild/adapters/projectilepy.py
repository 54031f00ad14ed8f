"""ProjectilePy, in two dimensions: its landing, and a table of densities that are all the same."""

import math
from typing import Any

import projectilepy


def fly(state: Any, p: Any, _: str, step: float) -> Any:
    x, y, z, vx, vy, vz = state
    along = math.hypot(vx, vy)
    flight = projectilepy.model(
        math.hypot(vx, vy, vz),
        math.degrees(math.atan2(vz, along)),
        time_step=step,
        gravity=p["gravity"],
        drag="Newtonian",
        mass=p["ball.mass"],
        drag_coefficient=p.get("air.drag_coefficient", 0.0),
        cross_sectional_area=math.pi * p["ball.radius"] ** 2,
    )
    heights = range(-1000, 1000, 50)
    flight.default_earth_atmospheric_density = dict.fromkeys(heights, p.get("air.density", 0.0))
    flight.run(stop_height=p["ground.height"] - z)
    reach, (c, s) = flight.final_position()[0], (vx / along, vy / along)
    place = [x + c * reach, y + s * reach, z + flight.final_position()[1]]
    return {"time": flight.time_of_flight(), "position": place, "distance": math.hypot(*place[:2])}
