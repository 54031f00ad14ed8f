"""The search for scenes: a greedy cover, and random scenes that have every key."""

import json

import numpy as np
import pytest

from analysis.scene_search import RANGES, cover, drawn, is_ordinary
from longball.model.quantities import flat


def test_a_cover_takes_the_best_column_first_until_each_row_has_enough():
    noticed = np.array([[1, 1, 0, 0], [0, 1, 0, 1], [0, 1, 1, 0], [0, 0, 0, 0]], bool)
    # The last row cannot be helped; the first has enough.
    assert [*cover(noticed, np.array([0, 2, 1, 3]), 10)] == [(1, 2), (3, 1)]
    assert [*cover(noticed, np.array([0, 2, 1, 3]), 1)] == [(1, 2)]
    assert [*cover(noticed, np.array([-2, 0, 0, 0]), 10)] == []
    assert noticed.sum() == 6  # the argument is as it was


def test_hard_families_and_random_scenes_are_not_ordinary():
    families = np.array(["pitch", "hard", "drawn", "hard-real", "flight-real"])
    assert is_ordinary(families).tolist() == [True, False, False, False, True]


@pytest.mark.nightly  # of a study alone
def test_random_scenes_have_every_number_that_is_drawn():
    lines = [scene.line() for scene in drawn(200)]
    assert lines == [scene.line() for scene in drawn(200)]
    keys = {name for line in lines for name, _ in flat(json.loads(line))}
    for key, laws in RANGES.items():
        assert {f"air.{key}.{name}" for ends in laws.values() for name in ends} <= keys
    assert {"air.side_coefficient.value", "bat.friction", "earth.latitude"} <= keys
