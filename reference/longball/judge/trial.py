"""A trial from beginning to end: ask a candidate or read its file, compare, diagnose, judge."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from longball.judge.answers import Collector, read_results
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Profile
from longball.judge.convergence_report import ConvergenceReport
from longball.judge.fingerprints import Fingerprints
from longball.judge.ladder import FAMILIES, converge_command, sample, with_step
from longball.judge.sampling import Sampling
from longball.judge.search import diagnose
from longball.judge.verdict import Comparison, Verdict, compare_all, verdict


@dataclass(frozen=True)
class Trial:
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
class Ladder:
    """Time steps that a candidate is run with, to see how it converges.

    Attributes
    ----------
    steps
        s; see `longball.judge.convergence.converge`.
    expected
        The order in theory; None if nobody says.
    progress
        Is told the runs done, and how many there are.
    """

    steps: Sequence[float]
    expected: float | None = None
    progress: Callable[[int, int], None] = lambda done, of: None


@dataclass(frozen=True)
class Court:
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

    def try_command(
        self,
        command: Sequence[str],
        limits: Limits | None = None,
        progress: Callable[[int], None] = lambda answered: None,
        ladder: Ladder | None = None,
        sampling: Sampling | None = None,
    ) -> Trial:
        """Run a candidate and judge it; see `longball.judge.candidate.run`.

        Parameters
        ----------
        command
            The candidate's. If {dt} is in it, `dt` goes there.
        limits, progress
            Of this run; the ladder's together have the same limit of time in all.
        ladder
            Time steps to run it with again, to see how it converges to the golden truth, whatever
            the profile. They are not tried with a candidate that does not end well.
        sampling
            How it draws at-bats, to be told in the same verdict.
        """
        words = with_step(command, self.dt) if self.dt else command
        heard = run(words, [case.scene for case in self.cases], limits, progress)
        report = None
        if ladder and not any(c.kind == "process" for c in heard.collected.complaints):
            report = self._converge(command, ladder, heard.collected, limits)
        elif ladder:
            heard.collected.complain("process", "for that, its convergence was not looked at")
        return self.judge(
            heard.collected,
            shlex.join(words),
            heard.errors,
            heard.seconds,
            convergence=report,
            sampling=sampling,
        )

    def _converge(
        self,
        command: Sequence[str],
        ladder: Ladder,
        collected: Collector,
        limits: Limits | None,
    ) -> ConvergenceReport:
        families = {case.family for case in self.cases}
        cases = sample(self.cases, FAMILIES if families > set(FAMILIES) else ())
        report, complaints = converge_command(
            command,
            [case.scene for case in cases],
            ladder.steps,
            [case.expected for case in cases],
            ladder.expected,
            limits=limits,
            progress=ladder.progress,
        )
        for complaint in complaints:
            collected.complain("process", complaint)
        return report

    def try_file(
        self,
        path: Path,
        columns: Mapping[str, str] | None = None,
        sampling: Sampling | None = None,
    ) -> Trial:
        """Judge a file of results; see `longball.judge.answers.read_results`."""
        ids = [case.id for case in self.cases]
        return self.judge(read_results(path, ids, columns), path.name, sampling=sampling)

    def try_samples(self, sampling: Sampling) -> Trial:
        """Judge nothing but how at-bats were drawn; this needs no cases."""
        return self.judge(Collector([]), sampling.source, sampling=sampling)

    def judge(
        self,
        collected: Collector,
        candidate: str,
        standard_error: str = "",
        seconds: float | None = None,
        convergence: ConvergenceReport | None = None,
        sampling: Sampling | None = None,
    ) -> Trial:
        """Judge answers; what was found beside them is told in the same verdict."""
        truths = self.profile.truths(self.cases)
        comparisons = compare_all(truths, collected, self.profile)
        diagnosis = None
        if self.diagnose and any(not c.passed for c in comparisons):
            prints = Fingerprints(truths, self.profile.engine(), self.dt)
            diagnosis = diagnose(prints, collected.answers)
        return Trial(
            verdict(
                comparisons,
                collected,
                self.profile,
                candidate=candidate,
                truth=self.truth,
                require=self.require,
                standard_error=standard_error,
                seconds=seconds,
                diagnosis=diagnosis,
                convergence=convergence,
                sampling=sampling,
            ),
            comparisons,
        )
