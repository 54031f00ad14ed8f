"""The Taylor steps of sixteen flights at once, as machine code made from a traced law.

The recurrence is that of `longball.engines.series`; here it is written in LLVM's language, on
vectors of sixteen doubles, in an order that keeps the multiply-add units busy. Lane k of a result
depends on lane k of the operands alone, each operation is rounded once as IEEE 754 says, and
nothing is contracted or reordered, so a lane's bits are the same whatever its neighbours hold.

Expansions are arrays of shape (blocks, order + 2, lanes); row k of a block belongs to the power k
of t. The first blocks are the rows of the recurrence, the variables before all others. `Layout`
says where the others are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from threading import Lock
from typing import Any

import numpy as np
from llvmlite import binding, ir

from longball.engines.compiled import stored
from longball.engines.series import recurrence, row_of
from longball.model.arrays import Array
from longball.model.trace import ZERO, Node, Program, squares, variable

Value = Any  # of LLVM: a number in each lane
Values = dict[Node, Value]

# Two registers of eight doubles hide the latency of a fused multiply-add where there is AVX-512;
# elsewhere sixteen are spread over more registers, at no loss against eight.
WIDTH = 16

# Rows of the block `step`, after those of the state at the end of the step: how long it is, s, NaN
# where no ordinary step is possible; when it begins, s; what rounding has taken from that time, s;
# 1 where nothing can happen on the way, else -1; the largest coordinate that the flight has had at
# a step; how far each position can get from where it was. Then what rounding takes from each
# position: at the beginning of the step, and at its end.
LENGTH, TIME, TIME_LOST, CLEARANCE, FARTHEST, RANGES = range(6)

# Sums that one loop carries, of sixteen doubles each. With more, registers are spilled. AVX-512 has
# 32 of eight doubles: for spin, wind and drag crisis in space, one loop for all took 1.5 times as
# long, and limits of 8 to 12 sums as long as 10 within a tenth. Other processors have 16 of four:
# limits of 3 to 6 sums took a third less time than 10, with partial derivatives to expand.
MOST_CHAINS = 10 if binding.get_host_cpu_features().get("avx512f") else 5

NO_LIMIT = 1e300  # s, of a step

# Orders that tangents of a law with an exponential or a logarithm are expanded beyond the state.
# Its last terms choose the step, and those of a tangent are larger: with a singularity at
# the distance r, term n of the state goes as r^-n, and its derivative as n r^-(n+1). A step stays
# within half the distance of the singularities of roots, but of no others. Over the golden scenes
# tangents of a drag crisis and of a logarithmic wind are off by up to 1.2e-11, relative, without
# these orders, each of which makes that a third; those of all other laws by up to 3e-13.
FURTHER = 4


@dataclass(frozen=True)
class Layout:
    """Which block of an expansion holds what, after the rows of the recurrence."""

    program: Program

    @property
    def parameters(self) -> int:
        """Block of the parameters, a row each."""
        return len(recurrence(self.program).rows)

    @property
    def step(self) -> int:
        """Block of the step: the state at its end, then LENGTH, TIME and so on."""
        return self.parameters + 1

    @property
    def inverse(self) -> int:
        """Block whose row k is 1/k."""
        return self.parameters + 2

    @property
    def partials(self) -> dict[Node, int]:
        """Blocks of the rates' partial derivatives, of a program of `with_partials`."""
        found = self.program.outputs[len(self.program.variables) :]
        nodes = dict.fromkeys(node for node in found if node is not ZERO)
        return {node: self.inverse + 1 + i for i, node in enumerate(nodes)}

    @property
    def further(self) -> int:
        """Number of orders that are expanded beyond those of the state; see `FURTHER`."""
        kinds = {node.kind for node in self.program.nodes} if self.partials else set()
        return FURTHER if kinds & {"exp", "log"} else 0

    def allocate(self, order: int) -> Array:
        """Return an expansion of the velocity to the power `order`, of the position to the next."""
        parts = 3 * len(self.program.variables) + RANGES, len(self.program.parameters)
        powers = order + self.further + 2
        x = aligned(self.inverse + 1 + len(self.partials), max(powers, *parts), WIDTH)
        x[self.inverse, 1:powers] = 1.0 / np.arange(1, powers)[:, np.newaxis]
        return x


