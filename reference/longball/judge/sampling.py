"""Which known mistakes are in the random at-bats that a candidate draws.

Some mistakes are made before any scene is there to be solved: the columns of Table II taken as
printed, a spread with or without its 2, a diameter for a radius. No answer to a golden scene can
show them; the scenes that a candidate draws do. Every combination of readings of the sampling is a
distribution, and the likelihood of the drawn numbers tells them apart.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from longball.convergence.report import Frozen
from longball.home_run import AtBats, Mixture, paper_at_bats
from longball.judge.answers import quoted
from longball.model.arrays import Array
from longball.model.quantities import at
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

# Kolmogorov's statistic √n D exceeds this once in a hundred thousand samples of the right
# distribution (2 exp(-2 x²) = 1e-5); four quantities are tested.
CRITICAL = 2.47

# Another way of drawing is named only if the numbers are this much likelier under it (a natural
# logarithm): a hundred thousand times, too. With a number fitted it must be as much likelier again.
LIKELIER = math.log(1e5)

# Of so many at-bats the mistake that is hardest to see, the speed's spread without its 2, is named
# in 995 of 1,000 trials; of 400 in 974, of 300 in 857. Of 2,000 right samplings none was called
# wrong.
FEWEST = 500

# A rank correlation times √n is as good as normal; it exceeds this once in 10⁸ samples of
# independent numbers, and forty are looked at.
TOO_ALIKE = 5.7

MANY_TIMES = 20  # a draw is there a few times if several restitutions are tried with it
LONGEST_SCENE = 1 << 16  # bytes

DRAWN = ("pitch.speed", "pitch.aim[0]", "swing.height_offset", "swing.tilt")


class BadSamples(ValueError):
    """A file that holds no at-bats to be judged; the message says why."""


class Drawn(Frozen):
    """How one random quantity of the at-bats was drawn."""

    quantity: str
    named: list[str] = Field(description="the mistakes in it; empty if it is as the paper means")
    fits: bool = Field(description="whether the distribution so named fits")
    statistic: float = Field(description="Kolmogorov's √n D beside that distribution")
    sentence: str

    @property
    def right(self) -> bool:
        """Whether it is drawn as the paper means it."""
        return self.fits and not self.named


class _Wrong(Frozen):
    @property
    def right(self) -> bool:
        """Whether it is as it should be, which it is not."""
        return False


class Constant(_Wrong):
    """A number of the at-bats that the paper prints, and that is another one here."""

    quantity: str
    paper: float
    given: list[float] = Field(description="the values met, a few of them")
    named: list[str] = Field(description="the mistake that it is, if it is a known one")
    sentence: str


class Dependence(_Wrong):
    """Random numbers that hang together, or come again."""

    quantity: str = Field(description="one, or two that hang together")
    named: list[str]
    statistic: float = Field(
        description="of dependence: a rank correlation times √n; of repeats: their number"
    )
    sentence: str


class Sampling(Frozen):
    """What is right and wrong in the at-bats that a candidate draws."""

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
        """Return what is not the paper's."""
        return [found for found in self.found if not found.right]


