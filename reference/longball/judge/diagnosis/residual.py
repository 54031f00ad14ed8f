"""Residuals of each stage: the candidate's values minus those that follow from its earlier values.

This module also flies all balls of the diagnosis, by any edited law: all scenes at once, by an
eighth-order Runge-Kutta method (Hairer, Nørsett and Wanner, *Solving Ordinary Differential
Equations I*, Sec. II.5; the coefficients are SciPy's).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853

from longball.engines.fence import chords
from longball.judge.answers import Answer
from longball.judge.cases import SLACK, Case, attainable
from longball.judge.diagnosis.chain import (
    CHAIN,
    INPUTS,
    MOVING,
    OWN,
    SPEED,
    Kind,
    Stage,
    closest,
    ended,
    highest,
    n,
    r_dot,
    rising,
)
from longball.judge.diagnosis.evidence import ADEQUATE, is_adequate
from longball.judge.diagnosis.expression import (
    JUMPS,
    Evaluator,
    M,
    Node,
    Pieces,
    depends,
    digests,
    names_in,
    ordered,
    specialised,
    symbol,
)
from longball.judge.diagnosis.operators import GIVEN, LEFT_OUT, WITHOUT_BLOCK, ZERO, key_of
from longball.judge.quantities import QUANTITIES, values_of
from longball.model.air import Air
from longball.model.arrays import Array
from longball.model.numbers import DOUBLES
from longball.model.quantities import at as value_at

# Relative error of a right value, from rounding in about a hundred steps of the candidate and of
# the judge.
ROUNDING = 1e-12
# Relative error that needs no explanation, because a careful integrator makes it: RK4 at 1 ms has
# 1e-11 at a landing, adaptive methods with a tolerance of 1e-10 have about 1e-9.
NOISE = 2.5e-10


class Stepping(NamedTuple):
    """Equal steps of a flight: each at most `longest`, but no more than `most` of them.

    If they are `controlled`, the steps adapt to the error and end at kinks and jumps of the law.
    """

    longest: float  # s
    most: int
    controlled: bool = False


# Steps of flights: free choices, finer than the differences that are looked for.
# FINE steps have a median error of 1e-14 at the landings of the golden flights. COARSE steps give
# the effects of nine edits in ten to better than a thousandth.
FINE, MIDDLE, COARSE = Stepping(0.8, 400, controlled=True), Stepping(0.5, 100), Stepping(1.7, 4)
# Steps of a program that does not look for kinks and jumps. The error of a step across one is
# proportional to its length, whatever the method.
UNAWARE = Stepping(0.05, 400)
# Flights are grouped by their number of steps, up to 36, 36², and so on. A batch takes as many
# steps as its longest flight.
TOGETHER = 36
LONGEST_FLIGHT = 120.0  # s: no ball flies longer, whatever time a candidate gives
CAREFUL, TOTAL = 1e-12, 3e-11  # relative errors of each controlled step, and of the whole flight
# A step across a kink or a jump is divided at BESIDE of its length before the kink and beyond it,
# until it is shorter than LEAST of the flight.
BESIDE, LEAST = 1 / 512, 1e-11
BISECTIONS = 11  # steps of bisection that locate a kink: 2⁻¹¹ is a fourth of BESIDE
CUTS = 150  # further steps of a controlled flight: an edited law may switch anywhere
# A ball is stuck if it covers less than PROGRESS of its flight in PATIENCE steps. A kink takes
# about ten.
PROGRESS, PATIENCE = 1e-3, 64

Index = NDArray[np.integer[Any]]  # positions of scenes


class Flying(Protocol):
    """The flights of a candidate, from a stage and its columns to quantities and their errors."""

    @property
    def reads(self) -> Sequence[str]:
        """Columns that the flights need besides those of the stage's formulas."""

    def __call__(
        self, stage: Stage, columns: Mapping[str, Any]
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the quantities of the stage, and their errors."""


@dataclass(frozen=True)
class Data:
    """Scenes and answers as columns with one entry for each scene, NaN where a value is missing.

    Attributes
    ----------
    cases
        The scenes with their truth.
    columns
        Inputs by symbol, and the scenes' options by switch.
    given
        The candidate's values by quantity, shape (n,) or (3, n).
    expected
        The true values.
    attainable
        The errors that double precision cannot avoid, shape (n,).
    cut
        Half a unit in the last written digit, absolute and relative, for quantities that are not
        written in full.
    slips
        A function that propagates the rounding of the written digits through a stage.
    granted
        The largest error that passes, in the SI unit of each quantity.
    ways
        The known integrators of the candidate, by stage name. Other stages are flown exactly.
    rough
        Names of the stages to which an edit has added a jump or a kink; see `compared`.
    blind
        Scenes that are not compared, by the stage's name and kind: the right chain does not
        reproduce the true value from true earlier values. A ball may graze a jump of the law.
    flights
        The ends of balls that were flown, by steps, integrator and quantities: a cache.
    """

    cases: Sequence[Case]
    columns: Mapping[str, Any]
    given: Mapping[str, Array]
    expected: Mapping[str, Array]
    attainable: Mapping[str, Array]
    cut: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    slips: Callable[..., Array] | None = None
    granted: float = 0.0
    ways: Mapping[str, Flying] = field(default_factory=dict)
    rough: frozenset[str] = frozenset()
    blind: Mapping[tuple[str, Kind], Index] = field(default_factory=dict)
    flights: dict[Any, Any] = field(default_factory=dict, compare=False)

    def way(self, stage: Stage) -> Flying | None:
        """The candidate's integrator of a stage; None if it flies exactly, or is no flight."""
        return self.ways.get(stage.name) if stage.kind == "flight" else None


def data_of(cases: Sequence[Case], answers: Mapping[str, Answer], granted: float = 0.0) -> Data:
    """Scenes and answers as columns."""
    given, expected, errors = {}, {}, {}
    for quantity, own in OWN.items():
        shape = (3, len(cases)) if own.vector else (len(cases),)
        given[quantity] = np.full(shape, np.nan)
        expected[quantity] = np.full(shape, np.nan)
        errors[quantity] = np.zeros(len(cases))
    for i, case in enumerate(cases):
        true, said = values_of(case.expected), answers[case.id].values
        for quantity in true.keys() & OWN.keys():
            expected[quantity][..., i] = _floats(true[quantity])
            errors[quantity][i] = attainable(case, quantity)
            if quantity in said:
                given[quantity][..., i] = _floats(said[quantity])
    scenes = [case.scene for case in cases]
    tops = given["fence.position"][2] - given["fence.clearance"]
    segments = [answers[case.id].told.get("fence.segment") for case in cases]
    chords_at = _fences(scenes, given["fence.position"], tops, segments)
    # The true margin belongs to the true pitch, and cannot be compared with that of another pitch.
    pitched = np.abs(given["plate.position"] - expected["plate.position"]).max(axis=0)
    given["contact.margin"][~(pitched <= SAME_PATH)] = np.nan
    # Nor can the true highest point be compared with that of another flight.
    ends = ("landing.position", "landing.velocity")  # straight up, the position says nothing
    landed = np.max([np.abs(given[q] - expected[q]).max(axis=0) for q in ends], axis=0)
    for quantity in ("apex.time", "apex.position"):
        given[quantity][..., ~(landed <= max(SAME_PATH, granted))] = np.nan
    numbers = inputs(scenes)
    columns = {**numbers, **switches(scenes), **keys(scenes, numbers), **chords_at}
    # The closest distance has no formula: it follows from the true margin, and the stage `margin`
    # turns it into a margin again.
    columns[str(closest.data)] = columns["R"] + columns["r_b"] - expected["contact.margin"]
    columns[str(rising.data)] = expected["apex.time"] - np.nan_to_num(expected["contact.time"])
    columns[str(highest.data)] = expected["apex.position"]
    return Data(cases, columns, given, expected, errors, granted=granted)


# m: pitches count as equal if they are this near to each other at the plate, flights if they are
# this near at the landing.
SAME_PATH = 1e-9  # a free choice


def _floats(value: Sequence[Any]) -> Any:
    numbers = [float(x) for x in value]
    return numbers if len(numbers) > 1 else numbers[0]


def inputs(scenes: Sequence[Any]) -> dict[str, Array]:
    """The numbers of scenes by symbol."""
    found = {}
    filled = [_with_air(scene) for scene in scenes]
    for node, path, null in INPUTS:
        nothing: Any = (null,) * 3 if node.vector else null
        column = [_number(scene, path, nothing) for scene in filled]
        found[str(node.data)] = np.array(column, dtype=float).T
    for side in ("drag", "lift"):
        key = f"air.{side}_coefficient"
        laws = [value_at(scene, key) if _has(scene, "air") else None for scene in scenes]
        for part in ("at", "values"):
            # Columns need rows of one length: the last node of a shorter table is repeated.
            rows = [getattr(law, part, (0.0, 1.0)) for law in laws]
            longest = max(map(len, rows), default=2)
            filled = [(*row, *[row[-1]] * (longest - len(row))) for row in rows]
            found[f"{key}.{part}"] = np.array(filled, dtype=float).T
    return found


def _with_air(scene: Any) -> Any:
    """A scene with the default air in place of null, for programs that ignore the null."""
    return scene.model_copy(update={"air": Air()}) if getattr(scene, "air", 0) is None else scene


def keys(scenes: Sequence[Any], numbers: Mapping[str, Array]) -> dict[str, Array]:
    """Columns by `key_of`: whether scenes give a number, omit it or its block, or give 0."""
    found = {}
    for node, path, _ in INPUTS:
        column = np.array([_in_scene(scene, path) for scene in scenes])
        if not node.vector:
            column[(column == GIVEN) & (numbers[str(node.data)] == 0.0)] = ZERO
        found[key_of(node)] = column
    return found


def _in_scene(scene: Any, path: str) -> str:
    """An option of a key's column, except ZERO: whether a scene gives it, omits it or its block."""
    block, (*above, last) = scene, path.partition("[")[0].split(".")
    for key in (*above, last):
        if key not in getattr(type(block), "model_fields", {}):
            return GIVEN
        if key not in block.model_fields_set:
            return LEFT_OUT if key == last else WITHOUT_BLOCK
        block = getattr(block, key)
    return GIVEN


def _has(scene: Any, key: str) -> bool:
    return getattr(scene, key, None) is not None


def _number(scene: Any, path: str, nothing: Any) -> Any:
    try:
        value = value_at(scene, path)
    except ValueError:  # this kind of scene has no such key
        return nothing
    # A key such as `air.wind` may hold a vector, a number or a block: the input has one of these.
    if isinstance(value, tuple):
        return value if isinstance(nothing, tuple) else nothing
    return float(value) if isinstance(value, int | float) else nothing


SWITCHES = frozenset(
    node.data[0]
    for node in ordered(root for stage in CHAIN for root in stage.roots.values())
    if node.op == "switch"
) | {"spin after"}


def switches(scenes: Sequence[Any]) -> dict[str, Array]:
    """The options of scenes by switch of the chain."""
    rows = [options(scene) for scene in scenes]
    return {key: np.array([row[key] for row in rows]) for key in (rows[0] if rows else SWITCHES)}


def options(scene: Any) -> dict[str, str]:
    """The options of a scene by switch of the chain: readings, and which keys and laws it has."""
    found = {f"reading.{key}": str(option) for key, option in scene.reading}
    found["kind"] = scene.kind
    filled = _with_air(scene)
    found |= {path: form(value_at(filled, path)) for path in FORMED}
    found["air"] = form(getattr(scene, "air", None))
    found["bat.support"] = value_at(scene, "bat.support") or "pivot"
    found["pitch"] = "aimed" if value_at(scene, "pitch.velocity") is None else "velocity"
    begun = ("pitch.spin", "launch.spin", "incoming.spin")
    spins = any(value_at(scene, path) is not None for path in begun)
    found["spin"] = "given" if spins else "none"
    found["spin after"] = "given" if spins or found["bat.friction"] == "given" else "none"
    return found


# Keys whose form is an option of a switch.
FORMED = (
    "air.drag_coefficient", "air.lift_coefficient", "air.side_coefficient", "air.density",
    "air.wind", "air.spin_decay_length", "air.density_scale_height", "earth", "fence",
    "bat.friction",
)  # fmt: skip
# Words for the form of a block, by a key that only this form has.
FORMS = {
    "above": "above a height", "roughness": "logarithmic", "temperature": "weather",
    "polyline": "a polyline", "radius": "a circle",
}  # fmt: skip


def form(held: Any) -> str:
    """The form of a key's value: "none", a law, the form of a block, or "given"."""
    if held is None:
        return "none"
    if law := getattr(held, "law", None):
        return f"table of {held.of}" if law == "table" else str(law)
    return next((FORMS[key] for key in FORMS if getattr(held, key, None) is not None), "given")


def _fences(
    scenes: Sequence[Any], places: Array, tops: Array, segments: Sequence[object]
) -> dict[str, Array]:
    """The ends of the nearest chord to a point on the fence, for each scene.

    At a corner or a step of the wall two chords are equally near. The function chooses the one that
    the candidate names (`segments`), or else the one whose height is nearer to `tops`, which
    follows from its clearance.
    """
    ends = np.full((2, 3, len(scenes)), np.nan)
    for i, scene in enumerate(scenes):
        fence = getattr(scene, "fence", None)
        if fence is None or fence.polyline is None or not np.isfinite(places[:, i]).all():
            continue
        x, y, _ = places[:, i]
        found = []
        for chord in chords(fence.polyline, DOUBLES):
            (ax, ay, az), (bx, by, bz) = chord.a, chord.b
            along = (x - ax) * (bx - ax) + (y - ay) * (by - ay)
            share = min(max(along / ((bx - ax) ** 2 + (by - ay) ** 2), 0.0), 1.0)
            apart = math.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay))
            above = np.nan_to_num(abs(az + share * (bz - az) - tops[i]))
            found.append((apart, chord.segment != segments[i], above, chord))
        least = min(apart for apart, *_ in found) + AT_CORNER
        near = [one for one in found if one[0] <= least]
        *_, nearest = min(near, key=lambda one: (one[1:3], one[0]))
        ends[:, :, i] = nearest.a, nearest.b
    return {"chord.a": ends[0], "chord.b": ends[1]}


