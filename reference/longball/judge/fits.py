"""Explanations that are changes of the chain: known mistakes, fitted numbers, two at once.

A fitted number is one that a candidate acts as if it had: by how much is it off, and of what.

For every scene the value of a parameter is found that explains a stage best, by Gauss and Newton's
method. If these values are the same in all scenes, the candidate has a number of its own, whatever
the scene says; if they are the same multiple of the scene's value, it has a factor too many.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from longball.engines.verlet import Verlet
from longball.judge.changes import Mistake
from longball.judge.contact_mistakes import BATTED, FENCE, IMPACT, TOUCHING, TWO_STEP_PUSH
from longball.judge.explanations import (
    IN_A_SCENE,
    JUMPED,
    NAMED,
    OWN_ERROR,
    Explanation,
    Sought,
)
from longball.judge.law_mistakes import LAW, OWN
from longball.judge.misreadings import SHORT, misreadings, with_density
from longball.judge.stages import COLLISION, NONE, Change, Trial, with_values
from longball.judge.steps import ITS_OWN, LIKE
from longball.model.air import (
    ConstantDrag,
    ConstantLift,
    CrisisDrag,
    LinearLift,
    RationalLift,
    SpinDrag,
    Table,
    Weather,
)
from longball.model.arrays import Array
from longball.model.atmosphere import density
from longball.model.bat import inertia_factor, tangential_restitution
from longball.model.numbers import DOUBLES
from longball.model.quantities import at

_FLIGHT = ("pitch", "flight")
DRAGS = ConstantDrag, SpinDrag, CrisisDrag, Table
LIFTS = ConstantLift, RationalLift, LinearLift, Table

_IMPULSE = ("impulse", "velocity after", "spin after", "energy", "flight")

# What is fitted, at which stages: the numbers of a scene that the stage depends on.
PARAMETERS: dict[str, tuple[str, ...]] = {name: stages for names, stages in (
    (("gravity", "air.density", "air.drag_coefficient", "air.lift_coefficient"), _FLIGHT),
    (("launch.speed", "launch.height"), ("flight",)),
    (("pitch.speed", "pitch.release[0]", "pitch.release[1]", "pitch.release[2]", "pitch.aim[0]",
      "pitch.aim[1]"), ("pitch",)),
    (("ball.mass",), ("pitch", "flight", *COLLISION)),
    (("ball.radius",), ("pitch", "touching", "flight", "landing")),
    (("ball.restitution",), ("restitution", "flight")),
    (("bat.mass",), ("restitution", "impulse", "energy")),
    (("bat.length",), ("bat velocity", "restitution")),
    (("bat.radius",), ("touching", "restitution")),
    (("swing.angular_speed", "swing.tilt"), ("bat velocity",)),
    (("swing.height_offset",), ("touching", "normal")),
    (("ground.height",), ("landing",)),
    (("spin",), (*_FLIGHT, "spin decay", *_IMPULSE)),
    (("wind", *(f"air.density.{key}" for key in Weather.model_fields),
      *(f"air.{way}_coefficient.{key}" for way, laws in (("drag", DRAGS), ("lift", LIFTS))
        for law in laws for key in law.model_fields if key not in ("law", "of")),
      "air.wind[0]", "air.wind[1]", "air.wind[2]", "air.wind.above", "air.wind.height",
      "air.wind.roughness", "air.density_scale_height", "earth.latitude", "earth.azimuth"),
     _FLIGHT),
    (("air.spin_decay_length",), (*_FLIGHT, "spin decay")),
    (("ball.inertia_factor", "bat.friction", "bat.tangential_restitution"), _IMPULSE),
    (("fence.radius",), ("fence",)),
    (tuple(OWN), _FLIGHT),
) for name in names}  # fmt: skip

# Parameters that stand for a vector's size, or for whichever a scene has.
_PLACES: dict[str, tuple[str, ...]] = {
    "launch.speed": ("launch.velocity",),
    "pitch.speed": ("pitch.velocity", "pitch.speed"),
    "launch.height": ("launch.position[2]",),
    "spin": ("launch.spin", "pitch.spin", "incoming.spin"),
    "wind": ("air.wind", "air.wind.velocity"),
}

# What counts, of a bat with friction, where a scene leaves it out.
_LEFT_OUT: dict[str, Callable[[Any], float]] = {
    "ball.inertia_factor": lambda scene: inertia_factor(scene.ball, DOUBLES),
    "bat.tangential_restitution": lambda scene: tangential_restitution(scene.bat, DOUBLES),
}


def _held(scene: Any, name: str) -> tuple[str, Any]:
    """Return where a scene has a parameter, and the number or the vector there, if it has it."""
    if name in OWN:
        return name, getattr(scene, name, OWN[name].usual)
    for place in _PLACES.get(name, (name,)):
        try:
            found = at(scene, place)
        except ValueError:
            continue
        rough = getattr(getattr(scene, "bat", None), "friction", None) is not None
        if found is None and rough and name in _LEFT_OUT:
            found = _LEFT_OUT[name](scene)
        if isinstance(found, Weather):
            found = float(density(scene, DOUBLES))
        if isinstance(found, float | int | tuple):
            return place, found
    return name, None


def _leaves_out(scene: Any, name: str) -> bool:
    """Tell whether a scene has no value of a parameter of its own, and the usual one counts."""
    return name in _LEFT_OUT and at(scene, name) is None


WEATHER = "weather"


def law_of(scene: Any, name: str) -> str | None:
    """Return the law that a number of a coefficient is in, or a density; None if it is in none."""
    if name == "air.density":
        return WEATHER if isinstance(at(scene, name), Weather) else None
    block, _, _ = name.rpartition(".")
    return getattr(at(scene, block), "law", None) if block.endswith("_coefficient") else None


def value_of(scene: Any, name: str) -> float | None:
    """Return the scene's own value of a parameter, of a vector its size; None if it has none."""
    found = _held(scene, name)[1]
    if isinstance(found, tuple):
        return math.hypot(*found)
    return None if found is None else float(found)


