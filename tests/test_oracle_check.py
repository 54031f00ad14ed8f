"""Golden cases by the oracle in many digits; `make nightly` takes some of every family."""

import pytest
from mpmath import mpf, workdps

from tests import oracle, oracle_check

# A chain with friction and a decaying spin, a fence, and kinks of tables where the wind sets in.
QUICK = {
    "combined": "combined-at-bat-0005",
    "fence": "fence-stepped-0000",
    "flight-kinks": "flight-kinks-jump--8-from-1",
}


def case(family, name):
    return next(case for case in oracle_check.cases(family) if case["id"] == name)


@pytest.mark.parametrize("family", QUICK)
def test_a_golden_case_is_confirmed(family):
    found = oracle_check.confirm(case(family, QUICK[family]))
    assert found.digits >= oracle_check.DIGITS, found.sentence


def test_a_wrong_digit_is_noticed():
    known = case("pitch", "pitch-0001")
    result = oracle.solve(known["scene"], digits=25).result
    right, _ = oracle_check.compared(known, result)
    with workdps(25):
        result["plate"]["time"] *= 1 + mpf(10) ** -18
    wrong, sentence = oracle_check.compared(known, result)
    assert right > oracle_check.DIGITS > wrong > 17
    assert sentence.startswith("plate.time differs")


def test_another_outcome_is_noticed():
    known = case("pitch", "pitch-0001")
    digits, sentence = oracle_check.compared(known, {"outcome": "airborne"})
    assert digits == 0
    assert sentence == "outcome is crossed in the file, airborne by the oracle"
