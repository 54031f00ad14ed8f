"""What an engine does for the chain of an at-bat: it flies a ball, and it meets a bat."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Literal, Protocol

from longball.model.motion import FlightPlane, Forces, PlaneState
from longball.model.numbers import N, Numbers, Vector
from longball.model.result import Result
from longball.model.scene import Scene

Stop = Literal["wall", "floor", "vertical", "time"]


class CannotSolve(ArithmeticError):
    """An engine's reason for giving no answer to a scene."""


@dataclass(frozen=True)
class Stops(Generic[N]):
    """What ends a flight, in its plane; the first one met does. None: not asked for.

    Attributes
    ----------
    time_limit
        s; the flight ends there at the latest.
    floor
        m; the height that z falls to, or touches.
    wall
        m; the distance that s rises to.
    vertical
        Whether u falling to zero ends the flight.
    """

    time_limit: N
    floor: N | None = None
    wall: N | None = None
    vertical: bool = False


@dataclass(frozen=True)
class Arrival(Generic[N]):
    """The end of a flight: what stopped it, when (s since its launch), in what state.

    `record` is the engine's own memory of the way there, which `Engine.touch` may use.
    """

    stop: Stop
    time: N
    state: PlaneState[N]
    record: object


@dataclass(frozen=True)
class BatSection(Generic[N]):
    """The bat seen along its axis, in the plane of the pitch: a circle to be touched.

    The ball's centre is ``reach = R + r_b`` from the axis when the two touch; its distance from
    the axis is that of ``(x + cos s, z - height)`` from zero. All in m.
    """

    x: N
    cos: N
    height: N
    reach: N


@dataclass(frozen=True)
class Touch(Generic[N]):
    """How a pitch meets the bat.

    Attributes
    ----------
    margin
        m; `reach` minus the closest distance of the undisturbed pitch.
    touched
        None if the margin is too small for the engine to tell.
    time, state
        First touching: s since release, and the state there; None if there is none.
    doubt
        What cannot be told, and why, if `touched` is None.
    noticed
        The state in which an engine that looks only now and then saw the overlap; the paper asks
        there whether the ball is between the bat's ends. None: at the touching itself.
    leaving
        Whether `state` is where the ball would leave the bat, instead of where it enters.
    record
        The engine's own memory of the contact, which `Stepped.rebound` may use.
    """

    margin: N
    touched: bool | None
    time: N | None = None
    state: PlaneState[N] | None = None
    doubt: str = ""
    noticed: PlaneState[N] | None = None
    leaving: bool = False
    record: object = None


@dataclass(frozen=True)
class Launch(Generic[N]):
    """A ball set free: where (m), how fast (m/s), and when (s since the start of the scene).

    Attributes
    ----------
    delay
        s, from the contact to the time at which the ball is free.
    landed
        Whether the ball has come down before it was free; then this is the landing.
    """

    position: Vector[N]
    velocity: Vector[N]
    time: N
    delay: N
    landed: bool = False


class Engine(Protocol[N]):
    """A way to compute."""

    @property
    def description(self) -> str:
        """Name and settings, as the result states them."""

    @property
    def numbers(self) -> Numbers[N]:
        """The number system."""

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size.

        0 where the number carries its own error.
        """

    def fly(self, start: PlaneState[N], forces: Forces[N], stops: Stops[N]) -> Arrival[N]:
        """Fly until the first stop."""

    def touch(
        self, pitch: Arrival[N], forces: Forces[N], bat: BatSection[N], stops: Stops[N]
    ) -> Touch[N]:
        """Find how the pitch that ended in an arrival at the plate meets the bat.

        The search begins with the release and ends where the ball has passed the bat
        (``x + cos s = -reach``), or with a stop.
        """


class Stepped(ABC, Generic[N]):
    """What an engine offers besides if it advances in fixed steps, as the paper does.

    Its bat pushes for some of the steps instead of striking at once.
    """

    @abstractmethod
    def rebound(
        self,
        plane: FlightPlane[N],
        touch: Touch[N],
        kick: Vector[N],
        forces: Forces[N],
        stops: Stops[N],
    ) -> Launch[N]:
        """Return the ball as the bat sets it free.

        Parameters
        ----------
        plane
            Of the pitch.
        touch
            From `Engine.touch`, with a state.
        kick
            m/s, the change of velocity that the whole impulse makes.
        forces, stops
            Of the batted flight.
        """


class ManyAtOnce(ABC):
    """What an engine offers besides if many scenes take it less time together than one by one."""

    @abstractmethod
    def solve_all(self, scenes: Sequence[Scene]) -> list[Result]:
        """Return what `longball.engines.at_bat.solve` returns for each scene, in order."""
