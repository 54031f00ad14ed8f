"""The reference engine against high precision, closed forms, and the traps of event finding."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from flint import arb
from longball.model.motion import Forces, PlaneState, acceleration

from longball.engines import ivp
from longball.engines.chain import solve
from longball.engines.engine import CannotSolve, Stops
from longball.engines.ivp import METHODS, Ivp
from longball.model import exact
from longball.model.numbers import Undecided
from longball.model.scene import AtBatScene, Pitch, Swing, parse_scene
from tests import oracle

ENGINE = Ivp()

# What the engine promises on regular scenes.
LENGTH, TIME = 1e-11, 1e-12  # m, s
TOLERANCES = {
    "plate.time": TIME,
    "plate.position": LENGTH,
    "contact.time": TIME,
    "contact.position": LENGTH,
    "contact.margin": LENGTH,
    "landing.time": TIME,
    "landing.hang_time": TIME,
    "landing.position": LENGTH,
    "landing.distance": LENGTH,
}

NO_AIR = Forces(None, None, 9.8, False)
DRAG = Forces(0.0075, None, 9.8, False)
USUAL = Forces(0.0075, 0.00375, 9.8, False)
LOOPS = Forces(None, 0.0381, 0.0126, False)  # at 160 m/s a loop takes 1 s


def fly(start, forces, engine=ENGINE, **stops):
    return engine.fly(PlaneState(*start), forces, Stops(**({"time_limit": 60.0} | stops)))


def path_of(start, forces):
    """The flight in high precision; its plane is that of x and z."""
    s, z, u, w = map(arb, start)
    constants = [arb(k or 0.0) for k in (forces.drag, forces.lift, forces.gravity)]
    return oracle.Path([s, arb(0), z], [u, arb(0), w], constants)


# ---- accuracy ------------------------------------------------------------------------------------


def at_bat_of_the_paper(rng):
    """Drawn from the paper's distributions."""
    mean, spread = (139.1, 4.58) if rng.random() < 0.45 else (127.8, 7.8)
    cell = rng.normal(2 if rng.random() < 0.52 else 4, 0.77)
    return AtBatScene(
        id="drawn",
        pitch=Pitch(speed=rng.normal(mean, spread) / 3.6, aim=((cell - 3) * 0.144, 1.8)),
        swing=Swing(height_offset=rng.normal(0, 0.0366), tilt=math.radians(rng.uniform(0, 10))),
    )


@pytest.mark.parametrize("seed", range(5))
def test_at_bats_agree_with_high_precision(seed):
    rng = np.random.default_rng([2014, seed])
    outcomes = set()
    for _ in range(20):
        scene = at_bat_of_the_paper(rng)
        found = solve(scene, ENGINE)
        outcomes.add(found.outcome)
        truth = oracle.solve(json.loads(scene.line()))
        off = {}
        for key, error in oracle.errors(json.loads(found.line()), truth):
            off[key] = max(off.get(key, 0.0), abs(error))
        beyond = {key: off[key] for key in TOLERANCES.keys() & off if off[key] > TOLERANCES[key]}
        assert beyond == {}, scene.line()
    assert "batted" in outcomes


@pytest.mark.parametrize(
    ("method", "rtol"),
    [
        (method, rtol)
        for method in METHODS
        for rtol in (1e-4, 1e-7, 1e-10)
        if (method, rtol) != ("RK23", 1e-10)  # 60,000 steps of third order
    ],
)
def test_every_method_is_as_accurate_as_its_tolerance(method, rtol):
    """A batted ball of 6 s and 110 m, relative to those.

    A one-step method's few steps stay within one tolerance together; the many of a multistep
    method add up, to 15 with BDF.
    """
    start = (0.0, 1.0, 35.0, 30.0)
    landing = fly(start, USUAL, Ivp(method=method, rtol=rtol, atol=rtol), floor=0.0)
    path = path_of(start, USUAL)
    tolerance = (20 if method in ("BDF", "LSODA") else 1) * rtol
    with oracle.in_digits(oracle.DIGITS):
        time = path.landing(arb(0), arb(60))
        (x, _, _), _ = path.at(time)
        assert abs(landing.state.s / x - 1) < tolerance
        assert abs(landing.time / time - 1) < tolerance


