"""Sign changes of a function along many lines: all that samples along them show.

The function is a number of metres that is positive where something is counted. It may jump, as
where a bat ends; it need not be differentiable.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from longball.model.arrays import Array, Flags, Integers

Function = Callable[[Array, Integers], Array]  # of places on lines, and the numbers of the lines

# m/s or m along a line, or m of the function: far below what an integral over lines is wanted to.
_TOLERANCES = {"xatol": 1e-13, "xrtol": 1e-13, "fatol": 1e-10}
# Of Chandrupatla's method, enough for most roots. At a jump it halves the bracket: division by five
# takes less than half as many steps, and a step costs little more for some places than for one.
_MOST_STEPS, _SECTIONS = 10, 5
# m, that a function can be from zero where it crosses zero without a jump: 1e10 times as much as
# the place is off, and D never is so steep.
_JUMP = 1e-3


class Crossings(NamedTuple):
    """Changes of sign: arrays of shape (crossing,), in the order of lines and along each.

    `rises` tells whether the function is positive after the crossing, `jumps` whether it jumps.
    """

    line: Integers
    place: Array
    rises: Flags
    jumps: Flags


def sampled(function: Callable[..., Any], grid: Array, lines: Integers | None = None) -> Any:
    """Return a function at the places of a grid, an array (line, sample).

    The numbers of the lines are 0, 1, … if they are not given.
    """
    each = np.repeat(np.arange(len(grid)) if lines is None else lines, grid.shape[1])
    return function(grid.ravel(), each).reshape(grid.shape)


def probability(
    below: Callable[[Array], Array], grid: Array, values: Array, ends: Crossings
) -> Array:
    """Return the probability, on each line, of places where a function is positive.

    Places have the distribution function `below`; the rest is what `crossings` takes and returns.
    """
    last, first = (np.where(values[:, i] >= 0.0, below(grid[:, i]), 0.0) for i in (-1, 0))
    p: Array = last - first
    # What lies below a beginning does not count, what lies below an end does.
    np.add.at(p, ends.line, np.where(ends.rises, -1.0, 1.0) * below(ends.place))
    return p


class _Brackets(NamedTuple):
    line: Integers
    low: Array
    high: Array
    rises: Flags


def narrowed(
    low: Array, high: Array, changed: Callable[[Array], Flags], times: int
) -> tuple[Array, Array]:
    """Narrow brackets, by so many divisions, to the part in which something first changes.

    `changed` tells of places, an array (bracket, place), whether it has changed there.
    """
    rows = np.arange(len(low))
    for _ in range(times if len(rows) else 0):
        places = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _SECTIONS + 1)
        other = np.ones_like(places, dtype=bool)
        other[:, 0] = False
        other[:, 1:-1] = changed(places[:, 1:-1])
        first = np.argmax(other, axis=1)
        low, high = places[rows, first - 1], places[rows, first]
    return low, high


def crossings(function: Function, grid: Array, values: Array) -> Crossings:
    """Find where a function changes its sign, from its values on grids (line, sample).

    There is one crossing between two samples of different signs; two or none beside a sample that
    is nearer to zero than its neighbours.
    """
    from scipy.optimize import elementwise  # slow to import, and not needed for --help

    # brackets: where neighbours differ, and beside samples near which the function may turn
    inside = values >= 0.0
    line, k = np.nonzero(inside[:, 1:] != inside[:, :-1])
    brackets = _Brackets(line, grid[line, k], grid[line, k + 1], inside[line, k + 1])
    beside = _beside_turns(function, grid, values, inside)
    brackets = _Brackets(*map(np.concatenate, zip(brackets, *beside, strict=True)))
    if len(brackets.line) == 0:
        return Crossings(brackets.line, brackets.low, brackets.rises, brackets.rises)
    # roots, all at once
    found = elementwise.find_root(
        function,
        (brackets.low, brackets.high),
        args=(brackets.line,),
        tolerances=_TOLERANCES,
        maxiter=_MOST_STEPS,
    )
    place, value, left = found.x, found.f_x, ~found.success
    # what is left are mostly jumps, which no interpolation finds: divide the brackets
    if left.any():
        line, rises = brackets.line[left], brackets.rises[left]
        ends = [end[left] for end in found.bracket]
        low, high = np.minimum(*ends), np.maximum(*ends)

        def changed(places: Array) -> Flags:
            there: Flags = (sampled(function, places, line) >= 0.0) == rises[:, None]
            return there

        widest = float((high - low).max())
        times = math.ceil(math.log(max(widest / _TOLERANCES["xatol"], 1.0), _SECTIONS))
        place[left] = narrowed(low, high, changed, times)[1]
        value[left] = function(place[left], line)
    # a value that is not zero at its root shows a jump
    order = np.lexsort((place, brackets.line))
    jumps = abs(value) > _JUMP
    return Crossings(brackets.line[order], place[order], brackets.rises[order], jumps[order])


def _beside_turns(function: Function, grid: Array, values: Array, inside: Flags) -> list[_Brackets]:
    """Bracket crossings that come in pairs between samples of the same sign."""
    from scipy.optimize import elementwise

    line, k = np.nonzero(_may_turn(values, inside))
    if len(line) == 0:
        return []
    sign = np.where(inside[line, k], 1.0, -1.0)
    found = elementwise.find_minimum(
        lambda place, of, sign: sign * function(place, of),
        (grid[line, k - 1], grid[line, k], grid[line, k + 1]),
        args=(line, sign),
    )
    crosses = found.f_x < 0.0
    line, k, turn = line[crosses], k[crosses], found.x[crosses]
    into = ~inside[line, k]
    return [
        _Brackets(line, grid[line, k - 1], turn, into),
        _Brackets(line, turn, grid[line, k + 1], ~into),
    ]


def _may_turn(values: Array, inside: Flags) -> Flags:
    """True if the function may cross zero and come back beside a sample.

    It does if the sample is nearer to zero than both neighbours on the same side, and near enough.
    A parabola through the three goes beyond it by an eighth of the sum of their differences at
    most; four times that is looked into.
    """
    sign = np.where(inside[:, 1:-1], 1.0, -1.0)
    near = abs(values[:, 1:-1])
    left, right = sign * values[:, :-2] - near, sign * values[:, 2:] - near
    may = np.zeros_like(inside)
    may[:, 1:-1] = (left >= 0.0) & (right >= 0.0) & (near < 0.5 * (left + right))
    return may
