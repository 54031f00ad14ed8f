"""Proven bounds: they hold the truth, they are narrow, and what is open is said to be open.

Truth comes from closed forms and invariants (`longball.model.exact`), from an extrapolation method
in mpmath that is written here, and for whole at-bats from `tests/oracle.py`.
"""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import replace
from fractions import Fraction

import flint
import mpmath
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st
from longball.model.motion import Forces, PlaneState, acceleration

from longball.engines import enclosure
from longball.engines.chain import solve, solve_with_restitutions
from longball.engines.enclosure import Balls, Enclosure
from longball.engines.engine import Stops
from longball.engines.ivp import Ivp
from longball.model import exact
from longball.model.exact import METHODS
from longball.model.numbers import Undecided
from longball.model.readings import Reading
from longball.model.result import Bounded
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    ImpactScene,
    Incoming,
    Launch,
    Pitch,
    PitchScene,
    Swing,
)
from tests import oracle

ENGINE = Enclosure(30)


def numbers_of(value, key=""):
    """Yield key and number of everything in a result."""
    if isinstance(value, Bounded | float | arb):
        yield key, value
    elif isinstance(value, (tuple, list)):
        for index, one in enumerate(value):
            yield from numbers_of(one, f"{key}[{index}]")
    elif value is not None and not isinstance(value, str):
        fields = value if isinstance(value, dict) else dict(value)
        for name, one in fields.items():
            yield from numbers_of(one, f"{key}.{name}")


def distance(bounded: Bounded, truth: Fraction) -> Fraction:
    return abs(Fraction(bounded.value) - truth)


def fraction(x: arb) -> Fraction:
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def flight(height=1.0, velocity=(30.0, 0.0, 30.0), **blocks):
    launch = Launch(position=(0.0, 0.0, height), velocity=velocity)
    return FlightScene(id="x", launch=launch, **blocks)


def at_bat(**blocks):
    return AtBatScene(id="x", **blocks)


def sampled(count: int, seed: int):
    """At-bats from the paper's distributions."""
    draw = random.Random(seed)
    for _ in range(count):
        mean, spread = (139.1, 4.58) if draw.random() < 0.45 else (127.8, 7.80)
        cell = draw.gauss(2 if draw.random() < 0.52 else 4, 0.77)
        yield at_bat(
            pitch=Pitch(speed=draw.gauss(mean, spread) / 3.6, aim=((cell - 3) * 0.144, 1.8)),
            swing=Swing(
                tilt=math.radians(draw.uniform(0, 10)), height_offset=draw.gauss(0, 0.0366)
            ),
        )


# --- numbers --------------------------------------------------------------------------------------


@given(
    st.floats(allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30),
    st.floats(min_value=0, max_value=1e3),
    st.sampled_from([1, 3, 7]),
    st.integers(-60, 60),
    st.sampled_from([1, 7, 30]),
)
def test_a_report_contains_the_ball(middle, radius, divisor, power, digits):
    balls = Balls(digits)
    with balls.arithmetic():
        x = (arb(middle) / divisor + arb(0, radius)) * arb(10) ** power
        report = balls.report(x)
        far = fraction(x.rad())
    assert distance(report, fraction(x)) + far <= Fraction(report.radius)
    digits_written = report.value.lower().split("e")[0].lstrip("-0.").replace(".", "")
    assert len(digits_written) <= digits + 2


def test_a_report_is_as_narrow_as_its_digits():
    with ENGINE.numbers.arithmetic():
        report = ENGINE.numbers.report(arb(2).sqrt())
    assert report.value == "1.414213562373095048801688724210"
    assert float(report.radius) < 0.5e-30
    assert ENGINE.numbers.report(arb(0)) == Bounded(value="0", radius="0")
    assert ENGINE.numbers.report(arb(-60)).radius == "0"