def read_samples(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the scenes of a file of JSON Lines, as they stand there.

    They are not held against the contract: what makes a scene impossible, such as a speed below
    zero, is what shows how it was drawn. A line that is no JSON object raises `BadSamples`.
    """
    with open(path, "rb") as file:
        for number, line in enumerate(iter(lambda: file.readline(LONGEST_SCENE + 1), b""), 1):
            if len(line) > LONGEST_SCENE:
                raise BadSamples(f"{path}: line {number}: longer than {LONGEST_SCENE} bytes")
            if not line.strip():
                continue
            try:
                scene = json.loads(line.decode("utf-8-sig"))
            except (ValueError, RecursionError) as error:
                raise BadSamples(
                    f"{path}: line {number}: not JSON: {quoted(line.decode(errors='replace'))}"
                ) from error
            if not isinstance(scene, dict) or scene.get("kind", "at-bat") != "at-bat":
                raise BadSamples(f"{path}: line {number}: not an at-bat: {quoted(scene)}")
            yield scene


def _number(scene: Mapping[str, Any], path: str) -> float | None:
    """Return a number of a scene; None if it is left out."""
    try:
        held = at(scene, path)
    except ValueError as error:
        raise BadSamples(str(error)) from None
    if held is None:
        return None
    number = math.nan
    if isinstance(held, int | float) and not isinstance(held, bool):
        with suppress(OverflowError):  # an integer too large for a double
            number = float(held)
    if not math.isfinite(number):
        raise BadSamples(f"{path} is {quoted(held)}; a finite number must stand there")
    return number


def judge_samples(scenes: Iterable[Mapping[str, Any]], source: str = "given") -> Sampling:
    """Return what is right and wrong in the at-bats that a candidate draws, of some source.

    They are JSON objects, at least `FEWEST`, drawn from the paper's distributions. A draw that is
    there more than once, such as for several restitutions, counts once; what the scenes leave out
    is not judged. `BadSamples` are too few, or hold something else than numbers.
    """
    draws: dict[tuple[float | None, ...], int] = {}
    paper = json.loads(AtBatScene(id="paper").line())
    printed = {name: x for name in _PRINTED if (x := _number(paper, name)) is not None}
    constants: dict[str, dict[float, None]] = {name: {} for name in printed}
    for number, scene in enumerate(scenes, 1):
        try:
            draw = tuple(_number(scene, name) for name in DRAWN)
            draws[draw] = draws.get(draw, 0) + 1
            for name, met in constants.items():
                value = _number(scene, name)
                if value is not None and len(met) < 3:
                    met[value] = None
        except BadSamples as error:
            raise BadSamples(f"{source}: at-bat {number}: {error}") from None
    columns = dict(zip(DRAWN, zip(*draws, strict=True), strict=True)) if draws else {}
    known = {name: [x for x in column if x is not None] for name, column in columns.items()}
    given = {name: np.array(column) for name, column in known.items()}
    most = max(map(len, given.values()), default=0)
    total = sum(draws.values())
    repeats = 0 < most < FEWEST <= total and total > MANY_TIMES * len(draws)
    if most < FEWEST and not repeats:
        raise BadSamples(
            f"{source}: {most} different at-bats; {FEWEST} are needed to tell how they are drawn"
        )
    repeating = Dependence(
        quantity="at-bats",
        named=["repeating-stream"],
        statistic=total / max(len(draws), 1),
        sentence=f"at-bats: the stream repeats itself: {len(draws)} different ones in {total}",
    )
    others = (_constant(name, value, list(constants[name])) for name, value in printed.items())
    return Sampling(
        source=source,
        at_bats=len(draws),
        drawn=[_judge(name, values) for name, values in given.items() if len(values) >= FEWEST],
        constants=[found for found in others if found is not None],
        dependences=[repeating] if repeats else list(_dependences(columns)),
        sees=min(1.0, CRITICAL / math.sqrt(max(most, 1))),
    )


def _dependences(columns: Mapping[str, Sequence[float | None]]) -> Iterator[Dependence]:
    """Yield pairs of quantities that hang together, and quantities that hang on their last draw.

    By ranks, so that one random number behind both shows, however it is turned into them; and by
    the distance of ranks from their middle, for one that is folded.
    """
    from scipy.stats import rankdata

    ranks = {
        name: rankdata(np.array(values, float))
        for name, values in columns.items()
        if all(value is not None for value in values) and len(values) >= FEWEST
    }
    pairs = [(a, b, ranks[a], ranks[b]) for a, b in itertools.combinations(ranks, 2)]
    pairs += [(a, f"the {a} before it", r[1:], r[:-1]) for a, r in ranks.items()]
    for a, b, x, y in pairs:
        n = len(x)
        folded = [np.abs(r - (n + 1) / 2) for r in (x, y)]
        both = itertools.product((x, folded[0]), (y, folded[1]))
        size = max(abs(float(np.corrcoef(u, v)[0, 1])) * math.sqrt(n) for u, v in both)
        if size > TOO_ALIKE:
            sentence = f"{a} hangs on {b}: the correlation of their ranks is "
            sentence += f"{size / math.sqrt(n):.2f}; draw a random number of its own for each"
            yield Dependence(
                quantity=f"{a} and {b}", named=["dependence"], statistic=size, sentence=sentence
            )


def _judge(quantity: str, values: Array) -> Drawn:
    if quantity == "swing.tilt":
        largest = {"": _paper().largest_tilt, "tilt-in-degrees": 10.0}
        sizes = {name: _kolmogorov(values / top, "uniform") for name, top in largest.items()}
        name = "" if sizes[""] < CRITICAL else min(sizes, key=lambda n: sizes[n])
        return _drawn(quantity, (name,) if name else (), sizes[name])
    ways = {"pitch.speed": _speeds, "swing.height_offset": _offsets, "pitch.aim[0]": _aims}
    guesses = ways[quantity](values)
    best = max(guesses, key=lambda guess: guess.log_likelihood(values) - guess.doubt)
    note = ""
    if best.fitted:
        width = best.scale * SamplingReading().cell_width
        note = f", with cells {width:.3g} m wide: ask for the reading cell_width"
    return _drawn(quantity, best.named, _kolmogorov(values, best.distribution), note)


# --- ways of drawing ------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Guess:
    """A way to draw a quantity."""

    named: tuple[str, ...]  # the mistakes in it
    mixture: Mixture  # what is drawn from
    scale: float = 1.0  # times so much
    positive: bool = False  # whether what is not positive is thrown away
    fitted: bool = False  # whether the scale was fitted to the values

    @property
    def doubt(self) -> float:
        """How much likelier than what the paper means it has to be, as a logarithm."""
        return LIKELIER * (bool(self.named) + 2 * self.fitted)

    @property
    def lost(self) -> float:
        """The share that is thrown away."""
        return float(self.mixture.distribution.cdf(0.0)) if self.positive else 0.0

    def distribution(self, values: Array) -> Array:
        """Return the distribution function."""
        below = self.mixture.distribution.cdf(values / self.scale)
        kept: Array = np.clip((below - self.lost) / (1 - self.lost), 0.0, 1.0)
        return kept

    def log_likelihood(self, values: Array) -> float:
        """Return the logarithm of the likelihood of values."""
        x = values / self.scale
        if self.positive and (x <= 0).any():
            return -math.inf
        terms = self.mixture.distribution.logpdf(x) - math.log(self.scale * (1 - self.lost))
        return float(terms.sum())


def _paper(**switches: object) -> AtBats:
    return paper_at_bats(SamplingReading.model_validate(switches))


def _speeds(values: Array) -> Iterator[_Guess]:
    for table, spread, unit in itertools.product(
        ("columns_swapped", "as_printed"), ("standard_deviation", "as_printed"), (1.0, 3.6)
    ):
        made = {"table-columns": table, "missing-2": spread, "speed-in-km/h": unit}
        named = tuple(name for name, how in made.items() if how in ("as_printed", 3.6))
        mixture = _paper(speed_table=table, speed_spread=spread).speed
        yield _Guess(named, mixture, unit)
        if table == "as_printed":  # half of which are below zero, and no pitches
            yield _Guess(named, mixture, unit, positive=True)


def _aims(values: Array) -> Iterator[_Guess]:
    aim = _paper().aim
    yield _Guess((), aim)
    cell = SamplingReading().cell_width
    yield _Guess(("cells-for-metres",), aim, 1 / cell)
    middle = Mixture(aim.weight, (2.0, 4.0), (0.77, 0.77))
    yield _Guess(("cells-from-the-edge",), middle, 1.0)
    yield _Guess(("cells-from-the-edge",), middle, cell)
    yield _Guess(("left-for-right",), Mixture(1 - aim.weight, aim.means, aim.deviations))
    # The paper does not say how wide a cell is: any width will do, the one that fits best.
    (left, right), deviation = aim.means, aim.deviations[0]
    expected = aim.weight * left**2 + (1 - aim.weight) * right**2 + deviation**2
    scale = math.sqrt(float(np.mean(values**2)) / expected)
    if scale > 0:
        yield _Guess((), aim, scale, fitted=True)


def _offsets(values: Array) -> Iterator[_Guess]:
    right = _paper().offset_deviation
    wrong = {"radius-or-diameter": 2 * right, "missing-2": right * math.sqrt(0.5)}
    for name, deviation in {"": right, **wrong}.items():
        mixture = Mixture(1.0, (0.0, 0.0), (deviation, deviation))
        yield _Guess((name,) if name else (), mixture)


def _kolmogorov(values: Array, distribution: str | Callable[[Array], Array]) -> float:
    """Return Kolmogorov's √n D of values."""
    from scipy.stats import kstest  # which takes a second to load

    return math.sqrt(len(values)) * float(kstest(values, distribution, method="asymp").statistic)


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


def _drawn(quantity: str, named: tuple[str, ...], statistic: float, note: str = "") -> Drawn:
    fits = statistic < CRITICAL
    if fits:
        said = "; ".join(_SENTENCES[n] for n in named) or f"drawn as the paper means it{note}"
    else:
        named, said = (), "drawn from none of the known distributions"
    sentence, names = f"{quantity}: {said}", list(named)
    return Drawn(quantity=quantity, named=names, fits=fits, statistic=statistic, sentence=sentence)


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


def _constant(quantity: str, paper: float, met: Sequence[float]) -> Constant | None:
    same = partial(math.isclose, rel_tol=1e-9)
    others = [value for value in met if not same(value, paper)]
    if not others:
        return None
    slips = _SLIPS.get(quantity, ())
    named = [name for name, values in slips if any(same(others[0], value) for value in values)]
    sentence = f"{quantity}: {others[0]:g}, where the paper has {paper:g}"
    return Constant(quantity=quantity, paper=paper, given=others, named=named, sentence=sentence)
