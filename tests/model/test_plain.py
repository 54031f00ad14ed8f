"""Numbers of every type become the nearest double, or are refused in a sentence."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from longball.model.plain import column_of, is_missing, is_number, plain

WHOLE = st.integers() | st.integers(-(10**400), 10**400)


def nearest(number) -> float:
    """Return the double nearest to an exact number, by rational arithmetic alone."""
    exact = Fraction(number)
    if abs(exact) >= Fraction(2) ** 1024 - Fraction(2) ** 970:  # half an ulp above the largest
        return math.inf if exact > 0 else -math.inf
    return exact.numerator / exact.denominator


@given(WHOLE | st.fractions() | st.decimals(allow_nan=False, allow_infinity=False))
@example(2**53 + 1)
@example(10**5000)
@example(-(10**400))
@example(Decimal("-1e400"))
@example(Fraction(1, 3))
def test_exact_numbers_become_the_nearest_double(number):
    value = plain(number)
    assert float(value) == nearest(number)
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
