"""The golden probabilities of a home run: made by quadrature, confirmed by scrambled points."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from longball import __version__
from longball.golden.case import Probabilities, ProbabilityCase, ProbabilityRow, Second
from longball.golden.files import PROBABILITIES, TEXTS, schemas, write_files
from longball.golden.reader import probabilities
from longball.home_run import Randomised, integrals, paper_at_bats, scrambled
from longball.home_run.randomised import SCRAMBLES

LINES = 1024  # in each scramble
SEED, SEED_OF_CHECKS = 1, 2
# A mean of 16 scrambles is farther off than five of the errors that they tell with a probability of
# 2e-4 (Student's t with 15 degrees of freedom), which a set of some 40 values does not show.
FARTHEST = 5.0


def write_probabilities(
    folder: Path,
    wanted: Sequence[ProbabilityCase] | None = None,
    *,
    lines: int = LINES,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the file of probabilities into a set; return the number of its cases.

    Computed again are the scene, the sampling and the restitutions of cases, by default those of
    the shipped set, with so many lines in each scramble of the second method. Threads do not change
    what is written.
    """
    chosen = probabilities().cases if wanted is None else wanted
    cases = []
    for case in chosen:
        cases.append(make(case, lines, workers))
        progress(len(cases), len(chosen))
    from longball.engines.batch import Batch  # extra `fast`

    whole = Probabilities(
        title="Longball's golden data: the probability of a home run P(e)",
        numbers=TEXTS["probability"],
        made_by={
            "p": "quadrature",
            "confirmation": f"{SCRAMBLES} scrambles of {lines} Sobol' points",
            "engine": Batch().description,
            "longball": __version__,
            "numpy": version("numpy"),
            "scipy": version("scipy"),
        },
        cases=tuple(cases),
    )
    data = whole.model_dump(mode="json")
    for written, case in zip(data["cases"], cases, strict=True):
        written["scene"] = json.loads(case.scene.line())  # as a line of scenes has it
    content = json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"
    write_files(folder, {PROBABILITIES: content} | schemas())
    return len(cases)


def make(case: ProbabilityCase, lines: int, workers: int) -> ProbabilityCase:
    """Return a case with its integrals, and what the second method makes of them, anew."""
    at_bats, space = paper_at_bats(case.sampling), case.sampling.sample_space
    problem = case.scene, at_bats, [row.e for row in case.rows]
    found = integrals(*problem, sample_space=space, workers=workers)
    # It shares the flights with quadrature, and neither nodes nor the order of integration.
    second = scrambled(*problem, lines, SEED, sample_space=space, workers=workers)
    rows = tuple(
        ProbabilityRow(
            **asdict(row), confirmation=Second(p=other.p, standard_error=other.standard_error)
        )
        for row, other in zip(found, second, strict=True)
    )
    return case.model_copy(update={"rows": rows})


def integrated_again(case: ProbabilityCase, independent: bool) -> list[str]:
    """Compute a case again; return a sentence for each thing that comes out otherwise.

    If `independent`, the second method computes it too, with other scrambles.
    """
    at_bats, space = paper_at_bats(case.sampling), case.sampling.sample_space
    restitutions = [row.e for row in case.rows]
    failures = []
    # the quadrature: both values are estimates, each with an error
    again_found = integrals(case.scene, at_bats, restitutions, sample_space=space)
    for row, again in zip(case.rows, again_found, strict=True):
        for name, known, now, error in (
            ("P", row.p, again.p, row.error + again.error),
            ("dP/de", row.slope, again.slope, row.slope_error + again.slope_error),
        ):
            if abs(known - now) > error:
                failures.append(
                    f"{case.id}, e = {row.e:g}: {name} is {known!r} in the file, computed again "
                    f"{now!r}; their errors allow for {error:.1e}"
                )
    # the second method, as it stands in the file, and with other scrambles
    seconds: list[tuple[ProbabilityRow, Second | Randomised]]
    seconds = [(row, row.confirmation) for row in case.rows]
    if independent:
        points = scrambled(
            case.scene, at_bats, restitutions, LINES, SEED_OF_CHECKS, sample_space=space
        )
        seconds += zip(case.rows, points, strict=True)
    return failures + [
        f"{case.id}, e = {row.e:g}: scrambled points have P = {other.p:.6f} ± "
        f"{other.standard_error:.1e}, the file {row.p:.8f}"
        for row, other in seconds
        if abs(row.p - other.p) > row.error + FARTHEST * other.standard_error
    ]
