"""Random scenes of every family: answered, and answered rightly. Thousands more are a study."""

from __future__ import annotations

import pytest

from analysis.random_scenes import FAMILIES, random_scene
from analysis.survival import examine, verdict_of
from longball.engines import create
from longball.engines.chain import solve
from longball.model.scene import parse_scene

SEED = 2


@pytest.mark.parametrize("family", FAMILIES)
def test_engines_agree_with_what_is_proven(family, monkeypatch):
    # What takes the enclosure more than some tenths of a second is not compared here.
    monkeypatch.setattr("longball.engines.enclosure.engine._MOST_WORK", 200_000)
    for number in range(24):
        scene = random_scene(family, number, SEED)
        for row in examine(scene):
            assert row["verdict"] in ("right", "declined", "not compared"), (row, scene.line())


@pytest.mark.parametrize("family", FAMILIES)
def test_engines_agree_with_each_other(family):
    for number in range(24, 100):
        scene = random_scene(family, number, SEED)
        for row in examine(scene, proven=False):
            assert row["verdict"] in ("declined", "not compared"), (row, scene.line())


@pytest.mark.parametrize("family", FAMILIES)
def test_a_scene_hangs_on_its_number_alone(family):
    scenes = [random_scene(family, n, SEED) for n in (3, 5, 3)]
    assert scenes[0] == scenes[2] != scenes[1]
    assert parse_scene(scenes[0].line()) == scenes[0]


def test_what_is_not_right_is_found():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    truth = solve(scene, create("enclosure", digits=20))
    right = solve(scene, create("ivp"))
    assert verdict_of(scene, right, truth) == "right"
    assert (
        verdict_of(scene, right.model_copy(update={"outcome": "missed"}), truth) == "wrong outcome"
    )

    impact = right.impact.model_copy(update={"impulse": right.impact.impulse * (1 + 1e-11)})
    assert verdict_of(scene, right.model_copy(update={"impact": impact}), truth) == "number off"
