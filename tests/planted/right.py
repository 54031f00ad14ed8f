"""A simulator that is right but for its own accuracy, which can be made as poor as one likes.

    python right.py [--step 0.01] [--rtol 1e-6] [--digits 6] [--float32]

Flights, pitches, impacts and at-bats of the paper's model by its default readings. All scenes that
are read are flown side by side: by Runge and Kutta's method in fixed steps, or in pairs of steps
whose difference is held below `--rtol`. Nothing of longball is used.
"""

import argparse
import json
import sys

import numpy as np


def rates(y, law):
    """The derivative of (r, v), a column a ball."""
    k_drag, k_lift, g, ahead = law
    v = y[3:]
    speed = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    along = v[0] * ahead[0] + v[1] * ahead[1]
    up = np.stack([-v[2] * ahead[0], -v[2] * ahead[1], along])
    a = -k_drag * speed * v + k_lift * speed * up
    a[2] -= g
    return np.concatenate([v, a])


def step(y, h, law):
    a = rates(y, law)
    b = rates(y + h / 2 * a, law)
    c = rates(y + h / 2 * b, law)
    d = rates(y + h * c, law)
    return y + h / 6 * (a + 2 * b + 2 * c + d)


def column(scenes, *path):
    """The numbers or vectors of scenes at a path of keys; 0 where there is none."""
    found = []
    for part in scenes:
        for key in path:
            part = (part or {}).get(key, 0.0)
        found.append(part)
    return np.array(found, dtype=OPTIONS.type).T


def law_of(scenes, v):
    k = np.pi * column(scenes, "air", "density") * column(scenes, "ball", "radius") ** 2
    k = (k / (2 * column(scenes, "ball", "mass"))).astype(OPTIONS.type)
    level = np.hypot(v[0], v[1])
    ahead = np.where(level > 0, v[:2] / np.where(level > 0, level, 1), [[1.0], [0.0]])
    drag, lift = (k * column(scenes, "air", f"{side}_coefficient") for side in ("drag", "lift"))
    return drag, lift, column(scenes, "gravity"), ahead.astype(OPTIONS.type)


def taken(law, some):
    return tuple(part[..., some] for part in law)


def until(y, law, gauge, longest, first=None):
    """Fly until a gauge of the state falls to 0; time (inf if never) and state."""
    count, real = y.shape[1], OPTIONS.type
    time, clock, ended = np.full(count, np.inf, real), np.zeros(count, real), y.copy()
    h = np.full(count, first or OPTIONS.step, real)
    flying = np.arange(count)
    while len(flying):
        now, own, hs = y[:, flying], taken(law, flying), h[flying]
        after = step(now, hs, own)
        if OPTIONS.rtol and not first:
            twice = step(step(now, hs / 2, own), hs / 2, own)
            error = np.abs(twice - after).max(axis=0) / (1 + np.abs(twice).max(axis=0))
            h[flying] = hs * np.clip(0.9 * (OPTIONS.rtol / (error + 1e-30)) ** 0.2, 0.2, 3.0)
            good = (error <= OPTIONS.rtol) | (hs < 1e-5)
            flying, now, own = flying[good], now[:, good], taken(own, good)
            hs, after = hs[good], twice[:, good]
        value = gauge(after, flying)
        down = (value <= 0) & (gauge(now, flying) > 0)
        down |= (value <= 0) & (after[5] < 0) & (clock[flying] == 0)
        if down.any():
            some, start, part = flying[down], now[:, down], taken(own, down)
            low, high = np.zeros(len(some), real), hs[down]
            for _ in range(60):
                middle = (low + high) / 2
                above = gauge(step(start, middle, part), some) > 0
                low, high = np.where(above, middle, low), np.where(above, high, middle)
            time[some], ended[:, some] = clock[some] + high, step(start, high, part)
        y[:, flying] = after
        clock[flying] += hs
        flying = np.flatnonzero(np.isinf(time) & (clock < longest))
    time[time > longest] = np.inf
    return time, ended


def pitched(scenes):
    """Position and velocity at the release."""
    r = column(scenes, "pitch", "release")
    toward = np.concatenate([0 * r[:1], column(scenes, "pitch", "aim")]) - r
    v = column(scenes, "pitch", "speed") * toward / np.sqrt((toward**2).sum(axis=0))
    return np.concatenate([r, v]), law_of(scenes, v)


def plates(scenes, results):
    start, law = pitched(scenes)
    limit, ground = column(scenes, "time_limit"), column(scenes, "ground", "height")
    time, y = until(start.copy(), law, lambda y, _: y[0], limit)
    fallen, _ = until(start.copy(), law, lambda y, some: y[2] - ground[some], limit)
    for i, result in enumerate(results):
        result["outcome"] = "crossed" if time[i] < fallen[i] else "grounded"
        if np.isinf(time[i]) and np.isinf(fallen[i]):
            result["outcome"] = "airborne"
        if result["outcome"] == "crossed":
            result["plate"] = {"time": time[i], "position": y[:3, i], "velocity": y[3:, i]}
    return start, law, y


def landings(scenes, results, y, law, begun):
    ground = column(scenes, "ground", "height")
    limit = column(scenes, "time_limit") - begun
    time, y = until(y.copy(), law, lambda y, some: y[2] - ground[some], limit)
    for i, result in enumerate(results):
        result["outcome"] = "airborne" if np.isinf(time[i]) else result["outcome"]
        if np.isfinite(time[i]):
            result["landing"] = {"time": begun[i] + time[i], "hang_time": time[i],
                                 "position": y[:3, i], "velocity": y[3:, i],
                                 "distance": np.hypot(y[0, i], y[1, i])}  # fmt: skip


