"""Ball and bat: how they meet, the impulse of Appendix A, and what it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from longball.engines.chain.run import Mask, Run
from longball.engines.engine import CannotSolve, OutOfRange
from longball.model.bat import (
    CollisionParameters,
    bat_rotation,
    bat_velocity,
    collision_parameters,
    inertia_factor,
    inverse_masses,
    lever_arm,
    tangential_restitution,
)
from longball.model.impact import (
    energy_change,
    gripping_impulse,
    impulse,
    push_energy,
    sliding_impulse,
    sliding_resistance,
    slip,
    spin_after_push,
    velocity_after,
    velocity_after_push,
)
from longball.model.law import Force
from longball.model.numbers import N, Undecided, Vector
from longball.model.vectors import dot, minus


def solve_impacts(run: Run) -> None:
    """Solve impact scenes, in which the touching is given."""
    incoming = run.scene.incoming
    position, velocity = run.vector(incoming.position), run.vector(incoming.velocity)
    ball = Ball(position, velocity, run.spin(incoming.spin))
    offset = position[0], position[2] - run.numbers.exact(incoming.bat_height)
    # Nothing has flown: the position is exact, and only roundings here are in doubt.
    contact = meet(run, ball, offset, 0.0, run.everything)
    if contact is not None:
        _, parted = strike(run, contact, 0.0)
        run.conclude("struck", parted)


# --- the contact ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Ball:
    """A ball that touches the bat."""

    # position, velocity, spin: m, m/s and rad/s; None: the scene has no spin
    position: Vector
    velocity: Vector
    spin: Vector | None = None
    # y by which the bat's end is decided, m; None: that of `position`
    aside: N | None = None
    leaving: bool = False  # it is where it would leave the bat, instead of where it enters
    approach: Any = None  # the pitch and the bat; None: the touching is given


@dataclass(frozen=True)
class ContactState:
    """Ball and bat at the touching, before the impulse."""

    ball: Ball
    normal: Vector  # unit vector from the bat's axis to the ball
    bat_velocity: Vector  # of the bat on its axis, m/s
    lever_arm: N  # r̃, m
    normal_speed: N  # Ṽ·n, m/s
    closing: Mask  # whether they approach each other


def meet(
    run: Run, ball: Ball, offset: tuple[N, N], inherited: float, rows: Mask
) -> ContactState | None:
    """Return the contact of balls and bats that approach each other; None if none do.

    Others are recorded as `beyond_bat` or `separating`. The `offset` leads from the bat's axis to
    the ball's centre, m: in x, and up. `inherited` is the relative error of position and velocity,
    without the rounding here.
    """
    numbers, bat = run.numbers, run.scene.bat

    # along the bat
    half = numbers.exact(bat.length) / 2
    slack = half * (inherited + 2 * numbers.rounding) if inherited else numbers.exact(0.0)
    aside = ball.position[1] if ball.aside is None else ball.aside
    question = "whether the ball meets the bat or its end"
    on_bat, beyond = run.decide(half - abs(aside), slack, question, rows)
    run.conclude("beyond_bat", beyond)
    if not run.some(on_bat):
        return None

    # across the bat
    velocity, (across, above) = ball.velocity, offset
    distance = numbers.sqrt(across * across + above * above)
    normal = (across / distance, numbers.exact(0.0), above / distance)
    arm = lever_arm(ball.position[1], bat, numbers)
    moving = bat_velocity(arm, run.scene.swing, numbers)
    normal_speed = dot(minus(velocity, moving), normal)
    # Ṽ = V - V_b (paper, Sec. III.C). Six operations lead from the velocities to its normal part,
    # each with a rounding of the terms.
    terms = [(v[i], normal[i]) for v in (velocity, moving) for i in (0, 2)]
    doubt = sum((abs(a * b) * (inherited + 6 * numbers.rounding) for a, b in terms), across * 0)
    # The impulse is the same for n and -n; with Appendix B's larger root the ball is where it would
    # leave the bat, and approaches when it moves outwards.
    approach = normal_speed if ball.leaving else -normal_speed
    question = "whether ball and bat approach or separate"
    closing, separating = run.decide(approach, doubt, question, on_bat)
    run.record("contact.position", ball.position, on_bat)
    run.record("contact.normal", normal, on_bat)
    run.record("contact.bat_velocity", moving, on_bat)
    run.record("contact.normal_speed", normal_speed, on_bat)
    run.conclude("separating", separating)
    if not run.some(closing):
        return None
    return ContactState(ball, normal, moving, arm, normal_speed, closing)


# --- the impulse ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Impact:
    """The impulse, N s, and what it does: see `longball.model.result.Impact`."""

    restitution: N
    impulse: N
    velocity: Vector
    energy_change: N
    spin: Vector | None = None
    mode: Any = None
    friction_margin: N | None = None


def strike(run: Run, contact: ContactState, error: N) -> tuple[Impact, Mask]:
    """Apply the impulses and record their effects; see `collide`."""
    impact, parted = run.model.collide(run, contact, error)
    for quantity in fields(Impact):
        if (value := getattr(impact, quantity.name)) is not None:
            run.record(f"impact.{quantity.name}", value, parted)
    _tell_recontact(run, contact, impact, parted)
    return impact, parted


# Of the speeds. No engine's error at a contact is as large, but in a graze of 1e-7 m and less.
_TOLD_APART = 1e-6


def _tell_recontact(run: Run, contact: ContactState, impact: Impact, rows: Mask) -> None:
    """Record where a bat that swings on as before the impulse would strike the ball again.

    The impulse of the model makes ball and bat part, since the bat gives way by J/M. A batter does
    not: his bat goes on at ω', and if the ball is slower along the normal than that, so that
    ``(V⁺ - V_b)·n`` still has the sign of ``Ṽ·n``, they meet again at once. The model has one
    impulse; what it says of the flight is then not what such a bat would do. Of a ball that parts,
    and falls back on the bat later, nothing is said: where the bat is then, is not in the model.
    """
    numbers = run.numbers
    rate = dot(minus(impact.velocity, contact.bat_velocity), contact.normal)
    parting = numbers.where(contact.normal_speed < 0, rate, -rate)
    speeds = sum(map(abs, (*contact.ball.velocity, *contact.bat_velocity)), rate * 0)
    doubt = speeds * numbers.exact(_TOLD_APART)
    again, parted = parting < -doubt, parting > doubt
    run.record("impact.recontact", "certain", rows & again)
    run.record("impact.recontact", "possible", rows & ((again | parted) ^ True))


def collide(run: Run, contact: ContactState, error: N) -> tuple[Impact, Mask]:
    """Return the impulse of Appendix A, or of an oblique impact, and the rows in which they part.

    The impact is oblique on a bat with friction. The `error` is that of velocities and directions,
    relative, without the rounding here.
    """
    scene, numbers = run.scene, run.numbers
    pair = collision_parameters(scene.ball, scene.bat, contact.lever_arm, scene.reading, numbers)
    if scene.bat.friction is not None:
        return _rub(run, contact, pair, error)
    parts = pair.reduced_mass, pair.restitution, contact.normal_speed
    mass, push = numbers.exact(scene.ball.mass), impulse(*parts)
    after = velocity_after(contact.ball.velocity, contact.normal, mass, push)
    spin = contact.ball.spin
    mode = None if spin is None else "frictionless"
    impact = Impact(pair.restitution, push, after, energy_change(*parts), spin, mode)
    return impact, contact.closing


# Fewer operations lead from the velocities to the decisions below, each on terms that are no larger
# than those of the bounds.
_OPERATIONS = 40
# For a ball far heavier than the bat K is all but singular: its determinant cancels, and the
# impulse that grips loses as many digits. In doubles, a scene that loses over three is refused.
_MOST_LOST = 1e3


def _rub(
    run: Run, contact: ContactState, pair: CollisionParameters, error: N
) -> tuple[Impact, Mask]:
    """Let the ball grip the bat, or slide on it; see `longball.model.derivation`.

    The impulse that ends the slip, ``P = -K⁻¹ (…)``, grips if it lies in the cone of friction,
    ``|P_t| <= μ P_n``. Otherwise the ball slides in one direction to the end, with P on the cone.
    """
    scene, numbers, rows = run.scene, run.numbers, contact.closing
    ball, bat, normal = scene.ball, scene.bat, contact.normal
    mass, radius = numbers.exact(ball.mass), numbers.exact(ball.radius)
    bat_radius, friction = numbers.exact(bat.radius), numbers.exact(bat.friction)
    e, e_t = pair.restitution, tangential_restitution(bat, numbers)
    zero, one = numbers.exact(0.0), numbers.exact(1.0)

    # the slip, and what an impulse does to it
    velocity, spin = contact.ball.velocity, contact.ball.spin or (zero, zero, zero)
    motion = velocity, spin, contact.bat_velocity, bat_rotation(scene.swing, numbers)
    _, g_y, g_t = slip(*motion, normal, radius, bat_radius)
    g = contact.normal_speed, g_y, g_t
    k = inverse_masses(ball, bat, contact.lever_arm, pair, scene.reading, numbers)

    # grip, if the friction suffices
    # No element of K is below 1/m but that which couples, so that an impulse is at most m times
    # what it does to the slip; doubled for the coupling.
    lengths = one, radius, one, bat_radius
    sizes = (abs(x) * a for v, a in zip(motion, lengths, strict=True) for x in v)
    off = (error + _OPERATIONS * numbers.rounding) * sum(sizes, zero)
    wanted = gripping_impulse(k, e, e_t, g)
    rubbed = numbers.sqrt(wanted[1] * wanted[1] + wanted[2] * wanted[2])
    doubt = 2 * (1 + friction) * mass * (2 + e + abs(e_t)) * off
    margin = friction * wanted[0] - rubbed
    question = "whether the ball grips the bat or slides on it"
    grips, slides = run.decide(margin, doubt, question, rows)
    told = grips | slides
    if numbers.rounding:
        whole = k[0] * k[2]
        gripping = grips if scene.reading.slide_direction == "initial" else told
        lost = gripping & (abs(whole - k[1] * k[1]) * _MOST_LOST < whole)
        reason = "the ball is too heavy for the bat: the impulse by which it grips loses its digits"
        run.refuse(OutOfRange(f"{reason}; take the engine enclosure"), lost)
        told = told & (lost ^ True)

    # or else a slide, which needs a direction, and must make them part
    if scene.reading.slide_direction == "initial":
        way, speed, off_way = (g_y, g_t), numbers.sqrt(g_y * g_y + g_t * g_t), off
    else:
        way, speed, off_way = (-wanted[1], -wanted[2]), rubbed, doubt
    speed = numbers.where(grips, one, speed)
    question = "in which direction the ball slides on the bat"
    known, unknown = run.decide(speed, numbers.where(grips, zero, off_way), question, rows)
    reason = f"{question} cannot be said: it has no slip; use the reading slide_direction = final"
    run.refuse(Undecided(reason), unknown)
    direction = way[0] / speed, way[1] / speed
    resistance = numbers.where(grips, one, sliding_resistance(k, friction, direction))
    coupled = friction * abs(k[1])
    doubt = _OPERATIONS * numbers.rounding * (k[0] + coupled) + coupled * off_way / speed
    parts, jammed = run.decide(resistance, doubt, "whether ball and bat jam", rows)
    reason = "ball and bat jam: at so high a bat.friction no impulse parts them; take a lower one"
    run.refuse(CannotSolve(reason), jammed)
    slid = sliding_impulse(resistance, e, friction, g, direction)

    # what the impulse does
    x, y, z = (numbers.where(grips, a, b) for a, b in zip(wanted, slid, strict=True))
    push = x, y, z
    impact = Impact(
        e,
        x,
        velocity_after_push(velocity, push, normal, mass),
        push_energy(push, g, k),
        spin_after_push(spin, push, normal, mass, radius, inertia_factor(ball, numbers)),
        numbers.where(grips, "grip", "slide"),
        margin / (friction * abs(wanted[0])),
    )
    return impact, told & known & parts


@dataclass(frozen=True)
class Model:
    """The parts of the chain that may be replaced.

    Attributes
    ----------
    forces
        What may act on a ball in flight besides the model's own.
    collide
        From a `ContactState` to the `Impact`; see `collide`.
    """

    forces: tuple[Force, ...] = ()
    collide: Callable[..., tuple[Any, Any]] = collide


MODEL = Model()
