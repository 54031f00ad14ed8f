"""An evaluation from beginning to end: run a candidate or read its file, compare, diagnose."""

from __future__ import annotations

import math
import shlex
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from longball.engines.ivp import Ivp
from longball.judge.answers import Answer, Collector, line_of, read_results
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Profile, completed, decidable, lacking, solved
from longball.judge.diagnosis.diagnose import diagnose
from longball.judge.diagnosis.findings import Diagnosis
from longball.judge.diagnosis.scenes import shrunk
from longball.judge.paths import as_written
from longball.judge.quantities import difference, length, values_of
from longball.judge.sampling import Sampling
from longball.judge.step_sweep import FAMILIES, StepSweep, filled, sample
from longball.judge.verdict import Comparison, Submission, Verdict, compare, verdict
from longball.model.scene import Scene, written_out

# Runs a candidate again: from scenes to answers by id.
Ask = Callable[[Sequence[Scene]], Mapping[str, Answer]]

AGAIN = 12  # scenes that are run again in reverse order
COMPLETED = 100  # scenes in which quantities are judged that the golden data lack

# The beginning of the sentence in place of a diagnosis that failed.
DEFECT = "the search for causes ended with an error of its own"

# A diagnosis cannot use larger numbers: the product of three of them may overflow.
BEYOND = Decimal("1e100")


def usable(answer: Answer) -> Answer:
    """Return an answer whose numbers beyond use count as unreadable."""
    beyond = {name for name, x in answer.values.items() if max(map(abs, x)) > BEYOND}
    wild = answer.path is not None and np.abs(answer.path).max() > float(BEYOND)
    values = {name: x for name, x in answer.values.items() if name not in beyond}
    beyond |= {"path.position"} if wild else set()
    path, unreadable = None if wild else answer.path, answer.unreadable | beyond
    return replace(answer, values=values, path=path, unreadable=unreadable)


@dataclass(frozen=True)
class Evaluation:
    """A verdict and what it was made from."""

    verdict: Verdict  # what is reported
    comparisons: Sequence[Comparison]  # every case with its answer, for pictures and for JUnit