def test_only_a_proven_sign_is_told():
    balls, nothing = Balls(30), arb(0)
    assert balls.positive(arb(1, 0.5), nothing, "?")
    assert not balls.positive(arb(-1, 0.5), nothing, "?")
    assert not balls.positive(nothing, nothing, "?")
    for x in (arb(1, 2), arb(0, 1e-300), arb("nan")):
        with pytest.raises(Undecided, match="whether it rains cannot be decided with 30 digits"):
            balls.positive(x, nothing, "whether it rains")


def test_engines_of_different_digits_do_not_meet():
    few, many = Enclosure(20), Enclosure(60)
    scenes = [at_bat(), flight(), PitchScene(id="x")]
    alone = [[solve(scene, engine) for scene in scenes] for engine in (few, many)]
    before = flint.ctx.prec
    for scene, *expected in zip(scenes, *alone, strict=True):
        assert [solve(scene, few), solve(scene, many)] == expected
    assert flint.ctx.prec == before
    assert few.numbers.bits < many.numbers.bits


def test_no_digits_are_refused():
    with pytest.raises(ValueError, match="digits = 0"):
        Enclosure(0)


# --- exact results lie inside ---------------------------------------------------------------------


def forces(drag=None, lift=None, gravity=9.8, always_up=False):
    return Forces(
        *(None if k is None else arb(k) for k in (drag, lift, gravity)), always_up=always_up
    )


def state(s, z, u, w):
    return PlaneState(arb(s), arb(z), arb(u), arb(w))


def same(found, truth, width=1e-30):
    """Tell whether two balls have something in common, and the first is narrow."""
    return found.overlaps(truth) and found.rad() <= width * max(1, abs(truth).upper())


def to_floor(start, field, limit=60.0):
    return ENGINE.fly(start, field, Stops(time_limit=arb(limit), floor=arb(0)))


@pytest.fixture
def _precise():
    with Balls(60).arithmetic():
        yield


@pytest.mark.usefixtures("_precise")
class TestExactResults:
    """Closed forms to 60 digits against enclosures of 30."""

    def test_parabola(self):
        start = state(0, 1, 30, 20)
        arrival = to_floor(start, forces())
        truth = exact.parabola_to_floor(start, arb(9.8), arb(0), METHODS)
        assert same(arrival.time, truth.time)
        assert all(map(same, arrival.state, truth.state))

    @pytest.mark.parametrize("up", [0.5, 25.0, 300.0])
    def test_straight_up_and_down(self, up):
        # The ball comes to rest at its apex, V = 0, where the speed is not smooth.
        drag, gravity, start = arb(0.0075), arb(9.8), state(0, 1, 0, up)
        arrival = to_floor(start, forces(drag))
        top = exact.apex(start, drag, gravity, METHODS)
        truth = exact.fall_to_floor(top.state, drag, gravity, arb(0), METHODS)
        assert same(arrival.time, top.time + truth.time)
        assert same(arrival.state.w, truth.state.w)
        assert arrival.state.s == 0
        assert arrival.state.u == 0

    @pytest.mark.parametrize("lift", [None, 0.0037, -0.3])
    def test_without_weight(self, lift):
        start, field = state(0, 1, 30, 20), forces(0.0075, lift, None)
        arrival = ENGINE.fly(start, field, Stops(time_limit=arb(5)))
        assert arrival.stop == "time"
        assert all(map(same, arrival.state, exact.weightless(start, field, arb(5), METHODS)))

    @pytest.mark.parametrize("drag", [0.0075, 0.2])
    def test_drag_alone(self, drag):
        start = state(0, 1, 30, 20)
        arrival = to_floor(start, forces(drag))
        values = (
            exact.drag_only_invariant(there, arb(drag), arb(9.8), METHODS)
            for there in (arrival.state, start)
        )
        assert same(*values)

    @pytest.mark.parametrize("lift", [0.0037, 0.05, -0.02])
    def test_lift_alone(self, lift):
        # With 0.05 the ball loops.
        start = state(0, 30, 25, 5)
        arrival = to_floor(start, forces(None, lift), limit=10.0)
        energies = (exact.energy(there, arb(9.8)) for there in (arrival.state, start))
        assert same(*energies)
        values = (
            exact.phugoid(there, arb(lift), arb(9.8), METHODS) for there in (arrival.state, start)
        )
        assert same(*values)


