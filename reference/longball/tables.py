"""Scenes and results as tables: a row for each scene, a column for each number.

Columns bear the names of the numbers (`longball.model.quantities`): ``pitch.aim[0]``,
``landing.distance``. ``kind`` and ``id`` are columns as well. An empty cell is a value left out.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel
from pydantic_core import to_json

from longball import engines
from longball.api import Solution, as_engine, as_scene
from longball.engines import chain
from longball.engines.chain import BLOCKS, DISCRETE
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import checked
from longball.extras import naming_extras
from longball.model.csv_files import not_utf8, other_separators
from longball.model.quantities import flat, nested, replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, ImpactScene, InvalidScene, PitchScene, Scene

if TYPE_CHECKING:
    import pandas as pd


@overload
def solve_many(
    scenes: Mapping[str, Any] | pd.DataFrame,
    engine: str | Engine[Any] = "batch",
    *,
    certify: bool = False,
    workers: int = -1,
    **options: Any,
) -> pd.DataFrame: ...


@overload
def solve_many(
    scenes: Iterable[object],
    engine: str | Engine[Any] = "batch",
    *,
    certify: bool = False,
    workers: int = -1,
    **options: Any,
) -> list[Solution]: ...


def solve_many(
    scenes: Any,
    engine: str | Engine[Any] = "batch",
    *,
    certify: bool = False,
    workers: int = -1,
    **options: Any,
) -> Any:
    """Solve many scenes.

    Parameters
    ----------
    scenes
        Scenes as `solve` takes them; or columns: a mapping or a DataFrame from the names of
        numbers (``pitch.speed``, ``pitch.aim[0]``, ``swing.tilt``, …), and from ``kind``, to arrays
        of shape (n,) or to one value for all scenes. An empty cell, NaN or None, is a value left
        out: it is the paper's. ``air=None`` for all scenes takes the air away, as in a scene. A
        text is no number, but may be JSON, such as ``"null"`` for no air.
    engine, options
        As in `solve`, but that the default is the engine batch.
    certify
        Whether every number comes with a proven bound on its error; where there is none,
        ``certificate`` says why.
    workers
        Threads of the batch engine, processes of another; -1: one per core. The answers do not
        depend on it.

    Returns
    -------
    list of Solution or pandas.DataFrame
        Solutions in the order of the scenes; one without an answer has an `error`. Of columns a
        table with a row for each scene: ``outcome``, ``plate.time``, ``landing.distance``,
        ``landing.position[0]``, …, NaN where there is none; ``error`` and ``code`` say why a row
        has no outcome. ``id`` is there if the columns have it. The index is that of the DataFrame
        that is given. A quantity that no row has is no column: a table of no rows has ``outcome``,
        ``error`` and ``code`` alone.

    Raises
    ------
    InvalidScene
        If no row of the columns is a scene, as when a column is missing.
    ValueError, TypeError
        As in `solve`; or if the columns differ in length, or `workers` is no number of them.

    Warns
    -----
    UserWarning
        If several scenes have the same id.

    Examples
    --------
    >>> import longball as lb
    >>> speeds = [30.0, 35.0, 40.0]
    >>> table = lb.solve_many({"kind": "pitch", "pitch.speed": speeds})
    >>> table["plate.time"].round(4).tolist()
    [0.6581, 0.5644, 0.494]
    """
    flyer = as_engine(engine, options)
    solver: Engine[Any] | ManyAtOnce = flyer
    if engines.of_type(bool, "certify", certify):
        from longball.engines.certify import Certifying  # brings ball arithmetic

        solver = Certifying(flyer)
    workers = checked(workers)
    if workers == -1:
        workers = os.cpu_count() or 1
    if isinstance(scenes, Mapping) or hasattr(scenes, "columns"):
        names = getattr(scenes, "columns", scenes)
        table = _solve_table({name: scenes[name] for name in names}, solver, workers)
        _warn_of_repeated(table.get("id", ()))
        return table.set_axis(scenes.index) if hasattr(scenes, "columns") else table
    if isinstance(scenes, str | bytes | BaseModel):
        raise TypeError("solve_many takes a list of scenes or columns; lb.solve takes one scene")
    if hasattr(scenes, "to_frame") or not isinstance(scenes, Iterable):
        raise TypeError(
            "solve_many takes a list of scenes, or columns as a mapping or a DataFrame; "
            f"not an object of type {type(scenes).__name__}"
        )
    solutions = [
        Solution(asked if isinstance(asked, BaseModel) else None, result, flyer)
        for asked, result in _asked_and_results(scenes, solver, workers)
    ]
    _warn_of_repeated(solution.id for solution in solutions)
    return solutions


def _warn_of_repeated(ids: Iterable[object]) -> None:
    repeated = [name for name, count in Counter(ids).items() if count > 1 and not _is_empty(name)]
    if repeated:
        told = f"{len(repeated)}, among them {repeated[0]!r}"
        warnings.warn(f"ids that more than one scene has: {told}", stacklevel=3)


def _asked_and_results(
    written: Iterable[object], solver: Engine[Any] | ManyAtOnce, workers: int
) -> Iterator[tuple[Scene | InvalidScene, Result]]:
    """Yield scenes, or why they are none, with their results."""
    asked = [*map(_as_scene_or_error, written)]
    valid = [scene for scene in asked if not isinstance(scene, InvalidScene)]
    results = iter(chain.solve_each(valid, solver, workers))
    for scene in asked:
        if isinstance(scene, InvalidScene):
            yield scene, Result(id=scene.scene_id, error=str(scene), code=scene.code)
        else:
            yield scene, next(results)


def _as_scene_or_error(written: object) -> Scene | InvalidScene:
    try:
        return as_scene(written)
    except InvalidScene as error:
        return error


# --- columns --------------------------------------------------------------------------------------

# Corners of the box that columns span: with more columns there are too many to try.
_MOST_COLUMNS = 12


def _solve_table(
    columns: Mapping[str, Any], solver: Engine[Any] | ManyAtOnce, workers: int
) -> pd.DataFrame:
    """Solve the scenes of columns; see `solve_many`."""
    fixed, varied = _split(columns)
    if isinstance(solver, ManyAtOnce) and hasattr(solver, "fly_all"):
        frame = _solve_as_columns(fixed, varied, solver, workers)
        if frame is not None:
            return frame
    rows = [*_rows(fixed, varied)]
    scenes = (_scene_of(row, _json_alone) for row in rows)
    solved = [*_asked_and_results(scenes, solver, workers)]
    errors = [asked for asked, _ in solved if isinstance(asked, InvalidScene)]
    if errors and len(errors) == len(rows):
        raise InvalidScene(
            f"no row is a scene: {errors[0]} (row 0 of {len(rows)}); "
            f"the columns are {', '.join(map(str, columns))}"
        )
    frame = results_table(result.data() for _, result in solved)
    unasked = [name for name in ("engine", "id") if name not in columns]
    return frame.drop(columns=unasked, errors="ignore")


def _solve_as_columns(
    fixed: Mapping[str, Any], varied: dict[str, NDArray[Any]], solver: Any, workers: int
) -> pd.DataFrame | None:
    """Solve columns by the batch engine, without a scene for each; None if some row is no scene."""
    from longball.engines.batch import solve_columns

    base = _all_valid(fixed, varied)
    if base is None:
        return None
    ids = varied.pop("id", None)
    table = solve_columns(base, varied, solver, workers)
    return _frame(table, ids, dict(_reasons(base, varied, table["outcome"], solver)))


def _split(columns: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return what all scenes have in common, and columns, by name."""
    fixed: dict[str, Any] = {}
    varied: dict[str, NDArray[Any]] = {}
    for name, value in columns.items():
        if isinstance(value, Mapping):
            fixed |= flat({name: value})
        elif isinstance(value, str | bytes) or np.ndim(value) == 0:
            # For all scenes it means what it means in one; in a cell it is a value left out.
            fixed[name] = _NO_AIR if name == "air" and value is None else value
        else:
            column = np.asarray(value)
            # NumPy makes texts of numbers that stand beside one.
            varied[name] = np.asarray(value, object) if column.dtype.kind in "UT" else column
    shapes = {name: column.shape for name, column in varied.items()}
    if len({*shapes.values()}) > 1 or any(len(shape) != 1 for shape in shapes.values()):
        told = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"columns must be one-dimensional and equally long; these are {told}")
    texts = [name for name, column in varied.items() if column.dtype.kind in "OUT"]
    if len(texts) < len(varied):  # there is a column of numbers that tells how many scenes
        for name in texts:
            values = varied[name].tolist()
            if name != "id" and all(value == values[0] for value in values):
                del varied[name]
                fixed |= dict.fromkeys([name], *values[:1])
    return fixed, varied


