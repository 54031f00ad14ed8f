"""The chain of `longball.engines.at_bat` over columns: a number for each of many scenes.

The same formulas in the same order as there, so that a row has the bits that its scene gets when
it is solved alone; a test holds the two together. What cannot be answered is marked, not explained:
the sentence is the other chain's to say.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, Protocol, cast, get_args

import numpy as np
from numpy.typing import NDArray

from longball.engines.batch import flights
from longball.engines.batch.flights import FLIGHT, Records
from longball.engines.batch.lanes import kept
from longball.engines.batch.records import (
    Start,
    approach_is_clear,
    noted,
    put_bat,
    put_forces,
    put_start,
    put_stops,
)
from longball.engines.engine import BatSection, Stops
from longball.model.bat import bat_velocity, couple, lever
from longball.model.impact import energy_change, impulse, velocity_after
from longball.model.motion import LARGER, TINY, FlightPlane, Forces, PlaneState
from longball.model.numbers import DOUBLES
from longball.model.readings import Reading
from longball.model.result import Outcome

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64] | slice
Vector = tuple[Array, Array, Array]
Columns = Mapping[str, Any]  # arrays of a number a scene, or one number for all

OUTCOMES: tuple[str, ...] = get_args(Outcome)
UNSOLVED = -1  # stands in a column of outcomes where a scene has no answer


class Fleet(Protocol):
    """Who flies balls for the chain, many at a time; `longball.engines.batch.engine.Batch` does."""

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size."""

    def fly_all(self, starts: Records) -> Records:
        """Fly records of `flights.FLIGHT`; return records of `flights.ARRIVAL`, in order."""

    def search_all(self, starts: Records) -> Records:
        """Do the same for flights past a bat."""


class Elementwise:
    """Arrays of doubles as the numbers of the model's formulas (`longball.model.numbers`)."""

    pi = math.pi

    def exact(self, value: Any) -> Any:
        """Return the doubles themselves."""
        return value

    def sqrt(self, x: Array) -> Array:
        """Return the correctly rounded square roots."""
        return np.sqrt(x)

    def cos_sin(self, angle: Array) -> tuple[Array, Array]:
        """Return cosines and sines by the functions that `math` has, not by NumPy's vector code."""
        angles = np.atleast_1d(angle)
        cos, sin = np.empty_like(angles), np.empty_like(angles)
        _cos_sin(angles, cos, sin)
        return cos.reshape(np.shape(angle)), sin.reshape(np.shape(angle))


@kept
def _cos_sin(angle: Array, cos: Array, sin: Array) -> None:
    for i in range(len(angle)):
        cos[i], sin[i] = math.cos(angle[i]), math.sin(angle[i])


NUMBERS = cast(Any, Elementwise())


# --- balls in the air -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Flown:
    """Flights at their ends: the codes of `flights` for what stopped them, times and states."""

    stop: NDArray[np.int64]
    time: Array
    state: PlaneState[Any]
    approach: Start


def _fly(
    count: int, start: PlaneState[Any], forces: Forces[Any], stops: Stops[Any], engine: Fleet
) -> Flown:
    """Fly to a stop, through the vertical if need be; see `longball.engines.at_bat`."""
    records = np.zeros(count, FLIGHT)
    put_start(records, Start(0.0, start))
    put_forces(records, forces)
    put_stops(records, stops, engine.flight_error)
    records["vertical"] = forces.always_up & (records["lift"] != 0.0)
    ends = engine.fly_all(records)
    upright = ends["stop"] == flights.VERTICAL
    if upright.any():
        rest, reached = records[upright], ends[upright]
        put_start(rest, Start(0.0, noted(reached).state._replace(u=0.0)))
        rest["lift"] = rest["vertical"] = 0.0
        rest["time_limit"] -= reached["time"]
        after = engine.fly_all(rest)
        after["time"] += reached["time"]
        ends[upright] = after
    return Flown(ends["stop"], *noted(ends), noted(ends, "mark_"))


