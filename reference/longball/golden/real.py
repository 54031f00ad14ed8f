"""Families of real baseball: spin, laws of drag and lift, wind, weather, the Earth's rotation.

Each is a lattice over the numbers of its own term, with the other forces as the published laws have
them; the last two hold all terms together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import wraps
from itertools import product
from typing import Any

from longball.golden.case_builder import Draft, between, draft, five_digits, flight, shares, towards
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

# Of flights in a wind, those in a logarithmic one, which come last.
PROFILES = 4

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


Blocks = Callable[[int, float, float, float], dict[str, Any]]


def _lattice(comment: str, spinning: bool = True) -> Callable[[Blocks], Callable[[], Any]]:
    """Make a family of batted balls, with spins about all axes, of what chooses air and reading.

    That is a function of the number of the case and three others in [0, 1).
    """

    def made(blocks: Blocks) -> Callable[[], Iterator[Draft]]:
        @wraps(blocks)
        def family() -> Iterator[Draft]:
            for i in range(COUNT):
                a, b, c, d, e, f, g, h, j, k = shares(i)
                launch = Launch(
                    position=(0.6, 0.0, between(0.4, 1.4, d)),
                    velocity=towards(between(20.0, 52.0, a), between(2.0, 65.0, b), 360.0 * c),
                    spin=_direction(e, f, between(40.0, 330.0, g)) if spinning else None,
                )
                name = f"{blocks.__name__.replace('_', '-')}-{i:04d}"
                yield draft(FlightScene(id=name, launch=launch, **blocks(i, h, j, k)), comment)

        return family

    return made


@_lattice("lift of a spin about any axis")
def flight_spin_lift(i: int, a: float, b: float, c: float) -> dict[str, Any]:
    """Lift along ω × v, by every law of C_L and both readings of the spin parameter."""
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
    return {
        "air": Air(drag_coefficient=between(0.25, 0.5, b), lift_coefficient=laws[i % 3]),
        "reading": Reading(spin_parameter=("transverse", "total")[i // 3 % 2]),
    }


@_lattice("drag by speed and spin")
def flight_spin_drag(i: int, a: float, b: float, c: float) -> dict[str, Any]:
    """Drag that depends on speed and spin, in both readings of the spin."""
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
    return {
        "air": Air(drag_coefficient=laws[i % 2], lift_coefficient=NATHAN_LIFT),
        "reading": Reading(drag_spin=("transverse", "total")[i // 2 % 2]),
    }


def flight_wind() -> Iterator[Draft]:
    """Wind from ahead, behind, below and aside, logarithmic; on drag and lift, or on drag alone."""
    for i in range(COUNT + PROFILES):
        a, b, c, d, e, *_ = shares(i)
        speed, rise, blows = between(20.0, 52.0, a), between(2.0, 65.0, b), between(-9.0, 9.0, c)
        wind: Point | WindProfile
        if i < COUNT:
            vx, vy, vz = towards(speed, rise)
            velocity = (vx if i % 2 else -vx, vy, vz)
            aside = between(-6.0, 6.0, d) if i % 8 == 7 else 0.0
            wind = (blows, aside, between(-2.0, 2.0, e) if i % 3 == 0 else 0.0)
            number, comment = i // 2, "in a wind"
        else:
            velocity = towards(speed, rise, 40.0 * e - 20.0)
            wind = WindProfile(
                velocity=(blows, between(-6.0, 6.0, e), 0.0),
                height=between(2.0, 15.0, d),
                roughness=between(0.01, 0.1, a),
            )
            number, comment = i, "in a logarithmic wind"
        scene = FlightScene(
            id=f"flight-wind-{i:04d}",
            launch=Launch(position=(0.6, 0.0, between(0.4, 1.4, d)), velocity=velocity),
            air=Air(wind=wind),
            reading=Reading(wind_acts_on=("both", "drag")[number % 2]),
        )
        yield draft(scene, comment)


@_lattice("density from the weather", spinning=False)
def flight_weather(i: int, a: float, b: float, c: float) -> dict[str, Any]:
    """Air whose density follows from the weather, or falls with the height; the paper's lift."""
    weather = Weather(
        temperature=between(265.0, 312.0, a),
        pressure=between(97000.0, 104000.0, b),
        humidity=between(0.0, 1.0, c),
        elevation=between(0.0, 1700.0, (a + b) % 1.0),
    )
    return {
        "air": Air(density=weather, density_scale_height=8000.0 if i % 2 else None),
        "reading": Reading(pressure=("sea_level", "station")[i // 2 % 2]),
    }


@_lattice("spin decays on the way")
def flight_spin_decay(i: int, a: float, b: float, c: float) -> dict[str, Any]:
    """Spin that decays along the path through the air, or as two other readings have it."""
    air = Air(
        drag_coefficient=NATHAN_DRAG,
        lift_coefficient=NATHAN_LIFT,
        spin_decay_length=between(100.0, 3000.0, a),
        wind=(between(-5.0, 5.0, b), 0.0, 0.0) if i % 4 == 0 else None,
    )
    return {"air": air, "reading": Reading(spin_decay=("path", "time", "path", "nathan")[i % 4])}


@_lattice("all terms of the flight together")
def flight_real(i: int, a: float, b: float, c: float) -> dict[str, Any]:
    """All terms together: spin that decays, weather, wind, the Earth's rotation."""
    air = Air(
        density=Weather(temperature=between(275.0, 308.0, a), humidity=b),
        density_scale_height=8217.0,
        drag_coefficient=NATHAN_DRAG if i % 2 else CrisisDrag(law="crisis", per_spin=7.4e-5),
        lift_coefficient=NATHAN_LIFT,
        wind=(between(-6.0, 6.0, b), between(-6.0, 6.0, c), 0.0),
        spin_decay_length=1341.0,
    )
    earth = Earth(latitude=between(-0.7, 0.9, a), azimuth=between(0.0, 6.28, b))
    return {"air": air, "earth": earth}


def hard_real() -> Iterator[Draft]:
    """Scenes of the extended model that sit where implementations break."""
    for cases in (_gyro, _parallel, _still_air, _nodes, _winds_above, _profiles, _spins_gone):
        yield from cases()


PUBLISHED = Air(drag_coefficient=NATHAN_DRAG, lift_coefficient=NATHAN_LIFT)


def _gyro() -> Iterator[Draft]:
    """Yield spins along the velocity of the launch, from which gravity turns the path away."""
    for (size, word), angle in product(((250.0, "forward"), (-250.0, "backward")), (10, 30, 60)):
        x, _, z = towards(size, angle)
        name = f"hard-real-gyro-{word}-{angle}"
        scene = flight(name, towards(40.0, angle), spin=(x, 1.0, z), air=PUBLISHED)
        yield draft(scene, "spin all but along the launch", "gyro")


def _parallel() -> Iterator[Draft]:
    """Yield spins that stay parallel to a vertical flight: no lift, whatever their size."""
    comment = "straight up or down, with the spin along the path"
    for (word, aside), speed in product((("up", 0.0), ("nearly", 1e-6)), (30.0, -5.0)):
        name, spin = f"hard-real-parallel-{word}-{speed:g}", (aside, 0.0, 200.0)
        scene = flight(name, (0.0, 0.0, speed), height=40.0, spin=spin, air=PUBLISHED)
        yield draft(scene, comment, "gyro", "rest")


def _still_air() -> Iterator[Draft]:
    """Yield winds as fast as the ball, which one from behind leaves all but at rest in the air."""
    for (word, side), speed in product((("head", -1.0), ("tail", 1.0)), (5.0, 12.0, 20.0)):
        air = Air(wind=(side * speed, 0.0, 0.0), lift_coefficient=0.0)
        name = f"hard-real-{word}-wind-{speed:g}"
        scene = flight(name, (speed, 0.0, 0.5), height=30.0, air=air)
        yield draft(scene, "a wind as fast as the ball", "rest")


def _nodes() -> Iterator[Draft]:
    """Yield flights all but in a vacuum, where the least speed is known: V = u, on a node."""
    for power, (sign, word) in product((3, 6, 9, 12), ((1.0, "under"), (-1.0, "over"))):
        at = (20.0 + sign * 10.0**-power, 60.0)
        table = Table(law="table", of="speed", at=at, values=(0.3, 0.3))
        air = Air(density=1e-6, drag_coefficient=table, lift_coefficient=0.0)
        scene = flight(f"hard-real-node-{word}-1e-{power:02d}", (20.0, 0.0, 15.0), air=air)
        yield draft(scene, f"its least speed is some 1e-{power} m/s {word} a table's node", "kink")


def _winds_above() -> Iterator[Draft]:
    for above in (12.5, 12.4799, 12.479, 12.4):
        wind = WindAbove(velocity=(8.0, 3.0, 0.0), above=above)
        air = Air(wind=wind, drag_coefficient=0.35, lift_coefficient=0.0)
        scene = flight(f"hard-real-wind-above-{above:g}", (25.0, 0.0, 17.0), air=air)
        yield draft(scene, "its apex is near the height above which the wind blows", "kink")


def _profiles() -> Iterator[Draft]:
    for height in (10.0, 0.1):
        wind = WindProfile(velocity=(-9.0, 2.0, 0.0), height=height, roughness=0.03)
        air = Air(wind=wind, drag_coefficient=NATHAN_DRAG, lift_coefficient=NATHAN_LIFT)
        name, spin = f"hard-real-profile-{height:g}", (10.0, -220.0, 60.0)
        scene = flight(name, (35.0, 5.0, 20.0), height=0.05, spin=spin, air=air)
        yield draft(scene, "a logarithmic wind from the ground up", "profile")


def _spins_gone() -> Iterator[Draft]:
    velocity = (35.0, 0.0, 25.0)
    fast = PUBLISHED.model_copy(update={"spin_decay_length": 0.5})
    scene = flight("hard-real-fast-decay", velocity, spin=(0.0, -300.0, 0.0), air=fast)
    yield draft(scene, "spin that is gone after some metres", "decay")
    for power in (6, 12, 18):
        tiny = (0.0, -(10.0**-power), 0.0)
        scene = flight(f"hard-real-slow-spin-1e-{power:02d}", velocity, spin=tiny, air=PUBLISHED)
        yield draft(scene, "hardly any spin", "gyro")


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
            yield draft(PitchScene(id=f"at-bat-real-{i:04d}", pitch=pitch, air=air), "a pitch")
            continue
        scene = AtBatScene(
            id=f"at-bat-real-{i:04d}",
            pitch=pitch,
            air=air,
            bat=Bat(friction=between(0.05, 0.6, b)),
            swing=Swing(height_offset=between(-0.05, 0.05, c), tilt=between(0.0, 0.2, d)),
        )
        yield draft(scene, "an at-bat with spin, friction, weather and wind")
