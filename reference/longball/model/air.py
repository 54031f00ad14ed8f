"""Air: coefficients of drag and lift with their laws, weather, wind.

A law of a coefficient is one class: its keys with their limits, and its formula. The formula takes
any object with the same keys. In the law of motion (`longball.model.law`) the keys are nodes of a
trace, and keys in which C is linear have the factor ``k = ρ A / (2 m)``. Sources of the laws and
their constants: paper, Sec. III.B; A. M. Nathan, Am. J. Phys. 76 (2008) 119, and "Analysis of
baseball trajectories" (2016).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import BaseModel, Discriminator, Field, Tag, field_validator, model_validator

from longball.model import trace
from longball.model.block import SMALLEST, Block, NotNegative, Point, Positive, Quantity, refuse
from longball.model.numbers import Vector
from longball.model.trace import ZERO

# --- coefficients ---------------------------------------------------------------------------------


class Flow(NamedTuple):
    """Motion of a ball through the air: the arguments of the coefficients.

    ω is the spin at launch, ω_T its component across the velocity u through the air, and ``U =
    |u|``. The spin parameter ``S = R ω_T/U`` is that of the decayed spin. It is a fraction, so that
    nothing is divided by the speed of a ball at rest.

    Attributes
    ----------
    velocity
        u, m/s.
    speed
        U, m/s.
    across
        ``ω × u``, m/s².
    drag_spin
        ``ω_T U`` of the decayed spin, m/s², by the reading `drag_spin`.
    spin
        ω_T, rad/s; this and the following fields are by the reading `spin_parameter`.
    top, bottom
        ``ω_T/U = top/bottom``.
    lever
        R times the remaining fraction of the spin, m: ``S = lever top/bottom``.
    """

    velocity: Vector
    speed: Any
    across: Vector
    drag_spin: Any
    spin: Any
    top: Any
    bottom: Any
    lever: Any

    @property
    def per_spin(self) -> Any:
        """``U/ω_T``, m; 0 without a spin across the velocity, when there is no lift."""
        # ZERO marks a value that is 0 in every state, such as the spin of a ball that has none.
        return ZERO if self.top is ZERO else self.bottom / self.top


class Coefficient(Block):
    """The law of a coefficient.

    A law of drag has the method `drag`, which returns ``C_D U``; a law of lift has `lift`, which
    returns ``C_L U/ω_T = R C_L/S``. Both are finite if U or ω_T is 0.
    """

    # Keys in which C is not linear; they do not get the factor k.
    nonlinear: ClassVar[tuple[str, ...]] = ()


class ConstantDrag(Coefficient):
    """C_D, the same at all speeds."""

    law: Literal["constant"]
    value: NotNegative

    def drag(self, flow: Flow) -> Any:
        """Return ``C_D U``."""
        return self.value * flow.speed


class SpinDrag(Coefficient):
    """``C_D = c_0 + c_1 ω_T`` (Nathan 2016)."""

    law: Literal["spin"]
    constant: NotNegative = Field(default=0.3008, description="c_0")
    per_spin: NotNegative = Field(default=2.788e-4, description="s per radian, c_1")

    def drag(self, flow: Flow) -> Any:
        """Return ``C_D U``."""
        return self.constant * flow.speed + self.per_spin * flow.drag_spin


class CrisisDrag(Coefficient):
    """``C_D = a + (b - a)/(1 + e^((U - U_c)/δ)) + c_1 ω_T``: a drag crisis."""

    law: Literal["crisis"]
    high_speed: NotNegative = Field(default=0.33, description="a, well above the speed U_c")
    low_speed: NotNegative = Field(default=0.5, description="b, well below it")
    speed: NotNegative = Field(default=31.4, description="m/s, U_c")
    width: Positive = Field(default=3.0, description="m/s, δ")
    per_spin: NotNegative = Field(default=0.0, description="s per radian, c_1")

    nonlinear: ClassVar[tuple[str, ...]] = ("speed", "width")

    def drag(self, flow: Flow) -> Any:
        """Return ``C_D U``."""
        steepness = trace.exp((flow.speed - self.speed) / self.width)
        # U times the weight of the value at low speed: 1 far below U_c, 0 far above.
        slow = flow.speed / (1.0 + steepness)
        return (
            self.high_speed * flow.speed
            + (self.low_speed - self.high_speed) * slow
            + self.per_spin * flow.drag_spin
        )


class ConstantLift(Coefficient):
    """C_L, the same at all speeds and spins."""

    law: Literal["constant"]
    value: Quantity

    def lift(self, flow: Flow) -> Any:
        """Return ``R C_L/S``."""
        return self.value * flow.per_spin


class RationalLift(Coefficient):
    """``C_L = c_2 S / (c_0 + c_1 S)`` (Nathan 2016)."""

    law: Literal["rational"]
    numerator: Quantity = Field(default=1.12, description="c_2")
    constant: NotNegative = Field(default=0.583, description="c_0")
    slope: NotNegative = Field(default=2.333, description="c_1")

    nonlinear: ClassVar[tuple[str, ...]] = ("constant", "slope")

    @model_validator(mode="after")
    def _has_a_denominator(self) -> Self:
        # The denominator c_0 + c_1 S would be 0 at every spin.
        if self.constant == self.slope == 0.0:
            refuse("constant and slope cannot both be 0: C_L = numerator S / (constant + slope S)")
        return self

    def lift(self, flow: Flow) -> Any:
        """Return ``R C_L/S``."""
        # With S = lever top/bottom, R/S times c_2 S/(c_0 + c_1 S) is c_2 lever bottom/(c_0 bottom +
        # c_1 lever top). This form does not divide by S, which is 0 without a spin.
        denominator = self.constant * flow.bottom + self.slope * (flow.lever * flow.top)
        return self.numerator * (flow.lever * (flow.bottom / denominator))


class LinearLift(Coefficient):
    """``C_L = a S``."""

    law: Literal["linear"]
    slope: Quantity = Field(default=1.0, description="a")

    def lift(self, flow: Flow) -> Any:
        """Return ``R C_L/S``."""
        return self.slope * flow.lever


# --- coefficients by straight lines ---------------------------------------------------------------


class BySpeed:
    """A line of a table: ``C = at_0 + slope U``."""

    passes = "the airspeed"

    at_0: Any
    slope: Any

    def drag(self, flow: Flow) -> Any:
        """Return ``C_D U``."""
        return self.at_0 * flow.speed + self.slope * (flow.speed * flow.speed)

    def lift(self, flow: Flow) -> Any:
        """Return ``R C_L/S``."""
        return (self.at_0 + self.slope * flow.speed) * flow.per_spin

    @staticmethod
    def passed(flow: Flow) -> tuple[Any, Any]:
        """Return U², as numerator and denominator."""
        # Nodes are compared as squares, which need no square root.
        return flow.speed * flow.speed, 1.0


class BySpin:
    """A line of a table: ``C = at_0 + slope S``."""

    passes = "the spin parameter"

    at_0: Any
    slope: Any

    def drag(self, flow: Flow) -> Any:
        """Return ``C_D U``."""
        # S U = R ω_T of the decayed spin.
        return self.at_0 * flow.speed + self.slope * (flow.lever * flow.spin)

    def lift(self, flow: Flow) -> Any:
        """Return ``R C_L/S``."""
        return self.at_0 * flow.per_spin + self.slope * flow.lever

    @staticmethod
    def passed(flow: Flow) -> tuple[Any, Any]:
        """Return S², as numerator and denominator."""
        return flow.lever * flow.lever * (flow.top * flow.top), flow.bottom * flow.bottom


# The nodes between which a coefficient is linear, and the lines, one more than nodes: each is given
# by its value at 0 and its slope.
Lines = tuple[tuple[Any, ...], tuple[tuple[Any, Any], ...]]


# Coefficients, densities and winds have several forms. The tag of a form, in <>, is not a key, and
# is left out of messages.


class BilinearLift(Block):
    """``C_L = 1.5 S`` below ``S = 0.1``, ``0.09 + 0.6 S`` above (Sawicki et al. 2003)."""

    law: Literal["bilinear"]

    of: ClassVar[str] = "spin_parameter"

    def lines(self, exact: Any) -> Lines:
        """Return the two lines of Am. J. Phys. 71 (2003) 1152."""
        # They meet at S = 0.1, where both are 0.15.
        return (exact(0.1),), ((exact(0.0), exact(1.5)), (exact(0.09), exact(0.6)))


class Table(Block):
    """A coefficient that is linear between nodes and constant outside."""

    law: Literal["table"]
    of: Literal["speed", "mach", "spin_parameter"] = Field(
        description="argument: the airspeed, m/s; the Mach number; S = R ω_T / U"
    )
    at: tuple[NotNegative, ...] = Field(min_length=2, max_length=100, description="the nodes")
    values: tuple[Quantity, ...] = Field(description="of the coefficient, at the nodes")

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        if len(self.values) != len(self.at):
            refuse(f"at has {len(self.at)} nodes and values has {len(self.values)} numbers")
        for i, (x, y) in enumerate(pairwise(self.at)):
            if not x < y:
                refuse(f"at must increase, but at[{i + 1}] = {y} follows {x}")
        return self

    def lines(self, exact: Any) -> Lines:
        """Return the lines between the nodes, and those outside."""
        at, values = [*map(exact, self.at)], [*map(exact, self.values)]
        nothing = exact(0.0)
        # The coefficient is constant below the first node, and above the last one.
        lines = [(values[0], nothing)]
        for (x, y), (right, above) in pairwise(zip(at, values, strict=True)):
            slope = (above - y) / (right - x)
            # The value of the line through (x, y), extended to 0.
            lines.append((y - slope * x, slope))
        lines.append((values[-1], nothing))
        # Arguments are not negative, so a node at 0 has no line below it.
        first = 1 if self.at[0] == 0.0 else 0
        return tuple(at[first:]), tuple(lines[first:])


def law_name(coefficient: Any) -> str:
    """Return the name of a coefficient's law; a number is a constant."""
    name: str = getattr(coefficient, "law", "constant")
    return name


