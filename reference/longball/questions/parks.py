"""Parks: fences by published distances and heights, and whether a ball is out in each.

A fence here is four straight chords between five published distances: those of the foul poles,
45° from centre field, of the alleys, which are put at 22.5°, and of centre field. Its top is at the
published height at each of these places, and linear between them. A real fence has more corners and
steps, and its alleys are marked where that suits: the module claims no more than these ten numbers.
Parks of which no source was found that gives them are not here.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from longball.api import as_engine, as_scene
from longball.engines.chain import solve_each
from longball.model.names import one_of
from longball.model.result import Result
from longball.model.scene import AtBatScene, Fence, FlightScene, InvalidScene
from longball.pitches.statcast import FOOT, PARKS
from longball.pitches.table import DATA

FENCES = DATA / "fences.csv"

_DISTANCES = ("left", "left_center", "center", "right_center", "right")
_WALLS = tuple(f"{place}_wall" for place in _DISTANCES)
# Of the alleys; of the poles it is √½ both ways, so that they stand on the foul lines themselves.
_COS, _SIN, _POLE = math.cos(math.pi / 8), math.sin(math.pi / 8), math.sqrt(0.5)
_AHEAD = ((_POLE, _POLE), (_COS, _SIN), (1.0, 0.0), (_COS, -_SIN), (_POLE, -_POLE))


@dataclass(frozen=True)
class Park:
    """A park's fence.

    Attributes
    ----------
    name
        As Statcast and the league call it today.
    formerly
        What it was called before, with the same fence; empty if nothing else.
    distances
        m, from the plate: left pole, left centre, centre, right centre, right pole.
    walls
        m, heights of the fence at these places.
    elevation
        m, above sea level.
    seasons
        In which these numbers hold, such as ``"2013-"``.
    source
        Who published them.
    """

    name: str
    formerly: str
    distances: tuple[float, ...]
    walls: tuple[float, ...]
    elevation: float
    seasons: str
    source: str

    @property
    def fence(self) -> Fence:
        """The fence as a block of a scene."""
        places = zip(self.distances, _AHEAD, self.walls, strict=True)
        return Fence(polyline=tuple((x * far, y * far, top) for far, (x, y), top in places))


@cache
def parks() -> tuple[Park, ...]:
    """Return the parks whose fences are known, by name.

    Examples
    --------
    >>> import longball as lb
    >>> len(lb.parks())
    20
    >>> [round(metres, 1) for metres in lb.park("Fenway Park").walls]
    [11.3, 11.3, 5.2, 1.5, 1.5]
    """
    elevations = {row["park"]: float(row["elevation"]) * FOOT for row in _rows(PARKS)}
    return tuple(
        Park(
            row["park"],
            row["formerly"],
            tuple(float(row[key]) * FOOT for key in _DISTANCES),
            tuple(float(row[key]) * FOOT for key in _WALLS),
            elevations[row["park"]],
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
        If no such park is known; the message names the nearest.

    Examples
    --------
    >>> import longball as lb
    >>> coors = lb.park("Coors Field")
    >>> f"{coors.distances[2]:.1f} m to centre, {coors.elevation:.0f} m above the sea"
    '126.5 m to centre, 1582 m above the sea'
    """
    known = {each.name: each for each in parks()}
    known |= {each.formerly: each for each in parks() if each.formerly}
    if name not in known:
        raise ValueError(f"park {name!r} is not known{one_of('the parks are', name, known)}")
    return known[name]


@dataclass(frozen=True)
class InPark:
    """A ball in a park: its result, and the quantities that people ask for."""

    park: Park
    result: Result

    @property
    def is_out(self) -> bool:
        """True if it is a home run."""
        return self.result.outcome == "home_run"

    @property
    def clearance(self) -> float | None:
        """m, above the top of the fence; negative at a wall; None if it does not get there."""
        fence = self.result.fence
        return None if fence is None else float(fence.clearance)


def in_parks(
    scene: object, where: Iterable[Park] | None = None, engine: Any = "ivp", **options: Any
) -> list[InPark]:
    """Solve a batted ball in every park.

    Parameters
    ----------
    scene
        A flight or an at-bat, as `solve` takes it. Its fence is replaced by each park's. If its
        density is a weather, that is at the park's elevation; a number stays what it is.
    where
        Parks; all that are known if left out.
    engine, options
        As of `solve`.

    Raises
    ------
    InvalidScene
        If `scene` describes no flight and no at-bat.

    Examples
    --------
    >>> import longball as lb
    >>> ball = lb.Flight(launch=lb.launch(speed=46.0, angle=0.49, direction=0.35))
    >>> found = lb.in_parks(ball)
    >>> sum(each.is_out for each in found), len(found)
    (5, 20)
    """
    asked = as_scene(scene)
    if not isinstance(asked, FlightScene | AtBatScene):
        raise InvalidScene(f"kind: must be 'flight' or 'at-bat' here, and is {asked.kind!r}")
    every: Sequence[Park] = parks() if where is None else tuple(where)
    results = solve_each([_in(one, asked) for one in every], as_engine(engine, options))
    return [InPark(one, result) for one, result in zip(every, results, strict=True)]


def _in(one: Park, scene: FlightScene | AtBatScene) -> Any:
    """Return the scene in a park."""
    data = scene.model_dump(mode="json", exclude_defaults=True) | {"kind": scene.kind}
    data["fence"] = one.fence.model_dump(mode="json", exclude_none=True)
    air = data.get("air")
    if isinstance(air, dict) and isinstance(air.get("density"), dict):
        data["air"] = air | {"density": air["density"] | {"elevation": one.elevation}}
    return as_scene(data)
