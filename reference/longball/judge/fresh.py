"""Scenes that are in no set: drawn anew, or with the constants that programs have built in.

Their results are computed and proven when they are drawn: no program can know them by heart.
"""

from __future__ import annotations

import csv
import itertools
import json
import math
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import StringIO
from typing import Any

import numpy as np
from pydantic import ValidationError

from longball import engines
from longball.engines.chain import solve
from longball.judge.cases import Known
from longball.model.csv_files import guarded
from longball.model.quantities import nested, numbers
from longball.model.scene import KINDS, Scene, written_out

DIGITS = 20  # of the truth: more than any double shows
USUAL = "usual-constants"  # the name of the set
GRAVITIES = (9.8, 9.80665, 9.81, 32.174 * 0.3048)  # m/s²
DENSITIES = (1.2, 1.205, 1.225, 1.29)  # kg/m³


def proven(
    scenes: Sequence[Scene],
    family: str | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Known]:
    """Return cases of scenes, each with its result enclosed to `DIGITS` digits."""
    engine = engines.create("enclosure", digits=DIGITS)
    cases = []
    for scene in scenes:
        cases.append(Known(scene, solve(scene, engine), family or scene.kind))
        progress(len(cases))
    return cases


def usual_constants() -> list[Scene]:
    """Return flights and pitches with values of g and ρ that programs have built in."""
    scenes: list[Scene] = []
    for i, (g, density) in enumerate(itertools.product(GRAVITIES, DENSITIES)):
        angle = math.radians(20 + 2 * i)
        velocity = (42 * math.cos(angle), 3.0, 42 * math.sin(angle))
        for kind, block in (
            ("flight", {"launch": {"position": (0.0, 0.0, 1.0), "velocity": velocity}}),
            ("pitch", {"pitch": {"speed": 34.0 + i / 2}}),
        ):
            given = {"id": f"{USUAL}-{kind}-{i:02}", "gravity": g, "air": {"density": density}}
            scenes.append(written_out(KINDS[kind].model_validate(given | block)))
    return scenes


DRAWN = ("at-bat", "flight", "pitch", "impact")  # kinds, in turn


def random_scenes(count: int, seed: int, kinds: Sequence[str] = DRAWN) -> Iterator[Scene]:
    """Yield scenes of some kinds in turn, every number drawn, the same for the same seed."""
    rng, made = np.random.default_rng(seed), 0
    while made < count:
        kind = kinds[made % len(kinds)]
        drawn = {"id": f"random-{seed}-{made:04}", "kind": kind, **_drawn(kind, rng)}
        try:
            scene = KINDS[kind].model_validate_json(json.dumps(drawn))
        except ValidationError:
            continue  # underground, for one
        made += 1
        yield written_out(scene)


# Limits of each number, by the kinds of scenes that draw it. The order is that of the draws: a
# change of it changes the scenes of every seed.
_RANGES: tuple[tuple[tuple[str, ...], dict[str, tuple[float, float]]], ...] = (
    (("flight", "pitch", "impact", "at-bat"), {
        "ball.mass": (0.14, 0.15), "ball.radius": (0.036, 0.038), "ball.restitution": (0.4, 0.5),
        "air.density": (0.9, 1.3), "air.drag_coefficient": (0.2, 0.5),
        "air.lift_coefficient": (-0.1, 0.3)}),
    (("flight", "pitch", "at-bat"), {"gravity": (9.7, 9.9)}),
    (("flight", "at-bat"), {"ground.height": (-0.5, 0.5)}),
    (("flight",), {
        "speed": (20, 50), "up": (0.1, 1.4), "aside": (-0.8, 0.8), "launch.position[0]": (-1, 1),
        "launch.position[1]": (-1, 1), "launch.position[2]": (0.6, 1.5)}),
    (("pitch", "at-bat"), {
        "pitch.speed": (30, 45), "pitch.release[0]": (16.5, 18.44),
        "pitch.release[1]": (-0.6, 0.6), "pitch.release[2]": (1.5, 2.1),
        "pitch.aim[0]": (-0.25, 0.25), "pitch.aim[1]": (1.5, 2.2)}),
    (("impact", "at-bat"), {
        "bat.mass": (0.8, 1.0), "bat.length": (0.8, 1.0), "bat.radius": (0.03, 0.034),
        "swing.angular_speed": (28, 40), "swing.tilt": (0.0, 0.2)}),
    (("at-bat",), {"swing.height_offset": (-0.9, 0.9)}),
    (("impact",), {
        "angle": (-0.9, 0.9), "incoming.bat_height": (0.5, 1.2),
        "incoming.position[1]": (-0.3, 0.3), "incoming.velocity[0]": (-42, -28),
        "incoming.velocity[1]": (-1, 1), "incoming.velocity[2]": (-6, -1)}),
)  # fmt: skip


