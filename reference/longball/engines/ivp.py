"""The reference engine: `scipy.integrate.solve_ivp` with terminal events.

solve_ivp looks for a change of an event's sign between its steps, so that a ball that dips and
comes back within a step is not seen, and finds the event on its interpolant, whose order may be
lower than that of its steps. Here its terminal events only end the integration in time. What they
ended is handed on as Taylor polynomials, step by step, in which `longball.engines.event` searches
for the first event, and misses none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.integrate

from longball.engines.contact import BatSection
from longball.engines.engine import OutOfRange, TooLong
from longball.engines.event import Events
from longball.engines.path import Flight
from longball.engines.path_engine import PathEngine, View
from longball.engines.polynomial import PolynomialPiece
from longball.engines.taylor import Expander, Taylor, right_hand_side
from longball.model.arrays import Array
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, Doubles

METHODS = ("Taylor", "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


# A baseball's flight takes a dozen steps of Taylor's method and a hundred of others. Strong lift
# can loop a ball a thousand times a second: the limit is some seconds of work.
_MOST_STEPS = 20_000
# After so many the ball may have settled to its final speed.
_MANY_STEPS = 2_000

_BEYOND = "the forces are beyond the range of double precision"


@dataclass(frozen=True)
class Ivp(PathEngine[float]):
    """Flights by `scipy.integrate.solve_ivp`.

    Attributes
    ----------
    method
        "Taylor" (`longball.engines.taylor.Taylor`), as exact as doubles are; or any of solve_ivp's
        own methods, by name.
    rtol, atol
        Tolerances of the steps of solve_ivp's own methods, relative and absolute (m and m/s);
        5e-14 if left out. Taylor's method takes none.
    """

    method: str = "Taylor"
    rtol: float | None = None
    atol: float | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method {self.method!r} is not one of {', '.join(METHODS)}")
        if self.method == "Taylor":
            if self.rtol is not None or self.atol is not None:
                raise ValueError("method Taylor takes no rtol and no atol; DOP853, for one, does")
            return
        smallest = 100 * np.finfo(float).eps  # below this solve_ivp raises it with a warning
        if not smallest <= self.tolerances["rtol"] < 1:
            raise ValueError(f"rtol = {self.rtol} is not between {smallest:.3g} and 1")
        if not 0 < self.tolerances["atol"] < 1:
            raise ValueError(f"atol = {self.atol} is not between 0 and 1")

    @property
    def tolerances(self) -> dict[str, float]:
        """What solve_ivp takes as tolerances."""
        if self.method == "Taylor":
            return {}
        default = 5e-14
        return {
            "rtol": default if self.rtol is None else self.rtol,
            "atol": default if self.atol is None else self.atol,
        }

    @property
    def numbers(self) -> Doubles:
        """Double precision."""
        return DOUBLES

    @property
    def description(self) -> str:
        """Name, method and tolerances."""
        return " ".join(["ivp", self.method, *(f"{k}={v:g}" for k, v in self.tolerances.items())])

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight.

        By Taylor's method it is a few roundings: up to 2.3e-15 in 400 batted balls at their
        landings, 3e-16 for high and for slow flights, 1.3e-14 after some six loops, whose path is
        much longer than the distance flown.

        The errors of the other methods' steps add up. Over pitches of all sorts, steep ones
        included, the plate was reached within 2.3 tolerances by one-step methods, and within 70 by
        multistep methods, whose steps are many (`tests/engines/test_contact.py`).
        """
        if self.method == "Taylor":
            return 2e-14
        return (100 if self.method in ("BDF", "LSODA") else 10) * max(self.tolerances.values())

    def steps(
        self,
        law: Law[float],
        start: State[float],
        begin: float,
        limit: float,
        events: Events[float],
    ) -> Iterator[PolynomialPiece]:
        """Yield the pieces of a flight; see `longball.engines.path_engine.PathEngine.steps`.

        Raises `OutOfRange` or `TooLong` if solve_ivp gives up, or the flight takes too many steps.
        """
        time, state = begin, np.array(start, dtype=float)
        taken = 0
        while time < limit:
            if taken > 0 and _has_settled(law, state):
                yield _uniform(law, time, state, limit)
                return
            solution, pieces = self._integrate(law, time, state, limit, events)
            for piece in pieces:
                taken, time = taken + 1, piece.begin + piece.length
                if taken > _MOST_STEPS:
                    raise TooLong(
                        f"the flight takes over {_MOST_STEPS} steps; try a shorter time_limit"
                    )
                yield piece
            if solution.status < 0:
                raise OutOfRange(f"solve_ivp gave up at t = {time:.6g} s: {solution.message}")
            time, state = float(solution.t[-1]), solution.y[:, -1]
            events = ()  # whoever asks for more did not stop there

    def _integrate(
        self, law: Law[float], time: float, state: Array, limit: float, events: Events[float]
    ) -> tuple[Any, Iterable[PolynomialPiece]]:
        """Return what solve_ivp returns, and the polynomials of its steps."""
        span, ends = (time, limit), _ends(events, law)
        if self.method == "Taylor":
            pieces: list[PolynomialPiece] = []
            options = {"law": law, "ends": ends, "pieces": pieces}
            solution = scipy.integrate.solve_ivp(
                None, span, state, method=_TaylorFlight, events=ends, **options
            )
            return solution, pieces
        rates = right_hand_side(law)
        if not np.isfinite(rates(time, state)).all():
            raise OutOfRange(_BEYOND)
        # A trial step may overflow; the step control then takes a shorter one or gives up.
        with np.errstate(all="ignore"):
            solution = scipy.integrate.solve_ivp(
                rates, span, state, method=self.method, events=ends, **self.tolerances
            )
        return solution, _expanded(law, solution.t.tolist(), solution.y.T)

    def views(
        self, pitch: Flight[float], law: Law[float], bat: BatSection[float]
    ) -> Iterator[View[float]]:
        """Yield the pieces of a pitch; near the plate, one that is expanded at the crossing.

        The bat's height is that of the same state, so that both have the same error. Under a law
        that changes its form near the plate there is no such piece.
        """
        if law.bends:
            for piece in pitch.path.pieces():
                yield View(piece, 0.0, piece.length, self._plate_error(pitch, bat))
            return
        centred = self.around(law, pitch.time, pitch.state)
        speed = math.hypot(*bat.frame.velocity(pitch.state))
        # Not much longer than it takes to get to the bat and past it: the square of the distance,
        # of which reach² is to be told apart, starts small.
        near = bat.distance(pitch.state, self.numbers) + _NEAR * bat.reach
        half = min(centred.length, near / speed)
        begin, end = max(0.0, pitch.time - half), pitch.time + half
        error = self._plate_error(pitch, bat)
        seen = False
        for piece in pitch.path.pieces():
            if piece.begin < begin:
                yield View(piece, 0.0, min(piece.length, begin - piece.begin), error)
            if piece.begin + piece.length >= begin and not seen:
                seen = True
                yield View(centred, begin - pitch.time, half, 0.0)
            if piece.begin + piece.length > end:
                yield View(piece, max(0.0, end - piece.begin), piece.length, error)

    def _plate_error(self, pitch: Flight[float], bat: BatSection[float]) -> float:
        """Return the error of a place near the plate, m."""
        return self.flight_error * max(abs(bat.frame.x), abs(pitch.state.z))

    def around(self, law: Law[float], time: float, state: State[float]) -> PolynomialPiece:
        """Return the flight around a state, s since the launch, as one piece on both sides of it.

        It begins at that time, and also holds before, for as long as it is long.
        """
        series, reach = Expander(law)(np.array(state, dtype=float))
        if not reach > 0:
            raise OutOfRange(_BEYOND)
        return PolynomialPiece(time, reach, law.state, series)


