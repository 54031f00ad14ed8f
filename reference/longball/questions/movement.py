"""Pitches as trackers publish them: nine parameters, and movement.

Trackers fit a constant acceleration to a pitch and publish nine numbers: position, velocity and
acceleration at one plane. Here they are in the frame of scenes, in SI units, with x = 0 at the
front of the plate, as in `longball.pitches.statcast`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from longball import engines
from longball.api import scene_of_kind, solve
from longball.model.arrays import Array
from longball.model.scene import Pitch, PitchScene
from longball.pitches.models import STANDARD_GRAVITY
from longball.pitches.statcast import FIT_PLANE, FOOT, PLATE_FRONT, MeasuredPitches, time_of_plane
from longball.solution import Path, Solution, real_numbers

Vector = tuple[float, float, float]

# x, m, of the plane at which trackers give the parameters (50 ft from the tip of the plate), and of
# the plane from which pfx counts (40 ft).
TRACKED, PFX = FIT_PLANE - PLATE_FRONT, 40.0 * FOOT - PLATE_FRONT

# Nodes of the Gauss-Legendre rule for the mean square over a pitch. The path is analytic: 12 nodes
# give the same parameters to 1e-12 on the shipped day of pitches.
_NODES = 16


@dataclass(frozen=True)
class NineParameters:
    """State and acceleration of a pitch at one moment; the acceleration is constant.

    Attributes
    ----------
    position
        m, ``[x, y, z]``.
    velocity
        m/s.
    acceleration
        m/s².
    residual
        Root mean square distance from the fitted path, m; 0 if nothing was fitted.

    Examples
    --------
    >>> from scipy.constants import foot
    >>> import longball as lb
    >>> tracked = lb.NineParameters(
    ...     position=(48.58 * foot, 0.5, 1.8), velocity=(-41, -1, -1.5), acceleration=(8, -2, -5)
    ... )
    >>> scene = lb.Pitch(pitch=tracked.pitch(release=16.8))
    >>> [round(v, 2) for v in scene.pitch.velocity]
    [-41.39, -0.9, -1.26]
    """

    position: Vector
    velocity: Vector
    acceleration: Vector
    residual: float = 0.0

    def __post_init__(self) -> None:
        for name in ("position", "velocity", "acceleration"):
            value = getattr(self, name)
            if vectors(name, value).ndim != 1:
                raise ValueError(f"{name} = {value!r}: one vector [x, y, z] is needed")

    def at(self, x: float) -> NineParameters:
        """Return the parameters at the plane x, m, on the flight to the plate.

        Raises
        ------
        ValueError
            If the ball never reaches the plane, because the deceleration turns it round.
        """
        # v² = v0² + 2 a d is negative beyond the point where the ball turns round.
        distance, speed, push = x - self.position[0], self.velocity[0], self.acceleration[0]
        square = speed * speed + 2.0 * push * distance
        if not (speed < 0.0 and square >= 0.0):
            turn = self.position[0] - speed**2 / (2.0 * push) if push > 0.0 else None
            turns = "" if turn is None else f"; it turns at x = {turn:.6g} m"
            raise ValueError(
                f"the pitch of these nine parameters never reaches x = {x} m on its flight to the "
                f"plate: velocity[0] = {speed} m/s, acceleration[0] = {push} m/s²{turns}"
            )
        time = float(time_of_plane(speed, push, distance))
        parts = [*zip(self.position, self.velocity, self.acceleration, strict=True)]
        _, y, z = (r + (v + 0.5 * a * time) * time for r, v, a in parts)
        u, v, w = (v + a * time for _, v, a in parts)
        return NineParameters((x, y, z), (u, v, w), self.acceleration, self.residual)

    def pitch(self, release: float) -> Pitch:
        """Return the `pitch` block of a scene released at x, m; see `at`."""
        self.at(0.0)  # or it is no pitch: the acceleration turns it round before the plate
        start = self.at(release)
        return Pitch(release=start.position, velocity=start.velocity)

    @property
    def approach(self) -> tuple[float, float]:
        """Vertical and horizontal approach angle, rad; see `result.Approach`."""
        u, v, w = self.velocity
        return math.atan2(w, math.hypot(u, v)), math.atan2(v, -u)


def nine_parameters(path: Path | Solution, at: float = TRACKED) -> NineParameters:
    """Fit a constant acceleration to a pitch, as trackers do.

    The fit minimises the squared distance from the path, averaged over the time from the release to
    the plate. It is not a Taylor polynomial at one point.

    Parameters
    ----------
    path
        Path or solution of a pitch, or solution of an at-bat, whose pitch ends at the plate.
    at
        Plane at which the parameters are given, x in m; by default 50 ft from the plate's tip.

    Raises
    ------
    ValueError
        If the pitch does not reach the plate, or the fit does not reach that plane.
    TypeError
        If `path` is neither a path nor a solution.

    Examples
    --------
    >>> import longball as lb
    >>> result = lb.solve(lb.Pitch(pitch={"release": [16.5, 0.6, 1.8]}))
    >>> fitted = lb.nine_parameters(result)
    >>> [round(a, 2) for a in fitted.acceleration], f"{1000 * fitted.residual:.1f} mm"
    ([8.86, 0.32, -4.99], '1.8 mm')
    """
    trajectory, end = _pitch_of(path)
    nodes, weights = leggauss(_NODES)
    half = 0.5 * (end - trajectory.start)
    places = trajectory.at(trajectory.start + half * (1.0 + nodes)).position
    # r(t) = r + v t + a t²/2, with t from the middle of the pitch; the rule's weights add up to 2.
    time, mean = half * nodes, np.sqrt(0.5 * weights)[:, None]
    basis = np.stack([np.ones_like(time), time, 0.5 * time**2], axis=1)
    fitted, squares, *_ = np.linalg.lstsq(mean * basis, mean * places)
    position, velocity, acceleration = map(_vector, fitted)
    middle = NineParameters(position, velocity, acceleration, math.sqrt(squares.sum()))
    return middle.at(at)


def _pitch_of(path: Path | Solution) -> tuple[Path, float]:
    """Return a path, and the time at which its pitch reaches the plate, s."""
    if isinstance(path, Solution):
        if path.plate is None:
            raise ValueError(f"the pitch does not reach the plate: it is {path.outcome}")
        return path.path, float(path.plate.time)
    if not isinstance(path, Path):
        raise TypeError(
            f"path: the path or the solution of a pitch is needed; not a {type(path).__name__}"
        )
    # The path of a pitch ends at x = 0 to rounding; if it lands first, it ends centimetres before.
    if path.at(path.end).position[0] > 1e-6:
        raise ValueError(f"the pitch does not reach the plate: its path ends at {path.end:.6g} s")
    return path, path.end


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def vectors(name: str, value: ArrayLike) -> Array:
    """Return vectors as an array of shape (…, 3); a ValueError names an invalid argument."""
    array = real_numbers(name, value)
    if array.shape[-1:] != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{name} = {value!r}: a vector [x, y, z] of finite numbers is needed")
    return array


@dataclass(frozen=True)
class Movement:
    """Movement of a pitch: its deflection by the air across its path, at the plate.

    Attributes
    ----------
    across, up
        m, to the catcher's left and up.
    clock
        Direction on a clock as the pitcher sees it, such as ``"12:00"`` for straight up; empty if
        there is no movement.
    """

    across: float
    up: float

    @property
    def clock(self) -> str:
        """See `Movement`. It is also the spin's direction if the whole spin is active."""
        return clock(self.across, self.up)


