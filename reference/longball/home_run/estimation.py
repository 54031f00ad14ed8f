"""Counting home runs, and fitting the paper's form of P(e)."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

import numpy as np

from longball.home_run.at_bats import AtBats
from longball.home_run.simulation import HOME_RUN_DISTANCE, Struck, monte_carlo
from longball.model.arrays import Array
from longball.model.readings import SampleSpace
from longball.model.scene import AtBatScene

if TYPE_CHECKING:
    from longball.home_run.quadrature import Integral


RESTITUTIONS = (0.41, 0.42, 0.43, 0.44, 0.45)  # paper, Fig. 7


@dataclass(frozen=True)
class Estimate:
    """P(e) from samples, with its 95 % Wilson interval."""

    e: float  # the ball's coefficient of restitution
    # Home runs, and samples in the sample space.
    home_runs: int
    trials: int
    failed: int  # samples that the engine could not decide; they count as no home runs
    # Fraction of home runs, and its interval; NaN if there are no trials.
    p: float
    low: float
    high: float


def estimate(e: float, struck: Struck, sample_space: SampleSpace = "pitches") -> Estimate:
    """Count the home runs at one restitution: over the fence, or D >= 150 m (paper, Sec. IV)."""
    every = np.ones_like(struck.batted)
    space = {"pitches": every, "batted": struck.batted, "fair": struck.fair}[sample_space]
    hits = int(np.count_nonzero(space & struck.home_run))
    trials = int(np.count_nonzero(space))
    p = hits / trials if trials else math.nan
    low, high = wilson(hits, trials)
    return Estimate(e, hits, trials, int(np.count_nonzero(struck.failed)), p, low, high)


def estimates(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    count: int,
    seed: int,
    *,
    sample_space: SampleSpace = "pitches",
    **others: Any,
) -> list[Estimate]:
    """Return P(e) at each restitution, from the samples of `monte_carlo`."""
    struck = monte_carlo(base, at_bats, restitutions, count, seed, **others)
    return [estimate(e, one, sample_space) for e, one in zip(restitutions, struck, strict=True)]


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return Wilson's score interval of 95 % for a probability; NaN without a trial.

    The roots p of (k/n - p)² = z² p (1 - p)/n: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.
    `scipy.stats.binomtest` has it too, after an exact test that takes a millisecond.
    """
    if trials == 0:
        return math.nan, math.nan
    z, p = NormalDist().inv_cdf(0.975), successes / trials
    middle = p + z * z / (2 * trials)
    half = z * math.sqrt(p * (1 - p) / trials + (z / (2 * trials)) ** 2)
    low, high = ((middle + side * half) / (1 + z * z / trials) for side in (-1, 1))
    # The interval of no success begins at exactly 0, that of no failure ends at exactly 1; rounding
    # would miss these by an ulp.
    return (0.0 if successes == 0 else low), (1.0 if successes == trials else high)


def columns(row: Estimate | Integral) -> dict[str, float]:
    """Return the columns of a row of a table of P(e), in the order in which they are written."""
    held = asdict(row)
    first = {name: held[name] for name in ("e", "p", "low", "high") if name in held}
    return first | held


@dataclass(frozen=True)
class Curve:
    """P(e) = ½ [1 - erf((150 - C₁ e) / (√2 σ))], the paper's form (Sec. IV); C₁ and σ in m."""

    c1: float
    sigma: float

    def __call__(self, e: float) -> float:
        """Return P at a restitution."""
        return 0.5 * math.erfc((HOME_RUN_DISTANCE - self.c1 * e) / (math.sqrt(2) * self.sigma))


# Values of P(e) for a fit: two parameters, and one more value for their errors.
FEWEST = 3
PAPER_CURVES = {"caption": Curve(242.0, 52.2), "text": Curve(271.0, 59.8)}  # Fig. 7 and its text


@dataclass(frozen=True)
class Fit:
    """The paper's form fitted to estimates, with standard errors in m."""

    curve: Curve
    c1_error: float
    sigma_error: float


def fit(estimates: Sequence[Estimate]) -> Fit | None:
    """Fit C₁ and σ to estimates by least squares, each weighted by its Wilson interval.

    Returns None if the samples do not determine two parameters.

    The standard errors assume independent estimates. Estimates from the same samples are not: they
    vary together.
    """
    # Width of a 95 % interval, in standard deviations.
    wide = 2 * NormalDist().inv_cdf(0.975)
    return fit_form(
        [row.e for row in estimates],
        [row.p for row in estimates],
        [(row.high - row.low) / wide for row in estimates],
    )


def fit_form(
    restitutions: Sequence[float], p: Sequence[float], errors: Sequence[float] | None = None
) -> Fit | None:
    """Fit C₁ and σ to values of P(e) by least squares.

    `errors` are the standard errors of P. Without them all values have the same weight, and the
    scatter of the values about the form gives the errors of the fit.

    Returns None if there are fewer than `FEWEST` values, too few of them strictly between 0 and 1
    (fewer than two, or three without errors), or if they do not determine the two parameters.
    """
    from scipy.optimize import OptimizeWarning, curve_fit
    from scipy.special import erfc

    # At P = 0 or 1 the probit of the starting line is infinite, and a Wilson interval is one-sided.
    inner = [i for i, value in enumerate(p) if 0 < value < 1]
    if len(p) < FEWEST or len(inner) < (3 if errors is None else 2):
        return None

    def form(e: Array, slope: float, intercept: float) -> Array:
        return 0.5 * np.asarray(erfc((intercept - slope * e) / math.sqrt(2)))

    e, values = np.array(restitutions)[inner], np.array(p)[inner]
    # In a = C₁/σ and b = 150/σ the form is a probit line, a e - b, which gives the start.
    start = np.polyfit(e, [NormalDist().inv_cdf(value) for value in values], 1)
    with warnings.catch_warnings():
        # An infinite covariance is checked below.
        warnings.simplefilter("ignore", OptimizeWarning)
        (a, b), covariance = curve_fit(
            form,
            e,
            values,
            p0=(start[0], -start[1]),
            sigma=None if errors is None else np.array(errors)[inner],
            absolute_sigma=errors is not None,
        )
    return of_line(a, b, covariance) if np.isfinite(covariance).all() else None


def of_line(a: float, b: float, covariance: Array) -> Fit:
    """Return C₁ and σ of a probit line a e - b, with errors from the covariance of a and b."""
    # To first order: ∂C₁/∂(a, b) = (150/b, -C₁/b), ∂σ/∂b = -σ/b.
    sigma, c1 = HOME_RUN_DISTANCE / b, HOME_RUN_DISTANCE * a / b
    to_c1 = np.array([HOME_RUN_DISTANCE / b, -c1 / b])
    return Fit(
        Curve(float(c1), float(sigma)),
        float(np.sqrt(to_c1 @ covariance @ to_c1)),
        float(sigma / b * np.sqrt(covariance[1, 1])),
    )
