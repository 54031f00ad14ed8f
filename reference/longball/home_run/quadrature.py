"""P(e) and dP/de by quadrature: no random numbers, and errors far below those of samples.

For given speed, offset and tilt, the home runs are intervals of the aim between an end of the bat
and roots of D = 150 m. D depends strongly on the aim, because the bat moves faster farther from its
pivot. The probability of the intervals is therefore smooth in the other three variables, except for
kinks: an interval opens or closes, or a root of D = 150 m becomes a jump of D, as between a ball
that just clears the ground and one that just does not. The range of offsets is cut at kinks, and
halved where one remains. An interval that opens between the ends of the bat has a length that is a
square root of the offset; the length is a smooth function of the angle whose sine is the offset. If
the pattern of these ranges changes, the integral over the offsets has a kink as a function of the
speed, and the range of speeds is cut there if that matters. The density of the speeds has two
narrow peaks, for which the Gauss rule of that density needs few nodes. A Gauss-Legendre rule
integrates over the tilts.

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

# A hundredth of the noise of a million samples.
TOLERANCE = 1e-7

# Beyond 7.1 standard deviations a normal variable has a probability of 1e-12. These tails are
# omitted, and so are the contacts on the last 1e-8 of the bat's ends; `_LEFT_OUT` bounds both.
FARTHEST = 7.1
_END = 1e-8
_LEFT_OUT = 1e-10
# Samples on a line along a variable; up to two roots are found between neighbours.
_AIMS, _SPEEDS = 13, 25  # free choices
# Steps for central differences of D, relative to the length of a line, and of e. Truncation causes
# a relative error of 1e-9, the engine's rounding a smaller one.
_STEP = 1e-5
# The same for the position of a jump, which is known to 1e-13 only.
_WIDER_STEP = 1e-4
_OFFSET_NODES = 12  # of a range of offsets, which is halved until they are enough
_HALVINGS = 20
# Divisions by five of the distance between two nodes with a kink between them. The remaining error
# is that distance to the power 3/2 for offsets, 5/2 for speeds.
_OF_OFFSETS, _OF_SPEEDS = 8, 4
# dP/de is a difference of densities: its error may be this many times that of P.
_STEEPER = 10.0
# If two rules without cuts at kinks differ by more than this many tolerances, kinks matter, and the
# other rules without cuts are skipped.
_KINKED = 100.0  # a free choice
# Nodes per standard deviation of a Gauss-Legendre rule that integrates a normal density to
# rounding.
_FINE = 4.0
_PAIRS = 240  # pairs of speed and tilt of one task; smaller tasks are mostly overhead


class Nodes(NamedTuple):
    """Numbers of nodes of two Gauss rules, over a range of speeds and over the tilts.

    `cut` is True if the range of speeds is cut at kinks.
    """

    speed: int
    tilt: int
    cut: bool = False


# Rules from coarse to fine. Those with cuts are last: searching kinks costs time, and under most
# readings no kink matters.
LEVELS = (Nodes(4, 2), Nodes(6, 3), Nodes(8, 4), Nodes(6, 2, cut=True), Nodes(8, 3, cut=True))


@dataclass(frozen=True)
class Integral:
    """P(e) and its slope, with generous estimates of their errors.

    Each error is the difference of two rules, almost all of which is that of the coarser one, and
    the weight of the undecided at-bats. All are NaN if the sample space is empty.
    """

    e: float  # the ball's coefficient of restitution
    # P(e), the probability of a home run.
    p: float
    error: float
    # dP/de.
    slope: float
    slope_error: float

    @property
    def low(self) -> float:
        """Lower end of the range of P."""
        return self.p - self.error

    @property
    def high(self) -> float:
        """Upper end of the range of P."""
        return self.p + self.error


class Share(NamedTuple):
    """Probability of the counted at-bats and its derivative by e, with their errors.

    The fields are numbers, or arrays with an element for each pair of speed and tilt.
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

    Rules are refined until two in a row agree to the tolerance (dP/de: ten times the tolerance), or
    there is no finer one. `progress` is called with the number of restitutions done.
    """
    from longball.engines.batch import Batch  # slow to import, and not needed for --help

    rows = []
    for done, e in enumerate(restitutions, 1):
        home_runs = Clearance(base, e, Batch(), sample_space)
        rows.append(_refined(home_runs, at_bats, tolerance, workers))
        progress(done)
    return rows


def _refined(home_runs: Clearance, at_bats: AtBats, tolerance: float, workers: int) -> Integral:
    """Return the probability of a home run within the sample space."""
    e = home_runs.restitution
    runs = _share(home_runs, at_bats, tolerance, workers)
    if home_runs.sample_space == "pitches":
        return Integral(e, *map(float, (runs.p, runs.error, runs.slope, runs.slope_error)))
    # P is a quotient: a relative error of the sample space is the same relative error of the small
    # P, so the sample space needs fewer digits.
    loose = tolerance / max(float(runs.p), 1e-3)
    space = _share(replace(home_runs, counted="sample space"), at_bats, loose, workers)
    if space.p == 0.0:
        return Integral(e, *[math.nan] * 4)
    # The quotient's error and derivative, to first order.
    p = runs.p / space.p
    return Integral(
        e,
        float(p),
        float((runs.error + p * space.error) / space.p),
        float((runs.slope - p * space.slope) / space.p),
        float((runs.slope_error + p * space.slope_error) / space.p),
    )


def _share(clearance: Clearance, at_bats: AtBats, tolerance: float, workers: int) -> Share:
    """Refine the rules until two in a row agree on the probability of the counted at-bats."""
    before = _over_speeds(clearance, at_bats, LEVELS[0], tolerance, workers)
    off = np.zeros(())
    for nodes in LEVELS[1:]:
        if not nodes.cut and off > _KINKED * tolerance:
            continue
        now = _over_speeds(clearance, at_bats, nodes, tolerance, workers)
        off, slope_off = abs(now.p - before.p), abs(now.slope - before.slope)
        # More nodes do not reduce the errors at the single nodes.
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
    """Ranges of a variable, and the number of the line (the other variables) of each."""

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
        """Return some of the ranges."""
        return _Ranges(*(x[which] for x in self))

    def and_also(self, others: _Ranges) -> _Ranges:
        """Return these ranges and others."""
        line, low, high = (np.concatenate(pair) for pair in zip(self, others, strict=True))
        return _Ranges(line, low, high)


class _Nodes(NamedTuple):
    """Nodes of rules over ranges: the range of each, the place, and the kind of what is there."""

    number: Integers
    place: Array
    kind: Integers


def _without_kinks(
    ranges: _Ranges, nodes: _Nodes, kind: Callable[[Array, Integers], Integers], times: int
) -> tuple[Flags, _Ranges]:
    """Cut ranges where the kind changes between two nodes, at the first such place.

    Return flags of the ranges without a change, and the pieces of the others.
    """
    changes = (nodes.number[1:] == nodes.number[:-1]) & (nodes.kind[1:] != nodes.kind[:-1])
    number, before = nodes.number[:-1][changes], nodes.kind[:-1][changes]
    low, high = nodes.place[:-1][changes], nodes.place[1:][changes]

    def changed(places: Array) -> Any:
        return sampled(kind, places, ranges.line[number]) != before[:, None]

    low, high = narrowed(low, high, changed, times)
    whole = np.unique(number)
    edges = np.concatenate([ranges.low[whole], ranges.high[whole], 0.5 * (low + high)])
    pieces = _Ranges.between(np.concatenate([whole, whole, number]), edges)
    smooth = ~np.isin(np.arange(len(ranges.line)), number)
    return smooth, pieces._replace(line=ranges.line[pieces.line])


# --- speed and tilt -------------------------------------------------------------------------------


def _over_speeds(
    clearance: Clearance, at_bats: AtBats, nodes: Nodes, tolerance: float, workers: int
) -> Share:
    """Return the probability of the counted at-bats among all pitches."""
    tilt, tilt_weight = _rule(0.0, at_bats.largest_tilt, nodes.tilt)
    tilt_weight = tilt_weight / at_bats.largest_tilt
    density = at_bats.speed.distribution.pdf
    narrowest = min(deviation for *_, deviation in at_bats.speed.parts)

    def rule(ranges: _Ranges) -> tuple[Array, Array, Integers]:
        """Return speeds, their weights and the numbers of their ranges."""
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
        # Kinks between speeds of negligible weight are ignored.
        heights = np.where(weight > tolerance, pattern(speed, ranges.line[number]), 0)
        smooth, pieces = _without_kinks(ranges, _Nodes(number, speed, heights), pattern, _OF_SPEEDS)
        ranges = ranges.at(smooth).and_also(pieces)
        speed, weight, number = rule(ranges)
    # The integrals over offsets and aims at each pair. A pair of small weight needs fewer digits.
    allowed = tolerance / np.clip(weight * len(weight), _LEFT_OUT, 1.0)
    shares = in_blocks(share_over_offsets, speed, ranges.line[number], allowed)
    return Share(*(np.concatenate(shares, axis=1) @ weight if shares else np.zeros(4)))


def _speeds(clearance: Clearance, law: Mixture) -> tuple[Array, Array]:
    """Return the ends of the ranges of speeds, m/s, at which a pitch reaches the plate."""

    def arrives(speed: Array, line: Integers) -> Array:
        return np.where(clearance.window(speed) > 0.0, 1.0, -1.0)

    low, high = law.range(FARTHEST)
    # With the printed columns of Table II some speeds are negative: no pitch.
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

    A Gauss-Legendre rule with `fine` nodes gives its orthogonal polynomials (Stieltjes's
    procedure). The nodes are the eigenvalues of their Jacobi matrix (Golub and Welsch, Math. Comp.
    23, 1969).
    """
    x, width = _rule(low, high, max(fine, 4 * nodes))
    w = width * density(x)
    if not w.sum() > 0.0:
        return _rule(low, high, nodes)[0], np.zeros(nodes)
    # three-term recurrence of the orthonormal polynomials
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
        """Return the counted intervals of aims."""
        inputs = Samples(self.speed[line], np.zeros_like(offset), offset, self.tilt[line])
        return _Intervals.of(self.clearance, inputs)

    def kinds(self, offset: Array, line: Integers) -> Integers:
        """Return the kinds of the intervals."""
        return self.intervals(offset, line).kind

    def over(self, ranges: _Ranges) -> tuple[Array, _Nodes]:
        """Return the integrals of `_Intervals.shares`, shape (3, range), and the nodes."""
        offset, weight, number = _sine_rule(ranges)
        each = self.intervals(offset, ranges.line[number])
        shares = np.array(each.shares(self.at_bats.aim))
        shares *= weight * self.at_bats.offset.distribution.pdf(offset)
        sums = shares.reshape(len(shares), len(ranges.line), _OFFSET_NODES).sum(axis=2)
        return sums, _Nodes(number, offset, each.kind)


