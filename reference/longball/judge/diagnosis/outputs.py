"""Outputs in other units or axes than the contract's, or copied from another quantity.

Such values are wrong at every stage that computes or uses them, although no formula is wrong. A
conversion of outputs is accepted if it mends at least two stages, or two quantities of one stage,
and breaks none. After a wrong formula, in contrast, the later stages are right.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from longball.judge.diagnosis.chain import INPUTS, OWN, Stage
from longball.judge.diagnosis.expression import M, S
from longball.judge.diagnosis.findings import Finding, joined, many
from longball.judge.diagnosis.operators import AXES, BITS, FACTORS
from longball.judge.diagnosis.residual import Data, Index, evenly, follow
from longball.judge.diagnosis.scenes import rule
from longball.judge.quantities import QUANTITIES
from longball.model.arrays import Array

# Limits of the search: free choices.
# A stage is mended if the right conversion leaves at most this fraction of its largest relative
# error. The rest may come from long steps, whose errors are less than a hundredth of a wrong
# unit's.
MENDED = 1e-2
BROKEN = 2.0  # a stage is broken if its error grows by more than this factor
CLOSE = 0.3  # fraction of the error that a conversion may leave if there is another mistake, too
NOTHING = 1e-6  # m, m/s: a value with a smaller error is not in another unit
MOST = 3  # largest number of successive conversions
FEW = 200  # scenes in which a conversion is tried first

SPEED = (1, 0, -1)
GROUPS: Mapping[str, tuple[str, ...]] = {
    "lengths": tuple(q for q, node in OWN.items() if node.dimension == M),
    "lengths and speeds": tuple(q for q, node in OWN.items() if node.dimension in (M, SPEED)),
    "speeds": tuple(q for q, node in OWN.items() if node.dimension == SPEED),
    "times": tuple(q for q, node in OWN.items() if node.dimension == S),
    "vectors": tuple(q for q, node in OWN.items() if node.vector),
    "positions": tuple(q for q, node in OWN.items() if node.vector and node.dimension == M),
    "velocities": tuple(q for q, node in OWN.items() if node.vector and node.dimension == SPEED),
}


# The largest relative error, and 1 if one is wrong; by a stage's name and kind, and the quantity.
Errors = Mapping[tuple[str, str, str], tuple[float, int]]


@dataclass(frozen=True)
class Conversion:
    """Another form in which the candidate gives some quantities.

    Attributes
    ----------
    outputs
        The quantities.
    words
        A clause such as "lengths are 3.28 times the right ones (feet)".
    bits
        Cost of the conversion.
    remedy
        An instruction to the author.
    given
        The converted values by quantity; NaN where the right value does not follow.
    """

    outputs: tuple[str, ...]
    words: str
    bits: float
    remedy: str
    given: Mapping[str, Array]


def outputs(data: Data, chain: Sequence[Stage]) -> tuple[Data, list[Finding]]:
    """Data with outputs converted back where that mends stages, and findings of the conversions."""
    findings: list[Finding] = []
    few = evenly(np.arange(len(data.cases)), FEW)
    errors = _errors(data, chain)
    while len(findings) < MOST and any(wrong for _, wrong in errors.values()):
        here = _errors(data, chain, few)
        found: list[tuple[int, float, Conversion, Errors]] = []
        for one in _conversions(data):
            converted = replace(data, given={**data.given, **one.given})
            if _mended(here, _errors(converted, chain, few)) < 2:
                continue
            after = _errors(converted, chain)
            mended = _mended(errors, after)
            if mended >= 2:
                found.append((-mended, one.bits, one, after))
        if not found:
            break
        # Accept the conversion that mends most, of several the likeliest. Others are tried in the
        # next round, on the converted data.
        _, _, best, errors = min(found, key=lambda way: way[:2])
        findings.append(_finding(best, data))
        data = replace(data, given={**data.given, **best.given})
    return data, findings


def _errors(data: Data, chain: Sequence[Stage], only: Index | None = None) -> Errors:
    """The largest relative error of each stage and quantity, and 1 if one is wrong."""
    _, followed = follow(chain, data, only=only)
    found: dict[tuple[str, str, str], tuple[float, int]] = {}
    for one in followed:
        # A flight has three vectors and a path, other stages have one quantity.
        rows = np.nan_to_num(np.abs(one.off) / one.scale)
        wrong = np.abs(one.off) > one.tolerance
        width = 3 if one.stage.kind == "flight" else len(rows)
        for i, quantity in enumerate(one.stage.quantities):
            some = slice(i * width, (i + 1) * width)
            key = *one.stage.key, quantity
            found[key] = float(rows[some].max(initial=0.0)), int(wrong[some].any())
    return found


def _mended(before: Errors, after: Errors) -> int:
    """Number of stages and quantities that are mended; 0 if one is broken."""
    count = 0
    for key, (error, wrong) in before.items():
        left, still = after[key]
        if still and left > BROKEN * error:
            return 0
        # A flight counts twice: it has six numbers, which a wrong conversion does not mend by
        # chance.
        weight = 2 if key[1] == "flight" else 1
        count += weight * (wrong and (not still or left <= MENDED * error))
    return count


def _finding(found: Conversion, data: Data) -> Finding:
    parts = [(np.atleast_2d(data.given[q]), np.atleast_2d(found.given[q])) for q in found.outputs]
    told = np.any([np.isfinite(given).any(axis=0) for given, _ in parts], axis=0)
    some = np.any([(given != right).any(axis=0) for given, right in parts], axis=0) & told
    count = int(some.sum())
    wrong, right = ([data.cases[int(i)] for i in np.flatnonzero(x)] for x in (some, told & ~some))
    return Finding(
        stage="all" if len(found.outputs) > 1 else "output", quantity=found.outputs[0],
        kind="named", edit=found.words, remedy=found.remedy, wrong=count, checked=int(told.sum()),
        worst=1.0, scenes=rule(wrong, right),
        sentence=f"{found.words}, in {many(count, 'scene')}. Converted back, they follow from each "
        "other.",
        example=data.cases[int(np.flatnonzero(some)[0])].id,
    )  # fmt: skip


# --- conversions ----------------------------------------------------------------------------------


def _conversions(data: Data) -> Iterator[Conversion]:
    """Conversions, each of all outputs that it brings much nearer to the truth."""
    known = [q for q in OWN if np.isfinite(data.given[q]).any()]
    for factor, words, remedy, bits in _factors(data):
        own = tuple(q for q in known if _fits(data, q, factor * data.expected[q]))
        if own:
            subject, verb = _named(own, known)
            right = "the right value" if verb == "is" else "the right ones"
            text = f"{subject} {verb} {words.format(right)}"
            given = {q: _where_off(data, q, data.given[q] / factor) for q in own}
            yield Conversion(own, text, bits, remedy or _remedy(own), given)
    vectors = [q for q in known if OWN[q].vector]
    for axes, rows in AXES.items():
        matrix = np.array(rows)
        own = tuple(q for q in vectors if _fits(data, q, matrix @ data.expected[q]))
        if own and abs(np.linalg.det(matrix)) == 1:  # can be inverted: no component is omitted
            subject, verb = _named(own, known)
            text = f"{subject} {verb} given as {axes}"
            bits = BITS["axes"] + math.log2(len(AXES))
            given = {q: _where_off(data, q, matrix.T @ data.given[q]) for q in own}
            yield Conversion(own, text, bits, "give [x, y, z] with the model's axes", given)
    yield from _others(data)


def _factors(data: Data) -> Iterator[tuple[Array | float, str, str | None, float]]:
    """Factors of outputs: numbers, and inputs; with words, remedies and bits."""
    for factor, meaning in FACTORS.items():
        words = "the negative of {}" if factor == -1 else f"{factor:.6g} times {{}}"
        note = f" ({meaning})" if meaning and factor != -1 else ""
        remedy = "turn the sign" if factor == -1 else None
        bits = BITS["factor"] + math.log2(len(FACTORS))
        yield factor, words + note, remedy, bits
    for one in INPUTS:
        name, column = one.symbol.data, data.columns[one.symbol.data]
        if not one.symbol.vector and (column > 0).all():
            bits = BITS["factor"] + 1 + math.log2(len(INPUTS))  # a free choice
            yield column, f"{{}} times {name}", f"do not multiply by {name}", bits
            yield 1.0 / column, f"{{}} divided by {name}", f"do not divide by {name}", bits


def _fits(data: Data, quantity: str, converted: Array) -> bool:
    """True if the given value is much nearer to a converted value than to the right one."""
    given, true = data.given[quantity], data.expected[quantity]
    off, plain = (np.sqrt(np.square(np.atleast_2d(given - x)).sum(0)) for x in (converted, true))
    known = np.isfinite(off) & (plain > NOTHING)
    return bool(known.any() and np.median(off[known] / plain[known]) < CLOSE)


def _where_off(data: Data, quantity: str, converted: Array) -> Array:
    """Convert only the values that are wrong; in scenes of another kind they may be right."""
    given = np.atleast_2d(data.given[quantity])
    off = np.abs(given - data.expected[quantity]).max(axis=0) > NOTHING
    return np.where(off, converted, data.given[quantity])


def _named(own: Sequence[str], known: Sequence[str]) -> tuple[str, str]:
    """Outputs in words, with their verb."""
    for name, group in GROUPS.items():
        if len(own) > 1 and {*own} == {*group} & {*known}:
            return f"all {name}", "are"
    return joined(own), "is" if len(own) == 1 else "are"


def _others(data: Data) -> Iterator[Conversion]:
    """Conversions of a quantity that equals another one of the candidate's."""
    for q, mine in data.given.items():
        for other, theirs in data.given.items():
            if (OWN[q].dimension, mine.ndim) != (OWN[other].dimension, theirs.ndim):
                continue
            both = np.isfinite(mine) & np.isfinite(theirs)
            apart = np.abs(data.expected[q] - data.expected[other]) > 1e-6  # a free choice
            # Values that agree to the last digit where the true ones differ were copied. The right
            # value cannot be recovered, and counts as missing.
            if (both & apart).any() and (mine == theirs)[both].all():
                wrong = {q: np.where(both, np.nan, mine)}
                bits = BITS["other"] + 2 * math.log2(len(OWN))  # a free choice
                yield Conversion(
                    (q,), f"{q} equals your {other}", bits, f"give {q}, not {other}", wrong
                )


def _remedy(own: Sequence[str]) -> str:
    units = dict.fromkeys(QUANTITIES[q].unit or "its own" for q in own)
    return f"give {joined(own) if len(own) < 3 else 'them'} in {joined(list(units))}"
