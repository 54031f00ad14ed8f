"""A few runs that choose the steps of a study: where errors are seen, and not yet rounding."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from longball.convergence.family import EPSILON
from longball.convergence.studies import first_and_last_event, in_order, observed
from longball.model.scene import Scene, ids_of

BEGIN = 0.1  # s: some fifty steps a flight, five a pitch
FINEST = BEGIN / 512  # s: at-bats by methods of order 2 need it where plates and bats are
# s that a run may take longer than start-ups do: some forty runs follow, most of them shorter.
PATIENCE = 0.4
COARSEST = 1.6  # s: a third of a flight, which methods of order 8 need to show it
SPAN, COUNT = 16.0, 9  # of the steps chosen: twice the factor that a fit needs on either side


def chosen_steps(run: Callable[[float], Sequence[Any]], scenes: Sequence[Scene]) -> list[float]:
    """Choose steps, s, the coarsest first, for `longball.convergence.converge`.

    The step is halved as long as that changes the results by more than rounding may; if it does
    not from the beginning, it is doubled. The finest step whose change is seen is the finest of
    those chosen, or less by a half: methods of high order get long steps, and others
    those that do not take long.
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
        # A method that is exact shows its rounding, which adds up in many steps.
        step = step if is_seen(step) else BEGIN / SPAN
    longest = min(SPAN * step, COARSEST)
    shortest = min(step, longest * 2 / SPAN)
    return [float(h) for h in np.geomspace(longest, shortest, COUNT)]
