"""The family of fences: home runs, walls, corners, and balls that are blown back."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from itertools import product
from typing import Any

from longball.golden.case_builder import Draft, between, number, shares, towards, with_nearest
from longball.model.block import Point
from longball.model.readings import Reading
from longball.model.scene import Air, AtBatScene, Fence, FlightScene, Ground, Launch, Swing

# The least distances that the rules want of a field of 2010: 325 feet to the poles, 400 to centre.
RULE_BOOK = Fence(
    polyline=((70.05, 70.05, 2.4), (106.7, 44.2, 2.4), (121.92, 0.0, 2.4), (106.7, -44.2, 2.4),
              (70.05, -70.05, 2.4))
)  # fmt: skip
# A tall wall on the left that steps down, and a bay in centre.
STEPPED = Fence(
    polyline=((67.0, 67.0, 11.3), (98.0, 40.0, 11.3), (98.0, 40.0, 5.2), (118.0, 12.0, 5.2),
              (126.0, 4.0, 1.5), (121.0, -8.0, 1.5), (110.0, -45.0, 1.5), (65.0, -65.0, 0.9))
)  # fmt: skip
POLES = Fence(polyline=((20.0, 80.0, 2.4), *(RULE_BOOK.polyline or ()), (20.0, -80.0, 2.4)))
FLY, FAR = (40.0, 0.0, 26.0), (46.0, 3.0, 27.0)


def fence() -> Iterator[Draft]:
    """Flights and at-bats in fields with a fence."""
    for cases in (
        _parks, _special, _corners, _clearances, _circles, _blown_back, _at_bats, _across_the_line
    ):  # fmt: skip
        yield from cases()


def _flight(name: str, velocity: Point, field: Fence, **others: Any) -> FlightScene:
    launch = Launch(position=(0.4, 0.0, 1.0), velocity=velocity)
    return FlightScene(id=f"fence-{name}", launch=launch, fence=field, **others)


def _parks() -> Iterator[Draft]:
    for i, (name, park) in product(
        range(5), (("rule-book", RULE_BOOK), ("stepped", STEPPED), ("poles", POLES))
    ):
        a, b, c, *_ = shares(3 * i + len(name))
        velocity = towards(between(36.0, 52.0, a), between(18.0, 40.0, b), between(-50.0, 50.0, c))
        yield Draft(_flight(f"{name}-{i:04d}", velocity, park), f"a fly in a park: {name}")


def _special() -> Iterator[Draft]:
    low = Ground(height=-2.0)
    surface = Reading(fence_clearance="surface", distance_origin="launch")
    park = RULE_BOOK
    for comment, scene in (
        ("over the fence beyond the pole: foul", _flight("foul", (29.0, 41.0, 26.0), POLES)),
        ("lands foul, short of the fence", _flight("foul-ground", (15.0, 26.0, 16.0), park)),
        ("against the wall", _flight("wall", (45.0, 3.0, 18.0), park)),
        ("beyond the fence, in the air still", _flight("airborne", FAR, park, time_limit=5.0)),
        ("short of the fence, in the air still", _flight("before", FLY, park, time_limit=3.0)),
        ("its surface clears the fence", _flight("surface", FAR, park, reading=surface)),
        (
            "the field is lower than the plate",
            _flight("low", (38.0, 6.0, 26.0), STEPPED, ground=low),
        ),
        ("a parabola over a fence", _flight("vacuum", (26.0, 4.0, 24.0), park, air=None)),
        ("straight up: it never gets there", _flight("up", (0.0, 0.0, 30.0), park)),
        ("away from the field", _flight("backwards", (-30.0, 3.0, 20.0), park)),
    ):
        yield Draft(scene, comment)


def _corners() -> Iterator[Draft]:
    """Yield flights past a corner where the height steps, and past the end, by 1e-3 … 1e-15 m."""
    step = Fence(polyline=((110.0, 60.0, 1.0), (110.0, 0.0, 1.0), (110.0, 0.0, 40.0),
                           (110.0, -60.0, 40.0)))  # fmt: skip
    end = Fence(polyline=((110.0, 60.0, 1.0), (110.0, 0.0, 1.0)))
    one_height = Fence(polyline=((110.0, 60.0, 1.0), (110.0, 0.0, 1.0), (110.0, -60.0, 9.0)))
    for (name, park), power, sign in product(
        (("step", step), ("end", end)), (3, 9, 12, 15), (1, -1)
    ):
        aside = sign * 10.0**-power * 40.0 / 109.6
        case = f"{name}-{'left' if sign > 0 else 'right'}-1e-{power:02d}"
        comment = f"past a corner ({name}) by 1e-{power:02d} m"
        yield Draft(_flight(case, (40.0, aside, 26.0), park), comment, ("vertex",))
    yield Draft(_flight("corner", FLY, one_height), "over a corner of one height", ("vertex",))
    for name, park in (("step", step), ("end", end)):
        scene = _flight(f"{name}-at", FLY, park)
        yield Draft(scene, f"over the corner itself ({name}): not to be told", ("vertex", "tie"))


def _clearances() -> Iterator[Draft]:
    """Yield flights that clear the fence, or not, by 1e-3 … 1e-15 m."""
    straight = Fence(polyline=((100.0, 90.0, 10.0), (100.0, -90.0, 10.0)))
    heights = [f"fence.polyline[{i}][2]" for i in (0, 1)]
    for power, (sign, word) in product((3, 9, 12, 15), (("", "clears"), ("-", "hits"))):
        size = f"1e-{power:02d}"
        scene = _flight(f"{word}-{size}", (40.0, 3.0, 26.0), straight)
        clearance, guesses = number("fence.clearance"), (10.0, 11.0)
        scene = with_nearest(scene, clearance, sign + size, guesses, *heights)
        yield Draft(scene, f"{word} the fence by {size} m", ("tangential",))


def _circles() -> Iterator[Draft]:
    """Yield the paper's rule, D = 150 m ± 1e-9 m, as a circle."""
    circle = Fence(radius=150.0)
    for miss, word in (("-1e-9", "short"), ("1e-9", "over")):
        target, distance = str(150 + Decimal(miss)), number("landing.distance")
        scene = _flight(f"circle-{word}", (60.0, 2.0, 30.0), circle)
        scene = with_nearest(scene, distance, target, (60.0, 61.0), "launch.velocity[0]")
        yield Draft(scene, f"D = 150 m and {miss} m", ("threshold",))
    for i in range(4):
        speed = between(50.0, 64.0, shares(i)[0])
        scene = _flight(f"circle-{i:04d}", (speed, 2.0, 30.0), circle)
        yield Draft(scene, "over or into a circle of 150 m")


