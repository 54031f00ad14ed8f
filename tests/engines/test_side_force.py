"""The side force k C_S U² ê: what is refused of it, and in columns.

Flights that turn to its direction, or pass it, are golden cases (`flight-side`).
"""

import json

import numpy as np
import pytest

import longball as lb
from longball.engines.batch import Batch, solve_columns
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.model.scene import FlightScene, InvalidScene, parse_scene

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


@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (0.0, 0.0, -3.0)])
def test_a_vertical_launch_has_no_vertical_side_force(direction):
    with pytest.raises(InvalidScene, match="is parallel to the velocity through the air at the"):
        flight(0.1, direction, (0.0, 0.0, 20.0))
    assert solve(flight(0.0, direction, (0.0, 0.0, 20.0)), Ivp()).outcome == "landed"


@pytest.mark.parametrize(
    ("air", "more", "message"),
    [
        (
            {"value": 0.1, "direction": [0, 0, 0]},
            {},
            "air.side_coefficient.direction: [0.0, 0.0, 0.0] has no direction",
        ),
        (
            {"value": 0.1, "direction": [10, 0, -1]},
            {"pitch": {"velocity": [-40, 0, 4]}},
            "air.side_coefficient.direction = [10.0, 0.0, -1.0] is parallel to the velocity",
        ),
        (
            {"value": 0.1, "direction": [1, 0, 0]},
            {"pitch": {"velocity": [-40, 2, 4]}, "wind": [0, 2, 4]},
            "is parallel to the velocity through the air at the start",
        ),
        (
            {"value": 0.1, "direction": [0, 1, 0]},
            {"reading": {"lift_direction": "always_up"}},
            "cannot be combined with spin, wind, a table of the lift, or a side_coefficient",
        ),
    ],
)
def test_what_is_no_side_force_is_refused_in_a_sentence(air, more, message):
    wind = {key: more[key] for key in more if key == "wind"}
    rest = {key: more[key] for key in more if key != "wind"}
    scene = {"kind": "pitch", "air": {"side_coefficient": air} | wind} | rest
    with pytest.raises(InvalidScene) as refused:
        parse_scene(json.dumps(scene))
    assert message in str(refused.value)


# --- columns ----------------------------------------------------------------


def test_columns_are_the_scenes_one_by_one():
    values = np.array([0.0, 0.05, -0.1])
    table = solve_columns(flight(), {"air.side_coefficient.value": values})
    for i, value in enumerate(values.tolist()):
        alone = landing(flight(value), Batch())
        assert [table[f"landing.position[{k}]"][i] for k in range(3)] == alone[:3].tolist()
    assert table["engine"][1] == Batch().description
    told = lb.solve_many(
        {
            "kind": "pitch",
            "air.side_coefficient.value": values,
            "air.side_coefficient.direction": [0.0, 1.0, 0.0],
        },
        engine="batch",
    )
    assert told["outcome"].tolist() == ["crossed"] * 3
    assert np.sign(told["plate.position[1]"]).tolist() == [0.0, 1.0, -1.0]


def test_a_row_that_passes_its_direction_is_refused_alone():
    """The lanes leave it to the scalar engine, which says why it has no answer."""
    scene = flight(0.05, (1.0, 0.0, 0.0), (35.0, 1.0, 20.0))
    columns = {"launch.velocity[1]": [0.0, 1.0, 1e-3]}
    table = solve_columns(scene, columns)
    assert table["outcome"].tolist() == ["", "landed", "landed"]
    assert table["engine"].tolist()[1:] == [Batch().description, Ivp().description]
