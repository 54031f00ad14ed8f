"""The hard family: scenes that sit where implementations break, each with the reason.

Everything is a small function that yields drafts. Where a case needs a number that no one can
guess, such as the height of a bat that is grazed by 1e-15 m, the number is the double nearest to
what high precision asks for.

Sizes that are powers of two, or sums of a few, make ties exact: R = r_b = 2^-5 m touch at 2^-4 m.
"""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from itertools import product
from typing import Any

import mpmath

from longball.engines.chain import approach_of
from longball.golden.case_builder import (
    CHOOSING,
    Draft,
    beside,
    between_powers,
    draft,
    five_digits,
    flight,
    number,
    shares,
    towards,
    with_nearest,
)
from longball.home_run import HOME_RUN_DISTANCE
from longball.model.block import Point
from longball.model.readings import Reading
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Ground,
    ImpactScene,
    Incoming,
    Pitch,
    PitchScene,
    Rotation,
    Swing,
)

# Ball and bat that touch at 2^-4 m, exactly.
_HALVES: dict[str, Any] = {"ball": Ball(radius=2.0**-5), "bat": Bat(radius=2.0**-5)}

NATHAN, PLAIN = (Reading(bat_ball_restitution=formula) for formula in ("nathan", "plain"))
LIFTS = (("spin", Reading()), ("up", Reading(lift_direction="always_up")))
DRAG_ONLY, LIFT_ONLY = Air(lift_coefficient=0.0), Air(drag_coefficient=0.0)
STILL = Rotation(angular_speed=0.0)


def hard() -> Iterator[Draft]:
    """Scenes that sit where implementations break."""
    for cases in (
        grazes, bat_ends, touching_at_release, lift_through_the_vertical, nearly_vertical, rest,
        never_landing, on_the_ground, dips, perpendicular, back_and_underside, restitutions,
        thresholds, ties, extreme_flights, extreme_pitches, extreme_masses, extreme_at_bats,
        each_in_time,
    ):  # fmt: skip
        yield from cases()


def _flight(name: str, velocity: Point, **others: Any) -> FlightScene:
    return flight(f"hard-{name}", velocity, **({"air": None} | others))


def _impact(name: str, position: Point, velocity: Point, **others: Any) -> ImpactScene:
    incoming = Incoming(position=position, velocity=velocity, bat_height=1.0)
    return ImpactScene(id=f"hard-{name}", incoming=incoming, **others)


# --- ball and bat ---------------------------------------------------------------------------------


def _margin(scene: AtBatScene) -> Decimal:
    with CHOOSING.numbers.arithmetic():
        approach = approach_of(scene, CHOOSING)
        assert approach is not None
        return Decimal(CHOOSING.numbers.report(approach.touch.margin).value)


def grazes() -> Iterator[Draft]:
    """Grazing at margins of ±1e-3 to ±1e-15 m.

    Where the bat is grazed by a margin m, the path cuts the circle of touching along a chord of
    half length √(2 (R + r_b) m): an error δ of the bat's height moves the touching by δ times the
    root of (R + r_b)/2m, so that half of the margin's digits are lost.
    """
    some = (3, 6, 9, 12, 15)
    for name, where, side, powers, swing in (
        ("", "over", -1, range(3, 16), Swing()),
        ("under-", "under", +1, some, Swing()),
        # A level swing carries the bat away from a ball that falls past it.
        ("level-", "over", -1, some, Swing(tilt=0.0)),
    ):
        for power, (sign, word) in product(powers, ((1, "plus"), (-1, "minus"))):
            margin = f"{'' if sign > 0 else '-'}1e-{power:02d}"
            scene = AtBatScene(id=f"hard-graze-{name}{word}-1e-{power:02d}", swing=swing)
            guess = side * (0.0696 - sign * 10.0**-power)
            guesses = guess, guess * (1 + 1e-6)
            grazed = with_nearest(scene, _margin, margin, guesses, "swing.height_offset")
            comment = f"the pitch passes {where} the bat with a margin of {margin} m"
            yield draft(grazed, comment, "grazing")


