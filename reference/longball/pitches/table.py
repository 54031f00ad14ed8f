"""Tables of measurements: columns, numbers, omitted rows, and tests of units.

A row that cannot be used is omitted and listed with the reason. A column that cannot be used, such
as one in another unit, rejects the table.
"""

from __future__ import annotations

import gzip
import math
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

import numpy as np
from pydantic import Field

from longball.extras import naming_extras
from longball.model.arrays import Array, Flags, Integers
from longball.model.block import Strict
from longball.model.csv_files import other_separators, read_rows
from longball.model.names import did_you_mean, nearest_file, one_of
from longball.model.units import UNITS, from_si, in_si, si_of

if TYPE_CHECKING:
    import pandas as pd

DATA = Path(__file__).parents[1] / "data"
EXAMPLE = DATA / "statcast_2023-06-11.csv"

# Sizes of units, in m/s and m.
SPEED_UNITS, LENGTH_UNITS = UNITS["m/s"], UNITS["m"]


class Usual(NamedTuple):
    """Range of a column's values in baseball; of absolute values if both signs occur."""

    unit: str  # Statcast's
    single: tuple[float, float]  # range of one number
    # Narrower range of the median of many: a single height of 0.7 may be in ft or in m.
    many: tuple[float, float] | None = None


# Fewest values for a test of the median. Medians of forty positions at the plate scatter by 0.1 ft
# across it, and by 0.2 ft in height.
MANY = 40
USUAL = {
    "release_speed": Usual("mph", (25.0, 120.0), (45.0, 110.0)),
    "vy0": Usual("ft/s", (-200.0, -60.0)),
    "release_pos_y": Usual("ft", (25.0, 62.0)),
    "release_pos_z": Usual("ft", (0.5, 9.0), (2.5, 8.0)),
    "release_spin_rate": Usual("rpm", (400.0, 5000.0)),
    "plate_x": Usual("ft", (0.0, math.inf), (0.25, 1.2)),
    "plate_z": Usual("ft", (0.0, math.inf), (1.2, 4.0)),
    "sz_top": Usual("ft", (1.8, 5.0)),
    "sz_bot": Usual("ft", (0.7, 2.5)),
    "launch_speed": Usual("mph", (60.0, 125.0)),
    "temperature": Usual("°F", (25.0, 130.0)),
}

# Number of rows listed for one reason.
ROWS_NAMED = 10


class TableError(ValueError):
    """Raised for a table that cannot be used; the message gives column or row, and reason."""


