"""The air of a scene: published constants, the density, and what is refused at a limit."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from itertools import product
from typing import Any

import pytest

from longball.model.air import Weather
from longball.model.atmosphere import density, earth_strengths, speed_of_sound
from longball.model.frame import Frame
from longball.model.numbers import DOUBLES
from longball.model.scene import AtBatScene, InvalidScene, _meet, parse_scene
from tests.calls import check_wrong_calls
from tests.model.test_scene import INCOMING, LAUNCH, LEAST


def scene(kind: str = "flight", **blocks: Any) -> Any:
    return parse_scene(json.dumps(LEAST[kind] | blocks))


# --- published constants --------------------------------------------------------------------------


def test_standard_weather() -> None:
    """15 °C and 1013.25 hPa, dry, at sea level: 1.2256 kg/m³ by the formula's 1.2929 at 0 °C."""
    weather = Weather()
    assert (weather.temperature, weather.pressure) == (288.15, 101325.0)
    assert (weather.humidity, weather.elevation) == (0.0, 0.0)
    assert density(scene(air={"density": {}}), DOUBLES) == pytest.approx(1.2256, abs=5e-5)
    sound = speed_of_sound(scene(air={"density": {}}), DOUBLES)
    assert sound == pytest.approx(340.29, abs=0.02)  # as tabulated


@pytest.mark.parametrize(
    ("celsius", "vapour"), [(0.0, 611.2), (10.0, 1228.0), (20.0, 2338.8), (30.0, 4245.5)]
)
def test_humid_air_is_lighter_by_the_tabulated_vapour_pressure(
    celsius: float, vapour: float
) -> None:
    """Of saturated vapour over water, Pa (CRC Handbook); half of it, at 50 %."""
    weather = {"temperature": 273.15 + celsius}
    dry, humid = (
        density(scene(air={"density": weather | {"humidity": part}}), DOUBLES) for part in (0, 0.5)
    )
    assert dry == pytest.approx(1.2929 * 273.15 / (273.15 + celsius), rel=1e-14)
    assert 1 - humid / dry == pytest.approx(0.3783 * 0.5 * vapour / 101325, rel=1e-3)


def test_the_earth_turns_once_in_a_sidereal_day_about_its_axis() -> None:
    """Its axis points north at the equator and up at the pole."""
    frame = Frame(0.0, 0.0, 1.0, 0.0)
    day, cases = 2 * math.pi / 86164.1, []
    for latitude, azimuth, axis in (
        (0.0, 0.0, (1, 0, 0)),
        (0.0, math.pi / 2, (0, 1, 0)),  # +x to the east, so north is to its left
        (math.pi / 2, 0.3, (0, 0, 1)),
        (math.pi / 6, 0.0, (math.cos(math.pi / 6), 0, 0.5)),
    ):
        at = scene(earth={"latitude": latitude, "azimuth": azimuth})
        strengths = earth_strengths(at, frame, DOUBLES)
        found = [strengths.get(f"earth_{name}", 0.0) for name in "syz"]
        cases.append(found)
        assert found == pytest.approx([day * x for x in axis], rel=1e-6, abs=1e-20)
    assert len(cases) == 4


# --- limits ---------------------------------------------------------------------------------------

TABLE = {"law": "table", "of": "speed"}


def table(at: list[float], values: list[float], of: str = "speed") -> Any:
    return scene(air={"drag_coefficient": {"law": "table", "of": of, "at": at, "values": values}})


def rough(**bat: Any) -> Any:
    return scene("at-bat", bat=bat)


def air(**blocks: Any) -> Any:
    return scene(air=blocks)


def aside(direction: list[float], wind: Any = None, reading: Any = None, **pitch: Any) -> Any:
    air = {"side_coefficient": {"value": 0.1, "direction": direction}, "wind": wind}
    return scene("pitch", air=air, pitch=pitch, reading=reading or {})


