"""Every combination of readings that matters, against the paper's Figs. 6 and 7."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from analysis.paper.balls import (
    SPACES,
    Balls,
    Base,
    Space,
    cores,
    describe,
    strike,
    strike_in_steps,
)
from analysis.paper.distances import (
    BIN,
    HEIGHT_AND_SLOPE,
    NEAR,
    NEAR_BOTH,
    Distance,
    Peak,
    covariance,
    distance,
    highest,
    peak,
    total,
)
from analysis.paper.printed import P_TEXT, PEAKS
from analysis.paper.printed import SAMPLES as PAPER_SAMPLES
from analysis.writing import figure, markdown_table, shown, table
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Estimate, draw, paper_at_bats
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene, Ball

Array = NDArray[np.float64]

SAMPLES = 10_000  # a combination, at first; ten times the paper's
CLOSER_SAMPLES = 50_000  # of those that come near
CLOSEST_SAMPLES = 500_000  # of those that may be it
WITHIN = 4 * NEAR  # of Fig. 7 at first sight: worth a closer look
FEWEST = 100  # balls that a sample space must have at first sight
SEED = 1

# The readings of the collision that differ. With μ from M_eff the printed ẽ gives
# μ (1 + ẽ) = m (1 + e), whatever M_eff is; plain has no M_eff. The thin rod's inertia is the
# cylinder's to 0.1 %.
BLOWS: tuple[dict[str, Any], ...] = (
    *(
        {"bat_ball_restitution": restitution, "effective_mass": mass, "inertia": inertia}
        for restitution in ("as_printed", "nathan")
        for mass in ("inertia_over_r_squared", "as_printed")
        for inertia in ("solid_cylinder", "about_centre")
    ),
    {"reduced_mass": "effective_mass"},
    {"bat_ball_restitution": "plain"},
)
OFFSET_SPREADS = (0.0366, 0.0732)  # m
# m; a third of the plate, and of the plate and a ball's width, for a ball 0.0366 m or 0.0732 m
# wide; and one narrower and one wider.
CELL_WIDTHS = (0.12, 0.144, 0.156, 0.168, 0.2)
PLATE = 0.432  # m, its width
RADII = (0.0366, 0.0183)  # m, of the ball; the paper calls 0.0366 m its diameter


def bases() -> Iterator[Base]:
    """Yield the at-bats of all combinations but for the sample spaces, which cost nothing."""
    for blow, offset, width, radius in itertools.product(BLOWS, OFFSET_SPREADS, CELL_WIDTHS, RADII):
        reading = Reading.model_validate(blow)
        yield Base(
            AtBatScene(id="base", ball=Ball(radius=radius), reading=reading),
            SamplingReading(offset_spread=offset, cell_width=width),
        )


@dataclass(frozen=True)
class Trial:
    """A reading held against the paper.

    Attributes
    ----------
    base, space
        The reading.
    rows
        P at the five restitutions.
    mode
        m, the middle of the highest bin of D, by restitution.
    low
        The share of D in the first bin, at the lowest restitution.
    to
        Distances to Fig. 7's curves, by their names, with samples of their own for each e.
    peaks
        The paper's Fig. 6 against it, by restitution; empty at first sight.
    """

    base: Base
    space: Space
    rows: list[Estimate]
    mode: dict[float, float]
    low: float
    to: dict[str, Distance]
    peaks: dict[float, Peak]

    @property
    def name(self) -> str:
        """What it differs in from the default."""
        return describe(self.base, self.space)

    @property
    def shared(self) -> Distance:
        """The distance to the caption's curve if the paper took the same samples for all e."""
        return distance(self.rows, PAPER_CURVES["caption"], shared=True)

    @property
    def both(self) -> float:
        """Distance to both figures together."""
        return total(self.to["caption"], list(self.peaks.values()))

    def p(self, e: float) -> float:
        """Return P at one of the restitutions."""
        return next(row.p for row in self.rows if row.e == e)


