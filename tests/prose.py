"""Check the prose: the first words of docstrings, and phrases of pages and of help.

A docstring begins with a noun phrase or an imperative: a reader sees at once what a thing is.
`make lint` runs the check.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from longball.cli.options import ARGUMENTS, OPTIONS

ROOT = Path(__file__).parent.parent
FOLDERS = ("reference", "analysis", "tests")
PAGES = ("*.md", "docs/*.md", "tests/**/*.md", "analysis/templates/**/*.md")
CLAUSE = re.compile(r"((Return|Tell|Say) )?(what|who|how|whether)\b", re.IGNORECASE)
# Code has words of its own: fences, and what a template computes.
CODE = r"^```.*?^```|\{\{.*?\}\}|\{%.*?%\}|\{#.*?#\}"
# Phrases that outside readers of the pages stumbled over, and words in their place.
PHRASES = {
    r"\bsome (?=\d|fifty|ten |minutes|seconds|per cent)": "about",
    r"\bbut for the\b|\ball but\b": "except",
    r"\bof (your own|yours)\b": "your",
    r"\b(un)?notices?d?\b": "detect",
    r"\btells? (from|apart|whether|how|which|what)\b|\btold (from|apart)\b": "distinguish",
    r"\btells? (this|it|them) from\b": "distinguish",
    r"\bhangs? (on|together)\b": "depends on",
    r"\bheld against\b": "compared with",
    r"\bon the average\b": "on average",
    r"\bof (its|their) own\b": "its",
    r"\bbears? (a|the)\b": "has",
    r"\bone after (an|the )other\b": "in turn",
    r"\bis asked (about|for)\b|\basks it\b": "warns, requires",
    r"\bsome way\b|\bacross the way\b": "perpendicular to the path",
    r"[,;] as [a-z_]+(\.[a-z_]+)?=": "e.g.",
    r"^\| what\b[^?|]*\|": "a noun, as the head of a column",
}
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def clauses(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each docstring that begins with a clause."""
    for node in ast.walk(ast.parse(source)):
        text = isinstance(node, DOCUMENTED) and ast.get_docstring(node)
        if text and CLAUSE.match(text):
            yield node.body[0].lineno, text.splitlines()[0]


def stumbles(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and phrase of each place of a page that has another way to say it."""
    for number, line in enumerate(text.splitlines(), 1):
        for phrase, instead in PHRASES.items():
            if there := re.search(phrase, line, re.IGNORECASE):
                yield number, f"{there[0]!r}: better {instead!r}"


def pages() -> Iterator[tuple[str, str]]:
    """Yield the name and the text of all pages and templates, and of the options' help."""
    for page in sorted(page for pattern in PAGES for page in ROOT.glob(pattern)):
        text = page.read_text(encoding="utf-8")
        yield str(page.relative_to(ROOT)), re.sub(CODE, blank, text, flags=re.S | re.M)
    for table in (ARGUMENTS, OPTIONS):
        for name, row in table.items():
            form = row() if callable(row) else row
            about = form["help"] if isinstance(form, dict) else form
            yield f"help of {name}", about if isinstance(about, str) else about[1]


def blank(code: re.Match[str]) -> str:
    """Return the line breaks of code, so that numbers of lines stay."""
    return "\n" * code[0].count("\n")


def main() -> int:
    """Print each such docstring and phrase, and return their number."""
    found = 0
    for name, text in pages():
        for line, told in stumbles(text):
            found += 1
            print(f"{name}:{line}: {told}")
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob("*.py")):
            for line, text in clauses(file.read_text(encoding="utf-8")):
                found += 1
                print(f"{file.relative_to(ROOT)}:{line}: begins with a clause: {text}")
    return found


if __name__ == "__main__":
    sys.exit(min(main(), 1))
