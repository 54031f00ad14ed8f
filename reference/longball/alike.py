"""Scenes written as dicts that differ in their numbers alone, read as columns.

A program writes thousands of scenes in one form: the same keys, in the same order. To read each of
them takes ten times as long as its flight. Read as columns, they are checked and flown at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from longball.model.arrays import Array
from longball.model.quantities import numbers

# A dict without its numbers: keys, each with `float` for a number, the length of a vector, the form
# of a block in turn, or the text or None itself.
Form: TypeAlias = tuple[tuple[str, Any], ...]

_LARGEST = 2**53  # larger whole numbers are not all doubles


@dataclass
class Alike:
    """Scenes of one form.

    Attributes
    ----------
    places
        Where they stand in the list.
    ids
        Their ids; None for a scene without one.
    rows
        The numbers of each, in the order of the form. They are kept, not the dicts, which their
        writer may change.
    """

    form: Form
    places: list[int] = field(default_factory=list)
    ids: list[str | None] = field(default_factory=list)
    rows: list[list[float]] = field(default_factory=list)

    def columns(self, begin: int, end: int) -> dict[str, Array]:
        """Return the numbers of some scenes as columns, by name."""
        cells = np.array(self.rows[begin:end], np.float64)
        names = [name for name, _ in numbers(_filled(self.form, iter(self.rows[begin])))]
        return {name: cells[:, i] for i, name in enumerate(names)}

    def written(self, i: int) -> dict[str, Any]:
        """Return a scene as it was written."""
        name = self.ids[i]
        return ({} if name is None else {"id": name}) | _filled(self.form, iter(self.rows[i]))


def alike(scenes: Iterable[object]) -> list[Alike]:
    """Return those scenes that are dicts of numbers, texts, vectors and blocks, by their form.

    The others need not be scenes at all.
    """
    found: dict[Form, Alike] = {}
    for place, scene in enumerate(scenes):
        if type(scene) is not dict:
            continue
        # An id is no part of the form: each scene has another.
        name = scene.get("id")
        if name is not None and not (type(name) is str and name and name.isprintable()):
            continue  # half of a surrogate pair is not printable
        block = scene if name is None else {key: x for key, x in scene.items() if key != "id"}
        row: list[float] = []
        try:
            group = found.setdefault(form := _form(block, row), Alike(form))
        except (_OtherForm, RecursionError):
            continue
        group.places.append(place)
        group.ids.append(name)
        group.rows.append(row)
    return [*found.values()]


class _OtherForm(Exception):
    """Raised where a dict holds something else, such as a number of NumPy."""


def _form(block: dict[Any, Any], row: list[float]) -> Form:
    """Return the form of a dict, and append its numbers to a row."""
    form: list[tuple[Any, Any]] = []
    for key, value in block.items():
        # Exact types: a bool is an int, and numbers of NumPy and others are read one by one.
        kind = type(value)
        if kind is float or (kind is int and abs(value) <= _LARGEST):
            row.append(value)
            form.append((key, float))
        elif kind is list or kind is tuple:
            for x in value:
                if type(x) is not float and (type(x) is not int or abs(x) > _LARGEST):
                    raise _OtherForm
            row += value
            form.append((key, len(value)))
        elif kind is dict:
            form.append((key, _form(value, row)))
        elif kind is str or value is None:
            form.append((key, value))
        else:
            raise _OtherForm
    return tuple(form)


def _filled(form: Form, row: Iterator[float]) -> dict[str, Any]:
    """Return a dict of a form with the numbers of a row."""
    block: dict[str, Any] = {}
    for key, part in form:
        if part is float:
            block[key] = next(row)
        elif isinstance(part, int):
            block[key] = [next(row) for _ in range(part)]
        else:
            block[key] = _filled(part, row) if isinstance(part, tuple) else part
    return block
