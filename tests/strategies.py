"""Scenes and results for hypothesis.

`scenes` and `results` are any that are valid, however odd: they are read and written, not solved.
`flights`, `at_bats` and `impacts` are such as one meets on a field, and more: every force may be
missing, spin may be top- or backspin. Those are solved.
"""

import math
from typing import get_args

from hypothesis import strategies as st

from longball.model import result
from longball.model.readings import Reading
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Ground,
    ImpactScene,
    Incoming,
    Launch,
    Pitch,
    PitchScene,
    Rotation,
    Swing,
)


def between(low, high):
    return st.floats(low, high, allow_subnormal=False)


def points(x, y, z):
    return st.tuples(x, y, z)


ids = st.text(min_size=1, max_size=8)

# ---- any valid scene -----------------------------------------------------------------------------

reals = st.floats(-1e6, 1e6)
positives = st.floats(1e-30, 1e6)
not_negatives = st.floats(0.0, 1e6)
any_points = points(reals, reals, reals)


def consistent(reading):
    """True if the options do not contradict each other; see `Reading`."""
    return (reading["bat_ball_restitution"], reading["reduced_mass"]) != (
        "plain",
        "effective_mass",
    )


def readings():
    """Any combination of options."""
    switches = {
        name: st.sampled_from(get_args(field.annotation))
        for name, field in Reading.model_fields.items()
    }
    return st.fixed_dictionaries(switches).filter(consistent).map(lambda d: Reading(**d))


any_balls = st.builds(Ball, mass=positives, radius=between(1e-3, 1), restitution=st.floats(0, 1))
any_airs = st.none() | st.builds(
    Air, density=not_negatives, drag_coefficient=not_negatives, lift_coefficient=reals
)
any_bats = st.builds(Bat, mass=positives, length=positives, radius=between(1e-3, 1))
any_pitches = st.builds(
    Pitch,
    speed=positives,
    release=points(positives, reals, st.floats(1, 1e6)),  # above the surface of any ball
    aim=st.tuples(reals, reals),
)
any_flying = {
    "id": ids,
    "ball": any_balls,
    "reading": readings(),
    "air": any_airs,
    "gravity": not_negatives,
    "time_limit": positives,
}


@st.composite
def any_flights(draw):
    height = draw(reals)
    x, y, above = draw(points(reals, reals, st.floats(2, 1e6)))  # more than any ball's radius
    launch = Launch(position=(x, y, height + above), velocity=draw(any_points))
    others = {name: draw(strategy) for name, strategy in any_flying.items()}
    return FlightScene(launch=launch, ground=Ground(height=height), **others)


@st.composite
def touchings(draw, ball, bat, heights, ys, velocities):
    """Balls that touch a bat, anywhere around it."""
    angle = draw(between(-math.pi, math.pi))
    reach, height = ball.radius + bat.radius, draw(heights)
    position = (reach * math.cos(angle), draw(ys), height + reach * math.sin(angle))
    return Incoming(position=position, velocity=draw(velocities), bat_height=height)


@st.composite
def any_impacts(draw):
    ball, bat = draw(any_balls), draw(any_bats)
    swing = Rotation(angular_speed=draw(reals), tilt=draw(reals))
    incoming = draw(touchings(ball, bat, between(-1e3, 1e3), reals, any_points))
    return ImpactScene(
        id=draw(ids), ball=ball, reading=draw(readings()), bat=bat, swing=swing, incoming=incoming
    )


def scenes():
    """Any valid scene, of any kind."""
    pitches = st.builds(PitchScene, **any_flying, pitch=any_pitches)
    swings = st.builds(Swing, angular_speed=reals, tilt=reals, height_offset=reals)
    grounds = st.builds(Ground, height=between(-1e6, 0))
    at_bats = st.builds(
        AtBatScene, **any_flying, pitch=any_pitches, bat=any_bats, swing=swings, ground=grounds
    )
    return any_flights() | pitches | any_impacts() | at_bats


# ---- any valid result ----------------------------------------------------------------------------

decimals = st.from_regex(r"[+-]?[0-9]{1,40}(\.[0-9]{1,40})?([eE][+-]?[0-9]{1,3})?", fullmatch=True)
radii = st.from_regex(r"[0-9](\.[0-9]{1,8})?[eE]-[0-9]{1,3}", fullmatch=True)
finite = st.floats(allow_nan=False, allow_infinity=False)
numbers = (
    finite
    | st.builds(result.Bounded, value=decimals, radius=st.none() | radii)
    | st.builds(result.Certified, value=finite, radius=radii)
)
triples = points(numbers, numbers, numbers)


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
            position=draw(points(between(-20, 20), between(-20, 20), between(1, 20))),
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


@st.composite
def impacts(draw):
    """Touchings of all sorts: with a bat that comes, stands or goes."""
    ball, bat = draw(balls), draw(bats)
    swing = Rotation(angular_speed=draw(between(-45, 45)), tilt=draw(between(-0.5, 0.5)))
    half = bat.length / 2
    speeds = between(-50, 50)
    incoming = draw(
        touchings(
            ball,
            bat,
            between(0.2, 1.8),
            between(-0.9 * half, 0.9 * half),
            points(speeds, between(-5, 5), speeds),
        )
    )
    return ImpactScene(id="impact", ball=ball, bat=bat, swing=swing, incoming=incoming)
