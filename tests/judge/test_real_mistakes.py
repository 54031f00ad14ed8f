"""Mistakes with spin, wind, weather, friction and fences, made by a program of its own.

`tests/candidates/real_ball.py` knows nothing of longball.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import pytest

from longball.golden import load
from longball.judge.answers import Answer, Collector
from longball.judge.cases import Case, decidable
from longball.judge.diagnosis import FINE, diagnose
from longball.judge.findings import Finding
from tests.candidates.real_ball import solve as simulate

FAMILIES = (
    "flight-spin-lift", "flight-spin-drag", "flight-spin-decay", "flight-wind", "flight-weather",
    "fence", "impact-oblique",
)  # fmt: skip


def known(case: Case) -> bool:
    """Tell whether the other program's model has a scene."""
    data = json.loads(case.scene.line())
    air, fence = data.get("air") or {}, data.get("fence") or {}
    wind, spin = air.get("wind"), data.get("launch", data.get("incoming", {})).get("spin")
    laws = [air.get(f"{way}_coefficient", 0.0) for way in ("drag", "lift")]
    return (
        decidable(case)
        and case.scene.kind in ("flight", "impact")
        and not case.scene.reading.model_dump()
        and not {"air", "earth"} & {key for key, value in data.items() if value is None}
        and not (wind and isinstance(wind, dict))
        and not air.get("density_scale_height")
        and (spin is None or any(spin))
        and not any(isinstance(c, dict) and c["law"] not in ("constant", "spin", "rational",
                                                             "linear") for c in laws)
        and ("fence" not in data or "polyline" in fence)
        and data.get("bat", {}).get("support") != "free"
        and data.get("bat", {"friction": 1}).get("friction") is not None
        and case.expected.outcome in ("landed", "struck", "home_run", "wall")
    )  # fmt: skip


@pytest.fixture(scope="module")
def gold() -> dict[str, list[Case]]:
    """Return a few cases of each family that the other program's model has."""
    return {family: [case for case in load(family) if known(case)][:5] for family in FAMILIES}


def answers(cases: Sequence[Case], mistake: str = "") -> dict[str, Answer]:
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        result = simulate(json.loads(case.scene.line()), mistake)
        collector.take_line(number, json.dumps(result).encode())
    return collector.answers


def found(cases: Sequence[Case], mistake: str = "") -> list[Finding]:
    findings = diagnose(cases, answers(cases, mistake)).findings
    return [f for f in findings if f.worst > FINE and f.stage != "outcome"]


def test_without_a_mistake_the_other_program_agrees(gold: dict[str, list[Case]]):
    cases = [case for some in gold.values() for case in some[:2]]
    assert len(cases) > 10
    assert found(cases) == []


NAMES = {
    "spin in rpm": ("impact-oblique", "spin*0.10472"),
    "spin sign": ("impact-oblique", "spin:(-x, -y, -z)"),
    "diameter": ("flight-spin-lift", "spin*2"),
    "total spin": ("flight-spin-lift", "spin_parameter=total"),
    "wind sign": ("flight-wind", "air.wind:(-x, -y, -z)"),
    "wind not in the lift": ("flight-wind", "wind_acts_on=drag"),
    "celsius": ("flight-weather", "celsius-for-kelvin"),
    "percent": ("flight-weather", "air.density.humidity*0.01"),
    "station pressure": ("flight-weather", "air.density.elevation*0"),
    "decay in time": ("flight-spin-decay", "spin_decay=time"),
    "fence by angle": ("fence", "fence-by-angle"),
    "slip without spin": ("impact-oblique", "friction-without-spin"),
}


@pytest.mark.parametrize(("mistake", "family", "name"), [(m, *e) for m, e in NAMES.items()])
def test_a_mistake_is_named(gold: dict[str, list[Case]], mistake: str, family: str, name: str):
    first = next(iter(found(gold[family], mistake)))
    assert first.kind == "named", first.sentence
    assert name in first.names
