"""Expressions with units, evaluated on columns of scenes.

A formula of the chain is a graph of nodes. Equal nodes are one object, so that a definition that
two formulas share is edited once. A node carries its dimension and knows whether it is a vector:
edits replace a node by another of the same kind. Values are columns with one entry for each scene;
a vector is an array of three rows.

>>> m, M = symbol("m", KG), symbol("M", KG)
>>> mu = named("μ", m * M / (m + M))
>>> words(substitute(2.0 * mu, mu, m))
'2·m'
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from operator import attrgetter
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from longball.model.arrays import Array

Dimension = tuple[int, int, int]  # exponents of m, kg, s
Columns = Mapping[str, Any]  # values by symbol: an array, or the codes of a switch

NONE: Dimension = (0, 0, 0)
M, KG, S = (1, 0, 0), (0, 1, 0), (0, 0, 1)


class Node:
    """A node of an expression; made by the functions below, compared by identity.

    Attributes
    ----------
    op
        The operation: a key of `OPERATIONS`, "symbol", "constant", "switch", "table", …
    args
        The nodes that it is applied to.
    data
        Further data of the operation, such as the name of a symbol; None for most.
    dimension, vector
        The exponents of m, kg and s; True for a vector.
    digest
        A hash of all the above. Unlike the identity, it is the same if a node is made again after
        it was dropped.

    Examples
    --------
    >>> m, M = symbol("m", KG), symbol("M", KG)
    >>> total = m + M
    >>> total.op, total.args, total.dimension
    ('sum', (m, M), (0, 1, 0))
    >>> m + M is total
    True
    >>> evaluate(m * M / total, {"m": np.array([0.1, 0.2]), "M": np.array([0.9, 0.8])})
    array([0.09, 0.16])
    """

    __slots__ = ("__weakref__", "args", "data", "digest", "dimension", "op", "vector")

    op: str
    args: tuple[Node, ...]
    data: Any
    dimension: Dimension
    vector: bool
    digest: int

    def __add__(self, other: Node | float) -> Node:
        return _node("sum", (self, as_node(other)), None, self.dimension, self.vector)

    def __radd__(self, other: Node | float) -> Node:
        return as_node(other) + self

    def __sub__(self, other: Node | float) -> Node:
        return self + -as_node(other)

    def __rsub__(self, other: Node | float) -> Node:
        return as_node(other) + -self

    def __neg__(self) -> Node:
        return _node("negative", (self,), None, self.dimension, self.vector)

    def __mul__(self, other: Node | float) -> Node:
        other = as_node(other)
        dimension = _sum(self.dimension, other.dimension)
        return _node("product", (self, other), None, dimension, self.vector or other.vector)

    def __rmul__(self, other: Node | float) -> Node:
        return as_node(other) * self

    def __truediv__(self, other: Node | float) -> Node:
        other = as_node(other)
        dimension = _sum(self.dimension, other.dimension, -1)
        return _node("quotient", (self, other), None, dimension, self.vector)

    def __rtruediv__(self, other: Node | float) -> Node:
        return as_node(other) / self

    def __repr__(self) -> str:
        return words(self)


# All nodes in use. A search makes millions of them; with weak references, the nodes of dropped
# edits are freed.
_known: WeakValueDictionary[Any, Node] = WeakValueDictionary()


def _node(
    op: str, args: tuple[Node, ...], data: Any, dimension: Dimension, vector: bool = False
) -> Node:
    # Ids are safe as keys: a node keeps its arguments alive, so their ids are not reused while the
    # key exists.
    key = op, tuple(map(id, args)), data, dimension, vector
    found = _known.get(key)
    if found is None:
        found = Node()
        found.op, found.args, found.data = op, args, data
        found.dimension, found.vector = dimension, vector
        found.digest = hash((op, tuple(arg.digest for arg in args), data, dimension, vector))
        _known[key] = found
    return found


def _sum(a: Dimension, b: Dimension, sign: int = 1) -> Dimension:
    return (a[0] + sign * b[0], a[1] + sign * b[1], a[2] + sign * b[2])


# --- nodes ----------------------------------------------------------------------------------------


def as_node(x: Node | float) -> Node:
    """A node as it is, or a number as a constant without a unit."""
    return x if isinstance(x, Node) else constant(x)


def constant(x: float, dimension: Dimension = NONE, vector: bool = False) -> Node:
    """A constant number; for a vector, the value of every component."""
    return _node("constant", (), float(x), dimension, vector)


def symbol(name: str, dimension: Dimension = NONE, vector: bool = False) -> Node:
    """A variable: a column of values from the scenes or the answers."""
    return _node("symbol", (), name, dimension, vector)


def named(name: str, x: Node) -> Node:
    """A definition: `x` under a name, which verdicts print in its place."""
    return _node("named", (x,), name, x.dimension, x.vector)


def function(op: str, *args: Node, dimension: Dimension = NONE, vector: bool = False) -> Node:
    """A function of `OPERATIONS`, such as sin or exp, applied to nodes."""
    return _node(op, args, None, dimension, vector)


def norm(v: Node) -> Node:
    """The length of a vector."""
    return _node("norm", (v,), None, v.dimension)


def unit(v: Node) -> Node:
    """The direction of a vector; 0 of a vector that is 0."""
    return _node("unit", (v,), None, NONE, True)


def dot(a: Node, b: Node) -> Node:
    """The scalar product."""
    return _node("dot", (a, b), None, _sum(a.dimension, b.dimension))


def cross(a: Node, b: Node) -> Node:
    """The vector product."""
    return _node("cross", (a, b), None, _sum(a.dimension, b.dimension), True)


def each(op: str, a: Node, b: Node) -> Node:
    """The product of two vectors, component by component ("by_component")."""
    return _node(op, (a, b), None, _sum(a.dimension, b.dimension), True)


def vector(x: Node | float, y: Node | float, z: Node | float) -> Node:
    """The vector of three components."""
    parts = as_node(x), as_node(y), as_node(z)
    # A component 0 may be written without its unit. The vector has the unit of the other
    # components.
    dimension = max((p.dimension for p in parts), key=lambda d: sum(map(abs, d)))
    return _node("vector", parts, None, dimension, True)


def component(v: Node, i: int) -> Node:
    """The component x, y or z of a vector."""
    return _node("component", (v,), i, v.dimension)


def axes(v: Node, rows: tuple[tuple[float, ...], ...], name: str) -> Node:
    """A vector with signed, masked or exchanged axes."""
    return _node("axes", (v,), (rows, name), v.dimension, True)


def solve(columns: tuple[Node, Node, Node], right: Node) -> Node:
    """The solution x of ``K x = right`` for a matrix K of three columns."""
    dimension = _sum(right.dimension, columns[0].dimension, -1)
    return _node("solve", (*columns, right), None, dimension, True)


def where(condition: Node, yes: Node, no: Node) -> Node:
    """One of two values: `yes` where the condition is positive, `no` elsewhere."""
    return _node("where", (condition, yes, no), None, yes.dimension, yes.vector)


def switch(key: str, options: Mapping[str, Node]) -> Node:
    """One of several values, chosen by each scene's option of a key."""
    first = next(iter(options.values()))
    assert all(option.vector == first.vector for option in options.values()), key
    data = key, tuple(options)
    return _node("switch", tuple(options.values()), data, first.dimension, first.vector)


