"""Number systems: doubles, mpmath, balls; and vectors of three numbers.

The chain of an at-bat and every formula of the model are written once, for any of these systems.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from types import MappingProxyType
from typing import Any

import numpy as np

from longball.model.result import ErrorCode, Number

# A number: float, mpf, ball, jet, a column of these, a node of a traced formula. It can be added,
# subtracted, multiplied, divided and compared. A ball is an interval, a value with a radius; its
# comparisons are true only if they are certain. Columns compare element by element.
#
# A condition is therefore a bool or an array of them. Conditions are combined by & and |, and
# negated by ``^ True``: ``not`` fails for arrays, and ``~True`` is -2.
N = Any


class Undecided(ArithmeticError):
    """A question whose answer lies within the error of the numbers at hand."""

    code: ErrorCode = "undecided"


class Numbers:
    """A number system. The methods take single numbers; systems of columns override them."""

    precision: str  # for messages, such as "in double precision"
    pi: N  # the constant, as precise as the system
    rounding: float  # relative error of one operation; 0 where the number carries its own error
    # Of traced formulas: `sqrt`, `exp`, `log`, and `unit` (`trace.Node`)
    functions: Mapping[str, Callable[..., N]]
    exact: Callable[[Any], N]  # a double as a number, not a rounded or decimal relative of it
    sqrt: Callable[[N], N]  # of x >= 0
    cos_sin: Callable[[N], tuple[N, N]]  # cosine and sine of an angle in radians
    angle: Callable[[N, N], N]  # from y and x: from the x axis to the vector, rad
    report: Callable[[N], Number]  # as a result writes it

    def arithmetic(self) -> AbstractContextManager[object]:
        """Return the context in which + - * / of these numbers are as precise as the system."""
        return nullcontext()

    def absent(self, value: float) -> bool:
        """True if a number of a scene is zero: its term is dropped."""
        return value == 0.0

    def where(self, condition: Any, x: N, y: N) -> N:
        """Return x where a condition of `positive` holds, y elsewhere."""
        return x if condition else y

    def positive(self, x: N, error: N, question: str) -> bool:
        """True if ``x > 0``; `Undecided`, with the question, if `x` is within its error."""
        # An exact zero without error is decided: not positive. Other values within the error are
        # not.
        if abs(x) > error or x == error == 0:
            return bool(x > 0)
        # Three digits show how many more digits of precision would decide it.
        value, off = (float(number) for number in (x, error))
        raise Undecided(
            f"{question} cannot be decided {self.precision}: "
            f"the value {value:.3g} lies within its error {off:.3g}"
        )


def present(strengths: dict[str, Any], numbers: Numbers) -> dict[str, N]:
    """Return the strengths that are not zero: a term whose strength is zero is dropped."""
    return {name: value for name, value in strengths.items() if not numbers.absent(value)}


def ratio(part: Any, whole: Any) -> Any:
    """Return ``part / whole``, the component of a unit vector; 0 if the vector is zero."""
    return part / whole if whole != 0 else part * 0


def doubt(x: N, error: N, question: str, numbers: Numbers) -> str:
    """Return the message of `Undecided` for the question whether ``x > 0``."""
    try:
        numbers.positive(x, error, question)
    except Undecided as undecided:
        return str(undecided)
    return f"{question} cannot be decided: the two coincide"


class Doubles(Numbers):
    """IEEE 754 double precision."""

    precision = "in double precision"
    pi = math.pi
    rounding = 2.0**-53  # half an ulp of 1, relative
    sqrt = staticmethod(math.sqrt)  # correctly rounded; every evaluation of a force calls it
    exact = report = float
    functions: Mapping[str, Callable[..., float]] = MappingProxyType(
        {"sqrt": math.sqrt, "exp": math.exp, "log": math.log, "unit": ratio}
    )

    def cos_sin(self, angle: float) -> tuple[float, float]:
        """Return cosine and sine of an angle in radians."""
        return math.cos(angle), math.sin(angle)

    def angle(self, y: float, x: float) -> float:
        """Return the angle from the x axis to a vector, rad."""
        return float(np.arctan2(y, x))  # as of columns: the bits of a row are those of its scene


DOUBLES = Doubles()


# --- vectors --------------------------------------------------------------------------------------

Vector = tuple[N, N, N]


def plus(a: Vector, b: Vector) -> Vector:
    """Return ``a + b``."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Return ``a - b``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(factor: Any, a: Vector) -> Vector:
    """Return ``factor a``."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Vector, b: Vector) -> Any:
    """Return ``a · b``."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return ``a × b``."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def part_across(a: Vector, b: Vector, square: Any) -> Vector:
    """Return ``b² a - (a·b) b``: the component of a across b, times the given b²."""
    # Without the division by b², which may be 0.
    return minus(scaled(square, a), scaled(dot(a, b), b))
