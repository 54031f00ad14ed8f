"""The diagnosis of an independent program with one mistake or two.

The program (`tests/planted/at_bat_lab.py`) is right to 1e-12; a mistake is an edit of its text.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.answers import Answer, Collector
from longball.judge.cases import Case, decidable
from longball.judge.diagnosis.diagnose import diagnose, reason
from longball.judge.diagnosis.expression import ordered
from longball.judge.diagnosis.operators import edits, edits_of_one_option
from longball.judge.diagnosis.residual import FINE, Stepping, follow, specialised_to, values
from longball.judge.diagnosis.search import Named, defaults
from longball.judge.quantities import values_of
from longball.model.scene import parse_scene
from tests.judge import material
from tests.judge.material import known, truth
from tests.planted.sources import edited_lab

NIGHTLY = pytest.mark.nightly


@pytest.fixture(scope="module")
def gold() -> list[Case]:
    """Every sixteenth golden case that the other program's model has, without time limits."""
    return [
        case
        for case in load()
        if decidable(case)
        and case.family != "hard"
        and not case.scene.reading.model_dump()
        and case.expected.outcome != "airborne"
    ][::16]


def answers(cases: Sequence[Case], *mistakes: str) -> dict[str, Answer]:
    lab: dict[str, Any] = {"__name__": "lab"}
    exec(edited_lab([MISTAKES[mistake] for mistake in mistakes]), lab)
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        result = lab["solve"](json.loads(case.scene.line()))
        collector.take_line(number, json.dumps(result).encode())
    return collector.answers


DISTANCE = 'landing["distance"] = abs(there[0] - origin)'
# What stands in the program, and what the author of the mistake has in its place.
MISTAKES = {
    "g-9.80665": ('scene.get("gravity", 9.8)', "9.80665"),
    "drag-per-component": (
        "dq -= f * uq\n                dw -= f * uw\n",
        "dq -= f / U * complex(abs(uq.real) * uq.real, abs(uq.imag) * uq.imag)\n"
        "                dw -= f / U * abs(uw) * uw\n",
    ),
    "nathan": ("bounce = e + (1 + e) * m / effective", "bounce = e + 0.0"),
    "bat-at-rest": ("closing = slip.real", "closing = local.real"),
    "over-bat-mass": ("local += impulse / m", "local += impulse / M"),
    "distance-in-feet": (DISTANCE, f"{DISTANCE} / 0.3048"),
}


def test_right_answers_have_no_finding(gold: list[Case]):
    collector = Collector([case.id for case in gold])
    for number, case in enumerate(gold, 1):
        collector.take_line(number, solve(case.scene, Ivp()).line().encode())
    found = diagnose(gold, collector.answers)
    assert (found.first, found.findings) == (None, [])


@pytest.mark.parametrize(
    ("mistake", "stage", "edit"),
    [
        ("g-9.80665", "pitch", "uses 9.80665 for g, whatever the scene says"),
        ("bat-at-rest", "normal speed", "leaves out -V_b"),
        ("over-bat-mass", "velocity after", "uses M for m"),
        pytest.param(
            "drag-per-component", "pitch", "uses each component's own size for U in k·C_D·U·v",
            marks=NIGHTLY,
        ),
    ],
)  # fmt: skip
def test_a_mistake_is_named_where_it_is_made(gold: list[Case], mistake: str, stage: str, edit: str):
    first = diagnose(gold, answers(gold, mistake)).findings[0]
    assert (first.stage, first.kind, first.edit) == (stage, "named", edit), first.sentence


@pytest.mark.nightly
def test_two_mistakes_at_different_stages_are_both_named(gold: list[Case]):
    found = diagnose(gold, answers(gold, "nathan", "distance-in-feet"))
    named = {f.stage: f.edit for f in found.findings if f.kind == "named"}
    assert named["restitution"] == "leaves out m/M_eff"
    assert "3.2808399 times" in (named["distance"] or "")


