"""Scenes that are in no set: drawn anew, or with the constants that programs have built in.

They are solved and proven on the spot: a candidate is judged by what nobody has seen before.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from pydantic import ValidationError

from longball import engines
from longball.engines.chain import solve
from longball.judge.cases import Known
from longball.model.quantities import numbers
from longball.model.scene import KINDS, Scene

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
    for i, (g, density) in enumerate((g, d) for g in GRAVITIES for d in DENSITIES):
        common = {"gravity": g, "air": {"density": density}}
        angle = math.radians(20 + 2 * i)
        launch = {
            "position": (0.0, 0.0, 1.0),
            "velocity": (42 * math.cos(angle), 3.0, 42 * math.sin(angle)),
        }
        scenes.append(
            KINDS["flight"].model_validate(
                {"id": f"{USUAL}-flight-{i:02}", "launch": launch} | common
            )
        )
        scenes.append(
            KINDS["pitch"].model_validate(
                {"id": f"{USUAL}-pitch-{i:02}", "pitch": {"speed": 34.0 + i / 2}} | common
            )
        )
    return scenes


def random_scenes(count: int, seed: int) -> Iterator[Scene]:
    """Yield scenes of all kinds with every number drawn, the same for the same seed."""
    rng, made = np.random.default_rng(seed), 0
    while made < count:
        kind = ("at-bat", "flight", "pitch", "impact")[made % 4]
        try:
            scene = KINDS[kind].model_validate(
                {"id": f"random-{seed}-{made:04}", "kind": kind} | _drawn(kind, rng)
            )
        except ValidationError:
            continue  # underground, for one
        made += 1
        yield scene


def _drawn(kind: str, rng: np.random.Generator) -> dict[str, Any]:
    def within(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    ball = {
        "mass": within(0.14, 0.15),
        "radius": within(0.036, 0.038),
        "restitution": within(0.4, 0.5),
    }
    air = {
        "density": within(0.9, 1.3),
        "drag_coefficient": within(0.2, 0.5),
        "lift_coefficient": within(-0.1, 0.3),
    }
    scene: dict[str, Any] = {"ball": ball}
    if kind != "impact":
        scene |= {"air": air, "gravity": within(9.7, 9.9)}
    if kind in ("flight", "at-bat"):
        scene["ground"] = {"height": within(-0.5, 0.5)}
    if kind == "flight":
        speed, up, aside = within(20, 50), within(0.1, 1.4), within(-0.8, 0.8)
        scene["launch"] = {
            "position": (within(-1, 1), within(-1, 1), within(0.6, 1.5)),
            "velocity": (
                speed * math.cos(up) * math.cos(aside),
                speed * math.cos(up) * math.sin(aside),
                speed * math.sin(up),
            ),
        }
    if kind in ("pitch", "at-bat"):
        scene["pitch"] = {
            "speed": within(30, 45),
            "release": (within(16.5, 18.44), within(-0.6, 0.6), within(1.5, 2.1)),
            "aim": (within(-0.25, 0.25), within(1.5, 2.2)),
        }
    if kind in ("impact", "at-bat"):
        bat = {"mass": within(0.8, 1.0), "length": within(0.8, 1.0), "radius": within(0.03, 0.034)}
        swing = {"angular_speed": within(28, 40), "tilt": within(0.0, 0.2)}
        scene |= {"bat": bat, "swing": swing}
        reach = ball["radius"] + bat["radius"]
        if kind == "at-bat":
            swing["height_offset"] = within(-0.9, 0.9) * reach
        else:
            angle, height = within(-0.9, 0.9), within(0.5, 1.2)
            scene["incoming"] = {
                "position": (
                    reach * math.cos(angle),
                    within(-0.3, 0.3),
                    height + reach * math.sin(angle),
                ),
                "velocity": (within(-42, -28), within(-1, 1), within(-6, -1)),
                "bat_height": height,
            }
    return scene


def as_csv(scenes: Iterable[Scene]) -> Iterator[bytes]:
    """Yield scenes as lines of CSV, the header first; a cell is empty where there is no number."""
    scenes = list(scenes)
    rows = [
        {"id": s.id or "", "kind": s.kind}
        | {name: repr(float(value)) for name, value in numbers(s)}
        | {f"reading.{name}": str(option) for name, option in s.reading}
        for s in scenes
    ]
    names = list(dict.fromkeys(name for row in rows for name in row))
    yield _row(names)
    for row in rows:
        yield _row([row.get(name, "") for name in names])


def _row(cells: Sequence[str]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue().encode()
