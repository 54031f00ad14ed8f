"""Every combination of readings that matters, against the paper's Figs. 6 and 7."""

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import chain, groupby, product
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from analysis.paper import balls, distances, printed
from analysis.paper.balls import SPACES, Balls, Base, Space, strike
from analysis.paper.distances import (
    BIN,
    HEIGHT_AND_SLOPE,
    LEVEL,
    Peak,
    Score,
    distance,
)
from analysis.paper.printed import PEAKS
from analysis.writing import STYLES, Report, data
from longball.engines.parallel import in_parallel
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Estimate
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene, Ball

FIRST_SAMPLES = 3_000  # a combination, at first; three times the paper's
CLOSER_SAMPLES = 20_000  # of those that come near; all of those that may be it
DRAWS = 500  # papers, of those that come near: p = 1 % is not missed
WITHIN = 3 * distances.NEAR  # of Fig. 7 at first sight: worth a closer look
FEWEST = 100  # balls that a sample space must have at first sight

GRID = data(__file__)
COLLISIONS, OFFSET_SPREADS = GRID["collisions"], GRID["offset_spreads"]
CELL_WIDTHS, RADII, CONTACT_FORCES = GRID["cell_widths"], GRID["radii"], GRID["contact_forces"]
USUAL, HALF = max(RADII), min(RADII)


def bases() -> Iterator[Base]:
    """Yield the at-bats of all combinations but for the sample spaces, which cost nothing."""
    for collision, force, offset, radius, width in product(
        COLLISIONS, CONTACT_FORCES, OFFSET_SPREADS, RADII, CELL_WIDTHS
    ):
        reading = Reading.model_validate(collision)
        yield Base(
            AtBatScene(id="base", ball=Ball(radius=radius), reading=reading),
            SamplingReading(offset_spread=offset, cell_width=width),
            force,
        )


# Readings that differ in more than the width of a cell.
TRIED = len(list(bases())) // len(CELL_WIDTHS) * len(SPACES)


class Trial(NamedTuple):
    """A reading held against the paper."""

    base: Base
    space: Space
    rows: list[Estimate]  # at the five restitutions
    mode: float  # m, the middle of the highest bin of D, where it is farthest out
    low: float  # the share of D in the first bin, at the lowest restitution
    # d² from Fig. 7's curves, with samples of their own for each e; and, `shared`, from the
    # caption's if the paper took the same samples for all.
    to: dict[str, float]
    # Both figures, by the width of Fig. 6's bins; empty without drawn papers.
    scores: dict[float, Score]

    @property
    def shares(self) -> list[float]:
        """P at the five restitutions."""
        return [row.p for row in self.rows]

    @property
    def name(self) -> str:
        """Differences from the default."""
        return balls.describe(self.base, self.space)

    @property
    def but_width(self) -> str:
        """The same without the width of a cell, which is free."""
        return balls.describe(self.base.replaced({"cell_width": 0.144}), self.space)

    @property
    def p_value(self) -> float:
        """Of both figures, with the bins that suit it best."""
        return max((score.p_value for score in self.scores.values()), default=0.0)

    @property
    def peaks(self) -> dict[float, Peak]:
        """The peaks of Fig. 6 in bins of 10 m, by restitution; empty without drawn papers."""
        return self.scores[BIN].peaks if self.scores else {}

    @property
    def usual(self) -> bool:
        """True if the ball has its usual size."""
        return bool(self.base.scene.ball.radius == USUAL)

    def p(self, e: float) -> float:
        """Return P at one of the restitutions."""
        return self.shares[RESTITUTIONS.index(e)]


def trials(base: Base, spaces: Sequence[Space], count: int, draws: int) -> list[Trial]:
    """Return a combination's trials in the sample spaces that have enough balls.

    Fig. 6 is looked at only where papers are drawn.
    """
    struck = strike(base, base.drawn(count), RESTITUTIONS, threads=1)
    enough = (space for space in spaces if space.members(struck[0]).sum() >= FEWEST)
    return [trial(base, space, struck, draws) for space in enough]


