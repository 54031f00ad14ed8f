"""``python -m analysis.scene_search OUT.jsonl``: search for scenes that notice what few cases do.

Random scenes of the whole model are solved, and every edit of the judge is held against them and
the golden data (`longball.judge.coverage`). Of the edits that fewer than `ENOUGH` golden cases
notice, or none outside the families of hard cases, the scene that notices most is taken, then the
one that notices most of the rest, and so on: a greedy cover. Its scenes are drafts for the golden
writer (docs/golden.md). With ``--quick`` the same cover chooses golden cases, for `quick` in their
header, and OUT.jsonl holds their ids.
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
from longball.judge.cases import decidable, solved
from longball.judge.coverage import coverage
from longball.model.readings import Reading
from longball.model.scene import KINDS, Scene, parse_scene

ENOUGH = 3  # golden cases that are to notice an edit
POOL = "drawn"  # the family of random scenes
DIGITS = 5  # of the numbers of a scene
SCENES, SEED = 600, 40


def main() -> None:
    """Search, and write the scenes that were chosen, or the ids of `quick`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("output")
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--most", type=int, default=100, help="scenes that are chosen")
    parser.add_argument("--every", type=int, default=1, help="edits, of which one is tried")
    parser.add_argument("--quick", action="store_true", help="choose golden cases")
    arguments = parser.parse_args()
    pool = [case for case in solved(drawn(arguments.scenes), Ivp(), POOL) if decidable(case)]
    found = coverage([*golden.load("all"), *pool], arguments.every)
    families = np.array([case.family for case in found.cases])
    own, ordinary = families != POOL, is_ordinary(families)
    if arguments.quick:
        offered, lacking = np.flatnonzero(own), np.ones(len(found.edits), int)
    else:
        seen = found.noticed[:, ordinary].any(axis=1)
        offered, lacking = np.flatnonzero(~own), ENOUGH - found.noticed[:, own].sum(axis=1)
        lacking = np.maximum(lacking, ~seen)
    with open(arguments.output, "w", encoding="utf-8") as file:
        for i, gain in cover(found.noticed[:, offered], lacking, arguments.most):
            case = found.cases[offered[i]]
            line: Any = case.id
            if not arguments.quick:
                line = {
                    "scene": json.loads(case.scene.line()),
                    "comment": f"notices {gain} edits that few others do",
                    "flags": ["reading"] if case.scene.reading != Reading() else [],
                }
            file.write(json.dumps(line) + "\n")


def is_ordinary(families: np.ndarray) -> np.ndarray:
    """Return True for golden families that are not made of hard cases."""
    ordinary: np.ndarray = (families != POOL) & ~np.char.startswith(families, "hard")
    return ordinary


def cover(noticed: np.ndarray, lacking: np.ndarray, most: int) -> Iterator[tuple[int, int]]:
    """Yield columns of a matrix until each row has so many, and how many rows each helps."""
    noticed, lacking = noticed.copy(), np.maximum(lacking, 0)
    for _ in range(most):
        gains = noticed[lacking > 0].sum(axis=0)
        best = int(gains.argmax())
        if not gains[best]:
            return
        yield best, int(gains[best])
        lacking = np.maximum(lacking - noticed[:, best], 0)
        noticed[:, best] = False


# --- scenes ---------------------------------------------------------------------------------------


def drawn(count: int, seed: int = SEED, first: int = 0) -> Iterator[Scene]:
    """Yield random scenes of all kinds, a third of them of the paper's model."""
    for number in range(first, first + count):
        kind = list(KINDS)[number % len(KINDS)]
        generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
        scene: Scene | None = None
        while scene is None:
            plain = baseball(kind, generator) if number % 3 == 0 else None
            written = plain or extended(kind, generator, generator)
            _vary(written, generator, plain=plain is not None)
            written = dict(_short(written)) | {"id": f"drawn-{number:04}"}
            if kind == "impact":
                _touch(written)
            try:
                scene = parse_scene(KINDS[kind].model_validate_json(json.dumps(written)).line())
            except ValidationError:
                continue  # underground, or a lift without a direction
        yield scene


