"""A quantity of a state goes by the branch of the law that is valid in that state.

Truth is the oracle's, which ends a step where the wind sets in and goes on with the other wind.
"""

import json
import math
from functools import cache

import numpy as np
import pytest

from longball.engines.batch import Batch
from longball.engines.chain import solve, solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.path_engine import arrived, branches_at
from longball.engines.verlet import Verlet
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES, Undecided
from longball.model.scene import parse_scene
from tests import oracle
from tests.test_oracle import PRESENT

# The oracle's steps are off by 1e-13 each, of which a flight takes some hundred. Verlet's scheme
# takes the step that passes a switch by the law before it: 1 ms times a jump of some 10 m/s².
ENGINES = [
    pytest.param(Ivp(), 1e-9, id="ivp"),
    pytest.param(Batch(), 1e-9, id="batch"),
    pytest.param(Multiprecision(10), 1e-9, id="multiprecision"),
    pytest.param(Enclosure(20), 1e-9, id="enclosure"),
    pytest.param(Verlet(1e-3, forces="implicit"), 1e-2, id="verlet"),
]
all_engines = pytest.mark.parametrize(("engine", "error"), ENGINES)


# Balls that come through the height where the wind sets in, end there, or start there.
AIR = {"lift_coefficient": {"law": "linear"}, "spin_decay_length": 100.0}
NATHAN = {"reading": {"spin_decay": "nathan"}}
BACK = {"position": (0.0, 0.0, 2.0), "velocity": (20.0, 0.0, 20.0), "spin": (0.0, -100.0, 0.0)}
CALM = {"lift_coefficient": 0.0}
TABLE = {"law": "table", "of": "speed", "at": (10, 20, 30, 45), "values": (0.9, 0.5, 0.3, 0.6)}


def flight(launch, air, above=0.5, wind=(15.0, 0.0, 0.0), floor=0.0, **keys):
    blown = air | {"wind": {"velocity": wind, "above": above}}
    return {"kind": "flight", "launch": launch, "air": blown, "ground": {"height": floor}} | keys


def thrown(height, *velocity):
    return {"position": (0.0, 0.0, height), "velocity": velocity}


SCENES = {
    # Nathan's spin, e^(-t U/L), has the airspeed of the wind that the ball came through.
    **PRESENT,
    "lands where the wind sets in": flight(BACK, AIR, floor=0.5, **NATHAN),
    "lands in the calm": flight(BACK, AIR, **NATHAN),
    # A lift with a kink of S is searched for where S jumps past it, with the spin on either side.
    "loses spin at once": flight(
        BACK | {"velocity": (25.0, 0.0, 10.0), "spin": (0.0, -150.0, 0.0)},
        AIR | {"lift_coefficient": {"law": "bilinear"}},
        above=4.0,
        **NATHAN,
    ),
    "rises slower than the air": flight(thrown(2.0, 0, 0, 3), CALM, 1.0, (0, 0, 5)),
    "starts into the wind": flight(thrown(1.0, 30, 0, 6), CALM, 1.0, (9, 3, 0)),
    "starts along its height": flight(thrown(1.0, 30, 0, 0), CALM, 1.0, (9, 3, 0)),
    "starts out of the wind": flight(thrown(1.0, 30, 0, -6), CALM, 1.0, (9, 3, 0)),
    "lands at z = 0, where it sets in": flight(thrown(1.0, 30, 0, 25), CALM, 0.0, (3, 0, 0)),
    "lands at 1 m, where it sets in": flight(thrown(2.0, 30, 0, 25), CALM, 1.0, (3, 0, 0), 1.0),
    # A ball straight up flies without lift, whatever the reading, and keeps the drag's table.
    "has a lift that is always up": {
        "kind": "flight",
        "launch": thrown(1.0, 0, 0, 40),
        "air": {"drag_coefficient": TABLE},
        "reading": {"lift_direction": "always_up"},
    },
    # Also where heights are uncertain by the rounding of another number of the launch.
    "rises from the ground": {
        "kind": "flight",
        "launch": {"position": (1.0, 0.0, 0.0), "velocity": (12.0, 9.5, 17.0)},
        "air": CALM | {"density_scale_height": 8500.0},
    },
}


