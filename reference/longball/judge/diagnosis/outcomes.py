"""Facts that a candidate reports besides numbers: outcomes, fair balls, modes of impact.

A `Tree` is a list of tests in the order in which a scene meets them: the first one that holds
decides the outcome. A test holds if all its conditions are positive. Conditions are expressions
over inputs and the candidate's own quantities, so that mistakes are edits of them, by the operators
of `longball.judge.diagnosis.operators`. A value that a test needs may be unknown, such as the time
of a landing that does not happen. Then several outcomes are possible, and an edit that leaves
several possible is no evidence.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.judge.answers import Answer
from longball.judge.cases import Case
from longball.judge.diagnosis.chain import (
    CHAIN,
    OWN,
    I,
    Stage,
    V,
    at_fence,
    fence_flown,
    fence_time,
    friction_margin,
    hang,
    landing,
    landing_time,
    plate,
    plate_time,
    reach,
    w,
    y,
)
from longball.judge.diagnosis.evidence import CHANCE, DIGIT, NUMBER
from longball.judge.diagnosis.expression import (
    SWITCHED,
    M,
    Node,
    S,
    component,
    constant,
    dot,
    evaluate,
    function,
    named,
    norm,
    ordered,
    specialised,
    substitute,
    switch,
    symbol,
    where,
    words,
)
from longball.judge.diagnosis.findings import Finding, joined, many
from longball.judge.diagnosis.operators import BITS, FACTORS, FREE, Edit, edits
from longball.judge.diagnosis.residual import ROUNDING
from longball.judge.diagnosis.search import defaults
from longball.judge.diagnosis.sentences import outcomes_wrong
from longball.judge.quantities import QUANTITIES, superfluous, told_by, untrue
from longball.model.arrays import Array

Bools = NDArray[np.bool_]

ALIKE = DIGIT  # bits: edits that cost at most this much more than the cheapest are listed with it
MOST = 2  # largest number of edits that are listed with the cheapest; a free choice

time_limit, floor = symbol("time_limit", S), symbol("landing height", M)
margin, clearance = OWN["contact.margin"], OWN["fence.clearance"]


def _fair(place: Node) -> Node:
    return component(place, 0) - function("abs", component(place, 1), dimension=M)


# Conditions whose names replace "… > 0" in verdicts. The time at the fence is positive if the ball
# reaches it, and NaN otherwise.
passes = named("the ball reaches the fence", fence_time)
fair = named(
    "the ball is fair",
    switch("fence", {"a circle": constant(1.0, M), "a polyline": _fair(at_fence)}),
)
_place = named("place", where(fence_time, at_fence, landing))
_flies = named("the time of flight", where(passes, where(fair, fence_flown, hang), hang))


@dataclass(frozen=True)
class Test:
    """A fact about a scene that holds if all conditions are positive."""

    says: object
    conditions: tuple[Node, ...]
    kinds: tuple[str, ...] = ("flight", "pitch", "impact", "at-bat")
    after: tuple[str, ...] = ()  # stages on whose values it depends


@dataclass(frozen=True)
class Tree:
    """Tests in their order, and the fact, by kind of scene, if none of them holds."""

    name: str
    tests: tuple[Test, ...]
    otherwise: Mapping[str, object]
    pool: tuple[Node, ...] = ()  # further nodes for the operators

    def options(self) -> list[object]:
        """All facts that may be reported."""
        return list(dict.fromkeys([*(t.says for t in self.tests), *self.otherwise.values()]))


# Kinds of scenes with a pitch, with a collision, and with a flight that lands. Then the stages on
# which the ball's state depends at the plate, at the bat, and after it has left the bat.
_KINDS = "flight", "pitch", "impact", "at-bat"
_THROWN, _STRUCK, _FLOWN = ("pitch", "at-bat"), ("impact", "at-bat"), ("flight", "at-bat")
_PITCHED = ("pitch", "plate")
_TOUCHED = (*_PITCHED, "touching")
_LEFT = (*_TOUCHED, "velocity after", "flight")
# docs/model.md, "Scenes and outcomes".
OUTCOMES = Tree(
    "outcome",
    (
        Test("airborne", (plate_time - time_limit,), _THROWN, _PITCHED),
        Test("grounded", (floor - component(plate, 2),), _THROWN, _PITCHED),
        Test("missed", (-margin,), ("at-bat",), _TOUCHED),
        Test(
            "beyond_bat",
            (function("abs", y, dimension=M) - named("L/2", I["L"] / 2.0),), _STRUCK, _TOUCHED,
        ),
        Test("separating", (w,), _STRUCK, (*_TOUCHED, "normal", "bat velocity", "normal speed")),
        # A ball that is over the fence at the limit is a home run without a landing.
        Test("airborne", (_flies - time_limit,), _FLOWN, _LEFT),
        Test("wall", (passes, -clearance), _FLOWN, (*_LEFT, "fence", "clearance")),
        Test("home_run", (passes, fair), _FLOWN, (*_LEFT, "fence", "clearance")),
    ),
    {"flight": "landed", "pitch": "crossed", "impact": "struck", "at-bat": "batted"},
    (
        *(component(OWN["contact.position"], i) for i in range(3)), *(I[s] for s in ("R", "r_b")),
        reach, landing_time, landing, component(at_fence, 0), component(at_fence, 1),
        norm(OWN["contact.velocity"]), dot(V, OWN["contact.normal"]),
    ),
)  # fmt: skip
FAIR = Tree(
    "landing.fair",
    (Test(True, (_fair(_place),), after=_LEFT),),
    dict.fromkeys(_KINDS, False),
    tuple(component(place, i) for place in (landing, at_fence) for i in (0, 1)),
)
MODE = Tree(
    "impact.mode",
    (
        Test(
            "frictionless", (switch("bat.friction", {"none": constant(1.0), "given": -I["μ_f"]}),)
        ),
        Test("slide", (-OWN["impact.friction_margin"],), after=("friction margin",)),
    ),
    dict.fromkeys(_KINDS, "grip"),
    (friction_margin,),
)
TOLD = {tree.name: tree for tree in (FAIR, MODE)}


_FLIGHTS = {stage.name for stage in CHAIN if stage.kind == "flight"}


@dataclass(frozen=True)
class Told:
    """Reported and true facts of scenes, with the values that decide them.

    Attributes
    ----------
    ids, kinds, columns
        Ids, kinds and columns of the scenes.
    said, right
        The reported facts, and the true ones.
    plates
        True for scenes whose truth has a plate: `airborne` then means the batted ball.
    given
        Flags by symbol: True where a value is the candidate's own.
    before
        Stages that are wrong. If the outcome is wrong too, a value that depends on these stages is
        known only where it is the candidate's own.
    """

    ids: Sequence[str]
    kinds: Any
    columns: Mapping[str, Any]
    said: Sequence[object]
    right: Sequence[object]
    plates: Bools
    given: Mapping[str, Bools]
    before: Collection[str]

    def __len__(self) -> int:
        return len(self.ids)

    @cached_property
    def suspect(self) -> set[str]:
        """Stages that are wrong; all flights if one of them is, because they share the law."""
        return {*self.before} | (_FLIGHTS if _FLIGHTS & {*self.before} else set())

    @cached_property
    def wrong(self) -> Bools:
        """True where the reported fact is not the true one."""
        pairs = zip(self.said, self.right, strict=True)
        return np.array([said != right for said, right in pairs], dtype=bool)


def _held(test: Test, told: Told, without: Node | None = None) -> Array:
    """1 where a test holds, 0 where it does not, NaN where that is unknown."""
    # A three-valued "and": 0 and anything is 0; otherwise NaN and anything is NaN.
    found = np.ones(len(told))
    for condition in test.conditions:
        if condition is without:
            continue
        with np.errstate(all="ignore"):
            value = np.asarray(evaluate(condition, told.columns), float) + np.zeros(len(told))
        # A condition is unknown if a value is missing; if it is a tie; or if, in a scene with a
        # wrong outcome and after a wrong stage, it contains a value that is not the candidate's
        # own.
        unsure = np.isnan(value)
        if not told.suspect.isdisjoint(test.after):
            own = [told.given[n.data] for n in ordered([condition]) if n.data in told.given]
            unsure |= told.wrong & ~np.logical_and.reduce([unsure | True, *own])
        if condition.op != "constant":
            unsure |= np.abs(value) <= ROUNDING
        holds = np.where(unsure, np.nan, value > 0)
        found = np.where((found == 0) | (holds == 0), 0.0, found * holds)
    return np.where(np.isin(told.kinds, test.kinds), found, 0.0)


def _known(tree: Tree, told: Told) -> list[Array]:
    """For each test, 1 or 0 where the true outcome shows that it holds or not; NaN elsewhere."""
    # Tests before the one that holds are 0. The truth does not show those after it.
    met = np.zeros(len(told), dtype=bool)
    found = []
    for test in tree.tests:
        here = np.array([right == test.says for right in told.right]) & ~met
        # Two tests say "airborne": an at-bat with a plate is airborne by the second.
        if test.says == "airborne" and test.kinds == _THROWN:
            here &= ~told.plates | (told.kinds == "pitch")
        here &= np.isin(told.kinds, test.kinds)
        met = met | here
        found.append(np.where(here, 1.0, np.where(met, np.nan, 0.0)))
    return found


@dataclass
class _Search:
    """A search for edits of a tree that explain a candidate's facts."""

    tree: Tree
    told: Told
    options: list[object] = field(init=False)

    def __post_init__(self) -> None:
        said = [*self.tree.options(), *self.told.said, *self.told.right]
        self.options = list(dict.fromkeys(said))
        self.truth = _known(self.tree, self.told)
        self.values = [self.filled(i, test) for i, test in enumerate(self.tree.tests)]

    def filled(self, i: int, test: Test, edited: bool = False) -> Array:
        """Result of a test by the candidate's values; by the truth where these leave it open."""
        held, truth = _held(test, self.told), self.truth[i]
        # A test that holds in truth may fail when it is edited. One that does not hold in truth
        # also fails when edited, if values are missing: no ball gets that far.
        if edited:
            truth = np.where(truth == 1, np.nan, truth)
        if not self.told.suspect.isdisjoint(test.after):
            truth = np.where(self.told.wrong, np.nan, truth)
        return np.where(np.isnan(held), truth, held)

    def possible(self, values: Sequence[Array]) -> Bools:
        """Flags of shape (options, scenes): True where an option is possible."""
        found = np.zeros((len(self.options), len(self.told)), dtype=bool)
        waiting = np.ones(len(self.told), dtype=bool)  # no test holds for certain so far
        for test, value in zip(self.tree.tests, values, strict=True):
            found[self.options.index(test.says)] |= waiting & (value != 0)
            waiting = waiting & (value != 1)
        for kind, option in self.tree.otherwise.items():
            found[self.options.index(option)] |= waiting & (self.told.kinds == kind)
        return found

    def agrees(self, possible: Bools, said: Sequence[object] | None = None) -> Bools:
        """True where the candidate's fact is possible, or one of `said` in its place."""
        rows = [self.options.index(x) for x in said or self.told.said]
        return np.asarray(possible[rows, np.arange(len(rows))])

    def with_(self, i: int, held: Array) -> Bools:
        """Facts that are possible where a test is changed."""
        values = [*self.values]
        values[i] = held
        return self.possible(values)

    def ways(self) -> Iterator[tuple[int, Test, Edit | None, float, str]]:
        """Edited tests: index, the new test, the edit if one made it, bits, and words."""
        for i, test in enumerate(self.tree.tests):
            choice = math.log2(len(self.tree.tests))
            yield (
                i, replace(test, conditions=(constant(0.0),)), None, BITS["zero"] + choice,
                f"never says {_text(test.says)}",
            )  # fmt: skip
            for condition in test.conditions:
                left = tuple(c for c in test.conditions if c is not condition)
                said = _is_positive(condition)
                if left:
                    cost = BITS["zero"] + choice + math.log2(len(test.conditions))
                    text = f"says {_text(test.says)} whether or not {said}"
                    yield i, replace(test, conditions=left), None, cost, text
                # The operators edit stages, so the condition is wrapped in one.
                roots = {"value": condition}
                stage = Stage("", (str(test.says),), "formula", roots, scenes=test.kinds)
                usual = {**defaults(), "time_limit": 60.0}
                for edit in edits((stage,), stage, usual, self.told.columns, self.tree.pool):
                    (other,) = edit.apply((stage,))
                    new = specialised(other.roots["value"], self.told.columns, {})
                    if new is condition or new.op == "constant" or _is_coincidence(edit):
                        continue
                    conditions = tuple(new if c is condition else c for c in test.conditions)
                    text = _says_if(test, new, condition, edit)
                    yield i, replace(test, conditions=conditions), edit, edit.bits + choice, text

    def settled(self, i: int, test: Test, old: Test) -> tuple[Test, float, float, float] | None:
        """A test with the roundest free number that the outcomes allow, its cost and limits."""
        (c,) = {n for f in test.conditions for n in ordered([f]) if n.data == FREE}
        (at,) = (k for k, f in enumerate(test.conditions) if f is not old.conditions[k])
        edited = test.conditions[at]
        # The condition is linear in c, a + b c > 0: its values at c = 0 and 1 give a and b, and
        # that at 2 confirms that it is linear. Scenes in which it is not, such as min(a, c) with a
        # small a, are no bounds on c.
        points = []
        for x in (0.0, 1.0, 2.0):
            with np.errstate(all="ignore"):
                f = substitute(edited, c, constant(x, c.dimension))
                points.append(evaluate(f, self.told.columns) + np.zeros(len(self.told)))
        slopes = [b - a for a, b in pairwise(points)]
        usable = np.isfinite(points[2]) & np.isclose(slopes[0], slopes[1], rtol=1e-9, atol=0.0)
        # Is the candidate's fact possible if the test holds? And if it does not?
        can = []
        for x in (1.0, 0.0):
            values = [*self.values]
            rest = _held(test, self.told, without=edited)
            values[i] = np.where(rest == 0, 0.0, np.where(np.isnan(rest), np.nan, x))
            values[i] = np.where(usable, values[i], self.filled(i, old, edited=True))
            can.append(self.agrees(self.possible(values)))
        # A scene in which only one of the two is possible is a bound on c, from below or from
        # above.
        must = np.where(usable & (can[0] ^ can[1]), np.where(can[0], 1.0, -1.0), 0.0)
        with np.errstate(all="ignore"):
            limit, way = -points[0] / slopes[0], np.sign(slopes[0]) * must
        low = float(limit[way > 0].max(initial=-np.inf))
        high = float(limit[way < 0].min(initial=np.inf))
        if not (low < high and math.isfinite(low) and math.isfinite(high)):
            return None
        for digits in range(1, 13):
            x = float(f"{(low + high) / 2:.{digits}g}")
            if low < x < high:
                break
        conditions = tuple(substitute(f, c, constant(x, c.dimension)) for f in test.conditions)
        return replace(test, conditions=conditions), NUMBER + DIGIT * digits, low, high

    def cost(self, possible: Bools, some: Bools) -> float:
        """Cost in bits of the outcomes where several are possible."""
        return float(np.log2(np.maximum(possible.sum(0), 1))[some].sum())

    def nothing(self, wrong: int) -> float:
        """Cost in bits of a number of wrong outcomes without an explanation."""
        # log2 of the number of choices: of the wrong scenes, and of a wrong outcome in each.
        scenes = len(self.told)
        some = min(wrong, scenes // 2)  # C(n, k) falls beyond n/2, but more errors cost more
        among = math.log2(math.comb(scenes, some))
        return among + wrong * math.log2(max(len(self.options) - 1, 1))


# Factors that may explain outcomes by coincidence. An outcome shows only the side of a limit on
# which a scene lies: a limit 3 times as large may divide the scenes as well as the candidate's
# limit.
_COINCIDENCES = {FREE, *(x for x, meaning in FACTORS.items() if not meaning)}


def _is_coincidence(edit: Edit) -> bool:
    return any(n.op == "product" and n.args[0].data in _COINCIDENCES for n in ordered([edit.by]))


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _says_if(test: Test, new: Node, was: Node, edit: Edit) -> str:
    """The words for another condition in a test; a definition in it may have kept its name."""
    says = f"says {_text(test.says)}"
    if words(new) == words(was):
        return f"{says} by a test that {edit.words}"
    return f"{says} if {_is_positive(new)}, not if {_is_positive(was)}"


def _is_positive(condition: Node) -> str:
    """A condition as people write it: a > b for a - b > 0."""
    if condition in (passes, fair):
        return words(condition)
    body = condition.args[0] if condition.op == "named" else condition
    if body.op == "negative" or (body.op == "product" and body.args[0].data == -1):
        return f"{words(body.args[-1])} ≤ 0"
    if body.op == "sum" and body.args[1].op == "negative":
        return f"{words(body.args[0])} > {words(body.args[1].args[0])}"
    return f"{words(condition)} > 0"


# --- findings -------------------------------------------------------------------------------------


def outcome_findings(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    columns: Mapping[str, Any],
    named_stages: Collection[str],
) -> list[Finding]:
    """Findings about wrong outcomes and other reported facts.

    `columns` are those of all the cases, also of those whose outcome is wrong, by the chain with
    the edits found; `named_stages` are the stages that are wrong already.
    """
    scenes: list[Any] = [case.scene for case in cases]
    own, given = _own(cases, answers, columns)
    known = {
        **columns,
        **own,
        "time_limit": np.array([getattr(s, "time_limit", math.nan) for s in scenes], float),
        "landing height": np.array([_floor(scene) for scene in scenes], float),
    }
    said = [answers[case.id].outcome for case in cases]
    right = [case.expected.outcome for case in cases]
    plates = np.array([case.expected.plate is not None for case in cases])

    def told(some: Sequence[int], said: Sequence[Any], right: Sequence[Any]) -> Told:
        at = np.array(some, dtype=int)
        here = {name: column[..., at] for name, column in known.items()}
        mine = {name: mask[at] for name, mask in given.items()}
        ids = [cases[i].id for i in some]
        return Told(ids, here["kind"], here, said, right, plates[at], mine, named_stages)

    some = [i for i, outcome in enumerate(said) if outcome is not None]
    every = told(some, [said[i] for i in some], [right[i] for i in some])
    found = [*_of_tree(OUTCOMES, every)]
    agreed = [i for i, case in enumerate(cases) if said[i] in (None, case.expected.outcome)]
    false: dict[str, list[tuple[int, object, object]]] = {}
    for i in agreed:
        for name, true, obtained in untrue(cases[i].expected, answers[cases[i].id].told):
            false.setdefault(name, []).append((i, obtained, true))
    for name, facts in false.items():
        both = [(i, answers[cases[i].id].told.get(name), told_by(cases[i].expected).get(name))
                for i in agreed]  # fmt: skip
        both = [(i, obtained, true) for i, obtained, true in both if obtained is not None]
        if name in TOLD:
            one = told([i for i, _, _ in both], *zip(*((a, b) for _, a, b in both), strict=True))
            found += _of_tree(TOLD[name], one)
        else:
            found.append(_untrue(name, facts, len(both), cases))
    return [*found, *_superfluous(cases, answers, agreed)]


def _own(
    cases: Sequence[Case], answers: Mapping[str, Answer], columns: Mapping[str, Any]
) -> tuple[dict[str, Array], dict[str, Bools]]:
    """The candidate's own values, also of what the truth does not have, and where they are."""
    values, given = {}, {}
    for quantity, node in OWN.items():
        column, mask = columns[node.data].copy(), np.zeros(len(cases), dtype=bool)
        for i, case in enumerate(cases):
            if (said := answers[case.id].values.get(quantity)) is not None:
                column[..., i] = np.squeeze(np.array([float(x) for x in said]))
                mask[i] = True
        values[str(node.data)], given[str(node.data)] = column, mask
    return values, given


def _floor(scene: Any) -> float:
    ground = getattr(scene, "ground", None)
    height = 0.0 if ground is None else ground.height
    return float(height + scene.ball.radius * (scene.reading.ground_contact == "surface"))


def _of_tree(tree: Tree, told: Told) -> Iterator[Finding]:
    """Findings of a tree: facts that edits explain, that follow from wrong numbers, and others."""
    left = told.wrong
    if not left.any():
        return
    search = _Search(tree, told)
    possible = search.possible(search.values)
    # A wrong outcome follows from wrong numbers if the candidate's own values allow it and exclude
    # the right one.
    follows = left & search.agrees(possible) & ~search.agrees(possible, told.right)
    left = left & ~follows
    accounted = ~left & search.agrees(possible)  # no edit may make these wrong
    unknown = left & search.agrees(possible)  # these are possible without an edit
    while left.any():
        ways = _ways(search, left, accounted, unknown)
        if not ways:
            break
        best, *others = ways
        near = [o for o in others if o.spent < best.spent + ALIKE and (o.fixed == best.fixed).all()]
        near = [o for o in near if SWITCHED not in o.edit][:MOST] if best.changed else []
        sentence = f"{outcomes_wrong(_pairs(told, best.fixed), tree.name)}: "
        sentence += f"your program {best.edit}"
        if near:
            sentence += f". The same outcomes follow if it {' or '.join(w.edit for w in near)}"
        yield _finding(
            tree, told, best.fixed, kind="named", edit=best.edit, bits=round(best.evidence, 1),
            sentence=f"{sentence}.", remedy=best.right,
        )  # fmt: skip
        left = left & ~best.fixed
    # The reason may be an earlier stage that is wrong and whose values the candidate omits.
    if _wrong_before(tree, told, left & unknown):
        follows, left = follows | (left & unknown), left & ~unknown
    if follows.any():
        yield _following(tree, told, follows)
    if left.any():
        yield _finding(
            tree, told, left, kind="located",
            sentence=f"{outcomes_wrong(_pairs(told, left), tree.name)}.",
        )  # fmt: skip


@dataclass(frozen=True)
class _Way:
    """An edit that gives the candidate's wrong outcomes, and keeps the right ones."""

    fixed: Bools
    spent: float  # bits
    evidence: float
    edit: str
    right: str
    changed: bool  # True for an edited test, False for an omitted one


def _ways(search: _Search, left: Bools, accounted: Bools, unknown: Bools) -> list[_Way]:
    """Edits that explain a whole kind of wrong outcome, sorted by number of scenes and by cost."""
    found: dict[bytes, _Way] = {}  # the cheapest of edits that agree in moved scenes
    moved, tests = _moved(search.told), search.tree.tests
    held_there = [_held(test, moved) for test in tests]
    unchanged = _fingerprint(held_there)
    pairs = np.array([hash(pair) for pair in _pairs(search.told, left | True)])
    for i, test, edit, bits, text in search.ways():
        old, within = tests[i], ""
        if edit is not None and edit.starts:
            settled = search.settled(i, test, old)
            if settled is None:
                continue
            test, more, low, high = settled
            bits += more
            ((new, was),) = ((a, b) for a, b in zip(test.conditions, old.conditions, strict=True)
                             if a is not b)  # fmt: skip
            text = _says_if(test, new, was, edit)
            within = f" (the number lies between {low:.4g} and {high:.4g})"
        held = search.filled(i, test, edited=True)
        possible = search.with_(i, held)
        agrees = search.agrees(possible)
        if not agrees[accounted].all():
            continue
        fixed = left & agrees
        fixed &= ~np.isin(pairs, pairs[left & ~agrees])  # a kind of mistake is explained whole
        # A scene is evidence only if the edited test decides it, and no wrong stage can be the
        # cause.
        spent = bits + search.cost(possible, fixed)
        sure = fixed & ~np.isnan(held) & ~unknown
        if not search.told.suspect.isdisjoint(old.after):
            sure &= ~np.isnan(_held(old, search.told))
        evidence = search.nothing(int(sure.sum())) - spent
        if evidence < CHANCE:
            continue
        key = _fingerprint([*held_there[:i], _held(test, moved), *held_there[i + 1 :]])
        if key == unchanged:
            continue
        if key not in found or spent < found[key].spent:
            right = f"say {_text(old.says)} if {_all_positive(old)}"
            found[key] = _Way(fixed, spent, evidence, f"{text}{within}", right, edit is not None)
    return sorted(found.values(), key=lambda way: (-way.fixed.sum(), way.spent))


def _moved(told: Told) -> Told:  # a free choice
    """Scenes with all values moved at random, in which equal edits are detected."""
    draw = np.random.default_rng(0)
    moved: dict[str, Any] = {}
    count = max(4, 400 // max(len(told), 1))
    for name, column in told.columns.items():
        column = np.repeat(column, count, axis=-1)
        moved[name] = column
        if column.dtype.kind == "f":
            known = column[np.isfinite(column)]
            middle, spread = (np.median(known), known.std()) if known.size else (1.0, 1.0)
            other = np.where(np.isfinite(column), column, middle)
            if (known > 0).all():  # widely: some pitches must exceed a limit of 60 s
                moved[name] = other * np.exp(2 * draw.normal(size=column.shape))
            else:
                moved[name] = other + 2 * spread * draw.normal(size=column.shape)
    ids = [name for name in told.ids for _ in range(count)]
    kinds = np.repeat(told.kinds, count)
    return replace(told, columns=moved, kinds=kinds, ids=ids, given={}, before=())


def _fingerprint(held: Sequence[Array]) -> bytes:
    """The number of the first test that holds, of each scene, as bytes."""
    found = np.full(held[0].shape, -1, dtype=np.int8)
    for i, one in enumerate(held):
        found[(found < 0) & (one == 1)] = i
    return found.tobytes()


def _all_positive(test: Test) -> str:
    return " and ".join(map(_is_positive, test.conditions))


def _wrong_before(tree: Tree, told: Told, some: Bools) -> list[str]:
    """Wrong stages on which the outcomes of these scenes may depend."""
    says = {said for pair in _pairs(told, some) for said in pair}
    after = {stage for test in tree.tests if says & {test.says} for stage in test.after}
    depends = bool(after & told.suspect)
    return [stage for stage in told.before if depends and stage in after | _FLIGHTS]


def _following(tree: Tree, told: Told, some: Bools) -> Finding:
    """The finding that wrong outcomes follow from wrong numbers."""
    sentence, remedy = outcomes_wrong(_pairs(told, some), tree.name), None
    if before := _wrong_before(tree, told, some):
        sentence = sentence.replace(" wrong (", " wrong too (", 1)
        sentence += ", probably for the same reason"
        remedy = f"see whether this is still so when {before[0]} is right"
    else:
        says = {said for pair in _pairs(told, some) for said in pair}
        tests = [test for test in tree.tests if says & {test.says}]
        needed = {node for test in tests for node in ordered(test.conditions)}
        own = [name for name, node in OWN.items() if node in needed]
        sentence += f": this follows from your own {joined(own)}, which "
        sentence += "is wrong" if len(own) == 1 else "are wrong"
    return _finding(tree, told, some, kind="located", sentence=f"{sentence}.", remedy=remedy)


def _pairs(told: Told, some: Bools) -> list[tuple[object, object]]:
    return [
        (said, right) for said, right, here in zip(told.said, told.right, some, strict=True) if here
    ]


def _finding(tree: Tree, told: Told, some: Bools, **said: Any) -> Finding:
    return Finding(
        stage="outcome", quantity=tree.name,
        wrong=int(some.sum()), checked=len(told), worst=1.0,
        example=told.ids[int(np.flatnonzero(some)[0])], **said,
    )  # fmt: skip


def _untrue(
    name: str, facts: Sequence[tuple[int, Any, Any]], checked: int, cases: Sequence[Case]
) -> Finding:
    """The finding of a fact without a tree: a shifted number, or a wrong word."""
    sentence = outcomes_wrong([(given, true) for _, given, true in facts], name)
    edit = None
    if all(type(x) is int for _, *both in facts for x in both):
        shifts = {given - true for _, given, true in facts}
        if len(shifts) == 1 and len(facts) == checked > 2 and (shift := shifts.pop()):
            edit = f"{name} is {abs(shift)} too {'large' if shift > 0 else 'small'}"
            sentence = f"{edit} in all {many(checked, 'scene')}"
    return Finding(
        stage="outcome", quantity=name, kind="named" if edit else "located", edit=edit,
        sentence=f"{sentence}.", wrong=len(facts), checked=checked, worst=1.0,
        example=cases[facts[0][0]].id,
    )  # fmt: skip


def _superfluous(
    cases: Sequence[Case], answers: Mapping[str, Answer], agreed: Sequence[int]
) -> Iterator[Finding]:
    """Findings of blocks and quantities that do not belong to the outcome."""
    found: dict[tuple[str, str], list[str]] = {}
    for i in agreed:
        case = cases[i]
        outcome, given = str(case.expected.outcome), answers[case.id].values
        true = [n for n in QUANTITIES if _is_there(case, n)]
        for name in superfluous(outcome, true, given):
            found.setdefault((name, outcome), []).append(case.id)
    for (name, outcome), ids in found.items():
        same = sum(str(cases[i].expected.outcome) == outcome for i in agreed)
        what = name if "." in name else f"a block {name}"
        others = same - len(ids)
        belongs = f"; in {others} others with that outcome it belongs there" if others else ""
        yield Finding(
            stage="outcome", quantity=name, kind="located", wrong=len(ids), checked=same, worst=1.0,
            sentence=f"{many(len(ids), 'answer')} with the outcome {outcome} "
            f"{'has' if len(ids) == 1 else 'have'} {what}, which should be left out{belongs}.",
            example=ids[0],
        )  # fmt: skip


def _is_there(case: Case, name: str) -> bool:
    block, _, key = name.partition(".")
    return getattr(getattr(case.expected, block, None), key, None) is not None
