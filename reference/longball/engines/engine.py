"""The engine protocol: fly a ball, and meet a bat."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from longball.engines.event import BatSection, Event, Events
from longball.engines.path import Flight
from longball.model.frame import Frame
from longball.model.law import Law, State
from longball.model.numbers import N, Numbers, Vector
from longball.model.result import ErrorCode, Result
from longball.model.scene import Scene


class CannotSolve(ArithmeticError):
    """An engine's reason for giving no answer to a scene."""

    code: ErrorCode = "unsupported"


class TooLong(CannotSolve):
    """A flight takes more steps than the engine is ready to take."""

    code = "too_long"


class OutOfRange(CannotSolve):
    """Raised if numbers or forces exceed the range or resolution of the engine."""

    code = "out_of_range"


@dataclass(frozen=True)
class Touch:
    """Contact of a pitch with the bat, or the miss."""

    margin: N  # m; `reach` minus the closest distance of the undisturbed pitch
    # None if the margin is too small for a decision; in columns 1, 0, and -1 for None
    touched: bool | None
    # Time, s since release, and state of the first contact; None without one.
    time: N | None = None
    state: State | None = None
    doubt: str = ""  # the undecided question, and the reason, if `touched` is None
    # True if `state` is the point where the ball would leave the bat, not where it enters.
    leaving: bool = field(default=False, kw_only=True)
    # The state in which the ball's place along the bat is compared with its ends; None: `state`
    inside: State | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Launch:
    """Launch of a batted ball: position, m, velocity, m/s, and time, s since the scene began."""

    position: Vector
    velocity: Vector
    time: N
    delay: N  # s, from the contact to the launch
    landed: bool = False  # the ball has landed before it was free: this is the landing
    spin: Vector | None = None  # rad/s; None if the scene gives none
    error: N | None = None  # of the velocity, m/s; None if it is exact, or carries its own


class Engine(Protocol):
    """A numerical method."""

    @property
    def description(self) -> str:
        """Name and settings, as the result states them."""

    @property
    def numbers(self) -> Numbers:
        """The number system."""

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size.

        0 where the number carries its own error.
        """

    def fly(self, law: Law, start: State, events: Events, limit: N) -> Flight:
        """Fly until the first of several events, or to the time limit, s since the launch.

        Raises `CannotSolve` or `Undecided`.
        """

    def touch(self, pitch: Flight, law: Law, bat: BatSection, events: Events, limit: N) -> Touch:
        """Find how a pitch that has reached the plate meets the bat.

        The search begins with the release and ends where the ball has passed the bat, at
        ``x = -reach``, or with one of the events, or at the time limit.
        """


class Stepped(ABC):
    """Protocol of engines that advance in fixed steps, as the paper does.

    The contact force acts over some of the steps instead of at once (paper, Appendix B).
    """

    @abstractmethod
    def rebound(
        self,
        frame: Frame,  # of the pitch
        touch: Any,  # from `Engine.touch`, with a state
        delta_v: Vector,  # m/s, the change of velocity that the whole impulse makes
        law_in: Callable[[Frame], Law],  # from the frame of a flight to the law there
        ground: Event,  # of the batted flight
    ) -> Launch:
        """Return the ball as the bat sets it free."""


class ManyAtOnce(ABC):
    """Protocol of engines that solve many scenes faster together than one by one."""

    alone: Any  # the engine that solves what this one leaves, and gives the path of a ball

    def solve_all(self, scenes: Sequence[Scene], threads: int = 1) -> list[Result]:
        """Solve each scene as `longball.engines.chain.solve` does, in order."""
        return [Result.model_validate(data) for data in self.solve_as_data(scenes, threads)]

    @abstractmethod
    def solve_as_data(self, scenes: Sequence[Scene], threads: int = 1) -> list[dict[str, Any]]:
        """Return the same as plain data; see `longball.model.result.Result.data`."""
