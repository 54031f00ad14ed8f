"""Changes to scenes by names, and the units of their values."""

from __future__ import annotations

import json
import math

import pytest

from longball.api import Flight, launch
from longball.model.changes import Changes, value_of
from longball.model.scene import parse_scene
from tests.calls import check_wrong_calls

LAUNCH = {"position": [0, 0, 1], "velocity": [30, 0, 25]}


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("pitch.speed", "40", 40),
        ("pitch.speed", ".5", 0.5),
        ("pitch.speed", "100mph", 44.704),  # 1 mph is 0.44704 m/s
        ("pitch.release", "[60, 0, 6] ft", [18.288, 0.0, 1.8288]),
        ("pitch.release[2]", "6ft", 1.8288),
        ("launch.spin", "[0,-60,0]rpm", [0.0, -2 * math.pi, 0.0]),
        ("swing.tilt", "-5°", -math.pi / 36),
        ("air.density.temperature", "20°C", 293.15),
        ("air.wind", "[10, 0, 0] mph", [4.4704, 0.0, 0.0]),
        ("air.drag_coefficient.speed", "36 km/h", 10.0),  # of a law of several
        ("air", "null", None),
        ("bat.support", "free", "free"),
        ("air.drag_coefficient", '{"law": "spin"}', {"law": "spin"}),
    ],
)
def test_values_have_units(name: str, text: str, value: object):
    read = value_of(name, text)
    if isinstance(value, float | list):
        # Two roundings, of the factor and of the product, and one more of a zero.
        assert read == pytest.approx(value, rel=4e-16)
    else:
        assert read == value


@pytest.mark.parametrize(
    ("name", "text", "as_launched"),
    [
        ("launch.speed", "100mph", {"speed": 44.704}),
        ("launch.angle", "30deg", {"angle": math.pi / 6}),
        ("launch.direction", "-0.2", {"direction": -0.2}),
        ("launch.backspin", "300", {"backspin": 300.0}),
    ],
)
def test_what_trackers_give_of_a_launch_changes_alone(name: str, text: str, as_launched: dict):
    """As `launch` makes it from the same numbers, to the rounding of an angle there and back."""
    given = {"speed": 40.0, "angle": 0.4, "direction": 0.1}
    scene = Flight(launch=launch(**given))
    found = changed(json.loads(scene.line()), (name, value_of(name, text)))
    expected = launch(**given | as_launched)
    assert found.launch.velocity == pytest.approx(expected.velocity, rel=1e-14)
    assert found.launch.spin == (expected.spin and pytest.approx(expected.spin, rel=1e-14))
    assert found.launch.position == expected.position


def changed(scene: dict, *values: tuple[str, object]):
    return parse_scene(json.dumps(scene), Changes(values))


def test_changes_stand_in_the_scene_as_if_written():
    scene = {"id": "a", "kind": "flight", "launch": LAUNCH, "air": {"density": 1.1}}
    found = changed(
        scene, ("launch.velocity[1]", 3.0), ("air.wind", [1.0, 0.0, 0.0]), ("gravity", 9.7)
    )
    written = scene | {
        "launch": LAUNCH | {"velocity": [30, 3.0, 25]},
        "air": {"density": 1.1, "wind": [1.0, 0.0, 0.0]},
        "gravity": 9.7,
    }
    assert found == parse_scene(json.dumps(written))
    assert scene["launch"] is LAUNCH
    assert LAUNCH["velocity"] == [30, 0, 25]


def test_a_component_of_a_default_is_set():
    assert changed({"kind": "pitch"}, ("pitch.release[2]", 2.0)).pitch.release == (18.44, 0, 2)


BALL = {"kind": "flight", "launch": LAUNCH}
PITCH = {"kind": "pitch"}
WRONG = r"""
# names and units
value_of("pitch.sped", "1") -> ^pitch.sped: no scene has this key, did you mean pitch.speed\?
value_of("ptch.speed", "1") -> ^ptch.speed: no scene has this key, did you mean pitch\?
value_of("pitch.speed", "95mhp")
    -> ^pitch.speed=95mhp: the unit 'mhp' does not fit, did you mean mph\?
value_of("pitch.speed", "95ft") -> the unit 'ft' does not fit, did you mean ft/s\? Use m/s,
value_of("ball.restitution", "42%") -> ^ball.*the unit '%' does not fit; this number has none
value_of("pitch.speed", "1.2.3mph") -> ^pitch.speed=1.2.3mph: could not convert
# launches
changed(PITCH, ("launch.speed", 40.0)) -> launch: unknown key
changed(BALL, ("launch.speed", -4)) -> speed: must be positive
changed(BALL, ("launch.angle", "up")) -> must be a number in rad
changed(BALL, ("launch.angle", 28.0)) -> 28° are 0.4887 rad
changed(BALL | {"launch": {"velocity": 3}}, ("launch.angle", 0.1)) -> must give launch.v
changed(BALL | {"launch": 3}, ("launch.angle", 0.1)) -> launch.angle: launch is set to 3
# scenes
changed(PITCH | {"air": None}, ("air.density", 1)) -> air is set to null already
changed({"kind": "flight"}, ("launch.spin[0]", 1)) -> the scene does not give launch.spin; set all
changed(PITCH, ("pitch.aim[2]", 1)) -> the scene does not give pitch.aim; set all of
changed(PITCH, ("ball.mass", -1)) -> ball.mass: must be positive
"""


def test_a_change_that_does_not_fit_is_named():
    check_wrong_calls(WRONG, globals())
