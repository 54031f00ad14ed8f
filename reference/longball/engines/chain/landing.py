"""Batted balls: from a launch to the ground, or over the fence or against it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, cast

from longball.engines.chain.cases import Cases
from longball.engines.chain.flying import fly, to_ground, to_level
from longball.engines.engine import Engine, Launch, Stepped
from longball.engines.event import Event, Piece
from longball.engines.fence import Place, Stop, at_stop, first_crossing, stop_at
from longball.engines.path import Flight, Path
from longball.model.frame import Frame, launch_frame
from longball.model.law import Law, PlaneState, State, in_plane
from longball.model.numbers import N, Undecided, Vector, absolute
from longball.model.result import Outcome
from longball.model.scene import landing_height


def solve_flights(cases: Cases[N]) -> None:
    """Solve launches and landings."""
    position = cases.vector(cases.scene.launch.position)
    velocity = cases.vector(cases.scene.launch.velocity)
    nothing, spin = cases.numbers.exact(0.0), cases.spin(cases.scene.launch.spin)
    land(cases, Launch(position, velocity, nothing, nothing, spin=spin), "landed")


@dataclass(frozen=True)
class Batted(Generic[N]):
    """A ball that is set free: its launch, and frame, law and start of its flight."""

    launch: Launch[N]
    frame: Frame[N]
    law: Law[N]
    start: PlaneState[N]


def land(cases: Cases[N], launch: Launch[N], outcome: Outcome) -> None:
    """Fly from launches to the ground, or to a fence; the `outcome` if the ball lands."""
    frame, start = launch_frame(launch.position, launch.velocity, cases.numbers, launch.spin)
    ball = Batted(launch, frame, cases.law(frame), start)
    if launch.landed:
        flight = Flight(Path(()), "ground", cases.numbers.exact(0.0), start)
        _come_down(cases, ball, flight, outcome)
    elif cases.scene.fence is None:
        _land(cases, ball, outcome)
    elif "v" not in ball.law.variables and not isinstance(cases.engine, Stepped):
        senses = {"fence": 1, "fence_behind": -1}
        fences = (partial(_to_fence, name, sense) for name, sense in senses.items())
        flight = fly(cases, ball.law, frame, start, to_ground, *fences)
        ahead, behind = flight.stopped("fence"), flight.stopped("fence_behind")
        inside, stayed, whole = cases.take((ahead | behind) ^ True, ball, flight)
        _come_down(inside, stayed, whole, outcome)
        for name, sense in senses.items():
            some, out, way = cases.take(flight.stopped(name), ball, flight)
            if not some.empty:
                place = _stop(some, out.frame, out.start, sense).place
                _meet_fence(some, out, way, place, outcome)
    else:
        cases.land_in_space(ball, outcome)


def _land(cases: Cases[N], ball: Batted[N], outcome: Outcome) -> None:
    """Fly from launches to the ground, but for balls that loop above it for ever."""
    if hasattr(cases.scene, "launch"):
        cases, ball = _land_from_below(cases, ball, outcome)
        if cases.empty:
            return
    law, start, limit = ball.law, ball.start, cases.time_limit
    if _may_loop(cases, law):
        aloft, others = _stays_aloft(cases, law, start, cases.ground(start))
        (looping,) = cases.take(aloft)
        path = Path(_when_asked(cases.engine, law, law.state_of(start), limit))
        looping.follow(ball.frame, Flight(path, "time", limit, start), ball.launch.time)
        looping.conclude("airborne")
        cases, ball = cases.take(others, ball)
        if cases.empty:
            return
    flight = fly(cases, ball.law, ball.frame, ball.start, to_ground)
    _come_down(cases, ball, flight, outcome)


def _land_from_below(cases: Cases[N], ball: Batted[N], outcome: Outcome) -> tuple[Any, ...]:
    """Land the balls that are launched below the ground; return the others.

    One that is hit to an upper deck is such a ball. A landing is a fall through the ground's
    height: first it rises through that.
    """
    rise = cases.numbers.exact(landing_height(cases.scene)) - ball.start.z
    under, level = cases.decide(rise, rise * 0, "whether the ball starts below the ground")
    others = cases.take(level, ball)
    cases, ball = cases.take(under, ball)
    if not cases.empty:
        up = fly(cases, ball.law, ball.frame, ball.start, to_level)
        flight = cases.either(up.stopped("level"), _fly_on, _as_it_is, up, ball)
        _come_down(cases, ball, flight, outcome)
    return others


def _fly_on(cases: Cases[N], up: Flight[N], ball: Batted[N]) -> Flight[N]:
    left = cases.time_limit - up.time
    return up.then(fly(cases, ball.law, ball.frame, up.state, to_ground, limit=left))


def _as_it_is(cases: Cases[N], up: Flight[N], ball: Batted[N]) -> Flight[N]:
    return up


def _come_down(
    cases: Cases[N], ball: Batted[N], flight: Flight[N], outcome: Outcome, fair: bool | None = None
) -> None:
    """Conclude flights that end on the ground, or with the time limit.

    `fair` is known where the ball has left the field.
    """
    cases.follow(ball.frame, flight, ball.launch.time)
    cases, ball, flight = _in_time(cases, ball, flight)
    (airborne,) = cases.take(flight.stopped("time"))
    airborne.conclude("home_run" if outcome == "home_run" else "airborne")
    cases, ball, flight = cases.take(flight.stopped("ground"), ball, flight)
    if cases.empty:
        return
    _rise(cases, ball, flight)
    launch, frame = ball.launch, ball.frame
    state: Any = flight.state
    x, y, z = position = frame.position(state)
    cases.record("landing.time", launch.time + flight.time)
    cases.record("landing.hang_time", launch.delay + flight.time)
    cases.record("landing.position", (x, y, z))
    u, v, w = velocity = frame.velocity(state)
    cases.record("landing.velocity", velocity)
    cases.record("landing.angle", cases.numbers.angle(-w, cases.numbers.sqrt(u * u + v * v)))
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
        lands_foul, lands_fair = _foul(cases, position, "lands fair")
        cases.record("landing.fair", lands_fair)
        (cases,) = cases.take(lands_foul | lands_fair)
    cases.conclude(outcome)


def _rise(cases: Cases[N], ball: Batted[N], flight: Flight[N]) -> None:
    """Record the highest point of flights that do not end in it."""
    top = flight.highest(cases.numbers)
    if top is not None:
        time, state = top
        cases.record("apex.time", ball.launch.time + time)
        cases.record("apex.position", ball.frame.position(state))


def _in_time(cases: Cases[N], ball: Batted[N], flight: Flight[N]) -> tuple[Any, ...]:
    """Return those of which it is certain whether the ball lands in the time limit.

    The engine knows of the errors of its flight, but not of that of the launch.
    """
    error, state = ball.launch.error, flight.state
    if error is None:
        return cases, ball, flight
    left = (cases.time_limit - flight.time) * absolute(state.w)
    above = state.z - cases.numbers.exact(landing_height(cases.scene))
    margin = cases.numbers.where(flight.stopped("time"), above, left)
    question = "whether the ball touches the ground in the time limit"
    certain, never = cases.decide(margin, error * flight.time, question)
    return cases.take(certain | never, ball, flight)


def _may_loop(cases: Cases[N], law: Law[N]) -> bool:
    """Tell whether nothing but lift about a fixed axis and gravity acts, in some of the cases."""
    return (
        law.is_paper
        and "lift" in law.strengths
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


def _to_fence(name: str, sense: int, cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    return at_stop(name, _stop(cases, frame, start, sense), sense, cases.numbers)


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
    flight: Flight[N],
    place: Place[N],
    outcome: Outcome,
    landing: Flight[N] | None = None,
) -> None:
    """Conclude flights that are at the fence; `landing` has where they land if they go on."""
    numbers, frame = cases.numbers, ball.frame
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
    wall, stopped, way = cases.take(known & into, ball, flight)
    wall.follow(stopped.frame, way, stopped.launch.time)
    if not wall.empty:
        _rise(wall, stopped, way)
    wall.conclude("wall")
    cases, ball, flight = cases.take(known & over, ball, flight)
    if cases.empty:
        return
    if landing is None:
        left = cases.time_limit - flight.time
        second = fly(cases, ball.law, ball.frame, flight.state, to_ground, limit=left)
        landing = flight.then(second)
    conditions = _foul(cases, ball.frame.position(flight.state), "leaves the field fair")
    around = cases.scene.fence.polyline is None
    for fair, condition in zip((False, True), conditions, strict=True):
        some, gone, way = cases.take(condition, ball, landing)
        if not some.empty:
            beyond: Outcome = "home_run" if fair or around else outcome
            _come_down(some, gone, way, beyond, fair)


def land_in_space(case: Cases[N], ball: Batted[N], outcome: Outcome) -> None:
    """Follow a flight that leaves its plane past the fence, of one scene; see `Cases`."""
    frame, numbers = ball.frame, case.numbers
    flight = fly(case, ball.law, frame, ball.start, to_ground)
    fence, pieces, error = (
        case.scene.fence,
        flight.path.pieces(),
        numbers.exact(_flight_error(case)),
    )
    (x, y, z), w = frame.position(flight.state), frame.velocity(flight.state)[2]
    off = error * (1 + absolute(x) + absolute(y) + absolute(z))
    late = off / absolute(w) if flight.stop == "ground" else numbers.exact(0.0)
    met = first_crossing(fence, frame, pieces, flight.time, late, error, numbers)
    if met is None:
        _come_down(case, ball, flight, outcome)
        return
    x, y, z = frame.position(met.state)
    above = z - numbers.exact(landing_height(case.scene))
    question = "whether the ball reaches the fence before it touches the ground"
    off = error * (1 + absolute(x) + absolute(y) + absolute(z))
    case.decide(above, off, question)
    if met.doubtful:
        reason = "it comes as close as a state's error"
        case.refuse(Undecided(f"whether the ball reaches the fence cannot be decided: {reason}"))
    stopped = Flight(flight.path, "fence", met.time, met.state)
    _meet_fence(case, ball, stopped, met.place, outcome, flight)
