"""Integrators in fixed steps as data, and flights by them.

An integrator is a step from one state to the next: place, velocity, and the path through the air
(`longball.judge.diagnosis.residual.Launched`). Adams-Bashforth and the variants of RK4 have
functions; each of the others is a table of coefficients for one function. `slips` edits these
tables as `operators` edits formulas.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property, partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from longball.engines.verlet import PUSHES, TREATMENTS, Treatment, Verlet, impulse_share
from longball.judge.diagnosis.chain import OWN, Stage, last_step
from longball.judge.diagnosis.expression import ordered, substitute
from longball.judge.diagnosis.residual import (
    START,
    Data,
    Index,
    Launched,
    Step,
    flown,
    launched,
    stepped,
)
from longball.model.arrays import Array
from longball.model.readings import ContactForce

# --- steps ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Table:
    """The coefficients of a step of length h with s evaluations of the acceleration.

    Row i is the state r + h c_i v + h² Σ_j A_ij a_j, v + h Σ_j B_ij a_j, with the accelerations a_j
    of the earlier rows. The last row is the end of the step. This is a Nyström method (Hairer,
    Nørsett and Wanner, *Solving Ordinary Differential Equations I*, Sec. II.14).

    Attributes
    ----------
    c
        Coefficients of the velocity, of shape (s + 1,), or (s + 1, n) of n balls.
    place, velocity
        A and B, of shape (s + 1, s), or (s + 1, s, n).
    carries
        True if a step begins with the last acceleration of the step before.
    """

    c: Array
    place: Array
    velocity: Array
    carries: bool = False

    def __call__(
        self, f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any
    ) -> tuple[Array, Any]:
        """Take a step; see `longball.judge.diagnosis.residual.Step`."""
        slopes: list[Array] = []
        for i, (c, place, velocity) in enumerate(self._rows):
            at = y.copy()
            at[:3] += h * c * y[3:6]
            for j, a in place:
                at[:3] += h * h * a * slopes[j][3:6]
            for j, b in velocity:
                at[3:] += h * b * slopes[j][3:]
            if i == len(self.c) - 1:
                break
            # The first acceleration is the one carried over; at the launch there is none yet.
            known = self.carries and i == 0 and left is not None
            slopes.append(left if known else f(at, t + c * h, y))
        return at, slopes[-1] if self.carries else None

    @cached_property
    def _rows(self) -> list[tuple[Any, list[tuple[int, Any]], list[tuple[int, Any]]]]:
        """The coefficients of each row, without those that are 0."""
        parts = [
            [[(j, a) for j, a in enumerate(row) if np.any(a)] for row in rows]
            for rows in (self.place, self.velocity)
        ]
        return list(zip(self.c, *parts, strict=True))

    @property
    def is_consistent(self) -> bool:
        """True if a step leads to the path as h goes to 0."""
        off = abs(self.c[-1] - 1.0), abs(self.velocity[-1].sum() - 1.0)
        return bool(max(off) < 1e-12)  # a free choice above the rounding


def _table(
    c: Sequence[float], place: Sequence[Sequence[float]], velocity: Sequence[Sequence[float]],
    carries: bool = False,
) -> Table:  # fmt: skip
    """A table from rows without their zeros at the end."""
    s = len(c) - 1
    a, b = (
        np.array([[*row, *[0.0] * (s - len(row))] for row in rows]) for rows in (place, velocity)
    )
    return Table(np.array(c, dtype=float), a, b, carries)


def _runge_kutta(matrix: Array) -> Table:
    """Table of an explicit Runge-Kutta method; the last row of its matrix holds the weights."""
    # The Nyström form of a Runge-Kutta method follows by inserting the velocities of the stages
    # into the positions: c = matrix·1, A = matrix², B = matrix.
    return Table(matrix.sum(axis=1), matrix @ matrix[:-1], matrix)


def _matrix(rows: Sequence[Sequence[float]], weights: Sequence[float]) -> Array:
    shares = [b / sum(weights) for b in weights]
    return np.array([[*row, *[0.0] * (len(weights) - len(row))] for row in ((), *rows, shares)])


def _adams_bashforth(
    parabola: bool, f: Any, y: Array, t: Any, h: Any, left: Any, whole: Any
) -> tuple[Array, Any]:
    # y + h (3 f_n - f_{n-1})/2 for a whole step; a shorter last step extrapolates the same line.
    # The first step is Euler's. With a parabola, the position moves under a constant acceleration.
    now = f(y, t, y)
    before = now if left is None else left
    new = y + h * (now + h / (2.0 * whole) * (now - before))
    if parabola:
        new[:3] = y[:3] + h * (y[3:6] + h / 2.0 * now[3:6])
    return new, now


@dataclass(frozen=True)
class Integrator:
    """A step, and the order of its errors; without a step, the exact path.

    Attributes
    ----------
    words
        Name of the integrator.
    order
        Order of the errors; 0 if they do not vanish with the step, None if it is unknown.
    step
        The step.
    matrix
        The coefficients of a Runge-Kutta method.
    frozen
        Parts of the law that are computed with the speed at the step's start.
    """

    words: str
    order: int | None
    step: Step | None = None
    matrix: Array | None = field(default=None, compare=False)
    frozen: str = ""

    @property
    def like(self) -> Any:
        """A key that integrators share if they can fly `together`."""
        if not isinstance(self.step, Table):
            return self.words
        return len(self.step.c), self.step.carries, self.order == 0, self.frozen

    def law(self, stage: Stage) -> Stage:
        """A stage whose law has the frozen speed."""
        if not self.frozen:
            return stage
        # The speed U, computed from the state at the step's start.
        speed = stage.roots["through"]
        inner = speed.args[0] if speed.op == "named" else speed
        begun = inner
        for node in ordered([inner]):
            if node.op == "symbol" and node.data in START:
                begun = substitute(begun, node, START[str(node.data)])
        # Drag uses U by its name. Under the reading `wind_acts_on = drag`, lift uses |v| without a
        # name: replacing the name changes drag alone, replacing its content changes both. Under
        # other readings the two variants are the same law.
        old = speed if self.frozen == "drag" else inner
        law = substitute(stage.roots["law"], old, begun)
        return replace(stage, roots={**stage.roots, "law": law})


def _of_runge_kutta(
    words: str, order: int, rows: Sequence[Sequence[float]], weights: Sequence[float]
) -> Integrator:
    matrix = _matrix(rows, weights)
    return Integrator(words, order, _runge_kutta(matrix), matrix)


EXACT = Integrator("an exact path", None)
STRAIGHT = _table((1,), ((),), ((),))
_EULER = _of_runge_kutta("explicit Euler", 1, (), (1,))
_MIDPOINT = _of_runge_kutta("the midpoint method", 2, ((0.5,),), (0, 1))
_HEUN = _of_runge_kutta("Heun's method", 2, ((1,),), (1, 1))
_HALVES, _CLASSICAL = ((0.5,), (0, 0.5), (0, 0, 1)), (1, 2, 2, 1)
_RK4 = _of_runge_kutta("RK4", 4, _HALVES, _CLASSICAL)
# Velocity Verlet needs the new acceleration before the new velocity, on which drag and lift depend.
# Euler's method predicts this velocity over a fraction of the step: the fraction, words, and the
# order of the errors.
_FORCES = {
    0.0: ("the force at the old velocity", 1),
    0.5: ("the force at the half-step velocity", 1),
    1.0: ("the force at a predicted velocity", 2),
}
_ROUNDS = 8  # iterations of an implicit velocity
VERLET = {
    Treatment(ahead, False, carries): Integrator(
        f"velocity Verlet with {words}{', which the next step begins with' * carries}",
        order,
        _table((0, 1, 1), ((), (0.5,), (0.5,)), ((), (ahead,), (0.5, 0.5)), carries),
    )
    for (ahead, (words, order)), carries in product(_FORCES.items(), (False, True))
} | {
    Treatment(1.0, True, False): Integrator(
        "velocity Verlet with an implicit velocity", 2,
        _table(
            (0, *[1] * (_ROUNDS + 1)), ((), *[(0.5,)] * (_ROUNDS + 1)),
            ((), (1,), *[(0.5, *[0] * i, 0.5) for i in range(_ROUNDS)]),
        ),
    )
}  # fmt: skip
_SEMI_IMPLICIT = (
    Integrator(
        "semi-implicit Euler, velocity first", 1, _table((0, 1), ((), (1,)), ((), (1,)))
    ),
    Integrator("semi-implicit Euler, position first", 1, _table((1, 1), ((), ()), ((), (1,)))),
    Integrator("constant acceleration over each step", 1, _table((0, 1), ((), (0.5,)), ((), (1,)))),
    Integrator(
        "leapfrog with the force at the old velocity", 1, _table((0.5, 1), ((), (0.5,)), ((), (1,)))
    ),
)  # fmt: skip


def _rk4_moved(share: float) -> Table:
    """RK4 that moves the ball at the step's first velocity plus a share of its change."""
    table = _runge_kutta(_matrix(_HALVES, _CLASSICAL))
    return replace(table, place=np.vstack([table.place[:-1], share * table.velocity[-1]]))