# --- an independent method agrees -----------------------------------------------------------------


class Mpf:
    """As much of a number system as the equations of motion ask for."""

    exact = staticmethod(mpmath.mpf)
    sqrt = staticmethod(mpmath.sqrt)


def extrapolated(start, field, time, steps):
    """Fly by Gragg's method, extrapolated in the square of its step to the order 24."""
    accelerate = acceleration(field, Mpf)

    def rate(y):
        return mpmath.matrix([y[2], y[3], *accelerate(y[2], y[3])])

    y, big = mpmath.matrix(list(start)), time / steps
    for _ in range(steps):
        rows = []
        for j in range(1, 13):
            h = big / (2 * j)
            before, now = y, y + h * rate(y)
            for _ in range(2 * j - 1):
                before, now = now, before + 2 * h * rate(now)
            row = [(before + now + h * rate(now)) / 2]
            for k in range(1, j):
                ratio = (mpmath.mpf(j) / (j - k)) ** 2
                row.append(row[-1] + (row[-1] - rows[-1][k - 1]) / (ratio - 1))
            rows.append(row)
        y = rows[-1][-1]
    return y


@pytest.mark.parametrize(
    ("drag", "lift", "velocity"),
    [(0.0075, 0.00375, (30.0, 25.0)), (0.0075, -0.03, (0.5, 30.0)), (0.005, 0.05, (40.0, 3.0))],
)
def test_a_flight_holds_what_extrapolation_finds(drag, lift, velocity):
    arrival = ENGINE.fly(state(0, 1, *velocity), forces(drag, lift), Stops(time_limit=arb(2)))
    with mpmath.workdps(55):
        field = Forces(*map(mpmath.mpf, (drag, lift, 9.8)), always_up=False)
        start = tuple(map(mpmath.mpf, (0, 1, *velocity)))
        rough, fine = (extrapolated(start, field, mpmath.mpf(2), steps) for steps in (24, 36))
        for found, near, true in zip(arrival.state, rough, fine, strict=True):
            middle = fraction(found)
            off = abs(mpmath.mpf(middle.numerator) / middle.denominator - true)
            # Steps shorter by a third divide the error by 1.5^24: what is left is less than the
            # thousandth part of what was won.
            assert off <= float(found.rad()) + abs(near - true) / 1000
            assert off < 1e-36


AT_BATS = [at_bat(), at_bat(swing=Swing(height_offset=-0.03)), *sampled(6, seed=3)]
REGULAR = [
    *AT_BATS,
    at_bat(air=None),
    at_bat(air=Air(lift_coefficient=0.0), swing=Swing(height_offset=0.2)),
    at_bat(pitch=Pitch(aim=(0.6, 1.8))),
    flight(velocity=(20.0, 10.0, 25.0)),
    flight(height=0.0, velocity=(20.0, 10.0, 25.0), air=Air(lift_coefficient=0.6)),
    PitchScene(id="x"),
    ImpactScene(
        id="x",
        incoming=Incoming(position=(0.0696, 0.1, 0.8), velocity=(-35.0, 0.2, -3.0), bat_height=0.8),
    ),
]


@pytest.mark.parametrize("scene", REGULAR)
def test_results_hold_what_the_oracle_finds(scene):
    found = solve(scene, ENGINE)
    truth = dict(numbers_of(oracle.solve(scene.model_dump() | {"reading": {}})))
    numbers = dict(numbers_of(found))
    assert numbers.keys() == truth.keys()
    for key, bounded in numbers.items():
        # The oracle is good to 40 digits, relative to the at-bat's lengths, speeds and times.
        off = distance(bounded, fraction(truth[key]))
        assert off <= Fraction(bounded.radius) + Fraction(1, 10**36), key