WRONG = r"""
rough(friction=0.5, tangential_restitution=1.0000001) -> tangential_restitution
rough(friction=0.5, tangential_restitution=-1.0000001) -> tangential_restitution
rough(tangential_restitution=1.0) -> bat: tangential_restitution needs friction
aside([0, 0, 0]) -> side_coefficient.direction: \[0.0, 0.0, 0.0\] has no direction
aside([10, 0, -1], velocity=[-40, 0, 4])
    -> air.side_coefficient.direction = \[10.0, 0.0, -1.0\] is parallel to the velocity
aside([1, 0, 0], wind=[0, 2, 4], velocity=[-40, 2, 4])
    -> is parallel to the velocity through the air at the start
aside([0, 1, 0], reading={"lift_direction": "always_up"})
    -> cannot be combined with spin, wind, a table of the lift, or a side_coefficient
rough(friction=0) -> bat.friction
rough(support="held") -> bat.support
scene("at-bat", bat={"support": "free"}, reading={"effective_mass": "as_printed"})
    -> bat.support = free has no
table([1], [1]) -> at least 2
table([*range(101)], [0.3] * 101) -> at most 100
table([1, 2, 3], [1, 2]) -> at has 3 nodes and values has 2 numbers
table([1, 3, 3], [1, 1, 2]) -> at\[2\] = 3.0 follows 3.0
table([1, 2], [1, -0.1]) -> -0.1 is negative
table([1, 2], [1, 1], "mach") -> needs the temperature
table([1, 2], [1, 1], "spin_parameter") -> needs a spin
air(spin_decay_length=100.0) -> air.spin_decay_length needs a spin
air(lift_coefficient={"law": "rational", "constant": 0, "slope": 0}) -> cannot both be 0
air(wind={"velocity": [1, 0, 1], "height": 10}) -> velocity\[2\] must be 0
air(wind={"velocity": [1, 0, 0]})
    -> must be \[x, y, z\] in m/s; or have velocity and above; or
air(density={"pressure": 1013}) -> 10000 Pa; 1013 hPa are 101300 Pa
air(density={"humidity": 50}) -> 50.0 is not a fraction from 0 to 1; 50 % is written 0.5
"""


def test_numbers_up_to_their_limits_are_taken_and_others_refused() -> None:
    check_wrong_calls(WRONG, globals())
    for e in (-1.0, 1.0):  # from rubbing nothing to a superball
        assert rough(friction=0.5, tangential_restitution=e)
    for at, values in (([1, 2], [1, 2]), ([0, 2], [0, 2]), ([*range(100)], [0.3] * 100)):
        assert table(at, values).air.drag_coefficient.values == tuple(values)
    for half in ({"constant": 0}, {"slope": 0}):
        scene(
            air={"lift_coefficient": {"law": "rational"} | half},
            launch=LAUNCH | {"spin": [1.0, 0.0, 0.0]},
        )


def test_some_coefficients_mean_nothing_without_a_spin() -> None:
    at_speed = TABLE | {"at": [1, 2], "values": [1, 1]}
    for key, law, needs in (
        ("drag_coefficient", {"law": "spin"}, True),
        ("drag_coefficient", {"law": "crisis", "per_spin": 1e-4}, True),
        *(("lift_coefficient", {"law": law}, True) for law in ("rational", "linear", "bilinear")),
        *(("drag_coefficient", law, False) for law in ({"law": "crisis"}, at_speed)),
        *((key, law, False) for key in ("drag_coefficient", "lift_coefficient")
          for law in (0.2, {"law": "constant", "value": 0.2})),
    ):  # fmt: skip
        name = f"air.{key}" if needs else ""
        spun = scene(air={key: law}, launch=LAUNCH | {"spin": [1.0, 2.0, 0.0]})
        assert spun.air.needs_spin == name, law
        with pytest.raises(InvalidScene, match=f"{name} needs a spin") if needs else nullcontext():
            scene(air={key: law})


# --- places ---------------------------------------------------------------------------------------


BELOW = math.nextafter(3.0, 4.0)
LEVEL = {"position": [0, 0, 3], "velocity": [30, 0, 0]}
AWAY = LAUNCH | {"position": [3, 4, 1]}
REACH = math.hypot(0.0366 + 0.033, 0.5)
PROFILE = {"velocity": [1, 0, 0], "height": 10.0, "roughness": 0.5}
MISPLACED = r"""
scene(ground={"height": BELOW}, launch=LEVEL) -> launch.position\[2\] = 3.0 is underground
scene(launch=AWAY, fence={"radius": 5.0}) -> launch.position is outside, 5.0 m from the plate
scene("at-bat", fence={"radius": REACH}) -> the bat's reach is outside
scene(air={"wind": PROFILE}, ground={"height": -0.5})
    -> must be above -air\.wind\.roughness = -0\.5
scene("pitch", pitch={"release": [0, 0, 1]}) -> in front of the plate
# fences
scene(fence={"polyline": [[70, 9, 1], [70, 9, 2]]}) -> at least two vertices
scene(fence={"polyline": [[70, -9, 1], [70, 9, 2]]}) -> the wrong way round
scene(fence={}) -> either a radius or a polyline
scene(fence={"radius": 9.0, "polyline": [[70, 9, 1], [70, -9, 2]]})
    -> either a radius or a polyline
"""


def test_a_scene_has_its_place_on_the_ground_and_inside_the_fence() -> None:
    check_wrong_calls(MISPLACED, globals())
    scene(ground={"height": 3.0}, launch=LEVEL)
    scene(launch=AWAY, fence={"radius": 5.000001})
    scene("at-bat", fence={"radius": 1.000001 * REACH})
    scene(air={"wind": PROFILE}, ground={"height": -0.4999})
    assert scene("pitch", pitch={"release": [1e-30, 0, 1]}).pitch.release[0] == 1e-30


