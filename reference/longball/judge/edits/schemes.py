"""Flights in fixed steps: edits of how a candidate flies, not of what it flies.

An integrator is a step from one state to the next. A candidate takes steps of one length h in all
scenes and makes its last step in one of a few ways. It is named if that makes every number of
every scene (`longball.judge.edits.evidence`); otherwise the order of its errors may be told. A step
is mentioned for an event or a clock only where times lie on a lattice of steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product
from typing import Any

import numpy as np

from longball.judge.edits.chain import OWN, Stage
from longball.judge.edits.evidence import (
    CHANCE,
    DIGIT,
    NUMBER,
    cost,
    fitted,
    is_adequate,
    rounded,
)
from longball.judge.edits.expression import Evaluator, ordered, substitute, words
from longball.judge.edits.operators import FACTORS, Edit
from longball.judge.edits.residual import (
    START,
    Data,
    Followed,
    Index,
    Launched,
    Step,
    compared,
    flown,
    is_rough,
    launched,
    stepped,
    take,
)
from longball.model.arrays import Array


@dataclass(frozen=True)
class Scheme:
    """What the steps of a candidate explain.

    Attributes
    ----------
    words
        What the candidate does, as a clause without its subject.
    order, step
        Of the integrator; None where only an event or a clock is at fault.
    bits, evidence
        What it costs, and the bits beyond chance.
    adequate
        True if it makes all numbers of all scenes: only then it is a name.
    """

    words: str
    order: int | None
    step: float | None
    bits: float
    evidence: float
    adequate: bool


# --- integrators ----------------------------------------------------------------------------------

Rows = Sequence[Sequence[float]]


def _runge_kutta(rows: Rows, weights: Sequence[float], whose: str = "own") -> Step:
    """An explicit Runge-Kutta method. `whose` velocity moves the ball: its own, or the step's."""
    shares = np.array(weights) / sum(weights)

    def step(f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any) -> tuple[Array, Any]:
        slopes = [f(y, t, y)]
        for row in rows:
            at = y + h * sum(a * k for a, k in zip(row, slopes, strict=False) if a)
            slopes.append(f(at, t + sum(row) * h, y))
        new = y + h * sum(b * k for b, k in zip(shares, slopes, strict=True) if b)
        if whose != "own":
            ahead = {"old": 0.0, "mean": 0.5, "new": 1.0}[whose]
            new[:3] = y[:3] + h * (y[3:6] + ahead * (new[3:6] - y[3:6]))
        return new, None

    return step


def _place_first(f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any) -> tuple[Array, Any]:
    moved = y.copy()
    moved[:3] += h * y[3:6]
    new = moved + h * f(moved, t, y)
    new[:3] = moved[:3]
    return new, None


def _leapfrog(f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any) -> tuple[Array, Any]:
    half = y.copy()
    half[:3] += h / 2.0 * y[3:6]
    new = half + h * f(half, t + h / 2.0, y)
    new[:3] = half[:3] + h / 2.0 * new[3:6]
    return new, None


def _verlet(
    ahead: float, carries: bool, rounds: int,
    f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any,
) -> tuple[Array, Any]:  # fmt: skip
    first = left if carries and left is not None else f(y, t, y)
    new = y + h * first
    new[:3] = y[:3] + h * (y[3:6] + h / 2.0 * first[3:6])
    at = new.copy()
    at[3:6] = y[3:6] + ahead * h * first[3:6]
    for _ in range(rounds):
        last = f(at, t + h, y)
        new[3:6] = y[3:6] + h / 2.0 * (first[3:6] + last[3:6])
        at[3:6] = new[3:6]
    return new, last if carries else None


def _adams_bashforth(
    parabola: bool, f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any
) -> tuple[Array, Any]:
    now = f(y, t, y)
    before = now if left is None else left
    new = y + h * (now + h / (2.0 * whole) * (now - before))
    if parabola:
        new[:3] = y[:3] + h * (y[3:6] + h / 2.0 * now[3:6])
    return new, now


@dataclass(frozen=True)
class Integrator:
    """A step, and the order of its errors; no step is the exact path."""

    words: str
    order: int
    step: Step | None = None
    frozen: str = ""  # what takes the speed of the step's start

    def law(self, stage: Stage) -> Stage:
        """A stage with the law as the steps see it."""
        if not self.frozen:
            return stage
        speed = stage.roots["through"]
        inner = speed.args[0] if speed.op == "named" else speed
        begun = inner
        for node in ordered([inner]):
            if node.op == "symbol" and node.data in START:
                begun = substitute(begun, node, START[str(node.data)])
        old = speed if self.frozen == "drag" else inner
        law = substitute(stage.roots["law"], old, begun)
        return replace(stage, roots={**stage.roots, "law": law})


