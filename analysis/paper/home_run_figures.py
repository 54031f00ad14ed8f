"""Table I, Figs. 6 and 7, and the numbers of the text about home runs, with our counterparts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.paper import combinations
from analysis.paper.balls import Balls, Base, Space, cores, describe, strike
from analysis.paper.distances import BIN, Peak, covariance, peak
from analysis.paper.printed import (
    FLAT,
    PAIRS,
    PEAKS,
    SEASONS,
    UZR_SHARE,
    UZR_SPAN,
    Season,
)
from analysis.paper.printed import SAMPLES as PAPER_SAMPLES
from analysis.writing import LINES, figure, markdown_table, shown, table
from longball.home_run import (
    HOME_RUN_DISTANCE,
    PAPER_CURVES,
    RESTITUTIONS,
    Curve,
    Estimate,
    Fit,
    draw,
    fit,
    paper_at_bats,
)

Array = NDArray[np.float64]

SAMPLES = 200_000
SEED = 31
UZR_E = 0.42  # the closest of the paper's to the season of the UZR data (its Sec. V)


@dataclass(frozen=True)
class Ratio:
    """Home runs of one season over those of another, with a standard error."""

    seasons: tuple[int, int]
    value: float
    error: float


@dataclass(frozen=True)
class Reproduced:
    """What a reading gives for Table I and Figs. 6 and 7.

    Attributes
    ----------
    name, base, space
        The reading.
    rows, fitted
        P at the five restitutions, and the paper's form fitted to it.
    fit_noise
        Standard deviations of C₁ and σ of such a fit to 1,000 samples a point.
    peaks
        The highest peaks of D.
    density
        Of D in bins of 10 m, 1/m, by restitution.
    flat
        The density's largest value over its smallest where the paper calls it the same.
    uzr_share
        The share of D in UZR's span, at e = 0.42.
    ratios
        P(e) of one season's ball over that of another.
    """

    name: str
    base: Base
    space: Space
    rows: list[Estimate]
    fitted: Fit | None
    fit_noise: tuple[float, float]
    peaks: dict[float, Peak]
    density: dict[float, Array]
    flat: float
    uzr_share: float
    ratios: list[Ratio]

    def p(self, e: float) -> float:
        """Return P at one of the restitutions."""
        return next(row.p for row in self.rows if row.e == e)


@cache
def reproduced() -> list[Reproduced]:
    """Return what the default reading gives, and the nearest; several sections ask for it."""
    return [reproduce(name, *case) for name, case in combinations.cases().items()]


def reproduce(name: str, base: Base, space: Space) -> Reproduced:
    """Return what a reading gives."""
    restitutions = sorted({*RESTITUTIONS, *(season.restitution for season in SEASONS)})
    samples = draw(paper_at_bats(base.sampling), SAMPLES, SEED)
    struck = dict(
        zip(restitutions, strike(base, samples, restitutions, threads=cores()), strict=True)
    )
    rows = [space.estimate(e, struck[e]) for e in RESTITUTIONS]
    fitted = fit(rows)
    generator = np.random.default_rng(SEED)
    flown = {e: space.distances(struck[e]) for e in restitutions}
    peaks = {
        e: peak(e, flown[e], len(flown[e]) / space.estimate(e, struck[e]).trials, generator)
        for e in PEAKS
    }
    density = {
        e: np.histogram(flown[e], np.arange(0.0, flown[e].max() + BIN, BIN))[0]
        / (BIN * len(flown[e]))
        for e in PEAKS
    }
    return Reproduced(
        name=name,
        base=base,
        space=space,
        rows=rows,
        fitted=fitted,
        fit_noise=fit_noise(fitted.curve) if fitted else (math.nan, math.nan),
        peaks=peaks,
        density=density,
        flat=flatness(density[max(PEAKS)]),
        uzr_share=float(np.mean((flown[UZR_E] >= UZR_SPAN[0]) & (flown[UZR_E] < UZR_SPAN[1]))),
        ratios=[ratio(pair, space, struck) for pair in PAIRS],
    )


def fit_noise(curve: Curve) -> tuple[float, float]:
    """Return how far 1,000 samples a point scatter C₁ and σ of a fit: standard deviations, m.

    To first order, with samples of their own for each restitution. In a = C₁/σ and b = 150/σ the
    curve is P = Φ(a e - b), and P' = φ(a e - b).
    """
    e = np.array(RESTITUTIONS)
    p = np.array([curve(one) for one in RESTITUTIONS])
    a, b = curve.c1 / curve.sigma, HOME_RUN_DISTANCE / curve.sigma
    density = np.exp(-((a * e - b) ** 2) / 2) / math.sqrt(2 * math.pi)
    by_line = np.stack([density * e, -density], axis=1)
    weight = np.linalg.inv(covariance(p, shared=False) / PAPER_SAMPLES)
    of_line = np.linalg.inv(by_line.T @ weight @ by_line)
    to_c1 = np.array([HOME_RUN_DISTANCE / b, -curve.c1 / b])
    return (
        math.sqrt(to_c1 @ of_line @ to_c1),
        curve.sigma / b * math.sqrt(of_line[1, 1]),
    )


def flatness(density: Array) -> float:
    """Return the largest value of a density over its smallest where the paper calls it flat."""
    first, last = (int(edge / BIN) for edge in FLAT)
    return float(density[first:last].max() / density[first:last].min())


def ratio(pair: tuple[int, int], space: Space, struck: dict[float, Balls]) -> Ratio:
    """Return P of one season's ball over P of another's, from the same at-bats."""
    above, below = (space.share(struck[season(year).restitution]) for year in pair)
    value = above.p / below.p
    relative = above.influence / above.p - below.influence / below.p
    return Ratio(pair, value, value * float(relative.std()) / math.sqrt(len(relative)))


def season(year: int) -> Season:
    """Return a line of Table I."""
    return next(one for one in SEASONS if one.year == year)


def printed_ratio(pair: tuple[int, int]) -> Ratio:
    """Return the ratio of the home runs that were hit, with the scatter of two counts."""
    above, below = (season(year).home_runs for year in pair)
    return Ratio(pair, above / below, above / below * math.sqrt(1 / above + 1 / below))


def curve_ratio(pair: tuple[int, int], curve: Curve) -> float:
    """Return what one of the paper's curves makes of two seasons."""
    above, below = (curve(season(year).restitution) for year in pair)
    return above / below


