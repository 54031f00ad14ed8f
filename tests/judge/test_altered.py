"""What is said of golden answers that are altered in one way."""

from __future__ import annotations

import json
import math
import shlex
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge import assert_case, judge
from longball.judge.answers import Collector
from longball.judge.cases import Case, Exact, decidable
from longball.judge.evaluation import Judge, Submission
from longball.judge.text import render
from longball.judge.verdict import Verdict

Data = dict[str, Any]


@pytest.fixture(scope="module")
def gold() -> dict[str, list[Case]]:
    families = "flight-both", "fence", "impact-oblique", "flight-spin-decay", "flight-wind"
    return {name: [case for case in load(name) if decidable(case)] for name in families}


def written(case: Case) -> Data:
    """Return the truth as a program writes it, in doubles."""

    def plain(held: Any) -> Any:
        match held:
            case {"value": value}:
                return float(value)
            case dict():
                return {key: plain(value) for key, value in held.items()}
            case list():
                return [plain(value) for value in held]
        return held

    made: Data = plain(json.loads(case.expected.line()))
    return made | {"id": case.id}


def judged(cases: list[Case], alter: Callable[[Case, Data], Data]) -> Verdict:
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        collector.take_line(number, json.dumps(alter(case, written(case))).encode())
    return Judge(cases, Exact()).evaluate(Submission("altered", collector)).verdict


def put(data: Data, name: str, value: Any) -> Data:
    block, key = name.split(".")
    if key in (data.get(block) or {}):
        data[block][key] = value(data[block][key])
    return data


def names(verdict: Verdict) -> list[str]:
    assert verdict.diagnosis is not None
    return verdict.diagnosis.named


def test_the_truth_in_doubles_passes(gold):
    for cases in gold.values():
        assert judged(cases, lambda case, data: data).passed


@pytest.mark.parametrize(
    ("family", "fact"),
    [("fence", "landing.fair"), ("fence", "fence.segment"), ("impact-oblique", "impact.mode")],
)
def test_what_is_left_out_besides_numbers_makes_an_answer_incomplete(gold, family, fact):
    block, key = fact.split(".")

    def without(case: Case, data: Data) -> Data:
        data.get(block, {}).pop(key, None)
        return data

    verdict = judged(gold[family], without)
    assert verdict.status == "PARTIAL"
    (missing,) = verdict.missing
    assert missing.quantity == fact
    assert missing.example.startswith(family)


def test_segments_that_count_from_one_are_told_so(gold):
    shifted = lambda case, data: put(data, "fence.segment", lambda n: n + 1)  # noqa: E731
    verdict = judged(gold["fence"], shifted)
    (finding,) = verdict.diagnosis.findings
    assert finding.sentence == "fence.segment is 1 too large, always"
    assert verdict.diagnosis.first == "fence"
    assert "fence" not in verdict.diagnosis.clean


def test_a_number_beyond_all_measure_is_judged(gold):
    far = lambda case, data: put(data, "landing.velocity", lambda v: [4.8e53, *v[1:]])  # noqa: E731
    verdict = judged(gold["flight-both"][:12], far)
    assert verdict.status == "FAILED"
    assert "4.8e+53" in render(verdict)


def test_six_digits_are_no_single_precision(gold):
    def short(held: Any) -> Any:
        if isinstance(held, list):
            return [short(x) for x in held]
        return float(f"{held:.6g}") if isinstance(held, float) else held

    def alter(case: Case, data: Data) -> Data:
        return data | {
            block: {key: short(x) for key, x in held.items()}
            for block, held in data.items()
            if isinstance(held, dict)
        }

    assert names(judged(gold["flight-both"], alter)) == ["few-digits"]


def test_a_distance_with_one_decimal_is_no_single_precision(gold):
    rounded = lambda case, data: put(data, "landing.distance", lambda d: round(d, 1))  # noqa: E731
    assert names(judged(gold["flight-both"], rounded)) == ["few-decimals"]


