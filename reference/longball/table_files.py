"""Files of scenes and results as tables: CSV and Parquet."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from longball.model.csv_files import read_rows, unguarded, write_frame
from longball.model.jsonl import json_or_number
from longball.model.plain import plain
from longball.model.scene import KINDS
from longball.tables import results_table, scene_of


def scene_lines(path: Path) -> bytes:
    """Return the scenes of a .csv or .parquet as lines of JSON, numbered as those of the file."""
    rows: Iterable[tuple[int, Mapping[Any, Any]]] = _csv_rows(path)
    if path.suffix.lower() == ".parquet":
        import pandas as pd

        if not (content := path.read_bytes()).startswith(b"PAR1"):
            raise ValueError("not Parquet: its first four bytes must be PAR1")
        rows = enumerate(pd.read_parquet(io.BytesIO(content)).to_dict("records"), 1)
    lines: list[bytes] = []
    for number, row in rows:
        # Somebody else's table: one sentence instead of an error in each row.
        if not lines and not any(map(_is_of_scene, row)):
            raise ValueError(
                f"no column is a key of a scene, such as kind or launch.velocity[0]; they are "
                f"{', '.join(map(str, row))}; longball measured reads tables of measurements"
            )
        lines += [b""] * (number - 1 - len(lines))  # the head, blank lines, the rest of a cell
        # Cells of lists and NumPy numbers become what JSON can write.
        cells = {name: _written(x) for name, x in row.items()}
        scene = scene_of(cells, json_or_number)
        lines.append(to_json(scene, inf_nan_mode="constants"))  # null would be no air
    return b"\n".join(lines)


_KEYS = {key for kind in KINDS.values() for key in kind.model_fields}


def _is_of_scene(name: object) -> bool:
    return re.split(r"[.\[]", str(name))[0] in _KEYS


def _written(cell: object) -> Any:
    """Return a cell of a file as JSON has it; what is neither number nor block, as a text."""
    try:
        return plain(cell)
    except TypeError:
        return str(cell)


def _csv_rows(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield the rows of a .csv that are not blank, each with the number of its first line."""
    head, rows = read_rows(path.read_bytes(), _is_of_scene)
    for number, cells in rows:
        pairs = [(name, x) for name, x in zip(head, cells, strict=False) if x]
        # pandas writes an index of row numbers into a first column without a name.
        if pairs and cells[0].isdecimal() and head[0] in _INDEX:
            del pairs[0]
        if unnamed := [x for name, x in pairs if not name]:
            raise ValueError(f"line {number}: {unnamed[0]!r} is in a column without a name")
        yield number, {name: unguarded(x) for name, x in pairs}


_INDEX = ("", "Unnamed: 0")  # names of a column that holds an index: in a file, and once read


def write_table(path: Path, results: Iterable[bytes]) -> None:
    """Write results, as lines of JSON, as a table."""
    # A table needs all results at once: their blocks decide the columns.
    frame = results_table(map(json.loads, results))
    if path.suffix.lower() == ".parquet":
        frame.to_parquet(path)
    else:
        write_frame(frame, path)
