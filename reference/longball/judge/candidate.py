"""Run another implementation: write scenes to its input, and read results from its output.

The candidate is not trusted. It may answer late, in any order, twice or never; crash, hang, flood
its output, close its input, or leave processes behind. In every case the run ends in bounded time
and memory, keeps all answers, and reports what went wrong. No shell is involved. A POSIX system is
required; elsewhere, judge a file of results.
"""

from __future__ import annotations

import os
import selectors
import signal
import subprocess
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

from longball.judge.answers import CHUNK, Collector, quoted, split_lines
from longball.judge.fresh import as_csv
from longball.model.scene import Scene, ids_of

MOST_FAULTS = 10_000  # largest number of output lines that are not answers
REFUSED = 1  # exit status of a program that could not solve all scenes


@dataclass(frozen=True)
class Limits:
    """Limits of a candidate's time and memory."""

    # Longest time without a new answer, s. The same limit applies to the start, and to the end
    # after the last answer.
    scene_seconds: float = 10.0
    total_seconds: float = 3600.0  # longest time of the run, s
    # Largest size of the output. A long result takes 5,000 bytes: this is 50,000 of them.
    output_bytes: int = 1 << 28
    error_bytes: int = 1 << 13  # bytes that are kept from the end of standard error


@dataclass(frozen=True)
class Run:
    """A candidate's run."""

    collected: Collector  # its answers, and issues with these and with its conduct
    errors: str  # the end of its standard error
    # Exit status; a negative one is the signal that ended the run. None if the judge stopped it.
    status: int | None


def run(
    command: Sequence[str],
    scenes: Sequence[Scene],
    limits: Limits | None = None,
    progress: Callable[[int], None] = lambda answered: None,
    table: bool = False,
) -> Run:
    """Run a candidate on scenes as they are written; raise an OSError if it cannot be started.

    No shell reads the command. `progress` is called with the number of answers whenever it grows.
    If `table`, scenes (with all their defaults) and results are CSV with a header.
    """
    session = _Session(command, scenes, limits or Limits(), progress, table)
    try:
        session.exchange()
        session.finish()
    finally:
        session.clear()
    errors = session.errors.decode("utf-8", errors="replace")
    return Run(session.collected, errors, session.status)


