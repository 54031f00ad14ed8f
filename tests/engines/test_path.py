"""A flight that one can ask: the same states as of a flight that ends there, at any time."""

import math
from itertools import pairwise

import numpy as np
import pytest

from longball.engines.batch import Batch
from longball.engines.chain import solve_with_path, solve_with_points
from longball.engines.enclosure import Enclosure
from longball.engines.event import ground, vertical
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.path import Flight, Path
from longball.engines.polynomial import PolynomialPiece
from longball.engines.verlet import Verlet
from longball.model.law import PlaneState, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import parse_scene

IVP, ENCLOSURE = Ivp(), Enclosure(30)
ENGINES = pytest.mark.parametrize("engine", [IVP, ENCLOSURE], ids=["ivp", "enclosure"])

STRENGTHS = {"drag": 0.0075, "lift": 0.00375, "gravity": 9.8}
# A batted ball; loops of strong lift; straight up and down; from rest.
FLIGHTS = {
    "batted": (STRENGTHS, (0.0, 1.0, 35.0, 30.0)),
    "loops": ({"drag": 0.002, "lift": 0.04, "gravity": 9.8}, (0.0, 60.0, 40.0, 5.0)),
    "straight": ({"drag": 0.0075, "gravity": 9.8}, (0.0, 1.0, 0.0, 25.0)),
    "at rest": (STRENGTHS, (0.0, 100.0, 0.0, 0.0)),
    "still": ({}, (3.0, 4.0, 0.0, 0.0)),
}
LIMIT = 4.0
# Some ulps of 100 m and 60 m/s: a flight that ends elsewhere has other steps.
ULPS = 4 * math.ulp(100.0)


def prepared(name, engine):
    """The law and the launch of a flight, and its landing as an event, in an engine's numbers."""
    strengths, start = FLIGHTS[name]
    number = engine.numbers.exact
    with engine.numbers.arithmetic():
        law = law_with({key: number(k) for key, k in strengths.items()})
        state = PlaneState(*map(number, start))
        return law, state, ground(number(0.0), state, engine.numbers)


def flown(name, engine, limit=LIMIT):
    law, start, landing = prepared(name, engine)
    with engine.numbers.arithmetic():
        return engine.fly(law, start, [landing], engine.numbers.exact(limit))


def assert_same(found, wanted, tolerance=ULPS):
    """To a few ulps; for balls, that they overlap."""
    for a, b in zip(found, wanted, strict=True):
        if isinstance(a, float):
            assert abs(a - b) <= tolerance
        else:
            assert a.overlaps(b)
            assert a.rad() < 1e-24


TIMES = [0.0, 1e-9, 0.1, 1.0, math.pi / 2, 3.999, LIMIT]


@ENGINES
@pytest.mark.parametrize("name", FLIGHTS)
@pytest.mark.sampled(every=3)
def test_a_path_has_the_states_of_flights_that_end_there(name, engine):
    path, other = flown(name, engine).path, flown(name, engine).path
    number = engine.numbers.exact
    with engine.numbers.arithmetic():
        backwards = {time: other.at(number(time)) for time in reversed(TIMES)}
        for time in TIMES:
            # It does not matter what was asked before.
            assert str([*path.at(number(time))]) == str([*backwards[time]])
            if time == 0.0:
                assert_same(path.at(number(0.0)), prepared(name, engine)[1], 0.0)
                continue
            ended = flown(name, engine, time)
            assert ended.stop == "time"
            assert float(ended.time) == time
            assert_same(path.at(number(time)), ended.state)
        # A piece begins when the one before ends, in the state in which that ends.
        pieces = list(path.pieces())
        assert list(path.pieces()) == pieces
        assert float(pieces[0].begin) == 0.0
        assert float(pieces[-1].begin + pieces[-1].length) == pytest.approx(LIMIT, rel=1e-15)
        for one, following in pairwise(pieces):
            assert_same([one.begin + one.length], [following.begin], math.ulp(LIMIT))
            # The length of a piece is rounded up, so that it reaches the next.
            assert_same(one.at(one.length), following.at(number(0.0)))