def table(x: Node, key: str, mode: str = "linear") -> Node:
    """Value at `x` of a scene's table, from columns ``key.at``, ``key.values`` (nodes, scenes)."""
    return _node("table", (x,), (key, mode), NONE)


ARGUMENT = symbol("a", NONE, True)  # of the function in `matrix`


def matrix(name: str, form: Node) -> Node:
    """The matrix of a linear function of vectors, from the function's value for `ARGUMENT`.

    A program has the function once. An edit of the form is in all columns of the matrix.
    """
    columns = (substitute(form, ARGUMENT, vector(*row)) for row in UNIT)
    return _node("matrix", (form, *columns), name, form.dimension)


UNIT = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)  # the rows of the unit matrix


def times(k: Node, v: Node) -> Node:
    """A matrix applied to a vector."""
    return _node("times", (k, v), None, _sum(k.dimension, v.dimension), True)


# --- graphs ---------------------------------------------------------------------------------------


def evaluated(node: Node) -> tuple[Node, ...]:
    """The arguments from which a node's value is computed."""
    return node.args[1:] if node.op == "matrix" else node.args


def ordered(
    roots: Iterable[Node],
    known: Container[Node] = (),
    arguments: Callable[[Node], Sequence[Node]] = attrgetter("args"),
) -> list[Node]:
    """Nodes below the roots, each once, arguments first.

    The walk stops at `known` nodes. `arguments` gives the arguments of a node that are followed.
    """
    found: dict[Node, None] = {}
    stack = [(root, False) for root in reversed(list(roots))]
    while stack:
        node, has_arguments = stack.pop()
        if node in found:
            continue
        if has_arguments or not node.args or node in known:
            found[node] = None
        else:
            # The node goes on the stack below its arguments, and is visited again after them.
            stack.append((node, True))
            stack += [(arg, False) for arg in reversed(arguments(node))]
    return list(found)


