"""Flights in fixed steps, as other simulators take them: what a candidate's integrator may be.

Each scheme is a function from a state, its rates and a step to the next state. Plate, bat and
ground are met as `longball.engines.verlet` meets them, between two steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longball.engines.engine import Launch
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.model.law import Law, State

Array = NDArray[np.float64]
Components = tuple[float, ...]
Rates = Callable[..., Components]
Step = Callable[[Rates, Components, float], Components]


def _plus(a: Components, h: float, b: Components) -> Components:
    return tuple(x + h * y for x, y in zip(a, b, strict=True))


def _euler(f: Rates, s: Components, h: float) -> Components:
    return _plus(s, h, f(*s))


def _semi_implicit(f: Rates, s: Components, h: float) -> Components:
    half = len(s) // 2
    v = _plus(s[half:], h, f(*s)[half:])
    return (*_plus(s[:half], h, v), *v)


def _implicit(f: Rates, s: Components, h: float) -> Components:
    new = _plus(s, h, f(*s))
    for _ in range(30):
        old, new = new, _plus(s, h, f(*new))
        if math.dist(old, new) < 1e-15 * math.hypot(*new):
            break
    return new


def _mean_velocity(f: Rates, s: Components, h: float) -> Components:
    half = len(s) // 2
    v = _plus(s[half:], h, f(*s)[half:])
    mean = tuple((a + b) / 2 for a, b in zip(s[half:], v, strict=True))
    return (*_plus(s[:half], h, mean), *v)


def _heun(f: Rates, s: Components, h: float) -> Components:
    a = f(*s)
    b = f(*_plus(s, h, a))
    return tuple(x + h * (p + q) / 2 for x, p, q in zip(s, a, b, strict=True))


def _midpoint(f: Rates, s: Components, h: float) -> Components:
    return _plus(s, h, f(*_plus(s, h / 2, f(*s))))


def _rk4(f: Rates, s: Components, h: float) -> Components:
    a = f(*s)
    b = f(*_plus(s, h / 2, a))
    c = f(*_plus(s, h / 2, b))
    d = f(*_plus(s, h, c))
    return tuple(
        x + h * (p + 2 * q + 2 * r + t) / 6 for x, p, q, r, t in zip(s, a, b, c, d, strict=True)
    )


def _rk4_old_velocity(f: Rates, s: Components, h: float) -> Components:
    half = len(s) // 2
    return (*_plus(s[:half], h, s[half:]), *_rk4(f, s, h)[half:])


def _rk4_new_velocity(f: Rates, s: Components, h: float) -> Components:
    half = len(s) // 2
    v = _rk4(f, s, h)[half:]
    return (*_plus(s[:half], h, v), *v)


# The scheme and its order, as its author would know it.
SCHEMES: dict[str, tuple[Step, int, str]] = {
    "explicit-euler": (_euler, 1, "Euler's method"),
    "semi-implicit-euler": (_semi_implicit, 1, "semi-implicit Euler, velocity first"),
    "implicit-euler": (_implicit, 1, "implicit Euler"),
    "euler-velocity": (_mean_velocity, 1, "Euler's method for the velocity and the mean of two "
                       "velocities for the position"),
    "heun": (_heun, 2, "Heun's method"),
    "midpoint": (_midpoint, 2, "the midpoint method"),
    "rk4-old-velocity": (_rk4_old_velocity, 1, "RK4 for the velocity, but the position moves with "
                         "the velocity at the step's start"),
    "rk4-new-velocity": (_rk4_new_velocity, 1, "RK4 for the velocity, but the position moves with "
                         "the velocity at the step's end"),
    "rk4": (_rk4, 4, "RK4"),
}  # fmt: skip


@dataclass(frozen=True)
class FixedStep(Verlet):
    """Flights in fixed steps of a scheme; ``chords`` is the true path, seen at the steps only.

    Attributes
    ----------
    scheme
        A name of `SCHEMES`, or "chords".
    """

    scheme: str = "explicit-euler"

    @property
    def description(self) -> str:
        """Scheme and step."""
        return f"{self.scheme} dt={self.dt!r}"

    def rebound(self, frame: Any, touch: Any, delta_v: Any, law_in: Any, ground: Any) -> Any:
        """Strike at once, where ball and bat touch."""
        position, before = frame.position(touch.state), frame.velocity(touch.state)
        velocity = tuple(v + d for v, d in zip(before, delta_v, strict=True))
        return Launch(position, velocity, touch.time, 0.0)

    def _march(
        self, law: Law[float], start: State[float], limit: float
    ) -> Iterator[tuple[int, Array]]:
        steps, done, length = math.ceil(min(limit / self.dt, 1e7)), 0, 128
        state: Components = tuple(map(float, start))
        take = self._taking(law, start)
        while done < steps:
            rows = [state]
            for k in range(done, done + min(length, steps - done)):
                state = take(state, k)
                rows.append(state)
            yield done, np.array(rows).T
            done, length = done + len(rows) - 1, min(2 * length, 4096)

    def _taking(
        self, law: Law[float], start: State[float]
    ) -> Callable[[Components, int], Components]:
        if self.scheme == "chords":
            path = Ivp().path(law, start, 1e3)
            return lambda state, k: tuple(path.at((k + 1) * self.dt))
        step, rates = SCHEMES[self.scheme][0], law.rates(self.numbers)
        return lambda state, k: step(rates, state, self.dt)


# --- clocks ---------------------------------------------------------------------------------------

# Steps that people choose: round numbers, and the rates of screens and cameras.
ROUND_STEPS = tuple(
    sorted(
        {float(f"{m}e{k}") for m in (1, 1.25, 1.5, 2, 2.5, 3, 4, 5, 6, 8) for k in (-4, -3, -2)}
        | {0.1, 0.2}
        | {1 / n for n in (24, 25, 30, 50, 60, 90, 120, 144, 240, 480, 960)},
        reverse=True,
    )
)

SHORTEST_STEP, LONGEST_STEP = 2e-5, 0.2  # s


def common_step(times: Sequence[float]) -> float | None:
    """Return the largest step of which all times are multiples, s; None if there is none.

    A multiple is met to a millionth of a step.
    """
    distinct = sorted({time for time in times if time > LONGEST_STEP})
    if len(distinct) < 5:
        return None
    known = np.array(distinct[:12])
    counts = np.arange(math.ceil(known[0] / LONGEST_STEP), math.floor(known[0] / SHORTEST_STEP) + 1)
    multiples = known[1:, None] * counts / known[0]
    fits = np.abs(multiples - np.round(multiples)).max(axis=0) < 1e-6 * np.maximum(
        1.0, multiples.max(axis=0) / 1e4
    )
    return float(known[0] / counts[np.argmax(fits)]) if fits.any() else None
