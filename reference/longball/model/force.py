"""What a law of motion is made of: forces, and what they depend on.

A flight has a frame of its own: s along the horizontal direction of the launch, y to the left of
it, z up; u, v, w are the components of the velocity. Forces are traced (`longball.model.trace`):
they are functions of nodes, and a parameter that is absent is the node ZERO.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from longball.model import trace
from longball.model.numbers import Numbers, Vector
from longball.model.trace import ZERO, Node

# From a scene, the `longball.model.frame.Frame` of a flight and a number system to the values of a
# term's parameters, None for one that is zero; None if the scene does not name the term.
Strengths = Callable[[Any, Any, Numbers[Any]], tuple[Any, ...] | None]


class Flow(NamedTuple):
    """The ball's velocity through the air, m/s, and its size."""

    velocity: Vector[Any]
    speed: Any


class Motion(NamedTuple):
    """What a force may depend on, in the frame of the flight.

    Attributes
    ----------
    position
        m.
    velocity
        Over the ground, m/s.
    air
        What drag depends on.
    lift
        What lift depends on: the same, unless the reading keeps the wind from the lift.
    density
        Of the air, relative to that at height 0.
    spin_left
        Size of the spin, relative to that at launch.
    """

    position: Vector[Any]
    velocity: Vector[Any]
    air: Flow
    lift: Flow
    density: Any
    spin_left: Any

    @property
    def speed(self) -> Any:
        """The airspeed, m/s."""
        return self.air.speed


@dataclass(frozen=True)
class Term:
    """A term of the law.

    Attributes
    ----------
    parameters
        Names of its parameters. The term is in the law if one of them has a value.
    strengths
        Their values.
    """

    parameters: tuple[str, ...]
    strengths: Strengths


@dataclass(frozen=True)
class Force(Term):
    """A force: from the motion and the parameters to the acceleration, m/s²."""

    acceleration: Callable[[Motion, Any], Vector[Any]]


@dataclass(frozen=True)
class Drag(Term):
    """A drag: from the motion and the parameters to the rate r, 1/s, of ``-r u``.

    u is the velocity through the air.
    """

    rate: Callable[[Motion, Any], Any]


@dataclass(frozen=True)
class Lift(Term):
    """A lift: from the motion and the parameters to the factor f of ``f (ω × u)``.

    ω is the spin at launch, u the velocity through the air.
    """

    factor: Callable[[Motion, Any], Any]


@dataclass(frozen=True)
class Wind(Term):
    """A wind: from the position and the parameters to its velocity, m/s.

    `lifts` tells whether it acts on the lift, besides the drag.
    """

    velocity: Callable[[Vector[Any], Any], Vector[Any]]
    lifts: bool = True


@dataclass(frozen=True)
class Thinning(Term):
    """How the density of the air, relative to that at height 0, depends on the position."""

    density: Callable[[Vector[Any], Any], Any]


@dataclass(frozen=True)
class Decay(Term):
    """How spin decays."""

    # Of what it decays along, the variable `path` of the state, m/s: from the motion, but for its
    # spin, and the parameters.
    rate: Callable[[Motion, Any], Any]
    # The spin that is left, relative to that at launch: from `path`, the airspeed and the
    # parameters.
    left: Callable[[Any, Any, Any], Any]


class Branches(NamedTuple):
    """The forms that a term takes, one after the other, as what it depends on grows."""

    levels: tuple[Any, ...]  # where one form ends and the next begins, in rising order
    # For each form, as a term has them; one more than levels.
    strengths: tuple[tuple[Any, ...], ...]


@dataclass(frozen=True)
class Piecewise(Term):
    """A term whose parameters change where something passes a level."""

    term: Term  # the term itself
    # From a scene, a frame and a number system; None if the scene does not name the term.
    branches: Callable[[Any, Any, Numbers[Any]], Branches | None]
    # What passes the levels, as top and bottom of a fraction that are built of + - * alone, the
    # bottom positive.
    argument: Callable[[Motion, Any], tuple[Any, Any]]
    question: str  # that it does, as a clause


def switched(scene: Any, frame: Any, numbers: Numbers[Any]) -> None:
    """Return no strengths: those of a `Piecewise` term are its branches'."""


def present(values: tuple[Any, ...], numbers: Numbers[Any]) -> tuple[Any, ...] | None:
    """Return strengths with None for those that are zero; None if all are."""
    known = tuple(None if numbers.absent(value) else value for value in values)
    return known if any(value is not None for value in known) else None


def plus(a: Vector[Any], b: Vector[Any]) -> Vector[Any]:
    """Return ``a + b``."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def scaled(factor: Any, a: Vector[Any]) -> Vector[Any]:
    """Return ``factor a``."""
    return factor * a[0], factor * a[1], factor * a[2]


def cross(a: Vector[Any], b: Vector[Any]) -> Vector[Any]:
    """Return ``a × b``."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def square(vector: Vector[Any]) -> Node:
    """Return the square of a vector's size, in the form that `trace.squares` knows."""
    return trace.total(trace.square(x) for x in vector if x is not ZERO)


def size(vector: Vector[Any]) -> Node:
    """Return the size of a vector."""
    squared = square(vector)
    return squared if squared is ZERO else trace.sqrt(squared)
