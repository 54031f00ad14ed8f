"""The diagnosis of programs with one mistake or two.

Formulas of an impact or a law that are wrong are in `test_planted_edits.py`.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from longball.golden import load
from longball.judge.cases import Case
from longball.judge.diagnosis import diagnose as diagnosing
from longball.judge.diagnosis.chain import CHAIN, OWN, I, lever, y
from longball.judge.diagnosis.diagnose import Step, _clearest, diagnose, reason
from longball.judge.diagnosis.expression import evaluate, ordered, substitute
from longball.judge.diagnosis.findings import Diagnosis
from longball.judge.diagnosis.operators import Edit, edits, edits_of_one_option
from longball.judge.diagnosis.residual import FINE, Stepping, follow, specialised_to, values
from longball.judge.diagnosis.search import Named, defaults
from longball.model.scene import parse_scene
from tests.judge import material
from tests.judge.material import answered, collected, known, right, truth

NIGHTLY = pytest.mark.nightly

# --- programs that read a scene otherwise: the right engine solves what they read -----------------

Read = Callable[[dict[str, Any]], object]


def diagnosed(cases: Sequence[Case], read: Read, **options: Any) -> Diagnosis:
    scenes = [json.loads(case.scene.as_written()) for case in cases]
    for scene in scenes:
        read(scene)
    answers = (answered(parse_scene(json.dumps(scene))) for scene in scenes)
    return diagnose(cases, collected(cases, answers).answers, **options)


def as_it_is(scene: dict[str, Any]) -> None:
    """Read the scene without a mistake."""


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


def own_gravity(scene: dict[str, Any]) -> None:
    scene["gravity"] = 9.81


def own_gravity_and_density(scene: dict[str, Any]) -> None:
    scene["gravity"], scene["air"]["density"] = 9.81, 1.2


def spins_in_revolutions_per_minute(scene: dict[str, Any]) -> None:
    for block in ("pitch", "launch", "incoming"):
        if spin := scene.get(block, {}).get("spin"):
            scene[block]["spin"] = [x * math.pi / 30 for x in spin]


def spins_in_whole_revolutions_per_minute(scene: dict[str, Any]) -> None:
    if spin := scene["launch"].get("spin"):
        scene["launch"]["spin"] = [round(x * 30 / math.pi) * math.pi / 30 for x in spin]


def wrong_pounds(scene: dict[str, Any]) -> None:
    for block, mass in (("ball", 0.145), ("bat", 0.9)):
        scene[block] = {"mass": mass} | scene.get(block, {})
        scene[block]["mass"] *= 0.9992


def heavier_bats_with_friction(scene: dict[str, Any]) -> None:
    """As of a program with a separate collision for bats with friction."""
    if scene.get("bat", {}).get("friction") is not None:
        scene["bat"]["mass"] = 1.1 * scene["bat"].get("mass", 0.9)


def one_law_per_revolution_a_minute(scene: dict[str, Any]) -> None:
    """As of a program that writes each law on its own: the drag crisis has the same spin."""
    drag = scene["air"]["drag_coefficient"]
    if drag["law"] == "spin":
        drag["per_spin"] *= 30 / math.pi


# Families, how a program misreads their scenes, the first wrong stage, and the edit that is named.
READ = [
    ("at-bat flight-spin-lift impact", as_it_is, None, ""),
    ("pitch", speed_in_miles_per_hour, "pitch",
     "uses 0.44704 times V_0 (miles per hour taken for m/s)"),
    ("flight-vacuum flight-both", air_where_there_is_none, "flight",
     "uses air = given in every scene"),
    ("flight-drag flight-both", down_to_the_height_of_the_launch, "landing",
     "uses launch.position_z for ground"),
    ("flight-weightless flight-both", gravity_or_default, "flight",
     "uses 9.8, its default, for g = 0"),
    ("at-bat-real", spins_in_revolutions_per_minute, "pitch",
     "uses 0.104719755 times the scene's spin (revolutions per minute taken for rad/s)"),
    ("flight-spin-lift", spins_in_whole_revolutions_per_minute, "flight",
     "rounds launch.spin to 0 decimals in revolutions per minute"),
    ("at-bat", wrong_pounds, "pitch", "uses 0.9992 times every mass of the scene"),
    ("impact impact-oblique", heavier_bats_with_friction, "restitution",
     "uses 1.1 times M where bat.friction is given"),
    pytest.param("flight-both", half_of_drag, "flight", "uses 0.5 times C_D for C_L",
                 marks=NIGHTLY),
    pytest.param("flight-spin-drag", one_law_per_revolution_a_minute, "flight",
                 "uses 9.54929659 times the spin in C_D where air.drag_coefficient is spin "
                 "(revolutions per minute)", marks=NIGHTLY),
    # Neither explains the errors alone, nor most of them.
    pytest.param("flight-both", own_gravity_and_density, "flight",
                 "uses 1.2 for ρ_0, whatever the scene says and uses 9.81 for g, whatever the "
                 "scene says", marks=NIGHTLY),
]  # fmt: skip


@pytest.mark.parametrize(("families", "read", "stage", "edit"), READ)
def test_a_scene_that_is_read_otherwise_is_named(
    families: str, read: Read, stage: str | None, edit: str
):
    cases = known(*families.split())[::3]
    found = diagnosed(cases, read)
    named = {f.edit for f in found.findings if f.stage != "outcome"}
    assert (found.first, named) == (stage, {edit} if stage else set())


def test_a_wrong_default_is_named_with_the_scenes_that_leave_the_key_out():
    def another_default(scene: dict[str, Any]) -> None:
        scene["ball"] = {"mass": 0.1417} | scene.get("ball", {})

    cases = [case for case in known("defaults") if case.scene.kind == "impact"]
    found = diagnosed([*cases, *known("impact")[::4]], another_default).findings
    assert {f.edit for f in found} == {"uses 0.1417 for m where the scene leaves it out"}


def test_a_mistake_is_reported_where_it_is_made_first():
    """The finding is at the pitch, although the batted balls are more and are searched first."""
    cases = [*known("pitch")[::9], *known("flight-both")[::3]]
    (found,) = diagnosed(cases, own_gravity).findings
    assert (found.stage, found.edit) == ("pitch", "uses 9.81 for g, whatever the scene says")
    # If answers change from run to run, the judge looks for no cause.
    found = diagnosed(cases, own_gravity, causes=False)
    assert {f.kind for f in found.findings} == {"located"}


# --- noise ----------------------------------------------------------------------------------------


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


def test_another_form_of_the_normal_is_no_mistake():
    """A ball that touches late is inside the bat; (r - axis)/(R + r_b) is then no unit vector."""
    data = truth(known("at-bat")[::9])
    chain = specialised_to(data)
    (at,) = (i for i, stage in enumerate(chain) if stage.name == "normal")

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        place = columns["contact.position"] - 0.002 * columns["n"]
        form, _ = chain[at].forms["value"]
        made = evaluate(form, {**columns, "contact.position": place})
        return {"contact.position": place, "contact.normal": made}

    data, _ = material.planted(data, chain, given)
    assert not reason(data, chain[at : at + 1]).steps


def test_a_number_that_is_reported_wrong_alone_is_wrong_once():
    """A program may compute the impulse from the velocities, not from its normal speed."""
    data = truth([case for case in known("impact") if case.scene.bat.friction is None][:40])
    chain = specialised_to(data)

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        noise = np.random.default_rng(2).uniform(0.7, 1.3, len(data.cases))
        return {"contact.normal_speed": columns[OWN["contact.normal_speed"].data] * noise}

    data, columns = material.planted(data, chain, given)
    (impulse,) = (stage for stage in chain if stage.name == "impulse")
    assert material.off(impulse, data, columns).beyond.any()
    (step,) = reason(data, chain).steps
    assert step.followed.stage.name == "normal speed"


def test_decisions_do_not_tell_which_number_of_a_condition_is_wrong():
    """Balls slide that should grip, for one of many reasons; and other impulses are wrong, too."""
    families = known("impact-oblique", "combined", "various-real", "at-bat-real")
    data = truth([x for x in families if x.expected.impact and x.expected.impact.mode])
    chain = specialised_to(data)
    (at,) = (i for i, stage in enumerate(chain) if stage.name == "impulse")
    (slide,) = (node for node in ordered(chain[at].roots.values()) if node.data == "P (slide)")
    grips = np.array([case.expected.impact.mode == "grip" for case in data.cases])

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        slides = (evaluate(slide, columns) * columns["n"]).sum(axis=0)
        slides[np.flatnonzero(grips)[:4]] *= [1.3, 0.8, 1.1, 1.7]
        return {"impact.impulse": np.where(grips, slides, columns["J"])}

    data, columns = material.planted(data, chain, given)
    wrong = material.off(chain[at], data, columns).beyond
    assert wrong.sum() > 10
    (step,) = reason(data, chain[at : at + 1]).steps
    assert not step.explained


@pytest.mark.parametrize("in_all_but_one", [True, False])
def test_an_edit_may_be_made_in_a_part_of_the_formulas(in_all_but_one: bool):
    """Such as another lever in the bat's mass, but not in the arm of friction; or the reverse."""
    data = truth([case for case in known("impact-oblique") if case.scene.kind == "impact"])
    (impulse,) = (stage for stage in specialised_to(data) if stage.name == "impulse")
    (arm,) = (node for node in ordered(impulse.roots.values()) if node.data == "r")
    other = I["L"] / 2.0 + y
    other_arm = substitute(arm, lever, other)
    everywhere, in_one = impulse.edited(lever, other), impulse.edited(arm, other_arm)
    in_others = everywhere.edited(other_arm, arm)
    believed, made = (everywhere, in_others) if in_all_but_one else (impulse, in_one)
    data, columns = material.planted(data, (impulse,), partial(values, made))
    wrong = material.off(believed, data, columns)
    assert wrong.beyond.any()
    found = Step(wrong, Named((Edit(lever, other, 1.0, ""),), 1.0))
    forms = diagnosing._edited_in_part(believed, impulse, [found])
    form = diagnosing._right_form(forms, data, columns, wrong)
    assert form is not None
    assert form.roots == made.roots


