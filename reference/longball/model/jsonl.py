"""JSON Lines: one object per line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from pydantic_core import to_json

# Bytes. A scene has a few hundred.
LONGEST_LINE = 1 << 20

# JSON allows these characters, but some readers end a line there: str.splitlines, JavaScript.
_BREAKS = {c: f"\\u{ord(c):04x}" for c in "\x85\u2028\u2029"}
_IN_TEXT = str.maketrans(_BREAKS)
_IN_BYTES = [(point.encode(), escape.encode()) for point, escape in _BREAKS.items()]


def json_line(data: Mapping[str, Any], separators: tuple[str, str] | None = None) -> str:
    """Return data as one line of JSON; U+0085, U+2028 and U+2029 are escaped."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=separators)
    return text.translate(_IN_TEXT)


def json_bytes(data: Mapping[str, Any]) -> bytes:
    """Return the same as UTF-8 without spaces, ten times faster."""
    text = to_json(data)
    for point, escape in _IN_BYTES:
        text = text.replace(point, escape)
    return text


def json_or_number(text: str) -> Any:
    """Return the value of a text: JSON (null for no air), a number such as .5, or the text."""
    for read in (json.loads, float):
        with suppress(ValueError, RecursionError):
            return read(text)
    return text
