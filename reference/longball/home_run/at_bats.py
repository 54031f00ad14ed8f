"""The paper's random at-bats: their distributions, and samples drawn from them.

Samples come in blocks with a seed each, so that neither the number of workers nor the number of
samples asked for changes any one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from longball.model.arrays import Array, Flags
from longball.model.quantities import at, replaced
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

MIDDLE_CELL = 3.0  # of the five that the pitching zone is divided into (paper, Sec. II)
BLOCK = 50  # samples drawn from one seed


@dataclass(frozen=True)
class Mixture:
    """Two normal distributions, the first one drawn with probability `weight`."""

    weight: float
    means: tuple[float, float]
    deviations: tuple[float, float]

    def draw(self, count: int, generator: np.random.Generator) -> Array:
        """Return `count` draws."""
        # The same number of draws whatever comes out, so that a sample does not move the next one.
        second = (generator.random(count) >= self.weight).astype(int)
        normal = generator.standard_normal(count)
        return np.take(self.means, second) + np.take(self.deviations, second) * normal

    @property
    def parts(self) -> tuple[tuple[float, float, float], ...]:
        """Weights, means and standard deviations of the normal distributions that are drawn."""
        weights = (self.weight, 1.0 - self.weight)
        every = zip(weights, self.means, self.deviations, strict=True)
        return tuple(part for part in every if part[0] > 0)

    def range(self, far: float) -> tuple[float, float]:
        """Return between what all lies that is no more standard deviations than `far` off."""
        ends = [(mean - far * s, mean + far * s) for _, mean, s in self.parts]
        return min(low for low, _ in ends), max(high for _, high in ends)

    @cached_property
    def distribution(self) -> Any:
        """As `scipy.stats` has it: with ``pdf``, ``cdf`` and ``icdf``."""
        from scipy import stats  # slow to import, and not needed for --help

        weights, means, deviations = zip(*self.parts, strict=True)
        normals = [stats.Normal(mu=m, sigma=s) for m, s in zip(means, deviations, strict=True)]
        return stats.Mixture(normals, weights=weights)


@dataclass(frozen=True)
class AtBats:
    """The distributions that at-bats are drawn from."""

    speed: Mixture  # m/s, of the pitch (paper, Eq. 3).
    aim: Mixture  # m, the horizontal coordinate P_y of the point aimed at (paper, Eq. 4).
    # m, of the height of the bat's axis over the pitch; its mean is 0 (paper, Sec. III.A).
    offset_deviation: float
    largest_tilt: float  # rad, of the swing's axis, which is uniform from 0 (paper, Sec. III.A).

    @property
    def offset(self) -> Mixture:
        """The distribution of the bat's height over the pitch, m: one normal distribution."""
        return Mixture(1.0, (0.0, 0.0), (self.offset_deviation, self.offset_deviation))


def paper_at_bats(reading: SamplingReading) -> AtBats:
    """Return the paper's distributions, as a reading of Table II, Eqs. 2 to 4 and Sec. III."""
    kmh = 1 / 3.6
    large, small = (139.1, 127.8), (4.58, 7.80)  # km/h, Table II
    means, spreads = (large, small) if reading.speed_table == "columns_swapped" else (small, large)
    # As printed, exp(-(v - μ)²/σ²): the standard deviation is σ/√2.
    per_spread = 1.0 if reading.speed_spread == "standard_deviation" else math.sqrt(0.5)
    width = reading.cell_width
    left, right, deviation = (2.0 - MIDDLE_CELL) * width, (4.0 - MIDDLE_CELL) * width, 0.77 * width
    return AtBats(
        speed=Mixture(
            0.45,
            (means[0] * kmh, means[1] * kmh),
            (spreads[0] * kmh * per_spread, spreads[1] * kmh * per_spread),
        ),
        aim=Mixture(0.52, (left, right), (deviation, deviation)),  # Eq. 4
        offset_deviation=reading.offset_spread,
        largest_tilt=math.radians(10.0),
    )


class Arrays:
    """A base of dataclasses of arrays, whose elements of one number are a row."""

    def chosen(self, which: NDArray[Any] | slice) -> Self:
        """Return some of the rows, with what is no array as it is."""
        held = vars(self).values()
        return type(self)(*(x[which] if isinstance(x, np.ndarray) else x for x in held))

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the rows of all parts, one after the other."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*map(np.concatenate, columns))


@dataclass(frozen=True)
class Samples(Arrays):
    """Random inputs of at-bats, an array element each: m/s, m, m, rad."""

    speed: Array
    aim: Array
    offset: Array
    tilt: Array

    def __len__(self) -> int:
        return len(self.speed)

    @property
    def pitched(self) -> Flags:
        """True where the speed is positive.

        The printed columns of Table II draw others, too: such a ball is never pitched.
        """
        return self.speed > 0

    @property
    def columns(self) -> dict[str, Array]:
        """As `longball.engines.batch.solve_columns` names them."""
        return {
            "pitch.speed": self.speed,
            "pitch.aim[0]": self.aim,
            "swing.height_offset": self.offset,
            "swing.tilt": self.tilt,
        }


# Numbers of an at-bat that a sample has of its own; a velocity stands for the speed and the aim.
DRAWN = (
    "ball.restitution",
    "pitch.velocity",
    "pitch.speed",
    "pitch.aim",
    "swing.tilt",
    "swing.height_offset",
)


def refuse_drawn(base: AtBatScene) -> None:
    """Raise a ValueError if an at-bat sets a number that varies from sample to sample."""
    usual = AtBatScene()
    for name in DRAWN:
        if at(base, name) != at(usual, name):
            raise ValueError(f"{name}: it varies from sample to sample")


def draw(at_bats: AtBats, count: int, seed: int, first: int = 0) -> Samples:
    """Return samples of a seed, from the one numbered `first` on: a multiple of BLOCK."""
    blocks = range(first // BLOCK, math.ceil((first + count) / BLOCK))
    drawn = Samples.joined([draw_block(at_bats, seed, block) for block in blocks])
    return drawn.chosen(slice(count))


def draw_block(at_bats: AtBats, seed: int, block: int) -> Samples:
    """Return the samples of one block, from a seed of its own."""
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))
    return Samples(
        speed=at_bats.speed.draw(BLOCK, generator),
        aim=at_bats.aim.draw(BLOCK, generator),
        offset=at_bats.offset_deviation * generator.standard_normal(BLOCK),
        tilt=at_bats.largest_tilt * generator.random(BLOCK),
    )


def scenes(base: AtBatScene, samples: Samples, first: int = 0) -> Iterator[AtBatScene | None]:
    """Yield a scene a sample: `base` with what was drawn, and an id that counts from `first`.

    Yields None for a ball that is never pitched.
    """
    rows = zip(*(column.tolist() for column in samples.columns.values()), strict=True)
    for i, (row, pitched) in enumerate(zip(rows, samples.pitched, strict=True), first):
        if not pitched:
            yield None
            continue
        scene = replaced(base, dict(zip(samples.columns, row, strict=True)))
        yield scene.model_copy(update={"id": f"sample-{i:06d}"})


def with_restitution(scene: AtBatScene, restitution: float) -> AtBatScene:
    """Return a scene with another restitution of the ball, which its id tells."""
    other = replaced(scene, {"ball.restitution": restitution})
    return other.model_copy(update={"id": f"{scene.id}-e{restitution:g}"})
