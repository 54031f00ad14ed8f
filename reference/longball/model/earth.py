"""The rotation of the Earth."""

from __future__ import annotations

from typing import Any

from longball.model.force import Force, Motion, cross, present, scaled
from longball.model.numbers import N, Numbers, Vector

ROTATION = 7.292115e-5  # rad/s


def _rotation(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
    """Return the components of ``Ω (cos λ north + sin λ up)`` in the frame of a flight.

    λ is the latitude. The scene's +x has an azimuth, from north to the east, and +y is to its left.
    """
    if scene.earth is None:
        return None
    rotation = numbers.exact(ROTATION)
    level, up = numbers.cos_sin(numbers.exact(scene.earth.latitude))
    north_x, north_y = numbers.cos_sin(numbers.exact(scene.earth.azimuth))
    level = rotation * level
    return present(frame.turned((level * north_x, level * north_y, rotation * up)), numbers)


def _coriolis(motion: Motion, p: Any) -> Vector[Any]:
    """Return ``-2 Ω × v``."""
    return scaled(-2.0, cross((p.earth_s, p.earth_y, p.earth_z), motion.velocity))


CORIOLIS = Force(("earth_s", "earth_y", "earth_z"), _rotation, _coriolis)