def rebuilt(node: Node, args: Sequence[Node]) -> Node:
    """A node with other arguments."""
    return _node(node.op, tuple(args), node.data, node.dimension, node.vector)


@lru_cache(maxsize=4096)
def _nodes(root: Node) -> tuple[Node, ...]:
    return tuple(ordered([root]))


@lru_cache(maxsize=16384)
def _using(root: Node, old: Node) -> tuple[Node, ...]:
    """Nodes of an expression that contain another node, arguments first."""
    above = {old: None}
    for node in _nodes(root):
        for arg in node.args:
            if arg in above:
                above[node] = None
                break
    return tuple(above)[1:]  # without the node itself


def substitute(root: Node, old: Node, new: Node) -> Node:
    """An expression with `new` in place of the node `old`, wherever it is used."""
    # Only the nodes above `old` are rebuilt; all others are shared with the old expression.
    made = {old: new}
    for node in _using(root, old):
        made[node] = rebuilt(node, [made.get(arg, arg) for arg in node.args])
    return made.get(root, root)


def contains(root: Node, node: Node) -> bool:
    """True if an expression is a node or uses it."""
    return root is node or bool(_using(root, node))


@lru_cache(maxsize=16384)
def depends(root: Node, names: frozenset[str]) -> bool:
    """True if an expression contains one of some symbols."""
    return any(node.op == "symbol" and node.data in names for node in _nodes(root))


@lru_cache(maxsize=1024)
def names_in(roots: tuple[Node, ...]) -> tuple[str, ...]:
    """Names of the columns that expressions read."""
    found: dict[str, None] = {}
    for node in ordered(roots):
        match node.op:
            case "symbol":
                found[node.data] = None
            case "switch":
                found[node.data[0]] = None
            case "table":
                found |= {f"{node.data[0]}.at": None, f"{node.data[0]}.values": None}
    return tuple(found)


def specialised(root: Node, columns: Columns, made: dict[Node, Node]) -> Node:
    """An expression without the switches that have one option in all scenes.

    `made` maps each node to its new form. Calls for other expressions of the same scenes share it.
    """
    for node in ordered([root]):
        if node in made:
            continue
        args = [made[arg] for arg in node.args]
        if node.op == "switch" and node.data[0] in columns:
            options = [i for i in node.data[1] if (columns[node.data[0]] == i).any()]
            if len(options) == 1:
                made[node] = args[node.data[1].index(options[0])]
                continue
        made[node] = _folded(rebuilt(node, args))
    return made[root]


