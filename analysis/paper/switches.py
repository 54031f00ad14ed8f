"""The ledger of readings, one switch turned at a time."""

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
from matplotlib.patches import Patch

from analysis.paper import balls
from analysis.paper.balls import SPACES, Base, Share, Space, strike
from analysis.paper.combinations import RADII, STEP, Cases
from analysis.paper.numbers import mark_p
from analysis.paper.printed import P_TEXT
from analysis.writing import Report, data
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS
from longball.model.readings import LEDGER, SCHEME_OPTIONS, ContactForce, readings_of

E = P_TEXT[0]
# Where the ledger has switches of what no at-bat of the paper has: spin, wind, friction, a fence.
VISIBLE = 0.002  # of P: a shorter bar is a line
LABELS = data(__file__)  # of switches with their options, as people say them
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
    scene, sampling, _ = base
    if switch == "contact_force":
        return base._replace(contact_force=cast(ContactForce, option))
    turned = {switch: float(option) if option[0].isdigit() else option}
    try:
        readings = readings_of(scene.reading.model_dump() | sampling.model_dump() | turned)
    except ValueError:
        return None
    scene = scene.model_copy(update={"reading": readings[0]})
    return base._replace(scene=scene, sampling=readings[1])


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
    """Solve a reading by the printed scheme, under each of its switches.

    The defaults come first, without an option.
    """
    turns = [("default", "")]
    chosen = {"contact_force": base.contact_force}
    turns += [
        (entry.switch, option)
        for entry in LEDGER if entry.belongs == "scheme"
        for option in entry.options if option != chosen.get(entry.switch, entry.options[0])
    ]  # fmt: skip
    samples = base.drawn(balls.STEPPED_SAMPLES)
    found, before = [], None
    for switch, option in turns:
        scheme, other = Verlet(dt=STEP), base
        if switch == "contact_force":
            other = base._replace(contact_force=cast(ContactForce, option))
        elif option:
            one: Any = {SCHEME_OPTIONS[switch]: option}
            scheme = replace(scheme, **one)
        (struck,) = balls.strike_in_steps(other, samples, [E], scheme)
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
    # A bar for each option that is seen, from P before to P after, the longest above.
    seen = [one.turned[one.turned["change"].abs() >= VISIBLE] for one in found]
    sizes = [len(rows) for rows in seen]
    size = (6.4, 1.4 + 0.26 * sum(sizes))
    with report.figure("paper_tornado", rows=len(found), size=size) as panels:
        for axes, of, turned in zip(panels, found, seen, strict=True):
            rows = turned.sort_values("change", key=abs, kind="stable")
            heights = np.arange(len(rows))
            axes.barh(
                heights, rows["change"], left=of.before.p, height=0.6,
                color=np.where(rows["change"] > 0, "0.75", "0.35"),
                xerr=2 * rows["change_error"], error_kw={"elinewidth": 0.8, "capsize": 2},
            )  # fmt: skip
            mark_p(axes, of.before.p, "no switch turned", of.name)
            axes.set_yticks(heights, [LABELS.get(name, name) for name in rows["name"]])
            axes.set(xlim=(0.0, None), ylim=(-0.8, len(rows) - 0.2))
            axes.grid(visible=False, axis="y")
        lines, _ = panels[0].get_legend_handles_labels()
        shades = [Patch(color="0.75", label="raises P"), Patch(color="0.35", label="lowers P")]
        place: Any = {"loc": "lower center", "bbox_to_anchor": (0.3, 1.07), "ncols": 4}
        panels[0].legend(handles=[*shades, *lines], **place)
    return report.render(
        "switches", globals(), found=found, schemes=turn_scheme(*cases["nearest"]),
        caption=PAPER_CURVES["caption"],
    )  # fmt: skip
