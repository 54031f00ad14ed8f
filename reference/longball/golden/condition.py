"""Sensitivity of a result to its inputs, and the accuracy that doubles can attain.

**Derivatives.** They are central differences with three digits: each input of the model is moved to
either side, and the whole scene is solved again. The first step is 2^-15 of the input, or of the
length of its vector, and the scenes are solved in doubles, in milliseconds. If the differences to
both sides agree to three digits, rounding, kinks and curvature do not matter, and the outcome stays
the same in between; a difference of exactly zero counts unless the step is tiny. Otherwise the step
is 2^-50 of the input (a few ulps, because the moved input must be a double, too), and the scenes
are solved with 30 digits, in a hundred times the time. The difference of two results then has
fifteen digits less, and even for a graze with a margin of 1e-15 m the step is a small part of the
margin.

**Attainable error.** With u = 2^-53, the error of rounding to a double, relative,

    attainable(Q) = u ( Σ_i |∂Q/∂x_i| |x_i|  +  |∂Q/∂σ_b| |z_b|  +  |Q| ).

First term: a program that reads the inputs as decimals, or multiplies each of them once, has errors
like those of inputs that are off by half an ulp; a backward stable computation adds a small
multiple of that for its own roundings. Second term (at-bats): the bat is at the height z_b = z'_b +
σ_b. A double holds it to half an ulp of z_b, however small the offset σ_b that decides margin and
normal. No derivative by an input shows this error, because pitch and bat move up and down together.
Third term: the result is rounded, too. For a component, |Q| is the length of its vector, because a
program may compute the vector along other axes; for the distance along a fence to the next vertex,
|Q| is the distance of the crossing from the plate. A good implementation loses only a small
multiple of the attainable error.

N. J. Higham, Accuracy and Stability of Numerical Algorithms, Ch. 1: the rule of thumb that the
forward error is the condition number times the backward error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal

from longball.engines.chain import solve
from longball.engines.engine import Engine
from longball.engines.ivp import Ivp
from longball.golden.case import ROUNDING, Condition, as_double, decisions, decisive
from longball.model.inputs import STEP, inputs, with_input
from longball.model.quantities import numbers, numbers_of, vector_of
from longball.model.result import Bounded, Result
from longball.model.scene import AtBatScene, Scene

# Relative step of an input in doubles; see the module's docstring. It is also the step of an input
# that is zero, in its unit.
WIDE_STEP = 2.0**-15

# Largest relative difference between the differences to either side: three digits.
_RESOLVED = 1e-3

# A step shorter than this, in the unit of the input, may change nothing in doubles although the
# derivative is not zero.
_SEEN = 1e-6


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of a result by its inputs."""

    # ∂Q/∂x by quantity and input; None if steps in both directions change the outcome.
    derivatives: Mapping[str, Mapping[str, float | None]]
    # True if a step of some input changes the outcome, or leads to a scene without one.
    fragile: bool


def sensitivity(scene: Scene, result: Result, engine: Engine) -> Sensitivity:
    """Return the derivatives of every quantity of a result by every input.

    The engine's digits, and those of the result, should be 25 or more.
    """
    here = dict(numbers_of(result))
    derivatives: dict[str, dict[str, float | None]] = {name: {} for name in here}
    fragile = False
    roughly = _in_doubles(scene, result)
    for path, x in inputs(scene).items():
        slopes: Mapping[str, float | None] | None = None
        if roughly is not None:
            slopes = _slopes_of_doubles(scene, result, path, x, roughly)
        if slopes is None:
            ends, decided = _moved(scene, result, path, x, engine)
            slopes = {name: _slope(name, ends) if ends else None for name in here}
            fragile |= not decided
        for name, slope in slopes.items():
            derivatives[name][path] = slope
    return Sensitivity(derivatives, fragile)


def _in_doubles(scene: Scene | None, result: Result) -> dict[str, float] | None:
    """Return the numbers of a scene solved in doubles; None if its decisions differ."""
    if scene is None or decisions(doubles := solve(scene, Ivp())) != decisions(result):
        return None
    known = dict(numbers(doubles))
    return {name: float(known[name]) for name, _ in numbers_of(result)}


