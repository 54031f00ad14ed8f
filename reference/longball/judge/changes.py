"""Explanations that are changes of the chain: known mistakes, fitted numbers, two at once."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from longball.engines.verlet import Verlet
from longball.judge.explanations import JUMPED, NAMED, Array, Explanation, Sought
from longball.judge.fits import PARAMETERS, Fit, fits, snapped
from longball.judge.mistakes import FENCE, IMPACT, LAW, READINGS, SPIN, TWO_STEP_PUSH, Mistake
from longball.judge.stages import NONE, Change

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
        (forms,) = fits(sought.trials, [name], sought.stages, sought.base, sought.work)
        for fit in forms:
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
    base = few.rows(NONE)
    if not sum(map(len, base)) or sought.work.exhausted:
        return
    columns: list[tuple[Explanation | str, list[Array]]] = []
    for e in known:
        effect = None if e.change is None else _effect(few, e.change)
        if effect and sum(np.abs(x).sum() for x in effect) > 1e-9:
            columns.append((e, effect))
    columns += _slopes(stage, few)
    ranked = []
    for (a, ea), (b, eb) in itertools.combinations(columns, 2):
        left = 0.0
        for rest, *effects in zip(base, ea, eb, strict=True):
            # A number that is the same in all scenes is another part of each scene's own.
            free = []
            for name, does in zip((a, b), effects, strict=True):
                if isinstance(name, str):
                    free.append(does)
                else:
                    rest = rest - does
            if free:
                matrix = np.array(free).T
                rest = rest - matrix @ np.linalg.lstsq(matrix, rest, rcond=None)[0]
            left += float(np.abs(rest).sum())
        ranked.append((left, a, b))
    ranked.sort(key=lambda one: one[0])
    for _, a, b in ranked[:4]:
        if not sought.work.exhausted and (joined := _joined(sought, stage, a, b)):
            yield joined


def _effect(few: Sought, change: Change) -> list[Array] | None:
    """Return what a change does to the errors of each trial, if it leaves the same quantities."""
    pairs = list(zip(few.rows(NONE), few.rows(change), strict=True))
    return [a - b for a, b in pairs] if all(a.shape == b.shape for a, b in pairs) else None


def _slopes(stage: str, few: Sought) -> Iterator[tuple[str, list[Array]]]:
    """Yield what a small part more of each parameter does."""
    for name, stages in PARAMETERS.items():
        if stage in stages:
            effect = _effect(few, Fit(name, "factor", 1.0 + 1e-5, 0.0, True).change)
            if effect and sum(np.abs(x).sum() for x in effect) > 1e-12:
                yield name, [x / 1e-5 for x in effect]


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
    if free:
        forms = fits(sought.trials, free, (stage,), sought.base.then(own), sought.work)
        tried = [
            (left, some)
            for some in itertools.product(*forms)
            if (left := sought.left(_together(own, some))) is not None
        ]
        if not tried:
            return None
        fitted = list(min(tried, key=lambda one: one[0])[1])
    own = _together(own, fitted)
    left = sought.left(own)
    if left is None or any(f.roundness >= ODD / 100 for f in fitted):
        return None
    both: list[Explanation | Fit] = [*fixed, *fitted]
    name, sentence = " and ".join(x.name for x in both), "; and ".join(x.sentence for x in both)
    return Explanation(name, sentence, None, left, 1.9, own)


def _together(change: Change, fitted: Iterable[Fit]) -> Change:
    for f in fitted:
        change = change.then(f.change)
    return change
