"""The bat where it meets the ball."""

import math

import pytest
from hypothesis import given

from longball.model.bat import bat_velocity
from longball.model.numbers import DOUBLES
from longball.model.scene import Rotation
from tests.scenes import between


@given(between(0, 1), between(-50, 50), between(-1.5, 1.5))
def test_the_bat_moves_by_the_cross_product(arm, omega, tilt):
    """V_b = ω' × r̃ written out, with ω' = ω (-sin θ, 0, cos θ) and r̃ = (0, -arm, 0)."""
    ox, oy, oz = -omega * math.sin(tilt), 0.0, omega * math.cos(tilt)
    rx, ry, rz = 0.0, -arm, 0.0
    wanted = oy * rz - oz * ry, oz * rx - ox * rz, ox * ry - oy * rx
    found = bat_velocity(arm, Rotation(angular_speed=omega, tilt=tilt), DOUBLES)
    assert found == pytest.approx(wanted, rel=4e-16)


def test_the_bat_swings_at_the_pitcher_and_upwards():
    """x points to the pitcher: 34 rad/s at half a metre is 17 m/s, and a tilt lifts it."""
    vx, vy, vz = bat_velocity(0.5, Rotation(angular_speed=34.0, tilt=0.1), DOUBLES)
    assert (vx, vy, vz) == (pytest.approx(17 * math.cos(0.1)), 0.0, pytest.approx(1.6972, rel=1e-4))
