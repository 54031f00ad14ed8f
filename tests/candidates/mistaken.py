"""A simulator with switches for the mistakes that authors make.

Written from the paper, in space and in plain Python. Flights are exact (Runge and Kutta's method in
short steps, the last one as long as it takes) or in steps of the paper's velocity Verlet.
`Switches` says what is done wrong; as they stand, nothing is.
"""

import math
from copy import deepcopy
from dataclasses import dataclass
from functools import partial

H = 0.008  # s: a step of Runge and Kutta's of that length errs by 1e-12 of a baseball's flight


def by_square(k, v):
    return scaled(v, -k * size(v))


def by_component(k, v):
    return [-k * abs(c) * c for c in v]


def by_first_power(k, v):
    return scaled(v, -k)


@dataclass(frozen=True)
class Switches:
    """What is done.

    `dt` is the step of what is done in steps. `forces` None: exact flights. `push`: Appendix B's
    two steps of half the force; else the bat strikes at once. `below`: land at the first step below
    the ground, counted from the "start" of the scene or from the "launch"; `on_floor`: but say that
    it was at the ground. `line`: the plate on the line between two steps. `steps_only`: look for
    the bat at the steps. `root`: "first" or "larger"; `parting`: no force where ball and bat part.
    """

    dt: float = 0.01
    forces: str | None = None
    push: bool = True
    landing: str = "interpolated"
    below: str = ""
    on_floor: bool = False
    line: bool = False
    steps_only: bool = False
    root: str = "first"
    parting: bool = False
    drag: object = by_square
    upward: bool = False
    restitution: str = "paper"
    arm_power: int = 2
    inertia: str = "cylinder"
    other_end: bool = False
    backwards: bool = False
    from_contact: bool = False
    from_launch: bool = False
    surface: bool = False
    scene: tuple = ()  # of (block, key, value), or (block, key, "times", factor)


# ---- vectors -------------------------------------------------------------------------------------


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def size(a):
    return math.sqrt(dot(a, a))


def scaled(a, factor):
    return [factor * a[0], factor * a[1], factor * a[2]]


def add(a, b, factor=1.0):
    return [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]


def between(a, b, share):
    return add(a, add(b, a, -1.0), share)


def heading(v):
    h = math.hypot(v[0], v[1])
    return (v[0] / h, v[1] / h) if h else (1.0, 0.0)


# ---- flights -------------------------------------------------------------------------------------


