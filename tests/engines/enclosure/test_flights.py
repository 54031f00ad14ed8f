"""Flights with proven bounds, under the paper's law and others: the bounds hold the truth.

Under the laws of scenes the golden data and the oracle tell: here are closed forms, and each bound.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from flint import arb, arb_poly

from longball.engines.enclosure import Balls, Enclosure, engine
from longball.engines.enclosure.system import System, structure
from longball.engines.engine import CannotSolve
from longball.engines.event import ground
from longball.model.law import PlaneState, law_with
from longball.model.trace import exp, sqrt, trace
from tests import exact
from tests.exact import METHODS

ENGINE = Enclosure(30)


def law(drag=None, lift=None, gravity=9.8):
    named = {"drag": drag, "lift": lift, "gravity": gravity}
    return law_with({name: arb(k) for name, k in named.items() if k is not None})


def state(s, z, u, w):
    return PlaneState(arb(s), arb(z), arb(u), arb(w))


def same(found, truth, width=1e-30):
    """True if two balls have something in common, and the first is narrow."""
    return found.overlaps(truth) and found.rad() <= width * max(1, abs(truth).upper())


def fly(start, field, limit, solver=ENGINE, events=()):
    with solver.numbers.arithmetic():
        return solver.fly(field, start, list(events), arb(limit))


def to_floor(start, field, limit=60.0, solver=ENGINE):
    with solver.numbers.arithmetic():
        floor = ground(arb(0), start, solver.numbers)
    return fly(start, field, limit, solver, [floor])


@pytest.fixture(autouse=True)
def _precise():
    with Balls(60).arithmetic():
        yield


# --- closed forms to 60 digits against enclosures of 30 -------------------------------------------


@pytest.mark.parametrize("up", [0.5, 25.0, 300.0])
def test_straight_up_and_down(up):
    # The ball comes to rest at its apex, V = 0, where the speed is not smooth.
    drag, gravity, start = arb(0.0075), arb(9.8), state(0, 1, 0, up)
    arrival = to_floor(start, law(drag))
    top = exact.apex(start, drag, gravity, METHODS)
    truth = exact.fall_to_floor(top.state, drag, gravity, arb(0), METHODS)
    assert same(arrival.time, top.time + truth.time)
    assert same(arrival.state.w, truth.state.w)
    assert arrival.state.s == 0
    assert arrival.state.u == 0


def test_from_rest():
    start, drag, gravity = state(0, 100, 0, 0), arb(0.0075), arb(9.8)
    upright = to_floor(start, law(drag))
    truth = exact.fall_to_floor(start, drag, gravity, arb(0), METHODS)
    assert same(upright.time, truth.time)
    # A lift that does next to nothing, so that the law has a root, and the series starts from rest.
    lifted = to_floor(start, law(drag, arb(1e-60)))
    assert same(lifted.time, truth.time)
    assert same(lifted.state.w, truth.state.w)


# --- other laws -----------------------------------------------------------------------------------


def test_where_a_law_is_not_defined_no_step_is_taken():
    def root(motion, p):
        return 0.0, 0.0, -p.k * sqrt(motion.position[2])

    field = law_with({"k": arb(4.0)}, (root,))
    # It falls to z = 0 in 1 s or so.
    with pytest.raises(CannotSolve):
        fly(state(0, 1, 1, -1), field, 5)


def dense_air(motion, p):
    """-k V v e^(-z/H): forces depend on the height, which belongs to the core then."""
    thickness = p.dense * exp(p.inverse_height * motion.position[2])
    return tuple(-(thickness * motion.speed) * x for x in motion.velocity)


# --- growth of errors -----------------------------------------------------------------------------


def shear(motion, p):
    """A linear law, u' = c w: nearby flights part at the rate c/2 at most."""
    return p.shear * motion.velocity[2], 0.0, 0.0


def bound_and_separations(field, velocity, error, h, directions=32):
    """Return the growth of an error in h s by a bound, and the separation of flights.

    Both as a multiple of the error at the start, one separation for each of the directions.
    """
    with ENGINE.numbers.arithmetic():
        system = System(field, ENGINE.numbers)
        core = engine.Start(tuple(map(arb, velocity)), arb(error))
        motion = engine.proven(system, core, arb(h), ENGINE.numbers.bits)
    assert motion.length >= h
    grown = (motion.early + motion.late * motion.length) / error
    fine = Enclosure(40)
    true = fly(state(0, 0, *velocity), field, h, fine).state
    separations = []
    for turn in range(directions):
        angle = 2 * math.pi * turn / directions
        u, w = velocity[0] + error * math.cos(angle), velocity[1] + error * math.sin(angle)
        other = fly(state(0, 0, u, w), field, h, fine).state
        offset = math.hypot(u - velocity[0], w - velocity[1])
        apart = math.hypot(float(other.u - true.u), float(other.w - true.w))
        separations.append(apart / offset)
    return float(grown), max(separations)


