"""Observed orders of made-up implementations, whose errors are known."""

import json
import math

import jsonschema
import numpy as np
import pytest
from matplotlib.figure import Figure

import longball as lb
from longball.convergence import ConvergenceReport, converge, studies, study
from longball.convergence.family import phase_step
from longball.convergence.figure import draw_convergence
from longball.engines.chain import solve
from longball.engines.verlet import Verlet
from longball.model.result import Landing, Result
from longball.model.scene import FlightScene, Launch

STEPS = np.geomspace(0.05, 1e-4, 14)
SCENES = [
    FlightScene(id=f"v{v}", launch=Launch(position=(0.0, 0.0, 1.0), velocity=(v, 0.0, 20.0)))
    for v in (20.0, 30.0, 35.0)
]


# ---- functions of the step -----------------------------------------------------------------------


def test_each_number_of_an_array_has_its_order():
    def values(step):
        return [[1.0 + step, 2.0 - step**2], [0.0, 3.0]]

    report = study(values, STEPS, truth=values(0.0))
    assert {o.quantity: o.order and round(o.order, 6) for o in report.orders} == {
        "value[0, 0]": 1.0,
        "value[0, 1]": 2.0,
        "value[1, 1]": None,
    }
    assert [order.verdict for order in report.orders] == ["no expectation"] * 2 + ["exact"]


@pytest.mark.parametrize(
    ("function", "truth"),
    [(lambda h: np.zeros(round(1 / h)), None), (lambda h: [h, h], [0, 0, 0])],
)
def test_numbers_that_come_and_go_are_refused(function, truth):
    with pytest.raises(ValueError, match=r"one shape are needed: \((20,|3,)\)"):
        study(function, STEPS, truth=truth)


def runge_kutta(h):
    """Four stages for y' = -y: at these steps its errors are roundings."""
    count = round(1 / h)
    a, y = -1 / count, 1.0
    for _ in range(count):
        y += a * y * (1 + a / 2 * (1 + a / 3 * (1 + a / 4)))
    return y


def by_turns(*sizes):
    """Errors of these sizes, step by step: no step fits a line."""
    known = dict(zip(STEPS, sizes * len(STEPS), strict=False))
    return lambda h: known[h]


def about_a_line(spread):
    """Errors about a line, with an interval of ±0.14 for its order at a spread of 0.6."""
    ratio = math.log(STEPS[1] / STEPS[0])
    return lambda h: 2 * h**1.5 * math.exp(spread * math.cos(2.4 * math.log(h) / ratio))


# An error as a function of the step, the order expected, the verdict, and why.
VERDICTS = [
    # Errors that neither fall nor change by a factor of two.
    (by_turns(1.0, 1.9), None, "wrong limit", ""),
    (by_turns(1.0, 2.1), None, "not resolved", ""),
    (lambda h: h**2 + 1e-4, 2, "wrong limit", "1.0"),
    (lambda h: h**4 + 1e-13 * math.sin(1e6 / h), 4, "as expected", ""),  # a floor of rounding
    (lambda h: h, 2, "other order", ""),
    # Scatter that leaves an order within a half of the expected one, and scatter that does not.
    (about_a_line(0.6), 1.5, "as expected", ""),
    (about_a_line(1.5), 1.5, "not resolved", ""),
]


def test_verdicts_on_functions_of_the_step():
    for number, (function, expected, verdict, why) in enumerate(VERDICTS):
        (seen,) = study(lambda h, f=function: 1 + f(h), STEPS, truth=1.0, expected=expected).orders
        assert seen.verdict == verdict, (number, seen.why)
        assert why in seen.why, number
        assert verdict != "as expected" or seen.low < expected < seen.high, number
        assert expected != 4 or seen.rungs[-1].use == "floor"
    for function, steps, truth, why in (
        (runge_kutta, np.geomspace(2e-3, 2e-4, 9), math.exp(-1), "try longer steps"),
        (by_turns(9.0, 1.0, 7.0, 2.0, 5.0, 1.0), STEPS[:6], 0.0, "there is no asymptotic range"),
    ):
        (seen,) = study(function, steps, truth=truth).orders
        assert seen.verdict == "not resolved"
        assert why in seen.why
    assert study(lambda h: h, STEPS[:5], truth=0.0).orders[0].order == pytest.approx(1.0)


