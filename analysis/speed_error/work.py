"""What everyone is given to solve: the same flights, the same at-bats; and the truth about them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from analysis import Array
from longball import engines
from longball.engines.chain import solve
from longball.home_run import draw, paper_at_bats
from longball.model.quantities import replaced
from longball.model.readings import SamplingReading
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Launch

Scene = FlightScene | AtBatScene

SEED = 1
HEIGHT = 1.0  # m, of the launches
TRUE_DIGITS = 40


@dataclass(frozen=True)
class Work:
    """Scenes that differ in some of their numbers."""

    base: Scene  # what is the same in all
    columns: dict[str, Array]  # what differs, as `longball.engines.batch.solve_columns` takes it
    true: Sequence[Result] = ()  # the truth about the first of them

    def __len__(self) -> int:
        return min(map(len, self.columns.values()))

    def first(self, count: int) -> "Work":
        """Return the first scenes."""
        return self.part(slice(count))

    def part(self, rows: slice | list[int]) -> "Work":
        """Return some of the scenes."""
        return Work(self.base, {name: column[rows] for name, column in self.columns.items()})

    @cached_property
    def scenes(self) -> list[Scene]:
        """The scenes one by one."""
        rows = zip(*(column.tolist() for column in self.columns.values()), strict=True)
        return [replaced(self.base, dict(zip(self.columns, row, strict=True))) for row in rows]


def flights(count: int) -> Work:
    """Return launches of batted balls: line drives to high flies, 25 to 50 m/s, 5° to 60°."""
    rng = np.random.default_rng(SEED)
    speed, rise = rng.uniform(25.0, 50.0, count), np.radians(rng.uniform(5.0, 60.0, count))
    level = Launch(position=(0.0, 0.0, HEIGHT), velocity=(30.0, 0.0, 30.0))
    velocity = {0: speed * np.cos(rise), 2: speed * np.sin(rise)}
    columns = {f"launch.velocity[{i}]": column for i, column in velocity.items()}
    return Work(FlightScene(id="flight", launch=level), columns)


def at_bats(count: int, seed: int = SEED) -> Work:
    """Return at-bats of the paper's distributions."""
    base = AtBatScene(id="at-bat")
    return Work(base, draw(paper_at_bats(SamplingReading()), count, seed).columns)


def truth(work: Work) -> list[Result]:
    """Return the results of scenes with proven digits."""
    exact = engines.create("enclosure", digits=TRUE_DIGITS)
    return [solve(scene, exact) for scene in work.scenes]


def known(work: Work, count: int) -> Work:
    """Return work with the truth about so many of its scenes."""
    return replace(work, true=truth(work.first(count)))
