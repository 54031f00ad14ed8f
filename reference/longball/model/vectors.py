"""Vectors of three numbers of any kind: floats, balls, columns, nodes of a traced formula."""

from __future__ import annotations

from typing import Any

from longball.model import trace
from longball.model.numbers import Vector
from longball.model.trace import ZERO, Node


def plus(a: Vector, b: Vector) -> Vector:
    """Return ``a + b``."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Return ``a - b``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(factor: Any, a: Vector) -> Vector:
    """Return ``factor a``."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Vector, b: Vector) -> Any:
    """Return ``a · b``."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return ``a × b``."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def part_across(a: Vector, b: Vector, square: Any) -> Vector:
    """Return ``b² a - (a·b) b``: the component of a across b, times the given b²."""
    # Without the division by b², which may be 0.
    return minus(scaled(square, a), scaled(dot(a, b), b))


def norm(a: Vector) -> Node:
    """Return ``|a|`` of a vector of nodes, in the form that `trace.squares` recognises."""
    # A sum of squares under a root has bounded derivatives; see `trace.derivative`.
    squared = trace.total(trace.square(x) for x in a if x is not ZERO)
    return squared if squared is ZERO else trace.sqrt(squared)
