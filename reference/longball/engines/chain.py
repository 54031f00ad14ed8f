"""The chain of an at-bat: pitch, plate, contact, impact, landing.

Written once, over any engine, any number system, and one scene or columns of scenes. It follows the
paper's Sec. III: the throw, the swing that is aimed at where the throw would cross the plate, the
collision of Sec. III.C and Appendix A, the flight to the ground. Its parts, the forces and the
collision, are handed in: a known mistake is the same chain with another part.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Generic, cast, get_args

from pydantic import ValidationError

from longball.engines.contact import BatSection, margin_error
from longball.engines.engine import (
    CannotSolve,
    Engine,
    Launch,
    ManyAtOnce,
    OutOfRange,
    Stepped,
    Touch,
)
from longball.engines.event import Event, Piece, ground, plate, vertical
from longball.engines.fence import Place, Stop, at_stop, first_crossing, stop_at
from longball.engines.parallel import in_parallel
from longball.engines.path import Flight, Leg, Path, Trajectory
from longball.model import result as written
from longball.model.aerodynamics import DRAG, LIFT
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
from longball.model.force import Term
from longball.model.frame import Frame, launch_frame
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
from longball.model.law import FORCES, GRAVITY, Law, PlaneState, State, in_plane, law_of
from longball.model.numbers import N, Numbers, Undecided, Vector, absolute
from longball.model.quantities import replaced
from longball.model.result import Outcome, Result
from longball.model.scene import AtBatScene, InvalidScene, Scene, landing_height

# --- the collision --------------------------------------------------------------------------------


@dataclass(frozen=True)
class ContactState(Generic[N]):
    """Ball and bat at the touching, before the impulse.

    Attributes
    ----------
    position, velocity, spin
        Of the ball, m, m/s and rad/s; no spin if the scene has none.
    normal
        Unit vector from the bat's axis to the ball.
    bat_velocity
        Of the bat on its axis, m/s.
    lever_arm
        r̃, m.
    normal_speed
        Ṽ·n, m/s.
    """

    position: Vector[N]
    velocity: Vector[N]
    spin: Vector[N] | None
    normal: Vector[N]
    bat_velocity: Vector[N]
    lever_arm: N
    normal_speed: N


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


def collide(
    cases: Cases[N], contact: ContactState[N], error: N | float, *carried: Any
) -> tuple[Any, ...]:
    """Apply the impulse of Appendix A; on a bat with friction, the oblique one.

    Parameters
    ----------
    error
        Of velocities and directions, relative, before any rounding here.
    carried
        Other values of theirs.

    Returns
    -------
    tuple
        Those that part, their `Impact`, and the other values.
    """
    scene, numbers = cases.scene, cases.numbers
    pair = collision_parameters(scene.ball, scene.bat, contact.lever_arm, scene.reading, numbers)
    if scene.bat.friction is not None:
        return _rub(cases, contact, pair, error, *carried)
    parts = pair.reduced_mass, pair.restitution, contact.normal_speed
    push = impulse(*parts)
    mass = numbers.exact(scene.ball.mass)
    after = velocity_after(contact.velocity, contact.normal, mass, push)
    mode = None if contact.spin is None else "frictionless"
    impact = Impact(pair.restitution, push, after, energy_change(*parts), contact.spin, mode)
    return cases, impact, *carried


# Between the velocities and the decisions below stand fewer operations, each on terms that are no
# larger than those of the bounds.
_OPERATIONS = 40


def _rub(
    cases: Cases[N],
    contact: ContactState[N],
    pair: CollisionParameters[N],
    error: N | float,
    *carried: Any,
) -> tuple[Any, ...]:
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
    return cases.take((grips | slides) & known & parts, impact, *carried)


@dataclass(frozen=True)
class Model:
    """The parts of the chain that may be replaced.

    Attributes
    ----------
    forces
        What may act on a ball in flight.
    collide
        From a `ContactState` to the `Impact`; see `collide`.
    """

    forces: tuple[Term, ...] = FORCES
    collide: Callable[..., tuple[Any, ...]] = collide


MODEL = Model()


# --- one scene, or many ---------------------------------------------------------------------------


class Cases(ABC, Generic[N]):
    """Scenes that have come equally far: one, or a column of them.

    A condition is a bool for one scene, and an array of them for columns.

    Attributes
    ----------
    scene
        Has the blocks of a scene as attributes, with a number or a column of numbers each.
    engine, model
        Who computes, with which parts.
    """

    scene: Any
    engine: Engine[N]
    model: Model

    @property
    @abstractmethod
    def empty(self) -> bool:
        """Whether no scene is left."""

    @abstractmethod
    def decide(self, x: N, error: N, question: str) -> tuple[Any, Any]:
        """Return the conditions that ``x > 0``, and that it is not; neither where in doubt.

        Raises
        ------
        Undecided
            For one scene, in doubt.
        """

    @abstractmethod
    def take(self, condition: Any, *values: Any) -> tuple[Any, ...]:
        """Return those for which a condition holds, and values of theirs."""

    @abstractmethod
    def either(
        self, condition: Any, yes: Callable[..., Any], no: Callable[..., Any], *values: Any
    ) -> Any:
        """Return ``yes(cases, *values)`` where a condition holds, else what `no` returns."""

    @abstractmethod
    def record(self, name: str, value: Any) -> None:
        """Write a quantity of the results, a number or a vector: ``plate.time``."""

    @abstractmethod
    def conclude(self, outcome: Outcome) -> None:
        """Write the outcome."""

    def refuse(self, reason: CannotSolve | Undecided) -> None:
        """Give no answer: to one scene, raise the reason."""

    @abstractmethod
    def touched(self, touch: Touch[N]) -> tuple[Any, Any]:
        """Return the conditions that ball and bat touch, and that they miss; see `decide`."""

    @abstractmethod
    def land_in_space(
        self,
        launch: Launch[N],
        frame: Frame[N],
        law: Law[N],
        start: PlaneState[N],
        outcome: Outcome,
    ) -> None:
        """Do what `land` does, of flights that a fence may end and that leave their plane."""

    def follow(self, frame: Frame[N], flight: Flight[N], begin: N) -> None:
        """Take note of a flight that begins at a time, s since the start of the scene."""

    @property
    def numbers(self) -> Numbers[N]:
        """The engine's number system."""
        return self.engine.numbers

    @property
    def time_limit(self) -> N:
        """The longest time of flight, s."""
        return self.numbers.exact(self.scene.time_limit)

    def vector(self, values: Sequence[float]) -> Vector[N]:
        """Return three numbers of a scene."""
        x, y, z = map(self.numbers.exact, values)
        return x, y, z

    def spin(self, values: Sequence[float] | None) -> Vector[N] | None:
        """Return the spin that a scene gives a ball, if it does."""
        return None if values is None else self.vector(values)

    def law(self, frame: Frame[N]) -> Law[N]:
        """Return the law of motion of a flight in a frame."""
        return law_of(self.scene, frame, self.numbers, self.model.forces)

    def spin_at(self, frame: Frame[N], law: Law[N], state: State[N]) -> Vector[N] | None:
        """Return the spin of the ball in a state of a flight, rad/s."""
        if frame.spin is None:
            return None
        left = law.spin_left(state, self.numbers)
        return frame.spin[0] * left, frame.spin[1] * left, frame.spin[2] * left

    def ground(self, start: State[N]) -> Event[N]:
        """Return the landing of a flight from a state."""
        return ground(self.numbers.exact(landing_height(self.scene)), start, self.numbers)


