"""The bat where it meets the ball: its velocity, its effective mass, its restitution.

The bat is a cylinder of length L along y whose end B, at y = +L/2, is the pivot of the swing.
Source: paper, Sec. III.A and III.C; the readings are those of the ledger.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic

from longball.model.impact import reduced_mass
from longball.model.numbers import N, Numbers, Vector
from longball.model.readings import Reading
from longball.model.scene import Ball, Bat, Rotation


def lever_arm(y: N, bat: Bat, numbers: Numbers[N]) -> N:
    """Return r̃, m: the distance from B to the foot of the perpendicular from the ball."""
    return numbers.exact(bat.length) / 2 - y


def bat_velocity(lever_arm: N, swing: Rotation, numbers: Numbers[N]) -> Vector[N]:
    """Return V_b = ω' × r̃, m/s, with ω' = ω(-sin θ, 0, cos θ) and r̃ = (0, -lever_arm, 0)."""
    cos, sin = numbers.cos_sin(numbers.exact(swing.tilt))
    speed = numbers.exact(swing.angular_speed) * lever_arm
    return speed * cos, numbers.exact(0.0), speed * sin


def moment_of_inertia(bat: Bat, reading: Reading, numbers: Numbers[N]) -> N:
    """Return the bat's moment of inertia I, kg m², about its end B (or as the reading slips)."""
    mass, length, radius = (numbers.exact(v) for v in (bat.mass, bat.length, bat.radius))
    match reading.inertia:
        case "solid_cylinder":
            return mass * (length * length / 3 + radius * radius / 4)
        case "thin_rod":
            return mass * length * length / 3
        case "about_centre":
            return mass * (length * length / 12 + radius * radius / 4)


@dataclass(frozen=True)
class CollisionParameters(Generic[N]):
    """What the impulse depends on besides the velocities.

    Attributes
    ----------
    restitution
        ẽ, between ball and bat.
    reduced_mass
        μ, kg.
    """

    restitution: N
    reduced_mass: N


def collision_parameters(
    ball: Ball, bat: Bat, lever_arm: N, reading: Reading, numbers: Numbers[N]
) -> CollisionParameters[N]:
    """Return ẽ and μ at a distance `lever_arm` (m) from the pivot, as the reading has them."""
    m, e, inertia = (
        numbers.exact(ball.mass),
        numbers.exact(ball.restitution),
        moment_of_inertia(bat, reading, numbers),
    )
    arm = lever_arm if reading.effective_mass == "as_printed" else lever_arm * lever_arm
    effective_mass = inertia / arm
    whole_mass = numbers.exact(bat.mass)
    match reading.bat_ball_restitution:
        case "nathan":
            return CollisionParameters(e, reduced_mass(m, effective_mass))
        case "plain":
            return CollisionParameters(e, reduced_mass(m, whole_mass))
        case "as_printed":
            ratio = m / effective_mass
            struck = effective_mass if reading.reduced_mass == "effective_mass" else whole_mass
            return CollisionParameters(e * (1 + ratio) + ratio, reduced_mass(m, struck))