def trial(base: Base, space: Space, struck: Sequence[Balls], draws: int = distances.DRAWS) -> Trial:
    """Hold struck balls against Fig. 7; and against both figures, if papers are to be drawn."""
    rows = space.estimates(struck)
    flown = {e: space.distances(one) for e, one in zip(RESTITUTIONS, struck, strict=True)}
    to = {name: distance(rows, curve) for name, curve in PAPER_CURVES.items()}
    to["shared"] = distance(rows, PAPER_CURVES["caption"], shared=True)
    found: dict[float, Score] = {}
    if draws:
        cells = {
            row.e: distances.in_cells(flown[row.e], len(flown[row.e]) / row.trials) for row in rows
        }
        generator = np.random.default_rng(balls.SEED)
        found = distances.scores(cells, to["caption"], generator, draws)
    mode = max(distances.highest(flown[e]) for e in PEAKS)
    low = float(np.mean(flown[min(PEAKS)] < BIN))
    return Trial(base, space, rows, mode, low, to, found)


class Family(NamedTuple):
    """Readings that differ only in the width of a cell; the best represents them."""

    best: Trial
    widths: list[float]  # m, at which the two figures do not reject it, with the bins it has there

    @property
    def survives(self) -> bool:
        """True if Figs. 6 and 7 together do not reject the best one."""
        return self.best.p_value >= LEVEL


@cache
def study() -> SimpleNamespace:
    """Try all combinations; several sections ask for what comes of it.

    Each has a trial at `first` sight; those `near` Fig. 7 are seen closer, and are `families` by
    the width of a cell, the nearest to both figures first. The best of these, and the ledger's
    `default`, have as many at-bats as all other studies.
    """

    def look(calls: Iterable[tuple[Any, ...]]) -> list[list[Trial]]:
        return list(in_parallel(trials, calls, workers=-1, threads=True))

    first = look((base, SPACES, FIRST_SAMPLES, 0) for base in bases())
    worth = [[one for one in some if one.to["caption"] <= WITHIN] for some in first]
    calls = [
        (some[0].base, [one.space for one in some], CLOSER_SAMPLES, DRAWS) for some in worth if some
    ]
    near = sorted(chain(*look(calls)), key=lambda one: one.but_width)
    families = []
    for _, group in groupby(near, key=lambda one: one.but_width):
        alike = list(group)
        best = max(alike, key=lambda one: (one.p_value, -one.to["caption"]))
        widths = [one.base.sampling.cell_width for one in alike if one.p_value >= LEVEL]
        families.append(Family(best, sorted(widths)))
    # Those that may be it, with more at-bats.
    maybe = [family for family in families if family.best.p_value >= LEVEL / 5]
    calls = [(one.best.base, [one.best.space], balls.SAMPLES, distances.DRAWS) for one in maybe]
    families = [one for one in families if one not in maybe] + [
        family._replace(best=best) for family, (best,) in zip(maybe, look(calls), strict=True)
    ]
    families.sort(key=lambda one: (-one.best.p_value, one.best.to["caption"]))
    (default,) = trials(Base(AtBatScene(id="base")), SPACES[:1], balls.SAMPLES, 0)
    every = list(chain(*first))
    return SimpleNamespace(first=every, near=near, families=families, default=default)


Cases = dict[str, tuple[Base, Space]]


def cases() -> Cases:
    """Return the two readings that are looked at closely: the default, and the nearest."""
    both = {"default": study().default, "nearest": study().families[0].best}
    return {name: (one.base, one.space) for name, one in both.items()}


STEP = 0.05  # s, as printed
# Attributes of a trial that readings differ in, by what tables call them.
SWITCHES = {
    "contact_force": "base.contact_force",
    **{
        name: f"base.scene.reading.{name}"
        for name in ("bat_ball_restitution", "effective_mass", "reduced_mass", "inertia")
    },
    "offset_spread": "base.sampling.offset_spread",
    "ball.radius": "base.scene.ball.radius",
    "samples": "space.name",
}


