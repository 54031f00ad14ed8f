"""How a scene may be misread: other scenes that follow from what a scene is made of.

A vector may be read in another order, with other signs or without a component; a key may be
ignored, or taken for its default; two numbers of a block may be exchanged, or one taken for the
other; a sign may be lost, a reading be another one, numbers be rounded. None of these mistakes is
listed by hand, so that a new key of a scene can be misread, too.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, get_args

import numpy as np

from longball.judge.changes import Mistake, reading_change, scene_change
from longball.judge.findings import many
from longball.judge.stages import COLLISION, Change, Numbers, with_values
from longball.model.air import WindAbove, WindProfile
from longball.model.atmosphere import density
from longball.model.block import Block
from longball.model.numbers import DOUBLES
from longball.model.quantities import at, numbers
from longball.model.readings import Reading

_SCENE = "take the scene's {}"

# The blocks whose numbers a stage depends on; all, of the others.
_FLYING = ("launch", "pitch", "spin", "air", "gravity", "earth", "ball", "ground", "time_limit")
_STRIKING = ("ball", "bat", "swing", "incoming", "spin")
_BLOCKS: dict[str, tuple[str, ...]] = {
    "pitch": _FLYING, "flight": _FLYING, "spin decay": _FLYING, "landing": ("ground", "ball"),
    "touching": ("pitch", "ball", "bat", "swing"), "fence": ("fence", "ball"),
    **dict.fromkeys(COLLISION, _STRIKING),
}  # fmt: skip

# Vectors that stand in several places.
_PLACES: dict[str, tuple[str, ...]] = {
    "spin": ("launch.spin", "pitch.spin", "incoming.spin"),
    "air.wind": ("air.wind", "air.wind.velocity"),
}
_NAME_OF = {place: name for name, places in _PLACES.items() for place in places}


def misreadings(scenes: Iterable[Any], stage: str) -> list[Mistake]:
    """Return how scenes may be misread in what a stage depends on."""
    found: dict[Mistake, None] = {}
    for scene in scenes:
        for name, mistakes in _of_scene(scene):
            if name.partition(".")[0] in _BLOCKS.get(stage, name):
                found |= dict.fromkeys(mistakes)
    return [*found, *_other_readings()]


# --- what a scene holds ---------------------------------------------------------------------------


@dataclass(frozen=True)
class _Held:
    """A value of a scene: its name, its unit, the default (None without one)."""

    name: str
    value: Any
    unit: str
    default: Any


def _held(block: Block, way: str = "") -> Iterator[_Held]:
    """Yield what stands in a block and in the blocks within it."""
    for key, field in type(block).model_fields.items():
        value, name = getattr(block, key), f"{way}{key}"
        if value is None or isinstance(value, Reading) or key == "kind":
            continue
        unit = (field.description or "").replace(";", ",").partition(",")[0].partition(" ")[0]
        default = None if field.is_required() else field.get_default(call_default_factory=True)
        yield _Held(name, value, unit if unit in _UNITS else "", default)
        if isinstance(value, Block):
            yield from _held(value, f"{name}.")


_UNITS = ("kg", "m", "m/s", "rad", "rad/s", "Pa", "K", "s", "m/s²", "kg/m³")


def alike(scene: Any, unit: str) -> list[str]:
    """Return the names of a scene's numbers that have a unit."""
    return [h.name for h in _held(scene) if h.unit == unit and isinstance(h.value, float)]


def _of_scene(scene: Any) -> Iterator[tuple[str, list[Mistake]]]:
    """Yield the name of each value of a scene, with how it may be misread."""
    known = list(_held(scene))
    for held in known:
        name = _NAME_OF.get(held.name, held.name)
        match held.value:
            case Block():
                found = _of_block(held)
            case tuple() if name.endswith(".values"):
                found = [_reversed(name), *(_extrapolated(name, where) for where in _OUTSIDE)]
            case (float(), float(), *rest) if len(rest) < 2 and not name.endswith(".at"):
                found = _of_vector(name, held)
            case float():
                found = [_unsigned(name), _positive(name)] if held.value < 0 else []
                if isinstance(held.default, float) and held.value != held.default:
                    found.append(_usual(name, held.default))
            case _:
                found = []
        optional = held.default is None and name in _OPTIONAL
        yield name, [*found, *([_ignored(name)] if optional else [])]
    for (block, unit), keys in _alike(known).items():
        yield block, [_in_unit(block, unit, tuple(keys), *one) for one in _UNITS_FOR.get(unit, ())]
    for a, b in itertools.combinations(_points(known), 2):
        block = a.name.rpartition(".")[0]
        if block and block == b.name.partition("[")[0].rpartition(".")[0] and a.unit == b.unit:
            yield a.name, [_exchanged(a.name, b.name), _taken(a.name, b.name),
                           _taken(b.name, a.name), _added(a.name, b.name)]  # fmt: skip


