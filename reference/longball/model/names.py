"""Names that are not known: the end of a message that lists the known ones."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def one_of(these_are: str, given: object, known: Iterable[str]) -> str:
    """Return the known names as the end of a sentence, after the one that is meant if it is clear.

    >>> one_of("the keys are", "lanch", ["launch", "ball"])
    ', did you mean launch? The keys are launch, ball'
    """
    names = [*known]
    near = difflib.get_close_matches(given, names, n=1) if isinstance(given, str) else []
    # Names of the field are said in other cases and with other signs: At_Bat, pitch-speed.
    alike = [name for name in names if _letters(name) == _letters(given)]
    shown = f"{these_are} {', '.join(names)}"
    if meant := [*alike, *near][:1]:
        return f", did you mean {meant[0]}? {shown[0].upper()}{shown[1:]}"
    return f"; {shown}"


def _letters(name: object) -> str:
    return "".join(filter(str.isalnum, str(name).lower()))
