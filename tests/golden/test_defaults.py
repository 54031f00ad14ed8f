"""The family of scenes that leave defaults out."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from longball.judge.coverage import coverage
from longball.model.scene import KINDS, parse_scene
from tests.scenes import all_cases, cases_of

CASES = cases_of("defaults")
# Keys that stand for a number where something else is given, and are null otherwise.
WITH_FRICTION = ("ball.inertia_factor", "bat.tangential_restitution", "bat.support")


def left_out(block: BaseModel, path: str = "", whole: bool = False) -> Iterator[tuple[str, bool]]:
    """Yield keys with a default, and whether they are left out, themselves or with their block."""
    for key, field in type(block).model_fields.items():
        value, name = getattr(block, key), f"{path}{key}"
        missing = whole or key not in block.model_fields_set
        if isinstance(value, BaseModel) and key != "reading":
            yield from left_out(value, f"{name}.", missing)
        elif name in WITH_FRICTION or not (field.is_required() or field.get_default() is None):
            yield name, missing


def test_each_key_with_a_default_is_left_out_twice_in_each_kind_of_scene():
    known, found = set[tuple[str, str]](), Counter[tuple[str, str]]()
    for case in all_cases():
        kind, keys = case.scene.kind, dict(left_out(case.scene))
        # No air at all is no default.
        known |= {(kind, key) for key in keys.keys() - {"kind", "air"}}
        if case.family == "defaults":
            found.update((kind, key) for key, missing in keys.items() if missing)
    assert {kind for kind, _ in known} == set(KINDS)
    assert {key for key in known if found[key] < 2} == set()


def test_its_lines_hold_no_more_than_was_written():
    bare = [json.loads(case.scene.as_written()) for case in CASES]
    assert any(scene.keys() == {"id", "kind", "launch"} for scene in bare)
    assert not any("gravity" in scene and "time_limit" in scene and "reading" in scene
                   and "ball" in scene and len(scene["ball"]) == 4 for scene in bare)  # fmt: skip
    for case in CASES:
        assert parse_scene(case.scene.as_written()) == case.scene


def test_another_default_changes_its_cases():
    """Defaults of left-out keys, in every kind of scene that has the key."""
    found = coverage(CASES, every=0)
    kinds: Any = [case.scene.kind for case in found.cases]
    noticed = {
        (edit.words.removeprefix("uses another default for "), kind)
        for edit, row in zip(found.edits, found.noticed, strict=True)
        for kind, seen in zip(kinds, row, strict=True)
        if seen and edit.words.startswith("uses another default for ")
    }
    flying = {"gravity", "air.density", "air.wind.roughness", "earth.azimuth",
              "air.drag_coefficient", "air.lift_coefficient", "ball.mass", "ball.radius",
              "air.lift_coefficient.numerator", "air.lift_coefficient.slope",
              "air.lift_coefficient.constant", "air.drag_coefficient.per_spin",
              "air.density.temperature", "air.density.pressure"}  # fmt: skip
    batting = {"bat.mass", "bat.length", "bat.radius", "swing.angular_speed", "swing.tilt",
               "ball.restitution", "ball.inertia_factor",
               "bat.tangential_restitution"}  # fmt: skip
    wanted = {
        *((key, kind) for key in flying for kind in ("flight", "pitch", "at-bat")),
        *((key, kind) for key in batting for kind in ("impact", "at-bat")),
        ("ground.height", "flight"), ("swing.height_offset", "at-bat"),
        *((key, kind) for key in ("pitch.speed", "pitch.release", "pitch.aim[0]", "pitch.aim[1]")
          for kind in ("pitch", "at-bat")),
    }  # fmt: skip
    assert wanted - noticed == set()
