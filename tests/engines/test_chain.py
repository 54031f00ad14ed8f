"""The chain of an at-bat: every outcome, and how its parts fit together."""

from __future__ import annotations

import json
import math
import random
from dataclasses import replace

import numpy as np
import pytest

from longball import engines
from longball.engines.chain import (
    MODEL,
    Run,
    approach_of,
    collide,
    solve,
    solve_with_path,
    solve_with_restitutions,
)
from longball.engines.chain.landing import Batted, _stays_aloft
from longball.engines.enclosure import Enclosure
from longball.engines.engine import Launch
from longball.engines.ivp import Ivp
from longball.model.frame import Frame
from longball.model.law import Force, PlaneState, law_with
from longball.model.quantities import replaced
from longball.model.scene import parse_scene
from longball.model.trace import ZERO


def solved(text: str):
    return solve(parse_scene(text), Ivp())


def test_one_pitch_serves_many_restitutions():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    for e, result in zip(
        (0.3, 0.5), solve_with_restitutions(scene, (0.3, 0.5), Ivp()), strict=True
    ):
        ball = f'"ball":{{"restitution":{e}}}'
        other = solved(f'{{"id":"x","kind":"at-bat",{ball},"swing":{{"height_offset":-0.03}}}}')
        assert result == other


def test_the_approach_is_that_of_the_at_bat():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    approach, result = approach_of(scene, Ivp()), solve(scene, Ivp())
    assert approach.touch.time == result.contact.time
    assert approach.touch.margin == result.contact.margin
    assert approach.pitch.frame.position(approach.touch.state) == result.contact.position


def test_the_path_of_a_scene_runs_from_its_start_to_its_end():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    result, way = solve_with_path(scene, Ivp())
    assert way.at(0.0)[0] == scene.pitch.release
    contact, landing = result.contact, result.landing
    before = way.at(contact.time * (1 - 1e-15))
    assert before[0] == pytest.approx(contact.position, abs=1e-13)  # 40 m/s over an ulp or two
    assert way.at(contact.time) == (contact.position, result.impact.velocity)
    assert way.end == landing.time
    assert way.at(way.end)[0] == pytest.approx(landing.position, abs=1e-12)
    with pytest.raises(ValueError, match=r"no state at t = -1\.0 s"):
        way.at(-1.0)


def test_another_law_or_collision_may_stand_in_the_chain():
    """Known mistakes, alternative readings and fitted laws are the same chain with other parts."""
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')

    def dead(run, contact, error):
        impact, parted = collide(run, contact, error)
        return replace(impact, velocity=(0.0, 0.0, 0.0)), parted

    fallen = solve(scene, Ivp(), replace(MODEL, collide=dead))
    assert fallen.contact == solve(scene, Ivp()).contact
    dropped = '{"id":"x","kind":"flight","launch":{"position":%s,"velocity":[0,0,0]}}'
    alone = solved(dropped % list(fallen.contact.position))
    assert fallen.landing.position == alone.landing.position


def test_a_sideways_force_goes_through_the_whole_chain():
    """1 m/s² to the left of the flight, whatever else acts: y = a t²/2 in a vacuum."""
    across = Force(lambda scene, frame, numbers: {"push": numbers.exact(1.0)}, push_left)
    model = replace(MODEL, forces=(across,))
    scene = parse_scene(
        '{"id":"x","kind":"flight","air":null,"launch":{"position":[0,0,1],"velocity":[30,0,20]}}'
    )
    landing = solve(scene, Ivp(), model).landing
    assert landing.position[1] == pytest.approx(landing.time**2 / 2, rel=1e-14)
    assert landing.position[0] == pytest.approx(30.0 * landing.time, rel=1e-14)


def push_left(motion, p):
    return ZERO, p.push, ZERO


RECONTACT = (
    '{"id":"x","kind":"at-bat","ball":{"mass":%r,"restitution":%r},"bat":{"mass":0.5},'
    '"reading":{"bat_ball_restitution":"plain","reduced_mass":"bat_mass"}}'
)


@pytest.mark.parametrize("engine", ["ivp", "batch", "enclosure", "multiprecision"])
@pytest.mark.parametrize(
    ("mass", "restitution", "said"),
    [
        (0.25, 0.6, None),
        # Of ẽ M / m = 1 the ball leaves with the bat's own speed: by the impulse's definition.
        (0.25, 0.5, "possible"),
        (0.25, 0.4, "certain"),
        (0.25, 0.0, "certain"),
        (0.125, 0.4, None),
        (2.0, 0.4, "certain"),
    ],
)
@pytest.mark.sampled(every=5)
def test_a_ball_that_stays_slower_than_the_bat_is_told(engine, mass, restitution, said):
    scene = parse_scene(RECONTACT % (mass, restitution))
    found = solve(scene, engines.create(engine))
    assert found.outcome == "batted"
    assert found.impact.recontact == said
    if engine == "batch":
        many = engines.create(engine).solve_all([scene, parse_scene('{"kind":"at-bat"}')] * 20)
        assert [result.impact.recontact for result in many] == [said, None] * 20
    if said is None:
        assert "recontact" not in found.line()


