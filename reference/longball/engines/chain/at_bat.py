"""Solvers for the four kinds of scenes, assembled from shared steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from longball.engines.chain.collision import Ball, ContactState, meet, solve_impacts, strike
from longball.engines.chain.flying import fly, lift_is_always_up, spin_at
from longball.engines.chain.landing import land, solve_flights
from longball.engines.chain.run import Mask, Run
from longball.engines.contact import BatSection, margin_error
from longball.engines.engine import Launch, Stepped, Touch
from longball.engines.event import plate, vertical
from longball.engines.path import Flight
from longball.model.frame import Frame, launch_frame
from longball.model.law import Law, State
from longball.model.numbers import N
from longball.model.vectors import dot, minus


@dataclass(frozen=True)
class Pitch:
    """A pitch, flown to the plate or to an earlier end."""

    frame: Frame
    law: Law
    start: State
    flight: Flight
    crossed: Mask  # whether it reached the plate


def throw(run: Run) -> Pitch:
    """Fly the pitch to x = 0; record the outcome of pitches that end before."""
    numbers, pitch = run.numbers, run.scene.pitch

    # the release, with the velocity given or towards the point aimed at
    x, y, z = place = run.vector(pitch.release)
    if pitch.velocity is None:
        aim_y, aim_z = (numbers.exact(value) for value in pitch.aim)
        toward = (-x, aim_y - y, aim_z - z)
        scale = numbers.exact(pitch.speed) / numbers.sqrt(dot(toward, toward))
        velocity = (toward[0] * scale, toward[1] * scale, toward[2] * scale)
    else:
        velocity = run.vector(pitch.velocity)
    frame, start = launch_frame(place, velocity, numbers, run.spin(pitch.spin))
    law = run.law(frame)

    # the flight
    flight = fly(
        run,
        law,
        start,
        lambda state: [run.ground(state), plate(frame, state, numbers)],
        run.time_limit,
        run.everything,
    )
    run.follow(frame, flight, numbers.exact(0.0), run.everything)
    run.conclude("grounded", run.everything & flight.stopped("ground"))
    run.conclude("airborne", run.everything & flight.stopped("time"))

    # the plate
    crossed = run.everything & flight.stopped("plate")
    if run.some(crossed):
        _, y, z = frame.position(flight.state)
        u, v, w = velocity = frame.velocity(flight.state)
        angle, level = numbers.angle, numbers.sqrt(u * u + v * v)
        run.record("plate.time", flight.time, crossed)
        run.record("plate.position", (numbers.exact(0.0), y, z), crossed)
        run.record("plate.velocity", velocity, crossed)
        run.record("plate.approach.vertical", angle(w, level), crossed)
        run.record("plate.approach.horizontal", angle(v, -u), crossed)
    return Pitch(frame, law, start, flight, crossed)


@dataclass(frozen=True)
class BatEncounter:
    """A pitch, the bat, and how they meet."""

    pitch: Pitch
    bat: BatSection
    touch: Touch


def approach_bat(run: Run) -> BatEncounter | None:
    """Fly the pitch, place the bat and search for the contact; None if no pitch is at the plate."""
    pitch, numbers, scene = throw(run), run.numbers, run.scene
    if not run.some(pitch.crossed):
        return None
    # z_b = z'_b + σ_b: the batter swings at the height of the pitch at the plate, but for an offset
    # (paper, Sec. III.A)
    height = pitch.flight.state.z + numbers.exact(scene.swing.height_offset)
    reach = numbers.exact(scene.ball.radius) + numbers.exact(scene.bat.radius)
    bat = BatSection(pitch.frame, height, reach)
    events = [run.ground(pitch.start)]
    if lift_is_always_up(run, pitch.law):
        events.append(vertical(pitch.start, numbers))
    touch = run.touch(pitch.flight, pitch.law, bat, events, pitch.crossed)
    return BatEncounter(pitch, bat, touch)


def meet_bat(run: Run) -> ContactState | None:
    """Return the contact of the pitches that are struck; None if there are none.

    The others are recorded as `missed`, `beyond_bat` or `separating`. The contact does not depend
    on the restitution, so that P(e) can use it again for every e.
    """
    approach = approach_bat(run)
    if approach is None:
        return None
    numbers, pitch, touch = run.numbers, approach.pitch, approach.touch
    run.record("contact.margin", touch.margin, pitch.crossed)
    touched, missed = run.touched(touch, pitch.crossed)
    run.conclude("missed", missed)
    if not run.some(touched):
        return None
    error, frame, state = run.engine.flight_error, pitch.frame, touch.state
    assert state is not None
    ball = Ball(
        frame.position(state),
        frame.velocity(state),
        spin_at(frame, pitch.law, state, numbers, numbers.exact(error)),
        # the y by which the bat's end is decided: by Verlet's method, that of the first step inside
        # the bat (paper, Sec. III.C)
        aside=frame.position(touch.detected)[1],
        leaving=touch.leaving,
        approach=approach,
    )
    run.record("contact.time", touch.time, touched)
    run.record("contact.position", ball.position, touched)
    return meet(run, ball, approach.bat.offset(state, numbers), error, touched)


def finish(run: Run, contact: ContactState | None) -> None:
    """Apply the impulse and fly the batted ball."""
    if contact is None:
        return
    engine, touch, pitch = run.engine, contact.ball.approach.touch, contact.ball.approach.pitch

    # the impulse: only the choice between grip and slide needs an error
    error = 0.0 if run.scene.bat.friction is None else _contact_error(run, contact)
    impact, parted = strike(run, contact, error)
    if not run.some(parted):
        return

    # the launch: at the contact, or after the contact force has acted for two or three steps
    if isinstance(engine, Stepped):
        launch = engine.rebound(
            pitch.frame,
            touch,
            minus(impact.velocity, contact.ball.velocity),
            lambda frame: run.law(replace(frame, spin=impact.spin)),
            run.ground(pitch.start),
        )
        launch = replace(launch, spin=impact.spin)
    else:
        off = _launch_error(run, contact) if run.numbers.rounding else None
        launch = Launch(
            contact.ball.position,
            impact.velocity,
            touch.time,
            touch.time * 0,  # no delay, in the shape and the numbers of the time
            spin=impact.spin,
            error=off,
        )
    land(run, launch, "batted", parted)


def _contact_error(run: Run, contact: ContactState) -> N:
    """Relative error of velocities and directions at the contact.

    A shift of the path by δ, in units of the reach r, turns the normal by ``δ |v|/|v·n|``. That
    diverges at a graze, but the normal turns by √(2 δ) at most: the angle between the normals of a
    graze and of a contact that is δ r deep, from ``r cos θ = r (1 - δ)``.
    """
    numbers, error = run.numbers, run.engine.flight_error
    bat, pitch = contact.ball.approach.bat, contact.ball.approach.pitch
    moved = margin_error(bat, pitch.flight.state.z, error, numbers) / bat.reach
    speed = numbers.sqrt(dot(contact.ball.velocity, contact.ball.velocity))
    towards = abs(dot(contact.ball.velocity, contact.normal))
    most = numbers.sqrt(2 * moved)
    steep = moved * speed > most * towards
    turned = numbers.where(steep, most, moved * speed / numbers.where(steep, speed, towards))
    return error + moved + turned


def _launch_error(run: Run, contact: ContactState) -> N:
    """Return a bound on the error of the velocity after the impulse, m/s.

    After it, ``V⁺ = V - (1 + ẽ) (μ/m) (Ṽ·n) n``. The error of V counts once, that of n twice, with
    a factor ``(1 + ẽ) μ/m`` of at most two: 1 + 2 · 2 = 5. The factor is larger only under readings
    that create energy, where ẽ exceeds 1.
    """
    sqrt = run.numbers.sqrt
    ball, bat = contact.ball.velocity, contact.bat_velocity
    return 5 * _contact_error(run, contact) * (sqrt(dot(ball, ball)) + sqrt(dot(bat, bat)))


CHAINS: dict[str, Callable[[Run], None]] = {
    "flight": solve_flights,
    "pitch": lambda run: run.conclude("crossed", throw(run).crossed),
    "impact": solve_impacts,
    "at-bat": lambda run: finish(run, meet_bat(run)),
}
