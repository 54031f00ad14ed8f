"""The impulse between ball and bat, as executed.

Generated from the expressions of :mod:`longball.model.derivation`; do not edit. To regenerate::

    python -m longball.model.derivation

Only + - * / and whole numbers occur, so the functions serve every kind of number alike: float,
Fraction, mpf, arb, and arrays, elementwise.
"""

from typing import Any

Number = Any  # float, mpf, arb or array: whatever adds, multiplies and divides


def reduced_mass(m: Number, M: Number) -> Number:  # noqa: N803  (the paper's letters)
    """Mass that the impulse between two free bodies meets: 1/μ = 1/m + 1/M.

    Parameters
    ----------
    m, M : number
        Masses of ball and bat, in kg.

    Returns
    -------
    number
        μ, in kg. The paper's Appendix A, below Eq. (A2).
    """
    return M * m / (M + m)


def impulse(reduced_mass: Number, restitution: Number, normal_speed: Number) -> Number:
    """Impulse that the ball receives along the normal; the bat receives the opposite.

    Parameters
    ----------
    reduced_mass : number
        μ, in kg.
    restitution : number
        ẽ, dimensionless.
    normal_speed : number
        Ṽ·n, velocity of the ball relative to the bat along the normal from bat to ball, in m/s.
        Negative for a ball that approaches.

    Returns
    -------
    number
        -μ (1 + ẽ) (Ṽ·n), in N·s. The paper's Eq. (A10) times Δt, which is its Eq. (9).
    """
    return -normal_speed * reduced_mass * (restitution + 1)


def velocity_after(
    velocity: tuple[Number, Number, Number],
    normal: tuple[Number, Number, Number],
    mass: Number,
    impulse: Number,
) -> tuple[Number, Number, Number]:
    """Velocity of the ball after the impulse.

    Parameters
    ----------
    velocity : three numbers
        Velocity of the ball before, in m/s.
    normal : three numbers
        Unit normal, from bat to ball.
    mass : number
        Mass of the ball, in kg.
    impulse : number
        Impulse along the normal, in N·s.

    Returns
    -------
    tuple of three numbers
        V + (J/m) n, in m/s. The paper's Eq. (A1).
    """
    vx, vy, vz = velocity
    nx, ny, nz = normal
    return (
        impulse * nx / mass + vx,
        impulse * ny / mass + vy,
        impulse * nz / mass + vz,
    )


def energy_change(reduced_mass: Number, restitution: Number, normal_speed: Number) -> Number:
    """Change of the kinetic energy of ball and bat together.

    Parameters
    ----------
    reduced_mass : number
        μ, in kg.
    restitution : number
        ẽ, dimensionless.
    normal_speed : number
        Ṽ·n before the collision, in m/s.

    Returns
    -------
    number
        -½ μ (1 - ẽ²) (Ṽ·n)², in J; positive if ẽ > 1. Not in the paper: it follows from the
        energies of both bodies, and is factored so as not to cancel near ẽ = 1.
    """
    return normal_speed * normal_speed * reduced_mass * (restitution - 1) * (restitution + 1) / 2