def test_no_cause_is_sought_in_answers_that_change_from_run_to_run(gold: list[Case]):
    found = diagnose(gold, answers(gold, "over-bat-mass"), causes=False)
    assert {f.kind for f in found.findings} == {"located"}


def test_noise_has_no_name():
    """Numbers that no formula makes: each off by another share of itself."""
    cases = known("impact")
    draw = np.random.default_rng(1)
    data = truth(cases)
    noise = 1 + 1e-3 * draw.normal(size=len(cases))
    given = {**data.given, "impact.energy_change": data.given["impact.energy_change"] * noise}
    reasoned = reason(replace(data, given=given), specialised_to(data))
    assert [step.followed.stage.name for step in reasoned.steps] == ["energy"]
    assert not isinstance(reasoned.steps[0].found, Named)


@pytest.mark.nightly
def test_noise_of_the_spin_alone_has_no_name_and_no_clock():
    cases = known("flight-spin-decay")[::4]
    data = truth(cases)
    noise = 1 + 1e-3 * np.random.default_rng(1).normal(size=len(cases))
    given = {**data.given, "landing.spin": data.given["landing.spin"] * noise}
    reasoned = reason(replace(data, given=given), specialised_to(data))
    assert [step.followed.stage.name for step in reasoned.steps] == ["flight"]
    assert not reasoned.steps[0].explained


@pytest.mark.nightly
def test_two_numbers_of_its_own_in_one_law_are_both_named():
    """Neither explains the errors alone, nor most of them."""

    def by_own_numbers(case: Case) -> Answer:
        air = case.scene.air.model_copy(update={"density": 1.2})
        scene = case.scene.model_copy(update={"air": air, "gravity": 9.81})
        return Answer(case.id, case.expected.outcome, values_of(solve(scene, Ivp())))

    cases = known("flight-both")[::3]
    found = diagnose(cases, {case.id: by_own_numbers(case) for case in cases}).findings
    (edit,) = (f.edit or "" for f in found if (f.stage, f.kind) == ("flight", "named"))
    assert set(edit.split(" and ")) == {
        "uses 9.81 for g, whatever the scene says",
        "uses 1.2 for ρ_0, whatever the scene says",
    }


def test_a_wrong_default_is_named_with_the_scenes_that_leave_the_key_out():
    def by_own_default(case: Case) -> Answer:
        scene, ball = case.scene, case.scene.ball
        if "mass" not in ball.model_fields_set:
            scene = scene.model_copy(update={"ball": ball.model_copy(update={"mass": 0.1417})})
        return Answer(case.id, case.expected.outcome, values_of(solve(scene, Ivp())))

    every = [*load("defaults"), *load("impact")[::4]]
    cases = [case for case in every if decidable(case) and case.scene.kind == "impact"]
    found = diagnose(cases, {case.id: by_own_default(case) for case in cases}).findings
    assert {f.edit for f in found} == {"uses 0.1417 for m where the scene leaves it out"}


@pytest.mark.nightly
def test_a_mistake_in_one_option_of_a_switch_is_named_with_it():
    """As of a program that writes each law on its own: the drag crisis has the same spin."""

    def per_rpm(case: Case) -> Answer:
        drag = case.scene.air.drag_coefficient
        if drag.law == "spin":
            law = drag.model_copy(update={"per_spin": drag.per_spin * 30 / math.pi})
            air = case.scene.air.model_copy(update={"drag_coefficient": law})
            told = solve(case.scene.model_copy(update={"air": air}), Ivp())
            return Answer(case.id, told.outcome, values_of(told))
        return Answer(case.id, None, values_of(case.expected))

    cases = known("flight-spin-drag")
    found = diagnose(cases, {case.id: per_rpm(case) for case in cases}).findings
    assert [finding.kind for finding in found] == ["named"]
    assert found[0].edit.startswith("uses 9.54929659 times ")
    assert found[0].edit.endswith("where air.drag_coefficient is spin (revolutions per minute)")


