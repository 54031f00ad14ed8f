"""Traced formulas: the same value, each operation once, nothing of what is absent."""

import math

import mpmath
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from longball.model import trace
from longball.model.numbers import DOUBLES
from longball.model.trace import Node, parameter, variable

X, Y, K = variable("x"), variable("y"), parameter("k")


def value(node, x=0.7, y=1.9, k=0.3, functions=DOUBLES.functions):
    program = trace.Program(("x", "y"), ("k",), (node,))
    return program.bind({"k": k}, functions)(x, y)[0]


# A formula is built from its own text, so that Python evaluates the same one without a trace.
LEAVES = ["x", "y", "k", "2.0", "0.0", "1.0", "(-3.0)"]
formulas = st.recursive(
    st.sampled_from(LEAVES),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        inner.map(lambda a: f"(-{a})"),
        inner.map(lambda a: f"sqrt({a} * {a} + 1.0)"),
        inner.map(lambda a: f"exp({a} / ({a} * {a} + 1.0))"),
        inner.map(lambda a: f"log({a} * {a} + 2.0)"),
    ),
    max_leaves=12,
)


def evaluated(text, x, y, k, functions):
    return eval(text, {"x": x, "y": y, "k": k, **functions})


@given(formulas, st.integers(-20, 20), st.integers(-20, 20), st.integers(1, 20))
def test_a_traced_formula_has_its_own_value(text, x, y, k):
    """In 60 digits, of which a dozen operations keep 40 unless they cancel or blow up."""
    with mpmath.workdps(60):
        numbers = [mpmath.mpf(n) / 7 for n in (x, y, k)]
        functions = {"sqrt": mpmath.sqrt, "exp": mpmath.exp, "log": mpmath.log}
        try:
            wanted = evaluated(text, *numbers, functions)
        except ZeroDivisionError:
            return
        assume(abs(wanted) < 1e10)
        try:
            node = evaluated(
                text, X, Y, K, {"sqrt": trace.sqrt, "exp": trace.exp, "log": trace.log}
            )
        except ArithmeticError:  # a division by nothing, or constants that are no doubles
            assume(False)
        if isinstance(node, float):
            node = trace.constant(node)
        assert isinstance(node, Node)
        try:
            found = value(node, *numbers, functions)
        except ZeroDivisionError:
            assume(False)
        assert abs(found - wanted) <= mpmath.mpf(10) ** -40 * (1 + abs(wanted))


@pytest.mark.parametrize("absent", [X * 0, 0 * X, X - X, 0 / X, K * 0])
def test_what_is_multiplied_by_nothing_is_gone(absent):
    assert absent is trace.ZERO


@pytest.mark.parametrize("node", [X, K, K + K])
def test_what_is_added_to_nothing_is_as_it_was(node):
    assert node + 0.0 is 0.0 + node is node


def test_static_factors_stand_before_products():
    product = (K * X) * (2 * Y)
    assert product.kind == "sum"
    ((coefficient, node),) = product.args[1:]
    assert coefficient.static
    assert node is X * Y


def test_static_factors_stand_before_quotients():
    assert (K * X) / Y is K * (X / Y)
    assert X / (K * Y) is (1 / K) * (X / Y)


@pytest.mark.parametrize(
    "formula",
    [
        X * X * Y,
        X / Y + K * X,
        trace.sqrt(X * X + Y * Y),
        trace.sqrt(X + 2),
        trace.exp(K * X * Y),
        trace.log(X * Y + 3),
    ],
)
def test_derivatives_are_those_of_small_differences(formula):
    for by, (dx, dy) in ((X, (1e-6, 0.0)), (Y, (0.0, 1e-6))):
        slope = value(trace.derivative(formula, by))
        up, down = value(formula, 0.7 + dx, 1.9 + dy), value(formula, 0.7 - dx, 1.9 - dy)
        assert slope == pytest.approx((up - down) / 2e-6, rel=1e-8)  # rounding over the step


def test_the_derivative_of_a_size_is_bounded():
    slope = trace.derivative(trace.sqrt(X * X + Y * Y), X)
    assert slope.kind == "unit"
    assert value(slope, 3.0, 4.0) == 0.6
    assert value(slope, 0.0, 0.0) == 0.0


def test_a_derivative_that_is_to_have_derivatives_has_plain_quotients():
    speed = trace.sqrt(trace.total(map(trace.square, (X, Y))))
    first = trace.derivative(speed, X, ratio="quotient")
    assert value(first, x=3.0, y=4.0) == 0.6
    assert value(trace.derivative(first, X), x=3.0, y=4.0) == pytest.approx(16 / 125, rel=1e-15)
    with pytest.raises(TypeError, match="a unit has no derivative"):
        trace.derivative(trace.derivative(speed, X), X)


def test_division_by_nothing_is_told():
    with pytest.raises(ZeroDivisionError, match="divides by zero"):
        X / (Y - Y)


@pytest.mark.parametrize(
    "formula", [lambda: X + K * 0 + trace.constant(0.1) * 0.3, lambda: trace.sqrt(2.0)]
)
def test_constants_that_would_be_rounded_are_refused(formula):
    """A double is exact in any number system; the product of two need not be one."""
    with pytest.raises(ArithmeticError, match="no double; make it a parameter"):
        formula()


def test_doubles_are_read_back_as_they_were():
    assert value(X * 0.1, x=1.0) == 0.1
    assert value(X + math.pi, x=0.0) == math.pi
