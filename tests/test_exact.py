"""The exact results, proved from the equations of motion.

The formulas are handed SymPy's symbols and the equations of motion as they are executed, so what
is proved is what runs.
"""

import math
from types import SimpleNamespace

import mpmath
import pytest
import sympy as sp

from longball.model.law import PlaneState, law_with
from tests import exact

T = sp.Symbol("t", positive=True)
DRAG, LIFT, GRAVITY, FLOOR = sp.symbols("k_D k_L g h", positive=True)
S, Z, W = sp.symbols("s z w", real=True)
U = sp.Symbol("u", positive=True)
STATE = PlaneState(S, Z, U, W)

SYMBOLIC = SimpleNamespace(
    sqrt=sp.sqrt,
    exp=sp.exp,
    expm1=lambda x: sp.exp(x) - 1,
    log=sp.log,
    log1p=lambda x: sp.log(1 + x),
    sin=sp.sin,
    cos=sp.cos,
    atan=sp.atan,
    sinh=sp.sinh,
    cosh=sp.cosh,
)
SYMBOLIC.functions = {"sqrt": sp.sqrt}


def field(drag=None, lift=None, gravity=None):
    """The accelerations as executed, in symbols."""
    strengths = {"drag": drag, "lift": lift, "gravity": gravity}
    rates = law_with({name: k for name, k in strengths.items() if k is not None}).rates(SYMBOLIC)
    return lambda u, w: rates(0, 0, u, w)[2:]


def residuals(path, accelerate):
    """Residuals s' - u, z' - w, and u' and w' less the accelerations, along a path."""
    s, z, u, w = path
    du, dw = accelerate(u, w)
    return [sp.diff(s, T) - u, sp.diff(z, T) - w, sp.diff(u, T) - du, sp.diff(w, T) - dw]


def vanishes(expression):
    return sp.simplify(expression) == 0


def rate(quantity, accelerate):
    """Derivative of a function of the state along a flight."""
    du, dw = accelerate(U, W)
    return (
        sp.diff(quantity, S) * U
        + sp.diff(quantity, Z) * W
        + sp.diff(quantity, U) * du
        + sp.diff(quantity, W) * dw
    )


# ---- closed forms --------------------------------------------------------------------------------


def test_the_parabola_solves_the_equations_without_air():
    path = exact.parabola(STATE, GRAVITY, T)
    assert all(map(vanishes, residuals(path, field(gravity=GRAVITY))))
    assert tuple(exact.parabola(STATE, GRAVITY, 0)) == tuple(STATE)


def test_the_parabola_lands_where_it_is_said_to():
    time, state = exact.parabola_to_floor(STATE, GRAVITY, FLOOR, SYMBOLIC)
    there = exact.parabola(STATE, GRAVITY, time)
    assert all(vanishes(a - b) for a, b in zip(there, state, strict=True))


STRAIGHT_UP = PlaneState(S, Z, sp.Integer(0), sp.Symbol("w", positive=True))
STRAIGHT_DOWN = PlaneState(S, Z, sp.Integer(0), sp.Symbol("w", negative=True))


@pytest.mark.parametrize(
    ("start", "formula", "sign"), [(STRAIGHT_UP, exact.rise, 1), (STRAIGHT_DOWN, exact.fall, -1)]
)
def test_vertical_flights_solve_the_equations(start, formula, sign):
    s, z, u, w = formula(start, DRAG, GRAVITY, T, SYMBOLIC)
    # With u = 0 the speed is |w|, which SymPy cannot know to be ±w along the path.
    assert (s, u) == (S, 0)
    assert vanishes(sp.diff(z, T) - w)
    assert vanishes(sp.diff(w, T) - (-sign * DRAG * w * w - GRAVITY))
    assert field(DRAG, None, GRAVITY)(sp.Integer(0), start.w)[1] == (
        -sign * DRAG * start.w**2 - GRAVITY
    )
    assert vanishes(z.subs(T, 0) - Z)
    assert vanishes(w.subs(T, 0) - start.w)


