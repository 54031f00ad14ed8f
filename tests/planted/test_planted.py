"""The planted programs pass without a mistake, and a few mistakes are told."""

import re
import shutil
import subprocess

import pytest

from longball.judge import judge
from tests.planted import trial

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")


@pytest.fixture(scope="module")
def binary(tmp_path_factory):
    return trial.build(tmp_path_factory.mktemp("planted"))


@pytest.mark.parametrize(
    "name",
    [
        "normal_in_three", "contact_on_surface", "no_drag_descending", "rk4_frozen_speed",
        "gravity_or_default", "friction_tangential_default",
    ],
)  # fmt: skip
def test_mistake_is_explained(binary, name):
    row = next(row for row in trial.mistakes() if row["name"] == name)
    grade = trial.grade(row, trial.judged(row, binary))
    assert grade.stage
    assert grade.explained
    assert not grade.false_name


BY_THE_PROGRAM_IN_C = [
    *trial.PAPER,
    "flight-spin-lift",
    "flight-weather",
    "impact-oblique",
    "fence",
]


@pytest.mark.parametrize("family", BY_THE_PROGRAM_IN_C)
def test_without_a_mistake_the_program_in_c_is_right_to_the_digits_of_doubles(binary, family):
    assert judge([str(binary)], family).passed


@pytest.mark.skipif(shutil.which("node") is None, reason="there is no Node")
@pytest.mark.parametrize("family", trial.PAPER)
def test_without_a_mistake_the_program_in_javascript_is_right_to_the_digits_of_doubles(family):
    assert judge(["node", str(trial.HERE / "flight.js")], family).passed


def test_all_rows_are_mistakes_of_their_program(binary):
    known = subprocess.run(
        [binary, "--list"], capture_output=True, text=True, check=True
    ).stdout.split()
    sources = {
        name: (trial.HERE / name).read_text(encoding="utf-8") for name in ("flight.js", "batter.py")
    }
    for row in trial.mistakes():
        for name in row["name"].split("+"):
            if row["program"] == "ballistics.c":
                assert name in known
            else:
                assert re.search(f"['\"]{name}['\"]", sources[row["program"]])
