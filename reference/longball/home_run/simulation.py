"""Monte Carlo: landings of sampled at-bats.

Every sample is drawn once and solved with every restitution. The noise is then almost the same at
every e, and differences of P(e) have little noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from longball.engines import create
from longball.engines.chain import solve_with_restitutions
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import in_parallel
from longball.home_run.at_bats import BLOCK, Arrays, AtBats, Samples, draw, scenes
from longball.model.arrays import Array, Flags
from longball.model.scene import AtBatScene

if TYPE_CHECKING:
    from longball.engines.batch import Batch


# Position of a ball that hits the fence, and of any other.
_PLACES = "fence", "landing"

HOME_RUN_DISTANCE = 150.0  # m; paper, Sec. IV

# Samples of one task: a few hundredths of a second.
COLUMNS = 200 * BLOCK


@dataclass(frozen=True)
class Struck(Arrays):
    """Landings of at-bats, one array element for each."""

    # Position of the landing, or of the ball at the fence, m; NaN if it was not batted.
    x: Array
    y: Array
    failed: Flags  # True if the engine could not decide

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

    @property
    def home_run(self) -> Flags:
        """True where it is a home run: D >= 150 m (paper, Sec. IV)."""
        return self.distance >= HOME_RUN_DISTANCE


@dataclass(frozen=True)
class Fenced(Struck):
    """Landings of at-bats in a field with a fence; `over` flags the home runs."""

    over: Flags

    @property
    def home_run(self) -> Flags:
        """True where it is a home run: over the fence."""
        return self.over


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
    # rows: x, y, failure, home run; blocks arrive in order and fill the columns
    landed = np.empty((len(restitutions), 4, count))
    done = 0
    for part in in_parallel(_strike, calls, workers, threads):
        landed[:, :, done : done + part.shape[2]] = part
        done += part.shape[2]
        progress(done)
    if base.fence is None:
        return [Struck(x, y, failed > 0) for x, y, failed, _ in landed]
    return [Fenced(x, y, failed > 0, over > 0) for x, y, failed, over in landed]


def _strike(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    first: int,
    count: int,
    seed: int,
    engine: Any,
) -> Array:
    """Return x, y, failure and home runs of samples: an array (restitution, 4, sample)."""
    # Workers draw their own samples, because each block has its own seed: nothing is sent to them.
    samples = draw(at_bats, count, seed, first)
    pitched = samples.pitched
    landed = np.full((len(restitutions), 4, count), np.nan)
    landed[:, 2:] = 0.0
    land = _landings_of_columns if isinstance(engine, ManyAtOnce) else _landings_of_scenes
    landed[:, :, pitched] = land(base, samples.chosen(pitched), restitutions, engine)
    return landed


def _landings_of_columns(
    base: AtBatScene, samples: Samples, restitutions: Sequence[float], engine: Batch
) -> Array:
    from longball.engines.batch import solve_columns_with_restitutions

    landed = []
    for table in solve_columns_with_restitutions(base, samples.columns, restitutions, engine):
        outcome = table["outcome"]
        stopped, nothing = outcome == "wall", np.full(len(outcome), np.nan)
        place = [
            np.where(stopped, *(table.get(f"{name}.position[{i}]", nothing) for name in _PLACES))
            for i in (0, 1)
        ]
        landed.append([*place, outcome == "", outcome == "home_run"])
    return np.array(landed)


def _landings_of_scenes(
    base: AtBatScene, samples: Samples, restitutions: Sequence[float], engine: Engine
) -> Array:
    landed = np.full((len(restitutions), 4, len(samples)), np.nan)
    for i, scene in enumerate(filter(None, scenes(base, samples))):
        for k, result in enumerate(solve_with_restitutions(scene, restitutions, engine)):
            place = result.fence if result.outcome == "wall" else result.landing
            landed[k, 2:, i] = result.error is not None, result.outcome == "home_run"
            if place is not None and result.error is None:
                landed[k, :2, i] = place.position[:2]
    return landed
