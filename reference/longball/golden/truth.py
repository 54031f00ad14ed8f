"""From a draft to a golden case: solved with proof, confirmed by another method, and judged."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

from longball.engines.chain import solve, solve_once
from longball.engines.digits import are_reached, shortened, sizes
from longball.engines.enclosure import Enclosure
from longball.engines.multiprecision import Multiprecision
from longball.golden.case import (
    FOUND,
    Case,
    Confirmation,
    Difficulty,
    Draft,
    Quantity,
    as_double,
    decisions,
    decisive,
)
from longball.golden.condition import (
    Sensitivity,
    attainable_errors,
    condition,
    magnitudes,
    sensitivity,
)
from longball.model.quantities import numbers_of, replaced
from longball.model.result import Result
from longball.model.scene import Scene

# The digits that are promised: a proven radius of at most 1e-30 of a quantity's size. Where 30
# digits of work do not get there, or cannot decide, more are tried before that is believed.
DIGITS = 30
WORK = (DIGITS, 2 * DIGITS, 4 * DIGITS)

# Digits of the independent method: what it prints is rounded far below the radii. More of them for
# tiny numbers that are differences of large ones: its errors are relative to those.
CONFIRMING = (DIGITS + 5, 2 * (DIGITS + 5), 3 * (DIGITS + 5))

_PREC = 4 * WORK[-1]  # digits of decimal arithmetic: more than any number here has


def prove(scene: Scene) -> Result:
    """Return the result of a scene with proven radii, or with the reason why there is none.

    Numbers have 31 digits and a radius of at most 1e-30 of their size (see `sizes`), if any number
    of `WORK` brings that about.
    """
    # A radius grows on the way: more digits of work, not more steps, make it smaller.
    for digits in WORK:
        result = solve_once(scene, Enclosure(digits))
        if result.error is None and are_reached(scene, result, DIGITS):
            break
    return replaced(result, {n: shortened(number, DIGITS) for n, number in numbers_of(result)})


def confirm(scene: Scene, proven: Result) -> tuple[Confirmation, bool]:
    """Solve a scene by the independent method; return what it says, and whether it agrees.

    It agrees if outcomes are the same and every number lies within the proven radius, but for the
    digits that it is known to; higher precision is tried before a disagreement is accepted. Where
    nothing is proven there is nothing to disagree with.
    """
    for digits in CONFIRMING:
        engine = Multiprecision(digits)
        other = solve(scene, engine)
        if proven.outcome is None or decisions(other) != decisions(proven):
            agrees, agreement = proven.outcome is None, None
        else:
            agrees, agreement = _compared(scene, proven, other, digits)
        if agrees:
            break
    confirmation = Confirmation(
        engine=engine.description, outcome=other.outcome, agreement=agreement
    )
    return confirmation, agrees


def _compared(
    scene: Scene, proven: Result, other: Result, digits: int
) -> tuple[bool, float | None]:
    """Compare two results: their agreement, and their largest difference in 1e-30 of a size."""
    here, there = dict(numbers_of(proven)), dict(numbers_of(other))
    agrees, largest = True, Decimal(0)
    with localcontext(prec=_PREC):
        for name, size in sizes(scene, proven).items():
            if name not in there:  # such as an apex that so few digits do not find
                return False, None
            difference = abs(Decimal(here[name].value) - Decimal(there[name].value))
            radius = Decimal(here[name].radius or "Infinity")
            # Two digits for what the method's error may grow to on the way.
            agrees = agrees and difference <= radius + size.scaleb(2 - digits)
            if size:
                largest = max(largest, difference / size)
        return agrees, float(f"{largest.scaleb(DIGITS):.3g}")


def quantities(result: Result, errors: dict[str, float | None]) -> dict[str, Quantity]:
    """Return every number of a result as a double, with the accuracy that doubles can attain."""
    table, magnitude = {}, magnitudes(result)
    for name, number in numbers_of(result):
        double, error, size = as_double(number), errors[name], magnitude[name]
        digits = max(0.0, round(math.log10(size / error), 1)) if error and size else None
        table[name] = Quantity(double=double, hex=double.hex(), attainable=error, digits=digits)
    return table


def level_of(result: Result, table: dict[str, Quantity], fragile: bool) -> Difficulty:
    """Return the difficulty of a case, from the digits that doubles can know of it."""
    if result.outcome is None or fragile:
        return "higher"
    asked = [table[name] for name in decisive(result)]
    if any(quantity.attainable is None for quantity in asked):
        return "higher"
    # A distance of exactly zero has no digits to lose.
    fewest = min((q.digits for q in asked if q.digits is not None), default=16.0)
    return "lower" if fewest >= 13 else "average" if fewest >= 10 else "higher"


def make(family: str, draft: Draft) -> Case:
    """Return the golden case of a draft."""
    scene = draft.scene
    # the truth, and what another method says of it
    result = prove(scene)
    confirmation, agrees = confirm(scene, result)
    # what doubles can attain, from the derivatives; without an outcome there are none
    found = Sensitivity({}, False)
    if result.outcome is not None:
        found = sensitivity(scene, result, Enclosure(DIGITS))
    table = quantities(result, attainable_errors(scene, result, found))
    # flags in the order of `FOUND`
    solved_with = (
        result.outcome is None and "refused" not in draft.flags,
        result.engine != Enclosure(DIGITS).description,
        found.fragile,
        not agrees,
        result.outcome is not None and not are_reached(scene, result, DIGITS),
    )
    found_out = (flag for flag, applies in zip(FOUND, solved_with, strict=True) if applies)
    assert scene.id
    return Case(
        id=scene.id,
        family=family,
        level=level_of(result, table, found.fragile),
        comment=draft.comment,
        flags=(*draft.flags, *found_out),
        scene=scene,
        expected=result,
        quantities=table,
        condition=condition(result, found) if result.outcome is not None else None,
        confirmation=confirmation,
    )