@ENGINES
def test_a_path_goes_on_beyond_the_event_that_ended_the_flight(engine):
    """Below the ground, as if that were not there."""
    law, start, landing = prepared("batted", engine)
    number = engine.numbers.exact
    with engine.numbers.arithmetic():
        landed = engine.fly(law, start, [landing], number(20.0))
        assert landed.stop == "ground"
        assert 0 < float(landed.time) < 10
        assert_same(landed.path.at(landed.time)._replace(z=landed.state.z), landed.state)
        free = engine.fly(law, start, [], number(20.0))
        for time in (float(landed.time) + 1e-9, 8.0, 19.9, 20.0):
            below = landed.path.at(number(time))
            assert below.z < 0
            assert_same(below, free.path.at(number(time)), 4 * ULPS)  # 500 m below


@ENGINES
@pytest.mark.parametrize("time", [-1e-300, -1.0, math.nextafter(LIMIT, 5), 60.0])
def test_a_time_outside_the_flight_is_an_error(engine, time):
    path = flown("batted", engine).path
    with engine.numbers.arithmetic(), pytest.raises(ValueError, match="the flight has no state"):
        path.at(engine.numbers.exact(time))


def straight(begin, length, z=0.0, w=0.0):
    """A piece in a straight line upwards."""
    return PolynomialPiece(begin, length, PlaneState, np.array([[0, 0], [z, w], [0, 0], [w, 0]]))


@pytest.mark.parametrize("rising", [1e-12, 1e-3, 2.0])
@pytest.mark.parametrize("falling", [-1e-12, -1e-3, -2.0])
def test_a_top_where_two_pieces_join(rising, falling):
    pieces = [straight(0.0, 1.0, 5.0, rising), straight(1.0, 1.0, 5.0 + rising, falling)]
    flight = Flight(Path(pieces), "time", 2.0, pieces[1].at(1.0))
    time, state = flight.highest(DOUBLES)
    assert (time, state.z) == (1.0, 5.0 + rising)


def test_a_ball_that_rises_ever_more_slowly_has_no_top():
    rows = np.array([[0.0] * 3, [5.0, 3.0, -1.25], [0.0] * 3, [3.0, -2.5, 0.0]])
    piece = PolynomialPiece(0.0, 1.0, PlaneState, rows)
    assert Flight(Path([piece]), "time", 1.0, piece.at(1.0)).highest(DOUBLES) is None


# --- one flight after another ---------------------------------------------------------------------


@ENGINES
def test_a_flight_that_goes_on_as_another(engine):
    """Up to the vertical with lift, and from there without."""
    number = engine.numbers.exact
    law, start, landing = prepared("loops", engine)
    with engine.numbers.arithmetic():
        turns = vertical(start, engine.numbers)
        ahead = engine.fly(law, start, [landing, turns], number(60.0))
        assert ahead.stopped("vertical")
        assert not ahead.stopped("ground")
        upright = turns.place(ahead.state)
        behind = engine.fly(law.without("lift"), upright, [landing], number(60.0))
        whole = ahead.then(behind)
        assert (whole.stop, whole.state) == (behind.stop, behind.state)
        assert_same([whole.time], [ahead.time + behind.time], 0.0)
        for part in (0.0, 0.3, 0.999):
            before = number(part) * ahead.time
            assert_same(whole.path.at(before), ahead.path.at(before), 0.0)
            after = number(part) * behind.time
            assert_same(whole.path.at(ahead.time + after), behind.path.at(after))
        at_the_end = whole.path.at(whole.time)
        assert_same(at_the_end._replace(z=whole.state.z), whole.state)
        begins = [float(piece.begin) for piece in whole.path.pieces()]
        assert begins == sorted(begins)
        for one, following in pairwise(whole.path.pieces()):
            assert_same([one.begin + one.length], [following.begin], math.ulp(20.0))
            assert not one.begin + one.length < following.begin


def test_the_pieces_of_a_flight_that_goes_on_reach_each_other():
    """However their times are rounded."""
    rng = np.random.default_rng(5)
    ends = [0.0, *np.cumsum(rng.uniform(0.01, 0.5, 20)).tolist()]
    second = [straight(a, math.nextafter(b - a, 1), w=1.0) for a, b in pairwise(ends)]
    end = second[-1].at(0.0)
    for time in rng.uniform(0.1, 9.0, 50).tolist():
        first = Flight(Path([straight(0.0, 9.0)]), "time", time, end)
        whole = first.then(Flight(Path(second), "time", ends[-1], end))
        for one, following in pairwise(whole.path.pieces()):
            assert not one.begin + one.length < following.begin
            assert one.begin + one.length == pytest.approx(following.begin, abs=1e-14)


