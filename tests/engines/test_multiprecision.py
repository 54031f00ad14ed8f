"""The multiprecision engine: closed forms, invariants, laws of any kind, and near ties."""

import pickle

import pytest

from longball.engines import event
from longball.engines.multiprecision import Multiprecision
from longball.model.law import PlaneState, law_with
from longball.model.result import Bounded
from longball.model.trace import ZERO, exp, log

ENGINE = Multiprecision(30)
NUMBERS = ENGINE.numbers
mp = NUMBERS.context
exact = NUMBERS.exact


def printed(x, digits=30):
    """The truth `x`, as the engine writes it if all of its digits are right."""
    return mp.nstr(x, digits, strip_zeros=False)


def plane_law(drag=None, lift=None, gravity=9.8):
    named = {"drag": drag, "lift": lift, "gravity": gravity}
    return law_with({name: exact(k) for name, k in named.items() if k is not None})


def launched(z, u, w):
    return PlaneState(exact(0.0), exact(z), exact(u), exact(w))


def ground(height=0.0):
    return event.ground(exact(0.0) + height, launched(1.0, 0.0, 0.0), NUMBERS)


# ---- laws of any kind ----------------------------------------------------------------------------


def height_law(force):
    """Return the law of an upward acceleration that is a function of the height."""

    def acceleration(motion, p):
        return ZERO, ZERO, p.strength * force(motion.position[2])

    return law_with({"strength": exact(1.0)}, (acceleration,))


@pytest.mark.parametrize(
    ("force", "potential"),
    [
        (lambda z: exp(-z), mp.exp),
        (lambda z: -log(z), lambda x: -x * mp.log(-x) + x),
        (lambda z: -4 * z, lambda x: 2 * x * x),
    ],
    ids=["exp", "log", "spring"],
)
def test_a_force_of_the_height_keeps_its_energy(force, potential):
    """Unlike drag, lift and weight it depends on the position."""
    law = height_law(force)
    start = launched(2.0, 3.0, -0.5)
    end = ENGINE.fly(law, start, [], exact(3.0)).state

    def energy(state):
        return state.w**2 / 2 + potential(-state.z)

    assert abs(energy(end) / energy(start) - 1) < mp.mpf(10) ** -37
    assert printed(end.s) == printed(exact(9.0))


def test_a_spring_swings():
    law = height_law(lambda z: -4 * z)
    flight = ENGINE.fly(law, launched(1.0, 3.0, 0.0), [ground()], exact(3.0))
    assert printed(flight.time) == printed(mp.pi / 4)
    assert printed(flight.state.w) == printed(exact(-2.0))


# ---- events --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def circle():
    """A flight without weight and drag: a circle of radius 1/k_L, here of 5 m."""
    law = plane_law(lift=0.2, gravity=None)
    # The curvature is the double 0.2, whose inverse is not quite 5.
    return launched(7.0, 0.0, -20.0), law, 7 - 1 / law.strengths["lift"]


@pytest.mark.parametrize(("above", "stop"), [(1e-30, "ground"), (-1e-30, "time")])
def test_a_dip_is_told_from_a_miss(circle, above, stop):
    start, law, bottom = circle
    floor = ground(bottom + exact(above))
    assert ENGINE.fly(law, start, [floor], exact(1.0)).stop == stop


@pytest.mark.parametrize("depth", [1e-3, 1e-9, 1e-18, 1e-30])
def test_a_dip_far_shorter_than_a_step_is_found(circle, depth):
    """The ball is under the ground for some sqrt(depth) of a step of about a second."""
    start, law, bottom = circle
    flight = ENGINE.fly(law, start, [ground(bottom + exact(depth))], exact(60.0))
    assert flight.stop == "ground"
    # The bottom is a quarter of the circle away, at 20 m/s on a radius of 1/k_L.
    early = mp.acos(1 - exact(depth) * law.strengths["lift"])
    assert abs(flight.time - (mp.pi / 2 - early) / (20 * law.strengths["lift"])) < 1e-20


# ---- the engine as an object ---------------------------------------------------------------------


def test_an_engine_travels_to_another_process():
    assert pickle.loads(pickle.dumps(ENGINE)) == ENGINE


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.0, "0.0"),
        (0.1, "0.10000"),
        (-1e-30, "-1.0000e-30"),
        (123456.0, "1.2346e+5"),
        (12345.0, "12345"),
    ],
)
def test_numbers_are_written_with_their_digits(x, text):
    """The pattern of `Bounded` is checked as it is made."""
    numbers = Multiprecision(5).numbers
    assert numbers.report(numbers.exact(x)) == Bounded(value=text)
