"""A simulator with the mistakes that authors make: ``python mistaken.py NAME… < scenes > results``.

Written from the paper, in space and in plain Python. Flights are exact (Runge and Kutta's method in
short steps, the last one as long as it takes) or in steps of the paper's velocity Verlet.
`Switches` says what is done wrong; as they stand, nothing is. `MISTAKES` has them by name, and
``python mistaken.py --list`` prints the names.
"""

import json
import math
import sys
from copy import deepcopy
from dataclasses import dataclass
from functools import partial

H = 0.008  # s: a step of Runge and Kutta's of that length errs by 1e-12 of a baseball's flight


def by_square(k, v):
    return scaled(v, -k * size(v))


def by_component(k, v):
    return [-k * abs(c) * c for c in v]


def by_component_in_plane(k, v):
    level = math.hypot(*v[:2])
    return [-k * level * v[0], -k * level * v[1], -k * abs(v[2]) * v[2]]


def by_first_power(k, v):
    return scaled(v, -k)


@dataclass(frozen=True)
class Switches:
    """Options of the simulation, a mistake each.

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
    lift: object = None  # of k, v, the heading and the vertical: an acceleration
    integrator: str = ""  # steps of `dt` for flights and plates: see `INTEGRATORS`
    formula: tuple = ()  # of (name, function): in place of a formula of `collide`
    report: tuple = ()  # functions of the result and the scene that change what is written


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
        if self.how.lift:
            a = add(a, self.how.lift(self.lift, v, to))
        else:
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
            if self.how.integrator:
                r, v = INTEGRATORS[self.how.integrator](lambda v: self(v, to), r, v, dt)
            else:
                r, v, a = self.step(r, v, a, dt, to)
            yield k, before, (r, v)


def rk4_velocity(a, v, h):
    a1 = a(v)
    a2 = a(add(v, a1, h / 2))
    a3 = a(add(v, a2, h / 2))
    a4 = a(add(v, a3, h))
    return add(add(add(add(v, a1, h / 6), a2, h / 3), a3, h / 3), a4, h / 6)


def rk4(a, r, v, h):
    a1 = a(v)
    v2 = add(v, a1, h / 2)
    a2 = a(v2)
    v3 = add(v, a2, h / 2)
    a3 = a(v3)
    v4 = add(v, a3, h)
    a4 = a(v4)
    r = add(add(add(add(r, v, h / 6), v2, h / 3), v3, h / 3), v4, h / 6)
    return r, add(add(add(add(v, a1, h / 6), a2, h / 3), a3, h / 3), a4, h / 6)


def euler(a, r, v, h):
    return add(r, v, h), add(v, a(v), h)


def semi_implicit(a, r, v, h):
    v = add(v, a(v), h)
    return add(r, v, h), v


def implicit(a, r, v, h):
    new = v
    for _ in range(40):
        new = add(v, a(new), h)
    return add(r, new, h), new


def heun(a, r, v, h):
    first = a(v)
    ahead = add(v, first, h)
    return add(add(r, v, h / 2), ahead, h / 2), add(add(v, first, h / 2), a(ahead), h / 2)


def midpoint(a, r, v, h):
    half = add(v, a(v), h / 2)
    return add(r, half, h), add(v, a(half), h)


def rk4_old(a, r, v, h):
    return add(r, v, h), rk4_velocity(a, v, h)


def mean_velocity(a, r, v, h):
    new = add(v, a(v), h)
    return add(add(r, v, h / 2), new, h / 2), new


INTEGRATORS = {
    "euler": euler, "semi-implicit": semi_implicit, "implicit": implicit, "heun": heun,
    "midpoint": midpoint, "rk4": rk4, "rk4-old": rk4_old, "mean": mean_velocity,
}  # fmt: skip


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
    if how.forces is None and not how.integrator:
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
        share = {"interpolated": (r0[2] - floor) / (r0[2] - r1[2]), "above": 0.0}.get(
            how.landing, 1.0
        )
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
    if how.forces is None and not how.integrator:
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
    formula, offset = dict(how.formula), swing.get("height_offset", 0.0)
    d = math.hypot(r[0], r[2] - height)
    n = [r[0] / d, 0.0, (r[2] - height) / d]
    if "normal" in formula:
        n = formula["normal"](r, height, offset)
    lever = L / 2 + r[1] if how.other_end else L / 2 - r[1]
    speed = swing["angular_speed"] * lever * (-1 if how.backwards else 1)
    vb = [speed * math.cos(swing["tilt"]), 0.0, speed * math.sin(swing["tilt"])]
    if "bat_velocity" in formula:
        vb = formula["bat_velocity"](swing, r[1], L)
    vn = dot(add(v, vb, -1.0), n)
    if "normal_speed" in formula:
        vn = formula["normal_speed"](v, vb, n)
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
    if "restitution" in formula:
        restitution = formula["restitution"](e, m, M, effective)
    mu = 1 / (1 / m + 1 / other)
    j = -mu * (1 + restitution) * vn
    if "impulse" in formula:
        j = formula["impulse"](e, restitution, m, M, effective, vn)
    after = add(v, n, j / m)
    if "after" in formula:
        after = formula["after"](v, vb, n, j, m, M)
    energy = (restitution**2 - 1) * mu * vn * vn / 2
    if "energy" in formula:
        energy = formula["energy"](e, restitution, m, M, effective, vn, v, after)
    return contact, {"restitution": restitution, "impulse": j, "velocity": after,
                     "energy_change": energy}  # fmt: skip


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
    result = {"id": scene["id"]} | result
    for change in how.report:
        change(result, scene)
    return result


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


# ---- mistakes by name ----------------------------------------------------------------------------


def times(block, key, factor):
    return {"scene": ((block, key, "times", factor),)}


def fixed(block, key, value):
    return {"scene": ((block, key, value),)}


def formula(name, function):
    return {"formula": ((name, function),)}


def reported(block, key, function):
    """Write a quantity otherwise than it is computed."""

    def change(result, scene):
        held = result.get(block)
        if held and held.get(key) is not None:
            held[key] = function(held[key], result, scene)

    return {"report": (change,)}


def in_unit(factor):
    def convert(value, result, scene):
        return scaled(value, factor) if isinstance(value, list) else value * factor

    return convert


def late_clock(result, scene):
    for block in ("plate", "landing"):
        if result.get(block):
            result[block]["time"] += 0.01
    if result.get("landing"):
        result["landing"]["hang_time"] += 0.01


def rotation(swing, lever, tilt):
    speed = swing["angular_speed"] * lever
    return [speed * math.cos(tilt), 0.0, speed * math.sin(tilt)]


def thinner_air(k, v):
    return scaled(v, -k * size(v) * 0.95)


def unit(v):
    return scaled(v, 1 / size(v))


MISTAKES = {
    # numbers that are not the scene's
    "g-9.81": fixed("", "gravity", 9.81),
    "g-9.80665": fixed("", "gravity", 9.80665),
    "density-1.2": fixed("air", "density", 1.2),
    "density-1.205": fixed("air", "density", 1.205),
    "density-1.225": fixed("air", "density", 1.225),
    "drag-0.35": fixed("air", "drag_coefficient", 0.35),
    "lift-0.15": fixed("air", "lift_coefficient", 0.15),
    "mass-0.145": fixed("ball", "mass", 0.145),
    "mass-0.142": fixed("ball", "mass", 0.142),
    "radius-0.0369": fixed("ball", "radius", 0.0369),
    "radius-doubled": times("ball", "radius", 2.0),
    "radius-halved": times("ball", "radius", 0.5),
    "e-0.5": fixed("ball", "restitution", 0.5),
    "bat-mass-0.88": fixed("bat", "mass", 0.88),
    "bat-length-0.84": fixed("bat", "length", 0.84),
    "omega-30": fixed("swing", "angular_speed", 30.0),
    "omega-in-rpm": times("swing", "angular_speed", 60 / (2 * math.pi)),
    "ground-at-0": fixed("ground", "height", 0.0),
    "pitch-in-km/h": times("pitch", "speed", 1 / 3.6),
    "pitch-in-mph": times("pitch", "speed", 0.44704),
    "pitch-to-mph": times("pitch", "speed", 2.2369362921),
    "no-lift": fixed("air", "lift_coefficient", 0.0),
    "drag-doubled": times("air", "drag_coefficient", 2.0),
    "area-without-pi": times("air", "density", 1 / math.pi),
    "offset-ignored": fixed("swing", "height_offset", 0.0),
    "tilt-to-radians": times("swing", "tilt", math.pi / 180),
    "tilt-to-degrees": times("swing", "tilt", 180 / math.pi),
    "tilt-ignored": fixed("swing", "tilt", 0.0),
    # the law of motion
    "drag-per-component": {"drag": by_component},
    "drag-per-component-in-plane": {"drag": by_component_in_plane},
    "drag-with-v": {"drag": by_first_power},
    "drag-with-v-cubed": {"drag": lambda k, v: scaled(v, -k * size(v) ** 2)},
    "unsigned-drag": {"drag": lambda k, v: [-k * c * c for c in v]},
    "drag-unsigned-down": {
        "drag": lambda k, v: [-k * size(v) * v[0], -k * size(v) * v[1], -k * size(v) * abs(v[2])]
    },
    "horizontal-drag": {"drag": lambda k, v: [-k * size(v) * v[0], -k * size(v) * v[1], 0.0]},
    "drag-forward": {"drag": lambda k, v: scaled(v, k * size(v))},
    "drag-less": {"drag": thinner_air},
    "lift-sign": times("air", "lift_coefficient", -1.0),
    "lift-vertical": {"lift": lambda k, v, to: [0.0, 0.0, k * dot(v, v)]},
    "lift-vertical-part": {"lift": lambda k, v, to: [0.0, 0.0, k * size(v) * along(v, to)]},
    "lift-with-v": {
        "lift": lambda k, v, to: [-k * to[0] * v[2], -k * to[1] * v[2], k * along(v, to)]
    },
    "lift-always-up": {"upward": True},
    # integrators and events
    "euler": {"integrator": "euler"},
    "semi-implicit-euler": {"integrator": "semi-implicit"},
    "implicit-euler": {"integrator": "implicit"},
    "heun": {"integrator": "heun", "dt": 0.02},
    "midpoint": {"integrator": "midpoint", "dt": 0.02},
    "rk4-old-velocity": {"integrator": "rk4-old"},
    "mean-velocity": {"integrator": "mean"},
    "euler-first-below": {"integrator": "euler", "landing": "below"},
    "rk4-first-below": {"integrator": "rk4", "landing": "below"},
    "rk4-last-above": {"integrator": "rk4", "landing": "above"},
    "rk4-on-the-line": {"integrator": "rk4", "dt": 0.02},
    "lagged-verlet": {"forces": "old_carried", "push": False},
    "half-step-verlet": {"forces": "half_step", "push": False},
    "paper": {"forces": "old_carried"},
    "first-below": {"below": "start"},
    "first-below-since-launch": {"below": "launch"},
    "linear-plate": {"line": True},
    "surface": {"surface": True},
    "clock-late": {"report": (late_clock,)},
    # the collision
    "plain-e": {"restitution": "plain"},
    "nathan": {"restitution": "nathan"},
    "mu-effective": {"restitution": "effective"},
    "effective-mass-over-r": {"arm_power": 1},
    "thin-rod": {"inertia": "rod"},
    "about-centre": {"inertia": "centre"},
    "other-end": {"other_end": True},
    "other-end-backwards": {"other_end": True, "backwards": True},
    "backwards": {"backwards": True},
    "normal-in-space": formula("normal", lambda r, z, o: unit([r[0], r[1], r[2] - z])),
    "normal-swapped": formula("normal", lambda r, z, o: unit([r[2] - z, 0.0, r[0]])),
    "tip-speed": formula("bat_velocity", lambda s, y, L: rotation(s, L, s["tilt"])),
    "middle-speed": formula("bat_velocity", lambda s, y, L: rotation(s, L / 2, s["tilt"])),
    "tilt-down": formula("bat_velocity", lambda s, y, L: rotation(s, L / 2 - y, -s["tilt"])),
    "tilt-swapped": formula(
        "bat_velocity", lambda s, y, L: rotation(s, L / 2 - y, math.pi / 2 - s["tilt"])
    ),
    "bat-at-rest": formula("normal_speed", lambda v, vb, n: dot(v, n)),
    "velocities-added": formula("normal_speed", lambda v, vb, n: dot(add(v, vb), n)),
    "bat-mass-ratio": formula("restitution", lambda e, m, M, eff: e * (1 + m / M) + m / M),
    "ratio-left-out": formula("restitution", lambda e, m, M, eff: e * (1 + m / eff)),
    "ball-mass-for-mu": formula("impulse", lambda e, t, m, M, eff, vn: -m * (1 + t) * vn),
    "e-in-impulse": formula("impulse", lambda e, t, m, M, eff, vn: -m * M / (m + M) * (1 + e) * vn),
    "inelastic": formula("impulse", lambda e, t, m, M, eff, vn: -m * M / (m + M) * vn),
    "over-bat-mass": formula("after", lambda v, vb, n, j, m, M: add(v, n, j / M)),
    "impulse-subtracted": formula("after", lambda v, vb, n, j, m, M: add(v, n, -j / m)),
    "before-forgotten": formula("after", lambda v, vb, n, j, m, M: scaled(n, j / m)),
    "relative-kept": formula("after", lambda v, vb, n, j, m, M: add(add(v, vb, -1.0), n, j / m)),
    "energy-not-squared": formula(
        "energy", lambda e, t, m, M, eff, vn, v, w: (t - 1) * m * M / (m + M) * vn * vn / 2
    ),
    "energy-of-ball": formula(
        "energy", lambda e, t, m, M, eff, vn, v, w: m * (dot(w, w) - dot(v, v)) / 2
    ),
    # what is written
    "distance-in-feet": reported("landing", "distance", in_unit(1 / 0.3048)),
    "position-in-feet": reported("landing", "position", in_unit(1 / 0.3048)),
    "exit-in-mph": reported("impact", "velocity", in_unit(1 / 0.44704)),
    "axes-exchanged": reported("landing", "position", lambda p, r, s: [p[1], p[0], p[2]]),
    "y-and-z-exchanged": reported("plate", "position", lambda p, r, s: [p[0], p[2], p[1]]),
    "side-sign": reported("landing", "position", lambda p, r, s: [p[0], -p[1], p[2]]),
    "normal-sign": reported("contact", "normal", in_unit(-1.0)),
    "energy-sign": reported("impact", "energy_change", in_unit(-1.0)),
    "margin-sign": reported("contact", "margin", in_unit(-1.0)),
    "time-since-contact": reported("landing", "time", lambda t, r, s: r["landing"]["hang_time"]),
    "hang-since-start": reported("landing", "hang_time", lambda t, r, s: r["landing"]["time"]),
    "distance-from-start": {"from_contact": True},
    "distance-along-x": reported(
        "landing", "distance", lambda d, r, s: r["landing"]["position"][0]
    ),
    "distance-in-space": reported(
        "landing", "distance", lambda d, r, s: size(r["landing"]["position"])
    ),
    "four-decimals": reported("landing", "position", lambda p, r, s: [round(c, 4) for c in p]),
}


def switches(*names):
    """Return the switches of some mistakes together."""
    joined = {}
    for name in names:
        for key, value in MISTAKES[name].items():
            joined[key] = joined[key] + value if isinstance(joined.get(key), tuple) else value
    return Switches(**joined)


def main(names):
    if names == ["--list"]:
        print("\n".join(MISTAKES))
        return
    how = switches(*names)
    for line in sys.stdin:
        scene = json.loads(line)
        try:
            result = solve(scene, how)
        except (ArithmeticError, ValueError, TypeError) as error:
            result = {"id": scene["id"], "error": repr(error)}
        print(json.dumps(result), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
