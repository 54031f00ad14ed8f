"""The legend of the golden set, its header: all that its files do not say by themselves."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import flint

from longball import __version__
from longball.engines.enclosure import Enclosure
from longball.engines.multiprecision import Multiprecision
from longball.golden.case import Case, Family, Header
from longball.golden.files import FORMAT
from longball.golden.truth import CONFIRMING, DIGITS, WORK

_TEXTS = tomllib.loads(Path(__file__).with_name("legend.toml").read_text(encoding="utf-8"))
NUMBERS: dict[str, str] = _TEXTS["numbers"]
LEVELS: dict[str, str] = _TEXTS["levels"]
FLAGS: dict[str, str] = _TEXTS["flags"]
NUMBERS_OF_PROBABILITIES: dict[str, str] = _TEXTS["probability"]


def header(
    cases: Mapping[str, list[Case]], about: Mapping[str, str], histories: Mapping[str, str]
) -> Header:
    """Return the header of a set of families; `about` says what each one is."""
    used = {flag for family in cases.values() for case in family for flag in case.flags}
    return Header(
        title="Longball's golden data: scenes of baseball at-bats with proven results",
        format=FORMAT,
        licence="CC0-1.0",
        numbers=NUMBERS,
        levels=LEVELS,
        flags={flag: FLAGS[flag] for flag in sorted(used)},
        families={
            name: Family(file=f"{name}.jsonl", cases=len(family), about=about[name])
            for name, family in cases.items()
        },
        histories=dict(histories),
        made_by=made_by(),
    )


def made_by() -> dict[str, str]:
    """Return who computes, and the versions of everything that takes part."""
    return {
        "truth": f"{Enclosure(DIGITS).description}, and up to {WORK[-1]} where it takes more",
        "confirmation": f"{Multiprecision(CONFIRMING[0]).description}, and up to {CONFIRMING[-1]} "
        "where it takes more",
        "longball": __version__,
        "python-flint": version("python-flint"),
        "FLINT": flint.__FLINT_VERSION__,
        "mpmath": version("mpmath"),
        "numpy": version("numpy"),
    }
