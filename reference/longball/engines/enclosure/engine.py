"""The engine: steps with a proof."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import flint
from flint import arb, arb_poly

from longball.engines.enclosure import lemmas
from longball.engines.enclosure.balls import Balls
from longball.engines.enclosure.curve import EnclosedPiece
from longball.engines.enclosure.defect import Defect, leading
from longball.engines.enclosure.system import Structure, System
from longball.engines.engine import OutOfRange, TooLong
from longball.engines.event import Events
from longball.engines.path_engine import PathEngine
from longball.model.law import Law, State
from longball.model.trace import Node, variable

# Error of a step, in roundings of the speed: what the roundings of a hundred coefficients leave.
_TOLERANCE = 2.0**8  # a free choice

# Order of the series for each bit: ln 2 / 2, which makes the work of a flight least if that of a
# step is as the square of its order (Jorba & Zou, Experimental Mathematics 14 (2005) 99).
_ORDER_PER_BIT = 0.35

# A step that cannot be proven is tried again this much shorter: the error falls as the order's
# power of it, to a twentieth. After some trials a power of the other is bisected: each costs a
# hundredth of a step, and where forces are strong the first may be too long by 22 decades.
_SHORTER, _MUCH_SHORTER = 0.95, 0.8
_FEW_TRIALS, _MOST_POWER = 20, 1000  # a free choice

# Of a step: at its beginning the series is exact, and only uncertain parameters make a defect.
_INSTANT = 2.0**-20  # a free choice

# Most work of a flight: the sum over steps of order² times the rows of the law's recurrence. A
# flight of a minute has a hundred steps. With drag and lift (5 rows), the limit is 2,400 steps with
# 30 digits, or 470 with 90; these take about 3 and 10 ms each, in total less than ten seconds.
_MOST_WORK = 40_000_000  # a free choice

# The work of a flight is proportional to the cube of its digits: with these, an at-bat takes about
# ten seconds.
_MOST_DIGITS = 500

# Bounds need few digits, unlike the numbers that they bound.
_BITS_OF_BOUNDS = 64  # a free choice

# Additional working digits if digits are lost. A table of C_L that falls by 0.4 over 0.01 of S
# makes the force change quickly with the velocity; a flight through it lost 17 digits beyond the
# guard.
_MORE_DIGITS = (20, 60)

# A step is cut into as many parts, on each of which the law's derivative is bounded, as make errors
# grow by little on each: by as much as the state changes on a part, the bound is too large.
_PARTS = (1, 8, 32, 128)  # a free choice
_GROWTH_OF_A_PART = 1 / 64  # a free choice

# How often a tube is made wider, for errors that grow much in a step.
_TUBES = 4  # a free choice


@dataclass(frozen=True)
class Start:
    """The core at the start of a step: an exact state, and how far it is off at most (norm)."""

    state: tuple[arb, ...]
    error: arb


@dataclass(frozen=True)
class Motion:
    """Exact polynomials of the core from 0 to `length` s: off by ``early + late t`` (norm)."""

    polynomials: tuple[arb_poly, ...]
    length: arb
    early: arb
    late: arb


def _piece(system: System, motion: Motion, begin: arb, state: State) -> tuple[EnclosedPiece, Start]:
    """Return the piece that a motion makes from a state on, and the core at its end."""
    structure = system.structure
    # The core with its error, early + late t, in each component by its weight in the norm.
    families: dict[str, Any] = {}
    for name, weight, p in zip(
        structure.core.variables, structure.weights, motion.polynomials, strict=True
    ):
        error = arb_poly([arb(0, motion.early / weight), arb(0, motion.late / weight)])
        families[name] = p + error
    # The other variables are integrals of linear combinations of it: they inherit its bound.
    for name, (rest, terms) in structure.quadratures.items():
        rate = arb_poly([system.static[rest]])
        for c, x in terms:
            rate += system.static[c] * families[x.args[0]]
        families[name] = getattr(state, name) + rate.integral()
    # `begin` is a ball: the piece has to hold for all beginnings in it.
    length = (motion.length - 2 * begin.rad()).lower()
    core = start_of(
        [p(length) for p in motion.polynomials],
        motion.early + motion.late * length,
        structure.weights,
    )
    return EnclosedPiece(begin, length, type(state)(**families), state), core


def start_of(state: Sequence[arb], error: arb, weights: Sequence[float]) -> Start:
    """Return the start at a state whose balls' middles are off by an error."""
    off = lemmas.norm([x.rad() for x in state], weights)
    return Start(tuple(x.mid() for x in state), (error + off).upper())


