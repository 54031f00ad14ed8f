"""The impulse between ball and bat, as executed.

Generated from the expressions of :mod:`longball.model.derivation`; do not edit. To regenerate::

    python -m longball.model.derivation

Only + - * / and whole numbers occur, so the functions serve every kind of number alike: float,
Fraction, mpf, arb, and arrays, elementwise. Components of three are along the normal, along the
bat, and across both; all others are in space.
"""

from typing import Any

Number = Any  # float, mpf, arb or array: whatever adds, multiplies and divides
Vector = tuple[Number, Number, Number]


def reduced_mass(
    m: Number,
    M: Number,
) -> Number:  # noqa: N803  (the paper's letters)
    """Mass that the impulse between two free bodies meets: 1/μ = 1/m + 1/M.

    Parameters
    ----------
    m : number
        Mass of the ball, in kg.
    M : number
        Mass of the bat, in kg.

    Returns
    -------
    Number
        μ, in kg. The paper's Appendix A, below Eq. (A2).
    """
    return M * m / (M + m)


def impulse(
    reduced_mass: Number,
    restitution: Number,
    normal_speed: Number,
) -> Number:
    """Impulse that the ball receives along the normal; the bat receives the opposite.

    Parameters
    ----------
    reduced_mass : number
        μ, in kg.
    restitution : number
        ẽ, dimensionless.
    normal_speed : number
        Ṽ·n, negative if they approach, in m/s.

    Returns
    -------
    Number
        -μ (1 + ẽ) (Ṽ·n), in N·s. The paper's Eq. (A10) times Δt, which is its Eq. (9).
    """
    return -normal_speed * reduced_mass * (restitution + 1)


def velocity_after(
    velocity: Vector,
    normal: Vector,
    mass: Number,
    impulse: Number,
) -> Vector:
    """Velocity of the ball after the impulse.

    Parameters
    ----------
    velocity : 3 numbers
        Of the ball, in m/s.
    normal : 3 numbers
        Unit normal, from bat to ball.
    mass : number
        Of the ball, in kg.
    impulse : number
        Along the normal, in N·s.

    Returns
    -------
    Vector
        V + (J/m) n, in m/s. The paper's Eq. (A1).
    """
    V_x, V_y, V_z = velocity
    n_x, n_y, n_z = normal
    return (
        V_x + impulse * n_x / mass,
        V_y + impulse * n_y / mass,
        V_z + impulse * n_z / mass,
    )


def energy_change(
    reduced_mass: Number,
    restitution: Number,
    normal_speed: Number,
) -> Number:
    """Change of the kinetic energy of ball and bat, factored so as not to cancel at ẽ = 1.

    Parameters
    ----------
    reduced_mass : number
        μ, in kg.
    restitution : number
        ẽ, dimensionless.
    normal_speed : number
        Ṽ·n, negative if they approach, in m/s.

    Returns
    -------
    Number
        -½ μ (1 - ẽ²) (Ṽ·n)², in J; positive if ẽ > 1. Not in the paper.
    """
    return normal_speed * normal_speed * reduced_mass * (restitution - 1) * (restitution + 1) / 2


def slip(
    velocity: Vector,
    spin: Vector,
    bat_velocity: Vector,
    rotation: Vector,
    normal: Vector,
    radius: Number,
    bat_radius: Number,
) -> Vector:
    """Velocity of the ball relative to the bat at the contact, where both turn.

    Parameters
    ----------
    velocity : 3 numbers
        Of the ball, in m/s.
    spin : 3 numbers
        Of the ball, in rad/s.
    bat_velocity : 3 numbers
        Of the bat on its axis, in m/s.
    rotation : 3 numbers
        Angular velocity of the bat, in rad/s.
    normal : 3 numbers
        Unit normal, from bat to ball.
    radius : number
        R, of the ball, in m.
    bat_radius : number
        r_b, in m.

    Returns
    -------
    Vector
        g, along the normal, along the bat, and across both, in m/s; g_n is Ṽ·n.
    """
    V_x, V_y, V_z = velocity
    omega_x, omega_y, omega_z = spin
    V_bx, V_by, V_bz = bat_velocity
    Omega_x, Omega_y, Omega_z = rotation
    n_x, n_y, n_z = normal
    return (
        -V_bx * n_x - V_bz * n_z + V_x * n_x + V_z * n_z,
        -V_by + V_y - bat_radius * (-Omega_x * n_z + Omega_z * n_x) - radius * (n_x * omega_z - n_z * omega_x),
        Omega_y * bat_radius + V_bx * n_z - V_bz * n_x - V_x * n_z + V_z * n_x + omega_y * radius,
    )