# Keys that a scene may leave out, and that can be ignored where it does not.
_OPTIONAL = (
    "spin", "air.wind", "air.spin_decay_length", "air.density_scale_height", "earth", "fence",
    "bat.support", "bat.friction", "bat.tangential_restitution",
)  # fmt: skip


# What the numbers of a block may be taken for, and what that makes of them.
_UNITS_FOR = {
    "m/s": (("km/h", 1 / 3.6), ("mph", 0.44704), ("ft/s", 0.3048)),
    "rad": (("degrees", math.pi / 180),),
}


def _alike(known: Iterable[_Held]) -> Mapping[tuple[str, str], list[str]]:
    """Return the numbers of each block that have the same unit, where there are several."""
    found: dict[tuple[str, str], list[str]] = {}
    for held in known:
        if isinstance(held.value, float) and "." in held.name:
            found.setdefault((held.name.rpartition(".")[0], held.unit), []).append(held.name)
    return {key: names for key, names in found.items() if len(names) > 1}


def _points(known: Iterable[_Held]) -> Iterator[_Held]:
    """Yield the numbers of a scene, those of the throw's two points among them."""
    for held in known:
        if isinstance(held.value, float):
            yield held
        elif held.name in ("pitch.release", "pitch.aim"):
            first = 3 - len(held.value)  # a point aimed at has no x
            yield from (_Held(f"{held.name}[{i - first}]", x, "xyz"[i], None)
                        for i, x in enumerate(held.value, first))  # fmt: skip


def _of_block(held: _Held) -> list[Mistake]:
    """Return how a block that stands for a number, or has numbers of a law, may be misread."""
    found = []
    if isinstance(held.default, float):
        found.append(_usual(held.name, held.default))
    if hasattr(held.value, "law") and any(
        not field.is_required() for field in type(held.value).model_fields.values()
    ):
        found.append(_usual_numbers(held.name, held.value.law))
    if held.name == "air.wind":
        found += [_same_wind(form) for form, (kind, _) in _WINDS.items()
                  if isinstance(held.value, kind)]  # fmt: skip
    return found


def _of_vector(name: str, held: _Held) -> list[Mistake]:
    """Return how a vector may be misread."""
    shown = _arrangements("xyz"[-len(held.value) :])
    found = [_arranged(name, one) for one in shown if _in_order(held.value, one) != held.value]
    if held.default is not None:
        found.append(_usual(name, held.default))
    return found


@cache
def _arrangements(letters: str) -> list[str]:
    """Return other readings of a vector's letters, one thing done to each: "x -y z"."""
    own = list(letters)
    found = [["-" + a for a in own], *(["0" if a != kept else a for a in own] for kept in own)]
    for i, a in enumerate(own):
        for other in ("0", f"-{a}", f"|{a}|"):
            found.append([*own[:i], other, *own[i + 1 :]])
        for j in range(i):
            swapped = own.copy()
            swapped[i], swapped[j] = own[j], own[i]
            found.append(swapped)
    found.append(["0"] * len(own))
    return list(dict.fromkeys(map(" ".join, found)))


# --- the changes ----------------------------------------------------------------------------------

# Each is made once, so that what it does to a scene is not computed anew.


@cache
def _arranged(name: str, shown: str) -> Mistake:
    def change(scene: Any) -> Mapping[str, Any]:
        found = {}
        for place in _PLACES.get(name, (name,)):
            vector = _vector(scene, place)
            if vector is not None and len(vector) == len(shown.split()):
                found[place] = _in_order(vector, shown)
        return found

    told = f"({', '.join(shown.split())})"
    nothing = set(shown.split()) == {"0"}
    sentence = f"ignores {name}" if nothing else f"reads {name} as {told}"
    return _misread(f"{name}:{told}", sentence, name, scene_change(change))


def _vector(scene: Any, place: str) -> Numbers | None:
    try:
        found = at(scene, place)
    except ValueError:
        return None
    return found if isinstance(found, tuple) else None


def _in_order(vector: Numbers, shown: str) -> Numbers:
    known = dict(zip("xyz"[-len(vector) :], vector, strict=True)) | {"0": 0.0}
    signs: dict[str, Callable[[float], float]] = {"-": float.__neg__, "|": abs}
    return tuple(signs.get(a[0], float)(known[a.strip("-|")]) for a in shown.split())


def _misread(name: str, sentence: str, what: str, change: Change) -> Mistake:
    return Mistake(name, sentence, _SCENE.format(what), change)


