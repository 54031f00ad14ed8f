"""Answers with proven errors: the radii hold the truth, and are hardly larger than needed."""

from __future__ import annotations

import json
import math
from decimal import Decimal

import pytest

from longball.engines import certify, create
from longball.engines.certify import Certifying
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.lines import solve_lines
from longball.model.quantities import numbers
from longball.model.result import Certified, Result
from longball.model.scene import parse_scene
from tests.scenes import paper_cases

IVP = create("ivp")
AT_BAT = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
FLIGHT = parse_scene(
    '{"id":"x","kind":"flight","launch":{"position":[0,0,1],"velocity":[35,2,20]}}'
)


def check(found: Result, truth: Result) -> None:
    """Hold radii against numbers of many more digits."""
    assert found.certificate is None
    assert found.outcome == truth.outcome
    sizes, certain = lengths(found), dict(numbers(found))
    assert all(isinstance(number, Certified) for number in certain.values())
    for name, true in numbers(truth):
        number = certain[name]
        off = abs(Decimal(number.value) - Decimal(true.value))
        radius, slack = Decimal(number.radius), Decimal(true.radius)
        assert off <= radius + slack, name
        # The ball adds as much again at most, and rounding up to two digits a tenth.
        least = max(off + slack, Decimal(sizes[name]) * Decimal(2) ** -53)
        assert radius <= Decimal("2.2") * least, name


def lengths(found: Result) -> dict[str, float]:
    """Return the length of the vector that each number is of."""
    values = {name: float(number) for name, number in numbers(found)}
    return {
        name: math.hypot(*(x for other, x in values.items() if stem(other) == stem(name)))
        for name in values
    }


def stem(name: str) -> str:
    return name.partition("[")[0]


def golden(step: int):
    answered = [case for case in paper_cases() if case.expected.outcome is not None]
    return [case for case in answered if "hard" in case.id][:: max(1, step // 2)] + answered[::step]


@pytest.mark.parametrize(
    ("engine", "step"),
    [("ivp", 20), ("batch", 40), pytest.param("ivp", 5, marks=pytest.mark.nightly)],
)
def test_the_radius_holds_golden_values(engine: str, step: int):
    """Which an independent method has confirmed."""
    held = 0
    for case in golden(step):
        found = solve(case.scene, Certifying(create(engine)))
        if found.error is None:
            check(found, case.expected)
            held += 1
    assert held > 15


@pytest.mark.parametrize("engine", ["ivp", "batch", "multiprecision"])
@pytest.mark.sampled(every=3)
def test_values_are_the_engines_own(engine: str):
    alone, found = solve(AT_BAT, create(engine)), solve(AT_BAT, Certifying(create(engine)))
    assert {n: float(x) for n, x in numbers(found)} == {n: float(x) for n, x in numbers(alone)}
    assert found.engine == alone.engine


def test_the_paper_scheme_is_told_how_far_off_it_is():
    found = solve(FLIGHT, Certifying(create("verlet", dt=0.01)))
    truth = solve(FLIGHT, IVP).landing.distance
    error = abs(found.landing.distance.value - truth)
    assert error <= float(found.landing.distance.radius) <= 1.1 * error


def test_an_outcome_that_is_wrong_is_not_certified():
    """The paper's step of 0.05 s jumps past the bat."""
    alone, found = solve(AT_BAT, create("verlet")), solve(AT_BAT, Certifying(create("verlet")))
    assert found.certificate == "the outcome is proven to be batted, not missed"
    assert found.model_copy(update={"certificate": None}) == alone


def test_a_wrong_number_gets_a_radius_that_says_so():
    alone = solve(FLIGHT, IVP)
    landing = alone.landing.model_copy(update={"distance": alone.landing.distance + 3e-3})
    found = certify.certify(FLIGHT, alone.model_copy(update={"landing": landing}))
    assert float(found.landing.distance.radius) == pytest.approx(3e-3, rel=0.05)


def test_more_digits_are_taken_where_few_leave_much_open(monkeypatch):
    monkeypatch.setattr(certify, "DIGITS", (1,))
    rough = solve(AT_BAT, Certifying(IVP))
    monkeypatch.setattr(certify, "DIGITS", (1, 20))
    fine = solve(AT_BAT, Certifying(IVP))
    check(fine, solve(AT_BAT, Enclosure(40)))
    assert float(rough.landing.distance.radius) > 10 * float(fine.landing.distance.radius)


def test_what_cannot_be_proven_says_why():
    """No number of digits tells of an exact tie."""
    tie = parse_scene(
        '{"id":"x","kind":"flight","air":null,"gravity":10,"time_limit":10,'
        '"launch":{"position":[0,0,0],"velocity":[1,0,50]}}'
    )
    found = solve(tie, Certifying(create("verlet")))
    assert found.outcome == "landed"
    assert found.certificate.startswith("the enclosure with 60 digits proves nothing: whether")
    # With an error there is nothing to certify.
    assert solve(tie, Certifying(IVP)) == solve(tie, IVP)


def test_a_number_without_a_proof_is_not_passed_over():
    alone = solve(FLIGHT, IVP)
    odd = alone.model_copy(update={"plate": solve(AT_BAT, IVP).plate})
    assert "no proof of plate.time" in certify.certify(FLIGHT, odd).certificate


def test_lines_are_certified_in_any_number_of_processes():
    lines = [AT_BAT.line().encode(), b"junk", FLIGHT.line().encode()]
    one, bad, two = solve_lines(lines, Certifying(create("batch")))
    assert (one.id, two.id) == ("x", "x")
    assert (one.failure, two.failure) == (None, None)
    assert bad.failure.startswith("line 2: not JSON")
    assert json.loads(two.text)["landing"]["distance"].keys() == {"value", "radius"}
    assert list(solve_lines(lines, Certifying(create("batch")), workers=2)) == [one, bad, two]
