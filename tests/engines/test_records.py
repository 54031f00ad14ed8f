"""Flights as records of the compiled code: what is written there, and which flights it takes."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from longball.engines.batch import flights
from longball.engines.batch.flights import Stop
from longball.engines.batch.records import (
    APPROACH,
    STOPS,
    Bat,
    Start,
    approach_is_clear,
    flies_in_lanes,
    general,
    noted,
    placed,
    records_of,
    stops,
)
from longball.engines.contact import BatSection
from longball.engines.event import ground, past, plate, vertical
from longball.model.frame import Frame, launch_frame
from longball.model.law import PlaneState, law_of, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import parse_scene

FRAME = Frame(18.0, 2.0, -0.8, 0.6)
PLANE = law_with({"drag": 0.0075, "gravity": 9.8})


def law_of_flight(**air: Any) -> Any:
    launch: dict[str, Any] = {"position": [0, 0, 1], "velocity": [30, 0, 20], "spin": [0, -100, 20]}
    line = {"kind": "flight", "launch": launch, "air": air, "gravity": air.pop("gravity", 9.8)}
    scene = parse_scene(json.dumps(line))
    frame, _ = launch_frame((0.0, 0.0, 1.0), (30.0, 0.0, 20.0), DOUBLES, (0.0, -100.0, 20.0))
    return law_of(scene, frame, DOUBLES)


def test_events_are_written_as_linear_functions_with_their_sizes() -> None:
    start = PlaneState(0.0, 1.5, 30.0, 2.0)
    events = [
        ground(0.25, start, DOUBLES),
        plate(FRAME, start, DOUBLES),
        past(FRAME, 0.07, DOUBLES),
    ]
    events.append(vertical(start, DOUBLES))
    bat = Bat(BatSection(FRAME, 1.25, 0.07), 1e-14)
    flight = records_of(PLANE, Start(0.5, start), events, 60.0, 2e-14, bat)
    assert (flight["time"], flight["time_limit"], flight["error"]) == (0.5, 60.0, 2e-14)
    assert (flight["reach"], flight["margin_error"], flight["ahead"]) == (0.07, 1e-14, 1.0)
    assert [flight[name] for name in start._fields] == list(start)
    assert (flight["drag"], flight["gravity"], flight["lift"]) == (0.0075, 9.8, 0.0)
    other = PlaneState(7.0, 3.0, 20.0, -4.0)

    def value(row: Any) -> float:
        return float(np.dot(row[:4], other) + row[4])

    for row, event in zip(flight["events"], events, strict=True):
        assert value(row) == pytest.approx(event.value(other), rel=1e-15)
        assert row[5] == event.size
    assert value(flight["across"]) == pytest.approx(FRAME.towards_x(other), rel=1e-15)
    assert value(flight["above"]) == 3.0 - 1.25
    # The waypoint lies so far before the plate, along the way: 0.25 m of s are 0.2 m of x.
    assert value(flight["waypoint"]) == pytest.approx(FRAME.towards_x(other) - 0.2, rel=1e-14)


def test_flights_without_more_have_no_waypoint_no_bat_and_no_event() -> None:
    flight = flights.new_flights(general(PLANE).program, (3,), 2)
    assert flight.shape == (3,)
    assert np.isnan(flight["ahead"]).all()
    assert (flight["reach"] == 0.0).all()
    assert np.isposinf(flight["waypoint"][..., 4]).all()
    assert np.isposinf(flight["events"][..., 4]).all()
    assert (flight["events"][..., :4] == 0.0).all()


@pytest.mark.parametrize(
    ("reach", "height", "clear"),
    [
        (0.19, 1.0, True),
        (0.21, 1.0, False),
        (0.1, 1.19, True),
        (0.1, 1.21, False),
        (0.1, 0.79, False),
    ],
)
def test_an_approach_is_clear_if_the_bat_is_nearer_to_the_plate(
    reach: float, height: float, clear: bool
) -> None:
    """It begins 0.25 m of the way before the plate: 0.2 m of x."""
    assert APPROACH * abs(FRAME.cos) == pytest.approx(0.2)
    assert approach_is_clear(BatSection(FRAME, height, reach), 1.0) == clear


def test_what_stopped_a_flight_is_told_by_the_events_that_it_had() -> None:
    start = PlaneState(0.0, 1.5, 30.0, 2.0)
    events = [plate(FRAME, start, DOUBLES), ground(0.25, start, DOUBLES)]
    end = np.zeros(4, flights.arrival_dtype(general(PLANE).program))
    end["stop"] = [0, 1, Stop.TIME_LIMIT, Stop.FALLBACK]
    end["z"] = 0.2500001
    end["time"] = [1.0, 2.0, 3.0, 4.0]
    end["mark_time"] = 0.5
    found = stops(end, events).tolist()
    assert found == [STOPS["plate"], STOPS["ground"], Stop.TIME_LIMIT, Stop.FALLBACK]
    there = placed(end, PLANE, events)
    assert there.time.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert there.state.z.tolist() == [0.2500001, 0.25, 0.2500001, 0.2500001]
    assert there.state.s.tolist() == pytest.approx([18.0 / 0.8, 0.0, 0.0, 0.0], rel=1e-15)
    assert noted(end, PLANE, "mark_").time.tolist() == [0.5] * 4
    assert stops(end[2:3], []).tolist() == [Stop.TIME_LIMIT]


def test_laws_that_the_compiled_code_takes() -> None:
    assert flies_in_lanes(PLANE)
    assert flies_in_lanes(law_with({"drag": 0.0075}))
    assert flies_in_lanes(law_of_flight())
    assert not flies_in_lanes(law_of_flight(gravity=0.0))
    assert not flies_in_lanes(law_of_flight(spin_decay_length=100.0))
    table = {"law": "table", "of": "speed", "at": [1, 40], "values": [0.5, 0.3]}
    assert not flies_in_lanes(law_of_flight(drag_coefficient=table))


def test_laws_of_the_paper_are_completed_by_what_does_not_act() -> None:
    law = general(PLANE)
    assert law.strengths == {"drag": 0.0075, "lift": 0.0, "gravity": 9.8}
    assert general(law_with({"gravity": 9.8})).program == law.program
    extended = law_of_flight()
    assert general(extended) is extended


def test_the_names_of_stops_are_told_apart() -> None:
    assert len(set(STOPS.values())) == len(STOPS)
    by_event = [number for name, number in STOPS.items() if name != "time"]
    assert not {*by_event} & {*Stop}
    assert STOPS["time"] == Stop.TIME_LIMIT
