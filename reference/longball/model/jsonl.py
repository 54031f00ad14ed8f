"""JSON Lines: one object per line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

# Bytes; a scene has some hundred of them.
LONGEST_LINE = 1 << 20

# JSON leaves them as they are, but some readers of lines end one there: str.splitlines, JavaScript.
_BREAKS = {c.encode(): f"\\u{ord(c):04x}".encode() for c in "\x85\u2028\u2029"}


def unbroken(text: bytes) -> bytes:
    """Return JSON that is one line, whatever a reader takes for the end of one."""
    for found, escaped in _BREAKS.items():
        text = text.replace(found, escaped)
    return text


def json_line(data: Mapping[str, Any], separators: tuple[str, str] | None = None) -> str:
    """Return data as one line of JSON."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=separators)
    return unbroken(text.encode()).decode()
