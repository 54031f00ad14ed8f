"""Values of Python, NumPy and pandas as JSON has them: what counts as a number."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from decimal import Decimal
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

# Whole numbers up to here are doubles, and are written as they are.
_LARGEST_WHOLE = 2**53
_DOUBLES = (np.float16, np.float32, np.float64)


def is_number(value: object) -> bool:
    """Check that a value is a real number: of Python, of NumPy, a `Decimal`, a `Fraction`."""
    # To Python a bool is a number, and to NumPy a duration is.
    return isinstance(value, Real | Decimal) and not isinstance(value, bool | np.timedelta64)


def double(number: Any) -> float:
    """Return the double nearest to a real number; infinity if it is beyond all doubles."""
    try:
        return float(number)
    except OverflowError:  # of int, Fraction
        return math.inf if number > 0 else -math.inf
    except ValueError:  # of Decimal("sNaN")
        return math.nan


def is_missing(value: object) -> bool:
    """Check that a cell is empty: None, NaN, a masked value, NA and NaT of pandas."""
    if value is None or value is np.ma.masked:
        return True
    if is_number(value):
        return math.isnan(double(value))
    pandas = sys.modules.get("pandas")  # where it is not loaded nobody has a value of it
    return pandas is not None and (value is pandas.NA or value is pandas.NaT)


def plain(value: object, name: str = "") -> Any:
    """Return a value, called `name` in messages, as JSON has it.

    Numbers become the nearest doubles. A masked value and pandas' NA are null.

    Raises
    ------
    TypeError
        If it holds something that JSON has no form for, such as a complex number or a time.
    """
    # Most are floats; to ask for a number of any kind takes a hundred times as long.
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
        # `tolist` makes whole numbers of times, and leaves extended precision as it is.
        return plain([*array] if array.ndim else array[()], name)
    where = f"{name}: " if name else ""
    raise TypeError(f"{where}must be a number, text or block (got a {type(value).__name__})")


def column_of(values: Any) -> NDArray[Any]:
    """Return an array, of any shape, of numbers as doubles; of anything else its cells as objects.

    Among numbers, a missing one is NaN.
    """
    if not hasattr(values, "__array__"):
        # NumPy makes texts of numbers that stand beside one, and numbers of bools.
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
        column[i] = cell  # a list, too
    return column.reshape(array.shape)
