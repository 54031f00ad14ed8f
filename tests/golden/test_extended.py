"""The families of real baseball: their cases are many, proven and confirmed."""

import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden.reader import EXTENDED
from tests.scenes import cases_of

CASES = {family: cases_of(family) for family in EXTENDED}


@pytest.mark.parametrize("family", EXTENDED)
def test_there_are_enough_and_all_are_proven_and_confirmed(family):
    few = family in ("hard-real", "defaults", "various-real")  # with no law of their own
    assert len(CASES[family]) >= (30 if few else 40)
    for case in CASES[family]:
        assert not {"unconfirmed", "wide"} & set(case.flags), case.id
        assert (case.expected.outcome is None) is bool({"refused", "undecided"} & set(case.flags))


def test_doubles_decide_a_touch_of_a_node_but_not_of_a_wind():
    """On both sides of a node forces are the same; where a wind sets in, they jump."""
    by_name = {case.id.removeprefix("flight-kinks-"): case for case in CASES["flight-kinks"]}
    for name in ("speed-node-at", "spin-node-at"):
        found, true = (solve(by_name[name].scene, Ivp()), by_name[name].expected)
        expected = [float(x) for x in true.landing.position]
        assert found.landing.position == pytest.approx(expected, abs=1e-12)
    assert solve(by_name["wind-at"].scene, Ivp()).code == "undecided"
