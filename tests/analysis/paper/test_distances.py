"""How far a reading is from the paper's figures: known cases, and the χ² that it should be."""

import math

import numpy as np
import pytest

from analysis.paper.distances import (
    DRAWS,
    NEAR,
    NEAR_BOTH,
    Distance,
    Peak,
    covariance,
    distance,
    highest,
    histogram,
    peak,
    peak_chances,
    total,
)
from analysis.paper.printed import SAMPLES
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Curve, Estimate, fit

CURVE = PAPER_CURVES["caption"]


def estimates(p, trials):
    return [
        Estimate(e, round(one * trials), trials, 0, one, one - 0.01, one + 0.01)
        for e, one in zip(RESTITUTIONS, p, strict=True)
    ]


def test_thresholds_are_those_of_the_tables():
    assert pytest.approx(5.991, abs=5e-4) == NEAR
    assert pytest.approx(12.592, abs=5e-4) == NEAR_BOTH


@pytest.mark.parametrize("shared", [True, False])
def test_the_covariance_is_that_of_drawn_home_runs(shared):
    generator = np.random.default_rng(1)
    p = np.array([0.1, 0.2, 0.35])
    draws = 200_000
    luck = generator.random((draws, 1)) if shared else generator.random((draws, 3))
    seen = np.cov((luck < p).astype(float), rowvar=False)
    # A covariance of flags from so many draws has a standard error below 0.25/√draws.
    assert seen == pytest.approx(covariance(p, shared), abs=5 * 0.25 / math.sqrt(draws))


def test_the_curve_is_no_distance_from_itself():
    rows = estimates([CURVE(e) for e in RESTITUTIONS], 10**7)
    # Half a home run in 10⁷ is nothing in units of the noise of 1,000.
    assert distance(rows, CURVE).squared == pytest.approx(0.0, abs=1e-4)
    assert distance(rows, CURVE).near
    assert not distance(rows, PAPER_CURVES["text"]).near


def test_a_height_is_told_from_a_slope():
    p = np.array([CURVE(e) for e in RESTITUTIONS])
    lower, flatter = estimates(p - 0.02, 10**7), estimates(p.mean() + 0 * p, 10**7)
    assert distance(lower, CURVE).level > 3.0
    assert distance(lower, CURVE).slope == pytest.approx(0.0, abs=0.1)
    assert distance(flatter, CURVE).level == pytest.approx(0.0, abs=0.01)
    assert distance(flatter, CURVE).slope > 2.0


def test_a_curve_fitted_to_a_thousand_samples_a_point_is_as_far_as_chi_squared_says():
    generator = np.random.default_rng(2)
    p = np.array([CURVE(e) for e in RESTITUTIONS])
    truth = estimates(p, 10**7)
    squared = []
    for _ in range(400):
        drawn = generator.binomial(SAMPLES, p) / SAMPLES
        half = 1.96 * np.sqrt(drawn * (1 - drawn) / SAMPLES)
        rows = [
            Estimate(e, round(q * SAMPLES), SAMPLES, 0, q, q - h, q + h)
            for e, q, h in zip(RESTITUTIONS, drawn, half, strict=True)
        ]
        fitted = fit(rows)
        assert fitted is not None
        squared.append(distance(truth, fitted.curve).squared)
    # χ² with 2 degrees of freedom has mean and standard deviation 2; a fit weights the points,
    # the height and slope do not, which is a few per cent.
    assert np.mean(squared) == pytest.approx(2.0, abs=4 * 2 / math.sqrt(400))
    assert np.mean(np.array(squared) <= NEAR) == pytest.approx(0.95, abs=0.045)


def test_samples_that_are_shared_leave_the_slope_less_open():
    p = np.array([CURVE(e) for e in RESTITUTIONS])
    flatter = estimates(0.5 * (p + p.mean()), 10**7)
    alone, shared = (distance(flatter, CURVE, shared=s) for s in (False, True))
    assert shared.slope > 2 * alone.slope


def test_bins_of_ten_metres():
    d = np.array([1.0, 71.0, 79.9, 80.0])
    assert histogram(d).tolist() == [1, 0, 0, 0, 0, 0, 0, 2, 1]
    assert highest(d) == 75.0


def test_two_equal_bins_are_the_highest_half_of_the_time_each():
    d = np.repeat([75.0, 125.0], 500)
    chances = peak_chances(d, 1.0, np.random.default_rng(3))
    assert chances[7] + chances[12] == pytest.approx(1.0)
    assert chances[7] == pytest.approx(0.5, abs=4 * 0.5 / math.sqrt(DRAWS))


def test_a_peak_that_is_there_is_possible_and_one_that_is_not_is_not():
    generator = np.random.default_rng(4)
    d = np.repeat([75.0, 125.0], [900, 100])
    there, away = peak(0.41, d, 1.0, generator), peak(0.45, d, 1.0, generator)
    assert (there.ours, there.p_value) == (75.0, 1.0)
    assert away.ours == 75.0
    # No draw has it, and one is added: 2 · 1 / (draws + 1).
    assert away.p_value == pytest.approx(2 / (DRAWS + 1))


def test_the_sum_of_fisher():
    nothing = Distance(0.0, 0.0, 3.0)
    assert total(nothing, [Peak(75.0, 1.0), Peak(125.0, math.exp(-2))]) == pytest.approx(7.0)


def test_the_curves_of_the_paper_are_far_from_each_other():
    rows = estimates([Curve(271.0, 59.8)(e) for e in RESTITUTIONS], 10**7)
    assert distance(rows, CURVE).squared > 100
