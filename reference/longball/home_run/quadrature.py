"""P(e) and dP/de by quadrature: no random numbers, and errors far below those of samples.

For given speed, offset and tilt the home runs are intervals of the aim, between an end of the bat
and roots of D = 150 m. D depends strongly on the aim, since the bat moves faster farther from its
pivot; the probability of the intervals is therefore smooth in the other three variables, except for
kinks where an interval opens or closes, or where a root of D = 150 m gives way to a jump of D, as
between a ball that just clears the ground and one that just does not. The range of offsets is cut
there; kinks that are not seen are dealt with by halving ranges. Where an interval opens between the
ends of the bat, its length is a square root of the offset, and smooth in the angle of which the
offset is the sine. Where the pattern of those ranges changes, the integral over them has a kink as
a function of the speed, whose range is cut there, too, where that matters. The density of the
speeds is two narrow peaks: over them the Gauss rule of that density takes a few nodes. Over the
tilts a Gauss-Legendre rule does.

Integrating the offset between its roots first, as `longball.home_run.randomised` does, leaves an
integrand with square-root endpoint singularities.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.engines.parallel import in_parallel
from longball.home_run.at_bats import AtBats, Mixture, Samples
from longball.home_run.clearance import Clearance
from longball.home_run.crossings import Crossings, crossings, narrowed, probability, sampled
from longball.model.arrays import Array, Flags, Integers
from longball.model.readings import SampleSpace
from longball.model.scene import AtBatScene

TOLERANCE = 1e-7

# A normal variable is farther from its mean, in standard deviations, with a probability of 1e-12:
# what lies beyond is left out, and what the last part of the bat's ends hits.
FARTHEST = 7.1
_END = 1e-8
_LEFT_OUT = 1e-10
# Samples of lines along a variable: none, one or two roots are found between two of them.
_AIMS, _SPEEDS = 13, 25
# Of the length of a line, and of e: steps for central differences of D. They are off by 1e-9 of the
# derivative by truncation, and by less through the engine's rounding.
_STEP = 1e-5
# The same for the place of a jump, of which 1e-13 is off.
_WIDER_STEP = 1e-4
_OFFSET_NODES = 12  # of a range of offsets, which is halved until that is enough
_HALVINGS = 20
# The distance of two nodes with a kink between them is divided by five, so many times: the errors
# that remain are as what is left of an offset to the power 3/2, of a speed to the power 5/2.
_OF_OFFSETS, _OF_SPEEDS = 8, 4
_STEEPER = 10.0  # how much larger than that of P the error of dP/de may be
# How much more than the tolerance two rules without cuts at kinks may differ: others follow them.
_KINKED = 100.0
# Nodes of a Gauss-Legendre rule on which a density is known to rounding, per standard deviation.
_FINE = 4.0
_PAIRS = 240  # of speed and tilt, that a thread takes at a time: fewer are mostly overhead


class Nodes(NamedTuple):
    """Nodes of two Gauss rules: of a range of speeds, whose density is the weight; of the tilts.

    `cut` tells whether the range of speeds is cut at kinks.
    """

    speed: int
    tilt: int
    cut: bool = False


# Kinks cost time, and most readings have none that matters.
LEVELS = (Nodes(4, 2), Nodes(6, 3), Nodes(8, 4), Nodes(6, 2, cut=True), Nodes(8, 3, cut=True))


@dataclass(frozen=True)
class Integral:
    """P(e) and its slope, with generous estimates of their errors.

    Each error is the difference of two rules, the coarser of which makes nearly all of it, and the
    weight of what the engine could not decide. NaN where the sample space is empty.
    """

    e: float  # the ball's coefficient of restitution
    # The probability of a home run.
    p: float
    error: float
    # dP/de.
    slope: float
    slope_error: float

    @property
    def low(self) -> float:
        """The least that P may be."""
        return self.p - self.error

    @property
    def high(self) -> float:
        """The most."""
        return self.p + self.error


class Share(NamedTuple):
    """Probabilities of what is counted and their derivatives by e, with their errors.

    Numbers, or arrays with an element for each pair of speed and tilt.
    """

    p: Array
    slope: Array
    error: Array
    slope_error: Array


def integrals(
    base: AtBatScene,
    at_bats: AtBats,
    restitutions: Sequence[float],
    *,
    sample_space: SampleSpace = "pitches",
    tolerance: float = TOLERANCE,
    workers: int = 1,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Integral]:
    """Return P(e) and dP/de at each restitution, by the batch engine.

    Rules are refined until two in a row agree so far as P is to be known, and dP/de ten times less
    well, or there is no finer one. `progress` is called with the number of restitutions done.
    """
    from longball.engines.batch import Batch  # slow to import, and not needed for --help

    found = []
    for done, e in enumerate(restitutions, 1):
        home_runs = Clearance(base, e, Batch(), sample_space)
        found.append(_refined(home_runs, at_bats, tolerance, workers))
        progress(done)
    return found


def _refined(home_runs: Clearance, at_bats: AtBats, tolerance: float, workers: int) -> Integral:
    """Return the share of the sample space that home runs have."""
    e = home_runs.restitution
    runs = _share(home_runs, at_bats, tolerance, workers)
    if home_runs.sample_space == "pitches":
        return Integral(e, *map(float, (runs.p, runs.error, runs.slope, runs.slope_error)))
    # An error of the sample space enters P as a part of P, which is small.
    loose = tolerance / max(float(runs.p), 1e-3)
    space = _share(replace(home_runs, counted="sample space"), at_bats, loose, workers)
    if space.p == 0.0:
        return Integral(e, *[math.nan] * 4)
    p = runs.p / space.p
    return Integral(
        e,
        float(p),
        float((runs.error + p * space.error) / space.p),
        float((runs.slope - p * space.slope) / space.p),
        float((runs.slope_error + p * space.slope_error) / space.p),
    )


def _share(clearance: Clearance, at_bats: AtBats, tolerance: float, workers: int) -> Share:
    """Refine the rules until two in a row agree about the probability of what is counted."""
    before = _over_speeds(clearance, at_bats, LEVELS[0], tolerance, workers)
    off = np.zeros(())
    for nodes in LEVELS[1:]:
        if not nodes.cut and off > _KINKED * tolerance:
            continue
        now = _over_speeds(clearance, at_bats, nodes, tolerance, workers)
        off, slope_off = abs(now.p - before.p), abs(now.slope - before.slope)
        # More nodes do not mend what is left open at each of them.
        if off <= tolerance + now.error and slope_off <= _STEEPER * tolerance + now.slope_error:
            break
        before = now
    return Share(
        now.p,
        now.slope,
        off + now.error + _LEFT_OUT,
        slope_off + now.slope_error + _STEEPER * _LEFT_OUT,
    )


# --- ranges ---------------------------------------------------------------------------------------


class _Ranges(NamedTuple):
    """Ranges of a variable, and the number of the line in the other variables that each is on."""

    line: Integers
    low: Array
    high: Array

    @classmethod
    def between(cls, line: Integers, edge: Array) -> _Ranges:
        """Return the ranges between neighbouring edges on a line."""
        order = np.lexsort((edge, line))
        line, edge = line[order], edge[order]
        first = np.flatnonzero((line[1:] == line[:-1]) & (edge[1:] > edge[:-1]))
        return cls(line[first], edge[first], edge[first + 1])

    def at(self, which: NDArray[Any]) -> _Ranges:
        """Return some of them."""
        return _Ranges(*(x[which] for x in self))

    def and_also(self, others: _Ranges) -> _Ranges:
        """Return these and others."""
        line, low, high = (np.concatenate(pair) for pair in zip(self, others, strict=True))
        return _Ranges(line, low, high)

    def cut(self, number: Integers, place: Array) -> _Ranges:
        """Return them cut at some places, each within the range of that number."""
        every = np.arange(len(self.line))
        numbers = np.concatenate([every, every, number])
        pieces = _Ranges.between(numbers, np.concatenate([self.low, self.high, place]))
        return pieces._replace(line=self.line[pieces.line])


class _Nodes(NamedTuple):
    """Nodes of rules over ranges: the range of each, the place, and the kind of what is there."""

    number: Integers
    place: Array
    kind: Integers


def _without_kinks(
    ranges: _Ranges, nodes: _Nodes, kind: Callable[[Array, Integers], Integers], times: int
) -> tuple[Flags, _Ranges]:
    """Find, between neighbouring nodes of different kinds, the first place where the kind changes.

    Returned is in which ranges there is none, and the pieces of the others.
    """
    changes = (nodes.number[1:] == nodes.number[:-1]) & (nodes.kind[1:] != nodes.kind[:-1])
    number, before = nodes.number[:-1][changes], nodes.kind[:-1][changes]
    low, high = nodes.place[:-1][changes], nodes.place[1:][changes]
    smooth = ~np.isin(np.arange(len(ranges.line)), number)

    def changed(places: Array) -> Any:
        return sampled(kind, places, ranges.line[number]) != before[:, None]

    low, high = narrowed(low, high, changed, times)
    numbers = (np.cumsum(~smooth) - 1)[number]
    return smooth, ranges.at(~smooth).cut(numbers, 0.5 * (low + high))


# --- speed and tilt -------------------------------------------------------------------------------


def _over_speeds(
    clearance: Clearance, at_bats: AtBats, nodes: Nodes, tolerance: float, workers: int
) -> Share:
    """Return the probability of what is counted among all pitches."""
    tilt, tilt_weight = _rule(0.0, at_bats.largest_tilt, nodes.tilt)
    tilt_weight = tilt_weight / at_bats.largest_tilt
    density = at_bats.speed.distribution.pdf
    narrowest = min(deviation for *_, deviation in at_bats.speed.parts)

    def rule(ranges: _Ranges) -> tuple[Array, Array, Integers]:
        """Return speeds, their weights and the ranges they are in."""
        fine = np.ceil(_FINE * (ranges.high - ranges.low) / narrowest).astype(int)
        each = zip(ranges.low, ranges.high, fine, strict=True)
        rules = [rule_of(density, *one, nodes.speed) for one in each]
        speed, weight = np.concatenate([np.zeros((2, 0)), *rules], axis=1)
        number = np.repeat(np.arange(len(rules)), nodes.speed)
        return speed, weight * tilt_weight[ranges.line[number]], number

    def in_blocks(function: Any, speed: Array, line: Integers, *others: Array) -> list[Any]:
        each = speed, tilt[line], *others
        calls = (
            (clearance, at_bats, *(x[first : first + _PAIRS] for x in each))
            for first in range(0, len(speed), _PAIRS)
        )
        return list(in_parallel(function, calls, workers, threads=True))

    def pattern(speed: Array, line: Integers) -> Integers:
        return np.concatenate(in_blocks(_patterns, speed, line))

    # the ranges of speeds, for each tilt a line
    low, high = _speeds(clearance, at_bats.speed)
    lines = np.repeat(np.arange(nodes.tilt), len(low))
    ranges = _Ranges(lines, np.tile(low, nodes.tilt), np.tile(high, nodes.tilt))
    speed, weight, number = rule(ranges)
    if nodes.cut:
        # A kink between speeds that hardly matter does not either.
        found = np.where(weight > tolerance, pattern(speed, ranges.line[number]), 0)
        smooth, pieces = _without_kinks(ranges, _Nodes(number, speed, found), pattern, _OF_SPEEDS)
        ranges = ranges.at(smooth).and_also(pieces)
        speed, weight, number = rule(ranges)
    # the integrals over offsets and aims at each pair
    # What counts little need not be known well.
    allowed = tolerance / np.clip(weight * len(weight), _LEFT_OUT, 1.0)
    shares = in_blocks(share_over_offsets, speed, ranges.line[number], allowed)
    return Share(*(np.concatenate(shares, axis=1) @ weight if shares else np.zeros(4)))


def _speeds(clearance: Clearance, law: Mixture) -> tuple[Array, Array]:
    """Return the ends of ranges of speeds, m/s; a pitch too slow to arrive is left out."""

    def arrives(speed: Array, line: Integers) -> Array:
        return np.where(clearance.window(speed) > 0.0, 1.0, -1.0)

    low, high = law.range(FARTHEST)
    # The printed columns of Table II draw negative speeds, too: such a ball is never pitched.
    grid = np.linspace(max(low, high / 1000), high, _SPEEDS)
    cuts = crossings(arrives, grid[None], sampled(arrives, grid[None])).place
    edges = np.array([grid[0], *cuts, grid[-1]])
    arriving = clearance.window(0.5 * (edges[1:] + edges[:-1])) > 0.0
    return edges[:-1][arriving], edges[1:][arriving]


def _rule(low: float, high: float, nodes: int) -> tuple[Array, Array]:
    """Return nodes and weights of the Gauss-Legendre rule over an interval."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    return 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * (high - low) * w