def test_a_finer_tolerance_is_a_smaller_error():
    start = (0.0, 1.0, 35.0, 30.0)
    path = path_of(start, USUAL)
    with oracle.in_digits(oracle.DIGITS):
        (x, _, _), _ = path.at(path.landing(arb(0), arb(60)))
        errors = [
            float(abs(fly(start, USUAL, Ivp(rtol=rtol, atol=rtol), floor=0.0).state.s - x))
            for rtol in (1e-5, 1e-8, 1e-11)
        ]
    assert errors[0] > 30 * errors[1] > 900 * errors[2]


@pytest.mark.parametrize(
    ("start", "floor"), [((0.0, 1.0, 30.0, 20.0), 0.0), ((2.0, 3.0, 8.0, -5.0), -50.0)]
)
def test_the_parabola(start, floor):
    time, state = exact.parabola_to_floor(PlaneState(*start), 9.8, floor, math)
    landing = fly(start, NO_AIR, floor=floor)
    assert landing.time == pytest.approx(time, abs=TIME)
    assert landing.state == pytest.approx(state, abs=LENGTH)
    time, state = exact.parabola_to_wall(PlaneState(*start), 9.8, 10.0)
    crossing = fly(start, NO_AIR, wall=10.0)
    assert (crossing.stop, crossing.state.s) == ("wall", 10.0)
    assert crossing.time == pytest.approx(time, abs=TIME)
    assert crossing.state == pytest.approx(state, abs=LENGTH)


@pytest.mark.parametrize("drag", [None, 0.0075])
@pytest.mark.parametrize("lift", [None, 0.01, -0.01])
def test_the_weightless_turn(drag, lift):
    start, forces = (0.0, 100.0, 30.0, 20.0), Forces(drag, lift, None, False)
    end = fly(start, forces, time_limit=3.0)
    wanted = exact.weightless(PlaneState(*start), forces, 3.0, math)
    assert end.stop == "time"
    assert end.state == pytest.approx(wanted, abs=LENGTH)


# ---- the singular point: V = 0 -------------------------------------------------------------------


def test_a_drop_from_rest():
    time, state = exact.fall_to_floor(PlaneState(0.0, 50.0, 0.0, 0.0), 0.0075, 9.8, 0.0, math)
    landing = fly((0.0, 50.0, 0.0, 0.0), DRAG, floor=0.0)
    assert landing.time == pytest.approx(time, abs=TIME)
    assert landing.state == pytest.approx(state, abs=LENGTH)


def test_a_drop_from_rest_with_lift():
    """Close to rest the lift is nothing, and the oracle can start a moment later."""
    landing = fly((0.0, 50.0, 0.0, 0.0), USUAL, floor=0.0)
    delay = 1e-9
    later = fly((0.0, 50.0, 0.0, -9.8 * delay), USUAL, floor=0.0)
    assert landing.time == pytest.approx(later.time + delay, abs=TIME)
    assert landing.state.s == pytest.approx(later.state.s, abs=LENGTH)
    assert landing.state.s > 0.1


@pytest.mark.parametrize("always_up", [False, True])
def test_a_ball_that_rests_at_its_apex(always_up):
    """Straight up and down through the air, against tan and tanh."""
    start = PlaneState(0.0, 1.0, 0.0, 30.0)
    up, top = exact.apex(start, 0.0075, 9.8, math)
    down, state = exact.fall_to_floor(top, 0.0075, 9.8, 0.0, math)
    landing = fly(start, replace(DRAG, always_up=always_up), floor=0.0)
    assert landing.time == pytest.approx(up + down, abs=TIME)
    assert landing.state == pytest.approx(state, abs=LENGTH)