def inverse_mass(
    mass: Number,
    inertia_factor: Number,
    inverse_bat_mass: Number,
    inertia: Number,
    axial_inertia: Number,
    arm: Number,
    bat_radius: Number,
) -> tuple[Number, ...]:
    """Change of the relative velocity at the contact for an impulse there: g' = g + K P.

    Parameters
    ----------
    mass : number
        Of the ball, in kg.
    inertia_factor : number
        β = I/(m R²) of the ball, dimensionless.
    inverse_bat_mass : number
        1/M of a free bat, 0 at a pivot, in 1/kg.
    inertia : number
        Of the bat, about an axis across it, in kg·m².
    axial_inertia : number
        Of the bat, about its own axis, in kg·m².
    arm : number
        y of the contact, from the pivot or the bat's centre, in m.
    bat_radius : number
        r_b, in m.

    Returns
    -------
    tuple[Number, ...]
        K_nn, K_ny, K_yy, K_tt, in 1/kg; n: normal, y: along the bat, t: across both.
    """
    return (
        arm * arm / inertia + inverse_bat_mass + 1 / mass,
        -arm * bat_radius / inertia,
        bat_radius * bat_radius / inertia + inverse_bat_mass + 1 / mass + 1 / (inertia_factor * mass),
        arm * arm / inertia + inverse_bat_mass + 1 / mass + 1 / (inertia_factor * mass) + bat_radius * bat_radius / axial_inertia,
    )


def gripping_impulse(
    inverse_mass: tuple[Number, ...],
    restitution: Number,
    tangential_restitution: Number,
    slip: Vector,
) -> Vector:
    """Impulse after which the ball does not slide: g' = -ẽ g_n n - e_T g_t.

    Parameters
    ----------
    inverse_mass : 4 numbers
        K_nn, K_ny, K_yy, K_tt of `inverse_mass`, in 1/kg.
    restitution : number
        ẽ, dimensionless.
    tangential_restitution : number
        e_T, from -1 to 1.
    slip : 3 numbers
        Relative velocity at the contact, along the normal, along the bat, and across both, in m/s.

    Returns
    -------
    Vector
        P, along the normal, along the bat, and across both, in N·s.
    """
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    g_n, g_y, g_t = slip
    return (
        (K_ny * g_y * tangential_restitution + K_ny * g_y - K_yy * g_n * restitution - K_yy * g_n) / (K_nn * K_yy - K_ny * K_ny),
        -(K_nn * g_y * tangential_restitution + K_nn * g_y - K_ny * g_n * restitution - K_ny * g_n) / (K_nn * K_yy - K_ny * K_ny),
        -g_t * (tangential_restitution + 1) / K_tt,
    )


def sliding_resistance(
    inverse_mass: tuple[Number, ...],
    friction: Number,
    direction: tuple[Number, ...],
) -> Number:
    """What resists the impulse of a ball that slides; not positive: the two jam.

    Parameters
    ----------
    inverse_mass : 4 numbers
        K_nn, K_ny, K_yy, K_tt of `inverse_mass`, in 1/kg.
    friction : number
        μ_f, dimensionless.
    direction : 2 numbers
        Unit vector of the sliding: along the bat, and across.

    Returns
    -------
    Number
        D = n·K(n - μ_f t), in 1/kg.
    """
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    t_y, t_t = direction
    return K_nn - K_ny * friction * t_y