def digests(roots: Sequence[Node], columns: Columns) -> Array:
    """Numbers, of shape (roots, scenes), that tell formulas apart, with each scene's options."""
    # A switch has the number of the argument that a scene chooses. Nodes above switches mix those
    # of their arguments; all others have one number, the digest.
    made: dict[Node, Any] = {}
    for node in ordered(roots):
        args = [made[arg] for arg in node.args]
        if node.op == "switch":
            key, options = node.data
            made[node] = np.uint64(0)  # of an option that the node does not have
            for option, arg in zip(options, args, strict=True):
                made[node] = np.where(columns[key] == option, arg, made[node])
        elif any(isinstance(arg, np.ndarray) for arg in args):
            made[node] = np.uint64(hash((node.op, node.data, node.dimension)) % 2**64)
            for arg in args:
                made[node] = made[node] * _PRIME ^ arg
        else:
            made[node] = np.uint64(node.digest % 2**64)
    rows = np.broadcast_arrays(*(made[root] for root in roots), columns["kind"])[:-1]
    return np.array(rows, dtype=np.uint64)


_PRIME = np.uint64(0x9E3779B97F4A7C15)  # 2⁶⁴ by the golden ratio: the product spreads all bits


def _folded(node: Node) -> Node:
    """A simplified node: terms 0, factors 1, double signs and second names are dropped."""

    def is_(arg: Node, value: float) -> bool:
        return arg.op == "constant" and arg.data == value

    match node.op, node.args:
        case "sum", (a, b) if is_(a, 0.0) or is_(b, 0.0):
            return b if is_(a, 0.0) else a
        case "product", (a, b) if is_(a, 0.0) or is_(b, 0.0):
            return constant(0.0, node.dimension, node.vector)
        # A 1 with a unit stays: it gives the number beside it that unit.
        case "product", (a, b) if (is_(a, 1.0) and a.dimension == NONE) or (
            is_(b, 1.0) and b.dimension == NONE
        ):
            return b if is_(a, 1.0) and a.dimension == NONE else a
        case "quotient", (a, _) if is_(a, 0.0):
            return constant(0.0, node.dimension, node.vector)
        # -1·(-1·x), from an edit that flips a sign which is flipped already.
        case "product", (a, b) if is_(a, -1.0) and b.op == "product" and is_(b.args[0], -1.0):
            return b.args[1]
        case (("negative" | "norm" | "named"), (a,)) if is_(a, 0.0):
            return constant(0.0, node.dimension, node.vector)
        case "cross", (a, b) if is_(a, 0.0) or is_(b, 0.0):
            return constant(0.0, node.dimension, True)
        case "named", (a,) if a.op in ("symbol", "constant") or a.data == node.data:
            return a
    return node


# --- values ---------------------------------------------------------------------------------------


_NEXT, _PREVIOUS = np.array([1, 2, 0]), np.array([2, 0, 1])  # axes


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(
        a.take(_NEXT, 0) * b.take(_PREVIOUS, 0) - a.take(_PREVIOUS, 0) * b.take(_NEXT, 0)
    )


def _norm(v: Array) -> Array:
    return np.asarray(np.sqrt(np.add.reduce(v * v)))


def _unit(v: Array) -> Array:
    # The direction of a zero vector is 0, as in the model: the term that it multiplies vanishes.
    size = _norm(v)
    return v / np.where(size > 0, size, 1.0)


def _vector(*components: Any) -> Array:
    found = np.empty((3, *(np.broadcast(*components).shape or (1,))))
    found[0], found[1], found[2] = components
    return found


def _solved(a: Array, b: Array, c: Array, right: Array) -> Array:
    # An edit may make the matrix of a scene singular. NumPy would then raise an error for all
    # scenes, so that only the regular ones are solved.
    matrix = np.array(np.broadcast_arrays(a, b, c, right)).transpose(2, 1, 0)
    sound = np.isfinite(matrix).all(axis=(1, 2)) & (np.linalg.det(matrix[:, :, :3]) != 0)
    found = np.full((3, len(matrix)), np.nan)
    found[:, sound] = np.linalg.solve(matrix[sound, :, :3], matrix[sound, :, 3:])[:, :, 0].T
    return found