def _blown_back() -> Iterator[Draft]:
    """Yield high flies that a wind from centre, or across, takes over the fence and back."""
    straight = Fence(polyline=((40.0, 60.0, 2.4), (40.0, -60.0, 2.4)))
    for (name, aside), out in product((("plane", 0.0), ("space", 4.0)), (34.0, 36.0)):
        air = Air(lift_coefficient=0.0, wind=(-20.0, aside, 0.0))
        scene = _flight(f"blown-back-{name}-{out:.0f}", (out, 0.0, 45.0), straight, air=air)
        yield Draft(scene, f"a head wind of 20 m/s blows it back ({name})", ("blown-back",))


def _at_bats() -> Iterator[Draft]:
    low = Fence(polyline=((40.0, 40.0, 3.0), (60.0, 0.0, 3.0), (40.0, -40.0, 3.0)))
    high = Fence(polyline=((30.0, 30.0, 25.0), (45.0, 1.0, 25.0), (30.0, -30.0, 25.0)))
    cases = ("circle", -0.03, Fence(radius=60.0)), ("park", -0.025, low), ("wall", -0.015, high)
    for name, offset, park in cases:
        scene = AtBatScene(id=f"fence-at-bat-{name}", swing=Swing(height_offset=offset), fence=park)
        yield Draft(scene, "an at-bat in a small park")


def _across_the_line() -> Iterator[Draft]:
    """Yield balls that a wind takes across the foul line behind the fence, out and in."""
    for (name, angle, wind), side in product(
        (("out", 41.0, 8.0), ("in", 49.25, -5.0)), (1.0, -1.0)
    ):
        air = Air(wind=(0.0, side * wind, 0.0))
        velocity = towards(52.0, 32.0, side * angle)
        word = f"line-{name}-{'left' if side > 0 else 'right'}"
        comment = f"over the fence {'fair, down foul' if name == 'out' else 'foul, down fair'}"
        yield Draft(_flight(word, velocity, POLES, air=air), comment)
