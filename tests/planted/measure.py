"""Accuracy of the judge's diagnosis: named, located, false names, false reassurance.

    python -m tests.planted.measure [--source planted mutants edits right] [--half open]
                                    [--sample 40] [--seed 1] [--cases 60] [--fresh 500]
                                    [--jobs 2] [--out build/planted]

Four sources of programs that are known to be wrong, or known to be right:

planted
    Independent programs with mistakes that authors make (mistakes.csv), in two halves: the closed
    one is not looked at while the judge is changed.
mutants
    The candidates of the tests with one place of their source changed at random (mutator.py).
edits
    longball's own chain with one of its edits: what the diagnosis can name, it has to find.
right
    A right program at many levels of accuracy (at_bat_lab.py): no name is right.

Nobody grades by reading. A name is right if the chain with the edits of the diagnosis makes the
program's numbers, from the program's own earlier values, in scenes that neither has seen; a place
is right if there the unedited chain fails first. Whatever was judged is kept as JSON in `--out`,
and not judged again.
"""

import argparse
import json
import multiprocessing
import random
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.stats import binomtest

from longball.judge.cases import Case, Profile
from longball.judge.diagnosis.chain import Stage
from longball.judge.diagnosis.clocks import Scheme
from longball.judge.diagnosis.diagnose import Conclusion, conclude, prepared
from longball.judge.diagnosis.digits import explain_digits, with_digits
from longball.judge.diagnosis.evidence import ADEQUATE, ROUGH
from longball.judge.diagnosis.findings import Finding
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.outputs import outputs
from longball.judge.diagnosis.residual import Data, follow, mended, switches
from longball.judge.diagnosis.schemes import explain_scheme
from longball.judge.diagnosis.search import Named
from longball.judge.diagnosis.unseen import Solve
from longball.judge.verdict import compare
from tests.planted import sources
from tests.planted.sources import EXACT, Answers, Crashed, Subject, fresh, golden

SOURCES = ("planted", "mutants", "edits", "right")
SAME = 1e-11  # relative: values of a mutant that differ by less are those of the original


# --- the judge ------------------------------------------------------------------------------------


def known(cases: Sequence[Case], answers: Answers) -> list[Case]:
    """Cases with a right outcome, of which numbers are compared."""
    given = [(case, answers[case.id]) for case in cases if case.id in answers]
    return [c for c, a in given if not a.error and a.outcome in (None, c.expected.outcome)]


def like(cases: Sequence[Case], others: Sequence[Case]) -> list[Case]:
    """Cases with the same options as one of some others: what a chain was specialised to."""

    def rows(cases: Sequence[Case]) -> list[tuple[str, ...]]:
        columns = switches([case.scene for case in cases]) if cases else {}
        return [*zip(*columns.values())]

    seen = {*rows(others)}
    return [case for case, row in zip(cases, rows(cases)) if row in seen]


@dataclass(frozen=True)
class Told:
    """A finding of the diagnosis at a stage.

    Attributes
    ----------
    edit, scheme
        The cause, if it is one of these; else it is an output, or digits.
    part
        True if the edit explains a part of the errors.
    """

    stage: str
    kind: str
    words: str
    edit: Edit | None = None
    scheme: Scheme | None = None
    part: bool = False


def told_by(made: Conclusion) -> list[Told]:
    """Findings of a conclusion: named, near or located."""
    told = [Told("output", "named", str(finding.edit)) for finding in made.outputs]
    if made.digits is not None:
        return [*told, Told("digits", "named", made.digits)]
    for step in made.steps:
        stage, found = step.followed.stage.name, step.found
        if isinstance(found, Named):
            part = found.mends is not None
            told += [Told(stage, "named", edit.words, edit, part=part) for edit in found.edits]
        elif isinstance(found, Scheme):
            kind = "named" if found.adequate else "located"
            told.append(Told(stage, kind, found.words, scheme=found))
        elif found.nearest is not None:
            told.append(Told(stage, "nearest", found.nearest.words, edit=found.nearest))
        else:
            told.append(Told(stage, "located", ""))
    return told


# --- grading --------------------------------------------------------------------------------------


