"""Rules that separate failing scenes from passing ones by their features, and minimal scenes."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from longball.judge.diagnosis import scenes
from longball.judge.diagnosis.scenes import features, rule, shrunk
from longball.model.scene import AtBatScene, FlightScene, Launch, parse_scene
from tests.judge.material import known


@pytest.fixture(autouse=True)
def as_given(monkeypatch: Any) -> None:
    """Let cases be their features."""
    monkeypatch.setattr(scenes, "features", lambda case: case)


def told(wrong: Any, right: Any, **options: Any) -> str | None:
    return rule([*wrong], [*right], **options)


MANY = range(12)


def test_one_condition():
    flights = [{"kind": "flight", "m": 1.0 * i} for i in MANY]
    pitches = [{"kind": "pitch", "m": 1.0 * i} for i in MANY]
    assert told(flights, pitches) == "kind = flight"
    assert told(flights[:5], pitches[:5]) == "kind = flight"
    assert told(flights, pitches[:4]) is None
    assert told(flights[:4], pitches) is None
    assert told(flights[:6], flights[6:]) == "m < 5.5"
    assert told(flights[6:], flights[:6]) == "m > 5.5"
    assert told(flights[6:], flights[:6], measured=False) is None
    assert told(flights[:6], flights[6:], measured=False) is None
    assert told(flights[::2], flights[1::2]) is None  # nothing separates them
    flagged = [{"m": 0.1 * i, "flag tie": True} for i in MANY]
    assert told(flagged, [{"m": 0.1 * i} for i in MANY]) == "the flag tie"


def test_a_value_that_most_scenes_have():
    windy = [{"wind": 0.3 + i, "g": 1.0 + i} for i in MANY]
    calm = [{"wind": 0.0, "g": 2.0 * i} for i in MANY]
    assert told(windy, calm) == "wind ≠ 0"
    assert told(calm, windy) == "wind = 0"
    # Another usual value only if a program may have it built in.
    usual = scenes.DEFAULTS["gravity"]
    moon = [{"gravity": 1.0 + i, "m": 1.0 + i} for i in MANY]
    assert told(moon, [{"gravity": usual, "m": 2.0 * i} for i in MANY]) == f"gravity ≠ {usual:g}"
    assert told(moon, [{"gravity": 5.5, "m": 2.0 * i} for i in MANY]) is None
    assert told(
        [{"law": ("spin", "crisis")[i % 2], "m": 1.0} for i in MANY],
        [{"law": "none", "m": 1.0} for i in MANY],
    ) == "law ≠ none"  # fmt: skip


def test_two_conditions():
    every = [
        {"kind": kind, "wind": 1.0 * wind}
        for kind, wind, _ in itertools.product(("flight", "pitch", "at-bat"), (0, 1), range(15))
    ]
    wrong = [one for one in every if one["kind"] == "flight" and one["wind"]]
    right = [one for one in every if one not in wrong]
    assert {*told(wrong, right).split(" and ")} == {"kind = flight", "wind ≠ 0"}


def test_several_rules_for_the_same_scenes():
    wrong = [{"kind": "flight", "flag tie": True, "x": 0.0, "y": 3.0} for _ in MANY]
    right = [{"kind": "pitch", "x": 1.0 + i, "y": 4.0 + i} for i in MANY]
    assert told(wrong, right) == (
        "kind = flight; or, which are the same scenes, x = 0; or, which are the same scenes, "
        "the flag tie"
    )


def test_chance_makes_no_rule():
    """Of many features one separates a few scenes by chance."""
    wrong = [{f"f{k}": "ab"[k < 3] for k in range(40)} for i in range(5)]
    right = [{f"f{k}": "ab"[(i + k) % 2] for k in range(40)} for i in range(5)]
    assert told(wrong, right) is None


def test_short_limits():
    limits = [
        (-1, 2, 0),
        (3, 30, 20),
        (0.41, 0.48, 0.44),
        (0.26, 0.35, 0.3),
        (1.2341, 1.2349, 1.2345),
    ]
    for a, b, limit in limits:
        assert scenes._between(float(a), float(b)) == limit
    assert not scenes._is_short(1.23456)
    assert scenes._is_short(1234.0)


@pytest.mark.parametrize("family", ["at-bat", "flight-spin-lift", "pitch", "impact-oblique"])
def test_features(family: str):
    case = next(case for case in known(family) if case.expected.landing or "pitch" in family
                or case.scene.kind == "impact")  # fmt: skip
    found = features(case)
    assert found["kind"] == case.scene.kind
    assert found["outcome"] == case.expected.outcome
    assert found["ball.mass"] == case.scene.ball.mass
    if family == "at-bat":
        landing, impact = case.expected.landing, case.expected.impact
        speed = sum(float(x) ** 2 for x in landing.velocity) ** 0.5
        launch = sum(float(x) ** 2 for x in impact.velocity) ** 0.5
        assert found["landing speed"] == pytest.approx(speed)
        assert found["launch speed"] == pytest.approx(launch)
        assert found["larger speed of launch and landing"] == pytest.approx(max(speed, launch))
        assert found["direction at landing"] == ("+x" if float(landing.velocity[0]) > 0 else "-x")
        assert found["landing.position[1]"] == float(landing.position[1])
        assert found["contact.normal[2]"] == float(case.expected.contact.normal[2])
    if family == "pitch":
        pitch = case.scene.pitch
        rise = pitch.aim[1] - pitch.release[2]
        assert found["pitch.aim[1] - pitch.release[2]"] == rise
    if family == "flight-spin-lift":
        launch = case.scene.launch
        x, y, z = launch.velocity
        assert found["launch speed"] == pytest.approx((x * x + y * y + z * z) ** 0.5)
        spin = sum(x * x for x in launch.spin) ** 0.5
        assert found["size of launch.spin"] == pytest.approx(spin)
    if family == "impact-oblique":
        assert found["impact.mode"] == case.expected.impact.mode
        assert found["impact.restitution"] == float(case.expected.impact.restitution)


def test_a_scene_is_shrunk_to_what_fails():
    scene = parse_scene(
        '{"id": "a", "kind": "at-bat", "gravity": 9.7, "pitch": {"speed": 41.237, '
        '"aim": [0.123456, 1.8]}, "ball": {"mass": 0.1431}, "air": {"wind": [1, 2, 0.5]},'
        '"reading": {"inertia": "thin_rod"}, "time_limit": 30}'
    )
    asked = []

    def fails(some: Any) -> list[bool]:
        asked.append(len(some))
        return [one.pitch.speed > 30 and one.ball.mass != 0.145 for one in some]

    small = shrunk(scene, fails)
    assert (small.air, small.ball.mass) == (None, 0.1)
    assert small.pitch == AtBatScene(id="b").pitch
    assert small.model_dump(exclude_defaults=True).keys() <= {"id", "kind", "pitch", "ball", "air"}
    assert len(asked) <= 2 * scenes.LARGEST_SHRINKS
    # Nothing smaller fails: the scene stays.
    same = shrunk(scene, lambda some: [False] * len(some))
    assert same == scene.model_copy(update={"id": "shrunk"})


def test_simpler_numbers():
    launch = Launch(position=(1e-12, 0.5, 1.2345), velocity=(30.0, 0.0, 20.0))
    scene = FlightScene(id="a", launch=launch, air=None)
    found = {change(scene).launch.position for change in scenes.simpler(scene)}
    assert (0.0, 0.5, 1.2345) in found
    assert (1e-12, 0.5, 1.0) in found
    assert not any(place[1] == 0.0 for place in found)
