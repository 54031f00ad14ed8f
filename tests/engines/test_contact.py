"""No bat missed, none invented: steep pitches, odd meetings, and the margin of a miss.

The margin is positive where ball and bat touch. The engine decides its sign beyond the limit that
`event.margin_error` states, and says that it cannot below. Grazes from 1e-3 m to 1e-15 m are in
the golden data (`hard`); `test_stated_errors.py` asks what is decided just beyond the limit.
"""

import json
import math

import numpy as np
import pytest

from longball.engines import create, event
from longball.engines.chain import approach_of, solve
from longball.engines.enclosure import Enclosure
from longball.engines.event import BatSection
from longball.engines.ivp import Ivp
from longball.model.law import law_of
from longball.model.numbers import DOUBLES
from longball.model.scene import Air, AtBatScene, Pitch, Swing, parse_scene

ENGINE = Ivp()


def at_bat(pitch, offset, **others):
    return AtBatScene(id="pitch", pitch=pitch, swing=Swing(height_offset=offset), **others)


def bat_of(approach):
    return BatSection(approach.pitch.frame, approach.bat.height, 0.0366 + 0.033)


def stated_error(approach, engine=ENGINE):
    """The bound on the margin's error that decides what the engine decides."""
    plate_height = approach.pitch.flight.state.z
    return event.margin_error(bat_of(approach), plate_height, engine.flight_error, DOUBLES)


def assert_decided_rightly(scene, margin, engine=ENGINE):
    """Hold the engine's decision, and its margin, to a margin in high precision; return it."""
    approach = approach_of(scene, engine)
    limit = stated_error(approach, engine)
    touch = approach.touch
    assert abs(touch.margin - margin) <= limit, scene.line()
    if touch.touched is None:
        assert abs(margin) <= 2 * limit, scene.line()
    else:
        assert touch.touched == (margin > 0), scene.line()
        assert (touch.time is None) == (margin < 0)
    return touch.touched


# ---- pitches that no pitcher throws --------------------------------------------------------------


def steep_pitch(rng):
    """Lobs and drops, in thick air and in none: anything that crosses the plate."""
    speed = math.exp(rng.uniform(math.log(12), math.log(60)))
    elevation = rng.uniform(0.1, 1.2) if speed < 30 else rng.uniform(-0.05, 0.6)
    pitch = Pitch(speed=speed, aim=(rng.uniform(-0.4, 0.4), 1.8 + 18.44 * math.tan(elevation)))
    air = Air(drag_coefficient=rng.uniform(0, 0.8), lift_coefficient=rng.uniform(-0.3, 0.3))
    return pitch, air


@pytest.mark.parametrize(
    ("method", "tolerance"),
    [
        ("Taylor", None),
        ("DOP853", 5e-14),
        ("DOP853", 1e-9),
        ("RK45", 1e-9),
        ("RK23", 1e-6),
        ("LSODA", 1e-9),
        ("Radau", 1e-7),
        ("BDF", 1e-7),
    ],
)
@pytest.mark.sampled(every=3)
def test_steep_pitches_by_every_method(method, tolerance, nightly):
    """Both bounds hold where the pitch's own error is largest: on the state, on the margin."""
    engine = Ivp(method, tolerance, tolerance)
    rng = np.random.default_rng(42)
    crossed = 0
    while crossed < (40 if nightly else 10):
        pitch, air = steep_pitch(rng)
        scene = at_bat(pitch, rng.normal(0, 0.05), air=air)
        reference = approach_of(scene, ENGINE)
        # Near the ground the search ends where the ball does, before the closest approach.
        if reference is None or reference.bat.height < 0.3:
            continue
        crossed += 1
        truth = solve(scene, Enclosure(20))
        pitch = approach_of(scene, engine).pitch
        state, plate = pitch.flight.state, truth.plate
        for found, true in (
            (pitch.frame.position(state), [*map(float, plate.position)]),
            (pitch.frame.velocity(state), [*map(float, plate.velocity)]),
        ):
            # A place is as far from where it came from as 18 m.
            assert math.dist(found, true) < engine.flight_error * max(math.hypot(*true), 18)
        assert_decided_rightly(scene, float(truth.contact.margin), engine)


