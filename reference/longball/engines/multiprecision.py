"""Any number of digits, by mpmath: the second opinion on every digit of the golden data.

It proves nothing, but shares nothing with the engine that does: no recurrence for Taylor
coefficients, no step from a radius of convergence, no interval root. A flight is a chain of
polynomials by Gauss-Legendre collocation. On a step, the rates of the state are polynomials that
satisfy the law of motion at the n nodes of Gauss and Legendre; the state is their integral. Where
the solution is analytic, the Legendre coefficients fall off geometrically, so that a few dozen
nodes give fifty digits on steps of about a second, and the polynomials are as good between the
nodes as at the ends of the step. On them an eigenvalue problem gives all turning points of an event
at once, so that none can hide between two steps.
(Extrapolation of the midpoint rule by Gragg, Bulirsch and Stoer takes 1.5 times as long for the
same 44 digits of a flight, at its best order and step, and gives no polynomials; mpmath's odefun,
which differentiates numerically with thousands of digits, takes 28 times as long.)

The equations at the nodes are solved by Newton's method in two precisions: the residuals in full,
the linear systems in doubles, which gains a dozen digits an iteration (iterative refinement, of a
nonlinear system here). The Jacobian is that of the traced law.

References
----------
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, Sec. IV.5 and IV.8: the method.
L. N. Trefethen, Approximation Theory and Approximation Practice, Ch. 8: the coefficients.
N. J. Higham, Accuracy and Stability of Numerical Algorithms, Ch. 12: refinement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from operator import mul
from typing import Any

import numpy as np
import scipy.linalg
from mpmath import MPContext

from longball.engines.engine import OutOfRange, TooLong
from longball.engines.event import Events
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import ARRAYS, Dual
from longball.model.arrays import Array
from longball.model.law import Law, State
from longball.model.numbers import Numbers, ratio
from longball.model.result import Bounded

Mpf = Any  # a number of an mpmath context: mpmath brings no types

# Digits beyond those that are printed. The error of a step is 14 digits below them, that of a
# flight of dozens of steps 10. Those ten allow for what an at-bat magnifies: from the contact to
# the landing an error grows by a few hundred, and in a graze with a margin of 1e-15 m by 1e10.
# Rounding stays six digits below the error of a step.
_FLIGHT_GUARD = 10
_STEP_GUARD = 14  # a free choice
_ROUNDING_GUARD = 20

# Nodes a digit: between 1.1 and 1.6 the time of a flight is flat.
_NODES_PER_DIGIT = 1.25  # a free choice


class MultiprecisionNumbers(Numbers):
    """Numbers of mpmath with the digits that are printed, and guard digits.

    They have a separate context, so that engines of different precision do not interfere.
    """

    def __init__(self, digits: int) -> None:
        self.digits, self.precision = digits, f"with {digits} digits"
        self.context = MPContext()
        self.context.dps = digits + _ROUNDING_GUARD
        self.pi: Mpf = +self.context.pi
        self.exact, self.sqrt = self.context.mpf, self.context.sqrt
        self.angle = self.context.atan2
        self.rounding = 2.0**-self.context.prec
        self.functions = {
            "sqrt": self.context.sqrt,
            "exp": self.context.exp,
            "log": self.context.log,
            "unit": ratio,
        }

    def cos_sin(self, angle: Mpf) -> tuple[Mpf, Mpf]:
        """Return cosine and sine of an angle in radians."""
        return self.context.cos(angle), self.context.sin(angle)

    def report(self, x: Mpf) -> Bounded:
        """Return the number rounded to the digits asked for; its error is not proven."""
        if not self.context.isfinite(x):
            raise OverflowError(f"a value is {x}")
        text: str = self.context.nstr(x, self.digits, strip_zeros=False)
        return Bounded(value=text.removesuffix("."), radius=None)

    @cached_property
    def tolerance(self) -> Mpf:
        """Allowed truncation error of a velocity in a step, relative to the flight's top speed."""
        return self.context.mpf(10) ** -(self.digits + _STEP_GUARD)

    @cached_property
    def rule(self) -> Rule:
        """The rule of collocation."""
        nodes = math.ceil(_NODES_PER_DIGIT * (self.digits + _STEP_GUARD))
        return gauss_legendre(nodes, self.context)