@pytest.mark.parametrize("scene", REGULAR)
def test_regular_scenes_are_good_to_all_digits(scene):
    for key, bounded in numbers_of(solve(scene, ENGINE)):
        value, radius = Fraction(bounded.value), Fraction(bounded.radius)
        # A component that is zero but for a cancellation has no relative error: take 1 micrometre.
        assert radius <= Fraction(1, 10**30) * max(abs(value), Fraction(1, 10**6)), key


@pytest.mark.parametrize("scene", REGULAR)
def test_more_digits_lie_within_fewer(scene):
    results = [dict(numbers_of(solve(scene, Enclosure(digits)))) for digits in (10, 25, 60)]
    for wide, narrow in itertools.pairwise(results):
        for key, bounded in narrow.items():
            off = distance(wide[key], Fraction(bounded.value))
            assert off + Fraction(bounded.radius) <= Fraction(wide[key].radius), key


UP = Reading(lift_direction="always_up")


@pytest.mark.parametrize(
    "scene",
    [
        *REGULAR,
        flight(reading=UP, velocity=(1.0, 0.0, 30.0)),
        flight(reading=UP, velocity=(0.0, 0.0, 30.0)),
        flight(velocity=(0.0, 0.0, 30.0)),
        flight(velocity=(0.0, 0.0, 0.0)),
        flight(velocity=(0.0, 0.0, 0.0), air=Air(lift_coefficient=0.0)),
        flight(velocity=(1e-9, 0.0, 30.0), air=Air(lift_coefficient=0.0)),
        flight(air=Air(lift_coefficient=-0.5), reading=UP, velocity=(0.5, 0.0, 30.0)),
        flight(height=0.0, velocity=(0.0, 0.0, 0.0)),
        flight(height=0.0, velocity=(10.0, 0.0, 0.0)),
        flight(height=0.0, velocity=(60.0, 0.0, 0.0)),
        flight(height=0.0, velocity=(10.0, 0.0, 0.0), air=None, gravity=0.0),
        flight(air=Air(lift_coefficient=3.0), velocity=(40.0, 0.0, 5.0)),
        flight(air=Air(lift_coefficient=3.0), velocity=(40.0, 0.0, 5.0), time_limit=3.0),
        flight(air=Air(density=100.0), velocity=(300.0, 0.0, 10.0)),
        flight(gravity=300.0),
        flight(air=None, gravity=0.0),
        flight(ball=Ball(mass=1e-5)),
        PitchScene(id="x", pitch=Pitch(speed=10.0)),
        PitchScene(id="x", time_limit=0.1),
        at_bat(reading=UP),
        at_bat(reading=Reading(ground_contact="surface")),
        at_bat(gravity=0.0),
        at_bat(pitch=Pitch(release=(0.07, 0.0, 1.8))),
        at_bat(swing=Swing(angular_speed=-90.0)),
    ],
)
def test_doubles_agree(scene):
    found, doubles = solve(scene, ENGINE), solve(scene, Ivp())
    assert found.error is None
    assert found.outcome == doubles.outcome
    truth = dict(numbers_of(found))
    for key, number in numbers_of(doubles):
        # The ivp engine's error: 1e-11 m on a baseball's flight, 1e-13 of what is larger.
        true = float(truth[key].value)
        assert number == pytest.approx(true, rel=1e-12, abs=2e-11), key


# --- what is hard ---------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [3, 9, 15])
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_graze_is_decided(exponent, side, sign):
    scene = at_bat()
    with oracle.in_digits(40):
        throw = oracle.Throw(scene.model_dump())
        offset = throw.offset_for(sign * 10.0**-exponent, side)
        margin = throw.margin(offset)
        assert sign * margin > 0
    found = solve(at_bat(swing=Swing(height_offset=offset)), ENGINE)
    assert found.error is None
    assert (found.outcome == "missed") == (sign < 0)
    radius = Fraction(found.contact.margin.radius)
    assert distance(found.contact.margin, fraction(margin)) <= radius + Fraction(1, 10**36)
    if exponent == 15:
        assert "cannot be decided" in solve(at_bat(swing=Swing(height_offset=offset)), Ivp()).error


