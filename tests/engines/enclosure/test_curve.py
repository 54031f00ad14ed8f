"""Zeros and turns of families of polynomials: enclosed, all of them, and told apart if possible."""

from __future__ import annotations

from contextlib import nullcontext

import numpy as np
import pytest
from flint import arb, arb_poly
from hypothesis import given
from hypothesis import strategies as st

from longball.engines.enclosure import Balls
from longball.engines.enclosure.curve import Curve, zeros
from longball.engines.event import first_fall, zero_of
from longball.model.numbers import Undecided


@pytest.fixture(autouse=True)
def _precise():
    with Balls(30).arithmetic():
        yield


def of_roots(*roots):
    p = arb_poly([1])
    for root in roots:
        p *= arb_poly([-arb(root), 1])
    return p


@pytest.mark.parametrize(
    "roots",
    [
        (),
        (0.25,),
        (0.25, 0.5, 0.75),
        (0.5, 0.5 + 2.0**-40),
        (1e-12, 0.3),
        (-0.5, 1.5),
        (0.0,),
        (1.0,),
    ],
)
@pytest.mark.parametrize("sign", [1, -1])
def test_simple_zeros_are_each_in_a_ball_of_their_own(roots, sign):
    inside = [root for root in roots if 0 <= root <= 1]
    found = zeros(sign * of_roots(*roots), arb(0), arb(1))
    assert len(found) == len(inside)
    for ball, root in zip(found, inside, strict=True):
        assert ball.contains(arb(root))
        assert ball.rad() < 1e-30


@pytest.mark.parametrize("roots", [(0.3, 0.3), (0.3, 0.3, 0.3)])
def test_zeros_that_are_not_told_apart_are_in_a_tiny_ball(roots):
    found = zeros(of_roots(*roots), arb(0), arb(1))
    assert any(ball.contains(arb(0.3)) for ball in found)
    # A triple zero is told to the cube root of a rounding, 2^-164.
    assert all(ball.rad() < 1e-15 for ball in found)
    assert len(found) == 1


def test_the_zeros_of_all_members_are_enclosed():
    off = 2.0**-30
    family = arb_poly([arb(0.5, off), -1])
    (ball,) = zeros(family, arb(0), arb(1))
    assert ball.contains(arb(0.5, off))
    assert ball.rad() < 1.01 * off
    assert Curve(family).zero(arb(0), arb(1)).contains(arb(0.5, off))


def test_a_curve_may_start_on_zero_and_on_a_turn():
    curve = Curve(arb_poly([0, 0, -1, 2]))  # -t² (1 - 2 t) turns at 0 and 1/3
    (turn,) = curve.turns(arb(0), arb(1))
    assert turn.contains(arb(1) / 3)
    assert curve.zero(arb(0), turn) == 0
    assert Curve(arb_poly([3])).turns(arb(0), arb(1)) == []


@pytest.mark.parametrize("near", [1e-12, 1e-30, 1e-60])
def test_a_zero_is_as_sharp_however_near_the_beginning_it_is(near):
    """Of t (near - t), which falls from the middle of the two zeros on."""
    zero = Curve(arb_poly([0, near, -1])).zero(arb(near) / 2, arb(1))
    assert zero.contains(arb(near))
    assert zero.rad() < 1e-30 * near


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_zero_between_flat_ends(power):
    # 1 - 2 t^n (…): falls from 1 to -1, flat at both ends for n > 1.
    smooth = {1: [1, -2], 2: [1, 0, -6, 4], 3: [1, 0, 0, -20, 30, -12]}[power]
    zero = Curve(arb_poly(smooth)).zero(arb(0), arb(1))
    assert zero.contains(arb(0.5))
    assert zero.rad() < 1e-30


def test_a_value_that_may_have_fallen_to_zero_before_is_open():
    for middle, is_open in ((0.0, True), (1e-29, False)):
        curve = Curve(arb_poly([arb(middle, 1e-30), -1]))
        with pytest.raises(Undecided, match="whether it rains") if is_open else nullcontext():
            zero_of(curve, arb(0), arb(1), "whether it rains", Balls(30))
    assert Curve(arb_poly([-1, -1])).zero(arb(0), arb(1)) == 0


def test_positive_is_certain_or_not():
    curve = Curve(arb_poly([1, -1]))
    assert curve.positive(arb(0), arb(0.5))
    assert not curve.positive(arb(0), arb(1))
    assert not curve.positive(arb(0.5), arb(2))
    assert not Curve(arb_poly([0])).positive(arb(0), arb(1))


RADII = st.sampled_from((0.0, 2.0**-10, 0.25, 1.0))
HEIGHTS = st.tuples(st.integers(0, 8), RADII)  # a flight does not begin below the ground
COEFFICIENTS = st.tuples(st.integers(-8, 8), RADII)
TIMES = np.linspace(0.0, 1.0, 201)


@given(HEIGHTS, st.lists(COEFFICIENTS, min_size=1, max_size=3), st.booleans(), st.randoms())
def test_the_first_fall_is_that_of_every_member(height, rest, launch, random):
    """Where members differ in whether they fall, or in whether at once, it is not told."""
    family = [height, *rest]
    with Balls(30).arithmetic():
        curve = Curve(arb_poly([arb(middle / 4, radius) for middle, radius in family]))
        try:
            fall = first_fall(curve, arb(1), arb(0), "it falls", Balls(30), launch=launch)
        except Undecided:
            return
        if fall is None and not curve(arb(1)) > 0:
            return  # that the piece ends so is left to the next one
    for _ in range(8):
        member = [middle / 4 + radius * random.uniform(-1, 1) for middle, radius in family]
        values = np.polynomial.Polynomial(member)(TIMES)
        if fall is None:
            assert values.min() > -1e-12
            continue
        assert values[float(fall.lower()) > TIMES].min(initial=1.0) > -1e-12
        assert np.polynomial.Polynomial(member)(float(fall.upper())) < 1e-12
