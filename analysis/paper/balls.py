"""Balls struck by the batch engine, with what the paper's studies ask of them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import joblib
import numpy as np

from longball import home_run
from longball.engines.batch import solve_columns_with_restitutions
from longball.engines.parallel import in_parallel
from longball.engines.verlet import Verlet, impulse_share
from longball.home_run import HOME_RUN_DISTANCE, RESTITUTIONS, Estimate, Samples, Struck
from longball.home_run.simulation import Table, solved
from longball.model.arrays import Array, Flags
from longball.model.quantities import number, numbers, replaced
from longball.model.readings import ContactForce, SampleSpace, SamplingReading
from longball.model.scene import AtBatScene

# At-bats, and what they are drawn by: the same ones in all studies, so that what two of them give
# is the same number.
SAMPLES, SEED = 50_000, 1
STEPPED_SAMPLES = 10_000  # the first of them, by the scheme; most pass the bat unseen


class Base(NamedTuple):
    """An at-bat's constants, and the reading that its random inputs are drawn under.

    The contact force is that of Appendix B in velocity Verlet. Without the scheme's steps it is its
    limit as they vanish: the same collision with another impulse.
    """

    scene: AtBatScene
    sampling: SamplingReading = SamplingReading()
    contact_force: ContactForce = "whole"

    def restitution(self, e: float) -> float:
        """Return the restitution of the ball that the whole force strikes as this one strikes e.

        In every reading of the collision the impulse is proportional to 1 + e (Sec. III.C).
        """
        # For the whole force e itself, to the last bit.
        return e + (impulse_share(self.contact_force) - 1.0) * (1.0 + e)

    def number(self, name: str) -> float:
        """Return a number of the scene or of the sampling by its name there."""
        block = self.sampling if name in SamplingReading.model_fields else self.scene
        return float(number(block, name))

    def replaced(self, values: Mapping[str, float]) -> "Base":
        """Return the pair with other numbers, by the same names."""
        sampled = {name: x for name, x in values.items() if name in SamplingReading.model_fields}
        fixed = {name: x for name, x in values.items() if name not in sampled}
        return self._replace(
            scene=replaced(self.scene, fixed), sampling=replaced(self.sampling, sampled)
        )

    def drawn(self, count: int = SAMPLES, seed: int = SEED) -> Samples:
        """Return random inputs: the same ones for every scene."""
        return home_run.draw(home_run.paper_at_bats(self.sampling), count, seed)


@dataclass(frozen=True)
class Balls(Struck):
    """Outcomes of at-bats, one array element each; NaN where the ball was not batted."""

    pitch_speed: Array  # m/s, of the ball as it meets the bat
    exit_speed: Array  # m/s, of the ball as it leaves it
    elevation: Array  # rad, of its direction then


VECTORS = "landing.position", "impact.velocity", "contact.normal"


def strike(
    base: Base,
    samples: Samples,
    restitutions: Sequence[float],
    threads: int = joblib.effective_n_jobs(-1),
) -> list[Balls]:
    """Solve samples, the same ones at each restitution.

    `longball.home_run.monte_carlo` gives the same landings; here the collision is kept too.
    """
    columns, own = samples.chosen(samples.pitched).columns, [*map(base.restitution, restitutions)]
    tables = solve_columns_with_restitutions(base.scene, columns, own, threads=threads)
    return [_balls(table, base, samples.pitched) for table in tables]


def _balls(table: Table, base: Base, pitched: Flags, pushed: float = 1.0) -> Balls:
    """Return the balls of a table of results, which has a row for each that was pitched.

    A scheme leaves them with so many times the impulse that the results have.
    """
    nothing = np.full(len(table["outcome"]), np.nan)
    place, after, normal = (
        np.array([table.get(f"{name}[{i}]", nothing) for i in range(3)]) for name in VECTORS
    )
    change = table.get("impact.impulse", nothing) / base.scene.ball.mass * normal
    before = after - change
    after = before + pushed * change
    speeds = np.linalg.norm([before, after], axis=1)
    elevation = np.arctan2(after[2], np.hypot(after[0], after[1]))
    columns = np.full((6, len(pitched)), np.nan)
    columns[:, pitched] = [*place[:2], table["outcome"] == "", *speeds, elevation]
    x, y, failed, *rest = columns
    return Balls(x, y, failed == 1.0, np.hypot(x, y) >= HOME_RUN_DISTANCE, *rest)


CHUNK = 500  # at-bats that a process takes at a time by the paper's scheme


def strike_in_steps(
    base: Base, samples: Samples, restitutions: Sequence[float], scheme: Verlet
) -> list[Balls]:
    """Solve samples by the paper's scheme, with the contact force of the base."""
    scheme = replace(scheme, contact_force=base.contact_force)
    chosen = (samples.chosen(slice(i, i + CHUNK)) for i in range(0, len(samples), CHUNK))
    chunks = in_parallel(_chunk, ((base, x, restitutions, scheme) for x in chosen), workers=-1)
    return [Balls.joined(part) for part in zip(*chunks, strict=True)]