_HALVES: Rows = ((0.5,), (0, 0.5), (0, 0, 1))
_CLASSICAL = (1, 2, 2, 1)
_WHOSE = {
    "old": ("the velocity at the step's start", 1),
    "new": ("the velocity at the step's end", 1),
    "mean": ("the mean of the velocities at the step's ends", 2),
}
_FORCES = {
    0.0: ("the force at the old velocity", 1),
    0.5: ("the force at the half-step velocity", 1),
    1.0: ("the force at a predicted velocity", 2),
}
EXACT = Integrator("an exact path", 99)
INTEGRATORS = (
    Integrator("explicit Euler", 1, _runge_kutta((), (1,))),
    Integrator("semi-implicit Euler, velocity first", 1, _runge_kutta((), (1,), "new")),
    Integrator("semi-implicit Euler, position first", 1, _place_first),
    Integrator("constant acceleration over each step", 1, _runge_kutta((), (1,), "mean")),
    Integrator("leapfrog with the force at the old velocity", 1, _leapfrog),
    *(
        Integrator(
            f"velocity Verlet with {words}{', which the next step begins with' * carries}",
            order if ahead != 0.5 or carries else 2,
            partial(_verlet, ahead, carries, 1),
        )
        for (ahead, (words, order)), carries in product(_FORCES.items(), (False, True))
    ),
    Integrator("velocity Verlet with an implicit velocity", 2, partial(_verlet, 1.0, False, 8)),
    Integrator("the midpoint method", 2, _runge_kutta(((0.5,),), (0, 1))),
    Integrator("Heun's method", 2, _runge_kutta(((1,),), (1, 1))),
    Integrator("Ralston's method", 2, _runge_kutta(((2 / 3,),), (1, 3))),
    Integrator("the Adams-Bashforth method of order 2", 2, partial(_adams_bashforth, False)),
    Integrator(
        "the Adams-Bashforth method of order 2 for the velocity", 2, partial(_adams_bashforth, True)
    ),
    Integrator("Kutta's method of order 3", 3, _runge_kutta(((0.5,), (-1, 2)), (1, 4, 1))),
    Integrator("Heun's method of order 3", 3, _runge_kutta(((1 / 3,), (0, 2 / 3)), (1, 0, 3))),
    Integrator("RK4", 4, _runge_kutta(_HALVES, _CLASSICAL)),
    Integrator(
        "the 3/8 rule of order 4", 4,
        _runge_kutta(((1 / 3,), (-1 / 3, 1), (1, -1, 1)), (1, 3, 3, 1)),
    ),
    *(
        Integrator(f"RK4 whose position moves with {words}", order,
                   _runge_kutta(_HALVES, _CLASSICAL, whose))
        for whose, (words, order) in _WHOSE.items()
    ),
    *(
        Integrator(f"RK4 whose {what} the speed at the step's start", 1,
                   _runge_kutta(_HALVES, _CLASSICAL), frozen)
        for frozen, what in (("drag", "drag takes"), ("drag and lift", "drag and lift take"))
    ),
    *(
        Integrator(f"RK4 with the weights {weights}", 2, _runge_kutta(_HALVES, weights))
        for weights in ((1, 1, 1, 1), (2, 1, 1, 2), (1, 3, 3, 1))
    ),
    *(
        Integrator(f"RK4 whose {words}", order, _runge_kutta(rows, _CLASSICAL))
        for words, order, rows in (
            ("third slope begins with the first", 2, ((0.5,), (0.5,), (0, 0, 1))),
            ("fourth slope begins with the second", 2, ((0.5,), (0, 0.5), (0, 1))),
            ("fourth slope begins with the first", 2, ((0.5,), (0, 0.5), (1,))),
            ("fourth slope is in the middle of the step", 1, ((0.5,), (0, 0.5), (0, 0, 0.5))),
        )
    ),
)  # fmt: skip

# --- flights --------------------------------------------------------------------------------------

ON_STEP = 1e-7  # of a step: a time that is nearer to one is there
DIRECT = 2000  # steps that are taken one by one
# s: where there are more, the state is extrapolated from flights in these steps and the exact one.
NODES = (0.1, 0.05, 0.025, 0.0125, 0.00625)


