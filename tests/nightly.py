"""Random scenes by all engines against the oracle: `make nightly`, and the tests by the same code.

A quantity may differ by what the oracle itself may be wrong by. Its flights take some hundred steps
to 1e-13 each; flown in steps of another length they agree to 1e-12, relative to a quantity or to 1.
A step across a narrow drag crisis may err by more: so a scene with a difference is compared again,
with the oracle in far shorter steps. What comes after a flight is off by that times the condition
of the quantity, which the oracle measures: it solves a second scene that is moved by 1e-9. An
engine's own error is of the same size or smaller.

A scene within 1e-6 (m, m/s, or of 1) of another outcome, or with another one when it is moved, is
left out, and counted. So is, for its engine, a scene that an engine cannot decide or prove. That
a scene is refused is a difference: all that are drawn are scenes of the model.
"""

import argparse
import json
import math
import random
import sys
from concurrent.futures import ProcessPoolExecutor
from datetime import date
from typing import NamedTuple

import longball as lb
from tests import oracle
from tests.scenes import random_scene

MOVED = 1e-9
ERROR = 1e-13  # of a step of the oracle, relative
NEAR = 1e-6
UNDECIDED = ("undecided", "too_long", "out_of_range")  # codes of an engine that reached its limits
SHORTER = 1 / 16  # of the oracle's longest step: steps of a second comparison
PIECE = 50  # scenes that one process solves at a time

# Options of `lb.solve_many`, and one in how many scenes is solved with them: some are slow.
ENGINES = {
    "ivp": ({"engine": "ivp"}, 1),
    "batch": ({"engine": "batch"}, 1),
    "enclosure": ({"engine": "enclosure", "digits": 20}, 5),
    "certify": ({"certify": True}, 10),
    "multiprecision": ({"engine": "multiprecision", "digits": 16}, 50),
}


class Value(NamedTuple):
    """A quantity by the oracle, and by how much an engine's may differ."""

    value: object
    tolerance: float = 0.0


def quantities(result, prefix="", number=float):
    """Names and values of a result: words, and lists of numbers, whatever stands beside these."""
    for name, value in result.items():
        if isinstance(value, dict) and "value" not in value:
            yield from quantities(value, f"{prefix}{name}.", number)
        elif value is None or isinstance(value, str | bool):
            yield prefix + name, value
        else:
            parts = value if hasattr(value, "__len__") and "value" not in value else [value]
            yield prefix + name, [number(p["value"] if isinstance(p, dict) else p) for p in parts]


def moved(scene):
    """The scene with every first velocity and the bat's height changed by a part in 1e9."""
    scene = json.loads(json.dumps(scene))
    for block in ("launch", "pitch", "incoming"):
        if "velocity" in scene.get(block, {}):
            scene[block]["velocity"] = [c * (1 + MOVED) for c in scene[block]["velocity"]]
        elif block == "pitch" and block in scene:
            scene[block]["speed"] = scene[block].get("speed", 36.9125) * (1 + MOVED)
    if scene["kind"] == "at-bat":
        swing = scene.get("swing", {})
        scene["swing"] = swing | {"height_offset": swing.get("height_offset", 0.0) + MOVED}
    return scene


def truth(scene, longest=oracle.STEP):
    """Quantities of a scene by the oracle, with their tolerances; None if it is in doubt."""
    try:
        answer, other = oracle.solve(scene, longest), oracle.solve(moved(scene), 2 * longest)
    except oracle.Unclear:
        return None
    here, there = dict(quantities(answer.result)), dict(quantities(other.result))
    words = [{k: v for k, v in q.items() if not isinstance(v, list)} for q in (here, there)]
    if answer.doubt.least < NEAR or words[0] != words[1] or here.keys() != there.keys():
        return None
    sizes = {k: max(1.0, math.hypot(*v)) for k, v in here.items() if isinstance(v, list)}
    if "impact.energy_change" in sizes:  # a difference of works
        work = abs(here["impact.impulse"][0] * here["contact.normal_speed"][0])
        sizes["impact.energy_change"] = max(work, sizes["impact.energy_change"])
    conditions = {}
    for name, size in sizes.items():
        block = name.partition(".")[0]
        condition = math.dist(here[name], there[name]) / (MOVED * size)
        conditions[block] = max(condition, conditions.get(block, 1.0))
    return {
        name: Value(value, ERROR * (10 + conditions[name.partition(".")[0]]) * sizes[name])
        if name in sizes
        else Value(value)
        for name, value in here.items()
    }


