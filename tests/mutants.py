"""Mutation testing: small faults are planted in the package, and the tests have to notice each.

    python tests/mutants.py [--sample 300] [--seed 1] [--only model] [--jobs 2]

A mutant is one module with one operator, comparison or constant changed, in a copy of the package
that comes before the real one on the path. A first run of the tests of `TESTS` records which test
reaches which line, and in what time; the record is kept for as long as no source changes. A line
that runs while its module is imported is in no test: the tests of all files that import the module
count as reaching it. Each mutant then runs the tests that reach its line, followed by those that
reach its module, the quickest first, up to `LIMIT` seconds in all. Killed: a test fails, or does
not end in time. The others are survivors, whether another test would kill them or not. A mutant for
which no test runs is an error, of this program or of its lists.

Two kinds of change are not made, because no test can notice them. `>` becomes `<=`, but not `>=`
unless one side is zero or written as a whole number: another real number is exactly at a limit with
probability zero. And a number that a comment calls a free choice does not change, nor does an
operator beside it:

    FEW = 6  # scenes in which schemes are tried first: a free choice

The comment holds for its statement, behind the head of a function for all of it, and on a line of
its own up to the next blank line. A number that is added to an entry of a table of free choices is
one, too. Changes by a factor of 10 or 1000 would say little: three in four survive, because a limit
of a search mostly costs time.

Mutants are drawn at random from `FOLDERS`, from each in proportion to its mutants, in an order of
which any beginning is such a sample. Survivors are written to tests/mutants.csv, where the column
`reason` says why a mutant is equivalent to the module; those do not count for the score, which is
printed with its 95 % interval (Wilson). Reasons are kept from run to run.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import csv
import hashlib
import importlib
import json
import math
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import tokenize
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from scipy.stats import binomtest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "reference" / "longball"
SPACE = ROOT / "build" / "mutants"
TABLE = ROOT / "tests" / "mutants.csv"
COLUMNS = ("module", "line", "where", "change", "code", "which", "reason")
FOLDERS = (
    "model", "engines", "convergence", "home_run", "golden", "questions", "judge/diagnosis",
)  # fmt: skip
TESTS = (
    *(f"tests/{folder.partition('/')[0]}" for folder in FOLDERS),
    "tests/planted",
    "tests/test_properties.py",
    "tests/test_against_oracle.py",
    "tests/analysis/test_survival.py",
)
# Written by a program from another module, which is mutated in its place.
GENERATED = {"model/dicts.py", "model/impact.py"}
# Tested by night alone, for a minute: hundreds of mutants cannot wait for that.
BY_NIGHT = {"golden/home_runs.py"}
# Compiled code leaves no trace, and what prints it leaves one in the first test alone: their tests
# are those of the module that calls it.
CALLERS = {
    **dict.fromkeys(
        (
            f"engines/batch/{name}.py"
            for name in ("expansion", "flights", "jit", "roots", "tangents", "writer")
        ),
        "engines/batch/records.py",
    ),
    "engines/coefficients.py": "engines/polynomial.py",
    "engines/series.py": "engines/taylor.py",
    "engines/verlet_steps.py": "engines/verlet.py",
}
LIMIT = 300.0  # s of tests for a mutant
SLOWER = 3.0  # times as long as without a mutant: no end
COMPILING = 30.0  # s beyond that
# In place of a line: what runs while the module is imported, which is in no test.
IMPORTED = "imported"
# Imported once, before the processes of the mutants are forked.
WARM = (
    "flint",
    "hypothesis",
    "joblib",
    "mpmath",
    "numba",
    "pandas",
    "pydantic",
    "scipy.integrate",
    "scipy.optimize",
    "sympy",
)

SWAPS: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Lt: (ast.GtE,),
    ast.LtE: (ast.Gt,),
    ast.Gt: (ast.LtE,),
    ast.GtE: (ast.Lt,),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}
# Made where the two sides may be equal.
TIES: dict[type[ast.AST], tuple[type[ast.AST], ...]] = {
    ast.Lt: (ast.LtE,),
    ast.LtE: (ast.Lt,),
    ast.Gt: (ast.GtE,),
    ast.GtE: (ast.Gt,),
}
FREE = re.compile(r"\bfree choices?\b", re.IGNORECASE)


# --- mutants --------------------------------------------------------------------------------------


Key = tuple[str, str, str, str, str]


@dataclass(frozen=True)
class Mutant:
    """A change of a module: its path in the package, lines, what changes, and the new source.

    `where` and `which` tell it from those of the same words: the function or class that it is in,
    and its number among those there.
    """

    module: str
    lines: range
    change: str
    code: str
    where: str
    which: int
    source: str = field(repr=False)

    @property
    def key(self) -> Key:
        """Key of a reason, without line numbers, which move."""
        return self.module, self.where, self.change, self.code, str(self.which)

    def __str__(self) -> str:
        return f"{self.module}:{self.lines.start}  {self.change}  {self.code}"


def mutants(module: str) -> Iterator[Mutant]:
    """Yield every mutant of a module."""
    source = (PACKAGE / module).read_text(encoding="utf-8")
    lines, numbers = source.splitlines(), Counter[tuple[str, str, str]]()
    tree = ast.parse(source)
    free = free_choices(tree, source)
    for where, node in _visible(tree):
        for change, changed in _changes(node) if node not in free else ():
            assert isinstance(node, ast.expr)
            reach = range(node.lineno, (node.end_lineno or node.lineno) + 1)
            words = where, change, lines[node.lineno - 1].strip()
            numbers[words] += 1
            new = replaced(source, node, changed)
            yield Mutant(module, reach, change, words[2], where, numbers[words], new)


def replaced(source: str, node: ast.expr, other: ast.expr) -> str:
    """Return a source with another expression; the lines before it do not move."""
    lines = source.encode().splitlines(keepends=True)
    last = (node.end_lineno or node.lineno) - 1
    head = b"".join(lines[: node.lineno - 1]) + lines[node.lineno - 1][: node.col_offset]
    tail = lines[last][node.end_col_offset :] + b"".join(lines[last + 1 :])
    return (head + f"({ast.unparse(other)})".encode() + tail).decode()


def _visible(node: ast.AST, where: str = "") -> Iterator[tuple[str, ast.AST]]:
    """Yield the parts of a module that a test can see, and the function or class that each is in.

    Not annotations, nor what an error says, nor what only states that the program is right.
    """
    match node:
        case ast.FunctionDef() | ast.ClassDef():
            where = f"{where}.{node.name}".removeprefix(".")
        case ast.JoinedStr() | ast.Raise() | ast.Assert():
            return
        case ast.keyword(arg="frozen" | "strict" | "slots"):
            return
        case ast.If(test=ast.Name(id="TYPE_CHECKING")):
            return
    yield where, node
    for name, part in ast.iter_fields(node):
        for child in part if isinstance(part, list) else [part]:
            if isinstance(child, ast.AST) and name not in ("annotation", "returns"):
                yield from _visible(child, where)


def _changes(node: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Yield what may be changed of a node: in words, and the other node."""
    match node:
        case ast.BinOp(op=op) | ast.BoolOp(op=op):
            for other in SWAPS.get(type(op), ()):
                yield _words(op, other), altered(node, op=other())
        case ast.Compare(left=left, ops=[op], comparators=[right]):
            ties = TIES.get(type(op), ()) if _is_whole(left) or _is_whole(right) else ()
            for other in (*SWAPS.get(type(op), ()), *ties):
                yield _words(op, other), altered(node, ops=[other()])
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield f"without {'-' if isinstance(node.op, ast.USub) else 'not'}", operand
        case ast.Constant(value=bool() as value):
            yield f"{value} -> {not value}", ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            other = value + 1 if isinstance(value, int) else 1.5 * value + (value == 0.0)
            yield f"{value} -> {other}", ast.Constant(other)


