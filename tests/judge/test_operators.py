"""Operators on small formulas: the values of every replacement of a node."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis import operators
from longball.judge.diagnosis.chain import CHAIN, OWN, I, Stage, n, r, v, v0
from longball.judge.diagnosis.expression import (
    ARGUMENT,
    NONE,
    M,
    Node,
    S,
    component,
    constant,
    cross,
    dot,
    evaluate,
    function,
    matrix,
    named,
    norm,
    switch,
    symbol,
    table,
    times,
    unit,
    vector,
    where,
)
from longball.judge.diagnosis.operators import AXES, FACTORS, FREE, Edit, Site, edits, free
from longball.judge.diagnosis.residual import follow, specialised_to
from longball.judge.diagnosis.search import defaults
from longball.judge.fresh import DENSITIES, GRAVITIES
from tests.judge.material import known, truth

x, y, z = symbol("x"), symbol("y"), symbol("z")
p, q, later = symbol("p", M), symbol("q", M), symbol("later", S)
a, b = symbol("a", M, True), symbol("b", M, True)
A, B, N = np.array([1.0, 2.0, 4.0]), np.array([3.0, -5.0, 8.0]), np.array([0.6, 0.0, 0.8])
COLUMNS = {
    "x": 2.0, "y": 5.0, "z": 11.0, "p": 3.0, "q": 7.0, "later": 13.0, "m": 17.0, FREE: 0.5,
    "a": A[:, None], "b": B[:, None], "n": N[:, None], "kind": np.array(["flight"]),
    "key.at": np.array([[0.0], [1.0], [3.0]]), "key.values": np.array([[2.0], [4.0], [3.0]]),
    "v": A[:, None], "r": B[:, None], "v0": 3 * B[:, None], "r0": 2 * A[:, None], "t": 0.4,
}  # fmt: skip


def value(node: Node, **columns: Any) -> Any:
    with np.errstate(all="ignore"):
        found = np.asarray(evaluate(node, COLUMNS | columns), float)
    return tuple(np.round(found, 9).ravel() + 0.0)


def given(
    operator: Callable[[Site], Iterator[Any]], node: Node, *parents: Node, pool: Any = (),
    flies: bool = False, **more: Any,
) -> set[Any]:  # fmt: skip
    """The distinct values of an operator's replacements."""
    site = Site(node, parents, pool, more.pop("defaults", {}), flies, **more)
    return {value(by) for by, *_ in operator(site)}


def one(*numbers: float) -> set[Any]:
    return {(round(float(number), 9) + 0.0,) for number in numbers}


def three(*vectors: Any) -> set[Any]:
    return {tuple(np.round(np.asarray(each, float), 9) + 0.0) for each in vectors}


def test_another_node():
    pool = (p, q, later, a)
    assert given(operators._others, p, pool=pool) == one(7, 13, 0.5 * 7, 3 + 7, 3 - 7)
    assert given(operators._others, p, p + q, pool=pool) == one(7, 13, 0.5 * 7, 10, -4)
    assert given(operators._others, x * p, pool=pool) == one(3, 7, 13)
    assert given(operators._others, x * p, x * p + q, pool=pool) == one(3, 7)
    assert given(operators._others, a, pool=(*pool, b)) == three(B, A + B, A - B)
    assert not given(operators._others, constant(3.0), pool=(x, y))


def test_the_cost_of_a_choice_among_other_nodes():
    """One of n or none: log2(1 + n), 1 bit more for three nodes than for one."""
    more = symbol("q2", M), symbol("q3", M)
    few, many = (
        {text: bits for _, bits, text, _ in operators._others(Site(p, (), pool, {}, False))}
        for pool in ((q,), (q, *more))
    )
    assert few.keys() == {
        "uses q for p",
        "uses {c} times q for p",
        "adds q to p",
        "subtracts q from p",
    }
    assert {text: many[text] for text in few} == {text: bits + 1 for text, bits in few.items()}


def test_another_node_where_a_scene_leaves_the_key_out():
    m, M = I["m"], I["M"]
    site = Site(m, (), (M, I["g"]), {}, False, {"m": {"left out"}})
    found = [by for by, *_ in operators._others(site) if by.op == "switch"]
    columns = {operators.key_of(m): np.array(["given", "left out"]), "M": 3.0}
    assert [value(by, **columns) for by in found] == [(17, 3), (17, 3)]  # one way or either


