"""Scenes and results as tables: a row for each scene, a column for each number.

Columns have the names of the numbers (`longball.model.quantities`): ``pitch.aim[0]``,
``landing.distance``. ``kind`` and ``id`` are columns as well. An empty cell means the default.
"""

from __future__ import annotations

import gc
import json
import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import islice, product
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from longball import engines
from longball.api import as_engine, as_scene, chosen_inputs, derivatives_in, differentiable
from longball.engines import chain
from longball.engines.chain import BLOCKS, DISCRETE
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import checked
from longball.extras import naming_extras
from longball.model.changes import USUAL_SCENES
from longball.model.plain import column_of, is_missing
from longball.model.quantities import flat, nested, replaced
from longball.model.result import Result, signed
from longball.model.scene import InvalidScene, Scene, may_be_mixed, refused, vector_length
from longball.solution import Solution

if TYPE_CHECKING:
    import pandas as pd

    from longball.engines.path_engine import PathEngine
    from longball.engines.tangent import Derivatives


@overload
def solve_many(
    scenes: Mapping[str, Any] | pd.DataFrame,
    engine: str | Engine = "batch",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    paths: int | None = None,
    workers: int = -1,
    **options: Any,
) -> pd.DataFrame: ...


@overload
def solve_many(
    scenes: Iterable[object],
    engine: str | Engine = "batch",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    paths: int | None = None,
    workers: int = -1,
    **options: Any,
) -> list[Solution]: ...


