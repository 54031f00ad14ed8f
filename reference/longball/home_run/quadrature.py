"""P(e) and dP/de by quadrature: no random numbers, and errors that no sample reaches.

For given speed, offset and tilt the home runs are intervals of the aim, between an end of the bat
and roots of D = 150 m. D depends strongly on the aim, since the bat moves faster farther from its
pivot; the probability of the intervals is therefore smooth in the other three variables, except for
kinks where an interval opens at an end of the bat. The range of offsets is cut there; remaining
kinks are found by halving ranges. Over speed and tilt Gauss-Legendre rules then converge
exponentially.

Integrating the offset between its roots first, as `longball.home_run.randomised` does, leaves an
integrand with square-root endpoint singularities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longball.engines.parallel import in_parallel
from longball.home_run.at_bats import AtBats, Mixture, Samples
from longball.home_run.clearance import Clearance
from longball.home_run.crossings import Places, crossings, probability, sampled
from longball.model.readings import SampleSpace
from longball.model.scene import AtBatScene

if TYPE_CHECKING:
    pass

Array = NDArray[np.float64]

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
_OFFSET_NODES = 10  # of a range of offsets, which is halved until that is enough
_HALVINGS = 20
_STEEPER = 10.0  # how much larger than that of P the error of dP/de may be
_PAIRS = 24  # of speed and tilt, that a thread takes at a time: some tenths of a second


class Nodes(NamedTuple):
    """Nodes of the Gauss-Legendre rules for each part of the speed, and for the tilt."""

    speed: int
    tilt: int


LEVELS = (Nodes(20, 2), Nodes(28, 3), Nodes(40, 4), Nodes(56, 6))


@dataclass(frozen=True)
class Integral:
    """P(e) and its slope, with generous estimates of their errors.

    Each error is the difference of two rules, the coarser of which makes nearly all of it, and the
    weight of what the engine could not decide. NaN where the sample space is empty.

    Attributes
    ----------
    e
        The ball's coefficient of restitution.
    p, error
        The probability of a home run.
    slope, slope_error
        dP/de.
    """

    e: float
    p: float
    error: float
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

    Parameters
    ----------
    base
        Everything about the at-bats that is not random, its reading included.
    at_bats
        The distributions of what is.
    restitutions
        Values of e.
    sample_space
        Of which the home runs are a share.
    tolerance
        Error of P that is asked for; ten times as much of dP/de. The rules are refined until two in
        a row agree so far, or there is no finer one.
    workers
        Threads; -1 for one per core. The answer does not depend on them, to the last bit.
    progress
        Called with the number of restitutions done.
    """
    from longball.engines.batch import Batch  # slow to import, and not needed for --help

    found = []
    for done, e in enumerate(restitutions, 1):
        home_runs = Clearance(base, e, Batch(), sample_space)
        found.append(_refined(home_runs, at_bats, tolerance, workers))
        progress(done)
    return found


def _refined(home_runs: Clearance, at_bats: AtBats, tolerance: float, workers: int) -> Integral:
    """Refine the rules until two in a row agree."""
    before = _probability(home_runs, at_bats, LEVELS[0], tolerance, workers)
    for nodes in LEVELS[1:]:
        now = _probability(home_runs, at_bats, nodes, tolerance, workers)
        error = abs(now.p - before.p) + now.error + _LEFT_OUT
        slope_error = abs(now.slope - before.slope) + now.slope_error + _STEEPER * _LEFT_OUT
        if error <= tolerance and slope_error <= _STEEPER * tolerance:
            break
        before = now
    e = home_runs.restitution
    return Integral(e, float(now.p), float(error), float(now.slope), float(slope_error))


def _probability(
    home_runs: Clearance, at_bats: AtBats, nodes: Nodes, tolerance: float, workers: int
) -> Share:
    """Return the share of the sample space that home runs have."""
    runs = _share(home_runs, at_bats, nodes, tolerance, workers)
    if home_runs.sample_space == "pitches":
        return runs
    # An error of the sample space enters P as a part of P, which is small.
    loose = tolerance / max(float(runs.p), 1e-3)
    space = _share(replace(home_runs, counted="sample space"), at_bats, nodes, loose, workers)
    if space.p == 0.0:
        return Share(*np.full(4, np.nan))
    p = runs.p / space.p
    return Share(
        p,
        (runs.slope - p * space.slope) / space.p,
        (runs.error + p * space.error) / space.p,
        (runs.slope_error + p * space.slope_error) / space.p,
    )


