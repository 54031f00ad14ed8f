"""What is said of simulators whose law of motion differs in one part."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import pytest

from longball.engines.chain import MODEL, Model, OneCase, solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.any_law import ANY_LAW
from longball.judge.cases import Case, decidable, solved
from longball.judge.diagnosis import diagnose
from longball.judge.law_mistakes import LAW
from longball.judge.stages import with_values
from longball.model.aerodynamics import DECAY_ALONG_PATH, LIFT
from longball.model.atmosphere import density
from longball.model.force import Drag, Lift, Piecewise, Term, scaled, size
from longball.model.frame import launch_frame
from longball.model.numbers import DOUBLES
from longball.model.trace import as_node
from tests.judge.material import collected, flights

ONE = as_node(1.0)


def gold(family: str, every: int = 1) -> list[Case]:
    return [case for case in load(family) if decidable(case)][::every]


def with_term(old: Term, new: Term) -> Model:
    return replace(MODEL, forces=tuple(new if f is old else f for f in MODEL.forces))


def explained(cases: list[Case], alter: Callable[[Any], Any], model: Model = MODEL) -> list[str]:
    """Return the names of what is found first, of the right answers to altered scenes."""
    results = [solve(alter(case.scene), Ivp(), model) for case in cases]
    first, *_ = diagnose(cases, collected(cases, results).answers).findings
    return first.names


def same(scene: Any) -> Any:
    return scene


def earth(**change: Callable[[float], float]) -> Callable[[Any], Any]:
    return lambda scene: with_values(
        scene, {f"earth.{key}": new(getattr(scene.earth, key)) for key, new in change.items()}
    )


@pytest.mark.parametrize(
    ("name", "alter"),
    [
        ("earth.latitude*-1", earth(latitude=lambda angle: -angle)),
        (
            "earth-in-degrees",
            earth(latitude=math.radians, azimuth=math.radians),
        ),
    ],
)
def test_an_angle_of_the_earth(name, alter):
    assert explained(gold("flight-real", 4), alter)[0] == name


def test_spin_that_decays_over_ground():
    decay = replace(DECAY_ALONG_PATH, rate=lambda motion, p: size(motion.velocity))
    over_ground = with_term(DECAY_ALONG_PATH, decay)
    assert explained(gold("flight-real", 2), same, over_ground) == ["spin-decay-over-ground"]


def changed(kind: type[Term], factor: Callable[[Any], Any]) -> Model:
    """Return the model with all drags, or all lifts, times a factor of the motion."""
    key = "rate" if kind is Drag else "factor"

    def one(f: Any) -> Any:
        if isinstance(f, Piecewise):
            return replace(f, term=one(f.term))
        if isinstance(f, kind):
            own = getattr(f, key)
            return replace(f, **{key: lambda m, p: own(m, p) * factor(m)})
        if kind is Lift and f is LIFT:
            return replace(f, acceleration=lambda m, p: scaled(factor(m), LIFT.acceleration(m, p)))
        return f

    return replace(MODEL, forces=tuple(map(one, MODEL.forces)))


def test_a_drag_by_the_speed_over_ground_and_a_coefficient_by_the_airspeed():
    over_ground = changed(Drag, lambda m: size(m.velocity) / m.air.speed)
    assert explained(gold("flight-real", 2), same, over_ground) == ["drag-by-speed-over-ground"]


def test_a_lift_in_air_that_is_the_same_at_all_heights():
    same_aloft = changed(Lift, lambda m: 1.0 / m.density)
    assert explained(gold("flight-real", 2), same, same_aloft) == ["lift-the-same-aloft"]


def test_a_lift_with_the_sign_of_its_vertical_part():
    def other(m: Any, p: Any) -> Any:
        x, y, z = LIFT.acceleration(m, p)
        return x, y, -1.0 * z

    model = with_term(LIFT, replace(LIFT, acceleration=other))
    assert explained(solved(flights(), Ivp()), same, model) == ["lift-vertical-sign"]


def test_times_rounded_to_milliseconds():
    cases = gold("flight-both", 2)
    results = []
    for case in cases:
        right = solve(case.scene, Ivp())
        times = {key: round(float(getattr(right.landing, key)), 3) for key in ("time", "hang_time")}
        results.append(right.model_copy(update={"landing": right.landing.model_copy(update=times)}))
    first, *_ = diagnose(cases, collected(cases, results).answers).findings
    assert (first.names, first.stage) == (["times-rounded"], "time")
    assert "rounded to 3 decimals" in first.sentence


def test_two_mistakes_in_the_restitution():
    """The lever by |y|, and the usual mass of a ball, in ẽ alone."""
    cases = [case for case in gold("impact") if case.expected.impact]
    results = []
    for case in cases:
        right = solve(case.scene, Ivp())
        x, y, z = case.scene.incoming.position
        other = with_values(case.scene, {"incoming.position": (x, abs(y), z), "ball.mass": 0.145})
        wrong = solve(other, Ivp())
        if right.impact is None or wrong.impact is None:
            results.append(right)
            continue
        impact = right.impact.model_copy(update={"restitution": wrong.impact.restitution})
        results.append(right.model_copy(update={"impact": impact}))
    findings = diagnose(cases, collected(cases, results).answers).findings
    (first,) = [f for f in findings if f.stage == "restitution"]
    assert first.names == ["incoming.position:(x, |y|, z) and ball.mass=0.145"]


def test_a_slightly_other_density_in_each_scene():
    cases = gold("flight-weather", 4)
    results = []
    for number, case in enumerate(cases):
        value = float(density(case.scene, DOUBLES)) * (1 + 1e-5 * (3 + number * number % 7))
        results.append(solve(with_values(case.scene, {"air.density": value}), Ivp()))
    first, *_ = diagnose(cases, collected(cases, results).answers).findings
    assert first.kind == "unexplained"
    assert "another air.density, 1.00003 to " in first.sentence


@pytest.mark.parametrize("family", ["flight-kinks", "flight-real"])
def test_every_known_mistake_makes_a_law_or_is_no_explanation(family: str):
    kinds = {repr((c.scene.reading, c.scene.air)): c.scene for c in gold(family, 2)}
    for scene in list(kinds.values())[:12]:
        launch = scene.launch
        for mistake in LAW:
            with suppress(ArithmeticError, ValueError):
                frame, _ = launch_frame(launch.position, launch.velocity, DOUBLES, launch.spin)
                made = OneCase(mistake.change.scene(scene), ANY_LAW, mistake.change.model(MODEL))
                made.law(frame)
