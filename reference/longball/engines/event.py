"""Events of a flight and the search that locates them, and the bat that a pitch may meet.

An event occurs where a function of the state falls through zero. The function may dip below zero
and come back within a step, so sign changes at the ends of steps are not enough. The search splits
each step at the function's turning points; on each part it is monotonic, and the signs at the ends
decide. A turning point within its error of zero raises `Undecided` with the event's question.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

from longball.model.frame import Frame
from longball.model.law import State, in_plane
from longball.model.numbers import N, Numbers, Undecided, doubt
from longball.model.scene import InvalidScene


class Event(NamedTuple):
    """A scalar function of the state, and how a flight reports its zero.

    Examples
    --------
    A ball is thrown level at 30 m/s from a height of 4.9 m, without air. When is it 20 m away?

    >>> from longball.engines.ivp import Ivp
    >>> from longball.model.law import PlaneState, law_with
    >>> far = Event("far", "it is 20 m away", lambda at: 20.0 - at.s, size=20.0)
    >>> start = PlaneState(s=0.0, z=4.9, u=30.0, w=0.0)
    >>> flight = Ivp().fly(law_with({"gravity": 9.8}), start, [far], 60.0)
    >>> flight.stop, round(flight.time, 9), round(flight.state.z, 9)
    ('far', 0.666666667, 2.722222222)
    """

    name: str  # the `stop` of a flight
    question: str  # the event as a clause: "the ball touches the ground"
    # The function that falls through zero. It is built of + - * only, and so takes states of
    # numbers, of polynomials and of dual numbers alike
    value: Callable[[Any], Any]
    size: N  # scale of the value: its error is a state's relative error times this
    slope: N | float = 1.0  # Lipschitz constant of the value in the coordinates, per m
    # Puts a state that is at the event to rounding exactly there
    place: Callable[[Any], Any] = lambda state: state


Events = Sequence[Event]


def ground(height: N, start: State, numbers: Numbers) -> Event:
    """Event: the ball descends to a height, m. The start sets the scale of the error."""
    return Event(
        "ground",
        "the ball touches the ground",
        lambda state: state.z - height,
        _size(numbers, height, start.z),
        place=lambda state: state._replace(z=height),
    )


def risen(height: N, start: State, numbers: Numbers) -> Event:
    """Event: a ball that starts below a height, m, rises to it."""
    return Event(
        "risen",
        "the ball rises to the height that it lands at",
        lambda state: height - state.z,
        _size(numbers, height, start.z),
        place=lambda state: state._replace(z=height),
    )


def plate(frame: Frame, start: State, numbers: Numbers) -> Event:
    """Event: a pitch crosses the plane x = 0."""

    def place(state: State) -> State:
        return state._replace(s=-frame.x / frame.cos) if in_plane(state) else state

    # x = x₀ + s cos φ. For a pitch almost parallel to the plane of the plate, cos φ ≪ 1: its path s
    # is far longer than x₀, and an error of s changes x little.
    slope = abs(frame.cos) if in_plane(start) else numbers.exact(1.0)
    size = slope * _size(numbers, frame.x / slope)
    return Event("plate", "the ball reaches the plate", frame.towards_x, size, slope, place)


def vertical(start: State, numbers: Numbers) -> Event:
    """Event: the ball turns vertical, its horizontal velocity u falling to zero.

    Its slope is 0: u does not depend on the position.
    """
    nothing, most = numbers.exact(0.0), numbers.exact(1.0)
    # The scale is the speed at the start, at most 1 m/s. With errors relative to 1 m/s, a ball that
    # starts almost at rest would be undecided at once.
    speed = abs(start.u) + abs(start.w)
    return Event(
        "vertical",
        "the ball turns vertical",
        lambda state: state.u,
        numbers.where(speed < most, speed, most),
        nothing,
        lambda state: state._replace(u=nothing),
    )


def past(frame: Frame, reach: N, numbers: Numbers) -> Event:
    """Event: the ball is behind the bat, by the distance `reach`, m, at which the two touch."""
    return Event(
        "past",
        "the ball passes the bat",
        lambda state: frame.towards_x(state) + reach,
        _size(numbers, frame.x, reach),
    )


def _size(numbers: Numbers, *lengths: N) -> N:
    """Return the largest of several lengths, at least 1 m."""
    largest = numbers.exact(1.0)
    for length in map(abs, lengths):
        largest = numbers.where(length > largest, length, largest)
    return largest


class Curve(Protocol):
    """The value of an event along a piece, as a function of the time on the piece, s."""

    def __call__(self, t: N) -> N:
        """Return the value."""

    def positive(self, a: N, b: N) -> bool:
        """True only if the value certainly stays above value(a)/2 > 0 on [a, b].

        Half, so that a value above twice its error stays above the error (`first_fall`).
        """

    def turns(self, a: N, b: N) -> Sequence[N]:
        """Candidate turning points in (a, b), in rising order.

        The value is monotonic between neighbours in ``[a, *turns, b]``.
        """

    def zero(self, a: N, b: N) -> N:
        """Time at which the value is zero; from a to b it falls through zero.

        The sign of the value at a is certain: `zero_of` checks that first.
        """


class Piece(Protocol):
    """A piece of a flight on which the state is a smooth function of time."""

    @property
    def begin(self) -> N:
        """Time of the beginning, s since the launch."""

    @property
    def length(self) -> N:
        """Length, s."""

    def at(self, t: N) -> State:
        """Return the state at a time on the piece, s since it begins."""

    def curve(self, value: Callable[[Any], Any]) -> Curve:
        """Return the value of an event along the piece."""


def zero_of(curve: Curve, a: N, b: N, question: str, numbers: Numbers) -> N:
    """Locate the zero of a value that falls through zero from a to b.

    Raises `Undecided` if the value at a is an interval around zero: it may have fallen before a.
    """
    there = curve(a)
    if not there <= 0:
        _require_positive(there, numbers.exact(0.0), question, numbers)
    return curve.zero(a, b)


def first_fall(
    curve: Curve,
    end: N,  # s since the piece begins; the search ends there
    error: N,  # of the value
    question: str | None,  # the event, as a clause; None accepts a touch within the error
    numbers: Numbers,
    # The piece begins with the launch, whose value is exact. A launch on the surface is an arrival,
    # at 0, unless the value rises from there
    launch: bool = False,
    # The launch is known to lie on the surface, though its value is an interval around zero. The
    # same holds for a state in which a law switches
    on_surface: bool = False,
    # A value that stays at zero counts as an arrival: a ball may rest on the ground. False for
    # switches of a law: a ball that moves along a threshold has not crossed it
    stays: bool = True,
) -> N | None:
    r"""Time, s since the piece begins, at which a value first falls through zero; None if never.

    Between two turning points the value is monotonic: its sign at the right one decides whether it
    falls through zero between them.

        \      2
         \    / \      4
          \__/   \    / \            1 is above the error: no fall before it
           1      \  /   \
        -----------\/-----\--- error
                   3       \         3 is within it: a touch, undecided
        --------------------\- -error
                             \       the end is below: it falls after 4

    Raises `Undecided` if a turning point of the value lies within its error of zero; or if, in
    interval arithmetic, the value at the beginning may be positive or not, or may rise or fall.
    """
    start = numbers.exact(0.0)
    first = curve(start)
    if first > 2 * error and curve.positive(start, end):
        return None
    for left, right in pairwise([start, *curve.turns(start, end), end]):
        value = curve(right)
        if left is start and not first > (0 if launch else error):
            # Intervals may overlap: falls and rises may both be False.
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
            # The piece before ended on a turning point within the error of zero. If the value
            # rises now, that was a touch.
            if not falls:
                _require_positive(first, error, f"whether {question}", numbers)
        if value > error:
            continue
        if value < -error:
            return zero_of(curve, left, right, f"whether {question}", numbers)
        if right is not end and question is not None:
            _require_positive(value, error, f"whether {question}", numbers)
    return None


# Rounding error of a coordinate, in units of 2⁻⁵³ times the largest coordinate so far. Measured:
# 5e-14 m in a flight that comes back from 300 m, 1.5 units.
_ROUNDINGS = 4  # a free choice above that


class Met(NamedTuple):
    """An event located on a flight: the time, s since the launch, and the state."""

    event: Event
    time: N
    state: State


def first_met(
    pieces: Iterable[Piece],
    events: Events,
    limit: N,  # s since the launch
    error: float,  # of a state, relative to its size; 0 for numbers that carry their own
    numbers: Numbers,
) -> Met | None:
    """First of several events on a flight; None if none is met in time.

    Raises `Undecided` if, within the error, an event may occur or not, may occur before or after
    the limit, or either of two may be first.
    """
    errors = {event.name: error * event.size for event in events}
    seen: list[tuple[Piece, N]] = []
    for number, piece in enumerate(pieces):
        left = limit - piece.begin
        end = piece.length if piece.length < left else left

        # the error of each value
        if numbers.rounding:
            # In doubles, a coordinate's rounding error grows with its largest size so far.
            start = piece.at(numbers.exact(0.0))
            rounded = _ROUNDINGS * numbers.rounding * max(1.0, abs(start.s), abs(start.z))
            for event in events:
                errors[event.name] = max(errors[event.name], event.slope * rounded)

        # the first fall of each value on this piece, and the first of these
        first: Met | None = None
        for event in events:
            curve, off = piece.curve(event.value), errors[event.name]
            t = first_fall(curve, end, off, event.question, numbers, launch=number == 0)
            if t is None:
                continue
            where = piece
            # A value below zero from the start fell on an earlier piece, where it was within its
            # error of zero.
            if numbers.rounding and number > 0 and not t > 0:
                where, t = _fallen(seen, event, numbers)
            met = Met(event, where.begin + t, event.place(where.at(t)))
            if first is None or met.time < first.time:
                first = met
        if first is not None:
            # At the first event all other values are still positive, by more than their errors. At
            # a launch they are exact, and the event that is listed first wins.
            for other in events:
                if other is not first.event and not first.time <= 0:
                    question = f"whether {first.event.question} before {other.question}"
                    off = errors[other.name]
                    _require_positive(other.value(first.state), off, question, numbers)
            question = f"whether {first.event.question} in the time limit"
            _require_positive(limit - first.time, error * limit, question, numbers)
            return first
        seen.append((piece, end))
        if not piece.begin + piece.length < limit:
            break

    # Nothing was met in time. The values at the limit have to be certainly positive.
    if not seen:
        return None
    piece, end = seen[-1]
    state = piece.at(end)
    for event in events:
        question = f"whether {event.question} in the time limit"
        _require_positive(event.value(state), errors[event.name], question, numbers)
    return None


def _fallen(seen: Sequence[tuple[Piece, N]], event: Event, numbers: Numbers) -> tuple[Piece, N]:
    """Locate the zero of a value that was within its error of zero at the end of some pieces.

    The next piece begins below zero, so that the value has fallen. Search backwards for the last
    piece that begins above zero.
    """
    start = numbers.exact(0.0)
    for piece, end in reversed(seen):
        curve = piece.curve(event.value)
        if curve(start) > 0:
            left = [start, *curve.turns(start, end)][-1]
            return piece, end if curve(end) > 0 else curve.zero(left, end)
    return seen[-1]


def _require_positive(x: N, error: N, question: str, numbers: Numbers) -> None:
    if not numbers.positive(x, error, question):
        raise Undecided(doubt(x, error, question, numbers))


# --- the bat --------------------------------------------------------------------------------------

# The distance of a pitch from the bat's axis dips below R + r_b for a few milliseconds only, or for
# no time at all in a graze. So contact is decided where the distance is least; the first touching
# lies before that.


@dataclass(frozen=True)
class BatSection:
    """The bat seen along its axis: a circle that a pitch touches or misses."""

    frame: Frame  # of the pitch
    height: N  # of the bat's axis, m
    reach: N  # R + r_b, m: the distance of the ball's centre from the axis when the two touch

    def distance(self, state: State, numbers: Numbers) -> N:
        """Return the distance of the ball's centre from the bat's axis, m."""
        across, above = self.frame.towards_x(state), state.z - self.height
        return numbers.sqrt(across * across + above * above)

    def least_distance(self, state: State, numbers: Numbers) -> N:
        """Return the distance of the ball's centre from the bat's axis where it is least, m.

        There, the offset d is perpendicular to the velocity v, so that its size is ``|d × v|/|v|``.
        If rounding alone explains the part along v, this leaves it out: of a ball that meets the
        axis almost centrally it would be all of d.
        """
        across, above = self.frame.towards_x(state), state.z - self.height
        forwards, upwards = self.frame.velocity(state)[0], state.w
        speed = numbers.sqrt(forwards * forwards + upwards * upwards)
        # as many half ulps of x as in `margin_error`
        rounding = 4 * numbers.rounding * abs(self.frame.x)
        if speed > 0 and abs(self.approach(state)) <= rounding * speed:
            return abs(across * upwards - above * forwards) / speed
        return self.distance(state, numbers)

    def offset(self, state: State, numbers: Numbers) -> tuple[N, N]:
        """Return the vector from the bat's axis to a ball that touches it: across and above, m.

        High above the ground, the difference of two heights has a large rounding error. There, if
        the error alone explains why the ball is not exactly at `reach`, the offset above follows
        from the offset across: ``above² = reach² - across²``.
        """
        across, above = self.frame.towards_x(state), state.z - self.height
        # as many half ulps of a height as in `margin_error`
        rounding = 8 * numbers.rounding * abs(self.height)
        off = abs(self.distance(state, numbers) - self.reach)
        high = (abs(self.height) > abs(self.frame.x)) & (abs(above) > abs(across))
        squared = (self.reach - across) * (self.reach + across)
        better = high & (off <= rounding) & (squared > 0)
        size = numbers.sqrt(numbers.where(better, squared, self.reach))
        return across, numbers.where(better, numbers.where(above > 0, size, -size), above)

    def outside(self, state: Any, reach: N | None = None) -> Any:
        """Return ``d² - reach²``, m², of a state or of polynomials; `reach` is that of contact."""
        across, above = self.frame.towards_x(state), state.z - self.height
        reach = self.reach if reach is None else reach
        return across * across + above * above - reach * reach

    def approach(self, state: State) -> N:
        """Return d·v, m²/s, half the rate of `outside`: negative while the ball comes closer."""
        across, above = self.frame.towards_x(state), state.z - self.height
        return across * self.frame.velocity(state)[0] + above * state.w


def margin_error(bat: BatSection, plate_height: N, flight_error: float, numbers: Numbers) -> N:
    """Return a bound on the error of the margin at the closest approach, m.

    The height of the bat is that of the pitch at the plate, and the closest approach is searched
    on the series of that same state. An error of the state at the plate therefore moves ball and
    bat together, and an error of the time has no effect. The remaining errors are

    - the error of the direction of flight at the plate, times the distance from there to the
      closest approach. Where the margin is in doubt, that distance is at most the bat's offset, and
      less than `reach` on a level pitch; doubled for the curvature of the path and of the circle;
    - the rounding of heights in that step, in z'_b + σ_b and in z - z_b, and that of distances
      from the release in x + cos s and in the frame's own place: a dozen half ulps in all;
      and of the distance itself: two half ulps of `reach`.
    """
    # The distance to the closest approach, and a height, each by the larger of two bounds.
    offset = abs(bat.height - plate_height)
    bat_height, ball_height = abs(bat.height), abs(plate_height)
    distance = numbers.where(offset > bat.reach, offset, bat.reach)
    height = numbers.where(bat_height > ball_height, bat_height, ball_height)
    rounding = numbers.rounding * (8 * height + 4 * abs(bat.frame.x) + 2 * bat.reach)
    return 2 * distance * flight_error + rounding


def inside_bat(distance: Any, reach: Any) -> InvalidScene:
    """Return the `InvalidScene` of a pitch that is released inside the bat."""
    return InvalidScene(
        f"the ball starts inside the bat: {float(distance):.6g} m from its axis, "
        f"where the two touch at {float(reach):.6g} m; release it farther from the plate"
    )


TOUCHES = "whether the ball touches the bat"
STARTS_INSIDE = "whether the ball starts inside the bat or touches it"
TURNS_VERTICAL = (
    "the pitch turns vertical over the plate, where a lift that is always up has no direction; "
    "use lift_direction = fixed_spin_axis"
)
