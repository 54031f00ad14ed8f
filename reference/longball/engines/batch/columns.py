"""The chain of an at-bat over columns: arrays with a number for each of many scenes.

It is the chain of `longball.engines.chain` with arrays as numbers, so that a row has the same bits
as its scene solved alone. Rows without an answer have no outcome; the scalar chain gives the
reason. It also solves what columns leave: see `Table.alone`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, cast, get_args

import numpy as np

from longball.engines.batch import flights, records
from longball.engines.batch.flights import Records, Stop
from longball.engines.batch.records import NOT_FLOWN, Bat, Start
from longball.engines.chain import Run
from longball.engines.engine import Touch
from longball.engines.event import BatSection, Events, margin_error, past
from longball.engines.path import Flight, Path
from longball.model.arrays import Array, Flags
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, ratio
from longball.model.result import Outcome
from longball.model.trace import Program

OUTCOMES: tuple[str, ...] = get_args(Outcome)
UNSOLVED = -1  # outcome of a row without an answer


# --- arrays as numbers ----------------------------------------------------------------------------


def _one_by_one(function: Callable[[float], float]) -> Callable[[Any], Any]:
    """Return a function over arrays with the same bits as a function of one number.

    It is NaN if the function raises an error; such a row has no answer.
    """
    # NumPy's own exp, log, cos and sin differ from those of `math` in last bits on some processors.

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
    angle = staticmethod(np.arctan2)
    missing = staticmethod(np.isnan)
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
        """True if a number is zero in all scenes."""
        return not np.any(value)

    def where(self, condition: Any, x: Any, y: Any) -> Any:
        """Return x where a condition holds, else y."""
        # [()] turns an array without dimensions into a number.
        return np.where(condition, x, y)[()]

    def cos_sin(self, angle: Array) -> tuple[Array, Array]:
        """Return cosines and sines."""
        return _one_by_one(math.cos)(angle), _one_by_one(math.sin)(angle)

    def positive(self, x: Array, error: Any, question: str) -> Any:
        """Elementwise ``x > 0``, for numbers without errors."""
        return x > 0.0


NUMBERS: Any = Elementwise()


# --- tables of results ----------------------------------------------------------------------------


# Last quantity of each outcome. Errors propagate as NaN: if this one is NaN, an earlier one
# overflowed.
_LAST = {
    "landed": "landing.distance",
    "batted": "landing.distance",
    "crossed": "plate.velocity[2]",
    "struck": "impact.velocity[2]",
    "home_run": "fence.clearance",
    "wall": "fence.clearance",
}


class Table:
    """Results, one row for each scene: columns with the names of quantities; NaN if absent.

    The last axis of a column is that of the rows.
    """

    def __init__(self, rows: int) -> None:
        self.outcome = np.full(rows, UNSOLVED)  # indices of OUTCOMES
        self.alone = np.zeros(rows, bool)  # rows that the scalar chain must solve
        self.columns: dict[str, Array] = {}

    def __len__(self) -> int:
        return len(self.outcome)

    def column(self, name: str, values: Any) -> Array:
        """Return the column of a quantity; create it for values of this type."""
        if name not in self.columns:
            known = np.asarray(values)
            absent, kind = ("", "U16") if known.dtype.kind == "U" else (np.nan, float)
            self.columns[name] = np.full((*known.shape[:-1], len(self)), absent, kind)
        return self.columns[name]

    def put(self, name: str, rows: Flags, values: Any) -> None:
        """Write a quantity into rows: an array of numbers or texts, or a vector of three arrays."""
        if isinstance(values, tuple):
            for i, value in enumerate(values):
                self.put(f"{name}[{i}]", rows, value)
        elif rows.any():
            np.copyto(self.column(name, values), values, where=rows)

    def write(self, i: int, answer: Mapping[str, Any]) -> None:
        """Write the outcome and the quantities of a row, by name."""
        for name, value in answer.items():
            if name == "outcome":
                self.outcome[i] = OUTCOMES.index(value)
            else:
                self.column(name, value)[i] = value

    def withdraw_what_is_not_finite(self) -> None:
        """Remove the answer of every row with an overflow."""
        overflown = np.zeros(len(self), bool)
        for column in self.columns.values():
            if column.dtype == float:
                overflown |= np.isinf(column)
        for outcome, quantity in _LAST.items():
            if quantity in self.columns:
                reached = self.outcome == OUTCOMES.index(outcome)
                overflown |= reached & np.isnan(self.columns[quantity])
        self.outcome[overflown] = UNSOLVED


def joined(tables: Sequence[Table], places: Sequence[Any]) -> Table:
    """Return one table with the rows of each of several at their places in it."""
    whole = Table(sum(map(len, tables)))
    for table, rows in zip(tables, places, strict=True):
        whole.outcome[rows], whole.alone[rows] = table.outcome, table.alone
        for name, column in table.columns.items():
            whole.column(name, column)[..., rows] = column
    return whole


# --- flights by records ---------------------------------------------------------------------------


class BatchFlyer(Protocol):
    """Protocol of engines that fly many balls at once; `batch.many.Batch` is one."""

    @property
    def description(self) -> str:
        """Name and settings."""

    @property
    def flight_error(self) -> float:
        """Error of a state at the end of a flight, relative to its size."""

    def fly_all(self, starts: Records, program: Program) -> Records:
        """Fly records of starts by a law's program; return records of arrivals, in order."""


