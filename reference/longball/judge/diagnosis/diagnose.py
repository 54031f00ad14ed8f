"""The diagnosis of a candidate, from its answers to findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from longball.engines.verlet import Verlet
from longball.judge.answers import Answer
from longball.judge.cases import Case
from longball.judge.diagnosis import sentences
from longball.judge.diagnosis.chain import CHAIN, CHAIN_IN_STEPS, Kind, Stage
from longball.judge.diagnosis.clocks import Scheme
from longball.judge.diagnosis.digits import explain_digits, with_digits
from longball.judge.diagnosis.evidence import FEWEST, is_adequate
from longball.judge.diagnosis.expression import contains, ordered, substitute
from longball.judge.diagnosis.findings import Diagnosis, Finding
from longball.judge.diagnosis.integrators import BATTED, Way, in_steps, straight
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.outcomes import outcome_findings
from longball.judge.diagnosis.outputs import outputs
from longball.judge.diagnosis.residual import (
    Data,
    Followed,
    Index,
    begun,
    compared,
    data_of,
    follow,
    seen,
    specialised_to,
)
from longball.judge.diagnosis.scenes import rule
from longball.judge.diagnosis.schemes import Steps, explain_push, explain_scheme, with_edit
from longball.judge.diagnosis.search import ALONE, PAIRS, WRONG, Explanation, Located, Named
from longball.judge.diagnosis.unseen import Solve, Unseen


@np.errstate(all="ignore")  # a wrong number may be of any size
def diagnose(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    dt: float | None = None,
    *,
    scheme: Verlet | None = None,
    causes: bool = True,
    granted: float = 0.0,
    solve: Solve | None = None,
) -> Diagnosis:
    """Explain what is wrong with a candidate's answers to cases.

    Parameters
    ----------
    cases, answers
        Scenes with a truth that doubles can decide, and the candidate's answers by id.
    dt
        The candidate's time step, s; None if it is unknown.
    scheme
        The engine whose results count as true, if these are not the exact ones.
    causes
        False to locate errors only, for example if the answers change from run to run.
    granted
        The largest error that passes, in the SI unit of each quantity.
    solve
        Function that runs the candidate in new scenes, in which every name has to hold.
    """
    known = [case for case in cases if (answer := answers.get(case.id)) and answer.error is None]
    # Numbers are compared only where the outcome is right: a missed ball has no landing.
    same = [case for case in known if answers[case.id].outcome in (None, case.expected.outcome)]
    if not causes:
        plain, chain = prepared(same, answers, scheme, granted)
        data = with_digits(plain, answers)
        _, first = follow(chain, data)
        return sentences.diagnosis(first, [*map(_locating(data), filter(_is_wrong, first))], data)
    made = conclude(same, answers, dt, scheme, granted, solve)
    found = [*made.outputs, *(_finding(step, made.mended) for step in made.steps)]
    if made.digits is not None:
        found = [sentences.digits(made.digits, made.first, made.mended)]
    # Outcomes need the columns of all scenes: also of those in which the outcome is wrong.
    every = replace(data_of(known, answers, granted), flights=made.data.flights)
    columns, _ = follow(specialised_to(every), every)
    stages = {finding.stage for finding in found}
    found += outcome_findings(known, answers, columns, stages)
    found.sort(key=lambda finding: finding.kind != "named")
    # Errors may exceed the tolerance and yet be within the noise, which nothing needs to explain.
    # The first wrong stage is then located.
    if not found:
        found = [*map(_locating(made.mended), filter(_is_wrong, made.first))][:1]
    return sentences.diagnosis(made.first, found, made.mended)


@dataclass(frozen=True)
class Conclusion:
    """Everything that explains a candidate's numbers.

    Attributes
    ----------
    first
        Residuals of the stages before any edit.
    mended
        The data with outputs converted back.
    outputs
        Findings of those conversions.
    digits
        The style in which the candidate writes numbers, if it explains all errors.
    steps
        The wrong stages in the order of their explanation.
    chain, data
        The chain with all named edits, and the data with all named schemes.
    """

    first: Sequence[Followed]
    mended: Data
    outputs: Sequence[Finding]
    digits: str | None
    steps: tuple[Step, ...]
    chain: tuple[Stage, ...]
    data: Data


def conclude(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    dt: float | None = None,
    scheme: Verlet | None = None,
    granted: float = 0.0,
    solve: Solve | None = None,
) -> Conclusion:
    """Explain a candidate's numbers in cases with a right outcome; see `diagnose`."""
    plain, chain = prepared(cases, answers, scheme, granted)
    data = with_digits(plain, answers)
    _, first = follow(chain, data)
    unseen = None if solve is None else Unseen(data, chain, solve, scheme)
    # Outputs come first: in a wrong unit they are wrong at every stage that uses them.
    mended, found = outputs(data, chain)
    converted = unseen.converted(found) if unseen and found else unseen
    if unseen and not converted:  # new scenes refute the conversions
        mended, found, converted = data, [], unseen
    reasoned = reason(mended, chain, dt, converted)
    # An input in a wrong unit may look like several outputs in wrong units. Unless one conversion
    # explains everything, compare with an explanation without conversions: fewer steps win.
    if found and (reasoned.unexplained or len(reasoned.steps) + len(found) > 1):
        other = reason(data, chain, dt, unseen)
        counts = [(x.unexplained, len(x.steps) + extra) for x, extra in
                  ((other, 0), (reasoned, len(found)))]  # fmt: skip
        if counts[0] < counts[1]:
            mended, found, reasoned = data, [], other
    # Digits come last: if rounded numbers still show a mistake, this is the better explanation.
    digits = None
    if not found and not any(step.explained for step in reasoned.steps):
        digits = explain_digits(chain, plain, answers, lambda: unseen is None or unseen.follows)
        if digits is not None:  # report the errors without an allowance for the digits
            _, first = follow(chain, plain)
    return Conclusion(first, mended, found, digits, reasoned.steps, reasoned.chain, reasoned.data)


