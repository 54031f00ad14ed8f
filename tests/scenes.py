"""Scenes that several files test: the golden cases, and scenes drawn at random.

`random_scene` mixes all keys and readings of the model: a scene is drawn as a JSON object from a
`random.Random`, so that a seed and a number name it. Each key and each reading is there in some of
the scenes, with any of the others that it may stand with. Sizes are those of a ball field: a ball
flies seconds, not hours. Random scenes of the paper's model are the judge's (`fresh`).
"""

from __future__ import annotations

import json
import math
import random
from functools import cache, partial
from types import UnionType
from typing import Annotated, Union, get_args, get_origin

from hypothesis import strategies as st
from pydantic import BaseModel

from longball import golden
from longball.golden.reader import EXTENDED
from longball.judge import fresh
from longball.model import result
from longball.model.scene import parse_scene

FAMILIES = tuple(golden.header().families)


@cache
def cases_of(family: str) -> tuple[golden.Case, ...]:
    """Return the golden cases of a family."""
    return tuple(golden.load(family))


def all_cases() -> list[golden.Case]:
    """Return the golden cases of all families, in the order of the files."""
    return [case for family in FAMILIES for case in cases_of(family)]


def paper_cases() -> list[golden.Case]:
    """Return the golden cases of the paper's model."""
    return [case for family in FAMILIES if family not in EXTENDED for case in cases_of(family)]


def case_of(identity: str) -> golden.Case:
    """Return the golden case of an id."""
    return next(case for case in all_cases() if case.id == identity)


# --- for hypothesis -------------------------------------------------------------------------------


def between(low, high):
    return st.floats(low, high, allow_subnormal=False)


def scenes():
    """Scenes of all kinds with any keys and readings."""
    return st.integers(0, 10**6).map(
        lambda seed: parse_scene(json.dumps(random_scene(random.Random(seed))))
    )


def paper_scenes(*kinds):
    """Scenes of the paper's model, of some kinds or of all."""
    return st.builds(
        lambda seed, kind: next(fresh.random_scenes(1, seed, [kind])),
        st.integers(0, 10**6),
        st.sampled_from(kinds or fresh.DRAWN),
    )


decimals = st.from_regex(r"[+-]?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,3})?", fullmatch=True)
radii = st.from_regex(r"[0-9](\.[0-9]{1,8})?[eE]-[0-9]{1,3}", fullmatch=True)
finite = st.floats(allow_nan=False, allow_infinity=False)
# Values of the parts of which the fields of results are made; other types have hypothesis's own.
VALUES = {
    float: finite,
    result.Bounded: st.builds(result.Bounded, value=decimals, radius=st.none() | radii),
    result.Certified: st.builds(result.Certified, value=finite, radius=radii),
}


def drawn(kind):
    """Any value of a type that a field of a result may have."""
    if kind in VALUES:
        return VALUES[kind]
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        fields = {name: field.annotation for name, field in kind.model_fields.items()}
        if kind is result.Result:
            del fields["path"]  # points, whose lines are long
        return st.builds(kind, **{name: drawn(each) for name, each in fields.items()})
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return drawn(parts[0])
    if origin is tuple:
        return st.tuples(*map(drawn, parts))
    if origin in (Union, UnionType):
        return st.one_of(*map(drawn, parts))
    return st.from_type(kind)


def results():
    """Any valid result, of whatever engine."""
    return drawn(result.Result)


# --- drawn at random ------------------------------------------------------------------------------

COEFFICIENTS = ("constant", "spin", "speed", "table")

# Numbers that a block has some of, and between what they lie.
SOME = {
    "ball": {"mass": (0.12, 0.17), "radius": (0.03, 0.045), "restitution": (0.2, 0.7)},
    "bat": {"mass": (0.7, 1.2), "length": (0.7, 1.1), "radius": (0.025, 0.04)},
    "earth": {"azimuth": (-3, 3)},
    "weather": {
        "temperature": (265, 312),
        "pressure": (97_000, 104_000),
        "humidity": (0, 1),
        "elevation": (-50, 2200),
    },
    "spin": {"constant": (0.2, 0.4), "per_spin": (0, 5e-4)},
    "crisis": {
        "high_speed": (0.1, 0.4),
        "low_speed": (0.4, 0.6),
        "speed": (20, 45),
        "width": (1, 6),
    },
    "linear": {"slope": (-0.5, 1.5)},
    "rational": {"numerator": (0.5, 1.5), "constant": (0.3, 0.8), "slope": (1.5, 3)},
}