# --- speed and tilt -------------------------------------------------------------------------------


def _share(
    clearance: Clearance, at_bats: AtBats, nodes: Nodes, tolerance: float, workers: int
) -> Share:
    """Return the probability of what is counted among all pitches."""
    speed, speed_weight = _speeds(clearance, at_bats.speed, nodes.speed)
    tilt, tilt_weight = _rule(0.0, at_bats.largest_tilt, nodes.tilt)
    tilt_weight = tilt_weight / at_bats.largest_tilt
    speeds, tilts = (x.ravel() for x in np.meshgrid(speed, tilt, indexing="ij"))
    weights = np.outer(speed_weight, tilt_weight).ravel()
    blocks = [slice(first, first + _PAIRS) for first in range(0, len(speeds), _PAIRS)]
    calls = ((clearance, at_bats, speeds[some], tilts[some], tolerance) for some in blocks)
    shares = in_parallel(share_over_offsets, calls, workers, threads=True)
    parts = zip(blocks, shares, strict=True)
    return Share(*sum((np.array(share) @ weights[some] for some, share in parts), np.zeros(4)))


def _speeds(clearance: Clearance, law: Mixture, nodes: int) -> tuple[Array, Array]:
    """Return speeds, m/s, and their weights; a pitch too slow to arrive is left out."""

    def arrives(speed: Array, line: Places) -> Array:
        return np.where(clearance.window(speed) > 0.0, 1.0, -1.0)

    speeds, weights = [], []
    for weight, mean, deviation in law.parts:
        normal = Mixture(1.0, (mean, mean), (deviation, deviation)).distribution
        high = mean + FARTHEST * deviation
        # The printed columns of Table II draw negative speeds, too: such a ball is never pitched.
        grid = np.linspace(max(mean - FARTHEST * deviation, high / 1000), high, _SPEEDS)
        cuts = crossings(arrives, grid[None], sampled(arrives, grid[None])).place
        edges = np.array([grid[0], *cuts, grid[-1]])
        for low, high in pairwise(edges):
            if clearance.window(np.array([0.5 * (low + high)]))[0] > 0.0:
                speed, width = _rule(low, high, nodes)
                speeds.append(speed)
                weights.append(weight * width * normal.pdf(speed))
    return np.concatenate([*speeds, []]), np.concatenate([*weights, []])


