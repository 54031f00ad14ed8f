"""Known mistakes, planted alone and in pairs, are named; noise and strangers are not accused.

The candidates are another program, `tests/candidates/mistaken.py`, with its switches set; those of
`test_examples` make their mistakes in source code of their own.
"""

from __future__ import annotations

import itertools
import json
import math
import random
from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.engines.verlet import TREATMENTS, Verlet
from longball.judge.answers import Answer, Collector
from longball.judge.cases import Known
from longball.judge.diagnosis import Diagnosis
from longball.judge.fingerprints import Atom, Fingerprints, Guess, select_cases
from longball.judge.mistakes import KNOWN, Mistake
from longball.judge.quantities import values_of
from longball.judge.search import common_step, diagnose
from longball.model.result import Result
from longball.model.scene import Scene
from tests.candidates.mistaken import Switches, by_component, by_first_power, size
from tests.candidates.mistaken import solve as simulate

DT = 0.01
ENGINE = Ivp("DOP853", 1e-12, 1e-12)

Answers = Mapping[str, Answer]


@pytest.fixture(scope="module")
def prints(cases: list[Known]) -> Fingerprints:
    return Fingerprints(cases)


def answers(cases: Sequence[Known], solver: Callable[[Scene], Result]) -> Answers:
    results = [solver(case.scene) for case in cases]
    return {r.id: Answer(r.id, r.outcome, values_of(r)) for r in results}


def slip(*scene: tuple, **switches: Any) -> dict[str, Any]:
    return {"scene": scene, **switches}


def at_once(forces: str) -> dict[str, Any]:
    return slip(forces=forces, push=False)


SOUND = ("predicted_recomputed", "predicted_carried", "implicit")
BELOW = {"forces": SOUND[0], "landing": "first_below"}
LARGER = {"forces": SOUND[0], "root": "larger"}

# How the other program makes each form of each mistake.
SWITCHES: dict[str, list[dict[str, Any]]] = {
    "lagged-verlet": [
        slip(forces="old_carried"),
        slip(forces="old_recomputed"),
        at_once("old_carried"),
        at_once("old_recomputed"),
    ],
    "half-step-verlet": [slip(forces="half_step"), at_once("half_step")],
    "verlet-steps": [at_once(forces) for forces in SOUND],
    "two-step-push": [slip(forces=forces) for forces in SOUND],
    "first-below": [
        *(slip(below=below, on_floor=on) for below in ("start", "launch") for on in (False, True)),
        slip(**BELOW),
        slip(**BELOW, on_floor=True),
    ],
    "linear-plate": [slip(line=True)],
    "tunnelling": [slip(steps_only=True)],
    "larger-root": [slip(**LARGER), slip(**LARGER, parting=True)],
    "drag-per-component": [slip(drag=by_component)],
    "drag-with-v": [slip(drag=by_first_power)],
    "lift-sign": [slip(("air", "lift_coefficient", "times", -1.0))],
    "lift-always-up": [slip(upward=True)],
    "plain-restitution": [slip(restitution="plain")],
    "nathan": [slip(restitution="nathan")],
    "effective-mass": [slip(arm_power=1)],
    "reduced-mass": [slip(restitution="effective")],
    "thin-rod": [slip(inertia="rod")],
    "inertia-about-centre": [slip(inertia="centre")],
    "other-pivot": [slip(other_end=True), slip(other_end=True, backwards=True)],
    "tilt-in-degrees": [
        slip(("swing", "tilt", "times", math.radians(1))),
        slip(("swing", "tilt", "times", math.degrees(1))),
    ],
    "speed-in-km/h": [
        slip(("pitch", "speed", "times", 1 / 3.6)),
        slip(("pitch", "speed", "times", 3.6)),
    ],
    "radius-or-diameter": [
        slip(("ball", "radius", "times", 2.0)),
        slip(("ball", "radius", "times", 0.5)),
    ],
    "g-9.81": [slip(("", "gravity", 9.81)), slip(("", "gravity", 9.80665))],
    "air-1.225": [slip(("air", "density", 1.225))],
    "air-1.2": [slip(("air", "density", 1.2)), slip(("air", "density", 1.204))],
    "distance-from-contact": [
        slip(from_contact=True),
        slip(from_contact=True, from_launch=True),
    ],
    "landing-of-surface": [slip(surface=True)],
}


def test_every_form_of_every_mistake_can_be_planted():
    assert {name: len(forms) for name, forms in SWITCHES.items()} == {
        name: len(mistake.variants) for name, mistake in KNOWN.items()
    }


