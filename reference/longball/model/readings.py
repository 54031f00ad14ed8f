"""The ledger of readings: every passage in which the paper is silent, ambiguous or wrong.

Each entry is a named switch, with its reason in ``ledger.toml``. It changes a scene's physics
(`Reading`, a scene's ``reading`` block), the sampling of at-bats (`SamplingReading`), the paper's
scheme (an option of the engine ``verlet``) or the figure that P(e) is compared with. The default is
the first option. No code decides such a passage without a switch.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from longball.model.block import Given

EffectiveMass = Literal["inertia_over_r_squared", "as_printed"]
Inertia = Literal["solid_cylinder", "thin_rod", "about_centre"]
SampleSpace = Literal["pitches", "batted", "fair"]
Fig7Parameters = Literal["caption", "text"]
VerletForces = Literal[
    "old_carried",
    "old_recomputed",
    "half_step",
    "predicted_carried",
    "predicted_recomputed",
    "implicit",
]
VerletLanding = Literal["interpolated", "first_below"]
AppendixBRoot = Literal["first", "larger"]
ContactForce = Literal["whole", "carried", "late", "early"]

Belongs = Literal["scene", "sampling", "scheme", "figure"]

# Switches of the scheme, and the corresponding options of the engine verlet.
SCHEME_OPTIONS = {
    "verlet_forces": "forces",
    "verlet_landing": "landing",
    "appendix_b_root": "root",
    "contact_force": "contact_force",
}
FIGURE_SWITCH = "fig7_parameters"


class _Switches(Given):
    @model_serializer(mode="wrap")
    def _without_defaults(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        default = type(self).model_fields
        return {
            name: value for name, value in handler(self).items() if value != default[name].default
        }


class Reading(_Switches):
    """A reading of the physics: an option for every switch that changes the result of a scene."""

    effective_mass: EffectiveMass = "inertia_over_r_squared"
    bat_ball_restitution: Literal["as_printed", "nathan", "plain"] = "as_printed"
    reduced_mass: Literal["bat_mass", "effective_mass"] = "bat_mass"
    inertia: Inertia = "solid_cylinder"
    lift_direction: Literal["fixed_spin_axis", "always_up"] = "fixed_spin_axis"
    ground_contact: Literal["centre", "surface"] = "centre"
    slide_direction: Literal["initial", "final"] = "initial"
    spin_parameter: Literal["transverse", "total"] = "transverse"
    drag_spin: Literal["transverse", "total"] = "transverse"
    spin_decay: Literal["path", "time", "nathan"] = "path"
    wind_acts_on: Literal["both", "drag"] = "both"
    pressure: Literal["sea_level", "station"] = "sea_level"
    fence_clearance: Literal["centre", "surface"] = "centre"
    distance_origin: Literal["plate", "launch"] = "plate"

    @model_validator(mode="after")
    def _no_contradiction(self) -> Self:
        if self.bat_ball_restitution == "plain" and self.reduced_mass == "effective_mass":
            raise ValueError(
                "bat_ball_restitution = plain needs the bat's whole mass, which "
                "reduced_mass = effective_mass replaces; for both together, set "
                "bat_ball_restitution = nathan"
            )
        return self


class SamplingReading(_Switches):
    """A reading of the sampling: how at-bats are drawn, and which of them P(e) refers to."""

    speed_table: Literal["columns_swapped", "as_printed"] = "columns_swapped"
    speed_spread: Literal["standard_deviation", "as_printed"] = "standard_deviation"
    offset_spread: float = Field(default=0.0366, gt=0.0, description="m")
    cell_width: float = Field(default=0.144, gt=0.0, description="m")
    sample_space: SampleSpace = "pitches"


def readings_of(switches: Mapping[str, object]) -> tuple[Reading, SamplingReading]:
    """Return the readings of scene and sampling with given switches, or raise a ValueError."""
    sampling = {name: x for name, x in switches.items() if name in SamplingReading.model_fields}
    physics = {name: x for name, x in switches.items() if name not in sampling}
    return Reading.model_validate(physics), SamplingReading.model_validate(sampling)


@dataclass(frozen=True)
class Entry:
    """A line of the ledger."""

    switch: str  # name
    options: tuple[str, ...]  # the default is first
    place: str  # passage of the paper
    why: str  # one sentence on the gap, ambiguity or error

    @property
    def is_switch(self) -> bool:
        """True for a switch; the masses are in the ledger, but are numbers of a scene."""
        return self.belongs != "scene" or self.switch in Reading.model_fields

    @property
    def belongs(self) -> Belongs:
        """The part that it changes: scene, sampling, scheme or figure."""
        if self.switch in SamplingReading.model_fields:
            return "sampling"
        if self.switch in SCHEME_OPTIONS:
            return "scheme"
        return "figure" if self.switch == FIGURE_SWITCH else "scene"


# The texts are in a TOML file, because they are prose: `longball readings` and the report print
# them.
LEDGER: tuple[Entry, ...] = tuple(
    Entry(**written | {"options": tuple(written["options"])})
    for written in tomllib.loads(
        Path(__file__).with_name("ledger.toml").read_text(encoding="utf-8")
    )["entry"]
)