def differences(answer, true):
    """Yield name, what an engine answers, what is true, and the difference over the tolerance."""
    found = dict(quantities({k: v for k, v in answer.items() if k not in ("id", "engine")}))
    for name in sorted(found.keys() | true.keys()):
        here, (value, tolerance) = found.get(name), true.get(name, Value(None))
        if isinstance(here, list) and isinstance(value, list):
            off = math.dist(here, value) / tolerance
        else:
            off = 0.0 if here == value else math.inf
        yield name, here, value, off


class Comparison(NamedTuple):
    """Answer of an engine to a scene, by the quantity that is off most."""

    engine: str
    label: str
    off: float | None  # in tolerances; None: the engine has no answer
    sentence: str

    @property
    def wrong(self):
        return self.off is not None and not self.off <= 1


def compare(scenes, labels, first=None):
    """Solve scenes by the oracle and by the engines. Return comparisons, and labels in doubt.

    `first` is the number of the first scene: an engine solves those whose number is a multiple of
    its share. Without one, all engines solve all.
    """
    truths = [truth(scene) for scene in scenes]
    doubtful = [label for label, true in zip(labels, truths, strict=True) if true is None]
    clear = [row for row in enumerate(zip(scenes, labels, truths, strict=True)) if row[1][2]]
    rows = []
    for engine, (options, one_of) in ENGINES.items():
        chosen = [row for i, row in clear if first is None or (first + i) % one_of == 0]
        solutions = lb.solve_many([scene for scene, _, _ in chosen], workers=1, **options)
        for (scene, label, true), solution in zip(chosen, solutions, strict=True):
            answer = json.loads(solution.result.line())
            off, sentence = judged(answer, true)
            if off is not None and off > 1 and (finer := truth(scene, SHORTER * oracle.STEP)):
                off, sentence = judged(answer, finer)
            rows.append(Comparison(engine, label, off, f"{sentence}\n  {json.dumps(scene)}"))
    return rows, doubtful


def judged(answer, true):
    """Largest error of an answer, in tolerances, and a sentence on it."""
    if answer.get("code") in UNDECIDED or "certificate" in answer:
        return None, answer.get("error") or answer["certificate"]
    if "error" in answer:
        return math.inf, answer["error"]
    name, here, value, off = max(differences(answer, true), key=lambda found: found[3])
    return off, f"{name} is {here}, not {value}: {off:.2g} times the tolerance"


def drawn(seed, numbers):
    """The scenes of these numbers, and what names them."""
    labels = [f"{seed} {number}" for number in numbers]
    return [random_scene(random.Random(label)) for label in labels], labels


def piece(seed, first, last):
    return compare(*drawn(seed, range(first, last)), first)


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--scenes", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=date.today().toordinal())
    parser.add_argument("--workers", type=int, default=None, help="processes; one per core")
    called = parser.parse_args()
    starts = range(0, called.scenes, PIECE)
    rows, doubtful = [], []
    with ProcessPoolExecutor(called.workers) as pool:
        futures = [
            pool.submit(piece, called.seed, start, min(start + PIECE, called.scenes))
            for start in starts
        ]
        for future in futures:
            compared, unclear = future.result()
            rows, doubtful = rows + compared, doubtful + unclear
            for row in compared:
                if row.off is None or row.wrong:
                    print(f"{row.engine}, scene {row.label!r}: {row.sentence}", flush=True)
    print(f"seed {called.seed}: {called.scenes} scenes, {len(doubtful)} in doubt {doubtful}")
    for engine in ENGINES:
        mine = [row for row in rows if row.engine == engine]
        right = [row.off for row in mine if row.off is not None and not row.wrong]
        wrong = [row for row in mine if row.wrong]
        print(
            f"{engine}: {len(mine)} compared, {len(wrong)} differ, "
            f"{len(mine) - len(right) - len(wrong)} without an answer, "
            f"the others off by at most {max(right, default=0):.2f} of the tolerance"
        )
    return 1 if any(row.wrong for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