def share_over_offsets(
    clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array, tolerance: Array
) -> Share:
    """Return the probability of the counted at-bats for pairs of speed and tilt.

    Ranges of offsets are halved until the rule over a range and those over its halves agree to the
    tolerance of the pair.
    """
    # The kinds at the nodes of one rule over each range show kinks: cut there, and use the rule
    # over the parts.
    lines = _Lines(clearance, at_bats, speed, tilt)
    totals = np.zeros((4, len(speed)))
    ranges = _ranges(clearance, at_bats, speed, tilt)
    whole, nodes = lines.over(ranges)
    smooth, pieces = _without_kinks(ranges, nodes, lines.kinds, _OF_OFFSETS)
    ranges = ranges.at(smooth).and_also(pieces)
    whole = np.concatenate([whole[:, smooth], lines.over(pieces)[0]], axis=1)
    # A range without an interval at any node is empty, because ranges are cut where intervals open.
    there = np.array(whole.any(axis=0))
    ranges, whole = ranges.at(there), whole[:, there]
    # halve the ranges that are not accurate enough
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
        for total, each in zip(totals, values, strict=True):
            np.add.at(total, ranges.line[done], each[done])
        again = np.tile(~done, 2)
        ranges, whole = halves.at(again), parts[:, again]
    return Share(*totals)


