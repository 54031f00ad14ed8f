"""Answers of a candidate, read from lines that are not trusted.

A candidate is another implementation. Every line of its output is either an answer to a scene, or
an issue with the number of the line. The output is never evaluated or used as a path, and messages
quote it escaped and shortened.
"""

from __future__ import annotations

import csv
import difflib
import json
import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from functools import partial
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np
from pydantic import Field

from longball.convergence.report import Frozen
from longball.engines.chain import PARTS
from longball.judge.quantities import QUANTITIES, Value
from longball.model.arrays import Array
from longball.model.csv_files import not_utf8, other_separators, unguarded
from longball.model.plain import plain
from longball.model.quantities import nested
from longball.model.result import Outcome, Result
from longball.model.scene import KINDS

CHUNK = 1 << 16  # bytes read or written at a time
LONGEST_LINE = 1 << 24  # bytes: a path of 100,000 points with velocities takes fourteen million
MOST_POINTS = 100_000

# A wrong program is often wrong in every line: further issues of the same kind are only counted.
KEPT = 20

Kind = Literal[
    "rubbish",  # a line that is not a result
    "unknown id",  # an answer without a scene
    "twice",  # a second answer
    "not a number",  # a quantity that is NaN, infinite, or of the wrong type
    "outcome",  # an outcome that the contract does not know
    "path",  # invalid points
    "unknown key",  # a key that the contract does not know: reported, and no fault by itself
    "process",  # how the candidate ran
]


class Issue(Frozen):
    """Something wrong with the candidate's output or conduct."""

    kind: Kind
    sentence: str
    line: int | None = Field(description="of its output, from 1; null for its conduct")

    def __str__(self) -> str:
        return self.sentence if self.line is None else f"line {self.line}: {self.sentence}"


@dataclass(frozen=True)
class Answer:
    """A candidate's answer to one scene."""

    id: str  # the scene's
    outcome: Outcome | None  # None if it was left out, or is not one of the contract's
    values: Mapping[str, Value]  # the quantities given
    unreadable: frozenset[str] = frozenset()  # names of quantities given that are no finite numbers
    # Why the candidate gives no answer, in its own words, if it refuses the scene.
    error: str | None = None
    # Points ``t, x, y, z`` or ``t, x, y, z, vx, vy, vz``, a row each; None if none are given.
    path: Array | None = None
    # Flags, texts and counts by name, such as ``landing.fair`` and ``impact.mode``.
    told: Mapping[str, object] = field(default_factory=dict)


