"""pitchphys: constant coefficients, its own plate; its y points to the plate."""

from typing import Any

import numpy as np
from pitchphys.aero.base import ConstantAeroModel
from pitchphys.core.ball import Baseball
from pitchphys.core.environment import Environment
from pitchphys.core.pitch import PitchRelease
from pitchphys.core.simulate import simulate

TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def fly(state: Any, p: Any, method: str, tolerance: float) -> Any:
    place, velocity = TURN @ state[:3], TURN @ state[3:]
    backspin = np.cross(velocity, (0.0, 0.0, 1.0))
    pitch = PitchRelease(
        speed_m_s=float(np.linalg.norm(velocity)),
        launch_angle_deg=float(np.degrees(np.arctan2(velocity[2], np.hypot(*velocity[:2])))),
        horizontal_angle_deg=float(np.degrees(np.arctan2(velocity[0], velocity[1]))),
        release_pos_m=place,
        spin_rate_rad_s=200.0,
        spin_axis=backspin / np.linalg.norm(backspin),
    )
    air = Environment(air_density_kg_m3=p.get("air.density", 0.0), gravity_m_s2=p["gravity"])
    ball = Baseball(mass_kg=p["ball.mass"], radius_m=p["ball.radius"])
    model = ConstantAeroModel(*(p.get(f"air.{x}_coefficient", 0.0) for x in ("drag", "lift")))
    options = {"method": method, "rtol": tolerance, "atol": tolerance / 100.0}
    flown = simulate(pitch, air, ball, model, plate_distance_m=0.0, **options)
    last = flown.position[-1] @ TURN, flown.velocity[-1] @ TURN
    return {"time": flown.flight_time_s, "position": last[0], "velocity": last[1]}
