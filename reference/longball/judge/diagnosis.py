"""What is wrong with a candidate: where first, by how much, in which scenes, and probably why.

Stage by stage (`longball.judge.stages`), in the order in which a scene goes through them. A stage
that does not follow from the candidate's own earlier values is explained by the first of these that
leaves least: a constant ratio or exchange, a known mistake, a fitted number, a scheme in steps. The
explanation is then part of the chain that later stages are computed with, so that one mistake does
not show twice and two do not hide each other. What is left is told, with its size.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import cached_property, partial
from statistics import median
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from longball.convergence.report import Frozen
from longball.engines.chain import solve
from longball.engines.verlet import Verlet
from longball.judge.answers import Answer
from longball.judge.cases import Case, decidable
from longball.judge.fits import (
    PARAMETERS,
    Fit,
    Work,
    factor_meaning,
    fits,
    snapped,
    told,
)
from longball.judge.mistakes import (
    FENCE,
    FORMULAS,
    IMPACT,
    LAW,
    OUTCOMES,
    READINGS,
    SPIN,
    TWO_STEP_PUSH,
    Mistake,
    View,
)
from longball.judge.quantities import told_by, untrue
from longball.judge.rules import rule
from longball.judge.stages import (
    NONE,
    STAGE_OF,
    STAGES,
    Change,
    Check,
    Numbers,
    Placed,
    Trial,
    follow,
    followed,
    placed,
    trial_of,
    view_values,
)
from longball.judge.steps import ROUND_STEPS, SCHEMES, FixedStep, common_step
from longball.model.readings import Reading
from longball.model.result import Result

Array = NDArray[np.float64]

# An explanation is named if it takes away this share of a stage's error, and probable from the
# second on; what merely looks alike leaves more.
NAMED, PROBABLE = 0.95, 0.5

# Explanations that leave the same, to this share of the error, cannot be told apart.
TIE = 1e-4

# Scenes that an explanation is sought in, failing and passing ones; it is then held against all.
SOUGHT, BESIDE = 10, 4

# A usual number may leave so much more than the fitted one.
SNAP = 0.01

# What leaves more than this of a few trials is not held against the others.
SCREEN = 0.8

# Flights of a search, so that a verdict is the same on every machine and comes within ten seconds;
# what has not been tried by then is not.
PATIENCE = 2_500.0

# Errors below this, relative, are an integrator's: no mistake of the physics is sought.
FINE = 1e-7

# Of the largest relative error of any stage: a stage below it is not where the trouble begins.
MINOR = 1e-3

# Steps of all flights together that are followed with a scheme.
MOST_STEPS = 50_000

Kind = Literal["named", "probably", "unexplained"]


class Finding(Frozen):
    """Something that is wrong at a stage."""

    stage: str
    quantity: str
    kind: Kind
    names: list[str] = Field(description="of the explanation, then of those that do as well")
    sentence: str
    remedy: str | None = None
    share: float = Field(description="of the stage's error that this explains")
    step: float | None = Field(default=None, description="s, of a scheme")
    wrong: int = Field(description="scenes in which the stage does not follow")
    checked: int
    worst: float = Field(description="largest relative error")
    scenes: str | None = Field(default=None, description="a rule that tells the wrong scenes")


class StageRow(Frozen):
    """How often a stage follows from the stages before."""

    stage: str
    checked: int
    wrong: int
    worst: float = Field(description="largest error relative to its quantity")
    example: str | None = Field(description="id of the scene with the largest error")


class Diagnosis(Frozen):
    """What is wrong, stage by stage."""

    sentence: str
    first: str | None = Field(description="the first stage with errors that matter")
    stages: list[StageRow]
    clean: list[str] = Field(description="stages that follow in every scene")
    findings: list[Finding]
    conduct: list[str] = Field(default=[], description="what a second run told")
    smallest: dict[str, Any] | None = Field(
        default=None, description="a scene with as little in it as still fails"
    )

    @property
    def named(self) -> list[str]:
        """Return the names of what is named, the ties behind each."""
        return [name for f in self.findings if f.kind == "named" for name in f.names]


@dataclass(frozen=True)
class Explanation:
    """A way to account for the errors of a stage.

    Attributes
    ----------
    rank
        Between equals the lower one is preferred.
    change
        What becomes of the chain; None if it is in the quantity alone.
    value
        What the quantity then is, of a trial; None if it is a change of the chain.
    mend
        What makes a trial right again for all that follows, where neither of these does.
    against
        The error that it makes in scenes that pass, in the same unit as `left`.
    """

    name: str
    sentence: str
    remedy: str | None
    left: float
    rank: float
    change: Change | None = None
    quantity: str | None = None
    value: Callable[[Trial], Numbers | None] | None = None
    step: float | None = None
    doubtful: bool = False
    mend: Callable[[Trial], Trial] | None = None
    against: float = 0.0


def diagnose(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    dt: float | None = None,
    scheme: Verlet | None = None,
) -> Diagnosis:
    """Return what is wrong with a candidate's answers.

    Parameters
    ----------
    cases
        That it was judged by.
    answers
        By the scene's id.
    dt
        s, its time step, if it is known.
    scheme
        What counts as true, if that is the paper's scheme.
    """
    trials = [
        trial_of(case, answer)
        for case in cases
        if decidable(case) and (answer := answers.get(case.id)) and answer.error is None
    ]
    search = _Search(trials, dt, scheme)
    search.single = _in_single_precision(answers.values())
    search.unread = sum(bool(answer.unreadable) for answer in answers.values())
    return search.diagnosis()


class _Search:
    """The search for what explains one candidate's errors."""

    def __init__(
        self, trials: Sequence[Trial], dt: float | None, scheme: Verlet | None = None
    ) -> None:
        self.single, self.unread = False, 0
        self.confused = [t for t in trials if t.outcome not in (None, t.case.expected.outcome)]
        self.trials = [t for t in trials if t.outcome in (None, t.case.expected.outcome)]
        self.dt = dt
        self.base = NONE if scheme is None else Change(engine=scheme, push=True)
        self.scheme = scheme
        self.findings: list[Finding] = []
        self.loose: dict[str, float] = {}
        self.work = Work()
        self.excused: set[str] = set()  # quantities whose errors are explained
        self._followed: tuple[Any, list[tuple[Trial, list[Check]]]] = (None, [])

    def diagnosis(self) -> Diagnosis:
        checks = self._follow()
        rows = [row for stage in STAGES if (row := _row(stage, checks))]
        largest = max((r.worst for r in rows), default=0.0)
        first = next((r.stage for r in rows if r.wrong and r.worst >= MINOR * largest), None)
        for stage in STAGES:
            for _ in range(3):
                checks = self._follow()
                if not self._explain(stage, checks):
                    break
        if self.confused:
            self._outcomes()
        self._told()
        clean = [r.stage for r in rows if not r.wrong]
        self.findings.sort(key=lambda f: f.worst < MINOR * largest)
        return Diagnosis(
            sentence=self._sentence(first, clean),
            first=first,
            stages=rows,
            clean=clean,
            findings=self.findings,
        )

    def _sentence(self, first: str | None, clean: Sequence[str]) -> str:
        """Return it all in a sentence."""
        unread = ""
        if self.unread:
            unread = f"{self.unread} answers hold values that are no numbers"
        if not self.findings:
            if not clean:
                return unread or "nothing is answered that could be followed"
            if unread:
                return f"{unread}; what could be read follows from what comes before it"
            return "every stage follows from the stages before it, in every scene"
        lead = self.findings[0]
        parts = [unread] if unread else []
        if first is not None:
            where = "all" if lead.wrong == lead.checked else f"{lead.wrong} of {lead.checked}"
            parts.append(
                f"the first stage that does not follow is {first}: wrong in {where} scenes"
            )
        parts += [f.sentence for f in self.findings if f.worst >= MINOR * lead.worst][:3]
        return "; ".join(parts)

    @property
    def impatient(self) -> bool:
        """Whether the search has done all that it may."""
        return self.work.done > PATIENCE

    # --- following ------------------------------------------------------------------------------

    def _follow(self) -> list[tuple[Trial, list[Check]]]:
        """Return what follows in every trial under the chain as far as it is explained."""
        if self._followed[0] is not self.trials:
            found = [
                (t, followed(t) if self.base is NONE else follow(t, self.base)) for t in self.trials
            ]
            self._followed = (
                self.trials,
                [
                    (
                        t,
                        [
                            self._inheriting(t, c)
                            for c in cs
                            if not {c.quantity, c.stage} & self.excused
                        ],
                    )
                    for t, cs in found
                ],
            )
        return self._followed[1]

    def _inheriting(self, trial: Trial, check: Check) -> Check:
        """Return a check that allows for what an earlier stage has left unexplained."""
        left = self.loose.get(trial.case.id, 0.0)
        if not left or check.stage not in ("touching", "normal speed", "velocity after"):
            return check
        return replace(check, tolerance=check.tolerance + 30 * left * max(check.scale, 0.1))

    def _explain(self, stage: str, checks: Sequence[tuple[Trial, list[Check]]]) -> bool:
        """Explain what does not follow at a stage; tell whether there may be more."""
        seen = [(t, [c for c in cs if c.stage == stage]) for t, cs in checks]
        sizes = [
            max((c.error / c.scale for c in cs if not c.follows), default=0.0) for _, cs in seen
        ]
        worst = max(sizes, default=0.0)
        if not worst:
            return False
        # Beside large errors small ones are another matter.
        wrong = [one for one, size in zip(seen, sizes, strict=True) if size > MINOR * worst]
        good = [
            one for one, size in zip(seen, sizes, strict=True) if one[1] and size <= MINOR * worst
        ]
        right = [t for t, _ in good]
        before = [f for f in self.findings if f.stage == stage]
        if before and worst < MINOR * before[0].worst and len(before) > 1:
            self._leave(stage, wrong)
            return False
        failing = [t for t, _ in wrong]
        scenes = rule([t.case for t in failing], [t.case for t in right])
        found: list[Explanation] = []
        if self.single and worst < SINGLE_NOISE:
            found = [SINGLE]
        elif worst > FINE:
            # A formula must not be contradicted by scenes that pass: but a part of it may be, if a
            # rule tells them, and it explains the others.
            beside = _evenly([o for o in good if o[0].scene.reading == Reading()], SOUGHT)
            found = self._sorted_explanations(stage, wrong, right, beside, checks)
            for i, e in enumerate(found):
                if not (scenes and e.left < 1 - NAMED):
                    found[i] = replace(e, left=e.left + e.against)
            found.sort(key=_order)
        found = [e for e in found if e.left < 1 - PROBABLE and self._likely(e, before)]
        quantity = max(
            (c for _, cs in wrong for c in cs), key=lambda c: c.error / c.scale
        ).quantity.partition(":")[0]
        common = {
            "stage": stage,
            "quantity": quantity,
            "wrong": len(wrong),
            "checked": len(wrong) + len(right),
            "worst": worst,
            "scenes": scenes,
        }
        if not found:
            self.findings.append(
                Finding(
                    kind="unexplained",
                    names=[],
                    share=0.0,
                    sentence=self._unknown(stage, wrong, worst, bool(before)),
                    **common,
                )
            )
            self._leave(stage, wrong)
            return False
        same = [e for e in found if e.left < max(TIE, found[0].left + TIE)][:6]
        broken = [self._breaks(e, stage) for e in same]
        same = [e for e, n in zip(same, broken, strict=True) if n == min(broken)]
        best = same[0]
        # Numbers that come to the same are told, whichever is rounder.
        ties = [
            e for e in same[1:]
            if e.name != best.name and (e.rank <= best.rank + 0.01 or min(e.rank, best.rank) >= 2)
        ][:3]  # fmt: skip
        sentence = best.sentence
        if ties:
            sentence += "; or, which comes to the same here: " + "; or ".join(
                e.sentence for e in ties
            )
        alone = min(broken) > 0
        named = 1 - best.left >= NAMED and not best.doubtful
        self.findings.append(
            Finding(
                kind="named" if named else "probably",
                names=list(dict.fromkeys([best.name, *(e.name for e in ties)])),
                sentence=f"{stage} alone: {sentence}" if alone else sentence,
                remedy=best.remedy,
                share=1 - best.left,
                step=best.step,
                **common,
            )
        )
        if not named:
            self._leave(stage, wrong)
            return False
        if alone:
            self.excused.add(stage)
            self._followed = (None, [])
        else:
            self._accept(best)
        return True

    def _likely(self, e: Explanation, before: Sequence[Finding]) -> bool:
        """Tell whether an explanation is one that people would give.

        A number that nobody would choose is none for a part of the errors, or for what another
        explanation has left; and no number is one that differs from scene to scene.
        """
        if e.doubtful:
            return False
        odd = e.rank >= 2 + ODD / 100 or e.rank == RELATION
        return not odd or (e.left < 1 - NAMED and not before)

    def _breaks(self, e: Explanation, stage: str) -> int:
        """Return how many checks of other stages would no longer follow with an explanation."""
        if e.change is None or isinstance(e.change.engine, Verlet):
            return 0
        full, count = self.base.then(e.change), 0
        known = {t.case.id: cs for t, cs in self._follow()}
        kinds: dict[str, list[Trial]] = defaultdict(list)
        for t in self.trials:
            kinds[t.scene.kind].append(t)
        for trial in (t for some in kinds.values() for t in _evenly(some, SOUGHT)):
            followed = {(c.stage, c.quantity) for c in known[trial.case.id] if c.follows}
            count += sum(
                c.stage != stage and c.error > max(c.tolerance, FINE * c.scale)
                and (c.stage, c.quantity) in followed
                for c in follow(trial, full)
            )  # fmt: skip
        return count

    def _sorted_explanations(
        self,
        stage: str,
        wrong: Sequence[tuple[Trial, list[Check]]],
        right: Sequence[Trial],
        beside: Sequence[tuple[Trial, list[Check]]],
        checks: Sequence[tuple[Trial, list[Check]]],
    ) -> list[Explanation]:
        """Return explanations, the best first."""
        if stage == "pitch":  # pitch and batted ball fly by one law: one explanation for both
            both = [(t, [c for c in cs if c.stage in ("pitch", "flight")]) for t, cs in checks]
            flying = [
                (t, cs) for t, cs in both
                if any(c.stage == "flight" and not c.follows for c in cs)
            ]  # fmt: skip
            if flying:
                sought = _Sought(
                    [t for t, _ in _evenly(wrong, SOUGHT // 2) + _evenly(flying, SOUGHT // 2)],
                    _evenly(right, BESIDE), ("pitch", "flight"), self.base, self.work,
                )  # fmt: skip
                found = sorted(self._parts(stage, sought), key=_order)
                if found and found[0].left < 1 - NAMED:
                    return found
        chosen = _evenly(wrong, SOUGHT)
        found = self._explanations(stage, chosen, _evenly(right, BESIDE), beside)
        return sorted(found, key=_order)

    def _accept(self, best: Explanation) -> None:
        """Make an explanation part of the chain, or mend the quantity that it is in.

        What is computed wrongly is mostly used as it is; a number that is only written wrongly is
        mended, which shows in more that follows.
        """
        if best.mend is not None:
            self.trials = [best.mend(t) for t in self.trials]
        elif best.change is not None:
            self.base = self.base.then(best.change)
            if isinstance(best.change.engine, Verlet):
                # Where steps find the bat is the scheme's, and what is computed there inherits it.
                self.excused.add("touching")
                steps = [_duration(t.case) / best.change.engine.dt for t in self.trials]
                self.trials = _evenly(self.trials, max(SOUGHT, int(MOST_STEPS / median(steps))))
                worst = self.findings[-1].worst
                self.loose = {
                    t.case.id: max(worst, self.loose.get(t.case.id, 0.0)) for t in self.trials
                }
        elif best.value is None:
            stage = self.findings[-1].stage
            self.excused.add(best.quantity or stage)
        elif best.quantity:
            mended = [self._mended(t, cs, best) for t, cs in self._follow()]
            self.excused.add(best.quantity)
            if best.quantity == "landing.position":
                self.excused.add("landing.velocity")
            self._followed = (None, [])
            plain, self.trials, as_it_is = self._failing(), mended, self.trials
            if self._failing() >= plain:
                self.trials = as_it_is
        self._followed = (None, [])

    def _mended(self, trial: Trial, checks: Sequence[Check], best: Explanation) -> Trial:
        """Return a trial with the right value of a quantity, but for what is left unexplained."""
        assert best.quantity is not None
        assert best.value is not None
        right = next((c.expected for c in checks if c.quantity == best.quantity), None)
        said, wrong = trial.given.get(best.quantity), best.value(trial)
        if right is None or said is None or wrong is None or len(said) != len(right):
            return trial
        value = tuple(e + s - w for e, s, w in zip(right, said, wrong, strict=True))
        return replace(trial, given={**trial.given, best.quantity: value})

    def _failing(self) -> int:
        """Return how many checks fail."""
        # Values from which nothing can be computed fail in everything.
        return sum(
            sum(not c.follows and c.error > FINE * c.scale for c in cs) if cs else len(STAGES)
            for _, cs in self._follow()
        )

    def _leave(self, stage: str, wrong: Sequence[tuple[Trial, list[Check]]]) -> None:
        """Let later stages allow for errors that stay unexplained, where they are handed on."""
        if stage in ("pitch", "plate", "touching"):
            for trial, checks in wrong:
                left = max(c.error / c.scale for c in checks)
                held = self.loose.get(trial.case.id, 0.0)
                self.loose[trial.case.id] = max(held, left)
            self._followed = (None, [])

    def _unknown(
        self, stage: str, wrong: Sequence[tuple[Trial, list[Check]]], worst: float, rest: bool
    ) -> str:
        """Return what can be said where nothing explains the errors."""
        sentence = f"{'what is left at' if rest else ''} {stage}".strip()
        sentence += f": wrong by up to {worst:.1e} of the quantity in {len(wrong)} scenes, and "
        sentence += "none of the known mistakes or fitted numbers explains it"
        if stage in ("pitch", "flight") and worst < 1e-4:
            sentence += (
                "; errors of this size are what long steps or a loose tolerance of the integrator "
                "leave: shorten them and see whether it falls"
            )
        return sentence

    # --- explanations ---------------------------------------------------------------------------

    def _explanations(
        self,
        stage: str,
        chosen: Sequence[tuple[Trial, list[Check]]],
        right: Sequence[Trial],
        beside: Sequence[tuple[Trial, list[Check]]],
    ) -> list[Explanation]:
        trials = [t for t, _ in chosen]
        found = [
            *self._relations(chosen, beside),
            *self._formulas(chosen, beside),
            *_resolutions(chosen),
        ]
        if stage in ("landing", "plate"):
            found += self._events(stage, chosen)
        if any(e.left < TIE for e in found):
            return found
        sought = _Sought(trials, right, (stage,), self.base, self.work)
        found += self._parts(stage, sought)
        if stage in ("pitch", "flight"):
            found += self._clock(stage, chosen)
            if not any(e.left < TIE for e in found) and self.scheme is None:
                found += self._schemes(stage, sought)
            if not any(e.left < 1 - NAMED for e in found):
                found += self._pairs(stage, sought, found)
        return found

    def _relations(
        self,
        chosen: Sequence[tuple[Trial, list[Check]]],
        beside: Sequence[tuple[Trial, list[Check]]],
    ) -> Iterator[Explanation]:
        """Yield constant ratios, exchanged axes and signs of the quantities."""
        for quantity in dict.fromkeys(c.quantity for _, cs in chosen for c in cs):
            pairs = [
                (t, c) for t, cs in chosen for c in cs if c.quantity == quantity and not c.follows
            ]
            if ":" in quantity or len(pairs) < 2:
                continue
            others = sum(
                min(c.error / c.scale, 1.0) for _, cs in chosen for c in cs
                if c.quantity != quantity
            )  # fmt: skip
            whole = others + sum(min(c.error / c.scale, 1.0) for _, c in pairs)
            expected = np.array([c.expected for _, c in pairs])
            obtained = np.array([c.obtained for _, c in pairs])
            scale = np.array([c.scale for _, c in pairs])
            true = [c for _, cs in beside for c in cs if c.quantity == quantity]
            for name, sentence, image in _images(quantity, expected, obtained):
                off = np.linalg.norm(obtained - image(expected), axis=1) / scale
                lefts = np.minimum(off, 1.0)
                wholes = [min(c.error / c.scale, 1.0) for _, c in pairs]
                left = _unless_alike((others + float(lefts.sum())) / whole, lefts, wholes)
                against = sum(_off(image(np.array(c.expected)), c) for c in true) / whole
                yield Explanation(
                    name, sentence, None, left, RELATION, quantity=quantity,
                    value=_image_value(quantity, image, self), against=against,
                )  # fmt: skip

    def _formulas(
        self,
        chosen: Sequence[tuple[Trial, list[Check]]],
        beside: Sequence[tuple[Trial, list[Check]]],
    ) -> Iterator[Explanation]:
        """Yield the known mistakes in formulas."""
        failing = {c.quantity for _, cs in chosen for c in cs if not c.follows}
        wanted = [f for f in FORMULAS if f.quantity in failing]
        if "landing.position" in failing:  # where the ball is at a time counted otherwise
            wanted += [f for f in FORMULAS if f.quantity == "landing.hang_time"]
        views = [(cs, self._view(t)) for t, cs in (*chosen, *beside)] if wanted else []
        for formula in wanted:
            left = whole = against = 0.0
            own: list[tuple[float, float]] = []  # of the quantity itself, what is left and was
            for number, (checks, view) in enumerate(views):
                for c in checks:
                    error = min(c.error / c.scale, 1.0)
                    value = _tried(formula.value, view) if c.quantity == formula.quantity else None
                    off = error if value is None else _off(value, c)
                    if number >= len(chosen):
                        against += off
                        continue
                    left, whole = left + off, whole + error
                    if c.quantity == formula.quantity:
                        own.append((off, error))
            if whole:
                yield Explanation(
                    formula.name, formula.sentence, formula.remedy,
                    _unless_alike(left / whole, *zip(*own, strict=True)) if own else left / whole,
                    0, quantity=formula.quantity, against=against / whole,
                    value=lambda t, f=formula: _tried(f.value, self._view(t)),  # type: ignore[misc]
                )  # fmt: skip

    def _view(self, trial: Trial) -> View | None:
        held = view_values(trial, self.base)
        return View(*held) if held else None

    def _parts(self, stage: str, sought: _Sought) -> list[Explanation]:
        """Return known mistakes and fitted numbers."""
        if stage == "flight" and type(self.base.engine) is Verlet and not self.base.push:
            push = list(self._tried_changes([TWO_STEP_PUSH], sought))
            if any(e.left < TIE for e in push):
                return push
        return [*self._changes(stage, sought), *self._fits(stage, sought)]

    def _changes(self, stage: str, sought: _Sought) -> Iterator[Explanation]:
        """Yield the known mistakes in the law, and other readings."""
        library: list[Mistake] = []
        if stage in ("pitch", "flight", "spin decay"):
            library += LAW
        if stage == "fence":
            library += FENCE
        if stage in ("impulse", "velocity after", "spin after", "energy"):
            library += (*IMPACT, *SPIN)
        if stage not in ("pitch", "plate", "touching", "normal", "bat velocity"):
            library += READINGS
        yield from self._tried_changes(library, sought)

    def _tried_changes(self, library: Iterable[Mistake], sought: _Sought) -> Iterator[Explanation]:
        for mistake in library:
            if self.impatient:
                return
            left = sought.screened(mistake.change)
            if left is not None:
                yield Explanation(
                    mistake.name, mistake.sentence, mistake.remedy, left, 1, mistake.change
                )

    def _fits(self, stage: str, sought: _Sought) -> Iterator[Explanation]:
        """Yield what numbers the candidate acts as if it had."""
        whole_chain = stage == "flight" and any(
            t.scene.kind == "at-bat" and "impact.velocity" not in t.given for t in sought.trials
        )
        for name, stages in PARAMETERS.items():
            if (stage not in stages and not whole_chain) or self.impatient:
                continue
            for fit in fits(sought.trials, name, sought.stages, self.base, self.work):
                left = sought.screened(fit.change)
                if left is None or left > 1 - PROBABLE:
                    continue
                # What is left may be another mistake, which has moved the number a little.
                for usual in snapped(fit):
                    there = sought.left(usual.change)
                    if there is not None and there < left + SNAP:
                        fit, left = usual, there
                yield Explanation(
                    fit_name(fit), fit.sentence, f"take the scene's {fit.parameter}", left,
                    2 + fit.roundness, fit.change,
                    doubtful=fit.doubt > 1e-2 * max(abs(fit.value), 1e-6),
                )  # fmt: skip

    def _events(
        self, stage: str, chosen: Sequence[tuple[Trial, list[Check]]]
    ) -> Iterator[Explanation]:
        """Yield where the ball is when the candidate says that the event happens."""
        offs = np.array([c.obtained[0] - c.expected[0] for _, cs in chosen for c in cs])
        trials = [t for t, _ in chosen]
        what, where = (
            ("below the ground", "above the ground") if stage == "landing"
            else ("behind the plate", "in front of the plate")
        )  # fmt: skip
        event = chosen[0][1][0].quantity
        low, high = float(offs.min()), float(offs.max())
        radius = np.array([t.scene.ball.radius for t in trials])
        floor = np.array([t.scene.ground.height for t in trials])
        if stage == "landing" and np.allclose(offs, radius, rtol=1e-6):
            yield Explanation(
                "landing-of-surface",
                "lets the ball land when its surface touches the ground, at z = R",
                "the ball lands when its centre reaches the ground, unless the reading "
                "ground_contact says otherwise", 0.0, 0, quantity=event,
            )  # fmt: skip
        if stage == "landing" and np.allclose(offs, -radius, rtol=1e-6):
            yield Explanation(
                "ignores-surface-reading",
                "lets the ball's centre reach the ground though reading.ground_contact = surface",
                "take the reading from the scene, or leave those out", 0.0, 0, quantity=event,
            )  # fmt: skip
        if stage == "landing" and floor.any() and np.allclose(offs, -floor, atol=1e-9):
            yield Explanation(
                "ground-ignored", "lands at z = 0, whatever ground.height is",
                "the ball lands at ground.height", 0.0, 0, quantity=event,
            )  # fmt: skip
        spread = high - low
        if spread <= 1e-6 * max(abs(low), abs(high)):
            yield Explanation(
                f"{stage}-offset", f"ends the flight {told(float(offs.mean()), spread / 2)} m off "
                f"{'the ground' if stage == 'landing' else 'the plate'}, always", None, 0.0, 1,
                quantity=event,
            )  # fmt: skip
        elif high <= 0 or low >= 0:
            late = high <= 0
            dt = self.dt or self._grid(stage, trials)
            step = f", in steps of {dt:.6g} s" if dt else ""
            name = ("first-below" if late else "last-above") + ("" if stage == "landing" else "-x")
            yield Explanation(
                name,
                f"ends the flight at the {'first' if late else 'last'} step "
                f"{what if late else where}{step}: by up to {max(-low, high):.2g} m",
                "interpolate to the surface between the last two steps, in time and velocity too",
                0.0, 1, quantity=event, step=dt,
            )  # fmt: skip

    def _grid(self, stage: str, trials: Sequence[Trial]) -> float | None:
        """Return the step of which all times are multiples."""
        names = ("plate.time",) if stage in ("pitch", "plate") else (
            "landing.hang_time", "landing.time")  # fmt: skip
        for name in names:
            times = [t.given[name][0] for t in self.trials if name in t.given and t in trials]
            if (step := common_step(times)) is not None:
                return step
        return None

    def _clock(
        self, stage: str, chosen: Sequence[tuple[Trial, list[Check]]]
    ) -> Iterator[Explanation]:
        """Yield what is wrong with times of points that lie on the true path."""
        places = [(t, p) for t, _ in chosen if (p := placed(t, self.base, stage))]
        if len(places) < 2:
            return
        off = np.array([p.off for _, p in places])
        clock = np.array([p.clock for _, p in places])
        moved = np.array([p.moved for _, p in places])
        left = float(off.sum() / max(moved.sum(), 1e-300))
        times = np.array([p.time for _, p in places])
        middle = float(np.median(clock))
        doubt = float(np.ptp(clock)) / 2
        on_path = f"the points lie on the true path, within {off.max():.1e} m; "
        if doubt < 1e-3 * abs(middle):
            yield Explanation(
                "clock-offset",
                on_path + f"the clock is {'ahead' if middle > 0 else 'behind'} by "
                f"{told(abs(middle), doubt)} s in all, as if a step were counted "
                f"{'twice' if middle > 0 else 'too late'}",
                "let the time of a state be that of the same step", left, 0, step=abs(middle),
                mend=_earlier(stage, middle),
            )  # fmt: skip
        ratio = times / np.maximum(times - clock, 1e-12)
        if np.ptp(ratio) < 1e-3 * abs(np.median(ratio) - 1):
            yield Explanation(
                "clock-rate", on_path + f"the clock runs {told(float(np.median(ratio)), 0)} times "
                "as fast", None, left, 0,
            )  # fmt: skip
        elif left < 1 - NAMED:
            yield Explanation(
                "clock", on_path + f"its times are off by {clock.min():.3g} to {clock.max():.3g} s",
                "law and integrator are right; look at how the time of the event is counted",
                left, 3,
            )  # fmt: skip

    def _schemes(self, stage: str, sought: _Sought) -> list[Explanation]:
        """Return schemes in fixed steps, with the step that fits best.

        The errors of a scheme of order p go with the p-th power of its step, so that one trial of
        each tells which step fits best and how well; the best few are then tried with theirs.
        """
        few = sought.some(4)
        known = self.dt or self._grid(stage, [t for t in self.trials if t.scene.kind != "impact"])
        first = max(known or 0.01, SHORTEST)
        base, ranked = few.residual(NONE), []
        for scheme in _schemes():
            r = few.residual(Change(engine=scheme.engine(first)))
            if r is None or base is None or self.impatient:
                continue
            amount = 1.0 if known else _amount(base, base - r)
            if amount > 0:
                ranked.append((float(np.linalg.norm(base - amount * (base - r))), scheme))
        ranked.sort(key=lambda one: one[0])
        found = []
        for _, scheme in ranked[:4]:
            dt = first if known else self._step(few, base, scheme, first)
            change = Change(engine=scheme.engine(dt))
            left = (sought if dt > 2e-3 else few).left(change)
            if left is not None:
                found.append(
                    Explanation(
                        scheme.name, f"{scheme.sentence}, in steps of {dt:.4g} s", scheme.remedy,
                        left, 1, change, step=dt,
                    )
                )  # fmt: skip
        return [*found, *self._chords(few)]

    def _step(self, few: _Sought, base: Array | None, scheme: _Scheme, dt: float) -> float:
        """Return the step that a scheme fits best with: a round one, if that fits as well."""
        best = (math.inf, dt)
        for _ in range(4):
            r = few.residual(Change(engine=scheme.engine(dt)))
            if r is None or base is None or self.impatient:
                break
            best = min(best, (float(np.abs(r).sum()), dt))
            amount = _amount(base, base - r)
            new = dt * amount ** (1 / scheme.order) if amount > 0 else 0.0
            if not SHORTEST <= new <= 0.2 or abs(new / dt - 1) < 1e-4:
                break
            dt = new
        for near in sorted(ROUND_STEPS, key=lambda step: abs(math.log(step / best[1])))[:3]:
            if near >= SHORTEST and abs(near / best[1] - 1) < 0.2:
                r = few.residual(Change(engine=scheme.engine(near)))
                best = best if r is None else min(best, (float(np.abs(r).sum()), near))
        return best[1]

    def _chords(self, few: _Sought) -> Iterator[Explanation]:
        """Yield events that lie on the straight line between two steps on the true path."""
        places = [p for t in few.trials if (p := placed(t, self.base, few.stage))]
        whole = sum(p.moved for p in places)
        if not whole or max(p.off for p in places) > 1:
            return
        tried = (self.dt,) if self.dt else [step for step in ROUND_STEPS if step >= SHORTEST]
        left, dt = min((sum(map(partial(_off_chord, dt), places)) / whole, dt) for dt in tried)
        if left < 1 - PROBABLE:
            yield Explanation(
                "linear-event", f"puts the end of the flight on the straight line between two "
                f"steps of {dt:.4g} s; the steps themselves are on the true path",
                "step onto the surface, or interpolate with the velocities (Hermite)", left, 1,
                Change(engine=FixedStep(dt=dt, scheme="chords")), step=dt,
            )  # fmt: skip

    def _pairs(
        self, stage: str, sought: _Sought, known: Sequence[Explanation]
    ) -> list[Explanation]:
        """Return two of the known mistakes and fitted numbers together."""
        base = sought.residual(NONE)
        if base is None or self.impatient:
            return []
        parts: list[tuple[Explanation, Array]] = []
        for e in known:
            if e.change is None:
                continue
            r = sought.residual(e.change)
            if r is not None and r.shape == base.shape and np.abs(base - r).sum() > 1e-9:
                parts.append((e, base - r))
        found = []
        columns: list[tuple[Explanation | str, Array]] = [*parts]
        columns += self._slopes(stage, sought, base)
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
            if self.impatient:
                break
            joined = self._joined(sought, stage, a, b)
            if joined is not None:
                found.append(joined)
        return found

    def _slopes(self, stage: str, sought: _Sought, base: Array) -> Iterator[tuple[str, Array]]:
        """Yield what a small part more of each parameter does."""
        for name, stages in PARAMETERS.items():
            if stage in stages:
                fit = Fit(name, "factor", 1.0 + 1e-5, 0.0, True)
                r = sought.residual(fit.change)
                if r is not None and r.shape == base.shape and np.abs(base - r).sum() > 1e-12:
                    yield name, (base - r) / 1e-5

    def _joined(
        self, sought: _Sought, stage: str, a: Explanation | str, b: Explanation | str
    ) -> Explanation | None:
        """Return two explanations as one, the fitted numbers fitted together."""
        fixed = [x for x in (a, b) if not isinstance(x, str)]
        free = [x for x in (a, b) if isinstance(x, str)]
        own = NONE
        for x in fixed:
            assert x.change is not None
            own = own.then(x.change)
        start = self.base.then(own)
        fitted: list[Fit] = []
        # Each in turn, with the others as they are: two numbers settle in a few rounds.
        for _ in range(6 if len(free) > 1 else 1):
            for name in free:
                others = [f for f in fitted if f.parameter != name]
                around = start
                for f in others:
                    around = around.then(f.change)
                forms = fits(sought.trials, name, (stage,), around, self.work)
                scored = [(sought.left(around.then(f.change), absolute=True), f) for f in forms]
                good = [(left, f) for left, f in scored if left is not None]
                if not good:
                    return None
                fitted = [*others, min(good, key=lambda one: one[0])[1]]
        for f in fitted:
            own = own.then(f.change)
        left = sought.left(own)
        if left is None:
            return None
        if left > 0.01 or any(f.roundness >= ODD / 100 for f in fitted):
            return None
        names = [x.name for x in fixed] + [fit_name(f) for f in fitted]
        sentences = [x.sentence for x in fixed] + [f.sentence for f in fitted]
        return Explanation(
            " and ".join(names), "; and ".join(sentences), None, left, 1.9,
            own,
        )  # fmt: skip

    # --- outcomes -------------------------------------------------------------------------------

    def _outcomes(self) -> None:
        """Say what is behind other outcomes."""
        kinds: dict[tuple[str, str], list[Trial]] = {}
        for t in self.confused:
            kinds.setdefault((str(t.case.expected.outcome), str(t.outcome)), []).append(t)
        for (expected, obtained), trials in sorted(kinds.items(), key=lambda k: -len(k[1])):
            same = [t for t in self.trials if t.case.expected.outcome == expected]
            few = _evenly(trials, 8)
            share, name, reason = self._outcome_explained(few, _evenly(same, 4))
            sentence, remedy = f"says {obtained} where {expected} is right", None
            if against := _against_itself(trials):
                share, name = 0.0, ""
                sentence += f", against {against}"
            elif share >= NAMED:
                sentence += f": {reason}"
            elif obtained == "missed" and expected in ("batted", "separating", "beyond_bat"):
                sentence += ": as one who looks for the bat at the steps only"
                remedy = (
                    "find the closest approach within the step, where d·v changes sign, and test "
                    "there"
                )
            self.findings.append(
                Finding(
                    stage="outcome", quantity="outcome", names=[name] if share >= NAMED else [],
                    kind="probably" if share >= NAMED else "unexplained", sentence=sentence,
                    remedy=remedy, share=share if share >= NAMED else 0.0, wrong=len(trials),
                    checked=len(trials) + len(same), worst=1.0,
                    scenes=rule([t.case for t in trials], [t.case for t in same]),
                )
            )  # fmt: skip

    def _solved(self, trial: Trial) -> Result:
        """Return a scene's result under the chain as far as it is explained."""
        return solve(self.base.scene(trial.scene), self.base.engine, self.base.model)

    def _told(self) -> None:
        """Say what is told besides numbers, and is not so."""
        wrong: dict[tuple[str, object, object], list[Trial]] = defaultdict(list)
        for t in self.trials:
            facts = untrue(t.case.expected, t.told)
            made = told_by(self._solved(t)) if facts and self.base is not NONE else {}
            for fact in facts:
                if made.get(fact[0]) != fact[2]:  # else it follows from what is explained
                    wrong[fact].append(t)
        for (name, true, given), trials in wrong.items():
            same = [t for t in self.trials if name in t.told and t not in trials]
            self.findings.append(
                Finding(
                    stage=STAGE_OF.get(name) or STAGE_OF[name.partition(".")[0]], quantity=name,
                    kind="unexplained", names=[], share=0.0, wrong=len(trials),
                    checked=len(trials) + len(same), worst=1.0,
                    sentence=f"{name} is told to be {given} where {true} is right",
                    scenes=rule([t.case for t in trials], [t.case for t in same]),
                )
            )  # fmt: skip

    def _outcome_explained(
        self, trials: Sequence[Trial], beside: Sequence[Trial]
    ) -> tuple[float, str, str]:
        """Return the share of outcomes that the best explanation makes, and what it is."""
        whole = [*trials, *beside]

        def share(change: Change) -> float:
            right = 0
            for t in whole:
                try:
                    made = solve(change.scene(t.scene), change.engine, change.model).outcome
                except (ArithmeticError, ValueError):
                    made = None
                right += made == (t.outcome or t.case.expected.outcome)
            return right / len(whole)

        name = next((name for f in self.findings for name in f.names), "")
        tried = [(self.base, name, "this follows from the above")]
        clear = "home_run" in _outcomes_of(whole) and not any(
            "fence.clearance" in t.given for t in whole
        )
        library = [*OUTCOMES, *(FENCE if clear else ())]
        tried += [(self.base.then(m.change), m.name, m.sentence) for m in library]
        found = [(share(change), name, sentence) for change, name, sentence in tried]
        return max(found, key=lambda one: one[0])


def _against_itself(trials: Sequence[Trial]) -> str:
    """Return which of their own values wrong outcomes contradict, with what it says; else ""."""
    for quantity, outcomes, says in (
        ("fence.clearance", {True: "home_run", False: "wall"}, "above the fence"),
        ("contact.margin", {True: "batted", False: "missed"}, "nearer than the bat's surface"),
    ):
        given = [(t, t.given[quantity][0] > 0) for t in trials if quantity in t.given]
        if (
            given
            and all(t.outcome in outcomes.values() for t, _ in given)
            and all(outcomes[above] != t.outcome for t, above in given)
        ):
            return f"its own {quantity}: positive is {says}"
    speeds = [
        t.given["contact.normal_speed"][0] for t in trials if "contact.normal_speed" in t.given
    ]
    if speeds and min(speeds) >= 0 and all(t.outcome in ("struck", "batted") for t in trials):
        return "its own contact.normal_speed: where it is not negative, ball and bat separate"
    return ""


def _outcomes_of(trials: Iterable[Trial]) -> set[str | None]:
    """Return what trials end with, and should."""
    return {outcome for t in trials for outcome in (t.outcome, t.case.expected.outcome)}


def _order(e: Explanation) -> tuple[float, ...]:
    return (0 if e.left <= TIE else round(e.left / TIE), e.rank)


# The rank of relations: behind known mistakes that leave as little.
RELATION = 0.5

# Digits of a number that nobody chooses.
ODD = 5

SHORTEST = 2e-4  # s: of steps that are tried


@dataclass(frozen=True)
class _Scheme:
    """A scheme in fixed steps: its engine for a step, and the order of its errors."""

    name: str
    sentence: str
    order: int
    engine: Callable[[float], Verlet]
    remedy: str = "take shorter steps, or a method of higher order"


_VERLET = {
    "old_carried": ("lagged-verlet", "flies by velocity Verlet with drag and lift at the velocity "
                    "of the step before", 1),
    "old_recomputed": ("lagged-verlet-recomputed", "flies by velocity Verlet with the force at the "
                       "old velocity", 1),
    "half_step": ("half-step-verlet", "flies by velocity Verlet with drag and lift at the "
                  "half-step velocity, as is usual in molecular dynamics", 1),
    "predicted_carried": ("verlet-predicted-carried", "flies by velocity Verlet with a predicted "
                          "velocity, which is of order 2", 2),
    "predicted_recomputed": ("verlet-predicted", "flies by velocity Verlet with a predicted "
                             "velocity, which is of order 2", 2),
    "implicit": ("verlet-implicit", "flies by velocity Verlet with an implicit velocity, which is "
                 "of order 2", 2),
}  # fmt: skip


_LAGGING = ("lagged-verlet", "lagged-verlet-recomputed", "half-step-verlet")
_REMEDY = (
    "predict the velocity at the step's end, v + aΔt, or iterate, before asking for the force "
    "there: the error then falls with Δt² instead of Δt"
)


def _schemes() -> Iterator[_Scheme]:
    """Yield the schemes; the paper's own comes first."""
    for forces, (name, sentence, order) in _VERLET.items():
        remedy = {"remedy": _REMEDY} if name in _LAGGING else {}
        yield _Scheme(name, sentence, order, partial(_verlet, forces), **remedy)
    for name, (_, order, words) in SCHEMES.items():
        yield _Scheme(name, f"flies by {words}", order, partial(_fixed, name))


def _verlet(forces: Any, dt: float) -> Verlet:
    return Verlet(dt=dt, forces=forces)


def _fixed(scheme: str, dt: float) -> Verlet:
    return FixedStep(dt=dt, scheme=scheme)


def _amount(errors: Array, effect: Array) -> float:
    """Return how many times an effect explains errors best."""
    size = float(effect @ effect)
    return float(errors @ effect) / size if size else 0.0


def fit_name(fit: Fit) -> str:
    """Return a fit as a name: ``air.density=1.205``, ``pitch.speed*3.6``."""
    symbol = {"fixed": "=", "factor": "*", "offset": "+"}[fit.form]
    return f"{fit.parameter}{symbol}{fit.value:.6g}"


class _Sought:
    """Trials that an explanation is sought in, and what changes leave of their errors."""

    def __init__(
        self, trials: Sequence[Trial], beside: Sequence[Trial], stages: tuple[str, ...],
        base: Change, work: Work,
    ) -> None:  # fmt: skip
        self.trials, self.beside = list(trials), list(beside)
        self.stages, self.base, self.work = stages, base, work
        self._first = [work.residuals(t, base, stages) for t in self.everything]

    @property
    def everything(self) -> list[Trial]:
        return [*self.trials, *self.beside]

    @property
    def stage(self) -> str:
        return self.stages[0]

    def screened(self, change: Change) -> float | None:
        """Return what a change leaves; of a few trials only, if it leaves most of them."""
        left = self.few.left(change)
        return left if left is None or left > SCREEN else self.left(change)

    @cached_property
    def few(self) -> _Sought:
        """Three of the trials."""
        return self.some(3)

    def some(self, count: int) -> _Sought:
        """Return a few of the trials, the shortest flights first."""
        short = sorted(self.trials, key=lambda t: _duration(t.case))
        return _Sought(_evenly(short[: 2 * count], count), (), self.stages, self.base, self.work)

    def residual(self, change: Change) -> Array | None:
        """Return all relative errors that a change leaves, in one row; None if it has none."""
        full = self.base.then(change)
        rows = [self.work.residuals(t, full, self.stages) for t in self.everything]
        if any(r.shape != f.shape for r, f in zip(rows, self._first, strict=True)):
            return None
        return np.concatenate(rows) if rows else None

    def left(self, change: Change, absolute: bool = False) -> float | None:
        """Return the share of the error that a change leaves, none counted for more than 1."""
        wholes = [float(np.minimum(np.abs(f), 1.0).sum()) for f in self._first]
        full = change if absolute else self.base.then(change)
        lefts = []
        for trial, first in zip(self.everything, self._first, strict=True):
            r = self.work.residuals(trial, full, self.stages)
            same = r.shape == first.shape
            lefts.append(float(np.minimum(np.abs(r), 1.0).sum()) if same else float(first.size))
        if not sum(wholes):
            return None
        count = len(self.trials)
        return _unless_alike(sum(lefts) / sum(wholes), lefts[:count], wholes[:count])


# --- single precision -----------------------------------------------------------------------------

SINGLE = Explanation(
    "single-precision",
    "computes or writes in single precision",
    "use doubles throughout, and write them with 17 digits",
    0.0,
    0,
)

# Single precision leaves 6e-8 a rounding; some hundred steps, amplified by bat and ball.
SINGLE_NOISE = 1e-2

# A quantity with fewer numbers than this may be in single precision by chance: 2.0 is.
ENOUGH = 5


def _in_single_precision(answers: Iterable[Answer]) -> bool:
    """Tell whether most quantities hold only numbers of single precision, or such as are written.

    Not all need to: a program in single precision may still take a square root in doubles.
    """
    numbers: dict[str, set[Decimal]] = defaultdict(set)
    for answer in answers:
        for name, value in answer.values.items():
            if len(numbers[name]) < 50:
                numbers[name].update(x for x in value if x)
    single = [all(map(_is_single, some)) for some in numbers.values() if len(some) >= ENOUGH]
    return 2 * sum(single) > len(single)


def _is_single(x: Decimal) -> bool:
    if abs(x.adjusted()) > 37:  # beyond the range of single precision
        return False
    single = np.float32(float(x))
    return float(x) == float(single) or x in (Decimal(str(single)), Decimal(f"{single:.9g}"))


# --- relations ------------------------------------------------------------------------------------


Image = Callable[[Array], Array]


def _images(quantity: str, expected: Array, obtained: Array) -> Iterator[tuple[str, str, Image]]:
    """Yield simple relations between what is expected and obtained."""
    size = float((expected * expected).sum())
    if size > 0:
        ratios = (obtained * expected).sum(axis=1) / np.maximum(
            (expected * expected).sum(axis=1), 1e-300
        )
        ratio = float(np.median(ratios))
        if abs(ratio - 1) > 1e-9 and np.ptp(ratios) < 1e-3 * max(abs(ratio), 1e-9):
            what = factor_meaning(ratio)
            text = "the sign is wrong" if what == "the sign" else (
                f"obtained = {ratio:.8g} × expected" + (f": {what}" if what else ""))  # fmt: skip
            yield f"{quantity}*{ratio:.6g}", f"{quantity}: {text}", lambda x: ratio * x
    if expected.shape[1] == 3:
        for order in itertools.permutations(range(3)):
            for signs in itertools.product((1.0, -1.0), repeat=3):
                if order == (0, 1, 2) and min(signs) > 0:
                    continue
                shown = ", ".join(
                    f"{'-' if s < 0 else ''}{'xyz'[i]}" for i, s in zip(order, signs, strict=True)
                )
                yield (
                    f"{quantity}:({shown})",
                    f"{quantity}: ({shown}) stands where (x, y, z) belongs",
                    _turned(order, signs),
                )
        for axis in range(3):
            flat = np.ones(3)
            flat[axis] = 0.0
            if quantity == "plate.position" and axis == 0:
                continue  # there it is 0
            if not np.abs(obtained[:, axis]).any() and np.abs(expected[:, axis]).any():
                name, told_as = (
                    f"{quantity}:{'xyz'[axis]}=0",
                    f"{quantity}: {'xyz'[axis]} is always 0",
                )
                if quantity == "landing.position" and axis == 2 and (expected[:, 2] < 0).all():
                    name = "first-below"
                    told_as = (
                        "ends the flight at the first step below the ground, and says that it is "
                        "at the ground"
                    )
                yield name, told_as, _turned((0, 1, 2), flat.tolist())
    else:
        shift = obtained - expected
        middle = float(np.median(shift))
        if middle and np.ptp(shift) < 1e-3 * abs(middle):
            yield (
                f"{quantity}+{middle:.6g}", f"{quantity}: obtained = expected + {middle:.8g}",
                lambda x: x + middle,
            )  # fmt: skip


def _turned(order: Sequence[int], signs: Sequence[float]) -> Image:
    """Return the exchange of axes, each with a factor."""
    axes, factors = list(order), np.array(signs)
    return lambda x: x[..., axes] * factors


def _image_value(quantity: str, image: Image, search: _Search) -> Callable[[Trial], Numbers | None]:
    def value(trial: Trial) -> Numbers | None:
        for check in follow(trial, search.base):
            if check.quantity == quantity:
                return tuple(image(np.array(check.expected)).tolist())
        return None

    return value


def _resolutions(chosen: Sequence[tuple[Trial, list[Check]]]) -> Iterator[Explanation]:
    """Yield the rounding of what is written, if numbers are written with few decimals."""
    failing = [c for _, cs in chosen for c in cs if not c.follows]
    places = max(-int(Decimal(repr(x)).as_tuple().exponent) for c in failing for x in c.obtained)
    resolution = max(0.5 * 10.0**-places, *(t.resolution for t, _ in chosen))
    if places <= FEW_DECIMALS and max(c.error for c in failing) < 4 * resolution:
        yield Explanation(
            "few-decimals", f"writes its numbers with {places} decimals only, and errors are of "
            "that size", "write doubles with 17 digits", 0.0, 3,
            mend=lambda t: replace(t, resolution=resolution),
        )  # fmt: skip


FEW_DECIMALS = 10


def _earlier(stage: str, seconds: float) -> Callable[[Trial], Trial]:
    """Return what takes some seconds from the times of a stage."""
    names = ("plate.time",) if stage == "pitch" else ("landing.time", "landing.hang_time")

    def mend(trial: Trial) -> Trial:
        times = {n: (trial.given[n][0] - seconds,) for n in names if n in trial.given}
        return replace(trial, given={**trial.given, **times})

    return mend


def _off_chord(dt: float, place: Placed) -> float:
    """Return how far a point is from the line between two steps on the true path, at its time."""
    first = math.floor(place.time / dt)
    share = place.time / dt - first
    try:
        a, b = place.way(first * dt), place.way((first + 1) * dt)
    except (ArithmeticError, ValueError):  # the flight cannot be followed beyond its end
        return place.moved
    return math.dist([p + (q - p) * share for p, q in zip(a, b, strict=True)], place.point)


# --- small things ---------------------------------------------------------------------------------


def _unless_alike(left: float, lefts: Iterable[float], wholes: Iterable[float]) -> float:
    """Return what an explanation leaves, but 1 if it leaves much in most of the scenes.

    One that only looks alike does; with a real one, what is left is in some scenes, or is little.
    """
    ratios = [a / b for a, b in zip(lefts, wholes, strict=True) if b]
    return left if left < 1 - NAMED or (ratios and median(ratios) < 1 - NAMED) else 1.0


def _off(value: Sequence[float] | Array, check: Check) -> float:
    """Return how far a value is from what a candidate says, relative, and at most 1."""
    if len(value) != len(check.obtained):
        return 1.0
    return min(math.dist(value, check.obtained) / check.scale, 1.0)


def _tried(value: Callable[[View], Numbers], view: View | None) -> Numbers | None:
    try:
        return None if view is None else value(view)
    except (KeyError, AttributeError, ZeroDivisionError, OverflowError, ValueError):
        return None


def _evenly(items: Sequence[Any], count: int) -> list[Any]:
    if len(items) <= count:
        return list(items)
    return [items[i * len(items) // count] for i in range(count)]


def _duration(case: Case) -> float:
    landing = case.expected.landing
    return 0.5 if landing is None else float(landing.time)


def _row(stage: str, checks: Iterable[tuple[Trial, list[Check]]]) -> StageRow | None:
    seen = [(t, c) for t, cs in checks for c in cs if c.stage == stage]
    if not seen:
        return None
    bad = [(t, c) for t, c in seen if not c.follows]
    worst = max(bad, key=lambda one: one[1].error / one[1].scale, default=None)
    return StageRow(
        stage=stage,
        checked=len({t.case.id for t, _ in seen}),
        wrong=len({t.case.id for t, _ in bad}),
        worst=worst[1].error / worst[1].scale if worst else 0.0,
        example=worst[0].case.id if worst else None,
    )
