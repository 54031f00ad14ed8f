"""Scenes: everything that a result depends on.

A scene is one JSON object in SI units and radians. Each kind of scene takes only the blocks it
needs; an unknown key is an error that names it; omitted values default to the paper's. Numbers are
read as the nearest double.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from numbers import Integral
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    WithJsonSchema,
    model_validator,
)

from longball.model.air import Air as Air
from longball.model.air import WindProfile
from longball.model.annotations import within
from longball.model.block import SMALLEST, NotNegative, Point, Positive, Quantity
from longball.model.block import Block as _Block
from longball.model.block import refuse as _refuse
from longball.model.csv_files import not_utf8
from longball.model.explain import explain, is_vector, parts_of, short
from longball.model.jsonl import LONGEST_LINE, json_line
from longball.model.names import did_you_mean, one_of
from longball.model.numbers import cross, plus, scaled
from longball.model.plain import json_text, plain
from longball.model.readings import Reading
from longball.model.result import ErrorCode, Result


class InvalidScene(ValueError):
    """Raised for an invalid scene; the message names the key and the fault."""

    code: ErrorCode = "invalid"

    def __init__(self, message: str, scene_id: str | None = None) -> None:
        super().__init__(message)
        self.scene_id = scene_id


def refused(error: InvalidScene) -> Result:
    """Return the result for an invalid scene."""
    return Result(id=error.scene_id, error=str(error), code=error.code)


class Ball(_Block):
    """The baseball."""

    # The rules of NPB allow 141.7 to 148.8 g, and a circumference of 22.9 to 23.5 cm. The default
    # mass is the middle of that range.

    mass: Positive = Field(default=0.145, description="kg; not printed in the paper")
    radius: Positive = Field(default=0.0366, description="m; paper, Sec. III.A")
    restitution: float = Field(
        default=0.42, ge=0.0, le=1.0, description="e; the paper's runs from 0.41 to 0.45"
    )
    inertia_factor: float | None = Field(
        default=None,
        ge=SMALLEST,
        le=1.0,
        description="I/(m R²), needed by friction; by default 0.4, that of a solid sphere",
    )


def _gives(key: str, form: str) -> dict[str, Any]:
    """Return the JSON Schema of a block that has a key in a form; null does not count."""
    return {"required": [key], "properties": {key: {"type": form}}}


Spin = Annotated[Point | None, Field(description="rad/s, ω; by default no spin")]


class Launch(_Block):
    """A ball that is already in the air."""

    position: Point = Field(description="m, of the ball's centre")
    velocity: Point = Field(description="m/s")
    spin: Spin = None


class Pitch(_Block):
    """A throw towards a point of the plane x = 0 (paper, Sec. III), or with a velocity."""

    model_config = ConfigDict(
        json_schema_extra={
            "not": _gives("velocity", "array")
            | {"anyOf": [_gives("speed", "number"), _gives("aim", "array")]}
        }
    )
    speed: Positive = Field(
        default=36.9125,
        description="m/s; default: the mean of Eq. 3, 0.45 · 139.1 + 0.55 · 127.8 = 132.885 km/h",
    )
    release: Point = Field(default=(18.44, 0.0, 1.8), description="m; x > 0")
    aim: tuple[Quantity, Quantity] = Field(
        default=(0.0, 1.8), description="m, [y, z] of the point aimed at; default: the middle cell"
    )
    velocity: Point | None = Field(default=None, description="m/s, instead of speed and aim")
    spin: Spin = None

    def named(self) -> Iterator[str]:
        """Yield the keys of the written block: speed and aim, or the velocity."""
        instead = () if self.velocity is None else ("speed", "aim")
        yield from (key for key in super().named() if key not in instead)

    @property
    def along(self) -> Point:
        """A vector along the velocity."""
        x, y, z = self.release
        return self.velocity or (-x, self.aim[0] - y, self.aim[1] - z)

    @property
    def pace(self) -> float:
        """Velocity as a multiple of `along`, in double precision."""
        return self.speed / math.hypot(*self.along) if self.velocity is None else 1.0

    @property
    def thrown(self) -> Point:
        """Velocity at the release, m/s, in double precision."""
        x, y, z = self.along
        return x * self.pace, y * self.pace, z * self.pace

    @model_validator(mode="after")
    def _thrown_one_way_in_front_of_the_plate(self) -> Self:
        # Even if speed and aim are written with their defaults: the scene would be ambiguous.
        both = sorted(self.model_fields_set & {"speed", "aim"})
        if self.velocity is not None and both:
            _refuse(f"velocity replaces speed and aim; remove {' and '.join(both)}")
        if self.release[0] <= 0.0:
            _refuse(f"release[0] = {self.release[0]} must be positive: in front of the plate")
        return self


class Bat(_Block):
    """A uniform solid cylinder along y (paper, Sec. III.A)."""

    mass: Positive = Field(default=0.9, description="kg; not printed in the paper")
    length: Positive = Field(default=1.0, description="m")
    radius: Positive = Field(default=0.033, description="m")
    support: Literal["pivot", "free"] | None = Field(
        default=None,
        description="support of the bat in the impact: it turns about its end B (pivot, the "
        "default), or moves freely (free)",
    )
    friction: Positive | None = Field(
        default=None, description="μ_f, between ball and bat; by default no friction"
    )
    tangential_restitution: float | None = Field(
        default=None,
        ge=-1.0,
        le=1.0,
        description="e_T of a ball that grips the bat; needs friction; by default 0.3",
    )

    @model_validator(mode="after")
    def _with_friction(self) -> Self:
        if self.tangential_restitution is not None and self.friction is None:
            _refuse("tangential_restitution needs friction: give the bat a friction, such as 0.5")
        return self


class Rotation(_Block):
    """The swing of an impact: a rotation about the bat's end B."""

    angular_speed: Quantity = Field(default=34.0, description="rad/s, about an axis through B")
    tilt: Quantity = Field(
        default=math.radians(5.0),
        description="rad, of that axis from the vertical; default: the mean of 0° to 10°",
    )


