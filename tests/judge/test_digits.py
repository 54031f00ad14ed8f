"""Candidates that write few digits or single precision, and what of their errors that explains."""

from __future__ import annotations

import math
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from longball.judge.diagnosis.diagnose import diagnose
from longball.judge.diagnosis.digits import (
    Digits,
    digits_of,
    explain_digits,
    said,
    slips,
    with_digits,
)
from longball.judge.diagnosis.residual import data_of, follow, specialised_to
from tests.judge.material import known, right, truth

WAYS = {
    "writes 6 significant digits": lambda x: f"{x:.6g}",
    "writes 4 decimals": lambda x: f"{x:.4f}",
    "writes numbers in single precision": lambda x: repr(float(np.float32(x))),
}


def written(family, way, change=lambda quantity, x: x):
    """The arguments of `explain_digits` for the truth, changed and written in a way."""
    cases = known(family)[::2]
    answers = right(cases, lambda q, xs: tuple(Decimal(way(change(q, float(x)))) for x in xs))
    data = data_of(cases, answers)
    return specialised_to(data), data, answers


@pytest.mark.parametrize("family", ["flight-both", "at-bat", "impact-oblique"])
@pytest.mark.parametrize("words", WAYS)
def test_few_digits_explain_what_they_do_to_later_stages(family, words):
    assert explain_digits(*written(family, WAYS[words])) == words


def test_full_digits_are_no_style():
    chain, data, answers = written("flight-both", repr)
    assert explain_digits(chain, data, answers) is None
    assert with_digits(data, answers) is data


@pytest.mark.parametrize("words", WAYS)
def test_a_mistake_is_still_seen_behind_few_digits(words):
    def farther(quantity, x):
        return 1.01 * x if quantity == "landing.distance" else x

    chain, data, answers = written("flight-both", WAYS[words], farther)
    assert explain_digits(chain, data, answers) is None
    _, found = follow(chain, with_digits(data, answers))
    assert {one.stage.name for one in found if one.wrong.any()} == {"distance"}


def test_one_quantity_with_few_decimals_is_told_by_its_name():
    def cut(quantity, x):
        return round(x, 1) if quantity == "landing.distance" else x

    chain, data, answers = written("flight-both", repr, cut)
    assert explain_digits(chain, data, answers) == "writes 1 decimal of landing.distance"


def test_errors_of_single_precision_that_add_up_are_told():
    draw = np.random.default_rng(3)

    def noisy(quantity, x):
        return float(np.float32(x * (1 + 2e-6 * draw.uniform(-1, 1))))

    assert explain_digits(*written("flight-both", repr, noisy)) == "computes in single precision"


def test_a_style_shows_in_numbers_that_differ():
    """A normal that is (1, 0, 0) in every scene is not rounded to one digit."""
    assert digits_of(map(Decimal, ("0.5", "0.25", "-1.25", "2"))) is not None
    assert digits_of([Decimal("1"), Decimal("0"), Decimal("-1")] * 20) is None
    full = Decimal(repr(0.1 + 0.2)), Decimal(repr(1 / 7)), Decimal(repr(2 / 7))
    assert digits_of([*full, Decimal("0.5")]) is None


def test_decimals_that_any_single_has_too_are_decimals():
    """Numbers in single precision are closer together than 1e-6 from 8 to 16."""
    draw = np.random.default_rng(1)
    numbers = [Decimal(f"{x:.6f}") for x in draw.uniform(8, 16, 60)]
    assert (style := digits_of(numbers)) == Digits("decimals", 6)
    assert style.cut == (pytest.approx(5e-7), 0.0)  # the same for large and small numbers


def test_styles_by_hand():
    numbers = [Decimal("0.00123"), Decimal("45.6"), Decimal("7")]
    ten = math.log2(10)
    assert Digits("digits", 3).bits(numbers) == pytest.approx(9 * ten)
    # With two decimals, 45.6 has four digits, 7 has three, and 0.00123 has none.
    assert Digits("decimals", 2).bits(numbers) == pytest.approx((4 + 3 + 0) * ten)
    assert Digits("single").bits(numbers) == 3 * 24
    assert Digits("digits", 3).cut == (0.0, pytest.approx(0.005))
    assert Digits("decimals", 3).cut == (pytest.approx(0.0005), 0.0)
    assert Digits("single").cut == (0.0, 2.0**-24)
    assert Digits("decimals", 1).words == "writes 1 decimal"
    assert Digits("digits", 2).words == "writes 2 significant digits"


def test_styles_of_several_quantities():
    two, three = Digits("digits", 2), Digits("decimals", 3)
    assert said({"a": two, "b": two}, ["a", "b"]) == two.words
    assert said({"a": two}, ["a", "b"]) == f"{two.words} of a"
    both = said({"a": two, "b": three, "c": two}, ["a", "b", "c"])
    assert both == f"{two.words} of a and c; {three.words} of b"


def test_single_precision_needs_numbers_that_show_it():
    draw = np.random.default_rng(1).uniform(1, 9, 20)
    single = [Decimal(repr(float(np.float32(x)))) for x in draw]
    assert digits_of(single) == Digits("single")
    assert digits_of([Decimal(f"{float(np.float32(x)):.9g}") for x in draw]) == Digits("single")
    assert digits_of([*single, Decimal(repr(1 / 7))]) is None
    assert digits_of([Decimal(f"{x:.8g}") for x in draw]) == Digits("digits", 8)


def test_what_rounding_does_to_later_numbers():
    data = truth(known("flight-both")[:30:3])
    chain = specialised_to(data)
    columns, _ = follow(chain, data)
    some = np.arange(len(data.cases))
    (flight,) = (stage for stage in chain if stage.kind == "flight")
    (distance,) = (stage for stage in chain if stage.name == "distance")

    def moved(stage, **cut):
        cut = {name.replace("_of_", "."): size for name, size in cut.items()}
        return slips(stage, replace(data, cut=cut), columns, some)

    # A distance moves with the place by its direction, whose square is 1.
    place = data.given["landing.position"]
    assert moved(distance, landing_of_position=(5e-4, 0.0)) == pytest.approx(5e-4, rel=1e-3)
    by = 1e-6 * np.hypot(*place[:2] ** 2) / np.hypot(*place[:2])
    assert moved(distance, landing_of_position=(0.0, 1e-6))[0] == pytest.approx(by, rel=1e-3)
    assert not moved(distance, landing_of_velocity=(1.0, 0.0)).any()
    # A place moves with the time by the velocity; once, if both times are rounded, √2 times.
    speed = np.abs(data.given["landing.velocity"])
    for times in (("hang_time",), ("time",), ("hang_time", "time")):
        found = moved(flight, **{f"landing_of_{name}": (1e-6, 0.0) for name in times})[:3]
        expected = 1e-6 * speed * math.sqrt(len(times))
        assert found == pytest.approx(expected, rel=1e-3, abs=1e-10)


def test_digits_that_explain_every_error_are_named():
    _, data, answers = written("impact", lambda x: f"{x:.8g}")
    (found,) = diagnose(data.cases, answers).findings
    assert found.edit == "writes 8 significant digits"
    assert found.wrong > 10
    assert 1e-8 < found.worst < 1e-5
