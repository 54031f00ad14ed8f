"""Into the frame of a flight, and back."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from longball.model.frame import Frame, launch_frame
from longball.model.law import PlaneState, SpaceState
from longball.model.numbers import DOUBLES, Undecided
from tests.scenes import between

# A velocity whose square underflows, below 1e-154 m/s, counts as none.
coordinates = st.just(0.0) | between(1e-100, 100) | between(-100, -1e-100)


@given(st.tuples(*[coordinates] * 3), st.tuples(*[coordinates] * 3))
def test_there_and_back(position, velocity):
    frame, start = launch_frame(position, velocity, DOUBLES)
    assert frame.position(start) == position
    assert (start.s, start.z) == (0.0, position[2])
    assert start.u >= 0.0
    assert math.hypot(frame.cos, frame.sin) == pytest.approx(1.0, abs=4e-16)
    # Three roundings: of the root, of the quotient and of the product.
    assert frame.velocity(start) == pytest.approx(velocity, rel=6e-16)


@given(*[between(-50, 50)] * 6)
def test_left_of_the_launch_is_left_of_it(s, y, z, u, v, w):
    frame = Frame(1.0, 2.0, 0.6, 0.8)
    state = SpaceState(s, y, z, u, v, w)
    along = frame.position(PlaneState(s, z, u, w))
    left = (-0.8 * y, 0.6 * y, 0.0)
    wanted = [a + b for a, b in zip(along, left, strict=True)]
    assert frame.position(state) == pytest.approx(wanted, abs=1e-13)  # a few ulps of 100 m
    assert frame.towards_x(state) == frame.position(state)[0]
    turned = Frame(0.0, 0.0, 0.6, 0.8).position(SpaceState(u, v, w, 0.0, 0.0, 0.0))
    assert frame.velocity(state) == pytest.approx(turned, abs=1e-13)


@pytest.mark.parametrize("w", [30.0, -30.0, 0.0])
def test_a_vertical_launch_heads_for_the_pitcher(w):
    frame, start = launch_frame((1.0, 2.0, 3.0), (0.0, 0.0, w), DOUBLES)
    assert (frame.cos, frame.sin, start.u, start.w) == (1.0, 0.0, 0.0, w)


@pytest.mark.parametrize("speed", [5e-324, 1e-200, 1e-30, 1e30])
def test_the_heading_of_any_speed(speed):
    frame, start = launch_frame((0.0, 0.0, 1.0), (-speed, 0.0, 10.0), DOUBLES)
    assert (frame.cos, frame.sin, start.u) == (-1.0, 0.0, speed)


def test_numbers_that_cannot_tell_a_vertical_launch_say_so():
    class Vague(type(DOUBLES)):
        def positive(self, x, error, question):
            return super().positive(x, 1e-3, question)

    with pytest.raises(Undecided, match="whether the launch is vertical cannot be decided"):
        launch_frame((0.0, 0.0, 1.0), (1e-6, 0.0, 30.0), Vague())
