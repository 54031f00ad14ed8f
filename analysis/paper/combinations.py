"""Every combination of readings that matters, against the paper's Figs. 6 and 7."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import joblib
import numpy as np

from analysis import Array
from analysis.paper import balls, distances, printed
from analysis.paper.balls import SPACES, Balls, Base, Space, strike
from analysis.paper.distances import BIN, HEIGHT_AND_SLOPE, NEAR_BOTH, Distance, Peak, distance
from analysis.paper.printed import PEAKS
from analysis.writing import STYLES, figure, render
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Estimate, draw, paper_at_bats
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene, Ball

SAMPLES = 10_000  # a combination, at first; ten times the paper's
CLOSER_SAMPLES = 50_000  # of those that come near
CLOSEST_SAMPLES = 500_000  # of those that may be it
WITHIN = 4 * distances.NEAR  # of Fig. 7 at first sight: worth a closer look
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


class Trial(NamedTuple):
    """A reading held against the paper."""

    base: Base
    space: Space
    rows: list[Estimate]  # at the five restitutions
    mode: dict[float, float]  # m, the middle of the highest bin of D, by restitution
    low: float  # the share of D in the first bin, at the lowest restitution
    to: dict[str, Distance]  # to Fig. 7's curves, with samples of their own for each e
    peaks: dict[float, Peak]  # the paper's Fig. 6 against it; empty at first sight

    @property
    def name(self) -> str:
        """What it differs in from the default."""
        return balls.describe(self.base, self.space)

    @property
    def shared(self) -> Distance:
        """The distance to the caption's curve if the paper took the same samples for all e."""
        return distance(self.rows, PAPER_CURVES["caption"], shared=True)

    @property
    def both(self) -> float:
        """Distance to both figures together."""
        return distances.total(self.to["caption"], list(self.peaks.values()))

    @property
    def small(self) -> bool:
        """Whether its ball is half as wide as usual."""
        return self.base.scene.ball.radius == min(RADII)

    @property
    def beyond(self) -> bool:
        """Whether the ledger's switches alone do not make it."""
        return self.space.flies or self.small

    def p(self, e: float) -> float:
        """Return P at one of the restitutions."""
        return self.rows[RESTITUTIONS.index(e)].p


def struck_at(base: Base, count: int) -> list[Balls]:
    """Return what becomes of the same samples at each restitution."""
    return strike(base, draw(paper_at_bats(base.sampling), count, SEED), RESTITUTIONS)


def tried(base: Base) -> list[Trial]:
    """Return what a combination gives at first sight, in the sample spaces with balls enough."""
    struck = struck_at(base, SAMPLES)
    return [
        trial(base, space, struck)
        for space in SPACES
        if space.estimate(RESTITUTIONS[0], struck[0]).trials >= FEWEST
    ]


def closer(base: Base, spaces: Sequence[Space], count: int) -> list[Trial]:
    """Return what a combination gives with more samples, the peaks of Fig. 6 with it."""
    struck = struck_at(base, count)
    return [with_peaks(trial(base, space, struck), struck) for space in spaces]


def trial(base: Base, space: Space, struck: Sequence[Balls]) -> Trial:
    """Hold struck balls against Fig. 7."""
    rows = [space.estimate(e, one) for e, one in zip(RESTITUTIONS, struck, strict=True)]
    flown = {e: space.distances(struck[RESTITUTIONS.index(e)]) for e in PEAKS}
    mode = {e: distances.highest(d) for e, d in flown.items()}
    to = {name: distance(rows, curve) for name, curve in PAPER_CURVES.items()}
    return Trial(base, space, rows, mode, float(np.mean(flown[min(PEAKS)] < BIN)), to, peaks={})


def with_peaks(one: Trial, struck: Sequence[Balls], seed: int = SEED) -> Trial:
    """Hold struck balls against Fig. 6, too."""
    generator = np.random.default_rng(seed)
    peaks = {}
    for row, here in zip(one.rows, struck, strict=True):
        if row.e in PEAKS:
            flown = one.space.distances(here)
            peaks[row.e] = distances.peak(row.e, flown, len(flown) / row.trials, generator)
    return one._replace(peaks=peaks)


# --- the study ------------------------------------------------------------------------------------


class Study(NamedTuple):
    """Every combination at first sight, and the near ones seen closer, the nearest first."""

    first: list[Trial]
    near: list[Trial]


@cache
def study() -> Study:
    """Try all combinations; several sections ask for what comes of it."""
    threads = joblib.Parallel(n_jobs=-1, prefer="threads")

    def look(calls: Sequence[tuple[Base, list[Space], int]]) -> list[Trial]:
        return list(itertools.chain(*threads(joblib.delayed(closer)(*call) for call in calls)))

    first = threads(joblib.delayed(tried)(base) for base in bases())
    worth = [
        (trials[0].base, spaces, CLOSER_SAMPLES)
        for trials in first
        if (spaces := [one.space for one in trials if one.to["caption"].squared <= WITHIN])
    ]
    near = look(worth)
    closest = [one for one in near if one.both <= 2 * NEAR_BOTH]
    again = look([(one.base, [one.space], CLOSEST_SAMPLES) for one in closest])
    done = [one.name for one in again]
    near = again + [one for one in near if one.name not in done]
    return Study(list(itertools.chain(*first)), sorted(near, key=lambda one: one.both))


@cache
def default_trial() -> Trial:
    """Return the ledger's defaults, seen as close as the near readings."""
    return closer(Base(AtBatScene(id="base")), SPACES[:1], CLOSEST_SAMPLES)[0]


Cases = dict[str, tuple[Base, Space]]


def cases() -> Cases:
    """Return the two readings that are looked at closely: the default, and the nearest."""
    both = {"default": default_trial(), "nearest": study().near[0]}
    return {name: (one.base, one.space) for name, one in both.items()}


