"""Check the first words of all docstrings; `make lint` runs it.

A docstring begins with a noun phrase or an imperative: a reader sees at once what a thing is.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDERS = ("reference", "analysis", "tests")
CLAUSE = re.compile(r"((Return|Tell|Say) )?(what|who|how|whether)\b", re.IGNORECASE)
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def clauses(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each docstring that begins with a clause."""
    for node in ast.walk(ast.parse(source)):
        text = isinstance(node, DOCUMENTED) and ast.get_docstring(node)
        if text and CLAUSE.match(text):
            yield node.body[0].lineno, text.splitlines()[0]


def main() -> int:
    """Print each such docstring, and return their number."""
    found = 0
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            for line, text in clauses(file.read_text(encoding="utf-8")):
                found += 1
                print(f"{file.relative_to(ROOT)}:{line}: begins with a clause: {text}")
    return found


if __name__ == "__main__":
    sys.exit(min(main(), 1))
