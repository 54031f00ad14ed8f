"""Candidates that fly in steps: which are named, and what is not taken for a scheme."""

from __future__ import annotations

import math
import runpy
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

import longball
from longball.engines.chain import solve
from longball.engines.verlet import Verlet
from longball.golden import load
from longball.judge.answers import Answer
from longball.judge.cases import decidable
from longball.judge.diagnosis.chain import I
from longball.judge.diagnosis.clocks import lattice
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.residual import data_of, follow, specialised_to
from longball.judge.diagnosis.schemes import Steps, explain_scheme, with_edit
from longball.judge.quantities import values_of

# The documentation's RK4, whose last step is shorter.
CANDIDATE = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "candidate.py"))
CASES = [
    case
    for case in load("flight-both")
    if decidable(case)
    and case.expected.outcome == "landed"
    and 0.5 < float(values_of(case.expected)["landing.hang_time"][0]) < 8.0
    and CANDIDATE["is_solved"](case.scene.model_dump(mode="json", exclude_none=True))
][:12]


def euler(state, h, *law):
    slope = CANDIDATE["rates"](state, *law)
    return [x + h * k for x, k in zip(state, slope, strict=True)]


def semi_implicit(state, h, *law):
    slope = CANDIDATE["rates"](state, *law)
    velocity = [x + h * k for x, k in zip(state[3:], slope[3:], strict=True)]
    return [*(x + h * v for x, v in zip(state[:3], velocity, strict=True)), *velocity]


def midpoint(state, h, *law):
    slope = CANDIDATE["rates"](euler(state, h / 2, *law), *law)
    return [x + h * k for x, k in zip(state, slope, strict=True)]


def uneven(state, h, *law):
    """Two steps of RK4, 3/10 and 7/10 of h long."""
    step = CANDIDATE["step"]
    return step(step(state, 0.3 * h, *law), 0.7 * h, *law)


def flown(h, step=CANDIDATE["step"], gravity=1.0):
    """The landings that the candidate gives in steps of h, by a scheme."""
    inside = CANDIDATE["solve"].__globals__
    usual, inside["step"] = inside["step"], step
    try:
        for case in CASES:
            scene = case.scene.model_dump(mode="json", exclude_none=True)
            scene["gravity"] *= gravity
            found = CANDIDATE["solve"](scene, h)["landing"]
            yield {f"landing.{key}": np.atleast_1d(value) for key, value in found.items()}
    finally:
        inside["step"] = usual


def wrong(landings, kind="flight"):
    """A wrong stage of some landings, as the arguments of `explain_scheme`."""
    answers = {
        case.id: Answer(case.id, "landed", {
            quantity: tuple(Decimal(float(x)) for x in value) for quantity, value in landing.items()
        })
        for case, landing in zip(CASES, landings, strict=True)
    }  # fmt: skip
    data = data_of(CASES, answers)
    chain = specialised_to(data)
    columns, found = follow(chain, data)
    one = next(one for one in found if one.wrong.any() and one.stage.kind == kind)
    return chain, one.stage, data, columns, one


def true(change):
    """The true landings, changed."""
    for case in CASES:
        landing = values_of(case.expected)
        found = {
            quantity: np.array([float(x) for x in value]) for quantity, value in landing.items()
        }
        change(case, found)
        yield found


@pytest.mark.parametrize(
    ("step", "h", "name", "order"),
    [
        (euler, 0.01, "explicit Euler", 1),
        (euler, 0.001, "explicit Euler", 1),
        (semi_implicit, 0.004, "semi-implicit Euler, velocity first", 1),
        (midpoint, 1 / 60, "the midpoint method", 2),
        (CANDIDATE["step"], 0.05, "RK4", 4),
        (euler, 0.0137, "explicit Euler", 1),  # a step that nobody chooses
    ],
)
@pytest.mark.sampled(every=6)
def test_a_scheme_is_named_with_its_step(step, h, name, order):
    found = explain_scheme(*wrong(flown(h, step)))
    assert found is not None
    assert found.adequate
    assert found.words.startswith(f"behaves like {name} in steps of {h:.6g} s")
    assert (found.order, found.step) == (order, pytest.approx(h, rel=1e-9))


def runge_kutta(nodes=(0.5, 0.5, 1.0), weights=(1, 2, 2, 1), divisor=6):
    def step(state, h, *law):
        slopes = [CANDIDATE["rates"](state, *law)]
        for node in nodes:
            at = [x + node * h * k for x, k in zip(state, slopes[-1], strict=True)]
            slopes.append(CANDIDATE["rates"](at, *law))
        rows = zip(state, *slopes, strict=True)
        return [x + h / divisor * np.dot(weights, each) for x, *each in rows]

    return step