# --- the paper's scheme ---------------------------------------------------------------------------

STEP = 0.05  # s, as printed
STEPPED_SAMPLES = 60_000  # most of them pass the bat unseen


class Stepped(NamedTuple):
    """A reading by the paper's scheme with its step, and the same reading without it."""

    exact: Trial
    rows: list[Estimate]  # at the five restitutions, in the same sample space
    batted: float  # share of the pitches
    batted_exactly: float
    of_pitches: list[Estimate]  # the home runs as shares of all pitches

    @property
    def inside(self) -> int:
        """At how many restitutions the interval of 95 % has P without the scheme inside."""
        pairs = zip(self.rows, self.exact.rows, strict=True)
        return sum(row.low <= exact.p <= row.high for row, exact in pairs)

    @property
    def away(self) -> Distance:
        """The distance to the caption's curve."""
        return distance(self.rows, PAPER_CURVES["caption"])


def stepped(exact: Trial) -> Stepped:
    """Take a reading's at-bats with the paper's scheme."""
    base = exact.base
    by_steps = balls.strike_in_steps(base, STEPPED_SAMPLES, SEED, RESTITUTIONS, Verlet(STEP))
    samples = draw(paper_at_bats(base.sampling), STEPPED_SAMPLES, SEED)
    exactly = strike(base, samples, RESTITUTIONS[:1], threads=balls.cores())[0]
    at = list(zip(RESTITUTIONS, by_steps, strict=True))
    return Stepped(
        exact,
        [exact.space.estimate(e, one) for e, one in at],
        float(by_steps[0].batted.mean()),
        float(exactly.batted.mean()),
        [SPACES[0].estimate(e, one) for e, one in at],
    )


# --- the report -----------------------------------------------------------------------------------


def section(report: Path) -> str:
    """Write the section of the combinations."""
    found, default = study(), default_trial()
    draw_plane(report, found, default)
    best, curve = found.near[0], PAPER_CURVES["caption"]
    near = [one for one in found.near if one.to["caption"].near]
    usual = [one for one in near if one.base.scene.ball.radius == default.base.scene.ball.radius]
    everything = [one for one in found.first if not one.space.flies]
    flies = [one for one in found.first if one.space.flies]
    solved = len(list(bases()))
    as_printed = paper_at_bats(SamplingReading(speed_table="as_printed"))
    inside = [one for one in found.near if not one.beyond] or [
        one for one in found.first if not one.beyond
    ]
    return render(
        report, "combinations", globals(),
        found=found, default=default, best=best, solved=solved,
        dropped=solved * len(SPACES) - len(found.first),
        backwards=1 - draw(as_printed, SAMPLES, SEED).pitched.mean(),
        everything=everything, grounded=sum(max(t.mode.values()) < BIN for t in everything),
        flies=flies, moved=sum(max(t.mode.values()) > BIN for t in flies),
        near_ones=near, usual=usual, both=[one for one in found.near if one.both <= NEAR_BOTH],
        nearest=min(inside, key=lambda one: one.to["caption"].squared),
        seventh=sorted(found.near, key=lambda one: one.to["caption"].squared)[:6],
        curve=curve, off=max(abs(one.p - curve(one.e)) for one in best.rows),
        noise=math.sqrt(best.p(0.43) * (1 - best.p(0.43)) / printed.SAMPLES),
        lowest=min(found.first, key=lambda one: one.to["text"].squared),
        text=PAPER_CURVES["text"], by_steps=[stepped(best)],
    )  # fmt: skip


def draw_plane(report: Path, found: Study, default: Trial) -> None:
    """Draw all readings by height and slope of P(e)."""
    beyond = [one for one in found.first if one.beyond]
    ledger = [one for one in found.first if not one.beyond]
    with figure(report, "paper_combinations", size=(6.8, 4.6)) as (axes,):

        def mark(trials: Sequence[Trial], **style: Any) -> None:
            p = np.array([[row.p for row in one.rows] for one in trials])
            axes.plot(*(HEIGHT_AND_SLOPE @ p.T), **style | {"linestyle": "none"})

        small: Any = {"markersize": 4, "markerfacecolor": "none"}
        mark(ledger, marker="o", color="0.55", **small, label="in the ledger")
        mark(beyond, marker="+", color="0.25", **small, label="ball 0.0366 m wide, or flies only")
        for name, curve in PAPER_CURVES.items():
            p = np.array([curve(e) for e in RESTITUTIONS])
            style = STYLES[f"paper's {name}"] | {"linestyle": "none", "markersize": 11}
            axes.plot(*(HEIGHT_AND_SLOPE @ p), **style, label=f"paper's {name}")
            if name == "caption":
                axes.plot(*noise(p), ":", color="black", label="95 % about the caption's")
        for name, one in {"default": default, "nearest": found.near[0]}.items():
            mark([one], **STYLES[name], markersize=8, label=f"{name} reading")
        axes.set(xlabel="height: mean of P(e) over e = 0.41 to 0.45", ylabel="slope dP/de")
        axes.margins(0.05)
        axes.legend(fontsize="small")


def noise(p: Array) -> Array:
    """Return the ellipse of 95 % that 1,000 samples a point leave open: heights and slopes."""
    covariance = distances.covariance(p, shared=False) / printed.SAMPLES
    spread = HEIGHT_AND_SLOPE @ covariance @ HEIGHT_AND_SLOPE.T
    turn = np.linspace(0.0, 2 * np.pi, 200)
    around: Array = np.linalg.cholesky(distances.NEAR * spread) @ np.array(
        [np.cos(turn), np.sin(turn)]
    )
    return around + (HEIGHT_AND_SLOPE @ p)[:, None]
