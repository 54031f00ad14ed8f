"""Statcast's rows as scenes: units and frames against numbers worked by hand."""

import io
import math

import numpy as np
import pandas as pd
import pytest

from longball.pitches import EXAMPLE, TableError
from longball.pitches.models import regression_spin
from longball.pitches.statcast import read_measured
from tests.calls import check_wrong_calls

PITCH = {
    "game_pk": 717798, "pitch_type": "FF", "p_throws": "R", "release_spin_rate": 2400,
    "spin_axis": 180, "release_pos_x": -2, "release_pos_y": 55, "release_pos_z": 6,
    "vx0": 6, "vy0": -130, "vz0": -4, "ax": -12, "ay": 30, "az": -15,
    "plate_x": 0.5, "plate_z": 2.5,
}  # fmt: skip
BATTED = {
    "game_pk": 717798, "stand": "R", "launch_speed": 100, "launch_angle": 30,
    "hit_distance_sc": 400, "hc_x": 125.42, "hc_y": 48.27,
}  # fmt: skip

# A few roundings of numbers of this size.
close = pytest.approx


def table(*rows):
    lines = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
    return io.StringIO("\n".join(lines) + "\n")


def pitches(**changes):
    return read_measured(table(PITCH | changes), "pitch")


def flies(**changes):
    return read_measured(table(BATTED | changes), "batted")


def unit(vector):
    return vector / np.linalg.norm(vector)


# ---- pitches -------------------------------------------------------------------------------------


def test_the_velocity_is_that_of_the_fit_at_release():
    # 5 ft before the plane of the fit: v² = 130² + 2 · 30 · 5, and the time there from its speeds.
    speed = math.sqrt(17200)
    since = (130 - speed) / 30
    expected = np.array([-speed, -(6 - 12 * since), -4 - 15 * since]) * 0.3048
    assert pitches().velocity[0] == close(expected, rel=1e-14)


def test_a_release_in_the_plane_of_the_fit_has_its_velocity():
    pitch = pitches(release_pos_y=50)
    assert pitch.velocity[0] == close([-130 * 0.3048, -6 * 0.3048, -4 * 0.3048])


@pytest.mark.parametrize(
    ("angle", "push"),  # where ω × v pushes a ball that flies to -x
    [(180, [0, 0, 1]), (0, [0, 0, -1]), (90, [0, -1, 0]), (270, [0, 1, 0])],
)
def test_the_spin_axis_pushes_where_statcast_says(angle, push):
    pitch = pitches(spin_axis=angle, vx0=0, vz0=0, ax=0, az=0)
    assert np.cross(pitch.axis[0], [-1.0, 0.0, 0.0]) == close(push, abs=1e-15)


def test_without_a_spin_its_columns_are_not_needed():
    spun = ("p_throws", "release_spin_rate", "spin_axis", "game_pk")
    rest = {name: x for name, x in PITCH.items() if name not in spun}
    pitch = read_measured(table(rest), "pitch", spin=False)
    assert pitch.velocity.tolist() == pitches().velocity.tolist()
    with pytest.raises(TableError, match="p_throws, release_spin_rate, spin_axis: the table has"):
        read_measured(table(rest), "pitch")


def test_a_release_is_an_extension_in_front_of_the_rubber():
    extended = {name: x for name, x in PITCH.items() if name != "release_pos_y"}
    pitch = read_measured(table(extended | {"release_extension": 5.5}), "pitch")
    assert pitch.release.tolist() == pitches(release_pos_y=55).release.tolist()
    with pytest.raises(TableError, match="no such column, nor release_extension"):
        read_measured(table(extended), "pitch")


def test_columns_may_have_names_of_their_own():
    renamed = {"RelSpeedY" if name == "vy0" else name: x for name, x in PITCH.items()}
    pitch = read_measured(table(renamed), "pitch", names={"vy0": "RelSpeedY"})
    assert pitch.velocity.tolist() == pitches().velocity.tolist()
    with pytest.raises(TableError, match=r"vy: no column that is read, did you mean vy0\?"):
        read_measured(table(renamed), "pitch", names={"vy": "RelSpeedY"})
    with pytest.raises(TableError, match="Tilt: the table has no such column"):
        read_measured(table(renamed), "pitch", names={"game_pk": "Tilt", "vy0": "RelSpeedY"})


def test_hands_may_be_words():
    assert pitches(p_throws="Left").hand.tolist() == pitches(p_throws="L").hand.tolist()


# ---- batted balls --------------------------------------------------------------------------------


