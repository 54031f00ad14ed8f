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
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import (
    Ball,
    Bat,
    Ground,
    InvalidScene,
    Launch,
    Pitch,
    Swing,
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


def launched(scene, position=None, velocity=None):
    launch = scene.launch
    return altered(
        scene,
        launch=Launch(
            position=launch.position if position is None else position,
            velocity=launch.velocity if velocity is None else velocity,
        ),
    )


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


def assert_near(found, wanted, tolerance):
    assert max(abs(a - b) for a, b in zip(found, wanted, strict=True)) <= tolerance


# ---- symmetries ----------------------------------------------------------------------------------


def mirror(vector):
    x, y, *rest = vector
    return (x, -y, *rest)


@given(paper_scenes("flight"))
def test_a_mirrored_flight_is_the_flight_mirrored(scene):
    there = landed(scene)
    back = solve(
        launched(scene, mirror(scene.launch.position), mirror(scene.launch.velocity))
    ).landing
    assert (back.time, back.distance) == (there.time, there.distance)
    assert back.position == mirror(there.position)
    assert back.velocity == mirror(there.velocity)


@given(paper_scenes("flight"), st.integers(1, 3))
def test_a_flight_turned_by_right_angles_is_the_same_bit_for_bit(scene, quarters):
    position, velocity = scene.launch.position, scene.launch.velocity
    landing = landed(scene)
    wanted = landing.position, landing.velocity
    for _ in range(quarters):
        position, velocity, *wanted = ((-v[1], v[0], v[2]) for v in (position, velocity, *wanted))
    turned = solve(launched(scene, position, velocity)).landing
    assert [turned.position, turned.velocity] == wanted
    assert (turned.time, turned.distance) == (landing.time, landing.distance)


# ---- scaling -------------------------------------------------------------------------------------

# Power of λ in each quantity of a result: times go with √λ, masses with λ³, so that the densities
# stay, and k = ρ C π R²/(2 m) becomes k/λ.
POWERS = {
    "time": 0.5,
    "hang_time": 0.5,
    "position": 1.0,
    "distance": 1.0,
    "margin": 1.0,
    "velocity": 0.5,
    "bat_velocity": 0.5,
    "normal_speed": 0.5,
    "normal": 0.0,
    "restitution": 0.0,
    "impulse": 3.5,
    "energy_change": 4.0,
}


def scaled(scene, length):
    """The at-bat with all lengths times `length`, gravity as it is."""
    root = math.sqrt(length)
    ball, bat, pitch, swing = scene.ball, scene.bat, scene.pitch, scene.swing
    return altered(
        scene,
        ball=Ball(
            mass=ball.mass * length**3, radius=ball.radius * length, restitution=ball.restitution
        ),
        bat=Bat(mass=bat.mass * length**3, length=bat.length * length, radius=bat.radius * length),
        pitch=Pitch(
            speed=pitch.speed * root,
            release=tuple(x * length for x in pitch.release),
            aim=tuple(x * length for x in pitch.aim),
        ),
        swing=Swing(
            angular_speed=swing.angular_speed / root,
            tilt=swing.tilt,
            height_offset=swing.height_offset * length,
        ),
        time_limit=scene.time_limit * root,
        ground=Ground(height=scene.ground.height * length),
    )


def blow_tolerance(solved):
    """Relative: how far the ball's velocity after the blow may be off.

    The margin's error, `reach` times flight_error, moves the touching along the surface by the
    factor one over the cosine of the angle of incidence, and turns the normal by as much over
    `reach`. The impulse, up to (1 + ẽ) times the ball's velocity relative to the bat, turns with
    it, and so do V_b and ẽ change, by less.
    """
    contact, impact = solved.contact, solved.impact
    across = abs(contact.normal_speed)
    relative = [v - b for v, b in zip(solved.plate.velocity, contact.bat_velocity, strict=True)]
    incidence = abs(np.dot(solved.plate.velocity, contact.normal)) / size(solved.plate.velocity)
    change = 2 * (1 + impact.restitution) * (size(relative) + across) / incidence
    return ERROR * (1 + change / size(impact.velocity))


@given(paper_scenes("at-bat"), between(0.3, 3))
def test_a_scaled_at_bat_is_the_at_bat_scaled(scene, length):
    here = solve(scene)
    assume(here.outcome == "batted")
    there = solve(scaled(scene, length))
    assert there.outcome == here.outcome
    relative = 2 * blow_tolerance(here)
    drop = size(here.landing.velocity) / abs(here.landing.velocity[2])
    stretch = {"landing": 1 + drop}
    for block in ("plate", "contact", "impact", "landing"):
        for name, power in POWERS.items():
            value = getattr(getattr(here, block), name, None)
            if value is None:
                continue
            small = np.atleast_1d(value)
            large = np.atleast_1d(getattr(getattr(there, block), name)) / length**power
            if name in ("position", "distance", "margin"):  # of what they are differences of
                scale = size(scene.pitch.release) + size(here.landing.position)
            elif name == "energy_change":  # of what goes to and fro
                scale = abs(here.impact.impulse * here.contact.normal_speed)
            else:
                scale = max(size(small), 1e-300)
            tolerance = relative * stretch.get(block, 1.0) * 2 * scale
            assert_near(small, large, tolerance)


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
    assert_near(again.position, landing.position, tolerance)
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


def inner_objects(data, path=()):
    """Yield the paths to the object itself and all objects in it."""
    yield path
    for key, value in data.items():
        if isinstance(value, dict):
            yield from inner_objects(value, (*path, key))


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


@given(as_data, st.text(min_size=1, max_size=10), st.data())
def test_an_unknown_key_is_refused_by_name(data, key, draw):
    path = draw.draw(st.sampled_from(list(inner_objects(data))))
    block = reached(data, path)
    assume(key not in block)
    block[key] = 1.0
    if path == ("reading",) and key in Reading.model_fields:
        return
    message = refusal(json.dumps(data))
    assert f"{name_of((*path, key))}: unknown key" in message


@given(as_data, st.data())
def test_a_missing_key_is_refused_by_name(data, draw):
    required = [("kind",)]
    for block in ("launch", "incoming"):
        if block in data:
            required += [(block,), *((block, key) for key in data[block])]
    path = draw.draw(st.sampled_from(required))
    del reached(data, path[:-1])[path[-1]]
    message = refusal(json.dumps(data))
    assert message.startswith(f"{name_of(path)}: ")
    assert "missing" in message


@given(as_data, st.data())
def test_a_key_given_twice_is_refused_by_name(data, draw):
    path = draw.draw(st.sampled_from([p for p in inner_objects(data) if reached(data, p)]))
    block = reached(data, path)
    key = draw.draw(st.sampled_from(sorted(block)))
    block["twice"] = block[key]
    text = json.dumps(data).replace('"twice"', f'"{key}"')
    assert f"{key}: the key is given twice" in refusal(text)


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
