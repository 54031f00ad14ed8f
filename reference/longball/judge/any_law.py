"""Flights under any law, without compiled code for it.

A candidate's mistakes are tried by the hundred, each a law of its own. Taylor's method would print
and compile each, for a second or so; SciPy's DOP853 takes any law as it is. Where an event is
looked for, its steps are made polynomials of degree five by the states at their ends, and their
first and second derivatives.
"""

from __future__ import annotations

import math
import threading
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from longball.engines.contact import BatSection
from longball.engines.engine import OutOfRange, TooLong
from longball.engines.event import Curve, Event, Events, Piece
from longball.engines.ivp import Ivp
from longball.engines.path import Flight, Path, reaching
from longball.engines.path_engine import PathEngine, View
from longball.engines.polynomial import PolynomialPiece
from longball.model.arrays import Array
from longball.model.law import PAPER, Law, State
from longball.model.numbers import DOUBLES, Doubles

# A candidate's mistakes leave most flights as they are: the last ones are kept.
MOST_PATHS = 2000


class Effort(threading.local):
    """What flights of a thread have taken so far: so a verdict hangs on no other one's work."""

    steps = 0.0  # of DOP853, of 0.2 ms or so; of what takes a part of that, the part

    def __init__(self) -> None:
        self._paths: dict[Hashable, dict[tuple[Any, ...], Path[Any]]] = defaultdict(dict)

    def path(
        self, law: Law[float], flight: tuple[Any, ...], pieces: Callable[[], Iterable[Any]],
        kind: Hashable = "any law", most: int = MOST_PATHS,
    ) -> Path[Any]:  # fmt: skip
        """Return the path of a flight, which stays known with so many after it of its kind."""
        # Many changes leave a flight as it was, which is not flown again. Programs are kept for
        # good, so that a number belongs to one of them.
        key, known = (id(law.program), *law.strengths.items(), *flight), self._paths[kind]

        def coming() -> Iterator[Any]:
            try:
                yield from pieces()
            except Exception:
                known.pop(key, None)  # a path that has failed would seem to end there
                raise

        if key not in known:
            if len(known) == most:
                del known[next(iter(known))]
            known[key] = Path(coming())
        return known[key]

    def forget(self) -> None:
        """Forget the flights: what a search takes hangs on none before it."""
        self._paths.clear()


EFFORT = Effort()

# Of a step: what it takes to look for where a law changes its form, and to go on in another one.
A_BEND, A_PART = 0.5, 2

TOLERANCE = 1e-11

# s: a polynomial of degree five is off by 1e-9 m on such a step of a baseball's flight.
LONGEST = 0.3

_SHORT = 1e-4  # s: half of what a derivative is a difference over
# m and m/s: a law that takes a ball so far drives it on without end; events there take seconds.
FARTHEST = 1e7
MOST_STEPS = 500  # a baseball's flight takes twenty, and one that a wrong law drives on any number