# Times the reach of the bat: as far beyond it as a pitch is where the search looks closely.
_NEAR = 4.0


class _TaylorFlight(Taylor):
    """Taylor's method that goes on to an event, and hands on its series.

    solve_ivp looks at an event for longer than a series takes: it is shown the last one alone.
    """

    def __init__(
        self,
        *given: Any,
        law: Law[float],
        ends: Callable[[float, Array], float],
        pieces: list[PolynomialPiece],
        **options: Any,
    ) -> None:
        super().__init__(*given, law=law, **options)
        self._state, self._ends, self._pieces = law.state, ends, pieces

    def step(self) -> str | None:
        """Take steps until the event's value is zero, with the account that `OdeSolver` keeps."""
        while self.status == "running":
            begin = self.t
            moved, message = self._step_impl()
            if not moved:
                self.status = "failed"
                return message
            self.t_old = begin
            length = _length(begin, self.t)
            self._pieces.append(PolynomialPiece(begin, length, self._state, self._x))
            if self.t == self.t_bound:
                self.status = "finished"
            elif not self._ends(self.t, self.y) > 0:
                break
        return None

    def _dense_output_impl(self) -> Callable[[float], Array]:
        """Return the ends of the last series: an event whose value is zero there is not sought."""
        return {self.t_old: self._x[:, 0], self.t: self.y}.__getitem__


