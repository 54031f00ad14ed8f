"""Any number of digits, by mpmath: the second opinion on every digit of the golden data.

It proves nothing, but shares nothing with the engine that does: no recurrence for Taylor
coefficients, no step from a radius of convergence, no interval root. Flights are chains of
polynomials (`longball.engines.collocation`), on which an eigenvalue problem gives all turning
points of an event at once, so that none can hide between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

from mpmath import MPContext

from longball.engines.collocation import Collocation, Mpf, Segment, gauss_legendre
from longball.engines.engine import TooLong
from longball.engines.event import Events
from longball.engines.path_engine import PathEngine
from longball.model.law import Law, State
from longball.model.numbers import Numbers, ratio
from longball.model.result import Bounded

# Digits beyond those that are printed. The error of a step is 14 digits below them, that of a
# flight of dozens of steps 10. Those ten allow for what an at-bat magnifies: from the contact to
# the landing an error grows by a few hundred, and in a graze with a margin of 1e-15 m by 1e10.
# Rounding stays six digits below the error of a step.
_FLIGHT_GUARD = 10
_STEP_GUARD = 14
_ROUNDING_GUARD = 20

# Nodes a digit: between 1.1 and 1.6 the time of a flight is flat.
_NODES_PER_DIGIT = 1.25


class MultiprecisionNumbers(Numbers):
    """Numbers of mpmath with the digits that are printed, and guard digits.

    They have a separate context, so that engines of different precision do not interfere.
    """

    def __init__(self, digits: int) -> None:
        self.digits, self.precision = digits, f"with {digits} digits"
        self.context = MPContext()
        self.context.dps = digits + _ROUNDING_GUARD
        self.pi: Mpf = +self.context.pi
        self.exact, self.sqrt = self.context.mpf, self.context.sqrt
        self.angle = self.context.atan2
        self.rounding = 2.0**-self.context.prec
        self.functions = {
            "sqrt": self.context.sqrt,
            "exp": self.context.exp,
            "log": self.context.log,
            "unit": ratio,
        }

    def cos_sin(self, angle: Mpf) -> tuple[Mpf, Mpf]:
        """Return cosine and sine of an angle in radians."""
        return self.context.cos(angle), self.context.sin(angle)

    def report(self, x: Mpf) -> Bounded:
        """Return the number rounded to the digits asked for; its error is not proven."""
        if not self.context.isfinite(x):
            raise OverflowError(f"a value is {x}")
        text: str = self.context.nstr(x, self.digits, strip_zeros=False)
        return Bounded(value=text.removesuffix("."), radius=None)


@lru_cache
def _numbers(digits: int) -> MultiprecisionNumbers:
    return MultiprecisionNumbers(digits)


@lru_cache
def _collocation(digits: int) -> Collocation:
    numbers = _numbers(digits)
    nodes = math.ceil(_NODES_PER_DIGIT * (digits + _STEP_GUARD))
    tolerance = numbers.context.mpf(10) ** -(digits + _STEP_GUARD)
    rule = gauss_legendre(nodes, numbers.context)
    return Collocation(rule, numbers, numbers.context, tolerance)


# --- the engine -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Multiprecision(PathEngine):
    """Flights by Gauss-Legendre collocation in mpmath.

    Attributes
    ----------
    digits
        How many digits of each number are printed, and normally right.
    """

    digits: int = 30

    def __post_init__(self) -> None:
        if not 1 <= self.digits <= _MOST_DIGITS:
            raise ValueError(f"digits = {self.digits} is not between 1 and {_MOST_DIGITS}")

    @property
    def description(self) -> str:
        """Name, method and digits."""
        return f"multiprecision Gauss-Legendre digits={self.digits}"

    @property
    def numbers(self) -> MultiprecisionNumbers:
        """Numbers of mpmath."""
        return _numbers(self.digits)

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight; it is not proven."""
        return 10.0 ** -(self.digits + _FLIGHT_GUARD)

    def steps(
        self, law: Law, start: State, begin: Mpf, limit: Mpf, events: Events
    ) -> Iterator[Segment]:
        """Yield the pieces of a flight; see `longball.engines.path_engine.PathEngine.steps`.

        A flight that comes near V = 0 is followed by steps as short as it takes.

        Raises `TooLong` if the flight takes too many steps.
        """
        segments = _collocation(self.digits).segments(law, begin, start, limit)
        for number, segment in enumerate(segments):
            if number == _MOST_STEPS:
                raise TooLong(
                    f"the flight takes more than {_MOST_STEPS} steps; the first "
                    f"{float(segment.begin):.3g} s of it can be had by a lower time_limit"
                )
            yield segment


# A flight takes twenty, one that loops for a minute a hundred: ten seconds of 30 digits.
_MOST_STEPS = 250

# Beyond, a double does not hold the error of a flight, 10^-(digits + 10).
_MOST_DIGITS = 290
