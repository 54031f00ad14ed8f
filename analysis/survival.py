"""Random survival: whatever scene the engines are given, each answers, rightly or with a reason.

What is right is said in the section. What doubles can attain is estimated here: the scene is solved
again, proven, with each of its inputs moved by a few roundings, and the bat by some of the place
where the flight begins; what they do adds up.
"""

import math
import time
from collections import defaultdict
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from analysis.random_scenes import random_scene
from analysis.stability import ALLOWED, exactly
from analysis.writing import Report
from longball.engines import create
from longball.engines.chain import solve, solve_with_path
from longball.engines.engine import CannotSolve
from longball.golden.case import ROUNDING, decisions
from longball.model.inputs import STEP, inputs, with_input
from longball.model.quantities import numbers, vector_of
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Scene

SCENES, FULL_SCENES = 2_000, 1_000_000
# Of the full number, those that the enclosure solves, too: every so many; of others all.
FULL_STRIDE = 100
SEED = 20
# How many scenes of a family there are in twenty. Those that are rarest take twenty times as long.
SHARES = {"baseball": 6, "wide": 6, "close": 6, "extreme": 1, "extended": 1}
BLOCK = 5  # such twenties

DIGITS = 20  # of the truth
# An error below so many roundings of its vector's length needs no estimate.
_FINE = 64
# Half ulps of the start of a flight by which a place w t further on is off where they cancel: of w,
# of t, of their product, and of the sum. With baseball's sizes this is less than `ALLOWED` grants.
_ROUNDINGS = 4

# Two engines agree on a number to so many roundings of its vector's length: 1e-11 of it.
_AGREE = 100_000

FAULTS = ("wrong outcome", "number off", "exception")
VERDICTS = ("right", "agree", "declined", "not compared", *FAULTS)


