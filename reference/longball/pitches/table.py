"""A table of pitches, read: what every row says, in the paper's terms.

The paper knows four things of a pitch (Sec. II): its speed, whether it is straight or breaking,
and in which cell of a 5 × 5 grid it crosses the plate. A table says the same in units and from a
point of view of its own, which are declared here and never guessed.

The grid. The middle 3 × 3 cells are the strike zone. Across, a cell is a third of home plate, the
ledger's ``cell_width`` (0.144 m), the cells are numbered from left to right as the pitcher sees
them, and the middle of the plate is the middle of cell 3. In height, the three cells between the
batter's own ``bottom`` and ``top`` are equal, and cell 1 is the lowest. Cells 1 and 5 are the ring:
open to the outside, so that every pitch is in some cell, as in a chart that shows every pitch.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, TextIO

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, model_validator

from longball.model.readings import SamplingReading

if TYPE_CHECKING:
    import pandas as pd

Floats = npt.NDArray[np.float64]
Booleans = npt.NDArray[np.bool_]
Counts = npt.NDArray[np.int64]

EXAMPLE = Path(__file__).parents[1] / "data" / "statcast_2023-06-11.csv"

# m/s of one unit, m of one unit; all exact by definition.
SPEED_UNITS = {"m/s": 1.0, "km/h": 1 / 3.6, "mph": 0.44704}
LENGTH_UNITS = {"m": 1.0, "cm": 0.01, "ft": 0.3048, "in": 0.0254}

# m/s: no pitch was ever measured faster than 47.4 (105.8 mph); far above it a unit is wrong.
IMPOSSIBLE_SPEED = 60.0

# How many of the rows that are left out for one reason are named by their number.
ROWS_NAMED = 10


class PitchesError(ValueError):
    """Pitches that cannot be used; the message says in a sentence which column or row, and why."""


class Strict(BaseModel):
    """A model that takes what it names, as it is, and nothing else."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Columns(Strict):
    """Which column says what, in which unit, seen from where. The defaults are Statcast's."""

    pitch_type: str = "pitch_type"
    speed: str = Field(default="release_speed", description="speed at release")
    speed_unit: Literal["mph", "km/h", "m/s"] = "mph"
    speed_resolution: float = Field(
        default=0.1,
        ge=0.0,
        description="step in which speeds are written, in their unit; 0: to many digits",
    )
    across: str = Field(default="plate_x", description="horizontal place at the plate")
    height: str | None = Field(default="plate_z", description="height there; null: not recorded")
    top: str = Field(default="sz_top", description="top of the strike zone, if height is a length")
    bottom: str = Field(default="sz_bot", description="its bottom, if height is a length")
    place_unit: Literal["ft", "in", "m", "cm", "cell"] = Field(
        default="ft", description="of across, height, top and bottom; cell: indices from 1 to 5"
    )
    view: Literal["catcher", "pitcher"] = Field(
        default="catcher", description="whose right is positive (or has the high cells)"
    )
    cell_width: float = Field(
        default=SamplingReading().cell_width,
        gt=0.0,
        description="m, of a cell across; paper: not given",
    )


class PitchTypes(Strict):
    """Which types of pitch are straight, which break. The defaults are for Statcast's codes.

    The paper counts curves and two-seam fastballs among the breaking balls, so that straight is
    the four-seam fastball alone, and with it the fastball that Statcast does not specify (FA).
    """

    straight: tuple[str, ...] = ("FF", "FA")
    # fmt: off
    breaking: tuple[str, ...] | None = Field(
        default=(
            "SI", "FT", "FC", "CH", "FS", "FO", "SC", "SL", "ST", "SV", "CU", "KC", "CS", "KN",
            "EP", "GY",
        ),
        description="null: every type that is neither straight nor left out",
    )
    # fmt: on
    left_out: tuple[str, ...] = Field(
        default=("PO", "IN", "AB", "AS", "NP", "UN"),
        description="pitchouts, balls and strikes that nobody threw, unknown pitches",
    )

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        every = [*self.straight, *(self.breaking or ()), *self.left_out]
        twice = sorted({name for name in every if every.count(name) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)}: a type of pitch can be in one class only")
        return self


class Omission(Strict):
    """Rows that were not used."""

    reason: str
    count: int
    first_rows: tuple[int, ...] = Field(
        description=f"numbers of the first {ROWS_NAMED}, from 1 below the header"
    )


