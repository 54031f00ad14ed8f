"""Simulators in the wild: the adapters of those that are installed, and the law of the air."""

from dataclasses import replace

import pytest
from scipy.integrate import solve_ivp

from analysis import wild
from analysis.wild.air import push_of_air
from analysis.wild.simulators import SIMULATORS
from longball.golden import load
from longball.judge.cases import Exact
from longball.judge.evaluation import Judge
from longball.model.quantities import numbers

BY_TITLE = {simulator.title: simulator for simulator in SIMULATORS}


def test_the_law_of_the_air_is_that_of_the_golden_data():
    case = load("flight-both")[1]
    p = {name: float(value) for name, value in numbers(case.scene)}
    state = (*case.scene.launch.position, *case.scene.launch.velocity)
    push = push_of_air(state, p)

    def rates(_, y):
        a = push(*y[3:])
        return [*y[3:], a[0], a[1], a[2] - p["gravity"]]

    end = float(case.expected.landing.time)
    last = solve_ivp(rates, (0.0, end), state, method="DOP853", rtol=1e-12, atol=1e-12).y[:3, -1]
    # Some steps of 1e-12 of places of 100 m.
    assert last == pytest.approx([float(x) for x in case.expected.landing.position], abs=1e-8)


@pytest.mark.parametrize("simulator", SIMULATORS, ids=lambda simulator: simulator.title)
def test_adapters_are_short(simulator):
    assert wild.adapter_lines(simulator) < 30


@pytest.mark.parametrize(
    ("title", "family", "knob", "error"),
    [
        # Orders of magnitude above what each method leaves, and far below what a wrong sign or a
        # swapped axis would: lift alone bends flights by metres.
        ("MuJoCo", "flight-both", 0.02, 1e-5),
        ("Exudyn", "flight-both", 0.05, 1e-5),
        ("REBOUND", "flight-both", 0.05, 1e-7),
        ("py-ballisticcalc", "flight-drag", 16.0, 1e-2),
        ("pitchphys", "pitch", 1e-8, 1e-6),
    ],
)
def test_an_adapter_flies_golden_scenes(title, family, knob, error):
    simulator = BY_TITLE[title]
    if simulator.version is None:
        pytest.skip(f"{title} is not installed")
    method = simulator.methods[-1]
    cases = [c for c in load(family)[:2] if c.expected.outcome in ("landed", "crossed")]
    judge = Judge(cases, Exact(), partial=True, diagnose=False)
    found = judge.evaluate_function(wild.candidate(simulator, method, knob))
    assert max(map(wild.place_error, found.comparisons)) < error


def test_a_simulator_that_is_not_installed_has_no_version():
    assert replace(SIMULATORS[0], package="no-such-simulator").version is None
