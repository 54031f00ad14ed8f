"""The diagnosis of a verdict: models of its JSON."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any, Literal

from pydantic import Field

from longball.convergence.report import Frozen

Kind = Literal["named", "nearest", "located"]


def many(count: int, noun: str) -> str:
    """A count with its noun: "1 scene", "2 scenes"."""
    return f"{count} {noun}{'s' * (count != 1)}"


class Finding(Frozen):
    """Something that is wrong at a stage.

    Attributes
    ----------
    kind
        "named" if an edit reproduces the candidate's numbers, "nearest" if one comes close, or
        "located" if only the stage is known.
    sentence, remedy
        The error in a sentence, and the right formula or an instruction.

    Examples
    --------
    >>> found = Finding(
    ...     stage="velocity after", quantity="impact.velocity", kind="named",
    ...     edit="uses M for m", wrong=83, checked=83, worst=0.84, example="at-bat-007",
    ...     sentence="velocity after: your program uses M for m. This step is wrong in 83 of 83 "
    ...     "scenes, given your own earlier values (relative error up to 84%).",
    ... )
    >>> many(found.wrong, "scene"), size(found.worst), found.remedy
    ('83 scenes', '84%', None)
    """

    stage: str
    quantity: str
    kind: Kind
    edit: str | None = Field(default=None, description="what stands for what; none if located")
    sentence: str
    remedy: str | None = None
    scenes: str | None = Field(default=None, description="a rule for the wrong scenes")
    bits: float | None = Field(default=None, description="of evidence beyond chance")
    wrong: int = Field(description="scenes in which the stage does not follow")
    checked: int
    worst: float = Field(description="largest relative error")
    example: str | None = Field(default=None, description="id of one of the wrong scenes")
    step: float | None = Field(default=None, description="s, of a scheme")


class StageRow(Frozen):
    """Counts of a stage: scenes that have it, and those in which it is wrong."""

    stage: str
    checked: int
    wrong: int
    worst: float = Field(description="largest error relative to its quantity")
    example: str | None = Field(description="id of the scene with the largest error")


class Diagnosis(Frozen):
    """The findings of a candidate, stage by stage."""

    sentence: str
    first: str | None = Field(description="the first stage with errors that matter")
    stages: list[StageRow]
    clean: list[str] = Field(description="stages that follow in every scene")
    findings: list[Finding]
    conduct: list[str] = Field(default=[], description="differences between two runs")
    smallest: dict[str, Any] | None = Field(
        default=None, description="a scene with as little in it as still fails"
    )

    @property
    def named(self) -> list[str]:
        """The edits that are named."""
        return [f.edit for f in self.findings if f.edit]


def size(relative: float) -> str:
    """A relative error as people write it: "1.8", "2%", "5e-06"."""
    if relative >= 1:
        return f"{relative:.2g}"
    return f"{100 * relative:.2g}%" if relative >= 1e-3 else f"{relative:.0e}"


def joined(names: Collection[str]) -> str:
    """Names as a list in a sentence."""
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last
