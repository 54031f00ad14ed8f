"""Type checks of the package and of the code in README and documentation, for `make lint`.

No tests: mypy and pyright take ten seconds and more, so that each is started once, for all pages.
For those it needs the package's types, which mypy therefore checks in the same run.
"""

from __future__ import annotations

import doctest
import json
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
    "mypy": ["mypy", "reference", "analysis"],
    "pyright": ["basedpyright", "--level", "error", "--pythonpath", sys.executable, "--project"],
}
SETTINGS = {"extraPaths": [str(ROOT / "reference")], "typeCheckingMode": "standard"}


def session(page: Path) -> str:
    """Return the Python input of a page, without the lines that raise on purpose."""
    examples = doctest.DocTestParser().get_examples("\n\n".join(fences(page, "pycon")))
    return "".join(example.source for example in examples if example.exc_msg is None)


def main(checker: str) -> int:
    """Check the pages, and by mypy the package too; print what is wrong, and return 1 if so."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for page in PAGES:
            program = folder / f"page_{page.stem.replace('-', '_')}.py"
            program.write_text(session(page), encoding="utf-8")
        (folder / "wrong.py").write_text(MISTAKES, encoding="utf-8")
        (folder / "pyrightconfig.json").write_text(json.dumps(SETTINGS), encoding="utf-8")
        command = [sys.executable, "-m", *CHECKERS[checker], name]
        run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    found = re.findall(r"(\w+\.py):(\d+)(?::\d+)?(?: -|:) error", run.stdout)
    errors = {(file, int(line)) for file, line in found}
    if errors == WRONG:
        return 0
    missed = sorted(line for _, line in WRONG - errors)
    print(f"{checker}: lines of wrong.py that it accepts: {missed}")
    print(run.stdout, run.stderr, sep="")
    return 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
