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
from longball.model import exact
from longball.model.frame import launch_frame
from longball.model.law import law_of
from longball.model.numbers import DOUBLES
from longball.model.readings import Reading
from longball.model.result import Result
from longball.model.scene import (
    KINDS,
    AtBatScene,
    Ball,
    Bat,
    InvalidScene,
    Launch,
    Pitch,
    Rotation,
    Swing,
    parse_scene,
)
from tests.strategies import airs, at_bats, between, flights, impacts, results, scenes

ENGINE = Ivp()
ERROR = ENGINE.flight_error
ROUNDING = 2.0**-53


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


@given(flights())
def test_a_mirrored_flight_is_the_flight_mirrored(scene):
    there = landed(scene)
    back = solve(
        launched(scene, mirror(scene.launch.position), mirror(scene.launch.velocity))
    ).landing
    assert (back.time, back.distance) == (there.time, there.distance)
    assert back.position == mirror(there.position)
    assert back.velocity == mirror(there.velocity)


def mirrored_pitch(scene):
    aim_y, aim_z = scene.pitch.aim
    pitch = Pitch(speed=scene.pitch.speed, release=mirror(scene.pitch.release), aim=(-aim_y, aim_z))
    return altered(scene, pitch=pitch)


@given(at_bats())
def test_a_mirrored_pitch_meets_the_bat_at_the_mirrored_place(scene):
    """Up to the touching the bat is a cylinder with its middle over the plate, and mirrors too."""
    there, back = solve(scene), solve(mirrored_pitch(scene))
    assume(there.plate is not None)
    assert back.plate.time == there.plate.time
    assert back.plate.position == mirror(there.plate.position)
    assert back.plate.velocity == mirror(there.plate.velocity)
    for name in ("time", "normal", "margin"):
        assert getattr(back.contact, name) == getattr(there.contact, name)
    if there.contact.position:
        assert back.contact.position == mirror(there.contact.position)


@given(at_bats(reading=Reading(bat_ball_restitution="plain")))
def test_an_at_bat_mirrors_where_the_distance_from_the_pivot_does_not_matter(scene):
    """The pivot stays at +y: the blow mirrors only if neither V_b nor ẽ nor μ depends on y."""
    still = Swing(angular_speed=0.0, height_offset=scene.swing.height_offset)
    scene = altered(scene, swing=still)
    there, back = solve(scene), solve(mirrored_pitch(scene))
    assert back.outcome == there.outcome
    assert (back.impact is None) == (there.impact is None)
    if there.impact:
        assert back.impact.impulse == there.impact.impulse
        assert back.impact.velocity == mirror(there.impact.velocity)
    if there.landing:
        assert back.landing.position == mirror(there.landing.position)


def test_an_at_bat_does_not_mirror_otherwise():
    """So that the test above cannot pass for want of a difference."""
    scene = AtBatScene(id="inside", pitch=Pitch(aim=(0.3, 1.8)))
    assert solve(scene).landing.distance != solve(mirrored_pitch(scene)).landing.distance


@given(flights(), st.integers(1, 3))
def test_a_flight_turned_by_right_angles_is_the_same_bit_for_bit(scene, quarters):
    position, velocity = scene.launch.position, scene.launch.velocity
    landing = landed(scene)
    wanted = landing.position, landing.velocity
    for _ in range(quarters):
        position, velocity, *wanted = ((-v[1], v[0], v[2]) for v in (position, velocity, *wanted))
    turned = solve(launched(scene, position, velocity)).landing
    assert [turned.position, turned.velocity] == wanted
    assert (turned.time, turned.distance) == (landing.time, landing.distance)


@given(flights(), between(-3, 3))
def test_a_turned_flight_is_the_flight_turned(scene, angle):
    cos, sin = math.cos(angle), math.sin(angle)

    def turn(vector):
        x, y, z = vector
        return cos * x - sin * y, sin * x + cos * y, z

    landing = landed(scene)
    turned = solve(
        launched(scene, turn(scene.launch.position), turn(scene.launch.velocity))
    ).landing
    assert_near(turned.position, turn(landing.position), landing_tolerance(scene, landing))
    assert abs(turned.distance - landing.distance) <= landing_tolerance(scene, landing)


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


