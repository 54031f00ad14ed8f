"""The chain of an at-bat over columns: a number for each of many scenes.

It is the chain of `longball.engines.chain`, with arrays for numbers, so that a row has the bits
that its scene gets when it is solved alone. What cannot be answered is left without an outcome;
solved alone it has a reason.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, fields, is_dataclass, replace
from types import SimpleNamespace
from typing import Any, Protocol, cast, get_args

import numpy as np

from longball.engines.batch import flights, records
from longball.engines.batch.flights import Records
from longball.engines.batch.records import Start
from longball.engines.chain import Cases, Model, OneCase, described, land
from longball.engines.contact import BatSection, margin_error
from longball.engines.engine import Touch
from longball.engines.event import past
from longball.engines.path import Flight, Path
from longball.model.arrays import Array, Flags, Integers
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, ratio
from longball.model.result import Outcome
from longball.model.trace import Program

OUTCOMES: tuple[str, ...] = get_args(Outcome)
UNSOLVED = -1  # stands in a column of outcomes where a scene has no answer


# --- arrays as numbers ----------------------------------------------------------------------------


def _one_by_one(function: Callable[[float], float]) -> Callable[[Any], Any]:
    """Return a function over arrays that has the bits of a function of one number.

    It is NaN where that has no value that a double can hold: such a row is left without an answer.
    """

    def checked(x: float) -> float:
        try:
            return function(x)
        except (OverflowError, ValueError):
            return math.nan

    fast, careful = (np.vectorize(f, otypes=[np.float64]) for f in (function, checked))

    def over_arrays(x: Any) -> Any:
        try:
            return fast(x)[()]
        except (OverflowError, ValueError):
            return careful(x)[()]

    return over_arrays


class Elementwise:
    """Arrays of doubles as the numbers of the model's formulas (`longball.model.numbers`)."""

    pi = math.pi
    rounding = DOUBLES.rounding
    sqrt = staticmethod(np.sqrt)  # correctly rounded
    functions: Mapping[str, Callable[..., Any]] = {
        "sqrt": np.sqrt,
        "exp": _one_by_one(math.exp),
        "log": _one_by_one(math.log),
        "unit": np.vectorize(ratio),
    }

    def exact(self, value: Any) -> Any:
        """Return the doubles themselves."""
        return value

    def absent(self, value: Any) -> bool:
        """Tell whether a number is zero in all scenes."""
        return not np.any(value)

    def where(self, condition: Any, x: Any, y: Any) -> Any:
        """Return x where a condition holds, else y."""
        return np.where(condition, x, y)[()]  # a number of numbers

    def cos_sin(self, angle: Array) -> tuple[Array, Array]:
        """Return cosines and sines."""
        return _one_by_one(math.cos)(angle), _one_by_one(math.sin)(angle)

    def angle(self, y: Array, x: Array) -> Array:
        """Return the angles from the x axis to vectors, rad."""
        return np.arctan2(y, x)

    def positive(self, x: Array, error: Any, question: str) -> Any:
        """Tell where ``x > 0``, of numbers without error."""
        return x > 0.0


NUMBERS: Any = Elementwise()


# --- tables of results ----------------------------------------------------------------------------


# What an answer ends with: if it is no number, something before has overflowed.
_LAST = {
    "landed": "landing.distance",
    "batted": "landing.distance",
    "crossed": "plate.velocity[2]",
    "struck": "impact.velocity[2]",
    "home_run": "fence.clearance",
    "wall": "fence.clearance",
}


class Table:
    """Results, a row a scene: columns with the names of quantities, NaN where there is none.

    `part` gives a table of some of the rows, which writes into this one.
    """

    def __init__(self, rows: int) -> None:
        self.rows = slice(0, rows)
        self.whole = np.full(rows, UNSOLVED, np.int64)
        self.columns: dict[str, Array] = {}
        self.engines: dict[int, str] = {}  # of rows that others flew than the compiled code

    def __len__(self) -> int:
        return self.rows.stop - self.rows.start

    @property
    def outcome(self) -> Integers:
        """The outcomes, as places in OUTCOMES."""
        return self.whole[self.rows]

    def part(self, rows: slice) -> Table:
        """Return the table of a range of rows."""
        part = copy(self)
        part.rows = slice(rows.start, min(rows.stop, len(self.whole)))
        return part

    def copy_from(self, other: Table) -> None:
        """Write the outcomes and columns of another table of as many rows."""
        self.outcome[:] = other.outcome
        for name, column in other.columns.items():
            self.put(name, slice(None), column[other.rows])

    def withdraw_what_is_not_finite(self) -> None:
        """Leave rows without an answer if a quantity of theirs has overflowed."""
        overflown = np.zeros(len(self), bool)
        for column in self.columns.values():
            if column.dtype == float:
                overflown |= np.isinf(column[self.rows])
        for outcome, quantity in _LAST.items():
            if quantity in self.columns:
                reached = self.outcome == OUTCOMES.index(outcome)
                overflown |= reached & np.isnan(self.columns[quantity][self.rows])
        self.outcome[overflown] = UNSOLVED

    def put(self, name: str, rows: Any, values: Any) -> None:
        """Write a quantity into rows: an array of numbers or texts, or a vector of three."""
        if isinstance(values, tuple):
            for i, value in enumerate(values):
                self.put(f"{name}[{i}]", rows, value)
            return
        if name not in self.columns:
            empty = "" if np.asarray(values).dtype.kind == "U" else np.nan
            kind = "U16" if empty == "" else float
            self.columns.setdefault(name, np.full(len(self.whole), empty, kind))
        self.columns[name][self.rows][rows] = values