class Swing(Rotation):
    """The swing of an at-bat: a rotation, at a height relative to the pitch at the plate."""

    height_offset: Quantity = Field(
        default=0.0, description="m, σ_b: height of the bat's axis above the pitch at x = 0"
    )


# Tolerance of the distance from the bat's axis, m. Positions at the height of a bat, written with
# ten digits, have smaller errors.
TOUCHING = 1e-9


class Incoming(_Block):
    """The ball at the moment it touches the bat."""

    position: Point = Field(description="m, of the ball's centre, R + r_b from the bat's axis")
    velocity: Point = Field(description="m/s")
    bat_height: Quantity = Field(description="m, z_b of the bat's axis")
    spin: Point | None = Field(default=None, description="rad/s, of the ball")


class Ground(_Block):
    """The surface that the ball lands on."""

    height: Quantity = Field(default=0.0, description="m")


class Earth(_Block):
    """Position of the park on the rotating Earth."""

    latitude: float = Field(
        ge=-math.pi / 2, le=math.pi / 2, description="rad, positive in the north"
    )
    azimuth: Quantity = Field(
        default=0.0, description="rad, of +x (from the plate to the pitcher), from north to east"
    )


class Fence(_Block):
    """Fence that a batted ball clears or hits: a circle on the ground, or a line of chords.

    A chord's left side, seen from its first vertex, is outside; where the height steps, a vertex is
    given twice.
    """

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [_gives("radius", "number"), _gives("polyline", "array")]}
    )
    radius: Positive | None = Field(
        default=None, description="m, of a fence of height 0 all around the plate"
    )
    polyline: tuple[tuple[Quantity, Quantity, Quantity], ...] | None = Field(
        default=None,
        description="m, [x, y, height of the top] from the left pole (y > 0) to the right one",
    )

    @model_validator(mode="after")
    def _is_a_fence(self) -> Self:
        if (self.radius is None) == (self.polyline is None):
            _refuse("a fence needs either a radius or a polyline")
        if self.polyline is None:
            return self

        # A polyline runs from left to right and does not cross itself. A step in height is a
        # repeated vertex.
        vertices = [(x, y) for x, y, _ in self.polyline]
        corners = [v for i, v in enumerate(vertices) if i == 0 or v != vertices[i - 1]]
        if len(corners) < 2:
            _refuse("polyline needs at least two vertices [x, y, height] at different places")
        chords = list(pairwise(corners))
        for i, (a, b) in enumerate(chords):
            # Neighbours share a vertex; they overlap only if the second folds back on the first.
            for j, (c, d) in enumerate(chords[i + 1 :], i + 1):
                back = (a[0] - b[0]) * (d[0] - b[0]) + (a[1] - b[1]) * (d[1] - b[1])
                folds = _turn(a, b, d) == 0 and back > 0
                if folds if j == i + 1 else _meet(a, b, c, d):
                    _refuse(f"polyline crosses itself: between {a}, {b} and between {c}, {d}")
        # Sum of the angles of the chords as seen from the plate: negative from left to right.
        plate = (0.0, 0.0)
        if sum(math.atan2(_turn(plate, a, b), a[0] * b[0] + a[1] * b[1]) for a, b in chords) > 0:
            _refuse(
                "polyline runs the wrong way round the plate: it must go from the left pole "
                "(y > 0) to the right pole; reverse the order of its vertices"
            )
        return self


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Return (b - a) × (c - a): positive if c is to the left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _meet(
    a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], d: tuple[float, float]
) -> bool:
    """True if two chords have a point in common."""
    # Disjoint bounding boxes. This also decides for chords on one line, whose cross products are
    # all 0.
    if max(min(a[0], b[0]), min(c[0], d[0])) > min(max(a[0], b[0]), max(c[0], d[0])):
        return False
    if max(min(a[1], b[1]), min(c[1], d[1])) > min(max(a[1], b[1]), max(c[1], d[1])):
        return False
    # Otherwise each chord must have its ends on different sides of the other, or on it.
    return _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0


