"""Known mistakes in the random at-bats that a candidate draws.

Some mistakes are made before a scene is solved: the columns of Table II as printed, a standard
deviation with a wrong factor √2, a diameter in place of a radius. Answers to golden scenes cannot
show them, but the scenes that a candidate draws can. Every combination of readings of the sampling
is a distribution, and the likelihood of the drawn numbers distinguishes them.
"""

from __future__ import annotations

import itertools
import json
import math
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

from longball.convergence.report import Frozen
from longball.home_run import AtBats, Mixture, paper_at_bats
from longball.judge.answers import lines_of, quoted
from longball.model.arrays import Array
from longball.model.quantities import at
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

# Critical value of Kolmogorov's statistic √n D. Samples of the right distribution exceed it with
# the probability 2 exp(-2 x²) = 1e-5; four quantities are tested.
CRITICAL = 2.47

# A mistake is named only if the drawn numbers are 1e5 times as likely with it; natural logarithm. A
# fitted number must increase the likelihood by this factor once more.
LIKELIER = math.log(1e5)

# The mistake that is hardest to detect is a standard deviation of the speed that is too small by
# √2. With 500 at-bats it is named in 995 of 1,000 trials, with 400 in 974, with 300 in 857. None of
# 2,000 right samplings was called wrong.
FEWEST = 500

# A rank correlation times √n is nearly normally distributed. For independent numbers it exceeds
# this value with a probability of 1e-8; forty are computed.
TOO_ALIKE = 5.7

# A stream repeats itself if each draw occurs more often than this. A program that tries several
# restitutions with each at-bat repeats each draw, too, but fewer times.
MANY_TIMES = 20
LONGEST_SCENE = 1 << 16  # bytes

DRAWN = ("pitch.speed", "pitch.aim[0]", "swing.height_offset", "swing.tilt")


class BadSamples(ValueError):
    """A file that holds no at-bats to be judged; the message says why."""


class Drawn(Frozen):
    """One random quantity of the at-bats, and its distribution."""

    quantity: str
    named: list[str] = Field(description="the mistakes in it; empty if it is as the paper means")
    fits: bool = Field(description="whether the distribution so named fits")
    statistic: float = Field(description="Kolmogorov's √n D beside that distribution")
    sentence: str

    @property
    def right(self) -> bool:
        """True if it is drawn as the paper means it."""
        return self.fits and not self.named


class Constant(Frozen):
    """A number of the at-bats that the paper prints, and that is another one here."""

    right: ClassVar[bool] = False
    quantity: str
    paper: float
    given: list[float] = Field(description="the values met, a few of them")
    named: list[str] = Field(description="the mistake that it is, if it is a known one")
    sentence: str


class Dependence(Frozen):
    """Random numbers that depend on each other, or repeat."""

    right: ClassVar[bool] = False
    quantity: str = Field(description="one, or two that depend on each other")
    named: list[str]
    statistic: float = Field(
        description="of dependence: a rank correlation times √n; of repeats: their number"
    )
    sentence: str


class Sampling(Frozen):
    """A judgement of the at-bats that a candidate draws."""

    source: str
    at_bats: int = Field(description="different ones")
    drawn: list[Drawn]
    constants: list[Constant] = Field(description="those that are not the paper's")
    dependences: list[Dependence] = Field(description="between numbers that should have none")
    sees: float = Field(
        description="the least difference of a distribution function that so many at-bats show"
    )

    @property
    def found(self) -> list[Drawn | Constant | Dependence]:
        """Return all that there is to say, the drawn quantities first."""
        return [*self.drawn, *self.dependences, *self.constants]

    @property
    def wrong(self) -> list[Drawn | Constant | Dependence]:
        """Return the quantities that are not drawn as the paper means them."""
        return [found for found in self.found if not found.right]