def test_an_edit_of_one_use_is_made_in_every_flight():
    """Also where the scenes of another stage have another drag coefficient."""
    cases = [c for f in ("pitch", "flight-spin-drag") for c in load(f)[:4] if decidable(c)]
    data = truth(cases)
    pitch, *_, flight = (s for s in specialised_to(data) if s.kind == "flight")
    assert pitch.roots["law"] is flight.roots["law"]
    assert any(node.op == "switch" for node in ordered([pitch.roots["law"]]))


@np.errstate(all="ignore")  # as `diagnose`
def planted(
    families: Sequence[str], every: int, *words: str, at: str = "flight", steps: Stepping = FINE
) -> list[str]:
    """Names found where a stage of some families has edits, flown in some steps."""
    cases = known(*families)[::every]
    data = truth(cases)
    chain = specialised_to(data)
    (stage,) = [stage for stage in chain if stage.name == at and stage.kind != "event"]
    columns, _ = follow(chain, data)
    own, wrong = {**columns, "spin": columns[stage.spins]}, stage
    for text in words:
        every_edit = itertools.chain(
            edits(chain, stage, defaults(), own), edits_of_one_option(stage, defaults(), own)
        )
        edit = next(e for e in every_edit if e.words == text)
        (wrong,) = (edit.settled(1.0005, 0.0) if edit.starts else edit).apply([wrong])
    data, _ = material.planted(data, chain, lambda columns: values(wrong, columns, steps))
    found = reason(data, chain).steps
    return [e.words for step in found if isinstance(step.found, Named) for e in step.found.edits]


@pytest.mark.nightly
def test_a_law_is_mended_where_other_scenes_have_a_decaying_spin():
    """Edits of the decay do not crowd out those of the law."""
    families = "flight-spin-decay", "flight-weather", "flight-real"
    first, *_ = planted(families, 6, "uses {c} times T")
    assert "1.0005 times T" in first


@pytest.mark.parametrize(
    ("family", "words"),
    [
        ("flight-spin-lift", "divides ω0 × v by the lengths of both, and not by its own"),
        ("flight-real", "uses 1 for the share of the spin that is left"),
        ("flight-real", "counts r from the launch"),
        ("flight-both", "uses each component's own size for U in k·C_D·U·v"),
        # What programs write that have neither units nor vectors.
        ("flight-both", "uses C_L for ρ_0"),
        ("flight-both", "leaves out k and U in drag"),
        ("flight-both", "uses k·C_L·U for h_x in k·C_L·U·h_x"),
        # Leads the balls far from their paths.
        ("flight-both", "uses 1 for k·C_L·U in k·C_L·U·(v · h)"),
    ],
)  # fmt: skip
@pytest.mark.sampled(every=8)
def test_what_is_planted_is_named(family: str, words: str):
    assert planted([family], 3, words) == [words]


def test_a_heading_of_each_moment_is_named():
    """It shows only in the few scenes in which a ball turns round."""
    words = "uses h of each moment, not of the launch"
    assert planted(["flight-wind"], 1, words) == [words]


def test_one_option_with_a_mistake_in_it_is_named():
    words = "uses reading.bat_ball_restitution = as_printed in every scene, and flips the sign of "
    words += "m/M_eff in e·(1 + m/M_eff) + m/M_eff"
    assert planted(["impact"], 1, words, at="restitution")[0] == words


@NIGHTLY  # by day, two mistakes in one formula are named
def test_two_mistakes_are_named_of_which_one_shows_in_a_few_scenes():
    """The profile of the wind is in three scenes of forty."""
    sign, profile = planted(["flight-wind"], 1, "flips the sign of W", "leaves out wind.velocity")
    assert sign in ("flips the sign of W", "flips the sign of W_0")
    assert profile in ("leaves out wind.velocity", "leaves out r_z")


def test_a_law_with_a_jump_is_named_although_steps_cross_it_unawares():
    words = "applies lift only on the way up"
    assert planted(["flight-both"], 3, words, steps=Stepping(0.03, 400)) == [words]


