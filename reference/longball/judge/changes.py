"""Explanations that are changes of the chain: known mistakes, fitted numbers, two at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from longball.engines.verlet import Verlet
from longball.judge.explanations import JUMPED, NAMED, Array, Explanation, Sought
from longball.judge.fits import PARAMETERS, Fit, fits, snapped
from longball.judge.mistakes import FENCE, IMPACT, LAW, READINGS, SPIN, TWO_STEP_PUSH, Mistake
from longball.judge.stages import NONE

# A usual number may leave so much more than the fitted one.
SNAP = 1e-4

# Digits of a number that nobody chooses, of two that are fitted at once.
ODD = 5


def parts(stage: str, sought: Sought) -> list[Explanation]:
    """Return known mistakes and fitted numbers, with what they leave of a stage's errors."""
    if stage == "flight" and type(sought.base.engine) is Verlet and not sought.base.push:
        push = list(_tried([TWO_STEP_PUSH], sought))
        if any(e.named for e in push):
            return push
    library: list[Mistake] = []
    if stage in ("pitch", "flight", "spin decay"):
        library += LAW
    if stage == "fence":
        library += FENCE
    if stage in ("impulse", "velocity after", "spin after", "energy"):
        library += (*IMPACT, *SPIN)
    if stage not in ("pitch", "plate", "touching", "normal", "bat velocity"):
        library += READINGS
    found = [*_tried(library, sought), *_fitted(stage, sought)]
    if any(e.named for e in found):
        return found
    return [*found, *_scaled(stage, library, sought)]


def _tried(library: Iterable[Mistake], sought: Sought) -> Iterator[Explanation]:
    for mistake in library:
        if sought.work.exhausted:
            return
        left = sought.screened(mistake.change)
        if left is not None:
            yield _explanation(mistake, left)


def _explanation(mistake: Mistake, left: float) -> Explanation:
    return Explanation(
        mistake.name, mistake.sentence, mistake.remedy, left, 1, mistake.change,
        allowed=JUMPED if mistake.switches else NAMED,
    )  # fmt: skip


def _scaled(stage: str, library: Iterable[Mistake], sought: Sought) -> Iterator[Explanation]:
    """Yield mistakes that have a number of their own, such as the speed that V² is made with."""
    for mistake in library:
        if mistake.scaled and not sought.work.exhausted:
            one = _explanation(mistake, 1.0)
            if joined := _joined(sought, stage, one, mistake.scaled):
                yield joined


def _fitted(stage: str, sought: Sought) -> Iterator[Explanation]:
    """Yield what numbers the candidate acts as if it had."""
    whole_chain = stage == "flight" and any(
        t.scene.kind == "at-bat" and "impact.velocity" not in t.given for t in sought.trials
    )
    for name, stages in PARAMETERS.items():
        if (stage not in stages and not whole_chain) or sought.work.exhausted:
            continue
        for fit in fits(sought.trials, name, sought.stages, sought.base, sought.work):
            left = sought.screened(fit.change)
            if left is None or fit.doubt > 1e-2 * max(abs(fit.value), 1e-6):
                continue
            # What is left may be another mistake, which has moved the number a little.
            for usual in snapped(fit):
                there = sought.left(usual.change)
                if there is not None and there < left + SNAP:
                    fit, left = usual, there
            yield Explanation(
                fit.name, fit.sentence, f"take the scene's {fit.parameter}", left,
                2 + fit.roundness, fit.change,
            )  # fmt: skip


# --- two at once ----------------------------------------------------------------------------------


def pairs(stage: str, sought: Sought, known: Sequence[Explanation]) -> Iterator[Explanation]:
    """Yield two of the known mistakes and fitted numbers together.

    Small effects add up: which two it may be is seen in a few trials, from what each does alone.
    """
    few = sought.few
    base = few.residual()
    if base is None or sought.work.exhausted:
        return
    columns: list[tuple[Explanation | str, Array]] = []
    for e in known:
        r = None if e.change is None else few.residual(e.change)
        if r is not None and np.abs(base - r).sum() > 1e-9:
            columns.append((e, base - r))
    columns += _slopes(stage, few, base)
    ranked = []
    for (a, ea), (b, eb) in itertools.combinations(columns, 2):
        free = [x for x, n in ((ea, a), (eb, b)) if isinstance(n, str)]
        fixed: Any = sum((x for x, n in ((ea, a), (eb, b)) if not isinstance(n, str)), 0.0)
        rest = base - fixed
        if free:
            matrix = np.array(free).T
            amounts = np.linalg.lstsq(matrix, rest, rcond=None)[0]
            rest = rest - matrix @ amounts
        ranked.append((float(np.abs(rest).sum()), a, b))
    ranked.sort(key=lambda one: one[0])
    for _, a, b in ranked[:4]:
        if not sought.work.exhausted and (joined := _joined(sought, stage, a, b)):
            yield joined


def _slopes(stage: str, sought: Sought, base: Array) -> Iterator[tuple[str, Array]]:
    """Yield what a small part more of each parameter does."""
    for name, stages in PARAMETERS.items():
        if stage in stages:
            r = sought.residual(Fit(name, "factor", 1.0 + 1e-5, 0.0, True).change)
            if r is not None and np.abs(base - r).sum() > 1e-12:
                yield name, (base - r) / 1e-5


def _joined(
    sought: Sought, stage: str, a: Explanation | str, b: Explanation | str
) -> Explanation | None:
    """Return two explanations as one, the fitted numbers fitted together."""
    fixed = [x for x in (a, b) if not isinstance(x, str)]
    free = [x for x in (a, b) if isinstance(x, str)]
    own = NONE
    for x in fixed:
        assert x.change is not None
        own = own.then(x.change)
    fitted: list[Fit] = []
    # Each in turn, with the others as they are: two numbers settle in a few rounds.
    for _ in range(6 if len(free) > 1 else 1):
        for name in free:
            others = [f for f in fitted if f.parameter != name]
            around = own
            for f in others:
                around = around.then(f.change)
            forms = fits(sought.trials, name, (stage,), sought.base.then(around), sought.work)
            scored = [(sought.left(around.then(f.change)), f) for f in forms]
            good = [(left, f) for left, f in scored if left is not None]
            if not good:
                return None
            fitted = [*others, min(good, key=lambda one: one[0])[1]]
    for f in fitted:
        own = own.then(f.change)
    left = sought.left(own)
    if left is None or any(f.roundness >= ODD / 100 for f in fitted):
        return None
    both: list[Explanation | Fit] = [*fixed, *fitted]
    name, sentence = " and ".join(x.name for x in both), "; and ".join(x.sentence for x in both)
    return Explanation(name, sentence, None, left, 1.9, own)
