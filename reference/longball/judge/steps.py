"""Flights in fixed steps, as other simulators take them: which scheme and step a candidate has.

Each scheme is a function from the rates, a state and a step to the next state; schemes that go on
with what the step before has left carry that along. Plate, bat and ground are met as
`longball.engines.verlet` meets them, on the line between two steps, or by a last step that is
shorter.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.polynomial.polynomial import polyval

from longball.engines.engine import Launch
from longball.engines.event import Event
from longball.engines.ivp import Ivp
from longball.engines.path import Flight, Path
from longball.engines.polynomial import PolynomialPiece
from longball.engines.verlet import TREATMENTS, Chord, Components, Verlet, plain_step
from longball.judge.any_law import EFFORT
from longball.judge.explanations import ALIKE, Explanation, Sought
from longball.judge.stages import Change
from longball.model.arrays import Array
from longball.model.law import Law, State
from longball.model.numbers import plus
from longball.model.readings import VerletForces

Rates = Callable[..., Components]

# From the rates, a state, a step and what the step before has left, None at first: the next state
# and what this step leaves.
Step = Callable[[Rates, Components, float, Any], tuple[Components, Any]]


_AHEAD = {"old": 0.0, "mean": 0.5, "new": 1.0}  # where in a step the velocity is that moves a ball


def _runge_kutta(
    nodes: Sequence[float] = (0.5, 0.5, 1),
    weights: Sequence[float] = (1, 2, 2, 1),
    whose: str = "own",
    begun: Sequence[int] = (0, 1, 2),
) -> Step:
    """Return an explicit Runge-Kutta method, each of whose stages begins with one before: `begun`.

    `whose` velocity moves the position: its "own", the step's "old" or "new" one, or their "mean".
    """
    shares = [weight / sum(weights) for weight in weights]

    def step(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
        rates = f(*s)
        stages = [rates]
        for node, first in zip(nodes, begun, strict=False):
            stages.append(f(*plus(s, node * h, stages[first])))
        new = s
        for share, rates in zip(shares, stages, strict=True):
            if share:
                new = plus(new, share * h, rates)
        if whose == "own":
            return new, None
        n = len(s) // 2
        change = plus(new[n : 2 * n], -1.0, s[n : 2 * n])
        velocity = plus(s[n : 2 * n], _AHEAD[whose], change)
        return (*plus(s[:n], h, velocity), *new[n:]), None

    return step


def _with_speed_of_start(step: Step, lifts: bool) -> Step:
    """Return a step whose drag, and lift if `lifts`, takes V at the step's start, in still air."""
    # Of the force without gravity, what lies along the velocity is the drag.

    def slowed(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
        n = len(s) // 2
        begun = math.hypot(*s[n : 2 * n])
        weight = f(*s[:n], *(0.0,) * n, *s[2 * n :])[n : 2 * n]

        def rates(*now: float) -> Components:
            velocity, found = now[n : 2 * n], f(*now)
            force, square, along = found[n : 2 * n], 0.0, 0.0
            for v, a, g in zip(velocity, force, weight, strict=True):
                square, along = square + v * v, along + v * (a - g)
            more = begun / math.sqrt(square) - 1
            if lifts:
                changed = plus(force, more, plus(force, -1.0, weight))
            else:
                changed = plus(force, more * along / square, velocity)
            return (*found[:n], *changed, *found[2 * n :])

        return step(rates, s, h, left)

    return slowed


def _implicit(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
    new = plus(s, h, f(*s))
    for _ in range(30):
        old, new = new, plus(s, h, f(*new))
        if math.dist(old, new) < 1e-15 * math.hypot(*new):
            break
    return new, None


def _adams_bashforth(velocity_only: bool) -> Step:
    """Return the method of order 2; where it is for the velocity only, r' = r + v h + a h²/2."""

    def step(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
        n, rates = len(s) // 2, f(*s)
        before, step_before = left or (rates, h)
        ratio = h / (2 * step_before)
        mean = plus(plus(rates, ratio, rates), -ratio, before)
        new = plus(s, h, mean)
        if velocity_only:
            place = plus(plus(s[:n], h, s[n : 2 * n]), h * h / 2, rates[n : 2 * n])
            new = (*place, *new[n:])
        return new, (rates, h)

    return step


def _leapfrog(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
    """Drift for half a step, kick with the force there and at the old velocity, drift again."""
    n = len(s) // 2
    half = (*plus(s[:n], h / 2, s[n : 2 * n]), *s[n:])
    new = (*half[:n], *plus(s[n:], h, f(*half)[n:]))
    return (*plus(new[:n], h / 2, new[n : 2 * n]), *new[n:]), None


def _verlet(treatment: VerletForces) -> Step:
    """Return velocity Verlet with a treatment of the force; see `longball.engines.verlet`."""

    def step(f: Rates, s: Components, h: float, left: Any) -> tuple[Components, Any]:
        n = len(s) // 2
        place, velocity, rest, rates = s[:n], s[n : 2 * n], s[2 * n :], f(*s)

        def force(r: Components, v: Components) -> Components:
            return f(*r, *v, *moved)[n : 2 * n]

        moved = plus(rest, h, rates[2 * n :])
        place, velocity, after = plain_step(
            place, velocity, left or rates[n : 2 * n], (0.0,) * n, h, *TREATMENTS[treatment], force
        )
        return (*place, *velocity, *moved), after

    return step


@dataclass(frozen=True)
class Scheme:
    """A scheme in fixed steps."""

    step: Step
    order: int  # of its errors
    words: str  # how its author would call it
    # Of the force, if it is velocity Verlet; `longball.engines.verlet` then flies by it, too.
    treatment: VerletForces | None = None


def _paper(treatment: VerletForces, order: int, words: str) -> Scheme:
    return Scheme(_verlet(treatment), order, f"velocity Verlet with {words}", treatment)


SCHEMES: dict[str, Scheme] = {
    "explicit-euler": Scheme(_runge_kutta((), (1,)), 1, "Euler's method"),
    "semi-implicit-euler": Scheme(_runge_kutta((), (1,), "new"), 1,
                                  "semi-implicit Euler, velocity first"),
    "implicit-euler": Scheme(_implicit, 1, "implicit Euler"),
    "euler-velocity": Scheme(
        _runge_kutta((), (1,), "mean"), 1, "constant acceleration over each step: Euler's method "
        "for the velocity and the mean of two velocities for the position"),
    "lagged-verlet": _paper("old_carried", 1, "drag and lift at the velocity of the step before"),
    "lagged-verlet-recomputed": _paper("old_recomputed", 1, "the force at the old velocity"),
    "half-step-verlet": _paper(
        "half_step", 1, "drag and lift at the half-step velocity, as is usual in molecular "
        "dynamics"),
    "leapfrog": Scheme(_leapfrog, 1, "leapfrog with drag and lift at the old velocity"),
    "rk4-old-velocity": Scheme(_runge_kutta(whose="old"), 1, "RK4 for the velocity, but the "
                               "position moves with the velocity at the step's start"),
    "rk4-new-velocity": Scheme(_runge_kutta(whose="new"), 1, "RK4 for the velocity, but the "
                               "position moves with the velocity at the step's end"),
    "rk4-drag-of-start": Scheme(_with_speed_of_start(_runge_kutta(), False), 1,
                                "RK4 whose drag takes the speed at the step's start"),
    "rk4-speed-of-start": Scheme(_with_speed_of_start(_runge_kutta(), True), 1,
                                 "RK4 whose drag and lift take the speed at the step's start"),
    "rk4-mean-velocity": Scheme(
        _runge_kutta(whose="mean"), 2, "RK4 for the velocity, but the position moves with the mean "
        "of the velocities at the step's ends"),
    "verlet-predicted-carried": _paper(
        "predicted_carried", 2, "a predicted velocity, which is of order 2"),
    "verlet-predicted": _paper(
        "predicted_recomputed", 2, "a predicted velocity, which is of order 2"),
    "verlet-implicit": _paper("implicit", 2, "an implicit velocity, which is of order 2"),
    "heun": Scheme(_runge_kutta((1,), (1, 1)), 2, "Heun's method, of order 2"),
    "midpoint": Scheme(_runge_kutta((0.5,), (0, 1)), 2, "the midpoint method, of order 2"),
    "ralston": Scheme(_runge_kutta((2 / 3,), (1, 3)), 2, "Ralston's method, of order 2"),
    "adams-bashforth": Scheme(_adams_bashforth(False), 2, "the Adams-Bashforth method of order 2"),
    "adams-bashforth-velocity": Scheme(
        _adams_bashforth(True), 2, "the Adams-Bashforth method of order 2 for the velocity"),
    "rk4-equal-weights": Scheme(_runge_kutta(weights=(1, 1, 1, 1)), 2, "RK4 with equal weights"),
    "rk4-third-from-first": Scheme(_runge_kutta(begun=(0, 0, 2)), 2,
                                   "RK4 whose third stage begins with the first one's slope"),
    "rk4-fourth-from-second": Scheme(_runge_kutta(begun=(0, 1, 1)), 2,
                                     "RK4 whose fourth stage begins with the second one's slope"),
    "rk4-fourth-from-first": Scheme(_runge_kutta(begun=(0, 1, 0)), 2,
                                    "RK4 whose fourth stage begins with the first one's slope"),
    "rk4-fourth-at-half": Scheme(_runge_kutta((0.5, 0.5, 0.5)), 1,
                                 "RK4 whose fourth stage is in the middle of the step"),
    "rk4-weights-exchanged": Scheme(_runge_kutta(weights=(2, 1, 1, 2)), 2,
                                    "RK4 with its weights exchanged, 2 1 1 2"),
    "rk4-three-eighths": Scheme(_runge_kutta(weights=(1, 3, 3, 1)), 2,
                                "RK4 with the weights of the 3/8 rule"),
    "rk4": Scheme(_runge_kutta(), 4, "RK4"),
}  # fmt: skip

# Where the force is asked for at a velocity that is late.
LAGGING = ("lagged-verlet", "lagged-verlet-recomputed", "half-step-verlet", "leapfrog")

Ends = Literal["line", "step"]

MOST_KEPT = 100  # flights of a scheme with a step, which may have ten thousand states

STEP_EFFORT = 0.12  # of a step of DOP853, what one of RK4 takes here


@dataclass(frozen=True)
class FixedStep(Verlet):
    """Flights in fixed steps of a scheme; ``chords`` is the true path, seen at the steps only."""

    scheme: str = "explicit-euler"  # a name of `SCHEMES`, or "chords"
    # Whether a state between two steps lies on the line between them, or is reached by a shorter
    # step.
    ends: Ends = "line"

    @property
    def description(self) -> str:
        """Scheme and step."""
        return f"{self.scheme} dt={self.dt!r}"

    def fly(
        self, law: Law[float], start: State[float], events: Sequence[Event[float]], limit: float
    ) -> Flight[float]:
        """Fly until the first of several events; see `longball.engines.engine.Engine.fly`."""
        flight = super().fly(law, start, events, limit)
        between = partial(self._chord, law, None if self.scheme == "chords" else self._step(law))
        return replace(flight, path=_Stepped(self._states(law, start, limit), between, self.dt))

    def rebound(self, frame: Any, touch: Any, delta_v: Any, law_in: Any, ground: Any) -> Any:
        """Strike at once, where ball and bat touch."""
        position, before = frame.position(touch.state), frame.velocity(touch.state)
        velocity = tuple(v + d for v, d in zip(before, delta_v, strict=True))
        return Launch(position, velocity, touch.time, 0.0)

    def _march(
        self, law: Law[float], start: State[float], limit: float
    ) -> Iterator[tuple[int, Array]]:
        states, done, length = self._states(law, start, limit), 0, 128
        rows = [next(states)[0]]
        for state, _ in states:
            rows.append(state)
            if len(rows) > length:
                yield done, np.array(rows).T
                done, length, rows = done + length, min(2 * length, 4096), rows[-1:]
        yield done, np.array(rows).T

    def _chord(
        self, law: Law[float], step: Callable[..., Any] | None, number: int, before: Any, after: Any
    ) -> Chord:
        """Return what lies between two states, each with what the step before it has left."""
        (row, left), (new, _) = before, after
        begin = number * self.dt
        length = (number + 1) * self.dt - begin
        if self.ends == "line" or step is None:
            return Chord(begin, length, law.state(*row), law.state(*new))
        return _Cut(begin, length, law.state(*row), law.state(*new), step, left)

    def _states(
        self, law: Law[float], start: State[float], limit: float
    ) -> Iterator[tuple[Components, Any]]:
        """Return the states at the steps, each with what the step before has left."""
        # A flight is looked at for its end and for the way there, and again after each mend.
        steps: Any = EFFORT.path(law, (start, limit), lambda: self._stepping(law, start, limit),
                                 (self.scheme, self.dt), MOST_KEPT).pieces()  # fmt: skip
        states: Iterator[tuple[Components, Any]] = steps
        return states

    def _stepping(
        self, law: Law[float], start: State[float], limit: float
    ) -> Iterator[tuple[Components, Any]]:
        state, left = tuple(map(float, start)), None
        yield state, left
        if self.scheme == "chords":
            yield from ((row, None) for row in _true_states(law, start, self.dt, limit))
            return
        step = self._step(law)
        for _ in range(math.ceil(min(limit / self.dt, 1e7))):
            EFFORT.steps += STEP_EFFORT
            state, left = step(state, self.dt, left)
            yield state, left

    def _step(self, law: Law[float]) -> Callable[..., tuple[Components, Any]]:
        step, rates = SCHEMES[self.scheme].step, law.pointwise(self.numbers)
        return lambda state, h, left: step(rates, state, h, left)


def _true_states(
    law: Law[float], start: State[float], dt: float, limit: float
) -> Iterator[Components]:
    """Yield the states of the true path at the steps, from the first one on."""
    count = 1
    for piece in Ivp().path(law, start, limit + dt).pieces():
        last = math.floor((piece.begin + piece.length) / dt)
        times = np.arange(count, last + 1) * dt - piece.begin
        if isinstance(piece, PolynomialPiece):
            yield from zip(*polyval(times, piece.coefficients.T).tolist(), strict=True)
        else:
            yield from (tuple(piece.at(time)) for time in times.tolist())
        count = last + 1


@dataclass(frozen=True)
class _Cut(Chord):
    """What lies between two steps, by a shorter step from the first one."""

    step: Callable[..., tuple[Components, Any]]
    left: Any

    def at(self, t: float) -> State[float]:
        """Return the state at a time, s since the first step."""
        if t == self.length:
            return self.after
        state: State[float] = type(self.before)(*self.step(tuple(self.before), t, self.left)[0])
        return state


class _Stepped(Path[float]):
    """A flight of very many pieces, of which few are asked for, and so few are made."""

    # From states at the steps; `between` makes the piece from a number's state to the next one.
    def __init__(self, states: Iterator[Any], between: Callable[..., Chord], dt: float) -> None:
        super().__init__(iter(()))
        self._states, self._between, self._dt = states, between, dt
        self._rows: list[Any] = []

    def _piece(self, number: int) -> Chord | None:
        while len(self._rows) < number + 2:
            row = next(self._states, None)
            if row is None:
                return None
            self._rows.append(row)
        return self._between(number, *self._rows[number : number + 2])

    def pieces(self, number: int = 0) -> Iterator[Chord]:
        """Yield the pieces; see `longball.engines.path.Path.pieces`."""
        while piece := self._piece(number):
            yield piece
            number += 1

    def at(self, time: float) -> State[float]:
        """Return the state at a time; see `longball.engines.path.Path.at`."""
        number = max(0, math.ceil(time / self._dt) - 1)
        if time > (number + 1) * self._dt:  # for the rounding of the quotient
            number += 1
        piece = None if time < 0 else self._piece(number)
        if piece is None:
            raise ValueError(f"the flight has no state at t = {time} s")
        state: State[float] = piece.at(time - piece.begin)
        return state


# Steps that people choose: round numbers, and the rates of screens and cameras.
_DECADE = (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8)
_RATES = (24, 25, 30, 50, 60, 90, 120, 144, 240, 480, 960)
_ROUND = {0.1, 0.2, *(float(f"{m}e{k}") for m in _DECADE for k in (-4, -3, -2))}
ROUND_STEPS = tuple(sorted(_ROUND | {1 / n for n in _RATES}, reverse=True))

SHORTEST = 1e-4  # s: of steps that are tried
SHORTEST_STEP, LONGEST_STEP = 2e-5, 0.2  # s: of clocks


def common_step(times: Sequence[float]) -> float | None:
    """Return the largest step of which all times are multiples, s; None without one."""
    distinct = sorted({time for time in times if time > LONGEST_STEP})
    if len(distinct) < 5:
        return None
    known = np.array(distinct[:12])
    counts = np.arange(math.ceil(known[0] / LONGEST_STEP), math.floor(known[0] / SHORTEST_STEP) + 1)
    multiples = known[1:, None] * counts / known[0]
    near = 1e-6 * np.maximum(1.0, multiples.max(axis=0) / 1e4)
    fits = np.abs(multiples - np.round(multiples)).max(axis=0) < near
    return float(known[0] / counts[np.argmax(fits)]) if fits.any() else None


# --- which scheme, and which step --------------------------------------------------------------

# The errors of a scheme of order p go with the p-th power of its step, so that one trial of each
# tells which step fits best and how well; the best few are then tried with theirs.

FIRST = 0.01  # s: the step of the first trial of each scheme
FINE_STEP, LONGEST = 1e-3, 0.2  # s: of those that are tried; what is shorter follows from the order
FEW, BEST = 3, 6  # trials of all schemes, and schemes that are tried with the step that fits them
NEAR = 1.5  # round steps are tried that differ from a fitted one by less than this factor
ALMOST = 1.1  # a round step may leave so many times what the one leaves that fits best
ROUNDED = 1e-8  # of the errors, what rounding leaves of the best

ITS_OWN = 1e-5  # of the errors, what the candidate's own scheme leaves; others of its order more
LIKE = "errs as one who"  # of a scheme that errs so, and is not the candidate's own
LONG = 2e-3  # s: with longer steps what a scheme leaves is seen in all trials, and not in a few

_SHORTER = "take shorter steps, or a method of higher order"
_STAGES = (
    "an RK4 step has four slopes: at its start, twice in its middle and at its end, each from the "
    "one before, with the forces of its own state, for position and velocity alike, and weighted "
    "as 1, 2, 2, 1"
)
_ORDER = (
    "if that is less than the order of your scheme, one of its stages or weights is wrong; if not, "
    "take shorter steps, or a method of higher order"
)
_REMEDY = (
    "predict the velocity at the step's end, v + aΔt, or iterate, before asking for the force "
    "there: the error then falls with Δt² instead of Δt"
)


@dataclass(frozen=True)
class _Way:
    """A scheme, and how it comes to its events."""

    name: str
    ends: Ends

    @property
    def order(self) -> int:
        return SCHEMES[self.name].order

    @property
    def whole(self) -> int:
        """The order of the whole flight: a line between two steps has one of 2."""
        return min(self.order, 2) if self.ends == "line" else self.order

    def change(self, dt: float) -> Change:
        """Return the chain that flies so."""
        treatment = SCHEMES[self.name].treatment
        if self.ends == "line" and treatment is not None:
            return Change(engine=Verlet(dt=dt, forces=treatment))
        return Change(engine=FixedStep(dt=dt, scheme=self.name, ends=self.ends))

    def explanation(
        self, dt: float, left: float, known: float | None, coarse: bool = False
    ) -> Explanation:
        """Return it as an explanation."""
        end = ", each event on the line between two of them" if self.ends == "line" else ""
        words = f"flies by {SCHEMES[self.name].words}, in steps of {dt:.4g} s{end}"
        if not _chosen(dt, known) or (known is None and (coarse or left > ITS_OWN)):
            words = f"{LIKE} {words}: of this order, and so much"
        remedy = _STAGES if self.name.startswith("rk4-") else _SHORTER
        return Explanation(
            self.name, words, _REMEDY if self.name in LAGGING else remedy, left, 1.1 if end else 1,
            self.change(dt), step=dt,
        )  # fmt: skip


def schemes(sought: Sought, known: float | None, order: int | None) -> Iterator[Explanation]:
    """Yield schemes with the step that fits best."""
    # `known` is the candidate's step, s, and `order` that of its errors, if that was measured.
    few = sought.some(FEW)
    base = few.residual()
    if base is None:
        return
    # Numbers with few digits do not tell schemes apart that err alike.
    coarse = any(t.coarse for t in sought.trials)
    ranked = []
    for way in (_Way(name, ends) for name in SCHEMES for ends in get_args(Ends)):
        if sought.work.spent:
            return
        if order not in (None, way.whole):
            continue
        dt = known or _scaled(few, base, way, FIRST)
        if not dt or dt < SHORTEST / NEAR or (way.ends == "line" and dt < FINE_STEP):
            continue  # with such steps, the line between two of them is the path
        # Where the step is shorter than those tried, the error follows from the order; all schemes
        # are tried with one that is known, which is to be quick.
        tried = max(dt, FIRST if known else FINE_STEP)
        share, steps = min(1.0, (dt / tried) ** way.order), [tried]
        if way.ends == "line" and not known:  # what is between two steps hangs on the step itself
            steps = [step for step in _round(dt, 3) if step >= FINE_STEP] or steps
        for step in steps:
            r = few.residual(way.change(step))
            if r is not None:
                rest = float(np.abs(base - share * (base - r)).sum())
                ranked.append((rest, way, dt if dt < tried else step))
    found = []
    for _, way, dt in sorted(ranked, key=lambda one: one[0])[:BEST]:
        if sought.work.spent:
            break
        fitted = known or _fitted(few, base, way, dt)
        change = way.change(fitted)
        left = sought.screened(change) if fitted > LONG else sought.some(2).left(change)
        if left is not None:
            found.append((_chosen(fitted, known), way.explanation(fitted, left, known, coarse)))
    usual = any(chosen and e.named for chosen, e in found)
    yield from _by_order([e for chosen, e in found if chosen or not usual], coarse)


def _by_order(found: list[Explanation], coarse: bool = False) -> list[Explanation]:
    """Return schemes; of several that err as the candidate does, and are not its own, the order."""
    best = min(found, key=lambda e: e.left, default=None)
    if best is None or not best.named or not best.sentence.startswith(LIKE):
        return found
    names = {e.name for e in found if e.left <= ALIKE * best.left or (coarse and e.named)}
    if len(names) < 2:
        return found
    orders = sorted({SCHEMES[name].order for name in names})
    sentence = f"errs as a method of order {' or '.join(map(str, orders))} does"
    return [replace(best, name=f"order-{orders[0]}", sentence=sentence, remedy=_ORDER, step=None)]


def _chosen(dt: float, known: float | None) -> bool:
    """Tell whether a step is one that people choose, or known to be the candidate's."""
    return known is not None or dt in ROUND_STEPS


def _scaled(few: Sought, base: Array, way: _Way, dt: float) -> float | None:
    """Return the step with which a scheme errs as much as the candidate, seen from another step."""
    r = few.residual(way.change(dt))
    effect = 0.0 if r is None else base - r
    size = float(np.sum(effect * effect))
    amount = float(np.sum(base * effect)) / size if size else 0.0
    return min(dt * amount ** (1 / way.order), LONGEST) if amount > 0 else None


def _fitted(few: Sought, base: Array, way: _Way, dt: float) -> float:
    """Return the step that a scheme fits best with: a round one, if one is near."""
    if dt < FINE_STEP:
        dt = _scaled(few, base, way, FINE_STEP) or dt
        return max((*_round(dt, 1), SHORTEST)[0], SHORTEST)
    steps = [dt]
    for _ in range(3):
        new = _scaled(few, base, way, steps[-1])
        if new is None or new < FINE_STEP:
            break
        steps.append(new)
        if _far(*steps[-2:]) < 1e-4:
            break
    steps += [step for step in _round(steps[-1], 4) if step >= FINE_STEP]

    def left(step: float) -> float:
        r = few.residual(way.change(step))
        return math.inf if r is None else float(np.abs(r).sum())

    # People choose round steps; another mistake may have moved the one that fits best.
    lefts = {step: left(step) for step in steps}
    best = min(lefts, key=lambda step: lefts[step])
    least = ALMOST * max(lefts[best], ROUNDED * float(np.abs(base).sum()))
    near = [step for step in _round(best, 4) if lefts.get(step, math.inf) <= least]
    return near[0] if near else best


def _round(dt: float, count: int) -> list[float]:
    """Return the round steps that are nearest, and near."""
    near = [step for step in ROUND_STEPS if _far(step, dt) < math.log(NEAR)]
    return sorted(near, key=partial(_far, dt))[:count]


def _far(a: float, b: float) -> float:
    return abs(math.log(a / b))
