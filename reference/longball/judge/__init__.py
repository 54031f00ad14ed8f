"""Comparison of another implementation with the truth, and diagnosis of its mistakes.

In another project's tests: `cases` and `assert_case`. In a notebook: `judge`. From the command
line: ``longball judge``.

>>> import pytest
>>> from longball.judge import assert_case, cases
>>>
>>> @pytest.mark.parametrize("case", cases("at-bat"))
>>> def test_at_bat(case):
...     assert_case(case, my_simulator(case.scene))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longball.judge.answers import Collector, line_of
from longball.judge.cases import Case, Profile, completed, lacking
from longball.judge.cases import profile as profile_of
from longball.judge.serve import serve
from longball.judge.text import describe, flagged
from longball.judge.verdict import Verdict, compare

if TYPE_CHECKING:
    from longball.model.scene import Scene

__all__ = ["assert_case", "cases", "judge", "serve"]


def judge(
    candidate: Sequence[str] | Callable[[Scene], Any],
    golden: str | None = None,
    *,
    profile: Profile | str | None = None,
    partial: bool = False,
    dt: float | None = None,
    folder: Path | None = None,
) -> Verdict:
    """Compare an implementation with the golden data, and diagnose its mistakes.

    Parameters
    ----------
    candidate
        A command, as a list of words, that reads scenes and writes results as lines of JSON; or a
        function from a scene to its result: a mapping with the keys of one, or what
        `longball.solve` returns. An exception in the function counts as a refusal.
    golden
        A family of the golden data, or "all"; the families of the paper's model if left out.
    profile
        The accuracy required: "exact", "converged" or "paper", or one with another number,
        such as ``longball.judge.cases.Converged(1e-4)``; "exact" if left out.
    partial
        True to accept missing scenes and quantities.
    dt
        The candidate's time step, s, for the diagnosis.
    folder
        Folder of a set of golden data, in place of the one that comes with longball.

    Returns
    -------
    Verdict
        ``passed``, ``reasons``, ``diagnosis`` and so on; ``print`` shows it as the command does.

    Raises
    ------
    OSError
        If the command cannot be started.
    TypeError
        If the candidate is neither a command nor a function.
    ValueError
        If there is no such family or profile.
    """
    from longball.judge.evaluation import Judge  # brings the diagnosis with it

    truth = "golden data" if golden is None else f"golden data, {golden}"
    held = Judge(cases(golden, folder), profile_of(profile), truth, partial=partial, dt=dt)
    if callable(candidate):
        return held.evaluate_function(candidate).verdict
    if isinstance(candidate, str) or not isinstance(candidate, Sequence) or not candidate:
        raise TypeError(
            "a candidate is a command, as a list of words, or a function from a scene to its "
            f"result; not {candidate!r}"
        )
    return held.evaluate_command(candidate).verdict


def cases(family: str | None = None, folder: Path | None = None) -> Sequence[Case]:
    """Return the golden cases of a family, "all", or those of the paper's model.

    Parameters are those of `longball.golden.load`.
    """
    from longball import golden

    return golden.load(family) if folder is None else golden.load(family, folder)


def assert_case(
    case: Case, obtained: Any, profile: Profile | str | None = None, partial: bool = False
) -> None:
    """Assert that a result is right, to the case's own tolerance.

    Parameters
    ----------
    case
        From `cases`.
    obtained
        The result: a mapping with the keys of one, or what `longball.solve` returns. The id may be
        left out.
    profile
        The accuracy required, as in `longball.judge.judge`.
    partial
        True to accept results that omit quantities, but not all of them.

    Raises
    ------
    AssertionError
        With a line for each quantity that is wrong: expected with its radius, obtained, the
        error and what is allowed; and the scene.
    """
    __tracebackhide__ = True  # pytest shows the caller's line
    rule = profile_of(profile)
    (truth,) = rule.truths([case])
    collector = Collector([case.id])
    collector.take_line(1, line_of(case.id, obtained))
    faults = [issue.sentence.removeprefix(f"{case.id}: ") for issue in collector.issues]
    answer = collector.answers.get(case.id)
    if answer is not None:
        truth = completed(truth, lacking(truth, answer.values))
    comparison = compare(truth, answer, rule)
    if comparison.judged:
        if answer is not None and answer.error is not None:
            faults.append(f"no answer: {answer.error}")
        faults += map(describe, comparison.faults)
        if not partial:
            faults += [f"{name}: is missing" for name in comparison.lacking]
        elif not comparison.measured and "outcome" in comparison.missing:
            faults.append("nothing that could be judged")
    if faults:
        lines = "\n".join(f"  {fault}" for fault in dict.fromkeys(faults))
        name = flagged(case.id, case.flags)
        raise AssertionError(f"{name}\n{lines}\n  scene: {case.scene.line()}")
