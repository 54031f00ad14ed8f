"""The family of kinks: tables, bilinear lift, and a wind that sets in at a height.

There the law changes its form on the way. A lattice takes all of these laws, by turns and together;
then come flights whose kinks lie where an engine may miss them. Numbers that no one can guess, as
the least speed of a flight, are the doubles nearest to what high precision finds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from longball.engines.chain import solve_with_path
from longball.engines.event import first_fall
from longball.golden.case_builder import (
    CHOOSING,
    Draft,
    between,
    draft,
    five_digits,
    flight,
    shares,
    towards,
)
from longball.model.air import (
    Air,
    BilinearLift,
    ConstantLift,
    Table,
    Weather,
    WindAbove,
    WindProfile,
)
from longball.model.block import Point
from longball.model.readings import Reading
from longball.model.scene import FlightScene

BILINEAR = BilinearLift(law="bilinear")
BACKSPIN = (0.0, -200.0, 0.0)
CALM = Air(drag_coefficient=0.35, lift_coefficient=0.0)

# A drag that falls with the speed.
FALLING_DRAG = Table(
    law="table", of="speed", at=(15.0, 22.0, 29.0, 36.0), values=(0.52, 0.5, 0.42, 0.33)
)


def flight_kinks() -> Iterator[Draft]:
    """Tables, bilinear lift, and a wind above a height: laws that change their form on the way."""
    for cases in (
        _lattice, _moving_nodes, _least_speeds, _largest_spin_parameters, _apexes, _two_at_once,
        _jumps_over_nodes, _from_a_kink, _again_and_again,
    ):  # fmt: skip
        yield from cases()


def _flight(name: str, air: Air, velocity: Point, **others: Any) -> FlightScene:
    return flight(f"flight-kinks-{name}", velocity, air=air, **others)


# --- all laws -------------------------------------------------------------------------------------


def _by_mach(a: float, *values: float) -> Table:
    """Return a table over Mach numbers that a batted ball passes, of airspeeds 17 to 38 m/s."""
    nodes = (between(0.05, 0.06, a), between(0.075, 0.085, a), between(0.1, 0.11, a))
    return Table(law="table", of="mach", at=nodes, values=values)


def _by_spin(a: float, *values: float) -> Table:
    """Return a table over spin parameters that a batted ball passes."""
    nodes = (0.0, between(0.08, 0.12, a), between(0.2, 0.25, a), 0.4)
    return Table(law="table", of="spin_parameter", at=nodes, values=values)


def _airs(a: float, b: float) -> tuple[Air, ...]:
    """Return airs of all laws that have kinks."""
    weather = Weather(temperature=between(275.0, 308.0, a), humidity=b)
    wind = WindAbove(
        velocity=(between(-8.0, 8.0, b), between(-4.0, 4.0, a), 0.0), above=between(3.0, 9.0, a)
    )
    nodes = tuple(five_digits(node + 3.0 * b) for node in FALLING_DRAG.at)
    drag = Table(law="table", of="speed", at=nodes, values=FALLING_DRAG.values)
    lift = _by_spin(a, 0.0, 0.13, 0.22, 0.27)
    return (
        Air(drag_coefficient=drag),
        Air(density=weather, drag_coefficient=_by_mach(b, 0.5, 0.44, 0.33)),
        Air(density=weather, drag_coefficient=0.35, lift_coefficient=_by_mach(b, 0.3, 0.2, 0.1)),
        Air(drag_coefficient=0.35, lift_coefficient=0.1, wind=wind),
        # From here on with spin.
        Air(drag_coefficient=0.35, lift_coefficient=BILINEAR),
        Air(drag_coefficient=0.35, lift_coefficient=lift),
        Air(drag_coefficient=_by_spin(b, 0.3, 0.34, 0.4, 0.45), lift_coefficient=BILINEAR),
        Air(drag_coefficient=drag, lift_coefficient=lift, wind=wind),
    )


def _lattice() -> Iterator[Draft]:
    for i in range(16):
        a, b, c, d, e, f, g, h, *_ = shares(i)
        airs = _airs(a, b)
        spins, in_space = i % len(airs) >= 4, i >= len(airs)
        vx, _, vz = towards(between(28.0, 48.0, c), between(15.0, 55.0, d))
        sideways = between(-150.0, 150.0, e) if in_space else 0.0
        scene = _flight(
            f"{i:04d}",
            airs[i % len(airs)],
            (vx, between(-3.0, 3.0, f) if in_space else 0.0, vz),
            spin=(sideways, -between(80.0, 280.0, g), 0.5 * sideways) if spins else None,
            height=between(0.4, 1.4, h),
            reading=Reading(
                spin_parameter=("transverse", "total")[i % 2 if spins else 0],
                wind_acts_on=("both", "drag")[1 if i == 11 else 0],
            ),
        )
        yield draft(scene, "a law that changes its form on the way", "kink")


def _moving_nodes() -> Iterator[Draft]:
    """Yield nodes over the spin parameter of a spin that decays, and in a logarithmic wind.

    Where a ball passes them hangs on an exponential of the way, or on a logarithm of the height.
    """
    wind = WindProfile(velocity=(4.0, -2.0, 0.0), height=10.0, roughness=0.03)
    spin_table = _by_spin(0.3, 0.0, 0.13, 0.22, 0.27)
    airs = {
        "bilinear": Air(drag_coefficient=0.35, lift_coefficient=BILINEAR, spin_decay_length=300.0),
        "table": Air(drag_coefficient=0.35, lift_coefficient=spin_table, spin_decay_length=800.0),
        "wind": Air(drag_coefficient=FALLING_DRAG, wind=wind),
        "wind-bilinear": Air(drag_coefficient=FALLING_DRAG, lift_coefficient=BILINEAR, wind=wind),
        "all": Air(
            drag_coefficient=_by_spin(0.6, 0.3, 0.34, 0.4, 0.45),
            lift_coefficient=BILINEAR,
            wind=wind,
            spin_decay_length=500.0,
        ),
    }
    for name, air in airs.items():
        for way in ("path", "time", "nathan") if air.spin_decay_length else ("path",):
            scene = _flight(
                f"moving-{name}-{way}",
                air,
                (33.0, 2.0, 21.0),
                spin=(40.0, -190.0, 25.0) if name != "wind" else None,
                reading=Reading(spin_decay=way),
            )
            yield draft(scene, "a node that moves with the spin left, or with the height", "kink")


# --- turning points -------------------------------------------------------------------------------


def _first(
    scene: FlightScene, value: Callable[[Any], Any], *, falls: bool = False
) -> tuple[float, Any]:
    """Return the first turning value of a function of the state, and that state.

    Or where the function first falls through zero, if it `falls`.
    """
    numbers = CHOOSING.numbers
    with numbers.arithmetic():
        _, way = solve_with_path(scene, CHOOSING)
        for piece in way.legs[0].flight.path.pieces():
            curve = piece.curve(value)
            if falls:
                time = first_fall(curve, piece.length, numbers.exact(0.0), "it falls", numbers)
                times = [] if time is None else [time]
            else:
                times = [*curve.turns(numbers.exact(0.0), piece.length)]
            if times:
                return float(curve(times[0]).mid()), piece.at(times[0])
    raise ValueError(f"{scene.id}: there is no such place")


def _square_of_speed(state: Any) -> Any:
    return state.u * state.u + state.w * state.w


def _beside(turning: float, size: float = 1.0) -> Iterator[tuple[str, float]]:
    """Yield numbers beside a turning value, by powers of ten of a size, and the one at it."""
    for power in (3, 6, 9, 12):
        yield f"above-1e-{power:02d}", turning + size * 10.0**-power
        yield f"below-1e-{power:02d}", turning - size * 10.0**-power
    yield "at", turning


def _least_speeds() -> Iterator[Draft]:
    """Yield flights whose least speed is next to a node, below which the drag rises."""
    velocity = (28.0, 0.0, 21.0)
    least = math.sqrt(_first(_flight("first", CALM, velocity), _square_of_speed)[0])
    for name, node in _beside(least):
        drag = Table(law="table", of="speed", at=(node - 6.0, node), values=(0.6, 0.35))
        air = Air(drag_coefficient=drag, lift_coefficient=0.0)
        scene = _flight(f"speed-node-{name}", air, velocity)
        yield draft(scene, "the speed turns next to a node of the drag's table", "kink")


def _largest_spin_parameters() -> Iterator[Draft]:
    """Yield flights whose largest spin parameter is next to a node, beyond which lift rises."""
    velocity = (28.0, 0.0, 21.0)
    flat = Air(drag_coefficient=0.35, lift_coefficient=ConstantLift(law="constant", value=0.15))
    first = _flight("first", flat, velocity, spin=BACKSPIN)
    speed = math.sqrt(_first(first, _square_of_speed)[0])
    for name, node in _beside(first.ball.radius * -BACKSPIN[1] / speed):
        lift = Table(law="table", of="spin_parameter", at=(node, 0.5), values=(0.15, 0.4))
        air = Air(drag_coefficient=0.35, lift_coefficient=lift)
        scene = _flight(f"spin-node-{name}", air, velocity, spin=BACKSPIN)
        yield draft(scene, "the spin parameter turns next to a node of the lift's table", "kink")


def _apexes() -> Iterator[Draft]:
    """Yield flights that rise up to a height, or not quite, above which a wind blows."""
    velocity = (25.0, 0.0, 17.0)
    top, _ = _first(_flight("first", CALM, velocity), lambda state: state.z)
    for name, above in _beside(top):
        wind = WindAbove(velocity=(8.0, 3.0, 0.0), above=above)
        air = Air(wind=wind, drag_coefficient=0.35, lift_coefficient=0.0)
        scene = _flight(f"wind-{name}", air, velocity)
        comment = "the apex is next to the height above which a wind blows"
        yield draft(scene, comment, "kink", *["tangential"] * (name == "at"))


# --- several kinks --------------------------------------------------------------------------------


def _two_at_once() -> Iterator[Draft]:
    """Yield flights that pass two kinks at the same time, or all but."""
    velocity = (30.0, 0.0, 20.0)
    lift = Table(law="table", of="speed", at=FALLING_DRAG.at, values=(0.3, 0.25, 0.15, 0.1))
    both = Air(drag_coefficient=FALLING_DRAG, lift_coefficient=lift)
    scenes = [_flight("both-by-speed", both, velocity)]
    drag = Table(law="table", of="spin_parameter", at=(0.1, 0.3, 0.5), values=(0.3, 0.35, 0.45))
    lift = Table(law="table", of="spin_parameter", at=(0.1, 0.3, 0.5), values=(0.12, 0.24, 0.3))
    both = Air(drag_coefficient=drag, lift_coefficient=lift)
    scenes.append(_flight("both-by-spin", both, velocity, spin=(30.0, -190.0, 60.0)))
    # On the way up it passes a node at 29 m/s, where a side wind sets in.
    _, state = _first(
        _flight("first", CALM, velocity), lambda state: _square_of_speed(state) - 841.0, falls=True
    )
    drag = Table(law="table", of="speed", at=(23.0, 29.0), values=(0.55, 0.35))
    height = float(state.z.mid())
    for name, shift in (("at", 0.0), ("below", -1e-9)):
        wind = WindAbove(velocity=(0.0, 6.0, 0.0), above=height + shift)
        air = Air(drag_coefficient=drag, lift_coefficient=0.0, wind=wind)
        scenes.append(_flight(f"node-and-wind-{name}", air, velocity))
    for scene in scenes:
        yield draft(scene, "two kinks at the same time, or all but", "kink", "tie")


def _jumps_over_nodes() -> Iterator[Draft]:
    """Yield flights whose airspeed jumps over nodes where the wind sets in, and goes back."""
    drag = Table(law="table", of="speed", at=(26.0, 28.0, 30.0), values=(0.6, 0.4, 0.2))
    for blows, height, rise in ((-8.0, 1.0, 20.0), (8.0, 1.0, 20.0), (-8.0, 30.0, -5.0)):
        wind = WindAbove(velocity=(blows, 0.0, 0.0), above=8.0)
        air = Air(drag_coefficient=drag, lift_coefficient=0.0, wind=wind)
        scene = _flight(f"jump-{blows:+g}-from-{height:g}", air, (24.0, 0.0, rise), height=height)
        yield draft(scene, "the airspeed jumps over the nodes where the wind sets in", "kink")


def _from_a_kink() -> Iterator[Draft]:
    """Yield launches on a kink: a node of the speed, or the height where the wind sets in."""
    comment = "launched on a node, or at the height where the wind sets in"
    drag = Table(law="table", of="speed", at=(20.0, 30.0, 40.0), values=(0.5, 0.4, 0.25))
    still = Air(drag_coefficient=drag, lift_coefficient=0.0)
    for word, rise in (("up", 24.0), ("down", -24.0)):  # the speed is 30 m/s
        scene = _flight(f"on-node-{word}", still, (18.0, 0.0, rise), height=30.0)
        yield draft(scene, comment, "kink")
    wind = WindAbove(velocity=(-7.0, 2.0, 0.0), above=20.0)
    air = Air(drag_coefficient=0.35, lift_coefficient=0.1, wind=wind)
    for word, rise in (("up", 10.0), ("level", 0.0), ("down", -10.0)):
        scene = _flight(f"on-height-{word}", air, (30.0, 0.0, rise), height=20.0)
        yield draft(scene, comment, "kink")


def _again_and_again() -> Iterator[Draft]:
    """Yield flights that skip along the height where the wind sets in.

    Below it lift carries the ball; above, with a tail wind, it does not.
    """
    comment = "it rises above the height where the wind sets in, and falls below it, several times"
    for i, (rise, blows) in enumerate(((3.0, 22.0), (6.0, 15.0))):
        wind = WindAbove(velocity=(blows, 1.0, 0.0), above=3.0)
        air = Air(drag_coefficient=0.2, lift_coefficient=0.4, wind=wind)
        yield draft(_flight(f"skips-{i}", air, (44.0, 0.0, rise)), comment, "kink")
