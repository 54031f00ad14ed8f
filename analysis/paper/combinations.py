"""Every combination of readings that matters, against the paper's Figs. 6 and 7."""

from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import chain, product
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from analysis.paper import balls, distances, printed
from analysis.paper.balls import SPACES, Balls, Base, Space, strike
from analysis.paper.distances import BIN, HEIGHT_AND_SLOPE, NEAR_BOTH, Distance, Peak, distance
from analysis.paper.printed import PEAKS
from analysis.writing import STYLES, Report, data
from longball.engines.parallel import in_parallel
from longball.engines.verlet import Verlet
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Estimate
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene, Ball

FIRST_SAMPLES = 10_000  # a combination, at first; ten times the paper's
CLOSER_SAMPLES = 50_000  # of those that come near; all of those that may be it
WITHIN = 4 * distances.NEAR  # of Fig. 7 at first sight: worth a closer look
FEWEST = 100  # balls that a sample space must have at first sight

GRID = data(__file__)
COLLISIONS, OFFSET_SPREADS = GRID["collisions"], GRID["offset_spreads"]
CELL_WIDTHS, RADII = GRID["cell_widths"], GRID["radii"]
PLATE = 0.432  # m, its width


def bases() -> Iterator[Base]:
    """Yield the at-bats of all combinations but for the sample spaces, which cost nothing."""
    for collision, offset, width, radius in product(COLLISIONS, OFFSET_SPREADS, CELL_WIDTHS, RADII):
        reading = Reading.model_validate(collision)
        yield Base(
            AtBatScene(id="base", ball=Ball(radius=radius), reading=reading),
            SamplingReading(offset_spread=offset, cell_width=width),
        )


class Trial(NamedTuple):
    """A reading held against the paper."""

    base: Base
    space: Space
    rows: list[Estimate]  # at the five restitutions
    mode: float  # m, the middle of the highest bin of D, where it is farthest out
    low: float  # the share of D in the first bin, at the lowest restitution
    # To Fig. 7's curves, with samples of their own for each e; and to the caption's if the paper
    # took the same samples for all.
    to: dict[str, Distance]
    peaks: dict[float, Peak]  # the paper's Fig. 6 against it; empty at first sight

    @property
    def shares(self) -> list[float]:
        """P at the five restitutions."""
        return [row.p for row in self.rows]

    @property
    def name(self) -> str:
        """What it differs in from the default."""
        return balls.describe(self.base, self.space)

    @property
    def both(self) -> float:
        """Distance to both figures together."""
        return distances.total(self.to["caption"], list(self.peaks.values()))

    @property
    def beyond(self) -> bool:
        """Whether it takes more than the ledger's switches: flies, or a ball half as wide."""
        return self.space.flies or self.base.scene.ball.radius == min(RADII)

    def p(self, e: float) -> float:
        """Return P at one of the restitutions."""
        return self.shares[RESTITUTIONS.index(e)]


def trials(base: Base, spaces: Sequence[Space], count: int, closer: bool = True) -> list[Trial]:
    """Return what a combination gives in the sample spaces with balls enough.

    The peaks of Fig. 6 are looked at only for who comes closer.
    """
    struck = strike(base, base.drawn(count), RESTITUTIONS, threads=1)
    enough = (space for space in spaces if space.members(struck[0]).sum() >= FEWEST)
    return [trial(base, space, struck, balls.SEED if closer else None) for space in enough]


def trial(base: Base, space: Space, struck: Sequence[Balls], seed: int | None = None) -> Trial:
    """Hold struck balls against Fig. 7; and against Fig. 6, whose peaks are drawn from a seed."""
    rows = space.estimates(struck)
    at = {e: RESTITUTIONS.index(e) for e in PEAKS}
    flown = {e: space.distances(struck[i]) for e, i in at.items()}
    to = {name: distance(rows, curve) for name, curve in PAPER_CURVES.items()}
    to["shared"] = distance(rows, PAPER_CURVES["caption"], shared=True)
    generator = np.random.default_rng(seed)
    shares = {e: (d, len(d) / rows[at[e]].trials) for e, d in flown.items() if seed is not None}
    peaks = {e: distances.peak(e, *share, generator) for e, share in shares.items()}
    mode = max(map(distances.highest, flown.values()))
    low = float(np.mean(flown[min(PEAKS)] < BIN))
    return Trial(base, space, rows, mode, low, to, peaks)


