"""Pymunk, in two dimensions: along the launch, and up; drag and lift by its velocity function."""

import math
from typing import Any

import pymunk

from analysis.wild.air import push_of_air


def fly(state: Any, p: Any, _: str, step: float) -> Any:
    x, y, z, vx, vy, vz = state
    along = math.hypot(vx, vy)
    push = push_of_air((0.0, 0.0, 0.0, 1.0, 0.0, 0.0), p)
    space = pymunk.Space()
    space.gravity = (0.0, -p["gravity"])
    ball = pymunk.Body(p["ball.mass"], 1.0)
    ball.position, ball.velocity = (0.0, z), (along, vz)

    def turn(body: Any, gravity: Any, damping: float, dt: float) -> None:
        body.force = [p["ball.mass"] * a for a in push(body.velocity.x, 0.0, body.velocity.y)[::2]]
        pymunk.Body.update_velocity(body, gravity, damping, dt)

    ball.velocity_func = turn
    space.add(ball)
    points = [[0.0, x, y, z]]
    c, s = (vx / along, vy / along) if along else (1.0, 0.0)
    while points[-1][3] >= p["ground.height"] and points[-1][0] < p["time_limit"]:
        space.step(step)
        r, up = ball.position
        points.append([len(points) * step, x + c * r, y + s * r, up])
    return points
