"""Scenes, solutions and P(e) for Python: what `import longball as lb` offers.

Scenes may be written as models, as mappings, or as lines of JSON. Results have the attributes that
lines of results have as keys. `longball.tables` solves many scenes at once.
"""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from os import PathLike
from typing import (
    TYPE_CHECKING,
    Any,
    Literal,
    NamedTuple,
    Protocol,
    TypeVar,
    Unpack,
    cast,
    get_args,
    overload,
)

import numpy as np
from numpy.typing import ArrayLike
from pydantic import ValidationError

from longball import engines
from longball.engines import chain
from longball.engines.engine import CannotSolve, Engine, OutOfRange, TooLong
from longball.engines.path import Trajectory
from longball.extras import naming_extras
from longball.model import scene as models
from longball.model.arrays import Array
from longball.model.explain import explain, parts_of
from longball.model.inputs import inputs, require_inputs
from longball.model.names import one_of
from longball.model.numbers import Undecided
from longball.model.plain import column_of, plain
from longball.model.quantities import at, numbers
from longball.model.readings import Reading, SamplingReading, readings_of
from longball.model.result import (
    Apex,
    Bounded,
    Certified,
    Contact,
    ErrorCode,
    Fence,
    Landing,
    Outcome,
    Plate,
    Result,
    signed,
)
from longball.model.result import Impact as ImpactResult
from longball.model.scene import AtBatScene, InvalidScene, Scene, parse_scene

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from longball.engines.path_engine import PathEngine
    from longball.engines.tangent import Derivatives
    from longball.model import dicts
    from longball.pitches import FittedPitches


# m: bat and ball meet some 2 ft before the plate's tip and 3 ft above the ground: Nathan's
# Trajectory Calculator begins there.
CONTACT = (0.6096, 0.0, 0.9144)


# --- scenes ---------------------------------------------------------------------------------------


class Flight(models.FlightScene):
    """A ball from launch to landing. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:
        _solved: FlightSolution

        def __init__(self, **blocks: Unpack[dicts.FlightSceneBlocks]) -> None: ...


class Pitch(models.PitchScene):
    """A pitch from the release to the plane x = 0. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:
        _solved: PitchSolution

        def __init__(self, **blocks: Unpack[dicts.PitchSceneBlocks]) -> None: ...


class Impact(models.ImpactScene):
    """Ball and bat at the moment of touching. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:
        _solved: ImpactSolution

        def __init__(self, **blocks: Unpack[dicts.ImpactSceneBlocks]) -> None: ...


class AtBat(models.AtBatScene):
    """Pitch, swing, contact, impact and flight. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:

        def __init__(self, **blocks: Unpack[dicts.AtBatSceneBlocks]) -> None: ...


def launch(
    speed: float,
    angle: float,
    direction: float = 0.0,
    *,
    backspin: float | None = None,
    side_spin: float | None = None,
    position: Sequence[float] = CONTACT,
) -> models.Launch:
    """Return the launch of a batted ball from what trackers measure.

    Parameters
    ----------
    speed
        m/s, off the bat.
    angle
        rad, above the horizontal.
    direction
        rad, from centre field to the left.
    backspin
        rad/s, about the horizontal axis across the direction; it lifts the ball.
    side_spin
        rad/s, about the axis across both that and the velocity; it turns the ball to the left.
    position
        m, of the ball's centre; by default 2 ft in front of the plate's tip, 3 ft above the ground.

    Raises
    ------
    InvalidScene
        If a number is none that a scene may have.

    Examples
    --------
    >>> import longball as lb
    >>> scene = lb.Flight(launch=lb.launch(speed=46.0, angle=0.5))
    >>> round(lb.solve(scene).landing.distance, 3)
    116.06
    """
    if not speed > 0.0:
        raise InvalidScene(f"speed: must be positive (got {speed!r})")
    level, ahead = math.cos(angle), (math.cos(direction), math.sin(direction))
    rise = math.sin(angle)
    start: Any = position  # in any form that a block takes
    velocity = (speed * level * ahead[0], speed * level * ahead[1], speed * rise)
    if backspin is None and side_spin is None:
        return models.Launch(position=start, velocity=velocity)
    back, side = backspin or 0.0, side_spin or 0.0
    spin = (
        back * ahead[1] - side * rise * ahead[0],
        -back * ahead[0] - side * rise * ahead[1],
        side * level,
    )
    return models.Launch(position=start, velocity=velocity, spin=spin)


