"""The verdict: a candidate's answers compared with the truth, counted and measured.

`compare` judges one answer, `verdict` all of them. The verdict is a pydantic model, so that it is
written and read as JSON by a schema; `longball.judge.text` writes it for a person.
"""

from __future__ import annotations

import html
import json
import math
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from decimal import Decimal
from statistics import median
from typing import Any, Literal

from pydantic import Field

from longball import __version__
from longball.convergence import ConvergenceReport
from longball.convergence.report import Frozen
from longball.judge.answers import Answer, Collector, Issue
from longball.judge.cases import FRAGILE, Case, Exact, Profile, attainable, decidable
from longball.judge.diagnosis.findings import Diagnosis, many
from longball.judge.quantities import (
    OPTIONAL,
    PATH,
    QUANTITIES,
    Value,
    difference,
    length,
    radius_of,
    superfluous,
    told_by,
    untrue,
    values_of,
)
from longball.judge.sampling import Sampling
from longball.model.schema import FOLDER, published, text


@dataclass(frozen=True)
class Measured:
    """The error of one quantity of an answer. Errors and sizes of vectors are lengths."""

    quantity: str
    expected: Value
    radius: Value
    obtained: Value
    # In the quantity's unit.
    error: float
    tolerance: float
    attainable: float
    size: float  # of the expected value

    @property
    def passed(self) -> bool:
        """True if the error is within the tolerance."""
        return self.error <= self.tolerance


@dataclass(frozen=True)
class Comparison:
    """One answer compared with the truth."""

    case: Case  # what was asked
    answer: Answer | None  # None if there was none
    # True if the case has an outcome that doubles can decide. A fragile case is judged only if the
    # decisions agree, and one whose outcome lies within the tolerance unless it was refused.
    judged: bool
    measured: tuple[Measured, ...] = ()  # every quantity that both sides have
    # Quantities of the truth, or ``outcome``, that the answer leaves out, optional ones included.
    missing: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()  # what is wrong; what is missing is not wrong

    @property
    def refused(self) -> bool:
        """True if the candidate said that it cannot answer."""
        return self.answer is not None and self.answer.error is not None

    @property
    def passed(self) -> bool:
        """True if nothing is wrong."""
        return not self.faults

    @property
    def empty(self) -> bool:
        """True if there is an answer that holds nothing to judge."""
        given = self.answer
        held = given is None or self.refused or self.measured or given.outcome or given.told
        return self.judged and self.passed and not held

    @property
    def counted(self) -> bool:
        """True if the answer holds something that is judged."""
        return self.judged and self.answer is not None and not (self.refused or self.empty)

    @property
    def complete(self) -> bool:
        """True if there is an answer with all quantities of the truth."""
        return self.answer is not None and not self.refused and not self.lacking

    @property
    def lacking(self) -> tuple[str, ...]:
        """The required quantities that are missing."""
        return tuple(name for name in self.missing if name not in OPTIONAL)


def compare(case: Case, answer: Answer | None, profile: Profile) -> Comparison:
    """Compare an answer with a case from the profile's `truths`."""
    judged = decidable(case)
    if answer is not None and answer.error is not None and profile.may_be_refused(case):
        judged = False
    if answer is None or answer.error is not None or not judged:
        return Comparison(case, answer, judged)
    # Points: the interpolation to the landing has an error, `slack` by quantity, which is added to
    # the tolerance, because it is not the candidate's.
    slack: Mapping[str, float] = {}
    points: Mapping[str, tuple[Value, Value]] = {}
    if answer.path is not None:
        from longball.judge.paths import landed, worst_points

        points = worst_points(case.scene, answer.path)
        answer, slack = landed(case.scene, answer)
    truth = case.expected
    # If the outcome is wrong, quantities that are missing are not reported as well.
    wrong = answer.outcome not in (None, truth.outcome)
    # numbers that the truth and the answer have
    expected, given = values_of(truth), answer.values
    measured = [
        Measured(
            name, true, radius_of(truth, name), given[name], difference(given[name], true),
            profile.tolerance(case, name, true) + slack.get(name, 0.0), attainable(case, name),
            length(true),
        )
        for name, true in expected.items()
        if name in given and name not in answer.unreadable
    ]  # fmt: skip
    # The sensitivity of a point in flight is not known. It gets the tolerance of the landing.
    for name, (true, point) in points.items():
        allowed = profile.allowed(size := length(true))
        if "landing.position" in expected:
            allowed = profile.tolerance(case, "landing.position", true)
        measured.append(
            Measured(name, true, (Decimal(0),) * 3, point, difference(point, true), allowed,
                     Exact().allowed(size), size)
        )  # fmt: skip
    # Missing quantities are counted separately, because a program may compute a part of the model
    # (`--partial`). Unreadable ones were meant as answers, and are wrong.
    missing = [] if answer.outcome else ["outcome"]
    missing += [n for n in expected if n not in given and n not in answer.unreadable]
    missing += [n for n in told_by(truth) if n not in answer.told]
    faults = [_fault("outcome", [truth.outcome], [answer.outcome])] if wrong else []
    faults += [_fault(n, expected.get(n, ()), ["not a number"]) for n in sorted(answer.unreadable)]
    if not wrong:
        faults += [_fault(n, [true], [told]) for n, true, told in untrue(truth, answer.told)]
        none = [f"nothing: a {truth.outcome} scene has none"]
        odd = superfluous(truth.outcome, expected, given)
        faults += [_fault(name, none, ["numbers"]) for name in odd]
    failed = [
        _fault(m.quantity, m.expected, m.obtained, m.radius, m.error, m.tolerance)
        for m in measured
        if not m.passed
    ]
    # Of a fragile case, another decision is not wrong, such as that the ball slides; nor are the
    # numbers that follow from it.
    decided = told_by(truth).items() <= answer.told.items()
    if FRAGILE in case.flags and (wrong or not decided) and (faults or failed):
        return Comparison(case, answer, judged=False)
    # The worst come first: a verdict shows only a few faults of each case.
    faults += sorted(failed, key=lambda fault: -fault.excess)
    return Comparison(
        case, answer, True, tuple(measured), () if wrong else tuple(missing), tuple(faults)
    )


