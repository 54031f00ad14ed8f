"""Any number of digits, by mpmath: the second opinion on every digit of the golden data.

It proves nothing, but shares nothing with the engine that does: no recurrence for Taylor
coefficients, no step from a radius of convergence, no interval root. Flights are chains of
polynomials (`longball.engines.collocation`). An event is sought over a whole polynomial at once:
the turning points of its function, all of which an eigenvalue problem gives, divide the segment
into pieces on which the function only rises or only falls, so that its signs at their ends tell
every crossing, and none can hide between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, pairwise
from operator import itemgetter
from typing import cast

import numpy as np
from mpmath import MPContext

from longball.engines import contact
from longball.engines.collocation import (
    Array,
    Collocation,
    Mpf,
    Rule,
    Segment,
    State,
    dynamics,
    gauss_legendre,
    upright_dynamics,
)
from longball.engines.engine import Arrival, BatSection, CannotSolve, Stop, Stops, Touch
from longball.model.motion import Forces, acceleration
from longball.model.numbers import Undecided
from longball.model.result import Bounded

# Digits beyond those that are printed. What a step leaves out is 14 digits below; a flight of
# dozens of steps stays 10 digits below, and those ten are for what an at-bat magnifies: the blow
# makes of an error of the contact a few hundred times as much at the landing, and in a graze with a
# margin of 1e-15 m 1e9 times as much. Rounding stays six digits below what a step leaves out.
_FLIGHT_GUARD = 10
_STEP_GUARD = 14
_ROUNDING_GUARD = 20

# Nodes a digit: between 1.1 and 1.6 the time of a flight is flat.
_NODES_PER_DIGIT = 1.25


class MultiprecisionNumbers:
    """Numbers of mpmath with so many digits to be printed, and some more behind them.

    They have a context of their own, so that engines of different precision do not meet.
    """

    def __init__(self, digits: int) -> None:
        self.digits = digits
        self.context = MPContext()
        self.context.dps = digits + _ROUNDING_GUARD
        self.pi: Mpf = +self.context.pi
        self.rounding = 2.0**-self.context.prec

    def arithmetic(self) -> AbstractContextManager[None]:
        """Return a context that does nothing: these numbers bring their own precision."""
        return nullcontext()

    def exact(self, value: float) -> Mpf:
        """Return the double itself."""
        return self.context.mpf(value)

    def sqrt(self, x: Mpf) -> Mpf:
        """Return the square root."""
        return self.context.sqrt(x)

    def cos_sin(self, angle: Mpf) -> tuple[Mpf, Mpf]:
        """Return cosine and sine of an angle in radians."""
        return self.context.cos(angle), self.context.sin(angle)

    def positive(self, x: Mpf, error: Mpf | float, question: str) -> bool:
        """Tell whether ``x > 0``; see `longball.model.numbers.Numbers.positive`."""
        if abs(x) > error or x == error == 0:
            return bool(x > 0)
        raise Undecided(
            f"{question} cannot be decided with {self.digits} digits: "
            f"the value {float(x):.3g} lies within its error {float(error):.3g}"
        )

    def report(self, x: Mpf) -> Bounded:
        """Return the number rounded to the digits asked for; its error is not proven."""
        if not self.context.isfinite(x):
            raise OverflowError(f"a value is {x}")
        text: str = self.context.nstr(x, self.digits, strip_zeros=False)
        return Bounded(value=text.removesuffix("."), radius=None)


@lru_cache
def _numbers(digits: int) -> MultiprecisionNumbers:
    return MultiprecisionNumbers(digits)


@lru_cache
def _collocation(digits: int) -> Collocation:
    numbers = _numbers(digits)
    nodes = math.ceil(_NODES_PER_DIGIT * (digits + _STEP_GUARD))
    tolerance = numbers.context.mpf(10) ** -(digits + _STEP_GUARD)
    rule = gauss_legendre(nodes, numbers.context)
    return Collocation(rule, numbers, numbers.context, tolerance)


# --- events on a segment --------------------------------------------------------------------------


@dataclass(frozen=True)
class Surface:
    """Something that a flight can reach: where a function of the state changes sign.

    Attributes
    ----------
    name
        Under which a flight reports it.
    value, rate
        The function, and its derivative in time.
    direction
        +1 if the function rises through zero there, -1 if it falls.
    size
        What the error of the function is relative to, in its unit.
    doubt
        What cannot be told where the function turns within its error of zero.
    place
        Puts a state that is within rounding of the surface onto it.
    """

    name: str
    value: Callable[[State], Mpf]
    rate: Callable[[State], Mpf]
    direction: int
    size: Mpf
    doubt: str = ""
    place: Callable[[State], State] = lambda state: state


def _may_vanish(segment: Segment, function: Callable[[State], Mpf], rule: Rule) -> bool:
    """Tell whether a function of the state may be zero on a segment, where all |P_k| <= 1."""
    first, *others = np.abs(_series(segment, function, rule))
    # The slack is far more than the rounding of doubles: no graze is passed over.
    return bool(first <= (1 + 1e-9) * sum(others))


def _zeros(segment: Segment, function: Callable[[State], Mpf], rule: Rule) -> list[Mpf]:
    """Return where a function of the state changes sign on a segment, in rising order.

    Doubles find all zeros at once, as the eigenvalues of a matrix; each is then made precise. Two
    of them nearer to each other than `_NEAR` are lost; between them an integral of the function
    changes by its cube, a part in 1e21.
    """
    series = _series(segment, function, rule)
    significant = np.flatnonzero(np.abs(series) > _NOISE * np.abs(series).max())
    if not significant.size:
        return []
    roots = np.polynomial.legendre.legroots(series[: significant[-1] + 1])
    zeros = []
    for guess in roots.real[np.abs(roots.imag) <= _NEAR].tolist():
        low, high = max(segment.first, guess - _NEAR), min(segment.last, guess + _NEAR)
        if low < high:
            zeros.append(_change_of_sign(segment, function, low, high))
    return sorted(zero for zero in zeros if zero is not None)


# Coefficients below this, relative to the largest, are the rounding of the doubles they are in.
_NOISE = 2.0**-52

# The eigenvalues are good to about 1e-14 if zeros are apart, and to the root of that if not.
_NEAR = 1e-7


def _crossing(segment: Segment, surface: Surface, left: Mpf, right: Mpf) -> Mpf | None:
    """Return where a surface is crossed in its direction, between two turns of its function."""
    before = surface.direction * surface.value(segment.state(left))
    after = surface.direction * surface.value(segment.state(right))
    if before > 0 or after < 0:
        return None
    return _change_of_sign(segment, surface.value, left, right)


def _series(segment: Segment, function: Callable[[State], Mpf], rule: Rule) -> Array:
    """Return the Legendre coefficients of a function of the state, in doubles."""
    values = [float(function(state)) for state in segment.at_nodes]
    series: Array = rule.coefficients_in_doubles @ np.array(values)
    return series


def _change_of_sign(
    segment: Segment, function: Callable[[State], Mpf], low: Mpf, high: Mpf
) -> Mpf | None:
    """Return where a function of the state is zero between two points; None if nowhere.

    Inverse quadratic interpolation where three points allow it, else bisection (Chandrupatla,
    Advances in Engineering Software 28, 145 (1997)): a dozen evaluations for fifty digits.
    """

    def at(x: Mpf) -> Mpf:
        return function(segment.state(x))

    x1, x2 = high, low
    f1, f2 = at(x1), at(x2)
    if f1 == 0 or f2 == 0:
        return x2 if f2 == 0 else x1
    if (f1 > 0) == (f2 > 0):
        return None
    resolution = 16 * segment.context.eps
    share = segment.context.mpf(0.5)
    while True:
        x = x1 + share * (x2 - x1)
        f = at(x)
        if (f > 0) == (f1 > 0):
            x3, f3 = x1, f1
        else:
            x3, f3, x2, f2 = x2, f2, x1, f1
        x1, f1 = x, f
        least = resolution / abs(x2 - x1)
        if f1 == 0 or least > 0.5:
            return x1 if abs(f1) < abs(f2) else x2
        xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
        share = segment.context.mpf(0.5)
        if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:
            share = f1 / (f2 - f1) * f3 / (f2 - f3)
            share += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        share = min(max(share, least), 1 - least)


# --- the engine -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Multiprecision:
    """Flights by Gauss-Legendre collocation in mpmath.

    Attributes
    ----------
    digits
        How many digits of each number are printed, and normally right.
    """

    digits: int = 30

    def __post_init__(self) -> None:
        if not 1 <= self.digits <= _MOST_DIGITS:
            raise ValueError(f"digits = {self.digits} is not between 1 and {_MOST_DIGITS}")

    @property
    def description(self) -> str:
        """Name, method and digits."""
        return f"multiprecision Gauss-Legendre digits={self.digits}"

    @property
    def numbers(self) -> MultiprecisionNumbers:
        """Numbers of mpmath."""
        return _numbers(self.digits)

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight; it is not proven."""
        return 10.0 ** -(self.digits + _FLIGHT_GUARD)

    def fly(self, start: State, forces: Forces[Mpf], stops: Stops[Mpf]) -> Arrival[Mpf]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`.

        Raises
        ------
        Undecided
            If the errors hide whether a stop is met, or which of two.
        """
        now = self.numbers.exact(0.0)
        if stops.floor is not None and self._rests_on(stops.floor, start, forces):
            return Arrival("floor", now, start, ())
        surfaces = self._stop_surfaces(start, forces, stops)
        in_time = "whether the ball meets the {} before the time limit"
        way: list[Segment] = []
        for segment in self._segments(forces, now, start, stops.time_limit):
            way.append(segment)
            if met := self._first_met(segment, surfaces):
                x, surface = met
                time, state = segment.time(x), surface.place(segment.state(x))
                error = self.flight_error * stops.time_limit
                self.numbers.positive(stops.time_limit - time, error, in_time.format(surface.name))
                return Arrival(cast(Stop, surface.name), time, state, tuple(way))
        end = way[-1].end if way else start
        for surface in surfaces:
            beyond = abs(surface.value(end))
            self.numbers.positive(beyond, self._error(surface), in_time.format(surface.name))
        return Arrival("time", stops.time_limit, end, tuple(way))

    def touch(
        self, pitch: Arrival[Mpf], forces: Forces[Mpf], bat: BatSection[Mpf], stops: Stops[Mpf]
    ) -> Touch[Mpf]:
        """Find how a pitch meets the bat; see `longball.engines.engine.Engine.touch`."""
        way = cast(tuple[Segment, ...], pitch.record)
        launch = way[0].start
        beyond = self._segments(forces, way[-1].until, way[-1].end, stops.time_limit)
        ends = self._search_ends(launch, forces, bat, stops)
        surface = self._bat_surface(launch, bat)
        error = self._error(surface)
        gap = -self._margin(launch, bat)
        if gap < -error:
            distance, reach = float(bat.reach + gap), float(bat.reach)
            raise CannotSolve(
                f"the ball starts inside the bat: {distance:.6g} m from its axis, "
                f"where the two touch at {reach:.6g} m; release it farther from the plate"
            )
        first: tuple[Mpf, State] | None = None
        if gap <= error and surface.rate(launch) < 0:
            first = way[0].begin, launch
        closest = -self.numbers.context.inf
        for segment in chain(way, beyond):
            met = self._first_met(segment, ends)
            last = met[0] if met else segment.last
            over = met is not None or segment.until >= stops.time_limit
            turns = [x for x in _zeros(segment, surface.rate, self._rule) if x < last]
            for left, right in pairwise([segment.first, *turns, last]):
                if first is None:
                    x = _crossing(segment, surface, left, right)
                    first = None if x is None else (segment.time(x), segment.state(x))
                if right == last and not over:
                    continue
                margin = self._margin(segment.state(right), bat)
                closest = max(closest, margin)
                if abs(margin) <= error:
                    return Touch(margin, None, doubt=self._doubt(margin, error))
                if margin > 0 and first is not None:
                    return Touch(margin, True, *first)
            if met and met[1].name == "vertical":
                raise CannotSolve(
                    "the pitch turns vertical over the plate, where a lift that is always up "
                    "has no direction; use lift_direction = fixed_spin_axis"
                )
            if over:
                break
        return Touch(closest, False)

    def _segments(
        self, forces: Forces[Mpf], begin: Mpf, start: State, end: Mpf
    ) -> Iterator[Segment]:
        """Fly, in two pieces if the flight is vertical: up to its apex, and down.

        There the ball is at rest, and V = |w| has a kink. Any other flight that comes near V = 0 is
        followed by steps as short as it takes.
        """
        steps = _collocation(self.digits).segments
        if start.u != 0 or forces.lift is not None:
            yield from steps(dynamics(forces, self.numbers), begin, start, end)
            return
        rising, falling = (upright_dynamics(forces, self.numbers, up) for up in (True, False))
        if start.w > 0:
            for segment in steps(rising, begin, start, end):
                if segment.end.w > 0:
                    yield segment
                    begin, start = segment.until, segment.end
                    continue
                x = _change_of_sign(segment, lambda state: state.w, segment.first, segment.last)
                begin, start = segment.time(x), segment.state(x)._replace(w=begin * 0)
                yield segment.ending(x, start)
                break
        yield from steps(falling, begin, start, end)

    def _first_met(self, segment: Segment, surfaces: list[Surface]) -> tuple[Mpf, Surface] | None:
        """Return the first surface that is crossed on a segment, and where."""
        met = []
        for surface in surfaces:
            if not _may_vanish(segment, surface.value, self._rule):
                continue
            turns = _zeros(segment, surface.rate, self._rule)
            inner = [x for x in turns if segment.first < x < segment.last]
            for left, right in pairwise([segment.first, *inner, segment.last]):
                depth = surface.value(segment.state(right))
                if right != segment.last and abs(depth) <= self._error(surface):
                    met.append((right, surface, True))
                    break
                x = _crossing(segment, surface, left, right)
                if x is not None:
                    met.append((x, surface, False))
                    break
        if not met:
            return None
        met.sort(key=itemgetter(0))
        x, surface, grazed = met[0]
        if grazed:
            value = surface.value(segment.state(x))
            self.numbers.positive(abs(value), self._error(surface), surface.doubt)
        for later, other, _ in met[1:]:
            self.numbers.positive(
                later - x,
                self.flight_error,
                f"whether the ball meets the {surface.name} or the {other.name} first",
            )
        return x, surface

    def _stop_surfaces(self, start: State, forces: Forces[Mpf], stops: Stops[Mpf]) -> list[Surface]:
        """Return what stops a flight."""
        one = self.numbers.exact(1.0)
        surfaces = []
        if (floor := stops.floor) is not None:
            surfaces.append(
                Surface(
                    "floor",
                    lambda y: y.z - floor,
                    lambda y: y.w,
                    -1,
                    max(one, abs(floor), abs(start.z)),
                    "whether the ball touches the ground at the bottom of a dip",
                    lambda y: y._replace(z=floor),
                )
            )
        if (wall := stops.wall) is not None:
            surfaces.append(
                Surface(
                    "wall",
                    lambda y: y.s - wall,
                    lambda y: y.u,
                    +1,
                    max(one, abs(wall)),
                    "whether the ball reaches the plate before it turns back",
                    lambda y: y._replace(s=wall),
                )
            )
        if stops.vertical:
            accelerate = acceleration(forces, self.numbers)
            surfaces.append(
                Surface(
                    "vertical",
                    lambda y: y.u,
                    lambda y: accelerate(y.u, y.w)[0],
                    -1,
                    max(one, abs(start.u)),
                    "whether the ball turns vertical",
                    lambda y: y._replace(u=one * 0),
                )
            )
        return surfaces

    def _search_ends(
        self, launch: State, forces: Forces[Mpf], bat: BatSection[Mpf], stops: Stops[Mpf]
    ) -> list[Surface]:
        """Return what ends the search for the bat."""
        past = Surface(
            "past",
            lambda y: bat.x + bat.cos * y.s + bat.reach,
            lambda y: bat.cos * y.u,
            -1,
            bat.x + bat.reach,
            "whether the ball passes the bat before it turns back",
        )
        return [past, *self._stop_surfaces(launch, forces, replace(stops, wall=None))]

    def _bat_surface(self, launch: State, bat: BatSection[Mpf]) -> Surface:
        """Return where ball and bat touch."""

        def depth(y: State) -> Mpf:
            across, up = bat.x + bat.cos * y.s, y.z - bat.height
            return (across * across + up * up - bat.reach * bat.reach) / 2

        return Surface(
            "bat",
            depth,
            lambda y: contact.radial_velocity(y, bat),
            -1,
            bat.x + abs(bat.height) + abs(launch.z) + bat.reach,
        )

    def _margin(self, state: State, bat: BatSection[Mpf]) -> Mpf:
        """Return how deep the ball is in the bat, m; negative outside."""
        across, up = bat.x + bat.cos * state.s, state.z - bat.height
        return bat.reach - self.numbers.sqrt(across * across + up * up)

    def _doubt(self, margin: Mpf, error: Mpf) -> str:
        return (
            f"whether the ball touches the bat cannot be decided with {self.digits} digits: "
            f"the margin {float(margin):.3g} m lies within its error {float(error):.3g} m"
        )

    def _rests_on(self, floor: Mpf, start: State, forces: Forces[Mpf]) -> bool:
        """Tell whether a ball on the floor does not leave it."""
        upwards = acceleration(forces, self.numbers)(start.u, start.w)[1]
        rising = start.w > 0 or (start.w == 0 and upwards > 0)
        return bool(start.z <= floor and not rising)

    def _error(self, surface: Surface) -> Mpf:
        return self.flight_error * surface.size

    @property
    def _rule(self) -> Rule:
        return _collocation(self.digits).rule


# Beyond, a double does not hold the error of a flight, 10^-(digits + 10).
_MOST_DIGITS = 290
