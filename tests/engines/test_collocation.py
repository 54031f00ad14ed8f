"""The multiprecision engine, by Gauss-Legendre collocation: steps, events on a segment, digits."""

from __future__ import annotations

import math
import pickle
from itertools import pairwise
from typing import Any

import pytest

from longball.engines.multiprecision import Multiprecision, SegmentCurve
from longball.model.law import Law, PlaneState, Shape, law_with
from longball.model.numbers import DOUBLES
from longball.model.result import Bounded
from longball.model.trace import Program, variable

DIGITS = 10
METHOD = Multiprecision(DIGITS)
CONTEXT = METHOD.numbers.context
exact = CONTEXT.mpf


def plane_law(**strengths: float) -> Any:
    return law_with({name: exact(k) for name, k in strengths.items()})


def launched(z: float, u: float, w: float) -> PlaneState:
    return PlaneState(exact(0), exact(z), exact(u), exact(w))


# --- the choice of steps --------------------------------------------------------------------------


def test_segments_join_and_reach_the_end() -> None:
    law = plane_law(drag=0.0075, lift=0.00375, gravity=9.8)
    begin, end = exact(1.25), exact(9)
    start = launched(1.0, 30.0, 30.0)
    segments = list(METHOD.steps(law, start, begin, end, ()))
    assert (segments[0].begin, segments[0].start) == (begin, start)
    assert 2 < len(segments) < 40
    for before, after in pairwise(segments):
        assert after.begin == before.begin + before.length
        assert after.start == before.end == before.at(before.length)
        assert after.at(exact(0)) == after.start
        assert after.begin < end
    last = segments[-1]
    assert end <= last.begin + last.length < end + 1e-20
    for segment in segments:
        # The polynomials end where the next segment begins, and satisfy the law between the nodes.
        near = segment.at(segment.length * (1 - 4 * CONTEXT.eps))
        for x, y in zip(near, segment.end, strict=True):
            assert abs(x - y) < 1e-24
        t, h = segment.length * exact(0.37), exact(10) ** -9
        rates, low, high = segment.rates(t), segment.at(t - h), segment.at(t + h)
        for rate, a, b in zip(rates, low, high, strict=True):
            assert abs((b - a) / (2 * h) - rate) < 1e-14


@pytest.mark.parametrize("power", [-300, 0, 300])
def test_a_matrix_is_as_good_for_values_of_any_size(power: int) -> None:
    """The integral of 1 from -1 to a node is 1 more than the node; of -P₁, half of 1 - x²."""
    rule, unit = METHOD.numbers.rule, exact(2) ** power
    ones = [unit] * rule.count
    nodes = [x - unit for x in rule.integrals @ ones]
    for x, y in zip(nodes, rule.integrals @ [-x for x in nodes], strict=True):
        assert abs(y - (unit - x * x / unit) / 2) < 8 * CONTEXT.eps * unit


# --- events on a segment --------------------------------------------------------------------------


@pytest.fixture(scope="module")
def parabola() -> Any:
    """A segment of 4 s of ``z = 12 t - 4 t²`` (gravity 8): up to 9 at 1.5 s, down at 3 s."""
    law = plane_law(gravity=8.0)
    (segment,) = METHOD.steps(law, launched(0.0, 60.0, 12.0), exact(0), exact(4), ())
    return segment


def curve(segment: Any, value: Any) -> SegmentCurve:
    found = segment.curve(value)
    assert isinstance(found, SegmentCurve)
    return found


def test_the_turns_of_a_value_are_all_found(parabola: Any) -> None:
    zero, end = exact(0), parabola.length
    (top,) = curve(parabola, lambda y: y.z).turns(zero, end)
    assert abs(top - 1.5) < 1e-28
    # (z - 5)² turns where z is 5, at 1/2 and 5/2, and at the top.
    squared = curve(parabola, lambda y: (y.z - 5) * (y.z - 5))
    found = squared.turns(zero, end)
    for t, wanted in zip(found, (0.5, 1.5, 2.5), strict=True):
        assert abs(t - wanted) < 1e-28
    assert [float(t) for t in squared.turns(exact(1), exact(2))] == [1.5]
    assert squared.turns(exact(1.75), exact(2.25)) == []
    assert curve(parabola, lambda y: y.s).turns(zero, end) == []
    assert curve(parabola, lambda y: y.u).turns(zero, end) == []


def test_where_a_value_falls_through_zero(parabola: Any) -> None:
    height, z = curve(parabola, lambda y: y.z), parabola.end.z
    assert abs(height.zero(exact(1.5), exact(4)) - 3) < 1e-28
    low = curve(parabola, lambda y: y.z - 8)
    assert abs(low.zero(exact(1.5), exact(4)) - 2) < 1e-28
    # Where it is nowhere positive, it is there from the beginning; a zero at an end is one.
    assert height.zero(exact(3.25), exact(4)) == 3.25
    assert height.zero(exact(0), exact(4)) == 0
    assert curve(parabola, lambda y: y.z - z).zero(exact(1.5), parabola.length) == parabola.length


@pytest.mark.parametrize(("floor", "above"), [(-16.1, True), (-16 - 1e-9, False), (-30.0, True)])
def test_whether_a_value_is_certainly_positive(parabola: Any, floor: float, above: bool) -> None:
    """With x from -1 to 1 it is 8/3 - 8 P₁ - 32/3 P₂: at least 8/3 - 8 - 32/3 = -16."""
    assert curve(parabola, lambda y: y.z - floor).positive(exact(0), exact(4)) is above


@pytest.mark.parametrize(("outputs", "wanted"), [("y", (math.e,)), ("xy", (math.e, math.e))])
def test_a_rate_that_is_a_variable_is_an_integral_only_of_another_one(outputs, wanted) -> None:
    """y' = y; and x' = y with it: both are e^t."""
    names = tuple(outputs)
    program = Program(names, (), tuple(variable("y") for _ in names))
    law = Law(program, {}, Shape())
    start = law.state(*(exact(1) for _ in names))
    *_, last = METHOD.steps(law, start, exact(0), exact(1), ())
    assert [float(x) for x in last.end] == pytest.approx(wanted, rel=1e-13)


# --- the engine as an object ----------------------------------------------------------------------


def test_an_engine_travels_to_another_process():
    assert pickle.loads(pickle.dumps(Multiprecision(30))) == Multiprecision(30)


@pytest.mark.parametrize("numbers", [METHOD.numbers, DOUBLES])
def test_a_rounding_is_half_of_the_last_place(numbers):
    one = numbers.exact(1.0)
    assert one + numbers.rounding == one < one + 2 * numbers.rounding


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.0, "0.0"),
        (0.1, "0.10000"),
        (-1e-30, "-1.0000e-30"),
        (123456.0, "1.2346e+5"),
        (12345.0, "12345"),
    ],
)
def test_numbers_are_written_with_their_digits(x, text):
    """The pattern of `Bounded` is checked as it is made."""
    numbers = Multiprecision(5).numbers
    assert numbers.report(numbers.exact(x)) == Bounded(value=text)
