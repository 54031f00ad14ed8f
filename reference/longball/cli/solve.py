"""``longball solve``."""

from __future__ import annotations

import gc
import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, BinaryIO

import typer

from longball import engines
from longball.cli.changes import FenceOption, ReadingOption, SetOption, chosen_changes
from longball.cli.cluster import Scheduler, on_cluster
from longball.cli.common import (
    EngineName,
    Quiet,
    Workers,
    named,
    note,
    progress_bar,
    say,
    tell,
    writable,
    writing_to,
    wrong_call,
)
from longball.cli.scenes import LINES, TABLES, Source, ending, scenes_from
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.lines import solve_lines
from longball.model.readings import AppendixBRoot, ContactForce, VerletForces, VerletLanding


def _results_file(output: Path | None) -> Path | None:
    if output is None or str(output) == "-":
        return None
    if ending(output) not in (*LINES, *TABLES):
        endings = ", ".join(filter(None, (*LINES, *TABLES)))
        raise typer.BadParameter(f"{output}: the endings of results are {endings}, or none")
    return writable(output)


def solve(
    source: Source = "-",
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            callback=_results_file,
            help="Where results go, .jsonl, .csv or .parquet; by default, or if -, stdout.",
        ),
    ] = None,
    engine: EngineName = "ivp",
    method: Annotated[
        str | None,
        typer.Option(
            "--integrator",
            help="ivp: Taylor (default), or of solve_ivp: RK23, RK45, DOP853, Radau, BDF, LSODA.",
        ),
    ] = None,
    rtol: Annotated[
        float | None,
        typer.Option(help="ivp: relative tolerance of solve_ivp's methods, by default 5e-14."),
    ] = None,
    atol: Annotated[
        float | None,
        typer.Option(help="ivp: their absolute tolerance, m and m/s, by default 5e-14."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--landing-error", help="batch: the error allowed at landing, m, by default 1e-13."
        ),
    ] = None,
    digits: Annotated[
        int | None,
        typer.Option(
            help="enclosure, multiprecision: digits of numbers, by default 30, up to 500 and 290."
        ),
    ] = None,
    dt: Annotated[float | None, typer.Option(help="verlet: the step, s, by default 0.05.")] = None,
    forces: Annotated[
        VerletForces | None,
        typer.Option(
            help="verlet: at which velocity drag and lift are taken, by default old_carried."
        ),
    ] = None,
    landing: Annotated[
        VerletLanding | None,
        typer.Option(help="verlet: where the ball lands, by default interpolated."),
    ] = None,
    root: Annotated[
        AppendixBRoot | None,
        typer.Option(help="verlet: which root of Appendix B's quadratic, by default the first."),
    ] = None,
    contact_force: Annotated[
        ContactForce | None,
        typer.Option(help="verlet: when half of the contact force acts, by default whole."),
    ] = None,
    path: Annotated[
        bool, typer.Option("--path", help="Add the path: [[t, x, y, z, vx, vy, vz], …].")
    ] = False,
    points: Annotated[
        int | None,
        typer.Option(
            min=2, max=1_000_000, help="Points of the path, evenly spaced in time, by default 201."
        ),
    ] = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="Give every number with a proven error.")
    ] = False,
    set_: SetOption = None,
    fence: FenceOption = None,
    reading: ReadingOption = None,
    workers: Workers = 1,
    scheduler: Scheduler = None,
    quiet: Quiet = False,
) -> None:
    """Solve scenes: one result in JSON for each line of input."""
    # fmt: off
    options = {
        "method": method, "rtol": rtol, "atol": atol, "tolerance": tolerance, "digits": digits,
        "dt": dt, "forces": forces, "landing": landing, "root": root,
        "contact_force": contact_force,
    }
    # fmt: on
    change = chosen_changes(set_, fence, reading)
    asked = (points or 201) if path or points else None
    if asked and output and ending(output) in TABLES:
        wrong_call(f"--path: {output} is a table, which has no place for paths; .jsonl has")
    if asked and certify:
        wrong_call("--path: its points cannot be certified; take --engine enclosure")
    if ".parquet" in {ending(name) for name in (source, output or "")}:
        import_module("pyarrow")
    if output and ending(output) in TABLES:
        import_module("pandas")
    try:
        solver: Engine[Any] | ManyAtOnce = engines.create(
            engine, **{k: v for k, v in options.items() if v is not None}
        )
    except ValueError as error:
        wrong_call(_with_options(str(error), options))
    if certify:
        from longball.engines.certify import Certifying  # brings ball arithmetic

        solver = Certifying(solver)
    # What has been imported stays: looking at it again and again took a fourth of the time.
    gc.freeze()
    solved = failed = 0
    ids: set[str | None] = set()
    repeated: set[str] = set()
    doubtful: dict[str, list[str]] = {}
    with (
        on_cluster(scheduler),
        scenes_from(source) as lines,
        results_to(output, source, lines) as write,
        progress_of(lines, output) as advance,
    ):
        for result in solve_lines(lines, solver, -1 if scheduler else workers, asked, change):
            write(result.text)
            solved += 1
            advance(solved)
            failed += result.failure is not None
            if result.id is not None and result.id in ids:
                repeated.add(result.id)
            ids.add(result.id)
            for key, question in result.doubts:
                doubtful.setdefault(key, []).append(f"scene {result.id}: {key}: {question}")
    for first, *others in doubtful.values():
        note(f"{first}{f' (and {len(others)} more)' if others else ''}")
    if solved == 0:
        tell(f"no scenes in {named(source)}")
    elif failed:
        tell(f"{failed} of {solved} lines could not be solved{' and certified' * certify}")
    if repeated:
        tell(f"ids that more than one line has: {len(repeated)}, among them {min(repeated)!r}")
    if failed or not solved:
        raise typer.Exit(1)


def _with_options(sentence: str, options: Iterable[str]) -> str:
    """Return an engine's message with the options' names on the command line."""
    names = {option: f"--{option.replace('_', '-')}" for option in options}
    names |= {"method": "--integrator", "tolerance": "--landing-error"}
    return re.sub(rf"\b({'|'.join(names)})\b", lambda name: names[name[0]], sentence)


@contextmanager
def progress_of(lines: BinaryIO, output: Path | None) -> Iterator[Callable[[int], None]]:
    """Show how many lines of a file are done, unless the results go to the terminal."""
    if lines.isatty():
        note("scenes are read from the terminal, one per line of JSON; Ctrl-D ends")
    shown = output is not None or not sys.stdout.isatty()
    if not (say.is_terminal and shown and lines.seekable()):
        yield lambda done: None
        return
    total = sum(1 for _ in lines)
    lines.seek(0)
    with progress_bar("scenes", total) as advance:
        yield advance


@contextmanager
def results_to(
    output: Path | None, source: str, lines: BinaryIO
) -> Iterator[Callable[[bytes], object]]:
    """Open the file that results go to; yield a function that takes a line of JSON."""
    if output is None or ending(output) not in TABLES:
        with writing_to(output, lines) as file:
            # Somebody may wait for an answer at the end of a pipe, but not of a file.
            awaited = True
            with suppress(OSError):  # a stream that is no file
                awaited = not stat.S_ISREG(os.fstat(file.fileno()).st_mode)

            def write(line: bytes) -> None:
                file.write(line + b"\n")
                if awaited:
                    file.flush()

            yield write
        return
    if source != "-" and output.exists() and output.samefile(source):
        wrong_call(f"{output} is the file that the scenes are read from")
    results: list[bytes] = []
    yield results.append
    from longball.table_files import write_table

    write_table(output, results)
