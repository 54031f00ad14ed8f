"""A table of pitches, read: units, points of view, what is missing, what is wrong."""

import io

import numpy as np
import pandas as pd
import pytest

from longball.pitches import EXAMPLE, Columns, PitchTypes, TableError, read_pitches
from longball.pitches.chart import cell
from longball.pitches.table import LENGTH_UNITS
from tests.calls import check_wrong_calls

STATCAST = "pitch_type,release_speed,plate_x,plate_z,sz_top,sz_bot\n"


def statcast(*lines, header=STATCAST):
    return io.StringIO(header + "\n".join(lines) + "\n")


GOOD = ("FF,90.0,0.0,2.5,3.5,1.5", "SL,80.0,1.0,2.5,3.5,1.5")


def test_statcast_units():
    pitches = read_pitches(statcast(*GOOD))
    assert pitches.speed.tolist() == [90 * 0.44704, 80 * 0.44704]
    assert pitches.straight.tolist() == [True, False]
    assert pitches.types == ("FF", "SL")
    assert pitches.height.tolist() == [3.0, 3.0]  # halfway up the batter's own zone
    assert pitches.rows_read == 2
    assert pitches.left_out == ()


@pytest.mark.parametrize(
    ("unit", "metres"), [("ft", 0.3048), ("in", 0.0254), ("cm", 0.01), ("m", 1)]
)
def test_to_the_right_of_the_catcher_is_to_the_left_of_the_pitcher(unit, metres):
    one_cell = 0.144 / metres
    zone = f"{0.6 / metres},{0.9 / metres},{0.3 / metres}"
    table = statcast(f"FF,90,{one_cell},{zone}", f"SL,90,{-2 * one_cell},{zone}")
    pitches = read_pitches(table, Columns(place_unit=unit))
    assert pitches.across == pytest.approx([2.0, 5.0], rel=1e-15)
    # The scene's frame: P_y = (cell - 3) · width, and +y is to the catcher's left.
    assert (pitches.across - 3) * 0.144 == pytest.approx([-0.144, 0.288], rel=1e-14)


@pytest.mark.parametrize(
    ("view", "across"), [("pitcher", [1, 2, 3, 4, 5]), ("catcher", [5, 4, 3, 2, 1])]
)
def test_a_table_that_gives_cells(view, across):
    kinds = ("straight", "curve", "curve", "curve", "curve")
    table = pd.DataFrame({"kind": kinds, "kmh": 140, "y": [1, 2, 3, 4, 5], "z": [5, 4, 3, 2, 1]})
    columns = Columns(
        pitch_type="kind", speed="kmh", speed_unit="km/h", across="y", height="z",
        place_unit="cell", view=view,
    )  # fmt: skip
    pitches = read_pitches(table, columns, PitchTypes(straight=("straight",), breaking=None))
    assert pitches.across.tolist() == across
    assert cell(pitches.across).tolist() == across
    assert pitches.height.tolist() == [5, 4, 3, 2, 1]
    assert pitches.speed == pytest.approx(140 / 3.6)


def test_cells_meet_halfway_and_the_outer_ones_are_open():
    places = np.array([-40, 1.499, 1.5, 2.499, 2.5, 3, 3.5, 4.499, 4.5, 99])
    assert cell(places).tolist() == [1, 1, 2, 2, 3, 3, 4, 4, 5, 5]


def test_the_strike_zone_is_the_batters_own():
    low_and_high = ("FF,90,0,1.5,3.5,1.5", "SL,90,0,4.0,4.0,1.0")
    assert read_pitches(statcast(*low_and_high)).height.tolist() == [1.5, 4.5]


def test_rows_that_lack_something_are_named_under_the_first_thing():
    table = statcast(
        "FF,90,0,2,3,1",
        "NA,90,NA,2,3,1",  # 2: lacks its type, and its place
        "SL,,0,2,3,1",  # 3
        "PO,90,0,2,3,1",  # 4: a pitchout
        "SL,90,0,2,3,",  # 5
        "SL,90, ,2,3,1",  # 6: a blank is nothing
        "SL,90,0,2,3,1",
    )
    pitches = read_pitches(table)
    assert {each.reason: each.first_rows for each in pitches.left_out} == {
        "pitch_type is missing": (2,),
        "pitch_type is PO": (4,),
        "release_speed is missing": (3,),
        "plate_x is missing": (6,),
        "sz_bot is missing": (5,),
    }
    assert len(pitches.types) == 2
    assert pitches.rows_read == 7


