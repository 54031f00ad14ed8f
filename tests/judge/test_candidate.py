"""Candidates that misbehave in every way: judged by what they answered, and gone afterwards.

Where a candidate is expected to succeed the limits are generous; where it hangs they are small.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from longball.judge.answers import LONGEST_LINE, split_lines
from longball.judge.candidate import Limits, Run, run
from longball.model.scene import FlightScene, Launch

GENEROUS = Limits(scene_seconds=60, total_seconds=120)
HASTY = Limits(scene_seconds=1.0, total_seconds=60)


def scenes(count: int = 5) -> list[FlightScene]:
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(30.0, 0.0, 20.0))
    return [FlightScene(id=f"s{i}", launch=launch) for i in range(count)]


def python(program: str, limits: Limits = GENEROUS, count: int = 5) -> Run:
    """Run a candidate that is written in a few lines; `say` answers an id."""
    start = (
        "import json, os, sys, time\n"
        "def say(id):\n"
        "    print(json.dumps({'id': id, 'outcome': 'landed', 'landing': {'distance': 1.5}}),\n"
        "          flush=True)\n"
        "def ids():\n"
        "    for line in sys.stdin:\n"
        "        yield json.loads(line)['id']\n"
    )
    return run([sys.executable, "-I", "-S", "-c", start + program], scenes(count), limits)


def said(ran: Run) -> str:
    return "\n".join(str(issue) for issue in ran.collected.issues)


def answered(ran: Run) -> list[str]:
    return sorted(ran.collected.answers)


EVERY = "for id in ids(): say(id)"
CHILD = "if os.fork() == 0: time.sleep(600)\nos._exit"
REFUSING = (
    "for i in range(4): say(f's{i}')\nprint(json.dumps({'id': 's4', 'error': 'no'}))\nsys.exit"
)
FLOOD = Limits(scene_seconds=60, total_seconds=120, output_bytes=1 << 21)

# What a candidate does, in which limits, how many scenes it has then answered, and what is said.
CONDUCT = {
    "answers": (EVERY, GENEROUS, 5, ""),
    "in any order": ("for id in reversed(list(ids())): say(id)", GENEROUS, 5, ""),
    "hangs": ("say('s0'); say('s1'); time.sleep(600)", HASTY, 2,
              "no answer came for 1 s, and was stopped; it answered 2 of 5 scenes"),
    "hangs with its output closed": (
        "say('s0'); sys.stdout.flush(); os.close(1); time.sleep(600)", HASTY, 1,
        "closed its output, but did not end within 1 s, and was stopped"),
    "hangs after the last answer": (f"{EVERY}\ntime.sleep(600)", HASTY, 5,
                                    "did not end within 1 s after its last answer"),
    "prints rubbish for ever": (
        "say('s0')\nwhile True: print('thinking', flush=True); time.sleep(.05)", HASTY, 1,
        "no answer came for 1 s"),
    "crashes": ("list(ids()); say('s0'); say('s1'); os.abort()", GENEROUS, 2,
                "was ended by signal SIGABRT; it answered 2 of 5 scenes"),
    "ends early": ("list(ids()); say('s0'); sys.exit(3)", GENEROUS, 1,
                   "ended with status 3; it answered 1 of 5 scenes"),
    "ends with a status": (f"{EVERY}\nsys.exit(3)", GENEROUS, 5,
                           "it ended with status 3; it answered 5 of 5 scenes"),
    "crashes in the end": (f"{EVERY}\nos.abort()", GENEROUS, 5,
                           "it was ended by signal SIGABRT; it answered 5 of 5 scenes"),
    # As `longball solve` does: 1 says that a line could not be solved.
    "refuses with 0": (f"{REFUSING}(0)", GENEROUS, 5, ""),
    "refuses with 1": (f"{REFUSING}(1)", GENEROUS, 5, ""),
    "refuses with 2": (f"{REFUSING}(2)", GENEROUS, 5, "it ended with status 2"),
    # Its child holds the pipe.
    **{f"leaves a child, {answered} answers, status {status}": (
        f"{answers}\n{CHILD}({status})", HASTY, answered,
        f"it ended with status {status}, but a process that it had started held its output open")
       for answers, status, answered in (("say('s0')", 0, 1), (EVERY, 0, 5), ("say('s0')", 4, 1))},
    "floods": ("say('s0')\nwhile True: os.write(1, b'spam' * 10000 + b'\\n')", FLOOD, 1,
               "wrote more than 2097152 bytes, and was stopped"),
}  # fmt: skip


@pytest.mark.parametrize("conduct", CONDUCT)
def test_what_was_answered_counts_and_the_rest_is_told(conduct: str):
    program, limits, count, sentence = CONDUCT[conduct]
    ran = python(program, limits)
    assert answered(ran) == [f"s{i}" for i in range(count)]
    assert sentence in said(ran)
    assert bool(said(ran)) == bool(sentence)
    assert (ran.status is None) == any(x in said(ran) for x in ("stopped", "last answer", "held"))
    # One end is told, not two.
    assert ("no answer came" in said(ran)) == ("no answer came" in sentence)
    assert len(ran.collected.issues) < 50


def test_the_time_in_all_is_limited():
    limits = Limits(scene_seconds=60, total_seconds=1.5)
    ran = python("for id in ids(): time.sleep(.5); say(id)", limits, count=1000)
    assert "took more than 1.5 s in all, and was stopped" in said(ran)


def test_no_deadlock_when_everything_is_read_first_or_answered_before_reading():
    # Both pipes are filled many times over: a pipe holds 64 KiB, these scenes are 2 MB.
    count = 5000
    ran = python("all = list(ids())\nfor id in all: say(id)", count=count)
    assert (len(answered(ran)), said(ran)) == (count, "")
    ran = python(f"for i in range({count}): say(f's{{i}}')\nfor id in ids(): pass", count=count)
    assert (len(answered(ran)), said(ran)) == (count, "")


def test_progress_is_told():
    told: list[int] = []
    program = 'import sys\nfor i in range(5): print(\'{"id": "s%d"}\' % i)'
    run([sys.executable, "-c", program], scenes(), GENEROUS, told.append)
    assert told == [1, 2, 3, 4, 5]


def test_an_input_that_is_closed_early_is_no_loss_of_answers():
    program = "os.close(0)\nfor i in range(3): say(f's{i}'); time.sleep(.1)"
    ran = python(program, count=5000)
    assert answered(ran) == ["s0", "s1", "s2"]
    assert "ended with status 0 before it had read all scenes; it answered 3 of 5000" in said(ran)


def test_a_line_without_end_takes_no_memory():
    ran = python(
        "say('s0')\n"
        "for _ in range(300): sys.stdout.write('x' * 65536)\n"
        "sys.stdout.write('\\n')\n"
        "say('s1')"
    )
    assert answered(ran) == ["s0", "s1"]
    assert f"line 2: longer than {LONGEST_LINE} bytes" in said(ran)


def test_lines_without_end_that_answer_nothing_are_stopped():
    ran = python("say('s0')\nwhile True: os.write(1, b'spam\\n' * 10000)")
    assert answered(ran) == ["s0"]
    assert "wrote more than 10000 lines that are no answers, and was stopped" in said(ran)
    assert "s1 is the first without an answer" in said(ran)
    assert len(ran.collected.issues) < 50
    assert ran.collected.left_out["rubbish"] > 1000


def test_a_flood_of_errors_is_read_and_forgotten():
    ran = python(
        "for id in ids():\n"
        "    os.write(2, b'warning\\n' * 100000)\n"
        "    say(id)\n"
        "os.write(2, b'the end\\n')"
    )
    assert (len(answered(ran)), said(ran)) == (5, "")
    assert len(ran.errors) <= GENEROUS.error_bytes
    assert ran.errors.endswith("the end\n")


def alive(pid: int) -> bool:
    """True if a process runs (a zombie that nobody reaps does not)."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{pid}/stat")
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] != "Z"


