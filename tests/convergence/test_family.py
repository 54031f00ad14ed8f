"""One quantity over a family of steps: errors, jumps, limits, and the use of each step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.convergence import study
from longball.convergence.family import (
    JUMP,
    PHASES,
    Observed,
    observe,
    step_family,
)
from longball.convergence.order import richardson

STEPS = np.array([0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003125])


def test_steps_are_sorted_and_counted_once():
    family = step_family([0.1, 0.2, 0.1, 0.4, 0.05, 0.8])
    assert family.tolist() == [0.8, 0.4, 0.2, 0.1, 0.05]
    for bad in (0.0, -0.1, math.inf, math.nan):
        with pytest.raises(ValueError, match="different positive ones are needed"):
            step_family([0.1, 0.2, 0.3, 0.4, 0.5, bad])


def test_an_error_without_truth_is_that_against_the_next_step():
    steps = np.geomspace(0.1, 0.01, 12)  # neighbours that differ by a fifth
    report = study(lambda h: 7.0 + 3.0 * h**1.7, steps, expected=1.7)
    (seen,), (limit,) = report.orders, report.limits
    assert (seen.quantity, seen.verdict, report.passed) == ("value", "as expected", True)
    assert (seen.order, seen.constant) == pytest.approx((1.7, 3.0), rel=1e-6)
    assert limit.value[0] == pytest.approx(7.0, abs=1e-12)
    errors = [rung.error for rung in seen.rungs]
    assert errors[-1] is None
    assert errors[:-1] == pytest.approx(list(3.0 * steps[:-1] ** 1.7), rel=1e-6)
    assert [rung.scenes for rung in seen.rungs] == [1] * 11 + [0]
    assert (seen.jumps, seen.jump) == (False, 0.0)
    assert {rung.phases for rung in seen.rungs} == {1}


@pytest.mark.parametrize("phases", [2, PHASES])
def test_a_number_that_jumps_is_told_by_how_much(phases):
    """Errors of h times 1 and 1/2 by turns: half of the larger one."""
    turn = iter(range(1000))

    def jumping(h):
        return 3.0 + h * (1.0 if next(turn) % 2 == 0 else 0.5)

    (seen,) = study(jumping, np.geomspace(0.1, 0.001, 9), truth=3.0, phases=phases).orders
    assert seen.jumps
    assert seen.jump == pytest.approx(0.5, abs=0.01)
    assert "by 50 % of the error" in seen.why
    assert {rung.phases for rung in seen.rungs} == {phases}
    rms = math.sqrt((1 + 0.25) / 2)
    for rung in seen.rungs:
        assert rung.error == pytest.approx(rms * rung.step, rel=0.02)


@pytest.mark.parametrize(("share", "evaluations"), [(0.9, 2), (1.1, PHASES)])
def test_a_jump_beyond_the_limit_takes_all_phases(share, evaluations):
    steps, done = np.geomspace(0.1, 0.001, 9), []

    def jumping(h):
        level = int(np.abs(np.log(steps / h)).argmin())
        return 3.0 + h * (1.0 if h == steps[level] else 1.0 - share * JUMP)

    def progress(count, planned):
        done.append((count, planned))

    def evaluate(h):
        return [one_number(jumping(h))]

    (order,), _ = observe(
        evaluate, steps, [one_number(3.0)], scenes=["a"], expected=1.0, first=1.0, last=1.0,
        phases=PHASES, progress=progress,
    )  # fmt: skip
    assert done[-1] == (9 * evaluations, 9 * evaluations)
    assert [count for count, _ in done] == list(range(1, 9 * evaluations + 1))
    assert order.jumps is (evaluations == PHASES)


def test_the_limit_of_what_jumps_is_that_of_its_means():
    """Errors whose mean over the phases is h; the first is 1.5 h and h/2 by turns."""
    steps = np.geomspace(0.1, 0.001, 9)

    def evaluate(h):
        level = int(np.abs(np.log(steps / h)).argmin())
        aside = 0.5 if level % 2 == 0 else -0.5
        share = 1.0 + aside if h == steps[level] else 1.0 - aside / (PHASES - 1)
        return [one_number(3.0 + h * share)]

    (order,), (limit,) = observe(
        evaluate, steps, [one_number(3.0)], scenes=["a"], expected=1.0, first=1e6, last=1.0,
        phases=PHASES, progress=lambda done, planned: None,
    )  # fmt: skip
    assert order.jumps
    # Steps of other phases are shorter by 1e-7 of themselves; one phase alone is off by steps[-1].
    assert limit.value[0] == pytest.approx(3.0, abs=1e-6 * steps[-1])
    assert limit.off == abs(limit.value[0] - 3.0)


def one_number(value):
    return Observed("value", "m", np.array([[value]]))


def test_what_is_zero_everywhere_has_no_order():
    assert study(lambda h: [0.0, h], STEPS, truth=[0.0, 0.0]).orders[0].quantity == "value[1]"
    assert study(lambda h: 0.0, STEPS, truth=0.0).orders == ()
    (exact,) = study(lambda h: 3.0, STEPS, truth=3.0, phases=PHASES).orders
    assert (exact.verdict, exact.jump) == ("exact", 0.0)


def test_a_step_is_used_for_what_its_error_tells():
    steps = np.geomspace(0.1, 1e-4, 16)
    errors = steps**2 * (1 + (steps / 0.01) ** 2)
    report = study(lambda h: h**2 * (1 + (h / 0.01) ** 2), steps, truth=0.0)
    (seen,), (limit,) = report.orders, report.limits
    value, error = richardson(steps, errors[:, None], seen.order)
    assert (*limit.value, limit.error) == pytest.approx((*value, error), rel=1e-9, abs=0)
    assert seen.order == pytest.approx(2, abs=0.1)
    uses = [rung.use for rung in seen.rungs]
    assert all(step < 0.02 for step, use in zip(steps, uses, strict=True) if use == "fitted")
    assert (uses[0], uses[-1], {*uses}) == (
        "pre-asymptotic",
        "fitted",
        {"pre-asymptotic", "fitted"},
    )
