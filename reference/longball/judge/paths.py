"""Answers that are points of a path: judged at their times, and completed with a landing.

A simulator that returns the path of its ball, and no landing, answers with ``path``. Its points are
compared with the true path at their times. The landing, or the crossing of the plate, is the root
of a polynomial through the eight nearest points. Velocities have a separate polynomial, because
those of many integrators are not the derivatives of their positions; or one polynomial fits
positions and velocities of four points, if it agrees better with that of three points.

A ball is airborne if its points end in the air at the scene's time limit. A pitch is grounded if
its points reach the ground before the plate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from typing import Any

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.optimize import brentq

from longball.engines.chain import solve_with_path
from longball.engines.ivp import Ivp
from longball.judge.answers import Answer
from longball.judge.quantities import Value
from longball.model.arrays import Array
from longball.model.result import Outcome
from longball.model.scene import ImpactScene, landing_height

Met = dict[str, Array]

# Numbers that the polynomials at a crossing interpolate. The difference of the two polynomials
# estimates the error of the interpolation, which is added to the tolerance.
POINTS = 8, 6
MOST_JUDGED = 2_000  # points, evenly chosen


def worst_points(scene: Any, path: Array) -> dict[str, tuple[Value, Value]]:
    """Return the true and the given value of the worst point and of the worst velocity."""
    if isinstance(scene, ImpactScene):
        return {}
    _, truth = solve_with_path(scene, Ivp())
    if not truth.legs:
        return {}
    inside = path[(path[:, 0] >= 0) & (path[:, 0] <= float(truth.end))]
    if len(inside) > MOST_JUDGED:
        inside = inside[np.linspace(0, len(inside) - 1, MOST_JUDGED).astype(int)]
    if not len(inside):
        return {}
    true: Any = np.array(truth.sample(inside[:, 0].tolist()))
    found = {}
    for name, at in (("path.position", 0), ("path.velocity", 3)):
        given, right = inside[:, 1 + at : 4 + at], true[:, at : 3 + at]
        if given.shape[1] == 3:
            worst = int(np.linalg.norm(given - right, axis=1).argmax())
            found[name] = _value(right[worst]), _value(given[worst])
    return found


def landed(scene: Any, answer: Answer) -> tuple[Answer, Mapping[str, float]]:
    """Return an answer, completed with the landing or the plate of its points.

    Quantities that the answer gives are unchanged. Return also the error of the interpolation by
    quantity, in its unit.
    """
    path = answer.path
    assert path is not None
    if isinstance(scene, ImpactScene):
        return answer, {}

    def ended(outcome: Outcome, **values: Any) -> Answer:
        """Return the answer with an outcome and values, unless it has them."""
        return replace(answer, outcome=answer.outcome or outcome, **values)

    floor, pitched = landing_height(scene), scene.kind == "pitch"
    block = "plate" if pitched else "landing"
    ground = _crossing(path[:, 3] - floor)
    crossing = _crossing(path[:, 1]) if pitched else ground
    begin = 0.0
    if not pitched and "contact.time" in answer.values:
        begin = float(answer.values["contact.time"][0])
    limit = begin + scene.time_limit
    if pitched and ground is not None and (crossing is None or ground < crossing):
        return ended("grounded"), {}
    if crossing is None:
        # If one more step would exceed the time limit, the points end in the air.
        in_the_air = 2 * path[-1, 0] - path[-2, 0] > limit * (1 - 1e-9)
        return (ended("airborne") if in_the_air else answer), {}
    # Try separate polynomials, and one for positions and velocities together, if there are enough
    # points.
    together = [False] if path.shape[1] == 4 or len(path) >= POINTS[0] else []
    together += [True] if path.shape[1] > 4 else []
    axis, level = (0, 0.0) if pitched else (2, floor)
    ways = [[_met(path, crossing, n, one, axis, level) for n in POINTS] for one in together]
    known = [(fine, coarse) for fine, coarse in ways if fine and coarse]
    if not known:
        return answer, {}
    fine, coarse = min(known, key=lambda way: _off(*way)["position"])
    if fine["time"][0] > limit:
        return ended("airborne"), {}
    if pitched and fine["position"][2] <= floor:  # in the same step
        return ended("grounded"), {}
    for met in (fine, coarse) if not pitched else ():
        met["distance"] = np.array([math.hypot(*met["position"][:2])])
        met["hang_time"] = met["time"] - begin
    values = {f"{block}.{name}": _value(x) for name, x in fine.items()} | dict(answer.values)
    outcomes: dict[str, Outcome] = {"flight": "landed", "pitch": "crossed", "at-bat": "batted"}
    slack = {f"{block}.{name}": off for name, off in _off(fine, coarse).items()}
    return ended(outcomes[scene.kind], values=values), slack


def _off(fine: Met, coarse: Met) -> dict[str, float]:
    return {name: float(np.linalg.norm(fine[name] - coarse[name])) for name in fine}


MANY = 10  # positions with so many decimals count as unrounded: nanometres have nine


def as_written(scene: Any, answer: Answer) -> Answer:
    """Return an answer completed from its points, with as many decimals as the positions have.

    The diagnosis then recognises rounded numbers (`diagnosis.digits`), and does not report their
    rounding as a mistake.
    """
    if answer.path is None:
        return answer
    whole, _ = landed(scene, answer)
    places = answer.path[:, 1:4]
    written = (d for d in range(MANY) if np.array_equal(places, np.round(places, d)))
    if (decimals := next(written, None)) is None:
        return whole
    values = {
        name: value if name in answer.values else tuple(round(x, decimals) for x in value)
        for name, value in whole.values.items()
    }
    return replace(whole, values=values)


def _crossing(heights: Array) -> int | None:
    """Return the index of the first point after the crossing.

    It is that of the last point if the crossing lies less than a step beyond it. None without a
    crossing.
    """
    fallen = np.flatnonzero((heights[1:] <= 0) & (heights[:-1] > 0))
    if fallen.size:
        return int(fallen[0]) + 1
    return len(heights) - 1 if 2 * heights[-1] - heights[-2] <= 0 else None


def _met(
    path: Array, crossing: int, order: int, together: bool, axis: int, level: float
) -> Met | None:
    """Return time, position and velocity where a polynomial at a crossing reaches a height.

    It interpolates `order` numbers: positions alone, or positions and velocities `together`.
    """
    # Use as many points before the crossing as after it, or the last ones of the path.
    count = order // 2 if together else order
    low = max(0, min(crossing - count // 2, len(path) - count))
    near = path[low : low + count]
    start = near[0, 0]
    times, places, speeds = near[:, 0] - start, near[:, 1:4], near[:, 4:7]
    if together:
        both = np.stack([places, speeds], axis=1).reshape(-1, 3)
        curve = KroghInterpolator(np.repeat(times, 2), both)
    else:
        curve = KroghInterpolator(times, places)
    apart = speeds.size and not together
    velocity_at = KroghInterpolator(times, speeds) if apart else curve.derivative
    before, after = path[crossing - 1 : crossing + 1, 0] - start

    def height(t: float) -> float:
        return float(curve(t)[axis]) - level

    if height(after) > 0:  # the path ends above the ground: extrapolate by at most one step
        before, after = after, after + (after - before)
    if not height(before) >= 0 >= height(after):
        return None
    time = brentq(height, before, after, xtol=1e-15)
    position = curve(time)
    position[axis] = level
    return {"time": np.array([start + time]), "position": position, "velocity": velocity_at(time)}


def _value(numbers: Array) -> Value:
    return tuple(Decimal(repr(float(x))) for x in np.atleast_1d(numbers))