@pytest.mark.parametrize(
    ("field", "share"),
    [
        ({"lift": 0.1}, 0.9),
        ({"drag": 0.01, "lift": 0.1, "gravity": 9.8}, 0.9),
        ({"drag": 0.005, "lift": 0.03, "gravity": 9.8}, 0.8),
        ({"shear": 2.0, "gravity": 9.8}, 0.95),
    ],
    ids=["lift", "lift-and-drag", "weak", "shear"],
)
@pytest.mark.sampled(every=3)
def test_growth_is_nearly_attained(field, share):
    # In so short a time that the directions of growth hardly turn: the logarithms are as the rates.
    field = law_with({n: arb(k) for n, k in field.items()}, (shear,) if "shear" in field else ())
    bound, separation = bound_and_separations(field, (30.0, 20.0), 2.0**-20, 2.0**-10)
    assert share * math.log(bound) <= math.log(separation) <= math.log(bound)


@pytest.mark.parametrize("error", [1.0, 10.0, 20.0])
@pytest.mark.sampled(every=2)
def test_growth_is_that_of_the_fastest_flight_in_the_tube(error):
    field = law(None, 0.1, None)
    bound, separation = bound_and_separations(field, (20.0, 0.0), error, 2.0**-7)
    assert separation <= bound
    if error == 20.0:
        # More than the rate k_L V / 2 at the speed of the flight itself has it.
        assert math.log(separation) > 0.1 * 20 / 2 * 2.0**-7


@pytest.mark.parametrize("bits", [64, 164])
def test_growth_is_summed_over_the_parts_of_a_step(bits):
    # V = a t: the integral of k_L V / 2 is k_L a h² / 4, though errors hardly grow at first.
    lift, a, h = 0.125, 64.0, 1.0
    with Balls(30).arithmetic():
        system = System(law(None, lift), Balls(30))
        motion = (arb_poly([]), arb_poly([0, -a]))
        growth = engine._growth(system, motion, arb(2) ** -bits, arb(h))
    truth = lift * a * h**2 / 4
    # A part of 1/128 of the step is as much too large as V changes on it, in each of four entries.
    assert truth <= math.log(float(growth)) <= 1.05 * truth


@pytest.mark.parametrize(
    ("field", "launch"),
    [
        ((0.0075, 0.00375), (30.0, 20.0)),
        ((None, 0.1), (40.0, -5.0)),
        ((0.01, -0.5), (30.0, 20.0)),
        ((0.02, None), (40.0, -5.0)),
        ((0.02, None), (0.001, 0.0)),  # not told from a ball at rest
    ],
)
@pytest.mark.sampled(every=3)
def test_a_launch_that_is_a_ball_holds_the_flights_of_its_points(field, launch):
    (u, w), off = launch, 0.002
    field = law(*field)
    wide = PlaneState(arb(0), arb(1), arb(u, off), arb(w, off))
    whole = fly(wide, field, 0.25, Enclosure(5)).state
    for du, dw in itertools.product((-off, 0.0, off), repeat=2):
        one = fly(state(0, 1, u + du, w + dw), field, 0.25).state
        assert all(map(arb.contains, whole, one))


def test_a_launch_that_is_a_ball_in_a_law_of_height():
    # e^(-z/8 m): an error in the height becomes one in the velocity.
    field = law_with({"dense": arb(0.02), "inverse_height": arb(-0.125)}, (dense_air,))
    off = 0.01
    wide = PlaneState(arb(0), arb(0, off), arb(20, off), arb(-8, off))
    whole = fly(wide, field, 0.25, Enclosure(5)).state
    for dz, du, dw in itertools.product((-off, off), repeat=3):
        one = fly(state(0, dz, 20 + du, -8 + dw), field, 0.25).state
        assert all(map(arb.contains, whole, one))
    high = PlaneState(arb(0), arb(0, off), arb(20), arb(-8))
    whole = fly(high, field, 0.25, Enclosure(5)).state
    for dz in (-off, off):
        assert all(map(arb.contains, whole, fly(state(0, dz, 20, -8), field, 0.25).state))


def test_a_start_is_off_by_the_radii_and_the_error():
    start = engine.start_of([arb(3, 0.25), arb(4, 0.5)], arb(1), (1.0, 2.0))
    assert start.state == (3, 4)
    assert 1 + math.hypot(0.25, 1.0) <= float(start.error) < 2.04


# --- steps ----------------------------------------------------------------------------------------


def test_linear_rates_of_unused_variables_are_integrated_apart():
    def rates(a, b, linear, product):
        return b, -a, 3 + 2 * a - b, 3 + a * b

    system = structure(trace(rates, ("a", "b", "linear", "product"), ()))
    assert {*system.quadratures} == {"linear"}
    assert system.core.variables == ("a", "b", "product")


