"""Options that stand in longball.toml, or in [tool.longball] of pyproject.toml."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

SCENE = b'{"id": "a", "kind": "pitch"}'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def engine(run) -> str:
    return json.loads(run.stdout)["engine"]


@pytest.mark.parametrize(
    ("file", "head"), [("longball.toml", "solve"), ("pyproject.toml", "tool.longball.solve")]
)
def test_a_file_gives_options_and_the_command_line_others(called, folder, file: str, head: str):
    (folder / file).write_text(f'[{head}]\nengine = "verlet"\ndt = 0.01\n')
    run = called("solve", stdin=SCENE)
    assert "dt=0.01" in engine(run)
    assert run.stderr == f"longball: {file} gives engine, dt\n"
    assert called("solve", "--quiet", stdin=SCENE).stderr == ""
    assert "dt=0.02" in engine(called("solve", "--dt", "0.02", stdin=SCENE))


def test_the_file_of_its_own_goes_first_and_others_stay_unread(called, folder):
    (folder / "pyproject.toml").write_text("[tool.other]\na = 1\n[tool.longball.solve]\ndt = 1.0\n")
    (folder / "longball.toml").write_text('[solve]\nengine = "batch"\n')
    assert "batch" in engine(called("solve", stdin=SCENE))
    (folder / "longball.toml").unlink()
    (folder / "pyproject.toml").write_text("[tool.other]\na = 1\n")
    assert called("solve", stdin=SCENE).stderr == ""


def test_what_the_command_line_gives_stands_for_what_excludes_it(called, folder):
    (folder / "longball.toml").write_text(
        '[judge]\ncommand = ["false"]\ngolden = ["hard"]\nkind = "pitch"\nformat = "json"\n'
    )
    verdict = json.loads(called("judge", "--random", "2").stdout)
    assert (verdict["candidate"], verdict["cases"]) == ("false", 2)
    assert verdict["truth"] == "proven values of 2 random pitch scenes, seed 1"
    (folder / "results.jsonl").write_text("")
    run = called("judge", "--random", "2", "--results", "results.jsonl")
    assert json.loads(run.stdout)["candidate"] == "results.jsonl"


# Files, whose lines are separated here by |, and what is said of them.
WRONG = """
[juge] -> longball.toml: juge: no such command, did you mean judge?
[judge]|tolerence = 1 -> judge.tolerence: no such option, did you mean tolerance?
[judge]|tolerance = [1, 2] -> judge.tolerance: takes one value, not a list
[judge]|partial = 1 -> judge.partial: must be true or false
[judge]|random = {n = 1} -> judge.random: must be a value, not a table
[judge]|command = "./a b" -> judge.command: must be a list of words, as [
judge = 1 -> judge: must be a table of options, [judge]
[judge]|tolerance = "x" -> longball.toml: judge.tolerance x: must be a number
[judge -> longball.toml: not TOML:
"""


def test_a_wrong_file_is_a_wrong_call(called, folder):
    for line in WRONG.strip().splitlines():
        text, _, said = line.partition(" -> ")
        (folder / "longball.toml").write_text(text.replace("|", "\n"))
        run = called("judge", "--", "true")
        assert (run.returncode, run.stdout) == (2, ""), text
        assert said in run.stderr
        assert called("judge", "--help").returncode == 0
