"""Parts of the search for edits: which edits are equal, and with which numbers it begins."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.expression import (
    Node,
    Values,
    constant,
    cross,
    function,
    norm,
    symbol,
    where,
)
from longball.judge.diagnosis.residual import inputs
from longball.judge.diagnosis.search import (
    _fingerprint,
    _fitted_from,
    _is_finite,
    _moved_at_random,
    _renamed,
    _roundest,
    defaults,
)
from longball.model.scene import AtBatScene

x, y = symbol("x"), symbol("y")
a, b = symbol("a", vector=True), symbol("b", vector=True)
COLUMNS: dict[str, Any] = {
    "x": np.array([2.0, 3e-7, 5.0]), "y": np.array([1.0, -4.0, 0.0]),
    "a": np.array([[3.0, 1.0, -2.0], [1e-3, 5.0, 0.3], [7.0, 2.0, 1.0]]), "b": np.eye(3),
    **{name: np.array(["none"] * 3) for name in ("kind", "spin", "spin after")},
}  # fmt: skip
SMALL = constant(1e-12)


def stage(root: Node) -> Stage:
    return Stage("", ("impact.velocity",), "formula", {"value": root})


def prints(*roots: Node) -> set[bytes]:
    return {_fingerprint(stage(root), Values(COLUMNS)) for root in roots}


@pytest.mark.parametrize(
    "equal",
    [
        (x + 0.1 * y + 0.2 * y, x + 0.3 * y),
        (SMALL * x * 3.0, 3.0 * (SMALL * x)),
        (0.0 * y, -(0.0 * y)),
        # A component that should be 0 is a rounding error of the others.
        (a + cross(a, a * 1.1), a),
        (a * (1.0 / norm(a)) * norm(a), a),
    ],
)
def test_equal_formulas_have_one_fingerprint(equal: tuple[Node, ...]):
    assert len(prints(*equal)) == 1


@pytest.mark.parametrize(
    "unequal",
    [
        (x, x * (1.0 + 1e-5)),
        (SMALL * x, SMALL * x * (1.0 + 1e-5)),
        (a, a * (1.0 + 1e-5), -a, a + 1e-5 * cross(a, b)),
        # A jump between the same two random numbers, elsewhere.
        (where(x - 3.5, x, y), where(x - 3.6, x, y)),
        (function("rises", x - 3.5), function("rises", x - 3.6)),
    ],
)
def test_unequal_formulas_have_several(unequal: tuple[Node, ...]):
    assert len(prints(*unequal)) == len(unequal)


def test_a_new_division_by_zero_is_no_edit():
    probe = Values(COLUMNS)
    for root, is_finite in (
        (x / (y - y), False), (x / y, True), (x + x / (y - y) * 0.0, False), (2.0 * x, True),
    ):  # fmt: skip
        assert _is_finite(stage(root), stage(x), probe) == is_finite
    known = stage(x / (y - y))
    assert _is_finite(known, known, probe)  # it was infinite before


def test_a_symbol_is_renamed_wherever_it_is():
    c = symbol("c", (1, 0, 0), True)
    renamed = _renamed(stage(c + x * c), "c", "d").roots["value"]
    d = symbol("d", (1, 0, 0), True)
    assert renamed is d + x * d


def test_random_numbers_near_the_scenes():
    """Signs are kept where all are positive; nothing else is equal, and options stay."""
    moved = _moved_at_random(stage(x), COLUMNS)
    assert (moved["x"] > 0).all()
    for name in ("x", "y", "a"):
        assert (moved[name] != COLUMNS[name]).all()
        assert np.abs(moved[name] - COLUMNS[name]).max() < 0.6 * np.abs(COLUMNS[name]).max()
    assert moved["kind"] is COLUMNS["kind"]
    states = [moved[name] for name in ("v0", "v", "r", "r0", "ω0")]
    assert {state.shape for state in states} == {(3, 3)}
    assert moved["dr/dt"] is moved["v"]


def test_defaults_are_the_values_of_scenes_that_leave_a_key_out():
    found, usual = defaults(), inputs([AtBatScene(id="a")])
    for name, column in usual.items():
        if column.ndim == 1 and np.isfinite(column).all():
            assert found[name] == column[0]
    air = {"density": {"temperature": 300.0}}
    weather = inputs([AtBatScene.model_validate({"air": air})])
    assert [found[name] for name in "pφh"] == [weather[name][0] for name in "pφh"]
    assert not {"μ_f", "λ"} & found.keys()  # every scene with friction or an earth gives these


def test_the_roundest_number_that_fits():
    scenes = np.linspace(1.0, 2.0, 6)
    slopes = np.array([[1e4 * scenes]])
    for number, round_ in ((1.2500001, 1.25), (0.30480004, 0.3048), (math.pi / 30, math.pi / 30)):
        r = 1e4 * scenes[None] * (number - round_)
        found, bits = _roundest(np.array([number]), r, slopes, 0)
        assert found == pytest.approx(round_, rel=1e-12)
        assert bits > 0
    # Of two numbers, the other one is fitted again.
    both = np.array([[1e4 * scenes], [1e4 * np.ones(6)]])
    r = np.full((1, 6), 30.0)
    assert _roundest(np.array([2.0, 0.503]), r, both, 1)[0] == 0.5


def test_a_fit_from_several_starts():
    """A factor that long steps forbid from 1: usual ones are tried, too."""
    scenes = np.linspace(1.0, 2.0, 6)

    def screened(c):
        r = np.where(abs(c - 2.0) < 0.2, 1e3 * (c - 2.0), 1e6) * scenes
        return r[:, None]

    assert _fitted_from(screened, [1.0], factor=True)[0] == pytest.approx(2.0)
    assert _fitted_from(screened, [1.0], factor=False)[0] != pytest.approx(2.0)
    c, r = _fitted_from(screened, [1.0, 2.1], factor=False)
    assert c == pytest.approx(2.0)
    assert abs(r).max() < 1e-6
