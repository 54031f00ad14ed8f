"""Columns of scenes, flights across kinks, and the tolerances with which numbers are compared."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from longball.judge.answers import Answer
from longball.judge.diagnosis import residual
from longball.judge.diagnosis.chain import r, r0
from longball.judge.diagnosis.expression import S, constant
from longball.judge.diagnosis.residual import (
    COARSE,
    FINE,
    HUGE,
    MIDDLE,
    UNAWARE,
    Launched,
    begun,
    compared,
    data_of,
    evenly,
    flown,
    follow,
    follows,
    inputs,
    options,
    specialised_to,
    with_every_option,
)
from longball.model.scene import AtBatScene, FlightScene, Launch, parse_scene
from tests.judge.material import known, right, truth


def thrown(duration: Any, pull: Any, **more: Any) -> Launched:
    """Balls at (0, 0, 1) with 20 m/s upwards, under an acceleration of the height."""
    duration = np.asarray(duration, float)
    y = np.zeros((7, len(duration)))
    y[2], y[5] = 1.0, 20.0

    def rates(at: Any, t: Any, start: Any = None) -> Any:
        slope = np.zeros_like(at)
        slope[:3], slope[5], slope[6] = at[3:6], pull(at, t), np.abs(at[5])
        return slope

    def some(which: Any) -> Launched:
        return thrown(duration[which], pull, **more)

    piece = more.get("piece", lambda at, t: np.zeros((1, at.shape[1])))
    return Launched(y, np.zeros((3, len(duration))), duration, rates, lambda y: {}, piece, some)


def test_flights_of_any_length():
    """Under -x'' = x: each in its own number of steps, backwards too; none without a time."""
    times = np.array([0.1, 2.0, 5.0, -1.0, np.nan])
    found = flown(thrown(times, lambda at, t: -at[2]), times)
    with np.errstate(invalid="ignore"):
        expected = np.cos(times) + 20 * np.sin(times)
        rising = 20 * np.cos(times) - np.sin(times)
    assert found[2] == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert found[5] == pytest.approx(rising, abs=1e-9, nan_ok=True)
    times = np.array([0.05, 300.0])
    parabola = flown(thrown(times, lambda at, t: np.full(at.shape[1], -10.0)), times)
    assert parabola[2] == pytest.approx(1 + 20 * times - 5 * times**2, rel=1e-13)
    times = np.array([0.1, 2.0, 5.0])
    # Other flights of the batch change nothing. Fewer steps have larger errors.
    alone = flown(thrown(times[2:3], lambda at, t: -at[2]), times[2:3])
    assert alone[:6, 0] == pytest.approx(found[:6, 2], rel=1e-12)
    off = [
        abs(flown(thrown(times[1:2], lambda at, t: -at[2]), times[1:2], limits)[2] - expected[1])
        for limits in (COARSE, MIDDLE, UNAWARE)
    ]
    assert off[0] > off[1] > off[2]


def test_a_flight_with_too_many_steps_states_a_huge_error():
    for time, error in ((5.0, residual.TOTAL), (75.0, HUGE)):
        balls = thrown([time], lambda at, t: -at[2])
        assert residual._flown(balls, balls.duration, FINE)[1] == [error]


def test_a_ball_between_two_forces_is_stuck_and_the_others_fly_on():
    """Friction of 40 m/s² against each motion: after 0.5 s the ball can move neither way."""
    calls = []

    def pull(at: Any, t: Any) -> Any:
        calls.append(at.shape[1])
        return -40.0 * np.sign(at[5])

    times = np.array([5.0, 0.4])
    balls = thrown(times, pull, piece=lambda at, t: np.atleast_2d(at[5] > 0))
    found, doubt = residual._flown(balls, times, FINE)
    assert found[2, 1] == pytest.approx(1 + 20 * 0.4 - 20 * 0.4**2, rel=1e-12)
    assert doubt.tolist() == [HUGE, residual.TOTAL]
    assert len(calls) < 2000  # evaluations of the law, of the 3,000 that its steps would allow


@pytest.mark.parametrize("level", [5.0, 15.37, 20.9])
def test_a_jump_on_the_way_is_met_exactly(level: float):
    """Gravity is 10 below a height and 20 above it; parabolas on both sides."""

    def pull(at: Any, t: Any) -> Any:
        return np.where(at[2] > level, -20.0, -10.0)

    def piece(at: Any, t: Any) -> Any:
        return np.atleast_2d(at[2] > level)

    up = 2.0 - np.sqrt(4.0 - (level - 1.0) / 5.0)  # 1 + 20 t - 5 t² = level
    speed = 20.0 - 10.0 * up
    times = np.array([up / 2, up + speed / 20 + 0.1, up + speed / 10 + 0.7])
    rest = times - up
    above = level + speed * rest - 10 * rest**2
    rest -= speed / 10
    expected = [
        1 + 20 * times[0] - 5 * times[0] ** 2,
        above[1] if rest[1] < 0 else level - speed * rest[1] - 5 * rest[1] ** 2,
        level - speed * rest[2] - 5 * rest[2] ** 2,
    ]
    found = flown(thrown(times, pull, piece=piece), times)
    assert found[2] == pytest.approx(expected, abs=1e-9)
    unaware = flown(thrown(times, pull, piece=piece), times, UNAWARE)
    assert abs(unaware[2] - expected).max() > 1e-6


def test_a_time_in_the_law():
    times = np.array([2.0, 3.0])
    found = flown(thrown(times, lambda at, t: 6.0 * t), times)
    assert found[2] == pytest.approx(1 + 20 * times + times**3, rel=1e-13)
    late = thrown(times, lambda at, t: np.where(t > 1.3, -10.0, 0.0) + 0.0 * at[2],
                  piece=lambda at, t: np.atleast_2d(t > 1.3))  # fmt: skip
    found = flown(late, times)
    assert found[2] == pytest.approx(1 + 20 * times - 5 * (times - 1.3) ** 2, abs=1e-9)


def test_steps_shorten_where_the_law_is_steep():
    """A decay of 300/s, which the longest steps would not resolve."""
    times = np.array([5.0])
    with np.errstate(all="ignore"):  # as `values`
        found = flown(thrown(times, lambda at, t: -300.0 * at[5]), times)
    assert found[2] == pytest.approx(1 + 20 / 300, rel=1e-9)
    assert abs(found[5]) < 1e-6


def test_evenly():
    every = np.arange(100)
    assert np.array_equal(evenly(every, 3), [0, 50, 99])
    assert np.array_equal(evenly(every[:3], 3), every[:3])
    assert len(evenly(every, 40)) == len({*evenly(every, 40).tolist()}) == 40


def test_scenes_with_every_option():
    numbers, one = np.arange(3.0), np.array(["p", "q", "q"])
    for other, expected in ((["x", "y", "y"], {0, 1}), (["x", "x", "y"], {0, 1, 2})):
        found = with_every_option({"n": numbers, "b": one, "a": np.array(other)})
        assert {*found.tolist()} == expected
        assert len(found) == len(expected)
    assert not with_every_option({"n": numbers}).size


def test_columns_of_scenes():
    launch = Launch(position=(0, 0, 1), velocity=(30, 1, 20))
    calm = FlightScene(id="a", launch=launch, air=None)
    spinning = calm.model_copy(update={"launch": launch.model_copy(update={"spin": (1, 2, 3)})})
    found = inputs([calm, AtBatScene(id="b")])
    assert found["launch.velocity"][:, 0].tolist() == [30, 1, 20]
    assert np.isnan(found["launch.velocity"][:, 1]).all()
    assert np.isnan(found["V_0"][0])
    # A program that ignores that there is no spin takes 0 for it.
    assert found["launch.spin"][:, 0].tolist() == found["pitch.spin"][:, 1].tolist() == [0, 0, 0]
    assert found["β"].tolist() == [0.4, 0.4]
    assert found["ρ_0"][0] == found["ρ_0"][1]  # null is replaced by the default air
    assert (options(calm)["air"], options(calm)["spin"], options(calm)["pitch"]) == (
        "none", "none", "aimed",
    )  # fmt: skip
    assert options(spinning)["spin"] == options(spinning)["spin after"] == "given"
    rubbed = AtBatScene.model_validate({"bat": {"friction": 0.3}})
    assert (options(rubbed)["spin"], options(rubbed)["spin after"]) == ("none", "given")


def test_tables_of_different_lengths():
    tables = [case.scene for case in known("various-real", "flight-kinks")
              if "table" in options(case.scene)["air.drag_coefficient"]]  # fmt: skip
    found = inputs(tables)
    lengths = set()
    for i, scene in enumerate(tables):
        at = scene.air.drag_coefficient.at
        lengths.add(len(at))
        column = found["air.drag_coefficient.at"][:, i]
        assert column[: len(at)].tolist() == [*at]
        assert (column[len(at) :] == at[-1]).all()
    assert len(lengths) > 1


@pytest.fixture(scope="module")
def drives() -> Any:
    data = truth(known("flight-both")[::4])
    return specialised_to(data), data


def test_errors_within_the_tolerance_follow(drives: Any):
    chain, data = drives
    (stage,) = (stage for stage in chain if stage.name == "distance")
    some = np.arange(len(data.cases))
    columns, _ = follow(chain, data)

    def told(by: float, **more: Any) -> Any:
        given = {**data.given, "landing.distance": data.given["landing.distance"] * (1 + by)}
        other = replace(data, given=given, **more)
        return compared(stage, other, follow(chain, other)[0], some)[0]

    assert not told(2e-13).wrong.any()
    assert told(3e-12).wrong.all()
    assert not told(3e-12).beyond.any()
    assert told(2e-9).beyond.all()
    assert told(2e-9).relative == pytest.approx(np.full(len(some), 2e-9), rel=1e-3)
    assert not told(1e-6, granted=1.0).wrong.any()
    # Four times the noise that rounded values propagate
    for noise, is_wrong in ((0.24e-6, True), (0.26e-6, False)):
        slips = noise * data.given["landing.distance"]
        found = told(1e-6, slips=lambda *_, by=slips: by[None])
        assert (found.wrong == is_wrong).all()
    assert not told(1e-6, cut={"landing.distance": (0.0, 2e-6)}).wrong.any()
    assert not told(1e-6, cut={"landing.distance": (1e-3, 0.0)}).wrong.any()
    assert told(1e-4, cut={"landing.distance": (1e-3, 0.0)}).wrong.any()
    silent = {**data.given, "landing.distance": np.full(len(some), np.nan)}
    found, _ = compared(stage, replace(data, given=silent), columns, some)
    assert not found.checked.any()
    blind = replace(data, blind={("distance", "formula"): some[:3]})
    assert compared(stage, blind, columns, some)[0].checked.tolist() == [False] * 3 + [True] * (
        len(some) - 3
    )
    assert follows(chain, data)


def test_a_formula_without_a_value_is_the_largest_error(drives: Any):
    chain, data = drives
    (stage,) = (stage for stage in chain if stage.name == "distance")
    (root,) = stage.roots.values()
    endless = stage.edited(root, root / (0.0 * root))
    some = np.arange(3)
    found, _ = compared(endless, data, follow(chain, data)[0], some)
    assert (found.off == HUGE).all()


def test_stages_that_need_the_ball_at_the_bat_are_omitted_where_the_pitch_is_wrong():
    data = truth(known("at-bat")[::5])
    chain = specialised_to(data)
    _, before = follow(chain, data)
    moved = {**data.given, "contact.position": data.given["contact.position"] + 0.01}
    _, found = follow(chain, replace(data, given=moved))
    for one, was in zip(found, before, strict=True):
        if one.stage.name in ("normal speed", "velocity after"):
            assert len(one.some) < len(was.some)
        if one.stage.name in ("bat velocity", "impulse"):
            assert len(one.some) == len(was.some)


def test_the_duration_of_a_flight_comes_from_the_time_nearer_to_the_truth():
    data = truth(known("at-bat")[::5])
    right = begun(data)["hang_time"]
    flies = np.isfinite(data.expected["landing.hang_time"])
    for wrong in ("landing.hang_time", "landing.time"):
        given = {**data.given, wrong: data.given[wrong] + 0.1}
        found = begun(replace(data, given=given))["hang_time"]
        assert found[flies] == pytest.approx(right[flies], abs=1e-12)
        given[wrong] = np.full_like(right, np.nan)
        found = begun(replace(data, given=given))["hang_time"]
        assert found[flies] == pytest.approx(right[flies], abs=1e-12)


def test_a_margin_is_compared_only_where_the_pitch_is_right():
    cases = known("at-bat")[::9]
    errors = itertools.cycle((1e-11, 1e-6))

    def moved(case: Any) -> dict[str, Answer]:
        by = [0.0, 0.0, next(errors)]
        return right([case], lambda q, x: np.array(x, float) + by if q == "plate.position" else x)

    told = {case.id: moved(case)[case.id] for case in cases}
    found = np.isfinite(data_of(cases, told).given["contact.margin"])
    true = np.isfinite(truth(cases).given["contact.margin"])
    odd = np.arange(len(cases)) % 2 == 1
    assert np.array_equal(found, true & ~odd)
    assert found.any()


def test_the_chord_beside_a_point():
    """At a step of the fence two chords are equally near: the height decides."""
    cases = [case for case in known("fence") if case.scene.fence.polyline][:12]
    data = truth(cases)
    ends = np.array([data.columns["chord.a"], data.columns["chord.b"]])
    at = data.given["fence.position"]
    there = np.isfinite(at).all(axis=0)
    a, b = ends[:, :2]
    share = ((at[:2] - a) * (b - a)).sum(0) / ((b - a) ** 2).sum(0)
    foot = a + share * (b - a)
    assert (share[there] > -1e-9).all()
    assert (share[there] < 1 + 1e-9).all()
    assert abs(foot - at[:2])[:, there].max() < 1e-9
    top = ends[0, 2] + share * (ends[1, 2] - ends[0, 2])
    assert (at[2] - data.given["fence.clearance"])[there] == pytest.approx(top[there], abs=1e-9)


def test_the_chord_at_a_step_follows_from_the_clearance_and_at_a_corner_from_the_segment():
    scene = parse_scene(
        '{"id": "a", "kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 9, 20]}, '
        '"fence": {"polyline": [[67, 67, 8], '
        "[98, 40, 11.3], [98, 40, 5.2], [118, 12, 9], [9, -60, 1]]}}"
    )
    at = np.array([[98.0, 98.0, 98.1, 118.0], [40.0, 40.0, 39.86, 12.0], [20.0] * 4])
    tops = np.array([11.3, 5.2, np.nan, 9.0])
    said = [None, None, None, 3]
    found = residual._fences([scene] * 4, at, tops, said)
    assert found["chord.a"][:, 0].tolist() == [67, 67, 8]
    assert found["chord.a"][:, 1].tolist() == [98, 40, 5.2]
    assert found["chord.b"][:, 2].tolist() == [118, 12, 9]
    assert found["chord.a"][:, 3].tolist() == [118, 12, 9]  # the candidate's own chord
    assert np.isnan(residual._fences([scene], np.full((3, 1), np.nan), tops, said)["chord.a"]).all()


@np.errstate(all="ignore")  # as `compared`
def test_the_stated_error_of_flights_is_relative_to_their_numbers():
    data = truth(known("flight-kinks")[::3])
    chain = specialised_to(data)
    columns, _ = follow(chain, data)
    (stage,) = (stage for stage in chain if stage.kind == "flight")
    found, again = residual._flown_once(stage, columns, data, FINE)
    for quantity in stage.quantities[:2]:
        size = np.maximum(abs(found[quantity]), 1.0)
        share = abs(again[quantity] - found[quantity]) / size
        assert np.isclose(share, residual.TOTAL, rtol=1e-3, atol=0.0).all()


def test_a_law_may_know_the_launch(drives: Any):
    """A spring to the launch, (r0 - r)/s²: r = r0 + v0 sin t."""
    chain, data = drives
    (stage,) = (stage for stage in chain if stage.kind == "flight")
    second = constant(1.0, S)
    spring = stage.edited(stage.roots["law"], (r0 - r) * (1.0 / (second * second)))
    columns = {**follow(chain, data)[0], "hang_time": np.full(len(data.cases), 2.0)}
    found = residual.values(spring, columns)
    start, speed = columns["launch.position"], columns["launch.velocity"]
    position, velocity = (found[q] for q in stage.quantities[:2])
    assert position == pytest.approx(start + speed * np.sin(2.0), abs=1e-9)
    assert velocity == pytest.approx(speed * np.cos(2.0), abs=1e-9)
