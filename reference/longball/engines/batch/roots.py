"""First roots of a polynomial, none missed.

Every event of a flight is a polynomial p(t) of a step that falls through zero. The search walks
from the left: below the polynomial lies the parabola with its value and slope at t, and with the
lowest curvature that p can have; p has no root before the parabola's. Where p has a simple root
this is Newton's method, from the safe side.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from longball.engines.batch.jit import compiled, fma

Array = NDArray[np.float64]

NEVER = math.inf
# A search takes three to six walks; near a double root each halves the rest of the way.
LONGEST_WALK = 1000
_NOTHING = 1e-17  # of a time: a tenth of its rounding


@compiled
def value(p: Array, degree: int, t: float) -> float:
    """Return p(t)."""
    total: float = p[degree]
    for k in range(degree - 1, -1, -1):
        total = fma(total, t, p[k])
    return total


@compiled
def height_and_rate(p: Array, slope: Array, degree: int, t: float) -> tuple[float, float]:
    """Return p(t) and p'(t): even and odd powers apart, which halves the wait for each sum."""
    square = t * t
    even, odd, even_rate, odd_rate = 0.0, 0.0, 0.0, 0.0
    k = degree
    if degree % 2 == 0:
        even = p[k]
        k -= 1
    else:
        odd, even, even_rate = p[k], p[k - 1], slope[k - 1]
        k -= 2
    while k > 0:
        odd, even = fma(odd, square, p[k]), fma(even, square, p[k - 1])
        odd_rate, even_rate = (
            fma(odd_rate, square, slope[k]),
            fma(even_rate, square, slope[k - 1]),
        )
        k -= 2
    return fma(odd, t, even), fma(odd_rate, t, even_rate)


@compiled
def differentiate(p: Array, degree: int, derivative: Array) -> None:
    """Write the coefficients of p' into `derivative`."""
    for k in range(degree):
        derivative[k] = (k + 1) * p[k + 1]


@compiled
def curvature(slope: Array, degree: int, end: float) -> float:
    """Return a bound on |p''| over [0, end], from the coefficients of p'."""
    total = 0.0
    for k in range(degree, 0, -1):
        total = fma(total, end, k * abs(slope[k]))
    return total


@compiled
def downward(slope: Array, degree: int, end: float) -> float:
    """Return an upper bound on -p'' over [0, end], from the coefficients of p'."""
    total = 0.0
    for k in range(degree, 1, -1):
        total = fma(total, end, k * abs(slope[k]))
    return float(fma(total, end, -slope[1])) if degree > 0 else 0.0


@compiled
def first_zero(
    p: Array,
    slope: Array,
    degree: int,
    sign: float,
    level: float,
    begin: float,
    end: float,
    bend: float,
) -> float:
    """Return where ``sign p - level`` first falls to zero in [begin, end], or NEVER.

    NaN if the walk takes too long, as it does to a triple root.

    Parameters
    ----------
    p, slope
        Coefficients of p, of degree `degree`, and of p'.
    bend
        An upper bound on ``-sign p''`` up to the end.
    """
    t: float = begin
    height, rate = p[0], slope[0]
    for walk in range(LONGEST_WALK):
        if walk > 0 or begin > 0.0:
            height, rate = height_and_rate(p, slope, degree, t)
        height, rate = sign * height - level, sign * rate
        if height <= 0.0:
            if rate <= 0.0:
                return t
            height = 0.0  # on the way up from a root
        square = rate * rate + 2.0 * bend * height
        if square < 0.0 or (rate > 0.0 and bend <= 0.0):  # the parabola turns up before zero
            return NEVER
        root = math.sqrt(square)
        step = (rate + root) / bend if rate > 0.0 else 2.0 * height / (root - rate)
        stays = t + step == t
        t += step
        if not t <= end:
            return NEVER
        # Above the parabola p has at most `bend step²` left here, and its slope is about `root`.
        if stays or abs(bend) * step * step <= _NOTHING * t * root:
            return t
    return math.nan


# --- what is asked of a polynomial, once for each step -------------------------------------------


@compiled
def shifted(p: Array, begin: float) -> Array:
    """Return the coefficients in powers of ``t - begin``."""
    q = p.copy()
    for first in range(len(q) - 1):
        for k in range(len(q) - 2, first - 1, -1):
            q[k] += begin * q[k + 1]
    return q


@compiled
def stays_high(p: Array, end: float) -> bool:
    """Tell whether p certainly stays above p(0)/2 > 0 on [0, end].

    From ``p(t) = p_0 + t (p_1 + t (…))``, with the least that each bracket can be.
    """
    least = 0.0
    for k in range(len(p) - 1, 0, -1):
        least = p[k] + min(0.0, least * end)
    return bool(p[0] > 0.0 and p[0] + 2.0 * least * end >= 0.0)


# Between a turning point and one that is so close, relative to the step, a polynomial changes by
# less than its rounding: by the cube of this.
_CLOSE = 1e-6


@compiled
def turning_points(p: Array, end: float) -> Array:
    """Return where p may turn in (0, end), in rising order; with a nan if that cannot be told."""
    degree = len(p) - 1
    slope, second = np.zeros(degree + 1), np.zeros(degree + 1)
    differentiate(p, degree, slope)
    differentiate(slope, degree - 1, second)
    bend = curvature(second, degree - 2, end)
    points = np.empty(degree)
    count = 0
    begin, rate = 0.0, slope[0] if slope[0] != 0.0 else second[0]
    if rate == 0.0:
        begin = _CLOSE * end
        rate = value(slope, degree - 1, begin)
    while count < degree and begin < end:
        sign = 1.0 if rate > 0.0 else -1.0
        turn = first_zero(slope, second, degree - 1, sign, 0.0, begin, end, bend)
        if not turn < end:
            if math.isnan(turn):
                points[count] = turn
                count += 1
            break
        if turn > 0.0:
            points[count] = turn
            count += 1
        begin = turn + _CLOSE * end
        rate = value(slope, degree - 1, begin)
    return points[:count]


@compiled
def falls(p: Array, end: float) -> float:
    """Return where p is zero in [0, end], given that it only falls there, from p(0) >= 0."""
    degree = len(p) - 1
    if p[0] <= 0.0:
        return 0.0
    slope = np.zeros(degree)
    differentiate(p, degree, slope)
    zero = first_zero(p, slope, degree, 1.0, 0.0, 0.0, end, downward(slope, degree - 1, end))
    if zero <= end:
        return zero
    # Only rounding, or a zero of high order, keeps the walk from it.
    left, right = 0.0, end
    while True:
        middle = 0.5 * (left + right)
        if not left < middle < right:
            return right
        if value(p, degree, middle) > 0.0:
            left = middle
        else:
            right = middle
