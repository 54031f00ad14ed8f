"""The paper's scheme under another law of drag, for a candidate that makes both mistakes.

`longball.engines.verlet` steps in the vertical plane of the launch, under the model's forces. A law
that drags each component by itself leaves that plane; so here the same steps are taken in space.
Under the model's own law they are the engine's, to rounding (tests/judge/test_alternative_laws.py).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numba
import numpy as np

from longball.engines.engine import BatSection
from longball.engines.verlet import (
    ROUNDS,
    SETTLED,
    TREATMENTS,
    Verlet,
    interpolate,
    line_touch,
    step,
)
from longball.judge.alternative_laws import DragLaw, from_contact, release
from longball.model import result as written
from longball.model.motion import PlaneState, forces, into_plane
from longball.model.numbers import DOUBLES, Vector
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, PitchScene

Triple = tuple[float, float, float]


class State(NamedTuple):
    """Position, m, and velocity, m/s, in space."""

    position: Triple
    velocity: Triple


class March(NamedTuple):
    """How a ball stepped until it was down or had passed a plane.

    Attributes
    ----------
    steps
        How many.
    ended
        Whether one or the other happened within the steps allowed.
    before, after
        The last step's ends.
    closest
        Least distance from the bat's axis at any step, m.
    hit
        Number of the first step in the bat; 0 if there is none.
    outside, inside
        The ends of that step.
    """

    steps: int
    ended: bool
    before: State
    after: State
    closest: float
    hit: int
    outside: State
    inside: State


def solve_in_steps(
    scene: FlightScene | PitchScene | AtBatScene, law: DragLaw, scheme: Verlet
) -> Result:
    """Return what the paper's scheme makes of a scene in which the air drags by another law."""
    if isinstance(scene, FlightScene):
        start = State(scene.launch.position, scene.launch.velocity)
        landing = _land(scene, law, scheme, start, 0.0, 0.0)
        return Result(id=scene.id, outcome="landed" if landing else "airborne", landing=landing)
    floor = scene.floor(scene.ground)
    thrown = release(scene).tolist()
    start = State((thrown[0], thrown[1], thrown[2]), (thrown[3], thrown[4], thrown[5]))
    pitch = _march(scene, law, scheme, start, floor=floor, wall=0.0)
    if not pitch.ended:
        return Result(id=scene.id, outcome="airborne")
    x, after_x = pitch.before.position[0], pitch.after.position[0]
    share = x / (x - after_x) if after_x <= 0.0 else 1.0
    crossing = _between(pitch.before, pitch.after, share)
    if after_x > 0.0 or crossing.position[2] <= floor:
        return Result(id=scene.id, outcome="grounded")
    plate = written.Plate(
        time=(pitch.steps - 1 + share) * scheme.dt,
        position=(0.0, *crossing.position[1:]),
        velocity=crossing.velocity,
    )
    if isinstance(scene, PitchScene):
        return Result(id=scene.id, outcome="crossed", plate=plate)
    return _meet(scene, law, scheme, start, plate)


def _meet(
    scene: AtBatScene, law: DragLaw, scheme: Verlet, start: State, plate: written.Plate
) -> Result:
    height = float(plate.position[2]) + scene.swing.height_offset
    reach = scene.ball.radius + scene.bat.radius
    pitch = _march(
        scene, law, scheme, start,
        floor=scene.floor(scene.ground), wall=-reach, height=height, reach=reach,
    )  # fmt: skip
    contact = written.Contact(margin=reach - pitch.closest)
    if not pitch.hit:
        return Result(id=scene.id, outcome="missed", plate=plate, contact=contact)
    (x, _, z), (u, _, w) = back = pitch.outside
    section = BatSection(x=0.0, cos=1.0, height=height, reach=reach)
    ahead = line_touch(PlaneState(x, z, u, w), section, scheme.root)
    if ahead is None:
        return Result(id=scene.id, plate=plate, contact=contact, error="no Δt' of touching")
    touching = tuple(r + ahead * v for r, v in zip(*back, strict=True))
    time = (pitch.hit - 1) * scheme.dt + ahead
    contact = contact.model_copy(update={"time": time, "position": touching})
    if abs(pitch.inside.position[1]) >= scene.bat.length / 2:
        return Result(id=scene.id, outcome="beyond_bat", plate=plate, contact=contact)

    def fly_on(after: Any) -> written.Landing | None:
        return _rebound(scene, law, scheme, pitch, ahead, after)

    return from_contact(scene, plate, contact, back.velocity, height, fly_on)


def _rebound(
    scene: AtBatScene, law: DragLaw, scheme: Verlet, pitch: March, ahead: float, after: Any
) -> written.Landing | None:
    """Push for two steps from the step before the contact (paper, Appendix B), and let it fly."""
    strengths = _strengths(scene)

    def air(velocity: Any) -> Any:
        v = tuple(velocity.tolist())
        return np.array(air_in_space(v, _heading(v), (law.whole, law.own), strengths))

    dt, floor, state = scheme.dt, scene.floor(scene.ground), pitch.outside
    position, velocity = np.array(state.position), np.array(state.velocity)
    push = (after - velocity) / (2 * dt)
    force = air(velocity)
    for done in (1, 2):
        position, velocity, force = step(
            position, velocity, force, dt, TREATMENTS[scheme.forces], air, push
        )
        before, state = state, State(tuple(position.tolist()), tuple(velocity.tolist()))
        if state.position[2] <= floor:
            count = pitch.hit - 1 + done
            return _landing(scheme, before, state, floor, count * dt, done * dt - ahead)
    return _land(scene, law, scheme, state, (pitch.hit + 1) * dt, 2 * dt - ahead)


