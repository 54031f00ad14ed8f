"""Readings in the golden data: each acts in scenes of every kind."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.model.readings import Reading
from longball.model.scene import parse_scene
from tests.scenes import all_cases

MOVED = 1e-4  # relative: far above the tolerance of any profile

# In which kinds of scenes a switch is to move answers, twice at least, in all golden data.
IMPACTS = ("effective_mass", "bat_ball_restitution", "reduced_mass", "inertia")
FLIGHTS = ("wind_acts_on", "spin_parameter", "drag_spin", "spin_decay", "pressure")
WANTED = {
    *((name, kind) for name in IMPACTS for kind in ("impact", "at-bat")),
    *((name, kind) for name in FLIGHTS for kind in ("flight", "pitch", "at-bat")),
    *((("ground_contact", kind)) for kind in ("flight", "pitch", "at-bat")),
    *((name, "flight") for name in ("lift_direction", "fence_clearance", "distance_origin")),
    ("lift_direction", "at-bat"),
    ("slide_direction", "impact"),
}


def numbers(result: Any) -> dict[str, Any]:
    """Return the outcome and the numbers of a result, by block and key."""
    found: dict[str, Any] = {"outcome": result.outcome}
    for block in ("plate", "contact", "impact", "landing", "fence"):
        held = getattr(result, block)
        found |= {f"{block}.{key}": x for key, x in (held or ())}
    return found


def differ(a: Any, b: Any) -> bool:
    first, second = numbers(a), numbers(b)
    return first.keys() != second.keys() or any(
        x != y and not (isinstance(x, float | tuple) and x == pytest.approx(y, rel=MOVED))
        for x, y in ((first[key], second[key]) for key in first)
    )


def without(scene: Any, name: str) -> Any:
    """Return a scene with one switch as it is by default."""
    default = Reading.model_fields[name].default
    return scene.model_copy(update={"reading": scene.reading.model_copy(update={name: default})})


@pytest.mark.nightly
def test_every_reading_moves_answers_of_every_kind():
    default, moved = Reading(), Counter[tuple[str, str]]()
    cases = [c for c in all_cases() if c.scene.reading != default and c.expected.outcome]
    for case in cases:
        scene: Any = parse_scene(case.scene.line())
        switches = [n for n in Reading.model_fields
                    if getattr(scene.reading, n) != getattr(default, n)]  # fmt: skip
        for name in switches:
            if moved[name, scene.kind] < 2:
                answers = solve(scene, Ivp()), solve(without(scene, name), Ivp())
                moved[name, scene.kind] += differ(*answers)
    assert {pair for pair in WANTED if moved[pair] < 2} == set()