def with_parameter(scene: Any, name: str, value: float) -> Any:
    """Return a scene with another value of a parameter."""
    place, found = _held(scene, name)
    if name in OWN:
        return scene.model_copy(update={name: value})
    if place == "air.density":
        return with_density(scene, value)
    if isinstance(found, tuple):
        share = value / (math.hypot(*found) or 1.0)
        return with_values(scene, {place: tuple(share * x for x in found)})
    return with_values(scene, {place: value})


def _in_law(name: str, change: Callable[[Any], Any]) -> Change:
    """Return the change of a parameter of scenes, or of a number of the law that they carry."""
    return Change(change).then(OWN[name].change) if name in OWN else Change(change)


@dataclass(frozen=True)
class Fit:
    """A parameter, what the candidate has in its place, and how far that is known."""

    parameter: str
    # "fixed": the value whatever the scene says; "where": the value in scenes that say the usual
    # one; "nonzero": in those that do not say 0; "factor": times the scene's; "offset": added;
    # "default": the value where the scene leaves it out.
    form: str
    # Half the range of nine tenths of the scenes.
    value: float
    doubt: float
    varies: bool  # whether the scenes have different values, so that the forms can be told apart
    usual: float = math.nan  # the scene's value, where it is always the same
    # Those that it is known of, as another one may have a number of that name; None for all.
    laws: frozenset[str | None] | None = None

    @property
    def change(self) -> Change:
        """The chain with that value."""

        def change(scene: Any) -> Any:
            own = value_of(scene, self.parameter)
            if (
                own is None
                or (own == 0.0 and self.form == "factor")
                or (self.form == "default" and not _leaves_out(scene, self.parameter))
                or (self.form == "where" and own != self.usual)
                or (self.form == "nonzero" and own == 0.0)
                or (self.laws is not None and law_of(scene, self.parameter) not in self.laws)
            ):
                return scene
            new = {"factor": own * self.value, "offset": own + self.value}
            return with_parameter(scene, self.parameter, new.get(self.form, self.value))

        return _in_law(self.parameter, change)

    @property
    def name(self) -> str:
        """Parameter and value: ``air.density=1.205``, ``pitch.speed*3.6``."""
        symbol = {"factor": "*", "offset": "+"}.get(self.form, "=")
        digits = 6 if abs(self.value - 1) > NEARLY else 10
        return f"{self.parameter}{symbol}{self.value:.{digits}g}"

    @property
    def remedy(self) -> str:
        """How to mend it."""
        if self.parameter in OWN:
            return f"it is {OWN[self.parameter].usual:.7g}"
        if self.of_weather:
            return "see the formula that makes the density from the weather, and its constants"
        if self.is_strength:
            return "k = ρ A/(2 m) with A = π R²: see which of them it is"
        return f"take the scene's {self.parameter}"

    @property
    def is_strength(self) -> bool:
        """Whether it is a factor of drag and lift, of which no flight tells where it is from."""
        return self.parameter == "air.density" and self.form == "factor" and not self.of_weather

    @property
    def of_weather(self) -> bool:
        """Whether it is a density that the weather gives: another one is as the scene says."""
        return self.laws == frozenset((WEATHER,))

    @property
    def roundness(self) -> float:
        """How many digits the number needs, in hundredths: people choose round ones."""
        if factor_meaning(self.value, self.doubt) and self.form == "factor":
            return 0.0
        if self.value in STANDARD:
            return FEW_DIGITS / 100
        share = self.value if self.form == "factor" else self.value / (self.usual or math.nan)
        more = digits_of(float(f"{share - 1:.5g}")) if abs(share - 1) < NEARLY else math.inf
        return min(digits_of(self.value), more) / 100

    @property
    def sentence(self) -> str:
        """What the candidate does."""
        number = told(self.value, self.doubt)
        if self.form == "factor":
            number = told_factor(self.value) or number
        meant = meaning(self)
        if self.is_strength:
            return (
                f"acts as if k = ρ A/(2 m) were {number} times as large{meant}: density, π, R² or "
                "1/m, which the flights do not tell apart"
            )
        words = OWN[self.parameter].words if self.parameter in OWN else self.parameter
        words = "the density that the weather gives" if self.of_weather else words
        acts, usual = f"acts as if {words}", f"{self.usual:.6g}"
        match self.form:
            case "fixed":
                whatever = "whatever the scene says" if self.varies else f"and not {usual}"
                return f"{acts} = {number}{meant}, {whatever}"
            case "where":
                return f"{acts} = {number}{meant} where the scene says {usual}"
            case "nonzero":
                return f"{acts} = {number}{meant}, whatever the scene says besides 0"
            case "default":
                return f"{acts} = {number}, and not {usual}, where the scene leaves it out"
            case "factor":
                there = "" if self.varies else f": {self.value * self.usual:.6g} for {usual}"
                return f"{acts} were {number} times the scene's{meant}{there}"
        return f"{acts} were the scene's plus {number}{meant}"


