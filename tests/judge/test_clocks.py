"""Clocks of a candidate: rules for the times of its states, and their cost in bits."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis import clocks
from longball.judge.diagnosis.clocks import LONGEST, ON_LATTICE, Scheme, lattice
from longball.judge.diagnosis.evidence import CHANCE, cost
from longball.judge.diagnosis.residual import (
    LONGEST_FLIGHT,
    compared,
    follow,
    launched,
    specialised_to,
    values,
)  # fmt: skip
from longball.judge.diagnosis.schemes import ROUND, explain_scheme
from tests.judge.material import known, truth

TIMES = np.array([0.53, 0.87, 1.21, 2.26, 3.08, 4.4, 5.02])


def test_the_bits_of_a_lattice():
    step, bits = lattice(TIMES, dt=0.01)
    assert step == 0.01
    assert bits == pytest.approx(6 * math.log2(1 / (2 * ON_LATTICE)))
    # A time off the lattice is one less, and costs bits; so does the choice among steps.
    missing = np.append(TIMES, 6.0033)
    assert lattice(missing, dt=0.01)[1] == pytest.approx(bits - 5.0)
    found, chosen = lattice(TIMES)
    assert found == pytest.approx(0.01)
    assert bits - 16 < chosen < bits - 12  # some ten thousand steps are tried
    assert lattice(TIMES / 2) is None or lattice(TIMES / 2)[0] != 0.01
    assert lattice(np.append(TIMES, [np.nan, 0.1234]))[0] == pytest.approx(0.01)
    assert lattice(np.append(TIMES[:4], 6.0033), dt=0.01) is not None  # four of five


def test_no_lattice():
    assert lattice(TIMES[:4], dt=0.01) is None  # too few
    assert lattice(TIMES + np.array([0, 1, 1, 0, 0, 0, 0]) * 3.3e-3, dt=0.01) is None
    assert lattice(TIMES, dt=0.013) is None
    assert lattice(np.repeat(TIMES[:3], 3), dt=0.01) is None  # different ones count


def test_steps_are_searched_from_the_shortest_to_the_longest():
    draw = np.random.default_rng(3)
    for step in (0.39, 1.7e-4):
        times = step * draw.integers(math.ceil(0.5 / step), math.ceil(6.0 / step), 9)
        assert lattice(np.unique(times) if step < 0.1 else step * np.arange(2, 12))[0] == (
            pytest.approx(step, rel=1e-6)
        )


def test_many_times_that_are_wrong_by_powers_of_ten():
    """Each has millions of divisions: all of them at once do not fit into memory."""
    found, _ = lattice(1e4 * 0.01 * np.arange(50, 1500))
    assert found == pytest.approx(LONGEST)
    times = np.random.default_rng(4).uniform(1e3, 1e5, 2000)
    assert lattice(times) is None


def rule(behind, told=None):
    """The rule for states that are `behind` the reported times, s, and its words."""
    told = TIMES if told is None else told
    found = clocks._rule(told, told - behind, None)
    return found, found.text.format("a state", "the time")


def test_rules():
    none, text = rule(np.full(7, 1e-9))
    assert (text, none.bits) == ("", 0.0)
    assert np.array_equal(none.times, TIMES)
    odd = np.random.default_rng(1).uniform(0.4, 5, 7)
    late, text = rule(np.full(7, 0.0125), odd)
    assert late.times == pytest.approx(odd - 0.0125)
    assert late.step == 0.0125
    assert "0.0125 s before" in text
    assert "0.0125 s after" in rule(np.full(7, -0.0125), odd)[1]
    # One of the states may be of another time.
    assert rule(np.array([0.0125] * 4 + [0.3]), odd[:5])[0].step == 0.0125
    for side, whole in (("before", np.floor), ("after", np.ceil)):
        at, text = rule(odd - whole(odd / 0.01) * 0.01, odd)
        assert at.times == pytest.approx(whole(odd / 0.01) * 0.01)
        assert side in text
        assert at.step == pytest.approx(0.01)
    multiples, text = rule(np.random.default_rng(2).uniform(-0.009, 0.009, 7))
    assert multiples.step == pytest.approx(0.01)
    assert "multiples" in text
    # A state of a time that is more than a step away is not that of the multiple.
    assert rule(np.random.default_rng(2).uniform(-0.2, 0.2, 7))[0].step is None
    free, text = rule(np.random.default_rng(2).uniform(-0.2, 0.2, 7), odd)
    assert free.step is None
    assert free.bits > 7 * 20
    assert np.array_equal(free.times, odd - np.random.default_rng(2).uniform(-0.2, 0.2, 7))
    assert none.bits < late.bits < at.bits + 10 < free.bits


# --- clocks of flights ----------------------------------------------------------------------------


@cache
def right() -> Any:
    """The chain of some flights, and right answers."""
    data = truth(known("flight-both")[:60:5])
    return specialised_to(data), data


@np.errstate(all="ignore")  # as `diagnose`
def explained(change: Any, kind: str = "flight") -> Scheme | None:
    """The explanation of landings that are changed.

    `change` is a function of the true times, and of a function from times to states. It returns new
    values of quantities.
    """
    chain, data = right()
    columns, _ = follow(chain, data)
    (flight,) = (stage for stage in chain if stage.kind == "flight")

    def at(times: Any) -> dict[str, Any]:
        return values(flight, {**columns, "hang_time": times})

    given = {**data.given, **change(data.given["landing.hang_time"], at)}
    data = replace(data, given=given)
    columns, _ = follow(chain, data)
    (stage,) = (one for one in chain if one.kind == kind and one.name in ("flight", "landing"))
    one, _ = compared(stage, data, columns, np.arange(len(data.cases)))
    found = explain_scheme(chain, stage, data, columns, one)
    if found is not None and kind == "flight":  # at most the cost of all errors
        assert 0 < found.evidence <= cost(one.off / one.floor) - found.bits - CHANCE
    return found


def test_no_ball_flies_for_hours():
    """A time in other units, or divided by the step instead of multiplied, is wrong."""
    chain, data = right()
    columns, _ = follow(chain, data)
    (flight,) = (stage for stage in chain if stage.kind == "flight")
    late = launched(flight, {**columns, "hang_time": np.full(len(data.cases), 1e6)})
    assert set(late.duration) == {LONGEST_FLIGHT}


@pytest.mark.parametrize(("late", "given"), [(0.02, 1.0), (-0.0125, 1.0), (0.02, np.nan)])
def test_a_clock_that_is_late(late: float, given: float):
    """Also that of a candidate that gives no velocity."""
    found = explained(lambda time, at: {
        "landing.hang_time": time + late, "landing.time": time + late,
        "landing.velocity": at(time)["landing.velocity"] * given,
    })  # fmt: skip
    assert found.adequate
    assert "landing.velocity" not in found.words  # nor of one of the two alone
    assert (found.order, found.way) == (None, None)
    assert found.step == abs(late)
    # One delay, of the position and of the velocity, costs as much as that of one of them.
    assert found.bits == pytest.approx(rule(np.full(7, late))[0].bits)
    assert ("before" in found.words) == (late > 0)


@pytest.mark.parametrize("side", [math.floor, math.ceil])
def test_a_velocity_of_another_step(side: Any):
    found = explained(
        lambda time, at: {
            "landing.velocity": at(np.array([side(x / 0.01) * 0.01 for x in time]))[
                "landing.velocity"
            ]
        }
    )
    assert found.adequate
    assert found.step == pytest.approx(0.01)
    assert ("before" in found.words) == (side is math.floor)


def test_a_velocity_of_any_other_time():
    draw = np.random.default_rng(1).uniform(0, 0.3, 20)
    found = explained(
        lambda time, at: {"landing.velocity": at(time - draw[: len(time)])["landing.velocity"]}
    )
    assert found.adequate
    assert found.step is None


@pytest.mark.parametrize("side", [math.floor, math.ceil])
def test_an_end_at_a_step(side: Any):
    def stepped(time: Any, at: Any) -> dict[str, Any]:
        steps = np.array([side(x / 0.05) * 0.05 for x in time])
        return {**at(steps), "landing.hang_time": steps, "landing.time": steps}

    found = explained(stepped, "event")
    assert found.adequate
    assert found.step == pytest.approx(0.05)
    assert ("after" in found.words) == (side is math.ceil)


def test_an_end_that_is_late_by_one_height_is_at_no_step():
    below = np.array([[0.0], [0.0], [0.03]])
    found = explained(lambda time, at: {"landing.position": at(time)["landing.position"] - below},
                         "event")  # fmt: skip
    assert found is None


def test_noise_is_no_clock():
    draw = np.random.default_rng(1)
    found = explained(
        lambda time, at: {
            "landing.velocity": at(time)["landing.velocity"]
            * draw.uniform(0.9, 1.1, (3, len(time)))
        }
    )
    assert found is None


def test_round_steps_are_steps_of_a_candidate():
    assert 0.0 < min(ROUND) < max(ROUND) <= LONGEST