class Air:
    """The acceleration of a ball with backspin, launched toward a heading."""

    def __init__(self, scene, how):
        air, ball = (
            scene["air"] or {"density": 0, "drag_coefficient": 0, "lift_coefficient": 0},
            scene["ball"],
        )
        k = air["density"] * math.pi * ball["radius"] ** 2 / (2 * ball["mass"])
        self.drag, self.lift = k * air["drag_coefficient"], k * air["lift_coefficient"]
        self.gravity, self.how = scene["gravity"], how

    def __call__(self, v, to):
        a = self.how.drag(self.drag, v)
        along = v[0] * to[0] + v[1] * to[1]
        side = math.copysign(1.0, along) if along else 0.0
        lift = self.lift * size(v) * (side if self.how.upward else 1.0)
        a = [a[0] - lift * to[0] * v[2], a[1] - lift * to[1] * v[2], a[2] + lift * along]
        a[2] -= self.gravity
        return a

    def moved(self, r, v, to, h):
        """One step of Runge and Kutta's."""
        a = self(v, to)
        v2 = add(v, a, h / 2)
        a2 = self(v2, to)
        v3 = add(v, a2, h / 2)
        a3 = self(v3, to)
        v4 = add(v, a3, h)
        a4 = self(v4, to)
        weights = (1, 2, 2, 1)
        dr = [sum(map(lambda w, c: w * c, weights, cs)) for cs in zip(v, v2, v3, v4)]
        dv = [sum(map(lambda w, c: w * c, weights, cs)) for cs in zip(a, a2, a3, a4)]
        return add(r, dr, h / 6), add(v, dv, h / 6)

    def step(self, r, v, a, dt, to=None, push=(0.0, 0.0, 0.0)):
        """One step of velocity Verlet, with the force at its end as `forces` says."""

        def air(v):
            return self(v, to or heading(v))

        felt = add(a, push)
        half = add(v, felt, dt / 2)
        kind = self.how.forces
        a = air({"old": v, "half": half}.get(kind.partition("_")[0], add(v, felt, dt)))
        end = add(half, add(a, push), dt / 2)
        if kind == "implicit":
            for _ in range(60):
                a = air(end)
                end = add(half, add(a, push), dt / 2)
        if kind in ("old_recomputed", "predicted_recomputed", "implicit"):
            a = air(end)
        return add(r, half, dt), end, a

    def exactly(self, r, v, to, value, limit=100.0):
        """Fly until `value(r, v)` falls to zero; return when and where, or None."""
        time = 0.0
        while time < limit:
            at = partial(self.moved, r, v, to)
            after = at(H)
            upright = v[0] == v[1] == 0.0
            if self.how.upward and not upright and along(after[1], to) <= 0.0:
                h = root(lambda h, at=at: along(at(h)[1], to))
                after = at(h)
                if value(*after) > 0.0:  # straight down from here
                    r, v, time = after[0], [0.0, 0.0, after[1][2]], time + h
                    continue
            if value(*after) <= 0.0:
                h = root(lambda h, at=at: value(*at(h)))
                return time + h, *at(h)
            (r, v), time = after, time + H
        return None

    def steps(self, r, v, dt, limit=100.0):
        """Yield the steps of a flight: the number, and the states before and after."""
        to = heading(v)
        a = self(v, to)
        for k in range(1, math.ceil(limit / dt) + 1):
            before = r, v
            r, v, a = self.step(r, v, a, dt, to)
            yield k, before, (r, v)


def along(v, to):
    return v[0] * to[0] + v[1] * to[1]


def root(function, low=0.0, high=H):
    """The zero of a function that falls from low to high."""
    for _ in range(50):
        middle = (low + high) / 2
        if function(middle) > 0.0:
            low = middle
        else:
            high = middle
    return high


def land(scene, how, r, v, time=0.0, since=0.0, stepped=0):
    """Fly to the ground; `time` is now, `since` the launch so much has passed already."""
    floor, air, to = floor_of(scene, how), Air(scene, how), heading(v)
    if how.forces is None:
        flight = air.exactly(r, v, to, lambda r, v: r[2] - floor)
        if not flight:
            return None
        t, r, v = flight
        if how.below:
            count = time + t if how.below == "start" else t
            late = math.ceil(count / how.dt) * how.dt - count
            r, v = air.moved(r, v, to, late)
            t += late
    else:
        flight = next((s for s in air.steps(r, v, how.dt) if s[2][0][2] <= floor), None)
        if not flight:
            return None
        k, (r0, v0), (r1, v1) = flight
        share = (r0[2] - floor) / (r0[2] - r1[2]) if how.landing == "interpolated" else 1.0
        r, v, t = between(r0, r1, share), between(v0, v1, share), (k - 1 + share) * how.dt
        if how.landing == "interpolated":
            r[2] = floor
    if how.on_floor:
        r = [*r[:2], floor]
    return {"time": time + t, "hang_time": since + t, "position": r, "velocity": v,
            "distance": math.hypot(r[0], r[1])}  # fmt: skip


def floor_of(scene, how):
    height = scene.get("ground", {"height": 0.0})["height"]
    return height + scene["ball"]["radius"] if how.surface else height


# ---- pitches -------------------------------------------------------------------------------------


def release(scene):
    pitch = scene["pitch"]
    toward = add([0.0, *pitch["aim"]], pitch["release"], -1.0)
    return list(pitch["release"]), scaled(toward, pitch["speed"] / size(toward))