def aligned(*shape: int) -> Array:
    """Return zeros that begin on a cache line."""
    cache_line = 64  # bytes
    size = math.prod(shape)
    memory = np.zeros(size + cache_line // 8)
    skip = (-memory.ctypes.data % cache_line) // 8
    return memory[skip : skip + size].reshape(*shape)


# --- code on lanes --------------------------------------------------------------------------------

_INDEX = ir.IntType(64)
_DOUBLE = ir.DoubleType()


class _Writer:
    """Writes a function whose values are a double in each of some lanes.

    Its arguments are two pointers to arrays of lanes, three integers and a double.
    """

    def __init__(self, module: Any, name: str, lanes: int = WIDTH) -> None:
        self.lanes = lanes
        self.type = ir.VectorType(_DOUBLE, lanes)
        arguments = [self.type.as_pointer()] * 2 + [_INDEX] * 3 + [_DOUBLE]
        self.function = ir.Function(module, ir.FunctionType(_INDEX, arguments), name)
        self.arguments = self.function.args
        self.builder = build = ir.IRBuilder(self.function.append_basic_block())
        self.add, self.subtract = build.fadd, build.fsub
        self.multiply, self.divide = build.fmul, build.fdiv

    def number(self, value: float) -> Value:
        """Return a number, the same in every lane."""
        return ir.Constant(self.type, [ir.Constant(_DOUBLE, value)] * self.lanes)

    def spread(self, scalar: Value) -> Value:
        """Return a double or an integer in every lane."""
        if scalar.type == _INDEX:
            scalar = self.builder.sitofp(scalar, _DOUBLE)
        nothing = ir.Constant(self.type, ir.Undefined)
        first = self.builder.insert_element(nothing, scalar, ir.Constant(ir.IntType(32), 0))
        every = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), [0] * self.lanes)
        return self.builder.shuffle_vector(first, nothing, every)

    def index(self, value: int) -> Value:
        """Return an integer that indexes rows."""
        return ir.Constant(_INDEX, value)

    def load(self, array: Value, index: Value) -> Value:
        """Return a row of an array."""
        return self.builder.load(self.builder.gep(array, [index]), align=8)

    def store(self, array: Value, index: Value, value: Value) -> None:
        """Write a row of an array."""
        self.builder.store(value, self.builder.gep(array, [index]), align=8)

    def call(self, name: str, *arguments: Value) -> Value:
        """Call a function of LLVM: fma, sqrt, exp, log, fabs."""
        shape = ir.FunctionType(self.type, [self.type] * len(arguments))
        full = f"llvm.{name}.v{self.lanes}f64"
        known = self.function.module.globals
        function = known[full] if full in known else ir.Function(self.function.module, shape, full)
        return self.builder.call(function, arguments)

    def fma(self, a: Value, b: Value, c: Value) -> Value:
        """Return ``a b + c``, rounded once."""
        return self.call("fma", a, b, c)

    def choose(self, a: Value, comparison: str, b: Value, yes: Value, no: Value) -> Value:
        """Return `yes` in the lanes where a comparison holds, else `no`; it fails for NaN."""
        return self.builder.select(self.builder.fcmp_ordered(comparison, a, b), yes, no)

    def repeat(
        self,
        begin: Value,
        end: Value,
        carried: Sequence[Value],
        body: Callable[[Value, list[Value]], Sequence[Value]],
    ) -> list[Value]:
        """Write a loop over i from `begin` to below `end`.

        `body` takes i and the carried values, and returns those for the next i.
        """
        build, entry = self.builder, self.builder.block
        head, inside, after = (self.function.append_basic_block() for _ in range(3))
        build.branch(head)
        build.position_at_end(head)
        i = build.phi(_INDEX)
        i.add_incoming(begin, entry)
        values = [build.phi(value.type) for value in carried]
        for phi, value in zip(values, carried, strict=True):
            phi.add_incoming(value, entry)
        build.cbranch(build.icmp_signed("<", i, end), inside, after)
        build.position_at_end(inside)
        for phi, value in zip(values, body(i, values), strict=True):
            phi.add_incoming(value, build.block)
        i.add_incoming(build.add(i, self.index(1)), build.block)
        build.branch(head)
        build.position_at_end(after)
        return values


# --- the recurrence -------------------------------------------------------------------------------


