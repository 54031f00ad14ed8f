"""Messages about unknown names: the known ones, and the one that was probably meant."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from pathlib import Path


def one_of(these_are: str, given: object, known: Iterable[str]) -> str:
    """Return the end of a message: the likely name, if any, and the known names.

    >>> one_of("the keys are", "lanch", ["launch", "ball"])
    ', did you mean launch? The keys are launch, ball'
    """
    names = [*known]
    shown = f"{these_are} {', '.join(names)}"
    if hint := did_you_mean(given, names):
        return f"{hint} {shown[0].upper()}{shown[1:]}" if len(names) <= _MOST_NAMES else hint
    return f"; {shown}"


# A longer list would hide the suggestion.
_MOST_NAMES = 20


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Return a suggestion of a similar name, or "".

    Similarity ignores case and signs between letters (At_Bat, pitch-speed). A name is also similar
    if one of its words begins with the given one.

    >>> did_you_mean("coors", ["Citi Field", "Coors Field"])
    ', did you mean Coors Field?'
    >>> did_you_mean("density", ["air", "ball", "air.density"])
    ', did you mean air.density?'
    """
    if not isinstance(given, str) or not (asked := letters(given)):
        return ""
    # In reverse order, so that the first of two names with the same letters remains.
    by_letters = {letters(name): name for name in reversed([*known])}
    near = difflib.get_close_matches(asked, by_letters, n=1)
    with_word = [
        name
        for name in reversed(by_letters.values())
        if any(word.startswith(asked) for word in re.split(r"\W+", name.lower()))
    ]
    # From certain to vague: equal letters, a word in the name, a similar spelling.
    meant = [*filter(None, [by_letters.get(asked)]), *with_word, *(by_letters[x] for x in near)]
    return f", did you mean {meant[0]}?" if meant else ""


def nearest_file(path: str | Path) -> str:
    """Return a suggestion of a file in the folder of a missing one, or ""."""
    folder = Path(path).parent
    stem = Path(path).stem
    # Compare the stems: the common suffix would make missing.jsonl similar to s.jsonl.
    known = [
        file.name
        for file in (folder.iterdir() if folder.is_dir() else ())
        if difflib.SequenceMatcher(None, stem, file.stem).ratio() > _LIKENESS
    ]
    return did_you_mean(Path(path).name, known)


# Least similarity of two stems; that of fly and flies is 0.5.
_LIKENESS = 0.4


def letters(name: str) -> str:
    """Return the letters and digits of a name, in lower case."""
    return "".join(filter(str.isalnum, name.lower()))
