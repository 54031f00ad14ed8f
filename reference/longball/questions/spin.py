"""The spin that a pitch needs for its movement, by the scene's own law of lift.

With the velocity v and the acceleration a at a point of the pitch, u the velocity through the air,

    a_D = -(a + g e_z)·û,   a_M = a + g e_z + a_D û,   C_L = |a_M| / (k U²),   k = ρ A / (2 m),

and the law of C_L, solved for S = R ω_T / U, gives the spin ω_T perpendicular to the path (Nathan,
Am. J. Phys. 76, 119 (2008), for the spin parameter S).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import root

from longball.api import scene_of_kind
from longball.engines.engine import CannotSolve
from longball.model.air import Air, law_name
from longball.model.arrays import Array
from longball.model.law import per_metre
from longball.model.names import one_of
from longball.model.numbers import DOUBLES, part_across
from longball.model.scene import AtBatScene, PitchScene
from longball.pitches.models import FlightModel
from longball.pitches.statcast import MeasuredPitches, time_of_plane
from longball.questions.movement import Movement, movement, vectors
from longball.solution import real_numbers

# Rounding allowed above a share of 1: for a ball with active spin alone, the law and its inverse
# give 1 to 1e-13.
_ROUNDING = 1e-12

# Largest error of a movement, m; the search leaves 1e-14 by rounding.
_MISSED = 1e-9  # a free choice

# Laws of lift that depend on the spin parameter, so that they can be solved for it.
_INVERTED = ("rational", "linear", "bilinear", "table")


@dataclass(frozen=True)
class SpinFromMovement:
    """Spin that causes a movement; arrays have one number for each pitch.

    Attributes
    ----------
    transverse
        Spin perpendicular to the velocity through the air, rad/s, shape (…, 3).
    drag_coefficient, lift_coefficient
        C_D and C_L, shape (…).
    active_share
        Transverse spin relative to the measured rate, shape (…); None without a rate. Above 1, the
        whole spin cannot cause the movement: it has another cause, or the rate is wrong.
    spin
        Whole spin, including the component along the velocity, rad/s, shape (…, 3); NaN if the
        share is above 1, None without a rate.
    above_one
        True if the share is above 1, shape (…); None without a rate.
    reasons
        Reasons why pitches have no spin, by their index.
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
        """Size of the transverse spin, rad/s, shape (…)."""
        return np.linalg.norm(self.transverse, axis=-1)[()]


