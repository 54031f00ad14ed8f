"""What a verdict must not claim: rules by chance, numbers that have not settled, false causes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.answers import Answer, Collector
from longball.judge.cases import Case, decidable, solved
from longball.judge.diagnosis import diagnose
from longball.judge.explanations import Sought, Work
from longball.judge.findings import Diagnosis, Finding
from longball.judge.fits import Fit
from longball.judge.outcomes import _explains
from longball.judge.rules import features, rule
from longball.judge.stages import NONE, Change, placed, trial_of, with_values
from longball.judge.steps import ITS_OWN, FixedStep, _Way
from longball.judge.text import stage_sentences
from longball.model.readings import Reading
from longball.model.scene import FlightScene, Launch, Pitch, PitchScene
from tests.judge.material import at_bats, flights, impacts


@pytest.fixture(scope="module")
def gold() -> dict[str, Case]:
    return {case.id: case for case in load() if decidable(case)}


def told(cases: Sequence[Case], answer: Callable[[int, Case], Any]) -> list[Finding]:
    """Return what is found in answers that are dictionaries, by the number and the case."""
    return diagnosis(cases, answer).findings


def diagnosis(cases: Sequence[Case], answer: Callable[[int, Case], Any]) -> Diagnosis:
    collector = Collector([case.id for case in cases])
    for i, case in enumerate(cases):
        collector.take_line(i + 1, json.dumps(answer(i, case)).encode())
    return diagnose(cases, collector.answers)


def result(scene: Any) -> dict[str, Any]:
    return json.loads(solve(scene, Ivp()).line())  # type: ignore[no-any-return]


# --- rules ----------------------------------------------------------------------------------------


def test_scenes_that_are_alike_in_a_number_make_no_rule_by_it(gold: dict[str, Case]):
    at_bats = [case for case in gold.values() if case.scene.kind == "at-bat"]
    slow = [case for case in at_bats if case.id.startswith("hard-lob-")]
    others = [case for case in at_bats if case not in slow and case.scene.pitch.speed > 20]
    assert len(slow) > 5
    assert "speed" not in (rule(slow, others) or "")


def test_a_number_that_sorts_many_scenes_is_a_rule(gold: dict[str, Case]):
    hit = [case for case in gold.values() if "launch speed" in features(case)]
    fast = [case for case in hit if features(case)["launch speed"] > 45]
    slow = [case for case in hit if case not in fast]
    assert (rule(fast, slow) or "").startswith("launch speed > 45")


def test_of_two_conditions_each_must_be_needed(gold: dict[str, Case]):
    landed = [case for case in gold.values() if "landing.hang_time" in features(case)]
    late = [
        case
        for case in landed
        if features(case)["landing.hang_time"] > 5 and features(case).get("air.drag_coefficient")
    ]
    others = [case for case in landed if case not in late]
    assert rule(late, others) == "landing.hang_time > 5.01 and air.drag_coefficient ≠ 0"


def test_how_large_an_error_is_makes_no_rule_by_a_number(gold: dict[str, Case]):
    landed = [case for case in gold.values() if case.expected.landing][:60]
    landed.sort(key=lambda case: float(case.expected.landing.hang_time))
    assert "hang_time" in (rule(landed[:30], landed[30:]) or "")
    assert rule(landed[:30], landed[30:], measured=False) is None


def test_few_scenes_make_no_rule(gold: dict[str, Case]):
    cases = [case for case in gold.values() if case.scene.kind in ("flight", "impact")]
    some = [case for case in cases if case.scene.kind == "impact"]
    others = [case for case in cases if case not in some]
    assert rule(some, others)
    assert rule(some[:4], others) is None


def test_another_number_than_most_have_makes_no_rule(gold: dict[str, Case]):
    thrown = [case for case in gold.values() if hasattr(case.scene, "pitch")]
    same = [case for case in thrown if features(case).get("pitch.speed") == 32.0]
    others = [case for case in thrown if case not in same]
    assert "≠ 32" not in (rule(others, same) or "")


def test_another_number_than_the_default_makes_one(gold: dict[str, Case]):
    flights = [case for case in gold.values() if case.scene.kind == "flight" and case.scene.air]
    heavy = [case for case in flights if case.scene.ball.mass != 0.145]
    told = rule(heavy, [case for case in flights if case not in heavy])
    assert (told or "").startswith("ball.mass ≠ 0.145")


# --- numbers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_the_bats_radius_is_blamed_where_it_is_wrong_and_nowhere_else(share: float):
    """In the moment of inertia alone, under two readings of what that is about."""
    about = Reading(inertia="about_centre")
    scenes = [
        *impacts(),
        *(s.model_copy(update={"id": f"{s.id}-centre", "reading": about}) for s in impacts()),
    ]

    def answer(i: int, case: Case) -> dict[str, Any]:
        scene, right = case.scene, result(case.scene)
        bat, ball = scene.bat, scene.ball
        lever = bat.length / 2 - scene.incoming.position[1]
        slender = bat.length**2 / (12 if scene.reading == about else 3)
        ratio = ball.mass * lever**2 / (bat.mass * (slender + share * bat.radius**2))
        right["impact"]["restitution"] = ball.restitution * (1 + ratio) + ratio
        return {"id": case.id, **right}

    first = told(solved(scenes, Ivp()), answer)[0]
    assert first.names[0] == f"bat-inertia={share:g}", first.names


def test_a_number_of_each_scenes_own_is_told():
    def answer(i: int, case: Case) -> dict[str, Any]:
        thicker = {"air.density": case.scene.air.density * (1 + 0.01 * i * i)}
        return {"id": case.id, **result(with_values(case.scene, thicker))}

    (first, *_) = told(solved(flights()[:6], Ivp()), answer)
    assert first.kind == "unexplained"
    assert "another air.density, " in first.sentence


def test_a_scheme_that_leaves_what_it_would_not_is_not_said_to_be_the_candidates():
    way = _Way("rk4-fourth-at-half", "step")
    assert way.explanation(0.004, 0.1 * ITS_OWN, None).sentence.startswith("flies by")
    assert way.explanation(0.004, 50 * ITS_OWN, None).sentence.startswith("errs as one who")


# --- outcomes -------------------------------------------------------------------------------------


def test_what_doubles_cannot_decide_contradicts_nothing(gold: dict[str, Case]):
    case = gold["hard-bat-end-pivot-above"]
    trial = trial_of(case, Answer(case.id, case.expected.outcome, {}))
    thinner = Change(lambda scene: with_values(scene, {"air.density": 1.225}))
    assert _explains(thinner, trial) is None


def test_a_faster_ball_that_stays_up_is_no_mistake_about_the_time_limit(gold: dict[str, Case]):
    case = gold["hard-each-in-time-high"]
    right = result(case.scene)
    fast = tuple(1.5 * v for v in right["impact"]["velocity"])
    del right["landing"]
    right |= {"outcome": "airborne", "impact": {**right["impact"], "velocity": fast}}
    outcome = next(f for f in told([case], lambda i, c: right) if f.stage == "outcome")
    assert outcome.names == []
    assert "its own impact.velocity" in outcome.sentence


def test_a_scheme_is_not_followed_far_beyond_the_time_limit(gold: dict[str, Case]):
    case = gold["hard-dip-circle-under-1e-09"]
    trial = trial_of(case, Answer(case.id, "airborne", {}))
    steps = Change(engine=FixedStep(dt=0.02, scheme="rk4", ends="step"))
    longer = Change(partial(with_values, values={"time_limit": 1e5}))
    assert _explains(steps, trial) is True
    assert _explains(steps.then(longer), trial) is None


def test_a_ball_struck_beyond_the_bat_is_told_from_its_own_contact(gold: dict[str, Case]):
    case = gold["hard-bat-end-slanted-outside"]
    right = result(case.scene)
    struck = {"velocity": [40.0, 0.0, 10.0]}
    outcome = next(
        f
        for f in told([case], lambda i, c: {**right, "outcome": "batted", "impact": struck})
        if f.stage == "outcome"
    )
    assert "beyond the ends of the bat" in outcome.sentence


def test_of_two_times_the_one_beyond_the_limit_is_no_place(gold: dict[str, Case]):
    cases = [case for case in gold.values() if case.scene.kind == "at-bat"][::9]
    cases += [gold["hard-each-in-time-high"], gold["hard-each-in-time-low"]]

    def answer(i: int, case: Case) -> dict[str, Any]:
        right = result(case.scene)
        if "landing" in right:
            right["landing"]["hang_time"] = right["landing"]["time"]
        return {"id": case.id, **right}

    (first, *rest) = told(cases, answer)
    assert (first.stage, first.names) == (
        "time",
        ["landing.hang_time: landing.time"],
    )
    assert rest == []


def test_a_number_is_told_once_however_small_its_rest(gold: dict[str, Case]):
    mass = 5.125 * 0.028349523125
    cases = [c for c in gold.values() if c.family in ("pitch", "impact", "at-bat")][::5]

    def answer(i: int, case: Case) -> dict[str, Any]:
        return {"id": case.id, **result(with_values(case.scene, {"ball.mass": mass}))}

    findings = [f for f in told(cases, answer) if f.stage != "outcome"]
    assert [f.names[0] for f in findings] == ["ball.mass=0.145291"]


def too_low(case: Case) -> dict[str, Any]:
    """Return a result with too small a clearance, and with home runs that are foul."""
    made = result(case.scene)
    made["fence"]["clearance"] -= 0.03
    return made | {"outcome": "home_run" if made["fence"]["clearance"] > 0 else "wall"}


def test_a_home_run_follows_from_a_clearance_only_if_the_ball_is_fair():
    fence = {case.id: case for case in load("fence")}
    names = ("stepped-0000", "poles-0001", "foul", "line-in-left", "line-in-right", "line-out-left")
    findings = told([fence[f"fence-{name}"] for name in names], lambda i, case: too_low(case))
    (fouls,) = [f for f in findings if f.stage == "outcome"]
    assert fouls.names == ["foul-home-run"]
    assert "follows from" not in fouls.sentence


def test_a_fence_that_is_not_seen_does_not_follow():
    fence = {case.id: case for case in load("fence")}
    cases = [fence[f"fence-step-right-1e-{power}"] for power in ("03", "09", "12")]
    cases.append(fence["fence-stepped-0000"])

    def answer(i: int, case: Case) -> dict[str, Any]:
        return result(case.scene.model_copy(update={"fence": None} if i < 3 else {}))

    (finding,) = told(cases, answer)
    assert "gives no block fence" in finding.sentence
    assert "fence" not in diagnosis(cases, answer).clean


def test_a_factor_near_one_is_told_by_its_difference():
    assert "gravity were 1 + 1e-11 times" in Fit("gravity", "factor", 1 + 1e-11, 0.0, True).sentence
    assert "gravity were 1 - 2e-07 times" in Fit("gravity", "factor", 1 - 2e-7, 0.0, True).sentence


# --- what follows from something else -------------------------------------------------------------


def test_what_follows_from_a_wrong_pitch_is_no_wrong_stage():
    cases = solved(at_bats(), Ivp())
    lighter = with_gravity(1 + 1e-7)
    found = diagnosis(cases, lambda i, case: result(lighter(case.scene)))
    assert found.first == "pitch"
    assert {row.stage for row in found.stages if row.wrong} == {"pitch", "flight"}


def test_the_first_stage_is_one_with_a_name_however_small_its_errors():
    cases = solved([*at_bats(), *flights()], Ivp())

    def answer(i: int, case: Case) -> dict[str, Any]:
        told = result(with_gravity(1 + 1e-8)(case.scene))
        told["landing"]["distance"] *= 2
        return told

    found = diagnosis(cases, answer)
    assert found.first == "pitch"
    assert found.findings[0].stage == "pitch"
    assert {f.stage for f in found.findings} == {"pitch", "distance"}


def with_gravity(factor: float) -> Callable[[Any], Any]:
    return lambda scene: with_values(scene, {"gravity": factor * scene.gravity})


def test_a_limit_that_its_own_values_bear_out_is_no_finding(gold: dict[str, Case]):
    ends = [case for name, case in gold.items() if name.startswith("hard-bat-end-")]
    cases = [*ends, *(case for case in gold.values() if case.family == "at-bat")]

    def answer(i: int, case: Case) -> dict[str, Any]:
        said = result(case.scene)
        if case.id == "hard-bat-end-slanted-inside":
            x, _, z = said["contact"]["position"]
            contact = {"time": said["contact"]["time"], "margin": said["contact"]["margin"]}
            beyond = [x, 0.5000001 * case.scene.bat.length, z]
            said |= {"outcome": "beyond_bat", "contact": {**contact, "position": beyond}}
            del said["impact"], said["landing"]
        return said

    outcome = next(f for f in told(cases, answer) if f.stage == "outcome")
    assert "this follows from its own contact.position" in outcome.sentence


def test_outcomes_of_balls_that_fly_wrongly_are_one_line(gold: dict[str, Case]):
    cases = [gold[f"hard-dip-phugoid-{side}-1e-12"] for side in ("under", "over")]
    cases += [case for case in gold.values() if case.family == "flight-lift"][::3]
    kinds = iter(("grounded", "wall"))

    def answer(i: int, case: Case) -> dict[str, Any]:
        if "dip" in case.flags:
            return {"id": case.id, "outcome": next(kinds)}
        said = result(case.scene)
        if "landing" in said:
            said["landing"]["position"][0] *= 1.01 + 0.003 * i
        return said

    (outcome,) = [f for f in told(cases, answer) if f.stage == "outcome"]
    assert outcome.kind == "probably"
    assert "in 2 scenes" in outcome.sentence


def test_dips_that_are_missed_are_no_other_ground(gold: dict[str, Case]):
    dips = [case for name, case in gold.items() if name.startswith("hard-dip-phugoid-under")]
    flights = [case for case in gold.values() if case.family == "flight-lift"][::6]

    def answer(i: int, case: Case) -> dict[str, Any]:
        return {"id": case.id, "outcome": "airborne"} if case in dips else result(case.scene)

    assert any(case.scene.ground.height for case in flights)
    (outcome,) = told([*dips, *flights], answer)
    assert outcome.names == []
    assert "at the steps only" in outcome.sentence


def test_a_plate_by_a_straight_line_from_the_last_step_is_no_wrong_pitch():
    thrown = [
        PitchScene(id=f"pitch-{i}", pitch=Pitch(speed=30.0 + 1.3 * i, aim=(0.05 * i, 1.7 + i / 40)))
        for i in range(12)
    ]

    def straight(i: int, case: Case) -> dict[str, Any]:
        right = result(case.scene)
        collector = Collector([case.id])
        collector.take_line(1, json.dumps(right).encode())
        known = placed(trial_of(case, collector.answers[case.id]), NONE, "pitch")
        assert known is not None
        way, step = known.way, 0.02
        last = math.floor(right["plate"]["time"] / step) * step
        before, place, after = (np.array(way(last + k * 1e-5)) for k in (-1, 0, 1))
        velocity = (after - before) / 2e-5
        more = -place[0] / velocity[0]
        crossed = {"time": last + more, "position": [0.0, *(place + more * velocity)[1:]]}
        return {**right, "plate": {**crossed, "velocity": list(velocity)}}

    found = diagnosis(solved(thrown, Ivp()), straight)
    assert found.first == "plate"
    assert "pitch" in found.clean
    assert [f.names for f in found.findings] == [["event-between-steps"]]


def ended(case: Case, change: Callable[[Any, float], dict[str, Any]]) -> dict[str, Any]:
    """Return a flight's right answer with another landing: from the true path and its time."""
    right = result(case.scene)
    trial = trial_of(case, answered(case, right))
    there = placed(trial, NONE, "landing")
    assert there is not None
    return {**right, "landing": {**right["landing"], **change(there, there.time)}}