class Collector:
    """Sorts lines into answers and issues.

    `asked` are the ids of the scenes. The lines of a `table` are CSV, the first one its header.
    """

    def __init__(self, asked: Collection[str], table: bool = False) -> None:
        self.asked = frozenset(asked)
        self.answers: dict[str, Answer] = {}  # by id: the first answer to each scene
        self.issues: list[Issue] = []  # in order; at most `KEPT` of a kind
        self._count: Counter[Kind] = Counter()
        self._table = table
        self._header: Sequence[str] | None = None
        self._unknown: set[str] = set()

    @property
    def left_out(self) -> dict[Kind, int]:
        """Return the number of unlisted issues, by kind."""
        return {kind: n - KEPT for kind, n in self._count.items() if n > KEPT}

    @property
    def faults(self) -> int:
        """Return the number of issues other than unknown keys."""
        return sum(n for kind, n in self._count.items() if kind != "unknown key")

    def report(self, kind: Kind, sentence: str, line: int | None = None) -> None:
        """Note an issue."""
        self._count[kind] += 1
        if self._count[kind] <= KEPT:
            self.issues.append(Issue(kind=kind, sentence=sentence, line=line))

    def take_line(self, number: int, line: bytes | None) -> bool:
        """Take a line, or None for one that is too long; lines are numbered from 1.

        Return True if it answers a scene that had no answer.
        """
        if line is None:
            self.report("rubbish", f"longer than {LONGEST_LINE} bytes", number)
        if not (line and line.strip()):
            return False
        try:
            text = line.decode("utf-8-sig")  # some programs begin with a byte-order mark
            if not self._table:
                return self._take(number, json.loads(text, **_NUMBERS))
            cells = _cells(text)
            if self._header is not None:
                if len(cells) < len(self._header):
                    told = f"{len(cells)} of {len(self._header)} cells"
                    self.report("rubbish", f"it is cut off: {told} of a result", number)
                    return False
                return self._take(number, _nested(zip(self._header, cells, strict=False)))
            self.begin_table(cells)
            return False
        except UnicodeDecodeError as error:
            why = not_utf8(error)
        except json.JSONDecodeError as error:
            why = f"not JSON from character {error.pos + 1} on: {quoted(text[error.pos :])}"
            if text.lstrip().startswith("{") and _is_cut(text.rstrip(), error):
                why += "; it is cut off: the line ends inside a result"
        except (csv.Error, ValueError):
            why = f"not a row of CSV: {quoted(text)}"
        except RecursionError:
            why = "not a result: brackets nested too deeply"
        self.report("rubbish", why, number)
        return False

    def begin_table(self, header: Sequence[str]) -> None:
        """Take the header of a table; report columns that no result has."""
        self._header = header
        for name in header:
            if name not in COLUMNS:
                self._report_key(1, name, COLUMNS, told="the column {} is not used: it")

    def _take(self, number: int, data: Any) -> bool:
        scene_id = data.get("id") if isinstance(data, dict) else None
        named = quoted(scene_id)
        if not isinstance(data, dict):
            self.report("rubbish", f"not a result, which is a JSON object: {quoted(data)}", number)
        elif not isinstance(scene_id, str):
            given = f"the id {named} is not text" if "id" in data else "it has no id"
            self.report("rubbish", f"not a result: {given}", number)
        elif scene_id not in self.asked:
            self.report("unknown id", f"no scene has the id {named}", number)
        elif scene_id in self.answers:
            self.report("twice", f"{named} is answered again; the first answer counts", number)
        else:
            self.answers[scene_id] = self._answer(number, scene_id, data)
            return True
        return False

    def _answer(self, number: int, scene_id: str, data: dict[str, Any]) -> Answer:
        outcome, error, outcomes = data.get("outcome"), data.get("error"), get_args(Outcome)

        def fault(kind: Kind, what: str) -> None:
            self.report(kind, f"{quoted(scene_id)}: {what}", number)

        if outcome is not None and outcome not in outcomes:
            near = _nearest(str(outcome), outcomes)
            known = f"the outcomes are {', '.join(outcomes)}"
            fault("outcome", f"{quoted(outcome)} is not an outcome{near}; {known}")
            outcome = None
        for key in data:
            if key not in _TOP:
                self._report_key(number, key, _TOP)
        # An unreadable block only invalidates its own quantities; the rest is judged.
        values: dict[str, Value] = {}
        told: dict[str, object] = {}
        unreadable = set()
        parts = {"": data}  # blocks, and blocks within them such as plate.approach
        for part, model in PARTS.items():
            outer, _, inner = part.rpartition(".")
            held = parts[outer].get(inner)
            parts[part] = held = {} if held is None else held
            if not isinstance(held, dict):
                fault("not a number", f"{part} is not a JSON object")
                unreadable |= {name for name in QUANTITIES if name.startswith(f"{part}.")}
                parts[part] = {}
                continue
            for key, given in held.items():
                name = f"{part}.{key}"
                size = QUANTITIES[name].size if name in QUANTITIES else 0
                if not size and key not in model.model_fields:
                    self._report_key(number, name, QUANTITIES)
                elif given is None or name in PARTS:
                    continue
                elif not size:
                    told[name] = _whole(given) if isinstance(given, Decimal) else given
                elif (value := _value(given, size)) is not None:
                    values[name] = value
                else:
                    unreadable.add(name)
                    needed = "a finite number" if size == 1 else "three finite numbers"
                    fault("not a number", f"{name} is {quoted(given)}; must be {needed}")
        path = None
        if (points := data.get("path")) is not None:
            try:
                path = _points(points)
            except ValueError as why:
                fault("path", f"path: {why}")
                unreadable.add("path.position")
        refused = None if error is None else quoted(error, 200)
        outcome = cast(Outcome | None, outcome)
        return Answer(scene_id, outcome, values, frozenset(unreadable), refused, path, told)

    def _report_key(self, number: int, key: str, known: Iterable[str], told: str = "{}") -> None:
        if key not in self._unknown and len(self._unknown) < KEPT:
            self._unknown.add(key)
            # A candidate may print the scene that it reads.
            near = ", but of a scene" if key in _ASKED else _nearest(key, known)
            sentence = f"{told.format(quoted(key))} is not a key of a result{near}"
            self.report("unknown key", sentence, number)


def _is_cut(text: str, error: json.JSONDecodeError) -> bool:
    """Check that a text could go on as JSON."""
    return error.pos >= len(text) or not (text.endswith("}") or error.msg == "Extra data")