AT_CORNER = 1e-9  # m: chords are equally near if their distances differ by less; a free choice


# --- flights --------------------------------------------------------------------------------------

Columns = Mapping[str, Any]


def take(columns: Columns, some: Index) -> dict[str, Any]:
    """Columns of some scenes."""
    return {name: column[..., some] for name, column in columns.items()}


def evenly(some: Index, most: int) -> Index:
    """At most `most` of some scenes, evenly spaced."""
    if len(some) <= most:
        return some
    return np.asarray(some[np.linspace(0, len(some) - 1, most).round().astype(int)])


def with_every_option(columns: Columns) -> Index:
    """Scenes, as few as one for each option, that have every option of all columns."""
    found = np.zeros(0, dtype=int)
    for column in columns.values():
        if column.dtype.kind != "f":
            options, first = np.unique(column, return_index=True)
            found = np.append(found, first[~np.isin(options, column[found])])
    return found


_A, _B, _C = DOP853.A[:12, :12], DOP853.B, DOP853.C[:12]
_PATH = frozenset(("path",))


@dataclass(frozen=True)
class Launched:
    """Balls at the start of a stage's flight.

    Attributes
    ----------
    y
        Position, velocity, and path length through the air, shape (7, balls).
    spin
        Spin at the start.
    duration
        Time of flight, s.
    rates
        Function that returns the derivative of `y` from a state, a time, and the state at the
        beginning of the step.
    ended
        Function from the final state to the stage's quantities.
    piece
        Function from a state and a time to numbers that change where the ball crosses a kink or a
        jump of the law.
    some
        Function that selects balls.
    """

    y: Array
    spin: Array
    duration: Array
    rates: Callable[..., Array]
    ended: Callable[[Array], dict[str, Array]]
    piece: Callable[[Array, Any], Array]
    some: Callable[[Index], Launched]


