"""Lines of scenes, and the scenes that they make.

That every wrong line is refused by name is asked of generated ones in tests/test_properties.py;
here stand encodings, and the wording of a few refusals.
"""

import json

import pytest

from longball.model.scene import (
    Ball,
    Ground,
    InvalidScene,
    landing_height,
    may_be_mixed,
    parse_scene,
)

LAUNCH = {"position": [1, 2, 3], "velocity": [4, 5, 6]}
INCOMING = {"position": [0.0696, 0, 1], "velocity": [-40, 0, 0], "bat_height": 1}
LEAST = {
    "flight": {"id": "f", "kind": "flight", "launch": LAUNCH},
    "pitch": {"id": "p", "kind": "pitch"},
    "impact": {"id": "i", "kind": "impact", "incoming": INCOMING},
    "at-bat": {"id": "a", "kind": "at-bat"},
}


def parsed(kind="pitch", **values):
    return parse_scene(json.dumps(LEAST[kind] | values))


def refused(text):
    with pytest.raises(InvalidScene) as error:
        parse_scene(text)
    return error.value


# ---- the contract --------------------------------------------------------------------------------


def test_a_number_is_the_double_nearest_to_what_is_written():
    assert parsed(gravity=9).gravity == 9.0
    long = '{"id": "p", "kind": "pitch", "gravity": 0.1000000000000000055511151231257827}'
    assert parse_scene(long).gravity == 0.1


@pytest.mark.parametrize(
    ("contact", "height"), [("centre", 0.25), ("surface", 0.25 + Ball().radius)]
)
def test_the_floor_is_where_the_balls_centre_lands(contact, height):
    scene = parsed("at-bat", reading={"ground_contact": contact}, ground={"height": 0.25})
    assert landing_height(scene) == height


def test_a_pitch_has_the_ground_of_the_paper():
    assert parsed().ground == Ground()
    assert "ground: unknown key" in str(refused(json.dumps(LEAST["pitch"] | {"ground": {}})))


def test_a_scene_cannot_be_changed():
    with pytest.raises(ValueError, match="frozen"):
        parsed().gravity = 1.0


# ---- encodings -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "text"),
    [("7", "7"), ("101.0", "101"), ("-3", "-3"), ("9" * 40, "9" * 40), (f"{2**53}.0", f"{2**53}")],
)
def test_an_id_that_is_a_whole_number_is_its_text(number, text):
    assert parse_scene(f'{{"id": {number}, "kind": "pitch"}}').id == text
    assert refused(f'{{"id": {number}, "kind": "pitch", "gravity": -1}}').scene_id == text


@pytest.mark.parametrize("number", ["7.5", "true", "1e400", f"{10**40}", f"{2**53 + 2}.0"])
def test_an_id_is_no_other_number(number):
    error = refused(f'{{"id": {number}, "kind": "pitch"}}')
    assert str(error).startswith("id: must be a text or a whole number")
    assert error.scene_id is None


def test_a_byte_order_mark_is_no_part_of_the_line():
    line = json.dumps(LEAST["pitch"]).encode("utf-8-sig")
    assert parse_scene(line) == parsed()


# ---- refusals ------------------------------------------------------------------------------------


