"""Mistakes that no golden case noticed before version 1.1; `test_defaults` has others."""

from __future__ import annotations

import pytest

from longball.golden.reader import header
from longball.judge import coverage as module
from longball.judge.cases import decidable
from longball.judge.coverage import LIMITS, coverage
from longball.judge.diagnosis.chain import CHAIN, I
from longball.judge.diagnosis.expression import constant
from longball.judge.diagnosis.operators import Edit
from tests.scenes import cases_of

ENOUGH = 3  # cases
FAMILIES = "defaults", "various-real", "flight-spin-drag"
ORDINARY = [name for name in header().families if not name.startswith("hard")]


@pytest.fixture(scope="module")
def counts() -> dict[str, int]:
    """Number of cases of a few families that notice each mistake that no operator makes."""
    spin = Edit(I["drag.per_spin"], constant(0.0, I["drag.per_spin"].dimension), 0.0, "no spin")
    (flight,) = [s for s in CHAIN if s.name == "flight"]
    beside = [*module.every_edit(0)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "every_edit", lambda every: [*beside, (flight, spin)])
        found = coverage([case for name in FAMILIES for case in cases_of(name)])
    return {e.words: int(row.sum()) for e, row in zip(found.edits, found.noticed, strict=True)}


@pytest.mark.parametrize(
    "words",
    [
        "no spin",
        "lifts a ball of spin 0 as one without",
        "counts the heights of a wind profile from the ground",
    ],
)  # fmt: skip
def test_a_mistake_is_noticed(counts: dict[str, int], words: str):
    assert counts[words] >= ENOUGH


def test_a_time_limit_is_not_cut_to_whole_seconds():
    (cut,) = [one for one in LIMITS if "whole seconds" in one.words]
    cases = (case for name in ORDINARY for case in cases_of(name) if decidable(case))
    assert sum(cut.notices(case) for case in cases) >= ENOUGH