def clock(across: float, up: float) -> str:
    """Return a direction on a clock as the pitcher sees it, to a minute; "" for no direction.

    Backspin, which lifts a ball, is 12:00; a movement to the pitcher's right, which is the
    catcher's left, 3:00.

    Examples
    --------
    >>> import longball as lb
    >>> lb.clock(0.0, 0.4), lb.clock(0.2, 0.2), lb.clock(0.0, -0.3)
    ('12:00', '1:30', '6:00')
    """
    if across == up == 0.0:
        return ""
    # Twelve hours are 2π, clockwise from 12:00; the catcher's left is the pitcher's right.
    minutes = round(math.atan2(across, up) * 360.0 / math.pi) % 720
    return f"{minutes // 60 or 12}:{minutes % 60:02}"


def movement(
    scene: object,
    without: Literal["air", "lift"] = "air",
    since: float | None = None,
    **options: Any,
) -> Movement:
    """Compare a pitch with the same pitch without air, or without lift.

    Parameters
    ----------
    scene
        A pitch, as `solve` takes it.
    without
        ``"air"``: compared with gravity alone, at the time of crossing the plate; from 40 ft on
        this is pfx. ``"lift"``: compared with the same ball under gravity and drag, where each
        crosses the plate; from the release on this is the induced break.
    since
        Plane from which the two paths separate, x in m; by default the release. The constant
        `longball.questions.movement.PFX` is 40 ft from the plate's tip, 11.76 m from its front.
    options
        ``engine=`` and its options, as `solve` takes them.

    Raises
    ------
    InvalidScene
        If `scene` is not a pitch.
    ValueError
        If the pitch does not reach the plate, or is released between `since` and the plate.

    Examples
    --------
    >>> import longball as lb
    >>> fastball = lb.Pitch(
    ...     pitch={"release": [16.5, 0.6, 1.8], "velocity": [-42, -1, -1], "spin": [0, 200, -60]},
    ...     air={"lift_coefficient": {"law": "rational"}},
    ... )
    >>> lb.movement(fastball).clock
    '12:35'
    """
    asked: PitchScene = scene_of_kind(scene, PitchScene)
    if without not in ("air", "lift"):
        raise ValueError(f"without must be 'air' or 'lift' (got {without!r})")
    result = solve(asked, **options)
    trajectory, end = _pitch_of(result)
    begin = trajectory.start
    if since is not None:
        x = engines.of_type(float, "since", since)
        release = trajectory.at(begin).position[0]
        if not release >= x > 0.0:
            raise ValueError(f"since = {x} m: the pitch is released at x = {release} m")
        begin = float(brentq(lambda t: trajectory.at(t).position[0] - x, begin, end, xtol=1e-15))
    _, place, velocity = trajectory.at(begin)
    crossed = trajectory.at(end).position
    if without == "air":
        left = end - begin
        free = place + velocity * left - [0.0, 0.0, 0.5 * asked.gravity * left**2]
        across, up = (crossed - free)[1:].tolist()
        return Movement(across, up)
    # The pitch without lift keeps its spin, because drag may depend on it.
    # Where the paths separate, the comparison starts with the state of the real pitch.
    thrown = {"release": place, "velocity": velocity, "spin": asked.pitch.spin}
    across = {"air.lift_coefficient": 0.0, "air.side_coefficient": None} if asked.air else {}
    straight = asked.replace(pitch={k: x for k, x in thrown.items() if x is not None}, **across)
    solved = solve(straight, **options)
    if solved.plate is None:
        raise ValueError(f"without lift the pitch does not reach the plate: it is {solved.outcome}")
    across, up = (crossed - np.array([*map(float, solved.plate.position)]))[1:].tolist()
    return Movement(across, up)


