"""Rules for the scenes that fail, over their fields and flags; and the smallest such scene."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import accumulate
from operator import eq, gt, lt, ne
from typing import Any

from longball.judge.cases import Case
from longball.judge.diagnosis.residual import SWITCHES, options
from longball.model.quantities import numbers, replaced
from longball.model.readings import Reading
from longball.model.scene import KINDS, AtBatScene, Scene, written_out

Features = dict[str, Any]


def features(case: Case) -> Features:
    """Return the features of a scene for rules: numbers, switches, flags and kind."""
    scene: Any = case.scene
    found: Features = {name: float(value) for name, value in numbers(scene)}
    found |= {f"flag {flag}": True for flag in case.flags if flag in TOLD_BY_NO_FIELD}
    found |= {**options(scene), "outcome": case.expected.outcome}
    landing, contact, impact = case.expected.landing, case.expected.contact, case.expected.impact
    if landing is not None:
        found["direction at landing"] = "+x" if float(landing.velocity[0]) > 0 else "-x"
        found["landing.hang_time"] = float(landing.hang_time)
        found["landing speed"] = math.hypot(*map(float, landing.velocity))
        x, y, _ = map(float, landing.position)
        found |= {"landing.position[0]": x, "landing.position[1]": y}
    if impact is not None:
        if scene.kind == "at-bat":
            found["launch speed"] = math.hypot(*map(float, impact.velocity))
        found["impact.restitution"] = float(impact.restitution)
        if impact.mode is not None:
            found["impact.mode"] = impact.mode
    if contact is not None and contact.normal_speed is not None:
        found["contact.normal_speed"] = float(contact.normal_speed)
    if contact is not None and contact.normal is not None:
        found["contact.normal[2]"] = float(contact.normal[2])
    if (velocity := getattr(getattr(scene, "pitch", None), "velocity", None)) is not None:
        found["pitch.speed"] = math.hypot(*velocity)
    elif hasattr(scene, "pitch"):
        rise = scene.pitch.aim[1] - scene.pitch.release[2]
        found["pitch.aim[1] - pitch.release[2]"] = rise
    for block in ("launch", "pitch", "incoming"):
        if (spin := getattr(getattr(scene, block, None), "spin", None)) is not None:
            found[f"size of {block}.spin"] = math.hypot(*spin)
    if scene.kind == "flight" and any(scene.launch.velocity):
        x, y, z = scene.launch.velocity
        found["launch speed"] = math.hypot(x, y, z)
        found["launch angle in degrees"] = math.degrees(math.atan2(z, math.hypot(x, y)))
    if landing is not None:
        speeds = found.get("launch speed", 0.0), found["landing speed"]
        found["larger speed of launch and landing"] = max(speeds)
    return found


# Flags for what a program meets on the way; no field of the scene or the result shows it.
TOLD_BY_NO_FIELD = frozenset((
    "tangential", "grazing", "kink", "tie", "vertex", "grip-slide", "loops", "vertical",
    "second-touching", "blown-back",
))  # fmt: skip


# A rule holds for the wrong scenes and for no right one. By chance one rule does so with the
# probability 1/choices (`Condition.choices`); it is reported if there are CHANCE times as many
# choices as rules that are tried.
CHANCE = 100

FEWEST = 5  # fewer scenes, wrong or right, are no rule: those made for one question are alike
DEFAULTS = dict(numbers(AtBatScene()))  # what a program may have built in
USUAL = 3  # scenes that must have a value for it to be the usual one
HALVES = 8  # conditions that are tried as the first of two: those with the fewest right scenes
MOST_RULES = 3  # rules for the same scenes that are reported: more of them say nothing


def rule(failing: Sequence[Case], passing: Sequence[Case], measured: bool = True) -> str | None:
    """Return the smallest rules that hold for all that fail and none that pass; None without one.

    A rule is one condition, or two that must both hold; limits of numbers are conditions only if
    `measured`. A few rules for the same scenes are all reported: any of them may be the cause.
    """
    wrong, right = [*map(features, failing)], [*map(features, passing)]
    if min(len(wrong), len(right)) < FEWEST:
        return None
    known = [one for one in _conditions(wrong, right) if measured or not one.measured]
    if whole := _text(_telling(known, wrong, right, len(known))):
        return whole
    # Two conditions: the first holds for all failing scenes and for as few others as possible, and
    # the second separates the failing scenes from those.
    cuts = [(one, [*filter(one.holds, right)]) for one in known if all(map(one.holds, wrong))]
    for one, left in sorted(cuts, key=lambda cut: len(cut[1]))[:HALVES]:
        others = [two for two in _conditions(wrong, left) if measured or not two.measured]
        tried, telling = len(known) * len(others), _telling(others, wrong, left, len(others))
        both = [other for other in telling
                if one.choices(wrong, [*filter(other.holds, right)]) >= CHANCE * tried]  # fmt: skip
        if text := _text(both):
            return f"{one.text} and {text}"
    return None


def _telling(
    conditions: Iterable[Condition],
    wrong: Sequence[Features],
    right: Sequence[Features],
    tried: int,
) -> list[Condition]:
    """Return those of `tried` conditions that separate the wrong scenes, hardly by chance."""
    likely = (one for one in conditions if one.choices(wrong, right) >= CHANCE * tried)
    telling = (one for one in likely if all(map(one.holds, wrong)))
    return [one for one in telling if not any(map(one.holds, right))]


def _text(conditions: Iterable[Condition]) -> str:
    """Return the plainest of some rules for the same scenes, in words."""
    whole: dict[str, str] = {}  # by the feature
    for one in conditions:
        whole.setdefault(one.name, one.text)
    # The first of these groups that is short enough: kinds of scenes and numbers that are 0, kinds
    # alone, the simplest of those, and if there is none of them, any rules.
    plain = [n for n in whole if _sorts(n)]
    zero = [n for n, text in whole.items() if n not in plain and text == f"{n} = 0"]
    simple = [n for n in plain if _is_simple(n)]
    for names in (plain + zero, plain, simple, [] if plain or zero else list(whole)):
        if 0 < len(names) <= MOST_RULES:
            told = sorted((whole[n] for n in names), key=lambda text: "the flag" in text)
            return "; or, which are the same scenes, ".join(told)
    return ""


def _sorts(name: str) -> bool:
    """True if scenes are sorted by a feature, such as a kind: numbers may follow from it."""
    return name in SWITCHES or _is_simple(name)


def _is_simple(name: str) -> bool:
    """True if it is no form of a block or a law, of which several may go together."""
    one_of = ("kind", "outcome", "air", "impact.mode")
    return name in one_of or name.startswith(("reading.", "flag "))


@dataclass(frozen=True)
class Condition:
    """A condition on a scene: a feature, in words, and the values for which it holds."""

    name: str
    text: str
    of: Callable[[Any], bool]
    without: bool = False  # whether it holds for scenes that have no such feature
    measured: bool = False  # whether it is one of how large a number is

    def holds(self, found: Features) -> bool:
        """True if it holds for a scene with such features."""
        return self.of(found[self.name]) if self.name in found else self.without

    def choices(self, wrong: Sequence[Features], right: Sequence[Features]) -> int:
        """Return the number of ways to choose so many scenes."""
        if not self.measured:
            return math.comb(len(wrong) + len(right), len(wrong))
        # Scenes with the same number fail together: the choice is of its values.
        values, others = _values(wrong, self.name), _values(right, self.name)
        return math.comb(len({*values, *others}), len({*values}))


def _values(some: Sequence[Features], name: str) -> list[Any]:
    return [f[name] for f in some if name in f]


def _conditions(wrong: Sequence[Features], right: Sequence[Features]) -> Iterator[Condition]:
    """Yield conditions that may separate the wrong scenes from the right ones."""
    for name in dict.fromkeys(name for f in (*wrong, *right) for name in f):
        values, others = _values(wrong, name), _values(right, name)
        if name.startswith("flag "):
            yield Condition(name, f"the {name}", bool)
            continue
        if not values:
            continue
        usual, times = Counter(others).most_common(1)[0] if others else (None, 0)
        differs = Condition(name, f"{name} ≠ {_told(usual)}", partial(ne, usual))
        often = times >= USUAL and 2 * times > len(others)
        number = isinstance(values[0], float)
        # "≠ 0" comes before "= 0.3": scenes that have a wind say more than the speed of the wind.
        # Another "≠" is no property of scenes, except for a default, which a program may have built
        # in.
        if often and usual == 0.0:
            yield differs
        if len(set(values)) == 1:
            is_some = number and values[0] != 0.0
            text = f"{name} = {_told(values[0])}"
            yield Condition(name, text, partial(eq, values[0]), measured=is_some)
        if often and usual != 0.0 and (not number or usual == DEFAULTS.get(name)):
            yield differs
        if number and (below := [v for v in others if v < min(values)]):
            low = max(below) and _between(max(below), min(values))
            if _is_short(low):
                yield Condition(name, f"{name} > {low:g}", partial(lt, low), measured=True)
        if number and (above := [v for v in others if v > max(values)]):
            high = min(above) and _between(max(values), min(above))
            if _is_short(high):
                yield Condition(name, f"{name} < {high:g}", partial(gt, high), measured=True)


def _told(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _is_short(limit: float) -> bool:
    return float(f"{limit:.4g}") == limit  # one that needs more digits hardly parts the scenes


def _between(a: float, b: float) -> float:
    """Return a short number that is above a, and below b or b itself; 0 if it may be that."""
    if a < 0.0 < b:
        return 0.0
    middle = (a + b) / 2
    shorter = (float(f"{middle:.{digits}g}") for digits in range(1, 17))
    return next((short for short in shorter if a < short < b), middle)


# --- the smallest scene ---------------------------------------------------------------------------

LARGEST_SHRINKS = 6

NOTHING = 1e-9  # numbers below this are the rounding of a zero


Simplification = Callable[[Any], Any]  # what makes a scene simpler


def simpler(scene: Scene) -> Iterator[Simplification]:
    """Yield changes that make one block or number of a scene plain, or take its air away."""
    fields = type(scene).model_fields
    if scene.reading != Reading():
        yield lambda s: type(s).model_validate(s.model_dump() | {"reading": {}})
    if getattr(scene, "air", None) is not None:
        yield lambda s: type(s).model_validate(s.model_dump() | {"air": None})
    for block in ("air", "ball", "bat", "ground", "swing", "pitch", "gravity", "time_limit"):
        if block in fields and not fields[block].is_required():
            yield partial(_without, block)
    for name, value in numbers(scene):
        for short in (0.0, *(float(f"{value:.{digits}g}") for digits in (1, 2, 3))):
            if short != value and (short or abs(value) < NOTHING):
                yield partial(replaced, values={name: short})
                break


def _without(block: str, scene: Any) -> Any:
    rest = {key: held for key, held in scene.model_dump().items() if key != block}
    return KINDS[scene.kind].model_validate(rest)


def shrunk(scene: Any, fails: Callable[[Sequence[Any]], Sequence[bool]]) -> Any:
    """Return a smaller scene that still fails.

    `fails` takes several scenes, so that a candidate is run once for all, and returns a flag for
    each.
    """

    def failing(scenes: Sequence[Any]) -> Sequence[bool]:
        named = (s.model_copy(update={"id": f"shrunk-{i}"}) for i, s in enumerate(scenes))
        return fails([written_out(s) for s in named])

    for _ in range(LARGEST_SHRINKS):
        changed = [(_simplified(scene, change), change) for change in simpler(scene)]
        tried = [pair for pair in changed if pair[0] is not scene]
        # The plainest come last: it is those that a program may break off at.
        tried.sort(key=lambda pair: _plainness(pair[0]), reverse=True)
        bad = failing([new for new, _ in tried]) if tried else []
        good = [change for (_, change), fails_too in zip(tried, bad, strict=True) if fails_too]
        if not good:
            break
        # The changes on top of each other, the plainest first. The longest pile that still fails
        # begins the next round. The first change alone is known to fail.
        piled = [*accumulate(reversed(good), _simplified, initial=scene)][1:]
        known = [True, *failing(piled[1:])] if piled[1:] else [True]
        scene = [new for new, still in zip(piled, known, strict=True) if still][-1]
    return scene.model_copy(update={"id": "shrunk"})


def _simplified(scene: Any, change: Simplification) -> Any:
    """Return a scene with a change; as it is if that is none, or no plainer."""
    try:
        new = change(scene)
    except ValueError:  # a ValidationError, too
        return scene
    return new if _plainness(new) < _plainness(scene) else scene


def _plainness(scene: Any) -> tuple[Any, ...]:
    """Return a sort key: scenes without air come first, then those with the fewest keys."""
    has_air = getattr(scene, "air", None) is not None
    return has_air, len(str(scene.model_dump(exclude_defaults=True))), len(scene.line())
