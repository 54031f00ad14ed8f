"""A new force costs one function and one key of the scene: every engine then flies it.

A new law of a coefficient costs one class.
"""

import math
from typing import ClassVar, Literal

import mpmath
import numpy as np
import pytest

from longball.engines.batch import Batch, solve_columns
from longball.engines.chain import Model, solve
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import Verlet
from longball.model import trace
from longball.model.air import Coefficient
from longball.model.block import Positive
from longball.model.law import Force
from longball.model.result import Bounded
from longball.model.scene import Air, FlightScene, Launch


class ThickAir(Air):
    linear_drag: float = 0.0  # 1/s


class ThickFlight(FlightScene):
    air: ThickAir = ThickAir()


def strength(scene, frame, numbers):
    rate = scene.air.linear_drag
    return None if numbers.absent(rate) else {"linear_drag": numbers.exact(rate)}


def linear_drag(motion, p):
    """-c v"""
    u, v, w = (-p.linear_drag * component for component in motion.velocity)
    return u, v, w


MODEL = Model(forces=(Force(strength, linear_drag),))


def scene(velocity=(30.0, 3.0, 25.0), **air):
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=velocity)
    return ThickFlight(id="x", launch=launch, air=ThickAir(**air))


def aside(motion, p):
    """A constant push to the left, which drives the ball off its plane."""
    return 0, p.aside, 0


PUSH = 1.5  # m/s²
PUSHED = Model(
    forces=(*MODEL.forces, Force(lambda scene, frame, n: {"aside": n.exact(PUSH)}, aside))
)


# Without batch, which takes a model for columns only.
every_engine = pytest.mark.parametrize(
    ("engine", "error"),
    [
        *((e, e.flight_error) for e in (Ivp(), Ivp("DOP853"), Ivp("Radau"))),
        # Of a time in 30 digits, at 25 m/s.
        (Enclosure(30), 1e-28),
        (Multiprecision(30), 1e-28),
        (Verlet(5e-4, forces="implicit"), 1e-6),  # Δt² times a few hundred m/s²
    ],
    ids=["ivp", "ivp-dop853", "ivp-radau", "enclosure", "multiprecision", "verlet"],
)


@every_engine
def test_all_engines_have_the_closed_form(engine, error):
    rate = 0.25
    thick = scene((30.0, 0.0, 20.0), density=0.0, linear_drag=rate)
    check_closed_form(solve(thick, engine, PUSHED).landing, rate, PUSH, error)


def check_closed_form(landing, rate, push_aside, error):
    """r = r₀ + f t + (v₀ - f) (1 - e^(-ct))/c and v = v₀ e^(-ct) + f (1 - e^(-ct)), f = a/c."""
    start, velocity = (0.0, 0.0, 1.0), (30.0, 0.0, 20.0)
    with mpmath.workdps(40):
        c, t = mpmath.mpf(rate), digits(landing.time)
        faded = -mpmath.expm1(-c * t)
        found = [*map(digits, landing.position)], [*map(digits, landing.velocity)]
        pushes = 0.0, push_aside, -9.8
        for r0, v0, push, r, v in zip(start, velocity, pushes, *found, strict=True):
            final = push / c
            assert abs(r0 + final * t + (v0 - final) * faded / c - r) < error * max(1, abs(r))
            assert abs(v0 + (final - v0) * faded - v) < error * max(1, abs(v))


def digits(x):
    """Return a number of a result as mpmath's."""
    return mpmath.mpf(x.value if isinstance(x, Bounded) else x)


def test_columns_have_the_new_key():
    rates = np.array([0.0, 0.125, 0.25])
    table = solve_columns(scene(), {"air.linear_drag": rates}, model=MODEL)
    for i, rate in enumerate(rates.tolist()):
        alone = solve(scene(linear_drag=rate), Ivp(), MODEL).landing
        found = [table[f"landing.position[{k}]"][i] for k in range(3)]
        assert found == pytest.approx(alone.position, abs=1e-12)  # some ulps of 100 m


# --- a law of a coefficient -----------------------------------------------------------------------


class SlowDrag(Coefficient):
    """``C_D = b/U``, with which drag is linear in the velocity."""

    law: Literal["slow"] = "slow"
    speed: Positive = 20.0  # m/s, b

    nonlinear: ClassVar[tuple[str, ...]] = ()

    def drag(self, flow):
        return self.speed * trace.constant(1.0)


class SlowAir(Air):
    drag_coefficient: SlowDrag = SlowDrag()


class SlowFlight(FlightScene):
    air: SlowAir = SlowAir(lift_coefficient=0.0)


@pytest.mark.parametrize(
    ("engine", "error"), [*every_engine.args[1], (Batch(), Batch().flight_error)]
)
def test_all_engines_fly_a_new_law_of_a_coefficient(engine, error):
    rate = 1.29 * math.pi * 0.0366**2 / (2 * 0.145) * 20.0
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(30.0, 0.0, 20.0))
    # The rate is rounded in doubles here.
    check_closed_form(
        solve(SlowFlight(launch=launch), engine).landing, rate, 0.0, max(error, 1e-13)
    )
