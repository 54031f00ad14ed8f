"""Ball and bat: how they meet, the impulse of Appendix A, and what it does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Generic

from longball.engines.chain.cases import Cases
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
from longball.model.numbers import N, Undecided, Vector, absolute
from longball.model.vectors import dot, minus


def solve_impacts(cases: Cases[N]) -> None:
    """Solve touchings that are given."""
    incoming = cases.scene.incoming
    position, velocity = cases.vector(incoming.position), cases.vector(incoming.velocity)
    ball = Ball(position, velocity, cases.spin(incoming.spin))
    offset = position[0], position[2] - cases.numbers.exact(incoming.bat_height)
    # Nothing has flown: the position is exact, and only roundings here are in doubt.
    cases, contact = meet(cases, ball, offset, 0.0)
    if contact is not None:
        cases, _, _ = strike(cases, contact, 0.0)
        cases.conclude("struck")


# --- the contact ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Ball(Generic[N]):
    """A ball that touches the bat."""

    # position, velocity, spin: m, m/s and rad/s; None: the scene has no spin
    position: Vector[N]
    velocity: Vector[N]
    spin: Vector[N] | None = None
    # Where it was along the bat, m, when that was looked at; None: as in `position`
    aside: N | None = None
    leaving: bool = False  # whether it is where it would leave the bat
    approach: Any = None  # how it came there; None: the touching is given


@dataclass(frozen=True)
class ContactState(Generic[N]):
    """Ball and bat at the touching, before the impulse."""

    # position, velocity, spin: of the ball, m, m/s and rad/s; no spin if the scene has none
    position: Vector[N]
    velocity: Vector[N]
    spin: Vector[N] | None
    normal: Vector[N]  # unit vector from the bat's axis to the ball
    bat_velocity: Vector[N]  # of the bat on its axis, m/s
    lever_arm: N  # r̃, m
    normal_speed: N  # Ṽ·n, m/s
    approach: Any = None  # that of the `Ball`


def meet(
    cases: Cases[N], ball: Ball[N], offset: tuple[N, N], inherited: float
) -> tuple[Cases[N], ContactState[N] | None]:
    """Look at balls and bats that touch; return those that approach each other.

    The `offset` is the way from the bat's axis to the ball's centre, m: in x, and up; `inherited`
    the relative error of position and velocity before any rounding here.
    """
    numbers, bat = cases.numbers, cases.scene.bat
    half = numbers.exact(bat.length) / 2
    slack = half * (inherited + 2 * numbers.rounding) if inherited else numbers.exact(0.0)
    question = "whether the ball meets the bat or its end"
    aside = ball.position[1] if ball.aside is None else ball.aside
    on_bat, beyond = cases.decide(half - absolute(aside), slack, question)
    (ended,) = cases.take(beyond)
    ended.conclude("beyond_bat")
    cases, ball, (across, above) = cases.take(on_bat, ball, offset)
    if cases.empty:
        return cases, None
    velocity = ball.velocity
    distance = numbers.sqrt(across * across + above * above)
    normal = (across / distance, numbers.exact(0.0), above / distance)
    arm = lever_arm(ball.position[1], cases.scene.bat, numbers)
    moving = bat_velocity(arm, cases.scene.swing, numbers)
    normal_speed = dot(minus(velocity, moving), normal)
    # Six operations stand between the velocities and their normal part.
    terms = [(v[i], normal[i]) for v in (velocity, moving) for i in (0, 2)]
    doubt = sum(
        (absolute(a * b) * (inherited + 6 * numbers.rounding) for a, b in terms), across * 0
    )
    # The force is the same for n and -n; a ball that would leave the bat approaches its back.
    approach = normal_speed if ball.leaving else -normal_speed
    question = "whether ball and bat approach or separate"
    closing, separating = cases.decide(approach, doubt, question)
    parts = normal, moving, arm, normal_speed
    contact = ContactState(ball.position, velocity, ball.spin, *parts, ball.approach)
    cases.record("contact.position", ball.position)
    cases.record("contact.normal", normal)
    cases.record("contact.bat_velocity", moving)
    cases.record("contact.normal_speed", normal_speed)
    (ended,) = cases.take(separating)
    ended.conclude("separating")
    cases, contact = cases.take(closing, contact)
    return cases, None if cases.empty else contact


# --- the impulse ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Impact(Generic[N]):
    """The impulse, N s, and what it does: see `longball.model.result.Impact`."""

    restitution: N
    impulse: N
    velocity: Vector[N]
    energy_change: N
    spin: Vector[N] | None = None
    mode: Any = None
    friction_margin: N | None = None


def strike(
    cases: Cases[N], contact: ContactState[N], error: N | float
) -> tuple[Cases[N], ContactState[N], Impact[N]]:
    """Apply the impulses; return those that part. See `collide`."""
    impact, part = cases.model.collide(cases, contact, error)
    cases, contact, impact = cases.take(part, contact, impact)
    if not cases.empty:
        for quantity in fields(Impact):
            if (value := getattr(impact, quantity.name)) is not None:
                cases.record(f"impact.{quantity.name}", value)
        _tell_recontact(cases, contact, impact)
    return cases, contact, impact


# Of the speeds. No engine's error at a contact is as large, but in a graze of 1e-7 m and less.
_TOLD_APART = 1e-6


def _tell_recontact(cases: Cases[N], contact: ContactState[N], impact: Impact[N]) -> None:
    """Record where a bat that swings on as before the impulse would strike the ball again.

    The impulse of the model makes ball and bat part, since the bat gives way by J/M. A batter does
    not: his bat goes on at ω', and if the ball is slower along the normal than that, so that
    ``(V⁺ - V_b)·n`` still has the sign of ``Ṽ·n``, they meet again at once. The model has one
    impulse; what it says of the flight is then not what such a bat would do. Of a ball that parts,
    and falls back on the bat later, nothing is said: where the bat is then, is not in the model.
    """
    numbers = cases.numbers
    rate = dot(minus(impact.velocity, contact.bat_velocity), contact.normal)
    parting = numbers.where(contact.normal_speed < 0, rate, -rate)
    speeds = sum(map(absolute, (*contact.velocity, *contact.bat_velocity)), rate * 0)
    doubt = speeds * numbers.exact(_TOLD_APART)
    again, parted = parting < -doubt, parting > doubt
    for condition, said in ((again, "certain"), ((again | parted) ^ True, "possible")):
        (some,) = cases.take(condition)
        if not some.empty:
            some.record("impact.recontact", said)


def collide(cases: Cases[N], contact: ContactState[N], error: N | float) -> tuple[Impact[N], Any]:
    """Return the impulse of Appendix A, on a bat with friction the oblique one; and if they part.

    The `error` is that of velocities and directions, relative, before any rounding here.
    """
    scene, numbers = cases.scene, cases.numbers
    pair = collision_parameters(scene.ball, scene.bat, contact.lever_arm, scene.reading, numbers)
    if scene.bat.friction is not None:
        return _rub(cases, contact, pair, error)
    parts = pair.reduced_mass, pair.restitution, contact.normal_speed
    push = impulse(*parts)
    mass = numbers.exact(scene.ball.mass)
    after = velocity_after(contact.velocity, contact.normal, mass, push)
    mode = None if contact.spin is None else "frictionless"
    return Impact(pair.restitution, push, after, energy_change(*parts), contact.spin, mode), True


# Between the velocities and the decisions below stand fewer operations, each on terms that are no
# larger than those of the bounds.
_OPERATIONS = 40
# A ball that is far heavier than the bat is gripped by an impulse that all but cancels in what it
# does to the bat: K is all but singular. So many roundings are lost at most, some of which show.
_MOST_LOST = 1e3


def _rub(
    cases: Cases[N],
    contact: ContactState[N],
    pair: CollisionParameters[N],
    error: N | float,
) -> tuple[Impact[N], Any]:
    """Let the ball grip the bat, or slide on it; see `longball.model.derivation`."""
    scene, numbers = cases.scene, cases.numbers
    ball, bat, normal = scene.ball, scene.bat, contact.normal
    mass, radius = numbers.exact(ball.mass), numbers.exact(ball.radius)
    bat_radius, friction = numbers.exact(bat.radius), numbers.exact(bat.friction)
    e, e_t = pair.restitution, tangential_restitution(bat, numbers)
    zero, one = numbers.exact(0.0), numbers.exact(1.0)
    spin = (zero, zero, zero) if contact.spin is None else contact.spin
    rotation = bat_rotation(scene.swing, numbers)
    motion = contact.velocity, spin, contact.bat_velocity, rotation
    _, g_y, g_t = slip(*motion, normal, radius, bat_radius)
    g = contact.normal_speed, g_y, g_t
    k = inverse_masses(ball, bat, contact.lever_arm, pair, scene.reading, numbers)

    # No element of K is below 1/m but that which couples, so that an impulse is at most m times
    # what it does to the slip; doubled for the coupling.
    lengths = one, radius, one, bat_radius
    sizes = (absolute(x) * a for v, a in zip(motion, lengths, strict=True) for x in v)
    off = (error + _OPERATIONS * numbers.rounding) * sum(sizes, zero)
    wanted = gripping_impulse(k, e, e_t, g)
    rubbed = numbers.sqrt(wanted[1] * wanted[1] + wanted[2] * wanted[2])
    doubt = 2 * (1 + friction) * mass * (2 + e + absolute(e_t)) * off
    question = "whether the ball grips the bat or slides on it"
    margin = friction * wanted[0] - rubbed
    grips, slides = cases.decide(margin, doubt, question)
    told = grips | slides
    if numbers.rounding:
        whole = k[0] * k[2]
        gripping = grips if scene.reading.slide_direction == "initial" else told
        lost = gripping & (absolute(whole - k[1] * k[1]) * _MOST_LOST < whole)
        (ended,) = cases.take(lost)
        reason = "the ball is too heavy for the bat: the impulse by which it grips loses its digits"
        ended.refuse(OutOfRange(f"{reason}; take the engine enclosure"))
        told = told & (lost ^ True)

    if scene.reading.slide_direction == "initial":
        way, speed, off_way = (g_y, g_t), numbers.sqrt(g_y * g_y + g_t * g_t), off
    else:
        way, speed, off_way = (-wanted[1], -wanted[2]), rubbed, doubt
    speed = numbers.where(grips, one, speed)
    question = "in which direction the ball slides on the bat"
    known, unknown = cases.decide(speed, numbers.where(grips, zero, off_way), question)
    (ended,) = cases.take(unknown)
    reason = f"{question} cannot be said: it has no slip; use the reading slide_direction = final"
    ended.refuse(Undecided(reason))
    direction = way[0] / speed, way[1] / speed
    resistance = numbers.where(grips, one, sliding_resistance(k, friction, direction))
    coupled = friction * absolute(k[1])
    doubt = _OPERATIONS * numbers.rounding * (k[0] + coupled) + coupled * off_way / speed
    parts, jammed = cases.decide(resistance, doubt, "whether ball and bat jam")
    (ended,) = cases.take(jammed)
    reason = "ball and bat jam: at so high a bat.friction no impulse parts them; take a lower one"
    ended.refuse(CannotSolve(reason))
    slid = sliding_impulse(resistance, e, friction, g, direction)
    x, y, z = (numbers.where(grips, a, b) for a, b in zip(wanted, slid, strict=True))
    push = x, y, z
    modes: Any = "grip", "slide"
    impact = Impact(
        e,
        x,
        velocity_after_push(contact.velocity, push, normal, mass),
        push_energy(push, g, k),
        spin_after_push(spin, push, normal, mass, radius, inertia_factor(ball, numbers)),
        numbers.where(grips, *modes),
        margin / (friction * absolute(wanted[0])),
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
