"""Derivatives of flights over a step, as machine code generated from a traced law.

The derivative ξ of the state by a number x of the scene, which the strengths p of the law may
depend on, obeys a linear equation on a known path,

    ``ξ' = A(t) ξ + b(t)``,  ``A = ∂f/∂state``,  ``b = (∂f/∂p) dp/dx``     (1)

A step has the path as a Taylor series. Its derivatives as series would cost a product of series for
each operation in A, and for each entry of A times each of ξ. Gauss's collocation (Hairer, Lubich
and Wanner, *Geometric Numerical Integration*, Sec. II.1.3) needs A and b as numbers, at K times
t_k = c_k h of the step, and one system of linear equations for all tangents:

    ``F_k = A_k ξ_k + b_k``,  ``ξ_k = ξ_0 + h Σ_j a_kj F_j``,  ``ξ(h) = ξ_0 + h Σ_k w_k F_k``  (2)

Collocation uses the path on the whole step, and needs fewer points than a series needs terms. If
the last terms of N = 22 orders are 1e-15, singularities are five steps away. The ellipse around the
step in which all functions are analytic then has half axes whose sum is 18 half steps, and the
error is about 18^-2K: 1e-15 with K = 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from llvmlite import binding, ir

from longball.engines.batch.writer import (
    DOUBLE,
    INDEX,
    WIDTH,
    Code,
    Value,
    Values,
    Writer,
    aligned,
    once,
)
from longball.engines.series import recurrence
from longball.model.arrays import Array
from longball.model.trace import ZERO, Node, Program, with_partials

# Flights computed together: their matrix fits into the first-level cache.
LANES = 8 if binding.get_host_cpu_features().get("avx512f") else 4
PARTS = WIDTH // LANES

# Number of times on a step at which tangents are needed: its end, its mark, and the closest
# approach to the bat.
TIMES = 3


def gauss(nodes: int) -> tuple[Array, Array, Array]:
    """Return c, w and a of (2), on [0, 1].

    ``a_kj = ∫_0^{c_k} l_j``: with ``l_j = w_j Σ_n (2 n + 1) P_n(c_j) P_n``, of Legendre polynomials
    on [0, 1], of which ``∫_0^c (2 n + 1) P_n = (P_{n+1}(c) - P_{n-1}(c))/2``.
    """
    x, w = np.polynomial.legendre.leggauss(nodes)
    c, w = (x + 1) / 2, w / 2
    p = np.polynomial.legendre.legvander(x, nodes)
    integrals = (p[:, 1:] - np.column_stack([-np.ones(nodes), p[:, : nodes - 1]])) / 2
    return c, w, integrals @ p[:, :nodes].T * w


# --- memory ---------------------------------------------------------------------------------------


class Tangents:
    """Equations (2) of a law, and the array with the tangents of the flights in the lanes.

    A variable that is the integral of another, as a position is of a velocity, has no separate F.
    With ``ξ' = η`` and ``η_k = η_0 + h Σ a_kj F_j`` it is
    ``ξ_k = ξ_0 + h c_k η_0 + h² Σ (a²)_kj F_j``.
    """

    def __init__(self, program: Program) -> None:
        # K: one more than the estimate above, or two more with a logarithm. Steps are shorter than
        # half the distance to singularities of roots, but not of other functions. A logarithmic
        # wind has one ahead of the ball, below the ground: relative errors of derivatives are
        # 3e-12, 5e-14 and 6e-15 with K = 6, 7 and 8. For a drag crisis, whose poles are not on the
        # real axis, they are 3e-14 and 5e-16 with K = 6 and 7.
        self.nodes = 8 if any(node.kind == "log" for node in program.nodes) else 7
        self.program = program
        count, sources = len(program.variables), len(program.variables) + len(program.parameters)
        slopes = with_partials(program).outputs[len(program.outputs) :]
        # of each variable that is an integral: of which
        self.mover: dict[int, int] = {}
        # of each other one: the partial derivatives of its rate that are not zero, by source
        self.slopes: dict[int, dict[int, Node]] = {}
        for i, rate in enumerate(program.outputs[:count]):
            if rate.kind == "variable":
                self.mover[i] = program.variables.index(rate.args[0])
            else:
                row = slopes[i * sources :][:sources]
                self.slopes[i] = {j: node for j, node in enumerate(row) if node is not ZERO}
        entries = {(i, j): node for i, row in self.slopes.items() for j, node in row.items()}
        self.partials = replace(program, outputs=tuple(entries.values()))
        self.unknown = [*self.slopes]  # variables, each with an F at each time
        # rows of the memory, of `LANES` numbers: at each time these partial derivatives; the blocks
        # of the matrix; F
        self.entry = {place: n for n, place in enumerate(entries)}
        self.matrix = self.nodes * len(entries)
        self.forces = self.matrix + self.nodes**2 * len(self.unknown) ** 2
        used = self.forces + self.nodes * len(self.unknown)
        # Rows of the lanes: `TIMES`, the state where the step begins, the rows above, and the
        # tangents. Of each: dp/dx; ξ at the end of the step; and at the other times, in order
        self.scratch = TIMES + count
        self.first = self.scratch - (-used // PARTS)
        self.size = len(program.parameters) + TIMES * count

    def allocate(self, tangents: int) -> Array:
        """Return an array for a number of tangents."""
        return aligned(self.first + tangents * self.size, WIDTH)


# --- code -----------------------------------------------------------------------------------------


class _Collocation(Writer):
    """Writes a function that integrates tangents over a step.

    The first argument is the array of the expansion, the second that of `Tangents`. The integers
    are the order, the rows of a block and the number of tangents; the double is the number of times
    that they are wanted at.
    """

    def __init__(self, module: Any, program: Program) -> None:
        super().__init__(module, "tangents", LANES)
        self.array, self.memory = self.arrays
        self.order, self.stride, self.count, times = self.numbers
        self.program, self.system = program, Tangents(program)
        self.nodes, self.unknown = self.system.nodes, self.system.unknown
        self.variables = len(program.variables)
        c, w, a = gauss(self.nodes)
        tables = {"c": c, "w": w, "a": a, "v": w * (1 - c), "b": a @ a}  # v_k = Σ w_j a_jk
        self.tables = {}
        for name, values in tables.items():
            kind = ir.ArrayType(DOUBLE, values.size)
            self.tables[name] = ir.GlobalVariable(module, kind, name)
            self.tables[name].global_constant = True
            self.tables[name].initializer = ir.Constant(kind, values.ravel().tolist())
        last = times.to("fptosi", INDEX) - 1

        def part(chunk: Value, _: Sequence[Value]) -> list[Value]:
            self.chunk = chunk
            given: Values = {}  # the same along a flight
            start = self.stride * len(recurrence(program).rows)
            self.evaluate(
                (node for node in self.system.partials.nodes if node.static),
                lambda x: self.array[self.place(start + program.parameters.index(x.args[0]))],
                given,
            )
            # the end last: it takes the place of the beginning
            self.repeat(0, last + 1, [], lambda i, _: self.advance(last - i, given))
            return []

        self.repeat(0, PARTS, [], part)
        self.build.ret(self.index(0).code)

    # --- places ---

    def constant(self, name: str, k: Value) -> Value:
        """Return a constant in every lane."""
        place = self.build.gep(self.tables[name], [INDEX(0), k.code])
        return self.spread(Value(self.build, self.build.load(place)))

    def place(self, row: Value) -> Value:
        """Index of a row for the present lanes."""
        return row * PARTS + self.chunk

    def of_tangent(self, tangent: Value, row: Value | int) -> Value:
        """Index of a row of a tangent: dp/dx, and ξ at the times."""
        return self.place(tangent * self.system.size + self.system.first + row)

    def scratch(self, row: Value) -> Value:
        """Index of a row of `Tangents`, which has the numbers of the present lanes only."""
        return row + self.system.scratch * PARTS

    def block(self, a: Value, b: Value) -> list[list[Value]]:
        """Indices of the numbers of a block of the matrix."""
        size = len(self.unknown)
        start = self.scratch((a * self.nodes + b) * (size * size) + self.system.matrix)
        return [[start + (size * i + j) for j in range(size)] for i in range(size)]

    def slope(self, k: Value, i: int, j: int) -> Any:
        """Return ``∂f_i/∂x_j`` at a time; None if it is always zero."""
        if (i, j) not in self.system.entry:
            return None
        return self.memory[self.scratch(k * len(self.system.entry) + self.system.entry[i, j])]

    def forces(self, k: Value) -> list[Value]:
        """Indices of F at a time."""
        start = self.scratch(k * len(self.unknown) + self.system.forces)
        return [start + i for i in range(len(self.unknown))]

    # --- the integration ---

    def advance(self, at: Value, given: Values) -> list[Value]:
        """Integrate all tangents up to one of the times, if any of the flights has it."""
        length = self.memory[self.place(at)]
        wanted = length.equals(length).to("bitcast", ir.IntType(LANES))
        some = self.build.icmp_signed("!=", wanted.code, ir.IntType(LANES)(0))

        def go(_: Value, __: Sequence[Value]) -> list[Value]:
            self.repeat(0, self.nodes, [], lambda k, _: self.put_slopes(k, length, dict(given)))
            self.repeat(0, self.nodes, [], lambda k, _: self.eliminate(k, length))
            self.repeat(0, self.count, [], lambda i, _: self.carry(i, at, length))
            return []

        return self.repeat(0, Value(self.build, some).to("zext", INDEX), [], go)

    def put_slopes(self, k: Value, length: Value, values: Values) -> list[Value]:
        """Evaluate the partial derivatives at a time of the step."""
        system = self.system
        t = length * self.constant("c", k)
        moving = [n for n in system.partials.nodes if not n.static]
        used = [n for n in moving if n.kind == "variable"]
        places = [self.program.variables.index(n.args[0]) for n in used]

        def coefficient(i: int, power: Value) -> Value:
            return self.array[self.place(self.stride * i + power)]

        # Positions are known to one order more.
        zero = self.number(0.0)
        begin = [coefficient(i, self.order + 1) if i in system.mover else zero for i in places]

        def term(m: Value, totals: list[Value]) -> list[Value]:
            return [
                self.fma(total, t, coefficient(i, self.order - m))
                for i, total in zip(places, totals, strict=True)
            ]

        totals = self.repeat(0, self.order, begin, term)
        starts = [self.memory[self.place(self.index(TIMES + i))] for i in places]
        state = {
            node: self.fma(total, t, start)
            for node, total, start in zip(used, totals, starts, strict=True)
        }
        self.evaluate(moving, state.__getitem__, values)
        for (i, j), n in system.entry.items():
            row = self.scratch(k * len(system.entry) + n)
            self.memory[row] = values[system.slopes[i][j]]
        return []

    def eliminate(self, a: Value, length: Value) -> list[Value]:
        """Write the blocks of row a of the matrix of (2), as factors L and U of it.

        The unit matrix is in it: h A a is about 0.1, and there is no need to choose pivots. Of the
        diagonal blocks of U the inverses are kept.
        """
        size, square = len(self.unknown), length * length

        def reduced(b: Value, until: Value) -> list[list[Value]]:
            """Return a block of the matrix, less the products of those of L and U before."""
            once = length * self.constant("a", a * self.nodes + b)
            twice = square * self.constant("b", a * self.nodes + b)
            same = a.equals(b).select(self.number(1.0), self.number(0.0))
            begin = []
            for i in self.unknown:
                for j in self.unknown:
                    total = same if i == j else self.number(0.0)
                    through = [(j, once)]
                    through += [(x, twice) for x, mover in self.system.mover.items() if mover == j]
                    for source, factor in through:
                        slope = self.slope(a, i, source)
                        if slope is not None:
                            total = self.fma(-slope, factor, total)
                    begin.append(total)

            def product(p: Value, totals: list[Value]) -> list[Value]:
                left, right = self.loaded(self.block(a, p)), self.loaded(self.block(p, b))
                return [
                    self.less(totals[size * i + j], left[i], [row[j] for row in right])
                    for i in range(size)
                    for j in range(size)
                ]

            elements = self.repeat(0, until, begin, product)
            return [elements[size * i :][:size] for i in range(size)]

        # row by row, so that each block is written once, when its sum is complete
        def lower(b: Value, _: list[Value]) -> list[Value]:
            block, pivot = reduced(b, b), self.loaded(self.block(b, b))
            self.keep(self.block(a, b), _product(self, block, pivot))
            return []

        def upper(b: Value, _: list[Value]) -> list[Value]:
            self.keep(self.block(a, b), reduced(b, a))
            return []

        self.repeat(0, a, [], lower)
        self.keep(self.block(a, a), _inverse(self, reduced(a, a)))
        self.repeat(a + 1, self.nodes, [], upper)
        return []

    def carry(self, tangent: Value, at: Value, length: Value) -> list[Value]:
        """Solve (2) for a tangent, and write it at the time."""
        system, parameters = self.system, len(self.program.parameters)

        def known(row: int) -> Value:
            return self.memory[self.of_tangent(tangent, row)]

        # of an integral, what it would gain with its rate as it begins
        start = [known(parameters + i) for i in range(self.variables)]
        drift = {x: length * start[mover] for x, mover in system.mover.items()}

        def forwards(k: Value, _: list[Value]) -> list[Value]:
            c = self.constant("c", k)
            there = [self.fma(drift[i], c, x) if i in drift else x for i, x in enumerate(start)]
            totals = []
            for i in self.unknown:
                total = self.number(0.0)
                for j in system.slopes[i]:
                    source = there[j] if j < self.variables else known(j - self.variables)
                    total = self.fma(self.slope(k, i, j), source, total)
                totals.append(total)
            totals = self.repeat(0, k, totals, lambda p, so_far: self.through(k, p, so_far))
            self.keep([self.forces(k)], [totals])
            return []

        def backwards(m: Value, sums: list[Value]) -> list[Value]:
            k = self.index(self.nodes - 1) - m
            (totals,) = self.loaded([self.forces(k)])
            totals = self.repeat(
                k + 1, self.nodes, totals, lambda p, so_far: self.through(k, p, so_far)
            )
            inverse = self.loaded(self.block(k, k))
            ((*force,),) = _product(self, [totals], [*map(list, zip(*inverse, strict=True))])
            self.keep([self.forces(k)], [force])
            weights = [self.constant(name, k) for name in "wv"]
            return [
                self.fma(f, weight, total)
                for weight, some in zip(
                    weights, (sums[: len(force)], sums[len(force) :]), strict=True
                )
                for f, total in zip(force, some, strict=True)
            ]

        # L y = A ξ_0 + b, then U F = y, and the sums of (2); v = w a, of what is integrated twice
        self.repeat(0, self.nodes, [], forwards)
        none = [self.number(0.0)] * (2 * len(self.unknown))
        sums = self.repeat(0, self.nodes, none, backwards)
        once, twice = (
            dict(zip(self.unknown, sums[n:], strict=False)) for n in (0, len(self.unknown))
        )
        first = at * self.variables + parameters
        for i, x in enumerate(start):
            if i in drift:
                change = self.fma(twice[system.mover[i]], length, start[system.mover[i]])
            else:
                change = once[i]
            self.memory[self.of_tangent(tangent, first + i)] = self.fma(change, length, x)
        return []

    def through(self, k: Value, p: Value, totals: list[Value]) -> list[Value]:
        """Subtract the products with the unknowns p from the sums of equations k, by L or U."""
        (known,) = self.loaded([self.forces(p)])
        rows = self.loaded(self.block(k, p))
        return [self.less(total, row, known) for total, row in zip(totals, rows, strict=True)]

    # --- small matrices ---

    def loaded(self, places: Sequence[Sequence[Value]]) -> list[list[Value]]:
        """Return numbers from the memory."""
        return [[self.memory[place] for place in row] for row in places]

    def keep(self, places: Sequence[Sequence[Value]], values: Sequence[Sequence[Value]]) -> None:
        """Write numbers into the memory."""
        for row, numbers in zip(places, values, strict=True):
            for place, x in zip(row, numbers, strict=True):
                self.memory[place] = x

    def less(self, total: Value, row: Sequence[Value], column: Sequence[Value]) -> Value:
        """Return a number less the product of a row and a column."""
        for x, y in zip(row, column, strict=True):
            total = self.fma(-x, y, total)
        return total


def _product(
    code: Writer, a: Sequence[Sequence[Value]], b: Sequence[Sequence[Value]]
) -> list[list[Value]]:
    """Return the product of two matrices."""
    product = []
    for row in a:
        totals = [row[0] * x for x in b[0]]
        for x, others in zip(row[1:], b[1:], strict=True):
            totals = [code.fma(x, y, total) for y, total in zip(others, totals, strict=True)]
        product.append(totals)
    return product


def _inverse(code: Writer, matrix: Sequence[Sequence[Value]]) -> list[list[Value]]:
    """Return the inverse of a matrix near the unit matrix, by Gauss and Jordan's elimination."""
    a = [[*row] for row in matrix]
    for p in range(len(a)):
        pivot = code.number(1.0) / a[p][p]
        a[p][p] = code.number(1.0)
        a[p] = [x * pivot for x in a[p]]
        for i in range(len(a)):
            if i != p:
                factor = -a[i][p]
                a[i][p] = code.number(0.0)
                a[i] = [code.fma(factor, x, y) for x, y in zip(a[p], a[i], strict=True)]
    return a


@once
def tangents(program: Program) -> Code:
    """Return the compiled tangents of a law: of (x, tangents, order, stride, count, times)."""
    return Code("tangents", program, lambda module: _Collocation(module, program))
