"""Random scenes for studies and tests, as they are written: any kind, any size, close calls.

`FAMILIES` are functions of a kind and a generator. `baseball` is what one meets on a field; `wide`
goes far beyond it; `extreme` has sizes from 1e-30 to 1e30; `close` has what is hard to tell: balls
that graze the bat, the ground or the bat's end, ties with the time limit, verticals, bat and ball
that hardly approach each other. `extended` has what the paper's model does not: spin, wind,
weather, laws and tables of the coefficients, the turning Earth, fences, friction of ball and bat;
and whatever other key the schema of the air has.
"""

import json
import math
from collections.abc import Callable
from typing import Any, get_args

import numpy as np
from pydantic import ValidationError

from longball.engines import create
from longball.engines.chain import solve
from longball.model.air import Air
from longball.model.block import LARGEST, SMALLEST
from longball.model.quantities import flat, nested
from longball.model.readings import Reading
from longball.model.scene import KINDS, Scene

Written = dict[str, Any]
Generator = np.random.Generator


def size(generator: Generator, low: float, high: float) -> float:
    """Return a positive number whose logarithm is uniform."""
    return math.exp(generator.uniform(math.log(low), math.log(high)))


def random_reading(generator: Generator) -> dict[str, str]:
    """Return an option of every switch that scenes have."""
    reading: dict[str, str] = {
        name: generator.choice(get_args(field.annotation)).item()
        for name, field in Reading.model_fields.items()
    }
    if reading["bat_ball_restitution"] == "plain":
        reading["reduced_mass"] = "bat_mass"
    return reading


def baseball(kind: str, generator: Generator) -> Written:
    """Return a scene of the paper's kind, under any reading."""
    scene: Written = {"id": "baseball", "kind": kind, "reading": random_reading(generator)}
    swing = {"angular_speed": generator.uniform(20.0, 45.0), "tilt": generator.uniform(0.0, 0.3)}
    if kind == "impact":
        velocity = [generator.uniform(-50.0, -20.0), generator.normal(), generator.normal(0.0, 3.0)]
        return scene | {"swing": swing, "incoming": touching(generator, 0.0366, 0.033, velocity)}
    if kind == "flight":
        speed, rise = generator.uniform(5.0, 60.0), generator.uniform(-0.5, 1.5)
        level, heading = speed * math.cos(rise), generator.uniform(-3.1, 3.1)
        velocity = [level * math.cos(heading), level * math.sin(heading), speed * math.sin(rise)]
        position = [0.0, 0.0, size(generator, 0.04, 3.0)]
        return scene | {"launch": {"position": position, "velocity": velocity}}
    speed, *aim = generator.normal([37.0, 0.0, 1.8], [3.0, 0.2, 0.2]).tolist()
    scene["pitch"] = {"speed": speed, "aim": aim}
    if kind == "at-bat":
        scene["swing"] = swing | {"height_offset": generator.normal(0.0, 0.03)}
    return scene


def wide(kind: str, generator: Generator) -> Written:
    """Return a scene with sizes far beyond baseball."""
    return _sized(kind, generator, 1.0)


def extreme(kind: str, generator: Generator) -> Written:
    """Return a scene some of whose numbers have any size that a scene may have."""
    scene = _sized(kind, generator, generator.choice([0.3, 3.0, 10.0]))
    for _ in range(generator.integers(0, 4)):
        values = dict(flat(scene))
        names = [x for x in values if isinstance(values[x], float) and "incoming" not in x]
        name = names[generator.integers(len(names))]
        values[name] = math.copysign(size(generator, SMALLEST, LARGEST), values[name])
        scene = nested(values)
    if kind == "impact":
        ball, bat, incoming = scene["ball"], scene["bat"], scene["incoming"]
        scene["incoming"] = touching(generator, ball["radius"], bat["radius"], incoming["velocity"])
    if generator.random() < 0.3:
        scene["time_limit"] = size(generator, 1e-6, 1e4)
    return scene


