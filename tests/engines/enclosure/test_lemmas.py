"""Each lemma of the enclosure: the bound holds, and cannot be less.

Every lemma is given cases in which the truth is known and comes as close to the bound as `share`
says: a bound that were half as large, or had one of its terms
left out, would be below the truth.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, arb_poly
from hypothesis import given
from hypothesis import strategies as st

from longball.engines.enclosure import Balls, lemmas

UNIT = st.floats(0.01, 1.0)
SMALL = st.floats(1e-6, 1e-3)


@pytest.fixture(autouse=True)
def _precise():
    with Balls(30).arithmetic():
        yield


def holds(bound, truth, share=1.0):
    """True if a truth is within its bound, and at least a share of it."""
    # Radii of balls have 30 bits; doubles are off by some 1e-15 here.
    slack = 2**-24 * abs(float(bound)) + 1e-14
    return share * float(bound) - slack <= float(truth) <= float(bound) + slack


def poly(coefficients):
    return arb_poly([arb(c) for c in coefficients])


# --- sizes of polynomials -------------------------------------------------------------------------


@given(st.lists(st.floats(0, 10), min_size=1, max_size=8), UNIT)
def test_largest_is_attained_if_all_terms_agree(sizes, h):
    with Balls(30).arithmetic():
        value = poly(sizes)(arb(h))
        for sign in (1, -1):
            assert holds(lemmas.largest(sign * poly(sizes), arb(h)), value)


@given(st.lists(st.floats(-10, 10), min_size=1, max_size=8), UNIT)
def test_largest_and_least_hold_everywhere(coefficients, h):
    with Balls(30).arithmetic():
        p = poly(coefficients)
        large, small = lemmas.largest(p, arb(h)), lemmas.least(p, arb(h))
    # Sums and products of doubles are exact in so many digits: the values have no radius of their
    # own, which a bound without slack would not hold.
    with Balls(1000).arithmetic():
        for t in np.linspace(0, h, 9).tolist():
            assert small <= p(arb(t)) <= large
            assert -p(arb(t)) <= large


@given(st.floats(0, 10), st.lists(st.floats(0, 10), max_size=8), UNIT)
def test_least_is_attained_if_all_terms_fall(first, falls, h):
    with Balls(30).arithmetic():
        p = poly([first, *(-fall for fall in falls)])
        assert abs(lemmas.least(p, arb(h)) - p(arb(h))) <= 2**-24 * sum(falls) + 1e-40


# --- errors of nodes ------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(0, 3)), min_size=1, max_size=5))
def test_combination_error_is_attained(terms):
    off = sum(c * math.copysign(e, c) for c, e in terms)
    assert holds(lemmas.combination_error([(arb(c), arb(e)) for c, e in terms]), off)


@given(*[st.sampled_from([0.0, 0.5, 3.0])] * 4)
def test_product_error_is_attained(a, b, error_a, error_b):
    # Each of the three terms alone, too: where a, b or one of the errors is zero.
    off = (a + error_a) * (b + error_b) - a * b
    assert holds(lemmas.product_error(*map(arb, (a, b, error_a, error_b))), off)


@pytest.mark.parametrize(("residual", "error"), [(0.0, 4.0), (4.0, 0.0), (1.0, 3.0), (3.0, 1.0)])
def test_root_error_is_attained_at_zero(residual, error):
    # N = 2 stands for √A with A = N² - r, and A for a = A - e = 0.
    n = math.sqrt(residual + error)
    assert holds(lemmas.root_error(arb(residual), arb(error), arb(n)), n)


@given(UNIT, SMALL, SMALL)
def test_root_error_is_twice_a_small_error(n, residual, error):
    off = n - math.sqrt(n * n - (residual + error) * n * n)
    bound = lemmas.root_error(arb(residual * n * n), arb(error * n * n), arb(n))
    assert holds(bound, off, share=0.5)


@given(*[st.sampled_from([0.0, 0.125, 0.5])] * 3, st.floats(-2, 2), UNIT)
def test_quotient_error_is_attained(residual, error_top, error_bottom, quotient, more):
    # N B = A + r; a = A - e_a; b = B - e_b: all of one sign with N.
    bottom = error_bottom + more
    sign = math.copysign(1.0, quotient)
    top = quotient * bottom + sign * residual  # r = N B - A
    off = abs(quotient - (top + sign * error_top) / (bottom - error_bottom))
    bound = lemmas.quotient_error(
        *map(arb, (residual, abs(quotient), error_top, error_bottom, bottom))
    )
    assert holds(bound, off)


@pytest.mark.parametrize(
    ("start", "residual", "error", "share"),
    [
        (1e-3, 0.0, 0.0, 1.0),
        (0.0, 1e-3, 0.0, 0.6),  # (e^x - 1)/x for e^x, where x <= 0.8
        (0.0, 0.0, 1e-3, 1.0),
        (0.0, 0.0, 1.0, 1.0),
        (1.0, 1.0, 1.0, 0.7),
    ],
)
@pytest.mark.parametrize("rate", [1e-9, 0.4, 1.6])
def test_exponential_error_is_nearly_attained(start, residual, error, share, rate):
    # A = rate t, N' = rate N + r, N(0) = 1 - start: at h, N is too small, and a = A + e is larger.
    h = 0.5
    grown = math.exp(rate * h)
    n = (1 - start) * grown - residual * math.expm1(rate * h) / rate
    off = grown * math.exp(error) - n
    bound = lemmas.exponential_error(*map(arb, (start, residual, rate, error, abs(n), h)))
    own = lemmas.exponential_error(*map(arb, (start, residual, rate, 0.0, abs(n), h)))
    assert holds(own, grown - n, share)
    # |N| + E may be twice e^A, if N is less by E.
    assert off <= float(bound) * (1 + 1e-12)
    if start == residual == 0:
        assert holds(bound, off)


@pytest.mark.parametrize(
    ("start", "residual", "error", "share"),
    [
        (1e-3, 0.0, 0.0, 1.0),
        (0.0, 1e-3, 0.0, 1.0),
        (0.0, 0.0, 1e-3, 0.99),
        (1e-4, 1e-4, 1e-4, 0.99),
    ],
)
def test_logarithm_error_is_nearly_attained(start, residual, error, share):
    # A = 0.5, N' = r / A, N(0) = ln A + start: at h, N is too large, and a = A - e is smaller.
    h, a = 0.25, 0.5
    n = math.log(a) + start + h * residual / a
    bound = lemmas.logarithm_error(*map(arb, (start, residual, error, a, h)))
    assert holds(bound, n - math.log(a - error), share)


def test_nothing_is_known_where_a_divisor_may_vanish():
    one, nothing = arb(1), arb(0)
    for bottom in (arb(0), arb(-1), arb(0, 1)):
        for bound in (
            lemmas.root_error(one, nothing, bottom),
            lemmas.quotient_error(one, one, nothing, nothing, bottom),
            lemmas.logarithm_error(nothing, one, nothing, bottom, one),
        ):
            assert not bound < 1e300
    assert not lemmas.quotient_error(one, one, nothing, arb(2), one) < 1e300
    assert not lemmas.logarithm_error(nothing, nothing, arb(2), one, one) < 1e300


# --- norms ----------------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.floats(-9, 9), st.sampled_from([0.125, 1.0])), min_size=1, max_size=6))
def test_norm_is_attained(parts):
    components, weights = zip(*parts, strict=True)
    truth = math.hypot(*(x * w for x, w in parts))
    assert holds(lemmas.norm([arb(x) for x in components], weights), truth)


def logarithmic_norm(matrix, weights):
    """The largest eigenvalue of the symmetric part of W J W⁻¹, by numpy."""
    scale = np.diag(weights)
    scaled = scale @ matrix @ np.linalg.inv(scale)
    return np.linalg.eigvalsh((scaled + scaled.T) / 2)[-1]


def bounded(matrix, weights):
    return float(
        lemmas.logarithmic_norm([[arb(x) for x in row] for row in matrix.tolist()], weights)
    )


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6])
def test_logarithmic_norm_is_a_bound(n):
    rng = np.random.default_rng(n)
    for _ in range(50):
        matrix, weights = rng.normal(size=(n, n)), rng.choice([0.125, 1.0, 3.0], n)
        truth = logarithmic_norm(matrix, weights)
        assert truth <= bounded(matrix, weights) + 1e-12 * np.abs(matrix).max() * n * 24
        if n <= 2:
            assert bounded(matrix, weights) == pytest.approx(truth, abs=1e-12 * n * 24)


@pytest.mark.parametrize("n", [3, 4, 6])
def test_logarithmic_norm_is_attained_if_all_eigenvalues_but_one_are_equal(n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        along, weights = rng.normal(size=n), rng.choice([0.125, 1.0, 3.0], n)
        turning = rng.normal(size=(n, n))
        scaled = np.outer(along, along) - rng.normal() * np.eye(n) + turning - turning.T
        matrix = np.diag(1 / weights) @ scaled @ np.diag(weights)
        truth = logarithmic_norm(matrix, weights)
        assert bounded(matrix, weights) == pytest.approx(truth, rel=1e-10, abs=1e-10)


def test_logarithmic_norm_of_a_ball_bounds_that_of_its_matrices():
    rng = np.random.default_rng(0)
    middle, off, weights = rng.normal(size=(3, 3)), 0.25, (0.125, 1.0, 1.0)
    ball = [[arb(x, off) for x in row] for row in middle.tolist()]
    bound = float(lemmas.logarithmic_norm(ball, weights))
    for _ in range(50):
        assert logarithmic_norm(middle + rng.uniform(-off, off, (3, 3)), weights) <= bound


# --- growth ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("rates", [[2.0], [2.0, -5.0], [-5.0, 1.0, 0.5], [-1.0], [0.0]])
def test_growth_counts_what_grows(rates):
    found = lemmas.growth([(arb(rate), arb(0.25)) for rate in rates])
    truth = math.exp(0.25 * sum(rate for rate in rates if rate > 0))
    assert holds(found, truth)
    assert not lemmas.growth([(arb("nan"), arb(1))]) < 1e300


@pytest.mark.parametrize(("error", "defect"), [(1.0, 0.0), (0.0, 1.0), (0.3, 0.7), (0.0, 0.0)])
@pytest.mark.parametrize("rate", [1e-6, 0.3, 2.0])
def test_error_bound_is_nearly_attained(error, defect, rate):
    # e' = λ e + δ, to the end of the step: (e^x - 1)/x is more than half of e^x, where x <= 0.6.
    h = 0.25
    growth = lemmas.growth([(arb(rate), arb(h))])
    early, late = lemmas.error_bound(arb(error), arb(defect), growth)
    off = error * math.exp(rate * h) + defect * math.expm1(rate * h) / rate
    assert holds(early + late * h, off, share=1.0 if defect == 0 else 0.75)
    for t in (0.0, 0.1, h):
        e = error * math.exp(rate * t) + defect * math.expm1(rate * t) / rate
        assert e <= float(early + late * t) * (1 + 1e-12)


@pytest.mark.parametrize(("error", "defect"), [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)])
def test_an_error_that_shrinks_is_bounded_without_growth(error, defect):
    early, late = lemmas.error_bound(arb(error), arb(defect), lemmas.growth([(arb(-3), arb(1))]))
    assert (early, late) == (error, defect)
