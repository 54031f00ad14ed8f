"""Balls in the air: a flight to a surface, through the vertical if need be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from longball.engines.chain.cases import Cases
from longball.engines.event import Event, level, plate, vertical
from longball.engines.path import Flight
from longball.model.frame import Frame
from longball.model.law import Law, State
from longball.model.numbers import N
from longball.model.scene import landing_height

# What a flight may end with, from its frame and start.
Surface = Callable[[Cases[N], Frame[N], State[N]], Event[N]]


def to_ground(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    """Return the landing."""
    return cases.ground(start)


def to_level(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    """Return the rise to the height of the ground."""
    return level(cases.numbers.exact(landing_height(cases.scene)), start, cases.numbers)


def to_plate(cases: Cases[N], frame: Frame[N], start: State[N]) -> Event[N]:
    """Return the crossing of the plane x = 0."""
    return plate(frame, start, cases.numbers)


def fly(
    cases: Cases[N],
    law: Law[N],
    frame: Frame[N],
    start: State[N],
    *surfaces: Surface[N],
    limit: N | None = None,
) -> Flight[N]:
    """Fly to a surface or the time limit, through the vertical if need be.

    With lift that is always up, a ball that reaches the vertical cannot leave it: on either side
    the horizontal part of the lift drives it back. It goes on without lift, straight up and down
    (the sliding solution in Filippov's sense; on the way down it is the symmetric one of two). From
    rest, or straight up or down, it is there already.
    """
    limit = cases.time_limit if limit is None else limit
    leg = law, law.state_of(start), limit, frame, surfaces
    flight: Flight[N] = cases.either(lift_is_always_up(cases, law), _fly_upwards, _fly, *leg)
    return flight


def lift_is_always_up(cases: Cases[N], law: Law[N]) -> Any:
    """Return the condition that there is a lift, and that it is always up."""
    if cases.scene.reading.lift_direction != "always_up" or "lift" not in law.strengths:
        return False
    if law.shape.spins:  # as a bat with friction makes the ball spin
        return False
    return cast(Any, law.strengths["lift"]) != 0


def _fly(
    cases: Cases[N],
    law: Law[N],
    start: State[N],
    limit: N,
    frame: Frame[N],
    surfaces: Sequence[Surface[N]],
    *others: Event[N],
) -> Flight[N]:
    events = [surface(cases, frame, start) for surface in surfaces]
    flight = cases.engine.fly(law, start, [*events, *others], limit)
    cases.flown(flight)
    return flight


def _fly_upwards(cases: Cases[N], law: Law[N], start: State[N], *leg: Any) -> Flight[N]:
    upright = cast(Any, start.u) == 0
    flight: Flight[N] = cases.either(upright, _fly_upright, _fly_to_vertical, law, start, *leg)
    return flight


def _fly_upright(cases: Cases[N], law: Law[N], *leg: Any) -> Flight[N]:
    return _fly(cases, law.without("lift"), *leg)


def _fly_to_vertical(cases: Cases[N], law: Law[N], start: State[N], *leg: Any) -> Flight[N]:
    turns = vertical(start, cases.numbers)

    def go_on(
        cases: Cases[N], flight: Flight[N], law: Law[N], start: State[N], limit: N, *rest: Any
    ) -> Flight[N]:
        upright = turns.place(flight.state)
        return flight.then(_fly_upright(cases, law, upright, limit - flight.time, *rest))

    def stay(cases: Cases[N], flight: Flight[N], *leg: Any) -> Flight[N]:
        return flight

    first = _fly(cases, law, start, *leg, turns)
    turned = first.stopped("vertical")
    flight: Flight[N] = cases.either(turned, go_on, stay, first, law, start, *leg)
    return flight