def _law(value: Any) -> str:
    """Return the name of a law's form, or of a number's."""
    if isinstance(value, BaseModel):
        return f"<{getattr(value, 'law', '')}>"
    return f"<{value.get('law', '')}>" if isinstance(value, dict) else "<number>"


DragCoefficient = Annotated[
    Annotated[NotNegative, Tag("<number>")]
    | Annotated[ConstantDrag, Tag("<constant>")]
    | Annotated[SpinDrag, Tag("<spin>")]
    | Annotated[CrisisDrag, Tag("<crisis>")]
    | Annotated[Table, Tag("<table>")],
    Discriminator(_law),
]
LiftCoefficient = Annotated[
    Annotated[Quantity, Tag("<number>")]
    | Annotated[ConstantLift, Tag("<constant>")]
    | Annotated[RationalLift, Tag("<rational>")]
    | Annotated[LinearLift, Tag("<linear>")]
    | Annotated[BilinearLift, Tag("<bilinear>")]
    | Annotated[Table, Tag("<table>")],
    Discriminator(_law),
]


# --- weather and wind -----------------------------------------------------------------------------


class Weather(Block):
    """Weather, which sets the density of the air; see `longball.model.atmosphere.density`."""

    temperature: float = Field(default=288.15, ge=150.0, le=350.0, description="K")
    # The lowest sea-level pressure ever measured is 870 hPa. The limit of 10 kPa catches hPa and
    # inHg.
    pressure: float = Field(
        default=101325.0, ge=1e4, le=1e30, description="Pa, reduced to sea level"
    )
    humidity: NotNegative = Field(default=0.0, description="relative, from 0 to 1")
    elevation: Quantity = Field(default=0.0, description="m, above sea level")

    @field_validator("humidity")
    @classmethod
    def _fraction(cls, value: float) -> float:
        # A percentage is the usual mistake, so the message shows the fraction.
        if value > 1.0:
            refuse(f"{value} is not a fraction from 0 to 1; 50 % is written 0.5")
        return value