def test_an_order_that_is_no_number_is_refused():
    with pytest.raises(ValueError, match="expected = nan"):
        study(lambda h: h, STEPS, expected=math.nan)


# ---- solvers of scenes ---------------------------------------------------------------------------


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
    report = converge(run, SCENES, STEPS, truth if with_truth else None, 2)
    seen = distance_of(report)
    assert report.against_truth is with_truth
    assert seen.verdict == "as expected"
    assert seen.low <= 2 + 1e-9
    assert seen.high >= 2 - 1e-9
    assert seen.constant == pytest.approx(30.0, rel=0.01)
    assert not seen.jumps
    assert {level.use for level in seen.rungs} <= {"fitted", "no error"}
    for limit in report.limits:
        if limit.quantity == "distance":
            assert limit.value[0] == pytest.approx(3 * float(limit.scene[1:]), abs=1e-9)


def test_another_order_than_expected_fails():
    run, truth = implementation(lambda h, v: v * h)
    report = converge(run, SCENES, STEPS, truth, {"distance": 2})
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
    report = converge(run, SCENES, STEPS, truth if with_truth else None, 1)
    seen = distance_of(report)
    assert seen.jumps
    assert seen.jump > 0.3
    assert seen.verdict == "as expected"
    assert all(level.phases == 8 for level in seen.rungs)
    if with_truth:  # the root mean square of a uniform share is 1/√3
        assert seen.constant == pytest.approx(30 / math.sqrt(3), rel=0.15)


def test_phases_are_spread_over_the_step():
    step, clock = 0.01, 0.537
    phases = np.sort([clock / phase_step(step, clock, j) % 1.0 for j in range(8)])
    gaps = np.diff([*phases, phases[0] + 1.0])
    assert gaps.max() < 2.7 / 8  # three-gap theorem: never more than φ² times the mean
    assert phase_step(step, clock, 0) == step
    for phase in range(1, 8):  # a multiple of the golden ratio
        behind = clock / phase_step(step, clock, phase) - clock / step
        assert behind == pytest.approx(phase * (math.sqrt(5) + 1) / 2 % 1.0, abs=1e-9)


def test_events_at_the_start_are_no_clock():
    def at(plate, landing):
        values = {"plate.time": [plate], "landing.time": [landing], "landing.distance": [9.0]}
        return studies.Sample("a", "landed", values)

    events = studies.first_and_last_event
    assert events([at(0.5, 4.0), at(0.4, 3.0)]) == (0.4, 4.0)
    assert events([at(0.0, 4.0)]) == (4.0, 4.0)
    assert events([studies.Sample("a", None, {})]) == (1.0, 1.0)  # nothing happens


def test_only_what_a_scene_should_end_with_is_observed():
    def sample(outcome, **values):
        return studies.Sample("a", outcome, {k.replace("_", "."): v for k, v in values.items()})

    right = sample("landed", landing_distance=[9.0])
    should = [right, sample("missed"), right, right, right]
    results = [
        sample("landed", landing_distance=[8.0]),
        sample("missed", landing_distance=[7.0]),
        sample("airborne", landing_distance=[6.0]),
        sample("landed"),
        sample(None, landing_distance=[5.0]),
    ]
    seen = {one.quantity: one.values for one in studies.observed(results, should)}
    np.testing.assert_array_equal(seen["distance"][:, 0], [8.0, *[math.nan] * 3, 5.0])
    assert np.isnan(seen["landing time"]).all()


def test_faults_are_wrong_limits_and_orders_that_were_expected():
    (seen,) = study(lambda h: h, STEPS, truth=0.0).orders
    verdicts = ["as expected", "exact", "wrong limit", "other order", "not resolved"]
    for expected, wanted in ((None, verdicts[2:3]), (2.0, verdicts[2:])):
        orders = [seen.model_copy(update={"verdict": v, "expected": expected}) for v in verdicts]
        report = ConvergenceReport(
            engine=None, against_truth=True, orders=tuple(orders), limits=(), lost=()
        )
        assert report.faults == [f"value: {verdict}" for verdict in wanted]
        assert not report.passed
    none = report.model_copy(update={"orders": ()})
    assert (none.passed, len(none.faults)) == (False, 1)


