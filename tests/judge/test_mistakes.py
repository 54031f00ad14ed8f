"""Other laws of drag, flown exactly and in steps; a moment later or earlier."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from longball.engines.chain import Model, solve, solve_with_path
from longball.engines.ivp import Ivp
from longball.engines.verlet import TREATMENTS, Verlet
from longball.judge.mistakes import DRAG_BY_COMPONENT, DRAG_WITH_V, SMALL, Solver
from longball.judge.quantities import values_of
from longball.model.frame import Frame
from longball.model.law import DRAG, GRAVITY, LIFT, Force, SpaceState, law_of
from longball.model.numbers import DOUBLES
from longball.model.scene import FlightScene, Launch
from tests.candidates import mistaken
from tests.judge.material import at_bats, flights, pitches

BY_COMPONENT = Model(forces=(DRAG_BY_COMPONENT, LIFT, GRAVITY))
FIRST_POWER = Model(forces=(DRAG_WITH_V, LIFT, GRAVITY))
EXACT = Ivp("DOP853")


def rates(force: Force, frame: Frame[float], velocity: tuple[float, float, float]) -> np.ndarray:
    """Return the acceleration in space, over k, of a ball with a velocity, m/s, in a frame."""
    scene = flights()[0]
    law = law_of(scene, frame, DOUBLES, (force,))
    state = SpaceState(0.0, 0.0, 2.0, *velocity)
    if law.state is not SpaceState:
        state = law.state(0.0, 2.0, velocity[0], velocity[2])
    derivative = law.state(*law.rates(DOUBLES)(*state))
    (k,) = DRAG.strengths(scene, frame, DOUBLES)
    change = [getattr(derivative, name, 0.0) / k for name in "uvw"]
    return np.array(frame.velocity(SpaceState(0.0, 0.0, 0.0, *change)))


@pytest.mark.parametrize("heading", [0.0, 0.6, math.pi])
def test_each_component_is_dragged_by_itself(heading: float):
    frame = Frame(0.0, 0.0, math.cos(heading), math.sin(heading))
    velocity = np.array(frame.velocity(SpaceState(0.0, 0.0, 0.0, 3.0, 1.0, -4.0)))
    # What stands for |c| is too large by SMALL⁴/(8 |c|³), and at 0 it is SMALL/2, times c = 0.
    expected = pytest.approx(-np.abs(velocity) * velocity, abs=SMALL**4)
    assert rates(DRAG_BY_COMPONENT, frame, (3.0, 1.0, -4.0)) == expected


def test_the_first_power_is_against_the_velocity():
    frame = Frame(0.0, 0.0, 0.6, 0.8)
    # In the plane of the launch, where it stays: 5 m/s along it is (3, 4) m/s.
    assert rates(DRAG_WITH_V, frame, (5.0, 0.0, -4.0)) == pytest.approx(np.array([-3, -4, 4]))


def test_a_component_that_is_nothing_stays_nothing():
    scene = flights()[0].model_copy(
        update={"launch": Launch(position=(0, 0, 1), velocity=(30, 0, 20))}
    )
    landing = solve(scene, EXACT, BY_COMPONENT).landing
    assert landing.position[1] == landing.velocity[1] == 0.0


def thrown_up(speed: float) -> FlightScene:
    """Return a ball thrown straight up from the ground, without lift."""
    scene = FlightScene(id="up", launch=Launch(position=(0, 0, 0), velocity=(0, 0, speed)))
    return scene.model_copy(update={"air": scene.air.model_copy(update={"lift_coefficient": 0.0})})


@pytest.mark.parametrize("engine", [Ivp(), EXACT])
def test_the_first_power_falls_as_it_can_be_worked_out(engine: Ivp):
    scene = thrown_up(30.0)
    (k,) = DRAG.strengths(scene, None, DOUBLES)
    end = 9.8 / k  # m/s, the speed at which drag k v balances the weight
    landing = solve(scene, engine, FIRST_POWER).landing
    # z(T) = 0 and v(T), from v(t) = (v0 + end) exp(-k t) - end; end is 2 km/s, so 1e-12 of it.
    time = landing.time
    assert (30.0 + end) * -math.expm1(-k * time) / k - end * time == pytest.approx(0, abs=1e-9)
    assert landing.velocity[2] == pytest.approx((30.0 + end) * math.exp(-k * time) - end, abs=1e-9)


@pytest.mark.parametrize("engine", [Ivp(), EXACT])
def test_a_ball_thrown_up_is_dragged_by_component_as_by_the_model(engine: Ivp):
    scene = thrown_up(30.0)
    expected = solve(scene, engine).landing
    found = solve(scene, engine, BY_COMPONENT).landing
    # SMALL, where the ball comes to rest, is there for 1e-4 s.
    assert found.time == pytest.approx(expected.time, rel=1e-12)
    assert found.velocity[2] == pytest.approx(expected.velocity[2], rel=1e-12)


@pytest.mark.parametrize(
    ("model", "drag"),
    [(BY_COMPONENT, mistaken.by_component), (FIRST_POWER, mistaken.by_first_power)],
)
def test_another_program_flies_the_same(model: Model, drag: object):
    for scene in [*at_bats(), *flights(), *pitches()]:
        result = solve(scene, EXACT, model)
        other = mistaken.solve(json.loads(scene.line()), mistaken.Switches(drag=drag))
        assert result.outcome == other["outcome"]
        block, name = ("landing", "position") if "landing" in other else ("plate", "position")
        # Its steps go through the kinks without a stop, which costs them 1e-7 m; ball and bat
        # amplify that a thousand times.
        bound = 1e-4 if scene.kind == "at-bat" else 1e-6
        assert getattr(result, block).position == pytest.approx(other[block][name], abs=bound)


@pytest.mark.parametrize("model", [BY_COMPONENT, FIRST_POWER])
@pytest.mark.parametrize("forces", ["predicted_recomputed", "implicit"])
def test_short_steps_lead_to_what_is_flown_exactly(model: Model, forces: str):
    for scene in [*flights()[:4], *pitches()[:2]]:
        expected = values_of(solve(scene, EXACT, model))
        errors = []
        for dt in (1e-2, 1e-3, 1e-4):
            found = values_of(solve(scene, Verlet(dt, forces), model))
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


@pytest.mark.parametrize("forces", TREATMENTS)
@pytest.mark.parametrize("drag", [mistaken.by_component, mistaken.by_first_power])
def test_at_bats_in_steps_are_those_of_another_program(forces: str, drag: object):
    model = BY_COMPONENT if drag is mistaken.by_component else FIRST_POWER
    batted = 0
    for scene in at_bats():
        result = solve(scene, Verlet(0.004, forces), model)
        switches = mistaken.Switches(0.004, forces, drag=drag)
        other = mistaken.solve(json.loads(scene.line()), switches)
        assert result.outcome == other["outcome"]
        if result.landing:
            batted += 1
            # SMALL, amplified by ball and bat.
            assert result.landing.position == pytest.approx(other["landing"]["position"], abs=1e-8)
    assert batted > 4


def test_a_moment_later_or_earlier_is_on_the_path():
    for model in (BY_COMPONENT, FIRST_POWER, Model()):
        scene = flights()[2]
        leg = solve_with_path(scene, Ivp(), model)[1].legs[0]
        before, now, after = (leg.flight.path.at(t) for t in (0.45, 0.5, 0.55))
        solver = Solver(lambda scene: solve(scene, Ivp()), model.forces)
        for seconds, state in ((-0.05, before), (0.05, after)):
            position, velocity = solver.moved(
                scene, leg.frame.position(now), leg.frame.velocity(now), seconds
            )
            # The lift's axis is that of a launch from here; where each component is dragged by
            # itself, the ball heads elsewhere by now than at its launch.
            bound = 1e-3 if model is BY_COMPONENT else 1e-12
            assert position == pytest.approx(leg.frame.position(state), abs=bound)
            assert velocity == pytest.approx(leg.frame.velocity(state), abs=10 * bound)
