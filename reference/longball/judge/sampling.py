"""Which known mistakes are in the random at-bats that a candidate draws.

Some mistakes are made before any scene is there to be solved: the columns of Table II taken as
printed, a spread with or without its 2, a diameter for a radius. No answer to a golden scene can
show them; the scenes that a candidate draws do. Every combination of readings of the sampling is a
distribution, and the likelihood of the drawn numbers tells them apart.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from longball.home_run import AtBats, Mixture, paper_at_bats
from longball.model.readings import Reading
from longball.model.scene import AtBatScene

Array = NDArray[np.float64]

# Kolmogorov's statistic √n D exceeds this once in a hundred thousand samples of the right
# distribution (2 exp(-2 x²) = 1e-5); four quantities are tested.
CRITICAL = 2.47

# Another way of drawing is named only if the numbers are this much likelier under it (a natural
# logarithm): a hundred thousand times, too.
LIKELIER = math.log(1e5)

# Fewer at-bats cannot tell a spread from √2 times it.
FEWEST = 50


class Drawn(BaseModel):
    """How one random quantity of the at-bats was drawn."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    quantity: str
    named: list[str] = Field(description="the mistakes in it; empty if it is as the paper means")
    fits: bool = Field(description="whether the distribution so named fits")
    statistic: float = Field(description="Kolmogorov's √n D beside that distribution")
    sentence: str


@dataclass(frozen=True)
class _Guess:
    """A way to draw a quantity: the mistakes in it, and its distribution function."""

    named: tuple[str, ...]
    mixture: Mixture
    scale: float = 1.0


def judge_samples(scenes: Iterable[AtBatScene]) -> list[Drawn]:
    """Return what is right and wrong in the random numbers of drawn at-bats.

    Parameters
    ----------
    scenes
        As a candidate draws them from the paper's distributions, at least `FEWEST`.

    Raises
    ------
    ValueError
        If there are too few.
    """
    scenes = list(scenes)
    if len(scenes) < FEWEST:
        raise ValueError(f"{len(scenes)} at-bats; {FEWEST} are needed to tell how they are drawn")
    drawn = {
        "pitch.speed": [scene.pitch.speed for scene in scenes],
        "pitch.aim": [scene.pitch.aim[0] for scene in scenes],
        "swing.height_offset": [scene.swing.height_offset for scene in scenes],
    }
    guesses = {
        "pitch.speed": list(_speeds()),
        "pitch.aim": list(_aims()),
        "swing.height_offset": list(_offsets()),
    }
    found = [_judge(name, np.array(drawn[name]), guesses[name]) for name in drawn]
    return [*found, _judge_tilt(np.array([scene.swing.tilt for scene in scenes]))]


def _paper(**switches: object) -> AtBats:
    return paper_at_bats(Reading.model_validate(switches))


def _speeds() -> Iterable[_Guess]:
    for table, spread, unit in itertools.product(
        ("columns_swapped", "as_printed"),
        ("standard_deviation", "as_printed"),
        (("", 1.0), ("speed-in-km/h", 3.6)),
    ):
        named = []
        if table == "as_printed":
            named.append("table-columns")
        if spread == "as_printed":
            named.append("missing-2")
        if unit[0]:
            named.append(unit[0])
        mixture = _paper(speed_table=table, speed_spread=spread).speed
        yield _Guess(tuple(named), mixture, unit[1])


def _aims() -> Iterable[_Guess]:
    aim = _paper().aim
    yield _Guess((), aim)
    cell = Reading().cell_width
    yield _Guess(("cells-for-metres",), aim, 1 / cell)
    middle = Mixture(aim.weight, (2.0, 4.0), (0.77, 0.77))
    yield _Guess(("cells-from-the-edge",), middle, 1.0)
    yield _Guess(("cells-from-the-edge",), middle, cell)


def _offsets() -> Iterable[_Guess]:
    for name, deviation in (("", 0.0366), ("radius-or-diameter", 0.0732), ("missing-2", 0.02588)):
        mixture = Mixture(1.0, (0.0, 0.0), (deviation, deviation))
        yield _Guess((name,) if name else (), mixture)


def _judge(quantity: str, values: Array, guesses: Sequence[_Guess]) -> Drawn:
    # What the paper means is not doubted without need.
    likelihoods = [_log_likelihood(values, guess) for guess in guesses]
    likeliest = int(np.argmax(likelihoods))
    best = likeliest if likelihoods[likeliest] > likelihoods[0] + LIKELIER else 0
    return _said(quantity, guesses[best].named, _kolmogorov(values, guesses[best]))


def _log_likelihood(values: Array, guess: _Guess) -> float:
    mixture, x = guess.mixture, values / guess.scale
    terms = [
        math.log(weight / (deviation * math.sqrt(2 * math.pi) * guess.scale))
        - 0.5 * ((x - mean) / deviation) ** 2
        for weight, mean, deviation in zip(
            (mixture.weight, 1 - mixture.weight), mixture.means, mixture.deviations, strict=True
        )
        if weight > 0
    ]
    return float(np.logaddexp.reduce(np.array(terms), axis=0).sum())


def _judge_tilt(values: Array) -> Drawn:
    largest = {"": math.radians(10.0), "tilt-in-degrees": 10.0}
    statistics = {
        name: _distance(np.clip(np.sort(values) / top, 0.0, 1.0)) for name, top in largest.items()
    }
    best = "" if statistics[""] < CRITICAL else min(statistics, key=lambda n: statistics[n])
    return _said("swing.tilt", (best,) if best else (), statistics[best])


def _kolmogorov(values: Array, guess: _Guess) -> float:
    mixture = guess.mixture
    ordered = np.sort(values) / guess.scale
    first, second = (
        np.array([NormalDist(mean, deviation).cdf(float(x)) for x in ordered])
        for mean, deviation in zip(mixture.means, mixture.deviations, strict=True)
    )
    return _distance(mixture.weight * first + (1 - mixture.weight) * second)


def _distance(expected: Array) -> float:
    """Return √n D of sorted values at which the distribution function is `expected`."""
    n = len(expected)
    steps = np.arange(n + 1) / n
    return float(math.sqrt(n) * max((steps[1:] - expected).max(), (expected - steps[:-1]).max()))


_SENTENCES = {
    "table-columns": "μ and σ are taken from Table II's columns as printed; they are exchanged",
    "missing-2": "the spread is taken without the 2 that Eq. 2 lacks",
    "speed-in-km/h": "it is in km/h; a scene's speed is in m/s",
    "cells-for-metres": "it is in cells; a cell is 0.144 m wide",
    "cells-from-the-edge": "cells are counted from the edge; the middle one, 3, lies at y = 0",
    "radius-or-diameter": "its spread is the ball's diameter; 0.0366 m is the radius",
    "tilt-in-degrees": "it is in degrees; a scene's tilt is in radians",
}


def _said(quantity: str, named: tuple[str, ...], statistic: float) -> Drawn:
    fits = statistic < CRITICAL
    if not fits:
        sentence = "drawn from none of the known distributions"
        named = ()
    elif named:
        sentence = "; ".join(_SENTENCES[name] for name in named)
    else:
        sentence = "drawn as the paper means it"
    return Drawn(
        quantity=quantity,
        named=list(named),
        fits=fits,
        statistic=statistic,
        sentence=f"{quantity}: {sentence}",
    )