@pytest.mark.parametrize(("stand", "sign"), [("R", 1), ("L", -1)])
def test_spin_of_a_fly_to_centre_field(stand, sign):
    # -763 + 120 · 30 rpm of backspin, and 849 rpm that turn a right-handed batter's to the right.
    fly = flies(stand=stand)
    spin = regression_spin(fly)[0] * 60 / (2 * math.pi)
    slope = math.radians(30)
    assert spin == close(
        [sign * 849 * math.sin(slope), -2837, -sign * 849 * math.cos(slope)], rel=1e-12
    )
    assert regression_spin(fly, side_spin=False)[0, 2] == 0.0


def test_a_speed_and_an_angle_are_enough():
    alone = {name: BATTED[name] for name in ("launch_speed", "launch_angle")}
    fly = read_measured(table(alone), "batted")
    assert fly.velocity.tolist() == flies().velocity.tolist()  # which goes to centre field
    assert np.isnan(fly.measured).all()
    assert [each.partition(":")[0] for each in fly.assumed] == [
        "no column stand",
        "no column hc_x",
        "no column hit_distance_sc",
    ]
    # Nobody's side: halfway between a left-handed and a right-handed batter's.
    both = sum(regression_spin(flies(stand=stand)) for stand in "RL") / 2
    assert regression_spin(fly)[0] == close(both[0], abs=1e-12)
    with pytest.raises(
        TableError, match="hc_y: the table has no such column, and it has the other"
    ):
        read_measured(table(alone | {"hc_x": 100}), "batted")


# ---- both ----------------------------------------------------------------------------------------


def test_weather_of_the_game():
    coors = flies()  # 66 °F at 5,190 ft
    assert coors.temperature.tolist() == [close(292.0388888888889)]
    assert coors.elevation.tolist() == [close(1581.912)]
    assert coors.weather_unknown == 0
    elsewhere = flies(game_pk=1)
    assert (elsewhere.temperature[0], elsewhere.elevation[0]) == (293.15, 0.0)
    assert elsewhere.weather_unknown == 1


def test_games_of_ones_own():
    games = io.StringIO("game_pk,temperature,park\n1,50,Fenway Park\n")
    fly = read_measured(table(BATTED | {"game_pk": 1}), "batted", games)
    assert (fly.temperature[0], fly.elevation[0]) == (283.15, close(21 * 0.3048))


@pytest.mark.parametrize(
    ("columns", "cells"), [("park,elevation", "Fenway Park,7349"), ("elevation", "7349")]
)
def test_an_elevation_counts_more_than_a_park(columns, cells):
    games = io.StringIO(f"game_pk,temperature,{columns}\n1,72,{cells}\n")
    fly = read_measured(table(BATTED | {"game_pk": 1}), "batted", games)
    assert fly.elevation[0] == close(7349 * 0.3048)


def test_games_have_a_park_or_an_elevation():
    with pytest.raises(TableError, match="has a column park, or elevation, in ft"):
        read_measured(table(BATTED), "batted", io.StringIO("game_pk,temperature\n1,72\n"))


def test_a_park_keeps_its_elevation_under_a_new_name():
    heights = []
    for park in ("Minute Maid Park", "Daikin Park"):
        games = io.StringIO(f"game_pk,temperature,park\n1,75,{park}\n")
        heights += [read_measured(table(BATTED | {"game_pk": 1}), "batted", games).elevation[0]]
    assert heights == [45 * 0.3048] * 2


# Why a row is left out, and what is changed in a good one.
LEFT_OUT = {
    "pitch": [
        ("pitch_type is missing", {"pitch_type": ""}),
        ("p_throws is missing", {"p_throws": ""}),
        ("spin_axis is missing", {"spin_axis": ""}),
        ("release_spin_rate is 0: not measured", {"release_spin_rate": 0}),
        ("vy0 is not below 0: away from the plate", {"vy0": 130}),
        ("release_pos_y is behind the front of the plate", {"release_pos_y": 1}),
        ("plate_z is below the ground: it bounced first", {"plate_z": -0.1}),
    ],
    "batted": [
        ("launch_speed is not a finite number", {"launch_speed": "98 mph"}),
        ("launch_angle is not a finite number", {"launch_angle": "inf"}),
        ("stand is neither R nor L", {"stand": "S"}),
        ("stand is missing", {"stand": ""}),
        ("hc_x is missing", {"hc_x": ""}),
        ("launch_angle is not between 10° and 60°", {"launch_angle": 9.9}),
        ("launch_angle is not between 10° and 60°", {"launch_angle": 60.1}),
        ("launch_speed is not above 60 mph", {"launch_speed": 60}),
        # what no fielder of the field took
        ("the direction is not between the foul lines, by over 15°", {"hc_x": 135, "hc_y": 215}),
        ("the direction is not between the foul lines, by over 15°", {"hc_x": 60, "hc_y": 205}),
        ("hc_x and hc_y are 0: not measured", {"hc_x": 0, "hc_y": 0}),
        ("hit_distance_sc is 0: not measured", {"hit_distance_sc": 0}),
    ],
}


