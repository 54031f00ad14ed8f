"""The ledger of readings: every place where the paper is silent, ambiguous or wrong.

Each entry is a named switch. It belongs to what it changes: to a scene's physics (`Reading`, a
scene's ``reading`` block), to the sampling of at-bats (`SamplingReading`), to the paper's scheme
(an option of the engine ``verlet``) or to the figure that P(e) is compared with. The default is the
first option. Nothing in the code decides one of these silently.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Self, get_args

from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from longball.model.block import Strict

SpeedTable = Literal["columns_swapped", "as_printed"]
SpeedSpread = Literal["standard_deviation", "as_printed"]
EffectiveMass = Literal["inertia_over_r_squared", "as_printed"]
BatBallRestitution = Literal["as_printed", "nathan", "plain"]
ReducedMass = Literal["bat_mass", "effective_mass"]
Inertia = Literal["solid_cylinder", "thin_rod", "about_centre"]
LiftDirection = Literal["fixed_spin_axis", "always_up"]
SpinParameter = Literal["transverse", "total"]
DragSpin = Literal["transverse", "total"]
SpinDecay = Literal["path", "time", "nathan"]
WindActsOn = Literal["both", "drag"]
Pressure = Literal["sea_level", "station"]
GroundContact = Literal["centre", "surface"]
SlideDirection = Literal["initial", "final"]
FenceClearance = Literal["centre", "surface"]
DistanceOrigin = Literal["plate", "launch"]
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

Belongs = Literal["scene", "sampling", "scheme", "figure"]

# The switches of the scheme, and the options of the engine verlet that they are.
SCHEME_OPTIONS = {"verlet_forces": "forces", "verlet_landing": "landing", "appendix_b_root": "root"}
FIGURE_SWITCH = "fig7_parameters"


class _Switches(Strict):
    @model_serializer(mode="wrap")
    def _only_what_differs(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        default = type(self).model_fields
        return {
            name: value for name, value in handler(self).items() if value != default[name].default
        }


class Reading(_Switches):
    """One reading of the physics: an option for every switch that changes what a scene does."""

    effective_mass: EffectiveMass = "inertia_over_r_squared"
    bat_ball_restitution: BatBallRestitution = "as_printed"
    reduced_mass: ReducedMass = "bat_mass"
    inertia: Inertia = "solid_cylinder"
    lift_direction: LiftDirection = "fixed_spin_axis"
    ground_contact: GroundContact = "centre"
    slide_direction: SlideDirection = "initial"
    spin_parameter: SpinParameter = "transverse"
    drag_spin: DragSpin = "transverse"
    spin_decay: SpinDecay = "path"
    wind_acts_on: WindActsOn = "both"
    pressure: Pressure = "sea_level"
    fence_clearance: FenceClearance = "centre"
    distance_origin: DistanceOrigin = "plate"

    @model_validator(mode="after")
    def _no_contradiction(self) -> Self:
        if self.bat_ball_restitution == "plain" and self.reduced_mass == "effective_mass":
            raise ValueError(
                "bat_ball_restitution = plain takes the bat's whole mass, "
                "reduced_mass = effective_mass does not; the two together are what "
                "bat_ball_restitution = nathan says"
            )
        return self


class SamplingReading(_Switches):
    """One reading of how at-bats are drawn, and of which of them P(e) is a share."""

    speed_table: SpeedTable = "columns_swapped"
    speed_spread: SpeedSpread = "standard_deviation"
    offset_spread: float = Field(default=0.0366, gt=0.0, description="m")
    cell_width: float = Field(default=0.144, gt=0.0, description="m")
    sample_space: SampleSpace = "pitches"


def readings_of(switches: Mapping[str, object]) -> tuple[Reading, SamplingReading]:
    """Return the readings of scene and sampling that switches of the ledger make.

    Raises
    ------
    ValueError
        If a switch belongs to neither, or does not take its option, or contradicts another.
    """
    sampling = {name: x for name, x in switches.items() if name in SamplingReading.model_fields}
    physics = {name: x for name, x in switches.items() if name not in sampling}
    return Reading.model_validate(physics), SamplingReading.model_validate(sampling)


@dataclass(frozen=True)
class Entry:
    """A line of the ledger.

    Attributes
    ----------
    switch
        Its name.
    options
        What it can be set to; the default comes first.
    place
        Where in the paper the question arises.
    why
        One sentence on what is silent, ambiguous or wrong.
    """

    switch: str
    options: tuple[str, ...]
    place: str
    why: str

    @property
    def is_switch(self) -> bool:
        """Whether it is chosen by name; the masses are numbers of a scene."""
        return self.belongs != "scene" or self.switch in Reading.model_fields

    @property
    def belongs(self) -> Belongs:
        """What it changes."""
        if self.switch in SamplingReading.model_fields:
            return "sampling"
        if self.switch in SCHEME_OPTIONS:
            return "scheme"
        return "figure" if self.switch == FIGURE_SWITCH else "scene"


LEDGER: tuple[Entry, ...] = (
    Entry(
        "speed_table",
        ("columns_swapped", "as_printed"),
        "Table II",
        "The headings exchange mean and spread: 139.1 km/h is a mean speed, 4.58 km/h its spread.",
    ),
    Entry(
        "speed_spread",
        ("standard_deviation", "as_printed"),
        "Eq. 2",
        "The exponent lacks its 2: as printed the density integrates to 1/√2, and its σ is "
        "√2 times the standard deviation.",
    ),
    Entry(
        "effective_mass",
        ("inertia_over_r_squared", "as_printed"),
        "Sec. III.C",
        "M_eff = I/r̃ as printed has the unit kg m; a mass is I/r̃².",
    ),
    Entry(
        "bat_ball_restitution",
        ("as_printed", "nathan", "plain"),
        "Sec. III.C",
        "ẽ = e(1 + r) + r with r = m/M_eff inverts Nathan's e_A = (e - r)/(1 + r), so that e "
        "stands where e_A belongs and ẽ > 1 creates energy towards the barrel. "
        "nathan: ẽ = e with μ from M_eff. plain: ẽ = e with μ from M.",
    ),
    Entry(
        "reduced_mass",
        ("bat_mass", "effective_mass"),
        "Eq. for F̄, Sec. III.C",
        "μ is printed with the bat's mass M, while ẽ uses M_eff. "
        "Used with bat_ball_restitution = as_printed; the other two bring their own μ.",
    ),
    Entry(
        "inertia",
        ("solid_cylinder", "thin_rod", "about_centre"),
        "Sec. III.A, III.C",
        "A uniform cylinder about its end B has M(L²/3 + r_b²/4); a thin rod ML²/3; "
        "M(L²/12 + r_b²/4) about the centre is a slip that raises P(e) to the paper's height.",
    ),
    Entry(
        "offset_spread",
        ("0.0366", "0.0732"),
        "Sec. III.A",
        "0.0366 m is called the diameter of the ball; it is its radius. Any length in metres.",
    ),
    Entry(
        "cell_width",
        ("0.144",),
        "Sec. II, III",
        "The aim is drawn in cell indices and used in metres. A third of the plate's width "
        "(0.432 m), or any width in metres; P_y = (index - 3) width.",
    ),
    Entry(
        "lift_direction",
        ("fixed_spin_axis", "always_up"),
        "Sec. III.B",
        "The lift is only said to be perpendicular to the velocity. A backspin axis fixed at "
        "launch is continuous and lets steep pop-ups loop; the upward perpendicular flips at "
        "the vertical.",
    ),
    Entry(
        "ground_contact",
        ("centre", "surface"),
        "Sec. III.C",
        "Does the ball land when its centre or when its surface reaches the ground?",
    ),
    Entry(
        "spin_parameter",
        get_args(SpinParameter),
        "extended model",
        "S = Rω/U: only spin across the velocity makes lift, and laws C_L(S) were fitted to it. "
        "total: S of the whole spin, gyro spin included; the force is then k R (C_L/S) ω × u.",
    ),
    Entry(
        "drag_spin",
        get_args(DragSpin),
        "extended model",
        "Drag grows with spin, and the fits are to balls with little gyro spin: whether that adds "
        "to the drag is open. total: it does.",
    ),
    Entry(
        "spin_decay",
        get_args(SpinDecay),
        "extended model",
        "The torque of the air is proportional to ω U, so that spin decays with the path through "
        "the air. time: e^(-t/τ), with the τ that spin_decay_length takes at 100 mph (44.704 m/s). "
        "nathan: e^(-t U/L) with the present airspeed U, as in ports of Nathan's spreadsheet; no "
        "equation for ω has this solution, and the motion is solved with it as it stands.",
    ),
    Entry(
        "wind_acts_on",
        get_args(WindActsOn),
        "extended model",
        "All forces of the air depend on the velocity through the air. drag: the lift is taken at "
        "the velocity over the ground, as programs do that add wind to the drag alone.",
    ),
    Entry(
        "pressure",
        get_args(Pressure),
        "extended model",
        "A weather report reduces pressure to sea level, so the density falls with the elevation "
        "besides. station: the pressure is measured at the park, and the elevation does nothing.",
    ),
    Entry(
        "sample_space",
        ("pitches", "batted", "fair"),
        "Sec. IV",
        "Are misses and fouls among the 1,000 samples? "
        "fair: landed within 45° of the line from the plate to the pitcher.",
    ),
    Entry(
        "fig7_parameters",
        ("caption", "text"),
        "Fig. 7",
        "The caption says C₁ = 242 m, σ = 52.2 m; the text 271 m, 59.8 m. "
        "The text's own P(0.42) ≈ 0.17 agrees with the caption.",
    ),
    Entry(
        "verlet_forces",
        get_args(VerletForces),
        "Sec. III.B",
        "Velocity Verlet needs the force at the end of a step before the velocity there is known, "
        "and drag and lift depend on it. Taken at the old velocity (and carried into the next "
        "step, or computed anew there), at the half-step velocity, at one predicted by Euler "
        "(carried, or anew), or solved for.",
    ),
    Entry(
        "verlet_landing",
        ("interpolated", "first_below"),
        "Sec. III.C",
        "Where the ball lands between two steps is not stated: on the line between them, "
        "or at the first step that is not above the ground.",
    ),
    Entry(
        "appendix_b_root",
        ("first", "larger"),
        "Appendix B",
        "The positive root of the quadratic for Δt' is to be taken, but before the contact both "
        "are positive: the smaller is where the ball enters the bat, the larger where it would "
        "leave it.",
    ),
    Entry(
        "slide_direction",
        ("initial", "final"),
        "not in the paper",
        "Where friction cannot make the ball grip, it acts against the slip; but bat and ball "
        "yield more in one direction than in another, so that the slip turns during the impact. "
        "initial: against the slip as it begins. final: along the friction that would end it, so "
        "that a ball that all but grips leaves as one that grips.",
    ),
    Entry(
        "fence_clearance",
        ("centre", "surface"),
        "not in the paper",
        "Does a ball clear a fence when its centre or when its whole surface is above the top?",
    ),
    Entry(
        "distance_origin",
        ("plate", "launch"),
        "Sec. IV",
        "Distances are said to be from the plate, of which x = y = 0 is the tip; trackers and many "
        "simulators measure from where the ball is launched or hit. "
        "P(e) counts D >= 150 m from the plate.",
    ),
    Entry(
        "friction",
        ("bat.friction = none, tangential_restitution = 0.3, ball.inertia_factor = 0.4",),
        "not in the paper",
        "The paper's bat is frictionless. With friction, balls leave with up to 40 % more spin "
        "than rolling leaves them (arXiv:1610.03464), which bounds e_T by 0.4. Set in the "
        "scene's bat and ball blocks.",
    ),
    Entry(
        "masses",
        ("ball.mass = 0.145, bat.mass = 0.9",),
        "not printed",
        "Neither mass is given. NPB's rules allow balls of 141.7 to 148.8 g; 0.9 kg is a typical "
        "bat. Set in the scene's ball and bat blocks.",
    ),
)
