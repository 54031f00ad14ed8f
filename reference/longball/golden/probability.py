"""The golden probabilities of a home run as they stand in their file."""

from __future__ import annotations

from pydantic import Field

from longball.model.block import Strict
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene


class Second(Strict):
    """The estimate of the second method."""

    p: float
    standard_error: float = Field(ge=0.0, description="from independent scrambles")


class ProbabilityRow(Strict):
    """P(e) at one restitution."""

    e: float = Field(ge=0.0, le=1.0, description="restitution of the ball")
    p: float = Field(description="the probability of a home run")
    error: float = Field(ge=0.0, description="estimated, not proven: |truth - p| <= error")
    slope: float = Field(description="dP/de")
    slope_error: float = Field(ge=0.0, description="the same of the slope")
    confirmation: Second


class ProbabilityCase(Strict):
    """P(e) under one reading."""

    id: str = Field(min_length=1, description="never reused")
    comment: str = Field(description="what the case tests")
    scene: AtBatScene = Field(
        description="everything that is not random; its restitution, speed, horizontal aim, "
        "height offset and tilt are not used"
    )
    sampling: SamplingReading = Field(
        description="how the at-bats are drawn, and of which of them P is a share"
    )
    rows: tuple[ProbabilityRow, ...]


class Probabilities(Strict):
    """The file of probabilities."""

    title: str
    numbers: dict[str, str] = Field(description="what the numbers mean")
    made_by: dict[str, str] = Field(description="methods, and versions of the libraries")
    cases: tuple[ProbabilityCase, ...]
