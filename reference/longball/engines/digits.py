"""The digits that an engine promises, and the check that a proven result has them.

The promise is relative to the size of a quantity. Where a calculation loses digits, so that radii
come out larger, an engine that proves them, and so has the method `finer`, does it again with more.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_CEILING, Decimal, localcontext
from typing import Any, TypeVar

from longball.model.quantities import numbers_of, replaced, vector_of
from longball.model.result import Bounded, Result
from longball.model.scene import AtBatScene, Scene

T = TypeVar("T")

# Digits of decimal arithmetic: more than any number with its radius has (`enclosure` allows 500).
_PREC = 1000


def to_digits(
    scene: Scene, engine: Any, solved: Callable[[Any], tuple[Result, T]]
) -> tuple[Result, T]:
    """Call a function with an engine until the result has the digits that the engine promises.

    Where digits are missed or a question is open, finer engines try again. The result is an error
    if none of them has the digits.
    """
    result, rest = solved(engine)
    digits: int = engine.digits
    for finer in engine.finer():
        if result.code != "undecided" and not missed_in(scene, result, digits):
            break
        more, path = solved(finer)
        if more.error is not None and more.code != "undecided":  # too long with more digits
            break
        # The answer of a finer engine is cut to the digits that were asked for.
        short = {name: shortened(number, digits) for name, number in numbers_of(more)}
        result, rest = replaced(more, short), path
    if missed := missed_in(scene, result, digits):
        fault = f"{missed} is not proven to {digits} digits; take fewer digits"
        known = {"id": result.id, "engine": result.engine}
        result = Result.model_validate(known | {"error": fault, "code": "out_of_range"})
    return result, rest


def missed_in(scene: Scene, result: Result, digits: int) -> str:
    """Return a quantity whose radius exceeds the promise, with the radius; "" if there is none.

    The promise is relative to the size of the quantity, and absolute next to zero.
    """
    if result.error is not None:
        return ""
    size = sizes(scene, result)
    with localcontext(prec=_PREC):
        for name, number in numbers_of(result):
            radius = Decimal(number.radius or "Infinity")
            # A number that may be zero has no digits: its radius counts as it is.
            at_zero = abs(Decimal(number.value)) <= radius <= Decimal(1).scaleb(-digits)
            if not (at_zero or radius <= size[name].scaleb(-digits)):
                return f"{name}, {float(number):.6g} ± {number.radius},"
    return ""


def shortened(number: Bounded, digits: int) -> Bounded:
    """Return a number with one digit more than promised; the radius includes the rounding.

    A number that cannot be distinguished from zero becomes zero.
    """
    with localcontext(prec=_PREC):
        whole = Decimal(number.value)
        radius = Decimal(number.radius or "Infinity")
        with localcontext(prec=digits + 1):
            value = +whole
        # "0 ± 3e-40" contains the same information as "1.2e-41 ± 2.9e-40".
        if abs(whole) <= radius:
            value = Decimal(0)
        radius += abs(value - whole)
        with localcontext(prec=3, rounding=ROUND_CEILING):
            return Bounded(value=str(value), radius=str(+radius) if radius else "0")


def sizes(scene: Scene, result: Result) -> dict[str, Decimal]:
    """Return the size of each quantity of a result, to which errors are relative, in its unit.

    The size of a component is the length of its vector, that of another number its absolute value.
    Margins and the clearance of a fence are differences; their size is at least that of one of the
    two terms. No number exceeds its size, so that `shortened`, which counts digits of the number,
    keeps the promised digits.
    """
    value = {name: Decimal(number.value) for name, number in numbers_of(result)}
    with localcontext(prec=_PREC):
        size = {
            name: sum((value[part] ** 2 for part in vector_of(name)), Decimal(0)).sqrt()
            for name in value
        }
        place = size.get("fence.position[0]", Decimal(0))
        least = {"fence.clearance": place, "fence.margin": place}
        least["impact.friction_margin"] = Decimal(1)
        if isinstance(scene, AtBatScene):
            least["contact.margin"] = Decimal(scene.ball.radius) + Decimal(scene.bat.radius)
        return {name: max(length, least.get(name, length)) for name, length in size.items()}