def bat_ends() -> Iterator[Draft]:
    """Touching at |y| = L/2 and one double to either side: the bat ends where |y| < L/2 does."""
    for side, end in (("pivot", 0.5), ("tip", -0.5)):
        for word, near in beside(end):
            scene = AtBatScene(
                id=f"hard-bat-end-{side}-{word}",
                pitch=Pitch(release=(18.44, near, 1.8), aim=(near, 1.8)),
                swing=Swing(height_offset=-0.02),
            )
            yield draft(scene, f"a pitch in the plane y = {near!r}", "bat-end")
            name = f"bat-end-impact-{side}-{word}"
            impact = _impact(name, (0.0696, near, 1.0), (-35.0, 0.0, -3.0))
            yield draft(impact, f"a touching at y = {near!r}", "bat-end")
    # A pitch across the bat meets the end somewhere on its way.
    for word, miss in (("inside", "-1e-12"), ("outside", "1e-12")):
        slanted = with_nearest(
            AtBatScene(id=f"hard-bat-end-slanted-{word}"),
            number("contact.position[1]"),
            str(Decimal("0.5") + Decimal(miss)),
            (0.5, 0.501),
            "pitch.aim[0]",
        )
        yield draft(slanted, f"touches 1e-12 m {word} the bat's end", "bat-end")


def touching_at_release() -> Iterator[Draft]:
    """Released in touch with the bat, and one double to either side of it."""
    touching = "; ball and bat touch at 0.0625 m"
    all_but = ", all but touching: z'_b is 1e-5 m below the release"
    vacuum: dict[str, Any] = {"air": None, "gravity": 0.0, "swing": Swing(tilt=0.125)}
    for name, where, others in (("", touching, vacuum), ("in-air-", all_but, {})):
        for word, x in beside(2.0**-4):
            pitch = Pitch(speed=32.0, release=(x, 0.0, 1.0), aim=(0.0, 1.0))
            scene = AtBatScene(id=f"hard-release-{name}{word}", pitch=pitch, **_HALVES, **others)
            refused = ["refused"] * (where == touching and x < 2.0**-4)
            yield draft(scene, f"released at x = {x!r}{where}", "at-release", *refused)


def perpendicular() -> Iterator[Draft]:
    """Ṽ·n = 0, and the nearest that doubles come to it on either side."""
    front = (2.0**-4, 0.0, 1.0)
    swing = Rotation(angular_speed=32.0, tilt=0.0)  # V_b = (16, 0, 0) at the middle, exactly
    for word, vx in beside(16.0):
        name = f"perpendicular-moving-{word}"
        scene = _impact(name, front, (vx, 1.0, -8.0), swing=swing, **_HALVES)
        yield draft(scene, f"vx = {vx!r} against a bat that moves at 16 m/s", "perpendicular")
    for word, vx in (("at", 0.0), ("below", -1e-30), ("above", 1e-30), ("closing", -1e-12)):
        name = f"perpendicular-still-{word}"
        scene = _impact(name, front, (vx, 5.0, 5.0), swing=STILL, **_HALVES)
        yield draft(scene, f"vx = {vx!r} against a bat that stands still", "perpendicular")
    # A 3-4-5 triangle: n = (3/5, 0, 4/5) is no pair of doubles, and V·n = 0 all the same.
    fifths = {"ball": Ball(radius=5 * 2.0**-7), "bat": Bat(radius=5 * 2.0**-7)}
    oblique = (3 * 2.0**-6, 0.0, 1.0 + 4 * 2.0**-6)
    for word, vx in beside(32.0):
        name = f"perpendicular-oblique-{word}"
        scene = _impact(name, oblique, (vx, 0.0, -24.0), swing=STILL, **fifths)
        comment = f"V = ({vx!r}, 0, -24) m/s against n = (3/5, 0, 4/5)"
        yield draft(scene, comment, "perpendicular")
    # An at-bat whose bat runs away from the ball about as fast as the ball comes.
    for word, miss in (("closing", "-1e-9"), ("parting", "1e-9")):
        away = with_nearest(
            AtBatScene(id=f"hard-perpendicular-at-bat-{word}", swing=Swing(height_offset=-0.03)),
            number("contact.normal_speed"),
            miss,
            (-70.0, -71.0),
            "swing.angular_speed",
        )
        comment = f"the bat runs away from the ball, Ṽ·n = {miss} m/s"
        yield draft(away, comment, "perpendicular")


