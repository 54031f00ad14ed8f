"""The family of oblique impacts: friction, spin, grip and slide."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Any

from longball.golden.case_builder import Draft, between, number, shares, with_nearest
from longball.model.block import Point
from longball.model.readings import Reading
from longball.model.scene import (
    AtBatScene,
    Ball,
    Bat,
    ImpactScene,
    Incoming,
    Pitch,
    Rotation,
    Swing,
)

NATHAN = Reading(bat_ball_restitution="nathan")
FINAL = Reading(bat_ball_restitution="nathan", slide_direction="final")


def impact_oblique() -> Iterator[Draft]:
    """Impacts with friction of balls that spin: grip, slide, and what is between them."""
    for cases in (_anywhere, _special, _thresholds, _jamming, _at_bats):
        yield from cases()


def _touching(angle: float, y: float, velocity: Point, spin: Point) -> Incoming:
    reach = Ball().radius + Bat().radius
    position = (round(reach * math.cos(angle), 12), y, round(1.0 + reach * math.sin(angle), 12))
    return Incoming(position=position, velocity=velocity, bat_height=1.0, spin=spin)


def _anywhere() -> Iterator[Draft]:
    readings = (Reading(), NATHAN, FINAL, Reading(bat_ball_restitution="plain"))
    for i in range(28):
        a, b, c, d, e, f, g, h, j, k = shares(i)
        free = i % 3 == 2
        bat = Bat(
            friction=between(0.05, 0.9, a),
            support="free" if free else None,
            tangential_restitution=None if i % 4 == 0 else between(-0.5, 1.0, b),
        )
        scene = ImpactScene(
            id=f"impact-oblique-{i:04d}",
            reading=readings[i % len(readings)],
            ball=Ball(inertia_factor=None if i % 2 else between(0.3, 0.66, c)),
            bat=bat,
            swing=Rotation(angular_speed=between(0.0, 45.0, d), tilt=between(0.0, 0.2, e)),
            incoming=_touching(
                math.radians(130 * f - 65),
                between(-0.45, 0.45, g),
                (between(-45.0, -20.0, h), between(-8.0, 8.0, j), between(-12.0, 4.0, k)),
                (between(-90.0, 90.0, b), between(-300.0, 300.0, c), between(-90.0, 90.0, a)),
            ),
        )
        yield Draft(scene, "a ball that spins against a rough bat", ("friction",))


def _special() -> Iterator[Draft]:
    """Yield balls for which much is known."""
    spin = (30.0, -150.0, 40.0)
    centre = (0.4, 0.0, (-38.0, 3.0, -4.0), spin)
    anywhere = (0.4, 0.25, (-38.0, 3.0, -4.0), spin)

    def case(name: str, comment: str, touching: Any, **blocks: Any) -> Draft:
        blocks = {"bat": Bat(friction=0.5), "reading": NATHAN} | blocks
        incoming = _touching(*touching)
        scene = ImpactScene(id=f"impact-oblique-{name}", incoming=incoming, **blocks)
        return Draft(scene, comment, ("friction",))

    lossless = Ball(restitution=1.0)
    superball = Bat(friction=9.0, tangential_restitution=1.0, support="free")
    smooth = Bat(friction=9.0, tangential_restitution=-1.0, support="free")
    rolling = Bat(friction=9.0, tangential_restitution=0.0)
    comment = "e = 1, e_T = 1: energy is kept"
    yield case("superball", comment, anywhere, ball=lossless, bat=superball)
    comment = "e = 1, e_T = -1 at the centre of a free bat: energy is kept"
    yield case("no-rub", comment, centre, ball=lossless, bat=smooth)
    yield case("rolling", "e_T = 0: the ball leaves rolling", anywhere, bat=rolling)
    shell = Ball(inertia_factor=2.0 / 3.0)
    yield case("shell", "a hollow sphere", anywhere, ball=shell)
    comment = "frictionless, with a spin that stays as it is"
    yield case("frictionless", comment, anywhere, bat=Bat())
    still = Rotation(angular_speed=0.0)
    level = (0.0, 0.0, (-40.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    yield case("head-on", "no slip at all: no friction", level, swing=still)
    about = (0.0, 0.0, (-40.0, 0.0, 0.0), (250.0, 0.0, 0.0))
    yield case("about-the-normal", "a spin about the normal does not slip", about, swing=still)
    barrel = (0.1, -0.45, (-38.0, 3.0, -4.0), spin)
    comment = "the printed restitution exceeds 1 at the barrel: energy is created"
    yield case("created", comment, barrel, reading=Reading())


def _thresholds() -> Iterator[Draft]:
    """Yield balls that all but slide, and all but grip, by 1e-3 … 1e-15 of the friction."""
    incoming = _touching(0.3, 0.2, (-38.0, 6.0, -9.0), (20.0, -180.0, 10.0))
    margin = number("impact.friction_margin")
    for reading, name, powers in ((NATHAN, "", (3, 6, 9, 12, 15)), (FINAL, "final-", (12,))):
        for power, (sign, word) in product(powers, (("", "grip"), ("-", "slide"))):
            scene = ImpactScene(
                id=f"impact-oblique-{name}{word}-1e-{power:02d}",
                bat=Bat(friction=1.0),
                incoming=incoming,
                reading=reading,
            )
            needed, spare = 1 - float(margin(scene)), f"{sign}1e-{power:02d}"
            rubbed = with_nearest(scene, margin, spare, (needed, needed * 1.0001), "bat.friction")
            comment = f"friction has {spare} of itself to spare"
            yield Draft(rubbed, comment, ("friction", "grip-slide"))


def _jamming() -> Iterator[Draft]:
    """Yield a ball that jams on a disc, and the same with less friction and with more."""
    incoming = Incoming(
        position=(1.0366, -0.0249, 1.0), velocity=(-1.0, 100.0, 100.0), bat_height=1.0
    )
    cases = (0.3, "slides", ()), (0.6, "jams", ("refused",)), (2.0, "grips", ())
    for friction, word, flags in cases:
        disc = Bat(mass=0.01, length=0.05, radius=1.0, friction=friction)
        scene = ImpactScene(
            id=f"impact-oblique-disc-{word}",
            bat=disc,
            swing=Rotation(angular_speed=0.0),
            incoming=incoming,
            reading=NATHAN,
        )
        yield Draft(scene, f"a ball on the rim of a disc {word}", ("friction", "extreme", *flags))


def _at_bats() -> Iterator[Draft]:
    """Yield whole at-bats: the batted ball flies with the spin that friction gives it."""
    for name, offset, friction, spin in (
        ("under", -0.02, 0.5, None),
        ("over", 0.02, 0.5, None),
        ("slides", -0.05, 0.05, (0.0, 200.0, 0.0)),
    ):
        scene = AtBatScene(
            id=f"impact-oblique-at-bat-{name}",
            bat=Bat(friction=friction),
            pitch=Pitch(aim=(0.1, 1.8), spin=spin),
            swing=Swing(height_offset=offset),
        )
        comment = "a batted ball flies with the spin that friction gives it"
        yield Draft(scene, comment, ("friction",))
