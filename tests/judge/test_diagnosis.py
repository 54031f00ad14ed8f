"""What is said of planted mistakes, made by a program that knows nothing of the judge.

`tests/candidates/mistaken.py` makes them; its own flights err by 1e-9 at most.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.answers import Answer, Collector
from longball.judge.cases import Case, decidable
from longball.judge.diagnosis import FINE, diagnose
from longball.judge.findings import Diagnosis, Finding
from longball.judge.rules import rule
from longball.judge.steps import common_step
from tests.candidates.mistaken import MISTAKES, Switches, by_component_in_plane, switches
from tests.candidates.mistaken import solve as simulate


@pytest.fixture(scope="module")
def gold() -> list[Case]:
    """Return every eighth golden case of those that the other program's model has."""
    return [
        case
        for case in load()
        if decidable(case) and case.family != "hard" and not case.scene.reading.model_dump()
    ][::8]


def answers(cases: Sequence[Case], *names: str) -> dict[str, Answer]:
    return answers_by(cases, switches(*names))


def answers_by(cases: Sequence[Case], how: Switches) -> dict[str, Answer]:
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        result = simulate(json.loads(case.scene.line()), how)
        collector.take_line(number, json.dumps(result).encode())
    return collector.answers


def found(diagnosis: Diagnosis) -> list[Finding]:
    """Return the findings besides outcomes and the program's own small errors."""
    return [f for f in diagnosis.findings if f.worst > FINE and f.stage != "outcome"]


def test_the_right_answers_are_clean(gold: list[Case]):
    collector = Collector([case.id for case in gold])
    for number, case in enumerate(gold, 1):
        collector.take_line(number, solve(case.scene, Ivp()).line().encode())
    diagnosis = diagnose(gold, collector.answers)
    assert diagnosis.first is None
    assert diagnosis.findings == []
    assert diagnosis.sentence.startswith("every stage follows")


# The stage at which each is found, and what is said of it; of all mistakes in `MISTAKES` those that
# stand for a kind each. The whole table takes minutes.
EXPECTED = {
    "g-9.80665": ("pitch", "gravity=9.80665"),
    "mass-0.145": ("pitch", "ball.mass=0.145"),
    "drag-per-component": ("pitch", "drag-per-component"),
    "drag-per-component-in-plane": ("pitch", "drag-per-component-in-plane"),
    "nathan": ("restitution", "bat_ball_restitution=nathan"),
    "other-end": ("bat velocity", "contact.bat_velocity: r̃ = L/2 + y"),
    "bat-at-rest": ("normal speed", "contact.normal_speed: V_b = 0"),
    "over-bat-mass": ("velocity after", "impact.velocity: m = M"),
    "first-below-since-launch": ("landing", "first-below"),
    "distance-in-feet": ("distance", "landing.distance*3.28084"),
    "axes-exchanged": ("landing", "landing.position:(y, x, z)"),
    "distance-from-start": ("distance", "landing.distance: √(x² + y²) = the way from the launch"),
}


@pytest.mark.parametrize(("mistake", "stage", "name"), [(m, *e) for m, e in EXPECTED.items()])
def test_a_mistake_is_found_where_it_is_made(gold: list[Case], mistake: str, stage: str, name: str):
    first = next(iter(found(diagnose(gold, answers(gold, mistake)))))
    assert (first.stage, first.kind) == (stage, "named"), first.sentence
    assert name in first.names
    assert first.share > 0.999


def test_a_law_is_named_beside_errors_that_nothing_explains(gold: list[Case]):
    def drag(k, v):
        return by_component_in_plane(k * (1 + 1e-2 * math.sin(v[2])), v)

    flights = [case for case in gold if case.scene.kind == "flight"]
    first, *rest = found(diagnose(flights, answers_by(flights, Switches(drag=drag))))
    assert first.names == ["drag-per-component-in-plane"]
    assert 0.99 < first.share < 0.999
    assert [(f.kind, f.names) for f in rest] == [("unexplained", [])]


def test_two_mistakes_at_different_stages_are_both_found(gold: list[Case]):
    diagnosis = diagnose(gold, answers(gold, "density-1.2", "thin-rod", "distance-in-feet"))
    assert {f.names[0] for f in found(diagnosis)} == {
        "air.density=1.2", "inertia=thin_rod", "landing.distance*3.28084",
    }  # fmt: skip


def test_a_mistake_in_some_scenes_comes_with_the_rule_that_tells_them(gold: list[Case]):
    (first, *_) = found(diagnose(gold, answers(gold, "ground-at-0")))
    assert first.stage == "landing"
    assert "ground.height" in first.sentence


def test_the_distance_alone_is_enough_to_find_the_density(gold: list[Case]):
    whole = answers([case for case in gold if case.scene.kind == "flight"], "density-1.205")
    only = {
        i: Answer(i, None, {n: v for n, v in a.values.items() if n == "landing.distance"})
        for i, a in whole.items()
    }
    (first, *_) = found(diagnose(gold, only))
    assert first.names[0] == "air.density=1.205"


def test_what_nothing_explains_is_never_called_nothing(gold: list[Case]):
    whole = answers(gold)
    bent = {
        i: Answer(i, a.outcome, a.values | (
            {"landing.position": tuple(x * (1 + len(i) % 7 * type(x)("1e-5")) for x in p)}
            if (p := a.values.get("landing.position")) else {}))
        for i, a in whole.items()
    }  # fmt: skip
    diagnosis = diagnose(gold, bent)
    assert diagnosis.findings
    assert "noise" not in diagnosis.sentence


def test_axes_exchanged_in_all_vectors_are_one_mistake(gold: list[Case]):
    turned = {
        i: replace(a, values={n: (v[0], v[2], v[1]) if len(v) == 3 else v
                              for n, v in a.values.items()})
        for i, a in answers(gold).items()
    }  # fmt: skip
    (first, *rest) = found(diagnose(gold, turned))
    assert first.names == ["axes:(x, z, y)"]
    assert rest == []


def test_no_cause_is_sought_in_answers_that_change_from_run_to_run(gold: list[Case]):
    findings = found(diagnose(gold, answers(gold, "g-9.80665"), causes=False))
    assert {f.kind for f in findings} == {"unexplained"}


def test_a_rule_is_told_only_if_chance_would_hardly_make_one(gold: list[Case]):
    flights = [case for case in gold if case.scene.kind == "flight"]
    others = [case for case in gold if case.scene.kind != "flight"]
    assert "kind = flight" in (rule(flights, others) or "")
    assert rule(flights[:1], others) is None


def test_there_are_eighty_mistakes_to_plant():
    assert len(MISTAKES) >= 80


def test_a_common_step():
    assert common_step([0.23, 0.31, 0.35, 0.4, 0.47, 0.51]) == pytest.approx(0.01)
    assert common_step([0.23, 0.31, 0.35, 0.4, 0.47, 0.5123456]) is None
    assert common_step([0.23, 0.31]) is None
