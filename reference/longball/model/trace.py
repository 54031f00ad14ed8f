"""Formulas traced into straight-line code.

A formula is an ordinary Python function. Called with `Node` instead of numbers it leaves behind
the graph of its operations, in which equal subexpressions are one node and whatever is multiplied
by an absent (zero) strength is gone. `Program` is that graph in the order of evaluation: an
engine evaluates it with its numbers, differentiates it, or prints recurrences from it.

The operations are ``+ - * /``, `sqrt`, `exp` and `log`. What depends on parameters alone is
*static*: it is computed once, not at every evaluation. What depends on the state is kept in a form
that suits power series, in which products are expensive and sums are not: sums are flat linear
combinations with static coefficients, and a static factor of a product stands before the product.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from typing import Any, cast

Scalar = float  # Python's numbers, which are exact


class Node:
    """A value of a traced formula; equal nodes are identical."""

    __slots__ = ("args", "kind", "static")

    # ``constant``, ``parameter`` and ``variable`` have one argument, a number or a name.
    # ``product``, ``quotient``, ``sqrt``, ``exp``, ``log`` and ``unit`` have nodes. ``sum`` has a
    # static node (the constant term) and pairs of a static coefficient and a dynamic node. A static
    # sum, ``plus``, has two nodes. ``unit`` is a quotient known to be between -1 and 1.
    kind: str
    args: tuple[Any, ...]
    static: bool  # whether it depends on no variable

    # Arithmetic with numbers is arithmetic with constants.
    def __add__(self, other: Any) -> Node:
        return _add(self, as_node(other))

    def __radd__(self, other: Any) -> Node:
        return _add(as_node(other), self)

    def __sub__(self, other: Any) -> Node:
        return _add(self, -as_node(other))

    def __rsub__(self, other: Any) -> Node:
        return _add(as_node(other), -self)

    def __mul__(self, other: Any) -> Node:
        return _multiply(self, as_node(other))

    def __rmul__(self, other: Any) -> Node:
        return _multiply(as_node(other), self)

    def __truediv__(self, other: Any) -> Node:
        return _divide(self, as_node(other))

    def __rtruediv__(self, other: Any) -> Node:
        return _divide(as_node(other), self)

    def __neg__(self) -> Node:
        return _multiply(_MINUS_ONE, self)

    def __repr__(self) -> str:
        return f"{self.kind}{self.args}"


_known: dict[tuple[Any, ...], Node] = {}


def _make(kind: str, *args: Any) -> Node:
    # Arguments are interned already, so that equality of nodes is identity.
    key = (kind, *args)
    if key not in _known:
        node = Node()
        node.kind, node.args = kind, args
        node.static = kind != "variable" and all(child.static for child in _children(node))
        _known[key] = node
    return _known[key]


def _children(node: Node) -> Iterator[Node]:
    """Yield the nodes that a node is computed from."""
    match node.kind:
        case "constant" | "parameter" | "variable":
            return
        case "sum":
            constant, *terms = node.args
            yield constant
            for term in terms:
                yield from term
        case _:
            yield from node.args


def constant(value: Scalar) -> Node:
    """Return a number as a node."""
    return _make("constant", float(value))


def variable(name: str) -> Node:
    """Return a component of the state."""
    return _make("variable", name)


def parameter(name: str) -> Node:
    """Return a node for a constant of the flight."""
    return _make("parameter", name)


def as_node(value: Any) -> Node:
    """Return a node, or a number as one."""
    return value if isinstance(value, Node) else constant(value)


ZERO, _ONE, _MINUS_ONE = constant(0.0), constant(1.0), constant(-1.0)


def _exact(a: Node, symbol: str, b: Node) -> Node:
    """Fold an operation on two constants, if the result is exactly a double."""
    operation = {"+": operator.add, "*": operator.mul, "/": operator.truediv}[symbol]
    result = operation(a.args[0], b.args[0])
    # 0.1 + 0.2 in doubles would be another number than in 40 digits: every engine has to see the
    # same constant.
    if operation(Fraction(a.args[0]), Fraction(b.args[0])) != Fraction(result):
        written = f"{a.args[0]} {symbol} {b.args[0]}"
        raise ArithmeticError(f"{written} is no double; make it a parameter")
    return constant(result)


def _add(a: Node, b: Node) -> Node:
    if a is ZERO or b is ZERO:
        return b if a is ZERO else a
    if a.static and b.static:
        if a.kind == b.kind == "constant":
            return _exact(a, "+", b)
        # Static sums are computed once; they need no form for series.
        return ZERO if b is -a else _make("plus", a, b)
    # Collect equal nodes of the two sums: 2x + 3x is 5x.
    coefficients: dict[Node, Node] = {}
    rest = ZERO
    for part in (a, b):
        more, *terms = _as_sum(part)
        rest = _add(rest, more)
        for coefficient, node in terms:
            coefficients[node] = _add(coefficients.get(node, ZERO), coefficient)
    return _sum(rest, ((c, node) for node, c in coefficients.items() if c is not ZERO))


def _sum(rest: Node, terms: Iterable[tuple[Node, Node]]) -> Node:
    pairs = tuple(terms)
    if not pairs:
        return rest
    if rest is ZERO and len(pairs) == 1 and pairs[0][0] is _ONE:
        return pairs[0][1]
    return _make("sum", rest, *pairs)


def _as_sum(node: Node) -> tuple[Any, ...]:
    """Return the constant term and the terms of a node."""
    if node.static:
        return (node,)
    return node.args if node.kind == "sum" else (ZERO, (_ONE, node))


def _multiply(a: Node, b: Node) -> Node:
    if a is ZERO or b is ZERO:
        return ZERO
    if a is _ONE or b is _ONE:
        return b if a is _ONE else a
    if a.static and b.static:
        if a.kind == b.kind == "constant":
            return _exact(a, "*", b)
        return _make("product", *((b, a) if b is _MINUS_ONE else (a, b)))
    if a.static or b.static:
        # A static factor goes into the coefficients of the sum, where it costs nothing.
        factor, node = (a, b) if a.static else (b, a)
        rest, *terms = _as_sum(node)
        return _sum(_multiply(factor, rest), ((_multiply(factor, c), x) for c, x in terms))
    (c, x), (d, y) = _scaled(a), _scaled(b)
    if c is not _ONE or d is not _ONE:
        return _multiply(_multiply(c, d), _multiply(x, y))
    # √a √a = a, without a product of series.
    if x is y and x.kind == "sqrt":
        return cast(Node, x.args[0])
    # Factors in one order: x y and y x are one node.
    return _make("product", *sorted((x, y), key=_order))


def _scaled(node: Node) -> tuple[Node, Node]:
    """Return a node as a static factor and what it multiplies."""
    if node.kind == "sum" and node.args[0] is ZERO and len(node.args) == 2:
        factor, inner = node.args[1]
        return factor, inner
    return _ONE, node


def _order(node: Node) -> tuple[int, str]:
    """Order the factors of a product: the same whatever was traced before."""
    return (0, node.args[0]) if node.kind == "variable" else (1, repr(node))


def _divide(a: Node, b: Node) -> Node:
    if b is ZERO:
        raise ZeroDivisionError("a traced formula divides by zero")
    if a is ZERO or b is _ONE:
        return a
    if a.kind == b.kind == "constant":
        return _exact(a, "/", b)
    # One static reciprocal in place of a quotient at every evaluation.
    if b.static and not a.static:
        return _multiply(_divide(_ONE, b), a)
    (c, x), (d, y) = _scaled(a), _scaled(b)
    if c is not _ONE or d is not _ONE:
        return _multiply(_divide(c, d), _divide(x, y))
    return _ONE if a is b else _make("quotient", a, b)


def _function(kind: str) -> Callable[[Any], Node]:
    def function(x: Any) -> Node:
        node = as_node(x)
        if node.kind == "constant":
            raise ArithmeticError(f"{kind}({node.args[0]}) is no double; make it a parameter")
        return _make(kind, node)

    return function


sqrt, exp, log = map(_function, ("sqrt", "exp", "log"))


def total(nodes: Iterable[Node]) -> Node:
    """Return the sum of nodes."""
    return sum(nodes, ZERO)


def square(node: Node) -> Node:
    """Return x x as a product that keeps a static factor of x inside, as `squares` knows it."""
    return _multiply(node, node) if node.static else _make("product", node, node)


def squares(node: Node) -> tuple[Node, ...]:
    """Return x, y, … of a node ``x x + y y + …``; nothing if it is another one."""
    rest, *terms = _as_sum(node)
    bases = []
    for coefficient, term in terms:
        if coefficient is not _ONE or term.kind != "product" or term.args[0] is not term.args[1]:
            return ()
        bases.append(term.args[0])
    return tuple(bases) if rest is ZERO else ()


def derivative(
    node: Node, by: Node, known: dict[Node, Node] | None = None, ratio: str = "unit"
) -> Node:
    """Return the partial derivative of a node by a variable, as a node.

    `ratio` is the kind of node for the ratio of a component to the size of its vector: ``quotient``
    if the derivative will be differentiated again.
    """
    # `known` avoids exponential work: nodes are shared between terms.
    known = {} if known is None else known
    if node in known:
        return known[node]

    def of(inner: Node) -> Node:
        return derivative(inner, by, known, ratio)

    found: Node
    match node.kind:
        case _ if node.static or node.kind == "variable":
            found = _ONE if node is by else ZERO
        case "sum":
            found = total(c * of(x) for c, x in node.args[1:])
        case "product":
            a, b = node.args
            found = of(a) * b + a * of(b)
        case "quotient":
            a, b = node.args
            found = (of(a) - node * of(b)) / b
        case "sqrt":
            (a,) = node.args
            # √(x² + y²) has the derivative x/√…, which stays bounded at 0; a'/(2√a) is 0/0 there.
            if parts := squares(a):
                # A `unit` node bounds the ratio by 1 even if numerator and denominator may be 0.
                found = total(_make(ratio, x, node) * of(x) for x in parts)
            else:
                found = of(a) / (2 * node)
        case "exp":
            (a,) = node.args
            found = node * of(a)
        case "log":
            (a,) = node.args
            found = of(a) / a
        case _:
            raise TypeError(f"a {node.kind} has no derivative")
    known[node] = found
    return found


# --- programs -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Program:
    """Straight-line code: from variables and parameters to outputs."""

    # Names, in the order of the arguments.
    variables: tuple[str, ...]
    parameters: tuple[str, ...]
    outputs: tuple[Node, ...]

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """All nodes of the outputs, each after its arguments."""
        order: dict[Node, None] = {}

        def visit(node: Node) -> None:
            # Depth first, so that arguments come before the node.
            if node not in order:
                for child in _children(node):
                    visit(child)
                order[node] = None

        for output in self.outputs:
            visit(output)
        return tuple(order)

    @cached_property
    def jacobian(self) -> Program:
        """The program whose outputs are the partial derivatives, output by output."""
        # The derivatives of all outputs by one variable share their common nodes.
        columns = [(variable(name), dict[Node, Node]()) for name in self.variables]
        return Program(
            self.variables,
            self.parameters,
            tuple(derivative(o, by, known) for o in self.outputs for by, known in columns),
        )

    @cached_property
    def source(self) -> str:
        """Source of a Python function, `program`.

        It takes the parameters and returns a function of the variables. Both call `sqrt`, `exp`,
        `log` and `unit` from their globals.
        """
        # Static nodes depend on parameters alone: they are computed once for a flight.
        names = Names()
        outer = [f"def program({', '.join(self.parameters)}):"]
        inner = [f"    def rates({', '.join(self.variables)}):"]
        for node in self.nodes:
            if text := names.define(node):
                (outer if node.static else inner).append(
                    f"    {text}" if node.static else f"        {text}"
                )
        inner.append(f"        return ({''.join(f'{names[o]}, ' for o in self.outputs)})")
        return "\n".join([*outer, *inner, "    return rates"]) + "\n"

    def bind(
        self, values: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]
    ) -> Callable[..., tuple[Any, ...]]:
        """Return the program as a function of its variables, with values of its parameters.

        `functions` gives `sqrt`, `exp`, `log` and `unit` for the number system.
        """
        # Python compiles the source once; scenes with the same law share it.
        make = run_source(self.source, "program", functions)
        bound: Callable[..., tuple[Any, ...]] = make(*(values[name] for name in self.parameters))
        return bound


class Names(dict[Node, str]):
    """Names of a program's nodes in printed code."""

    def __missing__(self, node: Node) -> str:
        if node.kind == "constant":
            name = repr(node.args[0])
            return name if node.args[0] >= 0 else f"({name})"
        if node.kind in ("variable", "parameter"):
            return str(node.args[0])
        raise KeyError(node)

    def define(self, node: Node) -> str:
        """Name a node, and return the line that computes it; "" for a constant or an argument."""
        if node.kind in ("constant", "parameter", "variable"):
            return ""
        text = self.expression(node)
        self[node] = f"x{len(self)}"
        return f"{self[node]} = {text}"

    def expression(self, node: Node) -> str:
        """Return the expression of a node in terms of the names of its arguments."""
        match node.kind:
            case "sum":
                return self.combination(node, self.__getitem__)
            case "plus":
                return " + ".join(self[x] for x in node.args)
            case "product":
                a, b = node.args
                return f"-{self[b]}" if a is _MINUS_ONE else f"{self[a]} * {self[b]}"
            case "quotient":
                return " / ".join(self[x] for x in node.args)
        return f"{node.kind}({', '.join(self[x] for x in node.args)})"

    def combination(self, node: Node, value: Callable[[Node], str], constant: bool = True) -> str:
        """Return the expression of a sum; `value` gives that of each of its nodes."""
        rest, *terms = node.args
        text = ""
        for coefficient, x in terms:
            if coefficient is _ONE or coefficient is _MINUS_ONE:
                sign, term = "-" if coefficient is _MINUS_ONE else "+", value(x)
            else:
                sign, term = "+", f"{self[coefficient]} * {value(x)}"
            text += f" {sign} {term}" if text else (f"-{term}" if sign == "-" else term)
        return text if rest is ZERO or not constant else f"{text} + {self[rest]}"


