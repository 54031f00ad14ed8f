"""The side force k C_S U² ê: where it has no direction, in columns, and its derivatives."""

import json
import math
import re

import numpy as np
import pytest

from longball.engines.batch import Batch, solve_columns
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import Verlet
from longball.model.scene import FlightScene, InvalidScene, parse_scene

ENGINES = [Ivp(), Ivp("DOP853"), Batch(), Enclosure(20), Multiprecision(16)]
START = (0.5, 0.25, 1.0)
GOING = (30.0, 6.0, 18.0)
ASIDE = (0.25, 1.0, 0.5)


def flight(value=0.08, direction=ASIDE, velocity=GOING, **more):
    air = more.pop("air", {})
    side = {} if value is None else {"side_coefficient": {"value": value, "direction": direction}}
    launch = {"position": START, "velocity": velocity, **more.pop("launch", {})}
    return FlightScene(launch=launch, air={**air, **side}, **more)


def landing(scene, engine):
    result = solve(scene, engine)
    assert result.error is None
    assert result.outcome == "landed"
    found = result.landing
    return np.array([float(x) for x in (*found.position, *found.velocity, found.time)])


# --- where it has no direction --------------------------------------------------------------------


@pytest.mark.parametrize("engine", [*ENGINES, Verlet(1e-4)], ids=repr)
def test_a_ball_that_it_has_turned_to_its_direction_is_refused(engine):
    """After the angle between the two over k C_S U."""
    value, speed = 0.5, 40.0
    bend = 1.29 * math.pi * 0.0366**2 / (2 * 0.145) * value
    none = {"drag_coefficient": 0.0, "lift_coefficient": 0.0}
    scene = flight(value, (0.0, 1.0, 1.0), (0.0, speed, 0.0), air=none, gravity=0.0)
    result = solve(scene, engine)
    time = math.pi / 4 / (bend * speed)
    said = re.search(r"direction, as it is (\S+) s after the ball is set free", result.error)
    assert float(said[1]) == pytest.approx(time, abs=1e-3)
    assert result.code == "unsupported"
    before = parse_scene(json.dumps(json.loads(scene.as_written()) | {"time_limit": time - 2e-3}))
    assert solve(before, engine).outcome == "airborne"


@pytest.mark.parametrize("engine", ENGINES, ids=repr)
@pytest.mark.sampled(every=3)
def test_a_ball_that_passes_its_direction_is_refused(engine):
    """In the plane of its launch, at the apex: there the force would jump."""
    result = solve(flight(0.05, (1.0, 0.0, 0.0), (35.0, 0.0, 20.0)), engine)
    assert result.error.startswith("the side force has no direction where the airspeed is parallel")
    passed = flight(0.05, (1.0, 0.0, 0.0), (35.0, 0.0, 20.0), air={"wind": (0.0, 0.1, 0.0)})
    assert solve(passed, engine).outcome == "landed"


@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (0.0, 0.0, -3.0)])
def test_a_vertical_launch_has_no_vertical_side_force(direction):
    with pytest.raises(InvalidScene, match="is parallel to the velocity through the air at the"):
        flight(0.1, direction, (0.0, 0.0, 20.0))
    assert solve(flight(0.0, direction, (0.0, 0.0, 20.0)), Ivp()).outcome == "landed"


# --- columns, derivatives, at-bats ----------------------------------------------------------------


def test_columns_are_the_scenes_one_by_one():
    values = np.array([0.0, 0.05, -0.1])
    table = solve_columns(flight(), {"air.side_coefficient.value": values})
    for i, value in enumerate(values.tolist()):
        alone = landing(flight(value), Batch())
        assert [table[f"landing.position[{k}]"][i] for k in range(3)] == alone[:3].tolist()
    assert table["engine"][1] == Batch().description


def test_a_row_that_passes_its_direction_is_refused_alone():
    """The lanes leave it to the scalar engine, which says why it has no answer."""
    scene = flight(0.05, (1.0, 0.0, 0.0), (35.0, 1.0, 20.0))
    columns = {"launch.velocity[1]": [0.0, 1.0, 1e-3]}
    table = solve_columns(scene, columns)
    assert table["outcome"].tolist() == ["", "landed", "landed"]
    assert table["engine"].tolist()[1:] == [Batch().description, Ivp().description]
