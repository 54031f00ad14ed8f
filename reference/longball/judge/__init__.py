"""Holding another implementation against the truth, and telling its author what is wrong.

In another project's tests: `cases` and `assert_case`. From the command line: ``longball judge``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from longball.judge.serve import serve
from longball.judge.testing import assert_case

if TYPE_CHECKING:
    from longball.judge.cases import Case

__all__ = ["assert_case", "cases", "serve"]


def cases(family: str | None = None, folder: Path | None = None) -> Sequence[Case]:
    """Return the golden cases of a family, or all; see `longball.golden.load`."""
    from longball import golden

    return golden.load(family) if folder is None else golden.load(family, folder)