OPERATIONS: dict[str, Callable[..., Any]] = {
    "sum": np.add,
    "product": np.multiply,
    "quotient": np.divide,
    "negative": np.negative,
    "named": lambda x: x,
    "matrix": lambda *columns: np.array(np.broadcast_arrays(*columns)),
    "times": lambda k, v: np.add.reduce(k * v[:, None]),
    "norm": _norm,
    "sizes": lambda v: np.abs(v).sum(0),  # |x| + |y| + |z|
    "unit": _unit,
    "dot": lambda a, b: np.add.reduce(a * b),
    "cross": _cross,
    "by_component": np.multiply,
    "by_own_size": lambda v, w: np.abs(v) * w,  # drag axis by axis: |v_x| w_x, …
    "vector": _vector,
    "solve": _solved,
    "where": lambda condition, yes, no: np.where(condition > 0, yes, no),
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "sqrt": np.sqrt,
    "square": np.square,
    "abs": np.abs,
    "positive": lambda x: np.maximum(x, 0.0),
    "least": np.minimum,
    "rises": lambda x: (x > 0) * 1.0,  # 1 where the argument is positive, else 0
    "truncated": np.trunc,
    "single": lambda x: np.float64(np.float32(x)),
    **{f"rounded_{i}": partial(np.round, decimals=i) for i in range(4)},
}


# Operations with a jump or a kink where their first argument is 0 (for `least`, where the arguments
# are equal). A fixed step of an integrator across it loses its order.
JUMPS = frozenset(("rises", "where"))
KINKS = frozenset(("abs", "positive", "least", "sizes", "by_own_size"))


def _table(at: Array, values: Array, mode: str) -> Callable[[Array], Array]:
    """A function that interpolates in the table of each scene.

    The value at x is the first value plus, for every segment, its slope times the length of its
    part below x. This is one expression for all scenes, although their nodes differ.
    """
    mode, _, limited = mode.partition(" or ")
    widths = np.diff(at, axis=0)
    long = widths > 0  # tables are filled up with their last nodes
    slopes = np.where(long, np.diff(values, axis=0) / np.where(long, widths, 1.0), 0.0)
    last = long.cumsum(axis=0).argmax(axis=0)  # number of the last segment that has a length
    # The part of a segment lies between 0 and its width, so that a table is constant outside. To
    # extrapolate, the first or the last segment loses its limit.
    low, high = np.zeros_like(widths), widths.copy()
    if mode in ("extrapolated", "extrapolated below"):
        low[0] = -np.inf
    balls = np.arange(at.shape[1])
    if mode in ("extrapolated", "extrapolated above"):
        high[last, balls] = np.inf
    if mode == "short":
        high[last, balls] = 0.0
    first, start = values[0], at[:-1]
    slip, _, where_slipped = mode.partition(" in the ")
    chosen = np.ones_like(long)
    if where_slipped == "first segment":
        chosen[1:] = False
    elif where_slipped == "last segment":
        chosen = np.arange(len(long))[:, None] == last

    if mode in CURVES:
        b, c, d = _cubics(at, values, CURVES[mode])

        def curve(x: Array) -> Any:
            part = np.clip(x - start, 0.0, widths)
            return first + np.add.reduce(part * (b + part * (c + part * d)))

        return curve

    def line(x: Array) -> Any:
        within = np.minimum(np.maximum(x - start, low), high)
        if slip in SLIPS:
            inside = chosen & (x > start) & (x < at[1:])
            within = np.where(inside, SLIPS[slip](within, widths), within)
        found = first + np.add.reduce(slopes * within)
        return np.maximum(found, 0.0) if limited else found

    return line