@pytest.mark.parametrize("off", [-1, 1])
def test_an_incoming_ball_touches_the_bat_to_a_nanometre(off: int) -> None:
    def at(distance: float) -> Any:
        return scene(
            "impact", incoming=INCOMING | {"position": [0.6 * distance, 0, 1 + 0.8 * distance]}
        )

    assert at(0.0696 + 0.9e-9 * off)
    with pytest.raises(
        InvalidScene, match=f"incoming.position is {'inside' if off < 0 else 'away'}"
    ):
        at(0.0696 + 1.1e-9 * off)


def test_a_line_may_be_a_mebibyte_long() -> None:
    line = json.dumps(LEAST["pitch"])
    longest = line + " " * (2**20 - len(line))
    assert parse_scene(longest) == parse_scene(longest.encode()) == parse_scene(line)
    for longer in (longest + " ", (longest + " ").encode()):
        with pytest.raises(InvalidScene, match="longer than 1,048,576 bytes"):
            parse_scene(longer)


def test_a_pitch_is_thrown_along_its_way() -> None:
    thrown = scene("pitch", pitch={"speed": 30, "release": [12, 3, 2], "aim": [-1, 5]}).pitch
    assert thrown.along == (-12.0, -4.0, 3.0)
    assert thrown.thrown == pytest.approx((-12 * 30 / 13, -4 * 30 / 13, 3 * 30 / 13), rel=1e-15)
    given = scene("pitch", pitch={"velocity": [-30, 1, 2]}).pitch
    assert given.thrown == given.along == (-30.0, 1.0, 2.0)
    with pytest.raises(InvalidScene, match="remove aim and speed"):
        scene("pitch", pitch={"velocity": [-30, 1, 2], "aim": [0, 1], "speed": 3})
    assert AtBatScene().pitch.velocity is None


# --- a fence that crosses itself ------------------------------------------------------------------


def crosses(*vertices: tuple[float, float]) -> bool:
    try:
        scene(fence={"polyline": [[x, y, 1] for x, y in vertices]})
    except InvalidScene as error:
        return "crosses itself" in str(error)  # it may also go the wrong way round
    return False


def test_chords_meet_if_they_have_a_point_in_common() -> None:
    """All pairs between points of a small grid, by Cramer's rule, or by an end on the other."""

    def within(p: Any, a: Any, b: Any) -> bool:
        ways = [(p[0] - a[0], p[1] - a[1]), (b[0] - a[0], b[1] - a[1])]
        aside = ways[0][0] * ways[1][1] - ways[0][1] * ways[1][0]
        along = ways[0][0] * ways[1][0] + ways[0][1] * ways[1][1]
        return aside == 0 and 0 <= along <= ways[1][0] ** 2 + ways[1][1] ** 2

    points = list(product((0.0, 1.0, 3.0), (0.0, 2.0, 3.0)))
    chords = [(a, b) for a, b in product(points, points) if a != b]
    for (a, b), (c, d) in product(chords, chords):
        u, v, w = ((q[0] - p[0], q[1] - p[1]) for p, q in ((a, b), (c, d), (a, c)))
        both = u[0] * v[1] - u[1] * v[0]
        first, second = w[0] * v[1] - w[1] * v[0], w[0] * u[1] - w[1] * u[0]
        if both != 0:
            wanted = 0 <= first / both <= 1 and 0 <= second / both <= 1
        else:
            wanted = any(within(*x) for x in ((a, c, d), (b, c, d), (c, a, b), (d, a, b)))
        assert _meet(a, b, c, d) is wanted


def test_a_fence_that_folds_back_on_itself() -> None:
    assert crosses((70, 9), (70, -9), (70, 3))
    assert crosses((70, 9), (70, -9), (70, 20))
    assert not crosses((70, 9), (70, -9), (70, -20))
    assert not crosses((70, 9), (70, -9), (70, -9), (60, -20))  # a step of the height


@pytest.mark.parametrize("about", [0.0, 1.4, -1.4])
def test_a_fence_that_turns_back_goes_the_way_between_its_ends(about: float) -> None:
    corners = [(60, 0.1 + about), (100, -0.5 + about), (60, 0.05 + about)]
    fence = [[far * math.cos(angle), far * math.sin(angle), 2] for far, angle in corners]
    assert scene(fence={"polyline": fence}).fence.polyline is not None
    with pytest.raises(InvalidScene, match="the wrong way round"):
        scene(fence={"polyline": fence[::-1]})


@pytest.mark.parametrize("sign", [1, -1])
def test_a_fence_is_seen_from_the_plate(sign: int) -> None:
    """Almost along a line of sight, which is another one from a metre aside or ahead of it."""
    ends = [(30, 0.5 * sign), (60, (1.0 - sign * 0.01) * sign)]
    for (x, y), (u, v) in (ends, ends[::-1]):
        fence = {"polyline": [[x, y, 1], [u, v, 2]]}
        if math.atan2(v, u) < math.atan2(y, x):
            assert scene(fence=fence).fence.polyline is not None
        else:
            with pytest.raises(InvalidScene, match="the wrong way round"):
                scene(fence=fence)