def prepared(
    cases: Sequence[Case],
    answers: Mapping[str, Answer],
    scheme: Verlet | None = None,
    granted: float = 0.0,
) -> tuple[Data, tuple[Stage, ...]]:
    """Answers as columns, and the chain for comparison with them."""
    data = data_of(cases, answers, granted)
    if scheme is not None:
        data = in_steps(data, scheme)
    chain = specialised_to(data, CHAIN if scheme is None else CHAIN_IN_STEPS)
    return seen(chain, data), chain


# --- stage by stage -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Step:
    """A stage that was wrong, and its explanation."""

    followed: Followed
    found: Named | Located | Scheme

    @property
    def explained(self) -> bool:
        """True if the cause is named."""
        if isinstance(self.found, Scheme):
            return self.found.adequate
        return isinstance(self.found, Named)

    @property
    def way(self) -> Way | None:
        """The way of the candidate's flight, if it is named."""
        return self.found.way if isinstance(self.found, Scheme) and self.explained else None

    @property
    def is_applied(self) -> bool:
        """True if later stages are followed with the explanation."""
        return isinstance(self.found, Named) or self.way is not None


@dataclass(frozen=True)
class Reasoned:
    """The chain with every edit that was named, and the stages in the order of explanation.

    Attributes
    ----------
    data
        The data with every scheme that was named.
    """

    chain: tuple[Stage, ...]
    data: Data
    steps: tuple[Step, ...]

    @property
    def unexplained(self) -> int:
        """Number of stages whose cause is not named."""
        return sum(not step.explained for step in self.steps)


# Limits of an explanation: free choices.
# The number of a named edit is rounded, which may show in a few scenes: errors below the fraction
# LAST of a stage's first errors are not explained further. A later stage may be more precise than
# the one to which the number was fitted: nor are relative errors below SPREADS times its spread.
LAST, SPREADS = 1e-7, 10.0
# A later flight is explained before the first wrong one if it tells more by this factor.
CLEARER = 2.0
ENOUGH = WRONG  # wrong scenes: a screening uses no more
ROUNDS = 3  # explanations of one stage; each explains the rest of the one before


