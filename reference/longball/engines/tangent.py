"""Derivatives of results by numbers of a scene: the chain followed in jets, by any path engine.

A `Jet` is a number and its derivative by one number x of the scene, which `seeded` marks. The chain
is written over number systems, so that it hands on jets as it does doubles; what an engine adds:

- A flight is flown together with its derivative, ``ξ = ∂(state)/∂x`` at a fixed time, which obeys
  the variational equation ``ξ' = (∂f/∂state) ξ + ∂f/∂x`` of the law ``state' = f`` (Hairer, Nørsett
  and Wanner, *Solving Ordinary Differential Equations I*, Sec. I.14). Both are one traced law, so
  that the inner engine flies it as exactly as any other, or proves it.
- An event, a zero at t of ``g(state(t), x)``, moves by ``dt/dx = -(∂g/∂x)/ġ``, with ξ in ∂g/∂x.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeVar

from pydantic import BaseModel

from longball.engines.chain import quantities_of
from longball.engines.enclosure import Enclosure
from longball.engines.engine import CannotSolve, Touch
from longball.engines.event import BatSection, Curve, Event, Events, Piece
from longball.engines.path import Flight
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import Arithmetic, Dual
from longball.engines.variation import RATE, variational
from longball.model.inputs import TRACKED, launched, tracked, value_of
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, Numbers, Undecided
from longball.model.quantities import steps_of, unknown
from longball.model.scene import InvalidScene, Scene

B = TypeVar("B", bound=BaseModel)


class Seed(float):
    """A number of a scene that derivatives are taken by, with the rate that it stands for."""

    rate: float

    def __new__(cls, value: float, rate: float) -> Seed:
        """Return the number, marked."""
        seed = super().__new__(cls, value)
        seed.rate = rate
        return seed

    def __add__(self, other: float) -> Seed:
        return Seed(float(self) + float(other), self.rate + getattr(other, "rate", 0.0))

    __radd__ = __add__


def seeded(block: B, rates: Mapping[str, float]) -> B:
    """Return a scene, or a block of one, whose numbers change at these rates."""
    for name, rate in rates.items():
        block = _marked(block, steps_of(name), rate)
    return block


def _marked(block: Any, steps: Sequence[str], rate: float) -> Any:
    if not steps:
        return Seed(block, rate)
    step, *rest = steps
    if isinstance(block, BaseModel):
        return block.model_copy(update={step: _marked(getattr(block, step), rest, rate)})
    return tuple(_marked(x, rest, rate) if str(i) == step else x for i, x in enumerate(block))


class Jet(Arithmetic):
    """A number and its derivative; of the inner engine's numbers, or of polynomials of these.

    It compares as its number does, but equals another only if the derivatives do as well: what the
    chain leaves out where it is zero must stay zero nearby. A `Dual` has jets as its parts.
    """

    __slots__ = ("rate", "value")

    def __init__(self, value: Any, rate: Any = 0) -> None:
        self.value, self.rate = value, rate

    def __add__(self, other: Any) -> Jet:
        if isinstance(other, Dual):
            return NotImplemented
        if isinstance(other, Jet):
            return type(self)(self.value + other.value, self.rate + other.rate)
        return type(self)(self.value + other, self.rate)

    def __neg__(self) -> Jet:
        return type(self)(-self.value, -self.rate)

    # Without a sum's change of signs, which takes as long as the sum where numbers are columns.

    def __sub__(self, other: Any) -> Jet:
        if isinstance(other, Dual):
            return NotImplemented
        if isinstance(other, Jet):
            return type(self)(self.value - other.value, self.rate - other.rate)
        return type(self)(self.value - other, self.rate)

    def __rsub__(self, other: Any) -> Jet:
        return type(self)(other - self.value, -self.rate)

    def __mul__(self, other: Any) -> Jet:
        if isinstance(other, Dual):
            return NotImplemented
        if isinstance(other, Jet):
            rate = self.rate * other.value + self.value * other.rate
            return type(self)(self.value * other.value, rate)
        return type(self)(self.value * other, self.rate * other)

    def __truediv__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            ratio = self.value / other.value
            return type(self)(ratio, (self.rate - ratio * other.rate) / other.value)
        return type(self)(self.value / other, self.rate / other)

    def __rtruediv__(self, other: Any) -> Jet:
        return type(self)(other) / self

    def __abs__(self) -> Jet:
        return -self if self.value < 0 else self

    def __lt__(self, other: Any) -> Any:
        return self.value < plain_of(other)

    def __le__(self, other: Any) -> Any:
        return self.value <= plain_of(other)

    def __gt__(self, other: Any) -> Any:
        return self.value > plain_of(other)

    def __ge__(self, other: Any) -> Any:
        return self.value >= plain_of(other)

    def __eq__(self, other: object) -> bool:
        return bool(self.value == plain_of(other) and self.rate == rate_of(other))

    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> float:
        return float(self.value)


def plain_of(x: Any) -> Any:
    """Return the number of a jet, and any other number as it is."""
    return x.value if isinstance(x, Jet) else x


def rate_of(x: Any) -> Any:
    """Return the derivative of a jet; 0 of any other number."""
    return x.rate if isinstance(x, Jet) else 0


@dataclass(frozen=True)
class Jets:
    """Jets of a number system; see `longball.model.numbers.Numbers`."""

    inner: Any  # a number system

    jet: ClassVar[type[Jet]] = Jet

    @property
    def pi(self) -> Jet:
        """The constant."""
        return self.jet(self.inner.pi)

    @property
    def rounding(self) -> Any:
        """See `Numbers`."""
        return self.inner.rounding

    def arithmetic(self) -> Any:
        """See `Numbers`."""
        return self.inner.arithmetic()

    @property
    def functions(self) -> Mapping[str, Callable[..., Jet]]:
        """See `Numbers`."""
        of = self.inner.functions

        def exp(x: Jet) -> Jet:
            value = of["exp"](x.value)
            return self.jet(value, value * x.rate)

        def log(x: Jet) -> Jet:
            return self.jet(of["log"](x.value), x.rate / x.value)

        def unit(part: Any, whole: Any) -> Any:
            return part / whole if whole != 0 else part * 0

        return {"sqrt": self.sqrt, "exp": exp, "log": log, "unit": unit}

    def exact(self, value: float) -> Jet:
        """Return a double, whose derivative is 0 unless it is a `Seed`."""
        rate = self.inner.exact(value.rate) if isinstance(value, Seed) else 0
        return Jet(self.inner.exact(float(value)), rate)

    def absent(self, value: Any) -> bool:
        """True if a number of a scene is zero, and stays so."""
        return bool(value == 0 and getattr(value, "rate", 0) == 0)

    def where(self, condition: Any, x: Any, y: Any) -> Any:
        """See `Numbers`."""
        return x if condition else y

    def sqrt(self, x: Any) -> Jet:
        """Return the square root; raise `Kink` where it has a corner."""
        root = self.inner.sqrt(plain_of(x))
        if rate_of(x) == 0:
            return Jet(root)
        if root == 0:
            raise Kink("a length is zero here, and has no derivative")
        return Jet(root, x.rate / (2 * root))

    def cos_sin(self, angle: Jet) -> tuple[Jet, Jet]:
        """See `Numbers`."""
        cos, sin = self.inner.cos_sin(angle.value)
        return self.jet(cos, -sin * angle.rate), self.jet(sin, cos * angle.rate)

    def angle(self, y: Any, x: Any) -> Jet:
        """Return the angle from the x axis to a vector, rad."""
        (u, v), (du, dv) = (plain_of(x), plain_of(y)), (rate_of(x), rate_of(y))
        turn = 0 if rate_of(x) == rate_of(y) == 0 else (u * dv - v * du) / (u * u + v * v)
        return Jet(self.inner.angle(v, u), turn)

    def positive(self, x: Any, error: Any, question: str) -> bool:
        """See `Numbers`; raise `Kink` for an input that stands on the border of two answers."""
        if plain_of(x) == 0 and not rate_of(x) == 0:
            raise Kink(f"{question} changes with this number, however little it changes")
        return bool(self.inner.positive(plain_of(x), plain_of(error), question))

    def report(self, x: Any) -> Any:
        """Return the number as the inner system reports it."""
        return self.inner.report(plain_of(x))


class Kink(CannotSolve):
    """A result has no derivative."""


class Shallow(CannotSolve):
    """A surface is met at so small an angle that a derivative needs more digits than there are."""


# --- flights --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tangent(PathEngine):
    """Flights in jets.

    Attributes
    ----------
    inner
        The engine that flies a law with its variational equation.
    """

    inner: PathEngine

    @property
    def description(self) -> str:
        """Name and settings of the inner engine."""
        return self.inner.description

    @property
    def numbers(self) -> Numbers:
        """Jets of the inner engine's numbers."""
        return Jets(self.inner.numbers)

    @property
    def flight_error(self) -> float:
        """That of the inner engine."""
        return self.inner.flight_error

    def steps(
        self, law: Law, start: State, begin: Jet, limit: Jet, events: Events
    ) -> Iterator[JetPiece]:
        """Yield the pieces of a flight; see `PathEngine.steps`.

        Their times are fixed: what a moving beginning does to the state is in the state.
        """
        values = {name: plain_of(x) for name, x in law.strengths.items()}
        numbers = self.inner.numbers
        nothing = numbers.exact(0.0)
        changes = {f"{name}{RATE}": nothing + rate_of(x) for name, x in law.strengths.items()}
        code = variational(law.program)
        flown = Law(code, {name: (values | changes)[name] for name in code.parameters}, law.shape)
        rates = flown.rates(numbers)
        now = [plain_of(x) for x in start]
        moved = [nothing + rate_of(x) for x in start]
        try:
            speeds = rates(*now, *moved)[: len(now)]
        except ZeroDivisionError:
            raise Kink("the ball is at rest in the air, where its forces have a corner") from None
        moved = [xi - v * rate_of(begin) for xi, v in zip(moved, speeds, strict=True)]

        def inner(event: Event) -> Event:
            def value(state: Any) -> Any:
                return plain_of(event.value(jets_of(state, law.state)))

            size, slope = plain_of(event.size), plain_of(event.slope)
            return Event(event.name, event.question, value, lambda state: state, size, slope)

        ends = [inner(event) for event in events]
        first, last = plain_of(begin), plain_of(limit)
        for piece in self.inner.steps(flown, flown.state(*now, *moved), first, last, ends):
            yield JetPiece(piece, law.state, rates, numbers.rounding)

    def fly(self, law: Law, start: State, events: Events, limit: Jet) -> Flight:
        """Fly until the first of several events; see `Engine.fly`."""
        flight = super().fly(law, start, events, limit)
        if plain_of(flight.time) == 0 and flight.stop != "time":
            raise Kink("the flight ends where it starts, and by the least change goes on")
        return flight

    def touch(
        self,
        pitch: Flight,
        law: Law,
        bat: BatSection,
        events: Events,
        limit: Jet,
    ) -> Touch:
        """Find how a pitch meets the bat; see `Engine.touch`.

        A distance has a corner at zero: a pitch that passes the bat's axis itself, to more digits
        than a derivative needs, has a margin without one.
        """
        met = super().touch(pitch, law, bat, events, limit)
        if abs(bat.reach - met.margin) > ON_THE_AXIS * bat.reach:
            return met
        return replace(met, margin=Jet(plain_of(met.margin), rate_of(met.margin) * math.nan))


