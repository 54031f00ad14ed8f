"""Properties of every scene: symmetries, invariants, restarts, refusals.

All is asked of the reference engine through the chain that every engine uses. Where both sides of
a comparison do the same roundings, they are compared bit for bit. Elsewhere the tolerance is the
engine's own statement of its error, `flight_error`, carried to the quantity at hand: each function
below that returns a tolerance says how.
"""

import json
import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from longball.engines import chain
from longball.engines.ivp import Ivp
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES
from longball.model.result import Result
from longball.model.scene import (
    Ball,
    Bat,
    Incoming,
    InvalidScene,
    Launch,
    Rotation,
    parse_scene,
)
from tests import exact
from tests.scenes import between, paper_scenes, results, scenes

ENGINE = Ivp()
ERROR = ENGINE.flight_error


def solve(scene):
    solved = chain.solve(scene, ENGINE)
    assert solved.error is None
    return solved


def landed(scene):
    """Landing of a flight that has one: with lift and no drag a ball can swing on for ever."""
    landing = solve(scene).landing
    assume(landing is not None)
    return landing


def altered(scene, **changes):
    """Another scene, validated as the first was."""
    return type(scene)(
        **{name: getattr(scene, name) for name in type(scene).model_fields} | changes
    )


def launched(scene, position, velocity):
    return altered(scene, launch=Launch(position=position, velocity=velocity))


def size(vector):
    return math.hypot(*vector)


def landing_tolerance(scene, landing):
    """m: what two solutions of a flight may be apart on the ground.

    The error of each state across the path is flight_error times its size, here the length of the
    way, at most; on the ground it is stretched by one over the sine of the angle of landing.
    """
    speed = max(size(scene.launch.velocity), size(landing.velocity))
    way = speed * landing.hang_time + size(scene.launch.position)
    return 2 * ERROR * way * speed / abs(landing.velocity[2])


# ---- symmetries ----------------------------------------------------------------------------------


def mirrored(vector):
    x, y, *rest = vector
    return (x, -y, *rest)


def turned(vector):
    x, y, z = vector
    return (-y, x, z)


@given(paper_scenes("flight"))
def test_a_mirrored_or_turned_flight_is_the_same_bit_for_bit(scene):
    here = landed(scene)
    for moved in (mirrored, turned, lambda v: turned(turned(v)), lambda v: turned(mirrored(v))):
        launch = launched(scene, moved(scene.launch.position), moved(scene.launch.velocity))
        there = solve(launch).landing
        assert (there.time, there.distance) == (here.time, here.distance)
        assert there.position == moved(here.position)
        assert there.velocity == moved(here.velocity)


# Times 2, lengths 4 and masses 4³, so that densities stay: by how much other quantities grow.
LARGER = {
    "position": 4.0, "velocity": 2.0, "bat_velocity": 2.0, "normal": 1.0, "normal_speed": 2.0,
    "restitution": 1.0, "impulse": 128.0, "energy_change": 256.0,
}  # fmt: skip


@given(paper_scenes("impact"))
def test_an_impact_of_larger_bodies_is_the_same_bit_for_bit(scene):
    ball, bat, swing, incoming = scene.ball, scene.bat, scene.swing, scene.incoming
    larger = altered(
        scene,
        ball=Ball(mass=64 * ball.mass, radius=4 * ball.radius, restitution=ball.restitution),
        bat=Bat(mass=64 * bat.mass, length=4 * bat.length, radius=4 * bat.radius),
        swing=Rotation(angular_speed=swing.angular_speed / 2, tilt=swing.tilt),
        incoming=Incoming(
            position=tuple(4 * x for x in incoming.position),
            velocity=tuple(2 * v for v in incoming.velocity),
            bat_height=4 * incoming.bat_height,
        ),
    )
    here, there = solve(scene), solve(larger)
    assert there.outcome == here.outcome
    for block in ("contact", "impact"):
        small, large = (dict(getattr(result, block) or ()) for result in (here, there))
        for name in LARGER.keys() & small.keys():
            assert np.array_equal(large[name], LARGER[name] * np.array(small[name])), name


# ---- invariants and balance laws -----------------------------------------------------------------


def in_plane(scene):
    """Frame, launch and law of a flight."""
    frame, start = launch_frame(scene.launch.position, scene.launch.velocity, DOUBLES)
    return frame, start, law_of(scene, frame, DOUBLES)


def fastest(scene, landing):
    """m/s: a bound on the speed, of which errors of a velocity are fractions."""
    return size(scene.launch.velocity) + scene.gravity * landing.hang_time


NODES, WEIGHTS = (a.tolist() for a in np.polynomial.legendre.leggauss(40))