def tried(base: Base) -> list[Trial]:
    """Return what a combination gives at first sight, in the sample spaces with balls enough."""
    struck = strike(base, draw(paper_at_bats(base.sampling), SAMPLES, SEED), RESTITUTIONS)
    return [
        trial(base, space, struck)
        for space in SPACES
        if space.estimate(RESTITUTIONS[0], struck[0]).trials >= FEWEST
    ]


def closer(base: Base, spaces: Sequence[Space], count: int) -> list[Trial]:
    """Return what a combination gives with more samples, the peaks of Fig. 6 with it."""
    struck = strike(base, draw(paper_at_bats(base.sampling), count, SEED), RESTITUTIONS)
    return [with_peaks(trial(base, space, struck), struck) for space in spaces]


def trial(base: Base, space: Space, struck: Sequence[Balls]) -> Trial:
    """Hold struck balls against Fig. 7."""
    rows = [space.estimate(e, one) for e, one in zip(RESTITUTIONS, struck, strict=True)]
    flown = {e: space.distances(one) for e, one in zip(RESTITUTIONS, struck, strict=True)}
    return Trial(
        base=base,
        space=space,
        rows=rows,
        mode={e: highest(flown[e]) for e in PEAKS},
        low=float(np.mean(flown[min(PEAKS)] < BIN)),
        to={name: distance(rows, curve) for name, curve in PAPER_CURVES.items()},
        peaks={},
    )


def with_peaks(one: Trial, struck: Sequence[Balls]) -> Trial:
    """Hold struck balls against Fig. 6, too."""
    generator = np.random.default_rng(SEED)
    peaks = {}
    for row, balls in zip(one.rows, struck, strict=True):
        if row.e in PEAKS:
            flown = one.space.distances(balls)
            peaks[row.e] = peak(row.e, flown, len(flown) / row.trials, generator)
    return replace(one, peaks=peaks)


# --- the study ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Study:
    """Every combination at first sight, and the near ones seen closer, the nearest first."""

    first: list[Trial]
    near: list[Trial]

    @property
    def best(self) -> Trial:
        """The reading that comes nearest to Figs. 6 and 7 together."""
        return self.near[0]


@cache
def study() -> Study:
    """Try all combinations; several sections ask for what comes of it."""
    everything = joblib.Parallel(n_jobs=-1, prefer="threads")(
        joblib.delayed(tried)(base) for base in bases()
    )
    worth = [
        (trials[0].base, spaces)
        for trials in everything
        if trials
        and (spaces := [one.space for one in trials if one.to["caption"].squared <= WITHIN])
    ]
    looked = joblib.Parallel(n_jobs=-1, prefer="threads")(
        joblib.delayed(closer)(*one, CLOSER_SAMPLES) for one in worth
    )
    near = [one for trials in looked for one in trials]
    closest = joblib.Parallel(n_jobs=-1, prefer="threads")(
        joblib.delayed(closer)(one.base, [one.space], CLOSEST_SAMPLES)
        for one in near
        if one.both <= 2 * NEAR_BOTH
    )
    again = [one for trials in closest for one in trials]
    done = [one.name for one in again]
    near = again + [one for one in near if one.name not in done]
    return Study(
        first=[one for trials in everything for one in trials],
        near=sorted(near, key=lambda one: one.both),
    )


@cache
def default_trial() -> Trial:
    """Return the ledger's defaults, seen as close as the near readings."""
    return closer(Base(AtBatScene(id="base")), SPACES[:1], CLOSEST_SAMPLES)[0]


Cases = dict[str, tuple[Base, Space]]


def cases() -> Cases:
    """Return the two readings that are looked at closely: the default, and the nearest."""
    both = {"default": default_trial(), "nearest": study().best}
    return {name: (one.base, one.space) for name, one in both.items()}


# --- the paper's scheme ---------------------------------------------------------------------------

STEP = 0.05  # s, as printed
STEPPED_SAMPLES = 60_000  # most of them pass the bat unseen


@dataclass(frozen=True)
class Stepped:
    """A reading by the paper's scheme with its step.

    Attributes
    ----------
    exact
        The same reading without it.
    rows
        P at the five restitutions, in the same sample space.
    batted, batted_exactly
        Shares of the pitches.
    of_pitches
        The home runs at each restitution as shares of all pitches.
    """

    exact: Trial
    rows: list[Estimate]
    batted: float
    batted_exactly: float
    of_pitches: list[Estimate]


