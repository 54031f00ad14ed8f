"""The verdict as text."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress

from longball.convergence import ConvergenceReport
from longball.judge.answers import printable, quoted
from longball.judge.diagnosis.findings import Diagnosis, Finding, many, size
from longball.judge.quantities import OPTIONAL
from longball.judge.sampling import Sampling
from longball.judge.verdict import Fault, Row, Verdict
from longball.text_table import aligned

SHOWN = 5  # entries of each list that are printed; the JSON has all
LOOSEST = 1.0  # m, s, m/s, J: a larger tolerance that would pass is not worth printing
LONGEST_NAME = 120  # characters of a candidate's command, which may contain a whole program


def render(verdict: Verdict, shown: int = SHOWN, table: bool = False) -> str:
    """Return a verdict as text of at most `shown` failed cases, issues and so on.

    The `table` has a row for each quantity.
    """
    sections = [
        *(_head(verdict), _errors(verdict) if table else (), _contacts(verdict)),
        _diagnosis(verdict.diagnosis) if verdict.diagnosis else (),
        _convergence(verdict.convergence) if verdict.convergence else (),
        _sampling(verdict.sampling) if verdict.sampling else (),
        *(_failures(verdict, shown), silence(verdict, shown), _issues(verdict, shown)),
    ]
    return "\n\n".join("\n".join(lines) for s in sections if (lines := list(s))) + "\n"


def _head(verdict: Verdict) -> Iterator[str]:
    candidate = quoted(verdict.candidate, LONGEST_NAME)
    asked = verdict.cases - len(verdict.undecidable)
    # Only with PARTIAL: after the other words, the count of complete answers would be read as that
    # of right or wrong ones.
    counted = f" {verdict.complete} of {asked}" * (verdict.status == "PARTIAL")
    yield f"{verdict.status}{counted}: {candidate}"
    if verdict.status == "PASSED" and verdict.complete < asked:
        yield f"{verdict.complete} of {asked} scenes are answered with all their quantities"
    if verdict.cases:
        yield from counts(verdict)
    for reason in verdict.reasons:
        yield f"{'partial' if verdict.status == 'PARTIAL' else 'failed'} because: {reason}"
    if (least := verdict.would_pass_at) is not None and least <= LOOSEST:
        yield f"no answer would be wrong at --profile converged --tolerance {least:g}"


def counts(verdict: Verdict) -> Iterator[str]:
    """Yield how many scenes were answered and how, by which rule."""
    yield f"profile {verdict.profile}"
    yield f"compared with {verdict.truth}"
    parts = [many(verdict.cases, "scene"), f"{many(verdict.judged, 'answer')} judged"]
    parts += [f"{verdict.right} right", f"{verdict.judged - verdict.right} wrong"]
    if verdict.unanswered:
        parts.append(f"{len(verdict.unanswered)} without an answer")
    if verdict.refused:
        parts.append(f"{len(verdict.refused)} refused")
    if verdict.undecidable:
        parts.append(f"{len(verdict.undecidable)} that doubles cannot decide, not judged")
    if verdict.seconds is not None:
        parts.append(f"{verdict.seconds:.1f} s")
    yield ", ".join(parts)


def _errors(verdict: Verdict) -> Iterator[str]:
    if not verdict.rows:
        return
    failed = [row for row in verdict.rows if row.failed]
    table = [ERRORS, *map(error_cells, failed or verdict.rows)]
    yield from aligned(table, right=(2, 3, 4, 5, 7, 8, 9, 10))
    right = Counter(row.family for row in verdict.rows if failed and not row.failed)
    if right:
        listed = ", ".join(f"{count} of {family}" for family, count in right.items())
        yield f"quantities that are right in every case: {listed}"


ERRORS = (
    "family", "quantity", "failed", "of", "worst error", "median", "", "worst ulps", "median",
    "digits right", "attainable at least", "worst case",
)  # fmt: skip


def error_cells(row: Row) -> tuple[str, ...]:
    """Return a row's texts under the head `ERRORS`."""
    ulps = ["" if x is None else f"{x:.0f}" if x < 1e5 else f"{x:.0e}"
            for x in (row.worst_ulps, row.median_ulps)]  # fmt: skip
    known = row.digits_right, row.digits_attainable
    digits = ["" if x is None else f"{x:.1f}" for x in known]
    errors = f"{row.worst_error:.1e}", f"{row.median_error:.1e}", row.unit
    counts = str(row.failed or "-"), str(row.cases)
    return (row.family, row.quantity, *counts, *errors, *ulps, *digits, row.worst_case)


def _contacts(verdict: Verdict) -> Iterator[str]:
    confused = [c for c in verdict.outcomes if c.expected != c.obtained]
    if confused:
        table = [("outcome expected", "obtained", "scenes")]
        table += [(c.expected, c.obtained, str(c.cases)) for c in confused]
        yield from aligned(table, right=(2,))
    contacts = {"missed": verdict.contacts_missed, "invented": verdict.contacts_invented}
    for what, ids in contacts.items():
        if ids:
            yield f"contacts {what}: {len(ids)} ({_some(ids, 5)})"