def measured_movement(pitches: MeasuredPitches, since: float | None = None) -> dict[str, Array]:
    """Compare measured pitches with flights under gravity alone.

    Parameters
    ----------
    pitches
        As `longball.pitches.statcast.read_measured` returns them. Only their nine parameters
        matter.
    since
        Plane from which the two paths separate, x in m; by default the release. See `movement`.

    Returns
    -------
    dict of str to array
        ``across`` and ``up``, m, and the approach angles at the plate, ``vertical`` and
        ``horizontal``, rad; one number for each pitch.
    """
    speed, push, release = pitches.velocity[:, 0], pitches.acceleration[:, 0], pitches.release[:, 0]
    begin = 0.0 if since is None else time_of_plane(speed, push, since - release)
    end = time_of_plane(speed, push, -release)
    # With a constant acceleration a, the deflection from gravity alone is (a + g e_z) t²/2.
    _, push_across, push_up = pitches.acceleration.T
    half_square = 0.5 * (end - begin) ** 2
    across, up = half_square * push_across, half_square * (push_up + STANDARD_GRAVITY)
    u, v, w = pitches.velocity.T + end * pitches.acceleration.T
    angles = {"vertical": np.arctan2(w, np.hypot(u, v)), "horizontal": np.arctan2(v, -u)}
    return {"across": across, "up": up} | angles