def throw(scene, how):
    r, v = release(scene)
    floor, air, to = floor_of(scene, how), Air(scene, how), heading(v)
    if how.forces is None:
        flight = air.exactly(r, v, to, lambda r, v: min(r[0], r[2] - floor))
        if not flight:
            return {"outcome": "airborne"}
        time, r, v = flight
        if abs(r[0]) > 1e-9:
            return {"outcome": "grounded"}
        if how.line:
            early = math.floor(time / how.dt) * how.dt - time
            (r0, v0), (r1, v1) = (air.moved(r, v, to, h) for h in (early, early + how.dt))
            share = r0[0] / (r0[0] - r1[0])
            r, v, time = (
                between(r0, r1, share),
                between(v0, v1, share),
                time + early + share * how.dt,
            )
    else:
        steps = air.steps(r, v, how.dt)
        flight = next((s for s in steps if s[2][0][0] <= 0.0 or s[2][0][2] <= floor), None)
        if not flight:
            return {"outcome": "airborne"}
        k, (r0, v0), (r1, v1) = flight
        share = r0[0] / (r0[0] - r1[0])
        r, v, time = between(r0, r1, share), between(v0, v1, share), (k - 1 + share) * how.dt
        if r1[0] > 0.0 or r[2] <= floor:
            return {"outcome": "grounded"}
    plate = {"time": time, "position": [0.0, *r[1:]], "velocity": v}
    return {"outcome": "crossed", "plate": plate}


# ---- ball and bat --------------------------------------------------------------------------------


def collide(scene, how, r, v, height, parting=True):
    """Return the contact at r, and the impact there if there is one."""
    ball, bat, swing = scene["ball"], scene["bat"], scene["swing"]
    m, e, M, L, rb = (ball["mass"], ball["restitution"], bat["mass"], bat["length"], bat["radius"])
    d = math.hypot(r[0], r[2] - height)
    n = [r[0] / d, 0.0, (r[2] - height) / d]
    lever = L / 2 + r[1] if how.other_end else L / 2 - r[1]
    speed = swing["angular_speed"] * lever * (-1 if how.backwards else 1)
    vb = [speed * math.cos(swing["tilt"]), 0.0, speed * math.sin(swing["tilt"])]
    vn = dot(add(v, vb, -1.0), n)
    contact = {"position": r, "normal": n, "bat_velocity": vb, "normal_speed": vn}
    if vn >= 0.0 and parting:
        return contact, None
    round_bat, rod = rb**2 / 4, L**2 / 3
    inertia = (
        M * {"cylinder": rod + round_bat, "rod": rod, "centre": rod / 4 + round_bat}[how.inertia]
    )
    effective = inertia / lever**how.arm_power
    restitution = e if how.restitution in ("plain", "nathan") else e + (1 + e) * m / effective
    other = effective if how.restitution in ("nathan", "effective") else M
    mu = 1 / (1 / m + 1 / other)
    j = -mu * (1 + restitution) * vn
    return contact, {"restitution": restitution, "impulse": j, "velocity": add(v, n, j / m),
                     "energy_change": (restitution**2 - 1) * mu * vn * vn / 2}  # fmt: skip


def at_bat(scene, how):
    result = throw(scene, how)
    if result["outcome"] != "crossed":
        return result
    height = result["plate"]["position"][2] + scene["swing"]["height_offset"]
    return result | (exact_bat if how.forces is None else stepped_bat)(scene, how, height)


