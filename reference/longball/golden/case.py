"""Golden cases, probabilities and the header of a set, in the form of their files."""

from __future__ import annotations

import json
import math
from decimal import Decimal
from typing import Literal, NamedTuple

from pydantic import Field, field_validator

from longball.model.block import Strict
from longball.model.jsonl import json_line
from longball.model.quantities import numbers_of, unknown
from longball.model.readings import SamplingReading
from longball.model.result import Bounded, Result
from longball.model.scene import AtBatScene, Scene

Difficulty = Literal["lower", "average", "higher"]

# Largest relative error of rounding to a double: half an ulp of 1.
ROUNDING = 2.0**-53


# Flags that solving adds to a case; the others are written with its scene.
FOUND = ("undecided", "many-digits", "fragile", "unconfirmed", "wide")


class Draft(Strict, extra="ignore"):
    """The written part of a case. The rest follows from its scene, which has the case's id."""

    scene: Scene = Field(discriminator="kind")
    comment: str
    flags: tuple[str, ...] = ()

    @field_validator("flags")
    @classmethod
    def _written(cls, flags: tuple[str, ...]) -> tuple[str, ...]:
        # A finished case of an earlier version is also a draft: solving decides its flags again.
        return tuple(flag for flag in flags if flag not in FOUND)


class Drafts(NamedTuple):
    """A family before it is solved: its subject and its cases."""

    about: str
    cases: list[Draft]


class Quantity(Strict):
    """A number of the expected result, for programs that compute in doubles."""

    double: float = Field(description="the double nearest to the truth")
    hex: str = Field(
        pattern=r"^-?0x[01](\.[0-9a-f]+)?p[+-]\d+$",
        description="that double in C's hexadecimal notation",
    )
    attainable: float | None = Field(
        ge=0.0,
        description="error that double precision cannot avoid, in the quantity's unit (see the "
        "header); null if the last bits of an input decide the outcome",
    )
    digits: float | None = Field(
        description="digits that double precision can get right, -log10(attainable / |value|), of "
        "a component by the length of its vector; null without an attainable error, or for zero"
    )


class Condition(Strict):
    """Dependence of the result on its inputs."""

    derivatives: dict[str, dict[str, float | None]] = Field(
        description="of the decisive quantities (the level depends on them) by each input that is "
        "not zero or may be varied about zero; null where a step in either direction changes the "
        "outcome or leaves none"
    )
    rates: dict[str, float] = Field(
        description="speed, m/s, at which the ball crosses the surface of each event: "
        "plate |vx|, contact |d·v|/(R + r_b), landing |vz|; slow is hard"
    )


class Confirmation(Strict):
    """The result of the independent method."""

    engine: str = Field(description="the method and its options")
    outcome: str | None = Field(description="null if it could not decide either")
    agreement: float | None = Field(
        ge=0.0,
        description="largest difference from the expected values in units of 1e-30 of the "
        "quantity's size (see the header); null if there is nothing to compare",
    )


class Case(Strict):
    """A scene, its proven result, and its difficulty."""

    id: str = Field(min_length=1, description="of the case and of its scene; never reused")
    family: str
    level: Difficulty = Field(description="difficulty, by digits attainable; see the header")
    comment: str = Field(description="what the case tests")
    flags: tuple[str, ...] = Field(description="each one is explained in the header")
    scene: Scene = Field(discriminator="kind")
    expected: Result = Field(
        description="the result by the contract, in decimal strings with proven radii; with "
        "`error` in place of an outcome if there is none"
    )
    quantities: dict[str, Quantity] = Field(
        description="every number of the result by its path, such as landing.position[0]"
    )
    condition: Condition | None = Field(description="null if there is no outcome")
    confirmation: Confirmation

    def attainable(self, quantity: str) -> float:
        """Return the error that double precision cannot avoid, in the quantity's unit.

        Parameters
        ----------
        quantity
            Name of the quantity, such as ``landing.distance``.

        Returns
        -------
        float
            The error; infinite if an input's last bits decide the outcome.

        Raises
        ------
        KeyError
            If the result has no such quantity; the message gives similar names.
        """
        if quantity not in self.quantities:
            raise KeyError(str(unknown(quantity, self.quantities)))
        error = self.quantities[quantity].attainable
        return math.inf if error is None else error

    def line(self) -> str:
        """Return the case as a line of JSON, with scene and result as in `longball solve`."""
        # The scene is written without its defaults if it was given without them: the family
        # `defaults` tests whether implementations know these.
        whole = self.model_dump(mode="json") | {
            "scene": json.loads(self.scene.as_written()),
            "expected": json.loads(self.expected.line()),
        }
        return json_line(whole, separators=(",", ":"))


