"""The chains of all kinds of scenes: the throw, the swing, the contact, the batted flight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Generic, cast

from longball.engines.chain.cases import Cases
from longball.engines.chain.collision import Ball, ContactState, meet, solve_impacts, strike
from longball.engines.chain.flying import fly, lift_is_always_up, to_ground, to_plate
from longball.engines.chain.landing import land, solve_flights
from longball.engines.contact import BatSection, margin_error
from longball.engines.engine import Launch, Stepped, Touch
from longball.engines.event import Event, vertical
from longball.engines.path import Flight
from longball.model.frame import Frame, launch_frame
from longball.model.law import Law, PlaneState, State
from longball.model.numbers import N, absolute
from longball.model.vectors import dot, minus


@dataclass(frozen=True)
class Pitch(Generic[N]):
    """A pitch up to the plate, or to wherever it ended before."""

    frame: Frame[N]
    law: Law[N]
    start: State[N]
    flight: Flight[N]


def release(cases: Cases[N]) -> tuple[Frame[N], Law[N], PlaneState[N]]:
    """Return frame, law and start of a pitch, from its release towards the point aimed at."""
    numbers, pitch = cases.numbers, cases.scene.pitch
    x, y, z = place = cases.vector(pitch.release)
    if pitch.velocity is None:
        aim_y, aim_z = (numbers.exact(value) for value in pitch.aim)
        toward = (-x, aim_y - y, aim_z - z)
        scale = numbers.exact(pitch.speed) / numbers.sqrt(dot(toward, toward))
        velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    else:
        velocity = cases.vector(pitch.velocity)
    frame, start = launch_frame(place, velocity, numbers, cases.spin(pitch.spin))
    return frame, cases.law(frame), start


def throw(cases: Cases[N]) -> Pitch[N]:
    """Throw, and fly to the plane x = 0."""
    frame, law, start = release(cases)
    return Pitch(frame, law, start, fly(cases, law, frame, start, to_ground, to_plate))


def reach_plate(cases: Cases[N]) -> tuple[Cases[N], Pitch[N]]:
    """Throw; conclude the pitches that end before the plate, and return the others."""
    pitch = throw(cases)
    cases.follow(pitch.frame, pitch.flight, cases.numbers.exact(0.0))
    for stop, outcome in (("ground", "grounded"), ("time", "airborne")):
        (ended,) = cases.take(pitch.flight.stopped(stop))
        ended.conclude(outcome)
    cases, pitch = cases.take(pitch.flight.stopped("plate"), pitch)
    if not cases.empty:
        _, y, z = pitch.frame.position(pitch.flight.state)
        cases.record("plate.time", pitch.flight.time)
        cases.record("plate.position", (cases.numbers.exact(0.0), y, z))
        u, v, w = velocity = pitch.frame.velocity(pitch.flight.state)
        cases.record("plate.velocity", velocity)
        angle, level = cases.numbers.angle, cases.numbers.sqrt(u * u + v * v)
        cases.record("plate.approach.vertical", angle(w, level))
        cases.record("plate.approach.horizontal", angle(v, -u))
    return cases, pitch


def solve_pitches(cases: Cases[N]) -> None:
    """Solve releases and plates."""
    crossed, _ = reach_plate(cases)
    crossed.conclude("crossed")


@dataclass(frozen=True)
class Approach(Generic[N]):
    """A pitch, the bat, and how they meet."""

    pitch: Pitch[N]
    bat: BatSection[N]
    touch: Touch[N]

    @property
    def height(self) -> N:
        """Height of the bat's axis, m."""
        return self.bat.height


def approach_bat(cases: Cases[N]) -> tuple[Cases[N], Approach[N] | None]:
    """Throw, put the bat where it is swung, and find how the two meet."""
    cases, pitch = reach_plate(cases)
    if cases.empty:
        return cases, None
    numbers, scene = cases.numbers, cases.scene
    # z_b = z'_b + σ_b (paper, Sec. III.A)
    height = pitch.flight.state.z + numbers.exact(scene.swing.height_offset)
    reach = numbers.exact(scene.ball.radius) + numbers.exact(scene.bat.radius)
    bat = BatSection(pitch.frame, height, reach)
    upwards = lift_is_always_up(cases, pitch.law)
    touch = cases.either(upwards, _find_upwards, _find, pitch, bat)
    return cases, Approach(pitch, bat, touch)


def _find(cases: Cases[N], pitch: Pitch[N], bat: BatSection[N], *others: Event[N]) -> Touch[N]:
    events = [cases.ground(pitch.start), *others]
    return cases.engine.touch(pitch.flight, pitch.law, bat, events, cases.time_limit)


