"""Coverage of a set of cases: the edits of the model that it detects, and the cases that do so.

This is the reverse of the diagnosis. The diagnosis searches for the edit that explains a program's
errors; the coverage counts the edits (`longball.judge.diagnosis.operators`) that a set of cases
would show. Every stage starts from the true values of earlier stages, so that a formula needs no
flight, and an edited law is evaluated along the true path only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden.case import decisions
from longball.judge.answers import Answer
from longball.judge.cases import Case, decidable
from longball.judge.diagnosis.chain import (
    CHAIN,
    INPUTS,
    LAW,
    OWN,
    I,
    Stage,
    r,
    rise,
    spin0,
)
from longball.judge.diagnosis.expression import (
    Columns,
    Node,
    Values,
    component,
    constant,
    norm,
    ordered,
    substitute,
    where,
)
from longball.judge.diagnosis.operators import LEFT_OUT, WITHOUT_BLOCK, Edit, edits, where_key
from longball.judge.diagnosis.residual import (
    ROUNDING,
    Data,
    Index,
    begun,
    data_of,
    take,
    values,
)
from longball.judge.diagnosis.response import Direct, Response, free
from longball.judge.diagnosis.search import defaults
from longball.judge.quantities import values_of
from longball.model.arrays import Array
from longball.model.quantities import replaced
from longball.model.scene import AtBatScene

Bools = NDArray[np.bool_]

# A case detects an edit that changes a number by this multiple of the unavoidable error: ten times
# the tolerance of the judge.
NOTICED = 1e3
# Rounding error in the difference of two formulas, relative to a number, or to 1 in its unit.
SEEN = ROUNDING


# Reasons why no case detects an edit.
NO_STEP = "no scene takes this step"
NO_NUMBER = "it uses what no scene has there, or divides by 0"
THE_SAME = "it comes to the same numbers"
TOO_SMALL = "it moves numbers by too little"
REASONS = NO_STEP, NO_NUMBER, THE_SAME, TOO_SMALL


@dataclass(frozen=True)
class Coverage:
    """Edits of the model, and the cases that detect them.

    Attributes
    ----------
    cases
        The cases, in order.
    edits
        Edits that change a number of some case; of those that change the same numbers, the
        cheapest.
    stages
        The stage of each edit.
    noticed
        True where a case detects an edit, shape (edits, cases).
    unnoticed
        Edits that no case detects, with their stages and the reason, one of `REASONS`.
    """

    cases: Sequence[Case]
    edits: tuple[Edit | Replaced, ...]
    stages: tuple[str, ...]
    noticed: Bools
    unnoticed: tuple[tuple[Edit | Replaced, str, str], ...]

    @property
    def bits(self) -> list[float]:
        """Cost of each edit in bits."""
        return [edit.bits for edit in self.edits]

    def by_stage(self, some: Bools) -> list[tuple[str, int, int]]:
        """Stages with their numbers of edits, and the numbers of those flagged by `some`."""
        names = np.array(self.stages)
        order = dict.fromkeys([*(stage.name for stage in CHAIN), *self.stages])
        here = [(name, names == name) for name in order]
        return [(name, int(at.sum()), int(some[at].sum())) for name, at in here if at.any()]

    def told(self, i: Any) -> dict[str, str]:
        """The words and the stage of edit `i`, and the first case that detects it."""
        case = self.cases[int(self.noticed[i].argmax())]
        return {"stage": self.stages[i], "edit": self.edits[i].words, "case": case.id}


# --- edits that no operator makes -----------------------------------------------------------------


@dataclass(frozen=True)
class Replaced:
    """A mistake that has the effect of another number in the scene, and changes outcomes only."""

    bits = 0.0
    words: str
    number: str  # its name
    by: Callable[[float], float]

    def notices(self, case: Case) -> bool:
        """True if the mistake changes the outcome of a case, or leaves it without one."""
        scene: Any = case.scene
        if self.number not in type(scene).model_fields:
            return False
        value = self.by(getattr(scene, self.number))
        if value == getattr(scene, self.number) or value <= 0.0:
            return bool(value <= 0.0)
        if case.expected.outcome != "airborne":
            return value < max(_durations(case), default=0.0)
        moved = solve(replaced(scene, {self.number: value}), Ivp())
        return decisions(moved) != decisions(case.expected)


def _durations(case: Case) -> Iterator[float]:
    """Durations of a case's flights, s."""
    found = case.expected
    for block in (found.plate, found.landing, found.fence):
        begun = found.contact.time if found.contact and block is not found.plate else 0.0
        if block is not None:
            yield float(block.time) - float(begun or 0.0)


LIMITS = (
    Replaced("cuts the time limit to whole seconds", "time_limit", math.floor),
    Replaced("uses 60 s for the time limit", "time_limit", lambda limit: 60.0),
    Replaced("uses half the time limit", "time_limit", lambda limit: limit / 2),
    Replaced("uses twice the time limit", "time_limit", lambda limit: limit * 2),
)


