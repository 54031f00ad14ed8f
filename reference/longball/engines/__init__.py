"""Engines: the numerical methods. Each solves a scene into a result."""

from __future__ import annotations

from dataclasses import fields
from importlib import import_module
from numbers import Integral, Real
from typing import Any, Literal, get_args, get_type_hints

from longball.engines.engine import Engine
from longball.extras import naming_extras
from longball.model.names import one_of

Name = Literal["ivp", "batch", "enclosure", "multiprecision", "verlet"]

# Imported only when asked for: an engine brings its own heavy libraries.
ENGINES: dict[Name, tuple[str, str]] = {
    "ivp": ("longball.engines.ivp", "Ivp"),
    "batch": ("longball.engines.batch", "Batch"),
    "enclosure": ("longball.engines.enclosure", "Enclosure"),
    "multiprecision": ("longball.engines.multiprecision", "Multiprecision"),
    "verlet": ("longball.engines.verlet", "Verlet"),
}


def create(name: str, **options: object) -> Engine:
    """Return an engine by name.

    Raises `ValueError` if there is no such engine, or if it does not take an option or its value;
    `TypeError` if an option is of another type; `MissingExtra` if a library is not installed.
    """
    if name not in ENGINES:
        raise ValueError(f"there is no engine {name!r}{one_of('the engines are', name, ENGINES)}")
    module, attribute = ENGINES[name]
    with naming_extras():
        family = getattr(import_module(module), attribute)
    # The options of an engine are the fields of its class, with their types.
    takes = [field.name for field in fields(family)]
    types = get_type_hints(family) if options else {}
    for option in options:
        if option not in takes:
            raise ValueError(f"engine {name} takes no {option}{one_of('it takes', option, takes)}")
    values = {option: of_type(types[option], option, options[option]) for option in options}
    engine: Engine = family(**values)
    return engine


_KINDS: tuple[tuple[Any, Any, str], ...] = (
    (bool, bool, "True or False"),
    (int, Integral, "a whole number"),
    (float, Real, "a number"),
)


def of_type(kind: Any, option: str, value: Any) -> Any:
    """Return the value of an option; numbers, which may be NumPy's, as Python's.

    Raises `TypeError` if it is of another kind: `bool`, `int`, `float`, or one of them or None.
    """
    # Options of another type, such as names, are checked by the engine itself.
    kinds = get_args(kind) or (kind,)  # float | None
    for wanted, sort, what in _KINDS:
        if wanted in kinds and not (value is None and type(None) in kinds):
            # To Python a bool is a number.
            if not isinstance(value, sort) or (isinstance(value, bool) and wanted is not bool):
                raise TypeError(f"{option} = {value!r} is not {what}")
            return wanted(value)
    return value


def whole_number(option: str, value: Any, least: int) -> int:
    """Return the value of an option that is a whole number, and not too small.

    Raises `TypeError` or `ValueError` if it is not.
    """
    number: int = of_type(int, option, value)
    if number < least:
        raise ValueError(f"{option} = {number} is less than {least}")
    return number
