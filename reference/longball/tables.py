"""Scenes and results as tables: a row for each scene, a column for each number.

Columns have the names of the numbers (`longball.model.quantities`): ``pitch.aim[0]``,
``landing.distance``. ``kind`` and ``id`` are columns as well. An empty cell means the default.
"""

from __future__ import annotations

import json
import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import islice, product
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from longball import engines
from longball.api import as_engine, as_scene, chosen_inputs, derivatives_in, differentiable
from longball.engines import chain
from longball.engines.chain import BLOCKS, DISCRETE
from longball.engines.engine import Engine, ManyAtOnce
from longball.engines.parallel import checked, without_collection
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
    with without_collection():
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
    asked: list[Scene | InvalidScene] = []
    for one in written:
        try:
            asked.append(as_scene(one))
        except InvalidScene as error:
            asked.append(error)
        except TypeError as error:  # in a list, or in a cell
            asked.append(InvalidScene(str(error)))
    valid = [scene for scene in asked if not isinstance(scene, InvalidScene)]
    if paths is not None:
        results = (chain.solve_with_points(scene, solver, paths).data() for scene in valid)
    elif isinstance(solver, ManyAtOnce):
        results = (data for data in solver.solve_as_data(valid, workers))
    else:
        results = (result.data() for result in chain.solve_each(valid, solver, workers))
    for scene in asked:
        yield scene, refused(scene).data() if isinstance(scene, InvalidScene) else next(results)


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
    frame = slopes = None
    # The compiled code takes columns as they are. Paths need a trajectory for each ball.
    if isinstance(solver, ManyAtOnce) and hasattr(solver, "fly_all") and paths is None:
        base = _base_of_valid(fixed, varied)
        if base is not None:
            frame, slopes = _solve_as_columns(base, varied, solver, workers, derivatives)
    if frame is None:
        cells = [column.tolist() for column in varied.values()]
        rows = zip(*cells, strict=True) if cells else [()] * count
        scenes = (_scene_at(fixed, varied, row) for row in rows)
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
        frame = results_table(data).drop(columns="id", errors="ignore")
        if paths is not None:
            points = np.empty(count, object)
            points[:] = [None if path is None else np.array(path, float) for path in flown]
            frame["path"] = points
        if derivatives:
            slopes = _slopes_alone(solved, solver, derivatives)
    # A few names in a million rows: each is signed once.
    if "engine" in frame:
        names = frame["engine"].dropna().unique()
        frame["engine"] = frame["engine"].map({name: signed(name) for name in names})
    if slopes is not None:
        frame = _with_slopes(frame, slopes)
    if ids is not None and count:
        frame.insert(0, "id", ids)
    return frame


def _scene_at(
    fixed: Mapping[str, Any], varied: Mapping[str, Any], row: Iterable[Any]
) -> dict[str, Any]:
    return scene_of({**fixed, **dict(zip(varied, row, strict=True))}, _json_alone)


@naming_extras()
def _solve_as_columns(
    base: Scene,
    varied: Mapping[str, NDArray[Any]],
    solver: Any,
    workers: int,
    derivatives: bool | Sequence[str],
) -> tuple[pd.DataFrame, _Slopes | None]:
    """Solve columns of valid scenes by the batch engine, without building the scenes."""
    import pandas as pd

    from longball.engines.batch import solve_columns, solve_columns_with_slopes

    slopes = None
    if derivatives:
        names = chosen_inputs(base, derivatives)
        table, found = solve_columns_with_slopes(base, varied, names, solver, workers)
        # Engine of the derivatives: compiled for most rows, `ivp` for those at a corner.
        by = np.full(len(table["outcome"]), None, object)
        by[table["outcome"] != ""] = solver.description
        by[found.alone] = _alone(solver).description
        columns = {
            f"{quantity} by {name}": column
            for quantity, by_number in found.columns.items()
            for name, column in zip(names, by_number, strict=True)
        }
        slopes = _Slopes(columns, by, found.refused)
    else:
        table = solve_columns(base, varied, solver, workers)
    # Rows without an answer of the compiled code: the chain solves them, or gives the reason.
    unsolved = np.flatnonzero(table["outcome"] == "").tolist()
    rows = ({name: column.item(i) for name, column in varied.items()} for i in unsolved)
    reasons = _asked_and_results((replaced(base, row) for row in rows), solver, workers)
    texts = ("outcome", "engine", "error", "code")
    nothing = np.full(len(table["outcome"]), None, object)
    table |= {name: table.get(name, nothing).astype(object) for name in texts}
    for i, (_, result) in zip(unsolved, reasons, strict=True):
        for name in texts:
            table[name][i] = result.get(name)
    return _typed(pd.DataFrame({name: table[name] for name in sorted(table, key=_place)})), slopes


