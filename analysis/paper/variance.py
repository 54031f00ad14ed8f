"""Which of an at-bat's four random inputs the distance D comes from: Sobol's indices."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from analysis import Array
from analysis.paper.balls import SPACES, Base, describe, strike
from analysis.writing import render
from longball.home_run import HOME_RUN_DISTANCE, Samples

INPUTS = {"speed": "pitch's speed", "aim": "aim", "tilt": "tilt", "offset": "offset"}
SAMPLES = 50_000  # of each of the two sets; six times as many at-bats are solved
SEEDS = (11, 12)
RESAMPLES = 200
E = 0.42


class Indices(NamedTuple):
    """Shares of a variance that inputs have, with standard errors; arrays of shape (inputs,)."""

    first: Array  # what an input explains alone
    first_error: Array
    total: Array  # what it has a part in
    total_error: Array


def indices(a: Array, b: Array, mixed: Array, seed: int) -> Indices:
    """Return Sobol's indices of first order and total.

    Parameters
    ----------
    a, b
        The quantity for two independent sets of n samples: shape (n,).
    mixed
        The quantity for the first set with one input taken from the second: shape (inputs, n).
    seed
        Of the bootstrap that the standard errors come from.

    Notes
    -----
    First order: A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259, Table 2 (b). Total:
    M. J. W. Jansen, Comput. Phys. Commun. 117 (1999) 35.
    """
    middle = (a.mean() + b.mean()) / 2  # centred: less noise, the same indices
    a, b, mixed = a - middle, b - middle, mixed - middle
    generator = np.random.default_rng(seed)
    resampled = []
    for _ in range(RESAMPLES):
        rows = generator.integers(len(a), size=len(a))
        resampled.append(_saltelli_jansen(a[rows], b[rows], mixed[:, rows]))
    first, total = _saltelli_jansen(a, b, mixed)
    first_error, total_error = np.std(resampled, axis=0, ddof=1)
    return Indices(first, first_error, total, total_error)


def _saltelli_jansen(a: Array, b: Array, mixed: Array) -> Array:
    variance = np.concatenate([a, b]).var()
    first = (b * (mixed - a)).mean(axis=1) / variance
    total = ((a - mixed) ** 2).mean(axis=1) / (2 * variance)
    return np.array([first, total])


def quantities(base: Base, samples: Samples) -> dict[str, Array]:
    """Return what is asked of at-bats: D, 0 for a miss, and whether it is a home run's."""
    (balls,) = strike(base, samples, [E])
    distance = np.where(balls.batted, balls.distance, 0.0)
    return {
        "D": distance,
        "D of balls hit upwards": np.where(balls.elevation > 0, distance, 0.0),
        "D ≥ 150 m": (distance >= HOME_RUN_DISTANCE).astype(float),
    }


def section(report: Path, bases: dict[str, Base]) -> str:
    """Write the section: the indices of each quantity, under each reading."""
    found = {}
    for name, base in bases.items():
        one, other = (base.drawn(SAMPLES, seed) for seed in SEEDS)
        a, b = quantities(base, one), quantities(base, other)
        mixed = [quantities(base, replace(one, **{x: getattr(other, x)})) for x in INPUTS]
        found[name] = {
            what: indices(a[what], b[what], np.array([each[what] for each in mixed]), SEEDS[0])
            for what in a
        }
    described = {name: describe(base, SPACES[0]) for name, base in bases.items()}
    return render(report, "variance", globals(), found=found, bases=described)
