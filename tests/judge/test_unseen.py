"""Scenes that nobody has seen: the scenes at hand, moved; and names that they refute."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.answers import Answer, Collector
from longball.judge.cases import solved
from longball.judge.diagnosis.diagnose import diagnose
from longball.judge.fresh import moved
from longball.model.quantities import numbers
from longball.model.scene import Scene
from tests.judge.material import flights, impacts


def test_moved_scenes_have_the_same_keys_and_other_numbers():
    scenes = [case.scene for family in ("fence", "flight-weather") for case in load(family)][::9]
    again = [*moved(scenes, 3)]
    assert again == [*moved(scenes, 3)] != [*moved(scenes, 4)]
    for scene, other in zip(scenes, again, strict=True):
        before, after = dict(numbers(scene)), dict(numbers(other))
        assert before.keys() == after.keys() and other.reading == scene.reading
        kept = {name for name in before if before[name] == after[name]}
        assert all(before[name] == 0 for name in kept - {"time_limit"})


def test_ball_and_bat_of_a_moved_impact_still_touch():
    for scene in moved(impacts(), 1):
        (x, _, z), height = scene.incoming.position, scene.incoming.bat_height
        reach = scene.ball.radius + scene.bat.radius
        assert math.isclose(math.hypot(x, z - height), reach, rel_tol=1e-12)


def backwards(scenes: Iterable[Scene]) -> dict[str, Answer]:
    """Landings of a program that steps x against the velocity."""
    asked = list(scenes)
    collector = Collector([str(scene.id) for scene in asked])
    for number, scene in enumerate(asked, 1):
        landing = solve(scene, Ivp()).landing
        x, y, z = map(float, landing.position)
        position = [2 * scene.launch.position[0] - x, y, z]
        told = {"id": scene.id, "outcome": "landed",
                "landing": {"time": float(landing.time), "position": position}}  # fmt: skip
        collector.take_line(number, json.dumps(told).encode())
    return collector.answers


def test_a_name_that_holds_by_chance_is_withdrawn():
    scenes = []
    for scene in flights():
        _, y, z = scene.launch.position
        launch = scene.launch.model_copy(update={"position": (0.0, y, z)})
        scenes.append(scene.model_copy(update={"launch": launch}))
    cases, answers = solved(scenes, Ivp()), backwards(scenes)
    # From x = 0 it is only another sign. Elsewhere it is not.
    by_chance = "landing.position is given as (-x, y, z)"
    assert [found.edit for found in diagnose(cases, answers).findings] == [by_chance]
    (found,) = diagnose(cases, answers, solve=backwards).findings
    assert (found.stage, found.kind) == ("flight", "located")
