"""All engines against the golden data: each case within what its condition allows.

Nothing here is tuned to an engine. The attainable error of a quantity is what inputs that are off
by 2^-53 of themselves do to it (`longball.golden.condition`). An engine whose flights are good to
`flight_error`, relative, makes errors like inputs that are off by that much: the attainable error,
times flight_error / 2^-53. Where nothing flies, the roundings of a few dozen operations remain.

Verlet's scheme is held to what its step allows. It meets the bat at its steps, to the first order,
so that `test_verlet.py` asks it for at-bats; and dips of less than a step it does not see.
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
from longball.engines.verlet import Verlet
from longball.golden.case import ROUNDING, decisions
from longball.golden.reader import EXTENDED
from longball.model.quantities import numbers, vector_of
from longball.model.result import Bounded
from tests.scenes import FAMILIES, case_of, cases_of

STRUCK = 32  # roundings from the scene of an impact to its result, every one for the worst
DIGITS = 20

# The errors of the scheme are like those of inputs that are off by Δt² times a few changes of the
# force in 1 s²; by Δt times them in families where a law changes its form within a step.
SCHEME, SMOOTH, KINKED = Verlet(1e-3, forces="implicit"), 2e-6, 2e-4
KINKS = re.compile(r"(flight-kinks|flight-side|hard-real|combined|various-real)-.*")

# Decided by less than the error that an engine of double precision states.
TOO_CLOSE = re.compile(
    r"hard-graze-.*-1e-1[45]|hard-dip-.*-1e-12|fence-(step|end)-.*-1e-15|"
    r"fence-(clears|hits)-1e-12|flight-kinks-wind-at"
)
TOO_CLOSE_FOR_STEPS = re.compile(
    r"fence-(step|end)-.*-1e-15|fence-(clears|hits)-1e-(09|12)|fence-circle-over"
)

# What an engine does not do as well as a case's condition allows, and by what rule it ought to.
KNOWN = {
    ("hard-upright-up-1e-16", "Multiprecision"): "digits are those of the way flown, not of x",
    ("hard-upright-up-1e-30", "Multiprecision"): "digits are those of the way flown, not of x",
    ("hard-ground-up-by-1e-30", "Multiprecision"): "a hop of 1e-61 m is below the height's digits",
    ("impact-oblique-no-rub", "Multiprecision"): "energies cancel but for the guard digits",
    ("hard-real-parallel-nearly-30", "Batch"): "truncation is relative to the speed, x to 1e-7 m",
    ("various-real-0090", "Verlet"): "the path through the air is a part in 900 too long",
}


@pytest.mark.parametrize("family", FAMILIES)
def test_every_number_of_the_reference_is_as_good_as_its_condition_allows(family, nightly):
    # Of the extended model many a case has a law of its own, which takes a tenth of a second.
    cases = cases_of(family)[:: 3 if family in EXTENDED and not nightly else 1]
    assert [fault for case in cases for fault in wrong(case, Ivp())] == []


@pytest.mark.sampled(every=3)  # so that each family has one engine by day
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    "engine",
    [Batch(), Enclosure(DIGITS), Multiprecision(DIGITS)],
    ids=lambda e: type(e).__name__,
)
def test_every_number_of_the_others_is_as_good_as_its_condition_allows(engine, family, nightly):
    cases = held(family, engine)
    if not nightly and not isinstance(engine, Batch):
        # These two made the data, and take longer: a sample tells whether they still would.
        if isinstance(engine, Multiprecision) and family in EXTENDED:
            pytest.skip("seconds a case: for --nightly, and some in test_against_oracle.py")
        cases = cases[::31]
    elif not nightly and family in EXTENDED:
        cases = cases[::7]  # each law is compiled: a second or two
    assert [fault for case in cases for fault in wrong(case, engine)] == []


@pytest.mark.parametrize(
    ("identity", "engine"),
    [
        pytest.param(*known, marks=pytest.mark.xfail(reason=why, strict=True))
        for known, why in KNOWN.items()
    ],
)
def test_what_an_engine_does_not_do_as_well(identity, engine):
    engines = {type(e).__name__: e for e in (Batch(), Multiprecision(DIGITS), SCHEME)}
    assert [*wrong(case_of(identity), engines[engine])] == []


@pytest.mark.sampled(every=2)
@pytest.mark.parametrize("family", [family for family in FAMILIES if family != "hard"])
def test_the_scheme_is_as_good_as_its_step_allows(family, nightly):
    cases = [case for case in held(family, SCHEME) if case.scene.kind != "at-bat"]
    faults = [fault for case in cases[:: 1 if nightly else 5] for fault in wrong(case, SCHEME)]
    assert faults == []


def held(family: str, engine) -> list[golden.Case]:
    """The cases of a family that an engine has to have right."""
    return [c for c in cases_of(family) if (c.id, type(engine).__name__) not in KNOWN]


def wrong(case: golden.Case, engine):
    """Yield a sentence for each thing that an engine has not as good as it should."""
    expected, found = case.expected, solve(case.scene, engine)
    doubles = isinstance(engine, Ivp | Batch | Verlet)
    if expected.outcome is None:
        # Doubles may not see that a ball which starts inside the bat by a rounding is refused, nor
        # steps where a force has no direction.
        codes = {expected.code, "undecided" if doubles else None}
        codes |= {"out_of_range"} if engine is SCHEME else set()
        if found.outcome or found.code not in codes:
            yield f"{case.id}: {expected.error} expected, {found.outcome or found.error}"
    elif decisions(found) != decisions(expected):
        if not may_differ(case, found, engine):
            yield f"{case.id}: {expected.outcome} expected, {found.outcome or found.error}"
    else:
        values, truths = dict(numbers(found)), dict(numbers(expected))
        for name, truth in truths.items():
            if isinstance(truth, Bounded):
                error = abs(exactly(values[name]) - exactly(truth))
                allowed = tolerance(case, name, engine, values[name], truth)
                if error > allowed:
                    yield f"{case.id}: {name} is off by {error:.3g}, more than {allowed:.3g}"


def may_differ(case: golden.Case, found, engine) -> bool:
    """True if an answer may decide otherwise than the data, or not at all."""
    undecided = found.code == "undecided"
    if isinstance(engine, Enclosure | Multiprecision):
        return undecided and bool({"many-digits", "unconfirmed"} & set(case.flags))
    # The last bits of an input decide: the header allows any other answer, or none.
    if "fragile" in case.flags:
        return True
    if engine is SCHEME:
        return TOO_CLOSE_FOR_STEPS.fullmatch(case.id) is not None
    return undecided and TOO_CLOSE.fullmatch(case.id) is not None


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
    roundings = STRUCK if case.scene.kind == "impact" else error_of(case, engine) / ROUNDING
    return Decimal(case.attainable(name)) * Decimal(roundings) + Decimal(ROUNDING) * abs(
        exactly(found)
    )


def error_of(case: golden.Case, engine) -> float:
    """Relative error of the inputs that would do as much as an engine's errors."""
    if engine is SCHEME:
        return KINKED if KINKS.fullmatch(case.id) else SMOOTH
    return engine.flight_error
