"""Equations of motion of a flight, in the vertical plane of its launch.

Drag, lift and weight all lie in the vertical plane that contains the launch velocity, so a flight
is planar: `s` is the horizontal distance flown, `z` the height, ``u = ds/dt``, ``w = dz/dt``.
Source: paper, Sec. III.B.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, NamedTuple, cast

from longball.model.numbers import N, Numbers, Vector
from longball.model.scene import Air, Ball


class PlaneState(NamedTuple, Generic[N]):
    """Position and velocity in the plane of a flight: m, m, m/s, m/s."""

    s: N
    z: N
    u: N
    w: N


@dataclass(frozen=True)
class Forces(Generic[N]):
    """What accelerates the ball; None where the scene names no such force.

    Attributes
    ----------
    drag, lift
        ``k = ρ C A / (2 m)``, 1/m.
    gravity
        m/s², downwards.
    always_up
        Reading of the lift's direction: it stays on the upper side of the path, so that it
        vanishes from a ball that flies vertically (see `longball.engines.at_bat`).
    """

    drag: N | None
    lift: N | None
    gravity: N | None
    always_up: bool


def forces(
    ball: Ball, air: Air | None, gravity: float, always_up: bool, numbers: Numbers[N]
) -> Forces[N]:
    """Return the forces that a scene names, from the paper's definitions of drag and lift."""

    def per_metre(coefficient: float) -> N | None:
        if air is None or air.density * coefficient == 0.0:
            return None
        density, radius = numbers.exact(air.density), numbers.exact(ball.radius)
        area = numbers.pi * radius * radius
        return density * numbers.exact(coefficient) * area / (2 * numbers.exact(ball.mass))

    return Forces(
        drag=per_metre(air.drag_coefficient) if air else None,
        lift=per_metre(air.lift_coefficient) if air else None,
        gravity=numbers.exact(gravity) if gravity else None,
        always_up=always_up,
    )


def acceleration(forces: Forces[N], numbers: Numbers[N]) -> Callable[[N, N], tuple[N, N]]:
    """Return the function ``(u, w) -> (u', w')`` with only the terms that `forces` names.

    ``u' = -V (k_D u + k_L w)``, ``w' = -V (k_D w - k_L u) - g``, ``V = √(u² + w²)``:
    lift turns the velocity upwards from the horizontal, as backspin does.
    """
    drag, lift, sqrt = forces.drag, forces.lift, numbers.sqrt
    # Subtracting a zero costs less than asking whether there is one.
    gravity = numbers.exact(0.0) if forces.gravity is None else forces.gravity
    nothing = numbers.exact(0.0)

    def vacuum(u: N, w: N) -> tuple[N, N]:
        return nothing, -gravity

    def drag_only(u: N, w: N) -> tuple[N, N]:
        k_v = drag * sqrt(u * u + w * w)
        return -k_v * u, -k_v * w - gravity

    def lift_only(u: N, w: N) -> tuple[N, N]:
        k_v = lift * sqrt(u * u + w * w)
        return -k_v * w, k_v * u - gravity

    def drag_and_lift(u: N, w: N) -> tuple[N, N]:
        speed = sqrt(u * u + w * w)
        return (
            -speed * (drag * u + lift * w),
            -speed * (drag * w - lift * u) - gravity,
        )

    if drag is None:
        return vacuum if lift is None else lift_only
    return drag_only if lift is None else drag_and_lift


@dataclass(frozen=True)
class FlightPlane(Generic[N]):
    """The vertical plane of a flight: where it starts, m, and the unit vector it heads for."""

    x: N
    y: N
    cos: N
    sin: N

    def position(self, state: PlaneState[N]) -> Vector[N]:
        """Return the position in space, m."""
        return self.x + self.cos * state.s, self.y + self.sin * state.s, state.z

    def velocity(self, state: PlaneState[N]) -> Vector[N]:
        """Return the velocity in space, m/s."""
        return self.cos * state.u, self.sin * state.u, state.w


# The square of a speed below TINY, in m/s, may vanish from a double. That of LARGER times any such
# double does not, and a power of 2 changes no digit.
TINY, LARGER = 2.0**-500, 2.0**600


def into_plane(
    position: Vector[N], velocity: Vector[N], numbers: Numbers[N]
) -> tuple[FlightPlane[N], PlaneState[N]]:
    """Return the plane of a flight, and its launch in that plane.

    A launch straight up or down has no heading of its own and takes that of +x, toward the
    pitcher: with it the landing distance from above the plate is continuous across the vertical.

    Raises
    ------
    Undecided
        If the numbers cannot tell whether the launch is vertical.
    """
    x, y, z = position
    vx, vy, vz = velocity
    nothing = numbers.exact(0.0)
    size = cast(N, abs(vx) + abs(vy))  # mypy knows abs() of a Real only
    if not numbers.positive(size, nothing, "whether the launch is vertical"):
        return FlightPlane(x, y, numbers.exact(1.0), nothing), PlaneState(nothing, z, nothing, vz)
    tiny = numbers.positive(numbers.exact(TINY) - size, nothing, "whether the launch is vertical")
    scale = numbers.exact(LARGER if tiny else 1.0)
    u, v = scale * vx, scale * vy
    length = numbers.sqrt(u * u + v * v)
    return FlightPlane(x, y, u / length, v / length), PlaneState(nothing, z, length / scale, vz)