def close(kind: str, generator: Generator) -> Written:
    """Return a scene with a question that is hard to decide."""
    scene = baseball(kind, generator)
    nudge = generator.choice([0.0, 1.0, -1.0]) * size(generator, 1e-17, 1e-6)
    match kind, generator.integers(3):
        case "impact", 0:  # the bat's end
            scene["incoming"]["position"][1] = float(generator.choice([-0.5, 0.5])) + nudge
        case "impact", 1:  # hardly approaching: along the surface of the bat, which moves along x
            swing, (x, y, z) = scene["swing"], scene["incoming"]["position"]
            moving = swing["angular_speed"] * (0.5 - y) * math.cos(swing["tilt"])
            along, height = generator.normal(0.0, 20.0), z - scene["incoming"]["bat_height"]
            velocity = [moving - along * height / 0.0696 + nudge, 0.0, along * x / 0.0696]
            scene["incoming"]["velocity"] = velocity
        case "flight", 0:  # to be at rest in the air, or all but so
            scene["launch"]["velocity"] = [nudge, 0.0, generator.choice([0.0, 10.0])]
        case "flight", 1:  # level over the ground
            scene["launch"]["position"][2] = 0.0366 * (1.0 + abs(nudge))
            level, rise = generator.uniform(1.0, 60.0), generator.choice([0.0, nudge])
            scene["launch"]["velocity"] = [level, 0.0, rise]
        case "pitch" | "flight", _:  # ends with the time limit
            block = "landing" if kind == "flight" else "plate"
            scene["time_limit"] = float(_quantity(scene, block, "time") or 1.0) * (1.0 + nudge)
        case "at-bat", 0:  # grazes the bat
            scene["swing"]["height_offset"] = 0.0
            if _quantity(scene, "contact", "margin") is not None:
                sign = float(generator.choice([-1.0, 1.0]))
                scene["swing"]["height_offset"] = sign * (0.0696 + nudge)
        case "at-bat", 1:  # the bat's end
            if (position := _quantity(scene, "contact", "position")) is not None:
                scene["pitch"]["aim"][0] += 0.5 + nudge - position[1]
    return scene


AIR = Air.model_json_schema()  # which takes milliseconds to make


# Each law of motion is compiled, which takes a second: some are drawn, once for all scenes.
LAWS = 40


def extended(kind: str, generator: Generator, law: Generator | None = None) -> Written:
    """Return a scene of the extended model, on a field or far beyond it; `law` draws its law."""
    scene = (baseball if generator.random() < 0.6 else wide)(kind, generator)
    if kind != "impact":
        _blow(scene, law or np.random.default_rng(generator.integers(LAWS)), generator)
    if kind in ("impact", "at-bat"):
        factor = _maybe(generator, generator.uniform(0.3, 0.7))
        scene["ball"] = scene.get("ball", {}) | {"inertia_factor": factor}
        scene["bat"] = scene.get("bat", {}) | _rough_bat(scene["reading"], generator)
    if kind == "impact":
        scene["incoming"]["spin"] = _maybe(generator, _spin(generator))
    if kind in ("flight", "at-bat"):
        scene["ground"] = {"height": generator.uniform(-2.0, 0.0)}
        scene["fence"] = _maybe(generator, _fence(generator))
    return scene