class _Expansion(_Writer):
    """Writes the expansion of a program, as `longball.engines.series` prints it for numbers.

    The first argument is the array of the expansion, the first integers are the order and the
    number of rows of a block.
    """

    def __init__(self, module: Any, name: str, program: Program) -> None:
        super().__init__(module, name)
        self.program = program
        self.recurrence = recurrence(program)
        self.layout = Layout(program)
        self.array, _, self.order, self.stride, *_ = self.arguments
        self.dynamic = [n for n in program.nodes if not n.static and n.kind != "variable"]
        self.blocks = {
            node: self.builder.mul(self.index(i), self.stride)
            for i, node in enumerate(self.recurrence.rows)
        }
        self.zeroth: Values = {}

    def at(self, node: Node, k: Value) -> Value:
        """Return the coefficient k > 0 of a row."""
        return self.load(self.array, self.builder.add(self.blocks[row_of(node)], k))

    def put(self, node: Node, k: Value, value: Value) -> None:
        """Write the coefficient k of a node that has a row."""
        self.store(self.array, self.builder.add(self.blocks[node], k), value)

    def extra(self, block: int, row: Value | int) -> Value:
        """Return a row of a block after those of the recurrence."""
        row = self.index(row) if isinstance(row, int) else row
        start = self.builder.mul(self.index(block), self.stride)
        return self.load(self.array, self.builder.add(start, row))

    def after(self, k: Value) -> Value:
        """Return ``k + 1``."""
        return self.builder.add(k, self.index(1))

    @property
    def outputs(self) -> list[tuple[Node, Node]]:
        """The variables and their rates."""
        return list(zip(map(variable, self.program.variables), self.program.outputs, strict=False))

    def keep(self, node: Node, k: Value, value: Value) -> None:
        """Write the coefficient k of a partial derivative."""
        start = self.builder.mul(self.index(self.layout.partials[node]), self.stride)
        self.store(self.array, self.builder.add(start, k), value)

    def expand(self) -> None:
        """Fill in the coefficients from those of t^0."""
        self.order_zero()
        for node in self.layout.partials:
            self.keep(node, self.index(0), self.zeroth[node])
        first = [self.zeroth[rate] for _, rate in self.outputs]
        for (name, _), rate in zip(self.outputs, first, strict=True):
            self.put(name, self.index(1), rate)
        order = self.builder.add(self.order, self.index(self.layout.further))
        last = self.repeat(self.index(1), order, first, self.next_order)
        per_n = self.extra(self.layout.inverse, self.after(order))
        known = dict(zip((name for name, _ in self.outputs), last, strict=True))
        for name, rate in self.outputs:
            if rate.kind == "variable":
                self.put(name, self.after(order), self.multiply(known[rate], per_n))

    def order_zero(self) -> None:
        """Evaluate the program, and what each order divides by."""
        place = {name: i for i, name in enumerate(self.program.parameters)}
        state = (name for name, _ in self.outputs)
        for node in dict.fromkeys((*state, *self.program.nodes)):
            self.zeroth[node] = self.value(node, place)
        self.inverses = {
            node: self.divide(self.number(1.0), self.zeroth[divisor])
            for node in self.dynamic
            if (divisor := _divisor(node)) is not None
        }

    def value(self, node: Node, place: dict[str, int]) -> Value:
        """Return the value of a node at t = 0, from those of the nodes before it."""
        match node.kind:
            case "constant":
                return self.number(node.args[0])
            case "parameter":
                return self.extra(self.layout.parameters, place[node.args[0]])
            case "variable":
                return self.load(self.array, self.blocks[node])
            case "sum":
                value = self.combination(node, self.zeroth)
                rest = node.args[0]
                zero = rest.kind == "constant" and rest.args[0] == 0.0
                return value if zero else self.add(value, self.zeroth[rest])
            case "plus":
                return self.add(*(self.zeroth[x] for x in node.args))
            case "product":
                return self.multiply(*(self.zeroth[x] for x in node.args))
            case "quotient":
                return self.divide(*(self.zeroth[x] for x in node.args))
            case _:
                return self.call(node.kind, self.zeroth[node.args[0]])

    def combination(self, node: Node, values: Values) -> Value:
        """Return a sum without its constant."""
        total = None
        for coefficient, x in node.args[1:]:
            known = coefficient.args[0] if coefficient.kind == "constant" else None
            if known == 1.0:
                total = values[x] if total is None else self.add(total, values[x])
            elif total is None:
                total = self.multiply(self.zeroth[coefficient], values[x])
            else:
                total = self.fma(self.zeroth[coefficient], values[x], total)
        return total

    # A symmetric sum is taken by halves: of these nodes `halves` holds half the coefficient.

    def next_order(self, n: Value, coefficients: list[Value]) -> list[Value]:
        """From the coefficients n of the variables, return those of order n + 1."""
        sums = self.inner_sums(n)
        names = [name for name, _ in self.outputs]
        current: Values = dict(zip(names, coefficients, strict=True))
        halves: Values = {}
        for node in self.dynamic:
            self.end(node, n, sums, current, halves)
            if node in self.blocks:
                self.put(node, n, self.whole(node, current, halves))
        for node in self.layout.partials:
            if not node.static:  # of the others there is but the first
                self.keep(node, n, self.whole(node, current, halves))
        per_n = self.extra(self.layout.inverse, self.after(n))
        following = []
        for name, rate in self.outputs:
            value = self.number(0.0)
            if not rate.static:
                value = self.multiply(self.whole(rate, current, halves), per_n)
            self.put(name, self.after(n), value)
            following.append(value)
        return following

    def whole(self, node: Node, current: Values, halves: Values) -> Value:
        """Return a coefficient, doubling what is known by half."""
        if node not in current:
            current[node] = self.add(halves[node], halves[node])
        return current[node]

    def inner_sums(self, n: Value) -> Values:
        """Return the sums over 1 … n-1: of pairs (j, n-j), symmetric ones by halves."""
        rows = {
            node: factors
            for node in self.dynamic
            if (factors := self.recurrence.factors(node)) is not None
        }
        return {
            node: total
            for some in _in_loops(rows)
            for node, total in self.sums_of_pairs(n, some).items()
        }

    def sums_of_pairs(self, n: Value, rows: dict[Node, tuple[Node, Node]]) -> Values:
        """Return sums over 1 … n-1 of the products of two rows, for each node, by one loop.

        The pairs go from the middle outwards, for the outermost need what was computed last.
        """
        build = self.builder
        count = build.ashr(build.sub(n, self.index(1)), self.index(1))

        def pair(i: Value, totals: list[Value]) -> list[Value]:
            j = build.sub(count, i)
            k = build.sub(n, j)
            known: dict[tuple[Node, int], Value] = {}

            def at(node: Node, side: int) -> Value:
                key = row_of(node), side
                if key not in known:
                    known[key] = self.at(node, k if side else j)
                return known[key]

            coming = iter(totals)
            found = []
            for node, (a, b) in rows.items():
                if a is b:
                    found.append(self.fma(at(a, 0), at(a, 1), next(coming)))
                    continue
                for side, weight in ((0, j), (1, k)):
                    x = at(a, side)
                    if node.kind in ("exp", "log"):
                        x = self.multiply(self.spread(weight), x)
                    found.append(self.fma(x, at(b, 1 - side), next(coming)))
            return found

        chains = sum(map(_chains, rows.values()))
        totals = self.repeat(self.index(0), count, [self.number(0.0)] * chains, pair)
        coming = iter(totals)
        merged = [
            next(coming) if a is b else self.add(next(coming), next(coming))
            for a, b in rows.values()
        ]
        middle = build.ashr(n, self.index(1))

        def central(_: Value, totals: list[Value]) -> list[Value]:
            found = []
            for (node, (a, b)), total in zip(rows.items(), totals, strict=True):
                x = self.at(a, middle)
                if a is b:
                    found.append(self.fma(self.multiply(self.number(0.5), x), x, total))
                    continue
                if node.kind in ("exp", "log"):
                    x = self.multiply(self.spread(middle), x)
                found.append(self.fma(x, self.at(b, middle), total))
            return found

        odd = build.and_(n, self.index(1))
        return dict(zip(rows, self.repeat(odd, self.index(1), merged, central), strict=True))

    def end(self, node: Node, n: Value, sums: Values, current: Values, halves: Values) -> None:
        """Write the coefficient n of a node, or half of it."""
        zeroth = self.zeroth

        def of(x: Node) -> Value:
            return self.number(0.0) if x.static else self.whole(x, current, halves)

        match node.kind:
            case "sum":
                ones = all(c.kind == "constant" and c.args[0] == 1.0 for c, _ in node.args[1:])
                if ones and all(x in halves for _, x in node.args[1:]):
                    halves[node] = self.combination(node, halves)
                else:
                    values = {x: of(x) for _, x in node.args[1:]}
                    current[node] = self.combination(node, values)
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
                current[node] = self.multiply(self.subtract(of(a), rest), self.inverses[node])
            case "sqrt":
                (a,) = node.args
                half = halves.get(a)
                if half is None:
                    half = self.multiply(self.number(0.5), of(a))
                current[node] = self.multiply(self.subtract(half, sums[node]), self.inverses[node])
            case "exp":
                (a,) = node.args
                inner = self.multiply(sums[node], self.extra(self.layout.inverse, n))
                current[node] = self.fma(of(a), zeroth[node], inner)
            case "log":
                (a,) = node.args
                inner = self.multiply(sums[node], self.extra(self.layout.inverse, n))
                current[node] = self.multiply(self.subtract(of(a), inner), self.inverses[node])


