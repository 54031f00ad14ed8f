"""Digits of a candidate's numbers: their style, and the effect of their rounding on the stages.

Numbers are written with a number of significant digits or of decimals, in single precision, or in
full. The style of a quantity is the one in which all its numbers take the fewest bits.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import Any, Literal

import numpy as np

from longball.judge.answers import Answer
from longball.judge.diagnosis.chain import CHAIN, OWN, Stage, ended, flown
from longball.judge.diagnosis.evidence import CHANCE, DIGIT
from longball.judge.diagnosis.expression import ordered
from longball.judge.diagnosis.residual import (
    Data,
    Index,
    follow,
    follows,
    is_rough,
    take,
    values,
)
from longball.model.arrays import Array

DOUBLE, SINGLE = 53.0, 24.0  # bits of a number
DIFFERENT = 4  # distinct numbers that a style needs: a constant 1 is not rounded to one digit
TELLING = 9  # digits that distinguish a number in single precision from its neighbours
# Roundings in single precision that add up in a calculation, such as one in each of 1,000 steps.
ROUNDINGS = 1e3  # a free choice


@dataclass(frozen=True)
class Digits:
    """A style of numbers, and half a unit in the last place: absolute, and relative.

    Attributes
    ----------
    kind, count
        "digits" or "decimals", and their number; "single" has no number.
    """

    kind: Literal["digits", "decimals", "single"]
    count: int = 0

    def bits(self, numbers: Sequence[Decimal]) -> float:
        """The bits that numbers take in this style."""
        if self.kind == "single":
            return SINGLE * len(numbers)
        # With decimals, a number also has the digits before its point. For 0.001 their number is
        # negative: its leading zeros are no information.
        more = sum(x.adjusted() + 1 for x in numbers) if self.kind == "decimals" else 0
        return DIGIT * (self.count * len(numbers) + more)

    @property
    def cut(self) -> tuple[float, float]:
        """Half a unit in the last place: absolute, and relative to the number."""
        if self.kind == "decimals":
            return 0.5 * 10.0**-self.count, 0.0
        return 0.0, 2.0**-SINGLE if self.kind == "single" else 0.5 * 10.0 ** (1 - self.count)

    @property
    def words(self) -> str:
        """The style as a clause without its subject."""
        if self.kind == "single":
            return "writes numbers in single precision"
        noun = "significant digit" if self.kind == "digits" else "decimal"
        return f"writes {self.count} {noun}{'s' * (self.count != 1)}"


def digits_of(numbers: Iterable[Decimal]) -> Digits | None:
    """Style of some numbers; None if they have all digits, or too few different values."""
    # A number may end in zeros, which are not known to be significant. The longest number shows the
    # style.
    known = sorted({abs(x.normalize()) for x in numbers if x})
    if len(known) < DIFFERENT:
        return None
    digits = max(len(x.as_tuple().digits) for x in known)
    decimals = max(0, *(-int(x.as_tuple().exponent) for x in known))
    ways = [Digits("digits", digits), Digits("decimals", decimals)]
    if digits >= TELLING and all(_is_single(x) for x in known):
        ways.append(Digits("single"))
    best = min(ways, key=lambda style: style.bits(known))
    return best if best.bits(known) + CHANCE < DOUBLE * len(known) else None


def _is_single(x: Decimal) -> bool:
    """True if a number is one in single precision, rounded to the digits that are written."""
    with np.errstate(all="ignore"):
        near = Decimal(float(np.float32(float(x))))
    unit = Decimal(1).scaleb(int(x.as_tuple().exponent))
    return near.is_finite() and abs(near - x) <= max(unit / 2, abs(x) * Decimal(2) ** -52)


def styles(answers: Mapping[str, Answer]) -> dict[str, Digits]:
    """The style of each quantity that is not written in full.

    A style common to all numbers is preferred, unless the quantity's own style takes far fewer
    bits.
    """
    told: dict[str, list[Decimal]] = {}
    for answer in answers.values():
        for quantity in OWN:
            told.setdefault(quantity, []).extend(
                x.normalize() for x in answer.values.get(quantity, ()) if x
            )
    common = digits_of(x for numbers in told.values() for x in numbers)
    found = {}
    for quantity, numbers in told.items():
        style = digits_of(numbers)
        if common is not None and (
            style is None or common.bits(numbers) < style.bits(numbers) + CHANCE
        ):
            style = common
        if style is not None:
            found[quantity] = style
    return found


def with_digits(data: Data, answers: Mapping[str, Answer]) -> Data:
    """Data whose floors include the digits that the candidate writes."""
    return with_cut(data, {quantity: style.cut for quantity, style in styles(answers).items()})


def with_cut(data: Data, cut: Mapping[str, tuple[float, float]]) -> Data:
    """Data whose floors include half a unit in the last digit of some quantities."""
    # Rounding errors are computed once, without edits. They take a flight for each rounded number,
    # and hardly depend on the edit.
    known: dict[tuple[Any, ...], Array] = {}

    def kept(stage: Stage, data: Data, columns: Mapping[str, Any], some: Index) -> Array:
        key = stage.key, stage.quantities, some.tobytes()
        if key not in known:
            known[key] = slips(stage, data, columns, some)
        return known[key]

    return replace(data, cut=cut, slips=kept) if cut else data


def slips(stage: Stage, data: Data, columns: Mapping[str, Any], some: Index) -> Array:
    """Errors of each number of a stage from the rounding of the candidate's own values.

    Roundings are independent, so that the squares of their effects on a number add up.
    """
    own = take(columns, some)
    used = {node.data for node in ordered(stage.roots.values()) if node.op == "symbol"}
    right = values(stage, own)
    # A branch, such as that of friction, may change on one side only.
    branches = stage.kind == "formula" and is_rough(stage)
    sides = (1.0, -1.0) if branches else (1.0,)
    squares = {quantity: np.zeros(np.shape(value)) for quantity, value in right.items()}
    units = {
        quantity: absolute + relative * np.abs(own[str(OWN[quantity].data)])
        for quantity, (absolute, relative) in data.cut.items()
    }
    # The ball's velocity and spin at the bat follow from the pitch at the time that is written.
    if used & {OWN[quantity].data for quantity in _BROUGHT} and data.slips is not None:
        struck = own["kind"] == "at-bat"
        rows = np.zeros((6, len(some)))
        rows[:, struck] = data.slips(_TOUCHING, data, columns, some[struck])[3:9]
        units |= zip(_BROUGHT, (rows[:3], rows[3:]), strict=True)
    for quantity, unit in units.items():
        name = str(OWN[quantity].data)
        # These give the duration, and the time of its end.
        lasts = {flown.data, ended.data} if quantity in _LASTING else set()
        if name not in used and used.isdisjoint(lasts):
            continue
        for part in range(len(unit)) if OWN[quantity].vector else (...,):
            by = np.zeros_like(unit)
            by[part] = unit[part]
            for side in sides:
                moved = {**own, name: own[name] + side * by}
                moved |= {str(other): own[str(other)] + side * by for other in lasts}
                for number, value in values(stage, moved).items():
                    squares[number] += np.nan_to_num(value - right[number]) ** 2 / len(sides)
    return np.concatenate([np.atleast_2d(np.sqrt(x)) for x in squares.values()])


(_TOUCHING,) = (stage for stage in CHAIN if stage.key == ("touching", "flight"))
_LASTING = "landing.hang_time", "landing.time"
_BROUGHT = _TOUCHING.quantities[1:3]  # velocity and spin, which no candidate writes


def said(found: Mapping[str, Digits], told: Collection[str]) -> str:
    """The styles of quantities as a clause; `told` are all quantities that the candidate gives."""
    kinds: dict[Digits, list[str]] = {}
    for quantity, style in found.items():
        kinds.setdefault(style, []).append(quantity)
    if len(kinds) == 1 and found.keys() >= set(told):
        return next(iter(kinds)).words
    return "; ".join(f"{style.words} of {' and '.join(those)}" for style, those in kinds.items())


def explain_digits(
    chain: Sequence[Stage], data: Data, answers: Mapping[str, Answer],
    elsewhere: Callable[[], bool] = lambda: True,
) -> str | None:  # fmt: skip
    """The style in which the candidate writes numbers, if it explains all errors.

    `elsewhere` returns True if it also explains the errors in new scenes.
    """
    found = styles(answers)
    _, before = follow(chain, data)
    if not found or not any(one.wrong.any() for one in before):
        return None

    def explain(some: Mapping[str, Digits]) -> bool:
        return follows(chain, with_cut(data, {q: style.cut for q, style in some.items()}))

    if explain(found) and elsewhere():
        for quantity in found if len({*found.values()}) > 1 else ():
            needed = {q: style for q, style in found.items() if q != quantity}
            if explain(needed):  # the digits of the quantity explain no error
                found = needed
        told = [quantity for quantity in OWN if np.isfinite(data.given[quantity]).any()]
        return said(found, told)
    # A program that computes in single precision also rounds within its steps. Its errors are then
    # larger than the rounding of its outputs.
    single = any(style.kind == "single" for style in found.values())
    if single and all(one.relative.max(initial=0.0) < ROUNDINGS * 2.0**-SINGLE for one in before):
        return "computes in single precision"
    return None