def _blow(scene: Written, law: Generator, generator: Generator) -> None:
    """Give a scene an air, a spin and an Earth: what there is of them by a law, and how much."""
    scene["reading"] |= {
        name: law.choice(get_args(Reading.model_fields[name].annotation)).item()
        for name in ("spin_parameter", "drag_spin", "spin_decay", "wind_acts_on", "pressure")
    } | {"lift_direction": "fixed_spin_axis"}
    uniform = generator.uniform
    coefficient = uniform(0.05, 0.6)
    at = np.cumsum(uniform(1.0, 12.0, 4)).tolist()
    values = [0.0 if law.random() < 0.5 else coefficient, *uniform(0.05, 0.6, 3)]
    crisis = {"law": "crisis", "speed": uniform(5.0, 50.0), "width": size(generator, 0.1, 10.0)}
    linear = {"law": "linear", "slope": uniform(0.5, 1.5)}
    # What needs a spin comes last.
    spins = law.random() < 0.8
    tables: list[Written] = [
        {"of": "speed", "at": at},
        {"of": "mach", "at": [x / 340.0 for x in at]},
        {"of": "spin_parameter", "at": [0.0, *(x / 40.0 for x in at[:3])]},
    ]

    def coefficient_of(others: list[Written]) -> Written:
        table = {"law": "table", "values": values} | tables[law.integers(3 if spins else 2)]
        laws: list[Written] = [{"law": "constant", "value": coefficient}, table, *others]
        return laws[law.integers(len(laws) if spins else 2)]

    drag = coefficient_of([{"law": "spin", "constant": coefficient}, crisis])
    lift = coefficient_of([{"law": "rational"}, linear, {"law": "bilinear"}])
    blowing = (size(generator, 0.1, 30.0) * generator.standard_normal(3)).tolist()
    winds: list[Any] = [
        None,
        blowing,
        {"velocity": blowing, "above": uniform(0.0, 10.0)},
        {"velocity": [*blowing[:2], 0.0], "height": 10.0, "roughness": uniform(0.02, 0.1)},
    ]
    weather = {"temperature": uniform(260.0, 320.0), "humidity": uniform()}
    weather["elevation"] = uniform(0.0, 2000.0)
    by_weather = law.random() < 0.5 or "mach" in (drag.get("of"), lift.get("of"))
    scene["air"] = {
        "density": weather if by_weather else size(generator, 0.01, 10.0),
        "drag_coefficient": drag,
        "lift_coefficient": lift,
        "wind": winds[law.integers(len(winds))],
        "spin_decay_length": _maybe(law, size(generator, 10.0, 1e4)) if spins else None,
        "density_scale_height": _maybe(law, uniform(5e3, 1e4)),
    }
    scene["earth"] = _maybe(law, {"latitude": uniform(-1.57, 1.57), "azimuth": uniform(-3.1, 3.1)})
    schema, further = AIR, generator.spawn(1)[0]
    for name, part in schema["properties"].items():
        if name not in scene["air"] and law.random() < 0.25:
            scene["air"][name] = _allowed(part, schema["$defs"], further)
    spin = _spin(generator) if spins else None
    if scene["kind"] == "flight":
        scene["launch"]["spin"] = spin
        return
    scene["pitch"]["spin"] = spin
    if generator.random() < 0.3:
        velocity = [generator.normal(-37.0, 3.0), generator.normal(), generator.normal()]
        scene["pitch"] = {"velocity": velocity, "spin": spin}


def _allowed(schema: Written, named: Written, generator: Generator) -> Any:
    """Return random data of a JSON schema: all of its keys, with numbers of about 0.3."""
    match schema:
        case {"anyOf": [first, *_]}:
            return _allowed(first, named, generator)
        case {"$ref": where}:
            return _allowed(named[where.rpartition("/")[2]], named, generator)
        case {"properties": parts}:
            return {key: _allowed(part, named, generator) for key, part in parts.items()}
        case {"prefixItems": parts}:
            return [_allowed(part, named, generator) for part in parts]
    limits = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
    return float(np.clip(generator.normal(0.0, 0.3), *limits))


def _maybe(generator: Generator, value: Any) -> Any:
    """Return a value, or at times nothing."""
    return value if generator.random() < 0.6 else None


def _spin(generator: Generator) -> list[float]:
    """Return a spin, rad/s, at times about an axis of the field."""
    way = generator.standard_normal(3)
    if generator.random() < 0.2:
        way *= np.eye(3)[generator.integers(3)]
    return [float(x) for x in size(generator, 1.0, 600.0) * way / math.sqrt(way @ way)]


def _rough_bat(reading: dict[str, str], generator: Generator) -> Written:
    bat: Written = {"friction": _maybe(generator, size(generator, 0.01, 3.0))}
    if bat["friction"] is not None:
        bat["tangential_restitution"] = _maybe(generator, generator.uniform(-1.0, 1.0))
    if reading["effective_mass"] != "as_printed":
        bat["support"] = _maybe(generator, "free")
    return bat


