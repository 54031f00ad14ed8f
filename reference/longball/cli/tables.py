"""Tables of measurements that commands read."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from longball.cli.messages import fail, wrong_call


def chosen_table(table: str, example: bool) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if example and table != "-":
        wrong_call(f"either --example or {table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    # Standard input as a text file: pandas reads both.
    return EXAMPLE if example else sys.stdin if table == "-" else table


@contextmanager
def reading_table() -> Iterator[None]:
    """Exit with status 1 on a bad table, or 2 on one that cannot be opened, and say why."""
    from longball.pitches import TableError

    try:
        yield
    except TableError as error:
        # A file that cannot be opened is a wrong call, one that cannot be understood a failure.
        if isinstance(error.__cause__, OSError):
            wrong_call(str(error))
        fail(str(error))
