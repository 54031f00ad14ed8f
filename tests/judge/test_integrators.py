"""Integrators in fixed steps: their orders, their steps written out, last steps, long flights."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from longball.engines.verlet import TREATMENTS, Treatment
from longball.judge.diagnosis import integrators
from longball.judge.diagnosis.chain import t
from longball.judge.diagnosis.expression import S, constant
from longball.judge.diagnosis.integrators import (
    EXACT,
    INTEGRATORS,
    VERLET,
    Integrator,
    Way,
    slips,
    steps,
    straight,
    together,
)
from longball.judge.diagnosis.residual import follow, launched, specialised_to, stepped, values
from tests.judge.material import known, truth

# A motion along x = sin t, under an acceleration of the place, the velocity and the time.
ONE = np.zeros((7, 1))
ONE[3] = 1.0


def pull(x: Any, v: Any, t: Any) -> Any:
    return -np.sin(t) + 0.7 * (v - np.cos(t)) + 0.3 * (v**2 - np.cos(t) ** 2) + x - np.sin(t)


def rates(y: Any, t: Any, start: Any = None) -> Any:
    slope = np.zeros_like(y)
    slope[:3], slope[3], slope[6] = y[3:6], pull(y[0], y[3], t), abs(y[3])
    return slope


def flown(step: Any, h: float, count: int) -> Any:
    y, left = ONE, None
    for k in range(count):
        y, left = step(rates, y, k * h, h, left, h)
    return y[[0, 3], 0]


@pytest.mark.parametrize("one", INTEGRATORS, ids=lambda one: one.words)
def test_the_order_of_an_integrator(one: Integrator):
    end = np.array([math.sin(1.0), math.cos(1.0)])
    coarse, fine = (abs(flown(one.step, 1 / n, n) - end).max() for n in (64, 128))
    order = 4 if one.frozen else one.order  # a frozen law is not seen here
    assert math.log2(coarse / fine) == pytest.approx(order, abs=0.1)


def verlet(ahead: float, implicit: bool, carries: bool) -> Callable[..., Any]:
    """Velocity Verlet whose new force takes the velocity that Euler's method predicts."""

    def step(x: float, v: float, t: float, h: float, left: Any) -> Any:
        old = left if left is not None and carries else pull(x, v, t)
        new, guess = x + h * v + h * h / 2 * old, v + ahead * h * old
        force = pull(new, guess, t + h)
        for _ in range(20 if implicit else 0):
            force = pull(new, v + h / 2 * (old + force), t + h)
        return new, v + h / 2 * (old + force), force

    return step


def adams(parabola: bool) -> Callable[..., Any]:
    def step(x: float, v: float, t: float, h: float, left: Any) -> Any:
        now = pull(x, v, t)
        a, u = left or (now, v)
        at = x + h * v + h * h / 2 * now if parabola else x + h * (3 * v - u) / 2
        return at, v + h * (3 * now - a) / 2, (now, v)

    return step


def leapfrog(x: float, v: float, t: float, h: float, left: Any) -> Any:
    new = v + h * pull(x + h / 2 * v, v, t + h / 2)
    return x + h / 2 * (v + new), new, None


def moved(share: float) -> Callable[..., Any]:
    """RK4 whose place moves at the first velocity plus a share of its change."""

    def step(x: float, v: float, t: float, h: float, left: Any) -> Any:
        a = pull(x, v, t)
        b = pull(x + h / 2 * v, v + h / 2 * a, t + h / 2)
        c = pull(x + h / 2 * (v + h / 2 * a), v + h / 2 * b, t + h / 2)
        d = pull(x + h * (v + h / 2 * b), v + h * c, t + h)
        new = v + h / 6 * (a + 2 * b + 2 * c + d)
        return x + h * ((1 - share) * v + share * new), new, None

    return step


def weighted(*weights: int) -> Callable[..., Any]:
    """RK4 with other weights of its four slopes."""

    def step(x: float, v: float, t: float, h: float, left: Any) -> Any:
        at, slopes = (x, v, t), []
        for node in (0.5, 0.5, 1.0, 0.0):
            slopes.append((at[1], pull(*at)))
            at = (x + node * h * slopes[-1][0], v + node * h * slopes[-1][1], t + node * h)
        w = np.array(weights) / sum(weights)
        dx, dv = w @ np.array(slopes)
        return x + h * dx, v + h * dv, None

    return step