def gone(pid: int) -> bool:
    for _ in range(500):
        if not alive(pid):
            return True
        time.sleep(0.01)
    return False


@pytest.mark.parametrize(
    ("leaves", "then"),
    [("pass", "time.sleep(600)"), ("os.setsid()", "time.sleep(600)"), ("os.setsid()", "pass")],
)
def test_no_process_is_left_behind(leaves: str, then: str, tmp_path: Path):
    if leaves != "pass" and not Path("/proc/self/environ").exists():
        pytest.skip("a process that leaves its group is found by /proc only")
    note = tmp_path / "grandchild"
    ran = python(
        f"if os.fork() == 0:\n"
        f"    {leaves}\n"
        f"    open({str(note)!r}, 'w').write(str(os.getpid()))\n"
        f"    time.sleep(600)\n"
        f"while not os.path.exists({str(note)!r}): time.sleep(.01)\n"
        f"time.sleep(.1)\n"
        f"say('s0')\n"
        f"{then}\n",
        HASTY,
    )
    assert answered(ran) == ["s0"]
    assert gone(int(note.read_text()))


def test_the_shell_is_not_asked(tmp_path: Path):
    trap = tmp_path / "trap"
    ran = run(
        [sys.executable, "-c", "import sys; print(sys.argv)", f"; touch {trap} $(touch {trap})"],
        scenes(),
        GENEROUS,
    )
    assert "touch" in said(ran)
    assert not trap.exists()


def test_a_program_that_is_not_there():
    with pytest.raises(FileNotFoundError):
        run(["/no/such/program"], scenes(), GENEROUS)


def test_scenes_with_one_id_are_refused():
    with pytest.raises(ValueError, match="same id"):
        run([sys.executable], scenes(1) * 2, GENEROUS)


def test_nothing_asked_is_nothing_answered():
    ran = python("for id in ids(): say(id)", count=0)
    assert (answered(ran), said(ran), ran.status) == ([], "", 0)


@pytest.mark.parametrize("size", [1, 10_007, 65_536])
def test_lines_do_not_depend_on_how_they_arrive(size: int):
    stream = b"one\n\ntwo\r\n" + b"x" * (LONGEST_LINE + 1) + b"\nthree"
    if size == 1:
        stream = stream.replace(b"x" * LONGEST_LINE, b"")
    chunks = (stream[start : start + size] for start in range(0, len(stream), size))
    too_long = b"x" if size == 1 else None
    expected = enumerate([b"one", b"", b"two\r", too_long, b"three"], 1)
    assert list(split_lines(chunks)) == list(expected)
