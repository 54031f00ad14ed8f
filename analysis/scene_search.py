"""``python -m analysis.scene_search OUT.jsonl``: search for scenes that notice what few cases do.

Random scenes of the whole model are solved, and every edit of the judge is held against them and
the golden data (`longball.judge.coverage`). Of the edits that fewer than `ENOUGH` golden cases
notice, the scene that notices most is taken, then the one that notices most of the rest, and so on:
a greedy cover. Its scenes are drafts for the golden writer (docs/golden.md).
"""

import argparse
import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import ValidationError

from analysis.random_scenes import Written, baseball, extended
from longball import golden
from longball.engines.ivp import Ivp
from longball.judge.cases import Known, decidable, solved
from longball.judge.coverage import Coverage, coverage
from longball.model.scene import KINDS, Scene, parse_scene

ENOUGH = 3  # golden cases that are to notice an edit
DIGITS = 5  # of the numbers of a scene
SCENES, SEED = 600, 40


def main() -> None:
    """Search, and write the scenes that were chosen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("output")
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--most", type=int, default=100, help="scenes that are chosen")
    parser.add_argument("--every", type=int, default=1, help="edits, of which one is tried")
    arguments = parser.parse_args()
    pool = [case for case in solved(drawn(arguments.scenes), Ivp()) if decidable(case)]
    cases = golden.load("all")
    found = coverage([*cases, *pool], arguments.every)
    with open(arguments.output, "w", encoding="utf-8") as file:
        for case, gain in chosen(found, arguments.most):
            line = {"scene": json.loads(case.scene.line()), "comment": f"notices {gain} edits"}
            file.write(json.dumps(line | {"flags": []}) + "\n")


def chosen(found: Coverage, most: int) -> Iterator[tuple[Known, int]]:
    """Yield scenes that are no golden cases, and how many edits each adds, the best first."""
    own = np.array([isinstance(case, golden.Case) for case in found.cases])
    lacking = np.maximum(ENOUGH - found.noticed[:, own].sum(axis=1), 0)
    offered = found.noticed[:, ~own]
    others = [case for case in found.cases if isinstance(case, Known)]
    for _ in range(most):
        gains = (offered & (lacking > 0)[:, None]).sum(axis=0)
        best = int(gains.argmax())
        if not gains[best]:
            return
        yield others[best], int(gains[best])
        lacking = np.maximum(lacking - offered[:, best], 0)
        offered[:, best] = False


# --- scenes ---------------------------------------------------------------------------------------


def drawn(count: int) -> Iterator[Scene]:
    """Yield random scenes of all kinds, a third of them of the paper's model."""
    for number in range(count):
        kind = list(KINDS)[number % len(KINDS)]
        generator = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(number,)))
        scene: Scene | None = None
        while scene is None:
            written = _varied(kind, generator, number % 3 == 0) | {"id": f"drawn-{number:04}"}
            try:
                scene = parse_scene(KINDS[kind].model_validate_json(json.dumps(written)).line())
            except ValidationError:
                continue  # underground, or a lift without a direction
        yield scene


def _varied(kind: str, generator: np.random.Generator, plain: bool) -> Written:
    """Return a scene with every number drawn that its kind has, as short decimals."""
    uniform = generator.uniform
    scene = (baseball if plain else extended)(kind, generator)
    if generator.random() < 0.5:
        scene["reading"] = {}
    ball = {"mass": uniform(0.14, 0.15), "radius": uniform(0.035, 0.038),
            "restitution": uniform(0.35, 0.5)}  # fmt: skip
    scene["ball"] = scene.get("ball", {}) | ball
    if kind in ("impact", "at-bat"):
        scene["bat"] = scene.get("bat", {}) | {
            "mass": uniform(0.8, 1.0), "length": uniform(0.75, 1.05), "radius": uniform(0.03, 0.036)
        }  # fmt: skip
    if kind != "impact":
        scene["gravity"] = uniform(9.7, 9.9)
        scene["time_limit"] = uniform(0.3, 8.0) if generator.random() < 0.2 else uniform(8.0, 20.0)
        wind = (scene.get("air") or {}).get("wind")
        rough = isinstance(wind, dict) and "roughness" in wind
        if kind != "pitch":
            scene["ground"] = {"height": uniform(-0.02 if rough else -2.0, 0.5)}
            scene["fence"] = _nearer(scene.get("fence"), uniform(0.2, 0.8))
        if plain:
            scene["air"] = {"density": uniform(0.9, 1.3), "drag_coefficient": uniform(0.2, 0.5),
                            "lift_coefficient": uniform(-0.1, 0.3)}  # fmt: skip
    if kind == "flight":
        scene["launch"]["position"] = [uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(0.6, 2.0)]
    if kind in ("pitch", "at-bat") and "velocity" not in scene["pitch"]:
        scene["pitch"]["release"] = [uniform(16.0, 18.4), uniform(-0.7, 0.7), uniform(1.4, 2.1)]
    if kind != "impact" and not plain and generator.random() < 0.1:
        # A spin of 0 gives no lift, whatever the law says.
        scene["launch" if kind == "flight" else "pitch"]["spin"] = [0.0, 0.0, 0.0]
        scene["air"]["lift_coefficient"] = uniform(0.1, 0.3)
    scene = dict(_short(scene))
    if kind == "impact":
        x, y, z = scene["incoming"]["position"]
        height = scene["incoming"]["bat_height"]
        reach = scene["ball"]["radius"] + scene["bat"]["radius"]
        share = reach / math.hypot(x, z - height)
        scene["incoming"]["position"] = [x * share, y, height + (z - height) * share]
    return scene


def _nearer(fence: Written | None, share: float) -> Written | None:
    """Return a fence that more balls reach."""
    match fence:
        case {"radius": radius}:
            return {"radius": share * radius}
        case {"polyline": corners}:
            return {"polyline": [[share * x, share * y, height] for x, y, height in corners]}
    return None


def _short(data: Any) -> Any:
    """Return data with short decimals, without what is null."""
    if isinstance(data, float):
        return float(f"{data:.{DIGITS}g}")
    if isinstance(data, dict):
        return {key: _short(x) for key, x in data.items() if x is not None}
    return [_short(x) for x in data] if isinstance(data, list) else data


if __name__ == "__main__":
    main()