class WindAbove(Block):
    """A wind that blows above a height alone."""

    velocity: Point = Field(description="m/s, where it blows to")
    above: NotNegative = Field(description="m, the height above which it blows")


class WindProfile(Block):
    """A wind that grows with the logarithm of the height."""

    velocity: Point = Field(description="m/s, where it blows to at the height; level")
    height: Positive = Field(description="m, at which it has this velocity")
    roughness: Positive = Field(default=0.03, description="m, z_0 of the ground; default: grass")

    @model_validator(mode="after")
    def _is_level(self) -> Self:
        # A vertical part that grows with the height would carry air out of the ground.
        if self.velocity[2] != 0.0:
            refuse("velocity[2] must be 0: a wind with a height and a roughness is level")
        return self


def _wind_form(value: Any) -> str | None:
    if not isinstance(value, dict | Block):
        return "<vector>"
    # The keys decide the form, so that an unknown key is named within the form that is meant.
    keys = value.keys() if isinstance(value, dict) else value.model_fields_set
    if keys & {"height", "roughness"}:
        return "<profile>"
    return "<above>" if "above" in keys else None


Wind = Annotated[
    Annotated[Point, Tag("<vector>")]
    | Annotated[WindAbove, Tag("<above>")]
    | Annotated[WindProfile, Tag("<profile>")],
    Discriminator(
        _wind_form,
        custom_error_type="wind_form",
        custom_error_message="must be [x, y, z] in m/s; or have velocity and above; or velocity, "
        "height and roughness",
    ),
]
Density = Annotated[
    Annotated[NotNegative, Tag("<number>")] | Annotated[Weather, Tag("<weather>")],
    Discriminator(lambda value: "<weather>" if isinstance(value, dict | Weather) else "<number>"),
]


