"""Mutants of a program that somebody else wrote: small faults that no author thought of.

Python is changed in its syntax tree, C in its tokens. Every mutant is the whole source with one
place changed, and a line in words.
"""

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from tests.mutants import altered, replaced

SISTERS = {"sin": "cos", "cos": "sin", "max": "min", "min": "max", "fmax": "fmin", "fmin": "fmax",
           "sinl": "cosl", "cosl": "sinl", "sqrt": "fabs", "sqrtl": "fabsl"}  # fmt: skip
OPERATORS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
FLIPPED = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}
NEIGHBOURS = 3  # other names that are tried for a name: those next to it in the alphabet


@dataclass(frozen=True)
class Mutant:
    """A changed source, and what is changed: "12: m -> M"."""

    change: str
    made: Callable[[], str]

    @property
    def source(self) -> str:
        """The changed source."""
        return self.made()


def others(name: str, names: set[str]) -> list[str]:
    """Some other names, the same for the same name."""
    ordered = sorted(names | {name})
    at = ordered.index(name)
    return [x for x in (ordered[at + 1 :] + ordered[:at])[:NEIGHBOURS] if x != name]


# --- Python ---------------------------------------------------------------------------------------


def python_mutants(source: str) -> Iterator[Mutant]:
    """Mutants of every function but `main`."""
    for scope in ast.walk(ast.parse(source)):
        if not isinstance(scope, ast.FunctionDef) or scope.name == "main":
            continue
        nodes = [node for node in ast.walk(scope) if isinstance(node, ast.expr)]
        called = {node.func for node in nodes if isinstance(node, ast.Call)}
        told = {x for node in nodes if isinstance(node, ast.JoinedStr) for x in ast.walk(node)}
        # What is reckoned with: another number may stand there, but not a list or a function.
        reckoned = {x for node in nodes for x in _operands(node)}
        names = {x.id for x in reckoned if isinstance(x, ast.Name)}
        keys = [x for x in nodes if _is_keyed(x)]
        for node in nodes:
            if node in told or (isinstance(node, ast.Name) and node not in reckoned):
                continue
            near = {x.slice.value for x in keys if _is_keyed(node)
                    and ast.dump(x.value) == ast.dump(node.value)}  # fmt: skip
            for other in _changes(node, names, near, node in called):
                words = f"{ast.unparse(node)} -> {ast.unparse(other)}"
                yield Mutant(f"{node.lineno}: {words}", partial(replaced, source, node, other))


def _operands(node: ast.expr) -> list[ast.expr]:
    match node:
        case ast.BinOp(left=left, right=right):
            return [left, right]
        case ast.Compare(left=left, comparators=rest):
            return [left, *rest]
    return []


def _is_keyed(node: ast.AST) -> bool:
    match node:
        case ast.Subscript(slice=ast.Constant(value=str()), ctx=ast.Load()):
            return True
    return False


def _changes(
    node: ast.expr, names: set[str], keys: set[str], called: bool
) -> Iterator[ast.expr]:  # fmt: skip
    match node:
        case ast.Name(id=name, ctx=ast.Load()) if not called:
            yield from (ast.Name(other) for other in others(name, names))
            yield ast.UnaryOp(ast.USub(), ast.Name(name))
        case ast.Attribute(attr=name) if called and name in SISTERS:
            yield altered(node, attr=SISTERS[name])
        case ast.Subscript(slice=ast.Constant(value=str(key)), ctx=ast.Load()):
            yield from (altered(node, slice=ast.Constant(other)) for other in others(key, keys))
        case ast.Subscript(slice=ast.Constant(value=int(i)), ctx=ast.Load()):
            yield altered(node, slice=ast.Constant(i - 1 if i else 1))
        case ast.BinOp(op=op, left=left, right=right) if type(op) in OPERATORS:
            yield altered(node, op=OPERATORS[type(op)]())
            yield left
            yield right
        case ast.Compare(ops=[op]) if type(op) in FLIPPED:
            yield altered(node, ops=[FLIPPED[type(op)]()])
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield operand
        case ast.Constant(value=int() | float() as x) if not isinstance(x, bool):
            yield from (ast.Constant(y) for y in (2 * x, x + 1, 0 * x) if y != x)


# --- C --------------------------------------------------------------------------------------------