@cache
def study() -> SimpleNamespace:
    """Try all combinations; several sections ask for what comes of it.

    Each has a trial at `first` sight; the `near` ones are seen closer, the nearest first, and as
    close as these the ledger's `default`.
    """

    def look(calls: Iterable[tuple[Any, ...]]) -> list[list[Trial]]:
        return list(in_parallel(trials, calls, workers=-1, threads=True))

    first = look((base, SPACES, FIRST_SAMPLES, False) for base in bases())
    worth = [[one for one in some if one.to["caption"].squared <= WITHIN] for some in first]
    calls = [(some[0].base, [one.space for one in some], CLOSER_SAMPLES) for some in worth if some]
    near = list(chain(*look(calls)))
    closest = [one for one in near if one.both <= 2 * NEAR_BOTH]
    again = chain(*look((one.base, [one.space], balls.SAMPLES) for one in closest))
    near = [*again, *(one for one in near if one not in closest)]
    (default,) = trials(Base(AtBatScene(id="base")), SPACES[:1], balls.SAMPLES)
    near.sort(key=lambda one: one.both)
    return SimpleNamespace(first=list(chain(*first)), near=near, default=default)


Cases = dict[str, tuple[Base, Space]]


def cases() -> Cases:
    """Return the two readings that are looked at closely: the default, and the nearest."""
    both = {"default": study().default, "nearest": study().near[0]}
    return {name: (one.base, one.space) for name, one in both.items()}


STEP = 0.05  # s, as printed


def section(report: Report) -> str:
    """Write the section of the combinations."""
    found, best = study(), study().near[0]
    draw_plane(report, found)
    as_printed = Base(found.default.base.scene, SamplingReading(speed_table="as_printed"))
    # The nearest by the paper's scheme with its step, and without them.
    samples = best.base.drawn(balls.STEPPED_SAMPLES)
    stepped = balls.strike_in_steps(best.base, samples, RESTITUTIONS, Verlet(STEP))
    (exactly,) = strike(best.base, samples, RESTITUTIONS[:1])
    rows = best.space.estimates(stepped)
    return report.render(
        "combinations", globals(),
        found=found, default=found.default, best=best, solved=len(list(bases())),
        backwards=1 - as_printed.drawn(FIRST_SAMPLES).pitched.mean(),
        stepped=stepped, stepped_rows=rows, exactly=exactly,
        # At how many restitutions the interval of 95 % has P without the scheme inside.
        agreeing=sum(row.low <= best.p(row.e) <= row.high for row in rows),
        off=max(abs(row.p - PAPER_CURVES["caption"](row.e)) for row in best.rows),
    )  # fmt: skip


def draw_plane(report: Report, found: SimpleNamespace) -> None:
    """Draw all readings by height and slope of P(e)."""
    with report.figure("paper_combinations", size=(6.8, 4.6)) as (axes,):

        def mark(p: Sequence[Any], **style: Any) -> None:
            axes.plot(*(HEIGHT_AND_SLOPE @ np.transpose(p)), **style | {"linestyle": "none"})

        small: Any = {"markersize": 4, "markerfacecolor": "none"}
        ledger, beyond = ([x.shares for x in found.first if x.beyond == y] for y in (False, True))
        mark(ledger, marker="o", color="0.55", **small, label="in the ledger")
        mark(beyond, marker="+", color="0.25", **small, label="ball 0.0366 m wide, or flies only")
        for name, curve in PAPER_CURVES.items():
            p = np.array([curve(e) for e in RESTITUTIONS])
            mark([p], **STYLES[f"paper's {name}"], markersize=11, label=f"paper's {name}")
            if name == "caption":  # the ellipse that 1,000 samples a point leave open
                covariance = distances.covariance(p, shared=False) / printed.SAMPLES
                spread = HEIGHT_AND_SLOPE @ covariance @ HEIGHT_AND_SLOPE.T
                turn = np.linspace(0.0, 2 * np.pi, 200)
                around = np.linalg.cholesky(distances.NEAR * spread) @ [np.cos(turn), np.sin(turn)]
                ellipse = around + (HEIGHT_AND_SLOPE @ p)[:, None]
                axes.plot(*ellipse, ":", color="black", label="95 % about the caption's")
        for name, one in {"default": found.default, "nearest": found.near[0]}.items():
            mark([one.shares], **STYLES[name], markersize=8, label=f"{name} reading")
        axes.set(xlabel="height: mean of P(e) over e = 0.41 to 0.45", ylabel="slope dP/de")
        axes.margins(0.05)
        axes.legend(fontsize="small")
