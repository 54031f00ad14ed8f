"""An evaluation from beginning to end: run a candidate or read its file, compare, diagnose."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from longball.convergence import ConvergenceReport
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.judge.answers import Answer, Collector, read_results
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Profile, decidable, solved
from longball.judge.diagnosis import diagnose
from longball.judge.paths import as_written
from longball.judge.quantities import Value, difference, length, values_of
from longball.judge.rules import shrunk
from longball.judge.sampling import Sampling
from longball.judge.step_sweep import FAMILIES, StepSweep, order_of, sample, with_step
from longball.judge.testing import line_of
from longball.judge.verdict import Comparison, Submission, Verdict, compare, failure, verdict
from longball.model.scene import Scene

AGAIN = 12  # scenes that are run twice


@dataclass(frozen=True)
class Evaluation:
    """A verdict and what it was made from."""

    verdict: Verdict  # what is reported
    comparisons: Sequence[Comparison]  # every case with its answer, for pictures and for JUnit

    def telling(self, **more: Any) -> Evaluation:
        """Return the same with more in its verdict."""
        return replace(self, verdict=self.verdict.model_copy(update=more))


@dataclass(frozen=True)
class Judge:
    """What candidates are judged by."""

    cases: Sequence[Case]  # with their truth
    profile: Profile  # the accuracy required
    truth: str = "golden data"  # where the cases are from, for the report
    partial: bool = False  # whether scenes and quantities may be left out
    # Whether it is asked where errors come from, and some scenes are run twice.
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

        If {dt} is in the command, `dt` goes there. With the time steps of `sweep` it is run again,
        if it ends well, to see how it converges to the golden truth, whatever the profile; these
        runs together have the same limit of time. `sampling` tells how it draws at-bats, and
        `table` whether scenes and results are CSV.
        """
        start = time.monotonic()
        filled = sweep.filled(command) if sweep else command
        filled = with_step(filled, self.dt) if self.dt else filled
        ran = run(filled, [case.scene for case in self.cases], limits, progress, table)
        well = not any(issue.kind == "process" for issue in ran.collected.issues)
        report, conduct, smallest = None, list[str](), None
        if sweep and well:
            report = self._converge(command, sweep, ran.collected, limits, table)
        elif sweep:
            ran.collected.report("process", "for that, its convergence was not looked at")

        def asked(scenes: Sequence[Scene]) -> Mapping[str, Answer]:
            return run(filled, scenes, limits, table=table).collected.answers

        if well and self.diagnose:
            conduct = self._again(asked, ran.collected.answers)
        submission = Submission(shlex.join(filled), ran.collected, ran.errors, report, sampling)
        found = self.evaluate(submission, conduct)
        if well and self.diagnose and not conduct and self.profile.engine() is None:
            smallest = self._smallest(asked, found.verdict)
        if smallest and (known := found.verdict.diagnosis):
            found = found.telling(diagnosis=known.model_copy(update={"smallest": smallest}))
        return found.telling(seconds=time.monotonic() - start)

    def _again(
        self,
        asked: Callable[[Sequence[Scene]], Mapping[str, Answer]],
        answers: Mapping[str, Answer],
    ) -> list[str]:
        """Run some scenes again, backwards; say whether the answers are the same."""
        # They may differ by what passes, as sums by several threads do.
        known = [case for case in self.cases if case.id in answers and decidable(case)]
        # No heading tells the axis of a lift straight up: there one that is kept shows, if it runs
        # after another flight.
        upright = [case for case in known if _is_upright(case.scene)][:1]
        some = [*upright, *known[:: max(1, len(known) // AGAIN)][:AGAIN]]
        chosen = [*{case.id: case for case in some}.values()][::-1]
        if len(chosen) < 2:
            return []

        def differing(a: Mapping[str, Answer], b: Mapping[str, Answer]) -> list[str]:
            return [c.id for c in chosen if self._differ(c, a.get(c.id), b.get(c.id))]

        backwards = asked([case.scene for case in chosen])
        if not (differ := differing(answers, backwards)):
            return []
        if random := differing(backwards, asked([case.scene for case in chosen])):
            return ["it is not deterministic: the same scenes in the same order give other "
                    f"numbers, {random[0]} for one"]  # fmt: skip
        return [f"its answer depends on the scenes before it: {len(differ)} of {len(chosen)} "
                f"scenes give other numbers in another order, {differ[0]} for one; state is kept "
                "between them"]  # fmt: skip

    def _differ(self, case: Case, a: Answer | None, b: Answer | None) -> bool:
        """Tell whether two answers differ by more than the profile passes."""
        if a is None or b is None:
            return (a is None) != (b is None)
        if a.outcome != b.outcome or set(a.values) != set(b.values):
            return True
        expected = values_of(case.expected)

        def passes(name: str, value: Value) -> float:
            if name in expected:
                return self.profile.tolerance(case, name, expected[name])
            return self.profile.allowed(length(value))

        return any(not difference(x, b.values[n]) <= passes(n, x) for n, x in a.values.items())

    def _smallest(
        self, asked: Callable[[Sequence[Scene]], Mapping[str, Answer]], found: Verdict
    ) -> dict[str, Any] | None:
        """Return the smallest scene that the candidate fails still."""
        wrong = {failure.id for failure in found.failures}
        failing = [case.scene for case in self.cases if case.id in wrong]
        if not failing:
            return None
        order = ("flight", "impact", "pitch", "at-bat")
        start = min(failing, key=lambda s: (order.index(s.kind), len(str(s.model_dump()))))

        def fails(scenes: Sequence[Any]) -> list[bool]:
            answers = asked(scenes)
            return [
                case.id in answers and not compare(case, answers[case.id], self.profile).passed
                for case in solved(scenes, Ivp())
            ]

        smallest = shrunk(start, fails).model_dump(mode="json", exclude_defaults=True)
        return {**smallest, "kind": start.kind}

    def _converge(
        self, command: Sequence[str], sweep: StepSweep, collected: Collector,
        limits: Limits | None, table: bool,
    ) -> ConvergenceReport:  # fmt: skip
        families = {case.family for case in self.cases}
        cases = sample(self.cases, FAMILIES if families > set(FAMILIES) else ())
        scenes, truth = [case.scene for case in cases], [case.expected for case in cases]
        report, issues = sweep.run(command, scenes, truth, limits, table)
        for issue in issues:
            collected.report("process", issue)
        return report

    def evaluate_function(self, solve: Callable[[Scene], Any]) -> Evaluation:
        """Judge a function from a scene to its result; see `longball.judge.judge`."""
        start = time.monotonic()
        collected = Collector([case.id for case in self.cases])
        for number, case in enumerate(self.cases, 1):
            try:
                line = line_of(case.id, solve(case.scene))
            except Exception as error:  # whatever it is, the candidate has no answer
                line = line_of(case.id, {"error": f"{type(error).__name__}: {error}"})
            collected.take_line(number, line)
        name = getattr(solve, "__name__", type(solve).__name__)
        found = self.evaluate(Submission(name, collected))
        return found.telling(seconds=time.monotonic() - start)

    def evaluate_file(
        self, path: Path, columns: Mapping[str, str] | None = None, sampling: Sampling | None = None
    ) -> Evaluation:
        """Judge a file of results; see `longball.judge.answers.read_results`."""
        collected = read_results(path, [case.id for case in self.cases], columns)
        return self.evaluate(Submission(path.name, collected, sampling=sampling))

    def evaluate_samples(self, sampling: Sampling) -> Evaluation:
        """Judge nothing but how at-bats were drawn; this needs no cases."""
        return self.evaluate(Submission(sampling.source, Collector([]), sampling=sampling))

    def evaluate(self, submission: Submission, conduct: Sequence[str] = ()) -> Evaluation:
        """Judge what a candidate has answered; `conduct` is what a second run has told."""
        answers = submission.collected.answers
        truths = self.profile.truths(self.cases)
        comparisons = [compare(case, answers.get(case.id), self.profile) for case in truths]
        diagnosis = None
        engine = self.profile.engine()
        wrong = any(not c.passed for c in comparisons)
        if self.diagnose and (conduct or wrong):
            whole = {c.id: as_written(c.scene, a) for c in self.cases if (a := answers.get(c.id))}
            scheme = engine if isinstance(engine, Verlet) else None
            failed = [c.case.id for c in comparisons if c.judged and not c.passed]
            report = submission.convergence if self.dt else None
            order = order_of(report) if report else None
            known = scheme, not conduct, failed, self.profile.error, order
            diagnosis = diagnose(truths, whole, self.dt, *known)
            diagnosis = diagnosis.model_copy(update={"conduct": list(conduct)})
            if not diagnosis.findings:
                wrong_in = {f.what for c in comparisons if not c.passed for f in failure(c).faults}
                if wrong_in:
                    sentence = f"no cause is known; what is wrong is {', '.join(sorted(wrong_in))}"
                    diagnosis = diagnosis.model_copy(update={"sentence": sentence})
        truth = engine.description if engine else self.truth
        rule = self.profile.told_of(self.cases)
        said = verdict(comparisons, submission, rule, truth, self.partial, diagnosis)
        return Evaluation(said, comparisons)


def _is_upright(scene: Any) -> bool:
    """Tell whether a scene is a flight straight up, or down, with a lift of its own axis."""
    flies = scene.kind == "flight" and scene.air is not None and scene.launch.spin is None
    return flies and not any(scene.launch.velocity[:2]) and bool(scene.air.lift_coefficient)