def as_scene(written: object) -> Scene:
    """Return the scene that a model, a mapping or a line of JSON describes.

    Raises
    ------
    InvalidScene
        If it describes none; the message names the key at fault.
    TypeError
        If it is something else, or holds something that JSON has no form for.
    """
    if isinstance(written, get_args(Scene)):
        return cast(Scene, written)
    if isinstance(written, str | bytes):
        return parse_scene(written)
    if isinstance(written, Mapping):
        try:
            return parse_scene(json.dumps(plain(written)))
        except RecursionError:
            raise InvalidScene("not a scene: its blocks are nested too deeply") from None
    raise TypeError(
        "a scene is an lb.AtBat, lb.Flight, lb.Pitch or lb.Impact, a mapping or a line of JSON; "
        f"not {_of_type(written)}"
    )


def _of_type(value: object) -> str:
    return f"an object of type {type(value).__name__}"


# --- one scene ------------------------------------------------------------------------------------


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

    def __init__(self, trajectory: Trajectory[Any], engine: Engine[Any]) -> None:
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
        times = _real("time", time)
        outside = times[~((times >= self.start) & (times <= self.end))]
        if outside.size:
            raise ValueError(
                f"t = {outside[0]} s is outside the path, from {self.start} s to {self.end} s"
            )
        with self._numbers.arithmetic():
            states = [self._state(t) for t in times.ravel().tolist()]
        found = np.array(states).reshape(*times.shape, 6)
        return State(times[()], found[..., :3], found[..., 3:])

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

        if np.ndim(points):
            raise TypeError(f"points = {points!r}: how many is asked; path.at takes times")
        count = engines.whole_number("points", points, 2)
        time, position, velocity = self.at(np.linspace(self.start, self.end, count))
        table = np.column_stack([time, position, velocity])
        return pd.DataFrame(table, columns=["t", "x", "y", "z", "vx", "vy", "vz"])

    @naming_extras()
    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the path from the side, to scale: height over the way from the plate, m.

        Parameters
        ----------
        ax
            Axes of Matplotlib to draw on; new ones if left out.

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
        axes.set_aspect("equal", adjustable="datalim")
        return axes

    def _state(self, time: float) -> list[float]:
        exact = self._numbers.exact(time)
        end = self._trajectory.end
        # The end may lie between two doubles, and so may the beginning of a flight.
        if time == self.end and exact > end:
            exact = end
        for leg in self._trajectory.legs:
            if time == self._double(leg.begin):
                exact = leg.begin
        (row,) = self._trajectory.sample([exact])
        return [self._double(x) for x in row]

    def _double(self, x: Any) -> float:
        return float(self._numbers.report(x))


_PLOTTED = 400  # points: lines between them are as smooth as a screen


