"""The families of combinations: that each reading acts in them, and each edge is on both sides."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.model.readings import Reading
from longball.model.scene import parse_scene
from tests.scenes import all_cases, cases_of

COMBINED, EDGES = cases_of("combined"), cases_of("edges")
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


def test_both_ends_of_the_bat_are_met_inside_and_outside():
    outcomes = {case.id: case.expected.outcome for case in EDGES}
    for end in ("pivot", "tip"):
        assert outcomes[f"edges-{end}-in"] == "batted"
        assert outcomes[f"edges-{end}-out"] == "beyond_bat"


def test_the_ground_under_a_pitch_is_told_by_its_height_and_by_the_reading():
    by_name = {case.id.removeprefix("edges-"): case for case in EDGES}
    assert by_name["ground-0.4"].expected.outcome == "grounded"
    below = by_name["ground--1.5"].expected
    assert below.outcome == "batted"
    assert float(below.plate.position[2]) < 0
    for height in ("0.72", "0.735"):
        assert by_name[f"skims-{height}-centre"].expected.outcome == "crossed"
        assert by_name[f"skims-{height}-surface"].expected.outcome == "grounded"


def test_circles_and_folded_fences():
    by_name = {case.id.removeprefix("combined-fence-"): case.expected for case in COMBINED}
    for name in ("circle-foul-left", "circle-foul-right", "circle-behind"):
        assert by_name[name].outcome == "home_run"
        assert by_name[name].landing.fair is False
    assert by_name["bay-first"].fence.segment == 0  # of three crossings of the fence
    assert by_name["in-time"].landing is None