def _all_valid(fixed: Mapping[str, Any], varied: Mapping[str, NDArray[Any]]) -> Scene | None:
    """Return one of the scenes if it is certain that all of them are valid.

    Every condition on a scene, but for that of an impact, holds in a convex set of its numbers:
    what holds at all corners of the box that the columns span holds in the box.
    """
    columns = {name: column for name, column in varied.items() if name != "id"}
    numeric = all(np.issubdtype(c.dtype, np.number) and c.size for c in columns.values())
    if not numeric or len(columns) > _MOST_COLUMNS:
        return None
    ends = [{float(column.min()), float(column.max())} for column in columns.values()]
    corners = [dict(zip(columns, corner, strict=True)) for corner in product(*ends)]
    try:
        base = as_scene(_scene_of({**fixed, **corners[0]}, _json_alone))
        if isinstance(base, ImpactScene):
            return None
        for corner in corners[1:]:
            replaced(base, corner)
    except ValueError:
        return None
    return base


def _rows(fixed: Mapping[str, Any], varied: Mapping[str, NDArray[Any]]) -> Iterator[dict[str, Any]]:
    for values in zip(*(column.tolist() for column in varied.values()), strict=True):
        yield {**fixed, **dict(zip(varied, values, strict=True))}
    if fixed and not varied:
        yield dict(fixed)


