"""The hard family: scenes that sit where implementations break, each with the reason.

Everything is a small function that yields drafts. Where a case needs a number that no one can
guess, such as the height of a bat that is grazed by 1e-15 m, the number is the double nearest to
what high precision asks for.

Sizes that are powers of two, or sums of a few, make ties exact: R = r_b = 2^-5 m touch at 2^-4 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from itertools import product
from typing import Any

import mpmath

from longball.engines.chain import approach_of, solve
from longball.engines.enclosure import Enclosure
from longball.golden.case_builder import Draft, between_powers, five_digits, shares, solve_for
from longball.home_run import HOME_RUN_DISTANCE
from longball.model.readings import Reading
from longball.model.result import Bounded, Number
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
    Swing,
)

# Digits with which numbers are chosen: a margin of 1e-15 m to all that a double can tell of it.
_CHOOSING = Enclosure(digits=40)

Triple = tuple[float, float, float]

# Ball and bat that touch at 2^-4 m, exactly.
_HALVES: dict[str, Any] = {"ball": Ball(radius=2.0**-5), "bat": Bat(radius=2.0**-5)}

UP = Reading(lift_direction="always_up")
DRAG_ONLY, LIFT_ONLY = Air(lift_coefficient=0.0), Air(drag_coefficient=0.0)


def hard() -> Iterator[Draft]:
    """Scenes that sit where implementations break."""
    for cases in (
        grazes,
        bat_ends,
        touching_at_release,
        lift_through_the_vertical,
        nearly_vertical,
        rest,
        never_landing,
        on_the_ground,
        dips,
        perpendicular,
        back_and_underside,
        restitutions,
        thresholds,
        ties,
        extreme_flights,
        extreme_pitches,
        extreme_masses,
        extreme_at_bats,
    ):
        yield from cases()


def _beside(x: float) -> tuple[tuple[str, float], ...]:
    """Return a number between its two neighbours among the doubles."""
    return (
        ("below", math.nextafter(x, -math.inf)),
        ("at", x),
        ("above", math.nextafter(x, math.inf)),
    )


def _flight(
    name: str, velocity: Triple, *, height: float = 1.0, ground: float = 0.0, **others: Any
) -> FlightScene:
    return FlightScene(
        id=f"hard-{name}",
        launch=Launch(position=(0.0, 0.0, height), velocity=velocity),
        ground=Ground(height=ground),
        **({"air": None} | others),
    )


def _impact(name: str, position: Triple, velocity: Triple, **others: Any) -> ImpactScene:
    incoming = Incoming(position=position, velocity=velocity, bat_height=1.0)
    return ImpactScene(id=f"hard-{name}", incoming=incoming, **others)


# --- ball and bat ---------------------------------------------------------------------------------


def _margin(scene: AtBatScene) -> Decimal:
    with _CHOOSING.numbers.arithmetic():
        approach = approach_of(scene, _CHOOSING)
        assert approach is not None
        return Decimal(_CHOOSING.numbers.report(approach.touch.margin).value)


def grazes() -> Iterator[Draft]:
    """Grazing at margins of ±1e-3 to ±1e-15 m.

    Where the bat is grazed by a margin m, the path cuts the circle of touching along a chord of
    half length √(2 (R + r_b) m): an error δ of the bat's height moves the touching by δ times the
    root of (R + r_b)/2m, so that half of the margin's digits are lost.
    """
    sides = (("", -1, range(3, 16)), ("under-", +1, (3, 6, 9, 12, 15)))
    for (name, side, powers), tilt in (
        *((row, math.radians(5.0)) for row in sides),
        # A level swing carries the bat away from a ball that falls past it.
        (("level-", -1, (3, 6, 9, 12, 15)), 0.0),
    ):
        for power, (sign, word) in product(powers, ((1, "plus"), (-1, "minus"))):
            margin = f"{'' if sign > 0 else '-'}1e-{power:02d}"
            case = f"hard-graze-{name}{word}-1e-{power:02d}"

            def with_offset(offset: float, case: str = case, tilt: float = tilt) -> AtBatScene:
                return AtBatScene(id=case, swing=Swing(height_offset=offset, tilt=tilt))

            guess = side * (0.0696 - sign * 10.0**-power)
            offset = solve_for(lambda x: _margin(with_offset(x)), margin, guess, guess * (1 + 1e-6))
            where = "over" if side < 0 else "under"
            comment = f"the pitch passes {where} the bat with a margin of {margin} m"
            yield Draft(with_offset(offset), comment, ("grazing",))


def bat_ends() -> Iterator[Draft]:
    """Touching at |y| = L/2 and one double to either side: the bat ends where |y| < L/2 does."""
    for side, word, near in (
        *(("pivot", *beside) for beside in _beside(0.5)),
        *(("tip", *beside) for beside in _beside(-0.5)),
    ):
        scene = AtBatScene(
            id=f"hard-bat-end-{side}-{word}",
            pitch=Pitch(release=(18.44, near, 1.8), aim=(near, 1.8)),
            swing=Swing(height_offset=-0.02),
        )
        yield Draft(scene, f"a pitch in the plane y = {near!r}", ("bat-end",))
        impact = _impact(f"bat-end-impact-{side}-{word}", (0.0696, near, 1.0), (-35.0, 0.0, -3.0))
        yield Draft(impact, f"a touching at y = {near!r}", ("bat-end",))
    # A pitch across the bat meets the end somewhere on its way.
    for word, miss in (("inside", "-1e-12"), ("outside", "1e-12")):

        def slanted(y: float, word: str = word) -> AtBatScene:
            return AtBatScene(id=f"hard-bat-end-slanted-{word}", pitch=Pitch(aim=(y, 1.8)))

        def at_touching(y: float) -> Decimal:
            result = solve(slanted(y), _CHOOSING)
            assert result.contact is not None
            assert result.contact.position is not None
            return _decimal(result.contact.position[1])

        aim = solve_for(at_touching, str(Decimal("0.5") + Decimal(miss)), 0.5, 0.501)
        yield Draft(slanted(aim), f"touches 1e-12 m {word} the bat's end", ("bat-end",))


def touching_at_release() -> Iterator[Draft]:
    """Released in touch with the bat, and one double to either side of it."""
    for word, x in _beside(2.0**-4):
        scene = AtBatScene(
            id=f"hard-release-{word}",
            **_HALVES,
            air=None,
            gravity=0.0,
            pitch=Pitch(speed=32.0, release=(x, 0.0, 1.0), aim=(0.0, 1.0)),
            swing=Swing(tilt=0.125),
        )
        flags = ("at-release", "refused") if x < 2.0**-4 else ("at-release",)
        yield Draft(scene, f"released at x = {x!r}; ball and bat touch at 0.0625 m", flags)
    for word, x in _beside(2.0**-4):
        scene = AtBatScene(
            id=f"hard-release-in-air-{word}",
            **_HALVES,
            pitch=Pitch(speed=32.0, release=(x, 0.0, 1.0), aim=(0.0, 1.0)),
            swing=Swing(height_offset=0.0),
        )
        comment = f"released at x = {x!r}, all but touching: z'_b is 1e-5 m below the release"
        yield Draft(scene, comment, ("at-release",))


def perpendicular() -> Iterator[Draft]:
    """Ṽ·n = 0, and the nearest that doubles come to it on either side."""
    front = (2.0**-4, 0.0, 1.0)
    swing = Rotation(angular_speed=32.0, tilt=0.0)  # V_b = (16, 0, 0) at the middle, exactly
    for word, vx in _beside(16.0):
        scene = _impact(
            f"perpendicular-moving-{word}", front, (vx, 1.0, -8.0), swing=swing, **_HALVES
        )
        comment = f"vx = {vx!r} against a bat that moves at 16 m/s"
        yield Draft(scene, comment, ("perpendicular",))
    still = Rotation(angular_speed=0.0)
    for word, vx in (("at", 0.0), ("below", -1e-30), ("above", 1e-30), ("closing", -1e-12)):
        scene = _impact(
            f"perpendicular-still-{word}", front, (vx, 5.0, 5.0), swing=still, **_HALVES
        )
        yield Draft(scene, f"vx = {vx!r} against a bat that stands still", ("perpendicular",))
    # A 3-4-5 triangle: n = (3/5, 0, 4/5) is no pair of doubles, and V·n = 0 all the same.
    for word, vx in _beside(32.0):
        scene = _impact(
            f"perpendicular-oblique-{word}",
            (3 * 2.0**-6, 0.0, 1.0 + 4 * 2.0**-6),
            (vx, 0.0, -24.0),
            ball=Ball(radius=5 * 2.0**-7),
            bat=Bat(radius=5 * 2.0**-7),
            swing=still,
        )
        comment = f"V = ({vx!r}, 0, -24) m/s against n = (3/5, 0, 4/5)"
        yield Draft(scene, comment, ("perpendicular",))
    # An at-bat whose bat runs away from the ball about as fast as the ball comes.
    for word, miss in (("closing", "-1e-9"), ("parting", "1e-9")):

        def running_away(speed: float, word: str = word) -> AtBatScene:
            swing = Swing(angular_speed=speed, height_offset=-0.03)
            return AtBatScene(id=f"hard-perpendicular-at-bat-{word}", swing=swing)

        def normal_speed(speed: float) -> Decimal:
            result = solve(running_away(speed), _CHOOSING)
            assert result.contact is not None
            assert result.contact.normal_speed is not None
            return _decimal(result.contact.normal_speed)

        away = running_away(solve_for(normal_speed, miss, -70.0, -71.0))
        comment = f"the bat runs away from the ball, Ṽ·n = {miss} m/s"
        yield Draft(away, comment, ("perpendicular",))


def back_and_underside() -> Iterator[Draft]:
    """Contacts on the back and the underside of the bat, where a second touching would follow.

    The model's impact is one impulse: what comes after is flown as if the bat were gone.
    """
    # A lob falls steeply through the plate: with the bat below its path it first touches the back.
    lob = Pitch(speed=14.5, release=(18.44, 0.0, 1.8), aim=(0.0, 22.0))
    for word, offset, speed in (
        ("top", 0.0, 20.0),
        ("front", 0.08, 20.0),
        ("back", -0.1, 0.0),
        ("back-swung-away", -0.1, 20.0),
        ("back-swung-against", -0.1, -20.0),
        ("far-back", -0.105, 0.0),
    ):
        swing = Swing(height_offset=offset, angular_speed=speed)
        scene = AtBatScene(id=f"hard-lob-{word}", pitch=lob, swing=swing)
        yield Draft(scene, f"a lob, the bat {offset} m above its path", ("second-touching",))
    for word, offset, speed in (
        ("underside", 0.05, 34.0),
        ("deep-underside", 0.068, 34.0),
        ("underside-still", 0.05, 0.0),
        ("underside-backwards", 0.06, -20.0),
    ):
        swing = Swing(height_offset=offset, angular_speed=speed)
        scene = AtBatScene(id=f"hard-{word}", swing=swing)
        yield Draft(scene, "the bat comes over the ball and drives it down", ("second-touching",))
    for word, position, velocity, speed in (
        ("behind", (-0.0696, 0.1, 1.0), (10.0, 0.0, -1.0), -20.0),
        ("behind-moving-on", (-0.0696, 0.1, 1.0), (-30.0, 0.0, -1.0), 34.0),
        ("below", (0.0, 0.1, 0.9304), (-30.0, 0.0, 5.0), 34.0),
        ("above", (0.0, 0.1, 1.0696), (-30.0, 0.0, -5.0), 34.0),
    ):
        rotation = Rotation(angular_speed=speed)
        impact = _impact(f"impact-{word}", position, velocity, swing=rotation)
        comment = f"a touching {word.partition('-')[0]} the bat's axis"
        yield Draft(impact, comment, ("second-touching",))


def restitutions() -> Iterator[Draft]:
    """ẽ = 0 (both go on together along the normal), 1 (no energy lost), and more (energy made)."""
    plain = Reading(bat_ball_restitution="plain")
    for word, e, reading, y in (
        ("zero", 0.0, plain, -0.2),
        ("one", 1.0, plain, -0.2),
        ("nathan-zero", 0.0, Reading(bat_ball_restitution="nathan"), -0.2),
        ("nathan-one", 1.0, Reading(bat_ball_restitution="nathan"), -0.2),
        ("above-one", 0.45, Reading(), -0.45),
        ("as-printed-zero", 0.0, Reading(), -0.45),
        ("as-printed-one", 1.0, Reading(), -0.45),
        ("about-centre", 0.45, Reading(inertia="about_centre"), -0.49),
        ("at-the-pivot", 0.45, Reading(), 0.499999),
    ):
        scene = _impact(
            f"restitution-{word}",
            (0.0696, y, 1.0),
            (-38.0, 1.0, -4.0),
            ball=Ball(restitution=e),
            reading=reading,
        )
        flags = ("restitution", "reading") if reading != Reading() else ("restitution",)
        yield Draft(scene, f"e = {e:g} at y = {y:g} m", flags)
    for e in (0.0, 1.0):
        at_bat = AtBatScene(
            id=f"hard-restitution-at-bat-{e:g}",
            ball=Ball(restitution=e),
            reading=plain,
            swing=Swing(height_offset=-0.025),
        )
        yield Draft(at_bat, f"ẽ = e = {e:g}", ("restitution", "reading"))


# --- flights --------------------------------------------------------------------------------------


def _readings() -> tuple[tuple[str, Reading, tuple[str, ...]], ...]:
    return ("spin", Reading(), ()), ("up", UP, ("reading",))


def lift_through_the_vertical() -> Iterator[Draft]:
    """Lift so strong that the path passes the vertical, and loops; under both readings."""
    for (word, reading, flags), coefficient, degrees in product(
        _readings(), (0.6, 1.0, 2.0, 4.0), (30, 80)
    ):
        angle = math.radians(degrees)
        velocity = (five_digits(50 * math.cos(angle)), 3.0, five_digits(50 * math.sin(angle)))
        name, air = f"vertical-{word}-{coefficient:g}-{degrees}", Air(lift_coefficient=coefficient)
        scene = _flight(name, velocity, air=air, reading=reading)
        comment = f"C_L = {coefficient:g}, launched at {degrees}°"
        yield Draft(scene, comment, ("vertical", *flags))
    # Without drag the ball loops on and on, and comes down by its weight alone.
    for coefficient in (0.5, 1.0, 3.0):
        air = Air(drag_coefficient=0.02, lift_coefficient=coefficient)
        scene = _flight(f"loops-{coefficient:g}", (30.0, 0.0, 0.0), height=30.0, air=air)
        yield Draft(scene, "hardly any drag: loops that shrink", ("vertical", "loops"))


def nearly_vertical() -> Iterator[Draft]:
    """Launch straight up, or all but: the heading and the side that lift turns to hang on it."""
    for (word, reading, flags), (name, vx) in product(
        _readings(),
        (("0", 0.0), ("1e-03", 1e-3), ("1e-09", 1e-9), ("1e-16", -1e-16), ("1e-30", 1e-30)),
    ):
        yield Draft(
            _flight(f"upright-{word}-{name}", (vx, 0.0, 30.0), air=Air(), reading=reading),
            f"launched upwards with vx = {vx!r} m/s",
            ("vertical", *flags),
        )


def rest() -> Iterator[Draft]:
    """V = 0 on the way, or nearly: the speed is not smooth there."""
    for power in (2, 4, 6, 8, 10, 12):
        yield Draft(
            _flight(f"rest-nearly-1e-{power:02d}", (10.0**-power, 0.0, 25.0), air=DRAG_ONLY),
            f"no faster than about 1e-{power} m/s at its apex, where the path turns about",
            ("rest",),
        )
    for name, air in (("vacuum", None), ("drag", DRAG_ONLY), ("lift", LIFT_ONLY), ("air", Air())):
        for word, reading, flags in _readings():
            if air is None and flags:
                continue  # no lift, nothing to read
            name_ = f"rest-dropped-{name}-{word}"
            scene = _flight(name_, (0.0, 0.0, 0.0), height=20.0, air=air, reading=reading)
            yield Draft(scene, "dropped from rest", ("rest", "vertical", *flags))
    scene = _flight(
        "rest-forever", (0.0, 0.0, 0.0), height=2.0, gravity=0.0, air=Air(), time_limit=10.0
    )
    yield Draft(scene, "at rest and weightless: it stays", ("rest", "airborne"))
    # Without drag K = k_L V³/3 - g u is constant; where it is zero the phugoid has cusps at V = 0.
    k = _lift_constant(LIFT_ONLY)
    for word, factor in (("below", 0.999999), ("nearest", 1.0), ("above", 1.000001)):
        speed = float(mpmath.sqrt(3 * mpmath.mpf(9.8) / k)) * factor
        scene = _flight(f"rest-cusp-{word}", (speed, 0.0, 0.0), height=200.0, air=LIFT_ONLY)
        comment = "a phugoid of cusps: at rest, or nearly, at the top of its path"
        yield Draft(scene, comment, ("rest", "vertical"))


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
        yield Draft(scene, "does not come down in time", ("airborne",))
    yield Draft(
        AtBatScene(id="hard-airborne-at-bat", time_limit=2.0, swing=Swing(height_offset=-0.03)),
        "batted, and still up when the time is over",
        ("airborne",),
    )
    yield Draft(
        PitchScene(id="hard-airborne-pitch", air=strong, time_limit=20.0, pitch=Pitch(speed=60.0)),
        "a pitch that lift turns back before the plate, over and over",
        ("airborne", "vertical"),
    )


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
        yield Draft(scene, f"launched from the ground with {velocity} m/s", ("on-ground",))
    # A flat landing: however the ball got its height, it comes down at w = -√(2 g h).
    for height in (1e-6, 1e-12, 1e-18):
        scene = _flight(f"ground-flat-{height:.0e}", (40.0, 0.0, 0.0), height=height)
        yield Draft(scene, f"skims the ground from a height of {height:g} m", ("tangential",))


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
            ground=float(bottom + sign * mpmath.mpf(10) ** -power),
            time_limit=20.0,
        )
        comment = f"its lowest point is 1e-{power} m {word} the ground"
        yield Draft(scene, comment, ("dip", "tangential"))


# --- home runs and ties ---------------------------------------------------------------------------


def thresholds() -> Iterator[Draft]:
    """D = 150 m, ± 1e-9 m: a home run or not."""
    for miss, word in (("-1e-9", "short"), ("0", "at"), ("1e-9", "over")):
        target = str(Decimal(HOME_RUN_DISTANCE) + Decimal(miss))

        def launched(speed: float, word: str = word) -> FlightScene:
            return _flight(f"home-run-flight-{word}", (speed, 0.0, 30.0), air=Air())

        def swung(speed: float, word: str = word) -> AtBatScene:
            swing = Swing(angular_speed=speed, height_offset=-0.025)
            pitch = Pitch(aim=(-0.25, 1.8))
            return AtBatScene(id=f"hard-home-run-at-bat-{word}", pitch=pitch, swing=swing)

        speed = solve_for(lambda x: _distance(launched(x)), target, 60.0, 61.0)
        yield Draft(launched(speed), f"D = 150 m and {miss} m", ("threshold",))
        speed = solve_for(lambda x: _distance(swung(x)), target, 40.0, 41.0)
        yield Draft(swung(speed), f"D = 150 m and {miss} m", ("threshold",))


def _distance(scene: FlightScene | AtBatScene) -> Decimal:
    landing = solve(scene, _CHOOSING).landing
    assert landing is not None
    return _decimal(landing.distance)


def _decimal(number: Number) -> Decimal:
    assert isinstance(number, Bounded)
    return Decimal(number.value)


def ties() -> Iterator[Draft]:
    """Two things at the same instant, exactly, and one double to either side."""
    # From 4 m with g = 8 m/s² a ball falls for exactly 1 s.
    for word, limit in _beside(1.0):
        scene = _flight(
            f"tie-time-limit-{word}", (5.0, 0.0, 0.0), height=4.0, gravity=8.0, time_limit=limit
        )
        yield Draft(scene, f"lands at t = 1 s; the time is over at {limit!r} s", ("tie",))
    for word, height in _beside(4.0):
        pitch = Pitch(speed=16.0, release=(16.0, 0.0, height), aim=(0.0, height))
        name = f"hard-tie-plate-and-ground-{word}"
        comment = f"released at {height!r} m: reaches plate and ground in the same second"
        yield Draft(PitchScene(id=name, air=None, gravity=8.0, pitch=pitch), comment, ("tie",))
    # The top of a vertical throw is the plane of the ground's height: launched and landing at once.
    yield Draft(
        _flight("tie-launch-and-ground", (3.0, 4.0, 0.0), height=1.0, ground=1.0, gravity=8.0),
        "launched along the ground: it has landed before it flies",
        ("tie", "on-ground"),
    )


# --- extremes -------------------------------------------------------------------------------------


def extreme_flights() -> Iterator[Draft]:
    """Speeds of 0.1 to 300 m/s, gravity up to 300 m/s², density up to 100 kg/m³."""
    for i in range(24):
        a, b, c, d, e, f, *_ = shares(i + 1)
        speed, angle = between_powers(0.1, 300.0, a), math.radians(170 * b - 80)
        density, coefficient = between_powers(0.001, 100.0, e), five_digits(0.4 * f - 0.1)
        scene = _flight(
            f"extreme-flight-{i:02d}",
            (
                five_digits(speed * math.cos(angle)),
                five_digits(0.1 * speed * (c - 0.5)),
                five_digits(speed * math.sin(angle)),
            ),
            height=between_powers(0.01, 100.0, c),
            gravity=between_powers(0.03, 300.0, d),
            air=Air(density=density, lift_coefficient=coefficient),
        )
        yield Draft(scene, "far from baseball", ("extreme",))
    dense = Air(density=100.0)
    for scene in (
        _flight("extreme-slowest", (0.07, 0.0, 0.07), air=Air()),
        _flight("extreme-fastest", (212.0, 0.0, 212.0), air=Air()),
        _flight("extreme-heaviest", (30.0, 0.0, 30.0), air=Air(), gravity=300.0),
        _flight("extreme-densest", (30.0, 0.0, 30.0), air=dense),
        _flight("extreme-thickest", (212.0, 0.0, 212.0), air=dense, gravity=300.0),
    ):
        yield Draft(scene, "far from baseball", ("extreme",))


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
        yield Draft(scene, "far from baseball", ("extreme",))


def extreme_masses() -> Iterator[Draft]:
    """Strike balls a million times lighter or heavier than the bat."""
    for power in (-6, -4, -2, 2, 4, 6):
        for word, reading in (("", Reading()), ("nathan-", Reading(bat_ball_restitution="nathan"))):
            scene = _impact(
                f"mass-ratio-{word}1e{power:+03d}",
                (0.0696, -0.3, 1.0),
                (-40.0, 0.0, -3.0),
                ball=Ball(mass=float(f"{0.9 * 10.0**power:.3g}")),
                reading=reading,
            )
            flags = ("extreme", "reading") if word else ("extreme",)
            yield Draft(scene, f"m/M = 1e{power}", flags)


def extreme_at_bats() -> Iterator[Draft]:
    """At-bats in little or much of everything, the bat at the height of the pitch."""
    for i in range(16):
        a, b, c, d, e, f, *_ = shares(i + 1)
        speed = between_powers(2.0, 300.0, a)
        swing = Swing(
            angular_speed=between_powers(0.1, 300.0, e), height_offset=five_digits(0.12 * f - 0.06)
        )
        scene = AtBatScene(
            id=f"hard-extreme-at-bat-{i:02d}",
            ball=Ball(mass=between_powers(0.001, 100.0, d)),
            # Slow enough to cross the plate above the ground, most of them.
            gravity=between_powers(0.001, min(300.0, speed * speed / 200), b),
            air=Air(density=between_powers(0.001, 100.0, c)),
            pitch=Pitch(speed=speed),
            swing=swing,
        )
        yield Draft(scene, "far from baseball", ("extreme",))
