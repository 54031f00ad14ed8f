"""Evidence for an edit, in bits: what it leaves, and what its free number costs.

An error of size r, in units of its floor, costs ½ log2(1 + r²) bits: nothing within the floor, and
one bit more for each factor of two beyond it. An edit is *adequate* if no number of any scene is
more than `ADEQUATE` floors off, and *better than chance* if it saves `CHANCE` bits beyond its own
cost and that of the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from longball.model.arrays import Array

BEYOND = 1e12  # floors: errors that are larger cost no more
ADEQUATE = 4.0  # floors: no number of any scene may be farther off
CHANCE = 20.0  # bits beyond chance: one in a million
ROUGH = 0.05  # of the numbers of wrong scenes, of an edit with jumps or kinks: as many may be off

# Bits of a digit of a free number, and of the fact that it is one.
DIGIT, NUMBER = math.log2(10), 3.0


def cost(r: Array) -> float:
    """Bits that errors cost, in units of their floors."""
    known = np.clip(r[np.isfinite(r)], -BEYOND, BEYOND)
    return float(np.log2(1.0 + known * known).sum()) / 2.0


def is_adequate(
    r: Array, rough: bool = False, wrong: NDArray[np.bool_] | slice = slice(None)
) -> bool:
    """True if errors, in units of their floors, are all within `ADEQUATE` of them.

    Those of a `rough` edit may be beyond it in `ROUGH` of as many numbers as the scenes have that
    are `wrong` without the edit: right ones are no evidence for it.
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
        # Each number in units of its effect: a gravity and a density have one scale then, and the
        # pseudo-inverse drops a number only if its effect is that of the other.
        steep = np.sqrt(np.einsum("kirn,kirn->ki", down, down))
        down /= np.where(steep > 0, steep, 1.0)[..., None, None]
        normal = np.einsum("kirn,kjrn->kij", down, down)
        along = np.einsum("kirn,krn->ki", down, off)
        scaled = np.einsum("kij,kj->ki", np.linalg.pinv(normal, 1e-12, hermitian=True), along)
        step = -np.divide(scaled, steep, out=np.zeros_like(scaled), where=steep > 0)
        before, moving = _squares(r), (step != 0.0).any(axis=1)
        for share in (1.0, 0.3):  # far from the minimum a shorter step may succeed
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
    # One-sided differences. All starts, and each with every number displaced, are one call.
    starts, numbers = c.shape
    h = 1e-6 * np.maximum(np.abs(c), 1e-3)
    beside = c[:, None] + h[:, None] * np.eye(numbers)
    every = residual(np.concatenate([c, beside.reshape(c.size, numbers)]))
    r, moved = every[:starts].copy(), every[starts:].reshape(starts, numbers, *every.shape[1:])
    return r, (moved - r[:, None]) / h[..., None, None]


def _squares(r: Array) -> Array:
    return np.asarray(np.where(np.isfinite(r), r * r, 0.0).sum(axis=(1, 2)))


STAYS = 0.8  # another round follows if the sum of squares fell to this fraction

NEAR = 1e-3  # relative: a usual number that is farther from the fitted one is not it


def rounded(c: float, usual: Collection[float] = ()) -> Iterator[tuple[float, float]]:
    """Usual and the roundest numbers near a fitted one, with their cost in bits.

    People write short numbers: one of three digits is likelier than one of twelve that fits a
    little better. Whoever calls this adds the cost of what each number leaves.
    """
    yield from ((x, NUMBER) for x in (0.0, 1.0))
    for x in usual:
        if abs(x - c) < NEAR * abs(x):
            yield x, math.log2(len(usual))
    for digits in range(1, 9):
        yield float(f"{c:.{digits}g}"), NUMBER + DIGIT * digits
    yield c, NUMBER + DIGIT * 12