def planted(cases: Sequence[Known], *slips: dict[str, Any], dt: float = DT) -> Answers:
    """Return the answers of the other program with some mistakes."""
    switches: dict[str, Any] = {}
    for slip in slips:
        # A mistake of the scheme that says nothing of the forces takes them as another has them.
        forces = {switches.get("forces", SOUND[0]), slip.get("forces", SOUND[0])} - {SOUND[0]}
        scene = (*switches.get("scene", ()), *slip["scene"])
        switches |= slip | {"scene": scene}
        if "forces" in switches and forces:
            (switches["forces"],) = forces
    how = Switches(dt, **switches)
    collector = Collector([case.id for case in cases])
    for number, case in enumerate(cases, 1):
        result = simulate(json.loads(case.scene.line()), how)
        collector.take_line(number, json.dumps(result).encode())
    assert not collector.issues
    return collector.answers


def differences(found: Answers, expected: Answers) -> list[float]:
    """Return how far numbers are apart that both have, in the same outcomes."""
    apart = []
    for name, answer in expected.items():
        assert found[name].outcome == answer.outcome
        for quantity, value in found[name].values.items():
            apart += [
                abs(float(a - b)) for a, b in zip(value, answer.values[quantity], strict=True)
            ]
    return apart


def test_the_other_program_is_right_but_for_its_switches(cases: list[Known]):
    # Its steps' errors of 1e-11 m, amplified up to a thousand times by ball and bat.
    assert max(differences(planted(cases), answers(cases, lambda s: solve(s, ENGINE)))) < 1e-8


@pytest.mark.parametrize("forces", TREATMENTS)
def test_the_other_program_steps_as_the_paper(cases: list[Known], forces: str):
    expected = answers(cases, lambda scene: solve(scene, Verlet(DT, forces)))
    # Roundings of a thousand steps, amplified as above.
    assert max(differences(planted(cases, slip(forces=forces)), expected)) < 1e-10


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
    ("mistake", "form"),
    [
        pytest.param(mistake, i, id=f"{name}-{i}")
        for name, mistake in KNOWN.items()
        for i in range(len(mistake.variants))
    ],
)
def test_a_mistake_alone_is_named_first(
    prints: Fingerprints, cases: list[Known], mistake: Mistake, form: int
):
    diagnosis = diagnose(prints, planted(cases, SWITCHES[mistake.name][form]))
    assert diagnosis.finding == "known"
    assert diagnosis.named == [mistake.name]
    assert diagnosis.suspects[0].name == mistake.name
    assert diagnosis.share > 0.999
    if mistake.variants[form].steps:
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
        diagnosis = diagnose(prints, planted(cases, *(SWITCHES[name][0] for name in pair)))
        if not set(pair) <= with_twins(diagnosis, 3):
            wrong[pair] = diagnosis.sentence
    assert not wrong


def test_the_distance_alone_is_enough(prints: Fingerprints, cases: list[Known]):
    whole = planted(cases, *SWITCHES["thin-rod"])
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
    return [-k * (0.8 + 0.4 / (1 + math.exp((size(v) - 33) / 3))) * size(v) * c for c in v]


def wind(k, v):
    relative = [v[0] + 3.0, v[1] - 1.0, v[2]]
    return [-k * size(relative) * c for c in relative]


@pytest.mark.parametrize(
    "stranger",
    [
        pytest.param(slip(drag=drag_crisis), id="C_D of the speed"),
        pytest.param(slip(drag=wind), id="wind"),
        pytest.param(slip(("bat", "mass", "times", 0.97)), id="a lighter bat"),
        pytest.param(slip(("ball", "restitution", "times", 1.02)), id="a livelier ball"),
        pytest.param(slip(("air", "density", "times", 0.9)), id="thinner air than any known"),
    ],
)
def test_a_stranger_is_called_unknown(prints: Fingerprints, cases: list[Known], stranger):
    diagnosis = diagnose(prints, planted(cases, stranger))
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
    heavy = planted(cases, SWITCHES["g-9.81"][0])
    assert diagnose(prints, in_single(heavy, write)).named == ["g-9.81", "single-precision"]


@pytest.mark.parametrize("dt", [0.0073, 1 / 120])
def test_a_time_step_that_nobody_told(prints: Fingerprints, cases: list[Known], dt: float):
    diagnosis = diagnose(prints, planted(cases, SWITCHES["lagged-verlet"][0], dt=dt))
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
    diagnosis = diagnose(prints, planted(flights, SWITCHES["first-below"][0]))
    assert diagnosis.named == ["first-below"]
    assert {"thin-rod", "nathan", "tunnelling", "linear-plate"} <= set(diagnosis.invisible)
    assert "first-below" not in diagnosis.invisible
    impacts = [case for case in cases if case.scene.kind == "impact"]
    central = [case for case in impacts if case.id == "impact-1"]
    prints = Fingerprints(central)
    only = {
        i: Answer(i, a.outcome, {"impact.restitution": a.values["impact.restitution"]})
        for i, a in planted(central, *SWITCHES["nathan"]).items()
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
