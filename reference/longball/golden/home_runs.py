"""The golden probabilities of a home run: made by quadrature, confirmed by scrambled points."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path

from longball import __version__
from longball.golden.files import PROBABILITIES, schemas, write_files
from longball.golden.headers import NUMBERS_OF_PROBABILITIES
from longball.golden.probability import Probabilities, ProbabilityCase, ProbabilityRow, Second
from longball.home_run import RESTITUTIONS, Randomised, integrals, paper_at_bats, scrambled
from longball.home_run.randomised import SCRAMBLES
from longball.model.readings import Reading, SamplingReading, readings_of
from longball.model.scene import AtBatScene

LINES = 1024  # in each scramble
SEED, SEED_OF_CHECKS = 1, 2
# A mean of 16 scrambles is farther off than five of the errors that they tell with a probability of
# 2e-4 (Student's t with 15 degrees of freedom), which a set of some 40 values does not show.
FARTHEST = 5.0


@dataclass(frozen=True)
class ProbabilityDraft:
    """A reading and restitutions of which the probabilities are wanted."""

    id: str
    comment: str
    reading: Reading
    sampling: SamplingReading
    restitutions: Sequence[float]


def drafts() -> Iterator[ProbabilityDraft]:
    """Yield the default reading, and those switches that a scheme for P(e) may get wrong."""
    yield ProbabilityDraft(
        "probability-default", "The default reading of the ledger.", *readings_of({}), RESTITUTIONS
    )
    ends = (RESTITUTIONS[0], RESTITUTIONS[-1])
    for switch, option, comment in (
        ("speed_spread", "as_printed", "Speeds that scatter less."),
        ("cell_width", 0.25, "Aims that scatter more."),
        ("offset_spread", 0.0732, "Offsets that scatter twice as much."),
        ("effective_mass", "as_printed", "A lighter bat towards its pivot."),
        ("reduced_mass", "effective_mass", "An impulse that grows along the bat."),
        ("bat_ball_restitution", "plain", "A restitution that is the same all along the bat."),
        ("inertia", "thin_rod", "A small change of the inertia."),
        ("ground_contact", "surface", "The ball lands a radius earlier."),
        ("sample_space", "batted", "Among batted balls only."),
    ):
        yield ProbabilityDraft(
            f"probability-{switch}-{option}", comment, *readings_of({switch: option}), ends
        )


def write_probabilities(
    folder: Path,
    wanted: Sequence[ProbabilityDraft] | None = None,
    *,
    lines: int = LINES,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the file of probabilities into a set; return the number of its cases.

    Parameters
    ----------
    folder
        The set; its other files are left alone.
    wanted
        What to compute; by default all of `drafts`.
    lines
        Of the second method in each scramble.
    workers
        Threads; -1 for one per core. Their number does not change what is written.
    progress
        Called with the numbers of cases done and of all.
    """
    chosen = list(drafts()) if wanted is None else wanted
    cases = []
    for draft in chosen:
        cases.append(make(draft, lines, workers))
        progress(len(cases), len(chosen))
    from longball.engines.batch import Batch  # extra `fast`

    whole = Probabilities(
        title="Longball's golden data: the probability of a home run P(e)",
        numbers=NUMBERS_OF_PROBABILITIES,
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


def make(draft: ProbabilityDraft, lines: int, workers: int) -> ProbabilityCase:
    """Return a case: its integrals, and what the second method makes of them."""
    scene = AtBatScene(id=draft.id, reading=draft.reading)
    at_bats, space = paper_at_bats(draft.sampling), draft.sampling.sample_space
    found = integrals(scene, at_bats, draft.restitutions, sample_space=space, workers=workers)
    second = scrambled(
        scene, at_bats, draft.restitutions, lines, SEED, sample_space=space, workers=workers
    )
    return ProbabilityCase(
        id=draft.id,
        comment=draft.comment,
        scene=scene,
        sampling=draft.sampling,
        rows=tuple(
            ProbabilityRow(
                **asdict(row), confirmation=Second(p=other.p, standard_error=other.standard_error)
            )
            for row, other in zip(found, second, strict=True)
        ),
    )


def integrated_again(case: ProbabilityCase, independent: bool) -> list[str]:
    """Compute a case again; return a sentence for each thing that comes out otherwise.

    Parameters
    ----------
    case
        From the file.
    independent
        Whether the second method, with other scrambles, computes it too.
    """
    at_bats, space = paper_at_bats(case.sampling), case.sampling.sample_space
    restitutions = [row.e for row in case.rows]
    failures = []
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
