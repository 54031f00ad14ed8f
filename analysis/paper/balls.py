"""Balls struck by the batch engine, with what the paper's studies ask of them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import joblib
import numpy as np
from numpy.typing import NDArray

from analysis import Array
from longball import home_run
from longball.engines.batch import solve_columns_with_restitutions
from longball.engines.chain import solve_with_restitutions
from longball.engines.verlet import Verlet
from longball.home_run import Estimate, Samples, Struck
from longball.model.quantities import number, replaced
from longball.model.readings import SampleSpace, SamplingReading
from longball.model.scene import AtBatScene

Flags = NDArray[np.bool_]


class Base(NamedTuple):
    """An at-bat's constants, and the reading that its random inputs are drawn under."""

    scene: AtBatScene
    sampling: SamplingReading = SamplingReading()

    def number(self, name: str) -> float:
        """Return a number of the scene or of the sampling by its name there."""
        block = self.sampling if name in SamplingReading.model_fields else self.scene
        return float(number(block, name))

    def replaced(self, values: Mapping[str, float]) -> Base:
        """Return the pair with other numbers, by the same names."""
        sampled = {name: x for name, x in values.items() if name in SamplingReading.model_fields}
        fixed = {name: x for name, x in values.items() if name not in sampled}
        return Base(replaced(self.scene, fixed), replaced(self.sampling, sampled))


@dataclass(frozen=True)
class Balls(Struck):
    """What became of at-bats, an array element each, NaN where the ball was not batted."""

    pitch_speed: Array  # m/s, of the ball as it meets the bat
    exit_speed: Array  # m/s, of the ball as it leaves it
    elevation: Array  # rad, of its direction then

    def chosen(self, which: Flags) -> Balls:
        """Return some of them."""
        return Balls(*(getattr(self, field.name)[which] for field in fields(self)))


def strike(
    base: Base, samples: Samples, restitutions: Sequence[float], threads: int = 1
) -> list[Balls]:
    """Return what becomes of samples, the same ones at each restitution.

    `longball.home_run.monte_carlo` gives the same landings; here the collision is kept too.
    """
    pitched = samples.pitched
    tables = solve_columns_with_restitutions(
        base.scene, samples.chosen(pitched).columns, restitutions, threads=threads
    )

    def whole(column: Array) -> Array:
        full = np.full(len(pitched), np.nan)
        full[pitched] = column
        return full

    def one(table: Mapping[str, Array]) -> Balls:
        after = np.array([table[f"impact.velocity[{i}]"] for i in range(3)])
        normal = np.array([table[f"contact.normal[{i}]"] for i in range(3)])
        before = after - table["impact.impulse"] / base.scene.ball.mass * normal
        failed = np.zeros(len(pitched), bool)
        failed[pitched] = table["outcome"] == ""
        return Balls(
            x=whole(table["landing.position[0]"]),
            y=whole(table["landing.position[1]"]),
            failed=failed,
            pitch_speed=whole(np.sqrt((before * before).sum(axis=0))),
            exit_speed=whole(np.sqrt((after * after).sum(axis=0))),
            elevation=whole(np.arctan2(after[2], np.hypot(after[0], after[1]))),
        )

    return [one(table) for table in tables]


CHUNK = 500  # at-bats that a process takes at a time by the paper's scheme


def strike_in_steps(
    base: Base, count: int, seed: int, restitutions: Sequence[float], scheme: Verlet
) -> list[Balls]:
    """Return what becomes of samples by the paper's scheme."""
    parts = joblib.Parallel(n_jobs=-1)(
        joblib.delayed(_chunk_in_steps)(base, first, min(CHUNK, count - first), seed, e, scheme)
        for e in [tuple(restitutions)]
        for first in range(0, count, CHUNK)
    )
    columns = np.concatenate(parts, axis=2)
    return [Balls(x, y, failed > 0, *blow) for x, y, failed, *blow in columns]


