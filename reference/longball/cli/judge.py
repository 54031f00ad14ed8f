"""``longball judge``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from longball.cli.common import Json, Quiet, progress_bar, refusing, split_assignment, wrong_call


def judge(
    command: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="-- COMMAND …",
            help="Reads scenes on stdin, writes results. {dt} in it stands for the time step: then "
            "its order of convergence is looked at, too.",
        ),
    ] = None,
    golden: Annotated[
        str | None, typer.Option(metavar="SET", help="A family of the golden data; by default all.")
    ] = None,
    results: Annotated[
        Path | None,
        typer.Option(
            help="Answers in a file, .jsonl or .csv, instead of a COMMAND. Columns of a .csv: id, "
            "outcome, landing.distance, landing.position[0], …"
        ),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=QUANTITY",
            help="What a column of a .csv holds that has another name; repeatable.",
        ),
    ] = None,
    samples: Annotated[
        Path | None,
        typer.Option(help="At-bats that the candidate drew, .jsonl, to test their distributions."),
    ] = None,
    profile: Annotated[
        str,
        typer.Option(
            help="exact: what doubles can attain; converged: an error below --tolerance; paper: "
            "the printed scheme at its time step, 0.05 s or --dt."
        ),
    ] = "exact",
    tolerance: Annotated[
        float | None, typer.Option(help="converged: the error allowed, m, s, m/s, J; 1e-6.")
    ] = None,
    dt: Annotated[
        float | None, typer.Option(help="s: the candidate's time step, which {dt} stands for.")
    ] = None,
    steps: Annotated[
        str | None,
        typer.Option(
            metavar="FROM:TO:COUNT",
            help="s: the steps put for {dt} to see it converge; 0.01:0.0001:9.",
        ),
    ] = None,
    expected: Annotated[
        float | None, typer.Option(help="The order of convergence in theory.")
    ] = None,
    require: Annotated[
        list[str] | None,
        typer.Option(help="all, answers, outcome, or a quantity: must not be missing; repeatable."),
    ] = None,
    timeout: Annotated[
        float, typer.Option(min=0.001, help="s without another answer, or before the first.")
    ] = 60.0,
    total_timeout: Annotated[float, typer.Option(min=0.001, help="s in all.")] = 3600.0,
    as_json: Json = False,
    junit: Annotated[Path | None, typer.Option(help="Write JUnit XML here, for CI.")] = None,
    html: Annotated[Path | None, typer.Option(help="Write a page with pictures here.")] = None,
    quiet: Quiet = False,
) -> None:
    """Compare another implementation with the truth, and tell what is wrong with it."""
    if command and results:
        wrong_call("either --results FILE or -- COMMAND, not both")
    if not (command or results or samples):
        wrong_call("-- COMMAND, --results FILE or --samples FILE is needed")
    if column and not results:
        wrong_call("--column names the columns of --results FILE.csv")
    # The judge brings compiled code with it, and --help does not need it.
    from longball.golden import load
    from longball.judge import junit as xml
    from longball.judge import page
    from longball.judge.candidate import Limits
    from longball.judge.cases import Paper
    from longball.judge.cases import profile as profile_of
    from longball.judge.evaluation import Judge
    from longball.judge.sampling import judge_samples, read_samples
    from longball.judge.step_sweep import StepSweep
    from longball.judge.text import render

    with refusing():
        drawn = judge_samples(read_samples(samples), samples.name) if samples else None
        family = family_of(command or [], steps, expected)
        rule = profile_of(profile, tolerance, dt if profile == "paper" else None)
        if family and dt is None:
            dt = rule.dt if isinstance(rule, Paper) else min(family)
        judge = Judge(
            load(golden) if command or results else [],
            rule,
            truth=f"golden data, {golden}" if golden else "golden data",
            require=require or (),
            dt=dt,
        )
        if results:
            columns = dict(split_assignment("--column", text) for text in column or ())
            found = judge.evaluate_file(results, columns, drawn)
        elif command:
            # One bar for both: the scenes answered, then the runs with other steps.
            with progress_bar("judging", len(judge.cases)) as advance:
                found = judge.evaluate_command(
                    command,
                    Limits(timeout, total_timeout),
                    advance,
                    StepSweep(family, expected, progress=advance) if family else None,
                    drawn,
                )
        else:
            assert drawn
            found = judge.evaluate_samples(drawn)
    print(found.verdict.line() if as_json else render(found.verdict).rstrip())
    if junit:
        junit.write_text(xml.junit(found), encoding="utf-8")
    if html:
        html.write_text(page.page(found), encoding="utf-8")
    if not found.verdict.passed:
        raise typer.Exit(1)


def family_of(
    command: Sequence[str], steps: str | None, expected: float | None
) -> list[float] | None:
    """Return the steps to put for {dt}; None if the command has no place for one."""
    from longball.judge.step_sweep import PLACE, STEPS, parse_steps, takes_step

    if takes_step(command):
        return parse_steps(steps or STEPS)
    for option, given in (("--steps", steps), ("--expected", expected)):
        if given is not None:
            wrong_call(f"{option} needs {PLACE} in the COMMAND, where its time step goes")
    return None