def answered(case: Case, right: dict[str, Any]) -> Answer:
    collector = Collector([case.id])
    collector.take_line(1, json.dumps(right).encode())
    return collector.answers[case.id]


def at_time(there: Any, time: float) -> dict[str, Any]:
    """Return what is told of a landing at another time on the true path."""
    place, velocity = there.way(time), there.velocity(time)
    told = {"time": time, "hang_time": time, "distance": math.hypot(*place[:2])}
    return {**told, "position": list(place), "velocity": list(velocity)}


def test_a_velocity_on_a_line_between_two_steps_is_no_fault_of_the_flight():
    def on_line(i: int, case: Case) -> dict[str, Any]:
        def change(there: Any, time: float) -> dict[str, Any]:
            share, step = (0.3 + 0.618 * i) % 1, 0.02
            a, b = (np.array(there.velocity(time + k * step)) for k in (-share, 1 - share))
            x, y, z = there.way(time)
            return {"velocity": list(a + share * (b - a)), "position": [x + 1e-9, y, z]}

        return ended(case, change)

    found = diagnosis(solved(flights(), Ivp()), on_line)
    (velocity,) = [f for f in found.findings if f.stage == "landing velocity"]
    assert velocity.names == ["event-between-steps"]
    assert {f.stage for f in found.findings if f.worst > 1e-9} == {"landing velocity"}


