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


def cannot_touch(
    state: PlaneState[float], duration: float, bat: BatSection[float], gravity: float
) -> bool:
    """Tell whether the ball is too far off to touch within `duration` seconds.

    Drag only brakes and lift only turns, so the speed grows by at most g a second.
    """
    fastest = math.hypot(state.u, state.w) + gravity * duration
    return distance(state, bat) - bat.reach > fastest * duration


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


def margin_error(bat: BatSection[float], release_height: float, flight_error: float) -> float:
    """Return a bound on the error of the margin at the closest approach, m.

    An error of the pitch's height moves ball and bat together, since the bat is put at the height
    where the pitch crosses the plate, and an error of its time moves nothing. What is left is

    - the direction of flight times the way from the plate to the closest approach, which is
      at most `reach`: reach · flight_error, doubled for the two ends;
    - the rounding of heights of up to the release's, in the steps that lead from the last step
      before the plate to the plate and to the approach, in z'_b + σ_b and in z - z_b: a dozen
      half ulps; and of the distance itself: two half ulps of `reach`.
    """
    height = max(abs(bat.height), abs(release_height))
    rounding = DOUBLES.rounding * (12 * height + 2 * bat.reach)
    return 2 * bat.reach * flight_error + rounding


def doubt(margin: float, error: float) -> str:
    """Say that a graze cannot be told from a miss."""
    return (
        "whether the ball touches the bat cannot be decided in double precision: "
        f"the margin {margin:.3g} m lies within its error {error:.3g} m"
    )
