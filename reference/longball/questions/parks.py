"""Parks: their fences, and batted balls in each of them.

A fence is a line of straight chords. Each vertex has a bearing from centre field, a distance from
the plate and a height of the wall, which is linear along a chord; two vertices at the same point
form a step. A. Fox measured most shapes from the air, to a few feet; the chords depart from his
curves by a foot or two. Parks without such a measurement have five vertices: the published
distances of the foul poles, of centre field and of the alleys, which are assumed at 22.5°.
A park is missing if no source gives its distances and heights.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any

from longball.api import as_engine, scene_of_kind
from longball.engines.chain import solve_each
from longball.model.air import Weather
from longball.model.inputs import listed
from longball.model.names import did_you_mean
from longball.model.result import Result
from longball.model.scene import AtBatScene, Fence, FlightScene, Scene
from longball.pitches.statcast import FOOT, PARKS
from longball.pitches.table import DATA

FENCES = DATA / "fences.csv"

# Cosine and sine of 45°: those of the library may differ in the last bit, and put a pole off the
# foul line.
_POLE = math.sqrt(0.5)


@dataclass(frozen=True)
class Park:
    """A park's fence.

    Attributes
    ----------
    name
        Name in use today by Statcast and the league.
    formerly
        Former name of the park with the same fence; empty if there is none.
    city
        City of its team.
    bearings
        Bearing of each vertex from centre field, rad, positive to the left, from the left pole on.
    distances
        Distance of each vertex from the plate, m.
    walls
        Height of the fence at each vertex, m.
    elevation
        Height above sea level, m.
    seasons
        Years for which these numbers are valid, such as ``"2013-"``.
    source
        Publisher of the numbers.
    """

    name: str
    formerly: str
    city: str
    bearings: tuple[float, ...]
    distances: tuple[float, ...]
    walls: tuple[float, ...]
    elevation: float
    seasons: str
    source: str

    @property
    def fence(self) -> Fence:
        """The `fence` block of a scene."""
        places = zip(self.distances, map(_ahead, self.bearings), self.walls, strict=True)
        return Fence(polyline=tuple((x * far, y * far, top) for far, (x, y), top in places))


def _ahead(bearing: float) -> tuple[float, float]:
    """Return the unit vector to a bearing."""
    if abs(bearing) == math.pi / 4:
        return _POLE, math.copysign(_POLE, bearing)
    return math.cos(bearing), math.sin(bearing)


@cache
def parks() -> tuple[Park, ...]:
    """Return all parks with a known fence, in the order of their names.

    Examples
    --------
    >>> import longball as lb
    >>> len(lb.parks())
    30
    >>> round(max(lb.park("Fenway Park").walls), 1)
    11.3
    """
    # Elevations and cities are in the table of parks that the weather of games uses, too.
    places = {row["park"]: row for row in _rows(PARKS)}
    return tuple(
        Park(
            row["park"],
            row["formerly"],
            places[row["park"]]["city"],
            tuple(math.radians(float(text)) for text in row["bearing"].split()),
            tuple(float(text) * FOOT for text in row["distance"].split()),
            tuple(float(text) * FOOT for text in row["wall"].split()),
            float(places[row["park"]]["elevation"]) * FOOT,
            row["seasons"],
            row["source"],
        )
        for row in _rows(FENCES)
    )


def _rows(path: Any) -> Iterator[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        yield from csv.DictReader(file)


def park(name: str) -> Park:
    """Return a park by its name, or a former one.

    Raises
    ------
    ValueError
        If the park is not known; the message gives similar names, or the parks of that city.

    Examples
    --------
    >>> import longball as lb
    >>> coors = lb.park("Coors Field")
    >>> f"{coors.distances[0]:.1f} m to the left pole, {coors.elevation:.0f} m above the sea"
    '105.2 m to the left pole, 1582 m above the sea'
    """
    known = {each.name: each for each in parks()}
    known |= {each.formerly: each for each in parks() if each.formerly}
    if name in known:
        return known[name]
    near = did_you_mean(name, known)
    # The name of a city selects its park: Boston is Fenway Park. The most similar name counts, as
    # Boston is also similar to Houston.
    cities = get_close_matches(name, [each.city for each in parks()], 1)
    if not near and cities:
        there = " or ".join(each.name for each in parks() if each.city == cities[0])
        near = f", did you mean {there}?"
    if any(row["park"] == name for row in _rows(PARKS)):
        near = ": no source gives the heights of its wall; if you know them, give the scene a fence"
    near = near or f"; the parks are {', '.join(each.name for each in parks())}"
    raise ValueError(f"park {name!r} is not known{near}")


@dataclass(frozen=True)
class InPark:
    """Result of a batted ball in a park."""

    park: Park
    result: Result

    @property
    def is_out(self) -> bool:
        """True if it is a home run."""
        return self.result.outcome == "home_run"

    @property
    def clearance(self) -> float | None:
        """Height above the top of the fence, m; negative for a wall; None short of the fence."""
        fence = self.result.fence
        return None if fence is None else float(fence.clearance)


def in_parks(
    scene: object, where: Iterable[Park | str] | None = None, engine: Any = "ivp", **options: Any
) -> list[InPark]:
    """Solve a batted ball in every park.

    Parameters
    ----------
    scene
        A flight or an at-bat, as `solve` takes it. Each park replaces its fence, and its elevation
        if the density is a weather. A density that is a number stays the same.
    where
        Parks or their names; by default all known ones.
    engine, options
        As `solve` takes them.

    Raises
    ------
    InvalidScene
        If `scene` is not a flight or an at-bat.
    ValueError
        If a park is not known; the message gives similar names.

    Examples
    --------
    >>> import longball as lb
    >>> ball = lb.Flight(launch=lb.launch(speed=46.0, angle=0.49, direction=0.35))
    >>> outcomes = lb.in_parks(ball)
    >>> sum(each.is_out for each in outcomes), len(outcomes)
    (12, 30)
    """
    asked: FlightScene | AtBatScene = scene_of_kind(scene, FlightScene, AtBatScene)
    chosen = parks() if where is None else listed(where)
    every = [park(one) if isinstance(one, str) else one for one in chosen]
    # The pressure of a weather is that at sea level. The model reduces it to the elevation, by the
    # weather formula of docs/model.md.
    rises = asked.air is not None and not ignores_elevation(asked)
    scenes: list[Any] = [
        asked.replace(fence=one.fence, **{"air.density.elevation": one.elevation} if rises else {})
        for one in every
    ]
    results = solve_each(scenes, as_engine(engine, options))
    return [InPark(one, result) for one, result in zip(every, results, strict=True)]


def ignores_elevation(scene: Scene) -> bool:
    """True if the air density is a number, and so the same in all parks."""
    air = getattr(scene, "air", None)
    return air is not None and not isinstance(air.density, Weather)
