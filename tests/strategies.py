"""Scenes and results for hypothesis.

`scenes` are those of `analysis/random_scenes.py`, and `results` any that are valid, however odd.
`flights` and `at_bats` are such as one meets on a field, with parts that a test may choose: every
force may be missing, spin may be top- or backspin.
"""

import math
from typing import get_args

from hypothesis import strategies as st

from analysis.random_scenes import random_scene
from longball.model import result
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Launch,
    Pitch,
    Swing,
)


def between(low, high):
    return st.floats(low, high, allow_subnormal=False)


def scenes(*families):
    """Scenes of some families, of all kinds in turn."""
    return st.builds(random_scene, st.sampled_from(families), st.integers(0, 10**6), st.just(0))


ids = st.text(min_size=1, max_size=8)

# ---- any valid result ----------------------------------------------------------------------------

decimals = st.from_regex(r"[+-]?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,3})?", fullmatch=True)
radii = st.from_regex(r"[0-9](\.[0-9]{1,8})?[eE]-[0-9]{1,3}", fullmatch=True)
finite = st.floats(allow_nan=False, allow_infinity=False)
numbers = (
    finite
    | st.builds(result.Bounded, value=decimals, radius=st.none() | radii)
    | st.builds(result.Certified, value=finite, radius=radii)
)
triples = st.tuples(numbers, numbers, numbers)


def results():
    """Any valid result, of whatever engine."""
    maybe = st.none()
    return st.builds(
        result.Result,
        id=maybe | ids,
        outcome=maybe | st.sampled_from(get_args(result.Outcome)),
        plate=maybe | st.builds(result.Plate, time=numbers, position=triples, velocity=triples),
        contact=maybe
        | st.builds(
            result.Contact,
            time=maybe | numbers,
            position=maybe | triples,
            normal=maybe | triples,
            bat_velocity=maybe | triples,
            normal_speed=maybe | numbers,
            margin=maybe | numbers,
        ),
        impact=maybe
        | st.builds(
            result.Impact,
            restitution=numbers,
            impulse=numbers,
            velocity=triples,
            energy_change=numbers,
        ),
        landing=maybe
        | st.builds(
            result.Landing,
            time=numbers,
            hang_time=numbers,
            position=triples,
            velocity=triples,
            distance=numbers,
        ),
        engine=maybe | st.text(),
        error=maybe | st.text(),
    )


# ---- scenes that are solved ----------------------------------------------------------------------

balls = st.builds(
    Ball, mass=between(0.13, 0.16), radius=between(0.03, 0.04), restitution=between(0.3, 0.6)
)
bats = st.builds(
    Bat, mass=between(0.7, 1.1), length=between(0.8, 1.1), radius=between(0.025, 0.035)
)


def airs(drag=True, lift=True):
    """Air with or without drag and lift: at times there is none though it may be."""
    none = st.just(0.0)
    return st.builds(
        Air,
        density=between(0.8, 1.4),
        drag_coefficient=none | between(0.05, 0.6) if drag else none,
        lift_coefficient=none | between(0.05, 0.3) | between(-0.2, -0.05) if lift else none,
    )


@st.composite
def flights(draw, air=None, elevation=None, heading=None):
    """Flights that come down: 5 to 60 m/s, from 1 to 20 m above the ground."""
    speed = draw(between(5, 60))
    steepness = draw(between(-0.5, 1.4) if elevation is None else elevation)
    azimuth = draw(between(-3, 3) if heading is None else heading)
    level = speed * math.cos(steepness)
    velocity = (
        level * math.cos(azimuth),
        level * math.sin(azimuth),
        speed * math.sin(steepness),
    )
    return FlightScene(
        id="flight",
        ball=draw(balls),
        air=draw(airs() if air is None else air),
        launch=Launch(
            position=draw(st.tuples(between(-20, 20), between(-20, 20), between(1, 20))),
            velocity=velocity,
        ),
    )


@st.composite
def at_bats(draw, **others):
    """Pitches over the plate, most of them hit."""
    pitch = Pitch(
        speed=draw(between(28, 48)),
        release=(draw(between(15, 19)), draw(between(-0.5, 0.5)), draw(between(1.5, 2.1))),
        aim=(draw(between(-0.4, 0.4)), draw(between(1.7, 2.2))),
    )
    swing = Swing(
        angular_speed=draw(between(20, 45)),
        tilt=draw(between(0, 0.3)),
        height_offset=draw(between(-0.05, 0.05)),
    )
    return AtBatScene(
        id="at-bat",
        ball=draw(balls),
        air=draw(airs()),
        pitch=pitch,
        bat=draw(bats),
        swing=swing,
        **others,
    )
