"""Dual numbers and polynomials for event functions."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np


class Arithmetic:
    """The operations of event functions, derived from ``a + b``, ``-a`` and ``a * b``."""

    __slots__ = ()

    def __add__(self, other: Any) -> Any:
        raise NotImplementedError

    def __neg__(self) -> Any:
        raise NotImplementedError

    def __mul__(self, other: Any) -> Any:
        raise NotImplementedError

    def __radd__(self, other: Any) -> Any:
        return self + other

    def __sub__(self, other: Any) -> Any:
        return self + -other

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __rmul__(self, other: Any) -> Any:
        return self * other


@dataclass(frozen=True)
class Dual(Arithmetic):
    """A number and its rate of change."""

    value: Any
    rate: Any

    __array_ufunc__ = None  # an array is one number

    def __add__(self, other: Any) -> Dual:
        other = _dual(other)
        return Dual(self.value + other.value, self.rate + other.rate)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.rate)

    def __mul__(self, other: Any) -> Dual:
        other = _dual(other)
        return Dual(self.value * other.value, self.rate * other.value + self.value * other.rate)


def _dual(x: Any) -> Dual:
    return x if isinstance(x, Dual) else Dual(x, 0 * x)


# The functions that a traced law calls, over arrays of doubles. The unit vector of a vector without
# length is zero, as in the other number systems (`longball.model.numbers.ratio`).
ARRAYS: Any = SimpleNamespace(
    functions={
        "sqrt": np.sqrt,
        "exp": np.exp,
        "log": np.log,
        "unit": lambda x, r: np.divide(x, r, out=np.zeros_like(r), where=r != 0),
    }
)
