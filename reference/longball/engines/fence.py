"""The fence: the point at which a batted ball leaves the field or hits the fence.

A fence is a line of straight chords on the ground, with a height that is linear along each, or a
circle of height 0 around the plate. A flight in a vertical plane can reach one point of the fence
ahead and one behind, which are computed before the flight (`stop_at`). For a flight that curves in
space, crossings of every chord's line are searched (`first_crossing`). A ball that passes an end of
the fence, or a step in its height, within its error is undecided.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from longball.engines.event import Curve, Event, Piece
from longball.model.frame import Frame
from longball.model.law import State
from longball.model.numbers import N, Numbers, Vector


class Place(NamedTuple):
    """A point on a fence."""

    height: N  # of the fence's top there, m
    segment: Any  # number of the chord
    margin: N | None  # m, along the chord to the next vertex; None on a circle
    to_break: N  # m, to the next vertex at which the fence ends or has two heights
    slope: N  # of the height along the chord


@dataclass(frozen=True)
class Chord:
    """A chord from a to b, [x, y, height] each, m.

    `open_a` and `open_b` are True if the fence ends there, or continues at another height.
    """

    segment: int
    a: tuple[N, N, N]
    b: tuple[N, N, N]
    length: N
    open_a: bool
    open_b: bool

    def place(self, fraction: N, to_end: N, to_break: N, numbers: Numbers) -> Place:
        """Return the point at a fraction of the chord from a to b; `to_end` is ``1 - fraction``."""
        rise = self.b[2] - self.a[2]
        shorter = numbers.where(to_end < fraction, to_end, fraction)
        height = self.a[2] + fraction * rise
        return Place(height, self.segment, shorter * self.length, to_break, rise / self.length)

    def inside(self, position: Sequence[Any]) -> Any:
        """Return the signed distance inside the chord's line, times the chord's length, m²."""
        (ax, ay, _), (bx, by, _) = self.a, self.b
        return (by - ay) * (position[0] - ax) - (bx - ax) * (position[1] - ay)

    def passed(self, position: Vector, slack: N, numbers: Numbers) -> Place | None:
        """Return the point of the chord at a position on its line; None beyond the ends + slack."""
        (ax, ay, _), (bx, by, _), (x, y, _) = self.a, self.b, position
        length, far = self.length, numbers.exact(_FAR)
        ahead = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length
        if ahead < -slack or ahead > length + slack:
            return None
        to_a = abs(ahead) if self.open_a else far
        to_b = abs(length - ahead) if self.open_b else far
        to_break = to_b if to_b < to_a else to_a
        return self.place(ahead / length, (length - ahead) / length, to_break, numbers)


# Distance to a vertex, or to the fence, where there is none, m.
_FAR = 1e30  # a free choice


def chords(polyline: Sequence[Sequence[float]], numbers: Numbers) -> list[Chord]:
    """Return the chords of a polyline; a step of the height, at one place, is no chord."""
    sides = [
        (i, a, b) for i, (a, b) in enumerate(pairwise(polyline)) if tuple(a[:2]) != tuple(b[:2])
    ]
    made = []
    for n, (i, a, b) in enumerate(sides):
        before, after = sides[n - 1] if n else None, sides[n + 1] if n + 1 < len(sides) else None
        x, y, h = (numbers.exact(v) for v in a)
        u, v, k = (numbers.exact(v) for v in b)
        goes_on = before is not None and tuple(before[2]) == tuple(a)
        ends = after is None or tuple(after[1]) != tuple(b)
        length = numbers.sqrt((u - x) * (u - x) + (v - y) * (v - y))
        made.append(Chord(i, (x, y, h), (u, v, k), length, not goes_on, ends))
    return made


# --- flights in a vertical plane ------------------------------------------------------------------


def stop_at(
    fence: Any, frame: Frame, s: N, sense: int, error: N, numbers: Numbers
) -> tuple[N, Place]:
    """First crossing of the fence by a ball that flies from s along its heading, or against it.

    Returns the distance along the flight's plane, m, and the point of the fence there.

    `sense` is 1 along the heading, -1 against it; `error` is the relative error of directions. If
    there is no crossing, the distance is `_FAR`. The function uses masks in place of branches, so
    that it accepts columns of flights.
    """
    zero, one, far = numbers.exact(0.0), numbers.exact(1.0), numbers.exact(_FAR)
    nowhere = Place(zero, 0, None if fence.polyline is None else zero, far, zero)

    def along(vertex: Sequence[N]) -> N:
        return frame.cos * (vertex[0] - frame.x) + frame.sin * (vertex[1] - frame.y)

    def seen(vertex: Sequence[N], is_open: bool) -> tuple[Any, N, Any]:
        """True if left of the flight or on it; the offset from it; True for an open end on it."""
        x, y = vertex[0] - frame.x, vertex[1] - frame.y
        aside = sense * (frame.cos * y - frame.sin * x)
        # ^ True negates a bool and an array of them alike (`longball.model.numbers`).
        on = (abs(aside) > error * (abs(x) + abs(y))) ^ True
        return (aside < 0) ^ True, aside, on & is_open

    if fence.polyline is None:
        # |r₀ + s h| = radius for the unit heading h: s = -r₀·h ± √((r₀·h)² + radius² - r₀²)
        radius = numbers.exact(fence.radius)
        ahead = frame.x * frame.cos + frame.y * frame.sin
        inside = radius * radius - frame.x * frame.x - frame.y * frame.y
        return sense * numbers.sqrt(ahead * ahead + inside) - ahead, nowhere
    nearest, first = sense * far, nowhere
    for chord in chords(fence.polyline, numbers):
        left_a, aside_a, near_a = seen(chord.a, chord.open_a)
        left_b, aside_b, near_b = seen(chord.b, chord.open_b)
        # Outwards is from right to left of the heading as the chords run: a on the left, b on the
        # right. The offsets of a and b divide the chord at the crossing, without cancellation.
        hit = left_a & (left_b ^ True)
        at_b = numbers.where(near_b, one, zero)
        apart = numbers.where(hit, aside_a - aside_b, one)
        fraction = numbers.where(hit, aside_a / apart, at_b)
        to_end = numbers.where(hit, -aside_b / apart, 1 - at_b)
        there = along(chord.a) * to_end + along(chord.b) * fraction
        # Beside an open end, the offset of the heading is how far the ball passes it.
        open_a = abs(aside_a) if chord.open_a else far
        open_b = abs(aside_b) if chord.open_b else far
        place = chord.place(
            fraction, to_end, numbers.where(open_b < open_a, open_b, open_a), numbers
        )
        # Keep the nearest of several crossings ahead of s.
        nearer = (hit | near_a | near_b) & (sense * (there - s) > 0)
        nearer = nearer & (sense * (there - nearest) < 0)
        nearest = numbers.where(nearer, there, nearest)
        first = Place(*(numbers.where(nearer, a, b) for a, b in zip(place, first, strict=True)))
    return nearest, first


def at_stop(name: str, s: N, sense: int, numbers: Numbers) -> Event:
    """Event: a flight in a vertical plane reaches the fence, at a distance along its plane, m."""
    return Event(
        name,
        "the ball reaches the fence",
        lambda state: sense * (s - state.s),
        numbers.where(abs(s) > 1, abs(s), numbers.exact(1.0)),
        place=lambda state: state._replace(s=s),
    )


# --- flights in space -----------------------------------------------------------------------------


class Crossing(NamedTuple):
    """The first point at which a flight reaches the fence; the time is in s since the launch.

    The crossing is `doubtful` if the ball comes within the error of the fence, and may not reach
    it.
    """

    time: N
    state: State
    place: Place
    doubtful: bool


def first_crossing(
    fence: Any,
    frame: Frame,
    pieces: Iterator[Piece],
    end: N,  # s since the launch
    late: N,  # error of the end, s
    error: N,  # of a state, relative to its size
    numbers: Numbers,
) -> Crossing | None:
    """First crossing of the fence by a flight in space; None if there is none before its end."""
    zero, one, far = numbers.exact(0.0), numbers.exact(1.0), numbers.exact(_FAR)

    def size(state: State) -> N:
        x, y, _ = frame.position(state)
        return one + abs(x) + abs(y)

    # Each chord, or None for the circle, with a function of the state, m², that falls through zero
    # where a ball crosses the line outwards. The functions are polynomials of the position, so that
    # the search for events can use them.
    lines: list[tuple[Chord | None, Any]]
    if fence.polyline is None:
        radius = numbers.exact(fence.radius)

        def within(state: Any) -> Any:
            x, y, _ = frame.position(state)
            return radius * radius - (x * x + y * y)

        lines = [(None, within)]
    else:
        lines = [
            (chord, lambda state, chord=chord: chord.inside(frame.position(state)))
            for chord in chords(fence.polyline, numbers)
        ]

    # The chords of a fence are searched piece by piece: the first crossing of a piece is the first
    # of the flight.
    for piece in pieces:
        left = end - piece.begin
        goes_on = piece.length < left
        until = piece.length if goes_on else left
        moved: N | None = None
        if not goes_on:  # an error of the time of the end moves the ball there
            u, v, _ = frame.velocity(piece.at(until))
            moved = late * (abs(u) + abs(v))
        crossings: list[Crossing] = []
        for chord, value in lines:
            # The gradient of the value: 2 |r| of radius² - r², and the chord's length of the other.
            length = size(piece.at(zero))
            slope = 2 * length if chord is None else chord.length
            off = error * length * slope
            at_end = None if moved is None else off + moved * slope
            for t, doubtful in falls(piece.curve(value), until, off, at_end):
                state = piece.at(t)
                place: Place | None = Place(zero, 0, None, far, zero)
                if chord is not None:
                    # A crossing within the error of an end counts for both chords that meet there.
                    place = chord.passed(frame.position(state), error * size(state), numbers)
                if place is not None:
                    crossings.append(Crossing(piece.begin + t, state, place, doubtful))
        if crossings:
            return min(crossings, key=lambda crossing: crossing.time)
        if not goes_on:
            return None
    return None


def falls(curve: Curve, end: N, error: N, at_end: N | None) -> Iterator[tuple[N, bool]]:
    """Yield all times at which a value falls, or may fall, through zero on a piece.

    The flag of each time is True for a turning point within the error of zero, where it is open
    whether the value reaches zero. The end of a flight counts as a turning point, with the error
    `at_end`; None if the flight continues. Unlike `first_fall`, this yields all times and decides
    nothing, because a fall through the line of a chord may be beyond the ends of the chord.
    """
    start = end * 0
    if at_end is None and curve.positive(start, end) and curve(start) > 2 * error:
        return
    for left, right in pairwise([start, *curve.turns(start, end), end]):
        before, after = curve(left), curve(right)
        if before < -error or not after < before:
            continue
        if after < -error:
            yield curve.zero(left, right), False
        elif right is not end:
            if not after > error:
                yield right, True
        elif at_end is not None and not after > at_end:
            yield right, True