@dataclass(frozen=True)
class AnyLaw(PathEngine[float]):
    """Flights by SciPy's DOP853; of the paper's own law, by Taylor's method."""

    @property
    def numbers(self) -> Doubles:
        """Double precision."""
        return DOUBLES

    @property
    def description(self) -> str:
        """Name and tolerance."""
        return f"any-law DOP853 {TOLERANCE:g}"

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight."""
        return 10 * TOLERANCE

    def path(
        self, law: Law[float], start: State[float], limit: float, events: Events[float] = ()
    ) -> Path[float]:
        """Return a flight."""
        if law.bends:
            return super().path(law, start, limit, events)
        flight = start, limit, tuple(event.name for event in events)
        return EFFORT.path(law, flight, lambda: self._pieces(law, start, limit, events))

    def steps(
        self,
        law: Law[float],
        start: State[float],
        begin: float,
        limit: float,
        events: Sequence[Event[float]],
    ) -> Iterator[Piece[float]]:
        """Yield the pieces of a flight; see `longball.engines.path_engine.PathEngine.steps`."""
        if is_papers(law):
            for piece in Ivp().steps(law, start, begin, limit, events):
                if max(map(abs, piece.at(0.0))) > FARTHEST:
                    raise OutOfRange(f"the ball is driven on at t = {piece.begin:.6g} s")
                yield piece
            return
        from scipy.integrate import DOP853  # slow to import

        from longball.engines.taylor import right_hand_side

        state, rates = np.array(start, dtype=float), _within(right_hand_side(law))

        def bend(state: Array, slope: Array) -> Array:
            """Return the second derivative, as a difference along the way."""
            ahead, behind = (rates(0.0, state + h * slope) for h in (_SHORT, -_SHORT))
            found: Array = (np.array(ahead) - np.array(behind)) / (2 * _SHORT)
            return found

        if not np.isfinite(rates(begin, state)).all():
            raise OutOfRange("the forces are beyond the range of double precision")
        searched = bool(events or law.bends)
        longest = LONGEST if searched else math.inf
        # Forces beyond all measure show in the state.
        with np.errstate(all="ignore"):
            solver = DOP853(
                rates, begin, state, limit, max_step=longest, rtol=TOLERANCE, atol=TOLERANCE
            )
            after = bend(state, solver.f) if searched else state
        EFFORT.steps += A_PART * bool(law.bends)
        for _ in range(MOST_STEPS):
            EFFORT.steps += 1 + A_BEND * len(law.bends)
            time, before, slope, bent = solver.t, solver.y, solver.f, after
            with np.errstate(all="ignore"):
                message = solver.step()
            if message is not None or not np.abs(solver.y).max() <= FARTHEST:
                raise OutOfRange(f"DOP853 gave up at t = {time:.6g} s")
            length = reaching(time, solver.t - time, solver.t)
            if not searched:
                yield Stride(time, length, law.state(*before), law.state(*solver.y))
            else:
                with np.errstate(all="ignore"):
                    after = bend(solver.y, solver.f)
                    between = _between(length, (before, solver.y), (slope, solver.f), (bent, after))
                if not np.isfinite(between).all():
                    raise OutOfRange(f"DOP853 gave up at t = {time:.6g} s")
                yield PolynomialPiece(time, length, law.state, between)
            if solver.status == "finished":
                return
        raise TooLong(f"the flight takes over {MOST_STEPS} steps")

    def views(
        self, pitch: Flight[float], law: Law[float], bat: BatSection[float]
    ) -> Iterator[View[float]]:
        """Yield the pieces of a pitch; see `longball.engines.path_engine.PathEngine.views`."""
        yield from (
            Ivp().views(pitch, law, bat) if is_papers(law) else super().views(pitch, law, bat)
        )


class Stride(NamedTuple):
    """A step whose ends alone are known."""

    begin: float
    length: float
    before: State[float]
    after: State[float]

    def at(self, t: float) -> State[float]:
        """Return the state at the beginning or at the end."""
        if t == 0.0:
            return self.before
        # The end that was asked for, less the beginning, is rounded.
        if not math.isclose(self.begin + t, self.begin + self.length, rel_tol=1e-14):
            raise ValueError("a flight in which no event is looked for has no state within a step")
        return self.after

    def curve(self, value: Callable[[Any], Any]) -> Curve[float]:
        """No event is looked for."""
        raise NotImplementedError


def _within(rates: Callable[[float, Array], Any]) -> Callable[[float, Array], Any]:
    """Return rates that are NaN where a law ends, so that a step which goes there is shortened."""

    def known(time: float, state: Array) -> Any:
        try:
            return rates(time, state)
        except (ArithmeticError, ValueError):
            return np.full(len(state), np.nan)

    return known


ANY_LAW = AnyLaw()


def is_papers(law: Law[float]) -> bool:
    """Tell whether a law is made of the paper's own terms."""
    return set(law.forces) <= set(PAPER)


def _between(
    h: float, states: tuple[Array, Array], slopes: tuple[Array, Array], bends: tuple[Array, Array]
) -> Array:
    """Return the coefficients of polynomials with these values and derivatives at both ends."""
    (a, b), (da, db), (dda, ddb) = states, slopes, bends
    gap = b - a - h * da - h * h * dda / 2
    rate = h * (db - da) - h * h * dda
    bend = h * h * (ddb - dda) / 2
    return np.column_stack([
        a, da, dda / 2,
        (10 * gap - 4 * rate + bend) / h**3,
        (-15 * gap + 7 * rate - 2 * bend) / h**4,
        (6 * gap - 3 * rate + bend) / h**5,
    ])  # fmt: skip
