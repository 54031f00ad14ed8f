"""Explanations that are in a quantity's own numbers: how it is computed, or only written.

A constant ratio to what follows, exchanged axes, a formula with a known mistake in it, few digits.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from statistics import median
from typing import Any

import numpy as np

from longball.judge.answers import Answer
from longball.judge.explanations import Explanation, Seen, off, share_by, size_of
from longball.judge.findings import Finding, found, many
from longball.judge.fits import FEW_DIGITS, FIRST, digits_of, factor_meaning, roundest, told_factor
from longball.judge.formulas import FORMULAS, NUMBERED, View
from longball.judge.misreadings import alike
from longball.judge.quantities import QUANTITIES
from longball.judge.stages import (
    ENOUGH,
    SHORT,
    Change,
    Check,
    Numbers,
    Trial,
    Trials,
    digits,
    follow,
    stage_of,
    view_values,
    with_values,
)
from longball.model.arrays import Array
from longball.model.quantities import at

Image = Callable[[Array], Array]

RELATION = 0.5  # the rank of relations: behind known mistakes that leave as little
NUMBER = 1.5  # the rank of formulas with a number that fits: behind known mistakes

FEW_DECIMALS = 10

CERTAIN = 1e-3  # of the number in a formula, how far it may differ from scene to scene
NEAREST = 1e-11  # a factor differs from 1 by more than this: less is rounding
NOTHING = 1e-6  # a number below this is 0: what rounding leaves of one that is left out


# --- relations to what follows --------------------------------------------------------------------


def relations(chosen: Seen, beside: Seen, base: Change) -> Iterator[Explanation]:
    """Yield constant ratios and differences, exchanged axes and signs of the quantities."""
    # The stage fails in the `chosen` trials, and not in those `beside`.
    for quantity in dict.fromkeys(c.quantity for _, cs in chosen for c in cs):
        pairs = [c for _, cs in chosen for c in cs if c.quantity == quantity and not c.follows]
        if ":" in quantity or len(pairs) < 2:
            continue
        expected = np.array([c.expected for c in pairs])
        obtained = np.array([c.obtained for c in pairs])
        if not np.isfinite(expected).all():
            continue
        for number, (name, sentence, image) in enumerate(_images(quantity, expected, obtained)):

            def value(trial: Trial, check: Check, image: Image = image) -> Array:
                return image(np.array(check.expected))

            left, against = _held(chosen, beside, quantity, value)
            yield Explanation(
                name, sentence, None, left, RELATION + number / 100, quantity=quantity,
                value=_image_value(quantity, image, base), against=against,
                stage="landing" if quantity == "landing.position" else None,
            )  # fmt: skip
        if expected.shape[1] == 1 and QUANTITIES[quantity].unit:
            yield from _with_a_number(quantity, chosen, beside)


def _with_a_number(quantity: str, chosen: Seen, beside: Seen) -> Iterator[Explanation]:
    """Yield that a number of the scene is added to a quantity, or taken from it."""
    some = [(t.scene, c) for t, cs in chosen for c in cs
            if c.quantity == quantity and not c.follows]  # fmt: skip
    for name in alike(some[0][0], QUANTITIES[quantity].unit):
        own = [_number(scene, name) for scene, _ in some]
        if len(own) < FIRST or not all(own):
            continue
        ratios = [(c.obtained[0] - c.expected[0]) / x for x, (_, c) in zip(own, some, strict=True)]
        times = round(2 * median(ratios)) / 2
        if not times or max(abs(ratio - times) for ratio in ratios) > CERTAIN:
            continue

        def value(trial: Trial, check: Check, name: str = name, times: float = times) -> Numbers:
            return (check.expected[0] + times * _number(trial.scene, name),)

        left, against = _held(chosen, beside, quantity, value)
        more = f"{'+-'[times < 0]} {f'{abs(times):g} ' * (abs(times) != 1)}{name}"
        yield Explanation(
            f"{quantity} {more}", f"{quantity}: obtained = expected {more}", None, left, RELATION,
            quantity=quantity, against=against,
        )  # fmt: skip


def _number(scene: Any, name: str) -> float:
    """Return a number of a scene; 0 if it has none of that name."""
    try:
        held = at(scene, name)
    except ValueError:
        return 0.0
    return held if isinstance(held, float) else 0.0


def _held(
    chosen: Seen,
    beside: Seen,
    quantity: str,
    value: Callable[[Trial, Check], Sequence[float] | Array | None],
) -> tuple[float, float]:
    """Return the share of the errors that is left if a quantity has a value, and is made beside."""
    # What follows from what is said of the quantity itself.
    made_of = (f"{quantity}: event", *(("landing.spin",) if quantity == "landing.path" else ()))

    def left(trial: Trial, checks: Iterable[Check]) -> float:
        return sum(
            off(value(trial, c), c) if c.quantity == quantity else size_of(c)
            for c in checks if c.quantity not in made_of
        )  # fmt: skip

    whole = sum(sum(map(size_of, cs)) for _, cs in chosen)
    against = sum(
        max(0.0, off(value(t, c), c) - c.tolerance / c.scale)  # what passes may be off by that
        for t, cs in beside
        for c in cs
        if c.quantity == quantity
    )
    return share_by(chosen, left), against / whole


def _images(quantity: str, expected: Array, obtained: Array) -> Iterator[tuple[str, str, Image]]:
    """Yield simple relations between what is expected and obtained."""
    square = np.maximum((expected * expected).sum(axis=1), 1e-300)
    ratios = (obtained * expected).sum(axis=1) / square
    ratio = float(np.median(ratios))
    what = factor_meaning(ratio)
    # Scenes that expect the same are one: any number is the ratio, and the difference, of one.
    same = bool((np.ptp(expected, axis=0) <= SAME * np.abs(expected).max()).all())
    if (
        abs(ratio - 1) > NEAREST
        and np.ptp(ratios) < 1e-3 * min(max(abs(ratio), 1e-9), abs(ratio - 1))
        and (what or not same)
    ):
        nearly = (near := told_factor(ratio)) and f"({near})"
        text = "the sign is wrong" if what == "the sign" else (
            f"obtained = {nearly or f'{ratio:.8g}'} × expected"
            + (f": {what}" if what else ""))  # fmt: skip
        name = f"{quantity}*{ratio:.{10 if nearly else 6}g}"
        yield name, f"{quantity}: {text}", lambda x: ratio * x
    if expected.shape[1] == 3:
        for shown, image in TURNS:
            sentence = f"{quantity}: {shown} stands where (x, y, z) belongs"
            yield f"{quantity}:{shown}", sentence, image
        yield from _moved(quantity, expected, obtained)
        yield from _flat(quantity, expected, obtained)
        yield from _on_surface(quantity, expected, obtained)
        return
    yield from _limited(quantity, expected[:, 0], obtained[:, 0])
    if not same and np.ptp(total := obtained + expected) < 1e-3 * abs(mean := float(total.mean())):
        whole = roundest(mean, float(np.ptp(total)) / 2)
        yield (f"{whole:.6g}-{quantity}", f"{quantity}: obtained = {whole:.8g} - expected",
               lambda x: whole - x)  # fmt: skip
    shift = obtained - expected
    middle = float(np.median(shift))
    if middle and not same and np.ptp(shift) < 1e-3 * abs(middle):
        sentence = f"{quantity}: obtained = expected {'+-'[middle < 0]} {abs(middle):.8g}"
        yield f"{quantity}+{middle:.6g}", sentence, lambda x: x + middle


def _moved(quantity: str, expected: Array, obtained: Array) -> Iterator[tuple[str, str, Image]]:
    """Yield the vector that is added to all, if it is the same."""
    by = np.median(obtained - expected, axis=0)
    apart = np.linalg.norm(obtained - expected - by, axis=1)
    size = float(np.linalg.norm(by))
    least = SAME * float(np.linalg.norm(expected, axis=1).max())  # an integrator's errors are less
    if size > least and len(apart) >= FIRST and apart.max() < 1e-3 * size:
        told = f"({', '.join(f'{roundest(x, float(apart.max())):.6g}' for x in by.tolist())})"
        yield f"{quantity}+{told}", f"{quantity}: obtained = expected + {told}", lambda x: x + by


def _limited(quantity: str, expected: Array, obtained: Array) -> Iterator[tuple[str, str, Image]]:
    """Yield the number that a quantity is where it should be larger, or smaller."""
    limit = float(np.median(obtained))
    if len(expected) < FIRST or np.ptp(obtained) > SAME * abs(limit):
        return
    for symbol, word, bound, most in (
        ("<=", "above", np.minimum, expected.max()), (">=", "below", np.maximum, -expected.min())
    ):  # fmt: skip
        if (bound(expected, limit) == limit).all():
            name, sentence = f"{quantity}{symbol}{limit:.6g}", f"{quantity} is never {word} "
            sentence += f"{limit:.6g}: it is that where up to {abs(most):.6g} is right"
            yield name, sentence, lambda x, bound=bound: bound(x, limit)  # type: ignore[misc]


def _flat(quantity: str, expected: Array, obtained: Array) -> Iterator[tuple[str, str, Image]]:
    """Yield the axis along which a vector is always 0, and should not be."""
    for axis in range(1 if quantity == "plate.position" else 0, 3):  # there x is 0
        if obtained[:, axis].any() or not expected[:, axis].any():
            continue
        letter, left_out = "xyz"[axis], np.ones(3)
        left_out[axis] = 0.0
        name, told = f"{quantity}:{letter}=0", f"{quantity}: {letter} is always 0"
        if quantity == "landing.position" and axis == 2 and (expected[:, 2] < 0).all():
            name = "first-below"
            told = "ends the flight at the first step below the ground, and says that it is at it"
        yield name, told, _turned((0, 1, 2), left_out.tolist())


def _on_surface(
    quantity: str, expected: Array, obtained: Array
) -> Iterator[tuple[str, str, Image]]:
    """Yield that a ball is said to be at the plate, or on the ground, at a time when it is not."""
    axis = {"plate.position": 0, "landing.position": 2}.get(quantity)
    off = expected - obtained
    if axis is None or len(np.unique(obtained[:, axis])) > 1:
        return
    beside, there = np.delete(off, axis, axis=1), np.abs(off[:, axis])
    if np.abs(beside).max() > SAME * max(float(there.max()), 1e-3):
        return
    side = "behind" if (off[:, axis] < 0).all() else "before" if (off[:, axis] > 0).all() else ""
    where = f"{side or 'before or behind'} {'the ground' if axis else 'the plate'}"
    step = {"behind": ", as at the end of its step", "before": ", as at the step before"}
    sentence = f"gives time and place of a ball up to {there.max():.2g} m {where}"
    sentence += f"{step.get(side, '')}, and says that it is there"
    yield f"{quantity}-at-step", sentence, _with_axis(axis, float(obtained[0, axis]))


def _with_axis(axis: int, value: float) -> Image:
    return lambda x: np.where(np.arange(3) == axis, value, x)


def _turned(order: Sequence[int], signs: Sequence[float]) -> Image:
    """Return the exchange of axes, each with a factor."""
    axes, factors = list(order), np.array(signs)
    return lambda x: x[..., axes] * factors


def _turns() -> Iterator[tuple[str, Image]]:
    """Yield the other orders of three axes, with all signs."""
    signed = itertools.product((1.0, -1.0), repeat=3)
    for order, signs in itertools.product(itertools.permutations(range(3)), signed):
        if order != (0, 1, 2) or min(signs) < 0:
            letters = [("" if s > 0 else "-") + "xyz"[i] for i, s in zip(order, signs, strict=True)]
            yield f"({', '.join(letters)})", _turned(order, signs)


TURNS = tuple(sorted(_turns(), key=lambda turn: turn[0].count("-")))


def _image_value(quantity: str, image: Image, base: Change) -> Callable[[Trial], Numbers | None]:
    def value(trial: Trial) -> Numbers | None:
        known = follow(trial, base, (stage_of(quantity),))  # later stages may not follow at all
        rows = (c.expected for c in known if c.quantity == quantity)
        return next((tuple(image(np.array(row)).tolist()) for row in rows), None)

    return value


# --- formulas -------------------------------------------------------------------------------------


def formulas(chosen: Seen, beside: Seen, base: Change) -> Iterator[Explanation]:
    """Yield the known mistakes in formulas; see `relations`."""
    failing = {c.quantity for _, cs in chosen for c in cs if not c.follows}
    wanted = [f for f in FORMULAS if f.quantity in failing]
    if "landing.position" in failing:  # where the ball is at a time counted otherwise
        wanted += [f for f in FORMULAS if f.quantity == "landing.hang_time"]
    views: dict[int, View] = {}

    def tried(value: Callable[[View], Numbers], trial: Trial) -> Numbers | None:
        if id(trial) not in views:
            views[id(trial)] = _view(trial, base, min(failing))
        return _value(value, views[id(trial)])

    plain = len(wanted)
    for numbered in NUMBERED:
        said = [(t, c.obtained) for t, cs in chosen for c in cs if c.quantity == numbered.quantity]
        seen = [tried(lambda v, n=numbered, x=x: (n.number(v, x),), t) for t, x in said]  # type: ignore[misc]
        number = _settled([one[0] for one in seen if one and math.isfinite(one[0])])
        if number is not None:
            wanted.append(numbered.of(number))
    for i, f in enumerate(wanted):
        left, against = _held(chosen, beside, f.quantity, lambda t, c, f=f: tried(f.value, t))  # type: ignore[misc]
        yield Explanation(
            f.name, f.sentence, f.remedy, left, 0.0 if i < plain else NUMBER, against=against,
            quantity=f.quantity,
            value=lambda t, f=f: _value(f.value, _view(t, base, f.quantity)),  # type: ignore[misc]
        )  # fmt: skip


def _settled(numbers: Sequence[float]) -> float | None:
    """Return the round number that all are; None if there is none, or too few tell it."""
    # Where all scenes have the same bat, another mistake may be like any number.
    if len(numbers) < FIRST:
        return None
    middle, doubt = float(np.median(numbers)), float(np.ptp(numbers)) / 2
    if doubt > max(CERTAIN * abs(middle), NOTHING):
        return None
    number = roundest(middle, max(doubt, 1e-9 * abs(middle)))
    return number if digits_of(number) <= FEW_DIGITS else None


def _view(trial: Trial, base: Change, quantity: str) -> View:
    return View(*view_values(trial, base, quantity))


def _value(value: Callable[[View], Numbers], view: View) -> Numbers | None:
    try:
        return value(view)
    except (KeyError, AttributeError, TypeError, ZeroDivisionError, OverflowError, ValueError):
        return None  # of a scene that has not what the formula takes


def by_speed(chosen: Seen, base: Change) -> Iterator[Explanation]:
    """Yield that e falls or rises in proportion to the speed at which ball and bat meet."""
    name = "impact.restitution"

    def line(trial: Trial) -> tuple[float, float, float, float] | None:
        """Return e, |Ṽ·n| in m/s, and a and b of ẽ = a + b e."""
        view = _view(trial, base, name)
        if "contact.normal_speed" not in view.values:
            return None
        ends = [replace(view, scene=with_values(view.scene, {"ball.restitution": e}))
                for e in (0.0, 1.0)]  # fmt: skip
        told = [_value(lambda at: (at.collision().restitution,), end) for end in ends]
        if told[0] is None or told[1] is None:
            return None
        low, high = told[0][0], told[1][0]
        return view.e, abs(view.number("contact.normal_speed")), low, high - low

    told = [(one, c.obtained[0]) for t, cs in chosen for c in cs
            if c.quantity == name and (one := line(t)) and one[3]]  # fmt: skip
    if len(told) < ENOUGH:
        return
    speed, more = np.array([(s, (said - a) / b - e) for (e, s, a, b), said in told]).T
    if np.ptp(speed) < SAME * speed.max():
        return
    slope, start = np.polyfit(speed, more, 1).tolist()
    if not slope or np.abs(start + slope * speed - more).max() > CERTAIN * np.abs(more).max():
        return

    def value(trial: Trial) -> Numbers | None:
        if (one := line(trial)) is None:
            return None
        e, s, a, b = one
        return (a + b * (e + start + slope * s),)

    doubt = CERTAIN * abs(slope)
    yield Explanation(
        "restitution-by-speed", "has a ball's restitution that "
        f"{'falls' if slope < 0 else 'rises'} with the speed: "
        f"by {roundest(abs(slope), doubt):.6g} for each m/s above "
        f"{roundest(-start / slope, CERTAIN * abs(start / slope)):.6g} m/s",
        "ball.restitution is the same at every speed", share_by(chosen, lambda t, cs: sum(
            off(value(t), c) if c.quantity == name else size_of(c) for c in cs)),
        NUMBER, quantity=name, value=value,
    )  # fmt: skip


# --- digits ---------------------------------------------------------------------------------------


def resolutions(chosen: Seen) -> Iterator[Explanation]:
    """Yield the rounding of what is written, if numbers are written with few decimals."""
    failing = [c for _, cs in chosen for c in cs if not c.follows]
    numbers = {x for c in failing for x in c.obtained if x}
    if len(numbers) < ENOUGH:
        return
    places = max(-min(int(Decimal(repr(x)).normalize().as_tuple().exponent), 0) for x in numbers)
    resolution = max(0.5 * 10.0**-places, *(t.resolution for t, _ in chosen))
    if places <= FEW_DECIMALS and max(c.error for c in failing) < 4 * resolution:
        yield Explanation(
            "few-decimals", f"{_writes(places)}, and errors are of that size", DOUBLES, 0.0,
            3, mend=lambda t: replace(t, resolution=resolution),
        )  # fmt: skip


def singles(wrong: Seen) -> Iterator[Explanation]:
    """Yield the one quantity of a stage that is computed or written in single precision."""
    failing = [c for _, cs in wrong for c in cs if not c.follows]
    for quantity in {c.quantity for c in failing}:
        some = [c for c in failing if c.quantity == quantity]
        numbers = {Decimal(x) for c in some for x in c.obtained if x}
        near = all(c.error <= SINGLE_ULPS * max(map(abs, c.obtained)) for c in some)
        whole = len(some) == len(failing) and len(numbers) >= ENOUGH
        if whole and near and all(map(_is_single, numbers)):
            yield Explanation(
                f"single-precision:{quantity}", f"{quantity} holds numbers of single precision",
                SINGLE.remedy, quantity=quantity,
            )  # fmt: skip


def few_digits(trials: Trials) -> Finding | None:
    """Return that all numbers are written with few digits, or few behind the point, if they are."""
    told = [t for t in trials if any(x % 1 for value in t.given.values() for x in value)]
    if len(told) < ENOUGH:
        return None
    resolution, share = min(t.resolution for t in told), min(t.share for t in told)
    if resolution >= 0.5 * 10.0**-FEW_DECIMALS:
        name, said, worst = "few-decimals", _writes(round(-math.log10(2 * resolution))), resolution
    elif share:
        count = 1 - round(math.log10(2 * share))
        name, said, worst = "few-digits", _writes(count, "digit"), share
    else:
        return None
    return found(
        "all", f"{said}; no error of that size, or that follows from it, is looked into",
        sum(not t.right for t in trials), len(trials), [name], remedy=DOUBLES, worst=worst,
        share=0.0,
    )  # fmt: skip


def _writes(count: int, noun: str = "decimal") -> str:
    return f"writes its numbers with {many(count, noun)} only"


DOUBLES = "write doubles with 17 digits"

SINGLE = Explanation(
    "single-precision", "computes or writes in single precision",
    "use doubles throughout, and write them with 17 digits",
)  # fmt: skip

SINGLE_ULPS = 1.1e-7  # of a number, what rounding to single precision may do, in three components
SINGLE_NOISE = 1e-2  # 6e-8 a rounding, some hundred steps, amplified by bat and ball


def in_single_precision(answers: Iterable[Answer]) -> bool:
    """Tell whether most quantities hold only numbers of single precision."""
    # Not all need to: a program in single precision may still take a square root in doubles.
    numbers: dict[str, set[Decimal]] = defaultdict(set)
    for answer in answers:
        for name, value in answer.values.items():
            if len(numbers[name]) < 50:
                # Numbers with few digits are in single precision, whatever they come from.
                numbers[name].update(x for x in value if digits(x) >= SHORT)
    single = [all(map(_is_single, some)) for some in numbers.values() if len(some) >= ENOUGH]
    return 2 * sum(single) > len(single)


def _is_single(x: Decimal) -> bool:
    if abs(x.adjusted()) > 37:  # beyond the range of single precision
        return False
    single = np.float32(float(x))
    return float(x) == float(single) or x in (Decimal(str(single)), Decimal(f"{single:.9g}"))


# --- the whole output -----------------------------------------------------------------------------


def shifted(trials: Trials) -> Finding | None:
    """Return that answers bear the id of the scene before or after, if most wrong ones do."""
    for order, whose in ((trials, "before"), (trials[::-1], "after")):
        wrong = [(t, other) for other, t in itertools.pairwise(order) if not t.right]
        moved = [t for t, other in wrong if t.given and _same(t.given, other.expected)]
        if len(moved) >= ENOUGH and 2 * len(moved) > len(wrong):
            return found(
                "all", f"gives each scene the answer to the one {whose} it", len(wrong),
                len(trials), ["ids-shifted"], quantity="id", example=moved[0].case.id,
                remedy="write the id of the scene that the answer belongs to",
            )  # fmt: skip
    return None


def _same(given: Mapping[str, Numbers], true: Mapping[str, Numbers]) -> bool:
    """Tell whether values are those of another scene."""
    return given.keys() == true.keys() and all(
        math.dist(value, true[name]) <= SAME * max(math.hypot(*true[name]), 1e-3)
        for name, value in given.items()
    )


SAME = 1e-6

# What the numbers of a unit are in place of it, by the factor.
_OTHER_UNITS = {
    "s": {1000.0: "ms", 0.001: "1000 s", 1 / 60: "minutes"},
    "m": {1 / 0.3048: "feet", 1 / 0.0254: "inches", 100.0: "cm", 1000.0: "mm", 1 / 0.9144: "yards"},
    "m/s": {3.6: "km/h", 1 / 0.44704: "mph", 1 / 0.3048: "ft/s", 100.0: "cm/s"},
}  # fmt: skip


def conventions(trials: Trials) -> Explanation | None:
    """Return axes or a unit, not the contract's, under which several quantities come right."""
    known: dict[str, list[tuple[Array, Array]]] = defaultdict(list)
    for trial in trials:
        for name, true in trial.expected.items():
            if name in trial.given and len(trial.given[name]) == len(true):
                known[name].append((np.array(true), np.array(trial.given[name])))
    pairs = {name: tuple(map(np.array, zip(*some, strict=True))) for name, some in known.items()}
    ways: list[tuple[str, str, Image, Image, list[str]]] = []
    vectors = [name for name in pairs if QUANTITIES[name].size == 3]
    for shown, image in TURNS:
        back = next(b for _, b in TURNS if (b(image(_PROBE)) == _PROBE).all())
        said = f"axes or signs are exchanged: {shown} stands where (x, y, z) belongs"
        ways.append((f"axes:{shown}", said, image, back, vectors))
    for unit, others in _OTHER_UNITS.items():
        names = [name for name in pairs if QUANTITIES[name].unit == unit]
        for factor, other in others.items():
            said = f"what belongs in {unit} is written in {other}, {factor:.6g} times as large"
            ways.append(
                (f"{other}-for-{unit}", said, lambda x, f=factor: f * x, lambda x, f=factor: x / f,  # type: ignore[misc]
                 names)
            )  # fmt: skip
    likely = []
    for name, said, image, back, names in ways:
        right = {}
        for n in names:
            before, after = _errors(*pairs[n]), _errors(image(pairs[n][0]), pairs[n][1])
            if before > MOVED and after < NAMED_IN_ALL * before:
                right[n] = after / before
        if len(right) > 1:
            sentence, left = f"{said}: in {', '.join(right)}", sum(right.values()) / len(right)
            one = Explanation(
                name, sentence, "see the contract's axes and units", left,
                quantity=next(iter(right)), mend=_rewritten([*right], back),
            )  # fmt: skip
            likely.append((-len(right), left, one))
    return min(likely, key=lambda one: one[:2])[2] if likely else None


_PROBE = np.array([1.0, 2.0, 3.0])

# The mean relative error that another convention makes if it is one, and may leave if it is the
# candidate's: that may have made other mistakes, too.
MOVED, NAMED_IN_ALL = 1e-3, 0.05


def _errors(expected: Array, obtained: Array) -> float:
    """Return the mean of relative errors, none counted for more than 1."""
    size = np.maximum(np.linalg.norm(expected, axis=1), 1e-3)
    return float(np.minimum(np.linalg.norm(obtained - expected, axis=1) / size, 1.0).mean())


def _rewritten(names: Sequence[str], back: Image) -> Callable[[Trial], Trial]:
    def mend(trial: Trial) -> Trial:
        said = {n: np.array(trial.given[n]) for n in names if n in trial.given}
        return trial.saying({n: tuple(back(x).tolist()) for n, x in said.items()})

    return mend
