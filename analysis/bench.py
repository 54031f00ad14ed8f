"""How fast the batch engine is, next to its peers: ratios, measured side by side.

``python -m analysis.bench`` takes less than three minutes. Each contender flies the same launches
of batted balls to the ground, on one thread, in turns: what the machine does besides then slows all
of them alike, and the medians of the turns are compared. Compiling is done before. The error is
that of the landing's place, against a solution by mpmath in 25 digits.

A peer that is not installed is left out: heyoka (``pip install heyoka``).
"""

from __future__ import annotations

import math
import platform
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import scipy.integrate
from numpy.typing import NDArray

from longball.engines.batch import Batch, solve_columns
from longball.home_run import draw, paper_at_bats
from longball.model.motion import Forces, forces
from longball.model.numbers import DOUBLES
from longball.model.scene import AtBatScene, FlightScene, Launch

Array = NDArray[np.float64]

TURNS = 15
LAUNCHES = 20_000
TRUE_LAUNCHES = 8  # of which the landing is known in 25 digits; a second each
HEIGHT = 1.0  # m, of the launches

_SCENE = FlightScene(
    id="bench", launch=Launch(position=(0.0, 0.0, HEIGHT), velocity=(30.0, 0.0, 30.0))
)


@dataclass(frozen=True)
class Contender:
    """Someone who can fly launches to the ground.

    Attributes
    ----------
    name
        As printed.
    land
        Takes velocities u and w, m/s, arrays of shape (n,); returns the distances, m.
    launches
        How many a turn; a slow contender gets fewer.
    """

    name: str
    land: Callable[[Array, Array], Array]
    launches: int


def launches(count: int) -> tuple[Array, Array]:
    """Return velocities u and w, m/s, of batted balls: line drives to high flies."""
    rng = np.random.default_rng(1)
    speed, rise = rng.uniform(25.0, 50.0, count), np.radians(rng.uniform(5.0, 60.0, count))
    return speed * np.cos(rise), speed * np.sin(rise)


# --- the contenders -------------------------------------------------------------------------------


def batch(tolerance: float) -> Contender:
    """Return the batch engine, as one calls it: columns of scenes."""
    engine = Batch(tolerance)

    def land(u: Array, w: Array) -> Array:
        columns = {"launch.velocity.0": u, "launch.velocity.2": w}
        return solve_columns(_SCENE, columns, engine)["landing.distance"]

    return Contender(f"longball batch, tolerance {tolerance:g} m", land, LAUNCHES)


def whole_at_bats() -> Contender:
    """Return the batch engine on at-bats of the paper's distributions, instead of flights."""
    scene = AtBatScene(id="bench")
    samples = draw(paper_at_bats(scene.reading), LAUNCHES, seed=1)
    columns = {
        "pitch.speed": samples.speed,
        "pitch.aim.0": samples.aim,
        "swing.height_offset": samples.offset,
        "swing.tilt": samples.tilt,
    }

    def solve(u: Array, w: Array) -> Array:
        return solve_columns(scene, columns)["landing.distance"]

    return Contender("longball batch, whole at-bats", solve, LAUNCHES)


def dop853(rtol: float) -> Contender:
    """Return scipy's DOP853 with a terminal event, as its manual shows it."""
    field = _field()
    drag, lift, gravity = field.drag or 0.0, field.lift or 0.0, field.gravity or 0.0

    def motion(_: float, y: Array) -> tuple[float, ...]:
        _, _, u, w = y.tolist()
        speed = math.sqrt(u * u + w * w)
        return (
            u,
            w,
            -speed * (drag * u + lift * w),
            -speed * (drag * w - lift * u) - gravity,
        )

    def ground(_: float, y: Array) -> float:
        return float(y[1])

    ground.terminal = True  # type: ignore[attr-defined]
    ground.direction = -1  # type: ignore[attr-defined]

    def land(u: Array, w: Array) -> Array:
        ends = [
            scipy.integrate.solve_ivp(
                motion,
                (0.0, 60.0),
                (0.0, HEIGHT, ui, wi),
                method="DOP853",
                rtol=rtol,
                atol=rtol,
                events=ground,
            ).y_events[0][0][0]
            for ui, wi in zip(u.tolist(), w.tolist(), strict=True)
        ]
        return np.array(ends)

    return Contender(f"scipy DOP853, rtol {rtol:g}", land, 60)


