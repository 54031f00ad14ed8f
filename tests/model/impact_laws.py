"""The laws that the derived impulse obeys.

Each is a function that returns a residual: what must be zero for the law to hold. It takes the
collision rule as an argument, so that a rule which breaks the law can be seen to leave a residual.
"""

import sympy as sp

from longball.model import derivation
from longball.model.derivation import (
    AXIAL_INERTIA,
    BALL_MASS,
    BAT_MASS,
    BAT_VELOCITY,
    BODIES,
    FRICTION,
    INERTIA,
    INERTIA_FACTOR,
    INVERSE_BAT_MASS,
    INVERSE_MASS,
    NORMAL,
    NORMAL_SPEED,
    RADIUS,
    REDUCED_MASS,
    RESISTANCE,
    RESTITUTION,
    ROTATION,
    SLIP,
    SPIN,
    VELOCITY,
    Bodies,
    Rule,
    collide,
    on_unit_normal,
)


def momentum_residual(rule: Rule = collide) -> sp.Matrix:
    """Change of the total momentum m V + M V_b: zero, as noted below (A2)."""
    after = rule(VELOCITY, BAT_VELOCITY, NORMAL)
    change = BALL_MASS * (after.ball - VELOCITY) + BAT_MASS * (after.bat - BAT_VELOCITY)
    return change.applyfunc(on_unit_normal)


def tangential_residual(rule: Rule = collide) -> sp.Matrix:
    """Change of the velocities tangential to the contact, ball and bat in two columns: zero.

    The averaged force has no tangential part (the paper sets it along n above (A4)).
    """

    def tangential(vector: sp.Matrix) -> sp.Matrix:
        return vector - vector.dot(NORMAL) * NORMAL

    after = rule(VELOCITY, BAT_VELOCITY, NORMAL)
    changes = sp.Matrix.hstack(
        tangential(after.ball - VELOCITY), tangential(after.bat - BAT_VELOCITY)
    )
    return changes.applyfunc(on_unit_normal)


def restitution_residual(rule: Rule = collide) -> sp.Expr:
    """Ṽ⁺·n + ẽ Ṽ·n, the restitution relation (A5) with the sign of a rebound: zero."""
    after = rule(VELOCITY, BAT_VELOCITY, NORMAL)
    before = VELOCITY - BAT_VELOCITY
    return on_unit_normal((after.ball - after.bat + RESTITUTION * before).dot(NORMAL))


def galilean_residual(rule: Rule = collide) -> sp.Matrix:
    """Effect of a common velocity of both bodies, beyond being added after as before: zero.

    Ball and bat in two columns.
    """
    common = sp.Matrix(sp.symbols("U_x U_y U_z", real=True))
    at_rest = rule(VELOCITY, BAT_VELOCITY, NORMAL)
    moving = rule(VELOCITY + common, BAT_VELOCITY + common, NORMAL)
    changes = sp.Matrix.hstack(
        moving.ball - common - at_rest.ball, moving.bat - common - at_rest.bat
    )
    return changes.applyfunc(on_unit_normal)


# ---- bodies that turn and rub -----------------------------------------------------------------


def kinetic_energy(bodies: Bodies) -> sp.Expr:
    """Return the kinetic energy of ball and free bat, w = 1/M."""
    spin, rotation = bodies.spin, bodies.rotation
    ball = bodies.velocity.dot(bodies.velocity) + INERTIA_FACTOR * RADIUS**2 * spin.dot(spin)
    inertia = sp.diag(INERTIA, AXIAL_INERTIA, INERTIA)
    bat = bodies.bat_velocity.dot(bodies.bat_velocity) / INVERSE_BAT_MASS
    return (BALL_MASS * ball + bat + rotation.dot(inertia * rotation)) / 2


def energy_residual() -> sp.Expr:
    """Return kinetic energy after less before less `work`: zero, for any impulse."""
    change = kinetic_energy(derivation.pushed(BODIES)) - kinetic_energy(BODIES)
    return sp.expand(change - derivation.work(derivation.slip(BODIES)).subs(derivation.elements()))


def contact_momentum_residual() -> sp.Matrix:
    """Return the change of β R ω + n × V, the ball's angular momentum about the contact: zero.

    Its normal part says that the spin about the normal stays as it is. Any friction obeys it.
    """
    normal, after = sp.Matrix([1, 0, 0]), derivation.pushed(BODIES)
    turned = INERTIA_FACTOR * RADIUS * (after.spin - SPIN)
    return (turned + normal.cross(after.velocity - VELOCITY)).applyfunc(sp.cancel)


def total_momentum_residual() -> sp.Matrix:
    """Return the changes of momentum and angular momentum of ball and free bat: zero.

    Angular momentum is about the bat's centre; two columns.
    """
    after = derivation.pushed(BODIES)
    moved = BALL_MASS * (after.velocity - VELOCITY)
    momentum = moved + (after.bat_velocity - BAT_VELOCITY) / INVERSE_BAT_MASS
    spin = INERTIA_FACTOR * BALL_MASS * RADIUS**2 * (after.spin - SPIN)
    bat = sp.diag(INERTIA, AXIAL_INERTIA, INERTIA) * (after.rotation - ROTATION)
    angular = (derivation._FROM_BAT - derivation._FROM_BALL).cross(moved) + spin + bat
    return sp.Matrix.hstack(momentum, angular).applyfunc(sp.cancel)


def frictionless_residual() -> sp.Expr:
    """Return the sliding impulse without friction less the paper's (A10), 1/μ = K_nn: zero."""
    resistance, found = derivation.sliding_impulse()
    push = found.subs(RESISTANCE, resistance).subs(FRICTION, 0)
    paper = derivation.impulse().subs({REDUCED_MASS: 1 / INVERSE_MASS[0], NORMAL_SPEED: SLIP[0]})
    return sp.cancel(push[0] - paper) + abs(push[1]) + abs(push[2])
