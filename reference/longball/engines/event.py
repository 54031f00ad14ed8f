"""Events of a flight, and the one search for them.

An event is where a function of the state falls through zero. A function may dip below zero and
come back within a step, so none is looked for by its signs at the ends of steps alone: its own
turning points divide a step into parts on which it only rises or only falls, and there the signs at
the ends tell everything. What its error leaves open is `Undecided`, in words that name the event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any, Generic, NamedTuple, Protocol

from longball.model.frame import Frame
from longball.model.law import State, in_plane
from longball.model.numbers import N, Numbers, Undecided, absolute


class Event(NamedTuple, Generic[N]):
    """Something that a flight can reach."""

    name: str  # under which a flight reports it
    question: str  # what is reached, as a clause: "the ball touches the ground"
    # From the components of a state to what falls through zero there. It is built of + - * only,
    # and so takes numbers and polynomials alike
    value: Callable[[Any], Any]
    place: Callable[[Any], Any]  # puts a state that is within rounding of the event onto it
    size: N  # what the error of the value is relative to, in its unit
    slope: N | float = 1.0  # by how much the value changes at most if a coordinate does, by 1 m


Events = Sequence[Event[N]]


def ground(height: N, start: State[N], numbers: Numbers[N]) -> Event[N]:
    """Return the landing of a flight that starts in a state, at a height, m."""
    return Event(
        "ground",
        "the ball touches the ground",
        lambda state: state.z - height,
        lambda state: state._replace(z=height),
        _size(numbers, height, start.z),
    )


def level(height: N, start: State[N], numbers: Numbers[N]) -> Event[N]:
    """Return where a flight from a state below a height, m, rises to it."""
    return Event(
        "level",
        "the ball rises to the height that it lands at",
        lambda state: height - state.z,
        lambda state: state._replace(z=height),
        _size(numbers, height, start.z),
    )


def plate(frame: Frame[N], start: State[N], numbers: Numbers[N]) -> Event[N]:
    """Return the crossing of the plane x = 0 by a pitch in a frame, from a state.

    A pitch that flies along the plate's plane, from beside it, has an x far smaller than the way.
    """

    def place(state: State[N]) -> State[N]:
        return state._replace(s=-frame.x / frame.cos) if in_plane(state) else state

    slope = absolute(frame.cos) if in_plane(start) else numbers.exact(1.0)
    size = slope * _size(numbers, frame.x / slope)
    return Event("plate", "the ball reaches the plate", frame.towards_x, place, size, slope)


def vertical(start: State[N], numbers: Numbers[N]) -> Event[N]:
    """Return where a flight that starts in a state turns vertical, u falling to zero.

    A ball that all but rests at first may turn while u is as small as it was.
    """
    nothing, most = numbers.exact(0.0), numbers.exact(1.0)
    speed = absolute(start.u) + absolute(start.w)
    return Event(
        "vertical",
        "the ball turns vertical",
        lambda state: state.u,
        lambda state: state._replace(u=nothing),
        numbers.where(speed < most, speed, most),
        nothing,
    )


def past(frame: Frame[N], reach: N, numbers: Numbers[N]) -> Event[N]:
    """Return where a pitch has passed a bat that it touches at a distance `reach`, m."""
    return Event(
        "past",
        "the ball passes the bat",
        lambda state: frame.towards_x(state) + reach,
        lambda state: state,
        _size(numbers, frame.x, reach),
    )


def _size(numbers: Numbers[N], *lengths: N) -> N:
    """Return the largest of some lengths, and at least 1 m."""
    largest = numbers.exact(1.0)
    for length in map(absolute, lengths):
        largest = numbers.where(length > largest, length, largest)
    return largest


class Curve(Protocol[N]):
    """The value of an event along a piece, as a function of the time on the piece, s."""

    def __call__(self, t: N) -> N:
        """Return the value."""

    def positive(self, a: N, b: N) -> bool:
        """True only if the value certainly stays above half of its value at `a`, a positive one."""

    def turns(self, a: N, b: N) -> Sequence[N]:
        """Return where in (a, b) the value may turn, in rising order.

        Between two neighbours, and a and b, it only rises or only falls.
        """

    def zero(self, a: N, b: N) -> N:
        """Return where the value is zero, given that from a to b it falls through zero.

        At a it is certain on which side of zero the value is; see `zero_of`.
        """


class Piece(Protocol[N]):
    """A piece of a flight on which the state is a smooth function of time."""

    @property
    def begin(self) -> N:
        """When it begins, s since the launch."""

    @property
    def length(self) -> N:
        """Length, s."""

    def at(self, t: N) -> State[N]:
        """Return the state at a time on the piece, s since it begins."""

    def curve(self, value: Callable[[Any], Any]) -> Curve[N]:
        """Return the value of an event along the piece."""


def zero_of(curve: Curve[N], a: N, b: N, question: str, numbers: Numbers[N]) -> N:
    """Return where a value is zero that falls through zero from a to b; see `Curve.zero`.

    Raises `Undecided`, with the question, if a radius leaves open whether it fell before a.
    """
    there = curve(a)
    if not (there > 0 or there <= 0):
        _require_positive(there, numbers.exact(0.0), question, numbers)
    return curve.zero(a, b)


def first_fall(
    curve: Curve[N],
    end: N,  # until when, s since the piece begins
    error: N,  # how far the value may be off
    # What happens there, as a clause; None if a touch within the error is as good as none
    question: str | None,
    numbers: Numbers[N],
    # Whether the piece begins with the launch, whose value is exact. It may lie on the surface:
    # then it is an arrival, at 0, only if the value does not rise from there
    launch: bool = False,
    # Whether such a piece lies on the surface where its value is zero within a radius
    on_surface: bool = False,
    # Whether a value that stays on the surface from there on is an arrival
    stays: bool = True,
) -> N | None:
    r"""Return when a value first falls through zero on a piece; None if it does not.

    Between two turning points the value only falls or only rises, so that its sign at the right one
    tells everything about the part before it:

        \      2
         \    / \      4
          \__/   \    / \            1 is above the error: no fall before it
           1      \  /   \
        -----------\/-----\--- error
                   3       \         3 is within it: a touch, undecided
        --------------------\- -error
                             \       the end is below: it falls after 4

    Raises `Undecided` if a turning point of the value lies within its error of zero; if a radius
    leaves open whether the piece begins above the surface, or whether the value rises from there.
    """
    start = numbers.exact(0.0)
    first = curve(start)
    if first > 2 * error and curve.positive(start, end):
        return None
    for left, right in pairwise([start, *curve.turns(start, end), end]):
        value = curve(right)
        if left is start and not first > (0 if launch else error):
            # Of two numbers with radii neither may be the larger.
            falls, rises = value <= first, value > first
            if not stays:
                falls, rises = value < first, value >= first
            if launch:
                if not (on_surface or first <= 0):
                    _require_positive(first, start, f"whether {question}", numbers)
                if falls:
                    return start
                if not rises:
                    _require_positive(value - first, start, f"whether {question}", numbers)
                continue
            if not falls:  # the last piece ended on a turning point
                _require_positive(first, error, f"whether {question}", numbers)
        if value > error:
            continue
        if value < -error:
            return zero_of(curve, left, right, f"whether {question}", numbers)
        if right is not end and question is not None:
            _require_positive(value, error, f"whether {question}", numbers)
    return None


class Met(NamedTuple, Generic[N]):
    """An event that a flight has met: when, s since the launch, and in what state."""

    event: Event[N]
    time: N
    state: State[N]


def first_met(
    pieces: Iterable[Piece[N]],
    events: Events[N],
    limit: N,  # s since the launch
    error: float,  # of a state, relative to its size; 0 for numbers that carry their own
    numbers: Numbers[N],
) -> Met[N] | None:
    """Return the first of several events on a flight; None if none is met in time.

    Raises `Undecided` if the error leaves open whether an event is met, whether in time, or which
    of two is first.
    """
    errors = {event.name: error * event.size for event in events}
    seen: list[tuple[Piece[N], N]] = []
    for number, piece in enumerate(pieces):
        left = limit - piece.begin
        end = piece.length if piece.length < left else left
        if numbers.rounding:
            start: Any = piece.at(numbers.exact(0.0))
            rounded = _ROUNDINGS * numbers.rounding * max(1.0, abs(start.s), abs(start.z))
            for event in events:
                errors[event.name] = max(errors[event.name], event.slope * rounded)
        found = []
        for event in events:
            curve, off = piece.curve(event.value), errors[event.name]
            t = first_fall(curve, end, off, event.question, numbers, launch=number == 0)
            if t is not None:
                where = piece
                if numbers.rounding and number > 0 and not t > 0:
                    where, t = _fallen(seen, event, numbers)
                found.append(Met(event, where.begin + t, event.place(where.at(t))))
        if found:
            return _earliest(found, events, errors, limit, error, numbers)
        seen.append((piece, end))
        if not piece.begin + piece.length < limit:
            break
    if not seen:
        return None
    piece, end = seen[-1]
    state = piece.at(end)
    for event in events:
        question = f"whether {event.question} in the time limit"
        _require_positive(event.value(state), errors[event.name], question, numbers)
    return None


def _fallen(
    seen: Sequence[tuple[Piece[N], N]], event: Event[N], numbers: Numbers[N]
) -> tuple[Piece[N], N]:
    """Return where a value fell through zero that was in doubt at the end of some pieces.

    The piece that follows tells that it did fall; where, within its error of that piece.
    """
    start = numbers.exact(0.0)
    for piece, end in reversed(seen):
        curve = piece.curve(event.value)
        if curve(start) > 0:
            left = [start, *curve.turns(start, end)][-1]
            return piece, end if curve(end) > 0 else curve.zero(left, end)
    return seen[-1]


# Half ulps of the largest coordinate that a flight has had: those of a flight that comes back from
# 300 m were off by 5e-14 m, which is one and a half.
_ROUNDINGS = 4


def _earliest(
    found: list[Met[N]],
    events: Events[N],
    errors: dict[str, N],
    limit: N,
    error: float,
    numbers: Numbers[N],
) -> Met[N]:
    """Return the first of what was met on a piece, if nothing else is met within the error."""
    first = min(found, key=lambda met: met.time)
    for other in events:
        if other is not first.event and not first.time <= 0:
            question = f"whether {first.event.question} before {other.question}"
            _require_positive(other.value(first.state), errors[other.name], question, numbers)
    question = f"whether {first.event.question} in the time limit"
    _require_positive(limit - first.time, error * limit, question, numbers)
    return first


def _require_positive(x: N, error: N, question: str, numbers: Numbers[N]) -> None:
    if not numbers.positive(x, error, question):
        raise Undecided(f"{question} cannot be decided: the two coincide")