@pytest.mark.parametrize("sideways", [1e-3, 1e-7, 1e-12])
def test_a_ball_that_nearly_rests_at_its_apex(sideways):
    start = (0.0, 1.0, sideways, 30.0)
    landing = fly(start, DRAG, floor=0.0)
    path = path_of(start, DRAG)
    with oracle.in_digits(oracle.DIGITS):
        time = path.landing(arb(0), arb(60))
        (x, _, _), _ = path.at(time)
        assert abs(landing.time - time) < TIME
        assert abs(landing.state.s - x) < LENGTH


def test_straight_up_with_lift_that_is_always_up_is_without_lift():
    line = (
        '{"id": "up", "kind": "flight", "reading": {"lift_direction": "always_up"}, '
        '"launch": {"position": [3, 0, 1], "velocity": [0, 0, 30]}}'
    )
    landing = solve(parse_scene(line), ENGINE).landing
    none = line.replace('"launch"', '"air": {"lift_coefficient": 0}, "launch"')
    assert landing == solve(parse_scene(none), ENGINE).landing
    assert landing.position[:2] == (3.0, 0.0)


def test_past_the_vertical_a_lift_that_is_always_up_has_gone():
    """To the vertical by the series, on from there by tan and tanh."""
    line = (
        '{"id": "loop", "kind": "flight", "reading": {"lift_direction": "always_up"}, '
        '"launch": {"position": [0, 0, 1], "velocity": [2, 0, 40]}}'
    )
    scene = parse_scene(line)
    found = solve(scene, ENGINE).landing
    with oracle.in_digits(oracle.DIGITS):
        constants = oracle.force_constants(json.loads(scene.line()))
        path = oracle.Path(oracle.vector((0, 0, 1)), oracle.vector((2, 0, 40)), constants)

        def sideways(time):
            _, v = path.at(time)
            return v[0], path.acceleration(v)[0]

        to_vertical = oracle.newton(sideways, arb(1))
        (x, _, z), (_, _, w) = path.at(to_vertical)
        assert w > 0
        upright = PlaneState(x, z, arb(0), w)
        drag, _, gravity = constants
        up, top = exact.apex(upright, drag, gravity, exact.METHODS)
        down, end = exact.fall_to_floor(top, drag, gravity, arb(0), exact.METHODS)
        assert abs(found.time - (to_vertical + up + down)) < TIME
        assert abs(found.position[0] - x) < LENGTH
        assert abs(found.velocity[2] - end.w) < LENGTH


# ---- events --------------------------------------------------------------------------------------


@pytest.mark.parametrize("stop", ["floor", "wall"])
def test_a_root_exactly_at_the_end_of_a_step(stop):
    """A flight stopped on the very height, or distance, that one of its steps ends on."""
    start = (0.0, 1.0, 35.0, 30.0)
    times, states = (lambda leg: (leg.times, leg.states))(fly(start, DRAG, time_limit=6.0).record)
    step = len(times) - 2
    state = PlaneState(*states[:, step].tolist())
    assert state.w < 0
    where = {"floor": state.z, "wall": state.s}[stop]
    arrival = fly(start, DRAG, **{stop: where})
    assert arrival.stop == stop
    assert arrival.time == pytest.approx(times[step], abs=TIME)
    assert arrival.state == pytest.approx(state, abs=LENGTH)


def test_a_landing_and_the_time_limit_closer_than_the_error_are_not_told_apart():
    start, unit = (0.0, 0.0, 1.0, 8.0), Forces(None, None, 8.0, False)  # lands at t = 2 s
    assert fly(start, unit, floor=0.0, time_limit=2.0 + 1e-9).stop == "floor"
    short = fly(start, unit, floor=0.0, time_limit=2.0 - 1e-9)
    assert (short.stop, short.time) == ("time", 2.0 - 1e-9)
    for limit in (math.nextafter(2.0, 1.0), 2.0, math.nextafter(2.0, 3.0)):
        with pytest.raises(Undecided, match="before the time limit"):
            fly(start, unit, floor=0.0, time_limit=limit)


@pytest.mark.parametrize("wall", [16.0 - 1e-13, 16.0, 16.0 + 1e-13])
def test_a_landing_and_the_plate_closer_than_the_error_are_not_told_apart(wall):
    start, unit = (0.0, 4.0, 16.0, 0.0), Forces(None, None, 8.0, False)  # lands at s = 16 m
    with pytest.raises(Undecided, match="before the plate"):
        fly(start, unit, floor=0.0, wall=wall)