@dataclass(frozen=True)
class Pitches:
    """The pitches of a table that say everything the analysis asks.

    Attributes
    ----------
    source
        Where they come from.
    rows_read
        How many rows the table has.
    left_out
        Which of them are not here. A row is listed under the first thing it lacks.
    types
        Type of each pitch, shape (n,).
    straight
        Whether it is a straight ball, shape (n,).
    speed
        m/s, shape (n,).
    across
        Where it crosses the plate, in cells: 3 is the middle, to the right of the pitcher is more.
        Shape (n,).
    height
        In cells: 1.5 is the bottom of the strike zone, 4.5 its top. Shape (n,), or None.
    columns
        How the table was read.
    """

    source: str
    rows_read: int
    left_out: tuple[Omission, ...]
    types: tuple[str, ...]
    straight: Booleans
    speed: Floats
    across: Floats
    height: Floats | None
    columns: Columns


def cell(place: Floats) -> Counts:
    """Return the cell from 1 to 5 of a place measured in cells; the outer cells are open."""
    return np.clip(np.floor(place + 0.5), 1, 5).astype(np.int64)


def read_pitches(
    table: str | Path | TextIO | pd.DataFrame,
    columns: Columns | None = None,
    types: PitchTypes | None = None,
) -> Pitches:
    """Read a table of pitches.

    Parameters
    ----------
    table
        A CSV file with a header, by its path or open; or a pandas DataFrame.
    columns
        Which column says what; default: Statcast's.
    types
        Which types of pitch are straight; default: for Statcast's codes.

    Returns
    -------
    Pitches
        Those of the rows that lack nothing; the others are listed with what they lack.

    Raises
    ------
    PitchesError
        If the table cannot be read, lacks a column, is empty, or holds something that is neither
        a value nor missing.
    """
    columns, types = columns or Columns(), types or PitchTypes()
    source, frame = _frame(table)
    text = {name: _column(frame, name) for name in _needed(columns)}
    if not len(frame):
        raise PitchesError(f"{source}: the table has a header, and no pitches below it")

    kind = text[columns.pitch_type].astype("string").str.strip().replace("", None)
    numbers = {name: _numbers(text[name]) for name in text if name != columns.pitch_type}
    lacks = [(f"{columns.pitch_type} is missing", kind.isna().to_numpy(dtype=bool))]
    lacks += [
        (f"{columns.pitch_type} is {name}", (kind == name).fillna(False).to_numpy(dtype=bool))
        for name in types.left_out
    ]
    lacks += [(f"{name} is missing", np.isnan(values)) for name, values in numbers.items()]
    left_out, keep = _sort_out(lacks, len(frame))

    names = tuple(str(name) for name in kind[keep])
    rows = np.flatnonzero(keep) + 1
    straight = _straight(names, rows, types, columns.pitch_type)
    kept = {name: values[keep] for name, values in numbers.items()}
    return Pitches(
        source=source,
        rows_read=len(frame),
        left_out=left_out,
        types=names,
        straight=straight,
        speed=_speed(kept[columns.speed], rows, columns),
        across=_across(kept[columns.across], rows, columns),
        height=_height(kept, rows, columns),
        columns=columns,
    )


# --- the table ------------------------------------------------------------------------------------


def _frame(table: str | Path | TextIO | pd.DataFrame) -> tuple[str, pd.DataFrame]:
    """Return the name of a table, and the table, as it is written: nothing is converted yet."""
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
        raise PitchesError(f"{source}: the table is empty") from None
    except pd.errors.ParserError as error:
        raise PitchesError(f"{source}: not a table in CSV: {str(error).strip()}") from None
    except UnicodeDecodeError as error:
        raise PitchesError(f"{source}: not UTF-8 text: byte {error.start + 1}") from None
    except OSError as error:
        raise PitchesError(f"{path}: cannot be read: {error.strerror}") from error
    header = [str(name).strip() for name in lines.iloc[0].fillna("")]
    return source, lines.iloc[1:].set_axis(header, axis="columns").reset_index(drop=True)


def _needed(columns: Columns) -> tuple[str, ...]:
    needed = [columns.pitch_type, columns.speed, columns.across]
    if columns.height is not None:
        needed.append(columns.height)
        if columns.place_unit != "cell":
            needed += [columns.top, columns.bottom]
    return tuple(needed)


