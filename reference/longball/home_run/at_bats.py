"""The paper's random at-bats: their distributions, and samples drawn from them.

Samples are drawn in blocks, each with its own seed, so that neither the number of workers nor the
number of samples changes any of them.
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
        # Both parts always use the same number of draws: a sample does not change the next one.
        second = (generator.random(count) >= self.weight).astype(int)
        normal = generator.standard_normal(count)
        return np.take(self.means, second) + np.take(self.deviations, second) * normal

    @property
    def parts(self) -> tuple[tuple[float, float, float], ...]:
        """Weights, means and standard deviations of the parts with a positive weight."""
        weights = (self.weight, 1.0 - self.weight)
        every = zip(weights, self.means, self.deviations, strict=True)
        return tuple(part for part in every if part[0] > 0)

    def range(self, far: float) -> tuple[float, float]:
        """Return the range that extends `far` standard deviations from each mean."""
        ends = [(mean - far * s, mean + far * s) for _, mean, s in self.parts]
        return min(low for low, _ in ends), max(high for _, high in ends)

    @cached_property
    def distribution(self) -> Any:
        """The same distribution in `scipy.stats`, with ``pdf``, ``cdf`` and ``icdf``."""
        from scipy import stats  # slow to import, and not needed for --help

        weights, means, deviations = zip(*self.parts, strict=True)
        normals = [stats.Normal(mu=m, sigma=s) for m, s in zip(means, deviations, strict=True)]
        return stats.Mixture(normals, weights=weights)


@dataclass(frozen=True)
class AtBats:
    """Distributions of the random numbers of an at-bat."""

    # Speed of the pitch, m/s (paper, Eq. 3).
    speed: Mixture
    # Horizontal coordinate P_y of the point aimed at, m (paper, Eq. 4).
    aim: Mixture
    # Standard deviation of the height of the bat's axis above the pitch, m; the mean is 0 (paper,
    # Sec. III.A).
    offset_deviation: float
    # Largest tilt of the swing's axis, rad; the distribution is uniform from 0 (paper, Sec. III.A).
    largest_tilt: float

    @property
    def offset(self) -> Mixture:
        """The distribution of the bat's height over the pitch, m: one normal distribution."""
        return Mixture(1.0, (0.0, 0.0), (self.offset_deviation, self.offset_deviation))


def paper_at_bats(reading: SamplingReading) -> AtBats:
    """Return the paper's distributions, by a reading of Table II, Eqs. 2 to 4 and Sec. III."""
    # As printed, Table II exchanges means and standard deviations: a mean speed of 4.58 km/h.
    kmh = 1 / 3.6
    large, small = (139.1, 127.8), (4.58, 7.80)  # km/h, Table II
    means, spreads = (large, small) if reading.speed_table == "columns_swapped" else (small, large)
    # Eq. 2 as printed is exp(-(v - μ)²/σ²), with a standard deviation of σ/√2.
    per_spread = 1.0 if reading.speed_spread == "standard_deviation" else math.sqrt(0.5)
    # Eq. 4 has its means in cells, numbered from 1; the plate's middle is the middle of cell 3.
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
    """Base of dataclasses of arrays; equal indices form a row."""

    def chosen(self, which: NDArray[Any] | slice) -> Self:
        """Return some of the rows; fields that are not arrays stay the same."""
        held = vars(self).items()
        return type(self)(**{k: x[which] if isinstance(x, np.ndarray) else x for k, x in held})

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the rows of all parts."""
        columns = zip(*(vars(part).values() for part in parts), strict=True)
        return cls(*map(np.concatenate, columns))


@dataclass(frozen=True)
class Samples(Arrays):
    """Random inputs of at-bats, one array element for each: m/s, m, m, rad."""

    speed: Array
    aim: Array
    offset: Array
    tilt: Array

    def __len__(self) -> int:
        return len(self.speed)

    @property
    def pitched(self) -> Flags:
        """True where the speed is positive.

        With the printed columns of Table II, some speeds are negative: no pitch.
        """
        return self.speed > 0

    @property
    def columns(self) -> dict[str, Array]:
        """The columns under the names of scenes, as `longball.engines.batch` takes them."""
        return {
            "pitch.speed": self.speed,
            "pitch.aim[0]": self.aim,
            "swing.height_offset": self.offset,
            "swing.tilt": self.tilt,
        }


# Numbers that vary from sample to sample; `pitch.velocity` would replace speed and aim.
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
            raise ValueError(f"{name}: it varies from sample to sample, and cannot be set")


def draw(at_bats: AtBats, count: int, seed: int, first: int = 0) -> Samples:
    """Return `count` samples of a seed from number `first` on, which is a multiple of BLOCK."""
    blocks = range(first // BLOCK, math.ceil((first + count) / BLOCK))
    drawn = Samples.joined([draw_block(at_bats, seed, block) for block in blocks])
    return drawn.chosen(slice(count))


def draw_block(at_bats: AtBats, seed: int, block: int) -> Samples:
    """Return the samples of one block, from its own seed."""
    # SeedSequence makes the streams of different blocks independent, without a common state.
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))
    return Samples(
        speed=at_bats.speed.draw(BLOCK, generator),
        aim=at_bats.aim.draw(BLOCK, generator),
        offset=at_bats.offset_deviation * generator.standard_normal(BLOCK),
        tilt=at_bats.largest_tilt * generator.random(BLOCK),
    )


def scenes(base: AtBatScene, samples: Samples, first: int = 0) -> Iterator[AtBatScene | None]:
    """Yield a scene for each sample: `base` with its values, and an id that counts from `first`.

    Yields None for a negative speed.
    """
    rows = zip(*(column.tolist() for column in samples.columns.values()), strict=True)
    for i, (row, pitched) in enumerate(zip(rows, samples.pitched, strict=True), first):
        if not pitched:
            yield None
            continue
        scene = replaced(base, dict(zip(samples.columns, row, strict=True)))
        yield scene.model_copy(update={"id": f"sample-{i:06d}"})


def with_restitution(scene: AtBatScene, restitution: float) -> AtBatScene:
    """Return a scene with another restitution of the ball, and the restitution in its id."""
    other = replaced(scene, {"ball.restitution": restitution})
    return other.model_copy(update={"id": f"{scene.id}-e{restitution:g}"})