def _is_whole(node: ast.expr) -> bool:
    """True if a number is zero, or is whole as it is written."""
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int) or value == 0.0
        case ast.UnaryOp(operand=operand):
            return _is_whole(operand)
        case ast.BinOp(left=left, right=right):
            return _is_whole(left) and _is_whole(right)
        case ast.Attribute(attr=name) | ast.Subscript(value=ast.Attribute(attr=name)):
            return name in ("size", "ndim", "shape")
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
            return name in ("len", "sum", "count")
    return False


def free_choices(tree: ast.Module, source: str) -> set[ast.AST]:
    """Return the numbers that comments call free choices, and the operators beside them."""
    lines, nodes = _free_lines(tree, source), [*ast.walk(tree)]
    free = {node for node in nodes if getattr(node, "lineno", 0) in lines}
    tables = {
        ast.unparse(statement.targets[0])
        for statement in tree.body
        if isinstance(statement, ast.Assign) and statement in free
    }
    for node in nodes:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
            parts = [*ast.walk(node)]
            entries = (part.value for part in parts if isinstance(part, ast.Subscript))
            if any(ast.unparse(table) in tables for table in entries):
                free.update(parts)
    subscripts = (node.slice for node in nodes if isinstance(node, ast.Subscript))
    indices = {part for subscript in subscripts for part in ast.walk(subscript)}
    numbers = {
        node for node in free - indices
        if isinstance(node, ast.Constant) and type(node.value) in (int, float)
    }  # fmt: skip
    return numbers | {
        node for node in nodes
        if isinstance(node, ast.BinOp | ast.UnaryOp)
        and not numbers.isdisjoint(ast.iter_child_nodes(node))
    }  # fmt: skip


