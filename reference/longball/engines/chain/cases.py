"""What the chain is written over: a scene, or columns of scenes, and who computes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic

from longball.engines.branches import arrived
from longball.engines.engine import CannotSolve, Engine, Touch
from longball.engines.event import Event, ground
from longball.engines.path import Flight
from longball.model.frame import Frame
from longball.model.law import Law, State, law_of
from longball.model.numbers import N, Numbers, Undecided, Vector, absolute
from longball.model.result import Outcome
from longball.model.scene import landing_height

if TYPE_CHECKING:
    from longball.engines.chain.collision import Model
    from longball.engines.chain.landing import Batted


class Cases(ABC, Generic[N]):
    """Scenes that have come equally far: one, or a column of them.

    A condition is a bool for one scene, and an array of them for columns.
    """

    scene: Any  # has the blocks of a scene as attributes, with a number or a column of numbers each
    # engine, model: who computes, with which parts
    engine: Engine[N]
    model: Model

    @property
    @abstractmethod
    def empty(self) -> bool:
        """Whether no scene is left."""

    @abstractmethod
    def decide(self, x: N, error: N, question: str) -> tuple[Any, Any]:
        """Return the conditions that ``x > 0``, and that it is not; neither where in doubt.

        Raises `Undecided` for one scene, in doubt.
        """

    @abstractmethod
    def take(self, condition: Any, *values: Any) -> tuple[Any, ...]:
        """Return those for which a condition holds, and values of theirs."""

    @abstractmethod
    def either(
        self, condition: Any, yes: Callable[..., Any], no: Callable[..., Any], *values: Any
    ) -> Any:
        """Return ``yes(cases, *values)`` where a condition holds, else what `no` returns."""

    @abstractmethod
    def record(self, name: str, value: Any) -> None:
        """Write a quantity of the results, a number or a vector: ``plate.time``."""

    @abstractmethod
    def conclude(self, outcome: Outcome) -> None:
        """Write the outcome."""

    def refuse(self, reason: CannotSolve | Undecided) -> None:
        """Give no answer: to one scene, raise the reason."""

    @abstractmethod
    def touched(self, touch: Touch[N]) -> tuple[Any, Any]:
        """Return the conditions that ball and bat touch, and that they miss; see `decide`."""

    @abstractmethod
    def land_in_space(self, ball: Batted[N], outcome: Outcome) -> None:
        """Do what `land` does, of flights that a fence may end and that leave their plane."""

    def follow(self, frame: Frame[N], flight: Flight[N], begin: N) -> None:
        """Take note of a flight that begins at a time, s since the start of the scene."""

    def flown(self, flight: Flight[N]) -> None:
        """Take note of who flew a flight, or a part of one."""

    @cached_property  # asked for by every step of the chain
    def numbers(self) -> Numbers[N]:
        """The engine's number system."""
        return self.engine.numbers

    @property
    def time_limit(self) -> N:
        """The longest time of flight, s."""
        return self.numbers.exact(self.scene.time_limit)

    def vector(self, values: Sequence[float]) -> Vector[N]:
        """Return three numbers of a scene."""
        x, y, z = map(self.numbers.exact, values)
        return x, y, z

    def spin(self, values: Sequence[float] | None) -> Vector[N] | None:
        """Return the spin that a scene gives a ball, if it does."""
        return None if values is None else self.vector(values)

    def law(self, frame: Frame[N]) -> Law[N]:
        """Return the law of motion of a flight in a frame."""
        return law_of(self.scene, frame, self.numbers, self.model.forces)

    def spin_at(
        self, frame: Frame[N], law: Law[N], state: State[N], error: N | None = None
    ) -> Vector[N] | None:
        """Return the spin of the ball in a state that a flight has come to, rad/s.

        The state's `error` is relative to its size; left out, the state is exact.
        """
        if frame.spin is None:
            return None
        off = state.z * 0 if error is None else error * (1 + absolute(state.z))
        left = arrived(law, state, self.numbers, off).spin_left(state, self.numbers)
        return frame.spin[0] * left, frame.spin[1] * left, frame.spin[2] * left

    def ground(self, start: State[N]) -> Event[N]:
        """Return the landing of a flight from a state."""
        return ground(self.numbers.exact(landing_height(self.scene)), start, self.numbers)