def _scene_of(row: Mapping[Any, Any], read: Callable[[str], Any]) -> dict[str, Any]:
    """Return the scene of a row as plain data, its texts read; without what is left out."""
    given = {
        str(name): read(x) if isinstance(x, str) and name not in ("id", "kind") else x
        for name, x in row.items()
        if not _is_empty(x)
    }
    return nested(given, _DEFAULTS.get(given.get("kind")))


def _is_empty(value: object) -> bool:
    return value is None or (isinstance(value, float) and value != value)


def _json_or_number(text: str) -> Any:
    """Return what a text of a file holds: JSON, as null is for no air, a number, as .5, or text."""
    for read in (json.loads, float):
        with suppress(ValueError):
            return read(text)
    return text


def _json_alone(text: str) -> Any:
    """Return what a text among Python's values holds: JSON, but a number is not written as text."""
    with suppress(ValueError):
        held = json.loads(text)
        return text if isinstance(held, int | float) else held
    return text


_NO_AIR = "null"  # as JSON, since None is a value left out


# Of kinds that need no block, to complete vectors from.
_DEFAULTS: dict[Any, Scene] = {scene.kind: scene for scene in (PitchScene(), AtBatScene())}


def _reasons(
    base: Scene, columns: Mapping[str, NDArray[Any]], outcomes: NDArray[Any], solver: Engine[Any]
) -> Iterator[tuple[int, Result]]:
    """Yield the numbers of rows without an outcome, with results that say why."""
    for i in np.flatnonzero(outcomes == "").tolist():
        yield i, chain.solve(replaced(base, {n: float(c[i]) for n, c in columns.items()}), solver)


