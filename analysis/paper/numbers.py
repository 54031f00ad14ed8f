"""The numbers that the paper does not print, and how P depends on all of them."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from analysis.paper import balls
from analysis.paper.balls import Base, Share, Space, strike
from analysis.paper.combinations import Cases, Trial, trial
from analysis.paper.distances import NEAR
from analysis.paper.printed import P_TEXT
from analysis.writing import STYLES, Report, data
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Samples, paper_at_bats

CORNER_SAMPLES = 20_000
E = P_TEXT[0]
STEP = 0.02  # of a number's value: its third order is 1 % of P' where P goes like its tenth power

DATA = data(__file__)

Problem = tuple[Base, Samples]


def drawn(base: Base, count: int = balls.SAMPLES) -> Problem:
    """Return an at-bat with its random numbers: the same ones for every reading."""
    return base, base.drawn(count)


def share(problem: Problem, space: Space) -> Share:
    """Return P at the restitution of the problem's ball."""
    base, samples = problem
    return space.share(strike(base, samples, [base.scene.ball.restitution])[0])


# In a scene or its sampling: name, unit, low and high end of the range, and their source.
UNKNOWN = tuple(SimpleNamespace(**one) for one in DATA["unknown"])


def section(report: Report, cases: Cases) -> str:
    """Write the section: what the unknown numbers do, alone and together."""
    cases = {name: (base.replaced({"ball.restitution": E}), s) for name, (base, s) in cases.items()}
    found = {}
    # P(0.42), and its changes by each number alone at both ends of its range, with their errors.
    for name, (base, space) in cases.items():
        before = share(drawn(base), space)
        others = [[base.replaced({one.name: x}) for x in (one.low, one.high)] for one in UNKNOWN]
        changes = [[share(drawn(x), space).above(before) for x in ends] for ends in others]
        found[name] = before, changes
    heights = np.arange(len(UNKNOWN))[::-1]
    with report.figure("paper_numbers", rows=len(found), size=(6.4, 6.4)) as panels:
        for axes, (name, (before, ranged)) in zip(panels, found.items(), strict=True):
            low, high = before.p + np.array(ranged)[:, :, 0].T
            axes.plot([low, high], [heights, heights], color="0.6", linewidth=3.0)
            axes.plot(low, heights, **STYLES["measured"], label="low end")
            axes.plot(high, heights, "s", color="black", label="high end")
            mark_p(axes, before.p, "as it is", name)
            labels = [f"{one.label},\n{one.low:g} to {one.high:g} {one.unit}" for one in UNKNOWN]
            axes.set_yticks(heights, labels)
            # A mark at 0 is seen whole.
            axes.set(xlim=(-0.004, None), ylim=(-0.6, len(UNKNOWN) - 0.4))
            axes.locator_params(axis="x", nbins=5)
        panels[0].legend(loc="lower center", bbox_to_anchor=(0.4, 1.08), ncols=4)
    ends = itertools.product(*([(one.name, one.low), (one.name, one.high)] for one in UNKNOWN))
    corners: dict[str, list[Trial]] = {name: [] for name in cases}
    for values, (name, (base, space)) in itertools.product(ends, cases.items()):
        corner = base.replaced(dict(values))
        struck = strike(*drawn(corner, CORNER_SAMPLES), RESTITUTIONS)
        corners[name].append(trial(corner, space, struck, 0))
    return report.render("numbers", globals(), near=NEAR, found=found, corners=corners)


def mark_p(axes: Axes, p: float, label: str, reading: str) -> None:
    """Draw the P of a reading and the caption's across a panel of changes of P."""
    axes.axvline(p, color="black", linewidth=0.8, label=label)
    caption = PAPER_CURVES["caption"](E)
    axes.axvline(caption, color="black", linestyle=":", label="Fig. 7, caption")
    axes.set(xlabel=f"P({E})", title=f"from the {reading} reading")


class Parameter(NamedTuple):
    """Numbers that P depends on and that change together."""

    name: str
    unit: str
    keys: Sequence[str] = ()  # of a scene or its sampling
    column: str = ""  # of the random numbers, if it is one of these

    def value(self, problem: Problem) -> float:
        """Return the first of them."""
        base, samples = problem
        if self.column == "tilt":
            return paper_at_bats(base.sampling).largest_tilt
        return float(samples.speed.mean()) if self.column else base.number(self.keys[0])

    def scaled(self, problem: Problem, factor: float) -> Problem:
        """Return the problem with the numbers multiplied, the random numbers left alone."""
        base, samples = problem
        if self.column:
            column = factor * getattr(samples, self.column)
            return base, replace(samples, **{self.column: column})
        other = base.replaced({key: factor * base.number(key) for key in self.keys})
        return (other, samples) if other.sampling == base.sampling else drawn(other, len(samples))


PARAMETERS = tuple(Parameter(**one) for one in DATA["parameter"])


def sensitivities(report: Report, cases: Cases) -> str:
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
            rise, error = (change / (2 * STEP) for change in above.above(below))
            value = one.value(problem)
            row = {"slope": rise / value, "slope_error": error / value, "parameter": one}
            found[name].append(row | {"power": rise / p, "power_error": error / p, "value": value})
    return report.render("sensitivities", globals(), found=found)