def test_the_apex_is_where_the_rise_ends():
    time, top = exact.apex(STRAIGHT_UP, DRAG, GRAVITY, SYMBOLIC)
    there = exact.rise(STRAIGHT_UP, DRAG, GRAVITY, time, SYMBOLIC)
    assert vanishes(there.w)
    assert vanishes(sp.logcombine(sp.simplify((there.z - top.z) * DRAG), force=True))
    assert top.w == 0


@pytest.mark.parametrize("w", [0, -1, -30, -80])
@pytest.mark.parametrize("depth", [1e-6, 1, 100])
def test_the_fall_ends_on_the_floor(w, depth):
    """In 30 digits; also from faster than the terminal speed, and after a micrometre."""
    with mpmath.workdps(30):
        start = PlaneState(*map(mpmath.mpf, (0, depth, 0, w)))
        drag, gravity = mpmath.mpf("0.005"), mpmath.mpf("9.8")
        time, end = exact.fall_to_floor(start, drag, gravity, mpmath.mpf(0), mpmath.mp)
        there = exact.fall(start, drag, gravity, time, mpmath.mp)
        assert abs(there.z) < 1e-26
        assert abs(there.w - end.w) < 1e-26
    # In doubles, too, the time has all its digits, in particular after a short fall.
    double = exact.fall_to_floor(PlaneState(0.0, depth, 0.0, float(w)), 0.005, 9.8, 0.0, math)
    assert double.time == pytest.approx(float(time), rel=1e-14)
    assert double.state.w == pytest.approx(float(end.w), rel=1e-14)


@pytest.mark.parametrize("drag", [None, DRAG])
@pytest.mark.parametrize("lift", [None, LIFT, -LIFT])
@pytest.mark.sampled(every=2)
def test_the_weightless_turn_solves_the_equations(drag, lift):
    start = PlaneState(S, Z, sp.Integer(3), sp.Integer(4))  # V = 5, so that no root is left
    path = exact.weightless(start, drag, lift, T, SYMBOLIC)
    speed = 5 if drag is None else 5 / (1 + 5 * DRAG * T)
    s, z, u, w = path
    assert vanishes(u * u + w * w - speed**2)
    k_d, k_l = drag or 0, lift or 0
    # The equations of motion with V as just proved: SymPy does not take the root of the square.
    wanted = u, w, -speed * (k_d * u + k_l * w), -speed * (k_d * w - k_l * u)
    assert all(vanishes(sp.diff(x, T) - rate) for x, rate in zip(path, wanted, strict=True))
    assert all(vanishes(x.subs(T, 0) - x0) for x, x0 in zip(path, start, strict=True))
    if lift:
        centre = S - sp.Rational(4, 5) / lift, Z + sp.Rational(3, 5) / lift
        assert vanishes((s - centre[0]) ** 2 + (z - centre[1]) ** 2 - 1 / lift**2)


def test_a_feather_falls_for_long():
    """exp(k_D h) would not fit a double: 10 km at the terminal speed of 3 cm/s, give or take."""
    terminal = math.sqrt(9.8 / 1e4)
    time, end = exact.fall_to_floor(PlaneState(0.0, 1e4, 0.0, 0.0), 1e4, 9.8, 0.0, math)
    assert end.w == pytest.approx(-terminal, rel=1e-15)
    assert time == pytest.approx(1e4 / terminal, rel=1e-7)


# ---- invariants and balance laws -----------------------------------------------------------------


def test_energy_and_phugoid_are_constant_without_drag():
    for quantity in (exact.energy(STATE, GRAVITY), exact.phugoid(STATE, LIFT, GRAVITY, SYMBOLIC)):
        assert vanishes(rate(quantity, field(None, LIFT, GRAVITY)))
        assert not vanishes(rate(quantity, field(DRAG, LIFT, GRAVITY)))


def test_with_drag_they_change_at_the_stated_rates():
    everything = field(DRAG, LIFT, GRAVITY)
    energy_rate = exact.energy_rate(STATE, DRAG, SYMBOLIC)
    assert vanishes(rate(exact.energy(STATE, GRAVITY), everything) - energy_rate)
    phugoid_rate = exact.phugoid_rate(STATE, DRAG, LIFT, GRAVITY, SYMBOLIC)
    phugoid = exact.phugoid(STATE, LIFT, GRAVITY, SYMBOLIC)
    assert vanishes(rate(phugoid, everything) - phugoid_rate)