def test_a_launch_for_a_landing_is_told_with_its_scenes(gold):
    def alter(case: Case, data: Data) -> Data:
        if data["landing"]["time"] <= 4.0:
            return data
        launch = case.scene.launch
        far = {"position": list(launch.position), "velocity": list(launch.velocity)}
        far |= {"time": 0.0, "hang_time": 0.0, "distance": math.hypot(*launch.position[:2])}
        return data | {"landing": far}

    verdict = judged(gold["flight-both"], alter)
    assert names(verdict)[0] == "landing-is-launch", verdict.diagnosis.findings
    assert "landing.hang_time > 4" in verdict.diagnosis.findings[0].scenes


def test_answers_under_the_id_of_the_scene_before(gold):
    cases = gold["flight-both"]
    others = {case.id: written(after) for case, after in pairwise([*cases, cases[0]])}
    verdict = judged(cases, lambda case, data: others[case.id] | {"id": case.id})
    assert names(verdict) == ["ids-shifted"]


def test_a_velocity_through_the_air_is_no_wrong_flight(gold):
    def alter(case: Case, data: Data) -> Data:
        if not isinstance(case.scene.air.wind, tuple):
            return data
        return put(data, "landing.velocity", lambda v: [
            x - w for x, w in zip(v, case.scene.air.wind, strict=True)])  # fmt: skip

    verdict = judged(gold["flight-wind"], alter)
    assert verdict.diagnosis.first == "landing velocity"
    assert names(verdict) == ["landing.velocity: the velocity through the air"]
    assert "flight" in verdict.diagnosis.clean


def test_the_spin_is_not_accused_of_a_wrong_distance(gold):
    """Nor is the path through the air, which the truth has under one reading alone."""

    def alter(case: Case, data: Data) -> Data:
        data["landing"].setdefault("path", 1.1 * data["landing"]["distance"])
        return put(data, "landing.distance", lambda d: d * d)

    verdict = judged(gold["flight-spin-decay"], alter)
    assert verdict.diagnosis.first == "distance"
    assert "spin decay" in verdict.diagnosis.clean


def test_a_block_that_some_truths_have_is_not_called_one_that_none_has(gold):
    """A foul ball has crossed the fence, and has landed."""
    fence = next(written(case)["fence"] for case in gold["fence"] if "fence" in written(case))

    def alter(case: Case, data: Data) -> Data:
        return data if "fence" in data or data["outcome"] != "landed" else data | {"fence": fence}

    verdict = judged(gold["fence"], alter)
    assert "fence-given" not in names(verdict)
    assert any("where the truth has none; in " in f.sentence for f in verdict.diagnosis.findings)


def test_a_profile_has_a_name_and_a_candidate_is_a_command_or_a_function():
    verdict = judge([sys.executable, "-c", "pass"], "pitch", profile="converged")
    assert verdict.profile.startswith("converged")
    assert verdict.truth == "golden data, pitch"
    assert shlex.join([sys.executable, "-c", "pass"]) == verdict.candidate
    for wrong in ([], 5, "longball solve"):
        with pytest.raises(TypeError, match="a candidate is a command, as a list of words"):
            judge(wrong)


def test_quantities_that_the_outcome_does_not_have_are_faults():
    missed = [c for c in load("at-bat") if c.expected.outcome == "missed"][:3]

    def touch(case: Case, data: Data) -> Data:
        data["contact"]["time"] = data["plate"]["time"]
        return data

    found = judged(missed, touch)
    assert not found.passed
    assert {fault.what for failure in found.failures for fault in failure.faults} == {
        "contact.time"
    }
    assert "gives contact.time with the outcome missed, which has none" in render(found)


def test_a_second_contact_need_not_be_told_but_the_verdict_says_so():
    struck = [c for c in load("impact") if c.expected.impact and c.expected.impact.recontact][:3]

    def silent(case: Case, data: Data) -> Data:
        del data["impact"]["recontact"]
        return data

    found = judged(struck, silent)
    assert found.status == "PASSED"
    assert f"left out, as it may be: impact.recontact in 3 answers: {struck[0].id}" in render(found)
    for case in struck:
        assert_case(case, silent(case, written(case)))