def run_source(source: str, name: str, functions: Mapping[str, Callable[..., Any]]) -> Any:
    """Run printed code with the functions that it calls, and return the object of a name."""
    return _run(source, tuple(functions.items()))[name]


@lru_cache(maxsize=256)
def _run(source: str, functions: tuple[tuple[str, Callable[..., Any]], ...]) -> dict[str, Any]:
    space: dict[str, Any] = dict(functions)
    exec(compile(source, "<traced>", "exec"), space)
    return space


def trace(
    formula: Callable[..., Sequence[Any]], variables: Sequence[str], parameters: Sequence[str]
) -> Program:
    """Return the program of a function that takes variables and parameters, one by one."""
    inputs = [*map(variable, variables), *map(parameter, parameters)]
    outputs = tuple(as_node(output) for output in formula(*inputs))
    return Program(tuple(variables), tuple(parameters), outputs)


# --- derivatives by variables and parameters ------------------------------------------------------

# Of the names of derivatives.
RATE = "_rate"


@cache
def partials(program: Program) -> tuple[tuple[Node, ...], ...]:
    """Return the derivatives of a program's outputs, output by output.

    They are by the variables and by the parameters, in order.
    """
    known = (*program.variables, *program.parameters)
    # `derivative` differentiates by variables: make the parameters variables, too.
    names = [variable(name) for name in known]
    # A unit vector's component is x/r, whose derivative is that of the quotient.
    functions: dict[str, Callable[..., Any]] = {
        "sqrt": sqrt,
        "exp": exp,
        "log": log,
        "unit": operator.truediv,
    }
    of_names = program.bind(dict(zip(known, names, strict=True)), functions)
    derived: list[dict[Any, Any]] = [{} for _ in known]
    derivatives = [
        derivative(as_node(output), name, known_so_far)
        for output in of_names(*names[: len(program.variables)])
        for name, known_so_far in zip(names, derived, strict=True)
    ]
    # Turn the parameters back, so that what depends on them alone is computed once for a flight.
    as_they_were = (*map(variable, program.variables), *map(parameter, program.parameters))
    bound = Program(known, (), tuple(derivatives)).bind({}, functions)(*as_they_were)
    nodes = tuple(map(as_node, bound))
    return tuple(nodes[i : i + len(known)] for i in range(0, len(nodes), len(known)))


@cache
def variational(program: Program) -> Program:
    """Return the program of a law ``state' = f(state, p)`` and its variational equation.

    ``ξ' = (∂f/∂state) ξ + ∂f/∂p dp/dx`` for the derivative ξ of a state by a number x (Hairer,
    Nørsett and Wanner, *Solving Ordinary Differential Equations I*, Sec. I.14). Variables and
    parameters are followed by their derivatives.
    """
    rates = [
        *(variable(name + RATE) for name in program.variables),
        *(parameter(name + RATE) for name in program.parameters),
    ]
    changes = (
        total(slope * rate for slope, rate in zip(slopes, rates, strict=True))
        for slopes in partials(program)
    )
    return Program(
        (*program.variables, *(name + RATE for name in program.variables)),
        (*program.parameters, *(name + RATE for name in program.parameters)),
        (*program.outputs, *changes),
    )


@cache
def with_partials(program: Program) -> Program:
    """Return a program whose outputs are followed by their derivatives, as of `partials`."""
    slopes = tuple(slope for of_output in partials(program) for slope in of_output)
    return Program(program.variables, program.parameters, (*program.outputs, *slopes))
