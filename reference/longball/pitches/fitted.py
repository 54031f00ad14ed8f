"""The result of a fit of pitches: distributions, their uncertainty, and how well they fit.

Everything is in SI units; places across the plate are in cells, numbered from left to right as the
pitcher sees them and continuous: a cell of the chart reaches half a unit to either side of its
number. A spread is always a standard deviation. Eq. 2 lacks the 2 of its exponent, so that the σ it
speaks of as printed is √2 times that; where a σ in the paper's sense is meant, it is called σ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, Field, ValidationError

from longball.home_run import MIDDLE_CELL, AtBats, Mixture
from longball.model.block import Strict
from longball.model.csv_files import not_utf8
from longball.model.explain import explain
from longball.pitches.chart import Columns, PitchTypes
from longball.pitches.table import Omission, TableError

Method = Literal["maximum_likelihood", "least_squares"]
Status = Literal["fitted", "held", "at_bound"]
T = TypeVar("T")
Five = tuple[T, T, T, T, T]  # a value for each cell
Share = Annotated[float, Field(ge=0.0, le=1.0)]

# The 95 % point of (χ²₀ + χ²₁)/2, the distribution of a likelihood ratio where the truth lies on
# the boundary between the two hypotheses (Self and Liang, J. Am. Stat. Assoc. 82, 605 (1987)).
PEAK_GAIN = 2.71


class Estimate(Strict):
    """A fitted number."""

    value: float
    standard_error: float | None = Field(description="null where the data do not determine it")
    status: Status = Field(
        default="fitted",
        description="held: not fitted, its error is 0; at_bound: the search ended at the end of "
        "its range, so that the value is no maximum and has no error",
    )


def _positive(estimate: Estimate) -> Estimate:
    if estimate.value <= 0.0:
        raise ValueError("must be positive")
    return estimate


def _share(estimate: Estimate) -> Estimate:
    if not 0.0 <= estimate.value <= 1.0:
        raise ValueError("must lie between 0 and 1")
    return estimate


Positive = Annotated[Estimate, AfterValidator(_positive)]
Weight = Annotated[Estimate, AfterValidator(_share)]


class SpeedFit(Strict):
    """Eqs. 2 and 3, fitted."""

    straight_mean: Positive = Field(description="m/s, μ₁")
    straight_spread: Positive = Field(description="m/s, standard deviation")
    breaking_mean: Positive = Field(description="m/s, μ₂")
    breaking_spread: Positive = Field(description="m/s, standard deviation")
    weight: Weight = Field(description="p, of the straight balls")
    r_squared: float | None = Field(
        description="coefficient of determination of the mixture against the histogram; null if "
        "all its bins are equally full"
    )

    def mixture(self) -> Mixture:
        """Return the fitted distribution, m/s; the straight balls come first."""
        return Mixture(
            self.weight.value,
            (self.straight_mean.value, self.breaking_mean.value),
            (self.straight_spread.value, self.breaking_spread.value),
        )


class AimFit(Strict):
    """Eq. 4, fitted."""

    left_mean: Estimate = Field(description="cells")
    right_mean: Estimate = Field(description="cells")
    spread: Positive = Field(description="cells, the standard deviation of both")
    weight: Weight = Field(description="q, of the left one")
    peaks: int = Field(description="maxima of the fitted density: 1 or 2")
    r_squared: float | None = Field(
        description="coefficient of determination against the five cells; null if all are equal"
    )

    def mixture(self, cell_width: float) -> Mixture:
        """Return the fitted distribution of P_y = (cell - 3) `cell_width`, m; left comes first."""
        left, right = (
            (x.value - MIDDLE_CELL) * cell_width for x in (self.left_mean, self.right_mean)
        )
        deviation = self.spread.value * cell_width
        return Mixture(self.weight.value, (left, right), (deviation, deviation))


class SpeedHistogram(Strict):
    """The circles of Fig. 2, by class."""

    edges: tuple[float, ...] = Field(description="m/s")
    straight: tuple[int, ...] = Field(description="pitches per bin")
    breaking: tuple[int, ...] = Field(description="pitches per bin")


class Speeds(Strict):
    """Fig. 2 and Table II."""

    histogram: SpeedHistogram
    maximum_likelihood: SpeedFit
    least_squares: SpeedFit = Field(description="normal curves laid through the histogram")
    least_squares_as_printed: SpeedFit = Field(
        description="the curve of Eq. 2 as printed, whose integral is 1/√2, laid through the "
        "histogram; its σ is √2 times the standard deviation given here"
    )


class Aims(Strict):
    """Fig. 3."""

    cells: Five[int] = Field(description="pitches in cells 1 to 5")
    maximum_likelihood: AimFit = Field(
        description="of the places themselves, or of cells if the table gives no more: "
        "a cell has the integral of the density over it"
    )
    gain_over_one_normal: float = Field(
        description="twice the logarithm of how much likelier that mixture is than one normal "
        "distribution, which has two parameters less"
    )
    gain_over_one_peak: float = Field(
        description="the same over the likeliest mixture of Eq. 4 that has a single maximum; 0 if "
        "the likeliest of all has"
    )
    two_peaks_supported: bool = Field(
        description="whether the first gain exceeds 2 ln n, which is what two more parameters "
        f"cost (BIC), and the second {PEAK_GAIN}, which 5 % of samples from a density with one "
        "peak exceed at most; both compare with densities of Eq. 4 only"
    )
    least_squares: AimFit = Field(
        description="the density at a cell's number laid through the cell's share, as in Fig. 3"
    )
    least_squares_at_edges: AimFit = Field(
        description="the same with the means held at 2 and 4, as they are printed"
    )


class Heights(Strict):
    """Fig. 4."""

    cells: Five[int] = Field(description="pitches in cells 1 to 5")
    shares: Five[Estimate]
    chi_squared_of_lower_four: float = Field(
        description="of cells 1 to 4 against equal shares, 3 degrees of freedom"
    )
    p_value_of_lower_four: Share = Field(description="of that χ² if the shares are equal")


class FittedPitches(Strict):
    """The paper's Sec. II on a table of pitches: `longball homerun --pitches` reads it."""

    source: str
    columns: Columns
    types: PitchTypes
    rows_read: int
    rows_used: int
    left_out: tuple[Omission, ...]
    straight: dict[str, int] = Field(description="pitches by type")
    breaking: dict[str, int] = Field(description="pitches by type")
    speed: Speeds
    aim: Aims
    height: Heights | None = Field(description="null: the table says nothing of heights")
    bootstrap_replicates: int = Field(description="behind the errors of least squares")
    bootstrap_seed: int
    draw_from: Method = Field(description="which of the fits is to be drawn from")

    def distributions(self, method: Method | None = None) -> tuple[Mixture, Mixture]:
        """Return the distributions of speed, m/s, and aim, m, to draw from."""
        method = method or self.draw_from
        speed: SpeedFit = getattr(self.speed, method)
        aim: AimFit = getattr(self.aim, method)
        return speed.mixture(), aim.mixture(self.columns.cell_width)

    def drawn_in(self, at_bats: AtBats) -> AtBats:
        """Return at-bats that draw their pitches from these distributions."""
        speed, aim = self.distributions()
        return replace(at_bats, speed=speed, aim=aim)


