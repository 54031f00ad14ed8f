"""Runs of a candidate with a family of time steps: the command, the scenes, and the order."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from longball.convergence import ConvergenceReport, Sample, chosen_steps, converge
from longball.convergence.family import PHASES
from longball.convergence.order import FEWEST
from longball.judge.answers import Answer
from longball.judge.candidate import Limits, run
from longball.judge.cases import Case, decidable
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import Scene

SAMPLE = 12  # cases of each family: enough for a typical error
FAMILIES = ("flight-both", "at-bat")  # of the golden data, by default


def takes(command: Sequence[str], name: str) -> bool:
    """True if a command has a place for the number that is varied."""
    return any(f"{{{name}}}" in word for word in command)


def filled(command: Sequence[str], name: str, word: str) -> list[str]:
    """Return a command with a word in place of ``{name}``."""
    return [part.replace(f"{{{name}}}", word) for part in command]


def parse_steps(text: str) -> list[float]:
    """Return the steps of FROM:TO:COUNT; a ValueError if it is none."""
    try:
        steps = _spread(text)
        if steps[0] <= steps[-1]:
            raise ValueError
    except ValueError:
        raise ValueError(f"--steps {text}: FROM:TO:COUNT, in s and from coarse to fine") from None
    if len(steps) < FEWEST:
        raise ValueError(f"--steps {text}: an order takes at least {FEWEST} steps")
    return steps


def _spread(text: str) -> list[float]:
    """Return COUNT numbers FROM:TO:COUNT, evenly spaced in their logarithm."""
    first, last, number = text.split(":")
    a, b, count = float(first), float(last), int(number)
    if not (0 < a < float("inf") and 0 < b < float("inf") and 2 <= count <= 1000):
        raise ValueError
    return [a * (b / a) ** (i / (count - 1)) for i in range(count)]


def parse_knob(text: str) -> tuple[str, list[str]]:
    """Return the name and the values of NAME=VALUES, the coarsest first; a ValueError if not so.

    VALUES are FROM:TO:COUNT, evenly spaced in their logarithm, or a list with commas, whose words
    stand in the command as they are. They fall, as steps do, or rise, as numbers of steps do.
    """
    name, _, values = text.partition("=")
    try:
        if not name.isidentifier():
            raise ValueError
        if ":" in values:
            words = [repr(x) for x in _spread(values)]
        else:
            words = [word.strip() for word in values.split(",")]
        sizes = [float(word) for word in words]
        if min(sizes) <= 0 or sorted(set(sizes)) not in (sizes, sizes[::-1]):
            raise ValueError
    except ValueError:
        raise ValueError(
            f"--knob {text}: NAME=FROM:TO:COUNT or NAME=VALUE,VALUE,… from coarse to fine"
        ) from None
    return name, words


def sample(cases: Sequence[Case], families: Sequence[str] = ()) -> list[Case]:
    """Return the first few cases of some families, or of all, under the default reading."""
    plain = [case for case in cases if case.scene.reading == Reading() and decidable(case)]
    chosen = dict.fromkeys(families or (case.family for case in plain))
    found = ([case for case in plain if case.family == family] for family in chosen)
    return [case for some in found for case in some[:SAMPLE]]


@dataclass(frozen=True)
class StepSweep:
    """Time steps that a candidate is run with, to see how it converges."""

    # See `longball.convergence.converge`; None: a few runs choose them.
    steps: Sequence[float] | None
    expected: float | Mapping[str, float] | None = None
    phases: int = PHASES
    # Called with the runs done, and how many there are.
    progress: Callable[[int, int], None] = lambda done, of: None
    knob: str = "dt"  # the name in braces that a step replaces
    # Steps as the command has them, where that is not the number itself, such as a number of steps.
    words: Mapping[float, str] = field(default_factory=dict)

    def filled(self, command: Sequence[str], step: float) -> list[str]:
        """Return a command with a step in its place."""
        return filled(command, self.knob, self.words.get(step, repr(step)))

    def run(
        self,
        command: Sequence[str],
        scenes: Sequence[Scene],
        truth: Sequence[Result] | None = None,
        limits: Limits | None = None,
        table: bool = False,
    ) -> tuple[ConvergenceReport, list[str]]:
        """Run a command with every step; see `converge` of `longball.convergence` and `run`.

        Also returned is what is wrong with its conduct. The limit of time in all is that of all
        runs together; none is begun after one that had to be stopped, or two of which no scene has
        an answer.
        """
        issues: list[str] = []
        done: dict[float, Sequence[Result | Sample]] = {}
        limits = limits or Limits()
        until = time.monotonic() + limits.total_seconds
        stopped = False

        def answers(step: float) -> Sequence[Result | Sample]:
            nonlocal stopped
            if step in done:
                return done[step]
            if stopped:
                return []
            left = replace(limits, total_seconds=max(0.0, until - time.monotonic()))
            ran = run(self.filled(command, step), scenes, left, table=table)
            # Stopped, or the second run without an answer: the step is not at fault.
            stopped = ran.status is None or (not ran.collected.answers and [*done.values()] == [[]])
            told = (issue for issue in ran.collected.issues if issue.kind != "unknown key")
            issues.extend(f"{self.knob} = {step:g}: {issue}" for issue in told)
            if stopped and ran.errors.strip():
                issues.append(
                    f"the end of its standard error: {ran.errors.strip().splitlines()[-1]}"
                )
            by_id = {scene.id: scene for scene in scenes}
            some = ran.collected.answers.items()
            done[step] = [_sample(answer, by_id[i]) for i, answer in some]
            return done[step]

        return converge(
            answers, scenes, self.steps or chosen_steps(answers, scenes), truth, self.expected,
            phases=self.phases, progress=self.progress,
        ), issues  # fmt: skip


def sweep_of(
    command: Sequence[str],
    steps: str | None = None,
    knob: str | None = None,
    expected: float | None = None,
    **options: Any,
) -> StepSweep | None:
    """Return the sweep of options of the command line; see `parse_steps` and `parse_knob`.

    Where the values of a knob rise, as a number of steps does, order is counted in their inverse.
    None if the command has no place for a step. A ValueError names the option that is wrong.
    """
    if knob:
        name, words = parse_knob(knob)
        if not takes(command, name):
            raise ValueError(f"--knob {knob} needs {{{name}}} in the COMMAND")
        sizes = [float(word) for word in words]
        sizes = [1 / size for size in sizes] if sizes[0] < sizes[-1] else sizes
        varied = {"knob": name, "words": dict(zip(sizes, words, strict=True))}
        return StepSweep(sizes, expected, **options | varied | {"phases": 1})
    if takes(command, "dt"):
        return StepSweep(parse_steps(steps) if steps else None, expected, **options)
    for option, given in (("--steps", steps), ("--expected", expected)):
        if given is not None:
            raise ValueError(f"{option} needs {{dt}} in the COMMAND, where its time step goes")
    return None


def _sample(answer: Answer, scene: Scene) -> Sample:
    """Return the observed numbers of an answer; sampled points are landed first."""
    if answer.path is not None:
        from longball.judge.paths import landed

        answer, _ = landed(scene, answer)
    return Sample(answer.id, answer.outcome, answer.values, error=answer.error)