# --- edits of the chain ---------------------------------------------------------------------------


def test_an_edit_of_one_use_is_made_in_every_flight():
    """Also where the scenes of another stage have another drag coefficient."""
    data = truth([*known("pitch")[:4], *known("flight-spin-drag")[:4]])
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
    own, wrong = stage.with_spin(columns), stage
    for text in words:
        every_edit = itertools.chain(
            edits(chain, stage, defaults(), own, most=math.inf),
            edits_of_one_option(stage, defaults(), own),
        )
        edit = next(e for e in every_edit if e.words == text)
        (wrong,) = (edit.settled(1.0005, 0.0) if edit.starts else edit).apply([wrong])
    data, _ = material.planted(data, chain, lambda columns: values(wrong, columns, steps))
    found = reason(data, chain).steps
    return [e.words for step in found if isinstance(step.found, Named) for e in step.found.edits]


@pytest.mark.parametrize("everywhere", [True, False])
@np.errstate(all="ignore")  # as `diagnose`
def test_a_mistake_in_a_definition_is_named_once_where_it_is_made(everywhere: bool):
    """The other lever in every formula of the impact, or in that of the restitution alone."""
    data = truth(known("impact")[::2])
    chain = specialised_to(data)
    mistake = Edit(lever, I["L"] / 2.0 + y, 1.0, "")
    wrong = [
        edited if everywhere or stage.name == "restitution" else stage
        for stage, edited in zip(chain, mistake.apply(chain), strict=True)
    ]
    assert sum(stage is not was for stage, was in zip(wrong, chain, strict=True)) > everywhere

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        for stage in wrong:  # each from the wrong values before it
            columns |= {str(OWN[q].data): x for q, x in values(stage, columns).items()}
        return {q: columns[str(OWN[q].data)] for stage in wrong for q in stage.quantities}

    data, _ = material.planted(data, chain, given)
    reasoned = reason(data, chain)
    (step,) = reasoned.steps
    assert isinstance(step.found, Named)
    assert not any(one.beyond.any() for one in follow(reasoned.chain, data)[1])


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
    assert planted(["flight-wind"], 3, words) == [words]


