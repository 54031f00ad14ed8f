"""The paper's Sec. II: normal curves for the speeds, a mixture across the plate, shares in height.

Everything is fitted twice. *Least squares* lays a curve through a histogram, as the paper did and
with what that brings: the curve is compared at the middle of a bin with the mean over the bin,
which widens it (by Sheppard's rule the fitted variance is too large by width²/12). *Maximum
likelihood* asks for the distribution under which the pitches are most probable, and has no such
bias; its errors come from Fisher's information. The errors of least squares come from a bootstrap:
the counts are drawn again from the observed shares, and fitted again.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO, cast

import numpy as np

from longball.model.arrays import Array, Flags, Integers
from longball.pitches.chart import Columns, Pitches, PitchTypes, cell, read_pitches
from longball.pitches.fitted import (
    PEAK_GAIN,
    AimFit,
    Aims,
    Estimate,
    FittedPitches,
    Five,
    Heights,
    Method,
    SpeedFit,
    SpeedHistogram,
    Speeds,
    Status,
)
from longball.pitches.table import SPEED_UNITS, TableError

if TYPE_CHECKING:
    import pandas as pd

Errors = Sequence[float | None]
# From counts, and how they are fitted, to the errors of what is fitted.
Bootstrap = Callable[[Integers, Callable[[Integers], tuple[float, ...]]], tuple[float, ...]]

# Relative error of a standard error from so many replicates: 1/√(2 · 200) = 5 %.
REPLICATES = 200

# km/h: the bins of Fig. 2 are not printed. With 1,548 pitches of the paper's own mixture, bins of
# 3 to 6 km/h give the printed R² = 0.9942; bins of 1 km/h are too noisy: see
# analysis/paper/pitch_fits.py.
BIN_WIDTH = 3.0

# Five numbers are fitted to the histogram; and more bins than this hold next to nothing each.
FEWEST_BINS, MOST_BINS = 5, 1000

# The standard errors here are asymptotic: they need samples of at least this size.
FEWEST_PITCHES = 20

# The grid of Fig. 1 across the plate: boundaries of the five cells, the outer ones open.
CELL_EDGES = np.array([-np.inf, 1.5, 2.5, 3.5, 4.5, np.inf])

# Where a table gives places and not cells, they are counted in tenths of a cell, 14 mm: a fit does
# not see so fine a step, and its cost does not grow with the table.
FINE_EDGES = np.concatenate([[-np.inf], np.linspace(-3.0, 9.0, 121), [np.inf]])

# The means of Fig. 3 as printed: the outer cells of the strike zone.
EDGES_OF_THE_ZONE = (2.0, 4.0)


def fit_pitches(
    table: str | Path | TextIO | pd.DataFrame,
    columns: Columns | None = None,
    types: PitchTypes | None = None,
    *,
    bin_width: float = BIN_WIDTH,
    draw_from: Method = "maximum_likelihood",
    replicates: int = REPLICATES,
    seed: int = 0,
) -> FittedPitches:
    """Analyse a table of pitches as the paper does.

    Parameters
    ----------
    table, columns, types
        As `longball.pitches.read_pitches` takes them.
    bin_width
        km/h, of the histogram of speeds; rounded to a whole number of the steps in which the
        table writes its speeds, so that every bin holds equally many of them.
    draw_from
        Whose distributions are to be drawn from.
    replicates, seed
        Of the bootstrap behind the errors of least squares.

    Raises
    ------
    TableError
        If the table cannot be used, a class has too few pitches or all of one speed, or the
        bins are too few or too many.
    """
    types = types or PitchTypes()
    pitches = read_pitches(table, columns, types)
    _enough(pitches)
    if replicates < 2:
        raise TableError(f"replicates = {replicates}: a bootstrap takes at least 2")
    bootstrap = partial(_bootstrap, replicates, np.random.default_rng(seed))
    straight, breaking = (
        dict(Counter(np.array(pitches.types)[chosen].tolist()).most_common())
        for chosen in (pitches.straight, ~pitches.straight)
    )
    return FittedPitches(
        source=pitches.source,
        columns=pitches.columns,
        types=types,
        rows_read=pitches.rows_read,
        rows_used=len(pitches.types),
        left_out=pitches.left_out,
        straight=straight,
        breaking=breaking,
        speed=_fit_speeds(pitches, bin_width, bootstrap),
        aim=_fit_aims(pitches, bootstrap),
        height=None if pitches.height is None else _describe_heights(_count_cells(pitches.height)),
        bootstrap_replicates=replicates,
        bootstrap_seed=seed,
        draw_from=draw_from,
    )


def r_squared(observed: Array, fitted: Array) -> float | None:
    """Return the coefficient of determination, 1 - Σ(o - f)² / Σ(o - ō)²; None if all o agree."""
    if np.ptp(observed) == 0.0:
        return None
    spread = np.sum((observed - observed.mean()) ** 2)
    return float(1.0 - np.sum((observed - fitted) ** 2) / spread)


def _enough(pitches: Pitches) -> None:
    for name, chosen in (("straight", pitches.straight), ("breaking", ~pitches.straight)):
        speeds = pitches.speed[chosen]
        if len(speeds) < FEWEST_PITCHES:
            raise TableError(
                f"{pitches.columns.pitch_type}: only {len(speeds)} {name} balls; a fit with its "
                f"errors needs at least {FEWEST_PITCHES}"
            )
        if np.ptp(speeds) == 0.0 or speeds.var() <= _variance_of_rounding(pitches.columns):
            raise TableError(
                f"{pitches.columns.speed}: the {len(speeds)} {name} balls differ no more than by "
                "the step in which their speeds are written, which no normal curve describes"
            )


# --- speeds: Fig. 2, Table II ---------------------------------------------------------------------


# Of Eq. 2 as printed, which lacks the 2 of its exponent: the curve is that of a normal distribution
# with the standard deviation σ/√2.
INTEGRAL_AS_PRINTED = math.sqrt(0.5)


def normal(v: Array, mean: float, deviation: float, integral: float = 1.0) -> Array:
    """Return the density of a normal distribution, scaled to an integral."""
    z = (v - mean) / deviation
    return integral * np.exp(-z * z / 2.0) / (math.sqrt(2.0 * math.pi) * deviation)


def _normal_through(
    v: Array, density: Array, start: Sequence[float], integral: float
) -> tuple[float, float]:
    """Return mean and standard deviation of the curve nearest to a density, from a first guess."""
    from scipy.optimize import least_squares

    def off(theta: Array) -> Array:
        return normal(v, theta[0], theta[1], integral) - density

    mean, deviation = least_squares(off, start, method="lm", x_scale=(start[1], start[1])).x
    return float(mean), abs(float(deviation))


def _fit_speeds(pitches: Pitches, bin_width: float, bootstrap: Bootstrap) -> Speeds:
    edges = _bins(pitches.speed, bin_width, pitches.columns)
    classes = (pitches.straight, ~pitches.straight)
    counts = np.stack([np.histogram(pitches.speed[chosen], edges)[0] for chosen in classes])
    by_likelihood = _likeliest_speeds(pitches, edges, counts)
    start = tuple(getattr(by_likelihood, name).value for name in _NAMES)
    return Speeds(
        histogram=SpeedHistogram(
            edges=tuple(edges.tolist()),
            straight=tuple(counts[0].tolist()),
            breaking=tuple(counts[1].tolist()),
        ),
        maximum_likelihood=by_likelihood,
        least_squares=_speeds_through(1.0, edges, counts, start, bootstrap),
        least_squares_as_printed=_speeds_through(
            INTEGRAL_AS_PRINTED, edges, counts, start, bootstrap
        ),
    )


def _bins(speed: Array, bin_width: float, columns: Columns) -> Array:
    """Return edges of equal bins, m/s, between the speeds that the table can write."""
    unit = SPEED_UNITS[columns.speed_unit]
    step = columns.speed_resolution * unit
    width = bin_width / 3.6
    if not width > 0.0:
        raise TableError(f"bin_width = {bin_width:g} km/h: a bin has a positive width")
    if step > 0.0:
        width = max(1, round(width / step)) * step
    # A speed that is written v is between v - step/2 and v + step/2, and bins end there too.
    first = math.floor((speed.min() - step / 2) / width)
    last = math.ceil((speed.max() - step / 2) / width)
    if not FEWEST_BINS <= last - first <= MOST_BINS:
        raise TableError(
            f"bin_width = {bin_width:g} km/h puts these speeds into {last - first} bins; "
            f"it takes {FEWEST_BINS} to {MOST_BINS} of them"
        )
    return (np.arange(first, last + 1) * width + step / 2).astype(np.float64)


def _likeliest_speeds(pitches: Pitches, edges: Array, counts: Integers) -> SpeedFit:
    total = len(pitches.speed)
    share = float(np.mean(pitches.straight))
    rounding = _variance_of_rounding(pitches.columns)
    classes = (pitches.straight, ~pitches.straight)
    one, two = (_likeliest_normal(pitches.speed[chosen], rounding) for chosen in classes)
    weight = Estimate(value=share, standard_error=math.sqrt(share * (1.0 - share) / total))
    return _speed_fit(1.0, edges, counts, (*one, *two, weight))


def _variance_of_rounding(columns: Columns) -> float:
    """Return the variance that rounded speeds gain, m²/s² (Sheppard)."""
    return (columns.speed_resolution * SPEED_UNITS[columns.speed_unit]) ** 2 / 12.0


def _likeliest_normal(speed: Array, rounding: float) -> tuple[Estimate, Estimate]:
    """Return mean and standard deviation, with errors that hold for other shapes too.

    The variance that `rounding` has added is taken off.
    For normal data the fourth moment is 3, and the error of the standard deviation Fisher's
    s/√(2n); with heavier tails it is larger (Huber's sandwich of Fisher's information).
    """
    mean, spread = float(speed.mean()), math.sqrt(speed.var() - rounding)
    fourth_moment = float(np.mean(((speed - mean) / spread) ** 4))
    of_spread = spread * math.sqrt((fourth_moment - 1.0) / (4.0 * len(speed)))
    return (
        Estimate(value=mean, standard_error=spread / math.sqrt(len(speed))),
        Estimate(value=spread, standard_error=of_spread),
    )


SpeedValues = tuple[float, ...]  # means and spreads of straight and breaking balls, and p
_NAMES = ("straight_mean", "straight_spread", "breaking_mean", "breaking_spread", "weight")


def _speed_fit(
    integral: float, edges: Array, counts: Integers, estimates: Sequence[Estimate]
) -> SpeedFit:
    """Return estimates, in the order of `SpeedValues`, with the R² of their mixture."""
    mean_1, spread_1, mean_2, spread_2, p = (estimate.value for estimate in estimates)
    v, width = _middles(edges)
    straight, breaking = (
        normal(v, mean_1, spread_1, integral),
        normal(v, mean_2, spread_2, integral),
    )
    everything = counts.sum(axis=0) / (counts.sum() * width)
    fitted = r_squared(everything, p * straight + (1.0 - p) * breaking)
    return SpeedFit(**dict(zip(_NAMES, estimates, strict=True)), r_squared=fitted)


def _speeds_through(
    integral: float, edges: Array, counts: Integers, start: SpeedValues, bootstrap: Bootstrap
) -> SpeedFit:
    """Lay Eqs. 2 and 3 through the histograms of the classes, and of all pitches."""
    fitted = _least_squares_speeds(integral, edges, counts, start)
    errors = bootstrap(counts, lambda drawn: _least_squares_speeds(integral, edges, drawn, fitted))
    statuses: list[Status] = ["fitted"] * 4
    statuses.append("at_bound" if fitted[-1] in (0.0, 1.0) else "fitted")
    estimates = _estimates(fitted, errors, statuses)
    return _speed_fit(integral, edges, counts, estimates)


def _least_squares_speeds(
    integral: float, edges: Array, counts: Integers, start: SpeedValues
) -> SpeedValues:
    v, width = _middles(edges)
    one, two = (
        _normal_through(v, count / (count.sum() * width), start[i : i + 2], integral)
        for i, count in zip((0, 2), counts, strict=True)
    )
    straight, breaking = (normal(v, *each, integral=integral) for each in (one, two))
    everything = counts.sum(axis=0) / (counts.sum() * width)
    # The sum of squares is a parabola in p: within [0, 1] it is least where clipping puts it.
    apart = straight - breaking
    weight = float(np.clip((everything - breaking) @ apart / (apart @ apart), 0.0, 1.0))
    return (*one, *two, weight)


def _middles(edges: Array) -> tuple[Array, float]:
    return (edges[1:] + edges[:-1]) / 2.0, float(edges[1] - edges[0])


# --- across the plate: Fig. 3 ---------------------------------------------------------------------


def _fit_aims(pitches: Pitches, bootstrap: Bootstrap) -> Aims:
    cells = _count_cells(pitches.across)
    edges = CELL_EDGES if pitches.columns.place_unit == "cell" else FINE_EDGES
    counts = np.histogram(pitches.across, edges)[0]
    likeliest, over_one_normal, over_one_peak = _likeliest_aim(counts, edges)
    errors = _fisher_errors(likeliest, edges, len(pitches.across))
    cost_of_two = 2.0 * math.log(len(pitches.across))  # parameters, by Schwarz's criterion
    return Aims(
        cells=cast(Five[int], tuple(cells.tolist())),
        maximum_likelihood=_aim_fit(likeliest, errors, cells, likeliest.shares(CELL_EDGES)),
        gain_over_one_normal=over_one_normal,
        gain_over_one_peak=over_one_peak,
        two_peaks_supported=over_one_normal > cost_of_two and over_one_peak > PEAK_GAIN,
        least_squares=_aim_through(cells, None, bootstrap),
        least_squares_at_edges=_aim_through(cells, EDGES_OF_THE_ZONE, bootstrap),
    )


class _Aim(NamedTuple):
    """Parameters of Eq. 4: q, the two means and their common spread, in cells."""

    weight: float
    left: float
    right: float
    spread: float

    def density(self, y: Array) -> Array:
        left, right = (normal(y, mean, self.spread) for mean in self[1:3])
        return self.weight * left + (1.0 - self.weight) * right

    def shares(self, edges: Array) -> Array:
        """Return the integral of the density over each cell."""
        from scipy.special import ndtr

        left, right = (np.diff(ndtr((edges - mean) / self.spread)) for mean in self[1:3])
        mixed: Array = self.weight * left + (1.0 - self.weight) * right
        return mixed

    def sorted(self) -> _Aim:
        if self.left <= self.right:
            return self
        return _Aim(1.0 - self.weight, self.right, self.left, self.spread)

    def peaks(self) -> int:
        """Count the maxima of the density, which lie between the means."""
        y = np.linspace(self.left - self.spread, self.right + self.spread, 2001)
        rises = np.diff(self.density(y)) > 0.0
        return int(np.sum(rises[:-1] & ~rises[1:]))


# Where the search for Eq. 4 may go. The means lie in the grid: what is aimed at is on the chart.
# The spread, in cells: narrower or wider, five cells see no difference.
_RANGE = _Aim(0.0, 0.5, 0.5, 0.05), _Aim(1.0, 5.5, 5.5, 5.0)
# Where it begins: two peaks at the edges of the strike zone; two broad ones; one beside the other.
_STARTS = (_Aim(0.5, 2.0, 4.0, 0.8), _Aim(0.5, 1.5, 4.5, 1.3), _Aim(0.8, 3.0, 4.5, 1.2))
_ONE_NORMAL = _Aim(1.0, 3.0, 3.0, 1.2)

# What of Eq. 4 is searched for: all of it; q and the spread; a mean and the spread.
_EVERYTHING = (True, True, True, True)
_MEANS_HELD = (True, False, False, True)
_LEFT_ALONE = (False, True, False, True)


class _OnePeak(NamedTuple):
    """A density of Eq. 4 that is about to have a second maximum, on the side of its lesser part.

    With the means 2dσ apart, d >= 1, there is one maximum if the odds of the two parts are at least
    (d - √(d² - 1))² exp(2d√(d² - 1)) (Robertson and Fryer, Skand. Aktuarietidskr. 52, 137 (1969)).
    """

    main: float  # mean of the greater part, cells
    half: float  # d
    spread: float

    def aim(self, side: int) -> _Aim:
        root = math.sqrt(self.half**2 - 1.0)
        log_odds = 2.0 * (self.half * root - math.asinh(root))
        weight = 1.0 / (1.0 + math.exp(-log_odds))
        apart = 2.0 * self.half * self.spread
        return _Aim(weight, self.main, self.main + side * apart, self.spread)


_RANGE_OF_ONE = _OnePeak(0.5, 1.0, 0.05), _OnePeak(5.5, 5.0, 5.0)
_STARTS_OF_ONE = _OnePeak(3.0, 1.05, 1.0), _OnePeak(3.0, 1.6, 1.0)  # even, and uneven


def _likeliest_aim(counts: Integers, edges: Array) -> tuple[_Aim, float, float]:
    """Fit Eq. 4 to counts in cells with these boundaries.

    Also return twice the logarithm of how much likelier it is than the likeliest normal
    distribution, and than the likeliest mixture with one maximum.
    """
    total = int(counts.sum())
    shares = counts / total

    def deviance_residuals(*aim: float) -> Array:
        # Far from every pitch a share underflows; there its logarithm only has to be very low.
        expected = np.maximum(_Aim(*aim).shares(edges), 1e-300)
        log_ratio = np.log(np.where(counts > 0, shares, 1.0) / expected) * (counts > 0)
        deviance = 2.0 * (shares * log_ratio - shares + expected)
        # Rounding can leave less than zero where a cell is met exactly.
        residuals: Array = np.sign(shares - expected) * np.sqrt(np.maximum(deviance, 0.0))
        return residuals

    def cost_beside(side: int) -> float:
        """Return the cost of the best on the boundary between one peak and two, on a side."""
        return _nearest(
            lambda *one: deviance_residuals(*_OnePeak(*one).aim(side)),
            _STARTS_OF_ONE,
            _RANGE_OF_ONE,
            (True, True, True),
        )[1]

    theta, cost = _nearest(deviance_residuals, _STARTS, _RANGE)
    _, cost_of_normal = _nearest(deviance_residuals, [_ONE_NORMAL], _RANGE, _LEFT_ALONE)
    found, cost_of_peak = _Aim(*theta).sorted(), cost
    if found.peaks() == 2:
        # Of densities with one peak the likeliest is then one that is about to have a second.
        cost_of_peak = min(cost_of_normal, cost_beside(-1), cost_beside(1))
    return found, 2.0 * total * (cost_of_normal - cost), 2.0 * total * (cost_of_peak - cost)


def _fisher_errors(aim: _Aim, edges: Array, total: int) -> Errors:
    """Return the errors by Fisher's information n Σ (∂P_j)(∂P_j)ᵀ / P_j.

    The derivatives are central differences; their error, 1e-10 or so, is far below any use of an
    error bar.
    """
    step = 1e-5
    theta, free = np.array(aim), _within(aim)
    slopes = np.stack(
        [
            (_Aim(*(theta + move)).shares(edges) - _Aim(*(theta - move)).shares(edges)) / (2 * step)
            for move in step * np.eye(4)[free]
        ]
    )
    information = (slopes / np.maximum(aim.shares(edges), 1e-300)) @ slopes.T * total
    # Singular to 8 digits: the differences cannot tell such a matrix from a singular one.
    if not np.linalg.cond(information) < 1e8:
        return [None] * 4
    errors = iter(np.sqrt(np.diag(np.linalg.inv(information))).tolist())
    return [next(errors) if determined else None for determined in free]


def _within(aim: _Aim) -> Flags:
    """Tell which parameters ended inside the range of the search, not at its end."""
    theta, low, high = np.array([aim, *_RANGE])
    # The search stays inside; that near to an end it would have gone on.
    near = 1e-4 * (high - low)
    inside: Flags = (theta > low + near) & (theta < high - near)
    return inside


def _aim_through(
    counts: Integers, means: tuple[float, float] | None, bootstrap: Bootstrap
) -> AimFit:
    """Lay the density of Eq. 4, at the number of each cell, through the cells' shares."""
    y = np.arange(1.0, 6.0)
    starts = _STARTS if means is None else (_Aim(0.5, *means, 0.8),)
    free = _EVERYTHING if means is None else _MEANS_HELD

    def fit(drawn: Integers, starts: tuple[_Aim, ...]) -> _Aim:
        shares = drawn / drawn.sum()
        theta, _ = _nearest(lambda *aim: _Aim(*aim).density(y) - shares, starts, _RANGE, free)
        return _Aim(*theta).sorted()

    found = fit(counts, starts)
    errors = bootstrap(counts, lambda drawn: fit(drawn, (found,)))
    return _aim_fit(found, errors, counts, found.density(y), free)


