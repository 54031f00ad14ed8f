"""Flights of an integrator, planted in right answers: the judge names it, its step and its end."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from longball.engines.verlet import PUSHES
from longball.judge.diagnosis import schemes
from longball.judge.diagnosis.chain import I
from longball.judge.diagnosis.evidence import CHANCE, cost
from longball.judge.diagnosis.integrators import (
    EXACT,
    INTEGRATORS,
    VERLET,
    Integrator,
    Way,
    slips,
    straight,
)
from longball.judge.diagnosis.operators import Edit, free
from longball.judge.diagnosis.residual import (
    Data,
    Followed,
    compared,
    follow,
    specialised_to,
    values,
)
from longball.judge.diagnosis.schemes import (
    SOME,
    Steps,
    _numbered,
    explain_push,
    explain_scheme,
    with_edit,
)
from tests.judge import material
from tests.judge.material import known, off, truth


@cache
def flights(family: str = "flight-both", every: int = 6) -> tuple[Any, Any, Data]:
    """The chain of a family, the flight after the bat, and right answers."""
    data = truth(known(family)[::every])
    chain = specialised_to(data)
    (stage,) = (stage for stage in chain if stage.name == "flight")
    return chain, stage, data


@np.errstate(all="ignore")  # as `diagnose`
def planted(way: Any, data: Data, chain: Any, stage: Any) -> tuple[Data, Any, Followed]:
    """Answers with the flights of an integrator; their columns, and the residuals of the stage."""
    data, columns = material.planted(
        data, chain, lambda columns: way(stage, stage.with_spin(columns))[0]
    )
    return data, columns, off(stage, data, columns)


def integrator(words: str) -> Integrator:
    return next(one for one in (*INTEGRATORS, *slips()) if one.words.startswith(words))


def most(one: Followed) -> float:
    """Evidence of an explanation of all errors, in bits, before its own cost."""
    return cost(one.off / one.floor) - CHANCE


WAYS = [
    (Way(integrator("explicit Euler"), 0.01), None),
    (Way(integrator("explicit Euler"), 0.0137), None),  # a step that nobody chooses
    (Way(integrator("explicit Euler"), 0.0137), 0.0137),
    (Way(integrator("semi-implicit Euler, velocity first"), 0.004), None),
    (Way(integrator("the midpoint method"), 1 / 60), None),
    (Way(integrator("the Adams-Bashforth method of order 2"), 0.02), None),
    (Way(integrator("RK4"), 0.02, chord=True), None),
    (Way([*VERLET.values()][1], 0.05, chord=True), None),
    (Way(integrator("RK4 with no k3 in the state of k4"), 0.02), None),
    (Way(integrator("RK4 with 6/7 times"), 0.02), None),
]


@np.errstate(all="ignore")
@pytest.mark.parametrize(("way", "dt"), WAYS, ids=lambda one: getattr(one, "words", str(one))[15:])
def test_a_way_is_named(way: Way, dt: float | None):
    chain, stage, right = flights()
    data, columns, one = planted(way, right, chain, stage)
    found = Steps(stage, data, columns, one).named(dt)
    assert found is not None
    assert found.adequate
    assert 0 < found.evidence <= most(one) - found.bits
    assert found.step == pytest.approx(way.h, rel=1e-6)
    assert found.way.chord == way.chord
    # Another integrator may give the same numbers: it has to agree to the last digit.
    again, *_ = planted(found.way, right, chain, stage)
    for quantity in stage.quantities[:2]:
        off = again.given[quantity] - data.given[quantity]
        assert np.nanmax(abs(off)) < 1e-9
    if found.way.one.words != way.one.words:
        assert way.one.words in found.words


def test_the_cost_of_a_way(monkeypatch: Any):
    """A step that the author has stated costs nothing, a round one little, any other one much."""
    chain, stage, right = flights()
    euler, bits = integrator("explicit Euler"), []
    monkeypatch.setattr(schemes, "INTEGRATORS", (euler,))
    for h, dt in ((0.01, 0.01), (0.01, None), (0.0137, None)):
        data, columns, one = planted(Way(euler, h), right, chain, stage)
        bits.append(Steps(stage, data, columns, one).named(dt).bits)
    assert bits[0] + 5 < bits[1] < bits[2] - 15


def test_fewer_than_three_scenes_show_no_scheme(monkeypatch: Any):
    """In one or two, another one fits by chance."""
    chain, stage, right = flights()
    euler = integrator("explicit Euler")
    monkeypatch.setattr(schemes, "INTEGRATORS", (euler,))
    data, columns, one = planted(Way(euler, 0.01), right, chain, stage)
    for count in (2, 3):
        few = Steps(stage, data, columns, one.of(np.flatnonzero(one.wrong)[:count]))
        assert (few.named(None, slipped=False) is None) == (count == 2)


@np.errstate(all="ignore")
def test_exact_flights_that_end_on_a_chord():
    chain, stage, right = flights()
    data, columns, one = planted(Way(EXACT, 0.02, chord=True), right, chain, stage)
    found = Steps(stage, data, columns, one).named(None)
    assert (found.way, found.order) == (Way(EXACT, 0.02, chord=True), None)


@np.errstate(all="ignore")
def test_errors_of_no_known_scheme_have_an_order():
    """Two steps of RK4, three tenths and seven tenths of a step long."""
    chain, stage, right = flights()
    whole = integrator("RK4")

    def uneven(f: Any, y: Any, t: Any, h: Any, left: Any, all_: Any) -> Any:
        y, _ = whole.step(f, y, t, 0.3 * h, None, all_)
        return whole.step(f, y, t + 0.3 * h, 0.7 * h, None, all_)

    data, columns, one = planted(Way(Integrator("uneven", 4, uneven), 0.2), right, chain, stage)
    steps = Steps(stage, data, columns, one)
    found = steps.order()
    assert (found.order, found.adequate, found.way) == (4, False, None)
    assert 0 < found.evidence < most(one.of(steps.short(one.wrong, SOME))) - found.bits
    assert found.step == pytest.approx(0.2 * (0.3**5 + 0.7**5) ** 0.25, rel=0.1)
    noise = data.given["landing.velocity"] * np.random.default_rng(1).uniform(
        0.9, 1.1, data.given["landing.velocity"].shape
    )
    other = replace(data, given={**data.given, "landing.velocity": noise})
    off, _ = compared(stage, other, columns, one.some)
    assert Steps(stage, other, columns, off).order() is None


@np.errstate(all="ignore")
@pytest.mark.parametrize(("push", "times"), [*((push, 1.0) for push in PUSHES), ("whole", 0.5)])
def test_a_contact_force_is_named(push: Any, times: float):
    chain, stage, right = flights("at-bat", 3)
    way = Way([*VERLET.values()][1], 0.004, chord=True)
    right = replace(right, ways={"pitch": way, "touching": straight(way)})
    data, columns, one = planted(replace(way, push=push, times=times), right, chain, stage)
    assert one.wrong.sum() > 3
    found = explain_push(stage, data, columns, one)
    assert found is not None
    assert (found.way.push, found.way.times, found.way.h) == (push, times, 0.004)
    # A whole impulse at once needs no push.
    assert explain_push(stage, replace(data, ways={}), columns, one) is None


@np.errstate(all="ignore")
def test_a_law_and_a_scheme_are_found_together():
    chain, stage, right = flights()
    times = [Edit(I[name], 1.1 * I[name], 5.0, f"uses 1.1 {name}") for name in ("m", "g")]
    (heavy,) = times[1].apply([stage])
    way = Way(integrator("explicit Euler"), 0.01)
    data, columns, one = planted(lambda _, columns: way(heavy, columns), right, chain, stage)
    edit, scheme = with_edit(Steps(stage, data, columns, one), times)
    assert edit is times[1]
    assert scheme.way == way
    assert 0 < scheme.evidence < most(one) - scheme.bits - edit.bits


@pytest.mark.nightly  # every scheme is tried, and every last step
@np.errstate(all="ignore")
def test_a_wrong_law_is_no_scheme():
    chain, stage, right = flights()
    (heavy,) = Edit(I["g"], 1.001 * I["g"], 5.0, "").apply([stage])
    data, columns, one = planted(
        lambda _, columns: (values(heavy, columns), {}), right, chain, stage
    )
    assert explain_scheme(chain, stage, data, columns, one) is None


@np.errstate(all="ignore")
def test_right_scenes_rule_out_integrators_whose_errors_they_would_show():
    """In a vacuum, some are exact and others are not."""
    data = truth([*known("flight-both")[::9], *known("flight-vacuum")[::9]])
    chain = specialised_to(data)
    (stage,) = (stage for stage in chain if stage.name == "flight")
    euler, rk4 = integrator("explicit Euler"), integrator("RK4")
    falls = data.columns["air"] == "none"
    found = []
    for right in (falls, ~falls):
        moved = np.where(right, 0.0, 0.01)
        given = {q: data.given[q] + moved for q in stage.quantities[:2]}
        other = replace(data, given={**data.given, **given})
        columns, _ = follow(chain, other)
        one = off(stage, other, columns)
        assert 0 < one.wrong.sum() < one.checked.sum()
        found.append(Steps(stage, other, columns, one).possible)
        alone = one.of(np.flatnonzero(one.wrong))
        assert Steps(stage, other, columns, alone).possible == INTEGRATORS
    assert rk4 in found[0]
    assert euler not in found[0]
    assert rk4 not in found[1]


def test_usual_and_round_numbers_are_tried_near_a_fitted_one():
    def tried(start: Any, edit: Edit) -> dict[float, float]:
        return {
            value: one.bits - edit.bits
            for one in _numbered(replace(edit, starts=(start,)))
            for value in (float(one.words.split()[1]),)
        }

    factor = Edit(I["m"], free() * I["m"], 4.0, "uses {c} times m", starts=(1.0,))
    value = Edit(I["m"], free(I["m"].dimension), 4.0, "uses {c} for m", starts=(1.0,))
    assert tried(2.043, value).keys() == {2.0, 2.04}
    assert tried(1.56, factor).keys() == {1.5, 1.6, 1.56}
    found = tried(0.3123, factor)
    assert found.keys() == {0.3, 0.31, 0.312, 0.3048, round(1 / math.pi, 9)}
    assert found[0.312] - found[0.31] == pytest.approx(math.log2(10))
    assert found[0.3048] == tried(2.043, factor)[2.0]  # one of so many
    assert [*_numbered(replace(value, starts=(I["M"],)))] == []
    plain = Edit(I["m"], I["M"], 2.0, "uses M for m")
    assert [*_numbered(plain)] == [plain]
