"""A flight that one can ask, and how engines with smooth flights fly and meet the bat.

An engine gives a flight piece by piece, as smooth functions of time; everything else is here, once:
the state at any time, the first event, the first touching of the bat.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, cast

from longball.engines.event import Curve, Event, Piece, first_fall, first_met
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers


class CannotSolve(ArithmeticError):
    """An engine's reason for giving no answer to a scene."""


class Path(Generic[N]):
    """A flight from its launch, as far as one looks.

    Parameters
    ----------
    pieces
        In order of time, each beginning where the one before ends. They are taken when needed.
    """

    def __init__(self, pieces: Iterable[Piece[N]]) -> None:
        self._coming = iter(pieces)
        self._known: list[Piece[N]] = []

    def pieces(self) -> Iterator[Piece[N]]:
        """Yield the pieces from the launch on."""
        number = 0
        while True:
            if number == len(self._known):
                piece = next(self._coming, None)
                if piece is None:
                    return
                self._known.append(piece)
            yield self._known[number]
            number += 1

    def at(self, time: N) -> State[N]:
        """Return the state at a time, s since the launch.

        Raises
        ------
        ValueError
            If the flight does not last so long, or the time is before the launch.
        """
        for piece in self.pieces():
            if not time > piece.begin + piece.length:
                if time < piece.begin:
                    break
                return piece.at(time - piece.begin)
        raise ValueError(f"the flight has no state at t = {float(cast(Any, time))} s")


@dataclass(frozen=True)
class Flight(Generic[N]):
    """A flight to its end: the way there, what stopped it, when (s since launch), in what state.

    `stop` is the name of an event, or "time" for the time limit.
    """

    path: Path[N]
    stop: str
    time: N
    state: State[N]


@dataclass(frozen=True)
class Part(Generic[N]):
    """The beginning of a piece."""

    piece: Piece[N]
    length: N

    @property
    def begin(self) -> N:
        """When it begins, s since the launch."""
        return self.piece.begin

    def at(self, t: N) -> State[N]:
        """Return the state at a time on the piece."""
        return self.piece.at(t)

    def curve(self, value: Callable[[Any], Any]) -> Curve[N]:
        """Return the value of an event along the piece."""
        return self.piece.curve(value)


class PathEngine(ABC, Generic[N]):
    """An engine whose flights are smooth, piece by piece."""

    @property
    @abstractmethod
    def description(self) -> str:
        """Name and settings, as the result states them."""

    @property
    @abstractmethod
    def numbers(self) -> Numbers[N]:
        """The number system."""

    @property
    @abstractmethod
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size.

        0 where the number carries its own error.
        """

    @abstractmethod
    def steps(
        self, law: Law[N], start: State[N], begin: N, limit: N, events: Sequence[Event[N]]
    ) -> Iterator[Piece[N]]:
        """Yield the pieces of a flight under a law that is smooth all the way, up to a time.

        Parameters
        ----------
        start
            The state at `begin`, s since the launch.
        limit
            Until when, s since the launch.
        events
            Where the flight is likely to end: an engine that integrates ahead may stop there and
            go on when it is asked for more.
        """

    def path(
        self, law: Law[N], start: State[N], limit: N, events: Sequence[Event[N]] = ()
    ) -> Path[N]:
        """Return the flight from a launch, up to a time."""
        return Path(self._pieces(law, start, limit, events))

    def _pieces(
        self, law: Law[N], start: State[N], limit: N, events: Sequence[Event[N]]
    ) -> Iterator[Piece[N]]:
        """Yield the pieces of a flight: a vertical one in two, on either side of its apex.

        There the ball is at rest, and the drag of V² has a kink.
        """
        begin = self.numbers.exact(0.0)
        up = down = None
        if start.u == 0:
            up, down = (law.straight(self.numbers.exact(sense)) for sense in (1.0, -1.0))
        if up is None or down is None:
            yield from self.steps(law, start, begin, limit, events)
            return
        if start.w > 0:
            for piece in self.steps(up, start, begin, limit, [APEX, *events]):
                top = first_fall(
                    piece.curve(APEX.value), piece.length, begin, APEX.question, self.numbers
                )
                if top is None:
                    yield piece
                    continue
                yield Part(piece, top)
                begin, start = piece.begin + top, APEX.place(piece.at(top))
                break
            else:
                return
        yield from self.steps(down, start, begin, limit, events)

    def fly(self, law: Law[N], start: State[N], events: Sequence[Event[N]], limit: N) -> Flight[N]:
        """Fly until the first of several events, or to the time limit, s.

        Raises
        ------
        CannotSolve, Undecided
        """
        path = self.path(law, start, limit, events)
        met = first_met(path.pieces(), events, limit, self.flight_error, self.numbers)
        if met is None:
            return Flight(path, "time", limit, path.at(limit))
        return Flight(path, met.event.name, met.time, met.state)


APEX: Event[Any] = Event(
    "apex",
    "the ball comes to rest",
    lambda state: state.w,
    lambda state: state._replace(w=state.w * 0),
    1.0,
)
