"""What may account for the errors of a stage, and how much of them it leaves.

An explanation is named only if it takes away the errors of every scene in which the stage fails,
and all but a thousandth of their sum. What merely looks alike leaves more: of the mistakes that
were planted, right names left 1e-5 and less, wrong ones 1e-3 and more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

import numpy as np

from longball.judge.any_law import EFFORT
from longball.judge.cases import Case
from longball.judge.stages import (
    ANY_LAW_ERROR,
    FLYING,
    NONE,
    Change,
    Check,
    Numbers,
    Trial,
    Trials,
    follow,
)
from longball.model.arrays import Array

# Of the errors, what a named explanation may leave in all, and in a scene.
NAMED, IN_A_SCENE = 1e-3, 0.05

# The same of a law that jumps. In the step in which a candidate passes the jump, its integrator
# errs by some of what the jump does in that step, and a flight has a hundred steps.
JUMPED = 1e-2

OWN_ERROR = 3e-9  # of a quantity, what flights under laws with forces of any kind err by, mostly
ALIKE = 3.0  # explanations that leave no more than so many times the least cannot be told apart
SCREEN = 0.3  # what leaves more than this of one trial, or of a few, is not held against the others
Checked = tuple[Trial, list[Check]]  # a trial's relative errors with their checks
Seen = Sequence[Checked]


@dataclass(frozen=True)
class Explanation:
    """A way to account for the errors of a stage."""

    name: str
    sentence: str
    remedy: str | None
    left: float = 0.0  # the share of the errors that it leaves; see `share_left`
    rank: float = 0.0  # between equals the lower one is told first
    change: Change | None = None  # what becomes of the chain; None if it is in the quantity alone
    # The quantity that it is in, and what that then is, of a trial.
    quantity: str | None = None
    value: Callable[[Trial], Numbers | None] | None = None
    # What makes a trial right again for all that follows, where neither of these does.
    mend: Callable[[Trial], Trial] | None = None
    against: float = 0.0  # the error that it makes in scenes that pass, in the same unit as `left`
    step: float | None = None  # s, of a scheme or a clock
    allowed: float = NAMED  # what it may leave to be named
    stage: str | None = None  # where the mistake is, if not at the stage whose errors it explains

    @property
    def named(self) -> bool:
        """Whether it leaves next to nothing."""
        return self.left <= self.allowed


def share_left(lefts: Sequence[float], wholes: Sequence[float]) -> float:
    """Return the share of errors that is left, scene by scene; at least that of scenes left."""
    # A scene is explained if little of its error is left, or little beside the usual error.
    errors = [whole for whole in wholes if whole]
    if not errors:
        return 1.0
    little = NAMED * median(errors)
    unexplained = sum(
        left > max(IN_A_SCENE * whole, little) for left, whole in zip(lefts, wholes, strict=True)
    )
    return max(sum(lefts) / sum(errors), min(1.0, unexplained / len(errors)))


def share_by(
    chosen: Iterable[Checked], left: Callable[[Trial, Sequence[Check]], float]
) -> float:  # fmt: skip
    """Return the share of the errors of some trials that a function of each leaves."""
    pairs = [(left(t, checks), sum(map(size_of, checks))) for t, checks in chosen]
    return share_left([one for one, _ in pairs], [whole for _, whole in pairs])


def size_of(check: Check) -> float:
    """Return a check's relative error, none counted for more than 1."""
    return min(check.error / check.scale, 1.0)


def off(value: Sequence[float] | Array | None, check: Check) -> float:
    """Return how far a value is from what a candidate says, relative, and at most 1."""
    if value is None or len(value) != len(check.obtained):
        return size_of(check)
    return min(math.dist(value, check.obtained) / check.scale, 1.0)


def doubt_of(checked: Iterable[Checked]) -> float:
    """Return the share of the errors that rounding may do, and the judge's own flights."""
    failing = [c for _, cs in checked for c in cs if not c.follows]
    own = sum(max(c.tolerance / c.scale, ANY_LAW_ERROR) for c in failing)
    return min(own / sum(map(size_of, failing)), NAMED)


def told_together(sentences: Sequence[str]) -> str:
    """Return sentences of explanations that cannot be told apart as one."""
    first, *others = sentences
    return "; or, which comes to the same here: ".join(
        [first, *(["; or ".join(others)] * bool(others))]
    )