def test_another_node_where_a_scene_has_it():
    site = Site(p, (), (q,), {}, False, {}, ("flight", "impact"), {q: {"flight"}})
    (by, *_), *_ = operators._others(site)
    assert value(by, kind=np.array(["flight", "impact"])) == (7, 3)


def test_numbers():
    m = I["m"]
    usual = {"defaults": {"m": 0.145}}
    assert given(operators._numbers, constant(3.0), 3.0 + x) == one(0, 0.5)
    assert given(operators._numbers, constant(3.0), 3.0 * x) == one(0.5)
    assert not given(operators._numbers, constant(0.0), 0.0 + x)
    assert given(operators._numbers, x, x + y) == one(0, 0.5)
    assert given(operators._numbers, x, x * y) == one(1, 0.5)
    assert given(operators._numbers, x) == one(0, 1, 0.5)
    assert given(operators._numbers, m, m * p, **usual) == one(0, 1, 0.145, 0.5)
    assert given(operators._numbers, m, p / m, **usual) == one(1, 0.145, 0.5)
    assert given(operators._numbers, named("k", x * y), p * named("k", x * y)) == one(0, 1, 0.5)
    assert given(operators._numbers, a, a + b) == three((0, 0, 0))
    assert not given(operators._numbers, a, 2.0 * a)


def test_a_number_that_a_scene_leaves_out_and_its_usual_values():
    g = I["g"]
    scenes = np.array(["given", "left out", "without its block", "0"])
    without = [(9, 0.5, 0.5, 9), (9, 0.5, 9, 9), (9, 9, 0.5, 9)]
    for omitted, expected in (({"left out"}, without[:2]), ({*scenes}, without), (set(), [])):
        options = [*operators._numbers(Site(g, (), (), {}, False, {"g": omitted}))]
        found = [(by, starts[0]) for by, *_, starts in options if by.op == "switch"]
        columns = {"g": 9.0 + np.zeros(4), operators.key_of(g): scenes}
        assert [value(by, **columns) for by, _ in found] == expected
        assert all(value(start, g=10.0) == (9,) for _, start in found)
    (*_, starts) = options[-1]
    assert {*starts} == {g, *GRAVITIES}
    *_, (*_, starts) = operators._numbers(Site(I["ρ_0"], (), (), {}, False))
    assert {*starts} == {I["ρ_0"], *DENSITIES}


def test_factors():
    assert {*one(-2, 0.5 * 2, 1e3 * 2)} <= given(operators._factors, x, x * y)
    assert not one(4) & given(operators._factors, x, x * y)  # a fit finds it
    whole = given(operators._factors, x * y, switch("kind", {"flight": x * y}))
    assert {*one(-10, 0.5 * 10)} <= whole
    assert {(round(12 * each, 9),) for each in FACTORS} == given(
        operators._factors, x + 10.0, x * y
    )
    assert given(operators._factors, x + 10.0, (x + 10.0) * y, flies=True) == one(-12)
    assert not given(operators._factors, x * y, x * y * z)
    assert not given(operators._factors, -x)
    assert given(operators._factors, unit(a), p * unit(a)) == three(-A / math.sqrt(21))


def test_units_are_factors_in_both_directions():
    whole = {factor for factor, meaning in FACTORS.items() if "for π" not in meaning} - {-1, 4 / 3}
    for factor in whole:
        assert any(math.isclose(factor * other, 1, rel_tol=1e-14) for other in whole), factor
    inch, foot, mile = 0.0254, 12 * 0.0254, 5280 * 12 * 0.0254
    for size in (inch, foot, mile / 3600, 1 / 3.6, math.pi / 180, 2 * math.pi / 60, math.pi, 1e-2,
                 1e-3, 1 / 2, 1 / 3, 2 / 3):  # fmt: skip
        assert any(math.isclose(size, other, rel_tol=1e-14) for other in whole), size
    for wrong in (3.14, 22 / 7):
        assert any(math.isclose(wrong, other * math.pi, rel_tol=1e-14) for other in FACTORS)
    assert {-1, 4 / 3} < FACTORS.keys()