def _fault(
    what: str, expected: Iterable[object], obtained: Iterable[object],
    radius: Iterable[object] = (), error: float | None = None, tolerance: float | None = None,
) -> Fault:  # fmt: skip
    numbers = {"expected": expected, "radius": radius, "obtained": obtained}
    texts = {name: [str(x) for x in held] for name, held in numbers.items()}
    return Fault(what=what, **texts, error=error, tolerance=tolerance)


# --- the verdict, as JSON has it ------------------------------------------------------------------


class Row(Frozen):
    """A quantity of a family of cases."""

    family: str
    quantity: str
    unit: str
    cases: int = Field(description="in which both sides have it")
    failed: int = Field(description="in which its error is above the tolerance")
    worst_error: float = Field(description="in the unit; of vectors, the length of the error")
    median_error: float
    worst_ulps: float | None = Field(
        description="in units in the last place of the expected double; null if all are zero"
    )
    median_ulps: float | None
    digits_right: float | None = Field(
        description="of the case that falls most short of its attainable digits; null if every "
        "expected value is zero"
    )
    digits_attainable: float | None = Field(description="of the same case")
    worst_case: str = Field(description="id of the case with the worst error")


class Fault(Frozen):
    """A fault of one answer."""

    what: str = Field(description="outcome, a quantity, or a block that does not belong there")
    expected: list[str]
    radius: list[str] = Field(description="proven radius of each number; 0 where none is proven")
    obtained: list[str]
    error: float | None = Field(description="null where what was given is no number")
    tolerance: float | None

    @property
    def excess(self) -> float:
        """The error in units of its tolerance; infinite without one."""
        return math.inf if self.error is None or not self.tolerance else self.error / self.tolerance


class Failure(Frozen):
    """A case that failed."""

    id: str
    family: str
    flags: list[str]
    scene: dict[str, Any]
    faults: list[Fault]

    @property
    def excess(self) -> float:
        """The excess of its worst fault."""
        return max(fault.excess for fault in self.faults)


class Confusion(Frozen):
    """An outcome that was given for another, and how often."""

    expected: str
    obtained: str
    cases: int


class Missing(Frozen):
    """A quantity that was left out."""

    quantity: str
    cases: int
    example: str = Field(description="id of one of the scenes")


class Unsolved(Frozen):
    """A scene that the candidate says it cannot solve."""

    id: str
    reason: str


