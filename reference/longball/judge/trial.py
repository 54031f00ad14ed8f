"""A trial from beginning to end: ask a candidate or read its file, compare, diagnose, judge."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from longball.judge.answers import Collector, read_results
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, Profile
from longball.judge.fingerprints import Fingerprints
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
    ) -> Trial:
        """Run a candidate and judge it; see `longball.judge.candidate.run`."""
        heard = run(command, [case.scene for case in self.cases], limits, progress)
        return self.judge(heard.collected, shlex.join(command), heard.errors, heard.seconds)

    def try_file(self, path: Path, columns: Mapping[str, str] | None = None) -> Trial:
        """Judge a file of results; see `longball.judge.answers.read_results`."""
        ids = [case.id for case in self.cases]
        return self.judge(read_results(path, ids, columns), path.name)

    def judge(
        self,
        collected: Collector,
        candidate: str,
        standard_error: str = "",
        seconds: float | None = None,
    ) -> Trial:
        """Judge answers."""
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
            ),
            comparisons,
        )
