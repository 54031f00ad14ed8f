"""The run of a chain over one scene, with masks that let it run over columns of scenes as well.

A mask says for which scenes something holds: a bool for one scene, an array of flags for columns.
A stage of the chain runs on the rows of a mask, and only if there are some. Numbers in other rows
have no meaning, and are never recorded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from longball.engines.contact import BatSection
from longball.engines.engine import CannotSolve, Launch, Touch
from longball.engines.event import Event, Events, ground
from longball.engines.path import Flight, Leg, Path
from longball.model.frame import Frame
from longball.model.law import Law, State, law_of
from longball.model.numbers import N, Undecided, Vector
from longball.model.result import Outcome
from longball.model.scene import landing_height

if TYPE_CHECKING:
    from longball.engines.chain.collision import Model

Mask = Any  # bool or array of flags


@dataclass
class Run:
    """A scene on its way through a chain; `longball.engines.batch.columns.Columns` has many.

    The methods that take `rows` are all that a chain needs to know about masks.

    Attributes
    ----------
    scene
        Has the blocks of a scene as attributes, in columns with a number or an array each.
    engine, model
        The engine that computes; the parts of the chain.
    answer
        What is recorded, by name, with the outcome.
    legs
        The flights of the scene, in order.
    engines
        Descriptions of the engines that flew the ball, in order.
    """

    scene: Any
    engine: Any
    model: Model
    answer: dict[str, Any] = field(default_factory=dict)
    legs: list[Leg] = field(default_factory=list)
    engines: list[str] = field(default_factory=list)

    # --- masks -----------------------------------------------------------------------------------

    @property
    def everything(self) -> Mask:
        """The mask of all scenes."""
        return True

    def some(self, rows: Mask) -> bool:
        """Return True if a mask has any rows."""
        return bool(rows)

    def decide(self, x: N, error: N, question: str, rows: Mask) -> tuple[Mask, Mask]:
        """Return two masks: of the rows in which ``x > 0``, and of those in which it is not.

        A row of columns that is in doubt is in neither.

        Raises `Undecided` for one scene, in doubt.
        """
        positive = rows and self.numbers.positive(x, error, question)
        return positive, rows and not positive

    def touched(self, touch: Touch, rows: Mask) -> tuple[Mask, Mask]:
        """Return the rows in which ball and bat touch, and in which they miss; see `decide`."""
        if touch.touched is None:
            raise Undecided(touch.doubt)
        return touch.touched, not touch.touched

    # --- flights ---------------------------------------------------------------------------------

    def fly(self, law: Law, start: State, events: Events, limit: N, rows: Mask) -> Flight:
        """Fly until the first of several events; see `longball.engines.engine.Engine.fly`.

        In other rows the flight stays at its start, and nothing stops it.
        """
        if not rows:
            return Flight(Path(()), "", self.numbers.exact(0.0), start)
        flight: Flight = self.engine.fly(law, start, events, limit)
        self.engines.append(flight.flown_by or self.engine.description)
        return flight

    def touch(self, pitch: Any, law: Law, bat: BatSection, events: Events, rows: Mask) -> Touch:
        """Find how pitches meet the bat; see `longball.engines.engine.Engine.touch`."""
        touch: Touch = self.engine.touch(pitch, law, bat, events, self.time_limit)
        if touch.decided_by:
            self.engines.append(touch.decided_by)
        return touch

    def land_one_by_one(self, launch: Launch, outcome: Outcome, rows: Mask) -> bool:
        """Land the balls of columns one after the other; return False for one scene, as it is."""
        return False

    # --- answers ---------------------------------------------------------------------------------

    def record(self, name: str, value: Any, rows: Mask) -> None:
        """Record a quantity of the results, a number or a vector: ``plate.time``."""
        if rows:
            self.answer[name] = value

    def conclude(self, outcome: Outcome, rows: Mask) -> None:
        """Record the outcome; nothing that a chain does afterwards concerns these rows."""
        self.record("outcome", outcome, rows)

    def refuse(self, reason: CannotSolve | Undecided, rows: Mask) -> None:
        """Mark rows as not solved; for a single scene, raise the error."""
        if rows:
            raise reason

    def follow(self, frame: Frame, flight: Flight, begin: N, rows: Mask) -> None:
        """Append a flight to the trajectory; it begins s after the start of the scene."""
        if rows:
            self.legs.append(Leg(begin, frame, flight))

    # --- the scene -------------------------------------------------------------------------------

    @property
    def numbers(self) -> Any:
        """The number system; see `longball.model.numbers.Numbers`."""
        return self.engine.numbers

    @property
    def time_limit(self) -> N:
        """The longest time of flight, s."""
        return self.numbers.exact(self.scene.time_limit)

    def vector(self, values: Sequence[float]) -> Vector:
        """Return three numbers of the scene."""
        x, y, z = map(self.numbers.exact, values)
        return x, y, z

    def spin(self, values: Sequence[float] | None) -> Vector | None:
        """Return the spin that the scene gives the ball, rad/s; None if it gives none."""
        return None if values is None else self.vector(values)

    def law(self, frame: Frame) -> Law:
        """Return the law of motion of a flight in a frame."""
        return law_of(self.scene, frame, self.numbers, self.model.forces)

    def ground(self, start: State) -> Event:
        """Return the landing of a flight from a state."""
        return ground(landing_height(self.scene, self.numbers.exact), start, self.numbers)
