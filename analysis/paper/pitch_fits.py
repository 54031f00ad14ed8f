"""The paper's Sec. II again: Figs. 2 to 4 and Table II, each with a counterpart.

The paper's own pitches were not published. Two things can be held against what it prints: pitches
drawn from its own fits, which an analysis that works must give back; and the pitches of a day in
another league, which show what is the paper's and what is baseball's.
"""

import math
from collections import namedtuple
from collections.abc import Sequence
from functools import cache, partial
from itertools import accumulate, product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from analysis.paper.histograms import BIN_WIDTH, Curves, curves, gain_over_one_normal
from analysis.writing import STYLES, Report, data
from longball.engines.parallel import in_parallel
from longball.model.arrays import Array
from longball.pitches import EXAMPLE, Columns, FittedPitches, PitchTypes, fit_pitches, read_pitches
from longball.pitches.fitted import Estimate
from longball.pitches.fitting import normal

Rows = list[dict[str, Any]]

PITCHES = 1548  # in the paper's 12 games
SYNTHETIC_SEED = 2014
DRAWS, FULL_DRAWS = 40, 200  # of that many pitches
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
    part: str  # of `FittedPitches` and `Curves`
    key: str  # its field
    scale: float = 1.0  # brings the field to the unit
    # In the unit: of the bins that widen the number if a curve is laid through a histogram.
    bin_width: float = 0.0

    def ours(self, fitted: FittedPitches | Curves) -> tuple[float, float | None]:
        """Return our value and its standard error, in the unit."""
        estimate: Estimate = getattr(getattr(fitted, self.part), self.key)
        error = estimate.standard_error
        return self.scale * estimate.value, None if error is None else self.scale * error


PRINTED = tuple(Printed(**one) for one in data(__file__)["printed"])
MEAN_1, SPREAD_1, MEAN_2, SPREAD_2, P, LEFT, RIGHT, SPREAD, Q = (one.value for one in PRINTED)

# The tables, by their names.
Found = namedtuple("Found", "counterparts coverage r_squared grid classes")


def run(report: Report, full: bool) -> str:
    """Write tables and figures and return the section; `full`: with more random draws."""
    draws = FULL_DRAWS if full else DRAWS
    example, synthetic = fitted(EXAMPLE), synthetic_fit()
    found = Found(compared(), cover(draws), determine(draws), vary_grid(), vary_classes())
    for name, rows in found._asdict().items():
        report.write_table(f"pitch_fits_{name}", pd.DataFrame(rows), float_format="%.6g")
    draw_speeds(report, example, synthetic)
    draw_aims(report, example, synthetic)
    draw_heights(report, example)
    draw_determination(report, pd.DataFrame(found.r_squared))
    return write(report, example, synthetic, found)


class Fits(NamedTuple):
    """The pitches of a table, fitted both ways."""

    likeliest: FittedPitches
    curves: Curves


def fitted(table: Any, columns: Columns | None = None, types: PitchTypes | None = None) -> Fits:
    """Return the likeliest distributions, and the paper's curves through histograms."""
    return Fits(fit_pitches(table, columns, types), curves(read_pitches(table, columns, types)))


@cache
def synthetic_fit() -> Fits:
    """Return the fits of pitches drawn from the printed distributions, as many as the paper had."""
    return fitted(draw_pitches(PITCHES, SYNTHETIC_SEED), CHART, KINDS)


@cache
def compared() -> Rows:
    """Return printed and ours, by both methods; `analysis.paper.counterparts` asks for it, too."""
    drawn = draw_pitches(10**6, SYNTHETIC_SEED)
    million = Fits(
        fit_pitches(drawn, CHART, KINDS, replicates=2),
        curves(read_pitches(drawn, CHART, KINDS), replicates=2),
    )
    fits = synthetic_fit(), fitted(EXAMPLE), million
    by_method: dict[str, Sequence[FittedPitches | Curves]] = {
        "least_squares": [fit.curves for fit in fits],
        "maximum_likelihood": [fit.likeliest for fit in fits],
    }
    rows: Rows = []
    for method, printed in product(by_method, PRINTED):
        synthetic, example, many = by_method[method]
        value, error = printed.ours(synthetic)
        theirs, their_error = printed.ours(example)
        row: dict[str, Any] = {"method": method, "quantity": printed.name, "unit": printed.unit}
        row |= {"printed": printed.value, "synthetic": value, "synthetic_error": error}
        row |= {"difference": value - printed.value, "million": printed.ours(many)[0]}
        row |= {"example": theirs, "example_error": their_error}
        rows.append(row | {"verdict": verdict(printed, method, value, error)})
    return rows