@dataclass(frozen=True)
class Judge:
    """A judge: the cases, the profile and the limits of its candidates."""

    cases: Sequence[Case]  # with their truth
    profile: Profile  # the accuracy required
    truth: str = "golden data"  # where the cases are from, for the report
    partial: bool = False  # whether scenes and quantities may be left out
    # True to search for causes, and to run some scenes twice.
    diagnose: bool = True
    # s, the candidate's time step, for the diagnosis; None if it is not known.
    dt: float | None = None

    def evaluate_command(
        self,
        command: Sequence[str],
        limits: Limits | None = None,
        progress: Callable[[int], None] = lambda answered: None,
        sweep: StepSweep | None = None,
        sampling: Sampling | None = None,
        table: bool = False,
    ) -> Evaluation:
        """Run a candidate and judge it; see `longball.judge.candidate.run`.

        `dt` replaces {dt} in the command. If the run ends well and there is a `sweep`, the
        candidate is run again with its time steps, to measure its convergence to the golden truth,
        whatever the profile; the same limit of time applies to these runs together. `sampling` is
        the judgement of the at-bats that it draws. If `table`, scenes and results are CSV.
        """
        start = time.monotonic()
        stepped = filled(command, "dt", repr(self.dt)) if self.dt else command
        whole = sweep.filled(stepped, min(sweep.steps)) if sweep and sweep.steps else stepped
        ran = run(whole, [case.scene for case in self.cases], limits, progress, table)
        collected, report = ran.collected, None
        well = not any(issue.kind == "process" for issue in collected.issues)
        if sweep and well:
            families = {case.family for case in self.cases}
            some = sample(self.cases, FAMILIES if families > set(FAMILIES) else ())
            scenes, truth = [case.scene for case in some], [case.expected for case in some]
            varied = command if sweep.knob == "dt" else stepped
            report, issues = sweep.run(varied, scenes, truth, limits, table)
            for issue in issues:
                collected.report("process", issue)
        elif sweep:
            collected.report("process", "because of that, its convergence was not measured")

        def ask(scenes: Sequence[Scene]) -> Mapping[str, Answer]:
            return run(whole, scenes, limits, table=table).collected.answers

        submission = Submission(shlex.join(whole), collected, ran.errors, report, sampling)
        return self.evaluate(submission, ask if well else None, start)

    def _completed(self, cases: Sequence[Case], answers: Mapping[str, Answer]) -> Sequence[Case]:
        """Return the cases, some of them with quantities that only the candidate has.

        A mistake in these is in most scenes, and each takes a solution: a sample is enough.
        """
        found = {c.id: names for c in cases
                 if c.id in answers and (names := lacking(c, answers[c.id].values))}  # fmt: skip
        chosen = {*[*found][:: math.ceil(len(found) / COMPLETED) or 1]}
        return [completed(c, found[c.id]) if c.id in chosen else c for c in cases]

    def _again(self, ask: Ask, answers: Mapping[str, Answer]) -> list[str]:
        """Run some scenes again, backwards, and return what is wrong if the answers differ.

        Differences within the tolerance are allowed: the order of sums may vary between threads.
        """
        known = [case for case in self.cases if case.id in answers and decidable(case)]
        # The axis of the lift follows from the heading, which a ball that flies straight up does
        # not have. A program that keeps the axis of the last scene depends on the order of scenes,
        # so such a scene is always among those that run again.
        upright = [case for case in known if _is_upright(case.scene)][:1]
        some = [*upright, *known[:: max(1, len(known) // AGAIN)][:AGAIN]]
        chosen = [*{case.id: case for case in some}.values()][::-1]
        if len(chosen) < 2:
            return []

        def differing(a: Mapping[str, Answer], b: Mapping[str, Answer]) -> list[str]:
            return [c.id for c in chosen if self._differ(c, a.get(c.id), b.get(c.id))]

        # Twice in reverse order: if the two reverse runs agree, the order is the cause; otherwise
        # the candidate is random.
        backwards = ask([case.scene for case in chosen])
        if not (differ := differing(answers, backwards)):
            return []
        if random := differing(backwards, ask([case.scene for case in chosen])):
            return ["the program is not deterministic: the same scenes in the same order give "
                    f"different numbers, for example {random[0]}"]  # fmt: skip
        return [f"answers depend on earlier scenes: {len(differ)} of {len(chosen)} scenes give "
                f"different numbers in another order, for example {differ[0]}; the program keeps "
                "state between scenes"]  # fmt: skip

    def _differ(self, case: Case, a: Answer | None, b: Answer | None) -> bool:
        """True if two answers differ by more than the profile allows."""
        if a is None or b is None:
            return (a is None) != (b is None)
        if a.outcome != b.outcome or set(a.values) != set(b.values):
            return True
        expected = values_of(case.expected)
        for name, value in a.values.items():
            if name in expected:
                passes = self.profile.tolerance(case, name, expected[name])
            else:
                passes = self.profile.allowed(length(value))
            if not difference(value, b.values[name]) <= passes:
                return True
        return False

    def _smallest(self, ask: Ask, failing: Sequence[Any]) -> dict[str, Any]:
        """Return a minimal scene that the candidate still fails."""
        order = ("flight", "impact", "pitch", "at-bat")
        start = min(failing, key=lambda s: (order.index(s.kind), len(str(s.model_dump()))))

        def fails(scenes: Sequence[Any]) -> list[bool]:
            answers = ask([*map(written_out, scenes)])
            return [
                case.id in answers and not compare(case, answers[case.id], self.profile).passed
                for case in solved(scenes, Ivp())
            ]

        smallest = shrunk(start, fails).model_dump(mode="json", exclude_defaults=True)
        return {**smallest, "kind": start.kind}

    def evaluate_function(self, solve: Callable[[Scene], Any]) -> Evaluation:
        """Judge a function from a scene to its result; see `longball.judge.judge`."""
        start = time.monotonic()
        collected = Collector([case.id for case in self.cases])
        for number, case in enumerate(self.cases, 1):
            try:
                line = line_of(case.id, solve(case.scene))
            except Exception as error:  # any error counts as a refusal
                line = line_of(case.id, {"error": f"{type(error).__name__}: {error}"})
            collected.take_line(number, line)
        name = getattr(solve, "__name__", type(solve).__name__)
        return self.evaluate(Submission(name, collected), start=start)

    def evaluate_file(
        self, path: Path, columns: Mapping[str, str] | None = None, sampling: Sampling | None = None
    ) -> Evaluation:
        """Judge a file of results; see `longball.judge.answers.read_results`."""
        collected = read_results(path, [case.id for case in self.cases], columns)
        return self.evaluate(Submission(path.name, collected, sampling=sampling))

    @np.errstate(all="ignore")  # a wrong number may be of any size
    def evaluate(
        self, submission: Submission, ask: Ask | None = None, start: float | None = None
    ) -> Evaluation:
        """Judge what a candidate has answered; `ask` runs it again, and it was begun at `start`."""
        answers = submission.collected.answers
        truths = self._completed(self.profile.truths(self.cases), answers)
        conduct = self._again(ask, answers) if ask and self.diagnose else []
        comparisons = [compare(case, answers.get(case.id), self.profile) for case in truths]
        wrong = [c for c in comparisons if not c.passed]
        diagnosis, scheme = None, self.profile.scheme()
        if self.diagnose and (conduct or wrong):
            judged = [c.case for c in comparisons if c.judged]
            diagnosis = self._diagnosis(judged, wrong, submission, conduct, ask)
        truth = scheme.description if scheme else self.truth
        rule = self.profile.rule(self.cases)
        seconds = None if start is None else time.monotonic() - start
        said = verdict(comparisons, submission, rule, truth, self.partial, diagnosis, seconds)
        return Evaluation(said, comparisons)

    def _diagnosis(
        self, judged: Sequence[Case], wrong: Sequence[Comparison], submission: Submission,
        conduct: list[str], ask: Ask | None,
    ) -> Diagnosis:  # fmt: skip
        """Return the diagnosis and a small scene that shows it; or the reason why there is none."""
        try:
            diagnosis = self._diagnosed(judged, wrong, submission, conduct, ask)
            if not ask or conduct or self.profile.scheme() is not None:
                return diagnosis
            # Begin with an example of the first finding, so that the scene shows that mistake.
            examples = {finding.example for finding in diagnosis.findings[:1]}
            told = [c for c in wrong if c.case.id in examples]
            smallest = self._smallest(ask, [c.case.scene for c in told or wrong])
            return diagnosis.model_copy(update={"smallest": smallest})
        # A defect of the diagnosis must not cost the candidate its verdict.
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            sentence = (
                f"{DEFECT}: {type(error).__name__}: {error} ({Path(place.filename).name}, line "
                f"{place.lineno}); answers are counted nevertheless; please report it"
            )
            try:  # the wrong steps, which need no search
                located = self._diagnosed(judged, wrong, submission, conduct, None, causes=False)
            except Exception:
                located = Diagnosis(
                    sentence="", first=None, stages=[], clean=[], findings=[], conduct=conduct
                )
            return located.model_copy(update={"sentence": sentence, "findings": []})

    def _diagnosed(
        self, judged: Sequence[Case], wrong: Sequence[Comparison], submission: Submission,
        conduct: list[str], ask: Ask | None, causes: bool = True,
    ) -> Diagnosis:  # fmt: skip
        def written(scenes: Iterable[Any], answers: Mapping[str, Answer]) -> dict[str, Answer]:
            return {s.id: as_written(s, usable(a)) for s in scenes if (a := answers.get(s.id))}

        def again(scenes: Sequence[Any]) -> Mapping[str, Answer]:
            return written(scenes, ask(scenes)) if ask else {}

        diagnosis = diagnose(
            judged, written([c.scene for c in self.cases], submission.collected.answers), self.dt,
            scheme=self.profile.scheme(), causes=causes and not conduct,
            granted=self.profile.error, solve=again if ask else None,
        )  # fmt: skip
        more: dict[str, Any] = {"conduct": conduct}
        if wrong and not diagnosis.findings:
            what = ", ".join(sorted({fault.what for c in wrong for fault in c.faults}))
            more["sentence"] = f"no cause is known; wrong: {what}"
        return diagnosis.model_copy(update=more)


def _is_upright(scene: Any) -> bool:
    """True if a scene is a flight straight up or down, with a lift and without a spin."""
    flies = scene.kind == "flight" and scene.air is not None and scene.launch.spin is None
    return flies and not any(scene.launch.velocity[:2]) and bool(scene.air.lift_coefficient)
