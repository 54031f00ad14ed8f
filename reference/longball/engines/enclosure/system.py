"""A law as the enclosure needs it, made once for a flight."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from flint import arb

from longball.engines.enclosure.balls import Balls
from longball.engines.enclosure.defect import dynamic
from longball.engines.series import recurrence
from longball.model.law import Law
from longball.model.trace import ZERO, Node, Program, constant, squares, variable

# s; an error in a position counts as much as one in a velocity of it in this time. Positions that
# forces depend on are bound to velocities by rates of this size at most, next to which the
# dependence on position of any force on a ball is weak.
_TIME_SCALE = 8.0


@dataclass(frozen=True)
class Structure:
    """Dependence of the variables of a program on each other."""

    # The program of those variables that rates depend on, and of those whose rates are not linear
    core: Program
    weights: tuple[float, ...]  # in the norm of the core
    # The linear rates of the other variables: a constant, and coefficients of core variables
    quadratures: Mapping[str, tuple[Node, Sequence[tuple[Node, Node]]]]
    # Indices in the core of what is zero at rest: the parts of the roots ``√(x x + y y + …)``, if
    # they are variables. Empty: the law is smooth where the ball is at rest
    resting: tuple[int, ...]
    # Nodes of the core that must not come to zero on a step: roots, denominators and arguments of
    # logarithms
    guarded: tuple[Node, ...]
    jacobian: Program


@cache
def structure(program: Program) -> Structure:
    """Return the dependences between the variables of a program."""
    used = {node.args[0] for node in program.nodes if node.kind == "variable"}
    rates = dict(zip(program.variables, program.outputs, strict=True))
    quadratures = {
        name: linear
        for name, rate in rates.items()
        if name not in used and (linear := _linear(rate)) is not None
    }
    names = tuple(name for name in program.variables if name not in quadratures)
    core = Program(names, program.parameters, tuple(rates[name] for name in names))
    parts = {part for root in recurrence(core).roots for part in squares(root.args[0])}
    still = all(part.kind == "variable" for part in parts)
    return Structure(
        core=core,
        weights=tuple(1 / _TIME_SCALE if rates[n].kind == "variable" else 1.0 for n in names),
        quadratures=quadratures,
        resting=tuple(n for n, name in enumerate(names) if still and variable(name) in parts),
        guarded=tuple(filter(None, map(recurrence(core).divisor, dynamic(core)))),
        jacobian=core.jacobian,
    )


def _linear(node: Node) -> tuple[Node, Sequence[tuple[Node, Node]]] | None:
    """Return the constant and the terms of a linear combination of variables."""
    if node.static:
        return node, ()
    if node.kind == "variable":
        return ZERO, ((constant(1.0), node),)
    if node.kind == "sum" and all(x.kind == "variable" for _, x in node.args[1:]):
        return node.args[0], node.args[1:]
    return None


class System:
    """The equations of a flight, with the values of their parameters."""

    def __init__(self, law: Law, balls: Balls) -> None:
        self.structure = structure(law.program)
        core = self.structure.core
        values = [law.strengths[name] for name in core.parameters]
        self.static = static_values(law.program, law.strengths, balls.functions)
        self._parameters = values
        self._functions = balls.functions
        self._jacobian = self.structure.jacobian.bind(law.strengths, balls.functions)
        self._recurrence = recurrence(core)
        # The nodes of which there are series, and the sizes of vectors among them
        self.rows = self._recurrence.rows
        self.roots = self._recurrence.roots

    def series(self, start: Sequence[arb], order: int, at_rest: bool) -> dict[Node, list[arb]]:
        """Return the Taylor coefficients of variables and other nodes, from a state of the core."""
        rows = [[arb(0)] * (order + 2) for _ in self.rows]
        for row, value in zip(rows, start, strict=False):
            row[0] = value
        expand = self._recurrence.function(self._functions, at_rest)
        expand(rows, order, *self._parameters)
        return dict(zip(self.rows, rows, strict=True))

    def jacobian(self, state: Sequence[arb]) -> list[Sequence[arb]]:
        """Enclose the partial derivatives of the core's rates over a box of states."""
        entries = self._jacobian(*state)
        n = len(state)
        return [entries[i * n : (i + 1) * n] for i in range(n)]


def static_values(
    program: Program, strengths: Mapping[str, arb], functions: Mapping[str, Callable[..., arb]]
) -> dict[Node, arb]:
    """Return the values of the nodes that depend on parameters alone."""
    nodes = (ZERO, constant(1.0), *(node for node in program.nodes if node.static))
    values = Program((), program.parameters, nodes).bind(strengths, functions)()
    return dict(zip(nodes, map(arb, values), strict=True))