_TOP = {*Result.model_fields, "path"}
_ASKED = {key for kind in KINDS.values() for key in kind.model_fields} - _TOP


def _decimal(text: str) -> Decimal:
    try:
        return Decimal(text)
    except InvalidOperation:  # an exponent with more digits than any number needs, or no number
        return Decimal("NaN")


# Numbers are read as decimals, as written: a float would round them, and messages would show digits
# that are not in the output.
_NUMBERS: dict[str, Any] = dict.fromkeys(("parse_float", "parse_int", "parse_constant"), _decimal)


def _nearest(name: str, known: Iterable[str]) -> str:
    """Return a question with the known name that is nearest; nothing if none is near."""
    plain = {k.replace("_", "").lower(): k for k in known}
    found = difflib.get_close_matches(name.replace("_", "").lower(), plain, n=1, cutoff=0.5)
    return f"; did you mean {plain[found[0]]}?" if found else ""


def quoted(what: Any, longest: int = 60) -> str:
    """Return untrusted text with its control characters escaped, cut to a length.

    A terminal obeys escape sequences, and a line break would forge a line of the verdict.
    """
    if isinstance(what, Decimal):
        what = str(what)
    elif isinstance(what, dict | list):
        what = json.dumps(what, default=str)
    elif not isinstance(what, str):
        return str(what)
    text = "".join(c if c.isprintable() else repr(c)[1:-1] for c in what[: longest + 1])
    return text if len(text) <= longest else text[: longest - 3] + "..."


def printable(text: str) -> str:
    """Return a text without control characters and the sequences that they begin."""
    bare = re.sub(r"\x1b(\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)|.)", "", text)
    return "".join(c if c.isprintable() or c == "\n" else " " for c in bare).strip()


def _whole(x: Decimal) -> object:
    """Return a whole number as one; of another number its text."""
    whole = _ordinary(x) and abs(x) < _LARGEST_WHOLE and x == x.to_integral_value()
    return int(x) if whole else quoted(x)


_LARGEST_WHOLE = 10**9


def _value(given: Any, size: int) -> Value | None:
    """Return a quantity as decimals; None if it is not that many finite numbers."""
    if size == 1:
        given = [given]
    if not isinstance(given, list) or len(given) != size:
        return None
    numbers = []
    for item in given:
        if isinstance(item, dict):  # {"value": "decimal string" or a number, "radius": ...}
            item = item.get("value")
            item = _decimal(item) if isinstance(item, str) else item
        if not isinstance(item, Decimal) or not _ordinary(item):
            return None
        numbers.append(item)
    return tuple(numbers)


def _points(given: Any) -> Array:
    """Return points as an array; a ValueError says why they are no path."""
    if not isinstance(given, list) or len(given) < 2:
        raise ValueError("must be at least two points [t, x, y, z] or [t, x, y, z, vx, vy, vz]")
    if len(given) > MOST_POINTS:
        raise ValueError(f"{len(given)} points; at most {MOST_POINTS} are read")
    width = len(given[0]) if isinstance(given[0], list) else 0
    for i, row in enumerate(given):
        if not isinstance(row, list) or len(row) != width or width not in (4, 7):
            raise ValueError(f"point {i} is {quoted(row)}; must have 4 or 7 numbers")
        if not all(isinstance(x, Decimal) and _ordinary(x) for x in row):
            raise ValueError(f"point {i} is {quoted(row)}; numbers must be finite")
    points = np.array(given, float)
    back = np.flatnonzero(np.diff(points[:, 0]) <= 0)
    if back.size:
        i = int(back[0]) + 1
        a, b = points[i - 1 : i + 1, 0]
        raise ValueError(f"time does not increase at point {i}: {a:g} s, then {b:g} s")
    return points


def _ordinary(x: Decimal) -> bool:
    """True if a number is finite, and small enough for its error to be a double."""
    # The size of a difference is a float, which overflows beyond 1e308.
    return x.is_finite() and (x.is_zero() or -400 <= x.adjusted() <= 300)


# --- lines, and results in a file -----------------------------------------------------------------


def split_lines(
    chunks: Iterable[bytes], longest: int = LONGEST_LINE
) -> Iterator[tuple[int, bytes | None]]:
    """Yield lines and their numbers, from 1; None for one that is too long.

    The memory needed is that of the longest line allowed, whatever comes.
    """
    number, held, overflowed = 1, bytearray(), False
    for chunk in chunks:
        for i, text in enumerate(chunk.split(b"\n")):
            if i:  # a line ends before it
                yield number, None if overflowed else bytes(held)
                number, held, overflowed = number + 1, bytearray(), False
            overflowed |= len(held) + len(text) > longest
            if overflowed:
                held.clear()
            else:
                held += text
    if held or overflowed:
        yield number, None if overflowed else bytes(held)


