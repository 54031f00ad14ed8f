"""CSV as it is written: what all that read it have in common."""

from __future__ import annotations

from collections.abc import Sequence

# Spreadsheets write what a country's decimal comma leaves them.
_OTHERS = {";": "semicolons", "\t": "tabs"}
# How files begin that are given where text is expected.
_BINARY = {b"PAR1": "Parquet", b"PK": "a spreadsheet or a zip archive", b"\x1f\x8b": "gzip"}


def other_separators(head: Sequence[str]) -> str:
    """Return the end of a message about a head that other signs than commas seem to separate."""
    for sign, name in _OTHERS.items():
        if any(sign in cell for cell in head):
            return f"; its head has {name} where commas must separate the cells"
    return ""


def not_utf8(error: UnicodeDecodeError) -> str:
    """Say where a text is in another encoding, or what it is instead."""
    for beginning, kind in _BINARY.items():
        if error.object.startswith(beginning):
            return f"not text but {kind}"
    return f"not UTF-8 text: byte {error.start + 1} is 0x{error.object[error.start]:02x}"
