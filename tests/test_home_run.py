"""Sampling, counting and fitting P(e)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from longball.home_run import (
    BLOCK,
    PAPER_CURVES,
    Curve,
    Estimate,
    Struck,
    draw,
    estimate,
    fit,
    monte_carlo,
    paper_at_bats,
    scenes,
    wilson,
)
from longball.model.readings import Reading
from longball.model.scene import AtBatScene

BASE = AtBatScene(id="base")
PAPER = paper_at_bats(Reading())


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

    def test_another_seed_gives_others(self):
        assert not np.any(draw(PAPER, 50, seed=4).speed == self.many.speed[:50])

    def test_read_the_ledger(self):
        printed = paper_at_bats(Reading(speed_spread="as_printed", cell_width=0.3))
        assert printed.speed.deviations[0] == pytest.approx(4.58 / 3.6 / math.sqrt(2))
        assert printed.aim.means == pytest.approx((-0.3, 0.3))
        swapped = paper_at_bats(Reading(speed_table="as_printed", offset_spread=0.0732))
        assert swapped.speed.means == pytest.approx((4.58 / 3.6, 7.80 / 3.6))
        assert swapped.offset_deviation == 0.0732

    def test_a_speed_that_is_not_positive_is_no_scene(self):
        backwards = draw(paper_at_bats(Reading(speed_table="as_printed")), 50, seed=1)
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


class TestMonteCarlo:
    def test_workers_change_no_bit(self):
        one, two = (monte_carlo(BASE, PAPER, (0.41, 0.45), 70, seed=1, workers=n) for n in (1, 2))
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a.x, b.x)
            np.testing.assert_array_equal(a.y, b.y)

    def test_more_restitution_flies_farther(self):
        low, high = monte_carlo(BASE, PAPER, (0.3, 0.6), 60, seed=1)
        forward = low.batted & (low.x > 20)
        assert forward.any()
        assert np.all(high.distance[forward] > low.distance[forward])

    def test_progress_reaches_the_end(self):
        seen: list[int] = []
        monte_carlo(BASE, PAPER, (0.4,), BLOCK + 1, seed=1, progress=seen.append)
        assert seen == [BLOCK, BLOCK + 1]


class TestEstimate:
    nan = math.nan
    struck = Struck(
        x=np.array([151.0, 149.0, nan, -160.0, 150.0, 10.0]),
        y=np.array([0.0, 0.0, nan, 0.0, 0.0, 200.0]),
        failed=np.array([False, False, True, False, False, False]),
    )

    @pytest.mark.parametrize(
        ("space", "home_runs", "trials"), [("pitches", 4, 6), ("batted", 4, 5), ("fair", 2, 3)]
    )
    def test_counts_in_its_sample_space(self, space: str, home_runs: int, trials: int):
        row = estimate(0.42, self.struck, Reading(sample_space=space))
        assert (row.home_runs, row.trials, row.failed) == (home_runs, trials, 1)
        assert row.p == home_runs / trials

    def test_wilson_is_the_score_interval(self):
        for successes, trials in [(0, 10), (3, 10), (170, 1000), (10, 10)]:
            expected = stats.binomtest(successes, trials).proportion_ci(method="wilson")
            assert wilson(successes, trials) == pytest.approx((expected.low, expected.high))

    def test_nothing_tried_is_nothing_known(self):
        assert all(math.isnan(bound) for bound in wilson(0, 0))


class TestFit:
    def rows(self, curve: Curve, trials: int) -> list[Estimate]:
        made = []
        for e in (0.41, 0.42, 0.43, 0.44, 0.45):
            hits = round(curve(e) * trials)
            made.append(Estimate(e, hits, trials, 0, hits / trials, *wilson(hits, trials)))
        return made

    @pytest.mark.parametrize("name", ["caption", "text"])
    def test_finds_the_curve_it_is_given(self, name: str):
        curve = PAPER_CURVES[name]
        found = fit(self.rows(curve, 10**9))
        assert found.curve.c1 == pytest.approx(curve.c1, rel=1e-5)
        assert found.curve.sigma == pytest.approx(curve.sigma, rel=1e-5)

    def test_its_errors_cover_the_truth(self):
        curve = PAPER_CURVES["caption"]
        generator = np.random.default_rng(1)
        inside = 0
        for _ in range(100):
            drawn = []
            for e in (0.2, 0.4, 0.6, 0.8):
                hits = int(generator.binomial(1000, curve(e)))
                drawn.append(Estimate(e, hits, 1000, 0, hits / 1000, *wilson(hits, 1000)))
            found = fit(drawn)
            inside += abs(found.curve.c1 - curve.c1) < 1.96 * found.c1_error
        # 95 of 100 expected; binomially, fewer than 88 or all 100 are each below 1 %.
        assert 88 <= inside < 100

    def test_says_when_there_is_nothing_to_fit(self):
        assert fit(self.rows(Curve(100.0, 5.0), 1000)) is None
        assert fit(self.rows(PAPER_CURVES["caption"], 1000)[:2]) is None

    def test_the_paper_s_text_agrees_with_its_caption(self):
        assert PAPER_CURVES["caption"](0.42) == pytest.approx(0.177, abs=5e-4)
        assert PAPER_CURVES["text"](0.42) == pytest.approx(0.273, abs=5e-4)