def reason(
    data: Data,
    chain: tuple[Stage, ...],
    dt: float | None = None,
    unseen: Unseen | None = None,
) -> Reasoned:
    """Explain the candidate's errors stage by stage.

    A named edit is applied to the chain, so that later stages inherit the mistake. After a stage
    that is only located, later stages continue from the candidate's own values. A name that
    `unseen` scenes refute is withdrawn.
    """
    columns, last = follow(chain, data)
    steps: list[Step] = []
    # By the key of a stage: its formulas without edits, the scenes that were wrong at first, the
    # largest error, and the number of explanations tried.
    unedited = {stage.key: stage for stage in chain}
    at_first = {one.stage.key: one.some[one.beyond] for one in last}
    errors = {one.stage.key: _largest(one) for one in last}
    tried: Counter[tuple[str, Kind]] = Counter()
    while True:
        named = (edit for s in steps if isinstance(s.found, Named) for edit in s.found.edits)
        spread = SPREADS * max((edit.spread for edit in named), default=0.0)
        wrong = [
            (stage, one)
            for stage, one in zip(chain, last, strict=True)
            if _largest(one) > max(LAST * errors[stage.key], spread)
            and tried[stage.key] < ROUNDS
            and not (stage.name in data.rough and _is_left(one, at_first[stage.key]))
        ]
        if not wrong:
            standing = _standing(steps, last)
            if unseen is not None:
                standing = _confirmed(standing, chain, data, unseen, dt)
            return Reasoned(chain, data, standing)
        stage, one = _clearest(wrong)
        at = stage.key
        tried[at] += 1
        errors[at] = max(errors[at], _largest(one))
        # If no edit explains the law on the way to the fence, none will on the way to the ground.
        if any(_is_same_flight(stage, s.followed.stage) for s in steps if not s.is_applied):
            tried[at] = ROUNDS
            continue
        # A candidate that makes no other mistake here may use another form of the formula, or may
        # have made a mistake that is named already in other places.
        forms = (*_other_forms(stage), *_edited_in_part(stage, unedited[at], steps))
        if (form := _right_form(forms, data, columns, one)) is not None:
            chain = tuple(form if other is stage else other for other in chain)
            columns, last = follow(chain, data)
            continue
        found = [
            Step(one, cause)
            for cause in _explained(chain, stage, data, columns, one, steps, dt, unseen)
        ]
        # An edit that leaves right numbers right is no mistake. It is a form whose numbers differ
        # only because those before them are wrong.
        edits = found[0].found.edits if isinstance(found[0].found, Named) else ()
        if edits and _is_another_form(edits, unedited[at], data, one):
            chain, data = _with_edits(edits, chain, data)
            columns, last = follow(chain, data)
            continue
        for step in found:
            if isinstance(step.found, Named):
                chain, data = _with_edits(step.found.edits, chain, data)
            elif step.way is not None:
                data = _with_way(step.way, stage, chain, data, columns)
        # A stage gets another round after an edit or a push. Any other explanation closes it.
        if not (isinstance(step.found, Named) or (step.way is not None and step.way.push)):
            tried[at] = ROUNDS
        if any(step.is_applied for step in found):
            columns, last = follow(chain, data)
        # If an edit also mends an earlier flight, report the mistake there: it explains all errors
        # of that flight.
        right, earlier = _right(last), wrong[: wrong.index((stage, one))]
        mended = next((other for s, other in earlier if s.key in right), None)
        for step in found:
            if isinstance(step.found, Named) and mended is not None:
                step = Step(mended, replace(step.found, mends=None))
            steps.append(step)


def _explained(
    chain: tuple[Stage, ...],
    stage: Stage,
    data: Data,
    columns: Mapping[str, Any],
    one: Followed,
    steps: Sequence[Step],
    dt: float | None,
    unseen: Unseen | None,
) -> Sequence[Named | Scheme | Located]:
    """The causes of a stage's errors: the first of these that there are.

    1. A push: the paper's contact force acts before the contact, which no edit of the batted flight
       can express.
    2. An edit, or two, found among the scenes that share an option with all wrong ones: there are
       fewer formulas, and so fewer edits.
    3. An edit, or two, that explain all errors.
    4. A scheme, of all flights or of a part of them.
    5. An edit of a part of the errors.
    6. An edit together with a scheme.
    7. Nothing: then the stage is located, with the nearest edit or the order of the errors.
    """
    push = explain_push(stage, data, columns, one)
    if push is not None:
        return [push]

    # If a part of the errors is explained, the search for the rest has a smaller budget. All
    # flights share one law.
    in_steps, flies = data.way(stage) is not None, stage.kind == "flight"
    edited, stepped = (
        [s.followed.stage for s in steps if isinstance(s.found, kind) and s.found.mends is not None]
        for kind in (Named, Scheme)
    )
    rest = in_steps or any(_shares_formula(stage, other) for other in edited)
    if rest and one.beyond.sum() < FEWEST:  # too few scenes to identify another mistake
        return [Located()]
    # If no edit explains one flight, hardly any explains the next.
    located = [s.followed.stage for s in steps if isinstance(s.found, Located)]
    again = rest or any(_shares_formula(stage, other) for other in located)
    layers, pairs = (ALONE[:2], 0) if again else (ALONE, PAIRS[stage.kind])
    search = Explanation(chain, stage, data, columns, one, layers, pairs)
    if not rest and (conditional := search.of_one_option()) is not None:
        return [conditional]
    # If a scheme explains only some flights, the remaining errors belong to the scheme, and not to
    # the law.
    found = Located() if flies and stepped else search.explain(unseen)
    if isinstance(found, Named) and found.mends is None:
        return [found]
    scheme = steps_of = None
    if not in_steps:
        steps_of = Steps(stage, data, columns, one)
        scheme = explain_scheme(chain, stage, data, columns, one, dt, steps_of)
    if scheme is not None and scheme.adequate:
        return [scheme]
    if isinstance(found, Named):
        return [found]
    # Edits are searched for with the scheme whose errors are most like the candidate's. A candidate
    # whose right flights have no such errors has no scheme.
    if not rest and flies and steps_of is not None and steps_of.possible:
        like = steps_of.nearest()
        near = _beside(like, chain, stage, data, columns, one) if like else found.near
        both = with_edit(steps_of, near, dt, like)
        if both is not None:
            edit, way = both
            return [Named((edit,), way.evidence), way]
    return [scheme or found]


