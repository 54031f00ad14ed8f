"""The launch that hits a target: low and high, or how far it would get."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import Any, cast

import numpy as np
from pydantic import ValidationError
from scipy.optimize import brentq, minimize_scalar

from longball.api import as_engine, as_scene, differentiable, solve
from longball.engines.engine import CannotSolve
from longball.engines.path_engine import PathEngine
from longball.model.arrays import Array
from longball.model.inputs import listed, require_inputs, value_of, with_values
from longball.model.names import one_of
from longball.model.numbers import Undecided
from longball.model.plain import column_of
from longball.model.scene import FlightScene, InvalidScene, Scene
from longball.questions.inverse import of_path, of_result
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
# A direction is corrected as often. A curve of some degrees is one of a thousandth of them at the
# second trial.
_CORRECTED = 3
# rad, m/s, s: to where a search goes, from which Newton's method is there in two steps.
_CLOSE = 1e-9
# Newton's steps, and how small the last one is, relative.
_STEPS, _SETTLED = 8, 1e-15


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
        needed = "launch.angle or launch.speed" + " and launch.direction" * (wanted == 2)
        raise ValueError(f"unknowns: a target of {numbers} numbers takes {needed}")
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

    # some launches, and the one that gets farthest
    tried = np.linspace(*RANGES[main], _TRIED).tolist()
    known = [x for x in tried if not math.isnan(excess(x))]
    if not known:
        raise CannotSolve(f"no launch lands, of those that are tried for {main}")
    best = tried.index(max(known, key=excess))
    found = minimize_scalar(
        lambda x: math.inf if math.isnan(excess(x)) else -excess(x),
        bounds=(tried[max(best - 1, 0)], tried[min(best + 1, _TRIED - 1)]),
        method="bounded",
        options={"xatol": _CLOSE},
    )
    farthest = max(tried[best], float(found.x), key=excess)

    # between two of which one is short and one is not, one hits
    hits = []
    for a, b in pairwise(sorted({*tried, farthest})):
        if excess(a) * excess(b) < 0 or excess(b) == 0:
            x = b if excess(b) == 0 else brentq(excess, a, b, xtol=_CLOSE)
            near = _trial(scene, target, {main: x}, engine)
            assert near is not None
            hits.append(_closer(near.scene, target, names, engine))
    if hits:
        return hits
    trial = _trial(scene, target, {main: farthest}, engine)
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
            return _at_a_distance(with_values(scene, values), target[0], engine)
        return _in_its_direction(scene, target, values, engine)
    except (CannotSolve, InvalidScene, Undecided, ValidationError):
        return None


def _at_a_distance(scene: Any, distance: float, engine: PathEngine) -> _Trial:
    gets = float(_landed(scene, engine)["landing.distance"])
    return _Trial(scene, gets - distance, _getting(gets, distance))


def _in_its_direction(
    scene: FlightScene, target: Array, values: dict[str, float], engine: PathEngine
) -> _Trial:
    origin = np.array(scene.launch.position[:2])
    away, bearing = _polar(target[:2] - origin)
    direction = bearing
    for _ in range(_CORRECTED):
        launched: Any = with_values(scene, {**values, _DIRECTION: direction})
        found = _landed(launched, engine)
        place = np.array([*map(float, found["landing.position"])])
        gets, turned = _polar(place[:2] - origin)
        trial = _Trial(launched, gets - away, _getting(gets, away))
        if len(target) == 3:
            short = min(gets - away, 0.0)
            if not short:
                place = found.path.at(_passing(found.path, origin, away)).position
                _, turned = _polar(place[:2] - origin)
                high = f"there the ball is {place[2]:.6g} m high at most"
                trial = replace(trial, gets=f"{high}, and the target {target[2]:.6g} m")
            trial = replace(trial, excess=place[2] - target[2] + short)
        direction += math.remainder(bearing - turned, 2 * math.pi)
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
    return brentq(beyond, begin, end, xtol=_CLOSE) if beyond(begin) < 0 < beyond(end) else end


def _closer(scene: FlightScene, target: Array, names: list[str], engine: PathEngine) -> FlightScene:
    """Return a scene that is near the target by Newton's method at it.

    A point is one of the path at a time, which is one more unknown.
    """
    near: Any = scene
    time: float | None = None
    if len(target) == 3:
        origin = np.array(near.launch.position[:2])
        time = _passing(solve(near, engine).path, origin, math.dist(target[:2], origin))
    for _ in range(_STEPS):
        if time is None:
            quantities = [f"landing.position[{i}]" for i in range(len(target))]
            quantities = ["landing.distance"] if len(target) == 1 else quantities
            found, slopes = of_result(near, quantities, names, engine)
        else:
            found, slopes = of_path(near, np.array([time]), names, engine)
            path = solve(near, engine).path
            moving = path.at(min(time, path.end)).velocity
            found, slopes = found[0], np.column_stack([slopes[0], moving])
        step, _, rank, _ = np.linalg.lstsq(slopes, target - found, rcond=1e-7)
        if rank < len(step):
            return scene  # the farthest launch, whose distance does not change with its angle
        values = {name: value_of(near, name) for name in names}
        near = with_values(
            near, {n: values[n] + float(d) for n, d in zip(names, step, strict=False)}
        )
        time = None if time is None else time + float(step[-1])
        if (np.abs(step[: len(names)]) <= _SETTLED * (1 + np.abs([*values.values()]))).all():
            break
    return cast(FlightScene, near)
