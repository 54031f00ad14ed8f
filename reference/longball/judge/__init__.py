"""Holding another implementation against the truth, and telling its author what is wrong.

In another project's tests: `cases` and `assert_case`. In a notebook: `judge`. From the command
line: ``longball judge``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longball.judge.serve import serve
from longball.judge.testing import assert_case

if TYPE_CHECKING:
    from longball.judge.cases import Case, Profile
    from longball.judge.verdict import Verdict
    from longball.model.scene import Scene

__all__ = ["assert_case", "cases", "judge", "serve"]


def judge(
    candidate: Sequence[str] | Callable[[Scene], Any],
    golden: str | None = None,
    *,
    profile: Profile | None = None,
    partial: bool = False,
    dt: float | None = None,
    folder: Path | None = None,
) -> Verdict:
    """Compare an implementation with the golden data, and tell what is wrong with it.

    Parameters
    ----------
    candidate
        A command, as a list of words, that reads scenes and writes results as lines of JSON; or a
        function from a scene to its result: a mapping with the keys of one, or what
        `longball.solve` returns. What the function raises counts as no answer.
    golden
        A family of the golden data; all if left out.
    profile
        How near is near enough (`longball.judge.cases`); as near as double precision can come if
        left out.
    partial
        Whether scenes and quantities may be left out.
    dt
        s, the candidate's time step, for the diagnosis.
    folder
        Of another set of golden data than the one that comes with longball.
    """
    from longball.judge.cases import Exact
    from longball.judge.evaluation import Judge

    held = Judge(cases(golden, folder), profile or Exact(), partial=partial, dt=dt)
    if callable(candidate):
        return held.evaluate_function(candidate).verdict
    return held.evaluate_command(candidate).verdict


def cases(family: str | None = None, folder: Path | None = None) -> Sequence[Case]:
    """Return the golden cases of a family, or all; see `longball.golden.load`."""
    from longball import golden

    return golden.load(family) if folder is None else golden.load(family, folder)
