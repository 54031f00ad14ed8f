"""Findings in sentences.

A sentence gives an error, its stage and its size. A remedy shows the right formula and the
candidate's.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.clocks import Scheme
from longball.judge.diagnosis.expression import (
    SWITCHED,
    Node,
    ordered,
    specialised,
    substitute,
    words,
)
from longball.judge.diagnosis.findings import (
    Diagnosis,
    Finding,
    Kind,
    StageRow,
    joined,
    many,
    size,
)
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.residual import HUGE, Data, Followed
from longball.judge.diagnosis.search import Located, Named


def diagnosis(followed: Iterable[Followed], findings: Sequence[Finding], data: Data) -> Diagnosis:
    """The diagnosis of a candidate, from the residuals of its stages before any edit."""
    # A flight and the event at its end have one name, and one row: that with more wrong scenes.
    rows: dict[str, StageRow] = {}
    for one in followed:
        row, before = _row(one, data), rows.get(one.stage.name)
        if row.checked and (before is None or row.wrong > before.wrong):
            rows[row.stage] = row
    wrong = [row for row in rows.values() if row.wrong]
    first = findings[0].stage if findings else wrong[0].stage if wrong else None
    if findings:
        sentence = findings[0].sentence
    elif first:
        sentence = f"{first} is the first step that is wrong"
    else:
        sentence = "every step is consistent with your earlier values"
    clean = [row.stage for row in rows.values() if not row.wrong]
    return Diagnosis(
        sentence=sentence, first=first, stages=[*rows.values()], clean=clean,
        findings=[*findings],
    )  # fmt: skip


def _row(one: Followed, data: Data) -> StageRow:
    counted = {"checked": int(one.checked.sum()), "wrong": int(one.wrong.sum())}
    return StageRow(stage=one.stage.name, worst=_worst(one), example=_example(one, data), **counted)


def _worst(one: Followed) -> float:
    return float(one.relative.max(initial=0.0, where=one.wrong))


def _example(one: Followed, data: Data) -> str | None:
    if not one.wrong.any():
        return None
    return data.cases[int(one.some[np.where(one.wrong, one.relative, 0.0).argmax()])].id


# --- sentences ------------------------------------------------------------------------------------


def named(
    stage: Stage, found: Named, one: Followed, data: Data, scenes: str | None = None
) -> Finding:
    """The finding of an edit that explains a stage; `stage` is the one before the edit."""
    # Edits at different nodes may have the same words.
    edit = joined([edit.words for edit in found.edits])
    same = [
        w for w in dict.fromkeys(e.words for e in found.same) if w != edit and SWITCHED not in w
    ]
    sentence = f"{stage.name}: your program {edit}. This step is wrong {_where(one)}."
    sentence += _of_a_part("edit", found.mends)
    if same:
        sentence += f" Equivalent in these scenes: {'; '.join(same)}."
    return _finding(
        one, data, kind="named", edit=edit, sentence=sentence, scenes=scenes,
        remedy=formulas(stage, found.edits[0], data), bits=round(found.evidence, 1),
    )  # fmt: skip


def located(
    stage: Stage, found: Located, one: Followed, data: Data, scenes: str | None = None
) -> Finding:
    """The finding of a stage that no edit explains."""
    sentence = f"{stage.name} is wrong {_where(one)}."
    seen = [*_equal(stage, data), *_beside_surface(one)]
    if found.nearest is None:
        kind: Kind = "located"
    else:
        kind = "nearest"
    # A refuted edit reproduces the compared scenes, but not new ones. Any other nearest edit
    # explains only a part of the errors.
    if found.nearest is not None and found.refuted is not None:
        wrong, of = found.refuted
        sentence += f" Your numbers are those of a program that {found.nearest.words}, but not in "
        sentence += f"{wrong} of {many(of, 'new scene')} like these."
    elif found.nearest is not None:
        sentence += " No single edit that is tried explains all your numbers. The nearest, that "
        sentence += f"your program {found.nearest.words}, "
        sentence += f"explains {100 * (1 - found.left):.0f}% of the error."
    right = words(_body(stage.roots["value"])) if stage.kind == "formula" else SWITCHED
    return _finding(
        one, data, kind=kind, edit=None, scenes=scenes,
        sentence=" ".join((sentence, *(f"{text}." for text in seen))),
        remedy=None if SWITCHED in right else f"{stage.quantities[0]} should be {right}",
    )  # fmt: skip


def scheme(
    stage: Stage, found: Scheme, one: Followed, data: Data, scenes: str | None = None
) -> Finding:
    """The finding of a stage whose errors a scheme explains, or resembles."""
    sentence = f"{stage.name}: your program {found.words}. This step is wrong {_where(one)}."
    sentence += _of_a_part("scheme", found.mends)
    return _finding(
        one, data, kind="named" if found.adequate else "nearest", sentence=sentence, scenes=scenes,
        edit=found.words if found.adequate else None, bits=round(found.evidence, 1),
        step=found.step,
    )  # fmt: skip


def _of_a_part(what: str, mends: int | None) -> str:
    if mends is None:
        return ""
    return f" This {what} explains {mends} of these scenes, and not the others."


def digits(words: str, followed: Iterable[Followed], data: Data) -> Finding:
    """The finding that all errors are those of the digits that the candidate writes."""
    wrong = [one for one in followed if one.wrong.any()]
    worst = max(wrong, key=_worst)
    sentence = f"Your program {words}: that rounding explains all its errors."
    found = _finding(worst, data, kind="named", edit=words, sentence=sentence)
    return found.model_copy(update={"stage": "all"})


def _finding(one: Followed, data: Data, **said: Any) -> Finding:
    return Finding(
        stage=one.stage.name, quantity=one.stage.quantities[0], wrong=int(one.wrong.sum()),
        checked=int(one.checked.sum()), worst=_worst(one), example=_example(one, data), **said,
    )  # fmt: skip


def _where(one: Followed) -> str:
    """Words for the number of scenes in which a stage is wrong, and the size of the errors."""
    scenes = f"in {one.wrong.sum()} of {many(int(one.checked.sum()), 'scene')}"
    if (np.abs(one.off) >= HUGE).any():
        return f"{scenes}, and not finite in some of them"
    if one.stage.kind == "event":
        return scenes
    return f"{scenes}, given your own earlier values (relative error up to {size(_worst(one))})"


# Words for the roots of a stage; the root of a formula is called by its quantity.
_ROOTS = {
    "rate": "the derivative of the position",
    "law": "the acceleration",
    "zero": "the event function",
    "place": "the starting position",
    "velocity": "the starting velocity",
    "spin": "the starting spin",
    "duration": "the duration",
    "spin_left": "the remaining fraction of the spin",
}


def formulas(stage: Stage, edit: Edit, data: Data) -> str | None:
    """The right and the edited form of the smallest definition that contains the edited node."""
    for key, root in stage.roots.items():
        # Definitions around the edited node, from the inside out. The first one that changes is
        # printed, because an edit is hard to see in a whole law.
        around = [
            node
            for node in ordered([root])
            if node.op == "named" and node is not edit.place and edit.place in ordered([node])
        ]
        for node in (*around, root):
            right = _body(node)
            other = _simple(substitute(right, edit.place, edit.new), stage, data)
            if SWITCHED in words(other):
                return None
            if words(other) != words(right):
                name = words(node) if node.op == "named" else _ROOTS.get(key, stage.quantities[0])
                return f"{name} should be {words(right)}; yours is {words(other)}"
    return None


def _simple(node: Node, stage: Stage, data: Data) -> Node:
    """An expression without terms that are 0 and factors that are 1."""
    return specialised(node, stage.with_spin(data.columns), {})


def _body(node: Node) -> Node:
    return node.args[0] if node.op == "named" else node


# --- hints without an edit ------------------------------------------------------------------------


def _equal(stage: Stage, data: Data) -> Iterable[str]:
    """Quantities that equal another of the candidate's, although the true values differ."""
    block = stage.quantities[0].partition(".")[0]
    for quantity in (*stage.quantities, f"{block}.time"):
        if quantity not in data.given:
            continue
        mine, true = data.given[quantity], data.expected[quantity]
        for other, theirs in data.given.items():
            if theirs.ndim != mine.ndim:
                continue
            # Values that are equal in truth, such as the two times of a flight scene, show nothing.
            least = 1e-6 * (1.0 + np.abs(true))  # a free choice
            apart = np.abs(true - data.expected[other]) > least
            both = np.isfinite(mine) & np.isfinite(theirs) & apart
            if both.sum() >= 3 * mine.ndim and (mine == theirs)[both].all():
                yield f"{quantity} equals your {other}"


