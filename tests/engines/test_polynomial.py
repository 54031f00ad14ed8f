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
from longball.engines.polynomial import Polynomial, PolynomialPiece, advanced, values_at
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


def test_a_start_on_a_turning_point_is_none():
    assert turning_points(np.array([1.0, 0.0, -1.0]), 5.0).tolist() == []
    assert turning_points(np.array([1.0, 0.0, 0.0, -1.0, 1.0]), 5.0) == pytest.approx([0.75])
    assert turning_points(np.array([1.0, 0.0, 0.0, 0.0]), 5.0).tolist() == []


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


def test_whether_a_line_stays_high_is_told_exactly():
    assert stays_high([1.0, -0.5], 1.0)
    assert not stays_high([1.0, -0.5000001], 1.0)
    assert stays_high([1.0, 2.0, -0.5], 1.0)
    assert stays_high([1.0, 0.0, -0.5], 1.0)
    assert not stays_high([1.0, 0.0, -0.5], 1.001)
    assert not stays_high([0.0, 1.0], 1.0)
    assert not stays_high([-1.0, 0.1], 1.0)


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


def test_turning_points_where_an_interval_is_cut():
    """The slope (t - 1/4)(t - 1/2)(t - 3/4) is exactly zero where [0, 1] is halved."""
    p = Series.fromroots([0.25, 0.5, 0.75]).integ().coef
    assert turning_points(p, 1.0) == pytest.approx([0.25, 0.5, 0.75], abs=1e-15)
    # Those at the ends are none: they lie in (0, end).
    assert turning_points(p, 0.75) == pytest.approx([0.25, 0.5], abs=1e-15)
    assert turning_points(shifted(p, 0.25), 0.5) == pytest.approx([0.25], abs=1e-15)
    assert turning_points(np.array([0.0, -1.0, 1.0]), 0.5).tolist() == []


def test_a_turning_point_on_a_cut_that_no_bound_has_to_spare():
    """The slope is (t - 1/2)(3 + 12 t²): about 1/4 it is bounded by exactly its value there."""
    p = np.array([0.0, -1.5, 1.5, -2.0, 3.0])
    assert turning_points(p, 1.0) == pytest.approx([0.5], abs=0)
    assert turning_points(p, 0.5).tolist() == []


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


def test_polynomials_calculate():
    rng = np.random.default_rng(3)
    p, q = rng.normal(0, 1, 4), rng.normal(0, 1, 7)
    a, b = Polynomial(p), Polynomial(q)
    x, y = Series(p), Series(q)
    for found, wanted in [
        (2 * a - b * a + 3, 2 * x - y * x + 3),
        (1 - a, 1 - x),
        (a * a - 0.5, x * x - 0.5),
        (b + a - (-a), y + 2 * x),
    ]:
        np.testing.assert_allclose(found.coefficients, wanted.coef, rtol=1e-14)


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


@pytest.mark.parametrize("length", [1e-3, 0.125, 0.75, 1.0, 3.0, 8.0])
def test_a_curve_from_a_later_time_is_the_same_curve(length):
    """It turns at 1/6, 1/2 and 5/6 of the piece, and falls through zero before the last."""
    turns = np.array([1, 3, 5]) / 6 * length
    p = -Series.fromroots(turns).integ(lbnd=0.0)
    p = p - 0.5 * (p(turns[1]) + p(turns[2]))
    p = p if p(turns[1]) > 0 else -p
    coefficients = np.zeros((4, 5))
    coefficients[1] = p.coef
    piece = PolynomialPiece(7.0, length, PlaneState, coefficients)
    curve = piece.curve(lambda state: state.z)
    assert length / 8 < curve.unit <= 8 * length
    for a, known in ((0.0, turns), (0.25 * length, turns[1:]), (0.6 * length, turns[2:])):
        assert list(curve.turns(a, length)) == pytest.approx(list(known), rel=1e-13)
    assert list(curve.turns(0.25 * length, 0.6 * length)) == pytest.approx([turns[1]], rel=1e-13)
    (fall,) = (r.real for r in p.roots() if turns[1] < r.real < turns[2] and abs(r.imag) < 1e-9)
    assert curve.zero(turns[1], turns[2]) == pytest.approx(fall, rel=1e-13)
    for t in (0.0, 0.3 * length, length):
        assert curve(t) == pytest.approx(p(t), rel=1e-12, abs=1e-14)
    high = piece.curve(lambda state: state.z + 1e4)
    assert high.positive(0.0, length)
    assert high.positive(0.5 * length, length)
    assert not curve.positive(turns[1], turns[2])
    # From where the value is not positive, the zero is there.
    assert curve.zero(turns[2], length) == turns[2]
