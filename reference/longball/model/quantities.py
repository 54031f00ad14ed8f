"""Numbers by their names: ``pitch.speed``, ``pitch.aim[0]``, ``landing.position[2]``.

A name is the path to a number through the blocks of a scene or a result, or through the same plain
data. Columns, golden data, tables and messages all use this syntax.
"""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, TypeVar

from pydantic import BaseModel

from longball.model.block import Block
from longball.model.result import Bounded, Certified, Result

# Largest index of a list: a name such as x[999999999] must not fill the memory.
_MOST_PLACES = 100_000

B = TypeVar("B", bound=BaseModel)

_NAME = re.compile(r"\w+(\.\w+|\[\d+\])*", re.ASCII)
_STEP = re.compile(r"(\w+)(\]?)", re.ASCII)


def numbers(block: Any) -> Iterator[tuple[str, Any]]:
    """Yield the name and the value of every number in a block, in the order of its keys.

    The block is a model or plain data; texts and null are skipped.
    """
    return ((name, value) for name, value in flat(block) if _is_number(value))


def numbers_of(result: Result) -> Iterator[tuple[str, Bounded]]:
    """Yield the name and the value of every decimal number in a result."""
    return ((name, value) for name, value in numbers(result) if isinstance(value, Bounded))


def vector_of(name: str) -> tuple[str, ...]:
    """Return the names of all components of a number's vector, or the name of a scalar."""
    vector, bracket, _ = name.partition("[")
    return tuple(f"{vector}[{i}]" for i in range(3)) if bracket else (name,)


# A table looks up the same few names in every row.
@lru_cache(maxsize=1024)
def _path(name: str) -> tuple[tuple[str, str], ...]:
    """Return the steps to a number: keys with "", indices of lists with "]"."""
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is not the name of a number, such as pitch.aim[0]")
    return tuple(_STEP.findall(name))


def doubles(block: Any) -> dict[str, float]:
    """Return the numbers of a block as doubles, by name."""
    return {name: float(getattr(x, "value", x)) for name, x in numbers(block)}


def at(block: Any, name: str) -> Any:
    """Return the value under a name, number or not; None if it is absent.

    A ValueError is raised if a step of the path does not exist.
    """
    for key, bracket in _path(name):
        match block:
            case None:
                return None
            case BaseModel() if not bracket:
                block = getattr(block, key) if key in type(block).model_fields else None
            case Mapping() if not bracket:
                block = block.get(key)
            case tuple() | list() if bracket and key in map(str, range(len(block))):
                block = block[int(key)]
            case _:
                step = f"[{key}]" if bracket else key
                raise ValueError(f"{name}: {reprlib.repr(block)} has no {step}")
    return block


def number(block: Any, name: str) -> Any:
    """Return a number of a block; a ValueError for an unknown name gives similar ones."""
    try:
        value = at(block, name)
    except ValueError:
        value = None
    if not _is_number(value):
        raise unknown(name, [known for known, _ in numbers(block)])
    return value


def unknown(name: str, names: Iterable[str]) -> ValueError:
    """Return the ValueError for an unknown name, with close matches."""
    nearest = difflib.get_close_matches(name, names := list(names), n=3, cutoff=0.0)
    known = f"the nearest are {', '.join(nearest)}" if names else "there are none"
    return ValueError(f"{name} is not the name of a number here; {known}")


def replaced(block: B, values: Mapping[str, object]) -> B:
    """Return a scene, a result or a block with other numbers, validated again.

    All numbers change at once, because a scene between the changes may be invalid. A ValueError is
    raised for an unknown name, or for an invalid block (`pydantic.ValidationError`).
    """
    for name in values:
        number(block, name)
    return rewritten(block, values)


def rewritten(block: B, values: Mapping[str, object]) -> B:
    """Return a block with other numbers or vectors under existing names."""
    data: Any = block.model_dump()
    for name, value in values.items():
        data = _put(data, [*_path(name)], value)
    return type(block).model_validate(data)


def viewed(block: Any, values: Mapping[str, Any], name: str = "") -> Any:
    """Return a block as a namespace, with other objects in place of some of its numbers.

    The objects may be columns, or numbers that know more than a float; nothing is validated. Inner
    blocks without such numbers stay; a namespace names the class of its block.
    """
    # Floats first: isinstance of a pydantic model is slow.
    if isinstance(block, float):
        return values.get(name, block)
    if isinstance(block, tuple):
        return tuple(viewed(x, values, f"{name}[{i}]") for i, x in enumerate(block))
    prefix = f"{name}." if name else ""
    known = not name or any(path.startswith(prefix) for path in values)
    if not (known and isinstance(block, BaseModel)):
        return block
    fields = type(block).model_fields
    parts = {key: viewed(getattr(block, key), values, prefix + key) for key in fields}
    return SimpleNamespace(**parts, block=type(block))


def flat(data: Any) -> list[tuple[str, Any]]:
    """Return the name and the value of every leaf of data; a number with a radius is a leaf."""
    pairs: list[tuple[str, Any]] = []

    def walk(inner: Any, name: str) -> None:
        parts = [] if _is_number(inner) else _parts(inner)
        if not parts:
            pairs.append((name, inner))
        for key, part in parts:
            walk(part, f"{name}.{key}" if name and not key.startswith("[") else name + key)

    walk(data, "")
    return pairs


def nested(values: Mapping[str, object], default: Any = None) -> dict[str, Any]:
    """Return plain data with values under their names.

    Components that are not named come from the block `default`. A ValueError is raised for an
    invalid name, and for names that contradict each other.
    """
    data: dict[str, Any] = {}
    for name, value in values.items():
        *steps, (last, _) = _path(name)
        block = data
        for step, _ in steps:
            block = block.setdefault(step, {})
            if not isinstance(block, dict):
                raise ValueError(f"{name}: {step} is given as {reprlib.repr(block)} already")
        block[last] = value
    return {key: _with_lists(value, default, key) for key, value in data.items()}


def _with_lists(data: Any, default: Any, name: str) -> Any:
    """Return data in which mappings from indices are lists."""
    if not isinstance(data, dict):
        return data
    if not data or not all(key.isdigit() for key in data):
        return {key: _with_lists(x, default, f"{name}.{key}") for key, x in data.items()}
    rest = [] if default is None else at(default, name) or []
    last = max(map(int, data))
    if last >= _MOST_PLACES:
        raise ValueError(f"{name}[{last}]: no list has so many places")
    places = range(max(len(rest), last + 1))
    return [
        _with_lists(data[key], default, f"{name}[{key}]")
        if (key := str(i)) in data
        else (rest[i] if i < len(rest) else None)
        for i in places
    ]


def _put(data: Any, steps: list[tuple[str, str]], value: object) -> Any:
    if not steps:
        return value
    (key, bracket), *rest = steps
    if not bracket:
        # The key may be missing, because a reading is dumped without its defaults.
        return data | {key: _put(data.get(key), rest, value)}
    return tuple(_put(x, rest, value) if i == int(key) else x for i, x in enumerate(data))


def _parts(block: Any) -> Sequence[tuple[str, Any]]:
    match block:
        case BaseModel():
            keys = block.named() if isinstance(block, Block) else type(block).model_fields
            return [(key, getattr(block, key)) for key in keys]
        case Mapping():
            return [*block.items()]
        case tuple() | list():
            return [(f"[{i}]", inner) for i, inner in enumerate(block)]
    return ()


# A decimal number with its radius is one number, although it is a model with two fields.
_NUMBERS = (float, int, Bounded, Certified)


def _is_number(value: Any) -> bool:
    return isinstance(value, _NUMBERS) and not isinstance(value, bool)
