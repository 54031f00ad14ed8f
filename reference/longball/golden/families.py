"""The regular families: ordinary flights, pitches, impacts and at-bats.

A family is a function that returns its drafts. Ids count within a family and are never reused:
a case that is added comes last, a case that goes leaves its number empty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import islice, product
from typing import get_args

from longball.golden import real
from longball.golden.case_builder import Draft, between, draft, shares, towards
from longball.golden.combined import combined, edges
from longball.golden.fences import fence
from longball.golden.hard import hard
from longball.golden.kinks import flight_kinks
from longball.golden.oblique import impact_oblique
from longball.home_run import draw, paper_at_bats, scenes, with_restitution
from longball.model.readings import EffectiveMass, Inertia, Reading, SamplingReading, readings_of
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Ground,
    ImpactScene,
    Incoming,
    Launch,
    Pitch,
    PitchScene,
    Rotation,
)

# --- flights --------------------------------------------------------------------------------------


def _flights(
    family: str,
    count: int,
    air: Callable[[float, float], Air | None],
    comment: str,
    flags: tuple[str, ...] = (),
) -> Iterator[Draft]:
    """Yield launches from 5 to 65 m/s in all directions that leave the ground, a lattice of them.

    `air` chooses the air from two numbers in [0, 1).
    """
    for i in range(count):
        a, b, c, d, e, f, g, h, *_ = shares(i)
        # Batted balls fly forward; launches of every heading are there to keep signs apart.
        velocity = towards(between(5.0, 65.0, a), 105 * b - 20, 360 * c)
        scene = FlightScene(
            id=f"{family}-{i:04d}",
            ball=Ball(mass=between(0.1417, 0.1488, d), radius=between(0.03645, 0.0374, e)),
            air=air(f, g),
            gravity=(9.8, 9.80665, 9.8, 1.62)[i % 4],  # the paper's, the standard one, the moon's
            launch=Launch(
                position=(0.0, between(-0.5, 0.5, h), between(0.5, 2.0, d)), velocity=velocity
            ),
            ground=Ground(height=0.0 if i % 3 else between(-5.0, 0.5, e)),
        )
        yield Draft(scene, comment, flags)


def flight_vacuum() -> Iterator[Draft]:
    """No air at all: parabolas."""
    comment = "a parabola: closed form known"
    return _flights("flight-vacuum", 40, lambda f, g: None, comment, ("closed-form",))


def _air(f: float, drag: float, lift: float) -> Air:
    return Air(density=between(0.9, 1.35, f), drag_coefficient=drag, lift_coefficient=lift)


def flight_drag() -> Iterator[Draft]:
    """Drag and weight."""
    comment = "drag without lift: 1/u² + (k_D/g)[…] is constant"
    return _flights("flight-drag", 40, lambda f, g: _air(f, between(0.15, 0.6, g), 0.0), comment)


def flight_lift() -> Iterator[Draft]:
    """Lift and weight, topspin included."""
    comment = "lift without drag: energy and phugoid constants"
    return _flights("flight-lift", 40, lambda f, g: _air(f, 0.0, between(-0.3, 0.3, g)), comment)


def flight_both() -> Iterator[Draft]:
    """Drag, lift and weight."""

    def air(f: float, g: float) -> Air:
        return _air(f, between(0.15, 0.6, g), between(-0.1, 0.35, (f + 7 * g) % 1.0))

    return _flights("flight-both", 60, air, "all forces on")


def flight_vertical() -> Iterator[Draft]:
    """Straight up or down, in air or none, without lift: tan, tanh or a parabola."""
    for i in range(20):
        a, b, c, *_ = shares(i)
        upwards = i % 2 == 0
        air = Air(drag_coefficient=between(0.2, 0.5, a), lift_coefficient=0.0)
        scene = FlightScene(
            id=f"flight-vertical-{i:04d}",
            air=air if i % 4 else None,
            launch=Launch(
                position=(between(-20.0, 20.0, b), between(-20.0, 20.0, c), between(1.0, 40.0, c)),
                velocity=(0.0, 0.0, between(1.0, 45.0, a) * (1 if upwards else -1)),
            ),
        )
        comment = "straight " + ("up, at rest at its apex, and down" if upwards else "down")
        # The speed is |w|, which has a kink where the ball turns round.
        yield draft(scene, comment, "closed-form", "vertical", *["rest"] * upwards)


def flight_weightless() -> Iterator[Draft]:
    """No gravity: the speed falls as 1/(1 + k_D V₀ t), the path is a circle of radius 1/k_L."""
    for i in range(16):
        a, b, c, d, e, *_ = shares(i)
        drag, lift = i % 2 == 0, i % 4 < 2
        scene = FlightScene(
            id=f"flight-weightless-{i:04d}",
            air=Air(
                drag_coefficient=between(0.2, 0.5, d) if drag else 0.0,
                lift_coefficient=between(-0.3, 0.1, e) if lift else 0.0,
            ),
            gravity=0.0,
            launch=Launch(
                position=(0.0, 0.0, between(1.0, 20.0, a)),
                velocity=(between(10.0, 40.0, b), between(-5.0, 5.0, c), between(-30.0, -10.0, d)),
            ),
        )
        yield Draft(scene, "no gravity: closed form in the logarithm of the time", ("closed-form",))


# --- pitches --------------------------------------------------------------------------------------


def pitch() -> Iterator[Draft]:
    """Throws of 18 to 50 m/s that cross the plate, come down before it, or are still on the way."""
    no_lift, topspin = (Air(lift_coefficient=x) for x in (0.0, -0.2))
    airs = (Air(), None, no_lift, Air(drag_coefficient=0.0), topspin)
    for i in range(50):
        a, b, c, d, e, f, *_ = shares(i)
        scene = PitchScene(
            id=f"pitch-{i:04d}",
            air=airs[i % len(airs)],
            pitch=Pitch(
                speed=between(18.0, 50.0, a),
                release=(between(16.0, 18.44, b), between(-0.8, 0.8, c), between(1.2, 2.2, d)),
                aim=(between(-0.5, 0.5, e), between(0.8, 2.6, f)),
            ),
            gravity=9.8 if i % 10 else 0.0,
            # One of a dozen is asked for too early to have arrived.
            time_limit=60.0 if i % 12 else 0.3,
        )
        yield Draft(scene, "a throw to the plane x = 0")


# --- impacts --------------------------------------------------------------------------------------


def impact_readings() -> list[Reading]:
    """Return every reading of the impact: all that the ledger lets be combined."""
    switches = ("bat_ball_restitution", "reduced_mass", "effective_mass", "inertia")
    restitutions = (
        ("as_printed", "bat_mass"),
        ("as_printed", "effective_mass"),
        ("nathan", "bat_mass"),
        ("plain", "bat_mass"),
    )
    masses, inertias = get_args(EffectiveMass), get_args(Inertia)
    return [
        Reading.model_validate(dict(zip(switches, (*restitution, mass, inertia), strict=True)))
        for restitution, mass, inertia in product(restitutions, masses, inertias)
    ]


def impact() -> Iterator[Draft]:
    """Ball and bat at the touching, all around the bat and along it, in every reading."""
    readings = impact_readings()
    for i in range(120):
        a, b, c, d, e, f, g, h, j, k = shares(i)
        reading = readings[i % len(readings)] if i >= 20 else Reading()
        ball, bat = Ball(), Bat()
        if i >= 80:  # of other masses and sizes, up to those of softball
            ball = Ball(mass=between(0.12, 0.19, d), radius=between(0.034, 0.0485, h))
            bat = Bat(
                mass=between(0.6, 1.2, j),
                length=between(0.7, 1.1, k),
                radius=between(0.028, 0.035, e),
            )
        reach, height = ball.radius + bat.radius, between(0.5, 1.5, a)
        # From behind and below through the front to behind and above, mostly in front.
        angle = math.radians(240 * b - 120)
        scene = ImpactScene(
            id=f"impact-{i:04d}",
            reading=reading,
            ball=ball.model_copy(update={"restitution": between(0.3, 0.6, c)}),
            bat=bat,
            swing=Rotation(angular_speed=between(0.0, 45.0, d), tilt=between(0.0, 0.2, e)),
            incoming=Incoming(
                position=(
                    round(reach * math.cos(angle), 12),
                    round(bat.length * between(-0.499, 0.499, f), 12),
                    round(height + reach * math.sin(angle), 12),
                ),
                velocity=(between(-45.0, -20.0, g), between(-3.0, 3.0, h), between(-12.0, 4.0, j)),
                bat_height=height,
            ),
        )
        yield draft(scene, "a touching anywhere on the bat")


# --- at-bats --------------------------------------------------------------------------------------

# Where the paper's at-bats are drawn from; any number would do.
SEED = 20261121

# Every switch of the ledger that changes an at-bat or how it is drawn: one at a time, and two.
AT_BAT_READINGS: dict[str, dict[str, str | float]] = {
    "speed-table-as-printed": {"speed_table": "as_printed"},
    "speed-spread-as-printed": {"speed_spread": "as_printed"},
    "effective-mass-as-printed": {"effective_mass": "as_printed"},
    "restitution-nathan": {"bat_ball_restitution": "nathan"},
    "restitution-plain": {"bat_ball_restitution": "plain"},
    "reduced-mass-effective": {"reduced_mass": "effective_mass"},
    "inertia-thin-rod": {"inertia": "thin_rod"},
    "inertia-about-centre": {"inertia": "about_centre"},
    "offset-spread-diameter": {"offset_spread": 0.0732},
    "cell-width-0.2": {"cell_width": 0.2},
    "lift-always-up": {"lift_direction": "always_up"},
    "ground-surface": {"ground_contact": "surface"},
    "up-and-surface": {"lift_direction": "always_up", "ground_contact": "surface"},
}

RESTITUTIONS = (0.41, 0.42, 0.43, 0.44, 0.45)  # paper, Fig. 7


def at_bat() -> Iterator[Draft]:
    """At-bats drawn from the paper's distributions, in the default reading and in every other.

    Misses stay in, as they were drawn.
    """
    yield from _drawn("at-bat-default", SamplingReading(), 60, AtBatScene(id="base"))
    for name, switches in AT_BAT_READINGS.items():
        reading, sampling = readings_of(switches)
        yield from _drawn(f"at-bat-{name}", sampling, 6, AtBatScene(id="base", reading=reading))
    # NPB's lightest and largest ball, and a light bat: the masses are not printed.
    light = AtBatScene(
        id="base", ball=Ball(mass=0.1417, radius=0.0374), bat=Bat(mass=0.82, length=0.85)
    )
    yield from _drawn("at-bat-masses", SamplingReading(), 6, light)


def _drawn(name: str, sampling: SamplingReading, count: int, base: AtBatScene) -> Iterator[Draft]:
    """Yield the first samples of which there is a scene: with a speed that is positive."""
    samples = draw(paper_at_bats(sampling), 10 * count, SEED)
    pitched = ((i, scene) for i, scene in enumerate(scenes(base, samples)) if scene is not None)
    for i, scene in islice(pitched, count):
        e = RESTITUTIONS[i % len(RESTITUTIONS)]
        struck = with_restitution(scene, e).model_copy(update={"id": f"{name}-{i:04d}"})
        drawn_by = "".join(f"{switch} = {x}, " for switch, x in sampling.model_dump().items())
        comment = f"drawn from the paper's distributions, {drawn_by}e = {e:g}"
        yield draft(struck, comment)


# --- all ------------------------------------------------------------------------------------------

Family = Callable[[], Iterator[Draft]]
FAMILIES: dict[str, Family] = {
    family.__name__.replace("_", "-"): family
    for family in (
        flight_vacuum, flight_drag, flight_lift, flight_both, flight_vertical, flight_weightless,
        pitch, impact, at_bat, hard, edges, impact_oblique, fence, real.flight_spin_lift,
        real.flight_spin_drag, real.flight_spin_decay, real.flight_wind, real.flight_weather,
        flight_kinks, real.flight_real, real.at_bat_real, real.hard_real,
        combined,
    )
}  # fmt: skip
