"""The flights and at-bats that every contender solves, and the truth about them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats.qmc import Sobol

from analysis.paper.printed import AT_BATS, BASE
from longball import engines
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.home_run import draw
from longball.model.arrays import Array
from longball.model.quantities import replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Launch

Scene = FlightScene | AtBatScene

SEED = 1
TRUE_DIGITS = 40


@dataclass(frozen=True)
class Work:
    """Scenes that differ in some of their numbers."""

    base: Scene  # what is the same in all
    columns: dict[str, Array]  # what differs, as `longball.engines.batch.solve_columns` takes it
    true: Sequence[Result] = ()  # the truth about the first of them

    def __len__(self) -> int:
        return min(map(len, self.columns.values()))

    def __getitem__(self, rows: slice | list[int]) -> "Work":
        return Work(self.base, {name: column[rows] for name, column in self.columns.items()})

    @cached_property
    def scenes(self) -> list[Scene]:
        """The scenes one by one."""
        rows = zip(*(column.tolist() for column in self.columns.values()), strict=True)
        return [replaced(self.base, dict(zip(self.columns, row, strict=True))) for row in rows]


def flights(count: int) -> Work:
    """Return launches of batted balls: line drives to high flies, 25 to 50 m/s, 5° to 60°.

    Sobol' points, of which the first few are spread as all are: who is timed on fewer flights has
    no easier ones.
    """
    points = Sobol(2, rng=SEED).random(1 << (count - 1).bit_length())[:count]
    return launches(25.0 + 25.0 * points[:, 0], np.radians(5.0 + 55.0 * points[:, 1]))


def launches(speed: Array, rise: ArrayLike, **blocks: Any) -> Work:
    """Return launches 1 m over the plate at speeds, m/s, and angles, rad; with blocks of scenes."""
    level = Launch(position=(0.0, 0.0, 1.0), velocity=(30.0, 0.0, 30.0))
    columns = {
        "launch.velocity[0]": speed * np.cos(rise),
        "launch.velocity[2]": speed * np.sin(rise),
    }
    return Work(FlightScene(id="flight", launch=level, **blocks), columns)


def at_bats(count: int, seed: int = SEED) -> Work:
    """Return at-bats of the paper's distributions."""
    return Work(BASE, draw(AT_BATS, count, seed).columns)


def truth(work: Work) -> list[Result]:
    """Return the results of scenes with proven digits."""
    exact = engines.create("enclosure", digits=TRUE_DIGITS)
    return [solve(scene, exact) for scene in work.scenes]


def known(work: Work, count: int) -> Work:
    """Return work with the truth about so many of its scenes."""
    return replace(work, true=truth(work[:count]))


def batted(count: int, seed: int) -> tuple[Work, list[Result]]:
    """Return the first batted at-bats of a seed, and what the reference engine makes of them."""
    drawn = at_bats(2 * count, seed)
    results = [solve(scene, Ivp()) for scene in drawn.scenes]
    rows = [row for row, result in enumerate(results) if result.outcome == "batted"][:count]
    return drawn[rows], [results[row] for row in rows]
