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

from longball.model.arrays import Array

BEYOND = 1e12  # floors: errors that are larger cost no more
ADEQUATE = 4.0  # floors: no number of any scene may be farther off
CHANCE = 20.0  # bits beyond chance: one in a million
ROUGH = 0.05  # of the numbers, what may be farther off where an edit has jumps or kinks

# Bits of a digit of a free number, and of the fact that it is one.
DIGIT, NUMBER = math.log2(10), 3.0


def cost(r: Array) -> float:
    """Bits that errors cost, in units of their floors."""
    known = np.clip(r[np.isfinite(r)], -BEYOND, BEYOND)
    return float(np.log2(1.0 + known * known).sum()) / 2.0


def is_adequate(r: Array, rough: bool = False) -> bool:
    """True if errors, in units of their floors, are all within `ADEQUATE` of them."""
    known = np.abs(r[np.isfinite(r)])
    beyond = float(np.mean(known > ADEQUATE)) if known.size else 1.0
    return beyond <= (ROUGH if rough else 0.0)


def fitted(
    residual: Callable[[float], Array], starts: Sequence[float], rounds: int = 5
) -> tuple[float, Array]:
    """The free number that leaves least, by Gauss-Newton from some starts, and what it leaves."""
    best: tuple[float, float, Array] | None = None
    for start in starts:
        c, r = start, residual(start)
        for _ in range(rounds):
            slope = slope_of(residual, c, r)
            known = np.isfinite(slope) & np.isfinite(r)
            square = float((slope[known] ** 2).sum())
            if not square > 0:
                break
            step = -float((slope[known] * r[known]).sum()) / square
            again = residual(c + step)
            if not _square(again) < _square(r):  # far from the best number a shorter step may do
                step *= 0.3
                again = residual(c + step)
            if not _square(again) < _square(r):
                break
            done = _square(again) > STAYS * _square(r)
            c, r = c + step, again
            if done:
                break
        if best is None or _square(r) < best[0]:
            best = _square(r), c, r
        if cost(r) < DONE * r.size:
            break
    assert best is not None
    return best[1], best[2]


def slope_of(residual: Callable[[float], Array], c: float, r: Array) -> Array:
    """The derivative of a residual by its free number; `r` is its value there."""
    h = 1e-6 * max(abs(c), 1e-3)
    return (residual(c + h) - r) / h


def _square(r: Array) -> float:
    return float((r[np.isfinite(r)] ** 2).sum())


STAYS = 0.8  # of the sum of squares, what a round may leave for the last time
DONE = 0.5  # bits a number: less is within the floors

NEAR = 1e-3  # relative: a usual number that is farther from the fitted one is not it


def rounded(c: float, usual: Collection[float] = ()) -> Iterator[tuple[float, float]]:
    """Usual and the roundest numbers near a fitted one, with their cost in bits."""
    yield 0.0, NUMBER
    for x in usual:
        if abs(x - c) < NEAR * abs(x):
            yield x, math.log2(len(usual))
    for digits in range(1, 9):
        yield float(f"{c:.{digits}g}"), NUMBER + DIGIT * digits
    yield c, NUMBER + DIGIT * 12
