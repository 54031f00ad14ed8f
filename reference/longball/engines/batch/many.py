"""Many scenes in one call: as columns of numbers, or as a list of scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import compress
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ValidationError

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
from longball.engines.chain import DISCRETE, MODEL, PARTS, Model
from longball.model import quantities
from longball.model.air import BilinearLift, WindAbove
from longball.model.air import Table as AirTable
from longball.model.arrays import Array, Flags
from longball.model.readings import Reading
from longball.model.result import Outcome
from longball.model.scene import AtBatScene, FlightScene, ImpactScene, Scene

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
        (`longball.engines.chain.solve` says why); the quantities of the result, ``plate.time``,
        ``contact.normal[0]``, ``landing.distance``, …, NaN where there is none; and ``engine``, the
        description of what flew the ball.

    Raises
    ------
    ValueError
        If a name is not one of the scene's numbers, or a column is not one of n finite numbers.

    Notes
    -----
    The numbers of the columns are taken as they are. A scene that `longball.model.scene` would
    refuse is not looked for; it has an answer, or none.
    """
    n, view = _view(scene, columns)
    flyer = engine or _batch()
    if not _is_extended(scene):
        return _named(_solve(scene.kind, n, view, flyer, threads, model), flyer)
    table = Table(n)
    if _flies_in_lanes(scene):
        # What is zero is not computed: the rows of a law are those with the same zeros.
        kinds = np.zeros(n, np.int64)
        for zero in (np.asarray(column) == 0.0 for column in columns.values()):
            if zero.any() and not zero.all():
                _, kinds = np.unique(2 * kinds + zero, return_inverse=True)
        for kind in np.unique(kinds):
            some = kinds == kind
            rows = np.flatnonzero(some)
            part = _solve(scene.kind, len(rows), select(view, some), flyer, threads, model)
            table.outcome[rows] = part.outcome
            table.engines |= {int(rows[i]): engine for i, engine in part.engines.items()}
            for name, column in part.columns.items():
                table.put(name, rows, column)
    _solve_the_rest(table, scene, columns, flyer, model)
    return _named(table, flyer)


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
    if _is_extended(scene):
        balls = [quantities.replaced(scene, {"ball.restitution": e}) for e in restitutions]
        return [solve_columns(ball, columns, flyer, threads) for ball in balls]
    tables = [Table(n) for _ in restitutions]

    def solve_block(rows: slice) -> None:
        met = Table(rows.stop - rows.start)
        cases, contact = chain.meet_bat(_cases(met, select(view, rows), flyer))
        struck = cast(ManyCases, cases)
        for table, e in zip(tables, restitutions, strict=True):
            part = table.part(rows)
            part.copy_from(met)
            chain.finish(struck.with_restitution(e, part), contact)
            part.withdraw_what_is_not_finite()

    _in_blocks(solve_block, n, threads)
    return [_named(table, flyer) for table in tables]


def _is_extended(scene: Scene) -> bool:
    """Tell whether a ball flies under more than the paper's forces.

    Friction gives a batted ball a spin.
    """
    if isinstance(scene, ImpactScene) or scene.air is None:
        return False
    if isinstance(scene, AtBatScene) and scene.bat.friction is not None:
        return True
    thrown: Any = scene.launch if isinstance(scene, FlightScene) else scene.pitch
    air = scene.air
    further = (
        *(thrown.spin, None if isinstance(scene, FlightScene) else thrown.velocity),
        *(scene.earth, air.wind, air.spin_decay_length, air.density_scale_height),
    )
    laws = air.drag_coefficient, air.lift_coefficient, air.density
    return any(x is not None for x in further) or any(isinstance(x, BaseModel) for x in laws)


def _flies_in_lanes(scene: Scene) -> bool:
    """Tell whether the compiled code flies the balls of an extended scene."""
    if isinstance(scene, ImpactScene) or scene.air is None:
        return True
    air = scene.air
    pieces = (air.drag_coefficient, air.lift_coefficient, air.wind)
    smooth = not any(isinstance(x, AirTable | BilinearLift | WindAbove) for x in pieces)
    return smooth and air.spin_decay_length is None and scene.gravity > 0.0


def _solve_the_rest(
    table: Table, scene: Scene, columns: Mapping[str, ArrayLike], flyer: Any, model: Model
) -> None:
    """Solve the scenes that have no answer one at a time."""
    values = [np.asarray(column).tolist() for column in columns.values()]
    for i in np.flatnonzero(table.outcome == UNSOLVED).tolist():
        try:
            one = quantities.replaced(
                scene, {name: column[i] for name, column in zip(columns, values, strict=True)}
            )
        except ValidationError:
            continue  # no scene
        result = chain.solve(one, flyer, model)
        table.engines[i] = result.engine or ""
        if result.outcome is not None:
            table.outcome[i] = OUTCOMES.index(result.outcome)
        for name, value in quantities.flat(result.data()):
            if "." in name:  # of a block
                table.put(name, i, value)


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
        if name and not any(column.startswith(way) for column in columns):
            return value  # none of its numbers differs
        parts = {
            key: _with_columns(getattr(value, key), columns, way + key)
            for key in type(value).model_fields
        }
        return SimpleNamespace(**parts)
    if isinstance(value, tuple):
        return tuple(_with_columns(x, columns, f"{name}[{i}]") for i, x in enumerate(value))
    return columns.get(name, value)


def _named(table: Table, flyer: BatchFlyer) -> dict[str, NDArray[Any]]:
    names, engines = np.array([*OUTCOMES, ""]), np.full(len(table), flyer.description, object)
    for i, engine in table.engines.items():
        engines[i] = engine
    return {"outcome": names[table.outcome]} | table.columns | {"engine": engines}


