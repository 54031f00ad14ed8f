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

from longball.model.trace import Names, Node, Program, run_source, squares, variable

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

    @cached_property
    def roots(self) -> tuple[Node, ...]:
        """The sizes of vectors, ``√(x x + y y + …)``: zero at rest."""
        return tuple(n for n in self.program.nodes if n.kind == "sqrt" and squares(n.args[0]))

    def source(self, at_rest: bool = False) -> str:
        """Return the code of ``expand(x, order, *parameters)``.

        `x` has a sequence for each of `rows`; those of the variables hold the state at 0. It
        fills in the coefficients up to `order`, and one more of a variable whose rate is another.
        """
        return _source(self, at_rest)

    def function(
        self, functions: Mapping[str, Callable[..., Any]], at_rest: bool = False
    ) -> Callable[..., None]:
        """Return the printed function, for numbers with these elementary functions."""
        expand: Callable[..., None] = run_source(self.source(at_rest), "expand", functions)
        return expand


@cache
def recurrence(program: Program) -> Recurrence:
    """Return the recurrence of a program."""
    return Recurrence(program)


@cache
def _source(recurrence: Recurrence, at_rest: bool) -> str:
    return _Printer(recurrence, at_rest).text()


def row_of(node: Node) -> Node:
    """Return x of ``x + constant``: the coefficients of the two differ in the first alone."""
    if node.kind == "sum" and len(node.args) == 2 and node.args[1][0].args == (1.0,):
        inner: Node = node.args[1][1]
        return inner
    return node


