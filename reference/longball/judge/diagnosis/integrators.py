"""Integrators in fixed steps as data, and flights by them.

An integrator is a step from one state to the next: place, velocity, and the path through the air
(`longball.judge.diagnosis.residual.Launched`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from longball.engines.verlet import PUSHES, TREATMENTS, Treatment, Verlet, impulse_share
from longball.judge.diagnosis.chain import OWN, Stage
from longball.judge.diagnosis.expression import ordered, substitute
from longball.judge.diagnosis.residual import START, Index, Launched, Step, flown, launched, stepped
from longball.model.arrays import Array
from longball.model.readings import ContactForce

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


def _straight(f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any) -> tuple[Array, Any]:
    new = y.copy()
    new[:3] += h * y[3:6]
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
VERLET = {
    Treatment(ahead, False, carries): Integrator(
        f"velocity Verlet with {words}{', which the next step begins with' * carries}",
        order if ahead != 0.5 or carries else 2,
        partial(_verlet, ahead, carries, 1),
    )
    for (ahead, (words, order)), carries in product(_FORCES.items(), (False, True))
} | {
    Treatment(1.0, True, False): Integrator(
        "velocity Verlet with an implicit velocity", 2, partial(_verlet, 1.0, False, 8)
    )
}
INTEGRATORS = (
    Integrator("explicit Euler", 1, _runge_kutta((), (1,))),
    Integrator("semi-implicit Euler, velocity first", 1, _runge_kutta((), (1,), "new")),
    Integrator("semi-implicit Euler, position first", 1, _place_first),
    Integrator("constant acceleration over each step", 1, _runge_kutta((), (1,), "mean")),
    Integrator("leapfrog with the force at the old velocity", 1, _leapfrog),
    Integrator("the midpoint method", 2, _runge_kutta(((0.5,),), (0, 1))),
    Integrator("Heun's method", 2, _runge_kutta(((1,),), (1, 1))),
    Integrator("Ralston's method", 2, _runge_kutta(((2 / 3,),), (1, 3))),
    *VERLET.values(),
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
DIRECT = 2000  # steps of a flight that are taken one by one
# s: where it has more, the state is extrapolated from flights in these steps and the exact one.
NODES = (0.1, 0.05, 0.025, 0.0125, 0.00625)


def _reached(balls: Launched, one: Integrator, h: float, counts: Index) -> tuple[Array, Any, Array]:
    """The states after so many steps, what the last ones leave, and the states' doubt.

    Errors of a method with constant steps have an expansion in powers of the step: what m and the
    exact path (1/m = 0) give for some m gives what any other number of steps gives.
    """
    if one.step is None:
        y = flown(balls, np.asarray(counts * h))
        return y, None, np.zeros_like(y)
    most, direct = int(counts.max(initial=0)), counts <= DIRECT
    short, last = stepped(balls, one.step, h, np.where(direct, counts, 0))
    if direct.all():
        return short, last, np.zeros_like(short)
    way: Array = np.asarray(counts * h, dtype=float)
    exact = flown(balls, way)
    many = [math.ceil(most * h / node) for node in NODES]
    found = [stepped(balls, one.step, way / m, np.full(len(counts), m)) for m in many]
    x = np.array([0.0, *(1.0 / m for m in many)])
    target = 1.0 / np.maximum(counts, 1)

    def drawn(states: Sequence[Array], skip: int) -> Array:
        used = [i for i in range(len(x)) if i != skip]
        weights = [np.prod([(target - x[k]) / (x[i] - x[k]) for k in used if k != i], axis=0)
                   for i in used]  # fmt: skip
        return np.asarray(sum(w * states[i] for w, i in zip(weights, used, strict=True)))

    states = [exact, *(y for y, _ in found)]
    y = np.where(direct, short, drawn(states, -1))
    doubt = np.where(direct, 0.0, np.abs(y - drawn(states, 1)))
    if found[0][1] is None:
        return y, None, doubt
    slopes = [balls.rates(exact, way), *(left for _, left in found)]
    slope = drawn(slopes, -1)
    return y, slope if last is None else np.where(direct, last, slope), doubt


@dataclass(frozen=True)
class Way:
    """A flight in steps of h, s; its last step is shorter, maybe of another kind, or a chord.

    A batted ball is struck at once, or pushed from the step before the contact on.
    """

    one: Integrator
    h: float
    chord: bool = False
    last: Integrator | None = None
    push: ContactForce | None = None

    @property
    def words(self) -> str:
        """The way as a clause without its subject."""
        if self.push is not None:
            said = (
                f"pushes the ball with half of the contact force {_PUSHED[self.push]}, in steps of"
            )
            share = impulse_share(self.push)
            return f"{said} {self.h:.6g} s" + f" ({share:g} times the impulse)" * (share != 1.0)
        if self.one is EXACT:
            return f"puts the end of the flight on the chord between two steps of {self.h:.6g} s"
        end = ", and ends on the chord between two of them" if self.chord else ""
        return f"errs like {self.one.words} in steps of {self.h:.6g} s{end}"

    def __call__(
        self, stage: Stage, columns: Mapping[str, Any]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """A stage's quantities and their doubt."""
        if self.push is not None:
            return _pushed(stage, columns, self, PUSHES[self.push])
        return steps(stage, columns, self.one, self.h, self.chord, self.last)


