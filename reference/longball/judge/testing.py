"""The golden cases inside another project's pytest.

>>> import pytest
>>> from longball.judge import assert_case, cases
>>>
>>> @pytest.mark.parametrize("case", cases("at-bat"))
>>> def test_at_bat(case):
...     assert_case(case, my_simulator(case.scene))
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from longball.judge.answers import Answer, Collector
from longball.judge.cases import Case, Profile, as_profile
from longball.judge.quantities import told_by, values_of
from longball.judge.text import describe, flagged
from longball.judge.verdict import compare
from longball.judge.verdict import failure as failure_of
from longball.model.result import Result


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
        Whether quantities may be left out that the implementation does not compute; not all.

    Raises
    ------
    AssertionError
        With a line for each quantity that is wrong: expected with its radius, obtained, the
        error and what is allowed; and the scene.
    """
    __tracebackhide__ = True  # pytest shows the caller's line
    profile = as_profile(profile)
    (truth,) = profile.truths([case])
    answer, faults = _answer(case, obtained)
    comparison = compare(truth, answer, profile)
    if comparison.judged:
        if answer is not None and answer.error is not None:
            faults.append(f"no answer: {answer.error}")
        faults += [describe(fault) for fault in failure_of(comparison).faults]
        if not partial:
            faults += [f"{name}: is missing" for name in comparison.lacking]
        elif not comparison.measured and "outcome" in comparison.missing:
            faults.append("nothing that could be judged")
    if faults:
        lines = "\n".join(f"  {fault}" for fault in dict.fromkeys(faults))
        name = flagged(case.id, case.flags)
        raise AssertionError(f"{name}\n{lines}\n  scene: {case.scene.line()}")


def _answer(case: Case, obtained: Any) -> tuple[Answer | None, list[str]]:
    if isinstance(obtained, Result):
        values, told = values_of(obtained), told_by(obtained)
        answer = Answer(case.id, obtained.outcome, values, error=obtained.error, told=told)
        return answer, []
    collector = Collector([case.id])
    collector.take_line(1, line_of(case.id, obtained))
    faults = [issue.sentence.removeprefix(f"{case.id}: ") for issue in collector.issues]
    return collector.answers.get(case.id), faults


def line_of(scene_id: str, obtained: Any) -> bytes:
    """Return a result under an id as JSON, as another implementation's line would come."""
    obtained = getattr(obtained, "result", obtained)  # of a `longball.Solution`
    if isinstance(obtained, Result):
        obtained = json.loads(obtained.line())
    if not isinstance(obtained, Mapping):
        raise TypeError(f"a result is a mapping; not an object of type {type(obtained).__name__}")
    return json.dumps({**obtained, "id": scene_id}, default=plain).encode()


def plain(value: Any) -> Any:
    """Return NumPy's arrays and numbers as Python's."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a number, a list of them, or a mapping")
