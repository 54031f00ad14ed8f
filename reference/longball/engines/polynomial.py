"""Dual numbers and polynomials for event functions, and pieces of a flight as polynomials."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from longball.engines import coefficients
from longball.engines.coefficients import MOST_NEWTON_STEPS
from longball.engines.compiled import Code
from longball.model.arrays import Array
from longball.model.law import State

# --- arithmetic of event functions ----------------------------------------------------------------


class Arithmetic:
    """The operations of event functions, derived from ``a + b``, ``-a`` and ``a * b``."""

    __slots__ = ()

    def __add__(self, other: Any) -> Any:
        raise NotImplementedError

    def __neg__(self) -> Any:
        raise NotImplementedError

    def __mul__(self, other: Any) -> Any:
        raise NotImplementedError

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other


@dataclass(frozen=True)
class Dual(Arithmetic):
    """A number and its rate of change."""

    value: Any
    rate: Any

    __array_ufunc__ = None  # an array is one number

    def __add__(self, other: Any) -> Dual:
        other = _dual(other)
        return Dual(self.value + other.value, self.rate + other.rate)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.rate)

    def __mul__(self, other: Any) -> Dual:
        other = _dual(other)
        return Dual(self.value * other.value, self.rate * other.value + self.value * other.rate)


def _dual(x: Any) -> Dual:
    return x if isinstance(x, Dual) else Dual(x, 0 * x)


# The functions that a traced law calls, over arrays of doubles. The unit vector of a vector without
# length is zero, as in the other number systems (`longball.model.numbers.ratio`).
ARRAYS: Any = SimpleNamespace(
    functions={
        "sqrt": np.sqrt,
        "exp": np.exp,
        "log": np.log,
        "unit": lambda x, r: np.divide(x, r, out=np.zeros_like(r), where=r != 0),
    }
)


# --- polynomials ----------------------------------------------------------------------------------

# A single value this much smaller than that at the origin would lose six digits and more: in a hop
# of a nanometre off the ground, or at a bat a hundred kilometres up.
_FAR_SMALLER = 2.0**-20
# s; for pieces between these a second is a unit that is about as long.
_SHORT, _LONG = 2.0**-3, 2.0**3  # a free choice
# Newton's method has converged when it moves by less than this fraction of a time on the piece:
# hundreds of roundings, which one more step would square.
_CLOSE_TIMES = 2.0**-44  # a free choice

# A curve takes about 0.1 ms as it is; to compile all of it takes two seconds.
COEFFICIENTS = Code(Path(coefficients.__file__).read_text("utf-8"), 5_000)  # a free choice


def values_at(x: Array, h: float) -> Array:
    """Return the values of polynomials, one a row."""
    run, heights = COEFFICIENTS.now, np.empty(len(x))
    run.values(run.taken(x), h, heights)
    return heights


def advanced(x: Array, h: float, low: Array) -> tuple[Array, Array]:
    """Return the values of polynomials, one for each row, and their rounding errors.

    `low` is the correction of their values at 0, from earlier rounding errors.
    """
    run, end, rounding = COEFFICIENTS.now, np.empty(len(x)), np.empty(len(x))
    run.advance(run.taken(x), h, run.taken(low), end, rounding)
    return end, rounding


@dataclass(eq=False, slots=True)
class Polynomial(Arithmetic):
    """A polynomial in doubles, for the formulas of events: + - * with another or with a number."""

    coefficients: Array  # of t^0, t^1, …

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


@dataclass(eq=False)
class PolynomialCurve:
    """The value of an event along a piece; see `longball.engines.event.Curve`."""

    piece: PolynomialPiece
    value: Callable[[Any], Any]  # of a state
    unit: float  # s, a power of 2 about as long as the piece
    run: ModuleType  # the functions of `longball.engines.coefficients`
    # Of the value, as a polynomial in the time on the piece, in that unit: so they do not overflow
    # where the value does not. Where a distance is small at the end of a long piece they cancel,
    # and so a single value is that of a state; unless it is far smaller than the value at the
    # origin is, whose rounding it would have
    coefficients: Any

    @cached_property
    def _lost(self) -> float:
        """The size of a value that the rounding of a state would drown."""
        origin = self.piece.state(*[0.0] * len(self.piece.coefficients))
        return _FAR_SMALLER * abs(float(self.value(origin)))

    def __call__(self, t: float) -> float:
        """Return the value."""
        if not t:
            return float(self.coefficients[0])
        if self.run.terms(self.coefficients, abs(t) / self.unit) > self._lost:
            return float(self.value(self.piece.at(t)))
        return float(self.run.value(self.coefficients, t / self.unit))

    def _from(self, begin: float) -> Any:
        return (
            self.run.shifted(self.coefficients, begin / self.unit) if begin else self.coefficients
        )

    def positive(self, a: float, b: float) -> bool:
        """See `Curve.positive`."""
        return bool(self.run.stays_high(self._from(a), (b - a) / self.unit))

    def turns(self, a: float, b: float) -> Sequence[float]:
        """See `Curve.turns`."""
        times = self.run.turning_points(self._from(a), (b - a) / self.unit) * self.unit
        return (a + times if a else times).tolist()  # type: ignore[no-any-return]

    def zero(self, a: float, b: float) -> float:
        """See `Curve.zero`."""
        p = self._from(a)
        if not (p[0] > 0 or self(a) > 0):
            return a  # where the piece before ended, to rounding
        # Newton's method on the coefficients first, which is compiled.
        t: float = self.run.zero(p, 0.0, (b - a) / self.unit) * self.unit
        # Then on single values, whose zero may be far from that where large coefficients cancel.
        left, right, close = 0.0, b - a, _CLOSE_TIMES * max(abs(a), abs(b))
        for _ in range(MOST_NEWTON_STEPS):
            height, slope = self(a + t), self.run.rate(p, t / self.unit) / self.unit
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
    """A piece of a flight on which the state is polynomial; see `longball.engines.event.Piece`."""

    # begin, length: s
    begin: float
    length: float
    state: Callable[..., Any]  # the class of the state
    # Shape (components of the state, order + 1): of the powers of the time since `begin`
    coefficients: Array

    def at(self, t: float) -> State:
        """Return the state at a time on the piece, s since it begins."""
        if t == 0.0:
            return self.state(*self.coefficients[:, 0].tolist())
        return self.state(*values_at(self.coefficients, t).tolist())

    def curve(self, value: Callable[[Any], Any]) -> PolynomialCurve:
        """Return the value of an event along the piece."""
        unit, scaled = 1.0, self.coefficients
        if not _SHORT < self.length < _LONG:
            power = math.frexp(self.length)[1]
            columns = np.arange(self.coefficients.shape[1], dtype=np.intc)
            unit, scaled = math.ldexp(1.0, power), np.ldexp(self.coefficients, power * columns)
        along: Polynomial = value(self.state(*map(Polynomial, scaled)))
        run = COEFFICIENTS.count()
        return PolynomialCurve(self, value, unit, run, run.taken(along.coefficients))