# Keys of a pitch, and the sentence that refuses them.
REFUSED = """
{"gravity": -1} -> gravity: must not be negative (got -1)
{"gravity": "9.8"} -> gravity: must be a number in m/s² (got '9.8')
{"pitch": 5} -> pitch: must be an object with the keys speed, release, aim, velocity, spin (got 5)
{"air": {"drag_coefficient": "x"}}
    -> air.drag_coefficient: must be a number, or an object with a law: constant, spin, crisis,
       table (got 'x')
{"air": {"density": "x"}} -> air.density: must be a number in kg/m³ (got 'x')
{"pitch": {"speed": -3}} -> pitch.speed: must be positive (got -3)
{"pitch": {"aim": {"y": 1}}} -> pitch.aim: must be [y, z] in m (got {'y': 1})
{"pitch": {"aim": [0, null]}} -> pitch.aim[1]: is missing, or null
{"pitch": {"aim": [0, 1, 2]}} -> pitch.aim: must be [y, z] in m, and has 3 values
{"air": {"density": {"temperature": 20}}}
    -> air.density.temperature: must be at least 150 K; 20 °C is 293.15 K (got 20)
{"earth": {"latitude": 45}}
    -> earth.latitude: must be at most 1.5708 rad; 45° is 0.7854 rad (got 45)
{"air": {"densty": 1}}
    -> air.densty: unknown key, did you mean density? The keys here are density, drag_coefficient,
       lift_coefficient, side_coefficient, wind, spin_decay_length, density_scale_height
{"pitch": {"release": [1, 2]}}
    -> pitch.release[2]: is missing; pitch.release must be [x, y, z] in m
{"wind": [1, 0, 0]}
    -> wind: unknown key; the keys here are id, ball, reading, air, gravity, time_limit, earth,
       kind, pitch; wind is a key of air
{"air": {"wind": 10}} -> air.wind: must be [x, y, z] in m/s (got 10)
{"air": {"lift_coefficient": {"law": "table", "of": "speed", "at": 1, "values": []}}}
    -> air.lift_coefficient.at: must be a list (got 1)
{"air": {"drag_coefficient": {"law": "crises"}}}
    -> air.drag_coefficient.law: 'crises' is not a law here, did you mean crisis? The laws are
       constant, spin, crisis, table
{"pitch.speed": 30} -> pitch.speed: unknown key; put it inside pitch, not beside it
{"pitch": {"release": [1, 0, -1]}}
    -> pitch.release[2] = -1.0 is underground: the ball lands at height 0.0
{"reading": {"cell_width": 0.2}} -> reading.cell_width: unknown key; the keys here are …
{"reading": {"inertia": "rod"}}
    -> reading.inertia: must be 'solid_cylinder', 'thin_rod' or 'about_centre' (got 'rod'), did
       you mean thin_rod?
"""


def test_a_refusal_names_the_key_and_says_what_it_takes():
    for row in REFUSED.strip().replace("\n    ", " ").splitlines():
        values, said = " ".join(row.split()).split(" -> ")
        error = refused(json.dumps(LEAST["pitch"] | json.loads(values)))
        if said.endswith("…"):
            assert str(error).startswith(said[:-1])
        else:
            assert str(error) == said
        assert error.scene_id == "p"


@pytest.mark.parametrize(
    ("first", "value", "falls"), [(0.0, 0.0, True), (0.0, 0.1, False), (0.1, 0.0, False)]
)
def test_a_spin_along_the_velocity_needs_a_lift_that_falls_with_the_spin_parameter(
    first, value, falls
):
    table = {"law": "table", "of": "spin_parameter", "at": [first, 0.3], "values": [value, 0.25]}
    pitch = {"velocity": [-30.0, 0.0, 0.0], "spin": [-50.0, 0.0, 0.0]}
    line = json.dumps(LEAST["pitch"] | {"pitch": pitch, "air": {"lift_coefficient": table}})
    if falls:
        assert parse_scene(line).air.lift_coefficient.values == (value, 0.25)
    else:
        assert "has no direction where pitch.spin is parallel" in str(refused(line))


def test_all_faults_of_a_line_are_told():
    message = str(refused(json.dumps(LEAST["pitch"] | {"gravity": -1, "foo": 2})))
    assert "gravity: must not be negative" in message
    assert "foo: unknown key" in message


def test_a_start_on_the_ground_is_above_it():
    assert parsed("flight", launch=LAUNCH | {"position": [0, 0, 0]})
    surface = LEAST["flight"] | {"reading": {"ground_contact": "surface"}}
    under = surface | {"launch": {"position": [0, 0, 0.03], "velocity": [30, 0, -1]}}
    told = str(refused(json.dumps(under)))
    assert "launch.position[2] = 0.03 is underground: the ball lands at height 0.0366" in told
    assert "launch.velocity[2] must be positive for it to rise there" in told


def test_a_ball_may_rise_to_the_ground_that_it_lands_on_but_not_inside_a_fence():
    deck = LEAST["flight"] | {
        "ground": {"height": 8},
        "launch": {"position": [0, 0, 1], "velocity": [30, 0, 25]},
    }
    assert parse_scene(json.dumps(deck)).ground.height == 8.0
    told = str(refused(json.dumps(deck | {"fence": {"radius": 100}})))
    assert "with a fence, the launch must not be below the ground" in told


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "not JSON"),
        ("{", "not JSON"),
        ("{'kind': 'pitch'}", "not JSON: at character 2 a key in double quotes is needed"),
        ("kind: pitch", "not JSON: at character 1 a value is needed"),
        ("{} {}", "from character 4 on; write one scene per line"),
        ("[1, 2]", "a JSON object is needed, not [1, 2]"),
        (b"\xff", "not UTF-8 text: byte 1 is 0xff"),
        ('{"id": "a", "kind": "pitch", "id": "b"}', "id: the key is given twice"),
        ('{"pitch": {"speed": 9, "aim": [], "aim": 1}}', "aim: the key is given twice"),
        ('{"id": "a"}', "kind: is missing"),
        ('{"kind": "flight"}', "launch: is missing"),
        ('{"kind": "impact", "incoming": {}}', "incoming.bat_height: is missing"),
        ('{"id": "a", "kind": "Pitch"}', "kind: 'Pitch' is not a kind of scene"),
        ('{"id": "a", "kind": ["pitch"]}', "is not a kind of scene"),
        ("[" * 100_000, "nested too deeply"),
        ('{"id": "\ud800", "kind": "pitch"}', "half of a surrogate pair"),
    ],
)
def test_what_is_no_scene_at_all(text, message):
    assert message in str(refused(text))


