"""``longball judge``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from longball.cli.common import progress_bar, split_assignment, wrong_call


def judge(
    command: Annotated[
        list[str] | None,
        typer.Argument(metavar="-- COMMAND …", help="Reads scenes on stdin, writes results."),
    ] = None,
    golden: Annotated[
        str | None,
        typer.Option(metavar="SET", help="A family of the golden data; all if not given."),
    ] = None,
    results: Annotated[
        Path | None, typer.Option(help="Answers in a file, .jsonl or .csv, instead of a COMMAND.")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="COLUMN=QUANTITY", help="A column of a .csv file; repeatable."),
    ] = None,
    profile: Annotated[
        str, typer.Option(help="exact: what doubles can attain; converged; paper: the scheme.")
    ] = "exact",
    tolerance: Annotated[
        float | None, typer.Option(help="converged: the error allowed, m, s, m/s.")
    ] = None,
    dt: Annotated[float | None, typer.Option(help="s: the candidate's time step.")] = None,
    require: Annotated[
        list[str] | None,
        typer.Option(help="all, answers, outcome, or a quantity: must not be missing; repeatable."),
    ] = None,
    timeout: Annotated[float, typer.Option(min=0.001, help="s without an answer.")] = 10.0,
    total_timeout: Annotated[float, typer.Option(min=0.001, help="s in all.")] = 3600.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, not a text.")] = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML here, for CI.")] = None,
    html: Annotated[Path | None, typer.Option(help="Write a page with pictures here.")] = None,
) -> None:
    """Hold another implementation against the truth, and tell what is wrong with it."""
    # The judge brings compiled code with it, and --help does not need it.
    from longball.golden import load
    from longball.judge import junit as xml
    from longball.judge import page
    from longball.judge.answers import BadTable
    from longball.judge.candidate import Limits
    from longball.judge.cases import profile as profile_of
    from longball.judge.trial import Court
    from longball.judge.words import words

    if bool(command) == bool(results):
        wrong_call("either --results FILE or -- COMMAND is needed")
    try:
        cases = load(golden)
        court = Court(
            cases,
            profile_of(profile, tolerance, dt if profile == "paper" else None),
            truth=f"golden data, {golden}" if golden else "golden data",
            require=require or (),
            dt=dt,
        )
        if results:
            columns = dict(split_assignment("--column", text) for text in column or ())
            trial = court.try_file(results, columns)
        else:
            with progress_bar("scenes", len(cases)) as advance:
                trial = court.try_command(command or [], Limits(timeout, total_timeout), advance)
    except (BadTable, ValueError) as error:
        wrong_call(str(error))
    print(trial.verdict.line() if as_json else words(trial.verdict).rstrip())
    if junit:
        junit.write_text(xml.junit(trial), encoding="utf-8")
    if html:
        html.write_text(page.page(trial), encoding="utf-8")
    if not trial.verdict.passed:
        raise typer.Exit(1)
