"""Sec. II as the paper did it: curves laid through histograms of speeds and of cells.

A curve is compared at the middle of a bin with the mean over the bin, which widens it: by
Sheppard's rule the fitted variance is too large by width²/12. Errors come from a bootstrap of the
counts, which are drawn again from the observed shares.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from longball.model.arrays import Array, Integers
from longball.pitches.chart import Pitches
from longball.pitches.fitted import AimFit, SpeedFit
from longball.pitches.fitting import (
    CELL_EDGES,
    EVERYTHING,
    FINE_EDGES,
    STARTS,
    Aim,
    aim_fit,
    count_cells,
    likeliest_aim,
    nearest_aim,
    normal,
    speed_fit,
)
from longball.pitches.table import SPEED_UNITS

# km/h: the bins of Fig. 2 are not printed. With 1,548 pitches of the paper's own mixture, bins of
# 3 to 6 km/h give the printed R² = 0.9942; bins of 1 km/h are too noisy.
BIN_WIDTH = 3.0

# The means of Fig. 3 as printed: the outer cells of the strike zone.
EDGES_OF_THE_ZONE = (2.0, 4.0)

# Of Eq. 2 as printed, which lacks the 2 of its exponent: the curve is that of a normal distribution
# with the standard deviation σ/√2.
INTEGRAL_AS_PRINTED = math.sqrt(0.5)


class Curves(NamedTuple):
    """Results of the paper's analysis of a table of pitches."""

    edges: Array  # m/s, of the bins
    counts: Integers  # of straight and breaking balls in each, shape (2, bins)
    speed: SpeedFit
    speed_as_printed: SpeedFit  # by Eq. 2 as printed, whose integral is 1/√2
    aim: AimFit
    aim_at_edges: AimFit  # with the means held at 2 and 4, as they are printed
    r_squared: dict[str, float | None]  # of each of the four, by its name


def curves(
    pitches: Pitches, bin_width: float = BIN_WIDTH, replicates: int = 200, seed: int = 0
) -> Curves:
    """Lay the curves through histograms of pitches; `bin_width` is in km/h."""
    bootstrap = partial(_bootstrap, replicates, np.random.default_rng(seed))
    edges = bins(pitches, bin_width)
    classes = (pitches.straight, ~pitches.straight)
    counts = np.stack([np.histogram(pitches.speed[chosen], edges)[0] for chosen in classes])
    start = [float(of(pitches.speed[chosen])) for chosen in classes for of in (np.mean, np.std)]
    cells = count_cells(pitches.across)
    # In this order, because all errors are drawn by one generator.
    laid: dict[str, Any] = {
        "speed": _speeds_through(1.0, edges, counts, start, bootstrap),
        "speed_as_printed": _speeds_through(INTEGRAL_AS_PRINTED, edges, counts, start, bootstrap),
        "aim": _aim_through(cells, None, bootstrap),
        "aim_at_edges": _aim_through(cells, EDGES_OF_THE_ZONE, bootstrap),
    }
    fits = {name: fit for name, (fit, _) in laid.items()}
    return Curves(edges, counts, **fits, r_squared={name: r for name, (_, r) in laid.items()})


def bins(pitches: Pitches, bin_width: float) -> Array:
    """Return edges of equal bins, m/s, between the speeds that the table can write."""
    speed, columns = pitches.speed, pitches.columns
    step = columns.speed_resolution * SPEED_UNITS[columns.speed_unit]
    width = bin_width / 3.6
    if step > 0.0:
        width = max(1, round(width / step)) * step
    # A speed that is written v is between v - step/2 and v + step/2, and bins end there too.
    first = math.floor((speed.min() - step / 2) / width)
    last = math.ceil((speed.max() - step / 2) / width)
    return (np.arange(first, last + 1) * width + step / 2).astype(np.float64)


def r_squared(observed: Array, fitted: Array) -> float | None:
    """Return the coefficient of determination, 1 - Σ(o - f)² / Σ(o - ō)²; None if all o agree."""
    if np.ptp(observed) == 0.0:
        return None
    spread = np.sum((observed - observed.mean()) ** 2)
    return float(1.0 - np.sum((observed - fitted) ** 2) / spread)


