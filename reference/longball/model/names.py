"""Names that are not known: the end of a message that lists the known ones."""

from __future__ import annotations

import difflib
import re
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
        return f"{hint} {shown[0].upper()}{shown[1:]}" if len(names) <= _MOST_NAMES else hint
    return f"; {shown}"


_MOST_NAMES = 20  # beside one that is meant: a line of more hides it


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Return the question whether a similar name is meant, or nothing.

    A name is similar if its letters are, in any case and with any signs between them (At_Bat,
    pitch-speed), or if one of its words is the given one.

    >>> did_you_mean("coors", ["Citi Field", "Coors Field"])
    ', did you mean Coors Field?'
    >>> did_you_mean("density", ["air", "ball", "air.density"])
    ', did you mean air.density?'
    """
    if not isinstance(given, str) or not (asked := letters(given)):
        return ""
    # Reversed twice, so that the first of two names with the same letters counts.
    by_letters = {letters(name): name for name in reversed([*known])}
    near = difflib.get_close_matches(asked, by_letters, n=1)
    with_word = [
        name
        for name in reversed(by_letters.values())
        if any(word.startswith(asked) for word in re.split(r"\W+", name.lower()))
    ]
    # The surest first: the same letters, then a whole word, then likeness.
    meant = [*filter(None, [by_letters.get(asked)]), *with_word, *(by_letters[x] for x in near)]
    return f", did you mean {meant[0]}?" if meant else ""


def nearest_file(path: str | Path) -> str:
    """Return ``, did you mean NAME?`` with a file beside a path that does not exist, or ``""``."""
    folder = Path(path).parent
    stem = Path(path).stem
    # A common ending alone is no likeness: missing.jsonl is not s.jsonl.
    known = [
        file.name
        for file in (folder.iterdir() if folder.is_dir() else ())
        if difflib.SequenceMatcher(None, stem, file.stem).ratio() > _LIKENESS
    ]
    return did_you_mean(Path(path).name, known)


_LIKENESS = 0.4  # of stems: fly and flies have 0.5


def letters(name: str) -> str:
    """Return the letters and digits of a name, in lower case."""
    return "".join(filter(str.isalnum, name.lower()))
