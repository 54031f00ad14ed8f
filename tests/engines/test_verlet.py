"""The paper's scheme: what it is exactly, how fast it converges, and what it does to a contact."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from longball.engines import create, event
from longball.engines.chain import approach_of, solve, solve_with_path
from longball.engines.compiled import Code
from longball.engines.event import BatSection
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import (
    TREATMENTS,
    Verlet,
    line_touch,
    plain_step,
    steps_of,
)
from longball.model.frame import Frame
from longball.model.law import PlaneState, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import Air, AtBatScene, FlightScene, Ground, Launch, Pitch, Swing
from tests.engines.test_ivp import ground, plate


def law(*forces, **strengths):
    return law_with(strengths, forces)


K_D, K_L, G = 0.0075, 0.0037, 9.8
AIR, NOTHING = law(drag=K_D, lift=K_L, gravity=G), law()
START = PlaneState(0.0, 1.0, 32.0, 22.0)
TRUTH = Multiprecision(20)
PLAIN = AtBatScene(id="plain")
TABLE = {"law": "table", "of": "speed", "at": (20.0, 30.0, 40.0), "values": (0.5, 0.45, 0.33)}
every_treatment = pytest.mark.parametrize("treatment", TREATMENTS)


def verlet(dt, treatment="implicit", **options):
    return Verlet(dt, treatment, **options)


def after_steps(engine, count, start=START, law=AIR):
    """State after so many whole steps."""
    arrival = engine.fly(law, start, [], (count - 0.5) * engine.dt)
    assert arrival.stop == "time"
    assert arrival.time == count * engine.dt
    return arrival.state


def fall(engine):
    """Arrival of the flight at the ground."""
    return engine.fly(AIR, START, [ground()], 10.0)


def flight(**keys):
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(32.0, 0.0, 22.0))
    return FlightScene(id="flight", launch=launch, **keys)


@pytest.fixture(scope="module")
def truth():
    """The state at 2 s, and the landing at z = 0, in twenty digits of another engine."""
    exact = TRUTH.numbers.exact
    there = law_with({name: exact(k) for name, k in AIR.strengths.items()})
    start = PlaneState(*map(exact, START))
    landing = TRUTH.fly(there, start, [event.ground(exact(0.0), start, TRUTH.numbers)], exact(60))
    end = [*map(float, landing.path.at(exact(2.0)))]
    return end, float(landing.time), float(landing.state.s)


# ---- what a step is ------------------------------------------------------------------------------


# Where the force is evaluated, in a Δt beyond v; whether it is iterated; whether it is carried on;
# and the order.
PRINTED = {
    "old_carried": (0.0, False, True, 1),
    "old_recomputed": (0.0, False, False, 1),
    "half_step": (0.5, False, True, 1),
    "predicted_carried": (1.0, False, True, 2),
    "predicted_recomputed": (1.0, False, False, 2),
    "implicit": (1.0, True, False, 2),
}


@every_treatment
@pytest.mark.parametrize("named", [{}, {"gravity": G}, {"drag": K_D, "lift": K_L, "gravity": G}])
def test_the_printed_steps_are_the_plain_ones_bit_for_bit(treatment, named):
    way, dt, there = TREATMENTS[treatment], 0.037, law(**named)
    rates = there.rates(DOUBLES)

    def air(position, velocity):
        return rates(*position, *velocity)[2:]

    marches = []
    for work in (1, 10**9):  # as it is, and compiled
        run = steps_of(there.program).count(work)
        states = np.empty((4, 51))
        states[:, 0] = START
        ends = START[:2], START[2:]
        run.march(states, *ends, air(*ends), dt, *way, tuple(named.values()))
        marches.append(states)
    position, velocity, nothing = START[:2], START[2:], (0.0, 0.0)
    force = air(position, velocity)
    for k in range(1, 51):
        position, velocity, force = plain_step(
            position, velocity, force, nothing, nothing, dt, *way, air
        )
        for states in marches:
            assert (*position, *velocity) == tuple(states[:, k])


@every_treatment
def test_a_step_is_what_frenkel_and_smit_print(treatment):
    """Written out anew, for drag and weight."""
    dt, (ahead, iterates, carries, _) = 0.037, PRINTED[treatment]
    s, z, u, w = START

    def force(u, w):
        speed = math.hypot(u, w)
        return np.array([-K_D * speed * u - K_L * speed * w, K_L * speed * u - K_D * speed * w - G])

    r, v, a = np.array([s, z]), np.array([u, w]), force(u, w)
    for _ in range(20):
        half = v + a * dt / 2
        r = r + half * dt
        a = force(*(v + ahead * a * dt))
        v = half + a * dt / 2
        for _ in range(20 if iterates else 0):
            a = force(*v)
            v = half + a * dt / 2
        a = a if carries else force(*v)
    assert after_steps(Verlet(dt, treatment), 20) == pytest.approx((*r, *v), rel=1e-13)


@given(st.integers(1, 400), st.integers(-64, 64), st.integers(-64, 64))
def test_the_parabola_is_exact(count, u, w):
    """On whole multiples of powers of two nothing is rounded, and no error is left."""
    dt, g = 2.0**-6, 9.75
    t = count * dt
    state = after_steps(verlet(dt), count, PlaneState(0.0, 1.0, u, w), law(gravity=g))
    assert state == (u * t, 1.0 + w * t - g * t * t / 2, u, w - g * t)


# ---- convergence ---------------------------------------------------------------------------------


@every_treatment
def test_observed_order_within_a_tenth_of_theory(treatment, truth):
    """Of each number of the state."""
    counts = [150, 220, 330, 500, 740]  # steps of 13 to 3 ms, not halving
    ends = [after_steps(verlet(2 / n, treatment), n) for n in counts]
    errors = np.abs(np.subtract(ends, truth[0]))
    orders = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert orders == pytest.approx(PRINTED[treatment][-1], abs=0.1)


# ---- the ends of a flight ------------------------------------------------------------------------


@pytest.mark.parametrize("stop", ["ground", "plate"])
def test_a_stop_lies_on_the_line_between_two_steps(stop):
    engine = verlet(0.05)
    arrival = engine.fly(AIR, START, [{"ground": ground(), "plate": plate(50.0)}[stop]], 60.0)
    count = math.ceil(arrival.time / engine.dt)
    before, after = after_steps(engine, count - 1), after_steps(engine, count)
    share = arrival.time / engine.dt - (count - 1)
    assert arrival.stop == stop
    assert arrival.state == pytest.approx(
        [a + share * (b - a) for a, b in zip(before, after, strict=True)], abs=1e-12
    )
    assert (arrival.state.z == 0.0) if stop == "ground" else (arrival.state.s == 50.0)


@pytest.mark.parametrize("landing", ["interpolated", "first_below"])
def test_a_ball_that_glides_on_the_ground_is_down(landing):
    """Without gravity its height neither rises nor falls, nor begins to."""
    glides = verlet(0.05, landing=landing)
    flight = glides.fly(law_with({}), PlaneState(1.0, 0.0, 5.0, 0.0), [ground()], 1.0)
    assert (flight.stop, flight.time, flight.state.s) == ("ground", 0.0, 1.0)


@pytest.mark.parametrize("landing", ["interpolated", "first_below"])
@pytest.mark.parametrize("stop", ["ground", "plate"])
def test_a_step_that_ends_on_a_surface_ends_the_flight(landing, stop):
    """The ground 4 m below under 8 m/s², or the plate 2 m ahead at 2 m/s: after 1 s."""
    events = [ground(), plate(3.0)] if stop == "ground" else [ground(-1.0), plate(2.0)]
    falls = verlet(0.25, landing=landing)
    arrival = falls.fly(law(gravity=8.0), PlaneState(0.0, 4.0, 2.0, 0.0), events, 60.0)
    assert (arrival.stop, arrival.time) == (stop, 1.0)
    assert arrival.state == (2.0, 0.0, 2.0, -8.0)


def test_the_first_point_below_is_a_step():
    engine = verlet(0.05, landing="first_below")
    arrival = fall(engine)
    count = round(arrival.time / engine.dt)
    assert arrival.time == count * engine.dt
    assert arrival.state == after_steps(engine, count)
    assert arrival.state.z <= 0.0 < after_steps(engine, count - 1).z


def test_of_two_stops_in_one_step_the_first_one_counts():
    """At 45° downwards from 1 m, wall and floor are 1 m away; the nearer one ends the flight."""
    down = PlaneState(0.0, 1.0, 10.0, -10.0)
    for way, expected in ((0.9, "plate"), (1.1, "ground")):
        stops = [ground(), plate(way)]
        assert verlet(0.5).fly(NOTHING, down, stops, 1.0).stop == expected


# ---- the contact ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def window():
    """Return when the plain pitch enters the bat, and when it would leave it, s."""
    meeting = approach_of(PLAIN, TRUTH)
    frame = Frame(*map(float, (getattr(meeting.pitch.frame, k) for k in ("x", "y", "cos", "sin"))))
    time, state = float(meeting.touch.time), PlaneState(*map(float, meeting.touch.state))
    bat = BatSection(frame, float(meeting.bat.height), PLAIN.ball.radius + PLAIN.bat.radius)
    # Straight within 4 ms to some 40 µm; from a step outside, for the root asks for one.
    outside = state._replace(s=state.s - 1e-6)
    return time, time + line_touch(outside, bat, "larger")


def aligned(window, share, count):
    """Return the step that puts step number `count` at a share of the window."""
    enters, leaves = window
    return (enters + share * (leaves - enters)) / count


@pytest.mark.parametrize("share", [0.02, 0.5, 0.98])
@pytest.mark.parametrize("count", [20, 37, 400])
def test_a_step_in_the_window_finds_the_bat(window, share, count):
    dt = aligned(window, share, count)
    result = solve(PLAIN, verlet(dt))
    # Within a step the pitch leaves its tangent by less than g Δt²/2, at 32 m/s and nearly level;
    # the chord under the plate and the scheme add as much.
    assert result.contact.time == pytest.approx(window[0], abs=2 * 9.8 * dt * dt / 32)
    assert result.outcome == "batted"


@pytest.mark.parametrize("share", [-0.05, 1.05])
@pytest.mark.parametrize("count", [10, 37])
def test_a_contact_between_two_steps_goes_unseen(window, share, count):
    result = solve(PLAIN, verlet(aligned(window, share, count)))
    assert result.outcome == "missed"
    assert result.contact.margin < 0
    assert solve(PLAIN, TRUTH).outcome == "batted"


def section(way, height, reach):
    return BatSection(Frame(way, 0.0, -1.0, 0.0), height, reach)


@given(st.floats(0.05, 2.0), st.floats(-0.9, 0.9), st.floats(5, 60))
def test_both_roots_touch_the_bat(distance, aside, speed):
    """A line that passes the axis at `aside` times the reach enters first and leaves later."""
    reach = 0.0696
    bat = section(distance + reach, 1.0, reach)
    angle = math.asin(aside * reach / (distance + reach))
    start = PlaneState(0.0, 1.0, speed * math.cos(angle), speed * math.sin(angle))
    first, larger = (line_touch(start, bat, root) for root in ("first", "larger"))
    assert 0 < first < larger
    for time, sign in ((first, -1), (larger, +1)):
        there = start._replace(s=start.u * time, z=1.0 + start.w * time)
        assert bat.distance(there, DOUBLES) == pytest.approx(reach, rel=1e-13)
        assert bat.approach(there) * sign > 0


def test_a_line_that_passes_the_bat_by_is_an_error_and_no_guess(window):
    """In a step of 0.05 s the pitch drops centimetres below its tangent, into a bat held low."""
    low = PLAIN.model_copy(update={"swing": Swing(height_offset=-0.064)})
    result = solve(low, verlet(aligned(window, 0.5, 11)))
    assert "Appendix B has no Δt'" in result.error
    assert result.contact.margin > 0


def test_the_larger_root_strikes_the_back_of_the_bat(window):
    """F̄ is the same for n and -n, so that the ball comes back all the same."""
    dt = aligned(window, 0.5, 20)
    first = solve(PLAIN, Verlet(dt))
    larger = solve(PLAIN, Verlet(dt, root="larger"))
    assert first.outcome == larger.outcome == "batted"
    assert larger.contact.time > first.contact.time
    assert first.contact.normal[0] > 0.9
    assert larger.contact.normal[0] < -0.9
    assert larger.impact.impulse < 0 < first.impact.impulse
    assert larger.impact.velocity[0] > 30


def test_between_the_ends_is_asked_at_the_step_in_the_bat():
    """A pitch that slides over the bat's end: between the ends at touching, beyond at the step."""
    slanted = PLAIN.model_copy(
        update={"pitch": Pitch(release=(4.0, -3.5, 1.8), aim=(0.53, 1.8), speed=30.0)}
    )
    reference = solve(slanted, TRUTH)
    assert reference.outcome == "batted"
    assert 0.45 < float(reference.contact.position[1].value) < 0.5
    found = solve(slanted, Verlet((float(reference.contact.time.value) + 0.003) / 30))
    assert found.outcome == "beyond_bat"