NEARLY = 1e-4  # a factor so near to 1 is told by what it differs


def told_factor(value: float) -> str:
    """Return a factor that is nearly 1 by what it differs; nothing if it is not."""
    nearly = 0 < abs(value - 1) < NEARLY
    return f"1 {'+' if value > 1 else '-'} {abs(value - 1):.3g}" if nearly else ""


LARGEST_DENOMINATOR, FRACTION_DIGITS = 12, 4  # people write 2/3 for what needs more digits


def digits_of(number: float) -> int:
    """Return how many digits a number needs, up to ten, besides zeros at its ends."""
    return len(f"{number:.10g}".partition("e")[0].replace(".", "").strip("-0"))


def roundest(value: float, doubt: float, size: float = 1.0) -> float:
    """Return the number with the fewest digits within the doubt; people choose those."""
    # A usual factor comes before it, and zero for what is nothing beside `size`.
    if abs(value) <= max(1e-9 * size, min(3 * doubt, 1e-6 * size)):
        return 0.0
    for usual in (*STANDARD, *(factor for factor, _ in _FACTORS)):
        if abs(value - usual) <= doubt and doubt < 1e-3 * min(abs(usual), abs(usual - 1)):
            return usual
    fraction = float(Fraction(value).limit_denominator(LARGEST_DENOMINATOR))
    for digits in range(1, 10):
        if abs((short := float(f"{value:.{digits}g}")) - value) <= doubt:
            return short
        if digits == FRACTION_DIGITS and abs(fraction - value) <= doubt:
            return fraction
    return value


def snapped(fit: Fit) -> Iterator[Fit]:
    """Yield fits of usual factors and numbers that are near, within a hundredth."""
    usual = [factor for factor, _ in _FACTORS] if fit.form == "factor" else STANDARD
    for value in usual:
        if value != fit.value and abs(fit.value / value - 1) < 0.01:
            yield replace(fit, value=value, doubt=0.0)


def told(value: float, doubt: float) -> str:
    """Return a value with its interval, to the digits that this leaves."""
    if value == 0.0:
        return "0" if doubt < 1e-9 else f"0 ± {doubt:.1g}"
    if doubt <= 1e-9 * max(abs(value), 1e-3):
        return f"{value:.10g}"
    places = min(12, max(0, 1 - math.floor(math.log10(doubt))))
    return f"{value:.{places}f} ± {doubt:.1g}"


# Numbers of many digits that people choose all the same: m/s², 5 ounces in kg, and the radius of a
# circumference of 9 and of 9¼ inches in m.
STANDARD = (9.80665, 0.14175, 0.1417476, 0.036383, 0.037394)