# Of the reach: the direction in which a pitch passes the axis is then known to six digits.
ON_THE_AXIS = 1e-9


def jets_of(inner: Sequence[Any], state: Callable[..., Any]) -> Any:
    """Return a state of the law and its derivative as a state of jets."""
    half = len(inner) // 2
    return state(*map(Jet, inner[:half], inner[half:]))


@dataclass(frozen=True)
class JetPiece:
    """A piece of a flight in jets; see `longball.engines.event.Piece`."""

    piece: Piece
    state: Callable[..., Any]
    rates: Callable[..., tuple[Any, ...]]
    rounding: float  # of the inner numbers

    @property
    def begin(self) -> Jet:
        """When it begins, s since the launch."""
        return Jet(self.piece.begin)

    @property
    def length(self) -> Jet:
        """Length, s."""
        return Jet(self.piece.length)

    def at(self, t: Jet) -> Any:
        """Return the state at a time on the piece, s since it begins."""
        inner = self.piece.at(plain_of(t))
        state = jets_of(inner, self.state)
        if rate_of(t) == 0:
            return state
        speeds = self.rates(*inner)
        return self.state(
            *(Jet(x.value, x.rate + v * t.rate) for x, v in zip(state, speeds, strict=False))
        )

    def curve(self, value: Callable[[Any], Any]) -> JetCurve:
        """Return the value of an event along the piece."""

        def along(inner: Any) -> Any:
            return plain_of(value(jets_of(inner, self.state)))

        return JetCurve(self, value, self.piece.curve(along))


