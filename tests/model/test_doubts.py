"""Questions about scenes that are valid, and probably not meant."""

from __future__ import annotations

import json

import pytest

from longball.model.doubts import doubts
from longball.model.scene import parse_scene

LAUNCH = {"position": [0.6, 0, 0.9], "velocity": [42, -3, 22]}
LEFT, CENTRE, RIGHT = [67, 67, 3], [122, 0, 3], [67, -67, 3]


def keys(**blocks: object) -> list[str]:
    blocks.setdefault("kind", "flight")
    if blocks["kind"] == "flight":
        blocks.setdefault("launch", LAUNCH)
    return [key for key, _ in doubts(parse_scene(json.dumps(blocks)))]


@pytest.mark.parametrize(
    "blocks",
    [
        {},
        {"kind": "pitch", "pitch": {"speed": 47.4, "spin": [0, 360, 0]}},  # the fastest one
        {"kind": "at-bat", "bat": {"mass": 1.2, "length": 1.07}, "swing": {"tilt": -0.5}},
        {"launch": LAUNCH | {"velocity": [42, 0, 35], "spin": [0, -700, 0]}},  # 122 mph, 6,700 rpm
        {"gravity": 0},
        {"fence": {"polyline": [LEFT, CENTRE, RIGHT]}},
        {"fence": {"polyline": [LEFT, RIGHT]}},
        {"fence": {"radius": 120}},
    ],
)
def test_baseball_raises_no_question(blocks: dict):
    assert keys(**blocks) == []


@pytest.mark.parametrize(
    ("key", "blocks"),
    [
        ("ball.mass", {"ball": {"mass": 145}}),
        ("ball.radius", {"ball": {"radius": 3.66}}),
        ("bat.mass", {"kind": "at-bat", "bat": {"mass": 32}}),
        ("bat.length", {"kind": "at-bat", "bat": {"length": 34}}),
        ("pitch.speed", {"kind": "pitch", "pitch": {"speed": 95}}),
        ("pitch.release", {"kind": "pitch", "pitch": {"release": [55, 0, 6]}}),
        ("pitch.spin", {"kind": "pitch", "pitch": {"spin": [0, 2200, 0]}}),
        ("swing.tilt", {"kind": "at-bat", "swing": {"tilt": 5}}),
        ("launch.velocity", {"launch": LAUNCH | {"velocity": [90, 0, 50]}}),
        ("gravity", {"gravity": 32.2}),
        ("fence.radius", {"fence": {"radius": 400}}),
        ("fence.polyline", {"fence": {"polyline": [[220, 220, 3], [400, 0, 3], [220, -220, 3]]}}),
        # x to right field and y to centre field; and half a fence.
        ("fence.polyline", {"fence": {"polyline": [[-67, 67, 3], [0, 122, 3], [67, 67, 3]]}}),
        ("fence.polyline", {"fence": {"polyline": [[90, -10, 3], [67, -67, 3]]}}),
    ],
)
def test_other_units_and_axes_are_asked_about(key: str, blocks: dict):
    assert keys(**blocks) == [key]