def _into_plane(position: Vector, velocity: Vector) -> tuple[FlightPlane[Any], PlaneState[Any]]:
    """Do what `longball.model.motion.into_plane` does."""
    x, y, z = position
    vx, vy, vz = velocity
    size = np.abs(vx) + np.abs(vy)
    scale = np.where(size < TINY, LARGER, 1.0)
    u, v = scale * vx, scale * vy
    length = np.sqrt(u * u + v * v)
    heads = size > 0.0
    divisor = np.where(heads, length, 1.0)
    plane = FlightPlane(x, y, np.where(heads, u / divisor, 1.0), v / divisor)
    return plane, PlaneState(0.0, z, length / scale, vz)


def _forces(c: Columns, reading: Reading) -> Forces[Any]:
    """Do what `longball.model.motion.forces` does, with 0 for a force that is not there."""
    radius = c["ball.radius"]
    area = math.pi * radius * radius

    def per_metre(coefficient: Any) -> Any:
        return c["air.density"] * coefficient * area / (2 * c["ball.mass"])

    return Forces(
        drag=per_metre(c["air.drag_coefficient"]),
        lift=per_metre(c["air.lift_coefficient"]),
        gravity=c["gravity"],
        always_up=reading.lift_direction == "always_up",
    )


def _floor(c: Columns, reading: Reading) -> Any:
    ground = c.get("ground.height", 0.0)  # a pitch's field is the paper's
    return ground + c["ball.radius"] if reading.ground_contact == "surface" else ground


def _point(c: Columns, name: str) -> Any:
    return c[f"{name}[0]"], c[f"{name}[1]"], c[f"{name}[2]"]


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


# --- tables of results ----------------------------------------------------------------------------


# What an answer ends with: if it is no number, something before has overflowed.
_LAST = {
    "landed": "landing.distance",
    "batted": "landing.distance",
    "crossed": "plate.velocity[2]",
    "struck": "impact.velocity[2]",
}


class Table:
    """Results, a row a scene: columns named as the contract names them, NaN where there is none.

    `part` gives a table of some of the rows, which writes into this one.
    """

    def __init__(self, rows: int) -> None:
        self.rows = slice(0, rows)
        self.whole = np.full(rows, UNSOLVED, np.int64)
        self.columns: dict[str, Array] = {}

    def __len__(self) -> int:
        return self.rows.stop - self.rows.start

    @property
    def outcome(self) -> NDArray[np.int64]:
        """The outcomes, as places in OUTCOMES."""
        return self.whole[self.rows]

    def part(self, rows: slice) -> Table:
        """Return the table of a range of rows."""
        part = copy(self)
        part.rows = slice(rows.start, min(rows.stop, len(self.whole)))
        return part

    def copy_from(self, other: Table) -> None:
        """Write all that another table of as many rows holds."""
        self.outcome[:] = other.outcome
        for name, column in other.columns.items():
            self.put(name, slice(None), column[other.rows])

    def decide(self, outcome: Outcome, rows: Any) -> None:
        """Write an outcome into rows, by index or by flag."""
        self.outcome[rows] = OUTCOMES.index(outcome)

    def withdraw_what_is_not_finite(self) -> None:
        """Leave rows without an answer if a quantity of theirs has overflowed."""
        overflown = np.zeros(len(self), bool)
        for column in self.columns.values():
            overflown |= np.isinf(column[self.rows])
        for outcome, quantity in _LAST.items():
            if quantity in self.columns:
                reached = self.outcome == OUTCOMES.index(outcome)
                overflown |= reached & np.isnan(self.columns[quantity][self.rows])
        self.outcome[overflown] = UNSOLVED

    def put(self, name: str, rows: Any, values: Any) -> None:
        """Write a quantity into rows: an array, or a vector of three."""
        if isinstance(values, tuple):
            for i, value in enumerate(values):
                self.put(f"{name}[{i}]", rows, value)
            return
        if name not in self.columns:
            self.columns.setdefault(name, np.full(len(self.whole), np.nan))
        self.columns[name][self.rows][rows] = values


# --- the links of the chain -----------------------------------------------------------------------


def solve_flights(table: Table, c: Columns, reading: Reading, engine: Fleet) -> None:
    """Solve launches and landings."""
    everyone = np.arange(len(table))
    position, velocity = _point(c, "launch.position"), _point(c, "launch.velocity")
    _land(table, everyone, c, position, velocity, np.zeros(len(table)), reading, engine)
    table.outcome[table.outcome == OUTCOMES.index("batted")] = OUTCOMES.index("landed")