def test_where_a_wrong_flight_ends_is_not_called_right():
    cases = solved(flights(), Ivp())
    found = diagnosis(cases, lambda i, case: result(with_values(case.scene, {"gravity": 9.81})))
    assert found.first == "flight"
    assert not {"landing", "landing velocity"} & {*found.clean}


@pytest.mark.parametrize(("late", "said"), [(1e-9, "a root is found no better"), (1e-2, "behind")])
def test_an_end_that_is_late_is_told_with_its_time(late: float, said: str):
    def answer(i: int, case: Case) -> dict[str, Any]:
        off = late * ((0.2 + 0.618 * i) % 1 + 0.05)
        return ended(case, lambda there, time: at_time(there, time + off))

    found = diagnosis(solved(flights(), Ivp()), answer)
    assert found.first == "landing"
    (only,) = [f for f in found.findings if f.names]
    assert only.names == ["landing-beside-surface"]
    assert said in only.sentence


def test_numbers_with_nine_digits_are_one_finding():
    def short(i: int, case: Case) -> dict[str, Any]:
        right = json.dumps(result(case.scene))
        return json.loads(right, parse_float=lambda x: float(f"{float(x):.9g}"))  # type: ignore[no-any-return]

    (only,) = told(solved([*flights(), *at_bats(6)], Ivp()), short)
    assert only.names == ["few-digits"]
    assert "9 digits" in only.sentence