def differ(cases: Sequence[Case], a: Answers, b: Answers) -> bool:
    """True if two programs do not answer the same."""
    for case in cases:
        one, other = a.get(case.id), b.get(case.id)
        if one is None or other is None:
            if one is not other:
                return True
            continue
        if one.outcome != other.outcome or one.values.keys() != other.values.keys():
            return True
        for quantity, value in one.values.items():
            x, y = (np.array([float(p) for p in z.values[quantity]]) for z in (one, other))
            if not np.abs(x - y).max() <= SAME * max(1.0, np.abs(y).max()) or len(value) != len(y):
                return True
    return False


def solves(case: Case, answers: Answers, profile: Profile) -> bool:
    """True if a program solves a case as well as its steps allow."""
    answer = answers.get(case.id)
    return answer is not None and not answer.error and compare(case, answer, profile).passed


def asked(subject: Subject) -> Solve:
    """A program as the judge asks it; it may fail."""

    def solve(scenes: Sequence[Any]) -> Answers:
        try:
            return subject.answers([SimpleNamespace(id=s.id, scene=s) for s in scenes])
        except Crashed:
            return {}

    return solve


def judged(subject: Subject, most: int, count: int) -> dict[str, Any]:
    """Judge a program by so many cases a family, and record the truth about it."""
    families = tuple(subject.families)
    cases, new = golden(families, most), fresh(families, count)
    said: dict[str, Any] = {"source": subject.source, "name": subject.name}
    try:
        answers, again = subject.answers(cases), subject.answers(new)
    except Crashed as error:
        return said | {"status": "crashed", "why": str(error)}
    if subject.original:
        before, later = subject.original(cases), subject.original(new)
        if not (differ(new, again, later) or differ(cases, answers, before)):
            return said | {"status": "same"}
        # What the original does not solve says nothing of the mutation.
        passes = subject.profile
        cases = [c for c in passes.truths(cases) if solves(c, before, passes)]
        new = [c for c in passes.truths(new) if solves(c, later, passes)]
    right = [c for c in known(cases, answers) if answers[c.id].values]
    unseen = like([c for c in known(new, again) if again[c.id].values], right)
    strict = subject.profile if subject.profile.scheme() else EXACT
    granted = subject.profile.error  # as the command does
    wrong = [c.id for c in right if not compare(c, answers[c.id], strict).passed]
    beyond = [c.id for c in unseen if not compare(c, again[c.id], strict).passed]
    passed = all(c.id in answers and compare(c, answers[c.id], strict).passed for c in cases)
    if not wrong and not (passed and beyond):
        return said | {"status": "other", "passed": passed}
    try:
        with warnings.catch_warnings(action="ignore"):
            start = time.process_time()
            solve = None if subject.source == "edits" else asked(subject)
            scheme = subject.profile.scheme()
            made = conclude(right, answers, subject.dt, scheme, granted, solve)
            seconds = time.process_time() - start
    except Exception:
        return said | {"status": "failed", "why": traceback.format_exc()[-1500:]}
    if not passed and not any(f.wrong.any() for f in made.first):  # numbers that cannot be read
        return said | {"status": "other", "passed": passed}
    first, everywhere, holds = [], [], lambda told: [0, 0]
    if unseen:
        data, chain = prepared(unseen, again, scheme, granted)
        first, everywhere = _wrong(follow(chain, data)[1])
        holds = _holding(made, chain, data, again, subject.dt)
    findings = [
        {
            "stage": x.stage, "kind": x.kind, "words": x.words, "is_edit": x.edit is not None,
            "rough": bool((x.edit and x.edit.rough) or x.scheme), "off": holds(x), "part": x.part,
        }
        for x in told_by(made)
    ]  # fmt: skip
    return said | {
        "status": "judged", "passed": passed, "wrong": len(wrong), "known": len(right),
        "fresh": len(unseen), "fresh_wrong": len(beyond), "first": first,
        "everywhere": everywhere, "findings": findings,
        "seconds": seconds,
    }  # fmt: skip


