"""``longball solve``."""

from __future__ import annotations

import gc
import os
import re
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import BinaryIO

from longball import engines
from longball.cli.changes import chosen_changes
from longball.cli.cluster import on_cluster
from longball.cli.messages import exit_unless, note, progress_bar, say, tell, wrong_call
from longball.cli.options import TABLES, Options, ending, flag
from longball.cli.scenes import named, scenes_from
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.lines import solve_lines

# Options of engines: their names in Python, and on the command line.
ENGINE_OPTIONS = {
    "method": "integrator", "rtol": "rtol", "atol": "atol", "tolerance": "landing_error",
    "digits": "digits", "dt": "dt", "forces": "forces", "landing": "landing", "root": "root",
    "contact_force": "contact_force",
}  # fmt: skip


def solve(o: Options) -> None:
    """Solve scenes: one result in JSON for each line of input."""
    change = chosen_changes(o)
    asked = (o.points or 201) if o.path or o.points else None
    if asked and o.output and ending(o.output) in TABLES:
        wrong_call(f"--path: {o.output} is a table, which cannot hold paths; use .jsonl")
    if asked and o.certify:
        wrong_call("--path: points cannot be certified; use --engine enclosure instead")
    # Report a missing library before hours of work.
    if ".parquet" in {ending(name) for name in (o.source, o.output or "")}:
        import_module("pyarrow")
    if o.output and ending(o.output) in TABLES:
        import_module("pandas")
    given = {name: getattr(o, option) for name, option in ENGINE_OPTIONS.items()}
    try:
        solver: Engine | ManyAtOnce = engines.create(
            o.engine, **{name: x for name, x in given.items() if x is not None}
        )
    except ValueError as error:
        # The engine's message, with the names of options on the command line.
        words = rf"\b({'|'.join(ENGINE_OPTIONS)})\b"
        wrong_call(re.sub(words, lambda m: flag(ENGINE_OPTIONS[m[0]]), str(error)))
    if o.certify:
        from longball.engines.certify import Certifying  # brings ball arithmetic

        solver = Certifying(solver)
    # Exclude the imported modules from garbage collection, which took a fourth of the time.
    gc.freeze()
    # Results are written one by one; only counts and ids are kept.
    solved = failed = 0
    ids: set[str | None] = set()
    repeated: set[str] = set()
    doubtful: dict[str, list[str]] = {}
    with (
        on_cluster(o) as workers,
        scenes_from(o.source) as lines,
        progress_of(lines, o.output) as advance,
    ):
        refuse_source(o.output, o.source, lines)
        results = solve_lines(lines, solver, workers, asked, change)
        # Open the output with the first result, so that an error before it does not empty the file.
        if (first := next(results, None)) is None:
            wrong_call(f"no scenes in {named(o.source)}")
        with results_to(o.output) as write:
            for result in chain([first], results):
                write(result.text)
                solved += 1
                advance(solved)
                failed += result.failure is not None
                if result.id is not None and result.id in ids:
                    repeated.add(result.id)
                ids.add(result.id)
                for key, question in result.doubts:
                    doubtful.setdefault(key, []).append(f"scene {result.id}: {key}: {question}")
    # A file in km/h has the same doubt in each line: print it once.
    for question, *others in doubtful.values():
        note(f"{question}{f' (and {len(others)} more)' if others else ''}")
    if failed:
        tell(f"{failed} of {solved} lines could not be solved{' and certified' * o.certify}")
    # Repeated ids are allowed, but a later join by id would be wrong.
    if repeated:
        are = "id is" if len(repeated) == 1 else "ids are"
        tell(f"{len(repeated)} {are} on more than one line, such as {min(repeated)!r}")
    exit_unless(not failed)


@contextmanager
def progress_of(lines: BinaryIO, output: Path | None) -> Iterator[Callable[[int], None]]:
    """Show a progress bar, unless the results go to the terminal."""
    if lines.isatty():
        note("reading scenes from the terminal, one JSON object per line; Ctrl-D ends the input")
    # A bar between results on the same terminal would break their lines.
    shown = output is not None or not sys.stdout.isatty()
    if not (say.is_terminal and shown and lines.seekable()):
        yield lambda done: None
        return
    total = sum(1 for _ in lines)
    lines.seek(0)
    with progress_bar("scenes", total) as advance:
        yield advance


def refuse_source(output: Path | None, source: str, lines: BinaryIO) -> None:
    """Reject an output (None: standard output) that is the file of the scenes."""
    # Streams are not files, and the output may not exist yet.
    with suppress(OSError):
        there = os.stat(output if output is not None else sys.stdout.fileno())
        read = os.stat(lines.fileno() if source == "-" else source)
        if stat.S_ISREG(there.st_mode) and os.path.samestat(there, read):
            wrong_call(f"{output or 'standard output'} is also the input; choose another output")


@contextmanager
def results_to(output: Path | None) -> Iterator[Callable[[bytes], object]]:
    """Open the output; yield a function that writes a line of JSON."""
    if output is not None and ending(output) in TABLES:
        # The last row may add a column, so a table is written at the end.
        results: list[bytes] = []
        yield results.append
        from longball.table_files import write_table

        write_table(output, results)
        return
    with nullcontext(sys.stdout.buffer) if output is None else open(output, "wb") as file:
        # Flush each line into a pipe, where a reader may wait for it; not into a file.
        awaited = True
        with suppress(OSError):  # streams are not files
            awaited = not stat.S_ISREG(os.fstat(file.fileno()).st_mode)

        def write(line: bytes) -> None:
            file.write(line + b"\n")
            if awaited:
                file.flush()

        yield write