def _chunk(base: Base, some: Samples, restitutions: Sequence[float], scheme: Verlet) -> list[Balls]:
    tables = solved(base.scene, some.chosen(some.pitched), restitutions, scheme)
    share = impulse_share(scheme.contact_force)
    return [_balls(table, base, some.pitched, share) for table in tables]


@dataclass(frozen=True)
class Share:
    """P, home runs over members of the sample space, and what each at-bat has to do with it.

    `influence` has one number for each at-bat pitched, with the mean 0: p's standard error is their
    standard deviation over √n, and that of the difference of two shares of the same at-bats is
    found from the difference of theirs (the delta method for a ratio).
    """

    p: float
    influence: Array

    def above(self, other: "Share") -> tuple[float, float]:
        """Return by how much this share is larger, and the standard error of that."""
        apart = self.influence - other.influence
        return self.p - other.p, float(apart.std() / math.sqrt(len(apart)))


@dataclass(frozen=True)
class Space:
    """Which at-bats are among the samples that P(e) is a share of.

    Fig. 6 does not have the balls that are hit into the ground (see the report), though the text
    nowhere says so, nor how they are left out. Two rules are tried that the ledger does not have:
    only balls that leave the bat upwards (`flies`), or only balls that land `beyond` a distance, m.
    """

    name: str
    ledger: SampleSpace
    flies: bool = False
    beyond: float | None = None

    def members(self, balls: Balls) -> Flags:
        """Tell which balls are among the samples."""
        everyone = np.ones_like(balls.batted)
        of = {"pitches": everyone, "batted": balls.batted, "fair": balls.fair}[self.ledger].copy()
        if self.beyond is not None:
            of &= balls.distance > self.beyond
        return of & ((balls.elevation > 0) | (not self.flies))

    def distances(self, balls: Balls) -> Array:
        """Return D, m, of the balls among the samples that have one."""
        return balls.distance[self.members(balls) & balls.batted]

    def estimate(self, e: float, balls: Balls) -> Estimate:
        """Count the home runs."""
        return home_run.estimate(e, balls.chosen(self.members(balls)))

    def estimates(self, struck: Sequence[Balls]) -> list[Estimate]:
        """Count those of balls that were struck at the paper's restitutions."""
        return [self.estimate(e, balls) for e, balls in zip(RESTITUTIONS, struck, strict=True)]

    def share(self, balls: Balls) -> Share:
        """Return P with what each at-bat has to do with it; there must be a member."""
        member = self.members(balls)
        over = member & balls.home_run
        p = float(over.sum() / member.sum())
        return Share(p, (over - p * member) / member.mean())


SPACES = (
    Space("pitches", "pitches"),
    Space("batted", "batted"),
    Space("fair", "fair"),
    Space("flies", "batted", flies=True),
    Space("fair flies", "fair", flies=True),
    *(
        Space(f"{name}, D > {beyond:g} m", name, beyond=beyond)
        for beyond in (10.0, 20.0, 40.0)
        for name in ("batted", "fair")
    ),
)


def describe(base: Base, space: Space) -> str:
    """Say in which readings and numbers an at-bat differs from the default ones."""
    usual = dict(numbers(AtBatScene()))
    changed = [f"{x} = {value:g}" for x, value in numbers(base.scene) if value != usual[x]]
    turned = base.scene.reading.model_dump() | base.sampling.model_dump()
    chosen = [] if space == SPACES[0] else [f"samples: {space.name}"]
    if base.contact_force != "whole":
        turned["contact_force"] = base.contact_force
    switches = [f"{switch} = {option}" for switch, option in turned.items()]
    return ", ".join(changed + switches + chosen) or "nothing changed"
