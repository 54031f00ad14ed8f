"""No bat missed, none invented: steep pitches, odd meetings, and the margin of a miss.

The margin is positive where ball and bat touch. The engine decides its sign beyond the limit that
`event.margin_error` states, and says that it cannot below. Grazes from 1e-3 m to 1e-15 m are in
the golden data (`hard`); `test_stated_errors.py` asks what is decided just beyond the limit.
"""

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

from longball.engines import create, event
from longball.engines.chain import approach_of, solve
from longball.engines.enclosure import Enclosure
from longball.engines.event import BatSection
from longball.engines.ivp import Ivp
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import PolynomialPiece
from longball.model.numbers import DOUBLES
from longball.model.quantities import numbers
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


# Scenes of a bat and a ball so thin that doubles round to a part of them, and by how much a number
# of the contact may be off: of its size, and of 1 at least.
MEETINGS = {
    # From there the square of a reach of 2e-8 m is below all roundings. A height of 1.8 m is known
    # to 2e-16 m, which is 1e-8 of the reach; some times over.
    "thin": (
        {
            "ball": {"radius": 1e-8},
            "bat": {"radius": 1e-8},
            "swing": {"height_offset": 1e-8},
        },
        2e-7,
    ),
    # Heights are rounded to a ten-millionth of the reach; the place across the bat is not.
    "thin, far above the release": (
        {
            "ball": {"mass": 2.75e-27, "radius": 9.17e-6, "restitution": 0.73},
            "bat": {"mass": 2.2e8, "length": 17787.4, "radius": 1.5e-5},
            "reading": {"lift_direction": "always_up"},
            "air": {"density": 7.25e-29, "drag_coefficient": 5.5e-11, "lift_coefficient": -1947},
            "gravity": 1.09e22,
            "pitch": {"speed": 5.0e13, "release": [0.003, -1.56, 0.2545], "aim": [-0.078, 4.1e9]},
            "swing": {"angular_speed": -16.65, "tilt": 1.75, "height_offset": 0.03887},
        },
        1e-13,
    ),
}


@pytest.mark.parametrize("meeting", MEETINGS)
def test_thin_bats_are_met_as_is_proven(meeting):
    scene, error = MEETINGS[meeting]
    true = solve(scene_of(**scene), Enclosure(20))
    truths = {name: float(x) for name, x in numbers(true) if name.startswith("contact.")}
    for name in ("ivp", "batch"):
        found = solve(scene_of(**scene), create(name))
        assert found.outcome == true.outcome
        known = {key: x for key, x in numbers(found) if key.startswith("contact.")}
        assert known.keys() == truths.keys()
        for key, truth in truths.items():
            assert abs(known[key] - truth) <= error * max(1.0, abs(truth)), (name, key)


@dataclass(frozen=True)
class Cut(Ivp):
    """Flies in a straight line, in pieces that end at some times; looks for the bat on those."""

    ends: tuple[float, ...] = ()

    def steps(self, law, start, begin, limit, events):
        state = np.array(start)
        for end in (*self.ends, limit):
            slopes = [*state[2:], 0.0, 0.0]
            piece = PolynomialPiece(begin, end - begin, law.state, np.column_stack([state, slopes]))
            yield piece
            begin, state = end, np.array(piece.at(end - begin))

    def search_pieces(self, *given):
        return PathEngine.search_pieces(self, *given)


@pytest.mark.parametrize("ends", [(), (0.5,), (0.25, 0.5, 0.75), (0.498,), (0.5, 0.502)])
@pytest.mark.parametrize(("offset", "touched"), [(0.03, True), (-0.03, True), (0.08, False)])
def test_a_bat_is_met_wherever_the_pieces_of_a_pitch_join(ends, offset, touched):
    """The pitch is nearest to the bat after 0.5 s, over the plate, and touches it before."""
    pitch = Pitch(release=(16.0, 0.0, 1.75), aim=(0.0, 1.75), speed=32.0)
    swing = Swing(height_offset=offset)
    scene = AtBatScene(id="cut", air=None, gravity=0.0, pitch=pitch, swing=swing)
    approach = approach_of(scene, Cut(ends=ends))
    assert approach is not None
    touch = approach.touch
    assert touch.touched is touched
    assert touch.margin == pytest.approx(0.0696 - abs(offset), abs=1e-15)
    if touched:
        before = math.sqrt(0.0696**2 - offset**2) / 32
        assert touch.time == pytest.approx(0.5 - before, rel=1e-13)


def test_the_margin_of_a_central_hit_has_no_error_of_the_distance_flown():
    """Without an offset a ball meets the bat's axis: the margin is R + r_b (ulp of x: 3.6e-15)."""
    rng, errors = np.random.default_rng(6), []
    for _ in range(60):
        scene = scene_of(
            pitch={
                "speed": float(rng.uniform(35, 45)),
                "aim": [float(rng.uniform(-0.2, 0.2)), float(rng.uniform(1.6, 2.4))],
                "spin": [10.0, -200.0, float(rng.uniform(-200, 200))],
            },
            swing={"height_offset": 0.0},
            air={"lift_coefficient": {"law": "rational"}},
        )
        if (approach := approach_of(scene, ENGINE)) is not None:
            reach = scene.ball.radius + scene.bat.radius
            errors.append(abs(approach.touch.margin - reach))
    assert len(errors) > 40
    assert np.median(errors) < 4e-16