# --- flights by records ---------------------------------------------------------------------------


class BatchFlyer(Protocol):
    """Who flies balls for the chain, many at a time; `longball.engines.batch.engine.Batch` does."""

    @property
    def description(self) -> str:
        """Name and settings."""

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size."""

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records of starts by a law's program; return records of arrivals, in order."""


@dataclass(frozen=True)
class Flights(Flight[Any]):
    """Flights at their ends, `stop` being codes of `flights`, with launches and marks.

    See `longball.engines.batch.engine.OneFlight`.
    """

    launch: Start
    mark: Start

    def highest(self, numbers: Any) -> Start:
        """See `Flight.highest`; NaN where there is none."""
        unmarked = np.isnan(self.mark.time)
        falls = unmarked & ~(self.launch.state.w > 0.0)
        return _chosen(falls, self.launch, self.mark)

    def stopped(self, name: str) -> Any:
        """Tell which flights an event of that name stopped."""
        return self.stop == records.STOPS[name]  # type: ignore[comparison-overlap]

    def then(self, second: Flight[Any]) -> Flights:
        """Return these flights, going on as others where they ended."""
        top, other = self.highest(NUMBERS), cast(Start, second.highest(NUMBERS))
        later = Start(self.time + other.time, other.state)
        mark = _chosen(np.isnan(top.time), later, top)
        end = {"stop": second.stop, "time": self.time + second.time, "state": second.state}
        return replace(self, **end, mark=mark)


def _chosen(condition: Any, yes: Start, no: Start) -> Start:
    """Return one of two starts by a condition, row by row."""
    state = (np.where(condition, a, b)[()] for a, b in zip(yes.state, no.state, strict=True))
    return Start(np.where(condition, yes.time, no.time)[()], type(no.state)(*state))