def curve_share(curve: Curve, e: float, low: float, high: float) -> float:
    """Return the share of D between two distances under the normal distribution of a curve."""

    def beyond(distance: float) -> float:
        return 0.5 * math.erfc((distance - curve.c1 * e) / (math.sqrt(2) * curve.sigma))

    return beyond(low) - beyond(high)


# --- the report -----------------------------------------------------------------------------------


def run(report: Path, full: bool) -> str:
    """Write the section; `full` changes nothing."""
    found = reproduced()
    draw_distances(report, found)
    draw_probabilities(report, found)
    return "\n".join(
        [
            "## Home runs: Table I, Figs. 6 and 7\n",
            f"{SAMPLES:,} at-bats (seed {SEED}), the same ones for every e, under the default "
            "reading of the ledger and under the one that comes nearest to the paper's figures "
            f"(next section): {describe(found[1].base, found[1].space)}.\n",
            "### Table I\n",
            on_seasons(report, found),
            "### Fig. 6\n",
            shown(
                "paper_fig6",
                "Density of D among the samples that have one, in bins of 10 m; triangles: the "
                "paper's highest peaks. Under the default reading the first bin, where balls hit "
                "downwards land, is cut off.",
            ),
            on_distances(found),
            "### Fig. 7\n",
            shown(
                "paper_fig7",
                "P(e) of the two readings with the fits of the paper's form, and the paper's two "
                f"printed curves; the bars are the 95 % that {PAPER_SAMPLES:,} samples a point "
                "leave open.",
            ),
            on_probabilities(report, found),
        ]
    )


def on_seasons(report: Path, found: Sequence[Reproduced]) -> str:
    """Hold P(e) against the home runs of two pairs of seasons."""
    rows = []
    sentences = []
    for i, pair in enumerate(PAIRS):
        hit, caption = printed_ratio(pair), curve_ratio(pair, PAPER_CURVES["caption"])
        rows.append(
            {
                "seasons": f"{pair[0]} / {pair[1]}",
                "e": " / ".join(f"{season(year).restitution:g}" for year in pair),
                "home runs": " / ".join(f"{season(year).home_runs:,}" for year in pair),
                "ratio": f"{hit.value:.3f} ± {hit.error:.3f}",
                "paper's caption": f"{caption:.3f}",
                **{
                    one.name: f"{one.ratios[i].value:.3f} ± {one.ratios[i].error:.3f}"
                    for one in found
                },
            }
        )
        sentences.append(
            f"{pair[0]} over {pair[1]}: the caption's own curve explains "
            f"{100 * math.log(caption) / math.log(hit.value):.0f} % of the logarithm of the ratio, "
            + ", ".join(
                f"the {one.name} reading "
                f"{100 * math.log(one.ratios[i].value) / math.log(hit.value):.0f} %"
                for one in found
            )
            + "."
        )
    return (
        "Home runs of a season are P(e) times the at-bats, so that the ratio of two seasons with "
        "as many at-bats is that of P. ± is the scatter of the counts, and the standard error of "
        f"ours.\n\n{table(report, 'paper_table1', pd.DataFrame(rows))}\n{' '.join(sentences)}\n"
    )