@pytest.mark.parametrize(
    ("mistake", "words", "order"),
    [
        ({"nodes": (0.5, -0.5, 1.0)}, "-1/2 k2 for 1/2 k2 in the state of k3", 1),
        ({"nodes": (0.5, 0.5, 0.0)}, "no k3 in the state of k4", 1),
        ({"weights": (1, 1, 2, 1)}, "1/6 k2 for 1/3 k2 in the last sum", 0),
        ({"divisor": 7}, "6/7 times its last sum", 0),
        ({"divisor": 1}, "6 times its last sum", 0),
    ],
)
@pytest.mark.parametrize("h", [0.02, 0.005])
@pytest.mark.sampled(every=8)
def test_a_wrong_coefficient_is_named_with_its_step(h, mistake, words, order):
    found = explain_scheme(*wrong(flown(h, runge_kutta(**mistake))))
    assert found is not None
    assert found.adequate
    assert found.words == f"behaves like RK4 with {words} in steps of {h:.6g} s"
    assert found.order == order


@pytest.mark.parametrize("landing", ["interpolated", "first_below"])
@pytest.mark.sampled(every=3)
def test_the_scheme_of_the_paper_is_named_with_its_last_step(landing):
    engine = Verlet(dt=0.05, forces="old_carried", landing=landing)
    results = [values_of(solve(case.scene, engine)) for case in CASES]
    found = explain_scheme(*wrong(results))
    assert found is not None
    assert found.words.startswith(
        "behaves like velocity Verlet with the force at the old velocity, which"
    )
    assert ("on the chord" in found.words) == (landing == "interpolated")
    if landing == "first_below":
        below = explain_scheme(*wrong(results, "event"))
        assert "at the step after the event, in steps of 0.05 s" in below.words


@pytest.mark.nightly  # every scheme is tried, and every last step
def test_a_scheme_that_is_not_known_gets_its_order_and_no_name():
    found = explain_scheme(*wrong(flown(0.2, uneven)))
    assert found is not None
    assert not found.adequate
    assert found.order == 4


@pytest.mark.nightly
def test_a_wrong_law_is_no_scheme():
    assert explain_scheme(*wrong(flown(1e-3, gravity=1.001))) is None


def test_a_law_and_a_scheme_are_found_together():
    _, *rest = wrong(flown(0.01, euler, gravity=1.1))
    times = Edit(I["g"], 1.1 * I["g"], 5.0, "uses 1.1 g")
    other = Edit(I["m"], 1.1 * I["m"], 5.0, "uses 1.1 m")
    found = with_edit(Steps(*rest), [other, times])
    assert found is not None
    edit, scheme = found
    assert edit is times
    assert scheme.words.startswith("behaves like explicit Euler in steps of 0.01 s")


def test_a_late_clock_is_told_and_no_scheme():
    def late(case, landing):
        landing["landing.hang_time"] += 0.02
        landing["landing.time"] += 0.02

    found = explain_scheme(*wrong(true(late)))
    assert found.words == "gives position and velocity of 0.02 s before hang_time"
    assert found.order is None


def test_a_velocity_of_another_time_is_told_without_a_rule():
    """As of steps that are of no one length."""
    draw = np.random.default_rng(1)

    def stale(case, landing):
        time = landing["landing.hang_time"][0] - 0.3 * draw.uniform()
        path = longball.solve(case.scene, engine="ivp").path
        landing["landing.velocity"] = np.array(path.at(time).velocity)

    found = explain_scheme(*wrong(true(stale)))
    assert found.adequate
    assert found.words.startswith("gives landing.velocity of up to 0.2")


def test_the_velocity_of_the_step_before_is_told():
    def stale(case, landing):
        time = math.floor(landing["landing.hang_time"][0] / 0.01) * 0.01
        path = longball.solve(case.scene, engine="ivp").path
        landing["landing.velocity"] = np.array(path.at(time).velocity)

    found = explain_scheme(*wrong(true(stale)))
    assert found.words == "gives landing.velocity of the step before hang_time, in steps of 0.01 s"


def test_a_step_is_told_only_where_times_lie_on_a_lattice():
    whole = np.array([0.53, 0.87, 1.21, 2.26, 3.08, 4.4, 5.02])
    assert lattice(whole)[0] == pytest.approx(0.01)
    assert lattice(whole + 0.01 * np.random.default_rng(1).uniform(size=7)) is None
    # An event that is late by one time everywhere is at no step.
    deep = true(lambda case, landing: landing["landing.position"].__setitem__(2, -0.03))
    assert explain_scheme(*wrong(deep, "event")) is None