def impacts(scenes, results, y, height):
    """Strike the balls; return their velocities after."""
    r, v = y[:3], y[3:]
    m, e = column(scenes, "ball", "mass"), column(scenes, "ball", "restitution")
    big, length, thick = (column(scenes, "bat", key) for key in ("mass", "length", "radius"))
    away = np.hypot(r[0], r[2] - height)
    n = np.stack([r[0] / away, 0 * away, (r[2] - height) / away])
    lever, tilt = length / 2 - r[1], column(scenes, "swing", "tilt")
    bat = column(scenes, "swing", "angular_speed") * lever
    bat = bat * np.stack([np.cos(tilt), 0 * tilt, np.sin(tilt)])
    closing = ((v - bat) * n).sum(axis=0)
    share = m * lever**2 / (big * (length**2 / 3 + thick**2 / 4))
    restitution, reduced = e * (1 + share) + share, m * big / (m + big)
    impulse = -reduced * (1 + restitution) * closing
    after = v + impulse / m * n
    energy = -reduced * (1 - restitution**2) * closing**2 / 2
    for i, result in enumerate(results):
        result.setdefault("contact", {})
        result["contact"] |= {"position": r[:, i], "normal": n[:, i], "bat_velocity": bat[:, i],
                              "normal_speed": closing[i]}  # fmt: skip
        result["outcome"] = "struck" if closing[i] < 0 else "separating"
        if abs(r[1, i]) >= length[i] / 2:
            result["outcome"] = "beyond_bat"
            result["contact"] = {key: result["contact"][key] for key in ("time", "position")
                                 if key in result["contact"]}  # fmt: skip
        elif closing[i] < 0:
            result["impact"] = {"restitution": restitution[i], "impulse": impulse[i],
                                "velocity": after[:, i], "energy_change": energy[i]}  # fmt: skip
    return after


def at_bats(scenes, results):
    start, law, plate = plates(scenes, results)
    some = np.array([i for i, x in enumerate(results) if x["outcome"] == "crossed"], dtype=int)
    height = plate[2] + column(scenes, "swing", "height_offset")
    reach = column(scenes, "ball", "radius") + column(scenes, "bat", "radius")
    height, reach = height[some], reach[some]
    scenes, results = [scenes[i] for i in some], [results[i] for i in some]

    def gap(y, these):
        outside = np.hypot(y[0], y[2] - height[these]) - reach[these]
        return np.where(y[0] < -reach[these], np.abs(outside) + 1e-9, outside)

    # To where the ball may meet the bat, and on in steps that it cannot meet it between.
    law, start = taken(law, some), start[:, some]
    before, y = until(start, law, lambda y, these: y[0] - reach[these], 60.0 + 0 * reach)
    time, y = until(y, law, gap, 0.02 + 0 * reach, 1e-4)
    time = before + time
    for i, result in enumerate(results):
        result["outcome"] = "missed"
        if np.isfinite(time[i]):
            result["contact"] = {"time": time[i]}
    met = np.flatnonzero(np.isfinite(time))
    scenes, results = [scenes[i] for i in met], [results[i] for i in met]
    after = impacts(scenes, results, y[:, met], height[met])
    hit = np.array([i for i, x in enumerate(results) if x["outcome"] == "struck"], dtype=int)
    scenes, results, after = [scenes[i] for i in hit], [results[i] for i in hit], after[:, hit]
    for result in results:
        result["outcome"] = "batted"
    begun = np.concatenate([y[:3, met][:, hit], after])
    landings(scenes, results, begun, law_of(scenes, after), time[met][hit])


def flights(scenes, results):
    r, v = column(scenes, "launch", "position"), column(scenes, "launch", "velocity")
    for result in results:
        result["outcome"] = "landed"
    begun = np.zeros(len(scenes), OPTIONS.type)
    landings(scenes, results, np.concatenate([r, v]), law_of(scenes, v), begun)


def struck(scenes, results):
    y = [column(scenes, "incoming", key) for key in ("position", "velocity")]
    impacts(scenes, results, np.concatenate(y), column(scenes, "incoming", "bat_height"))


def written(value):
    if isinstance(value, dict):
        return {key: written(x) for key, x in value.items()}
    if isinstance(value, np.ndarray):
        return [written(x) for x in value]
    return value if isinstance(value, str) else float(f"{value:.{OPTIONS.digits}g}")


def main():
    every = [json.loads(line) for line in sys.stdin]
    for scene in [scene for scene in every if scene["reading"]]:
        print(json.dumps({"id": scene["id"], "error": "only default readings are known"}))
        every.remove(scene)
    solvers = {"flight": flights, "pitch": plates, "impact": struck, "at-bat": at_bats}
    for kind, solve in solvers.items():
        scenes = [scene for scene in every if scene["kind"] == kind]
        for i in range(0, len(scenes), 64):
            some = scenes[i : i + 64]
            results = [{"id": scene["id"]} for scene in some]
            solve(some, results)
            for result in results:
                print(json.dumps(written(result)), flush=True)


parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
parser.add_argument("--step", type=float, default=0.01, help="s; with --rtol the first one")
parser.add_argument("--rtol", type=float, help="error of a step, relative to the state")
parser.add_argument("--digits", type=int, default=17)
parser.add_argument(
    "--float32", dest="type", action="store_const", const=np.float32, default=np.float64
)
OPTIONS = parser.parse_args()

if __name__ == "__main__":
    main()
