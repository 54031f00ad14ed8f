"""The bat where it meets the ball: its velocity, its effective mass, its restitution.

The bat is a cylinder of length L along y whose end B, at y = +L/2, is the pivot of the swing. In
the impact it turns about B still, or is free. Source: paper, Sec. III.A and III.C; the readings are
those of the ledger.
"""

from __future__ import annotations

from dataclasses import dataclass

from longball.model.impact import inverse_mass, reduced_mass
from longball.model.numbers import N, Numbers, Vector
from longball.model.readings import Reading
from longball.model.scene import Ball, Bat, Rotation


def bat_rotation(swing: Rotation, numbers: Numbers) -> Vector:
    """Return ω' = ω(-sin θ, 0, cos θ), rad/s."""
    cos, sin = numbers.cos_sin(numbers.exact(swing.tilt))
    speed = numbers.exact(swing.angular_speed)
    return -(speed * sin), numbers.exact(0.0), speed * cos


def bat_velocity(lever_arm: N, swing: Rotation, numbers: Numbers) -> Vector:
    """Return V_b = ω' × r̃, m/s, with ω' = ω(-sin θ, 0, cos θ) and r̃ = (0, -lever_arm, 0)."""
    cos, sin = numbers.cos_sin(numbers.exact(swing.tilt))
    speed = numbers.exact(swing.angular_speed) * lever_arm
    return speed * cos, numbers.exact(0.0), speed * sin


def moment_of_inertia(bat: Bat, reading: Reading, numbers: Numbers) -> N:
    """Return the bat's moment of inertia across its axis, kg m².

    About its end B (or as the reading slips); of a free bat, about its centre.
    """
    mass, length, radius = map(numbers.exact, (bat.mass, bat.length, bat.radius))
    if bat.support == "free":
        # About the centre, across the axis: M L²/12, and M r_b²/4 of the thickness.
        slender = mass * length * length / 12
        return slender if reading.inertia == "thin_rod" else slender + mass * radius * radius / 4
    match reading.inertia:
        case "solid_cylinder":
            # About the end B: M L²/12 + M (L/2)² by the theorem of parallel axes.
            return mass * (length * length / 3 + radius * radius / 4)
        case "thin_rod":
            return mass * length * length / 3
        case "about_centre":
            return mass * (length * length / 12 + radius * radius / 4)


@dataclass(frozen=True)
class CollisionParameters:
    """Parameters of the impulse, besides the velocities."""

    restitution: N  # ẽ, between ball and bat
    reduced_mass: N  # μ, kg


def collision_parameters(
    ball: Ball, bat: Bat, lever_arm: N, reading: Reading, numbers: Numbers
) -> CollisionParameters:
    """Return ẽ and μ at a distance `lever_arm` (m) from the pivot, as the reading has them."""
    m, e, inertia = (
        numbers.exact(ball.mass),
        numbers.exact(ball.restitution),
        moment_of_inertia(bat, reading, numbers),
    )
    whole_mass = numbers.exact(bat.mass)
    if bat.support == "free":
        # 1/M_eff = 1/M + y²/J, with y from the middle of the bat (model.md, Oblique impact).
        y = numbers.exact(bat.length) / 2 - lever_arm
        effective_mass = whole_mass * inertia / (inertia + whole_mass * y * y)
    else:
        # The paper prints M_eff = I/r̃, which is not a mass; the default is I/r̃².
        arm = lever_arm if reading.effective_mass == "as_printed" else lever_arm * lever_arm
        effective_mass = inertia / arm
    match reading.bat_ball_restitution:
        # ẽ = e, and M_eff in μ as well, as Nathan (2003) has it: model.md, Readings.
        case "nathan":
            return CollisionParameters(e, reduced_mass(m, effective_mass))
        case "plain":
            return CollisionParameters(e, reduced_mass(m, whole_mass))
        case "as_printed":
            # ẽ = e (1 + m/M_eff) + m/M_eff, the paper's Eq. (10). Above 1 towards the barrel, where
            # the collision creates energy.
            ratio = m / effective_mass
            struck = effective_mass if reading.reduced_mass == "effective_mass" else whole_mass
            return CollisionParameters(e * (1 + ratio) + ratio, reduced_mass(m, struck))


def inverse_masses(
    ball: Ball,
    bat: Bat,
    lever_arm: N,
    pair: CollisionParameters,
    reading: Reading,
    numbers: Numbers,
) -> tuple[N, ...]:
    """Return K_nn, K_ny, K_yy, K_tt, 1/kg, of `longball.model.impact.inverse_mass`.

    K_nn is 1/μ as the reading has it; the others are those of a uniform cylinder.
    """
    mass, radius = numbers.exact(bat.mass), numbers.exact(bat.radius)
    free, half = bat.support == "free", numbers.exact(bat.length) / 2
    _, *others = inverse_mass(
        mass=numbers.exact(ball.mass),
        inertia_factor=inertia_factor(ball, numbers),
        inverse_bat_mass=1 / mass if free else numbers.exact(0.0),
        inertia=moment_of_inertia(bat, reading, numbers),
        # A solid cylinder about its own axis.
        axial_inertia=mass * radius * radius / 2,
        # y of the contact from the bat's middle, or from B at y = L/2, which is further to the
        # left.
        arm=half - lever_arm if free else -lever_arm,
        bat_radius=radius,
    )
    return 1 / pair.reduced_mass, *others


def inertia_factor(ball: Ball, numbers: Numbers) -> N:
    """Return I/(m R²); the double 0.4 if the scene does not name it."""
    return numbers.exact(0.4 if ball.inertia_factor is None else ball.inertia_factor)


def tangential_restitution(bat: Bat, numbers: Numbers) -> N:
    """Return e_T; the double 0.3 if the scene does not name it."""
    given = bat.tangential_restitution
    return numbers.exact(0.3 if given is None else given)