def solve_many(
    scenes: Any,
    engine: str | Engine = "batch",
    *,
    certify: bool = False,
    derivatives: bool | Sequence[str] = False,
    paths: int | None = None,
    workers: int = -1,
    **options: Any,
) -> Any:
    """Solve many scenes.

    Parameters
    ----------
    scenes
        Scenes as `solve` takes them; or columns: a mapping or a DataFrame from the names of
        numbers (``pitch.speed``, ``pitch.aim[0]``, ``swing.tilt``, …), and from ``kind``, to arrays
        of shape (n,) or to one value for all scenes. A vector (``launch.position``) may be one
        column, of lists or of shape (n, 3), or one list for all scenes. An empty cell means the
        default: NaN, None, pandas' NA and masked cells. ``air=None`` for all scenes removes the
        air, as in a scene. Numbers can have any numeric type of Python or NumPy, and become the
        nearest doubles; bools, complex numbers and times are errors. A text is not a number, but
        can be JSON, such as ``"null"`` for no air.
    engine, options
        As in `solve`; the default engine is batch.
    certify
        True to add a proven bound on the error to every number; without one, ``certificate`` gives
        the reason.
    derivatives
        As in `solve`. With columns, the table has a column ``landing.distance by launch.speed`` for
        each number of the result and each chosen number of the scene, NaN without a derivative. The
        column ``derivatives`` names their engine: the compiled code leaves some rows to the engine
        ivp, which takes a thousand times as long. ``refused`` gives reasons for missing ones.
    paths
        Number of points of each ball's path, evenly spaced in time, from the start of its scene to
        the end. With columns, the table has a column ``path`` of arrays of shape (paths, 7) with t
        (s), x, y, z (m), vx, vy, vz (m/s), or None for an impact. A solution has them as
        ``to_dict()["path"]``.
    workers
        Threads of the batch engine, processes of other engines; -1: one per core. The results do
        not depend on it.

    Returns
    -------
    list of Solution or pandas.DataFrame
        Solutions in the order of the scenes; one without an answer has an `error`. For columns, a
        table with a row for each scene: ``outcome``, ``plate.time``, ``landing.distance``,
        ``landing.position[0]``, …, NaN if absent; ``engine``, the engine that flew the ball, which
        for some laws is not the requested one; ``error`` and ``code`` for rows without an outcome;
        ``id`` if the columns have it. The index is that of the given DataFrame. Quantities that no
        row has are omitted: a table without rows has ``outcome``, ``error`` and ``code`` alone.

    Raises
    ------
    InvalidScene
        If every row of the columns is invalid, for example because a column is missing. Otherwise
        invalid rows have an `error`.
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
    solver: Engine | ManyAtOnce = flyer
    if engines.of_type(bool, "certify", certify):
        from longball.engines.certify import Certifying  # brings ball arithmetic

        solver = Certifying(flyer)
    if certify and derivatives:
        raise ValueError("derivatives are not certified; engine = 'enclosure' proves them")
    if paths is not None:
        paths = engines.whole_number("paths", paths, 2)
        if certify:
            raise ValueError("paths: their points cannot be certified; take the engine enclosure")
    workers = checked(workers)
    # Engines take a number of threads or processes.
    if workers == -1:
        workers = os.cpu_count() or 1
    if isinstance(scenes, Mapping) or hasattr(scenes, "columns"):
        names = getattr(scenes, "columns", scenes)
        columns = {name: scenes[name] for name in names}
        table = _solve_table(columns, solver, workers, paths, derivatives)
        _warn_of_repeated(table.get("id", ()))
        return table.set_axis(scenes.index) if hasattr(scenes, "columns") else table
    # Iterable, but one scene.
    if isinstance(scenes, str | bytes | BaseModel):
        raise TypeError("solve_many takes a list of scenes or columns; lb.solve takes one scene")
    if hasattr(scenes, "to_frame") or not isinstance(scenes, Iterable):
        raise TypeError(
            "solve_many takes a list of scenes, or columns as a mapping or a DataFrame; "
            f"not an object of type {type(scenes).__name__}"
        )
    # Trajectories are not kept: a million of them would fill the memory.
    with _no_collection():
        solutions = [
            Solution(
                asked if isinstance(asked, BaseModel) else None,
                result,
                flyer,
                derivatives=_derivatives_alone(asked, result, flyer, derivatives),
            )
            for asked, result in _asked_and_results(scenes, solver, workers, paths)
        ]
    _warn_of_repeated(solution.id for solution in solutions)
    return solutions


@contextmanager
def _no_collection() -> Iterator[None]:
    """Pause the cyclic garbage collection."""
    # It would take half of the time for a few thousand scenes, and solutions have no cycles.
    active = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if active:
            gc.enable()


def _warn_of_repeated(ids: Iterable[object]) -> None:
    repeated = [name for name, count in Counter(ids).items() if count > 1 and not is_missing(name)]
    if repeated:
        message = f"{len(repeated)} ids are those of more than one scene, such as {repeated[0]!r}"
        warnings.warn(message, stacklevel=3)


def _asked_and_results(
    written: Iterable[object],
    solver: Engine | ManyAtOnce,
    workers: int,
    paths: int | None = None,
) -> Iterator[tuple[Scene | InvalidScene, dict[str, Any]]]:
    """Yield scenes, or why they are none, with their results as plain data."""
    asked = [*map(_as_scene_or_error, written)]
    valid = [scene for scene in asked if not isinstance(scene, InvalidScene)]
    if paths is not None:
        results = (chain.solve_with_points(scene, solver, paths).data() for scene in valid)
    elif isinstance(solver, ManyAtOnce):
        results = (data for data in solver.solve_as_data(valid, workers))
    else:
        results = (result.data() for result in chain.solve_each(valid, solver, workers))
    for scene in asked:
        yield scene, refused(scene).data() if isinstance(scene, InvalidScene) else next(results)


def _as_scene_or_error(written: object) -> Scene | InvalidScene:
    try:
        return as_scene(written)
    except InvalidScene as error:
        return error
    except TypeError as error:  # in a list, or in a cell
        return InvalidScene(str(error))


# --- columns --------------------------------------------------------------------------------------

# Of the box that columns span: to try more takes longer than to read the rows.
_MOST_CORNERS = 4096


def _solve_table(
    columns: Mapping[str, Any],
    solver: Engine | ManyAtOnce,
    workers: int,
    paths: int | None,
    derivatives: bool | Sequence[str],
) -> pd.DataFrame:
    """Solve the scenes of columns; see `solve_many`."""
    for name in columns:
        nested({str(name): None})  # raises an error for an invalid name
    fixed, varied, count = _split(columns)
    # An id may be a number here, and is no part of the scene that it is a name of.
    ids = varied.pop("id", fixed.pop("id", None))
    frame = None
    # The compiled code takes columns as they are. Paths need a trajectory for each ball.
    if isinstance(solver, ManyAtOnce) and hasattr(solver, "fly_all") and paths is None:
        frame = _solve_as_columns(fixed, varied, solver, workers, derivatives)
    if frame is None:
        rows = [*_rows(fixed, varied, count)]
        scenes = (scene_of(row, _json_alone) for row in rows)
        solved = [*_asked_and_results(scenes, solver, workers, paths)]
        errors = [asked for asked, _ in solved if isinstance(asked, InvalidScene)]
        # The same fault in all rows is one of the columns, as a column that is missing.
        if errors and len(errors) == count:
            raise InvalidScene(
                f"no row is a scene: {errors[0]} (row 0 of {count}); "
                f"the columns are {', '.join(map(str, columns))}"
            )
        data = [result for _, result in solved]
        # Arrays of shape (paths, 7) would become one column for each number.
        flown = [one.pop("path", None) for one in data]
        frame = _with_engines_signed(results_table(data)).drop(columns="id", errors="ignore")
        if paths is not None:
            points = np.empty(count, object)
            points[:] = [None if path is None else np.array(path, float) for path in flown]
            frame["path"] = points
        if derivatives:
            derived = [_derivatives_alone(*one, solver, derivatives) for one in solved]
            frame = _with_slopes(frame, *_slopes_alone(derived, solver))
    if ids is not None and count:
        frame.insert(0, "id", ids)
    return frame


def _solve_as_columns(
    fixed: Mapping[str, Any],
    varied: dict[str, NDArray[Any]],
    solver: Any,
    workers: int,
    derivatives: bool | Sequence[str],
) -> pd.DataFrame | None:
    """Solve columns by the batch engine without building scenes; None if a row is invalid."""
    from longball.engines.batch import solve_columns, solve_columns_with_slopes

    # To build a scene for each row would take far longer than its flight.
    first = {name: column.item(0) for name, column in varied.items() if column.size}
    base = _scene_or_none(scene_of({**fixed, **first}, _json_alone))
    if base is None or not _all_valid(base, varied):
        return None
    slopes = None
    if derivatives:
        names = chosen_inputs(base, derivatives)
        table, slopes = solve_columns_with_slopes(base, varied, names, solver, workers)
    else:
        table = solve_columns(base, varied, solver, workers)
    # Rows without an answer of the compiled code: the chain solves them, or gives the reason.
    unsolved = np.flatnonzero(table["outcome"] == "").tolist()
    rows = ({n: column.item(i) for n, column in varied.items()} for i in unsolved)
    scenes = (scene_of({**fixed, **row}, _json_alone) for row in rows)
    reasons = (result for _, result in _asked_and_results(scenes, solver, workers))
    frame = _with_engines_signed(_frame(table, dict(zip(unsolved, reasons, strict=True))))
    if slopes is None:
        return frame
    columns = {
        (quantity, name): column
        for quantity, by_number in slopes.columns.items()
        for name, column in zip(names, by_number, strict=True)
    }
    # Engine of the derivatives: compiled for most rows, `ivp` for those at a corner.
    by = np.full(len(frame), None, object)
    by[table["outcome"] != ""] = signed(solver.description)
    by[slopes.alone] = signed(_alone(solver).description)
    return _with_slopes(frame, columns, by, slopes.refused)


# --- derivatives ----------------------------------------------------------------------------------


def _alone(engine: Any) -> PathEngine:
    """Return the engine that finds the derivatives of single scenes."""
    return differentiable(engines.create("ivp") if isinstance(engine, ManyAtOnce) else engine)


def _derivatives_alone(
    scene: Scene | InvalidScene, result: dict[str, Any], engine: Any, names: bool | Sequence[str]
) -> Derivatives | None:
    """Return the derivatives of a result; None if none are requested, or it is an error."""
    if not names or isinstance(scene, InvalidScene) or "error" in result:
        return None
    return derivatives_in(scene, Result.model_validate(result), _alone(engine), names)


Slopes = Mapping[tuple[str, str], Any]  # columns, by quantities of results and by names of scenes


def _slopes_alone(
    derived: Sequence[Derivatives | None], engine: Any
) -> tuple[Slopes, Any, dict[int, Mapping[str, str]]]:
    """Return derivatives as columns, their engine by row, and refusals by row."""
    there = {i: one for i, one in enumerate(derived) if one is not None}
    # Rows have different quantities, as a miss has no landing: columns are the union.
    pairs = dict.fromkeys((q, n) for one in there.values() for q, by in one.items() for n in by)
    columns = {pair: np.full(len(derived), math.nan) for pair in pairs}
    by = np.full(len(derived), None, object)
    for i, one in there.items():
        by[i] = signed(_alone(engine).description)
        for quantity, slopes in one.items():
            for name, slope in slopes.items():
                columns[quantity, name][i] = float(slope)
    return columns, by, {i: one.refused for i, one in there.items() if one.refused}


@naming_extras()
def _with_slopes(
    frame: pd.DataFrame, columns: Slopes, by: Any, refused: Mapping[int, Mapping[str, str]]
) -> pd.DataFrame:
    """Return a table of results with columns of derivatives, and where they are from."""
    import pandas as pd

    text = pd.StringDtype(na_value=math.nan)
    sentences = np.full(len(frame), None, object)
    for i, reasons in refused.items():
        sentences[i] = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
    named = {
        f"{quantity} by {name}": columns[quantity, name]
        for quantity, name in sorted(columns, key=lambda pair: _place(pair[0]))
    }
    whence = {"derivatives": pd.array(by, text), "refused": pd.array(sentences, text)}
    slopes = pd.DataFrame({**named, **whence}, frame.index, copy=False)
    return pd.concat([frame, slopes], axis=1)


def _split(columns: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any], int]:
    """Split a table into constants, columns by name, and the number of scenes."""
    fixed: dict[str, Any] = {}
    varied: dict[str, Any] = {}
    for name, value in columns.items():
        if isinstance(value, Mapping):
            fixed |= flat({name: value})
        elif length := vector_length(str(name)):
            _put_vector(str(name), value, length, fixed, varied)
        elif _is_single(value):
            # A single None removes the air of all scenes; None in a cell means the default.
            fixed[name] = _NO_AIR if name == "air" and value is None else value
        else:
            varied[name] = _one_a_row(column_of(value)) if name != "id" else _labels(value)
    # All columns at once, so that the message shows which of them differ.
    shapes = {name: np.shape(column) for name, column in varied.items()}
    if len({*shapes.values()}) > 1 or any(len(shape) != 1 for shape in shapes.values()):
        given = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise ValueError(f"columns must be one-dimensional and equally long; these are {given}")
    # Without columns there is one scene, or none if nothing is given.
    (count, *_), *_ = [*shapes.values(), (min(len(fixed), 1),)]
    for name in [name for name in varied if name != "id"]:
        cells = varied[name]
        # The same word in all rows, as "flight" in `kind`, is a constant of the table.
        if all(isinstance(x, str) and x == cells[0] for x in cells) and count:
            fixed[name] = cells[0]
        elif not all(map(is_missing, cells)):
            continue
        del varied[name]
    return fixed, varied, count


def _put_vector(
    name: str, value: Any, length: int, fixed: dict[str, Any], varied: dict[str, Any]
) -> None:
    """Put a vector of all scenes, or a column of vectors, where single values and columns are."""
    cells = column_of(value)
    if cells.ndim == 0 or (cells.ndim == 1 and cells.dtype == float and cells.size):
        # By components, so that a column of one of them can take its place.
        fixed |= flat({name: cells.tolist()}) if cells.shape == (length,) else {name: value}
        return
    rows = [*cells] if cells.ndim == 2 else [column_of(cell) for cell in cells]
    vectors = np.array(rows) if rows and all(row.shape == (length,) for row in rows) else None
    # Cells of several lengths, or texts: each row gets its own message.
    if vectors is None or vectors.dtype != float:
        varied[name] = _one_a_row(cells)
        return
    varied |= {f"{name}[{i}]": vectors[:, i] for i in range(length)}


def _one_a_row(cells: NDArray[Any]) -> NDArray[Any]:
    """Return a column whose cells are the rows of an array, as lists."""
    if cells.ndim < 2:
        return cells
    column = np.empty(len(cells), object)
    column[:] = [row.tolist() for row in cells]
    return column


def _is_single(value: Any) -> bool:
    """Check that a value is that of all scenes, and no column."""
    if isinstance(value, str | bytes) or not hasattr(value, "__len__"):
        return True
    return getattr(value, "ndim", 1) == 0


def _labels(values: Iterable[Any]) -> list[Any]:
    """Return ids, which may be numbers, as they are given; None where one is missing."""
    return [None if is_missing(x) else x for x in values]


def _scene_or_none(written: Mapping[str, Any]) -> Scene | None:
    with suppress(TypeError, ValueError):
        return as_scene(written)
    return None


def _all_valid(scene: Scene, varied: Mapping[str, NDArray[Any]]) -> bool:
    """True if a scene is certainly valid with every row of columns.

    If the valid numbers are a convex set (`may_be_mixed`), it is enough to check the corners of the
    box that the columns span.
    """
    numeric = all(c.dtype == float and c.size and np.isfinite(c).all() for c in varied.values())
    if not varied or not numeric or not may_be_mixed(scene):
        return False
    # The smallest and the largest value of each column; one corner where they are equal.
    ends = [{*column[[column.argmin(), column.argmax()]].tolist()} for column in varied.values()]
    if math.prod(map(len, ends)) > _MOST_CORNERS:
        return False
    try:
        for corner in product(*ends):
            replaced(scene, dict(zip(varied, corner, strict=True)))
    except ValueError:
        return False
    return True


def _rows(
    fixed: Mapping[str, Any], varied: Mapping[str, NDArray[Any]], count: int
) -> Iterator[dict[str, Any]]:
    columns = [column.tolist() for column in varied.values()]
    for values in zip(*columns, strict=True) if columns else [()] * count:
        yield {**fixed, **dict(zip(varied, values, strict=True))}


def scene_of(row: Mapping[Any, Any], read: Callable[[str], Any]) -> dict[str, Any]:
    """Return the scene of a row as plain data, with texts converted, without empty cells."""
    given = {
        str(name): read(x) if isinstance(x, str) and name not in ("id", "kind") else x
        for name, x in row.items()
        if not is_missing(x)
    }
    # A block and a part of it in the same row, such as `air` as JSON and `air.density`: keep the
    # part as an unknown key, so that the error of the row names it.
    parts = [n for n in given if any(n[: m.start()] in given for m in _PART.finditer(n))]
    odd = {n: given.pop(n) for n in parts}
    return nested(given, USUAL_SCENES.get(given.get("kind"))) | odd


_PART = re.compile(r"[.\[]")


def _json_alone(text: str) -> Any:
    """Parse a string among Python's values: JSON, but no number."""
    with suppress(ValueError, RecursionError):
        held = json.loads(text)
        # "40" stays a text, which the scene refuses: numbers have columns of numbers.
        return text if isinstance(held, int | float) else held
    return text