def stepped(exact: Trial) -> Stepped:
    """Take a reading's at-bats with the paper's scheme."""
    base = exact.base
    by_steps = strike_in_steps(base, STEPPED_SAMPLES, SEED, RESTITUTIONS, Verlet(STEP))
    samples = draw(paper_at_bats(base.sampling), STEPPED_SAMPLES, SEED)
    exactly = strike(base, samples, RESTITUTIONS[:1], threads=cores())[0]
    at = list(zip(RESTITUTIONS, by_steps, strict=True))
    return Stepped(
        exact=exact,
        rows=[exact.space.estimate(e, one) for e, one in at],
        batted=float(by_steps[0].batted.mean()),
        batted_exactly=float(exactly.batted.mean()),
        of_pitches=[SPACES[0].estimate(e, one) for e, one in at],
    )


# --- the report -----------------------------------------------------------------------------------


def section(report: Path, found: Study, default: Trial, by_steps: Sequence[Stepped]) -> str:
    """Write the section of the combinations."""
    draw_plane(report, found, default)
    seventh = frame(sorted(found.near, key=lambda one: one.to["caption"].squared)[:6])
    lowest = min(found.first, key=lambda one: one.to["text"].squared)
    parts = [
        "### All combinations\n",
        on_the_grid(found),
        on_the_distance(),
        on_grounders(found),
        shown(
            "paper_combinations",
            "Height and slope of P(e) over e = 0.41 to 0.45: every combination of readings, and "
            "the two curves that the paper prints for its Fig. 7, with the 95 % that 1,000 samples "
            "a point leave open about the caption's.",
        ),
        on_the_count(found, default),
        "The nearest to both figures:\n",
        table(report, "paper_nearest", frame(found.near[:12])),
        "The nearest to Fig. 7 alone:\n",
        markdown_table(list(seventh.columns), seventh.to_numpy().tolist()),
        on_the_best(found.best),
        f"To the curve of the text the nearest of all is “{lowest.name}”, with d² = "
        f"{lowest.to['text'].squared:.1f} and P(0.42) = {lowest.p(0.42):.3f}, which is not the "
        f"{P_TEXT[1]:g} that the same text gives.\n",
        "### The printed scheme\n",
        *(on_steps(one) for one in by_steps),
        "### What stays unexplained\n",
        unexplained(found, by_steps),
    ]
    return "\n".join(parts)


def on_the_grid(found: Study) -> str:
    """Say what was tried."""
    solved = len(list(bases()))
    dropped = solved * len(SPACES) - len(found.first)
    widths = ", ".join(f"{width:g}" for width in CELL_WIDTHS)
    printed = paper_at_bats(SamplingReading(speed_table="as_printed"))
    backwards = 1 - draw(printed, SAMPLES, SEED).pitched.mean()
    return (
        f"{len(BLOWS)} blows that differ (`bat_ball_restitution`, `effective_mass`, "
        "`reduced_mass`, `inertia`), both spreads of the offset, "
        f"cells of {widths} m, a ball with a radius of 0.0366 m or of 0.0183 m (the paper "
        "calls 0.0366 m its diameter, and prints no other size), and five sample spaces: the "
        "ledger's three, and among the batted and the fair balls those that leave the bat "
        f"upwards. These are {solved} × {len(SPACES)} = {solved * len(SPACES):,} readings; "
        f"{dropped} have fewer than {FEWEST} balls among {SAMPLES:,} pitches and are left out. The "
        "speeds stay as Fig. 2 and Table II together demand: with the columns as printed "
        f"{100 * backwards:.0f} % of the pitches would fly away from the plate, and Eq. 2 as "
        "printed is not the curve of Fig. 2 (above). The other switches are turned one at a time "
        "about the nearest reading, above. Each reading was struck with the same "
        f"{SAMPLES:,} at-bats (seed {SEED}); the {len(found.near)} that came within d² = "
        f"{WITHIN:.0f} of the caption's curve, with {CLOSER_SAMPLES:,}; and those of them within "
        f"{2 * NEAR_BOTH:.0f} of both figures, with {CLOSEST_SAMPLES:,}.\n"
    )


