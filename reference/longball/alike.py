"""Scenes written as dicts that differ in their numbers alone, read as columns.

A program writes thousands of scenes in one form: the same keys, in the same order. To read each of
them takes ten times as long as its flight. Read as columns, they are checked and flown at once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from longball.model.arrays import Array
from longball.model.quantities import nested

_LARGEST = 2**53  # larger whole numbers are not all doubles


@dataclass
class Alike:
    """Scenes of one form: the same keys and texts, with other numbers.

    Attributes
    ----------
    names
        Of the numbers, such as ``launch.velocity[0]``.
    rest
        Texts, nulls and empty blocks, by name.
    places
        Where they stand in the list.
    ids
        Their ids; None for a scene without one.
    rows
        The numbers of each. They are kept, not the dicts, which their writer may change.
    """

    names: tuple[str, ...]
    rest: dict[str, Any]
    places: list[int] = field(default_factory=list)
    ids: list[str | None] = field(default_factory=list)
    rows: list[list[float]] = field(default_factory=list)

    def columns(self, begin: int, end: int) -> dict[str, Array]:
        """Return the numbers of some scenes as columns, by name."""
        cells = np.array(self.rows[begin:end], np.float64)
        return {name: cells[:, i] for i, name in enumerate(self.names)}

    def written(self, i: int) -> dict[str, Any]:
        """Return a scene as it was written."""
        name = self.ids[i]
        numbers = zip(self.names, self.rows[i], strict=True)
        return ({} if name is None else {"id": name}) | nested({**self.rest, **dict(numbers)})


def alike(scenes: Iterable[object]) -> list[Alike]:
    """Group scenes that are dicts of numbers, texts, vectors and blocks by their form.

    Other objects are omitted, whatever they are.
    """
    groups: dict[tuple[Any, ...], Alike] = {}
    for place, scene in enumerate(scenes):
        if type(scene) is not dict:
            continue
        # The id is not a part of the form: every scene has a different one.
        name = scene.get("id")
        if name is not None and not (type(name) is str and name and name.isprintable()):
            continue  # half of a surrogate pair is not printable
        numbers: dict[str, float] = {}
        rest: dict[str, Any] = {}
        try:
            _split(scene, "", numbers, rest)
        except (_OtherForm, RecursionError):
            continue
        rest.pop("id", None)
        names = tuple(numbers)
        key = names, tuple((at, repr(x)) for at, x in rest.items())
        group = groups.setdefault(key, Alike(names, rest))
        group.places.append(place)
        group.ids.append(name)
        group.rows.append([*numbers.values()])
    return [*groups.values()]


class _OtherForm(Exception):
    """Raised where a dict holds something else, such as a number of NumPy."""


def _split(
    block: dict[Any, Any], prefix: str, numbers: dict[str, float], rest: dict[str, Any]
) -> None:
    """Put the numbers of a dict and everything else under their names."""
    for key, value in block.items():
        # Another key could be the name of a number inside of a block, which it is not.
        if type(key) is not str or not key.isidentifier():
            raise _OtherForm
        # Exact types: a bool is an int, and numbers of NumPy and others are read one by one.
        name, kind = prefix + key, type(value)
        if kind is float or (kind is int and abs(value) <= _LARGEST):
            numbers[name] = value
        elif (kind is list or kind is tuple) and value:
            for i, x in enumerate(value):
                if type(x) is not float and (type(x) is not int or abs(x) > _LARGEST):
                    raise _OtherForm
                numbers[f"{name}[{i}]"] = x
        elif kind is dict and value:
            _split(value, f"{name}.", numbers, rest)
        elif kind is str or value is None or value == {}:
            rest[name] = value
        else:
            raise _OtherForm
