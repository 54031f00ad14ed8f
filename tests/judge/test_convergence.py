"""Observed orders of made-up implementations, whose errors are known."""

import json
import math

import jsonschema
import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.verlet import Verlet
from longball.judge.convergence import converge, phase_step, save_convergence
from longball.judge.convergence_report import ConvergenceReport
from longball.judge.order import (
    errors_without_truth,
    fit_power_law,
    richardson,
    typical,
)
from longball.model.result import Landing, Result
from longball.model.scene import FlightScene, Launch

UNEVEN = np.array([0.1, 0.071, 0.033, 0.02, 0.0131, 0.0057, 0.0031, 0.0012, 0.0007, 0.0003])
LADDER = np.geomspace(0.05, 1e-4, 14)
SCENES = [
    FlightScene(id=f"v{v}", launch=Launch(position=(0.0, 0.0, 1.0), velocity=(v, 0.0, 20.0)))
    for v in (20.0, 30.0, 35.0)
]


# ---- numbers in, numbers out ---------------------------------------------------------------------


@pytest.mark.parametrize("order", [0.5, 1, 2, 4])
def test_a_power_law_is_found_with_its_constant(order):
    law = fit_power_law(UNEVEN, 3.0 * UNEVEN**order)
    assert law.order == pytest.approx(order, abs=1e-12)
    assert law.constant == pytest.approx(3.0, rel=1e-9)
    assert (law.first, law.last) == (0, len(UNEVEN) - 1)


def test_steps_before_the_asymptotic_range_are_left_out():
    steps = np.geomspace(0.1, 1e-4, 16)
    law = fit_power_law(steps, steps**2 * (1 + (steps / 0.01) ** 2))
    assert law.order == pytest.approx(2, abs=0.1)
    assert steps[law.first] < 0.02
    assert law.last == 15


def test_a_rounding_floor_is_left_out():
    steps = np.geomspace(0.1, 1e-6, 21)
    noise = 1e-9 * np.random.default_rng(1).uniform(0.1, 1.0, 21)
    law = fit_power_law(steps, steps**2 + noise)
    assert law.order == pytest.approx(2, abs=0.05)
    assert steps[law.last] > 2e-5


def test_a_floor_that_happens_to_fall_over_its_last_steps_is_a_floor():
    steps = np.geomspace(0.05, 5e-7, 21)
    scatter = np.exp(0.06 * np.random.default_rng(5).standard_normal(21))
    errors = 2 * steps**2 * scatter
    errors[-3:] = 1.0e-11, 8.3e-12, 4.0e-12  # seen in a run; the law would give 1e-12 and less
    law = fit_power_law(steps, errors)
    assert law.order == pytest.approx(2, abs=0.05)
    assert law.last == 17


def test_a_straight_stretch_above_a_range_that_is_less_clean_is_not_taken():
    """Order 2 from 0.1 to 0.01 to the eye, and order 1 in the end with a scatter of 10 %."""
    steps = np.geomspace(0.1, 1e-5, 21)
    scatter = np.where(steps < 0.01, 0.1, 0.0) * np.random.default_rng(4).standard_normal(21)
    law = fit_power_law(steps, (steps**2 + 1e-3 * steps) * np.exp(scatter))
    assert law.order == pytest.approx(1, abs=0.2)
    assert steps[law.first] < 0.005


def test_the_interval_holds_the_order_nineteen_times_in_twenty():
    random, held = np.random.default_rng(2), 0
    for _ in range(400):
        errors = UNEVEN**1.5 * np.exp(0.05 * random.standard_normal(len(UNEVEN)))
        law = fit_power_law(UNEVEN, errors)
        held += law.low <= 1.5 <= law.high
    # 380 of 400 for a range fixed beforehand; choosing it by its scatter costs a little.
    assert 352 <= held <= 396


@pytest.mark.parametrize(
    "errors",
    [
        np.full(10, 1e-3),
        1 / UNEVEN,
        np.exp(np.random.default_rng(3).uniform(-9, 0, 10)),
        np.where(np.arange(10) < 4, UNEVEN, np.nan),
    ],
    ids=["constant", "growing", "noise", "too few"],
)
def test_no_range_where_there_is_none(errors):
    assert fit_power_law(UNEVEN, errors) is None


def test_a_typical_error_is_not_moved_by_scenes_that_lack_steps():
    """A large scene that is only there for fine steps does not lift them."""
    steps = np.geomspace(0.1, 1e-3, 10)
    errors = np.array([1.0, 2.0, 0.5, 1000.0, 700.0])[:, None] * steps
    errors[3:, :5] = np.nan
    seen = typical(errors)
    assert seen / seen[0] == pytest.approx(steps / steps[0], rel=1e-4)