def random_scene(rng):
    kind = rng.choices(["flight", "pitch", "impact", "at-bat"], [4, 1, 1, 6])[0]
    scene, ground = {"kind": kind}, 0.0
    reading = random_reading(rng)
    plain = reading.get("lift_direction") == "always_up"  # takes neither spin nor wind nor table
    spins = not plain and rng.random() < 0.65
    if rng.random() < 0.5:
        scene["ball"] = some(rng, "ball")
    if kind in ("impact", "at-bat"):
        scene["bat"], scene["swing"] = random_bat(rng, reading), random_swing(rng)
    if kind == "flight":
        ground = rng.choice([0.0, rng.uniform(-2, 2)])
        radius = scene.get("ball", {}).get("radius", 0.0366)
        floor = ground + (radius if "ground_contact" in reading else 0.0)
        scene["launch"] = random_launch(rng, spins, floor)
    if kind in ("pitch", "at-bat"):
        scene["pitch"] = random_pitch(rng, spins)
    if kind == "impact":
        scene["swing"].pop("height_offset", None)
        scene["incoming"] = random_incoming(rng, scene, spins)
    else:
        if kind == "at-bat" and rng.random() < 0.3:
            ground = rng.uniform(-2, 0.1)
        if ground:
            scene["ground"] = {"height": ground}
        scene |= random_surroundings(rng, kind, spins, plain, ground)
    if reading:
        scene["reading"] = reading
    if "friction" in scene.get("bat", {}) and rng.random() < 0.5:
        scene["ball"] = scene.get("ball", {}) | {"inertia_factor": rng.uniform(0.3, 0.667)}
    if not plain and scene.get("air") and rng.random() < 0.2:
        side = {"value": rng.uniform(-0.1, 0.1), "direction": direction(rng)}
        scene["air"]["side_coefficient"] = side
    return scene


def some(rng, block, **draws):
    """Some of the keys of a block, each drawn when it is there."""
    draws = {key: partial(rng.uniform, *ends) for key, ends in SOME.get(block, {}).items()} | draws
    return {key: draw() for key, draw in draws.items() if rng.random() < 0.6}


def direction(rng):
    x, y, z = (rng.gauss(0, 1) for _ in range(3))
    size = math.sqrt(x * x + y * y + z * z)
    return [x / size, y / size, z / size]


def random_reading(rng):
    options = {
        "effective_mass": "as_printed",
        "bat_ball_restitution": rng.choice(["nathan", "plain"]),
        "reduced_mass": "effective_mass",
        "inertia": rng.choice(["thin_rod", "about_centre"]),
        "ground_contact": "surface",
        "slide_direction": "final",
        "spin_parameter": "total",
        "drag_spin": "total",
        "spin_decay": rng.choice(["time", "nathan"]),
        "wind_acts_on": "drag",
        "pressure": "station",
        "fence_clearance": "surface",
        "distance_origin": "launch",
    }
    often = rng.choice([0.0, 0.25, 0.5])
    reading = {name: option for name, option in options.items() if rng.random() < often}
    if rng.random() < 0.3:
        reading["spin_decay"] = rng.choice(["time", "nathan"])
    if rng.random() < 0.08:
        reading["lift_direction"] = "always_up"
    if reading.get("bat_ball_restitution") == "plain":
        reading.pop("reduced_mass", None)  # the two contradict each other
    return reading


def random_spin(rng):
    if rng.random() < 0.03:
        return [0.0, 0.0, 0.0]
    size = rng.uniform(10, 400)
    if rng.random() < 0.3:  # backspin or topspin of a flight along x
        return [0.0, rng.choice([-1, 1]) * size, 0.0]
    return [size * c for c in direction(rng)]