def spin_from_movement(
    scene: object,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    rate: ArrayLike | None = None,
    gyro: ArrayLike = 1.0,
    height: float = 0.0,
) -> SpinFromMovement:
    """Compute the spin that causes a pitch's acceleration perpendicular to its path.

    Parameters
    ----------
    scene
        A pitch or an at-bat, as `solve` takes it. Its ball, air, gravity and law of lift are used,
        and its side force is subtracted; a mapping can omit the spin. The law of lift must depend
        on the spin parameter: rational, linear, bilinear, or a table.
    velocity, acceleration
        At one point of the pitch, m/s and m/s², shape (…, 3). With nine parameters, use the middle
        of the path, where the acceleration is closest to its mean.
    rate
        Measured size of the whole spin, rad/s, shape (…). It is needed for the active share.
    gyro
        Sign of the spin along the velocity, shape (…): 1 along it, -1 against it.
    height
        Height of the point, m, for a wind or a density that depends on it.

    Raises
    ------
    InvalidScene
        If `scene` is invalid, or neither a pitch nor an at-bat.
    ValueError
        If the law of lift cannot be solved for the spin, or, for a single pitch, never reaches its
        C_L. In arrays, such a row is NaN and has an entry in `reasons`.

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
    asked: PitchScene | AtBatScene = scene_of_kind(_with_spin(scene), PitchScene, AtBatScene)
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
    # Without gravity, the component along the velocity is drag, and the rest is lift (a_D and a_M
    # of the module's docstring).
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
    # ω_T = S U/R, along û × (direction of the force); a negative law reverses it.
    size = spin_parameter * speed / asked.ball.radius
    unit = moving / np.where(force > 0.0, force, 1.0)[..., None]
    transverse = sense * size[..., None] * np.cross(ahead, unit)
    reasons = {int(i): message.format(lift.flat[i]) for i in np.flatnonzero(beyond)}
    if rate is None:
        return SpinFromMovement(transverse, drag[()], lift[()], reasons=reasons)
    whole = real_numbers("rate", rate)
    if not (whole > 0.0).all():
        raise ValueError(f"rate = {rate!r}: spins must be positive, rad/s")
    # Spin along the velocity causes no force: ω² = ω_T² + ω_along² gives its size, not its sign.
    share = size / whole
    above = share > 1.0 + _ROUNDING
    along = np.sqrt(np.where(above, np.nan, np.maximum(whole**2 - size**2, 0.0)))
    spin = transverse + (np.sign(gyro) * along)[..., None] * ahead
    return SpinFromMovement(transverse, drag[()], lift[()], share[()], spin, above[()], reasons)


def _with_spin(scene: object) -> object:
    """Return a scene; a mapping can omit the spin, which is the unknown."""
    if not (isinstance(scene, Mapping) and scene.get("kind") in ("pitch", "at-bat")):
        return scene
    # Scenes with a law of the spin are rejected without one.
    pitch = scene.get("pitch", {})
    spun = {"spin": [0.0, 0.0, 0.0], **pitch} if isinstance(pitch, Mapping) else pitch
    return {**scene, "pitch": spun}


def spin_for(
    scene: object, moved: Movement, since: float | None = None, **options: Any
) -> PitchScene:
    """Compute the transverse spin that causes a given movement.

    Parameters
    ----------
    scene
        A pitch, as `solve` takes it. The part of its spin along the velocity is kept.
    moved
        Movement relative to a flight under gravity alone, m; see `movement`.
    since
        Plane from which the movement counts, x in m; by default the release.
    options
        ``engine=`` and its options, as `solve` takes them.

    Returns
    -------
    PitchScene
        The pitch with that spin: ``.pitch.spin``, rad/s.

    Raises
    ------
    InvalidScene
        If `scene` is not a pitch.
    ValueError
        If its law of lift cannot be inverted, or no spin causes so large a movement.
    CannotSolve
        If the search does not converge.

    Examples
    --------
    >>> import longball as lb
    >>> air = {"lift_coefficient": {"law": "rational"}, "drag_coefficient": 0.35}
    >>> pitch = {"kind": "pitch", "pitch": {"speed": 42.0}, "air": air}
    >>> moving = lb.spin_for(pitch, lb.Movement(across=0.2, up=0.4))
    >>> [round(x) for x in moving.pitch.spin]
    [0, 88, -49]
    """
    asked: PitchScene = scene_of_kind(_with_spin(scene), PitchScene)
    if not isinstance(moved, Movement):
        raise TypeError(f"moved = {moved!r}: a movement is needed, lb.Movement(across=…, up=…), m")
    ahead = np.array(asked.pitch.thrown)
    ahead /= np.linalg.norm(ahead)
    up = np.array([0.0, 0.0, 1.0]) - ahead[2] * ahead
    up /= np.linalg.norm(up)
    # Lift is along ω × v, so a force along n needs a spin along v × n: for n up, and n to the left.
    axes = np.stack([np.cross(ahead, up), np.cross(ahead, np.cross(ahead, up))])
    kept = ahead * (ahead @ np.array(asked.pitch.spin or (0.0, 0.0, 0.0)))

    def thrown(parts: Array) -> PitchScene:
        return asked.replace(**{"pitch.spin": (kept + parts @ axes).tolist()})

    def off(parts: Array) -> list[float]:
        reached = movement(thrown(parts), since=since, **options)
        return [reached.up - moved.up, reached.across - moved.across]

    # Start with the spin for a constant acceleration; it raises if no spin causes the movement. The
    # mean speed is about 0.95 of that at the release: drag takes a tenth on the whole path.
    far = asked.pitch.release[0] if since is None else since
    time = far / (0.95 * abs(asked.pitch.thrown[0]))
    push = 2.0 * np.array([0.0, moved.across, moved.up]) / time**2
    gravity = np.array([0.0, 0.0, -asked.gravity])
    start = spin_from_movement(asked, asked.pitch.thrown, push + gravity).transverse
    solution = root(off, axes @ start, tol=1e-12)
    missed = math.hypot(*off(solution.x))
    if not missed <= _MISSED:
        raise CannotSolve(
            f"no spin causes that movement: the nearest one misses it by {missed:.2g} m"
        )
    return thrown(solution.x)


def measured_spin(pitches: MeasuredPitches, model: FlightModel) -> dict[str, Array]:
    """Compute the spin that causes the movement of measured pitches, in the middle of their paths.

    Parameters
    ----------
    pitches
        As `longball.pitches.statcast.read_measured` returns them, with their spin.
    model
        Model whose law of lift is inverted, in the weather of each game.

    Returns
    -------
    dict of str to array
        ``drag_coefficient``, ``lift_coefficient``, ``transverse`` (rad/s, NaN if the law does not
        reach the lift) and ``active_share`` of the measured rate.
    """
    speed, push = pitches.velocity[:, 0], pitches.acceleration[:, 0]
    half = 0.5 * time_of_plane(speed, push, -pitches.release[:, 0])
    middle = pitches.velocity + pitches.acceleration * half[:, None]
    # One scene for each weather: a day has about fifteen games and thousands of pitches.
    names = "drag_coefficient", "lift_coefficient", "transverse", "active_share"
    columns = np.empty((len(names), len(pitches)))
    weathers = np.stack([pitches.temperature, pitches.elevation], axis=1)
    for weather in np.unique(weathers, axis=0):
        here = (weathers == weather).all(axis=1)
        scene = {"kind": "pitch"} | model.blocks(*weather.tolist())
        spin = spin_from_movement(
            scene, middle[here], pitches.acceleration[here], rate=pitches.spin_rate[here]
        )
        parts = spin.drag_coefficient, spin.lift_coefficient, spin.rate, spin.active_share
        columns[:, here] = parts
    return dict(zip(names, columns, strict=True))


def _air_of(scene: PitchScene | AtBatScene) -> Air:
    """Return the air of a scene; raise if its law of lift cannot be solved for the spin."""
    if scene.air is None:
        raise ValueError("air: there is none, and nothing can move the ball")
    law: Any = scene.air.lift_coefficient
    name = law_name(law)
    if name not in _INVERTED or getattr(law, "of", "spin_parameter") != "spin_parameter":
        what = "a constant" if name == "constant" else f"a {name} of {law.of}"
        raise ValueError(
            f"air.lift_coefficient: {what} does not depend on the spin"
            f"{one_of('laws that do are', name, _INVERTED)}"
        )
    if scene.reading.spin_parameter == "total":
        raise ValueError(
            "reading.spin_parameter = total: its lift depends on the whole spin; take transverse"
        )
    return scene.air


def _spin_parameter(air: Air, lift: Array) -> tuple[Array, float]:
    """Return S at values of |C_L|, NaN beyond the law's limit, and the limit with its sign."""
    # The laws of docs/model.md solved for S: linear, a S; rational, c2 S/(c0 + c1 S), whose limit
    # is c2/c1; bilinear, two lines that meet at the node; a table, linear between its nodes.
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
            "air.lift_coefficient: a table must begin with 0 at 0 and always rise, or always fall, "
            "to be solved for the spin"
        )
    inside = np.where(lift <= abs(values[-1]), lift, np.nan)
    return np.interp(inside, np.abs(values), at), float(values[-1])
