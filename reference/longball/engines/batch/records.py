"""Flights as records of the compiled code: writing where they start, reading how they end.

What is written is a number for one flight, or an array for many.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from longball.engines.batch.flights import Records
from longball.engines.engine import BatSection, Stops
from longball.model.motion import Forces, PlaneState

# m before a wall (the plate): a pitch is expanded anew there, and the search for the bat starts
# there. A pitch crosses that distance in 15 ms, well within one step, and the square of the
# distance to the bat, of which reach² = 0.005 m² is to be told apart, starts small.
APPROACH = 0.5


class Start(NamedTuple):
    """A time, s since launch, and the state then."""

    time: Any
    state: PlaneState[Any]


class Way(NamedTuple):
    """What a flight remembers of its way: its launch, and where it was `APPROACH` from a wall."""

    launch: Start
    approach: Start


def put_start(flight: Records, start: Start) -> None:
    """Write where flights begin."""
    flight["time"] = start.time
    flight["s"], flight["z"], flight["u"], flight["w"] = start.state


def put_forces(flight: Records, forces: Forces[Any]) -> None:
    """Write what acts on the balls."""
    flight["drag"] = 0.0 if forces.drag is None else forces.drag
    flight["lift"] = 0.0 if forces.lift is None else forces.lift
    flight["gravity"] = 0.0 if forces.gravity is None else forces.gravity


def put_stops(flight: Records, stops: Stops[Any], flight_error: float) -> None:
    """Write what ends the flights."""
    floor = -math.inf if stops.floor is None else stops.floor
    flight["time_limit"] = stops.time_limit
    flight["floor"] = floor
    flight["floor_error"] = flight_error * np.maximum(1.0, np.abs(floor))
    flight["wall"] = math.inf if stops.wall is None else stops.wall
    flight["vertical"] = stops.vertical
    flight["mark"] = flight["wall"] - APPROACH


def put_bat(flight: Records, bat: BatSection[Any], error: Any) -> None:
    """Write a bat to search for, and where the search ends: x + cos s = -reach."""
    flight["bat_x"], flight["bat_cos"] = bat.x, bat.cos
    flight["bat_height"], flight["reach"] = bat.height, bat.reach
    flight["margin_error"] = error
    flight["wall"] = (-bat.reach - bat.x) / bat.cos
    flight["mark"] = math.inf


def approach_is_clear(bat: BatSection[Any], plate: Any) -> Any:
    """Tell whether the approach to the plate, at height `plate`, holds all that counts of a pitch.

    Before it the ball is farther from the bat than the touching, and than at the plate.
    """
    far = APPROACH * abs(bat.cos)
    return (bat.reach < far) & (abs(bat.height - plate) < far)


def noted(end: Any, prefix: str = "") -> Start:
    """Return time and state that arrivals hold under names with a prefix."""
    time, s, z, u, w = (end[prefix + name] for name in ("time", "s", "z", "u", "w"))
    return Start(time, PlaneState(s, z, u, w))
