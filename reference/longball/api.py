"""Scenes, solutions and P(e) for Python, as ``import longball as lb``.

Scenes can be models, mappings, or lines of JSON. The attributes of results are the keys of their
JSON. `longball.tables` solves many scenes at once.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, Unpack, cast, get_args, overload

from numpy.typing import ArrayLike
from pydantic import ValidationError

from longball import engines
from longball.engines import chain
from longball.engines.engine import Engine
from longball.extras import naming_extras
from longball.model import scene as models
from longball.model.explain import explain
from longball.model.inputs import (
    CONTACT,
    OF_SPIN,
    OF_VELOCITY,
    inputs,
    launched,
    require_inputs,
    tracked_fault,
)
from longball.model.numbers import DOUBLES, Undecided
from longball.model.quantities import numbers
from longball.model.readings import Reading, SamplingReading, readings_of
from longball.model.result import Result
from longball.model.scene import AtBatScene, InvalidScene, Scene, parse_scene, scene_of
from longball.solution import Solution, error_of, real_numbers

if TYPE_CHECKING:
    import pandas as pd

    from longball.engines.path_engine import PathEngine
    from longball.engines.tangent import Derivatives
    from longball.model import dicts
    from longball.pitches import FittedPitches
    from longball.solution import FlightSolution, ImpactSolution, PitchSolution


# --- scenes ---------------------------------------------------------------------------------------


class Flight(models.FlightScene):
    """A ball from launch to landing. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:

        def __init__(self, **blocks: Unpack[dicts.FlightSceneBlocks]) -> None: ...


class Pitch(models.PitchScene):
    """A pitch from the release to the plane x = 0. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:

        def __init__(self, **blocks: Unpack[dicts.PitchSceneBlocks]) -> None: ...


class Impact(models.ImpactScene):
    """Ball and bat at the moment of touching. An `InvalidScene` names the key at fault."""

    if TYPE_CHECKING:

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
    gyrospin: float | None = None,
    position: Sequence[float] = CONTACT,
) -> models.Launch:
    """Return the launch of a batted ball from the quantities that trackers measure.

    Parameters
    ----------
    speed
        m/s, off the bat.
    angle
        rad, above the horizontal, from -π/2 to π/2.
    direction
        rad, from centre field to the left.
    backspin
        rad/s, about the horizontal axis across the direction; it lifts the ball.
    side_spin
        rad/s, about the axis across both that and the velocity; it turns the ball to the left.
    gyrospin
        rad/s, about the velocity, as the spin of a bullet.
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
    moved, spun = (speed, angle, direction), (backspin, side_spin, gyrospin)
    # The same formulas as those of derivatives by launch.speed, in longball.model.inputs.
    tracked: dict[str, float] = dict(zip(OF_VELOCITY, moved, strict=True))
    if any(spin is not None for spin in spun):
        tracked |= zip(OF_SPIN, (spin or 0.0 for spin in spun), strict=True)
    for name, value in tracked.items():
        if fault := tracked_fault(name, value):
            raise InvalidScene(f"{name.removeprefix('launch.')}: {fault}")
    start: Any = position  # in any form that a block takes
    vectors = {name.removeprefix("launch."): v for name, v in launched(tracked, DOUBLES).items()}
    return models.Launch(position=start, **vectors)


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
    # A file's name is neither a scene nor a line of JSON, which begins with a brace.
    if isinstance(written, PathLike) or (isinstance(written, str) and _FILE.fullmatch(written)):
        raise InvalidScene(
            f"not a scene, but the name of a file: {written}; pass its text, as of "
            "Path(…).read_text(), or its lines to lb.solve_many"
        )
    if isinstance(written, str | bytes):
        return parse_scene(written)
    if isinstance(written, Mapping):
        return scene_of(written)
    several = "; lb.solve_many takes several" if isinstance(written, list | tuple) else ""
    raise TypeError(
        "a scene is an lb.AtBat, lb.Flight, lb.Pitch or lb.Impact, a mapping or a line of JSON; "
        f"not {_of_type(written)}{several}"
    )


def scene_of_kind(written: object, *kinds: type[Scene]) -> Any:
    """Return a scene of one of the kinds, as `as_scene` does, or raise an `InvalidScene`."""
    asked = as_scene(written)
    if not isinstance(asked, kinds):
        known = " or ".join(repr(kind.model_fields["kind"].default) for kind in kinds)
        raise InvalidScene(f"kind: must be {known} here, and is {asked.kind!r}")
    return asked


_FILE = re.compile(r"[^{}\[\]\n]*\.(jsonl?|ndjson|csv|parquet)")


def _of_type(value: object) -> str:
    return f"an object of type {type(value).__name__}"


# --- one scene ------------------------------------------------------------------------------------