def surviving(families: Sequence[Family], width: float) -> int:
    """Return the number of families that the figures do not reject with bins of one width, m."""
    return sum(one.best.scores[width].p_value >= LEVEL for one in families)


def section(report: Report) -> str:
    """Write the section of the combinations."""
    found, best = study(), study().families[0].best
    draw_plane(report, found)
    as_printed = Base(found.default.base.scene, SamplingReading(speed_table="as_printed"))
    # The nearest by the paper's scheme with its step, and without them.
    samples = best.base.drawn(balls.STEPPED_SAMPLES)
    stepped = balls.strike_in_steps(best.base, samples, RESTITUTIONS, Verlet(STEP))
    (exactly,) = strike(best.base, samples, RESTITUTIONS[:1])
    # The same with a ball of the other size.
    other = best.base.replaced({"ball.radius": HALF if best.usual else USUAL})
    (resized,) = balls.strike_in_steps(other, samples, RESTITUTIONS[:1], Verlet(STEP))
    by_steps = trial(best.base, best.space, stepped, 0)
    return report.render(
        "combinations", globals(),
        found=found, default=found.default, best=best, combined=len(list(bases())) * len(SPACES),
        survivors=[one for one in found.families if one.survives],
        backwards=1 - as_printed.drawn(FIRST_SAMPLES).pitched.mean(),
        stepped=stepped, exactly=exactly,
        by_steps=by_steps, other_size=resized.batted.mean(),
        # At how many restitutions the interval of 95 % has P without the scheme inside.
        agreeing=sum(row.low <= best.p(row.e) <= row.high for row in by_steps.rows),
        off=max(abs(row.p - PAPER_CURVES["caption"](row.e)) for row in best.rows),
    )  # fmt: skip


def draw_plane(report: Report, found: SimpleNamespace) -> None:
    """Draw the mean and the rise of P(e): all readings as a cloud, and those that survive."""
    with report.figure("paper_combinations", size=(6.4, 4.4)) as (axes,):

        def at(shares: Sequence[Any]) -> Any:
            height, slope = HEIGHT_AND_SLOPE @ np.transpose(shares)
            return height, slope * (max(RESTITUTIONS) - min(RESTITUTIONS))

        all_of_them = [one.shares for one in found.first]
        style: Any = {"markersize": 2, "color": "0.7"}
        axes.plot(*at(all_of_them), ".", **style, label=f"all {len(all_of_them):,} tried")
        survivors = [one.best.shares for one in found.families if one.survives]
        if survivors:
            look: Any = {"color": "#009E73", "markersize": 7, "markerfacecolor": "none"}
            axes.plot(*at(survivors), "^", **look, label="not rejected by Figs. 6 and 7")
        for name, curve in PAPER_CURVES.items():
            p = np.array([curve(e) for e in RESTITUTIONS])
            style = STYLES[f"paper's {name}"] | {"linestyle": "none", "markersize": 11}
            axes.plot(*at([p]), **style, label=f"Fig. 7, {name}")
            if name == "caption":  # the ellipse that 1,000 samples a point leave open
                covariance = distances.covariance(p, shared=False) / printed.SAMPLES
                turn = np.linspace(0.0, 2 * np.pi, 200)
                spread = HEIGHT_AND_SLOPE @ covariance @ HEIGHT_AND_SLOPE.T
                around = np.linalg.cholesky(distances.NEAR * spread) @ [np.cos(turn), np.sin(turn)]
                height, slope = around + (HEIGHT_AND_SLOPE @ p)[:, None]
                rise = slope * (max(RESTITUTIONS) - min(RESTITUTIONS))
                axes.plot(height, rise, "-", color="black", label="its noise (95 %)")
        style = STYLES["default"] | {"linestyle": "none", "markersize": 8}
        axes.plot(*at([found.default.shares]), **style, label="default reading")
        axes.set(xlabel="mean of P(e) over e = 0.41 to 0.45")
        axes.set(ylabel="rise of P(e) from e = 0.41 to 0.45", xlim=(0.0, 0.45), ylim=(-0.01, 0.13))
        axes.legend()