def _sine_rule(ranges: _Ranges) -> tuple[Array, Array, Integers]:
    """Return nodes, weights and range numbers of Gauss-Legendre rules over an angle.

    The position within a range is the sine of the angle.
    """
    x, w = np.polynomial.legendre.leggauss(_OFFSET_NODES)
    half, angle = 0.5 * (ranges.high - ranges.low)[:, None], 0.5 * np.pi * x
    places = 0.5 * (ranges.low + ranges.high)[:, None] + half * np.sin(angle)
    weights = half * 0.5 * np.pi * np.cos(angle) * w
    return places.ravel(), weights.ravel(), np.repeat(np.arange(len(half)), _OFFSET_NODES)


def _patterns(clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array) -> Integers:
    """Return a number for each pair that identifies the sequence of kinds along the offset."""
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
    """Cut the offsets where counted aims begin or end at an end of the bat, or at its middle."""
    grid = clearance.offsets(speed, FARTHEST * at_bats.offset_deviation)
    pairs = np.arange(len(speed))
    lines, cuts = [pairs, pairs], [grid[:, 0], grid[:, -1]]
    for y in clearance.base.bat.length / 2 * (1.0 - _END) * np.array([-1.0, 0.0, 1.0]):

        def touching(offset: Array, pair: Integers, y: float = y) -> Array:
            inputs = Samples(speed[pair], np.zeros_like(offset), offset, tilt[pair])
            return clearance(replace(inputs, aim=clearance.aim_to_touch(y, inputs)))

        edges = crossings(touching, grid, sampled(touching, grid))
        lines.append(edges.line)
        cuts.append(edges.place)
    return _Ranges.between(np.concatenate(lines), np.concatenate(cuts))


