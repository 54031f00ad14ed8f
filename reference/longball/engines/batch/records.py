"""Flights as records of the compiled code: writing where they start, reading how they end.

A law, a state, an event hold a number of each flight, or one number for all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from longball.engines.batch.flights import Records, Stop, new_flights
from longball.engines.event import BatSection, Events
from longball.engines.polynomial import Dual
from longball.model.law import PAPER, Law, State, law_with

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
    "time": Stop.TIME_LIMIT,
}
NOT_FLOWN = -1  # stands for what stopped it where there is no flight


class Start(NamedTuple):
    """A time, s since launch, and the state then."""

    time: Any
    state: State


def flies_in_lanes(law: Law) -> bool:
    """True if the compiled code flies under a law.

    Not where the law changes its form on the way; nor where nothing keeps a ball from going
    straight on, to where it comes to rest in a wind.
    """
    if not all(switch.ends_law for switch in law.switches):
        return False
    return law.is_paper or law.gravity is not None


def formed(law: Law) -> Law:
    """Return a law in the form that the compiled code flies: a side force has a direction."""
    return law.on([1] * len(law.switches)) if law.switches and flies_in_lanes(law) else law


def general(law: Law) -> Law:
    """Return a law with all of the paper's forces, those that do not act with strength 0.

    So that the same compiled code serves all of the paper's scenes. A law of the extended model is
    as it is.
    """
    if law.is_paper:
        return law_with({**dict.fromkeys(PAPER, 0.0), **law.strengths})
    return formed(law)


# The sine, squared, of the angle between the airspeed and the direction of a side force at which a
# flight is left to the scalar engine, if a step begins there. The law ends at an angle of 1e-6
# (`longball.model.law.ALONG`), this is one of 1e-3: a step, which goes half of the way to where the
# sine would be zero, does not come from here to there.
_ALONG = 2.0**-20


def in_lanes(law: Law) -> Law:
    """Return a law as it is flown: with outputs behind the rates that must be above zero."""
    law = general(law)
    if not law.switches:
        return law
    guards = [law.switching_function(switch) for switch in law.switches]
    outputs = (*law.code.outputs, *(output for guard in guards for output in guard.outputs))
    code = replace(law.code, outputs=outputs, parameters=guards[0].parameters)
    return replace(law, code=code, strengths={**law.strengths, "threshold": _ALONG})


class Bat(NamedTuple):
    """A bat to search for, and the error of the margin, m."""

    section: BatSection
    error: Any


def records_of(
    law: Law,
    start: Start,
    events: Events,
    limit: Any,
    flight_error: float,
    bat: Bat | None = None,
    rows: Any = ...,
) -> Records:
    """Return flights that start from states, as `in_lanes(law)` has them fly.

    The values of the events must be linear in the state. Columns are those of all flights; of which
    the flights in `rows` are returned.
    """
    law = in_lanes(law)
    names = law.variables
    columns: dict[tuple[Any, ...], Any] = {
        ("time",): start.time,
        ("time_limit",): limit,
        ("error",): flight_error,
        **{(name,): law.strengths[name] for name in law.program.parameters},
        **{(name,): getattr(start.state, name) for name in names},
    }

    def put(key: tuple[Any, ...], line: Sequence[Any], size: Any) -> None:
        for i, number in enumerate([*line, size]):
            columns[(*key, i)] = number

    # the events, as affine functions; before the plate lies the sampling plane, along the same line
    for i, event in enumerate(events):
        line = linear(law, event.value)
        put(("events", i), line, event.size)
        if event.name == "plate":
            columns["beyond",] = float(i)
            *along, constant = line
            before = APPROACH * abs(along[names.index("s")])
            put(("sample",), [*along, constant - before], 0.0)
    if bat is not None:
        columns["reach",], columns["margin_error",] = bat.section.reach, bat.error
        put(("across",), linear(law, bat.section.frame.towards_x), 0.0)
        put(("above",), linear(law, lambda state: state.z - bat.section.height), 0.0)
    # numbers that all flights share are broadcast when the records are made
    columns = {key: value[rows] if np.ndim(value) else value for key, value in columns.items()}
    shape = np.broadcast_shapes(*(np.shape(value) for value in columns.values()))
    flight = new_flights(law.program, shape, len(events))
    for (name, *place), value in columns.items():
        flight[name][..., *place] = value
    return flight


def flown(
    flyer: Any,
    law: Law,
    start: Start,
    events: Events,
    limit: Any,
    bat: Bat | None = None,
    rows: Any = ...,
) -> tuple[Records, Records]:
    """Return flights that start from states, and their arrivals; see `records_of`."""
    starts = records_of(law, start, events, limit, flyer.flight_error, bat, rows)
    return starts, flyer.fly_all(starts, in_lanes(law).program)


def linear(law: Law, value: Callable[[Any], Any]) -> list[Any]:
    """Return the coefficients of a linear function of the state, and its constant."""
    names = law.variables
    along = [value(law.state(*(Dual(0.0, float(name == one)) for name in names))) for one in names]
    return [*(part.rate for part in along), along[0].value]


def approach_is_clear(bat: BatSection, plate: Any) -> Any:
    """True if the approach to the plate, at height `plate`, holds all that counts of a pitch.

    Before it the ball is farther from the bat than the touching, and than at the plate.
    """
    far = APPROACH * abs(bat.frame.cos)
    return (bat.reach < far) & (abs(bat.height - plate) < far)


def noted(end: Records, law: Law, prefix: str = "") -> Start:
    """Return time and state that arrivals hold under names with a prefix."""
    time, *state = (end[prefix + name][()] for name in ("time", *law.variables))
    return Start(time, law.state(*state))


def placed(end: Records, law: Law, events: Events) -> Start:
    """Return when and where flights ended, those that an event stopped being put onto it."""
    time, state = noted(end, law)
    for i, event in enumerate(events):
        stopped = end["stop"] == i
        there = event.place(state)
        state = law.state(*(np.where(stopped, x, y)[()] for x, y in zip(there, state, strict=True)))
    return Start(time, state)


def stops(end: Records, events: Events) -> Any:
    """Return the reason each flight stopped: one of `STOPS`, TOUCH or FALLBACK."""
    numbers = np.array([STOPS[event.name] for event in events] or [0], np.int64)
    by_event = (end["stop"] >= 0) & (end["stop"] < len(events))
    return np.where(by_event, numbers[np.where(by_event, end["stop"], 0)], end["stop"])[()]
