"""The chain of an at-bat: every outcome, and how its parts fit together."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

from longball import engines
from longball.engines.chain import (
    MODEL,
    approach_of,
    collide,
    solve,
    solve_with_restitutions,
)
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.model.quantities import replaced
from longball.model.scene import parse_scene


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


def test_a_tie_with_the_time_limit_is_declined_or_right():
    """Of a hop, whose hang time has the error of the contact; test_stated_errors.py has flights."""
    swing = {"height_offset": -0.0006930463748685695, "tilt": 0.10641549767016717}
    scene = parse_scene(json.dumps({"id": "x", "kind": "at-bat", "swing": swing}))
    proving, precise = Enclosure(20), engines.create("multiprecision", digits=20)
    time = float(solve(scene, proving).landing.hang_time)
    # An ulp of the time is 1e-15 s.
    limits = [time + ulps * math.ulp(time) for ulps in (-60, -1, 0, 1, 30)]
    limited = [replaced(scene, {"time_limit": limit}) for limit in limits]
    truths = [solve(scene, proving).outcome for scene in limited]
    for engine in (engines.create("ivp"), engines.create("batch"), precise):
        found = [solve(scene, engine) for scene in limited]
        for one, truth in zip(found, truths, strict=True):
            assert one.outcome == truth or one.code == "undecided"
        assert engine is precise or None in [one.outcome for one in found]


@pytest.mark.parametrize("engine", ["ivp", "batch"])
def test_a_ball_too_heavy_for_the_bat_is_not_gripped_in_doubles(engine):
    """K is singular to a part in 1e6: by as much a rounding shows in the impulse."""
    position = [0.0696 * math.cos(0.8), 0.0, 1.0 + 0.0696 * math.sin(0.8)]
    incoming = {"position": position, "bat_height": 1.0, "velocity": [0, 0.3, -2]}
    scene = parse_scene(
        json.dumps(
            {
                "kind": "impact",
                "ball": {"mass": 2e5},
                "bat": {"mass": 0.4, "length": 0.2, "friction": 30.0},
                "incoming": incoming | {"spin": [-16, -10, -6]},
                "reading": {"bat_ball_restitution": "nathan", "reduced_mass": "effective_mass"},
            }
        )
    )
    assert solve(scene, Enclosure(20)).impact.mode == "grip"
    result = solve(scene, engines.create(engine))
    assert result.code == "out_of_range"
    assert "too heavy" in result.error


def test_engines_are_made_by_name():
    assert engines.create("ivp", method="RK45", rtol=1e-9) == Ivp("RK45", rtol=1e-9)
    with pytest.raises(ValueError, match="no engine 'x'"):
        engines.create("x")
    with pytest.raises(ValueError, match="takes no dt; it takes method, rtol, atol"):
        engines.create("ivp", dt=0.1)


@pytest.mark.parametrize(
    ("name", "setting", "taken", "refused"),
    [
        ("batch", "tolerance", (1e-14, 1e-4), (0.99e-14, 1.01e-4)),
        ("enclosure", "digits", (1, 500), (0, 501)),
        ("multiprecision", "digits", (1, 290), (0, 291)),
        ("verlet", "dt", (1e-300, 1e300), (0.0, math.inf)),
    ],
)
def test_settings_have_limits(name, setting, taken, refused):
    for value in taken:
        assert getattr(engines.create(name, **{setting: value}), setting) == value
    for value in refused:
        with pytest.raises(ValueError, match=setting):
            engines.create(name, **{setting: value})


def test_a_ball_that_lands_before_the_bat_sets_it_free_has_its_spin():
    """By Verlet's scheme, in whose steps the contact force acts on; its batted flight is none."""
    scene = parse_scene(
        '{"id":"x","kind":"at-bat","ball":{"mass":0.12},"swing":{"height_offset":0.043},'
        '"pitch":{"velocity":[-40.27,-0.8,-1],"spin":[-26,17,-30]}}'
    )
    result = solve(scene, engines.create("verlet"))
    assert result.outcome == "batted"
    assert result.landing.hang_time < 0.05  # a step
    assert result.landing.spin == (-26.0, 17.0, -30.0)


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


def test_the_time_limit_counts_from_the_launch_also_beyond_the_vertical():
    """Always up, lift turns this ball upright, and ends there."""
    text = (
        '{"id":"x","kind":"flight","reading":{"lift_direction":"always_up"},"time_limit":%r,'
        '"launch":{"position":[0,0,1],"velocity":[7.5,-2,58]}}'
    )
    time = solved(text % 60.0).landing.time
    assert solved(text % (0.99 * time)).outcome == "airborne"
    assert solved(text % (1.01 * time)).landing.time == time