@dataclass(frozen=True)
class JetCurve:
    """The value of an event along a piece in jets; see `longball.engines.event.Curve`."""

    piece: JetPiece
    value: Callable[[Any], Any]
    inner: Curve

    def __call__(self, t: Jet) -> Jet:
        """Return the value."""
        return Jet(self.inner(plain_of(t)), rate_of(self.value(self.piece.at(t))))

    def positive(self, a: Jet, b: Jet) -> bool:
        """See `Curve`."""
        return self.inner.positive(plain_of(a), plain_of(b))

    def turns(self, a: Jet, b: Jet) -> Sequence[Jet]:
        """See `Curve`; to first order, a value does not change with the time at which it turns.

        Its derivative does: in doubles a turn is known to half of their digits, and so is taken
        where ġ is zero, of which g itself tells less.
        """
        turns = self.inner.turns(plain_of(a), plain_of(b))
        if not self.piece.rounding:
            return [Jet(t) for t in turns]
        h = self.piece.piece.length * _APART
        shifted = []
        for t in turns:
            curvature = (self._falling(t + h) - self._falling(t - h)) / (2 * h)
            step = -self._falling(t) / curvature if curvature else 0
            shifted.append(Jet(t + step if abs(step) < h else t))
        return shifted

    def _falling(self, t: Any) -> Any:
        """Return ġ."""
        inner = self.piece.piece.at(t)
        here = jets_of(inner, self.piece.state)
        return self._falling_at(here, self.piece.rates(*inner)[: len(here)])

    def _falling_at(self, here: Any, speeds: Sequence[Any]) -> Any:
        moved = [self._slope(here, n) * v for n, v in enumerate(speeds)]
        return sum(moved[1:], moved[0])

    def zero(self, a: Jet, b: Jet) -> Jet:
        """See `Curve`: ``dt/dx = -(∂g/∂x)/ġ``."""
        t = self.inner.zero(plain_of(a), plain_of(b))
        inner = self.piece.piece.at(t)
        here = jets_of(inner, self.piece.state)
        change, speeds = rate_of(self.value(here)), self.piece.rates(*inner)[: len(here)]
        falls = self._falling_at(here, speeds)
        if falls < 0:
            self._require_steep(here, falls, speeds)
        elif change != 0:
            raise Kink("the ball only grazes a surface here")
        return Jet(t) if change == 0 else Jet(t, -change / falls)

    def _slope(self, here: Any, n: int) -> Any:
        """Return ``∂g/∂x_n`` by a component of a state."""
        (up, level) = (
            self.value(type(here)(*(Jet(x.value, rate * (i == n)) for i, x in enumerate(here))))
            for rate in (1, 0)
        )
        return rate_of(up) - rate_of(level)  # the constants of an event change, too

    def _require_steep(self, here: Any, falls: Any, speeds: Sequence[Any]) -> None:
        """Require ġ to be known to as many digits as a derivative is to have."""
        if not self.piece.rounding:
            return
        places = [n for n, name in enumerate(here._fields) if name in ("s", "y", "z")]
        speed = math.hypot(*(speeds[n] for n in places))
        across = math.hypot(*(self._slope(here, n) for n in places)) * speed
        if not is_steep(falls, across, self.piece.rounding):
            raise Shallow(
                "a surface is met at so small an angle that doubles know too few digits of a "
                "derivative; take the engine enclosure"
            )


