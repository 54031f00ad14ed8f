"""The paper's Sec. II again: Figs. 2 to 4 and Table II, each with a counterpart.

The paper's own pitches were not published. Two things can be held against what it prints: pitches
drawn from its own fits, which an analysis that works must give back; and the pitches of a day in
another league, which show what is the paper's and what is baseball's.
"""

import math
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import joblib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from analysis.writing import STYLES, figure, render, write_table
from longball.pitches import EXAMPLE, Columns, FittedPitches, PitchTypes, fit_pitches, read_pitches
from longball.pitches.fitted import Estimate
from longball.pitches.fitting import BIN_WIDTH, normal
from longball.pitches.table import Floats

Rows = list[dict[str, Any]]

PITCHES = 1548  # in the paper's 12 games
SYNTHETIC_SEED = 2014
DRAWS, FULL_DRAWS = 40, 200  # of that many pitches
# Table II, its headings exchanged (km/h), and p; Fig. 3 (cells), and q.
MEAN_1, SPREAD_1, MEAN_2, SPREAD_2, P = 139.1, 4.58, 127.8, 7.80, 0.45
LEFT, RIGHT, SPREAD, Q = 2.0, 4.0, 0.77, 0.52
WHAT = ("speed", "speed as printed", "aim", "aim on the curve")  # R² is determined of
PRINTED_R_SQUARED = {"speed": 0.9942, "aim": 0.986}

# Sportsnavi writes whole km/h, and the cell of the chart.
CHART = Columns(
    pitch_type="type", speed="speed_kmh", speed_unit="km/h", speed_resolution=1.0,
    across="y", height=None, place_unit="cell", view="pitcher",
)  # fmt: skip
KINDS = PitchTypes(straight=("straight",), breaking=("breaking",), left_out=())


class Printed(NamedTuple):
    """A number that the paper prints, and how ours is found in a fit."""

    name: str  # as the report calls it
    unit: str
    value: float  # as printed, in that unit
    part: str  # block of `FittedPitches`
    key: str  # its field
    scale: float = 1.0  # brings the field to the unit
    # In the unit: of the bins that widen the number if a curve is laid through a histogram.
    bin_width: float = 0.0

    def ours(self, fitted: FittedPitches, method: str) -> tuple[float, float | None]:
        """Return our value and its standard error, in the unit."""
        estimate: Estimate = getattr(getattr(getattr(fitted, self.part), method), self.key)
        error = estimate.standard_error
        return self.scale * estimate.value, None if error is None else self.scale * error


PRINTED = (
    Printed("mean of straight balls, μ₁", "km/h", MEAN_1, "speed", "straight_mean", 3.6),
    Printed("their spread, σ₁", "km/h", SPREAD_1, "speed", "straight_spread", 3.6, BIN_WIDTH),
    Printed("mean of breaking balls, μ₂", "km/h", MEAN_2, "speed", "breaking_mean", 3.6),
    Printed("their spread, σ₂", "km/h", SPREAD_2, "speed", "breaking_spread", 3.6, BIN_WIDTH),
    Printed("weight of straight balls, p", "", P, "speed", "weight"),
    Printed("left mean", "cells", LEFT, "aim", "left_mean"),
    Printed("right mean", "cells", RIGHT, "aim", "right_mean"),
    Printed("spread of both", "cells", SPREAD, "aim", "spread", 1.0, 1.0),
    Printed("weight of the left, q", "", Q, "aim", "weight"),
)


class Found(NamedTuple):
    """The tables, by their names."""

    counterparts: Rows
    coverage: Rows
    r_squared: Rows
    grid: Rows
    classes: Rows


def run(report: Path, full: bool) -> str:
    """Write tables and figures and return the section; `full`: with more random draws."""
    draws = FULL_DRAWS if full else DRAWS
    example, synthetic = fit_pitches(EXAMPLE), synthetic_fit()
    found = Found(compared(), cover(draws), determine(draws), vary_grid(), vary_classes())
    for name, rows in found._asdict().items():
        write_table(report, f"pitch_fits_{name}", pd.DataFrame(rows), float_format="%.6g")
    draw_speeds(report, example, synthetic)
    draw_aims(report, example, synthetic)
    draw_heights(report, example)
    draw_determination(report, found.r_squared)
    return write(report, example, synthetic, found)


@cache
def synthetic_fit() -> FittedPitches:
    """Return the fit of as many pitches as the paper had, drawn from what it prints."""
    return fit_pitches(draw_pitches(PITCHES, SYNTHETIC_SEED), CHART, KINDS)


@cache
def compared() -> Rows:
    """Return printed and ours; `analysis.paper.counterparts` asks for it, too."""
    million = fit_pitches(draw_pitches(10**6, SYNTHETIC_SEED), CHART, KINDS)
    return compare(fit_pitches(EXAMPLE), synthetic_fit(), million)


