"""Which of an at-bat's four random inputs the distance D comes from: Sobol's indices."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from analysis.paper import balls
from analysis.writing import Report
from longball.home_run import HOME_RUN_DISTANCE, Samples
from longball.model.arrays import Array

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
    one, other, swapped = a - middle, b - middle, mixed - middle

    def of_rows(rows: Any) -> Array:
        a, b, mixed = one[rows], other[rows], swapped[:, rows]
        variance = np.concatenate([a, b]).var()
        first = (b * (mixed - a)).mean(axis=1) / variance
        return np.array([first, ((a - mixed) ** 2).mean(axis=1) / (2 * variance)])

    generator = np.random.default_rng(seed)
    resampled = [of_rows(generator.integers(len(a), size=len(a))) for _ in range(RESAMPLES)]
    (first, total), errors = of_rows(slice(None)), np.std(resampled, axis=0, ddof=1)
    return Indices(first, errors[0], total, errors[1])


def quantities(base: balls.Base, samples: Samples) -> dict[str, Array]:
    """Return D of at-bats, 0 for a miss, and flags of the home runs."""
    (struck,) = balls.strike(base, samples, [E])
    distance = np.where(struck.batted, struck.distance, 0.0)
    return {
        "D": distance,
        "D of balls hit upwards": np.where(struck.elevation > 0, distance, 0.0),
        "D ≥ 150 m": (distance >= HOME_RUN_DISTANCE).astype(float),
    }


def section(report: Report, bases: dict[str, balls.Base]) -> str:
    """Write the section: the indices of each quantity, under each reading."""
    found: dict[str, dict[str, Indices]] = {name: {} for name in bases}
    for name, base in bases.items():
        one, other = (base.drawn(SAMPLES, seed) for seed in SEEDS)
        a, b = quantities(base, one), quantities(base, other)
        mixed = [quantities(base, replace(one, **{x: getattr(other, x)})) for x in INPUTS]
        for what in a:
            both = np.array([each[what] for each in mixed])
            found[name][what] = indices(a[what], b[what], both, SEEDS[0])
    return report.render("variance", globals(), found=found, bases=bases)
