"""Polynomials on a step: no turning point and no zero is missed."""

from fractions import Fraction

import numpy as np
import pytest
from numpy.polynomial import Polynomial as Series

from longball.engines.coefficients import (
    rate,
    shifted,
    stays_high,
    terms,
    turning_points,
    value,
    zero,
)
from longball.engines.polynomial import PolynomialPiece, advanced, values_at
from longball.model.law import PlaneState


def from_roots(rng, degree):
    """A polynomial whose slope has known roots about [0, 1], some of them close to each other."""
    places = np.sort(rng.uniform(-0.5, 1.5, degree - 1))
    if rng.random() < 0.5:
        places[1] = places[0] + 10 ** rng.uniform(-4, -1)
    slope = Series.fromroots(places) * rng.choice([-1, 1])
    return slope.integ(k=rng.normal(0, 0.1)).coef, places


@pytest.mark.parametrize("seed", range(5))
def test_between_turning_points_a_polynomial_only_rises_or_only_falls(seed):
    rng = np.random.default_rng(seed)
    for _ in range(200):
        p, places = from_roots(rng, rng.integers(3, 9))
        found = turning_points(p, 1.0)
        wanted = places[(places > 0) & (places < 1)]
        assert len(found) == len(wanted)
        # A root that has another one close to it is known less well.
        np.testing.assert_allclose(found, np.sort(wanted), atol=1e-8)


def test_a_turning_point_where_the_interval_is_halved():
    for places in ([0.1, 0.5, 0.9], [0.25, 0.5, 0.625], [0.5, 0.75]):
        found = turning_points(Series.fromroots(places).integ().coef, 1.0)
        np.testing.assert_allclose(found, places, atol=1e-12)


def test_a_ball_at_rest_turns_nowhere():
    rest = PolynomialPiece(
        0.0, 60.0, PlaneState, np.array([[1.0, 0.0], [2.0, 0.0]] + [[0.0] * 2] * 2)
    )
    assert rest.at(0.0) == rest.at(33.0) == PlaneState(1.0, 2.0, 0.0, 0.0)
    for height, positive in ((1.0, True), (2.0, False), (3.0, False)):
        curve = rest.curve(lambda state, height=height: state.z - height)
        assert curve(5.0) == 2.0 - height
        assert curve.positive(0.0, 60.0) is positive
        assert curve.turns(0.0, 60.0) == []


def test_what_stays_high_is_above_half_of_its_start():
    rng = np.random.default_rng(1)
    high = 0
    for _ in range(3000):
        p = rng.normal(0, 1, 6) * 0.4 ** np.arange(6)
        p[0] = abs(p[0])
        least = Series(p)(np.linspace(0, 1, 500)).min()
        if stays_high(p, 1.0):
            high += 1
            assert least >= 0.5 * p[0] * (1 - 1e-15)
    assert high > 1000


def test_what_is_computed_of_whole_coefficients_is_exact():
    p, x = [3.0, -5.0, 2.0, 7.0], Series([3.0, -5.0, 2.0, 7.0])
    for t in (0.0, 0.5, 2.0):
        assert value(p, t) == x(t)
        assert rate(p, t) == x.deriv()(t)
        assert terms(p, t) == Series(np.abs(p))(t)
        assert values_at(np.array([p, [1.0, 1.0, 0.0, 0.0]]), t).tolist() == [x(t), 1.0 + t]
    assert list(shifted(np.array(p), 2.0)) == [57.0, 87.0, 44.0, 7.0]


def test_what_rounding_takes_from_a_sum_is_kept():
    rows = np.array([[0.1, 1e-17, 0.0], [1.0, 2.0**-54, 2.0**-60], [1e9, -3.0, 0.7]])
    low = np.array([1e-18, -(2.0**-70), 1e-9])
    end, lost = advanced(rows, 0.5, low)
    for (start, one, two), left, after, lacking in zip(rows, low, end, lost, strict=True):
        change = (two * 0.5 + one) * 0.5 + left
        assert after == start + change
        assert Fraction(after) + Fraction(lacking) == Fraction(start) + Fraction(change)


def test_zeros_at_the_ends_are_found():
    assert zero([0.0, -1.0], 0.0, 1.0) == 0.0
    assert zero([1.0, -1.0], 0.0, 1.0) == 1.0
    assert zero([-0.25, 0.0, 1.0], 0.0, 1.0) == 0.5
    assert zero([0.25, 0.0, -1.0], 0.0, 1.0) == 0.5
    # Flat where Newton's method begins: p' = 0 at the middle.
    assert zero((Series([-0.5, 1.0]) ** 3 - 1e-6).coef, 0.0, 1.0) == pytest.approx(0.51, rel=1e-14)


@pytest.mark.parametrize("order", [1, 3, 5])
def test_a_zero_of_any_order_is_found(order):
    p = (Series([0.7, -1.0]) ** order).coef
    # Where p is less than its rounding, some 1e-16, the place is known to the root of that order.
    assert zero(p, 0.0, 1.0) == pytest.approx(0.7, abs=1e-15 ** (1 / order))


def test_the_value_of_an_event_where_large_terms_cancel():
    """The distance from (18, 0) at the end of a way of 18 m, to the rounding of that distance."""
    coefficients = np.array([[0.0, 40.0], [1e-3, 0.0], [40.0, 0.0], [0.0, 0.0]])
    piece = PolynomialPiece(0.0, 1.0, PlaneState, coefficients)
    curve = piece.curve(lambda y: (y.s - 18) * (y.s - 18) + y.z * y.z)
    (nearest,) = curve.turns(0.0, 1.0)
    assert nearest == pytest.approx(0.45, abs=1e-14)
    assert curve(nearest) == pytest.approx(1e-6, rel=1e-9)


def test_a_touching_far_away_is_found_to_the_rounding_of_the_place():
    """Of reach 2e-5 m, 2e4 m away: the square of the way is rounded to more than reach²."""
    height, reach, speed = 20581.5, 2.4e-5, 4.5e13
    coefficients = np.array([[0.0, 0.0], [0.0, speed], [0.0, 0.0], [speed, 0.0]])
    piece = PolynomialPiece(0.0, 1e-9, PlaneState, coefficients)
    curve = piece.curve(lambda y: (y.z - height) * (y.z - height) - reach * reach)
    (nearest,) = curve.turns(0.0, 1e-9)
    touching = piece.at(curve.zero(0.0, nearest)).z
    assert touching == pytest.approx(height - reach, abs=2 * np.spacing(height))


def test_values_do_not_overflow_where_the_states_do_not():
    """In seconds, a coefficient of 1e200 times a number, or squared, is beyond the range."""
    coefficients = np.array([[0.0, 1e100, 1e200], [3.0, 0.0, 0.0], [0.0] * 3, [0.0] * 3])
    piece = PolynomialPiece(0.0, 1e-99, PlaneState, coefficients)
    curve = piece.curve(lambda y: y.z - (1e110 * y.s) * (1e-110 * y.s))
    assert curve(0.0) == 3.0
    assert not curve.positive(0.0, 1e-99)
    assert list(curve.turns(0.0, 1e-99)) == []
    x = (np.sqrt(1 + 4 * np.sqrt(3)) - 1) / 2  # of x + x² = √3
    assert curve.zero(0.0, 1e-99) == pytest.approx(x * 1e-100, rel=1e-14, abs=0)
