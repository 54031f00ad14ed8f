"""Mutation testing: small faults are planted in the package, and the tests have to notice each.

    python tests/mutants.py --sample 100 --seed 1 [--jobs 2] [--only model/impact.py]

A mutant is one module with one operator, comparison or constant changed, in a copy of the package
that stands before the real one on the path. It runs the tests of the folder that its module belongs
to. Killed: a test fails, or none ends in time. Survivors are written to report/mutants.csv, where
the column `reason` says why a mutant is no fault; reasons are kept from run to run.
"""

from __future__ import annotations

import argparse
import ast
import csv
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "reference" / "longball"
TABLE = ROOT / "report" / "mutants.csv"
COLUMNS = ("module", "line", "change", "code", "reason")
FOLDERS = ("model", "engines", "convergence")
# Written by a program from another module, which is mutated in its place.
GENERATED = {"model/impact.py"}

# Tests of a module, the quickest first: they stop at the first failure.
TESTS = {
    "model": ("tests/model", "tests/engines/test_chain.py"),
    "engines/batch": ("tests/engines/test_batch.py", "tests/engines/test_columns.py"),
    "engines/enclosure": ("tests/engines/enclosure", "tests/engines/test_enclosure.py"),
    "engines": ("tests/engines",),
    "convergence": ("tests/convergence",),
}
SECONDS = 900.0  # of the tests of a mutant: several times what they take

SWAPS: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}


@dataclass(frozen=True)
class Mutant:
    """A change of a module: its path in the package, where, what, and which of which node's."""

    module: str
    line: int
    change: str
    code: str
    node: int
    number: int

    @property
    def key(self) -> tuple[str, str, str]:
        """What a reason belongs to; lines move."""
        return self.module, self.change, self.code


def mutants(module: str, source: str) -> Iterator[Mutant]:
    """Yield every mutant of a module."""
    tree, lines = ast.parse(source), source.splitlines()
    passive = {id(node) for part in _passive(tree) for node in ast.walk(part)}
    for index, node in enumerate(ast.walk(tree)):
        if id(node) in passive:
            continue
        for number, (change, _) in enumerate(_changes(node)):
            line = node.lineno  # type: ignore[attr-defined]
            yield Mutant(module, line, change, lines[line - 1].strip(), index, number)


def source_of(mutant: Mutant) -> str:
    """Return the source of the module with the change."""
    tree = ast.parse((PACKAGE / mutant.module).read_text(encoding="utf-8"))
    node = list(ast.walk(tree))[mutant.node]
    _, apply = list(_changes(node))[mutant.number]
    apply(node)
    return ast.unparse(tree)


