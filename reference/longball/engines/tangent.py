"""Derivatives of results by numbers of a scene, by jets through the chain, for any path engine.

A `Jet` is a number and its derivative by one number x of the scene, which a `Seed` marks. The chain
works for every number system, and so for jets. Two things are added:

- A flight is integrated with its derivative ``ξ = ∂(state)/∂x`` at a fixed time, which obeys the
  variational equation ``ξ' = (∂f/∂state) ξ + ∂f/∂x`` of the law ``state' = f`` (Hairer, Nørsett
  and Wanner, *Solving Ordinary Differential Equations I*, Sec. I.14). Both together are one traced
  law, which the inner engine integrates, or proves, like any other.
- An event, a zero at t of ``g(state(t), x)``, moves by ``dt/dx = -(∂g/∂x)/ġ``, with ξ in ∂g/∂x.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

from longball.engines.chain import quantities_of, view_of
from longball.engines.enclosure import Enclosure
from longball.engines.engine import CannotSolve, Touch
from longball.engines.event import BatSection, Curve, Event, Events, Piece
from longball.engines.path import Flight
from longball.engines.path_engine import PathEngine
from longball.engines.polynomial import Arithmetic, Dual
from longball.model.inputs import TRACKED, launched, tracked, value_of
from longball.model.law import Law, State
from longball.model.numbers import DOUBLES, Numbers, Undecided
from longball.model.quantities import flat, number, unknown
from longball.model.scene import InvalidScene, Scene
from longball.model.trace import RATE, variational


class Seed(float):
    """A number of a scene with its derivative by the variable x, a float for all other purposes."""

    rate: float

    def __new__(cls, value: float, rate: float) -> Seed:
        """Return the number with its rate."""
        seed = super().__new__(cls, value)
        seed.rate = rate
        return seed

    # The chain adds two numbers of a scene as doubles only in ẑ = z'_b + σ_b, and in sums of
    # positions.
    def __add__(self, other: float) -> Seed:
        return Seed(float(self) + float(other), self.rate + getattr(other, "rate", 0.0))

    __radd__ = __add__


class Jet(Arithmetic):
    """A number and its derivative, both of the inner engine, or both polynomials of such numbers.

    Inequalities compare the numbers alone. Equality also needs equal derivatives, because a term
    that the chain omits at zero must stay zero nearby. The parts of a `Dual` may be jets.
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

    # Faster than the sum with -other, which for columns takes twice as long.

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

    # |x| has no derivative at 0; the chain takes it only of differences that are compared with
    # errors.
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
    """Return the number of a jet; other numbers are unchanged."""
    return x.value if isinstance(x, Jet) else x


def rate_of(x: Any) -> Any:
    """Return the derivative of a jet; 0 for other numbers."""
    return x.rate if isinstance(x, Jet) else 0


@dataclass(frozen=True)
class Jets(Numbers):
    """Jets of a number system; see `longball.model.numbers.Numbers`."""

    inner: Any  # a number system

    jet: ClassVar[type[Jet]] = Jet

    @property
    def pi(self) -> Jet:
        """The constant."""
        return self.jet(self.inner.pi)

    @property
    def rounding(self) -> Any:  # type: ignore[override]
        """See `Numbers`."""
        return self.inner.rounding

    def arithmetic(self) -> Any:
        """See `Numbers`."""
        return self.inner.arithmetic()

    @property
    def functions(self) -> Mapping[str, Callable[..., Jet]]:  # type: ignore[override]
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
        """Return a double as a jet; its derivative is 0, unless it is a `Seed`."""
        rate = self.inner.exact(value.rate) if isinstance(value, Seed) else 0
        return Jet(self.inner.exact(float(value)), rate)

    def absent(self, value: Any) -> bool:
        """True if a number of a scene is zero, and does not depend on x."""
        return bool(value == 0 and getattr(value, "rate", 0) == 0)

    def sqrt(self, x: Any) -> Jet:
        """Return the square root; raise `Kink` at zero, where it has a corner."""
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
        # d atan2(v, u) = (u dv - v du)/(u² + v²)
        (u, v), (du, dv) = (plain_of(x), plain_of(y)), (rate_of(x), rate_of(y))
        turn = 0 if rate_of(x) == rate_of(y) == 0 else (u * dv - v * du) / (u * u + v * v)
        return Jet(self.inner.angle(v, u), turn)

    def positive(self, x: Any, error: Any, question: str) -> bool:
        """See `Numbers`; raise `Kink` if x is on the boundary of two answers."""
        if plain_of(x) == 0 and not rate_of(x) == 0:
            raise Kink(f"{question} depends on arbitrarily small changes of this number")
        return bool(self.inner.positive(plain_of(x), plain_of(error), question))

    def report(self, x: Any) -> Any:
        """Return the number as the inner system reports it."""
        return self.inner.report(plain_of(x))