class Side(Block):
    """A side force ``k C_S U² ê``: what a seam-shifted wake is measured as."""

    value: Quantity = Field(description="C_S")
    direction: Point = Field(
        description="fixed in space, of any length; ê is along the part of it across the airspeed"
    )

    @field_validator("direction")
    @classmethod
    def _points_somewhere(cls, direction: Point) -> Point:
        # Only the direction counts, and the length of a tiny vector may underflow to 0.
        if max(map(abs, direction)) < SMALLEST:
            refuse(
                f"{list(direction)} has no direction; give a vector [x, y, z] with a component of "
                f"at least {SMALLEST}"
            )
        return direction


class Air(Block):
    """Air: density, coefficients (paper, Sec. III.B), and wind."""

    density: Density = Field(default=1.29, description="kg/m³ at height 0, or the weather")
    drag_coefficient: DragCoefficient = Field(default=0.4, description="C_D, or its law")
    lift_coefficient: LiftCoefficient = Field(
        default=0.2, description="C_L, negative for topspin; or its law"
    )
    side_coefficient: Side | None = Field(
        default=None, description="C_S and the direction of a side force; by default none"
    )
    wind: Wind | None = Field(
        default=None, description="m/s, where it blows to; or with a height, or a profile"
    )
    spin_decay_length: Positive | None = Field(
        default=None, description="m of path through the air in which spin falls by e"
    )
    density_scale_height: Positive | None = Field(
        default=None, description="m in which the density falls by e, from height 0 up"
    )

    @model_validator(mode="after")
    def _table_has_what_it_needs(self) -> Self:
        drag = self.drag_coefficient
        # A negative drag would feed energy to the ball. `Table` serves lifts, too, which may be
        # negative, so that its own fields cannot forbid it.
        if isinstance(drag, Table) and min(drag.values) < 0.0:
            refuse(f"drag_coefficient.values: {min(drag.values)} is negative")
        for key in ("drag_coefficient", "lift_coefficient"):
            of = getattr(getattr(self, key), "of", "")
            # The speed of sound is that of the weather, 331.3 √(T/273.15) m/s.
            if of == "mach" and not isinstance(self.density, Weather):
                refuse(
                    f"{key}: a table of the Mach number needs the temperature; give the density "
                    "as a weather"
                )
        return self

    def wind_at(self, height: float, climb: float) -> Point:
        """Return the wind, m/s, on a ball at a height, m, that climbs so fast, in any unit."""
        wind = self.wind
        if isinstance(wind, WindAbove):
            # At the height itself the ball feels the air that it flies into (model.md, Wind).
            aloft = height > wind.above or (height == wind.above and climb > 0.0)
            return wind.velocity if aloft else (0.0, 0.0, 0.0)
        if isinstance(wind, WindProfile):
            # ln((z + z_0)/z_0), which keeps its digits near the ground where z is small.
            rise, whole = (math.log1p(z / wind.roughness) for z in (height, wind.height))
            x, y, z = wind.velocity
            return x * (rise / whole), y * (rise / whole), z
        return wind or (0.0, 0.0, 0.0)

    @property
    def lift_is_constant(self) -> bool:
        """True if C_L does not fall with the spin parameter, to zero."""
        law = self.lift_coefficient
        if isinstance(law, Table):
            return law.of != "spin_parameter" or law.at[0] > 0.0 or law.values[0] != 0.0
        # Laws other than `constant` fall to zero with S, and have no value.
        value = getattr(law, "value", 0.0) if isinstance(law, Block) else law
        return value != 0.0

    @property
    def needs_spin(self) -> str:
        """The first key that means nothing without a spin; empty if there is none."""
        if self.spin_decay_length is not None:
            return "air.spin_decay_length"
        if by_spin(self.drag_coefficient):
            return "air.drag_coefficient"
        return "air.lift_coefficient" if by_spin(self.lift_coefficient) else ""


def by_spin(law: Any) -> bool:
    """True if a coefficient, or its law, depends on the spin."""
    name, of = law_name(law), getattr(law, "of", "")
    named = name in ("spin", "rational", "linear", "bilinear") or of == "spin_parameter"
    return named or getattr(law, "per_spin", 0.0) != 0.0
