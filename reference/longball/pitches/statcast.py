"""Rows of Statcast's tables as scenes: units, frames, spins, and the weather of a game.

Statcast uses feet, miles per hour, degrees and revolutions per minute, in a frame with x to the
catcher's right, y from the tip of home plate to the pitcher, and z up. Scenes have x to the pitcher
and y to the catcher's left, so that

    (x, y, z) of a scene = (y, -x, z) of Statcast.

A pitch is a fit of constant acceleration: `vx0`, …, `az` are its values at y = 50 ft, and `plate_x`
and `plate_z` its position at the front of the plate, 17 inches before the tip. The scene of a pitch
begins at the release, with the velocity of the fit there; its plane x = 0 is the front of the
plate. `spin_axis` is the axis projected on the plane of x and z: backspin is 180°, and at 90° the
ball breaks to the catcher's right.

A batted ball has a speed and a launch angle, but no direction. `hc_x` and `hc_y` give the point
where a fielder took it, on a drawing of the field; the bearing of this point replaces the direction
of the launch (Petti's transformation, baseballwithr.wordpress.com, 2018).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TextIO, get_args

import numpy as np

from longball.home_run.at_bats import Arrays
from longball.model.arrays import Array, Flags, Integers
from longball.model.inputs import CONTACT
from longball.model.names import one_of
from longball.pitches.table import (
    DATA,
    LENGTH_UNITS,
    SPEED_UNITS,
    USUAL,
    NoSuchColumn,
    Omission,
    TableError,
    numbers,
    read_columns,
    read_table,
    require_degrees,
    require_usual,
    select_rows,
    texts,
    unit_that_explains,
    unusual,
    unusual_rows,
)

if TYPE_CHECKING:
    import pandas as pd

Kind = Literal["pitch", "batted"]

FOOT, INCH = LENGTH_UNITS["ft"], LENGTH_UNITS["in"]
MPH = SPEED_UNITS["mph"]
RPM = 2.0 * np.pi / 60.0  # rad/s
FAHRENHEIT = 1.0 / 1.8  # K of a degree

GAMES = DATA / "games_2023-06-11.csv"
PARKS = DATA / "parks.csv"

# y of the plane of the fit, and of the front of the plate, from its tip, m.
FIT_PLANE = 50.0 * FOOT
PLATE_FRONT = 17.0 / 12.0 * FOOT

# Position of the plate on the drawing of hc_x and hc_y (Petti).
DRAWN_PLATE = (125.42, 198.27)

# Weather of a game that is not in the table of games, K and m.
USUAL_TEMPERATURE, SEA_LEVEL = 293.15, 0.0

# Launch angles, rad, and least speed, m/s, of the flies that are predicted. The recorded distance
# of a flatter ball is where it was stopped, not where it landed; a slower one hardly flies.
LOWEST, HIGHEST, SLOWEST = np.radians(10.0), np.radians(60.0), 60.0 * MPH

# Largest bearing, rad: the foul lines at 45°, and 15° for the difference between the point on the
# drawing and the direction of the launch. The regression of the spin is for fair balls.
WIDEST = np.radians(60.0)

# Columns that identify a row for its reader; they are passed on as they are.
IDENTITY = ("game_pk", "at_bat_number", "pitch_number", "player_name", "events")

# Distance of the pitcher's rubber from the plate's tip, ft. `release_extension` counts from there.
RUBBER = 60.5


@dataclass(frozen=True, kw_only=True)
class Rows(Arrays):
    """The complete rows of a table; arrays have an element for each, in SI units."""

    what: ClassVar[str]  # plural noun for messages
    components: ClassVar[tuple[str, ...]]  # names of the measured components
    unit: ClassVar[tuple[float, str]]  # unit of the measurement: size in m, and name
    seen: ClassVar[tuple[tuple[str, float], ...]]  # printed components, with their signs

    # Name of the table, its number of rows, and the omitted rows.
    source: str = ""
    rows_read: int = 1
    left_out: tuple[Omission, ...] = ()
    rows: Integers  # row numbers, from 1 below the header
    games: Integers  # game_pk, or 0 if the table has none
    # Columns of `IDENTITY` that the table has, and their texts, shape (n, columns); "" if missing.
    identified: tuple[str, ...] = ()
    identity: Any
    # Weather and park, K and m.
    temperature: Array
    elevation: Array
    weather_unknown: int = 0  # number of rows with the usual weather
    assumed: tuple[str, ...] = ()  # sentences on the values that replace missing columns
    doubts: tuple[str, ...] = ()  # questions on columns that seem to be in another unit

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.rows)

    def name(self, i: int) -> str:
        """Return the number of the i-th row, and the texts that identify it."""
        # A game alone identifies no row.
        known = self.identity[i] if len(self.identified) > 1 else []
        return ", ".join(filter(None, [f"row {self.rows[i]}", *known]))


@dataclass(frozen=True, kw_only=True)
class MeasuredPitches(Rows):
    """Pitches in the frame of scenes."""

    what, components, unit = "pitches", ("y", "z"), (INCH, "in")
    seen = ("right", -1.0), ("up", 1.0)  # as the catcher sees them

    labels: Any  # Statcast's types
    # At the release, m and m/s, shape (n, 3).
    release: Array
    velocity: Array
    acceleration: Array  # of the recorded fit, m/s², shape (n, 3)
    spin_rate: Array  # rad/s
    axis: Array  # unit vectors along the transverse component of the spin, shape (n, 3)
    hand: Array  # 1 for a right-handed pitcher, -1 for a left-handed one
    measured: Array  # y and z at the front of the plate, m, shape (n, 2)

    def spin(self, active: Array) -> Array:
        """Return the spin, rad/s; the share `active` is perpendicular to the release velocity.

        The rest is along the velocity, as the spin of a bullet: clockwise as a right-handed pitcher
        sees it, counter-clockwise for a left-handed one.
        """
        along = self.velocity / np.linalg.norm(self.velocity, axis=1, keepdims=True)
        gyro = (self.hand * np.sqrt(1.0 - active**2))[:, None] * along
        spin: Array = self.spin_rate[:, None] * (active[:, None] * self.axis + gyro)
        return spin

    def scene(self, i: int) -> dict[str, Any]:
        """Return the scene of the i-th pitch, without its spin."""
        pitch = {"release": self.release[i].tolist(), "velocity": self.velocity[i].tolist()}
        return {"kind": "pitch", "pitch": pitch}


@dataclass(frozen=True, kw_only=True)
class MeasuredFlies(Rows):
    """Batted balls in the frame of scenes."""

    what, components, unit = "batted balls", ("distance",), (FOOT, "ft")
    seen = (("bias", 1.0),)

    speed: Array  # m/s, off the bat
    angle: Array  # rad, of the launch above the horizontal
    bearing: Array  # rad, positive to right field
    side: Array  # 1 for a right-handed batter, -1 for a left-handed one, 0 if unknown
    measured: Array  # `hit_distance_sc`, m, shape (n, 1); NaN if the table lacks it

    @property
    def velocity(self) -> Array:
        """Velocity at the launch, m/s, shape (n, 3)."""
        return self.speed[:, None] * directions(self.angle, self.bearing)

    def spin(self, backspin: Array, side_spin: Array) -> Array:
        """Return the spin, rad/s, shape (n, 3), from its two components across the velocity.

        Backspin turns about a horizontal axis and lifts the ball. Side spin turns about the axis
        perpendicular to it in the vertical plane of the launch; positive side spin curves the ball
        to the left.
        """
        ahead = self.bearing
        lifts = np.stack([-np.sin(ahead), -np.cos(ahead), np.zeros_like(ahead)], axis=1)
        turns = directions(self.angle + np.pi / 2, ahead)
        spin: Array = backspin[:, None] * lifts + side_spin[:, None] * turns
        return spin

    def scene(self, i: int) -> dict[str, Any]:
        """Return the scene of the i-th ball, without its spin."""
        launch = {"position": list(CONTACT), "velocity": self.velocity[i].tolist()}
        return {"kind": "flight", "launch": launch}


def directions(angle: Array, bearing: Array) -> Array:
    """Return unit vectors at an angle above the horizontal and a bearing to the right, rad."""
    level = np.cos(angle)
    parts = [level * np.cos(bearing), -level * np.sin(bearing), np.sin(angle)]
    return np.stack(parts, axis=-1)


def read_measured(
    table: str | Path | TextIO | pd.DataFrame,
    kind: Kind,
    games: str | Path | TextIO | pd.DataFrame = GAMES,
    *,
    spin: bool = True,
    names: Mapping[str, str] | None = None,
) -> MeasuredPitches | MeasuredFlies:
    """Read the pitches of a table in Statcast's columns, or the flies among its batted balls.

    A table is the path of a .csv or .parquet file, an open file, or a pandas DataFrame; `names`
    gives its own names of Statcast's columns. Without `spin`, pitches need no spin columns. `games`
    has ``game_pk``, ``temperature`` (°F), and ``elevation`` (ft) or ``park``; other games get the
    usual temperature at sea level. A `TableError` says which column or row cannot be used, and why.
    """
    if kind not in (kinds := get_args(Kind)):
        raise ValueError(f"kind {kind!r}: there is none{one_of('the kinds are', kind, kinds)}")
    if kind == "pitch":
        return _pitches(table, games, spin, names)
    return _flies(table, games, names)


# --- pitches --------------------------------------------------------------------------------------

_SPIN = ("release_spin_rate", "spin_axis")
_PITCH_NUMBERS = (
    "release_pos_x", "release_pos_z", "vx0", "vy0", "vz0", "ax", "ay", "az", "plate_x", "plate_z",
)  # fmt: skip


def _pitches(
    table: Any, games: Any, spin: bool, names: Mapping[str, str] | None
) -> MeasuredPitches:
    needed = ["pitch_type", *_PITCH_NUMBERS, *(("p_throws", *_SPIN) if spin else ())]
    optional = [*IDENTITY, "release_pos_y", "release_extension", "release_speed"]
    source, frame = read_table(table, needed, optional, names)
    # Some tables have the extension from the rubber in place of the distance from the plate.
    if "release_pos_y" not in frame:
        if "release_extension" not in frame:
            raise NoSuchColumn(
                "release_pos_y: the table has no such column, nor release_extension",
                ["release_pos_y"],
            )
        frame["release_pos_y"] = RUBBER - numbers(frame["release_extension"])
    kind = texts(frame["pitch_type"])
    nothing = np.full(len(frame), np.nan)
    hand, odd_hand = nothing, np.zeros(len(frame), dtype=bool)
    if spin:
        hand, odd_hand = _side(frame["p_throws"])
    asked = (*(_SPIN if spin else ()), "release_pos_y", *_PITCH_NUMBERS)
    read, odd_cells = read_columns(frame, asked)
    values = dict.fromkeys(_SPIN, nothing) | read
    # A row is listed under its first fault, so the order is from missing to implausible.
    lacks = [
        *odd_cells,
        ("pitch_type is missing", kind.isna().to_numpy(dtype=bool)),
        ("p_throws is neither R nor L", odd_hand),
        ("p_throws is missing", np.isnan(hand) & spin),
        *((f"{name} is missing", np.isnan(column)) for name, column in read.items()),
        ("release_spin_rate is 0: not measured", values["release_spin_rate"] == 0.0),
        ("plate_z is below the ground: it bounced first", values["plate_z"] < 0.0),
        ("vy0 is not below 0: away from the plate", values["vy0"] >= 0.0),
        (
            "release_pos_y is behind the front of the plate",
            values["release_pos_y"] * FOOT <= PLATE_FRONT,
        ),
    ]
    keep, kept, shared = _selected(source, frame, lacks, values, games)
    # Small angles in degrees look like radians, so the test needs the whole column.
    require_degrees(kept["spin_axis"], "spin_axis", 2.0 * np.pi)
    if "release_speed" in frame:
        velocity = np.hypot(np.hypot(kept["vx0"], kept["vy0"]), kept["vz0"])
        _require_agreement(velocity, numbers(frame["release_speed"])[keep])

    def vector(*names: str) -> Array:
        return np.stack([kept[name] for name in names], axis=1) * FOOT

    # The fit is given at y = 50 ft; the scene begins at the release, a few feet earlier.
    velocity, acceleration = vector("vx0", "vy0", "vz0"), vector("ax", "ay", "az")
    release = vector("release_pos_x", "release_pos_y", "release_pos_z")
    since = time_of_plane(velocity[:, 1], acceleration[:, 1], release[:, 1] - FIT_PLANE)
    at_release = _in_our_frame(velocity + acceleration * since[:, None])
    measured = np.stack([-kept["plate_x"], kept["plate_z"]], axis=1) * FOOT
    _require_same_places(measured, _in_our_frame(release), at_release, _in_our_frame(acceleration))
    angle = np.radians(kept["spin_axis"])
    axis = _in_our_frame(np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=1))
    return MeasuredPitches(
        **shared,
        labels=kind[keep].to_numpy(dtype=str),
        release=_in_our_frame(release) - [PLATE_FRONT, 0.0, 0.0],
        velocity=at_release,
        acceleration=_in_our_frame(acceleration),
        spin_rate=kept["release_spin_rate"] * RPM,
        axis=_across(axis, at_release),
        hand=hand[keep],
        measured=measured,
    )


def _in_our_frame(vectors: Array) -> Array:
    x, y, z = vectors.T
    return np.stack([y, -x, z], axis=1)


def time_of_plane(speed: Any, acceleration: Any, distance: Any) -> Any:
    """Return the time at which a ball of constant acceleration has moved by a distance.

    It is the root nearest to 0 of speed · t + acceleration · t²/2 = distance, for a negative speed.
    """
    # This form of the root has no cancellation, and no division by an acceleration of zero.
    root = np.sqrt(np.maximum(speed**2 + 2.0 * acceleration * distance, 0.0))
    return 2.0 * distance / (speed - root)


def _across(axis: Array, velocity: Array) -> Array:
    """Return the unit vectors along the components of `axis` across the velocity."""
    along = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
    across = axis - np.sum(axis * along, axis=1, keepdims=True) * along
    unit: Array = across / np.linalg.norm(across, axis=1, keepdims=True)
    return unit


# --- batted balls ---------------------------------------------------------------------------------

_PLACE = ("hc_x", "hc_y")


def _flies(table: Any, games: Any, names: Mapping[str, str] | None) -> MeasuredFlies:
    optional = [*IDENTITY, "stand", "hit_distance_sc", *_PLACE]
    source, frame = read_table(table, ["launch_speed", "launch_angle"], optional, names)
    here = [name for name in ("hit_distance_sc", *_PLACE) if name in frame]
    values, odd_cells = read_columns(frame, ("launch_speed", "launch_angle", *here))
    if (odd := [name for name in _PLACE if name not in frame]) and len(odd) == 1:
        raise NoSuchColumn(f"{odd[0]}: the table has no such column, and it has the other", odd)
    nothing = np.full(len(frame), np.nan)
    require_degrees(values["launch_angle"], "launch_angle", np.pi / 2.0)
    side, odd_side = np.zeros(len(frame)), np.zeros(len(frame), dtype=bool)
    if "stand" in frame:
        side, odd_side = _side(frame["stand"])
    speed, angle = values["launch_speed"] * MPH, np.radians(values["launch_angle"])
    # Test the unit before slow balls are omitted: in m/s, few flies are above 60.
    up = (angle >= LOWEST) & (angle <= HIGHEST)
    doubt = unusual(values["launch_speed"][up & ~np.isnan(speed)], "launch_speed")
    if doubt and not (speed[up] > SLOWEST).any():
        raise TableError(doubt)
    # On the drawing, y points down, and x to the right.
    x, y = (values.get(name, nothing) for name in _PLACE)
    bearing = np.arctan2(x - DRAWN_PLATE[0], DRAWN_PLATE[1] - y) if "hc_x" in here else 0.0 * speed
    lacks = [
        *odd_cells,
        *((f"{name} is missing", np.isnan(column)) for name, column in values.items()),
        ("stand is neither R nor L", odd_side),
        ("stand is missing", np.isnan(side)),
        ("hc_x and hc_y are 0: not measured", (x == 0.0) & (y == 0.0)),
        ("hit_distance_sc is 0: not measured", values.get("hit_distance_sc", nothing) == 0.0),
        ("launch_angle is not between 10° and 60°", ~up),
        ("launch_speed is not above 60 mph", ~(speed > SLOWEST)),
        ("the direction is not between the foul lines, by over 15°", ~(abs(bearing) <= WIDEST)),
    ]
    keep, _, shared = _selected(source, frame, lacks, values, games)
    shared["doubts"] = (*filter(None, [doubt]), *shared["doubts"])
    assumed = tuple(
        f"no column {name}: {stands}"
        for name, stands in (
            ("stand", "no spin that depends on the batter's side"),
            ("hc_x", "hit to centre field"),
            ("hit_distance_sc", "predicted, and compared with nothing"),
        )
        if name not in frame
    )
    return MeasuredFlies(
        **shared,
        assumed=assumed,
        speed=speed[keep],
        angle=angle[keep],
        bearing=bearing[keep],
        side=side[keep],
        measured=values.get("hit_distance_sc", nothing)[keep, None] * FOOT,
    )


# --- both -----------------------------------------------------------------------------------------


def _side(column: pd.Series) -> tuple[Array, Flags]:
    """Return 1 for R or Right, -1 for L or Left, NaN for other values, and flags of the latter.

    A column with other values alone raises a `TableError`.
    """
    text = texts(column).replace({"Right": "R", "Left": "L"})
    odd = (text.notna() & ~text.isin(["R", "L"])).to_numpy(dtype=bool)
    if odd.any() and odd[text.notna()].all():
        raise TableError(
            f"{column.name}: row {int(np.argmax(odd)) + 1} below the header has "
            f"{text[odd].iloc[0]!r}, which is neither R nor L"
        )
    return np.asarray(text.map({"R": 1.0, "L": -1.0}), dtype=np.float64), odd


def _require_agreement(velocity: Array, speed: Array) -> None:
    """Require that velocities in ft/s agree with release speeds in mph.

    From the release to y0 = 50 ft a pitch loses 1 % or 2 %.
    """
    # Any confusion of ft/s, mph, m/s and km/h changes the ratio by at least 9 % (km/h and ft/s).
    # Without a single release speed there is nothing to compare.
    known = speed > 0.0
    ratio = float(np.median(velocity[known] / speed[known])) if known.any() else MPH / FOOT
    if not 0.95 <= ratio / (MPH / FOOT) <= 1.05:
        raise TableError(
            f"vx0, vy0, vz0: their length is {ratio:.3g} times release_speed, and in ft/s and mph "
            f"it would be {MPH / FOOT:.3f} times; is one of them in another unit?"
        )


def _require_same_places(
    places: Array, release: Array, velocity: Array, acceleration: Array
) -> None:
    """Require that positions at the plate are in the same unit as the fit."""
    time = time_of_plane(velocity[:, 0], acceleration[:, 0], PLATE_FRONT - release[:, 0])[:, None]
    crossed = (release + velocity * time + acceleration * time**2 / 2.0)[:, 1:]
    ratios = np.linalg.norm(places, axis=1) / np.linalg.norm(crossed, axis=1)
    ratio = float(np.median(ratios))
    if unit := unit_that_explains(ratio, "ft"):
        raise TableError(
            f"plate_x, plate_z: they are {ratio:.3g} times as far from the middle of the plate as "
            f"the recorded velocity and acceleration say; are they in {unit}? The table must be in "
            "ft here"
        )


def _selected(
    source: str,
    frame: pd.DataFrame,
    lacks: Sequence[tuple[str, Flags]],
    values: Mapping[str, Array],
    games: Any,
) -> tuple[Flags, dict[str, Array], dict[str, Any]]:
    """Return flags of the rows without a fault, their values, and the fields of `Rows`."""
    left_out, keep = select_rows(lacks, len(frame))
    kept, rows = {name: column[keep] for name, column in values.items()}, np.flatnonzero(keep) + 1
    for name in filter(kept.__contains__, USUAL):
        require_usual(kept[name], name)
    nothing = np.full(len(frame), np.nan)
    # A table without games has the usual weather in every row.
    game = (numbers(frame["game_pk"]) if "game_pk" in frame else nothing)[keep]
    temperature, elevation = (
        np.array([known.get(pk, np.nan) for pk in game.tolist()]) for known in _weather(games)
    )
    # Games may be missing: a table of games rarely has all of them.
    unknown = np.isnan(temperature)
    here = [name for name in IDENTITY if name in frame]
    fields = {
        "source": source,
        "rows_read": len(frame),
        "left_out": left_out,
        "rows": rows,
        "games": np.nan_to_num(game).astype(np.int64),
        "identified": (*here,),
        "identity": frame[here].apply(texts).fillna("").to_numpy(dtype=object)[keep],
        "temperature": np.where(unknown, USUAL_TEMPERATURE, temperature),
        "elevation": np.where(unknown, SEA_LEVEL, elevation),
        "weather_unknown": int(unknown.sum()),
        "doubts": tuple(unusual_rows(kept, rows)),
    }
    return keep, kept, fields


def _weather(games: Any) -> tuple[dict[float, float], dict[float, float]]:
    """Return the temperature of each game, K, and the elevation of its park, m."""
    try:
        source, frame = read_table(games, ["game_pk", "temperature"], ["park", "elevation"])
    # As another error, because `--column` names columns of the pitches, not of the games.
    except NoSuchColumn as error:
        raise TableError(f"the table of games: {error}") from None
    game, fahrenheit = numbers(frame["game_pk"]), numbers(frame["temperature"])
    if np.isnan(game).any() or np.isnan(fahrenheit).any():
        raise TableError(f"{source}: a game has no game_pk or no temperature")
    # Of two rows for a game the last would win silently, perhaps with another game's temperature.
    again = np.flatnonzero(frame.assign(game_pk=game).duplicated("game_pk"))
    if again.size:
        raise TableError(
            f"{source}: game_pk: row {again[0] + 1} below the header has {game[again[0]]:.0f}, "
            "which another row has already; a game must be there once"
        )
    if doubt := unusual(fahrenheit, "temperature"):
        raise TableError(f"{source}: {doubt} The table must be in °F here")
    celsius = (fahrenheit - 32.0) * FAHRENHEIT
    height = _elevations(source, frame)
    return (
        dict(zip(game.tolist(), (celsius + 273.15).tolist(), strict=True)),
        dict(zip(game.tolist(), height.tolist(), strict=True)),
    )


def _elevations(source: str, games: pd.DataFrame) -> Array:
    """Return the elevation of each game, m, from the table or from its park."""
    if not {"park", "elevation"} & {*games}:
        raise TableError(f"{source}: a table of games has a column park, or elevation, in ft")
    _, parks = read_table(PARKS, ["park", "elevation"])
    known = dict(zip(texts(parks["park"]), numbers(parks["elevation"]), strict=True))
    nothing = np.full(len(games), np.nan)
    feet = numbers(games["elevation"]) if "elevation" in games else nothing
    for i in np.flatnonzero(np.isnan(feet)):
        park = texts(games["park"]).iloc[i] if "park" in games else None
        if not isinstance(park, str):
            raise TableError(f"{source}: a game has no park")
        if park not in known:
            raise TableError(
                f"{source}: park: the elevation of {park!r} is not known; give it in a column "
                f"elevation, in ft{one_of('the parks are', park, known)}"
            )
        feet[i] = known[park]
    return feet * FOOT
