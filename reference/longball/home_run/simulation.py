"""Monte Carlo: landings of sampled at-bats.

Every sample is drawn once and solved with every restitution. The noise is then almost the same at
every e, and differences of P(e) have little noise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines import create
from longball.engines.chain import solve_with_restitutions
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import in_parallel
from longball.home_run.at_bats import BLOCK, Arrays, AtBats, Samples, draw, scenes
from longball.model.arrays import Array, Flags
from longball.model.quantities import doubles
from longball.model.scene import AtBatScene

HOME_RUN_DISTANCE = 150.0  # m; paper, Sec. IV

# Samples of one task: a few hundredths of a second.
COLUMNS = 200 * BLOCK

Table = Mapping[str, NDArray[Any]]  # results in columns, as `longball.engines.batch` returns them


@dataclass(frozen=True)
class Struck(Arrays):
    """Landings of at-bats, one array element for each."""

    # Position of the landing, or of the ball at the fence, m; NaN if it was not batted.
    x: Array
    y: Array
    failed: Flags  # True if the engine could not decide
    home_run: Flags  # over the fence, or without one D >= 150 m (paper, Sec. IV)

    @property
    def distance(self) -> Array:
        """Distance from the plate, m; NaN if not batted."""
        return np.hypot(self.x, self.y)

    @property
    def batted(self) -> Flags:
        """True where the ball was batted and landed, or met the fence."""
        return ~np.isnan(self.x)

    @property
    def fair(self) -> Flags:
        """True where it landed within 45° of the line from the plate to the pitcher."""
        return np.abs(self.y) <= self.x


def monte_carlo(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    count: int,
    seed: int,
    *,
    engine: Engine | None = None,
    workers: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Struck]:
    """Return the landings of the samples of a seed, the same samples at each restitution.

    `base` is the at-bat without its random numbers. Fewer samples are the first of more. The batch
    engine, the default, solves columns in threads; others solve single scenes in processes. The
    number of workers does not change a bit. `progress` is called with the number of samples done.
    """
    solver = engine or create("batch")
    threads = isinstance(solver, ManyAtOnce)
    size = COLUMNS if threads else BLOCK
    calls = (
        (base, at_bats, tuple(restitutions), first, min(size, count - first), seed, solver)
        for first in range(0, count, size)
    )
    parts = []
    for done, part in enumerate(in_parallel(_strike, calls, workers, threads), 1):
        parts.append(part)
        progress(min(done * size, count))
    return [Struck.joined(of_one) for of_one in zip(*parts, strict=True)]


def _strike(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    first: int,
    count: int,
    seed: int,
    engine: Any,
) -> list[Struck]:
    """Return the landings of samples at each restitution."""
    # Workers draw their own samples, because each block has its own seed: nothing is sent to them.
    samples = draw(at_bats, count, seed, first)
    pitched = samples.pitched
    found = []
    for table in solved(base, samples.chosen(pitched), restitutions, engine):
        outcome, nothing = table["outcome"], np.full(len(table["outcome"]), np.nan)
        place = np.full((2, count), np.nan)
        for i, column in enumerate(place):
            ends = (table.get(f"{end}.position[{i}]", nothing) for end in ("fence", "landing"))
            column[pitched] = np.where(outcome == "wall", *ends)
        failed, over = np.zeros((2, count), dtype=bool)
        failed[pitched], over[pitched] = outcome == "", outcome == "home_run"
        if base.fence is None:
            over = np.hypot(*place) >= HOME_RUN_DISTANCE
        x, y = place
        found.append(Struck(x, y, failed, over))
    return found


def solved(
    base: AtBatScene, samples: Samples, restitutions: Sequence[float], engine: Any
) -> list[Table]:
    """Return the results of samples, all of them pitched, at each restitution."""
    if isinstance(engine, ManyAtOnce):
        from longball.engines.batch import solve_columns_with_restitutions

        batch: Any = engine
        return [*solve_columns_with_restitutions(base, samples.columns, restitutions, batch)]
    every = [
        solve_with_restitutions(scene, restitutions, engine)
        for scene in filter(None, scenes(base, samples))
    ]
    tables: list[Table] = []
    for results in zip(*every, strict=True) if every else [()] * len(restitutions):
        rows = [doubles(result) for result in results]
        names = dict.fromkeys(name for row in rows for name in row)
        columns = {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
        outcomes = np.array([result.outcome or "" for result in results], dtype=object)
        tables.append(columns | {"outcome": outcomes})
    return tables
