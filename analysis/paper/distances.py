"""How far a reading is from the paper's Figs. 6 and 7, in units of their Monte-Carlo noise."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from analysis.paper.printed import PEAKS, SAMPLES
from longball.home_run import RESTITUTIONS, Curve, Estimate
from longball.model.arrays import Array, Integers

# Of 20 correct readings, one is farther off: from Fig. 7, and from it and both peaks of Fig. 6.
NEAR, NEAR_BOTH = float(chi2.ppf(0.95, df=2)), float(chi2.ppf(0.95, df=6))
BIN = 10.0  # m; the peaks at 75 m and 125 m are the middles of bins of 10 m
DRAWS = 10_000  # of the paper's samples, for the peaks: a chance of 1 % is known to 10 % of it

_E = np.array(RESTITUTIONS)
# What five points have to say about a curve that is nearly straight over them: a height and a
# slope. A fit with two parameters, like the paper's, keeps both.
HEIGHT_AND_SLOPE = np.linalg.pinv(np.stack([np.ones(len(_E)), _E - _E.mean()], axis=1))


def covariance(p: Array, shared: bool) -> Array:
    """Return the covariance of shares of home runs, of one sample each, at rising restitutions.

    With samples of its own every share is on its own. With the same samples for all, a home run
    at one restitution is one at any higher restitution too: E[1ᵢ 1ⱼ] = min(Pᵢ, Pⱼ).
    """
    if shared:
        return np.minimum.outer(p, p) - np.multiply.outer(p, p)
    return np.diag(p * (1 - p))


class Distance(NamedTuple):
    """How far the paper's curve lies from a reading, if it was fitted to 1,000 samples a point.

    Level and slope are the curve's mean and slope over the five restitutions, less the reading's,
    each in its own standard errors. The square is of both together: χ² with 2 degrees of freedom if
    the reading is the paper's.
    """

    level: float
    slope: float
    squared: float

    @property
    def near(self) -> bool:
        """Whether the two cannot be told apart at a level of 95 %."""
        return self.squared <= NEAR


def distance(rows: Sequence[Estimate], curve: Curve, shared: bool = False) -> Distance:
    """Return how far the paper's curve lies from a reading.

    The rows are its P at the five restitutions, from the same samples. The rounding of a printed
    curve's parameters is a tenth of the noise. `shared` is whether the paper took the same samples
    for all restitutions, which it does not say.
    """
    # Half a home run more and half a miss: a share of 0 is not certain either.
    p = np.array([(row.home_runs + 0.5) / (row.trials + 1) for row in rows])
    ours = covariance(p, shared=True) / rows[0].trials
    noise = covariance(p, shared) / SAMPLES + ours
    off = HEIGHT_AND_SLOPE @ (np.array([curve(e) for e in RESTITUTIONS]) - p)
    spread = HEIGHT_AND_SLOPE @ noise @ HEIGHT_AND_SLOPE.T
    level, slope = off / np.sqrt(np.diag(spread))
    return Distance(float(level), float(slope), float(off @ np.linalg.solve(spread, off)))


def histogram(distances: Array) -> Integers:
    """Return how many distances lie in each bin of 10 m."""
    return np.bincount((distances / BIN).astype(int), minlength=1)


def density(distances: Array) -> Array:
    """Return the density of distances in each bin of 10 m, 1/m."""
    return histogram(distances) / (BIN * len(distances))


def highest(distances: Array) -> float:
    """Return the middle of the highest bin, m."""
    return BIN * (int(np.argmax(histogram(distances))) + 0.5)


def peak_chances(distances: Array, share: float, generator: np.random.Generator) -> Array:
    """Return the chance of each bin to be the highest of a histogram of 1,000 samples.

    The distances, m, are those of many samples of which a share has one.
    """
    counts = histogram(distances)
    shares = np.append(counts * (share / counts.sum()), 1 - share)
    drawn = generator.multinomial(SAMPLES, shares, DRAWS)[:, :-1]
    # A random number below 1 picks one of bins that are equally high.
    tops = np.argmax(drawn + generator.random(drawn.shape), axis=1)
    return np.bincount(tops, minlength=len(counts)) / DRAWS


class Peak(NamedTuple):
    """The highest peak of D at one restitution.

    The p value is twice the chance of a peak as near as the paper's or nearer, or as far or
    farther, whichever is smaller: small if the reading does not have it there.
    """

    ours: float  # m, the middle of the bin that is most often the highest
    p_value: float


def peak(e: float, distances: Array, share: float, generator: np.random.Generator) -> Peak:
    """Compare the highest peak at a restitution with the one of Fig. 6."""
    chances = peak_chances(distances, share, generator)
    at = int(PEAKS[e] / BIN)
    tail = min(chances[: at + 1].sum(), chances[at:].sum())
    # One more, the paper's own, so that no finite number of draws makes it impossible.
    p_value = 2 * (tail * DRAWS + 1) / (DRAWS + 1)
    return Peak(BIN * (int(np.argmax(chances)) + 0.5), min(1.0, float(p_value)))


def total(seven: Distance, peaks: Sequence[Peak]) -> float:
    """Return the distance to Fig. 7 and the peaks of Fig. 6 together, by Fisher's method.

    -2 Σ ln p, a χ² with 2 degrees of freedom for each p if the reading is the paper's and the
    figures come from samples of their own; that of Fig. 7 is the distance itself, squared.
    """
    return seven.squared - 2 * sum(math.log(one.p_value) for one in peaks)