class Family(Strict):
    """A file of cases."""

    file: str
    cases: int
    about: str


class Header(Strict):
    """Header of a set: the meaning of its keys and numbers, its families and versions."""

    title: str
    format: str = Field(description="version of the form of the files; see README.md")
    licence: str
    numbers: dict[str, str] = Field(description="the number contract: meaning of each form")
    levels: dict[str, str]
    flags: dict[str, str] = Field(description="every flag in use, and its meaning")
    families: dict[str, Family]
    quick: tuple[str, ...] = Field(
        default=(),
        description="ids of a few cases that detect nearly all edits that any case detects",
    )
    histories: dict[str, str] = Field(description="tables of flights, and their contents")
    made_by: dict[str, str] = Field(description="engines, and versions of the libraries")


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
    slope_error: float = Field(ge=0.0, description="estimated error of the slope")
    confirmation: Second


class ProbabilityCase(Strict):
    """P(e) under one reading."""

    id: str = Field(min_length=1, description="never reused")
    comment: str = Field(description="what the case tests")
    scene: AtBatScene = Field(
        description="the at-bat without its random numbers: restitution, speed, horizontal aim, "
        "height offset and tilt are not used"
    )
    sampling: SamplingReading = Field(
        description="distributions of the at-bats, and the sample space of P"
    )
    rows: tuple[ProbabilityRow, ...]


class Probabilities(Strict):
    """The file of probabilities."""

    title: str
    numbers: dict[str, str] = Field(description="meaning of the numbers")
    made_by: dict[str, str] = Field(description="methods, and versions of the libraries")
    cases: tuple[ProbabilityCase, ...]


def as_double(number: Bounded) -> float:
    """Return the double nearest to a decimal number; Python rounds correctly.

    A negative zero is a zero.
    """
    return float(Decimal(number.value)) + 0.0


def decisions(result: Result) -> tuple[object, ...]:
    """Return a result's decisions: the outcome, and its flags."""
    # Two results with other decisions have different formulas, so their numbers cannot be compared.
    mode = result.impact and result.impact.mode
    fair = result.landing and result.landing.fair
    return result.outcome, mode, result.fence and result.fence.segment, fair


# The quantities for which a scene with this outcome is usually solved. Difficulty and derivatives
# of a case refer to them. Outcomes without an entry, such as airborne, have no such quantity.
_ASKED: dict[str | None, tuple[str, ...]] = {
    "batted": ("landing.distance", "landing.time"),
    "landed": ("landing.distance", "landing.time"),
    "missed": ("contact.margin",),
    "beyond_bat": ("contact.margin",),
    "home_run": ("fence.clearance", "landing.distance"),
    "wall": ("fence.clearance",),
    "struck": ("impact.impulse", "impact.friction_margin"),
    "separating": ("contact.normal_speed",),
    "crossed": ("plate.time", "plate.position[2]"),
}


def decisive(result: Result) -> tuple[str, ...]:
    """Return the names of the quantities that matter most for an outcome."""
    wanted = _ASKED.get(result.outcome, ())
    # Some quantities are missing: an impact scene begins at the contact, and has no margin.
    return tuple(name for name, _ in numbers_of(result) if name in wanted)