def back_and_underside() -> Iterator[Draft]:
    """Contacts on the back and the underside of the bat, where a second touching would follow.

    The model's impact is one impulse: what comes after is flown as if the bat were gone.
    """
    # A lob falls steeply through the plate: with the bat below its path it first touches the back.
    lob = Pitch(speed=14.5, release=(18.44, 0.0, 1.8), aim=(0.0, 22.0))
    driven = "the bat comes over the ball and drives it down"
    for word, pitch, offset, speed in (
        ("lob-top", lob, 0.0, 20.0),
        ("lob-front", lob, 0.08, 20.0),
        ("lob-back", lob, -0.1, 0.0),
        ("lob-back-swung-away", lob, -0.1, 20.0),
        ("lob-back-swung-against", lob, -0.1, -20.0),
        ("lob-far-back", lob, -0.105, 0.0),
        ("underside", Pitch(), 0.05, 34.0),
        ("deep-underside", Pitch(), 0.068, 34.0),
        ("underside-still", Pitch(), 0.05, 0.0),
        ("underside-backwards", Pitch(), 0.06, -20.0),
    ):
        swing = Swing(height_offset=offset, angular_speed=speed)
        scene = AtBatScene(id=f"hard-{word}", pitch=pitch, swing=swing)
        comment = f"a lob, the bat {offset} m above its path" if pitch == lob else driven
        yield draft(scene, comment, "second-touching")
    for word, position, velocity, speed in (
        ("behind", (-0.0696, 0.1, 1.0), (10.0, 0.0, -1.0), -20.0),
        ("behind-moving-on", (-0.0696, 0.1, 1.0), (-30.0, 0.0, -1.0), 34.0),
        ("below", (0.0, 0.1, 0.9304), (-30.0, 0.0, 5.0), 34.0),
        ("above", (0.0, 0.1, 1.0696), (-30.0, 0.0, -5.0), 34.0),
    ):
        rotation = Rotation(angular_speed=speed)
        impact = _impact(f"impact-{word}", position, velocity, swing=rotation)
        comment = f"a touching {word.partition('-')[0]} the bat's axis"
        yield draft(impact, comment, "second-touching")


def restitutions() -> Iterator[Draft]:
    """ẽ = 0 (both go on together along the normal), 1 (no energy lost), and more (energy made)."""
    for word, e, reading, y in (
        ("zero", 0.0, PLAIN, -0.2),
        ("one", 1.0, PLAIN, -0.2),
        ("nathan-zero", 0.0, NATHAN, -0.2),
        ("nathan-one", 1.0, NATHAN, -0.2),
        ("above-one", 0.45, Reading(), -0.45),
        ("as-printed-zero", 0.0, Reading(), -0.45),
        ("as-printed-one", 1.0, Reading(), -0.45),
        ("about-centre", 0.45, Reading(inertia="about_centre"), -0.49),
        ("at-the-pivot", 0.45, Reading(), 0.499999),
    ):
        blocks = {"ball": Ball(restitution=e), "reading": reading}
        scene = _impact(f"restitution-{word}", (0.0696, y, 1.0), (-38.0, 1.0, -4.0), **blocks)
        yield draft(scene, f"e = {e:g} at y = {y:g} m", "restitution")
    for e in (0.0, 1.0):
        at_bat = AtBatScene(
            id=f"hard-restitution-at-bat-{e:g}",
            ball=Ball(restitution=e),
            reading=PLAIN,
            swing=Swing(height_offset=-0.025),
        )
        yield draft(at_bat, f"ẽ = e = {e:g}", "restitution")


# --- flights --------------------------------------------------------------------------------------


def lift_through_the_vertical() -> Iterator[Draft]:
    """Lift so strong that the path passes the vertical, and loops; under both readings."""
    for (word, reading), coefficient, degrees in product(LIFTS, (0.6, 1.0, 2.0, 4.0), (30, 80)):
        vx, _, vz = towards(50, degrees)
        name, air = f"vertical-{word}-{coefficient:g}-{degrees}", Air(lift_coefficient=coefficient)
        scene = _flight(name, (vx, 3.0, vz), air=air, reading=reading)
        yield draft(scene, f"C_L = {coefficient:g}, launched at {degrees}°", "vertical")
    # Without drag the ball loops on and on, and comes down by its weight alone.
    for coefficient in (0.5, 1.0, 3.0):
        air = Air(drag_coefficient=0.02, lift_coefficient=coefficient)
        scene = _flight(f"loops-{coefficient:g}", (30.0, 0.0, 0.0), height=30.0, air=air)
        yield draft(scene, "hardly any drag: loops that shrink", "vertical", "loops")


def nearly_vertical() -> Iterator[Draft]:
    """Launch straight up, or all but: the heading and the side that lift turns to hang on it."""
    nearly = (("0", 0.0), ("1e-03", 1e-3), ("1e-09", 1e-9), ("1e-16", -1e-16), ("1e-30", 1e-30))
    for (word, reading), (name, vx) in product(LIFTS, nearly):
        scene = _flight(f"upright-{word}-{name}", (vx, 0.0, 30.0), air=Air(), reading=reading)
        yield draft(scene, f"launched upwards with vx = {vx!r} m/s", "vertical")


