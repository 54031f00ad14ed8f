"""Answers with proven errors: an engine's doubles, and how far each is off at most.

The enclosure engine solves the scene again in balls that contain the true values. A double's error
is at most the distance to the far side of the ball, whatever engine the double is from. So a ball
need not be small next to the double: it only has to be small next to the double's error, for which
84 bits are mostly enough.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from typing import Any

from flint import arb

from longball.engines.chain import quantities_of, solve_each
from longball.engines.enclosure import Enclosure
from longball.engines.engine import Engine, ManyAtOnce, TooLong
from longball.model import quantities
from longball.model.result import Certified, Result
from longball.model.scene import InvalidScene, Scene

# Digits of the enclosure, tried in turn; it works with 64 bits more (`enclosure.balls`).
DIGITS = (6, 20, 40, 60)

# More digits are no use once a ball is below half an ulp, relative to the length of a vector.
_NOTHING = 2.0**-53

_RADIUS = Context(prec=2, rounding=ROUND_CEILING)


@dataclass(frozen=True)
class Certifying(ManyAtOnce):
    """An engine that certifies the answers of another one."""

    engine: Engine | ManyAtOnce

    def solve_all(self, scenes: Sequence[Scene], threads: int = 1) -> list[Result]:
        """Certify the result of each scene, in order."""
        results = solve_each(scenes, self.engine, threads)
        return [certify(scene, result) for scene, result in zip(scenes, results, strict=True)]

    def solve_as_data(self, scenes: Sequence[Scene], threads: int = 1) -> list[dict[str, Any]]:
        """Return the same as plain data."""
        return [result.data() for result in self.solve_all(scenes, threads)]


def certify(scene: Scene, result: Result) -> Result:
    """Return the result of a scene, by any engine, with a proven error for each of its numbers.

    The outcome is proven, too, and the numbers are `longball.model.result.Certified`. If that
    cannot be had, the result is as it was, with the reason as its `certificate`; one with an error
    is returned as it is.
    """
    if result.error is not None:
        return result
    reason = ""
    proven: Result | None = None
    # More digits until smaller balls would hardly lower the errors. A proof that was found stays,
    # even if one with more digits fails.
    for digits in DIGITS:
        engine = Enclosure(digits)
        try:
            with engine.numbers.arithmetic():
                proven, tight = _with_errors(result, quantities_of(scene, engine))
        except _Refuted as refuted:
            reason = str(refuted)
            break
        except (ArithmeticError, ValueError) as error:
            reason = f"the enclosure with {digits} digits proves nothing: {error}"
            if isinstance(error, InvalidScene | TooLong):
                break
        else:
            if tight:
                break
    return proven or result.model_copy(update={"certificate": reason})


class _Refuted(Exception):
    """Raised where a proof contradicts a result, or does not cover it."""


def _with_errors(result: Result, truth: dict[str, Any]) -> tuple[Result, bool]:
    """Return a result with its proven errors, and whether smaller balls would hardly lower them."""
    if result.outcome != truth["outcome"]:
        raise _Refuted(f"the outcome is proven to be {truth['outcome']}, not {result.outcome}")
    certain: dict[str, Any] = {}
    tight = True
    for name, proven in truth.items():
        given = quantities.at(result, name)
        if given is None:
            continue
        if isinstance(proven, str | int):  # a word, a truth value or a whole number
            if given != proven:
                raise _Refuted(f"{name} is proven to be {proven}, not {given}")
            continue
        # numbers and vectors: a number is a vector of one component
        one = not isinstance(proven, tuple)
        pairs = [*zip([given] if one else given, [proven] if one else proven, strict=True)]
        numbers = tuple(Certified(value=float(x), radius=_radius(float(x), b)) for x, b in pairs)
        certain[name] = numbers[0] if one else numbers
        small = _NOTHING * math.hypot(*map(float, numbers))
        tight &= all(b.rad() <= max(small, float(abs(b.mid() - float(x)))) for x, b in pairs)
    # no number without a proof
    certified = quantities.rewritten(result, certain)
    for name, number in quantities.numbers(certified):
        if not isinstance(number, Certified | int):
            raise _Refuted(f"there is no proof of {name} where the outcome is {result.outcome}")
    return certified, tight


def _radius(value: float, ball: arb) -> str:
    """Return a decimal number that is at least the distance of all of a ball from a value."""
    bound = abs(ball - value).upper()
    if bound == 0:
        return "0"
    if not bound.is_finite():
        raise OverflowError("a number is not finite")
    above = math.nextafter(float(bound), math.inf)  # float() rounds to nearest
    return f"{_RADIUS.create_decimal_from_float(above):e}"
