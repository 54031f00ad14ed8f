"""Nine parameters, movement, the clock: exact without air, and against measured pitches."""

from __future__ import annotations

import math

import numpy as np
import pytest

import longball as lb
from longball.pitches import EXAMPLE
from longball.pitches.statcast import INCH, read_measured
from longball.questions.movement import PFX, TRACKED
from tests.calls import check_wrong_calls

THROWN = {"release": [16.5, 0.6, 1.8], "velocity": [-41.0, -1.2, 0.4]}
BACKSPIN = [0.0, 220.0, -70.0]
LIFT = {"lift_coefficient": {"law": "rational"}, "density": 1.2}


def test_without_air_the_nine_parameters_return_themselves():
    given = lb.NineParameters((TRACKED, 0.5, 1.7), (-40.0, -1.0, 0.3), (0.0, 0.0, -9.8))
    scene = lb.Pitch(air=None, gravity=9.8, pitch=given.pitch(release=16.8))
    back = lb.nine_parameters(lb.solve(scene))
    for name in ("position", "velocity", "acceleration"):
        # The acceleration is a second derivative over 0.4 s, in which roundings count.
        assert getattr(back, name) == pytest.approx(getattr(given, name), abs=1e-11)
    assert back.residual < 1e-14


@pytest.mark.parametrize("without", ["air", "lift"])
def test_without_air_nothing_moves(without):
    scene = lb.Pitch(air=None, pitch=THROWN)
    moved = lb.movement(scene, without)
    assert (moved.across, moved.up) == pytest.approx((0.0, 0.0), abs=1e-14)


def test_constant_drag_without_lift_induces_no_break():
    scene = lb.Pitch(air={"drag_coefficient": 0.35, "lift_coefficient": 0.0}, pitch=THROWN)
    assert lb.movement(scene, "lift") == lb.Movement(0.0, 0.0)
    assert lb.movement(scene, "air").up > 0.01  # drag lifts a ball that falls


def test_a_side_force_is_a_part_of_the_movement():
    """About k C_S U² t²/2, and all of it is gone without lift."""
    side = {"side_coefficient": {"value": 0.1, "direction": [0, 1, 0]}, "lift_coefficient": 0.0}
    pitch = lb.Pitch(pitch={"velocity": [-40, 0, 0]}, air=side)
    k = 1.29 * np.pi * 0.0366**2 / (2 * 0.145)
    for without in ("air", "lift"):
        found = lb.movement(pitch, without=without)
        assert found.across == pytest.approx(k * 0.1 * 18.44**2 / 2, rel=0.15)


def test_a_mirrored_pitch_moves_to_the_other_side():
    x, y, z = BACKSPIN
    one = lb.Pitch(air=LIFT, pitch=THROWN | {"spin": BACKSPIN})
    mirrored = {"release": [16.5, -0.6, 1.8], "velocity": [-41.0, 1.2, 0.4], "spin": [-x, y, -z]}
    other = lb.Pitch(air=LIFT, pitch=mirrored)
    for without in ("air", "lift"):
        a, b = lb.movement(one, without), lb.movement(other, without)
        assert (b.across, b.up) == pytest.approx((-a.across, a.up), rel=1e-12)
    first, second = (lb.nine_parameters(lb.solve(scene)) for scene in (one, other))
    flip = np.array([1, -1, 1])
    assert np.array(second.acceleration) == pytest.approx(flip * first.acceleration, rel=1e-9)


@pytest.mark.parametrize(("since", "slower"), [(PFX, 0.06), (0.5, 0.15)])
def test_pfx_of_a_fit_is_that_of_its_acceleration(since, slower):
    """Of constant acceleration it is a t²/2 from 40 ft on, as PITCHf/x had it."""
    scene = lb.Pitch(air=LIFT, pitch=THROWN | {"spin": BACKSPIN})
    moved = lb.movement(scene, "air", since=since)
    fitted = lb.nine_parameters(lb.solve(scene))
    start, end = fitted.at(since), fitted.at(0.0)
    time = (end.velocity[0] - start.velocity[0]) / fitted.acceleration[0]
    pfx = 0.5 * time**2 * np.add(fitted.acceleration[1:], [0.0, scene.gravity])
    # The last 12 m are slower than the mean of the way, and the last half metre more so.
    assert [moved.across, moved.up] == pytest.approx(pfx, rel=slower)


def test_a_fit_is_numpys_of_many_points():
    result = lb.solve(lb.Pitch(air=LIFT, pitch=THROWN | {"spin": BACKSPIN}))
    fitted = lb.nine_parameters(result)
    edges = np.linspace(0.0, result.plate.time, 4001)
    time = 0.5 * (edges[1:] + edges[:-1])
    path = result.path.at(time).position
    half, slope, start = np.polynomial.polynomial.polyfit(time, path, 2)[::-1]
    # The mean over midpoints is off by 1/(24 n²) of the second derivative: 1e-9.
    assert np.array(fitted.acceleration) == pytest.approx(2 * half, rel=1e-7)
    at = fitted.at(16.5)
    when = (at.velocity[0] - slope[0]) / (2 * half[0])
    # At 41 m/s a time that is off by as much of 0.4 s is 2e-8 m.
    assert np.array(at.position) == pytest.approx(start + (slope + half * when) * when, abs=1e-7)
    left = path - np.polynomial.polynomial.polyval(time, [start, slope, half]).T
    assert fitted.residual == pytest.approx(math.sqrt(np.mean(np.sum(left**2, axis=1))), rel=1e-5)


SLOW = lb.NineParameters((TRACKED, 0.0, 1.8), (-15.0, 0.0, 0.0), (9.0, 0.0, -9.8))
AWAY = lb.NineParameters((TRACKED, 0.0, 1.8), (15.0, 0.0, 0.0), (0.0, 0.0, -9.8))
WRONG = r"""
SLOW.at(0.0) -> never reaches x = 0.0 m .* it turns at x = 2.3
SLOW.pitch(16.5) -> never reaches x = 0\.0 m
AWAY.at(0.0) -> velocity\[0\] = 15.0 m/s
lb.nine_parameters(lb.solve(lb.Pitch(pitch={"speed": 10.0})))
    -> does not reach the plate: it is grounded
lb.movement({"kind": "at-bat"}) -> must be 'pitch' here, and is 'at-bat'
lb.movement(lb.Pitch(pitch=THROWN), since=17.0) -> released at x = 16\.5 m
"""


def test_what_never_reaches_the_plate_is_an_error():
    check_wrong_calls(WRONG, globals())


@pytest.mark.parametrize(
    ("across", "up", "said"),
    [(0, 1, "12:00"), (1, 0, "3:00"), (0, -1, "6:00"), (-1, 0, "9:00"), (1, 1, "1:30"),
     (-1e-9, 1, "12:00"), (0, 0, "")],
)  # fmt: skip
def test_the_clock(across, up, said):
    assert lb.clock(across, up) == said


def test_the_days_pitches_are_their_nine_parameters():
    """Statcast writes the fit's place at the plate to 0.01 ft, and so do its other numbers."""
    pitches = read_measured(EXAMPLE, "pitch", spin=False)
    off = []
    for i in range(0, len(pitches), 20):
        given = (pitches.release[i], pitches.velocity[i], pitches.acceleration[i])
        at_plate = lb.NineParameters(*(tuple(x) for x in given)).at(0.0)
        off.append(np.array(at_plate.position[1:]) - pitches.measured[i])
    assert math.sqrt(np.mean(np.sum(np.square(off), axis=1))) < 0.1 * INCH