# --- pitches drawn from what is printed -----------------------------------------------------------


def draw_pitches(count: int, seed: int) -> pd.DataFrame:
    """Return pitches drawn from Table II, p, q and Fig. 3, written down as Sportsnavi does."""
    random = np.random.default_rng(seed)
    straight = random.random(count) < P
    speed = np.where(
        straight, random.normal(MEAN_1, SPREAD_1, count), random.normal(MEAN_2, SPREAD_2, count)
    )
    left = random.random(count) < Q
    place = np.where(left, LEFT, RIGHT) + random.normal(0.0, SPREAD, count)
    kind = np.where(straight, "straight", "breaking")
    cells = np.clip(np.rint(place), 1, 5)
    return pd.DataFrame({"type": kind, "speed_kmh": np.rint(speed), "y": cells})


def printed_density() -> Floats:
    """Return ψ(y) of Eq. 4 with the printed numbers at the five cells."""
    y = np.arange(1.0, 6.0)
    return Q * normal(y, LEFT, SPREAD) + (1.0 - Q) * normal(y, RIGHT, SPREAD)


def printed_shares() -> Floats:
    """Return the shares of the five cells if the printed ψ is their curve, scaled to add to 1."""
    shares: Floats = printed_density() / printed_density().sum()
    return shares


def spread_behind_figure_3() -> float:
    """Return the spread of places, in cells, that puts the shares on the printed curve."""
    cells = np.repeat(np.arange(1, 6), np.rint(100_000 * printed_shares()).astype(int))
    table = draw_pitches(len(cells), seed=0).assign(y=cells)
    return fit_pitches(table, CHART, KINDS, replicates=2).aim.maximum_likelihood.spread.value


# --- tables ---------------------------------------------------------------------------------------


def compare(example: FittedPitches, synthetic: FittedPitches, million: FittedPitches) -> Rows:
    """Return printed and ours, by both methods."""
    rows: Rows = []
    for method, printed in product(("least_squares", "maximum_likelihood"), PRINTED):
        value, error = printed.ours(synthetic, method)
        theirs, their_error = printed.ours(example, method)
        row: dict[str, Any] = {"method": method, "quantity": printed.name, "unit": printed.unit}
        row |= {"printed": printed.value, "synthetic": value, "synthetic_error": error}
        row |= {"difference": value - printed.value, "million": printed.ours(million, method)[0]}
        row |= {"example": theirs, "example_error": their_error}
        rows.append(row | {"verdict": verdict(printed, method, value, error)})
    return rows


def verdict(printed: Printed, method: str, value: float, error: float | None) -> str:
    """Say whether pitches drawn from a printed number give it back, and why if they do not."""
    if error is None:
        return "not determined by these pitches"
    # Of the nine numbers of a table, all of them right, one lies outside every other time.
    if abs(value - printed.value) < 2.0 * error:
        return "given back"
    if method == "least_squares" and printed.bin_width:
        widened = math.hypot(printed.value, printed.bin_width / math.sqrt(12.0))
        if abs(value - widened) < 2.0 * error:
            return f"too wide by its bins: Sheppard's rule gives {widened:.3g}"
    if method == "least_squares" and printed.part == "aim":
        return "biased: a density at a cell's number is not its share"
    z = abs(value - printed.value) / error
    return f"off by {z:.1f} standard errors" + (": chance" if z < 3.0 else ", unexplained")


def fit_all(tables: Iterable[pd.DataFrame], **options: Any) -> list[FittedPitches]:
    """Return the fits of drawn pitches."""
    fit = joblib.delayed(fit_pitches)
    calls = (fit(table, CHART, KINDS, replicates=2, **options) for table in tables)
    return list(joblib.Parallel(n_jobs=-1)(calls))


def cover(draws: int) -> Rows:
    """Return how far from the printed numbers the fits of many draws lie, in standard errors."""
    fits = fit_all(draw_pitches(PITCHES, seed) for seed in range(draws))
    rows: Rows = []
    for printed in PRINTED:
        found = [printed.ours(fitted, "maximum_likelihood") for fitted in fits]
        z = np.array([(value - printed.value) / error for value, error in found if error])
        row = {"quantity": printed.name, "draws": len(z), "mean_of_z": z.mean()}
        within = np.mean(np.abs(z) < 1.96)
        rows.append(row | {"deviation_of_z": z.std(ddof=1), "within_1.96": within})
    return rows