_NO_AIR = "null"  # as JSON, because None means the default


@naming_extras()
def _frame(
    table: Mapping[str, NDArray[Any]], reasons: Mapping[int, Mapping[str, Any]]
) -> pd.DataFrame:
    """Return columns as a table of results, with the reasons why rows have no outcome."""
    import pandas as pd

    frame = pd.DataFrame({name: table[name] for name in sorted(table, key=_place)})
    # Texts in most rows are None: an object column takes both.
    frame["error"] = frame["code"] = pd.Series(None, frame.index, object)
    for i, result in reasons.items():
        names = ["outcome", "engine", "error", "code"]
        frame.loc[i, names] = [result.get(name) for name in names]
    return _typed(frame)


def _with_engines_signed(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table of results whose engines have longball's version, as in a `Solution`."""
    # A few names in a million rows: each is signed once.
    if "engine" in frame:
        names = frame["engine"].dropna().unique()
        frame["engine"] = frame["engine"].map({name: signed(name) for name in names})
    return frame


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
_TEXTS = ("outcome", "error", "code")  # columns that are always there
_DISCRETE = {name: "boolean" if kind is bool else "Int64" for name, kind in DISCRETE.items()}


def _typed(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table of results with the types of its columns, whatever is missing in them."""
    import pandas as pd

    # pandas 3 calls this "str"; to pandas 2 that is another type, which makes texts of None.
    text = pd.StringDtype(na_value=math.nan)
    types: dict[str, Any] = dict.fromkeys((*_TEXTS, "engine"), text) | _DISCRETE
    return frame.astype({name: types[name] for name in frame.columns if name in types})


def _place(name: str) -> tuple[int, int]:
    """Return the sort key of a column of results; components of a vector are already in order."""
    block, key, _ = re.split(r"\W", f"{name}..", maxsplit=2)
    keys = [*BLOCKS[block].model_fields] if block in BLOCKS else [""]
    return [*Result.model_fields].index(block), keys.index(key)