class _Session:
    """A candidate's process, and the three pipes to it."""

    # One thread waits until any of the pipes is ready. Writing all scenes first would be a
    # deadlock: a candidate that answers while it reads fills its output, and stops reading.

    def __init__(
        self,
        command: Sequence[str],
        scenes: Sequence[Scene],
        limits: Limits,
        progress: Callable[[int], None],
        table: bool,
    ) -> None:
        self.limits, self.progress = limits, progress
        self.ids = ids_of(scenes)
        self.collected = Collector(self.ids, table)
        if len(self.collected.asked) < len(scenes):
            raise ValueError("two scenes have the same id")
        lines = (scene.as_written().encode() + b"\n" for scene in scenes)
        self.unsent = as_csv(scenes) if table else lines
        self.sending = next(self.unsent, b"")
        self.input_closed = False
        self.read = b""  # the last piece of its output, not yet split into lines
        self.received = 0  # bytes of its output so far
        self.errors = b""
        self.status: int | None = None
        self.stopped = False
        self.mark = uuid.uuid4().hex  # `kill_marked` finds its child processes by this
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            bufsize=0, start_new_session=True, env=os.environ | {MARK: self.mark},
        )  # fmt: skip
        self.started = self.latest = time.monotonic()
        streams = self.process.stdin, self.process.stdout, self.process.stderr
        self.stdin, self.stdout, self.stderr = (cast(IO[bytes], stream) for stream in streams)
        self.selector = selectors.DefaultSelector()
        for pipe, ready, handle in (
            (self.stdin, selectors.EVENT_WRITE, self._write),
            (self.stdout, selectors.EVENT_READ, self._read),
            (self.stderr, selectors.EVENT_READ, self._read_errors),
        ):
            os.set_blocking(pipe.fileno(), False)
            self.selector.register(pipe, ready, handle)

    def exchange(self) -> None:
        """Exchange scenes and answers until the output ends or a limit is reached."""
        for number, line in split_lines(self._output()):
            if self.collected.take_line(number, line):
                self.latest = time.monotonic()
                self.progress(len(self.collected.answers))
            elif self.collected.faults > MOST_FAULTS and not self.stopped:
                self._stop(f"it wrote more than {MOST_FAULTS} lines that are no answers")

    def _output(self) -> Iterator[bytes]:
        # `latest` is the time of the last new answer. Other output does not extend the time limit.
        limits = self.limits
        while not self.stopped and not self.stdout.closed:
            now = time.monotonic()
            left = self.started + limits.total_seconds - now
            patience = self.latest + limits.scene_seconds - now
            if left <= 0:
                self._stop(f"it took more than {limits.total_seconds:g} s in all")
            elif patience > 0:
                self._wait(min(left, patience))
                yield self.read
                self.read = b""
            elif (status := self.process.poll()) is not None:
                # The pipe stays open while any process holds it, such as a daemon of the candidate.
                self.stopped = True
                held = f"held its output open, without an answer for {limits.scene_seconds:g} s"
                self._report(f"{_end(status)}, but a process that it had started {held}")
            elif self._missing():
                self._stop(f"no answer came for {limits.scene_seconds:g} s")
            else:
                patient = f"{limits.scene_seconds:g} s after its last answer"
                self._stop(f"it did not end within {patient}")

    def finish(self) -> None:
        """Wait for the candidate to end, and report how it ended."""
        if self.stopped:
            return
        self._close(self.stdin)
        until = time.monotonic() + self.limits.scene_seconds
        # A process cannot end while its standard error is full, so this is read meanwhile.
        while self.process.poll() is None and (left := until - time.monotonic()) > 0:
            if self.stderr.closed:
                with suppress(subprocess.TimeoutExpired):
                    self.process.wait(left)
            else:
                self._wait(min(left, 0.05))
        self.status = self.process.poll()
        if self.status is None:
            patience = f"{self.limits.scene_seconds:g} s"
            self._stop(f"it closed its output, but did not end within {patience}")
        elif self._missing() and self.status >= 0:
            early = " before it had read all scenes" if self.input_closed else ""
            self._report(f"{_end(self.status)}{early}")
        # All scenes are answered. A signal is a fault, and so is a status other than 0, except for
        # status 1 after a refusal.
        elif self.status and not (self.status == REFUSED and self._refused()):
            self._report(_end(self.status))

    def clear(self) -> None:
        """End the candidate's process group, and processes that have left the group."""
        with suppress(ProcessLookupError, PermissionError):  # all gone; macOS: not yet reaped
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        kill_marked(self.mark)
        while not self.stderr.closed and self._read_errors():
            pass  # no process writes any more, so this ends when the pipe is empty
        for pipe in (self.stdin, self.stdout, self.stderr):
            self._close(pipe)
        self.selector.close()

    # --- the three pipes --------------------------------------------------------------------------

    def _wait(self, seconds: float) -> None:
        for key, _ in self.selector.select(seconds):
            key.data()

    def _write(self) -> None:
        try:
            while self.sending:
                sent = os.write(self.stdin.fileno(), self.sending[:CHUNK])
                self.sending = self.sending[sent:] or next(self.unsent, b"")
        except BlockingIOError:
            return
        except BrokenPipeError:  # the candidate has closed its input, or has ended
            self.input_closed = True
        self._close(self.stdin)

    def _read(self) -> None:
        self.read = os.read(self.stdout.fileno(), CHUNK)
        self.received += len(self.read)
        if not self.read:
            self._close(self.stdout)
        elif self.received > self.limits.output_bytes:
            self.read = b""
            self._stop(f"it wrote more than {self.limits.output_bytes} bytes")

    def _read_errors(self) -> bool:
        try:
            data = os.read(self.stderr.fileno(), CHUNK)
        except BlockingIOError:
            return False
        if not data:
            self._close(self.stderr)
        self.errors = (self.errors + data)[-self.limits.error_bytes :]
        return bool(data)

    def _close(self, pipe: IO[bytes]) -> None:
        if not pipe.closed:
            with suppress(KeyError):
                self.selector.unregister(pipe)
            pipe.close()

    def _missing(self) -> int:
        return len(self.collected.asked) - len(self.collected.answers)

    def _refused(self) -> bool:
        return any(answer.error is not None for answer in self.collected.answers.values())

    def _report(self, what: str) -> None:
        answered, asked = len(self.collected.answers), len(self.collected.asked)
        sentence = f"the candidate: {what}; it answered {answered} of {asked} scenes"
        silent = next((name for name in self.ids if name not in self.collected.answers), None)
        if silent is not None:
            sentence += f", and {quoted(silent)} is the first without an answer"
        self.collected.report("process", sentence)

    def _stop(self, why: str) -> None:
        self.stopped = True
        self._report(f"{why}, and was stopped")


def _end(status: int) -> str:
    """Describe the end of a process."""
    if status >= 0:
        return f"it ended with status {status}"
    names = {s.value: s.name for s in signal.Signals}
    return f"it was ended by signal {names.get(-status, -status)}"


# --- processes that have left their group ---------------------------------------------------------

# A variable with a unique value in the candidate's environment. Its descendants inherit it, so they
# are found even if they have started their own sessions.
MARK = "LONGBALL_JUDGE"


def kill_marked(mark: str) -> None:
    """Kill the processes that have a mark in their environment, where /proc shows it (Linux)."""
    needle = f"{MARK}={mark}".encode()
    # Repeat until none is found: a process may have started another one in the meantime.
    for _ in range(10):
        entries = Path("/proc").glob("[0-9]*")
        found = [int(entry.name) for entry in entries if needle in _environment(entry)]
        for pid in found:
            with suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        if not found:
            return
        time.sleep(0.01)


def _environment(process: Path) -> list[bytes]:
    try:
        return (process / "environ").read_bytes().split(b"\0")
    except OSError:  # the process has ended, or belongs to another user
        return []