def _nearest(
    residuals: Callable[..., Array],
    starts: Sequence[Sequence[float]],
    bounds: tuple[Sequence[float], Sequence[float]],
    free: Sequence[bool] = _EVERYTHING,
) -> tuple[list[float], float]:
    """Return the parameters with the least sum of squares, and half that sum.

    Only the `free` ones move from where they start, within their bounds.
    """
    from scipy.optimize import least_squares

    moving = np.array(free)
    low, high = np.array(bounds)[:, moving]

    def search(start: Sequence[float]) -> tuple[list[float], float]:
        theta = np.array(start)

        def residuals_of_part(part: Array) -> Array:
            theta[moving] = part
            return residuals(*theta.tolist())

        found = least_squares(
            residuals_of_part,
            # It wants to start inside; a thousandth is far from any end that it may seek.
            np.clip(theta[moving], low + 1e-3, high - 1e-3),
            bounds=(low, high),
            # A step or a gain this small is far below every error bar.
            xtol=1e-10,
            ftol=1e-12,
            gtol=1e-12,
        )
        theta[moving] = found.x
        return theta.tolist(), float(found.cost)

    return min(map(search, starts), key=lambda end: end[1])


def _aim_fit(
    aim: _Aim, errors: Errors, counts: Integers, fitted: Array, free: tuple[bool, ...] = _EVERYTHING
) -> AimFit:
    statuses: list[Status] = [
        "held" if not moved else "fitted" if inside else "at_bound"
        for moved, inside in zip(free, _within(aim), strict=True)
    ]
    weight, left, right, spread = _estimates(aim, errors, statuses)
    return AimFit(
        left_mean=left,
        right_mean=right,
        spread=spread,
        weight=weight,
        peaks=aim.peaks(),
        r_squared=r_squared(counts / counts.sum(), fitted),
    )


