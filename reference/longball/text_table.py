"""Tables as lines of text."""

from __future__ import annotations

from collections.abc import Collection, Sequence


def aligned(table: Sequence[Sequence[str]], right: Collection[int] = ()) -> list[str]:
    """Return the rows of a table as lines; the columns `right` are right-aligned."""
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = []
    for row in table:
        cells = enumerate(zip(row, widths, strict=True))
        lines.append("  ".join(
            cell.rjust(width) if i in right else cell.ljust(width) for i, (cell, width) in cells
        ).rstrip())  # fmt: skip
    return lines
