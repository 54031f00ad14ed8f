"""Meeting the bat: which functions of the ball's state tell whether, when and by how much.

The distance to the bat's axis dips below R + r_b for a few milliseconds only, or for no time at
all in a graze, so a sign change of "distance - (R + r_b)" between the steps of a solver misses
most contacts. The radial velocity d·v changes sign once, at the closest approach, however large
the steps: contact is decided by the distance there, and the first touching lies before it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from longball.engines.engine import BatSection
from longball.model.motion import Forces, PlaneState
from longball.model.numbers import DOUBLES, N

Acceleration = Callable[[float, float], tuple[float, float]]


def distance(state: PlaneState[float], bat: BatSection[float]) -> float:
    """Return the distance of the ball's centre from the bat's axis, m."""
    return math.hypot(bat.x + bat.cos * state.s, state.z - bat.height)


def depth(state: PlaneState[float], bat: BatSection[float]) -> float:
    """Return ``(d² - reach²)/2``, m²: negative where the ball overlaps the bat."""
    d = distance(state, bat)
    return 0.5 * (d - bat.reach) * (d + bat.reach)


def radial_velocity(state: PlaneState[N], bat: BatSection[N]) -> N:
    """Return d·v, m²/s, the derivative of `depth`: negative while the ball comes closer."""
    return (bat.x + bat.cos * state.s) * (bat.cos * state.u) + (state.z - bat.height) * state.w


def radial_acceleration(
    state: PlaneState[N], bat: BatSection[N], acceleration: Callable[[N, N], tuple[N, N]]
) -> N:
    """Return the derivative of d·v, m²/s²."""
    du, dw = acceleration(state.u, state.w)
    across = bat.cos * state.u
    return (
        across * across
        + state.w * state.w
        + (bat.x + bat.cos * state.s) * (bat.cos * du)
        + (state.z - bat.height) * dw
    )


def stays_beyond(
    within: float,
    state: PlaneState[float],
    duration: float,
    bat: BatSection[float],
    gravity: float,
) -> bool:
    """Tell whether the ball stays beyond a distance (m) of the axis for `duration` seconds.

    Drag only brakes and lift only turns, so the speed grows by at most g a second.
    """
    fastest = math.hypot(state.u, state.w) + gravity * duration
    return distance(state, bat) - within > fastest * duration


def longest_step(state: PlaneState[float], bat: BatSection[float], forces: Forces[float]) -> float:
    """Return the longest step, s, in which the distance cannot turn twice unnoticed.

    The distance has a single turn, a minimum, as long as (d·v)' = V² + d·a > 0. A pitch is so
    fast, V² > 2 |d| |a|, that this holds all the way to the bat, and steps are not limited. A ball
    that hovers near the bat is followed in steps of a fourth of `reach`.
    """
    k = math.hypot(forces.drag or 0.0, forces.lift or 0.0)
    g = forces.gravity or 0.0
    speed = math.hypot(state.u, state.w)
    d = distance(state, bat)
    if speed * speed > 2 * d * (g + k * speed * speed):
        return math.inf
    fastest = math.sqrt(speed * speed + 2 * g * (d + bat.reach))
    return bat.reach / (4 * fastest)


def backward_growth(state: PlaneState[float], duration: float, forces: Forces[float]) -> float:
    """Return a bound on how much an error grows over a way back to a state.

    Drag makes flights converge, so that taken backwards they part: the acceleration's derivative
    in the velocity is at most 2 k V, of a speed that was V at the way's far end and grew by at
    most g a second.
    """
    k = math.hypot(forces.drag or 0.0, forces.lift or 0.0)
    fastest = math.hypot(state.u, state.w) + (forces.gravity or 0.0) * duration
    return math.exp(min(2 * k * fastest * duration, 700.0)) if duration > 0 else 1.0


def margin_error(bat: BatSection[float], plate: PlaneState[float], flight_error: float) -> float:
    """Return a bound on the error of the margin at the closest approach, m.

    The bat is put at the height where the pitch crosses the plate, and the closest approach is
    found by a short step from there. So an error of the state at the plate moves ball and bat
    together, and an error of the time moves nothing. What is left is

    - the direction of flight at the plate, times the way from there to the closest approach.
      Where the margin is in doubt that way is at most the bat's offset, and less than `reach` on a
      level pitch; doubled for the curvature of either;
    - the rounding of heights in that step, in z'_b + σ_b and in z - z_b, and that of distances
      from the release in x + cos s and in the plane's own place: a dozen half ulps in all;
      and of the distance itself: two half ulps of `reach`.
    """
    way = max(bat.reach, abs(bat.height - plate.z))
    height = max(abs(bat.height), abs(plate.z))
    rounding = DOUBLES.rounding * (8 * height + 4 * abs(bat.x) + 2 * bat.reach)
    return 2 * way * flight_error + rounding


def doubt(margin: float, error: float) -> str:
    """Say that a graze cannot be told from a miss."""
    return (
        "whether the ball touches the bat cannot be decided in double precision: "
        f"the margin {margin:.3g} m lies within its error {error:.3g} m"
    )
