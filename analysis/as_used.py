"""Waiting times: a scene in Python, a million in columns, a command.

``python -m analysis.as_used`` takes half a minute. Of each the best of some rounds is printed: what
else a machine does only adds to it.
"""

import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np

import longball as lb

ROUNDS = 7
COUNT = 1_000_000  # flights in columns
SCENE = '{"kind": "flight", "launch": {"position": [0, 0, 1], "velocity": [30, 0, 25]}}'


def best(task: Callable[[], object], repeats: int = 1) -> float:
    """Return the shortest time, s, that a task takes, of some rounds of so many repeats."""
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        for _ in range(repeats):
            task()
        times.append((time.perf_counter() - begin) / repeats)
    return min(times)


def main() -> None:
    """Measure, and print a line for each."""
    flight, at_bat = lb.Flight(launch=lb.launch(speed=46.0, angle=0.5)), lb.AtBat()
    rng = np.random.default_rng(1)
    columns = {
        "kind": "flight",
        "launch.position": [0.0, 0.0, 1.0],
        "launch.velocity[0]": rng.uniform(20.0, 40.0, COUNT),
        "launch.velocity[1]": rng.uniform(-5.0, 5.0, COUNT),
        "launch.velocity[2]": rng.uniform(10.0, 30.0, COUNT),
    }
    command = [sys.executable, "-m", "longball", "solve", "--quiet"]
    tasks: list[tuple[str, float, str]] = [
        ("lb.solve(flight)", 1e3 * best(lambda: lb.solve(flight), 100), "ms"),
        ("lb.solve(at_bat)", 1e3 * best(lambda: lb.solve(at_bat), 100), "ms"),
        (
            "lb.solve_many(columns), a flight",
            1e6 / COUNT * best(lambda: lb.solve_many(columns)),
            "µs",
        ),
        (
            "longball solve, one flight",
            best(lambda: subprocess.run(command, input=SCENE, capture_output=True, text=True)),
            "s",
        ),
    ]
    for name, value, unit in tasks:
        print(f"{name:34}{value:8.2g} {unit}")


if __name__ == "__main__":
    main()