def _free_lines(tree: ast.Module, source: str) -> set[int]:
    """Return the lines for which comments about free choices hold."""
    lines = ["", *source.splitlines(), ""]
    statements: dict[int, range] = {}  # by line; the inner ones replace the outer ones
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt):
            last = node.end_lineno or node.lineno
            if not isinstance(node, ast.FunctionDef) and (body := getattr(node, "body", None)):
                last = body[0].lineno - 1
            span = range(node.lineno, last + 1)
            statements |= dict.fromkeys(span, span)
    free: set[int] = set()
    for token in tokenize.generate_tokens(StringIO(source).readline):
        if token.type == tokenize.COMMENT and FREE.search(token.string):
            line = end = token.start[0]
            while lines[line].lstrip().startswith("#") and lines[end].strip():
                end += 1
            free.update(range(line, end) or statements[line])
    return free


def altered(node: ast.expr, **parts: Any) -> ast.expr:
    """Return a copy of a node with other parts."""
    changed = deepcopy(node)
    vars(changed).update(parts)
    return changed


def _words(before: ast.AST, after: type[ast.AST]) -> str:
    return f"{type(before).__name__} -> {after.__name__}"


def sample(seed: int) -> list[Mutant]:
    """Return all mutants of the folders in an order as the head says."""
    generator, placed = random.Random(seed), []
    for folder in FOLDERS:
        names = (path.relative_to(PACKAGE).as_posix() for path in (PACKAGE / folder).rglob("*.py"))
        chosen = sorted(set(names) - GENERATED - BY_NIGHT)
        every = [mutant for name in chosen for mutant in mutants(name)]
        generator.shuffle(every)
        placed += [((i + generator.random()) / len(every), m) for i, m in enumerate(every)]
    return [mutant for _, mutant in sorted(placed, key=lambda pair: pair[0])]


# --- tests ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reach:
    """Which tests reach which line, and how long each takes, s."""

    seconds: dict[str, float]
    lines: dict[str, dict[str, list[str]]]  # by module and line

    def tests(self, mutant: Mutant) -> dict[str, float]:
        """Return the tests of a mutant and their times, in their order."""
        reached = self.lines.get(mutant.module, {})
        own = [test for line in mutant.lines for test in reached.get(str(line), ())]
        own = own or reached.get(IMPORTED, [])
        caller = self.lines.get(CALLERS.get(mutant.module, ""), {})
        near = [test for part in (reached, caller) for of in part.values() for test in of]
        ordered = (test for of in (own, near) for test in sorted(of, key=self.seconds.__getitem__))
        chosen: dict[str, float] = {}
        for test in dict.fromkeys(ordered):
            if not chosen or sum(chosen.values()) + self.seconds[test] < LIMIT:
                chosen[test] = self.seconds[test]
        return chosen


@dataclass(eq=False)
class Recorder:
    """A plugin of pytest: records what each test reaches, and its time on the processor.

    So that a busy machine, on which it takes longer, leaves none out.
    """

    coverage: Any
    seconds: dict[str, float] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Record for a test."""
        self.coverage.switch_context(nodeid)
        self.seconds[nodeid] = -_processor_time()

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """Note how long a test took."""
        self.seconds[nodeid] += _processor_time()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note whether a test fails."""
        if report.failed:
            self.failed.add(report.nodeid)


@dataclass(eq=False)
class Chosen:
    """A plugin of pytest: runs some tests only, in their order, each for as long as it may take."""

    tests: dict[str, float]

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Choose among the tests."""
        place = {test: i for i, test in enumerate(self.tests)}
        items[:] = sorted((i for i in items if i.nodeid in place), key=lambda i: place[i.nodeid])

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Let the process end if a test does not."""
        end_after(COMPILING + SLOWER * self.tests[nodeid])


