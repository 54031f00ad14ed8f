"""Pitches of a table in the paper's terms.

The paper describes a pitch (Sec. II) by its speed, its class (straight or breaking), and its cell
of a 5 × 5 grid at the plate. Tables have other units and frames, which are declared here and never
guessed.

The middle 3 × 3 cells of the grid are the strike zone. Across, a cell is a third of home plate, the
ledger's ``cell_width`` (0.144 m); cells are numbered from left to right as the pitcher sees them,
and the middle of the plate is the middle of cell 3. In height, the three cells between the batter's
``bottom`` and ``top`` are equal, and cell 1 is the lowest. Cells 1 and 5 are open to the outside,
so that every pitch is in a cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, TextIO

import numpy as np
from pydantic import Field, model_validator

from longball.model.arrays import Array, Flags, Integers
from longball.model.block import Strict
from longball.model.readings import SamplingReading
from longball.pitches.table import (
    LENGTH_UNITS,
    SPEED_UNITS,
    Omission,
    TableError,
    and_more,
    read_columns,
    read_table,
    require_usual,
    select_rows,
    texts,
)

if TYPE_CHECKING:
    import pandas as pd

# m/s. The fastest measured pitch had 47.4 (105.8 mph); far above it, the unit is wrong.
IMPOSSIBLE_SPEED = 60.0


class Columns(Strict):
    """Columns of a table: their names, units and frame. The defaults are Statcast's."""

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
    """Types of pitches that are straight, and that break. The defaults are Statcast's codes.

    The paper counts curves and two-seam fastballs among the breaking balls. Only the four-seam
    fastball is straight, and the fastball that Statcast does not specify (FA).
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
        # A type in two classes would be fitted in the first one silently.
        twice = sorted({name for name in every if every.count(name) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)}: a type of pitch can be in one class only")
        return self


@dataclass(frozen=True)
class Pitches:
    """The complete pitches of a table; arrays have the shape (n,)."""

    source: str  # name of the table
    rows_read: int  # number of rows of the table
    # Omitted rows, each under its first fault.
    left_out: tuple[Omission, ...]
    types: tuple[str, ...]
    straight: Flags  # True for a straight ball
    speed: Array  # m/s
    # Position at the plate, in cells: 3 is the middle, larger values are to the pitcher's right.
    across: Array
    # Height at the plate, in cells: 1.5 is the bottom of the strike zone, 4.5 its top; or None.
    height: Array | None
    columns: Columns  # as the table was read


def cell(place: Array) -> Integers:
    """Return the cell, 1 to 5, of a position in cells; the outer cells are open."""
    return np.clip(np.floor(place + 0.5), 1, 5).astype(np.int64)


def read_pitches(
    table: str | Path | TextIO | pd.DataFrame,
    columns: Columns | None = None,
    types: PitchTypes | None = None,
) -> Pitches:
    """Read the pitches of a table: a CSV file by its path, an open one, or a pandas DataFrame.

    The default columns and types are Statcast's. Incomplete rows are listed with the reason. A
    `TableError` says why a table cannot be used.
    """
    columns, types = columns or Columns(), types or PitchTypes()
    in_cells = columns.place_unit == "cell"
    places = {"plate_x": columns.across}
    if columns.height is not None:
        places["plate_z"] = columns.height
        places |= {} if in_cells else {"sz_top": columns.top, "sz_bot": columns.bottom}
    read = [columns.speed, *places.values()]
    source, frame = read_table(table, [columns.pitch_type, *read])
    kind = texts(frame[columns.pitch_type])
    values, odd = read_columns(frame, read)

    # Into the paper's terms. Pitcher and catcher face each other, which exchanges left and right.
    speed = values[columns.speed] * SPEED_UNITS[columns.speed_unit]
    side = 1.0 if columns.view == "pitcher" else -1.0
    placed = {name: values[column] for name, column in places.items()}
    across, height = placed["plate_x"], placed.get("plate_z")
    lacks_place: list[tuple[str, Flags]] = []
    if in_cells:
        across = 3.0 + side * (across - 3.0)
        lacks_place = [
            (f"{column} is none of the cells 1 to 5", ~np.isin(values[column], range(1, 6)))
            for column in places.values()
        ]
    else:
        across = 3.0 + side * across * LENGTH_UNITS[columns.place_unit] / columns.cell_width
    if height is not None and not in_cells:
        top, bottom = placed["sz_top"], placed["sz_bot"]
        # The strike zone fills cells 2 to 4, from 1.5 to 4.5. Rows without one are omitted below.
        with np.errstate(divide="ignore", invalid="ignore"):
            height = 1.5 + 3.0 * (height - bottom) / (top - bottom)
        lacks_place = [(f"{columns.top} is not above {columns.bottom}", top <= bottom)]

    # omit faulty rows, then test whether the units of the others are plausible
    too_fast = f"{columns.speed} is faster in {columns.speed_unit} than any pitch: the right unit?"
    lacks = [
        (f"{columns.pitch_type} is missing", kind.isna().to_numpy(dtype=bool)),
        *(
            (f"{columns.pitch_type} is {name}", (kind == name).fillna(False).to_numpy(dtype=bool))
            for name in types.left_out
        ),
        *odd,
        *((f"{name} is missing", np.isnan(column)) for name, column in values.items()),
        (f"{columns.speed} is not positive", speed <= 0.0),
        (too_fast, speed > IMPOSSIBLE_SPEED),
        *lacks_place,
    ]
    left_out, keep = select_rows(lacks, len(frame))
    names = tuple(str(name) for name in kind[keep])
    straight = _straight(names, np.flatnonzero(keep) + 1, types, columns.pitch_type)
    require_usual(values[columns.speed][keep], "release_speed", columns.speed, columns.speed_unit)
    for name, column in places.items():
        if not in_cells:
            require_usual(values[column][keep], name, column, columns.place_unit)
    return Pitches(
        source=source,
        rows_read=len(frame),
        left_out=left_out,
        types=names,
        straight=straight,
        speed=speed[keep],
        across=across[keep],
        height=None if height is None else height[keep],
        columns=columns,
    )


def _straight(names: tuple[str, ...], rows: Integers, types: PitchTypes, column: str) -> Flags:
    if types.breaking is not None:
        known = {*types.straight, *types.breaking}
        strange = [row for row, name in zip(rows, names, strict=True) if name not in known]
        if strange:
            name = names[int(np.searchsorted(rows, strange[0]))]
            raise TableError(
                f"{column}: row {strange[0]} below the header has {name!r}, which is named neither "
                f"as straight, nor as breaking, nor to be left out{and_more(len(strange))}"
            )
    # Without a list of breaking types, every type that is not straight breaks.
    straight = np.isin(names, types.straight)
    for chosen, kind in ((straight, "straight"), (~straight, "breaking")):
        if not chosen.any():
            seen = ", ".join(sorted(set(names)))
            raise TableError(f"{column}: no {kind} ball among the types of pitch here: {seen}")
    return straight
