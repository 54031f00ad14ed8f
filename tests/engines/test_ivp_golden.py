"""The ivp engine against the golden data, each case within what its condition allows.

Nothing here is tuned to the engine. The attainable error of a quantity is what inputs that are off
by 2^-53 of themselves do to it (`longball.golden.condition`). An engine whose flights are good to
`flight_error`, relative, makes errors like inputs that are off by that much: the attainable error,
times flight_error / 2^-53. Where nothing flies, the roundings of a few dozen operations remain.
"""

from __future__ import annotations

import pytest

from longball import golden
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden.case import ROUNDING
from longball.model.quantities import numbers

ENGINE = Ivp()
FLOWN = ENGINE.flight_error / ROUNDING
STRUCK = 32  # roundings from the scene of an impact to its result, every one for the worst

# Closer than the engine's own error, which it says instead of answering.
DECLINED = {
    "hard-graze-plus-1e-14",
    "hard-graze-minus-1e-14",
    "hard-graze-plus-1e-15",
    "hard-graze-minus-1e-15",
    "hard-graze-under-plus-1e-15",
    "hard-graze-under-minus-1e-15",
    "hard-graze-level-plus-1e-15",
    "hard-graze-level-minus-1e-15",
    "hard-dip-circle-under-1e-12",
    "hard-dip-phugoid-over-1e-12",
    "fence-step-left-1e-15",
    "fence-step-right-1e-15",
    "fence-end-left-1e-15",
    "fence-end-right-1e-15",
    "fence-clears-1e-12",
    "fence-hits-1e-12",
    "flight-kinks-wind-at",
}


@pytest.mark.parametrize("family", list(golden.header().families))
def test_ivp_is_as_good_as_doubles_allow(family: str):
    cases = golden.load(family)
    faults = {case.id: fault for case in cases for fault in wrong(case)}
    known = DECLINED & {case.id for case in cases}
    assert faults.keys() == known, "\n".join(faults.values())
    for name in DECLINED & faults.keys():
        assert "cannot be decided in double precision" in faults[name]


def wrong(case: golden.Case):
    """Yield a sentence for each thing that the engine has not as good as it should."""
    result = solve(case.scene, ENGINE)
    if case.expected.outcome is None:
        return
    if result.outcome != case.expected.outcome:
        # The last bits of an input decide: the header allows any other answer, or none.
        if "fragile" not in case.flags:
            yield f"{case.id}: {case.expected.outcome} expected, {result.outcome or result.error}"
        return
    found = dict(numbers(result))
    for name, quantity in case.quantities.items():
        tolerance = case.attainable(name) * (STRUCK if case.scene.kind == "impact" else FLOWN)
        error = abs(found[name] - quantity.double)
        if error > tolerance:
            yield f"{case.id}: {name} is off by {error:.3g}, more than {tolerance:.3g}"
