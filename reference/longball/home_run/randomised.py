"""P(e) by randomised quasi-Monte Carlo, which shares no rule with the quadrature.

The height offset is integrated exactly between the roots of D = 150 m and the edges of the window
in which ball and bat meet. The other three variables are points of independently scrambled Sobol'
sequences (A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884), whose scatter estimates the error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from longball.engines.parallel import in_parallel
from longball.home_run.at_bats import AtBats, Samples
from longball.home_run.clearance import Clearance
from longball.home_run.crossings import crossings, probability, sampled
from longball.home_run.quadrature import FARTHEST
from longball.model.arrays import Array, Integers
from longball.model.readings import SampleSpace
from longball.model.scene import AtBatScene

# Independent estimates: 15 degrees of freedom for the standard error.
SCRAMBLES = 16
_LINES = 512  # of one task: a few tenths of a second


@dataclass(frozen=True)
class Randomised:
    """P(e) with its standard error, from independent scrambles; NaN without a sample space."""

    e: float
    p: float
    standard_error: float


def scrambled(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    lines: int,
    seed: int,
    *,
    sample_space: SampleSpace = "pitches",
    workers: int = 1,
) -> list[Randomised]:
    """Return P(e) at each restitution, by the batch engine, with the same points for all.

    `lines` is the number of points in each scramble, a power of 2. Each point is a line along the
    offset.
    """
    from longball.engines.batch import Batch  # slow to import, and not needed for --help

    # All scrambles are solved together, in long columns; `_means` separates them again.
    everything = Samples.joined([_lines(base, at_bats, lines, seed, i) for i in range(SCRAMBLES)])
    estimates = []
    for e in restitutions:
        home_runs = Clearance(base, e, Batch(), sample_space)
        each = _means(home_runs, at_bats, everything, workers)
        if sample_space != "pitches":
            space = replace(home_runs, counted="sample space")
            with np.errstate(invalid="ignore"):  # 0/0 where there is no sample space
                each = each / _means(space, at_bats, everything, workers)
        error = float(np.std(each, ddof=1)) / math.sqrt(SCRAMBLES)
        estimates.append(Randomised(e, float(np.mean(each)), error))
    return estimates


def _lines(base: AtBatScene, at_bats: AtBats, count: int, seed: int, scramble: int) -> Samples:
    """Return the lines of one scramble, without their offset.

    Speed and tilt follow their distributions. The aim is uniform over `_aims` (importance
    sampling): the end of the bat hits most home runs, and few pitches are thrown there.
    """
    from scipy.stats import qmc

    own = np.random.SeedSequence(seed, spawn_key=(scramble,))
    sobol = qmc.Sobol(3, rng=np.random.default_rng(own), bits=50)
    # A scrambled point may round to 0, whose quantile is infinite.
    unit = np.clip(sobol.random(count), 2.0**-51, None)
    low, high = _aims(base, at_bats)
    return Samples(
        at_bats.speed.distribution.icdf(unit[:, 0]),
        low + (high - low) * unit[:, 1],
        np.zeros(count),
        at_bats.largest_tilt * unit[:, 2],
    )


def _aims(base: AtBatScene, at_bats: AtBats) -> tuple[float, float]:
    """Return the range of the aims that occur and can touch the bat, m.

    The contact is at most R + r_b in front of the plate, on a line from the release to the aim.
    """
    x, y, _ = base.pitch.release
    fraction = (base.ball.radius + base.bat.radius) / x
    farthest = (base.bat.length / 2 + abs(y * fraction)) / (1.0 - fraction)
    low, high = at_bats.aim.range(FARTHEST)
    return max(-farthest, low), min(farthest, high)


def _means(clearance: Clearance, at_bats: AtBats, lines: Samples, workers: int) -> Array:
    """Return the probability of the counted at-bats in each scramble."""
    calls = (
        (clearance, at_bats, lines.chosen(slice(first, first + _LINES)))
        for first in range(0, len(lines), _LINES)
    )
    low, high = _aims(clearance.base, at_bats)
    shares = np.concatenate([*in_parallel(_share_over_offsets, calls, workers, threads=True)])
    # the weights of the uniform aims
    shares *= (high - low) * at_bats.aim.distribution.pdf(lines.aim)
    means: Array = shares.reshape(SCRAMBLES, -1).mean(axis=1)
    return means


def _share_over_offsets(clearance: Clearance, at_bats: AtBats, lines: Samples) -> Array:
    """Return the probability of the counted offsets on each line."""
    shares, pitched = np.zeros(len(lines)), lines.pitched
    lines = lines.chosen(pitched)
    grid = clearance.offsets(lines.speed, FARTHEST * at_bats.offset_deviation)

    def on_lines(offset: Array, line: Integers) -> Array:
        return clearance(replace(lines.chosen(line), offset=offset))

    values = sampled(on_lines, grid)
    ends = crossings(on_lines, grid, values)
    shares[pitched] = probability(at_bats.offset.distribution.cdf, grid, values, ends)
    return shares