# In quarters of F̄ Δt: half of F̄ counts 1/4 at the start of the first step on and at the end of the
# last one, 1/2 at a step between two on. The step after the last one on ends the push.
STRENGTHS = {
    "whole": 1 / 4 + 1 / 2 + 1 / 4,  # constant for 2 Δt
    "carried": 1 / 4 + 1 / 2 + 1 / 2,  # at t, t + Δt and t + 2Δt
    "late": 1 / 2 + 1 / 2,  # at t + Δt and t + 2Δt
    "early": 1 / 4 + 1 / 2,  # at t and t + Δt
}


def carried_in_vacuum(on, steps, kick, dt):
    """Velocity and position after steps of Frenkel and Smit's loop with one acceleration array."""
    x = v = 0.0
    a = kick / (2 * dt) if 0 in on else 0.0
    for k in range(1, steps + 1):
        x += v * dt + a * dt * dt / 2
        new = kick / (2 * dt) if k in on else 0.0
        v += (a + new) / 2 * dt
        a = new
    return v, x


@pytest.mark.parametrize("contact_force", STRENGTHS)
@pytest.mark.parametrize("count", [7, 300])
def test_the_impulse_in_vacuum(contact_force, count):
    """The same at a coarse and at a fine step: a share of F̄ Δt that no step changes."""
    scene = PLAIN.model_copy(update={"air": None, "gravity": 0.0, "time_limit": 1.0})
    touching = (18.44 - 0.0696) / scene.pitch.speed
    engine = Verlet((touching + 1e-3) / count, contact_force=contact_force)
    meeting = approach_of(scene, engine)
    touch, dt = meeting.touch, engine.dt
    kick = (64.0, 0.0, 16.0)
    launch = engine.rebound(meeting.pitch.frame, touch, kick, lambda _: NOTHING, ground(0.0))
    changed = np.subtract(launch.velocity, (-scene.pitch.speed, 0.0, 0.0))
    assert changed == pytest.approx(STRENGTHS[contact_force] * np.array(kick), rel=1e-13)
    steps = round(launch.time / dt) - touch.step
    assert steps == {"whole": 2, "carried": 3, "late": 3, "early": 2}[contact_force]
    assert launch.delay == pytest.approx(steps * dt - touch.ahead, rel=1e-9)
    on = {"carried": {0, 1, 2}, "late": {1, 2}, "early": {0, 1}}.get(contact_force)
    before = meeting.pitch.frame.position(touch.before)
    for i, u in enumerate((-scene.pitch.speed, 0.0, 0.0)):
        # Half the force for two steps, which no array of accelerations has: r + 2 v Δt + (J/m) Δt.
        v, x = carried_in_vacuum(on, steps, kick[i], dt) if on else (kick[i], kick[i] * dt)
        assert changed[i] == pytest.approx(v, rel=1e-13)
        assert launch.position[i] == pytest.approx(before[i] + u * steps * dt + x, rel=1e-13)