_numbers = lru_cache(MultiprecisionNumbers)


# --- the engine -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Multiprecision(PathEngine):
    """Flights by Gauss-Legendre collocation in mpmath.

    Attributes
    ----------
    digits
        How many digits of each number are printed, and normally right.
    """

    digits: int = 30

    def __post_init__(self) -> None:
        if not 1 <= self.digits <= _MOST_DIGITS:
            raise ValueError(f"digits = {self.digits} is not between 1 and {_MOST_DIGITS}")

    @property
    def description(self) -> str:
        """Name, method and digits."""
        return f"multiprecision Gauss-Legendre digits={self.digits}"

    @property
    def numbers(self) -> MultiprecisionNumbers:
        """Numbers of mpmath."""
        return _numbers(self.digits)

    @property
    def flight_error(self) -> float:
        """Relative error of a state at the end of a flight; it is not proven."""
        return 10.0 ** -(self.digits + _FLIGHT_GUARD)

    def steps(
        self, law: Law, start: State, begin: Mpf, limit: Mpf, events: Events
    ) -> Iterator[Segment]:
        """Yield the pieces of a flight; see `longball.engines.path_engine.PathEngine.steps`.

        A flight that comes near V = 0 is followed by steps as short as it takes.

        Raises `TooLong` if the flight takes too many steps, `OutOfRange` if no step is short
        enough.
        """
        numbers, dynamics = self.numbers, Dynamics(law, self.numbers)
        tolerance, context = numbers.tolerance, numbers.context
        state, fastest = start, dynamics.speed(start)
        shortest, failed, taken = tolerance * (limit - begin), False, 0
        # at first a step in which the velocity changes by as much as its size
        length, change = limit - begin, dynamics.speed(dynamics.exact(*start))
        if fastest and change:
            length = min(length, fastest / change)
        while begin < limit:
            # The last step is longer by its rounding, so that it does not end before the limit.
            length = min(length, (limit - begin) * (1 + 4 * context.eps))  # a free choice
            segment, needed = dynamics.step(begin, length / 2, state, fastest)
            # The factor to the next step. Coefficients fall as ρ^-k and reach the tolerance at k =
            # `needed`, which determines ρ. They should reach it at the last significant one; ρ is
            # inversely proportional to the step.
            change = _MOST_LONGER
            if needed:
                decades = -float(context.log10(tolerance))
                aim = _SAFETY * 10 ** (decades * (1 / needed - 1 / dynamics.enough))
                change = max(_MOST_SHORTER, min(_MOST_LONGER, aim))
            if segment is not None and needed <= dynamics.enough:
                if taken == _MOST_STEPS:
                    raise TooLong(
                        f"the flight takes more than {_MOST_STEPS} steps; the first "
                        f"{float(begin):.3g} s of it can be had by a lower time_limit"
                    )
                yield segment
                begin, state, taken = begin + length, segment.end, taken + 1
                fastest = max(fastest, dynamics.speed(state))
                # What made a step fail is often still ahead: do not grow at once.
                length *= min(1.0, change) if failed else change
                failed = False
            elif length > shortest:
                length *= change
                failed = True
            else:
                raise OutOfRange(
                    f"no step from t = {float(begin):.6g} s on is short enough to satisfy the "
                    f"equations of motion to {context.dps} digits"
                )


# A flight takes twenty, one that loops for a minute a hundred: ten seconds of 30 digits.
_MOST_STEPS = 250  # a free choice

# Beyond, a double does not hold the error of a flight, 10^-(digits + 10).
_MOST_DIGITS = 290

