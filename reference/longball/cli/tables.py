"""Tables of measurements that commands read."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from longball.cli.messages import wrong_call


def chosen_table(table: str, example: bool) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if example and table != "-":
        wrong_call(f"either --example or {table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    # Standard input as a text file: pandas reads both.
    return EXAMPLE if example else sys.stdin if table == "-" else table


@contextmanager
def reading_table() -> Iterator[None]:
    """Make a table that cannot be used a wrong call, and say why."""
    from longball.pitches import TableError

    try:
        yield
    except TableError as error:
        wrong_call(str(error))