def read(*lines, header=STATCAST, **columns):
    return read_pitches(statcast(*lines, header=header), Columns(**columns))


def cells(index):
    return read(f"FF,90,{index},2,3,1", f"SL,90,{index},2,3,1", place_unit="cell")


WRONG = r"""
read("FF,90", header="pitch_type,speed\n")
    -> ^release_speed, plate_x, plate_z, sz_top, sz_bot: the table has no such columns; its columns
read(*GOOD, "NA,90,0,2,3,1", "XY,90,0,2,3,1")
    -> ^pitch_type: row 4 below the header has 'XY', which is named neither as straight, nor as
read("SL,90,0,2,3,1", "CU,80,0,2,3,1")
    -> ^pitch_type: no straight ball among the types of pitch here: CU, SL$
read("FF,90,0,2,3,1") -> ^pitch_type: no breaking ball among the types of pitch here: FF$
read("FF,,0,2,3,1", ",90,0,2,3,1")
    -> ^no row .* \(1 rows: pitch_type is missing; 1 rows: release_speed is missing\)$
read() -> ^table: the table has a header, and nothing below it$
cells(0) -> plate_x is none of the cells 1 to 5
cells(6) -> plate_x is none of the cells 1 to 5
cells(2.5) -> plate_x is none of the cells 1 to 5
PitchTypes(straight=("FF", "SI")) -> SI: a type of pitch can be in one class only
"""


def test_what_cannot_be_read_says_why():
    check_wrong_calls(WRONG, globals())


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("FF,fast,0,2,3,1", "release_speed is not a finite number"),
        ("FF,90,inf,2,3,1", "plate_x is not a finite number"),
        ("FF,-90,0,2,3,1", "release_speed is not positive"),
        ("FF,150,0,2,3,1", "release_speed is faster in mph than any pitch: the right unit?"),
        ("FF,90,0,2,1,3", "sz_top is not above sz_bot"),
    ],
)
def test_a_row_that_cannot_be_used_is_left_out_with_the_reason(row, reason):
    pitches = read_pitches(statcast("FF,,0,2,3,1", *GOOD, row, row))
    assert len(pitches.types) == len(GOOD)
    missing, odd = sorted(pitches.left_out, key=lambda each: each.first_rows)
    assert missing.first_rows == (1,)
    assert (odd.reason, odd.count, odd.first_rows) == (reason, 2, (4, 5))


def test_pitchers_throw_away_from_the_batter():
    """Outside is the first-base side for a right-handed batter: the pitcher's left."""
    frame = pd.read_csv(EXAMPLE)
    for hand, side in (("R", -1), ("L", 1)):
        same_hand = frame[(frame.stand == hand) & (frame.p_throws == hand)]
        assert side * (read_pitches(same_hand).across.mean() - 3) > 0.3


@pytest.mark.parametrize(
    ("given", "meant"),
    [("m", "ft"), ("in", "ft"), ("cm", "ft"), ("ft", "m"), ("ft", "in"), ("cm", "in")],
)
def test_places_in_another_unit_are_asked_about(given, meant):
    """The day that longball ships, in every unit that is declared as another."""
    day = pd.read_csv(EXAMPLE)
    places = ["plate_x", "plate_z", "sz_top", "sz_bot"]
    day[places] *= 0.3048 / LENGTH_UNITS[given]
    read_pitches(day, Columns(place_unit=given))
    question = rf".* in {meant} it would lie between .*; is it in {given}\?"
    with pytest.raises(TableError, match="plate_x:" + question):
        read_pitches(day, Columns(place_unit=meant))
    # As TrackMan has them, without a strike zone.
    plain = day.rename(columns={"plate_x": "PlateLocSide", "plate_z": "PlateLocHeight"})
    with pytest.raises(TableError, match="PlateLocSide:" + question):
        read_pitches(plain, Columns(across="PlateLocSide", height=None, place_unit=meant))
    day["release_speed"] *= 0.44704
    with pytest.raises(TableError, match=r"release_speed: .* in mph it would .* is it in m/s"):
        read_pitches(day, Columns(place_unit=given))
