"""Tables of measurements that commands read."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from longball.cli.messages import refusing, wrong_call

if TYPE_CHECKING:
    from longball.pitches.statcast import Kind, MeasuredFlies, MeasuredPitches


def chosen_table(table: str, example: bool) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if example and table != "-":
        wrong_call(f"either --example or {table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    # Standard input as a text file, which is read as a path is.
    return EXAMPLE if example else sys.stdin if table == "-" else table


def read_rows(
    source: Any, kind: Kind, games: Path | None, names: Mapping[str, str], *, spin: bool
) -> MeasuredPitches | MeasuredFlies:
    """Return the measured balls of a table; a table that cannot be used is a wrong call."""
    from longball.pitches.models import MODELS
    from longball.pitches.statcast import GAMES, read_measured
    from longball.pitches.table import NoSuchColumn, TableError

    with refusing():
        try:
            return read_measured(source, kind, games or GAMES, spin=spin, names=names)
        except NoSuchColumn as error:
            hint = ""
            if {*error.missing} - (of_spin := {"spin_axis", "release_spin_rate"}):
                hint = "; --column NAME=COLUMN gives the table's name of a column"
            # The commonest lack of all, and there is a way round it.
            if of_spin & {*error.missing}:
                without = ", ".join(name for name, law in MODELS.items() if not law.spin)
                hint += (
                    "; Statcast's tables have spin_axis from 2020 on, and longball measured "
                    f"--model needs no spin with {without}"
                )
            raise TableError(f"{error}{hint}") from None
