"""One quantity over a family of steps, part by part: means, jumps, verdicts, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.convergence import study
from longball.convergence.family import (
    EPSILON,
    JUMP,
    PHASES,
    TOLERANCE,
    UNDECIDED,
    Observed,
    _jump,
    _Measured,
    _use,
    _verdict,
    observe,
    step_family,
)
from longball.convergence.order import PowerLaw

STEPS = np.array([0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003125])
SECONDS = 2.0


def measured(values, truth=None, phases=1):
    """One quantity of one number, (scene, step, phase), at phases that hardly differ in length."""
    values = np.asarray(values, float)
    return _Measured(
        "value",
        "m",
        STEPS[:, None] * 0.99 ** np.arange(phases),
        values[..., None],
        None if truth is None else np.asarray(truth, float)[:, None],
        SECONDS / STEPS,
    )


def power_law(order=2.0, half=0.05, constant=3.0, first=0, last=5):
    return PowerLaw(order, order - half, order + half, constant, first, last)


# --- steps ----------------------------------------------------------------------------------------


def test_steps_are_sorted_and_counted_once():
    family = step_family([0.1, 0.2, 0.1, 0.4, 0.05, 0.8])
    assert family.tolist() == [0.8, 0.4, 0.2, 0.1, 0.05]
    for bad in (0.0, -0.1, math.inf, math.nan):
        with pytest.raises(ValueError, match="different positive ones are needed"):
            step_family([0.1, 0.2, 0.3, 0.4, 0.5, bad])


def test_an_error_without_truth_is_that_against_the_next_step():
    steps = np.geomspace(0.1, 0.01, 12)  # neighbours that differ by a fifth
    (seen,) = study(lambda h: 7.0 + 3.0 * h**1.7, steps).orders
    errors = [rung.error for rung in seen.rungs]
    assert errors[-1] is None
    assert errors[:-1] == pytest.approx(list(3.0 * steps[:-1] ** 1.7), rel=1e-6)
    assert [rung.scenes for rung in seen.rungs] == [1] * 11 + [0]
    assert (seen.jumps, seen.jump) == (False, 0.0)
    assert {rung.phases for rung in seen.rungs} == {1}


def test_a_number_that_jumps_is_told_by_how_much():
    """Errors of h times 1 and 1/2 by turns: half of the larger one."""
    turn = iter(range(1000))

    def jumping(h):
        return 3.0 + h * (1.0 if next(turn) % 2 == 0 else 0.5)

    (seen,) = study(jumping, np.geomspace(0.1, 0.001, 9), truth=3.0, phases=PHASES).orders
    assert seen.jumps
    assert seen.jump == pytest.approx(0.5, abs=0.01)
    assert "by 50 % of the error" in seen.why
    assert {rung.phases for rung in seen.rungs} == {PHASES}
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


# --- means over phases ----------------------------------------------------------------------------


def test_means_leave_out_what_is_not_there():
    values = np.full((1, 6, 2), [3.0, 5.0])
    values[0, 1, 0] = values[0, 2, 1] = math.nan
    values[0, 3] = math.nan
    one = measured(values, [1.0], phases=2)
    np.testing.assert_array_equal(one.means(True)[0, :, 0], [4.0, 5.0, 3.0, math.nan, 4.0, 4.0])
    np.testing.assert_array_equal(
        one.means(False)[0, :, 0], [3.0, math.nan, 3.0, math.nan, 3.0, 3.0]
    )
    rms = math.sqrt((4 + 16) / 2)
    np.testing.assert_allclose(one.errors(True, 1.0)[0], [rms, 4.0, 2.0, math.nan, rms, rms])
    np.testing.assert_allclose(one.errors(False, 1.0)[0], [2.0, math.nan, 2.0, math.nan, 2.0, 2.0])
    np.testing.assert_allclose(one.levels(False), STEPS, rtol=1e-14)
    np.testing.assert_allclose(one.levels(True), STEPS * math.sqrt(0.99), rtol=1e-14)
    assert one.size == 5.0
    assert measured(np.full((1, 6, 1), math.nan)).size == 0.0


def test_the_change_with_the_phase_is_the_median_of_the_finer_half():
    truth = 1.0
    values = np.full((2, 6, 2), truth)
    values[:, :, 0] += STEPS
    values[0, :, 1] += 0.6 * STEPS
    values[1, :, 1] += 0.8 * STEPS
    values[:, :3, 1] += 7.0  # of the coarser half nothing counts
    smooth = 0.01  # of an error of order 1 at steps that are shorter by that in the next phase
    assert _jump(measured(values, [truth] * 2, phases=2)) == pytest.approx(0.3 - smooth)
    # A change that is larger than the error itself is all of it.
    values[:, :, 1] = truth + 9 * STEPS
    assert _jump(measured(values, [truth] * 2, phases=2)) == pytest.approx(1.0 - smooth)


@pytest.mark.parametrize(("share", "jumps"), [(0.9, False), (1.1, True)])
def test_a_change_below_the_noise_of_rounding_is_none(share, jumps):
    """Four times what independent roundings add up to: ε √n, of n steps."""
    noise = 4 * EPSILON * 8.0 * np.sqrt(SECONDS / STEPS)
    values = np.full((1, 6, 2), 8.0)
    values[0, :, 1] -= share * noise
    found = _jump(measured(values, [8.0], phases=2))
    assert (found > 0.5) is jumps


# --- verdicts -------------------------------------------------------------------------------------


def verdict(errors, law=None, expected=None, truth=(1.0,), wide=None):
    one = measured(np.full((1, 6, 1), 8.0), truth)
    return _verdict(one, np.asarray(errors, float), STEPS, law, wide or law, expected)


BOUND = EPSILON * 8.0 * SECONDS / STEPS


def test_errors_within_all_roundings_are_exact():
    kind, why = verdict(BOUND)
    assert kind == "exact"
    assert f"at most {BOUND.max():.1e} m" in why
    assert verdict([*BOUND[:5], 1.01 * BOUND[5]])[0] != "exact"
    assert verdict([math.nan, *BOUND[1:]])[0] == "exact"


def test_errors_far_above_their_law_have_another_limit():
    law = power_law()
    fitted = np.array([law.error(h) for h in STEPS])
    assert fitted[-1] > BOUND[-1]
    assert verdict(fitted, law, 2.0)[0] == "as expected"
    stuck = fitted.copy()
    stuck[-1] *= 10
    kind, why = verdict(stuck, law, 2.0)
    assert kind == "wrong limit"
    assert f"stays at {stuck[-1]:.2e} m" in why
    assert f"(at most {BOUND[-1]:.0e})" in why
    # Without the truth a limit cannot be wrong.
    assert verdict(stuck, law, 2.0, truth=None)[0] == "as expected"
    stuck[-1] = 1.5 * fitted[-1]
    assert verdict(stuck, law, 2.0)[0] == "as expected"


def test_five_errors_that_stay_have_another_limit_without_a_law():
    assert verdict([0.5] * 6)[0] == "wrong limit"
    assert verdict([math.nan, *[0.5] * 5])[0] == "wrong limit"
    assert verdict([9.0, *[0.5] * 5])[0] == "wrong limit"
    assert verdict([0.5, 0.5, 0.5, 0.5, 9.0, 0.5])[0] == "not resolved"
    assert verdict([math.nan, math.nan, *[0.5] * 4])[0] == "not resolved"


def test_without_a_law_longer_steps_are_advised_if_the_finest_errors_are_rounding():
    for finest, advised in ((1.0, False), (BOUND[-1], True)):
        kind, why = verdict([9.0, 1.0, 7.0, 2.0, 5.0, finest])
        assert kind == "not resolved"
        assert ("try longer steps" in why) is advised


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("share", "kind"), [(0.99, "as expected"), (1.01, "other order")])
def test_an_order_is_held_to_theory_besides_its_interval(sign, share, kind):
    law = power_law(half=0.05)
    errors = [law.error(h) for h in STEPS]
    expected = 2.0 + sign * share * (TOLERANCE + 0.05)
    assert verdict(errors, law, expected)[0] == kind
    # The interval that is reported is the one that counts.
    wide = power_law(half=0.3)
    assert verdict(errors, law, expected, wide=wide)[0] == "as expected"


@pytest.mark.parametrize(("share", "kind"), [(0.99, "as expected"), (1.01, "not resolved")])
def test_a_wide_interval_does_not_tell_an_order_from_the_next(share, kind):
    law = power_law(half=share * UNDECIDED / 2)
    found, why = verdict([law.error(h) for h in STEPS], law, 2.0)
    assert found == kind
    assert why.startswith(f"order 2.000 ({law.low:.3f} to {law.high:.3f})")


def test_what_a_step_is_used_for():
    law = power_law(first=1, last=3)
    uses = [_use(level, 1.0, law) for level in range(5)]
    assert uses == ["pre-asymptotic", "fitted", "fitted", "fitted", "floor"]
    assert _use(2, math.nan, law) == "no error"
    assert _use(2, 1.0, None) == "no range"