def _slopes_of_doubles(
    scene: Scene, result: Result, path: str, x: float, here: Mapping[str, float]
) -> dict[str, float | None] | None:
    """Return the derivatives by an input; None if doubles do not give three digits of them.

    Quantities that do not decide an outcome need three digits relative to their own size.
    """
    values = inputs(scene)
    step = WIDE_STEP * (math.hypot(*(values.get(part, 0.0) for part in vector_of(path))) or 1.0)
    below, above = (
        _in_doubles(with_input(scene, path, moved), result) for moved in (x - step, x + step)
    )
    if below is None or above is None:
        return None
    slopes: dict[str, float | None] = {}
    asked, sizes = decisive(result), magnitudes(result)
    for name, middle in here.items():
        rise, curvature = above[name] - below[name], above[name] - 2 * middle + below[name]
        least = 0.0 if name in asked else WIDE_STEP * sizes[name]
        if not abs(curvature) <= _RESOLVED * max(abs(rise), least) or (
            rise == 0.0 and step < _SEEN
        ):
            return None
        slopes[name] = rise / ((x + step) - (x - step))
    return slopes


def _moved(
    scene: Scene, result: Result, path: str, x: float, engine: Engine
) -> tuple[list[tuple[float, Mapping[str, Bounded]]], bool]:
    """Return the input and the numbers at both ends of a short step, and whether both are decided.

    An end with other decisions than the result is replaced by the middle; two of them by none.
    """
    step = STEP * (abs(x) or 1.0)
    there = [
        (moved, solve(other, engine))
        for moved in (x - step, x + step)
        if (other := with_input(scene, path, moved)) is not None
    ]
    ends = [(moved, solved) for moved, solved in there if decisions(solved) == decisions(result)]
    decided = len(ends) == len(there)
    # At a kink or a tie only one side has this outcome: a one-sided difference.
    if len(ends) == 1:
        ends.append((x, result))
    return [(moved, dict(numbers_of(solved))) for moved, solved in ends], decided


def _slope(name: str, ends: list[tuple[float, Mapping[str, Bounded]]]) -> float:
    (a, at_a), (b, at_b) = ends
    difference = Decimal(at_b[name].value) - Decimal(at_a[name].value)
    return float(difference / (Decimal(b) - Decimal(a)))


def attainable_errors(
    scene: Scene, result: Result, sensitivity: Sensitivity
) -> dict[str, float | None]:
    """Return the attainable error of each quantity, in its unit; see the module's docstring.

    None if a derivative is.
    """
    values = inputs(scene)
    # z_b, m, for the second term; other scenes give the height of the bat as an input.
    height = 0.0
    if isinstance(scene, AtBatScene) and result.plate is not None:
        height = float(result.plate.position[2]) + scene.swing.height_offset
    lengths = magnitudes(result)
    errors: dict[str, float | None] = {}
    for name, _ in numbers_of(result):
        slopes = sensitivity.derivatives.get(name, {})
        pairs = [(slopes.get(path), x) for path, x in values.items()]
        pairs.append((slopes.get("swing.height_offset", 0.0), height))
        parts = [abs(slope * x) for slope, x in pairs if slope is not None]
        known = len(parts) == len(pairs)
        total = math.fsum(parts) + lengths[name]
        errors[name] = _three_digits(ROUNDING * total) if known else None
    return errors


def magnitudes(result: Result) -> dict[str, float]:
    """Return the size of every number: its absolute value, or the length of its vector.

    The size of the distance along a fence to a vertex is that of the crossing's position.
    """
    value = {name: as_double(number) for name, number in numbers_of(result)}
    parts = {name: vector_of(name) for name in value}
    if "fence.margin" in parts:
        parts["fence.margin"] = parts["fence.position[0]"]
    return {name: math.hypot(*(value[part] for part in parts[name])) for name in value}


def condition(result: Result, sensitivity: Sensitivity) -> Condition:
    """Return the condition block of a golden case."""
    return Condition(
        derivatives={
            name: {
                path: None if slope is None else _three_digits(slope)
                for path, slope in sensitivity.derivatives[name].items()
            }
            for name in decisive(result)
        },
        rates=rates(result),
    )


def rates(result: Result) -> dict[str, float]:
    """Return the speed at which the ball crosses each event's surface, m/s."""
    speeds = {}
    if result.plate is not None:
        speeds["plate"] = abs(float(result.plate.velocity[0]))
    contact = result.contact
    if contact is not None and contact.normal is not None:
        assert contact.normal_speed is not None
        assert contact.bat_velocity is not None
        # V·n = Ṽ·n + V_b·n. The contact is found for a bat at rest (docs/model.md, Swing and
        # contact), so the ball's own speed counts.
        pairs = zip(contact.bat_velocity, contact.normal, strict=True)
        of_bat = math.fsum(float(v) * float(n) for v, n in pairs)
        speeds["contact"] = abs(float(contact.normal_speed) + of_bat)
    if result.landing is not None:
        speeds["landing"] = abs(float(result.landing.velocity[2]))
    return {name: _three_digits(speed) for name, speed in speeds.items()}


def _three_digits(x: float) -> float:
    return float(f"{x:.3g}")