def rest() -> Iterator[Draft]:
    """V = 0 on the way, or nearly: the speed is not smooth there."""
    for power in (2, 4, 6, 8, 10, 12):
        scene = _flight(f"rest-nearly-1e-{power:02d}", (10.0**-power, 0.0, 25.0), air=DRAG_ONLY)
        comment = f"no faster than about 1e-{power} m/s at its apex, where the path turns about"
        yield draft(scene, comment, "rest")
    still = (0.0, 0.0, 0.0)
    airs = (("vacuum", None), ("drag", DRAG_ONLY), ("lift", LIFT_ONLY), ("air", Air()))
    for (name, air), (word, reading) in product(airs, LIFTS):
        if air is None and word == "up":
            continue  # no lift, nothing to read
        dropped = f"rest-dropped-{name}-{word}"
        scene = _flight(dropped, still, height=20.0, air=air, reading=reading)
        yield draft(scene, "dropped from rest", "rest", "vertical")
    scene = _flight("rest-forever", still, height=2.0, gravity=0.0, air=Air(), time_limit=10.0)
    yield draft(scene, "at rest and weightless: it stays", "rest", "airborne")
    # Without drag K = k_L V³/3 - g u is constant; where it is zero the phugoid has cusps at V = 0.
    k = _lift_constant(LIFT_ONLY)
    for word, factor in (("below", 0.999999), ("nearest", 1.0), ("above", 1.000001)):
        speed = float(mpmath.sqrt(3 * mpmath.mpf(9.8) / k)) * factor
        scene = _flight(f"rest-cusp-{word}", (speed, 0.0, 0.0), height=200.0, air=LIFT_ONLY)
        comment = "a phugoid of cusps: at rest, or nearly, at the top of its path"
        yield draft(scene, comment, "rest", "vertical")


def _lift_constant(air: Air) -> mpmath.mpf:
    """Return k_L = ρ C_L π R²/(2 m) of the paper's ball, 1/m."""
    with mpmath.workdps(50):
        ball = Ball()
        coefficient = mpmath.mpf(air.density) * mpmath.mpf(air.lift_coefficient)
        area = mpmath.pi * mpmath.mpf(ball.radius) ** 2
        return coefficient * area / (2 * mpmath.mpf(ball.mass))


def never_landing() -> Iterator[Draft]:
    """Balls that are still up when the time is over."""
    strong = Air(drag_coefficient=0.0, lift_coefficient=3.0)
    for scene in (
        _flight("airborne-circle", (20.0, 0.0, 5.0), height=100.0, air=strong, gravity=0.0),
        _flight("airborne-phugoid", (40.0, 0.0, 0.0), height=60.0, air=strong),
        _flight("airborne-weightless", (20.0, 0.0, 5.0), gravity=0.0),
        _flight("airborne-weightless-drag", (20.0, 0.0, 5.0), gravity=0.0, air=DRAG_ONLY),
        _flight("airborne-too-early", (20.0, 0.0, 20.0), air=Air(), time_limit=2.0),
    ):
        yield draft(scene, "does not come down in time", "airborne")
    at_bat = AtBatScene(id="hard-airborne-at-bat", time_limit=2.0, swing=Swing(height_offset=-0.03))
    yield draft(at_bat, "batted, and still up when the time is over", "airborne")
    pitch = PitchScene(
        id="hard-airborne-pitch", air=strong, time_limit=20.0, pitch=Pitch(speed=60.0)
    )
    comment = "a pitch that lift turns back before the plate, over and over"
    yield draft(pitch, comment, "airborne", "vertical")


def each_in_time() -> Iterator[Draft]:
    """At-bats of whose time_limit pitch and batted ball take less each, and more together."""
    for name, offset, limit in (("high", -0.03, 5.7), ("low", -0.02, 4.8)):
        swing = Swing(height_offset=offset)
        scene = AtBatScene(id=f"hard-each-in-time-{name}", time_limit=limit, swing=swing)
        yield draft(scene, "pitch and flight are in time, each by itself")


