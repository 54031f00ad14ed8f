"""Scenes solved with any number of digits: closed forms, other solvers, proven digits."""

import re

import mpmath
import pytest

from longball import golden
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.model.result import Bounded
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Launch,
    Pitch,
    Swing,
)

ENGINE = Multiprecision(30)
NUMBERS = ENGINE.numbers
mp = NUMBERS.context
exact = NUMBERS.exact


def flight(velocity, position=(0.0, 0.0, 1.0), **blocks):
    return FlightScene(id="f", launch=Launch(position=position, velocity=velocity), **blocks)


def numbers_of(block):
    """Every number of a result, by the way to it, as it was written."""
    if isinstance(block, Bounded):
        return {"": block.value}
    if isinstance(block, float):
        return {"": block}
    if isinstance(block, tuple):
        parts = enumerate(block)
    elif block is None or isinstance(block, str):
        return {}
    else:
        parts = ((name, getattr(block, name)) for name in type(block).model_fields)
    return {f"{k}.{way}": x for k, part in parts for way, x in numbers_of(part).items()}


def printed(x, digits=30):
    """The truth `x`, as the engine writes it if all of its digits are right."""
    return mp.nstr(x, digits, strip_zeros=False)


# ---- closed forms: every digit -------------------------------------------------------------------


def test_parabola():
    landing = solve(flight((30.0, 0.0, 20.0), air=None), ENGINE).landing
    g = exact(9.8)
    time = (20 + mp.sqrt(400 + 2 * g)) / g
    assert landing.time.value == printed(time)
    assert landing.distance.value == printed(30 * time)
    assert landing.velocity[2].value == printed(20 - g * time)
    assert landing.position[2].value == "0.0"


# ---- other solvers, other precisions -------------------------------------------------------------


def test_agrees_with_a_taylor_solver():
    """mpmath's own, flown over the same time: it must come down where this engine lands."""
    at_bat = AtBatScene(id="t", swing=Swing(height_offset=-0.02))
    result = solve(at_bat, ENGINE)
    taylor = mpmath.MPContext()
    taylor.dps = 35

    air, ball = at_bat.air, at_bat.ball
    per_metre = (
        taylor.mpf(air.density)
        * taylor.pi
        * taylor.mpf(ball.radius) ** 2
        / 2
        / taylor.mpf(ball.mass)
    )
    drag, lift = (taylor.mpf(c) * per_metre for c in (air.drag_coefficient, air.lift_coefficient))
    gravity = taylor.mpf(at_bat.gravity)

    def motion(_, y):
        _, _, u, w = y
        speed = taylor.hypot(u, w)
        return [u, w, -speed * (drag * u + lift * w), -speed * (drag * w - lift * u) - gravity]

    x0, _, z0 = (taylor.mpf(p.value) for p in result.contact.position)
    u0, _, w0 = (taylor.mpf(v.value) for v in result.impact.velocity)
    assert at_bat.pitch.aim[0] == 0.0  # so that the flight is in the plane y = 0, along +x
    path = taylor.odefun(motion, 0, [x0, z0, u0, w0], degree=45)
    x, z, u, w = path(taylor.mpf(result.landing.hang_time.value))
    # The launch was read from 30 printed digits, and so is 1e-30 of a hundred metres off at most.
    for end, (found, truth) in {
        "x": (result.landing.position[0], x),
        "u": (result.landing.velocity[0], u),
        "w": (result.landing.velocity[2], w),
    }.items():
        assert abs(taylor.mpf(found.value) / truth - 1) < taylor.mpf(10) ** -28, end
    assert abs(z) < taylor.mpf(10) ** -27


def rounds_to(longer, shorter, digits):
    """True if `shorter` is `longer` rounded; or cut differently where the next digits are 49999…"""
    unit = mpmath.mpf(10)
    with mpmath.workdps(60):
        longer, shorter = mpmath.mpf(longer), mpmath.mpf(shorter)
        if longer == shorter:
            return True
        unit = unit ** (mpmath.floor(mpmath.log10(abs(longer))) + 1 - digits)
        return abs(longer - shorter) <= unit * (0.5 + 1e-6)


def test_doubles_cannot_tell_the_closest_grazes():
    """Which all digits of this engine do, in test_golden.py."""
    grazes = [c for c in golden.load("hard") if re.fullmatch("hard-graze-level-.*-1e-15", c.id)]
    assert {solve(case.scene, Ivp()).code for case in grazes} == {"undecided"}


@pytest.mark.nightly
def test_a_ball_that_almost_comes_to_rest_loses_no_digit():
    """V falls to 1e-9 m/s at the apex: the path is smooth, but only just."""
    scene = flight((1e-9, 0.0, 3.0), air=Air(lift_coefficient=0.0))
    few, many = (numbers_of(solve(scene, Multiprecision(digits))) for digits in (20, 30))
    for way in few:
        assert rounds_to(many[way], few[way], 20), way


def test_contact_at_the_release():
    """Sums of powers of two, in a vacuum without weight: the ball is released touching the bat."""
    scene = AtBatScene(
        id="a",
        ball=Ball(radius=0.03125),
        bat=Bat(radius=0.03125),
        air=None,
        gravity=0.0,
        pitch=Pitch(speed=32.0, release=(0.0625, 0.0, 1.5), aim=(0.0, 1.5)),
    )
    result = solve(scene, ENGINE)
    assert result.outcome == "batted" or result.outcome == "airborne"
    assert result.contact.time.value == "0.0"
    assert result.contact.margin.value == printed(mp.mpf(0.0625))


def test_engines_of_different_digits_do_not_meet():
    scene = AtBatScene(id="a")
    alone = solve(scene, Multiprecision(20))
    few, many = Multiprecision(20), Multiprecision(40)
    before = mpmath.mp.prec
    between = [solve(scene, engine) for engine in (few, many, few)]
    assert between[0] == between[2] == alone
    assert len(between[1].plate.time.value) == len("0.") + 40
    assert mpmath.mp.prec == before