def sliding_impulse(
    resistance: Number,
    restitution: Number,
    friction: Number,
    slip: Vector,
    direction: tuple[Number, ...],
) -> Vector:
    """Impulse of Coulomb's friction on a ball that slides.

    Parameters
    ----------
    resistance : number
        Of `sliding_resistance`, in 1/kg.
    restitution : number
        ẽ, dimensionless.
    friction : number
        μ_f, dimensionless.
    slip : 3 numbers
        Relative velocity at the contact, along the normal, along the bat, and across both, in m/s.
    direction : 2 numbers
        Unit vector of the sliding: along the bat, and across.

    Returns
    -------
    Vector
        P = P_n (n - μ_f t), along the normal, along the bat, and across both, in N·s.
    """
    g_n, g_y, g_t = slip
    t_y, t_t = direction
    return (
        g_n * (-restitution - 1) / resistance,
        -friction * g_n * t_y * (-restitution - 1) / resistance,
        -friction * g_n * t_t * (-restitution - 1) / resistance,
    )


def velocity_after_push(
    velocity: Vector,
    push: Vector,
    normal: Vector,
    mass: Number,
) -> Vector:
    """Velocity of the ball after an impulse that is not along the normal.

    Parameters
    ----------
    velocity : 3 numbers
        Of the ball, in m/s.
    push : 3 numbers
        The impulse: along the normal, along the bat, and across both, in N·s.
    normal : 3 numbers
        Unit normal, from bat to ball.
    mass : number
        Of the ball, in kg.

    Returns
    -------
    Vector
        V + P/m, in m/s.
    """
    V_x, V_y, V_z = velocity
    P_n, P_y, P_t = push
    n_x, n_y, n_z = normal
    return (
        P_n * n_x / mass - P_t * n_z / mass + V_x,
        P_y / mass + V_y,
        P_n * n_z / mass + P_t * n_x / mass + V_z,
    )


def spin_after_push(
    spin: Vector,
    push: Vector,
    normal: Vector,
    mass: Number,
    radius: Number,
    inertia_factor: Number,
) -> Vector:
    """Spin of the ball after an impulse at the contact.

    Parameters
    ----------
    spin : 3 numbers
        Of the ball, in rad/s.
    push : 3 numbers
        The impulse: along the normal, along the bat, and across both, in N·s.
    normal : 3 numbers
        Unit normal, from bat to ball.
    mass : number
        Of the ball, in kg.
    radius : number
        R, of the ball, in m.
    inertia_factor : number
        β = I/(m R²) of the ball, dimensionless.

    Returns
    -------
    Vector
        ω - (R/I) n × P, in rad/s.
    """
    omega_x, omega_y, omega_z = spin
    P_n, P_y, P_t = push
    n_x, n_y, n_z = normal
    return (
        P_y * n_z / (inertia_factor * mass * radius) + omega_x,
        P_t / (inertia_factor * mass * radius) + omega_y,
        -P_y * n_x / (inertia_factor * mass * radius) + omega_z,
    )


def push_energy(
    push: Vector,
    slip: Vector,
    inverse_mass: tuple[Number, ...],
) -> Number:
    """Change of the kinetic energy of ball and bat by an impulse at the contact.

    Parameters
    ----------
    push : 3 numbers
        The impulse: along the normal, along the bat, and across both, in N·s.
    slip : 3 numbers
        Relative velocity at the contact, along the normal, along the bat, and across both, in m/s.
    inverse_mass : 4 numbers
        K_nn, K_ny, K_yy, K_tt of `inverse_mass`, in 1/kg.

    Returns
    -------
    Number
        P·(g + K P/2), in J; positive if the collision creates energy.
    """
    P_n, P_y, P_t = push
    g_n, g_y, g_t = slip
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    return P_n * (K_nn * P_n / 2 + K_ny * P_y / 2 + g_n) + P_t * (K_tt * P_t / 2 + g_t) + P_y * (K_ny * P_n / 2 + K_yy * P_y / 2 + g_y)
