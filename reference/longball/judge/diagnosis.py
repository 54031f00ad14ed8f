"""What the fingerprints say of a candidate, as JSON has it."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from longball.convergence.report import Frozen


class Suspect(Frozen):
    """A known mistake, and how well it explains a candidate's errors."""

    name: str
    sentence: str = Field(description="what the candidate then does")
    remedy: str = Field(description="how to mend it")
    share: float | None = Field(
        description="of the error explained by it alone; negative if it makes matters worse; null "
        "for single precision, which shows in the numbers and not in their errors"
    )
    step: float | None = Field(description="s, the time step that fits best; null if it has none")
    twins: list[str] = Field(
        description="mistakes that give the same answers to every scene that was judged"
    )


Finding = Literal["nothing", "noise", "known", "unknown"]


class Diagnosis(Frozen):
    """Which known mistakes explain a candidate's errors."""

    finding: Finding = Field(
        description="nothing: no error beyond rounding; noise: errors without a pattern, of the "
        "size of rounding or loose tolerances; known: the mistakes named; unknown: none of them"
    )
    sentence: str
    named: list[str] = Field(description="mistakes that explain the errors, together")
    share: float = Field(description="of the error explained by those named, together")
    error: float = Field(
        description="mean error of the numbers used, relative to the size of each quantity"
    )
    suspects: list[Suspect] = Field(description="those named, then the next best")
    invisible: list[str] = Field(
        description="mistakes that change no answer to any scene that was judged"
    )
    scenes: int = Field(description="how many scenes the fingerprints were taken from")
