"""Which branch of the law is valid in a state, on the switch itself and within its error.

Flights through switches are in `test_odd_scenes.py`.
"""

import json
import math

import pytest

from longball.engines import create
from longball.engines.chain import solve_with_path
from longball.engines.path_engine import arrived, branches_at
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES, Undecided
from longball.model.scene import parse_scene


def law_and_start(**keys):
    """Law and launch of a ball that loses its spin below a wind."""
    wind = {"velocity": (15.0, 0.0, 0.0), "above": 0.5}
    air = {"lift_coefficient": {"law": "linear"}, "spin_decay_length": 100.0, "wind": wind}
    launch = {"position": (0, 0, 2), "velocity": (20, 0, 20), "spin": (0, -100, 0)}
    scene = parse_scene(json.dumps({"kind": "flight", "launch": launch, "air": air} | keys))
    ball = scene.launch
    frame, start = launch_frame(ball.position, ball.velocity, DOUBLES, ball.spin)
    law = law_of(scene, frame, DOUBLES)
    return law, law.state_of(start)


def test_within_the_error_of_the_switch_the_spin_is_undecided():
    law, start = law_and_start(reading={"spin_decay": "nathan"})
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


def test_a_ball_that_stays_at_that_height_is_in_the_calm():
    launch = {"position": (0.0, 0.0, 1.0), "velocity": (30.0, 0.0, 0.0)}
    air = {"lift_coefficient": 0.0, "wind": {"velocity": (25.0, 0.0, 0.0), "above": 1.0}}
    line = {"kind": "flight", "launch": launch, "air": air, "gravity": 0.0, "time_limit": 2.0}
    scene = parse_scene(json.dumps(line))
    slow = 1.29 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    for name, error in (("ivp", 1e-9), ("batch", 1e-9), ("multiprecision", 1e-9), ("verlet", 1e-2)):
        engine = create(name, dt=1e-3, forces="implicit") if name == "verlet" else create(name)
        result, way = solve_with_path(scene, engine)
        assert result.outcome == "airborne"
        with engine.numbers.arithmetic():
            position, _ = way.at(engine.numbers.exact(1.0))
        assert float(position[0]) == pytest.approx(math.log1p(slow * 30.0) / slow, rel=error)
    # The enclosure knows the height to within its error only.
    assert solve_with_path(scene, create("enclosure"))[0].code == "undecided"
