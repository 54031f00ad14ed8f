"""Monte Carlo: landings of sampled at-bats.

Every sample is drawn once and struck with every restitution asked for, so that differences of
P(e) along e carry little noise.
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


# Where a ball that meets the fence stays, and where another one lands.
_PLACES = "fence", "landing"

HOME_RUN_DISTANCE = 150.0  # m; paper, Sec. IV

# Samples that a thread takes at a time: some hundredths of a second.
COLUMNS = 200 * BLOCK


@dataclass(frozen=True)
class Struck(Arrays):
    """Landings of at-bats, one array element for each."""

    # m, where the ball landed, or met the fence; NaN if it was not batted.
    x: Array
    y: Array
    failed: Flags  # whether the engine could not decide

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
    """Landings of at-bats in a field with a fence, which the ball may be `over` as a home run."""

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
    """Return the landings of samples of a seed, the same ones at each restitution.

    `base` is everything about the at-bats that is not random. Fewer samples are the first of more.
    The batch engine, which is the default, solves columns in threads, another one scene by scene in
    processes; their number changes no bit. `progress` is called with the number of samples done.
    """
    solver = engine or create("batch")
    threads = isinstance(solver, ManyAtOnce)
    size = COLUMNS if threads else BLOCK
    calls = (
        (base, at_bats, tuple(restitutions), first, min(size, count - first), seed, solver)
        for first in range(0, count, size)
    )
    # x, y, failure and home runs, in place as the blocks come in order
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
    # Drawn where they are struck: blocks have seeds of their own, and need not be sent.
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