@dataclass(frozen=True)
class Flights(Flight):
    """Ends, launches and marks of flights; `stop` holds codes of `records`.

    See `longball.engines.batch.flights.arrival_dtype` for the marks.
    """

    launch: Start
    mark: Start
    numbers: Any = field(default=NUMBERS, kw_only=True)

    def highest(self, numbers: Any) -> Start:
        """See `Flight.highest`; NaN if there is none."""
        # The mark is the highest point within the flight; a ball that only falls is highest at
        # launch.
        lower = numbers.missing(self.mark.time) | (self.launch.state.z > self.mark.state.z)
        return _where(numbers, lower & ~(self.launch.state.w > 0.0), self.launch, self.mark)

    def stopped(self, name: str) -> Any:
        """Return flags of the flights that an event of that name stopped."""
        return self.stop == records.STOPS[name]  # type: ignore[comparison-overlap]

    def then(self, second: Flight) -> Flights:
        """Return these flights, continued by those of `second` that were flown."""
        flown = second.stop != NOT_FLOWN  # type: ignore[comparison-overlap]
        stop: Any = np.where(flown, second.stop, self.stop)[()]
        numbers = self.numbers
        end = Start(self.time + second.time, second.state)
        time, state = _where(numbers, flown, end, Start(self.time, self.state))
        top, other = self.highest(numbers), cast(Start, second.highest(numbers))
        later = Start(self.time + other.time, other.state)
        higher = numbers.missing(top.time) | (later.state.z > top.state.z)
        mark = _where(numbers, higher, later, top)
        mark = _where(numbers, flown, mark, self.mark)
        return replace(self, stop=stop, time=time, state=state, mark=mark)


def _where(numbers: Any, flags: Any, yes: Start, no: Start) -> Start:
    """Return times and states: from `yes` where a flag is set, else from `no`."""
    state = (numbers.where(flags, a, b) for a, b in zip(yes.state, no.state, strict=True))
    return Start(numbers.where(flags, yes.time, no.time), type(no.state)(*state))


