"""The integrator and the root search of many digits, against exact results."""

import mpmath
import pytest
from mpmath import mpf

from tests import extrapolation

DIGITS = 30


def circles(t, y):
    """Three circles r'' = -r, and a path that grows as e^t."""
    return [*y[3:6], *(-r for r in y[:3]), y[6]]


@pytest.mark.parametrize("asked", [["10"], ["10", "3", "9.5", "1e-20", "-1"]])
def test_a_leg_gives_its_state_at_any_time(asked):
    with mpmath.workdps(DIGITS + extrapolation.SPARE):
        start = [mpf(c) for c in (1, 0, 2, 0, 1, 0, 1)]
        leg = extrapolation.Leg(circles, mpf(0), start)
        for t in map(mpf, asked):
            x, y, z, *_, path = leg.at(t)
            # Some ten steps, each to 30 digits of its size; the path's errors grow as it does.
            assert max(abs(x - mpmath.cos(t)), abs(y - mpmath.sin(t))) < mpf(10) ** (2 - DIGITS)
            assert abs(z - 2 * mpmath.cos(t)) < mpf(10) ** (2 - DIGITS)
            assert abs(path / mpmath.exp(t) - 1) < mpf(10) ** (3 - DIGITS)


def test_a_step_is_cut_where_the_law_has_no_third_derivative():
    """A vertical throw in air: w' = -g - κ|w|w, up by tan, down by tanh."""
    with mpmath.workdps(DIGITS + extrapolation.SPARE):

        def throw(t, y):
            return [mpf(0), mpf(0), y[5], mpf(0), mpf(0), -1 - abs(y[5]) * y[5], abs(y[5])]

        w = mpmath.tan(mpf(1))  # at the top after a second, if g = κ = 1
        leg = extrapolation.Leg(throw, mpf(0), [*map(mpf, (0, 0, 0, 0, 0)), w, mpf(0)])
        assert abs(leg.at(mpf(3))[5] + mpmath.tanh(mpf(2))) < mpf(10) ** (3 - DIGITS)


@pytest.mark.parametrize("depth", ["1", "1e-3", "1e-20"])
def test_a_zero_is_found_however_flat_the_function(depth):
    with mpmath.workdps(DIGITS + extrapolation.SPARE):
        depth = mpf(depth)
        found = extrapolation.zero(lambda t: (t - 2) ** 2 - depth, mpf(0), mpf(2))
        assert abs(found - (2 - mpmath.sqrt(depth))) < mpf(10) ** -DIGITS
        assert extrapolation.zero(lambda t: t, mpf(-1), mpf(0)) == 0
    with pytest.raises(AssertionError, match="no zero"):
        extrapolation.zero(lambda t: t, mpf(1), mpf(2))


def test_a_zero_is_found_beside_a_value_that_is_tiny():
    """The hop of a ball that leaves the ground at 1e-30 m/s: secants begin with steps of 1e-53."""
    with mpmath.workdps(DIGITS + extrapolation.SPARE):
        hop = mpf("1e-30")
        found = extrapolation.zero(lambda t: t * (hop - t), mpf("1e-31"), mpf("1e-8"))
        assert abs(found - hop) < mpf(10) ** (-DIGITS - 2)
