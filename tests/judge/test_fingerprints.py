"""Known mistakes, planted alone and in pairs, are named; noise and strangers are not accused.

The candidates here make their mistakes through another engine setting than the fingerprints do;
those of `test_examples` make them in source code of their own.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal

import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.engines.verlet import Verlet
from longball.judge.alternative_laws import solve_with_drag
from longball.judge.alternative_schemes import solve_in_steps
from longball.judge.answers import Answer
from longball.judge.cases import Known
from longball.judge.diagnosis import Diagnosis
from longball.judge.fingerprints import Atom, Fingerprints, Guess, select_cases
from longball.judge.mistakes import KNOWN, Mistake, Variant
from longball.judge.quantities import values_of
from longball.judge.search import common_step, diagnose
from longball.model.result import Result
from longball.model.scene import Scene

DT = 0.01
ENGINE = Ivp(rtol=1e-12, atol=1e-12)

Answers = Mapping[str, Answer]


@pytest.fixture(scope="module")
def prints(cases: list[Known]) -> Fingerprints:
    return Fingerprints(cases)


def answers(cases: Sequence[Known], solver: Callable[[Scene], Result]) -> Answers:
    results = [solver(case.scene) for case in cases]
    return {r.id: Answer(r.id, r.outcome, values_of(r)) for r in results}


def planted(cases: Sequence[Known], variants: Sequence[Variant], dt: float = DT) -> Answers:
    """Return the answers of a candidate that makes mistakes."""
    options: dict[str, str] = {}
    for variant in variants:
        options |= {k: v for k, v in (variant.scheme or {}).items() if k not in options
                    or options[k] == "predicted_recomputed"}  # fmt: skip
    laws = [variant.drag for variant in variants if variant.drag]

    def base(scene: Scene) -> Result:
        if laws and options and scene.kind != "impact":
            return solve_in_steps(scene, laws[0], Verlet(dt, **options))
        if laws:
            return solve_with_drag(scene, laws[0])
        return solve(scene, Verlet(dt, **options) if options else ENGINE)

    solver = base
    for variant in variants:
        solver = lambda scene, v=variant, inner=solver: v.wrapper(scene, inner, dt)  # noqa: E731
    return answers(cases, solver)


def noisy(cases: Sequence[Known], size: float) -> Answers:
    noise = random.Random(1)
    return {
        case.id: Answer(
            case.id,
            case.expected.outcome,
            {
                name: tuple(Decimal(repr(float(x) * (1 + size * noise.gauss(0, 1)))) for x in value)
                for name, value in values_of(case.expected).items()
            },
        )
        for case in cases
    }


def with_twins(diagnosis: Diagnosis, first: int) -> set[str]:
    suspects = diagnosis.suspects[:first]
    return {name for suspect in suspects for name in (suspect.name, *suspect.twins)}


@pytest.mark.parametrize(
    ("mistake", "variant"),
    [
        pytest.param(mistake, variant, id=f"{name}-{i}")
        for name, mistake in KNOWN.items()
        for i, variant in enumerate(mistake.variants)
    ],
)
def test_a_mistake_alone_is_named_first(
    prints: Fingerprints, cases: list[Known], mistake: Mistake, variant: Variant
):
    diagnosis = diagnose(prints, planted(cases, [variant]))
    assert diagnosis.finding == "known"
    assert diagnosis.named == [mistake.name]
    assert diagnosis.suspects[0].name == mistake.name
    assert diagnosis.share > 0.999
    if variant.steps:
        assert diagnosis.suspects[0].step == pytest.approx(DT)


def pairs(prints: Fingerprints, count: int) -> list[tuple[str, str]]:
    """Return pairs of mistakes that can be made together, and of which neither hides the other."""
    found = []
    everything = list(itertools.combinations(KNOWN, 2))
    random.Random(2).shuffle(everything)
    for pair in everything:
        atoms = [Atom(name, 0) for name in pair]
        step = any(atom.made.steps for atom in atoms)
        both = prints.predict(Guess(tuple(atoms), DT if step else 0.0))
        if both is None:
            continue
        alone = [prints.predict(Guess((atom,), DT if atom.made.steps else 0.0)) for atom in atoms]
        seen = np.isfinite(prints.truth.numbers)
        if all(prints.error(both, one, seen) > 1e-8 for one in alone if one):
            found.append(pair)
        if len(found) == count:
            break
    return found


def test_of_thirty_pairs_both_are_among_the_first_three(prints: Fingerprints, cases: list[Known]):
    chosen = pairs(prints, 30)
    assert len(chosen) == 30
    wrong = {}
    for pair in chosen:
        diagnosis = diagnose(prints, planted(cases, [KNOWN[name].variants[0] for name in pair]))
        if not set(pair) <= with_twins(diagnosis, 3):
            wrong[pair] = diagnosis.sentence
    assert not wrong


def test_the_distance_alone_is_enough(prints: Fingerprints, cases: list[Known]):
    whole = planted(cases, KNOWN["thin-rod"].variants)
    only = {
        i: Answer(i, None, {n: v for n, v in a.values.items() if n == "landing.distance"})
        for i, a in whole.items()
    }
    diagnosis = diagnose(prints, only)
    assert diagnosis.named == ["thin-rod"]
    assert "linear-plate" not in diagnosis.invisible


def test_a_correct_candidate_is_accused_of_nothing(prints: Fingerprints, cases: list[Known]):
    for engine in (Ivp(), Ivp(method="Radau", rtol=1e-12, atol=1e-12)):
        diagnosis = diagnose(prints, answers(cases, lambda scene, e=engine: solve(scene, e)))
        assert diagnosis.finding in ("nothing", "noise")
        assert diagnosis.named == []
    assert diagnose(prints, answers(cases, lambda s: solve(s, Ivp()))).finding == "nothing"


@pytest.mark.parametrize("size", [1e-11, 1e-9, 1e-7])
def test_noise_is_called_noise(prints: Fingerprints, cases: list[Known], size: float):
    diagnosis = diagnose(prints, noisy(cases, size))
    assert diagnosis.finding == "noise"
    assert diagnosis.named == []
    assert diagnosis.error == pytest.approx(size / 2, rel=0.5)


def test_a_loose_tolerance_is_called_noise(prints: Fingerprints, cases: list[Known]):
    loose = Ivp(method="RK45", rtol=1e-6, atol=1e-6)
    assert diagnose(prints, answers(cases, lambda s: solve(s, loose))).finding == "noise"


def drag_crisis(k, v):
    speed = np.linalg.norm(v)
    return -k * (0.8 + 0.4 / (1 + np.exp((speed - 33) / 3))) * speed * v


def wind(k, v):
    relative = v - np.array([-3.0, 1.0, 0.0])
    return -k * np.linalg.norm(relative) * relative


def changed(block: str, key: str, factor: float) -> Callable[[Scene], Result]:
    def solver(scene: Scene) -> Result:
        held = getattr(scene, block, None)
        if held is not None:
            other = held.model_copy(update={key: factor * getattr(held, key)})
            scene = scene.model_copy(update={block: other})
        return solve(scene, ENGINE)

    return solver


@pytest.mark.parametrize(
    "solver",
    [
        pytest.param(lambda scene: solve_with_drag(scene, drag_crisis), id="C_D of the speed"),
        pytest.param(lambda scene: solve_with_drag(scene, wind), id="wind"),
        pytest.param(changed("bat", "mass", 0.97), id="a lighter bat"),
        pytest.param(changed("ball", "restitution", 1.02), id="a livelier ball"),
        pytest.param(changed("air", "density", 0.9), id="thinner air than any known"),
    ],
)
def test_a_stranger_is_called_unknown(prints: Fingerprints, cases: list[Known], solver):
    diagnosis = diagnose(prints, answers(cases, solver))
    assert diagnosis.finding == "unknown"
    assert diagnosis.named == []
    assert "none of the known mistakes" in diagnosis.sentence


def in_single(case_answers: Answers, write: Callable[[np.float32], str]) -> Answers:
    return {
        i: Answer(
            i,
            a.outcome,
            {
                name: tuple(Decimal(write(np.float32(float(x)))) for x in value)
                for name, value in a.values.items()
            },
        )
        for i, a in case_answers.items()
    }


@pytest.mark.parametrize("write", [str, lambda x: f"{x:.9g}", lambda x: repr(float(x))])
def test_single_precision_is_told_by_its_numbers(
    prints: Fingerprints, cases: list[Known], write: Callable[[np.float32], str]
):
    right = answers(cases, lambda scene: solve(scene, ENGINE))
    assert diagnose(prints, in_single(right, write)).named == ["single-precision"]
    heavy = planted(cases, KNOWN["g-9.81"].variants[:1])
    assert diagnose(prints, in_single(heavy, write)).named == ["g-9.81", "single-precision"]


@pytest.mark.parametrize("dt", [0.0073, 1 / 120])
def test_a_time_step_that_nobody_told(prints: Fingerprints, cases: list[Known], dt: float):
    diagnosis = diagnose(prints, planted(cases, KNOWN["lagged-verlet"].variants[:1], dt))
    assert diagnosis.named == ["lagged-verlet"]
    assert diagnosis.suspects[0].step == pytest.approx(dt, rel=1e-6)


def test_a_step_is_read_off_times_that_are_its_multiples():
    times = [0.0037 * k for k in (401, 623, 17, 998, 1200, 77)]
    assert common_step(times) == pytest.approx(0.0037)
    assert common_step([1.1, 1.2]) is None
    assert common_step([x**0.5 for x in (2, 3, 5, 7, 11, 13)]) is None


def test_twins_are_listed_together_and_the_unseen_is_said(cases: list[Known]):
    # Without a bat, and on flights that never turn back, two mistakes show as one and most not.
    flights = [case for case in cases if case.scene.kind == "flight"][:6]
    prints = Fingerprints(flights)
    diagnosis = diagnose(prints, planted(flights, KNOWN["first-below"].variants[:1]))
    assert diagnosis.named == ["first-below"]
    assert {"thin-rod", "nathan", "tunnelling", "linear-plate"} <= set(diagnosis.invisible)
    assert "first-below" not in diagnosis.invisible
    impacts = [case for case in cases if case.scene.kind == "impact"]
    central = [case for case in impacts if case.id == "impact-1"]
    prints = Fingerprints(central)
    only = {
        i: Answer(i, a.outcome, {"impact.restitution": a.values["impact.restitution"]})
        for i, a in planted(central, KNOWN["nathan"].variants).items()
    }
    diagnosis = diagnose(prints, only)
    assert {"nathan", "plain-restitution"} <= with_twins(diagnosis, 1)


def test_no_answers_are_no_mistake(prints: Fingerprints):
    assert diagnose(prints, {}).finding == "nothing"


def test_few_scenes_are_chosen_from_many(cases: list[Known]):
    chosen = select_cases(cases * 5)
    assert len(chosen) <= 44
    assert {case.scene.kind for case in chosen} == {"at-bat", "flight", "impact", "pitch"}
    assert any(case.id == "flight-89" for case in chosen)
