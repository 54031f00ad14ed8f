"""Proven bounds: they hold the truth, they are narrow, and what is open is said to be open.

That the bounds hold the truth is asked by the golden data, which `tests/oracle.py` confirms, and in
`enclosure/` of closed forms and invariants.
"""

from __future__ import annotations

import itertools
from fractions import Fraction

import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from longball.engines.chain import solve
from longball.engines.enclosure import Balls, Enclosure
from longball.model.numbers import Undecided
from longball.model.quantities import numbers
from longball.model.result import Bounded
from longball.model.scene import (
    AtBatScene,
    Ball,
    Bat,
    Pitch,
    Swing,
)
from tests.scenes import cases_of

ENGINE = Enclosure(30)


def distance(bounded: Bounded, truth: Fraction) -> Fraction:
    return abs(Fraction(bounded.value) - truth)


def fraction(x: arb) -> Fraction:
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def at_bat(**blocks):
    return AtBatScene(id="x", **blocks)


# --- numbers --------------------------------------------------------------------------------------


@given(
    st.floats(allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30),
    st.floats(min_value=0, max_value=1e3),
    st.sampled_from([1, 3, 7]),
    st.integers(-60, 60),
    st.sampled_from([1, 7, 30]),
)
def test_a_report_contains_the_ball(middle, radius, divisor, power, digits):
    balls = Balls(digits)
    with balls.arithmetic():
        x = (arb(middle) / divisor + arb(0, radius)) * arb(10) ** power
        report = balls.report(x)
        far = fraction(x.rad())
    assert distance(report, fraction(x)) + far <= Fraction(report.radius)
    digits_written = report.value.lower().split("e")[0].lstrip("-0.").replace(".", "")
    assert len(digits_written) <= digits + 2
    assert len(report.radius.lower().split("e")[0].replace(".", "").strip("0")) <= 3


def test_only_a_proven_sign_is_told():
    balls, nothing = Balls(30), arb(0)
    assert balls.positive(arb(1, 0.5), nothing, "?")
    assert not balls.positive(arb(-1, 0.5), nothing, "?")
    assert not balls.positive(nothing, nothing, "?")
    for x in (arb(1, 2), arb(0, 1e-300), arb("nan")):
        with pytest.raises(Undecided, match="whether it rains cannot be decided with 30 digits"):
            balls.positive(x, nothing, "whether it rains")


# --- an independent method agrees -----------------------------------------------------------------


@pytest.mark.parametrize("family", ["at-bat", "flight-both", "pitch", "impact", "fence"])
@pytest.mark.sampled(every=4)
def test_more_digits_lie_within_fewer(family):
    for case in cases_of(family)[:3]:
        results = [dict(numbers(solve(case.scene, Enclosure(n)))) for n in (10, 25, 60)]
        for wide, narrow in itertools.pairwise(results):
            for key, bounded in narrow.items():
                if isinstance(bounded, Bounded):
                    off = distance(wide[key], Fraction(bounded.value))
                    assert off + Fraction(bounded.radius) <= Fraction(wide[key].radius), key


# --- what is hard ---------------------------------------------------------------------------------


STRAIGHT = {"air": None, "gravity": 0.0, "ball": Ball(radius=0.0625), "bat": Bat(radius=0.03125)}


def test_an_exact_graze_is_open():
    scene = at_bat(**STRAIGHT, swing=Swing(height_offset=0.09375))
    found = solve(scene, ENGINE)
    assert found.outcome is None
    assert "whether the ball touches the bat cannot be decided with 90 digits" in found.error
    assert found.plate is not None
    assert abs(float(found.contact.margin.value)) <= float(found.contact.margin.radius)


def test_a_release_inside_the_bat_is_refused():
    within = at_bat(**STRAIGHT, pitch=Pitch(release=(0.0937, 0.0, 1.8)))
    assert "the ball starts inside the bat" in solve(within, ENGINE).error
