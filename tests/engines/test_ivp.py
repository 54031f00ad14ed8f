"""The reference engine against closed forms, other methods, and the traps of event finding."""

import math
from contextlib import contextmanager

import numpy as np
import pytest
import scipy.integrate

from longball.engines import event
from longball.engines.chain import solve
from longball.engines.engine import OutOfRange, TooLong
from longball.engines.ivp import METHODS, Ivp
from longball.engines.taylor import Taylor
from longball.model.frame import Frame
from longball.model.law import (
    PlaneState,
    law_with,
)
from longball.model.numbers import DOUBLES
from longball.model.scene import parse_scene
from tests import exact
from tests.calls import check_wrong_calls

ENGINE = Ivp()
ALONG_X = Frame(0.0, 0.0, 1.0, 0.0)

# What the engine promises on regular scenes: a few roundings of 100 m and 10 s.
LENGTH, TIME = 1e-13, 5e-15  # m, s


def law(drag=0.0, lift=0.0, gravity=9.8):
    strengths = {"drag": drag, "lift": lift, "gravity": gravity}
    return law_with({name: k for name, k in strengths.items() if k})


WITH_DRAG, USUAL = law(0.0075), law(0.0075, 0.00375)
LOOPS = law(0.0, 0.0381, 0.0126)  # at 160 m/s a loop takes 1 s


def ground(height=0.0):
    return event.ground(height, PlaneState(0.0, 1.0, 0.0, 0.0), DOUBLES)


def plate(distance):
    """The plate of a pitch that is released so many metres in front of it."""
    return event.plate(Frame(distance, 0.0, -1.0, 0.0), PlaneState(0.0, 1.0, 0.0, 0.0), DOUBLES)


def fly(start, law, *events, engine=ENGINE, limit=60.0):
    return engine.fly(law, PlaneState(*start), events, limit)


# ---- accuracy ------------------------------------------------------------------------------------


BATTED = (0.0, 1.0, 35.0, 30.0)


@pytest.mark.parametrize(
    ("method", "rtol"),
    [
        (method, rtol)
        for method in METHODS
        for rtol in (1e-4, 1e-7, 1e-10)
        if (method, rtol) != ("RK23", 1e-10) and method != "Taylor"  # 60,000 steps of third order
    ],
)
def test_every_method_is_as_accurate_as_its_tolerance(method, rtol):
    """A batted ball of 6 s and 110 m, relative to those, held to Taylor's method; also on the way.

    A one-step method's few steps stay within one tolerance together; the many of a multistep
    method add up, to 15 with BDF.
    """
    landing = fly(BATTED, USUAL, ground(), engine=Ivp(method, rtol, rtol))
    truth = fly(BATTED, USUAL, ground())
    tolerance = (20 if method in ("BDF", "LSODA") else 1) * rtol
    assert landing.state.s == pytest.approx(truth.state.s, rel=tolerance)
    assert landing.time == pytest.approx(truth.time, rel=tolerance)
    for time in np.linspace(0, 6, 50).tolist():
        assert landing.path.at(time) == pytest.approx(truth.path.at(time), abs=110 * tolerance)


# ---- the singular point: V = 0 -------------------------------------------------------------------


@pytest.mark.parametrize("air", [law(0.0075, 0.0, 0.0), law(0.0075, 0.00375, 0.0), law(0, 0, 0)])
def test_at_rest_with_nothing_to_move_it(air):
    end = fly((1.0, 2.0, 0.0, 0.0), air, ground(), limit=5.0)
    assert (end.stop, end.time, end.state) == ("time", 5.0, (1.0, 2.0, 0.0, 0.0))


def test_through_a_cusp():
    """Without drag a flight from rest, reversed, comes to rest at a cusp of its path, and goes on.

    Reversed, lift turns the other way.
    """
    top = 2.0
    falling = fly((0.0, 50.0, 0.0, 0.0), law(0.0, 0.02), limit=top)
    back = PlaneState(*(falling.state.s, falling.state.z, -falling.state.u, -falling.state.w))
    rising = fly(back, law(0.0, -0.02), limit=2 * top)
    at_rest = rising.path.at(top)
    assert math.hypot(at_rest.u, at_rest.w) < 1e-12
    assert at_rest.z == pytest.approx(50.0, abs=LENGTH)
    assert rising.state.z == pytest.approx(falling.state.z, abs=1e-11)


# ---- events --------------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", ["ground", "plate"])
def test_a_root_exactly_at_the_end_of_a_step(surface):
    """A flight stopped on the very height, or distance, that one of its steps ends on."""
    pieces = list(fly(BATTED, WITH_DRAG, limit=6.0).path.pieces())
    piece = pieces[-1]
    state = piece.at(0.0)
    assert state.w < 0
    met = ground(state.z) if surface == "ground" else plate(state.s)
    arrival = fly(BATTED, WITH_DRAG, met)
    assert arrival.stop == surface
    assert arrival.time == pytest.approx(piece.begin, abs=TIME)
    assert arrival.state == pytest.approx(state, abs=LENGTH)


# ---- stiff, and beyond ---------------------------------------------------------------------------


