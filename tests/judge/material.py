"""Scenes to judge by: the paper's at-bats and what surrounds them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.home_run import draw, paper_at_bats, scenes
from longball.judge.answers import Answer, Collector
from longball.judge.cases import decidable
from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.residual import Data, Followed, compared, data_of, follow
from longball.judge.quantities import told_by, values_of
from longball.model.readings import SamplingReading
from longball.model.scene import (
    AtBatScene,
    FlightScene,
    ImpactScene,
    Incoming,
    Launch,
    Pitch,
    PitchScene,
    Rotation,
)


def at_bats(count: int = 14) -> list[AtBatScene]:
    base = AtBatScene(id="base")
    return [
        scene for scene in scenes(base, draw(paper_at_bats(SamplingReading()), count, 7)) if scene
    ]


def flights() -> list[FlightScene]:
    """Drives and flies in all directions, and two pop-ups that loop over the vertical."""
    found = []
    for i, degrees in enumerate((5, 20, 35, 50, 65, 80, 86, 89)):
        speed, heading = 32.0 + 2 * i, 0.3 * i - 0.8
        angle = math.radians(degrees)
        velocity = (
            speed * math.cos(angle) * math.cos(heading),
            speed * math.cos(angle) * math.sin(heading),
            speed * math.sin(angle),
        )
        launch = Launch(position=(0.05, 0.1 * i - 0.3, 0.9 + 0.05 * i), velocity=velocity)
        found.append(FlightScene(id=f"flight-{degrees}", launch=launch))
    return found


def impacts() -> list[ImpactScene]:
    found = []
    for i, degrees in enumerate((-40, -10, 15, 40)):
        angle, y = math.radians(degrees), 0.2 * i - 0.3
        position = (0.0696 * math.cos(angle), y, 0.8 + 0.0696 * math.sin(angle))
        incoming = Incoming(position=position, velocity=(-34.0, 0.4 * i, -4.0), bat_height=0.8)
        swing = Rotation(tilt=math.radians(2 + 2 * i))
        found.append(ImpactScene(id=f"impact-{i}", incoming=incoming, swing=swing))
    return found


def pitches() -> list[PitchScene]:
    return [
        PitchScene(id=f"pitch-{i}", pitch=Pitch(speed=30.0 + 3 * i, aim=(0.1 * i - 0.15, 1.8)))
        for i in range(4)
    ]


def known(*families: str) -> list[Any]:
    """Golden cases of families that doubles decide."""
    return [case for family in families for case in load(family) if decidable(case)]


def right(
    cases: Iterable[Any], change: Callable[[str, Any], Any] = lambda quantity, value: value
) -> dict[str, Answer]:
    """Return right answers to cases, with other values of some quantities."""
    answers = {}
    for case in cases:
        values = {q: change(q, value) for q, value in values_of(case.expected).items()}
        told = told_by(case.expected)
        answers[case.id] = Answer(case.id, case.expected.outcome, values, told=told)
    return answers


def truth(cases: Sequence[Any]) -> Data:
    """Return the data of a diagnosis in which every answer is right."""
    return data_of(cases, right(cases))


def planted(
    data: Data, chain: Sequence[Stage], given: Callable[[Any], Mapping[str, Any]]
) -> tuple[Data, Any]:
    """Return answers with other values of some quantities, and the columns that follow.

    `given` computes these values from the columns of the answers in `data`.
    """
    told = given(follow(chain, data)[0])
    told = {q: np.where(np.isfinite(data.given[q]), x, np.nan) for q, x in told.items()}
    data = replace(data, given={**data.given, **told})
    return data, follow(chain, data)[0]


def off(stage: Stage, data: Data, columns: Any) -> Followed:
    """Return the residuals of a stage in all of its scenes."""
    return compared(stage, data, columns, np.flatnonzero(np.isin(columns["kind"], stage.scenes)))[0]


def collected(cases: Iterable[Any], answers: Iterable[Mapping[str, Any]]) -> Collector:
    """Return answers to cases or scenes as a candidate's lines of JSON would arrive."""
    collector = Collector([case.id for case in cases])
    for number, answer in enumerate(answers, 1):
        collector.take_line(number, json.dumps(answer).encode())
    return collector


def answered(scene: Any) -> dict[str, Any]:
    """Return the ivp engine's answer to a scene."""
    answer: dict[str, Any] = json.loads(solve(scene, Ivp()).line())
    return answer
