"""No bat missed, none invented: pitches decided by the engine and by high precision.

The margin is positive where ball and bat touch. The engine decides its sign beyond the limit that
`contact.margin_error` states, and says that it cannot below. Here 10,000 pitches drawn from the
paper's distributions and 2,000 grazing ones are decided a second time by `tests.precise`, which
takes a pitch as one Taylor series of 20 digits, in numbers that carry their roundings: margins are
known to 1e-20 m, while the smallest asked for is 2e-14 m, and the engine's limit near 1e-14 m.
"""

import json
import math

import numpy as np
import pytest
from flint import arb

from longball.engines import contact, create
from longball.engines.chain import approach_of, solve
from longball.engines.contact import BatSection
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.model.frame import Frame
from longball.model.law import PlaneState, law_of, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import Air, AtBatScene, Pitch, Swing, parse_scene
from tests import precise

ENGINE = Ivp()
DIGITS = 20

CHUNKS = 8  # for pytest-xdist to share, and one of them for `make test`
PITCHES, GRAZES = 1_200 // CHUNKS, 800 // CHUNKS
chunks = pytest.mark.parametrize(
    "chunk", [0, *(pytest.param(i, marks=pytest.mark.nightly) for i in range(1, CHUNKS))]
)


def pitch_of_the_paper(rng):
    """Speed and aim drawn from the paper's distributions."""
    mean, spread = (139.1, 4.58) if rng.random() < 0.45 else (127.8, 7.8)
    cell = rng.normal(2 if rng.random() < 0.52 else 4, 0.77)
    return Pitch(speed=rng.normal(mean, spread) / 3.6, aim=((cell - 3) * 0.144, 1.8))


def at_bat(pitch, offset, **others):
    return AtBatScene(id="pitch", pitch=pitch, swing=Swing(height_offset=offset), **others)


def as_data(scene):
    return json.loads(scene.line())


def bat_of(approach):
    return BatSection(approach.pitch.frame, approach.bat.height, 0.0366 + 0.033)


def stated_error(approach, engine=ENGINE):
    """The bound on the margin's error that decides what the engine decides."""
    plate_height = approach.pitch.flight.state.z
    return contact.margin_error(bat_of(approach), plate_height, engine.flight_error, DOUBLES)


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


# ---- thousands of pitches ------------------------------------------------------------------------


@chunks
def test_pitches_of_the_paper(chunk):
    rng = np.random.default_rng([10_000, chunk])
    decided = 0
    for _ in range(PITCHES):
        scene = at_bat(pitch_of_the_paper(rng), rng.normal(0, 0.0366))
        with precise.in_digits(DIGITS):
            throw = precise.Throw(as_data(scene), DIGITS)
            if throw.plate[0][2] < 0:  # a slow ball comes down before the plate
                assert approach_of(scene, ENGINE) is None
                continue
            margin = throw.margin(scene.swing.height_offset)
            assert assert_decided_rightly(scene, margin) is not None
            decided += 1
    assert decided > 0.99 * PITCHES


@chunks
def test_grazing_pitches(chunk):
    """|margin| from 1e-3 down to 2e-14 m, touching and not, above the bat and below it."""
    rng = np.random.default_rng([2_000, chunk])
    for size in np.geomspace(1e-3, 2e-14, GRAZES):
        pitch = pitch_of_the_paper(rng)
        sign, side = rng.choice([-1, 1], 2).tolist()
        with precise.in_digits(DIGITS):
            throw = precise.Throw(as_data(at_bat(pitch, 0.0)), DIGITS)
            offset = throw.offset_for(sign * size, side)
            margin = throw.margin(offset)  # of the offset as a double
            assert abs(margin - arb(sign * size)) < 2e-17
            assert assert_decided_rightly(at_bat(pitch, offset), margin) is not None


