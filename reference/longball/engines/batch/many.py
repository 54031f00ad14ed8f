"""Many scenes in one call: as columns of numbers, or as a list of scenes."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from dataclasses import dataclass
from itertools import compress, pairwise
from operator import attrgetter
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError

from longball.engines import chain
from longball.engines.batch import flights, records
from longball.engines.batch.columns import (
    NUMBERS,
    OUTCOMES,
    UNSOLVED,
    BatchFlyer,
    Columns,
    Table,
    joined,
)
from longball.engines.batch.flights import Records
from longball.engines.chain import DISCRETE, MODEL, PARTS, Model
from longball.engines.engine import ManyAtOnce
from longball.engines.ivp import Ivp
from longball.model import quantities
from longball.model.arrays import Array
from longball.model.frame import Frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES
from longball.model.result import Outcome
from longball.model.scene import AtBatScene, FlightScene, ImpactScene, Scene
from longball.model.trace import Program

# Scenes that a thread takes at a time: NumPy's calls on them then cost a tenth of the work.
BLOCK = 16_384  # a free choice
# The engine of what the compiled code leaves: laws with switches, grazes, balls that come to rest.
SCALAR = Ivp()

# Range of the tolerance, m. Looser ones save no time; tighter ones are below rounding.
LOOSEST, TIGHTEST = 1e-4, 1e-14


@dataclass(frozen=True)
class Batch(ManyAtOnce):
    """Flights by compiled Taylor series, sixteen scenes at once.

    A scene has the same bits alone and among others. The engine ivp solves the scenes that the
    compiled code leaves, and follows the path of a ball; a result names the engine that solved it.

    Attributes
    ----------
    tolerance
        Error of a landing up to 200 m away that truncation may cause, m, from 1e-4 to 1e-14.
        Rounding adds about 1e-13 m there.
    """

    tolerance: float = 1e-13

    numbers = DOUBLES
    alone = SCALAR

    def __post_init__(self) -> None:
        if not TIGHTEST <= self.tolerance <= LOOSEST:
            raise ValueError(
                f"tolerance = {self.tolerance} m is not between {TIGHTEST} and {LOOSEST}"
            )

    @property
    def truncation(self) -> float:
        """Size of the last terms of the velocity in a step, relative to the speed."""
        # With this factor, the landings of 400 launches at 3° to 88° were wrong by at most a fourth
        # of the tolerance, or by 4e-14 m where rounding dominates.
        return 0.01 * self.tolerance  # a free choice

    @property
    def order(self) -> int:
        """Order of the series."""
        # A step of order N costs N², and its length is proportional to truncation^(1/N): the
        # optimum is -ln(truncation)/2. The fixed cost of a step raises it a little.
        return round(-0.5 * math.log(self.truncation)) + 5

    @property
    def description(self) -> str:
        """Name and tolerance."""
        return f"batch tolerance={self.tolerance:g}"

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight."""
        # Measured in 34 digits on 400 launches: positions are wrong by up to 11 truncations (in
        # metres, or relative), velocities by a fourth of one, and both by 3 half ulps where
        # rounding dominates.
        return 20 * max(self.truncation, DOUBLES.rounding)

    def solve_as_data(self, scenes: Sequence[Scene], threads: int = 1) -> list[dict[str, Any]]:
        """Return the results of scenes of any kinds, in order, as plain data."""
        alike: defaultdict[Any, list[int]] = defaultdict(list)
        for i, scene in enumerate(scenes):
            alike[_structure(scene)].append(i)
        results: dict[int, dict[str, Any]] = {}
        for places in alike.values():
            same = [scenes[i] for i in places]
            solved: Sequence[dict[str, Any] | None] = [None] * len(same)
            if _flies_in_lanes(same[0], MODEL):  # then there are no tables of different lengths
                solved = solve_columns_as_data(same[0], _columns_of(same), self, threads)
            for i, data in zip(places, solved, strict=True):
                # The scalar chain solves the rows that are left, or gives the reason for no answer.
                results[i] = data or chain.solve(scenes[i], SCALAR).data()
                results[i]["id"] = scenes[i].id
        return [results[i] for i in range(len(scenes))]

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records of `flights.flight_dtype`; return their arrivals, in order."""
        # Flights past a bat take a hundredth of a second: a lower order is enough for one step.
        near_bat = starts.size > 0 and starts["reach"].item(0) > 0.0
        order = max(8, 2 * self.order // 5) if near_bat else self.order
        return flights.fly_all(program, starts, order, self.truncation)


# --- columns --------------------------------------------------------------------------------------


def solve_columns(
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    engine: BatchFlyer | None = None,
    threads: int = 1,
    model: Model = MODEL,
) -> dict[str, NDArray[Any]]:
    """Solve many scenes that differ from one in some of their numbers.

    The `columns` are arrays of shape (n,) by name: ``pitch.speed``, ``pitch.aim[0]``, … Neither
    their order nor the number of threads changes a bit. Columns are not validated as scenes: an
    invalid row may have an answer, or none.

    Returns columns of shape (n,): ``outcome``, a string, empty if the scene has no answer
    (`longball.engines.chain.solve` gives the reason); the quantities of the result,
    ``plate.time``, ``contact.normal[0]``, ``landing.distance``, …, NaN if absent; and ``engine``,
    the description of the engine that flew the ball.

    Raises `ValueError` if a name is not one of the scene's numbers, or a column is not one of n
    finite numbers.
    """
    flyer, known = engine or Batch(), _checked(scene, columns)
    table = _solve(scene, known, flyer, threads, model)
    return _named(table, scene, known, flyer, model)


def solve_decided_columns(
    scene: Scene, columns: Mapping[str, ArrayLike], engine: BatchFlyer | None = None
) -> dict[str, NDArray[Any]]:
    """Solve columns as `solve_columns` does, without an outcome for undecided rows.

    `solve_columns` leaves them to the scalar engine, which decides some and takes a thousand times
    as long. A root search for a graze ends among such rows, and does not need them.
    """
    if not _flies_in_lanes(scene, MODEL):
        return solve_columns(scene, columns, engine)
    flyer = engine or Batch()
    table = _solve(scene, _checked(scene, columns), flyer, 1)
    return _by_name(table, np.full(len(table), flyer.description, object))


@dataclass(frozen=True)
class Slopes:
    """Derivatives in columns."""

    # Of each quantity by the inputs, in order, shape (inputs, n); NaN if absent
    columns: dict[str, Array]
    alone: list[int]  # rows whose derivatives are from the engine ivp
    refused: dict[int, Mapping[str, str]]  # reasons for missing derivatives, by row and input


def solve_columns_with_slopes(
    scene: Scene,
    columns: Mapping[str, ArrayLike],
    names: Sequence[str],
    engine: Any = None,
    threads: int = 1,
) -> tuple[dict[str, NDArray[Any]], Slopes]:
    """Solve columns as `solve_columns` does, with their derivatives by inputs of the scene.

    `longball.model.inputs` defines the names of the inputs. `longball.engines.tangent` computes the
    rows in which the compiled code has no derivative, or a derivative may not exist.
    """
    from longball.engines.batch import slopes  # brings ball arithmetic
    from longball.engines.tangent import derivatives_of

    flyer = engine or Batch()
    known = _checked(scene, columns)

    def solve_block(rows: int, cells: Mapping[str, Array]) -> list[Table]:
        view = chain.view_of(scene, slopes.seeded_columns(scene, cells, names))
        run = slopes.SlopeColumns(view, flyer, MODEL, table=Table(rows), inputs=len(names))
        chain.CHAINS[scene.kind](run)
        run.table.withdraw_what_is_not_finite()
        run.conclude_doubt()
        return [run.table, run.slopes]

    table, derived = _in_blocks(solve_block, scene, known, threads, tables=2)
    table.alone |= table.outcome == UNSOLVED
    derived.alone |= table.alone
    results = _named(table, scene, known, flyer)

    # the rows whose derivatives the compiled code does not know, one by one
    alone = np.flatnonzero(derived.alone & (table.outcome != UNSOLVED)).tolist()
    refused = {}
    for i in alone:
        cells = {name: column.item(i) for name, column in known.items()}
        there = [
            name
            for name, column in table.columns.items()
            if column.dtype == float and np.isfinite(column[i]) and name not in DISCRETE
        ]
        one = derivatives_of(quantities.replaced(scene, cells), there, names, SCALAR)
        for quantity, by in one.items():
            slopes_of = derived.column(quantity, np.empty((len(names), 1)))
            slopes_of[:, i] = [by[name] for name in names]
        if one.refused:
            refused[i] = one.refused
    return results, Slopes(derived.columns, alone, refused)


def solve_columns_with_restitutions(
    scene: AtBatScene,
    columns: Mapping[str, ArrayLike],
    restitutions: Sequence[float],
    engine: BatchFlyer | None = None,
    threads: int = 1,
) -> list[dict[str, NDArray[Any]]]:
    """Solve at-bats for several restitutions; return a table of `solve_columns` for each.

    Pitches and contacts do not depend on the restitution, and are solved once.
    """
    flyer, known = engine or Batch(), _checked(scene, columns)
    balls = [quantities.replaced(scene, {"ball.restitution": e}) for e in restitutions]

    def solve_block(rows: int, cells: Mapping[str, Array]) -> list[Table]:
        met = Table(rows)
        contact = chain.meet_bat(Columns(chain.view_of(scene, cells), flyer, MODEL, table=met))
        tables = [deepcopy(met) for _ in balls]
        for ball, table in zip(balls, tables, strict=True):
            chain.finish(Columns(chain.view_of(ball, cells), flyer, MODEL, table=table), contact)
            table.withdraw_what_is_not_finite()
        return tables

    tables = _in_blocks(solve_block, scene, known, threads, tables=len(balls))
    return [_named(t, ball, known, flyer) for ball, t in zip(balls, tables, strict=True)]


def _checked(scene: Scene, columns: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """Return columns as arrays; check their names and lengths."""
    names = [name for name, _ in quantities.numbers(scene)]
    n = max((np.size(column) for column in columns.values()), default=1)
    for name, column in columns.items():
        if name not in names:
            raise quantities.unknown(name, names)
        if np.shape(column) != (n,) or not np.isfinite(column).all():
            raise ValueError(f"{name} must have {n} finite numbers, as the longest column has")
    return {name: np.array(column, np.float64) for name, column in columns.items()}


def _named(
    table: Table,
    scene: Scene,
    columns: Mapping[str, Array],
    flyer: BatchFlyer,
    model: Model = MODEL,
) -> dict[str, NDArray[Any]]:
    """Return a table as columns by name; solve the rows left to the scalar chain."""
    engines = np.full(len(table), flyer.description, object)
    for i in np.flatnonzero(table.alone).tolist():
        try:
            cells = {name: column.item(i) for name, column in columns.items()}
            result = chain.solve(quantities.replaced(scene, cells), SCALAR, model)
        except ValidationError:
            continue  # an invalid row has no answer
        engines[i] = result.engine
        # Those of blocks; id, outcome and error have no dot in their names.
        numbers = {name: x for name, x in quantities.flat(result.data()) if "." in name}
        table.write(i, numbers | ({"outcome": result.outcome} if result.outcome else {}))
    return _by_name(table, engines)


def _by_name(table: Table, engines: NDArray[Any]) -> dict[str, NDArray[Any]]:
    names = np.array([*OUTCOMES, ""])
    return {"outcome": names[table.outcome]} | table.columns | {"engine": engines}


def solve_columns_as_data(
    scene: Scene, columns: Mapping[str, Array], solver: Any, threads: int = 1
) -> list[dict[str, Any] | None]:
    """Return the results of columns as plain data without ids; None for a row without an answer."""
    return [
        None
        if outcome is None
        else {"id": None, "outcome": outcome, **parts, "engine": solver.description}
        for outcome, parts in _rows(_solve(scene, columns, solver, threads))
    ]


def _structure(scene: Scene) -> tuple[Any, ...]:
    """Return a hashable structure, equal for scenes that differ only in their numbers."""
    # Only optional blocks and keys are checked, because checking all would double the time.
    block = scene.__dict__.get
    bat: Any = block("bat")
    thrown: Any = block("launch") or block("pitch") or block("incoming")
    given = [block("earth"), scene.ball.inertia_factor, thrown.spin, thrown.velocity]
    if bat is not None:
        given += [bat.support, bat.friction, bat.tangential_restitution]
    known = [value if isinstance(value, str) else value is None for value in given]
    return type(scene), scene.reading, block("fence"), *known, _form(block("air"))


def _form(part: Any) -> Any:
    """Return a part of a scene with types in place of its numbers."""
    if type(part) in (float, tuple, NoneType):
        return type(part)
    return part if isinstance(part, str) else (type(part), *map(_form, part.__dict__.values()))


def _columns_of(scenes: list[Scene]) -> dict[str, Array]:
    """Return the numbers of scenes of one structure."""
    columns: dict[str, Array] = {}
    names = (name.partition("[")[0] for name, _ in quantities.numbers(scenes[0]))
    for quantity in dict.fromkeys(names):
        if quantity.startswith("fence."):
            continue  # part of the structure
        values = np.array([*map(attrgetter(quantity), scenes)], np.float64)
        if values.ndim == 1:
            columns[quantity] = values
        else:
            columns |= {f"{quantity}[{i}]": values[:, i] for i in range(values.shape[1])}
    return columns


def _solve(
    scene: Scene,
    columns: Mapping[str, Array],
    flyer: BatchFlyer,
    threads: int,
    model: Model = MODEL,
) -> Table:
    """Solve columns, except the rows left to the scalar chain."""

    def solve_block(rows: int, cells: Mapping[str, Array]) -> list[Table]:
        table = Table(rows)
        chain.CHAINS[scene.kind](Columns(chain.view_of(scene, cells), flyer, model, table=table))
        table.withdraw_what_is_not_finite()
        return [table]

    (table,) = _in_blocks(solve_block, scene, columns, threads, model)
    return table


def _flies_in_lanes(scene: Any, model: Model) -> bool:
    """True if the compiled code supports the laws of motion of a scene."""
    if isinstance(scene, ImpactScene):
        return True
    # With friction, the batted ball has a spin in any direction.
    rubbed = isinstance(scene, AtBatScene) and scene.bat.friction is not None
    thrown = scene.launch if isinstance(scene, FlightScene) else scene.pitch
    frame = Frame(0.0, 0.0, 1.0, 0.0, (1.0, 1.0, 1.0) if rubbed else thrown.spin)
    with np.errstate(all="ignore"):  # a scene may overflow
        return records.flies_in_lanes(law_of(scene, frame, NUMBERS, model.forces))


# Numbers of a scene that become strengths of the law of motion, in the frame of the ball's heading.
_OF_LAW = re.compile(r"air\.|earth\.|gravity|bat\.friction|\w+\.spin\[|launch\.velocity|pitch\.")


def _in_blocks(
    solve_block: Callable[[int, Mapping[str, Array]], list[Table]],  # of some rows
    scene: Scene,
    columns: Mapping[str, Array],
    threads: int,
    model: Model = MODEL,
    tables: int = 1,  # that `solve_block` returns
) -> list[Table]:
    """Solve columns block by block, by several threads; return the whole tables.

    Terms with strength zero are not in a law. All rows of a block therefore have zeros in the same
    strengths.
    """
    n = max(map(len, columns.values()), default=1)
    if n == 0 or not _flies_in_lanes(scene, model):
        none = [Table(n) for _ in range(tables)]
        for table in none:
            table.alone[:] = True
        return none

    # the rows in order of their zeros
    kinds = np.zeros(n, np.int64)
    for zero in (column == 0.0 for name, column in columns.items() if _OF_LAW.match(name)):
        if zero.any() and not zero.all():
            _, kinds = np.unique(2 * kinds + zero, return_inverse=True)
    order = np.argsort(kinds, kind="stable") if kinds.any() else None

    # blocks of rows with the same zeros
    if order is not None:
        kinds = kinds[order]
    edges = [0, *(1 + np.flatnonzero(np.diff(kinds))).tolist(), n]
    blocks = [
        slice(start, min(start + BLOCK, end))
        for begin, end in pairwise(edges)
        for start in range(begin, end, BLOCK)
    ]
    places = blocks if order is None else [order[rows] for rows in blocks]

    def quietly(rows: slice, place: Any) -> list[Table]:
        # Overflows are removed from the table afterwards.
        with np.errstate(all="ignore"):
            cells = {name: column[place] for name, column in columns.items()}
            return solve_block(rows.stop - rows.start, cells)

    if threads == 1 or len(blocks) == 1:
        solved = [*map(quietly, blocks, places)]
    else:
        with ThreadPoolExecutor(threads) as pool:
            solved = [*pool.map(quietly, blocks, places)]
    return [joined(parts, places) for parts in zip(*solved, strict=True)]


def _rows(table: Table) -> Iterator[tuple[Outcome | None, dict[str, Any]]]:
    """Yield the table's rows as outcomes (None: no answer) and parts of results."""
    blocks: dict[str, dict[str, list[Array]]] = {
        name: {key: [] for key in block.model_fields} for name, block in PARTS.items()
    }
    for name, column in table.columns.items():
        part, _, quantity = name.partition("[")[0].rpartition(".")
        blocks[part][quantity].append(column)
    parts = {
        name: _part(name, {key: columns for key, columns in block.items() if columns})
        for name, block in blocks.items()
        if any(block.values())
    }
    for i, outcome in enumerate(table.outcome.tolist()):
        known = {name: row for name, rows in parts.items() if (row := rows[i])}
        for name in [name for name in known if "." in name]:
            whole, _, key = name.rpartition(".")
            known[whole][key] = known.pop(name)
        yield None if outcome == UNSOLVED else OUTCOMES[outcome], known


def _part(name: str, columns_of: dict[str, list[Array]]) -> list[dict[str, Any]]:
    """Return a part of each row's result, with the quantities that are not NaN."""
    known: list[list[bool]] = []
    values: list[list[Any]] = []
    for key, columns in columns_of.items():
        first = columns[0]
        known.append((np.isfinite(first) if first.dtype == float else first != "").tolist())
        each: list[Any] = [column.tolist() for column in columns]
        if len(each) > 1:
            values.append([*zip(*each, strict=True)])
        elif kind := DISCRETE.get(f"{name}.{key}"):  # whose column holds doubles
            values.append([x if x != x else kind(x) for x in each[0]])
        else:
            values += each
    return [
        dict(compress(zip(columns_of, row, strict=True), there))
        for row, there in zip(zip(*values, strict=True), zip(*known, strict=True), strict=True)
    ]