def read_samples(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the scenes of a file of JSON Lines, unchecked.

    An impossible number, such as a speed below zero, shows how it was drawn. A line that is no JSON
    object raises `BadSamples`.
    """
    for number, line in lines_of(path, LONGEST_SCENE):
        where = f"{path}: line {number}"
        if line is None:
            raise BadSamples(f"{where}: longer than {LONGEST_SCENE} bytes")
        if not line.strip():
            continue
        try:
            scene = json.loads(line.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            said = quoted(line.decode(errors="replace"))
            raise BadSamples(f"{where}: not JSON: {said}") from error
        if not isinstance(scene, dict) or scene.get("kind", "at-bat") != "at-bat":
            raise BadSamples(f"{where}: not an at-bat: {quoted(scene)}")
        yield scene


def _number(scene: Mapping[str, Any], path: str) -> float | None:
    """Return a number of a scene; None if it is left out."""
    try:
        held = at(scene, path)
    except ValueError as error:
        raise BadSamples(str(error)) from None
    if held is None:
        return None
    known = isinstance(held, int | float) and not isinstance(held, bool)
    if not (known and abs(held) <= sys.float_info.max):  # NaN is not; some integers are too large
        raise BadSamples(f"{path} is {quoted(held)}; must be a finite number")
    return float(held)


def judge_samples(scenes: Iterable[Mapping[str, Any]], source: str = "given") -> Sampling:
    """Judge the at-bats that a candidate draws.

    They are JSON objects, at least `FEWEST`, drawn from the paper's distributions. Equal draws,
    such as one for each of several restitutions, count once. Keys that the scenes omit are not
    judged. `BadSamples` is raised if there are too few, or if a key holds no number.
    """
    draws: Counter[tuple[float | None, ...]] = Counter()
    met: dict[str, dict[float, None]] = {name: {} for name in _PRINTED}
    for count, scene in enumerate(scenes, 1):
        try:
            draws[tuple(_number(scene, name) for name in DRAWN)] += 1
            for name, values in met.items():
                value = _number(scene, name)
                if value is not None and len(values) < 3:
                    values[value] = None
        except BadSamples as error:
            raise BadSamples(f"{source}: at-bat {count}: {error}") from None
    columns = {name: [draw[i] for draw in draws] for i, name in enumerate(DRAWN)}
    given = {name: np.array([x for x in column if x is not None], float)
             for name, column in columns.items()}  # fmt: skip
    most, total = max(map(len, given.values())), draws.total()
    repeats = 0 < most < FEWEST <= total and total > MANY_TIMES * len(draws)
    if most < FEWEST and not repeats:
        raise BadSamples(
            f"{source}: {most} different at-bats; {FEWEST} are needed to test their distributions"
        )
    repeating = Dependence(
        quantity="at-bats",
        named=["repeating-stream"],
        statistic=total / max(len(draws), 1),
        sentence=f"at-bats: the stream repeats itself: {len(draws)} different ones in {total}",
    )
    whole = {name: values for name, values in given.items() if len(values) == len(draws)}
    others = (_constant(name, list(values)) for name, values in met.items())
    return Sampling(
        source=source,
        at_bats=len(draws),
        drawn=[_judge(name, values) for name, values in given.items() if len(values) >= FEWEST],
        constants=[found for found in others if found is not None],
        dependences=[repeating] if repeats else list(_dependences(whole)),
        sees=min(1.0, CRITICAL / math.sqrt(max(most, 1))),
    )


def _dependences(columns: Mapping[str, Array]) -> Iterator[Dependence]:
    """Yield pairs of quantities that depend on each other, and quantities on their last draw.

    Ranks show one random number behind both, whatever functions compute the quantities from it; the
    distance of ranks from their middle shows it if one of the functions is even.
    """
    from scipy.stats import rankdata

    ranks = {name: rankdata(values) for name, values in columns.items()}
    pairs = [(a, b, ranks[a], ranks[b]) for a, b in itertools.combinations(ranks, 2)]
    pairs += [(a, f"the {a} before it", r[1:], r[:-1]) for a, r in ranks.items()]
    for a, b, x, y in pairs:
        n = len(x)
        folded = [np.abs(r - (n + 1) / 2) for r in (x, y)]
        both = itertools.product((x, folded[0]), (y, folded[1]))
        size = max(abs(float(np.corrcoef(u, v)[0, 1])) * math.sqrt(n) for u, v in both)
        if size > TOO_ALIKE:
            sentence = f"{a} depends on {b}: the correlation of their ranks is "
            sentence += f"{size / math.sqrt(n):.2f}; draw a random number of its own for each"
            yield Dependence(
                quantity=f"{a} and {b}", named=["dependence"], statistic=size, sentence=sentence
            )


# --- ways of drawing ------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Way:
    """A way to draw a quantity."""

    named: tuple[str, ...]  # the mistakes in it
    distribution: Any  # of SciPy: what is drawn from
    scale: float = 1.0  # factor of the drawn numbers
    positive: bool = False  # whether what is not positive is thrown away
    fitted: str = ""  # what is said of the scale, if it was fitted to the values

    @property
    def lost(self) -> float:
        """The share that is thrown away."""
        return float(self.distribution.cdf(0.0)) if self.positive else 0.0

    def cdf(self, values: Array) -> Array:
        """Return the distribution function."""
        below = self.distribution.cdf(values / self.scale)
        kept: Array = np.clip((below - self.lost) / (1 - self.lost), 0.0, 1.0)
        return kept

    def likelihood(self, values: Array) -> float:
        """Return the logarithm of the likelihood of values, less what a mistake has to exceed."""
        x = values / self.scale
        if self.positive and (x <= 0).any():
            return -math.inf
        terms = self.distribution.logpdf(x) - math.log(self.scale * (1 - self.lost))
        return float(terms.sum()) - LIKELIER * (bool(self.named) + 2 * bool(self.fitted))


def _ways(quantity: str, values: Array) -> Iterator[_Way]:
    """Yield the ways in which a quantity may have been drawn, the right one first."""
    match quantity:
        case "pitch.speed":
            for table, spread, unit in itertools.product(
                ("columns_swapped", "as_printed"), ("standard_deviation", "as_printed"), (1.0, 3.6)
            ):
                made = {"table-columns": table, "missing-2": spread, "speed-in-km/h": unit}
                named = tuple(name for name, how in made.items() if how in ("as_printed", 3.6))
                speed = _paper(speed_table=table, speed_spread=spread).speed.distribution
                yield _Way(named, speed, unit)
                if table == "as_printed":  # half of which are below zero, and no pitches
                    yield _Way(named, speed, unit, positive=True)
        case "pitch.aim[0]":
            aim, cell = _paper().aim, SamplingReading().cell_width
            yield _Way((), aim.distribution)
            yield _Way(("cells-for-metres",), aim.distribution, 1 / cell)
            middle = Mixture(aim.weight, (2.0, 4.0), (0.77, 0.77)).distribution
            yield _Way(("cells-from-the-edge",), middle)
            yield _Way(("cells-from-the-edge",), middle, cell)
            other = Mixture(1 - aim.weight, aim.means, aim.deviations)
            yield _Way(("left-for-right",), other.distribution)
            # The paper does not give the width of a cell: the one that fits best, by the mean of
            # the squares, is as right as any.
            (left, right), deviation = aim.means, aim.deviations[0]
            expected = aim.weight * left**2 + (1 - aim.weight) * right**2 + deviation**2
            scale = math.sqrt(float(np.mean(values**2)) / expected)
            if scale > 0:
                width = f", with cells {scale * cell:.3g} m wide: ask for the reading cell_width"
                yield _Way((), aim.distribution, scale, fitted=width)
        case "swing.height_offset":
            right = _paper().offset_deviation
            wrong = {"radius-or-diameter": 2 * right, "missing-2": right * math.sqrt(0.5)}
            for name, deviation in {"": right, **wrong}.items():
                mixture = Mixture(1.0, (0.0, 0.0), (deviation, deviation))
                yield _Way((name,) if name else (), mixture.distribution)
        case _:  # swing.tilt, which is never a radian
            from scipy.stats import uniform

            degrees = values.max() > 1.0
            named = ("tilt-in-degrees",) if degrees else ()
            yield _Way(named, uniform(), 10.0 if degrees else _paper().largest_tilt)


def _paper(**switches: object) -> AtBats:
    return paper_at_bats(SamplingReading.model_validate(switches))


_SENTENCES = {
    "table-columns": "μ and σ are taken from Table II's columns as printed; they are exchanged",
    "missing-2": "the spread is σ/√2, by the 2 that Eq. 2 lacks; σ is the standard deviation",
    "speed-in-km/h": "it is in km/h; a scene's speed is in m/s",
    "cells-for-metres": "it is in cells; a scene's aim is in m",
    "cells-from-the-edge": "cells are counted from the edge; the middle one, 3, lies at y = 0",
    "left-for-right": "left is taken for right; from the pitcher, left to right is +y",
    "radius-or-diameter": "its spread is the ball's diameter; 0.0366 m is the radius",
    "tilt-in-degrees": "it is in degrees; a scene's tilt is in radians",
}


def _judge(quantity: str, values: Array) -> Drawn:
    from scipy.stats import kstest  # which takes a second to load

    way = max(_ways(quantity, values), key=lambda way: way.likelihood(values))
    statistic = math.sqrt(len(values)) * kstest(values, way.cdf, method="asymp").statistic
    if fits := bool(statistic < CRITICAL):
        known = "; ".join(_SENTENCES[name] for name in way.named)
        said = known or f"drawn as the paper means it{way.fitted}"
    else:
        said = "drawn from none of the known distributions"
    return Drawn(
        quantity=quantity, named=[*way.named] if fits else [], fits=fits,
        statistic=float(statistic), sentence=f"{quantity}: {said}",
    )  # fmt: skip


# --- what is not random ---------------------------------------------------------------------------


# The numbers of an at-bat that the paper prints and does not vary.
_PRINTED = (
    "ball.radius", "air.density", "air.drag_coefficient", "air.lift_coefficient", "gravity",
    "pitch.release[0]", "pitch.release[1]", "pitch.release[2]", "pitch.aim[1]",
    "bat.length", "bat.radius", "swing.angular_speed", "ground.height",
)  # fmt: skip

_SLIPS = {
    "ball.radius": (("radius-or-diameter", (0.0732, 0.0183)),),
    "bat.radius": (("radius-or-diameter", (0.066, 0.0165)),),
    "gravity": (("g-9.81", (9.81, 9.80665)),),
    "air.density": (("air-1.225", (1.225,)), ("air-1.2", (1.2, 1.204))),
}


def _constant(quantity: str, met: Sequence[float]) -> Constant | None:
    paper = float(at(AtBatScene(), quantity))
    same = partial(math.isclose, rel_tol=1e-9)
    others = [value for value in met if not same(value, paper)]
    if not others:
        return None
    slips = _SLIPS.get(quantity, ())
    named = [name for name, values in slips if any(same(others[0], value) for value in values)]
    sentence = f"{quantity}: {others[0]:g}, where the paper has {paper:g}"
    return Constant(quantity=quantity, paper=paper, given=others, named=named, sentence=sentence)