def is_steep(falls: Any, across: Any, rounding: float) -> Any:
    """True if ġ, which is at most `across`, is known to as many digits as a derivative is to have.

    An error ε of places makes one of ``ε/s²`` of ġ, relative, where a surface is met at the angle
    s: as deep below as the ball gets, ``s² V²/(2 a)``, it may get ε less or more.
    """
    return rounding * _ROUNDINGS * across**2 <= _GOOD * falls**2


# Of a piece: what ġ is compared over for its own rate, three digits of which are enough.
_APART = 2.0**-10
# Of a derivative, relative; and half ulps that a place is off, as after a flight of some steps.
_GOOD, _ROUNDINGS = 1e-12, 8


# --- derivatives ----------------------------------------------------------------------------------


def seeded_by(scene: Scene, name: str) -> tuple[Scene, float]:
    """Return a scene that changes with an input, and how fast the input does.

    As fast as it is large: derivatives are then of the size of the result.
    """
    speed = abs(value_of(scene, name)) or 1.0
    rates = {name: 1.0}
    if name in TRACKED:  # it changes all components of a vector
        parts = {known: Jet(x, float(known == name)) for known, x in tracked(scene).items()}
        vectors = launched(parts, Jets(DOUBLES))
        rates = {f"{v}[{i}]": float(x.rate) for v, of in vectors.items() for i, x in enumerate(of)}
    return seeded(scene, {path: rate * speed for path, rate in rates.items()}), speed


