"""``longball judge``, run as a user runs it."""

from __future__ import annotations

import csv
import json
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import jsonschema
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.verdict import schema
from tests.judge.material import answered
from tests.judge.test_sampling import at_bats

CANDIDATE = Path(__file__).parents[1] / "candidates" / "paper_verlet.py"
LONGBALL = [sys.executable, "-m", "longball"]

# A candidate of a few lines, which says the same of every scene.
SILENT = "import sys; sys.stdin.read()"
CRASHING = "print('\\x00\\x1b' * 99); raise SystemExit(7)"


def results(
    folder: Path,
    change: Callable[[dict], dict | None] = lambda answer: answer,
    family: str = "pitch",
) -> Path:
    """Return a file of the ivp engine's answers to golden scenes, changed."""
    path = folder / "results.jsonl"
    answers = [change(answered(case.scene)) for case in load(family)]
    path.write_text("".join(json.dumps(a) + "\n" for a in answers if a), encoding="utf-8")
    return path


def test_the_reference_passes_and_so_does_its_file(called, tmp_path: Path):
    said = called("judge", "--golden", "pitch", "--", *LONGBALL, "solve")
    assert (said.returncode, said.stderr) == (0, ""), said.stdout
    assert said.stdout.startswith(f"PASSED: {shlex.join([*LONGBALL, 'solve'])}\n")
    asked = "judge", "--golden", "pitch", "--results", results(tmp_path)
    said = called(*asked)
    assert said.returncode == 0, said.stdout
    assert said.stdout.startswith("PASSED: results.jsonl\nprofile converged")
    (suite, *_) = ElementTree.fromstring(called(*asked, "--format", "junit").stdout)
    assert (suite.get("name"), suite.get("failures")) == ("pitch", "0")


def test_a_verdict_in_every_form(called, tmp_path: Path):
    def in_feet(answer: dict) -> dict:
        if landing := answer.get("landing"):
            landing["distance"] /= 0.3048
        return answer

    html = tmp_path / "verdict.html"
    path = results(tmp_path, in_feet, "flight-drag")
    asked = "judge", "--golden", "flight-drag", "--results", path
    said = called(*asked, "--format", "json", "--html", html)
    assert said.returncode == 1
    verdict = json.loads(said.stdout)
    jsonschema.validate(verdict, schema())
    assert not verdict["passed"]
    (finding,) = [f for f in verdict["diagnosis"]["findings"] if f["kind"] == "named"]
    assert "(feet)" in finding["edit"]
    assert verdict["convergence"] is None
    assert html.read_text(encoding="utf-8").count("<img") == 2


@pytest.mark.nightly
def test_annotations_for_github_hold_no_command_of_the_program(called):
    hostile = "import sys; sys.stdin.read(); print('::add-mask::a\\n%', file=sys.stderr)"
    said = called("judge", "--golden", "pitch", "--format", "github", "--", sys.executable, "-c",
                  hostile)  # fmt: skip
    assert said.returncode == 1
    lines = said.stdout.splitlines()
    first = next(i for i, line in enumerate(lines) if not line.startswith("::"))
    *annotations, group, stop = lines[:first]
    assert all(line.startswith("::error title=longball judge%3A FAILED::") for line in annotations)
    assert annotations[0].endswith("no answer could be judged")
    assert group == "::group::verdict"
    token = stop.removeprefix("::stop-commands::")
    assert lines[-2:] == [f"::{token}::", "::endgroup::"]
    assert any("::add-mask::a" in line for line in lines[first:-2])
    passed = called("judge", "--golden", "pitch", "--format", "github", "--", *LONGBALL, "solve")
    assert passed.stdout.startswith("::notice title=longball judge%3A PASSED::")


def test_scenes_are_sent_as_the_file_has_them(called, tmp_path: Path):
    scenes = tmp_path / "scenes.jsonl"
    written = {"id": "a", "kind": "pitch", "air": {"density": 1.0}, "pitch": {"speed": 40.0}}
    scenes.write_text(json.dumps(written))
    echo = [sys.executable, "-c", "import sys; sys.stderr.write(sys.stdin.read())"]

    def sent(*options: str) -> dict:
        said = called("judge", "--scenes", scenes, *options, "--format", "json", "--", *echo)
        return json.loads(json.loads(said.stdout)["standard_error"])

    assert sent() == written
    whole = sent("--write-defaults")
    assert whole["air"]["density"] == 1.0
    assert whole["air"].keys() == {"density", "drag_coefficient", "lift_coefficient"}
    assert {"ball", "gravity", "time_limit", "reading"} < whole.keys()
    launch = {"position": [0, 0, 1], "velocity": [30, 0, 20]}
    scenes.write_text(json.dumps({"kind": "flight", "launch": launch}))
    assert called("judge", "--scenes", scenes, "--", *EXAMPLE).returncode == 0