def gain_over_one_normal(pitches: Pitches) -> float:
    """Return twice the logarithm of how much likelier Eq. 4 is than a single normal curve."""
    edges = CELL_EDGES if pitches.columns.place_unit == "cell" else FINE_EDGES
    counts = np.histogram(pitches.across, edges)[0]
    _, cost = likeliest_aim(counts, edges, STARTS)
    one = [Aim(1.0, 3.0, 3.0, 1.2)], (False, True, False, True)
    return float(2.0 * counts.sum() * (likeliest_aim(counts, edges, *one)[1] - cost))


# From counts, and a function that fits them, to the standard errors of the fitted numbers.
Bootstrap = Callable[[Integers, Callable[[Integers], Sequence[float]]], list[float]]


def _bootstrap(
    replicates: int,
    generator: np.random.Generator,
    counts: Integers,
    fit: Callable[[Integers], Sequence[float]],
) -> list[float]:
    """Return the standard deviations of fits to counts drawn from the observed shares."""
    total = int(counts.sum())
    shares = counts.ravel() / total
    drawn = generator.multinomial(total, shares, size=replicates).reshape(-1, *counts.shape)
    spread: list[float] = np.std([fit(each) for each in drawn], axis=0, ddof=1).tolist()
    return spread


def _speeds_through(
    integral: float,
    edges: Array,
    counts: Integers,
    start: Sequence[float],
    bootstrap: Bootstrap,
) -> tuple[SpeedFit, float | None]:
    """Lay Eqs. 2 and 3 through the histograms; also return R² of the one of all pitches."""
    v, width = (edges[1:] + edges[:-1]) / 2.0, float(edges[1] - edges[0])

    def mixed(counts: Integers, start: Sequence[float]) -> tuple[list[float], Array, Array]:
        found: list[float] = []
        for i, count in zip((0, 2), counts, strict=True):
            found += normal_through(v, count / (count.sum() * width), start[i : i + 2], integral)
        straight, breaking = (normal(v, found[i], found[i + 1], integral) for i in (0, 2))
        everything = counts.sum(axis=0) / (counts.sum() * width)
        # The sum of squares is a parabola in p: within [0, 1] it is least where clipping puts it.
        apart = straight - breaking
        weight = float(np.clip((everything - breaking) @ apart / (apart @ apart), 0.0, 1.0))
        return [*found, weight], everything, weight * straight + (1.0 - weight) * breaking

    found, everything, fitted = mixed(counts, start)
    errors = bootstrap(counts, lambda drawn: mixed(drawn, found)[0])
    return speed_fit(found, errors), r_squared(everything, fitted)


def normal_through(
    v: Array, density: Array, start: Sequence[float], integral: float
) -> tuple[float, float]:
    """Return mean and standard deviation of the curve nearest to a density, from a first guess."""

    def off(theta: Array) -> Array:
        return normal(v, theta[0], theta[1], integral) - density

    mean, deviation = least_squares(off, start, method="lm", x_scale=(start[1], start[1])).x
    return float(mean), abs(float(deviation))


def _aim_through(
    counts: Integers, means: tuple[float, float] | None, bootstrap: Bootstrap
) -> tuple[AimFit, float | None]:
    """Lay the density of Eq. 4, at each cell's number, through their shares; also return R²."""
    y = np.arange(1.0, 6.0)
    starts = STARTS if means is None else (Aim(0.5, *means, 0.8),)
    free = EVERYTHING if means is None else (True, False, False, True)

    def fit(drawn: Integers, starts: Sequence[Aim]) -> Aim:
        shares = drawn / drawn.sum()
        return nearest_aim(lambda *aim: Aim(*aim).density(y) - shares, starts, free)[0]

    found = fit(counts, starts)
    errors = bootstrap(counts, lambda drawn: fit(drawn, [found]))
    return aim_fit(found, errors, counts), r_squared(counts / counts.sum(), found.density(y))