def test_one_scene_is_enough():
    run, truth = implementation(lambda h, v: v * h)
    report = converge(lambda h: run(h)[:1], SCENES[:1], STEPS, truth[:1], 1)
    assert distance_of(report).verdict == "as expected"
    with pytest.raises(ValueError, match="no scene to converge in"):
        converge(run, [], STEPS)


def test_scenes_that_end_otherwise_are_left_out_and_told():
    run, truth = implementation(lambda h, v: v * h)

    def losing(step):
        results = run(step)
        if step > 0.01:
            results[1] = Result(id=results[1].id, outcome="airborne")
            del results[2]
        return results

    report = converge(losing, SCENES, STEPS, truth, 1)
    assert distance_of(report).verdict == "as expected"
    assert distance_of(report).rungs[0].scenes == 1
    assert distance_of(report).rungs[-1].scenes == 3
    assert [row.lost for row in report.lost] == [2 if h > 0.01 else 0 for h in STEPS]
    assert "2 of 3 scenes refused, or with a wrong outcome" in report.text()


def test_too_few_steps_and_strange_results_are_refused():
    run, truth = implementation(lambda h, v: h)
    with pytest.raises(ValueError, match="4 steps; 5 different positive ones are needed"):
        converge(run, SCENES, [0.1, 0.05, 0.1, 0.02, 0.01], truth)
    with pytest.raises(ValueError, match=r"a result belongs to no scene: its id is 'v35\.0'"):
        converge(run, SCENES[:2], STEPS, truth[:2])


def test_what_solve_many_returns_is_a_result():
    scenes = [scene.model_copy(update={"id": None}) for scene in SCENES]
    report = converge(lambda dt: lb.solve_many(scenes, "verlet", dt=dt), scenes, STEPS[:6])
    assert "distance" in {order.quantity for order in report.orders}
    with pytest.raises(TypeError, match="type dict"):
        converge(lambda dt: [{}], scenes, STEPS)


# ---- what is written ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def report():
    return converge(
        lambda h: [solve(s, Verlet(h, "implicit")) for s in SCENES],
        SCENES,
        STEPS,
        None,
        {"distance": 2},
    )


def test_the_json_is_what_its_schema_says_and_comes_back(report):
    data = json.loads(report.model_dump_json())
    jsonschema.validate(data, ConvergenceReport.model_json_schema(mode="serialization"))
    assert ConvergenceReport.model_validate_json(report.model_dump_json()) == report


def test_the_table_has_every_step(report):
    rows = report.csv().splitlines()
    assert len(rows) == 1 + len(report.orders) * len(STEPS)
    assert rows[0] == "quantity,unit,step_s,error,scenes,phases,use"


def test_the_picture_shows_every_step_and_the_law_through_those_that_are_fitted(report):
    axes = Figure().add_subplot()
    draw_convergence(axes, report)
    lines, labels = list(axes.lines), [t.get_text() for t in axes.get_legend().get_texts()]
    for order, label in zip(report.orders, labels, strict=True):
        assert label.startswith(order.quantity)
        fitted = [(step, error) for step, error, use in order.errors if use == "fitted"]
        if order.order is not None:
            assert label == f"{order.quantity}, order {order.order:.2f}"
            law = np.array([[h, order.constant * h**order.order] for h, _ in fitted])
            np.testing.assert_allclose(lines.pop(0).get_xydata(), law)
        every, filled = lines.pop(0), lines.pop(0)
        assert every.get_xydata().tolist() == [[h, e] for h, e, _ in order.errors]
        assert filled.get_xydata().tolist() == [[h, e] for h, e in fitted]
        assert every.get_markerfacecolor() == "none"
        assert filled.get_color() == every.get_color()
    assert lines == []
    assert any(order.order is not None for order in report.orders)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
