"""``longball golden``: list, path, export, coverage, write and check."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

import typer

from longball.cli.command import Command
from longball.cli.common import (
    Json,
    Quiet,
    Workers,
    note,
    progress_bar,
    refusing,
    show,
    tell,
    wrong_call,
)
from longball.golden import Header, files, reader
from longball.model.names import one_of

app = typer.Typer(
    help="The golden data: list, locate, export, check or generate them.",
    epilog="Example: longball golden list",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
)

Folder = Annotated[Path | None, typer.Argument(metavar="[DIR]")]
Part = Literal["cases", "probability"]


@app.command("list", cls=Command, epilog="Example: longball golden list")
def list_(folder: Folder = None, as_json: Json = False, quiet: Quiet = False) -> None:
    """List the families, which other commands take as SET, with how many cases each has."""
    top = header_of(folder)
    if as_json:
        print(top.model_dump_json(include={"format", "licence", "families"}))
        return
    families = (
        (name, str(x.cases), x.about.partition("\n")[0]) for name, x in top.families.items()
    )
    show(("family", "cases", "what"), families)
    note(f"format {top.format}, {top.licence}")


@app.command(cls=Command, epilog="Example: ls $(longball golden path)")
def path() -> None:
    """Print the folder of the golden data that come with longball."""
    print(reader.DATA)


@app.command(cls=Command, epilog="Example: longball golden export golden.zip")
def export(
    output: Annotated[
        Path | None, typer.Argument(metavar="[FILE.zip]", help="By default named by version.")
    ] = None,
    folder: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A set other than the shipped one.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a set as one archive, the same bytes every time."""
    target = output or Path(f"{files.ARCHIVE}.zip")
    with refusing():
        count = files.export(target, folder or reader.DATA)
    note(f"{count} files in {target}")


def header_of(folder: Path | None) -> Header:
    """Return the header of a set."""
    with refusing(f"{folder}: "):
        return reader.header(folder or reader.DATA)


@app.command(cls=Command, epilog="Example: longball golden write golden-data")
def write(
    folder: Annotated[Path, typer.Argument(metavar="DIR")],
    part: Annotated[Part | None, typer.Option(help="Only that part of the set.")] = None,
    family: Annotated[
        list[str] | None,
        typer.Option(help="Only that family of cases, the others as DIR has them; repeatable."),
    ] = None,
    workers: Workers = -1,
    quiet: Quiet = False,
) -> None:
    """Solve every case with proven bounds and write the set to DIR.

    An interrupted run resumes where it stopped. The cases take some ten minutes on two cores, the
    probabilities P(e) somewhat longer.
    """
    from longball.golden import home_runs, writer  # with them come the engines

    families = reader.header().families
    if unknown := set(family or []) - families.keys():
        name = min(unknown)
        wrong_call(f"--family {name}: there is none{one_of('the families are', name, families)}")
    if part != "probability":
        with progress_bar("cases", 1) as advance:
            count = writer.write(folder, only=family or None, workers=workers, progress=advance)
        note(f"{count} cases in {folder}")
    if part != "cases" and not family:
        with progress_bar("probabilities", 1) as advance:
            count = home_runs.write_probabilities(folder, workers=workers, progress=advance)
        note(f"{count} readings' probabilities in {folder}")


@app.command(cls=Command, epilog="Example: longball golden coverage scenes.jsonl")
def coverage(
    scenes: Annotated[
        str, typer.Argument(metavar="SCENES", help="A file of scenes, or - for standard input.")
    ],
    most: Annotated[
        int, typer.Option(min=0, help="How many mistakes that the scenes miss are listed.")
    ] = 20,
    every: Annotated[
        int, typer.Option(min=1, help="Try one edit of so many; 1 for all, which takes minutes.")
    ] = 8,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Count the mistakes that scenes of your own would show, beside the golden data.

    A mistake is an edit of the model: another symbol, a sign, a factor, a term that is left out.
    Those are counted that your scenes or the golden data show.
    """
    from longball.cli.scenes import read_scenes
    from longball.judge.coverage import coverage as covered
    from longball.judge.diagnosis.findings import many
    from longball.judge.fresh import proven

    with refusing():
        own = proven(list(read_scenes(scenes)), "own")
    with progress_bar("edits", EDITS // every) as advance:
        found = covered([*reader.load("all"), *own], every, advance)
    mine = [i for i, case in enumerate(found.cases) if case.family == "own"]
    shown = found.noticed[:, mine].sum(axis=1) > 0
    likeliest = sorted(range(len(shown)), key=found.bits.__getitem__)
    missed = [found.told(i) for i in likeliest if not shown[i]]
    by_stage = found.by_stage(shown)
    if as_json:
        stages = [{"stage": name, "edits": n, "noticed": k} for name, n, k in by_stage]
        print(json.dumps({"stages": stages, "missed": missed[:most]}, ensure_ascii=False))
        return
    rows = [(name, f"{n:,}", f"{k:,}", f"{k / n:.0%}") for name, n, k in by_stage]
    show(("stage", "edits", "noticed", ""), rows)
    if missed[:most]:
        print("\nmissed, with a golden case that notices it:")
    for one in missed[:most]:
        print(f"  {one['stage']}: {one['edit']} ({one['case']})")
    note(f"{many(len(mine), 'scene')}: {int(shown.sum()):,} of {many(len(shown), 'edit')} noticed")


EDITS = 50_000  # about as many as there are, for the bar


@app.command(cls=Command, epilog="Example: longball golden check --sample 50")
def check(
    folder: Folder = None,
    sample: Annotated[
        int | None, typer.Option(min=0, help="How many cases to solve again; by default all.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Chooses which ones.")] = 1,
    independent: Annotated[
        bool,
        typer.Option(help="Solve them also by the multiprecision engine, which shares no method."),
    ] = True,
    workers: Workers = -1,
    quiet: Quiet = False,
) -> None:
    """Verify a set: checksums, schema, and the results by solving again."""
    from longball.golden import checker  # with them come the engines that prove

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
    if report.confirmed:
        note(report.confirmed)
    if target.resolve() == reader.DATA:
        note("python -m tests.oracle_check solves them by a program that shares no line with these")
    found = f"{len(report.failures)} failures" if report.failures else "nothing is wrong"
    count = f"{report.cases} cases, with those of P(e)"
    note(f"{count}; {report.solved_again} solved again: {found}")
    if report.failures:
        raise typer.Exit(1)
