"""Flights by Runge-Kutta: reads one JSON scene per line, writes one JSON result per line.

Usage: candidate.py [STEP], in s; 0.005 by default.
"""

import json
import math
import sys

# Defaults of the paper's model.
DEFAULTS = {
    "ball": {"mass": 0.145, "radius": 0.0366},
    "air": {"density": 1.29, "drag_coefficient": 0.4, "lift_coefficient": 0.2},
    "gravity": 9.8,
    "ground": {"height": 0.0},
    "time_limit": 60.0,
}


def with_defaults(scene):
    """Return a scene with all defaults."""
    whole = DEFAULTS | scene
    for name in ("ball", "air", "ground"):
        if whole[name] is not None:  # no air at all
            whole[name] = DEFAULTS[name] | whole[name]
    return whole


def rates(state, scene, heading):
    """Return velocity and acceleration; `heading` is the horizontal direction of the launch."""
    velocity, air, ball = state[3:], scene["air"], scene["ball"]
    if not air:
        return [*velocity, 0.0, 0.0, -scene["gravity"]]
    k = air["density"] * math.pi * ball["radius"] ** 2 / (2 * ball["mass"]) * math.hypot(*velocity)
    drag, lift = k * air["drag_coefficient"], k * air["lift_coefficient"]
    (c, s), (vx, vy, vz) = heading, velocity
    forward = c * vx + s * vy
    ax, ay = -drag * vx - lift * c * vz, -drag * vy - lift * s * vz
    return [*velocity, ax, ay, -drag * vz + lift * forward - scene["gravity"]]


def step(state, h, *law):
    """Take a step of length `h`, s."""
    stages = [rates(state, *law)]
    for part in (0.5, 0.5, 1.0):
        stages.append(rates([x + part * h * k for x, k in zip(state, stages[-1])], *law))
    k1, k2, k3, k4 = stages
    return [x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4)]


def is_solved(scene):
    """True for flights of the paper's model in the default reading."""
    if scene["kind"] != "flight" or scene.get("reading") or scene.keys() & {"earth", "fence"}:
        return False
    air, launch = scene["air"] or {}, scene["launch"]
    return (
        launch.keys() <= {"position", "velocity"}
        and air.keys() <= {"density", "drag_coefficient", "lift_coefficient"}
        and not any(isinstance(value, dict) for value in air.values())
    )


def solve(scene, h=5e-3):
    """Fly until the ball comes down to the ground."""
    scene = with_defaults(scene)
    if not is_solved(scene):
        error = "only flights of the paper's model in the default reading are solved"
        return {"id": scene["id"], "error": error}
    state, time = [*scene["launch"]["position"], *scene["launch"]["velocity"]], 0.0
    along = math.hypot(*state[3:5])
    law = scene, (state[3] / along, state[4] / along) if along else (1.0, 0.0)
    ground = scene["ground"]["height"]
    while (after := step(state, h, *law))[2] > ground or after[5] > 0.0:
        state, time = after, time + h
        if time >= scene["time_limit"]:
            return {"id": scene["id"], "outcome": "airborne"}
    low, high = 0.0, h
    while high - low > 1e-15:
        middle = (low + high) / 2
        low, high = (middle, high) if step(state, middle, *law)[2] > ground else (low, middle)
    x, y, z, *velocity = step(state, high, *law)
    landing = {"time": time + high, "hang_time": time + high, "position": [x, y, z]}
    landing |= {"velocity": velocity, "distance": math.hypot(x, y)}
    return {"id": scene["id"], "outcome": "landed", "landing": landing}


if __name__ == "__main__":
    step_length = [float(word) for word in sys.argv[1:]]
    for line in sys.stdin:
        print(json.dumps(solve(json.loads(line), *step_length)), flush=True)