INTEGRATORS = (
    _EULER,
    *_SEMI_IMPLICIT,
    _MIDPOINT,
    _HEUN,
    _of_runge_kutta("Ralston's method", 2, ((2 / 3,),), (1, 3)),
    *VERLET.values(),
    Integrator("the Adams-Bashforth method of order 2", 2, partial(_adams_bashforth, False)),
    Integrator(
        "the Adams-Bashforth method of order 2 for the velocity", 2, partial(_adams_bashforth, True)
    ),
    _of_runge_kutta("Kutta's method of order 3", 3, ((0.5,), (-1, 2)), (1, 4, 1)),
    _of_runge_kutta("Heun's method of order 3", 3, ((1 / 3,), (0, 2 / 3)), (1, 0, 3)),
    _RK4,
    _of_runge_kutta(
        "the 3/8 rule of order 4", 4, ((1 / 3,), (-1 / 3, 1), (1, -1, 1)), (1, 3, 3, 1)
    ),
    *(
        Integrator(f"RK4 whose position moves with {words}", order, _rk4_moved(share))
        for share, order, words in (
            (0.0, 1, "the velocity at the step's start"),
            (1.0, 1, "the velocity at the step's end"),
            (0.5, 2, "the mean of the velocities at the step's ends"),
        )
    ),
    *(
        replace(_RK4, words=f"RK4 whose {what} the speed at the step's start", order=1,
                frozen=frozen)
        for frozen, what in (("drag", "drag takes"), ("drag and lift", "drag and lift take"))
    ),
    *(
        _of_runge_kutta(f"RK4 with the weights {weights}", 2, _HALVES, weights)
        for weights in ((1, 1, 1, 1), (2, 1, 1, 2), (1, 3, 3, 1))
    ),
)  # fmt: skip

