"""Curves through histograms, as the paper lays them: known answers, and its own numbers."""

import math

import numpy as np
import pytest

from analysis.paper.histograms import INTEGRAL_AS_PRINTED, curves, normal_through, r_squared
from longball.pitches import read_pitches
from longball.pitches.fitting import normal
from tests.pitches.test_fitting import CELLS, KINDS, METRES, PRINTED, SPEEDS, draw

pytestmark = pytest.mark.nightly  # of the paper's analysis alone


def laid(table, columns, bin_width=3.0, replicates=2):
    return curves(read_pitches(table, columns, KINDS), bin_width, replicates)


def test_so_does_the_histogram_if_its_bins_are_narrow():
    seeds = 12
    deviations = {name: [] for name in (*SPEEDS, "p")}
    for seed in range(seeds):
        table = draw(1548, seed, METRES)
        fitted = laid(table, METRES, 1.0, 24)
        for name, each in deviations.items():
            found = getattr(fitted.speed, "weight" if name == "p" else name)
            unit = 1.0 if name == "p" else 3.6
            each.append((unit * found.value - PRINTED[name]) / (unit * found.standard_error))
    for name, each in deviations.items():
        z = np.array(each)
        assert abs(z.mean()) < 3.5 / math.sqrt(seeds), name
        # One in 2,000 either way for 12 numbers; the errors themselves are known to 14 %.
        assert 0.35 < z.std() < 1.9, name


def test_shares_that_are_the_printed_density_give_figure_3_back():
    """The paper's fit on its own density: the share of cell j is ψ(j)."""

    def psi(y):
        left, right = (math.exp(-(((y - mean) / 0.77) ** 2) / 2) for mean in (2, 4))
        return (0.52 * left + 0.48 * right) / (math.sqrt(2 * math.pi) * 0.77)

    total = sum(psi(y) for y in range(1, 6))
    counts = [round(1548 * psi(y) / total) for y in range(1, 6)]
    cells = np.repeat([1, 2, 3, 4, 5], counts)
    table = draw(len(cells), 0, CELLS).assign(cell=cells)
    found = laid(table, CELLS)
    at_edges = found.aim_at_edges
    assert at_edges.weight.value == pytest.approx(0.52, abs=0.005)
    assert at_edges.spread.value == pytest.approx(0.77 * total, abs=0.01)  # ψ(1..5) adds to 0.98
    assert (at_edges.left_mean.value, at_edges.right_mean.value) == (2.0, 4.0)
    assert found.r_squared["aim_at_edges"] > 0.99


@pytest.mark.parametrize(("factor", "integral"), [(2, 1.0), (1, INTEGRAL_AS_PRINTED)])
def test_equation_2_with_and_without_its_2(factor, integral):
    v = np.linspace(-60.0, 60.0, 24001)
    y = np.exp(-((v - 1.0) ** 2) / (factor * 4.58**2)) / (math.sqrt(2 * math.pi) * 4.58)
    assert np.trapezoid(y, v) == pytest.approx(integral, rel=1e-9)
    assert normal(v, 1.0, 4.58 * integral, integral) == pytest.approx(y, rel=1e-12)
    found = normal_through(v[::50], y[::50], (0.0, 6.0), integral)
    assert found == pytest.approx((1.0, 4.58 * integral), rel=1e-7)


def test_equation_2_as_printed_cannot_have_given_the_printed_r_squared():
    """Its integral is 1/√2: through a histogram of all pitches it cannot reach 0.9942."""
    for seed in range(5):
        found = laid(draw(1548, seed, METRES), METRES)
        assert found.r_squared["speed"] > 0.975
        assert found.r_squared["speed_as_printed"] < 0.9


def test_wide_bins_widen_the_histogram_fit_as_sheppard_says():
    table = draw(200_000, 3, CELLS)
    for width in (1.0, 5.0):
        fit = laid(table, CELLS, width).speed
        expected = math.sqrt(4.58**2 + width**2 / 12)
        # The rule is of second order in width/σ; the next term is 0.5 % at 5 km/h.
        assert fit.straight_spread.value * 3.6 == pytest.approx(expected, rel=0.01)


def test_r_squared_by_hand():
    assert r_squared(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 4.0])) == 0.5
    assert r_squared(np.array([1.0, 2.0, 3.0]), np.array([2.0, 2.0, 2.0])) == 0.0
