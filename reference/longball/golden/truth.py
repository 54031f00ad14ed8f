"""From a draft to a golden case: proven result, confirmation, and difficulty."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

from longball.engines.chain import solve, solve_once
from longball.engines.digits import missed_in, shortened, sizes
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

# Promised digits: a proven radius of at most 1e-30 of a quantity's size. If 30 working digits do
# not reach it, or cannot decide the outcome, 60 and 120 are tried.
DIGITS = 30
WORK = (DIGITS, 2 * DIGITS, 4 * DIGITS)

# Digits of the independent method: five more than the truth, so that its own error is far below the
# radii. Tiny numbers that are differences of large ones need more, because its errors are relative
# to the large ones.
CONFIRMING = (DIGITS + 5, 2 * (DIGITS + 5), 3 * (DIGITS + 5))

# Digits of decimal arithmetic: more than any number here has, so that differences are exact.
_PREC = 4 * WORK[-1]


def prove(scene: Scene) -> Result:
    """Return the result of a scene with proven radii, or with the reason why there is none.

    Numbers have 31 digits and a radius of at most 1e-30 of their size (see `sizes`), unless all
    precisions of `WORK` fail.
    """
    # Radii grow along the flight. More working digits make them smaller; more steps do not.
    for digits in WORK:
        result, _ = solve_once(scene, Enclosure(digits))
        if result.error is None and not missed_in(scene, result, DIGITS):
            break
    return replaced(result, {n: shortened(number, DIGITS) for n, number in numbers_of(result)})


def confirm(scene: Scene, proven: Result) -> tuple[Confirmation, bool]:
    """Solve a scene by the independent method; return its result, and whether it agrees.

    It agrees if the decisions are the same and every number lies within the proven radius, enlarged
    by the method's own error. Higher precisions are tried before a disagreement is accepted. A
    scene without a proven outcome always agrees.
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
            # The method proves no bound: allow its error to grow a hundredfold along the flight.
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
    # The limits are those of the header: doubles keep at least 13 digits of the decisive
    # quantities, or at least 10. A distance of exactly zero has no digits to lose.
    fewest = min((q.digits for q in asked if q.digits is not None), default=16.0)
    return "lower" if fewest >= 13 else "average" if fewest >= 10 else "higher"


def make(family: str, draft: Draft) -> Case:
    """Return the golden case of a draft."""
    scene = draft.scene
    # the truth, and its confirmation by another method
    result = prove(scene)
    confirmation, agrees = confirm(scene, result)
    # what doubles can attain, from the derivatives; without an outcome there are none
    sensitive = Sensitivity({}, False)
    if result.outcome is not None:
        sensitive = sensitivity(scene, result, Enclosure(DIGITS))
    table = quantities(result, attainable_errors(scene, result, sensitive))
    # Flags in the order of `FOUND`. A refused scene has no outcome by design, so it is not
    # undecided.
    solved_with = (
        result.outcome is None and "refused" not in draft.flags,
        result.engine != Enclosure(DIGITS).description,
        sensitive.fragile,
        not agrees,
        result.outcome is not None and missed_in(scene, result, DIGITS) != "",
    )
    found_out = (flag for flag, applies in zip(FOUND, solved_with, strict=True) if applies)
    assert scene.id
    return Case(
        id=scene.id,
        family=family,
        level=level_of(result, table, sensitive.fragile),
        comment=draft.comment,
        flags=(*draft.flags, *found_out),
        scene=scene,
        expected=result,
        quantities=table,
        condition=condition(result, sensitive) if result.outcome is not None else None,
        confirmation=confirmation,
    )
