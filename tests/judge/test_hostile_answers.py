"""Whatever a candidate answers, it gets a verdict, which does not hang on the search for causes."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import longball as lb
from longball import golden
from longball.golden import reader
from longball.judge import evaluation
from longball.judge.answers import Collector, line_of
from longball.judge.cases import Exact
from longball.judge.diagnosis.diagnose import diagnose
from longball.judge.diagnosis.findings import Diagnosis
from longball.judge.evaluation import DEFECT, Judge, usable
from longball.judge.quantities import QUANTITIES
from longball.judge.verdict import Verdict
from longball.model.scene import Scene
from tests.judge.material import answered

FAMILIES = ("impact-oblique", "flight-vacuum", "at-bat-real")
FEW = 3  # cases of each, so that a search for causes takes a second or two

Edit = Callable[[dict[str, Any], int], None]  # changes an answer, the number of its scene given
Candidate = Callable[[Scene], dict[str, Any]]


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """Return a golden set of few cases of two families."""
    folder = tmp_path_factory.mktemp("golden")
    shutil.copy(reader.DATA / "header.json", folder)
    for name in FAMILIES:
        file = reader.header().families[name].file
        lines = (reader.DATA / file).read_bytes().splitlines(keepends=True)
        (folder / file).write_bytes(b"".join(lines[:: len(lines) // FEW]))
    return folder


def candidate(cases: list[golden.Case], edit: Edit) -> Candidate:
    """Return a program that knows the truth, but for what `edit` makes of it."""
    answers = {case.id: answered(case.scene) for case in cases}
    for i, answer in enumerate(answers.values()):
        edit(answer, i)
    return lambda scene: answers[scene.id]


def changed(answer: dict[str, Any], some: set[str], change: Callable[[float], Any]) -> None:
    """Change the numbers of some quantities, or of all if none is named."""
    for block, held in answer.items():
        for key in held if isinstance(held, dict) else ():
            if some and f"{block}.{key}" not in some:
                continue
            if isinstance(held[key], list):
                held[key] = [*map(change, held[key])]
            elif isinstance(held[key], float):
                held[key] = change(held[key])


EXTREME = [0.0, 1e300, -1e300, 1e-300, 5e-324, 1.0, -1.0, 1e155, 1e99, 1e17]
NO_NUMBERS = [math.nan, math.inf, 10**400, 10**5000, None, True, "1", [1.0], {"value": "1e300"}]


@st.composite
def edits(draw: st.DrawFn) -> Edit:
    """Draw what replaces, scales, turns or swaps numbers, in some quantities of some scenes."""
    some = draw(st.just(set()) | st.sets(st.sampled_from([*QUANTITIES]), min_size=1, max_size=4))
    every, first = draw(st.sampled_from([(1, 0), (1, 0), (2, 1), (3, 0), (100, 0)]))
    value = draw(st.sampled_from(EXTREME + NO_NUMBERS) | st.floats() | st.integers())
    factor = draw(st.sampled_from([-1.0, 0.5, 3.28, 1e150, 1e-150]) | st.floats(-10, 10))
    change = draw(st.sampled_from([lambda x: value, lambda x: x * factor, lambda x: x + factor]))
    outcome = draw(st.sampled_from([None, None, None, "missed", "airborne", "batted", "nonsense"]))
    swapped = draw(st.booleans())

    def edit(answer: dict[str, Any], number: int) -> None:
        if number % every != first:
            return
        changed(answer, some, change)
        if outcome is not None:
            answer["outcome"] = outcome
        if swapped and "landing" in answer and "plate" in answer:
            answer["landing"], answer["plate"] = answer["plate"], answer["landing"]

    return edit


def constant(value: Any) -> Edit:
    return lambda answer, number: changed(answer, set(), lambda x: value)


def without_causes(verdict: Verdict) -> dict[str, Any]:
    plain = json.loads(verdict.line(), parse_constant=pytest.fail)
    return {key: x for key, x in plain.items() if key not in ("diagnosis", "seconds", "date")}


def given_verdict(folder: Path, family: str, edit: Edit) -> Verdict:
    """The verdict on a candidate, without a warning, too: they are errors in tests."""
    cases = golden.load(family, folder)
    program = candidate(cases, edit)
    verdict = lb.judge.judge(program, family, folder=folder)
    assert DEFECT not in verdict.line()
    assert str(verdict).startswith(verdict.status)
    # The search for causes changes nothing of it.
    truth = f"golden data, {family}"
    alone = Judge(cases, Exact(), truth, diagnose=False).evaluate_function(program).verdict
    assert without_causes(verdict) == without_causes(alone)
    return verdict


# Zeros take the diagnosis longest: ten seconds here, half a minute for an impact.
@pytest.mark.parametrize(
    ("family", "value"),
    [
        pytest.param("at-bat-real", 0.0, marks=pytest.mark.nightly),
        ("at-bat-real", 1e300),
        ("impact-oblique", math.nan),
    ],
)
def test_a_candidate_that_says_one_number_gets_a_verdict(
    folder: Path, family: str, value: float
) -> None:
    verdict = given_verdict(folder, family, constant(value))
    assert verdict.status == "FAILED"
    assert verdict.right < verdict.judged


@pytest.mark.nightly
@settings(max_examples=5, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(FAMILIES), edits())
def test_every_candidate_gets_a_verdict(folder: Path, family: str, edit: Edit) -> None:
    assert given_verdict(folder, family, edit)


@pytest.mark.parametrize("part", ["diagnose", "of the causes"])
def test_a_search_that_breaks_off_is_told_and_costs_no_verdict(
    folder: Path, monkeypatch, part: str
) -> None:
    whole = evaluation.diagnose

    def broken(*arguments: object, causes: bool, **options: object) -> Diagnosis:
        if causes or part == "diagnose":
            raise ZeroDivisionError("division by zero")
        return whole(*arguments, causes=causes, **options)

    monkeypatch.setattr(evaluation, "diagnose", broken)
    cases = golden.load(FAMILIES[0], folder)
    verdict = lb.judge.judge(candidate(cases, constant(0.0)), FAMILIES[0], folder=folder)
    assert verdict.status == "FAILED"
    assert f"{DEFECT}: ZeroDivisionError: division by zero" in str(verdict)
    # The wrong steps are known without their causes.
    assert bool(verdict.diagnosis.stages) == (part == "of the causes")


def test_numbers_beyond_use_are_unreadable_to_the_diagnosis_alone() -> None:
    collector = Collector(["a"])
    points = [[0.0, 0.0, 0.0, 1.0], [1.0, 1e200, 0.0, 0.0]]
    data = {"landing": {"time": 1e99, "velocity": [0, -1e101, 0]}, "path": points}
    collector.take_line(1, line_of("a", data))
    given_ = collector.answers["a"]
    assert {*usable(given_).values} == {"landing.time"}
    assert usable(given_).unreadable == {"landing.velocity", "path.position"}
    assert usable(given_).path is None
    assert {*given_.values} == {"landing.time", "landing.velocity"}


@pytest.mark.nightly
def test_a_contact_at_the_end_that_the_bat_turns_about_is_no_reason_to_break_off(
    folder: Path,
) -> None:
    """The bat's effective mass is infinite there."""
    (case, *_) = [c for c in golden.load("at-bat-real", folder) if c.expected.impact]
    data = answered(case.scene)
    data["contact"]["position"][1] = case.scene.bat.length / 2
    collector = Collector([case.id])
    collector.take_line(1, line_of(case.id, data))
    assert diagnose([case], collector.answers).first is not None
