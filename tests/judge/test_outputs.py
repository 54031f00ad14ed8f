"""Outputs in other units and axes: converted back, and told apart from wrong formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis.chain import OWN
from longball.judge.diagnosis.expression import M, S
from longball.judge.diagnosis.outputs import _errors, outputs
from longball.judge.diagnosis.residual import Data, follow, specialised_to
from tests.judge import material


def true(*families: str, every: int = 8) -> Data:
    """Some scenes of families, in which every answer is the truth."""
    return material.truth(material.known(*families)[::every])


@pytest.fixture(scope="module")
def truth() -> Data:
    return true("flight-both", "at-bat")


def changed(data: Data, **given):
    return replace(data, given={**data.given, **given})


def wrong(data: Data) -> list[str]:
    return [f.stage.name for f in follow(specialised_to(data), data)[1] if f.wrong.any()]


def scaled(data: Data, factor: float, dimension) -> Data:
    own = [q for q, node in OWN.items() if node.dimension == dimension]
    return changed(data, **{q: factor * data.given[q] for q in own})


def in_feet(data: Data) -> Data:
    return scaled(data, 1 / 0.3048, M)


def with_two_impulses(data: Data) -> Data:
    """A doubled impulse that the ball gets too is no other unit of the output."""
    J, n, m = data.given["impact.impulse"], data.given["contact.normal"], data.columns["m"]
    struck = data.given["impact.velocity"] + J * n / m
    return changed(data, **{"impact.impulse": 2 * J, "impact.velocity": struck})


def with_values_of_no_rule(data: Data) -> Data:
    position = data.given["landing.position"]
    shares = np.random.default_rng(3).uniform(0.5, 2, position.shape)
    return changed(data, **{"landing.position": position * shares})


def other(quantity: str, change: Callable[[Data, Any], Any]) -> Callable[[Data], Data]:
    return lambda data: changed(data, **{quantity: change(data, data.given[quantity])})


# Outputs of a program, the conversion that is named, and the remedy.
CONVERTED = [
    (in_feet, "all lengths are 3.28084 times the right ones (feet)", "give them in m"),
    (lambda data: scaled(data, 1e3, S), "all times are 1000 times the right ones (thousands)", ""),
    (other("impact.impulse", lambda data, J: -J),
     "impact.impulse is the negative of the right value", "turn the sign"),
    (lambda data: changed(data, **{q: data.given[q][[0, 2, 1]] for q in OWN if OWN[q].vector}),
     "all vectors are given as (x, z, y)", ""),
    (other("landing.velocity", lambda data, v: data.given["impact.velocity"]),
     "landing.velocity equals your impact.velocity", ""),
    (other("impact.impulse", lambda data, J: J / data.columns["m"]),
     "impact.impulse is the right value divided by m", ""),
    (other("landing.velocity", lambda data, v: v * 3.6),
     "landing.velocity is 3.6 times the right value (km/h)", "give landing.velocity in m/s"),
]  # fmt: skip
NOT_CONVERTED = [
    lambda data: data,
    # Nothing follows from these: they are left to their formula.
    other("landing.distance", lambda data, x: 2 * x),
    other("impact.energy_change", lambda data, x: 2 * x),
    with_two_impulses,
    with_values_of_no_rule,
]


def test_conversions_are_named_and_undone(truth):
    for change, edit, remedy in CONVERTED:
        converted = change(truth)
        assert wrong(converted)
        data, (found,) = outputs(converted, specialised_to(converted))
        assert found.edit == edit
        assert found.stage == ("all" if edit.startswith("all ") else "output")
        assert str(found.remedy).startswith(remedy)
        assert wrong(data) == []
    assert len(wrong(in_feet(truth))) > 4


def test_what_no_conversion_explains_is_left(truth):
    for change in NOT_CONVERTED:
        kept = change(truth)
        data, found = outputs(kept, specialised_to(kept))
        assert found == []
        assert data is kept


def test_another_mistake_beside_it_stays(truth):
    both = other("impact.energy_change", lambda data, x: 2 * x)(in_feet(truth))
    data, (found,) = outputs(both, specialised_to(both))
    assert found.sentence.startswith("all lengths are 3.28084 times")
    assert wrong(data) == ["energy"]


def test_speeds_of_one_kind_of_scene_in_kilometres_per_hour():
    both = true("pitch", "at-bat", every=3)
    told = np.isfinite(both.given["plate.velocity"]).all(axis=0)
    batted = told & (both.columns["kind"] == "at-bat")
    fast = {"plate.velocity": both.given["plate.velocity"] * np.where(batted, 3.6, 1.0)}
    data, (found,) = outputs(changed(both, **fast), specialised_to(both))
    assert found.edit == "plate.velocity is 3.6 times the right value (km/h)"
    assert found.scenes.startswith("kind = at-bat")
    assert (found.wrong, found.checked) == (batted.sum(), told.sum())
    assert wrong(data) == []


def test_errors_of_a_flight_belong_to_their_quantities():
    data = true("flight-both")
    for quantity in ("landing.position", "landing.velocity"):
        other = changed(data, **{quantity: data.given[quantity] + 1.0})
        found = _errors(other, specialised_to(other))
        flight = {q: wrong for (_, kind, q), (_, wrong) in found.items() if kind == "flight"}
        assert [q for q, is_wrong in flight.items() if is_wrong] == [quantity]
