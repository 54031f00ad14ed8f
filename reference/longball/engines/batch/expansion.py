"""The Taylor steps of sixteen flights at once, as machine code generated from a traced law.

The recurrence is that of `longball.engines.series`, here in LLVM's language for vectors of sixteen
doubles, in an order that keeps the multiply-add units busy. Lane k of a result depends on lane k of
the operands alone, each operation is rounded once by IEEE 754, and nothing is contracted or
reordered. The bits of a lane therefore do not depend on its neighbours.

Expansions are arrays of shape (blocks, order + 2, lanes); row k of a block belongs to the power k
of t. The first blocks are the rows of the recurrence, the variables before all others. `Layout`
says where the others are.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import binding, ir

from longball.engines.batch.writer import (
    INDEX,
    WIDTH,
    Code,
    Value,
    Values,
    Writer,
    aligned,
    once,
)
from longball.engines.series import recurrence, row_of
from longball.model.arrays import Array
from longball.model.trace import Node, Program, squares, variable

# Rows of the block `step`, after those of the state at the end of the step: its length, s, NaN if
# no ordinary step is possible; the time of its beginning, s; Kahan's compensation of that time, s;
# 1 if no event is possible within the step, else -1; the largest coordinate of the flight at any
# step; a bound on the change of each position. Then the compensation of each position at the
# beginning and at the end of the step.
LENGTH, TIME, TIME_COMPENSATION, CLEARANCE, FARTHEST, RANGES = range(6)

# Sums that one loop carries, of sixteen doubles each. With more, registers are spilled. AVX-512 has
# 32 of eight doubles: for spin, wind and drag crisis in space, one loop for all took 1.5 times as
# long, and limits of 8 to 12 sums as long as 10 within a tenth. Other processors have 16 of four:
# limits of 3 to 6 sums took a third less time than 10, with partial derivatives to expand.
MOST_CHAINS = 10 if binding.get_host_cpu_features().get("avx512f") else 5

NO_LIMIT = 1e300  # s, of a step; a free choice
# A step more than this many times longer than one with small last terms of the speed is cut to
# that. With usual forces no step is; derivatives by a force of 0 need the shorter one.
LONGER = 3.0


# An exponent of a drag crisis shows in the last terms up to twice the order less this.
CRISIS_SHOWS = 10


class Layout:
    """Positions of the blocks of an expansion, after the rows of the recurrence."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.parameters = len(recurrence(program).rows)  # a row each
        self.step = self.parameters + 1  # the state at the step's end, then LENGTH, TIME and so on
        self.inverse = self.parameters + 2  # 1/k in row k

    def allocate(self, order: int) -> Array:
        """Return an expansion of the velocity to the power `order`, of the position to the next."""
        parts = 3 * len(self.program.variables) + RANGES, len(self.program.parameters)
        powers = order + 2
        x = aligned(self.inverse + 1, max(powers, *parts), WIDTH)
        x[self.inverse, 1:powers] = 1.0 / np.arange(1, powers)[:, np.newaxis]
        return x


