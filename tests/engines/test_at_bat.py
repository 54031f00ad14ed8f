"""The chain of an at-bat: every outcome, and how its parts fit together."""

from __future__ import annotations

import math

import pytest

from longball import engines
from longball.engines.chain import meet, solve, solve_with_restitutions, strike
from longball.engines.ivp import Ivp
from longball.model.scene import parse_scene

IMPACT = '{"id":"x","kind":"impact","swing":{"angular_speed":0},"incoming":{"position":[%s],"velocity":[%s],"bat_height":1}}'  # noqa: E501


def solved(text: str):
    return solve(parse_scene(text), Ivp())


@pytest.mark.parametrize(
    ("outcome", "scene"),
    [
        ("batted", '{"id":"x","kind":"at-bat"}'),
        ("missed", '{"id":"x","kind":"at-bat","swing":{"height_offset":0.08}}'),
        ("beyond_bat", '{"id":"x","kind":"at-bat","pitch":{"aim":[0.6,1.8]}}'),
        ("beyond_bat", '{"id":"x","kind":"at-bat","pitch":{"aim":[-0.6,1.8]}}'),
        ("separating", '{"id":"x","kind":"at-bat","swing":{"angular_speed":-90}}'),
        ("grounded", '{"id":"x","kind":"at-bat","pitch":{"speed":12}}'),
        ("airborne", '{"id":"x","kind":"at-bat","time_limit":0.1}'),
        ("airborne", '{"id":"x","kind":"at-bat","time_limit":1.0,"swing":{"height_offset":-0.03}}'),
        ("crossed", '{"id":"x","kind":"pitch"}'),
        ("grounded", '{"id":"x","kind":"pitch","pitch":{"speed":10}}'),
        ("airborne", '{"id":"x","kind":"pitch","time_limit":0.2}'),
        (
            "landed",
            '{"id":"x","kind":"flight","launch":{"position":[0,0,1],"velocity":[30,2,20]}}',
        ),
        (
            "airborne",
            '{"id":"x","kind":"flight","gravity":0,"launch":{"position":[0,0,1],"velocity":[1,0,1]}}',
        ),
        ("struck", IMPACT % ("0.0696,0,1", "-40,0,0")),
        ("separating", IMPACT % ("0.0696,0,1", "40,0,0")),
        ("separating", IMPACT % ("0.0696,0,1", "0,5,5")),
        ("beyond_bat", IMPACT % ("0.0696,0.5,1", "-40,0,0")),
    ],
)
def test_outcomes(outcome: str, scene: str):
    result = solved(scene)
    assert result.error is None
    assert result.outcome == outcome


def test_the_bat_is_put_where_the_pitch_would_cross():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    result = solve(scene, Ivp())
    alone = solved('{"id":"x","kind":"pitch"}')
    assert result.plate == alone.plate
    height = result.plate.position[2] - 0.03
    x, _, z = result.contact.position
    assert math.hypot(x, z - height) == pytest.approx(0.0366 + 0.033, abs=1e-15)
    assert result.contact.normal[1] == 0.0


def test_the_at_bat_is_its_parts():
    at_bat = solved('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03,"tilt":0.1}}')
    height = at_bat.plate.position[2] - 0.03
    pitch_velocity = [
        after - at_bat.impact.impulse / 0.145 * n
        for after, n in zip(at_bat.impact.velocity, at_bat.contact.normal, strict=True)
    ]
    impact = solved(
        '{"id":"x","kind":"impact","swing":{"tilt":0.1},"incoming":'
        f'{{"position":{list(at_bat.contact.position)},"velocity":{pitch_velocity},"bat_height":{height}}}}}'
    )
    assert impact.impact.velocity == pytest.approx(at_bat.impact.velocity, abs=1e-13)
    assert impact.impact.restitution == at_bat.impact.restitution
    flight = solved(
        '{"id":"x","kind":"flight","launch":'
        f'{{"position":{list(at_bat.contact.position)},"velocity":{list(at_bat.impact.velocity)}}}}}'
    )
    assert flight.landing.position == at_bat.landing.position
    assert at_bat.landing.time == at_bat.contact.time + flight.landing.time
    assert at_bat.landing.hang_time == flight.landing.time


def test_one_pitch_serves_many_restitutions():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    for e, result in zip(
        (0.3, 0.5), solve_with_restitutions(scene, (0.3, 0.5), Ivp()), strict=True
    ):
        ball = f'"ball":{{"restitution":{e}}}'
        other = solved(f'{{"id":"x","kind":"at-bat",{ball},"swing":{{"height_offset":-0.03}}}}')
        assert result == other


def test_meeting_and_striking_are_solving():
    scene = parse_scene('{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03}}')
    assert strike(scene, meet(scene, Ivp()), Ivp()) == solve(scene, Ivp())


def test_a_graze_below_rounding_is_not_decided():
    scene = '{"id":"x","kind":"at-bat","swing":{"height_offset":%r}}'
    reach = 0.0366 + 0.033
    margin = solved(scene % reach).contact.margin
    # Newton on the offset: raising the bat by δ lowers the margin by δ nearly.
    offset = reach + margin
    for _ in range(5):
        result = solved(scene % offset)
        offset += result.contact.margin
    assert abs(result.contact.margin) < 1e-14  # a few ulps of the heights
    assert result.outcome is None
    assert "cannot be decided in double precision" in result.error
    assert result.plate is not None


def test_a_bat_at_the_release_is_an_error():
    result = solved('{"id":"x","kind":"at-bat","pitch":{"release":[0.01,0,1.8],"speed":36}}')
    assert "inside the bat" in result.error


def test_engines_are_made_by_name():
    assert engines.create("ivp", method="RK45", rtol=1e-9) == Ivp("RK45", rtol=1e-9)
    with pytest.raises(ValueError, match="no engine 'x'"):
        engines.create("x")
    with pytest.raises(ValueError, match="takes method, rtol, atol; not dt"):
        engines.create("ivp", dt=0.1)


def test_a_ball_at_rest_in_empty_space_stays_there():
    rest = '{"id":"x","kind":"flight","gravity":0,"launch":{"position":[0,0,1],"velocity":[0,0,0]}}'
    assert solved(rest).outcome == "airborne"
