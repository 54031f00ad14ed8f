"""The wind.

Heights are those of the scene's z, above the plane z = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from longball.model import trace
from longball.model.force import Branches, Piecewise, Strengths, Wind, present, scaled, switched
from longball.model.numbers import N, Numbers, Vector
from longball.model.trace import ZERO

# The components along s, y and z of a wind that is the same everywhere, and of one above a height.
UNIFORM = ("wind_s", "wind_y", "wind_z"), ("above_s", "above_y", "above_z")
ROUGHNESS = "roughness"  # z_0, m, as a parameter of the law: the profile ends at z = -z_0


def _acts(scene: Any, on: str, form: str) -> Any:
    """Return the wind of a scene, if it has this form and acts on this."""
    wind = None if scene.air is None else scene.air.wind
    known = wind is not None and scene.reading.wind_acts_on == on
    return wind if known and _form(wind) == form else None


def _form(wind: Any) -> str:
    for form in ("above", "roughness"):
        if hasattr(wind, form):
            return form
    return "uniform"


def _uniform(on: str) -> Strengths:
    """Return the function from a scene to the components of a wind that is the same everywhere."""

    def strengths(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
        wind = _acts(scene, on, "uniform")
        return None if wind is None else present(frame.components(wind, numbers), numbers)

    return strengths


def _same_everywhere(position: Vector[Any], p: Any) -> Vector[Any]:
    return p.wind_s, p.wind_y, p.wind_z


def _aloft(position: Vector[Any], p: Any) -> Vector[Any]:
    return p.above_s, p.above_y, p.above_z


def _logarithmic(on: str) -> Strengths:
    """Return the function from a scene to a wind's ``W_h / ln((h + z_0)/z_0)``, and z_0."""

    def strengths(scene: Any, frame: Any, numbers: Numbers[N]) -> tuple[Any, ...] | None:
        wind = _acts(scene, on, "roughness")
        if wind is None:
            return None
        height, roughness = numbers.exact(wind.height), numbers.exact(wind.roughness)
        rise = numbers.functions["log"]((height + roughness) / roughness)
        s, y, _ = frame.components(wind.velocity, numbers)
        found = present((s / rise, y / rise), numbers)
        return None if found is None else (*found, roughness)

    return strengths


def _higher_faster(position: Vector[Any], p: Any) -> Vector[Any]:
    """Return ``W_h ln((z + z_0)/z_0) / ln((h + z_0)/z_0)``."""
    rise = trace.log(1.0 + position[2] / p.roughness)
    return scaled(rise, (p.log_wind_s, p.log_wind_y, ZERO))


def _blows_above(on: str) -> Callable[[Any, Any, Numbers[N]], Branches | None]:
    """Return the branches of a wind that blows above a height alone."""

    def branches(scene: Any, frame: Any, numbers: Numbers[N]) -> Branches | None:
        wind = _acts(scene, on, "above")
        if wind is None:
            return None
        found = present(frame.components(wind.velocity, numbers), numbers)
        none = None, None, None
        return None if found is None else Branches((numbers.exact(wind.above),), (none, found))

    return branches


WINDS_ABOVE = tuple(
    Piecewise(
        UNIFORM[1],
        switched,
        Wind(UNIFORM[1], switched, _aloft, on == "both"),
        _blows_above(on),
        lambda motion, p: (motion.position[2], 1.0),
        "the ball passes the height above which the wind blows",
    )
    for on in ("both", "drag")
)
WINDS = tuple(
    wind
    for on in ("both", "drag")
    for wind in (
        Wind(UNIFORM[0], _uniform(on), _same_everywhere, on == "both"),
        Wind(
            ("log_wind_s", "log_wind_y", ROUGHNESS), _logarithmic(on), _higher_faster, on == "both"
        ),
    )
)
