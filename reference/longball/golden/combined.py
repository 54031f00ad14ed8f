"""The families of combinations: readings, laws and blocks together, and edges of outcomes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from longball.golden.case_builder import Draft, between, draft, five_digits, flight, shares, towards
from longball.golden.fences import RULE_BOOK, STEPPED
from longball.golden.real import NATHAN_DRAG, NATHAN_LIFT
from longball.model.air import (
    Air,
    BilinearLift,
    CrisisDrag,
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
    Fence,
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


def combined() -> Iterator[Draft]:
    """All readings, laws and blocks together, and edges of fences."""
    for cases in (_flights, _throws, _impacts, _fences):
        yield from cases()


def edges() -> Iterator[Draft]:
    """Edges of the bat, of the ground and of headings, and swings that tilt downwards."""
    for cases in (_ends_of_the_bat, _grounds, _upright, _downwards, _popped_up):
        yield from cases()


# --- every reading of a flight, under every law ---------------------------------------------------

# Switches that act on a ball with spin in a wind.
READINGS: tuple[dict[str, str], ...] = (
    {"wind_acts_on": "drag"},
    {"spin_parameter": "total"},
    {"drag_spin": "total"},
    {"spin_decay": "time"},
    {"spin_decay": "nathan"},
    {"pressure": "station"},
    {"wind_acts_on": "drag", "spin_parameter": "total", "drag_spin": "total"},
)

_BY_SPEED = Table(law="table", of="speed", at=(20.0, 35.0, 50.0), values=(0.5, 0.4, 0.3))
_BY_MACH = Table(law="table", of="mach", at=(0.05, 0.1, 0.15), values=(0.3, 0.22, 0.15))
_DRAGS = NATHAN_DRAG, CrisisDrag(law="crisis", per_spin=1e-4)
_LIFTS = NATHAN_LIFT, BilinearLift(law="bilinear"), _BY_MACH


def _air(i: int) -> Air:
    """Return air with other laws, another wind and other weather for each number."""
    a, b, c, d, *_ = shares(i)
    velocity = between(-7.0, 7.0, a), between(-5.0, 5.0, b), 0.0
    winds = (
        velocity,
        WindProfile(velocity=velocity, height=10.0, roughness=0.03),
        WindAbove(velocity=velocity, above=1.4),
    )
    weather = Weather(
        temperature=between(275.0, 308.0, c), humidity=d, elevation=between(0.0, 1600.0, b)
    )
    return Air(
        density=weather,
        density_scale_height=8217.0 if i % 2 else None,
        drag_coefficient=_BY_SPEED if i % 5 == 1 else _DRAGS[i % len(_DRAGS)],
        lift_coefficient=_LIFTS[i % len(_LIFTS)],
        spin_decay_length=between(100.0, 1341.0, d),
        wind=winds[i // 2 % len(winds)],
    )


def _earth(i: int) -> Earth:
    a, b, *_ = shares(i)
    return Earth(latitude=between(-0.7, 0.9, b), azimuth=between(0.0, 6.28, a))


def _spin(i: int) -> Point:
    *_, a, b, c = shares(i)
    return between(-120.0, 120.0, a), between(-230.0, 230.0, b), between(-120.0, 120.0, c)


def _flights() -> Iterator[Draft]:
    for i, switches in enumerate(READINGS, 1):
        velocity = towards(between(34.0, 46.0, shares(i)[0]), 12.0 + 4 * i, 12.0 * i - 36.0)
        blocks: dict[str, Any] = {"air": _air(i), "reading": Reading.model_validate(switches)}
        yield draft(
            flight(f"combined-flight-{i:04d}", velocity, spin=_spin(i), **blocks),
            "one reading, in a wind, with spin that decays",
        )


def _throws() -> Iterator[Draft]:
    """Yield pitches and at-bats in the same air, and with what else an at-bat may have."""
    # What the bat's mass is taken for, which friction and a free bat hang on, too.
    bats: tuple[dict[str, str], ...] = (
        {"inertia": "thin_rod"},
        {"inertia": "about_centre"},
        {"effective_mass": "as_printed"},
        {"reduced_mass": "effective_mass"},
        {"slide_direction": "final"},
        {"distance_origin": "launch"},
    )
    for i, switches in enumerate((*READINGS, *READINGS), 1):
        a, b, c, d, *_ = shares(i)
        pitch = Pitch(
            velocity=(-between(38.0, 44.0, a), between(-0.3, 0.3, b), between(0.0, 1.5, c)),
            release=(16.6, between(-0.2, 0.2, d), between(1.7, 2.1, a)),
            spin=_spin(i),
        )
        thrown: dict[str, Any] = {"pitch": pitch, "air": _air(i), "earth": _earth(i)}
        reading = Reading.model_validate(switches)
        scene = PitchScene(id=f"combined-pitch-{i:04d}", reading=reading, **thrown)
        yield draft(scene, "one reading, in a wind, with spin that decays")
        both = bats[i % len(bats)] | switches
        at_bat = AtBatScene(
            id=f"combined-at-bat-{i:04d}",
            reading=Reading.model_validate(both),
            bat=Bat(friction=0.05 if i % 4 == 0 else between(0.1, 0.6, b)),
            swing=Swing(height_offset=between(-0.03, 0.03, c), tilt=between(-0.2, 0.2, d)),
            **thrown,
        )
        comment = "a reading of the flight and one of the impact, with friction"
        yield draft(at_bat, comment, "friction")


# --- impacts --------------------------------------------------------------------------------------


def _touching(angle: float, y: float, spin: Point | None = None) -> Incoming:
    reach = 0.0696
    position = (round(reach * math.cos(angle), 12), y, round(1.0 + reach * math.sin(angle), 12))
    return Incoming(position=position, velocity=(-38.0, 3.0, -4.0), bat_height=1.0, spin=spin)


def _impacts() -> Iterator[Draft]:
    spin = (30.0, -150.0, 40.0)
    rough, rolling = Bat(friction=0.4), Bat(friction=0.6, tangential_restitution=0.0)
    free = {"friction": None, "support": "free"}
    free_rough = Bat(friction=0.4, support="free")
    nathan, plain = (Reading(bat_ball_restitution=x) for x in ("nathan", "plain"))
    tilted = Rotation(tilt=-0.15)
    for i, inertia in enumerate(("thin_rod", "about_centre")):
        for word, bat in (("rough", rough), ("free", free_rough)):
            reading = nathan.model_copy(update={"inertia": inertia})
            yield _impact(f"{word}-{inertia}", 0.3 - 0.5 * i, 0.2, bat, reading, spin)
    printed = Reading(effective_mass="as_printed")
    yield _impact("rough-effective-mass", 0.4, 0.1, rough, printed, spin)
    yield _impact("rough-reduced-mass", -0.2, 0.3, rough, Reading(reduced_mass="effective_mass"),
                  spin)  # fmt: skip
    for y, reading in ((0.25, nathan), (-0.3, plain), (0.0, nathan)):
        name = f"free-{reading.bat_ball_restitution}-{y:g}"
        yield _impact(name, 0.2, y, Bat.model_validate(free), reading)
    for y in (0.15, -0.35):
        yield _impact(f"rolling-{y:g}", -0.4, y, rolling, nathan, spin, tilted)
        yield _impact(f"spinning-{y:g}", 0.5, y, Bat(), Reading(), spin)


def _downwards() -> Iterator[Draft]:
    for y in (0.15, -0.35):
        scene = ImpactScene(
            id=f"edges-downwards-{y:g}", incoming=_touching(0.4, y), swing=Rotation(tilt=-0.15)
        )
        yield Draft(scene, "a swing that tilts downwards")


def _impact(
    name: str, angle: float, y: float, bat: Bat, reading: Reading, spin: Point | None = None,
    swing: Rotation | None = None,
) -> Draft:  # fmt: skip
    scene = ImpactScene(
        id=f"combined-impact-{name.replace('_', '-')}",
        incoming=_touching(angle, y, spin),
        bat=bat,
        reading=reading,
        swing=swing or Rotation(),
    )
    flags = () if bat.friction is None else ("friction",)
    return draft(scene, "a reading of the impact with friction, a free bat or a tilt", *flags)


def _ends_of_the_bat() -> Iterator[Draft]:
    """Yield touchings within a ball's radius of the bat's ends, inside and outside."""
    for side, beyond in ((1.0, 0.02), (-1.0, 0.02), (1.0, -0.02), (-1.0, -0.02)):
        scene = AtBatScene(
            id=f"edges-{'pivot' if side > 0 else 'tip'}-{'out' if beyond > 0 else 'in'}",
            pitch=Pitch(aim=(side * (0.5 + beyond), 1.8), release=(18.44, side * 0.5, 1.8)),
            swing=Swing(tilt=-0.1),
        )
        yield draft(scene, "a touching 2 cm from an end of the bat")


# --- grounds and fences ---------------------------------------------------------------------------


def _grounds() -> Iterator[Draft]:
    """Yield pitches that a ground at another height, or the ball's surface, tells from others."""
    for height in (0.4, -1.5):
        aim = (0.1, 0.9) if height > 0 else (0.1, 0.2)
        scene = AtBatScene(
            id=f"edges-ground-{height:g}", pitch=Pitch(aim=aim), ground=Ground(height=height)
        )
        yield draft(scene, "a pitch above a ground that is higher, or lower, than the plate")
    surface = Reading(ground_contact="surface")
    for height in (0.72, 0.735):
        aimed = Pitch(aim=(0.1, height))
        for word, reading in (("centre", Reading()), ("surface", surface)):
            name = f"edges-skims-{height:g}-{word}"
            scene_ = PitchScene(id=name, pitch=aimed, reading=reading)
            yield draft(scene_, "a pitch whose centre is above the ground at the plate by less "
                        "than its radius")  # fmt: skip

    for ground in (0.0, -3.0):
        yield draft(
            flight(f"edges-surface-{ground:g}", (30.0, 8.0, 14.0), reading=surface,
                   ground=Ground(height=ground)),
            "a flight that ends where the ball's surface touches the ground",
        )  # fmt: skip


