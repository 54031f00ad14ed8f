"""MuJoCo: its own drag of an ellipsoid; lift, which it has for spinning bodies, by a callback."""

from typing import Any

import mujoco

from analysis.wild.air import push_of_air

BALL = """<mujoco><option timestep="{}" integrator="{}" gravity="0 0 {}" density="{}"/><worldbody>
<body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
<joint type="slide" axis="0 0 1"/><geom size="{}" mass="{}" fluidshape="ellipsoid"
fluidcoef="{} 0 0 0 0"/></body></worldbody></mujoco>"""


def fly(state: Any, p: Any, method: str, step: float) -> Any:
    density, radius, mass = p.get("air.density", 0.0), p["ball.radius"], p["ball.mass"]
    drag = p.get("air.drag_coefficient", 0.0) / 2.0  # MuJoCo's force is ρ c A V², without the half
    mujoco.set_mjcb_passive(None)
    model = mujoco.MjModel.from_xml_string(
        BALL.format(step, method, -p["gravity"], density, radius, mass, drag)
    )
    data = mujoco.MjData(model)
    data.qpos, data.qvel = state[:3], state[3:]
    lift = push_of_air(state, {**p, "air.drag_coefficient": 0.0})

    def lifted(_: Any, now: Any) -> None:
        now.qfrc_passive[:] += [mass * a for a in lift(*now.qvel)]

    mujoco.set_mjcb_passive(lifted)
    points = [[0.0, *state]]
    while points[-1][3] >= p["ground.height"] and data.time < p["time_limit"]:
        mujoco.mj_step(model, data)
        points.append([data.time, *data.qpos, *data.qvel])
    return points
