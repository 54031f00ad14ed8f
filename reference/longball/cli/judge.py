"""``longball judge``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from longball.cli.common import (
    AsCsv,
    Expected,
    Knob,
    Quiet,
    Steps,
    Timeout,
    assignments,
    failing_unless,
    note,
    progress_bar,
    refusing,
    to_file,
    wrong_call,
)

STEP = 1e-3  # s, at which a method of order 4 is right to 1e-6
Form = Literal["text", "json", "junit", "github"]

if TYPE_CHECKING:
    from longball.judge.cases import Case, Profile
    from longball.judge.evaluation import Evaluation


def judge(
    command: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[-- COMMAND …]",
            help="The program to judge: it reads scenes on standard input and writes results on "
            "standard output. If {dt} is in it, it is also run with several time steps, and its "
            "order of convergence is measured.",
        ),
    ] = None,
    golden: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SET",
            help="Judge by one family of the golden data, by all, by quick, which is a few cases "
            "of all that notice nearly every mistake, or by usual-constants. May be given several "
            "times. Default: all of the paper's model but hard.",
        ),
    ] = None,
    scenes: Annotated[
        str | None,
        typer.Option(
            help="Judge by the scenes of this file, lines of JSON, .csv or .parquet, which are "
            "solved first."
        ),
    ] = None,
    random: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Judge by N random scenes, drawn from --seed."),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Seed of the random scenes. Default: 1."),
    ] = None,
    kind: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND",
            help="Judge by scenes of this kind only: flight, pitch, impact or at-bat. May be given "
            "several times. Default: all kinds.",
        ),
    ] = None,
    readings: Annotated[
        bool,
        typer.Option("--readings", help="Judge by golden cases of other readings as well."),
    ] = False,
    write_defaults: Annotated[
        bool,
        typer.Option(
            "--write-defaults",
            help="Write out every default of a scene but those of its reading, also where the "
            "scene leaves it out.",
        ),
    ] = False,
    partial: Annotated[
        bool, typer.Option("--partial", help="Scenes and quantities may be left out.")
    ] = False,
    table: AsCsv = False,
    results: Annotated[
        Path | None,
        typer.Option(
            help="Judge the results in this file, .jsonl or .csv, instead of running a COMMAND. "
            "Columns of a .csv: id, outcome, landing.distance, landing.position[0], …"
        ),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=QUANTITY",
            help="Which quantity a column of the .csv holds, if its name does not say so. May be "
            "given several times.",
        ),
    ] = None,
    samples: Annotated[
        Path | None,
        typer.Option(
            help="At-bats that the program has drawn, as .jsonl: test their distributions."
        ),
    ] = None,
    profile: Annotated[
        str,
        typer.Option(
            help="Accuracy required. exact: within 100 times what doubles cannot avoid; converged: "
            "errors below --tolerance; paper: the same as the paper's scheme at its time step, "
            "0.05 s or --dt."
        ),
    ] = "converged",
    tolerance: Annotated[
        float | None,
        typer.Option(help="The error that profile converged allows, in SI units. Default: 1e-6."),
    ] = None,
    dt: Annotated[
        float | None,
        typer.Option(help="The program's time step, s. It replaces {dt} in the COMMAND."),
    ] = None,
    steps: Steps = None,
    knob: Knob = None,
    expected: Expected = None,
    timeout: Timeout = 60.0,
    total_timeout: Annotated[float, typer.Option(min=0.001, help="Longest run, s.")] = 3600.0,
    form: Annotated[
        Form,
        typer.Option(
            "--format",
            help="How the verdict is printed: for people, as JSON, as JUnit's XML, or with "
            "annotations for GitHub's Actions.",
        ),
    ] = "text",
    rows: Annotated[
        bool, typer.Option("--table", help="Print a table of the errors of each quantity.")
    ] = False,
    html: Annotated[
        Path | None, to_file("Write the verdict to this file as a page with pictures.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compare a simulator with proven results; say what is wrong."""
    if command and results:
        wrong_call("either --results FILE or -- COMMAND, not both")
    if not (command or results or samples):
        wrong_call("-- COMMAND, --results FILE or --samples FILE is needed")
    if table and not command:
        wrong_call(
            "--as-csv says what a COMMAND reads and writes; --results takes FILE.csv by itself"
        )
    if column and not results:
        wrong_call("--column names the columns of --results FILE.csv")
    if seed is not None and not random:
        wrong_call("--seed is that of the scenes of --random N")
    if readings and (scenes or random):
        wrong_call("--readings is that of golden cases")
    if knob and steps:
        wrong_call("either --steps or --knob, not both: one of them takes its values in turn")
    if sum(map(bool, (golden, scenes, random))) > 1:
        wrong_call("either --golden, --scenes or --random, not two of them")
    if html:
        import_module("matplotlib")  # it draws the page's pictures
    # The judge brings compiled code with it, and --help does not need it.
    from longball.judge import page
    from longball.judge.answers import Collector
    from longball.judge.candidate import Limits
    from longball.judge.cases import Paper
    from longball.judge.cases import profile as profile_of
    from longball.judge.evaluation import Judge
    from longball.judge.github import annotated
    from longball.judge.junit import junit
    from longball.judge.sampling import judge_samples, read_samples
    from longball.judge.step_sweep import sweep_of
    from longball.judge.text import render
    from longball.judge.verdict import Submission

    with refusing():
        drawn = judge_samples(read_samples(samples), samples.name) if samples else None
        sweep = sweep_of(command or [], steps, knob, expected)
        rule = profile_of(profile, tolerance, dt if profile == "paper" else None)
        stepped = sweep if sweep and not knob else None
        if stepped and dt is None:
            dt = rule.dt if isinstance(rule, Paper) else min(stepped.steps or [STEP])
        cases, truth = (
            cases_of(golden, scenes, random, seed, kind, readings)
            if command or results
            else ([], "")
        )
        if write_defaults:
            cases = [with_defaults(case) for case in cases]
        judge = Judge(cases, rule, truth, partial, dt=dt)
        if results:
            columns = assignments("--column", column)
            found = judge.evaluate_file(results, columns, drawn)
        elif command:
            if stepped:
                note(
                    f"after this run, at dt = {dt:g}, come some with other steps; --steps "
                    "FROM:TO:COUNT says which"
                )
            # One bar for both: the scenes answered, then the runs with other steps.
            with progress_bar("judging", len(judge.cases)) as advance:
                sweep = replace(sweep, progress=advance) if sweep else None
                limits = Limits(timeout, total_timeout)
                found = judge.evaluate_command(command, limits, advance, sweep, drawn, table)
        else:
            assert drawn
            found = judge.evaluate(Submission(drawn.source, Collector(()), sampling=drawn))
    if html:
        html.write_text(page.page(found), encoding="utf-8")
    text = render(found.verdict, table=rows).rstrip()
    if further := further_options(found, rule, golden, scenes or random):
        text += f"\n\nfurther: {further}"
    with failing_unless(found.verdict.passed):
        match form:
            case "text":
                print(text)
            case "json":
                print(found.verdict.line())
            case "junit":
                print(junit(found), end="")
            case "github":
                print(annotated(found.verdict, text))


