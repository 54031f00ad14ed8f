"""What is said of numbers that differ a little, or in some scenes only, and of signs."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from longball.engines.chain import MODEL, Model, solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.cases import Case, decidable, solved
from longball.judge.diagnosis import _not_alone, diagnose
from longball.judge.explanations import Explanation
from longball.judge.findings import Finding, found
from longball.judge.misreadings import with_density
from longball.judge.rules import features, rule, shrunk
from longball.judge.stages import with_values
from longball.judge.steps import LIKE, _by_order, _Way
from longball.model.air import Air, Weather
from longball.model.atmosphere import density
from longball.model.force import Lift, Piecewise
from longball.model.numbers import DOUBLES
from longball.model.readings import Reading
from tests.judge.material import at_bats, collected, flights, impacts, pitches

Alter = Callable[[Any], Any]


def findings(cases: Sequence[Case], alter: Alter, model: Model = MODEL) -> list[Finding]:
    """Return what is found, besides outcomes, in the right answers to altered scenes."""
    results = [solve(alter(case.scene), Ivp(), model) for case in cases]
    told = diagnose(cases, collected(cases, results).answers).findings
    return [f for f in told if f.stage != "outcome"]


def flown() -> list[Case]:
    return list(solved([*pitches(), *at_bats(6), *flights()[:5]], Ivp()))


def gold(*families: str, every: int = 1) -> list[Case]:
    cases = load() if not families else [case for name in families for case in load(name)]
    return [case for case in cases if decidable(case)][::every]


# --- numbers that differ a little -----------------------------------------------------------------


@pytest.mark.parametrize(("factor", "meant"), [(1 + 3e-9, ""), (355 / 113 / math.pi, "355/113")])
def test_a_factor_of_k_is_no_other_radius(factor: float, meant: str):
    only, *others = findings(
        flown(), lambda s: with_values(s, {"air.density": s.air.density * factor})
    )
    assert not others
    assert only.names[0].startswith("air.density*")
    assert not any("radius" in name or "mass" in name for name in only.names)
    assert "k = ρ A/(2 m)" in only.sentence
    assert meant in only.sentence


def test_a_factor_of_the_weathers_density_is_no_factor_of_k():
    """In scenes whose density is a number the flights are right."""

    def denser(scene: Any) -> Any:
        weather = isinstance(scene.air.density, Weather)
        return with_density(scene, 1.00008 * density(scene, DOUBLES)) if weather else scene

    only, *others = findings(gold("flight-weather", "flight-wind", every=3), denser)
    assert not others
    assert "the density that the weather gives" in only.sentence
    assert only.share > 0.999


def test_a_mass_of_few_digits_is_told_before_a_factor_of_k():
    scenes = [with_values(s, {"air.density": 1.1 + 0.03 * i}) for i, s in enumerate(flights()[:6])]
    (only,) = findings(solved(scenes, Ivp()), lambda s: with_values(s, {"ball.mass": 0.142}))
    assert only.names[0] == "ball.mass=0.142"


@pytest.mark.parametrize("place", ["gravity", "launch.velocity", "k"])
def test_what_is_held_in_single_precision_is_named(place: str):
    def alter(scene: Any) -> Any:
        if place == "gravity":
            return with_values(scene, {place: float(np.float32(scene.gravity))})
        if place == "k":
            k = scene.air.density * math.pi * scene.ball.radius**2 / (2 * scene.ball.mass)
            dense = scene.air.density * float(np.float32(k)) / k
            return with_values(scene, {"air.density": dense})
        velocity = tuple(float(np.float32(x)) for x in scene.launch.velocity)
        return with_values(scene, {place: velocity})

    scenes = [
        with_values(s, {"ball.mass": 0.14 + 0.003 * i, "gravity": 9.7 + 0.03 * i})
        for i, s in enumerate(flights()[:6])
    ]
    (only,) = findings(solved(scenes, Ivp()), alter)
    assert only.names[0] == f"single:{place}"


def test_an_impulse_that_is_slightly_too_large_is_told_with_its_ratio():
    cases = solved(impacts(), Ivp())

    def too_large(case: Case) -> dict[str, Any]:
        right = json.loads(solve(case.scene, Ivp()).line())
        impact, normal = right["impact"], right["contact"]["normal"]
        more = 1e-9 * impact["impulse"]
        impact["impulse"] += more
        impact["velocity"] = [
            v + more / case.scene.ball.mass * n
            for v, n in zip(impact["velocity"], normal, strict=True)
        ]
        return {"id": case.id, **right}

    collector = collected(cases, [])
    for number, case in enumerate(cases, 1):
        collector.take_line(number, json.dumps(too_large(case)).encode())
    impulse = next(f for f in diagnose(cases, collector.answers).findings if f.stage == "impulse")
    assert impulse.names[0] == "impact.impulse*1.000000001"
    assert "(1 + 1e-09) × expected" in impulse.sentence


def rk4_with_speed_of_start(scene: Any, dt: float) -> dict[str, Any]:
    """Return the landing of a flight whose steps keep the speed of their start in drag and lift."""
    k = scene.air.density * math.pi * scene.ball.radius**2 / (2 * scene.ball.mass)
    x, v = np.array(scene.launch.position), np.array(scene.launch.velocity)
    axis = np.array([v[1], -v[0], 0.0]) / math.hypot(v[0], v[1])

    def force(u: Any, speed: float) -> Any:
        drag, lift = scene.air.drag_coefficient, scene.air.lift_coefficient
        away = k * speed * (lift * np.cross(axis, u) - drag * u)
        return away - np.array([0.0, 0.0, scene.gravity])

    def step(x: Any, v: Any, h: float) -> tuple[Any, Any]:
        speed = np.linalg.norm(v)
        a = force(v, speed)
        b = force(v + h / 2 * a, speed)
        c = force(v + h / 2 * b, speed)
        d = force(v + h * c, speed)
        return x + h * v + h * h / 6 * (a + b + c), v + h / 6 * (a + 2 * b + 2 * c + d)

    time = 0.0
    while (new := step(x, v, dt))[0][2] > scene.ground.height:
        x, v, time = *new, time + dt
    low, high = 0.0, dt
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if step(x, v, middle)[0][2] > 0 else (low, middle)
    x, v = step(x, v, low)
    landing = {"time": time + low, "hang_time": time + low, "distance": math.hypot(*x[:2])}
    return {"outcome": "landed", "landing": {
        **landing, "position": [x[0], x[1], 0.0], "velocity": list(v)}}  # fmt: skip


@pytest.mark.parametrize("order", [None, 1, 2])
def test_a_scheme_is_of_the_order_that_was_measured(order: int | None):
    cases = solved(flights()[:6], Ivp())
    collector = collected(cases, [])
    for number, case in enumerate(cases, 1):
        line = {"id": case.id, **rk4_with_speed_of_start(case.scene, 0.01)}
        collector.take_line(number, json.dumps(line).encode())
    first, *_ = diagnose(cases, collector.answers, dt=0.01, order=order).findings
    if order == 2:
        assert "converge with order 2" in first.sentence
        assert not first.names
    else:
        assert first.names == ["rk4-speed-of-start"]


# --- numbers and signs in some scenes -------------------------------------------------------------


def test_a_number_in_place_of_the_usual_one_is_one_finding_for_pitch_and_flight():
    scenes = [
        with_values(s, {"gravity": 9.8 if i % 3 else 3.7})
        for i, s in enumerate((*pitches(), *at_bats(6), *flights()))
    ]

    def alter(scene: Any) -> Any:
        return with_values(scene, {"gravity": 9.80665}) if scene.gravity == 9.8 else scene

    (only,) = findings(solved(scenes, Ivp()), alter)
    assert only.names == ["gravity=9.80665"]
    assert "where the scene says 9.8" in only.sentence
    assert "alone" not in only.sentence


def test_a_laws_own_number_is_not_carried_over_to_another_law():
    def alter(scene: Any) -> Any:
        rational = getattr(scene.air.lift_coefficient, "law", "") == "rational"
        return with_values(scene, {"air.lift_coefficient.slope": 2.33}) if rational else scene

    (only,) = findings(gold("flight-spin-lift", every=2), alter)
    assert only.names[0] == "air.lift_coefficient.slope=2.33"


def test_a_cross_product_the_wrong_way_round_is_one_finding_under_all_laws():
    def reversed_lift(term: Any) -> Any:
        if isinstance(term, Piecewise):
            return replace(term, term=reversed_lift(term.term))
        if isinstance(term, Lift):
            return replace(term, factor=lambda m, p: -1.0 * term.factor(m, p))
        return term

    model = replace(MODEL, forces=tuple(map(reversed_lift, MODEL.forces)))
    (only,) = findings(gold("flight-spin-lift", every=2), lambda scene: scene, model)
    assert "lift-sign" in only.names


def test_an_axis_the_other_way_round_where_it_is_fixed_is_no_fault_of_the_pitch_alone():
    up, fixed = Reading(lift_direction="always_up"), [*pitches(), *flights()]
    above = [s.model_copy(update={"id": f"{s.id}-up", "reading": up}) for s in fixed]
    scenes = [*fixed, *above]

    def alter(scene: Any) -> Any:
        if scene.reading == up:
            return scene
        return with_values(scene, {"air.lift_coefficient": -scene.air.lift_coefficient})

    (only,) = findings(solved(scenes, Ivp()), alter)
    assert "lift-axis-sign" in only.names
    assert "alone" not in only.sentence


def test_a_lift_without_its_sign_is_no_axis_the_other_way_round():
    scenes = [
        with_values(s, {"air.lift_coefficient": -0.1 if i % 2 else 0.2})
        for i, s in enumerate((*pitches(), *flights()[:6]))
    ]

    def alter(scene: Any) -> Any:
        return with_values(scene, {"air.lift_coefficient": abs(scene.air.lift_coefficient)})

    (only,) = findings(solved(scenes, Ivp()), alter)
    assert only.names == ["air.lift_coefficient-unsigned"]


def test_what_several_stages_have_is_not_said_to_be_of_one_alone():
    told = [
        found(stage, f"{stage} alone: takes a bat", 1, 2, ["a-bat"])
        for stage in ("impulse", "energy")
    ]
    one, other = _not_alone(told)
    assert one.sentence == "impulse, as at energy: takes a bat"
    assert other.sentence == "energy, as at impulse: takes a bat"
    assert _not_alone(told[:1]) == told[:1]


# --- schemes --------------------------------------------------------------------------------------


def test_of_several_schemes_that_err_alike_the_order_alone_is_told():
    def like(name: str, left: float) -> Explanation:
        return Explanation(name, f"{LIKE} flies so", None, left)

    (told,) = _by_order([like("explicit-euler", 4e-4), like("rk4-fourth-at-half", 5e-4)])
    assert (told.name, told.sentence) == ("order-1", "errs as a method of order 1 does")
    for others in (
        [like("heun", 4e-4), like("rk4-fourth-at-half", 0.5)],
        [like("heun", 0.4), like("midpoint", 0.5)],
    ):
        assert _by_order(others) == others


def test_a_wrong_stage_is_not_mended_by_shorter_steps():
    remedy = _Way("rk4-third-from-first", "step").explanation(0.001, 0.0, None).remedy
    assert remedy is not None
    assert "shorter" not in remedy


# --- rules ----------------------------------------------------------------------------------------


def test_no_rule_is_by_a_flag_of_what_fields_tell():
    names = {name for case in gold() for name in features(case)}
    assert {"flag grazing", "flag tangential"} <= names
    assert names.isdisjoint({"flag at-release", "flag extreme", "flag dip", "flag reading"})


@pytest.mark.parametrize(
    ("name", "limit", "told"),
    [
        ("highest point in m", 30.0, "highest point in m > 30"),
        ("larger speed of launch and landing", 45.0, "larger speed of launch and landing > 45"),
        ("contact.normal[2]", 0.0, "contact.normal[2] > 0"),
    ],
)
def test_what_a_program_may_turn_on_is_a_rule(name: str, limit: float, told: str):
    cases = [case for case in gold() if name in features(case)]
    above = [case for case in cases if features(case)[name] > limit]
    assert (rule(above, [case for case in cases if case not in above]) or "").startswith(told)


@pytest.mark.parametrize(
    ("fails", "left"),
    [
        (lambda s: s.ground.height != 0.0, {"air": None, "ground": {"height": -3.0}}),
        (lambda s: s.air is not None, {}),
    ],
)
def test_a_smallest_scene_has_no_block_that_does_nothing(fails, left):
    (start,) = [case.scene for case in load("flight-both") if case.id == "flight-both-0006"]
    scene = shrunk(start, lambda scenes: [*map(fails, scenes)])
    found = scene.model_dump(mode="json", exclude_defaults=True)
    assert {name: x for name, x in found.items() if name not in ("id", "kind", "launch")} == left


def test_a_smallest_scene_is_one_that_is_answered():
    (start,) = [case.scene for case in load("flight-both") if case.id == "flight-both-0006"]

    def breaks_off_without_air(scenes):
        known = next((i for i, s in enumerate(scenes) if s.air is None), len(scenes))
        return [i < known for i in range(len(scenes))]

    assert shrunk(start, breaks_off_without_air).air == Air()


def test_fast_pitches_with_drag_are_a_rule():
    cases = [case for case in gold() if case.scene.kind in ("pitch", "at-bat")]
    known = [(case, features(case)) for case in cases]
    fast = [
        case
        for case, f in known
        if f.get("pitch.speed", 0.0) > 45 and f.get("air.drag_coefficient")
    ]
    told = rule(fast, [case for case in cases if case not in fast])
    assert told == "pitch.speed > 45 and air.drag_coefficient ≠ 0"
