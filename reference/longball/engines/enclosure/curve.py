"""Pieces of a flight as families of polynomials, and the zeros of such a family.

A *family* is a polynomial whose coefficients are balls: its members are the polynomials with
coefficients in them. A state, and the value of an event, is on a piece at every time the value of
some member, though not of the same one at all times: an error that depends on time is in the balls
like any other. So whatever holds for all members holds for the value. Where every member is
positive it is positive; and all its zeros are zeros of members, which Newton's method over the
family encloses.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb, arb_poly

from longball.engines.enclosure.defect import leading
from longball.model.law import State

# A piece without a clear sign is cut here: not at a half, where a round number may be a zero.
_CUT = 0.4871


@dataclass(frozen=True)
class Curve:
    """The value of an event along a piece, as a family of polynomials.

    `first` is the value at 0. A launch is exact, and there the family, which has the error of a
    step, would leave in doubt what begins on a surface.
    """

    value: arb_poly
    first: arb | None = None

    def __call__(self, t: arb) -> arb:
        """Return a ball that contains the values at all times of `t`."""
        return self.first if self.first is not None and t == 0 else self.value(t)

    def positive(self, a: arb, b: arb) -> bool:
        """True if the value is certainly positive from a to b."""
        return bool(self.value(a.union(b)) > 0)

    def turns(self, a: arb, b: arb) -> Sequence[arb]:
        """Enclose the turning points in (a, b); those that are not separated share one ball."""
        slope = self.value.derivative()
        power = leading(slope)
        if power is None:
            return []
        # The zeros at the beginning of the piece are none within it.
        slope = slope.right_shift(power)
        return zeros(slope, a.lower(), b.upper())

    def zero(self, a: arb, b: arb) -> arb:
        """Enclose the zeros of members, which all fall from a to b; a, if none starts above zero.

        It is certain at a on which side of zero the value is.
        """
        if self(a) <= 0:
            return a
        low, high = a.lower(), b.upper()
        slope = self.value.derivative()
        # By signs first: a zero may be nearer to an end than any part of the whole is short.
        while not slope(low.union(high)) < 0:
            middle = _cut(low, high)
            there = self.value(middle)
            if not _clear(there):
                break
            low, high = (middle, high) if there > 0 else (low, middle)
        first, *more = zeros(self.value, low, high)
        return more[-1].union(first) if more else first


def zeros(value: arb_poly, a: arb, b: arb) -> list[arb]:
    """Return balls, in rising order, that contain all zeros of a family's members in [a, b].

    Zeros that are not separated share one ball; a ball may contain none.
    """
    slope = value.derivative()
    curvature = slope.derivative()
    smallest = (b - a) * arb(2) ** (-flint.ctx.prec // 2)  # a free choice
    enclosed: list[arb] = []
    parts = [(a, b)]
    while parts:
        a, b = parts.pop()
        part, middle = a.union(b), _cut(a, b)
        if _clear(value(part)):
            continue
        # In mean-value form, sharp where the family is flat.
        there = value(middle) + (slope(middle) + curvature(part) * (part - middle)) * (
            part - middle
        )
        if _clear(there):
            continue
        rate = slope(part)
        if _clear(rate):
            falling, falling_slope = (value, slope) if rate < 0 else (-value, -slope)
            if falling(a) < 0 or falling(b) > 0:
                continue
            with suppress(ValueError):  # of an empty intersection: no member has a zero there
                _add(_newton(falling, falling_slope, a, b), enclosed)
            continue
        # Where a value at one time is as uncertain as on all of a part, cutting tells no more.
        if b - a > smallest and there.rad() > 2 * value(middle).rad():
            parts += [(middle, b), (a, middle)]
        else:
            _add(part, enclosed)
    return enclosed


def _add(ball: arb, others: list[arb]) -> None:
    """Add a ball to others before it, or make it one with the last, if they overlap."""
    if others and others[-1].overlaps(ball):
        ball = others.pop().union(ball)
    others.append(ball)


def _clear(x: arb) -> bool:
    return bool(x > 0 or x < 0)


def _cut(a: arb, b: arb) -> arb:
    return (a + (b - a) * _CUT).mid()


def _newton(value: arb_poly, slope: arb_poly, a: arb, b: arb) -> arb:
    """Enclose the zeros in [a, b] of members whose slopes are all negative there."""
    root = a.union(b)
    while True:
        middle = min(max(root.mid(), a), b)
        there = value(middle)
        closer = root.intersection(middle - there / slope(root))
        if not 2 * closer.rad() < root.rad():
            # So flat at one end that its slope says little: the sign at the middle says half.
            if there > 0:
                closer = middle.union(root.upper())
            elif there < 0:
                closer = root.lower().union(middle)
            if not 1.5 * closer.rad() < root.rad():  # a free choice
                return closer
        root = closer


@dataclass(frozen=True)
class EnclosedPiece:
    """A piece of a flight."""

    # begin, length: s; `begin` since the launch
    begin: arb
    length: arb
    # The components of the state as families of polynomials in the time since `begin`. They hold
    # for as much longer than `length` as `begin` is uncertain
    families: State
    start: State  # the state at `begin`

    def at(self, t: arb) -> State:
        """Return balls that contain the states at all times of `t`, s since `begin`."""
        if t == 0:
            return self.start
        return type(self.families)(*(family(t) for family in self.families))

    def curve(self, value: Callable[[Any], Any]) -> Curve:
        """Return the value of an event along the piece."""
        return Curve(value(self.families), value(self.start))