def _speed(core: Start, structure: Structure) -> arb:
    """Bound the size of the variables that are zero at rest; 0 if there are none."""
    return sum((abs(core.state[n]) for n in structure.resting), arb(0))


def brought_to_rest(core: Start, structure: Structure, negligible: arb) -> Start:
    """Replace a velocity by rest with an error if it contains 0, or is negligible (m/s).

    A Taylor step cannot come closer to V = 0 than to a fraction, but the bound on the error holds
    there as well; and from rest there is another series (`longball.engines.series`).
    """
    speed = _speed(core, structure)
    if speed == 0 or not (speed <= negligible or speed <= core.error):
        return core
    still = tuple(arb(0) if n in structure.resting else x for n, x in enumerate(core.state))
    return Start(still, (core.error + speed).upper())


def proven(system: System, core: Start, left: arb, bits: int, has_floor: bool = False) -> Motion:
    """Take a step that keeps its error to a few roundings.

    It is shorter than what is `left` of the flight, s, or at least as long. It `has_floor` if
    parameters are so uncertain that no step, however short, is that good.
    """
    structure = system.structure
    order = _order(bits)
    # The midpoints of the coefficients are exact polynomials; their roundings are in the defect.
    series = _series(system, core, order)
    polynomials = {node: arb_poly([arb(c).mid() for c in row]) for node, row in series.items()}
    motion = tuple(polynomials[variable(name)] for name in structure.core.variables)
    defect = Defect(structure.core, system.static, polynomials)
    guarded = [defect.polynomial(node) for node in structure.guarded]
    longest = left.upper()
    with flint.ctx.workprec(_BITS_OF_BOUNDS):
        tolerance = _TOLERANCE * arb(2) ** -bits
        guess = arb(_guess(motion, guarded, structure.weights, order, tolerance))
        first = guess if guess < left else longest
        floor = arb(0)
        if has_floor:
            floor = 2 * lemmas.norm(defect.bounds(first * _INSTANT), structure.weights)
        h, missed = _length(motion, defect, structure.weights, first, tolerance, floor)
        return Motion(motion, h, *_error(system, motion, core.error, missed, h))


def _order(bits: int) -> int:
    return math.ceil(_ORDER_PER_BIT * bits)


def _length(
    motion: Sequence[arb_poly],
    defect: Defect,
    weights: Sequence[float],
    first: arb,  # the time to try first
    tolerance: arb,  # what the defect may do, relative to the state
    floor: arb,  # how large the defect may be besides
) -> tuple[arb, arb]:
    """Return a time, s, in which the defect does little, and the norm of the defect till then."""
    size = lemmas.norm([p[0] for p in motion], weights)
    change = lemmas.norm([p[1] for p in motion], weights)

    def little(h: arb) -> arb | None:
        missed = lemmas.norm(defect.bounds(h), weights)
        return missed if missed * h <= tolerance * (size + change * h) + floor * h else None

    h = first
    for _ in range(_FEW_TRIALS):
        if (missed := little(h)) is not None:
            return h, missed
        h = (h * _SHORTER).mid()

    def shorter(power: int) -> arb:
        return (h * arb(_MUCH_SHORTER) ** power).mid()

    power = bisect_left(range(_MOST_POWER), True, key=lambda n: little(shorter(n)) is not None)
    if (missed := little(shorter(power))) is not None:
        return shorter(power), missed
    raise OutOfRange(
        "no step can be proven: the forces are too strong; or the ball is all but at rest in the "
        "air, or its spin all but parallel to its velocity, so that lift or drag have a corner"
    )


def _series(system: System, core: Start, order: int) -> dict[Node, list[arb]]:
    """Return the Taylor coefficients; of a ball that stays at rest, only the first."""
    if not system.roots:
        return system.series(core.state, order, at_rest=False)
    # The first order, which costs little, shows whether anything moves. If nothing does, a speed
    # stays zero, and neither recurrence has a series for it.
    few = system.series(core.state, 1, at_rest=True)
    if any(few[root][0] == 0 and few[root][1] == 0 for root in system.roots):
        rates = (few[variable(name)][1] for name in system.structure.core.variables)
        if all(rate == 0 for rate in rates):
            return few
    at_rest = any(few[root][0] == 0 for root in system.roots)
    return system.series(core.state, order, at_rest)


