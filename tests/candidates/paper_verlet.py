"""The paper's scheme in plain Python: scenes on standard input, results on standard output.

Velocity Verlet with drag and lift at the velocity of the step before, plate and ground on the line
between two steps, the bat looked for at the steps, Appendix B. Usage: paper_verlet.py [--dt 0.05]
"""

import json
import math
import sys


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(a, b, factor=1.0):
    return [p + factor * q for p, q in zip(a, b)]


def heading(v):
    h = math.hypot(v[0], v[1])
    return (v[0] / h, v[1] / h) if h else (1.0, 0.0)


def forces(scene):
    """Return the acceleration at velocity v of a ball launched toward `to` with backspin."""
    ball, air, g = scene["ball"], scene["air"], scene["gravity"]
    k = air["density"] * math.pi * ball["radius"] ** 2 / (2 * ball["mass"]) if air else 0.0
    drag, lift = (k * air["drag_coefficient"], k * air["lift_coefficient"]) if air else (0.0, 0.0)

    def acceleration(v, to):
        speed = math.sqrt(dot(v, v))
        along = v[0] * to[0] + v[1] * to[1]  # v is (along, up) in the plane of the launch
        across = (-v[2] * to[0], -v[2] * to[1], along)
        a = [speed * (-drag * p + lift * q) for p, q in zip(v, across)]
        a[2] -= g
        return a

    return acceleration


def step(r, v, a, dt, acceleration, to, push=(0.0, 0.0, 0.0)):
    total = add(a, push)
    half = add(v, total, 0.5 * dt)
    a = acceleration(v, to or heading(v))
    return add(r, half, dt), add(half, add(a, push), 0.5 * dt), a


def between(before, after, share):
    return [p + share * (q - p) for p, q in zip(before, after)]


def fly(scene, r, v, dt, ended):
    """Step until `ended(r)`; return the number of steps and the last two states."""
    acceleration, to = forces(scene), heading(v)
    a = acceleration(v, to)
    for k in range(1, math.ceil(scene["time_limit"] / dt) + 1):
        old = r, v
        r, v, a = step(r, v, a, dt, acceleration, to)
        if ended(r):
            return k, old, (r, v)
    return None


def land(scene, r, v, time, since, dt):
    """Fly to the ground; `time` is now, `since` what has passed since launch or contact."""
    floor = scene["ground"]["height"]
    flight = fly(scene, r, v, dt, lambda r: r[2] <= floor)
    if not flight:
        return None
    k, (r0, v0), (r1, v1) = flight
    drop = r0[2] - r1[2]
    share = (r0[2] - floor) / drop if drop > 0.0 else 0.0
    r, v, t = between(r0, r1, share), between(v0, v1, share), (k - 1 + share) * dt
    r[2] = floor
    return {"time": time + t, "hang_time": since + t, "position": r, "velocity": v,
            "distance": math.hypot(r[0], r[1])}  # fmt: skip


def throw(scene, dt):
    pitch = scene["pitch"]
    r = list(pitch["release"])
    c = add([0.0, *pitch["aim"]], r, -1.0)
    v = [pitch["speed"] / math.sqrt(dot(c, c)) * p for p in c]
    floor = scene.get("ground", {"height": 0.0})["height"]
    flight = fly(scene, r, v, dt, lambda r: r[0] <= 0.0 or r[2] <= floor)
    if not flight:
        return r, v, {"outcome": "airborne"}
    k, (r0, v0), (r1, v1) = flight
    share = r0[0] / (r0[0] - r1[0])
    if r1[0] > 0.0 or between(r0, r1, share)[2] <= floor:
        return r, v, {"outcome": "grounded"}
    at = between(r0, r1, share)
    plate = {"time": (k - 1 + share) * dt, "position": [0.0, *at[1:]],
             "velocity": between(v0, v1, share)}  # fmt: skip
    return r, v, {"outcome": "crossed", "plate": plate}


