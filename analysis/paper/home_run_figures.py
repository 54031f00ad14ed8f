"""Table I, Figs. 6 and 7, and the numbers of the text about home runs, with our counterparts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
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
from analysis.writing import LINES, STYLES, figure, render
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
    return render(
        report,
        "home_run_figures",
        found=found,
        nearest=describe(found[1].base, found[1].space),
        samples=SAMPLES,
        seed=SEED,
        paper_samples=PAPER_SAMPLES,
        pairs=[compare(i, pair, found) for i, pair in enumerate(PAIRS)],
        last_e=max(PEAKS),
        flat=FLAT,
        peaks=PEAKS,
        span=UZR_SPAN,
        uzr=UZR_SHARE,
        uzr_e=UZR_E,
        caption_share=curve_share(PAPER_CURVES["caption"], UZR_E, *UZR_SPAN),
        fence=HOME_RUN_DISTANCE,
        curves=PAPER_CURVES,
        restitutions=RESTITUTIONS,
    )


def compare(i: int, pair: tuple[int, int], found: Sequence[Reproduced]) -> dict[str, Any]:
    """Hold P(e) against the home runs of the pair of seasons with a number."""
    hit, caption = printed_ratio(pair), curve_ratio(pair, PAPER_CURVES["caption"])
    seasons = [season(year) for year in pair]
    ratios = [caption, *(one.ratios[i].value for one in found)]
    return {
        "years": pair,
        "restitutions": [one.restitution for one in seasons],
        "home_runs": [one.home_runs for one in seasons],
        "hit": hit,
        "caption": caption,
        "explained": [math.log(value) / math.log(hit.value) for value in ratios],
    }


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
        for name, curve in PAPER_CURVES.items():
            label = f"paper's {name}: C₁ = {curve.c1:g} m, σ = {curve.sigma:g} m"
            style = STYLES[f"paper's {name}"] | {"marker": ""}
            axes.plot(grid, [curve(e) for e in grid], **style, label=label)
        for one in found:
            p = np.array([row.p for row in one.rows])
            noise = 1.96 * np.sqrt(p * (1 - p) / PAPER_SAMPLES)
            label = f"{one.name} reading"
            style = STYLES[one.name]
            if one.fitted:
                curve = one.fitted.curve
                label += f", fit: C₁ = {curve.c1:.0f} m, σ = {curve.sigma:.1f} m"
                line = style | {"marker": "", "linewidth": 0.8}
                axes.plot(grid, [curve(e) for e in grid], **line)
            points = style | {"linestyle": "none", "capsize": 3, "markersize": 4}
            axes.errorbar(RESTITUTIONS, p, yerr=noise, **points, label=label)
        axes.set(
            xlabel="coefficient of restitution e of the ball",
            ylabel="probability of a home run P(e)",
            ylim=(0.0, None),
        )
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=2, fontsize="x-small")
