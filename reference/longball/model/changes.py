"""Changes to scenes, by the names of their numbers: ``pitch.speed=95mph``."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from longball.model.explain import keys_of, parts_of
from longball.model.inputs import (
    OF_SPIN,
    TRACKED,
    UNITS_OF_TRACKED,
    launched,
    tracked_fault,
    tracks_of,
)
from longball.model.names import one_of
from longball.model.numbers import DOUBLES
from longball.model.quantities import at
from longball.model.scene import KINDS, AtBatScene, InvalidScene, PitchScene
from longball.model.units import in_si, read_in_si, unit_of

_ELEMENT = re.compile(r"(.*)\[(\d+)\]")
# Default scenes, from which a vector is completed if only a component is set. A flight has no
# default.
USUAL_SCENES: dict[Any, Any] = {scene.kind: scene for scene in (PitchScene(), AtBatScene())}


@dataclass(frozen=True)
class Changes:
    """New values for scenes, by names of keys, of components of vectors, or of `TRACKED`.

    A tracked quantity of a launch, such as its speed, changes with the other tracked ones fixed.
    """

    values: tuple[tuple[str, Any], ...] = ()

    def __bool__(self) -> bool:
        """True if there are any."""
        return bool(self.values)

    def __call__(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Return a scene, as plain data, with the changes; `InvalidScene` if they do not fit it."""
        changed = dict(data)
        for name, value in self.values:
            # A flight without a launch is an error here: a speed needs a velocity to change.
            launch = changed.get("launch", {} if data.get("kind") == "flight" else None)
            if name in TRACKED and isinstance(launch, Mapping):
                changed["launch"] = _launch_with(launch, name, value)
                continue
            # A component: the others keep their values, or get the defaults of the kind.
            if element := _ELEMENT.fullmatch(name):
                name, place = element[1], int(element[2])
                vector = at(changed, name) or at(USUAL_SCENES.get(data.get("kind")), name)
                if not isinstance(vector, list | tuple) or place >= len(vector):
                    raise InvalidScene(
                        f"{name}[{place}]: the scene does not give {name}; set all of it"
                    )
                value = [*vector[:place], value, *vector[place + 1 :]]
            changed = _with(changed, name.split("."), value, name)
        return changed


def _launch_with(launch: Any, name: str, value: Any) -> dict[str, Any]:
    """Return a launch with another speed, angle, … (a name of `TRACKED`)."""
    velocity, spin = (at(launch, key) for key in ("velocity", "spin"))
    if not (_is_vector(velocity) and (spin is None or _is_vector(spin))):
        raise InvalidScene(f"{name}: the scene must give launch.velocity, which it changes")
    if fault := tracked_fault(name, value):
        raise InvalidScene(f"{name}: {fault}")
    tracks = tracks_of(velocity, spin, DOUBLES, math.hypot, math.atan2)
    # A ball without spin gets the one component that is set; the others are zero.
    without = dict.fromkeys(OF_SPIN, 0.0) if name in OF_SPIN else {}
    vectors = launched({**without, **tracks, name: value}, DOUBLES)
    return {**launch, **{key.removeprefix("launch."): [*v] for key, v in vectors.items()}}


def _is_vector(value: Any) -> bool:
    numeric = isinstance(value, list | tuple) and all(type(x) in (int, float) for x in value)
    return numeric and len(value) == 3


def _with(block: Mapping[str, Any], keys: list[str], value: Any, name: str) -> dict[str, Any]:
    key, *rest = keys
    if rest:
        inner = block.get(key, {})
        if not isinstance(inner, Mapping):
            raise InvalidScene(f"{name}: {key} is set to {json.dumps(inner)} already")
        value = _with(inner, rest, value, name)
    return {**block, key: value}


def value_of(name: str, text: str, models: Iterable[type[BaseModel]] = KINDS.values()) -> Any:
    """Return the value of a text for a key: JSON, a number with or without a unit, or a word.

    The key's description in the `models`, by default the kinds of scenes, gives the SI unit.

    >>> value_of("pitch.speed", "90 km/h")
    25.0

    A ValueError is raised for an unknown key, or for a unit of another quantity.
    """
    described = UNITS_OF_TRACKED.get(name) or _described(name, [*models])
    # First as JSON (null, lists, blocks), then as a number that JSON does not allow, such as .5.
    for read in (json.loads, float):
        with suppress(ValueError):
            return read(text)
    vector, si = re.fullmatch(r"(\[.*\])\s*([^\d\s\[\]]\S*)", text), unit_of(described)
    try:
        if vector:
            return [in_si(x, vector[2], si) for x in json.loads(vector[1])]
        number = read_in_si(text, si)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}={text}: {error}") from None
    return text if number is None else number


def _described(name: str, models: Sequence[type[BaseModel]]) -> str:
    """Return the description of a key of some model."""
    keys = _ELEMENT.sub(r"\1", name).split(".")
    for depth in range(1, len(keys) + 1):
        fields = [field for model in models for field in parts_of(model, keys[:depth])]
        if not fields:
            outer, before = keys[: depth - 1], "".join(f"{key}." for key in keys[: depth - 1])
            known = [f"{before}{key}" for model in models for key in keys_of(model, outer)]
            known += TRACKED if outer == ["launch"] else ()
            # Similar names include keys without their block, such as density for air.density.
            blocks = ((model, [*outer, key]) for model in models for key in keys_of(model, outer))
            known += [
                ".".join([*block, keys[depth - 1]])
                for model, block in blocks
                if keys[depth - 1] in keys_of(model, block)
            ]
            near = one_of("the keys here are", ".".join(keys[:depth]), dict.fromkeys(known))
            of = "scene" if "kind" in models[0].model_fields else "result"
            raise ValueError(f"{name}: no {of} has this key{near}")
    return next((field.description for field in fields if field.description), "")


def changes_of(texts: Iterable[tuple[str, str]], blocks: Mapping[str, Any]) -> Changes:
    """Return changes of whole blocks, and then of single numbers by name and text."""
    return Changes((*blocks.items(), *((name, value_of(name, text)) for name, text in texts)))
