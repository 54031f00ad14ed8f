"""All engines against the golden data: each case within what its condition allows.

Nothing here is tuned to an engine. The attainable error of a quantity is what inputs that are off
by 2^-53 of themselves do to it (`longball.golden.condition`). An engine whose flights are good to
`flight_error`, relative, makes errors like inputs that are off by that much: the attainable error,
times flight_error / 2^-53. Where nothing flies, the roundings of a few dozen operations remain.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal

import pytest

from longball import golden
from longball.engines.batch import Batch
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.golden.case import ROUNDING, decisions
from longball.golden.reader import EXTENDED
from longball.model.quantities import numbers, vector_of
from longball.model.result import Bounded

STRUCK = 32  # roundings from the scene of an impact to its result, every one for the worst
DIGITS = 20

# Decided by less than the error that an engine of double precision states.
TOO_CLOSE = re.compile(
    r"hard-graze-.*-1e-1[45]|hard-dip-.*-1e-12|fence-(step|end)-.*-1e-15|"
    r"fence-(clears|hits)-1e-12|flight-kinks-wind-at"
)


FAMILIES = list(golden.header().families)


@pytest.mark.parametrize("family", FAMILIES)
def test_every_number_of_the_reference_is_as_good_as_its_condition_allows(family):
    assert [fault for case in golden.load(family) for fault in wrong(case, Ivp())] == []


@pytest.mark.sampled(every=3)  # so that each family has one engine by day
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    "engine",
    [Batch(), Enclosure(DIGITS), Multiprecision(DIGITS)],
    ids=lambda e: type(e).__name__,
)
def test_every_number_of_the_others_is_as_good_as_its_condition_allows(engine, family, nightly):
    cases = golden.load(family)
    if not nightly and not isinstance(engine, Batch):
        # These two made the data, and take longer: a sample tells whether they still would.
        if isinstance(engine, Multiprecision) and family in EXTENDED:
            pytest.skip("seconds a case: for --nightly, and some in test_against_oracle.py")
        cases = cases[::32]
    elif not nightly and family in EXTENDED:
        cases = cases[::6]  # each law is compiled: a second or two
    assert [fault for case in cases for fault in wrong(case, engine)] == []


def wrong(case: golden.Case, engine):
    """Yield a sentence for each thing that an engine has not as good as it should."""
    expected, found = case.expected, solve(case.scene, engine)
    doubles = isinstance(engine, Ivp | Batch)
    if expected.outcome is None:
        # Doubles may not see that a ball which starts inside the bat by a rounding is refused.
        if found.outcome or found.code not in {expected.code, "undecided" if doubles else None}:
            yield f"{case.id}: {expected.error} expected, {found.outcome or found.error}"
    elif decisions(found) != decisions(expected):
        many = {"many-digits", "unconfirmed"} & set(case.flags)
        close = TOO_CLOSE.fullmatch(case.id) if doubles else many
        undecided = close and found.code == "undecided"
        # The last bits of an input decide: the header allows any other answer, or none.
        if not undecided and not (doubles and "fragile" in case.flags):
            yield f"{case.id}: {expected.outcome} expected, {found.outcome or found.error}"
    else:
        values, truths = dict(numbers(found)), dict(numbers(expected))
        for name, truth in truths.items():
            if isinstance(truth, Bounded):
                error = abs(exactly(values[name]) - exactly(truth))
                allowed = tolerance(case, name, engine, values[name], truth)
                if error > allowed:
                    yield f"{case.id}: {name} is off by {error:.3g}, more than {allowed:.3g}"


def exactly(number: float | Bounded) -> Decimal:
    return Decimal(number.value if isinstance(number, Bounded) else number)


def tolerance(
    case: golden.Case, name: str, engine, found: float | Bounded, truth: Bounded
) -> Decimal:
    """Error that a number may have: what the engine proves, prints, or can attain."""
    if isinstance(engine, Enclosure):
        return Decimal(found.radius) + Decimal(truth.radius)
    if isinstance(engine, Multiprecision):
        # Its last digit is rounded, in proportion to the vector that a component is of.
        size = math.hypot(*(case.quantities[part].double for part in vector_of(name)))
        return Decimal(size) / 10 ** (DIGITS - 1)
    roundings = STRUCK if case.scene.kind == "impact" else engine.flight_error / ROUNDING
    return Decimal(case.attainable(name)) * Decimal(roundings) + Decimal(ROUNDING) * abs(
        exactly(found)
    )