def test_a_ball_that_is_down_before_the_bat_lets_go_has_landed(window):
    ground = Ground(height=1.05)
    low = PLAIN.model_copy(update={"ground": ground, "swing": Swing(height_offset=0.06)})
    dt = aligned(window, 0.5, 20)
    between = solve(low, Verlet(dt))
    below = solve(low, Verlet(dt, landing="first_below"))
    assert between.outcome == below.outcome == "batted"
    assert between.landing.position[2] == 1.05
    assert below.landing.position[2] < 1.05
    assert below.landing.time in (20 * dt, 21 * dt)
    assert below.landing.time - dt < between.landing.time < below.landing.time
    for landed in (between, below):
        assert landed.contact.time + landed.landing.hang_time == pytest.approx(landed.landing.time)


@every_treatment
@pytest.mark.sampled(every=3)
def test_the_whole_at_bat_converges_at_first_order(treatment, window):
    """At no more, whatever the treatment: the half-force over two steps is of first order."""
    reference = float(solve(PLAIN, TRUTH).landing.distance.value)
    coarse, fine = (
        # Half a step before the contact, so that the phase of the step is the same.
        solve(PLAIN, Verlet(aligned(window, 0.0, count - 0.5), treatment)).landing.distance
        - reference
        for count in (10_000, 80_000)
    )
    assert abs(fine) < 1e-3
    assert math.log(coarse / fine) / math.log(8) == pytest.approx(1, abs=0.1)