def end_after(seconds: float) -> None:
    """End this process after some more seconds of the processor."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    end = math.ceil(used.ru_utime + used.ru_stime + seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (end, resource.RLIM_INFINITY))


def _processor_time() -> float:
    """Return the processor time of this process and its finished children, s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def record() -> Reach:
    """Record the lines that the tests reach, and return them."""
    used = [PACKAGE.rglob("*.py"), PACKAGE.rglob("*.jsonl")]
    used += [(ROOT / name).rglob("*.py") for name in ("analysis", "tests")]
    digest = hashlib.sha256()
    for path in sorted(path for paths in used for path in paths):
        digest.update(path.read_bytes())
    file = SPACE / f"reach-{digest.hexdigest()}.json"

    def run() -> int:
        coverage = importlib.import_module("coverage").Coverage(
            data_file=None, config_file=False, source_pkgs=["longball"], messages=False
        )
        coverage.start()
        recorder = Recorder(coverage)
        _pytest(TESTS, recorder)
        coverage.stop()
        data, right = coverage.get_data(), recorder.seconds.keys() - recorder.failed
        lines: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
        for test in sorted(right):
            for module in imported(test.partition("::")[0]):
                lines[module][IMPORTED].append(test)
        for name in data.measured_files():
            module = Path(name).relative_to(PACKAGE).as_posix()
            if module.startswith(FOLDERS):
                for n, tests in data.contexts_by_lineno(name).items():
                    lines[module][str(n)] = [test for test in tests if test in right]
        file.write_text(json.dumps([recorder.seconds, lines, sorted(recorder.failed)]))
        return 0

    if not file.exists() and _forked(run) != 0:
        sys.exit(f"the tests did not run; see {SPACE}/output-*")
    seconds, lines, failed = json.loads(file.read_text())
    for test in failed:
        print(f"fails without a mutant, and is left out: {test}", flush=True)
    return Reach(seconds, lines)


