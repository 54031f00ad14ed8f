"""The order of convergence that a family of steps shows: numbers in, numbers out.

An error C h^p is a straight line of slope p in log h and log e, but only in the asymptotic range:
above it higher terms bend the line, below it rounding takes over. The range is looked for and not
assumed, and neither is a constant ratio of the steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from longball.model.arrays import Array

FEWEST = 5  # two parameters, and three steps more to tell a line from a bend
NARROWEST = 4.0  # a range narrower than this factor in h would call any smooth curve a line
# Orders are held to 0.1; a range that is bent at an end moves the slope by about as much as it
# widens the interval, so that a fifth of that is good enough, and the finest of such ranges is
# nearest to the limit h -> 0.
GOOD_ENOUGH = 0.02
FLAT = 0.2  # the errors do not fall: a floor, of rounding or of a limit that is not the truth
HARMLESS = 0.05  # half of what orders are held to
# The errors fall: less than the lowest order of any scheme, more than a floor with its noise.
FALLING = 0.5


@dataclass(frozen=True)
class PowerLaw:
    """An error C h^p, over a range of steps."""

    # p, and its interval of 95 % from the scatter about the line.
    order: float
    low: float
    high: float
    constant: float  # C, in the error's unit over s^p
    # Indices of the steps at the ends of the range, both inside it.
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

    Of all ranges of at least `FEWEST` steps and a factor `NARROWEST` in which errors fall along a
    line that is not bent, and below which they do not fall on, those are kept whose interval is
    narrow: within `GOOD_ENOUGH`, or within one and a half times the narrowest. Of these the one
    with the finest step wins, and the longest if there are several. An error of NaN is none.
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
    allowed = max(GOOD_ENOUGH, 1.5 * min(law.half_width for law in laws))
    best = max(
        (law for law in laws if law.half_width <= allowed), key=lambda law: (law.last, -law.first)
    )
    return replace(best, first=int(there[best.first]), last=int(there[best.last]))


def _is_bent(steps: Array, errors: Array) -> bool:
    """True if a parabola has another slope at the finest step than the line."""
    # By more than `HARMLESS`, and by more than scatter explains in 19 of 20 cases.
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
    """True if the errors of the steps below a range still fall, so that it is not the last.

    By the median of all slopes between two of them, which a stray error does not move. Fewer steps
    than a range needs are none: a floor may happen to fall over three or four.
    """
    if len(steps) < FEWEST:
        return False
    x, y = np.log(steps), np.log(errors)
    slopes = [(y[i] - y[j]) / (x[i] - x[j]) for i in range(len(x)) for j in range(i)]
    return float(np.median(slopes)) > FALLING


def typical(errors: Array) -> Array:
    """Return one error a step from those of several scenes: (scene, step) -> (step,).

    Scenes differ in size and some lack some steps, so that a mean over those at hand would jump
    from step to step. Tukey's median polish of log e separates scene and step; the median is not
    moved by a scene whose error happens to change its sign near a step. NaN: no error there.

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
        if max(np.abs(by_scene).max(), np.abs(by_step).max()) < 1e-6:
            break
    result = np.full(errors.shape[1], np.nan)
    result[columns] = np.exp(step + np.median(scene))
    return result


def errors_without_truth(steps: Array, values: Array, order: float, ratio: float = 1.0) -> Array:
    """Return |q(h) - q(0)| as the differences from finer steps tell it.

    If q(h) = q(0) + C h^p, then q(h_k) - q(h_l) = C h_k^p (1 - (h_l/h_k)^p). Steps, s, descend;
    values are (step, component), NaN where there is none. A guess of the order p is exact for a
    constant ratio of the steps, and improved by repeating. A step is held against the next one that
    is finer by more than `ratio`: noise counts (1 + (h_l/h_k)^p) / (1 - (h_l/h_k)^p) times. NaN is
    returned for steps that have no finer one.
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
    # The error is the distance to what the two before give. None with fewer than three steps.
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
