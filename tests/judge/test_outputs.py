"""Outputs in other units and axes: converted back, and told apart from wrong formulas."""

from __future__ import annotations

from dataclasses import replace

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


def test_the_truth_is_in_its_own_units(truth):
    data, found = outputs(truth, specialised_to(truth))
    assert found == []
    assert data is truth


def test_lengths_in_feet(truth):
    feet = scaled(truth, 1 / 0.3048, M)
    assert len(wrong(feet)) > 4
    data, (found,) = outputs(feet, specialised_to(feet))
    assert found.edit == "all lengths are 3.28084 times the right ones (feet)"
    assert found.remedy == "give them in m"
    assert wrong(data) == []


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


def test_times_in_milliseconds(truth):
    late = scaled(truth, 1e3, S)
    data, (found,) = outputs(late, specialised_to(late))
    assert found.edit == "all times are 1000 times the right ones (thousands)"
    assert wrong(data) == []


def test_one_output_with_the_wrong_sign(truth):
    other = changed(truth, **{"impact.impulse": -truth.given["impact.impulse"]})
    data, (found,) = outputs(other, specialised_to(other))
    assert found.edit == "impact.impulse is the negative of the right value"
    assert found.remedy == "turn the sign"
    assert wrong(data) == []


def test_vectors_with_two_axes_exchanged(truth):
    turned = changed(truth, **{q: truth.given[q][[0, 2, 1]] for q in OWN if OWN[q].vector})
    data, (found,) = outputs(turned, specialised_to(turned))
    assert found.edit == "all vectors are given as (x, z, y)"
    assert wrong(data) == []


def test_one_output_that_equals_another(truth):
    late = changed(truth, **{"landing.velocity": truth.given["impact.velocity"]})
    data, (found,) = outputs(late, specialised_to(late))
    assert found.edit == "landing.velocity equals your impact.velocity"
    assert wrong(data) == []


def test_one_output_divided_by_an_input(truth):
    light = changed(truth, **{"impact.impulse": truth.given["impact.impulse"] / truth.columns["m"]})
    data, (found,) = outputs(light, specialised_to(light))
    assert found.edit == "impact.impulse is the right value divided by m"
    assert wrong(data) == []


def test_another_mistake_beside_it_stays(truth):
    energy = truth.given["impact.energy_change"]
    both = changed(scaled(truth, 1 / 0.3048, M), **{"impact.energy_change": 2 * energy})
    data, (found,) = outputs(both, specialised_to(both))
    assert found.sentence.startswith("all lengths are 3.28084 times")
    assert wrong(data) == ["energy"]


@pytest.mark.parametrize("quantity", ["landing.distance", "impact.energy_change"])
def test_a_value_that_nothing_follows_from_is_left_to_its_formula(truth, quantity):
    other = changed(truth, **{quantity: 2 * truth.given[quantity]})
    data, found = outputs(other, specialised_to(other))
    assert found == []
    assert data is other


def test_a_wrong_value_that_later_ones_follow_from_is_a_formula(truth):
    """A doubled impulse that the ball gets too is no other unit of the output."""
    J, n, m = truth.given["impact.impulse"], truth.given["contact.normal"], truth.columns["m"]
    struck = truth.given["impact.velocity"] + J * n / m
    other = changed(truth, **{"impact.impulse": 2 * J, "impact.velocity": struck})
    _, found = outputs(other, specialised_to(other))
    assert found == []


def test_errors_of_a_flight_belong_to_their_quantities():
    data = true("flight-both")
    for quantity in ("landing.position", "landing.velocity"):
        other = changed(data, **{quantity: data.given[quantity] + 1.0})
        found = _errors(other, specialised_to(other))
        flight = {q: wrong for (_, kind, q), (_, wrong) in found.items() if kind == "flight"}
        assert [q for q, is_wrong in flight.items() if is_wrong] == [quantity]


def test_wrong_values_of_no_rule_are_no_conversion(truth):
    draw = np.random.default_rng(3)
    position = truth.given["landing.position"]
    other = changed(truth, **{"landing.position": position * draw.uniform(0.5, 2, position.shape)})
    _, found = outputs(other, specialised_to(other))
    assert found == []
