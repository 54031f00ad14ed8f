"""Distances of readings from the paper's figures: known cases, and the χ² distribution."""

import math

import numpy as np
import pytest

from analysis.paper.distances import (
    CELL,
    DRAWS,
    NEAR,
    covariance,
    distance,
    in_cells,
    scores,
)
from analysis.paper.printed import PEAKS, SAMPLES
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Estimate, fit

CURVE = PAPER_CURVES["caption"]


def estimates(p, trials):
    return [
        Estimate(e, round(one * trials), trials, 0, one, one - 0.01, one + 0.01)
        for e, one in zip(RESTITUTIONS, p, strict=True)
    ]


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
    assert distance(rows, CURVE) == pytest.approx(0.0, abs=1e-4)
    assert distance(rows, PAPER_CURVES["text"]) > NEAR


def test_a_height_and_a_slope_count():
    p = np.array([CURVE(e) for e in RESTITUTIONS])
    lower, flatter = estimates(p - 0.02, 10**7), estimates(p.mean() + 0 * p, 10**7)
    # The mean of 5,000 flags of 0.17 has the standard error √(0.17 · 0.83 / 5,000) = 0.0053; the
    # slope of five shares of 0.19, √(0.19 · 0.81 / 1,000 / 0.001) = 0.39 (Σ(e - 0.43)² = 0.001).
    assert distance(lower, CURVE) == pytest.approx((0.02 / 0.0053) ** 2, rel=0.02)
    slope = (p[-1] - p[0]) / 0.04
    assert distance(flatter, CURVE) == pytest.approx((slope / 0.39) ** 2, rel=0.02)


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
        squared.append(distance(truth, fitted.curve))
    # χ² with 2 degrees of freedom has mean and standard deviation 2; a fit weights the points,
    # the height and slope do not, which is a few per cent.
    assert np.mean(squared) == pytest.approx(2.0, abs=4 * 2 / math.sqrt(400))
    assert np.mean(np.array(squared) <= NEAR) == pytest.approx(0.95, abs=0.045)


# ---- both figures --------------------------------------------------------------------------------


NOWHERE = 0.0
# Balls at 75 m and 125 m, and home runs as often as on the caption's curve.
SHARES = {0.41: (0.5, 0.2), 0.45: (0.2, 0.5)}


def figures(shares, seven=NOWHERE, seed=4):
    """Scores of a reading with so many balls at 75 m and at 125 m, and as many home runs."""
    cells = {}
    for e in RESTITUTIONS:
        near, far = shares.get(e, (0.3, 0.3))
        d = np.repeat([72.5, 122.5, 202.5], [round(1000 * x) for x in (near, far, CURVE(e))])
        cells[e] = in_cells(d, len(d) / 1000)
    return scores(cells, seven, np.random.default_rng(seed))


def test_two_peaks_that_are_there_are_not_rejected_in_any_bins():
    found = figures(SHARES)
    for width in (10.0, 20.0, 50.0):
        score = found[width]
        assert score.p_value > 0.9
        for e, at in PEAKS.items():
            middle = width * (math.floor((at - CELL / 2) / width) + 0.5)
            assert score.peaks[e].ours == middle
    # In bins of 25 m, whose edges the printed peaks are, they count as the upper ones.
    assert found[25.0].peaks[0.41].p_value == pytest.approx(2 / (DRAWS + 1))


def test_papers_drawn_under_a_reading_have_uniform_p_values():
    """With both peaks certain, the score is Fig. 7's alone: a χ² with 2 degrees of freedom."""
    for squared in (1.0, NEAR):
        p_value = figures(SHARES, squared)[50.0].p_value
        error = math.sqrt(math.exp(-squared / 2) / DRAWS)
        assert p_value == pytest.approx(math.exp(-squared / 2), abs=5 * error)
