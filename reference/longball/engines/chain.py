"""The chain of an at-bat: pitch, plate, contact, impact, landing.

Written once, over any engine, any number system, and one scene or columns of scenes (`Run`). It
follows the paper's Sec. III: the throw, the swing that is aimed at where the throw would cross the
plate, the collision of Sec. III.C and Appendix A, the flight to the ground or the fence. Its parts,
the forces and the collision, are passed in (`Model`): a known mistake is the same chain with
another part. `solve` and its kin make results of scenes, one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Any, get_args

from pydantic import ValidationError

from longball.engines.digits import to_digits
from longball.engines.engine import (
    CannotSolve,
    Engine,
    Launch,
    ManyAtOnce,
    OutOfRange,
    Stepped,
    Touch,
)
from longball.engines.event import (
    BatSection,
    Event,
    Events,
    ground,
    margin_error,
    plate,
    risen,
    vertical,
)
from longball.engines.fence import Place, at_stop, first_crossing, stop_at
from longball.engines.parallel import in_parallel
from longball.engines.path import Flight, Leg, Path, Trajectory
from longball.engines.path_engine import arrived
from longball.model import bat as bats
from longball.model import impact as formulas
from longball.model import result as written
from longball.model.frame import Frame, launch_frame
from longball.model.law import Force, Law, State, in_plane, law_of
from longball.model.numbers import N, Numbers, Undecided, Vector, dot, minus
from longball.model.quantities import replaced, viewed
from longball.model.result import Outcome, Result
from longball.model.scene import AtBatScene, InvalidScene, Scene, landing_height

# --- the run of a chain ---------------------------------------------------------------------------

# A mask selects scenes: a bool for one scene, an array of flags for columns. A stage of the chain
# runs on the rows of its mask, if there are any. Numbers in other rows have no meaning, and are
# never recorded.
Mask = Any


@dataclass
class Run:
    """State of one scene in the chain; `longball.engines.batch.columns.Columns` is for many.

    A chain uses masks only through the methods with the argument `rows`.
    """

    scene: Any  # has the blocks of a scene as attributes, with a number or an array each
    engine: Any  # computes the flights
    model: Model  # the parts of the chain
    # The quantities recorded so far, by name, and the outcome
    answer: dict[str, Any] = field(default_factory=dict)
    legs: list[Leg] = field(default_factory=list)  # the flights of the scene, in order
    numbers: Any = field(init=False)  # the number system; see `longball.model.numbers.Numbers`
    everything: Mask = field(default=True, init=False)  # the mask of all scenes

    def __post_init__(self) -> None:
        self.numbers = self.engine.numbers

    # --- masks -----------------------------------------------------------------------------------

    def any(self, rows: Mask) -> bool:
        """Return True if a mask has any rows."""
        return bool(rows)

    def decide(self, x: N, error: N, question: str, rows: Mask) -> tuple[Mask, Mask]:
        """Return two masks: of the rows in which ``x > 0``, and of those in which it is not.

        A row of columns that is in doubt is in neither.

        Raises `Undecided` for one scene, in doubt.
        """
        positive = rows and self.numbers.positive(x, error, question)
        return positive, rows and not positive

    # --- flights ---------------------------------------------------------------------------------

    def fly(self, law: Law, start: State, events: Events, limit: N, rows: Mask) -> Flight:
        """Fly until the first of several events; in other rows the flight stays at its start."""
        if not rows:
            return Flight(Path(()), "", self.numbers.exact(0.0), start)
        flight: Flight = self.engine.fly(law, start, events, limit)
        return flight

    def touch(self, pitch: Any, law: Law, bat: BatSection, events: Events, rows: Mask) -> Touch:
        """Find how pitches meet the bat; see `longball.engines.engine.Engine.touch`."""
        touch: Touch = self.engine.touch(pitch, law, bat, events, self.time_limit)
        return touch

    def leave(self, rows: Mask) -> bool:
        """Leave rows of columns to the scalar chain; return False for one scene."""
        return False

    # --- answers ---------------------------------------------------------------------------------

    def record(self, name: str, value: Any, rows: Mask) -> None:
        """Record a quantity of the results, a number or a vector: ``plate.time``."""
        if rows:
            self.answer[name] = value

    def conclude(self, outcome: Outcome, rows: Mask) -> None:
        """Record the outcome; nothing that a chain does afterwards concerns these rows."""
        self.record("outcome", outcome, rows)

    def refuse(self, reason: CannotSolve | Undecided, rows: Mask) -> None:
        """Mark rows as not solved; for a single scene, raise the error."""
        if rows:
            raise reason

    def follow(self, frame: Frame, flight: Flight, begin: N, rows: Mask) -> None:
        """Append a flight to the trajectory; it begins s after the start of the scene."""
        if rows:
            self.legs.append(Leg(begin, frame, flight))

    # --- the scene -------------------------------------------------------------------------------

    @property
    def time_limit(self) -> N:
        """The longest time of flight, s."""
        return self.numbers.exact(self.scene.time_limit)

    def vector(self, values: Sequence[float] | None) -> Any:
        """Return three numbers of the scene; None if it gives none."""
        return None if values is None else tuple(map(self.numbers.exact, values))

    def law(self, frame: Frame) -> Law:
        """Return the law of motion of a flight in a frame."""
        return law_of(self.scene, frame, self.numbers, self.model.forces)

    def ground(self, start: State) -> Event:
        """Return the landing of a flight from a state."""
        return ground(landing_height(self.scene, self.numbers.exact), start, self.numbers)


# --- a flight -------------------------------------------------------------------------------------


def fly(
    run: Run,
    law: Law,
    start: State,
    surfaces: Callable[[State], list[Event]],  # the events that may end a flight from a state
    limit: N,
    rows: Mask,
) -> Flight:
    """Fly to a surface or the time limit, s, through the vertical if necessary.

    Under the reading `always_up`, a ball that reaches the vertical cannot leave it: the horizontal
    component of the lift drives it back from either side. It continues without lift, straight up
    and down (the sliding solution in Filippov's sense; downwards, the symmetric one of two). A ball
    at rest or with a vertical velocity is already there.
    """
    start = law.state_of(start)
    if not lift_is_always_up(run, law):
        return run.fly(law, start, surfaces(start), limit, rows)

    # First to the vertical, with lift; then on from there, without.
    turn, upright = vertical(start, run.numbers), start.u == 0
    leaning = rows & (upright ^ True)  # ^ True: see `longball.model.numbers`
    first = run.fly(law, start, [*surfaces(start), turn], limit, leaning)
    upright = rows & (upright | first.stopped("vertical"))
    if not run.any(upright):
        return first
    there = turn.place(first.state)
    second = run.fly(law.without("lift"), there, surfaces(there), limit - first.time, upright)
    return first.then(second) if run.any(leaning) else second


def lift_is_always_up(run: Run, law: Law) -> bool:
    """Return True if lift points up whatever the ball's spin."""
    if law.shape.spins:  # then lift follows the spin: of the scene, or from a bat with friction
        return False
    return run.scene.reading.lift_direction == "always_up" and "lift" in law.strengths


def spin_at(
    frame: Frame,
    law: Law,
    state: State,
    numbers: Numbers,
    error: N | None = None,
) -> Vector | None:
    """Return the spin of the ball in a state that a flight has come to, rad/s.

    The state's `error` is relative to its size; left out, the state is exact.
    """
    if frame.spin is None:
        return None
    # Which branch of the spin's decay holds depends on the state: its error may leave that open.
    off = state.z * 0 if error is None else error * (1 + abs(state.z))
    left = arrived(law, state, numbers, off).spin_left(state, numbers)
    return frame.spin[0] * left, frame.spin[1] * left, frame.spin[2] * left


# --- pitch and bat --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pitch:
    """A pitch, flown to the plate or to an earlier end."""

    frame: Frame
    law: Law
    start: State
    flight: Flight
    crossed: Mask  # whether it reached the plate


def throw(run: Run) -> Pitch:
    """Fly the pitch to x = 0; record the outcome of pitches that end before."""
    numbers, pitch = run.numbers, run.scene.pitch

    # the release, with the velocity given or towards the point aimed at
    x, y, z = place = run.vector(pitch.release)
    if pitch.velocity is None:
        aim_y, aim_z = map(numbers.exact, pitch.aim)
        toward = (-x, aim_y - y, aim_z - z)
        scale = numbers.exact(pitch.speed) / numbers.sqrt(dot(toward, toward))
        velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    else:
        velocity = run.vector(pitch.velocity)
    frame, start = launch_frame(place, velocity, numbers, run.vector(pitch.spin))
    law = run.law(frame)

    # the flight
    flight = fly(
        run,
        law,
        start,
        lambda state: [run.ground(state), plate(frame, state, numbers)],
        run.time_limit,
        run.everything,
    )
    run.follow(frame, flight, numbers.exact(0.0), run.everything)
    run.conclude("grounded", run.everything & flight.stopped("ground"))
    run.conclude("airborne", run.everything & flight.stopped("time"))

    # the plate
    crossed = run.everything & flight.stopped("plate")
    if run.any(crossed):
        _, y, z = frame.position(flight.state)
        u, v, w = velocity = frame.velocity(flight.state)
        angle, level = numbers.angle, numbers.sqrt(u * u + v * v)
        run.record("plate.time", flight.time, crossed)
        run.record("plate.position", (numbers.exact(0.0), y, z), crossed)
        run.record("plate.velocity", velocity, crossed)
        run.record("plate.approach.vertical", angle(w, level), crossed)
        run.record("plate.approach.horizontal", angle(v, -u), crossed)
    return Pitch(frame, law, start, flight, crossed)


@dataclass(frozen=True)
class BatEncounter:
    """A pitch, the bat, and how they meet."""

    pitch: Pitch
    bat: BatSection
    touch: Touch


def approach_bat(run: Run) -> BatEncounter | None:
    """Fly the pitch, place the bat and search for the contact; None if no pitch is at the plate."""
    pitch, numbers, scene = throw(run), run.numbers, run.scene
    if not run.any(pitch.crossed):
        return None
    # z_b = z'_b + σ_b: the batter swings at the height of the pitch at the plate, but for an offset
    # (paper, Sec. III.A)
    height = pitch.flight.state.z + numbers.exact(scene.swing.height_offset)
    reach = numbers.exact(scene.ball.radius) + numbers.exact(scene.bat.radius)
    bat = BatSection(pitch.frame, height, reach)
    events = [run.ground(pitch.start)]
    if lift_is_always_up(run, pitch.law):
        events.append(vertical(pitch.start, numbers))
    touch = run.touch(pitch.flight, pitch.law, bat, events, pitch.crossed)
    return BatEncounter(pitch, bat, touch)


def meet_bat(run: Run) -> ContactState | None:
    """Return the contact of the pitches that are struck; None if there are none.

    The others are recorded as `missed`, `beyond_bat` or `separating`. The contact does not depend
    on the restitution, so that P(e) can use it again for every e.
    """
    approach = approach_bat(run)
    if approach is None:
        return None
    numbers, pitch, touch = run.numbers, approach.pitch, approach.touch
    run.record("contact.margin", touch.margin, pitch.crossed)
    touched, missed = pitch.crossed & (touch.touched == 1), pitch.crossed & (touch.touched == 0)
    run.refuse(Undecided(touch.doubt), pitch.crossed & ((touched | missed) ^ True))
    run.conclude("missed", missed)
    if not run.any(touched):
        return None
    error, frame, state = run.engine.flight_error, pitch.frame, touch.state
    assert state is not None
    ball = (
        frame.position(state),
        frame.velocity(state),
        spin_at(frame, pitch.law, state, numbers, numbers.exact(error)),
    )
    run.record("contact.time", touch.time, touched)
    run.record("contact.position", ball[0], touched)
    return meet(run, *ball, approach.bat.offset(state, numbers), error, touched, approach)


def finish(run: Run, contact: ContactState | None) -> None:
    """Apply the impulse and fly the batted ball."""
    if contact is None:
        return
    engine, touch, pitch = run.engine, contact.approach.touch, contact.approach.pitch

    # the impulse: only the choice between grip and slide needs an error
    error = 0.0 if run.scene.bat.friction is None else _contact_error(run, contact)
    impact, parted = strike(run, contact, error)
    if not run.any(parted):
        return

    # the launch: at the contact, or after the contact force has acted for two or three steps
    if isinstance(engine, Stepped):
        launch = engine.rebound(
            pitch.frame,
            touch,
            minus(impact.velocity, contact.velocity),
            lambda frame: run.law(replace(frame, spin=impact.spin)),
            run.ground(pitch.start),
        )
        launch = replace(launch, spin=impact.spin)
    else:
        off = None
        if run.numbers.rounding:
            # V⁺ = V - (1 + ẽ) (μ/m) (Ṽ·n) n. The error of V counts once, that of n twice, with a
            # factor (1 + ẽ) μ/m of at most two: 1 + 2 · 2 = 5. The factor is larger only under
            # readings that create energy, where ẽ exceeds 1.
            ball, bat, sqrt = contact.velocity, contact.bat_velocity, run.numbers.sqrt
            speeds = sqrt(dot(ball, ball)) + sqrt(dot(bat, bat))
            off = 5 * _contact_error(run, contact) * speeds
        launch = Launch(
            contact.position,
            impact.velocity,
            touch.time,
            touch.time * 0,  # no delay, in the shape and the numbers of the time
            spin=impact.spin,
            error=off,
        )
    land(run, launch, "batted", parted)


def _contact_error(run: Run, contact: ContactState) -> N:
    """Relative error of velocities and directions at the contact.

    A shift of the path by δ, in units of the reach r, turns the normal by ``δ |v|/|v·n|``. That
    diverges at a graze, but the normal turns by √(2 δ) at most: the angle between the normals of a
    graze and of a contact that is δ r deep, from ``r cos θ = r (1 - δ)``.
    """
    numbers, error = run.numbers, run.engine.flight_error
    bat, pitch = contact.approach.bat, contact.approach.pitch
    moved = margin_error(bat, pitch.flight.state.z, error, numbers) / bat.reach
    speed = numbers.sqrt(dot(contact.velocity, contact.velocity))
    towards = abs(dot(contact.velocity, contact.normal))
    most = numbers.sqrt(2 * moved)
    steep = moved * speed > most * towards
    turned = numbers.where(steep, most, moved * speed / numbers.where(steep, speed, towards))
    return error + moved + turned


# --- the contact ----------------------------------------------------------------------------------


def solve_impacts(run: Run) -> None:
    """Solve impact scenes, in which the touching is given."""
    incoming = run.scene.incoming
    position, velocity = run.vector(incoming.position), run.vector(incoming.velocity)
    offset = position[0], position[2] - run.numbers.exact(incoming.bat_height)
    # Nothing has flown: the position is exact, and only roundings here are in doubt.
    contact = meet(run, position, velocity, run.vector(incoming.spin), offset, 0.0, run.everything)
    if contact is not None:
        _, parted = strike(run, contact, 0.0)
        run.conclude("struck", parted)


@dataclass(frozen=True)
class ContactState:
    """Ball and bat at the touching, before the impulse."""

    # position, velocity, spin: of the ball, m, m/s and rad/s; None: the scene has no spin
    position: Vector
    velocity: Vector
    spin: Vector | None
    normal: Vector  # unit vector from the bat's axis to the ball
    bat_velocity: Vector  # of the bat on its axis, m/s
    lever_arm: N  # r̃, m
    normal_speed: N  # Ṽ·n, m/s
    closing: Mask  # whether they approach each other
    approach: Any  # the `BatEncounter` that led to it; None: the touching is given


def meet(
    run: Run,
    position: Vector,  # of the ball, m
    velocity: Vector,  # m/s
    spin: Vector | None,  # rad/s
    offset: tuple[N, N],  # from the bat's axis to the ball's centre, m: in x, and up
    inherited: float,  # relative error of position and velocity, without the rounding here
    rows: Mask,
    approach: BatEncounter | None = None,
) -> ContactState | None:
    """Return the contact of balls and bats that approach each other; None if none do.

    Others are recorded as `beyond_bat` or `separating`.
    """
    numbers, bat, end_y, leaving = run.numbers, run.scene.bat, position[1], False
    if approach is not None:
        touch, leaving = approach.touch, approach.touch.leaving
        # Verlet's method compares the y of the first step inside the bat with the bat's end (paper,
        # Sec. III.C).
        if touch.inside is not None:
            end_y = approach.pitch.frame.position(touch.inside)[1]

    # along the bat
    half = numbers.exact(bat.length) / 2
    slack = half * (inherited + 2 * numbers.rounding) if inherited else numbers.exact(0.0)
    question = "whether the ball meets the bat or its end"
    on_bat, beyond = run.decide(half - abs(end_y), slack, question, rows)
    run.conclude("beyond_bat", beyond)
    if not run.any(on_bat):
        return None

    # across the bat
    across, above = offset
    distance = numbers.sqrt(across * across + above * above)
    normal = (across / distance, numbers.exact(0.0), above / distance)
    arm = half - position[1]  # r̃, from the pivot at y = L/2
    moving = bats.bat_velocity(arm, run.scene.swing, numbers)
    normal_speed = dot(minus(velocity, moving), normal)
    # Ṽ = V - V_b (paper, Sec. III.C). Six operations lead from the velocities to its normal part,
    # each with a rounding of the terms.
    terms = [(v[i], normal[i]) for v in (velocity, moving) for i in (0, 2)]
    doubt = sum((abs(a * b) * (inherited + 6 * numbers.rounding) for a, b in terms), across * 0)
    # The impulse is the same for n and -n; with Appendix B's larger root the ball is where it would
    # leave the bat, and approaches when it moves outwards.
    rate = normal_speed if leaving else -normal_speed
    question = "whether ball and bat approach or separate"
    closing, separating = run.decide(rate, doubt, question, on_bat)
    run.record("contact.position", position, on_bat)
    run.record("contact.normal", normal, on_bat)
    run.record("contact.bat_velocity", moving, on_bat)
    run.record("contact.normal_speed", normal_speed, on_bat)
    run.conclude("separating", separating)
    if not run.any(closing):
        return None
    return ContactState(
        position, velocity, spin, normal, moving, arm, normal_speed, closing, approach
    )


# --- the impulse ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Impact:
    """The impulse, N s, and its effects: see `longball.model.result.Impact`."""

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

    # Would a bat that swings on as before strike the ball again? In the model the impulse slows the
    # bat, too, so that the two part. A batter's bat keeps its speed: if (V⁺ - V_b)·n still has the
    # sign of Ṽ·n, the ball is slower along the normal than that bat, and they touch again at once.
    # The model's single impulse then misstates the flight. A ball that falls back on the bat later
    # is not considered, since the model does not say where the bat is by then.
    rate = dot(minus(impact.velocity, contact.bat_velocity), contact.normal)
    parting = run.numbers.where(contact.normal_speed < 0, rate, -rate)
    speeds = sum(map(abs, (*contact.velocity, *contact.bat_velocity)), rate * 0)
    doubt = speeds * run.numbers.exact(_RESOLVED)
    again, apart = parting < -doubt, parting > doubt
    run.record("impact.recontact", "certain", parted & again)
    run.record("impact.recontact", "possible", parted & ((again | apart) ^ True))
    return impact, parted


# Of the speeds. No engine's error at a contact is as large, but in a graze of 1e-7 m and less.
_RESOLVED = 1e-6


def collide(run: Run, contact: ContactState, error: N) -> tuple[Impact, Mask]:
    """Return the impulse of Appendix A, or of an oblique impact on a bat with friction.

    Parameters
    ----------
    run
        The scene, or columns of them, and the engine's numbers.
    contact
        Ball and bat at the touching.
    error
        Of velocities and directions, relative, without the rounding here.

    Returns
    -------
    impact : Impact
        The impulse, N s, and the velocity, m/s, and spin, rad/s, after it.
    parted : bool or array of flags
        The rows in which ball and bat part.

    Raises
    ------
    CannotSolve, Undecided
        Of one scene: no impulse parts them, or its numbers leave open whether the ball slides.
    """
    scene, numbers = run.scene, run.numbers
    pair = bats.collision_parameters(
        scene.ball, scene.bat, contact.lever_arm, scene.reading, numbers
    )
    if scene.bat.friction is not None:
        return _rub(run, contact, pair, error)
    parts = pair.reduced_mass, pair.restitution, contact.normal_speed
    mass, push = numbers.exact(scene.ball.mass), formulas.impulse(*parts)
    after = formulas.velocity_after(contact.velocity, contact.normal, mass, push)
    spin = contact.spin
    mode = None if spin is None else "frictionless"
    impact = Impact(pair.restitution, push, after, formulas.energy_change(*parts), spin, mode)
    return impact, contact.closing


# Fewer operations lead from the velocities to the decisions below, each on terms that are no larger
# than those of the bounds.
_OPERATIONS = 40  # a free choice above them
# If the ball is far heavier than the bat, K is nearly singular: digits cancel in its determinant,
# and the gripping impulse loses as many. In doubles, a scene that loses more than three is refused.
_MOST_LOST = 1e3


def _rub(
    run: Run, contact: ContactState, pair: bats.CollisionParameters, error: N
) -> tuple[Impact, Mask]:
    """Let the ball grip the bat, or slide on it; see `longball.model.derivation`.

    The impulse that ends the slip, ``P = -K⁻¹ (…)``, grips if it lies in the cone of friction,
    ``|P_t| <= μ P_n``. Otherwise the ball slides in one direction to the end, with P on the cone.
    """
    scene, numbers, rows = run.scene, run.numbers, contact.closing
    ball, bat, normal = scene.ball, scene.bat, contact.normal
    mass, radius = numbers.exact(ball.mass), numbers.exact(ball.radius)
    bat_radius, friction = numbers.exact(bat.radius), numbers.exact(bat.friction)
    e, e_t = pair.restitution, bats.tangential_restitution(bat, numbers)
    zero, one = numbers.exact(0.0), numbers.exact(1.0)

    # the slip, and its change by an impulse
    velocity, spin = contact.velocity, contact.spin or (zero, zero, zero)
    motion = velocity, spin, contact.bat_velocity, bats.bat_rotation(scene.swing, numbers)
    _, g_y, g_t = formulas.slip(*motion, normal, radius, bat_radius)
    g = contact.normal_speed, g_y, g_t
    k = bats.inverse_masses(ball, bat, contact.lever_arm, pair, scene.reading, numbers)

    # grip, if the friction suffices
    # The diagonal elements of K are at least 1/m, so that an impulse is at most m times its change
    # of the slip; the factor 2 allows for the coupling.
    lengths = one, radius, one, bat_radius
    sizes = (abs(x) * a for v, a in zip(motion, lengths, strict=True) for x in v)
    off = (error + _OPERATIONS * numbers.rounding) * sum(sizes, zero)
    wanted = formulas.gripping_impulse(k, e, e_t, g)
    rubbed = numbers.sqrt(wanted[1] * wanted[1] + wanted[2] * wanted[2])
    doubt = 2 * (1 + friction) * mass * (2 + e + abs(e_t)) * off
    margin = friction * wanted[0] - rubbed
    question = "whether the ball grips the bat or slides on it"
    grips, slides = run.decide(margin, doubt, question, rows)
    decided = grips | slides
    if numbers.rounding:
        whole = k[0] * k[2]
        gripping = grips if scene.reading.slide_direction == "initial" else decided
        lost = gripping & (abs(whole - k[1] * k[1]) * _MOST_LOST < whole)
        reason = "the ball is too heavy for the bat: the impulse by which it grips loses its digits"
        run.refuse(OutOfRange(f"{reason}; take the engine enclosure"), lost)
        decided = decided & (lost ^ True)

    # or else a slide, which needs a direction, and must make them part
    if scene.reading.slide_direction == "initial":
        slip, speed, off_slip = (g_y, g_t), numbers.sqrt(g_y * g_y + g_t * g_t), off
    else:
        slip, speed, off_slip = (-wanted[1], -wanted[2]), rubbed, doubt
    speed = numbers.where(grips, one, speed)
    question = "in which direction the ball slides on the bat"
    known, unknown = run.decide(speed, numbers.where(grips, zero, off_slip), question, rows)
    reason = f"{question} cannot be said: it has no slip; use the reading slide_direction = final"
    run.refuse(Undecided(reason), unknown)
    direction = slip[0] / speed, slip[1] / speed
    resistance = numbers.where(grips, one, formulas.sliding_resistance(k, friction, direction))
    coupled = friction * abs(k[1])
    doubt = _OPERATIONS * numbers.rounding * (k[0] + coupled) + coupled * off_slip / speed
    parts, jammed = run.decide(resistance, doubt, "whether ball and bat jam", rows)
    reason = "ball and bat jam: at so high a bat.friction no impulse parts them; take a lower one"
    run.refuse(CannotSolve(reason), jammed)
    slid = formulas.sliding_impulse(resistance, e, friction, g, direction)

    # the effects of the impulse
    x, y, z = (numbers.where(grips, a, b) for a, b in zip(wanted, slid, strict=True))
    push = x, y, z
    impact = Impact(
        e,
        x,
        formulas.velocity_after_push(velocity, push, normal, mass),
        formulas.push_energy(push, g, k),
        formulas.spin_after_push(
            spin, push, normal, mass, radius, bats.inertia_factor(ball, numbers)
        ),
        numbers.where(grips, "grip", "slide"),
        margin / (friction * abs(wanted[0])),
    )
    return impact, decided & known & parts


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


# --- the landing ----------------------------------------------------------------------------------


def solve_flights(run: Run) -> None:
    """Solve flight scenes."""
    launch, nothing = run.scene.launch, run.numbers.exact(0.0)
    position, velocity = run.vector(launch.position), run.vector(launch.velocity)
    free = Launch(position, velocity, nothing, nothing, spin=run.vector(launch.spin))
    land(run, free, "landed", run.everything)


@dataclass(frozen=True)
class Batted:
    """A batted ball: its launch, and the frame, law and start of its flight."""

    launch: Launch
    frame: Frame
    law: Law
    start: State


def land(run: Run, launch: Launch, outcome: Outcome, rows: Mask) -> None:
    """Fly to the ground or to a fence; a ball that lands has the given outcome.

    Without a fence the ball comes down. With one, a flight in its plane meets one place of the
    fence, known beforehand; a flight in space, or in steps, is searched for the crossing.
    """
    numbers, limit = run.numbers, run.time_limit
    frame, start = launch_frame(launch.position, launch.velocity, numbers, launch.spin)
    law = run.law(frame)
    ball = Batted(launch, frame, law, start)

    # landed before it was free, or with a fence
    if launch.landed:
        down = Flight(Path(()), "ground", numbers.exact(0.0), law.state_of(start))
        _come_down(run, ball, down, outcome, rows)
        return
    if run.scene.fence is not None:
        if "v" not in law.variables and not isinstance(run.engine, Stepped):
            _cross_fence_in_plane(run, ball, outcome, rows)
        elif not run.leave(rows):  # only paths can be searched
            _cross_fence_in_space(run, ball, outcome, rows)
        return

    # from below the ground
    # A ball that is hit to an upper deck is such a ball: `ground.height` is above its launch. It
    # lands when it falls through that height, and so has to rise through it first. A pitch has not
    # touched the ground, so that a batted ball starts above it.
    if hasattr(run.scene, "launch"):
        height = landing_height(run.scene, numbers.exact)
        rise = height - start.z
        under, rows = run.decide(rise, rise * 0, "whether the ball starts below the ground", rows)
        if run.any(under):
            up = fly(run, law, start, lambda at: [risen(height, at, numbers)], limit, under)
            turned = under & up.stopped("risen")
            if run.any(turned):
                up = up.then(_fly_down(run, ball, up.state, limit - up.time, turned))
            _come_down(run, ball, up, outcome, under)

    # from above it
    if run.any(rows):
        _come_down(run, ball, _fly_down(run, ball, start, limit, rows), outcome, rows)


def _fly_down(run: Run, ball: Batted, start: State, limit: N, rows: Mask) -> Flight:
    """Fly to the ground."""
    return fly(run, ball.law, start, lambda state: [run.ground(state)], limit, rows)


def _come_down(
    run: Run,
    ball: Batted,
    flight: Flight,
    outcome: Outcome,
    rows: Mask,
    fair: bool | None = None,
) -> None:
    """Record landings, and the outcome of flights that end on the ground or at the time limit.

    `fair` is given for a ball that has left the field: then the place where it did decides.
    """
    numbers, scene, launch, frame = run.numbers, run.scene, ball.launch, ball.frame

    # the end of the flight
    run.follow(frame, flight, launch.time, rows)
    if launch.error is not None:
        # Is it certain whether the ball lands in the time limit? The engine allows for the error of
        # its flight, but not for that of the velocity at launch, δv, which moves the ball by δv t:
        # compare that with the height that is left.
        left = (run.time_limit - flight.time) * abs(flight.state.w)
        above = flight.state.z - landing_height(scene, numbers.exact)
        margin = numbers.where(flight.stopped("time"), above, left)
        question = "whether the ball touches the ground in the time limit"
        certain, never = run.decide(margin, launch.error * flight.time, question, rows)
        rows = certain | never
    aloft: Outcome = "home_run" if outcome == "home_run" else "airborne"
    run.conclude(aloft, rows & flight.stopped("time"))
    rows = rows & flight.stopped("ground")
    if not run.any(rows):
        return

    # the landing
    _rise(run, ball, flight, rows)
    state = flight.state
    x, y, z = position = frame.position(state)
    run.record("landing.time", launch.time + flight.time, rows)
    run.record("landing.hang_time", launch.delay + flight.time, rows)
    run.record("landing.position", (x, y, z), rows)
    u, v, w = velocity = frame.velocity(state)
    run.record("landing.velocity", velocity, rows)
    run.record("landing.angle", numbers.angle(-w, numbers.sqrt(u * u + v * v)), rows)
    if scene.reading.distance_origin == "launch":
        # s and y are measured from the launch: no digits cancel where the launch is far away.
        x = state.s
        y = x * 0 if in_plane(state) else state.y
    run.record("landing.distance", numbers.sqrt(x * x + y * y), rows)
    if frame.spin is not None:
        run.record("landing.spin", spin_at(frame, ball.law, state, numbers), rows)
    if hasattr(state, "path") and scene.reading.spin_decay == "path":
        run.record("landing.path", state.path, rows)

    # fair or foul
    if fair is not None:
        run.record("landing.fair", fair, rows)
    elif scene.fence is not None:
        lands_foul, lands_fair = _foul(run, position, "lands fair", rows)
        run.record("landing.fair", lands_fair, rows)
        rows = lands_foul | lands_fair
    run.conclude(outcome, rows)


def _rise(run: Run, ball: Batted, flight: Flight, rows: Mask) -> None:
    """Record the highest point of flights, unless they only rise."""
    if (top := flight.highest(run.numbers)) is not None:
        run.record("apex.time", ball.launch.time + top[0], rows)
        run.record("apex.position", ball.frame.position(top[1]), rows)


# --- the fence ------------------------------------------------------------------------------------


def _flight_error(run: Run) -> float:
    """Return the relative error of a state of a flight and of a few roundings of it."""
    error: float = run.engine.flight_error + 8 * run.numbers.rounding
    return error


def _heading_error(run: Run) -> float:
    """Return the relative error of the direction of a flight that stays in its plane.

    The flight itself adds none; the heading of a batted ball has the error of its pitch.
    """
    rounded: float = 8 * run.numbers.rounding
    return rounded if hasattr(run.scene, "launch") else _flight_error(run)


def _foul(run: Run, position: Vector, what: str, rows: Mask) -> tuple[Mask, Mask]:
    """Return two masks: of foul and of fair balls. A ball on the foul line is fair."""
    # fair territory is |y| <= x, with the foul lines at 45°
    x, y, _ = position
    error = _flight_error(run) * (abs(x) + abs(y))
    return run.decide(abs(y) - x, error, f"whether the ball {what}", rows)


def _cross_fence_in_plane(run: Run, ball: Batted, outcome: Outcome, rows: Mask) -> None:
    """Fly to the ground, or to the place of the fence that the ball heads for, ahead or behind."""
    numbers, start = run.numbers, ball.start
    error = numbers.exact(_heading_error(run))
    places, fences = {}, []
    for name, sense in (("fence", 1), ("fence_behind", -1)):
        fence = run.scene.fence
        s, places[name] = stop_at(fence, ball.frame, start.s, sense, error, numbers)
        fences.append(at_stop(name, s, sense, numbers))
    flight = fly(
        run, ball.law, start, lambda state: [run.ground(state), *fences], run.time_limit, rows
    )
    inside = rows & (flight.stopped("ground") | flight.stopped("time"))
    if run.any(inside):
        _come_down(run, ball, flight, outcome, inside)
    for name, place in places.items():
        stopped = rows & flight.stopped(name)
        if run.any(stopped):
            _meet_fence(run, ball, flight, place, outcome, stopped)


def _cross_fence_in_space(run: Run, ball: Batted, outcome: Outcome, rows: Mask) -> None:
    """Fly to the ground, and follow the flight, which leaves its plane, past the fence."""
    frame, numbers = ball.frame, run.numbers
    flight = _fly_down(run, ball, ball.start, run.time_limit, rows)
    # An error δ of a state moves the time of a landing by δ/|w|; the time limit is exact.
    error = numbers.exact(_flight_error(run))
    (x, y, z), w = frame.position(flight.state), frame.velocity(flight.state)[2]
    off = error * (1 + abs(x) + abs(y) + abs(z))
    late = off / abs(w) if flight.stop == "ground" else numbers.exact(0.0)
    pieces = flight.path.pieces()
    met = first_crossing(run.scene.fence, frame, pieces, flight.time, late, error, numbers)
    if met is None:
        _come_down(run, ball, flight, outcome, rows)
        return
    x, y, z = frame.position(met.state)
    above = z - landing_height(run.scene, numbers.exact)
    off = error * (1 + abs(x) + abs(y) + abs(z))
    run.decide(above, off, "whether the ball reaches the fence before it touches the ground", rows)
    if met.doubtful:
        reason = "it comes as close as a state's error"
        question = "whether the ball reaches the fence"
        run.refuse(Undecided(f"{question} cannot be decided: {reason}"), rows)
    stopped = Flight(flight.path, "fence", met.time, met.state)
    _meet_fence(run, ball, stopped, met.place, outcome, rows, flight)


def _meet_fence(
    run: Run,
    ball: Batted,
    flight: Flight,
    place: Place,
    outcome: Outcome,
    rows: Mask,
    landing: Flight | None = None,
) -> None:
    """Conclude flights that are at the fence; `landing` has where they land if they go on."""
    numbers, frame, begin = run.numbers, ball.frame, ball.launch.time
    x, y, z = frame.position(flight.state)
    u, v, w = frame.velocity(flight.state)
    clearance = z - place.height
    if run.scene.reading.fence_clearance == "surface":
        clearance = clearance - numbers.exact(run.scene.ball.radius)
    run.record("fence.time", begin + flight.time, rows)
    run.record("fence.position", (x, y, z), rows)
    run.record("fence.velocity", (u, v, w), rows)
    run.record("fence.clearance", clearance, rows)
    run.record("fence.segment", place.segment, rows)
    if place.margin is not None:
        run.record("fence.margin", place.margin, rows)

    # over a part of the fence that has one height
    error = _flight_error(run) * (1 + abs(x) + abs(y) + abs(z))
    heading = _heading_error(run) if landing is None else _flight_error(run)
    question = "on which side the ball passes a vertex where the fence ends or has two heights"
    sideways = heading * (1 + abs(x) + abs(y))  # the error across the path, m
    known, at_vertex = run.decide(place.to_break, sideways, question, rows)
    reason = f"{question} cannot be said: it passes over the vertex itself"
    run.refuse(Undecided(reason), at_vertex)

    # against the wall
    # An error of the place changes the ball's height by the slope of its path, and the height of
    # the fence by the slope of its top.
    steepness = abs(w) / numbers.sqrt(u * u + v * v) + abs(place.slope)
    over, into = run.decide(
        clearance, error * (1 + steepness), "whether the ball clears the fence", rows
    )
    into = known & into
    run.follow(frame, flight, begin, into)
    if run.any(into):
        _rise(run, ball, flight, into)
    run.conclude("wall", into)
    over = known & over
    if not run.any(over):
        return

    # out of the field
    if landing is None:
        left = run.time_limit - flight.time
        landing = flight.then(_fly_down(run, ball, flight.state, left, over))
    foul, fair = _foul(run, frame.position(flight.state), "leaves the field fair", over)
    around = run.scene.fence.polyline is None
    if run.any(fair):
        _come_down(run, ball, landing, "home_run", fair, True)
    if run.any(foul):
        _come_down(run, ball, landing, "home_run" if around else outcome, foul, False)


# --- results --------------------------------------------------------------------------------------

CHAINS: dict[str, Callable[[Run], None]] = {
    "flight": solve_flights,
    "pitch": lambda run: run.conclude("crossed", throw(run).crossed),
    "impact": solve_impacts,
    "at-bat": lambda run: finish(run, meet_bat(run)),
}


BLOCKS: dict[str, type[Any]] = {
    "plate": written.Plate,
    "contact": written.Contact,
    "impact": written.Impact,
    "apex": written.Apex,
    "fence": written.Fence,
    "landing": written.Landing,
}

# The same, and the blocks within them, by their names.
PARTS: dict[str, type[Any]] = {
    **BLOCKS,
    "plate.approach": written.Approach,
}

# The quantities that are flags or whole numbers, not measured: their types, by name.
DISCRETE: dict[str, type[bool] | type[int]] = {
    f"{name}.{key}": kind
    for name, block in BLOCKS.items()
    for key, field in block.model_fields.items()
    for kind in (bool, int)
    for parts in [(field.annotation, *get_args(field.annotation))]
    if any(kind in (part, *get_args(part)) for part in parts)
}


def solve(scene: Scene, engine: Engine | ManyAtOnce, model: Model = MODEL) -> Result:
    """Return the result of a scene; if it cannot be solved, a result with an error.

    Numbers have the promised digits of the engine; see `longball.engines.digits.to_digits`. Of an
    engine that solves many scenes at once the model has its usual parts.
    """
    if isinstance(engine, ManyAtOnce):
        return engine.solve_all([scene])[0]
    result, _ = solve_with_path(scene, engine, model)
    return result


def solve_once(scene: Scene, engine: Engine, model: Model = MODEL) -> tuple[Result, Trajectory]:
    """Return result and path of a scene by this engine, without a check of its digits."""
    run = Run(scene, engine, model)
    return _follow(run, CHAINS[scene.kind]), Trajectory(tuple(run.legs))


# Least number of scenes for processes. Starting these takes one or two seconds, as long as a
# hundred scenes by the slower engines.
_FEW = 100  # a free choice


def solve_each(
    scenes: Sequence[Scene], engine: Engine | ManyAtOnce, workers: int = 1
) -> Iterable[Result]:
    """Return the results of scenes, in order; most engines compute them lazily.

    Workers are threads if the engine solves many scenes at once, and processes otherwise.
    """
    if isinstance(engine, ManyAtOnce):
        return engine.solve_all(scenes, workers)
    if workers == 1 or len(scenes) < _FEW:
        return (solve(scene, engine) for scene in scenes)
    return in_parallel(solve, ((scene, engine) for scene in scenes), workers)


def solve_with_path(
    scene: Scene, engine: Engine | ManyAtOnce, model: Model = MODEL
) -> tuple[Result, Trajectory]:
    """Return the result of a scene, and the path of its ball from the start of the scene."""
    if isinstance(engine, ManyAtOnce):
        _, path = solve_with_path(scene, engine.alone)
        return solve(scene, engine), path
    # Only of numbers that carry their own error is it known how many digits are right.
    if engine.numbers.rounding:
        return solve_once(scene, engine, model)
    return to_digits(scene, engine, partial(solve_once, scene, model=model))


def solve_with_points(scene: Scene, engine: Engine | ManyAtOnce, points: int) -> Result:
    """Return the result of a scene with a number of points of its path, if it has a path."""
    # One engine computes both, so that they agree.
    alone: Engine = engine.alone if isinstance(engine, ManyAtOnce) else engine
    result, flown = solve_with_path(scene, alone)
    if result.error is not None or not flown.legs:
        return result
    with alone.numbers.arithmetic():
        rows = flown.evenly(points, alone.numbers)
        path = tuple(tuple(map(alone.numbers.report, row)) for row in rows)
    return result.model_copy(update={"path": path})


def solve_with_restitutions(
    scene: AtBatScene, restitutions: Sequence[float], engine: Engine
) -> list[Result]:
    """Return the results of an at-bat struck with balls that differ in restitution only.

    The pitch and its touching of the bat, which do not depend on it, are solved once.
    """
    run = Run(scene, engine, MODEL)
    contact = _follow(run, meet_bat)
    if isinstance(contact, Result):
        return [contact] * len(restitutions)
    results = []
    for e in restitutions:
        # a copy of what the pitch has recorded, with another ball
        ball = replaced(scene, {"ball.restitution": e})
        one = replace(run, scene=ball, answer=dict(run.answer))
        results.append(_follow(one, lambda one: finish(one, contact)))
    return results


def view_of(scene: Scene, values: Mapping[str, Any]) -> Any:
    """Return a scene with columns, or other objects, in place of its numbers."""
    view = viewed(scene, values)
    if hasattr(scene, "ground"):
        view.ground = viewed(scene.ground, values, "ground")  # of a pitch: the model's
    return view


def quantities_of(scene: Any, engine: Engine) -> dict[str, Any]:
    """Return a result's quantities and outcome by name, in the engine's own numbers.

    Raises `ArithmeticError` or `ValueError` if there is no result: `CannotSolve`, `InvalidScene`,
    `Undecided`, or what `_follow` words.
    """
    run = Run(scene, engine, MODEL)
    with run.numbers.arithmetic():
        CHAINS[scene.kind](run)
    return run.answer


def approach_of(scene: AtBatScene, engine: Engine) -> BatEncounter | None:
    """Return the approach of pitch and bat; None if the pitch does not reach the plate.

    Raises `CannotSolve` or `InvalidScene` or `Undecided`.
    """
    with engine.numbers.arithmetic():
        return approach_bat(Run(scene, engine, MODEL))


def _follow(run: Run, chain: Callable[[Run], Any]) -> Any:
    """Go through a chain; return the result, or what the chain returns if it is not concluded."""
    report, by = run.numbers.report, {"id": run.scene.id, "engine": run.engine.description}
    error: InvalidScene | Undecided | CannotSolve | None = None
    with run.numbers.arithmetic():
        try:
            # the chain
            try:
                rest = chain(run)
                if "outcome" not in run.answer:
                    return rest
            except (InvalidScene, Undecided, CannotSolve) as reason:
                error = reason

            # the quantities that it has recorded, in blocks
            blocks: dict[str, Any] = {}
            for name, value in run.answer.items():
                *outer, key = name.split(".")
                block = blocks
                for step in outer:
                    block = block.setdefault(step, {})
                if isinstance(value, tuple):
                    value = tuple(map(report, value))
                elif not isinstance(value, str | int):
                    value = report(value)
                block[key] = value
            if error is None:
                return Result(**by, **blocks)
            blocks.pop("outcome", None)
            return Result(**by, **blocks, error=str(error), code=error.code)
        # Overflow, a division by zero, or a result that pydantic refuses: no finite answer. What
        # was recorded is dropped, as it may have the numbers at fault.
        except (ArithmeticError, ValueError) as fault:
            what = "a quantity is not finite" if isinstance(fault, ValidationError) else str(fault)
            beyond = OutOfRange(f"the numbers leave the range of the engine: {what}")
            return Result(**by, error=str(beyond), code=beyond.code)
