"""Steps that a few runs choose."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.convergence import Sample, chosen_steps, converge
from longball.model.scene import FlightScene, Launch

SCENES = [
    FlightScene(id=str(i), launch=Launch(position=(0.0, 0.0, 1.0), velocity=(30.0 + i, 0.0, 20.0)))
    for i in range(6)
]
TIME, DISTANCE = 4.5, 110.0  # s, m, of a flight like these
# Errors of the distance at a step of 1 s, m; by order about those of explicit Runge-Kutta methods.
SIZES = {1: 11.0, 2: 0.6, 3: 0.04, 4: 0.012, 8: 1e-6}


def method(order: int, floor: float = 4e-16):
    """Return a method whose results are off by C h^p and rounding, and the steps that it took."""
    taken: list[float] = []
    rng = np.random.default_rng(1)

    def run(step: float) -> list[Sample]:
        taken.append(step)
        results = []
        for i, scene in enumerate(SCENES):
            off = SIZES[order] * (1 + 0.3 * i) * step**order if order else 0.0
            rounding = 1 + floor * math.sqrt(TIME / step) * rng.uniform(-1, 1)
            distance = DISTANCE * rounding + off
            values = {
                "landing.time": (TIME * rounding + off / 20,),
                "landing.position": (distance, 0.0, 0.0),
                "landing.distance": (distance,),
            }
            results.append(Sample(scene.id, "landed", values))
        return results

    return run, taken


TRUTH = [
    Sample(scene.id, "landed", {"landing.time": (TIME,), "landing.position": (DISTANCE, 0.0, 0.0),
                                "landing.distance": (DISTANCE,)})
    for scene in SCENES
]  # fmt: skip


@pytest.mark.parametrize("order", [1, 2, 3, 4, 8])
def test_the_order_of_a_right_method_shows_at_the_steps_chosen(order: int):
    run, taken = method(order)
    steps = chosen_steps(run, SCENES)
    assert len(taken) == len(set(taken)) <= 11
    report = converge(run, SCENES, steps, TRUTH, expected=order)
    assert [one.verdict for one in report.orders] == ["as expected"] * 3
    assert not any(one.jumps for one in report.orders)


def test_the_higher_the_order_the_longer_the_steps():
    finest = [min(chosen_steps(method(order)[0], SCENES)) for order in (2, 4, 8)]
    assert finest == sorted(finest)
    assert finest[0] < finest[-1] / 10


def test_a_slow_method_is_not_asked_for_short_steps(monkeypatch):
    """Runs that take 1 s, and 9 ms over the step in seconds."""
    run, taken = method(1)
    clock = 0.0

    def slow(step: float) -> list[Sample]:
        nonlocal clock
        clock += 1.0 + 0.009 / step
        return run(step)

    monkeypatch.setattr("longball.convergence.probe.time.monotonic", lambda: clock)
    steps = chosen_steps(slow, SCENES)
    # A run may take 0.4 s and twice the 1.09 s of the first: at 0.1 / 16 s it takes 2.44 s.
    assert min(taken) == pytest.approx(0.1 / 32)
    assert steps == pytest.approx(np.geomspace(0.1, 0.1 / 16, 9))


def test_a_method_without_an_error_is_exact_at_the_steps_chosen():
    run, _ = method(0)
    steps = chosen_steps(run, SCENES)
    assert {one.verdict for one in converge(run, SCENES, steps, TRUTH).orders} == {"exact"}


def test_a_program_that_answers_nothing_gets_steps_all_the_same():
    assert len(chosen_steps(lambda step: [], SCENES)) == 9