def test_one_option_with_a_mistake_in_it_is_named():
    words = "uses reading.bat_ball_restitution = as_printed in every scene, and flips the sign of "
    words += "m/M_eff in e·(1 + m/M_eff) + m/M_eff"
    assert planted(["impact"], 3, words, at="restitution")[0] == words


@NIGHTLY  # by day, two mistakes in one formula are named
def test_two_mistakes_are_named_of_which_one_shows_in_a_few_scenes():
    """The profile of the wind is in three scenes of forty."""
    sign, profile = planted(["flight-wind"], 1, "flips the sign of W", "leaves out wind.velocity")
    assert sign in ("flips the sign of W", "flips the sign of W_0")
    assert profile in (
        "leaves out wind.velocity",
        "leaves out r_z",
        "leaves out the wind's profile",
    )


def test_a_law_with_a_jump_is_named_although_steps_cross_it_unawares():
    words = "applies lift only on the way up"
    assert planted(["flight-both"], 6, words, steps=Stepping(0.03, 400)) == [words]


@pytest.mark.sampled(every=3)
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


@pytest.mark.nightly
def test_a_margin_is_held_to_that_of_the_undisturbed_pitch():
    cases = known("at-bat")
    wrong = right(cases, lambda q, value: [-x for x in value] if q == "contact.margin" else value)
    (found,) = diagnose(cases, wrong).findings
    assert found.stage == "margin"
    assert found.edit == "flips the sign of R + r_b - the closest distance"


def test_a_rough_edit_may_leave_a_few_errors():
    off, some = np.zeros((1, 200)), np.arange(200)
    left = []
    for count in (0, 1, 100):
        off[:, :count] = 1e6
        one: Any = SimpleNamespace(off=off, floor=np.ones_like(off), some=some)
        left.append(diagnosing._is_left(one, some))
    assert left == [True, True, False]


@pytest.mark.parametrize(
    ("first", "second", "chosen"),
    [(4, 6, 0), (4, 9, 1), (7, 60, 0)],  # of more than ten scenes each tells as much
)
def test_a_later_flight_comes_first_if_it_tells_far_more(first: int, second: int, chosen: int):
    flights = [stage for stage in CHAIN if stage.kind == "flight"][:2]
    wrong = [
        (stage, SimpleNamespace(beyond=np.arange(100) < count))
        for stage, count in zip(flights, (first, second), strict=True)
    ]
    assert _clearest(wrong) is wrong[chosen]