_MOST_DIGITS = 40  # of an id that is a number: a hash of 128 bits has 39


def _text_of_whole(value: Any) -> Any:
    """Return a whole number as its text: ids in data frames are numbers."""
    # A column of ids with a gap is a column of floats in pandas.
    if isinstance(value, float) and value.is_integer() and abs(value) <= 2**53:
        value = int(value)
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    return str(value) if is_whole and abs(value) < 10**_MOST_DIGITS else value


Id = Annotated[
    str,
    Field(min_length=1),
    BeforeValidator(_text_of_whole),
    WithJsonSchema({"anyOf": [{"type": "string", "minLength": 1}, {"type": "integer"}]}),
]


class _Scene(_Block):
    id: Id | None = Field(
        default=None,
        description="returned with the result, a whole number as its text; if left out, that "
        "bears the number of the line",
    )
    ball: Ball = Ball()
    reading: Reading = Reading()

    shown = ("line", "replace")

    def replace(self, **values: object) -> Self:
        """Return the scene with other values, under the names of keys or of components of vectors.

        >>> AtBatScene().replace(**{"swing.tilt": 0.2, "pitch.aim[1]": 1.7}).pitch.aim
        (0.0, 1.7)
        """
        from longball.model.changes import Changes  # which knows scenes

        # Without the defaults, a change can use a block's other form, such as velocity in place of
        # speed and aim.
        written = self.model_dump(mode="json", exclude_defaults=True)
        written["kind"] = type(self).model_fields["kind"].default
        changed = Changes(tuple((name, plain(value, name)) for name, value in values.items()))
        return type(self)(**changed(written))

    def line(self) -> str:
        """Return the scene as one line of JSON, with all defaults except those of readings."""
        return _line_of(self.model_dump(mode="json"))

    def as_written(self) -> str:
        """Return the scene as one line of JSON, with the keys that were given."""
        kind = {"kind": type(self).model_fields["kind"].default}
        return _line_of(kind | self.model_dump(mode="json", exclude_unset=True))


def _line_of(blocks: dict[str, Any]) -> str:
    # A reader looks for id and kind first.
    head = {key: value for key in ("id", "kind") if (value := blocks.pop(key, None))}
    return json_line(head | blocks)


