"""Order of convergence of a family of steps, from steps and errors.

An error C h^p is a straight line of slope p in log h and log e, but only in the asymptotic range:
above it higher terms bend the line, and below it rounding dominates. The range is searched, not
assumed, and the ratio of the steps need not be constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from longball.model.arrays import Array

FEWEST = 5  # two parameters, and three more steps to distinguish a line from a curve
NARROWEST = 4.0  # in a range narrower than this factor in h, any smooth curve looks straight
# Half width of an interval that is good enough: a fifth of the tolerance of orders, 0.1. A range
# that is curved at an end moves the slope by about as much as it widens the interval. Of all such
# ranges the finest is nearest to the limit h -> 0.
GOOD_ENOUGH = 0.02
FLAT = 0.2  # order of errors that do not fall: rounding, or a wrong limit
HARMLESS = 0.05  # change of the slope by curvature: half the tolerance of orders
# Order of errors that fall: below the order of any scheme, above a floor with its noise.
FALLING = 0.5


@dataclass(frozen=True)
class PowerLaw:
    """An error C h^p, over a range of steps."""

    # p, and its 95 % interval from the scatter about the line.
    order: float
    low: float
    high: float
    constant: float  # C, in the error's unit over s^p
    # Indices of the first and the last step of the range, inclusive.
    first: int
    last: int

    @property
    def half_width(self) -> float:
        """Half the interval's width."""
        return (self.high - self.low) / 2

    def error(self, step: float) -> float:
        """Return C h^p."""
        return float(self.constant * step**self.order)


def fit_line(steps: Array, errors: Array, first: int, last: int) -> PowerLaw:
    """Fit a power law to a range of steps by least squares of log e on log h."""
    # log e = log C + p log h
    x, y = np.log(steps[first : last + 1]), np.log(errors[first : last + 1])
    centred = x - x.mean()
    order = float(centred @ y / (centred @ centred))
    at_zero = float(y.mean() - order * x.mean())
    residuals = y - at_zero - order * x
    free = len(x) - 2
    deviation = math.sqrt(residuals @ residuals / free / (centred @ centred))
    half = float(stdtrit(free, 0.975)) * deviation
    return PowerLaw(order, order - half, order + half, math.exp(at_zero), first, last)


def fit_power_law(steps: Array, errors: Array) -> PowerLaw | None:
    """Find the asymptotic range of descending steps, s, and fit it; None if there is no such range.

    A candidate range has at least `FEWEST` steps and a ratio of `NARROWEST`; its errors fall along
    a straight line, and do not continue to fall below it. Ranges with a narrow interval are kept,
    up to `GOOD_ENOUGH` or 1.5 times the narrowest. The result is the range with the finest step
    among these, or the longest of several. NaN means no error at that step.
    """
    there = np.flatnonzero(np.isfinite(errors) & (errors > 0))
    h, e = steps[there], errors[there]
    ends = ((a, b) for a in range(len(there)) for b in range(a + FEWEST - 1, len(there)))
    wide = (fit_line(h, e, a, b) for a, b in ends if h[a] >= NARROWEST * h[b])
    laws = [
        law for law in wide if law.order - FLAT > 0 and law.half_width < law.order
        and not _is_bent(h[law.first : law.last + 1], e[law.first : law.last + 1])
        and not _falls_on(h[law.last + 1 :], e[law.last + 1 :])
    ]  # fmt: skip
    if not laws:
        return None
    allowed = max(GOOD_ENOUGH, 1.5 * min(law.half_width for law in laws))  # a free choice
    best = max(
        (law for law in laws if law.half_width <= allowed), key=lambda law: (law.last, -law.first)
    )
    return replace(best, first=int(there[best.first]), last=int(there[best.last]))


def _is_bent(steps: Array, errors: Array) -> bool:
    """True if the slope of a parabola at the finest step differs from that of the line."""
    # The difference must exceed `HARMLESS` and the scatter, at 95 %.
    x, y = np.log(steps), np.log(errors)
    x = x - x.mean()
    turn = float(x @ x**2 / (x @ x))
    parabola = x**2 - turn * x - (x @ x) / len(x)  # orthogonal to the line
    size = parabola @ parabola
    curvature = float(parabola @ y / size)
    rest = y - np.polynomial.Polynomial.fit(x, y, 2)(x)
    free = len(x) - 3
    scatter = math.sqrt(rest @ rest / free / size) * float(stdtrit(free, 0.975))
    steeper = abs(2 * x[-1] - turn)
    return abs(curvature) * steeper > HARMLESS and abs(curvature) > scatter


