"""The example candidates: built, judged, and judged again with a mistake in their source.

They were written from the paper, in three languages, without longball; that they agree with the
Verlet engine to 1e-9 is a test of that engine too.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from longball.engines.ivp import Ivp
from longball.judge.candidate import Limits
from longball.judge.cases import Known, profile, solved
from longball.judge.evaluation import Evaluation, Judge
from longball.judge.quantities import OPTIONAL
from longball.judge.text import render
from longball.model.scene import written_out
from tests.judge.material import at_bats, flights, impacts, pitches

FOLDER = Path(__file__).parents[1] / "candidates"
GENEROUS = Limits(scene_seconds=60, total_seconds=300)


def command(source: Path, folder: Path) -> list[str]:
    """Return the command that runs a candidate, built if need be."""
    match source.suffix:
        case ".py":
            return [sys.executable, "-I", str(source)]
        case ".js":
            if not (node := shutil.which("node")):
                pytest.skip("no Node on this machine")
            return [node, str(source)]
        case _:
            if not (compiler := shutil.which("cc")):
                pytest.skip("no C compiler on this machine")
            program = folder / "candidate"
            subprocess.run([compiler, "-O1", "-o", program, source, "-lm"], check=True)
            return [str(program)]


def truths(count: int = 14) -> list[Known]:
    """Cases for programs that know no defaults; their truth is the ivp engine's."""
    drawn = [*at_bats(count), *flights(), *impacts(), *pitches()]
    return solved([*map(written_out, drawn)], Ivp())


def evaluate(judge: Judge, program: list[str]) -> Evaluation:
    return judge.evaluate_command(program, GENEROUS)


LAGGED = (
    "behaves like velocity Verlet with the force at the old velocity, which the next step begins"
)

NIGHTLY = pytest.mark.nightly

NAMES = ["paper_verlet.c", "paper_verlet.js", "paper_verlet.py"]


@pytest.mark.parametrize("name", [*NAMES, "../planted/at_bat_lab.py"])
def test_they_know_nothing_of_longball(name: str):
    assert "longball" not in (FOLDER / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("dt", [0.05, pytest.param(0.004, marks=NIGHTLY)])
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(every=6)
def test_the_printed_scheme_passes_as_such(name: str, dt: float, tmp_path: Path):
    cases = truths(150 if dt == 0.05 else 40)
    judge = Judge(cases, profile("paper", dt=dt), partial=True)
    evaluation = evaluate(judge, [*command(FOLDER / name, tmp_path), "--dt", str(dt)])
    assert evaluation.verdict.passed, render(evaluation.verdict)
    assert evaluation.verdict.judged == len(cases)
    outcomes = {(c.expected, c.obtained) for c in evaluation.verdict.outcomes}
    assert ("batted", "batted") in outcomes
    assert dt < 0.05 or ("missed", "missed") in outcomes
    missing = {m.quantity for m in evaluation.verdict.missing}
    assert missing - {*OPTIONAL} == {"contact.margin"}


@pytest.mark.parametrize(
    ("name", "right", "wrong", "stage", "edit"),
    [
        ("paper_verlet.c", "a.z -= gravity", "a.z -= 9.81", "pitch", "uses 9.81 for g"),
        pytest.param("paper_verlet.py",
                     'floor = scene["ground"]["height"]\n    flight',
                     'floor = scene["ground"]["height"] + scene["ball"]["radius"]\n    flight',
                     "landing", "R", marks=NIGHTLY),
        pytest.param("paper_verlet.js", "restitution * (1 + ratio) + ratio;", "restitution;",
                     "restitution", "leaves out m/M_eff", marks=NIGHTLY),
    ],
)  # fmt: skip
def test_a_mistake_in_the_source_is_named_beside_the_scheme(
    name: str, right: str, wrong: str, stage: str, edit: str, tmp_path: Path
):
    text = (FOLDER / name).read_text(encoding="utf-8")
    assert right in text
    source = tmp_path / name
    source.write_text(text.replace(right, wrong), encoding="utf-8")
    # At 5 ms the bat is met in most at-bats, so that there is something to see.
    judge = Judge(truths(20), profile("paper", dt=0.005))
    verdict = evaluate(judge, [*command(source, tmp_path), "--dt", "0.005"]).verdict
    assert verdict.diagnosis is not None
    named = [f for f in verdict.diagnosis.findings if f.kind == "named"]
    assert [f.stage for f in named] == [stage], verdict.diagnosis.sentence
    assert edit in named[0].sentence


WHOLE = "half of the contact force as a constant over two steps"
OLD, NEXT = (f"acceleration({v}, to or heading({v}))" for v in ("v", "add(half, total, 0.5 * dt)"))


@pytest.mark.parametrize(
    ("dt", "edits", "mistakes"),
    [
        (0.004, [(OLD, NEXT)], ["velocity Verlet with the force at a predicted velocity", WHOLE]),
        (0.02, [("a[2] -= g", "a[2] -= 9.81"), ("rb**2 / 4)", "0)")],
         ["uses 9.81 for g", LAGGED, "leaves out r_b", WHOLE]),
    ],
)  # fmt: skip
@pytest.mark.nightly
def test_against_the_truth_its_mistakes_are_told_from_its_scheme(
    dt: float,
    edits: list[tuple[str, str]],
    mistakes: list[str],
    tmp_path: Path,
):
    text = (FOLDER / "paper_verlet.py").read_text(encoding="utf-8")
    for right, wrong in edits:
        assert right in text
        text = text.replace(right, wrong)
    source = tmp_path / "candidate.py"
    source.write_text(text, encoding="utf-8")
    judge = Judge(truths(), profile("converged", 1e-6))
    verdict = evaluate(judge, [*command(source, tmp_path), "--dt", str(dt)]).verdict
    assert verdict.diagnosis is not None
    named = [f.edit or "" for f in verdict.diagnosis.findings if f.kind == "named"]
    assert len(named) == len(mistakes), named
    for mistake in mistakes:
        assert any(mistake in edit for edit in named), named
