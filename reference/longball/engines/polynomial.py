"""Pieces of a flight as polynomials in doubles, and the values of events along them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines import roots
from longball.engines.compiled import compiled
from longball.model.law import State
from longball.model.numbers import Undecided

Array = NDArray[np.float64]


class Polynomial:
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

    __radd__ = __add__

    def __neg__(self) -> Polynomial:
        return Polynomial(-self.coefficients)

    def __sub__(self, other: Polynomial | float) -> Polynomial:
        return self + -other

    def __rsub__(self, other: float) -> Polynomial:
        return (-self) + other

    def __mul__(self, other: Polynomial | float) -> Polynomial:
        if isinstance(other, Polynomial):
            return Polynomial(np.convolve(self.coefficients, other.coefficients))
        return Polynomial(self.coefficients * other)

    __rmul__ = __mul__


@dataclass(frozen=True)
class PolynomialCurve:
    """The value of an event along a piece; see `longball.engines.event.Curve`.

    Its turning points and zeros are found by walks that pass none
    (`longball.engines.roots.first_zero`).
    """

    coefficients: Array

    def __call__(self, t: float) -> float:
        """Return the value."""
        return float(roots.value(self.coefficients, len(self.coefficients) - 1, t))

    def _from(self, begin: float) -> Array:
        return self.coefficients if begin == 0 else roots.shifted(self.coefficients, begin)

    def positive(self, a: float, b: float) -> bool:
        """Tell whether the value stays above half of what it is at a, which is positive."""
        return bool(roots.stays_high(self._from(a), b - a))

    def turns(self, a: float, b: float) -> Sequence[float]:
        """Return where in (a, b) the value may turn, in rising order."""
        found: list[float] = roots.turning_points(self._from(a), b - a).tolist()
        if found and found[-1] != found[-1]:
            raise Undecided("where the path turns cannot be decided in double precision")
        return [a + t for t in found] if a else found

    def zero(self, a: float, b: float) -> float:
        """Return where the value is zero, given that from a to b it falls through zero."""
        return a + float(roots.falls(self._from(a), b - a))


@dataclass(frozen=True)
class PolynomialPiece:
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
        found = np.empty(len(self.coefficients))
        advance(self.coefficients, t, np.zeros(len(found)), found)
        state: State[float] = self.state(*found.tolist())
        return state

    def curve(self, value: Callable[[Any], Any]) -> PolynomialCurve:
        """Return the value of an event along the piece."""
        along: Polynomial = value(self.state(*map(Polynomial, self.coefficients)))
        return PolynomialCurve(along.coefficients)


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
