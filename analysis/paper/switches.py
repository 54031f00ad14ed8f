"""The ledger of readings, one switch turned at a time."""

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.patches import Patch

from analysis.paper import balls
from analysis.paper.balls import SPACES, Base, Share, Space, strike
from analysis.paper.combinations import RADII, STEP, Cases
from analysis.paper.numbers import mark_p
from analysis.paper.printed import P_TEXT
from analysis.writing import Report
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS
from longball.model.readings import LEDGER, SCHEME_OPTIONS, readings_of

E = P_TEXT[0]
# Where the ledger has switches of what no at-bat of the paper has: spin, wind, friction, a fence.
ELSEWHERE = ("extended model", "not in the paper")


def options(base: Base, space: Space) -> Iterator[tuple[str, str, Base, Space]]:
    """Yield each switch with each option that is not the one chosen, and what it makes.

    Two that are not in the ledger come last: a ball 0.0366 m wide, and flies alone.
    """
    for entry in LEDGER:
        if entry.switch == "sample_space" or entry.place in ELSEWHERE:
            continue
        for option in entry.options:
            other = turned_to(base, entry.switch, option)
            if other is not None and other != base:
                yield entry.switch, option, other, space
    yield from (("samples", other.name, base, other) for other in SPACES if other != space)
    for radius in RADII:
        if (other := base.replaced({"ball.radius": radius})) != base:
            yield "ball.radius", f"{radius:g}", other, space


def turned_to(base: Base, switch: str, option: str) -> Base | None:
    """Return a reading with one switch set; None if it has no such switch, or contradicts it."""
    scene, sampling = base
    turned = {switch: float(option) if option[0].isdigit() else option}
    try:
        readings = readings_of(scene.reading.model_dump() | sampling.model_dump() | turned)
    except ValueError:
        return None
    return Base(scene.model_copy(update={"reading": readings[0]}), readings[1])


def turn(base: Base, space: Space) -> tuple[Share, pd.DataFrame]:
    """Return P(0.42) of a reading, and what comes of turning one switch, a row an option.

    The columns: P(0.42); by how much it is larger than before, and the standard error of that for
    the same at-bats; and dP/de over e = 0.41 to 0.45.
    """

    def shares(base: Base, space: Space) -> list[Share]:
        struck = strike(base, base.drawn(), RESTITUTIONS)
        return [space.share(one) for one in struck]

    at = RESTITUTIONS.index(E)
    before = shares(base, space)[at]
    rows = []
    for switch, option, other, other_space in options(base, space):
        after = shares(other, other_space)
        slope = (after[-1].p - after[0].p) / (RESTITUTIONS[-1] - RESTITUTIONS[0])
        rows.append((switch, option, after[at].p, *after[at].above(before), slope))
    columns = ["switch", "option", "p", "change", "change_error", "slope"]
    turned = pd.DataFrame(rows, columns=columns)
    return before, turned.assign(name=turned["switch"] + " = " + turned["option"])


def turn_scheme(base: Base, space: Space) -> list[dict[str, Any]]:
    """Return what becomes of a reading by the printed scheme, under each of its switches.

    The defaults come first, without an option.
    """
    turns = [("default", "")]
    turns += [(x.switch, o) for x in LEDGER if x.belongs == "scheme" for o in x.options[1:]]
    samples = base.drawn(balls.STEPPED_SAMPLES)
    found, before = [], None
    for switch, option in turns:
        chosen: Any = {SCHEME_OPTIONS[switch]: option} if option else {}
        scheme = Verlet(dt=STEP, **chosen)
        (struck,) = balls.strike_in_steps(base, samples, [E], scheme)
        share = space.share(struck)
        before = before or share
        row = {"switch": switch, "option": option, "batted": struck.batted.mean(), "share": share}
        found.append(row | {"change": share.above(before)})
    return found


def section(report: Report, cases: Cases) -> str:
    """Write the section: each reading with each switch turned."""
    found = []
    for name, case in cases.items():
        before, turned = turn(*case)
        found.append(SimpleNamespace(name=name, case=case, before=before, turned=turned))
    # A bar for each option, from P before to P after, the longest above.
    longest = max(len(one.turned) for one in found)
    size = (9.6, 0.6 + 0.24 * longest)
    with report.figure("paper_tornado", columns=len(found), size=size) as panels:
        for axes, of in zip(panels, found, strict=True):
            rows = of.turned.sort_values("change", key=abs, kind="stable")
            heights = np.arange(longest - len(rows), longest)
            axes.barh(
                heights, rows["change"], left=of.before.p, height=0.6,
                color=np.where(rows["change"] > 0, "0.75", "0.35"),
                xerr=2 * rows["change_error"], error_kw={"elinewidth": 0.8, "capsize": 2},
            )  # fmt: skip
            mark_p(axes, of.before.p, "no switch turned", of.name)
            axes.set_yticks(heights, rows["name"], fontsize="x-small")
            axes.set(xlim=(0.0, None), ylim=(-0.8, longest))
            axes.grid(visible=False, axis="y")
        lines, _ = panels[0].get_legend_handles_labels()
        shades = [Patch(color="0.75", label="raises P"), Patch(color="0.35", label="lowers P")]
        panels[0].legend(handles=[*shades, *lines], loc="lower center", fontsize="small")
    return report.render(
        "switches", globals(), found=found, schemes=turn_scheme(*cases["nearest"]),
        caption=PAPER_CURVES["caption"],
    )  # fmt: skip
