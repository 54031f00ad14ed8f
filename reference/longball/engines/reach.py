"""Length of the steps of Taylor's method: the reach of a series.

`longball.engines.taylor` prints this source before the recurrence of a law, so that both compile
together (`longball.engines.compiled.Code`). Its arguments are lists of numbers or, compiled, arrays
of doubles.
"""

from __future__ import annotations

from math import inf, nan, sqrt
from typing import Any

_SMALLEST = 2.0**-1022  # smallest normal double


def reach_of_terms(x: Any, order: int, rtol: float, changing: tuple[int, ...]) -> float:
    """Return the time for which the last terms of the series are small, s; NaN beyond doubles.

    Two conditions limit the last two terms in the rows `changing`: as vectors they are below `rtol`
    times the first term that is not zero; and in each component they are below `rtol` times the
    largest term, so that a slow drift is as accurate as the whole flight.

    The series of a circle converges for all times, and these conditions would allow half a turn,
    with large terms and rounding errors. The second-order term is therefore limited to twice the
    size, and a step to a third of a turn.
    """
    reach, power = inf, 0
    size, curvature = total(x, 0, changing), total(x, 2, changing)
    # the circle: |x_2| t² <= 2 |x_0|
    if size == 0.0:
        size, power = total(x, 1, changing), 1
    elif curvature > 0.0:
        reach = sqrt(2.0 * size / curvature)
    # Two terms, as by symmetry every other one may be zero.
    for n in (order - 1, order):
        last = total(x, n, changing)
        if not last < inf:
            return nan
        if last > 0.0:
            reach = min(reach, (rtol * size / last) ** (1.0 / (n - power)))
    # Each component by itself: `own` is its largest term at the reach, by Horner's rule with max.
    for i in changing:
        for n in (order - 1, order):
            last, own = abs(x[i][n]), 0.0
            if last == 0.0:
                continue
            for k in range(n - 1, -1, -1):
                own = max(own * reach, abs(x[i][k]))
            if rtol * own > _SMALLEST:
                reach = min(reach, (rtol * own / last) ** (1.0 / n))
    return reach


def total(x: Any, n: int, rows: tuple[int, ...]) -> float:
    """Return the sum of the sizes of the coefficients n of some rows."""
    result = 0.0
    for i in rows:
        result += abs(x[i][n])
    return result


# The series of a square root converges up to the complex zeros of its argument, even where that
# singularity is too weak to show in the last terms. V² ≈ V₀² + S₁ t + S₂ t² has them at a distance
# of V₀/√S₂ from a time at which V is least; V of a vector v + a t, at V₀/|a|. A step stays within
# half of the larger of the two.


def reach_of_root(reach: float, x: Any, root: int, parts: tuple[int, ...] | None) -> float:
    """Return a reach, s, shortened to half the distance to the zeros of the argument of a root.

    The rows of the root V and of the components of the vector that it is the size of, if it is one.
    """
    size = x[root][0]
    curvature = abs(x[root][1] * x[root][1] + 2.0 * size * x[root][2])  # S₂
    if parts is not None:
        square = 0.0  # of a
        for i in parts:
            square += x[i][1] * x[i][1]
        curvature = min(curvature, square)
    return min(reach, 0.5 * size / sqrt(curvature)) if curvature != 0.0 else reach


# A drag crisis of width δ is a step of ``1/(1 + e^x)`` with ``x = (U - U_c)/δ``. Far from it, all
# terms up to the order N are smaller than those of drag, while the terms beyond N are not: the
# series would jump over the crisis. The last term of e^-x at ``|x| = 2 N - 10`` is about
# ``(0.7 t/t_0)^N``, where t_0 is the time at which x is 0: from there on it limits the step.


def reach_of_crisis(reach: float, x: Any, exponent: int, order: int) -> float:
    """Return a reach, s, shortened so that a far exponent stays larger than ``2 N - 10``.

    The row of the exponent. Its first two terms get half of the way each.
    """
    room = 0.5 * (abs(x[exponent][0]) - (2.0 * order - 10.0))
    rate, bend = abs(x[exponent][1]), abs(x[exponent][2])
    if room > 1.0 and rate > 0.0:
        reach = min(reach, room / rate)
    if room > 1.0 and bend > 0.0:
        reach = min(reach, sqrt(room / bend))
    return reach