def _chains(factors: tuple[Node, Node]) -> int:
    """Return the number of partial sums of a product of two rows; a symmetric one needs half."""
    a, b = factors
    return 1 if a is b else 2


def _in_loops(rows: dict[Node, tuple[Node, Node]]) -> Iterator[dict[Node, tuple[Node, Node]]]:
    """Yield the products of rows in groups, a loop each, that share as many rows as they can."""
    left = dict(rows)
    while left:
        some: dict[Node, tuple[Node, Node]] = {}
        free = MOST_CHAINS
        while fitting := [node for node in left if _chains(left[node]) <= free]:
            loaded = {row_of(x) for factors in some.values() for x in factors}
            best = min(fitting, key=lambda node: len({*map(row_of, left[node])} - loaded))
            some[best] = left.pop(best)
            free -= _chains(some[best])
        yield some


def _divisor(node: Node) -> Node | None:
    """Return by what the coefficients of a node are divided, at t = 0."""
    divisors: dict[str, Node] = {"quotient": node.args[-1], "sqrt": node, "log": node.args[0]}
    return divisors.get(node.kind)


# --- the step -------------------------------------------------------------------------------------


class _Step(_Expansion):
    """Writes a step: the expansion, how far it holds, and the state at its end.

    The second argument is an array of shape (functions, variables + 2, lanes): of linear functions
    of the state the coefficients, the constant, and the error. Their number is the third integer.
    """

    def __init__(self, module: Any, program: Program) -> None:
        super().__init__(module, "step", program)
        self.expand()
        self.variables = [name for name, _ in self.outputs]
        self.positions = [name for name, rate in self.outputs if rate.kind == "variable"]
        velocities = [name for name in self.variables if name not in self.positions]
        length = self.choose_length(velocities)
        ranges = self.take(length)
        self.tell_clearance(ranges)
        self.builder.ret(self.index(0))

    def step_row(self, row: int) -> Value:
        """Return where a row of the block of the step is."""
        start = self.builder.mul(self.index(self.layout.step), self.stride)
        return self.builder.add(start, self.index(row))

    def put_step(self, row: int, value: Value) -> None:
        """Write a row of the block of the step."""
        self.store(self.array, self.step_row(row), value)

    def larger(self, values: list[Value]) -> Value:
        """Return the largest absolute value."""
        largest = self.call("fabs", values[0])
        for value in values[1:]:
            size = self.call("fabs", value)
            largest = self.choose(size, ">", largest, size, largest)
        return largest

    def choose_length(self, velocities: list[Node]) -> Value:
        """Choose the length: the last two terms of the velocity stay below `truncation` times V.

        A second bound keeps the roots of sums of squares analytic. Such a sum q_0 + q_1 t + q_2 t²
        has its complex zeros near √(q_0/q_2) from a minimum, and a step stays within half of that.
        It is not needed where the series ends.

        The length is NaN where no ordinary step is possible. On a vertical flight only one of the
        squares does not vanish, and the root has a corner where that falls to zero. Near rest the
        coefficients overflow, or those of second derivatives, up to order² times as large.
        """
        start = [self.zeroth[name] for name in velocities]
        square = self.number(0.0)
        for x in start:
            square = self.fma(x, x, square)
        allowed = self.multiply(self.spread(self.arguments[-1]), self.call("sqrt", square))
        before = self.builder.sub(self.order, self.index(1))
        lengths = []
        total = self.number(0.0)
        for power in (self.order, before):
            last = [self.at(name, power) for name in velocities]
            lengths.append(self.root(self.divide(allowed, self.larger(last)), power))
            for x in last:
                total = self.add(total, self.call("fabs", x))
        length = self.choose(lengths[0], "<", lengths[1], *lengths)
        order = self.spread(self.order)
        for _ in range(3):
            total = self.multiply(total, order)
        ordinary = self.builder.fcmp_ordered("<", total, self.number(math.inf))
        ends = self.builder.fcmp_ordered(">=", length, self.number(NO_LIMIT))
        for node in self.recurrence.roots:
            apart, limit = self.distance_to_zero(node)
            ordinary = self.builder.and_(ordinary, self.builder.or_(apart, ends))
            shorter = self.choose(limit, "<", length, limit, length)
            length = self.builder.select(ends, length, shorter)
        length = self.builder.select(ordinary, length, self.number(math.nan))
        self.put_step(len(self.variables) + LENGTH, length)
        return length

    def distance_to_zero(self, node: Node) -> tuple[Value, Value]:
        """Return where two squares or more do not vanish, and half the distance to the zeros."""
        one, two = self.index(1), self.index(2)
        bend, zero = self.number(0.0), self.number(0.0)
        none = ir.Constant(ir.VectorType(ir.IntType(1), WIDTH), [0] * WIDTH)
        some, several = none, none
        for p in squares(node.args[0]):
            p0, p1 = self.zeroth[p], self.at(p, one)
            bend = self.fma(p1, p1, bend)
            bend = self.fma(self.add(p0, p0), self.at(p, two), bend)
            moves = self.builder.fcmp_unordered("!=", self.larger([p0, p1]), zero)
            several = self.builder.or_(several, self.builder.and_(some, moves))
            some = self.builder.or_(some, moves)
        half = self.multiply(self.number(0.5), self.zeroth[node])
        return several, self.divide(half, self.call("sqrt", self.call("fabs", bend)))

    def root(self, x: Value, n: Value) -> Value:
        """Return a lower estimate of the n-th root, good to a tenth: all that a step needs.

        The logarithm of a double to base 2, times 2^52, is its bits read as an integer, but for a
        constant and to within 2^52 / 11: the mantissa stands for the fraction of the logarithm.
        Reading the root back from its bits makes it at most 1 / 0.94 times too long.
        """
        build = self.builder
        integers = ir.VectorType(_INDEX, WIDTH)
        one = ir.Constant(integers, [1023 << 52] * WIDTH)
        logarithm = build.sitofp(build.sub(build.bitcast(x, integers), one), self.type)
        part = self.add(self.divide(logarithm, self.spread(n)), build.sitofp(one, self.type))
        root = build.bitcast(build.fptosi(part, integers), self.type)
        limit = self.number(NO_LIMIT)
        return self.choose(x, "<", limit, self.multiply(self.number(0.94), root), limit)

    def take(self, length: Value) -> dict[Node, Value]:
        """Sum the series; return how far each position can get from its start on the way.

        What rounding takes from a position is made up for at the next step (Kahan): a feather's
        thousand short steps would all be rounded to the same side.
        """
        last = self.after(self.order)
        names = [*self.variables, *self.positions]
        sizes = self.call("fabs", length)

        def upper(name: Node, k: Value) -> Value:
            """Return the coefficient of t^k of a velocity, or of t^(k+1) of a position."""
            return self.at(name, self.after(k) if name in self.positions else k)

        def term(k: Value, totals: list[Value]) -> list[Value]:
            down = self.builder.sub(self.builder.sub(self.order, self.index(1)), k)
            found = {name: upper(name, down) for name in self.variables}
            sums = [
                self.fma(total, length, found[name])
                for name, total in zip(self.variables, totals, strict=False)
            ]
            bounds = [
                self.fma(total, sizes, self.call("fabs", found[name]))
                for name, total in zip(self.positions, totals[len(sums) :], strict=True)
            ]
            return sums + bounds

        begin = [upper(name, self.order) for name in self.variables]
        begin += [self.call("fabs", self.at(name, last)) for name in self.positions]
        totals = self.repeat(self.index(0), self.order, begin, term)
        for i, (name, total) in enumerate(zip(names, totals, strict=True)):
            if i < len(self.variables):
                if name in self.positions:
                    total = self.moved(i, self.zeroth[name], total, length)
                self.put_step(i, total)
        ranges = {}
        for i, name in enumerate(self.positions):
            ranges[name] = self.multiply(totals[len(self.variables) + i], sizes)
            self.put_step(len(self.variables) + RANGES + i, ranges[name])
        return ranges

    def moved(self, i: int, start: Value, rate: Value, length: Value) -> Value:
        """Return the i-th position at the end of the step; write what rounding takes from it."""
        lost = len(self.variables) + RANGES + len(self.positions) + i
        change = self.fma(rate, length, self.load(self.array, self.step_row(lost)))
        end = self.add(start, change)
        taken = self.subtract(end, start)
        left = self.subtract(start, self.subtract(end, taken))
        left = self.add(left, self.subtract(change, taken))
        self.put_step(lost + len(self.positions), left)
        return end

    def tell_clearance(self, ranges: dict[Node, Value]) -> None:
        """Write 1 where every linear function certainly stays above its error, -1 elsewhere."""
        functions, count = self.arguments[1], self.arguments[4]
        size = self.index(len(self.variables) + 2)
        clear, touched, zero = (self.number(value) for value in (1.0, -1.0, 0.0))

        def nearest(e: Value, totals: list[Value]) -> list[Value]:
            first = self.builder.mul(e, size)

            def part(i: int) -> Value:
                return self.load(functions, self.builder.add(first, self.index(i)))

            least = self.subtract(part(len(self.variables)), part(len(self.variables) + 1))
            total = totals[0]
            for i, name in enumerate(self.variables):
                slope = part(i)
                if name in ranges:
                    least = self.fma(slope, self.zeroth[name], least)
                    reach = self.call("fabs", slope)
                    least = self.subtract(least, self.multiply(reach, ranges[name]))
                else:
                    total = self.choose(slope, "==", zero, total, touched)
            return [self.choose(least, ">", zero, total, touched)]

        (result,) = self.repeat(self.index(0), count, [clear], nearest)
        self.put_step(len(self.variables) + CLEARANCE, result)


