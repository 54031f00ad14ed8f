"""Other laws of drag: flown exactly, and in the steps of the paper's scheme."""

from __future__ import annotations

import math

import numpy as np
import pytest
from longball.model.motion import forces

from longball.engines.chain import solve
from longball.engines.verlet import TREATMENTS, Verlet
from longball.judge.alternative_laws import THE_MODELS, DragLaw, solve_with_drag
from longball.judge.alternative_schemes import solve_in_steps
from longball.judge.quantities import values_of
from longball.model.numbers import DOUBLES
from longball.model.scene import FlightScene, Launch
from tests.judge.material import at_bats, flights, pitches

EACH_COMPONENT = DragLaw(whole=False, own=True)
FIRST_POWER = DragLaw(whole=False, own=False)


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (THE_MODELS, (-0.3 * 5 * 3, 0.0, 0.3 * 5 * 4)),
        (EACH_COMPONENT, (-0.3 * 9, 0.0, 0.3 * 16)),
        (FIRST_POWER, (-0.3 * 3, 0.0, 0.3 * 4)),
    ],
)
def test_the_laws(law: DragLaw, expected: tuple[float, float, float]):
    assert law(0.3, np.array([3.0, 0.0, -4.0])) == pytest.approx(np.array(expected))


@pytest.mark.parametrize("dt", [0.05, 0.004])
@pytest.mark.parametrize("treatment", TREATMENTS)
@pytest.mark.parametrize("landing", ["interpolated", "first_below"])
def test_under_the_models_law_the_steps_are_the_engines(dt: float, treatment: str, landing: str):
    engine = Verlet(dt, treatment, landing)
    outcomes = set()
    for scene in [*at_bats(20), *flights(), *pitches()]:
        expected, found = solve(scene, engine), solve_in_steps(scene, THE_MODELS, engine)
        outcomes.add(found.outcome)
        assert found.outcome == expected.outcome
        wanted, given = values_of(expected), values_of(found)
        assert given.keys() == wanted.keys()
        for name in wanted:
            # Plane or space: other roundings, of up to ten thousand steps, which a glancing blow
            # enlarges a thousand times. 6e-12 was the most that was seen.
            assert np.array(given[name], float) == pytest.approx(
                np.array(wanted[name], float), rel=1e-10, abs=1e-10
            ), (scene.id, name)
    assert {"batted", "landed", "crossed"} <= outcomes
    assert dt < 0.05 or "missed" in outcomes


def thrown_up(speed: float) -> FlightScene:
    """Return a ball thrown straight up from the ground, without lift."""
    scene = FlightScene(id="up", launch=Launch(position=(0, 0, 0), velocity=(0, 0, speed)))
    return scene.model_copy(update={"air": scene.air.model_copy(update={"lift_coefficient": 0.0})})


def test_the_first_power_falls_as_it_can_be_worked_out():
    scene = thrown_up(30.0)
    k = forces(scene.ball, scene.air, scene.gravity, False, DOUBLES).drag
    end = 9.8 / k  # m/s, the speed at which drag k v balances the weight
    landing = solve_with_drag(scene, FIRST_POWER).landing
    # z(T) = 0 and v(T), from v(t) = (v0 + end) exp(-k t) - end.
    time = landing.time
    assert (30.0 + end) * -math.expm1(-k * time) / k - end * time == pytest.approx(0, abs=1e-7)
    assert landing.velocity[2] == pytest.approx((30.0 + end) * math.exp(-k * time) - end, rel=1e-9)


@pytest.mark.parametrize("law", [EACH_COMPONENT, FIRST_POWER])
def test_short_steps_lead_to_what_is_flown_exactly(law: DragLaw):
    for scene in [*flights()[:4], *pitches()[:2]]:
        expected = values_of(solve_with_drag(scene, law))
        errors = []
        for dt in (1e-2, 1e-3, 1e-4):
            found = values_of(solve_in_steps(scene, law, Verlet(dt, "predicted_recomputed")))
            errors.append(
                max(
                    float(np.max(np.abs(np.array(found[n], float) - np.array(expected[n], float))))
                    for n in expected
                )
            )
        # Second order: a hundredth of the error for a tenth of the step, give or take the phase
        # of the step at the ground; and below what the scene's own drag moves it by, 10 m.
        assert errors[1] < errors[0] / 20
        assert errors[2] < 1e-5
