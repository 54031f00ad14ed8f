"""The batch engine, one scene at a time: a flight by compiled Taylor series."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from longball.engines import contact
from longball.engines.batch import flights
from longball.engines.batch.flights import FLIGHT, Records
from longball.engines.batch.records import (
    Start,
    Way,
    approach_is_clear,
    noted,
    put_bat,
    put_forces,
    put_start,
    put_stops,
)
from longball.engines.engine import (
    Arrival,
    BatSection,
    CannotSolve,
    ManyAtOnce,
    Stop,
    Stops,
    Touch,
)
from longball.model.motion import Forces, PlaneState
from longball.model.numbers import DOUBLES, Doubles, Undecided
from longball.model.result import Result
from longball.model.scene import Scene

State = PlaneState[float]

LOOSEST, TIGHTEST = 1e-4, 1e-14  # m

_STOPS: dict[int, Stop] = {
    flights.FLOOR: "floor",
    flights.WALL: "wall",
    flights.VERTICAL: "vertical",
    flights.TIME_LIMIT: "time",
}


@dataclass(frozen=True)
class Batch(ManyAtOnce):
    """Flights by Taylor series, compiled; many scenes go sixteen at a time.

    `longball.engines.chain.solve` takes one scene; `longball.engines.batch.solve_all` takes many,
    and gives the same bits.

    Attributes
    ----------
    tolerance
        m, from 1e-4 to 1e-14: the error that truncated series may cause in the place of a landing,
        up to 200 m away. The rounding of doubles adds some 1e-13 m there, whatever is asked for.
    """

    tolerance: float = 1e-13

    def __post_init__(self) -> None:
        if not TIGHTEST <= self.tolerance <= LOOSEST:
            raise ValueError(
                f"tolerance = {self.tolerance} m is not between {TIGHTEST} and {LOOSEST}"
            )

    @property
    def truncation(self) -> float:
        """Size of the last terms of the velocity in a step, relative to the speed.

        Landings of 400 launches at 3° to 88° were then off by a fourth of the tolerance at most,
        and by 4e-14 m where rounding rules.
        """
        return 0.01 * self.tolerance

    @property
    def order(self) -> int:
        """Order of the series.

        An order N costs N² a step, and steps grow as truncation^(1/N): the cheapest is
        -ln(truncation)/2, and somewhat more, as a step has costs besides.
        """
        return round(-0.5 * math.log(self.truncation)) + 5

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
        """Relative error of a state at the end of a flight.

        A position is off by up to 11 truncations, in metres or as a part of it, a velocity by a
        fourth of one, and where rounding rules by 3 half ulps: over 400 launches, measured in 34
        digits.
        """
        return 20 * max(self.truncation, DOUBLES.rounding)

    def fly(self, start: State, forces: Forces[float], stops: Stops[float]) -> Arrival[float]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`."""
        launch = Start(0.0, start)
        flight = self._flight(launch, forces, stops)
        end = self.fly_all(flight)
        stop = end["stop"].item()
        if stop not in _STOPS:
            raise _reason(stop, end, flight)
        time, state = _of_one(noted(end))
        return Arrival(_STOPS[stop], time, state, Way(launch, _of_one(noted(end, "mark_"))))

    def touch(
        self,
        pitch: Arrival[float],
        forces: Forces[float],
        bat: BatSection[float],
        stops: Stops[float],
    ) -> Touch[float]:
        """Find how a pitch meets the bat; see `longball.engines.engine.Engine.touch`."""
        way = cast(Way, pitch.record)
        start = way.approach if approach_is_clear(bat, pitch.state.z) else way.launch
        flight = self._flight(start, forces, stops)
        error = contact.margin_error(bat, pitch.state, self.flight_error)
        put_bat(flight, bat, error)
        end = self.search_all(flight)
        stop, margin = end["stop"].item(), end["margin"].item()
        match stop:
            case flights.TOUCH:
                return Touch(margin, True, *_of_one(noted(end)))
            case flights.GRAZES_BAT:
                return Touch(margin, None, doubt=contact.doubt(margin, error))
            case flights.FLOOR | flights.WALL | flights.TIME_LIMIT:
                return Touch(margin, False)
        raise _reason(stop, end, flight)

    def solve_all(self, scenes: Sequence[Scene]) -> list[Result]:
        """Solve scenes of any kinds; see `longball.engines.batch.solve_all`."""
        from longball.engines.batch.many import solve_all  # which imports this module

        return solve_all(scenes, self)

    def fly_all(self, starts: Records) -> Records:
        """Fly records of `flights.FLIGHT`; return records of `flights.ARRIVAL`, in order."""
        return flights.fly_all(starts, self.order, self.truncation)

    def search_all(self, starts: Records) -> Records:
        """Do the same for flights past a bat.

        They take a hundredth of a second, which steps of a lower order span.
        """
        return flights.fly_all(starts, max(8, 2 * self.order // 5), self.truncation)

    def _flight(self, start: Start, forces: Forces[float], stops: Stops[float]) -> Records:
        flight = np.zeros(1, FLIGHT)
        put_start(flight, start)
        put_forces(flight, forces)
        put_stops(flight, stops, self.flight_error)
        return flight


def _of_one(start: Start) -> Start:
    """Return what arrays of one element hold."""
    return Start(start.time.item(), PlaneState(*(x.item() for x in start.state)))


def _reason(stop: int, end: Records, flight: Records) -> ArithmeticError:
    """Say why a flight has no answer."""
    doubt = end["doubt"].item()
    match stop:
        case flights.VERTICAL:
            return CannotSolve(
                "the pitch turns vertical over the plate, where a lift that is always up "
                "has no direction; use lift_direction = fixed_spin_axis"
            )
        case flights.GRAZES_FLOOR:
            return Undecided(
                "whether the ball touches the ground at the bottom of a dip cannot be decided in "
                f"double precision: its height {doubt:.3g} m above the ground lies within its "
                f"error {end['size'].item() * flight['error'].item():.3g} m"
            )
        case flights.INSIDE_BAT:
            reach = flight["reach"].item()
            return CannotSolve(
                f"the ball starts inside the bat: {reach + doubt:.6g} m from its axis, "
                f"where the two touch at {reach:.6g} m; release it farther from the plate"
            )
        case flights.TOO_LONG:
            return CannotSolve(
                f"the flight takes more than {flights.MOST_STEPS} steps, its steps shrink to "
                "nothing where the ball all but comes to rest in the air, or an event of it has "
                "three roots in one"
            )
    return CannotSolve("a quantity of the flight leaves the range of double precision")
