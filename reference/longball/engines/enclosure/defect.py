"""The defect of polynomials as solutions of a traced law."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from flint import arb, arb_poly

from longball.engines.enclosure import lemmas
from longball.engines.enclosure.lemmas import INFINITE, largest, least
from longball.model.trace import Node, Program, variable

_NOTHING = arb(0)

# Nodes of which a polynomial has only an approximation.
TRANSCENDENTAL = ("sqrt", "quotient", "exp", "log")


class Defect:
    """Residuals of polynomials in a program's equations ``x' = f(x)``."""

    def __init__(
        self,
        program: Program,  # its outputs are the rates of its variables
        static: Mapping[Node, arb],  # values of the static nodes
        # Polynomials with exact coefficients, for the variables and the nodes that are neither sums
        # nor products. However they were found: whatever they are, the bounds hold
        approximations: Mapping[Node, arb_poly],
    ) -> None:
        self._static = static
        self._nodes = dynamic(program)
        value: dict[Node, Any] = {**static, **approximations}
        self._value = value
        self._residual: dict[Node, arb_poly] = {}
        self._start: dict[Node, arb] = {}
        for node in self._nodes:
            if node.kind in TRANSCENDENTAL:
                self._residual[node] = _residual(node, value)
                if node.kind in ("exp", "log"):
                    first = getattr(value[node.args[0]][0], node.kind)()
                    self._start[node] = abs(value[node][0] - first).upper()
            else:
                value[node] = polynomial_of(node, value)
        # p' - f(p), where each output has a separate polynomial: the remainder is its error.
        self._misses = [
            value[variable(name)].derivative() - value[rate]
            for name, rate in zip(program.variables, program.outputs, strict=True)
        ]
        self._outputs = program.outputs

    def polynomial(self, node: Node) -> arb_poly:
        """Return the polynomial that approximates a node."""
        polynomial: arb_poly = self._value[node]
        return polynomial

    def bounds(self, h: arb) -> list[arb]:
        """Bound ``|x' - f(x)|`` from 0 to h, for each variable."""
        errors = self.errors(h)
        return [
            largest(miss, h) + errors.get(rate, _NOTHING)
            for miss, rate in zip(self._misses, self._outputs, strict=True)
        ]

    def errors(self, h: arb) -> dict[Node, arb]:
        """Bound how far the polynomials of nodes are from the nodes' values, where they are not."""
        errors: dict[Node, arb] = {}
        for node in self._nodes:
            if node.kind in TRANSCENDENTAL:
                errors[node] = self._own_error(node, errors, h)
            # Sums and products are exact in the polynomials, and only propagate errors.
            elif node.kind == "sum":
                terms = [(self._static[c], errors[x]) for c, x in node.args[1:] if x in errors]
                if terms:
                    errors[node] = lemmas.combination_error(terms)
            elif node.args[0] in errors or node.args[1] in errors:
                sizes = (largest(self._value[x], h) for x in node.args)
                parts = (errors.get(x, _NOTHING) for x in node.args)
                errors[node] = lemmas.product_error(*sizes, *parts)
        return errors

    def _own_error(self, node: Node, errors: Mapping[Node, arb], h: arb) -> arb:
        """Bound the error of a node with a separate approximation."""
        value, residual, first = self._value, self._residual[node], node.args[0]
        error = errors.get(first, _NOTHING)
        if node.kind == "sqrt":
            return _root_error(value[node], residual, error, h)
        missed = largest(residual, h)
        match node.kind:
            case "quotient":
                bottom = value[node.args[1]]
                return lemmas.quotient_error(
                    missed,
                    largest(value[node], h),
                    error,
                    errors.get(node.args[1], _NOTHING),
                    least(bottom if bottom[0] > 0 else -bottom, h),
                )
            case "exp":
                rate = largest(value[first].derivative(), h)
                return lemmas.exponential_error(
                    self._start[node], missed, rate, error, largest(value[node], h), h
                )
        return lemmas.logarithm_error(self._start[node], missed, error, least(value[first], h), h)


def polynomial_of(node: Node, value: Mapping[Node, Any]) -> arb_poly:
    """Return the polynomial of a sum or product of polynomials."""
    if node.kind == "product":
        a, b = node.args
        product: arb_poly = value[a] * value[b]
        return product
    constant, *terms = node.args
    total = arb_poly([value[constant]])
    for c, x in terms:
        total += value[c] * value[x]
    return total


def _residual(node: Node, value: Mapping[Node, Any]) -> arb_poly:
    """Return the residual of an approximation in its node's equation."""
    n, a = value[node], value[node.args[0]]
    residual: arb_poly
    match node.kind:
        case "sqrt":
            residual = n * n - a
        case "quotient":
            residual = n * value[node.args[1]] - a
        case "exp":
            residual = n.derivative() - a.derivative() * n
        case "log":
            residual = a * n.derivative() - a.derivative()
        case kind:
            raise TypeError(f"a {kind} has no residual")
    return residual


def _root_error(root: arb_poly, residual: arb_poly, error: arb, h: arb) -> arb:
    """Apply `lemmas.root_error`, with the power of t divided out that the root starts with."""
    power = leading(root)
    if power is None:
        # N = 0 is the root of zero.
        return (largest(residual, h) + error).sqrt().upper()
    if power > 0:
        if error > 0 or any(not residual[n].is_zero() for n in range(power)):
            return INFINITE
        root, residual = root.right_shift(power), residual.right_shift(power)
    return lemmas.root_error(largest(residual, h), error, least(root, h))


def leading(polynomial: arb_poly) -> int | None:
    """Return the order of the first coefficient that is not zero; None if all are."""
    coefficients = polynomial.coeffs()
    return next((n for n, c in enumerate(coefficients) if not c.is_zero()), None)


@cache
def dynamic(program: Program) -> tuple[Node, ...]:
    """Return the nodes that are computed from variables, in the order of evaluation."""
    return tuple(n for n in program.nodes if not n.static and n.kind != "variable")