STRAIGHT = {"air": None, "gravity": 0.0, "ball": Ball(radius=0.0625), "bat": Bat(radius=0.03125)}


def test_an_exact_graze_is_open():
    scene = at_bat(**STRAIGHT, swing=Swing(height_offset=0.09375))
    found = solve(scene, ENGINE)
    assert found.outcome is None
    assert "whether the ball touches the bat cannot be decided with 30 digits" in found.error
    assert found.plate is not None
    assert abs(float(found.contact.margin.value)) <= float(found.contact.margin.radius)


def test_a_touching_at_the_release():
    touching = at_bat(**STRAIGHT, pitch=Pitch(release=(0.09375, 0.0, 1.8)))
    found = solve(touching, ENGINE)
    assert found.error is None
    assert distance(found.contact.time, Fraction(0)) <= Fraction(found.contact.time.radius)
    within = at_bat(**STRAIGHT, pitch=Pitch(release=(0.0937, 0.0, 1.8)))
    assert "the ball starts inside the bat" in solve(within, ENGINE).error


def test_the_release_may_be_the_closest_approach():
    # The ball falls away from a bat that is swung above it.
    scene = at_bat(
        pitch=Pitch(release=(0.08, 0.0, 1.8), aim=(0.0, 1.2)), swing=Swing(height_offset=1.0)
    )
    found = solve(scene, ENGINE)
    height = float(found.plate.position[2].value) + 1.0
    assert found.outcome == "missed"
    assert float(found.contact.margin.value) == pytest.approx(
        0.0696 - math.hypot(0.08, 1.8 - height), abs=1e-14
    )


@pytest.mark.parametrize(
    ("question", "scene"),
    [
        (
            "whether the ball touches the ground",
            flight(height=0.0, velocity=(1.0, 0.0, 50.0), air=None, gravity=10.0, time_limit=10.0),
        ),
        (
            "whether the ball touches the ground or the ball reaches the plate first",
            PitchScene(
                id="x",
                air=None,
                gravity=32.0,
                pitch=Pitch(speed=8.0, release=(8.0, 0.0, 16.0), aim=(0.0, 16.0)),
            ),
        ),
    ],
)
def test_a_tie_is_open(question, scene):
    assert f"{question} cannot be decided" in solve(scene, ENGINE).error


def test_a_hair_from_separating_is_told():
    # V·n - V_b·n, where V is the double next to 17 cos 0.3 m/s, and V_b·n = 17 cos 0.3 m/s.
    speed = 17.0 * math.cos(0.3)
    incoming = Incoming(position=(0.0696, 0.0, 1.0), velocity=(speed, 0.0, 0.0), bat_height=1.0)
    scene = ImpactScene(id="x", swing=Swing(tilt=0.3), incoming=incoming)
    found = solve(scene, ENGINE)
    with Balls(30).arithmetic():
        truth = arb(speed) - 17 * arb(0.3).cos()
    assert 0 < abs(truth) < 1e-14
    assert found.outcome == ("struck" if truth < 0 else "separating")


def test_a_landing_at_a_round_time():
    # 15 s is where halving the time limit comes to.
    found = solve(
        flight(height=0.0, velocity=(1.0, 0.0, 75.0), air=None, gravity=10.0), ENGINE
    ).landing
    assert distance(found.time, Fraction(15)) <= Fraction(found.time.radius)


