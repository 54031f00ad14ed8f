"""Exact results to test any engine with: closed forms, invariants, balance laws.

All are valid in the plane of a flight, for constant k_D, k_L and g (`longball.model.law`), and for
the number system of their arguments. `functions` are those of `math` for doubles, of `mpmath.mp`
for its numbers, and `METHODS` for numbers with functions as methods, such as flint's `arb`. No
numbers are compared, so that nothing is undecided.

Each docstring gives the equation and its reason. `drag` and `lift` are k_D and k_L in 1/m,
`gravity` is g in m/s²; speeds are in m/s, times in s, lengths in m. V = √(u² + w²).
"""

from __future__ import annotations

from operator import methodcaller
from types import SimpleNamespace
from typing import Any, NamedTuple, Protocol

from longball.model.law import PlaneState
from longball.model.numbers import N


class Functions(Protocol):
    """The functions of analysis, under their names in Python's `math`."""

    def sqrt(self, x: N, /) -> N: ...
    def exp(self, x: N, /) -> N: ...
    def expm1(self, x: N, /) -> N: ...
    def log(self, x: N, /) -> N: ...
    def log1p(self, x: N, /) -> N: ...
    def sin(self, x: N, /) -> N: ...
    def cos(self, x: N, /) -> N: ...
    def atan(self, x: N, /) -> N: ...
    def sinh(self, x: N, /) -> N: ...
    def cosh(self, x: N, /) -> N: ...


# Functions that call methods of their arguments: ``sqrt(x)`` is ``x.sqrt()``.
METHODS: Any = SimpleNamespace(
    **{name: methodcaller(name) for name in vars(Functions) if not name.startswith("_")}
)


# --- closed forms ---------------------------------------------------------------------------------


class Moment(NamedTuple):
    """A state of a flight and its time, s since launch."""

    time: N
    state: PlaneState


def parabola(start: PlaneState, gravity: N, time: N) -> PlaneState:
    """Return the state of a ball under gravity alone, `time` seconds after its launch.

    ``s = s₀ + u₀ t``, ``z = z₀ + w₀ t - g t²/2``, ``w = w₀ - g t``: u' = 0 and w' = -g, integrated
    twice.
    """
    fall = gravity * time
    return PlaneState(
        start.s + start.u * time, start.z + (start.w - fall / 2) * time, start.u, start.w - fall
    )


def parabola_to_floor(start: PlaneState, gravity: N, floor: N, functions: Functions) -> Moment:
    """Return time and state at which a ball under gravity alone falls to the height `floor`.

    ``w = -√(w₀² + 2g (z₀ - floor))`` from the energy, ``t = (w₀ - w)/g``; g > 0.
    """
    w = -functions.sqrt(start.w * start.w + 2 * gravity * (start.z - floor))
    time = (start.w - w) / gravity
    return Moment(time, PlaneState(start.s + start.u * time, floor, start.u, w))


def rise(start: PlaneState, drag: N, gravity: N, time: N, functions: Functions) -> PlaneState:
    """Return the state of a ball that rises vertically through the air; u₀ = 0 <= w.

    ``w = v tan(φ - τ)``, ``z = z₀ + log(cos(φ - τ)/cos φ)/k_D`` with the terminal speed
    v = √(g/k_D), τ = t √(g k_D) and tan φ = w₀/v, here without φ by the addition theorems:
    w' = -k_D w² - g is separable, and w = z' is the derivative of a logarithm.
    """
    terminal, tau = _terminal_speed(drag, gravity, functions), _tau(drag, gravity, time, functions)
    p, cos, sin = start.w / terminal, functions.cos(tau), functions.sin(tau)
    # cos(φ - τ)/cos φ
    growth = cos + p * sin
    return PlaneState(
        start.s,
        start.z + functions.log(growth) / drag,
        start.u,
        terminal * (p * cos - sin) / growth,
    )


def apex(start: PlaneState, drag: N, gravity: N, functions: Functions) -> Moment:
    """Return time and state at which a ball thrown straight up through the air comes to rest.

    ``t √(g k_D) = φ = arctan(w₀/v)``, ``z = z₀ + log(1 + w₀²/v²)/(2 k_D)``: `rise` at τ = φ.
    """
    p = start.w / _terminal_speed(drag, gravity, functions)
    time = functions.atan(p) / functions.sqrt(gravity * drag)
    # log1p keeps the digits of a slow throw.
    height = functions.log1p(p * p) / (2 * drag)
    return Moment(time, PlaneState(start.s, start.z + height, start.u, 0 * start.w))


def fall(start: PlaneState, drag: N, gravity: N, time: N, functions: Functions) -> PlaneState:
    """Return the state of a ball that falls vertically through the air; u₀ = 0 >= w₀.

    ``w = -v tanh(ψ + τ)``, ``z = z₀ - log(cosh(ψ + τ)/cosh ψ)/k_D`` with tanh ψ = -w₀/v and the
    rest as in `rise`, here without ψ, so that a ball faster than v needs no coth:
    w' = k_D w² - g is separable.
    """
    terminal, tau = _terminal_speed(drag, gravity, functions), _tau(drag, gravity, time, functions)
    q, cosh, sinh = -start.w / terminal, functions.cosh(tau), functions.sinh(tau)
    # cosh(ψ + τ)/cosh ψ
    growth = cosh + q * sinh
    return PlaneState(
        start.s,
        start.z - functions.log(growth) / drag,
        start.u,
        -terminal * (q * cosh + sinh) / growth,
    )


