"""Pieces of a flight as polynomials in doubles, and the values of events along them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.engines.arithmetic import Arithmetic
from longball.engines.compiled import compiled
from longball.model.law import State

Array = NDArray[np.float64]


class Polynomial(Arithmetic):
    """A polynomial in doubles, for the formulas of events: + - * with another or with a number.

    Attributes
    ----------
    coefficients
        Of t^0, t^1, …
    """

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Array) -> None:
        self.coefficients = coefficients

    def __add__(self, other: Polynomial | float) -> Polynomial:
        if not isinstance(other, Polynomial):
            total = self.coefficients.copy()
            total[0] += other
            return Polynomial(total)
        short, long = sorted((self.coefficients, other.coefficients), key=len)
        total = long.copy()
        total[: len(short)] += short
        return Polynomial(total)

    def __neg__(self) -> Polynomial:
        return Polynomial(-self.coefficients)

    def __mul__(self, other: Polynomial | float) -> Polynomial:
        if isinstance(other, Polynomial):
            return Polynomial(np.convolve(self.coefficients, other.coefficients))
        return Polynomial(self.coefficients * other)


class PolynomialCurve(NamedTuple):
    """The value of an event along a piece; see `longball.engines.event.Curve`.

    Attributes
    ----------
    piece
    value
        Of a state.
    unit
        s, a power of 2 no shorter than the piece.
    coefficients
        Of the value, as a polynomial in the time on the piece, in that unit: so they do not
        overflow where the value does not. Where a distance is small at the end of a long piece they
        cancel, and so a single value is that of a state; unless it is far smaller than the
        value at the origin is, whose rounding it would have.
    """

    piece: PolynomialPiece
    value: Callable[[Any], Any]
    unit: float
    coefficients: Array

    def __call__(self, t: float) -> float:
        """Return the value."""
        if t:
            terms = value(abs(self.coefficients), abs(t) / self.unit)
            origin = self.piece.state(*[0.0] * len(self.piece.coefficients))
            if terms > _FAR_SMALLER * abs(float(self.value(origin))):
                return float(self.value(self.piece.at(t)))
        return value(self.coefficients, t / self.unit)

    def _from(self, begin: float) -> Array:
        return shifted(self.coefficients, begin / self.unit) if begin else self.coefficients

    def positive(self, a: float, b: float) -> bool:
        """Tell whether the value stays above half of what it is at a, which is positive."""
        return stays_high(self._from(a), (b - a) / self.unit)

    def turns(self, a: float, b: float) -> Sequence[float]:
        """Return where in (a, b) the value may turn, in rising order."""
        found = turning_points(self._from(a), (b - a) / self.unit) * self.unit
        return (a + found if a else found).tolist()  # type: ignore[no-any-return]

    def zero(self, a: float, b: float) -> float:
        """Return where the value is zero, given that from a to b it falls through zero."""
        p = self._from(a)
        if not p[0] > 0:
            return a  # where the piece before ended, to rounding
        t = zero(p, 0.0, (b - a) / self.unit) * self.unit
        # On to the zero of single values, which may be far where large coefficients cancel.
        left, right, close = 0.0, b - a, _CLOSE_TIMES * max(abs(a), abs(b))
        for _ in range(_MOST_NEWTON_STEPS):
            height, slope = self(a + t), rate(p, t / self.unit) / self.unit
            if height == 0:
                break
            left, right = (t, right) if height > 0 else (left, t)
            following = t - height / slope if slope < 0 else math.nan
            if abs(following - t) <= close:
                t = following
                break
            t = following if left < following < right else 0.5 * (left + right)
        return min(max(a + t, a), b)


class PolynomialPiece(NamedTuple):
    """A piece of a flight on which the state is polynomial; see `longball.engines.event.Piece`.

    Attributes
    ----------
    begin, length
        s.
    state
        The class of the state.
    coefficients
        Shape (components of the state, order + 1): of the powers of the time since `begin`.
    """

    begin: float
    length: float
    state: Callable[..., Any]
    coefficients: Array

    def at(self, t: float) -> State[float]:
        """Return the state at a time on the piece, s since it begins."""
        if t == 0.0:
            start: State[float] = self.state(*self.coefficients[:, 0].tolist())
            return start
        found = np.empty(len(self.coefficients))
        advance(self.coefficients, t, np.zeros(len(found)), found)
        state: State[float] = self.state(*found.tolist())
        return state

    def curve(self, value: Callable[[Any], Any]) -> PolynomialCurve:
        """Return the value of an event along the piece."""
        power = math.frexp(self.length)[1]
        columns = np.arange(self.coefficients.shape[1], dtype=np.intc)
        scaled = np.ldexp(self.coefficients, power * columns)
        along: Polynomial = value(self.state(*map(Polynomial, scaled)))
        return PolynomialCurve(self, value, math.ldexp(1.0, power), along.coefficients)


# --- compiled: a polynomial is an array of its coefficients ---------------------------------------


@compiled
def advance(x: Array, h: float, low: Array, end: Array) -> None:
    """Sum the polynomials `x` at `h`: ``end + low``, where `end` is rounded.

    On entry, `low` is what their values at 0 lack of the true ones.
    """
    for i in range(len(end)):
        total = 0.0
        for k in range(x.shape[1] - 1, 0, -1):
            total = total * h + x[i, k]
        change = total * h + low[i]
        start = x[i, 0]
        end[i] = start + change
        taken = end[i] - start
        low[i] = (start - (end[i] - taken)) + (change - taken)


@compiled
def value(p: Array, t: float) -> float:
    """Return p(t)."""
    total = 0.0
    for k in range(len(p) - 1, -1, -1):
        total = total * t + p[k]
    return total


@compiled
def rate(p: Array, t: float) -> float:
    """Return p'(t)."""
    total = 0.0
    for k in range(len(p) - 1, 0, -1):
        total = total * t + k * p[k]
    return total


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
    return p[0] > 0.0 and p[0] + 2.0 * least * end >= 0.0  # type: ignore[no-any-return]