# Curves between the nodes, by their slopes there.
CURVES: Mapping[str, Callable[[Array, Array], Array]] = {
    "smoothed": lambda x, y: np.zeros_like(x),
    "spline": lambda x, y: CubicSpline(x, y)(x, 1),
    "monotonic": lambda x, y: PchipInterpolator(x, y)(x, 1),
}


def _cubics(
    at: Array, values: Array, slopes: Callable[[Array, Array], Array]
) -> tuple[Array, Array, Array]:
    """Coefficients of the part of each segment, of its square and of its cube: Hermite's cubic."""
    found = np.zeros((3, len(at) - 1, at.shape[1]))
    for ball in range(at.shape[1]):
        count = 1 + np.count_nonzero(np.diff(at[:, ball]))  # tables are filled up
        x, y = at[:count, ball], values[:count, ball]
        if not (np.diff(x) > 0).all():  # nodes moved at random, through which there is no curve
            found[:, :, ball] = np.nan
            continue
        m, width, rise = slopes(x, y), np.diff(x), np.diff(y) / np.diff(x)
        found[0, : count - 1, ball] = m[:-1]
        found[1, : count - 1, ball] = (3 * rise - 2 * m[:-1] - m[1:]) / width
        found[2, : count - 1, ball] = (m[:-1] + m[1:] - 2 * rise) / width**2
    return found[0], found[1], found[2]


# Wrong lengths of the part of a segment, from the right length and the width.
SLIPS: Mapping[str, Callable[[Array, Array], Array]] = {
    "previous node": lambda part, width: 0.0 * width,
    "next node": lambda part, width: width,
    "middle": lambda part, width: 0.5 * width,
    "exchanged": lambda part, width: width - part,
}


def _occurring(node: Node, columns: Columns) -> dict[int, Array]:
    """Options of a switch that some scenes have, by number, with those scenes' flags.

    If there are no scenes, it is the first option, whose value has the right shape.
    """
    key, options = node.data
    column = np.asarray(columns[key])
    chosen = {i: column == option for i, option in enumerate(options)}
    return {i: flags for i, flags in chosen.items() if flags.any()} or {0: chosen[0]}


def _operation(node: Node, columns: Columns) -> Callable[..., Any]:
    """The function from the values of a node's arguments to its own value."""
    match node.op:
        case "component":
            return lambda v: v[node.data]
        case "axes":
            matrix = np.array(node.data[0])
            return lambda v: matrix @ v
        case "table":
            key, mode = node.data
            return _table(columns[f"{key}.at"], columns[f"{key}.values"], mode)
        case "switch":
            _, *others = _occurring(node, columns).values()

            def selected(found: Any, *values: Any) -> Any:
                for flags, value in zip(others, values, strict=True):
                    found = np.where(flags, value, found)
                return found

            return selected
    return OPERATIONS[node.op]


