"""The inputs of a scene: the numbers that its result depends on.

Trackers describe a launch by speed, angle and direction, and by the components of the spin along
axes that turn with the velocity (A. M. Nathan's convention). These are inputs, too, under the names
`TRACKED`. Each changes with the others held fixed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pydantic import ValidationError

from longball.model.names import one_of
from longball.model.numbers import DOUBLES, N, Numbers, Vector, dot, plus, scaled
from longball.model.plain import is_number
from longball.model.quantities import number, numbers, replaced
from longball.model.scene import FlightScene, Scene

# A value of zero means that the force is absent from the equations, so it is not an input.
_ABSENT_AT_ZERO = (
    "air.density", "air.drag_coefficient", "air.lift_coefficient", "air.side_coefficient.value",
    "gravity",
)  # fmt: skip

# Step for derivatives, relative to an input; for an input of zero, in its unit.
STEP = 2.0**-50

# Tracked quantities of a velocity (m/s, rad, rad), and of a spin (rad/s).
OF_VELOCITY = ("launch.speed", "launch.angle", "launch.direction")
OF_SPIN = ("launch.backspin", "launch.side_spin", "launch.gyrospin")
TRACKED = (*OF_VELOCITY, *OF_SPIN)
UNITS_OF_TRACKED = dict(zip(TRACKED, ("m/s", "rad", "rad", *["rad/s"] * 3), strict=True))


# Usual position of the contact, m: 2 ft in front of the plate's tip and 3 ft above the ground,
# where Nathan's Trajectory Calculator begins.
CONTACT = (0.6096, 0.0, 0.9144)


def inputs(scene: Scene) -> dict[str, float]:
    """Return the inputs of a scene by name, such as ``pitch.release[0]``."""
    known = dict(numbers(scene))
    # The time limit ends a calculation, but is in no formula.
    known.pop("time_limit", None)
    if isinstance(scene, FlightScene) and not any(scene.launch.velocity[:2]):
        # A vertical launch has the heading +x by definition; the smallest horizontal velocity can
        # change the heading to any other, so there is no derivative.
        del known["launch.velocity[0]"], known["launch.velocity[1]"]
    # A number that is zero is an input if another value, on either side, gives a valid scene.
    return {
        path: x
        for path, x in known.items()
        if x
        or (
            path not in _ABSENT_AT_ZERO
            and any(with_input(scene, path, step) for step in (STEP, -STEP))
        )
    }


def with_input(scene: Scene, path: str, value: float) -> Scene | None:
    """Return the scene with another value of an input; None if there is no such scene."""
    try:
        return replaced(scene, {path: value})
    except ValidationError:
        return None


def axes_of(angle: N, direction: N, numbers: Numbers) -> tuple[Vector, ...]:
    """Return unit vectors along the velocity, the axis of backspin and the axis of side spin.

    Backspin turns about the horizontal axis perpendicular to the velocity, and lifts the ball. Side
    spin turns about the axis perpendicular to both, and curves the ball to the left. Gyrospin turns
    about the velocity itself.
    """
    level, rise = numbers.cos_sin(angle)
    ahead, aside = numbers.cos_sin(direction)
    nothing = numbers.exact(0.0)
    return (
        (level * ahead, level * aside, rise),
        (aside, -ahead, nothing),
        (-rise * ahead, -rise * aside, level),
    )


def tracked(scene: Scene) -> dict[str, float]:
    """Return the tracked quantities of a launch, by their names in `TRACKED`.

    The result is empty for other scenes than flights, and for a launch at rest. It has no spin
    components if the launch has no spin.
    """
    if not isinstance(scene, FlightScene) or not any(scene.launch.velocity):
        return {}
    return tracks_of(scene.launch.velocity, scene.launch.spin, DOUBLES, math.hypot, math.atan2)


def tracks_of(
    velocity: Vector,
    spin: Vector | None,
    numbers: Numbers,
    size: Callable[..., N],  # of a vector, from its components
    turn: Callable[[N, N], N],  # from the x axis to a vector, rad, from y and x
) -> dict[str, N]:
    """Return the tracked quantities of a velocity and a spin; see `tracked`."""
    x, y, z = velocity
    angle, direction = turn(z, size(x, y)), turn(y, x)
    tracks = dict(zip(OF_VELOCITY, (size(x, y, z), angle, direction), strict=True))
    if spin is not None:
        along, back, side = axes_of(angle, direction, numbers)
        parts = dot(spin, back), dot(spin, side), dot(spin, along)
        tracks |= dict(zip(OF_SPIN, parts, strict=True))
    return tracks


def launched(values: Mapping[str, N], numbers: Numbers) -> dict[str, Vector]:
    """Return velocity and spin (if any) of a launch from its tracked quantities."""
    speed, angle, direction = (values[name] for name in OF_VELOCITY)
    along, back, side = axes_of(angle, direction, numbers)
    made = {"launch.velocity": scaled(speed, along)}
    if OF_SPIN[0] in values:
        # All three components are needed: backspin alone does not determine the axis.
        of_back, of_side, of_along = (values[name] for name in OF_SPIN)
        across = plus(scaled(of_back, back), scaled(of_side, side))
        made["launch.spin"] = plus(across, scaled(of_along, along))
    return made


def tracked_fault(name: str, value: Any) -> str | None:
    """Return a sentence if a tracked quantity cannot have a value, and None otherwise."""
    if not is_number(value):
        return f"must be a number in {UNITS_OF_TRACKED[name]} (got {value!r})"
    # `not >` also refuses NaN.
    if name == OF_VELOCITY[0] and not value > 0.0:
        return f"must be positive (got {value!r})"
    # Degrees would otherwise give a wrong flight without an error.
    if name == OF_VELOCITY[1] and not abs(value) <= math.pi / 2:
        radians = f"{math.radians(value):.4f} rad"
        return f"must be from -π/2 to π/2 rad (got {value!r}); {value:g}° are {radians}"
    return None


def value_of(scene: Scene, name: str) -> float:
    """Return an input of a scene by its name, also one of `TRACKED`.

    Raises a `ValueError`, with similar names, if the scene has no such number.
    """
    of_launch = tracked(scene)
    if name in of_launch:
        return of_launch[name]
    if name in TRACKED:
        # The scene lacks the vector of this tracked quantity; the message names the vector.
        lacks = "launch"
        if isinstance(scene, FlightScene):
            lacks = "launch.spin" if name in OF_SPIN else "launch.velocity other than 0"
        raise ValueError(f"{name}: the scene has no {lacks}")
    try:
        return float(number(scene, name))
    except ValueError:
        known = [*of_launch, *inputs(scene)]
        raise ValueError(
            f"{name}: the scene has no such number{one_of('its numbers are', name, known)}"
        ) from None


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """Return the scene with other values of inputs, by name; also names of `TRACKED`.

    Raises `pydantic.ValidationError` if the new scene is invalid.
    """
    of_scene = {name: x for name, x in values.items() if name not in TRACKED}
    changed: Scene = replaced(scene, of_scene) if of_scene else scene
    of_launch = {name: x for name, x in values.items() if name in TRACKED}
    if not of_launch:
        return changed
    # The other tracked quantities stay the same: a new angle keeps speed, direction and backspin.
    made = launched({**tracked(changed), **of_launch}, DOUBLES)
    return replaced(
        changed,
        {f"{vector}[{i}]": x for vector, parts in made.items() for i, x in enumerate(parts)},
    )


def listed(names: Iterable[Any]) -> list[Any]:
    """Return names as a list; a single string is an error, not a list of letters."""
    if isinstance(names, str):
        raise TypeError(f"{names!r}: a list of names is needed, such as [{names!r}]")
    return [*names]


def require_inputs(scene: Scene, names: Iterable[str]) -> list[str]:
    """Return names of inputs of a scene, each checked; see `value_of`."""
    checked = listed(names)
    for name in checked:
        value_of(scene, name)
    if repeated := {name for name in checked if checked.count(name) > 1}:
        raise ValueError(f"{min(repeated)} is named more than once")
    return checked
