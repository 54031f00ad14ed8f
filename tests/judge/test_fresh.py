"""Fresh scenes, points for answers, functions for candidates, CSV for JSON."""

from __future__ import annotations

import io
import json
import math
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from longball.engines.chain import solve, solve_with_path
from longball.engines.ivp import Ivp
from longball.judge import evaluation, serve
from longball.judge.answers import Collector
from longball.judge.candidate import Run
from longball.judge.cases import Converged, Exact, solved
from longball.judge.evaluation import Judge
from longball.judge.fresh import as_csv, proven, random_scenes, usual_constants
from longball.judge.paths import landed
from longball.judge.step_sweep import parse_knob, sweep_of
from longball.judge.verdict import Submission, compare
from longball.model.scene import Launch, Scene, parse_scene
from tests.judge.material import answered, collected, flights, pitches


def test_random_scenes_are_the_same_for_the_same_seed_and_of_all_kinds():
    first, again, other = (list(random_scenes(8, seed)) for seed in (3, 3, 4))
    assert first == again
    assert first != other
    assert {scene.kind for scene in first} == {"flight", "pitch", "impact", "at-bat"}


def test_random_scenes_of_some_kinds():
    drawn = list(random_scenes(5, 3, ["flight", "pitch"]))
    assert [scene.kind for scene in drawn] == ["flight", "pitch", "flight", "pitch", "flight"]
    assert len({scene.id for scene in drawn}) == 5


def test_fresh_scenes_are_proven_and_right():
    cases = proven(list(random_scenes(4, 1)))
    assert all(float(case.expected.contact.normal_speed.radius) < 1e-15
               for case in cases if case.scene.kind == "impact")  # fmt: skip
    for case in cases:
        answers = collected([case], [answered(case.scene)]).answers
        assert compare(case, answers[case.id], Exact()).passed


def test_the_usual_constants_are_all_there():
    scenes = usual_constants()
    assert len({(s.gravity, s.air.density) for s in scenes}) == 16


def path_answer(scene: Scene, step: float, width: int, beyond: float = 0.05) -> dict:
    """Return points on the true path, a step apart."""
    result, truth = solve_with_path(scene, Ivp())
    end = float(truth.end)
    times = np.arange(0.0, end + beyond, step)
    leg = truth.legs[0]
    rows = []
    for t in times.tolist():
        state = leg.flight.path.at(t)
        rows.append([t, *leg.frame.position(state), *leg.frame.velocity(state)][:width])
    assert result.outcome in ("landed", "crossed")
    return {"id": scene.id, "path": rows}


def judged(scenes: list[Scene], answers: list[dict], profile=None):
    cases = solved(scenes, Ivp())
    judge = Judge(cases, profile or Converged(1e-6), diagnose=False)
    return judge.evaluate(Submission("points", collected(cases, answers)))


@pytest.mark.parametrize("width", [4, 7])
def test_points_are_judged_and_landed(width: int):
    scenes = [*flights()[:5], *pitches()]
    verdict = judged(scenes, [path_answer(s, 0.01, width) for s in scenes]).verdict
    assert verdict.passed, verdict.reasons
    assert {row.quantity for row in verdict.rows} >= {"path.position", "landing.distance"}


def test_a_path_that_stops_a_step_above_the_ground_is_landed():
    scenes = flights()[:3]
    answers = [path_answer(s, 0.01, 7, beyond=0.0) for s in scenes]
    assert judged(scenes, answers).verdict.passed


@pytest.mark.parametrize(("own", "error"), [(1.0, 1e-8), (1.001, 1e-6)])
def test_velocities_help_to_land_a_path_where_they_are_its_slopes(own: float, error: float):
    """At steps of 0.2 s; places alone leave 9e-7 m, as long as velocities are others."""
    (scene,) = (s for s in flights() if s.id == "flight-35")
    answer = path_answer(scene, 0.2, 7, beyond=0.4)
    for point in answer["path"]:
        point[4:] = [own * v for v in point[4:]]
    (case,) = solved([scene], Ivp())
    found, slack = landed(scene, collected([case], [answer]).answers[case.id])
    place = [float(x) for x in found.values["landing.position"]]
    assert math.dist(place, [float(x) for x in case.expected.landing.position]) < error
    assert slack["landing.position"] < 100 * error


