"""Where an event's polynomial first falls through zero, or comes too close to tell."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from longball.engines.batch.jit import compiled, fma
from longball.engines.batch.roots import (
    LONGEST_WALK,
    NEVER,
    curvature,
    differentiate,
    downward,
    first_zero,
    height_and_rate,
    value,
)

Array = NDArray[np.float64]

# A fall is steep if its rate squared exceeds that many times the strongest bend times the error.
_STEEP = 1e6


@compiled
def two_values(p: Array, q: Array, degree: int, t: float) -> tuple[float, float]:
    """Return p(t) and q(t): even and odd powers apart, which halves the wait for each sum."""
    square = t * t
    odd, odd_too = 0.0, 0.0
    k = degree
    if degree % 2 == 1:
        odd, odd_too = p[k], q[k]
        k -= 1
    even, even_too = p[k], q[k]
    k -= 1
    while k > 0:
        odd, even = fma(odd, square, p[k]), fma(even, square, p[k - 1])
        odd_too, even_too = fma(odd_too, square, q[k]), fma(even_too, square, q[k - 1])
        k -= 2
    return fma(odd, t, even), fma(odd_too, t, even_too)


@compiled
def first_fall(
    p: Array, slope: Array, scratch: Array, degree: int, end: float, error: float
) -> tuple[float, float]:
    """Return where p first falls through zero in [0, end], or NEVER, and NaN.

    Where p has a minimum within `error` of zero, whether it falls through cannot be told: the
    second number is that minimum then, and the first is where it lies. The first number is NaN if
    the walk takes too long.
    """
    sag = downward(slope, degree - 1, end)
    near = first_zero(p, slope, degree, 1.0, error, 0.0, end, sag)
    if error == 0.0 or near == NEVER or math.isnan(near):
        return near, math.nan
    height, rate = height_and_rate(p, slope, degree, near)
    bend = sag + slope[1] + abs(slope[1])  # as `curvature`
    if rate < 0.0 and height <= 2.0 * error and rate * rate > _STEEP * bend * error:
        # Even the strongest bend turns p only far below -error; a step of Newton's method from here
        # is good to 1/_STEEP of the way.
        zero = near - height / rate
        return (zero if zero <= end else NEVER), math.nan
    return _fall_by_pieces(p, slope, scratch, degree, end, error, sag)


@compiled
def _fall_by_pieces(
    p: Array, slope: Array, scratch: Array, degree: int, end: float, error: float, sag: float
) -> tuple[float, float]:
    """Do what `first_fall` does, from one turning point of p to the next."""
    differentiate(slope, degree - 1, scratch)
    bend_of_slope = curvature(scratch, degree - 2, end) if degree > 2 else 0.0
    rising = slope[0] > 0.0 or (slope[0] == 0.0 and scratch[0] > 0.0)
    begin = 0.0
    for _ in range(LONGEST_WALK):
        sign = 1.0 if rising else -1.0
        turn = first_zero(slope, scratch, degree - 1, sign, 0.0, begin, end, bend_of_slope)
        if math.isnan(turn):
            return turn, math.nan
        if not rising:
            least = value(p, degree, min(turn, end))
            if turn != NEVER and abs(least) <= error:
                return turn, least
            if least <= 0.0:
                zero = first_zero(p, slope, degree, 1.0, 0.0, begin, end, sag)
                return (zero if zero < end else end), math.nan
        if turn == NEVER:
            return NEVER, math.nan
        begin = turn
        rising = not rising
    return math.nan, math.nan
