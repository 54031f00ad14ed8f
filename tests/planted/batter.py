"""Flights and impacts by Gauss-Legendre steps of order 8, which can be told to be wrong.

``python batter.py [--mistake NAME[,NAME]]`` reads a JSON scene per line (flights and impacts), and
writes a JSON result per line. Equations: docs/model.md. mistakes.csv says what each mistake is.
"""

import json
import math
import random
import sys

WRONG = set(sys.argv[2].replace("+", ",").split(",")) if len(sys.argv) > 2 else set()


def gauss_legendre(stages):
    """Return nodes, weights and matrix of the method, from Legendre's polynomial."""
    nodes = []
    for i in range(stages):
        x = math.cos(math.pi * (i + 0.75) / (stages + 0.5))
        for _ in range(50):
            p, q = 1.0, 0.0
            for j in range(stages):
                p, q = ((2 * j + 1) * x * p - j * q) / (j + 1), p
            x -= p * (x * x - 1) / (stages * (x * p - q))
        nodes.append((1 - x) / 2)
    return nodes, *collocation(nodes)


def integral(coefficients, x):
    """Return the integral from 0 to x of a polynomial, lowest power first."""
    return sum(a * x ** (i + 1) / (i + 1) for i, a in enumerate(coefficients))


def collocation(nodes):
    """Return the weights and matrix that integrate the interpolating polynomial exactly."""
    basis = []
    for i, a in enumerate(nodes):
        polynomial = [1.0]
        for j, b in enumerate(nodes):
            if i != j:
                low, high = (
                    [-b * c / (a - b) for c in polynomial],
                    [c / (a - b) for c in polynomial],
                )
                polynomial = [p + q for p, q in zip([*low, 0.0], [0.0, *high])]
        basis.append(polynomial)
    weights = [integral(each, 1.0) for each in basis]
    return weights, [[integral(each, x) for each in basis] for x in nodes]


NODES, WEIGHTS, MATRIX = gauss_legendre(4)
STEP = 0.03


class Air:
    """The law of motion: drag, lift about a horizontal axis fixed at launch, gravity."""

    def __init__(self, scene, velocity):
        ball, air = scene["ball"], scene["air"]
        self.gravity = scene["gravity"]
        if "gravity_or_default" in WRONG:
            self.gravity = scene["gravity"] or 9.8  # 0 counts as absent
        if "air_null_ignored" in WRONG and air is None:
            air = {"density": 1.29, "drag_coefficient": 0.4, "lift_coefficient": 0.2}
        self.air = air is not None
        along = math.hypot(velocity[0], velocity[1])
        self.cos, self.sin = (velocity[0] / along, velocity[1] / along) if along else (1.0, 0.0)
        if not self.air:
            return
        drag, lift = air["drag_coefficient"], air["lift_coefficient"]
        if "lift_or_default" in WRONG:
            lift = lift or 0.2
        if "negative_lift_dropped" in WRONG:
            lift = max(lift, 0.0)
        k = air["density"] * math.pi * ball["radius"] ** 2 / (2 * ball["mass"])
        if "circumference" in WRONG:
            k *= 0.9822  # a radius from 22.8 cm of circumference
        if "buoyancy" in WRONG:
            volume = 4 / 3 * math.pi * ball["radius"] ** 3
            self.gravity *= 1 - air["density"] * volume / ball["mass"]
        if "added_mass" in WRONG:
            volume = 4 / 3 * math.pi * ball["radius"] ** 3
            factor = 1 + 0.5 * air["density"] * volume / ball["mass"]
            k, self.gravity = k / factor, self.gravity / factor
        self.drag, self.lift = k * drag, k * lift
        self.crisis = "drag_crisis" in WRONG

    def acceleration(self, vx, vy, vz):
        if not self.air:
            return 0.0, 0.0, -self.gravity
        speed = math.sqrt(vx * vx + vy * vy + vz * vz)
        drag, lift = self.drag * speed, self.lift * speed
        if self.crisis:
            drag *= 0.7 + 0.3 / (1 + math.exp((speed - 35) / 4))
        if "drag_power" in WRONG:
            drag = self.drag * 35 * (speed / 35) ** 0.9
        if "lift_no_speed_square" in WRONG:
            lift = self.lift * 30
        forward = self.cos * vx + self.sin * vy
        return (
            -drag * vx - lift * self.cos * vz,
            -drag * vy - lift * self.sin * vz,
            -drag * vz + lift * forward - self.gravity,
        )


def step(law, state, h):
    """Return position and velocity after one implicit step."""
    position, velocity = state
    slopes = [law.acceleration(*velocity)] * 4
    for _ in range(40):
        stages = [
            [v + h * sum(a * k[i] for a, k in zip(row, slopes)) for i, v in enumerate(velocity)]
            for row in MATRIX
        ]
        new = [law.acceleration(*stage) for stage in stages]
        change = max(abs(a - b) for x, y in zip(new, slopes) for a, b in zip(x, y))
        slopes = new
        if change < 1e-14 or "one_iteration" in WRONG:
            break
    moved = [x + h * sum(w * s[i] for w, s in zip(WEIGHTS, stages)) for i, x in enumerate(position)]
    if "position_by_mean_velocity" in WRONG:
        last = [
            v + h * sum(w * k[i] for w, k in zip(WEIGHTS, slopes)) for i, v in enumerate(velocity)
        ]
        moved = [x + h * (v + u) / 2 for x, v, u in zip(position, velocity, last)]
    return moved, [
        v + h * sum(w * k[i] for w, k in zip(WEIGHTS, slopes)) for i, v in enumerate(velocity)
    ]


HISTORY = []