def test_a_ball_brought_to_rest_is_as_far_off_as_it_was_fast():
    core = engine.Start((arb(0.003), arb(-0.004)), arb(0.01))
    drag = structure(law(0.01).program)
    still = engine.brought_to_rest(core, drag, arb(0))
    assert still.state == (0, 0)
    assert still.error >= arb(0.01) + arb(0.005)
    known = replace(core, error=arb(0.001))
    assert engine.brought_to_rest(known, drag, arb(0)) == known
    assert engine.brought_to_rest(known, drag, arb(0.1)).state == (0, 0)
    # Without a root nothing is special about rest.
    assert engine.brought_to_rest(core, structure(law().program), arb(0)) == core


def test_the_error_stays_in_the_tube_that_its_growth_was_bounded_on(monkeypatch):
    # Existence: growth by 10, and by ever more in a wider tube, which no tube is wide enough for.
    tubes = []

    def grown(factor):
        def growth(system, motion, tube, h):
            tubes.append(tube)
            return factor(tube)

        monkeypatch.setattr(engine, "_growth", growth)

    one = arb(1)
    grown(lambda tube: arb(10))
    early, late = engine._error(None, (), one, one, one)
    assert tubes[-1] > early + late >= 20
    grown(lambda tube: 10 * tube)
    with pytest.raises(CannotSolve, match="has grown"):
        engine._error(None, (), one, one, one)


@pytest.mark.parametrize("order", [2, 4, 8])
def test_a_step_of_low_order_keeps_its_bound(monkeypatch, order):
    balls, field = Balls(30), law(0.0075, 0.00375)
    monkeypatch.setattr(engine, "_TOLERANCE", 1e-6 * 2.0**balls.bits)
    monkeypatch.setattr(engine, "_ORDER_PER_BIT", order / balls.bits)
    with balls.arithmetic():
        start = engine.Start((arb(30), arb(25)), arb(0))
        step = engine.proven(System(field, balls), start, arb(60), balls.bits)
    monkeypatch.undo()
    h = step.length
    arrival = fly(state(0, 1, 30, 25), field, h)
    u, w = step.polynomials
    off = math.hypot(float(u(h) - arrival.state.u), float(w(h) - arrival.state.w))
    bound = float(step.early + step.late * h)
    assert off <= bound
    # The defect grows as the order's power of the time; the bound takes its end for all of it.
    assert bound <= 4 * (order + 1) * off


def test_a_speed_that_would_be_negative_is_not_believed(monkeypatch):
    # On the way up w is V; going on beyond the apex so, drag would push the ball down.
    guess = engine._guess
    monkeypatch.setattr(engine, "_guess", lambda *series: 3 * guess(*series))
    start, drag = state(0, 1, 1e-30, 1), arb(0.0075)
    arrival = to_floor(start, law(drag))
    top = exact.apex(start, drag, arb(9.8), METHODS)
    truth = exact.fall_to_floor(top.state, drag, arb(9.8), arb(0), METHODS)
    assert same(arrival.time, top.time + truth.time, 1e-27)


def landing(digits=30):
    field = law(arb(3) / 400, arb(3) / 800)
    return to_floor(state(0, 1, 30, 25), field, solver=Enclosure(digits))


def overlap(one, other):
    return all(map(arb.overlaps, (one.time, *one.state), (other.time, *other.state)))


def allow(monkeypatch, fraction_of_speed):
    """Let a step be off by a fraction of the speed, instead of a few roundings."""
    monkeypatch.setattr(engine, "_TOLERANCE", fraction_of_speed * 2.0 ** Balls(30).bits)


@pytest.mark.parametrize("order_per_bit", [0.03, 0.06, 0.12])
@pytest.mark.sampled(every=2)
def test_the_rest_of_the_series_is_not_forgotten(monkeypatch, order_per_bit):
    truth = landing(60)
    allow(monkeypatch, 1e-9)
    monkeypatch.setattr(engine, "_ORDER_PER_BIT", order_per_bit)
    assert overlap(landing(), truth)
    proven = engine.proven

    def careless(*arguments):
        return replace(proven(*arguments), late=arb(0))

    monkeypatch.setattr(engine, "proven", careless)
    assert not overlap(landing(), truth)


def test_a_wrong_recurrence_is_not_believed(monkeypatch):
    truth = landing(60)
    right = System.series

    def wrong(self, start, order, at_rest):
        series = right(self, start, order, at_rest)
        for row in series.values():
            row[1] *= 1 + arb(2) ** -40
        return series

    monkeypatch.setattr(System, "series", wrong)
    monkeypatch.setattr(engine, "_MOST_WORK", 2_000_000)
    # Steps so short that the wrong term does no harm take the flight nowhere.
    with pytest.raises(CannotSolve, match="more than"):
        landing()
    allow(monkeypatch, 1e-9)
    found = landing()
    assert overlap(found, truth)
    assert found.state.s.rad() > 1e-14