# ---- odd meetings --------------------------------------------------------------------------------


def scene_of(**values):
    return parse_scene(json.dumps({"id": "odd", "kind": "at-bat"} | values))


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_a_ball_released_next_to_the_bat_touches_almost_at_once(gap):
    pitch = {"release": [0.0696 + gap, 0, 1.8], "speed": 10.0}
    touch = approach_of(scene_of(pitch=pitch, gravity=0, air=None), ENGINE).touch
    assert touch.touched
    # In doubles a gap is known to the rounding of its two ends.
    assert touch.time == pytest.approx(gap / 10.0, abs=1e-17)


def test_a_ball_thrown_at_walking_pace_past_the_bat():
    """So slow that it falls as much as it flies while it passes: V² is less than 2 |d| |a|."""
    pitch = {"release": [0.5, 0, 1.8], "speed": 1.5, "aim": [0, 2.2]}
    for offset in (0.2, 0.1, 0.0, -0.1, -0.2):
        scene = scene_of(pitch=pitch, swing={"height_offset": offset})
        approach = approach_of(scene, ENGINE)
        frame, bat = approach.pitch.frame, bat_of(approach)
        law = law_of(scene, frame, DOUBLES)
        # By brute force, every millisecond.
        overlapping = []
        for time in np.arange(1e-3, 1, 1e-3).tolist():
            state = ENGINE.fly(law, approach.pitch.start, (), time).state
            if state.z < 0 or frame.towards_x(state) < -bat.reach:
                break
            if bat.distance(state, DOUBLES) < bat.reach:
                overlapping.append(time)
        assert approach.touch.touched == bool(overlapping)
        if overlapping:
            assert overlapping[0] - 1e-3 <= approach.touch.time <= overlapping[0]


def test_a_ball_that_falls_onto_the_bat_from_above():
    """It comes closer, touches, and never crosses behind the plate."""
    scene = scene_of(
        pitch={"release": [0.01, 0, 3.0], "speed": 0.02, "aim": [0, 3.0]},
        swing={"height_offset": -1.0},
        air=None,
    )
    approach = approach_of(scene, ENGINE)
    assert approach.touch.touched
    distance = bat_of(approach).distance(approach.touch.state, DOUBLES)
    # It falls in one step: d² is 5 m² at its beginning, and 2 d dd two ulps of that at its end.
    assert distance == pytest.approx(0.0696, abs=2 * math.ulp(5.0) / (2 * 0.0696))


def test_the_margin_of_a_miss_is_taken_until_the_ball_has_passed_the_bat():
    """A lob that falls past below the bat, and comes 1.4 mm closer behind it."""
    scene = at_bat(
        Pitch(speed=14.76, aim=(0.344, 24.2136)),
        -0.1642,
        air=Air(drag_coefficient=0.4033, lift_coefficient=0.158),
    )
    margin, truth = (solve(scene, engine).contact.margin for engine in (ENGINE, Enclosure(20)))
    assert margin == pytest.approx(float(truth), abs=1e-11)
    approach = approach_of(scene, ENGINE)
    bat, flight = bat_of(approach), approach.pitch.flight
    times = np.linspace(0, flight.time + 0.05, 5000).tolist()
    closest = min(bat.distance(flight.path.at(time), DOUBLES) for time in times)
    assert bat.reach - closest - margin == pytest.approx(1.4e-3, abs=1e-4)


