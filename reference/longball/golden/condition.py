"""Sensitivity of a result to its inputs, and the accuracy that doubles can attain.

**Derivatives.** Each number of a scene that is an input of the model is moved to either side, the
whole scene is solved again, and the central difference taken: a diagnostic of three digits. It is
moved by 2^-15 of itself, or of the vector it is a component of, and solved in doubles, which takes
milliseconds. If the differences to either side agree to three digits, neither rounding nor a kink
nor the curvature spoils them, and nothing changes the outcome in between; a change that doubles do
not see at all is none. Otherwise it is moved by 2^-50 of itself (a few ulps: the moved input is a
double too) and solved with 30 digits, in a hundred times the time: the difference of two results is
then known to fifteen digits less, and the step is so short that even at a graze with a margin of
1e-15 m it is a small part of the margin.

**Attainable error.** With u = 2^-53, the error of rounding to a double, relative,

    attainable(Q) = u ( Σ_i |∂Q/∂x_i| |x_i|  +  |∂Q/∂σ_b| |z_b|  +  |Q| ).

The first term: whoever reads the inputs as decimals, or multiplies each of them once, has errors
that act like inputs that are off by half an ulp; a backward stable computation adds a small
multiple of that for the roundings on its way. The second (at-bats): the bat is put at the height
z_b = z'_b + σ_b, which a double holds to half an ulp of z_b, however small the offset σ_b that
margin and normal hang on; this is no rounding of an input, and no input's derivative shows it,
because pitch and bat move up and down together. The third: the result is rounded too; for a
component |Q| is the length of its vector, since whoever computes the vector along other axes
rounds like that, and for the way along a fence to its next vertex it is the distance of the place
from the plate. What an implementation loses beyond a small multiple of this is its own doing.

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

# Of an input; see the module's docstring. An input of zero is moved by this in its unit.
WIDE_STEP = 2.0**-15

# How much differences to either side may differ: three digits.
_RESOLVED = 1e-3

# A step as short as that, in an input's unit, may change nothing in doubles though it matters.
_SEEN = 1e-6


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of a result by its inputs."""

    # ∂Q/∂x by quantity and input; None where a step in either direction changes the outcome.
    derivatives: Mapping[str, Mapping[str, float | None]]
    # Whether a step of any input, in any direction, changes the outcome or leaves none.
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
    """Return the numbers of a scene solved in doubles; None if it is not decided as a result is."""
    if scene is None or decisions(found := solve(scene, Ivp())) != decisions(result):
        return None
    known = dict(numbers(found))
    return {name: float(known[name]) for name, _ in numbers_of(result)}


def _slopes_of_doubles(
    scene: Scene, result: Result, path: str, x: float, here: Mapping[str, float]
) -> dict[str, float | None] | None:
    """Return the derivatives by an input; None if doubles do not have three digits of them.

    Where nothing much is asked, three digits of the quantity itself are enough.
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
    """Return an input and the numbers of a result at two ends of a short step, or none.

    Those are ends that decide as the result does; and whether both do.
    """
    step = STEP * (abs(x) or 1.0)
    there = [
        (moved, solve(other, engine))
        for moved in (x - step, x + step)
        if (other := with_input(scene, path, moved)) is not None
    ]
    ends = [(moved, found) for moved, found in there if decisions(found) == decisions(result)]
    decided = len(ends) == len(there)
    if len(ends) == 1:
        ends.append((x, result))
    return [(moved, dict(numbers_of(found))) for moved, found in ends], decided


def _slope(name: str, ends: list[tuple[float, Mapping[str, Bounded]]]) -> float:
    (a, at_a), (b, at_b) = ends
    difference = Decimal(at_b[name].value) - Decimal(at_a[name].value)
    return float(difference / (Decimal(b) - Decimal(a)))


def attainable_errors(scene: Scene, result: Result, found: Sensitivity) -> dict[str, float | None]:
    """Return the attainable error of each quantity, in its unit; see the module's docstring.

    None if a derivative is.
    """
    values = inputs(scene)
    height = 0.0  # z_b, m, where a bat is put relative to the pitch
    if isinstance(scene, AtBatScene) and result.plate is not None:
        height = float(result.plate.position[2]) + scene.swing.height_offset
    lengths = magnitudes(result)
    errors: dict[str, float | None] = {}
    for name, _ in numbers_of(result):
        slopes = found.derivatives.get(name, {})
        pairs = [(slopes.get(path), x) for path, x in values.items()]
        pairs.append((slopes.get("swing.height_offset", 0.0), height))
        parts = [abs(slope * x) for slope, x in pairs if slope is not None]
        known = len(parts) == len(pairs)
        total = math.fsum(parts) + lengths[name]
        errors[name] = _three_digits(ROUNDING * total) if known else None
    return errors


def magnitudes(result: Result) -> dict[str, float]:
    """Return of every number its absolute value, of a component the length of its vector.

    Of the way along a fence to a vertex, that of the place on the fence.
    """
    value = {name: as_double(number) for name, number in numbers_of(result)}
    parts = {name: vector_of(name) for name in value}
    if "fence.margin" in parts:
        parts["fence.margin"] = parts["fence.position[0]"]
    return {name: math.hypot(*(value[part] for part in parts[name])) for name in value}


def condition(result: Result, found: Sensitivity) -> Condition:
    """Return the condition block of a golden case."""
    return Condition(
        derivatives={
            name: {
                path: None if slope is None else _three_digits(slope)
                for path, slope in found.derivatives[name].items()
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
        # V·n = Ṽ·n + V_b·n: the bat's cylinder stands still while it is touched.
        pairs = zip(contact.bat_velocity, contact.normal, strict=True)
        of_bat = math.fsum(float(v) * float(n) for v, n in pairs)
        speeds["contact"] = abs(float(contact.normal_speed) + of_bat)
    if result.landing is not None:
        speeds["landing"] = abs(float(result.landing.velocity[2]))
    return {name: _three_digits(speed) for name, speed in speeds.items()}


def _three_digits(x: float) -> float:
    return float(f"{x:.3g}")
