"""Sign changes of a function along many lines, found from samples on each line.

The function is a length in metres, positive for counted at-bats. It may jump, for example at the
end of the bat, and need not be differentiable.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from longball.model.arrays import Array, Flags, Integers

Function = Callable[[Array, Integers], Array]  # of positions on lines, and the lines' numbers

# Along a line in m/s or m, and of the function in m: far below the errors of the integrals.
_TOLERANCES = {"xatol": 1e-13, "xrtol": 1e-13, "fatol": 1e-10}  # free choices
# Steps of Chandrupatla's method, enough for most roots. At a jump it only halves the bracket.
# Division by five needs less than half as many steps, and evaluating five positions costs little
# more than one.
_MOST_STEPS, _SECTIONS = 10, 5
# m. A function without a jump is closer to zero than this at its root: the root is accurate to
# 1e-13, and D changes by less than 1e10 times that.
_JUMP = 1e-3


class Crossings(NamedTuple):
    """Changes of sign: arrays of shape (crossing,), in the order of lines and along each.

    `rises` is True if the function is positive after the crossing, `jumps` if it jumps there.
    """

    line: Integers
    place: Array
    rises: Flags
    jumps: Flags


def sampled(function: Callable[..., Any], grid: Array, lines: Integers | None = None) -> Any:
    """Return the values of a function on a grid, an array (line, sample).

    The lines are numbered 0, 1, … by default.
    """
    each = np.repeat(np.arange(len(grid)) if lines is None else lines, grid.shape[1])
    return function(grid.ravel(), each).reshape(grid.shape)


def probability(
    below: Callable[[Array], Array], grid: Array, values: Array, ends: Crossings
) -> Array:
    """Return the probability, on each line, of the positions where a function is positive.

    `below` is the cumulative distribution function of a position; see `crossings` for the others.
    """
    last, first = (np.where(values[:, i] >= 0.0, below(grid[:, i]), 0.0) for i in (-1, 0))
    p: Array = last - first
    # An interval from a to b has the probability F(b) - F(a): ends add, beginnings subtract.
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
    """Divide brackets repeatedly, and keep the part with the first change.

    `changed` takes positions, an array (bracket, position), and returns True behind the change.
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
    """Find the sign changes of a function from its values on grids (line, sample).

    There is one crossing between two samples of different signs, and two or none next to a sample
    that is closer to zero than its neighbours.
    """
    from scipy.optimize import elementwise  # slow to import, and not needed for --help

    # brackets: between neighbours of different signs, and next to samples near a turning point
    inside = values >= 0.0
    line, k = np.nonzero(inside[:, 1:] != inside[:, :-1])
    brackets = _Brackets(line, grid[line, k], grid[line, k + 1], inside[line, k + 1])
    beside = _beside_turns(function, grid, values, inside)
    brackets = _Brackets(*map(np.concatenate, zip(brackets, *beside, strict=True)))
    if len(brackets.line) == 0:
        return Crossings(brackets.line, brackets.low, brackets.rises, brackets.rises)
    # roots, all at once
    roots = elementwise.find_root(
        function,
        (brackets.low, brackets.high),
        args=(brackets.line,),
        tolerances=_TOLERANCES,
        maxiter=_MOST_STEPS,
    )
    place, value, left = roots.x, roots.f_x, ~roots.success
    # most of the others are jumps, where interpolation fails: divide the brackets
    if left.any():
        line, rises = brackets.line[left], brackets.rises[left]
        ends = [end[left] for end in roots.bracket]
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
    minima = elementwise.find_minimum(
        lambda place, of, sign: sign * function(place, of),
        (grid[line, k - 1], grid[line, k], grid[line, k + 1]),
        args=(line, sign),
    )
    crosses = minima.f_x < 0.0
    line, k, turn = line[crosses], k[crosses], minima.x[crosses]
    into = ~inside[line, k]
    return [
        _Brackets(line, grid[line, k - 1], turn, into),
        _Brackets(line, turn, grid[line, k + 1], ~into),
    ]


def _may_turn(values: Array, inside: Flags) -> Flags:
    """True if the function may cross zero and return next to a sample.

    The sample must be closer to zero than both neighbours of the same sign, and close enough. A
    parabola through the three passes it by at most an eighth of the sum of the differences; the
    limit is four times that.
    """
    sign = np.where(inside[:, 1:-1], 1.0, -1.0)
    near = abs(values[:, 1:-1])
    left, right = sign * values[:, :-2] - near, sign * values[:, 2:] - near
    may = np.zeros_like(inside)
    may[:, 1:-1] = (left >= 0.0) & (right >= 0.0) & (near < 0.5 * (left + right))
    return may
