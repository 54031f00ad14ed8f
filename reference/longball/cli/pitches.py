"""Common parts of ``longball movement`` and ``longball spin``: tables of pitches."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from longball.cli.messages import note, show
from longball.cli.options import Options
from longball.cli.tables import in_parts, read_rows
from longball.model.arrays import Array
from longball.model.jsonl import json_line
from longball.pitches.statcast import MeasuredPitches


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
