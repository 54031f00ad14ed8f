"""The reference engine: `scipy.integrate.solve_ivp` with terminal events.

One call integrates a pitch to the plate:

    solve_ivp(right_hand_side(law), (0, limit), start, method=Taylor, law=law, dense_output=True,
              events=[ground, plate])

The height of the bat follows from the height of the pitch at the plate. A second call, with the
events ground, contact and closest approach, integrates the same pitch to the bat. A third call
integrates the batted ball to the ground.

solve_ivp only compares the signs of an event at its steps: it misses a ball that dips and returns
within a step. It locates the event on its interpolant, whose order may be lower than that of the
steps. Here its events only end the integration. `longball.engines.event` then searches the Taylor
polynomial of each step for the first event, and misses none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import Any

import numpy as np
import scipy.integrate

from longball.engines.engine import OutOfRange, TooLong, Touch
from longball.engines.event import BatSection, Event, Events, Piece
from longball.engines.path import Flight, Path
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import PolynomialPiece
from longball.engines.taylor import Series, Taylor, expand, right_hand_side
from longball.model.arrays import Array
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES

METHODS = ("Taylor", "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")


# A baseball's flight takes a dozen steps of Taylor's method and a hundred of others. Strong lift
# can loop a ball a thousand times a second: the limit corresponds to a few seconds of computing.
_MOST_STEPS = 20_000  # a free choice
# solve_ivp is interrupted after this many steps to test for terminal velocity (`_uniform`).
_MANY_STEPS = 2_000  # a free choice

_BEYOND = "the forces are beyond the range of double precision"


@dataclass(frozen=True)
class Ivp(PathEngine):
    """Flights by `scipy.integrate.solve_ivp`.

    Attributes
    ----------
    method
        "Taylor" (`longball.engines.taylor.Taylor`), accurate to rounding; or any of solve_ivp's
        own methods, by name.
    rtol, atol
        Tolerances of the steps of solve_ivp's own methods, relative and absolute (m and m/s);
        5e-14 if left out. Taylor's method takes none.
    """

    method: str = "Taylor"
    rtol: float | None = None
    atol: float | None = None

    numbers = DOUBLES

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method {self.method!r} is not one of {', '.join(METHODS)}")
        if self.method == "Taylor":
            if self.rtol is not None or self.atol is not None:
                raise ValueError("method Taylor takes no rtol and no atol; use DOP853, for example")
            return
        smallest = 100 * np.finfo(float).eps  # solve_ivp replaces smaller values, with a warning
        if not smallest <= self.tolerances["rtol"] < 1:
            raise ValueError(f"rtol = {self.rtol} is not between {smallest:.3g} and 1")
        if not 0 < self.tolerances["atol"] < 1:
            raise ValueError(f"atol = {self.atol} is not between 0 and 1")

    @property
    def tolerances(self) -> dict[str, float]:
        """Tolerances of solve_ivp, by name."""
        given = {} if self.method == "Taylor" else {"rtol": self.rtol, "atol": self.atol}
        return {name: 5e-14 if value is None else value for name, value in given.items()}

    @property
    def description(self) -> str:
        """Name, method and tolerances."""
        return " ".join(["ivp", self.method, *(f"{k}={v:g}" for k, v in self.tolerances.items())])

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight.

        Taylor's method makes a few rounding errors: up to 2.3e-15 at the landings of 400 batted
        balls, 3e-16 for high and for slow flights, and 1.3e-14 after about six loops, whose path is
        much longer than the distance flown.

        The errors of the other methods' steps add up. In units of the tolerance, the largest errors
        at the plate were 2.3 for one-step methods and 70 for multistep methods, which take many
        steps; the pitches included steep ones (`tests/engines/test_contact.py`).
        """
        if self.method == "Taylor":
            return 2e-14
        multiple = 100 if self.method in ("BDF", "LSODA") else 10  # free choices above these
        return multiple * max(self.tolerances.values())

    def steps(
        self,
        law: Law,
        start: State,
        begin: float,
        limit: float,
        events: Events,
    ) -> Iterator[PolynomialPiece]:
        """Yield the pieces of a flight; see `longball.engines.path_engine.PathEngine.steps`.

        Raises `OutOfRange` or `TooLong` if solve_ivp gives up, or the flight takes too many steps.
        """
        rates, taylor = right_hand_side(law), self.method == "Taylor"
        time, state = begin, np.array(start, dtype=float)
        taken = 0
        while time < limit:
            # the rest of the flight, if it is uniform motion
            if taken > 0 and (uniform := _uniform(law, time, state, limit)):
                yield uniform
                return
            if not taylor and not np.isfinite(rates(time, state)).all():
                raise OutOfRange(_BEYOND)

            # the events that end the integration
            # If two terminal events occur in one step, solve_ivp reports the first of the list.
            # `events` lists the ground first; reversed, any other event is reported instead.
            ends = [terminal(event.name, event.value, law.state) for event in reversed(events)]
            # `terminal` asks once for each time, and so once for each step.
            countdown = partial(lambda left, _: next(left), count(_MANY_STEPS, -1))
            ends.append(terminal("many steps", countdown, law.state))

            # the integration
            # A trial step may overflow; the step control then takes a shorter one or gives up.
            with np.errstate(all="ignore"):
                solution = scipy.integrate.solve_ivp(
                    rates,
                    (time, limit),
                    state,
                    method=Taylor if taylor else self.method,
                    dense_output=True,
                    events=ends,
                    **({"law": law, "until": ends} if taylor else self.tolerances),
                )

            # its steps, as polynomials
            for piece in _pieces(law, solution):
                taken += 1
                if taken > _MOST_STEPS:
                    raise TooLong(
                        f"the flight takes over {_MOST_STEPS} steps; try a shorter time_limit"
                    )
                yield piece
            if solution.status < 0:
                reached = solution.t[-1]
                raise OutOfRange(f"solve_ivp gave up at t = {reached:.6g} s: {solution.message}")
            last = solution.sol.interpolants[-1]
            time, state = float(last.t), last(last.t)

    def touch(
        self,
        pitch: Flight,
        law: Law,
        bat: BatSection,
        events: Events,
        limit: float,
    ) -> Touch:
        """Fly the pitch again, to the bat, whose height is known only now. See `Engine.touch`."""
        # If the ball enters and leaves the bat within a step, only the closest approach changes its
        # sign from one end of the step to the other.
        reach = bat.reach
        contact = Event("contact", "the ball touches the bat", bat.outside, reach * reach)
        question = "the ball is closest to the bat"
        closest = Event("closest approach", question, lambda state: -bat.approach(state), reach)
        pieces = self.pieces(law, pitch.path.at(0.0), limit, [*events, contact, closest])
        return super().touch(replace(pitch, path=Path(pieces)), law, bat, events, limit)

    def search_pieces(
        self, pitch: Flight, law: Law, bat: BatSection
    ) -> Iterator[tuple[Piece, float, float, float]]:
        """Yield the pieces of a pitch in which to search for the contact.

        Near the plate, one Taylor expansion about the crossing, which is valid for its length on
        both sides of that time, replaces the pieces. The bat's
        height comes from the state at the crossing, too. An error of that state therefore moves bat
        and ball together, and cancels in their distance. A law with switches has no such expansion.
        """
        # error of a position near the plate, m
        error = self.flight_error * float(max(abs(bat.frame.x), abs(pitch.state.z)))
        if law.switches:
            for piece in pitch.path.pieces():
                yield piece, 0.0, piece.length, error
            return
        series, length = expand(law, np.array(pitch.state, dtype=float))
        if not length > 0:
            raise OutOfRange(_BEYOND)
        centred = PolynomialPiece(pitch.time, length, law.state, series)
        speed = math.hypot(*bat.frame.velocity(pitch.state))
        # Keep the expansion short: contact is a zero of d² - reach², whose rounding error grows
        # with the largest d² on the piece.
        near = bat.distance(pitch.state, self.numbers) + _NEAR * bat.reach
        half = min(centred.length, near / speed)
        begin, end = max(0.0, pitch.time - half), pitch.time + half
        seen = False
        for piece in pitch.path.pieces():
            if piece.begin < begin:
                yield piece, 0.0, min(piece.length, begin - piece.begin), error
            if piece.begin + piece.length >= begin and not seen:
                seen = True
                yield centred, begin - pitch.time, half, 0.0
            if piece.begin + piece.length > end:
                yield piece, max(0.0, end - piece.begin), piece.length, error