# --- derivatives ----------------------------------------------------------------------------------


class _Slopes(NamedTuple):
    """Derivatives of the results of a table."""

    columns: Any  # by names such as "landing.distance by launch.speed", as a mapping or a table
    by: Any  # description of their engine in each row; None for a row without any
    refused: Mapping[int, Mapping[str, str]]  # reasons for missing ones, by row and input


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


@naming_extras()
def _slopes_alone(
    solved: Sequence[tuple[Scene | InvalidScene, dict[str, Any]]],
    engine: Any,
    names: bool | Sequence[str],
) -> _Slopes:
    """Return the derivatives of results one by one."""
    import pandas as pd

    derived = [_derivatives_alone(*one, engine, names) for one in solved]
    # Rows have different quantities, as a miss has no landing: columns are the union.
    columns = pd.DataFrame(
        {f"{q} by {name}": float(x) for q, by in (one or {}).items() for name, x in by.items()}
        for one in derived
    )
    by = [None if one is None else _alone(engine).description for one in derived]
    refused = {i: one.refused for i, one in enumerate(derived) if one is not None and one.refused}
    return _Slopes(columns, by, refused)


@naming_extras()
def _with_slopes(frame: pd.DataFrame, slopes: _Slopes) -> pd.DataFrame:
    """Return a table of results with columns of derivatives, and where they are from."""
    import pandas as pd

    text = pd.StringDtype(na_value=math.nan)
    signatures = [by and signed(by) for by in slopes.by]
    sentences = np.full(len(frame), None, object)
    for i, reasons in slopes.refused.items():
        sentences[i] = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
    columns = {name: slopes.columns[name] for name in sorted(slopes.columns, key=_place)}
    columns |= {
        "derivatives": pd.array(signatures, text),
        "refused": pd.array(sentences, text),
    }
    return pd.concat([frame, pd.DataFrame(columns, frame.index, copy=False)], axis=1)


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
            # Ids may be numbers, and stay as they are given.
            labels = [None if is_missing(x) else x for x in value] if name == "id" else []
            varied[name] = labels or _one_a_row(column_of(value))
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


def _base_of_valid(fixed: Mapping[str, Any], varied: Mapping[str, NDArray[Any]]) -> Scene | None:
    """Return the scene of the first row if the scenes of all rows are certainly valid.

    If the valid numbers are a convex set (`may_be_mixed`), it is enough to check the corners of the
    box that the columns span: to build a scene for each row would take far longer than its flight.
    """
    columns = varied.values()
    if not columns or not all(
        c.dtype == float and c.size and np.isfinite(c).all() for c in columns
    ):
        return None
    # The smallest and the largest value of each column; one corner where they are equal.
    ends = [{*column[[column.argmin(), column.argmax()]].tolist()} for column in columns]
    with suppress(TypeError, ValueError):
        base = as_scene(_scene_at(fixed, varied, [column.item(0) for column in columns]))
        if may_be_mixed(base) and math.prod(map(len, ends)) <= _MOST_CORNERS:
            for corner in product(*ends):
                replaced(base, dict(zip(varied, corner, strict=True)))
            return base
    return None


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
