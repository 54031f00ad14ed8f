"""Trial runs that choose the steps of a study: errors must be visible, and above rounding."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from longball.convergence.family import EPSILON
from longball.convergence.studies import first_and_last_event, in_order, observed
from longball.model.scene import Scene, ids_of

# First step, s: about fifty steps in a flight, five in a pitch.
BEGIN = 0.1
# Finest step, s. In at-bats, methods of order 2 need it near the plate and the bat.
FINEST = BEGIN / 512
# Longest run, s, beyond the time of two start-ups: about forty runs follow, most of them shorter.
PATIENCE = 0.4
# Coarsest step, s: a third of a flight. Methods of order 8 show their order only with such steps.
COARSEST = 1.6
# Ratio and number of the chosen steps: four times the ratio that a fit needs (`NARROWEST`).
SPAN, COUNT = 16.0, 9


def chosen_steps(run: Callable[[float], Sequence[Any]], scenes: Sequence[Scene]) -> list[float]:
    """Choose steps, s, the coarsest first, for `longball.convergence.converge`.

    The step is halved while this changes the results by more than rounding. If even the first
    halving does not, the step is doubled instead. The chosen steps end near the finest step with a
    visible change. Methods of high order thus get long steps; for others, the time of a run is the
    limit.
    """
    ids = ids_of(scenes)
    results: dict[float, Sequence[Any]] = {}
    seconds: dict[float, float] = {}

    def is_seen(step: float) -> bool:
        for each in (step, step / 2):
            if each not in results:
                start = time.monotonic()
                results[each] = in_order(run(each), ids)
                seconds[each] = time.monotonic() - start
        coarse, fine = results[step], results[step / 2]
        _, last = first_and_last_event(fine)
        changes = []
        for a, b in zip(observed(coarse, fine), observed(fine, fine), strict=True):
            size = np.max(np.abs(b.values), where=np.isfinite(b.values), initial=0.0)
            change = np.linalg.norm(a.values - b.values, axis=1)
            if size > 0.0 and np.isfinite(change).any():
                changes.append(np.nanmedian(change) / (EPSILON * size * last / step))
        return bool(changes) and float(np.median(changes)) > 1.0

    step = BEGIN
    if is_seen(step):
        while step / 2 >= FINEST and seconds[step / 2] < PATIENCE + 2 * min(seconds.values()):
            if not is_seen(step / 2):
                break
            step /= 2
    else:
        while 4 * step < COARSEST and not is_seen(step):
            step *= 2
        # An exact method shows only rounding, which grows with the number of steps: use short ones.
        step = step if is_seen(step) else BEGIN / SPAN
    longest = min(SPAN * step, COARSEST)
    shortest = min(step, longest * 2 / SPAN)
    return [float(h) for h in np.geomspace(longest, shortest, COUNT)]