def rule_of(
    density: Callable[[Array], Array], low: float, high: float, fine: int, nodes: int
) -> tuple[Array, Array]:
    """Return nodes and weights of the Gauss rule of a density over an interval.

    Its orthogonal polynomials are found on a Gauss-Legendre rule with `fine` nodes (Stieltjes's
    procedure); the nodes are the eigenvalues of their Jacobi matrix (Golub and Welsch, Math. Comp.
    23, 1969).
    """
    x, width = _rule(low, high, max(fine, 4 * nodes))
    w = width * density(x)
    if not w.sum() > 0.0:
        return _rule(low, high, nodes)[0], np.zeros(nodes)
    before, p, off = np.zeros_like(x), np.ones_like(x), 0.0
    diagonal, beside = np.empty(nodes), np.empty(nodes)
    for k in range(nodes):
        p /= math.sqrt(w @ p**2)
        diagonal[k] = w @ (x * p**2)
        before, p = p, (x - diagonal[k]) * p - off * before
        beside[k] = off = math.sqrt(w @ p**2)
    places, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(beside[:-1], -1))
    return places, w.sum() * vectors[0] ** 2


# --- the offset -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Lines:
    """Lines along the offset, each for a pair of speed, m/s, and tilt, rad."""

    clearance: Clearance
    at_bats: AtBats
    speed: Array
    tilt: Array

    def intervals(self, offset: Array, line: Integers) -> _Intervals:
        """Return the intervals of aims that are counted."""
        inputs = Samples(self.speed[line], np.zeros_like(offset), offset, self.tilt[line])
        return _Intervals.found(self.clearance, inputs)

    def kinds(self, offset: Array, line: Integers) -> Integers:
        """Return of what kind they are."""
        return self.intervals(offset, line).kind

    def over(self, ranges: _Ranges) -> tuple[Array, _Nodes]:
        """Return integrals (3, range) of what `_Intervals.shares` returns, and the nodes."""
        offset, weight, number = _sine_rule(ranges)
        each = self.intervals(offset, ranges.line[number])
        shares = np.array(each.shares(self.at_bats.aim))
        shares *= weight * self.at_bats.offset.distribution.pdf(offset)
        sums = shares.reshape(len(shares), len(ranges.line), _OFFSET_NODES).sum(axis=2)
        return sums, _Nodes(number, offset, each.kind)


