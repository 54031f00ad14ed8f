"""The numbers that the paper does not print, and how P depends on all of them."""

import itertools
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from analysis.paper.balls import Base, Share, Space, strike
from analysis.paper.combinations import Cases, Trial, trial
from analysis.paper.distances import NEAR
from analysis.paper.printed import P_TEXT
from analysis.writing import STYLES, figure, render
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Samples, paper_at_bats

SAMPLES = 100_000
CORNER_SAMPLES = 20_000
SEED = 1
E = P_TEXT[0]
STEP = 0.02  # of a number's value: its third order is 1 % of P' where P goes like its tenth power

DATA = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))

Problem = tuple[Base, Samples]


def drawn(base: Base, count: int = SAMPLES) -> Problem:
    """Return an at-bat with its random numbers: the same ones for every reading."""
    return base, base.drawn(count, SEED)


def share(problem: Problem, space: Space) -> Share:
    """Return P at the restitution of the problem's ball."""
    base, samples = problem
    return space.share(strike(base, samples, [base.scene.ball.restitution])[0])


# --- what is not printed --------------------------------------------------------------------------


# In a scene or its sampling: name, unit, low and high end of the range, and their source.
UNKNOWN = tuple(SimpleNamespace(**one) for one in DATA["unknown"])
Change = tuple[float, float]  # of P(0.42), with its standard error


def over_ranges(base: Base, space: Space) -> tuple[Share, list[tuple[Change, Change]]]:
    """Return P(0.42), and what each number alone does to it at the ends of its range."""
    before = share(drawn(base), space)

    def moved(name: str, value: float) -> Change:
        return share(drawn(base.replaced({name: value})), space).above(before)

    return before, [(moved(one.name, one.low), moved(one.name, one.high)) for one in UNKNOWN]


def section(report: Path, cases: Cases) -> str:
    """Write the section: what the unknown numbers do, alone and together."""
    cases = {name: (base.replaced({"ball.restitution": E}), s) for name, (base, s) in cases.items()}
    found = {name: over_ranges(*case) for name, case in cases.items()}
    draw_ranges(report, found)
    names = [one.name for one in UNKNOWN]
    corners: dict[str, list[Trial]] = {name: [] for name in cases}
    for values in itertools.product(*((one.low, one.high) for one in UNKNOWN)):
        for name, (base, space) in cases.items():
            corner = base.replaced(dict(zip(names, values, strict=True)))
            struck = strike(*drawn(corner, CORNER_SAMPLES), RESTITUTIONS)
            corners[name].append(trial(corner, space, struck))
    return render(report, "numbers", globals(), near=NEAR, found=found, corners=corners)


def draw_ranges(report: Path, found: dict[str, tuple[Share, list[tuple[Change, Change]]]]) -> None:
    """Draw P at both ends of each range."""
    heights = np.arange(len(UNKNOWN))[::-1]
    with figure(report, "paper_numbers", columns=len(found), size=(9.0, 3.2)) as panels:
        for axes, (name, (before, ranged)) in zip(panels, found.items(), strict=True):
            for height, (low_end, high_end) in zip(heights, ranged, strict=True):
                ends = np.array([low_end[0], high_end[0]]) + before.p
                axes.plot(ends, [height, height], color="0.6", linewidth=3.0)
                low, high = (None, None) if height else ("low end", "high end")
                axes.plot(ends[0], height, **STYLES["measured"], label=low)
                axes.plot(ends[1], height, "s", color="black", label=high)
            axes.axvline(before.p, color="black", linewidth=0.8, label="printed or default")
            caption = PAPER_CURVES["caption"](E)
            axes.axvline(caption, color="black", linestyle=":", label="paper's caption")
            labels = [f"{one.name}\n{one.low:g} to {one.high:g} {one.unit}" for one in UNKNOWN]
            axes.set_yticks(heights, labels, fontsize="small")
            axes.set(xlabel=f"P({E})", title=f"from the {name} reading")
            axes.set_ylim(-0.6, len(UNKNOWN) - 0.4)
            axes.set_xlim(left=-0.004)  # a mark at 0 is seen whole
            axes.locator_params(axis="x", nbins=5)
        panels[0].legend(fontsize="small", loc="center", bbox_to_anchor=(0.62, 0.5))


# --- sensitivities --------------------------------------------------------------------------------


class Parameter(NamedTuple):
    """A number that P depends on."""

    name: str
    unit: str
    value: Callable[[Problem], float]
    # The problem with the number multiplied by a factor, the random numbers left alone.
    scaled: Callable[[Problem, float], Problem]


def of_scene(name: str, unit: str) -> Parameter:
    """Return a number of the scene, or of the sampling, which changes what is drawn."""

    def scaled(problem: Problem, factor: float) -> Problem:
        base, samples = problem
        other = base.replaced({name: factor * base.number(name)})
        return (other, samples) if other.sampling == base.sampling else drawn(other, len(samples))

    return Parameter(name, unit, lambda problem: problem[0].number(name), scaled)


def _heights_scaled(problem: Problem, factor: float) -> Problem:
    base, samples = problem
    heights = ("pitch.release[2]", "pitch.aim[1]")
    return base.replaced({name: factor * base.number(name) for name in heights}), samples


PARAMETERS = (
    *(of_scene(name, unit) for name, unit in DATA["parameters"].items()),
    Parameter(
        "all pitch speeds, their mean", "m/s",
        lambda problem: float(problem[1].speed.mean()),
        lambda problem, factor: (problem[0], replace(problem[1], speed=factor * problem[1].speed)),
    ),
    Parameter(
        "largest tilt", "rad",
        lambda problem: paper_at_bats(problem[0].sampling).largest_tilt,
        lambda problem, factor: (problem[0], replace(problem[1], tilt=factor * problem[1].tilt)),
    ),
    Parameter(
        "heights of release and aim", "m",
        lambda problem: problem[0].scene.pitch.release[2],
        _heights_scaled,
    ),
)  # fmt: skip


def sensitivities(report: Path, cases: Cases) -> str:
    """Write the section: ∂P/∂x and d ln P / d ln x of a number x at each of the two readings.

    By the central difference over ± 2 % with the same random numbers, with its standard error.
    """
    found: dict[str, list[dict[str, Any]]] = {}
    for name, (base, space) in cases.items():
        problem = drawn(base.replaced({"ball.restitution": E}))
        p = share(problem, space).p
        found[name] = []
        for one in PARAMETERS:
            above, below = (share(one.scaled(problem, 1 + x), space) for x in (STEP, -STEP))
            value, (rise, error) = one.value(problem), above.above(below)
            row = {"slope": rise / (2 * STEP * value), "slope_error": error / (2 * STEP * value)}
            row |= {"power": rise / (2 * STEP * p), "power_error": error / (2 * STEP * p)}
            found[name].append(row | {"parameter": one, "value": value})
    return render(report, "sensitivities", globals(), found=found)


def strongest(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the three numbers that change P most."""
    return sorted(rows, key=lambda row: -abs(row["power"]))[:3]
