"""Golden cases solved by the oracle of the tests, which shares no line with the engines."""

from __future__ import annotations

import json

import pytest

from longball import golden
from tests import nightly as by_oracle
from tests.oracle_check import LATER
from tests.scenes import FAMILIES, cases_of

EACH = 40  # cases, of which one is solved in every run; `make nightly` solves all
# In comments of kinks: a law changes its form for less than the 5 ms between the oracle's samples.
NEXT_TO = "next to"
DIP = "dip"  # the flag of a ball that grazes the ground, which the oracle's tolerance leaves out
# Of a family: cases nearer to another outcome than the oracle can tell are left out.
IN_DOUBT = 0.5


def apart(case: golden.Case) -> tuple[float | None, str]:
    """Distance of a case from the oracle's result, in tolerances; None if in doubt."""
    true = by_oracle.truth(json.loads(case.scene.as_written()))
    if true is None:
        return None, ""
    answer = json.loads(case.expected.line())
    told = dict(by_oracle.quantities(answer))
    later = [name for name in true if name not in told and name in LATER]
    true = {name: value for name, value in true.items() if name not in later}
    off, sentence = by_oracle.judged(answer, true)
    return off, f"{case.id}: {sentence}"


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.sampled(every=2)
def test_the_oracle_confirms(family: str, request):
    nightly = request.getfixturevalue("nightly")
    solved = [
        case
        for case in cases_of(family)
        if case.expected.outcome and NEXT_TO not in case.comment and DIP not in case.flags
    ]
    found = [apart(case) for case in solved[:: 1 if nightly else EACH]]
    known = [(off, sentence) for off, sentence in found if off is not None]
    assert [sentence for off, sentence in known if off > 1] == []
    assert "hard" in family or len(known) >= IN_DOUBT * len(found)
