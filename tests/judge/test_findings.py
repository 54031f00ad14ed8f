"""Sentences of findings: what is wrong, where and by how much, and the right formula beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from longball.judge.diagnosis.chain import μ
from longball.judge.diagnosis.expression import norm, ordered, symbol
from longball.judge.diagnosis.findings import size
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.residual import HUGE, Data, follow, specialised_to
from longball.judge.diagnosis.search import Located, Named
from longball.judge.diagnosis.sentences import diagnosis, located, named, outcomes_wrong
from tests.judge import material


def truth(*families: str) -> Data:
    plain = (c for c in material.known(*families) if c.scene.reading == type(c.scene.reading)())
    return material.truth([*plain][:30])


def wrong(data: Data, **given):
    """Data with other values; the first stage that is wrong then, and how far."""
    data = replace(data, given={**data.given, **given})
    _, followed = follow(specialised_to(data), data)
    return data, next(one for one in followed if one.wrong.any()), followed


def test_a_named_mistake_has_the_right_formula_beside_its_own():
    data = truth("impact")
    given = data.given["impact.impulse"]
    data, one, followed = wrong(data, **{"impact.impulse": 1.5 * given})
    (place,) = (n for n in ordered(one.stage.roots.values()) if n.data == μ.data)
    m = next(n for n in ordered([place]) if n.data == "m")
    found = named(one.stage, Named((Edit(place, m, 5.0, "uses m for μ"),), 40.0), one, data)
    count = int(one.checked.sum())
    assert found.sentence.startswith(
        f"impulse: your program uses m for μ. This step is wrong in {count}"
    )
    where = f"of {count} scenes, given your own earlier values (relative error up to"
    assert where in found.sentence
    assert found.remedy == "impact.impulse should be -μ·(1 + ẽ)·Ṽ·n; yours is -m·(1 + ẽ)·Ṽ·n"
    assert (found.edit, found.bits, found.wrong) == ("uses m for μ", 40.0, count)
    told = diagnosis(followed, [found], data)
    assert (told.first, told.named) == ("impulse", ["uses m for μ"])
    assert "impulse" not in told.clean
    assert "restitution" in told.clean


def test_an_edit_inside_a_definition_is_shown_there():
    data = truth("impact")
    data, one, _ = wrong(data, **{"contact.bat_velocity": 2 * data.given["contact.bat_velocity"]})
    (half,) = (n for n in ordered(one.stage.roots.values()) if repr(n) == "L/2")
    (length,) = half.args[:1]
    found = named(one.stage, Named((Edit(half, length, 5.0, "uses L for L/2"),), 40.0), one, data)
    assert found.remedy == "r̃ should be L/2 - contact.position_y; yours is L - contact.position_y"


def test_a_point_on_another_plane_says_how_far_it_is_from_its_own():
    data = truth("pitch")
    there = data.given["plate.position"] + np.array([[0.4318], [0.0], [0.0]])
    data, _, followed = wrong(data, **{"plate.position": there})
    event = next(f for f in followed if f.stage.kind == "event")
    found = located(event.stage, Located(), event, data)
    assert found.kind == "located"
    assert "plate point lies up to 0.43 m in front of x = 0: check which plane" in found.sentence


def test_numbers_that_are_not_finite_have_no_size():
    data = truth("impact")
    data, one, _ = wrong(data, **{"impact.impulse": 1.5 * data.given["impact.impulse"]})
    endless = one.off.copy()
    endless[0, 0] = HUGE
    said = [located(x.stage, Located(), x, data).sentence for x in (one, replace(one, off=endless))]
    assert [("%" in text or "relative" in text) for text in said] == [True, False]


def test_an_output_that_equals_another_is_said():
    data = truth("at-bat")
    data, one, _ = wrong(data, **{"plate.time": data.given["contact.time"]})
    assert one.stage.name == "pitch"
    found = located(one.stage, Located(), one, data)
    assert "plate.time equals your contact.time." in found.sentence


def test_values_that_are_equal_in_truth_are_no_finding():
    data = truth("flight-both")  # a flight begins at 0: its two times are one
    moved = data.given["landing.velocity"] * 1.01
    data, one, _ = wrong(data, **{"landing.velocity": moved})
    assert "equals" not in located(one.stage, Located(), one, data).sentence


def test_the_nearest_mistake_is_no_name():
    data = truth("impact")
    data, one, _ = wrong(data, **{"impact.restitution": 1.1 * data.given["impact.restitution"]})
    edit = Edit(norm(symbol("V", vector=True)), symbol("x"), 1.0, "uses x")
    found = located(one.stage, Located(edit, 0.02), one, data)
    assert (found.kind, found.edit) == ("nearest", None)
    assert "The nearest, that your program uses x, explains 98% of the error" in found.sentence


@pytest.mark.parametrize(
    ("relative", "text"),
    [(1.8, "1.8"), (0.214, "21%"), (2e-6, "2e-06")],
)
def test_a_relative_error_in_words(relative, text):
    assert size(relative) == text


def test_wrong_outcomes_are_counted_by_what_is_said():
    pairs = [("batted", "missed")] * 5
    assert outcomes_wrong(pairs) == '5 outcomes are wrong ("batted" instead of "missed")'
    pairs = [("batted", "missed"), ("batted", "missed"), ("wall", None)]
    said = '3 outcomes are wrong (2 "batted" instead of "missed", 1 "wall" instead of none)'
    assert outcomes_wrong(pairs) == said
    assert outcomes_wrong(pairs[:1]).startswith("1 outcome is wrong")