class Verdict(Frozen):
    """A candidate's answers compared with the truth."""

    status: Literal["PASSED", "PARTIAL", "FAILED"]
    passed: bool
    reasons: list[str] = Field(description="why it did not pass; empty if it did")
    candidate: str
    version: str = Field(default=__version__, description="of longball")
    date: str = Field(
        default_factory=lambda: datetime.now(UTC).isoformat(timespec="seconds"),
        description="when it was judged, UTC",
    )
    profile: str
    truth: str = Field(description="source of the true results")
    would_pass_at: float | None = Field(
        description="the tolerance of the profile converged at which nothing would be wrong; null "
        "if none helps, or nothing is wrong"
    )
    cases: int
    complete: int = Field(description="answered with all the quantities of their outcome")
    judged: int = Field(description="answered, and decidable in double precision")
    right: int = Field(description="judged, and nothing wrong")
    rows: list[Row]
    outcomes: list[Confusion]
    contacts_missed: list[str] = Field(
        description="ids of scenes with a contact that the answer denies"
    )
    contacts_invented: list[str]
    failures: list[Failure] = Field(description="the worst first")
    missing: list[Missing]
    unanswered: list[str]
    refused: list[Unsolved]
    undecidable: list[str] = Field(
        description="ids of cases without a truth, or with one that depends on the last bits of "
        "the inputs: any answer will do"
    )
    complaints: list[Issue] = Field(description="those about its conduct first")
    complaints_left_out: dict[str, int] = Field(description="of a kind, beyond those listed")
    standard_error: str = Field(description="its end")
    seconds: float | None = Field(
        description="of all the candidate's runs and the search for causes; null if none was run"
    )
    diagnosis: Diagnosis | None = Field(default=None, description="where, by how much, and why")
    convergence: ConvergenceReport | None = Field(
        default=None, description="result of a family of time steps"
    )
    sampling: Sampling | None = Field(
        default=None, description="how the candidate draws its at-bats"
    )

    def line(self) -> str:
        """Return the verdict as JSON."""
        return self.model_dump_json(indent=2)

    def __str__(self) -> str:
        from longball.judge.text import render  # which is made for verdicts

        return render(self)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


SCHEMA_FILE = FOLDER / "verdict.schema.json"


def schema() -> dict[str, Any]:
    """Return the JSON Schema of a verdict; ``python -m longball.judge.verdict`` writes its file."""
    return published("verdict", Verdict.model_json_schema(mode="serialization"))


@dataclass(frozen=True)
class Submission:
    """A candidate, as its author describes it."""

    candidate: str  # what it is called
    collected: Collector  # its answers, and what is wrong with its output or conduct
    standard_error: str = ""  # of its run, if it was run
    convergence: ConvergenceReport | None = None  # how it converges, if a family of steps was run
    sampling: Sampling | None = None  # how it draws at-bats, if it gave some


def verdict(
    comparisons: Sequence[Comparison],
    submission: Submission,
    profile: str,
    truth: str,
    partial: bool = False,
    diagnosis: Diagnosis | None = None,
    seconds: float | None = None,
) -> Verdict:
    """Build the verdict on a candidate.

    `truth` names the source of the true results, and `profile` the accuracy that is asked for. If
    `partial`, scenes and quantities may be left out.
    """
    judged = [c for c in comparisons if c.counted]
    failures = sorted((_failure(c) for c in judged if not c.passed), key=lambda f: -f.excess)
    errors = [(c.case.id, c.answer.error) for c in comparisons if c.judged and c.answer]
    refused = [Unsolved(id=name, reason=error) for name, error in errors if error is not None]
    collected = submission.collected
    convergence, sampling = submission.convergence, submission.sampling
    reasons = []
    # Without any answer that can be judged, nothing is wrong, and yet nothing is shown to be right.
    if comparisons and not judged:
        empty = any(c.empty for c in comparisons)
        what = "the answers hold nothing that could" if empty else "no answer could"
        reasons.append(f"{what} be judged")
    if failures:
        reasons.append(f"{len(failures)} of {len(judged)} answers are wrong")
    if collected.faults:
        reasons.append(f"{many(collected.faults, 'issue')} with its output or conduct")
    if convergence:
        reasons += [f"convergence: {fault}" for fault in convergence.faults]
    if sampling:
        reasons += [f"sampling: {found.sentence}" for found in sampling.wrong]
    if diagnosis:
        reasons += diagnosis.conduct
    whole = [c for c in comparisons if c.judged]
    complete = sum(c.complete for c in whole)
    status: Literal["PASSED", "PARTIAL", "FAILED"] = "FAILED" if reasons else "PASSED"
    if judged and complete < len(whole) and not partial:
        kinds = {c.case.scene.kind for c in whole} - {
            c.case.scene.kind for c in whole if c.complete
        }
        none = f", and no {', no '.join(sorted(kinds))}" if kinds and complete else ""
        reasons.append(f"{complete} of {len(whole)} scenes are answered with all their quantities"
                       f"{none}; --partial judges what there is")  # fmt: skip
        status = "PARTIAL" if status == "PASSED" else status
    return Verdict(
        status=status, passed=not reasons, reasons=reasons, candidate=submission.candidate,
        profile=profile, truth=truth, would_pass_at=_would_pass_at(judged),
        cases=len(comparisons), complete=complete, judged=len(judged),
        right=len(judged) - len(failures), rows=list(_rows(judged)), outcomes=_confusions(judged),
        contacts_missed=[c.case.id for c in judged if _met(c) == (True, False)],
        contacts_invented=[c.case.id for c in judged if _met(c) == (False, True)],
        failures=failures, missing=_missing(comparisons),
        unanswered=[c.case.id for c in comparisons if c.answer is None], refused=refused,
        undecidable=[c.case.id for c in comparisons if not c.judged],
        complaints=sorted(collected.issues, key=lambda issue: issue.kind != "process"),
        complaints_left_out=dict(collected.left_out.items()),
        standard_error=submission.standard_error, seconds=seconds,
        diagnosis=diagnosis, convergence=convergence, sampling=sampling,
    )  # fmt: skip