def _with_edits(
    edits: Sequence[Edit], chain: tuple[Stage, ...], data: Data
) -> tuple[tuple[Stage, ...], Data]:
    """The chain with edits, and the data with the stages that a rough edit changes."""
    for edit in edits:
        before, chain = chain, edit.apply(chain)
        changed = {s.name for s, was in zip(chain, before, strict=True) if s is not was}
        data = replace(data, rough=data.rough.union(changed if edit.rough else ()))
    return chain, data


def _other_forms(stage: Stage) -> Iterator[Stage]:
    """The stage in its other forms.

    Forms agree for right inputs only: those of the normal differ if the ball is not on the bat's
    surface.
    """
    for form in stage.forms.get("value", ()):
        yield replace(stage, roots={"value": form})


def _is_another_form(edits: Iterable[Edit], stage: Stage, data: Data, followed: Followed) -> bool:
    """True if a formula with edits is right for right inputs, in the scenes that are wrong."""
    if stage.kind == "flight":
        return False
    edited = stage
    for edit in edits:
        (edited,) = edit.apply([edited])
    right, some = replace(data, given=data.expected, cut={}, slips=None), followed.beyond
    before, after = (
        compared(one, right, begun(right), followed.some[some])[0] for one in (stage, edited)
    )
    # A scene whose outcome is wrong too has inputs of the candidate.
    known = before.checked & ~before.beyond
    return bool(known.any() and not after.beyond[known].any())


def _edited_in_part(stage: Stage, unedited: Stage, steps: Sequence[Step]) -> Iterator[Stage]:
    """The stage with a named edit in one more formula, or in one formula less.

    A program may write out a definition again where it uses it, so that it errs in one place only.
    """
    for edit in (e for s in steps if isinstance(s.found, Named) for e in s.found.edits):
        for name, root in unedited.roots.items() if stage.kind != "flight" else ():
            for node in ordered([root]):
                if node is not edit.place and contains(node, edit.place):
                    edited, now = substitute(node, edit.place, edit.new), stage.roots[name]
                    for old, new in ((edited, node), (node, edited)):
                        if contains(now, old):
                            changed = {name: substitute(now, old, new)}
                            yield replace(stage, roots={**stage.roots, **changed})


def _right_form(
    forms: Iterable[Stage], data: Data, columns: Mapping[str, Any], one: Followed
) -> Stage | None:
    """The first form of a stage with which all of the candidate's numbers are right."""
    return next(
        (form for form in forms if not compared(form, data, columns, one.some)[0].beyond.any()),
        None,
    )


def _largest(one: Followed) -> float:
    """The largest relative error that is beyond the noise, at most 1; infinite ones count as 1."""
    return float(np.minimum(one.relative[one.beyond], 1.0).max(initial=0.0))


def _is_left(one: Followed, wrong: Index) -> bool:
    """True if a rough edit explains a stage: few errors are left, relative to its wrong scenes."""
    return is_adequate(one.off / one.floor, rough=True, wrong=np.isin(one.some, wrong))


def _clearest(wrong: Sequence[tuple[Stage, Followed]]) -> tuple[Stage, Followed]:
    """The stage to explain next: the first wrong one, or a flight that tells far more.

    All flights share one law. One with `ENOUGH` wrong scenes tells as much as any.
    """

    def tells(both: tuple[Stage, Followed]) -> int:
        return min(int(both[1].beyond.sum()), ENOUGH)

    first = wrong[0]
    most = max((both for both in wrong if both[0].kind == "flight"), key=tells, default=first)
    return most if first[0].kind == "flight" and tells(most) > CLEARER * tells(first) else first


