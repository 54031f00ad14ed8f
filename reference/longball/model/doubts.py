"""Doubts about a valid scene: numbers in another unit, a fence in other axes.

The model takes any ball and any field. A person who writes 145 for a mass means grams.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

from longball.model.scene import Scene

# Limits beyond all measured values in baseball: the size of a number or vector, its unit, and other
# units in which the number would be plausible.
_LIMITS = {
    "ball.mass": (1.0, "kg", "g or oz"),
    "ball.radius": (0.2, "m", "cm or inches"),
    "bat.mass": (5.0, "kg", "g or oz"),
    "bat.length": (3.0, "m", "cm or inches"),
    "bat.radius": (0.2, "m", "cm or inches"),
    "launch.velocity": (60.0, "m/s", "km/h, mph or ft/s"),
    "pitch.velocity": (60.0, "m/s", "km/h, mph or ft/s"),
    "pitch.speed": (60.0, "m/s", "km/h, mph or ft/s"),
    "incoming.velocity": (60.0, "m/s", "km/h, mph or ft/s"),
    "pitch.release": (25.0, "m", "ft"),
    "launch.spin": (1000.0, "rad/s", "rpm"),
    "pitch.spin": (1000.0, "rad/s", "rpm"),
    "incoming.spin": (1000.0, "rad/s", "rpm"),
    "swing.angular_speed": (150.0, "rad/s", "degrees/s or rpm"),
    "swing.tilt": (math.pi, "rad", "degrees"),
    "fence.radius": (200.0, "m", "ft"),
    "fence.polyline": (200.0, "m", "ft"),
    "gravity": (30.0, "m/s²", "ft/s²"),
}


def doubts(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield the key and a question for each implausible value."""
    for name, block, key, (limit, unit, others) in _limits_of(type(scene)):
        value: Any = getattr(scene, block)
        value = getattr(value, key) if key and value is not None else value
        if value is None:
            continue
        # A question, not an error: the model is valid for any ball, and a study may need one of 1
        # t.
        size = _size(value)
        if size > limit:
            yield name, f"{size:g} {unit} is more than in any game; is it in {others}?"
    fence = getattr(scene, "fence", None)
    line = pairwise([] if fence is None else fence.polyline or ())
    ahead = [a[1] > 0.0 >= b[1] or a[1] >= 0.0 > b[1] for a, b in line]
    # The axis from the plate through centre field must cross a chord.
    if ahead and not any(ahead):
        yield (
            "fence.polyline",
            (
                "it does not enclose centre field, and balls fly past it; x must point to centre "
                "field and y to the left"
            ),
        )


def _size(value: Any) -> float:
    """Return the size of a number or a vector; for a line, the distance of its farthest vertex."""
    if not isinstance(value, tuple):
        return abs(float(value))
    if isinstance(value[0], tuple):
        return max(math.hypot(x, y) for x, y, _ in value)
    return math.hypot(*value)


@cache
def _limits_of(kind: type[Scene]) -> list[tuple[str, str, str, tuple[float, str, str]]]:
    """Return the limits for a kind of scene, with block and key of each number."""
    parts = [(name, *name.partition(".")[::2], limit) for name, limit in _LIMITS.items()]
    return [part for part in parts if part[1] in kind.model_fields]