def _passive(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield the parts of a module that no test can see: annotations, and what an error says."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef():
                yield from filter(None, [node.returns])
            case ast.arg() | ast.AnnAssign():
                yield from filter(None, [node.annotation])
            case ast.JoinedStr() | ast.Raise():
                yield node
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                yield node


def _changes(node: ast.AST) -> Iterator[tuple[str, Callable[[ast.AST], None]]]:
    """Yield what may be changed of a node: in words, and as a function of the node's copy."""
    match node:
        case ast.BinOp() | ast.BoolOp():
            for other in SWAPS.get(type(node.op), ()):
                yield _words(node.op, other), lambda n, o=other: setattr(n, "op", o())
        case ast.Compare(ops=[op]):
            for other in SWAPS.get(type(op), ()):
                yield _words(op, other), lambda n, o=other: setattr(n, "ops", [o()])
        case ast.UnaryOp(op=ast.USub()):
            yield "without -", lambda n: setattr(n, "op", ast.UAdd())
        case ast.UnaryOp(op=ast.Not()):
            yield "without not", lambda n: vars(n).update(op=ast.Not(), operand=_negated(n))
        case ast.Constant(value=bool() as value):
            yield f"{value} -> {not value}", lambda n: setattr(n, "value", not value)
        case ast.Constant(value=int() | float() as value):
            other = value + 1 if isinstance(value, int) else 1.5 * value + (value == 0.0)
            yield f"{value} -> {other}", lambda n: setattr(n, "value", other)


def _negated(node: ast.AST) -> ast.UnaryOp:
    return ast.UnaryOp(op=ast.Not(), operand=node.operand)  # type: ignore[attr-defined]


def _words(before: ast.AST, after: type[ast.AST]) -> str:
    return f"{type(before).__name__} -> {after.__name__}"


def every_mutant(only: str | None) -> Iterator[Mutant]:
    """Yield the mutants of the package's folders, or of one module."""
    for folder in FOLDERS:
        for path in sorted((PACKAGE / folder).rglob("*.py")):
            module = path.relative_to(PACKAGE).as_posix()
            if "__pycache__" not in module and module not in GENERATED and only in (None, module):
                yield from mutants(module, path.read_text(encoding="utf-8"))


def tests_of(module: str) -> tuple[str, ...]:
    """Return the tests that cover a module: its own file first, if there is one."""
    own = Path("tests") / Path(module).with_name(f"test_{Path(module).name}")
    folder = max((f for f in TESTS if module.startswith(f)), key=len)
    first = (own.as_posix(),) if (ROOT / own).exists() else ()
    return *first, *TESTS[folder]


def killed(mutant: Mutant) -> bool:
    """Tell whether the tests notice a mutant."""
    return fails(mutant.module, source_of(mutant))


def fails(module: str, source: str) -> bool:
    """Tell whether the tests of a module fail with another source of it, or do not end in time."""
    with tempfile.TemporaryDirectory() as folder:
        away = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGE, Path(folder) / "longball", ignore=away)
        (Path(folder) / "longball" / module).write_text(source, encoding="utf-8")
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([folder, str(ROOT)]),
            "PYTHONDONTWRITEBYTECODE": "1",
            # A mutant's code must not be found in the cache by the next one.
            "NUMBA_CACHE_DIR": str(Path(folder) / "numba"),
        }
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        try:
            done = subprocess.run(
                [*command, *tests_of(module)],
                cwd=ROOT,
                env=environment,
                capture_output=True,
                timeout=SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return True
        return done.returncode != 0


def known_reasons() -> dict[tuple[str, str, str], str]:
    """Return the reasons in the table, by what they belong to."""
    if not TABLE.exists():
        return {}
    with TABLE.open(encoding="utf-8", newline="") as file:
        return {(r["module"], r["change"], r["code"]): r["reason"] for r in csv.DictReader(file)}


def write(survivors: list[Mutant], tried: list[Mutant]) -> None:
    """Write the table: the survivors, and earlier ones that were not tried again."""
    reasons, again = known_reasons(), {mutant.key for mutant in tried}
    rows = [(m.module, str(m.line), m.change, m.code, reasons.get(m.key, "")) for m in survivors]
    rows += [
        (key[0], "", key[1], key[2], reason) for key, reason in reasons.items() if key not in again
    ]
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(sorted(rows))


def main() -> None:
    """Try a sample of mutants and print the score."""
    parser = argparse.ArgumentParser(description="Mutation testing of longball.")
    parser.add_argument("--sample", type=int, help="how many mutants; by default all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="how many at a time")
    parser.add_argument("--only", help="a module, as model/bat.py")
    options = parser.parse_args()
    every = list(every_mutant(options.only))
    count = min(options.sample or len(every), len(every))
    tried = random.Random(options.seed).sample(every, count)
    for module in sorted({mutant.module for mutant in tried}):
        if fails(module, (PACKAGE / module).read_text(encoding="utf-8")):
            sys.exit(f"the tests of {module} fail without a mutant: {' '.join(tests_of(module))}")
    survivors, reasons = [], known_reasons()
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutant, dead in zip(tried, pool.map(killed, tried), strict=True):
            if not dead:
                survivors.append(mutant)
            word = "killed" if dead else "SURVIVED"
            print(
                f"{word}  {mutant.module}:{mutant.line}  {mutant.change}  {mutant.code}", flush=True
            )
    write(survivors, tried)
    unexplained = [mutant for mutant in survivors if not reasons.get(mutant.key)]
    print(
        f"{count} of {len(every)} mutants: {count - len(survivors)} killed, "
        f"{len(survivors)} survived, {len(unexplained)} of them without a reason"
    )


if __name__ == "__main__":
    main()