@given(at_bats(), between(0.3, 3))
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


def test_the_effective_mass_as_printed_does_not_scale():
    """I/r̃ is no mass: it is the one reading that depends on the unit of length."""
    for printed in (False, True):
        reading = Reading(effective_mass="as_printed") if printed else Reading()
        scene = AtBatScene(id="scaled", reading=reading)
        small, large = solve(scene), solve(scaled(scene, 4.0))
        same = math.isclose(small.impact.restitution, large.impact.restitution, rel_tol=ERROR)
        assert same is not printed


# ---- impact --------------------------------------------------------------------------------------


@given(impacts())
def test_momentum_is_conserved_and_energy_accounted_for(scene):
    solved = chain.solve(scene, ENGINE)
    assume(solved.outcome == "struck")
    m, mass, contact = scene.ball.mass, scene.bat.mass, solved.contact
    before, bat = np.array(scene.incoming.velocity), np.array(contact.bat_velocity)
    after, normal = np.array(solved.impact.velocity), np.array(contact.normal)
    push = solved.impact.impulse * normal
    bat_after = bat - push / mass  # Newton's third law
    # A few roundings of each term: momenta, and the energies of both bodies.
    momenta = m * (size(before) + size(after)) + mass * (size(bat) + size(bat_after))
    assert_near(m * after + mass * bat_after, m * before + mass * bat, 8 * ROUNDING * momenta)
    tangential = (after - before) - np.dot(after - before, normal) * normal
    assert size(tangential) <= 8 * ROUNDING * momenta / m
    approach, separation = np.dot(before - bat, normal), np.dot(after - bat_after, normal)
    assert abs(separation + solved.impact.restitution * approach) <= 32 * ROUNDING * momenta / m
    energy_before = (m * np.dot(before, before) + mass * np.dot(bat, bat)) / 2
    energy_after = (m * np.dot(after, after) + mass * np.dot(bat_after, bat_after)) / 2
    energies = energy_before + energy_after
    change = energy_after - energy_before
    assert abs(solved.impact.energy_change - change) <= 32 * ROUNDING * energies


@given(impacts(), between(-20, 20), between(-5, 5))
def test_the_impact_is_the_same_to_whoever_moves_along(scene, boost, along):
    """Galilean invariance: with a common velocity added to ball and bat, nothing else changes.

    A scene can give the bat a velocity along V_b alone, by a faster swing; along the bat's axis
    none is needed, since there a cylinder is the same everywhere and its impulse has no part.
    """
    here = chain.solve(scene, ENGINE)
    # Where the two hardly approach, the roundings of what is added may make them separate.
    assume(here.outcome == "struck" and here.contact.normal_speed < -1e-9)
    arm = scene.bat.length / 2 - scene.incoming.position[1]
    common = (boost * math.cos(scene.swing.tilt), along, boost * math.sin(scene.swing.tilt))
    incoming = scene.incoming.model_copy(
        update={
            "velocity": tuple(v + c for v, c in zip(scene.incoming.velocity, common, strict=True))
        }
    )
    faster = Rotation(angular_speed=scene.swing.angular_speed + boost / arm, tilt=scene.swing.tilt)
    there = solve(altered(scene, incoming=incoming, swing=faster))
    # A few roundings of velocities as large as these; the impulse multiplies them by up to 1 + ẽ.
    speed = size(scene.incoming.velocity) + size(here.contact.bat_velocity) + abs(boost) + 5
    strength = 1 + here.impact.restitution
    tolerance = 32 * ROUNDING * speed * strength
    assert abs(there.contact.normal_speed - here.contact.normal_speed) <= tolerance
    assert there.impact.restitution == here.impact.restitution
    assert abs(there.impact.impulse - here.impact.impulse) <= tolerance * scene.ball.mass
    wanted = [v + c for v, c in zip(here.impact.velocity, common, strict=True)]
    assert_near(there.impact.velocity, wanted, tolerance)