# --- tangents -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tangents:
    """Layout of an array with the tangents of the flights in the lanes.

    A tangent is the derivative ξ of the state by a number x, which the strengths p of the law may
    depend on: ``ξ' = (∂f/∂state) ξ + (∂f/∂p) dp/dx``.
    """

    program: Program  # of `with_partials`

    @property
    def sources(self) -> int:
        """Number of the variables and parameters."""
        return len(self.program.variables) + len(self.program.parameters)

    def first(self, rows: int) -> int:
        """Row of the first tangent, after `TIMES` and the series of two."""
        return TIMES + 2 * len(self.program.variables) * rows

    @property
    def size(self) -> int:
        """Rows of one: dp/dx; ξ at the end of the step; and at the other times, in order."""
        return len(self.program.parameters) + TIMES * len(self.program.variables)

    def allocate(self, count: int, rows: int) -> Array:
        """Return an array for tangents of expansions with so many rows in a block."""
        return aligned(self.first(rows) + count * self.size, WIDTH)


# The times on a step, s, that a tangent is wanted at: its end, where it is marked, and where the
# ball is closest to the bat.
TIMES = 3


class _Tangents(_Writer):
    """Writer of a function that integrates tangents over a step, with its partial derivatives.

    The first argument is the array of the expansion, the second that of `Tangents`. The integers
    are the order, the rows of a block and the number of tangents; the double is the number of times
    that they are wanted at. Two tangents go at once, in half of the lanes: their sums then stay in
    registers, and a partial derivative is loaded once for both.
    """

    def __init__(self, module: Any, program: Program) -> None:
        super().__init__(module, "tangents", WIDTH // 2)
        self.array, self.memory, order, self.stride, count, times = self.arguments
        self.order = self.builder.add(order, self.index(Layout(program).further))
        self.rows, self.count = Tangents(program), len(program.variables)
        # of each variable: where the variable is that is its rate; or, in a rate that is none, the
        # sources that it depends on, and the blocks of the partial derivatives
        self.mover: dict[int, int] = {}
        self.terms: dict[int, list[tuple[int, int]]] = {}
        blocks, sources = Layout(program).partials, self.rows.sources
        for i, rate in enumerate(program.outputs[: self.count]):
            if rate.kind == "variable":
                self.mover[i] = program.variables.index(rate.args[0])
            else:
                slopes = program.outputs[self.count + i * sources :][:sources]
                self.terms[i] = [(j, blocks[x]) for j, x in enumerate(slopes) if x is not ZERO]
        self.inverse = Layout(program).inverse
        self.times = self.builder.fptosi(times, _INDEX)

        build, two = self.builder, self.index(2)
        pairs = build.sdiv(count, two)
        for self.half in range(2):
            self.repeat(self.index(0), pairs, [], lambda i, _: self.carry(build.mul(i, two), 2))
            self.repeat(build.mul(pairs, two), count, [], lambda i, _: self.carry(i, 1))
        build.ret(self.index(0))

    def place(self, row: Value) -> Value:
        """Return where the half of a row is."""
        return self.builder.add(self.builder.mul(row, self.index(2)), self.index(self.half))

    def get(self, block: int, k: Value) -> Value:
        """Return a row of a block of the expansion."""
        start = self.builder.mul(self.index(block), self.stride)
        return self.load(self.array, self.place(self.builder.add(start, k)))

    def series(self, which: int, i: int, k: Value) -> Value:
        """Return where the coefficient k of a component of ξ is, of the first or second tangent."""
        block = self.builder.mul(self.index(which * self.count + i), self.stride)
        return self.place(self.builder.add(self.builder.add(self.index(TIMES), block), k))

    def known(self, tangent: Value, row: Value | int) -> Value:
        """Return where a row of a tangent is: dp/dx, and ξ at the times."""
        row = self.index(row) if isinstance(row, int) else row
        begin = self.builder.mul(tangent, self.index(self.rows.size))
        series = self.builder.mul(self.index(2 * self.count), self.stride)
        first = self.builder.add(self.index(TIMES), series)
        return self.place(self.builder.add(self.builder.add(first, begin), row))

    def carry(self, first: Value, size: int) -> list[Value]:
        """Integrate one tangent, or two neighbours, over the step."""
        build = self.builder
        tangents = [build.add(first, self.index(i)) for i in range(size)]
        parameters = self.rows.sources - self.count
        for which, tangent in enumerate(tangents):
            for i in range(self.count):
                start = self.load(self.memory, self.known(tangent, parameters + i))
                self.store(self.memory, self.series(which, i, self.index(0)), start)
        sums = [(which, i) for which in range(size) for i in self.terms]

        def next_order(n: Value, _: list[Value]) -> list[Value]:
            begin = []
            for which, i in sums:
                total = self.number(0.0)
                for source, block in self.terms[i]:
                    if source >= self.count:
                        place = self.known(tangents[which], source - self.count)
                        total = self.fma(self.get(block, n), self.load(self.memory, place), total)
                begin.append(total)

            def term(m: Value, totals: list[Value]) -> list[Value]:
                k = build.sub(n, m)
                found = list(totals)
                for i, terms in self.terms.items():
                    for source, block in terms:
                        if source >= self.count:
                            continue
                        slope = self.get(block, m)
                        for which in range(size):
                            place = sums.index((which, i))
                            xi = self.load(self.memory, self.series(which, source, k))
                            found[place] = self.fma(slope, xi, found[place])
                return found

            after = build.add(n, self.index(1))
            totals = self.repeat(self.index(0), after, begin, term)
            self.put_order(size, n, dict(zip(sums, totals, strict=True)))
            return []

        self.repeat(self.index(0), self.order, [], next_order)
        self.put_order(size, self.order, dict.fromkeys(sums, self.number(0.0)))

        def evaluate(at: Value, _: list[Value]) -> list[Value]:
            start = build.add(build.mul(at, self.index(self.count)), self.index(parameters))
            for which, tangent in enumerate(tangents):
                for i, value in enumerate(self.sums(which, self.load(self.memory, self.place(at)))):
                    row = build.add(start, self.index(i))
                    self.store(self.memory, self.known(tangent, row), value)
            return []

        return self.repeat(self.index(0), self.times, [], evaluate)

    def put_order(self, size: int, n: Value, totals: dict[tuple[int, int], Value]) -> None:
        """Write the coefficients of order n + 1, those of n of the rates being known."""
        after = self.builder.add(n, self.index(1))
        per_n = self.get(self.inverse, after)
        for which in range(size):
            for i in range(self.count):
                if i in self.mover:
                    rate = self.load(self.memory, self.series(which, self.mover[i], n))
                else:
                    rate = totals[which, i]
                change = self.multiply(rate, per_n)
                self.store(self.memory, self.series(which, i, after), change)

    def sums(self, which: int, time: Value) -> list[Value]:
        """Return the components of ξ at a time on the step."""
        last = self.builder.add(self.order, self.index(1))

        def term(k: Value, totals: list[Value]) -> list[Value]:
            down = self.builder.sub(self.order, k)
            return [
                self.fma(total, time, self.load(self.memory, self.series(which, i, down)))
                for i, total in enumerate(totals)
            ]

        begin = [self.load(self.memory, self.series(which, i, last)) for i in range(self.count)]
        return self.repeat(self.index(0), last, begin, term)


# --- machine code ---------------------------------------------------------------------------------


def written(program: Program) -> Any:
    """Return the module of LLVM with the functions of a `Kernel`."""
    module = ir.Module("law")
    _Step(module, program)
    if Layout(program).partials:
        _Tangents(module, program)
    return module


@dataclass(frozen=True)
class Kernel:
    """The compiled steps of a program."""

    layout: Layout
    # Addresses of functions; the stride is the number of rows of a block.
    # step: of (x, functions, order, stride, count, truncation);
    # tangents: of (x, tangents, order, stride, count, times), or 0
    step: int
    tangents: int
    engine: Any  # owns the code


_lock = Lock()


@cache
def _kernel(program: Program) -> Kernel:
    def compiled() -> bytes:
        module = binding.parse_assembly(str(written(program)))
        module.verify()
        options = binding.create_pipeline_tuning_options(speed_level=3)
        binding.create_pass_builder(target, options).getModulePassManager().run(
            module, binding.create_pass_builder(target, options)
        )
        code: bytes = target.emit_object(module)
        return code

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    target = binding.Target.from_default_triple().create_target_machine(
        cpu=binding.get_host_cpu_name(),
        features=binding.get_host_cpu_features().flatten(),
        opt=3,
        codemodel="jitdefault",
        jit=True,
    )
    code = stored("law", [program.source], compiled)
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), target)
    engine.add_object_file(binding.ObjectFileRef.from_data(code))
    engine.finalize_object()
    step, tangents = map(engine.get_function_address, ("step", "tangents"))
    return Kernel(Layout(program), step, tangents, engine)


def kernel(program: Program) -> Kernel:
    """Return the compiled steps of a program; they are compiled once per machine."""
    with _lock:
        return _kernel(program)
