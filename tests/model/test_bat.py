"""The bat where it meets the ball."""

import math
from fractions import Fraction

import pytest
from hypothesis import given

from longball.model.bat import (
    bat_velocity,
    collision_parameters,
    inverse_masses,
    lever_arm,
    moment_of_inertia,
)
from longball.model.numbers import DOUBLES
from longball.model.readings import Reading
from longball.model.scene import Ball, Bat, Rotation
from tests.scenes import between

BALL, BAT = Ball(), Bat()


class Exact:
    """Fractions, as far as masses and lengths need a number system."""

    exact = staticmethod(Fraction)


EXACT = Exact()
M, L, R = map(Fraction, (BAT.mass, BAT.length, BAT.radius))


def test_the_lever_is_the_distance_from_the_end_at_plus_y():
    assert lever_arm(0.0, BAT, DOUBLES) == 0.5
    assert lever_arm(0.5, BAT, DOUBLES) == 0.0
    assert lever_arm(-0.25, Bat(length=0.9), DOUBLES) == pytest.approx(0.7)


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


@pytest.mark.parametrize(
    ("inertia", "wanted"),
    [
        ("solid_cylinder", M * (L**2 / 3 + R**2 / 4)),
        ("thin_rod", M * L**2 / 3),
        ("about_centre", M * (L**2 / 12 + R**2 / 4)),
    ],
)
def test_moments_of_inertia(inertia, wanted):
    assert moment_of_inertia(BAT, Reading(inertia=inertia), EXACT) == wanted


def test_the_cylinder_about_its_end_is_the_one_about_its_centre_moved():
    """Steiner: I_B = I_centre + M (L/2)²."""
    at_end, at_centre = (
        moment_of_inertia(BAT, Reading(inertia=name), EXACT)
        for name in ("solid_cylinder", "about_centre")
    )
    assert at_end == at_centre + M * (L / 2) ** 2


ARM = Fraction(3, 4)
BALL_MASS, E = Fraction(BALL.mass), Fraction(BALL.restitution)
INERTIA = M * (L**2 / 3 + R**2 / 4)
EFFECTIVE = INERTIA / ARM**2


def mu(mass):
    return 1 / (1 / BALL_MASS + 1 / mass)


def inverted(ratio):
    return E * (1 + ratio) + ratio


@pytest.mark.parametrize(
    ("reading", "restitution", "reduced_mass"),
    [
        ({}, inverted(BALL_MASS / EFFECTIVE), mu(M)),
        ({"reduced_mass": "effective_mass"}, inverted(BALL_MASS / EFFECTIVE), mu(EFFECTIVE)),
        ({"effective_mass": "as_printed"}, inverted(BALL_MASS * ARM / INERTIA), mu(M)),
        (
            {"effective_mass": "as_printed", "reduced_mass": "effective_mass"},
            inverted(BALL_MASS * ARM / INERTIA),
            mu(INERTIA / ARM),
        ),
        ({"bat_ball_restitution": "nathan"}, E, mu(EFFECTIVE)),
        ({"bat_ball_restitution": "plain"}, E, mu(M)),
        ({"inertia": "thin_rod"}, inverted(BALL_MASS * ARM**2 / (M * L**2 / 3)), mu(M)),
    ],
)
def test_readings_of_the_collision(reading, restitution, reduced_mass):
    pair = collision_parameters(BALL, BAT, ARM, Reading(**reading), EXACT)
    assert pair.restitution == restitution
    assert pair.reduced_mass == reduced_mass


def test_as_printed_inverts_nathans_apparent_coefficient():
    """e_A = (ẽ - r)/(1 + r) of the printed ẽ is the printed e."""
    printed = collision_parameters(BALL, BAT, ARM, Reading(), EXACT).restitution
    ratio = BALL_MASS / EFFECTIVE
    assert (printed - ratio) / (1 + ratio) == E


@pytest.mark.parametrize(("support", "mass", "arm"), [("pivot", 0, 0.7), ("free", 1, -0.2)])
def test_inverse_masses_are_those_of_a_ball_and_a_cylinder(support, mass, arm):
    """Along the normal and the bat, and around the bat, which also turns about its own axis.

    `arm` is from the pivot, or the centre of a free bat, which moves as a whole besides.
    """
    ball, bat, reading = Ball(mass=0.15), Bat(mass=0.9, radius=0.03, support=support), Reading()
    pair = collision_parameters(ball, bat, 0.7, reading, DOUBLES)
    inertia = moment_of_inertia(bat, reading, DOUBLES)
    surface = (1 + 5 / 2) / 0.15 + mass / 0.9
    expected = (
        1 / pair.reduced_mass,
        abs(arm) * 0.03 / inertia,
        surface + 0.03**2 / inertia,
        surface + arm**2 / inertia + 0.03**2 / (0.9 * 0.03**2 / 2),
    )
    found = inverse_masses(ball, bat, 0.7, pair, reading, DOUBLES)
    assert tuple(map(abs, found)) == pytest.approx(expected, rel=1e-14)
