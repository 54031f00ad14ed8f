"""The impulse between ball and bat.

The return statements are generated from the expressions of :mod:`longball.model.derivation`; do not
edit them. To generate them again::

    python -m longball.model.derivation

The formulas contain only + - * / and whole numbers, so the functions take every kind of number:
float, Fraction, mpf, arb, and arrays, elementwise. Vectors have three components: those of `slip` and
`push` are along the normal, along the bat, and across both; all others are in space. Arguments have
the same meaning everywhere:

mass, radius, inertia_factor
    Of the ball: m, in kg; R, in m; β = I/(m R²), dimensionless.
bat_mass, inverse_bat_mass
    M, in kg; 1/M of a free bat and 0 at a pivot, in 1/kg.
inertia, axial_inertia
    Of the bat, about an axis across it and about its own, in kg·m².
bat_radius, arm
    r_b; y of the contact, from the pivot or the bat's centre; in m.
velocity, spin, bat_velocity, rotation
    Of the ball, in m/s and rad/s; of the bat on its axis, in m/s; its angular velocity, in rad/s.
normal
    Unit vector, from bat to ball.
reduced_mass, inverse_mass
    μ, in kg; K_nn, K_ny, K_yy, K_tt of `inverse_mass`, in 1/kg.
normal_speed, slip
    Ṽ·n, negative if they approach; relative velocity at the contact; in m/s.
restitution, tangential_restitution, friction
    ẽ; e_T, from -1 to 1; μ_f; dimensionless.
direction, resistance
    Unit vector of the sliding, along the bat and across; D of `sliding_resistance`, in 1/kg.
impulse, push
    Along the normal; the whole of it; in N·s.
"""

from typing import Any

# float, mpf, arb, array: any type with addition, multiplication and division.
Number = Any
Vector = tuple[Number, Number, Number]


def reduced_mass(mass: Number, bat_mass: Number) -> Number:
    """Mass that the impulse between two free bodies meets: 1/μ = 1/m + 1/M.

    μ, in kg. The paper's Appendix A, below Eq. (A2).
    """
    return bat_mass * mass / (bat_mass + mass)


def impulse(reduced_mass: Number, restitution: Number, normal_speed: Number) -> Number:
    """Impulse that the ball receives along the normal; the bat receives the opposite.

    -μ (1 + ẽ) (Ṽ·n), in N·s. The paper's Eq. (A10) times Δt, which is its Eq. (9).
    """
    return -normal_speed * reduced_mass * (restitution + 1)


def velocity_after(velocity: Vector, normal: Vector, mass: Number, impulse: Number) -> Vector:
    """Velocity of the ball after the impulse.

    V + (J/m) n, in m/s. The paper's Eq. (A1).
    """
    V_x, V_y, V_z = velocity
    n_x, n_y, n_z = normal
    return (
        V_x + impulse * n_x / mass,
        V_y + impulse * n_y / mass,
        V_z + impulse * n_z / mass,
    )


def energy_change(reduced_mass: Number, restitution: Number, normal_speed: Number) -> Number:
    """Change of the kinetic energy of ball and bat.

    -½ μ (1 - ẽ²) (Ṽ·n)², in J; positive if ẽ > 1. Not in the paper.
    """
    # The factors (ẽ - 1)(ẽ + 1) keep their digits near ẽ = 1; 1 - ẽ² would cancel.
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

    g, in m/s; g_n is Ṽ·n.
    """
    V_x, V_y, V_z = velocity
    omega_x, omega_y, omega_z = spin
    V_bx, V_by, V_bz = bat_velocity
    Omega_x, Omega_y, Omega_z = rotation
    n_x, n_y, n_z = normal
    # The contact is at -R n from the ball's centre, and at r_b n from the bat's axis. The normal has no
    # component along the bat, so n_y does not occur.
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

    K_nn, K_ny, K_yy, K_tt, in 1/kg; n: normal, y: along the bat, t: across both.
    """
    # K is symmetric. By the symmetry of ball and bat, K_nt = K_yt = 0: an impulse across the bat does
    # not change the other components.
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

    P, in N·s.
    """
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    g_n, g_y, g_t = slip
    # The normal and the component along the bat are coupled: a system of two equations.
    return (
        (K_ny * g_y * tangential_restitution + K_ny * g_y - K_yy * g_n * restitution - K_yy * g_n) / (K_nn * K_yy - K_ny * K_ny),
        -(K_nn * g_y * tangential_restitution + K_nn * g_y - K_ny * g_n * restitution - K_ny * g_n) / (K_nn * K_yy - K_ny * K_ny),
        -g_t * (tangential_restitution + 1) / K_tt,
    )


def sliding_resistance(
    inverse_mass: tuple[Number, ...], friction: Number, direction: tuple[Number, ...]
) -> Number:
    """Resistance to the normal impulse of a sliding ball; if it is not positive, the bodies jam.

    D = n·K(n - μ_f t), in 1/kg.
    """
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    t_y, t_t = direction
    # Only the component along the bat is coupled to the normal, so t_t does not occur.
    return K_nn - K_ny * friction * t_y


def sliding_impulse(
    resistance: Number,
    restitution: Number,
    friction: Number,
    slip: Vector,
    direction: tuple[Number, ...],
) -> Vector:
    """Impulse of Coulomb's friction on a ball that slides.

    P = P_n (n - μ_f t), in N·s.
    """
    g_n, g_y, g_t = slip
    t_y, t_t = direction
    return (
        g_n * (-restitution - 1) / resistance,
        -friction * g_n * t_y * (-restitution - 1) / resistance,
        -friction * g_n * t_t * (-restitution - 1) / resistance,
    )


def velocity_after_push(velocity: Vector, push: Vector, normal: Vector, mass: Number) -> Vector:
    """Velocity of the ball after an impulse that is not along the normal.

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


def push_energy(push: Vector, slip: Vector, inverse_mass: tuple[Number, ...]) -> Number:
    """Change of the kinetic energy of ball and bat by an impulse at the contact.

    P·(g + K P/2), in J; positive if the collision creates energy.
    """
    P_n, P_y, P_t = push
    g_n, g_y, g_t = slip
    K_nn, K_ny, K_yy, K_tt = inverse_mass
    return P_n * (K_nn * P_n / 2 + K_ny * P_y / 2 + g_n) + P_t * (K_tt * P_t / 2 + g_t) + P_y * (K_ny * P_n / 2 + K_yy * P_y / 2 + g_y)