# ---- what is refused -----------------------------------------------------------------------------


@pytest.mark.parametrize("treatment", ["old_carried", "implicit"])
def test_a_step_too_long_for_the_forces_says_so(treatment):
    level = FlightScene(
        id="level",
        launch=Launch(position=(0.0, 0.0, 1.0), velocity=(30.0, 0.0, 0.0)),
        air=Air(drag_coefficient=1e6, lift_coefficient=0.0),
        gravity=0.0,
    )
    assert "too long for these forces" in solve(level, Verlet(0.5, treatment)).error


def test_a_ball_that_stays_up_is_airborne_and_one_on_the_ground_is_down():
    assert solve(flight(gravity=0.0, air=None), Verlet(0.05)).outcome == "airborne"
    resting = Launch(position=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    assert solve(FlightScene(id="resting", launch=resting), Verlet(0.05)).landing.time == 0.0


def test_a_flight_of_too_many_steps_is_given_up_before_the_first(monkeypatch):
    """Only the time limit is known beforehand, not whether the ball lands."""
    monkeypatch.setattr(Code, "count", lambda self, work=1: pytest.fail("a step was taken"))
    for scene, dt in ((flight(), 1e-12), (flight(gravity=0.0, time_limit=1e12), 0.05)):
        result = solve(scene, Verlet(dt))
        assert result.code == "too_long"
        assert f"more than 200,000,000 steps of {dt!r} s" in result.error
        assert f"a time_limit of {2e8 * dt:.3g} s or less" in result.error


def test_the_path_of_a_ball_that_stays_up_ends_with_its_last_step():
    scene = flight(gravity=0.0, air=None, time_limit=1.0)
    _, way = solve_with_path(scene, Verlet(0.3))
    assert way.end == pytest.approx(1.2)
    there = [x + 1.2 * v for x, v in zip(scene.launch.position, scene.launch.velocity, strict=True)]
    assert way.at(way.end)[0] == pytest.approx(there)


def test_a_ball_that_lands_after_the_time_limit_in_its_last_step_is_airborne():
    """It falls from 1 m at 1/1.1 m/s: in the step from 0.9 s to 1.2 s, after the limit of 1 s."""
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(2.0, 0.0, -1 / 1.1))
    scene = FlightScene(id="late", air=None, gravity=0.0, time_limit=1.0, launch=launch)
    result, way = solve_with_path(scene, Verlet(0.3))
    assert result.outcome == "airborne"
    assert way.end == pytest.approx(0.9)
    assert way.at(way.end)[0] == pytest.approx((1.8, 0.0, 1 - 0.9 / 1.1))
    longer = scene.model_copy(update={"time_limit": 1.15})
    assert solve(longer, Verlet(0.3)).outcome == "landed"


