"""Scenes that several files test: the golden cases, which a process reads once."""

from __future__ import annotations

from functools import cache

from longball import golden
from longball.golden.reader import EXTENDED

FAMILIES = tuple(golden.header().families)


@cache
def cases_of(family: str) -> tuple[golden.Case, ...]:
    """Return the golden cases of a family."""
    return tuple(golden.load(family))


def all_cases() -> list[golden.Case]:
    """Return the golden cases of all families, in the order of the files."""
    return [case for family in FAMILIES for case in cases_of(family)]


def paper_cases() -> list[golden.Case]:
    """Return the golden cases of the paper's model."""
    return [case for family in FAMILIES if family not in EXTENDED for case in cases_of(family)]


def case_of(identity: str) -> golden.Case:
    """Return the golden case of an id."""
    return next(case for case in all_cases() if case.id == identity)
