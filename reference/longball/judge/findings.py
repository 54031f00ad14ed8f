"""What is said of a candidate's errors, stage by stage."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, Literal

from pydantic import Field

from longball.convergence.report import Frozen

Kind = Literal["named", "probably", "unexplained"]


def many(count: int, noun: str) -> str:
    """Return a number of things: "1 scene", "2 scenes"."""
    return f"{count} {noun}{'s' * (count != 1)}"


class Finding(Frozen):
    """Something that is wrong at a stage."""

    stage: str
    quantity: str
    kind: Kind
    names: list[str] = Field(description="of the explanation, then of those that do as well")
    sentence: str
    remedy: str | None = None
    share: float = Field(description="of the stage's error that this explains")
    step: float | None = Field(default=None, description="s, of a scheme")
    wrong: int = Field(description="scenes in which the stage does not follow")
    checked: int
    worst: float = Field(description="largest relative error")
    scenes: str | None = Field(default=None, description="a rule that tells the wrong scenes")
    example: str | None = Field(default=None, description="id of one of the wrong scenes")

    @property
    def beside_stage(self) -> str:
        """The sentence where the stage stands before it already."""
        said = self.sentence.removeprefix(f"{self.stage}: ").removeprefix(f"{self.stage}, ")
        return re.sub(f"^{self.stage} alone", "here alone", said)


def found(
    stage: str, sentence: str, wrong: int, checked: int, names: Sequence[str] = (), **more: Any
) -> Finding:
    """Return a finding that is named, if there are names, and explains all of the error or none."""
    said = {"quantity": "", "kind": "named" if names else "unexplained", "worst": 1.0}
    return Finding(
        stage=stage, sentence=sentence, wrong=wrong, checked=checked, names=list(names),
        **said | {"share": 1.0 if names else 0.0} | more,
    )  # fmt: skip


class StageRow(Frozen):
    """How often a stage follows from the stages before."""

    stage: str
    checked: int
    wrong: int
    worst: float = Field(description="largest error relative to its quantity")
    example: str | None = Field(description="id of the scene with the largest error")


class Diagnosis(Frozen):
    """What is wrong, stage by stage."""

    sentence: str
    first: str | None = Field(description="the first stage with errors that matter")
    stages: list[StageRow]
    clean: list[str] = Field(description="stages that follow in every scene")
    findings: list[Finding]
    conduct: list[str] = Field(default=[], description="what a second run told")
    smallest: dict[str, Any] | None = Field(
        default=None, description="a scene with as little in it as still fails"
    )

    @property
    def named(self) -> list[str]:
        """Return the names of what is named, the ties behind each."""
        return [name for f in self.findings if f.kind == "named" for name in f.names]