def load_fitted(path: str | PathLike[str]) -> FittedPitches:
    """Read what `longball fit --json` wrote; a `TableError` names the key at fault."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise TableError(f"{path}: {not_utf8(error)}") from None
    try:
        return FittedPitches.model_validate_json(text)
    except ValidationError as error:
        raise TableError(
            f"{path}: not the result of longball fit: {explain(error, FittedPitches)}"
        ) from None


# --- for people -----------------------------------------------------------------------------------


def as_text(fitted: FittedPitches) -> str:
    """Return the fit as a table for people, in the paper's units."""
    return "\n".join(_lines(fitted)) + "\n"


def _lines(fitted: FittedPitches) -> Iterator[str]:
    yield f"{fitted.source}: {fitted.rows_used} pitches used of {fitted.rows_read} rows"
    for each in fitted.left_out:
        yield f"  {each}"
    for name, types in (("straight", fitted.straight), ("breaking", fitted.breaking)):
        found = ", ".join(f"{kind} {count}" for kind, count in types.items())
        yield f"  {name}: {sum(types.values())} ({found})"

    speed = fitted.speed
    yield ""
    yield _row("Speed (Table II, Fig. 2)", "maximum likelihood", "histogram", "Eq. 2 as printed")
    fits = (speed.maximum_likelihood, speed.least_squares, speed.least_squares_as_printed)
    for kind in ("straight", "breaking"):
        for label, key, scale in (
            (f"mean of {kind}, km/h", f"{kind}_mean", 3.6),
            ("  its standard deviation", f"{kind}_spread", 3.6),
            ("  σ of Eq. 2 as printed", f"{kind}_spread", 3.6 * math.sqrt(2.0)),
        ):
            yield _row(label, *(_number(getattr(fit, key), scale, 2) for fit in fits))
    yield _row("p, weight of straight", *(_number(fit.weight, 1.0, 4) for fit in fits))
    yield _row("R² of the mixture", *(_determination(fit.r_squared) for fit in fits))

    aim = fitted.aim
    yield ""
    yield _row("Across (Fig. 3)", "maximum likelihood", "histogram", "means held")
    aims = (aim.maximum_likelihood, aim.least_squares, aim.least_squares_at_edges)
    for label, key in (
        ("mean of left, cells", "left_mean"),
        ("mean of right, cells", "right_mean"),
        ("standard deviation, cells", "spread"),
        ("q, weight of left", "weight"),
    ):
        yield _row(label, *(_number(getattr(fit, key), 1.0, 3) for fit in aims))
    unsupported = "" if aim.two_peaks_supported else ", unsupported"
    yield _row("peaks", *(f"{fit.peaks}{unsupported * (fit.peaks == 2)}" for fit in aims))
    yield _row("R²", *(_determination(fit.r_squared) for fit in aims))
    needed = 2.0 * math.log(sum(aim.cells))
    yield _row("2 Δ ln L over one normal", f"{aim.gain_over_one_normal:.1f} (BIC: {needed:.1f})")
    yield _row("2 Δ ln L over one peak", f"{aim.gain_over_one_peak:.1f} (5 %: {PEAK_GAIN})")
    if not aim.two_peaks_supported:
        yield "The data do not support two peaks: one of these gains is below what it has to be."
    yield _row("pitches in cells 1 to 5", ", ".join(map(str, aim.cells)))

    if fitted.height is not None:
        yield ""
        yield "Height (Fig. 4)"
        for index, share in enumerate(fitted.height.shares, start=1):
            yield _row(f"share of cell {index}", _number(share, 1.0, 4))
        yield _row(
            "cells 1 to 4 equal",
            f"χ² = {fitted.height.chi_squared_of_lower_four:.1f} (3 degrees of freedom), "
            f"p = {fitted.height.p_value_of_lower_four:.2g}",
        )
    yield ""
    yield "± is one standard error, ? where there is none to give. At bound: where the range of the"
    yield "search ends; the likelihood, or the sum of squares, has no extremum there."
    yield (
        f"A cell across is {fitted.columns.cell_width:g} m wide, numbered from the pitcher's left. "
        f"To draw from: {fitted.draw_from.replace('_', ' ')}."
    )


def _row(label: str, *values: str) -> str:
    return f"{label:28}" + "".join(f"{value:21}" for value in values).rstrip()


def _number(estimate: Estimate, scale: float, digits: int) -> str:
    value = f"{scale * estimate.value:.{digits}f}"
    if estimate.status != "fitted":
        return f"{value} ({estimate.status.replace('_', ' ')})"
    if estimate.standard_error is None:
        return f"{value} ± ?"
    return f"{value} ± {scale * estimate.standard_error:.{digits}f}"


def _determination(value: float | None) -> str:
    return "?" if value is None else f"{value:.4f}"