def _popped_up() -> Iterator[Draft]:
    """Yield pop-ups that lift turns over the vertical, up or fixed."""
    for offset, lift in ((-0.0475, 0.5), (-0.05, 0.2), (-0.0525, 0.5)):
        scene = AtBatScene(
            id=f"edges-popped-up-{offset:g}",
            swing=Swing(height_offset=offset),
            air=Air(lift_coefficient=lift),
            reading=Reading(lift_direction="always_up"),
        )
        yield draft(scene, "an at-bat whose ball turns past the vertical")


def _fences() -> Iterator[Draft]:
    sloping = Fence(polyline=((80.0, 80.0, 12.0), (115.0, 0.0, 2.0), (80.0, -80.0, 9.0)))
    # A bay: the ball passes the fence outwards, inwards, and outwards again.
    bay = Fence(
        polyline=((70.0, 70.0, 3.0), (60.0, -5.0, 3.0), (80.0, 5.0, 5.0), (100.0, -5.0, 4.0),
                  (70.0, -70.0, 3.0))
    )  # fmt: skip
    circle = Fence(radius=110.0)
    surface, origin = Reading(fence_clearance="surface"), Reading(distance_origin="launch")
    over = (44.0, 6.0, 26.0)
    for name, velocity, fence, blocks in (
        ("sloping-left", (36.0, 20.0, 27.0), sloping, {}),
        ("sloping-right", (38.0, -18.0, 24.0), sloping, {}),
        ("sloping-surface", (40.0, 12.0, 26.0), sloping, {"reading": surface}),
        ("surface-wall", (46.0, -3.0, 18.5), RULE_BOOK, {"reading": surface}),
        ("circle-foul-left", (30.0, 36.0, 26.0), circle, {}),
        ("circle-foul-right", (24.0, -42.0, 26.0), circle, {}),
        ("circle-behind", (-46.0, 6.0, 26.0), circle, {}),
        ("bay-first", (44.0, 0.2, 26.0), bay, {}),
        ("bay-low", (40.0, -0.2, 12.0), bay, {}),
        ("origin", over, RULE_BOOK, {"reading": origin}),
        ("origin-short", (28.0, 9.0, 22.0), STEPPED, {"reading": origin}),
        ("high-ground", over, STEPPED, {"ground": Ground(height=0.8)}),
        ("low-ground", (43.0, 10.0, 20.0), sloping, {"ground": Ground(height=-4.0)}),
        ("in-time", over, RULE_BOOK, {"time_limit": 5.2}),
        ("in-time-circle", over, circle, {"time_limit": 5.2}),
    ):
        launch: dict[str, Any] = {"fence": fence, **blocks}
        aside = Launch(position=(3.0, -2.0, 1.0), velocity=velocity)
        scene = FlightScene(id=f"combined-fence-{name}", launch=aside, **launch)
        yield draft(scene, "a fence that slopes or folds, or a reading of it")


def _upright() -> Iterator[Draft]:
    """Yield launches straight up and down after others: they head for +x, whatever came before."""
    for i, rise in enumerate((28.0, -6.0, 33.0)):
        aside = towards(30.0, 30.0, 60.0 + 110 * i)
        yield Draft(flight(f"edges-aside-{i}", aside), "a flight with another heading")
        straight = (0.0, 0.0, five_digits(rise))
        scene = flight(f"edges-upright-{i}", straight, height=20.0)
        yield Draft(scene, "straight up or down: it heads for +x")
