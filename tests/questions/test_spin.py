"""The spin that a movement needs: the law there and back, and a measured day."""

from __future__ import annotations

import numpy as np
import pytest

import longball as lb
from longball.engines.path_engine import form_at
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES
from longball.pitches import EXAMPLE
from longball.pitches.models import MODELS
from longball.pitches.statcast import INCH, read_measured
from tests.calls import check_wrong_calls

LAWS = {
    "rational": {"law": "rational"},
    "linear": {"law": "linear", "slope": 0.9},
    "bilinear": {"law": "bilinear"},
    "table": {
        "law": "table", "of": "spin_parameter",
        "at": [0.0, 0.1, 0.3, 0.8], "values": [0.0, 0.11, 0.22, 0.4],
    },
    "downwards": {"law": "linear", "slope": -0.5},
}  # fmt: skip
VELOCITY = (-40.0, 1.5, -2.5)


def scene(law, spin, **air):
    known = {"lift_coefficient": law, "drag_coefficient": 0.35, "density": {"elevation": 300.0}}
    thrown = {"release": [16.0, 0.5, 1.8], "velocity": VELOCITY, "spin": spin}
    return lb.Pitch(air=known | air, pitch=thrown)


def acceleration(pitch):
    """Return the acceleration at the release by the scene's own law, m/s²."""
    spin = pitch.pitch.spin
    frame, start = launch_frame(pitch.pitch.release, pitch.pitch.velocity, DOUBLES, spin)
    law = law_of(pitch, frame, DOUBLES)
    state = law.state_of(start)
    rates = dict(
        zip(law.variables, form_at(law, state, DOUBLES).rates(DOUBLES)(*state), strict=True)
    )
    u, v, w = rates["u"], rates.get("v", 0.0), rates["w"]
    return [frame.cos * u - frame.sin * v, frame.sin * u + frame.cos * v, w]


SIDE = {"side_coefficient": {"value": 0.07, "direction": [1.0, -3.0, 2.0]}}  # no spin makes it


@pytest.mark.parametrize(
    "air",
    [{"density_scale_height": 8500.0}, {"wind": [-3.0, 2.0, 0.5]}, SIDE],
    ids=["calm", "windy", "side force"],
)
@pytest.mark.parametrize("law", LAWS)
def test_the_law_there_and_back_is_the_identity(law, air):
    through = np.array(VELOCITY) - air.get("wind", [0.0, 0.0, 0.0])
    ahead = through / np.linalg.norm(through)
    across = np.cross(ahead, [0.2, 0.5, 0.7])
    for rate, along in ((30.0, 0.0), (150.0, 40.0), (260.0, -120.0), (700.0, 9.0)):
        spin = rate * across / np.linalg.norm(across)
        whole = spin + along * ahead
        pitch = scene(LAWS[law], whole.tolist(), **air)
        found = lb.spin_from_movement(
            pitch, VELOCITY, acceleration(pitch), np.linalg.norm(whole), along, height=1.8
        )
        assert found.transverse == pytest.approx(spin, rel=1e-11, abs=1e-10)
        assert found.drag_coefficient == pytest.approx(0.35, rel=1e-12)
        assert found.active_share == pytest.approx(rate / np.linalg.norm(whole), rel=1e-11)
        # √(ω² - ω_T²) next to ω = ω_T keeps half of the digits.
        assert found.spin == pytest.approx(whole, abs=3e-4 if along == 0.0 else 1e-8)


def test_above_the_laws_maximum_there_is_no_spin():
    pitch = {"kind": "pitch", "air": {"lift_coefficient": LAWS["rational"], "density": 1.2}}
    asked = np.array([[0.0, 0.0, -5.0], [0.0, 0.0, 20.0]])  # m/s²
    with pytest.raises(ValueError, match=r"C_L = 1\.\d+ is above .* reaches, 0\.4801: no spin"):
        lb.spin_from_movement(pitch, VELOCITY, asked[1])
    both = lb.spin_from_movement(pitch, [VELOCITY, VELOCITY], asked)
    assert np.isnan(both.rate).tolist() == [False, True]
    assert [*both.reasons] == [1]
    flat = {"kind": "pitch", "air": {"lift_coefficient": LAWS["table"], "density": 1.2}}
    with pytest.raises(ValueError, match=r"is above .* reaches, 0\.4: no spin"):
        lb.spin_from_movement(flat, VELOCITY, asked[1])


def test_a_pitch_that_only_slows_down_and_falls_needs_no_spin():
    found = asked(velocity=[-40.0, 0.0, 0.0], push=[5.0, 0.0, -9.8], rate=99.0)
    assert found.transverse.tolist() == [0.0, 0.0, 0.0]
    assert (found.lift_coefficient, found.active_share) == (0.0, 0.0)


def test_a_share_above_one_is_flagged():
    pitch = {"kind": "pitch", "air": {"lift_coefficient": LAWS["linear"], "density": 1.2}}
    push = [5.0, 0.0, -5.0]
    shares = np.array([3.0, 1.1, 0.9, 0.3])
    rates = lb.spin_from_movement(pitch, VELOCITY, push).rate / shares
    found = lb.spin_from_movement(pitch, VELOCITY, push, rate=rates)
    assert found.above_one.tolist() == (shares > 1).tolist()
    assert found.active_share == pytest.approx(shares, rel=1e-12)
    assert np.isnan(found.spin).all(axis=1).tolist() == (shares > 1).tolist()


def asked(lift=LAWS["rational"], velocity=VELOCITY, push=(5.0, 0.0, -5.0), rate=None, **blocks):
    pitch = {"kind": "pitch", "air": {"lift_coefficient": lift}} | blocks
    return lb.spin_from_movement(pitch, velocity, push, rate=rate)


