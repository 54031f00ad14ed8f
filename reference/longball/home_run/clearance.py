"""Clearance of an at-bat: the function whose roots bound the home runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from longball.home_run.at_bats import Samples
from longball.home_run.simulation import HOME_RUN_DISTANCE
from longball.model.arrays import Array, Flags
from longball.model.readings import SampleSpace
from longball.model.scene import AtBatScene

if TYPE_CHECKING:
    from longball.engines.batch import Batch

Counted = Literal["home runs", "sample space"]

# Margin of the window in which ball and bat meet, for the curvature of the path: the ball's fall as
# it passes the bat adds less than this.
_WIDER = 1.05
# Samples across the window, 5° apart around the bat.
_OFFSETS = 37


@dataclass(frozen=True)
class Clearance:
    """Signed distance of a landing from the boundary of the counted ones, m; negative outside.

    A ball that is not batted has a distance of zero.
    """

    base: AtBatScene  # the at-bat without its random numbers
    restitution: float  # of the ball
    engine: Batch
    sample_space: SampleSpace = "pitches"  # P(e) is the fraction of home runs in it
    counted: Counted = "home runs"  # home runs within the sample space, or the whole space

    def __post_init__(self) -> None:
        if self.base.fence is not None:
            raise ValueError("quadrature needs home runs by distance (D = 150 m), not a fence")

    def __call__(self, inputs: Samples) -> Array:
        """Return clearances, an array of shape (n,), for a root search.

        A ball that grazes ground or bat within the engine's error counts as not batted.
        """
        from longball.engines.batch import solve_decided_columns

        return self._from_edge(solve_decided_columns(*self._problem(inputs)))

    def with_unsolved(self, inputs: Samples) -> tuple[Array, Flags]:
        """Return clearances, and flags of the undecided at-bats, which count as not batted."""
        table = self._solve(inputs)
        return self._from_edge(table), table["outcome"] == ""

    def _from_edge(self, table: Mapping[str, NDArray[Any]]) -> Array:
        # Each boundary has a distance; a landing inside all of them is counted, so the minimum
        # decides.
        x, y = _column(table, "landing.position[0]"), _column(table, "landing.position[1]")
        inside = np.full_like(x, HOME_RUN_DISTANCE)
        if self.counted == "home runs":
            inside = np.hypot(x, y) - HOME_RUN_DISTANCE
        if self.sample_space == "fair":
            inside = np.minimum(inside, x - abs(y))
        return np.where(np.isnan(x), -HOME_RUN_DISTANCE, inside)

    def window(self, speed: Array) -> Array:
        """Return the largest offset at which bat and ball can touch, m.

        It is (R + r_b)/cos γ for a straight pitch that falls at the angle γ, with a margin, and 0
        for a pitch that does not reach the plate.
        """
        nothing = np.zeros_like(speed)
        table = self._solve(Samples(speed, nothing, nothing, nothing))
        x, y, z = (_column(table, f"plate.velocity[{i}]") for i in range(3))
        level = np.hypot(x, y)
        reach = self.base.ball.radius + self.base.bat.radius
        return np.nan_to_num(_WIDER * reach * np.hypot(level, z) / level)

    def offsets(self, speed: Array, farthest: float) -> Array:
        """Return offsets across the window, m, at most `farthest` from 0: an array (n, sample).

        They are evenly spaced in the angle around the bat, because D is a smooth function of it.
        """
        half = np.minimum(self.window(speed), farthest)
        return half[:, None] * np.sin(np.linspace(-np.pi / 2, np.pi / 2, _OFFSETS))

    def aim_to_touch(self, y: float, inputs: Samples) -> Array:
        """Return the aims of the pitches that touch the bat at y, m; y itself if all miss.

        Seen from above, the path is a line from the release to the aim. The x of the contact is
        computed with the aim y. The returned aim differs by about 2 mm, which changes x by 1e-8 m.
        """
        release_x, release_y, _ = self.base.pitch.release
        aim = np.full_like(inputs.speed, y)
        x = _column(self._solve(replace(inputs, aim=aim)), "contact.position[0]")
        # Similar triangles: the line is at y where its distance from the plate is x.
        fraction = np.nan_to_num(x) / release_x
        return (y - release_y * fraction) / (1.0 - fraction)

    def _solve(self, inputs: Samples) -> Mapping[str, NDArray[Any]]:
        from longball.engines.batch import solve_columns

        return solve_columns(*self._problem(inputs))

    def _problem(self, inputs: Samples) -> tuple[AtBatScene, Mapping[str, Array], Batch]:
        restitution = np.full_like(inputs.speed, self.restitution)
        return self.base, inputs.columns | {"ball.restitution": restitution}, self.engine


def _column(table: Mapping[str, NDArray[Any]], name: str) -> Array:
    """Return a column of a table; NaN if no at-bat has this quantity."""
    return table.get(name, np.full(len(table["outcome"]), np.nan))
