"""Result of a fit of pitches: distributions, their errors, and tests of the fit.

All numbers are in SI units, except positions across the plate: these are in cells, numbered from
left to right as the pitcher sees them, and continuous (a cell of the chart extends half a unit to
either side of its number). A spread is always a standard deviation. The exponent of Eq. 2 lacks a
factor of 2, so that its σ is √2 times the standard deviation; σ always means the paper's.
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

Status = Literal["fitted", "at_bound"]
T = TypeVar("T")
# A value for each cell of the chart.
Five = tuple[T, T, T, T, T]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class Estimate(Strict):
    """A fitted number."""

    value: float
    standard_error: float | None = Field(description="null where the data do not determine it")
    status: Status = Field(
        default="fitted",
        description="at_bound: the search ended at the end of its range, so that the value is no "
        "maximum and has no error",
    )


# The file may be edited by hand, and `longball homerun` draws from it: check the ranges.
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
    """Fit of Eqs. 2 and 3, for Fig. 2 and Table II."""

    straight_mean: Positive = Field(description="m/s, μ₁")
    straight_spread: Positive = Field(description="m/s, standard deviation")
    breaking_mean: Positive = Field(description="m/s, μ₂")
    breaking_spread: Positive = Field(description="m/s, standard deviation")
    weight: Weight = Field(description="p, of the straight balls")

    def mixture(self) -> Mixture:
        """Return the fitted distribution, m/s; the straight balls come first."""
        return Mixture(
            self.weight.value,
            (self.straight_mean.value, self.breaking_mean.value),
            (self.straight_spread.value, self.breaking_spread.value),
        )


class AimFit(Strict):
    """Fit of Eq. 4, for Fig. 3."""

    left_mean: Estimate = Field(description="cells")
    right_mean: Estimate = Field(description="cells")
    spread: Positive = Field(description="cells, the standard deviation of both")
    weight: Weight = Field(description="q, of the left one")
    peaks: int = Field(description="maxima of the fitted density: 1 or 2")
    cells: Five[int] = Field(description="pitches in cells 1 to 5")

    def mixture(self, cell_width: float) -> Mixture:
        """Return the fitted distribution of P_y = (cell - 3) `cell_width`, m; left comes first."""
        left, right = (
            (x.value - MIDDLE_CELL) * cell_width for x in (self.left_mean, self.right_mean)
        )
        deviation = self.spread.value * cell_width
        return Mixture(self.weight.value, (left, right), (deviation, deviation))


class Heights(Strict):
    """Heights at the plate, for Fig. 4."""

    cells: Five[int] = Field(description="pitches in cells 1 to 5")
    shares: Five[Estimate]
    chi_squared_of_lower_four: float = Field(
        description="of cells 1 to 4 against equal shares, 3 degrees of freedom"
    )
    p_value_of_lower_four: Share = Field(description="of that χ² if the shares are equal")


class FittedPitches(Strict):
    """The analysis of the paper's Sec. II for a table of pitches.

    `longball homerun --pitches` reads it.
    """

    source: str
    columns: Columns
    types: PitchTypes
    rows_read: int
    rows_used: int
    left_out: tuple[Omission, ...]
    straight: dict[str, int] = Field(description="pitches by type")
    breaking: dict[str, int] = Field(description="pitches by type")
    speed: SpeedFit
    aim: AimFit = Field(
        description="to the places themselves, or to cells if the table gives no more: a cell has "
        "the integral of the density over it"
    )
    height: Heights | None = Field(description="null: the table says nothing of heights")
    bootstrap_replicates: int = Field(description="behind the errors")
    bootstrap_seed: int

    def distributions(self) -> tuple[Mixture, Mixture]:
        """Return the distributions of speed, m/s, and aim, m, to draw from."""
        return self.speed.mixture(), self.aim.mixture(self.columns.cell_width)

    # `height` is not used: the paper's at-bats draw no height of the pitch (its Sec. III).
    def drawn_in(self, at_bats: AtBats) -> AtBats:
        """Return at-bats that draw their pitches from these distributions."""
        speed, aim = self.distributions()
        return replace(at_bats, speed=speed, aim=aim)


def load_fitted(path: str | PathLike[str]) -> FittedPitches:
    """Read a result of `longball fit --json`; a `TableError` names the key at fault."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise TableError(f"{path}: {not_utf8(error)}") from None
    try:
        return FittedPitches.model_validate_json(text)
    except ValidationError as error:
        faults = explain(error, FittedPitches)
        # Another kind of file lacks all keys; the first one is enough.
        if error.error_count() > 3:
            faults = faults.partition(";")[0]
        raise TableError(f"{path}: not the result of longball fit --json: {faults}") from None


# --- text -----------------------------------------------------------------------------------------


def as_text(fitted: FittedPitches) -> str:
    """Return the fit as text, in the paper's units."""
    return "\n".join(_lines(fitted)) + "\n"


def _lines(fitted: FittedPitches) -> Iterator[str]:
    yield f"{fitted.source}: {fitted.rows_used} pitches used of {fitted.rows_read} rows"
    for each in fitted.left_out:
        yield f"  {each}"
    for name, types in (("straight", fitted.straight), ("breaking", fitted.breaking)):
        counts = ", ".join(f"{kind} {count}" for kind, count in types.items())
        yield f"  {name}: {sum(types.values())} ({counts})"

    # In the paper's units and with its σ, for comparison with Table II.
    speed, aim = fitted.speed, fitted.aim
    yield "\nSpeed (Table II, Fig. 2)"
    for kind in ("straight", "breaking"):
        mean, spread = getattr(speed, f"{kind}_mean"), getattr(speed, f"{kind}_spread")
        yield _row(f"mean of {kind}, km/h", mean, 3.6, 2)
        yield _row("  its standard deviation", spread, 3.6, 2)
        yield _row("  σ of Eq. 2 as printed", spread, 3.6 * math.sqrt(2.0), 2)
    yield _row("p, weight of straight", speed.weight, 1.0, 4)

    yield "\nAcross (Fig. 3)"
    yield _row("mean of left, cells", aim.left_mean, 1.0, 3)
    yield _row("mean of right, cells", aim.right_mean, 1.0, 3)
    yield _row("standard deviation, cells", aim.spread, 1.0, 3)
    yield _row("q, weight of left", aim.weight, 1.0, 3)
    yield f"{'peaks':28}{aim.peaks}"
    yield f"{'pitches in cells 1 to 5':28}{', '.join(map(str, aim.cells))}"

    if (height := fitted.height) is not None:
        yield "\nHeight (Fig. 4)"
        for index, share in enumerate(height.shares, start=1):
            yield _row(f"share of cell {index}", share, 1.0, 4)
        test = f"χ² = {height.chi_squared_of_lower_four:.1f} (3 degrees of freedom)"
        yield f"{'cells 1 to 4 equal':28}{test}, p = {height.p_value_of_lower_four:.2g}"
    yield ""
    yield "By maximum likelihood; ± is one standard error, ? means that it is unknown. At bound: an"
    yield "end of the range of the search; the likelihood has no maximum within it."
    yield (
        f"A cell across is {fitted.columns.cell_width:g} m wide, numbered from the pitcher's left."
    )


def _row(label: str, estimate: Estimate, scale: float, digits: int) -> str:
    value = f"{label:28}{scale * estimate.value:.{digits}f}"
    if estimate.status == "at_bound":
        return f"{value} (at bound)"
    if estimate.standard_error is None:
        return f"{value} ± ?"
    return f"{value} ± {scale * estimate.standard_error:.{digits}f}"
