"""The parts of the study of the seasons that can be worked by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analysis.reality import landings
from analysis.seasons import (
    FENCE,
    Variant,
    fence_distance,
    measured_hits,
    of_games,
    proportionality,
)
from longball.engines import create
from longball.model.scene import Fence
from longball.pitches.models import MODELS
from longball.pitches.prediction import scenes
from longball.pitches.statcast import FOOT


def test_the_fence_goes_straight_from_point_to_point():
    assert fence_distance(np.radians([-45, 0, 15])) / FOOT == pytest.approx([330, 402, 392])
    # A third of the way from centre field to the point at 15°.
    x = (402 * 2 + 392 * math.cos(math.radians(15))) / 3
    y = 392 * math.sin(math.radians(15)) / 3
    bearing = np.array([math.atan2(y, x)])
    assert fence_distance(bearing) / FOOT == pytest.approx([math.hypot(x, y)])
    assert fence_distance(-bearing) == pytest.approx(fence_distance(bearing))
    # Balls in play are fair: what the drawing has beyond a pole passes at the pole.
    assert fence_distance(np.array([1.0])) / FOOT == pytest.approx([330])


def test_the_impulse_is_proportional_to_one_plus_e():
    # Some roundings of the impulse, divided by a change of e of a tenth.
    assert proportionality() < 1e-12


def test_a_livelier_ball_is_faster_by_its_share_of_the_impulse():
    hits = measured_hits()
    livelier = hits.with_restitution(0.01, 0.4)
    gained = livelier.flies.velocity - hits.flies.velocity
    assert gained == pytest.approx(0.01 * (hits.flies.velocity - hits.pitch) / 1.4, abs=1e-12)
    # A pitch comes down on the plate at its speed; measured flies leave the other way.
    assert np.linalg.norm(hits.pitch, axis=1).min() > 28
    assert np.linalg.norm(hits.pitch, axis=1).max() < 45
    assert (hits.pitch[:, 0] < 0).all()
    assert (hits.flies.velocity[:, 0] > 0).all()


def test_a_bootstrap_over_games():
    variant = Variant("", measured_hits(), MODELS["nathan"], 1.0)
    games = variant.hits.flies.games
    n = len(np.unique(games))
    one = np.ones(len(games))
    doubled = of_games(lambda a, b: b / a, variant, one, 2.0 * one)
    assert doubled.value == 2.0
    assert doubled.interval == (2.0, 2.0)
    # One home run in a game and none in the others: a game is drawn any number of times, in the
    # mean once, with the variance 1 - 1/n of n draws of one in n.
    first = (games == games[0]) / np.sum(games == games[0])
    drawn = of_games(lambda a: a, variant, first).draws
    assert set(np.round(drawn, 9)) >= {0.0, 1.0, 2.0}
    error = math.sqrt((1 - 1 / n) / len(drawn))
    assert drawn.mean() == pytest.approx(1.0, abs=4 * error)


@pytest.mark.nightly
def test_margins_say_what_the_fence_of_a_scene_says():
    hits = measured_hits()
    long = replace(hits, flies=hits.flies.chosen(hits.flies.measured[:, 0] > 100.0))
    variant = Variant("", long, MODELS["nathan"], 1.0, by_place=True)
    margins = variant.margins(long)
    place, _ = landings(long.flies, variant.model)
    polyline = [
        (FOOT * far * math.cos(math.radians(a)), -FOOT * far * math.sin(math.radians(a)), 8 * FOOT)
        for a, far in FENCE
    ]
    batch = create("batch")
    fenced = [
        scene.model_copy(update={"fence": Fence(polyline=tuple(polyline))})
        for scene in scenes(long.flies, variant.model)
    ]
    over = np.array([result.outcome == "home_run" for result in batch.solve_all(fenced)])
    # Well between the poles, and further from the top of the fence than a path from there to the
    # ground bends: 0.2 m were seen.
    bearing = np.degrees(np.arctan2(-place[:, 1], place[:, 0]))
    clear = (np.abs(bearing) < 42.0) & (np.abs(margins) > 0.5)
    assert clear.sum() > 80
    assert (over[clear] == (margins[clear] > 0.0)).all()
    assert over[clear].any()
    assert not over[clear].all()