class _Step(Writer):
    """Writes a step: the expansion of a program, how far it holds, and the state at its end.

    The first argument is the array of the expansion, of whose blocks the first two integers are the
    order and the number of rows. The second one is an array of shape (functions, variables + 2,
    lanes): of linear functions of the state the coefficients, the constant, and the error. Their
    number is the third integer. The double is the truncation.
    """

    def __init__(self, module: Any, program: Program) -> None:
        super().__init__(module, "step")
        self.program, self.recurrence, self.layout = program, recurrence(program), Layout(program)
        self.array, self.functions = self.arrays
        self.order, self.stride, self.count, self.truncation = self.numbers
        self.variables = [*map(variable, program.variables)]
        self.rates = program.outputs[: len(self.variables)]
        moving = [*zip(self.variables, self.rates, strict=True)]
        self.positions = [name for name, rate in moving if rate.kind == "variable"]
        self.dynamic = [n for n in program.nodes if not n.static and n.kind != "variable"]
        self.blocks = {node: self.stride * i for i, node in enumerate(self.recurrence.rows)}
        self.inverse, self.step = (self.stride * i for i in (self.layout.inverse, self.layout.step))
        self.zeroth: Values = {}
        self.expand()
        length = self.choose_length([rate for _, rate in moving if rate.kind == "variable"])
        self.store_clearance(self.take(length))
        self.build.ret(self.index(0).code)

    def at(self, node: Node, k: Value | int) -> Value:
        """Return the coefficient k > 0 of a row."""
        return self.array[self.blocks[row_of(node)] + k]

    # --- the recurrence ---

    def expand(self) -> None:
        """Fill in the coefficients from those of t^0, as `longball.engines.series` prints it."""
        # order 0: the program, and what each order divides by
        place = {name: i for i, name in enumerate(self.program.parameters)}

        def given(node: Node) -> Value:
            if node.kind == "parameter":
                return self.array[self.stride * self.layout.parameters + place[node.args[0]]]
            return self.array[self.blocks[node]]

        nodes = dict.fromkeys((*self.variables, *self.program.nodes))
        self.evaluate(nodes, given, self.zeroth)
        self.inverses = {
            node: self.number(1.0) / self.zeroth[divisor]
            for node in self.dynamic
            if (divisor := self.recurrence.divisor(node)) is not None
        }
        # order 1 of the variables, then the other ones
        first = [self.zeroth[rate] for rate in self.rates]
        for name, start in zip(self.variables, first, strict=True):
            self.array[self.blocks[name] + 1] = start
        last = self.repeat(1, self.order, first, self.next_order)
        per_n = self.array[self.inverse + (self.order + 1)]
        known = dict(zip(self.variables, last, strict=True))
        for name, rate in zip(self.variables, self.rates, strict=True):
            if rate.kind == "variable":
                self.array[self.blocks[name] + (self.order + 1)] = known[rate] * per_n

    # A symmetric sum is taken by halves: of these nodes `halves` holds half the coefficient.

    def next_order(self, n: Value, coefficients: list[Value]) -> list[Value]:
        """From the coefficients n of the variables, return those of order n + 1."""
        sums = self.inner_sums(n)
        current: Values = dict(zip(self.variables, coefficients, strict=True))
        halves: Values = {}
        for node in self.dynamic:
            self.end(node, n, sums, current, halves)
            if node in self.blocks:
                self.array[self.blocks[node] + n] = self.whole(node, current, halves)
        per_n = self.array[self.inverse + (n + 1)]
        following = []
        for name, rate in zip(self.variables, self.rates, strict=True):
            value = self.number(0.0)
            if not rate.static:
                value = self.whole(rate, current, halves) * per_n
            self.array[self.blocks[name] + (n + 1)] = value
            following.append(value)
        return following

    def whole(self, node: Node, current: Values, halves: Values) -> Value:
        """Return a coefficient, doubling what is known by half."""
        if node not in current:
            current[node] = halves[node] + halves[node]
        return current[node]

    def inner_sums(self, n: Value) -> Values:
        """Return the sums over 1 … n-1: of pairs (j, n-j), symmetric ones by halves.

        They are taken in loops of a few sums, which share as many rows as they can.
        """
        rows = {
            node: factors
            for node in self.dynamic
            if (factors := self.recurrence.factors(node)) is not None
        }
        sums: Values = {}
        while rows:
            some: dict[Node, tuple[Node, Node]] = {}
            free = MOST_CHAINS
            while fitting := [node for node in rows if _chains(rows[node]) <= free]:
                loaded = {row_of(x) for factors in some.values() for x in factors}
                best = min(fitting, key=lambda node: len({*map(row_of, rows[node])} - loaded))
                some[best] = rows.pop(best)
                free -= _chains(some[best])
            sums |= self.sums_of_pairs(n, some)
        return sums

    def sums_of_pairs(self, n: Value, rows: dict[Node, tuple[Node, Node]]) -> Values:
        """Return sums over 1 … n-1 of the products of two rows, for each node, by one loop.

        The pairs go from the middle outwards, for the outermost need what was computed last.
        """
        count = (n - 1) >> 1

        def weighed(node: Node, order: Value, x: Value) -> Value:
            return self.spread(order) * x if node.kind in ("exp", "log") else x

        # two terms of each sum at a time, (j, n-j) and (n-j, j): two chains of additions, which the
        # processor does at once; of a product of equal rows the two are the same
        def pair(i: Value, totals: list[Value]) -> list[Value]:
            j = count - i
            k = n - j
            known: dict[tuple[Node, int], Value] = {}

            def at(node: Node, side: int) -> Value:
                key = row_of(node), side
                if key not in known:
                    known[key] = self.at(node, k if side else j)
                return known[key]

            coming, sums = iter(totals), []
            for node, (a, b) in rows.items():
                if a is b:
                    sums.append(self.fma(at(a, 0), at(a, 1), next(coming)))
                    continue
                for side, weight in ((0, j), (1, k)):
                    x = weighed(node, weight, at(a, side))
                    sums.append(self.fma(x, at(b, 1 - side), next(coming)))
            return sums

        chains = sum(map(_chains, rows.values()))
        coming = iter(self.repeat(0, count, [self.number(0.0)] * chains, pair))
        merged = [next(coming) if a is b else next(coming) + next(coming) for a, b in rows.values()]
        # the term in the middle, of even n alone: a loop of one round or none
        middle = n >> 1

        def central(_: Value, totals: list[Value]) -> list[Value]:
            sums = []
            for (node, (a, b)), total in zip(rows.items(), totals, strict=True):
                x = self.at(a, middle)
                if a is b:
                    sums.append(self.fma(x * 0.5, x, total))
                else:
                    x = weighed(node, middle, x)
                    sums.append(self.fma(x, self.at(b, middle), total))
            return sums

        return dict(zip(rows, self.repeat(n & 1, 1, merged, central), strict=True))

    def end(self, node: Node, n: Value, sums: Values, current: Values, halves: Values) -> None:
        """Write the coefficient n of a node, or half of it."""
        zeroth, first = self.zeroth, node.args[0]

        def of(x: Node) -> Value:
            return self.number(0.0) if x.static else self.whole(x, current, halves)

        match node.kind:
            case "sum":
                ones = all(c.kind == "constant" and c.args[0] == 1.0 for c, _ in node.args[1:])
                if ones and all(x in halves for _, x in node.args[1:]):
                    halves[node] = self.combination(node, halves, zeroth)
                else:
                    values = {x: of(x) for _, x in node.args[1:]}
                    current[node] = self.combination(node, values, zeroth)
            case "product":
                a, b = node.args
                if a is b:
                    halves[node] = self.fma(zeroth[a], of(a), sums[node])
                else:
                    # Variables come first among factors, and are known before what depends on them.
                    early = self.fma(zeroth[b], of(a), sums[node])
                    current[node] = self.fma(of(b), zeroth[a], early)
            case "quotient":
                a, b = node.args
                rest = self.fma(of(b), zeroth[node], sums[node])
                current[node] = (of(a) - rest) * self.inverses[node]
            case "sqrt":
                half = halves[first] if first in halves else of(first) * 0.5
                current[node] = (half - sums[node]) * self.inverses[node]
            case "exp":
                inner = sums[node] * self.array[self.inverse + n]
                current[node] = self.fma(of(first), zeroth[node], inner)
            case "log":
                inner = sums[node] * self.array[self.inverse + n]
                current[node] = (of(first) - inner) * self.inverses[node]

    # --- the step ---

    def larger(self, values: list[Value]) -> Value:
        """Return the largest absolute value."""
        first, *others = (self.call("fabs", value) for value in values)
        for size in others:
            first = (size > first).select(size, first)
        return first

    def choose_length(self, velocities: list[Node]) -> Value:
        """Choose the length: the last two terms of the velocity stay below `truncation` times V.

        A second bound keeps the roots of sums of squares analytic. Such a sum q_0 + q_1 t + q_2 t²
        has its complex zeros near √(q_0/q_2) from a minimum, and a step stays within half of that.
        A third one bounds the last term of these roots, which are speeds. Where the air hardly
        pushes the ball, the series of the velocity nearly ends and theirs does not; the path along
        which spin decays and derivatives by the forces depend on them.
        A fourth one is that of `longball.engines.reach.reach_of_crisis`.

        The length is NaN where no ordinary step is possible. On a vertical flight only one of the
        squares does not vanish, and the root has a corner where that falls to zero. Near rest the
        coefficients overflow, or those of second derivatives, up to order² times as large. Nor is
        one possible where an output behind the rates is not above zero: there the law ends.
        """
        # truncation: |x_N| t^N and |x_(N-1)| t^(N-1) are at most `allowed`
        square = self.number(0.0)
        for x in [self.zeroth[name] for name in velocities]:
            square = self.fma(x, x, square)
        allowed = self.spread(self.truncation) * self.call("sqrt", square)
        before = self.order - 1
        lengths = []
        total = self.number(0.0)
        for power in (self.order, before):
            last = [self.at(name, power) for name in velocities]
            lengths.append(self.root(allowed / self.larger(last), power))
            for x in last:
                total = total + self.call("fabs", x)
        length = (lengths[0] < lengths[1]).select(*lengths)
        # overflow: the last terms stay finite, and so do derivatives of second order of them
        order = self.spread(self.order)
        ordinary = total * order * order * order < math.inf
        # the roots: within half the distance of their singularities, and with small last terms
        has_path = len(self.variables) > len(self.positions) + len(velocities)
        longer = self.number(1.0 if has_path else LONGER)
        for node in self.recurrence.roots:
            curvature = self.number(0.0)
            # the lanes in which some square moves, and several
            some = several = curvature.differs(0.0)
            for p in squares(node.args[0]):
                p0, p1 = self.zeroth[p], self.at(p, 1)
                curvature = self.fma(p1, p1, curvature)
                curvature = self.fma(p0 + p0, self.at(p, 2), curvature)
                moves = self.larger([p0, p1]).differs(0.0)
                several = several | (some & moves)
                some = some | moves
            half = self.zeroth[node] * 0.5
            limit = half / self.call("sqrt", self.call("fabs", curvature))
            ordinary = ordinary & several
            size = self.call("fabs", self.at(node, before))
            term = self.root(allowed / size, before)
            length = (longer * term < length).select(term, length)
            length = (limit < length).select(limit, length)
        # the crises of drag: a series shows nothing of one that is far
        near = self.spread(self.order * 2 - CRISIS_SHOWS)
        for exponent in self.recurrence.crises:
            room = (self.call("fabs", self.zeroth[exponent]) - near) * 0.5
            rate, bend = (self.call("fabs", self.at(exponent, k)) for k in (1, 2))
            for limit in (room / rate, self.call("sqrt", room / bend)):
                length = ((room > 1.0) & (limit < length)).select(limit, length)
        # the law: not where it ends
        for guard in self.program.outputs[len(self.variables) :]:
            ordinary = ordinary & (self.zeroth[guard] > 0.0)
        length = ordinary.select(length, self.number(math.nan))
        self.array[self.step + (len(self.variables) + LENGTH)] = length
        return length

    def root(self, x: Value, n: Value) -> Value:
        """Return a lower estimate of the n-th root, good to a tenth: all that a step needs.

        The logarithm of a double to base 2, times 2^52, is its bits read as an integer, up to a
        constant and to within 2^52 / 11: the mantissa approximates the fraction of the logarithm.
        Reading the root back from its bits makes it at most 1 / 0.94 times too long.
        """
        integers = ir.VectorType(INDEX, WIDTH)
        one = Value(self.build, ir.Constant(integers, [1023 << 52] * WIDTH))
        logarithm = (x.to("bitcast", integers) - one).to("sitofp", self.type)
        part = logarithm / self.spread(n) + one.to("sitofp", self.type)
        root = part.to("fptosi", integers).to("bitcast", self.type)
        return (x < NO_LIMIT).select(root * 0.94, self.number(NO_LIMIT))

    def take(self, length: Value) -> dict[Node, Value]:
        """Sum the series; return how far each position can get from its start on the way.

        What rounding takes from a position is made up for at the next step (Kahan): a feather's
        thousand short steps would all be rounded to the same side.
        """
        sizes = self.call("fabs", length)

        def upper(name: Node, k: Value) -> Value:
            """Return the coefficient of t^k of a velocity, or of t^(k+1) of a position."""
            return self.at(name, k + 1 if name in self.positions else k)

        def term(k: Value, totals: list[Value]) -> list[Value]:
            down = self.order - 1 - k
            coefficients = {name: upper(name, down) for name in self.variables}
            sums = [
                self.fma(total, length, coefficients[name])
                for name, total in zip(self.variables, totals, strict=False)
            ]
            bounds = [
                self.fma(total, sizes, self.call("fabs", coefficients[name]))
                for name, total in zip(self.positions, totals[len(sums) :], strict=True)
            ]
            return sums + bounds

        # by Horner's rule, values and bounds in one loop, as they load the same coefficients
        begin = [upper(name, self.order) for name in self.variables]
        begin += [self.call("fabs", upper(name, self.order)) for name in self.positions]
        totals = self.repeat(0, self.order, begin, term)
        # of a position, x(0) is added last: that is the sum with Kahan's compensation
        compensations = len(self.variables) + RANGES + len(self.positions)
        for i, (name, total) in enumerate(zip(self.variables, totals, strict=False)):
            if name in self.positions:
                row, start = self.step + (compensations + i), self.zeroth[name]
                change = self.fma(total, length, self.array[row])
                total = start + change
                taken = total - start
                left = (start - (total - taken)) + (change - taken)
                self.array[row + len(self.positions)] = left
            self.array[self.step + i] = total
        ranges = {}
        for i, name in enumerate(self.positions):
            ranges[name] = totals[len(self.variables) + i] * sizes
            self.array[self.step + (len(self.variables) + RANGES + i)] = ranges[name]
        return ranges

    def store_clearance(self, ranges: dict[Node, Value]) -> None:
        """Write 1 where every linear function certainly stays above its error, -1 elsewhere."""
        size = len(self.variables) + 2
        clear, touched = self.number(1.0), self.number(-1.0)

        def nearest(e: Value, totals: list[Value]) -> list[Value]:
            first, (total,) = e * size, totals
            *slopes, constant, error = (self.functions[first + i] for i in range(size))
            least = constant - error
            for name, slope in zip(self.variables, slopes, strict=True):
                if name in ranges:
                    least = self.fma(slope, self.zeroth[name], least)
                    least = least - self.call("fabs", slope) * ranges[name]
                else:
                    total = slope.equals(0.0).select(total, touched)
            return [(least > 0.0).select(total, touched)]

        (result,) = self.repeat(0, self.count, [clear], nearest)
        self.array[self.step + (len(self.variables) + CLEARANCE)] = result


def _chains(factors: tuple[Node, Node]) -> int:
    """Return the number of partial sums of a product of two rows; a symmetric one needs half."""
    a, b = factors
    return 1 if a is b else 2


@once
def step(program: Program) -> Code:
    """Return the compiled step of a law: of (x, functions, order, stride, count, truncation).

    The stride is the number of rows of a block.
    """
    return Code("step", program, lambda module: _Step(module, program))
