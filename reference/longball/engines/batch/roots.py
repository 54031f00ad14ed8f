"""First roots of a polynomial, none missed.

Every event of a flight is a polynomial p(t) of a step that falls through zero. The search walks
from the left: below the polynomial lies the parabola with its value and slope at t, and with the
lowest curvature that p can have; p has no root before the parabola's. Where p has a simple root
this is Newton's method, from the safe side.
"""

from __future__ import annotations

import math

from longball.engines.batch.jit import fma, inner
from longball.model.arrays import Array

NEVER = math.inf
# A search takes three to six walks; near a double root each halves the rest of the way.
_LONGEST_WALK = 1000  # a free choice
_NOTHING = 1e-17  # of a time: a tenth of its rounding


@inner
def value(p: Array, degree: int, t: float) -> float:
    """Return p(t)."""
    total: float = p[degree]
    for k in range(degree - 1, -1, -1):
        total = fma(total, t, p[k])
    return total


@inner
def two_values(p: Array, q: Array, degree: int, t: float) -> tuple[float, float]:
    """Return p(t) and q(t), such as a slope with a zero behind it as `differentiate` writes it.

    Even and odd powers apart, which halves the wait for each sum.
    """
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


@inner
def differentiate(p: Array, degree: int, derivative: Array) -> None:
    """Write the coefficients of p', and a zero, into `derivative`."""
    for k in range(degree):
        derivative[k] = (k + 1) * p[k + 1]
    derivative[degree] = 0.0


@inner
def curvature(slope: Array, degree: int, end: float) -> float:
    """Return a bound on |p''| over [0, end], from the coefficients of p'."""
    total = 0.0
    for k in range(degree, 0, -1):
        total = fma(total, end, k * abs(slope[k]))
    return total


@inner
def downward(slope: Array, degree: int, end: float) -> float:
    """Return an upper bound on -p'' over [0, end], from the coefficients of p'."""
    total = 0.0
    for k in range(degree, 1, -1):
        total = fma(total, end, k * abs(slope[k]))
    return float(fma(total, end, -slope[1])) if degree > 0 else 0.0


@inner
def first_zero(
    # p, slope: coefficients of p, of degree `degree`, and of p'
    p: Array,
    slope: Array,
    degree: int,
    sign: float,
    level: float,
    begin: float,
    end: float,
    sag: float,  # an upper bound on ``-sign p''`` up to the end
) -> float:
    r"""First time in [begin, end] at which ``sign p`` falls to `level`; NEVER if it does not.

    Each parabola lies below the polynomial, so that its zero comes before the polynomial's:

        *__
         . \__    p
          .   \__
        ---x-----\---- 0
        t  |     root
           next t

    NaN if the walk takes too long, as it does to a triple root.
    """
    t: float = begin
    height, rate = p[0], slope[0]
    for walk in range(_LONGEST_WALK):
        if walk > 0 or begin > 0.0:
            height, rate = two_values(p, slope, degree, t)
        height, rate = sign * height - level, sign * rate
        if height <= 0.0:
            if rate <= 0.0:
                return t
            height = 0.0  # on the way up from a root
        square = rate * rate + 2.0 * sag * height
        if square < 0.0 or (rate > 0.0 and sag <= 0.0):  # the parabola turns up before zero
            return NEVER
        root = math.sqrt(square)
        step = (rate + root) / sag if rate > 0.0 else 2.0 * height / (root - rate)
        stays = t + step == t
        t += step
        if not t <= end:
            return NEVER
        # p'' is at least -sag, and about `2 p''(0) + sag` at most: this is what p may have left
        # above the parabola; its slope is about `root`.
        left = (abs(sag) + abs(slope[1])) * step * step
        if stays or left <= _NOTHING * t * root:
            return t
    return math.nan


# --- the first fall -----------------------------------------------------------------------------

# A fall is steep if its rate squared exceeds that many times the largest curvature times the error.
_STEEP = 1e12
# A fall certainly ends below -error if it is larger than this multiple of the error: 6 would do.
_CERTAIN = 8.0


@inner
def first_fall(p: Array, slope: Array, degree: int, end: float, error: float) -> float:
    r"""Return where p first falls through zero in [0, end], or NEVER; NaN if that is in doubt.

    NaN if p enters the band ±error and does not certainly leave it below:

        \_____/             NEVER
        --------- error
        \_____/             NaN, as for a walk that takes too long
        --------- -error
          \___/             the time at which it falls through zero
    """
    sag = downward(slope, degree - 1, end)
    near = first_zero(p, slope, degree, 1.0, error, 0.0, end, sag)
    if error == 0.0 or near == NEVER or math.isnan(near):
        return near
    height, rate = two_values(p, slope, degree, near)
    most = sag + slope[1] + abs(slope[1])  # as `curvature`
    if rate >= 0.0 or height > 2.0 * error or rate * rate <= _CERTAIN * most * error:
        return math.nan
    if rate * rate <= _STEEP * most * error:
        return first_zero(p, slope, degree, 1.0, 0.0, 0.0, end, sag)
    # Even the largest curvature turns p only far below -error; a step of Newton's method from here
    # is good to 1/_STEEP of the way.
    zero = near - height / rate
    return zero if zero <= end else NEVER