def test_terms_and_whole_formulas():
    assert given(operators._terms, p, p * q) == one(3.5)
    assert given(operators._terms, x, x * y) == one(2.5, 3)
    assert given(operators._terms, x * y, x * y * z) == one(11)
    assert not given(operators._terms, x + y, (x + y) * z)
    assert not given(operators._terms, a)
    assert given(operators._scales, p, pool=(p, q, x, a)) == one(3 / 7, 3 * 7, 3 / 2, 3 * 2)
    assert not given(operators._scales, p, p + q, pool=(q,))
    assert not given(operators._scales, p, pool=(q,), flies=True)
    assert not given(operators._scales, a, pool=(q,))


def test_products_without_two_factors():
    whole = x * y * p / q * 3.0
    assert given(operators._products, whole) == one(
        *(3 * 2 * 5 * 3 / 7 / f / g for f, g in
          itertools.combinations((2, 5, 3, 1 / 7), 2))
    )  # fmt: skip
    assert given(operators._products, named("k", x * y), named("k", x * y) + z) == one(1)
    assert not given(operators._products, x * y, x * y + z)


def test_scopes():
    assert given(operators._scopes, x * p + q) == one(2 * 3 + 2 * 7)
    assert given(operators._scopes, p + x * q) == one(2 * 3 + 2 * 7)
    assert given(operators._scopes, x * named("sum", p + q)) == one(2 * 3 + 7, 2 * 7 + 3)
    assert not given(operators._scopes, p * named("sum", p + q))
    either = switch("kind", {"flight": y * p, "impact": x * p})
    assert given(operators._scopes, either + q) == one(5 * 3 + 5 * 7, 5 * 3 + 7)
    assert one((1 - 2) ** 2) <= given(operators._scopes, 1.0 - x * x)
    assert one((1 + 2) ** 2) <= given(operators._scopes, 1.0 + x * x)


def test_shapes():
    assert given(operators._shapes, p / q) == one(7 / 3, 3 / 7)
    assert given(operators._shapes, p * p) == one(3, 9)
    assert not given(operators._shapes, constant(2.0))
    assert not given(operators._shapes, a / p)
    for number in (1.7654, -1.7654):
        shapes = operators._shapes(Site(I["m"], (I["m"] * y,), (), {}, False))
        every = {value(by, m=number, **{FREE: -9.0 if number < 0 else 0.5}) for by, *_ in shapes}
        limit = -9.0 if number < 0 else 0.5
        assert every == one(
            number**2, 1 / number, abs(number), max(number, 0), min(number, limit),
                max(number, limit)
        )  # fmt: skip
    assert given(operators._shapes, norm(a), norm(a) + p) == one(21)


@pytest.mark.parametrize("sign", [1, -1])
def test_roundings(sign):
    """An input loses digits in SI units, or in those of the program."""

    def rounded(node: Node, number: float) -> set[Any]:
        ways = operators._roundings(Site(node, (), (), {}, False))
        return {value(by, **dict.fromkeys(("m", "V_0", "L", "r_b"), number)) for by, *_ in ways}

    number = sign * 1.7654
    found = (sign * x for x in (1, 2, 1.8, 1.77, 1.765))
    assert rounded(I["m"], number) == one(*found, np.float32(number))
    # 39.3 m/s are 87.91 mph and 141.48 km/h.
    mph, kmh = 0.44704, 1 / 3.6
    speeds = {88 * mph, 87.9 * mph, 87.91 * mph, 87 * mph, 141 * kmh, 141.5 * kmh, 141.48 * kmh}
    assert one(*(sign * x for x in speeds)) <= rounded(I["V_0"], sign * 39.3)
    assert rounded(named("r̃", I["L"] / 2.0), 2.2) == one(np.float32(1.1))
    assert not rounded(I["L"] + I["r_b"], 2.2)


def mixed(one_: Any, other: Any) -> list[float]:
    whole = one_ @ other
    signs = [whole - 2 * one_[i] * other[i] for i in range(3)]
    return signs + [
        whole - one_[i] * other[i] + one_[i] * other[j]
        for i, j in itertools.permutations(range(3), 2)
    ]