def _land(
    table: Table,
    rows: NDArray[np.int64],
    c: Columns,
    position: Vector,
    velocity: Vector,
    time: Array,
    reading: Reading,
    engine: Fleet,
) -> None:
    """Fly to the ground from launches at `time`, and write how that ends: batted or airborne."""
    plane, start = _into_plane(position, velocity)
    stops = Stops(time_limit=c["time_limit"], floor=_floor(c, reading))
    flown = _fly(len(rows), start, _forces(c, reading), stops, engine)
    table.decide("airborne", rows[flown.stop == flights.TIME_LIMIT])
    down = _flagged(flown.stop == flights.FLOOR)
    table.decide("batted", rows[down])
    x, y, z = plane.position(flown.state)
    for name, values in (
        ("time", time + flown.time),
        ("hang_time", flown.time),
        ("position", (x, y, z)),
        ("velocity", plane.velocity(flown.state)),
        ("distance", np.sqrt(x * x + y * y)),
    ):
        table.put(f"landing.{name}", rows[down], _at(values, down))


@dataclass(frozen=True)
class Delivered:
    """Pitches up to the plate, or to wherever they ended before."""

    plane: FlightPlane[Any]
    start: PlaneState[Any]
    forces: Forces[Any]
    stops: Stops[Any]
    flown: Flown


def _deliver(count: int, c: Columns, reading: Reading, engine: Fleet) -> Delivered:
    x, y, z = _point(c, "pitch.release")
    toward = (-x, c["pitch.aim[0]"] - y, c["pitch.aim[1]"] - z)
    scale = c["pitch.speed"] / np.sqrt(_dot(toward, toward))
    velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    plane, start = _into_plane((x, y, z), velocity)
    stops = Stops(time_limit=c["time_limit"], floor=_floor(c, reading), wall=-x / plane.cos)
    forces = _forces(c, reading)
    return Delivered(plane, start, forces, stops, _fly(count, start, forces, stops, engine))


def _plate(table: Table, delivered: Delivered) -> Rows:
    """Write how pitches end, and the plate of those that reach it; return which do."""
    flown, plane = delivered.flown, delivered.plane
    crossed = _flagged(flown.stop == flights.WALL)
    table.decide("crossed", crossed)
    table.decide("grounded", flown.stop == flights.FLOOR)
    table.decide("airborne", flown.stop == flights.TIME_LIMIT)
    _, y, z = plane.position(flown.state)
    table.put("plate.time", crossed, flown.time[crossed])
    table.put("plate.position", crossed, _at((np.zeros_like(y), y, z), crossed))
    table.put("plate.velocity", crossed, _at(plane.velocity(flown.state), crossed))
    return crossed


def solve_pitches(table: Table, c: Columns, reading: Reading, engine: Fleet) -> None:
    """Solve releases and plates."""
    _plate(table, _deliver(len(table), c, reading, engine))


@dataclass(frozen=True)
class Blows:
    """Balls and bats at touching, of the rows that it is decided for."""

    rows: NDArray[np.int64]
    position: Vector
    velocity: Vector
    normal: Vector
    lever: Array
    normal_speed: Array
    time: Array


