"""The paper's scheme: velocity Verlet in fixed steps, with the collision of its Appendix B.

One step of length Δt, from position r, velocity v and acceleration a (Frenkel and Smit,
"Understanding Molecular Simulation", 2nd ed., Sec. 4.3)::

    v½ = v + a Δt/2        r' = r + v½ Δt        v' = v½ + a' Δt/2

That defines the scheme for forces of the position. Here they depend on the velocity, and v' is not
known when a' is asked for: six `TREATMENTS` are the ways out. Everything else is as printed:

- Time is t = kΔt with k counted in whole steps, one rounding, never a sum of steps.
- The plate (Sec. III.A): between the steps on its two sides, on the line between them. So are the
  ground, if it is read as interpolated, and the time and velocity at either.
- The contact (Sec. III.C) is looked for at the steps only: the ball overlaps the bat in a step and
  is between its ends there. A contact between two steps goes unseen. The bat stands where it is
  swung from the release on, so that a step just before the plate can find it.
- Appendix B: the ball goes back to the step before; from there a straight line, at that step's
  velocity, leads to where the two touch, after Δt'; normal, bat velocity and restitution are
  taken there. Then half of the averaged force acts over two whole steps from the step gone back to.

What the paper leaves open about those two steps:

- Contact force and air act together in an ordinary step, the former constant, F̄/(2m). The air's
  part is computed afresh where the contact force begins and where it ends; between, it is carried
  or not as elsewhere.
- The push lies across the bat and not in the pitch's vertical plane: the velocity leaves that plane
  before the batted flight has one, so these two steps are taken in space. Neither flight's launch
  fixes a spin axis for them; the air acts in the vertical plane of the velocity it is asked for, as
  on a ball with backspin launched that way. This joins both flights without a jump.
- A ball that is down before the two steps are over has landed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar, cast, get_args

import numba
import numpy as np
from numpy.typing import NDArray

from longball.engines import contact
from longball.engines.engine import (
    Arrival,
    BatSection,
    CannotSolve,
    Launch,
    Stepped,
    Stop,
    Stops,
    Touch,
)
from longball.model.motion import FlightPlane, Forces, PlaneState, acceleration, into_plane
from longball.model.numbers import DOUBLES, Doubles, Vector
from longball.model.readings import AppendixBRoot, VerletForces, VerletLanding

State = PlaneState[float]
Point = NDArray[np.float64]


class Treatment(NamedTuple):
    """How the force at the end of a step is had, which depends on the velocity there.

    Attributes
    ----------
    ahead
        It is evaluated at v + ahead · a Δt.
    iterates
        Whether it is then evaluated at the v' that it leads to, until v' no longer changes.
    carries
        Whether the next step begins with it, instead of with the force at v'.
    """

    ahead: float
    iterates: bool
    carries: bool


# One force evaluation a step if carried, two if not, about eight if iterated. With forces that
# depend on the velocity alone, old_recomputed moves v as Euler's method does, predicted_recomputed
# as Heun's, implicit as the trapezoidal rule; half_step is Euler's method for v at the half steps.
TREATMENTS: dict[VerletForces, Treatment] = {
    "old_carried": Treatment(0.0, iterates=False, carries=True),
    "old_recomputed": Treatment(0.0, iterates=False, carries=False),
    "half_step": Treatment(0.5, iterates=False, carries=True),
    "predicted_carried": Treatment(1.0, iterates=False, carries=True),
    "predicted_recomputed": Treatment(1.0, iterates=False, carries=False),
    "implicit": Treatment(1.0, iterates=True, carries=False),
}

OPTIONS: dict[str, tuple[str, ...]] = {
    "forces": tuple(TREATMENTS),
    "landing": get_args(VerletLanding),
    "root": get_args(AppendixBRoot),
}


@dataclass(frozen=True)
class Verlet(Stepped[float]):
    """Flights and contacts in fixed steps.

    Attributes
    ----------
    dt
        s, the step; 0.05 in the paper.
    forces, landing, root
        Switches of the ledger: ``verlet_forces``, ``verlet_landing``, ``appendix_b_root``.
    """

    dt: float = 0.05
    forces: VerletForces = "old_carried"
    landing: VerletLanding = "interpolated"
    root: AppendixBRoot = "first"

    def __post_init__(self) -> None:
        if not 0 < self.dt < math.inf:
            raise ValueError(f"dt = {self.dt} is not a positive number of seconds")
        for name, options in OPTIONS.items():
            if (chosen := getattr(self, name)) not in options:
                raise ValueError(f"{name} {chosen!r} is not one of {', '.join(options)}")

    @property
    def numbers(self) -> Doubles:
        """Double precision."""
        return DOUBLES

    @property
    def description(self) -> str:
        """Name, step and readings."""
        return f"verlet dt={self.dt!r} forces={self.forces} landing={self.landing} root={self.root}"

    @property
    def flight_error(self) -> float:
        """0: the scheme decides by its numbers as they are, however far from the truth."""
        return 0.0

    def fly(self, start: State, forces: Forces[float], stops: Stops[float]) -> Arrival[float]:
        """Fly until the first stop; see `longball.engines.engine.Engine.fly`."""
        if stops.floor is not None and _rests_on(stops.floor, start, forces):
            return Arrival("floor", 0.0, start, start)
        count, found, *numbers = fly_steps(
            *start,
            *_strengths(forces),
            self.dt,
            *TREATMENTS[self.forces],
            _steps_within(stops.time_limit, self.dt),
            -math.inf if stops.floor is None else stops.floor,
            math.inf if stops.wall is None else stops.wall,
            stops.vertical,
        )
        self._require_finite(numbers, count)
        before, after = PlaneState(*numbers[:4]), PlaneState(*numbers[4:])
        if not found:
            return Arrival("time", count * self.dt, after, start)
        stop, time, state = self.stop_between(count, before, after, stops)
        if time > stops.time_limit:
            return Arrival("time", (count - 1) * self.dt, before, start)
        return Arrival(stop, time, state, start)

    def stop_between(
        self, count: int, before: State, after: State, stops: Stops[float]
    ) -> tuple[Stop, float, State]:
        """Return what is met first in step number `count`, and where."""
        met: list[tuple[float, Stop]] = []
        if stops.floor is not None and after.z <= stops.floor:
            met.append((_share(before.z, after.z, stops.floor), "floor"))
        if stops.wall is not None and after.s >= stops.wall:
            met.append((_share(before.s, after.s, stops.wall), "wall"))
        if stops.vertical and after.u <= 0.0:
            met.append((_share(before.u, after.u, 0.0), "vertical"))
        share, stop = min(met)
        if stop == "floor" and self.landing == "first_below":
            return stop, count * self.dt, after
        state = PlaneState(*(interpolate(a, b, share) for a, b in zip(before, after, strict=True)))
        match stop:
            case "floor":
                state = state._replace(z=cast(float, stops.floor))
            case "wall":
                state = state._replace(s=cast(float, stops.wall))
        return stop, (count - 1 + share) * self.dt, state

    def touch(
        self,
        pitch: Arrival[float],
        forces: Forces[float],
        bat: BatSection[float],
        stops: Stops[float],
    ) -> Touch[float]:
        """Find the first step in the bat; see `longball.engines.engine.Engine.touch`.

        The margin is that of the closest step. In doubt is a ball that is in the bat at a step,
        though Appendix B's straight line from the step before passes it by.
        """
        start = cast(State, pitch.record)
        if contact.distance(start, bat) < bat.reach:
            raise CannotSolve("the ball starts inside the bat; release it farther from the plate")
        steps, closest, hit, *numbers = approach_steps(
            *start,
            *_strengths(forces),
            self.dt,
            *TREATMENTS[self.forces],
            _steps_within(stops.time_limit, self.dt),
            -math.inf if stops.floor is None else stops.floor,
            bat.x,
            bat.cos,
            bat.height,
            bat.reach,
        )
        self._require_finite(numbers, steps)
        margin = bat.reach - closest
        if not hit:
            return Touch(margin, False)
        before, inside = PlaneState(*numbers[:4]), PlaneState(*numbers[4:])
        ahead = line_touch(before, bat, self.root)
        if ahead is None:
            return Touch(
                margin,
                None,
                doubt=f"Appendix B has no Δt': the ball is in the bat at step {hit} of "
                f"{self.dt!r} s, but the straight line from the step before does not meet it",
            )
        touching = before._replace(s=before.s + before.u * ahead, z=before.z + before.w * ahead)
        return Touch(
            margin,
            True,
            (hit - 1) * self.dt + ahead,
            touching,
            noticed=inside,
            leaving=self.root == "larger",
            record=(hit - 1, before, ahead),
        )

    def rebound(
        self,
        plane: FlightPlane[float],
        touch: Touch[float],
        kick: Vector[float],
        forces: Forces[float],
        stops: Stops[float],
    ) -> Launch[float]:
        """Push for two steps from the step before the contact (paper, Appendix B)."""
        count, back, ahead = cast(tuple[int, State, float], touch.record)
        air, dt = air_in_space(forces), self.dt
        treatment = TREATMENTS[self.forces]
        push = np.array(kick) / (2 * dt)  # F̄/(2m), m/s²
        floor = -math.inf if stops.floor is None else stops.floor
        position, velocity = np.array(plane.position(back)), np.array(plane.velocity(back))
        force = air(velocity)
        for done in (1, 2):
            old = position, velocity
            position, velocity, force = step(position, velocity, force, dt, treatment, air, push)
            self._require_finite([*position, *velocity], count + done)
            if position[2] <= floor:
                return self._down(old, (position, velocity), floor, count + done, done * dt - ahead)
        return Launch(_triple(position), _triple(velocity), (count + 2) * dt, 2 * dt - ahead)

    def _down(
        self,
        before: tuple[Point, Point],
        after: tuple[Point, Point],
        floor: float,
        count: int,
        delay: float,
    ) -> Launch[float]:
        """Return where a ball comes down during a step that the bat pushes in."""
        share = 1.0
        position, velocity = after
        if self.landing == "interpolated":
            share = _share(before[0][2], position[2], floor)
            position = interpolate(before[0], position, share)
            velocity = interpolate(before[1], velocity, share)
            position[2] = floor
        early = (1 - share) * self.dt
        return Launch(
            _triple(position), _triple(velocity), count * self.dt - early, delay - early, True
        )

    def _require_finite(self, numbers: list[float], count: int) -> None:
        if not all(map(math.isfinite, numbers)):
            raise CannotSolve(
                f"the numbers do not stay finite within {count} steps of {self.dt!r} s, or an "
                "implicit step does not settle: the step is too long for these forces"
            )


# --- the rules between the steps ------------------------------------------------------------------

Value = TypeVar("Value", float, Point)


def interpolate(before: Value, after: Value, share: float) -> Value:
    """Return the value at a share of the way from one step to the next."""
    return before + share * (after - before)


def line_touch(before: State, bat: BatSection[float], root: AppendixBRoot) -> float | None:
    """Return Δt', s, after which a ball on a straight line at constant velocity touches the bat.

    The roots of |d + v Δt'|² = reach² (paper, Appendix B). None if they are not real and positive.
    """
    a = (bat.cos * before.u) ** 2 + before.w**2
    b = contact.radial_velocity(before, bat)
    c = 2 * contact.depth(before, bat)
    discriminant = b * b - a * c
    if b >= 0.0 or discriminant < 0.0:
        return None
    # Added, not subtracted, so that neither root cancels.
    larger = -b + math.sqrt(discriminant)
    return larger / a if root == "larger" else c / larger


def _share(before: float, after: float, there: float) -> float:
    """Return the share of a step after which a quantity has reached a value, on a line."""
    # A ball that is set free below the ground, or launched on it, is there at once.
    return max(0.0, (there - before) / (after - before)) if after != before else 0.0


def _steps_within(time_limit: float, dt: float) -> int:
    """Return the number of the first step that is not before the limit."""
    return math.ceil(min(time_limit / dt, 2.0**53))


def _strengths(forces: Forces[float]) -> tuple[float, float, float]:
    return forces.drag or 0.0, forces.lift or 0.0, forces.gravity or 0.0


def _rests_on(floor: float, start: State, forces: Forces[float]) -> bool:
    """Tell whether a ball on the floor does not leave it."""
    rising = start.w > 0 or (
        start.w == 0 and acceleration(forces, DOUBLES)(start.u, start.w)[1] > 0
    )
    return start.z <= floor and not rising


def _triple(point: Point) -> Vector[float]:
    x, y, z = point.tolist()
    return x, y, z


# --- the step -------------------------------------------------------------------------------------

# An implicit step has settled when v' changes by no more than its rounding, and has failed when it
# has not after this many rounds: a ball's first change is a hundredth of the one before.
SETTLED = 2.0**-52
ROUNDS = 100


def step(
    position: Point,
    velocity: Point,
    force: Point,
    dt: float,
    treatment: Treatment,
    air: Callable[[Point], Point],
    push: Point,
) -> tuple[Point, Point, Point]:
    """Take one step of velocity Verlet, in any number of dimensions.

    Parameters
    ----------
    position, velocity
        m, m/s; arrays of the same shape.
    force
        m/s², that depends on the velocity: what the step begins with.
    dt
        s.
    treatment
        How the force at the step's end is had.
    air
        That force at a velocity, m/s² (gravity included).
    push
        m/s², constant over the step.

    Returns
    -------
    position, velocity, force
        At the end; the force is what the next step begins with. NaN where an implicit step does
        not settle.
    """
    half = velocity + 0.5 * dt * (force + push)
    position = position + dt * half
    force = air(velocity + treatment.ahead * dt * (force + push))
    velocity = half + 0.5 * dt * (force + push)
    if treatment.iterates:
        for _ in range(ROUNDS):
            old = velocity
            force = air(old)
            velocity = half + 0.5 * dt * (force + push)
            if np.max(np.abs(velocity - old)) <= SETTLED * np.max(np.abs(velocity)):
                break
        else:
            velocity = np.full_like(velocity, math.nan)
    return position, velocity, force if treatment.carries else air(velocity)


def air_in_space(forces: Forces[float]) -> Callable[[Point], Point]:
    """Return the acceleration in the vertical plane of the velocity that it is asked for."""
    accelerate = acceleration(forces, DOUBLES)

    def air(velocity: Point) -> Point:
        plane, state = into_plane((0.0, 0.0, 0.0), _triple(velocity), DOUBLES)
        du, dw = accelerate(state.u, state.w)
        return np.array(plane.velocity(state._replace(u=du, w=dw)))

    return air


# --- the step compiled ----------------------------------------------------------------------------
# The same operations as `step` and `motion.acceleration`, in the flight plane, on scalars, without
# a push: a hundred times faster. tests/engines/test_verlet.py holds the two together bit for bit.

compiled: Callable[[Any], Any] = numba.njit(cache=True)


@compiled
def air_compiled(u, w, drag, lift, gravity):  # type: ignore[no-untyped-def]
    """Return `motion.acceleration`; a strength of 0 is a force that the scene does not name."""
    if drag == 0.0 and lift == 0.0:
        return 0.0, -gravity
    speed = math.sqrt(u * u + w * w)
    if lift == 0.0:
        return -(drag * speed) * u, -(drag * speed) * w - gravity
    if drag == 0.0:
        return -(lift * speed) * w, lift * speed * u - gravity
    return -speed * (drag * u + lift * w), -speed * (drag * w - lift * u) - gravity


@compiled
def step_compiled(  # type: ignore[no-untyped-def]
    s, z, u, w, du, dw, drag, lift, gravity, dt, ahead, iterates, carries
):
    """Return `step`: s, z, u, w and the force that the next step begins with."""
    half_u, half_w = u + 0.5 * dt * du, w + 0.5 * dt * dw
    s, z = s + dt * half_u, z + dt * half_w
    du, dw = air_compiled(u + ahead * dt * du, w + ahead * dt * dw, drag, lift, gravity)
    u, w = half_u + 0.5 * dt * du, half_w + 0.5 * dt * dw
    if iterates:
        settled = False
        for _ in range(ROUNDS):
            old_u, old_w = u, w
            du, dw = air_compiled(u, w, drag, lift, gravity)
            u, w = half_u + 0.5 * dt * du, half_w + 0.5 * dt * dw
            if max(abs(u - old_u), abs(w - old_w)) <= SETTLED * max(abs(u), abs(w)):
                settled = True
                break
        if not settled:
            u = w = math.nan
    if not carries:
        du, dw = air_compiled(u, w, drag, lift, gravity)
    return s, z, u, w, du, dw


@compiled
def fly_steps(  # type: ignore[no-untyped-def]
    s, z, u, w, drag, lift, gravity, dt, ahead, iterates, carries, limit, floor, wall, vertical
):
    """Step until z <= floor, s >= wall or, if asked, u <= 0; at most `limit` steps.

    Returns the number of steps, whether a stop was met, and s, z, u, w before and after the last.
    """
    du, dw = air_compiled(u, w, drag, lift, gravity)
    a, b, c, d = s, z, u, w
    for count in range(1, limit + 1):
        a, b, c, d = s, z, u, w
        s, z, u, w, du, dw = step_compiled(
            s, z, u, w, du, dw, drag, lift, gravity, dt, ahead, iterates, carries
        )
        if z <= floor or s >= wall or (vertical and u <= 0.0):
            return count, True, a, b, c, d, s, z, u, w
        if not abs(u) + abs(w) < math.inf:
            return count, False, a, b, c, d, s, z, u, w
    return limit, False, a, b, c, d, s, z, u, w


@compiled
def approach_steps(  # type: ignore[no-untyped-def]
    s,
    z,
    u,
    w,
    drag,
    lift,
    gravity,
    dt,
    ahead,
    iterates,
    carries,
    limit,
    floor,
    x,
    cos,
    height,
    reach,
):
    """Step until the ball has passed the bat or is down; at most `limit` steps.

    Returns the number of steps, the least distance from the bat's axis at any of them, the number
    of the first one in the bat (0 if there is none), and s, z, u, w before and after that one.
    """
    du, dw = air_compiled(u, w, drag, lift, gravity)
    closest, hit = math.hypot(x + cos * s, z - height), 0
    a, b, c, d, e, f, g, h = s, z, u, w, s, z, u, w
    for count in range(1, limit + 1):
        before_s, before_z, before_u, before_w = s, z, u, w
        s, z, u, w, du, dw = step_compiled(
            s, z, u, w, du, dw, drag, lift, gravity, dt, ahead, iterates, carries
        )
        if z <= floor or not abs(u) + abs(w) < math.inf:
            return count, closest, hit, a, b, c, d, e, f, g, h
        distance = math.hypot(x + cos * s, z - height)
        closest = min(closest, distance)
        if hit == 0 and distance < reach:
            hit = count
            a, b, c, d = before_s, before_z, before_u, before_w
            e, f, g, h = s, z, u, w
        if x + cos * s <= -reach:
            return count, closest, hit, a, b, c, d, e, f, g, h
    return limit, closest, hit, a, b, c, d, e, f, g, h