@pytest.mark.parametrize("speed", [40.0, 10.5])
def test_a_ball_that_comes_from_behind_the_bat_is_told_too(speed):
    """It overtakes the bat, of 10 m/s, is struck by its back, and is faster still."""
    line = (
        '{"id":"x","kind":"impact","ball":{"mass":%r},"swing":{"angular_speed":20},"reading":'
        '{"bat_ball_restitution":"plain","reduced_mass":"bat_mass"},'
        '"incoming":{"position":[-0.0696,0,1],"velocity":[%r,0,0],"bat_height":1}}'
    )
    assert solved(line % (0.145, speed)).impact.recontact is None
    assert solved(line % (5.0, speed)).impact.recontact == "certain"


@pytest.mark.parametrize(
    "line",
    [
        '{"id":"x","kind":"flight","launch":{"position":[0,0,0],'
        '"velocity":[20.395979199258313,-0.651281012443394,31.6328971210868]}}',
        '{"id":"x","kind":"flight","launch":{"position":[0,0,1],"velocity":[0,0,35]}}',
        # A hop, whose hang time has the error of the contact.
        '{"id":"x","kind":"at-bat","swing":{"height_offset":-0.0006930463748685695,'
        '"tilt":0.10641549767016717}}',
    ],
)
@pytest.mark.sampled(every=3)
def test_a_tie_with_the_time_limit_is_declined_or_right(line, nightly):
    scene = parse_scene(line)
    # An ulp of the time is 1e-15 s.
    proving, precise = Enclosure(20), engines.create("multiprecision", digits=20)
    time = float(solve(scene, proving).landing.hang_time)
    around = (-60, -3, -1, 0, 1, 2, 8, 30) if nightly else (-60, -1, 0, 1, 30)
    limits = [time + ulps * math.ulp(time) for ulps in around]
    limited = [replaced(scene, {"time_limit": limit}) for limit in limits]
    truths = [solve(scene, proving) for scene in limited]
    for engine in (engines.create("ivp"), engines.create("batch"), precise):
        outcomes = set()
        for scene, truth in zip(limited, truths, strict=True):
            found = solve(scene, engine)
            assert found.outcome == truth.outcome or found.code == "undecided", scene.line()
            outcomes.add(found.outcome)
        assert None in outcomes or engine is precise


def test_engines_are_made_by_name():
    assert engines.create("ivp", method="RK45", rtol=1e-9) == Ivp("RK45", rtol=1e-9)
    with pytest.raises(ValueError, match="no engine 'x'"):
        engines.create("x")
    with pytest.raises(ValueError, match="takes no dt; it takes method, rtol, atol"):
        engines.create("ivp", dt=0.1)


def test_a_ball_at_rest_in_empty_space_stays_there():
    rest = '{"id":"x","kind":"flight","gravity":0,"launch":{"position":[0,0,1],"velocity":[0,0,0]}}'
    assert solved(rest).outcome == "airborne"


# --- loops without drag ---------------------------------------------------------------------------


LOOP = (
    '{"id":"x","kind":"flight","gravity":%r,"air":{"drag_coefficient":0,"lift_coefficient":%r},'
    '"launch":{"position":[0,0,%r],"velocity":[%r,0,%r]},"time_limit":%r}'
)


@pytest.mark.parametrize("engine", ["ivp", "batch", "enclosure"])
@pytest.mark.parametrize("gravity", [0.0, 9.8])
@pytest.mark.sampled(every=4)
def test_thousands_of_loops_that_stay_aloft_are_airborne(engine, gravity):
    # 500 m/s² of lift for each m/s: a hundred loops a second, of 15 mm.
    scene = parse_scene(LOOP % (gravity, 4e3, 10.0, 30.0, 20.0, 60.0))
    result = solve(scene, engines.create(engine))
    assert (result.outcome, result.error) == ("airborne", None)


def test_balls_that_stay_aloft_are_those_that_do_not_land(nightly):
    generator = random.Random(7)
    outcomes = set()
    for _ in range(60 if nightly else 30):
        gravity, sign = generator.choice([0.0, 9.8]), generator.choice([-1.0, 1.0])
        lift, height = sign * generator.uniform(0.3, 8.0), generator.uniform(2.0, 40.0)
        u, w = (generator.uniform(-40.0, 40.0) for _ in range(2))
        # Some turns: a ball that lands does so in the first.
        turn = 2 * math.pi / (abs(lift) * _PER_LIFT * math.hypot(u, w))
        scene = parse_scene(LOOP % (gravity, lift, height, u, w, 8 * turn))
        shortcut = solve(scene, Ivp())
        flown = solve(scene, Ivp(), replace(MODEL, forces=(NOTHING,)))
        assert shortcut.outcome == flown.outcome
        outcomes.add((gravity, shortcut.outcome))
    assert len(outcomes) == 4


