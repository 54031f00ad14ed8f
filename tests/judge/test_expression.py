"""Values of expressions compared with NumPy's, their words, and expressions without switches."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from longball.judge.diagnosis.chain import I
from longball.judge.diagnosis.expression import (
    ARGUMENT,
    KG,
    NONE,
    Evaluator,
    M,
    Node,
    Pieces,
    S,
    Values,
    axes,
    component,
    constant,
    contains,
    cross,
    depends,
    dot,
    each,
    evaluate,
    function,
    matrix,
    named,
    names_in,
    norm,
    ordered,
    solve,
    specialised,
    substitute,
    switch,
    symbol,
    table,
    times,
    unit,
    vector,
    where,
    words,
)

x, y = symbol("x", M), symbol("y", M)
a, b = symbol("a", M, True), symbol("b", M, True)
draw = np.random.default_rng(1)
X, Y = np.array([-1.5, 0.0, 2.25]), np.array([4.0, 0.5, 2.25])
A, B = draw.normal(size=(2, 3, 3))
A[:, 1] = 0.0
COLUMNS = {
    "x": X, "y": Y, "a": A, "b": B, "kind": np.array(["one", "two", "one"]),
    "key.at": np.array([[0.0, 0, 1], [1, 0.5, 2], [3, 2, 2]]),
    "key.values": np.array([[2.0, 1, 5], [4, 2, 6], [3, 5, 6]]),
}  # fmt: skip
OF_NUMBERS = {
    "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan, "atan": np.arctan,
    "sqrt": np.sqrt, "square": lambda x: x**2, "abs": abs, "positive": lambda x: x.clip(0),
    "rises": lambda x: np.array([0.0, 0, 1]), "rounded_0": np.round,
    "rounded_1": lambda x: np.array([-1.5, 0, 2.2]), "truncated": lambda x: np.array([-1.0, 0, 2]),
    "single": lambda x: x,
}  # fmt: skip
VALUES = [
    (x + y, X + Y), (2.0 - x, 2 - X), (x * y, X * Y), (x / y, X / Y), (1.0 / y, 1 / Y), (-x, -X),
    (3.0 + x, 3 + X), (named("k", x), X),
    (norm(a), np.sqrt((A**2).sum(0))), (function("sizes", a), abs(A).sum(0)),
    (unit(b), B / np.linalg.norm(B, axis=0)), (dot(a, b), (A * B).sum(0)),
    (cross(a, b), np.cross(A, B, axis=0)), (each("by_component", a, b), A * B),
    (each("by_own_size", a, b), abs(A) * B), (vector(x, y, 0.0), np.array([X, Y, 0 * X])),
    (component(a, 2), A[2]),
    (axes(a, ((0, 0, 1), (0, -1, 0), (0, 0, 0)), ""), [A[2], -A[1], 0 * X]),
    (where(x, y, 2.0 * y), np.where(X > 0, Y, 2 * Y)), (function("least", x, y), np.minimum(X, Y)),
    (switch("kind", {"one": x, "two": y}), np.array([X[0], Y[1], X[2]])),
    (times(matrix("K", x * cross(b, ARGUMENT)), a), X * np.cross(B, A, axis=0)),
    (function("single", b, vector=True), np.float32(B)),
    (x * a, X * A), (constant(2.0, M, True) + a, 2 + A),
    *((function(op, x), of(X)) for op, of in OF_NUMBERS.items() if op not in ("log", "sqrt")),
    *((function(op, y), of(Y)) for op, of in OF_NUMBERS.items() if op in ("log", "sqrt")),
]  # fmt: skip


@pytest.mark.parametrize(("node", "expected"), VALUES, ids=lambda case: str(case)[:30])
def test_values(node: Node, expected: Any):
    assert np.allclose(evaluate(node, COLUMNS), expected, rtol=1e-15, atol=1e-15)
    # The same with symbols that move.
    (found,) = Evaluator([node], {**COLUMNS, "x": None, "a": None}, frozenset("xa"))(x=X, a=A)
    assert np.allclose(found, expected, rtol=1e-15, atol=1e-15)


def test_given_symbols():
    known = Values({"y": Y})
    assert np.array_equal(known.given(x * y, {"x": X}), X * Y)
    assert np.array_equal(known.given(x * y, {"x": 2 * X}), 2 * X * Y)
    assert x * y not in known
    assert np.array_equal(known.of(y), Y)
    assert y in known
    known.beside().of(3.0 * y)
    assert 3.0 * y not in known
    # A node with another value, also if it is in an option that no scene has.
    assert np.array_equal(known.changed(3.0 * y + y * y, 3.0 * y, X), X + Y * Y)
    assert np.array_equal(known.changed(2.0 * y, x, X), 2 * Y)
    kinds = Values(COLUMNS)
    either = switch("kind", {"one": x, "two": y, "three": 2.0 * x})
    assert np.array_equal(kinds.changed(either, x, 5 * X), [5 * X[0], Y[1], 5 * X[2]])


def test_the_solution_of_a_matrix_where_it_is_regular():
    columns = [symbol(name, NONE, True) for name in "uvw"]
    matrix = draw.normal(size=(3, 3, 4))  # column, row, scene
    matrix[2, :, 1] = matrix[0, :, 1]  # singular
    right = draw.normal(size=(3, 4))
    given = dict(zip("uvw", matrix, strict=True)) | {"right": right}
    found = evaluate(solve(tuple(columns), symbol("right", NONE, True)), given)
    assert np.isnan(found[:, 1]).all()
    for i in (0, 2, 3):
        assert np.allclose(matrix[:, :, i].T @ found[:, i], right[:, i])


@pytest.mark.parametrize(
    ("mode", "below", "above"),
    [
        ("linear", (2, 1, 5), (3, 5, 6)),
        ("extrapolated", (0, -1, 4), (2.5, 7, 8)),
        ("extrapolated or 0", (0, 0, 4), (2.5, 7, 8)),
        ("extrapolated below", (0, -1, 4), (3, 5, 6)),
        ("extrapolated above", (2, 1, 5), (2.5, 7, 8)),
        ("previous node", (2, 1, 5), (3, 5, 6)),
        ("middle", (2, 1, 5), (3, 5, 6)),
    ],
)
def test_tables(mode: str, below: Any, above: Any):
    """Nodes 0, 1, 3; 0, 0.5, 2; and 1, 2, filled up with a last node of no length."""
    at = COLUMNS["key.at"]
    node = table(symbol("s"), "key", mode)

    def value(s: Any) -> Any:
        return evaluate(node, {**COLUMNS, "s": np.asarray(s, float)})

    assert np.allclose(value(at[0] - 1), below)
    assert np.allclose(value(at[-1] + [1, 1, 2]), above)
    assert np.allclose(value(at[0]), (2, 1, 5))
    assert np.allclose(value(at[1]), (4, 2, 6))
    between = (2, 1, 5) if mode == "previous node" else (3, 1.5, 5.5)
    assert np.allclose(value((at[0] + at[1]) / 2), between)


@pytest.mark.parametrize(
    ("mode", "between"), [("next node in the last segment", (3, 5, 6)), ("short", (4, 2, 5))]
)
def test_the_last_segment_of_a_table(mode: str, between: Any):
    found = evaluate(table(symbol("s"), "key", mode), {**COLUMNS, "s": np.array([2.0, 1.25, 1.5])})
    assert np.allclose(found, between)


def test_dimensions():
    time = symbol("t", S)
    assert (x * y / time).dimension == (2, 0, -1)
    assert dot(a, b).dimension == cross(a, b).dimension == (2, 0, 0)
    assert each("by_component", a, a).dimension == (2, 0, 0)
    assert unit(a).dimension == NONE
    assert norm(a).dimension == vector(0.0, x, 0.0).dimension == M
    assert solve((a, a, a), time * b).dimension == S
    assert (a / x).vector
    assert (x * a).vector
    assert not dot(a, b).vector
    assert not norm(a).vector
    assert (symbol("m", KG) * x).dimension == (1, 1, 0)
    assert component(a, 1).dimension == axes(a, (), "").dimension == M


def test_graphs():
    total = (x + y) * x
    assert ordered([total]) == [x, y, x + y, total]
    assert ordered([total], {x + y}) == [x + y, x, total]
    assert substitute(total, x, y) is (y + y) * y
    assert substitute(total, a, b) is total
    assert contains(total, y)
    assert contains(total, total)
    assert not contains(total, a)
    assert depends(total, frozenset("yz"))
    assert not depends(total, frozenset("z"))
    reads = names_in((total, table(x, "key"), switch("kind", {"one": x})))
    assert {*reads} == {"x", "y", "kind", "key.at", "key.values"}
    assert as_is(x) is x


def as_is(node: Node) -> Node:
    return specialised(node, {}, {})


def test_what_is_left_without_a_switch():
    either = switch("kind", {"one": x, "two": y})
    assert specialised(either, {"kind": np.array(["two", "two"])}, {}) is y
    assert specialised(either, COLUMNS, {}) is either
    nothing, one = constant(0.0, M), constant(1.0)
    zero = constant(0.0, M)
    for whole, left in [
        (x + nothing, x), (nothing + x, x), (one * x, x), (x * one, x), (x / y, x / y),
        (constant(0.0) * x, zero), (x * constant(0.0), zero), (nothing / constant(2.0), zero),
        (-1.0 * (-1.0 * x), x), (-nothing, zero), (norm(constant(0.0, M, True)), zero),
        (named("k", x), x), (named("k", named("k", x + y)), named("k", x + y)),
        (named("k", nothing), zero),
        (constant(1.0, M) * y, constant(1.0, M) * y), (2.0 * x, 2.0 * x), (x + y, x + y),
        (cross(a, constant(0.0, M, True)), constant(0.0, (2, 0, 0), True)),
        (cross(constant(0.0, M, True), a), constant(0.0, (2, 0, 0), True)),
        (-1.0 * (2.0 * x), -1.0 * (2.0 * x)), (named("k", x + y), named("k", x + y)),
    ]:  # fmt: skip
        assert as_is(whole) is left, whole


def test_numbers_that_change_at_kinks_and_jumps():
    s = symbol("s")
    other = switch("kind", {"one": function("abs", s), "two": x})
    for root, at in [
        (where(s - 1.0, x, y), (0.9, 1.1)), (function("abs", s), (-0.1, 0.1)),
        (function("least", s, constant(2.0)), (1.9, 2.1)), (table(s, "key"), (2.9, 3.1)),
        (function("positive", s - 1.0), (0.9, 1.1)), (function("rises", s), (-1.0, 1.0)),
    ]:  # fmt: skip
        pieces = Pieces(root, COLUMNS, frozenset("s"))
        before, beyond = (pieces(s=np.full(3, one)) for one in at)
        assert (before != beyond).any(axis=0)[0]
        assert np.array_equal(before, pieces(s=np.full(3, at[0] - 0.05)))
    pieces = Pieces(other, COLUMNS, frozenset("s"))
    changes = (pieces(s=np.full(3, -1.0)) != pieces(s=np.full(3, 1.0))).any(axis=0)
    assert np.array_equal(changes, [True, False, True])  # only where the option is
    assert Pieces(function("abs", x), COLUMNS, frozenset("s"))(s=X).shape == (0, 1)


@pytest.mark.parametrize(
    ("node", "text"),
    [
        (x + y, "x + y"), (x - y, "x - y"), (x + -(2.0 * y), "x - 2·y"), ((x + y) * x, "(x + y)·x"),
        (x / (x * y), "x/(x·y)"), (x * y / x, "x·y/x"), (-(x + y), "-(x + y)"), (-1.0 * x, "-x"),
        ((x + y) / x, "(x + y)/x"), (function("square", x + y), "(x + y)²"), (norm(a), "|a|"),
        (dot(a, b), "a · b"), (cross(a, b), "a × b"), (x * dot(a, b), "x·(a · b)"),
        (component(a + b, 2), "(a + b)_z"), (component(a, 0), "a_x"), (unit(a), "a/|a|"),
        (vector(x, 0.0, y), "(x, 0, y)"), (function("sin", x), "sin(x)"),
        (switch("kind", {"one": x}), "⟨kind⟩"), (table(x, "key"), "table(x)"),
        (function("rises", x), "[x > 0]"), (function("positive", x), "max(x, 0)"),
        (constant(math.pi), "π"), (constant(0.1), "0.1"), (named("k", x + y), "k"),
        (axes(a, (), "(x, 0, z)"), "a as (x, 0, z)"), (function("least", x, y), "least(x, y)"),
        (function("sizes", a), "|a_x| + |a_y| + |a_z|"), (x * (x / y), "x·x/y"),
        (each("by_component", a, b), "a·b by component"), (times(matrix("K", ARGUMENT), a), "K·a"),
        (I["m"], "m"),
    ],
)  # fmt: skip
def test_words(node: Node, text: str):
    assert words(node) == repr(node) == text


# Tables of two and of four nodes; the shorter one is filled up with its last node.
NODES = np.array([[0.0, 1.0], [1.0, 2.0], [2.5, 2.0], [3.0, 2.0]])
OF_NODES = np.array([[1.0, 4.0], [3.0, 2.0], [2.0, 2.0], [5.0, 2.0]])
CURVES = {"spline": CubicSpline, "monotonic": PchipInterpolator}


@pytest.mark.parametrize("mode", CURVES)
def test_curves_through_the_nodes_of_a_table(mode: str):
    tables = {"key.at": NODES, "key.values": OF_NODES}
    for x in (-0.5, 0.3, 1.0, 1.7, 2.9, 3.5):
        found = evaluate(table(symbol("s"), "key", mode), {**tables, "s": np.array([x, x])})
        whole = CURVES[mode](NODES[:, 0], OF_NODES[:, 0])(np.clip(x, 0.0, 3.0))
        line = np.interp(x, (1.0, 2.0), (4.0, 2.0))
        assert found == pytest.approx([float(whole), line], abs=1e-14)


def test_no_curve_leads_through_nodes_out_of_order():
    tables = {"key.at": NODES[::-1], "key.values": OF_NODES, "s": np.array([0.25, 1.25])}
    found = evaluate(table(symbol("s"), "key", "spline"), tables)
    assert np.isnan(found).all()


def test_a_smoothed_table():
    tables = {"key.at": NODES, "key.values": OF_NODES, "s": np.array([0.25, 1.25])}
    # s²(3 - 2s) = 5/32 at s = 1/4
    expected = [1.0 + 2.0 * 5 / 32, 4.0 - 2.0 * 5 / 32]
    assert evaluate(table(symbol("s"), "key", "smoothed"), tables) == pytest.approx(expected)