@pytest.mark.parametrize("written", ["{:.6g}", "{:.9g}", "{:.5f}"])
def test_few_digits_hide_no_density(written: str):
    def thin(i: int, case: Case) -> dict[str, Any]:
        air = case.scene.air.model_copy(update={"density": 0.95 * case.scene.air.density})
        short = json.dumps(result(case.scene.model_copy(update={"air": air})))
        return json.loads(short, parse_float=lambda x: float(written.format(float(x))))  # type: ignore[no-any-return]

    names = [f.names[0] for f in told(solved([*flights(), *at_bats(6)], Ivp()), thin)]
    assert "air.density=1.2255" in names or "air.density*0.95" in names, names
    assert names[-1] in ("few-digits", "few-decimals")


def test_decimals_are_counted_in_numbers_with_exponents_too():
    (case,) = solved(flights()[:1], Ivp())
    collected = Collector([case.id])
    landing = '{"position": [6.0E-4, 1.25, 0.0], "distance": 12.5}'
    line = f'{{"id": "{case.id}", "outcome": "landed", "landing": {landing}}}'
    collected.take_line(1, line.encode())
    assert trial_of(case, collected.answers[case.id]).resolution == 0.5e-4


def test_one_end_off_the_ground_is_not_told_as_the_rule():
    def high(i: int, case: Case) -> dict[str, Any]:
        return ended(case, lambda there, time: at_time(there, time - 0.2 * (i == 0)))

    found = diagnosis(solved(flights(), Ivp()), high)
    assert found.first == "landing"
    assert not [f for f in found.findings if "always" in f.sentence]