def test_a_touching_long_before_the_plate_is_not_sought_backwards_through_thick_air():
    """A ball of 9 mg sinks for a fifth of a second from the bat to the plate's plane."""
    scene = parse_scene(
        json.dumps(
            {
                "id": "sinking",
                "kind": "at-bat",
                "ball": {"mass": 8.8e-06, "radius": 0.0167},
                "reading": {"lift_direction": "always_up"},
                "gravity": 105.3,
                "air": {"density": 3.73, "drag_coefficient": 1.117, "lift_coefficient": 0.792},
                "pitch": {"speed": 0.1145, "release": [0.361, -0.994, 3.9], "aim": [0.557, 0.324]},
                "bat": {"radius": 0.0132},
                "swing": {"height_offset": 0.0726},
            }
        )
    )
    result, truth = (solve(scene, engine) for engine in (ENGINE, Enclosure(20)))
    assert result.contact.margin == pytest.approx(float(truth.contact.margin), abs=1e-11)
    assert result.contact.time == pytest.approx(float(truth.contact.time), abs=1e-11)


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure", "multiprecision"])
def test_a_lob_that_is_as_close_before_the_bat_as_behind_it(name):
    """Above x = 0 it is highest: z = h - x², m, closest to the bat's axis at x² = h - 1/2."""
    scene = scene_of(
        air=None,
        gravity=8.0,
        ball={"radius": 0.125},
        bat={"radius": 0.25},
        pitch={"release": [2.0, 0.0, 2.0], "velocity": [-2.0, 0.0, 8.0]},
        swing={"height_offset": -0.625},
    )
    found = solve(scene, create(name))
    assert found.outcome == "missed"
    assert float(found.contact.margin) == pytest.approx(0.375 - math.sqrt(0.375), abs=1e-13)


def test_the_ground_may_end_the_search():
    """A bat in the ground is never reached."""
    touch = approach_of(scene_of(swing={"height_offset": -1.5}), ENGINE).touch
    assert touch.touched is False
    assert touch.margin < -0.1


# ---- the functions of the state ------------------------------------------------------------------


@pytest.mark.parametrize("offset", [1.0, 10.0, -1.2])
def test_the_margin_of_a_wide_miss_is_that_of_the_whole_pitch(offset):
    """The closest approach may lie steps before any in which the ball could have touched."""
    text = '{"id":"x","kind":"at-bat","swing":{"height_offset":%r}}'
    scene = parse_scene(text % offset)
    found, true = solve(scene, Ivp()), solve(scene, Enclosure(digits=20))
    assert found.outcome == true.outcome == "missed"
    # The state at the closest approach has a flight's error, relative to its distance from home.
    assert found.contact.margin == pytest.approx(float(true.contact.margin), abs=1e-11)


@pytest.mark.parametrize("name", ["ivp", "batch"])
def test_a_thin_bat_touched_far_above_the_release(name):
    """Heights are rounded to a ten-millionth of the reach; the place across the bat is not."""
    scene = parse_scene(
        json.dumps(
            {
                "id": "far",
                "kind": "at-bat",
                "ball": {"mass": 2.75e-27, "radius": 9.17e-6, "restitution": 0.73},
                "bat": {"mass": 2.2e8, "length": 17787.4, "radius": 1.5e-5},
                "reading": {"lift_direction": "always_up"},
                "air": {
                    "density": 7.25e-29,
                    "drag_coefficient": 5.5e-11,
                    "lift_coefficient": -1947,
                },
                "gravity": 1.09e22,
                "pitch": {
                    "speed": 5.0e13,
                    "release": [0.003, -1.56, 0.2545],
                    "aim": [-0.078, 4.1e9],
                },
                "swing": {"angular_speed": -16.65, "tilt": 1.75, "height_offset": 0.03887},
            }
        )
    )
    result, truth = solve(scene, create(name)), solve(scene, Enclosure(20))
    assert result.outcome == truth.outcome == "batted"
    height, normal = (float(truth.contact.position[2]), [float(n) for n in truth.contact.normal])
    assert result.contact.position[2] == pytest.approx(height, abs=4 * np.spacing(height))
    # What a move of the bat by a rounding of its height does to the normal, some times over.
    assert result.contact.normal == pytest.approx(normal, abs=1e-13)
    assert result.landing.distance == pytest.approx(float(truth.landing.distance), abs=1e-8)