@pytest.mark.parametrize("option", ["forces", "landing", "root", "contact_force"])
def test_an_option_that_is_none_is_refused(option):
    with pytest.raises(ValueError, match=f"{option} 'odd' is not one of"):
        create("verlet", **{option: "odd"})


# --- the extended model ---------------------------------------------------------------------------


def test_the_apex_lies_between_two_steps():
    """In a vacuum a step between two is off by g Δt²/8 at most."""
    scene, dt = flight(air=None), 2.0**-10
    found = solve(scene, Verlet(dt)).apex
    time = 22.0 / G
    assert found.time == pytest.approx(time, abs=G * dt**2)
    at = (32.0 * time, 0.0, 1.0 + 22.0**2 / (2 * G))
    assert found.position == pytest.approx(at, abs=16 * G * dt**2)


def test_steps_that_push_the_ball_take_the_drag_of_its_speed():
    """By a table that is 0.4 wherever the ball is, as by that number."""
    table = {"law": "table", "of": "speed", "at": (1.0, 2.0), "values": (9.0, 0.4)}
    number, tabled = (
        solve(
            AtBatScene(swing=Swing(height_offset=-0.03), air={"drag_coefficient": drag}),
            Verlet(1e-4),
        ).landing
        for drag in (0.4, table)
    )
    # Roundings: 0.4 is the end of a line.
    assert tabled.position == pytest.approx(number.position, abs=1e-9)


