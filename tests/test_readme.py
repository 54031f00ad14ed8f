"""What the README shows is what the commands print."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FENCES = re.findall(r"```sh\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
SHOWN = [fence for fence in FENCES if fence.startswith("$ ") and "..." not in fence]
NUMBER = re.compile(r"-?\d+\.\d+(?:e[+-]?\d+)?")


@pytest.mark.parametrize("fence", SHOWN, ids=lambda fence: fence[2:40])
def test_a_command_prints_what_the_readme_shows(fence: str):
    command, shown = fence[2:].split("\n", 1)
    # `longball` and `python` are those of this environment, whatever the shell's path says.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    command = command.replace("longball ", f"{sys.executable} -m longball ")
    printed = subprocess.run(
        ["bash", "-c", command],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
        cwd=ROOT,
        env=os.environ | {"PATH": path},
    ).stdout
    assert NUMBER.sub("#", printed) == NUMBER.sub("#", shown)
    # The last digits are the machine's: its mathematical library may round another way.
    numbers = [float(text) for text in NUMBER.findall(printed)]
    assert numbers == pytest.approx([float(text) for text in NUMBER.findall(shown)], rel=1e-9)


def test_there_are_commands_to_try():
    assert len(SHOWN) >= 2


def test_what_the_readme_points_to_is_there():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert target.startswith("http") or (ROOT / target).exists(), target