def _other_defaults() -> Iterator[Edit]:
    """Another default for each number that has one: a tenth more, or 0.1 for 0."""
    usual = AtBatScene()
    for node, path, _ in INPUTS:
        name = str(node.data)
        if name not in defaults() and path not in ("pitch.release", "ball.inertia_factor"):
            continue
        vector = isinstance(getattr(usual.pitch, path.rpartition(".")[2], None), tuple)
        zero = defaults().get(name) == 0.0 and not vector
        more = constant(0.1, node.dimension) if zero else 0.1 * node
        other = where_key((LEFT_OUT, WITHOUT_BLOCK), node, node + more)
        yield Edit(node, other, 0.0, f"uses another default for {path}")


def _beside() -> Iterator[Edit]:
    """Mistakes that no operator makes."""
    yield from _other_defaults()
    above_ground = substitute(rise, component(r, 2), component(r, 2) - I["ground"])
    yield Edit(rise, above_ground, 0.0, "counts the heights of a wind profile from the ground")
    # A program that tests the size of the spin, and not its key, uses the paper's lift for a ball
    # with a spin of 0.
    (lift,) = (n for n in ordered([LAW]) if n.op == "switch" and n.data[0] == "spin")
    paper, _ = lift.args
    yield Edit(lift, where(norm(spin0), lift, paper), 0.0, "lifts a ball of spin 0 as one without")


# --- effects of edits -----------------------------------------------------------------------------

# Nodes of the Gauss-Legendre rule over the time of flight. Few are enough: first-order effects are
# right to a factor near 1, and most edits are above or below the limit by many powers of ten.
NODES = 4


# Flights that are parts of another flight under the same law.
PARTS = "touching", "fence"


@dataclass(frozen=True)
class _Effects:
    """Effects of edits at a stage, in the scenes that have it."""

    stage: Stage
    some: Index
    nodes: Mapping[str, frozenset[Node]]  # of each formula of the stage
    effects: Response | Direct
    allowed: Array  # largest undetected change of each number

    def has(self, edit: Edit) -> bool:
        """True if the stage uses the node that an edit replaces."""
        return any(
            edit.place in nodes and self.stage.takes(name, edit.new)
            for name, nodes in self.nodes.items()
        )

    def of(self, edit: Edit) -> Array:
        """The changes of the stage's numbers by an edit; NaN where there is no number."""
        moved = self.effects.moved([(edit, None)])[0, : len(self.allowed)]
        moved = np.where(np.isfinite(self.allowed) & np.isfinite(moved), moved, np.nan)
        return np.broadcast_to(moved, self.allowed.shape)


def _effects(stage: Stage, columns: Columns, data: Data) -> _Effects | None:
    """The effects at a stage; None if no scene has the stage."""
    here = np.isin(columns["kind"], stage.scenes)
    first = np.atleast_2d(data.expected[stage.quantities[0]])
    some = np.flatnonzero(here & np.isfinite(first).all(axis=0))
    if not len(some):
        return None
    # The largest undetected change of each number; infinite where a result lacks the number.
    rows = []
    for quantity in stage.quantities:
        # Results do not contain the spin at the contact. It equals that after an impact without
        # friction. The velocity there needs no limit: it is right if the position is. They report
        # the ball's path as `landing.path`.
        told = {"contact.spin": "impact.spin", "flight.path": "landing.path"}.get(
            quantity, quantity
        )
        known = np.isfinite(np.atleast_2d(data.expected[told])).all(axis=0)
        errors = np.where(known, data.attainable[told], np.inf)[some]
        size = np.sqrt(np.square(np.atleast_2d(columns[str(OWN[told].data)][..., some])).sum(0))
        least = np.maximum(NOTICED * errors, SEEN * np.fmax(size, 1.0))
        rows += [least] * (3 if OWN[quantity].vector and stage.kind != "event" else 1)
    own = stage.with_spin(take(columns, some))
    flies = stage.kind == "flight"
    at = Values(own)
    # The sensitivity of a ball without forces is right to a factor, which is enough (`NODES`).
    # Edits of the law are tried on whole flights only, not again on their parts.
    effects = Response(stage, at, sensitivity=free, nodes=NODES) if flies else Direct(stage, at)
    passed = {"through", "law"} if stage.name in PARTS else set[str]()
    # The speed along the path is one node, as it is for the operators.
    nodes = {
        name: frozenset([root] if name == "through" else ordered([root]))
        for name, root in stage.roots.items()
        if name not in passed
    }
    return _Effects(stage, some, nodes, effects, np.array(rows))