def _blows(
    table: Table,
    rows: NDArray[np.int64],
    c: Columns,
    position: Vector,
    velocity: Vector,
    height: Array,
    inherited: float,
    time: Array,
) -> Blows:
    """Write how balls and bats touch; return those that approach each other."""
    _, y, _ = position
    half = c["bat.length"] / 2
    end = _sign(half - abs(y), half * (inherited + 2 * DOUBLES.rounding) if inherited else 0.0 * y)
    table.outcome[rows] = UNSOLVED
    beyond = _flagged(end < 0)
    table.decide("beyond_bat", rows[beyond])
    table.put("contact.position", rows[beyond], _at(position, beyond))
    on_bat = _flagged(end > 0)
    rows, c, time, height = rows[on_bat], at_rows(c, on_bat), time[on_bat], height[on_bat]
    position, velocity = _at(position, on_bat), _at(velocity, on_bat)
    x, y, z = position
    distance = np.sqrt(x * x + (z - height) * (z - height))
    normal = (x / distance, np.zeros_like(x), (z - height) / distance)
    arm = lever(y, _block(c, "bat"), NUMBERS)
    bat = bat_velocity(arm, _block(c, "swing"), NUMBERS)
    relative = (velocity[0] - bat[0], velocity[1] - bat[1], velocity[2] - bat[2])
    normal_speed = _dot(relative, normal)
    terms = (
        (velocity[0], normal[0]),
        (bat[0], normal[0]),
        (velocity[2], normal[2]),
        (bat[2], normal[2]),
    )
    doubt = np.zeros_like(x)
    for a, b in terms:
        doubt += abs(a * b) * (inherited + 6 * DOUBLES.rounding)
    closing = _sign(-normal_speed, doubt)
    table.decide("separating", rows[closing < 0])
    table.decide("struck", rows[closing > 0])
    decided = _flagged(closing != 0)
    for name, values in (
        ("position", position),
        ("normal", normal),
        ("bat_velocity", (bat[0], np.zeros_like(x), bat[2])),
        ("normal_speed", normal_speed),
    ):
        table.put(f"contact.{name}", rows[decided], _at(values, decided))
    kept = _flagged(closing > 0)
    return Blows(
        rows[kept],
        *(_at(values, kept) for values in (position, velocity, normal, arm, normal_speed, time)),
    )


def _sign(x: Array, error: Array) -> NDArray[np.int64]:
    """Return 1 where x > 0, -1 where it is not, 0 where that lies within its error."""
    decided = (abs(x) > error) | ((x == 0.0) & (error == 0.0))
    return np.where(decided, np.where(x > 0.0, 1, -1), 0)


def _strike(table: Table, blows: Blows, c: Columns, reading: Reading) -> Vector:
    """Apply the impulses of Appendix A; write them, and return the balls' velocities after."""
    pair = couple(_block(c, "ball"), _block(c, "bat"), blows.lever, reading, NUMBERS)
    push = impulse(pair.reduced_mass, pair.restitution, blows.normal_speed)
    after = velocity_after(blows.velocity, blows.normal, c["ball.mass"], push)
    change = energy_change(pair.reduced_mass, pair.restitution, blows.normal_speed)
    table.put("impact.restitution", blows.rows, pair.restitution)
    table.put("impact.impulse", blows.rows, push)
    table.put("impact.velocity", blows.rows, after)
    table.put("impact.energy_change", blows.rows, change)
    return after


def solve_impacts(table: Table, c: Columns, reading: Reading, engine: Fleet) -> None:
    """Solve touchings that are given."""
    rows = np.arange(len(table))
    c = {name: np.broadcast_to(column, len(table)) for name, column in c.items()}
    position, velocity = _point(c, "incoming.position"), _point(c, "incoming.velocity")
    height, time = c["incoming.bat_height"], np.zeros(len(table))
    blows = _blows(table, rows, c, position, velocity, height, 0.0, time)
    # Beyond the bat there is no contact to tell of.
    table.put("contact.position", table.outcome == OUTCOMES.index("beyond_bat"), (np.nan,) * 3)
    _strike(table, blows, at_rows(c, blows.rows), reading)


def solve_at_bats(table: Table, c: Columns, reading: Reading, engine: Fleet) -> None:
    """Solve whole at-bats."""
    finish_at_bats(table, meet_at_bats(table, c, reading, engine), c, reading, engine)


def meet_at_bats(table: Table, c: Columns, reading: Reading, engine: Fleet) -> Blows:
    """Solve at-bats up to the blow: all of them that the ball's restitution leaves alone."""
    delivered = _deliver(len(table), c, reading, engine)
    crossed = _plate(table, delivered)
    rows = np.arange(len(table))[crossed]
    return _meet(table, rows, at_rows(c, crossed), _delivered_at(delivered, crossed), engine)


def finish_at_bats(table: Table, blows: Blows, c: Columns, reading: Reading, engine: Fleet) -> None:
    """Solve at-bats from the blow on."""
    struck = at_rows(c, blows.rows)
    after = _strike(table, blows, struck, reading)
    table.outcome[blows.rows] = UNSOLVED
    _land(table, blows.rows, struck, blows.position, after, blows.time, reading, engine)