def _fence(generator: Generator) -> Written:
    """Return a fence around the outfield: a circle, or chords of different heights."""
    if generator.random() < 0.3:
        return {"radius": generator.uniform(20.0, 130.0)}
    count = generator.integers(2, 8)
    angles = np.sort(generator.uniform(-0.8, 0.8, count))[::-1].tolist()
    corners = zip(angles, generator.uniform(20.0, 130.0, count), strict=True)
    across = ((far * math.cos(angle), far * math.sin(angle)) for angle, far in corners)
    return {"polyline": [[x, y, generator.uniform(0.0, 12.0)] for x, y in across]}


FAMILIES: dict[str, Callable[[str, Generator], Written]] = {
    family.__name__: family for family in (baseball, wide, extreme, close, extended)
}


def random_scene(family: str, number: int, seed: int) -> Scene:
    """Return a valid scene of a family; kinds take turns with the number, and readings vary.

    What is drawn does not depend on other numbers.
    """
    kind = list(KINDS)[number % len(KINDS)]
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    while True:
        written = FAMILIES[family](kind, generator) | {"id": f"{family}-{seed}-{number}"}
        try:
            return KINDS[kind].model_validate_json(json.dumps(written))
        except ValidationError:
            continue  # underground, or not touching


def touching(
    generator: Generator, ball_radius: float, bat_radius: float, velocity: list[float]
) -> Written:
    """Return an incoming ball that touches the bat anywhere around it."""
    angle, reach = generator.uniform(-math.pi, math.pi), ball_radius + bat_radius
    y = generator.normal(0.0, 0.3)
    position = [reach * math.cos(angle), y, 1.0 + reach * math.sin(angle)]
    return {"position": position, "velocity": velocity, "bat_height": 1.0}


def _sized(kind: str, generator: Generator, spread: float) -> Written:
    """Return a scene; `spread` is how far the logarithms of its sizes are spread, 1 being wide."""

    def any_size(low: float, high: float) -> float:
        middle = math.sqrt(low * high)
        return float(middle * (size(generator, low, high) / middle) ** spread)

    def or_nothing(low: float, high: float) -> float:
        return 0.0 if generator.random() < 0.1 else any_size(low, high)

    def velocity() -> list[float]:
        way = generator.standard_normal(3)
        return [float(x) for x in any_size(0.1, 300.0) * way / math.sqrt(way @ way)]

    bat_mass = any_size(0.1, 10.0)
    ball = {
        "mass": bat_mass * any_size(1e-6, 1e6),
        "radius": any_size(0.01, 0.1),
        "restitution": generator.random(),
    }
    scene: Written = {"kind": kind, "ball": ball, "reading": random_reading(generator)}
    bat = {"mass": bat_mass, "length": any_size(0.1, 10.0), "radius": any_size(0.01, 0.1)}
    turning, tilt = generator.normal(0.0, 50.0), generator.uniform(-math.pi, math.pi)
    swing = {"angular_speed": turning, "tilt": tilt}
    if kind == "impact":
        incoming = touching(generator, ball["radius"], bat["radius"], velocity())
        return scene | {"bat": bat, "swing": swing, "incoming": incoming}
    scene["gravity"] = or_nothing(1e-3, 300.0)
    scene["air"] = {
        "density": or_nothing(1e-4, 100.0),
        "drag_coefficient": or_nothing(0.01, 2.0),
        "lift_coefficient": float(generator.choice([-1, 1])) * or_nothing(0.01, 2.0),
    }
    if kind == "flight":
        height = ball["radius"] + or_nothing(1e-9, 100.0)
        return scene | {"launch": {"position": [0.0, 0.0, height], "velocity": velocity()}}
    scene["pitch"] = {
        "speed": any_size(0.1, 300.0),
        "release": [any_size(0.3, 30.0), generator.normal(), ball["radius"] + any_size(0.1, 10.0)],
        "aim": [generator.normal(0.0, 0.5), any_size(0.1, 10.0)],
    }
    if kind == "at-bat":
        return scene | {"bat": bat, "swing": swing | {"height_offset": generator.normal(0.0, 0.05)}}
    return scene


def _quantity(scene: Written, block: str, name: str) -> Any:
    """Return a quantity of the result, by the batch engine; None if there is none."""
    try:
        parsed = KINDS[scene["kind"]].model_validate_json(json.dumps(scene))
    except ValidationError:
        return None
    return getattr(getattr(solve(parsed, create("batch")), block), name, None)
