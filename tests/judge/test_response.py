"""First-order effects of edits, beside flights of the edited law."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.expression import Values, cross, norm, ordered, symbol
from longball.judge.diagnosis.operators import FREE, Edit, edits
from longball.judge.diagnosis.residual import (
    begun,
    flown,
    launched,
    specialised_to,
    take,
    values,
)
from longball.judge.diagnosis.response import Direct, Effects, Response, cubic, free
from longball.judge.diagnosis.search import defaults
from tests.judge.material import known, truth

SCENES = 7
SHORT = 7.0  # s: a flight whose derivatives a few long steps give


def stage_of(family: str, name: str) -> tuple[tuple[Stage, ...], Stage, dict[str, Any]]:
    """The chain of a family, one of its stages, and the columns of a few scenes."""
    data = truth(known(family))
    chain = specialised_to(data)
    (stage,) = [s for s in chain if s.name == name and s.kind != "event"]
    columns = begun(data)
    told = np.isfinite(np.atleast_2d(data.expected[stage.quantities[0]])).all(axis=0)
    short = ~(columns["hang_time"] > SHORT)
    flown = np.flatnonzero(told & short)
    own = take(columns, flown[np.linspace(0, len(flown) - 1, SCENES).astype(int)])
    return chain, stage, stage.with_spin(own)


def edit_of(chain: tuple[Stage, ...], stage: Stage, columns: Any, words: str) -> Edit:
    return next(e for e in edits(chain, stage, defaults(), columns) if e.words == words)


def rows(stage: Stage, columns: Any) -> Any:
    found = values(stage, columns)
    return np.concatenate([np.atleast_2d(found[q]) for q in stage.quantities[:2]])


@pytest.mark.parametrize(
    ("family", "name", "words"),
    [
        ("flight-both", "flight", "uses {c} times m"),
        ("flight-both", "flight", "uses {c} times launch.velocity"),
        ("flight-weather", "flight", "uses {c} times T"),
        ("flight-both", "flight", "uses {c} times hang_time"),
        ("pitch", "pitch", "uses {c} times V_0"),
        ("flight-spin-lift", "flight", "uses {c} times launch.spin"),
    ],
)
def test_what_a_small_edit_does_is_what_its_flight_does(family: str, name: str, words: str):
    chain, stage, columns = stage_of(family, name)
    edit = edit_of(chain, stage, columns, words)
    (edited,) = edit.apply([stage])
    factor = 1.0 + 1e-5
    foreseen = Response(stage, Values(columns)).moved([(edit, factor)])[0, :6]
    flown = rows(edited, {**columns, FREE: np.full(len(columns["kind"]), factor)}) - rows(
        stage, columns
    )
    assert np.abs(flown).max() > 1e-6  # it does something
    assert foreseen == pytest.approx(flown, abs=2e-3 * np.abs(flown).max())


@pytest.mark.parametrize("words", ["uses m for μ", "leaves out ẽ"])
def test_an_edit_leaves_nothing_of_its_own_errors_and_much_of_another(words: str):
    chain, stage, columns = stage_of("impact", "impulse")
    right = Direct(stage, Values(columns))
    edit = edit_of(chain, stage, columns, words)
    other = edit_of(chain, stage, columns, "flips the sign of Ṽ·n")
    off = right.moved([(edit, None)])[0]
    assert Effects(right, [edit], [()], off).left() == pytest.approx([0.0], abs=1e-12)
    assert Effects(right, [other], [()], off).left()[0] > 1e-4
    assert Effects(right, [edit], [()], -off).left() == [1.0]  # only forwards


def test_a_number_may_do_more_than_its_start():
    """The start changes scenes of another g alone; the candidate's number changes all."""
    chain, stage, columns = stage_of("flight-both", "flight")
    edit = edit_of(chain, stage, columns, "uses {c} for g, whatever the scene says")
    effects = Response(stage, Values(columns))
    off = effects.moved([(edit, 9.80665)])[0]
    assert Effects(effects, [edit], [(9.8,)], off).left() == pytest.approx([0.0], abs=1e-9)


def test_of_a_pair_both_edits_are_found_where_neither_fits_alone():
    chain, stage, columns = stage_of("flight-both", "flight")
    effects = Response(stage, Values(columns))
    every = [e for e in edits(chain, stage, defaults(), columns) if "uses {c} times" in e.words]
    gravity = edit_of(chain, stage, columns, "uses {c} for g, whatever the scene says")
    mass = edit_of(chain, stage, columns, "uses {c} times m")
    off = effects.moved([(gravity, 9.81), (mass, 1.0005)]).sum(axis=0)
    every = [gravity, *every]
    with np.errstate(all="ignore"):
        found = Effects(effects, every, [(9.8,), *[(0.9,)] * (len(every) - 1)], off)
    assert min(found.left()) > 1e-3
    pair = {edit.words for edit, _ in found.pairs(1)[0]}
    # Whatever scales both forces alike moves the ball as the mass does.
    (other,) = pair - {gravity.words}
    assert other in {f"uses {{c}} times {name}" for name in ("m", "ρ_0", "ρ", "A", "k", "π")}