# --- slips in a table -----------------------------------------------------------------------------

_EXPLICIT = (one for how, one in VERLET.items() if not how.iterates)
SLIPPED = (_RK4, _MIDPOINT, _HEUN, _EULER, *_SEMI_IMPLICIT, *_EXPLICIT)
TIMES = (0.0, 2.0, 0.5, -1.0, 1.5, 3.0)  # factors of a wrong coefficient
# Factors of all weights: a wrong sign, or a divisor other than 6 = 1 + 2 + 2 + 1.
DIVIDED = (-1.0, *(6 / n for n in range(1, 19) if n != 6))


@cache
def slips() -> tuple[Integrator, ...]:
    """Integrators with a wrong coefficient."""
    found = []
    for one in SLIPPED:
        assert isinstance(one.step, Table)
        # A program may advance position and velocity together, so that a slip in the matrix affects
        # both; or separately, so that a slip is in one coefficient of the table. Programs with a
        # Runge-Kutta method write only the sum at the end separately.
        apart = _of_table(one.step, 0 if one.matrix is None else len(one.step.c) - 1)
        both = () if one.matrix is None else _of_matrix(one.matrix)
        found += [
            Integrator(f"{one.words} with {words}", None if table.is_consistent else 0, table)
            for table, words in (*both, *apart)
        ]
    return tuple(found)