def _reached(balls: Launched, one: Integrator, h: float, counts: Index) -> tuple[Array, Any, Array]:
    """The states after so many steps, what the last ones leave, and the states' doubt.

    Errors of a method with constant steps have an expansion in powers of the step: what m and the
    exact path (1/m = 0) give for some m gives what any other number of steps gives.
    """
    if one.step is None:
        y = flown(balls, counts * h)
        return y, None, np.zeros_like(y)
    most = int(counts.max(initial=0))
    if most <= DIRECT:
        y, left = stepped(balls, one.step, h, counts)
        return y, left, np.zeros_like(y)
    way = counts * h
    exact = flown(balls, way)
    steps = [math.ceil(most * h / node) for node in NODES]
    found = [stepped(balls, one.step, way / m, np.full(len(counts), m)) for m in steps]
    x = np.array([0.0, *(1.0 / m for m in steps)])
    target = 1.0 / np.maximum(counts, 1)

    def drawn(states: Sequence[Array], skip: int) -> Array:
        used = [i for i in range(len(x)) if i != skip]
        weights = [np.prod([(target - x[k]) / (x[i] - x[k]) for k in used if k != i], axis=0)
                   for i in used]  # fmt: skip
        return sum(w * states[i] for w, i in zip(weights, used, strict=True))  # type: ignore[return-value]

    states = [exact, *(y for y, _ in found)]
    y = np.where(counts > 0, drawn(states, -1), balls.y)
    doubt = np.where(counts > 0, np.abs(y - drawn(states, 1)), 0.0)
    if found[0][1] is None:
        return y, None, doubt
    slopes = [balls.rates(exact, way), *(left for _, left in found)]
    return y, drawn(slopes, -1), doubt


def _scheme_flight(
    stage: Stage, columns: Mapping[str, Any], one: Integrator, h: float, chord: bool
) -> tuple[dict[str, Array], dict[str, Array]]:
    """A stage's quantities, flown in steps of h, and their doubt.

    The last step is shorter, or the state lies on the chord between two steps.
    """
    balls = launched(one.law(stage), columns)
    counts = np.floor(np.nan_to_num(balls.duration) / h + ON_STEP).astype(int).clip(0)
    y, left, doubt = _reached(balls, one, h, counts)
    rest = balls.duration - counts * h
    if one.step is None:
        new = y + rest / h * (flown(balls, (counts + 1) * h) - y)
    elif chord:
        new = y + rest / h * (one.step(balls.rates, y, counts * h, h, left, h)[0] - y)
    else:
        new, _ = one.step(balls.rates, y, counts * h, rest, left, h)
    found = balls.ended(new)
    doubts = {q: np.zeros_like(x) for q, x in found.items()}
    return found, {**doubts, stage.quantities[0]: doubt[:3], stage.quantities[1]: doubt[3:6]}


# --- which integrator, and which step -------------------------------------------------------------

FEW = 6  # wrong scenes with short flights, in which schemes are tried first
TRIALS = (0.2, 0.04)  # s: steps of the first trials, from which the order leads to the candidate's
SHORTEST, LONGEST = 2e-5, 0.4  # s: steps of candidates
KEPT = 8  # integrators that are tried with the steps that fit them
# Of the square of the errors, what a scheme leaves that is looked at, that fits, and nearly is it.
ROUGHLY, FITS, CLOSELY = 0.7, 0.1, 1e-3
LIKE, MOST = 0.1, 0.8  # errors are of an order if so much is left, at most, in most scenes
NEAR, CHORD = 1.25, 2.0  # a round step is tried within this factor of the fitted one, and a chord's