class Solution:
    """The result of a scene.

    Its attributes are the keys of a line of results; a block that the outcome does not have is
    None. A number is a float, or with `digits` a `Bounded`, which `float` converts.

    Attributes
    ----------
    scene
        The scene that was solved.
    result
        The whole result as a model; ``result.line()`` is its line of JSON.
    """

    id: str | None
    outcome: Outcome | None
    # None where the outcome does not have it: who asks for a block knows the outcome.
    plate: Plate
    contact: Contact
    impact: ImpactResult
    apex: Apex
    fence: Fence
    landing: Landing
    engine: str | None
    error: str | None
    code: ErrorCode | None

    def __init__(
        self,
        scene: Scene | None,
        result: Result,
        solver: Engine[Any],
        trajectory: Trajectory[Any] | None = None,
        derivatives: Derivatives | None = None,
    ) -> None:
        engine = result.engine and signed(result.engine)
        self.scene, self.result = scene, result.model_copy(update={"engine": engine})
        self._solver, self._trajectory = solver, trajectory
        self._derivatives = derivatives

    def __getattr__(self, name: str) -> Any:
        if name in Result.model_fields:
            return getattr(self.result, name)
        raise AttributeError(f"a solution has no attribute {name!r}")

    def __getitem__(self, name: str) -> Any:
        """Return a quantity by its name, such as ``landing.position[0]``; None if it is left out.

        A ValueError says that no result has it, and names the nearest.
        """
        keys = re.sub(r"\[\d+\]", "", name).split(".")
        if not parts_of(Result, keys):
            blocks = chain.PARTS.items()
            known = [f"{block}.{key}" for block, its in blocks for key in its.model_fields]
            raise ValueError(f"{name}: no result has it{one_of('they have', name, known)}")
        return at(self.result, name)

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data, without the quantities it does not have."""
        return self.result.data()

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *Result.model_fields]

    def __getstate__(self) -> dict[str, Any]:
        # A trajectory is made piece by piece, which no copy can go on with: `path` solves again.
        state = {name: value for name, value in vars(self).items() if name != "path"}
        return state | {"_trajectory": None}

    @property
    def derivatives(self) -> Derivatives:
        """Derivatives of its numbers by numbers of the scene; a `ValueError` if not asked for."""
        if self._derivatives is None:
            raise ValueError("derivatives are to be asked for: lb.solve(scene, derivatives=True)")
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
        way = self._trajectory
        if way is None:
            _, way = chain.solve_with_path(self.scene, self._solver)
        if not way.legs:
            raise ValueError("an impact has no path: nothing flies in it")
        return Path(way, self._solver)

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
        blocks = [*chain.BLOCKS]
        for name in sorted(chain.PARTS, key=lambda part: blocks.index(part.split(".")[0])):
            block = at(self.result, name)
            for key, field in type(block).model_fields.items() if block else ():
                if (
                    value := getattr(block, key)
                ) is not None and f"{name}.{key}" not in chain.PARTS:
                    unit = _UNIT.match(field.description or "")
                    yield f"{name}.{key}", _shown(value), unit[0] if unit else ""


if TYPE_CHECKING:
    # Solutions of a kind: a type checker refuses what no scene of the kind has.

    class FlightSolution(Solution):
        """The result of a flight: neither pitch nor bat."""

        plate: None  # type: ignore[assignment]
        contact: None  # type: ignore[assignment]
        impact: None  # type: ignore[assignment]

    class PitchSolution(Solution):
        """The result of a pitch: it is not batted."""

        contact: None  # type: ignore[assignment]
        impact: None  # type: ignore[assignment]
        apex: None  # type: ignore[assignment]
        fence: None  # type: ignore[assignment]
        landing: None  # type: ignore[assignment]

    class ImpactSolution(Solution):
        """The result of an impact: nothing flies."""

        plate: None  # type: ignore[assignment]
        apex: None  # type: ignore[assignment]
        fence: None  # type: ignore[assignment]
        landing: None  # type: ignore[assignment]


S = TypeVar("S", bound=Solution, covariant=True)


class _Of(Protocol[S]):
    """A scene whose class says what type its solutions are of."""

    @property
    def _solved(self) -> S: ...


# Descriptions of the result's quantities begin with the unit.
_UNIT = re.compile(r"(s|m|m/s|rad|rad/s|J|N s)(?=[,;]|$)")


def _real(name: str, value: ArrayLike) -> Array:
    """Return an array of numbers; texts that look like numbers are none."""
    numbers = column_of(value)
    if numbers.dtype != float:
        raise TypeError(f"{name} = {value!r}: a number or an array of numbers is needed")
    return numbers


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return f"({', '.join(map(_shown, value))})"
    if isinstance(value, Bounded | Certified):
        return value.value if value.radius is None else f"{value.value} ± {value.radius}"
    return f"{value:.7g}" if isinstance(value, float) else str(value)


@overload
def solve(
    scene: _Of[S],
    engine: str | Engine[Any] = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> S: ...


@overload
def solve(
    scene: dicts.SceneDict | Scene | Mapping[str, Any] | str | bytes,
    engine: str | Engine[Any] = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> Solution: ...


def solve(
    scene: object,
    engine: str | Engine[Any] = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> Solution:
    """Solve a scene.

    Parameters
    ----------
    scene
        An `AtBat`, `Flight`, `Pitch` or `Impact`, a mapping like one, or a line of JSON.
    engine
        ``"ivp"``, ``"batch"``, ``"enclosure"``, ``"multiprecision"``, ``"verlet"``, or an engine.
    certify
        Whether every number comes with a proven bound on its error, as a `Certified`.
    derivatives
        Whether the derivatives of the result by every number of the scene come with it, as
        ``result.derivatives``; or by which numbers, such as ``["launch.speed", "gravity"]``.
    options
        Of an engine given by name: ``digits=30`` of enclosure and multiprecision, ``dt=1e-3`` of
        verlet, and so on.

    Raises
    ------
    InvalidScene
        If `scene` describes none; the message names the key at fault.
    Undecided
        If the engine cannot tell what happens: its error is larger than what decides. With
        `certify`, also if a bound cannot be proven.
    CannotSolve
        If it has no answer for another reason.
    ValueError
        If there is no such engine, or it does not take an option.
    TypeError
        If `scene`, `engine`, `certify` or an option is of another type.

    Examples
    --------
    >>> import longball as lb
    >>> ball = lb.Flight(launch={"position": [0, 0, 1], "velocity": [30, 0, 25]})
    >>> result = lb.solve(ball)
    >>> f"{result.landing.distance:.6f} m"
    '92.847616 m'
    >>> result.path.at(1.0).position.round(3)
    array([25.243,  0.   , 20.103])
    """
    asked, solver = as_scene(scene), as_engine(engine, options)
    certify = engines.of_type(bool, "certify", certify)
    if certify and derivatives:
        raise ValueError("derivatives are not certified; engine = 'enclosure' proves them")
    result, trajectory = chain.solve_with_path(asked, solver)
    if result.error is not None:
        raise error_of(result)
    if certify:
        from longball.engines.certify import certify as certified  # brings ball arithmetic

        result = certified(asked, result)
        if result.certificate is not None:
            raise Undecided(result.certificate)
    slopes = derivatives_in(asked, result, solver, derivatives) if derivatives else None
    return Solution(asked, result, solver, trajectory, slopes)


def derivatives_in(
    scene: Scene, result: Result, engine: Engine[Any], names: bool | Sequence[str]
) -> Derivatives:
    """Return the derivatives of a result by some numbers of its scene, or by all."""
    from longball.engines.tangent import derivatives_of

    chosen = chosen_inputs(scene, names)
    quantities = [name for name, _ in numbers(result) if name not in chain.DISCRETE]
    return derivatives_of(scene, quantities, chosen, differentiable(engine))


def chosen_inputs(scene: Scene, names: bool | Sequence[str]) -> list[str]:
    """Return the names of some inputs of a scene, checked, or of all."""
    if isinstance(names, bool):
        return [*inputs(scene)]
    if isinstance(names, str):
        raise TypeError(f"derivatives = {names!r}: a list of names is needed, such as [{names!r}]")
    return require_inputs(scene, names)


def differentiable(engine: Engine[Any]) -> PathEngine[Any]:
    """Return an engine that derivatives can be had of; a ValueError says that it is none."""
    from longball.engines.path_engine import PathEngine

    if not isinstance(engine, PathEngine):
        raise ValueError(
            f"the engine {engine.description} has no derivatives; take ivp, multiprecision or "
            "enclosure"
        )
    return engine


def as_engine(engine: str | Engine[Any], options: Mapping[str, Any]) -> Engine[Any]:
    """Return an engine by name with options, or the one that is given."""
    if isinstance(engine, str):
        return engines.create(engine, **options)
    if not hasattr(engine, "fly"):
        raise TypeError(
            f"engine must be a name ({', '.join(engines.ENGINES)}) or an engine; "
            f"not {_of_type(engine)}"
        )
    if options:
        raise TypeError(f"{', '.join(options)}: options go with the name of an engine")
    return engine


def error_of(result: Result) -> Exception:
    """Return the exception that says why a result has no outcome."""
    assert result.error is not None
    assert result.code is not None
    return _ERRORS[result.code](result.error)


_ERRORS: dict[ErrorCode, Callable[[str], Exception]] = {
    error.code: error for error in (InvalidScene, Undecided, CannotSolve, TooLong, OutOfRange)
}


# --- the probability of a home run ----------------------------------------------------------------


@naming_extras()
def home_run_probability(
    e: ArrayLike,
    method: Literal["quadrature", "monte-carlo"] = "quadrature",
    *,
    samples: int | None = None,
    seed: int | None = None,
    reading: Mapping[str, object] | None = None,
    scene: object = None,
    pitches: FittedPitches | str | PathLike[str] | None = None,
    workers: int = -1,
) -> pd.DataFrame:
    """Compute the probability of a home run P(e) of the paper's at-bats.

    Parameters
    ----------
    e
        Coefficients of restitution of the ball, 0 to 1.
    method
        ``"quadrature"`` integrates over the distributions; ``"monte-carlo"`` counts samples.
    samples, seed
        Of Monte Carlo: how many at-bats are drawn, 10,000 if left out, and the seed of the random
        numbers, 1 if left out.
    reading
        Switches of the ledger (``longball readings``), of the scene and of the sampling.
    scene
        An at-bat, as `solve` takes it, with all that is not drawn at random: speed and aim of the
        pitch, height and tilt of the swing and the restitution are. The paper's if left out.
    pitches
        What speed and aim are drawn from: the result of `longball.pitches.fit_pitches`, or the file
        that ``longball fit --json`` wrote. The paper's distributions if left out.
    workers
        Threads; -1: one per core. The answer does not depend on it.

    Returns
    -------
    pandas.DataFrame
        A row for each e. Quadrature: ``e``, ``p``, ``error``, ``slope`` (dP/de), ``slope_error``.
        Monte Carlo: ``e``, ``p``, ``low``, ``high`` (95 %), ``home_runs``, ``trials``, ``failed``.

    Raises
    ------
    ValueError
        If an e is not between 0 and 1 or there is none, a reading or the method is unknown, or
        `scene` is no at-bat, or sets what is drawn at random; if `pitches` cannot be read; if
        `samples`, `seed` or `workers` is too small, or one of the first two is given for
        quadrature, which draws none.
    TypeError
        If one of these three is not a whole number, an e no number, or `reading` no mapping.

    Examples
    --------
    >>> import longball as lb
    >>> lb.home_run_probability([0.41, 0.45], "monte-carlo", samples=1000).p.tolist()
    [0.008, 0.015]
    """
    import pandas as pd

    from longball import home_run

    restitutions = _restitutions(e)
    drawn = {"samples": samples, "seed": seed}
    if method == "quadrature" and (given := [name for name, x in drawn.items() if x is not None]):
        raise ValueError(f"{given[0]}: quadrature draws none; method = 'monte-carlo' does")
    count = engines.whole_number("samples", 10_000 if samples is None else samples, 1)
    first = engines.whole_number("seed", 1 if seed is None else seed, 0)
    physics, sampling = _readings(reading or {})
    base = as_scene({"kind": "at-bat"} if scene is None else scene)
    if not isinstance(base, AtBatScene):
        raise ValueError(f"scene: an at-bat is needed, and this is a {base.kind}")
    home_run.refuse_drawn(base)
    if reading:
        base = base.model_copy(update={"reading": physics})
    at_bats = home_run.paper_at_bats(sampling)
    if pitches is not None:
        from longball.pitches import FittedPitches, load_fitted

        fitted = pitches if isinstance(pitches, FittedPitches) else load_fitted(pitches)
        at_bats = fitted.drawn_in(at_bats)
    problem = base, at_bats, restitutions
    rows: Sequence[home_run.Estimate | home_run.Integral]
    space = sampling.sample_space
    if method == "quadrature":
        rows = home_run.integrals(*problem, sample_space=space, workers=workers)
    elif method == "monte-carlo":
        rows = home_run.estimates(*problem, count, first, sample_space=space, workers=workers)
    else:
        raise ValueError(f"method {method!r} is not one of quadrature, monte-carlo")
    return pd.DataFrame([home_run.columns(row) for row in rows])


def _restitutions(e: ArrayLike) -> list[float]:
    given = _real("e", e)
    if given.ndim > 1 or not given.size or not ((given >= 0) & (given <= 1)).all():
        raise ValueError(
            f"e = {given.tolist()}: one coefficient of restitution or more is needed, "
            "each from 0 to 1"
        )
    found: list[float] = given.reshape(-1).tolist()
    return found


def _readings(switches: Mapping[str, object]) -> tuple[Reading, SamplingReading]:
    """Return the readings of scene and sampling; what is wrong with them is one sentence."""
    if not isinstance(switches, Mapping):
        raise TypeError(f"reading: a mapping from switches is needed; not {_of_type(switches)}")
    known = (*Reading.model_fields, *SamplingReading.model_fields)
    for name in switches:
        if name not in known:
            raise ValueError(f"reading: {name!r} is not a switch; they are {', '.join(known)}")
    try:
        return readings_of(switches)
    except ValidationError as error:
        raise ValueError(f"reading: {explain(error, Reading)}") from None