class NoSuchColumn(TableError):
    """Raised if a table lacks columns."""

    def __init__(self, message: str, missing: Sequence[str], present: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.missing, self.present = missing, present


class Omission(Strict):
    """Rows that were not used."""

    reason: str
    count: int
    first_rows: tuple[int, ...] = Field(
        description=f"numbers of the first {ROWS_NAMED}, from 1 below the header"
    )

    def __str__(self) -> str:
        """Describe the omitted rows: count, reason and row numbers."""
        rows = ", ".join(map(str, self.first_rows))
        more = ", …" if self.count > len(self.first_rows) else ""
        return f"omitted: {self.count}, {self.reason} (row {rows}{more})"


def read_table(
    table: str | Path | TextIO | pd.DataFrame,
    columns: Iterable[str],
    optional: Iterable[str] = (),
    names: Mapping[str, str] | None = None,
) -> tuple[str, pd.DataFrame]:
    """Return the name of a table and some of its columns, without conversion.

    The table is the path of a .csv or .parquet file, an open file, or a pandas DataFrame. `names`
    gives the table's own names of columns. `optional` columns are returned if the table has them. A
    `TableError` is raised if the table cannot be read, is empty, lacks a column or has one twice.
    """
    its = dict(names or {})
    needed = {name: its.get(name, name) for name in columns}
    wanted = needed | {name: its.get(name, name) for name in optional}
    for name in its.keys() - wanted.keys():
        raise TableError(f"{name}: no column that is read{one_of('they are', name, wanted)}")
    source, head, frame = _frame(table, wanted.values())
    for name in wanted.values():
        if head.count(name) > 1:
            raise TableError(f"{source}: the column {name} appears twice")
    # A column that the user names must exist, even if it is optional.
    if missing := [x for name, x in wanted.items() if x not in head and name in needed | its]:
        shown = ", ".join(head[:20]) + (", …" if len(head) > 20 else "")
        others = [name for name in head if name not in wanted.values()]
        near = did_you_mean(missing[0], others) if len(missing) == 1 else ""
        theirs = f"{near} Its" if near else "; its"
        none = "no such column" if len(missing) == 1 else "no such columns"
        raise NoSuchColumn(
            f"{', '.join(missing)}: the table has {none}{theirs} columns are {shown}"
            f"{other_separators(head)}",
            missing,
            head,
        )
    if not len(frame):
        raise TableError(f"{source}: the table has a header, and nothing below it")
    here = {name: x for name, x in wanted.items() if x in head}
    named = frame.set_axis([str(name) for name in frame.columns], axis="columns")
    return source, named[[*here.values()]].set_axis([*here], axis="columns")


@naming_extras()
def _frame(
    table: str | Path | TextIO | pd.DataFrame, wanted: Iterable[str]
) -> tuple[str, list[str], pd.DataFrame]:
    """Return the name of a table, the names of all columns, and at least the wanted columns."""
    import pandas as pd

    # A DataFrame has no name; messages call it "table".
    if isinstance(table, pd.DataFrame):
        return "table", [str(name) for name in table.columns], table
    if not (isinstance(table, str | Path) or hasattr(table, "read")):
        raise TypeError(
            "a table is a pandas DataFrame, or a .csv or .parquet by its path; "
            f"not an object of type {type(table).__name__}"
        )
    path = table if isinstance(table, str | Path) else getattr(table, "name", "table")
    # The same name as in other messages.
    path = "standard input" if path == "<stdin>" else path
    source = Path(path).name
    try:
        data = _content(table)
    except (OSError, EOFError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or error
        near = nearest_file(path) if isinstance(error, FileNotFoundError) else ""
        raise TableError(f"{path}: cannot be read: {reason}{near}") from error
    try:
        # By the first bytes, not by the suffix: an open file may have no name.
        if data.startswith(b"PAR1"):
            frame = pd.read_parquet(BytesIO(data))
            return source, [str(name) for name in frame.columns], frame
        names = {*wanted}
        head, rows = read_rows(data, names.__contains__)
        # Statcast's tables have ninety columns; only about twenty are kept in memory.
        kept = [i for i, name in enumerate(head) if name in names]
        cells = [
            [None if i >= len(row) or row[i].strip() in _MISSING else row[i] for i in kept]
            for _, row in rows
        ]
    except ValueError as error:
        raise TableError(f"{source}: {error}") from None
    return source, head, pd.DataFrame(cells, columns=[head[i] for i in kept], dtype="string")


def _content(table: str | Path | TextIO) -> bytes:
    """Return the bytes of a file, decompressed; an open text file gives its undecoded bytes."""
    if isinstance(table, str | Path):
        data = Path(table).read_bytes()
    else:
        read: str | bytes = getattr(table, "buffer", table).read()
        data = read.encode() if isinstance(read, str) else read
    return gzip.decompress(data) if data.startswith(b"\x1f\x8b") else data


# Texts that programs and devices write for a missing value.
_MISSING = {
    "", "-", "--", "—", "NA", "N/A", "n/a", "#N/A", "NaN", "nan", "<NA>", "NULL", "null", "None",
}  # fmt: skip


def texts(column: pd.Series) -> pd.Series:
    """Return a column as texts; empty ones are missing."""
    return column.astype("string").str.strip().replace("", None)


def numbers(column: pd.Series) -> Array:
    """Return a column as numbers, with NaN for missing ones; raise a `TableError` for others."""
    values, odd = readable(column)
    if odd.any():
        raise _not_numbers(column, odd)
    return values


def readable(column: pd.Series) -> tuple[Array, Flags]:
    """Return a column as numbers, with NaN for missing ones, and flags of all other cells.

    If no cell is a number, the column has another form, and a `TableError` is raised.
    """
    import pandas as pd

    # Invalid texts become NaN like missing cells; `text` distinguishes the two.
    values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    text = column.notna().to_numpy(dtype=bool)
    if not pd.api.types.is_numeric_dtype(column):
        text = text & texts(column).notna().to_numpy(dtype=bool)
    odd = text & ~np.isfinite(values)
    if odd.any() and odd[text].all():
        raise _not_numbers(column, odd)
    return np.where(odd, np.nan, values), odd


def read_columns(
    frame: pd.DataFrame, names: Iterable[str]
) -> tuple[dict[str, Array], list[tuple[str, Flags]]]:
    """Return columns as numbers, and for each column the rows whose cell is not a number."""
    read = {name: readable(frame[name]) for name in names}
    odd = [(f"{name} is not a finite number", odd) for name, (_, odd) in read.items()]
    return {name: values for name, (values, _) in read.items()}, odd


def _not_numbers(column: pd.Series, odd: Flags) -> TableError:
    first = int(np.argmax(odd))
    # Show the first faulty cell: usually it reveals the form of the others.
    cell = column.iloc[first]
    what = "is not finite" if str(cell).lower().lstrip("+-") in _INFINITE else "is not a number"
    return TableError(
        f"{column.name}: row {first + 1} below the header has {cell!r}, "
        f"which {what}{and_more(int(odd.sum()))}"
    )


_INFINITE = ("inf", "infinity")


def select_rows(
    lacks: Sequence[tuple[str, Flags]], count: int
) -> tuple[tuple[Omission, ...], Flags]:
    """List the faulty rows, each under its first fault, and return flags of the others.

    If no row remains, a `TableError` is raised.
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
        raise TableError(f"no row of the table can be used ({reasons})")
    return tuple(left_out), keep


def require_usual(values: Array, name: str, column: str = "", unit: str = "") -> None:
    """Raise a `TableError` if the median of a column is out of range, as it is in another unit.

    `name` is the column's name in `USUAL`; the table may use another name and another unit.
    """
    if doubt := unusual(values, name, column, unit):
        raise TableError(f"{doubt} The table must be in {unit or USUAL[name].unit} here")


def unusual(values: Array, name: str, column: str = "", unit: str = "") -> str:
    """Return a question if the median of a column is out of range; see `require_usual`."""
    usual = USUAL[name]
    unit = unit or usual.unit
    # The median ignores single wrong values; with many rows its range is narrower.
    bounds = usual.many if usual.many and values.size >= MANY else usual.single
    lowest, highest = bounds
    sized = lowest >= 0.0 and bool((values < 0.0).any())
    median = float(np.median(np.abs(values) if sized else values)) if values.size else np.nan
    if np.isnan(median) or lowest <= _converted(median, unit, usual.unit) <= highest:
        return ""
    low, high = (_converted(x, usual.unit, unit) for x in bounds)
    whose = "the median of its sizes" if sized else "the median"
    return (
        f"{column or name}: {whose} is {median:.4g}, and in {unit} it would lie between {low:.3g} "
        f"and {high:.3g}; is it in {_fitting(median, usual.unit, bounds)}?"
    )


def unusual_rows(columns: Mapping[str, Array], rows: Integers) -> Iterator[str]:
    """Yield a question for each column with a value out of its range in `USUAL`."""
    for name, usual in USUAL.items():
        if name not in columns:
            continue
        lowest, highest = usual.single
        size = np.abs(columns[name]) if lowest >= 0.0 else columns[name]
        odd = (size < lowest) | (size > highest)
        if odd.any():
            first = int(np.argmax(odd))
            value = float(columns[name][first])
            yield (
                f"{name}: row {rows[first]} below the header has {value:g}, outside of what is "
                f"usual, {lowest:g} to {highest:g} {usual.unit}; is it in "
                f"{_fitting(value, usual.unit, usual.single)}?{and_more(int(odd.sum()))}"
            )


def _converted(number: float, unit: str, other: str) -> float:
    si = si_of(unit)
    return from_si(in_si(number, unit, si), other, si)


def _fitting(number: float, unit: str, bounds: tuple[float, float]) -> str:
    """Return the units in which a number would be within bounds, which are in `unit`."""
    sizes = {other: _converted(number, other, unit) for other in UNITS[si_of(unit)]}
    # Two names of one unit have the same size; the later one, the usual one, remains.
    fitting = {size: other for other, size in sizes.items() if bounds[0] <= size <= bounds[1]}
    return " or ".join(fitting.values()) or "another unit"


def require_degrees(angles: Array, name: str, largest: float) -> None:
    """Raise a `TableError` if angles look like radians: none is above `largest`.

    Whole numbers are degrees, however small they are.
    """
    known = angles[~np.isnan(angles)]
    # A table may have small whole numbers of degrees; whole numbers of radians never occur.
    if known.size and np.abs(known).max() <= largest and (known % 1.0).any():
        raise TableError(
            f"{name}: none is above {largest:.3g}; is it in rad? The table must be in degrees here"
        )


def unit_that_explains(ratio: float, unit: str) -> str | None:
    """Return the unit that explains a ratio of given to expected numbers; None if none does.

    Ratios may differ from the factor between units by a fifth; other units differ by more.

    >>> unit_that_explains(0.31, "ft")
    'm'
    """
    factors = UNITS[si_of(unit)]
    for other, factor in factors.items():
        if other != unit and abs(ratio * factor / factors[unit] - 1.0) < 0.2:
            return other
    return None


def and_more(count: int) -> str:
    """Return the end of a message about the first of `count` rows."""
    return "" if count == 1 else f" ({count} rows in all)"
