"""Tables as they are written: columns found, numbers read, rows left out with their reasons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import numpy as np
from pydantic import Field

from longball.extras import naming_extras
from longball.model.arrays import Array, Flags, Integers
from longball.model.block import Strict
from longball.model.csv_files import not_utf8, other_separators

if TYPE_CHECKING:
    import pandas as pd

DATA = Path(__file__).parents[1] / "data"
EXAMPLE = DATA / "statcast_2023-06-11.csv"

# m/s of one unit, m of one unit; all exact by definition.
SPEED_UNITS = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "ft": 0.3048, "in": 0.0254}

# How many of the rows that are left out for one reason are named by their number.
ROWS_NAMED = 10


class TableError(ValueError):
    """A table that cannot be used; the message says in a sentence which column or row, and why."""


class NoSuchColumn(TableError):
    """A table that lacks a column."""


class Omission(Strict):
    """Rows that were not used."""

    reason: str
    count: int
    first_rows: tuple[int, ...] = Field(
        description=f"numbers of the first {ROWS_NAMED}, from 1 below the header"
    )

    def __str__(self) -> str:
        """Say how many, why, and which."""
        rows = ", ".join(map(str, self.first_rows))
        more = ", …" if self.count > len(self.first_rows) else ""
        return f"left out: {self.count}, {self.reason} (row {rows}{more})"


def read_table(
    table: str | Path | TextIO | pd.DataFrame, columns: Iterable[str]
) -> tuple[str, pd.DataFrame]:
    """Return the name of a table and some of its columns, as they are written.

    It is a CSV file by its path, an open one, or a pandas DataFrame. A `TableError` says that it
    cannot be read, is empty, or lacks a column or has one twice.
    """
    source, frame = _frame(table)
    names = [str(each) for each in frame.columns]
    columns = list(dict.fromkeys(columns))
    for name in columns:
        if names.count(name) > 1:
            raise TableError(f"{name}: the table has {names.count(name)} columns of this name")
    if missing := [name for name in columns if name not in names]:
        shown = ", ".join(names[:20]) + (", …" if len(names) > 20 else "")
        none = "no such column" if len(missing) == 1 else "no such columns"
        raise NoSuchColumn(
            f"{', '.join(missing)}: the table has {none}; its columns are {shown}"
            f"{other_separators(names)}"
        )
    if not len(frame):
        raise TableError(f"{source}: the table has a header, and nothing below it")
    return source, frame.set_axis(names, axis="columns")[columns]


@naming_extras()
def _frame(table: str | Path | TextIO | pd.DataFrame) -> tuple[str, pd.DataFrame]:
    import pandas as pd

    if isinstance(table, pd.DataFrame):
        return "table", table
    path = table if isinstance(table, str | Path) else getattr(table, "name", "table")
    source = Path(path).name
    try:
        # The header is read as a row: pandas would rename a column that is there twice, and take
        # the first column for an index where rows are longer than the header.
        # An open text file, like standard input, has decided on an encoding: its bytes are read.
        raw = getattr(table, "buffer", table)
        lines = pd.read_csv(raw, header=None, dtype="string", encoding="utf-8-sig")
    except pd.errors.EmptyDataError:
        raise TableError(f"{source}: the table is empty") from None
    except pd.errors.ParserError as error:
        raise TableError(f"{source}: not a table in CSV: {str(error).strip()}") from None
    except UnicodeDecodeError as error:
        raise TableError(f"{source}: {not_utf8(error)}") from None
    except OSError as error:
        raise TableError(f"{path}: cannot be read: {error.strerror}") from error
    header = [str(name).strip() for name in lines.iloc[0].fillna("")]
    return source, lines.iloc[1:].set_axis(header, axis="columns").reset_index(drop=True)


def texts(column: pd.Series) -> pd.Series:
    """Return the texts of a column, missing where there is none."""
    return column.astype("string").str.strip().replace("", None)


def numbers(column: pd.Series) -> Array:
    """Return the numbers of a column, NaN where there is none; a `TableError` for anything else."""
    import pandas as pd

    values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    text = column.notna().to_numpy(dtype=bool)
    if not pd.api.types.is_numeric_dtype(column):
        text = text & texts(column).notna().to_numpy(dtype=bool)
    odd = np.flatnonzero((text & np.isnan(values)) | np.isinf(values))
    if odd.size:
        what = "is not a number" if np.isnan(values[odd[0]]) else "is not finite"
        raise TableError(
            f"{column.name}: row {odd[0] + 1} below the header has {column.iloc[odd[0]]!r}, "
            f"which {what}{and_more(odd.size)}"
        )
    return values


def select_rows(
    lacks: Sequence[tuple[str, Flags]], count: int
) -> tuple[tuple[Omission, ...], Flags]:
    """List the rows that lack something, each under the first thing; and mark the others.

    A `TableError` says that no row is left.
    """
    keep = np.ones(count, dtype=bool)
    left_out = []
    for reason, lacking in lacks:
        rows = np.flatnonzero(lacking & keep) + 1
        if rows.size:
            first = tuple(rows[:ROWS_NAMED].tolist())
            left_out.append(Omission(reason=reason, count=rows.size, first_rows=first))
        keep &= ~lacking
    if not keep.any():
        reasons = "; ".join(f"{each.count} rows: {each.reason}" for each in left_out)
        raise TableError(f"no row of the table says all that is asked ({reasons})")
    return tuple(left_out), keep


def refuse_rows(wrong: Flags, values: Array, rows: Integers, column: str, why: str) -> None:
    """Raise a `TableError` that names the first row where a value is wrong, if any is."""
    if wrong.any():
        first = int(np.argmax(wrong))
        raise TableError(
            f"{column}: row {rows[first]} below the header has {values[first]:g}: "
            f"{why}{and_more(int(wrong.sum()))}"
        )


def and_more(count: int) -> str:
    """Return what a message about the first of so many rows ends with."""
    return "" if count == 1 else f" ({count} rows in all)"
