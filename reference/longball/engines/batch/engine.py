"""The batch engine: compiled Taylor series, one scene or many, with the same bits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from longball.engines import contact
from longball.engines.batch import flights
from longball.engines.batch.flights import ARRIVAL, FLIGHT, Records
from longball.engines.engine import Arrival, BatSection, CannotSolve, Stop, Stops, Touch
from longball.model.motion import Forces, PlaneState
from longball.model.numbers import DOUBLES, Doubles

State = PlaneState[float]

LOOSEST, TIGHTEST = 1e-4, 1e-14  # m

# m before a wall (a plate): a pitch's state there is kept, to look for the bat from. Closer than
# that the bat's depth polynomial is too short to lose digits; farther off there is no bat.
APPROACH = 0.5


class Start(NamedTuple):
    """A time, s since launch, and the state then."""

    time: float
    state: State


class Way(NamedTuple):
    """What a flight remembers of its way: its launch, and where it was `APPROACH` from a wall."""

    launch: Start
    approach: Start


@dataclass(frozen=True)
class Batch:
    """Flights by Taylor series, compiled, sixteen at a time.

    Attributes
    ----------
    tolerance
        m, from 1e-4 to 1e-14: no position of a landing within 200 m is off by more, apart from
        the rounding of doubles (a few 1e-14 m at that distance). A looser one is faster.
    """

    tolerance: float = 1e-13

    def __post_init__(self) -> None:
        if not TIGHTEST <= self.tolerance <= LOOSEST:
            raise ValueError(
                f"tolerance = {self.tolerance} m is not between {TIGHTEST} and {LOOSEST}"
            )

    @property
    def truncation(self) -> float:
        """Size of the last terms of a step's series, relative to the speed."""
        return 1e-3 * self.tolerance

    @property
    def order(self) -> int:
        """Order of the series: -ln(truncation)/2 would cost least if all a step costs were it."""
        return round(-0.5 * math.log(self.truncation)) + 3

    @property
    def numbers(self) -> Doubles:
        """Double precision."""
        return DOUBLES

    @property
    def description(self) -> str:
        """Name and tolerance."""
        return f"batch tolerance={self.tolerance:g}"

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight."""
        return 10 * max(self.truncation, 10 * DOUBLES.rounding)

    def fly(self, start: State, forces: Forces[float], stops: Stops[float]) -> Arrival[float]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`."""
        flight = np.zeros(1, FLIGHT)
        put_start(flight, Start(0.0, start))
        put_forces(flight, forces)
        put_stops(flight, stops, self.flight_error)
        end = self.fly_all(flight)[0]
        stop = int(end["stop"])
        if stop not in _STOPS:
            raise reason(stop, float(end["doubt"]), flight[0])
        way = Way(Start(0.0, start), noted(end, "mark_"))
        time, state = noted(end)
        return Arrival(_STOPS[stop], time, state, way)

    def touch(
        self,
        pitch: Arrival[float],
        forces: Forces[float],
        bat: BatSection[float],
        stops: Stops[float],
    ) -> Touch[float]:
        """Find how a pitch meets the bat; see `longball.engines.engine.Engine.touch`."""
        way = cast(Way, pitch.record)
        start = way.approach if bat.reach < APPROACH * abs(bat.cos) else way.launch
        error = contact.margin_error(bat, way.launch.state.z, self.flight_error)
        flight = np.zeros(1, FLIGHT)
        put_start(flight, start)
        put_forces(flight, forces)
        put_stops(flight, stops, self.flight_error)
        put_bat(flight, bat, error)
        end = self.fly_all(flight)[0]
        margin = float(end["margin"])
        match int(end["stop"]):
            case flights.TOUCH:
                time, state = noted(end)
                return Touch(margin, True, time, state)
            case flights.GRAZES_BAT:
                return Touch(margin, None, doubt=contact.doubt(margin, error))
            case flights.FLOOR | flights.WALL | flights.TIME_LIMIT:
                return Touch(margin, False)
            case other:
                raise reason(other, float(end["doubt"]), flight[0])

    def fly_all(self, starts: Records) -> Records:
        """Fly records of FLIGHT; return records of ARRIVAL, shape and order the same."""
        return flights.fly_all(starts, self.order, self.truncation)


_STOPS: dict[int, Stop] = {
    flights.FLOOR: "floor",
    flights.WALL: "wall",
    flights.VERTICAL: "vertical",
    flights.TIME_LIMIT: "time",
}


def put_start(flight: Records, start: Start) -> None:
    """Write where flights begin."""
    flight["time"] = start.time
    flight["s"], flight["z"], flight["u"], flight["w"] = start.state


def put_forces(flight: Records, forces: Forces[float]) -> None:
    """Write what acts on the ball."""
    flight["drag"] = forces.drag or 0.0
    flight["lift"] = forces.lift or 0.0
    flight["gravity"] = forces.gravity or 0.0


def put_stops(flight: Records, stops: Stops[float], flight_error: float) -> None:
    """Write what ends a flight, and the place before a wall that is kept."""
    floor = -math.inf if stops.floor is None else stops.floor
    flight["time_limit"] = stops.time_limit
    flight["floor"] = floor
    flight["floor_error"] = flight_error * np.maximum(1.0, abs(floor))
    flight["wall"] = math.inf if stops.wall is None else stops.wall
    flight["vertical"] = stops.vertical
    flight["mark"] = flight["wall"] - APPROACH


def put_bat(flight: Records, bat: BatSection[float], error: float) -> None:
    """Write the bat, and where the search for it ends: where x + cos s = -reach."""
    flight["bat_x"], flight["bat_cos"] = bat.x, bat.cos
    flight["bat_height"], flight["reach"] = bat.height, bat.reach
    flight["margin_error"] = error
    flight["wall"] = (-bat.reach - bat.x) / bat.cos
    flight["mark"] = math.inf


def noted(end: Any, prefix: str = "") -> Start:
    """Return the time and state that an arrival holds under names with a prefix."""
    time, s, z, u, w = (float(end[prefix + name]) for name in ("time", "s", "z", "u", "w"))
    return Start(time, PlaneState(s, z, u, w))


def reason(stop: int, doubt: float, flight: Any) -> ArithmeticError:
    """Say why a flight has no answer."""
    match stop:
        case flights.VERTICAL:
            return CannotSolve(
                "the pitch turns vertical over the plate, where a lift that is always up "
                "has no direction; use lift_direction = fixed_spin_axis"
            )
    return CannotSolve(f"{stop} {doubt}")