def test_a_slip_in_the_vector_product_of_a_program_shows_in_all_and_in_nothing_else():
    a, b = symbol("a", vector=True), symbol("b", vector=True)
    right = norm(a) * cross(a, b) + norm(b) * cross(b, a)
    stage = Stage("", ("impact.velocity",), "formula", {"value": right})
    found = [e for e in edits((stage,), stage, {}, {}) if "in every vector product" in e.words]
    assert found
    for edit in found:
        nodes = ordered([edit.by])
        assert {norm(a), norm(b)} <= {*nodes}
        assert sum(node.op == "vector" for node in nodes) == 2


def test_a_cubic_is_the_path_of_a_parabola():
    _, stage, columns = stage_of("flight-vacuum", "flight")
    balls = launched(stage, columns)
    end = flown(balls, balls.duration)
    shares = np.array([0.0, 0.2, 0.7, 1.0])
    found = cubic(end[:6])(balls, shares)
    for i, share in enumerate(shares):
        assert found[:6, i] == pytest.approx(flown(balls, share * balls.duration)[:6], rel=1e-9)
    speed = np.sqrt((found[3:6] ** 2).sum(axis=0))
    assert found[6] == pytest.approx(speed * shares[:, None] * balls.duration)


class Given:
    """Effects that are given: of each edit at its start, and at another value of its number."""

    def __init__(self, effects: dict[Edit, Any]) -> None:
        self.effects = effects

    def moved(self, changes: Any) -> Any:
        return np.array(
            [self.effects[edit][int(number not in (None, 1.0))] for edit, number in changes]
        )


def test_pairs_are_ranked_by_least_squares():
    rng = np.random.default_rng(5)
    edits = {Edit(symbol("a"), symbol("b"), i / 3, str(i)): (1.0,) * (i < 8) for i in range(12)}
    effects = {edit: rng.normal(size=(2, 6, 1)) for edit in edits}
    off = rng.normal(size=(6, 1))
    scale = np.sqrt((off * off).sum(axis=0))
    left = {}
    for pair in itertools.combinations(edits, 2):
        # Two effects of an edit with a free number, and one of another: of about its own size
        columns = [(effect, not edits[edit]) for edit in pair
                   for effect in effects[edit][: 1 + len(edits[edit])]]  # fmt: skip
        matrix = np.array([(effect / scale).ravel() for effect, _ in columns]).T
        fit, (rest,), *_ = np.linalg.lstsq(matrix, (off / scale).ravel())
        if all(0.5 < x < 2.0 for x, (_, fixed) in zip(fit, columns, strict=True) if fixed):
            whole = len(off)  # errors of size 1: a factor of 2 between them is a bit each
            left[frozenset(pair)] = whole / 2 * math.log2(rest / whole) + sum(e.bits for e in pair)
    assert len(left) > 6
    nothing = Edit(symbol("a"), symbol("b"), 3.0, "nothing")
    every, starts = [*edits, nothing], [*edits.values(), ()]
    given = Given(effects | {nothing: np.zeros((2, 6, 1))})
    ranking = Effects(given, every, starts, off)
    alone = 3 * np.log2(ranking.left()) + [edit.bits for edit in every]
    assert ranking.bits() == pytest.approx(alone)
    found = ranking.pairs(99)
    ranked = [frozenset((one, other)) for (one, _), (other, _) in found if one is not other]
    assert ranked == sorted(left, key=left.__getitem__)


def test_a_longer_path_takes_more_of_the_spin():
    chain, stage, columns = stage_of("flight-spin-decay", "flight")
    edit = edit_of(chain, stage, columns, "uses {c} times the speed along the path")
    (edited,) = edit.apply([stage])
    factor, spin = 1.0 + 1e-5, stage.quantities[2]
    foreseen = Response(stage, Values(columns)).moved([(edit, factor)])[0, 6:9]
    longer = {**columns, FREE: np.full(len(columns["kind"]), factor)}
    flown = values(edited, longer)[spin] - values(stage, columns)[spin]
    assert foreseen == pytest.approx(flown, abs=2e-3 * np.abs(flown).max())


def test_the_effects_on_free_balls_are_those_on_parabolas():
    """However large they are: in a vacuum, a parabola is its own cubic."""
    chain, stage, columns = stage_of("flight-vacuum", "flight")
    balls = launched(stage, columns)
    lasts, end = balls.duration, flown(balls, balls.duration)[:6]
    way = Response(stage, Values(columns), cubic(end), free)
    assert way.off(end + 3.0) == pytest.approx(np.full_like(end, 3.0))
    v, g, none = balls.y[3:6], columns["g"] * np.array([[0], [0], [-1]]), np.zeros((3, SCENES))
    for words, number, place, velocity in (
        ("uses {c} times g", 5.0, 2 * g * lasts**2, 4 * g * lasts),
        ("uses the components (x, -y, z) of dr/dt", None,
         v * lasts * np.array([[0], [-2], [0]]), none),
        ("uses {c} times launch.velocity", 3.0, 2 * v * lasts, 2 * v),
        ("uses {c} times hang_time", 1.5, end[3:] * lasts / 2, g * lasts / 2),
    ):  # fmt: skip
        edit = edit_of(chain, stage, columns, words)
        moved = way.moved([(edit, number)])[0, :6]
        assert moved == pytest.approx(np.concatenate([place, velocity]), abs=1e-9), words