START = {
    "r": symbol("r at the step's start", M, True),
    "v": symbol("v at the step's start", SPEED, True),
}


def launched(stage: Stage, columns: Columns) -> Launched:
    """Launch the balls of a stage."""
    roots, names = stage.roots, stage.quantities
    starts = [roots[name] for name in ("place", "velocity", "spin", "duration")]
    place, velocity, spin, duration = Evaluator(starts, columns)()
    count = len(columns["kind"])
    y = np.zeros((7, count))
    y[:3], y[3:6] = place, velocity
    duration = np.clip(duration, -LONGEST_FLIGHT, LONGEST_FLIGHT) + np.zeros(count)
    columns = {
        **columns,
        "r0": y[:3].copy(),
        "v0": y[3:6].copy(),
        "ω0": spin + np.zeros((3, count)),
    }
    # The path length is integrated only if the spin decays along it. The rate of the position is
    # the velocity, unless an edit has changed it.
    has_path = depends(roots["law"], _PATH) or depends(roots["spin_left"], _PATH)
    moving = MOVING | {str(node.data) for node in START.values()}
    is_edited = roots["rate"] is not r_dot
    more = ("through",) * has_path + ("rate",) * is_edited
    law = Evaluator([roots[name] for name in ("law", *more)], columns, moving)
    began = [str(START[name].data) for name in ("r", "v")]

    def rates(at: Array, t: Any, start: Array | None = None) -> Array:
        start = at if start is None else start
        begin = {began[0]: start[:3], began[1]: start[3:6]}
        found = law(r=at[:3], v=at[3:6], t=t, path=at[6], **{**begin, "dr/dt": at[3:6]})
        slope = np.empty_like(at)
        slope[:3], slope[3:6] = found[-1] if is_edited else at[3:6], found[0]
        slope[6] = found[1] if has_path else 0.0
        return slope

    def ended(y: Array) -> dict[str, Array]:
        found = {names[0]: y[:3], names[1]: y[3:6]}
        if len(names) > 2:
            left = Evaluator([roots["spin_left"]], columns, MOVING)
            share = left(r=y[:3], v=y[3:6], t=duration, path=y[6])[0]
            found[names[2]] = share * columns["ω0"]
        if len(names) > 3:
            found[names[3]] = y[6]
        return found

    @cache  # only controlled steps need the pieces of the law
    def pieces() -> Pieces:
        return Pieces(roots["law"], columns, moving)

    def piece(at: Array, t: Any) -> Array:
        begin = {began[0]: at[:3], began[1]: at[3:6]}
        return pieces()(r=at[:3], v=at[3:6], t=t, path=at[6], **begin)

    def some(which: Index) -> Launched:
        return launched(stage, take(columns, which))

    return Launched(y, columns["ω0"], duration, rates, ended, piece, some)


