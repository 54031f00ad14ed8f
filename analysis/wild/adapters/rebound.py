"""REBOUND: one particle; gravity, drag and lift are its additional forces."""

from typing import Any

import rebound

from analysis.wild.air import push_of_air


def fly(state: Any, p: Any, method: str, step: float) -> Any:
    push = push_of_air(state, p)
    sim = rebound.Simulation()
    sim.integrator, sim.dt, sim.gravity = method, step, "none"
    sim.add(m=0.0, **dict(zip(("x", "y", "z", "vx", "vy", "vz"), state, strict=True)))
    ball = sim.particles[0]

    def force(_: Any) -> None:
        ball.ax, ball.ay, ball.az = push(ball.vx, ball.vy, ball.vz)
        ball.az -= p["gravity"]

    sim.additional_forces, sim.force_is_velocity_dependent = force, 1
    points = [[0.0, *state]]
    while points[-1][3] >= p["ground.height"] and points[-1][0] < p["time_limit"]:
        sim.integrate(len(points) * step)
        points.append([sim.t, ball.x, ball.y, ball.z, ball.vx, ball.vy, ball.vz])
    return points