def test_one_quantity_that_is_wrong_is_named():
    def odd(i: int, case: Case) -> dict[str, Any]:
        right = result(case.scene)
        x, y, z = right["impact"]["velocity"]
        right["impact"]["velocity"] = [x + 0.01 * math.sin(3 * i + 1), y, z * (1 + i / 50)]
        return right

    (first, *_) = told(solved(impacts(), Ivp()), odd)
    assert "impact.velocity is wrong" in first.sentence


def test_times_that_are_off_are_no_wrong_touching():
    def late(i: int, case: Case) -> dict[str, Any]:
        told = result(case.scene)
        off = 1 + 1e-7 * (2 + math.sin(i))
        for block in told.values():
            if isinstance(block, dict):
                block |= {key: off * block[key] for key in ("time", "hang_time") if key in block}
        return told

    found = diagnosis(solved([*at_bats(), *flights()], Ivp()), late)
    assert found.first == "time"
    assert {row.stage for row in found.stages if row.wrong} == {"time"}
    assert {f.stage for f in found.findings} == {"time"}


def test_a_velocity_wrong_at_the_end_only_counts_with_its_flight():
    """Under a change that puts the place right, it is not told of another stage."""
    (case,) = solved(flights()[2:3], Ivp())
    heavier = case.scene.model_copy(update={"gravity": 9.9})
    right = result(heavier)
    right["landing"]["velocity"][0] += 0.01
    trial = trial_of(case, answered(case, right))
    sought = Sought([trial], [], ("flight",), NONE, Work())
    (plain,) = sought.rows(NONE)
    (mended,) = sought.rows(Change(partial(with_values, values={"gravity": 9.9})))
    assert plain.shape == mended.shape == (6,)
    assert abs(mended[:3]).max() < 1e-9
    assert abs(mended[3]) > 1e-5


