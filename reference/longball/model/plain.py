"""Values of Python, NumPy and pandas as plain JSON values."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from decimal import Decimal
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

# Whole numbers up to this size are exact doubles, and stay whole numbers in JSON.
_LARGEST_WHOLE = 2**53
_DOUBLES = (np.float16, np.float32, np.float64)


def is_number(value: object) -> bool:
    """True for a real number of Python or NumPy, a `Decimal` or a `Fraction`."""
    # Python counts bools as numbers, and NumPy counts durations.
    return isinstance(value, Real | Decimal) and not isinstance(value, bool | np.timedelta64)


def double(number: Any) -> float:
    """Return the double nearest to a real number; infinity beyond the largest double."""
    try:
        return float(number)
    except OverflowError:  # of int, Fraction
        return math.inf if number > 0 else -math.inf
    except ValueError:  # of Decimal("sNaN")
        return math.nan


def is_missing(value: object) -> bool:
    """True for an empty cell: None, NaN, a masked value, NA and NaT of pandas."""
    if value is None or value is np.ma.masked:
        return True
    if is_number(value):
        return math.isnan(double(value))
    # pandas is an extra: if it is not loaded, the value cannot be one of its.
    pandas = sys.modules.get("pandas")
    return pandas is not None and (value is pandas.NA or value is pandas.NaT)


def plain(value: object, name: str = "") -> Any:
    """Return a value as plain JSON data; `name` is its name in messages.

    Numbers become the nearest doubles. A masked value and pandas' NA become null.

    Raises `TypeError` if JSON has no form for a value, such as a complex number or a time.
    """
    # Fast path: most values are floats, and the general test for numbers takes a hundred times
    # longer.
    if value is None or type(value) is float or isinstance(value, str | bool):
        return value
    if is_number(value):
        whole = isinstance(value, Integral) and abs(int(value)) <= _LARGEST_WHOLE
        return int(value) if whole else double(value)  # type: ignore[call-overload]
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        before = f"{name}." if name else ""
        return {key: plain(inner, f"{before}{key}") for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [plain(inner, f"{name}[{i}]") for i, inner in enumerate(value)]
    if is_missing(value):
        return None
    if hasattr(value, "__array__") and not isinstance(value, np.generic):
        array = value if isinstance(value, np.ndarray) else np.asarray(value)
        if array.dtype in _DOUBLES and not np.ma.isMaskedArray(array):
            return array.tolist()
        # Not by `tolist`, which converts times to whole numbers and keeps extended precision.
        return plain([*array] if array.ndim else array[()], name)
    where = f"{name}: " if name else ""
    raise TypeError(f"{where}must be a number, text or block (got a {type(value).__name__})")


def json_text(value: object) -> str:
    """Return a value as JSON, with the conversions of `plain`."""
    try:
        return json.dumps(value, default=plain)
    except (TypeError, ValueError):
        return json.dumps(plain(value))  # raises an error that names the value


def column_of(values: Any) -> NDArray[Any]:
    """Return an array of any shape: of doubles if all cells are numbers, otherwise of objects.

    Missing numbers become NaN.
    """
    if not hasattr(values, "__array__"):
        # NumPy would convert numbers next to a text to texts, and bools next to numbers to numbers.
        values = np.array(values, object)
    array = values if isinstance(values, np.ndarray) else np.asarray(values)
    if array.dtype.kind in "iuf":
        with np.errstate(over="ignore"):  # extended precision reaches beyond doubles
            doubles: NDArray[Any] = np.ma.filled(array.astype(float), np.nan)
        return doubles
    cells = [*array.flat]
    if all(is_number(x) or is_missing(x) for x in {type(x): x for x in cells}.values()):
        numbers = [math.nan if is_missing(x) else double(x) for x in cells]
        return np.array(numbers, float).reshape(array.shape)
    column = np.empty(len(cells), object)
    for i, cell in enumerate(cells):
        column[i] = cell  # one by one, because NumPy would unpack lists
    return column.reshape(array.shape)