def _diagnosis(diagnosis: Diagnosis) -> Iterator[str]:
    for sentence in diagnosis.conduct:
        yield f"run again: {sentence}"
    if diagnosis.first:
        yield f"first wrong step: {diagnosis.first}"
    yield from stage_sentences(diagnosis)
    if not diagnosis.findings:
        yield f"diagnosis: {diagnosis.sentence}"
    for finding in diagnosis.findings if not diagnosis.conduct else ():  # no cause was sought
        yield from finding_sentences(finding)
    if diagnosis.smallest:
        yield f"a minimal scene that fails: {json.dumps(diagnosis.smallest, ensure_ascii=False)}"


def stage_sentences(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the stages that are wrong, given earlier values, and those that are right."""
    for row in (row for row in diagnosis.stages if row.wrong):
        where = f"in {row.wrong} of {many(row.checked, 'scene')}"
        worst = f"relative error up to {size(row.worst)}; {row.example}"
        yield f"  {row.stage} is wrong {where} ({worst})"
    if diagnosis.clean:
        yield f"  right in every scene, given your own earlier values: {', '.join(diagnosis.clean)}"


def finding_sentences(finding: Finding) -> Iterator[str]:
    """Yield a finding, its remedy and the rule for its scenes."""
    yield f"{finding.kind}: {finding.sentence}"
    if finding.remedy:
        yield f"  {finding.remedy}"
    if finding.scenes:
        yield f"  exactly the scenes with {finding.scenes}"


def _convergence(report: ConvergenceReport) -> Iterator[str]:
    yield "convergence: the error of a family of time steps, against the truth"
    yield from (f"  {line}".rstrip() for line in report.text().splitlines())


def _sampling(sampling: Sampling) -> Iterator[str]:
    count, source = sampling.at_bats, sampling.source
    yield f"sampling: {count} different at-bats of {source}, compared with the paper's"
    yield f"  they show differences of a distribution function of {sampling.sees:.2f} or more"
    for found in sampling.found:
        named = f" [{', '.join(found.named)}]" if found.named else ""
        yield f"  {'right' if found.right else 'WRONG'}  {found.sentence}{named}"


def _failures(verdict: Verdict, shown: int) -> Iterator[str]:
    if not verdict.failures:
        return
    yield f"wrong answers, the worst first ({min(shown, len(verdict.failures))} shown)"
    for failure in verdict.failures[:shown]:
        yield f"  {flagged(failure.id, failure.flags)}"
        for fault in failure.faults[:2]:
            yield f"    {describe(fault)}"
        if len(failure.faults) > 2:
            yield f"    and {many(len(failure.faults) - 2, 'other fault')}"


def flagged(name: str, flags: Sequence[str]) -> str:
    """Return the id of a scene, followed by its flags."""
    return name + (f" [{', '.join(flags)}]" if flags else "")


def describe(fault: Fault) -> str:
    """Return a fault as a sentence."""
    expected = _joined(fault.expected)
    if any(radius.strip("0.") for radius in fault.radius):
        expected += f" ± {max(fault.radius, key=float)}"
    sentence = f"{fault.what}: expected {expected}, obtained {_joined(fault.obtained)}"
    if fault.error is None or fault.tolerance is None:
        return sentence
    allowed = f"{fault.tolerance:.1e}" if fault.tolerance >= sys.float_info.epsilon**2 else "none"
    return f"{sentence}; off by {fault.error:.2e}, allowed {allowed}"


def _joined(numbers: Sequence[str]) -> str:
    """Return numbers with no more digits than a double has."""
    short = list(numbers)
    for i, number in enumerate(numbers):
        with suppress(ValueError):  # a text
            short[i] = f"{float(number):.17g}" if len(number) > 24 else number
    return short[0] if len(short) == 1 else f"({', '.join(short)})"


def silence(verdict: Verdict, shown: int) -> Iterator[str]:
    """Yield lines on missing answers and quantities, refusals, and cases that are not judged."""
    for missing in verdict.missing if verdict.judged else ():  # otherwise everything is
        need = ", as it may be" if missing.quantity in OPTIONAL else ""
        where = f"in {many(missing.cases, 'answer')}: {missing.example}"
        yield f"left out{need}: {missing.quantity} {where}"
    if verdict.unanswered:
        yield f"without an answer: {_some(verdict.unanswered, shown)}"
    for unsolved in verdict.refused[:shown]:
        yield f"refused: {unsolved.id}: {unsolved.reason}"
    if verdict.undecidable:
        yield f"not judged, doubles cannot decide: {_some(verdict.undecidable, shown)}"


def _issues(verdict: Verdict, shown: int) -> Iterator[str]:
    for issue in verdict.complaints[:shown]:
        yield f"{'note' if issue.kind == 'unknown key' else 'issue'}: {issue}"
    more = len(verdict.complaints) - shown + sum(verdict.complaints_left_out.values())
    if more > 0:
        yield f"issues: {more} more"
    if verdict.complaints and printable(verdict.standard_error):
        yield "the end of its standard error:"
        yield from (f"  {line}" for line in printable(verdict.standard_error).splitlines()[-shown:])


def _some(ids: Sequence[str], shown: int) -> str:
    more = len(ids) - shown
    return ", ".join(ids[:shown]) + (f" and {more} more" if more > 0 else "")