def random_launch(rng, spins, floor):
    speed, up, side = rng.uniform(8, 60), rng.uniform(-0.3, 1.45), rng.uniform(-1.2, 1.2)
    if rng.random() < 0.1:
        side = rng.uniform(-math.pi, math.pi)
    level = speed * math.cos(up)
    velocity = [level * math.cos(side), level * math.sin(side), speed * math.sin(up)]
    height = floor + (rng.uniform(0.2, 2.5) if rng.random() < 0.8 else rng.uniform(2, 60))
    odd = rng.random()
    if odd < 0.04:  # off the ground
        height, velocity[2] = floor, abs(velocity[2]) + 1
    elif odd < 0.07 and not spins:
        velocity = [0.0, 0.0, rng.choice([0.0, speed, -speed])]
    launch = {"position": [rng.uniform(-1, 2), rng.uniform(-1, 1), height], "velocity": velocity}
    return launch | ({"spin": random_spin(rng)} if spins else {})


def random_pitch(rng, spins):
    pitch = {}
    if rng.random() < 0.6:
        pitch["release"] = [rng.uniform(15, 19), rng.uniform(-0.8, 0.8), rng.uniform(1.4, 2.3)]
    if rng.random() < 0.3:
        speed, (x, y, _) = rng.uniform(30, 48), pitch.get("release", [18.44, 0.0, 1.8])
        across = (rng.uniform(-0.4, 0.4) - y) * speed / x
        pitch["velocity"] = [-speed, across, rng.uniform(-2.5, 1.5)]
    else:
        pitch |= some(
            rng,
            "pitch",
            speed=lambda: rng.uniform(28, 48),
            aim=lambda: [rng.uniform(-0.4, 0.4), rng.uniform(1.2, 2.4)],
        )
    return pitch | ({"spin": random_spin(rng)} if spins else {})


def random_bat(rng, reading):
    bat = some(rng, "bat")
    if rng.random() < 0.6:
        bat["support"] = rng.choice(["pivot", "free"])
        if bat["support"] == "free" and reading.get("effective_mass") == "as_printed":
            bat["support"] = "pivot"
    if rng.random() < 0.6:
        bat["friction"] = 10 ** rng.uniform(-2, 0.3)
        if rng.random() < 0.6:
            bat["tangential_restitution"] = rng.uniform(-1, 1)
    return bat


def random_swing(rng):
    return some(
        rng,
        "swing",
        angular_speed=lambda: rng.uniform(15, 50) if rng.random() < 0.8 else rng.uniform(-90, 0),
        tilt=lambda: rng.uniform(-0.2, 0.4),
        height_offset=lambda: rng.uniform(-0.08, 0.08),
    )


def random_incoming(rng, scene, spins):
    reach = scene.get("ball", {}).get("radius", 0.0366) + scene["bat"].get("radius", 0.033)
    angle, height = rng.uniform(-1.5, 1.5), rng.uniform(0.3, 1.5)
    half = scene["bat"].get("length", 1.0) / 2
    return {
        "position": [
            reach * math.cos(angle),
            rng.uniform(-1.05, 1.05) * half,
            height + reach * math.sin(angle),
        ],
        "velocity": [-rng.uniform(-20, 45), rng.uniform(-5, 5), rng.uniform(-10, 10)],
        "bat_height": height,
    } | ({"spin": random_spin(rng)} if spins else {})


def random_surroundings(rng, kind, spins, plain, ground):
    """Air, ground, fence and Earth around a ball in flight."""
    around = {}
    if rng.random() < 0.3:
        around["gravity"] = rng.choice([9.81, 9.7807, 0.0, rng.uniform(1.6, 15)])
    if rng.random() < 0.2:
        around["earth"] = {"latitude": rng.uniform(-1.5, 1.5)} | some(rng, "earth")
    if rng.random() < 0.1 or around.get("gravity") == 0:
        around["time_limit"] = rng.uniform(0.3, 3)
    if kind != "pitch" and rng.random() < 0.6:
        around["fence"] = random_fence(rng)
    if rng.random() < 0.04:
        return around | {"air": None}
    if rng.random() < 0.9:
        around["air"] = random_air(rng, spins, plain, ground)
    return around


