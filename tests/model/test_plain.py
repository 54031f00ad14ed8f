"""Numbers of every type become the nearest double, or are refused in a sentence."""

from __future__ import annotations

import math
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from longball.model.plain import column_of, is_missing, is_number, plain

WHOLE = st.integers() | st.integers(-(10**400), 10**400)
EXACT = st.decimals(allow_nan=False) | st.fractions()


def nearest(number) -> float:
    """Return the double nearest to an exact number, by rational arithmetic alone."""
    exact = Fraction(number)
    if abs(exact) >= Fraction(2) ** 1024 - Fraction(2) ** 970:  # half an ulp above the largest
        return math.inf if exact > 0 else -math.inf
    return exact.numerator / exact.denominator


@given(WHOLE | st.fractions() | st.decimals(allow_nan=False, allow_infinity=False))
@example(2**53 + 1)
@example(10**5000)
@example(Decimal("-1e400"))
@example(Fraction(1, 3))
def test_exact_numbers_become_the_nearest_double(number):
    value = plain(number)
    assert value == nearest(number) or value == number
    assert isinstance(value, float) or abs(value) <= 2**53
    assert column_of([number]).tolist() == [nearest(number)]


# Every type that NumPy's arrays have, by the letter of its kind.
REAL, OTHER = "iuf", "bcmMSU"


@given(st.data())
def test_every_type_of_numpy_is_handled_or_refused(data):
    dtype = data.draw(arrays.scalar_dtypes() | st.sampled_from([np.longdouble, "U3", "S3"]))
    array = data.draw(arrays.arrays(np.dtype(dtype), st.integers(1, 3)))
    with np.errstate(over="ignore"):  # extended precision reaches beyond doubles
        doubles = [float(x) for x in array] if array.dtype.kind in REAL else []
    column = column_of(array)
    if array.dtype.kind in REAL:
        np.testing.assert_array_equal(column, doubles)
        np.testing.assert_array_equal(plain(array), doubles)
        return
    assert array.dtype.kind in OTHER
    if not all(map(is_missing, array)):
        assert column.dtype == object
    for cell in array:
        assert not is_number(cell)
        if array.dtype.kind in ("b", "U"):  # truth values and texts, which JSON has
            assert type(plain(cell)) in (bool, str, np.str_)
            continue
        with pytest.raises(TypeError, match=rf"^pitch\.speed: must be .*{type(cell).__name__}"):
            plain({"pitch": {"speed": cell}})


@pytest.mark.parametrize("cell", [True, 1j, b"1", np.timedelta64(1, "ns"), pd.Timestamp(0), "1"])
def test_one_other_cell_makes_no_numbers_of_the_rest_and_is_none_itself(cell):
    assert column_of([1.0, cell]).tolist()[1] is cell or column_of([1.0, cell])[1] == cell
    assert column_of([1.0, cell]).dtype == object


@pytest.mark.parametrize(
    "column",
    [
        np.ma.array([1.0, 2.0], mask=[False, True]),
        np.ma.array([1, 2], mask=[False, True], dtype=np.int8),
        [1, np.ma.masked],
        [1.0, None],
        [1, pd.NA],
        [Decimal(1), Decimal("NaN")],
        pd.Series([1, None], dtype="Int64"),
        pd.array([1.0, None], dtype="Float64"),
    ],
)
def test_what_is_masked_or_missing_is_missing(column):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = column_of(column)
    assert found.dtype == float
    assert [is_missing(x) for x in found.tolist()] == [False, True]


def test_masked_numbers_of_a_vector_are_null():
    assert plain(np.ma.array([1.0, 2.0], mask=[False, True])) == [1.0, None]
    assert plain(np.ma.masked) is None