@overload
def solve(
    scene: models.FlightScene | dicts.FlightSceneDict,
    engine: str | Engine = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> FlightSolution: ...


@overload
def solve(
    scene: models.PitchScene | dicts.PitchSceneDict,
    engine: str | Engine = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> PitchSolution: ...


@overload
def solve(
    scene: models.ImpactScene | dicts.ImpactSceneDict,
    engine: str | Engine = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> ImpactSolution: ...


@overload
def solve(
    scene: Scene | dicts.AtBatSceneDict | Mapping[str, Any] | str | bytes,
    engine: str | Engine = "ivp",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    **options: Any,
) -> Solution: ...


def solve(
    scene: object,
    engine: str | Engine = "ivp",
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
        If `scene` is invalid; the message names the key at fault.
    Undecided
        If the errors of the engine's numbers do not settle the outcome. With `certify`, also if a
        bound cannot be proven.
    CannotSolve
        If there is no answer for another reason.
    ValueError
        If there is no such engine, or it does not have the option.
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
    # Check the scene first: a mistake in it is more likely than one in the engine.
    asked, solver = as_scene(scene), as_engine(engine, options)
    # Truthy texts such as "no" are mistakes.
    certify = engines.of_type(bool, "certify", certify)
    if certify and derivatives:
        raise ValueError("derivatives are not certified; engine = 'enclosure' proves them")
    result, trajectory = chain.solve_with_path(asked, solver)
    if result.error is not None:
        raise error_of(result)
    # The engine's own double is certified, so that it stays the same with and without a bound.
    if certify:
        from longball.engines.certify import certify as certified  # brings ball arithmetic

        result = certified(asked, result)
        if result.certificate is not None:
            raise Undecided(result.certificate)
    slopes = derivatives_in(asked, result, solver, derivatives) if derivatives else None
    return Solution(asked, result.data(), solver, trajectory, slopes)


def derivatives_in(
    scene: Scene, result: Result, engine: Engine, names: bool | Sequence[str]
) -> Derivatives:
    """Return the derivatives of a result by given numbers of its scene, or by all."""
    from longball.engines.tangent import derivatives_of

    chosen = chosen_inputs(scene, names)
    # A discrete quantity, such as the segment of the fence, has no derivative.
    quantities = [name for name, _ in numbers(result) if name not in chain.DISCRETE]
    return derivatives_of(scene, quantities, chosen, differentiable(engine))


def chosen_inputs(scene: Scene, names: bool | Sequence[str]) -> list[str]:
    """Return the names of inputs of a scene, checked; True means all."""
    if isinstance(names, bool):
        return [*inputs(scene)]
    return require_inputs(scene, names)


def differentiable(engine: Engine) -> PathEngine:
    """Return the engine if it supports derivatives; raise a ValueError if not."""
    from longball.engines.path_engine import PathEngine

    if not isinstance(engine, PathEngine):
        raise ValueError(
            f"the engine {engine.description} has no derivatives; take ivp, multiprecision or "
            "enclosure"
        )
    return engine


def as_engine(engine: str | Engine, options: Mapping[str, Any]) -> Engine:
    """Return an engine by name with options, or the one that is given."""
    if isinstance(engine, str):
        return engines.create(engine, **options)
    # Any object with the method of a protocol is an engine.
    if not (hasattr(engine, "fly") or hasattr(engine, "solve_as_data")):
        raise TypeError(
            f"engine must be a name ({', '.join(engines.ENGINES)}) or an engine; "
            f"not {_of_type(engine)}"
        )
    if options:
        raise TypeError(f"{', '.join(options)}: options go with the name of an engine")
    return engine


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
        For Monte Carlo: number of at-bats, by default 10,000, and seed of the random numbers, by
        default 1.
    reading
        Switches of the ledger (``longball readings``), of the scene and of the sampling.
    scene
        An at-bat, as `solve` takes it, by default the paper's. Its restitution, the speed and aim
        of the pitch, and the height and tilt of the swing are random and cannot be set.
    pitches
        Distributions of speed and aim: a result of `longball.pitches.fit_pitches`, or a file from
        ``longball fit --json``; by default the paper's.
    workers
        Number of threads; -1: one per core. The result does not depend on it.

    Returns
    -------
    pandas.DataFrame
        A row for each e. Quadrature: ``e``, ``p``, ``error``, ``slope`` (dP/de), ``slope_error``.
        Monte Carlo: ``e``, ``p``, ``low``, ``high`` (95 %), ``home_runs``, ``trials``, ``failed``.

    Raises
    ------
    ValueError
        If there is no e, or one outside 0 to 1; if a reading or the method is unknown; if `scene`
        is not an at-bat, or sets a random number; if `pitches` cannot be read; if `samples`, `seed`
        or `workers` is too small, or one of the first two is given for quadrature.
    TypeError
        If one of these three is not a whole number, an e not a number, or `reading` not a mapping.

    Examples
    --------
    >>> import longball as lb
    >>> lb.home_run_probability([0.41, 0.45], "monte-carlo", samples=1000).p.tolist()
    [0.008, 0.015]
    """
    import pandas as pd

    from longball import home_run

    # Check all arguments before the computation begins.
    given_e = real_numbers("e", e)
    if given_e.ndim > 1 or not given_e.size or not ((given_e >= 0) & (given_e <= 1)).all():
        raise ValueError(
            f"e = {given_e.tolist()}: one coefficient of restitution or more is needed, "
            "each from 0 to 1"
        )
    restitutions: list[float] = given_e.reshape(-1).tolist()
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
    # Readings of the argument replace those of the scene: both at once would be ambiguous.
    if reading:
        base = base.model_copy(update={"reading": physics})
    at_bats = home_run.paper_at_bats(sampling)
    if pitches is not None:
        from longball.pitches import FittedPitches, load_fitted

        fitted = pitches if isinstance(pitches, FittedPitches) else load_fitted(pitches)
        at_bats = fitted.drawn_in(at_bats)
    # Both methods integrate over the same distributions, and can be compared.
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


def _readings(switches: Mapping[str, object]) -> tuple[Reading, SamplingReading]:
    """Return the readings of scene and sampling; an error has one sentence for all faults."""
    if not isinstance(switches, Mapping):
        raise TypeError(f"reading: a mapping from switches is needed; not {_of_type(switches)}")
    known = (*Reading.model_fields, *SamplingReading.model_fields)
    # Pydantic would name the first model alone; a switch may belong to either.
    for name in switches:
        if name not in known:
            raise ValueError(f"reading: {name!r} is not a switch; they are {', '.join(known)}")
    try:
        return readings_of(switches)
    except ValidationError as error:
        raise ValueError(f"reading: {explain(error, Reading)}") from None
