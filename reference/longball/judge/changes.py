"""A known mistake: a change of the one chain, with what is said of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from longball.judge.stages import Change, with_values
from longball.model.readings import Reading


@dataclass(frozen=True)
class Mistake:
    """A known mistake in the parts of the chain."""

    name: str  # for programs
    sentence: str  # what the candidate does, said to its author
    remedy: str  # how to mend it
    change: Change  # the chain with the mistake in it
    # Whether the law jumps somewhere, so that a candidate's own step across may leave much.
    switches: bool = False
    # The parameter that a number of the candidate's own then goes into, if there may be one.
    scaled: str | None = None


def scene_change(values: Callable[[Any], Mapping[str, Any]]) -> Change:
    """Return the change of a scene's values, by their names; none if it lacks what they need."""

    def change(scene: Any) -> Any:
        try:
            return with_values(scene, values(scene))
        except (ArithmeticError, AttributeError, TypeError, ValueError):
            return scene

    return Change(change)


def reading_change(**switches: str) -> Change:
    """Return the change of some readings; none if a scene excludes them by another."""

    def change(scene: Any) -> Any:
        try:
            reading = Reading.model_validate(scene.reading.model_dump() | switches)
        except ValidationError:  # it excludes another switch of the scene
            return scene
        return scene.model_copy(update={"reading": reading})

    return Change(change)
