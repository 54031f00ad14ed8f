"""The README and the documentation show the output that longball prints.

A fence `console` holds commands after "$ " with what they print, a fence `pycon` holds a session of
Python; "..." stands for any text. The fences of one page are one session.
"""

from __future__ import annotations

import csv
import doctest
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from longball.cli import COMMANDS
from longball.judge.diagnosis.residual import NOISE
from longball.judge.diagnosis.search import ALONE
from tests.test_environment import PATIENCE

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Templates hold links of the report, where they are checked.
LINKED = sorted(
    page
    for folder in (
        ".",
        "docs",
        "report",
        "tests",
        "tests/planted",
        "reference/longball/golden/data",
    )
    for page in (ROOT / folder).glob("*.md")
)
NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[+-]?\d+)?")
# The last digits are the machine's: its mathematical library may round another way.
DIGITS = 1e-9


def fences(page: Path, language: str) -> list[str]:
    if language == "pycon":  # pictures are drawn by sessions, too
        language = r"(?:pycon|\{eval-rst\}\n\.\. plot::)"
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.S)


def commands(page: Path) -> list[tuple[str, str]]:
    """Return commands and what they print."""
    return [
        (command, shown)
        for fence in fences(page, "console")
        for command, _, shown in (
            part.partition("\n") for part in re.split(r"^\$ ", fence, flags=re.M)[1:]
        )
    ]


def same(shown: str, printed: str) -> bool:
    """True if two texts are equal but for the last digits of their numbers."""
    pattern = re.escape(NUMBER.sub("\0", shown.strip())).replace(r"\.\.\.", "(?:.*)")
    pattern = pattern.replace("\0", f"({NUMBER.pattern})")
    match = re.fullmatch(pattern, printed.strip(), re.S)
    if match is None:
        return False
    expected = [float(text) for text in NUMBER.findall(shown)]
    return [float(text) for text in match.groups()] == pytest.approx(expected, rel=DIGITS)


class Checker(doctest.OutputChecker):
    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        return same(" ".join(want.split()), " ".join(got.split()))


NIGHTLY = pytest.mark.nightly


@pytest.mark.parametrize(
    ("command", "shown"),
    # What two pages show is run once.
    [
        pytest.param(
            *case,
            id=f"{page.stem}: {case[0][:50]}",
            # The README's are run by day, but for verdicts, which take ten seconds.
            marks=() if page.stem == "README" and " judge " not in case[0] else NIGHTLY,
        )
        for case, page in {case: page for page in PAGES for case in commands(page)}.items()
    ],
)
def test_a_command_prints_what_the_page_shows(command: str, shown: str):
    # `longball` and `python` are those of this environment, whatever the shell's path says.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    printed = subprocess.run(
        ["bash", "-c", re.sub(r"\blongball (?=\w)", f"{sys.executable} -m longball ", command)],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        cwd=ROOT,
        env=os.environ | {"PATH": path},
    )
    assert same(shown, printed.stdout), printed.stdout + printed.stderr


@pytest.mark.parametrize(
    "page", [p for p in PAGES if fences(p, "pycon")], ids=lambda page: page.stem
)
def test_a_session_prints_what_the_page_shows(page: Path):
    session = "\n\n".join(fences(page, "pycon"))
    example = doctest.DocTestParser().get_doctest(session, {}, page.name, str(page), 0)
    told: list[str] = []
    doctest.DocTestRunner(Checker()).run(example, out=told.append)
    assert not told, "".join(told)