class Kink(CannotSolve):
    """Raised if a result has no derivative."""


class Shallow(CannotSolve):
    """Raised if the ball meets a surface at so small an angle that doubles have too few digits."""


# --- flights --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tangent(PathEngine):
    """Flights in jets."""

    inner: PathEngine  # integrates a law with its variational equation

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
        """Flight error of the inner engine."""
        return self.inner.flight_error

    def steps(
        self, law: Law, start: State, begin: Jet, limit: Jet, events: Events
    ) -> Iterator[JetPiece]:
        """Yield the pieces of a flight; see `PathEngine.steps`.

        The times of the pieces do not depend on x. If the beginning does, the change is in the
        state.
        """
        # one law for state and derivative: the variational equation of the program
        values = {name: plain_of(x) for name, x in law.strengths.items()}
        numbers = self.inner.numbers
        nothing = numbers.exact(0.0)
        changes = {f"{name}{RATE}": nothing + rate_of(x) for name, x in law.strengths.items()}
        code = variational(law.program)
        flown = Law(code, {name: (values | changes)[name] for name in code.parameters}, law.shape)
        rates = flown.rates(numbers)
        # A beginning that moves by dt/dx changes the state at a fixed time by -f dt/dx.
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
            return Event(event.name, event.question, value, size, slope)

        ends = [inner(event) for event in events]
        first, last = plain_of(begin), plain_of(limit)
        for piece in self.inner.steps(flown, flown.state(*now, *moved), first, last, ends):
            times = Jet(piece.begin), Jet(piece.length)
            yield JetPiece(*times, piece, law.state, rates, numbers.rounding)

    def fly(self, law: Law, start: State, events: Events, limit: Jet) -> Flight:
        """Fly until the first of several events; see `Engine.fly`."""
        flight = super().fly(law, start, events, limit)
        if plain_of(flight.time) == 0 and flight.stop != "time":
            raise Kink("the flight ends where it starts; the smallest change may prolong it")
        return flight

    def touch(
        self,
        pitch: Flight,
        law: Law,
        bat: BatSection,
        events: Events,
        limit: Jet,
    ) -> Touch:
        """Find the contact of a pitch; see `Engine.touch`.

        The distance from the bat's axis has a corner at zero: a pitch through the axis has no
        derivative of the margin.
        """
        met = super().touch(pitch, law, bat, events, limit)
        if abs(bat.reach - met.margin) > ON_THE_AXIS * bat.reach:
            return met
        return replace(met, margin=Jet(plain_of(met.margin), rate_of(met.margin) * math.nan))


# Distance from the axis, relative to the reach, that counts as zero. Beyond it, the direction from
# the axis to the ball is known to six digits.
ON_THE_AXIS = 1e-9


def jets_of(inner: Sequence[Any], state: Callable[..., Any]) -> Any:
    """Return a state and its derivative, one list of numbers, as a state of jets."""
    half = len(inner) // 2
    return state(*map(Jet, inner[:half], inner[half:]))


