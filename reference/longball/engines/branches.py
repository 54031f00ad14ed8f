"""The branches of a law that are valid in a state."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any, cast

from longball.engines.arithmetic import Dual
from longball.engines.engine import CannotSolve
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers


def branches_at(
    law: Law[N],
    state: State[N],
    numbers: Numbers[N],
    known: Mapping[int, int] = MappingProxyType({}),
) -> list[int]:
    """Return the branch of each term with several, in a state; on a level, that which it enters.

    The wind's first, on which airspeeds depend; forms that are `known` stay.

    Raises `Undecided` if a radius leaves open on which side of a level a state is.
    """
    return _branches(law, state, numbers, known, range(len(law.bends)), 1, state.z * 0)


def arrived(law: Law[N], state: State[N], numbers: Numbers[N], error: N) -> Law[N]:
    """Return the law in the form by which the spin goes in a state that a flight has come to.

    On a level it is that of the branch that the flight came by. Other branches are the first ones.

    Raises `Undecided` if the state is within an `error` of a level.
    """
    if not law.bends:
        return law
    none: dict[int, int] = {}
    return law.on(_branches(law, state, numbers, none, law.bends_of_spin, -1, error))


def require_law(law: Law[N], branches: Sequence[Any], time: Any) -> None:
    """Require that a law goes on in its branches, which it has at a time, s since the launch.

    Raises `CannotSolve` where a side force has no direction.
    """
    for bend, branch in zip(law.bends, branches, strict=True):
        if bend.ends and branch == 0:
            raise no_direction(time)


def no_direction(time: Any) -> CannotSolve:
    """Return the error of a side force that has no direction at a time, s since the launch."""
    return CannotSolve(
        "the side force has no direction where the airspeed is parallel to "
        f"air.side_coefficient.direction, as it is {float(time):.6g} s after the ball is set free; "
        "take another direction, or a time_limit before that"
    )


def _branches(
    law: Law[N],
    state: State[N],
    numbers: Numbers[N],
    known: Mapping[int, int],
    asked: Collection[int],
    sense: int,  # on a level: 1 to the branch that the flight enters, -1 to that which it leaves
    error: N,  # of what passes the levels
) -> list[int]:
    branches = [known.get(which, 0) for which in range(len(law.bends))]
    for which, bend in sorted(enumerate(law.bends), key=lambda numbered: not numbered[1].blows):
        if which in known or which not in asked:
            continue
        form = law.on(branches)
        state = form.completed(state, numbers)
        for level in bend.levels:
            value = form.beyond(bend, level, numbers)
            there, off = value(state), error
            if cast(Any, there) == 0:
                moving: Any = map(Dual, state, form.rates(numbers)(*state))
                there, off = sense * value(law.state(*moving)).rate, error * 0
            question = f"whether {bend.question}"
            branches[which] += numbers.positive(there, off, question)
    return branches
