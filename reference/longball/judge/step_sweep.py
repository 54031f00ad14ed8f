"""A candidate run with a family of time steps: the command, the scenes, and what is wrong."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from longball.convergence import ConvergenceReport, converge
from longball.convergence.family import PHASES
from longball.judge.answers import as_result
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, decidable
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import Scene

PLACE = "{dt}"  # in a command, where its time step goes

SAMPLE = 12  # cases of each family: enough for a typical error
FAMILIES = ("flight-both", "at-bat")  # of the golden data, where no other is asked for
STEPS = "0.01:0.0001:9"  # s, evenly spaced in their logarithm


def takes_step(command: Sequence[str]) -> bool:
    """Tell whether a command has a place for a time step."""
    return any(PLACE in word for word in command)


def with_step(command: Sequence[str], step: float) -> list[str]:
    """Return a command with a time step in its place."""
    return [word.replace(PLACE, repr(step)) for word in command]


def parse_steps(text: str) -> list[float]:
    """Return the steps of FROM:TO:COUNT, evenly spaced in their logarithm.

    Raises
    ------
    ValueError
        If it is none.
    """
    try:
        first, last, number = text.split(":")
        coarse, fine, count = float(first), float(last), int(number)
        if not (0 < fine < coarse < float("inf") and 2 <= count <= 1000):
            raise ValueError
    except ValueError:
        raise ValueError(f"--steps {text}: FROM:TO:COUNT, in s and from coarse to fine") from None
    return [coarse * (fine / coarse) ** (i / (count - 1)) for i in range(count)]


def sample(cases: Sequence[Case], families: Sequence[str] = ()) -> list[Case]:
    """Return the first few cases of some families, or of all, under the default reading."""
    plain = [case for case in cases if case.scene.reading == Reading() and decidable(case)]
    chosen = dict.fromkeys(families or (case.family for case in plain))
    return [
        case
        for family in chosen
        for case in [case for case in plain if case.family == family][:SAMPLE]
    ]


@dataclass(frozen=True)
class StepSweep:
    """Time steps that a candidate is run with, to see how it converges.

    Attributes
    ----------
    steps, expected, phases
        See `longball.convergence.converge`.
    progress
        Called with the runs done, and how many there are.
    """

    steps: Sequence[float]
    expected: float | Mapping[str, float] | None = None
    phases: int = PHASES
    progress: Callable[[int, int], None] = lambda done, of: None

    def run(
        self,
        command: Sequence[str],
        scenes: Sequence[Scene],
        truth: Sequence[Result] | None = None,
        limits: Limits | None = None,
    ) -> tuple[ConvergenceReport, list[str]]:
        """Run a command with every step; see `longball.convergence.converge`.

        The limit of time in all is that of all runs together; after a run that had to be stopped,
        no other is begun.

        Returns
        -------
        report, issues
            How it converges, and what is wrong with its conduct, each with its time step.
        """
        issues: list[str] = []
        limits = limits or Limits()
        until = time.monotonic() + limits.total_seconds
        stopped = False

        def answers(step: float) -> Sequence[Result]:
            nonlocal stopped
            if stopped:
                return []
            left = replace(limits, total_seconds=max(0.0, until - time.monotonic()))
            ran = run(with_step(command, step), scenes, left)
            stopped = ran.status is None
            issues.extend(f"dt = {step:g}: {issue}" for issue in ran.collected.issues)
            return [as_result(answer) for answer in ran.collected.answers.values()]

        report = converge(
            answers,
            scenes,
            self.steps,
            truth,
            self.expected,
            phases=self.phases,
            progress=self.progress,
        )
        return report, issues