def test_errors_of_balls_that_fly_straight_up_are_no_straight_lines():
    launches = [((0.0, 0.0, 1.0), (0.0, 0.0, 20.0 + i)) for i in range(6)]
    scenes = [
        FlightScene(id=f"up-{i}", launch=Launch(position=place, velocity=velocity))
        for i, (place, velocity) in enumerate(launches)
    ]

    def low(i: int, case: Case) -> dict[str, Any]:
        right = result(case.scene)
        right["landing"]["position"][2] -= 0.01 * (1 + (i * 0.618) % 1)
        right["landing"]["velocity"][2] *= 1.0
        return right

    assert "event-between-steps" not in names(told(solved(scenes, Ivp()), low))


def names(findings: Sequence[Finding]) -> list[str]:
    return [name for f in findings for name in f.names]


def test_single_precision_is_told_once():
    def single(i: int, case: Case) -> dict[str, Any]:
        right = json.dumps(result(case.scene))
        return json.loads(right, parse_float=lambda x: float(np.float32(x)))  # type: ignore[no-any-return]

    found = told(solved([*flights(), *at_bats(6)], Ivp()), single)
    assert names(found) == ["single-precision"]
    assert len(found) == 1


def test_what_a_few_scenes_make_of_few_digits_is_no_fault_of_theirs(gold: dict[str, Case]):
    """The impulse on a ball of a milligram is lost in six decimals; its velocity is not."""
    light = gold["hard-mass-ratio-nathan-1e-06"]
    cases = [case for case in gold.values() if case.family == "impact"][:40]

    def short(i: int, case: Case) -> dict[str, Any]:
        right = json.dumps(result(case.scene))
        return json.loads(right, parse_float=lambda x: round(float(x), 6))  # type: ignore[no-any-return]

    found = diagnosis([*cases, light], short)
    assert names(found.findings) == found.findings[0].names == ["few-decimals"]
    assert found.first is None
    assert "as far as its digits tell" in " ".join(stage_sentences(found))


def test_the_axis_of_the_pitch_is_named_where_others_are_always_up():
    """Straight pitches turn about +y, and a ball that is batted about it is pressed down."""
    straight = [with_values(s, {"pitch.release[1]": 0.0, "pitch.aim[0]": 0.0}) for s in at_bats(10)]
    up = Reading(lift_direction="always_up")
    above = [s.model_copy(update={"id": f"{s.id}-up", "reading": up}) for s in straight]

    def pressed(i: int, case: Case) -> dict[str, Any]:
        scene, right = case.scene, result(case.scene)
        if scene.reading == up or "impact" not in right:
            return right
        begin, away = right["contact"]["position"], right["impact"]["velocity"]
        launch = Launch(position=tuple(begin), velocity=tuple(away))
        air = scene.air.model_copy(update={"lift_coefficient": -scene.air.lift_coefficient})
        flight = FlightScene(id=case.id, launch=launch, air=air)
        landing = result(flight)["landing"]
        landing["time"] += right["contact"]["time"]
        return right | {"landing": landing}

    found = told(solved([*straight, *above], Ivp()), pressed)
    assert any("axis that the pitch had" in f.sentence for f in found), found


@pytest.mark.parametrize("late", [-0.01, 0.02])
def test_a_velocity_of_another_time_is_named_with_that(late: float):
    def odd(i: int, case: Case) -> dict[str, Any]:
        right = result(case.scene)
        trial = trial_of(case, answered(case, right))
        place = placed(trial, NONE, "landing velocity")
        assert place is not None
        right["landing"]["velocity"] = list(place.velocity(place.time + late * (1 + 0.1 * (i % 3))))
        return right

    (only,) = told(solved([*flights(), *at_bats(6)], Ivp()), odd)
    assert only.names == ["velocity-of-another-time"]
    assert ("before" if late < 0 else "after") in only.sentence