def _possible(values: Callable[[Any], Mapping[str, Any]]) -> Change:
    """Return the change of blocks of a scene; none where that makes no scene."""

    def change(scene: Any) -> Any:
        new = changed.scene(scene)
        try:
            return type(scene).model_validate(new.model_dump())
        except ValueError:
            return scene

    changed = scene_change(values)
    return Change(change)


def _set(name: str, value: Callable[[Any], Any], told: str, sentence: str) -> Mistake:
    """Return the mistake of another value, from the one that the scene has."""
    change = _possible(lambda scene: {name: value(at(scene, name))})
    return _misread(f"{name}{told}", sentence, name, change)


@cache
def _ignored(name: str) -> Mistake:
    places = [place for place in _PLACES.get(name, (name,)) if not place.endswith(".velocity")]
    change = _possible(lambda scene: dict.fromkeys(places))
    return _misread(f"{name}-ignored", f"ignores {name}", name, change)


@cache
def _usual(name: str, default: Any) -> Mistake:
    told = (
        f"{default:g}"
        if isinstance(default, float)
        else f"({', '.join(map('{:g}'.format, default))})"
    )
    return _set(name, lambda held: default, f"={told}",
                f"takes {told} for {name}, whatever the scene says")  # fmt: skip


@cache
def _usual_numbers(name: str, law: str) -> Mistake:
    def usual(held: Any) -> Any:
        fields = type(held).model_fields.items() if getattr(held, "law", "") == law else ()
        return held.model_copy(update={
            key: field.default for key, field in fields if not field.is_required()})  # fmt: skip

    return _set(name, usual, f"-{law}-defaults", f"takes the defaults of the {law} law of {name}, "
                "whatever the scene says")  # fmt: skip


_WINDS: Mapping[str, tuple[Any, str]] = {
    "": (Block, ""), "-above": (WindAbove, " where the scene has it above a height"),
    "-profile": (WindProfile, " where it has a profile"),
}  # fmt: skip


@cache
def _same_wind(form: str) -> Mistake:
    kind, where = _WINDS[form]
    return _set("air.wind", lambda wind: wind.velocity if isinstance(wind, kind) else wind,
                f"-everywhere{form}", f"has the same wind at all heights{where}")  # fmt: skip


@cache
def _reversed(name: str) -> Mistake:
    return _set(name, lambda held: held[::-1], "-reversed", f"takes {name} in the reverse order")


@cache
def _in_unit(block: str, unit: str, names: tuple[str, ...], other: str, factor: float) -> Mistake:
    change = scene_change(lambda scene: {name: factor * at(scene, name) for name in names})
    return _misread(f"{block}-in-{other}", f"takes the numbers of {block} in {unit} for {other}",
                    block, change)  # fmt: skip


_OUTSIDE = {"below": "first line below", "above": "last line above",
            "outside": "first and last line outside"}  # fmt: skip


@cache
def _extrapolated(name: str, where: str) -> Mistake:
    block = name.rpartition(".")[0]

    def line(x: float, ends: Sequence[tuple[float, float]]) -> tuple[float, float]:
        (a, left), (b, right) = ends
        return x, left + (x - a) * (right - left) / (b - a)

    def change(scene: Any) -> Mapping[str, Any]:
        table = at(scene, block)
        nodes = [*zip(table.at, table.values, strict=True)]
        low = [line(0.0, nodes[:2])] if table.at[0] and where != "above" else []
        high = [line(100 * table.at[-1], nodes[-2:])] if where != "below" else []
        places, values = zip(*low, *nodes, *high, strict=True)
        return {f"{block}.at": places, name: values}

    return _misread(f"{block}-extrapolated-{where}", f"goes on along the {_OUTSIDE[where]} the "
                    f"table of {block}", block, scene_change(change))  # fmt: skip


@cache
def _unsigned(name: str) -> Mistake:
    return _set(name, abs, "-unsigned", f"takes {name} without its sign")


@cache
def _positive(name: str) -> Mistake:
    return _set(name, lambda x: max(x, 0.0), "-positive", f"counts a negative {name} as 0")


def _both(a: str, b: str, values: Callable[[float, float], tuple[float, float]]) -> Change:
    def change(scene: Any) -> Mapping[str, Any]:
        held = at(scene, a), at(scene, b)
        both = all(isinstance(x, float) for x in held)
        return dict(zip((a, b), values(*held), strict=True)) if both else {}

    return scene_change(change)


@cache
def _exchanged(a: str, b: str) -> Mistake:
    change = _both(a, b, lambda x, y: (y, x))
    return _misread(f"{a}-{b}-exchanged", f"exchanges {a} and {b}", f"{a} and {b}", change)