# Steps of x and v, written out.
PLAIN: dict[str, Callable[..., Any]] = {
    "explicit Euler": lambda x, v, t, h, _: (x + h * v, v + h * pull(x, v, t), None),
    "semi-implicit Euler, velocity first":
        lambda x, v, t, h, _: (x + h * (n := v + h * pull(x, v, t)), n, None),
    "semi-implicit Euler, position first":
        lambda x, v, t, h, _: (n := x + h * v, v + h * pull(n, v, t + h), None),
    "constant acceleration over each step":
        lambda x, v, t, h, _: (x + h * v + h * h / 2 * (a := pull(x, v, t)), v + h * a, None),
    "leapfrog with the force at the old velocity": leapfrog,
    "the Adams-Bashforth method of order 2": adams(False),
    "the Adams-Bashforth method of order 2 for the velocity": adams(True),
    "RK4 whose position moves with the velocity at the step's start": moved(0.0),
    "RK4 whose position moves with the velocity at the step's end": moved(1.0),
    "RK4 whose position moves with the mean of the velocities at the step's ends": moved(0.5),
    "RK4 with the weights (1, 1, 1, 1)": weighted(1, 1, 1, 1),
    "RK4 with the weights (2, 1, 1, 2)": weighted(2, 1, 1, 2),
    "RK4 with the weights (1, 3, 3, 1)": weighted(1, 3, 3, 1),
    **{one.words: verlet(*how) for how, one in VERLET.items()},
}  # fmt: skip


@pytest.mark.parametrize("words", PLAIN)
def test_an_integrator_is_its_step_written_out(words: str):
    (one,) = (one for one in INTEGRATORS if one.words == words)
    x, v, left, h = 0.0, 1.0, None, 0.05
    for k in range(4):
        x, v, left = PLAIN[words](x, v, k * h, h, left)
    assert flown(one.step, h, 4) == pytest.approx([x, v], rel=1e-12)


def runge_kutta(nodes: Any, weights: Any, divisor: float) -> Callable[..., Any]:
    def step(f: Any, y: Any, t: Any, h: Any, left: Any, whole: Any) -> Any:
        slopes = [f(y, t)]
        for node in nodes:
            slopes.append(f(y + node * h * slopes[-1], t + node * h))
        return y + h / divisor * sum(w * k for w, k in zip(weights, slopes, strict=True)), None

    return step


def test_wrong_coefficients_of_a_program_are_among_the_slips():
    half, sums = (0.5, 0.5, 1.0), (1, 2, 2, 1)
    wrong = [
        runge_kutta((0.5, -0.5, 1.0), sums, 6), runge_kutta((0.5, 0.5, 0.0), sums, 6),
        runge_kutta((0.5, 1.0, 1.0), sums, 6), runge_kutta((0.5, 0.5, 0.5), sums, 6),
        runge_kutta(half, (1, 1, 2, 1), 6), runge_kutta(half, (1, 2, 0, 1), 6),
        runge_kutta(half, (1, 2, 1, 2), 6),
        runge_kutta(half, sums, 5), runge_kutta(half, sums, -6), runge_kutta((0.25,), (0, 1), 1),
        runge_kutta((1.0,), (1, 1), 1), runge_kutta((), (1,), 2),
    ]  # fmt: skip
    every = [flown(one.step, 0.1, 3) for one in slips()]
    for mistaken in wrong:
        end = flown(mistaken, 0.1, 3)
        assert any(np.allclose(end, other, rtol=1e-13, atol=1e-13) for other in every)
    # The order is unknown if they lead to the path, and 0 if they do not.
    end = [math.sin(1), math.cos(1)]
    with np.errstate(all="ignore"):
        for one in slips()[::7]:
            near = abs(flown(one.step, 0.01, 100) - end).max() < 0.04
            assert near == (one.order is None), one.words


