"""Solutions of scenes for Python: their quantities, their paths, and the form that is shown."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from longball import engines
from longball.engines import chain
from longball.engines.chain import BLOCKS
from longball.engines.engine import CannotSolve, Engine, OutOfRange, TooLong
from longball.engines.path import Trajectory
from longball.extras import naming_extras
from longball.model.arrays import Array
from longball.model.explain import parts_of
from longball.model.names import did_you_mean, one_of
from longball.model.numbers import Undecided
from longball.model.plain import column_of
from longball.model.quantities import at
from longball.model.result import (
    Apex,
    Bounded,
    Certified,
    Contact,
    ErrorCode,
    Fence,
    Impact,
    Landing,
    Outcome,
    Plate,
    Result,
    signed,
)
from longball.model.scene import InvalidScene, Scene

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from longball.engines.tangent import Derivatives


class State(NamedTuple):
    """Position and velocity of the ball at a time.

    Attributes
    ----------
    time
        s since the start of the scene: a float, or an array of shape (…).
    position
        m; array of shape (…, 3).
    velocity
        m/s; array of shape (…, 3).
    """

    time: Any
    position: Array
    velocity: Array


class Path:
    """The trajectory of the ball from the start of a scene to its end.

    The velocity jumps at the contact; at that time the one after the impulse is returned.

    Attributes
    ----------
    start, end
        s since the start of the scene: a path begins at 0.
    """

    def __init__(self, trajectory: Trajectory, engine: Engine) -> None:
        self._trajectory, self._numbers = trajectory, engine.numbers
        self.start = self._double(trajectory.legs[0].begin)
        self.end = self._double(trajectory.end)

    def __repr__(self) -> str:
        return f"Path from {self.start:g} s to {self.end:.7g} s"

    def at(self, time: ArrayLike) -> State:
        """Return the state at one or more times.

        Parameters
        ----------
        time
            s since the start of the scene; a number or an array of any shape.

        Raises
        ------
        ValueError
            If a time lies outside the path.
        TypeError
            If a time is no number.
        """
        times = real_numbers("time", time)
        # `~` and not the opposite comparisons, so that NaN is outside, too.
        outside = times[~((times >= self.start) & (times <= self.end))]
        if outside.size:
            raise ValueError(
                f"t = {outside[0]} s is outside the path, from {self.start} s to {self.end} s"
            )
        states = []
        with self._numbers.arithmetic():
            # One by one: engines of many digits have no arrays.
            for t in times.ravel().tolist():
                exact, end = self._numbers.exact(t), self._trajectory.end
                # The end may lie between two doubles, and so may the beginning of a flight.
                if t == self.end and exact > end:
                    exact = end
                # At the contact two legs meet. The later one counts, with the velocity after the
                # impulse.
                for leg in self._trajectory.legs:
                    if t == self._double(leg.begin):
                        exact = leg.begin
                (row,) = self._trajectory.sample([exact])
                states.append([*map(self._double, row)])
        numbers = np.array(states).reshape(*times.shape, 6)
        return State(times[()], numbers[..., :3], numbers[..., 3:])

    @naming_extras()
    def sample(self, points: int = 200) -> pd.DataFrame:
        """Return states at evenly spaced times from start to end.

        Parameters
        ----------
        points
            How many, 2 at least: the first at the start, the last at the end. States at times of
            your own come from `at`.

        Returns
        -------
        pandas.DataFrame
            With columns ``t`` (s), ``x``, ``y``, ``z`` (m), ``vx``, ``vy``, ``vz`` (m/s).

        Raises
        ------
        TypeError, ValueError
            If `points` is not such a number.
        """
        import pandas as pd

        # Whoever has times looks for `at`.
        if np.ndim(points):
            raise TypeError(f"points = {points!r}: how many is asked; path.at takes times")
        count = engines.whole_number("points", points, 2)
        time, position, velocity = self.at(np.linspace(self.start, self.end, count))
        table = np.column_stack([time, position, velocity])
        return pd.DataFrame(table, columns=["t", "x", "y", "z", "vx", "vy", "vz"])

    @naming_extras()
    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the path from the side, to scale: height against distance from the plate, m.

        Parameters
        ----------
        ax
            Axes of Matplotlib to draw on; by default new ones.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, for titles, limits and more paths.

        Examples
        --------
        >>> import longball as lb
        >>> axes = lb.solve(lb.AtBat()).path.plot()
        >>> axes.get_ylabel()
        'height z (m)'
        """
        import matplotlib.pyplot as plt

        axes = plt.subplots(layout="constrained")[1] if ax is None else ax
        position = self.at(np.linspace(self.start, self.end, _PLOTTED)).position
        axes.plot(position[:, 0], position[:, 2])
        axes.set(xlabel="x, from the plate towards the pitcher (m)", ylabel="height z (m)")
        # To scale: an angle of launch is the angle that is seen.
        axes.set_aspect("equal", adjustable="datalim")
        return axes

    def _double(self, x: Any) -> float:
        return float(self._numbers.report(x))


