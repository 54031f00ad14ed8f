"""Proven errors: whether the radii of `longball solve --certify` hold the truth, and their price.

Each radius is held against the enclosure of 40 digits. That is for random scenes far beyond
baseball, and for at-bats of the paper's distributions, whose time is measured too.
"""

import time
from itertools import islice

import pandas as pd
from joblib import Parallel, delayed

from analysis.paper.printed import AT_BATS, BASE
from analysis.random_scenes import random_scene
from analysis.survival import errors
from analysis.writing import Report
from longball.engines.certify import certify
from longball.engines.chain import solve
from longball.engines.compiled import compile_at_once
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.golden.case import ROUNDING
from longball.home_run import draw_block, scenes
from longball.model.quantities import numbers
from longball.model.result import Result
from longball.model.scene import Scene

SCENES, FULL_SCENES = 400, 10_000
BLOCK = 100
SEED = 21
TRUTH = Enclosure(40)


def run(report: Report, full: bool) -> str:
    """Certify the scenes, hold radii against the truth, and sum up."""
    number = FULL_SCENES if full else SCENES
    blocks = Parallel(n_jobs=-1)(delayed(_block)(block) for block in range(number // BLOCK))
    seen = pd.DataFrame([row for block in blocks for row in block])
    return report.render("certificates", globals(), number=number, seen=seen, full=full)


def _block(block: int) -> list[dict[str, object]]:
    half = BLOCK // 2
    paper = list(islice(filter(None, scenes(BASE, draw_block(AT_BATS, SEED, block))), half))
    beyond = [random_scene("wide", block * BLOCK + number, SEED) for number in range(half)]
    compile_at_once()
    certify(paper[0], solve(paper[0], Ivp()))  # compiles, and is not timed
    rows = [_certified("at-bats of the paper", scene) for scene in paper]
    return rows + [_certified("far beyond", scene) for scene in beyond]


def _certified(name: str, scene: Scene) -> dict[str, object]:
    """Certify a scene, and return the outcome of the attempt."""
    result = solve(scene, Ivp())
    start = time.process_time()
    found = certify(scene, result)
    seconds = time.process_time() - start
    row: dict[str, object] = {"scenes": name, "seconds": seconds, "numbers": 0, "wrong": 0}
    if found.error is not None:
        return row | {"answer": "error"}
    if found.certificate is not None:
        return row | {"answer": "not certified"}
    truth = solve(scene, TRUTH)
    if truth.error is not None:  # fewer digits take fewer steps
        return row | {"answer": "not compared"}
    return row | {"answer": "certified"} | _held(found, truth)


def _held(found: Result, truth: Result) -> dict[str, object]:
    """Return the number of radii, the largest relative one, and the number that miss the truth."""
    if found.outcome != truth.outcome:
        raise ValueError(f"{found.id}: {found.outcome} is certified, the truth is {truth.outcome}")
    radii = {name: float(number.radius) for name, number in numbers(found)}
    off = errors(found, truth)
    wrong = sum(error > radii[name] for name, (error, _) in off.items())
    relative = (radii[name] * ROUNDING / (fine or ROUNDING) for name, (_, fine) in off.items())
    return {"numbers": len(radii), "wrong": wrong, "radius": max(relative, default=0.0)}