def on_distances(found: Sequence[Reproduced]) -> str:
    """Say where the peaks are, and how flat the density is."""
    sentences = []
    for one in found:
        peaks = "; ".join(
            f"at e = {e:g} in the bin about {here.ours:g} m most often (paper {PEAKS[e]:g} m, "
            f"p = {here.p_value:.4f})"
            for e, here in one.peaks.items()
        )
        sentences.append(
            f"The {one.name} reading, samples: {one.space.name}, has its highest peak {peaks}. "
            f"Between {FLAT[0]:g} and {FLAT[1]:g} m its density at e = {max(PEAKS)} changes by a "
            f"factor of {one.flat:.2f}, where the paper calls it almost the same."
        )
    caption = curve_share(PAPER_CURVES["caption"], UZR_E, *UZR_SPAN)
    sentences.append(
        f"UZR finds {UZR_SHARE:g} of the batted balls between {UZR_SPAN[0]:g} and {UZR_SPAN[1]:g} "
        f"m. At e = {UZR_E:g} "
        + ", ".join(f"the {one.name} reading has {one.uzr_share:.3f} there" for one in found)
        + f", and the caption's normal distribution {caption:.3f}. The paper compares UZR's share "
        f"with its P({UZR_E:g}), the share beyond {HOME_RUN_DISTANCE:g} m: another span, so that "
        "the two numbers need not agree, and that they nearly do says nothing."
    )
    return " ".join(sentences) + "\n"


def on_probabilities(report: Path, found: Sequence[Reproduced]) -> str:
    """Print P(e) and the fits."""
    frame = pd.DataFrame(
        {
            "e": [f"{e:g}" for e in RESTITUTIONS],
            **{
                f"paper's {name}": [f"{curve(e):.4f}" for e in RESTITUTIONS]
                for name, curve in PAPER_CURVES.items()
            },
            **{one.name: [f"{row.p:.4f}" for row in one.rows] for one in found},
            **{
                f"{one.name} - caption": [
                    f"{row.p - PAPER_CURVES['caption'](row.e):+.4f}" for row in one.rows
                ]
                for one in found
            },
        }
    )
    fits = [[f"paper's {n}", f"{c.c1:g}", f"{c.sigma:g}", ""] for n, c in PAPER_CURVES.items()]
    fits += [
        [
            one.name, f"{one.fitted.curve.c1:.1f}", f"{one.fitted.curve.sigma:.1f}",
            f"{one.fit_noise[0]:.0f}, {one.fit_noise[1]:.0f}",
        ]
        for one in found if one.fitted
    ]  # fmt: skip
    head = ["fit", "C₁, m", "σ, m", f"scatter of both with {PAPER_SAMPLES:,} samples a point, m"]
    return table(report, "paper_fig7", frame) + "\n" + markdown_table(head, fits)


def draw_distances(report: Path, found: Sequence[Reproduced]) -> None:
    """Draw Fig. 6."""
    with figure(report, "paper_fig6", columns=len(found), size=(9.0, 3.4)) as panels:
        for axes, one in zip(panels, found, strict=True):
            for (e, density), dash in zip(one.density.items(), LINES, strict=False):
                edges = BIN * np.arange(len(density) + 1)
                axes.stairs(
                    1e3 * density, edges, linestyle=dash, linewidth=1.5, color="black",
                    label=f"e = {e:g}",
                )  # fmt: skip
            top = 1.25e3 * max(density[1:].max() for density in one.density.values())
            for e, at in PEAKS.items():
                axes.plot(at, 0.93 * top, "v", color="0.3")
                axes.annotate(
                    f"{e:g}", (at, 0.95 * top), ha="center", va="bottom", fontsize="small"
                )
            axes.axvline(HOME_RUN_DISTANCE, color="0.5", linestyle=":", linewidth=1.0)
            axes.set(
                xlabel="distance D from the plate, m",
                ylabel="probability density, 1/km",
                title=f"{one.name} reading, samples: {one.space.name}",
                xlim=(0.0, 300.0),
                ylim=(0.0, 1.05 * top),
            )
            axes.legend(loc="center right")


def draw_probabilities(report: Path, found: Sequence[Reproduced]) -> None:
    """Draw Fig. 7."""
    grid = np.linspace(0.408, 0.452, 100)
    with figure(report, "paper_fig7", size=(6.4, 4.2)) as (axes,):
        for (name, curve), dash in zip(PAPER_CURVES.items(), ("--", ":"), strict=True):
            label = f"paper's {name}: C₁ = {curve.c1:g} m, σ = {curve.sigma:g} m"
            axes.plot(grid, [curve(e) for e in grid], dash, color="0.45", label=label)
        for one, marker in zip(found, "os", strict=True):
            p = np.array([row.p for row in one.rows])
            noise = 1.96 * np.sqrt(p * (1 - p) / PAPER_SAMPLES)
            label = f"{one.name} reading"
            if one.fitted:
                curve = one.fitted.curve
                label += f", fit: C₁ = {curve.c1:.0f} m, σ = {curve.sigma:.1f} m"
                axes.plot(grid, [curve(e) for e in grid], "-", color="black", linewidth=0.8)
            axes.errorbar(
                RESTITUTIONS, p, yerr=noise, fmt=marker, color="black", capsize=3, markersize=4,
                markerfacecolor="white" if marker == "o" else "black", label=label,
            )  # fmt: skip
        axes.set(
            xlabel="coefficient of restitution e of the ball",
            ylabel="probability of a home run P(e)",
            ylim=(0.0, None),
        )
        axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=2, fontsize="small", frameon=False
        )
