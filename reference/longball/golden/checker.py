"""Verification of a golden set: files, schemas, consistency, and every number computed again."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal, localcontext
from importlib import import_module
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from longball.engines.parallel import in_parallel
from longball.extras import MissingExtra, naming_extras
from longball.golden.case import Case, Header, Probabilities, ProbabilityCase, decisive
from longball.golden.files import (
    CHECKSUMS,
    HEADER,
    PROBABILITIES,
    checksum,
    inside,
    listed,
    schemas,
)
from longball.golden.home_runs import integrated_again
from longball.golden.reader import DATA, drafts
from longball.golden.truth import confirm, prove, quantities
from longball.model.quantities import numbers_of
from longball.model.result import Result

M = TypeVar("M", Header, Probabilities)


@dataclass(frozen=True)
class Report:
    """Result of a check: counts, failures, omitted cases, and a sentence on confirmations."""

    cases: int
    solved_again: int
    failures: tuple[str, ...]
    left_out: str = ""
    confirmed: str = ""


def check(
    folder: Path = DATA,
    *,
    sample: int | None = None,
    seed: int = 1,
    independent: bool = True,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Report:
    """Verify a golden set: check its files, and solve its cases, or a random sample, again.

    If `independent`, a second method solves them as well, in several times the time. `progress` is
    called with the number of cases solved again, and their total.
    """
    # the files, and the cases in them
    failures = [*_wrong_files(folder)]
    cases: list[Case] = []
    top, fault = _read(Header, folder / HEADER)
    if top is None:
        return Report(0, 0, (*failures, f"{HEADER}: {fault}"))
    for name, family in top.families.items():
        if not inside(folder, family.file):
            failures.append(f"{HEADER}: {family.file!r} is not a file of {folder}")
            continue
        of_family, wrong = _read_family(folder / family.file, name, family.cases)
        cases += of_family
        failures += wrong
    if folder.resolve() != DATA:
        failures += _out_of_order(cases)
    every: list[Case | ProbabilityCase] = [*cases]
    # the probabilities; a set can be written without them
    if (folder / PROBABILITIES).exists():
        integrals, fault = _read(Probabilities, folder / PROBABILITIES)
        if integrals is None:
            failures.append(f"{PROBABILITIES}: {fault}")
        else:
            every += integrals.cases
    # consistency of each case with the header and with itself
    ids = Counter(case.id for case in every)
    failures += [f"{name}: the id is given twice" for name, count in ids.items() if count > 1]
    failures += [sentence for case in cases for sentence in _inconsistent(case, top)]

    # Solve all cases again, or a sample. P(e) needs the compiled engine, which is an extra: without
    # it the other cases can still be checked.
    chosen = every
    if sample is not None and sample < len(every):
        chosen = random.Random(seed).sample(every, sample)
    left_out = ""
    try:
        with naming_extras():
            import_module("longball.engines.batch")
    except MissingExtra as error:
        left_out = f"P(e) is not integrated again: {error}"
        chosen = [case for case in chosen if isinstance(case, Case)]
    calls = ((case, independent) for case in chosen)
    for done, found_wrong in enumerate(in_parallel(_made_again, calls, workers), 1):
        failures += found_wrong
        progress(done, len(chosen))
    return Report(len(every), len(chosen), tuple(failures), left_out, _confirmations(cases))


# --- files ----------------------------------------------------------------------------------------


def _wrong_files(folder: Path) -> Iterator[str]:
    if not (folder / CHECKSUMS).exists():
        yield f"{CHECKSUMS}: there is no such file in {folder}"
        return
    sums = listed(folder)
    for name, digest in sums.items():
        if not inside(folder, name):
            yield f"{CHECKSUMS}: {name!r} is not a file of {folder}"
        elif not (folder / name).is_file():
            yield f"{name}: listed in {CHECKSUMS}, but not there"
        elif checksum(folder / name) != digest:
            yield f"{name}: its SHA-256 is not the one in {CHECKSUMS}; the file was changed"
    # Hidden files, such as those of an interrupted run, are not part of the set.
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_file() and name not in {*sums, CHECKSUMS} and not name.startswith("."):
            yield f"{name}: not listed in {CHECKSUMS}"
    for name, content in schemas().items():
        path = folder / name
        if path.exists() and path.read_text(encoding="utf-8") != content:
            yield f"{name}: not the schema that this version of longball writes"


def _read(model: type[M], path: Path) -> tuple[M | None, str]:
    try:
        return model.model_validate_json(path.read_bytes()), ""
    except FileNotFoundError:
        return None, "there is no such file"
    except ValidationError as error:
        return None, _first_fault(error)


def _read_family(path: Path, family: str, count: int) -> tuple[list[Case], list[str]]:
    if not path.is_file():
        return [], [f"{path.name}: there is no such file"]
    cases, failures = [], []
    lines = path.read_bytes().splitlines()
    for number, line in enumerate(lines, 1):
        try:
            case = Case.model_validate_json(line)
        except ValidationError as error:
            failures.append(f"{path.name}, line {number}: {_first_fault(error)}")
            continue
        cases.append(case)
        if case.family != family:
            failures.append(f"{case.id}: says that its family is {case.family}, not {family}")
    if len(lines) != count:
        failures.append(f"{path.name}: has {len(lines)} cases, {count} in {HEADER}")
    return cases, failures


def _out_of_order(cases: list[Case]) -> Iterator[str]:
    """Yield a sentence for each case that is not in the order of the shipped set."""
    # Reordered lines would leave every checksum of a newly written set right.
    shipped = (draft.scene.id for family in drafts().values() for draft in family.cases)
    place = {name: number for number, name in enumerate(shipped)}
    ids = [case.id for case in cases if case.id in place]
    for stands, belongs in zip(ids, sorted(ids, key=place.__getitem__), strict=True):
        if stands != belongs:
            yield f"{stands}: stands where {belongs} belongs"


def _first_fault(error: ValidationError) -> str:
    fault = error.errors(include_url=False)[0]
    return f"{'.'.join(map(str, fault['loc']))}: {fault['msg']}"


# --- consistency ----------------------------------------------------------------------------------


def _inconsistent(case: Case, top: Header) -> Iterator[str]:
    """Yield the contradictions between a case and the header, and within the case."""
    if case.scene.id != case.id or case.expected.id != case.id:
        yield f"{case.id}: scene and expected result have other ids"
    for flag in case.flags:
        if flag not in top.flags:
            yield f"{case.id}: the flag {flag} is not explained in {HEADER}"
    if case.level not in top.levels:
        yield f"{case.id}: the level {case.level} is not explained in {HEADER}"
    if case.condition and set(case.condition.derivatives) != set(decisive(case.expected)):
        yield f"{case.id}: condition.derivatives has other quantities than the decisive ones"
    # `quantities`, for programs in doubles, repeats the decimal numbers of `expected`.
    known = case.quantities
    if {name for name, _ in numbers_of(case.expected)} != known.keys():
        yield f"{case.id}: quantities are not those of the expected result"
        return
    own = quantities(case.expected, {name: one.attainable for name, one in known.items()})
    for name, number in numbers_of(case.expected):
        if known[name] != own[name]:
            yield f"{case.id}, {name}: {known[name]} is not that of {number.value}, {own[name]}"
        if number.radius is None:
            yield f"{case.id}, {name}: there is no proven radius"


def _confirmations(cases: list[Case]) -> str:
    """Return a sentence on the cases that a second method confirms, with the accuracy."""
    solved = [case for case in cases if case.expected.outcome]
    agreeing = [case.confirmation for case in solved if "unconfirmed" not in case.flags]
    methods = sorted({each.engine.partition(" digits=")[0] for each in agreeing})
    if not agreeing:
        return ""
    largest = max(each.agreement or 0.0 for each in agreeing)
    return (
        f"{len(agreeing)} of {len(solved)} cases with an outcome are confirmed by "
        f"{' and '.join(methods)}, to {largest:.2g} · 1e-30 of each number's size"
    )


# --- cases solved again ---------------------------------------------------------------------------


def _made_again(case: Case | ProbabilityCase, independent: bool) -> list[str]:
    if isinstance(case, Case):
        return solved_again(case, independent)
    return integrated_again(case, independent)


def solved_again(case: Case, independent: bool) -> list[str]:
    """Solve a case again; return a sentence for each difference."""
    failures = [f"{case.id}: {fault}" for fault in _apart(case.expected, prove(case.scene))]
    if independent:
        confirmation, agrees = confirm(case.scene, case.expected)
        if not agrees and "unconfirmed" not in case.flags:
            failures.append(
                f"{case.id}: {confirmation.engine} does not agree: outcome "
                f"{confirmation.outcome}, largest difference {confirmation.agreement} · 1e-30"
            )
    return failures


def _apart(expected: Result, again: Result) -> Iterator[str]:
    """Yield the numbers whose two enclosures do not overlap."""
    if expected.outcome != again.outcome:
        yield f"expected {expected.outcome or expected.error}, now {again.outcome or again.error}"
        return
    now = dict(numbers_of(again))
    # More digits than any number of the set has: the differences are exact.
    with localcontext(prec=100):
        for name, number in numbers_of(expected):
            other = now[name]
            distance = abs(Decimal(number.value) - Decimal(other.value))
            # Both radii are proven: the truth lies in both, so that they must overlap.
            if distance > Decimal(number.radius or 0) + Decimal(other.radius or 0):
                yield (
                    f"{name} is {number.value} ± {number.radius} in the file, "
                    f"solved again {other.value} ± {other.radius}"
                )
