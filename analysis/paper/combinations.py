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
from analysis.writing import STYLES, figure, render
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

    @property
    def inside(self) -> int:
        """At how many restitutions the interval of 95 % has P without the scheme inside."""
        return sum(
            row.low <= exact.p <= row.high
            for row, exact in zip(self.rows, self.exact.rows, strict=True)
        )

    @property
    def away(self) -> Distance:
        """The distance to the caption's curve."""
        return distance(self.rows, PAPER_CURVES["caption"])


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
    best, curve = found.best, PAPER_CURVES["caption"]
    everything = [one for one in found.first if not one.space.flies]
    flies = [one for one in found.first if one.space.flies]
    near = [one for one in found.near if one.to["caption"].near]
    usual = [one for one in near if one.base.scene.ball.radius == default.base.scene.ball.radius]
    inside = [one for one in found.near if not beyond(one)] or [
        one for one in found.first if not beyond(one)
    ]
    solved = len(list(bases()))
    printed = paper_at_bats(SamplingReading(speed_table="as_printed"))
    return render(
        report,
        "combinations",
        found=found,
        default=default,
        best=best,
        blows=len(BLOWS),
        widths=CELL_WIDTHS,
        solved=solved,
        spaces=len(SPACES),
        dropped=solved * len(SPACES) - len(found.first),
        fewest=FEWEST,
        backwards=1 - draw(printed, SAMPLES, SEED).pitched.mean(),
        samples=SAMPLES,
        closer_samples=CLOSER_SAMPLES,
        closest_samples=CLOSEST_SAMPLES,
        paper_samples=PAPER_SAMPLES,
        stepped_samples=STEPPED_SAMPLES,
        seed=SEED,
        within=WITHIN,
        near=NEAR,
        near_both=NEAR_BOTH,
        peaks=PEAKS,
        everything=everything,
        grounded=[one for one in everything if all(m < BIN for m in one.mode.values())],
        flies=flies,
        moved=sum(any(m > BIN for m in one.mode.values()) for one in flies),
        near_ones=near,
        both=[one for one in found.near if one.both <= NEAR_BOTH],
        usual=usual,
        ledger=[one for one in usual if not one.space.flies],
        nearest=min(inside, key=lambda one: one.to["caption"].squared),
        seventh=sorted(found.near, key=lambda one: one.to["caption"].squared)[:6],
        curve=curve,
        off=max(abs(one.p - curve(one.e)) for one in best.rows),
        noise=math.sqrt(best.p(0.43) * (1 - best.p(0.43)) / PAPER_SAMPLES),
        small=min(RADII),
        plate=PLATE,
        lowest=min(found.first, key=lambda one: one.to["text"].squared),
        text=PAPER_CURVES["text"],
        p_text=P_TEXT[1],
        by_steps=by_steps,
        step=STEP,
    )


def draw_plane(report: Path, found: Study, default: Trial) -> None:
    """Draw all readings by height and slope of P(e)."""
    groups = {
        "in the ledger": ("o", "0.55", [t for t in found.first if not beyond(t)]),
        "ball 0.0366 m wide, or flies only": ("+", "0.25", [t for t in found.first if beyond(t)]),
    }
    with figure(report, "paper_combinations", size=(6.8, 4.6)) as (axes,):

        def mark(p: Array, **style: Any) -> None:
            axes.plot(*(HEIGHT_AND_SLOPE @ p.T), **style | {"linestyle": "none"})

        for name, (marker, grey, trials) in groups.items():
            p = np.array([[row.p for row in one.rows] for one in trials])
            mark(p, marker=marker, color=grey, markersize=4, markerfacecolor="none", label=name)
        for name, curve in PAPER_CURVES.items():
            p = np.array([curve(e) for e in RESTITUTIONS])
            mark(p, **STYLES[f"paper's {name}"], markersize=11, label=f"paper's {name}")
            if name == "caption":
                axes.plot(*noise(p), ":", color="black", label="95 % about the caption's")
        for name, one in {"default": default, "nearest": found.best}.items():
            p = np.array([row.p for row in one.rows])
            mark(p, **STYLES[name], markersize=8, label=f"{name} reading")
        axes.set(xlabel="height: mean of P(e) over e = 0.41 to 0.45", ylabel="slope dP/de")
        axes.margins(0.05)
        axes.legend(fontsize="small")


def beyond(one: Trial) -> bool:
    """Tell whether the ledger's switches alone do not make a reading."""
    return one.space.flies or one.base.scene.ball.radius == min(RADII)


def noise(p: Array) -> Array:
    """Return the ellipse of 95 % that 1,000 samples a point leave open: heights and slopes."""
    spread = HEIGHT_AND_SLOPE @ covariance(p, shared=False) @ HEIGHT_AND_SLOPE.T / PAPER_SAMPLES
    turn = np.linspace(0.0, 2 * np.pi, 200)
    around: Array = np.linalg.cholesky(NEAR * spread) @ np.array([np.cos(turn), np.sin(turn)])
    return around + (HEIGHT_AND_SLOPE @ p)[:, None]