def run(report: Report, full: bool) -> str:
    """Solve the scenes and count what came of them."""
    count, stride = (FULL_SCENES, FULL_STRIDE) if full else (SCENES, 1)
    blocks = range(count // (BLOCK * sum(SHARES.values())))
    found = Parallel(n_jobs=-1, return_as="generator")(delayed(survive)(n, stride) for n in blocks)
    seen = pd.concat(found, ignore_index=True)
    counts = seen.groupby(["engine", "family", "answer"]).size().unstack("family", fill_value=0)
    report.write_table("survival", counts.reset_index())
    return report.render(
        "survival", globals(), count=count, stride=stride, full=full,
        engines=seen.groupby("engine"), faults=seen[seen["verdict"].isin(FAULTS)],
    )  # fmt: skip


def survive(block: int, stride: int) -> pd.DataFrame:
    """Solve a block of scenes of all families; a row for each engine and scene."""
    rows: list[dict[str, object]] = []
    for family, share in SHARES.items():
        for number in range(block * BLOCK * share, (block + 1) * BLOCK * share):
            scene = random_scene(family, number, SEED)
            found = examine(scene, proven=number % stride == 0)
            rows += [{"family": family, "scene": number, **row} for row in found]
    return pd.DataFrame(rows)


def examine(scene: Scene, proven: bool = True) -> list[dict[str, Any]]:
    """Solve a scene by the engines: a row for each with its answer, verdict and seconds.

    `proven` tells whether the enclosure solves it though the others agree.
    """
    results: dict[str, Result] = {}
    rows = [_solved(scene, name, results) for name in ("ivp", "batch")]
    agree = _agree([*results.values()])
    if proven or not agree:
        rows.append(_solved(scene, "enclosure", results))
    truth = results.get("enclosure")
    for row in rows:
        if row["engine"] in results:
            row["verdict"] = verdict_of(scene, results[row["engine"]], truth)
            if agree and row["verdict"] == "not compared":
                row["verdict"] = "agree"
    if not agree and (truth is None or truth.outcome is None):
        outcomes = {result.outcome for result in results.values() if result.outcome is not None}
        for row in rows if len(outcomes) > 1 else ():
            row["verdict"] = "wrong outcome"  # of one of them
    return rows


def _solved(scene: Scene, name: str, results: dict[str, Result]) -> dict[str, Any]:
    """Solve a scene by an engine, and put the result, if there is one, with others."""
    options = {"digits": DIGITS} if name == "enclosure" else {}
    start = time.process_time()  # a scene's own work, whatever else the machine does
    try:
        results[name] = result = solve(scene, create(name, **options))
    except Exception as fault:
        answer, verdict = repr(fault), "exception"
    else:
        answer, verdict = result.outcome or f"error: {result.error}"[:40], ""
    seconds = time.process_time() - start
    return {"engine": name, "answer": answer, "verdict": verdict, "seconds": seconds}


def _agree(results: list[Result]) -> bool:
    """True if results that have an outcome have the same numbers, but for some roundings."""
    solved = [result for result in results if result.outcome is not None]
    if len(solved) < 2:
        return True
    one, other = solved
    return decisions(one) == decisions(other) and all(
        error <= _AGREE * fine for error, fine in errors(one, other).values()
    )


def verdict_of(scene: Scene, result: Result, truth: Result | None) -> str:
    """Return the verdict on a result."""
    if result.outcome is None:
        return "declined"
    if truth is None or truth.outcome is None:
        return "not compared"
    if decisions(result) != decisions(truth):
        return "wrong outcome"
    excess = errors(result, truth)
    doubtful = {name: error for name, (error, fine) in excess.items() if error > _FINE * fine}
    attainable = moved_errors(scene, truth) if doubtful else {}
    if attainable is None:
        return "not compared"
    for name, error in doubtful.items():
        allowed = ALLOWED * (attainable[name] + excess[name][1])
        if error > max(allowed, _least(scene, truth, name)):
            return "number off"
    return "right"


def _least(scene: Scene, truth: Result, name: str) -> float:
    """Return by how much a number may be off, whatever moves with the inputs."""
    if name in ("apex.time", "apex.position[0]", "apex.position[1]"):
        return math.inf  # a flat top is known by its height: roundings of w move it as they like
    if ".position" in name or name == "landing.distance":
        return _ROUNDINGS * ROUNDING * _start(scene)
    if name == "contact.margin" and isinstance(scene, AtBatScene):
        # A height less that of the bat, as `longball.engines.event.margin_error` counts.
        return 8 * ROUNDING * (_height(truth) + abs(scene.swing.height_offset))
    return 0.0


def _height(truth: Result) -> float:
    """Return the height of the pitch over the plate, m; 0 where there is none."""
    return abs(float(truth.plate.position[2])) if truth.plate else 0.0


def _start(scene: Scene) -> float:
    """Return the largest coordinate of the release or launch, m; 0 where nothing flies."""
    if isinstance(scene, FlightScene):
        return max(map(abs, scene.launch.position))
    return max(map(abs, scene.pitch.release)) if hasattr(scene, "pitch") else 0.0


def _extent(scene: Scene) -> float:
    """Return a ball's distance from the start of a flight, m, or its height, if larger."""
    farthest = 0.0
    for leg in solve_with_path(scene, create("ivp"))[1].legs:
        with suppress(CannotSolve):  # a ball that loops above the ground takes too many steps
            for piece in leg.flight.path.pieces():
                if piece.begin > leg.flight.time:
                    break
                state = piece.at(0.0)
                farthest = max(farthest, *map(abs, (state.s, getattr(state, "y", 0.0), state.z)))
    return farthest


def errors(result: Result, truth: Result) -> dict[str, tuple[float, float]]:
    """Return of every number how far it is off, and half an ulp of its vector's length.

    A difference within the radius of the true number, which may be that large, is none.
    """
    true = dict(numbers(truth))
    found = {}
    for name, value in numbers(result):
        length = float(np.hypot.reduce([float(exactly(true[x])) for x in vector_of(name)]))
        off = float(abs(exactly(value) - exactly(true[name])))
        radius = float(getattr(true[name], "radius", 0.0) or 0.0)
        found[name] = max(off - radius, 0.0), ROUNDING * length
    return found


@lru_cache(maxsize=1)  # the same of each engine
def moved_errors(scene: Scene, truth: Result) -> dict[str, float] | None:
    """Return the change of each number by half an ulp of each input.

    None if the outcome changes.
    """
    values = inputs(scene)
    sizes = {name: abs(x) for name, x in values.items()}
    # A ball that comes back to its start after loops of kilometres is there to their rounding.
    starts = [name for name in sizes if name.startswith(("launch.position", "pitch.release"))]
    farthest = _extent(scene) if starts else 0.0
    sizes |= {name: max(sizes[name], farthest) for name in starts}
    if isinstance(scene, AtBatScene) and truth.plate is not None:
        # A double holds z_b, and the way of the ball, no better, however small the offset is.
        sizes["swing.height_offset"] += max(_height(truth), _start(scene))
    moved: dict[str, float] = defaultdict(float)
    for name, move in sizes.items():
        steps = (STEP, -STEP) if move else ()
        others = (with_input(scene, name, values[name] + step * move) for step in steps)
        other: Any = next(filter(None, others), None)  # None: underground, say
        if other is not None:
            found = solve(other, create("enclosure", digits=DIGITS))
            if decisions(found) != decisions(truth):
                return None
            for quantity, (error, _) in errors(found, truth).items():
                moved[quantity] += error * ROUNDING / STEP
    return moved or None