@pytest.mark.nightly
def test_a_place_for_the_step_shows_how_it_converges(called, tmp_path: Path):
    html = tmp_path / "verdict.html"
    arguments = ("--golden", "flight-drag", "--profile", "converged", "--tolerance", "1",
                 "--steps", "0.02:0.004:5", "--html", html)  # fmt: skip
    command = ("--", sys.executable, "-I", CANDIDATE, "--dt", "{dt}")
    said = called("judge", *arguments, "--expected", "2", *command)
    assert said.returncode == 1
    assert said.stdout.splitlines()[0].endswith("--dt 0.004")
    assert "first run: dt = 0.004; then runs with other steps" in said.stderr
    assert "failed because: convergence: distance: other order" in said.stdout
    assert ", but 2 in theory" in said.stdout
    assert html.read_text(encoding="utf-8").count("<img") == 2
    said = called("judge", *arguments, "--expected", "1", "--format", "json", *command)
    assert said.returncode == 0, said.stdout
    orders = json.loads(said.stdout)["convergence"]["orders"]
    assert {order["verdict"] for order in orders} == {"as expected"}


def test_samples_are_judged_alone_and_beside_answers(called, tmp_path: Path):
    right, samples = tmp_path / "right.jsonl", tmp_path / "samples.jsonl"
    for path, drawn in ((right, at_bats()), (samples, at_bats(offset_spread=0.0732))):
        path.write_text("\n".join(map(json.dumps, drawn)), encoding="utf-8")
    alone = called("judge", "--samples", right)
    assert alone.returncode == 0
    assert "right  pitch.speed: drawn as the paper means it" in alone.stdout
    alone = called("judge", "--samples", samples)
    assert alone.returncode == 1
    reason = "FAILED: samples.jsonl\nfailed because: sampling: swing.height_offset: its spread"
    assert alone.stdout.startswith(reason)
    assert "WRONG  swing.height_offset" in alone.stdout
    assert "[radius-or-diameter]" in alone.stdout
    both = called(
        "judge", "--golden", "pitch", "--results", results(tmp_path), "--samples", samples,
        "--format", "json",
    )  # fmt: skip
    assert both.returncode == 1
    verdict = json.loads(both.stdout)
    jsonschema.validate(verdict, schema())
    assert verdict["right"] == verdict["judged"] > 0
    (reason,) = verdict["reasons"]
    assert reason.startswith("sampling: swing.height_offset")


def test_a_table_with_columns_of_its_own(called, tmp_path: Path):
    table = tmp_path / "results.csv"
    with table.open("w", encoding="utf-8", newline="") as file:
        write = csv.writer(file).writerow
        write(
            ["case", "t", "plate.velocity[0]", "plate.velocity[1]", "plate.velocity[2]", "remark"]
        )
        for case in load("pitch"):
            plate = solve(case.scene, Ivp()).plate
            cells = [repr(plate.time), *map(repr, plate.velocity)] if plate else [""] * 4
            write([case.id, *cells, "mine"])
    arguments = ("--golden", "pitch", "--results", table, "--column", "case=id")
    said = called("judge", *arguments, "--column", "t=plate.time", "--partial")
    assert said.returncode == 0, said.stdout
    assert "left out: plate.position in " in said.stdout
    said = called("judge", *arguments, "--column", "t=plate.time")
    assert said.returncode == 1
    assert said.stdout.startswith("PARTIAL ")


@pytest.mark.parametrize(
    ("program", "status", "step"), [(SILENT, 0, []), (CRASHING, 7, []), (CRASHING, 7, ["{dt}"])]
)
def test_a_candidate_that_misbehaves_fails_with_a_sentence(called, program, status, step):
    command = [sys.executable, "-I", "-S", "-c", program, *step]
    said = called("judge", "--golden", "pitch", "--", *command)
    assert said.returncode == 1
    # It may have ended "before it had read all scenes": that depends on who is faster.
    assert f"ended with status {status}" in said.stdout
    assert "; it answered 0 of" in said.stdout
    assert "Traceback" not in said.stderr
    assert "\x1b" not in said.stdout
    # No other step is tried of one that crashes.
    assert ("its convergence was not measured" in said.stdout) == bool(step)


