"""The result of a scene, one line of JSON.

The keys are fixed, because other implementations write them and the judge reads them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_serializer

from longball import __version__
from longball.model.block import Strict
from longball.model.jsonl import json_line

Outcome = Literal[
    "batted",
    "missed",
    "beyond_bat",
    "separating",
    "landed",
    "crossed",
    "struck",
    "grounded",
    "airborne",
    "home_run",
    "wall",
]


ErrorCode = Literal["invalid", "undecided", "too_long", "out_of_range", "unsupported"]


# Radii are decimal strings: a double could not hold one below 1e-308.
_RADIUS = r"^[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?$"


class Bounded(Strict):
    """A number as a decimal string, with the radius that an engine proves for it."""

    value: str = Field(
        pattern=r"^[+-]?[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?$",
        description="decimal string of N digits",
    )
    radius: str | None = Field(
        default=None,
        pattern=_RADIUS,
        description="proven bound on the error; null if none is proven",
    )

    def __float__(self) -> float:
        """Return the double nearest to the value."""
        return float(self.value)

    @model_serializer
    def _radius_stays_when_null(self) -> dict[str, str | None]:
        return {"value": self.value, "radius": self.radius}


# Two classes, because a `Certified` keeps the engine's own double.
class Certified(Strict):
    """A double, with the radius that the enclosure engine proves for it."""

    value: float = Field(description="the engine's double")
    radius: str = Field(pattern=_RADIUS, description="proven bound on its error, rounded up")

    def __float__(self) -> float:
        """Return the double."""
        return self.value


if TYPE_CHECKING:
    # A float; a Bounded from engines with digits; a Certified with a certificate. Options decide,
    # which a type checker cannot follow.
    Number = Any
else:
    Number = Annotated[float, Field(description="a double")] | Bounded | Certified
Triple = tuple[Number, Number, Number]


class Approach(Strict):
    """The direction in which a pitch crosses the plate."""

    vertical: Number = Field(
        description="rad, of the velocity above the horizontal, negative for a pitch that falls: "
        "the vertical approach angle, VAA"
    )
    horizontal: Number = Field(
        description="rad, of its horizontal part from straight ahead to the catcher's left: the "
        "horizontal approach angle, HAA, with the sign of y"
    )


class Plate(Strict):
    """The pitch at x = 0 as if there were no bat."""

    time: Number = Field(description="s, since release")
    position: Triple = Field(description="m; its z is the height z'_b")
    velocity: Triple = Field(description="m/s")
    approach: Approach | None = None


class Contact(Strict):
    """First touching of ball and bat, or how close the pitch came."""

    time: Number | None = Field(default=None, description="s, since release")
    position: Triple | None = Field(default=None, description="m, ball's centre at touching")
    normal: Triple | None = Field(default=None, description="unit vector from the axis to the ball")
    bat_velocity: Triple | None = Field(default=None, description="m/s, of the bat at the contact")
    normal_speed: Number | None = Field(
        default=None, description="m/s, velocity of the ball relative to the bat along the normal"
    )
    margin: Number | None = Field(
        default=None,
        description="m, R + r_b minus the closest distance of the undisturbed pitch from its "
        "release until it has passed the bat; negative for a miss",
    )


class Impact(Strict):
    """The impulse and what it does."""

    restitution: Number = Field(description="ẽ, between ball and bat")
    impulse: Number = Field(description="N s, the normal part")
    velocity: Triple = Field(description="m/s, of the ball, after")
    energy_change: Number = Field(
        description="J, of ball and bat together; positive: the collision creates energy"
    )
    spin: Triple | None = Field(default=None, description="rad/s, of the ball, after")
    mode: Literal["grip", "slide", "frictionless"] | None = Field(
        default=None, description="motion of the ball on the bat; absent without friction and spin"
    )
    friction_margin: Number | None = Field(
        default=None,
        description="(μ_f P_n - |P_t|)/(μ_f |P_n|) of the gripping impulse; negative if the ball "
        "slides",
    )
    recontact: Literal["certain", "possible"] | None = Field(
        default=None,
        description="certain: the ball leaves the contact more slowly along the normal than the "
        "bat came, so that a bat that continues its swing would strike it again (not modelled); "
        "possible: the two speeds agree to a millionth; absent: no second contact",
    )


class Apex(Strict):
    """The highest point of a batted ball; absent if it rises to its end."""

    time: Number = Field(description="s, since the start of the scene")
    position: Triple = Field(description="m")


class Landing(Strict):
    """Where the ball comes down."""

    time: Number = Field(description="s, since the start of the scene")
    hang_time: Number = Field(description="s, since contact or launch")
    position: Triple = Field(description="m")
    velocity: Triple = Field(description="m/s")
    distance: Number = Field(description="m, horizontal, from the plate")
    angle: Number | None = Field(
        default=None, description="rad, of the velocity below the horizontal"
    )
    spin: Triple | None = Field(default=None, description="rad/s, if the scene has a spin")
    path: Number | None = Field(
        default=None, description="m, through the air since contact or launch, if spin decays"
    )
    fair: bool | None = Field(
        default=None,
        description="true if |y| <= x where the ball leaves the field or lands; only with a fence",
    )


class Fence(Strict):
    """Where the ball first leaves the field over the fence, or meets it."""

    time: Number = Field(description="s, since the start of the scene")
    position: Triple = Field(description="m")
    velocity: Triple = Field(description="m/s")
    clearance: Number = Field(description="m, height above the top; a wall if not positive")
    segment: int = Field(description="number of the chord between two vertices, the first being 0")
    margin: Number | None = Field(
        default=None, description="m, along the chord to the next vertex; none on a circle"
    )


def signed(engine: str) -> str:
    """Return the description of an engine with longball's version."""
    return f"longball {__version__} {engine}"


class Result(Strict):
    """The result of a scene."""

    id: str | None = Field(description="the scene's id; null if its line had none")
    outcome: Outcome | None = Field(default=None, description="absent if there is an error")
    plate: Plate | None = None
    contact: Contact | None = None
    impact: Impact | None = None
    apex: Apex | None = None
    fence: Fence | None = None
    landing: Landing | None = None
    path: tuple[Annotated[tuple[Number, ...], Field(min_length=4, max_length=7)], ...] | None = (
        Field(
            default=None,
            description="[t, x, y, z, vx, vy, vz] at times from the start of the scene to its end, "
            "s, m and m/s, if requested; velocities may be omitted",
        )
    )
    engine: str | None = Field(default=None, description="engine and version of the result")
    error: str | None = Field(default=None, description="the fault, its location, and a remedy")
    code: ErrorCode | None = Field(
        default=None,
        description="kind of error. invalid: the scene is invalid, or contradicts itself; "
        "undecided: the errors of the numbers do not settle the outcome; more digits may help; "
        "too_long: the flight takes too many steps; a lower time_limit may help; "
        "out_of_range: numbers or forces exceed the range or resolution of the engine; "
        "unsupported: the model or the engine has no answer to such a scene",
    )

    certificate: str | None = Field(
        default=None,
        description="with --certify: reason why the numbers are not proven; absent if they are",
    )

    def data(self) -> dict[str, Any]:
        """Return the result as plain data, without absent quantities."""
        # `id` is the only key that may be null.
        return {"id": self.id} | self.model_dump(exclude_none=True)

    def line(self) -> str:
        """Return the result as one line of JSON, without absent quantities."""
        return json_line(self.data())