# ---- invariants and balance laws -----------------------------------------------------------------


def in_plane(scene):
    """Frame, launch and law of a flight."""
    frame, start = launch_frame(scene.launch.position, scene.launch.velocity, DOUBLES)
    return frame, start, law_of(scene, frame, DOUBLES)


def landing_state(scene, landing):
    """The landing in the flight's plane, as far as the invariants ask for it."""
    frame, start, _ = in_plane(scene)
    u = frame.cos * landing.velocity[0] + frame.sin * landing.velocity[1]
    return start._replace(z=landing.position[2], u=u, w=landing.velocity[2])


def fastest(scene, landing):
    """m/s: a bound on the speed, of which errors of a velocity are fractions."""
    return size(scene.launch.velocity) + scene.gravity * landing.hang_time


@given(flights(air=airs(lift=False)))
def test_the_invariant_of_flights_without_lift(scene):
    assume(scene.air.drag_coefficient > 0)
    landing = landed(scene)
    _, start, law = in_plane(scene)
    drag, gravity = law.strengths["drag"], law.strengths["gravity"]
    end = landing_state(scene, landing)
    before, after = (
        exact.drag_only_invariant(state, drag, gravity, math) for state in (start, end)
    )
    # The gradient in (u, w) of either, times the error of a velocity.
    tolerance = 0.0
    for state in (start, end):
        slope = state.w / state.u
        by_w = drag / gravity * 2 * math.hypot(1, slope) / state.u
        by_u = 2 / state.u**3 + by_w * abs(slope)
        tolerance += (by_u + by_w) * ERROR * fastest(scene, landing)
    assert abs(after - before) <= tolerance


@given(flights(air=airs(drag=False), elevation=between(-0.5, 1.57)))
def test_energy_and_phugoid_of_flights_without_drag(scene):
    landing = landed(scene)
    _, start, law = in_plane(scene)
    end = landing_state(scene, landing)
    gravity, lift = law.strengths["gravity"], law.strengths.get("lift", 0.0)
    speed = fastest(scene, landing)
    change = exact.energy(end, gravity) - exact.energy(start, gravity)
    assert abs(change) <= ERROR * (speed * speed + gravity * speed * landing.hang_time)
    change = exact.phugoid(end, lift, gravity, math) - exact.phugoid(start, lift, gravity, math)
    assert abs(change) <= ERROR * speed * (abs(lift) * speed * speed + gravity)


NODES, WEIGHTS = (a.tolist() for a in np.polynomial.legendre.leggauss(40))


@given(flights(elevation=between(-0.5, 1.1)), between(0.2, 1.5))
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


@given(flights(), between(0.05, 0.95))
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


@given(between(10, 45), between(0.5, 5), airs(), st.sampled_from([1e-3, 1e-6, 1e-9]))
def test_the_distance_is_continuous_across_the_vertical_launch(speed, height, air, off):
    """With the spin axis fixed at launch, and launched above the plate.

    On the one side the lift carries the ball to -x, on the other to +x, equally far from the plate.
    """
    straight = parse_scene(
        json.dumps(
            {
                "id": "up",
                "kind": "flight",
                "air": air.model_dump(),
                "launch": {"position": [0, 0, height], "velocity": [0, 0, speed]},
            }
        )
    )
    up = landed(straight)
    left, right = (
        solve(launched(straight, velocity=(sign * off * speed, 0.0, speed))).landing
        for sign in (-1, 1)
    )
    assert left.distance == right.distance
    # To first order in the angle, a ball that leaves sideways at `off` times its speed and keeps
    # that speed, for as long as it flies, to and fro.
    near = 2 * off * fastest(straight, up) * up.hang_time
    assert abs(right.distance - up.distance) <= near + landing_tolerance(straight, up)


def test_the_distance_is_not_continuous_elsewhere():
    """The ball lands on the other side of where it left: only over the plate is that as far."""
    scene = parse_scene(
        '{"id": "up", "kind": "flight", '
        '"launch": {"position": [20, 0, 1], "velocity": [1e-9, 0, 30]}}'
    )
    left = launched(scene, velocity=(-1e-9, 0.0, 30.0))
    assert abs(solve(scene).landing.distance - solve(left).landing.distance) > 1


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