def test_a_step_that_hangs_is_the_last_that_is_tried(called):
    # It answers with the finest step only, which it is first judged with.
    program = (
        "import sys, time, json\n"
        "if sys.argv[1] != '0.001': time.sleep(600)\n"
        "for line in sys.stdin: print(json.dumps({'id': json.loads(line)['id']}))\n"
    )
    command = [sys.executable, "-I", "-S", "-c", program, "{dt}"]
    asked = "judge", "--golden", "pitch", "--timeout", "5", "--steps", "0.1:0.001:5"
    said = called(*asked, "--", *command)
    assert said.returncode == 1
    assert said.stdout.count("no answer came for 5 s, and was stopped") == 1
    assert "dt = 0.1: the candidate: no answer came" in said.stdout
    assert "convergence: no answer has a quantity that could converge" in said.stdout


# --- what is asked ------------------------------------------------------------------------------


EXAMPLE = [sys.executable, str(Path(__file__).parents[2] / "docs" / "candidate.py")]


def test_the_first_command_says_what_is_left(called, tmp_path: Path):
    """As for a program that flies, and does no more; `test_docs.py` judges the flights alone."""
    said = called("judge", "--results", results(tmp_path, family="flight-both"))
    lines = said.stdout.splitlines()
    assert lines[0].startswith("PARTIAL ")
    assert "0 wrong" in lines[3]
    assert "and no at-bat, no impact, no pitch; --partial judges what there is" in lines[4]
    assert lines[-1].startswith("beyond this verdict: at --profile exact, ")
    assert "are right; not tested: defaults, hard, impact-oblique, fence," in lines[-1]


def test_nothing_is_claimed_of_answers_that_hold_nothing(called):
    """Of a program that prints the scenes that it reads, by each of the ways to count."""
    said = called("judge", "--golden", "pitch", "--", "cat").stdout
    assert "failed because: the answers hold nothing that could be judged" in said
    assert "ball is not a key of a result, but of a scene" in said
    assert not {"right;", "further:", "left out:"} & {*said.split()}


@pytest.mark.nightly
def test_other_readings_and_rows_are_shown_if_asked_for(called, tmp_path: Path):
    default = [case for case in load("at-bat") if "reading" not in case.flags]
    answers = [answered(case.scene) for case in load("at-bat")]
    path = tmp_path / "results.jsonl"
    path.write_text("".join(json.dumps(answer) + "\n" for answer in answers), encoding="utf-8")
    arguments = ("judge", "--golden", "at-bat", "--results", path)
    every = called(*arguments, "--readings", "--table")
    assert f"\n{len(answers)} scenes, " in every.stdout
    assert "\nat-bat  landing.distance" in every.stdout
    ids = {case.id for case in default}
    kept = [answer for answer in answers if answer["id"] in ids]
    path.write_text("".join(json.dumps(answer) + "\n" for answer in kept), encoding="utf-8")
    first = called(*arguments)
    assert f"\n{len(default)} scenes, {len(default)} answers judged" in first.stdout
    assert first.returncode == 0
    assert "landing.distance" not in first.stdout


# --- CSV, and few digits --------------------------------------------------------------------------

EULER = [sys.executable, str(CANDIDATE.with_name("euler_csv.py"))]


@pytest.mark.nightly
def test_a_candidate_that_takes_csv_converges(called, tmp_path: Path):
    command = ["--golden", "flight-both", "--as-csv", "--", *EULER, "{dt}", "17"]
    files = "--figure", tmp_path / "orders.png"
    ran = called("converge", "--json", *files, "--steps", "0.01:0.001:5", *command)
    assert ran.returncode == 0, ran.stderr
    assert (tmp_path / "orders.png").read_bytes().startswith(b"\x89PNG")
    orders = {one["quantity"]: one["order"] for one in json.loads(ran.stdout)["orders"]}
    assert orders["landing point"] == pytest.approx(1.0, abs=0.01)
    # A tolerance with which it passes, so that no causes are sought.
    lax = "--partial", "--tolerance", "10", "--steps", "0.01:0.001:5"
    said = called("judge", *lax, *command)
    assert "landing point  1.0" in said.stdout, said.stdout
    assert "not JSON" not in said.stdout


@pytest.mark.nightly
@pytest.mark.parametrize("step", ["0.01", "0.001"])
def test_six_digits_hide_no_method_of_order_one(called, step: str):
    said = called(
        "judge", "--golden", "flight-both", "--profile", "exact", "--partial", "--as-csv",
        "--", *EULER, step, "6",
    )  # fmt: skip
    assert f"flight: your program behaves like explicit Euler in steps of {step} s" in said.stdout