@pytest.mark.parametrize("drag", [0.35, TABLE], ids=["one form", "table"])
def test_steps_that_end_below_the_ground_of_a_logarithmic_wind(drag):
    """There the profile has no value. The flight before it converges to the true one."""
    wind = {"velocity": (4.0, -3.0, 0.0), "height": 10.0, "roughness": 0.01}
    launch = {"position": (0.5, 0.1, 1.0), "velocity": (40.0, 3.0, 20.0), "spin": (20, -250, 60)}
    scene = FlightScene(launch=launch, air={"drag_coefficient": drag, "wind": wind})
    truth = solve(scene, Ivp()).landing
    for dt, error in ((0.05, 5e-2), (2e-3, 5e-4)):
        found = solve(scene, Verlet(dt, forces="predicted_recomputed")).landing
        assert found.position == pytest.approx(truth.position, abs=error)
        assert found.velocity == pytest.approx(truth.velocity, abs=error)


@pytest.mark.parametrize("offset", [1.0, -1.0])
def test_the_margin_of_a_pitch_that_lands_beside_the_bat(offset):
    """It falls by 1 in 4 towards the ground, 4 cm behind the plate; the step there is too late."""
    dt, pitch = 1e-3, Pitch(release=(20.0, 0.0, 5.01), aim=(0.0, 0.01), speed=30.0)
    swing = Swing(height_offset=offset)
    scene = AtBatScene(id="low", air=None, gravity=0.0, pitch=pitch, swing=swing)
    way = 30.0 * dt * np.arange(800) / math.hypot(4.0, 1.0)
    x, z = 20.0 - 4.0 * way, 5.01 - way
    distance = np.hypot(x, z - (0.01 + offset))[z > 0].min()
    found = solve(scene, Verlet(dt))
    assert found.outcome == "missed"
    assert found.contact.margin == pytest.approx(0.0696 - distance, abs=1e-12)
