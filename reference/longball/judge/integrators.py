"""Which scheme in fixed steps a candidate flies by, and with which step.

The errors of a scheme of order p go with the p-th power of its step, so that one trial of each
tells which step fits best and how well; the best few are then tried with theirs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from longball.engines.verlet import Verlet
from longball.judge.explanations import Explanation, Sought
from longball.judge.stages import Change
from longball.judge.steps import (
    LAGGING,
    PAPERS,
    ROUND_STEPS,
    SCHEMES,
    SHORTEST,
    Ends,
    FixedStep,
)

Array = NDArray[np.float64]

# s: the step of the first trial of each scheme, and the shortest one that is tried with others to
# find the one that fits; what is shorter follows from the order.
FIRST, FINE_STEP, LONGEST = 0.01, 1e-3, 0.2

# Schemes that are tried with the step that fits them best.
BEST = 4

# With steps longer than this, s, what a scheme leaves is seen in all trials, and not in a few.
LONG = 2e-3

_SHORTER = "take shorter steps, or a method of higher order"
_REMEDY = (
    "predict the velocity at the step's end, v + aΔt, or iterate, before asking for the force "
    "there: the error then falls with Δt² instead of Δt"
)


@dataclass(frozen=True)
class _Way:
    """A scheme, and how it comes to its events."""

    name: str
    ends: Ends

    @property
    def order(self) -> int:
        return SCHEMES[self.name].order

    def change(self, dt: float) -> Change:
        """Return the chain that flies so."""
        if self.ends == "line" and self.name in PAPERS:
            return Change(engine=Verlet(dt=dt, forces=PAPERS[self.name]))  # type: ignore[arg-type]
        return Change(engine=FixedStep(dt=dt, scheme=self.name, ends=self.ends))

    def explanation(self, dt: float, left: float) -> Explanation:
        """Return it as an explanation."""
        end = ", each event on the line between two of them" if self.ends == "line" else ""
        return Explanation(
            self.name, f"flies by {SCHEMES[self.name].words}, in steps of {dt:.4g} s{end}",
            _REMEDY if self.name in LAGGING else _SHORTER, left, 1, self.change(dt), step=dt,
        )  # fmt: skip


def schemes(sought: Sought, known: float | None) -> Iterator[Explanation]:
    """Yield schemes with the step that fits best; `known` is the candidate's, s, if it is known."""
    few = sought.some(4)
    base = few.residual()
    if base is None:
        return
    first = max(known or FIRST, FINE_STEP)
    ranked = []
    for name in SCHEMES:
        way = _Way(name, "step")
        r = few.residual(way.change(first))
        if r is None:
            continue
        amount = (known / first) ** way.order if known else _amount(base, base - r)
        if amount > 0:
            ranked.append((float(np.abs(base - amount * (base - r)).sum()), name))
    ranked.sort()
    for way in (_Way(name, ends) for ends in get_args(Ends) for _, name in ranked[:BEST]):
        dt = known or _step(few, base, way)
        change = way.change(dt)
        left = sought.screened(change) if dt > LONG else sought.some(2).left(change)
        if left is not None:
            yield way.explanation(dt, left)


def _step(few: Sought, base: Array, way: _Way) -> float:
    """Return the step that a scheme fits best with: a round one, if one is near."""
    tried: dict[float, float] = {}

    def left(dt: float) -> tuple[float, Array | None]:
        r = few.residual(way.change(dt))
        tried[dt] = math.inf if r is None else float(np.abs(r).sum())
        return tried[dt], r

    dt = FIRST
    for _ in range(4):
        _, r = left(dt)
        amount = 0.0 if r is None else _amount(base, base - r)
        if amount <= 0:
            break
        new = min(dt * amount ** (1 / way.order), LONGEST)
        if new < FINE_STEP:
            if dt > FINE_STEP:
                dt = FINE_STEP
                continue
            return max(min(ROUND_STEPS, key=partial(_far, new)), SHORTEST)
        if abs(new / dt - 1) < 1e-4:
            break
        dt = new
    best = min(tried, key=lambda h: tried[h])
    for near in sorted(ROUND_STEPS, key=partial(_far, best))[:4]:
        if near >= FINE_STEP and _far(best, near) < math.log(1.5):
            left(near)
    return min(tried, key=lambda h: tried[h])


def _far(a: float, b: float) -> float:
    return abs(math.log(a / b))


def _amount(errors: Array, effect: Array) -> float:
    """Return how many times an effect explains errors best."""
    size = float(effect @ effect)
    return float(errors @ effect) / size if size else 0.0
