"""The family of fences: home runs, walls, corners, and balls that are blown back."""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from itertools import product
from typing import Any

from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.golden.case_builder import Draft, between, shares, solve_for
from longball.model.readings import Reading
from longball.model.result import Bounded
from longball.model.scene import Air, AtBatScene, Fence, FlightScene, Ground, Launch, Swing

_CHOOSING = Enclosure(digits=40)  # as in `longball.golden.hard`

Triple = tuple[float, float, float]

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
    for cases in (_parks, _special, _corners, _clearances, _circles, _blown_back, _at_bats):
        yield from cases()


def _flight(name: str, velocity: Triple, field: Fence, **others: Any) -> FlightScene:
    launch = Launch(position=(0.4, 0.0, 1.0), velocity=velocity)
    return FlightScene(id=f"fence-{name}", launch=launch, fence=field, **others)


def _parks() -> Iterator[Draft]:
    for i, (name, park) in product(
        range(5), (("rule-book", RULE_BOOK), ("stepped", STEPPED), ("poles", POLES))
    ):
        a, b, c, *_ = shares(3 * i + len(name))
        speed, up = between(36.0, 52.0, a), math.radians(between(18.0, 40.0, b))
        heading = math.radians(between(-50.0, 50.0, c))
        ahead = speed * math.cos(up)
        velocity = (
            between(0.0, ahead, math.cos(heading)),
            between(0.0, ahead, math.sin(heading)),
            between(0.0, speed, math.sin(up)),
        )
        yield Draft(_flight(f"{name}-{i:04d}", velocity, park), f"a fly in a park: {name}")


def _special() -> Iterator[Draft]:
    low = Ground(height=-2.0)
    surface = Reading(fence_clearance="surface", distance_origin="launch")
    for name, comment, scene in (
        ("foul", "over the fence beyond the pole: foul", ((29.0, 41.0, 26.0), POLES, {})),
        ("foul-ground", "lands foul, short of the fence", ((15.0, 26.0, 16.0), RULE_BOOK, {})),
        ("wall", "against the wall", ((45.0, 3.0, 18.0), RULE_BOOK, {})),
        ("airborne", "beyond the fence, in the air still", (FAR, RULE_BOOK, {"time_limit": 5.0})),
        ("before", "short of the fence, in the air still", (FLY, RULE_BOOK, {"time_limit": 3.0})),
        ("surface", "its surface clears the fence", (FAR, RULE_BOOK, {"reading": surface})),
        ("low", "the field is lower than the plate", ((38.0, 6.0, 26.0), STEPPED, {"ground": low})),
        ("vacuum", "a parabola over a fence", ((26.0, 4.0, 24.0), RULE_BOOK, {"air": None})),
        ("up", "straight up: it never gets there", ((0.0, 0.0, 30.0), RULE_BOOK, {})),
        ("backwards", "away from the field", ((-30.0, 3.0, 20.0), RULE_BOOK, {})),
    ):
        velocity, park, others = scene
        yield Draft(_flight(name, velocity, park, **others), comment)


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

    def over(height: float, case: str) -> FlightScene:
        straight = Fence(polyline=((100.0, 90.0, height), (100.0, -90.0, height)))
        return _flight(case, (40.0, 3.0, 26.0), straight)

    def clearance(height: float) -> Decimal:
        found = solve(over(height, "fence-choice"), _CHOOSING).fence
        assert found is not None
        assert isinstance(found.clearance, Bounded)
        return Decimal(found.clearance.value)

    for power, sign in product((3, 9, 12, 15), ("", "-")):
        target = f"{sign}1e-{power:02d}"
        height = solve_for(clearance, target, 10.0, 11.0)
        word = "hits" if sign else "clears"
        scene = over(height, f"{word}-1e-{power:02d}")
        yield Draft(scene, f"{word} the fence by 1e-{power:02d} m", ("tangential",))


def _circles() -> Iterator[Draft]:
    """Yield the paper's rule, D = 150 m ± 1e-9 m, as a circle."""

    def launched(speed: float, case: str, reading: Reading | None = None) -> FlightScene:
        field = Fence(radius=150.0)
        return _flight(case, (speed, 2.0, 30.0), field, reading=reading or Reading())

    def distance(speed: float) -> Decimal:
        landing = solve(launched(speed, "choice"), _CHOOSING).landing
        assert landing is not None
        assert isinstance(landing.distance, Bounded)
        return Decimal(landing.distance.value)

    for miss, word in (("-1e-9", "short"), ("1e-9", "over")):
        speed = solve_for(distance, str(150 + Decimal(miss)), 60.0, 61.0)
        yield Draft(launched(speed, f"circle-{word}"), f"D = 150 m and {miss} m", ("threshold",))
    for i in range(4):
        a, *_ = shares(i)
        speed = between(50.0, 64.0, a)
        yield Draft(launched(speed, f"circle-{i:04d}"), "over or into a circle of 150 m")


def _blown_back() -> Iterator[Draft]:
    """Yield high flies that a wind from centre, or across, takes over the fence and back."""
    straight = Fence(polyline=((40.0, 60.0, 2.4), (40.0, -60.0, 2.4)))
    for name, wind in (("plane", (-20.0, 0.0, 0.0)), ("space", (-20.0, 4.0, 0.0))):
        for out in (34.0, 36.0):
            air = Air(lift_coefficient=0.0, wind=wind)
            scene = _flight(f"blown-back-{name}-{out:.0f}", (out, 0.0, 45.0), straight, air=air)
            comment = f"a head wind of 20 m/s blows it back ({name})"
            yield Draft(scene, comment, ("blown-back",))


def _at_bats() -> Iterator[Draft]:
    for name, offset, park in (
        ("circle", -0.03, Fence(radius=60.0)),
        ("park", -0.025, Fence(polyline=((40.0, 40.0, 3.0), (60.0, 0.0, 3.0), (40.0, -40.0, 3.0)))),
        (
            "wall",
            -0.015,
            Fence(polyline=((30.0, 30.0, 25.0), (45.0, 1.0, 25.0), (30.0, -30.0, 25.0))),
        ),
    ):
        scene = AtBatScene(id=f"fence-at-bat-{name}", swing=Swing(height_offset=offset), fence=park)
        yield Draft(scene, "an at-bat in a small park")
