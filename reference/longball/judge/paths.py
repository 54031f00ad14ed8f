"""Answers that are points: judged at their own times, and landed by longball.

A simulator that returns the way of its ball, and no landing, answers with ``path``. Its points are
held against the true path as they are. The landing, or the plate of a pitch, is found on a
polynomial through the eight next to it; velocities, if there are some, have one of their own, since
many integrators have others than the slope of their places, or make one polynomial with the places
of four, where that agrees better with one of three.
A ball that its points leave in the air at the scene's time limit is airborne, and a pitch that they
bring to the ground before the plate is grounded.
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

POINTS = 8, 6  # numbers that a polynomial at a crossing goes through: their difference is the doubt
MOST_JUDGED = 2_000  # points, evenly chosen


def worst_points(scene: Any, path: Array) -> dict[str, tuple[Value, Value]]:
    """Return the worst point, and the worst velocity, each beside the truth at its time."""
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
    """Return an answer with what its points say of the landing or the plate, where it does not.

    Also how far interpolation may be off, by quantity, in its unit.
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
        # A step on, but for the rounding of times.
        in_the_air = 2 * path[-1, 0] - path[-2, 0] > limit * (1 - 1e-9)
        return (ended("airborne") if in_the_air else answer), {}
    # Places and velocities may make one polynomial; both are tried where that can be seen.
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


MANY = 10  # decimals of places that are doubles: more than of places in nanometres


def as_written(scene: Any, answer: Answer) -> Answer:
    """Return an answer with what its points say, to as many decimals as their places are written.

    So that what rounding has done to them is not taken for something else.
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
    """Return the number of the point behind the crossing; of the last, if it is a step away."""
    fallen = np.flatnonzero((heights[1:] <= 0) & (heights[:-1] > 0))
    if fallen.size:
        return int(fallen[0]) + 1
    return len(heights) - 1 if 2 * heights[-1] - heights[-2] <= 0 else None


def _met(
    path: Array, crossing: int, order: int, together: bool, axis: int, level: float
) -> Met | None:
    """Return when and where a polynomial through `order` numbers by a crossing is at a level."""
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

    if height(after) > 0:  # the path ends above the ground: at most one step goes on
        before, after = after, after + (after - before)
    if not height(before) >= 0 >= height(after):
        return None
    time = brentq(height, before, after, xtol=1e-15)
    position = curve(time)
    position[axis] = level
    return {"time": np.array([start + time]), "position": position, "velocity": velocity_at(time)}


def _value(numbers: Array) -> Value:
    return tuple(Decimal(repr(float(x))) for x in np.atleast_1d(numbers))