def test_integrators_of_one_kind_fly_together():
    some = [one for one in INTEGRATORS if one.like == INTEGRATORS[0].like]
    kinds = {one.like for one in INTEGRATORS}
    assert 1 < len(kinds) < len(INTEGRATORS)
    for like in kinds:
        some = [one for one in INTEGRATORS if one.like == like]
        every = together(some, 2)
        y = np.repeat(ONE, 2 * len(some), axis=1)
        new, _ = every.step(rates, y, 0.0, 0.1, None, 0.1)
        for i, one in enumerate(some):
            assert np.allclose(
                new[[0, 3], 2 * i + 1], flown(one.step, 0.1, 1), rtol=1e-14, atol=1e-15
            )


# --- flights --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drives() -> Any:
    """The flights of a few scenes, and their columns."""
    data = truth(known("flight-both")[:40:5])
    chain = specialised_to(data)
    (stage,) = (stage for stage in chain if stage.kind == "flight")
    columns, _ = follow(chain, data)
    return stage, stage.with_spin(columns)


RK4 = next(one for one in INTEGRATORS if one.words == "RK4")
EULER = INTEGRATORS[0]


def rows(stage: Any, found: Any) -> Any:
    return np.concatenate([found[q] for q in stage.quantities[:2]])


@pytest.mark.parametrize("last", ["shorter", "chord", "straight"])
def test_the_last_step_of_a_flight(drives: Any, last: str):
    """Under a law that grows with the time."""
    stage, columns = drives
    stage = stage.edited(stage.roots["law"], t * (1.0 / constant(1.0, S)) * stage.roots["law"])
    h, balls = 0.03, launched(stage, columns)
    counts = np.floor(balls.duration / h).astype(int)
    y, _ = stepped(balls, RK4.step, h, counts)
    rest = balls.duration - counts * h
    beyond = RK4.step(balls.rates, y, counts * h, h, None, h)[0]
    expected = {
        "shorter": RK4.step(balls.rates, y, counts * h, rest, None, h)[0],
        "chord": y + rest / h * (beyond - y),
        "straight": np.concatenate([y[:3] + rest * y[3:6], y[3:6]]),
    }[last]  # fmt: skip
    way = Way(RK4, h, chord=last == "chord")
    found, doubt = (straight(way) if last == "straight" else way)(stage, columns)
    assert rows(stage, found) == pytest.approx(expected[:6], rel=1e-12)
    assert not rows(stage, doubt).any()


def test_a_chord_of_the_exact_path(drives: Any):
    stage, columns = drives
    h, balls = 0.1, launched(stage, columns)
    counts = np.floor(balls.duration / h)

    def at(time: Any) -> Any:
        return rows(stage, values(stage, {**columns, "hang_time": time}))

    share = balls.duration / h - counts
    expected = (1 - share) * at(counts * h) + share * at((counts + 1) * h)
    found, _ = steps(stage, columns, EXACT, h, True)
    assert rows(stage, found) == pytest.approx(expected, rel=1e-9)


# It does not lead to the path.
SLIP = next(one for one in slips() if one.order == 0 and one.words.startswith(EULER.words))
VERLETS = [VERLET[Treatment(0.5, False, carries)] for carries in (False, True)]


@pytest.mark.parametrize("one", [EULER, *VERLETS, SLIP], ids=lambda one: one.words)
def test_many_steps_are_interpolated_from_few(drives: Any, one: Integrator, monkeypatch: Any):
    stage, columns = drives
    monkeypatch.setattr(integrators, "DIRECT", 10**6)
    directly, none = steps(stage, columns, one, 0.002, False)
    monkeypatch.setattr(integrators, "DIRECT", 100)
    found, doubt = steps(stage, columns, one, 0.002, False)
    off = abs(rows(stage, found) - rows(stage, directly))
    error = abs(rows(stage, directly) - rows(stage, values(stage, columns)))
    assert not rows(stage, none).any()
    assert off.max() < 1e-3 * error.max()
    assert (off <= 3 * rows(stage, doubt) + 1e-12 * abs(rows(stage, found)).max()).all()


def test_treatments_of_the_paper_have_integrators():
    assert {*TREATMENTS.values()} <= VERLET.keys()