class _FlyingScene(_Scene):
    air: Air | None = Field(default=Air(), description="null: no air at all")
    gravity: NotNegative = Field(default=9.8, description="m/s², downwards; paper, Sec. III.B")
    time_limit: Positive = Field(
        default=60.0, description="s, longest flight; the outcome is then airborne"
    )
    earth: Earth | None = Field(default=None, description="by default it does not rotate")

    @property
    def _start(self) -> tuple[str, Point | None, Point, Point, float]:
        """The name of the block with the initial state of the ball; its spin and position.

        And its velocity, as a vector along it and a factor.
        """
        if isinstance(self, FlightScene):
            ball = self.launch
            return "launch", ball.spin, ball.position, ball.velocity, 1.0
        pitch: Pitch = self.pitch  # type: ignore[attr-defined]
        return "pitch", pitch.spin, pitch.release, pitch.along, pitch.pace

    @model_validator(mode="after")
    def _flies(self) -> Self:
        block, spin, (_, _, z), *_ = self._start
        air, reading, floor = self.air, self.reading, landing_height(self)

        # air and spin agree
        if air is not None:
            if spin is None and (key := air.needs_spin):
                _refuse(f"{key} needs a spin; give {block}.spin, in rad/s")
            table = getattr(air.lift_coefficient, "of", None)
            # This reading changes the direction of the paper's lift, which has no spin axis.
            beyond = (spin, air.wind, table, air.side_coefficient)
            if reading.lift_direction == "always_up" and any(x is not None for x in beyond):
                _refuse(
                    "reading.lift_direction = always_up cannot be combined with spin, wind, a "
                    "table of the lift, or a side_coefficient"
                )
            # ln((z + z_0)/z_0) is not defined at z <= -z_0.
            if isinstance(air.wind, WindProfile) and floor <= -air.wind.roughness:
                _refuse(
                    f"the ball lands at {floor}, which must be above -air.wind.roughness = "
                    f"{-air.wind.roughness}, because the wind has no value below that"
                )

        # above ground
        if z < floor:
            key = "position" if block == "launch" else "release"
            under = f"{block}.{key}[2] = {z} is underground: the ball lands at height {floor}"
            if not isinstance(self, FlightScene):
                _refuse(under)
            # A sinking ball would never rise through the landing height, and so never land.
            if not self.launch.velocity[2] > 0.0:
                _refuse(f"{under}, so launch.velocity[2] must be positive for it to rise there")
            if self.fence is not None:
                _refuse(f"{under}; with a fence, the launch must not be below the ground")

        # forces with a direction
        if air is None:
            return self
        side = air.side_coefficient
        if side is not None and side.value and not any(_across(side.direction, self)):
            _refuse(
                f"air.side_coefficient.direction = {list(side.direction)} is parallel to the "
                "velocity through the air at the start, but the force must be perpendicular to it; "
                "choose another direction, or the value 0"
            )
        # A law that vanishes with S has no jump where the spin is parallel to the velocity. With
        # the total spin the force is k R (C_L/S) ω × u, which is smooth where ω × u vanishes.
        jumps = air.lift_is_constant and reading.spin_parameter != "total"
        if jumps and spin is not None and any(spin) and not any(_across(spin, self)):
            _refuse(
                f"air.lift_coefficient: a constant lift has no direction where {block}.spin is "
                "parallel to the velocity through the air; use the law rational or linear, the "
                "number 0, or the reading spin_parameter = total"
            )
        return self


def _across(direction: Point, scene: _FlyingScene) -> Point:
    """Return the cross product of a direction and the velocity behind lift, at the start."""
    _, _, position, along, pace = scene._start
    wind = (0.0, 0.0, 0.0)
    if scene.air is not None and scene.reading.wind_acts_on == "both":
        wind = scene.air.wind_at(position[2], along[2])
    # The pace multiplies the product, not the velocity: a product of exactly 0 stays 0.
    across = scaled(pace, cross(direction, along))
    return plus(across, scaled(-1.0, cross(direction, wind)))