def _rule(low: float, high: float, nodes: int) -> tuple[Array, Array]:
    """Return nodes and weights of the Gauss-Legendre rule over an interval."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    return 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * (high - low) * w


# --- the offset -----------------------------------------------------------------------------------


class _Ranges(NamedTuple):
    """Ranges of offsets, m, and the pair of speed and tilt that each belongs to."""

    pair: Places
    low: Array
    high: Array

    def at(self, some: NDArray[np.bool_]) -> _Ranges:
        """Return some of them."""
        return _Ranges(self.pair[some], self.low[some], self.high[some])


def share_over_offsets(
    clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array, tolerance: float
) -> Share:
    """Return, for pairs of speed and tilt, the probability of what is counted.

    Ranges of offsets are halved until the rule over a range and those over its halves agree.
    """
    ranges = _ranges(clearance, at_bats, speed, tilt)
    p, slope, error, slope_error = np.zeros((4, len(speed)))
    whole = _over_ranges(clearance, at_bats, speed, tilt, ranges)
    # A range that is empty at every node is taken to be empty: it was cut where it opens.
    there = np.array(whole.any(axis=0))
    ranges, whole = ranges.at(there), whole[:, there]
    for halving in range(_HALVINGS):
        if len(ranges.pair) == 0:
            break
        middle = 0.5 * (ranges.low + ranges.high)
        halves = _Ranges(
            np.tile(ranges.pair, 2),
            np.concatenate([ranges.low, middle]),
            np.concatenate([middle, ranges.high]),
        )
        parts = _over_ranges(clearance, at_bats, speed, tilt, halves)
        sums = parts[:, : len(middle)] + parts[:, len(middle) :]
        off, slope_off, _ = abs(sums - whole)
        done = np.array((off <= tolerance) & (slope_off <= _STEEPER * tolerance))
        done |= halving == _HALVINGS - 1
        doubt = sums[2]
        for total, values in (
            (p, sums[0]),
            (slope, sums[1]),
            (error, off + doubt),
            (slope_error, slope_off + _STEEPER * doubt),
        ):
            np.add.at(total, ranges.pair[done], values[done])
        again = np.tile(~done, 2)
        ranges, whole = halves.at(again), parts[:, again]
    return Share(p, slope, error, slope_error)


def _over_ranges(
    clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array, ranges: _Ranges
) -> Array:
    """Return integrals over ranges of what `share_over_aims` returns: an array (3, range)."""
    x, w = np.polynomial.legendre.leggauss(_OFFSET_NODES)
    half = 0.5 * (ranges.high - ranges.low)[:, None]
    offset = 0.5 * (ranges.low + ranges.high)[:, None] + half * x
    weight = half * w * at_bats.offset.distribution.pdf(offset)
    pair = np.repeat(ranges.pair, _OFFSET_NODES)
    inputs = Samples(speed[pair], np.zeros(len(pair)), offset.ravel(), tilt[pair])
    shares = share_over_aims(clearance, at_bats.aim, inputs)
    return np.array([(weight * share.reshape(offset.shape)).sum(axis=1) for share in shares])


def _ranges(clearance: Clearance, at_bats: AtBats, speed: Array, tilt: Array) -> _Ranges:
    """Cut the offsets where the counted set begins or ends at an end of the bat, or amid it."""
    grid = clearance.offsets(speed, FARTHEST * at_bats.offset_deviation)
    pairs = np.arange(len(speed))
    lines, cuts = [pairs, pairs], [grid[:, 0], grid[:, -1]]
    for y in clearance.base.bat.length / 2 * (1.0 - _END) * np.array([-1.0, 0.0, 1.0]):

        def touching(offset: Array, pair: Places, y: float = y) -> Array:
            inputs = Samples(speed[pair], np.zeros_like(offset), offset, tilt[pair])
            return clearance(replace(inputs, aim=clearance.aim_to_touch(y, inputs)))

        found = crossings(touching, grid, sampled(touching, grid))
        lines.append(found.line)
        cuts.append(found.place)
    line, cut = np.concatenate(lines), np.concatenate(cuts)
    order = np.lexsort((cut, line))
    line, cut = line[order], cut[order]
    first = np.flatnonzero((line[1:] == line[:-1]) & (cut[1:] > cut[:-1]))
    return _Ranges(line[first], cut[first], cut[first + 1])


# --- the aim --------------------------------------------------------------------------------------


def share_over_aims(
    clearance: Clearance, law: Mixture, inputs: Samples
) -> tuple[Array, Array, Array]:
    """Return, for given speeds, offsets and tilts, the probability of what is counted.

    And its derivative by e, and 1 where the engine could not decide some at-bat, 0 elsewhere.
    """
    half = clearance.base.bat.length / 2 * (1.0 - _END)
    low, high = clearance.aim_to_touch(-half, inputs), clearance.aim_to_touch(half, inputs)
    grid = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _AIMS)

    def at(aim: Array, line: Places) -> Samples:
        return replace(inputs.chosen(line), aim=aim)

    every = np.repeat(np.arange(len(low)), _AIMS)
    flat, unsolved = clearance.with_unsolved(at(grid.ravel(), every))
    values = flat.reshape(grid.shape)
    ends = crossings(lambda aim, line: clearance(at(aim, line)), grid, values)
    p = probability(law.distribution.cdf, grid, values, ends)
    slope = np.zeros_like(p)
    moves = _moves(clearance, at(ends.place, ends.line), _STEP * (high - low)[ends.line])
    rates = np.where(ends.rises, -1.0, 1.0) * law.distribution.pdf(ends.place) * moves
    np.add.at(slope, ends.line, rates)
    doubt = np.where(unsolved.reshape(grid.shape).any(axis=1), 1.0, 0.0)
    return p, slope, doubt


def _moves(clearance: Clearance, roots: Samples, step: Array) -> Array:
    """Return how fast roots move along the aim with e: -(∂D/∂e)/(∂D/∂aim).

    Where D jumps, its difference over a step is so large that the root stays where it is.
    """
    e = clearance.restitution
    by_e = replace(clearance, restitution=e + _STEP)(roots)
    by_e -= replace(clearance, restitution=e - _STEP)(roots)
    by_aim = clearance(replace(roots, aim=roots.aim + step))
    by_aim -= clearance(replace(roots, aim=roots.aim - step))
    moves: Array = np.divide(-by_e / _STEP, by_aim / step, np.zeros_like(step), where=by_aim != 0.0)
    return moves