def _drawn(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    """Return a scene without its id, as plain data."""
    drawn = {
        name: float(rng.uniform(*ends))
        for kinds, ranges in _RANGES
        for name, ends in (ranges.items() if kind in kinds else ())
    }
    reach = drawn["ball.radius"] + drawn.get("bat.radius", 0.0)
    if kind == "flight":
        speed, up, aside = (drawn.pop(name) for name in ("speed", "up", "aside"))
        drawn["launch.velocity[0]"] = speed * math.cos(up) * math.cos(aside)
        drawn["launch.velocity[1]"] = speed * math.cos(up) * math.sin(aside)
        drawn["launch.velocity[2]"] = speed * math.sin(up)
    if kind == "at-bat":
        drawn["swing.height_offset"] *= reach
    if kind == "impact":
        angle, height = drawn.pop("angle"), drawn["incoming.bat_height"]
        drawn["incoming.position[0]"] = reach * math.cos(angle)
        drawn["incoming.position[2]"] = height + reach * math.sin(angle)
        drawn = {name: x for name, x in drawn.items() if not name.startswith("air.")}
    return nested(drawn)


def moved(scenes: Sequence[Scene], seed: int) -> Iterator[Scene]:
    """Yield scenes with every number moved by up to a tenth, a number 0 of a vector by up to 0.1.

    Ball and bat still touch. What is no scene any more, such as one underground, is left out.
    """
    draw = random.Random(seed)

    def shifted(value: Any, key: str = "", inside: bool = False) -> Any:
        if isinstance(value, dict):
            return {k: shifted(x, k) for k, x in value.items()}
        if isinstance(value, list):
            return [shifted(x, key, True) for x in value]
        if not isinstance(value, float) or key == "time_limit":
            return value
        return value * draw.uniform(0.9, 1.1) + (inside and value == 0.0) * draw.uniform(-0.1, 0.1)

    for number, scene in enumerate(scenes):
        before = json.loads(scene.line())
        after: dict[str, Any] = shifted(before) | {"id": f"moved-{seed}-{number:04}"}
        # An impact begins where ball and bat touch: both radii and the distance from the bat's axis
        # change by one factor.
        if incoming := before.get("incoming"):
            q = draw.uniform(0.9, 1.1)
            after["ball"]["radius"] = q * before["ball"]["radius"]
            after["bat"]["radius"] = q * before["bat"]["radius"]
            x, _, z = incoming["position"]
            height = after["incoming"]["bat_height"]
            after["incoming"]["position"][0] = q * x
            after["incoming"]["position"][2] = height + q * (z - incoming["bat_height"])
        try:
            yield KINDS[scene.kind].model_validate_json(json.dumps(after))
        except ValidationError:
            continue


def as_csv(scenes: Iterable[Scene]) -> Iterator[bytes]:
    """Yield scenes as lines of CSV, the header first; a cell is empty where there is no number."""
    rows = [
        {"id": guarded(s.id or ""), "kind": s.kind}
        | {name: repr(float(value)) for name, value in numbers(s)}
        | {f"reading.{name}": str(option) for name, option in s.reading}
        for s in scenes
    ]
    names = list(dict.fromkeys(name for row in rows for name in row))
    for row in [dict(zip(names, names, strict=True)), *rows]:
        text = StringIO()
        csv.DictWriter(text, names, lineterminator="\n").writerow(row)
        yield text.getvalue().encode()