def derivatives_by(scene: Scene, name: str, engine: PathEngine) -> dict[str, Any]:
    """Return the derivatives of all numbers of a result by an input, by their names.

    They are numbers of the engine.

    Raises
    ------
    InvalidScene
        If the scene has no such input.
    CannotSolve, Undecided
        If the result has no derivative, or the engine has no result.
    """
    marked, speed = seeded_by(scene, name)
    numbers = engine.numbers
    with numbers.arithmetic(), not_beyond_a_kink():
        try:
            jets = quantities_of(marked, Tangent(engine))
        except Shallow:
            finer = derivatives_by(scene, name, Enclosure(_DIGITS))
            return {quantity: numbers.exact(float(slope)) for quantity, slope in finer.items()}
        return {
            path: (numbers.exact(0.0) + jet.rate) / numbers.exact(speed)
            for quantity, value in jets.items()
            for path, jet in _named(quantity, value)
        }


# A margin of 1e-15 m takes half of them.
_DIGITS = 30


@contextmanager
def not_beyond_a_kink() -> Iterator[None]:
    """Raise `Kink` for an operation that no number has a result of."""
    try:
        yield
    except (CannotSolve, Undecided, InvalidScene):
        raise
    except (ArithmeticError, ValueError) as error:
        raise Kink(f"a quantity has no derivative here ({error})") from None


@dataclass(frozen=True)
class Derivatives(Mapping[str, Mapping[str, Any]]):
    """Derivatives of the numbers of a result by numbers of its scene, in SI units.

    Attributes
    ----------
    table
        By result number and scene number. NaN where there is no derivative.
    refused
        Why there are no derivatives by some scene numbers.

    Examples
    --------
    Without air, a ball that leaves level ground at 45° with speed v lands v²/g away:

    >>> import longball as lb
    >>> ball = lb.Flight(launch={"position": (0, 0, 0), "velocity": (20, 0, 20)}, air=None)
    >>> by = lb.solve(ball, derivatives=["gravity"]).derivatives["landing.distance"]
    >>> round(by["gravity"], 6)  # -v²/g²
    -8.329863
    """

    table: Mapping[str, Mapping[str, Any]]
    refused: Mapping[str, str]

    def __getitem__(self, quantity: str) -> Mapping[str, Any]:
        """Return the derivatives of a number of the result."""
        if quantity not in self.table:
            raise KeyError(str(unknown(quantity, self.table)))
        return self.table[quantity]

    def __iter__(self) -> Iterator[str]:
        return iter(self.table)

    def __len__(self) -> int:
        return len(self.table)


def derivatives_of(
    scene: Scene, quantities: Iterable[str], names: Iterable[str], engine: PathEngine
) -> Derivatives:
    """Return the derivatives of numbers of a result by inputs; see `Derivatives`."""
    table: dict[str, dict[str, Any]] = {quantity: {} for quantity in quantities}
    refused: dict[str, str] = {}
    for name in names:
        slopes: Mapping[str, Any] = {}
        try:
            slopes = derivatives_by(scene, name, engine)
        except (CannotSolve, Undecided, ValueError) as error:
            refused[name] = str(error)
        for quantity, row in table.items():
            row[name] = engine.numbers.report(slopes[quantity]) if quantity in slopes else math.nan
    return Derivatives(table, refused)


def _named(quantity: str, value: Any) -> Iterator[tuple[str, Jet]]:
    """Yield the numbers of a quantity, by name; no outcomes, and no counts."""
    if isinstance(value, Jet):
        yield quantity, value
    elif isinstance(value, tuple):
        yield from ((f"{quantity}[{i}]", x) for i, x in enumerate(value))