@pytest.mark.parametrize("size", [5e-15, 1e-15, 1e-16, 1e-17])
@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.sampled(every=3)
def test_below_the_limit_it_cannot_be_decided(size, sign):
    rng = np.random.default_rng(17)
    for side in (-1, 1) * 5:
        pitch = pitch_of_the_paper(rng)
        with precise.in_digits(DIGITS):
            throw = precise.Throw(as_data(at_bat(pitch, 0.0)), DIGITS)
            offset = throw.offset_for(sign * size, side)
        scene = at_bat(pitch, offset)
        found = solve(scene, ENGINE)
        assert found.outcome is None
        assert "cannot be decided in double precision" in found.error
        approach = approach_of(scene, ENGINE)
        assert found.contact.margin == approach.touch.margin
        assert abs(found.contact.margin) < stated_error(approach)
        assert f"the value {found.contact.margin:.3g} lies within its error" in approach.touch.doubt
        assert found.impact is None


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
        with precise.in_digits(DIGITS):
            throw = precise.Throw(as_data(scene), DIGITS)
            pitch = approach_of(scene, engine).pitch
            state, (r, v) = pitch.flight.state, throw.plate
            for found, true in (
                (pitch.frame.position(state), r),
                (pitch.frame.velocity(state), v),
            ):
                off = precise.length([arb(a) - b for a, b in zip(found, true, strict=True)])
                # A place is as far from where it came from as 18 m.
                assert off < engine.flight_error * max(precise.length(true), arb(18))
            assert_decided_rightly(scene, throw.margin(scene.swing.height_offset), engine)


# ---- odd meetings --------------------------------------------------------------------------------


def scene_of(**values):
    return parse_scene(json.dumps({"id": "odd", "kind": "at-bat"} | values))


def test_the_plain_event_would_have_missed():
    """The distance itself shows no change of sign between the steps; hence the search."""
    approach = approach_of(scene_of(), ENGINE)
    bat, pieces = bat_of(approach), list(approach.pitch.flight.path.pieces())
    ends = [piece.at(t) for piece in pieces for t in (0.0, piece.length)]
    assert all(bat.distance(state, DOUBLES) > bat.reach for state in ends)
    assert approach.touch.touched


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
    with precise.in_digits(DIGITS):
        closest = precise.Throw(as_data(scene), DIGITS).margin(scene.swing.height_offset)
    margin, truth = (solve(scene, engine).contact.margin for engine in (ENGINE, Enclosure(20)))
    assert margin == pytest.approx(float(truth), abs=1e-11)
    assert float(closest) - margin == pytest.approx(1.4e-3, abs=1e-4)


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

STATE = PlaneState(18.3, 1.2, 31.0, -4.0)
BAT = BatSection(Frame(18.44, 0.0, -0.9999, -math.sqrt(1 - 0.9999**2)), 1.15, 0.0696)


def test_the_approach_is_half_the_rate_of_the_depth():
    """d/dt depth = 2 d·v: a central difference, whose error is of order h²."""
    law = law_with({"drag": 0.0075, "lift": 0.00375, "gravity": 9.8})
    _, _, du, dw = law.rates(DOUBLES)(*STATE)
    h = 1e-5

    def moved(time):
        return PlaneState(
            STATE.s + time * (STATE.u + time * du / 2),
            STATE.z + time * (STATE.w + time * dw / 2),
            STATE.u + time * du,
            STATE.w + time * dw,
        )

    slope = (BAT.depth(moved(h)) - BAT.depth(moved(-h))) / (2 * h)
    assert slope == pytest.approx(2 * BAT.approach(STATE), rel=1e-7)


def test_depth_is_zero_at_reach_and_keeps_its_digits_there():
    # The ball straight above the axis, a millionth of a millionth off.
    state = PlaneState(0.0, 1.15 + 0.0696 + 1e-12, 0.0, 0.0)
    bat = BatSection(Frame(0.0, 0.0, -1.0, 0.0), 1.15, 0.0696)
    gap = bat.distance(state, DOUBLES) - bat.reach
    assert bat.depth(state) == pytest.approx(2 * gap * 0.0696, rel=1e-3)


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


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_how_high_a_ball_touches_far_up_follows_from_its_place_across(side):
    """A double knows the height to 1e-10 m, and the place across to 1e-17."""
    reach, across, height = 0.07, 0.02, 1e6
    above = math.sqrt((reach - across) * (reach + across))
    bat = BatSection(Frame(1.0, 0.0, -1.0, 0.0), height, reach)
    state = PlaneState(1.0 - across, height + side * above, 1.0, -100.0)
    found = bat.offset(state, DOUBLES)
    assert found == pytest.approx((across, side * above), rel=1e-14)