def heyoka() -> Contender:
    """Return heyoka's adaptive Taylor integrator: scalar, default tolerance, its own event."""
    hy: Any = import_module("heyoka")
    field = _field()
    s, z, u, w = hy.make_vars("s", "z", "u", "w")
    speed = hy.sqrt(u * u + w * w)
    integrator = hy.taylor_adaptive(
        [
            (s, u),
            (z, w),
            (u, -speed * (field.drag * u + field.lift * w)),
            (w, -speed * (field.drag * w - field.lift * u) - field.gravity),
        ],
        [0.0, HEIGHT, 1.0, 1.0],
        t_events=[hy.t_event(z, direction=hy.event_direction.negative)],
    )

    def land(us: Array, ws: Array) -> Array:
        ends = np.empty(len(us))
        for i in range(len(us)):
            integrator.time = 0.0
            integrator.reset_cooldowns()
            integrator.state[:] = (0.0, HEIGHT, us[i], ws[i])
            integrator.propagate_until(60.0)
            ends[i] = integrator.state[0]
        return ends

    return Contender("heyoka, scalar, default tolerance", land, 2000)


def contenders() -> Iterator[Contender]:
    """Yield the flyers of single flights that are installed, the measure of all first."""
    yield batch(1e-13)
    yield batch(1e-8)
    yield dop853(1e-12)
    try:
        yield heyoka()
    except ImportError:
        print("heyoka is not installed: left out")


def _field() -> Forces[float]:
    return forces(_SCENE.ball, _SCENE.air, _SCENE.gravity, False, DOUBLES)


# --- measuring ------------------------------------------------------------------------------------


def truth(count: int) -> list[float]:
    """Return the distances of the first launches, m, from mpmath in 25 digits."""
    field = _field()
    found = []
    with mpmath.workdps(25):

        def motion(_: Any, y: Any) -> list[Any]:
            speed = mpmath.hypot(y[2], y[3])
            return [
                y[2],
                y[3],
                -speed * (field.drag * y[2] + field.lift * y[3]),
                -speed * (field.drag * y[3] - field.lift * y[2]) - field.gravity,
            ]

        u, w = launches(LAUNCHES)
        for i in range(count):
            start = [mpmath.mpf(x) for x in (0.0, HEIGHT, u[i], w[i])]
            state = mpmath.odefun(motion, 0, start, tol=1e-20)
            time = mpmath.mpf(_landing_time(u[i], w[i]))
            for _ in range(3):  # Newton's method, from 14 digits
                _, z, _, w_end = state(time)
                time -= z / w_end
            found.append(float(state(time)[0]))
    return found


def _landing_time(u: float, w: float) -> float:
    columns = {"launch.velocity.0": [u], "launch.velocity.2": [w]}
    return float(solve_columns(_SCENE, columns)["landing.time"][0])


def microseconds(entrants: list[Contender], turns: int) -> dict[str, list[float]]:
    """Return the times of each contender's turns, µs a launch; the turns alternate."""
    u, w = launches(LAUNCHES)
    for entrant in entrants:  # compile, and fill caches
        entrant.land(u[: entrant.launches], w[: entrant.launches])
    times: dict[str, list[float]] = {entrant.name: [] for entrant in entrants}
    for _ in range(turns):
        for entrant in entrants:
            n = entrant.launches
            begin = time.perf_counter()
            entrant.land(u[:n], w[:n])
            times[entrant.name].append((time.perf_counter() - begin) / n * 1e6)
    return times


def machine() -> str:
    """Describe the processor and the versions of what is compared."""
    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        names = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].partition(":")[2].strip() if names else processor
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "scipy", "numba", "heyoka"):
        try:
            versions.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return f"{processor}; {', '.join(versions)}"


def main() -> None:
    """Measure, and print a table."""
    flyers = list(contenders())
    at_bats = whole_at_bats()
    times = microseconds([*flyers, at_bats], TURNS)
    true = truth(TRUE_LAUNCHES)
    u, w = (v[:TRUE_LAUNCHES] for v in launches(LAUNCHES))
    measure = times[flyers[0].name]
    print(machine())
    print(f"{'':42} µs each    ratio   max error, m")
    for entrant in [*flyers, at_bats]:
        mine = times[entrant.name]
        # The ratio of each turn, so that a slow moment counts on both sides.
        ratio = statistics.median(a / b for a, b in zip(mine, measure, strict=True))
        error = ""
        if entrant is not at_bats:
            error = f"{np.abs(entrant.land(u, w) - true).max():.1e}"
        print(f"{entrant.name:42} {statistics.median(mine):7.2f} {ratio:8.2f}   {error}")


if __name__ == "__main__":
    main()