def _find_upwards(cases: Cases[N], pitch: Pitch[N], bat: BatSection[N]) -> Touch[N]:
    return _find(cases, pitch, bat, vertical(pitch.start, cases.numbers))


def meet_bat(cases: Cases[N]) -> tuple[Cases[N], ContactState[N] | None]:
    """Throw and swing; conclude what is not struck, and return the others.

    On what is returned the ball's restitution has no influence.
    """
    cases, approach = approach_bat(cases)
    if approach is None:
        return cases, None
    touch = approach.touch
    cases.record("contact.margin", touch.margin)
    touched, missed = cases.touched(touch)
    (ended,) = cases.take(missed)
    ended.conclude("missed")
    cases, approach = cases.take(touched, approach)
    if cases.empty:
        return cases, None
    touch, frame, law = approach.touch, approach.pitch.frame, approach.pitch.law
    ball = Ball(
        frame.position(touch.state),
        frame.velocity(touch.state),
        cases.spin_at(frame, law, touch.state, cases.numbers.exact(cases.engine.flight_error)),
        aside=frame.position(touch.detected)[1],
        leaving=touch.leaving,
        approach=approach,
    )
    cases.record("contact.time", touch.time)
    cases.record("contact.position", ball.position)
    error = cases.engine.flight_error
    offset = approach.bat.offset(touch.state, cases.numbers)
    return meet(cases, ball, offset, error)


def finish(cases: Cases[N], contact: ContactState[N] | None) -> None:
    """Solve at-bats from the impulse on."""
    if contact is None:
        return
    error = 0.0 if cases.scene.bat.friction is None else _contact_error(cases, contact)
    cases, contact, impact = strike(cases, contact, error)
    if cases.empty:
        return
    engine, touch, pitch = cases.engine, contact.approach.touch, contact.approach.pitch
    if isinstance(engine, Stepped):
        delta_v = minus(impact.velocity, contact.velocity)
        surface = cases.ground(pitch.start)

        def law_in(frame: Frame[N]) -> Law[N]:
            return cases.law(replace(frame, spin=impact.spin))

        launch = engine.rebound(pitch.frame, touch, delta_v, law_in, surface)
        launch = replace(launch, spin=impact.spin)
    else:
        time = cast(N, touch.time)
        off = _launch_error(cases, contact) if cases.numbers.rounding else None
        launch = Launch(
            contact.position, impact.velocity, time, time * 0, spin=impact.spin, error=off
        )
    land(cases, launch, "batted")


def _contact_error(cases: Cases[N], contact: ContactState[N]) -> N:
    """Return the relative error of velocities and directions at the contact.

    Where the ball all but grazes the bat, an error of its way moves the contact around the bat by
    as much more as it is slower towards the bat than past it; but an error δ of the margin moves it
    by √(2 δ/reach) at most, which is the angle between a graze and a touching δ deep.
    """
    engine, numbers = cases.engine, cases.numbers
    approach: Approach[N] = contact.approach
    bat, pitch = approach.bat, approach.pitch
    moved = margin_error(bat, pitch.flight.state.z, engine.flight_error, numbers) / bat.reach
    speed = numbers.sqrt(dot(contact.velocity, contact.velocity))
    towards = absolute(dot(contact.velocity, contact.normal))
    most = numbers.sqrt(2 * moved)
    steep = moved * speed > most * towards
    turned = numbers.where(steep, most, moved * speed / numbers.where(steep, speed, towards))
    return engine.flight_error + moved + turned


def _launch_error(cases: Cases[N], contact: ContactState[N]) -> N:
    """Return a bound on the error of the velocity after the impulse, m/s.

    The ball's own, and that of ``(1 + ẽ) (μ/m) (Ṽ·n) n``: n comes in twice, and the factors before
    are at most two, but under readings that create energy.
    """
    sqrt = cases.numbers.sqrt
    ball, bat = contact.velocity, contact.bat_velocity
    return 5 * _contact_error(cases, contact) * (sqrt(dot(ball, ball)) + sqrt(dot(bat, bat)))


def solve_at_bats(cases: Cases[N]) -> None:
    """Solve whole at-bats."""
    finish(*meet_bat(cases))


CHAINS: dict[str, Callable[[Cases[Any]], None]] = {
    "flight": solve_flights,
    "pitch": solve_pitches,
    "impact": solve_impacts,
    "at-bat": solve_at_bats,
}
