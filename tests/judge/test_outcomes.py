"""Outcomes as predicates: right ones follow from true values, and mistakes planted are named."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from longball.judge.answers import Answer
from longball.judge.diagnosis import outcomes
from longball.judge.diagnosis.expression import symbol
from longball.judge.diagnosis.findings import Finding
from longball.judge.diagnosis.outcomes import Told, Tree, _is_positive, _Search, outcome_findings
from longball.judge.diagnosis.residual import data_of, follow, specialised_to
from longball.judge.quantities import told_by, values_of
from tests.judge.material import known

BATS = ("impact", "at-bat")
ENDS = (*BATS, "hard", "at-bat-real")  # in which more balls are met beyond the end of the bat
FENCES = ("fence", "combined")
MET = ("struck", "batted", "separating")  # by the bat, and not beyond it

FLIGHTS: dict[Any, Any] = {}  # which most tests have in common

Said = Callable[[Any], Any]


@cache
def cases_of(families: tuple[str, ...]) -> list[Any]:
    return [case for case in known(*families) if not case.id.startswith("fence-step-")]


def findings(
    families: tuple[str, ...],
    outcome: Said = lambda case: None,
    told: Said = lambda case: {},
    values: Said = lambda case: {},
    named: Sequence[str] = (),
) -> list[Finding]:
    """The findings in true answers with another outcome, other values or none, and others told."""
    cases = cases_of(families)
    answers = {
        c.id: Answer(
            c.id,
            outcome(c) or c.expected.outcome,
            {} if values(c) is None else values_of(c.expected) | values(c),
            told=told_by(c.expected) | told(c),
        )
        for c in cases
    }
    data = replace(data_of(cases, answers), flights=FLIGHTS)
    columns, _ = follow(specialised_to(data), data)
    return outcome_findings(cases, answers, columns, named)


def one(found: list[Finding]) -> Finding:
    assert len(found) == 1, [f.sentence for f in found]
    return found[0]


def side(case: Any) -> float:
    """Position of the contact along the bat, m."""
    if case.scene.kind == "impact":
        return float(case.scene.incoming.position[1])
    return float(case.expected.contact.position[1])


def batted(case: Any) -> str:
    return "struck" if case.scene.kind == "impact" else "batted"


def test_true_outcomes_follow_from_true_values():
    more = (*FENCES, "pitch", "flight-both", "impact-oblique")
    assert findings((*ENDS, *more, "edges")) == []


def instead(outcome: Said, of: str, where: Said = lambda case: True) -> dict[str, Said]:
    """Another outcome in place of one, in some scenes."""
    return {"outcome": lambda c: outcome(c) if c.expected.outcome == of and where(c) else None}


def hang_time(case: Any) -> float:
    return float(case.expected.landing.hang_time)


def in_front_of_the_plate(case: Any) -> dict[str, bool]:
    where = case.expected.fence or case.expected.landing
    told = "landing.fair" in told_by(case.expected)
    return {"landing.fair": float(where.position[0]) > 0} if told else {}


def always_grips(case: Any) -> dict[str, str]:
    slides = told_by(case.expected).get("impact.mode") == "slide"
    return {"impact.mode": "grip"} if slides else {}


def counted_from_1(case: Any) -> dict[str, Any]:
    segment = told_by(case.expected).get("fence.segment")
    return {} if segment is None else {"fence.segment": segment + 1}


# Families, the program's wrong facts, the beginning of the edit that is named, and the remedy.
NAMED = {
    "an outcome is never said": (
        ENDS, instead(batted, "separating"), "never says separating", "say separating if Ṽ·n > 0"),
    "L for L/2": (
        ENDS, instead(batted, "beyond_bat", lambda c: abs(side(c)) < c.scene.bat.length),
        "says beyond_bat if |contact.position_y| > L, not if",
        "say beyond_bat if |contact.position_y| > L/2"),
    "one end of the bat": (
        ENDS, instead(batted, "beyond_bat", lambda c: side(c) < 0),
        "says beyond_bat if contact.position_y > L/2, not if |", ""),
    "a quarter of the bat": (
        ENDS, {"outcome": lambda c: "beyond_bat" if c.expected.outcome in MET
               and abs(side(c)) > c.scene.bat.length / 4 else None},
        "says beyond_bat by a test that uses L/2 for L", ""),
    "a condition is dropped": (
        FENCES, instead(lambda c: "home_run", "landed", lambda c: c.expected.fence),
        "says home_run whether or not the ball is fair", ""),
    "every ball that lands in front of the plate is fair": (
        FENCES, {"told": in_front_of_the_plate},
        "says true if place_x > 0, not if place_x > |place_y|", ""),
    "a ball always grips": (("impact-oblique",), {"told": always_grips}, "never says slide", ""),
    "segments from 1": (FENCES, {"told": counted_from_1}, "fence.segment is 1 too large", ""),
}  # fmt: skip


@pytest.mark.parametrize("mistake", NAMED)
def test_a_wrong_condition_is_named(mistake: str):
    families, said, edit, remedy = NAMED[mistake]
    found = one(findings(families, **said))
    assert found.kind == "named"
    assert str(found.edit).startswith(edit)
    assert str(found.remedy).startswith(remedy)
    true = {c.id: (c.expected.outcome, told_by(c.expected)) for c in cases_of(families)}
    other, told = said.get("outcome", lambda c: None), said.get("told", lambda c: {})
    changed = [
        c for c in cases_of(families)
        if (other(c) or true[c.id][0], true[c.id][1] | told(c)) != true[c.id]
    ]  # fmt: skip
    assert found.wrong == len(changed) > 0
    assert found.worst == 1.0


def test_a_limit_of_the_candidates_own_lies_between_its_values():
    late = 5.0
    said = instead(lambda c: "airborne", "landed", lambda c: hang_time(c) > late)
    found = one(findings(("flight-both", "flight-drag"), **said))
    assert found.edit is not None
    assert found.edit.startswith("says airborne if the time of flight > 5, not if")
    low, high = found.edit.rpartition("between ")[2].rstrip(")").split(" and ")
    assert float(low) <= late <= float(high)


@pytest.mark.parametrize("named", [(), ("touching",)])
def test_an_outcome_that_is_right_by_a_wrong_value_of_its_own_is_no_mistake_of_its_own(named):
    missed = [c for c in cases_of(BATS) if c.expected.outcome == "missed"]
    found = one(
        findings(
            BATS,
            lambda c: "batted" if c in missed else None,
            values=lambda c: {"contact.margin": (0.01,)} if c in missed else {},
            named=named,
        )
    )
    assert (found.kind, found.edit, found.wrong) == ("located", None, len(missed))
    reason = "for the same reason" if named else "your own contact.margin, which is wrong"
    assert reason in found.sentence


def test_outcomes_wrong_at_random_are_located():
    wrong = [c for c in cases_of(BATS) if c.expected.outcome in ("separating", "missed")][::2]
    found = one(findings(BATS, lambda c: batted(c) if c in wrong else None))
    assert (found.kind, found.edit, found.wrong) == ("located", None, len(wrong))


def test_a_block_that_the_outcome_does_not_have():
    batted_ball = next(c for c in cases_of(("at-bat",)) if c.expected.outcome == "batted")
    landing = {q: x for q, x in values_of(batted_ball.expected).items() if q.startswith("landing.")}
    found = one(
        findings(("at-bat",), values=lambda c: landing if c.expected.outcome == "missed" else {})
    )
    assert found.quantity == "landing"
    assert "with the outcome missed have a block landing" in found.sentence


@pytest.mark.parametrize(("named", "kind"), [((), "named"), (("pitch",), "located")])
def test_where_the_pitch_is_wrong_the_true_place_of_the_ball_decides_nothing(named, kind):
    low = [
        c
        for c in cases_of(("at-bat",))
        if c.expected.plate and float(c.expected.plate.position[2]) < 0.9
    ]
    found = one(
        findings(
            ("at-bat",),
            lambda c: "grounded" if c in low else None,
            values=lambda c: None if c in low else {},
            named=named,
        )
    )
    assert (found.kind, found.wrong) == (kind, len(low))
    assert kind == "named" or found.remedy == "see whether this is still so when pitch is right"


def test_conditions_in_words():
    x, y = symbol("x"), symbol("y")
    assert [_is_positive(node) for node in (x, x - y, -x, -1.0 * x, 2.0 * x)] == [
        "x > 0", "x > y", "x ≤ 0", "x ≤ 0", "2·x > 0"
    ]  # fmt: skip


def test_possible_outcomes_are_those_of_all_unknown_values():
    """A value is unknown if it is missing, on the limit, or a wrong stage's and not one's own.

    A test that this leaves open has the result that the true outcome shows, but not after a wrong
    stage where the outcome is wrong, too.
    """
    numbers = (1.0, -1.0, 0.0, math.nan)
    scenes = [*itertools.product(numbers, numbers, numbers, "ABC", "AC", (True, False))]
    *values, right, said, own = map(np.array, zip(*scenes, strict=True))
    a, b, c = (symbol(name) for name in "abc")
    tests = outcomes.Test("A", (a,), after=("flight",)), outcomes.Test("B", (b, c))
    tree = Tree("outcome", tests, {"pitch": "C"})
    told = Told(
        [str(i) for i in range(len(scenes))], np.full(len(scenes), "pitch"),
        dict(zip("abc", values, strict=True)), [*said], [*right], np.zeros(len(scenes), bool),
        {"a": own}, ("fence",),
    )  # fmt: skip
    search = _Search(tree, told)
    possible = search.possible(search.values)

    def results(told: Sequence[float], truth: str) -> set[bool]:
        if any(value < 0 for value in told):
            return {False}
        sure = all(value > 0 for value in told)
        return {True} if sure else {"1": {True}, "0": {False}}.get(truth, {True, False})

    for i, (x, y, z, truth, told_, given) in enumerate(scenes):
        # The true outcome shows the tests up to the one that holds.
        first, second = {"A": "1?", "B": "01", "C": "00"}[truth]
        if told_ != truth:  # all flights share one law, and that to the fence is wrong
            x, first = x if given else math.nan, "?"
        expected = {
            "A" if one else "B" if two else "C"
            for one in results([x], first) for two in results([y, z], second)
        }  # fmt: skip
        assert {*np.array(search.options)[possible[:, i]]} == expected, scenes[i]


def test_the_bits_of_wrong_outcomes():
    """Which of the scenes are wrong, and which wrong outcome each has."""
    search: Any = SimpleNamespace(told=range(10), options="abcde")
    assert _Search.nothing(search, 3) == pytest.approx(math.log2(120) + 3 * 2)
    assert _Search.nothing(search, 9) == pytest.approx(math.log2(252) + 9 * 2)
    possible = np.array([[1, 0, 1], [1, 0, 1], [1, 0, 0], [1, 0, 0]], dtype=bool)
    assert _Search.cost(search, possible, np.array([True, True, False])) == 2.0
    assert _Search.cost(search, possible, np.array([False, True, True])) == 1.0
