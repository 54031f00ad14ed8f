"""The rotation of the Earth."""

from __future__ import annotations

from typing import Any

from longball.model.numbers import N, Numbers, present

ROTATION = 7.292115e-5  # rad/s


def earth_strengths(scene: Any, frame: Any, numbers: Numbers) -> dict[str, N]:
    """Return the components of ``Ω (cos λ north + sin λ up)`` in the frame of a flight.

    λ is the latitude. The scene's +x has an azimuth, from north to the east, and +y is to its left.
    """
    if scene.earth is None:
        return {}
    rotation = numbers.exact(ROTATION)
    level, up = numbers.cos_sin(numbers.exact(scene.earth.latitude))
    # North as x and y: +x is at the azimuth α from it, so that north is at α to the left of +x.
    north_x, north_y = numbers.cos_sin(numbers.exact(scene.earth.azimuth))
    # Ω cos λ, which points to the north.
    level = rotation * level
    s, y, z = frame.turned((level * north_x, level * north_y, rotation * up))
    return present({"earth_s": s, "earth_y": y, "earth_z": z}, numbers)
