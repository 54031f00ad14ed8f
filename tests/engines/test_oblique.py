"""The oblique impact: balls too heavy for the bat, and how scenes of it are written.

Jams and balls at the limit of gripping are golden cases (`impact-oblique`).
"""

import math

import pytest

from longball.engines import create
from longball.engines.chain import solve
from longball.model.readings import Reading
from longball.model.scene import (
    Ball,
    Bat,
    ImpactScene,
    Incoming,
    InvalidScene,
    parse_scene,
)


@pytest.mark.parametrize(("mass", "told"), [(50.0, True), (2e5, False)])
def test_a_ball_too_heavy_for_the_bat_is_not_gripped_in_doubles(mass, told):
    """K is singular to a part in 1e2 or in 1e6: by as much a rounding shows in the impulse."""
    ball, bat = Ball(mass=mass), Bat(mass=0.4, length=0.2, friction=30.0)
    reach = ball.radius + bat.radius
    incoming = Incoming(
        position=(reach * math.cos(0.8), 0.0, 1.0 + reach * math.sin(0.8)),
        bat_height=1.0,
        velocity=(0.0, 0.3, -2.0),
        spin=(-16.0, -10.0, -6.0),
    )
    reading = Reading(bat_ball_restitution="nathan", reduced_mass="effective_mass")
    scene = ImpactScene(id="heavy", ball=ball, bat=bat, incoming=incoming, reading=reading)
    truth = solve(scene, create("enclosure")).impact
    assert truth.mode == "grip"
    for name in ("ivp", "batch"):
        result = solve(scene, create(name))
        if told:
            assert result.impact.impulse == pytest.approx(float(truth.impulse), rel=1e-12)
        else:
            assert result.code == "out_of_range"
            assert "too heavy" in result.error


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
