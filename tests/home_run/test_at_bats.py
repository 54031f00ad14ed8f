"""The paper's distributions, and samples of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from longball.home_run import BLOCK, draw, paper_at_bats, scenes
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

BASE = AtBatScene(id="base")
PAPER = paper_at_bats(SamplingReading())


class TestSamples:
    many = draw(PAPER, 40_000, seed=3)

    def test_follow_the_paper_s_distributions(self):
        def speeds(v):  # Eq. 3, Table II, km/h
            return 0.45 * stats.norm.cdf(v, 139.1, 4.58) + 0.55 * stats.norm.cdf(v, 127.8, 7.80)

        def cells(y):  # Eq. 4
            return 0.52 * stats.norm.cdf(y, 2, 0.77) + 0.48 * stats.norm.cdf(y, 4, 0.77)

        for values, cdf in [
            (self.many.speed * 3.6, speeds),
            (self.many.aim / 0.144 + 3, cells),
            (self.many.offset, stats.norm(0, 0.0366).cdf),
            (self.many.tilt, stats.uniform(0, math.radians(10)).cdf),
        ]:
            assert stats.kstest(values, cdf).pvalue > 1e-3

    def test_are_independent_of_each_other(self):
        columns = [self.many.speed, self.many.aim, self.many.offset, self.many.tilt]
        correlations = np.corrcoef(columns) - np.eye(4)
        assert np.abs(correlations).max() < 5 / math.sqrt(len(self.many))

    def test_fewer_are_the_first_of_more(self):
        few = draw(PAPER, BLOCK + 7, seed=3)
        for name in ("speed", "aim", "offset", "tilt"):
            np.testing.assert_array_equal(getattr(few, name), getattr(self.many, name)[: BLOCK + 7])

    def test_any_range_of_them_can_be_drawn(self):
        later = draw(PAPER, BLOCK + 7, seed=3, first=3 * BLOCK)
        np.testing.assert_array_equal(later.tilt, self.many.tilt[3 * BLOCK : 4 * BLOCK + 7])

    def test_read_the_ledger(self):
        printed = paper_at_bats(SamplingReading(speed_spread="as_printed", cell_width=0.3))
        assert printed.speed.deviations[0] == pytest.approx(4.58 / 3.6 / math.sqrt(2))
        assert printed.aim.means == pytest.approx((-0.3, 0.3))
        swapped = paper_at_bats(SamplingReading(speed_table="as_printed", offset_spread=0.0732))
        assert swapped.speed.means == pytest.approx((4.58 / 3.6, 7.80 / 3.6))
        assert swapped.offset_deviation == 0.0732

    def test_a_speed_that_is_not_positive_is_no_scene(self):
        backwards = draw(paper_at_bats(SamplingReading(speed_table="as_printed")), 50, seed=1)
        made = list(scenes(BASE, backwards))
        assert [scene is None for scene in made] == list(backwards.speed <= 0)
        assert None in made

    def test_scenes_carry_what_was_drawn(self):
        samples = draw(PAPER, 3, seed=1)
        scene = list(scenes(BASE, samples))[2]
        assert scene.id == "sample-000002"
        assert scene.pitch.speed == samples.speed[2]
        assert scene.pitch.aim == (samples.aim[2], 1.8)
        assert scene.swing.height_offset == samples.offset[2]
        assert scene.swing.tilt == samples.tilt[2]
        assert scene.swing.angular_speed == 34.0