def _would_pass_at(judged: Sequence[Comparison]) -> float | None:
    """Return the smallest tolerance at which every answer passes, rounded up to two digits.

    None if an outcome or a word is wrong.
    """
    errors = [fault.error for c in judged for fault in c.faults]
    known = [error for error in errors if error is not None]
    if len(known) < len(errors) or not known:
        return None
    place = 10.0 ** (math.floor(math.log10(worst := max(known))) - 1)  # of the second digit
    return float(f"{math.ceil(worst / place) * place:.2g}")


# Outcomes that show if ball and bat touch. Others, such as `landed`, leave it open.
_MET = {"batted": True, "separating": True, "missed": False, "beyond_bat": False}


def _met(comparison: Comparison) -> tuple[bool | None, bool | None]:
    """Return two flags, from the case and the answer, for contact; None where that is open."""
    assert comparison.answer is not None
    truth = comparison.case.expected
    expected = _MET.get(truth.outcome or "", True if truth.impact else None)
    struck = any(name.startswith("impact.") for name in comparison.answer.values)
    return expected, _MET.get(comparison.answer.outcome or "", True if struck else None)


def _missing(comparisons: Iterable[Comparison]) -> list[Missing]:
    found: dict[str, list[str]] = defaultdict(list)
    for comparison in comparisons:
        for name in comparison.missing:
            found[name].append(comparison.case.id)
    order = ["outcome", *QUANTITIES]
    names = [*(n for n in order if n in found), *sorted(found.keys() - set(order))]
    return [Missing(quantity=n, cases=len(found[n]), example=found[n][0]) for n in names]


def _confusions(judged: Iterable[Comparison]) -> list[Confusion]:
    told = ((str(c.case.expected.outcome), c.answer.outcome) for c in judged if c.answer)
    pairs = Counter((expected, obtained) for expected, obtained in told if obtained is not None)
    return [Confusion(expected=a, obtained=b, cases=n) for (a, b), n in sorted(pairs.items())]


def _rows(judged: Iterable[Comparison]) -> Iterator[Row]:
    groups: dict[tuple[str, str], list[tuple[Comparison, Measured]]] = defaultdict(list)
    for comparison in judged:
        for measured in comparison.measured:
            groups[comparison.case.family, measured.quantity].append((comparison, measured))
    for family in dict.fromkeys(family for family, _ in groups):
        for name, quantity in (QUANTITIES | PATH).items():
            if group := groups.get((family, name)):
                yield _row(family, name, quantity.unit, group)


def _row(family: str, name: str, unit: str, group: list[tuple[Comparison, Measured]]) -> Row:
    measured = [m for _, m in group]
    worst, most = max(group, key=lambda pair: pair[1].error)
    # JSON has no infinity.
    ulps = [min(m.error / math.ulp(m.size), sys.float_info.max) for m in measured if m.size]
    known = [m for m in measured if m.size]
    # The digits are those of the case with the largest gap to what is attainable, not those of the
    # worst error: a graze has few right digits in any program.
    digits = [[right_digits(x, m.size) for x in (m.error, m.attainable)] for m in known]
    lost = [(attainable - right, right, attainable) for right, attainable in digits]
    _, digits_right, digits_attainable = max(lost, default=(None, None, None))
    return Row(
        family=family, quantity=name, unit=unit, cases=len(group),
        failed=sum(not m.passed for m in measured), worst_error=most.error,
        median_error=_median([m.error for m in measured]), worst_ulps=max(ulps, default=None),
        median_ulps=_median(ulps) if ulps else None, digits_right=digits_right,
        digits_attainable=digits_attainable, worst_case=worst.case.id,
    )  # fmt: skip


def _median(values: Sequence[float]) -> float:
    """Return the median, even if the sum of two values would overflow."""
    return median(x / 2 for x in values) * 2 if max(values) > 1e300 else median(values)


_MOST_DIGITS = 17.0  # of a double


def right_digits(error: float, size: float) -> float:
    """Return the number of right decimal digits, from a number's size and error."""
    if not error:
        return _MOST_DIGITS
    return max(0.0, min(_MOST_DIGITS, math.log10(size) - math.log10(error)))


def _failure(comparison: Comparison) -> Failure:
    case, faults = comparison.case, list(comparison.faults)
    scene: dict[str, Any] = json.loads(case.scene.as_written())
    return Failure(id=case.id, family=case.family, flags=[*case.flags], scene=scene, faults=faults)


if __name__ == "__main__":
    SCHEMA_FILE.write_text(text(schema()), encoding="utf-8")