class Values:
    """The values of expressions on columns, each node computed once."""

    def __init__(self, columns: Columns) -> None:
        self.columns = columns
        self._known: dict[Node, Any] = {}  # which keeps the nodes alive
        self._arguments: dict[Node, list[Node]] = {}  # of switches
        self._operations: dict[Node, Callable[..., Any]] = {}  # of these and of tables

    def of(self, root: Node) -> Any:
        """The value of an expression."""
        if root not in self._known:
            for node in ordered([root], self, self.arguments):
                self.next(node)
        return self._known[root]

    def arguments(self, node: Node) -> Sequence[Node]:
        """Arguments on which a node's value depends: of a switch, the options that occur."""
        if node.op != "switch":
            return evaluated(node)
        if node not in self._arguments:
            self._arguments[node] = [node.args[i] for i in _occurring(node, self.columns)]
        return self._arguments[node]

    def given(self, root: Node, symbols: Mapping[str, Any]) -> Any:
        """Value of an expression with values of further symbols; results are not cached."""
        made: dict[Node, Any] = {}
        for node in ordered([root], self, self.arguments):
            if node in self._known:
                continue
            if node.op == "symbol" and node.data in symbols:
                made[node] = symbols[node.data]
            else:
                made[node] = self._computed(node, made)
        return made[root] if root in made else self._known[root]

    def changed(self, root: Node, old: Node, new: Any) -> Any:
        """Value of an expression if one of its nodes had another value."""
        self.of(root)
        made = {old: new}
        for node in _using(root, old):
            if node in self._known:  # otherwise it is in an option that no scene has
                made[node] = self._computed(node, made)
        return made.get(root, self._known[root])

    def _computed(self, node: Node, made: Mapping[Node, Any]) -> Any:
        """Value of a node from those of its arguments, which are in `made` or cached."""
        match node.op:
            case "symbol":
                return self.columns[node.data]
            case "constant":
                return np.full((3, 1), node.data) if node.vector else node.data
        operation = self._operations.get(node) or _operation(node, self.columns)
        # Operations of edits (`given`, `changed`) are not cached: there are thousands of edits.
        if node.op in ("switch", "table") and made is self._known:
            self._operations[node] = operation
        args = [made[arg] if arg in made else self._known[arg] for arg in self.arguments(node)]
        return operation(*args)

    def __contains__(self, node: object) -> bool:
        return node in self._known

    def beside(self) -> Values:
        """A copy of these values, which may grow while these stay as they are."""
        other = Values(self.columns)
        other._known, other._arguments = {**self._known}, self._arguments
        other._operations = self._operations
        return other

    def next(self, node: Node) -> Any:
        """The value of a node whose arguments' values are known."""
        if node not in self._known:
            self._known[node] = self._computed(node, self._known)
        return self._known[node]


class Evaluator:
    """Expressions bound to columns, as a function of the symbols that move.

    Nodes without a moving symbol are computed once, or come from `Values` of the same columns.
    These `Values` are copied, not extended, because thousands of edits use them.
    """

    def __init__(
        self, roots: Sequence[Node], columns: Columns | Values, moving: frozenset[str] = frozenset()
    ) -> None:
        known = columns.beside() if isinstance(columns, Values) else Values(columns)
        nodes = ordered(roots, known, known.arguments)
        # A definition, or a switch with a single option here, has the value of its argument: it
        # shares the argument's index, and a call needs no step for it.
        place: dict[Node, int] = {}
        for i, node in enumerate(nodes):
            args = known.arguments(node)
            alone = node.op == "named" or (node.op == "switch" and len(args) == 1)
            place[node] = place.get(args[0], i) if alone else i
        # Values by index: the fixed ones, and during a call also those that move. A call is a list
        # of steps without look-ups, because a search of a law makes millions of calls.
        self._values: list[Any] = [None] * len(nodes)
        self._given: list[tuple[int, str]] = []
        self._steps: list[tuple[int, Callable[..., Any], list[int]]] = []
        self._roots = [place[root] for root in roots]
        moves = set[Node]()
        for i, node in enumerate(nodes):
            args = known.arguments(node)
            if node.op == "symbol" and node.data in moving:
                moves.add(node)
                self._given.append((i, node.data))
            elif any(arg in moves for arg in args):
                moves.add(node)
                if place[node] != i:
                    continue
                operation = _operation(node, known.columns)
                self._steps.append((i, operation, [place[arg] for arg in args]))
            else:
                self._values[i] = known.next(node)

    def __call__(self, **moving: Any) -> list[Any]:
        """The values of the roots."""
        values = self._values
        for i, name in self._given:
            values[i] = moving[name]
        for i, operation, args in self._steps:
            values[i] = operation(*[values[k] for k in args])
        return [values[i] for i in self._roots]


def used(roots: Sequence[Node], columns: Columns) -> dict[Node, Any]:
    """The nodes below the roots with flags of the scenes that use them, users first.

    A scene uses an option of a switch only if it has that option.
    """
    # The flags are passed down from the roots to the arguments; a node with two users has the flags
    # of both.
    at_hand, found = Values(columns), dict[Node, Any].fromkeys(roots, np.True_)
    for node in reversed(ordered(roots, (), at_hand.arguments)):
        flags = [*_occurring(node, columns).values()] if node.op == "switch" else ()
        for i, arg in enumerate(at_hand.arguments(node)):
            own: Any = flags[i] if flags else np.True_
            found[arg] = found.get(arg, np.False_) | (found[node] & own)
    return found