def test_a_typical_error_is_not_moved_by_one_that_changes_its_sign():
    steps = np.geomspace(0.1, 1e-3, 10)
    errors = np.array([1.0, 2.0, 0.5])[:, None] * steps
    errors[1] = np.abs(errors[1] - 0.02)
    seen = typical(errors)
    assert seen / seen[0] == pytest.approx(steps / steps[0], rel=1e-4)


def test_differences_imply_the_errors():
    values = 7.0 + np.array([3.0, -1.0]) * UNEVEN[:, None] ** 1.7
    implied = errors_without_truth(UNEVEN, values, 1.7)
    assert implied[:-1] == pytest.approx(math.sqrt(10) * UNEVEN[:-1] ** 1.7, rel=1e-9)
    assert math.isnan(implied[-1])


def test_extrapolation_is_exact_on_a_power_law_and_bounds_what_comes_after():
    values = 7.0 + 3.0 * UNEVEN[:, None] ** 2
    value, error = richardson(UNEVEN, values, 2.0)
    assert value == pytest.approx([7.0], abs=1e-13)
    assert error < 1e-13
    value, error = richardson(UNEVEN, values + UNEVEN[:, None] ** 3, 2.0)
    assert abs(value[0] - 7.0) < error < 1e-6
    assert richardson(UNEVEN[:2], values[:2], 2.0) is None


# ---- implementations -----------------------------------------------------------------------------


def landed(scene, distance):
    return Result(
        id=scene.id,
        outcome="landed",
        landing=Landing(
            time=4.3,
            hang_time=4.3,
            position=(distance, 0.0, 0.0),
            velocity=(20.0, 0.0, -20.0),
            distance=distance,
        ),
    )


def implementation(error):
    """Return one whose distance is 3 v + error(step, v), and its truth."""
    speeds = {scene.id: scene.launch.velocity[0] for scene in SCENES}

    def run(step):
        return [landed(s, 3 * speeds[s.id] + error(step, speeds[s.id])) for s in SCENES]

    return run, [landed(s, 3 * speeds[s.id]) for s in SCENES]


def distance_of(report):
    return next(order for order in report.orders if order.quantity == "distance")


@pytest.mark.parametrize("with_truth", [True, False])
def test_an_order_is_observed_and_judged(with_truth):
    run, truth = implementation(lambda h, v: v * h**2)
    report = converge(run, SCENES, LADDER, truth if with_truth else None, 2)
    seen = distance_of(report)
    assert report.against_truth is with_truth
    assert seen.verdict == "as expected"
    assert seen.low <= 2 + 1e-9
    assert seen.high >= 2 - 1e-9
    assert seen.constant == pytest.approx(30.0, rel=0.01)
    assert not seen.jumps
    assert {rung.use for rung in seen.rungs} <= {"fitted", "no error"}
    for limit in report.limits:
        if limit.quantity == "distance":
            assert limit.value[0] == pytest.approx(3 * float(limit.scene[1:]), abs=1e-9)


def test_another_order_than_expected_fails():
    run, truth = implementation(lambda h, v: v * h)
    report = converge(run, SCENES, LADDER, truth, {"distance": 2})
    assert distance_of(report).verdict == "other order"
    assert not report.passed
    assert next(o for o in report.orders if o.quantity == "landing point").verdict == (
        "no expectation"
    )


@pytest.mark.parametrize("with_truth", [True, False])
def test_an_error_that_jumps_with_the_phase_is_averaged(with_truth):
    """The first point below the ground: anywhere within a step of it."""

    def jumping(step, v):
        return v * step * (1 - 4.3 * v / 30 / step % 1.0)

    run, truth = implementation(jumping)
    report = converge(run, SCENES, LADDER, truth if with_truth else None, 1)
    seen = distance_of(report)
    assert seen.jumps
    assert seen.jump > 0.3
    assert seen.verdict == "as expected"
    assert all(rung.phases == 8 for rung in seen.rungs)
    if with_truth:  # the root mean square of a uniform share is 1/√3
        assert seen.constant == pytest.approx(30 / math.sqrt(3), rel=0.15)


def test_phases_are_spread_over_the_step():
    step, clock = 0.01, 0.537
    phases = np.sort([clock / phase_step(step, clock, j) % 1.0 for j in range(8)])
    gaps = np.diff([*phases, phases[0] + 1.0])
    assert gaps.max() < 2.7 / 8  # three-gap theorem: never more than φ² times the mean
    assert phase_step(step, clock, 0) == step