_PLOTTED = 400  # points: lines between them are as smooth as a screen


class Solution:
    """The result of a scene.

    `scene` is the solved scene, None if it was invalid. The other attributes are the keys of a line
    of results; a block that the outcome does not have is None. A number is a float, or with
    `digits` a `Bounded`, which `float` converts.
    """

    outcome: Outcome | None
    # None where the outcome does not have it, as a miss has no landing.
    plate: Plate | None
    contact: Contact | None
    impact: Impact | None
    apex: Apex | None
    fence: Fence | None
    landing: Landing | None
    engine: str | None
    error: str | None
    code: ErrorCode | None

    def __init__(
        self,
        scene: Scene | None,
        data: dict[str, Any],  # of its result, with the name of the engine alone
        solver: Engine,
        trajectory: Trajectory | None = None,
        derivatives: Derivatives | None = None,
    ) -> None:
        self.scene, self._data = scene, data
        self._solver, self._trajectory = solver, trajectory
        self._derivatives = derivatives

    @property
    def id(self) -> str | None:
        """The id of the scene."""
        name: str | None = self._data["id"]
        return name

    @cached_property
    def result(self) -> Result:
        """The whole result as a model; ``result.line()`` is its line of JSON."""
        by = self._data.get("engine")
        return Result.model_validate(self._data | ({"engine": signed(by)} if by else {}))

    def __getattr__(self, name: str) -> Any:
        # Blocks and top-level keys; the declarations above are for type checkers.
        if name in BLOCKS:
            # Create one block only: most callers need the same one from thousands of solutions.
            block = self._data.get(name)
            vars(self)[name] = block and BLOCKS[name].model_validate(block)
            return vars(self)[name]
        if name in Result.model_fields:
            return getattr(self.result, name)
        hint = "" if name.startswith("_") else did_you_mean(name, _quantities())
        raise AttributeError(f"a solution has no attribute {name!r}{hint}")

    def __getitem__(self, name: str) -> Any:
        """Return a quantity by its name, such as ``landing.position[0]``; None if absent.

        A ValueError for a name that no result has gives similar names.
        """
        # Check the name against the model: at() returns None for any missing quantity.
        keys = re.sub(r"\[\d+\]", "", name).split(".")
        if not parts_of(Result, keys):
            raise ValueError(f"{name}: no result has it{one_of('they have', name, _quantities())}")
        return at({keys[0]: getattr(self if keys[0] in BLOCKS else self.result, keys[0])}, name)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, without the quantities it does not have."""
        return self.result.data()

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *Result.model_fields]

    def __getstate__(self) -> dict[str, Any]:
        # A trajectory holds a generator, which cannot be pickled; `path` of a copy solves again.
        state = {name: value for name, value in vars(self).items() if name != "path"}
        return state | {"_trajectory": None}

    @property
    def derivatives(self) -> Derivatives:
        """Derivatives of its numbers by numbers of the scene; a `ValueError` if not requested."""
        if self._derivatives is None:
            raise ValueError("derivatives must be requested: lb.solve(scene, derivatives=True)")
        return self._derivatives

    @cached_property
    def path(self) -> Path:
        """The trajectory of the ball.

        Raises
        ------
        ValueError
            If nothing flies in the scene.
        InvalidScene, Undecided, CannotSolve
            If it has no result.
        """
        if self.scene is None or self.result.error is not None:
            raise error_of(self.result)
        # Results of solve_many come without trajectories, which would fill the memory.
        trajectory = self._trajectory
        if trajectory is None:
            _, trajectory = chain.solve_with_path(self.scene, self._solver)
        if not trajectory.legs:
            raise ValueError("an impact has no path: nothing flies in it")
        return Path(trajectory, self._solver)

    def __repr__(self) -> str:
        rows = [*self._rows()]
        width = max((len(name) for name, *_ in rows), default=0)
        lines = [f"  {name:<{width}} {value} {unit}".rstrip() for name, value, unit in rows]
        return "\n".join([self._title, *lines])

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{html.escape(value)}</td><td>{unit}</td></tr>"
            for name, value, unit in self._rows()
        )
        return f"<table><caption>{html.escape(self._title)}</caption>{rows}</table>"

    @property
    def _title(self) -> str:
        named = "" if self.id is None else f"{self.id}: "
        return f"{named}{self.outcome or self.error} ({self.engine or 'not solved'})"

    def _rows(self) -> Iterator[tuple[str, str, str]]:
        """Yield name, value and unit of every quantity."""
        # In the order of the model, with inner blocks (plate.approach) after their own.
        blocks = [*BLOCKS]
        for name in sorted(chain.PARTS, key=lambda part: blocks.index(part.split(".")[0])):
            block = self[name]
            for key, field in type(block).model_fields.items() if block else ():
                if (
                    value := getattr(block, key)
                ) is not None and f"{name}.{key}" not in chain.PARTS:
                    unit = _UNIT.match(field.description or "")
                    yield f"{name}.{key}", _shown(value), unit[0] if unit else ""


def _quantities() -> list[str]:
    """Return the names of all quantities that results have."""
    return [f"{name}.{key}" for name, block in chain.PARTS.items() for key in block.model_fields]


if TYPE_CHECKING:
    # Solutions by kind of scene: a type checker rejects blocks that the kind never has, and treats
    # the usual landing, plate or impact as present.

    class FlightSolution(Solution):
        """The result of a flight: neither pitch nor bat; without a landing it met a wall."""

        plate: None
        contact: None
        impact: None
        landing: Landing

    class PitchSolution(Solution):
        """The result of a pitch: it is not batted; without a crossing it met the ground."""

        plate: Plate
        contact: None
        impact: None
        apex: None
        fence: None
        landing: None

    class ImpactSolution(Solution):
        """The result of an impact: nothing flies; without an impulse the two part already."""

        plate: None
        contact: Contact
        impact: Impact
        apex: None
        fence: None
        landing: None


# Descriptions of the result's quantities begin with the unit.
_UNIT = re.compile(r"(s|m|m/s|rad|rad/s|J|N s)(?=[,;]|$)")


def real_numbers(name: str, value: ArrayLike) -> Array:
    """Return an array of numbers; texts that look like numbers are none."""
    numbers = column_of(value)
    if numbers.dtype != float:
        raise TypeError(f"{name} = {value!r}: a number or an array of numbers is needed")
    return numbers


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return f"({', '.join(map(_shown, value))})"
    if isinstance(value, Bounded | Certified):
        # Decimal digits of any number, which a float could not show.
        return value.value if value.radius is None else f"{value.value} ± {value.radius}"
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def error_of(result: Result) -> Exception:
    """Return the exception for a result without an outcome."""
    assert result.error is not None
    assert result.code is not None
    return _ERRORS[result.code](result.error)


_ERRORS: dict[ErrorCode, Callable[[str], Exception]] = {
    error.code: error for error in (InvalidScene, Undecided, CannotSolve, TooLong, OutOfRange)
}