def further_options(
    found: Evaluation, rule: Profile, golden: Sequence[str] | None, others: object
) -> str:
    """List the tests that were not run, with the options that run them."""
    from longball.golden import reader
    from longball.judge.cases import Converged, Exact
    from longball.judge.verdict import compare

    said = []
    judged = [c for c in found.comparisons if c.judged and c.answer and not c.refused]
    if judged and isinstance(rule, Converged):
        right = sum(compare(c.case, c.answer, Exact()).passed for c in judged)
        said.append(f"to the last digits {right} of {len(judged)} are right (--profile exact)")
    if judged and not others:
        tried = {case.case.family for case in found.comparisons}
        more = [name for name in reader.header().families if name not in tried]
        said += [f"not tried: {', '.join(more)} (--golden all)"] if more else []
    return "; ".join(said)


def with_defaults(case: Case) -> Case:
    """Return a case whose scene leaves out no default."""
    from longball.judge.cases import Known
    from longball.model.scene import written_out

    scene = written_out(case.scene)
    if isinstance(case, Known):
        return replace(case, scene=scene)
    return case.model_copy(update={"scene": scene})


def cases_of(
    golden: Sequence[str] | None,
    scenes: str | None,
    random: int | None,
    seed: int | None,
    kinds: Sequence[str] | None,
    readings: bool,
) -> tuple[list[Case], str]:
    """Return the cases to judge by, and where they are from."""
    from longball.cli.scenes import read_scenes
    from longball.golden import load
    from longball.judge.cases import asked as asked_of
    from longball.judge.fresh import DRAWN, USUAL, proven, random_scenes, usual_constants
    from longball.model.names import one_of
    from longball.model.scene import KINDS

    chosen = list(dict.fromkeys(kinds or ()))
    for name in chosen:
        if name not in KINDS:
            wrong_call(f"--kind {name}: there is none{one_of('the kinds are', name, KINDS)}")
    if scenes:
        given = [x for x in read_scenes(scenes) if not chosen or x.kind in chosen]
        return list(proven(given)), f"proven values of {scenes}"
    if random:
        seed = 1 if seed is None else seed
        asked = list(random_scenes(random, seed, chosen or DRAWN))
        with progress_bar("proving", random) as advance:
            cases = proven(asked, progress=advance)
        drawn = " ".join([" and ".join(chosen), "scenes"]).strip()
        return list(cases), f"proven values of {random} random {drawn}, seed {seed}"
    found: list[Case] = [] if golden else [*load()]
    for name in dict.fromkeys(golden or ()):
        found += proven(usual_constants(), USUAL) if name == USUAL else load(name)
    found = [case for case in found if not chosen or case.scene.kind in chosen]
    found = asked_of(found, readings, hard=bool(golden))
    if not found:
        wrong_call("no golden case is of these families and kinds")
    return found, ", ".join(["golden data", *(golden or ()), *chosen])
