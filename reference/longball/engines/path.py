"""Flights as functions of time: the state at any time, and the first event.

A flight is a sequence of pieces, each a smooth function of time. They are computed on demand,
because the end of a flight is not known beforehand.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from longball.engines.event import Curve, Piece
from longball.model.frame import Frame
from longball.model.law import State
from longball.model.numbers import N, Numbers, Vector


class Path:
    """A flight from its launch, with pieces that are computed on demand.

    The pieces are in order of time; each begins at the end of the previous one.
    """

    def __init__(self, pieces: Iterable[Piece]) -> None:
        self._coming = iter(pieces)
        self._known: list[Piece] = []

    def pieces(self, number: int = 0) -> Iterator[Piece]:
        """Yield the pieces from the launch on, or from piece `number` on."""
        while True:
            if number == len(self._known):
                piece = next(self._coming, None)
                if piece is None:
                    return
                self._known.append(piece)
            yield self._known[number]
            number += 1

    def at(self, time: N) -> State:
        """Return the state at a time, s since the launch.

        Raises `ValueError` if the flight does not last so long, or the time is before the launch.
        """
        passed = bisect_left(self._known, True, key=lambda p: not time > p.begin + p.length)
        for piece in self.pieces(passed):
            if not time > piece.begin + piece.length:
                if time < piece.begin:
                    break
                return piece.at(time - piece.begin)
        raise ValueError(f"the flight has no state at t = {float(time)} s")


@dataclass(frozen=True)
class Flight:
    """A flight to its end: the path, the event that stopped it, its time, s, and the state.

    `stop` is the name of the event, or "time" for the time limit.
    """

    path: Path
    stop: str
    time: N
    state: State

    def stopped(self, name: str) -> Any:
        """True if an event of that name stopped it."""
        return self.stop == name

    def highest(self, numbers: Numbers) -> tuple[N, State] | None:
        """Return time, s since launch, and state at the highest point; None if it still rises."""
        top: tuple[N, State] | None = None
        start, rises = numbers.exact(0.0), True
        for piece in self.path.pieces():
            left = self.time - piece.begin
            climb, sink = piece.curve(lambda state: state.w), piece.curve(lambda state: -state.w)
            # The launch of a ball that falls, or the top between two pieces.
            if rises and not climb(start) > 0:
                state = piece.at(start)
                if top is None or state.z > top[1].z:
                    top = piece.begin, state
            over = not piece.length < left
            end = left if over else piece.length
            # Most pieces only climb or only sink, which is cheaper to see than where they turn.
            steady = climb.positive(start, end) or sink.positive(start, end)
            turns = [] if steady else [start, *climb.turns(start, end), end]
            for a, b in pairwise(turns):
                if climb(a) > 0 and not climb(b) > 0:
                    # w is zero exactly where the flight of a ball straight up is cut in two.
                    t = climb.zero(a, b) if climb(b) < 0 else b
                    state = piece.at(t)
                    if top is None or state.z > top[1].z:
                        top = piece.begin + t, state
            if over:
                break
            rises = climb(end) > 0
        return top

    def then(self, second: Flight) -> Flight:
        """Return this flight, continued by a second one from where it ends."""

        def pieces() -> Iterator[Piece]:
            for piece in self.path.pieces():
                if not piece.begin + piece.length < self.time:
                    yield Part(piece, self.time - piece.begin)
                    break
                yield piece
            for piece in second.path.pieces():
                # rounded such that the part reaches its end from its beginning
                begin, end = self.time + piece.begin, self.time + (piece.begin + piece.length)
                length = piece.length
                while begin + length < end:
                    length += end - (begin + length)
                yield Part(piece, length, self.time)

        return Flight(Path(pieces()), second.stop, self.time + second.time, second.state)


@dataclass(frozen=True)
class Part:
    """The first part of a piece, of a length, s, in a flight that begins `delay` earlier, s."""

    piece: Piece
    length: N
    delay: N | None = None

    @property
    def begin(self) -> N:
        """Time of the beginning, s since the launch."""
        return self.piece.begin if self.delay is None else self.delay + self.piece.begin

    def at(self, t: N) -> State:
        """Return the state at a time on the piece."""
        return self.piece.at(t)

    def curve(self, value: Callable[[Any], Any]) -> Curve:
        """Return the value of an event along the piece."""
        return self.piece.curve(value)


@dataclass(frozen=True)
class Leg:
    """A flight of a scene: when it begins, s since the start of the scene, and in which frame."""

    begin: N
    frame: Frame
    flight: Flight


@dataclass(frozen=True)
class Trajectory:
    """The trajectory from the start of a scene to its end: a pitch, a batted ball, or both."""

    legs: tuple[Leg, ...]

    @property
    def end(self) -> N:
        """Time of the end, s since the start of the scene."""
        return self.legs[-1].begin + self.legs[-1].flight.time

    def at(self, time: N) -> tuple[Vector, Vector]:
        """Return position, m, and velocity, m/s, at a time, s since the start of the scene.

        Where one flight ends and another begins, and within a radius of that, it is the other.

        Raises `ValueError` if the trajectory has no such time.
        """
        begun = [leg for leg in self.legs if not time < leg.begin]
        if not begun:
            raise ValueError(f"the trajectory has no state at t = {float(time)} s")
        leg = begun[-1]
        # A ball minus itself is not zero, but a ball around zero.
        since, flight = time * 0 if time is leg.begin else time - leg.begin, leg.flight
        if since > flight.time and not time > leg.begin + flight.time:
            since = flight.time  # the end is a rounded sum
        # The state at an event lies exactly on it; the state at the time limit may not be computed
        # yet.
        at_end = flight.stop != "time" and since == flight.time
        state = flight.state if at_end else flight.path.at(since)
        return leg.frame.position(state), leg.frame.velocity(state)

    def sample(self, times: Iterable[N]) -> list[tuple[N, ...]]:
        """Return x, y, z, m, and their rates, m/s, at some times; see `at`."""
        return [(*position, *velocity) for position, velocity in map(self.at, times)]

    def evenly(self, points: int, numbers: Numbers) -> list[tuple[N, ...]]:
        """Return t, s, x, y, z and their rates at evenly spaced times from beginning to end."""
        begin, end = self.legs[0].begin, self.end
        fractions = (
            numbers.exact(float(i)) / numbers.exact(float(points - 1)) for i in range(points)
        )
        times = [begin + (end - begin) * fraction for fraction in fractions]
        times[-1] = end
        return [(t, *row) for t, row in zip(times, self.sample(times), strict=True)]