# --- height: Fig. 4 -------------------------------------------------------------------------------


def _describe_heights(counts: Integers) -> Heights:
    """Return the shares of the five cells, and whether the lower four of them are equal."""
    from scipy.stats import chisquare

    total = int(counts.sum())
    # An empty cell has no error of this kind: √0 would say that it is empty for certain.
    shares = [
        Estimate(value=share, standard_error=math.sqrt(share * (1.0 - share) / total) or None)
        for share in (counts / total).tolist()
    ]
    lower_four = chisquare(counts[:4])
    return Heights(
        cells=cast(Five[int], tuple(counts.tolist())),
        shares=cast(Five[Estimate], tuple(shares)),
        chi_squared_of_lower_four=float(lower_four.statistic),
        p_value_of_lower_four=float(lower_four.pvalue),
    )


def _count_cells(place: Array) -> Integers:
    return np.bincount(cell(place), minlength=6)[1:]


# --- uncertainty ----------------------------------------------------------------------------------


def _estimates(
    values: Sequence[float], errors: Errors, statuses: Sequence[Status]
) -> list[Estimate]:
    return [
        Estimate(
            value=value,
            standard_error={"fitted": error, "held": 0.0, "at_bound": None}[status],
            status=status,
        )
        for value, error, status in zip(values, errors, statuses, strict=True)
    ]


def _bootstrap(
    replicates: int,
    generator: np.random.Generator,
    counts: Integers,
    fit: Callable[[Integers], tuple[float, ...]],
) -> tuple[float, ...]:
    """Return the spread of what is fitted to counts that are drawn from the observed shares."""
    total = int(counts.sum())
    shares = counts.ravel() / total
    drawn = generator.multinomial(total, shares, size=replicates).reshape(-1, *counts.shape)
    fits = np.array([fit(each) for each in drawn])
    return tuple(fits.std(axis=0, ddof=1).tolist())