def evenly(items: Sequence[Any], count: int) -> list[Any]:
    """Return so many of some things, evenly chosen."""
    if len(items) <= count:
        return list(items)
    return [items[i * len(items) // count] for i in range(count)]


def duration(case: Case) -> float:
    """Return how long a ball flies in a scene, s."""
    landing = case.expected.landing
    return 0.5 if landing is None else float(landing.time)


class Work:
    """What a search has done: so many flights, or what takes as long."""

    done = 0.0  # flights

    def __init__(self) -> None:
        EFFORT.forget()
        self._begun = EFFORT.steps

    @property
    def exhausted(self) -> bool:
        """Whether the search for laws has done all that it may."""
        return self.done > PATIENCE or self._steps > LAWS_EFFORT

    @property
    def spent(self) -> bool:
        """Whether its flights have taken very many steps: more than leave time for schemes."""
        return self._steps > MOST_EFFORT

    @property
    def _steps(self) -> float:
        return EFFORT.steps - self._begun

    def checks(self, trial: Trial, change: Change, stages: Iterable[str]) -> list[Check]:
        """Return what follows in some stages, and on the way to them, under a change."""
        wanted, step = frozenset(stages), getattr(change.engine, "dt", LONG_STEP)
        flown = duration(trial.case) * LONG_STEP / step
        self.done += 0.2 if wanted.isdisjoint(FLYING) else flown
        return follow(trial, change, wanted)


PATIENCE = 4_000.0  # flights of a search, which end within ten seconds: the same on every machine
# Steps of DOP853, for laws, and for schemes after them: a law that drives the ball on takes many.
LAWS_EFFORT, MOST_EFFORT = 16_000, 26_000
LONG_STEP = 5e-3  # s: with such steps a second of flight takes as long as a flight under any law


class Sought:
    """Trials that an explanation is sought in, and what changes leave of their errors."""

    # Trials that fail, and some that do not: nothing may be explained that is not there. Of the
    # stages whose errors are looked at the first is the one to be explained.
    def __init__(
        self, trials: Trials, beside: Trials, stages: tuple[str, ...],
        base: Change, work: Work
    ) -> None:  # fmt: skip
        self.trials, self.beside = list(trials), list(beside)
        self.stages, self.base, self.work = stages, base, work
        self.stage = stages[0]
        self._known: dict[tuple[int, Change], Array] = {}
        self._quantities: dict[int, frozenset[str]] = {}  # by the trial's identity
        self._slips: dict[int, Array] = {}  # what few digits may do to each number of a row

    def rows(self, change: Change) -> list[Array]:
        """Return the relative errors that a change leaves in each trial."""
        full = self.base if change is NONE else self.base.then(change)
        for trial in (*self.trials, *self.beside):
            if (id(trial), change) not in self._known:
                self._known[id(trial), change] = self.errors(trial, full)
        return [self._known[id(trial), change] for trial in (*self.trials, *self.beside)]

    def errors(self, trial: Trial, full: Change) -> Array:
        """Return the relative errors of a trial under a chain."""
        # Of the quantities that are of the stages under the base: another chain may move some.
        if id(trial) not in self._quantities:
            known = [c for c in follow(trial, self.base, self.stages) if c.stage in self.stages]
            self._quantities[id(trial)] = frozenset(c.quantity for c in known)
            if trial.coarse:
                slips = [c.tolerance / c.scale for c in known for _ in c.expected]
                self._slips[id(trial)] = np.array(slips)
        checks = self.work.checks(trial, full, self.stages)
        here = self._quantities[id(trial)]
        errors = np.array([(o - e) / c.scale for c in checks if c.quantity in here
                           for e, o in zip(c.expected, c.obtained, strict=True)])  # fmt: skip
        return np.where(np.isfinite(errors), errors, 1.0)

    def concerned(self, change: Change) -> bool:
        """Tell whether a change may do anything to the trials: what is done to scenes is cheap."""
        if replace(change, scene=NONE.scene) != NONE:
            return True
        scenes = (self.base.scene(t.scene) for t in self.trials)
        pairs = ((scene, change.scene(scene)) for scene in scenes)
        return any(made is not scene and made != scene for scene, made in pairs)

    def given(self, change: Change) -> Sought:
        """Return what is sought when a change explains a part."""
        base, first = self.base.then(change), self.rows(NONE)
        rest = Sought(self.trials, self.beside, self.stages, base, self.work)
        rest.trials = [
            t for t, r, f in zip(self.trials, rest.rows(NONE), first, strict=False)
            if np.abs(r).sum() > NAMED * np.abs(f).sum()
        ]  # fmt: skip
        return rest

    def sizes(self, change: Change) -> list[float]:
        """Return the errors that a change leaves in each trial, at most 1, then in those beside."""
        rows = zip((*self.trials, *self.beside), self.rows(change), self.rows(NONE), strict=True)
        return [
            float(np.clip(np.abs(r) - self._slips.get(id(t), 0.0), 0.0, 1.0).sum())
            if r.shape == f.shape else float(f.size)
            for t, r, f in rows
        ]  # fmt: skip

    def screened(self, change: Change) -> float | None:
        """Return what a change leaves; of a few trials only, if it leaves much of them."""
        for some in (self.some(1), self.some(3), self):
            left = some.left(change)
            if left is None or left > SCREEN:
                break
        return left

    def split(self, e: Explanation) -> Explanation:
        """Return an explanation with what it does to trials beside it apart from what it leaves."""
        if e.named or not self.beside or e.change is None:
            return e
        left = self.of(self.trials).screened(e.change)
        return e if left is None else replace(e, left=left, against=max(0.0, e.left - left))

    def some(self, count: int) -> Sought:
        """Return a few of the trials, the shortest flights first."""
        short = sorted(self.trials, key=lambda t: duration(t.case))
        return self.of(evenly(short[: 2 * count], count))

    def of(self, trials: Trials) -> Sought:
        """Return the same, sought in some of the trials."""
        few = Sought(trials, (), self.stages, self.base, self.work)
        few._known, few._quantities, few._slips = self._known, self._quantities, self._slips
        return few

    def residual(self, change: Change = NONE) -> Array | None:
        """Return all relative errors that a change leaves, in one row; None if it has none."""
        rows, first = self.rows(change), self.rows(NONE)
        if not rows or any(r.shape != f.shape for r, f in zip(rows, first, strict=True)):
            return None
        return np.concatenate(rows)

    def left(self, change: Change) -> float | None:
        """Return the share of the error that a change leaves, none counted for more than 1."""
        wholes = self.sizes(NONE)
        lefts = [max(0.0, left - min(OWN_ERROR, JUMPED * whole))
                 for left, whole in zip(self.sizes(change), wholes, strict=True)]  # fmt: skip
        wholes[len(self.trials) :] = [0.0] * len(self.beside)
        return share_left(lefts, wholes) if any(wholes) else None
