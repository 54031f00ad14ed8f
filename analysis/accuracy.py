"""Speed and error of the reference engine, beside plain solve_ivp with scipy's own events."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import scipy.integrate

from analysis.writing import table
from longball import engines
from longball.engines.at_bat import solve
from longball.engines.ivp import Ivp
from longball.home_run import draw, paper_at_bats, scenes
from longball.model.motion import acceleration, forces, into_plane
from longball.model.numbers import DOUBLES
from longball.model.readings import SamplingReading
from longball.model.result import Result
from longball.model.scene import AtBatScene, FlightScene, Launch

COUNT, FULL_COUNT = 60, 600  # at-bats that are batted
SEED = 7
ROUNDS = 9  # interleaved repetitions of each timing
PLAIN_TOLERANCES = (1e-6, 1e-9, 1e-12)


def run(report: Path, full: bool) -> str:
    """Measure on batted balls of the paper's distributions."""
    at_bats = batted(FULL_COUNT if full else COUNT)
    flights = [flight_of(scene, result) for scene, result in at_bats]
    truth = [solve(flight, engines.create("enclosure", digits=20)) for flight in flights]
    candidates: dict[str, Callable[[FlightScene], tuple[float, float]]] = {
        f"solve_ivp DOP853 {rtol:g}, its own event": partial(plain_landing, rtol=rtol)
        for rtol in PLAIN_TOLERANCES
    }
    for rtol in (1e-9, 1e-12, Ivp().rtol):
        candidates[f"longball ivp DOP853 {rtol:g}"] = partial(
            landing, engine=Ivp(rtol=rtol, atol=rtol)
        )
    seconds = interleaved(candidates, flights)
    unit = seconds["solve_ivp DOP853 1e-12, its own event"]
    rows = []
    for name, candidate in candidates.items():
        d, t = errors(candidate, flights, truth)
        rows.append(
            {
                "method": name,
                "worst error of D, m": f"{max(d):.1e}",
                "median, m": f"{statistics.median(d):.1e}",
                "worst error of time, s": f"{max(t):.1e}",
                "time a flight, ratio": f"{seconds[name] / unit:.2f}",
            }
        )
    return "\n".join(
        [
            "## The reference engine: speed against error\n",
            f"Landings of {len(flights)} batted balls of the paper's distributions (seed {SEED}), "
            "held against 20 digits with proven bounds. Times are medians of "
            f"{ROUNDS} interleaved rounds on one thread, as ratios to plain `solve_ivp` at a "
            "tolerance of 1e-12 (`python -m analysis accuracy`).\n",
            table(report, "accuracy", pd.DataFrame(rows)),
            at_bat_errors(report, at_bats),
        ]
    )


def batted(count: int) -> list[tuple[AtBatScene, Result]]:
    """Return the first batted at-bats of a seed."""
    base = AtBatScene(id="base")
    found = []
    for scene in scenes(base, draw(paper_at_bats(SamplingReading()), 2 * count, SEED)):
        assert scene is not None
        result = solve(scene, Ivp())
        if result.outcome == "batted":
            found.append((scene, result))
    return found[:count]


def flight_of(scene: AtBatScene, result: Result) -> FlightScene:
    """Return the flight of a batted ball as a scene of its own."""
    assert result.contact is not None
    assert result.contact.position is not None
    assert result.impact is not None
    x, y, z = map(float, result.contact.position)
    u, v, w = map(float, result.impact.velocity)
    return FlightScene(id=scene.id, launch=Launch(position=(x, y, z), velocity=(u, v, w)))


def plain_landing(flight: FlightScene, rtol: float) -> tuple[float, float]:
    """Return D and time of landing by solve_ivp as its manual shows it, with an event z = 0."""
    plane, start = into_plane(flight.launch.position, flight.launch.velocity, DOUBLES)
    field = forces(flight.ball, flight.air, flight.gravity, False, DOUBLES)
    accelerate = acceleration(field, DOUBLES)

    def right_hand_side(_: float, y: np.ndarray) -> tuple[float, ...]:
        _, _, u, w = y.tolist()
        return (u, w, *accelerate(u, w))

    def ground(_: float, y: np.ndarray) -> float:
        return float(y[1])

    ground.terminal = True  # type: ignore[attr-defined]
    ground.direction = -1  # type: ignore[attr-defined]
    solution = scipy.integrate.solve_ivp(
        right_hand_side,
        (0.0, flight.time_limit),
        start,
        method="DOP853",
        rtol=rtol,
        atol=rtol,
        events=ground,
    )
    s = float(solution.y[0, -1])
    return math.hypot(plane.x + plane.cos * s, plane.y + plane.sin * s), float(solution.t[-1])


def landing(flight: FlightScene, engine: Ivp) -> tuple[float, float]:
    """Return D and time of landing by the reference engine."""
    landed = solve(flight, engine).landing
    assert landed is not None
    return float(landed.distance), float(landed.time)


def errors(
    candidate: Callable[[FlightScene], tuple[float, float]],
    flights: list[FlightScene],
    truth: list[Result],
) -> tuple[list[float], list[float]]:
    """Return the errors of D and of the landing's time."""
    distances, times = [], []
    for flight, true in zip(flights, truth, strict=True):
        assert true.landing is not None
        d, t = candidate(flight)
        distances.append(abs(d - float(true.landing.distance)))
        times.append(abs(t - float(true.landing.time)))
    return distances, times


def interleaved(
    candidates: dict[str, Callable[[FlightScene], tuple[float, float]]], flights: list[FlightScene]
) -> dict[str, float]:
    """Return the median time of each candidate for all flights, s, over interleaved rounds."""
    seconds: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(ROUNDS):
        for name, candidate in candidates.items():
            start = time.perf_counter()
            for flight in flights:
                candidate(flight)
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}


def at_bat_errors(report: Path, at_bats: list[tuple[AtBatScene, Result]]) -> str:
    """Return the errors of plate, contact and landing of whole at-bats."""
    exact = engines.create("enclosure", digits=20)
    worst: dict[str, float] = {}
    for scene, result in at_bats:
        for name, error in differences(result, solve(scene, exact)).items():
            worst[name] = max(worst.get(name, 0.0), error)
    frame = pd.DataFrame(
        {"quantity": list(worst), "worst error": [f"{error:.1e}" for error in worst.values()]}
    )
    return (
        f"Whole at-bats, the same {len(at_bats)}, by the reference engine at its default "
        "tolerance:\n\n" + table(report, "accuracy_at_bats", frame)
    )


def differences(result: Result, true: Result) -> dict[str, float]:
    """Return how far the quantities of two results are apart: m, s, m/s."""
    assert result.plate is not None
    assert true.plate is not None
    assert result.contact is not None
    assert true.contact is not None
    assert result.landing is not None
    assert true.landing is not None
    assert result.impact is not None
    assert true.impact is not None
    pairs = {
        "plate, time, s": (result.plate.time, true.plate.time),
        "plate, height, m": (result.plate.position[2], true.plate.position[2]),
        "contact, time, s": (result.contact.time, true.contact.time),
        "contact, margin, m": (result.contact.margin, true.contact.margin),
        "impact, velocity x, m/s": (result.impact.velocity[0], true.impact.velocity[0]),
        "impact, velocity z, m/s": (result.impact.velocity[2], true.impact.velocity[2]),
        "landing, time, s": (result.landing.time, true.landing.time),
        "landing, distance, m": (result.landing.distance, true.landing.distance),
    }
    return {
        name: abs(float(ours) - float(truth))
        for name, (ours, truth) in pairs.items()
        if ours is not None and truth is not None
    }
