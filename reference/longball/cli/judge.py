"""``longball judge``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from longball.cli.messages import (
    assignments,
    failing_unless,
    note,
    progress_bar,
    refuse_if,
    refusing,
    wrong_call,
)

# Default time step, s: a method of order 4 reaches the default tolerance, 1e-6, with it.
STEP = 1e-3
Form = Literal["text", "json", "junit", "github"]

if TYPE_CHECKING:
    from longball.judge.cases import Case, Profile
    from longball.judge.evaluation import Evaluation


def judge(
    command: list[str] | None = None,
    golden: list[str] | None = None,
    scenes: str | None = None,
    random: int | None = None,
    seed: int | None = None,
    kind: list[str] | None = None,
    readings: bool = False,
    write_defaults: bool = False,
    partial: bool = False,
    as_csv: bool = False,
    results: Path | None = None,
    column: list[str] | None = None,
    samples: Path | None = None,
    profile: str = "converged",
    tolerance: float | None = None,
    dt: float | None = None,
    steps: str | None = None,
    knob: str | None = None,
    expected: float | None = None,
    timeout: float = 60.0,
    total_timeout: float = 3600.0,
    format_: Form = "text",
    table: bool = False,
    html: Path | None = None,
    quiet: bool = False,
) -> None:
    """Compare a simulator with proven results, and name its mistakes."""
    refuse_if(
        (command and results, "either --results FILE or -- COMMAND, not both"),
        (
            not (command or results or samples),
            "give -- COMMAND, --results FILE or --samples FILE",
        ),
        (
            as_csv and not command,
            "--as-csv is for a COMMAND; --results recognises FILE.csv by its name",
        ),
        (column and not results, "--column is for the columns of --results FILE.csv"),
        (seed is not None and not random, "--seed is for the scenes of --random N"),
        (readings and (scenes or random), "--readings is for golden cases"),
        (knob and steps, "either --steps or --knob, not both"),
        (
            sum(map(bool, (golden, scenes, random))) > 1,
            "either --golden, --scenes or --random, not two of them",
        ),
    )
    # Report a missing library now, not after the program has run for minutes.
    if html:
        import_module("matplotlib")
    # Imported here because --help must not load the engines.
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
        # The verdict uses the finest step, because a correct program has its smallest errors there.
        if stepped and dt is None:
            dt = rule.dt if isinstance(rule, Paper) else min(stepped.steps or [STEP])
        cases, truth = (
            cases_of(golden, scenes, random, seed, kind, readings)
            if command or results
            else ([], "")
        )
        # By default, scenes omit keys as they were written, which tests the program's defaults.
        if write_defaults:
            cases = [with_defaults(case) for case in cases]
        # All options are checked before this point, because a program may run for an hour.
        judge = Judge(cases, rule, truth, partial, dt=dt)
        if results:
            columns = assignments("--column", column)
            evaluation = judge.evaluate_file(results, columns, drawn)
        elif command:
            if stepped:
                note(f"first run: dt = {dt:g}; then runs with other steps (--steps FROM:TO:COUNT)")
            # One progress bar for the answers and for the runs with other steps.
            with progress_bar("judging", len(judge.cases)) as advance:
                sweep = replace(sweep, progress=advance) if sweep else None
                limits = Limits(timeout, total_timeout)
                evaluation = judge.evaluate_command(command, limits, advance, sweep, drawn, as_csv)
        else:
            assert drawn
            evaluation = judge.evaluate(Submission(drawn.source, Collector(()), sampling=drawn))
    if html:
        html.write_text(page.page(evaluation), encoding="utf-8")
    # In GitHub's log, the text is below the annotations.
    text = render(evaluation.verdict, table=table).rstrip()
    if further := further_options(evaluation, rule, golden, scenes or random):
        text += f"\n\nfurther: {further}"
    with failing_unless(evaluation.verdict.passed):
        match format_:
            case "text":
                print(text)
            case "json":
                print(evaluation.verdict.line())
            case "junit":
                print(junit(evaluation), end="")
            case "github":
                print(annotated(evaluation.verdict, text))


def further_options(
    evaluation: Evaluation, rule: Profile, golden: Sequence[str] | None, others: object
) -> str:
    """List the tests that were not run, with the options that run them."""
    from longball.golden import reader
    from longball.judge.cases import Converged, Exact
    from longball.judge.verdict import compare

    # What a first-time author may try next: the last digits, and the other families.
    sentences = []
    judged = [c for c in evaluation.comparisons if c.counted]
    if judged and isinstance(rule, Converged):
        right = sum(compare(c.case, c.answer, Exact()).passed for c in judged)
        sentences.append(f"at --profile exact, {right} of {len(judged)} are right")
    if judged and not others:
        tried = {case.case.family for case in evaluation.comparisons}
        # `defaults` comes first: wrong defaults are common, and no other family detects them.
        more = [name for name in reader.header().families if name not in tried]
        more.sort(key=lambda name: name != "defaults")
        sentences += [f"not tested: {', '.join(more)} (--golden all)"] if more else []
    return "; ".join(sentences)


def with_defaults(case: Case) -> Case:
    """Return a case with all defaults in its scene."""
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
    """Return the cases of the options, and a description of their source."""
    from longball.cli.scenes import chosen_kinds, read_scenes
    from longball.golden import load
    from longball.judge.cases import asked as asked_of
    from longball.judge.fresh import DRAWN, USUAL, proven, random_scenes, usual_constants

    chosen = chosen_kinds(kinds)
    if scenes:
        given = [x for x in read_scenes(scenes) if not chosen or x.kind in chosen]
        return list(proven(given)), f"proven values of {scenes}"
    # Random scenes are solved with proven bounds first, which takes most of the time.
    if random:
        seed = 1 if seed is None else seed
        asked = list(random_scenes(random, seed, chosen or DRAWN))
        with progress_bar("proving", random) as advance:
            cases = proven(asked, progress=advance)
        drawn = " ".join([" and ".join(chosen), "scenes"]).strip()
        return list(cases), f"proven values of {random} random {drawn}, seed {seed}"
    # Without a family: the paper's model in its default reading, for authors who begin.
    chosen_cases: list[Case] = [] if golden else [*load()]
    for name in dict.fromkeys(golden or ()):
        chosen_cases += proven(usual_constants(), USUAL) if name == USUAL else load(name)
    chosen_cases = [case for case in chosen_cases if not chosen or case.scene.kind in chosen]
    chosen_cases = asked_of(chosen_cases, readings, hard=bool(golden))
    if not chosen_cases:
        wrong_call("there is no golden case of these families and kinds; see longball golden list")
    return chosen_cases, ", ".join(["golden data", *(golden or ()), *chosen])
