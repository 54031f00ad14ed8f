"""Evidence for an edit, in bits: the cost of the errors that it leaves, and of its free number.

An error of size r, in units of its floor, costs ½ log2(1 + r²) bits: little within the floor, and
one bit more for each factor of two beyond it. An edit is *adequate* if all numbers of all scenes
are within `ADEQUATE` floors, and *better than chance* if it saves `CHANCE` bits more than its own
cost and that of the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from longball.model.arrays import Array

BEYOND = 1e12  # floors: larger errors cost no more; a free choice
ADEQUATE = 4.0  # floors: largest error of an adequate edit
CHANCE = 20.0  # bits: by chance an edit saves so many once in a million (2⁻²⁰)
# Numbers that may have larger errors if the edit has jumps or kinks, as a fraction of those of the
# wrong scenes.
ROUGH = 0.05

# An explanation holds for a part of the errors if it mends so many wrong scenes, and this fraction
# of them, and breaks none.
FEWEST, PART = 3, 0.3

# Cost in bits of each digit of a free number, and of having one.
DIGIT, NUMBER = math.log2(10), 3.0


def cost(r: Array) -> float:
    """Cost in bits of errors in units of their floors."""
    known = np.clip(r[np.isfinite(r)], -BEYOND, BEYOND)
    return float(np.log2(1.0 + known * known).sum()) / 2.0


def is_adequate(
    r: Array, rough: bool = False, wrong: NDArray[np.bool_] | slice = slice(None)
) -> bool:
    """True if all errors, in units of their floors, are within `ADEQUATE`; most, if `rough`.

    A few may be larger then: `ROUGH` times the number of errors in the scenes that are `wrong`
    without the edit. Right scenes add nothing to that.
    """
    known = np.isfinite(r)
    beyond = int((np.abs(r[known]) > ADEQUATE).sum())
    allowed = ROUGH * int(known[:, wrong].sum()) if rough else 0.0
    return bool(known.any()) and beyond <= allowed


def fitted(
    residual: Callable[[Array], Array], starts: Sequence[Sequence[float]] | Array, rounds: int = 8
) -> tuple[Array, Array, Array]:
    """Free numbers with the smallest residual, that residual and its derivatives.

    Gauss-Newton steps run from all starts at once. `residual` takes an array like `starts`, of
    shape (starts, numbers); the first axis of its result is that of the starts. The first axis of
    the derivatives is that of the numbers.
    """
    # In the sums k is a start, i and j are free numbers, r a row of the residual, n a scene.
    c = np.array(starts, dtype=float)
    r, slope = _with_slope(residual, c)
    for _ in range(rounds if c.size else 0):
        known = np.isfinite(slope).all(axis=1) & np.isfinite(r)
        down, off = np.where(known[:, None], slope, 0.0), np.where(known, r, 0.0)
        # Scale each number by its effect. Gravity and density then have the same scale, and the
        # pseudo-inverse drops a number only if its effect is parallel to that of another.
        steep = np.sqrt(np.einsum("kirn,kirn->ki", down, down))
        down /= np.where(steep > 0, steep, 1.0)[..., None, None]
        normal = np.einsum("kirn,kjrn->kij", down, down)
        along = np.einsum("kirn,krn->ki", down, off)
        inverse = np.linalg.pinv(normal, 1e-12, hermitian=True)  # a free choice
        scaled = np.einsum("kij,kj->ki", inverse, along)
        step = -np.divide(scaled, steep, out=np.zeros_like(scaled), where=steep > 0)
        before, moving = _squares(r), (step != 0.0).any(axis=1)
        for share in (1.0, 0.3):  # far from the minimum a shorter step may succeed; a free choice
            again, slopes = _with_slope(residual, c + share * step)
            better = moving & (_squares(again) < before)
            c = np.where(better[:, None], c + share * step, c)
            r[better], slope[better] = again[better], slopes[better]
            moving &= ~better
            if not moving.any():
                break
        if not (_squares(r) <= STAYS * before).any():
            break
    best = int(np.argmin(_squares(r)))
    return c[best], r[best], slope[best]


def _with_slope(residual: Callable[[Array], Array], c: Array) -> tuple[Array, Array]:
    # One-sided differences: one call for all starts, and for each start with each number displaced.
    starts, numbers = c.shape
    h = 1e-6 * np.maximum(np.abs(c), 1e-3)  # a free choice
    beside = c[:, None] + h[:, None] * np.eye(numbers)
    every = residual(np.concatenate([c, beside.reshape(c.size, numbers)]))
    r, moved = every[:starts].copy(), every[starts:].reshape(starts, numbers, *every.shape[1:])
    return r, (moved - r[:, None]) / h[..., None, None]


def _squares(r: Array) -> Array:
    return np.asarray(np.where(np.isfinite(r), r * r, 0.0).sum(axis=(1, 2)))


STAYS = 0.8  # another round follows if the sum of squares fell at least to this fraction

NEAR = 1e-3  # largest relative distance between a fitted number and the usual one; a free choice


def rounded(c: float, usual: Collection[float] = ()) -> Iterator[tuple[float, float]]:
    """Usual and the roundest numbers near a fitted one, with their cost in bits.

    People write short numbers: a number of three digits is likelier than one of twelve digits that
    fits a little better. The caller adds the cost of the errors that each number leaves.
    """
    yield from ((x, NUMBER) for x in (0.0, 1.0))
    for x in usual:
        if abs(x - c) < NEAR * abs(x):
            yield x, math.log2(len(usual))
    for digits in range(1, 9):
        yield float(f"{c:.{digits}g}"), NUMBER + DIGIT * digits
    yield c, NUMBER + DIGIT * 12