@pytest.mark.parametrize(("above", "aloft"), [(1e-5, True), (-1e-5, False)])
def test_a_ball_stays_aloft_if_the_bottom_of_its_loop_is_above_the_ground(above, aloft):
    """There V = u: the larger root of ``k V³/3 - g V = k V₀³/3 - g u₀``, at its own energy."""
    gravity, lift = 9.8, 4.0 * _PER_LIFT
    for u, w in ((20.0, 15.0), (-20.0, 15.0), (3.0, -30.0)):
        speed = math.hypot(u, w)
        kept = lift * speed**3 / 3 - gravity * u
        roots = np.polynomial.polynomial.polyroots([-kept, -gravity, 0.0, lift / 3])
        bottom = max(root.real for root in roots if abs(root.imag) < 1e-9)
        height = 30.0 + (speed**2 - bottom**2) / (2 * gravity)
        line = json.loads(LOOP % (gravity, 4.0, 30.0, u, w, 60.0))
        scene = parse_scene(json.dumps(line | {"ground": {"height": height - above}}))
        launch = Launch((0.0, 0.0, 30.0), (u, 0.0, w), 0.0, 0.0)
        law = law_with({"lift": lift, "gravity": gravity})
        ball = Batted(launch, Frame(0.0, 0.0, 1.0, 0.0), law, PlaneState(0.0, 30.0, u, w))
        assert _stays_aloft(Run(scene, Ivp(), MODEL), ball, rows=True) is aloft


def test_the_way_of_a_ball_that_stays_aloft_is_flown_when_asked():
    scene = parse_scene(LOOP % (0.0, 4.0, 20.0, 30.0, 0.0, 2.0))
    result, trajectory = solve_with_path(scene, Ivp())
    assert result.outcome == "airborne"
    position, velocity = trajectory.at(2.0)
    # A circle of the radius 1/k.
    k = 4.0 * _PER_LIFT
    angle = 30.0 * k * 2.0
    expected = (math.sin(angle) / k, 0.0, 20.0 + (1.0 - math.cos(angle)) / k)
    assert position == pytest.approx(expected, abs=1e-11)
    assert math.hypot(*velocity) == pytest.approx(30.0, rel=1e-13)


# k_L of a lift coefficient of 1, 1/m: ρ π R² / (2 m).
_PER_LIFT = 1.29 * math.pi * 0.0366**2 / (2 * 0.145)
# With it the chain takes the law for another one.
NOTHING = Force(lambda scene, frame, numbers: {}, lambda motion, p: (ZERO, ZERO, ZERO))


@pytest.mark.parametrize("engine", ["ivp", "batch", "enclosure", "multiprecision"])
def test_a_flight_of_too_many_steps_is_an_error_that_says_so(engine, monkeypatch):
    monkeypatch.setattr("longball.engines.ivp._MOST_STEPS", 20)
    monkeypatch.setattr("longball.engines.multiprecision._MOST_STEPS", 20)
    monkeypatch.setattr("longball.engines.enclosure.engine._MOST_WORK", 400_000)
    scene = parse_scene(
        '{"id":"x","kind":"flight","air":{"drag_coefficient":0.001,"lift_coefficient":4000},'
        '"launch":{"position":[0,0,1],"velocity":[30,0,30]}}'
    )
    assert "steps" in solve(scene, engines.create(engine)).error


@pytest.mark.parametrize("engine", ["ivp", "batch"])
@pytest.mark.parametrize("spin", ["", ',"spin":[10,-150,30]'])
def test_the_distance_from_a_launch_does_not_hang_on_its_place(engine, spin):
    scene = (
        '{"id":"x","kind":"flight","reading":{"distance_origin":"launch"},'
        '"launch":{"position":[%r,0,1],"velocity":[-3,-20,5]%s}}'
    )
    near, far = (
        solve(parse_scene(scene % (x, spin)), engines.create(engine)).landing.distance
        for x in (0.0, 1e15)
    )
    assert far == near


@pytest.mark.parametrize("engine", ["ivp", "batch"])
def test_a_flight_in_too_many_pieces_is_declined(engine, monkeypatch):
    monkeypatch.setattr("longball.engines.path_engine._MOST_PIECES", 3)
    scene = parse_scene(
        '{"id":"x","kind":"flight","launch":{"position":[0,0,1],"velocity":[40,3,20]},"air":'
        '{"drag_coefficient":{"law":"table","of":"speed","at":[20,30,40],"values":[0.5,0.45,0.33]}}}'
    )
    result = solve(scene, engines.create(engine))
    assert result.code == "too_long"
    assert "over 3 steps; try a shorter time_limit" in result.error


@pytest.mark.parametrize("engine", engines.ENGINES)
def test_a_spin_at_rest_pushes_nowhere(engine):
    scene = parse_scene(
        '{"id":"x","kind":"flight","air":{"lift_coefficient":{"law":"rational"}},'
        '"launch":{"position":[0,0,1],"velocity":[0,0,0],"spin":[20,-250,60]}}'
    )
    result = solve(scene, engines.create(engine))
    assert result.error is not None
    assert result.landing is None