@given(flights() | at_bats() | impacts())
def test_so_does_what_the_engine_answers(scene):
    line = chain.solve(scene, ENGINE).line()
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


as_data = scenes().map(lambda scene: json.loads(scene.line()))


@given(as_data, st.data())
def test_a_value_of_the_wrong_kind_is_refused_by_name(data, draw):
    path = draw.draw(st.sampled_from([p for p in leaves(data) if p != ("kind",)]))
    number = isinstance(reached(data, path), float)
    wrong = [True, [], {}] + ([math.nan, math.inf, -math.inf, "1.0"] if number else [3.5])
    # No air at all is a valid scene, as is one without an id; no number is none.
    wrong += [] if path in {("air",), ("id",)} else [None]
    reached(data, path[:-1])[path[-1]] = draw.draw(
        st.sampled_from([value for value in wrong if path != ("air",) or value != {}])
    )
    assert name_of(path) in refusal(json.dumps(data))


POSITIVE = [
    ("ball", "mass"),
    ("ball", "radius"),
    ("bat", "mass"),
    ("bat", "length"),
    ("bat", "radius"),
    ("pitch", "speed"),
    ("time_limit",),
]
NOT_NEGATIVE = [
    ("ball", "restitution"),
    ("air", "density"),
    ("air", "drag_coefficient"),
    ("gravity",),
]


@given(as_data, between(1e-9, 1e9), st.data())
def test_a_negative_value_is_refused_by_name(data, amount, draw):
    present = set(leaves(data))
    path = draw.draw(st.sampled_from([p for p in POSITIVE + NOT_NEGATIVE if p in present]))
    reached(data, path[:-1])[path[-1]] = -amount
    assert name_of(path) in refusal(json.dumps(data))


@given(as_data, st.data())
def test_zero_is_refused_by_name_where_nothing_would_be_left(data, draw):
    path = draw.draw(st.sampled_from([p for p in POSITIVE if p in set(leaves(data))]))
    reached(data, path[:-1])[path[-1]] = 0.0
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


@given(as_data, st.sampled_from(["launch", "pitch", "bat", "swing", "incoming", "ground", "air"]))
def test_a_block_of_another_kind_of_scene_is_an_unknown_key(data, block):
    assume(block not in data)
    data[block] = {}
    assert f"{block}: unknown key" in refusal(json.dumps(data))


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


@given(as_data, st.text().filter(lambda kind: kind not in KINDS))
def test_an_unknown_kind_is_refused_with_those_there_are(data, kind):
    message = refusal(json.dumps(data | {"kind": kind}))
    assert message.startswith("kind: ")
    assert all(known in message for known in KINDS)


@given(as_data, between(1e-6, 1e3))
def test_a_start_underground_is_refused_by_name(data, depth):
    assume(data["kind"] != "impact")
    block, key = ("launch", "position") if data["kind"] == "flight" else ("pitch", "release")
    data[block][key][2] = data.get("ground", {"height": 0.0})["height"] - depth
    if data["kind"] == "flight":  # one that rises comes up first
        data["launch"]["velocity"][2] = -abs(data["launch"]["velocity"][2])
    message = refusal(json.dumps(data))
    assert f"{block}.{key}[2]" in message
    assert "underground" in message


@given(as_data, between(0.1, 10))
def test_a_ball_inside_the_bat_or_away_from_it_is_refused(data, factor):
    assume(data["kind"] == "impact")
    reach = data["ball"]["radius"] + data["bat"]["radius"]
    assume(abs(factor - 1) * reach > 1e-6)
    incoming = data["incoming"]
    incoming["position"] = [factor * reach, 0.0, incoming["bat_height"]]
    message = refusal(json.dumps(data))
    assert "incoming.position" in message
    assert ("inside the bat" if factor < 1 else "away from the bat") in message


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