def test_a_normal_divided_by_the_reach_follows_where_ball_and_bat_do_not_touch():
    met = [case for case in load("at-bat") if case.expected.impact][:4]

    def farther(case: Case, data: Data) -> Data:
        contact, reach = data["contact"], case.scene.ball.radius + case.scene.bat.radius
        contact["position"][0] += 0.01
        x, _, z = contact["position"]
        height = data["plate"]["position"][2] + case.scene.swing.height_offset
        contact["normal"] = [x / reach, 0.0, (z - height) / reach]
        return data

    diagnosis = judged(met, farther).diagnosis
    assert diagnosis is not None
    assert "normal" in diagnosis.clean


def test_what_one_quantity_is_explained_by_is_not_told_against_the_mode_of_others():
    cases = [case for case in load("impact-oblique") if decidable(case)]
    slides = [c for c in cases if c.expected.impact and c.expected.impact.mode == "slide"]
    names = "0024", "slide-1e-06", "slide-1e-09", "slide-1e-12"
    near = [case for case in slides if case.id.removeprefix("impact-oblique-") in names]

    def grips(case: Case, data: Data) -> Data:
        if case in near:
            bat = case.scene.bat.model_copy(update={"friction": 1000.0})
            made = solve(case.scene.model_copy(update={"bat": bat}), Ivp()).impact
            gripping = json.loads(made.model_dump_json(exclude_none=True))
            data["impact"] |= gripping | {"friction_margin": data["impact"]["friction_margin"]}
        return data

    diagnosis = judged(cases, grips).diagnosis
    assert diagnosis is not None
    assert "always-grips" not in diagnosis.named


def test_a_ground_that_is_ignored_below_zero_only_is_not_said_to_be_ignored():
    cases = [*load("flight-both"), *load("flight-vacuum")]
    assert any(case.scene.ground.height > 0 for case in cases[::2])

    def level(case: Case, data: Data) -> Data:
        height = max(0.0, case.scene.ground.height)
        ground = case.scene.ground.model_copy(update={"height": height})
        made = solve(case.scene.model_copy(update={"ground": ground}), Ivp())
        return json.loads(made.line()) | {"id": case.id}  # type: ignore[no-any-return]

    diagnosis = judged(cases[::2], level).diagnosis
    assert diagnosis is not None
    (finding,) = diagnosis.findings
    assert finding.sentence == "counts a negative ground.height as 0"


def test_what_is_taken_for_fair_tells_the_scenes_and_no_number_does(gold: dict[str, list[Case]]):
    def where_it_lands(case: Case, data: Data) -> Data:
        if data.get("landing") and "fair" in data["landing"]:
            x, y, _ = data["landing"]["position"]
            data["landing"]["fair"] = abs(y) <= x
        return data

    diagnosis = judged(gold["fence"], where_it_lands).diagnosis
    assert diagnosis is not None
    (finding,) = diagnosis.findings
    assert (finding.names, finding.scenes) == (["fair-at-landing"], None)


def test_times_in_another_unit_in_some_scenes_are_named(gold: dict[str, list[Case]]):
    def in_milliseconds(case: Case, data: Data) -> Data:
        if data["landing"]["hang_time"] > 5:
            for name in ("landing.time", "landing.hang_time"):
                data = put(data, name, lambda time: 1000 * time)
        return data

    diagnosis = judged(gold["flight-both"], in_milliseconds).diagnosis
    assert diagnosis is not None
    (finding,) = diagnosis.findings
    assert finding.names == ["ms-for-s"]
    assert finding.scenes == "landing.hang_time > 5"


def test_another_limit_of_its_own_value_is_told_between_which_values_it_is():
    def early(case: Case, data: Data) -> Data:
        if abs((data.get("contact") or {}).get("position", (0, 0))[1]) < 0.25:
            return data
        plate, contact = data["plate"], data["contact"]
        kept = {name: contact[name] for name in ("time", "position", "margin")}
        return {"id": case.id, "outcome": "beyond_bat", "plate": plate, "contact": kept}

    diagnosis = judged(load("at-bat"), early).diagnosis
    assert diagnosis is not None
    (finding,) = diagnosis.findings
    limit = "its limit for |contact.position[1]| is between 0.235 and 0.255 m, where L/2 is right"
    assert limit in finding.sentence
    assert finding.kind == "probably"