def draw_pitches(count: int, seed: int) -> pd.DataFrame:
    """Return pitches drawn from Table II, p, q and Fig. 3, written down as Sportsnavi does."""
    random = np.random.default_rng(seed)
    straight = random.random(count) < P
    fast, slow = random.normal(MEAN_1, SPREAD_1, count), random.normal(MEAN_2, SPREAD_2, count)
    left = random.random(count) < Q
    place = np.where(left, LEFT, RIGHT) + random.normal(0.0, SPREAD, count)
    kind = np.where(straight, "straight", "breaking")
    speed, cells = np.rint(np.where(straight, fast, slow)), np.clip(np.rint(place), 1, 5)
    return pd.DataFrame({"type": kind, "speed_kmh": speed, "y": cells})


CELLS: Any = np.arange(1, 6)
# ψ(y) of Eq. 4 with the printed numbers, and the shares if that is their curve, scaled to add to 1.
DENSITY: Any = Q * normal(CELLS, LEFT, SPREAD) + (1.0 - Q) * normal(CELLS, RIGHT, SPREAD)
SHARES = DENSITY / DENSITY.sum()


def spread_behind_figure_3() -> float:
    """Return the spread of places, in cells, that puts the shares on the printed curve."""
    cells = np.repeat(CELLS, np.rint(100_000 * SHARES).astype(int))
    table = draw_pitches(len(cells), seed=0).assign(y=cells)
    return fit_pitches(table, CHART, KINDS, replicates=2).aim.spread.value


def verdict(printed: Printed, method: str, value: float, error: float | None) -> str:
    """Report if pitches drawn from a printed number give it back, and the reason if not."""
    if error is None:
        return "not determined by these pitches"
    # Of the nine numbers of a table, all of them right, one lies outside every other time.
    if abs(value - printed.value) < 2.0 * error:
        return "recovered"
    if method == "least_squares" and printed.bin_width:
        widened = math.hypot(printed.value, printed.bin_width / math.sqrt(12.0))
        if abs(value - widened) < 2.0 * error:
            return f"too wide by its bins: Sheppard's rule gives {widened:.3g}"
    if method == "least_squares" and printed.part == "aim":
        return "biased: a density at a cell's number is not its share"
    z = abs(value - printed.value) / error
    return f"off by {z:.1f} standard errors" + (": chance" if z < 3.0 else ", unexplained")


def curves_of(table: pd.DataFrame, bin_width: float) -> Curves:
    """Return the curves through the histograms of drawn pitches, without errors."""
    return curves(read_pitches(table, CHART, KINDS), bin_width, replicates=2)


def cover(draws: int) -> Rows:
    """Return the deviations of many draws' fits from the printed numbers, in standard errors."""
    # Errors from 50 replicates are known to 10 %, which widens the spread of z by half a per cent.
    fit = partial(fit_pitches, columns=CHART, types=KINDS, replicates=50)
    tables = ((draw_pitches(PITCHES, seed),) for seed in range(draws))
    fits = list(in_parallel(fit, tables, workers=-1))
    rows: Rows = []
    for printed in PRINTED:
        found = [printed.ours(fit) for fit in fits]
        z = np.array([(value - printed.value) / error for value, error in found if error])
        row = {"quantity": printed.name, "draws": len(z), "mean_of_z": z.mean()}
        row |= {"deviation_of_z": z.std(ddof=1), "within_1.96": np.mean(np.abs(z) < 1.96)}
        rows.append(row)
    return rows


