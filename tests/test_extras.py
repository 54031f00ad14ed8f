"""An installation without the extras: what needs one says so, all else is the same."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from longball.extras import EXTRAS
from longball.golden import writer
from longball.golden.files import write_files
from longball.golden.reader import DATA
from tests.golden.test_writing import SMALL
from tests.test_environment import PATIENCE

AT_BAT = '{"id": "a", "kind": "at-bat"}'
BLOCK = "import sys\nfor name in {names!r}: sys.modules[name] = None\n"


LAUNCH = {"position": [0.3, 0, 1], "velocity": [38, 4, 27], "spin": [20, -180, 40]}
LIFT = {"law": "rational", "numerator": 1, "constant": 0.4, "slope": 2.3}
AIR = {
    "drag_coefficient": {"law": "table", "of": "speed", "at": [25, 40], "values": [0.5, 0.3]},
    "lift_coefficient": LIFT,
    "wind": {"velocity": [4, 1, 0], "height": 10},
    "spin_decay_length": 600,
}
# A step below the ground has no logarithmic wind.
FLIGHT = json.dumps({"kind": "flight", "launch": LAUNCH, "air": AIR, "time_limit": 3})
SCENES = f"{AT_BAT}\n{FLIGHT}"


def light(code: str, *arguments: str, names: tuple[str, ...] = tuple(EXTRAS), lines: str = AT_BAT):
    return subprocess.run(
        [sys.executable, "-c", BLOCK.format(names=names) + code, *arguments],
        input=lines,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


def command_line(*arguments: str, **options) -> subprocess.CompletedProcess:
    return light("from longball.__main__ import main; main()", *arguments, **options)


@pytest.mark.parametrize(
    ("engine", "lines"),
    [
        ("ivp", AT_BAT),
        *(
            pytest.param(*case, marks=pytest.mark.nightly)  # to compile takes seconds a law
            for case in (
                ("ivp", SCENES),
                ("verlet", SCENES),
                ("enclosure", AT_BAT),
                ("multiprecision", AT_BAT),
            )
        ),
    ],
)
def test_engines_give_the_same_bits(engine: str, lines: str):
    run = command_line("solve", "--engine", engine, lines=lines)
    whole = light(
        "from longball.engines.compiled import compile_at_once; compile_at_once()\n"
        "from longball.__main__ import main; main()",
        "solve", "--engine", engine, names=(), lines=lines,
    )  # fmt: skip
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == whole.stdout
    assert "error" not in run.stdout


@pytest.mark.nightly
def test_the_judge_and_the_golden_data(tmp_path: Path):
    # The reference itself is judged, as anybody's simulator would be.
    (tmp_path / "run.py").write_text(
        BLOCK.format(names=tuple(EXTRAS)) + "from longball.__main__ import main; main()"
    )
    candidate = [sys.executable, str(tmp_path / "run.py"), "solve"]
    run = command_line("judge", "--golden", "flight-weightless", "--", *candidate)
    assert run.returncode == 0, run.stdout + run.stderr
    assert run.stdout.startswith("PASSED")
    small = tmp_path / "golden"
    writer.write(small, SMALL)
    write_files(small, {"probability.json": (DATA / "probability.json").read_text("utf-8")})
    run = command_line("golden", "check", str(small))
    assert (run.returncode, run.stdout) == (0, ""), run.stderr
    assert "; 3 solved again" in run.stderr
    assert "P(e) is not integrated again" in run.stderr


def test_the_library():
    code = (
        "import longball as lb\n"
        "result = lb.solve(lb.AtBat())\n"
        "assert result.path.at(0.1).position.shape == (3,)\n"
        "assert lb.solve_many([lb.AtBat()], engine='ivp')[0].outcome == result.outcome\n"
        "lb.judge.assert_case(lb.golden.load('pitch')[0], lb.golden.load('pitch')[0].expected)\n"
        "try: result.path.sample()\n"
        "except ImportError as error: print(error)\n"
    )
    run = light(code)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == 'this needs pandas: pip install ".[tables]"\n'


# Calls of the command line in one process, each with its exit status and its words.
CALLS = """
import contextlib, io, json, os
from longball.__main__ import main
os.chdir(sys.argv[1])
scenes, answers = sys.stdin.buffer.read(), []
for arguments in json.loads(sys.argv[2]):
    sys.argv, sys.stdin = ["longball", *arguments], io.TextIOWrapper(io.BytesIO(scenes))
    with contextlib.redirect_stderr(io.StringIO()) as words:
        try: main()
        except SystemExit as left: answers.append([left.code, words.getvalue()])
print(json.dumps(answers))
"""
MISSING = {
    "fast": [
        ["solve", "--engine", "batch"],
        ["solve", "--workers", "2"],
        ["homerun", "--samples", "10"],
        ["homerun", "--method", "quadrature"],
        ["readings", "--samples", "10"],
        ["golden", "write", "nowhere"],
        ["golden", "check", "--workers", "2"],
        ["measured", "--example"],
    ],
    "tables": [
        ["fit", "--example"],
        ["solve", "-o", "x.csv"],
        ["solve", "-o", "x.parquet"],
        ["measured", "--example", "--engine", "ivp"],
    ],
    "plot": [
        ["homerun", "--samples", "5", "--figure", "x.png"],
        ["plot"],
        ["judge", "--html", "x.html", "--", "true"],
    ],
    "dask": [
        ["solve", "--scheduler", "tcp://127.0.0.1:1"],
        ["homerun", "--scheduler", "tcp://127.0.0.1:1"],
    ],
}


@pytest.mark.parametrize("extra", MISSING)
@pytest.mark.sampled(every=2)
def test_what_is_missing_is_named(extra: str, tmp_path: Path):
    names = tuple(name for name, its in EXTRAS.items() if its == extra)
    run = light(CALLS, str(tmp_path), json.dumps(MISSING[extra]), names=names)
    assert run.returncode == 0, run.stderr
    answers = json.loads(run.stdout.splitlines()[-1])
    for arguments, (status, words) in zip(MISSING[extra], answers, strict=True):
        assert status == 2, arguments
        assert f'pip install ".[{extra}]"' in words, arguments
        assert len(words.splitlines()) == 1, arguments
        assert "llvmlite" not in words, arguments  # which numba brings


@pytest.mark.nightly
def test_samples_are_struck_by_an_engine_that_needs_none():
    run = command_line("homerun", "--samples", "3", "--e", "0.42", "--engine", "ivp")
    assert (run.returncode, run.stderr) == (0, "")


def test_a_module_that_is_run_names_what_is_missing():
    run = light("import runpy; runpy.run_module('longball.model.derivation', run_name='__main__')")
    assert run.stderr == 'this needs sympy: pip install ".[symbolic]"\n'


def test_several_workers_are_one_if_not_asked_for():
    assert json.loads(command_line("solve", "--workers", "-1").stdout)["outcome"] == "batted"
