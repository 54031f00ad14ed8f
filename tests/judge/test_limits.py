"""Values that are limited, ends at steps, and what a verdict says of few scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from longball.engines.chain import MODEL, solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.any_law import ANY_LAW
from longball.judge.cases import Case, decidable, solved
from longball.judge.findings import Finding, found
from longball.judge.law_mistakes import changed_terms, lifts, multiplied, of_kind
from longball.judge.stages import with_values
from longball.judge.text import finding_sentences
from longball.model.air import Table
from longball.model.readings import Reading
from longball.model.scene import FlightScene, Launch
from tests.judge.material import at_bats, impacts, pitches
from tests.judge.test_other_numbers import findings
from tests.judge.test_reasons import result, told


def family(name: str, holds: Callable[[Any], bool] = lambda scene: True) -> list[Case]:
    return [case for case in load(name) if decidable(case) and holds(case.scene)]


def named(
    cases: Sequence[Case], change: Callable[[Any, dict[str, Any]], None], stage: str
) -> Finding:
    """Return the only finding at a stage in results that are changed in place."""

    def answer(i: int, case: Case) -> dict[str, Any]:
        given = result(case.scene)
        change(case.scene, given)
        return given

    (only,) = (f for f in told(cases, answer) if f.stage == stage)
    return only


def test_a_limit_of_a_value_is_told():
    masses = np.geomspace(0.2, 20, 12)
    scenes = [
        with_values(s, {"id": f"{s.id}-{m:g}", "ball.mass": m}) for s in impacts() for m in masses
    ]

    def limited(scene: Any, given: dict[str, Any]) -> None:
        given["impact"]["restitution"] = min(given["impact"]["restitution"], 1.0)

    assert named(solved(scenes, Ivp()), limited, "restitution").names[0] == "impact.restitution<=1"


def test_one_less_the_value_is_told():
    def ratio(scene: Any, given: dict[str, Any]) -> None:
        if "friction_margin" in given.get("impact", {}):
            given["impact"]["friction_margin"] = 1 - given["impact"]["friction_margin"]

    only = named(family("impact-oblique"), ratio, "velocity after")
    assert only.sentence == "impact.friction_margin: obtained = 1 - expected"


def test_a_component_that_stays_as_it_was_is_named():
    def kept(scene: Any, given: dict[str, Any]) -> None:
        given["impact"]["velocity"][2] = scene.incoming.velocity[2]

    assert (
        named(solved(impacts(), Ivp()), kept, "velocity after").names[0]
        == "impact.velocity: v_z as before the impact"
    )


def test_a_lost_spin_about_the_normal_is_named():
    def lost(scene: Any, given: dict[str, Any]) -> None:
        if "spin" in given.get("impact", {}):
            spin, n = np.array(given["impact"]["spin"]), np.array(given["contact"]["normal"])
            given["impact"]["spin"] = (spin - (spin @ n) * n).tolist()

    only = named(family("impact-oblique"), lost, "spin after")
    assert only.names[0] == "impact.spin: a spin without its part about the normal"


def test_a_normal_by_another_length_is_named():
    def grown(scene: Any, radius: float) -> Any:
        (x, y, z), height = scene.incoming.position, scene.incoming.bat_height
        more = (radius + scene.ball.radius) / 0.0696
        place = (more * x, y, height + more * (z - height))
        name = f"{scene.id}-{radius}"
        return with_values(scene, {"id": name, "bat.radius": radius, "incoming.position": place})

    def by_number(scene: Any, given: dict[str, Any]) -> None:
        reach = scene.ball.radius + scene.bat.radius
        given["contact"]["normal"] = [x * reach / 0.07 for x in given["contact"]["normal"]]

    cases = solved([grown(s, radius) for s in impacts() for radius in (0.03, 0.035)], Ivp())
    assert named(cases, by_number, "normal").names == ["normal-by-number=0.07"]


@pytest.mark.parametrize(("of", "height"), [("higher", max), ("lower", min)])
def test_a_level_chord_is_named_by_its_vertex(of: str, height: Any):
    cases = family("fence", lambda s: s.fence is not None and s.fence.polyline is not None)

    def level(scene: Any) -> Any:
        line = scene.fence.polyline
        level = [(x, y, height(p[2], q[2])) for p, q in pairwise(line) for x, y, _ in (p, q)]
        return with_values(scene, {"fence.polyline": tuple(level)})

    names = [name for f in findings(cases, level) for name in f.names]
    assert f"fence-height-of-{of}" in names


def test_defaults_of_a_law_are_named():
    def default(scene: Any) -> Any:
        if getattr(scene.air.lift_coefficient, "law", "") != "rational":
            return scene
        numbers = {"numerator": 1.12, "constant": 0.583, "slope": 2.333}
        return with_values(scene, {f"air.lift_coefficient.{n}": x for n, x in numbers.items()})

    (only,) = findings(family("flight-spin-lift"), default)
    assert only.names == ["air.lift_coefficient-rational-defaults"]
    assert only.scenes is None


def test_a_flight_driven_beyond_all_measure_hides_no_cause():
    cases = family("flight-kinks", lambda s: isinstance(s.air.drag_coefficient, Table))[:12]

    def beyond(scene: Any) -> Any:
        table = scene.air.drag_coefficient
        slope = (table.values[-1] - table.values[-2]) / (table.at[-1] - table.at[-2])
        far = 1.5 * table.at[-1]
        more = max(0.0, table.values[-1] + slope * (far - table.at[-1]))
        return with_values(
            scene,
            {
                "air.drag_coefficient.at": (*table.at, far),
                "air.drag_coefficient.values": (*table.values, more),
            },
        )

    def answer(i: int, case: Case) -> dict[str, Any]:
        given = result(beyond(case.scene))
        if i == 0:
            given["landing"]["velocity"] = [1e9, 0.0, -1e9]
            given["landing"]["position"][0] *= 1.5
        return given

    found = told(cases, answer)
    assert not any("none of the known" in f.sentence for f in found if f.stage == "flight"), found


def test_a_law_with_another_lift_is_always_up_still():
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(2.0, 0.0, 40.0))
    scene = FlightScene(id="up", launch=launch, reading=Reading(lift_direction="always_up"))
    same = changed_terms(of_kind(lifts, lambda form: multiplied(form, lambda m, p: 1.0)))
    made, right = solve(scene, ANY_LAW, same.model(MODEL)), solve(scene, Ivp())
    assert made.landing is not None
    assert right.landing is not None
    assert made.landing.position == pytest.approx(right.landing.position, abs=1e-7)


# --- at the steps ---------------------------------------------------------------------------------


def in_vacuum(scenes: Sequence[Any]) -> list[Case]:
    return solved([with_values(scene, {"air": None}) for scene in scenes], Ivp())


def thrown(scene: Any, time: float) -> tuple[list[float], list[float]]:
    """Return place and velocity of a ball thrown in a vacuum."""
    start, velocity = np.array(scene.pitch.release), np.array(scene.pitch.thrown)
    fall = np.array([0.0, 0.0, -scene.gravity])
    place = start + velocity * time + fall * time**2 / 2
    return place.tolist(), (velocity + fall * time).tolist()


@pytest.mark.parametrize(("which", "side"), [(math.ceil, "behind"), (math.floor, "before")])
def test_a_plate_at_a_step_is_named(which: Callable[[float], int], side: str):
    def at_step(scene: Any, given: dict[str, Any]) -> None:
        if "plate" not in given:
            return
        time = which(given["plate"]["time"] / 0.002) * 0.002
        (_, y, z), velocity = thrown(scene, time)
        given["plate"] |= {"time": time, "position": [0.0, y, z], "velocity": velocity}

    scenes = [
        with_values(s, {"id": f"{s.id}-{x}", "pitch.release[0]": x})
        for s in pitches() for x in (17.1, 17.9, 18.3)
    ]  # fmt: skip
    only = named(in_vacuum(scenes), at_step, "pitch")
    assert only.names == ["plate.position-at-step"]
    assert f"{side} the plate" in only.sentence


@pytest.mark.parametrize(("which", "name"), [(math.ceil, "late"), (math.floor, "early")])
def test_a_contact_at_a_step_is_named(which: Callable[[float], int], name: str):
    def at_step(scene: Any, given: dict[str, Any]) -> None:
        given.pop("impact", None)
        given.pop("landing", None)
        if "contact" in given and "position" in given["contact"]:
            time = which(given["contact"]["time"] / 0.002) * 0.002
            margin = given["contact"]["margin"]
            place, _ = thrown(scene, time)
            given["contact"] = {"time": time, "position": place, "margin": margin}

    assert named(in_vacuum(at_bats(40)), at_step, "touching").names == [f"contact-{name}"]


# --- words ----------------------------------------------------------------------------------------


def test_a_cause_that_rests_on_one_scene_is_told_so():
    one, many = (found("fence", "bends the fence", n, 40, ["fence-by-angle"]) for n in (1, 20))
    assert "in 1 scene only" in next(iter(finding_sentences(one)))
    assert "only" not in next(iter(finding_sentences(many)))


def test_a_rule_of_two_conditions_is_not_told_as_the_cause():
    scenes = "air.drag_coefficient ≠ 0.4 and kind = flight"
    unknown = found("flight", "wrong", 9, 40, scenes=scenes)
    assert any("need not be the cause" in line for line in finding_sentences(unknown))