@cache
def determine(draws: int) -> Rows:
    """Return the R² that the paper's fits would have if they were the truth, by width of bin."""
    tables = [draw_pitches(PITCHES, 10_000 + seed) for seed in range(draws)]
    rows: Rows = []

    def add(what: str, width: float, laid: Sequence[Curves], name: str) -> None:
        known: Any = [r for one in laid if (r := one.r_squared[name]) is not None]
        low, median, high = np.quantile(known, (0.05, 0.5, 0.95))
        row = {"what": what, "bin_width": width, "draws": len(known)}
        rows.append(row | {"low": low, "median": median, "high": high})

    for width in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
        laid = list(in_parallel(curves_of, ((x, width) for x in tables), workers=-1))
        add("speed", width, laid, "speed")
        add("speed as printed", width, laid, "speed_as_printed")
    random = np.random.default_rng(0)
    on_the_curve = [x.assign(y=random.choice(CELLS, len(x), p=SHARES)) for x in tables]
    for what, drawn in (("aim", tables), ("aim on the curve", on_the_curve)):
        laid = list(in_parallel(curves_of, ((x, BIN_WIDTH) for x in drawn), workers=-1))
        add(what, 1.0, laid, "aim_at_edges")
    return rows


def vary_grid() -> Rows:
    """Return the example's places under other grids, and for hands of batter and pitcher."""
    frame = pd.read_csv(EXAMPLE)
    # m: 0.144 is a third of the plate; 0.169 a third of it with a ball's radius on either side.
    cases = [(f"cell width {w:.3f} m", frame, w) for w in (0.120, 0.144, 0.169, 0.200)]
    for p, b in product("RL", "RL"):
        chosen = frame[(frame.p_throws == p) & (frame.stand == b)]
        cases.append((f"pitcher {p}, batter {b}", chosen, 0.144))
    rows: Rows = []
    for name, chosen, width in cases:
        columns = Columns(cell_width=width)
        aim = fit_pitches(chosen, columns, replicates=2).aim
        count, peaks = sum(aim.cells), aim.peaks
        shares = {f"share_{cell}": n / count for cell, n in zip(CELLS, aim.cells, strict=True)}
        row = {"case": name, "pitches": count, **shares, "peaks": peaks}
        gain = gain_over_one_normal(read_pitches(chosen, columns))
        rows.append(row | {"gain_over_one_normal": gain})
    return rows


def vary_classes() -> Rows:
    """Return the example's Table II for other meanings of "straight"."""
    rows: Rows = []
    for straight in accumulate((("FF",), ("FA",), ("SI",), ("FC",))):
        types = PitchTypes(straight=straight, breaking=None)
        likeliest = fit_pitches(EXAMPLE, types=types, replicates=2)
        ours = {x.key: x.ours(likeliest)[0] for x in PRINTED[:5]}
        laid = curves(read_pitches(EXAMPLE, types=types), replicates=2)
        rows.append({"straight": " ".join(straight), **ours, "r_squared": laid.r_squared["speed"]})
    return rows


THEIRS = f"{PITCHES:,} pitches drawn from the paper's fits"
OURS = "{.likeliest.rows_used:,} MLB pitches of 11 June 2023".format


SIDES = ("left", "right")


def _mixture(axes: Axes, x: Array, parts: Sequence[Array], *labels: str) -> None:
    """Draw a fitted mixture and its two parts."""
    axes.plot(x, sum(parts), **STYLES["mixture"], label=f"fitted mixture, {labels[0]}")
    axes.plot(x, parts[0], **STYLES["first part"], label=labels[1])
    axes.plot(x, parts[1], **STYLES["second part"], label=labels[2])


def draw_speeds(report: Report, example: Fits, synthetic: Fits) -> None:
    """Draw the counterpart of Fig. 2."""
    panels_of = {THEIRS: synthetic.curves, OURS(example): example.curves}
    with report.figure("pitch_fits_fig2", rows=2, size=(6.4, 7.2)) as panels:
        for axes, (title, laid) in zip(panels, panels_of.items(), strict=True):
            fit, edges = laid.speed, laid.edges * 3.6
            width, middles = edges[1] - edges[0], (edges[1:] + edges[:-1]) / 2
            counts = laid.counts.sum(axis=0)
            axes.plot(middles, counts / counts.sum(), **STYLES["measured"], label="pitches")
            v = np.linspace(edges[0], edges[-1], 400)
            parts = [width * p / 3.6 * normal(v / 3.6, *x) for p, *x in fit.mixture().parts]
            _mixture(axes, v, parts, "Eq. 3", "straight", "breaking")
            axes.set(title=title, xlabel="speed at release, km/h", ylim=(0.0, None))
            axes.set_ylabel(f"share of pitches per {width:.2g} km/h")
            determined = f"R² = {laid.r_squared['speed']:.4f}"
            axes.text(0.03, 0.95, determined, transform=axes.transAxes, va="top")
        panels[0].legend(loc="center left")


