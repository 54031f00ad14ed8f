"""``longball golden write`` and ``longball golden check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from longball.cli.common import Quiet, Workers, note, progress_bar, tell, wrong_call

app = typer.Typer(help="Generate the golden data, or verify them.", no_args_is_help=True)

Folder = Annotated[Path | None, typer.Argument(metavar="[DIR]")]
Part = Literal["cases", "probability"]


@app.command(epilog="Example: longball golden write golden-data")
def write(
    folder: Folder = None,
    part: Annotated[Part | None, typer.Option(help="Only that part of the set.")] = None,
    family: Annotated[
        list[str] | None,
        typer.Option(help="Only that family of cases, the others as DIR has them; repeatable."),
    ] = None,
    workers: Workers = -1,
    quiet: Quiet = False,
) -> None:
    """Solve every case with proven bounds and write the set to DIR; by default the shipped set.

    An interrupted run resumes where it stopped. The cases take some ten minutes on two cores, the
    probabilities P(e) somewhat longer.
    """
    from longball.golden import home_runs, reader, writer  # with them come the engines
    from longball.golden.families import FAMILIES

    target = folder or reader.DATA
    if unknown := set(family or []) - FAMILIES.keys():
        known = ", ".join(FAMILIES)
        wrong_call(f"--family {unknown.pop()}: there is none; the families are {known}")
    if part != "probability":
        with progress_bar("cases", 1) as advance:
            count = writer.write(target, only=family or None, workers=workers, progress=advance)
        note(f"{count} cases in {target}")
    if part != "cases" and not family:
        with progress_bar("probabilities", 1) as advance:
            count = home_runs.write_probabilities(target, workers=workers, progress=advance)
        note(f"{count} readings' probabilities in {target}")


@app.command(epilog="Example: longball golden check --sample 50")
def check(
    folder: Folder = None,
    sample: Annotated[
        int | None, typer.Option(min=0, help="Solve so many cases again; by default all.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Which ones.")] = 1,
    independent: Annotated[
        bool, typer.Option(help="Also by the multiprecision engine, which shares no method.")
    ] = True,
    workers: Workers = -1,
    quiet: Quiet = False,
) -> None:
    """Verify a set: checksums, schema, and the results by solving again."""
    from longball.golden import checker, reader  # with them come the engines that prove

    target = folder or reader.DATA
    if not target.is_dir():
        wrong_call(f"{target}: there is no such folder")
    with progress_bar("cases", 1) as advance:
        report = checker.check(
            target,
            sample=sample,
            seed=seed,
            independent=independent,
            workers=workers,
            progress=advance,
        )
    for failure in report.failures:
        print(failure)
    if report.left_out:
        tell(report.left_out)
    found = f"{len(report.failures)} failures" if report.failures else "nothing is wrong"
    note(f"{report.cases} cases, {report.solved_again} solved again: {found}")
    if report.failures:
        raise typer.Exit(1)
