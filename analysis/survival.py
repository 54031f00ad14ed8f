"""Random survival: whatever scene the reference engine is given, it answers.

Scenes of all kinds, log-uniform over ranges far beyond baseball, go through the engine. Each has
to come back with an outcome of the contract or with an error that says why, without an exception.
"""

from __future__ import annotations

import json
import math
import time
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pandas as pd
from joblib import Parallel, delayed

from analysis.writing import table
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import KINDS, parse_scene

SCENES, FULL_SCENES = 5_000, 100_000
BLOCK = 100
SEED = 20


def run(report: Path, full: bool) -> str:
    """Solve the scenes and count what came of them."""
    count = FULL_SCENES if full else SCENES
    blocks = Parallel(n_jobs=-1)(delayed(survive)(block) for block in range(count // BLOCK))
    seen = pd.DataFrame([row for block in blocks for row in block])
    counts = seen.groupby(["answer", "kind"]).size().unstack(fill_value=0).reset_index()
    slow = seen["seconds"]
    return "\n".join(
        [
            "## Random survival\n",
            f"{count:,} random scenes (seed {SEED}), the kinds in equal parts: speeds from 0.1 to "
            "300 m/s, gravity from 0 to 300 m/s², air from 0 to 100 kg/m³, mass ratios from 1e-6 "
            "to 1e6, any reading. Every one was answered; a number of scenes for each answer:\n",
            table(report, "survival", counts),
            f"Half of them took less than {1e3 * slow.median():.2g} ms of processor time, 99 % "
            f"less than {1e3 * slow.quantile(0.99):.2g} ms, the slowest {slow.max():.2g} s "
            f"(`python -m analysis survival{' --full' if full else ''}`).\n",
        ]
    )


def survive(block: int) -> list[dict[str, object]]:
    """Solve a block of scenes; an exception of the engine would end the study."""
    generator = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(block,)))
    rows: list[dict[str, object]] = []
    for i in range(BLOCK):
        kind = list(KINDS)[i % len(KINDS)]
        line = json.dumps(random_scene(kind, generator)).encode()
        start = time.process_time()  # a scene's own work, whatever else the machine does
        result = solve(parse_scene(line), Ivp())
        seconds = time.process_time() - start
        rows.append({"kind": kind, "answer": answer(result), "seconds": seconds})
    return rows


def answer(result: Result) -> str:
    """Return the outcome, or the sort of error."""
    if result.outcome is not None:
        return result.outcome
    assert result.error is not None
    sorts = ("cannot be decided", "inside the bat", "gave up", "steps", "vertical over the plate")
    return f"error: {next((sort for sort in sorts if sort in result.error), result.error)}"


def random_scene(kind: str, generator: np.random.Generator) -> dict[str, Any]:
    """Return a random scene as it is written."""

    def size(low: float, high: float) -> float:
        return float(math.exp(generator.uniform(math.log(low), math.log(high))))

    def size_or_nothing(low: float, high: float) -> float:
        return 0.0 if generator.random() < 0.1 else size(low, high)

    def direction() -> tuple[float, float, float]:
        x, y, z = generator.standard_normal(3)
        norm = math.sqrt(x * x + y * y + z * z)
        return float(x / norm), float(y / norm), float(z / norm)

    def velocity() -> list[float]:
        speed = size(0.1, 300.0)
        return [speed * part for part in direction()]

    bat_mass = size(0.1, 10.0)
    ball_radius, bat_radius = size(0.01, 0.1), size(0.01, 0.1)
    reading = {
        name: generator.choice(get_args(field.annotation)).item()
        for name, field in Reading.model_fields.items()
    }
    if reading["bat_ball_restitution"] == "plain":
        reading["reduced_mass"] = "bat_mass"
    scene: dict[str, Any] = {
        "id": kind,
        "kind": kind,
        "ball": {
            "mass": bat_mass * size(1e-6, 1e6),
            "radius": ball_radius,
            "restitution": generator.random(),
        },
        "reading": reading,
    }
    bat = {"mass": bat_mass, "length": size(0.1, 10.0), "radius": bat_radius}
    swing = {
        "angular_speed": float(generator.normal(0.0, 50.0)),
        "tilt": float(generator.uniform(-math.pi, math.pi)),
    }
    if kind == "impact":
        angle = generator.uniform(-math.pi, math.pi)
        reach = ball_radius + bat_radius
        y = float(generator.normal(0.0, 0.5))
        position = [reach * math.cos(angle), y, 1.0 + reach * math.sin(angle)]
        incoming = {"position": position, "velocity": velocity(), "bat_height": 1.0}
        return scene | {"bat": bat, "swing": swing, "incoming": incoming}
    scene["gravity"] = size_or_nothing(1e-3, 300.0)
    scene["air"] = {
        "density": size_or_nothing(1e-4, 100.0),
        "drag_coefficient": size_or_nothing(0.01, 2.0),
        "lift_coefficient": float(generator.choice([-1, 1])) * size_or_nothing(0.01, 2.0),
    }
    if kind == "flight":
        height = ball_radius + size_or_nothing(1e-9, 100.0)
        launch = {"position": [0.0, 0.0, height], "velocity": velocity()}
        return scene | {"launch": launch}
    scene["pitch"] = {
        "speed": size(0.1, 300.0),
        "release": [size(0.3, 30.0), float(generator.normal()), 0.2 + size(0.1, 10.0)],
        "aim": [float(generator.normal(0.0, 0.5)), size(0.1, 10.0)],
    }
    if kind == "at-bat":
        swing["height_offset"] = float(generator.normal(0.0, 0.05))
        return scene | {"bat": bat, "swing": swing}
    return scene
