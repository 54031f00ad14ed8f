"""Taylor series of a flight in time: the recurrence that a traced law implies.

If ``y = Σ y_n tⁿ`` obeys ``y' = f(y)``, then ``(n+1) y_{n+1}`` is the coefficient of order n of
f(y), and that follows operation by operation (Moore, *Interval Analysis* (1966), ch. 11; Jorba and
Zou, *Experimental Mathematics* 14 (2005) 99):

    ``(a b)_n = Σ a_j b_{n-j}``
    ``(a/b)_n = (a_n - Σ' b_j (a/b)_{n-j}) / b_0``,  Σ' without j = 0
    ``(√a)_n = (a_n - Σ'' (√a)_j (√a)_{n-j}) / (2 √a_0)``,  Σ'' without j = 0 and j = n
    ``(eᵃ)_n = Σ' (j/n) a_j (eᵃ)_{n-j}``
    ``(ln a)_n = (a_n - Σ'' (j/n) (ln a)_j a_{n-j}) / a_0``

All have the same inner sum, over 1 … n-1 of a row of coefficients times another, so the
recurrence is printed as one loop over pairs (j, n-j), followed by the ends of the sums in the
order of the program. The printed function runs on sequences of any kind of number and, compiled
by numba, on arrays of doubles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, MutableSequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

from longball.model.trace import ZERO, Names, Node, Program, run_source, squares, variable

# A row of coefficients for each variable, and for each value that a sum over orders needs.
Rows = list[MutableSequence[Any]]


@dataclass(frozen=True)
class Recurrence:
    """The recurrence of a program whose outputs are the rates of its variables.

    It is printed in two forms. The second is for a flight that starts at rest, or with another
    vector of size zero: then ``V = V_1 t + …``, where V_1 is the size of the acceleration.
    """

    program: Program

    @cached_property
    def rows(self) -> tuple[Node, ...]:
        """Nodes with stored coefficients, the variables first."""
        kept = dict.fromkeys(map(variable, self.program.variables))
        # The inner sums need the whole rows of their factors; of a sum of nodes, the present
        # coefficient is enough.
        for node in self.program.nodes:
            if node.static:
                continue
            match node.kind:
                case "product":
                    kept |= dict.fromkeys(map(row_of, node.args))
                case "quotient":
                    kept |= dict.fromkeys((node, row_of(node.args[1])))
                case "sqrt":
                    kept |= {node: None}
                case "exp" | "log":
                    kept |= dict.fromkeys((node, row_of(node.args[0])))
        return tuple(node for node in kept if not node.static)

    def name(self, node: Node) -> str:
        """Return the name of a row in printed code."""
        return str(node.args[0]) if node.kind == "variable" else f"r{self.rows.index(node)}"

    def factors(self, node: Node) -> tuple[Node, Node] | None:
        """Return the two nodes whose rows the inner sum of a node multiplies; None without a sum.

        For `exp` and `log` the first factor is weighted with its order.
        """
        match node.kind:
            case "product":
                return node.args
            case "quotient":
                return node.args[1], node
            case "sqrt":
                return node, node
            case "exp":
                return node.args[0], node
            case "log":
                return node, node.args[0]
        return None

    def divisor(self, node: Node) -> Node | None:
        """Return the divisor of the coefficients of a node, at t = 0, which must not be zero."""
        divisors: dict[str, Node] = {"quotient": node.args[-1], "sqrt": node, "log": node.args[0]}
        return divisors.get(node.kind)

    @cached_property
    def roots(self) -> tuple[Node, ...]:
        """The sizes of vectors, ``√(x x + y y + …)``: zero at rest."""
        return tuple(n for n in self.program.nodes if n.kind == "sqrt" and squares(n.args[0]))

    @cached_property
    def crises(self) -> tuple[Node, ...]:
        """The exponents x of divisors ``1 + e^x``: a series does not show them where x is large."""
        divisors = (node.args[1] for node in self.program.nodes if node.kind == "quotient")
        sums = [x.args for x in divisors if x.kind == "sum" and x.args[0] is not ZERO]
        powers = [x.args[0] for _, *terms in sums for _, x in terms if x.kind == "exp"]
        return tuple(dict.fromkeys(powers))

    @cache  # noqa: B019  (recurrences are few, and kept anyway)
    def source(self, at_rest: bool = False) -> str:
        """Return the code of ``expand(x, order, *parameters)``.

        `x` has a sequence for each of `rows`; those of the variables hold the state at 0. It
        fills in the coefficients up to `order`, and one more of a variable whose rate is another.
        """
        program, lines = self.program, []
        outputs = list(zip(program.variables, program.outputs, strict=True))
        dynamic = [n for n in program.nodes if not n.static and n.kind != "variable"]

        def put(depth: int, line: str) -> None:
            lines.append("    " * depth + line)

        def at(node: Node, index: str) -> str:
            return f"{self.name(row_of(node))}[{index}]"

        put(0, f"def expand({', '.join(('x', 'order', *program.parameters))}):")
        for i, node in enumerate(self.rows):
            put(1, f"{self.name(node)} = x[{i}]")
        static = Names()
        for node in program.nodes:
            if node.static and (line := static.define(node)):
                put(1, line)

        # order 0, which is the program at the start, and the first coefficient of each variable
        zeroth = Names(static)
        for name in program.variables:
            zeroth[variable(name)] = f"{name}[0]"
        for node in dynamic:
            text = zeroth.expression(node)
            zeroth[node] = f"y{len(zeroth)}"
            put(1, f"{zeroth[node]} = {text}")
            if node in self.rows:
                put(1, f"{self.name(node)}[0] = {zeroth[node]}")
        for name, rate in outputs:
            put(1, f"{name}[1] = {zeroth[rate]}")

        # the sums over 1 … n-1, in pairs (j, n-j), each symmetric one by halves
        put(1, "for n in range(1, order):")
        both, middle, doubled = [], [], []
        sums: dict[Node, str] = {}
        for node in dynamic:
            if (factors := self.factors(node)) is None:
                continue
            total, (a, b) = f"s{len(sums)}", factors
            sums[node] = total
            weigh = "{} * " if node.kind in ("exp", "log") else ""  # with the orders of a
            products = [f"{weigh.format(i)}{at(a, i)} * {at(b, k)}" for i, k in ("jk", "kj", "mm")]
            if a is b:
                # a_j a_k and a_k a_j are the same: half of the sum, twice
                del products[1]
                doubled.append(f"{total} = {total} + {total}")
            both.append(f"{total} += {' + '.join(products[:-1])}")
            middle.append(f"{total} += {products[-1]}")
            put(2, f"{total} = 0.0")
        if sums:
            put(2, "for j in range(1, (n + 1) // 2):")
            for line in ("k = n - j", *both):
                put(3, line)
            for line in (*doubled, "if n % 2 == 0:"):
                put(2, line)
            for line in ("m = n // 2", *middle):
                put(3, line)

        # the coefficients of order n: the sums with the products that have an index of 0 or n; the
        # formulas are those of the module's docstring
        names = Names(static)
        for name in program.variables:
            names[variable(name)] = f"{name}[n]"
        for node in dynamic:
            coefficient, inner, first = f"c{len(names)}", sums.get(node, ""), node.args[0]
            match node.kind:
                case "sum":
                    text = names.combination(node, names.__getitem__, constant=False)
                case "product":
                    a, b = node.args
                    text = f"{inner} + {zeroth[a]} * {names[b]} + {names[a]} * {zeroth[b]}"
                    if a is b:
                        text = f"{inner} + 2 * {zeroth[a]} * {names[a]}"
                case "quotient":
                    a, b = node.args
                    top = "0.0" if a.static else names[a]
                    text = f"({top} - {inner} - {names[b]} * {zeroth[node]}) / {zeroth[b]}"
                case "sqrt":
                    text = f"({names[first]} - {inner}) / (2 * {zeroth[node]})"
                case "exp":
                    text = f"{inner} / n + {names[first]} * {zeroth[node]}"
                case "log":
                    text = f"({names[first]} - {inner} / n) / {zeroth[first]}"
            depth = 2
            if at_rest and node in self.roots:
                # With V_0 = 0, the equation of order n + 1 of V² = Σ v_i² has V_n as 2 V_1 V_n.
                parts, row = squares(first), self.name(node)
                squared = " + ".join(f"{at(p, '1')} * {at(p, '1')}" for p in parts)
                put(2, f"if {zeroth[node]} == 0.0:")
                put(3, "if n == 1:")
                put(4, f"{coefficient} = sqrt({squared})")
                put(3, "else:")
                put(4, f"{coefficient} = 0.0")
                put(4, "for j in range(1, n + 1):")
                for p in parts:
                    put(5, f"{coefficient} += {at(p, 'j')} * {at(p, 'n + 1 - j')}")
                put(4, "for j in range(2, n):")
                put(5, f"{coefficient} -= {row}[j] * {row}[n + 1 - j]")
                put(4, f"{coefficient} = {coefficient} / (2 * {row}[1])")
                put(2, "else:")
                depth = 3
            put(depth, f"{coefficient} = {text}")
            names[node] = coefficient
            if node in self.rows:
                put(2, f"{self.name(node)}[n] = {coefficient}")

        # the next one of each variable: that of its rate, by n + 1
        for name, rate in outputs:
            put(2, f"{name}[n + 1] = {'0.0' if rate.static else names[rate]} / (n + 1)")
        for name, rate in outputs:
            if rate.kind == "variable":
                put(1, f"{name}[order + 1] = {rate.args[0]}[order] / (order + 1)")
        return "\n".join(lines) + "\n"

    def function(
        self, functions: Mapping[str, Callable[..., Any]], at_rest: bool = False
    ) -> Callable[..., None]:
        """Return the printed function, for numbers with these elementary functions."""
        expand: Callable[..., None] = run_source(self.source(at_rest), "expand", functions)
        return expand


# The recurrence of a program, made once.
recurrence = cache(Recurrence)


def row_of(node: Node) -> Node:
    """Return x of ``x + constant``: the coefficients of the two differ in the first alone."""
    if node.kind == "sum" and len(node.args) == 2 and node.args[1][0].args == (1.0,):
        inner: Node = node.args[1][1]
        return inner
    return node