def _settled(edit: Edit, at: Values) -> Edit:
    """An edit with a typical value of its free number: a factor of 1.1, or a starting value."""
    if not edit.starts:
        return edit
    x = edit.starts[len(edit.starts) // 2]
    if edit.factor:
        return edit.settled(1.1, 0.0)
    if isinstance(x, Node):
        known = np.asarray(at.of(x))
        known = known[np.isfinite(known)]
        x = float(np.median(known)) if known.size else math.nan  # no scene has it
    return edit.settled(x, 0.0)


def _why(moved: Array, allowed: Array) -> str:
    """The reason why changes are not detected."""
    if np.isnan(moved).all():
        return NO_NUMBER
    # Changes below a thousandth of the limit are rounding errors (`SEEN`): the edit has no effect.
    return TOO_SMALL if (np.abs(moved) > allowed / 1e3).any() else THE_SAME


def _hash(moved: Array) -> int:
    """Hash of numbers, equal if they agree to three digits."""
    # Keep the upper 10 of the 23 bits of a float32's mantissa, rounded.
    bits = moved.astype(np.float32).view(np.int32)
    return hash((((bits + 0x1000) >> 13) * (moved != 0)).tobytes())


def every_edit(every: int = 1) -> Iterator[tuple[Stage, Edit]]:
    """Edits of the model, each once, with the first stage that uses the edited node.

    `every` selects one of so many edits of the operators, 0 none of them; all other edits follow.
    """
    seen = set[tuple[int, int]]()  # digests, since a million nodes would take gigabytes
    for stage in CHAIN if every else ():
        for edit in edits(CHAIN, stage, defaults(), {}, most=math.inf):
            if (key := (edit.place.digest, edit.new.digest)) not in seen:
                seen.add(key)
                if len(seen) % every == 0:
                    yield stage, edit
    for edit in _beside():
        yield next(s for s in CHAIN if s.edited(edit.place, edit.new) is not s), edit


@np.errstate(all="ignore")
def coverage(
    cases: Sequence[Case],
    every: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> Coverage:
    """Determine the edits of the model that cases detect.

    Parameters
    ----------
    cases
        Golden cases, or others with their truth; those without an outcome are dropped.
    every
        Try one of so many edits of the operators: 1 tries all, which takes minutes for a thousand
        cases; 0 tries none.
    progress
        Called from time to time with the number of edits that were tried.

    Returns
    -------
    Coverage
        Its cases are those that have an outcome.
    """
    cases = [case for case in cases if decidable(case)]
    true = [Answer(c.id, c.expected.outcome, values_of(c.expected)) for c in cases]
    data = data_of(cases, {answer.id: answer for answer in true})
    columns = begun(data)
    stages: dict[int, _Effects] = {}  # by place in the chain
    for place, stage in enumerate(CHAIN):
        if stage.name == "touching" and stage.kind == "flight":
            columns = _with_contact(stage, columns, data)
        if (effects := _effects(stage, columns, data)) is not None:
            stages[place] = effects
    rows: dict[int, tuple[Edit | Replaced, str, Bools]] = {}
    unnoticed: list[tuple[Edit | Replaced, str, str]] = []
    nowhere = Values(columns)
    for done, (first, edit) in enumerate(every_edit(every), 1):
        # An edit of a definition may change several stages, each of which may detect it. The key
        # combines the effects on all stages, so that equal edits have equal keys.
        touched = [i for i, one in stages.items() if one.has(edit)]
        edit = _settled(edit, stages[touched[0]].effects.at if touched else nowhere)
        noticed, key, why = np.zeros(len(cases), dtype=bool), 0, NO_STEP
        for place in touched:
            one = stages[place]
            moved = one.of(edit)
            shows = np.abs(moved) > one.allowed
            if shows.any():
                noticed[one.some] |= shows.any(axis=0)
                key = hash((key, place, _hash(np.where(shows, moved, 0.0))))
            why = max(why, _why(moved, one.allowed), key=REASONS.index)
        if not noticed.any():
            unnoticed.append((edit, first.name, why))
        elif key not in rows or edit.bits < rows[key][0].bits:
            rows[key] = edit, first.name, noticed
        if done % 100 == 0:
            progress(done)
    for limit in LIMITS:
        row = np.array([limit.notices(case) for case in cases])
        rows[hash(limit)] = limit, "outcome", row
    found = [*rows.values()]
    return Coverage(
        cases,
        tuple(edit for edit, _, _ in found),
        tuple(name for _, name, _ in found),
        np.array([row for *_, row in found]),
        tuple(unnoticed),
    )


def _with_contact(stage: Stage, columns: Mapping[str, Any], data: Data) -> dict[str, Any]:
    """Columns with velocity and spin at the contact, which no result contains."""
    some = np.flatnonzero(
        (columns["kind"] == "at-bat") & np.isfinite(data.expected["contact.time"])
    )
    found, filled = values(stage, take(columns, some)), {**columns}
    for quantity in ("contact.velocity", "contact.spin"):
        name = str(OWN[quantity].data)
        filled[name] = filled[name].copy()
        filled[name][:, some] = found[quantity]
    return filled
