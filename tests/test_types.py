"""The sessions of README and documentation as type checkers see them."""

from __future__ import annotations

import doctest
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.test_docs import PAGES, ROOT, fences

pytest.importorskip("mypy")
SHOWN = [page for page in PAGES if fences(page, "pycon")]


def checked(folder: Path, programs: dict[str, str]) -> str:
    for name, program in programs.items():
        (folder / f"{name}.py").write_text(program, encoding="utf-8")
    run = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *(f"{name}.py" for name in programs)],
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ | {"MYPYPATH": str(ROOT / "reference")},
    )
    return run.stdout + run.stderr


def session(page: Path) -> str:
    """Return what is typed in a page, without what raises on purpose."""
    examples = doctest.DocTestParser().get_examples("\n\n".join(fences(page, "pycon")))
    return "".join(example.source for example in examples if example.exc_msg is None)


def test_what_pages_show_type_checks_and_mistakes_do_not(tmp_path: Path):
    pages = {f"page_{page.stem.replace('-', '_')}": session(page) for page in SHOWN}
    said = checked(tmp_path, pages | {"wrong": MISTAKES})
    lines = [line for line in said.splitlines() if "error:" in line]
    assert [line.partition(":")[2].partition(":")[0] for line in lines] == WRONG_LINES, said


MISTAKES = """import longball as lb

lb.AtBat(pich={"speed": 38.64})
lb.Flight()
lb.Flight(launch=lb.launch(speed="46", angle=0.5))
lb.solve(lb.Pitch()).landing.distnce
lb.Bat(mass="0.9")
"""
WRONG_LINES = ["3", "4", "5", "6", "7"]