@dataclass
class Columns(Run):
    """The run of a chain over the rows of a table."""

    table: Table = field(kw_only=True)

    def __post_init__(self) -> None:
        self.numbers, self.everything = NUMBERS, np.ones(len(self.table), bool)

    def any(self, rows: Flags) -> bool:
        """See `Run`."""
        return bool(rows.any())

    def decide(self, x: Array, error: Array, question: str, rows: Flags) -> tuple[Flags, Flags]:
        """See `Run`."""
        # An exact zero with no error is decided: it is not positive.
        positive = np.greater(x, 0.0)
        decided = rows & (np.greater(abs(x), error) | ((x == 0.0) & (error == 0.0)))
        return decided & positive, decided & ~positive

    def fly(self, law: Law, start: State, events: Events, limit: Any, rows: Flags) -> Flights:
        """See `Run`. Flights without support in the compiled code are left to the scalar chain."""
        launch = Start(0.0, law.state_of(start))
        if not records.flies_in_lanes(law):
            self.leave(rows)
            return self.flights(law, NOT_FLOWN, launch, launch, launch)
        # An event of an infinite size, such as the plate for a pitch along its plane, is one that
        # the scalar engine rejects.
        size: Any = sum(event.size for event in events)
        alone = rows & ~np.isfinite(getattr(size, "value", size))
        ends = self._flown(law, launch, events, limit, rows & ~alone)
        stops = records.stops(ends, events)
        self.leave(alone | (rows & (stops == Stop.FALLBACK)))
        end = self._arrived(ends, law, events, limit, rows)
        return self.flights(law, stops, end, launch, self._noted(ends, law, "mark_"))

    def flights(self, law: Law, stops: Any, end: Start, launch: Start, mark: Start) -> Flights:
        """Return flights by their ends."""
        return Flights(Path(()), stops, *end, launch, mark)

    def _flown(
        self,
        law: Law,
        start: Start,
        events: Events,
        limit: Any,
        rows: Flags,
        bat: Bat | None = None,
        changes: Sequence[Array] = (),  # of `records.records_of`
    ) -> Records:
        """Fly the rows of a mask; return arrivals of all rows, or a single one for all."""
        program = records.in_lanes(law).program
        # If no number of the flight differs between rows, it is flown once.
        if rows.any():
            error = self.engine.flight_error
            begun = records.records_of(law, start, events, limit, error, bat, rows, changes)
            flown: Records = self.engine.fly_all(begun, program)
            if flown.ndim == 0 or rows.all():
                return flown
        # the others stay where they start
        inputs = len(changes[0]) if changes else 0
        ends = np.zeros(len(rows), flights.arrival_dtype(program, inputs))
        ends["stop"], ends["mark_time"], ends["rates"] = NOT_FLOWN, np.nan, np.nan
        for name in program.variables:
            ends[name] = getattr(start.state, name)
        if rows.any():
            ends[rows] = flown
        return ends

    def _noted(self, ends: Records, law: Law, prefix: str = "") -> Start:
        """Return time and state that arrivals hold under names with a prefix."""
        return records.noted(ends, law, prefix)

    def _arrived(self, ends: Records, law: Law, events: Events, limit: Any, rows: Flags) -> Start:
        """Return when and where flights ended, those that an event stopped being put onto it."""
        time, state = records.noted(ends, law)
        return Start(time, records.placed(ends["stop"], state, events, self.numbers))

    def touch(self, pitch: Any, law: Law, bat: BatSection, events: Events, rows: Flags) -> Touch:
        """See `Run`."""
        numbers = self.numbers
        error = margin_error(bat, pitch.state.z, self.engine.flight_error, numbers)
        over = [past(bat.frame, bat.reach, numbers), *events]
        # The search begins at the sampling plane, if nothing that counts can happen before it: the
        # ball is farther from the bat there than at the touching, and than at the plate.
        far = records.APPROACH * abs(bat.frame.cos)
        clear = (bat.reach < far) & (abs(bat.height - pitch.state.z) < far)
        start = _where(numbers, clear, pitch.mark, pitch.launch)
        ends = self._flown(law, start, over, self.time_limit, rows, Bat(bat, error))

        # 1 for a contact, 0 for a miss, -1 if undecided
        stops = records.stops(ends, over)
        self.leave(rows & (stops == Stop.FALLBACK))
        touched = stops == Stop.TOUCH
        missed = np.isin(stops, [records.STOPS[name] for name in ("past", "ground", "time")])
        margin = np.where(touched | missed, ends["margin"], np.nan)[()]
        code: Any = np.where(touched, 1, np.where(missed, 0, -1))[()]
        return self._touched_at(ends, law, bat, Touch(margin, code), rows)

    def _touched_at(
        self, ends: Records, law: Law, bat: BatSection, touch: Touch, rows: Flags
    ) -> Touch:
        """Return contacts with their times and states."""
        time, state = records.noted(ends, law)
        return replace(touch, time=time, state=state)

    def leave(self, rows: Flags) -> bool:
        """See `Run`."""
        self.table.alone |= rows
        return True

    def record(self, name: str, value: Any, rows: Flags) -> None:
        """See `Run`."""
        self.table.put(name, rows, value)

    def conclude(self, outcome: Outcome, rows: Flags) -> None:
        """See `Run`."""
        self.table.outcome[rows] = OUTCOMES.index(outcome)

    def refuse(self, reason: Exception, rows: Flags) -> None:
        """See `Run`."""

    def follow(self, frame: Any, flight: Flight, begin: Any, rows: Flags) -> None:
        """See `Run`."""