def flown(balls: Launched, duration: Array, limits: Stepping = FINE) -> Array:
    """Fly balls for a duration, s, and return their states."""
    return _flown(balls, duration, limits)[0]


def _flown(balls: Launched, duration: Array, limits: Stepping) -> tuple[Array, Array]:
    """The states of balls after a duration, and their relative errors; 0 for equal steps.

    The steps of a flight do not depend on the other flights.
    """
    y, doubt = np.full_like(balls.y, np.nan), np.zeros(balls.y.shape[1])
    # A duration may be negative, as with an edited clock: the ball flies backwards.
    steps = np.clip(np.ceil(np.abs(duration) / limits.longest), 1, limits.most)
    # A batch takes as many equal steps as its longest flight. Controlled steps go on without the
    # balls that have arrived.
    fly, groups = _in_controlled_steps, np.sign(steps)
    if not limits.controlled:
        fly, groups = _in_equal_steps, np.ceil(np.log(steps) / math.log(TOGETHER)).clip(1)
    for group in np.unique(groups[np.isfinite(groups)]):
        which = np.flatnonzero(groups == group)
        some = balls
        if len(which) < len(steps):
            some = replace(balls.some(which), y=balls.y[:, which])
        y[:, which], doubt[which] = fly(some, duration[which], steps[which])
    return y, doubt


def _in_equal_steps(balls: Launched, duration: Array, steps: Array) -> tuple[Array, Array]:
    """Fly balls in equal steps, and return the states and 0: their errors are not estimated."""
    y, h = balls.y, duration / steps
    for step in range(int(steps.max())):
        y = np.where(step < steps, _step(balls, y, step * h, h)[0], y)
    return y, np.zeros(len(steps))


def _step(balls: Launched, y: Array, t: Array, h: Array) -> tuple[Array, Array]:
    """The states after a step, and the rates on the way."""
    slopes = np.zeros((12, *y.shape))
    flat = slopes.reshape(12, -1)
    for i in range(12):
        at = y + h * (_A[i, :i] @ flat[:i]).reshape(y.shape) if i else y
        slopes[i] = balls.rates(at, t + _C[i] * h)
    return y + h * (_B @ flat).reshape(y.shape), slopes