def _falls_on(steps: Array, errors: Array) -> bool:
    """True if the errors below a range still fall, so that a finer range must exist.

    The criterion is the median of the slopes between all pairs (Theil and Sen), which ignores
    single outliers. Fewer than `FEWEST` steps are not tested: a floor may happen to fall over three
    or four.
    """
    if len(steps) < FEWEST:
        return False
    x, y = np.log(steps), np.log(errors)
    slopes = [(y[i] - y[j]) / (x[i] - x[j]) for i in range(len(x)) for j in range(i)]
    return float(np.median(slopes)) > FALLING


def typical(errors: Array) -> Array:
    """Return one error for each step from those of several scenes: (scene, step) -> (step,).

    Scenes have errors of different sizes, and may lack some steps, so that a mean would jump from
    step to step. Tukey's median polish of log e separates scene and step; a scene whose error
    happens to change sign near a step does not affect the median. NaN means no error.

    J. W. Tukey, Exploratory Data Analysis (1977), Ch. 11.
    """
    logs = np.log(np.where(errors > 0, errors, np.nan))
    rows = np.isfinite(logs).any(axis=1)
    columns = np.isfinite(logs).any(axis=0)
    if not rows.any():
        return np.full(errors.shape[1], np.nan)
    rest = logs[np.ix_(rows, columns)]
    scene, step = np.zeros(rest.shape[0]), np.zeros(rest.shape[1])
    for _ in range(100):
        by_scene = np.nanmedian(rest, axis=1)
        scene, rest = scene + by_scene, rest - by_scene[:, None]
        by_step = np.nanmedian(rest, axis=0)
        step, rest = step + by_step, rest - by_step
        if max(np.abs(by_scene).max(), np.abs(by_step).max()) < 1e-6:  # a free choice
            break
    result = np.full(errors.shape[1], np.nan)
    result[columns] = np.exp(step + np.median(scene))
    return result


def errors_without_truth(steps: Array, values: Array, order: float, ratio: float) -> Array:
    """Return |q(h) - q(0)| from the differences between steps.

    If q(h) = q(0) + C h^p, then q(h_k) - q(h_l) = C h_k^p (1 - (h_l/h_k)^p). Steps, s, descend;
    values have the shape (step, component), with NaN for missing ones. An estimate of the order p
    is enough: with a constant ratio of the steps its error cancels in the slope, otherwise
    repetition improves it. Each step is compared with the next one that is finer by more than
    `ratio`, because noise is amplified by (1 + (h_l/h_k)^p) / (1 - (h_l/h_k)^p). The result is NaN
    without a finer step.
    """
    errors = np.full(len(steps), np.nan)
    there = np.flatnonzero(np.isfinite(values).all(axis=1))
    for coarse in there:
        finer = there[steps[there] * ratio < steps[coarse]]
        if len(finer):
            difference = float(np.linalg.norm(values[coarse] - values[finer[0]]))
            errors[coarse] = difference / (1 - (steps[finer[0]] / steps[coarse]) ** order)
    return errors


def richardson(steps: Array, values: Array, order: float) -> tuple[Array, float] | None:
    """Extrapolate to h = 0 from the two finest steps, descending, at a known order."""
    # The error estimate is the distance to the same from the two steps before. None with fewer than
    # three steps.
    there = np.flatnonzero(np.isfinite(values).all(axis=1))
    if len(there) < 3:
        return None

    # q(h) = q(0) + C h^p at two steps, solved for q(0)
    def limit(coarse: int, fine: int) -> Array:
        ratio = (steps[coarse] / steps[fine]) ** order
        extrapolated: Array = values[fine] + (values[fine] - values[coarse]) / (ratio - 1)
        return extrapolated

    value = limit(there[-2], there[-1])
    return value, float(np.linalg.norm(value - limit(there[-3], there[-2])))