@given(paper_scenes("flight"), between(0.2, 1.5))
@settings(max_examples=25)
def test_balance_laws(scene, duration):
    """E and K change by the integrals of their rates, here by Gauss's rule over whole flights.

    The rates are analytic up to where V² = 0, half a second away at 5 m/s: 40 nodes on 1.5 s leave
    an error far below the engine's.
    """
    _, start, law = in_plane(scene)
    drag, lift, gravity = (law.strengths.get(name, 0.0) for name in ("drag", "lift", "gravity"))

    def after(time):
        return ENGINE.fly(law, start, (), time).state

    states = [after(duration * (1 + node) / 2) for node in NODES]
    assume(min(math.hypot(state.u, state.w) for state in states) > 5)

    def integral(rate):
        return sum(w * rate(s) for w, s in zip(WEIGHTS, states, strict=True)) * duration / 2

    end, speed = after(duration), size(scene.launch.velocity) + gravity * duration
    work = integral(lambda state: exact.energy_rate(state, drag, math))
    change = exact.energy(end, gravity) - exact.energy(start, gravity)
    assert abs(change - work) <= ERROR * (speed * speed + gravity * (20 + speed * duration))
    drift = integral(lambda state: exact.phugoid_rate(state, drag, lift, gravity, math))
    change = exact.phugoid(end, lift, gravity, math) - exact.phugoid(start, lift, gravity, math)
    assert abs(change - drift) <= 2 * ERROR * speed * (abs(lift) * speed * speed + gravity)


# ---- restart, continuity -------------------------------------------------------------------------


@given(paper_scenes("flight"), between(0.05, 0.95))
def test_a_flight_restarted_on_its_way_lands_where_it_would_have(scene, part):
    """Not past the vertical: there a new launch would put the spin on the other side."""
    landing = landed(scene)
    frame, start, law = in_plane(scene)
    on_its_way = ENGINE.fly(law, start, (), part * landing.hang_time)
    assume(on_its_way.state.u > 0.01)
    again = solve(
        launched(scene, frame.position(on_its_way.state), frame.velocity(on_its_way.state))
    ).landing
    # The heading is taken anew from a velocity that is known to so much.
    heading = 1 + fastest(scene, landing) / on_its_way.state.u
    tolerance = heading * landing_tolerance(scene, landing)
    assert math.dist(again.position, landing.position) <= tolerance
    falling = abs(landing.velocity[2])
    assert abs(on_its_way.time + again.time - landing.time) <= tolerance / falling


# ---- JSON ----------------------------------------------------------------------------------------


@given(scenes())
def test_a_scene_survives_being_written(scene):
    line = scene.line()
    assert "\n" not in line
    assert parse_scene(line) == scene
    assert parse_scene(line.encode()).line() == line


@given(results())
def test_a_result_survives_being_written(result):
    line = result.line()
    assert "\n" not in line
    assert Result.model_validate_json(line) == result
    assert Result.model_validate_json(line).line() == line


@given(scenes())
def test_whatever_the_scene_there_is_an_answer(scene):
    """Scenes no field has seen are solved or refused with a reason, and never a traceback.

    That a flight takes too many steps is a reason, too: here after fewer than usual.
    """
    short = (
        altered(scene, time_limit=min(scene.time_limit, 1.0))
        if "time_limit" in (type(scene).model_fields)
        else scene
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("longball.engines.ivp._MANY_STEPS", 100)
        patch.setattr("longball.engines.ivp._MOST_STEPS", 200)
        solved = chain.solve(short, Ivp("DOP853", 1e-6, 1e-6))
    assert (solved.outcome is None) == (solved.error is not None) == (solved.code is not None)


# ---- refusals ------------------------------------------------------------------------------------


def leaves(data, path=()):
    """Yield the paths to all values of an object that are no objects themselves."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key)


def reached(data, path):
    for key in path:
        data = data[key]
    return data


def name_of(path):
    """As messages write it: ball.mass, launch.position[2]."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)[1:]


def refusal(text):
    with pytest.raises(InvalidScene) as refused:
        parse_scene(text)
    return str(refused.value)


as_data = paper_scenes().map(lambda scene: json.loads(scene.line()))


@given(as_data, st.data())
def test_a_value_of_the_wrong_kind_is_refused_by_name(data, draw):
    path = draw.draw(st.sampled_from([p for p in leaves(data) if p != ("kind",)]))
    number = isinstance(reached(data, path), float)
    wrong = [True, [], {}] + ([math.nan, math.inf, -math.inf, "1.0"] if number else [3.5])
    # No air at all is a valid scene, as is one without an id; no number is none.
    wrong += [] if path in {("air",), ("id",)} else [None]
    reached(data, path[:-1])[path[-1]] = draw.draw(
        st.sampled_from([x for x in wrong if x != {} or path[:1] != ("air",)])  # defaults, weather
    )
    assert name_of(path) in refusal(json.dumps(data))


@given(scenes(), st.data())
def test_a_truncated_line_is_refused(scene, draw):
    line = scene.line()
    assert refusal(line[: draw.draw(st.integers(0, len(line) - 1))])


anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text() | st.integers(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(st.binary() | st.text(st.characters()) | anything.map(json.dumps))
@example(b"")
@example(b"\xff\xfe{}")
@example("[" * 100_000)
@example('{"id": "a", "kind": "pitch", "gravity": 1' + "0" * 5000 + "}")
@example('{"id": "\\ud800", "kind": "pitch"}')
@example('{"id": "\ud800", "kind": "pitch"}')
def test_rubbish_is_refused(rubbish):
    assert refusal(rubbish)
