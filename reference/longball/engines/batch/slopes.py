"""Derivatives in columns: jets of columns through the chain.

The derivatives are those of `longball.engines.tangent`; the compiled code integrates them with the
flights. Rows in which a derivative is less accurate, or may not exist, are marked in the table and
left to `longball.engines.tangent`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from longball.engines.batch import records
from longball.engines.batch.columns import (
    NUMBERS,
    Columns,
    Flights,
    Table,
)
from longball.engines.batch.flights import Records, Stop
from longball.engines.batch.records import Bat, Start
from longball.engines.engine import Touch
from longball.engines.event import BatSection, Event, Events
from longball.engines.path import Path
from longball.engines.tangent import ON_THE_AXIS, Jet, Jets, is_steep, plain_of, rate_of
from longball.model.arrays import Array, Flags
from longball.model.inputs import TRACKED, launched, tracks_of
from longball.model.law import Law
from longball.model.quantities import number
from longball.model.scene import FlightScene, Scene

# --- jets of columns ------------------------------------------------------------------------------


class ColumnJet(Jet):
    """A column of numbers, and their derivatives by some inputs.

    The value is of shape (rows,) or a number; the rate of shape (inputs, rows) or (inputs, 1), or
    it is 0.
    """

    __slots__ = ()
    __array_ufunc__ = None  # arrays are numbers here, and no lists of jets

    def __abs__(self) -> Jet:
        sense = np.where(self.value < 0, -1.0, 1.0)
        return ColumnJet(abs(self.value), self.rate * sense)

    def __eq__(self, other: object) -> Any:
        return (self.value == plain_of(other)) & np.all(self.rate == rate_of(other), axis=0)

    __hash__ = None


@dataclass(frozen=True, eq=False)
class ColumnSeed:
    """A column of numbers in a scene that derivatives are taken by, as a `tangent.Seed`."""

    numbers: Any
    rates: Any  # as of `ColumnJet`

    def __add__(self, other: Any) -> ColumnSeed:
        numbers, rates = getattr(other, "numbers", other), getattr(other, "rates", 0)
        return ColumnSeed(self.numbers + numbers, self.rates + rates)

    __radd__ = __add__

    def __eq__(self, other: object) -> bool:
        return bool(np.all(self.numbers == getattr(other, "numbers", other)))

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True)
class ColumnJets(Jets):
    """Jets of columns as the numbers of the chain."""

    # Rows of which a derivative is to be found alone
    doubtful: Flags = field(default_factory=lambda: np.zeros(1, bool))

    jet: ClassVar[type[Jet]] = ColumnJet

    def exact(self, value: Any) -> Any:
        """Return numbers of a scene, whose derivatives are 0 unless they are a `ColumnSeed`."""
        if isinstance(value, ColumnSeed):
            return ColumnJet(value.numbers, value.rates)
        return ColumnJet(value)

    def absent(self, value: Any) -> bool:
        """True if a number of a scene is zero, and stays so, in all rows."""
        jet = value if isinstance(value, Jet) else self.exact(value)
        return not (np.any(jet.value) or np.any(jet.rate))

    def where(self, condition: Any, x: Any, y: Any) -> Any:
        """See `Elementwise`."""
        value = NUMBERS.where(condition, plain_of(x), plain_of(y))
        if not isinstance(x, Jet) and not isinstance(y, Jet):
            return value
        rates = rate_of(x), rate_of(y)
        constant = all(isinstance(rate, int) for rate in rates)
        return ColumnJet(value, 0 if constant else np.where(condition, *rates))

    def sqrt(self, x: Any) -> Jet:
        """Return the square root."""
        root = np.sqrt(plain_of(x))
        return ColumnJet(root, _quotient(rate_of(x), 2 * root))

    def angle(self, y: Any, x: Any) -> Jet:
        """Return the angle from the x axis to a vector, rad."""
        (u, v), (du, dv) = (plain_of(x), plain_of(y)), (rate_of(x), rate_of(y))
        return ColumnJet(NUMBERS.angle(v, u), _quotient(u * dv - v * du, u * u + v * v))

    def positive(self, x: Any, error: Any, question: str) -> Any:
        """Elementwise ``x > 0``."""
        self.doubt_at_border(x)
        return plain_of(x) > 0.0

    def missing(self, x: Any) -> Any:
        """See `Elementwise`."""
        return NUMBERS.missing(plain_of(x))

    def doubt(self, rows: Any) -> None:
        """Mark rows for the scalar engine."""
        self.doubtful[...] |= rows

    def doubt_at_border(self, x: Any, rows: Any = True) -> None:
        """Mark rows for the scalar engine if a number is zero, and its derivative is not."""
        zero = plain_of(x) == 0.0
        if np.any(zero):
            self.doubt(rows & zero & np.any(rate_of(x) != 0, axis=0))


def _quotient(change: Any, divisor: Any) -> Any:
    """Return a rate over a number; nothing over any number is nothing."""
    if isinstance(change, int):
        return 0
    return np.where(change == 0, 0.0, change / divisor)


# --- inputs ---------------------------------------------------------------------------------------


def seeded_columns(
    scene: Scene, cells: Mapping[str, Array], names: Sequence[str]
) -> dict[str, Any]:
    """Return columns of a scene, with those of the numbers that change with inputs as seeds."""

    def known(path: str) -> Any:
        return cells[path] if path in cells else number(scene, path)

    def vector(name: str) -> tuple[Any, Any, Any]:
        return known(f"{name}[0]"), known(f"{name}[1]"), known(f"{name}[2]")

    # each number of the scene changes with itself
    unit = np.eye(len(names))[:, :, np.newaxis]
    rates: dict[str, Any] = {}
    for name, rate in zip(names, unit, strict=True):
        if name not in TRACKED:
            rates[name] = rates.get(name, 0) + rate
    # what trackers give changes all components of a vector, the others of these held fixed
    if isinstance(scene, FlightScene) and any(name in TRACKED for name in names):
        velocity = vector("launch.velocity")
        spin = None if scene.launch.spin is None else vector("launch.spin")
        parts = tracks_of(velocity, spin, NUMBERS, _norm, np.arctan2)
        jets = {
            name: ColumnJet(x, unit[names.index(name)] if name in names else 0)
            for name, x in parts.items()
        }
        for name, components in launched(jets, ColumnJets(NUMBERS)).items():
            for i, x in enumerate(components):
                path = f"{name}[{i}]"
                rates[path] = rates.get(path, 0) + rate_of(x)
    return {
        **cells,
        **{path: ColumnSeed(known(path), rate) for path, rate in rates.items()},
    }


# --- the run --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class JetFlights(Flights):
    """Flights in jets, whose marks are at fixed times."""

    law: Law  # in plain numbers

    def highest(self, numbers: Any) -> Start:
        """See `Flights`; the ball is highest where it ceases to rise."""
        time, state = self.mark
        speeds = self.law.rates(NUMBERS)(*map(plain_of, state))
        falls = speeds[self.law.variables.index("w")]
        top = _later(time, state, speeds, -_quotient(rate_of(state.w), falls))
        return Flights.highest(replace(self, mark=top), numbers)


def _later(time: Any, state: Any, speeds: Sequence[Any], late: Any) -> Start:
    """Return a time and a state whose time changes by `late` more."""
    moved = (ColumnJet(x.value, x.rate + v * late) for x, v in zip(state, speeds, strict=True))
    return Start(ColumnJet(plain_of(time), rate_of(time) + late), type(state)(*moved))


@dataclass
class SlopeColumns(Columns):
    """The run of a chain over the rows of a table, in jets."""

    inputs: int = field(kw_only=True)  # that derivatives are taken by
    slopes: Table = field(init=False)  # columns of shape (inputs, rows); `alone` is for them

    def __post_init__(self) -> None:
        super().__post_init__()
        self.slopes = Table(len(self.table))
        self.numbers = self.jets = ColumnJets(NUMBERS, self.slopes.alone)

    def decide(self, x: Any, error: Any, question: str, rows: Flags) -> tuple[Flags, Flags]:
        """See `Columns`."""
        self.jets.doubt_at_border(x, rows)
        return super().decide(plain_of(x), plain_of(error), question, rows)

    def record(self, name: str, value: Any, rows: Flags) -> None:
        """See `Run`."""
        if isinstance(value, tuple):
            for i, x in enumerate(value):
                self.record(f"{name}[{i}]", x, rows)
            return
        super().record(name, plain_of(value), rows)
        if isinstance(value, Jet):
            self.slopes.put(name, rows, self.rates(value))

    def rates(self, x: Any) -> Array:
        """Return derivatives in the shape of a column of slopes."""
        return np.broadcast_to(rate_of(x), (self.inputs, len(self.table)))

    def conclude_doubt(self) -> None:
        """Leave the rows without an answer, or without a derivative, to be solved alone."""
        self.jets.doubt(self.table.outcome < 0)
        for name, slopes in self.slopes.columns.items():
            there = ~np.isnan(self.table.columns[name])
            self.jets.doubt(there & ~np.isfinite(slopes.sum(axis=0)))

    def flights(self, law: Law, stops: Any, end: Start, launch: Start, mark: Start) -> JetFlights:
        """See `Columns`."""
        plain = _plain_law(law)
        return JetFlights(Path(()), stops, *end, launch, mark, numbers=self.jets, law=plain)

    def _flown(
        self,
        law: Law,
        start: Start,
        events: Events,
        limit: Any,
        rows: Flags,
        bat: Bat | None = None,
        changes: Sequence[Array] = (),
    ) -> Records:
        """Fly the rows of a mask, with derivatives at fixed times; see `Columns._flown`."""
        # The lanes fly plain numbers, by the same records as without derivatives: same bits.
        plain, state = _plain_law(law), start.state
        still = Start(plain_of(start.time), type(state)(*map(plain_of, state)))
        known = [_plain_event(event) for event in events]
        met = None if bat is None else Bat(_plain_section(bat.section), plain_of(bat.error))
        # dp/dx of (1) in `tangents`, and ξ where the flight starts
        strengths = records.in_lanes(law).strengths
        sources = [*map(strengths.get, records.in_lanes(plain).program.parameters), *state]
        rates = [*map(self.rates, sources)]
        return super()._flown(plain, still, known, plain_of(limit), rows, met, rates)

    def _noted(self, ends: Records, law: Law, prefix: str = "") -> Start:
        """See `Columns`; the times are fixed."""
        time, state = records.noted(ends, law, prefix)
        return Start(time, type(state)(*map(ColumnJet, state, records.rates_of(ends, prefix))))

    def _arrived(self, ends: Records, law: Law, events: Events, limit: Any, rows: Flags) -> Start:
        """See `Columns`; an event, a zero of g, moves by ``dt/dx = -(∂g/∂x)/ġ``."""
        plain, stop, end = _plain_law(law), ends["stop"], self._noted(ends, law)
        speeds = plain.rates(NUMBERS)(*map(plain_of, end.state))
        late: Any = np.where(stop == Stop.TIME_LIMIT, rate_of(limit), 0.0)
        for i, event in enumerate(events):
            here = stop == i
            change = rate_of(event.value(end.state))
            *slopes, _ = records.linear(plain, _plain_event(event).value)
            falls = sum((x * v for x, v in zip(slopes, speeds, strict=True)), np.float64(0.0))
            half = len(speeds) // 2
            self._require_steep(falls, _norm(*slopes[:half]) * _norm(*speeds[:half]), change, here)
            late = np.where(here, -_quotient(change, falls), late)
        time, moved = _later(end.time, end.state, speeds, late)

        # A flight that ends at its start continues after the least change: that is a corner.
        starts = (stop != Stop.TIME_LIMIT) & (ends["time"] == 0.0)
        self.jets.doubt(rows & (starts | (ends["steps"] > _MOST_STEPS)))
        return Start(time, records.placed(stop, moved, events, self.jets))

    def _require_steep(self, falls: Any, across: Any, change: Any, rows: Flags) -> None:
        """Leave rows to be solved alone in which a surface is grazed, or met at a small angle."""
        steep = (falls < 0) & is_steep(falls, across, NUMBERS.rounding)
        self.jets.doubt(rows & ~steep & np.any(change != 0, axis=0))

    def _touched_at(
        self, ends: Records, law: Law, bat: BatSection, touch: Touch, rows: Flags
    ) -> Touch:
        """See `Columns`."""
        code: Any = touch.touched
        # where the margin is taken: to first order, it does not change with the time of that
        distance = bat.distance(self._noted(ends, law, "nearest_").state, self.jets)
        margin = ColumnJet(touch.margin, rate_of(bat.reach - distance))
        self.jets.doubt(rows & (plain_of(distance) <= ON_THE_AXIS * plain_of(bat.reach)))

        # the touching, where half the square of the distance falls at the rate d·v
        time, touching = records.noted(ends, law)
        marked = self._noted(ends, law, "mark_").state
        state = type(touching)(*map(ColumnJet, touching, map(rate_of, marked)))
        falls = _plain_section(bat).approach(touching)
        change = 0.5 * rate_of(bat.outside(state))
        speed = _norm(*map(plain_of, bat.frame.velocity(state)))
        self._require_steep(falls, plain_of(bat.reach) * speed, change, rows & (code == 1))
        speeds = _plain_law(law).rates(NUMBERS)(*touching)
        return Touch(margin, code, *_later(time, state, speeds, -_quotient(change, falls)))


# Of a flight. Most take less than 30; one that takes more than this all but rests on its way, and
# its direction from there, on which a tangent hangs, is known to as many digits less.
_MOST_STEPS = 64  # a free choice


def _norm(*components: Any) -> Any:
    return np.sqrt(sum(x * x for x in components))


def _plain_law(law: Law) -> Law:
    plain = replace(law, strengths={name: plain_of(x) for name, x in law.strengths.items()})
    return records.formed(plain)


def _plain_section(bat: BatSection) -> BatSection:
    parts = {name: plain_of(getattr(bat.frame, name)) for name in ("x", "y", "cos", "sin")}
    return BatSection(replace(bat.frame, **parts), plain_of(bat.height), plain_of(bat.reach))


def _plain_event(event: Event) -> Event:
    def value(state: Any) -> Any:
        return plain_of(event.value(type(state)(*map(ColumnJet, state))))

    return event._replace(value=value, size=plain_of(event.size), slope=plain_of(event.slope))
