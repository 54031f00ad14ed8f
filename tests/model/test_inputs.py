"""The inputs of a scene, and what trackers give of a launch."""

import math

import pytest

import longball as lb
from longball.model.inputs import TRACKED, require_inputs, tracked, value_of, with_values


def flight(**launch):
    return lb.Flight(launch={"position": [0, 0, 1], **launch}, air=None)


def test_a_launch_is_tracked_by_speed_angle_and_direction():
    scene = flight(velocity=[3.0, 4.0, 12.0])
    assert tracked(scene) == pytest.approx(
        {
            "launch.speed": 13.0,
            "launch.angle": math.atan(12 / 5),
            "launch.direction": math.atan(4 / 3),
        }
    )


@pytest.mark.parametrize(
    ("spin", "part"),
    # A ball that flies to centre field, +x, is lifted by a backspin about -y, and turned to the
    # left, +y, by a side spin about +z; gyrospin is about its way.
    [
        ((0, -1, 0), "launch.backspin"),
        ((0, 0, 1), "launch.side_spin"),
        ((1, 0, 0), "launch.gyrospin"),
    ],
)
def test_the_axes_of_spin_are_those_of_the_field(spin, part):
    parts = tracked(flight(velocity=[30, 0, 0], spin=spin))
    assert {name for name in TRACKED[3:] if parts[name]} == {part}
    assert parts[part] == 1.0


def test_one_of_them_changes_and_the_others_stay():
    scene = flight(velocity=[30.0, 5.0, 20.0], spin=[10.0, -200.0, 30.0])
    moved = with_values(scene, {"launch.angle": 0.25, "gravity": 9.81})
    assert moved.gravity == 9.81
    expected = tracked(scene) | {"launch.angle": 0.25}
    assert tracked(moved) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("launch.sped", "did you mean launch.speed?"),
        ("launch.backspin", "the scene has no launch.spin"),
        ("air.drag_coefficient", "the scene has no such number"),
    ],
)
def test_a_number_that_the_scene_has_not_is_named(name, sentence):
    with pytest.raises(ValueError, match=sentence.replace("?", r"\?")):
        value_of(flight(velocity=[30, 0, 20]), name)


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match=r"gravity is named more than once"):
        require_inputs(flight(velocity=[30, 0, 20]), ["gravity", "gravity"])
