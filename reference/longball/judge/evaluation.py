"""An evaluation from beginning to end: run a candidate or read its file, compare, diagnose."""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from longball.convergence import ConvergenceReport
from longball.judge.answers import Collector, read_results
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Profile
from longball.judge.fingerprints import Fingerprints
from longball.judge.sampling import Sampling
from longball.judge.search import diagnose
from longball.judge.step_sweep import FAMILIES, StepSweep, sample, with_step
from longball.judge.testing import line_of
from longball.judge.verdict import Comparison, Submission, Verdict, compare_all, verdict
from longball.model.scene import Scene


@dataclass(frozen=True)
class Evaluation:
    """A verdict and what it was made from.

    Attributes
    ----------
    verdict
        What is reported.
    comparisons
        Every case with its answer, for pictures and for JUnit.
    """

    verdict: Verdict
    comparisons: Sequence[Comparison]


@dataclass(frozen=True)
class Judge:
    """What candidates are judged by.

    Attributes
    ----------
    cases
        With their truth.
    profile
        How near is near enough.
    truth
        Where the cases are from, for the report.
    require
        Names of `longball.judge.verdict.REQUIRABLE` that must not be missing.
    diagnose
        Whether known mistakes are looked for.
    dt
        s, the candidate's time step, for the diagnosis; None if it is not known.
    """

    cases: Sequence[Case]
    profile: Profile
    truth: str = "golden data"
    require: Collection[str] = ()
    diagnose: bool = True
    dt: float | None = None

    def evaluate_command(
        self,
        command: Sequence[str],
        limits: Limits | None = None,
        progress: Callable[[int], None] = lambda answered: None,
        sweep: StepSweep | None = None,
        sampling: Sampling | None = None,
    ) -> Evaluation:
        """Run a candidate and judge it; see `longball.judge.candidate.run`.

        Parameters
        ----------
        command
            The candidate's. If {dt} is in it, `dt` goes there.
        limits, progress
            Of this run; the sweep's runs together have the same limit of time in all.
        sweep
            Time steps to run it with again, to see how it converges to the golden truth, whatever
            the profile. They are not tried with a candidate that does not end well.
        sampling
            How it draws at-bats, to be reported in the same verdict.
        """
        filled = with_step(command, self.dt) if self.dt else command
        ran = run(filled, [case.scene for case in self.cases], limits, progress)
        report = None
        if sweep and not any(issue.kind == "process" for issue in ran.collected.issues):
            report = self._converge(command, sweep, ran.collected, limits)
        elif sweep:
            ran.collected.report("process", "for that, its convergence was not looked at")
        return self.evaluate(
            Submission(shlex.join(filled), ran.collected, ran.errors, ran.seconds, report, sampling)
        )

    def _converge(
        self,
        command: Sequence[str],
        sweep: StepSweep,
        collected: Collector,
        limits: Limits | None,
    ) -> ConvergenceReport:
        families = {case.family for case in self.cases}
        cases = sample(self.cases, FAMILIES if families > set(FAMILIES) else ())
        scenes, truth = [case.scene for case in cases], [case.expected for case in cases]
        report, issues = sweep.run(command, scenes, truth, limits)
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
        return self.evaluate(Submission(name, collected, seconds=time.monotonic() - start))

    def evaluate_file(
        self,
        path: Path,
        columns: Mapping[str, str] | None = None,
        sampling: Sampling | None = None,
    ) -> Evaluation:
        """Judge a file of results; see `longball.judge.answers.read_results`."""
        collected = read_results(path, [case.id for case in self.cases], columns)
        return self.evaluate(Submission(path.name, collected, sampling=sampling))

    def evaluate_samples(self, sampling: Sampling) -> Evaluation:
        """Judge nothing but how at-bats were drawn; this needs no cases."""
        return self.evaluate(Submission(sampling.source, Collector([]), sampling=sampling))

    def evaluate(self, submission: Submission) -> Evaluation:
        """Judge what a candidate has answered."""
        answers = submission.collected.answers
        truths = self.profile.truths(self.cases)
        comparisons = compare_all(truths, answers, self.profile)
        diagnosis = None
        if self.diagnose and any(not c.passed for c in comparisons):
            prints = Fingerprints(truths, self.profile.engine(), self.dt)
            diagnosis = diagnose(prints, answers)
        engine = self.profile.engine()
        truth = engine.description if engine else self.truth
        return Evaluation(
            verdict(comparisons, submission, str(self.profile), truth, self.require, diagnosis),
            comparisons,
        )
