"""The golden data as one file to hand on."""

from __future__ import annotations

import zipfile
from pathlib import Path

from longball import __version__
from longball.golden.files import CHECKSUMS, FORMAT, listed
from longball.golden.reader import DATA

NAME = f"longball-golden-{FORMAT}-{__version__}"

_NEVER = (1980, 1, 1, 0, 0, 0)  # the same set makes the same archive, whenever


def export(path: Path, folder: Path = DATA) -> int:
    """Write a set as a ZIP archive; return how many files it holds.

    Raises
    ------
    ValueError
        If there is no set in the folder.
    """
    names = sorted([*listed(folder), CHECKSUMS])
    if names == [CHECKSUMS]:
        raise ValueError(f"{folder}: there is no {CHECKSUMS}, and so no golden data")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in names:
            entry = zipfile.ZipInfo(f"{NAME}/{name}", _NEVER)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, (folder / name).read_bytes())
    return len(names)