def _of_matrix(matrix: Array) -> Iterator[tuple[Table, str]]:
    """Tables of a Runge-Kutta method with another coefficient, and what is wrong in words."""
    last = len(matrix) - 1
    for i, j in zip(*np.nonzero(matrix), strict=True):
        where = "the last sum" if i == last else f"the state of k{i + 1}"
        for factor in TIMES:
            other = factor * matrix[i, j]
            yield _with(matrix, {(i, j): other}), _said(other, matrix[i, j], f"k{j + 1}", where)
        for k in range(i):
            if matrix[i, k] == 0.0:
                moved = {(i, j): 0.0, (i, k): matrix[i, j]}
                yield _with(matrix, moved), f"k{k + 1} for k{j + 1} in {where}"
        for k in range(j):
            if matrix[i, k] not in (0.0, matrix[i, j]):
                moved = {(i, j): matrix[i, k], (i, k): matrix[i, j]}
                yield _with(matrix, moved), f"exchanged weights of k{k + 1} and k{j + 1} in {where}"
    for factor in DIVIDED:
        changes = {(last, j): factor * b for j, b in enumerate(matrix[last])}
        yield _with(matrix, changes), f"{_fraction(factor)} times its last sum"


def _with(matrix: Array, changes: Mapping[tuple[int, int], float]) -> Table:
    changed = matrix.copy()
    for place, value in changes.items():
        changed[place] = value
    return _runge_kutta(changed)


def _of_table(table: Table, first: int) -> Iterator[tuple[Table, str]]:
    """Tables with another coefficient from the row `first` on, and what is wrong in words."""
    last = len(table.c) - 1
    for name, unit in (("c", "h v"), ("velocity", "h a{}"), ("place", "h² a{}")):
        numbers = getattr(table, name)
        for at in zip(*np.nonzero(numbers), strict=True):
            i = at[0]
            if i < first:
                continue
            what = unit.format(at[1] + 1 if len(at) > 1 else "")
            whose = "velocity" if name == "velocity" else "place"
            where = f"the {whose}" + ("" if i == last else f" of a{i + 1}")
            for factor in TIMES:
                changed, other = numbers.copy(), factor * numbers[at]
                changed[at] = other
                yield replace(table, **{name: changed}), _said(other, numbers[at], what, where)


def _said(new: float, old: float, what: str, where: str) -> str:
    if not new:
        return f"no {what} in {where}"
    return f"{_fraction(new)} {what} for {_fraction(old)} {what} in {where}"


def _fraction(x: float) -> str:
    return str(Fraction(x).limit_denominator(24))  # a free choice above all divisors


def together(some: Sequence[Integrator], count: int) -> Integrator:
    """Integrators that are `like` each other as one, which flies `count` balls by each in turn."""
    tables = [one.step for one in some if isinstance(one.step, Table)]
    if not tables:  # an integrator without a table is `like` no other
        return some[0]

    def repeated(name: str) -> Array:
        stacked = np.stack([getattr(table, name) for table in tables], axis=-1)
        return np.repeat(stacked, count, axis=-1)

    table = Table(repeated("c"), repeated("place"), repeated("velocity"), tables[0].carries)
    return replace(some[0], words="several", step=table, matrix=None)


# --- flights --------------------------------------------------------------------------------------

ON_STEP = 1e-7  # of a step: a time that is nearer to the end of a step is that end; a free choice
DIRECT = 2000  # largest number of steps that are taken one by one
# A flight with more steps than that, and more than those of the following flights together, is
# interpolated between these and the exact path; s.
NODES = (0.1, 0.05, 0.025, 0.0125, 0.00625)


