"""The launches that hit a target, or the farthest that the ball gets."""

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

from longball.api import as_engine, differentiable, scene_of_kind, solve
from longball.engines.engine import CannotSolve
from longball.engines.path_engine import PathEngine
from longball.model.arrays import Array
from longball.model.inputs import listed, require_inputs, with_values
from longball.model.names import one_of
from longball.model.numbers import Undecided
from longball.model.plain import column_of
from longball.model.scene import FlightScene, InvalidScene
from longball.solution import Path

# Range of each unknown, rad and m/s. No ball has been hit at 70 m/s. The ends of the angles are
# left out, because a launch straight up or down has no direction.
RANGES = {
    "launch.angle": (-math.pi / 2 + 1e-6, math.pi / 2 - 1e-6),
    "launch.speed": (1.0, 100.0),
}
_DIRECTION = "launch.direction"

# Launches on the first grid, 3° apart. If two launches between neighbours of the grid hit the
# target, the farthest launch is between them, and a search adds it to the grid.
_TRIED = 61  # a free choice
# Most corrections of the direction, which side spin and wind turn: the first by the angle that the
# landing is off, the others by the secant method, whose fourth step is below rounding.
_CORRECTED = 8  # a free choice
# Tolerance of roots in rad, m/s and s: rounding. Brent's method needs about ten flights.
_EXACT = 1e-15  # a free choice


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
        A flight as `solve` takes it. Everything except the unknowns stays the same.
    target
        One number: distance of the landing, m. Two: position [x, y] of the landing, m. Three: a
        point [x, y, z] of the path, m.
    unknowns
        ``launch.angle`` or ``launch.speed``, and ``launch.direction`` if the target is a position
        or a point; by default angle and direction. Angles are searched from straight down to
        straight up, speeds from 1 to 100 m/s.
    engine, options
        As `solve` takes them.

    Returns
    -------
    list
        Scenes that hit the target, in order of angle or speed. Usually there are two angles, a low
        one and a high one.

    Raises
    ------
    InvalidScene
        If `scene` is not a flight.
    ValueError
        If `target` or `unknowns` have another form.
    CannotSolve
        If the target is out of reach. The message gives the maximum and the launch that attains it.

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
    asked: FlightScene = scene_of_kind(scene, FlightScene)
    solver = differentiable(as_engine(engine, options))
    # A ball that hits the fence has no landing; the question is how far it would fly.
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
    main = names[0]

    @cache
    def trial(x: float) -> _Trial | None:
        try:
            return _trial(asked, np.atleast_1d(place), {main: x}, solver)
        except (CannotSolve, InvalidScene, Undecided, ValidationError):
            return None

    def excess(x: float) -> float:
        return tried.excess if (tried := trial(x)) else math.nan

    # the grid, and the launch that gets farthest: next to the maximum two launches may hit the
    # target although no launch of the grid gets beyond it
    grid = np.linspace(*RANGES[main], _TRIED).tolist()
    known = [x for x in grid if trial(x)]
    if not known:
        raise CannotSolve(f"no launch lands, at any {main} from {grid[0]:.4g} to {grid[-1]:.4g}")
    best = grid.index(max(known, key=excess))
    near = grid[max(best - 1, 0) : best + 2]
    peak = minimize_scalar(
        lambda x: -excess(x) if trial(x) else math.inf,
        bounds=(near[0], near[-1]),
        method="bounded",
        options={"xatol": 1e-9},  # a free choice
    )
    farthest = max(grid[best], float(peak.x), key=excess)

    # the excess changes sign between neighbours: one launch between them hits
    hits = [
        b if excess(b) == 0 else brentq(excess, a, b, xtol=_EXACT)
        for a, b in pairwise(sorted({*grid, farthest}))
        if excess(a) * excess(b) < 0 or excess(b) == 0
    ]
    if hits:
        return [hit.scene for hit in map(trial, hits) if hit]
    if (most := trial(farthest)) and most.excess < 0:
        raise CannotSolve(f"the target is out of reach: {most.gets}, at {main} = {farthest:.6g}")
    raise CannotSolve(f"the ball gets beyond the target at every {main} from {grid[0]:.4g} on")


def _unknowns(given: Iterable[str] | None, numbers: int) -> list[str]:
    # A distance has one unknown; a position has two, because the direction matters as well.
    second = [] if numbers == 1 else [_DIRECTION]
    names = ["launch.angle", *second] if given is None else listed(given)
    for name in names:
        if name not in (*RANGES, _DIRECTION):
            raise ValueError(
                f"unknowns: {name} cannot be aimed with"
                f"{one_of('what can is', name, (*RANGES, _DIRECTION))}"
            )
    if names not in [[first, *second] for first in RANGES]:
        needed = " or ".join(RANGES)
        if second:
            raise ValueError(f"unknowns: a place or a point takes {needed}, and {_DIRECTION}")
        raise ValueError(f"unknowns: a distance takes one, {needed}")
    return names


@dataclass(frozen=True)
class _Trial:
    """A launch at a target."""

    scene: FlightScene
    excess: float  # m beyond or above the target; negative if the ball is short of or below it
    gets: str  # the distance that the ball gets, as a clause of the error message


def _trial(
    scene: FlightScene, target: Array, values: dict[str, float], engine: PathEngine
) -> _Trial | None:
    """Return a launch at a target, in its direction; None without a landing."""
    # A distance counts from the plate. A place has a direction, too, which turns the path about the
    # launch.
    if len(target) == 1:
        origin, (away,), bearing = np.zeros(2), target.tolist(), None
    else:
        origin = np.array(scene.launch.position[:2])
        away, bearing = _polar(target[:2] - origin)
    direction, step, before = bearing, 0.0, 0.0
    for _ in range(_CORRECTED):
        aimed = {} if direction is None else {_DIRECTION: direction}
        launched: Any = with_values(scene, values | aimed)
        result = solve(launched, engine)
        if result.landing is None:
            return None
        place = np.array([*map(float, result.landing.position)])
        gets, turned = _polar(place[:2] - origin)
        trial = _Trial(launched, gets - away, f"the ball gets at most {gets:.6g} m of {away:.6g} m")
        if bearing is None:
            break
        assert direction is not None
        # The excess at a point is the ball's height above it. A ball that lands before it has the
        # (negative) distance by which it is short added, so that the excess stays continuous.
        if len(target) == 3:
            short = min(gets - away, 0.0)
            if not short:
                place = result.path.at(_passing(result.path, origin, away)).position
                _, turned = _polar(place[:2] - origin)
                high = f"there the ball is at most {place[2]:.6g} m high"
                trial = replace(trial, gets=f"{high}, and the target {target[2]:.6g} m")
            trial = replace(trial, excess=place[2] - target[2] + short)
        off = math.remainder(bearing - turned, 2 * math.pi)
        if abs(off) <= _EXACT:
            break
        # Secant method for the direction at which `off` is zero; the first step assumes slope 1.
        step = off * step / (before - off) if step and before != off else off
        direction, before = direction + step, off
    return trial


def _polar(vector: Array) -> tuple[float, float]:
    return math.hypot(*vector), math.atan2(vector[1], vector[0])


def _passing(path: Path, origin: Array, away: float) -> float:
    """Return the time at which a growing distance from the origin reaches a value, s."""

    def beyond(time: float) -> float:
        return math.dist(path.at(time).position[:2], origin) - away

    # A ball that lands short never reaches the distance: take the landing, which counts as short.
    begin, end = path.start, path.end
    return brentq(beyond, begin, end, xtol=_EXACT) if beyond(begin) < 0 < beyond(end) else end