WRONG = r"""
# scenes
asked(air=None) -> there is none
asked(0.2) -> a constant does not depend on the spin
asked(air={"density": 0.0, "lift_coefficient": {"law": "linear"}}) -> density: is 0
asked(LAWS["table"] | {"of": "speed", "at": [0, 10, 20, 40]}) -> a table of speed does not depend
asked(LAWS["table"] | {"values": [0.1, 0.2, 0.3, 0.4]}) -> must begin with 0 at 0
asked(LAWS["linear"], reading={"spin_parameter": "total"}) -> depends on the whole spin
# numbers
asked(velocity=[0.0, 0.0, 0.0]) -> the ball must move through the air
asked(velocity=[-40.0, float("nan"), 0.0]) -> velocity = .*finite numbers is needed
asked(push=[5.0, 0.0]) -> acceleration = .*a vector \[x, y, z\]
asked(rate=0.0) -> rate = 0.0: spins must be positive
lb.launch(40.0, 0.5, gyrospin="fast") -> gyrospin: must be a number in rad/s
# movements
lb.spin_for(scene(LAWS["rational"], [0.0, 0.0, 0.0]), lb.Movement(0.0, 3.0))
    -> no spin moves a ball so far
lb.spin_for(lb.Pitch(), lb.Movement(0.0, 0.3)) -> a constant does not depend on the spin
lb.spin_for(lb.AtBat(), lb.Movement(0.0, 0.3)) -> must be 'pitch' here
"""


def test_what_cannot_be_asked_for_a_spin_says_so():
    check_wrong_calls(WRONG, globals())


def of_the_day():
    """Return the day's pitches, and what of their spin their movement needs, in the middle."""
    pitches = read_measured(EXAMPLE, "pitch")
    release, speed = pitches.release[:, 0], pitches.velocity[:, 0]
    push = pitches.acceleration[:, 0]
    half = 0.5 * (-speed - np.sqrt(speed**2 - 2 * push * release)) / push
    middle = pitches.velocity + pitches.acceleration * half[:, None]
    weather = pitches.temperature.mean().item(), pitches.elevation.mean().item()
    blocks = MODELS["nathan"].blocks(*weather)
    found = lb.spin_from_movement(
        {"kind": "pitch"} | blocks, middle, pitches.acceleration, rate=pitches.spin_rate
    )
    return pitches, found, blocks


def test_the_active_share_of_the_day_is_that_of_another_study():
    """By type; that study of the same day shares no code with longball."""
    pitches, found, _ = of_the_day()
    known = {"SL": 0.17, "FC": 0.24, "ST": 0.55, "CU": 0.65, "FF": 0.79, "CH": 0.82, "SI": 0.85}
    for kind, share in known.items():
        # Each type is thrown by some dozens of pitchers; weather and law are off by some per cent.
        typical = np.nanmedian(found.active_share[pitches.labels == kind])
        assert typical == pytest.approx(share, abs=0.06)
    assert len(found.reasons) < 0.01 * len(pitches)


def test_each_pitchs_own_coefficients_bring_it_to_within_an_inch():
    """Nine parameters -> C_D, C_L, spin axis -> a flight: 0.7 in at the plate, as their fit has."""
    pitches, found, blocks = of_the_day()
    off = []
    for i in range(0, len(pitches), 25):
        axis = found.transverse[i]
        if i in found.reasons or not np.any(axis):
            continue
        air = blocks["air"] | {
            "drag_coefficient": found.drag_coefficient[i],
            "lift_coefficient": {"law": "constant", "value": found.lift_coefficient[i]},
        }
        thrown = pitches.scene(i)["pitch"] | {"spin": axis}
        flown = lb.solve({**blocks, "kind": "pitch", "air": air, "pitch": thrown})
        off.append(np.array(flown.plate.position[1:]) - pitches.measured[i])
    assert len(off) > 150
    assert np.sqrt(np.mean(np.sum(np.square(off), axis=1))) == pytest.approx(0.7 * INCH, rel=0.1)


@pytest.mark.parametrize("law", [name for name in LAWS if name != "downwards"])
@pytest.mark.parametrize("since", [None, 11.76])
def test_a_movement_gives_back_the_spin_that_makes_it(law, since):
    ahead = np.array(VELOCITY) / np.linalg.norm(VELOCITY)
    across = np.cross(ahead, [0.1, 0.4, 0.9])
    spin = (180.0 * across / np.linalg.norm(across)).tolist()
    moved = lb.movement(scene(LAWS[law], spin), since=since)
    found = lb.spin_for(scene(LAWS[law], [0.0, 0.0, 0.0]), moved, since)
    assert found.pitch.spin == pytest.approx(spin, abs=1e-7)


def test_the_spin_along_the_velocity_stays():
    gyro = (50.0 * np.array(VELOCITY) / np.linalg.norm(VELOCITY)).tolist()
    found = lb.spin_for(scene(LAWS["rational"], gyro), lb.Movement(0.1, 0.3))
    moved = lb.movement(found)
    assert (moved.across, moved.up) == pytest.approx((0.1, 0.3), abs=1e-9)
    assert np.dot(found.pitch.spin, VELOCITY) == pytest.approx(np.dot(gyro, VELOCITY), rel=1e-12)


def test_gyrospin_is_about_the_velocity():
    launch = lb.launch(40.0, 0.5, 0.2, gyrospin=100.0)
    assert np.array(launch.spin) == pytest.approx(100.0 / 40.0 * np.array(launch.velocity))