def _expanded(
    law: Law[float], times: Sequence[float], states: Iterable[Array]
) -> Iterator[PolynomialPiece]:
    """Yield the series from accepted states; again where a step is longer than they reach."""
    expand, make = Expander(law), law.state
    for time, state, end in zip(times, states, times[1:], strict=False):
        while time < end:
            series, reach = expand(state)
            if not reach > 0:
                raise OutOfRange(_BEYOND)
            until = min(time + reach, end)
            piece = PolynomialPiece(time, _length(time, until), make, series)
            yield piece
            time, state = until, np.array(piece.at(piece.length))


def _ends(events: Events[float], law: Law[float]) -> Callable[[float, Array], float]:
    """Return the terminal event that ends an integration with the step that meets an event.

    Its value stays at zero from there, and so solve_ivp finds it at the end of that step. An
    integration also ends after many steps.
    """
    make, steps, last = law.state, 0, math.inf
    values = [event.value for event in events]

    def left(time: float, y: Array) -> float:
        nonlocal steps, last
        steps += 1
        if steps > _MANY_STEPS:
            last = min(last, time)
        least = 1.0 if time < last else 0.0
        state = make(*y.tolist())
        for value in values:
            if not (height := value(state)) >= least:
                least = max(height, 0.0)
        return least

    left.terminal = True  # type: ignore[attr-defined]
    left.direction = -1  # type: ignore[attr-defined]
    return left


def _length(begin: float, end: float) -> float:
    """Return how long a piece is, rounded such that it reaches its end."""
    length = end - begin
    return length if begin + length >= end else math.nextafter(length, math.inf)


# A ball that falls at its final speed V is a stiff problem if it is light: a disturbance decays
# within V/(2 g), and an explicit step is not much longer. But then its acceleration is nothing but
# the rounding of its forces, and its motion uniform, to rounding.
_SETTLED = 1e-14  # of gravity


def _has_settled(law: Law[float], state: Array) -> bool:
    """Tell whether a ball moves uniformly from here on."""
    if law.gravity is None or any(
        node.kind == "variable" and node.args[0] in "syz" for node in law.program.nodes
    ):
        return False
    rates = law.rates(DOUBLES)(*state.tolist())
    pushed = [
        rate
        for rate, node in zip(rates, law.program.outputs, strict=True)
        if node.kind != "variable"
    ]
    return all(abs(rate) <= _SETTLED * law.gravity for rate in pushed)


def _uniform(law: Law[float], time: float, state: Array, limit: float) -> PolynomialPiece:
    rates = law.rates(DOUBLES)(*state.tolist())
    slopes = [
        rate if node.kind == "variable" else 0.0
        for rate, node in zip(rates, law.program.outputs, strict=True)
    ]
    return PolynomialPiece(time, _length(time, limit), law.state, np.column_stack([state, slopes]))
