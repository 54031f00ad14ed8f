"""The verdict for GitHub's Actions: annotations, and the verdict's text in a group.

https://docs.github.com/en/actions/reference/workflows-and-actions/workflow-commands
"""

from __future__ import annotations

from collections.abc import Iterator
from uuid import uuid4

from longball.judge.text import describe, finding_sentences, flagged
from longball.judge.verdict import Verdict

MOST = 10  # annotations of a step that GitHub shows


def annotated(verdict: Verdict, text: str) -> str:
    """Return workflow commands: what is wrong as annotations, and a text of it in a group."""
    # GitHub obeys a command in any line of the output. The text may quote the program, which must
    # not be able to give one: `stop-commands` turns them off until a word that it cannot know.
    level = "error" if verdict.status == "FAILED" else "warning"
    found = [*_sentences(verdict)] or [f"{verdict.right} of {verdict.judged} answers are right"]
    level = "notice" if verdict.passed else level
    title = _escaped(f"longball judge: {verdict.status}", ":,")
    lines = [f"::{level} title={title}::{_escaped(sentence)}" for sentence in found[:MOST]]
    silent = uuid4().hex
    verdict_text = [f"::stop-commands::{silent}", text, f"::{silent}::"]
    return "\n".join([*lines, "::group::verdict", *verdict_text, "::endgroup::"])


def _sentences(verdict: Verdict) -> Iterator[str]:
    """Yield what is wrong, the most useful first."""
    for finding in verdict.diagnosis.findings if verdict.diagnosis else ():
        yield "\n".join(finding_sentences(finding))
    yield from verdict.reasons
    for failure in verdict.failures:
        yield "\n".join([flagged(failure.id, failure.flags), *map(describe, failure.faults[:2])])


def _escaped(text: str, others: str = "") -> str:
    """Return a text as a workflow command takes it; in its parameters `others` are escaped, too."""
    for character in ("%", "\r", "\n", *others):
        text = text.replace(character, f"%{ord(character):02X}")
    return text