def test_a_limit_that_is_not_the_truth_is_found():
    run, truth = implementation(lambda h, v: v * h**2 + 1e-4)
    seen = distance_of(converge(run, SCENES, LADDER, truth, 2))
    assert seen.verdict == "wrong limit"
    assert "1.0" in seen.why
    assert "e-04 m" in seen.why


def test_an_error_that_never_falls_is_a_wrong_limit_too():
    run, truth = implementation(lambda h, v: 0.5)
    assert distance_of(converge(run, SCENES, LADDER, truth, 2)).verdict == "wrong limit"


def test_an_exact_implementation_has_no_order():
    run, truth = implementation(lambda h, v: 0.0)
    report = converge(run, SCENES, LADDER, truth, 2)
    assert distance_of(report).verdict == "exact"
    assert report.passed


def test_a_floor_of_rounding_is_no_wrong_limit():
    def rounded(step, v):
        return v * step**4 + 1e-13 * math.sin(1e6 / step)

    run, truth = implementation(rounded)
    seen = distance_of(converge(run, SCENES, LADDER, truth, 4))
    assert seen.verdict == "as expected"
    assert seen.rungs[-1].use == "floor"


def test_noise_is_not_resolved():
    run, truth = implementation(lambda h, v: math.sin(1e6 * v / h))
    assert distance_of(converge(run, SCENES, LADDER, truth, 1)).verdict in (
        "not resolved",
        "wrong limit",
    )


def test_scenes_that_end_otherwise_are_left_out_and_told():
    run, truth = implementation(lambda h, v: v * h)

    def losing(step):
        results = run(step)
        if step > 0.01:
            results[1] = Result(id=results[1].id, outcome="airborne")
            del results[2]
        return results

    report = converge(losing, SCENES, LADDER, truth, 1)
    assert distance_of(report).verdict == "as expected"
    assert distance_of(report).rungs[0].scenes == 1
    assert distance_of(report).rungs[-1].scenes == 3
    assert [row.lost for row in report.lost] == [2 if h > 0.01 else 0 for h in LADDER]
    assert "2 of 3 scenes end otherwise" in report.text()


def test_too_few_steps_and_strange_results_are_refused():
    run, truth = implementation(lambda h, v: h)
    with pytest.raises(ValueError, match="4 steps; 5 different positive ones are needed"):
        converge(run, SCENES, [0.1, 0.05, 0.1, 0.02, 0.01], truth)
    with pytest.raises(ValueError, match=r"a result belongs to no scene: its id is 'v35\.0'"):
        converge(run, SCENES[:2], LADDER, truth[:2])


def test_our_own_scheme_by_itself_and_against_the_parabola():
    """A projectile without air, on which interpolation is all that is left of the error."""
    scenes = [s.model_copy(update={"air": None}) for s in SCENES]
    truth = []
    for scene in scenes:
        time = (20 + math.sqrt(20**2 + 2 * 9.8)) / 9.8
        truth.append(landed(scene, scene.launch.velocity[0] * time))
    report = converge(lambda h: [solve(s, Verlet(h)) for s in scenes], scenes, LADDER, truth)
    assert distance_of(report).order == pytest.approx(2, abs=0.1)
    assert distance_of(report).jumps


# ---- what is written -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report():
    return converge(
        lambda h: [solve(s, Verlet(h, "implicit")) for s in SCENES],
        SCENES,
        LADDER,
        None,
        {"distance": 2},
    )


def test_the_json_is_what_its_schema_says_and_comes_back(report):
    data = json.loads(report.model_dump_json())
    jsonschema.validate(data, ConvergenceReport.model_json_schema(mode="serialization"))
    assert ConvergenceReport.model_validate_json(report.model_dump_json()) == report


def test_the_text_has_a_line_and_a_sentence_for_each_quantity(report):
    lines = report.text().splitlines()
    assert lines[0].split() == (
        ["quantity", "order", "95", "%", "expected", "C", "steps", "fitted,", "s", "verdict"]
    )
    assert sum(line.startswith("distance") for line in lines) == 2
    assert any("2 in theory" in line for line in lines)


def test_the_table_has_every_rung(report):
    rows = report.csv().splitlines()
    assert len(rows) == 1 + len(report.orders) * len(LADDER)
    assert rows[0] == "quantity,unit,step_s,error,scenes,phases,use"


def test_the_picture_is_drawn(report, tmp_path):
    save_convergence(tmp_path / "orders.png", report)
    assert (tmp_path / "orders.png").read_bytes().startswith(b"\x89PNG")