def test_points_off_the_path_are_told():
    scene = flights()[2]
    answer = path_answer(scene, 0.01, 7)
    answer["path"][50][2] += 0.01
    (failure,) = judged([scene], [answer]).verdict.failures
    fault = failure.faults[0]
    assert fault.what == "path.position"
    assert fault.error == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("points", "why"),
    [
        ([], "at least two points"),
        ([[0, 0, 0, 1]], "at least two points"),
        ([[0, 0, 0, 1], [1, 0, 0, 1], [0.5, 0, 0, 1]], "time does not increase at point 2"),
        ([[0, 0, 0, 1], [0, 0, 0, 1]], "time does not increase"),
        ([[0, 0, 0, 1], [1, 0, math.nan, 1]], "point 1 is"),
        ([[0, 0, 0, 1], [1, 0, 1]], "point 1 is"),
        ([[0, 0, 0, 1], "x"], "point 1 is"),
        ([[float(i), 0, 0, 1] for i in range(100_001)], "100001 points"),
        (7, "at least two points"),
    ],
)
def test_what_is_no_path_is_told(points: object, why: str):
    evaluation = judged([flights()[0]], [{"id": flights()[0].id, "path": points}])
    assert not evaluation.verdict.passed
    assert any(why in str(issue) for issue in evaluation.verdict.complaints)


def vacuum_at(times):
    """Return a function from a launch to its way without air, as points at given times."""

    def fly(state, parameters):
        x, y, z, vx, vy, vz = state
        g = parameters["gravity"]
        t = times(parameters["time_limit"])
        return np.array([t, x + vx * t, y + vy * t, z + vz * t - g / 2 * t**2]).T

    return fly


def served(function, *lines: str) -> list[dict]:
    """Return the answers of a function to scenes."""
    out = io.StringIO()
    serve(function, lines, out)
    return [*map(json.loads, out.getvalue().splitlines())]


def test_a_function_becomes_a_candidate():
    scene = flights()[0].model_copy(update={"air": None})
    incoming = {"position": [0.0696, 0, 1], "velocity": [-30, 0, 0], "bat_height": 1}
    impact = json.dumps({"kind": "impact", "id": "i", "incoming": incoming})
    vacuum = vacuum_at(lambda limit: np.linspace(0, 4, 401))
    answer, refused = served(vacuum, scene.line(), impact)
    assert judged([scene], [answer]).verdict.passed
    assert "only flights and pitches" in refused["error"]


def in_vacuum(kind: str, **blocks: object) -> Scene:
    return parse_scene(json.dumps({"id": kind, "kind": kind, "air": None, **blocks}))


UP = {"launch": {"position": [0, 0, 1], "velocity": [0, 0, 30]}}


@pytest.mark.parametrize(
    ("scene", "outcome"),
    [
        (in_vacuum("flight", time_limit=2.0, **UP), "airborne"),
        (in_vacuum("flight", time_limit=7.0, **UP), "landed"),
        (in_vacuum("pitch", time_limit=0.3), "airborne"),
        (in_vacuum("pitch"), "crossed"),
        (in_vacuum("pitch", pitch={"velocity": [-15, 0, 0]}), "grounded"),
        (in_vacuum("pitch", pitch={"velocity": [-40, 0, 1]}), "crossed"),
    ],
)
@pytest.mark.parametrize("last", [lambda limit: limit, lambda limit: limit - 0.01, lambda _: 8.0])
def test_points_tell_how_a_ball_ends(scene: Scene, outcome: str, last):
    fly = vacuum_at(lambda limit: np.arange(0.0, min(last(limit), 8.0) + 1e-9, 0.01))
    (answer,) = served(fly, scene.line())
    assert solve(scene, Ivp()).outcome == outcome
    found = judged([scene], [answer])
    assert found.verdict.passed, found.verdict.reasons
    assert found.comparisons[0].answer.outcome == outcome


def test_a_landing_after_the_time_limit_is_airborne():
    scene = in_vacuum("flight", time_limit=2.0, **UP)
    late = {"time": np.float64(6.2), "position": (0, 0, 0)}
    assert judged([scene], served(lambda state, parameters: late, scene.line())).verdict.passed


