"""The chain of an at-bat: pitch, plate, contact, impact, landing.

Written once, over any engine and its number system. It follows the paper's Sec. III: the throw,
the swing that is aimed at where the throw would cross the plate, the collision of Sec. III.C and
Appendix A, the flight to the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

from pydantic import ValidationError

from longball.engines.engine import (
    Arrival,
    BatSection,
    CannotSolve,
    Engine,
    Launch,
    Stepped,
    Stops,
    Touch,
)
from longball.model import result as written
from longball.model.bat import bat_velocity, couple, lever
from longball.model.impact import energy_change, impulse, velocity_after
from longball.model.motion import FlightPlane, Forces, PlaneState, forces, into_plane
from longball.model.numbers import N, Numbers, Undecided, Vector
from longball.model.quantities import replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, ImpactScene, PitchScene, Scene


def solve(scene: Scene, engine: Engine[N]) -> Result:
    """Return the result of a scene; what cannot be solved is a result with an error."""
    with engine.numbers.arithmetic():
        try:
            match scene:
                case FlightScene():
                    return solve_flight(scene, engine)
                case PitchScene():
                    return solve_pitch(scene, engine)
                case ImpactScene():
                    return solve_impact(scene, engine)
                case AtBatScene():
                    return strike(scene, meet(scene, engine), engine)
        except (ArithmeticError, ValueError) as error:
            return _unsolved(scene, engine, _reason(error))


def solve_with_restitutions(
    scene: AtBatScene, restitutions: Sequence[float], engine: Engine[N]
) -> list[Result]:
    """Return the results of an at-bat struck with balls that differ in restitution only.

    The pitch and its touching of the bat, which do not depend on it, are solved once.
    """
    with engine.numbers.arithmetic():
        try:
            meeting = meet(scene, engine)
        except (ArithmeticError, ValueError) as error:
            return [_unsolved(scene, engine, _reason(error))] * len(restitutions)
        results = []
        for e in restitutions:
            one = replaced(scene, {"ball.restitution": e})
            try:
                results.append(strike(one, meeting, engine))
            except (ArithmeticError, ValueError) as error:
                results.append(_unsolved(one, engine, _reason(error)))
        return results


def _reason(error: ArithmeticError | ValueError) -> str:
    if isinstance(error, Undecided | CannotSolve):
        return str(error)
    what = "a quantity is not finite" if isinstance(error, ValidationError) else str(error)
    return f"the numbers leave the range of the engine: {what}"


# --- a ball that is already in the air ------------------------------------------------------------


def solve_flight(scene: FlightScene, engine: Engine[N]) -> Result:
    """Solve launch and landing."""
    numbers = engine.numbers
    position = _vector(scene.launch.position, numbers)
    velocity = _vector(scene.launch.velocity, numbers)
    nothing = numbers.exact(0.0)
    landing = _land(scene, Launch(position, velocity, nothing, nothing), engine)
    return Result(
        id=scene.id,
        engine=engine.description,
        outcome="landed" if landing else "airborne",
        landing=landing,
    )


def _land(
    scene: FlightScene | AtBatScene, launch: Launch[N], engine: Engine[N]
) -> written.Landing | None:
    """Fly from a launch to the ground; None if still airborne."""
    numbers = engine.numbers
    plane, start = into_plane(launch.position, launch.velocity, numbers)
    nothing = numbers.exact(0.0)
    if launch.landed:
        arrival = Arrival("floor", nothing, start, None)
    else:
        arrival = _fly(start, _forces(scene, numbers), _ground(scene, numbers), engine)
    if arrival.stop == "time":
        return None
    x, y, z = plane.position(arrival.state)
    return written.Landing(
        time=numbers.report(launch.time + arrival.time),
        hang_time=numbers.report(launch.delay + arrival.time),
        position=_triple((x, y, z), numbers),
        velocity=_triple(plane.velocity(arrival.state), numbers),
        distance=numbers.report(numbers.sqrt(x * x + y * y)),
    )


def _ground(scene: FlightScene | AtBatScene, numbers: Numbers[N]) -> Stops[N]:
    return Stops(
        time_limit=numbers.exact(scene.time_limit),
        floor=numbers.exact(scene.floor(scene.ground)),
    )


def _fly(start: PlaneState[N], forces: Forces[N], stops: Stops[N], engine: Engine[N]) -> Arrival[N]:
    """Fly to a stop, through the vertical if need be.

    With lift that is always up, a ball that reaches the vertical cannot leave it: on either side
    the horizontal part of the lift drives it back. It goes on without lift, straight up and down
    (the sliding solution in Filippov's sense; on the way down it is the symmetric one of two).
    """
    if forces.lift is None or not forces.always_up:
        return engine.fly(start, forces, stops)
    if start.u == 0.0:  # from rest, or straight up or down: it is there already
        return engine.fly(start, replace(forces, lift=None), stops)
    arrival = engine.fly(start, forces, replace(stops, vertical=True))
    if arrival.stop != "vertical":
        return arrival
    upright = arrival.state._replace(u=engine.numbers.exact(0.0))
    rest = replace(stops, time_limit=stops.time_limit - arrival.time)
    end = engine.fly(upright, replace(forces, lift=None), rest)
    return replace(end, time=arrival.time + end.time)


# --- the pitch ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Delivery(Generic[N]):
    """A pitch up to the plate, or to wherever it ended before."""

    plane: FlightPlane[N]
    forces: Forces[N]
    stops: Stops[N]
    arrival: Arrival[N]


def solve_pitch(scene: PitchScene, engine: Engine[N]) -> Result:
    """Solve release and plate."""
    delivery = _deliver(scene, engine)
    return Result(
        id=scene.id,
        engine=engine.description,
        outcome=_outcome_of_pitch(delivery),
        plate=_plate(delivery, engine.numbers),
    )


def _deliver(scene: PitchScene | AtBatScene, engine: Engine[N]) -> Delivery[N]:
    """Throw from the release toward the point aimed at, and fly to the plane x = 0."""
    numbers = engine.numbers
    x, y, z = _vector(scene.pitch.release, numbers)
    aim_y, aim_z = (numbers.exact(value) for value in scene.pitch.aim)
    toward = (-x, aim_y - y, aim_z - z)
    scale = numbers.exact(scene.pitch.speed) / numbers.sqrt(_dot(toward, toward))
    velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    plane, start = into_plane((x, y, z), velocity, numbers)
    stops = Stops(
        time_limit=numbers.exact(scene.time_limit),
        floor=numbers.exact(scene.floor(scene.ground)),
        wall=-x / plane.cos,
    )
    field = _forces(scene, numbers)
    return Delivery(plane, field, stops, _fly(start, field, stops, engine))


def _outcome_of_pitch(delivery: Delivery[N]) -> written.Outcome:
    match delivery.arrival.stop:
        case "wall":
            return "crossed"
        case "floor":
            return "grounded"
        case _:
            return "airborne"


def _plate(delivery: Delivery[N], numbers: Numbers[N]) -> written.Plate | None:
    arrival, plane = delivery.arrival, delivery.plane
    if arrival.stop != "wall":
        return None
    _, y, z = plane.position(arrival.state)
    return written.Plate(
        time=numbers.report(arrival.time),
        position=_triple((numbers.exact(0.0), y, z), numbers),
        velocity=_triple(plane.velocity(arrival.state), numbers),
    )


# --- ball and bat ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Blow(Generic[N]):
    """Ball and bat at the touching, before the impulse."""

    position: Vector[N]
    velocity: Vector[N]
    normal: Vector[N]
    lever: N
    bat_velocity: Vector[N]
    normal_speed: N
    closing: bool


def solve_impact(scene: ImpactScene, engine: Engine[N]) -> Result:
    """Solve a touching that is given."""
    numbers = engine.numbers
    # Nothing has flown: the position is exact, and only the roundings of the blow are in doubt.
    blow = _blow(
        scene,
        _vector(scene.incoming.position, numbers),
        _vector(scene.incoming.velocity, numbers),
        numbers.exact(scene.incoming.bat_height),
        0.0,
        numbers,
    )
    if blow is None:
        return Result(id=scene.id, engine=engine.description, outcome="beyond_bat")
    impact, _ = _impact(scene, blow, numbers) if blow.closing else (None, None)
    return Result(
        id=scene.id,
        engine=engine.description,
        outcome="struck" if blow.closing else "separating",
        contact=_contact(blow, numbers),
        impact=impact,
    )


def _blow(
    scene: ImpactScene | AtBatScene,
    position: Vector[N],
    velocity: Vector[N],
    height: N,
    inherited: float,
    numbers: Numbers[N],
    noticed: Vector[N] | None = None,
    leaving: bool = False,
) -> Blow[N] | None:
    """Return ball and bat at a touching; None beyond the bat's ends, |y| >= L/2.

    `inherited` is the relative error of position and velocity before any rounding here. For
    `noticed` (here a position) and `leaving` see `longball.engines.engine.Touch`.
    """
    half = numbers.exact(scene.bat.length) / 2
    slack = half * (inherited + 2 * numbers.rounding) if inherited else numbers.exact(0.0)
    aside = abs((noticed or position)[1])
    if not numbers.positive(half - aside, slack, "whether the ball meets the bat or its end"):
        return None
    x, y, z = position
    distance = numbers.sqrt(x * x + (z - height) * (z - height))
    normal = (x / distance, numbers.exact(0.0), (z - height) / distance)
    arm = lever(y, scene.bat, numbers)
    bat = bat_velocity(arm, scene.swing, numbers)
    relative = (velocity[0] - bat[0], velocity[1] - bat[1], velocity[2] - bat[2])
    normal_speed = _dot(relative, normal)
    # Six operations stand between the velocities and their normal part.
    terms = (
        (velocity[0], normal[0]),
        (bat[0], normal[0]),
        (velocity[2], normal[2]),
        (bat[2], normal[2]),
    )
    doubt = numbers.exact(0.0)
    for a, b in terms:
        doubt += abs(a * b) * (inherited + 6 * numbers.rounding)
    # The force is the same for n and -n; a ball that would leave the bat approaches its back.
    approach = normal_speed if leaving else -normal_speed
    closing = numbers.positive(approach, doubt, "whether ball and bat approach or separate")
    return Blow(position, velocity, normal, arm, bat, normal_speed, closing)


def _impact(
    scene: ImpactScene | AtBatScene, blow: Blow[N], numbers: Numbers[N]
) -> tuple[written.Impact, Vector[N]]:
    """Apply the impulse of Appendix A; return it as written, and the ball's velocity after it."""
    pair = couple(scene.ball, scene.bat, blow.lever, scene.reading, numbers)
    push = impulse(pair.reduced_mass, pair.restitution, blow.normal_speed)
    after = velocity_after(blow.velocity, blow.normal, numbers.exact(scene.ball.mass), push)
    change = energy_change(pair.reduced_mass, pair.restitution, blow.normal_speed)
    impact = written.Impact(
        restitution=numbers.report(pair.restitution),
        impulse=numbers.report(push),
        velocity=_triple(after, numbers),
        energy_change=numbers.report(change),
    )
    return impact, after


def _contact(
    blow: Blow[N], numbers: Numbers[N], time: N | None = None, margin: N | None = None
) -> written.Contact:
    return written.Contact(
        time=None if time is None else numbers.report(time),
        position=_triple(blow.position, numbers),
        normal=_triple(blow.normal, numbers),
        bat_velocity=_triple(blow.bat_velocity, numbers),
        normal_speed=numbers.report(blow.normal_speed),
        margin=None if margin is None else numbers.report(margin),
    )


# --- the whole at-bat -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Meeting(Generic[N]):
    """Pitch and bat up to the touching: all of an at-bat that the ball's restitution leaves alone.

    `touch` and `height` (m, of the bat's axis) are None for a pitch that never reaches the plate.
    """

    delivery: Delivery[N]
    touch: Touch[N] | None
    height: N | None


def meet(scene: AtBatScene, engine: Engine[N]) -> Meeting[N]:
    """Throw the pitch, put the bat where it is swung, and find how the two meet."""
    delivery = _deliver(scene, engine)
    if delivery.arrival.stop != "wall":
        return Meeting(delivery, None, None)
    numbers = engine.numbers
    # z_b = z'_b + σ_b (paper, Sec. III.A)
    height = delivery.arrival.state.z + numbers.exact(scene.swing.height_offset)
    bat = BatSection(
        x=delivery.plane.x,
        cos=delivery.plane.cos,
        height=height,
        reach=numbers.exact(scene.ball.radius) + numbers.exact(scene.bat.radius),
    )
    field = delivery.forces
    stops = replace(delivery.stops, vertical=field.always_up and field.lift is not None)
    return Meeting(delivery, engine.touch(delivery.arrival, field, bat, stops), height)


def strike(scene: AtBatScene, meeting: Meeting[N], engine: Engine[N]) -> Result:
    """Finish an at-bat from where pitch and bat meet.

    `scene` may differ in the ball's restitution from the scene that was met. Whoever calls this
    or `meet` by itself does so within the engine's `numbers.arithmetic()`.
    """
    numbers = engine.numbers
    delivery, touch, height = meeting.delivery, meeting.touch, meeting.height
    plate = _plate(delivery, numbers)
    if touch is None or height is None:
        return Result(id=scene.id, engine=engine.description, outcome=_outcome_of_pitch(delivery))
    margin = written.Contact(margin=numbers.report(touch.margin))
    if touch.touched is None:
        return _unsolved(scene, engine, touch.doubt, plate, margin)
    if touch.time is None or touch.state is None:
        return Result(
            id=scene.id, engine=engine.description, outcome="missed", plate=plate, contact=margin
        )
    position = delivery.plane.position(touch.state)
    velocity = delivery.plane.velocity(touch.state)
    try:
        blow = _blow(
            scene,
            position,
            velocity,
            height,
            engine.flight_error,
            numbers,
            noticed=delivery.plane.position(touch.noticed) if touch.noticed else None,
            leaving=touch.leaving,
        )
    except Undecided as doubt:
        return _unsolved(scene, engine, str(doubt), plate, margin)
    if blow is None:
        beyond = written.Contact(
            time=numbers.report(touch.time),
            position=_triple(position, numbers),
            margin=numbers.report(touch.margin),
        )
        return Result(
            id=scene.id,
            engine=engine.description,
            outcome="beyond_bat",
            plate=plate,
            contact=beyond,
        )
    contact = _contact(blow, numbers, touch.time, touch.margin)
    if not blow.closing:
        return Result(
            id=scene.id,
            engine=engine.description,
            outcome="separating",
            plate=plate,
            contact=contact,
        )
    impact, after = _impact(scene, blow, numbers)
    if isinstance(engine, Stepped):
        kick = (after[0] - velocity[0], after[1] - velocity[1], after[2] - velocity[2])
        field, ground = _forces(scene, numbers), _ground(scene, numbers)
        launch = engine.rebound(delivery.plane, touch, kick, field, ground)
    else:
        launch = Launch(position, after, touch.time, numbers.exact(0.0))
    landing = _land(scene, launch, engine)
    return Result(
        id=scene.id,
        engine=engine.description,
        outcome="batted" if landing else "airborne",
        plate=plate,
        contact=contact,
        impact=impact,
        landing=landing,
    )


# --- small things ---------------------------------------------------------------------------------


def _forces(scene: FlightScene | PitchScene | AtBatScene, numbers: Numbers[N]) -> Forces[N]:
    always_up = scene.reading.lift_direction == "always_up"
    return forces(scene.ball, scene.air, scene.gravity, always_up, numbers)


def _unsolved(
    scene: Scene,
    engine: Engine[N],
    reason: str,
    plate: written.Plate | None = None,
    contact: written.Contact | None = None,
) -> Result:
    return Result(
        id=scene.id, engine=engine.description, plate=plate, contact=contact, error=reason
    )


def _vector(values: tuple[float, float, float], numbers: Numbers[N]) -> Vector[N]:
    x, y, z = values
    return numbers.exact(x), numbers.exact(y), numbers.exact(z)


def _triple(vector: Vector[N], numbers: Numbers[N]) -> written.Triple:
    x, y, z = vector
    return numbers.report(x), numbers.report(y), numbers.report(z)


def _dot(a: Vector[N], b: Vector[N]) -> N:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
