"""The files of a golden set: names, texts, checksums, schemas, and atomic writing."""

from __future__ import annotations

import hashlib
import os
import tomllib
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from pydantic import BaseModel

from longball import __version__
from longball.golden.case import Case, Header, Probabilities
from longball.model.schema import published, text

# Version of the files' format; README.md in their folder says when it changes.
FORMAT = "1.3"

# Files that come with every set, written by hand.
DOCUMENTS = ("README.md", "CHANGELOG.md", "LICENSE")
CHECKSUMS = "SHA256SUMS"  # as sha256sum writes and reads it
HEADER = "header.json"
HISTORIES = "histories"
PROBABILITIES = "probability.json"
PARTIAL = ".partial"
ARCHIVE = f"longball-golden-{FORMAT}-{__version__}"

# Texts of the headers, by table and key.
TEXTS: dict[str, dict[str, str]] = tomllib.loads(
    Path(__file__).with_name("legend.toml").read_text(encoding="utf-8")
)


@cache
def schemas() -> dict[str, str]:
    """Return file names and contents of the JSON Schemas of a set's files."""
    models: dict[str, type[BaseModel]]
    models = {"case": Case, "header": Header, "probability": Probabilities}
    return {
        f"{name}.schema.json": text(published(f"golden-{name}", model.model_json_schema()))
        for name, model in models.items()
    }


def write_whole(path: Path, content: str) -> None:
    """Write a file atomically: complete, or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # A rename within a folder is atomic. Without fsync it could reach the disk before the content.
    unfinished = path.with_name(path.name + ".tmp")
    with open(unfinished, "w", encoding="utf-8", newline="\n") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(unfinished, path)


def inside(folder: Path, name: str) -> bool:
    """True if a name is that of a file in a folder or below it."""
    # A set may be downloaded: a name such as ../x must not lead out of its folder.
    return (folder / name).resolve().is_relative_to(folder.resolve())


def write_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write files of a set, and update the list of checksums."""
    for name, content in files.items():
        write_whole(folder / name, content)
    sums = {name: checksum(folder / name) for name in files}
    # A set may be written in parts: sums of files that are still there are kept.
    for name, digest in listed(folder).items():
        if inside(folder, name) and (folder / name).is_file():
            sums.setdefault(name, digest)
    lines = (f"{sums[name]}  {name}\n" for name in sorted(sums))
    write_whole(folder / CHECKSUMS, "".join(lines))


def listed(folder: Path) -> dict[str, str]:
    """Return the checksums of a set by file name; none if it has no list."""
    listing = folder / CHECKSUMS
    if not listing.exists():
        return {}
    lines = (line.partition("  ") for line in listing.read_text(encoding="utf-8").splitlines())
    return {name: digest for digest, _, name in lines}


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def export(path: Path, folder: Path) -> int:
    """Write a set as a ZIP archive, the same bytes every time; return how many files it holds."""
    names = sorted([*listed(folder), CHECKSUMS])
    if names == [CHECKSUMS]:
        raise ValueError(f"{folder}: there is no {CHECKSUMS}, and so no golden data")
    contents = {name: (folder / name).read_bytes() for name in names}
    # The earliest time that ZIP can hold; the time of writing would change the bytes.
    never = (1980, 1, 1, 0, 0, 0)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            entry = zipfile.ZipInfo(f"{ARCHIVE}/{name}", never)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return len(names)