def test_scenes_and_results_as_csv(tmp_path: Path):
    source = tmp_path / "candidate.py"
    source.write_text(
        "import csv, sys\n"
        "rows = csv.DictReader(sys.stdin)\n"
        "print('id,outcome,plate.time')\n"
        "for row in rows:\n"
        "    print(row['id'] + ',crossed,' + str(float(row['pitch.release[0]'])))\n",
        encoding="utf-8",
    )
    scenes = pitches()
    judge = Judge(solved(scenes, Ivp()), Converged(100.0), partial=True, diagnose=False)
    verdict = judge.evaluate_command([sys.executable, str(source)], table=True).verdict
    assert verdict.passed, verdict.reasons
    assert verdict.judged == len(scenes)
    header = next(as_csv(scenes)).decode()
    assert header.startswith("id,kind,")


def test_state_kept_between_scenes_and_random_answers_are_told(tmp_path: Path):
    source = tmp_path / "candidate.py"
    text = (
        "import json, random, sys\n"
        "n = 0\n"
        "for line in sys.stdin:\n"
        "    n += 1\n"
        "    made = {'id': json.loads(line)['id'], 'plate': {'time': VALUE}}\n"
        "    print(json.dumps(made), flush=True)\n"
    )
    judge = Judge(solved(pitches(), Ivp()), Converged(1e-3), partial=True)
    for value, why in (
        ("n / 100", "depend on earlier scenes"),
        ("random.random()", "not det"),
    ):
        source.write_text(text.replace("VALUE", value), encoding="utf-8")
        verdict = judge.evaluate_command([sys.executable, str(source)]).verdict
        assert any(why in reason for reason in verdict.reasons), verdict.reasons


@pytest.mark.nightly
def test_a_flight_straight_up_is_run_twice_as_others_are():
    first, second, *_ = flights()
    up = first.model_copy(update={"launch": Launch(position=(0.0, 0.0, 1.0), velocity=(0, 0, 40))})
    judge = Judge(solved([up, second], Ivp()), Exact())
    verdict = judge.evaluate_command([sys.executable, "-m", "longball", "solve"]).verdict
    assert verdict.passed, verdict.reasons


def test_the_time_of_a_verdict_is_that_of_all_runs(monkeypatch):
    runs: list[int] = []  # a second each, by the clock below

    def run(command, scenes, *others, **options) -> Run:
        runs.append(len(scenes))
        return Run(Collector([scene.id for scene in scenes]), "", 0)

    def again(self, asked, answers) -> list[str]:
        asked(pitches()[:2])
        return []

    monkeypatch.setattr(evaluation, "run", run)
    monkeypatch.setattr(evaluation, "time", SimpleNamespace(monotonic=lambda: float(len(runs))))
    monkeypatch.setattr(Judge, "_again", again)
    judge = Judge(solved(pitches(), Ivp()), Exact())
    assert judge.evaluate_command(["candidate"]).verdict.seconds == 2.0


@pytest.mark.parametrize(
    ("text", "name", "words"),
    [
        ("n=10,20,40,80,160", "n", ["10", "20", "40", "80", "160"]),
        ("tol=1e-3:1e-5:3", "tol", ["0.001", "0.0001", "1e-05"]),
    ],
)
def test_a_knob_has_a_name_and_values(text: str, name: str, words: list[str]):
    found = parse_knob(text)
    assert found[0] == name
    assert [float(w) for w in found[1]] == pytest.approx([float(w) for w in words])


def test_a_knob_that_rises_is_a_number_of_steps():
    command = ["x", "--n={n}"]
    sweep = sweep_of(command, knob="n=10,20,40,80,160")
    assert sweep.steps == pytest.approx([0.1, 0.05, 0.025, 0.0125, 0.00625])
    assert sweep.filled(command, min(sweep.steps)) == ["x", "--n=160"]
    for wrong in ("n=3,1,2", "n", "n=0,1", "2=1,2", "n=a,b"):
        with pytest.raises(ValueError, match="from coarse to fine"):
            parse_knob(wrong)