def _meet(
    table: Table, rows: NDArray[np.int64], c: Columns, delivered: Delivered, engine: Fleet
) -> Blows:
    """Put the bats where they are swung, and write how the pitches meet them."""
    plane, flown = delivered.plane, delivered.flown
    height = flown.state.z + c["swing.height_offset"]
    bat = BatSection(plane.x, plane.cos, height, c["ball.radius"] + c["bat.radius"])
    clear = approach_is_clear(bat, flown.state.z)
    records = np.zeros(len(rows), FLIGHT)
    put_start(
        records,
        Start(
            np.where(clear, flown.approach.time, 0.0),
            PlaneState(
                *map(
                    lambda near, far: np.where(clear, near, far),
                    flown.approach.state,
                    delivered.start,
                )
            ),
        ),
    )
    put_forces(records, delivered.forces)
    put_stops(records, delivered.stops, engine.flight_error)
    records["vertical"] = delivered.forces.always_up & (records["lift"] != 0.0)
    put_bat(records, bat, _margin_error(bat, flown.state.z, engine.flight_error))
    ends = engine.search_all(records)
    stop = ends["stop"]
    touched = _flagged(stop == flights.TOUCH)
    missed = (stop == flights.FLOOR) | (stop == flights.WALL) | (stop == flights.TIME_LIMIT)
    told = _flagged(missed | (stop == flights.TOUCH) | (stop == flights.GRAZES_BAT))
    table.outcome[rows] = UNSOLVED
    table.decide("missed", rows[missed])
    table.put("contact.margin", rows[told], ends["margin"][told])
    time, state = _start_at(noted(ends), touched)
    plane = FlightPlane(*_at((plane.x, plane.y, plane.cos, plane.sin), touched))
    table.put("contact.time", rows[touched], time)
    return _blows(
        table,
        rows[touched],
        at_rows(c, touched),
        plane.position(state),
        plane.velocity(state),
        height[touched],
        engine.flight_error,
        time,
    )


def _margin_error(bat: BatSection[Any], plate: Array, flight_error: float) -> Array:
    """Do what `longball.engines.contact.margin_error` does; `plate` is the height there, m."""
    way = np.maximum(bat.reach, abs(bat.height - plate))
    height = np.maximum(abs(bat.height), abs(plate))
    rounding = DOUBLES.rounding * (8 * height + 4 * abs(bat.x) + 2 * bat.reach)
    return cast(Array, 2 * way * flight_error + rounding)


# --- rows and blocks ------------------------------------------------------------------------------


def _flagged(flags: Flags) -> Rows:
    """Return the rows with a flag: as a slice if all have it, for a slice copies nothing."""
    return slice(None) if flags.all() else np.flatnonzero(flags)


def at_rows(c: Columns, rows: Rows) -> dict[str, Array]:
    """Return some rows of columns."""
    return {name: _at(column, rows) for name, column in c.items()}


def _at(values: Any, rows: Rows) -> Any:
    """Return some rows of an array, or of each array of a tuple; a number is that of every row."""
    if isinstance(values, tuple):
        return tuple(_at(value, rows) for value in values)
    return values[rows] if np.ndim(values) else values


def _start_at(start: Start, rows: Rows) -> Start:
    """Return some rows of times and states."""
    return Start(_at(start.time, rows), PlaneState(*_at(tuple(start.state), rows)))


def _delivered_at(delivered: Delivered, rows: Rows) -> Delivered:
    plane, forces, stops, flown = (
        delivered.plane,
        delivered.forces,
        delivered.stops,
        delivered.flown,
    )
    return Delivered(
        FlightPlane(*_at((plane.x, plane.y, plane.cos, plane.sin), rows)),
        _start_at(Start(0.0, delivered.start), rows).state,
        replace(
            forces,
            drag=_at(forces.drag, rows),
            lift=_at(forces.lift, rows),
            gravity=_at(forces.gravity, rows),
        ),
        Stops(time_limit=_at(stops.time_limit, rows), floor=_at(stops.floor, rows)),
        Flown(
            flown.stop[rows],
            *_start_at(Start(flown.time, flown.state), rows),
            _start_at(flown.approach, rows),
        ),
    )


def _block(c: Columns, name: str) -> Any:
    """Return a block of scenes, with a column for each of its numbers."""
    start = f"{name}."
    return SimpleNamespace(
        **{key.removeprefix(start): column for key, column in c.items() if key.startswith(start)}
    )
