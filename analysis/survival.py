"""Random survival: whatever scene the engines are given, each answers, rightly or with a reason.

Scenes of all kinds and of the families of `analysis.random_scenes` go through `ivp` and `batch`,
and some of them through `enclosure`, whose outcomes and numbers are proven. None may raise an
exception. Outcomes that are given have to be the same. A number may be off by `ALLOWED` times what
doubles can attain, which is estimated here: the scene is solved again, proven, with all of its
inputs moved at once by a few roundings, up and down at random. And by some roundings of the place
where the flight begins: those who count from there know no other place better.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from pydantic import ValidationError

from analysis.random_scenes import FAMILIES, random_scene
from analysis.stability import ALLOWED, exactly
from analysis.writing import render, table
from longball.engines import create
from longball.engines.chain import solve
from longball.golden.case import ROUNDING, vector_of
from longball.golden.condition import STEP, inputs
from longball.model.quantities import numbers, replaced
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, PitchScene, Scene

SCENES, FULL_SCENES = 2_000, 1_000_000
# Of the full number, those that the enclosure solves, too: every so many; of others all.
FULL_STRIDE = 20
BLOCK = 100
SEED = 20

DIGITS = 20  # of the truth
_MOVES = 4  # of all inputs at once
# An error below so many roundings of its vector's length needs no estimate.
_FINE = 64
# Of the start of the flight, as a search for events has it.
_ROUNDINGS = 4

# The last three are faults.
VERDICTS = ("right", "declined", "not compared", "wrong outcome", "number off", "exception")


def run(report: Path, full: bool) -> str:
    """Solve the scenes and count what came of them."""
    count, stride = (FULL_SCENES, FULL_STRIDE) if full else (SCENES, 1)
    blocks = Parallel(n_jobs=-1)(delayed(survive)(n, stride) for n in range(count // BLOCK))
    seen = pd.DataFrame([row for block in blocks for row in block])
    counts = seen.groupby(["engine", "family", "answer"]).size().unstack("family", fill_value=0)
    table(report, "survival", counts.reset_index())
    return render(
        report,
        "survival",
        count=count,
        seed=SEED,
        stride=stride,
        digits=DIGITS,
        allowed=ALLOWED,
        verdicts=VERDICTS,
        engines=[
            {
                "name": engine,
                "counts": [(of["verdict"] == verdict).sum() for verdict in VERDICTS],
                "median": of["seconds"].median(),
                "most": of["seconds"].quantile(0.99),
                "longest": of["seconds"].max(),
            }
            for engine, of in seen.groupby("engine")
        ],
        faults=list(seen[seen["verdict"].isin(VERDICTS[3:])].itertuples()),
        full=full,
    )


def survive(block: int, stride: int) -> list[dict[str, object]]:
    """Solve a block of scenes of all families; a row for each engine and scene."""
    rows: list[dict[str, object]] = []
    for number in range(block * BLOCK, (block + 1) * BLOCK):
        turn, family = divmod(number, len(FAMILIES))
        name = list(FAMILIES)[family]
        scene = random_scene(name, turn, SEED)
        found = examine(scene, proven=turn % stride == 0)
        rows += [{"family": name, "scene": scene.id, **row} for row in found]
    return rows


def examine(scene: Scene, proven: bool = True) -> list[dict[str, Any]]:
    """Solve a scene by the engines: a row for each with its answer, verdict and seconds."""
    names = ["ivp", "batch", *(["enclosure"] if proven else [])]
    results, rows = {}, []
    for name in names:
        options = {"digits": DIGITS} if name == "enclosure" else {}
        start = time.process_time()  # a scene's own work, whatever else the machine does
        try:
            result = solve(scene, create(name, **options))
        except Exception as fault:
            answer, verdict = repr(fault), "exception"
        else:
            results[name] = result
            answer, verdict = result.outcome or f"error: {result.error}"[:40], ""
        seconds = time.process_time() - start
        rows.append({"engine": name, "answer": answer, "verdict": verdict, "seconds": seconds})
    truth = results.get("enclosure")
    for row in rows:
        if row["engine"] in results:
            row["verdict"] = verdict_of(scene, results[row["engine"]], truth)
    if truth is None and len({r.outcome for r in results.values() if r.outcome is not None}) > 1:
        for row in rows:
            row["verdict"] = "wrong outcome"  # of one of them
    return rows


def verdict_of(scene: Scene, result: Result, truth: Result | None) -> str:
    """Return the verdict on a result."""
    if result.outcome is None:
        return "declined"
    if truth is None or truth.outcome is None:
        return "not compared"
    if result.outcome != truth.outcome:
        return "wrong outcome"
    excess = errors(result, truth)
    doubtful = {name: error for name, (error, fine) in excess.items() if error > _FINE * fine}
    if not doubtful:
        return "right"
    attainable = moved_errors(scene, truth)
    if attainable is None:
        return "not compared"
    start = _start(scene)
    reach = scene.ball.radius + scene.bat.radius if isinstance(scene, AtBatScene) else np.inf
    for name, error in doubtful.items():
        fine = excess[name][1]
        rounded = ROUNDING * start if ".position" in name else fine * start / reach
        if error > ALLOWED * (attainable[name] + fine) + _ROUNDINGS * rounded:
            return "number off"
    return "right"


def _start(scene: Scene) -> float:
    """Return the largest coordinate of the release or launch, m; 0 where nothing flies."""
    match scene:
        case FlightScene():
            return max(map(abs, scene.launch.position))
        case PitchScene() | AtBatScene():
            return max(map(abs, scene.pitch.release))
    return 0.0


def errors(result: Result, truth: Result) -> dict[str, tuple[float, float]]:
    """Return of every number how far it is off, and half an ulp of its vector's length."""
    true = {name: exactly(value) for name, value in numbers(truth)}
    found = {}
    for name, value in numbers(result):
        length = float(np.hypot.reduce([float(true[part]) for part in vector_of(name)]))
        found[name] = float(abs(exactly(value) - true[name])), ROUNDING * length
    return found


def moved_errors(scene: Scene, truth: Result) -> dict[str, float] | None:
    """Return how far each number moves with the inputs, for half an ulp of these.

    None if the outcome changes.
    """
    generator = np.random.default_rng(SEED)
    sizes = {name: abs(x) for name, x in inputs(scene).items()}
    if isinstance(scene, AtBatScene) and truth.plate is not None:
        # A double holds z_b no better than this, however small the offset is.
        sizes["swing.height_offset"] += abs(float(exactly(truth.plate.position[2])))
    largest: dict[str, float] = {}
    for _ in range(_MOVES):
        moves = dict(zip(sizes, generator.choice([-STEP, STEP], len(sizes)), strict=True))
        values: Mapping[str, float] = {
            name: x + float(moves[name]) * sizes[name] for name, x in inputs(scene).items()
        }
        try:
            other = solve(replaced(scene, values), create("enclosure", digits=DIGITS))
        except ValidationError:
            continue
        if other.outcome != truth.outcome:
            return None
        for name, (error, _) in errors(other, truth).items():
            largest[name] = max(largest.get(name, 0.0), error * ROUNDING / STEP)
    return largest or None
