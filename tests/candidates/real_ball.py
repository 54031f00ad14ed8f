"""A simulator of spin, wind, weather, friction and fences, with mistakes that authors make.

``python real_ball.py MISTAKE < scenes > results``. Written from the model's formulas, in space and
in plain Python: Runge and Kutta's method in short steps, the last one as long as it takes. What it
does wrong is looked up by the mistake's name where it would be done right.
"""

import itertools
import json
import math
import sys

H = 0.01  # s


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def size(a):
    return math.sqrt(dot(a, a))


def add(a, b, factor=1.0):
    return [x + factor * y for x, y in zip(a, b)]


def times(a, factor):
    return [factor * x for x in a]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def density(air, wrong):
    given = air["density"]
    if not isinstance(given, dict):
        return given
    kelvin = given["temperature"] + (273.15 if wrong == "celsius" else 0.0)
    t = kelvin - 273.15
    vapour = 611.16 * math.exp((18.687 - t / 234.5) * t / (257.14 + t))
    humidity = given["humidity"] * (0.01 if wrong == "percent" else 1.0)
    beta = 0.0 if wrong == "station pressure" else 1.217e-4
    pressure = given["pressure"] * math.exp(-beta * given["elevation"])
    return 1.2929 * 273.15 / kelvin * (pressure - 0.3783 * humidity * vapour) / 101325


def coefficient(given, key):
    return given.get(key, 0.0) if isinstance(given, dict) else given if key == "value" else 0.0


class Flight:
    """The law of motion of a ball with position, velocity and the path that it has flown."""

    def __init__(self, scene, spin, heading, wrong):
        air, ball = scene["air"], scene["ball"]
        self.gravity, self.spin, self.wrong = scene["gravity"], spin, wrong
        self.radius, self.wind = ball["radius"], air.get("wind") or [0.0, 0.0, 0.0]
        if wrong in ("wind sign", "no wind"):
            self.wind = times(self.wind, -1.0 if wrong == "wind sign" else 0.0)
        self.k = density(air, wrong) * math.pi * self.radius**2 / (2 * ball["mass"])
        self.drag, self.lift = air["drag_coefficient"], air["lift_coefficient"]
        self.decay = 1 / air["spin_decay_length"] if air.get("spin_decay_length") else 0.0
        self.axis = [heading[1], -heading[0], 0.0]

    def magnus(self, u, left):
        """k_L U² along ω × u; without spin about the horizontal axis of the launch."""
        speed = size(u)
        if self.spin is None:
            lift = self.k * coefficient(self.lift, "value")
            return times(cross(self.axis, u), lift * speed)
        spin = times(self.spin, left)
        across = cross(spin, u)
        if not size(across):
            return [0.0, 0.0, 0.0]
        turning = size(spin) if self.wrong == "total spin" else size(across) / speed
        s = self.radius * turning / speed * (2.0 if self.wrong == "diameter" else 1.0)
        law = self.lift.get("law") if isinstance(self.lift, dict) else None
        if law == "rational":
            c = self.lift["numerator"] * s / (self.lift["constant"] + self.lift["slope"] * s)
        else:
            c = self.lift["slope"] * s if law == "linear" else coefficient(self.lift, "value")
        along = turning * speed if self.wrong == "total spin" else size(across)
        return times(across, self.k * c * speed**2 / along)

    def rates(self, state):
        velocity = state[3:6]
        u = add(velocity, self.wind, -1.0)
        speed = size(u)
        left = math.exp(-self.decay * state[6])
        drag = coefficient(self.drag, "value") + coefficient(self.drag, "constant")
        if self.spin is not None and coefficient(self.drag, "per_spin"):
            spin = times(self.spin, left)
            turning = size(spin) if self.wrong == "total spin" else size(cross(spin, u)) / speed
            drag += self.drag["per_spin"] * turning
        a = times(u, -self.k * drag * speed)
        a = add(a, self.magnus(velocity if self.wrong == "wind not in the lift" else u, left))
        flown = 44.704 if self.wrong == "decay in time" else speed
        return [*velocity, a[0], a[1], a[2] - self.gravity, flown]

    def step(self, state, h):
        a = self.rates(state)
        b = self.rates(add(state, a, h / 2))
        c = self.rates(add(state, b, h / 2))
        d = self.rates(add(state, c, h))
        return [x + h * (p + 2 * q + 2 * r + s) / 6 for x, p, q, r, s in zip(state, a, b, c, d)]

    def until(self, state, value, time=0.0):
        """Fly until a value of the state falls to zero; return when, and the state."""
        while time < 60.0:
            after = self.step(state, H)
            if value(after) <= 0.0:
                low, high = 0.0, H
                for _ in range(50):
                    middle = (low + high) / 2
                    low, high = (
                        (middle, high) if value(self.step(state, middle)) > 0.0 else (low, middle)
                    )
                return time + high, self.step(state, high)
            state, time = after, time + H
        return None