def fly(scene):
    """Fly from the launch to the ground."""
    state = scene["launch"]["position"], scene["launch"]["velocity"]
    law, ground, t, n = Air(scene, state[1]), scene["ground"]["height"], 0.0, 0
    if "ground_above_launch" in WRONG:
        ground = abs(ground)
    if "drifting_default" in WRONG:
        HISTORY.append(1)
        law.gravity *= 1 + 1e-7 * len(HISTORY)
    if "noisy_launch" in WRONG:
        state = state[0], [v + random.gauss(0, 1e-6) for v in state[1]]
    size = STEP
    while True:
        h = min(size, scene["time_limit"] - t)
        if h <= 0:
            return {"outcome": "airborne"}
        after = step(law, state, h)
        if after[0][2] <= ground and after[1][2] <= 0:
            break
        n += 1
        state, t = after, (n * size if "clock_rounded" not in WRONG else round(n * size, 1))
    a, b = 0.0, h
    while b - a > 1e-17 and a < (a + b) / 2 < b:
        middle = (a + b) / 2
        a, b = (middle, b) if step(law, state, middle)[0][2] > ground else (a, middle)
        if "bisection_ten" in WRONG and b - a < STEP / 1000:
            break
    position, velocity = step(law, state, b)
    if "bounced" in WRONG:
        velocity = [velocity[0], velocity[1], -0.5 * velocity[2]]
    distance = math.hypot(position[0], position[1])
    if "distance_int" in WRONG:
        distance = float(int(distance))
    landing = {
        "time": t + b,
        "hang_time": t + b,
        "position": position,
        "velocity": velocity,
        "distance": distance,
    }
    if "position_reversed" in WRONG:
        landing["position"] = position[::-1]
    if "landing_nested" in WRONG:
        return {"outcome": "landed", "result": {"landing": landing}}
    if "path_only" in WRONG:
        landing.pop("velocity")
    return {"outcome": "Landed" if "capital_outcome" in WRONG else "landed", "landing": landing}


def strike(scene):
    """Let the impulse act that a touching gives."""
    ball, bat, swing, reading = scene["ball"], scene["bat"], scene["swing"], scene["reading"]
    (x, y, z), v, zb = (scene["incoming"][key] for key in ("position", "velocity", "bat_height"))
    m, big, length, rb = ball["mass"], bat["mass"], bat["length"], bat["radius"]
    omega, tilt = swing["angular_speed"], swing["tilt"]
    if abs(y) >= length / 2:
        return {"outcome": "beyond_bat"}
    away = math.hypot(x, z - zb)
    n = [x / away, 0.0, (z - zb) / away]
    lever = length / 2 - y
    if "omega_rpm" in WRONG:
        omega *= math.pi / 30
    bat_velocity = [omega * lever * math.cos(tilt), 0.0, omega * lever * math.sin(tilt)]
    if "tilt_sine_cosine" in WRONG:
        bat_velocity = bat_velocity[::-1]
    if "lever_to_surface" in WRONG:
        bat_velocity = [each * (1 + rb) for each in bat_velocity]
    closing = sum((a - b) * c for a, b, c in zip(v, bat_velocity, n))
    shown = [x - ball["radius"] * n[0], y, z - ball["radius"] * n[2]]
    contact = {
        "position": shown if "contact_on_surface" in WRONG else [x, y, z],
        "normal": n,
        "bat_velocity": bat_velocity,
        "normal_speed": abs(closing) if "normal_speed_abs" in WRONG else closing,
    }
    if closing >= 0:
        return {"outcome": "separating", "contact": contact}
    inertia = {
        "thin_rod": big * length**2 / 3,
        "about_centre": big * (length**2 / 12 + rb**2 / 4),
    }.get(reading.get("inertia"), big * (length**2 / 3 + rb**2 / 4))
    if "inertia_with_diameter" in WRONG:
        inertia = big * (length**2 / 3 + rb**2)
    effective = inertia / lever ** (1 if reading.get("effective_mass") == "as_printed" else 2)
    kind = reading.get("bat_ball_restitution", "as_printed")
    e, ratio = ball["restitution"], m / effective
    if "restitution_of_speed" in WRONG:
        e -= 0.001 * (abs(closing) - 40)
    restitution = e * (1 + ratio) + ratio if kind == "as_printed" else e
    if "ratio_forgotten" in WRONG and kind == "as_printed":
        restitution = e * (1 + ratio)
    mass = (
        effective
        if kind == "nathan" or (kind != "plain" and reading.get("reduced_mass") == "effective_mass")
        else big
    )
    mu = m * mass / (m + mass)
    if "mu_squared" in WRONG:
        mu = m * mass / math.sqrt(m * m + mass * mass)
    impulse = -mu * (1 + restitution) * closing
    after = [a + impulse / m * b for a, b in zip(v, n)]
    if "after_without_y" in WRONG:
        after[1] = 0.0
    energy = -mu * (1 - restitution**2) * closing**2 / 2
    if "energy_e_not_squared" in WRONG:
        energy = -mu * (1 - restitution) * closing**2 / 2
    impact = {
        "restitution": restitution,
        "impulse": impulse,
        "velocity": after,
        "energy_change": energy,
    }
    return {"outcome": "struck", "contact": contact, "impact": impact}


for line in sys.stdin:
    scene = json.loads(line)
    result = fly(scene) if scene["kind"] == "flight" else strike(scene)
    identity = {} if "id_missing" in WRONG else {"id": scene["id"]}
    if "stops_early" in WRONG and scene["id"].endswith("0030"):
        sys.exit(1)
    print(json.dumps(identity | result), flush=True)