def _error(y: Array, slopes: Array, h: Array) -> Array:
    """The largest relative error of each ball's step, by the method's own estimate."""
    # DOP853 combines estimates of orders 5 and 3: h e5²/√(e5² + 0.01 e3²) (Hairer et al., Sec.
    # II.10). The result falls as the eighth power of the step.
    e5, e3 = (np.abs(np.tensordot(e[:12], slopes, 1)) for e in (DOP853.E5, DOP853.E3))
    size = np.hypot(e5, 0.1 * e3)
    error = np.abs(h) * e5 * e5 / np.where(size > 0, size, 1.0)
    return np.asarray((error / np.maximum(np.abs(y), 1.0)).max(axis=0))


def _in_controlled_steps(balls: Launched, duration: Array, steps: Array) -> tuple[Array, Array]:
    """Fly balls in steps of controlled error that end at kinks and jumps of the law.

    Times and steps are fractions of the duration. None is longer than the equal ones would be. A
    step across a kink is rejected: bisection on the cubic between its ends locates the kink, and
    the next targets are just before it and just beyond. The short step between those may be divided
    in the same way, until it is shorter than `LEAST`.

    Return also the relative errors; `HUGE` for a ball that does not arrive in `CUTS` more steps, or
    is stuck, as where a force points against each motion: it covers less than `PROGRESS` of its
    flight in `PATIENCE` steps.
    """
    # Each ball has its own `whole`, the step that the error allows; `before` and `beyond`, the
    # times next to the last kink found; `here`, the present piece of the law; and `reached`, the
    # time when its progress was last checked.
    longest, most = 1.0 / steps, CUTS + 10 * steps
    y, t, whole = balls.y, np.zeros(len(steps)), longest
    before, beyond, reached = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
    here, found, index = balls.piece(y, t), y.copy(), np.arange(len(t))
    doubt, flies = np.full(len(t), HUGE), np.ones(len(t), dtype=bool)
    taken = 0
    while True:
        goal = np.where(before > t, before, np.where(beyond > t, beyond, 1.0))
        step = np.where(flies, np.minimum(whole, goal - t), 0.0)
        h = step * duration
        new, slopes = _step(balls, y, t * duration, h)
        there = balls.piece(new, (t + step) * duration)
        error = np.nan_to_num(_error(new, slopes, h), nan=HUGE)
        crossed = (there != here).any(axis=0) & (step > LEAST)
        coarse = (error > CAREFUL) & (step > LEAST) & ~crossed
        if crossed.any():
            kink = _first_kink(balls, y, new, t * duration, h, slopes[0])
            first = t + step * np.maximum(kink - BESIDE, BESIDE)
            before = np.where(crossed, first, before)
            beyond = np.where(crossed, first + 2 * BESIDE * step, beyond)
        # The usual step control: the error is proportional to the eighth power of the step. A step
        # that was cut short at a kink does not shorten the next ones.
        best = step * np.clip(0.9 * (CAREFUL / np.maximum(error, 1e-99)) ** 0.125, 0.1, 3.0)
        whole = np.where(coarse, best, np.clip(best, whole, longest))
        stays = crossed | coarse
        y, here = np.where(stays, y, new), np.where(stays, here, there)
        t = np.where(stays, t, t + step)
        taken += 1
        flies &= (t < 1.0 - LEAST) & (taken < most)
        if taken % PATIENCE == 0:
            flies &= t - reached > PROGRESS
            reached = t
        # Once at least half of the balls have ended, continue with the others alone.
        if flies.sum() <= len(index) / 2:
            found[:, index] = y
            doubt[index[t >= 1.0 - LEAST]] = TOTAL
            if not flies.any():
                return found, doubt
            balls, index, y = balls.some(np.flatnonzero(flies)), index[flies], y[:, flies]
            t, whole, before, beyond, reached, longest, most, duration = (
                x[flies] for x in (t, whole, before, beyond, reached, longest, most, duration)
            )
            here, flies = balls.piece(y, t * duration), flies[flies]


def _first_kink(balls: Launched, y: Array, new: Array, t: Array, h: Array, slope: Array) -> Array:
    """The fraction of each ball's step before the first kink of the law."""
    here, end = balls.piece(y, t), balls.rates(new, t + h)
    low, high = np.zeros_like(h), np.ones_like(h)
    for _ in range(BISECTIONS):
        s = (low + high) / 2
        # Hermite's cubic, as the chord plus a correction (Hairer et al., Eq. II.6.7).
        bent = (1 - 2 * s) * (y - new) + h * ((1 - s) * slope - s * end)
        at = y + s * (new - y) + s * (1 - s) * bent
        beyond = (balls.piece(at, t + s * h) != here).any(axis=0)
        low, high = np.where(beyond, low, s), np.where(beyond, s, high)
    return low


# A step of a scheme. The arguments are the rates, the state, its time, the length of the step, the
# value that the last step carried over (None at first), and the length of a whole step; a last step
# may be shorter. The results are the next state and the value to carry over, such as an old
# acceleration.
Step = Callable[..., tuple[Array, Any]]


def stepped(balls: Launched, step: Step, h: Any, counts: Index) -> tuple[Array, Any]:
    """Fly each ball by its number of steps of a scheme.

    Return the states, and the values that the last steps carry over; None if steps carry nothing.
    """
    y, carried = balls.y, None
    found, kept = y.copy(), balls.rates(y, 0.0)
    for k in range(int(counts.max(initial=0))):
        y, carried = step(balls.rates, y, k * h, h, carried, h)
        here = counts == k + 1
        if here.any():
            found[:, here] = y[:, here]
            if carried is not None:
                kept[:, here] = carried[:, here]
    return found, None if carried is None else kept


