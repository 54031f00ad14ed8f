"""Outcomes as predicates: right ones follow from true values, and mistakes planted are named."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from longball import golden
from longball.judge.answers import Answer
from longball.judge.cases import decidable
from longball.judge.diagnosis.findings import Finding
from longball.judge.diagnosis.outcomes import outcome_findings
from longball.judge.diagnosis.residual import data_of, follow, specialised_to
from longball.judge.quantities import told_by, values_of

BATS = ("impact", "at-bat")
ENDS = (*BATS, "hard", "at-bat-real")  # in which more balls are met beyond the end of the bat
FENCES = ("fence", "combined")

FLIGHTS: dict[Any, Any] = {}  # which most tests have in common

Said = Callable[[Any], Any]


@cache
def cases_of(families: tuple[str, ...]) -> list[Any]:
    every = [c for family in families for c in golden.load(family) if decidable(c)]
    return [c for c in every if not c.id.startswith("fence-step-")]


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


def test_an_outcome_that_is_never_said():
    found = one(findings(ENDS, lambda c: batted(c) if c.expected.outcome == "separating" else None))
    assert (found.kind, found.edit) == ("named", "never says separating")
    assert found.remedy == "say separating if Ṽ·n > 0"
    separating = [c for c in cases_of(ENDS) if c.expected.outcome == "separating"]
    assert found.wrong == len(separating) > 30


def test_the_length_of_the_bat_for_its_half():
    found = one(
        findings(
            ENDS,
            lambda c: (
                batted(c)
                if c.expected.outcome == "beyond_bat" and abs(side(c)) < c.scene.bat.length
                else None
            ),
        )
    )
    assert found.edit is not None
    assert found.edit.startswith("says beyond_bat if |contact.position_y| > L, not if")
    assert found.remedy == "say beyond_bat if |contact.position_y| > L/2"


def test_one_end_of_the_bat_alone():
    found = one(
        findings(
            ENDS,
            lambda c: batted(c) if c.expected.outcome == "beyond_bat" and side(c) < 0 else None,
        )
    )
    assert found.edit is not None
    assert found.edit.startswith("says beyond_bat if contact.position_y > L/2, not if |")


def test_a_limit_of_the_candidates_own_lies_between_its_values():
    late = 5.0

    def flown(case: Any) -> float:
        return float(case.expected.landing.hang_time)

    found = one(
        findings(
            ("flight-both", "flight-drag"),
            lambda c: "airborne" if c.expected.outcome == "landed" and flown(c) > late else None,
        )
    )
    assert found.edit is not None
    assert found.edit.startswith("says airborne if the time of flight > 5, not if")
    low, high = found.edit.rpartition("between ")[2].rstrip(")").split(" and ")
    assert float(low) <= late <= float(high)


def test_a_condition_that_is_dropped():
    fouls = [c for c in cases_of(FENCES) if c.expected.fence and c.expected.outcome == "landed"]
    found = one(findings(FENCES, lambda c: "home_run" if c in fouls else None))
    assert found.edit == "says home_run whether or not the ball is fair"
    assert found.wrong == len(fouls) > 0


def test_what_is_in_front_of_the_plate_taken_for_fair():
    def fair(case: Any) -> dict[str, bool]:
        where = case.expected.fence or case.expected.landing
        if where is None or "landing.fair" not in told_by(case.expected):
            return {}
        return {"landing.fair": float(where.position[0]) > 0}

    found = one(findings(FENCES, told=fair))
    assert found.quantity == "landing.fair"
    assert found.edit == "says true if place_x > 0, not if place_x > |place_y|"


def test_a_ball_that_always_grips():
    found = one(
        findings(
            ("impact-oblique",),
            told=lambda c: (
                {"impact.mode": "grip"} if told_by(c.expected).get("impact.mode") == "slide" else {}
            ),
        )
    )
    assert found.edit == "never says slide"


def test_segments_counted_from_1():
    def shifted(case: Any) -> dict[str, Any]:
        segment = told_by(case.expected).get("fence.segment")
        return {} if segment is None else {"fence.segment": segment + 1}

    assert one(findings(FENCES, told=shifted)).edit == "fence.segment is 1 too large"


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
    reason = "probably for the same reason" if named else "your own contact.margin"
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
