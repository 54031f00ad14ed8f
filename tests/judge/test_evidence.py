"""Bits, fits and round numbers, compared with values computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.judge.diagnosis.evidence import ADEQUATE, BEYOND, cost, fitted, is_adequate, rounded


def test_the_cost_of_errors_in_bits():
    assert cost(np.array([1.0, -1.0, np.nan])) == pytest.approx(1.0)
    assert cost(np.array([[3.0], [math.sqrt(15.0)]])) == pytest.approx(math.log2(10) / 2 + 2)
    # One bit more for a factor of two, until errors are so large that they cost no more.
    assert cost(np.array([2e6])) - cost(np.array([1e6])) == pytest.approx(1.0)
    assert cost(np.array([2 * BEYOND])) == cost(np.array([BEYOND]))


def test_adequate_within_the_noise():
    least, most = np.array([[ADEQUATE, -ADEQUATE, np.nan]]), np.array([[1.001 * ADEQUATE, 0.0]])
    assert is_adequate(least)
    assert not is_adequate(most)
    assert not is_adequate(-most)
    assert not is_adequate(np.full((2, 2), np.nan))
    # A rough edit may leave a twentieth of the numbers in wrong scenes.
    r = np.zeros((2, 40))
    r[0, :2] = 9.0
    wrong = np.arange(40) < 20
    assert is_adequate(r, rough=True)
    assert is_adequate(r, rough=True, wrong=wrong)
    assert not is_adequate(r, rough=True, wrong=np.arange(40) < 19)
    assert not is_adequate(r)


def test_a_fit_finds_the_numbers():
    scenes = np.linspace(1.0, 2.0, 5)

    def curve(c):
        """Two rows, of which one is linear in the numbers and one is not."""
        line = c[:, :1] * scenes + c[:, 1:] - (3.0 * scenes - 2.0)
        return np.stack([line, c[:, :1] ** 3 * scenes - 27.0 * scenes], axis=1)

    c, r, slopes = fitted(curve, [(1.0, 0.0), (2.5, -1.0)])
    assert c == pytest.approx([3.0, -2.0], rel=1e-9)
    assert r.shape == (2, 5)
    assert abs(r).max() < 1e-7
    assert slopes[0, 0] == pytest.approx(scenes, rel=1e-5)
    assert slopes[1, 0] == pytest.approx(1.0, rel=1e-5)
    assert slopes[0, 1] == pytest.approx(27 * scenes, rel=1e-4)

    # Missing values count for nothing, and a start that is worse does not win.
    def holed(c):
        found = curve(c)
        found[:, :, 0] = np.nan
        return found

    assert fitted(holed, [(500.0, 9.0), (2.9, -1.9)])[0] == pytest.approx([3.0, -2.0], rel=1e-7)
    # Without numbers there is nothing to fit.
    assert np.isfinite(fitted(lambda c: np.ones((len(c), 1, 1)), np.zeros((1, 0)))[1]).all()


def test_numbers_whose_scales_differ_are_fitted_together():
    scenes = np.linspace(1.0, 2.0, 5)

    def residual(c):
        return (1e9 * c[:, :1] * scenes + c[:, 1:] * 1e-3 - 2e9 * scenes - 7e-3)[:, None]

    assert fitted(residual, [(1.0, 1.0)])[0][0] == pytest.approx(2.0, rel=1e-9)


def test_a_step_that_is_too_long_is_shortened():
    """On the arctangent, Gauss and Newton's step from 1.5 leads away from 0; a third does not."""
    c, *_ = fitted(lambda c: np.arctan(c)[..., None], [(1.5,)], rounds=9)
    assert abs(c[0]) < 1e-6


def test_round_numbers_are_tried_first():
    every = dict(rounded(9.806652, (9.80665, 9.8, 3.0)))
    assert {9.80665, 9.8, 10.0, 9.81, 9.807, 9.8067, 9.806652, 0.0, 1.0} == every.keys()
    assert every[9.8067] - every[9.807] == pytest.approx(math.log2(10))
    assert every[10.0] < every[9.81] < every[9.807] < every[9.8067]
    assert every[0.0] == every[1.0] < every[10.0]
    pairs = [*rounded(9.806652, (9.80665, 9.8, 3.0))]
    assert (9.80665, pytest.approx(math.log2(3))) in pairs  # one of three usual ones
    assert max(pairs, key=lambda pair: pair[1])[0] == 9.806652
    assert 3.0 not in every