def _error(
    system: System, motion: Sequence[arb_poly], error: arb, defect: arb, h: arb
) -> tuple[arb, arb]:
    """Apply `lemmas.error_bound`, with a tube that is wide enough for it."""
    # The bound holds as long as the solution is in the tube. It proves that it stays there if it is
    # less than the tube's radius, which is not zero even for a start and a series without error.
    tube = 4 * (error + defect * h) + arb(2) ** -1000  # a free choice
    for _ in range(_TUBES):
        early, late = lemmas.error_bound(error, defect, _growth(system, motion, tube, h))
        bound = early + late * h
        if bound < tube:
            return early, late
        tube = 2 * bound  # a free choice
    raise OutOfRange(
        "the bound on the velocity's error has grown as large as the speed, as it does under a "
        "strong lift in the long run; take more digits, or a lower time_limit"
    )


def _growth(system: System, motion: Sequence[arb_poly], tube: arb, h: arb) -> arb:
    """Bound how much an error grows from 0 to h, if it stays below `tube`."""
    # On each part of the step, f's derivative over all states that are in the tube at its times.
    weights = system.structure.weights
    around = [arb(0, tube / weight) for weight in weights]
    for parts in _PARTS:
        rates = []
        for part in range(parts):
            times = (h * part / parts).union(h * (part + 1) / parts)
            box = [p(times) + near for p, near in zip(motion, around, strict=True)]
            rate = lemmas.logarithmic_norm(system.jacobian(box), weights)
            rates.append((rate, h / parts))
        if all(rate * length <= _GROWTH_OF_A_PART for rate, length in rates):
            break
    return lemmas.growth(rates)


def _guess(
    motion: Sequence[arb_poly],
    guarded: Sequence[arb_poly],
    weights: Sequence[float],
    order: int,
    tolerance: arb,
) -> float:  # a free choice
    """Return the time, s, at which the series' last terms are small next to the state.

    But not the whole time in which a value that must not be zero would come to nothing.
    """
    times = []
    for p in guarded:
        first = leading(p)
        if first is not None and (falling := abs(p[first + 1])) > 0:
            times.append(abs(p[first]) / falling * (1 - arb(2) ** -10))
    first, size = next(
        ((n, size) for n in (0, 1) if (size := lemmas.norm([p[n] for p in motion], weights)) > 0),
        (0, arb(1)),
    )
    for n in (order - 1, order):
        term = lemmas.norm([p[n] for p in motion], weights)
        if n > first and term > 0:
            times.append(((tolerance * size / term).log() / (n - first)).exp())
    return min((float(time) for time in times), default=math.inf)


@dataclass(frozen=True)
class Enclosure(PathEngine):
    """Flights with proven bounds.

    Attributes
    ----------
    digits
        What a result is good to, relatively. A number's own radius tells what it is good to.
    """

    digits: int = 30

    flight_error = 0.0  # balls carry their own

    def __post_init__(self) -> None:
        if not 1 <= self.digits <= _MOST_DIGITS:
            raise ValueError(f"digits = {self.digits} is not between 1 and {_MOST_DIGITS}")

    def finer(self) -> Iterator[Enclosure]:
        """Yield the same engine with more digits, and with still more; see `digits.to_digits`."""
        for more in _MORE_DIGITS:
            if self.digits + more <= _MOST_DIGITS:
                yield Enclosure(self.digits + more)

    @property
    def numbers(self) -> Balls:
        """Balls of as many digits."""
        return Balls(self.digits)

    @property
    def description(self) -> str:
        """Name and digits."""
        return f"enclosure digits={self.digits}"

    def steps(
        self, law: Law, start: State, begin: arb, limit: arb, events: Events
    ) -> Iterator[EnclosedPiece]:
        """Yield the pieces of a flight; see `PathEngine.steps`."""
        balls = self.numbers
        with balls.arithmetic():
            system = System(law, balls)
            structure = system.structure
            state = [getattr(start, name) for name in structure.core.variables]
            core = start_of(state, arb(0), structure.weights)
            # A parameter may be off by more than roundings, as the spin after an impact is.
            parameters = [x for node, x in system.static.items() if node.kind == "parameter"]
            rounded = arb(2) ** -balls.bits
            has_floor = any(x.rad() > abs(x.mid()) * rounded * _TOLERANCE for x in parameters)
            # What a rounding of the launch's speed is, is no speed.
            negligible = _speed(core, structure) * rounded
        most = _MOST_WORK // (len(system.rows) * _order(balls.bits) ** 2)
        for _ in range(most):
            with balls.arithmetic():
                core = brought_to_rest(core, structure, negligible)
                motion = proven(system, core, limit - begin, balls.bits, has_floor)
                piece, core = _piece(system, motion, begin, start)
                begin, start = begin + piece.length, piece.at(piece.length)
            yield piece
            if not begin < limit:
                return
        raise TooLong(
            f"the flight takes more than {most} steps; the first {float(begin):.3g} s of it "
            "can be had by a lower time_limit"
        )
