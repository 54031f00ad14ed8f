"""Writing the golden data: the only way that it comes about.

Finished cases are kept as they come, so that an interrupted run goes on where it stopped; files
appear whole; and neither the number of workers nor an interruption changes a byte of them.
"""

from __future__ import annotations

import hashlib
import inspect
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from pydantic import ValidationError

import longball
from longball.golden.case import Case
from longball.golden.draft import Draft
from longball.golden.families import FAMILIES
from longball.golden.files import (
    HEADER,
    HISTORIES,
    PARTIAL,
    schemas,
    write_files,
    write_whole,
)
from longball.golden.history import ABOUT, history
from longball.golden.legend import header, made_by
from longball.golden.truth import make
from longball.model.scene import FlightScene

Family = Callable[[], Iterator[Draft]]

# Flights that are tabulated: one of every kind, all of which land.
TABULATED = (
    "flight-vacuum-0000",
    "flight-drag-0000",
    "flight-lift-0002",
    "flight-both-0000",
    "flight-vertical-0002",
    "hard-vertical-spin-2-30",
)


def plan(families: Mapping[str, Family] = FAMILIES) -> dict[str, list[Draft]]:
    """Return the drafts of families: all that there is to be solved. Takes some seconds."""
    return {name: list(family()) for name, family in families.items()}


def write(
    folder: Path,
    families: Mapping[str, Family] = FAMILIES,
    *,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the golden data; return the number of its cases.

    Parameters
    ----------
    folder
        Where to; other files in it are left alone.
    families
        Functions that return the drafts of a family; their docstrings go into the header.
    workers
        Processes; -1 for one a core. They change no byte of what is written.
    progress
        Called with the numbers of cases done, those of an interrupted run included, and of all.
    """
    drafts = plan(families)
    total = sum(map(len, drafts.values()))
    done = 0
    made: dict[str, list[Case]] = {}
    for name, family in drafts.items():
        made[name] = []
        for case in _cases(folder, name, family, workers):
            made[name].append(case)
            done += 1
            progress(done, total)
        order = {draft.scene.id: place for place, draft in enumerate(family)}
        made[name].sort(key=lambda case: order[case.id])
    files = {f"{name}.jsonl": _lines(cases) for name, cases in made.items()}
    tables = dict(_histories(made))
    about = {name: inspect.getdoc(family) or "" for name, family in families.items()}
    top = header(made, about, dict.fromkeys(tables, ABOUT))
    files |= tables | schemas() | {HEADER: top.model_dump_json(indent=2) + "\n"}
    write_files(folder, files)
    shutil.rmtree(folder / PARTIAL, ignore_errors=True)
    return total


def _lines(cases: list[Case]) -> str:
    return "".join(case.line() + "\n" for case in cases)


def _histories(made: Mapping[str, list[Case]]) -> Iterator[tuple[str, str]]:
    for case in (case for cases in made.values() for case in cases):
        if case.id in TABULATED:
            assert isinstance(case.scene, FlightScene)
            assert case.expected.landing is not None
            table = history(case.scene, float(case.expected.landing.time))
            yield f"{HISTORIES}/{case.id}.csv", table


# --- going on after an interruption ---------------------------------------------------------------


def _cases(folder: Path, family: str, drafts: list[Draft], workers: int) -> Iterator[Case]:
    """Yield the cases of a family in any order: first those that an earlier run has finished."""
    from joblib import Parallel, delayed  # slow to import

    kept = folder / PARTIAL / f"{family}.jsonl"
    stamp = fingerprint()
    finished = {case.id: case for case in _finished(kept, stamp)}
    still = [draft for draft in drafts if not _is_of(finished.get(draft.scene.id), draft)]
    unchanged = [finished[draft.scene.id] for draft in drafts if draft not in still]
    # Written anew, so that half a line at its end, or what is out of date, is gone.
    write_whole(kept, stamp + "\n" + _lines(unchanged))
    yield from unchanged
    tasks = (delayed(make)(family, draft) for draft in still)
    with open(kept, "a", encoding="utf-8", newline="\n") as file:
        for case in Parallel(n_jobs=workers, return_as="generator_unordered")(tasks):
            file.write(case.line() + "\n")
            file.flush()
            yield case


def _is_of(case: Case | None, draft: Draft) -> bool:
    return (
        case is not None
        and case.scene == draft.scene
        and case.comment == draft.comment
        and case.flags[: len(draft.flags)] == draft.flags
    )


def _finished(kept: Path, stamp: str) -> Iterator[Case]:
    """Yield the cases that a run of the same code and libraries has left behind."""
    if not kept.exists():
        return
    first, *lines = kept.read_bytes().splitlines() or [b""]
    if first.decode(errors="replace") != stamp:
        return
    for line in lines:
        try:
            yield Case.model_validate_json(line)
        except ValidationError:
            continue  # the run ended in the middle of this line


def fingerprint() -> str:
    """Return a text that changes with the code that takes part and with its libraries."""
    package = Path(longball.__file__).parent
    parts = ("model", "engines", "home_run", "golden")
    sources = sorted(path for part in parts for path in (package / part).glob("*.py"))
    digest = hashlib.sha256(repr(sorted(made_by().items())).encode())
    for path in sources:
        digest.update(path.read_bytes())
    return digest.hexdigest()