def draw_aims(report: Report, example: Fits, synthetic: Fits) -> None:
    """Draw the counterpart of Fig. 3."""
    panels_of = {THEIRS: synthetic.curves.aim, OURS(example): example.likeliest.aim}
    with report.figure("pitch_fits_fig3", rows=2, size=(6.4, 7.2)) as panels:
        panels[1].hist(
            read_pitches(EXAMPLE).across, np.arange(-1.5, 7.51, 0.25).tolist(), density=True,
            histtype="stepfilled", facecolor="0.85", edgecolor="0.6",
            label="places in quarters of a cell",
        )  # fmt: skip
        for axes, (title, fit) in zip(panels, panels_of.items(), strict=True):
            y, shares = np.linspace(-1.5, 7.5, 500), np.array(fit.cells) / sum(fit.cells)
            mixture = fit.mixture(cell_width=1.0).parts
            parts = [q * normal(y - CELLS[2], *x) for q, *x in mixture]
            names = [
                f"{side} part, weight {q:.2f}" for side, (q, *_) in zip(SIDES, mixture, strict=True)
            ]
            _mixture(axes, y, parts, "Eq. 4", *names)
            axes.plot(CELLS, shares, **STYLES["measured"], label="share of a cell")
            axes.set(title=title, xlabel="cell across the plate, from the pitcher's left")
            axes.set(xticks=range(-1, 8), ylim=(0.0, 0.4), ylabel="density per cell")
            style: Any = {"color": "0.4", "linewidth": 0.9, "dashes": (1, 3)}
            axes.axvline(1.5, 0.0, 0.65, **style, label="edges of the strike zone")
            axes.axvline(4.5, 0.0, 0.65, **style)
            axes.legend(loc="upper left")


def draw_heights(report: Report, example: Fits) -> None:
    """Draw the counterpart of Fig. 4."""
    heights = example.likeliest.height
    assert heights is not None
    shares = [share.value for share in heights.shares]
    bars = [2 * (share.standard_error or 0.0) for share in heights.shares]
    with report.figure("pitch_fits_fig4", size=(4.8, 3.8)) as (axes,):
        axes.errorbar(CELLS, shares, yerr=bars, capsize=3, **STYLES["measured"])
        axes.set(title=OURS(example), xticks=CELLS, ylim=(0.0, 0.3))
        axes.set_xlabel("cell in height, from the lowest (1 and 5 are open)")
        axes.set_ylabel("share of pitches ± 2 standard errors")


def draw_determination(report: Report, determination: pd.DataFrame) -> None:
    """Draw R² against the width of the bins."""
    printed = PRINTED_R_SQUARED["speed"]
    with report.figure("pitch_fits_r_squared", size=(6.4, 4.0)) as (axes,):
        for what, label in ("speed", "normal density"), ("speed as printed", "Eq. 2 as printed"):
            drawn = determination[determination["what"] == what]
            middle = drawn["median"]
            bars, style = [middle - drawn["low"], drawn["high"] - middle], STYLES[label]
            axes.errorbar(drawn["bin_width"], middle, bars, **style, capsize=3, label=label)
        axes.axhline(
            printed,
            color="0.4",
            linestyle=":",
            label=f"R² that the paper prints for Fig. 2, {printed}",
        )
        axes.set(title=THEIRS, xlabel="width of the bins, km/h")
        axes.set_ylabel("R²: median, and 5 % to 95 % of draws")
        axes.legend(loc="center right")


def write(report: Report, example: Fits, synthetic: Fits, found: Found) -> str:
    """Return the report in Markdown; every number and verdict in it comes from the fits."""
    return report.render(
        "pitch_fits", globals(), example=example.likeliest, found=found,
        r_squared=[fit.curves.r_squared["speed"] for fit in (synthetic, example)],
        gain=gain_over_one_normal(read_pitches(EXAMPLE)),
        within=np.mean([row["within_1.96"] for row in found.coverage]),
        spread=spread_behind_figure_3(),
    )  # fmt: skip