def collide(scene, r, v, height):
    """Return the contact at r, and the impact there if the two approach."""
    ball, bat, swing = scene["ball"], scene["bat"], scene["swing"]
    m, e, big, length, rb = (ball["mass"], ball["restitution"], bat["mass"], bat["length"],
                             bat["radius"])  # fmt: skip
    d = math.hypot(r[0], r[2] - height)
    n = [r[0] / d, 0.0, (r[2] - height) / d]
    lever = length / 2 - r[1]
    speed = swing["angular_speed"] * lever
    vb = [speed * math.cos(swing["tilt"]), 0.0, speed * math.sin(swing["tilt"])]
    vn = dot(add(v, vb, -1.0), n)
    contact = {"position": r, "normal": n, "bat_velocity": vb, "normal_speed": vn}
    if vn >= 0.0:
        return contact, None
    ratio = m * lever**2 / (big * (length**2 / 3 + rb**2 / 4))  # m / M_eff
    restitution, mu = e * (1 + ratio) + ratio, m * big / (m + big)
    j = -mu * (1 + restitution) * vn
    return contact, {"restitution": restitution, "impulse": j, "velocity": add(v, n, j / m),
                     "energy_change": -0.5 * mu * (1 - restitution**2) * vn * vn}  # fmt: skip


def bat(scene, dt):
    r, v, result = throw(scene, dt)
    if result["outcome"] != "crossed":
        return result
    height = result["plate"]["position"][2] + scene["swing"]["height_offset"]
    reach = scene["ball"]["radius"] + scene["bat"]["radius"]
    floor = scene["ground"]["height"]
    distances = [math.hypot(r[0], r[2] - height)]

    def met(r):
        distances.append(math.hypot(r[0], r[2] - height))
        return distances[-1] < reach or r[0] <= -reach or r[2] <= floor

    flight = fly(scene, r, v, dt, met)
    if not flight or distances[-1] >= reach:
        return result | {"outcome": "missed", "contact": {"margin": reach - min(distances)}}
    k, (r, v), (inside, _) = flight
    # |d + v Δt'| = reach, d from the axis to the ball (Appendix B)
    a, b = v[0] ** 2 + v[2] ** 2, r[0] * v[0] + (r[2] - height) * v[2]
    c = r[0] ** 2 + (r[2] - height) ** 2 - reach**2
    ahead = c / (-b + math.sqrt(b * b - a * c))
    touching = {"time": (k - 1) * dt + ahead}
    if abs(inside[1]) >= scene["bat"]["length"] / 2:
        return result | {"outcome": "beyond_bat",
                         "contact": touching | {"position": add(r, v, ahead)}}  # fmt: skip
    contact, impact = collide(scene, add(r, v, ahead), v, height)
    result["contact"] = touching | contact
    if not impact:
        return result | {"outcome": "separating"}
    push = [x / (2 * dt) for x in add(impact["velocity"], v, -1.0)]
    acceleration = forces(scene)
    air = acceleration(v, heading(v))
    for _ in range(2):
        r, v, air = step(r, v, air, dt, acceleration, None, push)
    landing = land(scene, r, v, (k + 1) * dt, 2 * dt - ahead, dt)
    result |= {"outcome": "batted" if landing else "airborne", "impact": impact}
    return result | ({"landing": landing} if landing else {})


def solve(scene, dt):
    if scene["reading"]:
        return {"error": "only the default reading is understood"}
    if scene["kind"] == "flight":
        launch = scene["launch"]
        landing = land(scene, launch["position"], launch["velocity"], 0.0, 0.0, dt)
        return {"outcome": "landed", "landing": landing} if landing else {"outcome": "airborne"}
    if scene["kind"] == "pitch":
        return throw(scene, dt)[2]
    if scene["kind"] == "at-bat":
        return bat(scene, dt)
    incoming = scene["incoming"]
    if abs(incoming["position"][1]) >= scene["bat"]["length"] / 2:
        return {"outcome": "beyond_bat"}
    contact, impact = collide(scene, incoming["position"], incoming["velocity"],
                              incoming["bat_height"])  # fmt: skip
    struck = {"outcome": "struck", "impact": impact} if impact else {"outcome": "separating"}
    return struck | {"contact": contact}


def main():
    dt = float(sys.argv[sys.argv.index("--dt") + 1]) if "--dt" in sys.argv else 0.05
    for line in sys.stdin:
        scene = json.loads(line)
        print(json.dumps({"id": scene["id"]} | solve(scene, dt)), flush=True)


if __name__ == "__main__":
    main()