@NIGHTLY
@pytest.mark.parametrize("side", [0.0, 1.0, -1.0])
def test_ends_beside_the_ground_are_no_other_event(side: float):
    """As of single precision, on both sides or on one."""
    cases = [case for case in load("flight-both") if case.expected.outcome == "landed"]
    data = truth(cases)
    noise = 1e-6 * np.random.default_rng(1).normal(size=len(cases))
    ends = data.given["landing.position"].copy()
    ends[2] += side * np.abs(noise) if side else noise
    nothing = np.full_like(ends, np.nan)
    given = {**data.given, "landing.position": ends, "landing.velocity": nothing}
    reasoned = reason(replace(data, given=given), specialised_to(data))
    assert "landing" in [step.followed.stage.name for step in reasoned.steps]
    assert not any(isinstance(step.found, Named) for step in reasoned.steps)


def half_of_drag(scene: dict[str, Any]) -> None:
    if scene["air"] is not None:
        scene["air"]["lift_coefficient"] = 0.5 * scene["air"]["drag_coefficient"]


def air_where_there_is_none(scene: dict[str, Any]) -> None:
    if scene["air"] is None:
        del scene["air"]


def down_to_the_height_of_the_launch(scene: dict[str, Any]) -> None:
    scene["ground"] = {"height": scene["launch"]["position"][2]}


def speed_in_miles_per_hour(scene: dict[str, Any]) -> None:
    scene["pitch"]["speed"] *= 0.44704


def gravity_or_default(scene: dict[str, Any]) -> None:
    scene["gravity"] = scene["gravity"] or 9.8


def spins_in_revolutions_per_minute(scene: dict[str, Any]) -> None:
    for block in ("pitch", "launch", "incoming"):
        if spin := scene.get(block, {}).get("spin"):
            scene[block]["spin"] = [x * math.pi / 30 for x in spin]


# Programs that read a scene otherwise: the right engine solves what they read.
READ = [
    pytest.param("flight-both", half_of_drag, "flight", "uses 0.5 times C_D for C_L",
                 marks=NIGHTLY),
    ("flight-vacuum", air_where_there_is_none, "flight", "uses air = given in every scene"),
    ("flight-drag", down_to_the_height_of_the_launch, "landing",
     "uses launch.position_z for ground"),
    ("pitch", speed_in_miles_per_hour, "pitch",
     "uses 0.44704 times V_0 (miles per hour taken for m/s)"),
    ("flight-weightless", gravity_or_default, "flight", "uses 9.8, its default, for g = 0"),
    ("at-bat-real", spins_in_revolutions_per_minute, "pitch",
     "uses 0.104719755 times the scene's spin (revolutions per minute taken for rad/s)"),
]  # fmt: skip


@pytest.mark.parametrize(("family", "read", "stage", "edit"), READ)
def test_a_scene_that_is_read_otherwise_is_named(
    family: str, read: Callable[[dict[str, Any]], None], stage: str, edit: str
):
    families = {family, "flight-both"} if family.startswith("flight") else {family}
    cases = known(*families)[::3]
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        scene = json.loads(case.scene.line())
        read(scene)
        result = solve(parse_scene(json.dumps(scene)), Ivp())
        collector.take_line(number, result.line().encode())
    found = diagnose(cases, collector.answers)
    assert [(f.stage, f.edit) for f in found.findings if f.stage != "outcome"] == [(stage, edit)]


@pytest.mark.nightly
def test_a_margin_is_held_to_that_of_the_undisturbed_pitch():
    cases = known("at-bat")
    told = {c.id: dict(values_of(c.expected)) for c in cases}
    for values_told in told.values():
        if "contact.margin" in values_told:
            values_told["contact.margin"] = tuple(-x for x in values_told["contact.margin"])
    wrong = {c.id: Answer(c.id, c.expected.outcome, told[c.id]) for c in cases}
    (found,) = diagnose(cases, wrong).findings
    assert found.stage == "margin"
    assert found.edit == "flips the sign of R + r_b - the closest distance"