def prose(page: Path) -> str:
    """Return a page without its fences."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page, as GitHub and MyST derive them from headings."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_link_leads_somewhere():
    for page in LINKED:
        for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
            if target.startswith("http"):
                continue
            file, _, anchor = target.partition("#")
            assert (page.parent / file).exists(), (page, target)
            assert not anchor or anchor in anchors(page.parent / file if file else page), target


def test_the_readme_quotes_the_report():
    methods = {
        "longball `batch`": ("batch", "1e-13 m"),
        "longball `ivp` (default)": ("ivp Taylor", "default"),
        "longball `enclosure`, 30 digits, proven": ("enclosure", "30 digits"),
        "heyoka, batches of 16": ("heyoka batch", "default"),
        "diffrax, Dopri8 at 1e-12": ("diffrax Dopri8", "1e-12"),
        "CVODE, Adams at 1e-12": ("CVODE Adams", "1e-12"),
        "plain `solve_ivp`, DOP853 at 1e-12": ("scipy DOP853", "1e-12"),
    }
    with (ROOT / "report/tables/speed_error.csv").open(encoding="utf-8", newline="") as file:
        table = {(row["work"], row["method"], row["setting"]): row for row in csv.DictReader(file)}
    quoted = re.findall(
        r"^\| (.*) \| ([\d.,]+) \| ([\d.e-]+) \| (\d+) % \|$", prose(PAGES[0]), re.M
    )
    assert [name for name, *_ in quoted] == list(methods)
    for name, time, error, missed in quoted:
        flight, at_bat = table["flight", *methods[name]], table["at-bat", *methods[name]]
        # Rounding to two digits changes a number by a twentieth at most.
        assert float(time.replace(",", "")) == pytest.approx(
            float(flight["time each, µs"]), rel=0.02
        )
        assert float(error) == pytest.approx(float(flight["worst error, m"]), rel=0.05)
        share = 100 * int(at_bat["missed"]) / int(at_bat["contacts"])
        assert int(missed) == pytest.approx(share, abs=0.5)


@pytest.mark.parametrize(
    "scene",
    [
        {"kind": "pitch"},
        {"kind": "flight", "reading": {"ground_contact": "surface"}},
        {"kind": "flight", "reading": {}, "air": {"wind": [1, 0, 0]}, "launch": {}},
        {"kind": "flight", "reading": {}, "air": {"density": {}}, "launch": {}},
        {"kind": "flight", "reading": {}, "air": None, "launch": {"spin": [0, 200, 0]}},
        {"kind": "flight", "reading": {}, "air": None, "launch": {}, "fence": {"radius": 90}},
    ],
    ids=["kind", "reading", "wind", "weather", "spin", "fence"],
)
def test_the_candidate_refuses_what_it_does_not_solve(scene: dict[str, object]):
    asked = json.dumps({"id": "a", **scene})
    command = [sys.executable, str(ROOT / "docs/candidate.py")]
    answer = subprocess.run(command, input=asked, capture_output=True, text=True, check=True)
    assert json.loads(answer.stdout).keys() == {"id", "error"}


def test_the_tutorials_test_of_a_simulator_passes(tmp_path: Path):
    (test,) = (x for x in fences(ROOT / "docs/tutorial-simulator.md", "python") if "pytest" in x)
    (tmp_path / "my_simulator.py").write_bytes((ROOT / "docs/candidate.py").read_bytes())
    (tmp_path / "test_it.py").write_text(test, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-k", "000", "test_it.py"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert " passed" in ran.stdout, ran.stdout
    assert ran.returncode == 0


def test_there_is_something_to_try():
    assert sum(len(commands(page)) for page in PAGES) >= 5


def test_the_page_on_trust_has_the_numbers_of_the_judge():
    page = " ".join((ROOT / "docs/truth.md").read_text(encoding="utf-8").split())
    small, cheap, others = ALONE
    assert f"the first {small.edits.stop:,} edits, then the first {cheap.edits.stop:,}" in page
    assert f"at most {others.edits.stop - others.edits.start:,} others" in page
    assert f"{small.tried} of the first layer or the {cheap.tried} of a later one" in page
    assert f"max(tolerance, {NOISE:g} · max(|x|, 1))" in page


def test_help_has_an_example_and_names_the_form_of_every_value(called):
    """A reader of `--scenes TEXT` does not know that a file is meant."""
    for command in ("", "golden", *COMMANDS):
        shown = called(*command.split(), "--help").stdout
        assert "Example: " in shown, command
        assert " TEXT" not in shown, command
