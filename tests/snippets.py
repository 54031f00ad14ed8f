"""Type checks of the code in README and documentation; `make lint` runs them.

No tests: mypy and pyright take ten seconds each, so that each is started once, for all pages, and
both at the same time.
"""

from __future__ import annotations

import doctest
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.test_docs import PAGES, ROOT, fences

# Lines that both must refuse, each for the reason beside it.
MISTAKES = """import longball as lb

lb.AtBat(pich={"speed": 38.64})  # no such block
lb.AtBat(pitch={"sped": 38.64})  # no such key of a block
lb.AtBat(pitch={"speed": "38.64"})  # a text
lb.AtBat(air={"drag_coefficient": {"law": "crises"}})  # no such law
lb.Flight()  # without a launch
lb.Flight(launch={"position": [0, 0, 1]})  # a launch without a velocity
lb.Flight(launch=lb.launch(speed="46", angle=0.5))
lb.solve(lb.AtBat()).landing.distance  # a miss has no landing
lb.solve({"kind": "at-bat"}).contact.time
lb.solve('{"kind": "flight"}').landing.distance  # of a line nothing is known
lb.solve(lb.Flight(launch=lb.launch(46.0, 0.5))).landing.distnce
lb.solve({"kind": "flight", "launch": lb.launch(46.0, 0.5)}).contact.time  # nor has a flight
lb.solve(lb.Pitch()).landing.distance  # a pitch does not land
lb.solve({"kind": "pitch", "pitch": {"speed": 38.64}}).plate.tme
lb.solve(42)
lb.Bat(mass="0.9")
"""
WRONG = {("wrong.py", i) for i, line in enumerate(MISTAKES.splitlines(), 1) if line[:3] == "lb."}

CHECKERS = {
    "mypy": ["-m", "mypy", "--strict", "."],
    "pyright": ["-m", "basedpyright", "--level", "error", "--pythonpath", sys.executable, "."],
}
SETTINGS = {"extraPaths": [str(ROOT / "reference")], "typeCheckingMode": "standard"}


def session(page: Path) -> str:
    """Return the Python input of a page, without the lines that raise on purpose."""
    examples = doctest.DocTestParser().get_examples("\n\n".join(fences(page, "pycon")))
    return "".join(example.source for example in examples if example.exc_msg is None)


def main() -> int:
    """Check all pages by both; print what is wrong, and return how many of the checkers fail."""
    failed = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for page in PAGES:
            program = folder / f"page_{page.stem.replace('-', '_')}.py"
            program.write_text(session(page), encoding="utf-8")
        (folder / "wrong.py").write_text(MISTAKES, encoding="utf-8")
        (folder / "pyrightconfig.json").write_text(json.dumps(SETTINGS), encoding="utf-8")
        runs = {
            checker: subprocess.Popen(
                [sys.executable, *command],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                cwd=folder,
                env=os.environ | {"MYPYPATH": str(ROOT / "reference")},
            )
            for checker, command in CHECKERS.items()
        }
        for checker, run in runs.items():
            output, _ = run.communicate()
            found = re.findall(r"(\w+\.py):(\d+)(?::\d+)?(?: -|:) error", output)
            errors = {(file, int(line)) for file, line in found}
            if errors != WRONG:
                failed += 1
                missed = sorted(line for _, line in WRONG - errors)
                print(f"{checker}: lines of wrong.py that it accepts: {missed}")
                print(output)
    return failed


if __name__ == "__main__":
    sys.exit(main())
