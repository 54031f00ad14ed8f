"""Parks: fences by their published numbers, and the commands that ask for them."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import pytest

import longball as lb
from longball.pitches.statcast import FOOT
from tests.calls import check_wrong_calls

ROOT2 = math.sqrt(0.5)


def ball(speed: float, direction: float = 0.0) -> lb.Flight:
    """Return a ball in a vacuum, launched at 45° from the plate on the ground."""
    launch = lb.launch(speed, math.pi / 4, direction, position=[0, 0, 0])
    return lb.Flight(air=None, gravity=9.8, launch=launch)


def test_fences_stand_where_they_are_published():
    fence = lb.park("Rogers Centre").fence.polyline
    assert fence[0] == pytest.approx((328 * ROOT2 * FOOT, 328 * ROOT2 * FOOT, 14.33 * FOOT))
    assert fence[2] == pytest.approx((400 * FOOT, 0, 8 * FOOT))
    assert fence[-1] == pytest.approx((328 * ROOT2 * FOOT, -328 * ROOT2 * FOOT, 12.58 * FOOT))


def test_every_park_encloses_fair_ground_and_names_its_source():
    for park in lb.parks():
        line = park.fence.polyline
        assert line[0][0] == line[0][1]
        assert line[-1][0] == -line[-1][1]
        # Each direction meets the fence once, at one height or at a step.
        assert all(a >= b for a, b in pairwise(park.bearings))
        # By the rules 250 ft at least, and no fence of today is beyond 440 ft or 40 ft high.
        assert all(250 < far / FOOT < 440 for far in park.distances)
        assert all(3 <= round(top / FOOT, 9) < 40 for top in park.walls)
        assert park.source
        assert "-" in park.seasons


@pytest.mark.parametrize(
    ("name", "left", "center", "right"),
    # By other sources than the fences are from: the clubs, the league and newspapers.
    [
        ("Fenway Park", 310, 390, 302), ("Yankee Stadium", 318, 408, 314),
        ("Coors Field", 347, 415, 350), ("Daikin Park", 315, 409, 326),
        ("Petco Park", 336, 396, 322), ("PNC Park", 325, 399, 320),
        ("Dodger Stadium", 330, 395, 330), ("Wrigley Field", 355, 400, 353),
        ("Busch Stadium", 336, 400, 335), ("Tropicana Field", 315, 404, 322),
        ("Oracle Park", 339, 391, 309), ("loanDepot park", 344, 400, 335),
        ("Oakland Coliseum", 330, 400, 330),
    ],
)  # fmt: skip
def test_fences_agree_with_the_numbers_on_the_wall(name, left, center, right):
    """Measured from the air, to some feet: poles and centre field are where they are marked."""
    park = lb.park(name)
    aimed = ball(60.0).replace(fence=park.fence.model_dump())
    middle = math.hypot(*lb.solve(aimed).fence.position[:2])
    found = park.distances[0], middle, park.distances[-1]
    assert [far / FOOT for far in found] == pytest.approx([left, center, right], abs=8.0)


@pytest.mark.parametrize("engine", ["ivp", "batch"])
def test_a_parabola_clears_a_park_by_what_galileo_says(engine):
    """Over flat ground z = x - g x²/V² at 45°."""
    (found,) = lb.in_parks(ball(38.0), [lb.park("Globe Life Field")], engine)
    x = 407 * FOOT
    over = x - 9.8 * x**2 / 38.0**2 - 8 * FOOT
    assert found.is_out
    assert found.clearance == pytest.approx(over, abs=1e-11)


def test_the_same_ball_is_out_here_and_not_there():
    found = {each.park.name: each for each in lb.in_parks(ball(32.0, math.radians(44.9)))}
    assert found["Daikin Park"].is_out  # 315 ft and 21 ft high
    assert found["Fenway Park"].result.outcome == "wall"  # 306 ft and 37 ft high
    assert found["Fenway Park"].clearance < 0


def test_weather_is_at_the_parks_elevation_and_a_number_stays():
    parks = [lb.park("Coors Field"), lb.park("Yankee Stadium")]
    launch = lb.launch(46.0, 0.5)
    air = {"density": {"temperature": 295.0}, "lift_coefficient": 0.1}
    high, low = lb.in_parks(lb.Flight(launch=launch, air=air), parks)
    assert high.result.landing.distance > low.result.landing.distance + 5.0
    high, low = lb.in_parks(lb.Flight(launch=launch), parks)
    assert high.result.landing.distance == low.result.landing.distance


def test_parks_may_be_named():
    (found,) = lb.in_parks(ball(45.0), ["Fenway Park"])
    assert found == lb.in_parks(ball(45.0), [lb.park("Fenway Park")])[0]


WRONG = r"""
lb.in_parks(ball(45.0), ["fenway park"]) -> did you mean Fenway Park
lb.in_parks(lb.Pitch()) -> must be 'flight' or 'at-bat' here
lb.park("Fenway") -> 'Fenway' is not known, did you mean Fenway Park\?
# those of the city, and for Boston not Houston's
lb.park("Denver") -> Coors Field
lb.park("Boston") -> Fenway Park
lb.park("st louis") -> Busch Stadium
lb.park("Chicago") -> Rate Field or Wrigley Field
lb.park("Nowhere") -> the parks are American
"""


def test_an_unknown_park_names_the_nearest_and_those_of_the_city():
    check_wrong_calls(WRONG, globals())
    assert all(park.city for park in lb.parks())


@pytest.mark.parametrize(
    ("air", "notes"),
    [
        (None, 0),
        ({"density": {"temperature": 295.0}}, 0),
        ({"density": 1.2}, 1),
        ({}, 1),  # the paper's density
    ],
)
def test_a_density_that_ignores_elevations_is_noted(called, air, notes):
    scene = lb.Flight(launch=lb.launch(46.0, 0.5), air=air)
    both = ("--park", "Coors Field", "--park", "Yankee Stadium")
    asked = called("parks", "-", *both, stdin=f"{scene.line()}\n".encode() * 2)
    assert asked.stderr.count("the same at every park's elevation") == notes
    assert not called("parks", "-", "-q", *both, stdin=scene.line().encode()).stderr
    weather = 'air.density={"temperature": 293}'
    if air is not None:
        changed = called("parks", "-", "--set", weather, *both, stdin=scene.line().encode())
        assert not changed.stderr


def test_parks_of_a_file(called, tmp_path):
    lines = [ball(45.0).line(), "{", ball(20.0).line()]
    told = called("parks", "-", "--json", "--park", "Petco Park", stdin="\n".join(lines).encode())
    answers = [json.loads(line) for line in told.stdout.splitlines()]
    assert [answer["outcome"] for answer in answers] == ["home_run", "landed"]
    assert [answer["id"] for answer in answers] == ["1", "3"]
    assert "line 2: not JSON" in told.stderr
    assert told.returncode == 1
    row = 'flight,9.8,null,"[0, 0, 0]","[32, 0, 32]"'
    table = f"kind,gravity,air,launch.position,launch.velocity\n{row}\n".encode()
    (tmp_path / "balls.csv").write_bytes(table)
    assert called("parks", str(tmp_path / "balls.csv")).stdout.startswith("2: a home run in ")
    shown = called("parks", "-", stdin=ball(45.0).line().encode()).stdout
    assert shown.startswith(f"1: a home run in {len(lb.parks())} of {len(lb.parks())} parks")


@pytest.mark.parametrize(
    ("options", "distance"),
    # By SciPy's DOP853 with the law written out, not by longball.
    [([], 127.11188723858902), (["--elevation", "7349 ft", "--temperature", "72 F"],
                                140.01515250821657)],
    ids=["sea level", "Mexico City"],
)  # fmt: skip
def test_a_flight_in_a_line(called, options, distance):
    asked = ["flight", "--speed", "103 mph", "--angle", "28", "--bats", "R", "--json"]
    answer = json.loads(called(*asked, *options).stdout)
    assert answer["landing"]["distance"] == pytest.approx(distance, rel=1e-12)


def test_the_scene_of_a_flight_goes_to_other_commands(called, tmp_path):
    asked = ["flight", "--speed", "103 mph", "--angle", "28", "--wind", "5 mph out"]
    run = called(*asked, "--scene")
    assert run.returncode == 0
    (line,) = run.stdout.encode().splitlines()
    (alone, solved) = (
        json.loads(called(*asked, "--json").stdout),
        json.loads(called("solve", stdin=line).stdout),
    )
    assert solved["landing"] == alone["landing"]
    parks = called("parks", "-", stdin=line)
    assert (parks.returncode, parks.stderr) == (0, "")
    assert parks.stdout.startswith("1: a home run in ")
    here = called("parks", "-", "--park", "Coors Field", "--json", stdin=line).stdout
    there = called(*asked, "--park", "Coors Field", "--json").stdout
    assert json.loads(here)["clearance"] == json.loads(there)["fence"]["clearance"]


def test_units_wind_and_park_of_a_flight(called):
    asked = ["flight", "--speed", "46.04512 m/s", "--angle", "0.4886921905584123 rad"]
    same = ["flight", "--speed", "103 mph", "--angle", "28"]
    assert called(*asked).stdout == called(*same).stdout
    out, into = (called(*same, "--wind", f"10 mph {way}", "--json").stdout for way in ("out", "in"))
    assert json.loads(out)["landing"]["distance"] > json.loads(into)["landing"]["distance"] + 15
    park = json.loads(called(*same, "--park", "Globe Life Field", "--json").stdout)
    assert math.hypot(*park["fence"]["position"][:2]) == pytest.approx(407 * FOOT)
    plain = json.loads(called(*same, "--park", "Globe Life Field", "--set", "fence.radius=100",
                           "--json").stdout)  # fmt: skip
    assert math.hypot(*plain["fence"]["position"][:2]) == pytest.approx(100.0)
