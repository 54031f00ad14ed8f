"""Golden probabilities of a home run, by quadrature; scrambled points confirm them."""

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

LINES = 1024  # in each scramble of the second method
# Checks draw other points than the file, so that they confirm it independently.
SEED, SEED_OF_CHECKS = 1, 2
# In standard errors. The mean of 16 scrambles is off by more than five of its estimated standard
# errors with a probability of 2e-4 (Student's t, 15 degrees of freedom), of 1 % in 40 values.
FARTHEST = 5.0


def write_probabilities(
    folder: Path,
    wanted: Sequence[ProbabilityCase] | None = None,
    *,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the file of probabilities of a set; return the number of its cases.

    `wanted` gives scenes, samplings and restitutions, by default those of the shipped set. The
    number of workers does not change the file.
    """
    chosen = probabilities().cases if wanted is None else wanted
    cases = []
    for case in chosen:
        cases.append(make(case, workers))
        progress(len(cases), len(chosen))
    from longball.engines.batch import Batch  # extra `fast`

    whole = Probabilities(
        title="Longball's golden data: the probability of a home run P(e)",
        numbers=TEXTS["probability"],
        made_by={
            "p": "quadrature",
            "confirmation": f"{SCRAMBLES} scrambles of {LINES} Sobol' points",
            "engine": Batch().description,
            "longball": __version__,
            "numpy": version("numpy"),
            "scipy": version("scipy"),
        },
        cases=tuple(cases),
    )
    data = whole.model_dump(mode="json")
    for written, case in zip(data["cases"], cases, strict=True):
        # In the form that `longball solve` reads, not with every field of the model.
        written["scene"] = json.loads(case.scene.line())
    content = json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"
    write_files(folder, {PROBABILITIES: content} | schemas())
    return len(cases)


def make(case: ProbabilityCase, workers: int) -> ProbabilityCase:
    """Compute a case: its integrals, and their confirmation by the second method."""
    at_bats, space = paper_at_bats(case.sampling), case.sampling.sample_space
    problem = case.scene, at_bats, [row.e for row in case.rows]
    computed = integrals(*problem, sample_space=space, workers=workers)
    # It shares the flights with the quadrature, but neither the nodes nor the order of integration.
    second = scrambled(*problem, LINES, SEED, sample_space=space, workers=workers)
    rows = tuple(
        ProbabilityRow(
            **asdict(row), confirmation=Second(p=other.p, standard_error=other.standard_error)
        )
        for row, other in zip(computed, second, strict=True)
    )
    return case.model_copy(update={"rows": rows})


def integrated_again(case: ProbabilityCase, independent: bool) -> list[str]:
    """Compute a case again; return a sentence for each difference.

    If `independent`, the second method also computes it, with other scrambles.
    """
    at_bats, space = paper_at_bats(case.sampling), case.sampling.sample_space
    restitutions = [row.e for row in case.rows]
    failures = []
    # the quadrature: both values are estimates, so their difference may be the sum of both errors
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
    # the second method: its values in the file, and those with other scrambles
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