TOKEN = re.compile(
    r"(?P<skip>/\*.*?\*/|//[^\n]*|^\s*#(?:[^\n]*\\\n)*[^\n]*|\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])+')"
    r"|(?P<number>(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?L?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<mark>->|<=|>=|==|!=|&&|\|\||[-+*/]=|\+\+|--|<<|>>|[-+*/<>{}()\[\];,.?:=!&|%])",
    re.DOTALL | re.MULTILINE,
)
MARKS = {"+": "-", "-": "+", "*": "/", "/": "*", "<": ">", ">": "<", "<=": ">=", ">=": "<=",
         "&&": "||", "||": "&&", "+=": "-=", "-=": "+="}  # fmt: skip
KEYWORDS = re.compile(
    "auto|bool|break|case|char|const|continue|default|do|double|else|enum|extern|float|for|goto|if|int"
    "|long|return|short|signed|sizeof|static|struct|switch|typedef|union|unsigned|void|while|true"
    "|false|NULL|main"
)
RECKONED = {*"+-*/<>", "<=", ">="}
ENDS = {*"+-<>;,)]}?:", "<=", ">=", "&&", "||", "==", "!="}


def c_mutants(source: str) -> Iterator[Mutant]:
    """Mutants of every function but `main`; some do not compile."""
    tokens = [match for match in TOKEN.finditer(source) if match.lastgroup != "skip"]
    depth, begun = 0, 0
    for i, token in enumerate(tokens):
        depth += {"{": 1, "}": -1}.get(token[0], 0)
        if token[0] == "{" and depth == 1:
            begun = i
        head = [x[0] for x in tokens[max(0, begun - 40) : begun]]
        is_function = bool(head) and head[-1] == ")" and "main" not in head[-12:]
        if token[0] == "}" and depth == 0 and is_function:
            yield from _in_function(source, tokens[begun : i + 1])


def _spliced(source: str, start: int, end: int, by: str) -> str:
    return source[:start] + by + source[end:]


def _in_function(source: str, tokens: list[re.Match[str]]) -> Iterator[Mutant]:
    words = [token[0] for token in tokens]
    after_dot = [i > 0 and words[i - 1] in (".", "->") for i in range(len(words))]
    # What is reckoned with, and is no array, structure or function.
    named = [
        token.lastgroup == "name"
        and not KEYWORDS.fullmatch(token[0])
        and words[i + 1] not in ("(", "[", ".", "->")
        and (words[i - 1] in RECKONED or words[i + 1] in RECKONED or after_dot[i])
        for i, token in enumerate(tokens)
    ]
    pools = {
        dotted: {x for x, is_name, dot in zip(words, named, after_dot) if is_name and dot == dotted}
        for dotted in (True, False)
    }
    for i, (token, word) in enumerate(zip(tokens, words)):
        start, end, by = token.start(), token.end(), list[str]()
        line = source.count("\n", 0, start) + 1
        binary = i > 0 and (
            named[i - 1] or words[i - 1] in (")", "]") or tokens[i - 1].lastgroup == "number"
        )
        if named[i]:
            by = [*others(word, pools[after_dot[i]])]
        elif word in SISTERS:
            by = [SISTERS[word]]
        elif token.lastgroup == "number":
            suffix = "L" if word.endswith("L") else ""
            x = float(word.removesuffix("L"))
            whole = word.isdigit()
            found = (2 * x, x + 1, 0 * x)
            by = [f"{int(y)}" if whole else f"{y!r}{suffix}" for y in found if y != x]
        elif word in MARKS and (binary or word not in "+-*"):
            by = [MARKS[word]]
            if word in ("+", "-"):
                last = tokens[_end_of_term(words, i + 1)].start()
                change = f"{line}: {source[start:last]} dropped"
                yield Mutant(change, partial(_spliced, source, start, last, ""))
        elif word == "-":
            by = [""]
        around = source[max(0, start - 12) : end + 12].replace("\n", " ")
        for other in by:
            change = f"{line}: {word} -> {other} in {around}"
            yield Mutant(change, partial(_spliced, source, start, end, other))


def _end_of_term(words: list[str], i: int) -> int:
    depth = 0
    while depth or words[i] not in ENDS:
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(words[i], 0)
        i += 1
    return i
