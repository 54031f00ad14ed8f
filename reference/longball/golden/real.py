"""Families of real baseball: spin, laws of drag and lift, wind, weather, the Earth's rotation.

Each is a lattice over the numbers of its own term, with the other forces as the published laws have
them; the last two hold all terms together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from longball.golden.case_builder import Draft, between, five_digits, shares
from longball.model.air import (
    Air,
    ConstantLift,
    CrisisDrag,
    LinearLift,
    RationalLift,
    SpinDrag,
    Table,
    Weather,
    WindAbove,
    WindProfile,
)
from longball.model.block import Point
from longball.model.readings import Reading
from longball.model.scene import (
    AtBatScene,
    Bat,
    Earth,
    FlightScene,
    Launch,
    Pitch,
    PitchScene,
    Swing,
)

# Cases in a family.
COUNT = 40

NATHAN_DRAG, NATHAN_LIFT = SpinDrag(law="spin"), RationalLift(law="rational")


def _direction(a: float, b: float, size: float) -> Point:
    """Return a vector of a size whose direction is even on the sphere over a and b in [0, 1)."""
    z, angle = 2.0 * a - 1.0, 2.0 * math.pi * b
    across = size * math.sqrt(1.0 - z * z)
    return (
        five_digits(across * math.cos(angle)),
        five_digits(across * math.sin(angle)),
        five_digits(size * z),
    )


def _flights(
    family: str,
    comment: str,
    air: Callable[[int, float, float, float], Air],
    reading: Callable[[int], Reading] = lambda i: Reading(),
    earth: Callable[[float, float], Earth | None] = lambda a, b: None,
    spinning: bool = True,
) -> Iterator[Draft]:
    """Yield batted balls with spins about all axes; `air` chooses from three numbers in [0, 1)."""
    for i in range(COUNT):
        a, b, c, d, e, f, g, h, j, k = shares(i)
        speed, elevation = between(20.0, 52.0, a), math.radians(between(2.0, 65.0, b))
        heading = math.radians(360.0 * c)
        ahead = speed * math.cos(elevation)
        read = reading(i)
        scene = FlightScene(
            id=f"{family}-{i:04d}",
            launch=Launch(
                position=(0.6, 0.0, between(0.4, 1.4, d)),
                velocity=(
                    five_digits(ahead * math.cos(heading)),
                    five_digits(ahead * math.sin(heading)),
                    five_digits(speed * math.sin(elevation)),
                ),
                spin=_direction(e, f, between(40.0, 330.0, g)) if spinning else None,
            ),
            air=air(i, h, j, k),
            reading=read,
            earth=earth(h, j),
        )
        yield Draft(scene, comment, ("reading",) if read != Reading() else ())


def flight_spin_lift() -> Iterator[Draft]:
    """Lift along ω × v, by every law of C_L and both readings of the spin parameter."""

    def air(i: int, a: float, b: float, c: float) -> Air:
        laws = (
            RationalLift(
                law="rational",
                numerator=between(0.8, 1.3, a),
                constant=between(0.3, 0.8, b),
                slope=between(1.5, 2.6, c),
            ),
            LinearLift(law="linear", slope=between(0.3, 1.6, a)),
            ConstantLift(law="constant", value=between(0.05, 0.3, a)),
        )
        return Air(drag_coefficient=between(0.25, 0.5, b), lift_coefficient=laws[i % 3])

    def reading(i: int) -> Reading:
        return Reading(spin_parameter=("transverse", "total")[i // 3 % 2])

    return _flights("flight-spin-lift", "lift of a spin about any axis", air, reading)


def flight_spin_drag() -> Iterator[Draft]:
    """Drag that depends on speed and spin, in both readings of the spin."""

    def air(i: int, a: float, b: float, c: float) -> Air:
        per_spin = between(1e-4, 5e-4, c)
        laws = (
            SpinDrag(law="spin", constant=between(0.25, 0.4, a), per_spin=per_spin),
            CrisisDrag(
                law="crisis",
                high_speed=between(0.2, 0.35, a),
                low_speed=between(0.4, 0.55, b),
                speed=between(25.0, 40.0, c),
                width=between(2.0, 6.0, a),
                per_spin=per_spin if i % 4 == 1 else 0.0,
            ),
        )
        return Air(drag_coefficient=laws[i % 2], lift_coefficient=NATHAN_LIFT)

    def reading(i: int) -> Reading:
        return Reading(drag_spin=("transverse", "total")[i // 2 % 2])

    return _flights("flight-spin-drag", "drag by speed and spin", air, reading)


def flight_wind() -> Iterator[Draft]:
    """Wind from ahead, behind, below and aside; on drag and lift, or on drag alone."""
    for i in range(COUNT):
        a, b, c, d, e, *_ = shares(i)
        speed, elevation = between(20.0, 52.0, a), math.radians(between(2.0, 65.0, b))
        side = 1.0 if i % 2 else -1.0
        aside = between(-6.0, 6.0, d) if i % 8 == 7 else 0.0
        upwards = between(-2.0, 2.0, e) if i % 3 == 0 else 0.0
        read = Reading(wind_acts_on=("both", "drag")[i // 2 % 2])
        scene = FlightScene(
            id=f"flight-wind-{i:04d}",
            launch=Launch(
                position=(0.6, 0.0, between(0.4, 1.4, d)),
                velocity=(
                    five_digits(side * speed * math.cos(elevation)),
                    0.0,
                    five_digits(speed * math.sin(elevation)),
                ),
            ),
            air=Air(wind=(between(-9.0, 9.0, c), aside, upwards)),
            reading=read,
        )
        yield Draft(scene, "in a wind", ("reading",) if read != Reading() else ())


def flight_weather() -> Iterator[Draft]:
    """Air whose density follows from the weather, or falls with the height; the paper's lift."""

    def air(i: int, a: float, b: float, c: float) -> Air:
        weather = Weather(
            temperature=between(265.0, 312.0, a),
            pressure=between(97000.0, 104000.0, b),
            humidity=between(0.0, 1.0, c),
            elevation=between(0.0, 1700.0, (a + b) % 1.0),
        )
        return Air(density=weather, density_scale_height=8000.0 if i % 2 else None)

    def reading(i: int) -> Reading:
        return Reading(pressure=("sea_level", "station")[i // 2 % 2])

    comment = "density from the weather"
    return _flights("flight-weather", comment, air, reading, spinning=False)


def flight_spin_decay() -> Iterator[Draft]:
    """Spin that decays along the path through the air, or as two other readings have it."""

    def air(i: int, a: float, b: float, c: float) -> Air:
        return Air(
            drag_coefficient=NATHAN_DRAG,
            lift_coefficient=NATHAN_LIFT,
            spin_decay_length=between(100.0, 3000.0, a),
            wind=(between(-5.0, 5.0, b), 0.0, 0.0) if i % 4 == 0 else None,
        )

    def reading(i: int) -> Reading:
        return Reading(spin_decay=("path", "time", "path", "nathan")[i % 4])

    return _flights("flight-spin-decay", "spin decays on the way", air, reading)


def flight_real() -> Iterator[Draft]:
    """All terms together: spin that decays, weather, wind, the Earth's rotation."""

    def air(i: int, a: float, b: float, c: float) -> Air:
        return Air(
            density=Weather(temperature=between(275.0, 308.0, a), humidity=b),
            density_scale_height=8217.0,
            drag_coefficient=NATHAN_DRAG if i % 2 else CrisisDrag(law="crisis", per_spin=7.4e-5),
            lift_coefficient=NATHAN_LIFT,
            wind=(between(-6.0, 6.0, b), between(-6.0, 6.0, c), 0.0),
            spin_decay_length=1341.0,
        )

    def earth(a: float, b: float) -> Earth:
        return Earth(latitude=between(-0.7, 0.9, a), azimuth=between(0.0, 6.28, b))

    return _flights("flight-real", "all terms of the flight together", air, earth=earth)


def _spinning(name: str, velocity: Point, spin: Point, air: Air, **others: Any) -> FlightScene:
    launch = Launch(position=(0.0, 0.0, others.pop("height", 1.0)), velocity=velocity, spin=spin)
    return FlightScene(id=f"hard-real-{name}", launch=launch, air=air, **others)


def hard_real() -> Iterator[Draft]:
    """Scenes of the extended model that sit where implementations break."""
    published = Air(drag_coefficient=NATHAN_DRAG, lift_coefficient=NATHAN_LIFT)
    for size, word in ((250.0, "forward"), (-250.0, "backward")):
        # Gyrospin: along the velocity of the launch, from which gravity turns the path away.
        for angle in (10, 30, 60):
            c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            velocity = (five_digits(40.0 * c), 0.0, five_digits(40.0 * s))
            spin = (five_digits(size * c), 1.0, five_digits(size * s))
            scene = _spinning(f"gyro-{word}-{angle}", velocity, spin, published)
            yield Draft(scene, "spin all but along the launch", ("gyro",))
    for name, spin in (("up", (0.0, 0.0, 200.0)), ("nearly", (1e-6, 0.0, 200.0))):
        for speed in (30.0, -5.0):
            # The spin stays parallel to a vertical flight: no lift, whatever its size.
            scene = _spinning(
                f"parallel-{name}-{speed:g}", (0.0, 0.0, speed), spin, published, height=40.0
            )
            yield Draft(
                scene, "straight up or down, with the spin along the path", ("gyro", "rest")
            )
    for word, side in (("head", -1.0), ("tail", 1.0)):
        for speed in (5.0, 12.0, 20.0):
            air = Air(wind=(side * speed, 0.0, 0.0), lift_coefficient=0.0)
            scene = FlightScene(
                id=f"hard-real-{word}-wind-{speed:g}",
                launch=Launch(position=(0.0, 0.0, 30.0), velocity=(speed, 0.0, 0.5)),
                air=air,
            )
            # With a tail wind of its own speed a ball is all but at rest in the air.
            yield Draft(scene, "a wind as fast as the ball", ("rest",))
    for power in (3, 6, 9, 12):
        for sign, word in ((1.0, "under"), (-1.0, "over")):
            # In a vacuum of weight alone the turning point is known: V = u there, on the node.
            node = 20.0 + sign * 10.0**-power
            table = Table(law="table", of="speed", at=(node, 60.0), values=(0.3, 0.3))
            air = Air(density=1e-6, drag_coefficient=table, lift_coefficient=0.0)
            scene = FlightScene(
                id=f"hard-real-node-{word}-1e-{power:02d}",
                launch=Launch(position=(0.0, 0.0, 1.0), velocity=(20.0, 0.0, 15.0)),
                air=air,
            )
            yield Draft(
                scene, f"its least speed is some 1e-{power} m/s {word} a table's node", ("kink",)
            )
    for above in (12.5, 12.4799, 12.479, 12.4):
        wind = WindAbove(velocity=(8.0, 3.0, 0.0), above=above)
        air = Air(wind=wind, drag_coefficient=0.35, lift_coefficient=0.0)
        scene = FlightScene(
            id=f"hard-real-wind-above-{above:g}",
            launch=Launch(position=(0.0, 0.0, 1.0), velocity=(25.0, 0.0, 17.0)),
            air=air,
        )
        yield Draft(scene, "its apex is near the height above which the wind blows", ("kink",))
    for height in (10.0, 0.1):
        wind_profile = WindProfile(velocity=(-9.0, 2.0, 0.0), height=height, roughness=0.03)
        scene = _spinning(
            f"profile-{height:g}", (35.0, 5.0, 20.0), (10.0, -220.0, 60.0),
            Air(wind=wind_profile, drag_coefficient=NATHAN_DRAG, lift_coefficient=NATHAN_LIFT),
            height=0.05,
        )  # fmt: skip
        yield Draft(scene, "a logarithmic wind from the ground up", ("profile",))
    still = Air(drag_coefficient=NATHAN_DRAG, lift_coefficient=NATHAN_LIFT, spin_decay_length=0.5)
    yield Draft(
        _spinning("fast-decay", (35.0, 0.0, 25.0), (0.0, -300.0, 0.0), still),
        "spin that is gone after some metres",
        ("decay",),
    )
    for power in (6, 12, 18):
        tiny = (0.0, -(10.0**-power), 0.0)
        scene = _spinning(f"slow-spin-1e-{power:02d}", (35.0, 0.0, 25.0), tiny, published)
        yield Draft(scene, "hardly any spin", ("gyro",))


def at_bat_real() -> Iterator[Draft]:
    """Pitches and at-bats with spin, friction of the bat, weather and wind."""
    for i in range(COUNT):
        a, b, c, d, e, f, g, h, j, k = shares(i)
        velocity = (-between(34.0, 45.0, a), between(-0.6, 0.6, b), between(-2.0, 0.5, c))
        release = (16.6, between(-0.5, 0.5, d), between(1.6, 2.1, e))
        pitch = Pitch(
            velocity=velocity, release=release, spin=_direction(f, g, between(150.0, 270.0, h))
        )
        air = Air(
            density=Weather(temperature=between(280.0, 305.0, j), humidity=0.5),
            drag_coefficient=NATHAN_DRAG,
            lift_coefficient=NATHAN_LIFT,
            wind=(between(-4.0, 4.0, k), between(-4.0, 4.0, a), 0.0),
            spin_decay_length=1341.0,
        )
        if i % 4 == 0:
            yield Draft(PitchScene(id=f"at-bat-real-{i:04d}", pitch=pitch, air=air), "a pitch", ())
            continue
        scene = AtBatScene(
            id=f"at-bat-real-{i:04d}",
            pitch=pitch,
            air=air,
            bat=Bat(friction=between(0.05, 0.6, b)),
            swing=Swing(height_offset=between(-0.05, 0.05, c), tilt=between(0.0, 0.2, d)),
        )
        yield Draft(scene, "an at-bat with spin, friction, weather and wind", ())
