"""Engines with smooth flights: how they fly and how they meet the bat.

Such an engine computes a flight piece by piece, as smooth functions of time. The rest is here,
once for all of them: the switches of a law, the apex of a vertical flight, the first event, the
first touching of the bat.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from types import MappingProxyType
from typing import Any, NamedTuple

from longball.engines.engine import CannotSolve, Engine, TooLong, Touch
from longball.engines.event import (
    STARTS_INSIDE,
    TOUCHES,
    TURNS_VERTICAL,
    BatSection,
    Event,
    Events,
    Piece,
    first_fall,
    first_met,
    inside_bat,
    margin_error,
    past,
    zero_of,
)
from longball.engines.path import Flight, Part, Path
from longball.engines.polynomial import Dual
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers, doubt


class PathEngine(Engine, ABC):
    """An engine whose flights consist of smooth pieces."""

    @abstractmethod
    def steps(self, law: Law, start: State, begin: N, limit: N, events: Events) -> Iterator[Piece]:
        """Yield the pieces of a flight under a smooth law, up to a time.

        The flight starts at `begin` and may last until `limit`, s since the launch. It probably
        ends at one of the `events`; an engine that integrates ahead may pause there.
        """

    def pieces(self, law: Law, start: State, limit: N, events: Events = ()) -> Iterator[Piece]:
        """Yield the pieces of a flight from a launch, up to a time.

        One ends wherever the law switches to another branch; for `events` see `steps`.

        Raises `Undecided` if a flight only touches such a place, within its error; `TooLong` if it
        has more pieces than can be searched for such places within seconds.
        """
        begin = self.numbers.exact(0.0)
        if not law.switches:
            yield from self._smooth(law, start, begin, limit, events)
            return
        # A flight under a law with switches is a chain of smooth flights: fly on one branch up to
        # the first threshold, change the branch there, and launch again from that state.
        law = law.in_polynomials()
        branches = branches_at(law, start, self.numbers)
        start = law.on(branches).completed(start, self.numbers)
        passed: _SwitchEvent | None = None  # on whose threshold the form begins
        pieces = 0
        for _ in range(_MOST_BRANCHES):
            require_law(law, branches, begin)
            form = law.on(branches)
            ends = self._switch_events(form, branches, events)
            met, first = None, True
            stops = [*(event for event, *_ in ends), *events]
            for piece in self._smooth(form, start, begin, limit, stops):
                pieces += 1
                if pieces > _MOST_PIECES:
                    raise TooLong(
                        f"under a law with tables, or with wind above a height, the flight takes "
                        f"over {_MOST_PIECES} steps; try a shorter time_limit"
                    )
                met = self._first_switch(piece, ends, form, first, passed)
                if met is None:
                    yield piece
                    first = False
                    continue
                # the switch: cut the piece there, and begin another on the neighbouring branch
                time, passed = met
                if time != 0:
                    yield Part(piece, time)
                begin, start = piece.begin + time, piece.at(time)
                which = passed.which
                branches[which] += passed.direction
                # Where the wind sets in or ends, the airspeed jumps, and with it whatever the
                # tables depend on: their branches are looked up afresh.
                if law.switches[which].is_wind:
                    branches = branches_at(law, start, self.numbers, {which: branches[which]})
                    start = law.on(branches).completed(start, self.numbers)
                break
            if met is None:
                return
        raise CannotSolve(
            f"the flight passes nodes of tables, or the height where the wind sets in, over "
            f"{_MOST_BRANCHES} times"
        )

    def _switch_events(
        self, form: Law, branches: Sequence[int], events: Events
    ) -> list[_SwitchEvent]:
        """Return the events that switch from these branches of a law: the thresholds next to each.

        A height of the wind at which an event ends the flight is none: where the ground is the
        height above which the wind blows, a landing is a landing.
        """
        # threshold        0       1       2
        # branch       0   |   1   |   2   |   3
        #                  <-- - - -->           leaving branch 1: down (-1) or up (1)
        one, nothing = self.numbers.exact(1.0), self.numbers.exact(0.0)
        switching = []
        for which, (switch, branch) in enumerate(zip(form.switches, branches, strict=True)):
            for direction, number in ((-1, branch - 1), (1, branch)):
                if not 0 <= number < len(switch.thresholds):
                    continue
                threshold = switch.thresholds[number]
                if switch.is_wind and direction < 0:
                    # Dual numbers tell whether an event's value is zero at that height wherever
                    # else the ball is: the value, and its rate if all else changes, are both 0.
                    anywhere = form.state(*(Dual(nothing, one) for _ in form.variables))
                    there = anywhere._replace(z=Dual(threshold, nothing))
                    values = [event.value(there) for event in events]
                    if any(value.value == 0 and value.rate == 0 for value in values):
                        continue
                value = form.beyond(switch, threshold, self.numbers)
                if direction > 0:  # events fall through zero, and this value rises
                    value = partial(lambda beyond, state: -beyond(state), value)
                size = self.numbers.where(threshold > 1, threshold, self.numbers.exact(1.0))
                event = Event("switch", switch.question, value, size)
                # Balls are equal if both their parts are.
                part = (
                    (threshold.mid(), threshold.rad()) if hasattr(threshold, "mid") else threshold
                )
                surface = form.switching_function(switch).outputs, part
                switching.append(_SwitchEvent(event, which, direction, surface))
        return switching

    def _first_switch(
        self,
        piece: Piece,
        ends: Sequence[_SwitchEvent],
        form: Law,
        first: bool,
        passed: _SwitchEvent | None,
    ) -> tuple[N, _SwitchEvent] | None:
        """First of the switching events on a piece, with its time.

        The `first` piece on a branch begins on the threshold that was `passed`; another switch of
        the same function may have that threshold, too.
        """
        found = []
        for end in ends:
            event = end.event
            error = self.numbers.exact(self.flight_error) * event.size
            curve = piece.curve(event.value)
            # Forces are the same on both sides of a node: a touch within an error that is not
            # proven changes them by as little.
            touch_matters = self.flight_error == 0.0 or form.switches[end.which].is_wind
            question = event.question if touch_matters else None
            # As at a launch: a piece may begin on the threshold that the one before ended on.
            time = first_fall(
                curve, piece.length, error, question, self.numbers,
                launch=first or self.flight_error > 0.0,
                on_surface=passed is not None and end.surface == passed.surface,
                stays=False,
            )  # fmt: skip
            if time is not None:
                found.append((time, end))
        return min(found, key=lambda each: each[0], default=None)

    def _smooth(
        self, law: Law, start: State, begin: N, limit: N, events: Events
    ) -> Iterator[Piece]:
        """Yield the pieces of a flight; one that is vertical is flown up, and then down.

        A ball that moves vertically through the air comes to rest in it at its apex, where the drag
        k V² has a kink. So it flies up and down under two laws, in which V is w and -w.
        """
        nothing = self.numbers.exact(0.0)

        # Where the ball is at rest, a part of its spin across the velocity has no direction.
        try:
            law.rates(self.numbers)(*start)
        except ZeroDivisionError:
            raise CannotSolve(RESTS_WITH_SPIN) from None

        # vertical
        up = down = None
        *level, wind = law.drift(nothing)
        drifts = [start.u, getattr(start, "v", nothing)] == level
        if drifts and (start.w > wind or start.w <= wind):  # balls may satisfy neither
            up, down = (law.straight(self.numbers.exact(sense)) for sense in (1.0, -1.0))
        if up is None or down is None:
            yield from self.steps(law, start, begin, limit, events)
            return
        # upwards to the apex, then downwards; or downwards at once
        if start.w > wind:
            # A ball that moves vertically comes to rest in air that rises at `wind`.
            apex = Event(
                "apex",
                "the ball comes to rest",
                lambda state: state.w - wind,
                size=1.0,
                place=lambda state: state._replace(w=wind),
            )
            for piece in self.steps(up, start, begin, limit, [apex, *events]):
                top = first_fall(
                    piece.curve(apex.value), piece.length, nothing, apex.question, self.numbers
                )
                if top is None:
                    yield piece
                    continue
                yield Part(piece, top)
                begin, start = piece.begin + top, apex.place(piece.at(top))
                break
            else:
                return
        yield from self.steps(down, start, begin, limit, events)

    def fly(self, law: Law, start: State, events: Events, limit: N) -> Flight:
        """Fly until the first of several events; see `Engine.fly`."""
        path = Path(self.pieces(law, start, limit, events))
        met = first_met(path.pieces(), events, limit, self.flight_error, self.numbers)
        if met is None:
            return Flight(path, "time", limit, path.at(limit))
        return Flight(path, met.event.name, met.time, met.state)

    def search_pieces(
        self, pitch: Flight, law: Law, bat: BatSection
    ) -> Iterator[tuple[Piece, N, N, N]]:
        """Yield the pieces of a pitch in which to search for the contact with the bat.

        Each piece comes with the beginning and the end of the search on it, s, of which the
        beginning may be negative; and with the error of the distance to the bat, m, in addition to
        `event.margin_error`.
        """
        nothing = self.numbers.exact(0.0)
        for piece in pitch.path.pieces():
            yield piece, nothing, piece.length, nothing

    def touch(self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: N) -> Touch:
        r"""Find how a pitch that has reached the plate meets the bat; see `Engine.touch`.

        The distance to the bat falls to a minimum, rises to a maximum, and so on. The pitch
        touches the bat if a minimum is nearer than `reach` by more than the error; the touching
        itself lies before the first such minimum::

              |\          /\
            d | \        /  \          /
              |  \______/    \        /
        reach-+---------------*------/-----
              |                \____/
        """
        numbers = self.numbers

        # the release, which must not lie in the bat
        error = margin_error(bat, pitch.state.z, self.flight_error, numbers)
        launch = pitch.path.at(numbers.exact(0.0))
        gap = bat.distance(launch, numbers) - bat.reach
        if gap < -error:
            raise inside_bat(bat.distance(launch, numbers), bat.reach)
        if not (gap == 0 or gap > error):
            numbers.positive(gap, error, STARTS_INSIDE)

        # a release on the bat's surface, towards it, is the touching
        touching: tuple[N, State] | None = None
        if not gap > error and bat.approach(launch) < 0:
            touching = numbers.exact(0.0), launch

        # the end of the search: behind the bat, on the ground, vertical, or the time limit
        ends = [past(bat.frame, bat.reach, numbers), *events]
        met = first_met(pitch.path.pieces(), ends, limit, self.flight_error, numbers)
        search_end = limit if met is None else met.time
        # A piece on which the ball stays farther away than it is at the plate has no minimum that
        # matters: the margin is at least that of the plate.
        at_plate = bat.distance(pitch.state, numbers)
        near = at_plate if at_plate > bat.reach else bat.reach

        # the approaches, with the largest margin of all
        # Of each, the state at its end, and the error of the margin there. One that ends with its
        # piece is `pending`: the next piece shows whether the distance continues to fall, or has
        # turned.
        closest = -gap
        pending: tuple[State, N] | None = None
        for piece, since, until, off in self.search_pieces(pitch, law, bat):
            left = search_end - piece.begin
            over = not until < left
            end = left if over else until
            curve = piece.curve(bat.outside)
            far = curve if near is bat.reach else piece.curve(partial(bat.outside, reach=near))
            turns = []
            if far(since) > 0 and far.positive(since, end):
                pending = None
            else:
                turns = [since, *curve.turns(since, end), end]
            for a, b in pairwise(turns):
                if not curve(b) >= curve(a):  # it falls, or may fall by interval arithmetic
                    if touching is None and curve(b) < 0:
                        t = zero_of(curve, a, b, TOUCHES, numbers)
                        touching = piece.begin + t, piece.at(t)
                    approach, turned = (piece.at(b), error + off), b is not end or over
                    pending = None if turned else approach
                elif pending is not None:  # it turned where pieces join
                    approach, turned, pending = pending, True, None
                else:
                    continue

                # the margin, which decides the contact where the distance has turned
                nearest, slack = approach
                margin = bat.reach - bat.least_distance(nearest, numbers)
                if margin > closest:
                    closest = margin
                elif not margin <= closest:  # of two numbers with radii neither may be the larger
                    closest = (margin + closest + abs(margin - closest)) / 2
                if turned and not abs(margin) > slack:
                    return Touch(margin, None, doubt=doubt(margin, slack, TOUCHES, numbers))
                if turned and margin > error and touching is not None:
                    return Touch(margin, True, *touching)
            if over:
                break
        if met is not None and met.event.name == "vertical":
            raise CannotSolve(TURNS_VERTICAL)
        return Touch(closest, False)


# A flight passes a node of a table twice, or a few times more if it loops.
_MOST_BRANCHES = 1000  # a free choice
# Each piece is searched for the ends of the law's form, in up to a millisecond.
_MOST_PIECES = 10_000  # a free choice


class _SwitchEvent(NamedTuple):
    """A switching event: its switch, by number, its direction, and the surface that is crossed."""

    event: Event
    which: int
    direction: int
    surface: tuple[Any, Any]  # the switching function, and the threshold


RESTS_WITH_SPIN = (
    "the ball starts at rest in the air, or along its spin, where the part of the spin across the "
    "velocity has no size or no direction; take the reading spin_parameter = total, a lift that is "
    "linear in the spin, or another velocity"
)


# --- the branches of a law with switches ----------------------------------------------------------


def branches_at(
    law: Law,
    state: State,
    numbers: Numbers,
    known: Mapping[int, int] = MappingProxyType({}),  # branches that stay, by the number of switch
    error: N = 0.0,  # of the switching functions
    sense: int = 1,  # on a threshold: 1 for the branch that the flight enters, -1 if it leaves it
) -> list[int]:
    """Branch of each switch of a law in a state.

    Raises `Undecided` if the state is within the error, or the radius of a ball, of a threshold.
    """
    branches = [known.get(which, 0) for which in range(len(law.switches))]
    # The wind's switch first: the others depend on the airspeed.
    for which, switch in sorted(
        enumerate(law.switches), key=lambda numbered: not numbered[1].is_wind
    ):
        if which in known:
            continue
        form = law.on(branches)
        state = form.completed(state, numbers)
        for threshold in switch.thresholds:
            value = form.beyond(switch, threshold, numbers)
            there, off = value(state), error
            # Exactly on the threshold, the direction in which the flight passes it decides. It is
            # exact, too: a state that lies there was put there.
            if there == 0:
                moving = map(Dual, state, form.rates(numbers)(*state))
                there, off = sense * value(law.state(*moving)).rate, error * 0
            question = f"whether {switch.question}"
            # The thresholds rise, so that the branch is the number of those below the value.
            branches[which] += numbers.positive(there, off, question)
    return branches


def form_at(law: Law, state: State, numbers: Numbers) -> Law:
    """Return the law on the branches of a state; see `branches_at`."""
    return law.on(branches_at(law, state, numbers)) if law.switches else law


def arrived(law: Law, state: State, numbers: Numbers, error: N) -> Law:
    """Return the law on the branch by which the spin decays in a state that a flight has reached.

    On a threshold, that is the branch on which the flight came. Switches that do not matter to the
    spin are left on their first branches.

    Raises `Undecided` if the state is within an `error` of a threshold.
    """
    if not law.switches:
        return law
    known = {n: 0 for n in range(len(law.switches)) if n not in law.switches_of_spin}
    return law.on(branches_at(law, state, numbers, known, error, -1))


def require_law(law: Law, branches: Sequence[Any], time: Any) -> None:
    """Raise `CannotSolve` if a side force has no direction on these branches.

    The time, s since the launch, is for the message.
    """
    for switch, branch in zip(law.switches, branches, strict=True):
        if switch.ends_law and branch == 0:
            raise no_direction(time)


def no_direction(time: Any) -> CannotSolve:
    """Return the error of a side force that has no direction at a time, s since the launch."""
    return CannotSolve(
        "the side force has no direction where the airspeed is parallel to "
        f"air.side_coefficient.direction, as it is {float(time):.6g} s after the ball is set free; "
        "take another direction, or a time_limit before that"
    )