@pytest.mark.parametrize("side", [-1, 1])
def test_a_dip_that_touches_the_ground_by_a_hair(side):
    # A dive that strong lift turns up again. Height enters no force: the depth of the dive is the
    # same from any height.
    drag, lift = 0.005, 0.2
    with mpmath.workdps(40):
        field = Forces(*map(mpmath.mpf, (drag, lift, 9.8)), always_up=False)
        start = tuple(map(mpmath.mpf, (0, 0, 40, -5)))
        accelerate = acceleration(field, Mpf)
        time = mpmath.mpf("0.06")
        for _ in range(7):
            bottom = extrapolated(start, field, time, steps=2)
            time -= bottom[3] / accelerate(bottom[2], bottom[3])[1]
        depth = -bottom[1]
        assert 0.03 < depth < 0.05
        height = float(depth) * (1 + side * 1e-13)
        assert side * (height - depth) > 1e-15
    arrival = to_floor(state(0, height, 40, -5), forces(drag, lift), limit=0.2)
    assert arrival.stop == ("floor" if side < 0 else "time")
    assert side > 0 or abs(float(arrival.time) - float(time)) < 1e-6


def test_restitutions_share_a_pitch():
    scene = at_bat()
    results = solve_with_restitutions(scene, [0.41, 0.42], ENGINE)
    assert results[1] == solve(scene, ENGINE)
    assert results[0].contact == results[1].contact


# --- a wrong bound would be found out -------------------------------------------------------------


def polynomial_in_time(coefficients):
    return flint.arb_poly([arb(float(c)) for c in coefficients])


@pytest.mark.parametrize("which", ["u", "w", "speed"])
def test_the_defect_is_bounded_whatever_the_polynomials(which):
    # Each of the three terms is the one that counts: a wrong u, a wrong w, and a pair that solves
    # the equations with a wrong speed, p' = -V̂ A p - g e_z.
    drag, lift, gravity, assumed = 0.0075, 0.0037, 9.8, 50.0
    u, w = [30.0, -400.0], [20.0, 300.0]
    rate_u = assumed * (drag * u[0] + lift * w[0])
    rate_w = assumed * (drag * w[0] - lift * u[0]) + gravity
    u[1] = -rate_u if which != "u" else 5.0
    w[1] = -rate_w if which != "w" else 5.0
    speed = [assumed if which == "speed" else math.hypot(u[0], w[0])]
    h = 1e-6  # s; so short that only the first terms count, as if the rest were exact
    with Balls(30).arithmetic():
        misses = enclosure._misses(
            *map(polynomial_in_time, (u, w, speed)), arb(drag), arb(lift), arb(gravity)
        )
        bound = float(enclosure._largest(misses, arb(h)))
    accelerate = acceleration(Forces(drag, lift, gravity, always_up=False), Ivp().numbers)
    for t in (0.0, h):
        du, dw = accelerate(u[0] + u[1] * t, w[0] + w[1] * t)
        missed = math.hypot(u[1] - du, w[1] - dw)
        assert bound / 5 < missed <= bound


@pytest.mark.parametrize("order", [2, 4, 8])
def test_a_step_of_low_order_keeps_its_bound(monkeypatch, order):
    balls, field = Balls(30), forces(0.0075, 0.00375)
    monkeypatch.setattr(enclosure, "_TOLERANCE", 1e-6 * 2.0**balls.bits)
    monkeypatch.setattr(enclosure, "_ORDER_PER_BIT", order / balls.bits)
    with balls.arithmetic():
        start = enclosure.Core(arb(30), arb(25), arb(0))
        step = enclosure._motion(start, field, arb(60), balls.bits)
    monkeypatch.undo()
    h = step.length
    arrival = ENGINE.fly(state(0, 1, 30, 25), field, Stops(time_limit=h))
    with balls.arithmetic():
        off = ((step.u(h) - arrival.state.u) ** 2 + (step.w(h) - arrival.state.w) ** 2).sqrt()
        bound = step.early + step.late * h
        assert off <= bound
        # The defect grows as the order's power of the time; the bound takes its end for all of it.
        assert bound <= 4 * (order + 1) * off


