"""Counting and fitting P(e)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.home_run import PAPER_CURVES, Curve, Estimate, Struck, estimate, fit, wilson
from longball.home_run.estimation import fit_form, of_line


class TestEstimate:
    nan = math.nan
    struck = Struck(
        x=np.array([151.0, 149.0, nan, -160.0, 150.0, 10.0]),
        y=np.array([0.0, 0.0, nan, 0.0, 0.0, 200.0]),
        failed=np.array([False, False, True, False, False, False]),
        home_run=np.array([True, False, False, True, True, True]),
    )

    @pytest.mark.parametrize(
        ("space", "home_runs", "trials"), [("pitches", 4, 6), ("batted", 4, 5), ("fair", 2, 3)]
    )
    def test_counts_in_its_sample_space(self, space: str, home_runs: int, trials: int):
        row = estimate(0.42, self.struck, space)
        assert (row.home_runs, row.trials, row.failed) == (home_runs, trials, 1)
        assert row.p == home_runs / trials

    def test_wilson_is_the_score_interval(self):
        """Its ends lie 1.96 of their own standard errors from what was counted."""
        for successes, trials in [(0, 10), (3, 10), (170, 1000), (10, 10)]:
            low, high = wilson(successes, trials)
            assert (low == 0.0) is (successes == 0)
            assert (high == 1.0) is (successes == trials)
            for p in {low, high} - {0.0, 1.0}:
                error = math.sqrt(p * (1 - p) / trials)
                assert abs(successes / trials - p) == pytest.approx(1.959963984540054 * error)

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

    def test_values_without_errors_lie_on_a_line_of_probits(self):
        curve = PAPER_CURVES["caption"]
        e = (0.3, 0.5, 0.7)
        found = fit_form(e, [*map(curve, e)])
        assert (found.curve.c1, found.curve.sigma) == pytest.approx((242.0, 52.2), rel=1e-6)
        assert found.c1_error < 1e-4 * found.curve.c1  # they do not scatter
        # The form is never 0 or 1: such values say nothing, and two others leave no scatter.
        outer = (0.1, *e, 0.9), [0.0, *map(curve, e), 1.0]
        assert fit_form(*outer) == found
        assert fit_form(outer[0][:3], outer[1][:3]) is None
        assert fit_form(outer[0][:3], outer[1][:3], [0.01] * 3) is not None
        assert fit_form(outer[0][:2], outer[1][:2], [0.01] * 2) is None
        assert fit_form(outer[0][1:3], outer[1][1:3], [0.01] * 2) is None

    def test_errors_are_propagated_from_the_line(self):
        a, b, step = 4.0, 3.0, 1e-6
        for change in ((step, 0.0), (0.0, step), (step, step), (step, -step)):
            one = of_line(a, b, np.outer(change, change))
            moved = of_line(a + change[0], b + change[1], np.zeros((2, 2))).curve
            assert one.c1_error == pytest.approx(abs(moved.c1 - one.curve.c1), rel=1e-4, abs=1e-9)
            assert one.sigma_error == pytest.approx(abs(moved.sigma - one.curve.sigma), rel=1e-4)

    def test_says_when_there_is_nothing_to_fit(self):
        assert fit(self.rows(Curve(100.0, 5.0), 1000)) is None
        assert fit(self.rows(PAPER_CURVES["caption"], 1000)[:2]) is None
        # The same P at every e tells no slope.
        level = [Estimate(e, 1, 300, 0, 1 / 300, *wilson(1, 300)) for e in (0.41, 0.43, 0.45)]
        assert fit(level) is None

    def test_the_paper_s_text_agrees_with_its_caption(self):
        assert PAPER_CURVES["caption"](0.42) == pytest.approx(0.177, abs=5e-4)
        assert PAPER_CURVES["text"](0.42) == pytest.approx(0.273, abs=5e-4)