def test_airborne_at_the_time_limit():
    end = fly((0.0, 1.0, 35.0, 30.0), USUAL, floor=0.0, time_limit=2.0)
    assert (end.stop, end.time) == ("time", 2.0)
    path = path_of((0.0, 1.0, 35.0, 30.0), USUAL)
    with oracle.in_digits(oracle.DIGITS):
        (x, _, z), _ = path.at(arb(2))
        assert abs(end.state.s - x) < LENGTH
        assert abs(end.state.z - z) < LENGTH


@pytest.mark.parametrize("w", [1e-9, 1e-3, 1.0, 30.0])
def test_a_launch_from_the_ground_flies(w):
    landing = fly((0.0, 0.0, 20.0, w), NO_AIR, floor=0.0)
    assert landing.time == pytest.approx(2 * w / 9.8, rel=1e-14)
    assert landing.state == pytest.approx((20.0 * landing.time, 0.0, 20.0, -w), rel=1e-14)


@pytest.mark.parametrize("w", [0.0, -0.0, -1e-9, -5.0])
@pytest.mark.parametrize("forces", [NO_AIR, USUAL])
def test_a_ball_on_the_ground_that_does_not_rise_has_landed(w, forces):
    landing = fly((0.0, 0.0, 5.0, w), forces, floor=0.0)
    assert (landing.stop, landing.time) == ("floor", 0.0)
    assert landing.state == (0.0, 0.0, 5.0, w)


def test_a_tangential_start_that_lift_carries_up():
    """w = 0 on the ground, but k_L V² > g."""
    forces = Forces(0.001, 0.02, 9.8, False)
    start = (0.0, 0.0, 40.0, 0.0)
    end = fly(start, forces, floor=0.0, time_limit=1.0)
    assert (end.stop, end.time) == ("time", 1.0)
    path = path_of(start, forces)
    with oracle.in_digits(oracle.DIGITS):
        (x, _, z), _ = path.at(arb(1))
        assert abs(end.state.s - x) < LENGTH
        assert abs(end.state.z - z) < LENGTH


def test_a_loop_that_comes_back_to_the_ground_tangentially_is_not_decided():
    """Without drag it does so after each round, of what would be an endless flight."""
    with pytest.raises(Undecided, match="touches the ground at the bottom of a dip"):
        fly((0.0, 0.0, 40.0, 0.0), Forces(None, 0.02, 9.8, False), floor=0.0, time_limit=20.0)


def bottom_of(path, guess):
    def rate(time):
        _, v = path.at(time)
        return v[2], path.acceleration(v)[2]

    return oracle.newton(rate, arb(guess))


DIPPING = ((0.0, 3.0, 45.0, -8.0), Forces(0.001, 0.01, 9.8, False))


@pytest.mark.parametrize("depth", [1.0, 1e-3, 1e-6, 1e-9])
def test_a_dip_into_the_ground_between_two_steps_is_a_landing(depth):
    start, forces = DIPPING
    path = path_of(start, forces)
    with oracle.in_digits(oracle.DIGITS):
        bottom = bottom_of(path, 0.7)
        r, v = path.at(bottom)
        floor = float(r[2]) + depth
        truly = floor - r[2]

        def height(time):
            r, v = path.at(time)
            return r[2] - arb(floor), v[2]

        # From the parabola about the bottom.
        back = (2 * truly / path.acceleration(v)[2]).sqrt()
        time = oracle.newton(height, bottom - back)
        (x, _, _), _ = path.at(time)
        landing = fly(start, forces, floor=floor)
        # An error in height shifts a shallow landing by its ratio to the slope there.
        slope = float(abs(path.at(time)[1][2]) / 45)
        assert abs(landing.state.s - x) < LENGTH / slope
        assert abs(landing.time - time) < TIME / slope
    assert landing.stop == "floor"