@pytest.mark.parametrize("field", [(0.0075, 0.00375), (None, 0.1), (0.01, -0.5), (0.02, None)])
@pytest.mark.parametrize("launch", [(30.0, 20.0), (40.0, -5.0), (0.001, 0.0)])
def test_a_launch_that_is_a_ball_holds_the_flights_of_its_points(field, launch):
    # From rest, too: the third launch is not told from a ball at rest.
    (u, w), off = launch, 0.002
    stops, field = Stops(time_limit=arb(0.25)), forces(*field)
    wide = PlaneState(arb(0), arb(1), arb(u, off), arb(w, off))
    whole = Enclosure(5).fly(wide, field, stops).state
    for du, dw in itertools.product((-off, 0.0, off), repeat=2):
        one = ENGINE.fly(state(0, 1, u + du, w + dw), field, stops).state
        assert all(map(arb.contains, whole, one))


def test_a_ball_brought_to_rest_is_as_far_off_as_it_was_fast():
    with Balls(30).arithmetic():
        core = enclosure.Core(arb(0.003), arb(-0.004), arb(0.01))
        still = enclosure._brought_to_rest(core, arb(0))
        assert still.u == still.w == 0
        assert still.error >= arb(0.01) + arb(0.005)
        assert enclosure._brought_to_rest(replace(core, error=arb(0.001)), arb(0)).u == core.u


def test_a_speed_that_would_be_negative_is_not_believed(monkeypatch):
    # On the way up w is V; going on beyond the apex so, drag would push the ball down.
    guess = enclosure._guess
    monkeypatch.setattr(enclosure, "_guess", lambda *series: 3 * guess(*series))
    start, drag = state(0, 1, 0, 1), 0.0075
    arrival = to_floor(start, forces(drag))
    with Balls(60).arithmetic():
        top = exact.apex(start, arb(drag), arb(9.8), METHODS)
        truth = exact.fall_to_floor(top.state, arb(drag), arb(9.8), arb(0), METHODS)
        assert same(arrival.time, top.time + truth.time)


def landing(digits=30):
    stops = Stops(time_limit=arb(60), floor=arb(0))
    with Balls(60).arithmetic():
        field = forces(arb(3) / 400, arb(3) / 800)
    return Enclosure(digits).fly(state(0, 1, 30, 25), field, stops)


def overlap(one, other):
    return all(map(arb.overlaps, (one.time, *one.state), (other.time, *other.state)))


def allow(monkeypatch, fraction_of_speed):
    """Let a step be off by a fraction of the speed, instead of a few roundings."""
    monkeypatch.setattr(enclosure, "_TOLERANCE", fraction_of_speed * 2.0 ** Balls(30).bits)


@pytest.mark.parametrize("order_per_bit", [0.03, 0.06, 0.12])
def test_the_rest_of_the_series_is_not_forgotten(monkeypatch, order_per_bit):
    truth = landing(60)
    allow(monkeypatch, 1e-9)
    monkeypatch.setattr(enclosure, "_ORDER_PER_BIT", order_per_bit)
    assert overlap(landing(), truth)
    proven = enclosure._motion

    def careless(*arguments):
        return replace(proven(*arguments), early=arb(0), late=arb(0))

    monkeypatch.setattr(enclosure, "_motion", careless)
    assert not overlap(landing(), truth)


def test_a_wrong_recurrence_is_not_believed(monkeypatch):
    truth = landing(60)
    right = enclosure.extend

    def wrong(n, drag, lift, *others):
        right(n, drag * (1 + arb(2) ** -40), lift, *others)

    monkeypatch.setattr(enclosure, "extend", wrong)
    assert "no step can be proven" in solve(flight(), ENGINE).error
    allow(monkeypatch, 1e-9)
    found = landing()
    assert overlap(found, truth)
    assert found.state.s.rad() > 1e-13
