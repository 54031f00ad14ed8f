"""Flights as records of the compiled code: writing where they start, reading how they end.

A law, a state, an event hold a number of each flight, or one number for all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from longball.engines.arithmetic import ARRAYS, Arithmetic
from longball.engines.batch import flights
from longball.engines.batch.flights import Records, new_flights
from longball.engines.contact import BatSection
from longball.engines.event import Event, Events
from longball.model.atmosphere import ROUGHNESS
from longball.model.law import PAPER, Law, State, law_with
from longball.model.vectors import cross, dot

# m before the plate: a pitch is expanded anew there, and the search for the bat starts there. A
# pitch crosses that distance in 8 ms, well within one step, and the square of the distance to the
# bat, of which reach² = 0.005 m² is to be told apart, starts small.
APPROACH = 0.25

# How arrivals say what stopped a flight: by a number for each event's name.
STOPS: Mapping[str, int] = {
    "ground": 0,
    "plate": 1,
    "vertical": 2,
    "past": 3,
    "fence": 4,
    "fence_behind": 5,
    "level": 6,
    "aside": 7,
    "time": flights.TIME_LIMIT,
}
NOT_FLOWN = -1  # stands for what stopped it where there is no flight


class Start(NamedTuple):
    """A time, s since launch, and the state then."""

    time: Any
    state: State[Any]


def in_lanes(law: Law[Any]) -> Law[Any] | None:
    """Return the form of a law that the compiled code flies; None if it flies none.

    Not where the law has several forms, or a state has a path besides positions and velocities;
    nor where nothing keeps a ball from going straight on, to where it comes to rest in a wind. A
    side force has one form as long as it has a direction; see `guards`.
    """
    if not all(bend.ends for bend in law.bends) or "path" in law.variables:
        return None
    if not law.is_paper and law.gravity is None:
        return None
    if not law.bends:
        return law
    return None if ROUGHNESS in law.strengths else law.on([1] * len(law.bends))


# The part of `guards` that has to be left; and how large they have to be at the start, relative to
# the airspeed and in m/s. An angle of `longball.model.law.ALONG` is far below, at any speed.
_LEFT, _LEAST, _LEAST_SPEED = 1 / 16, 0.01, 1.0


def guards(law: Law[Any], start: State[Any]) -> list[Event[Any]]:
    """Return where flights under a law in lanes are left to be flown alone, as events.

    That is well before a side force has no direction: what `Law.aside` gives is zero there. A part
    of it is linear in the state: along itself at the start; or, better, along z, which gravity does
    not change.
    """
    if "side" not in law.strengths:
        return []
    first = law.aside(law.state_of(start), ARRAYS)
    whole = np.sqrt(dot(first, first))
    along_z = 2.0 * np.abs(first[2]) >= whole
    unit = tuple(
        np.where(along_z, z, part / np.where(whole > 0.0, whole, 1.0))[()]
        for part, z in zip(first, (0.0, 0.0, np.sign(first[2])), strict=True)
    )
    size = dot(unit, first)
    question = "the side force comes near to where it has no direction"

    def value(state: Any) -> Any:
        return dot(unit, law.aside(state, ARRAYS)) - _LEFT * size

    return [Event("aside", question, value, lambda state: state, size)]


def is_guarded(end: Records, events: Events[Any]) -> Any:
    """Tell which flights met a guard, which come behind their other events, or may have met one."""
    of_guard = (end["stop"] >= len(events)) & (end["stop"] < flights.TIME_LIMIT)
    doubted = (end["event"] >= len(events)) | (end["rival"] >= len(events))
    return of_guard | (np.isin(end["stop"], flights.DOUBTS) & doubted)


def starts_at_corner(law: Law[Any], start: State[Any]) -> Any:
    """Tell which flights of the extended model start where lift or drag has a corner.

    Straight up or down through the air, along their spin, or almost along a side force.
    """
    if law.is_paper:
        return np.False_
    wind = [law.strengths.get(f"wind_{name}", 0.0) for name in "syz"]
    u, v, w = (
        velocity - drift
        for velocity, drift in zip((start.u, getattr(start, "v", 0.0), start.w), wind, strict=True)
    )
    corner = (u == 0.0) & (v == 0.0)
    if "spin" in law.strengths:
        spin = [law.strengths.get(f"spin_{name}", 0.0) for name in "syz"]
        across = cross((spin[0], spin[1], spin[2]), (u, v, w))
        corner = corner | ((across[0] == 0.0) & (across[1] == 0.0) & (across[2] == 0.0))
    for guard in guards(law, start):
        least = np.maximum(_LEAST * np.sqrt(u * u + v * v + w * w), _LEAST_SPEED)
        corner = corner | ~(guard.size > least)
    return corner


def general(law: Law[Any]) -> Law[Any]:
    """Return a law with all of the paper's forces, those that do not act with strength 0.

    So that the same compiled code serves all of the paper's scenes. A law of the extended model is
    as it is.
    """
    return law_with({**dict.fromkeys(PAPER, 0.0), **law.strengths}) if law.is_paper else law


@dataclass(frozen=True)
class _Linear(Arithmetic):
    """A linear function of the variables: their coefficients, by name, and a constant."""

    coefficients: Mapping[str, Any]
    constant: Any = 0.0

    __array_ufunc__ = None  # an array is one factor or constant

    def __add__(self, other: Any) -> _Linear:
        if not isinstance(other, _Linear):
            return _Linear(self.coefficients, self.constant + other)
        names = {**self.coefficients, **other.coefficients}
        both = (self.coefficients, other.coefficients)
        added = {name: sum(part[name] for part in both if name in part) for name in names}
        return _Linear(added, self.constant + other.constant)

    def __mul__(self, factor: Any) -> _Linear:
        scaled = {name: x * factor for name, x in self.coefficients.items()}
        return _Linear(scaled, self.constant * factor)

    def __neg__(self) -> _Linear:
        return self * -1.0


class Bat(NamedTuple):
    """A bat to search for, and the error of the margin, m."""

    section: BatSection[Any]
    error: Any


def records_of(
    law: Law[Any],
    start: Start,
    events: Events[Any],
    limit: Any,
    flight_error: float,
    bat: Bat | None = None,
    rows: Any = ...,
) -> Records:
    """Return flights that start from states, as `general(law)` has them fly.

    The values of the events must be linear in the state. Columns are those of all flights; of which
    the flights in `rows` are returned.
    """
    law = general(law)
    names = law.program.variables
    columns: dict[tuple[Any, ...], Any] = {
        ("time",): start.time,
        ("time_limit",): limit,
        ("error",): flight_error,
        **{(name,): law.strengths[name] for name in law.program.parameters},
        **{(name,): getattr(start.state, name) for name in names},
    }

    def put(way: tuple[Any, ...], value: _Linear, size: Any) -> None:
        numbers = [value.coefficients.get(name, 0.0) for name in names]
        for i, number in enumerate([*numbers, value.constant, size]):
            columns[(*way, i)] = number

    for i, event in enumerate(events):
        value = linear(law, event.value)
        put(("events", i), value, event.size)
        if event.name == "plate":
            columns["ahead",] = float(i)
            put(("waypoint",), value - APPROACH * abs(value.coefficients["s"]), 0.0)
    if bat is not None:
        columns["reach",], columns["margin_error",] = bat.section.reach, bat.error
        put(("across",), linear(law, bat.section.frame.towards_x), 0.0)
        put(("above",), linear(law, lambda state: state.z - bat.section.height), 0.0)
    columns = {way: value[rows] if np.ndim(value) else value for way, value in columns.items()}
    shape = np.broadcast_shapes(*(np.shape(value) for value in columns.values()))
    flight = new_flights(law.program, shape, len(events))
    for (name, *place), value in columns.items():
        flight[name][..., *place] = value
    return flight


def flown(
    flyer: Any,
    law: Law[Any],
    start: Start,
    events: Events[Any],
    limit: Any,
    bat: Bat | None = None,
    rows: Any = ...,
) -> tuple[Records, Records]:
    """Return flights that start from states, and their arrivals; see `records_of`."""
    starts = records_of(law, start, events, limit, flyer.flight_error, bat, rows)
    return starts, flyer.fly_all(starts, general(law).program)


def linear(law: Law[Any], value: Any) -> _Linear:
    """Return a linear function of a state as its coefficients."""
    state = law.state(*(_Linear({name: 1.0}) for name in law.program.variables))
    found: _Linear = value(state)
    return found


def approach_is_clear(bat: BatSection[Any], plate: Any) -> Any:
    """True if the approach to the plate, at height `plate`, holds all that counts of a pitch.

    Before it the ball is farther from the bat than the touching, and than at the plate.
    """
    far = APPROACH * abs(bat.frame.cos)
    return (bat.reach < far) & (abs(bat.height - plate) < far)


def noted(end: Records, law: Law[Any], prefix: str = "") -> Start:
    """Return time and state that arrivals hold under names with a prefix."""
    time, *state = (end[prefix + name][()] for name in ("time", *law.program.variables))
    return Start(time, law.state(*state))


def placed(end: Records, law: Law[Any], events: Events[Any]) -> Start:
    """Return when and where flights ended, those that an event stopped being put onto it."""
    time, state = noted(end, law)
    for i, event in enumerate(events):
        stopped = end["stop"] == i
        there = event.place(state)
        state = law.state(*(np.where(stopped, x, y)[()] for x, y in zip(there, state, strict=True)))
    return Start(time, state)


def stops(end: Records, events: Events[Any]) -> Any:
    """Return the reason each flight stopped: one of `STOPS`, or why there is no answer."""
    numbers = np.array([STOPS[event.name] for event in events] or [0], np.int64)
    by_event = (end["stop"] >= 0) & (end["stop"] < len(events))
    return np.where(by_event, numbers[np.where(by_event, end["stop"], 0)], end["stop"])[()]
