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


# Flags of events on the way that no field of the scene or the result shows.
TOLD_BY_NO_FIELD = frozenset((
    "tangential", "grazing", "kink", "tie", "vertex", "grip-slide", "loops", "vertical",
    "second-touching", "blown-back",
))  # fmt: skip


# A rule holds for all wrong scenes and for no right one. By chance a given rule does so with the
# probability 1/choices (`Condition.choices`). A rule is reported if there are at least ODDS times
# as many choices as rules that were tried.
ODDS = 100  # a free choice

# Limits of the search: free choices.
# No rule for fewer scenes, wrong or right: golden scenes that test one thing are alike, so that
# many rules separate a few of them from others.
FEWEST = 5
DEFAULTS = dict(numbers(AtBatScene()))  # values that a program may have built in
USUAL = 3  # a value is the usual one if at least so many scenes have it
HALVES = 8  # conditions that are tried as the first of two
MOST_RULES = 3  # rules for the same scenes that are reported; of more, none would help


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
    # Two conditions: the first holds for all failing scenes and for few others; the second
    # separates the failing scenes from these others.
    cuts = [(one, [*filter(one.holds, right)]) for one in known if all(map(one.holds, wrong))]
    for one, left in sorted(cuts, key=lambda cut: len(cut[1]))[:HALVES]:
        others = [two for two in _conditions(wrong, left) if measured or not two.measured]
        tried, telling = len(known) * len(others), _telling(others, wrong, left, len(others))
        both = [other for other in telling
                if one.choices(wrong, [*filter(other.holds, right)]) >= ODDS * tried]  # fmt: skip
        if text := _text(both):
            return f"{one.text} and {text}"
    return None


def _telling(
    conditions: Iterable[Condition],
    wrong: Sequence[Features],
    right: Sequence[Features],
    tried: int,
) -> list[Condition]:
    """Return the conditions that separate wrong and right scenes, and are unlikely by chance.

    `tried` is the number of conditions that were tried.
    """
    likely = (one for one in conditions if one.choices(wrong, right) >= ODDS * tried)
    telling = (one for one in likely if all(map(one.holds, wrong)))
    return [one for one in telling if not any(map(one.holds, right))]


def _text(conditions: Iterable[Condition]) -> str:
    """Return the plainest of some rules for the same scenes, in words."""
    whole: dict[str, str] = {}  # by the feature
    for one in conditions:
        whole.setdefault(one.name, one.text)
    # Report the first of these groups that is short enough: sorts of scenes and numbers equal to 0;
    # sorts alone; the simplest sorts; and, if there are neither sorts nor zeros, all rules.
    plain = [n for n in whole if _sorts(n)]
    zero = [n for n, text in whole.items() if n not in plain and text == f"{n} = 0"]
    simple = [n for n in plain if _is_simple(n)]
    for names in (plain + zero, plain, simple, [] if plain or zero else list(whole)):
        if 0 < len(names) <= MOST_RULES:
            told = sorted((whole[n] for n in names), key=lambda text: "the flag" in text)
            return "; or, which are the same scenes, ".join(told)
    return ""


def _sorts(name: str) -> bool:
    """True for a feature that sorts scenes, such as the kind: numbers may follow from it."""
    return name in SWITCHES or _is_simple(name)


def _is_simple(name: str) -> bool:
    """True for a feature that is not the form of a block or a law; such forms go together."""
    one_of = ("kind", "outcome", "air", "impact.mode")
    return name in one_of or name.startswith(("reading.", "flag "))


@dataclass(frozen=True)
class Condition:
    """A condition on a feature of a scene, its words, and the values for which it holds."""

    name: str
    text: str
    of: Callable[[Any], bool]
    measured: bool = False  # True if it is a limit of a number

    def holds(self, found: Features) -> bool:
        """True if the condition holds for a scene with these features."""
        return self.name in found and self.of(found[self.name])

    def choices(self, wrong: Sequence[Features], right: Sequence[Features]) -> int:
        """Return the number of ways to choose as many scenes as are wrong."""
        if not self.measured:
            return math.comb(len(wrong) + len(right), len(wrong))
        # Scenes with the same number fail together: the choice is among different numbers.
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
        # "≠ 0" comes before "= 0.3": that the scenes have a wind is a better rule than its speed.
        # Other "≠" are rules only for a default, which a program may have built in.
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
    return float(f"{limit:.4g}") == limit  # a longer limit is a coincidence of the scenes


def _between(a: float, b: float) -> float:
    """Return a short number between a and b, which may be b; 0 if a and b have opposite signs."""
    if a < 0.0 < b:
        return 0.0
    middle = (a + b) / 2
    shorter = (float(f"{middle:.{digits}g}") for digits in range(1, 17))
    return next((short for short in shorter if a < short < b), middle)


# --- the smallest scene ---------------------------------------------------------------------------

LARGEST_SHRINKS = 6  # rounds of simplification, each runs the candidate up to twice; a free choice

NOTHING = 1e-9  # smaller numbers are rounding errors of zero; a free choice


Simplification = Callable[[Any], Any]  # from a scene to a simpler one


def simpler(scene: Scene) -> Iterator[Simplification]:
    """Yield changes that simplify one block or number of a scene, or remove its air."""
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
        # The plainest scenes come last: if the candidate crashes at one, the others are answered.
        tried.sort(key=lambda pair: _plainness(pair[0]), reverse=True)
        bad = failing([new for new, _ in tried]) if tried else []
        good = [change for (_, change), fails_too in zip(tried, bad, strict=True) if fails_too]
        if not good:
            break
        # Apply the changes on top of each other, the plainest first. The longest sequence that
        # still fails begins the next round. The first change alone is known to fail.
        piled = [*accumulate(reversed(good), _simplified, initial=scene)][1:]
        known = [True, *failing(piled[1:])] if piled[1:] else [True]
        scene = [new for new, still in zip(piled, known, strict=True) if still][-1]
    return scene.model_copy(update={"id": "shrunk"})


def _simplified(scene: Any, change: Simplification) -> Any:
    """Return a changed scene; the scene itself if the change is invalid or no simpler."""
    try:
        new = change(scene)
    except ValueError:  # a ValidationError, too
        return scene
    return new if _plainness(new) < _plainness(scene) else scene


def _plainness(scene: Any) -> tuple[Any, ...]:
    """Return a sort key: scenes without air come first, then those with the fewest keys."""
    has_air = getattr(scene, "air", None) is not None
    return has_air, len(str(scene.model_dump(exclude_defaults=True))), len(scene.line())