@pytest.mark.parametrize("clearance", [1e-9, 1e-3])
def test_a_dip_above_the_ground_is_none(clearance):
    start, forces = DIPPING
    path = path_of(start, forces)
    with oracle.in_digits(oracle.DIGITS):
        bottom = bottom_of(path, 0.7)
        lowest = float(path.at(bottom)[0][2])
    later = float(bottom) + 0.5
    end = fly(start, forces, floor=lowest - clearance, time_limit=later)
    assert (end.stop, end.time) == ("time", later)


def test_a_dip_that_touches_to_rounding_is_not_decided():
    start, forces = DIPPING
    path = path_of(start, forces)
    with oracle.in_digits(oracle.DIGITS):
        lowest = float(path.at(bottom_of(path, 0.7))[0][2])
    with pytest.raises(Undecided, match="touches the ground at the bottom of a dip"):
        fly(start, forces, floor=lowest)


@pytest.mark.parametrize("above", [1e-3, 1e-6, 1e-9, -1e-9, -1e-6, -1e-3])
def test_plate_and_ground_within_one_step(above):
    """The floor that far below the place where the ball crosses the wall, or above it."""
    start = (0.0, 1.8, 25.0, 0.0)
    crossing = fly(start, USUAL, wall=18.0)
    stop = fly(start, USUAL, wall=18.0, floor=crossing.state.z - above)
    assert stop.stop == ("wall" if above > 0 else "floor")
    assert stop.time == pytest.approx(crossing.time, abs=1e-3)
    if above > 0:
        assert stop.state == pytest.approx(crossing.state, abs=LENGTH)
    else:
        assert stop.time < crossing.time


# ---- stiff, and beyond ---------------------------------------------------------------------------


# Steps at these tolerances are of 0.1 to 0.3 rad of a loop; an event is settled in a few more.
@pytest.mark.parametrize(
    ("start", "forces", "stop", "most"),
    [
        ((0.0, 1.0, 30.0, 30.0), USUAL, "floor", 600),
        ((0.0, 50.0, 160.0, 0.0), LOOPS, "time", 10_000),  # ten loops
    ],
)
def test_the_work_of_a_flight_is_bounded(monkeypatch, start, forces, stop, most):
    worked = 0

    def counted(*which):
        function = acceleration(*which)

        def evaluate(u, w):
            nonlocal worked
            worked += 1
            return function(u, w)

        return evaluate

    monkeypatch.setattr(ivp, "acceleration", counted)
    arrival = fly(start, forces, floor=0.0, time_limit=10.0)
    assert arrival.stop == stop
    assert 0 < worked < most


@pytest.mark.parametrize("drag", [1.0, 100.0, 1e4])
def test_a_feather_light_ball(drag):
    """It settles to √(g/k) within 1/√(g k), and explicit steps stay that short."""
    time, state = exact.fall_to_floor(PlaneState(0.0, 1.0, 0.0, 0.0), drag, 9.8, 0.0, math)
    landing = fly((0.0, 1.0, 0.0, 0.0), Forces(drag, None, 9.8, False), floor=0.0)
    # Of the way of 1 m, and of the times that it takes.
    assert landing.time == pytest.approx(time, rel=ENGINE.flight_error)
    assert landing.state.w == pytest.approx(state.w, rel=ENGINE.flight_error)


def test_forces_without_measure_are_an_error():
    with pytest.raises(CannotSolve, match="beyond the range of double precision"):
        fly((0.0, 1.0, 1e200, 0.0), Forces(1e200, None, 9.8, False), floor=0.0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"method": "RK4"}, "method 'RK4' is not one of RK23"),
        ({"rtol": 1e-15}, "rtol = 1e-15 is not between 2.22e-14 and 1"),
        ({"rtol": 1.0}, "rtol"),
        ({"rtol": math.nan}, "rtol"),
        ({"atol": 0.0}, "atol"),
    ],
)
def test_settings_that_cannot_be_kept_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        Ivp(**settings)


def test_the_description_tells_the_settings():
    assert Ivp("RK45", 1e-8, 1e-9).description == "ivp RK45 rtol=1e-08 atol=1e-09"
