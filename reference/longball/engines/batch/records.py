"""Flights as records of the compiled code: writing where they start, reading how they end.

A law, a state, an event hold a number of each flight, or one number for all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from longball.engines.batch.flights import PREFIXES, Records, Stop, new_flights
from longball.engines.event import BatSection, Events
from longball.engines.polynomial import Dual
from longball.model.arrays import Array, Flags
from longball.model.law import PAPER, Law, State, law_with

# Distance of the sampling plane from the plate, m, where a new series and the search for the bat
# begin. A pitch crosses this distance in 8 ms, well within one step. The squared distance from the
# bat, which is compared with reach² = 0.005 m², is small from there on.
APPROACH = 0.25

# Codes of the events that stop flights, by name.
STOPS: Mapping[str, int] = {
    "ground": 0,
    "plate": 1,
    "vertical": 2,
    "past": 3,
    "fence": 4,
    "fence_behind": 5,
    "risen": 6,
    "time": Stop.TIME_LIMIT,
}
NOT_FLOWN = -1  # code of a row without a flight


class Start(NamedTuple):
    """A time, s since launch, and the state then."""

    time: Any
    state: State


def flies_in_lanes(law: Law) -> bool:
    """True if the compiled code supports a law.

    It does not support switches within a flight, nor a law without gravity in which a ball may come
    to rest in the wind.
    """
    if not all(switch.ends_law for switch in law.switches):
        return False
    return law.is_paper or "gravity" in law.strengths


def formed(law: Law) -> Law:
    """Return a law on the branches of the compiled code, where a side force has a direction."""
    return law.on([1] * len(law.switches)) if law.switches and flies_in_lanes(law) else law


def general(law: Law) -> Law:
    """Return a law with all of the paper's forces; absent ones have strength 0.

    The same compiled code then serves all scenes of the paper's model. Laws of the extended model
    stay the same.
    """
    if law.is_paper:
        return law_with({**dict.fromkeys(PAPER, 0.0), **law.strengths})
    return formed(law)


# Squared sine of the angle between the airspeed and the vector of a side force, at the beginning of
# a step, below which the flight is left to the scalar engine. It is an angle of 1e-3; the law ends
# at 1e-6 (`longball.model.law.ALONG`). A step covers at most half of the distance to a zero of the
# sine, and so cannot get from the one to the other.
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
    bat: Bat | None,
    rows: Flags,
    changes: Sequence[Array] = (),  # derivatives of parameters and variables, (inputs, flights)
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
    flight = new_flights(law.program, shape, len(events), len(changes[0]) if changes else 0)
    for (name, *place), value in columns.items():
        flight[name][..., *place] = value
    for source, rate in enumerate(changes):
        flight["changes"][..., source] = rate[:, rows if shape else 0].T
    return flight


def linear(law: Law, value: Callable[[Any], Any]) -> list[Any]:
    """Return the coefficients of a linear function of the state, and its constant."""
    names = law.variables
    along = [value(law.state(*(Dual(0.0, float(name == one)) for name in names))) for one in names]
    return [*(part.rate for part in along), along[0].value]


def noted(end: Records, law: Law, prefix: str = "") -> Start:
    """Return time and state that arrivals hold under names with a prefix."""
    time, *state = (end[prefix + name][()] for name in ("time", *law.variables))
    return Start(time, law.state(*state))


def rates_of(end: Records, prefix: str) -> Array:
    """Return the derivatives of the states under a prefix, of shape (variables, inputs, rows)."""
    rates: Array = np.atleast_1d(end)["rates"][:, PREFIXES.index(prefix)].T
    return np.ascontiguousarray(rates)


def placed(stop: Any, state: State, events: Events, numbers: Any) -> State:
    """Return the states at the ends of flights, those that an event stopped being put onto it."""
    for i, event in enumerate(events):
        there = zip(event.place(state), state, strict=True)
        state = type(state)(*(numbers.where(stop == i, x, y) for x, y in there))
    return state


def stops(end: Records, events: Events) -> Any:
    """Return the reason each flight stopped: one of `STOPS`, TOUCH or FALLBACK."""
    numbers = np.array([STOPS[event.name] for event in events] or [0], np.int64)
    by_event = (end["stop"] >= 0) & (end["stop"] < len(events))
    return np.where(by_event, numbers[np.where(by_event, end["stop"], 0)], end["stop"])[()]