def _column(frame: pd.DataFrame, name: str) -> pd.Series:
    names = [str(each) for each in frame.columns]
    if names.count(name) == 1:
        return frame.iloc[:, names.index(name)]
    if name in names:
        raise PitchesError(f"{name}: the table has {names.count(name)} columns of this name")
    shown = ", ".join(names[:20]) + (", …" if len(names) > 20 else "")
    raise PitchesError(f"{name}: the table has no such column; its columns are {shown}")


def _numbers(column: pd.Series) -> Floats:
    """Return the numbers of a column, NaN where there is none."""
    import pandas as pd

    values = pd.to_numeric(column, errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
    text = column.notna().to_numpy(dtype=bool)
    if not pd.api.types.is_numeric_dtype(column):
        text = text & column.astype("string").str.strip().ne("").fillna(False).to_numpy(dtype=bool)
    odd = np.flatnonzero((text & np.isnan(values)) | np.isinf(values))
    if odd.size:
        what = "is not a number" if np.isnan(values[odd[0]]) else "is not finite"
        raise PitchesError(
            f"{column.name}: row {odd[0] + 1} below the header has {column.iloc[odd[0]]!r}, "
            f"which {what}{_and_more(odd.size)}"
        )
    return values


def _sort_out(
    lacks: list[tuple[str, Booleans]], count: int
) -> tuple[tuple[Omission, ...], Booleans]:
    """List the rows that lack something, each under the first thing; and mark the others."""
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
        raise PitchesError(f"no pitch of the table says all that is asked ({reasons})")
    return tuple(left_out), keep


# --- its columns, in the paper's terms ------------------------------------------------------------


def _straight(names: tuple[str, ...], rows: Counts, types: PitchTypes, column: str) -> Booleans:
    if types.breaking is not None:
        known = {*types.straight, *types.breaking}
        strange = [row for row, name in zip(rows, names, strict=True) if name not in known]
        if strange:
            name = names[int(np.searchsorted(rows, strange[0]))]
            raise PitchesError(
                f"{column}: row {strange[0]} below the header has {name!r}, which is named neither "
                f"as straight, nor as breaking, nor to be left out{_and_more(len(strange))}"
            )
    straight = np.isin(names, types.straight)
    for found, kind in ((straight, "straight"), (~straight, "breaking")):
        if not found.any():
            seen = ", ".join(sorted(set(names)))
            raise PitchesError(f"{column}: no {kind} ball among the types of pitch here: {seen}")
    return straight


def _speed(speed: Floats, rows: Counts, columns: Columns) -> Floats:
    metres_per_second = speed * SPEED_UNITS[columns.speed_unit]
    too_fast = f"faster in {columns.speed_unit} than any pitch: is it the right unit?"
    _refuse_rows(speed <= 0.0, speed, rows, columns.speed, "a speed is positive")
    _refuse_rows(metres_per_second > IMPOSSIBLE_SPEED, speed, rows, columns.speed, too_fast)
    return metres_per_second


def _across(across: Floats, rows: Counts, columns: Columns) -> Floats:
    if columns.place_unit == "cell":
        _refuse_no_cell(across, rows, columns.across)
        from_middle = across - 3.0
    else:
        from_middle = across * LENGTH_UNITS[columns.place_unit] / columns.cell_width
    # Pitcher and catcher face each other: one's right is the other's left.
    return 3.0 + (from_middle if columns.view == "pitcher" else -from_middle)


def _height(kept: dict[str, Floats], rows: Counts, columns: Columns) -> Floats | None:
    if columns.height is None:
        return None
    height = kept[columns.height]
    if columns.place_unit == "cell":
        _refuse_no_cell(height, rows, columns.height)
        return height
    top, bottom = kept[columns.top], kept[columns.bottom]
    _refuse_rows(top <= bottom, top, rows, columns.top, f"that is not above {columns.bottom}")
    return 1.5 + 3.0 * (height - bottom) / (top - bottom)


def _refuse_no_cell(values: Floats, rows: Counts, column: str) -> None:
    _refuse_rows(~np.isin(values, range(1, 6)), values, rows, column, "a cell is 1, 2, 3, 4 or 5")


def _refuse_rows(wrong: Booleans, values: Floats, rows: Counts, column: str, why: str) -> None:
    if wrong.any():
        first = int(np.argmax(wrong))
        raise PitchesError(
            f"{column}: row {rows[first]} below the header has {values[first]:g}: "
            f"{why}{_and_more(int(wrong.sum()))}"
        )


def _and_more(count: int) -> str:
    return "" if count == 1 else f" ({count} rows in all)"
