"""Flights to a surface, through the vertical if necessary, and the spin at their end."""

from __future__ import annotations

from collections.abc import Callable

from longball.engines.branches import arrived
from longball.engines.chain.run import Mask, Run
from longball.engines.event import Event, vertical
from longball.engines.path import Flight
from longball.model.frame import Frame
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers, Vector


def fly(
    run: Run,
    law: Law,
    start: State,
    surfaces: Callable[[State], list[Event]],
    limit: N,
    rows: Mask,
) -> Flight:
    """Fly to a surface or the time limit, s, through the vertical if necessary.

    With lift that is always up, a ball that reaches the vertical cannot leave it: on either side
    the horizontal part of the lift drives it back. It goes on without lift, straight up and down
    (the sliding solution in Filippov's sense; on the way down it is the symmetric one of two). From
    rest, or straight up or down, it is there already.

    Parameters
    ----------
    surfaces
        The events that may end a flight from a state.
    """
    start = law.state_of(start)
    if not lift_is_always_up(run, law):
        return run.fly(law, start, surfaces(start), limit, rows)

    # First to the vertical, with lift; then on from there, without.
    turn, upright = vertical(start, run.numbers), start.u == 0
    leaning = rows & (upright ^ True)
    first = run.fly(law, start, [*surfaces(start), turn], limit, leaning)
    upright = rows & (upright | first.stopped("vertical"))
    if not run.some(upright):
        return first
    there = turn.place(first.state)
    second = run.fly(law.without("lift"), there, surfaces(there), limit - first.time, upright)
    return first.then(second) if run.some(leaning) else second


def lift_is_always_up(run: Run, law: Law) -> bool:
    """Return True if lift points up whatever the ball's spin."""
    if law.shape.spins:  # then lift follows the spin: of the scene, or from a bat with friction
        return False
    return run.scene.reading.lift_direction == "always_up" and "lift" in law.strengths


def spin_at(
    frame: Frame,
    law: Law,
    state: State,
    numbers: Numbers,
    error: N | None = None,
) -> Vector | None:
    """Return the spin of the ball in a state that a flight has come to, rad/s.

    The state's `error` is relative to its size; left out, the state is exact.
    """
    if frame.spin is None:
        return None
    # Which branch of the spin's decay holds depends on the state: its error may leave that open.
    off = state.z * 0 if error is None else error * (1 + abs(state.z))
    left = arrived(law, state, numbers, off).spin_left(state, numbers)
    return frame.spin[0] * left, frame.spin[1] * left, frame.spin[2] * left