def _chunk_in_steps(
    base: Base, first: int, count: int, seed: int, restitutions: tuple[float, ...], scheme: Verlet
) -> Array:
    """Return the fields of `Balls` for some of the samples: (restitution, field, sample)."""
    found = np.full((len(restitutions), len(fields(Balls)), count), np.nan)
    found[:, 2] = 0.0
    samples = home_run.draw(home_run.paper_at_bats(base.sampling), count, seed, first)
    for i, scene in enumerate(home_run.scenes(base.scene, samples, first)):
        if scene is None:
            continue
        for k, result in enumerate(solve_with_restitutions(scene, restitutions, scheme)):
            if result.error is not None:
                found[k, 2, i] = 1.0
            elif result.landing and result.impact and result.contact:
                after = np.array(result.impact.velocity, np.float64)
                normal = np.array(result.contact.normal, np.float64)
                push = float(result.impact.impulse) / scene.ball.mass
                found[k, :2, i] = result.landing.position[:2]
                found[k, 3:, i] = (
                    np.linalg.norm(after - push * normal),
                    np.linalg.norm(after),
                    math.atan2(after[2], math.hypot(after[0], after[1])),
                )
    return found


def cores() -> int:
    """Return how many threads are worth starting."""
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Space:
    """Which at-bats are among the samples that P(e) is a share of.

    `flies` tells whether only balls that leave the bat upwards are among them. The ledger does not
    have this: the paper nowhere says so, but its Fig. 6 does (see the report).
    """

    name: str
    ledger: SampleSpace
    flies: bool = False

    def members(self, balls: Balls) -> Balls:
        """Return the balls that may be among the samples, misses included."""
        return balls.chosen(balls.elevation > 0) if self.flies else balls

    def distances(self, balls: Balls) -> Array:
        """Return D, m, of the balls among the samples that have one."""
        members = self.members(balls)
        landed = members.fair if self.ledger == "fair" else members.batted
        return members.distance[landed]

    def estimate(self, e: float, balls: Balls) -> Estimate:
        """Count the home runs."""
        return home_run.estimate(e, self.members(balls), self.ledger)

    def share(self, balls: Balls) -> Share:
        """Return P with what each at-bat has to do with it; there must be a member."""
        everyone = np.ones_like(balls.batted)
        members = {"pitches": everyone, "batted": balls.batted, "fair": balls.fair}
        member = members[self.ledger] & ((balls.elevation > 0) | (not self.flies))
        over = member & (balls.distance >= home_run.HOME_RUN_DISTANCE)
        p = float(over.sum() / member.sum())
        return Share(p, (over - p * member) / member.mean())


@dataclass(frozen=True)
class Share:
    """P, home runs over members of the sample space, and what each at-bat has to do with it.

    `influence` has one number for each at-bat pitched, with the mean 0: p's standard error is their
    standard deviation over √n, and that of the difference of two shares of the same at-bats is
    found from the difference of theirs (the delta method for a ratio).
    """

    p: float
    influence: Array

    def above(self, other: Share) -> tuple[float, float]:
        """Return by how much this share is larger, and the standard error of that."""
        apart = self.influence - other.influence
        return self.p - other.p, float(apart.std() / math.sqrt(len(apart)))


SPACES = (
    Space("pitches", "pitches"),
    Space("batted", "batted"),
    Space("fair", "fair"),
    Space("flies", "batted", flies=True),
    Space("fair flies", "fair", flies=True),
)


def describe(base: Base, space: Space) -> str:
    """Say in which readings and numbers an at-bat differs from the default ones."""
    default = AtBatScene(id="default")
    numbers = [
        f"{name}.{key} = {value:g}"
        for name in ("ball", "bat", "air")
        for key, value in getattr(base.scene, name).model_dump().items()
        if value != getattr(getattr(default, name), key) and key != "restitution"
    ]
    turned = base.scene.reading.model_dump() | base.sampling.model_dump()
    switches = [f"{key} = {value}" for key, value in turned.items()]
    chosen = [] if space == SPACES[0] else [f"samples: {space.name}"]
    return ", ".join(numbers + switches + chosen) or "nothing changed"