class _Printer:
    """Prints a recurrence."""

    def __init__(self, recurrence: Recurrence, at_rest: bool) -> None:
        self.recurrence = recurrence
        self.program = recurrence.program
        self.from_rest = recurrence.roots if at_rest else ()
        self.names = Names()
        self.dynamic = [n for n in self.program.nodes if not n.static and n.kind != "variable"]
        self.lines: list[str] = []

    def text(self) -> str:
        arguments = ", ".join(("x", "order", *self.program.parameters))
        self.put(0, f"def expand({arguments}):")
        for i, node in enumerate(self.recurrence.rows):
            self.put(1, f"{self.recurrence.name(node)} = x[{i}]")
        for node in self.program.nodes:
            if node.static and (line := self.names.define(node)):
                self.put(1, line)
        self.order_zero()
        self.put(1, "for n in range(1, order):")
        self.inner_sums()
        self.ends()
        for name, rate in self.outputs():
            if rate.kind == "variable":
                self.put(1, f"{name}[order + 1] = {rate.args[0]}[order] / (order + 1)")
        return "\n".join(self.lines) + "\n"

    def put(self, depth: int, line: str) -> None:
        self.lines.append("    " * depth + line)

    def outputs(self) -> list[tuple[str, Node]]:
        return list(zip(self.program.variables, self.program.outputs, strict=True))

    def row(self, node: Node, index: str) -> str:
        return f"{self.recurrence.name(row_of(node))}[{index}]"

    def order_zero(self) -> None:
        """Print the coefficients of order 0, and the first one of each variable."""
        # They are the values of the program at the start.
        names = Names(self.names)
        for name in self.program.variables:
            names[variable(name)] = f"{name}[0]"
        for node in self.dynamic:
            text = names.expression(node)
            names[node] = f"y{len(names)}"
            self.put(1, f"{names[node]} = {text}")
            if node in self.recurrence.rows:
                self.put(1, f"{self.recurrence.name(node)}[0] = {names[node]}")
        self.zeroth = names
        for name, rate in self.outputs():
            self.put(1, f"{name}[1] = {names[rate]}")

    def inner_sums(self) -> None:
        """Print the sums over 1 … n-1, in pairs (j, n-j), each symmetric one by halves."""
        both: list[str] = []
        middle: list[str] = []
        doubled: list[str] = []
        self.sums: dict[Node, str] = {}
        for node in self.dynamic:
            factors = self.recurrence.factors(node)
            if factors is None:
                continue
            name = self.sums[node] = f"s{len(self.sums)}"
            a, b = factors
            if a is b:
                # a_j a_k and a_k a_j are the same: half of the sum, twice
                both.append(f"{name} += {self.row(a, 'j')} * {self.row(a, 'k')}")
                middle.append(f"{name} += {self.row(a, 'm')} * {self.row(a, 'm')}")
                doubled.append(f"{name} = {name} + {name}")
            else:
                # a_j b_k and a_k b_j in one pass; the weights are the orders of a
                weigh = node.kind in ("exp", "log")
                near, far = (f"{i} * " if weigh else "" for i in "jk")
                both.append(
                    f"{name} += {near}{self.row(a, 'j')} * {self.row(b, 'k')}"
                    f" + {far}{self.row(a, 'k')} * {self.row(b, 'j')}"
                )
                half = "m * " if weigh else ""
                middle.append(f"{name} += {half}{self.row(a, 'm')} * {self.row(b, 'm')}")
        for name in self.sums.values():
            self.put(2, f"{name} = 0.0")
        if both:
            self.put(2, "for j in range(1, (n + 1) // 2):")
            self.put(3, "k = n - j")
            for line in both:
                self.put(3, line)
        for line in doubled:
            self.put(2, line)
        if middle:
            self.put(2, "if n % 2 == 0:")
            self.put(3, "m = n // 2")
            for line in middle:
                self.put(3, line)

    def ends(self) -> None:
        """Print the coefficients of order n, and the next one of each variable."""
        # One order after the other: a variable's next coefficient is that of its rate, by n + 1.
        names = Names(self.names)
        zeroth = self.zeroth
        for name in self.program.variables:
            names[variable(name)] = f"{name}[n]"
        for node in self.dynamic:
            names[node] = self.end(node, names, zeroth)
            if node in self.recurrence.rows:
                self.put(2, f"{self.recurrence.name(node)}[n] = {names[node]}")
        for name, rate in self.outputs():
            text = names[rate] if not rate.static else "0.0"
            self.put(2, f"{name}[n + 1] = {text} / (n + 1)")

    def end(self, node: Node, names: Names, zeroth: Names) -> str:
        """Print the coefficient of order n of a node; return its name.

        It completes the inner sum with the products that have an index of 0 or n: the formulas
        are those of the module's docstring.
        """
        name = f"c{len(names)}"
        inner = self.sums.get(node, "")
        match node.kind:
            case "sum":
                text = names.combination(node, names.__getitem__, constant=False)
            case "product":
                a, b = node.args
                if a is b:
                    text = f"{inner} + 2 * {zeroth[a]} * {names[a]}"
                else:
                    text = f"{inner} + {zeroth[a]} * {names[b]} + {names[a]} * {zeroth[b]}"
            case "quotient":
                a, b = node.args
                top = "0.0" if a.static else names[a]
                text = f"({top} - {inner} - {names[b]} * {zeroth[node]}) / {zeroth[b]}"
            case "sqrt":
                text = f"({names[node.args[0]]} - {inner}) / (2 * {zeroth[node]})"
            case "exp":
                text = f"{inner} / n + {names[node.args[0]]} * {zeroth[node]}"
            case "log":
                a = node.args[0]
                text = f"({names[a]} - {inner} / n) / {zeroth[a]}"
        if node in self.from_rest:
            self.put(2, f"if {zeroth[node]} == 0.0:")
            self.root_from_rest(node, name)
            self.put(2, "else:")
            self.put(3, f"{name} = {text}")
        else:
            self.put(2, f"{name} = {text}")
        return name

    def root_from_rest(self, node: Node, name: str) -> None:
        """Print the coefficient of a speed that is zero at the start.

        With V_0 = 0, the equation of order n + 1 of ``V² = Σ v_i²`` has V_n as ``2 V_1 V_n``.
        """
        parts = squares(node.args[0])
        row = self.recurrence.name(node)
        first = " + ".join(f"{self.row(p, '1')} * {self.row(p, '1')}" for p in parts)
        self.put(3, "if n == 1:")
        self.put(4, f"{name} = sqrt({first})")
        self.put(3, "else:")
        self.put(4, f"{name} = 0.0")
        self.put(4, "for j in range(1, n + 1):")
        for p in parts:
            self.put(5, f"{name} += {self.row(p, 'j')} * {self.row(p, 'n + 1 - j')}")
        self.put(4, "for j in range(2, n):")
        self.put(5, f"{name} -= {row}[j] * {row}[n + 1 - j]")
        self.put(4, f"{name} = {name} / (2 * {row}[1])")
