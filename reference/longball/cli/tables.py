"""Tables of measurements that commands read."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TextIO

from longball.cli.messages import wrong_call


def chosen_table(table: str, example: bool) -> str | Path | TextIO:
    """Return the table to read: longball's example, or a file; - is standard input."""
    if example and table != "-":
        wrong_call(f"either --example or {table}, not both")
    from longball.pitches import EXAMPLE  # brings numpy

    # Standard input as a text file, which is read as a path is.
    return EXAMPLE if example else sys.stdin if table == "-" else table