@cache
def determine(draws: int) -> Rows:
    """Return what R² the paper's fits would have if they were the truth, by width of bin."""
    tables = [draw_pitches(PITCHES, 10_000 + seed) for seed in range(draws)]
    rows: Rows = []

    def add(what: str, width: float, fits: Iterable[Any]) -> None:
        known = [fit.r_squared for fit in fits if fit.r_squared is not None]
        low, median, high = np.quantile(known, (0.05, 0.5, 0.95))
        row = {"what": what, "bin_width": width, "draws": len(known)}
        rows.append(row | {"low": low, "median": median, "high": high})

    for width in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
        speeds = [fitted.speed for fitted in fit_all(tables, bin_width=width)]
        add("speed", width, (x.least_squares for x in speeds))
        add("speed as printed", width, (x.least_squares_as_printed for x in speeds))
    random, p = np.random.default_rng(0), printed_shares()
    on_the_curve = [x.assign(y=random.choice(range(1, 6), len(x), p=p)) for x in tables]
    for what, drawn in (("aim", tables), ("aim on the curve", on_the_curve)):
        add(what, 1.0, (fitted.aim.least_squares_at_edges for fitted in fit_all(drawn)))
    return rows


def vary_grid() -> Rows:
    """Return the example's places under other grids, and for hands of batter and pitcher."""
    frame = pd.read_csv(EXAMPLE)
    # m: 0.144 is a third of the plate; 0.169 a third of it with a ball's radius on either side.
    cases = [(f"cell width {w:.3f} m", frame, w) for w in (0.120, 0.144, 0.169, 0.200)]
    cases += [
        (f"pitcher {p}, batter {b}", chosen, 0.144)
        for p, b in (("R", "R"), ("R", "L"), ("L", "R"), ("L", "L"))
        for chosen in [frame[(frame.p_throws == p) & (frame.stand == b)]]
    ]
    rows: Rows = []
    for name, chosen, width in cases:
        aim = fit_pitches(chosen, Columns(cell_width=width), replicates=2).aim
        count = sum(aim.cells)
        row: dict[str, Any] = {"case": name, "pitches": count}
        row |= {f"share_{cell}": n / count for cell, n in enumerate(aim.cells, start=1)}
        row |= {"peaks": aim.maximum_likelihood.peaks}
        rows.append(row | {"gain_over_one_normal": aim.gain_over_one_normal})
    return rows


def vary_classes() -> Rows:
    """Return the example's Table II for other meanings of "straight"."""
    rows: Rows = []
    names = ("FF", "FA", "SI", "FC")
    for straight in (names[: i + 1] for i in range(len(names))):
        types = PitchTypes(straight=straight, breaking=None)
        fitted = fit_pitches(EXAMPLE, types=types, replicates=2)
        row: dict[str, Any] = {"straight": " ".join(straight)}
        row |= {x.key: x.ours(fitted, "maximum_likelihood")[0] for x in PRINTED[:5]}
        rows.append(row | {"r_squared": fitted.speed.least_squares.r_squared})
    return rows


# --- figures --------------------------------------------------------------------------------------

THEIRS = f"{PITCHES:,} pitches drawn from the paper's fits"


def _ours(example: FittedPitches) -> str:
    return f"{example.rows_used:,} MLB pitches of 11 June 2023"


def _mixture(
    axes: Axes, x: Floats, weight: Estimate, of: Sequence[tuple[Estimate, Estimate]],
    labels: Sequence[str], unit: float = 1.0, scale: float = 1.0,
) -> None:  # fmt: skip
    """Draw a fitted mixture and its two parts, from their means and spreads in a unit."""
    first, second = (
        scale * share * normal(x, unit * mean.value, unit * spread.value)
        for share, (mean, spread) in zip((weight.value, 1 - weight.value), of, strict=True)
    )
    parts = {"mixture": first + second, "first part": first, "second part": second}
    for (style, y), label in zip(parts.items(), labels, strict=True):
        axes.plot(x, y, **STYLES[style], label=label)


def draw_speeds(report: Path, example: FittedPitches, synthetic: FittedPitches) -> None:
    """Draw the counterpart of Fig. 2."""
    panels_of = {THEIRS: synthetic.speed, _ours(example): example.speed}
    with figure(report, "pitch_fits_fig2", columns=2, size=(9.6, 3.8)) as panels:
        for axes, (title, fitted) in zip(panels, panels_of.items(), strict=True):
            histogram, fit = fitted.histogram, fitted.least_squares
            edges = np.array(histogram.edges) * 3.6
            width = edges[1] - edges[0]
            counts = np.array(histogram.straight) + np.array(histogram.breaking)
            middles = (edges[1:] + edges[:-1]) / 2
            axes.plot(middles, counts / counts.sum(), **STYLES["measured"], label="pitches")
            v = np.linspace(edges[0], edges[-1], 400)
            labels = ("fitted mixture, Eq. 3", "straight", "breaking")
            straight = fit.straight_mean, fit.straight_spread
            breaking = fit.breaking_mean, fit.breaking_spread
            _mixture(axes, v, fit.weight, (straight, breaking), labels, 3.6, width)
            axes.set(title=title, xlabel="speed at release, km/h")
            axes.set_ylabel(f"share of pitches per {width:.2g} km/h")
            axes.text(0.03, 0.95, f"R² = {fit.r_squared:.4f}", transform=axes.transAxes, va="top")
            axes.set_ylim(bottom=0.0)
        panels[0].legend(fontsize="small", loc="center left")