# The expansion at the plate extends beyond the bat by this multiple of R + r_b: far enough to pass
# the bat in a miss, and near enough to keep d² below a few dozen times (R + r_b)².
_NEAR = 4.0


def terminal(
    name: str, value: Callable[[Any], float], state: Callable[..., Any]
) -> Callable[[float, Array], float]:
    """Wrap an event for solve_ivp: a flight ends where its value falls to zero.

    Once it has been positive, the wrapped value is clipped at zero from below. Root finding then
    returns at once, with the end of the step; the exact time is found later, on the polynomial of
    the step. Values are cached by time: solve_ivp evaluates the end of a step twice, from the state
    and from the interpolant, and rounding may give the two opposite signs.
    """
    known: dict[float, float] = {}
    least = -math.inf

    def falls(time: float, y: Array) -> float:
        nonlocal least
        if time not in known:
            height = value(state(*y.tolist()))
            least = 0.0 if height > 0 else least
            known[time] = max(height, least)
        return known[time]

    falls.__name__ = name
    falls.terminal, falls.direction = True, -1  # type: ignore[attr-defined]
    return falls


def _pieces(law: Law, solution: Any) -> Iterator[PolynomialPiece]:
    """Yield the steps of solve_ivp as polynomials.

    The last one extends past the event that ended the integration. Methods other than Taylor's
    have interpolants of low order, which are replaced by the Taylor series at the beginning of the
    step. A step that is longer than its series converges is split.
    """
    for state, step in zip(solution.y.T, solution.sol.interpolants, strict=False):
        time, end = float(step.t_old), float(step.t)
        if isinstance(step, Series):
            for begin, until, series in step.parts:
                yield PolynomialPiece(begin, _length(begin, until), law.state, series)
            continue
        while time < end:
            series, reach = expand(law, state)
            if not reach > 0:
                raise OutOfRange(_BEYOND)
            until = min(time + reach, end)
            piece = PolynomialPiece(time, _length(time, until), law.state, series)
            yield piece
            time, state = until, np.array(piece.at(piece.length))