def blocks(result):
    """Numbers of the contact and of the landing, by block and key."""
    for block in ("contact", "landing"):
        for key in ("time", "position", "velocity", "spin"):
            value = result.get(block, {}).get(key)
            if value is not None:
                yield f"{block}.{key}", np.array([float(x) for x in np.atleast_1d(value)])


@all_engines
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.sampled(every=3)
def test_a_quantity_goes_by_the_branch_of_its_state(engine, error, name):
    found = solve(parse_scene(json.dumps(SCENES[name])), engine)
    assert found.error is None
    told = dict(blocks({k: dict(b) for k, b in found if k in ("contact", "landing") and b}))
    for key, truth in blocks(true(name)):
        if key == "contact.time" and key not in told:
            continue
        assert told[key] == pytest.approx(truth, rel=error, abs=100 * error), key


@cache
def true(name):
    return oracle.solve(json.loads(json.dumps(SCENES[name]))).result


def law_and_start(**keys):
    scene = parse_scene(json.dumps(flight(BACK, AIR, **keys)))
    frame, start = launch_frame(BACK["position"], BACK["velocity"], DOUBLES, BACK["spin"])
    law = law_of(scene, frame, DOUBLES)
    return law, law.state_of(start)


def test_within_the_error_of_the_switch_the_spin_is_undecided():
    law, start = law_and_start(**NATHAN)
    near = start._replace(z=math.nextafter(0.5, 1.0), w=-1.0)
    with pytest.raises(Undecided, match="passes the height above which the wind blows"):
        arrived(law, near, DOUBLES, 1e-14)
    assert arrived(law, near, DOUBLES, 0.0).form == (1,)
    for w, entered, left in ((1.0, 1, 0), (0.0, 0, 0), (-1.0, 0, 1)):
        on = near._replace(z=0.5, w=w)
        assert branches_at(law, on, DOUBLES) == [entered]
        assert arrived(law, on, DOUBLES, 1e-14).form == (left,)


def test_a_spin_that_does_not_depend_on_the_wind_is_decided_anywhere():
    law, start = law_and_start()
    assert not law.switches_of_spin
    assert arrived(law, start._replace(z=0.5), DOUBLES, 1e-14).form == (0,)


def test_steps_that_push_the_ball_take_the_drag_of_its_speed():
    """Verlet's bat pushes for two steps: in the air as it is there, by a table, as by a number."""
    swung = {"kind": "at-bat", "swing": {"height_offset": -0.03}}
    # A table that is 0.4 wherever the ball is, and else is not.
    table = {"law": "table", "of": "speed", "at": (1.0, 2.0), "values": (9.0, 0.4)}
    found = [
        solve(parse_scene(json.dumps(swung | {"air": {"drag_coefficient": drag}})), Verlet(1e-4))
        for drag in (0.4, table)
    ]
    number, tabled = (result.landing for result in found)
    # Roundings: 0.4 is the end of a line.
    assert tabled.position == pytest.approx(number.position, abs=1e-9)


@all_engines
def test_a_ball_that_stays_at_that_height_is_in_the_calm(engine, error):
    launch = {"position": (0.0, 0.0, 1.0), "velocity": (30.0, 0.0, 0.0)}
    air = {"lift_coefficient": 0.0, "wind": {"velocity": (25.0, 0.0, 0.0), "above": 1.0}}
    scene = {"kind": "flight", "launch": launch, "air": air, "gravity": 0.0, "time_limit": 2.0}
    result, way = solve_with_path(parse_scene(json.dumps(scene)), engine)
    if isinstance(engine, Enclosure):  # which knows the height to within its error only
        assert result.code == "undecided"
        return
    assert result.outcome == "airborne"
    with engine.numbers.arithmetic():
        position, _ = way.at(engine.numbers.exact(1.0))
    slow = 1.29 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    assert float(position[0]) == pytest.approx(math.log1p(slow * 30.0) / slow, rel=error)