@dataclass(frozen=True)
class Columns:
    """The engine of the chain over columns."""

    flyer: BatchFlyer

    numbers = NUMBERS

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size."""
        return self.flyer.flight_error

    def fly(self, law: Law[Any], start: State[Any], events: Any, limit: Any) -> Flights:
        """Fly to a stop; see `longball.engines.engine.Engine.fly`."""
        launch = Start(0.0, start)
        _, ends = records.flown(self.flyer, law, launch, events, limit)
        # Those are solved alone.
        ends["stop"][...] = np.where(
            records.starts_at_corner(law, start), flights.OUT_OF_RANGE, ends["stop"]
        )
        return Flights(
            Path(()),
            records.stops(ends, events),
            *records.placed(ends, law, events),
            launch,
            records.noted(ends, law, "mark_"),
        )

    def touch(
        self, pitch: Flights, law: Law[Any], bat: BatSection[Any], events: Any, limit: Any
    ) -> Touch[Any]:
        """Find how pitches meet the bat; see `longball.engines.engine.Engine.touch`."""
        clear = records.approach_is_clear(bat, pitch.state.z)
        start = merged(clear, select(pitch.mark, clear), select(pitch.launch, ~clear))
        error = margin_error(bat, pitch.state.z, self.flight_error, NUMBERS)
        over = [past(bat.frame, bat.reach, NUMBERS), *events]
        _, ends = records.flown(self.flyer, law, start, over, limit, records.Bat(bat, error))
        touched = ends["stop"] == flights.TOUCH
        missed = np.isin(
            records.stops(ends, over), [records.STOPS[name] for name in ("past", "ground", "time")]
        )
        told = touched | missed | (ends["stop"] == flights.GRAZES_BAT)
        margin = np.where(told, ends["margin"], np.nan)[()]
        time, state = records.noted(ends, law)
        told_apart = np.where(touched, 1, np.where(missed, 0, -1))[()]
        return Touch(margin, told_apart, time, state)  # type: ignore[arg-type]


# --- cases in columns -----------------------------------------------------------------------------


@dataclass(frozen=True)
class ManyCases(Cases[Any]):
    """Rows of a table."""

    scene: Any
    engine: Any
    model: Model
    table: Table
    rows: Integers

    @property
    def empty(self) -> bool:
        """See `Cases`."""
        return len(self.rows) == 0

    def decide(self, x: Array, error: Array, question: str) -> tuple[Flags, Flags]:
        """See `Cases`."""
        positive = np.greater(x, 0.0)
        decided = np.greater(abs(x), error) | ((x == 0.0) & (error == 0.0))
        return decided & positive, decided & ~positive

    def touched(self, touch: Touch[Any]) -> tuple[Flags, Flags]:
        """See `Cases`."""
        code: Any = touch.touched
        return code == 1, code == 0

    def take(self, condition: Any, *values: Any) -> tuple[Any, ...]:
        """See `Cases`."""
        rows = self._flags(condition)
        some = replace(self, scene=select(self.scene, rows), rows=self.rows[rows])
        return some, *(select(value, rows) for value in values)

    def either(
        self, condition: Any, yes: Callable[..., Any], no: Callable[..., Any], *values: Any
    ) -> Any:
        """See `Cases`."""
        flags = self._flags(condition)
        answers = [
            function(*self.take(which, *values)) if which.any() else None
            for function, which in ((yes, flags), (no, ~flags))
        ]
        return merged(flags, *answers)

    def record(self, name: str, value: Any) -> None:
        """See `Cases`."""
        self.table.put(name, self.rows, value)

    def conclude(self, outcome: Outcome) -> None:
        """See `Cases`."""
        self.table.outcome[self.rows] = OUTCOMES.index(outcome)

    def land_in_space(self, ball: Any, outcome: Outcome) -> None:
        """See `Cases`. Each alone: what it may cross depends on where it curves to."""
        for i, row in enumerate(self.rows):

            def one(column: Array, i: int = i) -> Any:
                return column[i].item()

            case = OneCase(_mapped(one, self.scene), self.engine.flyer, self.model)
            with contextlib.suppress(ArithmeticError):
                land(case, _mapped(one, ball.launch), outcome)
                for name, value in case.answer.items():
                    if name != "outcome":
                        self.table.put(name, row, value)
                self.table.outcome[row] = OUTCOMES.index(case.answer["outcome"])
                before = [self.engine.flyer.description] if hasattr(self.scene, "pitch") else []
                place = range(self.table.rows.start, self.table.rows.stop)[row]
                self.table.engines[place] = described([*before, *case.engines])

    def with_restitution(self, restitution: float, table: Table) -> ManyCases:
        """Return the same cases with other balls, writing into another table."""
        ball = SimpleNamespace(**{**vars(self.scene.ball), "restitution": restitution})
        scene = SimpleNamespace(**{**vars(self.scene), "ball": ball})
        return replace(self, scene=scene, table=table)

    def _flags(self, condition: Any) -> Flags:
        return np.broadcast_to(condition, len(self.rows))


def select(value: Any, rows: Flags | slice) -> Any:
    """Return some rows of whatever holds columns; a number is that of every row."""
    if isinstance(rows, np.ndarray) and rows.all():
        return value  # a view copies nothing
    return _mapped(lambda column: column[rows], value)


def merged(flags: Flags, yes: Any, no: Any) -> Any:
    """Return columns that are `yes` where a flag is set, else `no`, each with its own rows only."""
    if yes is None or no is None:
        return no if yes is None else yes

    def merge(a: Any, b: Any) -> Any:
        column = np.empty(len(flags), np.result_type(a, b))
        column[flags], column[~flags] = a, b
        return column

    return _mapped(merge, yes, no)


def _mapped(function: Callable[..., Any], *values: Any) -> Any:
    """Return a structure of columns with a function of each."""
    first = values[0]
    match first:
        case np.ndarray():
            return function(*values)
        case float() | str() | None if len(values) == 1:
            return first
        case tuple() | list():
            parts = [_mapped(function, *same) for same in zip(*values, strict=True)]
            return type(first)(*parts) if hasattr(first, "_fields") else type(first)(parts)
        case Mapping():
            return {name: _mapped(function, *(value[name] for value in values)) for name in first}
        case SimpleNamespace():
            return SimpleNamespace(**_mapped(function, *map(vars, values)))
        case Law():
            return replace(first, strengths=_mapped(function, *(law.strengths for law in values)))
        case _ if is_dataclass(first):
            names = [f.name for f in fields(first)]
            changed = {n: _mapped(function, *(getattr(v, n) for v in values)) for n in names}
            return replace(first, **changed)  # type: ignore[type-var]
    if any(isinstance(value, np.ndarray) for value in values):
        return function(*values)
    return first