def ways_of(engine: Verlet) -> dict[str, Way]:
    """Ways of the paper's scheme: to the line between two steps, and straight on to the bat."""
    way = Way(VERLET[TREATMENTS[engine.forces]], engine.dt, chord=True)
    batted = replace(way, push=engine.contact_force)
    return {"pitch": way, "touching": straight(way), **dict.fromkeys(BATTED, batted)}


BATTED = ("flight", "fence")  # stages of a batted ball's flight
_PUSHED: dict[ContactForce, str] = {
    "whole": "as a constant over two steps",
    "carried": "at three steps in a row, as velocity Verlet carries an acceleration on",
    "late": "at the two steps after the contact, as velocity Verlet carries an acceleration on",
    "early": "at the steps next to the contact, as velocity Verlet carries an acceleration on",
}


def straight(way: Way) -> Way:
    """A way whose last step is a straight line at the velocity of the step's start."""
    return Way(way.one, way.h, last=Integrator("a straight line", 1, _straight))


def steps(
    stage: Stage,
    columns: Mapping[str, Any],
    one: Integrator,
    h: float,
    chord: bool,
    last: Integrator | None = None,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """A stage's quantities, flown in steps of h, and their doubt.

    The last step is shorter, and may be that of another integrator, or the state lies on the chord
    between two steps.
    """
    balls = launched(one.law(stage), columns)
    counts = np.floor(np.nan_to_num(balls.duration) / h + ON_STEP).astype(int).clip(0)
    y, left, doubt = _reached(balls, one, h, counts)
    rest = balls.duration - counts * h
    if one.step is None:
        new = y + rest / h * (flown(balls, np.asarray((counts + 1) * h)) - y)
    elif chord:
        new = y + rest / h * (one.step(balls.rates, y, counts * h, h, left, h)[0] - y)
    else:
        step = one.step if last is None or last.step is None else last.step
        new, _ = step(balls.rates, y, counts * h, rest, left, h)
    found = balls.ended(new)
    doubts = {q: np.zeros_like(x) for q, x in found.items()}
    for quantity, part in zip(stage.quantities, (doubt[:3], doubt[3:6]), strict=False):
        # One component may be near by chance.
        doubts[quantity] = np.broadcast_to(part.max(axis=0), part.shape)
    return found, doubts


def _pushed(
    stage: Stage, columns: Mapping[str, Any], way: Way, on: Sequence[int]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The same of batted balls that the contact force F̄/2 pushes at some steps (Appendix B)."""
    h, step = way.h, way.one.step
    struck = columns["kind"] == "at-bat"
    if step is None or not struck.any():
        return steps(stage, columns, way.one, h, way.chord, way.last)
    time, place, velocity, after, hang = (
        "hang_time" if quantity is None else str(OWN[quantity].data)
        for quantity in (
            "contact.time", "contact.position", "contact.velocity", "impact.velocity", None
        )
    )  # fmt: skip
    # From the step gone back to, a straight line leads to the contact.
    ahead = columns[time] - np.floor(columns[time] / h + ON_STEP) * h
    before = columns[velocity]
    half = (columns[after] - before) / (2.0 * h)

    def rates(y: Array, t: Any, start: Array | None = None) -> Array:
        # No launch fixes a spin axis: the air acts as on a ball launched with this velocity.
        balls = launched(stage, {**columns, place: y[:3], after: y[3:6]})
        slope = balls.rates(balls.y, 0.0)
        slope[3:6] += on[round(t / h)] * half
        return slope

    y = np.zeros((7, len(struck)))
    y[:3], y[3:6] = columns[place] - ahead * before, before
    states, left = [y], None
    for k in range(len(on) - 1):
        y, left = step(rates, states[-1], k * h, h, left, h)
        states.append(y)
    # The rest is a flight from where the push ends.
    pushed = (len(on) - 1) * h - ahead
    free = {
        time: columns[time] + pushed, hang: columns[hang] - pushed, place: y[:3], after: y[3:6]
    }  # fmt: skip
    free = {name: np.where(struck, column, columns[name]) for name, column in free.items()}
    found, doubts = steps(stage, {**columns, **free}, way.one, h, way.chord, way.last)
    # A ball may be down before.
    flown_for = launched(stage, columns).duration + ahead
    counts = np.floor(flown_for / h + ON_STEP)
    for k, (begin, end) in enumerate(pairwise(states)):
        here = struck & (counts == k)
        down = begin + (flown_for / h - k) * (end - begin)
        for quantity, part in zip(stage.quantities, (down[:3], down[3:6]), strict=False):
            found[quantity] = np.where(here, part, found[quantity])
    return found, doubts
