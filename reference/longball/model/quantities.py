"""Numbers by their names: ``pitch.speed``, ``pitch.aim[0]``, ``landing.position[2]``.

A name is the way to a number through the blocks of a scene or a result, or through the same as
plain data. Columns, golden data, tables and messages all use this syntax.
"""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeVar

from pydantic import BaseModel

from longball.model.block import Block
from longball.model.result import Bounded, Certified, Result

_MOST_PLACES = 100_000  # of a list that names describe: an odd name must not take all memory

B = TypeVar("B", bound=BaseModel)

_NAME = re.compile(r"\w+(\.\w+|\[\d+\])*", re.ASCII)
_STEP = re.compile(r"(\w+)(\]?)", re.ASCII)


def numbers(block: Any) -> Iterator[tuple[str, Any]]:
    """Yield the name and the value of every number in a block, in the order of its keys.

    The block is a model, or plain data as JSON has it; texts and null are passed over.
    """
    return ((name, value) for name, value in flat(block) if _is_number(value))


def numbers_of(result: Result) -> Iterator[tuple[str, Bounded]]:
    """Yield every number of a result that is written with digits, with its name."""
    return ((name, value) for name, value in numbers(result) if isinstance(value, Bounded))


def vector_of(name: str) -> tuple[str, ...]:
    """Return the names of the components of the vector that a number is of, or its own."""
    vector, bracket, _ = name.partition("[")
    return tuple(f"{vector}[{i}]" for i in range(3)) if bracket else (name,)


def steps_of(name: str) -> list[str]:
    """Return the keys and places on the way to a number: pitch, aim, 0."""
    return [step for step, _ in _STEP.findall(name)]


@lru_cache(maxsize=1024)
def _way(name: str) -> tuple[tuple[str, str], ...]:
    """Return the steps on the way to a number, with a bracket behind a place in a list."""
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is not the name of a number, such as pitch.aim[0]")
    return tuple(_STEP.findall(name))


def doubles(block: Any) -> dict[str, float]:
    """Return the numbers of a block as doubles, by their names."""
    return {name: float(getattr(x, "value", x)) for name, x in numbers(block)}


def at(block: Any, name: str) -> Any:
    """Return the value under a name, number or not; None if it is absent.

    A ValueError says that the way there leads through something that has no parts, or not so many.
    """
    for key, bracket in _way(name):
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
    """Return a number of a block, as it is held; a ValueError names the nearest if it has none."""
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
    """Return a scene, a result or a block of one with other numbers, as if it had been written so.

    They are put in together. A ValueError says that the block has no number of a name, or that the
    numbers make no valid block (`pydantic.ValidationError`).
    """
    for name in values:
        number(block, name)
    return rewritten(block, values)


def rewritten(block: B, values: Mapping[str, object]) -> B:
    """Return a block with other numbers, or whole vectors, under names that it has."""
    data: Any = block.model_dump()
    for name, value in values.items():
        data = _put(data, [*_way(name)], value)
    return type(block).model_validate(data)


def flat(data: Any) -> list[tuple[str, Any]]:
    """Return the name and the value of everything in data that has no parts, or is a number."""
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
    """Return plain data that hold values under their names.

    The rest of a vector of which some components are named is taken from the block `default`. A
    ValueError says that something is no name, or that names contradict each other.
    """
    data: dict[str, Any] = {}
    for name, value in values.items():
        *steps, (last, _) = _way(name)
        block = data
        for step, _ in steps:
            block = block.setdefault(step, {})
            if not isinstance(block, dict):
                raise ValueError(f"{name}: {step} is given as {reprlib.repr(block)} already")
        block[last] = value
    return {key: _with_lists(value, default, key) for key, value in data.items()}


def _with_lists(data: Any, default: Any, name: str) -> Any:
    """Return data with lists for mappings from places."""
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
        # A reading is dumped without its defaults.
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


_NUMBERS = (float, int, Bounded, Certified)


def _is_number(value: Any) -> bool:
    return isinstance(value, _NUMBERS) and not isinstance(value, bool)
