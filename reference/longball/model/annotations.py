"""Annotations of the models' fields, as text for documentation and type checkers."""

from __future__ import annotations

import json
import types
from collections.abc import Callable
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, WithJsonSchema

_OF_JSON = {"string": "str", "integer": "int"}


def spelled(annotation: Any, block: Callable[[type[BaseModel]], str]) -> str:
    """Return an annotation without its limits; `block` spells the models in it.

    >>> spelled(tuple[float, float, float] | None, lambda model: model.__name__)
    'Vector | None'
    """
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        # A validator may accept other JSON types than the annotation names: list all of them.
        schemas = [part.json_schema for part in parts if isinstance(part, WithJsonSchema)]
        if schemas and schemas[0]:
            options = schemas[0].get("anyOf", schemas)
            return " | ".join(_OF_JSON[option["type"]] for option in options)
        return spelled(parts[0], block)
    # Different limits of the same type are spelled alike, and listed once.
    if origin in (Union, types.UnionType):
        return " | ".join(dict.fromkeys(spelled(part, block) for part in parts))
    # Vectors can be given as lists and arrays.
    if origin is tuple:
        (part, *_) = names = {spelled(x, block) for x in parts if x is not ...}
        return "Vector" if names == {"float"} else f"Sequence[{part}]"
    if origin is Literal:
        return f"Literal[{', '.join(map(json.dumps, parts))}]"
    if annotation is types.NoneType:
        return "None"
    if is_model(annotation):
        return block(annotation)
    return str(annotation) if origin else str(annotation.__name__)


def within(annotation: Any) -> list[Any]:
    """Return an annotation and all its parts."""
    return [annotation, *(x for part in get_args(annotation) for x in within(part))]


def is_model(annotation: Any) -> bool:
    """True if an annotation is a model itself."""
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
