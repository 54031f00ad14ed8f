"""Table I, Figs. 6 and 7, and the numbers of the text about home runs, with our counterparts."""

import math
from functools import cache
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from scipy.stats import norm

from analysis.paper import balls, combinations, distances, printed
from analysis.paper.balls import Balls, Space
from analysis.paper.combinations import Trial
from analysis.paper.distances import BIN, covariance
from analysis.paper.printed import FLAT, PAIRS, PEAKS, UZR_SPAN, Season
from analysis.writing import LINES, STYLES, Report
from longball import home_run
from longball.home_run import HOME_RUN_DISTANCE, PAPER_CURVES, RESTITUTIONS, Curve
from longball.home_run.estimation import of_line
from longball.model.arrays import Array

UZR_E = 0.42  # the closest of the paper's to the season of the UZR data (its Sec. V)


class Ratio(NamedTuple):
    """Home runs of one season over those of another, with a standard error."""

    value: float
    error: float


class Reproduced(NamedTuple):
    """Table I and Figs. 6 and 7 by a reading."""

    name: str
    trial: Trial
    fitted: home_run.Fit | None  # the paper's form, to P at the five restitutions
    curve: Curve  # of the fit; not numbers if there is none
    density: dict[float, Array]  # of D in bins of 10 m, 1/m, by restitution
    uzr_share: float  # of D in UZR's span, at e = 0.42
    ratios: list[Ratio]  # P(e) of one season's ball over that of another


@cache
def reproduced() -> list[Reproduced]:
    """Reproduce the figures by the default and the nearest reading; several sections use them."""
    restitutions = sorted({*RESTITUTIONS, *(one.restitution for pair in PAIRS for one in pair)})
    found = []
    for name, (base, space) in combinations.cases().items():
        at_all = balls.strike(base, base.drawn(), restitutions)
        struck = dict(zip(restitutions, at_all, strict=True))
        trial = combinations.trial(base, space, [struck[e] for e in RESTITUTIONS])
        density = {e: distances.density(space.distances(struck[e])) for e in PEAKS}
        flown = space.distances(struck[UZR_E])
        uzr_share = float(np.mean((flown >= UZR_SPAN[0]) & (flown < UZR_SPAN[1])))
        ratios = [ratio(pair, space, struck) for pair in PAIRS]
        fitted = home_run.fit(trial.rows)
        curve = fitted.curve if fitted else Curve(math.nan, math.nan)
        found.append(Reproduced(name, trial, fitted, curve, density, uzr_share, ratios))
    return found


def fit_noise(curve: Curve) -> tuple[float, float]:
    """Return the standard deviations, m, of C₁ and σ in fits to 1,000 samples a point.

    To first order, with samples of their own for each restitution. In a = C₁/σ and b = 150/σ the
    curve is P = Φ(a e - b), and P' = φ(a e - b).
    """
    e, p = np.array([(e, curve(e)) for e in RESTITUTIONS]).T
    a, b = curve.c1 / curve.sigma, HOME_RUN_DISTANCE / curve.sigma
    density = norm.pdf(a * e - b)
    by_line = np.stack([density * e, -density], axis=1)
    weight = np.linalg.inv(covariance(p, shared=False) / printed.SAMPLES)
    noisy = of_line(a, b, np.linalg.inv(by_line.T @ weight @ by_line))
    return noisy.c1_error, noisy.sigma_error


CALLED_FLAT = slice(*(int(edge / BIN) for edge in FLAT))  # bins of 10 m


def flatness(density: Array) -> float:
    """Return the largest value of a density over its smallest where the paper calls it flat."""
    return float(density[CALLED_FLAT].max() / density[CALLED_FLAT].min())


def ratio(pair: tuple[Season, Season], space: Space, struck: dict[float, Balls]) -> Ratio:
    """Return P of one season's ball over P of another's, from the same at-bats."""
    above, below = (space.share(struck[season.restitution]) for season in pair)
    value = above.p / below.p
    relative = above.influence / above.p - below.influence / below.p
    return Ratio(value, value * float(relative.std()) / math.sqrt(len(relative)))


def printed_ratio(pair: tuple[Season, Season]) -> Ratio:
    """Return the ratio of the home runs that were hit, with the scatter of two counts."""
    above, below = (season.home_runs for season in pair)
    return Ratio(above / below, above / below * math.sqrt(1 / above + 1 / below))


def curve_ratio(curve: Curve, pair: tuple[Season, Season]) -> float:
    """Return the ratio of home runs in a pair of seasons by a curve."""
    return curve(pair[0].restitution) / curve(pair[1].restitution)


def curve_share(curve: Curve, e: float, low: float, high: float) -> float:
    """Return the share of D between two distances under the normal distribution of a curve."""
    reach = NormalDist(curve.c1 * e, curve.sigma)
    return reach.cdf(high) - reach.cdf(low)


def run(report: Report, full: bool) -> str:
    """Write the section; `full` changes nothing."""
    found = reproduced()
    with report.figure("paper_fig6", rows=len(found), size=(6.4, 6.8)) as panels:
        for axes, one in zip(panels, found, strict=True):
            top = 1.25 * draw_stairs(axes, one.density, linewidth=1.5, color="black")
            for e, at in PEAKS.items():
                axes.plot(at, 0.93 * top, "v", color="0.3")
                place: Any = {"ha": "center", "va": "bottom", "fontsize": "small"}
                axes.annotate(f"{e:g}", (at, 0.95 * top), **place)
            axes.axvline(HOME_RUN_DISTANCE, color="0.5", linestyle=":", linewidth=1.0)
            axes.set(title=f"{one.name} reading, samples: {one.trial.space.name}")
            axes.set(xlim=(0.0, 300.0), ylim=(0.0, 1.05 * top))
            axes.legend(loc="center right")
    grid = np.linspace(0.408, 0.452, 100)
    with report.figure("paper_fig7", size=(6.4, 4.8)) as (axes,):
        for name, curve in PAPER_CURVES.items():
            label = f"paper's {name}: C₁ = {curve.c1:g} m, σ = {curve.sigma:g} m"
            style = STYLES[f"paper's {name}"] | {"marker": ""}
            axes.plot(grid, [curve(e) for e in grid], **style, label=label)
        for one in found:
            p, curve, style = np.array(one.trial.shares), one.curve, STYLES[one.name]
            line = style | {"marker": "", "linewidth": 0.8}
            axes.plot(grid, [curve(e) for e in grid], **line)
            label = f"{one.name} reading"
            if one.fitted:
                label += f", fit: C₁ = {curve.c1:.0f} m, σ = {curve.sigma:.1f} m"
            points = style | {"linestyle": "none", "capsize": 3, "markersize": 4}
            axes.errorbar(RESTITUTIONS, p, 1.96 * printed.noise(p), **points, label=label)
        axes.set(xlabel="coefficient of restitution e of the ball", ylim=(0.0, None))
        axes.set_ylabel("probability of a home run P(e)")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.01))
    return report.render("home_run_figures", globals(), found=found)


def draw_stairs(axes: Axes, densities: dict[float, Array], **style: Any) -> float:
    """Draw densities of D by restitution; return the highest value behind the first bin, 1/m."""
    for (e, density), dash in zip(densities.items(), LINES, strict=False):
        edges = BIN * np.arange(len(density) + 1)
        axes.stairs(density, edges, linestyle=dash, **style, label=f"e = {e:g}")
    axes.set(xlabel="distance D from the plate, m", ylabel="probability density, 1/m")
    return max(float(density[1:].max()) for density in densities.values())