# What a factor is, if it is one of these.
_FACTORS = (
    (3.280839895, "feet for metres"), (0.3048, "metres for feet"), (3.6, "km/h for m/s"),
    (1 / 3.6, "m/s for km/h"), (2.2369362921, "mph for m/s"), (0.44704, "m/s for mph"),
    (180 / math.pi, "degrees for radians"), (math.pi / 180, "radians for degrees"),
    (39.37007874, "inches for metres"), (0.0254, "metres for inches"), (1000.0, "g for kg, or mm"),
    (0.001, "kg for g, or m"), (100.0, "cm for m, or per cent"),
    (0.01, "m for cm, or taken for per cent"), (2.0, "doubled"),
    (0.5, "halved"), (4.0, "a diameter for a radius, squared"), (-1.0, "the sign"),
    (30 / math.pi, "rpm for rad/s"), (math.pi / 30, "rad/s for rpm"),
    (math.pi, "a π too many"), (1 / math.pi, "a π is missing"), (2.20462262, "pounds for kg"),
    (0.45359237, "kg for pounds"), (1.466666667, "ft/s for mph"), (math.sqrt(2), "a √2 too many"),
    (math.sqrt(0.5), "a √2 is missing"),
    *((pi / math.pi, f"{pi:.6g} for π") for pi in (3.14, 3.1416, 3.14159, 22 / 7)),
    (355 / 113 / math.pi, "355/113 for π"),
)  # fmt: skip


def factor_meaning(value: float, doubt: float = 0.0) -> str | None:
    """Return what a factor is, if it is a usual one."""
    for factor, name in _FACTORS:
        size = min(abs(factor), abs(factor - 1))
        near = max(3 * doubt, 1e-6 * abs(factor) if size > 0.01 else 1e-3 * size)
        if abs(value - factor) <= near and doubt < 0.01 * size:
            return name
    return None


def meaning(fit: Fit) -> str:
    """Return what a fitted factor is, in brackets; nothing if it is no usual one."""
    name = factor_meaning(fit.value, fit.doubt) if fit.form == "factor" else None
    return f" ({name})" if name else ""


ROUNDS = 10
STAYS = 0.97  # of what the round before has left: what leaves more has come to its end
FAST = 0.1  # what leaves less of it goes straight to its end
NEAR = 1e-6  # of a scene's errors: what leaves less has come near its end

# Of a number, and of the scene's own, what a last step may move it by where it has come to its end.
SETTLED, MOVED = 0.1, 1e-4

FEW_DIGITS = 3  # digits of a number that one or two scenes are enough to believe
# The doubt of a fit beside what it differs from the scene, and beside itself: more is no fit.
UNSURE, DOUBTFUL = 0.2, 1e-2
LOOSELY = 3.0  # times these, what the first scenes may leave in doubt
MISSED = 0.3  # of a scene, what a parameter may leave that may be the first of two
MOST_MISSED = 0.2  # of impacts, how many may be missed so: the others' number is held against all
FIRST = 3  # with so many scenes a number is believed that has many digits


def implied(
    trial: Trial, names: Sequence[str], sought: Sought, own: Change = NONE
) -> tuple[Array, float] | None:
    """Return the values of parameters that explain a trial best, and the share they leave."""
    # `own` is a change before it. None if the trial does not depend on all of the parameters.
    base = sought.base.then(own)
    held = [value_of(base.scene(trial.scene), name) for name in names]
    if None in held:
        return None

    def off(values: Array) -> Array:
        change = base
        for name, value in zip(names, values.tolist(), strict=True):
            change = change.then(_in_law(name, partial(with_parameter, name=name, value=value)))
        return sought.errors(trial, change)

    value = np.array(held, float)
    r = off(value)
    first = size = float(np.linalg.norm(r))
    if not r.size or first == 0.0:
        return None
    move, slopes = 0.0 * value, None
    for count in range(ROUNDS):
        if count == 3 and size > 0.7 * first:
            break  # it leads nowhere
        if slopes is None:
            steps = np.diag(1e-6 * np.maximum(np.abs(value), 1e-3))
            ahead = [off(value + step) for step in steps]
            if any(a.shape != r.shape for a in ahead):
                return None
            slopes = np.array([(a - r) / step.sum() for a, step in zip(ahead, steps, strict=True)])
            if not slopes.any(axis=1).all():
                return None
        move = -np.linalg.lstsq(slopes.T, r, rcond=None)[0]
        # Near the end only rounding keeps a step from being better.
        for _ in range(5 if size > NEAR * first else 1):
            trying = off(value + move)
            if trying.shape == r.shape and float(np.linalg.norm(trying)) < size:
                break
            move /= 4
        else:
            break
        change, old, size = trying - r, size, float(np.linalg.norm(trying))
        value, r = value + move, trying
        # Near the end the slopes are those along the last step (Broyden's update).
        along = np.outer(move, change - move @ slopes) / (move @ move)
        slopes = slopes + along if size < FAST * old else None
        stays = size > (STAYS if count > 1 else 0.999) * old  # a step too far may lead back
        if stays or (abs(move) < 1e-12 * abs(value)).all() or size < 1e-13:
            break
    still = np.maximum(SETTLED * np.abs(value), MOVED * np.abs(np.array(held, float)))
    if (abs(move) > still).any() and size > 1e-13:
        return value, 1.0  # halved again and again, a number is on its way to 0 and not there
    return value, size / first