def _length(begin: float, end: float) -> float:
    """Return the length of a piece, rounded up so that it reaches its end."""
    length = end - begin
    return length if begin + length >= end else math.nextafter(length, math.inf)


# A light ball at its terminal speed V is a stiff problem: a disturbance decays within V/(2 g), and
# an explicit step cannot be much longer. By then the acceleration is zero to rounding, so the rest
# of the flight is uniform motion.
_SETTLED = 1e-14  # of gravity


def _uniform(law: Law, time: float, state: Array, limit: float) -> PolynomialPiece | None:
    """Uniform motion up to the limit; None if the ball has not settled to it."""
    # Motion stays uniform only if the law is the same everywhere: a law whose wind or density
    # depends on the position has s, y or z among its variables.
    gravity = law.strengths.get("gravity")
    if gravity is None or any(
        node.kind == "variable" and node.args[0] in "syz" for node in law.program.nodes
    ):
        return None
    slopes = []
    for rate, node in zip(law.rates(DOUBLES)(*state.tolist()), law.program.outputs, strict=True):
        if node.kind != "variable" and not abs(rate) <= _SETTLED * gravity:
            return None
        slopes.append(rate if node.kind == "variable" else 0.0)
    return PolynomialPiece(time, _length(time, limit), law.state, np.column_stack([state, slopes]))