def on_the_ground() -> Iterator[Draft]:
    """Launch from the ground: up, along it, or not at all."""
    topspin = Air(lift_coefficient=-0.2)
    strong = Air(lift_coefficient=2.0)
    for name, velocity, air, gravity in (
        ("up", (20.0, 0.0, 15.0), Air(), 9.8),
        ("down", (20.0, 0.0, -15.0), Air(), 9.8),
        ("along-vacuum", (20.0, 0.0, 0.0), None, 9.8),
        ("along-lifted", (40.0, 0.0, 0.0), strong, 9.8),
        ("along-pressed", (40.0, 0.0, 0.0), topspin, 9.8),
        ("along-weightless", (20.0, 0.0, 0.0), None, 0.0),
        ("at-rest", (0.0, 0.0, 0.0), None, 9.8),
        ("up-by-1e-9", (20.0, 0.0, 1e-9), None, 9.8),
        ("up-by-1e-30", (20.0, 0.0, 1e-30), None, 9.8),
    ):
        scene = _flight(f"ground-{name}", velocity, height=0.0, air=air, gravity=gravity)
        yield draft(scene, f"launched from the ground with {velocity} m/s", "on-ground")
    # A flat landing: however the ball got its height, it comes down at w = -√(2 g h).
    for height in (1e-6, 1e-12, 1e-18):
        scene = _flight(f"ground-flat-{height:.0e}", (40.0, 0.0, 0.0), height=height)
        yield draft(scene, f"skims the ground from a height of {height:g} m", "tangential")


def dips() -> Iterator[Draft]:
    """Graze the ground in a dip: lift turns a falling ball up again within one long step."""
    # No gravity: a circle of radius 1/k_L, whose lowest point is (1 - cos α)/k_L below the launch.
    air = Air(drag_coefficient=0.0, lift_coefficient=1.0)
    with mpmath.workdps(50):
        u, w = mpmath.mpf(32.0), mpmath.mpf(-24.0)
        bottom = 50 - (1 - u / mpmath.sqrt(u * u + w * w)) / _lift_constant(air)
        yield from _around("circle", bottom, air, 0.0)
        # Lift and weight: E = g z + V²/2 and K = k_L V³/3 - g u are constant; at the bottom u = V.
        g, k = mpmath.mpf(9.8), _lift_constant(air)
        energy, phugoid = g * 50 + (u * u + w * w) / 2, k * mpmath.mpf(40) ** 3 / 3 - g * u
        fastest = mpmath.findroot(lambda v: k * v**3 / 3 - g * v - phugoid, 45)
        yield from _around("phugoid", (energy - fastest**2 / 2) / g, air, 9.8)


def _around(name: str, bottom: mpmath.mpf, air: Air, gravity: float) -> Iterator[Draft]:
    for power, (sign, word) in product((3, 6, 9, 12), ((1, "under"), (-1, "over"))):
        scene = _flight(
            f"dip-{name}-{word}-1e-{power:02d}",
            (32.0, 0.0, -24.0),
            height=50.0,
            air=air,
            gravity=gravity,
            ground=Ground(height=float(bottom + sign * mpmath.mpf(10) ** -power)),
            time_limit=20.0,
        )
        yield draft(
            scene, f"its lowest point is 1e-{power} m {word} the ground", "dip", "tangential"
        )


# --- home runs and ties ---------------------------------------------------------------------------


def thresholds() -> Iterator[Draft]:
    """D = 150 m, ± 1e-9 m: a home run or not."""
    for miss, word in (("-1e-9", "short"), ("0", "at"), ("1e-9", "over")):
        target = str(Decimal(HOME_RUN_DISTANCE) + Decimal(miss))
        distance, comment = number("landing.distance"), f"D = 150 m and {miss} m"
        launched = _flight(f"home-run-flight-{word}", (60.0, 0.0, 30.0), air=Air())
        launched = with_nearest(launched, distance, target, (60.0, 61.0), "launch.velocity[0]")
        yield draft(launched, comment, "threshold")
        swung = AtBatScene(
            id=f"hard-home-run-at-bat-{word}",
            pitch=Pitch(aim=(-0.25, 1.8)),
            swing=Swing(height_offset=-0.025),
        )
        swung = with_nearest(swung, distance, target, (40.0, 41.0), "swing.angular_speed")
        yield draft(swung, comment, "threshold")


