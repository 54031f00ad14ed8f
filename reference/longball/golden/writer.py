"""Writing the golden data.

Finished cases are cached, so that an interrupted run resumes where it stopped. Files are written
atomically, and neither the number of workers nor an interruption changes a byte of them.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from decimal import Decimal, localcontext
from importlib.metadata import version
from pathlib import Path

import flint

import longball
from longball.engines.chain import solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.multiprecision import Multiprecision
from longball.engines.parallel import in_parallel
from longball.extras import naming_extras
from longball.golden.case import Case, Draft, Drafts, Family, Header
from longball.golden.files import (
    DOCUMENTS,
    FORMAT,
    HEADER,
    HISTORIES,
    PARTIAL,
    TEXTS,
    schemas,
    write_files,
)
from longball.golden.reader import DATA, drafts, read_cases
from longball.golden.reader import header as shipped
from longball.golden.truth import CONFIRMING, DIGITS, WORK, make
from longball.model.scene import FlightScene

# Cases with a table of their flight: one of each kind; all of them land.
TABULATED = (
    "flight-vacuum-0000",
    "flight-drag-0000",
    "flight-lift-0002",
    "flight-both-0000",
    "flight-vertical-0002",
    "hard-vertical-spin-2-30",
)


def write(
    folder: Path,
    families: Mapping[str, Drafts] | None = None,
    *,
    only: Collection[str] | None = None,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the golden data into a folder; return the number of cases.

    `families` are the scenes to solve, by default those of the shipped set. With `only`, the cases
    of the other families are read from the folder. Other files in the folder are kept. The number
    of workers does not change the files. `progress` is called with the number of finished cases,
    including those of an interrupted run, and their total.
    """
    families = drafts() if families is None else families
    chosen = families if only is None else {name: families[name] for name in only}
    # joblib is an extra: report its absence before anything is solved.
    with naming_extras():
        from joblib import Memory  # slow to import
    # One cache for each family; it returns the cases that an interrupted run has finished.
    lines = {name: Memory(folder / PARTIAL / name, verbose=0).cache(_line) for name in chosen}
    stamp = fingerprint()
    total = sum(len(family.cases) for family in chosen.values())
    made: dict[str, list[Case]] = {
        name: [] if name in chosen else read_cases(folder / f"{name}.jsonl") for name in families
    }
    for name, family in chosen.items():
        calls = ((stamp, name, draft) for draft in family.cases)
        for text in in_parallel(lines[name], calls, workers):
            made[name].append(Case.model_validate_json(text))
            progress(sum(len(made[name]) for name in chosen), total)
    # All contents are complete before the first file is written: an error changes nothing.
    files = {
        f"{name}.jsonl": "".join(case.line() + "\n" for case in cases)
        for name, cases in made.items()
    }
    tables = {}
    for case in (case for cases in made.values() for case in cases if case.id in TABULATED):
        assert isinstance(case.scene, FlightScene)
        assert case.expected.landing is not None
        table = history(case.scene, float(case.expected.landing.time))
        tables[f"{HISTORIES}/{case.id}.csv"] = table
    # the header counts the cases, so it comes last
    top = header(made, families, dict.fromkeys(tables, ABOUT))
    files |= {name: (DATA / name).read_text(encoding="utf-8") for name in DOCUMENTS}
    files |= tables | schemas() | {HEADER: top.model_dump_json(indent=2) + "\n"}
    write_files(folder, files)
    for name in chosen:
        shutil.rmtree(folder / PARTIAL / name, ignore_errors=True)
    # The folder is not empty if a run of other families was interrupted: keep their cases.
    with suppress(OSError):
        (folder / PARTIAL).rmdir()
    return sum(map(len, made.values()))


def _line(stamp: str, family: str, draft: Draft) -> str:
    """Return a case as its file has it; `stamp` keeps results of other code apart."""
    return make(family, draft).line()


def fingerprint() -> str:
    """Return a text that changes with the code behind the data, and with its libraries."""
    import joblib  # slow to import

    package = Path(longball.__file__).parent
    parts = ("model", "engines", "home_run", "golden")
    sources = (path for part in parts for path in sorted((package / part).rglob("*.py")))
    # joblib keeps a copy of the function with its results
    code = [path.read_bytes() for path in sources if PARTIAL not in path.parts]
    return str(joblib.hash([made_by(), code]))


# --- the header -----------------------------------------------------------------------------------


def header(
    cases: Mapping[str, list[Case]], families: Mapping[str, Drafts], histories: Mapping[str, str]
) -> Header:
    """Return the header of a set, of its cases by family."""
    # Flags and quick cases that the set lacks would explain nothing.
    used = {flag for family in cases.values() for case in family for flag in case.flags}
    ids = {case.id for family in cases.values() for case in family}
    return Header(
        title="Longball's golden data: scenes of baseball at-bats with proven results",
        format=FORMAT,
        licence="CC0-1.0",
        numbers=TEXTS["numbers"],
        levels=TEXTS["levels"],
        flags={flag: TEXTS["flags"][flag] for flag in sorted(used)},
        families={
            name: Family(file=f"{name}.jsonl", cases=len(family), about=families[name].about)
            for name, family in cases.items()
        },
        quick=tuple(name for name in shipped().quick if name in ids),
        histories=dict(histories),
        made_by=made_by(),
    )


def made_by() -> dict[str, str]:
    """Return the versions of longball, Python and the libraries that compute the data."""
    return {
        "truth": f"{Enclosure(DIGITS).description}, and up to {WORK[-1]} where it takes more",
        "confirmation": f"{Multiprecision(CONFIRMING[0]).description}, and up to {CONFIRMING[-1]} "
        "where it takes more",
        "longball": longball.__version__,
        "python-flint": version("python-flint"),
        "FLINT": flint.__FLINT_VERSION__,
        "mpmath": version("mpmath"),
        "numpy": version("numpy"),
    }


# --- histories ------------------------------------------------------------------------------------

COLUMNS = ("time_s", "x_m", "y_m", "z_m", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s")
HISTORY_DIGITS = 20
PER_SECOND = 20  # rows; the paper's Δt = 0.05 s

ABOUT = (
    "Position and velocity of the case's ball every 0.05 s from launch up to the last full step "
    f"before landing. {HISTORY_DIGITS} digits; the last one may be off by one."
)


def history(scene: FlightScene, until: float) -> str:
    """Return the table of a flight, as CSV, for times up to `until`, s."""
    engine = Enclosure(HISTORY_DIGITS + 10)
    numbers = engine.numbers
    lines = [",".join(COLUMNS)]
    with numbers.arithmetic():
        _, trajectory = solve_with_path(scene, engine)
        rows = range(math.floor(until * PER_SECOND) + 1)
        times = [numbers.exact(row) / PER_SECOND for row in rows]
        for row, state in zip(rows, trajectory.sample(times), strict=True):
            reported = [Decimal(numbers.report(x).value) for x in state]
            with localcontext(prec=HISTORY_DIGITS):
                shown = [str(+number) for number in reported]
            lines.append(",".join([f"{row / PER_SECOND:.2f}", *shown]))
    return "\n".join(lines) + "\n"
