"""Taylor's method inside scipy.integrate.solve_ivp, for anybody's traced law."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longball.engines import taylor
from longball.engines.taylor import Taylor, expand, right_hand_side
from longball.model import trace
from longball.model.law import Law, law_with
from tests.engines.test_ivp import fly, ground

BALL = law_with({"drag": 0.0075, "lift": 0.00375, "gravity": 9.8})
START = [0.0, 1.0, 35.0, 30.0]


def spring():
    """A spring with all that a formula may have: products, a quotient, exp and log."""

    def rates(at, moving, stiffness):
        push = trace.exp(-at) / (2 + at * at)
        return moving, -stiffness * at - push + trace.log(3 + at * at)

    return Law(trace.trace(rates, ("at", "moving"), ("stiffness",)), {"stiffness": 4.0}, ())


def height(_, y):
    return y[1]


height.terminal = True
height.direction = -1


def by_taylor(law, span, start, **options):
    return solve_ivp(right_hand_side(law), span, start, method=Taylor, law=law, **options)


@pytest.mark.parametrize(("law", "start"), [(BALL, START), (spring(), [1.0, 0.5])])
def test_it_agrees_with_dop853(law, start):
    found = by_taylor(law, (0, 6), start, dense_output=True)
    other = solve_ivp(
        right_hand_side(law), (0, 6), start, "DOP853", rtol=1e-13, atol=1e-13, dense_output=True
    )
    assert found.success
    assert found.y[:, -1] == pytest.approx(other.y[:, -1], abs=1e-10)
    times = np.linspace(0, 6, 40)
    np.testing.assert_allclose(found.sol(times), other.sol(times), atol=1e-8)
    assert len(found.t) < len(other.t) / 2


def test_laws_of_which_every_rate_is_a_variable():
    growth = Law(trace.trace(lambda a, b: (b, a), ("a", "b"), ()), {}, ())
    found = by_taylor(growth, (0, 3), [1.0, 1.0])
    assert found.y[:, -1] == pytest.approx([math.exp(3)] * 2, rel=1e-15)


def test_it_has_few_steps_and_lands_exactly():
    found = by_taylor(BALL, (0, 60), START, events=height)
    assert len(found.t) < 12
    assert found.status == 1
    # The time is a double; so the height is as good as zero.
    assert abs(found.y[1, -1]) <= abs(found.y[3, -1]) * np.spacing(found.t[-1])
    assert found.t[-1] == fly(START, BALL, ground()).time


def test_one_comes_back_to_where_one_started():
    there = by_taylor(BALL, (0, 6), START)
    back = by_taylor(BALL, (6, 0), there.y[:, -1])
    assert back.y[:, -1] == pytest.approx(START, abs=1e-12)


def test_times_may_be_asked_for_one_by_one_or_all_at_once():
    found = by_taylor(BALL, (0, 6), START, dense_output=True, t_eval=[0.0, 1.5, 6.0])
    assert found.y[:, 1] == pytest.approx(found.sol(1.5), abs=1e-14)
    assert found.sol([0.5, 1.5]).shape == (4, 2)
    assert found.sol(np.array(1.5)).tolist() == found.sol(1.5).tolist()


def test_steps_can_be_limited_and_series_shortened():
    full = by_taylor(BALL, (0, 6), START)
    short = by_taylor(BALL, (0, 6), START, max_step=0.25)
    rough = by_taylor(BALL, (0, 6), START, order=8, rtol=1e-9)
    assert np.diff(short.t).max() <= 0.25
    assert short.y[:, -1] == pytest.approx(full.y[:, -1], abs=1e-13)
    assert 1e-13 < abs(rough.y[0, -1] - full.y[0, -1]) < 1e-6


@pytest.mark.parametrize(("span", "far"), [((0, 8), 110.0), ((8, 0), 30.0)])
def test_a_step_goes_on_to_the_first_of_the_events(span, far):
    """The same series: the same solution, of fewer steps."""
    start = START if span[0] == 0 else by_taylor(BALL, (0, 8), START).y[:, -1]
    events = [lambda t, y: t - 100.0, lambda t, y: y[0] - far]
    events[1].terminal = True
    options = {"events": events, "dense_output": True}
    many = by_taylor(BALL, span, start, **options)
    found = by_taylor(BALL, span, start, until=events, **options)
    assert (len(found.t), found.status) == (2, 1)
    assert len(many.t) > 3
    assert found.t[-1] == pytest.approx(many.t[-1], rel=1e-15)
    times = np.linspace(found.t[0], found.t[-1], 50)
    assert found.sol(times).tolist() == many.sol(times).tolist()


def test_options_of_other_methods_are_named_in_a_warning():
    with pytest.warns(UserWarning, match="Taylor does not take atol"):
        by_taylor(BALL, (0, 1), START, atol=1e-9)


def test_the_right_hand_side_is_taken_one_state_at_a_time_unless_it_is_said():
    """As by all solvers of scipy."""
    solver = Taylor(lambda t, y: [*y.shape, y[1]], 0.0, [1.0, 0.5], 1.0, law=spring())
    assert solver.fun(0.0, np.array([1.0, 0.5])).tolist() == [2.0, 0.5]


def test_from_rest():
    found = by_taylor(BALL, (0, 1), [0.0, 50.0, 0.0, 0.0])
    other = solve_ivp(
        right_hand_side(BALL), (0, 1), [0.0, 50.0, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-13
    )
    assert found.y[:, -1] == pytest.approx(other.y[:, -1], abs=1e-10)


def test_what_is_too_large_for_doubles_fails_as_scipy_has_it():
    found = by_taylor(BALL, (0, 1), [0.0, 1.0, 1e200, 0.0])
    assert (found.success, found.status) == (False, -1)
    assert "beyond the range" in found.message


def test_too_many_steps_shorter_than_the_spacing_of_times_fail_as_scipy_has_it(monkeypatch):
    monkeypatch.setattr(taylor, "_MOST_SHORT_STEPS", 3)
    found = by_taylor(BALL, (1.0, 2.0), [0.0, 1.0, 1e-30, 0.0])
    assert (found.success, found.status) == (False, -1)
    assert found.message == Taylor.TOO_SMALL_STEP
    assert found.t.tolist() == [1.0]


@pytest.mark.parametrize("speed", [1e-3, 1e-9, 1e-15, 1e-30, 1e-120])
def test_a_ball_that_all_but_rests(speed):
    """Its coefficients grow like the powers of 1/V, beyond the range of doubles."""
    x, reach = expand(BALL, np.array([0.0, 1.0, speed, 0.0]))
    assert 0 < reach <= 0.51 * speed / 9.8
    assert np.isfinite(x).all()


def test_names_that_the_printed_code_uses_are_refused():
    law = Law(trace.trace(lambda u, k: (k * u * u,), ("u",), ("k",)), {"k": 1.0}, ())
    with pytest.raises(ValueError, match="cannot be called k"):
        expand(law, np.array([1.0]))
