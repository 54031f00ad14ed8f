"""Functions of polynomials, given by their coefficients; compiled after enough work.

This source runs in a separate namespace (`longball.engines.compiled.Code`): as Python on lists of
numbers, and compiled on arrays of doubles. Results are written into given arrays, because in
compiled code the allocation of an array takes as long as the sum of a polynomial.
"""

from __future__ import annotations

from typing import Any

import numpy as np

_ROUNDING = 2.0**-53
# Six are enough at a simple zero; rounding could lead Newton's method on without end.
MOST_NEWTON_STEPS = 50  # a free choice
# Between turning points that are this close, relative to the step, a polynomial changes by less
# than its rounding: by the cube of it.
_CLOSE = 1e-6  # a free choice


def values(x: Any, h: float, out: Any) -> None:
    """Evaluate polynomials, the rows of `x`, at `h`."""
    for i in range(len(x)):
        out[i] = x[i][0] + _change(x[i], h)


def advance(x: Any, h: float, low: Any, end: Any, rounding: Any) -> None:
    """Evaluate polynomials, the rows of `x`, at `h`: rounded values, and their rounding errors.

    `low` has the rounding errors of the values at 0.
    """
    # Knuth's sum of two numbers: over dozens of steps only the errors of the changes add up, which
    # are smaller than the values.
    for i in range(len(x)):
        change = _change(x[i], h) + low[i]
        start = x[i][0]
        after = start + change
        taken = after - start
        end[i] = after
        rounding[i] = (start - (after - taken)) + (change - taken)


def _change(p: Any, t: float) -> float:
    """Return p(t) - p(0)."""
    total = 0.0
    for k in range(len(p) - 1, 0, -1):
        total = total * t + p[k]
    return total * t


def value(p: Any, t: float) -> float:
    """Return p(t)."""
    total = 0.0
    for k in range(len(p) - 1, -1, -1):
        total = total * t + p[k]
    return total


def terms(p: Any, t: float) -> float:
    """Return the sum of the sizes of the terms of p(t), where t is not negative."""
    total = 0.0
    for k in range(len(p) - 1, -1, -1):
        total = total * t + abs(p[k])
    return total


def rate(p: Any, t: float) -> float:
    """Return p'(t)."""
    total = 0.0
    for k in range(len(p) - 1, 0, -1):
        total = total * t + k * p[k]
    return total


def shifted(p: Any, begin: float) -> Any:
    """Return the coefficients in powers of ``t - begin``."""
    q = p.copy()
    for first in range(len(q) - 1):
        for k in range(len(q) - 2, first - 1, -1):
            q[k] += begin * q[k + 1]
    return q


def stays_high(p: Any, end: float) -> bool:
    """True if p certainly stays above p(0)/2 > 0 on [0, end].

    A bound from below: in ``p(t) = p_0 + t (p_1 + t (…))``, each bracket is at least its constant
    plus ``min(0, least of the next one) · end``.
    """
    least = 0.0
    for k in range(len(p) - 1, 0, -1):
        least = p[k] + min(0.0, least * end)
    return p[0] > 0.0 and p[0] + 2.0 * least * end >= 0.0  # type: ignore[no-any-return]


def zero(p: Any, left: float, right: float) -> float:
    """Return the zero of p in [left, right], where p is monotonic.

    Newton's method, with a bisection where it would leave the bracket.
    """
    height = value(p, left)
    if height == 0.0:
        return left
    t = 0.5 * (left + right)
    steps = 0
    while True:
        steps += 1
        here, slope = value(p, t), rate(p, t)
        if (here > 0.0) == (height > 0.0):
            left = t
        else:
            right = t
        middle = 0.5 * (left + right)
        if here == 0.0 or not left < middle < right:
            return t if here == 0.0 else right
        following = t - here / slope if slope != 0.0 else middle
        if not left < following < right or steps > MOST_NEWTON_STEPS:
            following = middle
        if abs(following - t) <= _ROUNDING * t:
            return following
        t = following


def turning_points(p: Any, end: float) -> Any:
    """Candidate turning points of p in (0, end), in rising order.

    The interval is halved until the slope p' certainly has no zero in a part, or one at most: by
    its Taylor series at the middle, whose first term, or the first of its rate, exceeds the rest.
    """
    slope = p[1:].copy()
    for k in range(len(slope)):
        slope[k] = (k + 1) * p[k + 1]
    points = [0.0]
    parts = [(0.0, end)]
    while len(parts) > 0:
        left, right = parts.pop()
        half = 0.5 * (right - left)
        q = shifted(slope, left + half)
        change, curvature = 0.0, 0.0  # of the slope from the middle; of its rate
        for k in range(len(q) - 1, 0, -1):
            change = (change + abs(q[k])) * half
            curvature = curvature * half + (k * abs(q[k]) if k > 1 else 0.0)
        # no zero of the slope: its value in the middle exceeds all that it can change by; or it is
        # zero everywhere, and nothing turns
        if abs(q[0]) > change * (1.0 + 4 * len(q) * _ROUNDING) or q[0] == change == 0.0:
            continue
        # one zero at most: the slope is monotonic, and the signs at the ends decide
        if len(q) > 1 and abs(q[1]) >= curvature:
            first, last = value(slope, left), value(slope, right)
            if first != 0.0 and last != 0.0 and (first > 0.0) != (last > 0.0):
                points.append(zero(slope, left, right))
            elif last == 0.0 and right < end:
                points.append(right)
        # several, but so close that it does not matter which of them is reported
        elif half < _CLOSE * end:
            points.append(left + half)
        else:
            parts.append((left + half, right))
            parts.append((left, left + half))
    return np.array(points[1:])
