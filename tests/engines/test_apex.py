"""The highest point of a batted ball, by closed forms.

The oracle knows it too, beside fences and under all forces, and the angle of a pitch at the plate.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from longball import engines
from longball.engines.chain import solve, solve_with_path
from longball.model.scene import Scene, parse_scene

ENGINES = {
    "ivp": {},
    "batch": {},
    "enclosure": {"digits": 20},
    "multiprecision": {"digits": 20},
    "verlet": {"dt": 2.0**-10},
}
# Of Verlet in a vacuum: an apex between two steps is off by g dt²/8 = 1.2e-6 m at most.
OFF = {"verlet": 2e-6}


def scene(**blocks: object) -> Scene:
    flying = {"kind": "flight", "air": None, "gravity": 9.8}
    return parse_scene(json.dumps(flying | blocks))


def launch(position: list[float], velocity: list[float]) -> dict[str, object]:
    return {"position": position, "velocity": velocity}


@pytest.mark.parametrize("name", ENGINES)
def test_without_air_it_is_galileos(name: str) -> None:
    found = solve(
        scene(launch=launch([1, 2, 0.5], [12, 9, 20])), engines.create(name, **ENGINES[name])
    )
    off = OFF.get(name, 1e-13)
    time, height = 20 / 9.8, 0.5 + 20**2 / (2 * 9.8)
    assert float(found.apex.time) == pytest.approx(time, abs=off)
    at = [1 + 12 * time, 2 + 9 * time, height]
    assert [*map(float, found.apex.position)] == pytest.approx(at, abs=15 * off)
    down = math.sqrt(20**2 + 2 * 9.8 * 0.5)
    assert float(found.landing.angle) == pytest.approx(math.atan(down / 15), abs=off)


def test_a_ball_that_does_not_get_up_there_is_airborne() -> None:
    low = scene(launch=launch([0, 0, 0], [30, 0, 12]), ground={"height": 8}, time_limit=5)
    found = solve(low, engines.create("ivp"))
    assert (found.outcome, found.apex, found.landing) == ("airborne", None, None)


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure"])
def test_a_ball_straight_up_rests_there(name: str) -> None:
    # z' = √(g/k) tan(arctan(√(k/g) w0) - √(g k) t), with drag k z'² that is on; no lift.
    air = {"density": 1.2, "drag_coefficient": 0.4, "lift_coefficient": 0.0}
    up = scene(launch=launch([0, 0, 1], [0, 0, 30]), air=air)
    found = solve(up, engines.create(name))
    k = 1.2 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    time = math.atan(30 * math.sqrt(k / 9.8)) / math.sqrt(9.8 * k)
    assert float(found.apex.time) == pytest.approx(time, rel=1e-13)
    height = 1 + math.log1p(k * 30**2 / 9.8) / (2 * k)
    assert float(found.apex.position[2]) == pytest.approx(height, rel=1e-13)


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure"])
def test_a_ball_that_its_lift_turns_upright_has_one(name: str) -> None:
    """Always up, lift ends where a ball comes to rise straight up: its last way is Galileo's."""
    air = {"density": 1.2, "drag_coefficient": 0.4, "lift_coefficient": 0.2}
    up = scene(
        launch=launch([0, 0, 1], [7.5, -2, 58]), air=air, reading={"lift_direction": "always_up"}
    )
    found = solve(up, engines.create(name))
    x, y, z = found.apex.position
    assert [float(x), float(y)] == pytest.approx([*map(float, found.landing.position[:2])])
    # From its top the ball falls as one that is dropped.
    k = 1.2 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    falling = float(found.landing.time) - float(found.apex.time)
    dropped = math.log(math.cosh(falling * math.sqrt(k * 9.8))) / k
    assert float(z) == pytest.approx(dropped, rel=1e-12)


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure"])
@pytest.mark.parametrize("velocity", [[40, 0, -5], [25, 0, -12]])
def test_of_several_tops_it_is_the_highest(name: str, velocity: list[float]) -> None:
    """Launched downwards at 15 m, one ball loops up to 60 m and then to 8 m, one to 17 m."""
    looping = scene(
        launch=launch([0, 0, 15], velocity) | {"spin": [0, -100, 0]},
        air={"density": 1.2, "drag_coefficient": 0.3, "lift_coefficient": 1.5},
        time_limit=20,
    )
    result, path = solve_with_path(looping, engines.create("ivp"))
    times = np.linspace(0.0, float(result.landing.time), 1000)
    highest = max(float(path.at(time)[0][2]) for time in times.tolist())
    found = solve(looping, engines.create(name))
    # Between samples the ball rises by |z''| dt²/8, under ten times the gravity at most.
    between = 98 * times[1] ** 2 / 8
    assert highest <= float(found.apex.position[2]) <= highest + between
