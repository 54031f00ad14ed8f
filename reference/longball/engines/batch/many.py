"""Many scenes in one call: as columns of numbers, or as a list of scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import compress
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel

from longball.engines import chain, create
from longball.engines.batch.columns import (
    OUTCOMES,
    UNSOLVED,
    BatchFlyer,
    Columns,
    ManyCases,
    Table,
    select,
)
from longball.engines.chain import BLOCKS, MODEL, Model
from longball.model import quantities
from longball.model.readings import Reading
from longball.model.result import Outcome, Result
from longball.model.scene import AtBatScene, Scene

Array = NDArray[np.float64]

# Scenes that a thread takes at a time: NumPy's calls on them then cost a tenth of the work.
BLOCK = 16_384
# Fewer scenes of a kind are solved one by one in less time than the calls of NumPy take.
FEW = 16


def solve_columns(
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    engine: BatchFlyer | None = None,
    threads: int = 1,
    model: Model = MODEL,
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
        (`longball.engines.chain.solve` says why); and the quantities of the result,
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
    n, view = _view(scene, columns)
    return _named(_solve(scene.kind, n, view, engine or _batch(), threads, model))


def solve_columns_with_restitutions(
    scene: AtBatScene,
    columns: Mapping[str, ArrayLike],
    restitutions: Sequence[float],
    engine: BatchFlyer | None = None,
    threads: int = 1,
) -> list[dict[str, NDArray[Any]]]:
    """Solve at-bats with balls that differ in restitution: a table as of `solve_columns` for each.

    The pitches and their touching of the bat, which do not depend on it, are solved once.
    """
    n, view = _view(scene, columns)
    flyer = engine or _batch()
    tables = [Table(n) for _ in restitutions]

    def solve_block(rows: slice) -> None:
        met = Table(rows.stop - rows.start)
        cases, meeting = chain.meet_bat(_cases(met, _rows_of(view, rows), flyer))
        struck = cast(ManyCases, cases)
        for table, e in zip(tables, restitutions, strict=True):
            part = table.part(rows)
            part.copy_from(met)
            chain.finish(struck.with_restitution(e, part), meeting)
            part.withdraw_what_is_not_finite()

    _in_blocks(solve_block, n, threads)
    return [_named(table) for table in tables]


def _batch() -> BatchFlyer:
    flyer: Any = create("batch")  # which flies for these functions, and knows them
    return cast(BatchFlyer, flyer)


def _cases(table: Table, view: SimpleNamespace, flyer: BatchFlyer, model: Model = MODEL) -> Any:
    return ManyCases(view, Columns(flyer), model, table, np.arange(len(table)))


def _view(scene: Scene, columns: Mapping[str, ArrayLike]) -> tuple[int, SimpleNamespace]:
    """Return how many scenes there are, and one whose numbers are their columns."""
    names = [name for name, _ in quantities.numbers(scene)]
    n = max((np.size(column) for column in columns.values()), default=1)
    known: dict[str, Array] = {}
    for name, column in columns.items():
        if name not in names:
            raise quantities.unknown(name, names)
        if np.shape(column) != (n,) or not np.isfinite(column).all():
            raise ValueError(f"{name} must have {n} finite numbers, as the longest column has")
        known[name] = np.array(column, np.float64)
    view: SimpleNamespace = _with_columns(scene, known, "")
    if hasattr(scene, "ground"):
        view.ground = _with_columns(scene.ground, known, "ground")  # of a pitch: the model's
    return n, view


def _with_columns(value: Any, columns: Mapping[str, Array], name: str) -> Any:
    """Return a part of a scene with columns for those of its numbers that have them."""
    if isinstance(value, Reading):
        return value
    if isinstance(value, BaseModel):
        way = f"{name}." if name else ""
        parts = {
            key: _with_columns(getattr(value, key), columns, way + key)
            for key in type(value).model_fields
        }
        return SimpleNamespace(**parts)
    if isinstance(value, tuple):
        return tuple(_with_columns(x, columns, f"{name}[{i}]") for i, x in enumerate(value))
    return columns.get(name, value)


def _rows_of(view: SimpleNamespace, rows: slice) -> Any:
    return select(view, rows)


def _named(table: Table) -> dict[str, NDArray[Any]]:
    names = np.array([*OUTCOMES, ""])
    return {"outcome": names[table.outcome]} | table.columns


def solve_all(
    scenes: Iterable[Scene], engine: BatchFlyer | None = None, threads: int = 1
) -> list[Result]:
    """Return the results of scenes of any kinds, in order, as `longball.engines.chain.solve`."""
    solver: Any = engine or _batch()
    scenes = list(scenes)
    alike: defaultdict[tuple[Any, ...], list[int]] = defaultdict(list)
    for i, scene in enumerate(scenes):
        alike[_structure(scene)].append(i)
    results: dict[int, Result] = {}
    for places in alike.values():
        if len(places) < FEW:
            results |= {i: chain.solve(scenes[i], solver) for i in places}
            continue
        same = [scenes[i] for i in places]
        _, view = _view(same[0], _columns_of(same))
        table = _solve(same[0].kind, len(places), view, solver, threads)
        for i, (outcome, parts) in zip(places, _rows(table), strict=True):
            if outcome is None:
                results[i] = chain.solve(scenes[i], solver)  # for the reason
            else:
                results[i] = Result(
                    id=scenes[i].id, outcome=outcome, engine=solver.description, **parts
                )
    return [results[i] for i in range(len(scenes))]


def _structure(scene: Any) -> tuple[Any, ...]:
    """Return what scenes have in common that differ in nothing but their numbers."""
    bat, incoming = getattr(scene, "bat", None), getattr(scene, "incoming", None)
    named = (
        (scene.ball, "inertia_factor"),
        (scene, "air"),
        (bat, "friction"),
        (bat, "tangential_restitution"),
        (incoming, "spin"),
    )
    absent = tuple(getattr(block, key, None) is None for block, key in named)
    return type(scene), scene.reading, getattr(bat, "support", None), absent


def _columns_of(scenes: list[Scene]) -> dict[str, Array]:
    """Return the numbers of scenes of one structure."""
    columns: dict[str, Array] = {}
    for way in dict.fromkeys(name.partition("[")[0] for name, _ in quantities.numbers(scenes[0])):
        values = np.array([*map(attrgetter(way), scenes)], np.float64)
        if values.ndim == 1:
            columns[way] = values
        else:
            columns |= {f"{way}[{i}]": values[:, i] for i in range(values.shape[1])}
    return columns


def _solve(
    kind: str,
    count: int,
    view: SimpleNamespace,
    flyer: BatchFlyer,
    threads: int,
    model: Model = MODEL,
) -> Table:
    """Solve columns in blocks, each by one thread."""
    table = Table(count)

    def solve_block(rows: slice) -> None:
        part = table.part(rows)
        chain.CHAINS[kind](_cases(part, _rows_of(view, rows), flyer, model))
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


def _rows(table: Table) -> Iterator[tuple[Outcome | None, dict[str, Any]]]:
    """Yield the table's rows as outcomes (None: no answer) and parts of results."""
    found: dict[str, dict[str, list[Array]]] = {block: {} for block in BLOCKS}
    for name, column in table.columns.items():
        part, quantity = name.partition("[")[0].split(".")
        found[part].setdefault(quantity, []).append(column)
    parts = {name: _part(name, columns) for name, columns in found.items() if columns}
    for i, outcome in enumerate(table.outcome.tolist()):
        known = {name: rows[i] for name, rows in parts.items()}
        yield None if outcome == UNSOLVED else OUTCOMES[outcome], known


def _known(column: NDArray[Any]) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = np.isfinite(column) if column.dtype == float else column != ""
    return found


def _part(name: str, columns_of: dict[str, list[Array]]) -> list[Any]:
    """Return a part of each row's result, or None where the row has none of its columns_of."""
    known = zip(*(_known(columns[0]).tolist() for columns in columns_of.values()), strict=True)
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
        BLOCKS[name](**dict(compress(zip(columns_of, row, strict=True), there)))
        if any(there)
        else None
        for row, there in zip(values, known, strict=True)
    ]