def _reached(balls: Launched, one: Integrator, h: Any, counts: Index) -> tuple[Array, Any, Array]:
    """The states after a number of steps, what the last steps carry over, and the states' errors.

    Errors of a method with constant steps have an expansion in powers of the step (Hairer, Nørsett
    and Wanner, Sec. II.8). The state at a fixed time, after m steps, is therefore nearly a
    polynomial in 1/m. It is interpolated from flights with a few small m and from the exact path,
    1/m = 0. A method of order 0 does not converge to the exact path, which is omitted then.
    """
    if one.step is None:
        y = flown(balls, np.asarray(counts * h))
        return y, None, np.zeros_like(y)
    time: Array = np.asarray(counts * h, dtype=float)
    many = [math.ceil(time.max(initial=0.0) / node) for node in NODES]
    direct = counts <= max(DIRECT, sum(many))
    short, last = stepped(balls, one.step, h, np.where(direct, counts, 0))
    if direct.all():
        return short, last, np.zeros_like(short)
    exact = flown(balls, time)
    found = [stepped(balls, one.step, time / m, np.full(len(counts), m)) for m in many]
    x = np.array([0.0, *(1.0 / m for m in many)])
    target = 1.0 / np.maximum(counts, 1)
    first = 1 if one.order == 0 else 0

    def interpolated(states: Sequence[Array], skip: int | None = None) -> Array:
        """Lagrange's polynomial through the states, one of which may be skipped, at `target`."""
        used = [i for i in range(first, len(x)) if i != skip]
        weights = [np.prod([(target - x[k]) / (x[i] - x[k]) for k in used if k != i], axis=0)
                   for i in used]  # fmt: skip
        return np.asarray(sum(w * states[i] for w, i in zip(weights, used, strict=True)))

    # The error is estimated by the difference from the polynomial without the coarsest flight.
    states = [exact, *(y for y, _ in found)]
    y = np.where(direct, short, interpolated(states))
    doubt = np.where(direct, 0.0, np.abs(y - interpolated(states, skip=1)))
    if found[0][1] is None:
        return y, None, doubt
    slopes = [balls.rates(exact, time), *(left for _, left in found)]
    slope = interpolated(slopes)
    return y, slope if last is None else np.where(direct, last, slope), doubt


