"""Simulators in the wild: adapters of what is installed, the law of the air, the page."""

import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from scipy.integrate import solve_ivp

from analysis import wild
from analysis.wild.air import push_of_air
from analysis.wild.simulators import SIMULATORS, Simulator
from analysis.writing import Report
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


@pytest.mark.nightly
def test_the_page_tells_of_a_simulator_that_flies_in_a_vacuum(tmp_path, monkeypatch):
    def fly(state, p, word, step):
        x, y, z, vx, vy, vz = state
        points = [
            [t, x + vx * t, y + vy * t, z + vz * t - p["gravity"] * t * t / 2]
            for t in (step * i for i in range(2000))
        ]
        return points[: 1 + next(i for i, at in enumerate(points) if at[3] < p["ground.height"])]

    simulator = BY_TITLE["freefall"]
    method = replace(simulator.methods[0], usual=0.01, steps=(0.05, 0.02, 3))
    monkeypatch.setitem(sys.modules, simulator.module, SimpleNamespace(fly=fly))
    monkeypatch.setattr(Simulator, "version", property(lambda self: "1.0"))
    monkeypatch.setattr(wild, "SIMULATORS", [replace(simulator, methods=(method,))])
    monkeypatch.setattr(wild, "SCENES", 3)
    page = wild.run(Report(tmp_path), full=False)
    assert "leaves out" in page  # the drag, or what it is made of
    assert "| freefall, leapfrog | 2 |" in page
    assert (tmp_path / "figures" / "wild_orders.png").exists()
