"""At-bats under other equations of motion, for mistakes that no scene and no engine can express.

The equations of `longball.model.motion` keep a flight in its plane. Some mistakes do not: they are
flown in space here, with the same bat and the same impulse. Good to 1e-9; a fingerprint needs no
more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.integrate
import scipy.optimize
from numpy.typing import NDArray

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.model import result as written
from longball.model.motion import Forces, forces, into_plane
from longball.model.numbers import DOUBLES
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, ImpactScene, Incoming, PitchScene, Scene

Array = NDArray[np.float64]

# Acceleration by drag, m/s², from k_D = ρ C_D A/(2m), 1/m, and the velocity, m/s.
Drag = Callable[[float, Array], Array]


@dataclass(frozen=True)
class DragLaw:
    """Drag against the velocity, each component times a speed: the model's law, and slips of it.

    Attributes
    ----------
    whole
        Whether times the whole speed V.
    own
        Whether times the component's own size.
    """

    whole: bool
    own: bool

    def __call__(self, k: float, velocity: Array) -> Array:
        """Return the acceleration by drag; see `Drag`."""
        drag: Array = -k * velocity
        if self.whole:
            drag = drag * math.sqrt(float(velocity @ velocity))
        return drag * np.abs(velocity) if self.own else drag


THE_MODELS = DragLaw(whole=True, own=False)

TOLERANCE = 1e-11


def solve_with_drag(scene: Scene, drag: Drag) -> Result:
    """Return the result of a scene in which the air drags by another law."""
    match scene:
        case ImpactScene():
            return solve(scene, Ivp())
        case FlightScene():
            state = np.array([*scene.launch.position, *scene.launch.velocity])
            landing = _land(scene, state, 0.0, drag)
            return Result(id=scene.id, outcome="landed" if landing else "airborne", landing=landing)
        case _:
            return _solve_pitch(scene, drag)


def release(scene: PitchScene | AtBatScene) -> Array:
    """Return where a pitch starts, m, and how fast, m/s, as one array."""
    position = np.array(scene.pitch.release)
    toward = np.array([0.0, *scene.pitch.aim]) - position
    return np.concatenate([position, scene.pitch.speed * toward / np.linalg.norm(toward)])


def _solve_pitch(scene: PitchScene | AtBatScene, drag: Drag) -> Result:
    start = release(scene)
    floor = scene.floor(scene.ground)
    end, path, stop = fly(
        scene, start, drag, [lambda y: float(y[0]), lambda y: float(y[2]) - floor]
    )
    if stop != 0:
        outcome: Any = "grounded" if stop == 1 else "airborne"
        return Result(id=scene.id, outcome=outcome)
    at_plate = path(end)
    plate = written.Plate(time=end, position=_triple(at_plate[:3]), velocity=_triple(at_plate[3:]))
    if isinstance(scene, PitchScene):
        return Result(id=scene.id, outcome="crossed", plate=plate)
    return _meet(scene, start, plate, float(at_plate[2]) + scene.swing.height_offset, drag)


def _meet(
    scene: AtBatScene, start: Array, plate: written.Plate, height: float, drag: Drag
) -> Result:
    reach = scene.ball.radius + scene.bat.radius

    def depth(y: Array) -> float:
        return math.hypot(float(y[0]), float(y[2]) - height) - reach

    def approach(y: Array) -> float:
        return -float(y[0] * y[3] + (y[2] - height) * y[5])

    closest, path, _ = fly(scene, start, drag, [approach])
    margin = -depth(path(closest))
    if margin < 0:
        return Result(
            id=scene.id, outcome="missed", plate=plate, contact=written.Contact(margin=margin)
        )
    time = scipy.optimize.brentq(lambda t: depth(path(t)), 0.0, closest, xtol=1e-14)
    ball = path(time)
    position = _triple(ball[:3])
    touching = written.Contact(time=time, position=position, margin=margin)

    def fly_on(after: Array) -> written.Landing | None:
        return _land(scene, np.array([*position, *after]), time, drag)

    return from_contact(scene, plate, touching, _triple(ball[3:]), height, fly_on)


def from_contact(
    scene: AtBatScene,
    plate: written.Plate,
    touching: written.Contact,
    velocity: Any,
    height: float,
    fly_on: Callable[[Array], written.Landing | None],
) -> Result:
    """Return an at-bat whose ball touches the bat with a velocity, m/s; `fly_on` lands it."""
    struck = _strike_at(scene, touching.position, velocity, height)
    contact = (struck.contact or written.Contact()).model_copy(
        update={name: getattr(touching, name) for name in ("time", "position", "margin")}
    )
    if struck.impact is None:
        return Result(id=scene.id, outcome=struck.outcome, plate=plate, contact=contact)
    landing = fly_on(np.array(struck.impact.velocity, float))
    return Result(
        id=scene.id,
        outcome="batted" if landing else "airborne",
        plate=plate,
        contact=contact,
        impact=struck.impact,
        landing=landing,
    )


def _strike_at(scene: AtBatScene, position: Any, velocity: Any, height: float) -> Result:
    """Return contact and impact of a ball that touches the bat at a position, m, velocity, m/s."""
    # Not validated: the touching is as good as its root, and a scene asks for 1e-9 m.
    touching = ImpactScene.model_construct(
        id=scene.id,
        ball=scene.ball,
        bat=scene.bat,
        swing=scene.swing,
        reading=scene.reading,
        incoming=Incoming.model_construct(position=position, velocity=velocity, bat_height=height),
    )
    return solve(touching, Ivp())


def _land(
    scene: FlightScene | AtBatScene, start: Array, time: float, drag: Drag
) -> written.Landing | None:
    floor = scene.floor(scene.ground)
    end, path, stop = fly(scene, start, drag, [lambda y: float(y[2]) - floor])
    if stop is None:
        return None
    ball = path(end)
    return written.Landing(
        time=time + end,
        hang_time=end,
        position=_triple(ball[:3]),
        velocity=_triple(ball[3:]),
        distance=float(np.hypot(ball[0], ball[1])),
    )


def fly(
    scene: FlightScene | PitchScene | AtBatScene,
    start: Array,
    drag: Drag,
    falling: list[Callable[[Array], float]],
) -> tuple[float, Callable[[float], Array], int | None]:
    """Fly until one of the functions falls through zero; return when, the path, and which one."""
    field = forces(scene.ball, scene.air, scene.gravity, False, DOUBLES)
    move = _motion(field, start, drag)
    events = []
    for function in falling:

        def event(_: float, y: Array, function: Callable[[Array], float] = function) -> float:
            return function(y)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1  # type: ignore[attr-defined]
        events.append(event)
    solution = scipy.integrate.solve_ivp(
        move,
        (0.0, scene.time_limit),
        start,
        method="DOP853",
        rtol=TOLERANCE,
        atol=TOLERANCE,
        events=events,
        dense_output=True,
    )
    stop = next((i for i, found in enumerate(solution.t_events) if found.size), None)
    return float(solution.t[-1]), solution.sol, stop


def _motion(field: Forces[float], start: Array, drag: Drag) -> Callable[[float, Array], Array]:
    """Return the right-hand side: drag as given, lift about the backspin axis of the launch."""
    plane, _ = into_plane(_triple(start[:3]), _triple(start[3:]), DOUBLES)
    axis_x, axis_y = plane.sin, -plane.cos
    k_drag, k_lift, gravity = field.drag or 0.0, field.lift or 0.0, field.gravity or 0.0

    def move(_: float, y: Array) -> Array:
        velocity = y[3:]
        x, y_, z = velocity.tolist()
        k = k_lift * math.sqrt(x * x + y_ * y_ + z * z)
        # axis × v, with the axis in the horizontal plane
        lift = (k * axis_y * z, -k * axis_x * z, k * (axis_x * y_ - axis_y * x) - gravity)
        return np.concatenate([velocity, drag(k_drag, velocity) + lift])

    return move


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
