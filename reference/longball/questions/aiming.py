"""The launch that hits a target: low and high, or how far it would get."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import ValidationError
from scipy.optimize import brentq, minimize_scalar

from longball.api import as_engine, as_scene, differentiable, solve
from longball.engines.engine import CannotSolve
from longball.engines.path_engine import PathEngine
from longball.model.arrays import Array
from longball.model.inputs import listed, require_inputs, with_values
from longball.model.names import one_of
from longball.model.numbers import Undecided
from longball.model.plain import column_of
from longball.model.scene import FlightScene, InvalidScene, Scene
from longball.solution import Path, Solution

# Where each unknown is looked for: rad, m/s. No ball has been hit at 70 m/s. Straight up and down
# a launch has no direction.
RANGES = {
    "launch.angle": (-math.pi / 2 + 1e-6, math.pi / 2 - 1e-6),
    "launch.speed": (1.0, 100.0),
}
_DIRECTION = "launch.direction"

# Flights that are tried. Two launches that hit the target and lie between two of these have the
# farthest one between them, which is looked for as well.
_TRIED = 61
# How often a direction is corrected at most, for the curve of side spin and wind: a first time by
# what it is off, then by the secant, whose fourth step is below rounding.
_CORRECTED = 8
# Tolerance of roots, in rad, m/s and s: rounding. Brent's method gets there in some ten flights.
_EXACT = 1e-15


def aim(
    scene: object,
    target: Any,
    *,
    unknowns: Iterable[str] | None = None,
    engine: str = "ivp",
    **options: Any,
) -> list[FlightScene]:
    """Find the launches that land at a target, or pass through it.

    Parameters
    ----------
    scene
        A flight as `solve` takes it; all of its launch but the unknowns is kept.
    target
        A number: the landing's distance, m. Two: the place [x, y] of the landing, m. Three: the
        point [x, y, z] that the ball passes through, m.
    unknowns
        ``launch.angle`` or ``launch.speed``, and ``launch.direction`` for a place or a point; if
        left out, angle and direction. An angle is looked for from straight down to straight up, a
        speed from 1 to 100 m/s.
    engine, options
        As `solve` takes them.

    Returns
    -------
    list
        The scenes that hit the target, by rising angle or speed: of angles mostly a low one and a
        high one.

    Raises
    ------
    InvalidScene
        If `scene` is no flight.
    ValueError
        If target or unknowns are none of these.
    CannotSolve
        If the target is out of reach: the message says how far the ball would get, and how.

    Examples
    --------
    >>> import longball as lb
    >>> ball = lb.Flight(launch=lb.launch(speed=46.0, angle=0.4))
    >>> low, high = lb.aim(ball, 100.0)
    >>> round(low.launch.velocity[2], 3), round(high.launch.velocity[2], 3)
    (12.889, 39.402)
    >>> round(lb.solve(high).landing.distance, 9)
    100.0
    """
    asked, solver = as_scene(scene), differentiable(as_engine(engine, options))
    if not isinstance(asked, FlightScene):
        raise InvalidScene(f"aim: a flight is needed, and this is a scene of kind {asked.kind}")
    # A ball that hits the fence has no distance, and how far it would fly is asked.
    if asked.fence is not None:
        asked = asked.model_copy(update={"fence": None})
    place = column_of(target)
    if place.dtype != float or place.ndim > 1 or place.size not in (1, 2, 3):
        raise ValueError(
            f"target = {target!r}: a distance is needed, the place [x, y] of a landing, or the "
            "point [x, y, z] of a path, m"
        )
    if not np.isfinite(place).all():
        raise ValueError(f"target = {target!r}: every number must be finite")
    if place.size == 1 and not (place > 0).all():
        raise ValueError(f"target = {target!r}: a distance must be positive, m")
    names = _unknowns(unknowns, place.size)
    require_inputs(asked, names)
    return _hits(asked, place.reshape(-1), names, solver)


def _unknowns(given: Iterable[str] | None, numbers: int) -> list[str]:
    if given is None:
        return ["launch.angle", _DIRECTION][: 1 if numbers == 1 else 2]
    names = listed(given)
    wanted = 1 if numbers == 1 else 2
    for name in names:
        if name not in (*RANGES, _DIRECTION):
            raise ValueError(
                f"unknowns: {name} cannot be aimed with"
                f"{one_of('what can is', name, (*RANGES, _DIRECTION))}"
            )
    if len(names) != wanted or names[0] not in RANGES or names[1:] != [_DIRECTION][: wanted - 1]:
        needed = "launch.angle or launch.speed"
        if wanted == 2:
            raise ValueError(f"unknowns: a place or a point takes {needed}, and launch.direction")
        raise ValueError(f"unknowns: a distance takes one, {needed}")
    return names


@dataclass(frozen=True)
class _Trial:
    """A launch at a target."""

    scene: FlightScene
    excess: float  # m beyond the target, or above it; negative: short of it, or below
    gets: str  # how far the farthest launch gets, as a clause


def _hits(
    scene: FlightScene, target: Array, names: list[str], engine: PathEngine
) -> list[FlightScene]:
    """Return the scenes that hit a target, by the first unknown: some are tried, roots refined."""
    main = names[0]

    @cache
    def excess(x: float) -> float:
        trial = _trial(scene, target, {main: x}, engine)
        return math.nan if trial is None else trial.excess

    # some launches, and the one that gets farthest: beside a maximum two launches may hit, between
    # which no tried one gets beyond the target
    tried = np.linspace(*RANGES[main], _TRIED).tolist()
    known = [x for x in tried if not math.isnan(excess(x))]
    if not known:
        raise CannotSolve(f"no launch lands, of those that are tried for {main}")
    best = tried.index(max(known, key=excess))
    peak = minimize_scalar(
        lambda x: math.inf if math.isnan(excess(x)) else -excess(x),
        bounds=(tried[max(best - 1, 0)], tried[min(best + 1, _TRIED - 1)]),
        method="bounded",
        options={"xatol": 1e-9},
    )
    farthest = max(tried[best], float(peak.x), key=excess)

    # between two of which one is short and one is not, one hits
    hits = [
        b if excess(b) == 0 else brentq(excess, a, b, xtol=_EXACT)
        for a, b in pairwise(sorted({*tried, farthest}))
        if excess(a) * excess(b) < 0 or excess(b) == 0
    ]
    found = [_trial(scene, target, {main: x}, engine) for x in hits or [farthest]]
    if hits:
        return [trial.scene for trial in found if trial]
    (trial,) = found
    assert trial is not None
    if trial.excess < 0:
        raise CannotSolve(
            f"the target is out of reach: {trial.gets}; that is at {main} = {farthest:.6g}"
        )
    raise CannotSolve(f"the ball gets beyond the target at every {main} that is tried")


def _trial(
    scene: FlightScene, target: Array, values: dict[str, float], engine: PathEngine
) -> _Trial | None:
    """Return a launch at a target; None without a landing."""
    try:
        if len(target) == 1:
            launched: Any = with_values(scene, values)
            gets = float(_landed(launched, engine)["landing.distance"])
            return _Trial(launched, gets - target[0], _getting(gets, target[0]))
        return _in_its_direction(scene, target, values, engine)
    except (CannotSolve, InvalidScene, Undecided, ValidationError):
        return None


def _in_its_direction(
    scene: FlightScene, target: Array, values: dict[str, float], engine: PathEngine
) -> _Trial:
    origin = np.array(scene.launch.position[:2])
    away, bearing = _polar(target[:2] - origin)
    direction, step, before = bearing, 0.0, 0.0
    for _ in range(_CORRECTED):
        launched: Any = with_values(scene, {**values, _DIRECTION: direction})
        found = _landed(launched, engine)
        place = np.array([*map(float, found["landing.position"])])
        gets, turned = _polar(place[:2] - origin)
        trial = _Trial(launched, gets - away, _getting(gets, away))
        # A point is passed at a height: the excess is the height above it, and for a ball that does
        # not get so far also how far it falls short, which is negative, too.
        if len(target) == 3:
            short = min(gets - away, 0.0)
            if not short:
                place = found.path.at(_passing(found.path, origin, away)).position
                _, turned = _polar(place[:2] - origin)
                high = f"there the ball is {place[2]:.6g} m high at most"
                trial = replace(trial, gets=f"{high}, and the target {target[2]:.6g} m")
            trial = replace(trial, excess=place[2] - target[2] + short)
        off = math.remainder(bearing - turned, 2 * math.pi)
        if abs(off) <= _EXACT:
            break
        step = off * step / (before - off) if step and before != off else off
        direction, before = direction + step, off
    return trial


def _getting(gets: float, away: float) -> str:
    return f"the ball gets {gets:.6g} m of {away:.6g} m at most"


def _polar(vector: Array) -> tuple[float, float]:
    return math.hypot(*vector), math.atan2(vector[1], vector[0])


def _landed(scene: Scene, engine: PathEngine) -> Solution:
    found = solve(scene, engine)
    if found.landing is None:
        raise CannotSolve(f"the outcome is {found.outcome}")
    return found


def _passing(path: Path, origin: Array, away: float) -> float:
    """Return the time at which a growing distance from the origin reaches a value, s."""

    def beyond(time: float) -> float:
        return math.dist(path.at(time).position[:2], origin) - away

    begin, end = path.start, path.end
    return brentq(beyond, begin, end, xtol=_EXACT) if beyond(begin) < 0 < beyond(end) else end
