"""A golden case before it is solved, and the means to choose its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any, TypeVar

from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.golden.case import numbers_of
from longball.model.block import Point
from longball.model.quantities import replaced
from longball.model.readings import Reading
from longball.model.scene import AtBatScene, FlightScene, ImpactScene, Launch, Scene

S = TypeVar("S", FlightScene, ImpactScene, AtBatScene)

# Digits with which numbers are chosen: a margin of 1e-15 m to all that a double can tell of it.
CHOOSING = Enclosure(digits=40)


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


def draft(scene: Scene, comment: str, *flags: str) -> Draft:
    """Return a draft whose last flag says that its reading is not the default, if it is not."""
    return Draft(scene, comment, (*flags, "reading") if scene.reading != Reading() else flags)


def flight(
    name: str, velocity: Point, *, height: float = 1.0, spin: Point | None = None, **blocks: Any
) -> FlightScene:
    """Return a flight from a height above the plate."""
    launch = Launch(position=(0.0, 0.0, height), velocity=velocity, spin=spin)
    return FlightScene(id=name, launch=launch, **blocks)


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


def towards(speed: float, elevation: float, heading: float = 0.0) -> Point:
    """Return a velocity, m/s, of an elevation and a heading in degrees, with five digits."""
    up, left = math.radians(elevation), math.radians(heading)
    ahead = speed * math.cos(up)
    return (
        five_digits(ahead * math.cos(left)),
        five_digits(ahead * math.sin(left)),
        five_digits(speed * math.sin(up)),
    )


def beside(x: float) -> tuple[tuple[str, float], ...]:
    """Return a number between its two neighbours among the doubles."""
    return (
        ("below", math.nextafter(x, -math.inf)),
        ("at", x),
        ("above", math.nextafter(x, math.inf)),
    )


def number(name: str) -> Callable[[Scene], Decimal]:
    """Return the function that solves a scene for a number of its result."""
    return lambda scene: Decimal(dict(numbers_of(solve(scene, CHOOSING)))[name].value)


def with_nearest(
    scene: S,
    quantity: Callable[[S], Decimal],
    target: str,
    guesses: tuple[float, float],
    *inputs: str,
) -> S:
    """Return a scene with the double at which a quantity of it comes nearest to a target.

    The double is the value of all the inputs named.
    """

    def at(x: float) -> S:
        return replaced(scene, dict.fromkeys(inputs, x))

    return at(solve_for(lambda x: quantity(at(x)), target, *guesses))


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