def fall_to_floor(start: PlaneState, drag: N, gravity: N, floor: N, functions: Functions) -> Moment:
    """Return time and state at which a ball that falls vertically reaches the height `floor`.

    ``w² = v² + (w₀² - v²) exp(-2 k_D h)`` with h = z₀ - floor, since d(w²)/dz = 2 (k_D w² - g) is
    linear in w²; ``exp τ = exp(k_D h) (v - w)/(v - w₀)`` inverts `fall`. Either h > 0 or w₀ < 0.
    """
    # In this form a short fall loses no digits, and a long one does not overflow.
    terminal = _terminal_speed(drag, gravity, functions)
    q, depth = -start.w / terminal, drag * (start.z - floor)
    spent = -functions.expm1(-2 * depth)
    end = functions.sqrt(q * q + (1 - q) * (1 + q) * spent)
    # end - q is a difference of squares over end + q.
    tau = depth + functions.log1p((1 - q) * spent / (end + q))
    time, w = tau / functions.sqrt(gravity * drag), -terminal * end
    return Moment(time, PlaneState(start.s, floor, start.u, w))


def weightless(
    start: PlaneState, drag: N | None, lift: N | None, time: N, functions: Functions
) -> PlaneState:
    """Return the state of a ball without weight, `time` seconds after its launch.

    V' = -k_D V² gives ``V = V₀/(1 + k_D V₀ t)`` after the path ``σ = log(1 + k_D V₀ t)/k_D``.
    Lift turns the velocity upwards at the rate k_L V, by the angle ``k_L σ``: the path is a circle
    of radius 1/k_L, and the ball is at the end of a chord of length ``2 sin(k_L σ/2)/k_L``. Without
    drag or lift: the limits k_D -> 0, k_L -> 0.
    """
    u, w = start.u, start.w
    speed = functions.sqrt(u * u + w * w)
    # V₀/V, as a number of the system even without drag
    slowing = 1 + 0 * speed
    arc = speed * time
    if drag is not None:
        slowing = 1 + drag * arc
        arc = functions.log1p(drag * arc) / drag
    if lift is None:
        return PlaneState(
            start.s + arc * u / speed, start.z + arc * w / speed, u / slowing, w / slowing
        )
    half = lift * arc / 2
    cos, sin = functions.cos(half), functions.sin(half)
    chord = 2 * sin / lift / speed
    # The chord is along the launch velocity turned by half the angle; the final velocity is turned
    # by the whole angle.
    along_u, along_w = u * cos - w * sin, u * sin + w * cos
    return PlaneState(
        start.s + chord * along_u,
        start.z + chord * along_w,
        (along_u * cos - along_w * sin) / slowing,
        (along_u * sin + along_w * cos) / slowing,
    )


# --- invariants -----------------------------------------------------------------------------------


def energy(state: PlaneState, gravity: N) -> N:
    """Return ``E = g z + V²/2``, m²/s², the energy per unit mass: constant without drag.

    Lift is perpendicular to the velocity and does no work.
    """
    return gravity * state.z + (state.u * state.u + state.w * state.w) / 2


def phugoid(state: PlaneState, lift: N, gravity: N, functions: Functions) -> N:
    """Return ``K = k_L V³/3 - g u``, m²/s³: constant without drag, loops included.

    Without drag V V' = -g w and u' = -k_L V w, so K' = k_L V² V' - g u' = 0. Lanchester's phugoid.
    """
    squared = state.u * state.u + state.w * state.w
    return lift * squared * functions.sqrt(squared) / 3 - gravity * state.u


# --- rates of the invariants under drag -----------------------------------------------------------


def energy_rate(state: PlaneState, drag: N, functions: Functions) -> N:
    """Return ``E' = -k_D V³``, m²/s³, on every flight: only drag does work."""
    squared = state.u * state.u + state.w * state.w
    return -drag * squared * functions.sqrt(squared)


def phugoid_rate(state: PlaneState, drag: N, lift: N, gravity: N, functions: Functions) -> N:
    """Return ``K' = -k_D V (k_L V³ - g u)``, m²/s⁴, on every flight.

    Drag adds -k_D V² to V' and -k_D V u to u', in K' = k_L V² V' - g u'.
    """
    squared = state.u * state.u + state.w * state.w
    speed = functions.sqrt(squared)
    return -drag * speed * (lift * squared * speed - gravity * state.u)


def _terminal_speed(drag: N, gravity: N, functions: Functions) -> N:
    return functions.sqrt(gravity / drag)


def _tau(drag: N, gravity: N, time: N, functions: Functions) -> N:
    return time * functions.sqrt(gravity * drag)
