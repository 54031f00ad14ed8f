"""Names that are not known: the end of a message that lists the known ones."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path


def one_of(these_are: str, given: object, known: Iterable[str]) -> str:
    """Return the known names as the end of a sentence, after the one that is meant if it is clear.

    >>> one_of("the keys are", "lanch", ["launch", "ball"])
    ', did you mean launch? The keys are launch, ball'
    """
    names = [*known]
    shown = f"{these_are} {', '.join(names)}"
    if hint := did_you_mean(given, names):
        return f"{hint} {shown[0].upper()}{shown[1:]}"
    return f"; {shown}"


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Return the question whether a name is meant that is near to what is given, or nothing."""
    names = [*known]
    if not isinstance(given, str):
        return ""
    near = difflib.get_close_matches(given, names, n=1)
    # Names are said in other cases and with other signs: At_Bat, pitch-speed.
    alike = [name for name in names if letters(name) == letters(given)]
    return f", did you mean {[*alike, *near][0]}?" if alike or near else ""


def nearest_file(path: str | Path) -> str:
    """Return ``, did you mean NAME?`` with a file beside a path that does not exist, or ``""``."""
    folder = Path(path).parent
    known = [file.name for file in folder.iterdir()] if folder.is_dir() else []
    return did_you_mean(Path(path).name, known)


def letters(name: str) -> str:
    """Return the letters and digits of a name, in lower case."""
    return "".join(filter(str.isalnum, name.lower()))
