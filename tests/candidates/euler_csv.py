"""Flights of the paper's model by Euler's method, as CSV: euler_csv.py STEP DIGITS."""

import csv
import math
import sys

step, digits = float(sys.argv[1]), int(sys.argv[2])


def landing(scene: dict[str, str]) -> list[float]:
    """Return the time of the landing, s, its place and its distance, m."""

    def number(name: str) -> float:
        return float(scene[name] or 0.0)

    x, y, z = (number(f"launch.position[{i}]") for i in range(3))
    u, v, w = (number(f"launch.velocity[{i}]") for i in range(3))
    floor, gravity = number("ground.height"), number("gravity")
    area = math.pi * number("ball.radius") ** 2
    k = number("air.density") * area / (2 * number("ball.mass"))
    drag, lift = k * number("air.drag_coefficient"), k * number("air.lift_coefficient")
    level = math.hypot(u, v)
    ahead, aside = (u / level, v / level) if level else (1.0, 0.0)  # the heading at the launch
    time = 0.0
    while True:
        speed, level = math.hypot(u, v, w), u * ahead + v * aside
        last, x, y, z = (x, y, z), x + step * u, y + step * v, z + step * w
        a = -drag * speed * u - lift * speed * w * ahead
        b = -drag * speed * v - lift * speed * w * aside
        c = -drag * speed * w + lift * speed * level - gravity
        u, v, w, time = u + step * a, v + step * b, w + step * c, time + step
        if z <= floor < last[2]:
            part = (last[2] - floor) / (last[2] - z)
            x, y = (old + part * (new - old) for old, new in zip(last, (x, y), strict=False))
            return [time - step + part * step, x, y, floor, math.hypot(x, y)]


names = ["landing.time", *(f"landing.position[{i}]" for i in range(3)), "landing.distance"]
print(",".join(["id", "outcome", *names]))
for row in csv.DictReader(sys.stdin):
    print(row["id"], "landed", *(f"{x:.{digits}g}" for x in landing(row)), sep=",", flush=True)