# --- the aim --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Intervals:
    """Counted intervals of aims; a line is a set of speed, offset and tilt."""

    clearance: Clearance
    inputs: Samples
    # Aims, m, an array (line, sample), and their clearances, m.
    grid: Array
    values: Array
    ends: Crossings  # of the intervals, without the ends of the bat
    unsolved: Flags  # True for a line with an undecided at-bat

    @classmethod
    def of(cls, clearance: Clearance, inputs: Samples) -> _Intervals:
        """Locate the ends of the intervals, in the order of the aim."""
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
        """One number for each line: ends, jumps among them, and a flag.

        The flag is set if the first end of the bat is in an interval.
        """
        kind = np.where(self.values[:, 0] >= 0.0, 1_000_000, 0)
        np.add.at(kind, self.ends.line, 1 + 1000 * self.ends.jumps)
        return kind

    def shares(self, law: Mixture) -> tuple[Array, Array, Array]:
        """Return the probability of the intervals of each line, its derivative by e, and a doubt.

        The doubt is 1 on a line with an undecided at-bat, and 0 elsewhere.
        """
        ends = self.ends
        p = probability(law.distribution.cdf, self.grid, self.values, ends)
        slope = np.zeros_like(p)
        # An end at the aim y moves by dy/de and changes the probability by the density times dy.
        length = (self.grid[:, -1] - self.grid[:, 0])[ends.line]
        at_ends = replace(self.inputs.chosen(ends.line), aim=ends.place)
        moves = np.where(ends.jumps, 0.0, _moves(self.clearance, at_ends, _STEP * length))
        if ends.jumps.any():
            moves[ends.jumps] = self._moves_of_jumps(0.5 * length[ends.jumps] / (_AIMS - 1))
        rates = np.where(ends.rises, -1.0, 1.0) * law.distribution.pdf(ends.place) * moves
        np.add.at(slope, ends.line, rates)
        return p, slope, self.unsolved.astype(float)

    def _moves_of_jumps(self, far: Array) -> Array:
        """Return the derivatives of the positions of jumps by e, m; 0 if one moves beyond `far`."""
        which = self.ends.jumps
        lines, place = self.inputs.chosen(self.ends.line[which]), self.ends.place[which]
        grid = place[:, None] + far[:, None] * np.array([-1.0, 1.0])
        moved = []
        for sign in (1.0, -1.0):
            e = self.clearance.restitution + sign * _WIDER_STEP
            along = _along(replace(self.clearance, restitution=e), lines)
            jumps = crossings(along, grid, sampled(along, grid))
            at = place.copy()
            at[jumps.line] = jumps.place
            moved.append(at)
        return (moved[0] - moved[1]) / (2 * _WIDER_STEP)


def _along(clearance: Clearance, inputs: Samples) -> Callable[[Array, Integers], Array]:
    """Return the clearance as a function of aims on lines."""
    return lambda aim, line: clearance(replace(inputs.chosen(line), aim=aim))


def _moves(clearance: Clearance, roots: Samples, step: Array) -> Array:
    """Return the derivatives of roots along the aim by e, m: -(∂D/∂e)/(∂D/∂aim)."""
    e = clearance.restitution
    by_e = replace(clearance, restitution=e + _STEP)(roots)
    by_e -= replace(clearance, restitution=e - _STEP)(roots)
    by_aim = clearance(replace(roots, aim=roots.aim + step))
    by_aim -= clearance(replace(roots, aim=roots.aim - step))
    moves: Array = np.divide(-by_e / _STEP, by_aim / step, np.zeros_like(step), where=by_aim != 0.0)
    return moves
