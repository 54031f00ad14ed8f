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
FEWER = 100_000  # with derivatives
NUMBERS = [*(f"launch.velocity[{i}]" for i in range(3)), "gravity", "air.density", "ball.mass"]
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


def flights(count: int) -> dict[str, object]:
    """Return so many launches in columns."""
    rng = np.random.default_rng(1)
    return {
        "kind": "flight",
        "launch.position": [0.0, 0.0, 1.0],
        "launch.velocity[0]": rng.uniform(20.0, 40.0, count),
        "launch.velocity[1]": rng.uniform(-5.0, 5.0, count),
        "launch.velocity[2]": rng.uniform(10.0, 30.0, count),
    }


def with_derivatives() -> float:
    """Return the time that flights in columns take with derivatives, relative to that without."""
    columns = flights(FEWER)
    plain = best(lambda: lb.solve_many(columns, workers=1))
    return best(lambda: lb.solve_many(columns, workers=1, derivatives=NUMBERS)) / plain


def main() -> None:
    """Measure, and print a line for each."""
    flight, at_bat = lb.Flight(launch=lb.launch(speed=46.0, angle=0.5)), lb.AtBat()
    columns = flights(COUNT)
    command = [sys.executable, "-m", "longball", "solve", "--quiet"]
    tasks: list[tuple[str, float, str]] = [
        ("lb.solve(flight)", 1e3 * best(lambda: lb.solve(flight), 100), "ms"),
        ("lb.solve(at_bat)", 1e3 * best(lambda: lb.solve(at_bat), 100), "ms"),
        (
            "lb.solve_many(columns), a flight",
            1e6 / COUNT * best(lambda: lb.solve_many(columns)),
            "µs",
        ),
        ("the same with derivatives by six", with_derivatives(), "times"),
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
