"""Engines with smooth flights: how they fly and how they meet the bat.

Such an engine gives a flight piece by piece, as smooth functions of time. All else is here, once:
the apex of a vertical flight, the first event, the first touching of the bat.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import Any, Generic, cast

from longball.engines.contact import (
    STARTS_INSIDE,
    TOUCHES,
    TURNS_VERTICAL,
    BatSection,
    inside_bat,
    margin_error,
)
from longball.engines.engine import CannotSolve, Touch
from longball.engines.event import Event, Piece, first_fall, past
from longball.engines.path import Flight, Part, Path, Rest
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers, doubt


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
        """Yield the pieces of a flight: one of a ball at rest, two of one that flies vertically.

        At its apex it is at rest, and the drag of V² has a kink.
        """
        begin = self.numbers.exact(0.0)
        if all(cast(Any, rate) == 0 for rate in law.rates(self.numbers)(*start)):
            yield Rest(begin, limit, start)
            return
        up = down = None
        if cast(Any, start.u) == 0 and (start.w > 0 or start.w <= 0):  # for certain
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
        met = path.first(events, limit, self.flight_error, self.numbers)
        if met is None:
            return Flight(path, "time", limit, path.at(limit))
        return Flight(path, met.event.name, met.time, met.state)

    def views(self, pitch: Flight[N], law: Law[N], bat: BatSection[N]) -> Iterator[View[N]]:
        """Yield the pieces of a pitch, for the search for the bat."""
        nothing = self.numbers.exact(0.0)
        for piece in pitch.path.pieces():
            yield View(piece, nothing, piece.length, nothing)

    def touch(
        self,
        pitch: Flight[N],
        law: Law[N],
        bat: BatSection[N],
        events: Sequence[Event[N]],
        limit: N,
    ) -> Touch[N]:
        """Find how a pitch that has reached the plate meets the bat; see `Engine.touch`.

        The distance to the bat falls to a minimum, rises to a maximum, and so on; a touching is
        settled at the first minimum that is certainly nearer than `reach`, and lies before it.
        """
        numbers = self.numbers
        error = margin_error(bat, pitch.state.z, self.flight_error, numbers)
        launch = pitch.path.at(numbers.exact(0.0))
        gap = bat.distance(launch, numbers) - bat.reach
        if gap < -error:
            raise inside_bat(bat.distance(launch, numbers), bat.reach)
        if not (cast(Any, gap) == 0 or gap > error):
            numbers.positive(gap, error, STARTS_INSIDE)
        first: tuple[N, State[N]] | None = None
        if not gap > error and bat.approach(launch) < 0:
            first = numbers.exact(0.0), launch
        closest = -gap
        for way in self._ways_in(pitch, law, bat, events, limit, first):
            margin = bat.reach - bat.distance(way.end, numbers)
            closest = margin if margin > closest else closest
            if way.settled and not abs(margin) > error + way.error:
                return Touch(margin, None, doubt=doubt(margin, error + way.error, TOUCHES, numbers))
            if way.settled and margin > error and way.touching is not None:
                return Touch(margin, True, *way.touching)
        return Touch(closest, False)

    def _ways_in(
        self,
        pitch: Flight[N],
        law: Law[N],
        bat: BatSection[N],
        events: Sequence[Event[N]],
        limit: N,
        touching: tuple[N, State[N]] | None,
    ) -> Iterator[_WayIn[N]]:
        """Yield the parts of a pitch on which it comes closer to the bat.

        `touching` is when, s, and in what state the two touch at once, if they do.
        """
        numbers = self.numbers
        ends = [past(bat.frame, bat.reach, numbers), *events]
        met = pitch.path.first(ends, limit, self.flight_error, numbers)
        search_end = limit if met is None else met.time
        at_plate = bat.distance(pitch.state, numbers)
        near = at_plate if at_plate > bat.reach else bat.reach
        pending: _WayIn[N] | None = None
        for view in self.views(pitch, law, bat):
            piece = view.piece
            left = search_end - piece.begin
            over = not view.until < left
            end = left if over else view.until
            far = piece.curve(partial(bat.beyond, near))
            if far(view.since) > 0 and far.positive(view.since, end):
                pending = None
            else:
                curve = piece.curve(bat.depth)
                for a, b in pairwise([view.since, *curve.turns(view.since, end), end]):
                    if curve(b) < curve(a):
                        if touching is None and curve(b) < 0:
                            t = curve.zero(a, b)
                            touching = piece.begin + t, piece.at(t)
                        settled = b is not end or over
                        pending = _WayIn(piece.at(b), touching, view.error, settled)
                        yield pending
                    elif pending is not None and not pending.settled:
                        yield replace(pending, settled=True)  # it turned where the pieces join
                        pending = None
            if over:
                break
        if met is not None and met.event.name == "vertical":
            raise CannotSolve(TURNS_VERTICAL)


APEX: Event[Any] = Event(
    "apex",
    "the ball comes to rest",
    lambda state: state.w,
    lambda state: state._replace(w=state.w * 0),
    1.0,
)


@dataclass(frozen=True)
class View(Generic[N]):
    """A piece of a pitch, or a part of it, in which the bat is looked for.

    Attributes
    ----------
    since, until
        The part, s since the piece begins; `since` may be negative.
    error
        Of the distance to a bat that is put at the height of the pitch at the plate, m, besides
        what `longball.engines.contact.margin_error` counts.
    """

    piece: Piece[N]
    since: N
    until: N
    error: N


@dataclass(frozen=True)
class _WayIn(Generic[N]):
    """A part of a pitch on which it comes closer to the bat.

    `end` is the state at its end; `touching` when, s, and in what state the two first touch, if
    they do; `settled` tells whether the distance turns there, or the search ends.
    """

    end: State[N]
    touching: tuple[N, State[N]] | None
    error: N
    settled: bool