# Numbers of laws and winds that are drawn where a scene has them: from and to.
RANGES = {
    "drag_coefficient": {
        "spin": {"per_spin": (1e-4, 5e-4)},
        "crisis": {"high_speed": (0.2, 0.4), "low_speed": (0.4, 0.6), "per_spin": (1e-4, 4e-4)},
    },
    "lift_coefficient": {
        "rational": {"numerator": (0.9, 1.3), "constant": (0.4, 0.7), "slope": (1.5, 3.0)},
    },
    "density": {"weather": {"pressure": (9.6e4, 1.04e5)}},
    "wind": {"profile": {"height": (4.0, 20.0)}},
}


def _vary(scene: Written, generator: np.random.Generator, plain: bool) -> None:
    """Draw every number that a scene of its kind has; a plain one has the paper's air."""
    uniform, kind = generator.uniform, scene["kind"]
    if generator.random() < 0.5:
        scene["reading"] = {}
    ball = {"mass": uniform(0.14, 0.15), "radius": uniform(0.035, 0.038),
            "restitution": uniform(0.35, 0.5)}  # fmt: skip
    scene["ball"] = scene.get("ball", {}) | ball
    if kind in ("impact", "at-bat"):
        scene["bat"] = scene.get("bat", {}) | {
            "mass": uniform(0.8, 1.0), "length": uniform(0.75, 1.05), "radius": uniform(0.03, 0.036)
        }  # fmt: skip
    if kind == "impact":
        return
    scene["gravity"] = uniform(9.7, 9.9)
    scene["time_limit"] = uniform(0.3, 8.0) if generator.random() < 0.2 else uniform(8.0, 20.0)
    if plain:
        scene["air"] = {"density": uniform(0.9, 1.3), "drag_coefficient": uniform(0.2, 0.5),
                        "lift_coefficient": uniform(-0.1, 0.3)}  # fmt: skip
    else:
        _vary_air(scene["air"], generator)
    if kind != "pitch":
        wind = scene["air"].get("wind")
        rough = isinstance(wind, dict) and "roughness" in wind
        scene["ground"] = {"height": uniform(-0.02 if rough else -2.0, 0.5)}
        scene["fence"] = _nearer(scene.get("fence"), uniform(0.2, 0.8))
    if kind == "flight":
        scene["launch"]["position"] = [uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(0.6, 2.0)]
    elif "velocity" not in scene["pitch"]:
        scene["pitch"]["release"] = [uniform(16.0, 18.4), uniform(-0.7, 0.7), uniform(1.4, 2.1)]
    if not plain and kind != "at-bat" and generator.random() < 0.1:
        # A spin of 0 gives no lift, whatever the law says. The least spin gives the whole of it,
        # so that doubles cannot tell where such a pitch meets the bat.
        scene["launch" if kind == "flight" else "pitch"]["spin"] = [0.0, 0.0, 0.0]
        scene["air"]["lift_coefficient"] = uniform(0.1, 0.3)


def _vary_air(air: Written, generator: np.random.Generator) -> None:
    """Draw the numbers of laws, weather and wind, and a side force at times."""
    for key, laws in RANGES.items():
        if isinstance(given := air.get(key), dict):
            named = given.get("law") or ("profile" if "roughness" in given else "weather")
            for name, ends in laws.get(named, {}).items():
                if generator.random() < 0.7:
                    given[name] = generator.uniform(*ends)
    if generator.random() < 0.3:
        direction = generator.standard_normal(3).tolist()
        air["side_coefficient"] = {"value": generator.uniform(-0.1, 0.1), "direction": direction}


def _touch(scene: Written) -> None:
    """Move the ball of an impact to where it touches the bat."""
    x, y, z = scene["incoming"]["position"]
    height = scene["incoming"]["bat_height"]
    reach = scene["ball"]["radius"] + scene["bat"]["radius"]
    share = reach / math.hypot(x, z - height)
    scene["incoming"]["position"] = [x * share, y, height + (z - height) * share]


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
