"""The distance of a pitch from the bat's axis.

The distance dips below R + r_b for a few milliseconds only, or for no time at all in a graze. So
contact is decided where the distance is least; the first touching lies before that.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from longball.model.frame import Frame
from longball.model.law import State
from longball.model.numbers import N, Numbers
from longball.model.scene import InvalidScene


@dataclass(frozen=True)
class BatSection:
    """The bat seen along its axis: a circle that a pitch touches or misses."""

    frame: Frame  # of the pitch
    height: N  # of the bat's axis, m
    reach: N  # R + r_b, m: the distance of the ball's centre from the axis when the two touch

    def distance(self, state: State, numbers: Numbers) -> N:
        """Return the distance of the ball's centre from the bat's axis, m."""
        across, above = self.frame.towards_x(state), state.z - self.height
        return numbers.sqrt(across * across + above * above)

    def offset(self, state: State, numbers: Numbers) -> tuple[N, N]:
        """Return the vector from the bat's axis to a ball that touches it: across and above, m.

        High above the ground, the difference of two heights has a large rounding error. There, if
        the error alone explains why the ball is not exactly at `reach`, the offset above follows
        from the offset across: ``above² = reach² - across²``.
        """
        across, above = self.frame.towards_x(state), state.z - self.height
        # as many half ulps of a height as in `margin_error`
        rounding = 8 * numbers.rounding * abs(self.height)
        off = abs(self.distance(state, numbers) - self.reach)
        high = (abs(self.height) > abs(self.frame.x)) & (abs(above) > abs(across))
        squared = (self.reach - across) * (self.reach + across)
        better = high & (off <= rounding) & (squared > 0)
        size = numbers.sqrt(numbers.where(better, squared, self.reach))
        return across, numbers.where(better, numbers.where(above > 0, size, -size), above)

    def depth(self, state: Any) -> Any:
        """Return ``d² - reach²``, m², of a state or of polynomials: negative inside the bat."""
        return self.beyond(self.reach, state)

    def beyond(self, distance: N, state: Any) -> Any:
        """Return ``d² - distance²``, m²."""
        across, above = self.frame.towards_x(state), state.z - self.height
        return across * across + above * above - distance * distance

    def approach(self, state: State) -> N:
        """Return d·v, m²/s, half the rate of `depth`: negative while the ball comes closer."""
        across, above = self.frame.towards_x(state), state.z - self.height
        return across * self.frame.velocity(state)[0] + above * state.w


def margin_error(bat: BatSection, plate_height: N, flight_error: float, numbers: Numbers) -> N:
    """Return a bound on the error of the margin at the closest approach, m.

    The height of the bat is that of the pitch at the plate, and the closest approach is searched
    on the series of that same state. So an error of the state at the plate moves ball and bat
    together, and an error of the time moves nothing. There remain

    - the error of the direction of flight at the plate, times the distance from there to the
      closest approach. Where the margin is in doubt, that distance is at most the bat's offset, and
      less than `reach` on a level pitch; doubled for the curvature of the path and of the circle;
    - the rounding of heights in that step, in z'_b + σ_b and in z - z_b, and that of distances
      from the release in x + cos s and in the frame's own place: a dozen half ulps in all;
      and of the distance itself: two half ulps of `reach`.
    """
    # The distance to the closest approach, and a height, each by the larger of two bounds.
    offset, bat_height, ball_height = (
        abs(value) for value in (bat.height - plate_height, bat.height, plate_height)
    )
    way = numbers.where(offset > bat.reach, offset, bat.reach)
    height = numbers.where(bat_height > ball_height, bat_height, ball_height)
    rounding = numbers.rounding * (8 * height + 4 * abs(bat.frame.x) + 2 * bat.reach)
    return 2 * way * flight_error + rounding


def inside_bat(distance: Any, reach: Any) -> InvalidScene:
    """Return the error that a pitch cannot be released there."""
    return InvalidScene(
        f"the ball starts inside the bat: {float(distance):.6g} m from its axis, "
        f"where the two touch at {float(reach):.6g} m; release it farther from the plate"
    )


TOUCHES = "whether the ball touches the bat"
STARTS_INSIDE = "whether the ball starts inside the bat or touches it"
TURNS_VERTICAL = (
    "the pitch turns vertical over the plate, where a lift that is always up has no direction; "
    "use lift_direction = fixed_spin_axis"
)