@compiled
def zero(p: Array, left: float, right: float) -> float:
    """Return the zero of p in [left, right], given that p only rises there, or only falls.

    Newton's method, by halves where it would leave the interval.
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
        if not left < following < right or steps > _MOST_NEWTON_STEPS:
            following = middle
        if abs(following - t) <= _ROUNDING * t:
            return following
        t = following


_ROUNDING = 2.0**-53
# Of six digits and more that a single value would lose: a hop of a nanometre off the ground, or a
# bat that is met a hundred kilometres up.
_FAR_SMALLER = 2.0**-20
# Six are enough at a simple zero; rounding could lead Newton's method on without end.
_MOST_NEWTON_STEPS = 50
# Of the times on a piece: hundreds of roundings. Newton's method doubles the digits, so that what
# moves by less is there.
_CLOSE_TIMES = 2.0**-44
# Between turning points that are this close, relative to the step, a polynomial changes by less
# than its rounding: by the cube of it.
_CLOSE = 1e-6


@compiled
def turning_points(p: Array, end: float) -> Array:
    """Return where p may turn in (0, end), in rising order.

    The interval is halved until the slope p' certainly has no zero in a part, or one at most.
    """
    slope = np.empty(len(p) - 1)
    for k in range(len(slope)):
        slope[k] = (k + 1) * p[k + 1]
    points = [0.0]
    parts = [(0.0, end)]
    while len(parts) > 0:
        left, right = parts.pop()
        half = 0.5 * (right - left)
        q = shifted(slope, left + half)
        change, bend = 0.0, 0.0  # of the slope from the middle; of its rate
        for k in range(len(q) - 1, 0, -1):
            change = (change + abs(q[k])) * half
            bend = bend * half + (k * abs(q[k]) if k > 1 else 0.0)
        if abs(q[0]) > change * (1.0 + 4 * len(q) * _ROUNDING):
            continue
        if len(q) > 1 and abs(q[1]) >= bend:
            first, last = value(slope, left), value(slope, right)
            if first != 0.0 and last != 0.0 and (first > 0.0) != (last > 0.0):
                points.append(zero(slope, left, right))
            elif last == 0.0 and right < end:
                points.append(right)
        elif half < _CLOSE * end:
            points.append(left + half)
        else:
            parts.append((left + half, right))
            parts.append((left, left + half))
    return np.array(points[1:])
