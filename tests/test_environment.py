"""The command line as a process: streams, encodings, signals, odd input."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import pytest

from longball.engines.ivp import Ivp
from longball.engines.lines import solve_lines
from longball.model.jsonl import LONGEST_LINE

FLIGHT = b'{"id":"f","kind":"flight","launch":{"position":[0,0,1],"velocity":[30,2,20]}}\n'
LONGBALL = [sys.executable, "-m", "longball"]
PATIENCE = 600.0  # s: what hangs ends then; on a busy machine a process takes minutes


def longball(*arguments: str, **options) -> subprocess.CompletedProcess:
    given = {"stdin": subprocess.DEVNULL, "capture_output": True, "timeout": PATIENCE} | options
    if "input" in given:
        del given["stdin"]
    return subprocess.run([*LONGBALL, *arguments], check=False, **given)


def shell(line: str, folder: Path) -> subprocess.CompletedProcess:
    return subprocess.run(
        ["sh", "-c", line.replace("longball", f"'{sys.executable}' -m longball")],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )


# --- streams and encodings ------------------------------------------------------------------------


def test_output_is_utf_8_whatever_the_locale():
    run = longball(
        *("readings", "--samples", "0"),
        env={**os.environ, "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"},
    )
    assert run.returncode == 0, run.stderr
    assert any(ord(c) > 255 for c in run.stdout.decode())
    assert "bat_ball_restitution" in run.stdout.decode()


@pytest.mark.parametrize(
    ("line", "status", "said"),
    [
        ("longball solve <&-", 2, b"longball: standard input: is closed\n"),
        ("longball fit - <&-", 2, b"cannot be read: is closed\n"),
        ("longball solve scenes.jsonl >&-", 2, b"longball: standard output: is closed\n"),
        ("longball readings --samples 0 >&-", 2, b"longball: standard output: is closed\n"),
        ("longball solve scenes.jsonl -o results.jsonl <&- >&- 2>&-", 0, b""),
        ("longball solve nowhere.jsonl 2>&-", 2, b""),
    ],
)
@pytest.mark.sampled(every=3)
def test_closed_streams(tmp_path: Path, line: str, status: int, said: bytes):
    (tmp_path / "scenes.jsonl").write_bytes(FLIGHT)
    run = shell(line, tmp_path)
    assert run.returncode == status
    assert run.stderr.endswith(said)
    assert b"Traceback" not in run.stderr
    if "-o" in line:
        assert b'"landed"' in (tmp_path / "results.jsonl").read_bytes()


@pytest.mark.parametrize(
    "line",
    [
        "longball solve - -o scenes.jsonl < scenes.jsonl",
        "longball solve - >> scenes.jsonl < scenes.jsonl",
        "longball solve scenes.jsonl >> scenes.jsonl",
    ],
)
@pytest.mark.sampled(every=3)
def test_the_source_is_not_overwritten(tmp_path: Path, line: str):
    source = tmp_path / "scenes.jsonl"
    source.write_bytes(FLIGHT)
    run = shell(line, tmp_path)
    assert run.returncode == 2
    assert b"is also the input" in run.stderr
    assert source.read_bytes() == FLIGHT


@pytest.mark.nightly
def test_a_disk_that_is_full_is_named():
    if not Path("/dev/full").exists():
        pytest.skip("this system has no /dev/full")
    with open("/dev/full", "wb") as full:
        run = longball("solve", input=FLIGHT, capture_output=False, stdout=full, stderr=-1)
    assert run.returncode == 2
    assert os.strerror(errno.ENOSPC).encode() in run.stderr
    assert b"Traceback" not in run.stderr


@pytest.mark.parametrize("engine", ["ivp", "batch"])
@pytest.mark.sampled(every=2)
def test_a_line_is_answered_before_the_next_is_read(engine: str):
    with subprocess.Popen(
        [*LONGBALL, "solve", "--engine", engine],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as process:
        for _ in range(3):
            process.stdin.write(FLIGHT)
            process.stdin.flush()
            assert json.loads(process.stdout.readline())["outcome"] == "landed"
        process.stdin.close()
        assert process.wait(timeout=PATIENCE) == 0


def test_a_reader_that_leaves_early_is_no_traceback():
    with subprocess.Popen(
        [*LONGBALL, "solve"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        process.stdin.write(FLIGHT)
        process.stdin.flush()
        process.stdout.readline()
        process.stdout.close()
        process.stdin.write(FLIGHT)
        process.stdin.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=PATIENCE) == 0


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["--help"], 0),
        (["judge", "--golden", "flight-weightless", "--results", os.devnull], 1),
    ],
)
@pytest.mark.sampled(every=2)
def test_a_reader_that_has_left_changes_no_status(arguments: list[str], status: int):
    reader, writer = os.pipe()
    os.close(reader)
    run = longball(*arguments, capture_output=False, stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert run.returncode == status
    assert b"Broken" not in run.stderr


def test_a_wrong_call_says_what_it_says_in_this_process(called):
    run, same = longball("solve", "--rtol", "1e-20"), called("solve", "--rtol", "1e-20")
    assert (run.returncode, run.stdout) == (2, b"")
    # Before it may stand how to call the program, whose name is another here.
    assert run.stderr.decode().splitlines()[-1] == same.stderr.splitlines()[-1]


# --- lines ----------------------------------------------------------------------------------------


class Endless(BytesIO):
    """A long line without end, before a scene."""

    def __init__(self, size: int) -> None:
        super().__init__(b"\n" + FLIGHT)
        self.left = size

    def read1(self, size: int = -1) -> bytes:
        if self.left <= 0:
            return super().read1(size)
        self.left -= size
        return b"x" * size


@pytest.mark.parametrize("workers", [1, 2])
def test_a_line_has_a_limit(workers: int):
    long, flight = solve_lines(Endless(5 * LONGEST_LINE), Ivp(), workers)
    assert long.failure == f"line 1: longer than {LONGEST_LINE:,} bytes"
    assert (long.id, flight.id, flight.failure) == ("1", "f", None)


def test_ids_given_twice_are_told(called):
    run = called("solve", stdin=FLIGHT * 3 + FLIGHT.replace(b'"f"', b'"g"'))
    assert run.returncode == 0
    assert run.stderr == "longball: 1 id is on more than one line, such as 'f'\n"
    assert len(run.stdout.splitlines()) == 4


def test_no_id_breaks_a_line(called):
    name = "a\x85b\u2028c\u2029d\ne"
    scene = json.loads(FLIGHT) | {"id": name}
    run = called("solve", stdin=json.dumps(scene, ensure_ascii=False).encode())
    (line,) = run.stdout.splitlines()
    assert json.loads(line)["id"] == name


# --- signals --------------------------------------------------------------------------------------


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
class TestSignals:
    def start(self, *arguments: str) -> subprocess.Popen:
        return subprocess.Popen(
            [*LONGBALL, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            preexec_fn=hear_interrupts,
        )

    @pytest.mark.parametrize(
        ("workers", "number", "said"),
        [
            ("1", signal.SIGINT, b"interrupted"),
            ("2", signal.SIGINT, b"interrupted"),
            ("2", signal.SIGTERM, b"terminated"),
        ],
    )
    @pytest.mark.sampled(every=3)
    def test_end_a_run(self, workers: str, number: signal.Signals, said: bytes):
        with self.start("solve", "--workers", workers) as process:
            process.stdin.write(FLIGHT * 100)
            process.stdin.flush()
            # Two workers answer when they have their share; the program is at work then, or waits.
            if workers == "1":
                process.stdout.readline()
            else:
                while not children(process.pid):
                    assert process.poll() is None
            os.killpg(process.pid, number)
            # Worker processes hold the streams open: this waits for them, too.
            _, words = process.communicate(timeout=PATIENCE)
        assert process.returncode == 128 + number
        assert words == b"longball: " + said + b"\n"

    @pytest.mark.parametrize("name", ["typer", "longball.cli.fit", "numpy"])
    @pytest.mark.sampled(every=3)
    def test_end_imports_without_a_word(self, name: str):
        code = (
            "import os, signal, sys\n"
            "class Finder:\n"
            "    def find_spec(self, name, path=None, target=None):\n"
            "        if name == sys.argv[2]: os.kill(os.getpid(), signal.SIGINT)\n"
            "sys.meta_path.insert(0, Finder())\n"
            "from longball.__main__ import main\n"
            "main()\n"
        )
        run = subprocess.run(
            [sys.executable, "-c", code, "fit", name],
            capture_output=True,
            check=False,
            preexec_fn=hear_interrupts,
        )
        assert run.returncode == -signal.SIGINT
        assert run.stderr == b""


def hear_interrupts() -> None:
    """Undo what a shell does for jobs in the background: they ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def children(pid: int) -> bool:
    """True if a process has started worker processes."""
    found = subprocess.run(["ps", "-axwwo", "pgid,args"], capture_output=True, check=True).stdout
    lines = (line.split(maxsplit=1) for line in found.decode().splitlines()[1:])
    return any(int(group) == pid and "popen_loky" in args for group, args in lines)
