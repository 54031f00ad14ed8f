"""The planted programs are right without a mistake, and what is measured of the judge is measured
rightly. `make planted` measures it; here is a small part of the open half.
"""

import ast
import json
import re
import shutil
import subprocess
import sys

import pytest

from longball.judge import judge
from longball.judge.cases import Converged
from longball.judge.diagnosis.chain import CHAIN
from longball.judge.diagnosis.residual import data_of, specialised_to
from longball.judge.verdict import compare
from tests.planted import measure, sources
from tests.planted.mutator import c_mutants, python_mutants

pytestmark = pytest.mark.nightly  # of the measurement alone

needs_c = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("planted")


# --- the measurement ------------------------------------------------------------------------------


def test_wilson_interval_of_none_in_300():
    # z² / (n + z²) with z = 1.96
    assert measure.wilson(0, 300) == (0.0, pytest.approx(3.8415 / 303.8415, rel=1e-4))


def test_name_is_right_only_within_four_floors_everywhere():
    finding = {"stage": "flight", "kind": "named", "words": "uses 2 times lift",
               "is_edit": True, "rough": False, "off": [0, 90], "part": False}  # fmt: skip
    row = {"source": "planted", "passed": False, "first": ["flight"], "everywhere": ["flight"],
           "findings": [finding]}  # fmt: skip
    assert measure.grade(row).named
    assert measure.grade(row | {"source": "right"}).false  # a right program has no mistake
    assert measure.grade(row | {"findings": [finding | {"off": [1, 90]}]}).false
    assert not measure.grade(row | {"findings": [finding | {"off": [4, 90], "rough": True}]}).false
    assert not measure.grade(row | {"first": ["pitch"]}).located
    assert measure.grade(row | {"findings": []}).reassured
    part, rest = finding | {"part": True}, finding | {"kind": "located"}
    assert measure.grade(row | {"findings": [part, finding]}).named
    assert not measure.grade(row | {"findings": [part, rest]}).named


@pytest.mark.parametrize("family", ["flight-both", "pitch", "impact", "at-bat", "fence"])
def test_chain_without_an_edit_answers_the_truth(family):
    cases = sources.golden((family,), 6)
    chain = specialised_to(data_of(cases, sources.truth(cases)), CHAIN)
    answers = sources.answers_of(chain, cases)
    assert len(answers) == len(cases)
    assert all(compare(c, answers[c.id], Converged(1e-8)).passed for c in cases)


def test_fresh_scenes_are_new_and_have_the_options_of_the_old_ones():
    old, new = sources.golden(("impact",), 120), sources.fresh(("impact",), 20)
    assert len(new) == 20
    assert measure.like(new, old) == [*new]
    masses = {case.scene.ball.mass for case in old}
    assert not masses & {case.scene.ball.mass for case in new}


def test_halves_are_disjoint_and_about_equal():
    names = [f"program {i}" for i in range(400)]
    closed = sum(sources.half_of(name) == "closed" for name in names)
    assert 160 < closed < 240  # ± 4 σ


# --- mutants --------------------------------------------------------------------------------------

PYTHON = """
def speed(a, b):
    return math.sin(a) * b - air["drag"] + air["lift"] + b[0]


def main():
    return 1 + 1
"""


def test_mutants_in_python():
    every = [*python_mutants(PYTHON)]
    changes = {mutant.change.removeprefix("3: ") for mutant in every}
    assert {"math.sin -> math.cos", "b -> -b", "b[0] -> b[1]"} <= changes
    assert {"air['drag'] -> air['lift']", "math.sin(a) * b -> math.sin(a) / b"} <= changes
    assert "math.sin(a) * b -> b" in changes
    for mutant in every:
        ast.parse(mutant.source)
        assert mutant.source != PYTHON
        assert mutant.source.endswith(PYTHON[PYTHON.index("\n\n\ndef main") :])


C = """
static double speed(double a, double b) {
    /* a + b */
    if (a < b) return sin(a) * b - 2.0 * a;
    return -a + at[0].x;
}
int main(void) { return 1 + 1; }
"""


def test_mutants_in_c():
    every = [*c_mutants(C)]
    lines = {mutant.source.splitlines()[3].strip() for mutant in every}
    assert "if (a > b) return sin(a) * b - 2.0 * a;" in lines
    assert "if (a < b) return cos(a) * b - 2.0 * a;" in lines
    assert "if (a < b) return sin(a) / b - 2.0 * a;" in lines
    assert "if (a < b) return sin(a) * b ;" in lines
    assert "if (a < b) return sin(a) * b - 4.0 * a;" in lines
    assert "if (a < b) return sin(a) * a - 2.0 * a;" in lines
    for mutant in every:
        assert "/* a + b */" in mutant.source
        assert mutant.source.endswith("int main(void) { return 1 + 1; }\n")


# --- the programs ---------------------------------------------------------------------------------


@pytest.mark.parametrize("level", ["step 0.01", "tolerance 1e-10"])
def test_the_right_program_is_right_to_its_accuracy(folder, level):
    cases = sources.golden(sources.PAPER, 12)
    named = {subject.name: subject.answers for subject in sources.right(folder)}
    answers = named[f"at_bat_lab.py {sources.FLIGHTS[0]}.. {level}"](cases)
    given = [case for case in cases if not answers[case.id].error]
    assert len(given) > 80
    # A landing magnifies the error of a contact a thousandfold.
    assert all(compare(case, answers[case.id], Converged(1e-6)).passed for case in given)


@needs_c
@pytest.mark.parametrize("family", [*sources.PAPER, *sources.REAL])
def test_without_a_mistake_the_program_in_c_is_right_to_the_digits_of_doubles(folder, family):
    assert judge([str(sources.built(sources.HERE / "ballistics.c", folder))], family).passed


@pytest.mark.skipif(shutil.which("node") is None, reason="there is no Node")
@pytest.mark.parametrize("family", sources.PAPER)
def test_without_a_mistake_the_program_in_javascript_is_right_to_the_digits_of_doubles(family):
    assert judge(["node", str(sources.HERE / "flight.js")], family).passed


@needs_c
def test_all_rows_are_mistakes_of_their_program(folder):
    command = [sources.built(sources.HERE / "ballistics.c", folder), "--list"]
    known = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    for subject in sources.planted("both", folder):
        program, _, names = subject.name.partition(" ")
        if isinstance(subject.answers, sources.Mutated):
            continue
        for name in names.split("+"):
            text = (sources.HERE / program).read_text(encoding="utf-8")
            assert (
                name in known if program == "ballistics.c" else re.search(f"['\"]{name}['\"]", text)
            )


def test_the_lab_is_right_and_every_edit_of_it_changes_it():
    file = sources.HERE / "at_bat_lab.py"
    for author, count in (("at_bat_lab", 200), ("batter", 20)):
        rows = json.loads(file.with_name(f"{author}.json").read_text(encoding="utf-8"))
        assert len(rows) > count
        edited = {sources.edited_lab(row["edits"]) for row in rows.values()}  # each has a place
        assert len(edited - {file.read_text(encoding="utf-8")}) == len(rows)
    cases = sources.golden(sources.EVERYTHING, 2)
    answers = sources.Program([sys.executable, str(file)])(cases)
    assert all(compare(case, answers[case.id], Converged(1e-7)).passed for case in cases)