@cache
def imported(tests: str) -> tuple[str, ...]:
    """Return the modules of the package that a file of tests imports."""
    found = []
    for node in ast.walk(ast.parse((ROOT / tests).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("longball."):
            path = Path(*(node.module or "").split(".")[1:])
            names = (path, *(path / alias.name for alias in node.names))
            found += [name.with_suffix(".py") for name in names]
    return tuple(name.as_posix() for name in found if (PACKAGE / name).exists())


def require_tests(tried: Iterable[Mutant], reach: Reach) -> None:
    """End the program if no test reaches the module of a mutant."""
    if alone := {mutant.module for mutant in tried if not reach.tests(mutant)}:
        sys.exit(f"no test of {', '.join(TESTS)} reaches {', '.join(sorted(alone))}")


def _tried(mutant: Mutant, tests: dict[str, float]) -> tuple[Mutant, str, float]:
    """Return a mutant, its fate, and how long that took, s."""
    start = time.monotonic()
    return mutant, fate(mutant, tests), time.monotonic() - start


def fate(mutant: Mutant, tests: dict[str, float]) -> str:
    """Run tests on a mutant, and return its fate.

    ``killed``, ``no end`` or ``SURVIVED``; ``NO TEST`` if none ran.
    """
    files = dict.fromkeys(test.partition("::")[0] for test in tests)
    with tempfile.TemporaryDirectory(dir=SPACE) as folder:
        shutil.copytree(PACKAGE, Path(folder) / "longball", copy_function=os.link)
        # Code that does not depend on the mutated module need not be compiled again; what a mutant
        # compiles, no other finds.
        kept = Path(folder) / "compiled"
        shutil.copytree(SPACE / "compiled", kept, copy_function=os.link)
        module = Path(folder) / "longball" / mutant.module
        module.unlink()
        module.write_text(mutant.source, encoding="utf-8")

        def run() -> int:
            os.environ["NUMBA_CACHE_DIR"] = str(kept)
            sys.path.insert(0, folder)
            os.environ["PYTHONPATH"] = os.pathsep.join([folder, os.environ.get("PYTHONPATH", "")])
            end_after(LIMIT)
            # A module that cannot be imported would end pytest before any test, in a conftest.
            path = Path("longball", mutant.module).with_suffix("")
            importlib.import_module(".".join(path.parts).removesuffix(".__init__"))
            return _pytest(("-x", *files), Chosen(tests))

        status = _forked(run)
    return _FATES.get(status, "killed")


def _pytest(files: tuple[str, ...], plugin: object) -> int:
    options = [f"-pno:{name}" for name in ("cacheprovider", "faulthandler", "xdist", "cov")]
    # Hypothesis is warm.
    options += ["-q", "--tb=short", "-Wignore::pytest.PytestAssertRewriteWarning"]
    return int(pytest.main([*options, *files], plugins=[plugin]))


_FATES = {
    pytest.ExitCode.OK: "SURVIVED",
    pytest.ExitCode.NO_TESTS_COLLECTED: "NO TEST",
    pytest.ExitCode.USAGE_ERROR: "NO TEST",
    -signal.SIGXCPU: "no end",
}


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Write what is printed to a file."""
    kept = [os.dup(number) for number in (1, 2)]
    with (SPACE / f"output-{os.getpid()}").open("w", encoding="utf-8") as output:
        for number in (1, 2):
            os.dup2(output.fileno(), number)
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for number, before in zip((1, 2), kept, strict=True):
                os.dup2(before, number)
                os.close(before)


def _forked(run: Callable[[], int]) -> int:
    """Return the exit status of a process of its own."""
    process = os.fork()
    if process == 0:
        status = 1
        with _quiet():
            try:
                status = run()
            except BaseException:
                traceback.print_exc()
        os._exit(status)
    _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status)


# --- table ----------------------------------------------------------------------------------------


def known_reasons() -> dict[Key, str]:
    """Return the reasons in the table, by what they belong to."""
    if not TABLE.exists():
        return {}
    with TABLE.open(encoding="utf-8", newline="") as file:
        return {
            (r["module"], r["where"], r["change"], r["code"], r["which"]): r["reason"]
            for r in csv.DictReader(file)
        }


def write(every: Iterable[Mutant], survivors: list[Mutant], tried: list[Mutant]) -> None:
    """Write the table: the survivors of all mutants, and earlier ones that were not tried again."""
    reasons = known_reasons()
    rows = {m.key for m in survivors} | (reasons.keys() - {m.key for m in tried})
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for m in sorted(every, key=lambda m: (m.module, m.lines.start)):
            if m.key in rows:
                line, reason = m.lines.start, reasons.get(m.key, "")
                writer.writerow((m.module, line, m.where, m.change, m.code, m.which, reason))


def main() -> None:
    """Try a sample of mutants and print the score."""
    parser = argparse.ArgumentParser(description="Mutation testing of longball.")
    parser.add_argument("--sample", type=int, help="how many mutants; by default all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="a module or folder, as model/bat.py")
    parser.add_argument("--again", action="store_true", help="only survivors without a reason")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at once")
    options = parser.parse_args()
    os.chdir(ROOT)
    (SPACE / "compiled").mkdir(parents=True, exist_ok=True)
    os.environ |= {
        "PYTHONPATH": os.pathsep.join([str(PACKAGE.parent), str(ROOT)]),
        "PYTHONDONTWRITEBYTECODE": "1",
        "NUMBA_CACHE_DIR": str(SPACE / "compiled"),
    }
    sys.path.insert(0, str(PACKAGE.parent))
    sys.dont_write_bytecode = True
    for name in WARM:
        importlib.import_module(name)
    every, reasons = sample(options.seed), known_reasons()
    asked = [mutant for mutant in every if mutant.module.startswith(options.only)]
    if options.again:
        asked = [mutant for mutant in asked if reasons.get(mutant.key) == ""]
    asked_for, reach = asked[: options.sample], record()
    require_tests(asked_for, reach)
    tasks = [(mutant, reach.tests(mutant)) for mutant in asked_for]
    tried, survivors, untested = [], [], 0
    with ThreadPoolExecutor(options.jobs) as pool, contextlib.suppress(KeyboardInterrupt):
        for done in as_completed([pool.submit(_tried, *task) for task in tasks]):
            mutant, word, seconds = done.result()
            if word == "NO TEST":
                untested += 1
            else:
                tried.append(mutant)
            survivors += [mutant] if word == "SURVIVED" else []
            print(f"{word:8} {seconds:5.1f} s  {mutant}", flush=True)
    write(every, survivors, tried)
    equivalent = sum(bool(reasons.get(mutant.key)) for mutant in survivors)
    killed, count = len(tried) - len(survivors), len(tried) - equivalent
    print(f"{len(tried)} of {len(asked)} mutants, {equivalent} of them equivalent")
    low, high = binomtest(killed, count).proportion_ci(method="wilson")
    print(f"{killed} of {count} killed: {killed / count:.1%} ({low:.1%} to {high:.1%})")
    if untested:
        sys.exit(f"no test ran for {untested} more, though some reach their modules")


if __name__ == "__main__":
    main()