def test_a_refusal_carries_the_id_if_the_line_has_one_that_can_be_written():
    assert refused('{"id": "a", "kind": "x"}').scene_id == "a"
    assert refused('{"id": 1.5, "kind": "pitch"}').scene_id is None
    assert refused('{"id": "\\ud800", "kind": "pitch"}').scene_id is None


# ---- where a lift of one size has no direction ---------------------------------------------------

AIMED = {"release": [18, 0, 1.8], "aim": [0, 1.8], "speed": 36, "spin": [0, -200, 0]}
THROWN = {"velocity": [-40, 0, 3], "spin": [-80, 0, 6]}
RISING = {"velocity": [-40, 0, 0.5], "spin": [0, 0, 9]}
ALONG_Y = [-36, 5, 0]  # the air that an aimed pitch leaves behind moves along the spin


# Pitches, winds and readings.
ALONG = [
    # As fast as the ball, and sideways: the ball moves along its spin through the air.
    (AIMED, ALONG_Y, {}),
    (AIMED, {"velocity": ALONG_Y, "above": 1.5}, {}),
    (AIMED, {"velocity": ALONG_Y, "height": 1.8}, {}),
    (THROWN, None, {}),
    (THROWN, [0, 9, 0], {"wind_acts_on": "drag"}),
    # From exactly that height, up into the wind.
    (RISING, {"velocity": [-40, 0, 0], "above": 1.8}, {}),
]
ACROSS = [
    # Along the spin, if the way to the point aimed at were the velocity.
    (AIMED, [-18, 5, 0], {}),
    (AIMED, {"velocity": ALONG_Y, "above": 1.8}, {}),  # not at this height, nor below
    (AIMED, {"velocity": ALONG_Y, "above": 2}, {}),
    (AIMED, {"velocity": ALONG_Y, "height": 10}, {}),
    (AIMED, ALONG_Y, {"wind_acts_on": "drag"}),
    (THROWN, [0, 9, 0], {}),
    (THROWN, None, {"spin_parameter": "total"}),
    # Into the calm.
    (RISING | {"velocity": [-40, 0, -3]}, {"velocity": [-40, 0, 0], "above": 1.8}, {}),
]


def spun(pitch, wind, reading):
    air = {"lift_coefficient": 0.2, "wind": wind}
    return json.dumps({"kind": "pitch", "pitch": pitch, "air": air, "reading": reading})


def test_a_spin_along_the_way_through_the_air_is_refused():
    for case in ALONG:
        said = str(refused(spun(*case)))
        assert "pitch.spin is parallel to the velocity through the air" in said, case


def test_a_spin_across_the_way_through_the_air_is_taken():
    for case in ACROSS:
        assert parse_scene(spun(*case)).pitch.spin == tuple(case[0]["spin"])


def test_scenes_between_valid_ones():
    """A spin of constant lift, a side force and a polyline may be invalid between valid ones."""
    spinning = {"launch": LAUNCH | {"spin": [0, 0, 1]}}
    line = {"fence": {"polyline": [[70, 70, 2], [120, 0, 2], [70, -70, 2]]}}
    aside = {"air": {"side_coefficient": {"value": 0.1, "direction": [0, 0, 1]}}}
    law = {"air": {"lift_coefficient": {"law": "linear"}}}
    mixed = {"flight": [{}, {"fence": {"radius": 100}}, spinning | law, {"air": None} | spinning],
             "pitch": [{}], "at-bat": [{}], "impact": []}  # fmt: skip
    alone = {"flight": [spinning, line, aside, spinning | line, spinning | law | line],
             "pitch": [aside], "at-bat": [line], "impact": [{}]}  # fmt: skip
    for kind in LEAST:
        assert all(may_be_mixed(parsed(kind, **values)) for values in mixed[kind]), kind
        assert not any(may_be_mixed(parsed(kind, **values)) for values in alone[kind]), kind
