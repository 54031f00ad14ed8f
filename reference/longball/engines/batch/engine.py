"""The batch engine, one scene at a time: a flight by compiled Taylor series."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from longball.engines.batch import flights, records
from longball.engines.batch.expansion import kernel
from longball.engines.batch.flights import Records, Stop
from longball.engines.batch.many import solve_as_data
from longball.engines.batch.records import Start
from longball.engines.engine import CannotSolve, ManyAtOnce, Touch
from longball.engines.event import TURNS_VERTICAL, BatSection, Events, Piece, margin_error, past
from longball.engines.ivp import Ivp
from longball.engines.path import Flight, Path, Rest
from longball.engines.polynomial import PolynomialPiece
from longball.engines.taylor import Expander
from longball.model.arrays import Array
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, Numbers
from longball.model.scene import Scene
from longball.model.trace import Program

# Range of the tolerance, m. Looser ones save no time; tighter ones are below rounding.
LOOSEST, TIGHTEST = 1e-4, 1e-14

# The fallback for laws and flights that the compiled code does not support.
SCALAR = Ivp()


@dataclass(frozen=True)
class OneFlight(Flight):
    """A flight with its launch and a mark.

    The mark of a pitch is a point shortly before the plate, that of another ball its highest point.
    """

    launch: Start
    mark: Start

    def highest(self, numbers: Numbers) -> tuple[float, State] | None:
        """See `Flight.highest`."""
        falls = not self.launch.state.w > 0.0
        known = self.mark.time == self.mark.time  # not NaN
        if known and not (falls and self.launch.state.z > self.mark.state.z):
            return self.mark
        return self.launch if falls else None

    def then(self, second: Flight) -> Flight:
        """See `Flight.then`."""
        whole, top = super().then(second), self.highest(DOUBLES)
        later = second.highest(DOUBLES)
        if later is not None and (top is None or later[1].z > top[1].z):
            top = self.time + later[0], later[1]
        return OneFlight(
            whole.path, whole.stop, whole.time, whole.state, self.launch, Start(*top or self.mark)
        )


@dataclass(frozen=True)
class Batch(ManyAtOnce):
    """Flights by compiled Taylor series, sixteen scenes at once.

    `longball.engines.chain.solve` takes one scene, and `solve_all` many; both give the same bits.

    Attributes
    ----------
    tolerance
        Error of a landing up to 200 m away that truncation may cause, m, from 1e-4 to 1e-14.
        Rounding adds about 1e-13 m there.
    """

    tolerance: float = 1e-13

    numbers = DOUBLES

    def __post_init__(self) -> None:
        if not TIGHTEST <= self.tolerance <= LOOSEST:
            raise ValueError(
                f"tolerance = {self.tolerance} m is not between {TIGHTEST} and {LOOSEST}"
            )

    @property
    def truncation(self) -> float:
        """Size of the last terms of the velocity in a step, relative to the speed."""
        # With this factor, the landings of 400 launches at 3° to 88° were wrong by at most a fourth
        # of the tolerance, or by 4e-14 m where rounding dominates.
        return 0.01 * self.tolerance

    @property
    def order(self) -> int:
        """Order of the series."""
        # A step of order N costs N², and its length is proportional to truncation^(1/N): the
        # optimum is -ln(truncation)/2. The fixed cost of a step raises it a little.
        return round(-0.5 * math.log(self.truncation)) + 5

    @property
    def description(self) -> str:
        """Name and tolerance."""
        return f"batch tolerance={self.tolerance:g}"

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight."""
        # Measured in 34 digits on 400 launches: positions are wrong by up to 11 truncations (in
        # metres, or relative), velocities by a fourth of one, and both by 3 half ulps where
        # rounding dominates.
        return 20 * max(self.truncation, DOUBLES.rounding)

    def fly(self, law: Law, start: State, events: Events, limit: float) -> Flight:
        """Fly until the first of several events; see `longball.engines.engine.Engine.fly`."""
        if records.flies_in_lanes(law):
            launch = Start(0.0, law.state_of(start))
            flight = records.records_of(law, launch, events, limit, self.flight_error)
            end = self.fly_all(flight, records.in_lanes(law).program)
            stop = records.stops(end, events).item()
            if stop != Stop.FALLBACK:
                names = {number: name for name, number in records.STOPS.items()}
                return OneFlight(
                    Path(self._pieces(flight, law)),
                    names[stop],
                    *_plain(records.placed(end, law, events)),
                    launch,
                    _plain(records.noted(end, law, "mark_")),
                )
        return replace(SCALAR.fly(law, start, events, limit), flown_by=SCALAR.description)

    def touch(
        self,
        pitch: Flight,
        law: Law,
        bat: BatSection,
        events: Events,
        limit: float,
    ) -> Touch:
        """Find the contact of a pitch; see `longball.engines.engine.Engine.touch`."""
        # Start the search at the mark before the plate if the ball cannot touch the bat earlier.
        if isinstance(pitch, OneFlight):
            clear = records.approach_is_clear(bat, pitch.state.z)
            start = pitch.mark if clear else pitch.launch
            error = margin_error(bat, pitch.state.z, self.flight_error, DOUBLES)
            ends = [past(bat.frame, bat.reach, DOUBLES), *events]
            near = records.Bat(bat, error)
            flight = records.records_of(law, start, ends, limit, self.flight_error, near)
            end = self.fly_all(flight, records.in_lanes(law).program)
            stop, margin = records.stops(end, ends).item(), end["margin"].item()
            if stop == Stop.TOUCH:
                return Touch(margin, True, *_plain(records.noted(end, law)))
            if stop == records.STOPS["vertical"]:
                raise CannotSolve(TURNS_VERTICAL)
            if stop != Stop.FALLBACK:
                return Touch(margin, False)
        touch = SCALAR.touch(pitch, law, bat, events, limit)
        return replace(touch, decided_by=SCALAR.description)

    def solve_as_data(self, scenes: Sequence[Scene], threads: int = 1) -> list[dict[str, Any]]:
        """Solve scenes of any kinds; see `longball.engines.batch.solve_as_data`."""
        return solve_as_data(scenes, self, threads)

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records of `flights.flight_dtype`; return their arrivals, in order."""
        return self.fly_all_with_tangents(starts, program, None)[0]

    def fly_all_with_tangents(
        self, starts: Records, program: Program, changes: Array | None
    ) -> tuple[Records, Array]:
        """Fly records with derivatives; see `flights.fly_all`."""
        # Flights past a bat take a hundredth of a second: a lower order is enough for one step.
        near_bat = starts.size > 0 and starts["reach"].item(0) > 0.0
        order = max(8, 2 * self.order // 5) if near_bat else self.order
        return flights.fly_all(kernel(program), starts, order, self.truncation, changes)

    def _pieces(self, flight: Records, law: Law) -> Iterator[Piece]:
        """Yield the steps of a flight as polynomials."""
        # The compiled code returns only the states between steps; the series are expanded again
        # here.
        code = kernel(records.in_lanes(law).program)
        settings = self.order, self.truncation
        arrival, _ = flights.fly_all(code, flight, *settings)
        states = np.empty((arrival["steps"].item(), 1 + len(law.variables)))
        flights.fly_all(code, flight, *settings, steps=states)
        expand = Expander(records.general(law), self.order)
        ends = [*states[1:, 0].tolist(), arrival["time"].item()]
        # A flight that ends at its launch has no step.
        if ends[-1] == states[0, 0]:
            begin, *state = states[0].tolist()
            yield Rest(begin, 0.0, law.state(*state))
        for (begin, *state), end in zip(states.tolist(), ends, strict=True):
            if begin < end:  # a step may be too short to change the time
                yield PolynomialPiece(begin, end - begin, law.state, expand(np.array(state))[0])


def _plain(start: Start) -> Start:
    """Return numbers of Python."""
    return Start(start.time.item(), type(start.state)(*(x.item() for x in start.state)))
