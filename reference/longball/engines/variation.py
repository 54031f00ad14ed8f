"""The variational equation of a law: how flights change with their start and its strengths.

``ξ' = (∂f/∂state) ξ + ∂f/∂p dp/dx`` for the derivative ξ of a state by a number x, with a law
``state' = f(state, p)`` (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*,
Sec. I.14).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from operator import truediv
from typing import Any

from longball.model import trace
from longball.model.trace import Program, parameter, variable

# Of the names of derivatives.
RATE = "_rate"


@cache
def partials(program: Program) -> tuple[tuple[trace.Node, ...], ...]:
    """Return the derivatives of a program's outputs, output by output.

    They are by the variables and by the parameters, in order.
    """
    known = (*program.variables, *program.parameters)
    # `trace.derivative` takes derivatives by variables: make the parameters variables, too.
    names = [variable(name) for name in known]
    # A unit vector's component is x/r, whose derivative is that of the quotient.
    functions: dict[str, Callable[..., Any]] = {
        "sqrt": trace.sqrt,
        "exp": trace.exp,
        "log": trace.log,
        "unit": truediv,
    }
    of_names = program.bind(dict(zip(known, names, strict=True)), functions)
    derived: list[dict[Any, Any]] = [{} for _ in known]
    derivatives = [
        trace.derivative(trace.as_node(output), name, known_so_far)
        for output in of_names(*names[: len(program.variables)])
        for name, known_so_far in zip(names, derived, strict=True)
    ]
    # Turn the parameters back, so that what depends on them alone is computed once for a flight.
    as_they_were = (*map(variable, program.variables), *map(parameter, program.parameters))
    bound = Program(known, (), tuple(derivatives)).bind({}, functions)(*as_they_were)
    nodes = tuple(map(trace.as_node, bound))
    return tuple(nodes[i : i + len(known)] for i in range(0, len(nodes), len(known)))


@cache
def variational(program: Program) -> Program:
    """Return the program of a law together with its variational equation.

    Variables and parameters are followed by their derivatives.
    """
    rates = [
        *(variable(name + RATE) for name in program.variables),
        *(parameter(name + RATE) for name in program.parameters),
    ]
    changes = (
        trace.total(slope * rate for slope, rate in zip(slopes, rates, strict=True))
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
