"""Real numbers as balls: midpoints, and radii that hold every rounding (python-flint's `arb`)."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from decimal import Decimal
from typing import cast

import flint
from flint import arb

from longball.model.numbers import Numbers, Undecided
from longball.model.result import Bounded

# Bits beyond the digits asked for. A flight's error is some 2¹⁴ roundings: 2⁸ a step, and 2⁵ steps.
# A strong lift that loops for a minute adds 2⁴³; or a graze with a margin of 1e-15 m adds 2²⁷.
_GUARD_BITS = 64


class Balls(Numbers):
    """Real numbers as balls that contain them, written with a number of digits."""

    rounding = 0.0
    exact = staticmethod(arb)
    angle = staticmethod(arb.atan2)

    def __init__(self, digits: int) -> None:
        self.digits = digits
        self.bits = math.ceil(digits * math.log2(10)) + _GUARD_BITS
        self.functions = {"sqrt": self.sqrt, "exp": arb.exp, "log": arb.log, "unit": unit}
        with self.arithmetic():
            self.pi = arb.pi()

    def arithmetic(self) -> AbstractContextManager[object]:
        """Return the context in which balls are as small as the digits want them."""
        return cast(AbstractContextManager[object], flint.ctx.workprec(self.bits))

    def sqrt(self, x: arb) -> arb:
        """Return the square root of a number that is known not to be negative."""
        return x.sqrt() if x > 0 else arb(0).union(x.nonnegative_part().upper().sqrt())

    def cos_sin(self, angle: arb) -> tuple[arb, arb]:
        """Return cosine and sine of an angle in radians."""
        return angle.cos(), angle.sin()

    def positive(self, x: arb, error: arb, question: str) -> bool:
        """True if ``x > 0``; see `longball.model.numbers.Numbers.positive`."""
        if x > error:
            return True
        if x <= -error:
            return False
        raise Undecided(
            f"{question} cannot be decided with {self.digits} digits: "
            f"the value is zero but for {float(x.abs_upper()):.3g}; take more digits"
        )

    def report(self, x: arb) -> Bounded:
        """Return a decimal number and a radius that contain the ball between them.

        The number has one digit more than was asked for, so that its own rounding, which the
        radius includes, is less than one in the last digit asked for.
        """
        if not x.is_finite():
            raise OverflowError(f"a number is not finite: {x}")
        middle, radius, exponent = (int(part) for part in x.mid_rad_10exp(self.digits + 3))
        # The rounding of the midpoint joins the radius.
        value, dropped = _shortened(middle, self.digits + 1)
        bound = radius + abs(value * 10**dropped - middle)
        # Three digits are enough of a radius; rounded up.
        coarse, coarsely = _shortened(bound, 3)
        coarse += coarse * 10**coarsely < bound
        return Bounded(
            value=str(Decimal(f"{value}E{exponent + dropped}")),
            radius=str(Decimal(f"{coarse}E{exponent + coarsely}")) if bound else "0",
        )


def unit(x: arb, r: arb) -> arb:
    """Enclose x / r, which is known to lie between -1 and 1, whatever it is where r is zero."""
    between = arb(0, 1)
    return between.intersection(x / r) if r > 0 else between


def _shortened(whole: int, digits: int) -> tuple[int, int]:
    """Round a whole number to some digits; return those, and how many are dropped."""
    dropped = max(0, len(str(abs(whole))) - digits)
    unit = 10**dropped
    return (whole + unit // 2) // unit, dropped
