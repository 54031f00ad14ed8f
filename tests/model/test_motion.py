"""The equations of motion in the plane are those in space, with only the terms that are named."""

import math

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from longball.model.motion import FlightPlane, Forces, PlaneState, acceleration, forces, into_plane
from longball.model.numbers import DOUBLES, Undecided
from longball.model.scene import Air, Ball
from tests.strategies import between

DRAG, LIFT, GRAVITY = sp.symbols("k_D k_L g", positive=True)
HEADING = sp.Symbol("alpha", real=True)
U, W = sp.symbols("u w", real=True)


class Symbols:
    sqrt = staticmethod(sp.sqrt)
    exact = staticmethod(sp.Integer)


@pytest.mark.parametrize("drag", [None, DRAG])
@pytest.mark.parametrize("lift", [None, LIFT])
@pytest.mark.parametrize("gravity", [None, GRAVITY])
def test_the_plane_has_the_accelerations_of_space(drag, lift, gravity):
    """a = -k_D V v + k_L V (ŝ × v) + g, ŝ level and across the flight; no part leaves the plane."""
    du, dw = acceleration(Forces(drag, lift, gravity, False), Symbols)(U, W)
    plane = FlightPlane(0, 0, sp.cos(HEADING), sp.sin(HEADING))
    velocity = sp.Matrix(plane.velocity(PlaneState(0, 0, U, W)))
    in_plane = sp.Matrix(plane.velocity(PlaneState(0, 0, du, dw)))
    backspin = sp.Matrix([plane.cos, plane.sin, 0]).cross(sp.Matrix([0, 0, 1]))
    speed = sp.sqrt(U**2 + W**2)
    in_space = (
        -(drag or 0) * speed * velocity
        + (lift or 0) * speed * backspin.cross(velocity)
        - (gravity or 0) * sp.Matrix([0, 0, 1])
    )
    assert (in_plane - in_space).applyfunc(sp.simplify) == sp.zeros(3, 1)


def test_backspin_lifts_and_drag_brakes():
    """The signs, without algebra: a level flight to the right."""
    du, dw = acceleration(Forces(0.1, 0.01, None, False), DOUBLES)(10.0, 0.0)
    assert (du, dw) == (pytest.approx(-10.0), pytest.approx(1.0))


def test_the_constants_are_those_of_the_paper():
    """k = ρ C A / (2 m), in numbers: 1.29 · 0.4 · π · 0.0366² / (2 · 0.145)."""
    found = forces(Ball(), Air(), 9.8, False, DOUBLES)
    assert found.drag == pytest.approx(0.007488, rel=1e-4)
    assert found.lift == pytest.approx(0.003744, rel=1e-4)
    assert (found.gravity, found.always_up) == (9.8, False)


@pytest.mark.parametrize(
    ("air", "gravity", "named"),
    [
        (None, 9.8, {"gravity"}),
        (None, 0.0, set()),
        (Air(density=0.0), 9.8, {"gravity"}),
        (Air(drag_coefficient=0.0), 0.0, {"lift"}),
        (Air(lift_coefficient=0.0), 0.0, {"drag"}),
        (Air(lift_coefficient=-0.1), 9.8, {"drag", "lift", "gravity"}),
    ],
)
def test_only_what_the_scene_names_is_there(air, gravity, named):
    found = forces(Ball(), air, gravity, True, DOUBLES)
    assert {name for name in ("drag", "lift", "gravity") if getattr(found, name)} == named
    assert all(getattr(found, name) is None for name in {"drag", "lift", "gravity"} - named)
    assert found.always_up


# A velocity whose square underflows, below 1e-154 m/s, counts as none.
coordinates = st.just(0.0) | between(1e-100, 100) | between(-100, -1e-100)


@given(st.tuples(*[coordinates] * 3), st.tuples(*[coordinates] * 3))
def test_into_the_plane_and_back(position, velocity):
    plane, start = into_plane(position, velocity, DOUBLES)
    assert plane.position(start) == position
    assert (start.s, start.z) == (0.0, position[2])
    assert start.u >= 0.0
    assert math.hypot(plane.cos, plane.sin) == pytest.approx(1.0, abs=4e-16)
    # Three roundings: of the root, of the quotient and of the product.
    assert plane.velocity(start) == pytest.approx(velocity, rel=6e-16)


@pytest.mark.parametrize("w", [30.0, -30.0, 0.0])
def test_a_vertical_launch_heads_for_the_pitcher(w):
    plane, start = into_plane((1.0, 2.0, 3.0), (0.0, 0.0, w), DOUBLES)
    assert (plane.cos, plane.sin, start.u, start.w) == (1.0, 0.0, 0.0, w)


@pytest.mark.parametrize("speed", [5e-324, 1e-200, 1e-30, 1e30])
def test_the_heading_of_any_speed(speed):
    plane, start = into_plane((0.0, 0.0, 1.0), (-speed, 0.0, 10.0), DOUBLES)
    assert (plane.cos, plane.sin, start.u) == (-1.0, 0.0, speed)


def test_numbers_that_cannot_tell_a_vertical_launch_say_so():
    class Vague(type(DOUBLES)):
        def positive(self, x, error, question):
            return super().positive(x, 1e-3, question)

    with pytest.raises(Undecided, match="whether the launch is vertical cannot be decided"):
        into_plane((0.0, 0.0, 1.0), (1e-6, 0.0, 30.0), Vague())
