"""The batch engine: flights by compiled Taylor series."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from longball.engines.batch import flights
from longball.engines.batch.flights import Records
from longball.engines.batch.many import SCALAR, solve_as_data
from longball.engines.engine import ManyAtOnce
from longball.model.arrays import Array
from longball.model.numbers import DOUBLES
from longball.model.scene import Scene
from longball.model.trace import Program

# Range of the tolerance, m. Looser ones save no time; tighter ones are below rounding.
LOOSEST, TIGHTEST = 1e-4, 1e-14


@dataclass(frozen=True)
class Batch(ManyAtOnce):
    """Flights by compiled Taylor series, sixteen scenes at once.

    A scene has the same bits alone and among others. The engine ivp solves the scenes that the
    compiled code leaves, and follows the path of a ball; a result names the engine that solved it.

    Attributes
    ----------
    tolerance
        Error of a landing up to 200 m away that truncation may cause, m, from 1e-4 to 1e-14.
        Rounding adds about 1e-13 m there.
    """

    tolerance: float = 1e-13

    numbers = DOUBLES
    alone = SCALAR

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
        return flights.fly_all(program, starts, order, self.truncation, changes)
