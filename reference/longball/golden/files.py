"""The files of a golden set: names, checksums, schemas, and writing without halves."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

from longball.golden.case import Case, Header
from longball.model.schema import DRAFT, text

CHECKSUMS = "SHA256SUMS"  # as sha256sum writes and reads it
HEADER = "header.json"
HISTORIES = "histories"
PARTIAL = ".partial"


def schemas() -> dict[str, str]:
    """Return file names and contents of the JSON Schemas of a case and of the header."""
    return {
        "case.schema.json": text({"$schema": DRAFT} | Case.model_json_schema()),
        "header.schema.json": text({"$schema": DRAFT} | Header.model_json_schema()),
    }


def write_whole(path: Path, content: str) -> None:
    """Write a file so that it is there whole, or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".tmp")
    with open(unfinished, "w", encoding="utf-8", newline="\n") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)


def checksums(folder: Path, names: Iterable[str]) -> str:
    """Return the checksums of files, a line each."""
    return "".join(f"{checksum(folder / name)}  {name}\n" for name in sorted(names))


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