def share_over_offsets(
    clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array, tolerance: Array
) -> Share:
    """Return, for pairs of speed and tilt, the probability of what is counted.

    Ranges of offsets are halved until the rule over a range and those over its halves agree, to the
    tolerance of its pair.
    """
    # one rule over each range shows its kinks: cut there, and take the rule over the parts
    lines = _Lines(clearance, at_bats, speed, tilt)
    found = np.zeros((4, len(speed)))
    ranges = _ranges(clearance, at_bats, speed, tilt)
    whole, nodes = lines.over(ranges)
    smooth, pieces = _without_kinks(ranges, nodes, lines.kinds, _OF_OFFSETS)
    ranges = ranges.at(smooth).and_also(pieces)
    whole = np.concatenate([whole[:, smooth], lines.over(pieces)[0]], axis=1)
    # A range that is empty at every node is taken to be empty: it was cut where it opens.
    there = np.array(whole.any(axis=0))
    ranges, whole = ranges.at(there), whole[:, there]
    # halve what is not known well enough yet
    for halving in range(_HALVINGS):
        if len(ranges.line) == 0:
            break
        # in the arrays the lower halves of all ranges come first, then the upper ones
        middle = 0.5 * (ranges.low + ranges.high)
        halves = ranges._replace(high=middle).and_also(ranges._replace(low=middle))
        parts, _ = lines.over(halves)
        sums = parts[:, : len(middle)] + parts[:, len(middle) :]
        off, slope_off, _ = abs(sums - whole)
        allowed = tolerance[ranges.line]
        done = np.array((off <= allowed) & (slope_off <= _STEEPER * allowed))
        done |= halving == _HALVINGS - 1
        p, slope, doubt = sums
        values = np.array([p, slope, off + doubt, slope_off + _STEEPER * doubt])
        for total, each in zip(found, values, strict=True):
            np.add.at(total, ranges.line[done], each[done])
        again = np.tile(~done, 2)
        ranges, whole = halves.at(again), parts[:, again]
    return Share(*found)


