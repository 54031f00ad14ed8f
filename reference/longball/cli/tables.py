"""Input of commands: tables of measurements."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

from longball.cli.cluster import on_cluster
from longball.cli.messages import refusing, wrong_call
from longball.cli.options import Options
from longball.engines.parallel import in_parallel

if TYPE_CHECKING:
    from longball.pitches.statcast import Kind, MeasuredFlies, MeasuredPitches

T = TypeVar("T")

# Rows of one task: a second of work, compared with which the transfer is negligible.
PART = 20_000


def chosen_table(o: Options) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if o.example and o.table != "-":
        wrong_call(f"either --example or {o.table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    # Standard input is an open text file; other tables are paths.
    return EXAMPLE if o.example else sys.stdin if o.table == "-" else str(o.table)


def read_rows(o: Options, kind: Kind, *, spin: bool) -> MeasuredPitches | MeasuredFlies:
    """Return the measured balls of a table; an unusable table is a usage error."""
    from longball.pitches.models import MODELS
    from longball.pitches.statcast import GAMES, read_measured
    from longball.pitches.table import NoSuchColumn, TableError

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