def test_an_integration_goes_on_after_many_steps(monkeypatch):
    """It pauses, to see whether the ball has settled, and goes on where the last step ended."""
    whole = list(fly((0.0, 50.0, 160.0, 0.0), LOOPS, limit=10.0).path.pieces())
    monkeypatch.setattr("longball.engines.ivp._MANY_STEPS", 6)
    with given_to_solve_ivp(monkeypatch) as calls:
        parts = list(fly((0.0, 50.0, 160.0, 0.0), LOOPS, limit=10.0).path.pieces())
    assert len(calls) > 3
    assert [piece.begin for piece in parts[1:]] == [p.begin + p.length for p in parts[:-1]]
    assert parts[-1].at(parts[-1].length) == pytest.approx(whole[-1].at(whole[-1].length), abs=1e-9)


# ---- what solve_ivp is given ---------------------------------------------------------------------


@contextmanager
def given_to_solve_ivp(monkeypatch):
    """The calls of solve_ivp: each with what it was given, and what it returned."""
    solve_ivp, calls = scipy.integrate.solve_ivp, []

    def spy(*given, **options):
        calls.append((given, options, solve_ivp(*given, **options)))
        return calls[-1][-1]

    with monkeypatch.context() as patch:
        patch.setattr(scipy.integrate, "solve_ivp", spy)
        yield calls


AT_BAT = '{"id": "hit", "kind": "at-bat", "swing": {"height_offset": %r}}'


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.sampled(every=2)
def test_solve_ivp_is_given_the_law_and_terminal_events(monkeypatch, method):
    """A pitch to the plate, the same to the bat, a batted ball."""
    with given_to_solve_ivp(monkeypatch) as calls:
        assert solve(parse_scene(AT_BAT % 0.01), Ivp(method)).outcome == "batted"
    seen = {}
    for (rates, (begin, _), state), options, solution in calls:
        assert rates(begin, state)[:2] == tuple(state[2:])  # ds/dt = u, dz/dt = w
        assert options["method"] in (Taylor, method)
        *events, _ = options["events"]  # the last one counts steps
        assert all((event.terminal, event.direction) == (True, -1) for event in events)
        names = tuple(event.__name__ for event in events)
        times = zip(names, solution.t_events, strict=False)
        seen.setdefault(names, set()).update(name for name, found in times if found.size)
    pitch, meeting, batted = seen
    assert pitch == ("plate", "ground")
    assert "plate" in seen[pitch]
    assert meeting == ("closest approach", "contact", "ground")
    assert seen[meeting] & {"contact", "closest approach"}
    assert batted == ("ground",)
    assert seen[batted] == {"ground"}


@pytest.mark.parametrize("offset", [0.0695, 0.04, -0.04, -0.0695])
def test_a_contact_within_one_step_is_not_missed(monkeypatch, offset):
    """Before and after the step the ball is far from the bat: only the guard changes its sign."""
    with given_to_solve_ivp(monkeypatch) as calls:
        result = solve(parse_scene(AT_BAT % offset), ENGINE)
    assert result.contact is not None
    _, options, solution = calls[1]
    times = dict(zip([e.__name__ for e in options["events"]], solution.t_events, strict=True))
    assert times["contact"].size == 0
    assert times["closest approach"].size == 1
    assert result.contact.time < times["closest approach"][0]


def test_a_flight_may_take_as_many_steps_as_are_granted(monkeypatch):
    def steps():
        return len(list(fly((0.0, 1.0, 30.0, 20.0), USUAL, limit=5.0).path.pieces()))

    taken = steps()
    monkeypatch.setattr("longball.engines.ivp._MOST_STEPS", taken)
    assert steps() == taken
    monkeypatch.setattr("longball.engines.ivp._MOST_STEPS", taken - 1)
    with pytest.raises(TooLong):
        steps()


@pytest.mark.parametrize("drag", [1.0, 100.0, 1e4, 1e6])
def test_a_feather_light_ball(drag):
    """It settles to √(g/k) within 1/√(g k), and explicit steps are not much longer."""
    height = min(1.0, 10 / math.sqrt(drag))
    time, state = exact.fall_to_floor(PlaneState(0.0, height, 0.0, 0.0), drag, 9.8, 0.0, math)
    landing = fly((0.0, height, 0.0, 0.0), law(drag), ground())
    assert landing.time == pytest.approx(time, rel=ENGINE.flight_error)
    assert landing.state.w == pytest.approx(state.w, rel=ENGINE.flight_error)


@pytest.mark.parametrize("method", ["Taylor", "DOP853"])
def test_forces_without_measure_are_an_error(method):
    with pytest.raises(OutOfRange):
        fly((0.0, 1.0, 1e200, 0.0), law(1e200), ground(), engine=Ivp(method))


WRONG = """
Ivp("RK4") -> method 'RK4' is not one of Taylor, RK23
Ivp("DOP853", rtol=1e-15) -> rtol = 1e-15 is not between 2.22e-14 and 1
Ivp("DOP853", rtol=1.0) -> rtol
Ivp("DOP853", rtol=math.nan) -> rtol
Ivp("DOP853", atol=0.0) -> atol
Ivp(rtol=1e-9) -> Taylor takes no rtol
"""


def test_settings_that_cannot_be_kept_are_refused():
    check_wrong_calls(WRONG, globals())
