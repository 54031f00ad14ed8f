"""What is wrong with a candidate: where first, by how much, in which scenes, and why.

Stage by stage (`longball.judge.stages`), in the order in which a scene goes through them. A stage
that does not follow from the candidate's own earlier values is explained, if anything explains its
errors in every scene (`longball.judge.explanations`): a relation or a formula in the quantity
itself (`relations`), a known mistake in the chain or a number of its own (`fits`), when it ends
or how time is counted (`clocks`), or a scheme in steps (`steps`). The explanation is then
part of the chain that later stages are computed with, so that one mistake does not show twice and
two do not hide each other. What is left is told, with its size.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np

from longball.engines.verlet import Verlet
from longball.judge import clocks, fits, misreadings, outcomes, relations
from longball.judge.answers import Answer
from longball.judge.cases import FRAGILE, Case, decidable
from longball.judge.explanations import (
    ALIKE,
    IN_A_SCENE,
    NAMED,
    Checked,
    Explanation,
    Seen,
    Sought,
    Work,
    doubt_of,
    duration,
    evenly,
    size_of,
    told_together,
)
from longball.judge.findings import Diagnosis, Finding, StageRow, found, many
from longball.judge.quantities import superfluous, untrue
from longball.judge.rules import FEWEST, TURNED, rule
from longball.judge.stages import (
    COLLISION,
    ENOUGH,
    NONE,
    SHORT,
    STAGES,
    Change,
    Check,
    Trial,
    Trials,
    follow,
    followed,
    half_unit,
    stage_of,
    trial_of,
)
from longball.judge.steps import FixedStep, schemes
from longball.model.readings import Reading

SOUGHT, BESIDE = 10, 4  # failing and passing scenes that an explanation is sought in, before all
PASSING = 60  # passing scenes in which it is seen what contradicts an explanation
OTHERS = 3  # scenes of each kind in which it is seen what an explanation does to other stages

# Of wrong answers, those in which no stage can be told to be wrong, such as grazes that doubles
# hardly decide: beside a cause that is named, so few are not worth a line.
FEW_UNSEEN = 0.1

# What the axes or the unit of some scenes may leave of their errors: those are exact, and a throw
# to the other side, for one, makes almost the same of them.
EXACTLY = 1e-4

RIGHT = {"wrong": 0, "worst": 0.0, "example": None}  # of errors made elsewhere

# Where a wrong flight ends is seen to be on the surface, and no more: not that it is there in time.
ENDS_OF = {"plate": "pitch", "landing": "flight", "landing velocity": "flight"}

MADE = ("impact.mode",)  # what the impact tells besides numbers, which a change of it may change

# Scenes with these flags magnify the errors of flights under laws other than longball's; where one
# in so many of them is wrong with an explanation at hand, it is that explanation's own error.
KEEN, ONE_IN = frozenset(("vertical", "grazing", "vertex")), 5

# Errors below this, relative, are mostly an integrator's: of the physics only a number may be
# behind them. Below the second one nothing is sought.
FINE, FAINT = 1e-7, 1e-10

LAST = 1e-5  # of the errors, what explanations may leave in few scenes
MINOR = 1e-3  # of the largest relative error of any stage: below it is not where the trouble begins
DOUBT_OF_STEPS = 1e-6  # of the errors, what a scheme leaves that is the candidate's own
MOST_STEPS = 10_000  # steps of all flights together that are followed with a scheme
STRENGTH = "air.density*"  # what stands for a factor of k = ρ A/(2 m)

# Stages in which a graze makes errors of what comes before it a thousand times as large.
INHERITING = ("touching", "normal speed", "velocity after")

MAYBE_STEPS = (
    "; an error of this size may be in a number, or the integrator's (long steps, a loose "
    "tolerance): see whether shorter steps change it"
)

# What one impulse with friction makes.
PUSHED = ("impulse", "velocity after", "spin after", "energy")

IN_STEPS = (
    "if it flies in steps, put {dt} where the COMMAND sets them: how errors fall with the step "
    "tells an integrator's from those of a law"
)

FIXED_AXIS = (
    "the lift's axis is fixed at launch, so that the lift turns the ball on beyond the vertical: a "
    "heading that is taken anew from the velocity flips there, and the lift with it"
)

MEND_FIRST = "mend what is named first: it may be the same"

CUT_OFF = "; the few digits of the numbers before it may do that"

OF_ORDER = (
    "; its runs with several time steps converge with order {}: look for what is of that order in "
    "a step"
)

ROUNDS = 3  # explanations at one stage, each for what the one before has left


def diagnose(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    dt: float | None = None,
    scheme: Verlet | None = None,
    causes: bool = True,
    wrong: Collection[str] = (),
    granted: float = 0.0,
    order: int | None = None,
) -> Diagnosis:
    """Return what is wrong with a candidate's answers to cases.

    Parameters
    ----------
    dt, order
        s, its time step, if it is known; the order of its errors in it, if that was measured.
    scheme
        What counts as true, if that is the paper's scheme.
    causes
        Whether causes are sought; they are not in answers that change from run to run.
    wrong, granted
        Ids of answers that are wrong by the profile; the error of a quantity that passes.
    """
    known = [(c, a) for c in cases if decidable(c) and (a := answers.get(c.id)) and a.error is None]
    trials = [  # either outcome of a fragile case may be right
        trial_of(case, answer, granted)
        for case, answer in known
        if FRAGILE not in case.flags or answer.outcome in (None, case.expected.outcome)
    ]
    if other := relations.shifted(trials):
        return Diagnosis(sentence=other.sentence, first=None, stages=[], clean=[], findings=[other])
    if 2 * sum(t.coarse for t in trials) <= len(trials):
        # A few answers have short numbers by chance, such as those of the scene.
        trials = [replace(t, resolution=0.0, share=0.0) for t in trials]
    if single := relations.in_single_precision(answers.values()):
        # Written with nine digits, they are right to seven.
        least = half_unit(SHORT)
        trials = [replace(t, share=t.share if t.share >= least else 0.0) for t in trials]
    unread = {name for name, answer in answers.items() if answer.unreadable}
    base = NONE if scheme is None else Change(engine=scheme, push=True)
    return _Search(
        trials, dt, order, scheme, causes, frozenset(wrong), single, unread, base,
        relations.few_digits(trials),
    ).diagnosis()  # fmt: skip


@dataclass
class _Search:
    """The search for what explains one candidate's errors."""

    trials: list[Trial]
    # See `diagnose`.
    dt: float | None
    order: int | None
    scheme: Verlet | None
    causes: bool
    wrong: Collection[str]
    single: bool  # whether the answers are in single precision
    unread: Collection[str]  # ids of answers with values that are no numbers
    base: Change  # the chain as far as it is explained
    coarse: Finding | None  # that all numbers are written with few digits, if they are
    findings: list[Finding] = field(default_factory=list)
    # Stages and quantities whose errors are explained.
    excused: set[str] = field(default_factory=set)
    stepless: bool = False  # whether no scheme in steps explains the flights
    # Whether a law is found that jumps: what is left then is the candidate's step across.
    jumps: bool = False
    # Relative errors that are left unexplained and handed on, by scene.
    loose: dict[str, float] = field(default_factory=dict)
    # Largest relative errors of the stages that something is found for, before that.
    begun: dict[str, float] = field(default_factory=dict)
    # Stages whose errors are explained by a mistake at another one, and that.
    moved: dict[str, str] = field(default_factory=dict)
    thrown: set[str] = field(default_factory=set)  # scenes whose pitch does not follow
    # Stages that are wrong in few scenes, which few digits may do.
    amplified: set[str] = field(default_factory=set)
    work: Work = field(default_factory=Work)
    _raw: dict[int, Checked] = field(default_factory=dict)  # under the base, by trial's identity
    _followed: list[Checked] | None = None

    def diagnosis(self) -> Diagnosis:
        checks = self._follow()
        rows = [row for stage in STAGES if (row := _row(stage, checks))]
        wrong = [(t.case.id, c.stage) for t, cs in checks for c in cs if not c.follows]
        self.thrown, unseen = {name for name, at in wrong if at == "pitch"}, self._unseen(checks)
        largest = _largest(checks)
        first = next((r.stage for r in rows if r.wrong and r.worst >= MINOR * largest), None)
        if self.causes and self.scheme is None:
            self._rewrite(first, rows)
        for stage in STAGES:
            for _ in range(ROUNDS):
                if not self._explain(stage, self._follow()):
                    break
        self.findings += outcomes.outcome_findings(self.trials, self.base, self.findings)
        facts = [*outcomes.told_findings(self.trials, self.base, self.findings)]
        self.findings += facts
        named = any(f.names for f in self.findings)
        if unseen and named and (self.single or unseen.wrong <= FEW_UNSEEN * len(self.wrong)):
            unseen = None
        if self.causes and (coarse := self.coarse):
            self.findings.insert(sum(bool(f.names) for f in self.findings), coarse)
        elif unseen:
            remedy = MEND_FIRST if named else None
            self.findings.append(unseen.model_copy(update={"remedy": remedy}))
        self.findings = _not_alone(self.findings)
        known = {f.stage for f in self.findings if f.names}
        # Little beside other errors is mostly the candidate's integrator's, unless it has a name.
        self.findings.sort(key=lambda f: not f.names and f.worst < MINOR * largest)
        rows = _where_made(rows, self.moved, {f.stage for f in self.findings}, facts)
        absent = {_absent(t) for t, cs in checks if t.confused and all(c.follows for c in cs)}
        bad = {r.stage for r in rows if r.wrong}
        right = [r.stage for r in rows if r.stage not in bad | absent]
        clean = [stage for stage in right if ENDS_OF.get(stage) not in bad]
        rows = self._without_inherited(rows)
        leading = [r for r in rows if r.wrong and (r.worst >= MINOR * largest or r.stage in known)]
        lead = next((r for r in leading if r.stage not in self.amplified), None)
        return Diagnosis(
            sentence=self._sentence(lead, clean), first=lead and lead.stage, stages=rows,
            clean=clean, findings=self.findings,
        )  # fmt: skip

    def _without_inherited(self, rows: Sequence[StageRow]) -> list[StageRow]:
        """Return the rows without errors of stages that follow with what is found at others."""
        # So the touching does with the law of a wrong pitch. A flight has that law itself.
        told = {"flight", *self.excused, *(f.stage for f in self.findings)}
        if isinstance(self.base.engine, Verlet):  # of which only some scenes are followed
            return list(rows)
        told |= {c.stage for _, cs in self._follow() for c in cs if not c.follows}
        return [r if r.stage in told else r.model_copy(update=RIGHT) for r in rows]

    def _unseen(self, checks: Seen) -> Finding | None:
        """Return that answers are wrong in which every stage follows, as far as it is told."""
        sound = [t for t, cs in checks if not t.confused and all(c.follows for c in cs)]
        numbers = [t for t in sound if not untrue(t.case.expected, t.told)
                   and not superfluous(t.case.expected.outcome, t.expected, t.given)]  # fmt: skip
        small = [t for t in numbers if t.case.id in self.wrong and t.case.id not in self.unread]
        if not small:
            return None
        return found(
            "all", f"{many(len(small), 'answer')} wrong in which no stage is so far off that it "
            "can be told to be at fault", len(small), len(checks), worst=0.0,
            example=small[0].case.id,
        )  # fmt: skip

    def _sentence(self, first: StageRow | None, clean: Sequence[str]) -> str:
        """Return it all in a sentence."""
        count = len(self.unread)
        unread = f"{count} answers hold values that are no numbers of any use" if count else ""
        if not self.findings:
            if not clean:
                return unread or "nothing is answered that could be followed"
            if unread:
                return f"{unread}; what could be read follows from what comes before it"
            return "every stage follows from the stages before it, in every scene"
        lead = self.findings[0]
        parts = [unread] if unread else []
        if first is not None:
            where = "all" if first.wrong == first.checked else f"{first.wrong} of {first.checked}"
            said = f"the first stage that does not follow is {first.stage}"
            parts.append(f"{said}: wrong in {where} scenes")
        large = MINOR * min(lead.worst, 1.0)
        parts += [f.sentence for f in self.findings if f.worst >= large][:3]
        return "; ".join(parts)

    def _follow(self) -> list[Checked]:
        """Return what follows in every trial under the chain as far as it is explained."""
        if self._followed is None:
            for t in self.trials:
                if id(t) not in self._raw:
                    checks = followed(t) if self.base is NONE else follow(t, self.base)
                    self._raw[id(t)] = t, checks
            found = [self._raw[id(t)] for t in self.trials]
            self._followed = [(t, [self._inheriting(t, c) for c in cs if not {
                c.quantity, c.stage} & self.excused]) for t, cs in found]  # fmt: skip
        return self._followed

    def _inheriting(self, trial: Trial, check: Check) -> Check:
        """Return a check that allows for what an earlier stage has left unexplained."""
        left = self.loose.get(trial.case.id, 0.0)
        if not left or check.stage not in INHERITING:
            return check
        return replace(check, tolerance=check.tolerance + 30 * left * max(check.scale, 0.1))

    def _leave(self, stage: str, wrong: Seen) -> None:
        """Let later stages allow for errors that stay unexplained, where they are handed on."""
        if stage in ("pitch", "plate", "touching"):
            for trial, checks in wrong:
                left = max(c.error / c.scale for c in checks)
                self.loose[trial.case.id] = max(self.loose.get(trial.case.id, 0.0), left)
            self._followed = None

    def _rewrite(self, first: str | None, rows: Sequence[StageRow]) -> None:
        """Read the output as it is meant, if all of it is written otherwise."""
        if meant := relations.conventions(self.trials):
            stage, every = first or stage_of(meant.quantity or "landing"), len(self.trials)
            counts = [(r.wrong, r.checked) for r in rows if r.stage == stage] or [(every, every)]
            self._read(self.trials, meant, found(stage, "", *counts[0]))

    def _read(self, some: Trials, meant: Explanation, told: Finding) -> None:
        """Read the output of some trials as it is meant."""
        assert meant.mend is not None
        self.findings.append(_with_name(told, meant, quantity=meant.quantity))
        self.begun.setdefault(told.stage, 1.0)
        mended = {id(t): meant.mend(t) for t in some}
        self.trials = [mended.get(id(t), t) for t in self.trials]
        self._followed = None

    def _explain(self, stage: str, checks: Seen) -> bool:
        """Explain what does not follow at a stage; tell whether there may be more."""
        seen = [(t, [c for c in cs if c.stage == stage]) for t, cs in checks]
        failing = ([c.error / c.scale for c in cs if not c.follows] for _, cs in seen)
        sizes = [max(errors, default=0.0) for errors in failing]
        worst = max(sizes, default=0.0)
        if not worst:
            return False
        # Beside large errors small ones are another matter.
        before = self.begun.get(stage, 0.0)
        minor = MINOR * _usual(sizes) if before else _minor(sizes)
        wrong = [one for one, size in zip(seen, sizes, strict=True) if size > minor]
        good = [one for one, size in zip(seen, sizes, strict=True) if one[1] and size <= minor]
        # Of a number that is found the last digits are not known.
        rest = FINE if before else FAINT if self.begun else 0.0
        failures = sum(size > 0 for size in sizes)
        if _usual(sizes) < rest or self._is_own(wrong, good, failures):
            self._leave(stage, wrong)
            return False
        every = len(wrong) + len(good)
        quantity = max((c for _, cs in wrong for c in cs), key=lambda c: c.error / c.scale).quantity
        scenes = _told_apart(seen, sizes, minor)
        wrong_ones = {c.quantity for _, cs in wrong for c in cs if not c.follows}
        said = _unknown(stage, wrong_ones, sizes, minor, before > 0)
        told = found(stage, said, len(wrong), every, quantity=quantity.partition(":")[0],
                     worst=worst, scenes=scenes)  # fmt: skip
        causes: list[Explanation] = []
        little = worst < MINOR * min(before, 1.0)
        stepped = before and (isinstance(self.base.engine, Verlet) or self.jumps)
        # Large in a graze is what an earlier stage has left there, or had wrong from the beginning.
        few = len(wrong) < max(ENOUGH, every / ONE_IN)
        left = self.loose.keys() | self.thrown
        if stage in INHERITING and few and all(t.case.id in left for t, _ in wrong):
            self._leave(stage, wrong)
            return False
        # Of digits that are cut off a few scenes make a thousand times as much, and more.
        cut_off = self.coarse is not None and len(wrong) <= FEW_UNSEEN * every
        searched = self.causes and not (little or stepped or cut_off)
        if searched and scenes:
            ids = {id(t) for t, _ in wrong}
            some = [t for t in self.trials if id(t) in ids]
            if (meant := relations.conventions(some)) and meant.left < EXACTLY:
                self._read(some, meant, told)
                return True
        plain, of_most, rounded = _plain(wrong), False, False
        if searched and self.single and worst < relations.SINGLE_NOISE:
            causes = [relations.SINGLE]
        elif searched and worst > FAINT:
            causes = self._found(stage, wrong, good, checks, told.scenes is not None)
            rounded = bool(self.begun) and _usual(sizes) < FINE
            ratios = [e for e in causes if e.quantity and e.change is None]
            if rounded and ratios:  # of a quantity itself: no rest of another number is like that
                rounded, causes = False, ratios
            elif rounded:
                # Beside what is found so little is in its last digits, and no other number.
                numbers = {_parameter(f.names[0]) for f in self.findings if f.names}
                causes = [e for e in causes if _parameter(e.name) in numbers]
            if not causes and not rounded and ENOUGH <= len(plain) < len(wrong):
                of_plain = self._found(stage, plain, _plain(good), checks, False)
                causes = [e for e in of_plain if _is_telling(e)]
                of_most = bool(causes)
        broken, same = 0, causes[:4]
        if causes and worst >= FINE:  # so little neither breaks a stage nor mends one
            broken, same = self._least_harm(causes, stage, good)
        if broken and len(wrong) < fits.FIRST:
            same = []  # what others contradict is not told by a scene or two
        if not same:
            more, remedy = CUT_OFF if cut_off else "", None
            if cut_off:
                self.amplified.add(stage)
            if searched and stage in ("pitch", "flight"):
                chosen = [t for t, _ in evenly(wrong, SOUGHT)]
                more = fits.scene_by_scene(Sought(chosen, (), (stage,), self.base, self.work))
                remedy = FIXED_AXIS if scenes == TURNED else None
                if self.order is not None:
                    more += OF_ORDER.format(self.order)
                elif not more and not scenes:
                    more = MAYBE_STEPS if worst < 1e-4 else ""
                    remedy = None if self.dt else IN_STEPS
            added = {"sentence": told.sentence + more, "remedy": remedy}
            self.findings.append(told.model_copy(update=added))
            self._leave(stage, wrong)
            return False
        same = _without_others(same)
        best, alone = same[0], broken > 0 or of_most
        if best is relations.SINGLE and any(best.name in f.names for f in self.findings):
            self.excused.add(stage)
            self._followed = None
            return False
        if rounded and not alone:
            self._accept(best, stage, worst)
            self._followed = None
            return True
        sentence = told_together([e.sentence for e in same])
        if of_most:
            sentence = (
                f"in all {len(plain)} scenes that leave the readings as they are: {sentence}; what "
                f"is wrong in {len(wrong) - len(plain)} with other readings this does not explain"
            )
        elif alone:
            where = f", where {told.scenes}" if told.scenes else ""
            sentence = f"{stage} alone{where}: {sentence}"
        names = list(dict.fromkeys(e.name for e in same))
        other: dict[str, Any] = {}
        if of_most:
            part, whole = (sum(size_of(c) for _, cs in s for c in cs) for s in (plain, wrong))
            other["share"] = (1 - best.left) * part / whole
        elif best.change is not None and not alone:
            other["scenes"] = None  # the explanation tells them
        self.findings.append(_with_name(told, best, names=names, sentence=sentence, step=best.step,
                                        stage=best.stage or stage, **other))  # fmt: skip
        self.begun.setdefault(stage, worst)
        if best.stage:
            self.moved[stage] = best.stage
        if alone:
            self.excused.add(stage)
            self._leave(stage, wrong)
        else:
            self._accept(best, stage, worst)
        self._followed = None
        return True

    def _is_own(self, wrong: Seen, good: Seen, failures: int) -> bool:
        """Tell whether errors, in `failures` scenes, are those of flights with what is found."""
        seen = len(wrong) + len(good)
        few = ONE_IN * len(wrong) <= seen
        # A scene passes a jump where a flight is sensitive to it, or a scheme its own start.
        if self.jumps:
            return few
        if isinstance(self.base.engine, FixedStep):
            return ONE_IN * failures <= seen
        if not self.begun:
            return False
        worst = max((size_of(c) for _, cs in wrong for c in cs), default=0.0)
        if not all(_keen(t) or _is_wild(t) for t, _ in wrong):
            return few and worst < max(FINE, LAST * min(max(self.begun.values()), 1.0))
        # A graze makes of an error its square root.
        keen = len(wrong) + sum(_keen(t) for t, _ in good)
        return worst * worst < FAINT or ONE_IN * (len(wrong) - 1) <= keen

    def _found(
        self, stage: str, wrong: Seen, good: Seen, checks: Seen, told_apart: bool
    ) -> list[Explanation]:
        """Return the best of what explains a stage, and what does so as well."""
        # What explains errors must not be contradicted by scenes that pass, unless a rule tells
        # these from the others.
        good = [] if told_apart else good
        beside = evenly(_plain(good), SOUGHT)
        some = self._explanations(stage, wrong, good, beside, checks)
        found = [e for one in some if (e := replace(one, left=one.left + one.against)).named]
        named = [e for e in sorted(found, key=lambda e: (e.left, e.rank))
                 if e.change is None or not self._contradicted(e.change, wrong, good)]  # fmt: skip
        named = named or self._but_for(some, stage, wrong, good)
        if not named:
            return []
        alike, doubt = ALIKE * named[0].left, doubt_of(wrong)
        ties = [
            e for e in named
            if e.left <= max(alike, DOUBT_OF_STEPS if e.step and e.change else doubt)
        ]  # fmt: skip
        ties = self._told_from_ties(ties, stage, wrong)
        if len(ties) > 1:  # one reading says more than all of them
            ties = [e for e in ties if e.name != misreadings.ALL_READINGS]
        by_sentence = {e.sentence: e for e in reversed(ties)}
        return sorted(by_sentence.values(), key=lambda e: e.rank)

    def _but_for(
        self, some: Iterable[Explanation], stage: str, wrong: Seen, good: Seen
    ) -> list[Explanation]:
        """Return an explanation that trials which pass contradict, if a rule tells those."""
        explain = [e for e in some if e.change is not None and e.named and not fits.is_odd(e)]
        if not explain or len(wrong) < FEWEST:
            return []
        best = min(explain, key=lambda e: (e.left, e.rank))
        full = self.base.then(best.change or NONE)
        spared = [t.case for t, _ in evenly(good, PASSING) if any(
            c.stage == stage and not c.follows for c in follow(t, full, (stage,)))]  # fmt: skip
        where = rule(spared, [t.case for t, _ in wrong])
        if where is None:
            return []
        return [replace(best, sentence=f"{best.sentence}, but not in scenes with {where}")]

    def _told_from_ties(
        self, ties: list[Explanation], stage: str, wrong: Seen
    ) -> list[Explanation]:
        """Return those that are best where they make different scenes; all, if they nowhere do."""
        changes = [self.base.then(e.change) for e in ties if e.change is not None]
        if len(ties) < 2 or len(changes) < len(ties):
            return ties
        differ = []
        for t, _ in wrong:
            first, *others = (change.scene(t.scene) for change in changes)
            if any(scene != first for scene in others):
                differ.append(t)
        some, lefts = evenly(differ, OTHERS), list[float]()
        for change in changes:
            checks = [c for t in some for c in follow(t, change, (stage,)) if c.stage == stage]
            lefts.append(sum(size_of(c) for c in checks if not c.follows))
        best = min(lefts)
        return [e for e, left in zip(ties, lefts, strict=True) if left <= best + IN_A_SCENE]

    def _contradicted(self, change: Change, wrong: Seen, good: Seen) -> bool:
        """Tell whether trials tell rightly, besides numbers, what a change would not make."""
        # Most of those with errors, or of those without that are told the same.
        full = self.base.then(change)
        alike: dict[str, list[tuple[Trial, dict[str, object]]]] = defaultdict(list)
        for t, checks in (*wrong, *good):
            facts = {n: x for n, x in t.told.items() if n in MADE}
            if facts and not untrue(t.case.expected, facts):
                fails = any(not c.follows for c in checks)
                alike["" if fails else repr(facts)].append((t, facts))
        return any(
            2 * sum(outcomes.made_otherwise(t, full, facts) for t, facts in some) > len(some)
            for some in (evenly(known, OTHERS) for known in alike.values())
        )

    def _least_harm(
        self, found: Sequence[Explanation], stage: str, good: Seen
    ) -> tuple[int, list[Explanation]]:
        """Return those that the other stages bear out best, and how many checks they break."""
        others = [*self._elsewhere(stage), *evenly(good, SOUGHT)]
        effects = [self._effect(e, stage, [*others, *_moved(e, good)]) for e in found[:6]]
        broken = min(b for b, _ in effects)
        mended = max(m for b, m in effects if b == broken)
        same = [e for e, effect in zip(found, effects, strict=False) if effect == (broken, mended)]
        return broken, same[:4]

    def _effect(self, e: Explanation, stage: str, others: Iterable[Checked]) -> tuple[int, int]:
        """Return how many checks an explanation breaks, and how many of other stages it mends."""
        if e.change is None or isinstance(e.change.engine, Verlet):
            return 0, 0
        full, broken, mended = self.base.then(e.change), 0, 0
        for trial, checks in others:
            known = {(c.stage, c.quantity): c.follows for c in checks}
            for c in follow(trial, full, {s for s, _ in known}):
                before = known.get((c.stage, c.quantity))
                fine = c.error <= max(c.tolerance, FINE * c.scale)
                broken += before is True and not fine
                mended += before is False and fine and c.stage != stage
        return broken, mended

    def _elsewhere(self, stage: str) -> Iterator[Checked]:
        """Yield a few trials of each kind, by reading and by whether other stages have errors."""
        kinds: dict[tuple[str, str, bool], list[Checked]] = defaultdict(list)
        for trial, checks in self._follow():
            fails = any(c.stage != stage and not c.follows for c in checks)
            kinds[trial.scene.kind, repr(trial.scene.reading), fails].append((trial, checks))
        for some in kinds.values():
            yield from evenly(some, OTHERS)

    def _accept(self, best: Explanation, stage: str, worst: float) -> None:
        """Make an explanation part of the chain, or mend the quantity that it is in."""
        # What is computed wrongly is mostly used so; what is only written wrongly is mended.
        if best.mend is not None:
            self.trials = [best.mend(t) for t in self.trials]
        elif best.stage == "plate":
            # Where a pitch ends says nothing of other flights, nor of the ball's later velocity.
            self.excused |= {stage, "plate"}
            self.trials = [
                replace(t, given={n: x for n, x in t.given.items() if n != "plate.velocity"})
                for t in self.trials
            ]
        elif best.change is not None:
            self.jumps |= best.allowed > NAMED
            self.base, self._raw = self.base.then(best.change), {}
            if isinstance(best.change.engine, Verlet):
                # Where steps find the bat is the scheme's, and what is computed there inherits it.
                self.excused.add("touching")
                steps = [duration(t.case) / best.change.engine.dt for t in self.trials]
                self.trials = evenly(self.trials, max(SOUGHT, int(MOST_STEPS / median(steps))))
                for t in self.trials:
                    self.loose[t.case.id] = max(worst, self.loose.get(t.case.id, 0.0))
        elif best.value is None or best.quantity is None:
            self.excused.add(best.quantity or stage)
        else:
            mended = [self._mended(t, cs, best) for t, cs in self._follow()]
            self.excused.add(best.quantity)
            if best.quantity == "landing.position":
                self.excused.add("landing.velocity")
            self._followed = None
            plain, self.trials, as_it_is = self._failing(), mended, self.trials
            self._followed = None
            if self._failing() >= plain:
                self.trials = as_it_is

    def _mended(self, trial: Trial, checks: Sequence[Check], best: Explanation) -> Trial:
        """Return a trial with the right value of a quantity, but for what is left unexplained."""
        assert best.quantity is not None
        assert best.value is not None
        check = next((c for c in checks if c.quantity == best.quantity), None)
        said, wrong = trial.given.get(best.quantity), best.value(trial)
        if check is None or said is None or wrong is None:
            return trial
        if not len(said) == len(wrong) == len(check.expected):
            return trial
        if check.follows and math.dist(said, check.expected) <= math.dist(said, wrong):
            return trial
        value = tuple(e + s - w for e, s, w in zip(check.expected, said, wrong, strict=True))
        return trial.saying({best.quantity: value})

    def _failing(self) -> int:
        """Return how many checks fail."""
        # Values from which nothing can be computed fail in everything.
        checks = [cs for _, cs in self._follow()]
        failing = sum(not c.follows and c.error > FINE * c.scale for cs in checks for c in cs)
        return failing + len(STAGES) * sum(not cs for cs in checks)

    # --- explanations ---------------------------------------------------------------------------

    def _explanations(
        self, stage: str, wrong: Seen, good: Seen, beside: Seen, checks: Seen
    ) -> list[Explanation]:
        """Return explanations, the cheap ones first, until some are named."""
        wrong = [one for one in wrong if all(map(_known, one[1])) and not (
            _keen(one[0]) or _is_wild(one[0]))] or wrong  # fmt: skip
        chosen = evenly(wrong, SOUGHT)
        right = evenly([t for t, _ in good if not _keen(t)], BESIDE)
        sought = Sought([t for t, _ in chosen], right, (stage,), self.base, self.work)
        flies, ends = stage in ("pitch", "flight"), stage in ("plate", "landing")
        if stage == "pitch":
            together = self._with_flights(wrong, right, checks)
        else:
            together = self._with_push(wrong, right, checks) if stage == "impulse" else None
        found = [*relations.singles(wrong)]
        if found:
            return found
        ratios = partial(relations.relations, chosen, beside, self.base)
        at_surface = partial(clocks.beside_surface, stage, wrong)
        ways: list[Callable[[], Iterable[Explanation]]]
        if max(size_of(c) for _, cs in wrong for c in cs if not c.follows) < FINE:
            ways = [lambda: [*ratios(), *(at_surface() if ends else ())],
                    *(partial(_fine, some) for some in (together, sought) if some)]  # fmt: skip
        else:
            ways = [
                lambda: [*ratios(), *relations.formulas(chosen, beside, self.base),
                         *relations.resolutions(chosen), *self._own_of(stage, wrong, chosen)],
                *([partial(fits.parts, together)] if together else []),
                partial(fits.parts, sought),
            ]  # fmt: skip
            ways += [at_surface] if ends else []
            ways += self._of_flights(stage, wrong, sought, together, found) if flies else []
            if stage == "touching":
                ways.append(partial(clocks.reaches, wrong, self.base))
                seen = [[c.follows for c in cs if c.stage == stage] for _, cs in checks]
                if 2 * sum(map(all, seen)) < len(seen):  # steps leave few right
                    ways.append(partial(clocks.contacts_at_steps, wrong))
            if stage == "restitution":
                ways.append(lambda: fits.one_after_another(sought, found))
        for number, way in enumerate(ways):
            found += way()
            # A known mistake in the collision may be behind a formula's.
            if any(e.named for e in found) and (number or stage not in COLLISION):
                break
        return found

    def _own_of(self, stage: str, wrong: Seen, chosen: Seen) -> Iterator[Explanation]:
        """Yield explanations that are of one stage alone."""
        match stage:
            case "restitution":
                yield from relations.by_speed(chosen, self.base)
            case "landing" | "plate":
                yield from clocks.ends(stage, chosen, self.trials, self.dt)
            case "landing velocity":
                yield from clocks.between_steps(stage, wrong, self.base)
                yield from clocks.velocities_of_another_time(wrong, self.base)
            case "fence":
                yield from clocks.fences(wrong, self.base)
            case "touching":
                yield from clocks.touchings(wrong, self.base)
            case "pitch" | "flight":
                yield from clocks.clocks(stage, chosen, self.base)

    def _of_flights(
        self, stage: str, wrong: Seen, sought: Sought, together: Sought | None,
        found: Sequence[Explanation],
    ) -> list[Callable[[], Iterable[Explanation]]]:  # fmt: skip
        """Return ways to explain flights that no single change of the chain does."""
        both = together or sought

        def in_steps() -> Iterable[Explanation]:
            known = self.dt or clocks.grid(stage, self.trials)
            chords = [*clocks.on_chords(sought.some(4), self.base, known)]
            own = chords if any(e.named for e in chords) else [
                *chords, *schemes(sought, known, self.order)]  # fmt: skip
            # What flies the pitch flies the batted ball.
            self.stepless = not any(e.named for e in own)
            return own

        def two() -> Iterable[Explanation]:
            single = list({e.name: e for e in reversed(found)}.values())[::-1]
            pairs = [*fits.two(both, single)]
            if together and not any(e.named for e in pairs):
                # Pitches alone are alike: any two numbers explain them, but not any scheme.
                some = fits.two(sought, single)
                pairs += (e for e in some if e.change and e.change.engine != NONE.engine)
            return pairs

        steps = [] if self.scheme is not None or self.stepless else [in_steps]
        return [
            *steps, partial(fits.mostly, both), two,
            partial(clocks.between_steps, stage, wrong, self.base),
        ]  # fmt: skip

    def _with_push(self, wrong: Seen, right: Trials, checks: Seen) -> Sought | None:
        """Return impacts with friction that are wrong in more: one explanation for all of it."""
        more = {id(t) for t, cs in checks if any(
            c.stage in PUSHED[1:] and not c.follows for c in cs)}  # fmt: skip
        some = [t for t, _ in wrong if id(t) in more and t.scene.bat.friction is not None]
        if len(some) < ENOUGH:
            return None
        return Sought(evenly(some, SOUGHT), right, PUSHED, self.base, self.work)

    def _with_flights(self, wrong: Seen, right: Trials, checks: Seen) -> Sought | None:
        """Return pitches and batted balls, which fly by one law: one explanation for both."""

        def wrongly(c: Check) -> bool:
            return c.stage == "flight" and not c.follows and _known(c)

        flying = [(t, cs) for t, cs in checks if not _keen(t) and any(map(wrongly, cs))]
        if not flying:
            return None
        some = evenly(wrong, SOUGHT // 2) + evenly(flying, SOUGHT // 2)
        return Sought([t for t, _ in some], right, ("pitch", "flight"), self.base, self.work)


def _with_name(told: Finding, e: Explanation, **more: Any) -> Finding:
    """Return what is told of a stage with the explanation of its errors."""
    said = {"names": [e.name], "sentence": e.sentence, "remedy": e.remedy, "share": 1 - e.left}
    return told.model_copy(update={"kind": "named", **said, **more})


def _not_alone(findings: Sequence[Finding]) -> list[Finding]:
    """Return findings without "alone" where several stages have the same."""
    stages: dict[str, list[str]] = defaultdict(list)
    for f in findings:
        if f.names:
            stages[f.names[0]].append(f.stage)
    result = []
    for f in findings:
        several = stages[f.names[0]] if f.names else []
        if len(several) > 1:
            others = [stage for stage in several if stage != f.stage]
            where = f"{f.stage}, as at {' and '.join(dict.fromkeys(others))}"
            sentence = f.sentence.replace(f"{f.stage} alone", where, 1)
            f = f.model_copy(update={"sentence": sentence})
        result.append(f)
    return result


def _parameter(name: str) -> str:
    """Return what a fitted number is of, from its name."""
    return re.split("[=*+]", name)[0]


def _without_others(same: Sequence[Explanation]) -> list[Explanation]:
    """Return explanations that come to the same, each name once, a factor of k as that first."""
    by_name: dict[str, Explanation] = {}
    for e in same:
        by_name.setdefault(e.name, e)
    ranked = list(by_name.values())
    strength = next((e for e in ranked if e.name.startswith(STRENGTH)), None)
    if strength is None:
        return ranked
    # Nobody chooses a mass that is nearly the right one; a rounder factor may be the mistake.
    nearly = abs(float(strength.name.removeprefix(STRENGTH)) - 1) < fits.NEARLY
    least = -math.inf if nearly else strength.rank
    others = (e for e in ranked if e is not strength and not fits.is_odd(e))
    kept = [e for e in others if not e.name.startswith("ball.") or e.rank < least]
    return sorted([strength, *kept], key=lambda e: "=" not in e.name)  # numbers before factors


def _moved(e: Explanation, good: Seen) -> list[Checked]:
    """Return some of the trials that pass whose scenes an explanation changes."""
    if e.change is None:
        return []
    changed = e.change.scene
    return evenly([one for one in good if changed(one[0].scene) != one[0].scene], OTHERS)


def _keen(trial: Trial) -> bool:
    """Tell whether a trial answers to the last digits of what is computed."""
    return not KEEN.isdisjoint(trial.case.flags)


WILD = 1e3  # so many times the true size a value is of a ball that a wrong law drives on


def _is_wild(trial: Trial) -> bool:
    """Tell whether a trial gives a value beyond all measure: then its flight tells nothing."""
    true = trial.expected
    return any(math.hypot(*value) > WILD * (1 + math.hypot(*true[name]))
               for name, value in trial.given.items() if name in true)  # fmt: skip


def _known(check: Check) -> bool:
    """Tell whether it is known what follows: a path may end before a candidate's does."""
    return all(map(math.isfinite, check.expected))


def _fine(sought: Sought) -> Iterator[Explanation]:
    """Yield the numbers, one or two, that may be behind errors that are mostly an integrator's."""
    for way in (fits.singles(sought), fits.fitted(sought), fits.pairs(sought, ())):
        found = [*way]
        yield from found
        if any(e.named for e in found):
            return


def _absent(trial: Trial) -> str | None:
    """Return the stage of the first quantity that a trial leaves out; None if it is a landing."""
    # No ball lands that the fence stops, or that stays in the air, whatever is wrong with that.
    first = next((name for name in trial.expected if name not in trial.given), "landing")
    return None if first.startswith("landing") else stage_of(first)


def _where_made(
    rows: Iterable[StageRow], moved: Mapping[str, str], known: Collection[str],
    facts: Iterable[Finding]
) -> list[StageRow]:  # fmt: skip
    """Return the rows of stages with the errors of each at the one where they are made."""
    # A landing by a wrong clock is on the true path, and not where the ball is then: `moved` tells
    # such stages, `known` those with a finding. Wrong is also one at which `facts` are.
    by_stage = {row.stage: row for row in rows}
    for stage, made in moved.items():
        if row := by_stage.get(stage):
            by_stage[made] = row.model_copy(update={"stage": made})
            if stage not in known:
                by_stage[stage] = row.model_copy(update=RIGHT)
    for fact in facts:
        row = by_stage.get(fact.stage)
        if row is None and fact.stage in STAGES:
            row = StageRow(stage=fact.stage, checked=fact.checked, wrong=0, worst=0.0, example=None)
        if row is not None and row.wrong < fact.wrong:
            worse = {"wrong": fact.wrong, "worst": fact.worst, "example": fact.example}
            by_stage[fact.stage] = row.model_copy(update=worse)
    return [by_stage[stage] for stage in STAGES if stage in by_stage]


def _told_apart(seen: Seen, sizes: Sequence[float], minor: float) -> str | None:
    """Return a rule of the scenes with errors, or of those with errors that are not minor."""
    # Where a value is 0, an error in proportion does not show.
    known = [(t.case, size) for (t, cs), size in zip(seen, sizes, strict=True)
             if size or any(any(c.expected) for c in cs)]  # fmt: skip
    for least in (0.0, minor):
        wrong = [case for case, size in known if size > least]
        # How large an error is goes with how large a number is, and tells no cause apart.
        if found := rule(wrong, [case for case, size in known if size <= least], least == 0.0):
            return found
    return None


def _plain(checked: Seen) -> list[Checked]:
    """Return those of scenes that leave the readings as they are."""
    return [one for one in checked if one[0].scene.reading == Reading()]


def _is_telling(e: Explanation) -> bool:
    """Tell whether an explanation says more than a number that any error makes."""
    # Where all scenes have the same bat, there is a ratio, and a mass, for every mistake.
    quantity, _, ratio = e.name.partition("*")
    any_ratio = quantity == e.quantity and fits.factor_meaning(float(ratio or "nan")) is None
    return not any_ratio and not fits.is_odd(e)


def _unknown(
    stage: str, quantities: Collection[str], sizes: Sequence[float], minor: float, rest: bool
) -> str:
    """Return what is said where nothing explains errors of these sizes in some quantities."""
    worst, wrong = max(sizes), sum(size > minor for size in sizes)
    sentence = f"{'what is left at ' if rest else ''}{stage}: "
    sentence += f"{next(iter(quantities))} is " if len(quantities) == 1 else ""
    sentence += f"wrong by up to {worst:.1e} of the quantity in {many(wrong, 'scene')}"
    if smaller := sum(0 < size <= minor for size in sizes):
        sentence += f" (in {smaller} more by less than {minor:.0e})"
    sentence += ", and none of the known mistakes or fitted numbers explains it"
    return sentence


def _usual(sizes: Iterable[float]) -> float:
    """Return the relative error, at most 1, that only three in a hundred that have one exceed.

    A few scenes, such as grazes, make any error a thousand times as large; and an integrator that
    errs faintly in all of them is no measure of a mistake in a few, which is among the largest.
    """
    known = [min(size, 1.0) for size in sizes if size]
    errors = [size for size in known if size > FAINT] or known
    return float(np.quantile(errors, 0.97, method="higher")) if errors else 0.0


def _minor(sizes: Sequence[float]) -> float:
    """Return the relative error that is small beside the others at a stage."""
    minor = MINOR * _usual(sizes)
    large = sum(size > minor for size in sizes)
    small = sum(FINE < size <= minor for size in sizes)
    # A scene or two that turn on any error are no measure of the others.
    return 0.0 if large < fits.FIRST <= small else minor


def _largest(checks: Seen) -> float:
    """Return the usual relative error of the stage that has the largest."""
    sizes: dict[str, list[float]] = defaultdict(list)
    for _, seen in checks:
        for check in seen:
            if not check.follows:
                sizes[check.stage].append(size_of(check))
    return max(map(_usual, sizes.values()), default=0.0)


def _row(stage: str, checks: Iterable[Checked]) -> StageRow | None:
    seen = [(t.case.id, c) for t, cs in checks for c in cs if c.stage == stage]
    if not seen:
        return None
    bad = [(c.error / c.scale, name) for name, c in seen if not c.follows]
    worst, example = max(bad, key=lambda one: one[0], default=(0.0, None))
    counts = {"checked": len({name for name, _ in seen}), "wrong": len({name for _, name in bad})}
    return StageRow(stage=stage, **counts, worst=worst, example=example)