def draw_aims(report: Path, example: FittedPitches, synthetic: FittedPitches) -> None:
    """Draw the counterpart of Fig. 3."""
    panels_of = (
        (THEIRS, synthetic.aim.cells, synthetic.aim.least_squares),
        (_ours(example), example.aim.cells, example.aim.maximum_likelihood),
    )
    with figure(report, "pitch_fits_fig3", columns=2, size=(9.6, 3.8)) as panels:
        panels[1].hist(
            read_pitches(EXAMPLE).across, np.arange(-1.5, 7.51, 0.25).tolist(), density=True,
            histtype="stepfilled", facecolor="0.85", edgecolor="0.6",
            label="places in quarters of a cell",
        )  # fmt: skip
        for axes, (title, cells, fit) in zip(panels, panels_of, strict=True):
            sides = (fit.left_mean, fit.spread), (fit.right_mean, fit.spread)
            labels = ("fitted mixture, Eq. 4", "left", "right")
            _mixture(axes, np.linspace(-1.5, 7.5, 500), fit.weight, sides, labels)
            shares = np.array(cells) / sum(cells)
            label = "cells (1 and 5 are open)"
            axes.plot(range(1, 6), shares, **STYLES["measured"], label=label)
            axes.set(title=title, xlabel="cell across the plate, from the pitcher's left")
            axes.set(xticks=range(-1, 8), ylim=(0.0, 0.4))
            dotted: Any = {"ymax": 0.65, "color": "0.4", "linewidth": 0.9, "dashes": (1, 3)}
            axes.axvline(1.5, **dotted, label="edges of the strike zone")
            axes.axvline(4.5, **dotted)
            axes.legend(fontsize="small", loc="upper right")
        panels[0].set_ylabel("share of a cell; density per cell")


def draw_heights(report: Path, example: FittedPitches) -> None:
    """Draw the counterpart of Fig. 4."""
    assert example.height is not None
    shares = [share.value for share in example.height.shares]
    bars = [2 * (share.standard_error or 0.0) for share in example.height.shares]
    with figure(report, "pitch_fits_fig4", size=(4.8, 3.8)) as (axes,):
        axes.errorbar(range(1, 6), shares, yerr=bars, capsize=3, **STYLES["measured"])
        axes.set(title=_ours(example), xticks=range(1, 6), ylim=(0.0, 0.3))
        axes.set_xlabel("cell in height, from the lowest (1 and 5 are open)")
        axes.set_ylabel("share of pitches ± 2 standard errors")


def draw_determination(report: Path, determination: Rows) -> None:
    """Draw R² against the width of the bins."""
    frame = pd.DataFrame(determination)
    printed = PRINTED_R_SQUARED["speed"]
    with figure(report, "pitch_fits_r_squared", size=(4.8, 3.8)) as (axes,):
        for what, label in ("speed", "normal density"), ("speed as printed", "Eq. 2 as printed"):
            low, median, high = (frame[frame["what"] == what][x] for x in ("low", "median", "high"))
            style, widths = STYLES[label], frame[frame["what"] == what]["bin_width"]
            bars = [median - low, high - median]
            axes.errorbar(widths, median, yerr=bars, **style, capsize=3, label=label)
        axes.axhline(printed, color="0.4", linestyle=":", label=f"printed: {printed}")
        axes.set(title=THEIRS, xlabel="width of the bins, km/h")
        axes.set_ylabel("R² (median, 5 % to 95 % of draws)")
        axes.legend(fontsize="small", loc="center left")


def write(report: Path, example: FittedPitches, synthetic: FittedPitches, found: Found) -> str:
    """Return the report in Markdown; every number and verdict in it comes from the fits."""
    of = {what: [r for r in found.r_squared if r["what"] == what] for what in WHAT}
    return render(
        report, "pitch_fits", globals(), example=example, synthetic=synthetic, found=found,
        within=float(np.mean([row["within_1.96"] for row in found.coverage])),
        speed=of["speed"], aim=of["aim"][0], on_the_curve=of["aim on the curve"][0],
        as_printed=max(row["high"] for row in of["speed as printed"]),
        spread=spread_behind_figure_3(),
    )  # fmt: skip