def landing_height(scene: Any, exact: Callable[[Any], Any] = float) -> Any:
    """Return the height of the ball's centre at landing, m, as a sum of an engine's numbers."""
    height = exact(scene.ground.height)
    surface = scene.reading.ground_contact == "surface"
    return height + exact(scene.ball.radius) if surface else height


class FlightScene(_FlyingScene):
    """A ball from launch to landing."""

    kind: Literal["flight"] = "flight"
    launch: Launch
    ground: Ground = Ground()
    fence: Fence | None = None

    @model_validator(mode="after")
    def _inside_the_fence(self) -> Self:
        # Only for circles: a polyline may be open behind the plate, and then has no inside.
        x, y, _ = self.launch.position
        _require_inside(self.fence, "launch.position", math.hypot(x, y))
        return self


class PitchScene(_FlyingScene):
    """A throw from the mound to the plane x = 0 above a ground at height 0."""

    kind: Literal["pitch"] = "pitch"
    pitch: Pitch = Pitch()

    @property
    def ground(self) -> Ground:
        """Ground of the paper's field; pitch scenes have no other."""
        return Ground()


class ImpactScene(_Scene):
    """Ball and bat at their contact."""

    kind: Literal["impact"] = "impact"
    bat: Bat = Bat()
    swing: Rotation = Rotation()
    incoming: Incoming

    @model_validator(mode="after")
    def _touching(self) -> Self:
        x, _, z = self.incoming.position
        distance = math.hypot(x, z - self.incoming.bat_height)
        reach = self.ball.radius + self.bat.radius
        if abs(distance - reach) > TOUCHING:
            where = "inside the bat" if distance < reach else "away from the bat"
            _refuse(
                f"incoming.position is {where}: its distance from the bat's axis is "
                f"{distance} m, and must be R + r_b = {reach} m"
            )
        _require_support(self)
        return self


class AtBatScene(_FlyingScene):
    """Pitch, swing, contact, impact and flight."""

    kind: Literal["at-bat"] = "at-bat"
    pitch: Pitch = Pitch()
    bat: Bat = Bat()
    swing: Swing = Swing()
    ground: Ground = Ground()
    fence: Fence | None = None

    @model_validator(mode="after")
    def _has_support_inside_the_fence(self) -> Self:
        _require_support(self)
        # Farthest contact from the plate: R + r_b from the axis, and half a bat from its middle.
        farthest = math.hypot(self.ball.radius + self.bat.radius, self.bat.length / 2)
        _require_inside(self.fence, "the bat's reach", farthest)
        return self


def _require_inside(fence: Fence | None, what: str, distance: float) -> None:
    if fence is not None and fence.radius is not None and not distance < fence.radius:
        _refuse(f"fence.radius = {fence.radius} m: {what} is outside, {distance} m from the plate")


def _require_support(scene: ImpactScene | AtBatScene) -> None:
    if scene.bat.support == "free" and scene.reading.effective_mass == "as_printed":
        _refuse(
            "bat.support = free has no pivot, but the reading effective_mass = as_printed needs "
            "the distance from it; use effective_mass = inertia_over_r_squared, or support = pivot"
        )


Scene = FlightScene | PitchScene | ImpactScene | AtBatScene
KINDS: dict[str, type[Scene]] = {x.model_fields["kind"].default: x for x in get_args(Scene)}


def may_be_mixed(scene: Scene) -> bool:
    """True if scenes between two valid ones of this form are valid, too.

    Most conditions on a scene describe a convex set of its numbers. The exceptions are: the ball
    must touch the bat, a spin or a side force must not be parallel to the velocity, and a fence
    must not cross itself.
    """
    # Columns of such scenes are validated by their smallest and largest values alone.
    if isinstance(scene, ImpactScene):
        return False
    _, spin, *_ = scene._start
    spun = spin is not None and scene.air is not None and scene.air.lift_is_constant
    if scene.air is not None and scene.air.side_coefficient is not None:
        return False
    fence = None if isinstance(scene, PitchScene) else scene.fence
    return not spun and (fence is None or fence.polyline is None)


def ids_of(scenes: Sequence[Scene]) -> list[str]:
    """Return the ids of the results of scenes: the scene's, or the number of the line."""
    return [scene.id or str(number) for number, scene in enumerate(scenes, 1)]


