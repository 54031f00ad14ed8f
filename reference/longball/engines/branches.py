"""Branches of a law with switches: which ones are valid in a state."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from longball.engines.arithmetic import Dual
from longball.engines.engine import CannotSolve
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers


def branches_at(
    law: Law,
    state: State,
    numbers: Numbers,
    known: Mapping[int, int] = MappingProxyType({}),
) -> list[int]:
    """Branch of each switch of a law in a state; on a threshold, the branch that is entered.

    Branches that are `known` stay.

    Raises `Undecided` if a ball leaves open on which side of a threshold a state is.
    """
    return _branches(law, state, numbers, known, range(len(law.bends)), 1, state.z * 0)


def arrived(law: Law, state: State, numbers: Numbers, error: N) -> Law:
    """Return the law on the branch by which the spin decays in a state that a flight has reached.

    On a threshold, that is the branch on which the flight came. Switches that do not matter to the
    spin are left on their first branches.

    Raises `Undecided` if the state is within an `error` of a threshold.
    """
    if not law.bends:
        return law
    none: dict[int, int] = {}
    return law.on(_branches(law, state, numbers, none, law.bends_of_spin, -1, error))


def require_law(law: Law, branches: Sequence[Any], time: Any) -> None:
    """Raise `CannotSolve` if a side force has no direction on these branches.

    The time, s since the launch, is for the message.
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
    law: Law,
    state: State,
    numbers: Numbers,
    known: Mapping[int, int],
    asked: Collection[int],
    sense: int,  # on a threshold: 1 for the branch that the flight enters, -1 for the one it leaves
    error: N,  # of the switching functions
) -> list[int]:
    branches = [known.get(which, 0) for which in range(len(law.bends))]
    # The wind's switch first: the others depend on the airspeed.
    for which, bend in sorted(enumerate(law.bends), key=lambda numbered: not numbered[1].blows):
        if which in known or which not in asked:
            continue
        form = law.on(branches)
        state = form.completed(state, numbers)
        for level in bend.levels:
            value = form.beyond(bend, level, numbers)
            there, off = value(state), error
            # Exactly on the threshold, the direction in which the flight passes it decides. It is
            # exact, too: a state that lies there was put there.
            if there == 0:
                moving = map(Dual, state, form.rates(numbers)(*state))
                there, off = sense * value(law.state(*moving)).rate, error * 0
            question = f"whether {bend.question}"
            # The thresholds rise, so that the branch is the number of those below the value.
            branches[which] += numbers.positive(there, off, question)
    return branches