def slipped(one_: Any, other: Any) -> Iterator[Any]:
    """All vector products with one wrong sign, or one wrong index of one of the two terms."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        terms = [(j, k), (k, j)]
        slips = [[terms[0], terms[1], sign] for sign in ((-1, 1), (1, 1))]
        for which, (first, last) in enumerate(terms):
            for index in range(3):
                for new in ((index, last), (first, index)):
                    if new != (first, last):
                        both = [*terms]
                        both[which] = new
                        slips.append([*both, (1, -1)])
        for (c, d), (e, f), (plus, minus) in slips:
            found = np.cross(one_, other)
            found[i] = plus * one_[c] * other[d] + minus * one_[e] * other[f]
            yield found


def kin(node: Node) -> set[Any]:
    return {value(by) for by, *_ in operators._kin(node)}


def test_siblings():
    assert kin(function("sin", x)) == one(math.cos(2), math.tan(2), 2, 1, 2 - 8 / 6)
    assert kin(function("cos", x)) == one(math.sin(2), math.tan(2), 2, 1, -1)
    assert kin(function("sqrt", p)) == one(3)
    assert kin(function("atan2", x, y)) == one(math.atan(2 / 5), math.atan2(5, 2))
    assert kin(function("exp", x)) == one(3)
    assert kin(function("abs", p - q, dimension=M)) == one(-4, 4)
    assert kin(function("positive", p - q, dimension=M)) == one(-4)
    assert kin(function("least", p, q, dimension=M)) == one(3, 7)
    assert kin(1.0 - x) == one(2)
    assert kin(where(x - 3.0, y, z)) == one(5, 11)
    assert kin(where(x - 1.0, y, z)) == one(5, 11)
    # The last two are on the parabola through the nodes, and on the monotonic cubic.
    assert kin(table(x, "key")) == one(3, 3.5, 4, 13 / 3, 3.875)
    assert kin(table(x - 3.0, "key")) == one(0, 2)
    assert kin(table(x + 2.0, "key")) == one(2.5, 3, 4)
    assert kin(dot(a, b)) == one(*mixed(A, B), *mixed(B, A))
    assert kin(cross(a, b)) == three(*slipped(A, B))
    parts = [math.hypot(*A[[0, 1]]), math.hypot(*A[[0, 2]]), math.hypot(*A[[1, 2]])]
    with np.errstate(invalid="ignore"):
        lengths = np.sqrt(mixed(A, A))
    found = {number for number in kin(norm(a)) if not math.isnan(number[0])}
    assert found == one(7, 1, 2, 4, *parts, *lengths[np.isfinite(lengths)])
    assert one(abs(A @ B)) < kin(norm(named("c", cross(a, b))))
    assert kin(unit(a)) == three(A)
    across = np.cross(A, B)
    divided = across / math.sqrt(A @ A * (B @ B))
    assert kin(unit(named("c", cross(a, b)))) == three(across, divided)
    assert kin(2.0 * norm(a) * a) == three(2 * A * abs(A), 2 * A * A)
    assert not kin(x + y)
    assert not kin(p * a)


def test_axes_are_as_their_names_say():
    letters = dict(zip("xyz", np.eye(3), strict=True)) | {"0": np.zeros(3)}
    for name, rows in AXES.items():
        parts = name.strip("()").split(", ")
        expected = [(-1 if part[0] == "-" else 1) * letters[part[-1]] for part in parts]
        assert np.array_equal(rows, expected), name
    # Signs, exchanges, and omitted components: no two of these at once, but quarter turns.
    assert {"(x, -y, -z)", "(z, y, x)", "(y, z, x)", "(x, 0, 0)", "(y, -x, z)"} < AXES.keys()
    assert len(AXES) == 7 + 6 + 5 + 2


def test_directions():
    every = [np.array(rows) @ A for rows in AXES.values()]
    along = A @ N * N
    ahead = (math.sqrt(21), 0, 0)
    assert given(operators._directions, a) == three(*every, ahead)
    assert given(operators._directions, a, pool=(n,)) == three(*every, along, A - along, ahead)
    size = math.sqrt(21)
    beside = size * B / np.linalg.norm(B)
    assert given(operators._directions, a, pool=(b,)) == three(*every, ahead, beside)
    every_b = [np.array(rows) @ B for rows in AXES.values()]
    along_v = (A @ B) * A / 21
    ahead_b = (np.linalg.norm(B), 0, 0)
    flying = three(*every_b, along_v, B - along_v, ahead_b)
    assert given(operators._directions, b, flies=True) == flying
    assert given(operators._directions, unit(a), pool=(n,)) == three(*(x / size for x in every))
    assert not given(operators._directions, x)


def test_components():
    def instead(*choices: tuple[int, float]) -> list[list[float]]:
        return [[number if i == at else A[i] for i in range(3)] for at, number in choices]

    swaps = instead(*((at, A[k]) for at, k in itertools.permutations(range(3), 2)))
    free = instead(*enumerate(A + 0.5), *enumerate(0.5 * A))
    assert given(operators._components, a) == three(*swaps, *free)
    other = instead(*((at, B[1]) for at in range(3)))
    assert given(operators._components, a, pool=(component(b, 1),)) == three(*swaps, *other, *free)
    aim = I["release"]
    found = {value(by, release=A[:, None]) for by, *_ in
             operators._components(Site(aim, (), (), {}, False))}  # fmt: skip
    fitted = instead(*((at, 0.5) for at in range(3)))
    assert found == three(*swaps, *free, *fitted)
    assert not given(operators._components, a + b)


def test_states():
    assert not given(operators._states, norm(v), p * norm(v))
    launch = math.sqrt(9 * (B @ B))
    speed = named("U", norm(v))
    found = given(operators._states, speed, p * speed, flies=True)
    size = math.sqrt(21)
    # At this state the ball rises, below 10 m, after 0.4 s: a condition holds, or it does not.
    assert found == one(launch, size, 0, size * math.exp(-8 / 0.5))
    assert given(operators._states, norm(v), p * norm(v), flies=True) == one(launch)
    assert given(operators._states, r, r + b, flies=True) >= three(2 * A, B - 2 * A)
    assert given(operators._states, component(r, 2), flies=True) >= one(8, 8 - 8, 0)
    heading = named("h", unit(v0))
    assert given(operators._states, heading, p * heading, flies=True) == three(A / size)
    assert not given(operators._states, unit(v0), p * unit(v0), flies=True)
    assert not given(operators._states, v0 + b, flies=True)


def test_conditions():
    """Each with the state in which it holds, and one in which it does not."""
    speed = named("U", norm(v))
    up, down = np.array([[3.0], [0], [4]]), np.array([[3.0], [0], [-4]])
    slow = {"v": up, "r": up, "t": 1.0, FREE: 6.0}
    fast = {"v": 2 * up, "r": 2 * up, "t": 7.0, FREE: 6.0}
    cases = {
        "only on the way up": ({"v": up}, {"v": down}),
        "only on the way down": ({"v": down}, {"v": up}),
        "only above a speed of {c} m/s": (fast, slow),
        "only below a speed of {c} m/s": (slow, fast),
        "only if v_z/|v| is below {c}": ({"v": up, FREE: 0.9}, {"v": up, FREE: 0.7}),
        "only above a height of {c} m": (fast, slow),
        "only after {c} s": (fast, slow),
        "only for {c} s": (slow, fast),
    }
    site = Site(speed, (p * speed,), (), {}, True)
    seen = {}
    for by, _, words, starts in operators._states(site):
        for text, (yes, no) in cases.items():
            if text in words:
                seen[text] = starts
                assert value(by, **yes) == value(speed, **yes)
                assert value(by, **no) == (0,)
    assert seen.keys() == cases.keys()
    assert all(bool(starts) == ("{c}" in text) for text, starts in seen.items())


def test_options():
    either = switch("kind", {"flight": p, "impact": q, "pitch": 2.0 * p})
    kinds = np.array(["flight", "impact", "pitch"])
    found = {value(by + 0.0 * p, kind=kinds, p=np.full(3, 3.0)) for by, *_ in
             operators._options(Site(either, (), (), {}, False))}  # fmt: skip
    assert found == {(3, 3, 3), (7, 7, 7), (6, 6, 6), (7, 7, 6), (6, 7, 6), (3, 3, 6), (3, 6, 6),
                     (3, 7, 3), (3, 7, 7)}  # fmt: skip


# --- whole formulas -------------------------------------------------------------------------------


def of_formula(root: Node, form: Node | None = None, **columns: Any) -> dict[str, Any]:
    forms = {} if form is None else {"value": (form,)}
    stage = Stage("", ("impact.impulse",), "formula", {"value": root}, forms)
    found = {}
    for edit in edits((stage,), stage, {"x": 9.0}, COLUMNS | columns):
        (other,) = edit.apply((stage,))
        found[edit.words] = value(other.roots["value"], **columns)
    return found


def test_a_mistake_in_one_use_of_several():
    found = {*of_formula(x * x + x * y).values()}
    assert one(1 + 5, 2 + 2 * 5, 1 + 2 * 5, 4 + 5) <= found  # 1 for x: everywhere, once, …
    assert one(25 + 25, 5 * 2 + 10, 25 + 10, 4 + 25) <= found  # y for x


def test_exchanged_symbols():
    assert one(5 - 2 * 2 * 11, 11 - 25 * 2, 2 - 25 * 11) & {*of_formula(x - y * y * z).values()}
    assert one(5 - 4 * 11) <= {*of_formula(x - y * y * z).values()}


def test_another_form_has_mistakes_of_its_own():
    parts = {*of_formula(x * (y + z), x * y + x * z).values()}
    assert one(4 * 5 + 22, 5 + 22) <= parts  # x² and 1 for x, once


def test_mistakes_in_one_option_of_a_switch():
    kinds = {"kind": np.array(["flight", "impact"])}
    found = of_formula(switch("kind", {"flight": x * y, "impact": x * z}), **kinds)
    assert {(5, 22), (10, 11), (5, 11)} <= {*found.values()}  # 1 for x
    found = of_formula(switch("kind", {"flight": (x + y) * (x + z), "impact": x * z}), **kinds)
    assert (10 * 16, 22) in found.values()  # y for x, in both uses there


def test_mistakes_in_one_definition_of_a_law():
    """In a definition with two uses of a symbol that is used elsewhere, too."""
    stage = Stage("", ("impact.impulse",), "formula", {"law": named("k", x * y + x) + x})
    found = {
        value(edit.apply((stage,))[0].roots["law"])
        for edit in edits((stage,), stage, {}, COLUMNS)
        if edit.words.endswith(" in k")
    }
    assert one(1 * 5 + 1 + 2, -2 * 5 - 2 + 2) <= found  # 1 for x; its sign


def test_a_slip_in_the_function_of_all_products():
    found = {*of_formula(dot(a, b) + dot(a, a)).values()}
    for i in range(3):
        assert one(A @ B + A @ A - 2 * A[i] * (A[i] + B[i])) <= found
    tables = {*of_formula(table(x - 3.0, "key") + table(x + 2.0, "key")).values()}
    assert one(0 + 2.5, 2 + 2.5, 0 + 3) <= tables
    lengths = {*of_formula(norm(a) + dot(a, unit(b))).values()}
    size, other = (math.sqrt(X @ X - 2 * X[0] ** 2) for X in (A, B))
    assert one(size + (A @ B - 2 * A[0] * B[0]) / other) <= lengths


def test_a_mistake_in_a_function_with_a_matrix():
    turned = cross(b, ARGUMENT)
    found = {*of_formula(times(matrix("K", 2.0 * ARGUMENT + turned), a)).values()}
    assert three(2 * A - np.cross(B, A), np.cross(B, A), 2 * A) <= found


def test_the_default_of_a_zero():
    keys = {operators.key_of(x): np.array([operators.ZERO]), "x": np.array([0.0])}
    assert one(9 * 5) <= {*of_formula(x * y, **keys).values()}


def test_the_defaults_of_zeros_of_a_number_of_a_block_and_of_all():
    some = {"m": 2.0, "R": 3.0, "L": 5.0}
    stage = Stage("", ("impact.velocity",), "formula", {"value": vector(*map(I.get, some))})
    zeros = dict.fromkeys(some, 0.0)
    zeros |= {operators.key_of(I[name]): np.array([operators.ZERO]) for name in some}
    found = [
        value(edit.apply((stage,))[0].roots["value"], **zeros)
        for edit in edits((stage,), stage, some, COLUMNS | zeros) if "= 0" in edit.words
        or "that is 0" in edit.words
    ]  # fmt: skip
    assert sorted(found) == [(0, 0, 5), (0, 3, 0), (2, 0, 0), (2, 3, 0), (2, 3, 5)]


def test_all_inputs_of_one_unit_in_another():
    m, M, L = (I[name] for name in ("m", "M", "L"))
    one_stage = Stage("a", ("impact.velocity",), "formula", {"value": vector(m, M, L)})
    other = Stage("b", ("impact.impulse",), "formula", {"value": m * L})
    found = [
        edit for edit in edits((one_stage, other), one_stage, {}, {}) if " every " in edit.words
    ]
    (masses,) = found  # there is a single length, and no speed
    both = [stage.roots["value"] for stage in masses.settled(3.0, 0.0).apply((one_stage, other))]
    columns = {"m": 2.0, "M": 5.0, "L": 7.0}
    assert [value(root, **columns) for root in both] == [(6, 15, 7), (42,)]
    assert masses.factor


def test_states_before_the_launch_of_a_ball():
    flights = {stage.name: stage for stage in CHAIN if stage.kind == "flight"}
    for name in ("pitch", "touching"):  # one ball
        assert operators.earlier_states(CHAIN, flights[name]) == ()
    for name in ("flight", "fence"):
        found = operators.earlier_states(CHAIN, flights[name])
        assert [text for text, *_ in found] == [
            "of the launch of pitch", "of the end of pitch", "of the end of touching",
        ]  # fmt: skip
        assert found[1][1:] == (OWN["plate.position"], OWN["plate.velocity"])
        assert found[0][2].args[0] is flights["pitch"].roots["velocity"]
    assert operators.earlier_states(CHAIN, CHAIN[-1]) == ()


@pytest.mark.parametrize("name", ["restitution", "time", "margin"])
def test_all_edits_within_a_limit_are_generated(name: str):
    (stage,) = (stage for stage in CHAIN if stage.name == name)
    dear, cheap = (
        [(edit.words, edit.bits) for edit in edits(CHAIN, stage, {"m": 0.145}, {}, most=most)]
        for most in (math.inf, 14.0)
    )
    assert len(cheap) < len(dear)
    assert sorted(x for x in cheap if x[1] <= 14) == sorted(x for x in dear if x[1] <= 14)


def costs(root: Node, form: Node | None = None) -> dict[str, float]:
    forms = {} if form is None else {"value": (form,)}
    stage = Stage("", ("impact.impulse",), "formula", {"value": root}, forms)
    found: dict[str, float] = {}
    for edit in edits((stage,), stage, {}, COLUMNS):
        found[edit.words] = min(edit.bits, found.get(edit.words, math.inf))
    return found


def test_costs_in_bits():
    """One bit more is half as likely: one of more nodes, of another form, or in one use."""
    short, long = costs(x * y), costs(x * y + z)
    flip = "flips the sign of x"
    assert long[flip] - short[flip] == pytest.approx(math.log2((1 + 5) / (1 + 3)))
    parts = costs(x * y + x * z)
    one_use = f"{flip} in x·y"
    assert parts[one_use] > parts[flip] + 1
    whole = costs(y - z, x * y + x * z)
    assert whole["flips the sign of x·y"] == parts["flips the sign of x·y"] + 1
    assert whole[one_use] == parts[one_use] + 1
    # Edits of named nodes and of inputs are cheaper than those of nodes without a name.
    named_ = costs(named("k", x * y) + z)
    unnamed = costs(x * y + z + 0.0 * z)
    assert named_["flips the sign of k"] < named_[flip] < unnamed["flips the sign of x·y"]
    exchange = "exchanges x and y"
    assert costs(x * y - z)[exchange] - costs(x - y)[exchange] == pytest.approx(math.log2(3 / 2))
    choice = costs(x + y), costs(x + y + z * p)
    assert choice[1]["uses y for x"] > choice[0]["uses y for x"]


def test_the_costs_of_kinds_and_choices_add_up(monkeypatch: Any):
    """If kinds cost nothing, a choice costs 0 or more; each option has a kind, or several."""
    m, height, kinds = I["m"], component(r, 2), switch("kind", {"flight": x * x, "impact": y})
    pool = (p, q, later, x, z, b, component(b, 1), n, m, I["M"], v0)
    states = (("of the pitch", r, v),)
    sites = [
        Site(node, parents, pool, {"m": 0.145}, flies, {"m": {"left out"}}, earlier=states)
        for flies in (False, True)
        for node, above in (
            (p, p + q), (p, p * q), (m, m * x), (x * x, x * x + z), (x / y, x / y + z), (a, a + b),
            (x, x - x * x), (norm(a), x * norm(a)), (unit(a), x * unit(a)), (v, v + b), (r, r + b),
            (I["release"], I["release"] + b), (height, height - p), (named("U", norm(v)), p + q),
            (kinds, x * kinds), (cross(a, b), cross(a, b) + a), (dot(a, b), dot(a, b) + z),
            (constant(3.0), 3.0 + x), (named("k", x * y), p * named("k", x * y)),
        )
        for parents in ((), (above,))
    ]  # fmt: skip

    def bits(each: float) -> list[float]:
        monkeypatch.setattr(operators, "BITS", dict.fromkeys(operators.BITS, each))
        return [bits for operator in operators.OPERATORS for site in sites
                for _, bits, *_ in operator(site)]  # fmt: skip

    choices = np.array(bits(0.0))
    of_kinds = np.array(bits(1.0)) - choices
    assert choices.min() == 0.0
    assert {*np.round(of_kinds, 9)} == {1.0, 2.0}


def test_an_edit_in_some_stages():
    stages = tuple(
        Stage(name, ("impact.impulse",), "formula", {"value": x * y}) for name in ("one", "two")
    )
    edit = Edit(x, free() * x, 1.0, "uses {c} times x", starts=(1.0,))
    assert [s.roots["value"] is x * y for s in edit.apply(stages)] == [False, False]
    here = Edit(x, z, 1.0, "", only=stages[:1])
    assert [s.roots["value"] for s in here.apply(stages)] == [z * y, x * y]
    within = Edit(x * y, z, 1.0, "", within=(x + y, y))
    assert [s.roots["value"] for s in within.apply(stages)] == [x + z] * 2
    settled = edit.settled(2.0, 4.5)
    assert (settled.bits, settled.starts, value(settled.by)) == (5.5, (), (4,))
    assert edit.factor
    assert not here.factor
    assert not Edit(x, free() + x, 1.0, "").factor
    assert Edit(x, function("rises", x), 1.0, "").rough
    assert Edit(x, function("abs", x), 1.0, "").rough
    assert not Edit(function("abs", x), -1.0 * function("abs", x), 1.0, "").rough


def test_launches_and_pools():
    flights = [stage for stage in CHAIN if stage.kind == "flight"]
    assert all(len(operators.launches_of(stage)) == 3 for stage in flights)
    assert operators.launches_of(CHAIN[-1]) == []
    (impulse,) = (stage for stage in CHAIN if stage.name == "impulse")
    pool = operators.pool_of(CHAIN, impulse, {})
    told = {node.data for node in pool if node.op == "symbol"}
    assert {"ẽ", "Ṽ·n", "m", "M"} <= told  # earlier results, and inputs
    assert "μ" in {node.data for node in pool}  # its own definitions
    assert not {"J", "V⁺", "landing.distance"} & told  # its own, and later ones
    sizes = {node.args[0] for node in pool if node.op == "norm"}
    assert operators.OWN["contact.velocity"] in sizes
    assert not {n, operators.OWN["impact.restitution"]} & sizes  # of length 1, and a number
    assert -operators.e_y in operators.pool_of(CHAIN, flights[0], {})
    assert x.dimension == NONE


def test_a_vector_is_replaced_by_a_vector():
    """Also where a scene leaves a vector out, such as that of the wind."""
    data = truth([*known("defaults")[::2], *known("flight-wind")[:4]])
    chain = specialised_to(data)
    columns, _ = follow(chain, data)
    (flight,) = (stage for stage in chain if stage.key == ("flight", "flight"))
    own = flight.with_spin(columns)
    assert all(
        edit.new.vector == edit.place.vector for edit in edits(chain, flight, defaults(), own)
    )
