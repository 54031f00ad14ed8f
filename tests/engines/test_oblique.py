"""The oblique impact: jams, balls too heavy for the bat, and how scenes of it are written."""

import math

import pytest

from longball.engines import create
from longball.engines.chain import solve
from longball.model.readings import Reading
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    ImpactScene,
    Incoming,
    InvalidScene,
    Pitch,
    Rotation,
    Swing,
    parse_scene,
)

ENGINES = {name: create(name) for name in ("ivp", "batch", "verlet", "enclosure")}
EVERY_ENGINE = pytest.mark.parametrize("engine", [ENGINES["ivp"], ENGINES["verlet"]], ids=str)
NATHAN = Reading(bat_ball_restitution="nathan")


def touching(angle, y, bat, ball, **more):
    reach = ball.radius + bat.radius
    position = (reach * math.cos(angle), y, 1.0 + reach * math.sin(angle))
    return Incoming(position=position, bat_height=1.0, **more)


def struck(scene, engine):
    result = solve(scene, engine)
    assert result.error is None
    return result


@EVERY_ENGINE
def test_jamming_is_an_error(engine):
    """It takes a disc: no ball jams on a bat that yields more across its axis than along it."""
    disc = Bat(mass=0.01, length=0.05, radius=1.0, friction=0.6)
    still = Rotation(angular_speed=0.0)

    def impact(friction):
        bat = disc.model_copy(update={"friction": friction})
        incoming = touching(0.0, -0.0249, bat, Ball(), velocity=(-1.0, 100.0, 100.0))
        return ImpactScene(id="jam", bat=bat, swing=still, incoming=incoming, reading=NATHAN)

    result = solve(impact(0.6), engine)
    assert "ball and bat jam" in result.error
    assert result.impact is None
    assert struck(impact(0.3), engine).impact.mode == "slide"
    assert struck(impact(2.0), engine).impact.mode == "grip"
    jammed, slid = ENGINES["batch"].solve_all([impact(0.6)] * 20 + [impact(0.3)] * 20)[19:21]
    assert jammed.error is not None
    assert slid.impact.mode == "slide"


@pytest.mark.parametrize(("mass", "told"), [(50.0, True), (2e5, False)])
def test_a_ball_too_heavy_for_the_bat_is_not_gripped_in_doubles(mass, told):
    """K is singular to a part in 1e2 or in 1e6: by as much a rounding shows in the impulse."""
    ball, bat = Ball(mass=mass), Bat(mass=0.4, length=0.2, friction=30.0)
    incoming = touching(0.8, 0.0, bat, ball, velocity=(0.0, 0.3, -2.0), spin=(-16.0, -10.0, -6.0))
    reading = Reading(bat_ball_restitution="nathan", reduced_mass="effective_mass")
    scene = ImpactScene(id="heavy", ball=ball, bat=bat, incoming=incoming, reading=reading)
    truth = struck(scene, ENGINES["enclosure"]).impact
    assert truth.mode == "grip"
    for name in ("ivp", "batch"):
        result = solve(scene, ENGINES[name])
        if told:
            assert result.impact.impulse == pytest.approx(float(truth.impulse), rel=1e-12)
        else:
            assert result.code == "out_of_range"
            assert "too heavy" in result.error


def test_a_flight_with_the_spin_of_an_impact_is_proven():
    """That spin is a ball of numbers, and no step is better than it: the steps are no shorter."""
    scene = AtBatScene(
        id="batted",
        pitch=Pitch(spin=(10.0, 200.0, 30.0)),
        bat=Bat(friction=0.5),
        swing=Swing(height_offset=-0.02),
        air=Air(lift_coefficient={"law": "rational"}),
    )
    proven, found = (solve(scene, ENGINES[name]).landing for name in ("enclosure", "ivp"))
    assert float(proven.distance.radius) < 1e-15
    assert found.distance == pytest.approx(float(proven.distance.value), rel=1e-13)


# --- scenes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bat", "reading", "message"),
    [
        ('"tangential_restitution": 0.3', "", "bat: tangential_restitution needs friction"),
        ('"friction": 0', "", "bat.friction"),
        ('"friction": 1, "tangential_restitution": 1.5', "", "bat.tangential_restitution"),
        ('"support": "held"', "", "bat.support"),
        ('"support": "free"', '"effective_mass": "as_printed"', "bat.support = free has no"),
    ],
)
def test_bad_keys_are_named(bat, reading, message):
    line = f'{{"id": "x", "kind": "at-bat", "bat": {{{bat}}}, "reading": {{{reading}}}}}'
    with pytest.raises(InvalidScene, match=message):
        parse_scene(line)
