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

# Trials that schemes are tried in, and schemes that are tried with the step that fits them best.
FEW, BEST = 3, 6

# Round steps are tried that differ from a fitted one by less than this factor.
NEAR = 1.5

# A round step may leave so many times what the one leaves that fits best.
ALMOST = 1.1

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
        treatment = SCHEMES[self.name].treatment
        if self.ends == "line" and treatment is not None:
            return Change(engine=Verlet(dt=dt, forces=treatment))
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
    few = sought.some(FEW)
    base = few.residual()
    if base is None:
        return
    ranked = []
    for way in (_Way(name, ends) for name in SCHEMES for ends in get_args(Ends)):
        if sought.work.spent:
            return
        dt = known or _scaled(few, base, way, FIRST)
        if not dt or dt < SHORTEST / NEAR or (way.ends == "line" and dt < FINE_STEP):
            continue  # with such steps, the line between two of them is the path
        # Where the step is shorter than those tried, the error follows from the order.
        share, steps = min(1.0, (dt / FINE_STEP) ** way.order), [max(dt, FINE_STEP)]
        if way.ends == "line" and not known:  # what is between two steps hangs on the step itself
            steps = [step for step in _round(dt, 3) if step >= FINE_STEP] or steps
        for step in steps:
            r = few.residual(way.change(step))
            if r is not None:
                rest = float(np.abs(base - share * (base - r)).sum())
                ranked.append((rest, way, dt if dt < FINE_STEP else step))
    for _, way, dt in sorted(ranked, key=lambda one: one[0])[:BEST]:
        if sought.work.spent:
            return
        fitted = known or _fitted(few, base, way, dt)
        change = way.change(fitted)
        left = sought.screened(change) if fitted > LONG else sought.some(2).left(change)
        if left is not None:
            yield way.explanation(fitted, left)


def _scaled(few: Sought, base: Array, way: _Way, dt: float) -> float | None:
    """Return the step with which a scheme errs as much as the candidate, seen from another step."""
    r = few.residual(way.change(dt))
    effect = 0.0 if r is None else base - r
    size = float(np.sum(effect * effect))
    amount = float(np.sum(base * effect)) / size if size else 0.0
    return min(dt * amount ** (1 / way.order), LONGEST) if amount > 0 else None


def _fitted(few: Sought, base: Array, way: _Way, dt: float) -> float:
    """Return the step that a scheme fits best with: a round one, if one is near."""
    if dt < FINE_STEP:
        dt = _scaled(few, base, way, FINE_STEP) or dt
        return max((*_round(dt, 1), SHORTEST)[0], SHORTEST)
    steps = [dt]
    for _ in range(3):
        new = _scaled(few, base, way, steps[-1])
        if new is None or new < FINE_STEP:
            break
        steps.append(new)
        if _far(new, steps[-2]) < 1e-4:
            break
    steps += [step for step in _round(steps[-1], 4) if step >= FINE_STEP]

    def left(step: float) -> float:
        r = few.residual(way.change(step))
        return math.inf if r is None else float(np.abs(r).sum())

    # People choose round steps; another mistake may have moved the one that fits best.
    lefts = {step: left(step) for step in steps}
    best = min(lefts, key=lambda step: lefts[step])
    near = [step for step in _round(best, 4) if lefts.get(step, math.inf) <= ALMOST * lefts[best]]
    return near[0] if near else best


def _round(dt: float, count: int) -> list[float]:
    """Return the round steps that are nearest, and near."""
    near = [step for step in ROUND_STEPS if _far(step, dt) < math.log(NEAR)]
    return sorted(near, key=partial(_far, dt))[:count]


def _far(a: float, b: float) -> float:
    return abs(math.log(a / b))
