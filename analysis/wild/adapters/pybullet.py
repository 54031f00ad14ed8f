"""PyBullet: its damping, which is linear in the speed, is off; drag and lift are pushed in."""

from typing import Any

import pybullet

from analysis.wild.air import push_of_air


def fly(state: Any, p: Any, _: str, step: float) -> Any:
    if not pybullet.isConnected():
        pybullet.connect(pybullet.DIRECT)
    pybullet.resetSimulation()
    pybullet.setTimeStep(step)
    pybullet.setGravity(0.0, 0.0, -p["gravity"])
    ball = pybullet.createMultiBody(p["ball.mass"], basePosition=state[:3])
    pybullet.changeDynamics(ball, -1, linearDamping=0.0, angularDamping=0.0)
    pybullet.resetBaseVelocity(ball, state[3:])
    push = push_of_air(state, p)
    points = [[0.0, *state]]
    while points[-1][3] >= p["ground.height"] and points[-1][0] < p["time_limit"]:
        place, velocity = points[-1][1:4], points[-1][4:]
        force = [p["ball.mass"] * a for a in push(*velocity)]
        pybullet.applyExternalForce(ball, -1, force, place, pybullet.WORLD_FRAME)
        pybullet.stepSimulation()
        place, velocity = (
            pybullet.getBasePositionAndOrientation(ball)[0],
            pybullet.getBaseVelocity(ball)[0],
        )
        points.append([len(points) * step, *place, *velocity])
    return points
