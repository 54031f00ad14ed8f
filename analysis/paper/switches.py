"""The ledger of readings, one switch turned at a time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pydantic import ValidationError

from analysis.paper.balls import (
    SPACES,
    Balls,
    Base,
    Share,
    Space,
    cores,
    describe,
    strike,
    strike_in_steps,
)
from analysis.paper.combinations import RADII, STEP, Cases
from analysis.paper.printed import P_TEXT
from analysis.writing import figure, shown, table
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS, draw, paper_at_bats
from longball.model.readings import LEDGER, SCHEME_OPTIONS, Reading, SamplingReading

SAMPLES = 100_000
STEPPED_SAMPLES = 40_000
SEED = 1
E = P_TEXT[0]


@dataclass(frozen=True)
class Turned:
    """A reading with one switch turned.

    Attributes
    ----------
    switch, option
        Which, and to what.
    p, change, change_error
        P(0.42), and by how much it is larger than before, with the standard error for the same
        at-bats.
    slope
        dP/de over e = 0.41 to 0.45.
    """

    switch: str
    option: str
    p: float
    change: float
    change_error: float
    slope: float

    @property
    def name(self) -> str:
        """As the figure calls it."""
        return f"{self.switch} = {self.option}"


def options(base: Base, space: Space) -> Iterator[tuple[str, str, Base, Space]]:
    """Yield each switch with each option that is not the one chosen, and what it makes.

    Two that are not in the ledger come last: a ball 0.0366 m wide, and flies alone.
    """
    for entry in LEDGER:
        if entry.switch == "sample_space":
            continue
        for option in entry.options:
            other = turned_to(base, entry.switch, option)
            if other is not None and other != base:
                yield entry.switch, option, other, space
    for other_space in SPACES:
        if other_space != space:
            yield "samples", other_space.name, base, other_space
    for radius in RADII:
        if radius != base.scene.ball.radius:
            yield "ball.radius", f"{radius:g}", base.replaced({"ball.radius": radius}), space


def turned_to(base: Base, switch: str, option: str) -> Base | None:
    """Return a reading with one switch set; None if it has no such switch, or contradicts it."""
    scene, sampling = base
    if switch in SamplingReading.model_fields:
        number = SamplingReading.model_fields[switch].annotation is float
        value = float(option) if number else option
        switches = sampling.model_dump() | {switch: value}
        return Base(scene, SamplingReading.model_validate(switches))
    try:
        reading = Reading.model_validate(scene.reading.model_dump() | {switch: option})
    except ValidationError:
        return None
    return Base(scene.model_copy(update={"reading": reading}), sampling)


def turn(base: Base, space: Space) -> tuple[Share, list[Turned]]:
    """Return P(0.42) of a reading, and all that comes of turning one switch."""
    before = [space.share(balls) for balls in struck(base)]
    at = RESTITUTIONS.index(E)
    found = []
    for switch, option, other, other_space in options(base, space):
        shares = [other_space.share(balls) for balls in struck(other)]
        change, error = shares[at].above(before[at])
        found.append(Turned(switch, option, shares[at].p, change, error, slope(shares)))
    return before[at], found


def struck(base: Base) -> list[Balls]:
    """Return what becomes of the same random numbers under a reading."""
    samples = draw(paper_at_bats(base.sampling), SAMPLES, SEED)
    return strike(base, samples, RESTITUTIONS, threads=cores())


def slope(shares: Sequence[Share]) -> float:
    """Return dP/de from the first restitution to the last."""
    return (shares[-1].p - shares[0].p) / (RESTITUTIONS[-1] - RESTITUTIONS[0])


# --- the printed scheme ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Scheme:
    """The printed scheme with one of its switches turned.

    Attributes
    ----------
    switch, option
        Which, and to what; the first option is the default.
    batted
        The share of pitches that it finds to meet the bat.
    p, p_error
        P(0.42) in the reading's sample space.
    change, change_error
        Against the defaults.
    """

    switch: str
    option: str
    batted: float
    p: float
    p_error: float
    change: float
    change_error: float


def turn_scheme(base: Base, space: Space) -> list[Scheme]:
    """Return what becomes of a reading by the printed scheme, under each of its switches."""
    found = []
    before: Share | None = None
    for entry in (one for one in LEDGER if one.belongs == "scheme"):
        for option in entry.options:
            usual = option == entry.options[0]
            if usual and before:
                continue
            scheme: Any = {"dt": STEP, SCHEME_OPTIONS[entry.switch]: option}
            (balls,) = strike_in_steps(base, STEPPED_SAMPLES, SEED, [E], Verlet(**scheme))
            share = space.share(balls)
            before = before or share
            change, error = share.above(before)
            found.append(
                Scheme(
                    switch="default" if usual else entry.switch,
                    option="" if usual else option,
                    batted=float(balls.batted.mean()),
                    p=share.p,
                    p_error=float(share.influence.std() / np.sqrt(STEPPED_SAMPLES)),
                    change=change,
                    change_error=error,
                )
            )
    return found


# --- the report -----------------------------------------------------------------------------------


def section(report: Path, cases: Cases) -> str:
    """Write the section: each reading with each switch turned."""
    found = {name: turn(base, space) for name, (base, space) in cases.items()}
    draw_tornado(report, found)
    rows = pd.DataFrame(
        [
            {
                "from": name,
                "switch": one.switch,
                "option": one.option,
                f"P({E})": f"{one.p:.4f}",
                "change": f"{one.change:+.5f} ± {one.change_error:.5f}",
                "dP/de": f"{one.slope:.2f}",
            }
            for name, (_, turned) in found.items()
            for one in turned
        ]
    )
    *_, (scheme_base, scheme_space) = cases.values()
    return "\n".join(
        [
            "### One switch at a time\n",
            "[The ledger](README.md#the-ledger-of-readings) has each switch with its reason.\n",
            on_switches(cases, found),
            shown(
                "paper_tornado",
                f"P({E}) with one switch turned, from the default reading and from the one that "
                "comes nearest to the paper's figures (below); the dotted line is the caption's.",
            ),
            table(report, "paper_switches", rows),
            "### The switches of the printed scheme\n",
            on_scheme(report, turn_scheme(scheme_base, scheme_space)),
        ]
    )


def on_switches(cases: Cases, found: dict[str, tuple[Share, list[Turned]]]) -> str:
    """Say which switches move P most, and whether one of them is enough."""
    sentences = [
        f"The same {SAMPLES:,} random at-bats (seed {SEED}) for every reading; ± is the standard "
        "error of the change, which is smaller than that of P itself. The ball 0.0366 m wide and "
        "the flies are not in the ledger: see below."
    ]
    wanted = PAPER_CURVES["caption"](E)
    steep = (PAPER_CURVES["caption"](0.45) - PAPER_CURVES["caption"](0.41)) / 0.04
    for name, (before, turned) in found.items():
        base, space = cases[name]
        still = [one for one in turned if abs(one.change) < 2 * one.change_error]
        order = sorted(turned, key=lambda one: -abs(one.change))
        high = [one for one in turned if one.p >= 0.9 * wanted]
        sentences.append(
            f"**From the {name} reading** ({describe(base, space)}): P({E}) = {before.p:.4f}. Most "
            "is moved by "
            + ", ".join(f"{one.name} ({one.change:+.4f})" for one in order[:3])
            + (f"; not to be seen: {', '.join(one.name for one in still)}." if still else ".")
        )
        reached = ", ".join(
            f"{one.name} ({one.p:.3f}, with dP/de = {one.slope:.2f} for the caption's {steep:.2f})"
            for one in high
        )
        if before.p < 0.9 * wanted:
            sentences.append(
                f"The caption's {wanted:.3f} is reached, or nearly, by {reached}."
                if high
                else f"No switch alone reaches the caption's {wanted:.3f}."
            )
    return " ".join(sentences) + "\n"


def on_scheme(report: Path, found: Sequence[Scheme]) -> str:
    """Say what the readings of the printed scheme do."""
    rows = pd.DataFrame(
        [
            {
                "switch": one.switch,
                "option": one.option,
                "batted, of all pitches": f"{100 * one.batted:.2f} %",
                f"P({E})": f"{one.p:.3f} ± {one.p_error:.3f}",
                "change": f"{one.change:+.3f} ± {one.change_error:.3f}" if one.option else "",
            }
            for one in found
        ]
    )
    seen = [one for one in found if one.option and abs(one.change) > 2 * one.change_error]
    moved = ", ".join(f"{one.switch} = {one.option} ({one.change:+.3f})" for one in seen)
    verdict = "None of them moves P by more than two standard errors."
    if seen:
        verdict = f"More than two standard errors from the default: {moved}."
    return (
        f"They act on velocity Verlet with Δt = {STEP} s alone. The nearest reading, "
        f"{STEPPED_SAMPLES:,} pitches, all but a few of which pass the bat between two steps "
        f"unseen:\n\n{table(report, 'paper_scheme', rows)}\n{verdict}\n"
    )


def draw_tornado(report: Path, found: dict[str, tuple[Share, list[Turned]]]) -> None:
    """Draw a bar for each option, from P before to P after, the longest above."""
    longest = max(len(turned) for _, turned in found.values())
    size = (9.6, 0.6 + 0.24 * longest)
    with figure(report, "paper_tornado", columns=len(found), size=size) as panels:
        for axes, (name, (before, turned)) in zip(panels, found.items(), strict=True):
            order = sorted(turned, key=lambda one: abs(one.change))
            heights = np.arange(longest - len(order), longest)
            axes.barh(
                heights, [one.change for one in order], left=before.p, height=0.6,
                color=["0.75" if one.change > 0 else "0.35" for one in order],
                xerr=[2 * one.change_error for one in order],
                error_kw={"elinewidth": 0.8, "capsize": 2},
            )  # fmt: skip
            axes.axvline(before.p, color="black", linewidth=0.8)
            axes.axvline(PAPER_CURVES["caption"](E), color="black", linestyle=":", linewidth=1.0)
            axes.set_yticks(heights, [one.name for one in order], fontsize="x-small")
            axes.set(xlabel=f"P({E})", title=f"from the {name} reading", ylim=(-0.8, longest))
            axes.set_xlim(left=0.0)
            axes.grid(visible=False, axis="y")