class Pieces:
    """Numbers that change where an expression has a kink or a jump, as a function of what moves."""

    def __init__(self, root: Node, columns: Columns, moving: frozenset[str]) -> None:
        # A kink in an option counts only in scenes that have this option.
        self._parts: list[tuple[Any, Any]] = []  # table's nodes or None, flags
        nodes: list[Node] = []
        for node, flags in used([root], columns).items():
            if node.op not in JUMPS | KINKS | {"table"}:
                continue
            x, at = node.args[0], None
            if node.op == "least":
                x = x - node.args[1]
            elif node.op == "table":
                at = columns[f"{node.data[0]}.at"]
            if depends(x, moving):
                nodes.append(x)
                self._parts.append((at, flags))
        self._values = Evaluator(nodes, columns, moving)

    def __call__(self, **moving: Any) -> Array:
        """The numbers; the last axis is that of the scenes."""
        rows = [
            np.atleast_2d((x > 0 if at is None else (x >= at).sum(0)) * flags)
            for x, (at, flags) in zip(self._values(**moving), self._parts, strict=True)
        ]
        return np.concatenate(rows) if rows else np.zeros((0, 1))


def evaluate(root: Node, columns: Columns) -> Any:
    """The value of an expression on columns."""
    return Values(columns).of(root)


# --- words ----------------------------------------------------------------------------------------

_FORMATS = {
    "sum": "{} + {}",
    "product": "{}·{}",
    "quotient": "{}/{}",
    "negative": "-{}",
    "norm": "|{}|",
    "abs": "|{}|",
    "square": "{}²",
    "dot": "{} · {}",
    "cross": "{} × {}",
    "times": "{}·{}",
    "sizes": "|{0}_x| + |{0}_y| + |{0}_z|",
    "unit": "{0}/|{0}|",
    "rises": "[{} > 0]",
    "positive": "max({}, 0)",
    "vector": "({}, {}, {})",
    "by_component": "{}·{} by component",
}
_WEAK = {"sum", "dot", "cross"}  # put in parentheses inside a product


# A switch is printed as ⟨its key⟩. A text with one does not help the author of a program.
SWITCHED = "⟨"


@lru_cache(maxsize=16384)
def words(node: Node) -> str:
    """An expression as people write it; definitions by their names."""
    if node.op == "constant":
        return "π" if node.data == math.pi else f"{node.data:.9g}"
    if node.op in ("symbol", "named"):
        return str(node.data)
    args = [words(arg) for arg in node.args]
    if node.op in ("product", "quotient", "negative", "square"):
        # A divisor needs parentheses where a dividend needs none: a·b/c, but a/(b·c).
        weak = _WEAK | ({"product", "quotient"} if node.op == "quotient" else set())
        args = [
            f"({text})" if arg.op in (weak if i or node.op != "quotient" else _WEAK) else text
            for i, (arg, text) in enumerate(zip(node.args, args, strict=True))
        ]
    match node.op:
        case "component":
            whole = f"({args[0]})" if node.args[0].op in _WEAK else args[0]
            return f"{whole}_{'xyz'[node.data]}"
        case "axes":
            return f"{args[0]} as {node.data[1]}"
        case "switch":
            return f"{SWITCHED}{node.data[0]}⟩"
        case "table":
            return f"table({args[0]})"
        case "matrix":
            return str(node.data)
        case "sum" if args[1].startswith("-"):
            return f"{args[0]} - {args[1][1:]}"
        case "product" if args[0] == "-1":
            return f"-{args[1]}"
    return _FORMATS.get(node.op, f"{node.op}({', '.join(args)})").format(*args)