def on_the_distance() -> str:
    """Say what the distance is."""
    return (
        "**The distance.** The paper prints a curve fitted to five points of "
        f"{PAPER_SAMPLES:,} samples each. "
        "Over so short a range it has a height and a slope, and a fit keeps those of its points. "
        "d² is the squared difference in both from a reading, in units of the covariance that "
        f"{PAPER_SAMPLES:,} samples a point give it (and that our own samples add). If a reading "
        "is the paper's, d² is a χ² with 2 degrees of freedom; 95 % of the time it is below "
        f"{NEAR:.2f}. The highest peaks of Fig. 6 have a chance each, by drawing "
        f"{PAPER_SAMPLES:,} samples over and over into a histogram in steps of 10 m: twice the "
        "chance of a highest bin as far as the paper's or farther (or as near or nearer, whichever "
        "is smaller). Fisher's rule adds -2 ln p of both to "
        f"d²; 95 % of the time the sum is below {NEAR_BOTH:.2f}.\n"
    )


def on_grounders(found: Study) -> str:
    """Say what Fig. 6 has to say about balls that are hit downwards."""
    everything = [one for one in found.first if not one.space.flies]
    first = [one for one in everything if all(m < BIN for m in one.mode.values())]
    flies = [one for one in found.first if one.space.flies]
    moved = [one for one in flies if any(m > BIN for m in one.mode.values())]
    least = min(one.low for one in everything)
    told = "So Fig. 6 does not tell whether such balls are counted."
    if len(first) > 0.99 * len(everything):
        told = (
            "The paper's highest peaks are at 75 m and 125 m. So the balls that are hit downwards "
            "are not in its Fig. 6, though its text does not say so, and so two sample spaces "
            f"of flies were added. Of their {len(flies)} readings {len(moved)} have it elsewhere."
        )
    return (
        f"**Fig. 6 and the ground.** Of {len(everything)} readings that count every batted ball, "
        f"{len(first)} have their highest peak below 10 m at both restitutions, where balls hit "
        f"downwards land: at least {100 * least:.0f} % of D is there. {told}\n"
    )


def on_the_count(found: Study, default: Trial) -> str:
    """Say how many readings cannot be told from the paper."""
    near = [one for one in found.near if one.to["caption"].near]
    both = [one for one in found.near if one.both <= NEAR_BOTH]
    usual = [one for one in near if one.base.scene.ball.radius == default.base.scene.ball.radius]
    ledger = [one for one in usual if not one.space.flies]
    inside = [one for one in found.near if not beyond(one)] or [
        one for one in found.first if not beyond(one)
    ]
    nearest = min(inside, key=lambda one: one.to["caption"].squared)
    many = f"**{len(both)}** of them can" if both else "**None** of them can"
    next_best = "" if both else f"; the nearest is at {found.best.both:.1f}"
    return (
        f"**How many.** The default reading is at d² = {default.to['caption'].squared:,.0f}. "
        f"{len(near)} of {len(found.first):,} readings cannot be told from the caption's curve at "
        f"95 %: {len(ledger)} of the ledger's switches alone, {len(usual)} with a ball of the "
        f"usual size. Within the ledger, with that ball, “{nearest.name}” comes nearest, at "
        f"d² = {nearest.to['caption'].squared:.1f}. {many} have the peaks of Fig. 6 as well "
        f"(sum below {NEAR_BOTH:.2f}){next_best}.\n"
    )