@cache
def _taken(a: str, b: str) -> Mistake:
    change = _both(a, b, lambda x, y: (y, y))
    return replace(_misread(f"{b}-for-{a}", f"takes {b} for {a}", a, change), scaled=a)


@cache
def _added(a: str, b: str) -> Mistake:
    change = _both(a, b, lambda x, y: (x, x + y))
    return _misread(f"{b}-from-{a}", f"counts {b} from {a}", b, change)


# --- readings -------------------------------------------------------------------------------------

ALL_READINGS = "ignores-reading"


@cache
def _other_readings() -> tuple[Mistake, ...]:
    """Return the mistakes of having one option of a switch always, and of having no readings."""
    found = []
    for name, field in Reading.model_fields.items():
        for option in get_args(field.annotation):
            ignored = option == field.default
            how = "ignores" if ignored else "mistakes"
            sentence = f"{how} reading.{name}: acts as if it were {option}"
            found.append(Mistake(f"{name}={option}", sentence, f"take reading.{name} from the "
                                 f"scene; its default is {field.default}",
                                 reading_change(**{name: option})))  # fmt: skip
    none = Change(lambda scene: scene.model_copy(update={"reading": Reading()}))
    whole = Mistake(ALL_READINGS, "ignores the scene's reading block", "take the switches of "
                    "scene.reading, or leave those scenes out with --golden", none)  # fmt: skip
    return *found, whole


# --- digits ---------------------------------------------------------------------------------------


def with_density(scene: Any, value: float) -> Any:
    """Return a scene with another density at height 0, kg/m³."""
    # That of the weather is linear in the pressure, on which nothing else hangs.
    if isinstance(scene.air.density, float):
        return with_values(scene, {"air.density": value})
    pressures = 0.0, float(scene.air.density.pressure)
    low, high = (of_weather(scene, pressure=p) for p in pressures)
    share = (value - low) / (high - low)
    return with_values(scene, {"air.density.pressure": share * pressures[1]})


def of_weather(scene: Any, **other: float) -> float:
    """Return the density of a scene's weather, kg/m³, with some of its numbers others."""
    named = {f"air.density.{name}": value for name, value in other.items()}
    return float(density(with_values(scene, named), DOUBLES))


def _with_single_strength(scene: Any) -> Any:
    """Return a scene with the density of a k = ρ A/(2 m) in single precision."""
    if getattr(scene, "air", None) is None:
        return scene
    dense, ball = float(density(scene, DOUBLES)), scene.ball
    k = dense * math.pi * ball.radius**2 / (2 * ball.mass)
    return with_density(scene, dense * float(np.float32(k)) / k) if k else scene


def _to_half(x: float) -> float:
    with np.errstate(over="ignore"):  # 65504 is the largest
        return float(np.float16(x))


def _read_to(short: Callable[[float], float], place: str = "") -> Change:
    """Return the change of all numbers of a scene, or of those of one vector, to shorter ones."""
    return scene_change(lambda scene: {
        name: short(float(x)) for name, x in numbers(scene) if name.startswith(place)})  # fmt: skip


_DOUBLES = "use doubles throughout"

# What a program may hold in single precision that is in doubles otherwise, and with how few digits
# it may read numbers.
SHORT: tuple[Mistake, ...] = (
    Mistake("single:scene", "takes the scene's numbers in single precision", _DOUBLES,
            _read_to(lambda x: float(np.float32(x)))),
    Mistake("single:k", "has k = ρ A/(2 m) in single precision", _DOUBLES,
            Change(_with_single_strength)),
    *(Mistake(f"single:{place}", f"takes {place} in single precision", _DOUBLES,
              _read_to(lambda x: float(np.float32(x)), place))
      for place in ("gravity", "launch.velocity", "launch.position", "air.density", "ball.mass",
                    "ball.radius")),
    *(Mistake(f"read-to:{name}", f"reads the scene's numbers to {name} only", _DOUBLES,
              _read_to(short))  # type: ignore[arg-type]
      for name, short in (
          *((many(n, "decimal"), partial(round, ndigits=n)) for n in range(7)),
          *((f"{n} digits", lambda x, n=n: float(f"{x:.{n}g}")) for n in range(2, 8)),
          ("half precision", _to_half))),
    *(Mistake(f"rounded:{place}:{n}", f"rounds {place} to {many(n, 'decimal')}", _DOUBLES,
              _read_to(partial(round, ndigits=n), place))
      for place, least in (("launch.velocity", 0), ("launch.position", 0), ("pitch.speed", 0),
                           ("pitch.aim", 0), ("swing.height_offset", 2), ("swing.tilt", 2))
      for n in range(least, 7)),
)  # fmt: skip