def written_out(scene: Scene) -> Scene:
    """Return a scene with all defaults given, except those of its reading."""
    return parse_scene(scene.line())


def parse_scene(
    line: str | bytes, change: Callable[[dict[str, Any]], dict[str, Any]] | None = None
) -> Scene:
    """Return the scene of a line of JSON, after an optional change of its data.

    `InvalidScene` names the key at fault.
    """
    text = _text(line)
    try:
        data = _DECODER.decode(text)
    except json.JSONDecodeError as error:
        fault = _JSON_FAULTS.get(error.msg, f"{error.msg} at character {{at}}")
        raise InvalidScene(f"not JSON: {fault.replace('{at}', str(error.pos + 1))}") from None
    except RecursionError:
        raise InvalidScene("not a scene: the brackets are nested too deeply") from None
    if not isinstance(data, dict):
        raise InvalidScene(f"not a scene: a JSON object is needed, not {short(data)}")
    if change:
        return scene_of(change(data))
    return _validated(data, text)


def scene_of(data: Mapping[str, Any]) -> Scene:
    """Return the scene of a mapping with values of Python, NumPy and pandas; see `parse_scene`."""
    # A mapping may hold itself.
    try:
        text = json_text(data)
    except RecursionError:
        raise InvalidScene("not a scene: its blocks are nested too deeply") from None
    return _validated(data, _text(text))


def _validated(data: Mapping[str, Any], text: str) -> Scene:
    scene_id = _text_of_whole(data.get("id"))
    # Read before validation, so that an error has the id.
    scene_id = scene_id if _is_text(scene_id) else None
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        like = next((key for key in data if did_you_mean(key, ["kind"])), None)
        given = f"is missing, and {like} is not a key" if like else "is missing"
        given = f"{short(kind)} is not a kind of scene" if "kind" in data else given
        raise InvalidScene(f"kind: {given}{one_of('the kinds are', kind, KINDS)}", scene_id)
    try:
        # Pydantic's own strict JSON mode: it rejects "1" for 1, and 1 for true, but takes lists as
        # tuples.
        return KINDS[kind].model_validate_json(text)
    except ValidationError as error:
        raise InvalidScene(explain(error, KINDS[kind]), scene_id) from None


def _text(line: str | bytes) -> str:
    # Checked before parsing: an endless line would fill the memory.
    if len(line) > LONGEST_LINE:
        raise InvalidScene(f"longer than {LONGEST_LINE:,} bytes")
    if isinstance(line, str):
        if not _is_text(line):
            raise InvalidScene("not Unicode text: it contains half of a surrogate pair")
        return line
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidScene(not_utf8(error)) from None


# Frequent messages of Python's parser, and ours.
_JSON_FAULTS = {
    "Extra data": "text after the scene, from character {at} on; write one scene per line",
    "Expecting value": 'at character {at} a value is needed, such as {"kind": "at-bat"} or 9.8',
    "Expecting property name enclosed in double quotes": "at character {at} a key in double quotes "
    "is needed",
}


def _is_text(value: Any) -> bool:
    """True if a value is a string that can be written: no half of a surrogate pair."""
    if not isinstance(value, str):
        return False
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def _each_key_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    block = dict(pairs)
    if len(block) < len(pairs):
        # Python would silently take the last of the two values.
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InvalidScene(f"{twice}: the key is given twice in one block")
    return block


# Python raises an error for whole numbers of thousands of digits; a float is out of range, and gets
# a message with its key.
_DECODER = json.JSONDecoder(
    object_pairs_hook=_each_key_once,
    parse_int=lambda digits: int(digits) if len(digits) <= _MOST_DIGITS else float(digits),
)


def vector_length(name: str) -> int | None:
    """Return the length of the vector with a name, 2 or 3; None for other values."""
    fields = [field for kind in KINDS.values() for field in parts_of(kind, name.split("."))]
    parts = [get_args(x) for field in fields for x in within(field.annotation)]
    return next((len(part) for part in parts if is_vector(part)), None)