# --- balls in the air -----------------------------------------------------------------------------


# What a flight may end with, from its frame and start.
Surface = Callable[[Cases[N], Frame[N], State[N]], Event[N]]


def _ground(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    return cases.ground(start)


def _plate(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    return plate(frame, start, cases.numbers)


def _fence(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    return at_stop("fence", _stop(cases, frame, start, 1), 1, cases.numbers)


def _fence_behind(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    return at_stop("fence_behind", _stop(cases, frame, start, -1), -1, cases.numbers)


def fly(
    cases: Cases[N],
    law: Law[N],
    frame: Frame[N],
    start: State[N],
    *surfaces: Surface[N],
    limit: N | None = None,
) -> Flight[N]:
    """Fly to a surface or the time limit, through the vertical if need be.

    With lift that is always up, a ball that reaches the vertical cannot leave it: on either side
    the horizontal part of the lift drives it back. It goes on without lift, straight up and down
    (the sliding solution in Filippov's sense; on the way down it is the symmetric one of two). From
    rest, or straight up or down, it is there already.
    """
    limit = cases.time_limit if limit is None else limit
    leg = law, law.state_of(start), limit, frame, surfaces
    flight: Flight[N] = cases.either(_is_always_up(cases, law), _fly_upwards, _fly, *leg)
    return flight


def _is_always_up(cases: Cases[N], law: Law[N]) -> Any:
    """Return the condition that there is a lift, and that it is always up."""
    if cases.scene.reading.lift_direction != "always_up" or LIFT not in law.forces:
        return False
    return cast(Any, law.strengths["lift"]) != 0


def _fly(
    cases: Cases[N],
    law: Law[N],
    start: State[N],
    limit: N,
    frame: Frame[N],
    surfaces: Sequence[Surface[N]],
    *others: Event[N],
) -> Flight[N]:
    events = [surface(cases, frame, start) for surface in surfaces]
    return cases.engine.fly(law, start, [*events, *others], limit)


def _fly_upwards(cases: Cases[N], law: Law[N], start: State[N], *leg: Any) -> Flight[N]:
    upright = cast(Any, start.u) == 0
    flight: Flight[N] = cases.either(upright, _fly_upright, _fly_to_vertical, law, start, *leg)
    return flight


def _fly_upright(cases: Cases[N], law: Law[N], *leg: Any) -> Flight[N]:
    return _fly(cases, law.without(LIFT), *leg)


def _fly_to_vertical(cases: Cases[N], *leg: Any) -> Flight[N]:
    turns = vertical(cases.numbers)

    def go_on(
        cases: Cases[N], flight: Flight[N], law: Law[N], start: State[N], limit: N, *rest: Any
    ) -> Flight[N]:
        upright = turns.place(flight.state)
        return flight.then(_fly_upright(cases, law, upright, limit - flight.time, *rest))

    def stay(cases: Cases[N], flight: Flight[N], *leg: Any) -> Flight[N]:
        return flight

    first = _fly(cases, *leg, turns)
    flight: Flight[N] = cases.either(first.stopped("vertical"), go_on, stay, first, *leg)
    return flight


def solve_flights(cases: Cases[N]) -> None:
    """Solve launches and landings."""
    position = cases.vector(cases.scene.launch.position)
    velocity = cases.vector(cases.scene.launch.velocity)
    nothing, spin = cases.numbers.exact(0.0), cases.spin(cases.scene.launch.spin)
    land(cases, Launch(position, velocity, nothing, nothing, spin=spin), "landed")


@dataclass(frozen=True)
class Batted(Generic[N]):
    """A ball in the air: its launch, frame and law, and its flight as far as it is known."""

    launch: Launch[N]
    frame: Frame[N]
    law: Law[N]
    flight: Flight[N]


def land(cases: Cases[N], launch: Launch[N], outcome: Outcome) -> None:
    """Fly from launches to the ground, or to a fence; the `outcome` if the ball lands."""
    frame, start = launch_frame(launch.position, launch.velocity, cases.numbers, launch.spin)
    law = cases.law(frame)
    if launch.landed:
        _come_down(cases, Batted(launch, frame, law, _landed(start, cases.numbers)), outcome)
    elif cases.scene.fence is None:
        _land(cases, launch, frame, law, start, outcome)
    elif "v" not in law.program.variables and not isinstance(cases.engine, Stepped):
        flight = fly(cases, law, frame, start, _ground, _fence, _fence_behind)
        ahead, behind = flight.stopped("fence"), flight.stopped("fence_behind")
        ball = Batted(launch, frame, law, flight)
        inside, stayed = cases.take((ahead | behind) ^ True, ball)
        _come_down(inside, stayed, outcome)
        for sense, there in ((1, ahead), (-1, behind)):
            some, out, begun = cases.take(there, ball, start)
            if not some.empty:
                place = _stop(some, out.frame, begun, sense).place
                _meet_fence(some, out, place, outcome)
    else:
        cases.land_in_space(launch, frame, law, start, outcome)


def _land(
    cases: Cases[N],
    launch: Launch[N],
    frame: Frame[N],
    law: Law[N],
    start: PlaneState[N],
    outcome: Outcome,
) -> None:
    """Fly from launches to the ground, but for balls that loop above it for ever."""
    if _may_loop(cases, law):
        aloft, others = _stays_aloft(cases, law, start, _ground(cases, frame, start))
        (looping,) = cases.take(aloft)
        path = Path(_when_asked(cases.engine, law, law.state_of(start), cases.time_limit))
        looping.follow(frame, Flight(path, "time", cases.time_limit, start), launch.time)
        looping.conclude("airborne")
        cases, launch, frame, law, start = cases.take(others, launch, frame, law, start)
        if cases.empty:
            return
    flight = fly(cases, law, frame, start, _ground)
    _come_down(cases, Batted(launch, frame, law, flight), outcome)


def _come_down(
    cases: Cases[N], ball: Batted[N], outcome: Outcome, fair: bool | None = None
) -> None:
    """Conclude flights that end on the ground, or with the time limit.

    `fair` is known where the ball has left the field.
    """
    cases.follow(ball.frame, ball.flight, ball.launch.time)
    cases, ball = _in_time(cases, ball)
    (airborne,) = cases.take(ball.flight.stopped("time"))
    airborne.conclude("home_run" if outcome == "home_run" else "airborne")
    cases, ball = cases.take(ball.flight.stopped("ground"), ball)
    if cases.empty:
        return
    launch, frame, flight = ball.launch, ball.frame, ball.flight
    state: Any = flight.state
    x, y, z = frame.position(state)
    cases.record("landing.time", launch.time + flight.time)
    cases.record("landing.hang_time", launch.delay + flight.time)
    cases.record("landing.position", (x, y, z))
    cases.record("landing.velocity", frame.velocity(state))
    if cases.scene.reading.distance_origin == "launch":
        # Of the frame, which begins at the launch: no difference of places that are far away.
        x = state.s
        y = x * 0 if in_plane(state) else state.y
    cases.record("landing.distance", cases.numbers.sqrt(x * x + y * y))
    if frame.spin is not None:
        cases.record("landing.spin", cases.spin_at(frame, ball.law, state))
    if hasattr(state, "path") and cases.scene.reading.spin_decay == "path":
        cases.record("landing.path", state.path)
    if fair is not None:
        cases.record("landing.fair", fair)
    elif cases.scene.fence is not None:
        lands_foul, lands_fair = _foul(cases, frame.position(state), "lands fair")
        cases.record("landing.fair", lands_fair)
        (cases,) = cases.take(lands_foul | lands_fair)
    cases.conclude(outcome)


def _in_time(cases: Cases[N], ball: Batted[N]) -> tuple[Any, ...]:
    """Return those of which it is certain whether the ball lands in the time limit.

    The engine knows of the errors of its flight, but not of that of the launch.
    """
    launch, flight = ball.launch, ball.flight
    if launch.error is None:
        return cases, ball
    state = flight.state
    left = (cases.time_limit - flight.time) * absolute(state.w)
    above = state.z - cases.numbers.exact(landing_height(cases.scene))
    margin = cases.numbers.where(flight.stopped("time"), above, left)
    question = "whether the ball touches the ground in the time limit"
    certain, never = cases.decide(margin, launch.error * flight.time, question)
    return cases.take(certain | never, ball)


def _may_loop(cases: Cases[N], law: Law[N]) -> bool:
    """Tell whether nothing but lift about a fixed axis and gravity acts, in some of the cases."""
    return (
        LIFT in law.forces
        and {DRAG, LIFT, GRAVITY}.issuperset(law.forces)
        and cases.numbers.absent(cast(Any, law.strengths.get("drag", 0.0)))
        and cases.scene.reading.lift_direction == "fixed_spin_axis"
        and not isinstance(cases.engine, Stepped)  # whose scheme may well come down
    )


def _stays_aloft(
    cases: Cases[N], law: Law[N], start: State[N], surface: Event[N]
) -> tuple[Any, Any]:
    """Return the conditions that a ball without drag never comes down to the ground, or does.

    It loops, for ever, and an engine would fly every turn. But ``V² + 2 g z`` stays the same, and
    so does ``u - k ∫ V² dV / g``, with the lift k: at the height of the ground, H below the start,
    the speed would be ``V_H = √(V² + 2 g H)``, and its horizontal part

        u + (2/3) k H (V_H² + V_H V + V²) / (V_H + V),

    also where g = 0. A ball for which that is more than the speed cannot come there; and as speed
    less horizontal speed is concave in V, any other ball can.
    """
    numbers, height = cases.numbers, surface.value(start)
    slow2 = start.u * start.u + start.w * start.w
    gravity = law.gravity
    fast2 = slow2 if gravity is None else slow2 + 2 * gravity * height
    slow, fast = numbers.sqrt(slow2), numbers.sqrt(fast2)
    total, lift = fast + slow, law.strengths["lift"]
    level = start.u * total + 2 * lift * height * (fast2 + fast * slow + slow2) / 3
    # A ball that only just touches the ground is left to the search for that event.
    beyond = absolute(level) - fast * total * (1 + _TOUCHING)
    return cases.decide(beyond, fast * 0, "whether the ball stays above the ground")


# Far more than the roundings of a flight.
_TOUCHING = 1e-9


def _when_asked(engine: Engine[N], law: Law[N], start: State[N], limit: N) -> Iterator[Piece[N]]:
    """Yield the pieces of a flight that is only flown if somebody wants to know its way."""
    yield from engine.fly(law, start, (), limit).path.pieces()


# --- the fence ------------------------------------------------------------------------------------


def _flight_error(cases: Cases[N]) -> float:
    """Return the relative error of a state of a flight and of a few roundings of it."""
    return cases.engine.flight_error + 8 * cases.numbers.rounding


def _heading_error(cases: Cases[N]) -> float:
    """Return the relative error of where a flight in its plane heads for.

    The flight itself adds none; the heading of a batted ball has its pitch's error.
    """
    rounded = 8 * cases.numbers.rounding
    return rounded if hasattr(cases.scene, "launch") else _flight_error(cases)


def _stop(cases: Cases[N], frame: Frame[N], start: State[N], sense: int) -> Stop[N]:
    error = cases.numbers.exact(_heading_error(cases))
    return stop_at(cases.scene.fence, frame, start.s, sense, error, cases.numbers)


def _foul(cases: Cases[N], position: Vector[N], what: str) -> tuple[Any, Any]:
    """Return the conditions that a ball is foul, and that it is fair: the foul line is."""
    x, y, _ = position
    error = _flight_error(cases) * (absolute(x) + absolute(y))
    return cases.decide(absolute(y) - x, error, f"whether the ball {what}")


def _meet_fence(
    cases: Cases[N],
    ball: Batted[N],
    place: Place[N],
    outcome: Outcome,
    landing: Flight[N] | None = None,
) -> None:
    """Conclude flights that are at the fence; `landing` has where they land if they go on."""
    numbers, frame, flight = cases.numbers, ball.frame, ball.flight
    x, y, z = frame.position(flight.state)
    u, v, w = frame.velocity(flight.state)
    clearance = z - place.height
    if cases.scene.reading.fence_clearance == "surface":
        clearance = clearance - numbers.exact(cases.scene.ball.radius)
    cases.record("fence.time", ball.launch.time + flight.time)
    cases.record("fence.position", (x, y, z))
    cases.record("fence.velocity", (u, v, w))
    cases.record("fence.clearance", clearance)
    cases.record("fence.segment", place.segment)
    if place.margin is not None:
        cases.record("fence.margin", place.margin)
    error = _flight_error(cases) * (1 + absolute(x) + absolute(y) + absolute(z))
    heading = _heading_error(cases) if landing is None else _flight_error(cases)
    question = "on which side the ball passes a vertex where the fence ends or has two heights"
    aside = heading * (1 + absolute(x) + absolute(y))
    known, at_vertex = cases.decide(place.to_break, aside, question)
    (ended,) = cases.take(at_vertex)
    ended.refuse(Undecided(f"{question} cannot be said: it passes over the vertex itself"))
    # What the place is off, the ball's way makes of it by its steepness, and the top by its own.
    steepness = absolute(w) / numbers.sqrt(u * u + v * v) + absolute(place.slope)
    over, into = cases.decide(
        clearance, error * (1 + steepness), "whether the ball clears the fence"
    )
    wall, stopped = cases.take(known & into, ball)
    wall.follow(stopped.frame, stopped.flight, stopped.launch.time)
    wall.conclude("wall")
    cases, ball = cases.take(known & over, ball)
    if cases.empty:
        return
    frame, flight = ball.frame, ball.flight
    if landing is None:
        left = cases.time_limit - flight.time
        landing = flight.then(fly(cases, ball.law, frame, flight.state, _ground, limit=left))
    conditions = _foul(cases, frame.position(flight.state), "leaves the field fair")
    around = cases.scene.fence.polyline is None
    for fair, condition in zip((False, True), conditions, strict=True):
        some, gone, way = cases.take(condition, ball, landing)
        if not some.empty:
            beyond: Outcome = "home_run" if fair or around else outcome
            _come_down(some, replace(gone, flight=way), beyond, fair)


def _landed(state: State[N], numbers: Numbers[N]) -> Flight[N]:
    return Flight(Path(()), "ground", numbers.exact(0.0), state)


# --- the pitch ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pitch(Generic[N]):
    """A pitch up to the plate, or to wherever it ended before."""

    frame: Frame[N]
    law: Law[N]
    start: State[N]
    flight: Flight[N]


def throw(cases: Cases[N]) -> Pitch[N]:
    """Throw from the release toward the point aimed at, and fly to the plane x = 0."""
    numbers, pitch = cases.numbers, cases.scene.pitch
    x, y, z = release = cases.vector(pitch.release)
    if pitch.velocity is None:
        aim_y, aim_z = (numbers.exact(value) for value in pitch.aim)
        toward = (-x, aim_y - y, aim_z - z)
        scale = numbers.exact(pitch.speed) / numbers.sqrt(_dot(toward, toward))
        velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    else:
        velocity = cases.vector(pitch.velocity)
    frame, start = launch_frame(release, velocity, numbers, cases.spin(pitch.spin))
    law = cases.law(frame)
    return Pitch(frame, law, start, fly(cases, law, frame, start, _ground, _plate))


def reach_plate(cases: Cases[N]) -> tuple[Cases[N], Pitch[N]]:
    """Throw; conclude the pitches that end before the plate, and return the others."""
    pitch = throw(cases)
    cases.follow(pitch.frame, pitch.flight, cases.numbers.exact(0.0))
    for stop, outcome in (("ground", "grounded"), ("time", "airborne")):
        (ended,) = cases.take(pitch.flight.stopped(stop))
        ended.conclude(outcome)
    cases, pitch = cases.take(pitch.flight.stopped("plate"), pitch)
    if not cases.empty:
        _, y, z = pitch.frame.position(pitch.flight.state)
        cases.record("plate.time", pitch.flight.time)
        cases.record("plate.position", (cases.numbers.exact(0.0), y, z))
        cases.record("plate.velocity", pitch.frame.velocity(pitch.flight.state))
    return cases, pitch


def solve_pitches(cases: Cases[N]) -> None:
    """Solve releases and plates."""
    crossed, _ = reach_plate(cases)
    crossed.conclude("crossed")


# --- ball and bat ---------------------------------------------------------------------------------


def solve_impacts(cases: Cases[N]) -> None:
    """Solve touchings that are given."""
    incoming = cases.scene.incoming
    position, velocity = cases.vector(incoming.position), cases.vector(incoming.velocity)
    ball = Ball(position, velocity, cases.spin(incoming.spin))
    offset = position[0], position[2] - cases.numbers.exact(incoming.bat_height)
    # Nothing has flown: the position is exact, and only roundings here are in doubt.
    cases, contact = meet(cases, ball, offset, 0.0)
    if not cases.empty:
        cases, _ = strike(cases, contact, 0.0)
        cases.conclude("struck")


@dataclass(frozen=True)
class Ball(Generic[N]):
    """A ball that touches the bat.

    Attributes
    ----------
    position, velocity, spin
        m, m/s and rad/s; None: the scene has no spin.
    aside
        Where it was along the bat, m, when that was looked at; None: as in `position`.
    leaving
        Whether it is where it would leave the bat.
    """

    position: Vector[N]
    velocity: Vector[N]
    spin: Vector[N] | None = None
    aside: N | None = None
    leaving: bool = False


def meet(
    cases: Cases[N], ball: Ball[N], offset: tuple[N, N], inherited: float, *carried: Any
) -> tuple[Any, ...]:
    """Look at balls and bats that touch; return those that approach each other.

    Parameters
    ----------
    offset
        The way from the bat's axis to the ball's centre, m: in x, and up.
    inherited
        Relative error of position and velocity before any rounding here.
    carried
        Other values of theirs, returned behind the `ContactState`.
    """
    numbers, bat = cases.numbers, cases.scene.bat
    half = numbers.exact(bat.length) / 2
    slack = half * (inherited + 2 * numbers.rounding) if inherited else numbers.exact(0.0)
    question = "whether the ball meets the bat or its end"
    aside = ball.position[1] if ball.aside is None else ball.aside
    on_bat, beyond = cases.decide(half - absolute(aside), slack, question)
    (ended,) = cases.take(beyond)
    ended.conclude("beyond_bat")
    cases, ball, (across, above), *rest = cases.take(on_bat, ball, offset, *carried)
    if cases.empty:
        return cases, None, *rest
    velocity = ball.velocity
    distance = numbers.sqrt(across * across + above * above)
    normal = (across / distance, numbers.exact(0.0), above / distance)
    arm = lever_arm(ball.position[1], cases.scene.bat, numbers)
    moving = bat_velocity(arm, cases.scene.swing, numbers)
    relative = (velocity[0] - moving[0], velocity[1] - moving[1], velocity[2] - moving[2])
    normal_speed = _dot(relative, normal)
    # Six operations stand between the velocities and their normal part.
    terms = [(v[i], normal[i]) for v in (velocity, moving) for i in (0, 2)]
    doubt = sum(
        (absolute(a * b) * (inherited + 6 * numbers.rounding) for a, b in terms), across * 0
    )
    # The force is the same for n and -n; a ball that would leave the bat approaches its back.
    approach = normal_speed if ball.leaving else -normal_speed
    question = "whether ball and bat approach or separate"
    closing, separating = cases.decide(approach, doubt, question)
    contact = ContactState(ball.position, velocity, ball.spin, normal, moving, arm, normal_speed)
    cases.record("contact.position", ball.position)
    cases.record("contact.normal", normal)
    cases.record("contact.bat_velocity", moving)
    cases.record("contact.normal_speed", normal_speed)
    (ended,) = cases.take(separating)
    ended.conclude("separating")
    return cases.take(closing, contact, *rest)


def strike(
    cases: Cases[N], contact: ContactState[N], error: N | float, *carried: Any
) -> tuple[Any, ...]:
    """Apply the impulses; see `collide`."""
    cases, impact, contact, *rest = cases.model.collide(cases, contact, error, contact, *carried)
    if not cases.empty:
        for quantity in fields(Impact):
            if (value := getattr(impact, quantity.name)) is not None:
                cases.record(f"impact.{quantity.name}", value)
        _tell_recontact(cases, contact, impact)
    return cases, impact, *rest


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
    after = tuple(v - b for v, b in zip(impact.velocity, contact.bat_velocity, strict=True))
    terms = [v * n for v, n in zip(after, contact.normal, strict=True)]
    rate = terms[0] + terms[1] + terms[2]
    parting = numbers.where(contact.normal_speed < 0, rate, -rate)
    speeds = sum(map(absolute, (*contact.velocity, *contact.bat_velocity)), rate * 0)
    doubt = speeds * numbers.exact(_TOLD_APART)
    again, parted = parting < -doubt, parting > doubt
    for condition, said in ((again, "certain"), ((again | parted) ^ True, "possible")):
        (some,) = cases.take(condition)
        if not some.empty:
            some.record("impact.recontact", said)


# --- the whole at-bat -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Approach(Generic[N]):
    """A pitch, the bat, and how they meet."""

    pitch: Pitch[N]
    bat: BatSection[N]
    touch: Touch[N]

    @property
    def height(self) -> N:
        """Height of the bat's axis, m."""
        return self.bat.height


@dataclass(frozen=True)
class Meeting(Generic[N]):
    """Pitch and bat up to the impulse, on which the ball's restitution has no influence."""

    approach: Approach[N]
    contact: ContactState[N]


def approach_bat(cases: Cases[N]) -> tuple[Cases[N], Approach[N] | None]:
    """Throw, put the bat where it is swung, and find how the two meet."""
    cases, pitch = reach_plate(cases)
    if cases.empty:
        return cases, None
    numbers, scene = cases.numbers, cases.scene
    # z_b = z'_b + σ_b (paper, Sec. III.A)
    height = pitch.flight.state.z + numbers.exact(scene.swing.height_offset)
    reach = numbers.exact(scene.ball.radius) + numbers.exact(scene.bat.radius)
    bat = BatSection(pitch.frame, height, reach)
    upwards = _is_always_up(cases, pitch.law)
    touch = cases.either(upwards, _find_upwards, _find, pitch, bat)
    return cases, Approach(pitch, bat, touch)


def _find(cases: Cases[N], pitch: Pitch[N], bat: BatSection[N], *others: Event[N]) -> Touch[N]:
    events = [cases.ground(pitch.start), *others]
    return cases.engine.touch(pitch.flight, pitch.law, bat, events, cases.time_limit)


def _find_upwards(cases: Cases[N], pitch: Pitch[N], bat: BatSection[N]) -> Touch[N]:
    return _find(cases, pitch, bat, vertical(cases.numbers))


def meet_bat(cases: Cases[N]) -> tuple[Cases[N], Meeting[N] | None]:
    """Throw and swing; conclude what is not struck, and return the others."""
    cases, approach = approach_bat(cases)
    if approach is None:
        return cases, None
    touch = approach.touch
    cases.record("contact.margin", touch.margin)
    touched, missed = cases.touched(touch)
    (ended,) = cases.take(missed)
    ended.conclude("missed")
    cases, approach = cases.take(touched, approach)
    if cases.empty:
        return cases, None
    touch, frame, law = approach.touch, approach.pitch.frame, approach.pitch.law
    ball = Ball(
        frame.position(touch.state),
        frame.velocity(touch.state),
        cases.spin_at(frame, law, touch.state),
        aside=frame.position(touch.detected)[1],
        leaving=touch.leaving,
    )
    cases.record("contact.time", touch.time)
    cases.record("contact.position", ball.position)
    error = cases.engine.flight_error
    offset = approach.bat.offset(touch.state, cases.numbers)
    cases, contact, approach = meet(cases, ball, offset, error, approach)
    return cases, None if contact is None else Meeting(approach, contact)


def finish(cases: Cases[N], meeting: Meeting[N] | None) -> None:
    """Solve at-bats from the impulse on."""
    if meeting is None or cases.empty:
        return
    error = 0.0 if cases.scene.bat.friction is None else _contact_error(cases, meeting)
    cases, impact, meeting = strike(cases, meeting.contact, error, meeting)
    if cases.empty:
        return
    contact, engine = meeting.contact, cases.engine
    touch, pitch = meeting.approach.touch, meeting.approach.pitch
    if isinstance(engine, Stepped):
        before, after = contact.velocity, impact.velocity
        delta_v = (after[0] - before[0], after[1] - before[1], after[2] - before[2])
        surface = cases.ground(pitch.start)

        def law_in(frame: Frame[N]) -> Law[N]:
            return cases.law(replace(frame, spin=impact.spin))

        launch = engine.rebound(pitch.frame, touch, delta_v, law_in, surface)
        launch = replace(launch, spin=impact.spin)
    else:
        time = cast(N, touch.time)
        off = _launch_error(cases, meeting) if cases.numbers.rounding else None
        launch = Launch(
            contact.position, impact.velocity, time, time * 0, spin=impact.spin, error=off
        )
    land(cases, launch, "batted")


def _contact_error(cases: Cases[N], meeting: Meeting[N]) -> N:
    """Return the relative error of velocities and directions at the contact.

    Where the ball all but grazes the bat, an error of its way moves the contact around the bat by
    as much more as it is slower towards the bat than past it; but an error δ of the margin moves it
    by √(2 δ/reach) at most, which is the angle between a graze and a touching δ deep.
    """
    contact, approach, engine = meeting.contact, meeting.approach, cases.engine
    numbers = cases.numbers
    bat, pitch = approach.bat, approach.pitch
    moved = margin_error(bat, pitch.flight.state.z, engine.flight_error, numbers) / bat.reach
    speed = numbers.sqrt(_dot(contact.velocity, contact.velocity))
    towards = absolute(_dot(contact.velocity, contact.normal))
    most = numbers.sqrt(2 * moved)
    steep = moved * speed > most * towards
    turned = numbers.where(steep, most, moved * speed / numbers.where(steep, speed, towards))
    return engine.flight_error + moved + turned


def _launch_error(cases: Cases[N], meeting: Meeting[N]) -> N:
    """Return a bound on the error of the velocity after the impulse, m/s.

    The ball's own, and that of ``(1 + ẽ) (μ/m) (Ṽ·n) n``: n comes in twice, and the factors before
    are at most two, but under readings that create energy.
    """
    contact, sqrt = meeting.contact, cases.numbers.sqrt
    ball, bat = contact.velocity, contact.bat_velocity
    return 5 * _contact_error(cases, meeting) * (sqrt(_dot(ball, ball)) + sqrt(_dot(bat, bat)))


def solve_at_bats(cases: Cases[N]) -> None:
    """Solve whole at-bats."""
    finish(*meet_bat(cases))


CHAINS: dict[str, Callable[[Cases[Any]], None]] = {
    "flight": solve_flights,
    "pitch": solve_pitches,
    "impact": solve_impacts,
    "at-bat": solve_at_bats,
}


# --- one scene ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class OneCase(Cases[N]):
    """A scene, whose results are written into `answer`, and the way of its ball into `legs`."""

    scene: Scene
    engine: Engine[N]
    model: Model
    answer: dict[str, Any] = field(default_factory=dict)
    legs: list[Leg[N]] = field(default_factory=list)

    @property
    def empty(self) -> bool:
        """See `Cases`."""
        return False

    def decide(self, x: N, error: N, question: str) -> tuple[bool, bool]:
        """See `Cases`."""
        positive = self.numbers.positive(x, error, question)
        return positive, not positive

    def refuse(self, reason: CannotSolve | Undecided) -> None:
        """See `Cases`."""
        raise reason

    def touched(self, touch: Touch[N]) -> tuple[bool, bool]:
        """See `Cases`."""
        if touch.touched is None:
            raise Undecided(touch.doubt)
        return touch.touched, not touch.touched

    def take(self, condition: bool, *values: Any) -> tuple[Any, ...]:
        """See `Cases`."""
        return self if condition else _Nobody(self.scene, self.engine, self.model), *values

    def either(
        self, condition: bool, yes: Callable[..., Any], no: Callable[..., Any], *values: Any
    ) -> Any:
        """See `Cases`."""
        return (yes if condition else no)(self, *values)

    def land_in_space(
        self,
        launch: Launch[N],
        frame: Frame[N],
        law: Law[N],
        start: PlaneState[N],
        outcome: Outcome,
    ) -> None:
        """See `Cases`."""
        flight = fly(self, law, frame, start, _ground)
        ball, error = Batted(launch, frame, law, flight), self.numbers.exact(_flight_error(self))
        fence, pieces = cast(Any, self.scene).fence, flight.path.pieces()
        met = first_crossing(fence, frame, pieces, flight.time, error, self.numbers)
        if met is None:
            _come_down(self, ball, outcome)
            return
        x, y, z = frame.position(met.state)
        above = z - self.numbers.exact(landing_height(self.scene))
        question = "whether the ball reaches the fence before it touches the ground"
        self.decide(above, error * (1 + absolute(x) + absolute(y) + absolute(z)), question)
        stopped = replace(ball, flight=Flight(flight.path, "fence", met.time, met.state))
        _meet_fence(self, stopped, met.place, outcome, flight)

    def follow(self, frame: Frame[N], flight: Flight[N], begin: N) -> None:
        """See `Cases`."""
        self.legs.append(Leg(begin, frame, flight))

    def record(self, name: str, value: Any) -> None:
        """See `Cases`."""
        self.answer[name] = value

    def conclude(self, outcome: Outcome) -> None:
        """See `Cases`."""
        self.answer["outcome"] = outcome

    def result(self, error: InvalidScene | Undecided | CannotSolve | None = None) -> Result:
        """Return what has been written, as a result; with an error, if there is one."""
        blocks: dict[str, dict[str, Any]] = {}
        for name, value in self.answer.items():
            block, _, key = name.partition(".")
            if key:
                blocks.setdefault(block, {})[key] = self._reported(value)
        return Result(
            id=self.scene.id,
            engine=self.engine.description,
            outcome=None if error else self.answer["outcome"],
            error=None if error is None else str(error),
            code=None if error is None else error.code,
            **{name: BLOCKS[name](**values) for name, values in blocks.items()},
        )

    def _reported(self, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(self.numbers.report, value))
        return value if isinstance(value, str | int) else self.numbers.report(value)


class _Nobody(OneCase[N]):
    """The one scene, once its outcome is known."""

    @property
    def empty(self) -> bool:
        return True

    def follow(self, frame: Frame[N], flight: Flight[N], begin: N) -> None:
        pass

    def record(self, name: str, value: Any) -> None:
        pass

    def conclude(self, outcome: Outcome) -> None:
        pass

    def refuse(self, reason: CannotSolve | Undecided) -> None:
        pass


BLOCKS: dict[str, type[Any]] = {
    "plate": written.Plate,
    "contact": written.Contact,
    "impact": written.Impact,
    "fence": written.Fence,
    "landing": written.Landing,
}

# The quantities that are told, not measured: their types, by name.
DISCRETE: dict[str, type[bool] | type[int]] = {
    f"{name}.{key}": kind
    for name, block in BLOCKS.items()
    for key, field in block.model_fields.items()
    for kind in (bool, int)
    for parts in [(field.annotation, *get_args(field.annotation))]
    if any(kind in (part, *get_args(part)) for part in parts)
}


def solve(scene: Scene, engine: Engine[N], model: Model = MODEL) -> Result:
    """Return the result of a scene; what cannot be solved is a result with an error."""
    case = OneCase(scene, engine, model)
    return _answer(case, CHAINS[scene.kind])


# Starting processes takes a second or two: as long as so many scenes take some engines.
_FEW = 100


def solve_each(
    scenes: Sequence[Scene], engine: Engine[N] | ManyAtOnce, workers: int = 1
) -> Iterable[Result]:
    """Return the results of scenes, in order; of most engines each when it is asked for.

    Workers are threads of an engine that solves many scenes at once, and processes of another.
    """
    if isinstance(engine, ManyAtOnce):
        return engine.solve_all(scenes, workers)
    if workers == 1 or len(scenes) < _FEW:
        return (solve(scene, engine) for scene in scenes)
    return in_parallel(solve, ((scene, engine) for scene in scenes), workers)


def solve_with_path(
    scene: Scene, engine: Engine[N], model: Model = MODEL
) -> tuple[Result, Trajectory[N]]:
    """Return the result of a scene, and the way of its ball from the start of the scene on."""
    case = OneCase(scene, engine, model)
    result = _answer(case, CHAINS[scene.kind])
    return result, Trajectory(tuple(case.legs))


def solve_with_points(scene: Scene, engine: Engine[N], points: int) -> Result:
    """Return the result of a scene with so many points of its path, if it has any."""
    result, way = solve_with_path(scene, engine)
    if result.error is not None or not way.legs:
        return result
    with engine.numbers.arithmetic():
        rows = way.evenly(points, engine.numbers)
        path = tuple(tuple(map(engine.numbers.report, row)) for row in rows)
    return result.model_copy(update={"path": path})


def solve_with_restitutions(
    scene: AtBatScene, restitutions: Sequence[float], engine: Engine[N], model: Model = MODEL
) -> list[Result]:
    """Return the results of an at-bat struck with balls that differ in restitution only.

    The pitch and its touching of the bat, which do not depend on it, are solved once.
    """
    case = OneCase(scene, engine, model)
    struck: list[tuple[Cases[N], Meeting[N] | None]] = []
    concluded = _follow(case, lambda: struck.append(meet_bat(case)))
    if concluded is not None:
        return [concluded] * len(restitutions)
    ((_, meeting),) = struck
    return [
        _answer(
            replace(case, scene=replaced(scene, {"ball.restitution": e}), answer=dict(case.answer)),
            lambda one: finish(one, meeting),
        )
        for e in restitutions
    ]


def quantities_of(scene: Scene, engine: Engine[N]) -> dict[str, Any]:
    """Return what a result holds by its names, the outcome too, in the engine's own numbers.

    Raises
    ------
    ArithmeticError, ValueError
        If there is no result: `CannotSolve`, `InvalidScene`, `Undecided`, or what `_follow` words.
    """
    case = OneCase(scene, engine, MODEL)
    with engine.numbers.arithmetic():
        CHAINS[scene.kind](case)
    return case.answer


def approach_of(scene: AtBatScene, engine: Engine[N]) -> Approach[N] | None:
    """Return how pitch and bat of a scene meet; None if the pitch does not reach the plate.

    Raises
    ------
    CannotSolve, InvalidScene, Undecided
    """
    with engine.numbers.arithmetic():
        return approach_bat(OneCase(scene, engine, MODEL))[1]


def _answer(case: OneCase[N], chain: Callable[[OneCase[N]], None]) -> Result:
    """Go through a chain to its end; return the result."""
    result = _follow(case, lambda: chain(case))
    assert result is not None
    return result


def _follow(case: OneCase[N], chain: Callable[[], None]) -> Result | None:
    """Go through a chain; return the result, or an error; None if it is not concluded."""
    with case.numbers.arithmetic():
        try:
            try:
                chain()
            except (InvalidScene, Undecided, CannotSolve) as error:
                return case.result(error)
            return case.result() if "outcome" in case.answer else None
        except (ArithmeticError, ValueError) as error:
            what = "a quantity is not finite" if isinstance(error, ValidationError) else str(error)
            reason = OutOfRange(f"the numbers leave the range of the engine: {what}")
            return replace(case, answer={}).result(reason)


def _dot(a: Vector[N], b: Vector[N]) -> N:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