# A failed step costs more than one that is a tenth too short. Beyond the other two limits the
# estimate of ρ is unreliable: the coefficients have not begun to fall, or there are too few.
_SAFETY, _MOST_SHORTER, _MOST_LONGER = 0.9, 0.5, 4.0  # a free choice


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
    """Matrices that act on the values at the n Gauss-Legendre nodes on [-1, 1]."""

    count: int  # n
    # From values at the nodes to Legendre coefficients of degree 0 to n - 1
    coefficients: FixedMatrix
    integrals: FixedMatrix  # from values at the nodes to integrals from -1 to each node
    coefficients_in_doubles: Array
    integrals_in_doubles: Array


def gauss_legendre(n: int, context: MPContext) -> Rule:
    """Return the rule with `n` nodes in the precision of the context."""
    bits = context.prec + 10  # n terms of size one add up: ten bits for a thousand of them

    def fixed(rows: list[list[Mpf]]) -> FixedMatrix:
        whole = tuple(tuple(value.to_fixed(bits) for value in row) for row in rows)
        return FixedMatrix(whole, bits, context)

    by_node, rises = [], []
    for guess in np.polynomial.legendre.leggauss(n)[0].tolist():
        node = context.mpf(guess)
        for _ in range((context.prec // 40).bit_length()):  # from 50 bits, twice as many each time
            values = legendre(node, n)
            node -= values[n] * (1 - node * node) / (n * (values[n - 1] - node * values[n]))
        values = legendre(node, n)
        weight = 2 * (1 - node * node) / (n * values[n - 1]) ** 2
        by_node.append([(2 * k + 1) * weight * values[k] / 2 for k in range(n)])
        # The integral of P_k from -1 is (P_{k+1} - P_{k-1})/(2k + 1), and 1 + x for k = 0.
        higher = [(values[k + 1] - values[k - 1]) / (2 * k + 1) for k in range(1, n)]
        rises.append([1 + node, *higher])
    from_coefficients = fixed(by_node)
    integrals = [from_coefficients @ rise for rise in rises]
    coefficients = [list(row) for row in zip(*by_node, strict=True)]
    return Rule(
        n,
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


# --- a step ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Segment:
    """A step of a flight: the state as Legendre series of x, from -1 to 1."""

    begin: Mpf  # when the segment begins, s since the launch
    half: Mpf  # s; the time since it begins is ``half (1 + x)``
    # start, end: the states at its ends, exactly those of the neighbouring segments
    start: State
    end: State
    series: tuple[list[Mpf], ...]  # the Legendre coefficients of each component of the state
    # at_nodes, rates_at_nodes: the states at the nodes of the rule, and their rates of change
    at_nodes: list[State]
    rates_at_nodes: list[State]
    dynamics: Dynamics  # the equations that it satisfies

    @property
    def length(self) -> Mpf:
        """Length of the segment, s."""
        return 2 * self.half

    def at(self, t: Mpf) -> State:
        """Return the state at a time on the segment, s since it begins."""
        if t == 0:
            return self.start
        if t == self.length:
            return self.end
        values = legendre(t / self.half - 1, len(self.series[0]) - 1)
        return type(self.start)(
            *(self.dynamics.numbers.context.fdot(c, values) for c in self.series)
        )

    def rates(self, t: Mpf) -> State:
        """Return the rates of change of the state at a time on the segment."""
        return type(self.start)(*self.dynamics.exact(*self.at(t)))

    def curve(self, value: Callable[[Any], Any]) -> SegmentCurve:
        """Return the value of an event along the segment."""
        return SegmentCurve(self, value)


class Dynamics:
    """A law of motion: its rates in full precision and with their Jacobian over arrays, its steps.

    `enough` is the number of significant coefficients of a step; the others must be negligible.
    """

    def __init__(self, law: Law, numbers: MultiprecisionNumbers) -> None:
        self.numbers, self.enough = numbers, numbers.rule.count - _IDLE
        # Each position, and the velocity that it is the integral of. All other variables, which are
        # called velocities here, are the unknowns of a step, whose error is relative to theirs.
        names, rates = law.variables, law.program.outputs
        mover = {
            i: names.index(rate.args[0]) for i, rate in enumerate(rates) if rate.kind == "variable"
        }
        self.positions = {i: velocity for i, velocity in mover.items() if velocity not in mover}
        self.velocities = [i for i in range(len(names)) if i not in self.positions]
        self.exact = law.rates(numbers)
        in_doubles: Law = replace(law, strengths={k: float(x) for k, x in law.strengths.items()})
        self.rough = in_doubles.rates(ARRAYS)
        self.jacobian = in_doubles.jacobian(ARRAYS)

    def values(self, start: State, rates: list[Any], integrate: Callable[[Any, Any], Any]) -> Any:
        """Return the variables at the nodes; write the rates of positions, given the others."""
        values = [*start]
        for i in self.velocities:
            values[i] = integrate(start[i], rates[i])
        for i, velocity in self.positions.items():
            rates[i] = values[velocity]
            values[i] = integrate(start[i], rates[i])
        return values

    def speed(self, state: Sequence[Mpf]) -> Mpf:
        """Return the size of the velocities of a state, or of their rates."""
        context = self.numbers.context
        return context.sqrt(context.fsum(state[i] ** 2 for i in self.velocities))

    def step(
        self, begin: Mpf, half: Mpf, start: State, fastest: Mpf
    ) -> tuple[Segment | None, float]:
        """Take a step; return it and how many coefficients it needs, which may be more than it has.

        All others change the velocity by less than the tolerance. If Newton's method fails, there
        is no step, and no number would do.
        """
        rule, state, unknown = self.numbers.rule, type(start), self.velocities
        context, tolerance = self.numbers.context, self.numbers.tolerance

        # Newton's method in doubles; its factored Jacobian serves the refinement, too
        rough = self._roughly(start, float(half))
        if rough is None:
            return None, math.inf
        guess, jacobian, speed = rough
        fastest = max(fastest, speed)

        def integrate(x: Mpf, row: list[Mpf]) -> list[Mpf]:
            return [x + half * rise for rise in rule.integrals @ row]

        # refinement: residuals in full, corrections by the Jacobian factored in doubles
        rates = [list(map(context.mpf, row)) for row in guess]
        before = None
        while True:
            values = self.values(start, rates, integrate)
            at_nodes = [state(*column) for column in zip(*values, strict=True)]
            computed = [*zip(*(self.exact(*there) for there in at_nodes), strict=True)]
            residual = [x - y for i in unknown for x, y in zip(computed[i], rates[i], strict=True)]
            largest = max(map(abs, residual))
            if half * largest <= _SOLVED * tolerance * fastest:
                break
            # Each round gains about a dozen digits; less than two show that it does not converge.
            if before is not None and largest * 100 > before:  # a free choice
                return None, math.inf
            before = largest
            # Scaled: with hundreds of digits, residuals are below the range of doubles.
            scaled = np.array([float(r / largest) for r in residual])
            correction = scipy.linalg.lu_solve(jacobian, scaled).reshape(len(unknown), -1).tolist()
            for i, change in zip(unknown, correction, strict=True):
                rates[i] = [rate + largest * c for rate, c in zip(rates[i], change, strict=True)]

        # the state as Legendre series, and how many of their coefficients matter
        rising = [rule.coefficients @ row for row in rates]
        series = []
        for p, x in zip(rising, start, strict=True):
            # of x + half · (integral of p from -1)
            padded = [*p, p[0] * 0, p[0] * 0]
            integral = [
                half * (padded[k - 1] / (2 * k - 1) - padded[k + 1] / (2 * k + 3))
                for k in range(1, len(p) + 1)
            ]
            series.append([x + half * (padded[0] - padded[1] / 3), *integral])
        segment = Segment(
            begin,
            half,
            start,
            state(*map(context.fsum, series)),  # P_k(1) = 1 for all k
            tuple(series),
            at_nodes,
            [state(*column) for column in zip(*rates, strict=True)],
            self,
        )
        # the effect of each coefficient on a velocity, m/s
        velocities = [rising[i] for i in unknown]
        sizes = [half * max(map(abs, each)) for each in zip(*velocities, strict=True)]
        matter = [k for k, size in enumerate(sizes, start=1) if size > tolerance * fastest]
        if not matter or matter[-1] <= self.enough:
            return segment, matter[-1] if matter else 0
        last = max(sizes[-_IDLE:]) / fastest
        if not last < 1:
            return segment, math.inf
        # The number at which they reach the tolerance if they fall on as ρ^-k, k = 1, 2, …
        log = context.log
        return segment, float(len(sizes) * log(tolerance) / log(last))

    def _roughly(self, start: State, half: float) -> tuple[list[Array], Any, float] | None:
        """Solve in doubles: the rates at the nodes, the Jacobian factored, the fastest speed."""
        rule, n, unknown = self.numbers.rule, self.numbers.rule.count, self.velocities
        once = half * rule.integrals_in_doubles
        twice = once @ once
        at_start = type(start)(*map(float, start))
        rates = [np.zeros(n)] * len(start)
        previous = np.inf
        for _ in range(_ROUGH_STEPS):
            # A step too long runs away.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                values = self.values(at_start, rates, lambda x, row: x + once @ row)
                computed = self.rough(*values)
                # The rates at all nodes depend on the variables there, and these on the rates at
                # all nodes: blocks of ∂f_i/∂x_k times the integrals, taken from the unit matrix;
                # twice the integrals if x_k is a position, with the rates of its velocity.
                jacobian, partials = np.eye(n * len(unknown)), self.jacobian(*values)
                for row, i in enumerate(unknown):
                    for k, partial in enumerate(partials[i * len(start) :][: len(start)]):
                        integrals = twice if k in self.positions else once
                        column = unknown.index(self.positions.get(k, k))
                        jacobian[n * row : n * (row + 1), n * column : n * (column + 1)] -= (
                            np.broadcast_to(partial, n)[:, np.newaxis] * integrals
                        )
            residual = np.concatenate([computed[i] - rates[i] for i in unknown])
            if not (np.isfinite(jacobian).all() and np.isfinite(residual).all()):
                return None
            factored = scipy.linalg.lu_factor(jacobian)
            correction = scipy.linalg.lu_solve(factored, residual).reshape(len(unknown), n)
            for i, more in zip(unknown, correction, strict=True):
                rates[i] = rates[i] + more
            # The change of the velocity that the rates make in half the step.
            velocities = np.array([values[i] for i in unknown])
            change = half * np.abs(correction).max()
            if change <= _ROUGHLY * np.abs(velocities).max():
                return rates, factored, float(np.linalg.norm(velocities, axis=0).max())
            if change > 2 * previous:  # a free choice
                return None
            previous = change
        return None


# Number of negligible coefficients at the end. By symmetry, even and odd ones may differ in size:
# two would cover both kinds, and three are safe.
_IDLE = 3  # a free choice

# End of the refinement, relative to the truncation error. A larger residual would look like a tail
# of the coefficients, which a shorter step does not remove.
_SOLVED = 1e-3  # a free choice

# Newton's method squares the error. A dozen iterations end far from the solution only if the step
# is far too long.
_ROUGH_STEPS = 12  # a free choice

# End of Newton's method in doubles, relative to the velocity: near rounding. The refinement
# continues from there.
_ROUGHLY = 1e-11  # a free choice


# --- events on a segment --------------------------------------------------------------------------


@dataclass(frozen=True)
class SegmentCurve:
    """The value of an event along a segment; see `longball.engines.event.Curve`."""

    segment: Segment
    value: Callable[[Any], Any]

    def __call__(self, t: Mpf) -> Mpf:
        """Return the value."""
        return self.value(self.segment.at(t))

    def rate(self, t: Mpf) -> Mpf:
        """Return the rate of change of the value."""
        return self._rate(self.segment.at(t), self.segment.rates(t))

    def _rate(self, state: State, rates: State) -> Mpf:
        duals: State = type(state)(*map(Dual, state, rates))
        return self.value(duals).rate

    def _in_doubles(self, values: Iterable[Mpf]) -> Array:
        """Return the Legendre coefficients of a function with these values at the nodes."""
        series: Array = self.segment.dynamics.numbers.rule.coefficients_in_doubles @ np.array(
            [*map(float, values)]
        )
        return series

    def positive(self, a: Mpf, b: Mpf) -> bool:
        """See `Curve.positive`: a sum of |c_k| bounds the rest, as all |P_k| <= 1."""
        first, *others = self._in_doubles(map(self.value, self.segment.at_nodes))
        # The slack is far more than the rounding of doubles: no graze is passed over.
        return bool(first > (1 + 1e-9) * np.abs(others).sum())  # a free choice

    def turns(self, a: Mpf, b: Mpf) -> list[Mpf]:
        """See `Curve.turns`.

        Doubles find all zeros of its rate at once, as the eigenvalues of a matrix; each is then
        made precise. Two that are nearer to each other than `_NEAR` are missed; between them the
        value changes by the cube of that, a part in 1e21.
        """
        segment = self.segment
        rates = map(self._rate, segment.at_nodes, segment.rates_at_nodes)
        series = self._in_doubles(rates)
        significant = np.flatnonzero(np.abs(series) > _NOISE * np.abs(series).max())
        if not significant.size:
            return []
        roots = np.polynomial.legendre.legroots(series[: significant[-1] + 1])
        half, turns = segment.half, []
        for guess in roots.real[np.abs(roots.imag) <= _NEAR].tolist():
            low, high = max(a, half * (1 + guess - _NEAR)), min(b, half * (1 + guess + _NEAR))
            if low < high:
                turns.append(self._change_of_sign(self.rate, low, high))
        return sorted(t for t in turns if t is not None and a < t < b)

    def zero(self, a: Mpf, b: Mpf) -> Mpf:
        """See `Curve.zero`; a value that is not positive at a is zero there."""
        zero = self._change_of_sign(self, a, b)
        return a if zero is None else zero

    def _change_of_sign(self, function: Callable[[Mpf], Mpf], low: Mpf, high: Mpf) -> Mpf | None:
        """Time between two at which a function changes its sign; None if it does not.

        Inverse quadratic interpolation where three points allow it, else bisection (Chandrupatla,
        Advances in Engineering Software 28, 145 (1997)): a dozen evaluations for fifty digits.
        """
        x1, x2 = high, low
        f1, f2 = function(x1), function(x2)
        if f1 == 0 or f2 == 0:
            return x2 if f2 == 0 else x1
        if (f1 > 0) == (f2 > 0):
            return None
        context = self.segment.dynamics.numbers.context
        # (mpmath's own bracketing solvers stop by the size of the function, which says nothing of
        # the time where that is as flat as at a graze.)
        resolution = 16 * context.eps * self.segment.half
        fraction = context.mpf(0.5)
        while True:
            x = x1 + fraction * (x2 - x1)
            f = function(x)
            if (f > 0) == (f1 > 0):
                x3, f3 = x1, f1
            else:
                x3, f3, x2, f2 = x2, f2, x1, f1
            x1, f1 = x, f
            least = resolution / abs(x2 - x1)
            if f1 == 0 or least > 0.5:
                return x1 if abs(f1) < abs(f2) else x2
            xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            fraction = context.mpf(0.5)
            if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:
                fraction = f1 / (f2 - f1) * f3 / (f2 - f3)
                fraction += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
            fraction = min(max(fraction, least), 1 - least)


# Coefficients below this, relative to the largest, are the rounding of the doubles they are in.
_NOISE = 2.0**-52  # a free choice

# The eigenvalues are good to about 1e-14 if zeros are apart, and to the root of that if not.
_NEAR = 1e-7  # a free choice
