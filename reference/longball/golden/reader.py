"""Reading the golden data."""

from __future__ import annotations

from pathlib import Path

from longball.golden.case import Case, Draft, Drafts, Header, Probabilities
from longball.model.names import one_of

DATA = Path(__file__).parent / "data"


def header(folder: Path = DATA) -> Header:
    """Return the header of the set: number contract, levels, flags, families, versions."""
    return Header.model_validate_json((folder / "header.json").read_bytes())


# Families of the extended model. An implementation of the paper's model would reject their keys, so
# `load` omits them by default.
EXTENDED = (
    "impact-oblique", "fence", "flight-spin-lift", "flight-spin-drag", "flight-spin-decay",
    "flight-wind", "flight-weather", "flight-side", "flight-kinks", "flight-real", "at-bat-real",
    "hard-real", "combined", "defaults", "various-real",
)  # fmt: skip


QUICK = "quick"  # the cases that the header lists, from all families


def load(family: str | None = None, folder: str | Path = DATA) -> list[Case]:
    """Return the cases of a family, of all families ("all"), or of all of the paper's model (None).

    The other families have keys that an implementation of the paper's model does not know. "quick"
    selects a few cases that together detect nearly every edit of the model.

    Parameters
    ----------
    family
        Name of a family, "all", "quick", or None.
    folder
        Folder of a set; by default the one that comes with longball.

    Returns
    -------
    list of Case
        Cases in the order of the files.

    Raises
    ------
    ValueError
        If there is no such family; the message gives similar names.
    """
    folder = Path(folder)
    top = header(folder)
    families = top.families
    if family is not None and family not in (*families, "all", QUICK):
        raise ValueError(
            f"there is no family {family!r}{one_of('the families are', family, families)}"
        )
    chosen = [family] if family not in (None, "all", QUICK) else list(families)
    if family is None:
        chosen = [name for name in chosen if name not in EXTENDED]
    cases = [case for name in chosen for case in read_cases(folder / families[name].file)]
    return [case for case in cases if case.id in top.quick] if family == QUICK else cases


def read_cases(file: Path) -> list[Case]:
    """Return the cases of a file of JSON Lines."""
    return [Case.model_validate_json(line) for line in file.read_bytes().splitlines()]


def drafts(folder: Path = DATA) -> dict[str, Drafts]:
    """Return the families of a set with the written part of their cases.

    A new case may have no other part.
    """
    by_family = {}
    for name, family in header(folder).families.items():
        lines = (folder / family.file).read_bytes().splitlines()
        by_family[name] = Drafts(family.about, [Draft.model_validate_json(line) for line in lines])
    return by_family


def probabilities(folder: Path = DATA) -> Probabilities:
    """Return P(e) under several readings, with the errors of each value."""
    return Probabilities.model_validate_json((folder / "probability.json").read_bytes())