def turned(scene, block, wrong):
    spin = scene[block].get("spin")
    if spin is None:
        return None
    reverse = wrong == "spin sign" or (
        wrong == "pitches spin the other way" and block in ("pitch", "incoming")
    )
    return times(spin, -1.0 if reverse else math.pi / 30 if wrong == "spin in rpm" else 1.0)


def flight(scene, wrong):
    launch = scene["launch"]
    velocity = list(launch["velocity"])
    level = math.hypot(*velocity[:2])
    ball = Flight(scene, turned(scene, "launch", wrong), [v / level for v in velocity[:2]], wrong)
    start = [*launch["position"], *velocity, 0.0]
    result, floor = {"outcome": "landed"}, scene.get("ground", {"height": 0.0})["height"]
    time, state = ball.until(start, lambda s: s[2] - floor)
    if scene.get("fence"):
        met = fence(scene, ball, start, time, wrong)
        if met:
            result["fence"] = met
            result["outcome"] = "home_run" if met["clearance"] > 0 else "wall"
    if result["outcome"] != "wall":
        x, y, z = state[:3]
        result["landing"] = {"time": time, "hang_time": time, "position": [x, y, z],
                             "velocity": state[3:6], "distance": math.hypot(x, y)}  # fmt: skip
        if ball.spin is not None:
            left = math.exp(-ball.decay * state[6])
            result["landing"]["spin"] = times(ball.spin, left)
    return result


def fence(scene, ball, start, landed, wrong):
    """The first chord that the ball flies out over, before it lands."""
    vertices, found = scene["fence"]["polyline"], None
    if wrong == "fence by angle":
        bent = []
        for (ax, ay, a), (bx, by, b) in itertools.pairwise(vertices):
            for i in range(50):
                q = i / 50
                r = math.hypot(ax, ay) * (1 - q) + math.hypot(bx, by) * q
                angle = math.atan2(ay, ax) * (1 - q) + math.atan2(by, bx) * q
                bent.append([r * math.cos(angle), r * math.sin(angle), a + (b - a) * q])
        vertices = [*bent, vertices[-1]]
    chords, time, state = list(itertools.pairwise(vertices)), 0.0, start
    while time < landed:
        after = ball.step(state, H)
        for (ax, ay, a), (bx, by, b) in chords:

            def inside(s, ax=ax, ay=ay, bx=bx, by=by):
                return (by - ay) * (s[0] - ax) - (bx - ax) * (s[1] - ay)

            if not inside(state) > 0.0 >= inside(after):
                continue
            at, s = ball.until(state, inside, time)
            share = ((s[0] - ax) * (bx - ax) + (s[1] - ay) * (by - ay)) / (
                (bx - ax) ** 2 + (by - ay) ** 2
            )
            if 0 <= share <= 1 and at < (found["time"] if found else landed):
                found = {"time": at, "position": s[:3], "velocity": s[3:6],
                         "clearance": s[2] - a - (b - a) * share}  # fmt: skip
        if found:
            return found
        state, time = after, time + H
    return None


def pitch(scene, wrong):
    thrown = scene["pitch"]
    toward = add([0.0, *thrown["aim"]], thrown["release"], -1.0)
    velocity = thrown.get("velocity") or times(toward, thrown["speed"] / size(toward))
    level = math.hypot(*velocity[:2])
    ball = Flight(scene, turned(scene, "pitch", wrong), [v / level for v in velocity[:2]], wrong)
    time, state = ball.until([*thrown["release"], *velocity, 0.0], lambda s: s[0])
    plate = {"time": time, "position": [0.0, *state[1:3]], "velocity": state[3:6]}
    return {"outcome": "crossed", "plate": plate}