# The surface of each event, a noun for the advice, and words for its positive and negative sides.
_SURFACES = {
    "plate.position": ("x = 0", "plane", "in front of", "behind"),
    "contact.position": ("the surface where ball and bat touch", "distance", "outside", "inside"),
    "landing.position": ("the ground", "height", "above", "below"),
    "fence.position": ("the fence", "line", "behind", "in front of"),
}


def _beside_surface(one: Followed) -> Iterable[str]:
    """Words for the distance between an event's point and its surface."""
    quantity = one.stage.quantities[0]
    off = np.where(np.abs(one.off) > one.tolerance, one.off, 0.0)
    if one.stage.kind != "event" or not off.any():
        return
    surface, noun, *sides = _SURFACES[quantity]
    far = [
        f"up to {distance:.2g} m {side} {surface}"
        for side, distance in zip(sides, (float(off.max()), float(-off.min())), strict=True)
        if distance > 0
    ]
    block = quantity.partition(".")[0]
    yield f"Your {block} point lies {' and '.join(far)}: check which {noun} you stop at"


def outcomes_wrong(pairs: Iterable[tuple[object, object]], quantity: str = "outcome") -> str:
    """A clause on wrong facts, from pairs of reported and true ones: '5 outcomes are wrong (…)'."""
    kinds = Counter(pairs).most_common()
    listed = ", ".join(
        f"{count} " * (len(kinds) > 1) + f"{_shown(said)} instead of {_shown(right)}"
        for (said, right), count in kinds
    )
    total = sum(count for _, count in kinds)
    what = many(total, "outcome" if quantity == "outcome" else f"{quantity} value")
    return f"{what} {'is' if total == 1 else 'are'} wrong ({listed})"


def _shown(value: object) -> str:
    return "none" if value is None else json.dumps(value)
