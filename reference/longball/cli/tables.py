"""Tables of measured pitches as input of commands, and tables of results by pitch."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TextIO, TypeVar

import numpy as np

from longball.cli.cluster import on_cluster
from longball.cli.messages import note, refusing, show, wrong_call
from longball.cli.options import Options
from longball.engines.parallel import in_parallel
from longball.model.arrays import Array
from longball.model.jsonl import json_line
from longball.pitches import EXAMPLE
from longball.pitches.models import MODELS
from longball.pitches.statcast import GAMES, Kind, MeasuredFlies, MeasuredPitches, read_measured
from longball.pitches.table import NoSuchColumn, TableError

T = TypeVar("T")

# Rows of one task: a second of work, compared with which the transfer is negligible.
PART = 20_000


def chosen_table(o: Options) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if o.example and o.table != "-":
        wrong_call(f"either --example or {o.table}, not both")
    # Standard input is an open text file; other tables are paths.
    return EXAMPLE if o.example else sys.stdin if o.table == "-" else str(o.table)


def read_rows(o: Options, kind: Kind, *, spin: bool) -> MeasuredPitches | MeasuredFlies:
    """Return the measured balls of a table; an unusable table is a usage error."""
    table = chosen_table(o)
    games = vars(o).get("games") or GAMES  # not all commands need the weather
    with refusing():
        try:
            return read_measured(table, kind, games, spin=spin, names=o.column)
        except NoSuchColumn as error:
            hint = ""
            if {*error.missing} - (of_spin := {"spin_axis", "release_spin_rate"}):
                hint = "; --column NAME=COLUMN gives the table's name of a column"
            # The most common case: tables before 2020. Models without spin still work.
            if "vx0" in error.missing and {"launch_speed", "launch_angle"} <= {*error.present}:
                hint = "; longball measured --kind batted predicts batted balls"
            elif of_spin & {*error.missing}:
                without = ", ".join(name for name, law in MODELS.items() if not law.spin)
                hint += (
                    "; Statcast's tables have spin_axis from 2020 on, and longball measured "
                    f"--model needs no spin with {without}"
                )
            raise TableError(f"{error}{hint}") from None


def in_parts(
    o: Options,
    function: Callable[..., T],
    rows: MeasuredPitches | MeasuredFlies,
    *more: Any,
) -> list[T]:
    """Return a function's values for parts of the rows, in order, from all workers."""
    begins = range(0, len(rows), PART)
    calls = ((rows.chosen(slice(i, i + PART)), *more) for i in begins)
    with on_cluster(o) as workers:
        return [*in_parallel(function, calls, workers)]


# --- pitches --------------------------------------------------------------------------------------


def pitches_of(o: Options, *, spin: bool) -> MeasuredPitches:
    """Return the pitches of a table, and print a note on omitted rows."""
    pitches = read_rows(o, "pitch", spin=spin)
    assert isinstance(pitches, MeasuredPitches)
    note(f"{pitches.source}: {len(pitches)} pitches used of {pitches.rows_read} rows")
    for omission in (*pitches.left_out, *pitches.doubts):
        note(f"  {omission}")
    return pitches


def answers(
    o: Options, question: Callable[..., Mapping[str, Array]], pitches: MeasuredPitches, *more: Any
) -> dict[str, Array]:
    """Return the columns that a function computes for pitches, in parts."""
    parts = in_parts(o, question, pitches, *more)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def show_each(pitches: MeasuredPitches, columns: dict[str, Any]) -> None:
    """Print a line of JSON for each pitch, without missing numbers."""
    # x == x is false for NaN.
    every = {"row": pitches.rows, "pitch_type": pitches.labels} | columns
    for values in zip(*(column.tolist() for column in every.values()), strict=True):
        print(json_line({name: x for name, x in zip(every, values, strict=True) if x == x}))


def show_types(pitches: MeasuredPitches, columns: Mapping[str, Array]) -> None:
    """Print the median of columns for each type of pitch, the most common first; - for none."""
    types, counts = np.unique(pitches.labels, return_counts=True)
    rows = []
    for i in np.argsort(-counts, kind="stable"):
        here = pitches.labels == types[i]
        known = (column[here & ~np.isnan(column)] for column in columns.values())
        cells = (f"{np.median(x):.4g}" if x.size else "-" for x in known)
        rows.append([str(types[i]), str(counts[i]), *cells])
    show(["median of type", "n", *columns], rows)