def ties() -> Iterator[Draft]:
    """Two things at the same instant, exactly, and one double to either side."""
    # From 4 m with g = 8 m/s² a ball falls for exactly 1 s.
    for word, limit in beside(1.0):
        name, level = f"tie-time-limit-{word}", (5.0, 0.0, 0.0)
        scene = _flight(name, level, height=4.0, gravity=8.0, time_limit=limit)
        yield draft(scene, f"lands at t = 1 s; the time is over at {limit!r} s", "tie")
    for word, height in beside(4.0):
        pitch = Pitch(speed=16.0, release=(16.0, 0.0, height), aim=(0.0, height))
        name = f"hard-tie-plate-and-ground-{word}"
        comment = f"released at {height!r} m: reaches plate and ground in the same second"
        yield draft(PitchScene(id=name, air=None, gravity=8.0, pitch=pitch), comment, "tie")
    # The top of a vertical throw is the plane of the ground's height: launched and landing at once.
    ground = Ground(height=1.0)
    scene = _flight("tie-launch-and-ground", (3.0, 4.0, 0.0), ground=ground, gravity=8.0)
    comment = "launched along the ground: it has landed before it flies"
    yield draft(scene, comment, "tie", "on-ground")


# --- extremes -------------------------------------------------------------------------------------

_FAR = "far from baseball"


def extreme_flights() -> Iterator[Draft]:
    """Speeds of 0.1 to 300 m/s, gravity up to 300 m/s², density up to 100 kg/m³."""
    for i in range(24):
        a, b, c, d, e, f, *_ = shares(i + 1)
        speed = between_powers(0.1, 300.0, a)
        vx, _, vz = towards(speed, 170 * b - 80)
        density, coefficient = between_powers(0.001, 100.0, e), five_digits(0.4 * f - 0.1)
        scene = _flight(
            f"extreme-flight-{i:02d}",
            (vx, five_digits(0.1 * speed * (c - 0.5)), vz),
            height=between_powers(0.01, 100.0, c),
            gravity=between_powers(0.03, 300.0, d),
            air=Air(density=density, lift_coefficient=coefficient),
        )
        yield draft(scene, _FAR, "extreme")
    dense = Air(density=100.0)
    for scene in (
        _flight("extreme-slowest", (0.07, 0.0, 0.07), air=Air()),
        _flight("extreme-fastest", (212.0, 0.0, 212.0), air=Air()),
        _flight("extreme-heaviest", (30.0, 0.0, 30.0), air=Air(), gravity=300.0),
        _flight("extreme-densest", (30.0, 0.0, 30.0), air=dense),
        _flight("extreme-thickest", (212.0, 0.0, 212.0), air=dense, gravity=300.0),
    ):
        yield draft(scene, _FAR, "extreme")


def extreme_pitches() -> Iterator[Draft]:
    """Pitches of 0.1 to 300 m/s in little or much of everything."""
    for i in range(8):
        a, b, c, *_ = shares(i + 1)
        scene = PitchScene(
            id=f"hard-extreme-pitch-{i:02d}",
            pitch=Pitch(speed=between_powers(0.1, 300.0, a)),
            gravity=between_powers(0.0001, 300.0, b) if i % 4 else 0.0,
            air=Air(density=between_powers(0.001, 100.0, c)),
        )
        yield draft(scene, _FAR, "extreme")


def extreme_masses() -> Iterator[Draft]:
    """Strike balls a million times lighter or heavier than the bat."""
    for power, (word, reading) in product(
        (-6, -4, -2, 2, 4, 6), (("", Reading()), ("nathan-", NATHAN))
    ):
        scene = _impact(
            f"mass-ratio-{word}1e{power:+03d}",
            (0.0696, -0.3, 1.0),
            (-40.0, 0.0, -3.0),
            ball=Ball(mass=float(f"{0.9 * 10.0**power:.3g}")),
            reading=reading,
        )
        yield draft(scene, f"m/M = 1e{power}", "extreme")


def extreme_at_bats() -> Iterator[Draft]:
    """At-bats in little or much of everything, the bat at the height of the pitch."""
    for i in range(16):
        a, b, c, d, e, f, *_ = shares(i + 1)
        speed, turning = between_powers(2.0, 300.0, a), between_powers(0.1, 300.0, e)
        scene = AtBatScene(
            id=f"hard-extreme-at-bat-{i:02d}",
            ball=Ball(mass=between_powers(0.001, 100.0, d)),
            # Slow enough to cross the plate above the ground, most of them.
            gravity=between_powers(0.001, min(300.0, speed * speed / 200), b),
            air=Air(density=between_powers(0.001, 100.0, c)),
            pitch=Pitch(speed=speed),
            swing=Swing(angular_speed=turning, height_offset=five_digits(0.12 * f - 0.06)),
        )
        yield draft(scene, _FAR, "extreme")
