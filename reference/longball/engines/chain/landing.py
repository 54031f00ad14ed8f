"""Batted balls: from a launch to the ground, or over the fence or against it."""

from __future__ import annotations

from dataclasses import dataclass

from longball.engines.chain.flying import fly, spin_at
from longball.engines.chain.run import Mask, Run
from longball.engines.engine import Launch, Stepped
from longball.engines.event import level
from longball.engines.fence import Place, at_stop, first_crossing, stop_at
from longball.engines.path import Flight, Path
from longball.model.frame import Frame, launch_frame
from longball.model.law import Law, State, in_plane
from longball.model.numbers import N, Undecided, Vector
from longball.model.result import Outcome
from longball.model.scene import landing_height


def solve_flights(run: Run) -> None:
    """Solve flight scenes."""
    launch, nothing = run.scene.launch, run.numbers.exact(0.0)
    position, velocity = run.vector(launch.position), run.vector(launch.velocity)
    free = Launch(position, velocity, nothing, nothing, spin=run.spin(launch.spin))
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
    frame, start = launch_frame(launch.position, launch.velocity, run.numbers, launch.spin)
    law = run.law(frame)
    ball = Batted(launch, frame, law, start)
    if launch.landed:
        down = Flight(Path(()), "ground", run.numbers.exact(0.0), law.state_of(start))
        _come_down(run, ball, down, outcome, rows)
    elif run.scene.fence is None:
        # A pitch has not touched the ground, so that a batted ball starts above it.
        if hasattr(run.scene, "launch"):
            rows = _land_from_below(run, ball, outcome, rows)
        if run.some(rows):
            _come_down(run, ball, _fly_down(run, ball, start, run.time_limit, rows), outcome, rows)
    elif "v" not in law.variables and not isinstance(run.engine, Stepped):
        _cross_fence_in_plane(run, ball, outcome, rows)
    elif not run.land_one_by_one(launch, outcome, rows):
        _cross_fence_in_space(run, ball, outcome, rows)


def _fly_down(run: Run, ball: Batted, start: State, limit: N, rows: Mask) -> Flight:
    """Fly to the ground."""
    return fly(run, ball.law, start, lambda state: [run.ground(state)], limit, rows)


def _land_from_below(run: Run, ball: Batted, outcome: Outcome, rows: Mask) -> Mask:
    """Land the balls that are launched below the ground; return the other rows.

    A ball that is hit to an upper deck is such a ball: `ground.height` is above its launch. It
    lands when it falls through that height, and so has to rise through it first.
    """
    height, limit = landing_height(run.scene, run.numbers.exact), run.time_limit
    rise = height - ball.start.z
    under, others = run.decide(rise, rise * 0, "whether the ball starts below the ground", rows)
    if run.some(under):
        flight = fly(
            run, ball.law, ball.start, lambda at: [level(height, at, run.numbers)], limit, under
        )
        risen = under & flight.stopped("level")
        if run.some(risen):
            down = _fly_down(run, ball, flight.state, limit - flight.time, risen)
            flight = flight.then(down)
        _come_down(run, ball, flight, outcome, under)
    return others


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
    rows = _in_time(run, ball, flight, rows)
    aloft: Outcome = "home_run" if outcome == "home_run" else "airborne"
    run.conclude(aloft, rows & flight.stopped("time"))
    rows = rows & flight.stopped("ground")
    if not run.some(rows):
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
    top = flight.highest(run.numbers)
    if top is not None:
        time, state = top
        run.record("apex.time", ball.launch.time + time, rows)
        run.record("apex.position", ball.frame.position(state), rows)


def _in_time(run: Run, ball: Batted, flight: Flight, rows: Mask) -> Mask:
    """Return the rows in which it is certain whether the ball lands in the time limit.

    The engine allows for the error of its flight, but not for that of the velocity at launch, δv,
    which moves the ball by δv t: compare that with the height that is left.
    """
    error, state = ball.launch.error, flight.state
    if error is None:
        return rows
    left = (run.time_limit - flight.time) * abs(state.w)
    above = state.z - landing_height(run.scene, run.numbers.exact)
    margin = run.numbers.where(flight.stopped("time"), above, left)
    question = "whether the ball touches the ground in the time limit"
    certain, never = run.decide(margin, error * flight.time, question, rows)
    return certain | never


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
    numbers, start, senses = run.numbers, ball.start, {"fence": 1, "fence_behind": -1}
    error = numbers.exact(_heading_error(run))
    stops = {
        name: stop_at(run.scene.fence, ball.frame, start.s, sense, error, numbers)
        for name, sense in senses.items()
    }
    fences = [at_stop(name, stops[name], sense, numbers) for name, sense in senses.items()]
    flight = fly(
        run, ball.law, start, lambda state: [run.ground(state), *fences], run.time_limit, rows
    )
    inside = rows & (flight.stopped("ground") | flight.stopped("time"))
    if run.some(inside):
        _come_down(run, ball, flight, outcome, inside)
    for name, stop in stops.items():
        stopped = rows & flight.stopped(name)
        if run.some(stopped):
            _meet_fence(run, ball, flight, stop.place, outcome, stopped)


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
    aside = heading * (1 + abs(x) + abs(y))
    known, at_vertex = run.decide(place.to_break, aside, question, rows)
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
    if run.some(into):
        _rise(run, ball, flight, into)
    run.conclude("wall", into)
    over = known & over
    if not run.some(over):
        return

    # out of the field
    if landing is None:
        left = run.time_limit - flight.time
        landing = flight.then(_fly_down(run, ball, flight.state, left, over))
    foul, fair = _foul(run, frame.position(flight.state), "leaves the field fair", over)
    around = run.scene.fence.polyline is None
    if run.some(fair):
        _come_down(run, ball, landing, "home_run", fair, True)
    if run.some(foul):
        _come_down(run, ball, landing, "home_run" if around else outcome, foul, False)