# Steps that people choose: round numbers, and the rates of screens and cameras.
_DECADE = (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
_RATES = (24, 25, 30, 50, 60, 64, 90, 100, 120, 128, 144, 240, 256, 480, 512, 960, 1000, 1024)
ROUND = tuple(
    sorted({0.1, 0.2, 0.3, 0.4, *(float(f"{m}e{k}") for m in _DECADE for k in (-5, -4, -3, -2))}
           | {1 / n for n in _RATES})
)  # fmt: skip
ROUND_BITS = math.log2(len(ROUND))


def _nearer(one: Integrator, h: float, share: float) -> float:
    """The step with which errors are `share` times those with `h`."""
    return float(np.clip(h * share ** (1 / one.order), SHORTEST, LONGEST))


@dataclass(frozen=True)
class _Search:
    """A flight stage whose errors are compared with those of schemes."""

    stage: Stage
    data: Data
    columns: Mapping[str, Any]
    followed: Followed

    @cached_property
    def few(self) -> Index:
        """Numbers of `followed.some` with wrong and short flights."""
        wrong = np.flatnonzero(self.followed.wrong & np.isfinite(self.durations))
        wrong = wrong[np.argsort(self.durations[wrong], kind="stable")]
        wrong = wrong[: max(FEW, 2 * len(wrong) // 3)]
        return np.asarray(wrong[np.linspace(0, len(wrong) - 1, min(FEW, len(wrong))).astype(int)])

    @cached_property
    def durations(self) -> Array:
        root = self.stage.roots["duration"]
        found = Evaluator([root], take(self.columns, self.followed.some))()[0]
        return np.asarray(found + np.zeros(len(self.followed.some)))

    @cached_property
    def all(self) -> Index:
        return np.arange(len(self.followed.some))

    @cached_property
    def null(self) -> float:
        """Bits that the errors cost now."""
        return cost(self.followed.off / self.followed.floor)

    @property
    def square(self) -> float:
        """The sum of the squares of the errors in the first scenes."""
        off = self.followed.off[:, self.few] / self.followed.scale[:, self.few]
        return float(np.square(off[np.isfinite(off)]).sum())

    def columns_of(self, some: Index) -> dict[str, Any]:
        """Columns of some of the scenes."""
        found = take(self.columns, self.followed.some[some])
        return {**found, "spin": found[self.stage.spins]}

    def rows(self, found: Mapping[str, Array]) -> Array:
        """Quantities as rows, in the order of `followed`."""
        return np.concatenate([np.atleast_2d(found[q]) for q in self.stage.quantities if q in found])

    def errors(self, one: Integrator, h: float, chord: bool, some: Index) -> tuple[Array, Array]:
        """What a scheme makes other than the exact path does, and the doubt of it."""
        with np.errstate(all="ignore"):
            found, doubt = _scheme_flight(self.stage, self.columns_of(some), one, h, chord)
            given = self.rows({q: self.data.given[q][..., self.followed.some[some]] for q in found})
            exact = given - self.followed.off[:, some]
            return self.rows(found) - exact, self.rows(doubt)

    def left(self, one: Integrator, h: float, chord: bool, some: Index) -> Array:
        """What a scheme leaves of the candidate's errors, in floors."""
        made, doubt = self.errors(one, h, chord, some)
        off = self.followed.off[:, some]
        r = (off - made) / (self.followed.floor[:, some] + doubt)
        return np.where(np.isfinite(off) & ~np.isfinite(r), 1e12, r)

    def ratio(self, one: Integrator, h: float, chord: bool = False) -> tuple[float, float]:
        """The candidate's errors over those of a scheme, and the share that is left of them."""
        made, _ = self.errors(one, h, chord, self.few)
        off, floor = (x[:, self.few] for x in (self.followed.off, self.followed.scale))
        known = np.isfinite(off) & np.isfinite(made)
        a, b = (off / floor)[known], (made / floor)[known]
        square = float(a @ a)
        share = float(a @ b) / max(float(b @ b), 1e-300)
        return share, float(np.square(a - share * b).sum()) / max(square, 1e-300)

    def fitting(self) -> list[tuple[float, float, Integrator]]:
        """Integrators with the steps that fit them and what they leave, those that fit best first."""
        found = []
        for one, h in product(INTEGRATORS, TRIALS):
            share, left = self.ratio(one, h)
            if share > 0.0 and left < ROUGHLY:
                found.append((left, _nearer(one, h, share), one))
        found.sort(key=lambda each: each[0])
        better: dict[str, tuple[float, float, Integrator]] = {}
        for left, h, one in found[: 2 * KEPT]:
            for _ in range(2 * (one.words not in better)):
                share, left = self.ratio(one, h)
                if not (share > 0.0 and left < ROUGHLY):
                    break
                h = _nearer(one, h, share)
                better[one.words] = left, h, one
        places = {one.words: i for i, one in enumerate(INTEGRATORS)}
        fits = [each for each in better.values() if each[0] < FITS]
        # What comes to the same here is called by its simplest name.
        return sorted(fits, key=lambda x: (round(math.log10(x[0] + 1e-12)), places[x[2].words]))

    def best(self, dt: float | None) -> Scheme | None:
        """The cheapest scheme that makes all numbers, or else the order that errors have."""
        found = self.fitting()
        tried = 2 * (len(INTEGRATORS) + 1)
        steps = [*ROUND, *([dt] if dt else [])]

        def near(fit: float, factor: float) -> list[float]:
            close = {h for h in steps if max(h / fit, fit / h) < factor}
            return sorted(close, key=lambda h: abs(math.log(h / fit)))

        options = [
            (one, h, chord)
            for _, fit, one in found for h in near(fit, NEAR) for chord in (False, True)
        ]  # fmt: skip
        # Errors of a chord grow as the square of the step.
        made, _ = self.errors(EXACT, TRIALS[1], True, self.few)
        off = self.followed.off[:, self.few]
        fit = TRIALS[1] * math.sqrt(np.nanmax(np.abs(off[:3])) / np.nanmax(np.abs(made[:3])))
        chords = {h: self.ratio(EXACT, h, True) for h in near(fit, CHORD)}
        best = min(chords, key=lambda h: chords[h][1], default=None)
        if best is not None and chords[best][1] < ROUGHLY:
            options.append((EXACT, best, True))
            options += [(one, best, True) for one in INTEGRATORS if one.order > 1]
        named = self._adequate(options, dt, tried)
        if named is None and found and found[0][0] < CLOSELY:
            named = self._adequate(list(self._free(found[:2])), dt, tried)
        return named or self._order(found, tried)

    def _free(
        self, found: Iterable[tuple[float, float, Integrator]]
    ) -> Iterable[tuple[Integrator, float, bool]]:
        for _, fit, one in found:
            c, _ = fitted(lambda h, one=one: self.left(one, abs(h), False, self.few), (fit,))  # type: ignore[misc]
            yield from ((one, x, False) for x, _ in rounded(abs(c)) if x > SHORTEST)

    def _adequate(
        self, options: Sequence[tuple[Integrator, float, bool]], dt: float | None, tried: int
    ) -> Scheme | None:
        for one, h, chord in options:
            if not is_adequate(self.left(one, h, chord, self.few)):
                continue
            r = self.left(one, h, chord, self.all)
            bits = math.log2(tried) + (0.0 if h == dt else ROUND_BITS if h in ROUND else 30.0)
            evidence = self.null - cost(r) - bits - CHANCE
            if evidence > 0 and is_adequate(r, is_rough(self.stage)):
                said = f"flies by {one.words} in steps of {h:.6g} s"
                if one is EXACT:
                    said = f"puts the end of the flight on the chord between two steps of {h:.6g} s"
                elif chord:
                    said += ", and ends on the chord between two of them"
                order = None if one is EXACT else one.order
                return Scheme(said, order, h, bits, evidence, adequate=True)
        return None

    def _order(
        self, found: Sequence[tuple[float, float, Integrator]], tried: int
    ) -> Scheme | None:
        off = self.followed.off[:, self.followed.wrong]
        wrong = self.all[self.followed.wrong]
        for _, h, one in found[:2]:
            made, _ = self.errors(one, h, False, wrong)
            known = np.isfinite(off) & np.isfinite(made)
            before, after = (
                np.sqrt(np.square(np.where(known, x / self.followed.scale[:, wrong], 0.0)).sum(0))
                for x in (off, off - made)
            )
            bits = math.log2(tried) + ROUND_BITS
            evidence = self.null - cost(self.left(one, h, False, self.all)) - bits - CHANCE
            if np.mean(after < LIKE * before) >= MOST and evidence > 0:
                said = f"errs like a scheme of order {one.order}, such as {one.words} in steps of"
                return Scheme(f"{said} about {h:.2g} s", one.order, h, bits, evidence, False)
        return None


# --- events at steps, and clocks ------------------------------------------------------------------

ON_LATTICE = 1e-4  # of a step: times that are nearer to whole steps lie on them
FINEST = 1e-4  # s: of steps that times may show
TIMES = 5  # different times that a lattice is seen in


def lattice(times: Array, dt: float | None = None) -> tuple[float, float] | None:
    """The largest step of which most times are multiples, s, and its bits beyond chance.

    Balls that a candidate starts anew in flight, such as at a kink of the law, need not be there.
    """
    known = np.unique(times[np.isfinite(times) & (times > LONGEST)].round(12))
    if len(known) < TIMES:
        return None
    steps = [np.array([dt])] if dt else [
        first / np.arange(math.ceil(first / LONGEST), math.floor(first / FINEST) + 1)
        for first in known[:3]
    ]  # fmt: skip
    tried = np.concatenate(steps)
    beside = np.abs(known[:, None] / tried - np.round(known[:, None] / tried)) < ON_LATTICE
    fits = np.flatnonzero(beside.mean(axis=0) >= MOST)
    if not fits.size:
        return None
    best = fits[np.argmax(tried[fits])]
    on = int(beside[:, best].sum())
    bits = (on - 1) * -math.log2(2 * ON_LATTICE) - math.log2(len(tried)) - (len(known) - on) * 5.0
    return float(f"{tried[best]:.9g}"), bits


@dataclass(frozen=True)
class _Clocks:
    """The times at which a candidate's states lie on the path, beside those that it gives."""

    search: _Search

    @cached_property
    def balls(self) -> Launched:
        with np.errstate(all="ignore"):
            return launched(self.search.stage, self.search.columns_of(self.search.all))

    @cached_property
    def parts(self) -> list[slice]:
        """Rows of the place and the velocity, as far as they are given."""
        rows = slice(0, 3), slice(3, 6)
        return [part for part in rows if np.isfinite(self.search.followed.off[part]).any()]

    def off(self, part: slice, times: Array) -> tuple[Array, Array]:
        """What is given less the path at other times, and how fast that path moves there."""
        search = self.search
        with np.errstate(all="ignore"):
            y, now = flown(self.balls, times), flown(self.balls, search.durations)
            return search.followed.off[part] + (now - y)[part], self.balls.rates(y, times)[part]

    def own_times(self, part: slice) -> Array:
        """The times at which the path is nearest to what is given."""
        times = self.search.durations.copy()
        for _ in range(4):
            off, moving = self.off(part, times)
            with np.errstate(all="ignore"):
                times = times + np.nan_to_num((off * moving).sum(0) / (moving * moving).sum(0))
        return times

    def best(self, dt: float | None) -> Scheme | None:
        """A clock that makes all numbers, and those of what is given at another time."""
        search = self.search
        told = search.durations
        name = words(search.stage.roots["duration"])
        laws = [self._pattern(told, self.own_times(part), dt) for part in self.parts]
        if not laws or any(law is None for law in laws):
            return None
        known = [law for law in laws if law is not None]
        r = np.concatenate([
            self.off(part, law[1])[0] / search.followed.floor[part]
            for part, law in zip(self.parts, known, strict=True)
        ])  # fmt: skip
        bits = sum(law[2] for law in known)
        evidence = search.null - cost(r) - bits - CHANCE
        if evidence <= 0 or not is_adequate(r, is_rough(search.stage)):
            return None
        if len({law[0] for law in known}) == 1:
            said = known[0][0].format("the state", name)
        else:
            said = "; ".join(
                text.format(quantity, name)
                for (text, *_), quantity in zip(known, search.stage.quantities, strict=False)
                if text
            )
        return Scheme(said, None, next((law[3] for law in known if law[3]), None), bits, evidence, True)

    def _pattern(
        self, told: Array, own: Array, dt: float | None
    ) -> tuple[str, Array, float, float | None] | None:
        """Words, times by a rule, its bits and its step, for times that are not those told."""
        behind = told - own
        known = behind[np.isfinite(behind)]
        late = float(np.median(known)) if known.size else 0.0
        if _mostly(np.abs(known) < SAME):
            return "", told, 0.0, None
        if _mostly(np.abs(known - late) < max(SAME, 1e-4 * abs(late))):
            late = float(f"{late:.4g}")
            side = "before" if late > 0 else "after"
            text = f"gives {{}} of {abs(late):.6g} s {side} {{}}"
            return text, told - late, NUMBER + 4 * DIGIT, abs(late)
        if found := lattice(own, dt):
            h, counts = found[0], told / found[0]
            sides = ("before", np.floor(counts + ON_STEP)), ("after", np.ceil(counts - ON_STEP))
            for text, steps in sides:
                if _mostly(np.abs(steps * h - own) < SAME + ON_LATTICE * h):
                    text = f"gives {{}} of the step {text} {{}}, in steps of {h:.6g} s"
                    return text, steps * h, ROUND_BITS, h
        if (found := lattice(told, dt)) and _mostly(np.abs(known) < found[0] * (1 + ON_LATTICE)):
            h, bits = found
            return f"counts {{1}} in whole steps of {h:.6g} s", own, 10.0 * known.size - bits, h
        return None


def _mostly(those: Array) -> bool:
    return bool(those.size) and bool(np.mean(those) >= MOST)


SAME = 1e-8  # s: times that differ by less are one


def _event(
    chain: Sequence[Stage], stage: Stage, columns: Mapping[str, Any], followed: Followed,
    dt: float | None,
) -> Scheme | None:  # fmt: skip
    """An event that is taken at the step before it or after it."""
    quantity = stage.quantities[0]
    flight = next((x for x in chain if x.kind == "flight" and x.quantities[0] == quantity), None)
    if flight is None:
        return None
    some = followed.some[followed.wrong]
    own = take(columns, some)
    own["spin"] = own[flight.spins]
    with np.errstate(all="ignore"):
        balls = launched(flight, own)
        found = lattice(balls.duration, dt)
        if found is None:
            return None
        h, bits = found
        sides = []
        for shift in (-h, 0.0, h):
            place = flown(balls, balls.duration + shift)[:3]
            zero = Evaluator([stage.roots["zero"]], {**own, str(OWN[quantity].data): place})()[0]
            sides.append(np.sign(zero) + np.zeros(len(some)))
    name = words(flight.roots["duration"])
    evidence = bits + len(some) - CHANCE
    for text, other in (("after", sides[0]), ("before", sides[2])):
        if evidence > 0 and _mostly(other * sides[1] < 0):
            said = f"takes {name} and {quantity} at the step {text} the event, in steps of {h:.6g} s"
            return Scheme(said, None, h, bits, evidence, adequate=True)
    return None


# --- what explains a stage ------------------------------------------------------------------------


def explain_scheme(
    chain: Sequence[Stage], stage: Stage, data: Data, columns: Mapping[str, Any],
    followed: Followed, dt: float | None = None,
) -> Scheme | None:  # fmt: skip
    """The scheme, event at a step, or clock that explains a stage, or the order of its errors."""
    if stage.kind == "event":
        return _event(chain, stage, columns, followed, dt)
    if stage.kind == "formula" or not followed.wrong.any():
        return None
    search = _Search(stage, data, columns, followed)
    return _Clocks(search).best(dt) or search.best(dt)


VARIANTS = 3  # edits with a number that are tried with all schemes


def with_edit(
    stage: Stage, data: Data, columns: Mapping[str, Any], followed: Followed,
    edits: Iterable[Edit], dt: float | None = None,
) -> tuple[Edit, Scheme] | None:  # fmt: skip
    """One of some edits, and the scheme by which the edited law is flown."""
    null = cost(followed.off / followed.floor)
    ways: list[tuple[float, Edit, _Search]] = []
    for edit in edits:
        for variant in _numbered(edit):
            (other,) = variant.apply([stage])
            with np.errstate(all="ignore"):
                after, _ = compared(other, data, columns, followed.some)
            search = _Search(other, data, columns, after)
            if not (after.wrong.any() and search.null < null):
                continue
            ratios = [search.ratio(one, TRIALS[0]) for one in INTEGRATORS]
            left = min((left for share, left in ratios if share > 0.0), default=1.0)
            ways.append((left * search.square, variant, search))
    ways.sort(key=lambda way: way[0])
    for _, edit, search in ways[:VARIANTS]:
        scheme = search.best(dt)
        if scheme is not None and scheme.adequate:
            saved = null - search.null - edit.bits - math.log2(1 + len(ways))
            return edit, replace(scheme, evidence=scheme.evidence + saved)
    return None


def _numbered(edit: Edit) -> Iterable[Edit]:
    """An edit with usual and round values near that of its free number, which a scheme has moved."""
    if not edit.starts:
        return [edit]
    (c,) = edit.starts
    if not isinstance(c, float):
        return []
    usual = [x for x in (FACTORS if edit.factor else ()) if abs(x - c) < MOVED * abs(c)]
    values = {x: math.log2(len(FACTORS)) for x in usual}
    for digits in (1, 2, 3):
        x = float(f"{c:.{digits}g}")
        if abs(x - c) < MOVED * abs(c):
            values.setdefault(x, NUMBER + DIGIT * digits)
    return [edit.settled(x, bits) for x, bits in values.items()]


MOVED = 0.05  # relative: how far a scheme's errors may move a free number