def _holding(
    made: Conclusion, chain: tuple[Stage, ...], plain: Data, again: Answers, dt: float | None
) -> Callable[[Told], list[int]]:
    """From what is told to how many numbers of its stage it leaves wrong in new scenes.

    Of a conversion, digits, or a clock it is 1 of 1 if the new scenes do not show the same. Of a
    part of the errors, the numbers are those of the scenes that the edit breaks.
    """
    data, converted = with_digits(plain, again), list[Finding]()
    if made.outputs:
        data, converted = outputs(data, chain)
    data = replace(data, ways=made.data.ways, rough=made.data.rough)
    columns, every = follow(made.chain, data)
    shaken = follow(made.chain, _shaken(data))[1]

    def left(told: Told) -> list[int]:
        if told.stage == "output":
            return [int(told.words not in {f.edit for f in converted}), 1]
        if told.stage == "digits":
            return [int(explain_digits(chain, plain, again) != told.words), 1]
        if told.scheme is not None and told.scheme.way is None:
            own = [f for f in every if f.stage.name == told.stage and f.wrong.any()]
            found = [explain_scheme(made.chain, f.stage, data, columns, f, dt) for f in own]
            return [int(not all(x is not None and x.adequate for x in found)), 1]
        if told.part and told.edit is not None:
            edited = follow(told.edit.apply(chain), data)[1]
            pairs = zip(follow(chain, data)[1], edited, strict=True)
            counts = [mended(a, b) for a, b in pairs if a.stage.name == told.stage]
            mends, breaks = (sum(column) for column in zip(*counts, strict=True))
            return [breaks if mends else 1, max(1, mends + breaks)]
        return _off(every, shaken, told.stage)

    return left


def _wrong(followed: Sequence[Any]) -> tuple[list[str], list[str]]:
    """Stages that are wrong in a scene where nothing before them is; and all that are wrong."""
    first, every, before = list[str](), list[str](), set[int]()
    for f in followed:
        wrong = {int(i) for i in f.some[f.wrong]}
        first += [f.stage.name] if wrong - before else []
        every += [f.stage.name] if wrong else []
        before |= wrong
    return [*dict.fromkeys(first)], [*dict.fromkeys(every)]


def _shaken(data: Data) -> Data:
    """The same with values that no event ends at."""
    given = {quantity: 1.01 * value + 0.01 for quantity, value in data.given.items()}
    return replace(data, given=given)


def _off(followed: Sequence[Any], shaken: Sequence[Any], stage: str) -> list[int]:
    """Count the numbers of a stage that are more than `ADEQUATE` floors off, and all of them.

    An event that values shaken at random satisfy as well is no event: it is off everywhere.
    """
    off = every = 0
    for f, other in zip(followed, shaken):
        if f.stage.name == stage:
            given = int(np.isfinite(f.off).sum())
            vacuous = f.stage.kind == "event" and not _beyond(other)
            off += given if vacuous else _beyond(f)
            every += given
    return [off, every]


def _beyond(f: Any) -> int:
    with np.errstate(all="ignore"):
        return int((np.abs(f.off) > ADEQUATE * f.floor).sum())


@dataclass(frozen=True)
class Grade:
    """Grade of a diagnosis."""

    named: bool  # a name of an edit, a scheme or an output, and every name right
    located: bool  # the stage first found wrong is one that is, and so is every other
    false: tuple[str, ...]  # names that are not
    reassured: bool


def grade(row: Mapping[str, Any]) -> Grade:
    """Grade what was judged."""
    findings = row["findings"]
    names = [f for f in findings if f["kind"] == "named"]
    false = [f"{f['stage']} {f['words']}" for f in names if not is_right(row, f)]
    parts = [f for f in names if f["part"]]
    places = [f["stage"] for f in findings if f["stage"] not in ("output", "digits")]
    return Grade(
        # A part of the errors counts as named if the rest is named, too.
        bool(names) and not false and not (parts and len(names) < len(findings)),
        bool(findings)
        and all(stage in row["first"] for stage in places[:1])
        and all(stage in row["everywhere"] for stage in places),
        tuple(false),
        row["passed"] or not findings,
    )