def frame(trials: Sequence[Trial]) -> pd.DataFrame:
    """Return the table of readings against Figs. 6 and 7."""
    return pd.DataFrame(
        [
            {
                "reading": one.name,
                "P(0.41)": f"{one.p(0.41):.4f}",
                "P(0.43)": f"{one.p(0.43):.4f}",
                "P(0.45)": f"{one.p(0.45):.4f}",
                "height, σ": f"{one.to['caption'].level:+.1f}",
                "slope, σ": f"{one.to['caption'].slope:+.1f}",
                "d²": f"{one.to['caption'].squared:.2f}",
                "d², shared samples": f"{one.shared.squared:.2f}",
                **{
                    f"peak at e = {e}, m": f"{peak.ours:g} (p = {peak.p_value:.3f})"
                    for e, peak in one.peaks.items()
                },
                "with Fig. 6": f"{one.both:.1f}",
            }
            for one in trials
        ]
    )


def on_the_best(best: Trial) -> str:
    """Say what the nearest reading is, and how far it is."""
    curve = PAPER_CURVES["caption"]
    off = max(abs(one.p - curve(one.e)) for one in best.rows)
    noise = math.sqrt(best.p(0.43) * (1 - best.p(0.43)) / PAPER_SAMPLES)
    listed = ", ".join(f"P({one.e}) = {one.p:.4f} ({curve(one.e):.4f})" for one in best.rows)
    said = (
        f"**The nearest**: {best.name}. It has {listed}, the caption's curve in brackets: off by "
        f"{off:.4f} at most, {off / noise:.1f} times the noise of {PAPER_SAMPLES:,} samples. "
    )
    if best.base.scene.reading.reduced_mass == "effective_mass":
        said += (
            "Its collision is the paper's formula with one effective mass throughout: then "
            "μ (1 + ẽ) = m (1 + e), a ball is struck as by a bat of infinite mass with the "
            "restitution e, and neither the bat's mass nor its inertia matters, which the paper "
            "does not print. "
        )
    if best.base.scene.ball.radius == min(RADII):
        said += (
            "Its ball is 0.0366 m wide, as the paper has it: a quarter of a baseball's cross "
            "section, and so of its drag and lift. "
        )
    zone = PLATE + 2 * best.base.scene.ball.radius
    if abs(3 * best.base.sampling.cell_width - zone) < 0.001:
        said += (
            f"Three of its cells, {3 * best.base.sampling.cell_width:.3f} m, are the plate and one "
            "such ball: the zone that some part of the ball crosses. "
        )
    return said + "\n"


def on_steps(one: Stepped) -> str:
    """Say what the printed scheme does to a reading."""
    exact = one.exact
    rows, inside = [], 0
    for row, true, whole in zip(one.rows, exact.rows, one.of_pitches, strict=True):
        inside += row.low <= true.p <= row.high
        interval, counts = f"{row.low:.4f} to {row.high:.4f}", f"{row.home_runs} of {row.trials}"
        p = [f"{true.p:.4f}", f"{row.p:.4f}", interval, counts, f"{whole.p:.5f}"]
        rows.append([f"{row.e:g}", *p])
    away = distance(one.rows, PAPER_CURVES["caption"])
    smaller = "As a share of all pitches P is that much smaller. "
    return (
        f"“{exact.name}” by velocity Verlet with Δt = {STEP} s, as printed: of "
        f"{STEPPED_SAMPLES:,} pitches {100 * one.batted:.1f} % are seen to meet the bat, of "
        f"{100 * one.batted_exactly:.1f} % that do. "
        f"{smaller if exact.space.name != 'pitches' else ''}"
        f"Among its own samples ({exact.space.name}), P without the scheme lies inside the "
        f"interval of 95 % at {inside} of {len(rows)} restitutions; d² from the caption's curve is "
        f"{away.squared:,.1f}, "
        f"{'and so it still cannot be told from it' if away.near else 'so that it is not it'}.\n\n"
        + markdown_table(["e", "P", f"P at {STEP} s", "95 %", "home runs", "of all pitches"], rows)
    )