@pytest.mark.parametrize("kind", LEFT_OUT)
def test_a_row_that_cannot_be_used_is_left_out_with_the_reason_and_no_other(kind):
    good = {"pitch": [{}], "batted": [{}, {"launch_angle": 10}, {"launch_angle": 60}]}[kind]
    reasons, changes = zip(*LEFT_OUT[kind], strict=True)
    whole = {"pitch": PITCH, "batted": BATTED}[kind]
    found = read_measured(table(*(whole | change for change in (*changes, *good))), kind)
    wanted: dict[str, tuple[int, ...]] = {}
    for row, reason in enumerate(reasons, 1):
        wanted[reason] = (*wanted.get(reason, ()), row)
    assert {each.reason: each.first_rows for each in found.left_out} == wanted
    assert found.rows.tolist() == [*range(len(changes) + 1, len(changes) + len(good) + 1)]


def test_a_table_in_other_units_is_asked_about():
    metres = {name: PITCH[name] * 0.3048 for name in ("vx0", "vy0", "vz0")}
    with pytest.raises(TableError, match=r"vy0: the median is -39\.62, and in ft/s it would"):
        pitches(**metres)
    with pytest.raises(TableError, match="launch_speed: the median is 160, and in mph it would"):
        flies(launch_speed=160)


@pytest.mark.parametrize(("unit", "factor"), [("m", 0.3048), ("in", 12.0), ("cm", 30.48)])
def test_places_at_the_plate_in_another_unit_are_asked_about(unit, factor):
    """One pitch tells by where its fit crosses the plate, and many by where pitches go."""
    crossed = {"plate_x": -0.33, "plate_z": 3.14}  # ft, by hand
    assert len(pitches(**crossed)) == 1
    scaled = {name: value * factor for name, value in crossed.items()}
    with pytest.raises(TableError, match=rf"plate_x, plate_z: .* are they in {unit}\?"):
        pitches(**scaled)
    day = pd.read_csv(EXAMPLE)
    day["plate_x"] *= factor
    with pytest.raises(TableError, match=rf"plate_x: the median of its sizes .* in {unit}\?"):
        read_measured(day, "pitch")
    day["plate_x"] /= factor
    day["release_pos_z"] *= factor
    with pytest.raises(TableError, match=rf"release_pos_z: the median .* in {unit}\?"):
        read_measured(day, "pitch")


def test_the_day_that_is_shipped():
    pitch, fly = read_measured(EXAMPLE, "pitch"), read_measured(EXAMPLE, "batted")
    assert (len(pitch), len(fly)) == (4339, 385)
    assert pitch.weather_unknown == fly.weather_unknown == 0
    # plate_x and plate_z are where the fit of constant acceleration crosses the plate's front. It
    # begins at the release; both places are written in hundredths of a foot, whose rounding is
    # 1.76 mm (RMS): 0.01 ft/√12 in each of two components of two places.
    x, y, z = pd.read_csv(EXAMPLE)[["ay", "ax", "az"]].to_numpy()[pitch.rows - 1].T * 0.3048
    r, v = pitch.release, pitch.velocity
    time = -2 * r[:, 0] / (v[:, 0] - np.sqrt(v[:, 0] ** 2 - 2 * x * r[:, 0]))
    crossing = [r[:, i] + v[:, i] * time + a * time**2 / 2 for i, a in ((1, -y), (2, z))]
    off = np.stack(crossing, axis=1) - pitch.measured
    assert 1.7e-3 < np.sqrt(np.mean(np.sum(off**2, axis=1))) < 2e-3


def played(*games):
    lines = ["game_pk,temperature,park", *games]
    return read_measured(table(BATTED), "batted", io.StringIO("\n".join(lines) + "\n"))


WRONG = r"""
read_measured(table(BATTED | {"stand": "S"}, BATTED | {"stand": ""}), "batted")
    -> ^stand: row 1 below the header has 'S', which is neither R nor L$
flies(launch_speed="fast")
    -> ^launch_speed: row 1 below the header has 'fast', which is not a number$
played("1,warm,Fenway Park") -> temperature: row 1 below the header has 'warm'
played("1,,Fenway Park") -> a game has no game_pk or no temperature
played("1,50,") -> a game has no park
played("1,50,Fenway")
    -> 'Fenway' is not known; give it in a column elevation, in ft, did you mean Fenway Park
played("1,50,Fenway Park", "1.0,60,Coors Field") -> game_pk: row 2 below the header has 1, which
played("1,10,Fenway Park") -> temperature: the median is 10, and in °F it would lie between
"""


def test_what_cannot_be_read_says_why():
    check_wrong_calls(WRONG, globals())