def solve_as_data(scenes: Sequence[Scene], solver: Any, threads: int) -> list[dict[str, Any]]:
    """Return the results of scenes of any kinds, in order, as plain data."""
    alike: defaultdict[tuple[Any, ...], list[int]] = defaultdict(list)
    for i, scene in enumerate(scenes):
        alike[*_structure(scene), *_zeros(scene, i)].append(i)
    results: dict[int, dict[str, Any]] = {}
    for places in alike.values():
        if len(places) < FEW:
            results |= {i: chain.solve(scenes[i], solver).data() for i in places}
            continue
        same = [scenes[i] for i in places]
        _, view = _view(same[0], _columns_of(same))
        table = _solve(same[0].kind, len(places), view, solver, threads)
        for row, (i, (outcome, parts)) in enumerate(zip(places, _rows(table), strict=True)):
            if outcome is None:
                results[i] = chain.solve(scenes[i], solver).data()  # for the reason
            else:
                head = {"id": scenes[i].id, "outcome": outcome}
                engine = table.engines.get(row, solver.description)
                results[i] = {**head, **parts, "engine": engine}
    return [results[i] for i in range(len(scenes))]


def _structure(scene: Any) -> tuple[Any, ...]:
    """Return what scenes have in common that differ in nothing but their numbers."""
    # A block that a scene does not have takes long to be asked for.
    has = type(scene).model_fields
    names = ("bat", "incoming", "air", "fence")
    bat, incoming, air, fence = (getattr(scene, name) if name in has else None for name in names)
    support = bat and (bat.support, bat.friction is None, bat.tangential_restitution is None)
    spins = incoming is not None and incoming.spin is not None
    known = scene.ball.inertia_factor is None, air is None, support, spins
    return type(scene), scene.reading, fence, known


def _zeros(scene: Scene, place: int) -> tuple[Any, ...]:
    """Return which laws an extended scene names, and which of its numbers are zero.

    What is zero is not computed. A scene that the compiled code does not fly is alike no other.
    """
    if not _is_extended(scene):
        return ()
    if not _flies_in_lanes(scene):
        return (place,)
    air: Any = getattr(scene, "air", None)
    laws = (getattr(air, key, None) for key in ("drag_coefficient", "lift_coefficient"))
    zeros = ((name, value == 0.0) for name, value in quantities.numbers(scene))
    return *(getattr(law, "law", "") for law in laws), *zeros


def _columns_of(scenes: list[Scene]) -> dict[str, Array]:
    """Return the numbers of scenes of one structure."""
    columns: dict[str, Array] = {}
    for way in dict.fromkeys(name.partition("[")[0] for name, _ in quantities.numbers(scenes[0])):
        if way.startswith("fence."):
            continue  # the same in all
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
        chain.CHAINS[kind](_cases(part, select(view, rows), flyer, model))
        part.withdraw_what_is_not_finite()

    _in_blocks(solve_block, count, threads)
    return table


def _in_blocks(solve_block: Callable[[slice], None], count: int, threads: int) -> None:
    """Call a function for each block of rows, from several threads."""

    def quietly(start: int) -> None:
        with np.errstate(all="ignore"):  # what overflows is withdrawn
            solve_block(slice(start, min(start + BLOCK, count)))

    starts = range(0, count, BLOCK)
    if threads == 1 or len(starts) == 1:
        for start in starts:
            quietly(start)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(quietly, starts))


def _rows(table: Table) -> Iterator[tuple[Outcome | None, dict[str, Any]]]:
    """Yield the table's rows as outcomes (None: no answer) and parts of results."""
    found: dict[str, dict[str, list[Array]]] = {
        name: {key: [] for key in block.model_fields} for name, block in PARTS.items()
    }
    for name, column in table.columns.items():
        part, _, quantity = name.partition("[")[0].rpartition(".")
        found[part][quantity].append(column)
    parts = {
        name: _part(name, {key: columns for key, columns in block.items() if columns})
        for name, block in found.items()
        if any(block.values())
    }
    for i, outcome in enumerate(table.outcome.tolist()):
        known = {name: row for name, rows in parts.items() if (row := rows[i])}
        for name in [name for name in known if "." in name]:
            whole, _, key = name.rpartition(".")
            known[whole][key] = known.pop(name)
        yield None if outcome == UNSOLVED else OUTCOMES[outcome], known


def _known(column: NDArray[Any]) -> Flags:
    found: Flags = np.isfinite(column) if column.dtype == float else column != ""
    return found


def _part(name: str, columns_of: dict[str, list[Array]]) -> list[dict[str, Any]]:
    """Return a part of each row's result: what it has of its quantities."""
    known = zip(*(_known(columns[0]).tolist() for columns in columns_of.values()), strict=True)
    values = zip(
        *(
            zip(*(column.tolist() for column in columns), strict=True)
            if len(columns) > 1
            else _values(f"{name}.{key}", columns[0])
            for key, columns in columns_of.items()
        ),
        strict=True,
    )
    return [
        dict(compress(zip(columns_of, row, strict=True), there))
        for row, there in zip(values, known, strict=True)
    ]


def _values(name: str, column: NDArray[Any]) -> list[Any]:
    """Return the values of a quantity, whose columns hold doubles even if it is none."""
    values: list[Any] = column.tolist()
    kind = DISCRETE.get(name)
    return [x if x != x else kind(x) for x in values] if kind else values
