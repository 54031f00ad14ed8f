"""The analysis of the paper's Sec. II: speeds, positions across the plate, and heights.

Speeds are normal distributions, positions across the plate a mixture of two, heights are shares.
The fit is by maximum likelihood. Errors come from a bootstrap: pitches are drawn from the table
with replacement, and fitted again. The paper's own method, curves through histograms, is in
analysis/paper/histograms.py.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

import numpy as np

from longball.model.arrays import Array, Integers
from longball.pitches.chart import Columns, Pitches, PitchTypes, cell, read_pitches
from longball.pitches.fitted import AimFit, Estimate, FittedPitches, Heights, SpeedFit, Status
from longball.pitches.table import SPEED_UNITS, TableError

if TYPE_CHECKING:
    import pandas as pd

# Replicates of the bootstrap; n give a relative error of the standard errors of 1/√(2 n), here 5 %.
REPLICATES = 200

# Fewest pitches in a class. A bootstrap of fewer underestimates the standard deviation.
FEWEST_PITCHES = 20

# Boundaries of the five cells across the plate (Fig. 1), the outer ones open.
CELL_EDGES = np.array([-np.inf, 1.5, 2.5, 3.5, 4.5, np.inf])

# Positions are counted in tenths of a cell (14 mm) if the table gives more than cells. This step is
# too fine to affect a fit, and the cost of the fit does not grow with the table.
FINE_EDGES = np.concatenate([[-np.inf], np.linspace(-3.0, 9.0, 121), [np.inf]])


def fit_pitches(
    table: str | Path | TextIO | pd.DataFrame,
    columns: Columns | None = None,
    types: PitchTypes | None = None,
    *,
    replicates: int = REPLICATES,
    seed: int = 0,
) -> FittedPitches:
    """Analyse a table of pitches as the paper does.

    Parameters
    ----------
    table, columns, types
        As `longball.pitches.read_pitches` takes them.
    replicates, seed
        Number and seed of the replicates of the bootstrap.

    Raises
    ------
    TableError
        If the table cannot be used, or a class has too few pitches or all of one speed.
    """
    types = types or PitchTypes()
    pitches = read_pitches(table, columns, types)
    _enough(pitches)
    if replicates < 2:
        raise TableError(f"replicates = {replicates}: a bootstrap takes at least 2")

    # speeds by class, and the five cells or the tenths of them across
    rounding = variance_of_rounding(pitches.columns)
    edges = CELL_EDGES if pitches.columns.place_unit == "cell" else FINE_EDGES
    bins = np.searchsorted(edges, pitches.across, side="right") - 1

    def speeds_of(chosen: Integers | slice) -> list[float]:
        speed, straight = pitches.speed[chosen], pitches.straight[chosen]
        # Maximum likelihood of a normal distribution: its mean and variance, minus the variance
        # that rounding of the speeds adds (Sheppard's correction).
        moments: list[float] = []
        for each in (speed[straight], speed[~straight]):
            moments += [each.mean(), np.sqrt(max(each.var() - rounding, 0.0))]
        return [*moments, straight.mean()]

    def aim_of(chosen: Integers | slice, starts: Sequence[Aim]) -> Aim:
        counts = np.bincount(bins[chosen], minlength=len(edges) - 1)
        return likeliest_aim(counts, edges, starts)[0]

    speeds, aim = speeds_of(slice(None)), aim_of(slice(None), STARTS)

    # Bootstrap: the same for pitches drawn with replacement. The search starts from the fit, so
    # that one start is enough; the fit itself needs three.
    random = np.random.default_rng(seed)
    replicated = []
    for _ in range(replicates):
        drawn = random.integers(len(pitches.speed), size=len(pitches.speed))
        replicated.append([*speeds_of(drawn), *aim_of(drawn, [aim])])
    errors = np.std(replicated, axis=0, ddof=1).tolist()
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
        speed=speed_fit(speeds, errors[: len(speeds)]),
        aim=aim_fit(aim, errors[len(speeds) :], count_cells(pitches.across)),
        height=None if pitches.height is None else _heights(count_cells(pitches.height)),
        bootstrap_replicates=replicates,
        bootstrap_seed=seed,
    )


def speed_fit(values: Sequence[float], errors: Sequence[float]) -> SpeedFit:
    """Return fitted speeds with their errors; a weight of 0 or 1 has none."""
    inside = [True] * 4 + [0.0 < values[-1] < 1.0]
    return SpeedFit(
        **dict(zip(SpeedFit.model_fields, _estimates(values, errors, inside), strict=True))
    )


def aim_fit(aim: Aim, errors: Sequence[float], counts: Integers) -> AimFit:
    """Return fitted parameters of Eq. 4 with their errors, and the pitches in the five cells."""
    weight, left, right, spread = _estimates(aim, errors, within(aim))
    return AimFit(
        left_mean=left,
        right_mean=right,
        spread=spread,
        weight=weight,
        peaks=aim.peaks(),
        cells=_five(counts),
    )


def _estimates(
    values: Sequence[float], errors: Sequence[float], inside: Sequence[bool]
) -> Iterator[Estimate]:
    """Yield fitted numbers with their errors; a number at the end of its range has none."""
    for value, error, free in zip(values, errors, inside, strict=True):
        status: Status = "fitted" if free else "at_bound"
        yield Estimate(value=value, standard_error=error if free else None, status=status)


def _enough(pitches: Pitches) -> None:
    for name, chosen in (("straight", pitches.straight), ("breaking", ~pitches.straight)):
        speeds = pitches.speed[chosen]
        if len(speeds) < FEWEST_PITCHES:
            raise TableError(
                f"{pitches.columns.pitch_type}: only {len(speeds)} {name} balls; a fit with its "
                f"errors needs at least {FEWEST_PITCHES}"
            )
        if np.ptp(speeds) == 0.0 or speeds.var() <= variance_of_rounding(pitches.columns):
            raise TableError(
                f"{pitches.columns.speed}: the {len(speeds)} {name} balls differ no more than by "
                "rounding; a normal distribution cannot be fitted to them"
            )


def variance_of_rounding(columns: Columns) -> float:
    """Return the variance that rounding adds to speeds, m²/s² (Sheppard: step²/12)."""
    return (columns.speed_resolution * SPEED_UNITS[columns.speed_unit]) ** 2 / 12.0


# --- across the plate: Fig. 3 ---------------------------------------------------------------------


def normal(v: Array, mean: float, deviation: float, integral: float = 1.0) -> Array:
    """Return the density of a normal distribution, scaled to an integral."""
    z = (v - mean) / deviation
    return integral * np.exp(-z * z / 2.0) / (math.sqrt(2.0 * math.pi) * deviation)


class Aim(NamedTuple):
    """Parameters of Eq. 4: q, the two means and their common spread, in cells."""

    weight: float
    left: float
    right: float
    spread: float

    def density(self, y: Array) -> Array:
        """Return ψ(y), per cell."""
        left, right = (normal(y, mean, self.spread) for mean in self[1:3])
        return self.weight * left + (1.0 - self.weight) * right

    def shares(self, edges: Array) -> Array:
        """Return the integral of the density over each cell."""
        from scipy.special import ndtr

        left, right = (np.diff(ndtr((edges - mean) / self.spread)) for mean in self[1:3])
        mixed: Array = self.weight * left + (1.0 - self.weight) * right
        return mixed

    def sorted(self) -> Aim:
        """Return the same density with the left part first."""
        if self.left <= self.right:
            return self
        return Aim(1.0 - self.weight, self.right, self.left, self.spread)

    def peaks(self) -> int:
        """Count the maxima of the density, which lie between the means."""
        # The grid is finer than a thousandth of the distance of two peaks that can be
        # distinguished.
        y = np.linspace(self.left - self.spread, self.right + self.spread, 2001)
        rises = np.diff(self.density(y)) > 0.0
        return int(np.sum(rises[:-1] & ~rises[1:]))


# Range of the search for Eq. 4, in cells. The means are within the grid, because pitchers aim at
# points of the chart. Outside these spreads, the shares of five cells do not change.
RANGE = Aim(0.0, 0.5, 0.5, 0.05), Aim(1.0, 5.5, 5.5, 5.0)
# Starts of the search: two peaks at the edges of the strike zone, two broad ones, and two on the
# same side. The likelihood can have several maxima; the best of the three searches wins.
STARTS = (Aim(0.5, 2.0, 4.0, 0.8), Aim(0.5, 1.5, 4.5, 1.3), Aim(0.8, 3.0, 4.5, 1.2))

EVERYTHING = (True, True, True, True)


def likeliest_aim(
    counts: Integers, edges: Array, starts: Sequence[Aim], free: Sequence[bool] = EVERYTHING
) -> tuple[Aim, float]:
    """Fit Eq. 4 to counts in cells with these boundaries.

    Also return half the deviance per pitch, which is -ln L/n up to a constant of the counts.
    """
    shares = counts / counts.sum()

    def deviance_residuals(*aim: float) -> Array:
        # Far from every pitch the share underflows. Its logarithm must stay finite, and very low.
        expected = np.maximum(Aim(*aim).shares(edges), 1e-300)
        log_ratio = np.log(np.where(counts > 0, shares, 1.0) / expected) * (counts > 0)
        deviance = 2.0 * (shares * log_ratio - shares + expected)
        # Signed roots of the deviance, so that least squares maximise the likelihood. Rounding can
        # make a deviance of zero slightly negative.
        residuals: Array = np.sign(shares - expected) * np.sqrt(np.maximum(deviance, 0.0))
        return residuals

    return nearest_aim(deviance_residuals, starts, free)


def nearest_aim(
    residuals: Callable[..., Array], starts: Sequence[Aim], free: Sequence[bool] = EVERYTHING
) -> tuple[Aim, float]:
    """Return the parameters of Eq. 4 with the smallest sum of squares, and half that sum.

    Only the `free` parameters change, within `RANGE`.
    """
    from scipy.optimize import least_squares

    moving = np.array(free)
    low, high = np.array(RANGE)[:, moving]

    def search(start: Aim) -> tuple[Aim, float]:
        theta = np.array(start)

        def residuals_of_part(part: Array) -> Array:
            theta[moving] = part
            return residuals(*theta.tolist())

        fit = least_squares(
            residuals_of_part,
            # SciPy requires a start strictly inside the bounds.
            np.clip(theta[moving], low + 1e-3, high - 1e-3),
            bounds=(low, high),
            # Steps and gains below these are far smaller than every standard error.
            xtol=1e-10,
            ftol=1e-12,
            gtol=1e-12,
        )
        theta[moving] = fit.x
        return Aim(*theta.tolist()), float(fit.cost)

    aim, cost = min(map(search, starts), key=lambda end: end[1])
    return aim.sorted(), cost


def within(aim: Aim) -> list[bool]:
    """Return a flag for each parameter: True if it is inside the range of the search."""
    theta, low, high = np.array([aim, *RANGE])
    # The search stays strictly inside its bounds, so "at the end" means close to it.
    near = 1e-4 * (high - low)
    inside: list[bool] = ((theta > low + near) & (theta < high - near)).tolist()
    return inside


# --- cells, height: Figs. 3 and 4 -----------------------------------------------------------------


def count_cells(place: Array) -> Integers:
    """Count positions by the five cells."""
    return np.bincount(cell(place), minlength=6)[1:]


def _heights(counts: Integers) -> Heights:
    """Return the shares of the five cells, and a test of equal shares in the lower four."""
    from scipy.stats import chisquare

    total = counts.sum()
    # An empty cell has no standard error: the formula gives 0, which would mean certainty.
    shares = [
        Estimate(value=share, standard_error=float(np.sqrt(share * (1.0 - share) / total)) or None)
        for share in (counts / total).tolist()
    ]
    lower_four = chisquare(counts[:4])
    return Heights(
        cells=_five(counts),
        shares=(shares[0], shares[1], shares[2], shares[3], shares[4]),
        chi_squared_of_lower_four=float(lower_four.statistic),
        p_value_of_lower_four=float(lower_four.pvalue),
    )


def _five(counts: Integers) -> tuple[int, int, int, int, int]:
    a, b, c, d, e = counts.tolist()
    return a, b, c, d, e
