"""Mistakes that are in the sampling, told from the drawn at-bats."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.home_run import draw, paper_at_bats, scenes
from longball.judge.sampling import judge_samples
from longball.model.readings import Reading
from longball.model.scene import AtBatScene


def at_bats(count: int = 1000, **switches: object) -> list[AtBatScene]:
    samples = draw(paper_at_bats(Reading.model_validate(switches)), count, 5)
    return [scene for scene in scenes(AtBatScene(id="base"), samples) if scene]


def changed(block: str, key: str, change) -> list[AtBatScene]:
    found = []
    for scene in at_bats():
        held = getattr(scene, block)
        other = held.model_copy(update={key: change(getattr(held, key))})
        found.append(scene.model_copy(update={block: other}))
    return found


def named(drawn: list[AtBatScene]) -> dict[str, list[str]]:
    return {found.quantity: found.named for found in judge_samples(drawn) if found.named}


def test_the_papers_at_bats_are_right():
    assert named(at_bats()) == {}
    assert all(found.fits for found in judge_samples(at_bats()))


@pytest.mark.parametrize(
    ("drawn", "quantity", "mistakes"),
    [
        (at_bats(speed_spread="as_printed"), "pitch.speed", ["missing-2"]),
        (at_bats(offset_spread=0.0732), "swing.height_offset", ["radius-or-diameter"]),
        (changed("pitch", "speed", lambda v: 3.6 * v), "pitch.speed", ["speed-in-km/h"]),
        (changed("swing", "tilt", math.degrees), "swing.tilt", ["tilt-in-degrees"]),
        (changed("pitch", "aim", lambda a: (a[0] / 0.144, a[1])), "pitch.aim",
         ["cells-for-metres"]),
        (changed("pitch", "aim", lambda a: (a[0] + 3 * 0.144, a[1])), "pitch.aim",
         ["cells-from-the-edge"]),
    ],
)  # fmt: skip
def test_a_mistake_is_named(drawn: list[AtBatScene], quantity: str, mistakes: list[str]):
    assert named(drawn) == {quantity: mistakes}


def test_the_printed_columns_are_recognised_though_they_draw_impossible_speeds():
    # A speed that is not positive is no pitch: what is left is cut off, as the author's is.
    drawn = [
        float(v) for v in draw(paper_at_bats(Reading(speed_table="as_printed")), 1000, 5).speed
    ]
    base = AtBatScene(id="base")
    drawn_scenes = [
        base.model_copy(update={"pitch": base.pitch.model_copy(update={"speed": v})}) for v in drawn
    ]
    found = {d.quantity: d for d in judge_samples(drawn_scenes)}
    assert found["pitch.speed"].named == ["table-columns"]


def test_two_mistakes_in_one_quantity():
    drawn = at_bats(speed_spread="as_printed")
    fast = [
        s.model_copy(update={"pitch": s.pitch.model_copy(update={"speed": 3.6 * s.pitch.speed})})
        for s in drawn
    ]
    assert named(fast) == {"pitch.speed": ["missing-2", "speed-in-km/h"]}


def test_a_stranger_fits_nothing():
    noise = iter(np.random.default_rng(1).uniform(20, 50, 1000))
    found = judge_samples(changed("pitch", "speed", lambda _: float(next(noise))))
    assert not found[0].fits
    assert "none of the known" in found[0].sentence


def test_few_cannot_tell():
    with pytest.raises(ValueError, match="50 are needed"):
        judge_samples(at_bats(49))
