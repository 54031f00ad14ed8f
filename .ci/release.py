"""Tell whether a tag, the package, the changelog and the citation name the same version."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent


def first(pattern: str, file: str) -> tuple[str, ...]:
    """Return what the groups of a pattern match first in a file."""
    found = re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
    return found.groups() if found else ()


def faults(tag: str | None = None) -> list[str]:
    """Return a sentence for each disagreement; without a tag the version may be unreleased."""
    (version,) = first(r'^__version__ = "(.*)"$', "reference/longball/__init__.py")
    (cited,) = first(r"^version: (.*)$", "CITATION.cff")
    date = first(r"^date-released: (.*)$", "CITATION.cff")
    entry = first(r"^## (?:\[?([0-9.]+)\]? - ([0-9-]+)|Unreleased)$", "CHANGELOG.md")
    found = []
    if cited != version:
        found.append(f"CITATION.cff has version {cited}, the package {version}")
    if entry == (None, None):
        if tag:
            found.append("CHANGELOG.md begins with Unreleased")
        if date:
            found.append("CITATION.cff has a date of release, CHANGELOG.md none")
    elif entry != (version, *date):
        found.append(f"CHANGELOG.md begins with {entry}, CITATION.cff has {(cited, *date)}")
    if tag and tag != f"v{version}":
        found.append(f"the tag is {tag}, the version {version}")
    return found


if __name__ == "__main__":
    sys.exit("\n".join(faults(sys.argv[1])))