def values(stage: Stage, columns: Columns, limits: Stepping = FINE) -> dict[str, Array]:
    """The quantities of a stage, from the values of earlier stages; flights as in `flown`."""
    columns = stage.with_spin(columns)
    with np.errstate(all="ignore"):
        if stage.kind == "flight":
            balls = launched(stage, columns)
            return balls.ended(flown(balls, balls.duration, limits))
        (root,) = stage.roots.values()
        shape = (3, len(columns["kind"])) if root.vector else (len(columns["kind"]),)
        return {stage.quantities[0]: np.broadcast_to(Evaluator([root], columns)()[0], shape)}


def _flown_once(
    stage: Stage, columns: Columns, data: Data, limits: Stepping
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The quantities of a flight by the candidate's integrator, and the same plus their error.

    No ball is flown twice: an edit of one stage changes few flights of the others, and samples of
    scenes overlap.
    """
    # The key of a ball: the formulas of its flight, and the numbers that they read.
    roots, way = (*stage.roots.values(),), data.way(stage)
    known = data.flights.setdefault((limits, way, stage.quantities), {})
    names = sorted({stage.spins, *names_in(roots), *(way.reads if way else ())} & columns.keys())
    given = [columns[name] for name in names if columns[name].dtype.kind == "f"]
    formulas = digests(roots, stage.with_spin(columns)).view(float)
    rows = [*map(np.atleast_2d, given), formulas]
    numbers = np.ascontiguousarray(np.concatenate(rows).T)
    balls = [hashlib.blake2b(row.tobytes(), digest_size=16).digest() for row in numbers]
    new = np.array([i for i, ball in enumerate(balls) if ball not in known], dtype=int)
    if new.size or not balls:
        some = stage.with_spin(take(columns, new))
        if way is not None:
            found, doubt = way(stage, some)
            again = {quantity: found[quantity] + doubt[quantity] for quantity in found}
        else:
            launch = launched(stage, some)
            y, share = _flown(launch, launch.duration, limits)
            found = launch.ended(y)
            again = launch.ended(y + share * np.maximum(np.abs(y), 1.0))
        for k, i in enumerate(new):
            known[balls[i]] = [x[q][..., k] for x in (found, again) for q in stage.quantities]
        if len(new) == len(balls):
            return found, again
    ends = [np.stack(column, axis=-1) for column in zip(*map(known.get, balls), strict=True)]
    count = len(stage.quantities)
    return (
        dict(zip(stage.quantities, ends[:count], strict=True)),
        dict(zip(stage.quantities, ends[count:], strict=True)),
    )


@dataclass(frozen=True)
class Followed:
    """The residuals of a stage, with their tolerance and noise.

    Attributes
    ----------
    stage
        The stage.
    some
        The scenes that have it.
    off
        Residuals: obtained minus predicted, shape (numbers, scenes); NaN where nothing is given.
        For an event, the event function at the candidate's own value, which should be 0.
    tolerance, floor
        A number is right if its residual is below the tolerance. A residual below the floor, the
        noise, needs no explanation.
    finest
        The floor if no error is granted: what a precise candidate leaves.
    scale
        Size to which errors are relative.

    Examples
    --------
    Three scenes, of which the second is wrong by more than the noise, and the third has no answer:

    >>> stage = next(one for one in CHAIN if one.name == "distance")
    >>> off = np.array([[1e-15, 0.02, np.nan]])
    >>> limit, size = np.full((1, 3), 1e-9), np.full((1, 3), 100.0)
    >>> f = Followed(stage, np.arange(3), off, limit, limit, limit, scale=size)
    >>> f.checked, f.beyond, f.relative
    (array([ True,  True, False]), array([False,  True, False]), array([1.e-17, 2.e-04, 0.e+00]))
    """

    stage: Stage
    some: Index
    off: Array
    tolerance: Array
    floor: Array
    finest: Array
    scale: Array

    def of(self, which: Index) -> Followed:
        """Some of the scenes, by their places in `some`."""
        every = self.off, self.tolerance, self.floor, self.finest, self.scale
        return Followed(self.stage, self.some[which], *(x[:, which] for x in every))

    @property
    def checked(self) -> NDArray[np.bool_]:
        """True for each scene in which the candidate gives a number of the stage."""
        return np.asarray(np.isfinite(self.off).any(axis=0))

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """True for each scene in which a number is wrong."""
        return np.asarray((np.abs(self.off) > self.tolerance).any(axis=0))

    @property
    def beyond(self) -> NDArray[np.bool_]:
        """True for each scene in which a number is wrong by more than the noise."""
        return np.asarray(self.wrong & (np.abs(self.off) > ADEQUATE * self.floor).any(axis=0))

    @property
    def relative(self) -> Array:
        """The largest relative error in each scene; 0 where nothing is given."""
        return np.asarray(np.nan_to_num(np.abs(self.off) / self.scale).max(axis=0, initial=0.0))


HUGE = 1e12  # SI units: a ball cannot have larger numbers; a free choice


@np.errstate(all="ignore")  # a wrong number may be of any size
def compared(
    stage: Stage, data: Data, columns: Columns, some: Index, limits: Stepping = FINE
) -> tuple[Followed, dict[str, Array]]:  # fmt: skip
    """The residuals of a stage in some scenes, and the values that the stage predicts.

    The integration method estimates the error of the judge's flights. If an edit has added a
    jump or a kink to the stage (`Data.rough`), the error of steps that cross it without detecting
    it is noise, too.
    """
    # Three predictions: `found`; `again`, which differs by the error of the judge's own flight; and
    # `careless`, by a program whose steps cross jumps.
    own, rough = take(columns, some), stage.name in data.rough
    if stage.kind == "flight":
        found, again = _flown_once(stage, own, data, limits)
    else:
        again = found = values(stage, own)
    careless = found
    if rough and stage.kind == "flight" and data.way(stage) is None:
        careless = _flown_once(stage, own, data, UNAWARE)[0]
    rows = []
    for quantity in stage.quantities:
        # The residual. A missing answer is no error. A prediction that is not finite is the largest
        # error.
        given = np.atleast_2d(data.given[quantity][..., some])
        predicted = np.atleast_2d(found[quantity])
        sizes = [np.sqrt(np.square(x).sum(0)) for x in (given, predicted)]
        large = np.fmax(np.fmax(*sizes) if stage.kind != "event" else sizes[0], 1.0)
        off = predicted if stage.kind == "event" else given - predicted
        off = np.where(np.isfinite(given).all(axis=0), off, np.nan)
        off = np.where(np.isfinite(given) & ~np.isfinite(off), HUGE, off)
        # Tolerance and noise (docs/truth.md, "Four times the noise").
        others = (np.atleast_2d(x[quantity]) for x in (again, careless))
        unsure = np.nan_to_num(np.max([np.abs(predicted - other) for other in others], axis=0))
        if rough and some.size:
            # Near a kink, two flights may agree by chance: use at least the 0.9 quantile.
            unsure = np.maximum(unsure, np.quantile(unsure, 0.9, axis=1, keepdims=True))
        absolute, relative = data.cut.get(quantity, (0.0, 0.0))
        short = absolute + relative * np.abs(given) if stage.kind != "event" else 0.0
        attained = SLACK * data.attainable[quantity][some]
        least = np.maximum(attained, data.granted) + short
        tolerance = np.maximum(least, ROUNDING * large) + 4 * unsure
        floor, finest = (np.maximum(x, NOISE * large) + unsure for x in (least, attained + short))
        row = off, tolerance, floor, finest, large
        rows.append([x + 0 * off for x in row])
    off, tolerance, floor, finest, scale = map(np.concatenate, zip(*rows, strict=True))
    off[:, np.isin(some, data.blind.get(stage.key, ()))] = np.nan
    if data.slips is not None:
        slipped = data.slips(stage, data, columns, some)
        tolerance, floor, finest = tolerance + 4 * slipped, floor + slipped, finest + slipped
    return Followed(stage, some, off, tolerance, floor, finest, scale), found


def mended(before: Followed, after: Followed) -> tuple[int, int]:
    """The number of wrong scenes that an edit makes right, and of right ones that it breaks."""
    wrong, left = before.beyond, after.beyond
    return int((wrong & ~left).sum()), int((left & ~wrong).sum())


def is_rough(stage: Stage) -> bool:
    """True if a stage has jumps or kinks, at which a few scenes may have errors."""
    roots = (root for name, root in stage.roots.items() if name != "through")
    return any(node.op in JUMPS | {"table"} for node in ordered(roots))


def specialised_to(data: Data, chain: Iterable[Stage] = CHAIN) -> tuple[Stage, ...]:
    """The chain of these scenes: their stages, without switches that are the same in all scenes.

    A switch of the law is removed only if it is the same in all flights: they share one law, which
    an edit changes in every flight.
    """
    # Keep stages for which a scene has a true value: without a fence, there is no stage `fence`.
    present = [
        stage
        for stage in chain
        if any(np.isfinite(data.expected[q][..., _at(stage, data)]).any() for q in stage.quantities)
    ]
    flights = [stage for stage in present if stage.kind == "flight"]
    found = []
    for stage in present:
        columns = {}
        for name in SWITCHES:
            alike = flights if stage.kind == "flight" else [stage]
            keys = ((s, s.spins if name == "spin" else name) for s in alike)
            columns[name] = np.concatenate([data.columns[key][_at(s, data)] for s, key in keys])
        known: dict[Node, Node] = {}
        roots = {name: specialised(root, columns, known) for name, root in stage.roots.items()}
        forms = {
            name: tuple(specialised(form, columns, known) for form in some)
            for name, some in stage.forms.items()
        }
        found.append(replace(stage, roots=roots, forms=forms))
    return tuple(found)


def _at(stage: Stage, data: Data) -> NDArray[np.bool_]:
    return np.isin(data.columns["kind"], stage.scenes)


def begun(data: Data) -> dict[str, Any]:
    """Columns before the first stage: inputs, and the candidate's values, or else true ones."""
    columns = dict(data.columns)
    for quantity, node in OWN.items():
        given = data.given[quantity]
        columns[node.data] = np.where(np.isfinite(given), given, data.expected[quantity])
    # The duration of a flight is `landing.hang_time`, or `landing.time` minus the time of the
    # contact (0 in a flight scene). If the two disagree, the one nearer to the truth is used.
    both = [columns[OWN[name].data] for name in ("landing.time", "contact.time")]
    hang, since = data.given["landing.hang_time"], both[0] - np.nan_to_num(both[1])
    true = data.expected["landing.hang_time"]
    nearer = np.abs(hang - true) <= np.abs(since - true)
    columns["hang_time"] = np.where(nearer | ~np.isfinite(since), hang, since)
    columns["landing.hang_time"] = np.where(np.isfinite(hang), hang, since)
    columns[str(ended.data)] = columns["hang_time"] + np.nan_to_num(both[1])
    columns["ω"] = np.where(columns["spin"] == "none", 0.0, columns["ω"])
    return columns


# Columns of what results do not report of a ball's flights, such as its velocity at the bat, by
# stage. They follow from the flights, and are unknown if one of these is wrong.
_UNREPORTED = {
    one.key: frozenset(
        str(OWN[quantity].data)
        for other in CHAIN if other.kind == "flight"
        and other.roots["velocity"] is one.roots["velocity"]
        for quantity in other.quantities if quantity not in QUANTITIES
    )
    for one in CHAIN if one.kind == "flight"
}  # fmt: skip
# The formulas of the collision need a unit vector. A program that divides by R + r_b does not get
# one if its ball is not on the bat's surface.
_NORMAL, NOT_ONE = frozenset((str(n.data),)), 1e-6  # a free choice


def seen(chain: Sequence[Stage], data: Data) -> Data:
    """Data with the scenes in which the right chain does not reproduce the truth (`Data.blind`)."""
    # These scenes have a law with jumps. Only those matter in which the candidate is wrong.
    jumps = np.zeros(len(data.cases), dtype=bool)
    for stage in chain:
        if stage.kind == "flight":
            jumps |= _jumping(stage, data.columns)
    if not jumps.any():
        return data
    _, found = follow(chain, data)
    # The judge's own flight may fail: its error is then larger than the ball's position.
    lost = {one.stage.key: one.some[(one.floor > one.scale)[:3].all(axis=0)] for one in found}
    wrong = np.unique(np.concatenate([one.some[one.wrong] for one in found]))
    wrong = wrong[jumps[wrong]]
    _, found = follow(chain, replace(data, given=data.expected, cut={}, slips=None), only=wrong)
    blind = {one.stage.key: np.union1d(lost[one.stage.key], one.some[one.wrong]) for one in found}
    return replace(data, blind=blind)


def _jumping(stage: Stage, columns: Columns) -> NDArray[np.bool_]:
    """True in scenes in which a law has a jump or a table."""
    columns = stage.with_spin(columns)
    found: dict[Node, NDArray[np.bool_]] = {}
    none = np.zeros(len(columns["kind"]), dtype=bool)
    for node in ordered([stage.roots["law"]]):
        inside = [found[arg] for arg in node.args]
        if node.op == "switch":
            key, options = node.data
            inside = [
                x & (columns[key] == option) for x, option in zip(inside, options, strict=True)
            ]
        jumps = node.op in JUMPS | {"table"} and depends(node.args[0], MOVING)
        found[node] = ~none if jumps else np.any([none, *inside], axis=0)
    return found[stage.roots["law"]]


def follow(
    chain: Iterable[Stage], data: Data, only: Index | None = None
) -> tuple[dict[str, Any], list[Followed]]:
    """Compute the residuals of all stages in order.

    Return the columns and the residuals. The columns have the candidate's values; where it gives
    none, those that follow from earlier stages. `only` restricts the scenes. Stages that need what
    a flight does not report are omitted where the flight is wrong, and those that need the normal
    where it is no unit vector.
    """
    columns = begun(data)
    found = []
    lost: dict[frozenset[str], Index] = dict.fromkeys(
        (*_UNREPORTED.values(), _NORMAL), np.zeros(0, dtype=int)
    )
    for stage in chain:
        some = np.flatnonzero(np.isin(columns["kind"], stage.scenes))
        if only is not None:
            some = np.intersect1d(some, only)
        for names, scenes in lost.items():
            if scenes.size and any(depends(root, names) for root in stage.roots.values()):
                some = np.setdiff1d(some, scenes)
        one, follows = compared(stage, data, columns, some)
        found.append(one)
        if (unknown := _UNREPORTED.get(stage.key)) is not None:
            lost[unknown] = np.union1d(lost[unknown], some[one.wrong])
        if stage.kind == "event":  # an event gives no value, only the distance from its surface
            continue
        for quantity, value in follows.items():
            name = OWN[quantity].data
            column = columns[name].copy()
            silent = ~np.isfinite(data.given[quantity][..., some]) & np.isfinite(value)
            column[..., some] = np.where(silent, value, column[..., some])
            columns[name] = column
        if stage.name == "normal":
            size = np.sqrt(np.square(columns[str(n.data)]).sum(axis=0))
            lost[_NORMAL] = np.flatnonzero(np.abs(size - 1.0) > NOT_ONE)
    return columns, found


def follows(chain: Iterable[Stage], data: Data) -> bool:
    """True if every stage follows from the candidate's earlier values, within the noise."""
    checked = (one for one in follow(chain, data)[1] if one.checked.any())
    return all(is_adequate(one.off / one.floor, is_rough(one.stage)) for one in checked)
