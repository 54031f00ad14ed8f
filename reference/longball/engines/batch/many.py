"""Many scenes in one call: as columns of numbers, or as a list of scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import compress
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longball.engines.at_bat import solve
from longball.engines.batch import chain
from longball.engines.batch.chain import OUTCOMES, UNSOLVED, Fleet, Table, at_rows
from longball.engines.batch.engine import Batch
from longball.model import quantities
from longball.model import result as written
from longball.model.readings import Reading
from longball.model.result import Outcome, Result
from longball.model.scene import Air, AtBatScene, FlightScene, ImpactScene, PitchScene, Scene

Array = NDArray[np.float64]

# Scenes that a thread takes at a time: their columns stay in a core's own cache, and the calls of
# NumPy on them cost a tenth of their work.
BLOCK = 4096
# Fewer scenes of a kind are solved one by one in less time than the calls of NumPy take.
FEW = 16

_CHAINS: dict[type[Any], Callable[[Table, chain.Columns, Reading, Fleet], None]] = {
    FlightScene: chain.solve_flights,
    PitchScene: chain.solve_pitches,
    ImpactScene: chain.solve_impacts,
    AtBatScene: chain.solve_at_bats,
}


def solve_columns(
    scene: Scene, columns: Mapping[str, ArrayLike], engine: Fleet | None = None, threads: int = 1
) -> dict[str, NDArray[Any]]:
    """Solve many scenes that differ from one in some of their numbers.

    Parameters
    ----------
    scene
        Says what is the same in all.
    columns
        Arrays of shape (n,) under the names of what differs: ``pitch.speed``, ``pitch.aim[0]``,
        ``swing.height_offset``, ``ball.restitution``, ``launch.velocity[2]``, …
    threads
        Of this process. Neither their number nor the order of the scenes changes a bit.

    Returns
    -------
    dict of str to array
        Columns of shape (n,): ``outcome``, a string, empty where the scene has no answer
        (`longball.engines.at_bat.solve` says why); and the quantities of the result,
        ``plate.time``, ``contact.normal[0]``, ``landing.distance``, …, NaN where there is none.

    Raises
    ------
    ValueError
        If a name is not one of the scene's numbers, or a column is not one of n finite numbers.

    Notes
    -----
    The numbers of the columns are taken as they are; a scene that `longball.model.scene` would
    refuse is not found out.
    """
    n, whole = _columns(scene, columns)
    table = _solve(type(scene), n, whole, scene.reading, engine or Batch(), threads)
    return _named(table)


def solve_columns_with_restitutions(
    scene: AtBatScene,
    columns: Mapping[str, ArrayLike],
    restitutions: Sequence[float],
    engine: Batch | None = None,
    threads: int = 1,
) -> list[dict[str, NDArray[Any]]]:
    """Solve at-bats with balls that differ in restitution: a table as of `solve_columns` for each.

    The pitches and their touching of the bat, which do not depend on it, are solved once.
    """
    n, whole = _columns(scene, columns)
    engine = engine or Batch()
    tables = [Table(n) for _ in restitutions]

    def solve_block(rows: slice) -> None:
        c, met = at_rows(whole, rows), Table(rows.stop - rows.start)
        blows = chain.meet_at_bats(met, c, scene.reading, engine)
        for table, e in zip(tables, restitutions, strict=True):
            part = table.part(rows)
            part.copy_from(met)
            struck = c | {"ball.restitution": e}
            chain.finish_at_bats(part, blows, struck, scene.reading, engine)
            part.withdraw_what_is_not_finite()

    _in_blocks(solve_block, n, threads)
    return [_named(table) for table in tables]


def _columns(scene: Scene, columns: Mapping[str, ArrayLike]) -> tuple[int, dict[str, Any]]:
    """Return how many scenes there are, and all of their numbers."""
    base = numbers_of(scene)
    n = max((np.size(column) for column in columns.values()), default=1)
    for name, column in columns.items():
        if name not in base:
            raise quantities.unknown(name, base)
        if np.shape(column) != (n,) or not np.isfinite(column).all():
            raise ValueError(f"{name} must have {n} finite numbers, as the longest column has")
    whole: dict[str, Any] = dict(base)
    whole |= {name: np.array(column, np.float64) for name, column in columns.items()}
    return n, whole


def _named(table: Table) -> dict[str, NDArray[Any]]:
    names = np.array([*OUTCOMES, ""])
    return {"outcome": names[table.outcome]} | table.columns


def solve_all(
    scenes: Iterable[Scene], engine: Batch | None = None, threads: int = 1
) -> list[Result]:
    """Return the results of scenes of any kinds, in order, as `longball.engines.at_bat.solve`."""
    engine = engine or Batch()
    scenes = list(scenes)
    alike: defaultdict[tuple[Any, ...], list[int]] = defaultdict(list)
    for i, scene in enumerate(scenes):
        alike[type(scene), scene.reading, getattr(scene, "air", None) is None].append(i)
    results: dict[int, Result] = {}
    for (kind, reading, _), places in alike.items():
        if len(places) < FEW:
            results |= {i: solve(scenes[i], engine) for i in places}
            continue
        columns = _columns_of([scenes[i] for i in places])
        table = _solve(kind, len(places), columns, reading, engine, threads)
        for i, (outcome, parts) in zip(places, _rows(table), strict=True):
            if outcome is None:
                results[i] = solve(scenes[i], engine)  # for the reason
            else:
                results[i] = Result(
                    id=scenes[i].id, outcome=outcome, engine=engine.description, **parts
                )
    return [results[i] for i in range(len(scenes))]


def _columns_of(scenes: list[Scene]) -> dict[str, Array]:
    """Return the numbers of scenes of one kind, all of them with air or all without."""
    columns: dict[str, Any] = numbers_of(scenes[0])
    has_air = getattr(scenes[0], "air", None) is not None
    ways = (name.partition("[")[0] for name in columns)
    for way in list(dict.fromkeys(ways)):
        if way.startswith("air.") and not has_air:
            continue
        values = np.array([*map(attrgetter(way), scenes)], np.float64)
        if values.ndim == 1:
            columns[way] = values
        else:
            columns |= {f"{way}[{i}]": values[:, i] for i in range(values.shape[1])}
    return columns


def numbers_of(scene: Scene) -> dict[str, float]:
    """Return the numbers of a scene, named by the way to them; no air has the density 0."""
    found = {name: float(x) for name, x in quantities.numbers(scene)}
    if getattr(scene, "air", ...) is None:
        found |= {f"air.{key}": 0.0 for key in Air.model_fields}
    return found


def _solve(
    kind: type[Any],
    count: int,
    columns: chain.Columns,
    reading: Reading,
    engine: Fleet,
    threads: int,
) -> Table:
    """Solve columns in blocks, each by one thread."""
    table = Table(count)

    def solve_block(rows: slice) -> None:
        part = table.part(rows)
        _CHAINS[kind](part, at_rows(columns, rows), reading, engine)
        part.withdraw_what_is_not_finite()

    _in_blocks(solve_block, count, threads)
    return table


def _in_blocks(solve_block: Callable[[slice], None], count: int, threads: int) -> None:
    """Call a function for each block of rows, from several threads."""

    def quietly(start: int) -> None:
        with np.errstate(all="ignore"):  # what overflows is withdrawn
            solve_block(slice(start, min(start + BLOCK, count)))

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(quietly, range(0, count, BLOCK)))


_PARTS: dict[str, type[Any]] = {
    "plate": written.Plate,
    "contact": written.Contact,
    "impact": written.Impact,
    "landing": written.Landing,
}


def _rows(table: Table) -> Iterator[tuple[Outcome | None, dict[str, Any]]]:
    """Yield the table's rows as outcomes (None: no answer) and parts of results."""
    found: dict[str, dict[str, list[Array]]] = {part: {} for part in _PARTS}
    for name, column in table.columns.items():
        part, quantity = name.partition("[")[0].split(".")
        found[part].setdefault(quantity, []).append(column)
    parts = {name: _part(name, columns) for name, columns in found.items() if columns}
    for i, outcome in enumerate(table.outcome.tolist()):
        known = {name: rows[i] for name, rows in parts.items()}
        yield None if outcome == UNSOLVED else OUTCOMES[outcome], known


def _part(name: str, columns_of: dict[str, list[Array]]) -> list[Any]:
    """Return a part of each row's result, or None where the row has none of its columns_of."""
    known = zip(*(np.isfinite(columns[0]).tolist() for columns in columns_of.values()), strict=True)
    values = zip(
        *(
            zip(*(column.tolist() for column in columns), strict=True)
            if len(columns) > 1
            else columns[0].tolist()
            for columns in columns_of.values()
        ),
        strict=True,
    )
    return [
        _PARTS[name](**dict(compress(zip(columns_of, row, strict=True), there)))
        if any(there)
        else None
        for row, there in zip(values, known, strict=True)
    ]