@dataclass(frozen=True)
class Way:
    """A flight in steps of h, s, and the kind of its last step.

    The last step is shorter; or it is a step of another integrator; or the end lies on the chord of
    a whole step. The batted ball is struck at once, or pushed during a few steps.

    Attributes
    ----------
    one, h
        The integrator and its step.
    chord
        True if the end lies on the chord between the steps before and after it.
    last
        The last step, if it is that of another integrator.
    push
        Steps at which the contact force acts in the paper's scheme.
    times
        Size of the push, in units of half of the contact force.

    Examples
    --------
    >>> Way(VERLET[Treatment(0.0, False, False)], 0.05, chord=True).words[:65]
    'behaves like velocity Verlet with the force at the old velocity i'
    >>> Way(EXACT, 0.001, chord=True).words
    'puts the end of the flight on the chord between two steps of 0.001 s'
    """

    one: Integrator
    h: float
    chord: bool = False
    last: Step | None = None
    push: ContactForce | None = None
    times: float = 1.0

    @property
    def words(self) -> str:
        """The way as a clause without its subject."""
        if self.push is not None:
            half = "half of" if self.times == 1.0 else f"{self.times:g} times half of"
            said = (
                f"pushes the ball with {half} the contact force {_PUSHED[self.push]}, in steps of"
            )
            share = self.times * impulse_share(self.push)
            return f"{said} {self.h:.6g} s" + f" ({share:g} times the impulse)" * (share != 1.0)
        if self.one is EXACT:
            return f"puts the end of the flight on the chord between two steps of {self.h:.6g} s"
        end = ", and ends on the chord between two of them" if self.chord else ""
        return f"behaves like {self.one.words} in steps of {self.h:.6g} s{end}"

    @property
    def reads(self) -> Sequence[str]:
        """Columns that the flight needs besides those of the stage's formulas."""
        return () if self.push is None else PUSHED_BY

    def __call__(
        self, stage: Stage, columns: Mapping[str, Any]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """A stage's quantities and their errors."""
        if self.push is not None:
            return _pushed(stage, columns, self, [self.times * on for on in PUSHES[self.push]])
        return steps(stage, columns, self.one, self.h, self.chord, self.last)


def in_steps(data: Data, engine: Verlet) -> Data:
    """Data with the integrators of the paper's scheme, and the last step before each contact."""
    way = Way(VERLET[TREATMENTS[engine.forces]], engine.dt, chord=True)
    batted = replace(way, push=engine.contact_force)
    ways = {"pitch": way, "touching": straight(way), **dict.fromkeys(BATTED, batted)}
    before = np.floor(data.expected["contact.time"] / engine.dt + ON_STEP) * engine.dt
    return replace(data, ways=ways, columns={**data.columns, str(last_step.data): before})


BATTED = ("flight", "fence")  # stages of a batted ball's flight
# Columns that a push needs: time, place and velocity of the contact, the velocity after it, and the
# time of flight.
PUSHED_BY = *(
    str(OWN[quantity].data)
    for quantity in ("contact.time", "contact.position", "contact.velocity", "impact.velocity")
), "hang_time"  # fmt: skip
_PUSHED: dict[ContactForce, str] = {
    "whole": "as a constant over two steps",
    "carried": "at three steps in a row, as velocity Verlet carries an acceleration on",
    "late": "at the two steps after the contact, as velocity Verlet carries an acceleration on",
    "early": "at the steps next to the contact, as velocity Verlet carries an acceleration on",
}


def straight(way: Way) -> Way:
    """A way whose last step is a straight line at the velocity of the step's start."""
    return Way(way.one, way.h, last=STRAIGHT)


def steps(
    stage: Stage,
    columns: Mapping[str, Any],
    one: Integrator,
    h: Any,
    chord: bool,
    last: Step | None = None,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """A stage's quantities after a flight in steps of h, and their errors; see `Way`."""
    # Whole steps up to the last one before the end, then the rest of the time.
    balls = launched(one.law(stage), columns)
    counts = np.floor(np.nan_to_num(balls.duration) / h + ON_STEP).astype(int).clip(0)
    y, left, doubt = _reached(balls, one, h, counts)
    rest = balls.duration - counts * h
    if one.step is None:
        new = y + rest / h * (flown(balls, np.asarray((counts + 1) * h)) - y)
    elif chord:
        new = y + rest / h * (one.step(balls.rates, y, counts * h, h, left, h)[0] - y)
    else:
        new, _ = (last or one.step)(balls.rates, y, counts * h, rest, left, h)
    found = balls.ended(new)
    doubts = {q: np.zeros_like(x) for q, x in found.items()}
    for quantity, part in zip(stage.quantities, (doubt[:3], doubt[3:6]), strict=False):
        # The estimate for one component may be small by chance: use the largest of the three.
        doubts[quantity] = np.broadcast_to(part.max(axis=0), part.shape)
    return found, doubts


def _pushed(
    stage: Stage, columns: Mapping[str, Any], way: Way, on: Sequence[float]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """A stage's quantities and their errors, for balls that the contact force F̄/2 pushes.

    Paper, Appendix B. `on` are the multiples of F̄/2 that act at each step, beginning with the last
    step before the contact; together they replace the impulse m (V⁺ - V).
    """
    h, step = way.h, way.one.step
    struck = columns["kind"] == "at-bat"
    if step is None or not struck.any():
        return steps(stage, columns, way.one, h, way.chord, way.last)
    time, place, velocity, after, hang = PUSHED_BY
    # The ball goes back along a straight line from the contact to the last step before it.
    ahead = columns[time] - np.floor(columns[time] / h + ON_STEP) * h
    before = columns[velocity]
    half = (columns[after] - before) / (2.0 * h)  # F̄/2m, for F̄ h = m (V⁺ - V)

    def rates(y: Array, t: Any, start: Array | None = None) -> Array:
        # There is no launch yet that fixes the axis of the lift: the air acts as on a ball that is
        # launched with the present velocity.
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
    # The rest is a flight that starts where the push ends.
    pushed = (len(on) - 1) * h - ahead
    free = {
        time: columns[time] + pushed, hang: columns[hang] - pushed, place: y[:3], after: y[3:6]
    }  # fmt: skip
    free = {name: np.where(struck, column, columns[name]) for name, column in free.items()}
    found, doubts = steps(stage, {**columns, **free}, way.one, h, way.chord, way.last)
    # A ball that lands during the push lies on the chord between two of its states.
    flown_for = launched(stage, columns).duration + ahead
    counts = np.floor(flown_for / h + ON_STEP)
    for k, (begin, end) in enumerate(pairwise(states)):
        here = struck & (counts == k)
        down = begin + (flown_for / h - k) * (end - begin)
        for quantity, part in zip(stage.quantities, (down[:3], down[3:6]), strict=False):
            found[quantity] = np.where(here, part, found[quantity])
    return found, doubts