def _land(
    scene: FlightScene | AtBatScene,
    law: DragLaw,
    scheme: Verlet,
    start: State,
    time: float,
    hang_time: float,
) -> written.Landing | None:
    floor = scene.floor(scene.ground)
    flight = _march(scene, law, scheme, start, floor=floor)
    if not flight.ended:
        return None
    flown = flight.steps * scheme.dt
    return _landing(scheme, flight.before, flight.after, floor, time + flown, hang_time + flown)


def _landing(
    scheme: Verlet, before: State, after: State, floor: float, time: float, hang_time: float
) -> written.Landing:
    """Return the landing in a step whose end, below the floor, is at a time and hang time."""
    share = 1.0
    if scheme.landing == "interpolated":
        drop = before.position[2] - after.position[2]
        share = max(0.0, (before.position[2] - floor) / drop) if drop else 0.0
    position, velocity = _between(before, after, share)
    early = (1.0 - share) * scheme.dt
    if scheme.landing == "interpolated":
        position = (*position[:2], floor)
    return written.Landing(
        time=time - early,
        hang_time=hang_time - early,
        position=position,
        velocity=velocity,
        distance=math.hypot(position[0], position[1]),
    )


def _between(before: State, after: State, share: float) -> State:
    position, velocity = (
        interpolate(np.array(one), np.array(other), share)
        for one, other in zip(before, after, strict=True)
    )
    return State(tuple(position.tolist()), tuple(velocity.tolist()))


def _strengths(scene: FlightScene | PitchScene | AtBatScene) -> Triple:
    field = forces(scene.ball, scene.air, scene.gravity, False, DOUBLES)
    return field.drag or 0.0, field.lift or 0.0, field.gravity or 0.0


def _heading(velocity: Vector[float]) -> tuple[float, float]:
    plane, _ = into_plane((0.0, 0.0, 0.0), velocity, DOUBLES)
    return plane.cos, plane.sin


def _march(
    scene: FlightScene | PitchScene | AtBatScene,
    law: DragLaw,
    scheme: Verlet,
    start: State,
    *,
    floor: float,
    wall: float = -math.inf,
    height: float = 0.0,
    reach: float = 0.0,
) -> March:
    steps, ended, before, after, closest, hit, outside, inside = march(
        *start,
        _heading(start.velocity),
        (law.whole, law.own),
        _strengths(scene),
        scheme.dt,
        tuple(TREATMENTS[scheme.forces]),
        math.ceil(scene.time_limit / scheme.dt),
        floor,
        wall,
        height,
        reach,
    )
    return March(
        steps, ended, State(*before), State(*after), closest, hit, State(*outside), State(*inside)
    )


# --- compiled -------------------------------------------------------------------------------------

compiled = numba.njit(cache=True)


@compiled
def moved(a, factor, b):  # type: ignore[no-untyped-def]
    """Return a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@compiled
def air_in_space(velocity, heading, law, strengths):  # type: ignore[no-untyped-def]
    """Return the acceleration of a ball with backspin that was launched toward a heading."""
    x, y, z = velocity
    cos, sin = heading
    whole, own = law
    drag, lift, gravity = strengths
    speed = math.sqrt(x * x + y * y + z * z)
    k = drag * speed if whole else drag
    turn = lift * speed
    return (
        -k * (abs(x) if own else 1.0) * x - turn * cos * z,
        -k * (abs(y) if own else 1.0) * y - turn * sin * z,
        -k * (abs(z) if own else 1.0) * z + turn * (cos * x + sin * y) - gravity,
    )


@compiled
def step_in_space(  # type: ignore[no-untyped-def]
    position, velocity, force, heading, law, strengths, dt, treatment
):
    """Return `longball.engines.verlet.step`, without a push."""
    ahead, iterates, carries = treatment
    half = moved(velocity, 0.5 * dt, force)
    position = moved(position, dt, half)
    force = air_in_space(moved(velocity, ahead * dt, force), heading, law, strengths)
    velocity = moved(half, 0.5 * dt, force)
    if iterates:
        for _ in range(ROUNDS):
            old = velocity
            force = air_in_space(old, heading, law, strengths)
            velocity = moved(half, 0.5 * dt, force)
            change = max(
                abs(velocity[0] - old[0]), abs(velocity[1] - old[1]), abs(velocity[2] - old[2])
            )
            if change <= SETTLED * max(abs(velocity[0]), abs(velocity[1]), abs(velocity[2])):
                break
    if not carries:
        force = air_in_space(velocity, heading, law, strengths)
    return position, velocity, force


@compiled
def march(  # type: ignore[no-untyped-def]
    position,
    velocity,
    heading,
    law,
    strengths,
    dt,
    treatment,
    limit,
    floor,
    wall,
    height,
    reach,
):
    """Step until z <= floor or x <= wall, at most `limit` steps; return the fields of `March`."""
    force = air_in_space(velocity, heading, law, strengths)
    closest, hit, count = math.hypot(position[0], position[2] - height), 0, 0
    before = outside = inside = after = (position, velocity)
    for count in range(1, limit + 1):
        before = after
        position, velocity, force = step_in_space(
            position, velocity, force, heading, law, strengths, dt, treatment
        )
        after = (position, velocity)
        if position[2] <= floor:
            return count, True, before, after, closest, hit, outside, inside
        distance = math.hypot(position[0], position[2] - height)
        closest = min(closest, distance)
        if hit == 0 and distance < reach:
            hit, outside, inside = count, before, after
        if position[0] <= wall:
            return count, True, before, after, closest, hit, outside, inside
    return count, False, before, after, closest, hit, outside, inside
