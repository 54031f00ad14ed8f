"""The frame of a flight: position of the launch, and the horizontal heading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from longball.model.law import PlaneState, in_plane
from longball.model.numbers import N, Numbers, Vector


@dataclass(frozen=True)
class Frame:
    """Position of a launch, m, horizontal unit vector of its heading, and its spin.

    `spin` is the vector at the launch, rad/s, in space; None if the scene gives none.
    """

    x: N
    y: N
    cos: N
    sin: N
    spin: Vector | None = None

    def turned(self, vector: Vector) -> Vector:
        """Return the components of a vector in space along s, y and z of the frame."""
        x, y, z = vector
        # A rotation about z by minus the heading; its inverse is in `position` and `velocity`.
        return x * self.cos + y * self.sin, y * self.cos - x * self.sin, z

    def components(self, vector: Sequence[float], numbers: Numbers) -> Vector:
        """Return the components of a vector of the scene along s, y and z of the frame."""
        x, y, z = map(numbers.exact, vector)
        return self.turned((x, y, z))

    def position(self, state: Any) -> Vector:
        """Return the position in space, m."""
        if in_plane(state):
            return self.x + self.cos * state.s, self.y + self.sin * state.s, state.z
        return (
            self.x + self.cos * state.s - self.sin * state.y,
            self.y + self.sin * state.s + self.cos * state.y,
            state.z,
        )

    def velocity(self, state: Any) -> Vector:
        """Return the velocity in space, m/s."""
        if in_plane(state):
            return self.cos * state.u, self.sin * state.u, state.w
        return (
            self.cos * state.u - self.sin * state.v,
            self.sin * state.u + self.cos * state.v,
            state.w,
        )

    def towards_x(self, state: Any) -> Any:
        """Return x, m, of a state, or of a state of polynomials."""
        x = self.x + self.cos * state.s
        return x if in_plane(state) else x - self.sin * state.y


# The square of a speed below TINY, m/s, may underflow. Such speeds are multiplied by LARGER first,
# a power of 2, which is exact.
TINY, LARGER = 2.0**-500, 2.0**600  # a free choice


def launch_frame(
    position: Vector, velocity: Vector, numbers: Numbers, spin: Vector | None = None
) -> tuple[Frame, PlaneState]:
    """Return the frame of a flight, and its launch in that frame.

    A launch straight up or down has the heading +x, towards the pitcher. With it, the landing
    distance of launches above the plate is continuous at the vertical.
    """
    x, y, z = position
    vx, vy, vz = velocity
    nothing = numbers.exact(0.0)
    # Exactly zero only if both components are, and without a root.
    size = abs(vx) + abs(vy)
    question = "whether the launch is vertical"
    heads = numbers.positive(size, nothing, question)
    tiny = numbers.positive(numbers.exact(TINY) - size, nothing, question)
    scale = numbers.where(tiny, numbers.exact(LARGER), numbers.exact(1.0))
    u, v = scale * vx, scale * vy
    length = numbers.sqrt(u * u + v * v)
    # Columns evaluate both branches: divide by 1 where the length is 0 and the quotient is not
    # used.
    divisor = numbers.where(heads, length, numbers.exact(1.0))
    cos = numbers.where(heads, u / divisor, numbers.exact(1.0))
    frame = Frame(x, y, cos, v / divisor, spin)
    # By definition of the heading, the launch has no sideways velocity.
    return frame, PlaneState(nothing, z, length / scale, vz)