def _right(last: Sequence[Followed]) -> set[tuple[str, Kind]]:
    """The stages without an error, by name and kind."""
    return {one.stage.key for one in last if not one.beyond.any()}


def _confirmed(
    steps: Sequence[Step], chain: tuple[Stage, ...], data: Data, unseen: Unseen, dt: float | None
) -> tuple[Step, ...]:
    """The same steps, with names withdrawn if unseen scenes refute them."""
    found = list[Step]()
    refuted = unseen.refuting(chain, data, dt)
    for step in steps:
        stage, cause = step.followed.stage, step.found
        # A name that was found beside a refuted edit of the same formula has no basis.
        before = [s.followed.stage for s in found if isinstance(s.found, Located)]
        if any(other.key == stage.key for other in before):
            continue
        if isinstance(cause, Named) and any(_shares_formula(stage, other) for other in before):
            cause = Located()
        elif isinstance(cause, Named) and cause.mends is None:
            count = refuted(stage, any(edit.rough for edit in cause.edits), None)
            cause = cause if count is None else Located(cause.edits[0], refuted=count)
        elif isinstance(cause, Scheme) and cause.adequate and cause.mends is None:
            cause = replace(cause, adequate=refuted(stage, False, cause) is None)
        found.append(replace(step, found=cause))
    return tuple(found)


def _standing(steps: Sequence[Step], last: Sequence[Followed]) -> tuple[Step, ...]:
    """Drop located stages that a later edit has explained."""
    right = _right(last)
    return tuple(step for step in steps if step.explained or step.followed.stage.key not in right)


def _beside(
    way: Way,
    chain: tuple[Stage, ...],
    stage: Stage,
    data: Data,
    columns: Mapping[str, Any],
    one: Followed,
) -> tuple[Edit, ...]:
    """Edits that may explain the errors which a scheme like the candidate's leaves."""
    data = replace(data, ways={**data.ways, stage.name: way})
    one, _ = compared(stage, data, columns, one.some)
    if not one.beyond.any():
        return ()
    found = Explanation(chain, stage, data, columns, one).explain()
    return found.near if isinstance(found, Located) else found.edits


def _with_way(
    way: Way,
    stage: Stage,
    chain: Sequence[Stage],
    data: Data,
    columns: Mapping[str, Any],
) -> Data:
    """Data with the candidate's integrator for a stage, and for other flights that it explains.

    A program has one integrator for all flights. The last step of a pitch to the bat may be a
    straight line (paper, Appendix B).
    """
    if way.push is not None:
        return replace(data, ways={**data.ways, **dict.fromkeys(BATTED, way)})
    ways = {**data.ways, stage.name: way}
    for other in chain:
        some = np.flatnonzero(np.isin(columns["kind"], other.scenes))
        if other.kind == "flight" and other.name not in ways:
            wrong: dict[Way | None, int] = {}
            wrong[None] = int(compared(other, data, columns, some)[0].beyond.sum())
            for one in (way, straight(way)):
                flown = replace(data, ways={other.name: one})
                wrong[one] = int(compared(other, flown, columns, some)[0].beyond.sum())
            best = min(wrong, key=wrong.__getitem__)
            if best is not None:
                ways[other.name] = best
    return replace(data, ways=ways)


def _shares_formula(a: Stage, b: Stage) -> bool:
    """True for a stage and itself, and for two flights, which share one law."""
    return a.key == b.key or a.kind == b.kind == "flight"


def _is_same_flight(a: Stage, b: Stage) -> bool:
    """True for flights of one ball, such as to the fence and to the ground."""
    if a.kind != "flight" or b.kind != "flight":
        return False
    return all(
        a.roots[name] is b.roots[name] for name in ("place", "velocity", "spin", "rate", "law")
    )


def _is_wrong(one: Followed) -> bool:
    return bool(one.wrong.any())


def _locating(data: Data) -> Callable[[Followed], Finding]:
    """Return the function from a wrong stage to a finding that only locates it."""
    return lambda one: sentences.located(one.stage, Located(), one, data)


def _finding(step: Step, data: Data) -> Finding:
    """The finding of a stage, with the rule that its wrong scenes follow."""
    one = step.followed
    wrong = [data.cases[i] for i in one.some[one.wrong]]
    right = [data.cases[i] for i in one.some[one.checked & ~one.wrong]]
    scenes = rule(wrong, right)
    if isinstance(step.found, Named):
        return sentences.named(one.stage, step.found, one, data, scenes)
    if isinstance(step.found, Located):
        return sentences.located(one.stage, step.found, one, data, scenes)
    return sentences.scheme(one.stage, step.found, one, data, scenes)
