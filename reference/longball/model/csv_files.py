"""Reading and writing of CSV files."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import StringIO
from itertools import chain, islice
from typing import Any

# Separators of spreadsheets in countries with a decimal comma.
_OTHERS = {";": "semicolons", "\t": "tabs"}
# First bytes of binary files, with advice.
_BINARY = {
    b"PAR1": "Parquet",
    b"PK\x03\x04": "a spreadsheet or a zip archive; save the sheet as CSV",
    b"\x1f\x8b": "gzip; gunzip unpacks it",
}


Row = tuple[int, list[str]]  # the number of its first line, and its cells


def read_rows(data: bytes, knows: Callable[[str], bool]) -> tuple[list[str], Iterator[Row]]:
    """Return the head of a table, and its rows without blank ones.

    The head is the one of the first rows with the most names known to `knows`, because measuring
    devices write names and dates above it. A ValueError is raised for other files and faulty lines.
    """
    rows = _not_blank(decoded(data))
    first = [*islice(rows, _LINES_ABOVE)]
    if not first:
        raise ValueError("the table is empty")
    heads = [[cell.strip() for cell in cells] for _, cells in first]
    known = [sum(map(knows, head)) for head in heads]
    above = known.index(max(known))
    head = heads[above]
    if not known[above] and (hint := other_separators(head)):
        raise ValueError(f"not a table in CSV{hint}")
    for name in filter(knows, head):
        if head.count(name) > 1:
            raise ValueError(f"the column {name} appears twice")
    return head, _fitting(head, chain(first[above + 1 :], rows))


# Rows in which the head is searched; devices write up to about twenty lines above it.
_LINES_ABOVE = 50


def _not_blank(text: str) -> Iterator[Row]:
    reader = csv.reader(StringIO(text, newline=""), skipinitialspace=True)
    begin = 1
    try:
        for cells in reader:
            number, begin = begin, reader.line_num + 1
            if any(map(str.strip, cells)):
                yield number, cells
    # A quote without an end: the reader is at the end of the file, but the fault is where it began.
    except csv.Error as error:
        raise ValueError(f"line {begin}: {error}") from None


def _fitting(head: Sequence[str], rows: Iterable[Row]) -> Iterator[Row]:
    # Shorter rows are allowed, because programs drop empty cells at the end.
    for number, cells in rows:
        if len(cells) > len(head) and any(cells[len(head) :]):
            raise ValueError(f"line {number}: {len(cells)} cells, but the head has {len(head)}")
        yield number, cells


def other_separators(head: Sequence[str]) -> str:
    """Return the end of a message about a head that is not separated by commas, or ""."""
    for sign, name in _OTHERS.items():
        if any(sign in cell for cell in head):
            return f"; its head has {name} where commas must separate the cells"
    return ""


def decoded(data: bytes) -> str:
    """Return the text of a file in UTF-8, or in UTF-16 with a byte-order mark.

    A ValueError is raised for other encodings, with the position, and for files of other kinds.
    """
    if kind := binary(data):
        raise ValueError(kind)
    # Spreadsheets save "Unicode text" as UTF-16, and begin UTF-8 with the mark EF BB BF.
    utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if utf16 else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(not_utf8(error)) from None
    # JSON; names of columns do not begin with a bracket.
    if text.lstrip()[:1] in ("{", "["):
        raise ValueError(
            "JSON, where a table is needed: a head with the names of its columns, and rows below it"
        )
    return text


def not_utf8(error: UnicodeDecodeError) -> str:
    """Return a sentence on a text that is not UTF-8: position, and advice."""
    if kind := binary(error.object):
        return kind
    byte = error.object[error.start]
    # The most common other encodings. UTF-16 begins with FE FF or FF FE.
    is_utf16 = error.start == 0 and byte >= 0xFE
    name, code = ("UTF-16", "utf-16") if is_utf16 else ("Latin-1", "latin1")
    hint = f"iconv -f {code} -t utf-8 converts {name}"
    return f"not UTF-8 text: byte {error.start + 1} is 0x{byte:02x}; {hint}"


def binary(data: bytes) -> str:
    """Describe data that are not text; empty if they may be text."""
    kinds = [kind for beginning, kind in _BINARY.items() if data.startswith(beginning)]
    return f"not text but {kinds[0]}" if kinds else ""


# Spreadsheets run a cell that begins with one of these as a formula, which can start programs, even
# in quotes. An apostrophe before it prevents this, and is not shown.
_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")


def guarded(cell: Any) -> Any:
    """Return a cell for a file: a text that looks like a formula gets an apostrophe."""
    formula = isinstance(cell, str) and _FORMULA.match(cell) and not _NUMBER.fullmatch(cell)
    return f"'{cell}" if formula else cell


def unguarded(text: str) -> str:
    """Return the text of a cell: the inverse of `guarded`."""
    return text[1:] if text.startswith("'") and _FORMULA.match(text) else text


def write_frame(frame: Any, path: Any) -> None:
    """Write a DataFrame, without its index."""
    from pandas.api.types import is_string_dtype

    texts = [name for name in frame if is_string_dtype(frame[name].dtype)]
    cells = {name: frame[name].map(guarded) for name in texts}
    # By default `csv` does not quote a carriage return, and readers would end the line there.
    odd = any("\r" in str(cell) for column in cells.values() for cell in column)
    quoting = csv.QUOTE_NONNUMERIC if odd else csv.QUOTE_MINIMAL
    frame.assign(**cells).to_csv(path, index=False, lineterminator="\n", quoting=quoting)