# --- scenes ---------------------------------------------------------------------------------------

AT_BAT = '{"id":"x","kind":"at-bat","swing":{"height_offset":-0.03,"tilt":0.1}}'


def float_of(values):
    return [float(x) for x in values]


@ENGINES
def test_the_trajectory_of_an_at_bat_has_its_results(engine):
    number = engine.numbers.exact
    with engine.numbers.arithmetic():
        result, way = solve_with_path(parse_scene(AT_BAT), engine)
        (pitch, batted), end = way.legs, way.end
        assert float(end) == float(result.landing.time)
        at = {"landing": end, "contact": batted.begin}
        for block, time in at.items():
            position, velocity = way.at(time)
            wanted = getattr(result, block)
            assert float_of(position) == pytest.approx(float_of(wanted.position), abs=1e-13)
            after = result.impact.velocity if block == "contact" else wanted.velocity
            assert float_of(velocity) == pytest.approx(float_of(after), abs=1e-13)
        # Before the contact the ball is on the pitch, whose own path goes on to the plate.
        before = batted.begin - number(1e-6)
        assert way.at(before)[1][0] < 0 < way.at(batted.begin)[1][0]
        crossing = pitch.flight.path.at(pitch.flight.time)
        found = float_of(pitch.frame.position(crossing))
        assert found == pytest.approx(float_of(result.plate.position), abs=1e-13)
        for time in (number(-1e-9), end + 60):
            with pytest.raises(ValueError, match="has no state at t"):
                way.at(time)


def test_a_trajectory_has_a_state_at_its_end():
    """The end is the time of the contact and the time of the flight, rounded."""
    rng = np.random.default_rng(4)
    scene = parse_scene(AT_BAT)
    for limit in rng.uniform(0.7, 1.5, 50).tolist():
        result, way = solve_with_path(scene.model_copy(update={"time_limit": limit}), IVP)
        assert result.outcome == "airborne"
        flight = way.legs[-1].flight
        wanted = way.legs[-1].frame.position(flight.state)
        assert way.at(way.end)[0] == pytest.approx(wanted, abs=1e-13)  # 60 m/s over an ulp


@pytest.mark.parametrize(
    ("engine", "error"),
    [
        (Ivp("DOP853"), 1e-11),  # its tolerance, 5e-14 a step, over 100 m
        (Multiprecision(20), ULPS),
        (Verlet(1e-4, "implicit"), 1e-5),  # Δt² times some hundred m/s²
    ],
    ids=["dop853", "multiprecision", "verlet"],
)
def test_every_engine_has_the_path(engine, error):
    """The state at any time, as the reference engine has it."""
    path, wanted = flown("batted", engine).path, flown("batted", IVP).path
    for t in (0.0, 0.123, 1.0, 2.75):
        found = map(float, path.at(engine.numbers.exact(t)))
        assert_same(found, wanted.at(t), error)


NO_DRAG = '"air": {"drag_coefficient": 0.0, "lift_coefficient": 4.0},'


@pytest.mark.parametrize("engine", [Ivp(), Batch()])
def test_a_ball_that_loops_for_ever_has_a_path(engine):
    launch = '{"position": [0, 0, 5], "velocity": [40, 0, 10]}'
    scene = parse_scene(f'{{"kind": "flight", {NO_DRAG} "launch": {launch}}}')
    result = solve_with_points(scene, engine, 5)
    assert result.outcome == "airborne"
    assert [row[0] for row in result.path] == [0.0, 15.0, 30.0, 45.0, 60.0]
    for _, _, _, z, u, _, w in result.path:
        assert 9.8 * z + (u * u + w * w) / 2 == pytest.approx(899.0, rel=1e-10)


@pytest.mark.parametrize("engine", [Ivp(), Batch()])
def test_a_ball_that_is_down_at_its_launch_has_a_path(engine):
    launch = '{"position": [0, 0, 0], "velocity": [5, 0, -5]}'
    result = solve_with_points(parse_scene(f'{{"kind": "flight", "launch": {launch}}}'), engine, 3)
    assert result.path == ((0.0, 0.0, 0.0, 0.0, 5.0, 0.0, -5.0),) * 3