def impact(scene, wrong):
    """The oblique impulse on a bat that turns about its end B."""
    incoming, swing = scene["incoming"], scene["swing"]
    bat, ball = scene["bat"], scene["ball"]
    m, radius, big = ball["mass"], ball["radius"], bat["mass"]
    length, thick = bat["length"], bat["radius"]
    x, y, z = incoming["position"]
    away = math.hypot(x, z - incoming["bat_height"])
    n = [x / away, 0.0, (z - incoming["bat_height"]) / away]
    lever, omega, tilt = length / 2 - y, swing["angular_speed"], swing["tilt"]
    rotation = [-omega * math.sin(tilt), 0.0, omega * math.cos(tilt)]
    on_axis = cross(rotation, [0.0, -lever, 0.0])
    velocity = list(incoming["velocity"])
    closing = dot(add(velocity, on_axis, -1.0), n)
    contact = {"position": [x, y, z], "normal": n, "bat_velocity": on_axis, "normal_speed": closing}
    if closing >= 0.0:
        return {"outcome": "separating", "contact": contact}
    across_bat = big * (length**2 / 3 + thick**2 / 4)
    ratio = m * lever**2 / across_bat
    e = ball["restitution"] * (1 + ratio) + ratio
    beta = ball.get("inertia_factor") or 0.4
    e_t = bat.get("tangential_restitution")
    e_t = 0.3 if e_t is None else e_t
    friction = bat["friction"]
    spin = turned(scene, "incoming", wrong) or [0.0, 0.0, 0.0]
    arm = add(times(n, thick), [0.0, -lever, 0.0])
    moving = [0.0, 0.0, 0.0] if wrong == "slip without spin" else spin
    slip = add(velocity, cross(moving, times(n, -radius)))
    slip = add(slip, cross(rotation, arm), -1.0)
    t = cross(n, [0.0, 1.0, 0.0])
    axes = [n, [0.0, 1.0, 0.0], t]

    def gives(push):
        """Change of the slip by an impulse, without its part along n."""
        turning = cross(arm, push)
        turning = [turning[0] / across_bat, turning[1] / (big * thick**2 / 2),
                   turning[2] / across_bat]  # fmt: skip
        own = add(push, times(n, dot(push, n)), -1.0)
        return add(add(times(push, 1 / m), own, 1 / (beta * m)), cross(turning, arm))

    k = [[dot(gives(b), a) for b in axes] for a in axes]
    k[0][0] = 1 / m + 1 / big
    g = [dot(slip, a) for a in axes]
    goal = [-(1 + e) * g[0], -(1 + e_t) * g[1], -(1 + e_t) * g[2]]
    determinant = k[0][0] * k[1][1] - k[0][1] * k[1][0]
    push = [(goal[0] * k[1][1] - goal[1] * k[0][1]) / determinant,
            (k[0][0] * goal[1] - k[1][0] * goal[0]) / determinant, goal[2] / k[2][2]]  # fmt: skip
    rubbed, mode = math.hypot(push[1], push[2]), "grip"
    margin = 1 - rubbed / (friction * push[0])
    if margin < 0.0:
        mode, way = "slide", math.hypot(g[1], g[2])
        c, s = g[1] / way, g[2] / way
        normal = goal[0] / (k[0][0] - friction * k[0][1] * c)
        push = [normal, -friction * normal * c, -friction * normal * s]
    whole = add(add(times(n, push[0]), axes[1], push[1]), t, push[2])
    gained = [sum(k[i][j] * push[j] for j in range(3)) for i in range(3)]
    energy = sum(p * (a + b / 2) for p, a, b in zip(push, g, gained))
    after = add(spin, cross(n, whole), -1 / (beta * m * radius))
    struck = {"restitution": e, "impulse": push[0], "velocity": add(velocity, whole, 1 / m),
              "energy_change": energy, "spin": after, "mode": mode,
              "friction_margin": margin}  # fmt: skip
    return {"outcome": "struck", "contact": contact, "impact": struck}


def solve(scene, wrong=""):
    """Return the result of a scene, a dict as JSON has it."""
    kinds = {"flight": flight, "pitch": pitch, "impact": impact}
    return {"id": scene["id"]} | kinds[scene["kind"]](scene, wrong)


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(solve(json.loads(line), *sys.argv[1:])), flush=True)
