"""Steps of velocity Verlet, in any number of dimensions: the code that numba compiles for each law.

This source runs in a separate namespace together with functions that `longball.engines.verlet`
prints for a law. Vectors are tuples of as many numbers as there are dimensions.
"""

# ruff: noqa: F821  (the names declared below are defined where this runs)

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

# Printed: the acceleration at a position and velocity, given the parameters; a + factor b; where a
# position is after dt at a velocity, the path through the air being one too; the largest size of a
# component; what writes position and velocity into a column of an array.
accelerate: Callable[..., Any]
plus: Callable[..., Any]
moved: Callable[..., Any]
largest: Callable[..., Any]
write: Callable[..., None]

# An implicit step has settled when v' changes by no more than its rounding, and has failed when it
# has not after this many rounds: a ball's first change is a hundredth of the one before.
SETTLED = 2.0**-52
ROUNDS = 100  # a free choice


def step(
    # position, velocity: m, m/s
    position: Any,
    velocity: Any,
    force: Any,  # m/s², of the law: what the step begins with
    # push, pushed: m/s², in addition to the law's at the start and at the end of the step
    push: Any,
    pushed: Any,
    dt: float,  # s
    # ahead, iterates, carries: see `longball.engines.verlet.Treatment`
    ahead: float,
    iterates: bool,
    carries: bool,
    parameters: Any,  # of the law
) -> Any:
    """Return position, velocity and force after a step: the force that the next one begins with.

    NaN where an implicit step does not settle.
    """
    # v½ = v + a Δt/2, r' = r + v½ Δt, and a' at the velocity of the treatment
    felt = plus(force, 1.0, push)
    half = plus(velocity, 0.5 * dt, felt)
    position = moved(position, dt, half, parameters)
    force = accelerate(position, plus(velocity, ahead * dt, felt), parameters)
    velocity = plus(half, 0.5 * dt, plus(force, 1.0, pushed))
    # implicit: a' at the v' that it leads to, by iteration
    if iterates:
        settled = False
        for _ in range(ROUNDS):
            old = velocity
            force = accelerate(position, old, parameters)
            velocity = plus(half, 0.5 * dt, plus(force, 1.0, pushed))
            if largest(plus(velocity, -1.0, old)) <= SETTLED * largest(velocity):
                settled = True
                break
        if not settled:
            velocity = plus(velocity, math.nan, velocity)
    # recomputed: the next step begins with a' at v'
    if not carries:
        force = accelerate(position, velocity, parameters)
    return position, velocity, force


def march(
    states: Any,
    position: Any,
    velocity: Any,
    force: Any,
    dt: float,
    ahead: float,
    iterates: bool,
    carries: bool,
    parameters: Any,
) -> Any:
    """Fill an array with the states after one step, two, …, from its second column on.

    Returns the force that the next step begins with.
    """
    nothing = plus(velocity, -1.0, velocity)
    for k in range(1, states.shape[1]):
        position, velocity, force = step(
            position, velocity, force, nothing, nothing, dt, ahead, iterates, carries, parameters
        )
        write(states, k, position, velocity)
    return force