def random_fence(rng):
    """A polyline around the field, with a step at times and a dent at others; or a circle."""
    if rng.random() < 0.2:
        return {"radius": rng.uniform(20, 130)}
    corners = rng.randint(2, 7)
    size = rng.uniform(15, 100)
    polyline = []
    for index in range(corners):
        bearing = math.pi / 4 * (1 - 2 * index / (corners - 1))
        if 0 < index < corners - 1:  # not in the plane in which many a ball flies
            bearing += rng.uniform(-0.1, 0.1)
        away = size * rng.uniform(0.85, 1.2)
        corner = [away * math.cos(bearing), away * math.sin(bearing)]
        polyline.append([*corner, rng.uniform(0.5, 8)])
        if 0 < index < corners - 1 and rng.random() < 0.2:
            polyline.append([*corner, rng.uniform(2, 16)])
    return {"polyline": polyline}


def random_air(rng, spins, plain, ground):
    air = {}
    weather = rng.random() < 0.4
    if weather:
        air["density"] = some(rng, "weather")
    elif rng.random() < 0.4:
        air["density"] = rng.uniform(0.8, 1.4)
    if rng.random() < 0.3:
        air["density_scale_height"] = 10 ** rng.uniform(2.5, 4)
    if not plain and rng.random() < 0.6:
        air["wind"] = random_wind(rng, ground)
    if spins and rng.random() < 0.5:
        air["spin_decay_length"] = 10 ** rng.uniform(1.7, 3.3)
    mach = weather and "temperature" in air["density"]
    if rng.random() < 0.8:
        air["drag_coefficient"] = random_drag(rng, spins, plain, mach)
    if rng.random() < 0.8:
        air["lift_coefficient"] = random_lift(rng, spins, plain, mach)
    return air


def random_wind(rng, ground):
    velocity = [rng.uniform(-9, 9), rng.uniform(-9, 9), 0.0]
    form = rng.choice(["uniform", "above", "profile"])
    if form == "profile" and ground > -0.005:
        return {"velocity": velocity, "height": rng.uniform(2, 20)} | some(
            rng, "wind", roughness=lambda: 10 ** rng.uniform(-2, 0)
        )
    velocity[2] = rng.choice([0.0, rng.uniform(-2, 2)])
    if form == "above":
        heights = [rng.uniform(0, 1), rng.uniform(1, 30), rng.choice([0.0, max(ground, 0.0)])]
        return {"velocity": velocity, "above": rng.choices(heights, [5, 5, 1])[0]}
    return velocity


def random_drag(rng, spins, plain, mach):
    law = rng.choice(COEFFICIENTS)
    if law == "spin" and spins:
        return {"law": "spin"} | some(rng, "spin")
    if law == "speed":
        crisis = some(rng, "crisis")
        if spins and rng.random() < 0.4:
            crisis["per_spin"] = rng.uniform(0, 3e-4)
        return {"law": "crisis"} | crisis
    if law == "table" and not plain:
        return random_table(rng, spins, mach, lambda: rng.uniform(0.15, 0.6))
    value = rng.choice([0.0, rng.uniform(0.1, 0.6), rng.uniform(0.1, 0.6)])
    return rng.choice([value, {"law": "constant", "value": value}])


def random_lift(rng, spins, plain, mach):
    law = rng.choice(COEFFICIENTS)
    if law in ("spin", "speed") and spins:
        laws = [{"law": law} | some(rng, law) for law in ("bilinear", "linear", "rational")]
        return rng.choice(laws)
    if law == "table" and not plain:
        return random_table(rng, spins, mach, lambda: rng.uniform(-0.1, 0.4))
    value = rng.choice([0.0, rng.uniform(0.02, 0.35), rng.uniform(-0.25, -0.02)])
    return rng.choice([value, {"law": "constant", "value": value}])


def random_table(rng, spins, mach, value):
    of = rng.choice(["speed"] + ["mach"] * mach + ["spin_parameter"] * spins)
    top = {"speed": 60, "mach": 0.18, "spin_parameter": 0.6}[of]
    at = sorted(round(rng.uniform(0, top), 4) for _ in range(rng.randint(2, 7)))
    at = sorted(set(at)) if len(set(at)) > 1 else [0.0, top]
    return {"law": "table", "of": of, "at": at, "values": [value() for _ in at]}