def fits(
    names: Sequence[str], sought: Sought, own: Change = NONE, most: float = MISSED
) -> list[list[Fit]]:
    """Return for each of some parameters the forms in which they may explain trials together.

    A parameter that leaves more than `most` of a scene, whatever its value, does not explain it.
    """
    trials, base = sought.trials, sought.base.then(own)
    found: list[tuple[Array, list[float | None]]] = []
    scenes: list[Any] = []
    missed, may_miss = 0, MOST_MISSED * len(trials) * (set(sought.stages) <= set(COLLISION))
    for trial in trials:
        if sought.work.exhausted:
            return [[] for _ in names]
        one = implied(trial, names, sought, own)
        if one is None:
            continue
        if one[1] > most:
            missed += 1  # a slope across a jump, as from grip to slide, leads nowhere
            if missed > may_miss:
                return [[] for _ in names]
            continue
        scenes.append(scene := base.scene(trial.scene))
        found.append((one[0], [value_of(scene, name) for name in names]))
        if len(found) == FIRST and not all(_all_forms(names, found, scenes, LOOSELY)):
            return [[] for _ in names]  # each scene acts as if it were another number
    if len(found) < max(1, len(trials) // 3):
        return [[] for _ in names]
    return _all_forms(names, found, scenes)


def _all_forms(
    names: Sequence[str], found: Sequence[tuple[Array, list[float | None]]], scenes: Sequence[Any],
    loosely: float = 1.0,
) -> list[list[Fit]]:  # fmt: skip
    """Return for each parameter the forms in which it explains scenes; see `_forms`."""
    values, theirs = (np.array(rows, float).T for rows in zip(*found, strict=True))
    unsaid = [all(_leaves_out(scene, name) for scene in scenes) for name in names]
    laws = [frozenset(law_of(scene, name) for scene in scenes) for name in names]
    return [
        [replace(fit, laws=known) for fit in _forms(name, value, own, left_out, loosely)]
        for known, name, value, own, left_out in zip(
            laws, names, values, theirs, unsaid, strict=True
        )
    ]


def _forms(name: str, values: Array, own: Array, unsaid: bool, loosely: float) -> list[Fit]:
    """Return the forms in which a parameter explains values; `unsaid`: all scenes leave it out.

    The doubt of a number may be so many times as large as it usually may: `loosely`.
    """
    varies = bool(np.ptp(own) > 1e-9 * np.abs(own).max(initial=0.0))
    some = own != 0  # a factor leaves the others as they are
    stay = some.any() and np.abs(values[~some]).max(initial=0.0) <= 1e-9 * np.abs(own).max()
    forms = {"fixed": values, "factor": values[some] / own[some], "offset": values - own}
    result = []
    for form, spread in ({"default": values} if unsaid else forms).items():
        if form == "factor" and not stay:
            continue
        if form == "fixed" and not varies and own[0] and factor_meaning(float(values[0] / own[0])):
            continue  # the factor says more
        if form == "fixed" and varies and not values.any() and own.all():
            continue  # so it does here
        nearly = own.all() and 0 < abs(float(np.median(values / own)) - 1) < NEARLY
        strength = not varies and name == "air.density" and nearly
        if form == "fixed" and strength and digits_of(float(np.median(values))) > ODD:
            continue  # nobody chooses such a density: the factor may be elsewhere
        if form == "offset" and not varies and not name.endswith("height"):
            continue
        low, middle, high = np.quantile(spread, (0.05, 0.5, 0.95))
        doubt = float(high - low) / 2
        size = 1.0 if form == "factor" else float(np.abs(own).max())
        fine = min(1e-9 * abs(float(middle)), 1e-3 * _difference(form, float(middle), own))
        value = roundest(float(middle), max(doubt, fine), size)
        fit = Fit(name, form, value, doubt, varies, float(own[0]))
        unsure = min(UNSURE * _difference(form, value, own), DOUBTFUL * max(abs(value), 1e-6))
        if doubt > loosely * unsure:
            continue  # scene after scene acts as if it were another number
        if len(values) < FIRST and fit.roundness > FEW_DIGITS / 100:
            continue  # nothing tells how much it differs from scene to scene
        if form == "factor" and not (varies or strength or factor_meaning(fit.value, doubt)):
            continue  # the number itself says as much
        result.append(fit)
    return result


def _difference(form: str, value: float, own: Array) -> float:
    """Return how much a fit differs from what the scenes say, in its own unit."""
    if form in ("factor", "offset"):
        return abs(value - (form == "factor"))
    return float(np.abs(value - own).max())


SNAP = 1e-4  # a usual number may leave so much more than the fitted one
ODD = 5  # digits of a number that nobody chooses, of two that are fitted at once


BEHIND = 1e-3  # the rank of a number in scenes with the usual one, behind that in all scenes


def is_odd(e: Explanation) -> bool:
    """Tell whether an explanation has a number of so many digits."""
    return e.rank >= 2 + ODD / 100


def parts(sought: Sought) -> list[Explanation]:
    """Return known mistakes and fitted numbers, with what they leave of a stage's errors."""
    if sought.stage == "flight" and type(sought.base.engine) is Verlet and not sought.base.push:
        push = list(_tried([TWO_STEP_PUSH], sought))
        if any(e.named for e in push):
            return push
    library = _library(sought)
    found = [*_tried(library, sought), *fitted(sought)]
    if any(e.named for e in found):
        return found
    return [*found, *_scaled(library, sought)]


def _library(sought: Sought) -> list[Mistake]:
    """Return the known mistakes that may show at a stage, and how its scenes may be misread."""
    stage = sought.stage
    struck = stage in ("restitution", "impulse", "velocity after", "spin after", "energy")
    return [
        *misreadings([t.scene for t in sought.trials], stage),
        *(SHORT if len(sought.trials) >= FIRST else ()),  # of one scene digits explain anything
        *(LAW if stage in ("pitch", "flight", "spin decay") else ()),
        *(BATTED if stage == "flight" else ()),
        *(TOUCHING if stage in ("touching", "normal") else ()),
        *(FENCE if stage == "fence" else ()),
        *(IMPACT if struck else ()),
    ]


def _tried(library: Iterable[Mistake], sought: Sought) -> Iterator[Explanation]:
    for mistake in library:
        if sought.work.exhausted:
            return
        left = sought.screened(mistake.change) if sought.concerned(mistake.change) else None
        if left is not None:
            yield sought.split(_explanation(mistake, left))


# Of the larger half of errors, what a law may leave to an integrator; and their least size.
MOSTLY, LARGE = 1e-2, 1e-3


def mostly(sought: Sought) -> Iterator[Explanation]:
    """Yield known laws, with what they leave of the larger errors."""
    # The rest may be an integrator's; in other scenes that may be as large as a law's.
    sized = zip(sought.sizes(NONE), sought.trials, strict=False)  # sizes of those beside follow
    large = sorted((one for one in sized if one[0] > LARGE), key=lambda one: -one[0])
    if len(large) < TRIED:
        return
    few = sought.of([t for _, t in large[: max(TRIED, len(large) // 2)]])
    for e in _tried(LAW, few):
        yield replace(e, allowed=MOSTLY)


def singles(sought: Sought) -> list[Explanation]:
    """Return what the candidate may hold in single precision."""
    return list(_tried(SHORT, sought))


def _explanation(mistake: Mistake, left: float) -> Explanation:
    return Explanation(
        mistake.name, mistake.sentence, mistake.remedy, left, 1, mistake.change,
        allowed=JUMPED if mistake.switches else NAMED,
    )  # fmt: skip


def _scaled(library: Iterable[Mistake], sought: Sought) -> Iterator[Explanation]:
    """Yield mistakes that have a number of their own, such as the speed that V² is made with."""
    for mistake in library:
        if mistake.scaled:
            one = _explanation(mistake, 1.0)
            if joined := _joined(sought, one, mistake.scaled):
                yield joined


def fitted(sought: Sought, most: float = MISSED) -> Iterator[Explanation]:
    """Yield what numbers the candidate acts as if it had; `most` as in `fits`."""
    whole_chain = sought.stage == "flight" and any(
        t.scene.kind == "at-bat" and "impact.velocity" not in t.given for t in sought.trials
    )
    for name, stages in PARAMETERS.items():
        if sought.stage not in stages and not whole_chain:
            continue
        (forms,) = fits([name], sought, most=most)
        alike = [replace(f, form="nonzero" if f.varies else "where")
                 for f in forms if f.form == "fixed" and f.roundness < ODD / 100]  # fmt: skip
        for fit in (*forms, *alike):
            left = sought.screened(fit.change)
            if left is None:
                continue
            # What is left may be another mistake, which has moved the number a little.
            for usual in snapped(fit):
                there = sought.left(usual.change)
                if there is not None and there < left + SNAP:
                    fit, left = usual, there
            rank = 2 + fit.roundness + (BEHIND if fit.form in ("where", "nonzero") else 0)
            found = Explanation(fit.name, fit.sentence, fit.remedy, left, rank, fit.change)
            yield sought.split(found)


# Numbers that a force goes with, and so may have another value in each scene.
STRENGTHS = (
    "air.density", "air.drag_coefficient", "air.lift_coefficient", "gravity", "spin", "wind",
)  # fmt: skip

WHOLLY = 1e-5  # of a scene's errors, what a number of its own may leave, besides the judge's own


def scene_by_scene(sought: Sought) -> str:
    """Return which numbers would explain all trials with another value in each; else ""."""
    found = []
    for name in STRENGTHS:
        ratios = []
        for trial, whole in zip(sought.trials, sought.sizes(NONE), strict=True):
            one = implied(trial, [name], sought)
            own = value_of(sought.base.scene(trial.scene), name)
            allowed = min(max(WHOLLY, OWN_ERROR / whole), NAMED) if whole else WHOLLY
            if one is None or not own or one[1] > allowed:
                break
            ratios.append(float(one[0][0]) / own)
        if FIRST <= len(sought.trials) == len(ratios):
            found.append(f"{name}, {min(ratios):.10g} to {max(ratios):.10g} times the scene's")
    told = "; or another ".join(found)
    return f"; another {told}, in each scene by itself would explain all" if told else ""


# --- two at once ----------------------------------------------------------------------------------


_SHORTENED = frozenset(mistake.name for mistake in SHORT)


def two(sought: Sought, known: Sequence[Explanation]) -> Iterator[Explanation]:
    """Yield two of the known mistakes and fitted numbers together."""
    # Few digits go with anything.
    known = [e for e in known if e.name not in _SHORTENED]
    for way in (pairs, one_after_another):
        found = list(way(sought, known))
        yield from found
        if any(e.named for e in found):
            return


def pairs(sought: Sought, known: Sequence[Explanation]) -> Iterator[Explanation]:
    """Yield two of the known mistakes and fitted numbers together."""
    # Small effects add up: what each does alone, in a few trials, tells which two to try.
    few = sought.some(3)
    base = few.rows(NONE)
    if not sum(map(len, base)) or sought.work.exhausted:
        return
    columns: list[tuple[Explanation | str, list[Array]]] = []
    for e in known:
        if sought.work.exhausted:
            return
        # Free, an odd number stands among the slopes.
        effect = None if is_odd(e) or e.change is None else _effect(few, e.change)
        if effect and sum(np.abs(x).sum() for x in effect) > 1e-9:
            columns.append((e, effect))
    columns += _slopes(few)
    ranked: dict[tuple[int, bool], list[tuple[float, Any, Any]]] = defaultdict(list)
    for (a, ea), (b, eb) in itertools.combinations(columns, 2):
        count = isinstance(a, str) + isinstance(b, str)
        # A number that is the same in all scenes is another part of each scene's own, and a factor
        # the same part.
        for common in (False, True) if count else (False,):
            left = _left_by((base, ea, eb), (a, b), common)
            ranked[count, common].append((left, a, b))
    # What is free fits more, and takes longer.
    tried: list[tuple[Any, Any]] = []
    most_of = {(0, False): 3, (1, False): 4, (1, True): 3, (2, True): 2, (2, False): 2}
    for key, most in most_of.items():
        for _, a, b in sorted(ranked[key], key=lambda one: one[0])[:most]:
            if (a, b) in tried or sought.work.exhausted:
                continue
            tried.append((a, b))
            if joined := _joined(sought, a, b):
                yield joined
                if joined.named:
                    return


def _left_by(
    rows: tuple[list[Array], list[Array], list[Array]], names: tuple[Any, Any], common: bool
) -> float:
    """Return what is left of errors by two effects, in each trial, or in all if `common`."""
    # Explanations have their own size; numbers, told by a name alone, any.
    if common:
        rows = tuple([np.concatenate(one)] for one in rows)  # type: ignore[assignment]
    left = 0.0
    for rest, *effects in zip(*rows, strict=True):
        free = [does for name, does in zip(names, effects, strict=True) if isinstance(name, str)]
        for name, does in zip(names, effects, strict=True):
            if not isinstance(name, str):
                rest = rest - does
        if free:
            matrix = np.array(free).T
            rest = rest - matrix @ np.linalg.lstsq(matrix, rest, rcond=None)[0]
        left += float(np.abs(rest).sum())
    return left


BOTH = 0.1  # of what one of two leaves, what both may: else the other does nothing
FIRSTS = 6  # changes that are taken for the first of two, one after the other
HELPS = 0.95  # of the errors, what the first must not leave
TRIED = 4  # trials that these are chosen by


def one_after_another(sought: Sought, known: Sequence[Explanation]) -> Iterator[Explanation]:
    """Yield two of the known mistakes and fitted numbers together, each of any size.

    The first is one that explains a scene wholly, in which the other does nothing, or else one that
    leaves least; the second explains the rest, given the first.
    """
    ranked = []
    few = sought.some(TRIED)
    wholes = few.sizes(NONE)
    for e in known:
        if e.change is None or sought.work.exhausted or not few.concerned(e.change):
            continue
        if isinstance(e.change.engine, Verlet) or is_odd(e):
            continue
        lefts = few.sizes(e.change)
        solved = sum(left <= NAMED * whole for left, whole in zip(lefts, wholes, strict=True))
        worse = sum(left > whole for left, whole in zip(lefts, wholes, strict=True))
        if sum(lefts) < HELPS * sum(wholes) and (solved or worse < len(lefts) // 2):
            ranked.append((-solved, sum(lefts), e))
    ranked.sort(key=lambda one: one[:2])
    for _, _, first in ranked[:FIRSTS]:
        assert first.change is not None
        rest = sought.given(first.change)
        seconds = [*_tried(_library(rest), rest), *fitted(rest, IN_A_SCENE)]
        best = 1.0
        for second in (e for e in seconds if e.named and e.change and not is_odd(e)):
            assert second.change is not None
            change = first.change.then(second.change)
            left = sought.left(change)
            if left is not None and left < BOTH * first.left and second.name != first.name:
                best = min(best, left)
                yield Explanation(
                    f"{first.name} and {second.name}", f"{first.sentence}; and {second.sentence}",
                    None, left, 1.9 + (first.rank + second.rank) / 100, change,
                    allowed=max(first.allowed, second.allowed),
                )  # fmt: skip
        if best < WHOLLY:
            return


def _effect(few: Sought, change: Change) -> list[Array] | None:
    """Return what a change does to the errors of each trial, if it leaves the same quantities."""
    pairs = list(zip(few.rows(NONE), few.rows(change), strict=True))
    return [a - b for a, b in pairs] if all(a.shape == b.shape for a, b in pairs) else None


def _slopes(few: Sought) -> Iterator[tuple[str, list[Array]]]:
    """Yield what a small part more of each parameter does."""
    for name, stages in PARAMETERS.items():
        if few.stage in stages:
            effect = _effect(few, Fit(name, "factor", 1.0 + 1e-5, 0.0, True).change)
            if effect and sum(np.abs(x).sum() for x in effect) > 1e-12:
                yield name, [x / 1e-5 for x in effect]


def _joined(sought: Sought, a: Explanation | str, b: Explanation | str) -> Explanation | None:
    """Return two explanations as one, the fitted numbers fitted together."""
    fixed = [x for x in (a, b) if not isinstance(x, str)]
    free = [x for x in (a, b) if isinstance(x, str)]
    own = NONE
    for x in fixed:
        assert x.change is not None
        own = own.then(x.change)
    fitted: list[Fit] = []
    if free:
        joint = [(sought.left(_together(own, some)), some)
                 for some in itertools.product(*fits(free, sought, own, IN_A_SCENE))
                 if not sought.work.exhausted]  # fmt: skip
        tried = [(left, some) for left, some in joint if left is not None]
        if not tried:
            return None
        fitted = list(min(tried, key=lambda one: one[0])[1])
    own = _together(own, fitted)
    left = sought.left(own)
    if left is None or any(f.roundness >= ODD / 100 for f in fitted):
        return None
    if left > BOTH * min((x.left for x in fixed), default=math.inf):
        return None
    if left > ITS_OWN and any(x.sentence.startswith(LIKE) for x in fixed):
        return None  # beside another mistake, any scheme errs like what is left
    both: list[Explanation | Fit] = [*fixed, *fitted]
    name, sentence = " and ".join(x.name for x in both), "; and ".join(x.sentence for x in both)
    return Explanation(name, sentence, None, left, 1.9, own)


def _together(change: Change, fitted: Iterable[Fit]) -> Change:
    for f in fitted:
        change = change.then(f.change)
    return change