class JetPiece(NamedTuple):
    """A piece of a flight in jets; see `longball.engines.event.Piece`."""

    begin: Jet
    length: Jet
    piece: Piece
    state: Callable[..., Any]
    rates: Callable[..., tuple[Any, ...]]
    rounding: float  # of the inner numbers

    def at(self, t: Jet) -> Any:
        """Return the state at a time, s since the beginning of the piece."""
        # At a time that depends on x: ξ + (d state/dt) dt/dx.
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
        """See `Curve`. To first order a value does not depend on the time of its turning point."""
        return [Jet(t) for t in self.inner.turns(plain_of(a), plain_of(b))]

    def _falling(self, t: Any) -> tuple[Any, Any, Sequence[Any]]:
        """Return ġ, the state and its rates."""
        inner = self.piece.piece.at(t)
        here = jets_of(inner, self.piece.state)
        speeds = self.piece.rates(*inner)[: len(here)]
        moved = [self._slope(here, n) * v for n, v in enumerate(speeds)]
        return sum(moved[1:], moved[0]), here, speeds

    def zero(self, a: Jet, b: Jet) -> Jet:
        """See `Curve`: ``dt/dx = -(∂g/∂x)/ġ``."""
        t = self.inner.zero(plain_of(a), plain_of(b))
        falls, here, speeds = self._falling(t)
        change = rate_of(self.value(here))
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
        # The second value removes the dependence of the event's own constants on x.
        return rate_of(up) - rate_of(level)

    def _require_steep(self, here: Any, falls: Any, speeds: Sequence[Any]) -> None:
        """Raise `Shallow` unless ġ has enough digits for a derivative."""
        if not self.piece.rounding:
            return
        places = [n for n, name in enumerate(here._fields) if name in ("s", "y", "z")]
        speed = math.hypot(*(speeds[n] for n in places))
        across = math.hypot(*(self._slope(here, n) for n in places)) * speed
        if not is_steep(falls, across, self.piece.rounding):
            raise Shallow(
                "the ball meets a surface at so small an angle that a derivative needs more digits "
                "than doubles have; use the engine enclosure"
            )


def is_steep(falls: Any, across: Any, rounding: float) -> Any:
    """True if ġ, which is at most `across`, has enough digits for a derivative."""
    # At the angle s between path and surface, an error ε of the position causes a relative error
    # ε/s² of ġ: a ball with the acceleration a gets s² V²/(2 a) below the surface, with an error of
    # ε.
    return rounding * _ROUNDINGS * across**2 <= _GOOD * falls**2


# Relative accuracy of derivatives; error of a position after a few steps, in half ulps.
_GOOD, _ROUNDINGS = 1e-12, 8


# --- derivatives ----------------------------------------------------------------------------------


def seeded_by(scene: Scene, name: str) -> tuple[Any, float]:
    """Return a view of a scene with a seed for an input, and the rate of the input.

    The rate is the size of the input, so that derivatives have the size of the result.
    """
    speed = abs(value_of(scene, name)) or 1.0  # a free choice
    rates = {name: 1.0}
    # A tracked quantity changes all components of its vector: take their rates from its formulas.
    if name in TRACKED:
        parts = {known: Jet(x, float(known == name)) for known, x in tracked(scene).items()}
        vectors = launched(parts, Jets(DOUBLES))
        rates = {f"{v}[{i}]": float(x.rate) for v, of in vectors.items() for i, x in enumerate(of)}
    seeds = {path: Seed(number(scene, path), rate * speed) for path, rate in rates.items()}
    return view_of(scene, seeds), speed


def derivatives_by(scene: Scene, name: str, engine: PathEngine) -> dict[str, Any]:
    """Return the derivatives of all numbers of a result by one input, as numbers of the engine.

    Raises `InvalidScene` if the scene has no such input; `CannotSolve` or `Undecided` if the result
    has no derivative, or the engine has no result.
    """
    marked, speed = seeded_by(scene, name)
    numbers = engine.numbers
    with numbers.arithmetic(), not_beyond_a_kink():
        try:
            jets = quantities_of(marked, Tangent(engine))
        except Shallow:
            finer = derivatives_by(scene, name, Enclosure(_DIGITS))
            return {quantity: numbers.exact(float(slope)) for quantity, slope in finer.items()}
        named = dict(flat(jets))
        return {
            path: (numbers.exact(0.0) + jet.rate) / numbers.exact(speed)
            for path, jet in named.items()
            if isinstance(jet, Jet)  # no outcomes and counts
        }


# Digits for shallow angles. A contact with a margin of 1e-15 m loses half of them.
_DIGITS = 30


@contextmanager
def not_beyond_a_kink() -> Iterator[None]:
    """Raise `Kink` for an operation without a result, such as a division by zero."""
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
        Derivatives by number of the result and number of the scene; NaN if there is none.
    refused
        Reasons why there are no derivatives by some numbers of the scene.

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
