"""The spin that a pitch needs for its movement, by the scene's own law of lift.

With the velocity v and the acceleration a at a point of the pitch, u the velocity through the air,

    a_D = -(a + g e_z)·û,   a_M = a + g e_z + a_D û,   C_L = |a_M| / (k U²),   k = ρ A / (2 m),

and the law of C_L gives S = R ω_T / U: how fast the ball turns across its way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import root

from longball.api import as_scene
from longball.engines.engine import CannotSolve
from longball.model.air import Air, law_name
from longball.model.arrays import Array
from longball.model.law import per_metre
from longball.model.names import one_of
from longball.model.numbers import DOUBLES
from longball.model.scene import AtBatScene, InvalidScene, PitchScene, Scene
from longball.model.vectors import part_across
from longball.pitches.models import FlightModel
from longball.pitches.statcast import MeasuredPitches, time_of_plane
from longball.questions.movement import Movement, movement, vectors
from longball.solution import real_numbers

# Of a share: of a ball whose spin is all active the law there and back gives 1 to 1e-13.
_ROUNDING = 1e-12

# m: largest error of a movement; rounding leaves 1e-14.
_MISSED = 1e-9

# Laws of the spin parameter, which can be asked for it.
_INVERTED = ("rational", "linear", "bilinear", "table")


@dataclass(frozen=True)
class SpinFromMovement:
    """The spin that a movement needs; arrays have a number for each pitch.

    Attributes
    ----------
    transverse
        rad/s, shape (…, 3): the spin across the velocity through the air.
    drag_coefficient, lift_coefficient
        C_D and C_L, shape (…).
    active_share
        Of the measured rate, shape (…); None if no rate is given. Above 1 the ball moves more than
        its whole spin can move it: the movement has another cause, or the rate is wrong.
    spin
        rad/s, shape (…, 3): with the part along the velocity; NaN where the share is above 1, and
        None without a rate.
    above_one
        Where the share is above 1, shape (…); None without a rate.
    reasons
        Why pitches have no spin, by their number, in order.
    """

    transverse: Array
    drag_coefficient: Any
    lift_coefficient: Any
    active_share: Any = None
    spin: Array | None = None
    above_one: Any = None
    reasons: dict[int, str] = field(default_factory=dict)

    @property
    def rate(self) -> Any:
        """The size of the transverse spin, rad/s, shape (…)."""
        return np.linalg.norm(self.transverse, axis=-1)[()]


def spin_from_movement(
    scene: object,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    rate: ArrayLike | None = None,
    gyro: ArrayLike = 1.0,
    height: float = 0.0,
) -> SpinFromMovement:
    """Compute the spin across its way that a pitch needs for its acceleration.

    Parameters
    ----------
    scene
        A pitch or an at-bat, as `solve` takes it: its ball, air, gravity and law of lift count, and
        its side force is taken off; a mapping need not have a spin. A law of the spin parameter is
        needed: rational, linear, bilinear, or a table.
    velocity, acceleration
        m/s and m/s², shape (…, 3), at one point of the pitch; of nine parameters best in the middle
        of the way, where the acceleration is nearest to its mean.
    rate
        rad/s, shape (…): the whole spin that was measured. With it the active share is returned.
    gyro
        The sign of the spin along the velocity, shape (…): 1 along it, -1 against it.
    height
        m, of that point: for a wind or a density that depend on it.

    Raises
    ------
    InvalidScene
        If `scene` describes none.
    ValueError
        If its law of lift cannot be asked for a spin. Of a single pitch also if its C_L is above
        what the law reaches; of many such a row is NaN, and named in `reasons`.

    Examples
    --------
    >>> import longball as lb
    >>> air = {"lift_coefficient": {"law": "rational"}, "density": 1.2}
    >>> found = lb.spin_from_movement(
    ...     {"kind": "pitch", "air": air}, [-40, 0, -2], [8, 0, -3.6], rate=240
    ... )
    >>> f"C_L = {found.lift_coefficient:.3f}, {found.active_share:.0%} active"
    'C_L = 0.207, 87% active'
    """
    asked = _asked(scene)
    if not isinstance(asked, PitchScene | AtBatScene):
        raise ValueError(f"scene: a pitch or an at-bat is needed, and this is a {asked.kind}")
    air = _air_of(asked)
    per_unit = per_metre(asked, 1.0, DOUBLES)
    if per_unit is None:
        raise ValueError("air.density: is 0, and nothing can move the ball")
    if air.density_scale_height is not None:
        per_unit *= float(np.exp(-height / air.density_scale_height))

    # the forces
    v, a = vectors("velocity", velocity), vectors("acceleration", acceleration)
    wind = np.array(air.wind_at(height, 1.0))
    u = v - wind
    speed = np.linalg.norm(u, axis=-1)
    if not speed.all():
        raise ValueError(f"velocity = {velocity!r}: the ball must move through the air")
    ahead = u / speed[..., None]
    free = a + np.array([0.0, 0.0, asked.gravity])
    # Drag is what is left along the way when gravity is taken off; lift is what is left across it.
    slowing = -np.sum(free * ahead, axis=-1)
    pressure = per_unit * speed**2
    moving = free + slowing[..., None] * ahead
    if (side := air.side_coefficient) is not None:
        parts = part_across(side.direction, (u[..., 0], u[..., 1], u[..., 2]), speed**2)
        whole = np.stack(parts, axis=-1)
        size = np.linalg.norm(whole, axis=-1)
        moving = moving - (side.value * pressure / size)[..., None] * whole
    force = np.linalg.norm(moving, axis=-1)
    drag, lift = slowing / pressure, force / pressure

    # the spin
    spin_parameter, most = _spin_parameter(air, lift)
    sense = -1.0 if most < 0.0 else 1.0
    beyond = np.isnan(spin_parameter)
    message = (
        "C_L = {:.4g} is above what the law of air.lift_coefficient reaches, "
        f"{abs(most):.4g}: no spin moves a ball so far"
    )
    if beyond.ndim == 0 and beyond:
        raise ValueError(message.format(float(lift)))
    size = spin_parameter * speed / asked.ball.radius
    unit = moving / np.where(force > 0.0, force, 1.0)[..., None]
    transverse = sense * size[..., None] * np.cross(ahead, unit)
    reasons = {int(i): message.format(lift.flat[i]) for i in np.flatnonzero(beyond)}
    if rate is None:
        return SpinFromMovement(transverse, drag[()], lift[()], reasons=reasons)
    whole = real_numbers("rate", rate)
    if not (whole > 0.0).all():
        raise ValueError(f"rate = {rate!r}: spins must be positive, rad/s")
    # The spin along the way makes no force: ω² = ω_T² + ω_along², whose sign nothing here shows.
    share = size / whole
    above = share > 1.0 + _ROUNDING
    along = np.sqrt(np.where(above, np.nan, np.maximum(whole**2 - size**2, 0.0)))
    spin = transverse + (np.sign(gyro) * along)[..., None] * ahead
    return SpinFromMovement(transverse, drag[()], lift[()], share[()], spin, above[()], reasons)


def _asked(scene: object) -> Scene:
    """Return a scene; a mapping of one need not have the spin that is asked for."""
    if isinstance(scene, Mapping) and scene.get("kind") in ("pitch", "at-bat"):
        # A law of the spin must have one in a scene.
        pitch = scene.get("pitch", {})
        if isinstance(pitch, Mapping):
            scene = {**scene, "pitch": {"spin": [0.0, 0.0, 0.0], **pitch}}
    return as_scene(scene)


def spin_for(
    scene: object, moved: Movement, since: float | None = None, **options: Any
) -> PitchScene:
    """Find the transverse spin that gives a pitch a movement.

    Parameters
    ----------
    scene
        A pitch, as `solve` takes it. The part of its spin along the velocity is kept.
    moved
        Movement relative to a flight under gravity alone, m; see `movement`.
    since
        x of the point from which the movement counts, m; the release by default.
    options
        ``engine=`` and options of it, as of `solve`.

    Returns
    -------
    PitchScene
        The pitch with that spin: ``.pitch.spin``, rad/s.

    Raises
    ------
    InvalidScene
        If `scene` describes no pitch.
    ValueError
        If its law of lift cannot be inverted, or no spin reaches the movement.
    CannotSolve
        If no spin is found.

    Examples
    --------
    >>> import longball as lb
    >>> air = {"lift_coefficient": {"law": "rational"}, "drag_coefficient": 0.35}
    >>> pitch = {"kind": "pitch", "pitch": {"speed": 42.0}, "air": air}
    >>> found = lb.spin_for(pitch, lb.Movement(across=0.2, up=0.4))
    >>> [round(x) for x in found.pitch.spin]
    [0, 88, -49]
    """
    asked = _asked(scene)
    if not isinstance(asked, PitchScene):
        raise InvalidScene(f"kind: must be 'pitch' here, and is {asked.kind!r}")
    if not isinstance(moved, Movement):
        raise TypeError(f"moved = {moved!r}: a movement is needed, lb.Movement(across=…, up=…), m")
    ahead = np.array(asked.pitch.thrown)
    ahead /= np.linalg.norm(ahead)
    up = np.array([0.0, 0.0, 1.0]) - ahead[2] * ahead
    up /= np.linalg.norm(up)
    # A force along n needs a spin along ahead × n: up, and to the left.
    axes = np.stack([np.cross(ahead, up), np.cross(ahead, np.cross(ahead, up))])
    kept = ahead * (ahead @ np.array(asked.pitch.spin or (0.0, 0.0, 0.0)))

    def thrown(parts: Array) -> PitchScene:
        return asked.replace(**{"pitch.spin": (kept + parts @ axes).tolist()})

    def off(parts: Array) -> list[float]:
        found = movement(thrown(parts), since=since, **options)
        return [found.up - moved.up, found.across - moved.across]

    # It begins with the spin for a constant acceleration, which also says what no spin reaches.
    # A twentieth of its speed is what a pitch loses on half of its way.
    far = asked.pitch.release[0] if since is None else since
    time = far / (0.95 * abs(asked.pitch.thrown[0]))
    push = 2.0 * np.array([0.0, moved.across, moved.up]) / time**2
    gravity = np.array([0.0, 0.0, -asked.gravity])
    start = spin_from_movement(asked, asked.pitch.thrown, push + gravity).transverse
    found = root(off, axes @ start, tol=1e-12)
    missed = math.hypot(*off(found.x))
    if not missed <= _MISSED:
        raise CannotSolve(
            f"no spin is found: the nearest one misses that movement by {missed:.2g} m"
        )
    return thrown(found.x)


def measured_spin(pitches: MeasuredPitches, model: FlightModel) -> dict[str, Array]:
    """Compute the spin that measured pitches need for their movement, in the middle of their way.

    Parameters
    ----------
    pitches
        As `longball.pitches.statcast.read_measured` returns them, with their spin.
    model
        Whose law of lift is asked, in the weather of each game.

    Returns
    -------
    dict of str to array
        ``drag_coefficient``, ``lift_coefficient``; ``transverse``, rad/s, NaN where the law does
        not reach the lift; and ``active_share`` of the rate that was measured.
    """
    speed, push = pitches.velocity[:, 0], pitches.acceleration[:, 0]
    half = 0.5 * time_of_plane(speed, push, -pitches.release[:, 0])
    middle = pitches.velocity + pitches.acceleration * half[:, None]
    # Pitches of one weather have one scene: a day has fifteen games and thousands of pitches.
    names = "drag_coefficient", "lift_coefficient", "transverse", "active_share"
    columns = {name: np.empty(len(pitches)) for name in names}
    weathers = np.stack([pitches.temperature, pitches.elevation], axis=1)
    for weather in np.unique(weathers, axis=0):
        here = (weathers == weather).all(axis=1)
        scene = {"kind": "pitch"} | model.blocks(*weather.tolist())
        found = spin_from_movement(
            scene, middle[here], pitches.acceleration[here], rate=pitches.spin_rate[here]
        )
        parts = found.drag_coefficient, found.lift_coefficient, found.rate, found.active_share
        for column, part in zip(columns.values(), parts, strict=True):
            column[here] = part
    return columns


def _air_of(scene: PitchScene | AtBatScene) -> Air:
    """Return the air of a scene whose law of lift can be asked for a spin."""
    if scene.air is None:
        raise ValueError("air: there is none, and nothing can move the ball")
    law: Any = scene.air.lift_coefficient
    name = law_name(law)
    if name not in _INVERTED or getattr(law, "of", "spin_parameter") != "spin_parameter":
        what = "a constant" if name == "constant" else f"a {name} of {law.of}"
        raise ValueError(
            f"air.lift_coefficient: {what} says nothing of the spin"
            f"{one_of('laws that do are', name, _INVERTED)}"
        )
    if scene.reading.spin_parameter == "total":
        raise ValueError(
            "reading.spin_parameter = total: its lift depends on the whole spin; take transverse"
        )
    return scene.air


def _spin_parameter(air: Air, lift: Array) -> tuple[Array, float]:
    """Return S at values of |C_L|, NaN beyond what the law reaches; and that, with its sign."""
    # Each law solved for S at C_L: slope S; c0 S/(c1 + c2 S), which never gets beyond c0/c2; two
    # lines that meet at the node; a table, by its own straight lines.
    law: Any = air.lift_coefficient
    match law_name(law):
        case "linear":
            most = np.copysign(np.inf, law.slope)
            return lift / abs(law.slope) if law.slope else np.where(lift, np.nan, 0.0), most
        case "rational":
            most = law.numerator / law.slope if law.slope else np.copysign(np.inf, law.numerator)
            left = abs(law.numerator) - law.slope * lift
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.where(left > 0.0, law.constant * lift / left, np.nan), most
        case "bilinear":
            (node,), ((_, steep), (base, slope)) = law.lines(float)
            low = lift <= steep * node
            return np.where(low, lift / steep, (lift - base) / slope), np.inf
    at, values = np.array(law.at), np.array(law.values)
    if at[0] != 0.0 or values[0] != 0.0 or not np.all(np.diff(np.abs(values)) > 0.0):
        raise ValueError(
            "air.lift_coefficient: to be asked for a spin a table must begin with 0 at 0 and rise, "
            "or fall, all the way"
        )
    inside = np.where(lift <= abs(values[-1]), lift, np.nan)
    return np.interp(inside, np.abs(values), at), float(values[-1])