def unexplained(found: Study, by_steps: Sequence[Stepped]) -> str:
    """List what no reading explains, or the nearest does not."""
    best = found.best
    both = [one for one in found.near if one.both <= NEAR_BOTH]
    listed = []
    for e, peak_there in best.peaks.items():
        if peak_there.p_value < 0.05:
            listed.append(
                f"The peak at {PEAKS[e]:g} m for e = {e}: the nearest reading has it at "
                f"{peak_there.ours:g} m most often (p = {peak_there.p_value:.3f})."
            )
    if best.space.flies:
        listed.append(
            "Why only balls that leave the bat upwards"
            + (" and land fair" if best.space.ledger == "fair" else "")
            + " would be the samples: the text says nothing of it."
        )
    if best.base.scene.ball.radius == min(RADII):
        listed.append(
            "Whether the ball of the paper's program was 0.0366 m wide: the text says so, and the "
            "nearest readings say so, but nothing else does."
        )
    far = PAPER_CURVES["text"](0.42) - best.p(0.42)
    listed.append(
        "Where the text's C₁ = 271 m and σ = 59.8 m come from: the nearest reading has "
        f"{best.p(0.42):.3f} at e = 0.42, and that curve {far:+.3f} of it."
    )
    for one in by_steps:
        if one.exact is best and distance(one.rows, PAPER_CURVES["caption"]).near:
            listed.append(
                f"Whether the step was {STEP} s: with it, {1 / one.batted:.0f} pitches must be "
                "thrown for one that is batted, but P among the batted hardly changes."
            )
    last = "Both figures together: no reading tried gives them."
    if len(both) > 1:
        last = (
            f"Which of {len(both)} readings it was: the two figures do not tell them apart; and of "
            f"{len(found.first):,} that were tried, with the width of a cell free, one or another "
            "may come near both by chance."
        )
    elif both:
        last = (
            "That one reading alone comes near both figures may be chance: "
            f"{len(found.first):,} were tried, and the width of a cell is free."
        )
    listed.append(last)
    return "\n".join(f"- {line}" for line in listed) + "\n"


def draw_plane(report: Path, found: Study, default: Trial) -> None:
    """Draw all readings by height and slope of P(e)."""
    groups = {
        "in the ledger": ("o", [t for t in found.first if not beyond(t)]),
        "ball 0.0366 m wide, or flies only": ("+", [t for t in found.first if beyond(t)]),
    }
    with figure(report, "paper_combinations", size=(6.8, 4.6)) as (axes,):
        for (name, (marker, trials)), grey in zip(groups.items(), ("0.55", "0.25"), strict=True):
            p = np.array([[row.p for row in one.rows] for one in trials])
            axes.plot(
                *(HEIGHT_AND_SLOPE @ p.T), marker, color=grey, markersize=4, markerfacecolor="none",
                linestyle="none", label=name,
            )  # fmt: skip
        for (name, curve), marker in zip(PAPER_CURVES.items(), "*X", strict=True):
            p = np.array([curve(e) for e in RESTITUTIONS])
            axes.plot(*(HEIGHT_AND_SLOPE @ p.T), marker, color="C3", markersize=12, label=name)
            if name == "caption":
                axes.plot(*noise(p), "--", color="C3", linewidth=1.0)
        for one, marker, name in ((default, "s", "default"), (found.best, "D", "nearest to both")):
            p = np.array([row.p for row in one.rows])
            axes.plot(*(HEIGHT_AND_SLOPE @ p.T), marker, color="C0", markersize=7, label=name)
        axes.set(
            xlabel="height: mean of P(e) over e = 0.41 to 0.45",
            ylabel="slope dP/de",
            xlim=(-0.01, 0.45),
            ylim=(-0.5, 3.0),
        )
        axes.legend(loc="upper left", fontsize="small")


def beyond(one: Trial) -> bool:
    """Tell whether the ledger's switches alone do not make a reading."""
    return one.space.flies or one.base.scene.ball.radius == min(RADII)


def noise(p: Array) -> Array:
    """Return the ellipse of 95 % that 1,000 samples a point leave open: heights and slopes."""
    spread = HEIGHT_AND_SLOPE @ covariance(p, shared=False) @ HEIGHT_AND_SLOPE.T / PAPER_SAMPLES
    turn = np.linspace(0.0, 2 * np.pi, 200)
    around: Array = np.linalg.cholesky(NEAR * spread) @ np.array([np.cos(turn), np.sin(turn)])
    return around + (HEIGHT_AND_SLOPE @ p)[:, None]