@naming_extras()
def _frame(
    table: Mapping[str, NDArray[Any]], ids: NDArray[Any] | None, reasons: Mapping[int, Result]
) -> pd.DataFrame:
    import pandas as pd

    named = {} if ids is None else {"id": ids}
    frame = pd.DataFrame({**named, **table})
    frame["error"] = frame["code"] = pd.Series(None, frame.index, "str")
    for i, result in reasons.items():
        frame.loc[i, ["outcome", "error", "code"]] = None, result.error, result.code
    return _typed(frame)


@naming_extras()
def results_table(results: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """Return results, as plain data, as a table with the columns in the order of `Result`."""
    import pandas as pd

    rows = (dict(flat(data)) for data in results)
    # Block by block: rows as dicts take ten times the memory of a table.
    blocks = [pd.DataFrame(block) for block in iter(lambda: [*islice(rows, _ROWS)], [])]
    frame = pd.concat(blocks) if blocks else pd.DataFrame()
    names = sorted(dict.fromkeys([*frame.columns, *_TEXTS]), key=_place)
    return _typed(frame.reset_index(drop=True).reindex(columns=names))


_ROWS = 10_000
_TEXTS = {"outcome": "str", "error": "str", "code": "str"}  # columns that are always there
_DISCRETE = {name: "boolean" if kind is bool else "Int64" for name, kind in DISCRETE.items()}


def _typed(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table of results with the types of its columns, whatever is missing in them."""
    types = _TEXTS | _DISCRETE
    return frame.astype({name: types[name] for name in frame.columns if name in types})


def _place(name: str) -> tuple[int, int]:
    """Return where a column of results stands; those of one vector are in their order already."""
    block, key, _ = re.split(r"\W", f"{name}..", maxsplit=2)
    keys = [*BLOCKS[block].model_fields] if block in BLOCKS else [""]
    return [*Result.model_fields].index(block), keys.index(key)


# --- files ----------------------------------------------------------------------------------------


def scene_lines(path: Path) -> bytes:
    """Return the scenes of a .csv or .parquet as lines of JSON, numbered as those of the file."""
    rows: Iterable[tuple[int, Mapping[Any, Any]]] = _csv_rows(path)
    if path.suffix.lower() == ".parquet":
        import pandas as pd

        rows = enumerate(pd.read_parquet(path).to_dict("records"), 1)
    lines: list[bytes] = []
    for number, row in rows:
        lines += [b""] * (number - 1 - len(lines))  # the head, blank lines, the rest of a cell
        lines.append(to_json(_scene_of(row, _json_or_number)))
    return b"\n".join(lines)


def _csv_rows(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield the rows of a .csv that are not blank, each with the number of its first line."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(not_utf8(error)) from None
    reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
    begin, head = 1, None
    try:
        for cells in reader:
            number, begin = begin, reader.line_num + 1
            if not any(map(str.strip, cells)):
                continue
            if head is None:
                head = _head(cells)
                continue
            if any(cells[len(head) :]):
                told = f"{len(cells)} cells, and the head has {len(head)}"
                raise ValueError(f"line {number}: {told}")
            if unnamed := [x for name, x in zip(head, cells, strict=False) if x and not name]:
                raise ValueError(f"line {number}: {unnamed[0]!r} is in a column without a name")
            yield number, {name: x for name, x in zip(head, cells, strict=False) if x}
    except csv.Error as error:
        raise ValueError(f"line {begin}: {error}") from None


def _head(cells: Sequence[str]) -> list[str]:
    """Return the names of columns as the first row has them."""
    head = [name.strip() for name in cells]
    for name in filter(None, head):
        if head.count(name) > 1:
            raise ValueError(f"the column {name} is there twice")
    if hint := other_separators(head):
        raise ValueError(f"not a table of scenes{hint}")
    return head


def write_table(path: Path, results: Iterable[bytes]) -> None:
    """Write results, as lines of JSON, as a table."""
    frame = results_table(map(json.loads, results))
    if path.suffix.lower() == ".parquet":
        frame.to_parquet(path)
    else:
        frame.to_csv(path, index=False)