def is_right(row: Mapping[str, Any], finding: Mapping[str, Any]) -> bool:
    """True if what is named makes the program's numbers in the scenes that neither has seen.

    A few numbers may be off where a kink is near, or where the program's own search for the end
    of its last step stops early; a wrong name misses nearly all.
    """
    off, every = finding["off"]
    law = row["source"] == "right" and finding["is_edit"]  # which is right there already
    return not law and off <= (ROUGH if finding["rough"] else 0.0) * every


def wilson(count: int, of: int) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson)."""
    low, high = binomtest(count, of).proportion_ci(method="wilson")
    return float(low), float(high)


def with_interval(count: int, of: int) -> str:
    """A count with its share and the interval of that."""
    if not of:
        return "-"
    low, high = wilson(count, of)
    return f"{count} ({count / of:.1%}; {low:.1%} to {high:.1%})"


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """The four figures of each source, in Markdown."""
    head = ["source", "judged", "named", "located", "false names", "false reassurance", "crashed",
            "same", "other"]  # fmt: skip
    lines = [head, ["---"] * len(head)]
    for source in SOURCES:
        own = [row for row in rows if row["source"] == source]
        grades = [grade(row) for row in own if row["status"] == "judged"]
        counts = [sum(map(bool, of)) for of in zip(*(vars(g).values() for g in grades))]
        told = [with_interval(n, len(grades)) for n in counts] or ["-"] * 4
        status = [row["status"] for row in own]
        rest = [status.count(x) for x in ("crashed", "same")]
        rest.append(status.count("other") + status.count("failed"))
        lines.append([source, len(grades), *told, *rest])
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


# --- the run --------------------------------------------------------------------------------------

CHOSEN: list[Subject] = []  # what the processes share


def kept(number: int, folder: Path, most: int, count: int) -> dict[str, Any]:
    """Judge a subject, or read what was judged before."""
    subject = CHOSEN[number]
    file = subject.file(folder)
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(judged(subject, most, count)), encoding="utf-8")
    return json.loads(file.read_text(encoding="utf-8"))


def chosen(options: argparse.Namespace) -> Iterator[Subject]:
    """The subjects of a run."""
    folder = options.out / "programs"
    folder.mkdir(parents=True, exist_ok=True)
    makers = {
        "planted": lambda: sources.planted(options.half, folder),
        "mutants": lambda: sources.mutants(options.seed, folder),
        "edits": lambda: sources.own_edits(options.seed, options.cases),
        "right": lambda: sources.right(folder),
    }
    for source in options.source:
        every = makers[source]()
        if source in ("planted", "right"):
            every = [*every]
            random.Random(options.seed).shuffle(every)
        yield from (subject for subject, _ in zip(every, range(options.sample)))


def main() -> None:
    """Measure, and print the table with every false name."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--source", nargs="*", choices=SOURCES, default=SOURCES)
    parser.add_argument("--half", choices=("open", "closed", "both"), default="open")
    parser.add_argument("--sample", type=int, default=1000, help="at most so many of each source")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=60, help="at most so many of each family")
    parser.add_argument("--fresh", type=int, default=500, help="scenes that a name is held against")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=sources.ROOT / "build" / "planted")
    options = parser.parse_args()
    CHOSEN[:] = chosen(options)
    context = multiprocessing.get_context("fork")  # edits are not pickled
    with ProcessPoolExecutor(options.jobs, context) as pool:
        asked = [
            pool.submit(kept, number, options.out, options.cases, options.fresh)
            for number in range(len(CHOSEN))
        ]
        rows = []
        for future in asked:
            rows.append(row := future.result())
            print(_line_of(row), file=sys.stderr, flush=True)
    print(table(rows))
    for row in rows:
        if row["status"] == "judged" and (false := grade(row).false):
            print(f"false name: {row['name']}: {'; '.join(false)}")


def _line_of(row: Mapping[str, Any]) -> str:
    if row["status"] != "judged":
        return f"{row['status']}: {row['name']}"
    said = [f"{f['stage']} {f['kind']} {f['words']} {f['off']}" for f in row["findings"]]
    return f"{row['name']}: {grade(row)} first {row['first']} {said} {row['seconds']:.0f} s"


if __name__ == "__main__":
    main()