def lines_of(path: Path, longest: int = LONGEST_LINE) -> Iterator[tuple[int, bytes | None]]:
    """Yield the lines of a file; see `split_lines`."""
    with open(path, "rb") as file:
        yield from split_lines(iter(partial(file.read, CHUNK), b""), longest)


class BadTable(ValueError):
    """A table that cannot be read as results; the message says why."""


def read_results(
    path: Path, asked: Collection[str], columns: Mapping[str, str] | None = None
) -> Collector:
    """Read a file of results: JSON Lines, or CSV if its name ends in .csv.

    `asked` are ids of scenes; `columns` tells which of `COLUMNS` a column of CSV is, where its name
    does not say so. A `BadTable` has no id column, or not those.
    """
    kind, lines = path.suffix.lower(), lines_of(path)
    collector = Collector(asked, table=kind == ".csv")
    if kind == ".csv":
        _, line = next(lines, (1, b""))
        collector.begin_table(_columns(line or b"", columns or {}))
    elif kind == ".parquet":
        raise BadTable(f"{path}: results are read from .jsonl or .csv, not from .parquet")
    elif columns:
        raise BadTable("columns are named for a CSV file only; this is read as JSON Lines")
    for number, line in lines:
        collector.take_line(number, line)
    return collector


# Flags, texts and counts of a result: reported, not measured.
FACTS = [
    name
    for part, model in PARTS.items()
    for key in model.model_fields
    for name in [f"{part}.{key}"]
    if name not in {**QUANTITIES, **PARTS}
]
_TEXTS = ("id", "outcome", "error")
COLUMNS = (*_TEXTS, *(name for spec in QUANTITIES.values() for name in spec.names), *FACTS)


def _columns(line: bytes, columns: Mapping[str, str]) -> list[str]:
    """Return the numbers and texts under a header, by column."""
    try:
        header = _cells(line.decode("utf-8-sig", errors="replace"))
    except csv.Error as error:
        raise BadTable(f"its head is not CSV: {error}") from None
    there = f"the columns are {', '.join(header)}"
    for column, name in columns.items():
        if column not in header:
            raise BadTable(f"there is no column {column}; {there}")
        if name not in COLUMNS:
            raise BadTable(f"a column cannot hold {name}; it can hold {', '.join(COLUMNS)}")
    names = [columns.get(column, column) for column in header]
    if len(set(names)) < len(names):
        raise BadTable("two columns hold the same")
    if "id" not in names:
        raise BadTable(
            "there is no id column; name the one that holds it by --column COLUMN=id; "
            f"{there}{other_separators(header)}"
        )
    return names


def _cells(text: str) -> list[str]:
    """Return the cells of a row of CSV."""
    rows = csv.reader([text.strip()], strict=True, skipinitialspace=True)
    return [cell.strip() for cell in next(rows, [])]


def _nested(cells: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Return a row as a result is written in JSON; an empty cell is a quantity left out."""
    values: dict[str, object] = {}
    for name, cell in cells:
        if not cell or name not in COLUMNS:
            continue
        # A component of a vector: the others are None until they come, and make it unreadable if
        # they do not.
        if "[" in name:
            values = dict.fromkeys(QUANTITIES[name.partition("[")[0]].names) | values
        read = unguarded if name in _TEXTS else _fact if name in FACTS else _decimal
        values[name] = read(cell)
    return nested(values)


def _fact(cell: str) -> object:
    """Return a cell's value if it is not measured: a flag, the number of a chord, a text."""
    if cell.lower() in ("true", "false"):
        return cell.lower() == "true"
    return _decimal(cell) if cell.lstrip("-").isdigit() else cell


# --- results that are no lines yet ----------------------------------------------------------------


def line_of(scene_id: str, obtained: Any) -> bytes:
    """Return a result under an id as JSON, as another implementation's line would come."""
    obtained = getattr(obtained, "result", obtained)  # of a `longball.Solution`
    if isinstance(obtained, Result):
        obtained = json.loads(obtained.line())
    if not isinstance(obtained, Mapping):
        raise TypeError(f"a result is a mapping; not an object of type {type(obtained).__name__}")
    return json.dumps(plain({**obtained, "id": scene_id})).encode()
