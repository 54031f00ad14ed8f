"""Gauss-Legendre collocation to any number of digits: a flight as a chain of polynomials.

On a step, the acceleration is the polynomial that satisfies the equations of motion at the n nodes
of Gauss and Legendre; velocity and position are its integrals. Where the solution is analytic, the
Legendre coefficients fall off geometrically, so that a few dozen nodes give fifty digits on steps
of about a second, and the polynomials are as good between the nodes as at the ends of the step.
(Extrapolation of the midpoint rule by Gragg, Bulirsch and Stoer takes 1.5 times as long for the
same 44 digits of a flight, at its best order and step, and gives no polynomials.)

The equations at the nodes are solved by Newton's method in two precisions: the residuals in full,
the linear systems in doubles, which gains a dozen digits an iteration (iterative refinement, of a
nonlinear system here). The Jacobian is a complex step through the equations of motion themselves.

References
----------
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, Sec. IV.5 and IV.8: the method.
L. N. Trefethen, Approximation Theory and Approximation Practice, Ch. 8: the coefficients.
N. J. Higham, Accuracy and Stability of Numerical Algorithms, Ch. 12: refinement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from operator import mul
from typing import Any

import numpy as np
import scipy.linalg
from mpmath import MPContext
from numpy.typing import NDArray

from longball.engines.engine import CannotSolve
from longball.model.motion import Forces, PlaneState, acceleration
from longball.model.numbers import Numbers

Mpf = Any  # a number of an mpmath context: mpmath brings no types
State = PlaneState[Mpf]
Array = NDArray[np.float64]


# --- the rule -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FixedMatrix:
    """A matrix that multiplies lists of mpf in fixed point, ten times faster than in mpf.

    `rows` are whole numbers in units of ``2**-bits``. A list is scaled by its largest entry, so
    that a product is rounded relative to that, as sums are.
    """

    rows: tuple[tuple[int, ...], ...]
    bits: int
    context: MPContext

    def __matmul__(self, values: list[Mpf]) -> list[Mpf]:
        largest = max(map(abs, values))
        if largest == 0:
            return [largest] * len(self.rows)
        shift = self.bits - int(self.context.mag(largest))
        whole = [value.to_fixed(shift) for value in values]
        unit = -self.bits - shift
        return [self.context.mpf((sum(map(mul, row, whole)), unit)) for row in self.rows]


@dataclass(frozen=True)
class Rule:
    """The n Gauss-Legendre nodes on [-1, 1], and what is linear in the values there.

    Attributes
    ----------
    nodes
        In rising order.
    coefficients
        From values at the nodes to Legendre coefficients of degree 0 to n - 1.
    integrals
        From values at the nodes to integrals from -1 to each node.
    """

    nodes: tuple[Mpf, ...]
    coefficients: FixedMatrix
    integrals: FixedMatrix
    coefficients_in_doubles: Array
    integrals_in_doubles: Array


def gauss_legendre(n: int, context: MPContext) -> Rule:
    """Return the rule with `n` nodes in the precision of the context."""
    bits = context.prec + 10  # n terms of size one add up: ten bits for a thousand of them

    def fixed(rows: list[list[Mpf]]) -> FixedMatrix:
        whole = tuple(tuple(value.to_fixed(bits) for value in row) for row in rows)
        return FixedMatrix(whole, bits, context)

    nodes, by_node, rises = [], [], []
    for guess in np.polynomial.legendre.leggauss(n)[0].tolist():
        node = context.mpf(guess)
        for _ in range((context.prec // 40).bit_length()):  # from 50 bits, twice as many each time
            values = legendre(node, n)
            node -= values[n] * (1 - node * node) / (n * (values[n - 1] - node * values[n]))
        values = legendre(node, n)
        weight = 2 * (1 - node * node) / (n * values[n - 1]) ** 2
        nodes.append(node)
        by_node.append([(2 * k + 1) * weight * values[k] / 2 for k in range(n)])
        # The integral of P_k from -1 is (P_{k+1} - P_{k-1})/(2k + 1), and 1 + x for k = 0.
        higher = [(values[k + 1] - values[k - 1]) / (2 * k + 1) for k in range(1, n)]
        rises.append([1 + node, *higher])
    from_coefficients = fixed(by_node)
    integrals = [from_coefficients @ rise for rise in rises]
    coefficients = [list(row) for row in zip(*by_node, strict=True)]
    return Rule(
        tuple(nodes),
        fixed(coefficients),
        fixed(integrals),
        np.array(coefficients, dtype=float),
        np.array(integrals, dtype=float),
    )


def legendre(x: Mpf, degree: int) -> list[Mpf]:
    """Return P_0(x) to P_degree(x)."""
    values = [x * 0 + 1, x]
    for k in range(1, degree):
        values.append(((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1))
    return values


def _antiderivative(series: list[Mpf], half: Mpf, at_start: Mpf) -> list[Mpf]:
    """Return the series of ``at_start + half · (integral from -1)`` of a Legendre series."""
    padded = [*series, series[0] * 0, series[0] * 0]
    first = at_start + half * (padded[0] - padded[1] / 3)
    return [
        first,
        *(
            half * (padded[k - 1] / (2 * k - 1) - padded[k + 1] / (2 * k + 3))
            for k in range(1, len(series) + 1)
        ),
    ]


# --- a step ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Segment:
    """A step of a flight: the state as Legendre series of x, from `first` to `last`.

    Attributes
    ----------
    begin, until
        When the segment begins and ends, s since the launch.
    half
        s; the time is ``begin + half (1 + x)``.
    first, last
        -1, and 1 unless the segment was cut short.
    start, end
        The states at its ends, exactly those of the neighbouring segments.
    series
        The Legendre coefficients of s, z, u and w.
    at_nodes
        The states at the nodes of the rule, where it is cheap to look at functions of the state.
    """

    begin: Mpf
    until: Mpf
    half: Mpf
    first: Mpf
    last: Mpf
    start: State
    end: State
    series: tuple[list[Mpf], list[Mpf], list[Mpf], list[Mpf]]
    at_nodes: list[State]
    context: MPContext

    def time(self, x: Mpf) -> Mpf:
        """Return the time at x, s since the launch."""
        return self.until if x == self.last else self.begin + self.half * (1 + x)

    def state(self, x: Mpf) -> State:
        """Return the state at x."""
        if x == self.first:
            return self.start
        if x == self.last:
            return self.end
        values = legendre(x, len(self.series[0]) - 1)
        return PlaneState(*(self.context.fdot(series, values) for series in self.series))

    def ending(self, x: Mpf, state: State) -> Segment:
        """Return the segment cut short at x, where the state is as given."""
        return replace(self, until=self.time(x), last=x, end=state)


@dataclass(frozen=True)
class Dynamics:
    """The equations of motion in full precision, and over arrays of complex doubles."""

    exact: Callable[[Mpf, Mpf], tuple[Mpf, Mpf]]
    doubles: Callable[[Any, Any], tuple[Any, Any]]


class _ComplexArrays:
    """As much of a number system as the equations of motion ask for."""

    def exact(self, value: float) -> complex:
        return complex(value)

    def sqrt(self, x: Any) -> Any:
        return np.sqrt(x)


def dynamics(forces: Forces[Mpf], numbers: Numbers[Mpf]) -> Dynamics:
    """Return the equations of motion with the forces that a scene names."""

    def rounded(force: Mpf | None) -> complex | None:
        return None if force is None else complex(force)

    in_doubles: Forces[Any] = replace(
        forces,
        drag=rounded(forces.drag),
        lift=rounded(forces.lift),
        gravity=rounded(forces.gravity),
    )
    arrays: Any = _ComplexArrays()
    return Dynamics(acceleration(forces, numbers), acceleration(in_doubles, arrays))


def upright_dynamics(forces: Forces[Mpf], numbers: Numbers[Mpf], upwards: bool) -> Dynamics:
    """Return the equations of a vertical flight without lift, continued beyond its apex.

    With u = 0 the speed is |w|, and w' = -k_D |w| w - g has a kink in its second derivative at the
    apex. On either side it is a polynomial in w; here that of one side holds on both, which on the
    other means a drag that pushes.
    """
    if forces.drag is None:
        return dynamics(forces, numbers)
    here = dynamics(forces, numbers)
    beyond = dynamics(replace(forces, drag=-forces.drag), numbers)

    def exact(u: Mpf, w: Mpf) -> tuple[Mpf, Mpf]:
        return (here if (w >= 0) == upwards else beyond).exact(u, w)

    def doubles(u: Any, w: Any) -> tuple[Any, Any]:
        this_side = (w.real >= 0) == upwards
        return tuple(
            np.where(this_side, *sides)
            for sides in zip(here.doubles(u, w), beyond.doubles(u, w), strict=True)
        )

    return Dynamics(exact, doubles)


@dataclass(frozen=True)
class Collocation:
    """Steps of Gauss-Legendre collocation.

    Attributes
    ----------
    rule
        The nodes.
    numbers, context
        The arithmetic.
    tolerance
        What a step may leave out of the velocity, relative to the fastest speed of the flight.
    """

    rule: Rule
    numbers: Numbers[Mpf]
    context: MPContext
    tolerance: Mpf

    def segments(self, dynamics: Dynamics, begin: Mpf, start: State, end: Mpf) -> Iterator[Segment]:
        """Fly from a time and state to the time `end`, a segment at a time.

        Raises
        ------
        CannotSolve
            If no step is short enough.
        """
        state, fastest = start, self._speed(start)
        shortest, failed = self.tolerance * (end - begin), False
        length = self._first_length(dynamics, start, end - begin)
        while begin < end:
            length = min(length, end - begin)
            until = end if length == end - begin else begin + length
            segment, needed = self._step(dynamics, begin, until, state, fastest)
            change = self._change_of_length(needed)
            if segment is not None and needed <= self._enough:
                yield segment
                begin, state, fastest = until, segment.end, max(fastest, self._speed(segment.end))
                # What made a step fail is often still ahead.
                length *= min(1.0, change) if failed else change
                failed = False
            elif length > shortest:
                length *= change
                failed = True
            else:
                raise CannotSolve(
                    f"no step from t = {float(begin):.6g} s on is short enough to satisfy the "
                    f"equations of motion to {self.context.dps} digits"
                )

    @property
    def _enough(self) -> int:
        """Return how many coefficients may matter: the last are there to show that they do not."""
        return len(self.rule.nodes) - _IDLE

    def _change_of_length(self, needed: float) -> float:
        """Return by how much the next step should be longer than the last.

        Coefficients that fall as ρ^-k reach the tolerance at k = `needed`, which tells ρ, and
        should reach it at the last that may matter; and ρ is inverse to the length of a step.
        """
        if needed == 0:
            return _MOST_LONGER
        decades = -float(self.context.log10(self.tolerance))
        aim: float = _SAFETY * 10 ** (decades * (1 / needed - 1 / self._enough))
        return max(_MOST_SHORTER, min(_MOST_LONGER, aim))

    def _first_length(self, dynamics: Dynamics, start: State, longest: Mpf) -> Mpf:
        """Guess a step, s, in which the velocity changes by as much as its size."""
        speed = self._speed(start)
        change = self._hypot(*dynamics.exact(start.u, start.w))
        return min(longest, speed / change) if speed and change else longest

    def _speed(self, state: State) -> Mpf:
        return self._hypot(state.u, state.w)

    def _hypot(self, u: Mpf, w: Mpf) -> Mpf:
        return self.numbers.sqrt(u * u + w * w)

    def _step(
        self, dynamics: Dynamics, begin: Mpf, until: Mpf, start: State, fastest: Mpf
    ) -> tuple[Segment | None, float]:
        """Take a step; return it and how many coefficients it needs, which may be more than it has.

        All others change the velocity by less than the tolerance. If Newton's method fails, there
        is no step, and no number would do.
        """
        half = (until - begin) / 2
        rough = self._roughly(dynamics, float(start.u), float(start.w), float(half))
        if rough is None:
            return None, math.inf
        accelerations, jacobian = rough
        du = [self.context.mpf(a) for a in accelerations[0].tolist()]
        dw = [self.context.mpf(a) for a in accelerations[1].tolist()]
        n = len(self.rule.nodes)
        before = None
        while True:
            us = [start.u + half * rise for rise in self.rule.integrals @ du]
            ws = [start.w + half * rise for rise in self.rule.integrals @ dw]
            there = [dynamics.exact(u, w) for u, w in zip(us, ws, strict=True)]
            residual = [a - b for (a, _), b in zip(there, du, strict=True)]
            residual += [a - b for (_, a), b in zip(there, dw, strict=True)]
            largest = max(map(abs, residual))
            fastest_here = max(fastest, *(self._hypot(u, w) for u, w in zip(us, ws, strict=True)))
            if half * largest <= _SOLVED * self.tolerance * fastest_here:
                break
            if before is not None and largest * 100 > before:
                return None, math.inf
            before = largest
            scaled = np.array([float(r / largest) for r in residual])
            correction = scipy.linalg.lu_solve(jacobian, scaled).tolist()
            du = [a + largest * c for a, c in zip(du, correction[:n], strict=True)]
            dw = [a + largest * c for a, c in zip(dw, correction[n:], strict=True)]
        du_series, dw_series = self.rule.coefficients @ du, self.rule.coefficients @ dw
        u_series = _antiderivative(du_series, half, start.u)
        w_series = _antiderivative(dw_series, half, start.w)
        series = (
            _antiderivative(u_series, half, start.s),
            _antiderivative(w_series, half, start.z),
            u_series,
            w_series,
        )
        # P_k(1) = 1 for all k.
        end = PlaneState(*(self.context.fsum(coefficients) for coefficients in series))
        at_nodes = [
            PlaneState(start.s + half * s, start.z + half * z, u, w)
            for s, z, u, w in zip(
                self.rule.integrals @ us, self.rule.integrals @ ws, us, ws, strict=True
            )
        ]
        one = self.context.mpf(1)
        segment = Segment(begin, until, half, -one, one, start, end, series, at_nodes, self.context)
        sizes = [half * max(map(abs, pair)) for pair in zip(du_series, dw_series, strict=True)]
        return segment, self._needed(sizes, fastest_here)

    def _needed(self, sizes: list[Mpf], speed: Mpf) -> float:
        """Return how many coefficients are needed, from what each means to a velocity, m/s."""
        matter = [k for k, size in enumerate(sizes, start=1) if size > self.tolerance * speed]
        if not matter or matter[-1] <= self._enough:
            return matter[-1] if matter else 0
        last = max(sizes[-_IDLE:]) / speed
        # As many as it takes the coefficients to fall on to the tolerance.
        log = self.context.log
        return float(len(sizes) * log(self.tolerance) / log(last)) if last < 1 else math.inf

    def _roughly(
        self, dynamics: Dynamics, u: float, w: float, half: float
    ) -> tuple[Array, Any] | None:
        """Solve the step in doubles: the accelerations at the nodes, and the Jacobian factored."""
        n = len(self.rule.nodes)
        integrals = half * self.rule.integrals_in_doubles
        found = np.zeros((2, n))
        previous = np.inf
        for _ in range(_ROUGH_STEPS):
            us, ws = u + integrals @ found[0], w + integrals @ found[1]
            there = np.empty((2, n))
            slopes = np.empty((2, 2, n))
            with np.errstate(over="ignore", invalid="ignore"):  # a step too long runs away
                for k, (by_u, by_w) in enumerate(((_TINY, 0.0), (0.0, _TINY))):
                    value = dynamics.doubles(us + 1j * by_u, ws + 1j * by_w)
                    for i in range(2):
                        there[i], slopes[i, k] = np.real(value[i]), np.imag(value[i]) / _TINY
            blocks = [[-slopes[i, k][:, None] * integrals for k in range(2)] for i in range(2)]
            jacobian = np.block(blocks) + np.eye(2 * n)
            residual = (there - found).ravel()
            if not (np.isfinite(jacobian).all() and np.isfinite(residual).all()):
                return None
            factored = scipy.linalg.lu_factor(jacobian)
            correction = scipy.linalg.lu_solve(factored, residual).reshape(2, n)
            found = found + correction
            change = half * np.abs(correction).max()
            if change <= _ROUGHLY * max(np.abs(us).max(), np.abs(ws).max()):
                return found, factored
            if change > 2 * previous:
                return None
            previous = change
        return None


# Even and odd coefficients may differ in size, by symmetry: two tell that both have fallen, three
# leave no doubt.
_IDLE = 3

# A step that fails costs more than one that is a tenth too short. Beyond these limits ρ is not
# inverse to the length: the coefficients have not begun to fall, or there are too few to tell.
_SAFETY, _MOST_SHORTER, _MOST_LONGER = 0.9, 0.5, 4.0

# Where the refinement stops, relative to what a step may leave out: what remains must not pass for
# a tail of the coefficients, which no shorter step would take away.
_SOLVED = 1e-3

# The derivative by a complex step has no rounding error to balance: any tiny step will do.
_TINY = 1e-100

# Newton's method squares the error. A dozen iterations end far from the solution only if the step
# is far too long.
_ROUGH_STEPS = 12

# Where Newton's method in doubles may stop, relative to the velocity: near its rounding. The
# refinement goes on from there.
_ROUGHLY = 1e-11
