"""``longball judge``."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING

from longball.cli.messages import (
    failing_unless,
    note,
    progress_bar,
    refusing,
    wrong_call,
)
from longball.cli.options import Options

# Default time step, s: a method of order 4 reaches the default tolerance, 1e-6, with it.
STEP = 1e-3

if TYPE_CHECKING:
    from longball.judge.cases import Case, Profile
    from longball.judge.evaluation import Evaluation


def judge(o: Options) -> None:
    """Compare a simulator with proven results, and name its mistakes."""
    if not (o.command or o.results or o.samples):
        wrong_call("give -- COMMAND, --results FILE or --samples FILE")
    if o.as_csv and not o.command:
        wrong_call("--as-csv is for a COMMAND; --results recognises FILE.csv by its name")
    if o.column and not o.results:
        wrong_call("--column is for the columns of --results FILE.csv")
    if o.seed is not None and not o.random:
        wrong_call("--seed is for the scenes of --random N")
    if o.readings and (o.scenes or o.random):
        wrong_call("--readings is for golden cases")
    # Report a missing library now, not after the program has run for minutes.
    if o.html:
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
        drawn = judge_samples(read_samples(o.samples), o.samples.name) if o.samples else None
        sweep = sweep_of(o.command or [], o.steps, o.knob, o.expected)
        rule = profile_of(o.profile, o.tolerance, o.dt if o.profile == "paper" else None)
        stepped = sweep if sweep and not o.knob else None
        # The verdict uses the finest step, because a correct program has its smallest errors there.
        dt = o.dt
        if stepped and dt is None:
            dt = rule.dt if isinstance(rule, Paper) else min(stepped.steps or [STEP])
        cases, truth = cases_of(o) if o.command or o.results else ([], "")
        # By default, scenes omit keys as they were written, which tests the program's defaults.
        if o.write_defaults:
            cases = [with_defaults(case) for case in cases]
        # All options are checked before this point, because a program may run for an hour.
        judge = Judge(cases, rule, truth, o.partial, dt=dt)
        if o.results:
            evaluation = judge.evaluate_file(o.results, o.column, drawn)
        elif o.command:
            if stepped:
                note(f"first run: dt = {dt:g}; then runs with other steps (--steps FROM:TO:COUNT)")
            # One progress bar for the answers and for the runs with other steps.
            with progress_bar("judging", len(judge.cases)) as advance:
                sweep = replace(sweep, progress=advance) if sweep else None
                limits = Limits(o.timeout, o.total_timeout)
                evaluation = judge.evaluate_command(
                    o.command, limits, advance, sweep, drawn, o.as_csv
                )
        else:
            assert drawn
            evaluation = judge.evaluate(Submission(drawn.source, Collector(()), sampling=drawn))
    if o.html:
        o.html.write_text(page.page(evaluation), encoding="utf-8")
    # In GitHub's log, the text is below the annotations.
    text = render(evaluation.verdict, table=o.table).rstrip()
    if further := further_options(o, evaluation, rule):
        text += f"\n\nbeyond this verdict: {further}"
    with failing_unless(evaluation.verdict.passed):
        match o.format:
            case "text":
                print(text)
            case "json":
                print(evaluation.verdict.line())
            case "junit":
                print(junit(evaluation), end="")
            case "github":
                print(annotated(evaluation.verdict, text))


def further_options(o: Options, evaluation: Evaluation, rule: Profile) -> str:
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
    if judged and not (o.scenes or o.random):
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


def cases_of(o: Options) -> tuple[list[Case], str]:
    """Return the cases of the options, and a description of their source."""
    from longball.cli.scenes import read_scenes
    from longball.golden import load
    from longball.judge.cases import asked as asked_of
    from longball.judge.fresh import DRAWN, USUAL, proven, random_scenes, usual_constants

    if o.scenes:
        given = [x for x in read_scenes(o.scenes) if not o.kind or x.kind in o.kind]
        return list(proven(given)), f"proven values of {o.scenes}"
    # Random scenes are solved with proven bounds first, which takes most of the time.
    if o.random:
        seed = 1 if o.seed is None else o.seed
        asked = list(random_scenes(o.random, seed, o.kind or DRAWN))
        with progress_bar("proving", o.random) as advance:
            cases = proven(asked, progress=advance)
        drawn = " ".join([" and ".join(o.kind or ()), "scenes"]).strip()
        return list(cases), f"proven values of {o.random} random {drawn}, seed {seed}"
    # Without a family: the paper's model in its default reading, for authors who begin.
    families = [*dict.fromkeys(o.golden or ())]
    known: list[Case] = [] if families else [*load()]
    for name in families:
        known += proven(usual_constants(), USUAL) if name == USUAL else load(name)
    known = [case for case in known if not o.kind or case.scene.kind in o.kind]
    known = asked_of(known, o.readings, hard=bool(families))
    if not known:
        wrong_call("there is no golden case of these families and kinds; see longball golden list")
    return known, ", ".join(["golden data", *(o.golden or ()), *(o.kind or ())])
