"""A golden case before it is solved, and the means to choose its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext

from longball.model.scene import Scene


@dataclass(frozen=True)
class Draft:
    """A scene that is to become a golden case; the scene's id is the case's.

    Attributes
    ----------
    scene
        What is to be solved.
    comment
        What the case tests.
    flags
        Known in advance; others follow from its solution.
    """

    scene: Scene
    comment: str
    flags: tuple[str, ...] = ()


# Square roots of primes: their multiples fill a cube evenly (Kronecker's sequence), with nothing
# but arithmetic that is the same on every machine.
_IRRATIONAL = tuple(math.sqrt(prime) % 1.0 for prime in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29))


def shares(index: int) -> tuple[float, ...]:
    """Return ten numbers in [0, 1) that fill the cube evenly as `index` runs from 0."""
    return tuple((0.5 + index * alpha) % 1.0 for alpha in _IRRATIONAL)


def five_digits(x: float) -> float:
    """Return a number that a reader can retype, and that no last bit of a sine changes."""
    return float(f"{x:.5g}")


def between(low: float, high: float, share: float) -> float:
    """Return a number between two, with five digits."""
    return five_digits(low + (high - low) * share)


def between_powers(low: float, high: float, share: float) -> float:
    """Return a number between two positive ones, even in its logarithm; three digits."""
    return float(f"{low * (high / low) ** share:.3g}")


def solve_for(
    quantity: Callable[[float], Decimal], target: str, first: float, second: float
) -> float:
    """Return the double at which a quantity comes nearest to a target.

    By the secant method from two guesses. The quantity is known to far more digits than a double
    has, so that the choice does not depend on who computes it.

    Raises
    ------
    ValueError
        If the method does not settle.
    """
    with localcontext(prec=60):
        goal = Decimal(target)
        a, b = first, second
        miss_a, miss_b = quantity(a) - goal, quantity(b) - goal
        for _ in range(_MOST_STEPS):
            if abs(miss_a) < abs(miss_b):
                a, b, miss_a, miss_b = b, a, miss_b, miss_a
            if miss_b == 0 or miss_a == miss_b:
                return b
            slope = (miss_b - miss_a) / (Decimal(b) - Decimal(a))
            following = float(Decimal(b) - miss_b / slope)
            if following in (a, b):
                return b
            a, miss_a = b, miss_b
            b, miss_b = following, quantity(following) - goal
    raise ValueError(f"no double found at which the quantity is {target}")


# The secant method gains half as many digits again each time: a dozen steps for sixteen of them.
_MOST_STEPS = 30