def exact_bat(scene, how, height):
    reach = scene["ball"]["radius"] + scene["bat"]["radius"]
    start, air = release(scene), Air(scene, how)
    to = heading(start[1])

    def beyond(r):
        return math.hypot(r[0], r[2] - height) - reach

    time, r, v = air.exactly(*start, to, lambda r, v: -(r[0] * v[0] + (r[2] - height) * v[2]))
    margin = -beyond(r)
    if margin < 0.0:
        return {"outcome": "missed", "contact": {"margin": margin}}
    early = root(lambda h: beyond(air.moved(r, v, to, h)[0]), -2 * reach / size(v), 0.0)
    (r, v), time = air.moved(r, v, to, early), time + early
    if how.steps_only:
        late = math.ceil(time / how.dt) * how.dt - time
        gaps = [beyond(air.moved(r, v, to, h)[0]) for h in (late - how.dt, late)]
        if gaps[1] >= 0.0:
            return {"outcome": "missed", "contact": {"margin": -min(gaps)}}
    touching = {"time": time, "position": r, "margin": margin}
    if abs(r[1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat", "contact": touching}
    contact, impact = collide(scene, how, r, v, height)
    if not impact:
        return {"outcome": "separating", "contact": touching | contact}
    landing = land(scene, how, r, impact["velocity"], time)
    return {"outcome": "batted" if landing else "airborne", "contact": touching | contact,
            "impact": impact} | ({"landing": landing} if landing else {})  # fmt: skip


def stepped_bat(scene, how, height):
    reach, dt, air = scene["ball"]["radius"] + scene["bat"]["radius"], how.dt, Air(scene, how)
    start = release(scene)
    floor, gaps, hit = floor_of(scene, how), [math.hypot(start[0][0], start[0][2] - height)], None
    for k, before, (r, _) in air.steps(*start, dt):
        if r[2] <= floor:
            break
        gaps.append(math.hypot(r[0], r[2] - height))
        if not hit and gaps[-1] < reach:
            hit = k, before, r
        if r[0] <= -reach:
            break
    contact = {"margin": reach - min(gaps)}
    if not hit:
        return {"outcome": "missed", "contact": contact}
    k, (r, v), inside = hit
    p, q = v[0] ** 2 + v[2] ** 2, r[0] * v[0] + (r[2] - height) * v[2]
    s = r[0] ** 2 + (r[2] - height) ** 2 - reach**2
    ahead = (-q + (1 if how.root == "larger" else -1) * math.sqrt(q * q - p * s)) / p
    contact |= {"time": (k - 1) * dt + ahead, "position": add(r, v, ahead)}
    if abs(inside[1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat", "contact": contact}
    met, impact = collide(
        scene, how, contact["position"], v, height, how.root == "first" or how.parting
    )
    contact |= met
    if not impact:
        return {"outcome": "separating", "contact": contact}
    result = {"outcome": "batted", "contact": contact, "impact": impact}
    if not how.push:
        landing = land(scene, how, contact["position"], impact["velocity"], contact["time"])
    else:
        push = scaled(add(impact["velocity"], v, -1.0), 1 / (2 * dt))
        a = air(v, heading(v))
        for _ in range(2):
            r, v, a = air.step(r, v, a, dt, None, push)
        landing = land(scene, how, r, v, (k + 1) * dt, 2 * dt - ahead)
    return result | ({"landing": landing} if landing else {"outcome": "airborne"})


# ---- scenes --------------------------------------------------------------------------------------


def solve(scene, how):
    """Return the result of a scene, a dict as JSON has it, with the mistakes of `Switches`."""
    scene = deepcopy(scene)
    for block, key, *value in how.scene:
        holder = scene if not block else scene.get(block)
        if holder and key in holder:
            holder[key] = holder[key] * value[1] if value[0] == "times" else value[0]
    result = {"flight": flight, "pitch": throw, "impact": impact, "at-bat": at_bat}[scene["kind"]](
        scene, how
    )
    landing = result.get("landing")
    if landing:
        start = result.get("contact", {}).get("position") if how.from_contact else None
        if how.from_launch and scene["kind"] == "flight":
            start = scene["launch"]["position"]
        x, y, _ = add(landing["position"], start or (0, 0, 0), -1.0)
        landing["distance"] = math.hypot(x, y)
    return {"id": scene["id"]} | result


def flight(scene, how):
    landing = land(scene, how, scene["launch"]["position"], scene["launch"]["velocity"])
    return {"outcome": "landed", "landing": landing} if landing else {"outcome": "airborne"}


def impact(scene, how):
    incoming = scene["incoming"]
    if abs(incoming["position"][1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat"}
    contact, struck = collide(
        scene, how, incoming["position"], incoming["velocity"], incoming["bat_height"]
    )
    if not struck:
        return {"outcome": "separating", "contact": contact}
    return {"outcome": "struck", "contact": contact, "impact": struck}