def _sine_rule(ranges: _Ranges) -> tuple[Array, Array, Integers]:
    """Return nodes, their weights and the ranges they are in: of Gauss-Legendre rules of an angle.

    Over a range, the variable is the sine of the angle.
    """
    x, w = np.polynomial.legendre.leggauss(_OFFSET_NODES)
    half, angle = 0.5 * (ranges.high - ranges.low)[:, None], 0.5 * np.pi * x
    places = 0.5 * (ranges.low + ranges.high)[:, None] + half * np.sin(angle)
    weights = half * 0.5 * np.pi * np.cos(angle) * w
    return places.ravel(), weights.ravel(), np.repeat(np.arange(len(half)), _OFFSET_NODES)


def _patterns(clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array) -> Integers:
    """Return a number for each pair, which tells the kinds of intervals that follow each other."""
    ranges = _ranges(clearance, at_bats, speed, tilt)
    offset, _, number = _sine_rule(ranges)
    line = ranges.line[number]
    kind = _Lines(clearance, at_bats, speed, tilt).kinds(offset, line)
    order = np.lexsort((offset, line))
    line, number, kind = line[order], number[order], kind[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (number[1:] != number[:-1]) | (kind[1:] != kind[:-1])
    return np.array([hash(tuple(kind[new & (line == n)].tolist())) for n in range(len(speed))])


def _ranges(clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array) -> _Ranges:
    """Cut the offsets where the counted set begins or ends at an end of the bat, or amid it."""
    grid = clearance.offsets(speed, FARTHEST * at_bats.offset_deviation)
    pairs = np.arange(len(speed))
    lines, cuts = [pairs, pairs], [grid[:, 0], grid[:, -1]]
    for y in clearance.base.bat.length / 2 * (1.0 - _END) * np.array([-1.0, 0.0, 1.0]):

        def touching(offset: Array, pair: Integers, y: float = y) -> Array:
            inputs = Samples(speed[pair], np.zeros_like(offset), offset, tilt[pair])
            return clearance(replace(inputs, aim=clearance.aim_to_touch(y, inputs)))

        found = crossings(touching, grid, sampled(touching, grid))
        lines.append(found.line)
        cuts.append(found.place)
    return _Ranges.between(np.concatenate(lines), np.concatenate(cuts))


# --- the aim --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Intervals:
    """Intervals of aims that are counted, for given speeds, offsets and tilts: the lines."""

    # What is counted, and the lines.
    clearance: Clearance
    inputs: Samples
    # Aims, m, an array (line, sample), and clearances there, m.
    grid: Array
    values: Array
    ends: Crossings  # of the intervals, but for the ends of the bat
    unsolved: Flags  # whether the engine could not decide some at-bat of a line

    @classmethod
    def found(cls, clearance: Clearance, inputs: Samples) -> _Intervals:
        """Find them."""
        half = clearance.base.bat.length / 2 * (1.0 - _END)
        low, high = clearance.aim_to_touch(-half, inputs), clearance.aim_to_touch(half, inputs)
        grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _AIMS)
        every = np.repeat(np.arange(len(low)), _AIMS)
        flat, unsolved = clearance.with_unsolved(replace(inputs.chosen(every), aim=grid.ravel()))
        values = flat.reshape(grid.shape)
        ends = crossings(_along(clearance, inputs), grid, values)
        which = np.array(unsolved.reshape(grid.shape).any(axis=1))
        return cls(clearance, inputs, grid, values, ends, which)

    @property
    def kind(self) -> Integers:
        """A number a line, which tells how many ends there are, and how many of them are jumps.

        And whether the first end of the bat is in an interval.
        """
        kind = np.where(self.values[:, 0] >= 0.0, 1_000_000, 0)
        np.add.at(kind, self.ends.line, 1 + 1000 * self.ends.jumps)
        return kind

    def shares(self, law: Mixture) -> tuple[Array, Array, Array]:
        """Return the probability of the intervals of each line.

        And its derivative by e, and 1 where the engine could not decide some at-bat, 0 elsewhere.
        """
        ends = self.ends
        p = probability(law.distribution.cdf, self.grid, self.values, ends)
        slope = np.zeros_like(p)
        length = (self.grid[:, -1] - self.grid[:, 0])[ends.line]
        at_ends = replace(self.inputs.chosen(ends.line), aim=ends.place)
        moves = np.where(ends.jumps, 0.0, _moves(self.clearance, at_ends, _STEP * length))
        if ends.jumps.any():
            moves[ends.jumps] = self._moves_of_jumps(0.5 * length[ends.jumps] / (_AIMS - 1))
        rates = np.where(ends.rises, -1.0, 1.0) * law.distribution.pdf(ends.place) * moves
        np.add.at(slope, ends.line, rates)
        return p, slope, self.unsolved.astype(float)

    def _moves_of_jumps(self, far: Array) -> Array:
        """Return the derivatives of jumps' places by e, m; 0 for a move beyond `far` in a step."""
        which = self.ends.jumps
        lines, place = self.inputs.chosen(self.ends.line[which]), self.ends.place[which]
        grid = place[:, None] + far[:, None] * np.array([-1.0, 1.0])
        moved = []
        for sign in (1.0, -1.0):
            e = self.clearance.restitution + sign * _WIDER_STEP
            along = _along(replace(self.clearance, restitution=e), lines)
            found = crossings(along, grid, sampled(along, grid))
            at = place.copy()
            at[found.line] = found.place
            moved.append(at)
        return (moved[0] - moved[1]) / (2 * _WIDER_STEP)


def _along(clearance: Clearance, inputs: Samples) -> Callable[[Array, Integers], Array]:
    """Return the clearance as a function of aims on lines."""
    return lambda aim, line: clearance(replace(inputs.chosen(line), aim=aim))


def _moves(clearance: Clearance, roots: Samples, step: Array) -> Array:
    """Return the derivatives of roots' places along the aim by e: -(∂D/∂e)/(∂D/∂aim)."""
    e = clearance.restitution
    by_e = replace(clearance, restitution=e + _STEP)(roots)
    by_e -= replace(clearance, restitution=e - _STEP)(roots)
    by_aim = clearance(replace(roots, aim=roots.aim + step))
    by_aim -= clearance(replace(roots, aim=roots.aim - step))
    moves: Array = np.divide(-by_e / _STEP, by_aim / step, np.zeros_like(step), where=by_aim != 0.0)
    return moves
