"""Distance of a reading from the paper's Figs. 6 and 7, in units of their Monte-Carlo noise."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from analysis.paper.printed import PEAKS, SAMPLES
from longball.home_run import HOME_RUN_DISTANCE, RESTITUTIONS, Curve, Estimate
from longball.model.arrays import Array, Integers

LEVEL = 0.05  # of 20 correct readings, one is farther off
NEAR = float(chi2.ppf(1.0 - LEVEL, df=2))
BIN = 10.0  # m; the peaks at 75 m and 125 m are the middles of bins of 10 m, and of 50 m
BINS = (10.0, 20.0, 25.0, 50.0)  # m; the paper does not say how wide its bins are
CELL, CELLS = 5.0, 100  # m; cells of which all these bins consist, the last one open
DRAWS = 4_000  # of the paper: a chance of 5 % is known to 7 % of it

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


def distance(rows: Sequence[Estimate], curve: Curve, shared: bool = False) -> float:
    """Return d², how far the paper's curve lies from a reading: squared, in units of the noise.

    Both the curve's mean and its slope over the five restitutions count. If the reading is the
    paper's, and the curve was fitted to 1,000 samples a point, this is a χ² with 2 degrees of
    freedom, below `NEAR` 95 % of the time.

    The rows are the reading's P at the five restitutions, from the same samples. The rounding of a
    printed curve's parameters is a tenth of the noise. `shared` is whether the paper took the same
    samples for all restitutions, which it does not say.
    """
    # Half a home run more and half a miss: a share of 0 is not certain either.
    p = np.array([(row.home_runs + 0.5) / (row.trials + 1) for row in rows])
    ours = covariance(p, shared=True) / rows[0].trials
    noise = covariance(p, shared) / SAMPLES + ours
    off = HEIGHT_AND_SLOPE @ (np.array([curve(e) for e in RESTITUTIONS]) - p)
    spread = HEIGHT_AND_SLOPE @ noise @ HEIGHT_AND_SLOPE.T
    return float(off @ np.linalg.solve(spread, off))


def histogram(distances: Array) -> Integers:
    """Count distances in bins of 10 m."""
    return np.bincount((distances / BIN).astype(int), minlength=1)


def density(distances: Array) -> Array:
    """Return the density of distances in each bin of 10 m, 1/m."""
    return histogram(distances) / (BIN * len(distances))


def highest(distances: Array) -> float:
    """Return the middle of the highest bin, m."""
    return BIN * (int(np.argmax(histogram(distances))) + 0.5)


class Peak(NamedTuple):
    """The highest peak of D at one restitution, in bins of one width.

    The p value is twice the chance of a peak as near as the paper's or nearer, or as far or
    farther, whichever is smaller: small if the reading does not have it there.
    """

    ours: float  # m, the middle of the bin that is most often the highest
    p_value: float


class Score(NamedTuple):
    """Figs. 6 and 7 together, with a histogram in bins of one width."""

    p_value: float  # of the figures together: chance of a paper that is as far off, or farther
    peaks: dict[float, Peak]  # by restitution


def scores(
    cells: Mapping[float, Array],
    seven: float,
    generator: np.random.Generator,
    draws: int = DRAWS,
) -> dict[float, Score]:
    """Hold both figures against a reading, by the width of the bins of Fig. 6, m.

    Parameters
    ----------
    cells
        The shares of a reading's samples in cells of D, as `in_cells` returns them, at the five
        restitutions.
    seven
        d² of the paper's curve from the reading, see `distance`.
    generator, draws
        What the papers are drawn with, and how many.

    Notes
    -----
    The papers are drawn under the reading: five samples of 1,000, two of which have a
    histogram, too. A paper's score is its distance from the reading in Fig. 7, squared, less
    2 ln p for both peaks. The p value is the rank of the printed figures among them, so that it
    does not matter that the figures share samples.
    """
    drawn = {
        e: generator.multinomial(SAMPLES, shares, draws)[:, :-1] for e, shares in cells.items()
    }
    fence = round(HOME_RUN_DISTANCE / CELL)
    p = np.array([shares[fence:-1].sum() for shares in cells.values()])
    seen = np.array([counts[:, fence:].sum(axis=1) for counts in drawn.values()]) / SAMPLES
    off = HEIGHT_AND_SLOPE @ (seen - p[:, None])
    spread = HEIGHT_AND_SLOPE @ covariance(p, shared=False) @ HEIGHT_AND_SLOPE.T / SAMPLES
    by_curve = np.einsum("id,id->d", off, np.linalg.solve(spread, off))
    found = {}
    for width in BINS:
        ours, printed, peaks = by_curve.copy(), seven, {}
        for e, at in PEAKS.items():
            counts = drawn[e].reshape(draws, -1, round(width / CELL)).sum(axis=2)
            # A random number below 1 picks one of bins that are equally high.
            tops = np.argmax(counts + generator.random(counts.shape), axis=1)
            # With the paper's own among them no finite number of draws makes it impossible.
            # A peak that is printed at the edge of two bins lies in the upper one.
            chances = np.bincount(np.append(tops, int(at / width)), minlength=counts.shape[1])
            below, above = np.cumsum(chances), np.cumsum(chances[::-1])[::-1]
            p_values = np.minimum(1.0, 2.0 * np.minimum(below, above) / (draws + 1))
            ours -= 2.0 * np.log(p_values[tops])
            printed -= 2.0 * math.log(p_values[int(at / width)])
            most = width * (int(np.argmax(np.bincount(tops))) + 0.5)
            peaks[e] = Peak(most, float(p_values[int(at / width)]))
        p_value = float((ours >= printed).sum() + 1) / (draws + 1)
        found[width] = Score(p_value, peaks)
    return found


def in_cells(distances: Array, share: float) -> Array:
    """Return the shares of samples in cells of D, and last of those that have none.

    The distances, m, are those of many samples of which a share has one.
    """
    cells = np.minimum((distances / CELL).astype(int), CELLS - 1)
    return np.append(np.bincount(cells, minlength=CELLS) * (share / len(distances)), 1.0 - share)
