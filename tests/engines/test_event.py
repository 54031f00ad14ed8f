"""The one search for events: none missed, none invented, on any surface.

A flight that touches a surface and turns back dips below it for a moment, or stays as little short
of it. Here are such flights, from 1e-3 to 1e-13 beyond each surface and as far short of it, with a
turning point that is known exactly, by a closed form. Double precision finds the
event, or not, or says that it cannot tell; the enclosure tells them all. Flights through the air
under all forces, and pitches that graze the bat, are in the golden data (`hard`).
"""

import json
import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from flint import arb, ctx

from analysis.random_scenes import random_scene
from longball.engines import create, event
from longball.engines.chain import solve, solve_once
from longball.engines.enclosure import Enclosure
from longball.engines.fence import at_stop
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.polynomial import Dual, PolynomialPiece
from longball.model.frame import Frame
from longball.model.law import PlaneState, law_with
from longball.model.numbers import DOUBLES, Undecided
from longball.model.scene import parse_scene

IVP, ENCLOSURE = Ivp(), Enclosure(30)
ENGINES = pytest.mark.parametrize("engine", [IVP, ENCLOSURE], ids=["ivp", "enclosure"])
DIGITS = 37


def sway(motion, p):
    """Pushed sideways by its own climbing, so that u is a parabola in time."""
    return -p.sway * motion.velocity[2], 0, 0


@dataclass(frozen=True)
class Case:
    """A flight in numbers of a scene, an event, and how far beyond that it goes (exactly)."""

    strengths: dict
    start: tuple
    surface: str
    at: tuple
    limit: float
    depth: arb | None = None


def fly(case, engine, *more):
    """Fly a case to its event, or to another one, of a surface and a place."""
    number = engine.numbers.exact
    with engine.numbers.arithmetic():
        strengths = {name: number(k) for name, k in case.strengths.items()}
        law = law_with(strengths, (sway,) if "sway" in strengths else ())
        start = PlaneState(*map(number, case.start))
        surfaces = [(case.surface, case.at), *more]
        events = [make(*surface, start, engine.numbers) for surface in surfaces]
        return engine.fly(law, start, events, number(case.limit))


def make(surface, at, start, numbers):
    """Return an event by its name and its place."""
    match surface:
        case "ground":
            return event.ground(numbers.exact(at[0]), start, numbers)
        case "plate":
            return event.plate(frame_of(at, numbers), start, numbers)
        case "vertical":
            return event.vertical(start, numbers)
        case "fence":
            return at_stop("fence", numbers.exact(at[0]), 1, numbers)
        case "past":
            return event.past(frame_of(at, numbers), numbers.exact(at[2]), numbers)


def frame_of(at, numbers):
    """Return a frame from x and cos; that y and sin do not matter to any surface."""
    x, cos = map(numbers.exact, at[:2])
    return Frame(x, numbers.exact(0.0), cos, numbers.exact(0.0))


# --- flights that turn ----------------------------------------------------------------------------


def on_a_circle(rng, surface):
    """Without weight: a circle of radius 1/k_L, whatever the drag.

    Return strengths, launch, the lowest or the farthest place, and when it is there.
    """
    drag, lift = rng.choice([0.0, rng.uniform(0.001, 0.01)]), rng.uniform(0.02, 0.1)
    v, angle, height = rng.uniform(25, 60), rng.uniform(-1.4, 1.4), rng.uniform(10, 60)
    start = (0.0, height, v * math.cos(angle), v * math.sin(angle))
    _, z, u, w = map(arb, start)
    speed, radius = (u * u + w * w).sqrt(), 1 / arb(lift)
    if surface == "ground":
        turned, place = -angle % (2 * math.pi), z + radius * u / speed - radius
    else:
        turned, place = math.pi / 2 - angle, radius - radius * w / speed
    way = turned / lift
    time = (math.expm1(drag * way) / drag if drag else way) / math.hypot(*start[2:])
    return {"lift": lift} | ({"drag": drag} if drag else {}), start, place, time


def turning(rng, surface):
    """Maker of a flight that goes beyond a surface by a depth, or stays short of it."""
    if surface == "vertical":
        # u = u₀ - c (w₀ t - g t²/2) is least at the top, exactly.
        gravity, push, w = rng.uniform(2, 9.8), rng.uniform(0.1, 1), rng.uniform(5, 40)
        change, time = arb(push) * arb(w) * arb(w) / (2 * arb(gravity)), w / gravity
        strengths, cos = {"gravity": gravity, "sway": push}, 0.0
    else:
        strengths, start, place, time = on_a_circle(rng, surface)
        cos = -math.cos(rng.uniform(-0.5, 0.5))
    reach = 0.0696 if surface == "past" else 0.0
    if surface == "ground" and rng.random() < 0.5:
        # The same fall onto a surface at a height of about 0.
        lower = float(arb(start[1]) - place)
        place, start = place + arb(lower) - arb(start[1]), (start[0], lower, *start[2:])

    def case(depth):
        match surface:
            case "ground":
                at = (float(place + arb(depth)),)
                launch, beyond = start, arb(at[0]) - place
            case "fence":
                at = (float(place - arb(depth)),)
                launch, beyond = start, place - arb(at[0])
            case "vertical":
                at, launch = (), (0.0, 1.0, float(change - arb(depth)), w)
                beyond = change - arb(launch[2])
            case _:
                at = (float(-arb(cos) * place - arb(depth) - arb(reach)), cos, reach)
                launch, beyond = start, -(arb(at[0]) + arb(cos) * place + arb(reach))
        return Case(strengths, launch, surface, at, 1.001 * time + 0.01, beyond)

    return case


# --- dips beyond each surface ---------------------------------------------------------------------

SURFACES = ("ground", "fence", "plate", "vertical", "past")


def dips(surface, flights, depths):
    """Yield flights that go beyond a surface by 1e-3 … 1e-13, and that stay as far short of it."""
    rng = np.random.default_rng([600, *surface.encode()])
    for _ in range(flights):
        with ctx.workdps(DIGITS):
            placed = turning(rng, surface)
            cases = [
                placed(sign * depth)
                for sign in (1, -1)
                for depth in np.geomspace(1e-3, 1e-13, depths).tolist()
            ]
        yield from cases


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.sampled(every=2)
def test_no_dip_is_missed_and_none_invented(surface, nightly):
    decided = total = 0
    for case in dips(surface, flights=30 if nightly else 12, depths=10):
        total += 1
        try:
            flight = fly(case, IVP)
        except Undecided:
            assert abs(case.depth) < 1e-11, case
            continue
        decided += 1
        assert flight.stop == (surface if case.depth > 0 else "time"), case
    assert total == (600 if nightly else 240)
    assert decided > 0.75 * total


@pytest.mark.parametrize("engine", [ENCLOSURE, Multiprecision(30)], ids=["proofs", "digits"])
@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.sampled(every=3)
def test_engines_of_many_digits_tell_them_all(surface, engine, nightly):
    for case in dips(surface, flights=5 if nightly else 1, depths=4):
        flight = fly(case, engine)
        assert flight.stop == (surface if case.depth > 0 else "time"), case


# --- where pieces join ----------------------------------------------------------------------------


def falling_and_rising(depth, cuts):
    """The parabola ``(t - 1)² - depth`` of a height, in pieces that are cut at some times."""
    ends = [0.0, *sorted(cuts), 2.0]
    for begin, end in pairwise(ends):
        z = [(begin - 1) ** 2 - depth, 2 * (begin - 1), 1.0]
        w = [2 * (begin - 1), 2.0, 0.0]
        rows = np.array([[0.0] * 3, z, [0.0] * 3, w])
        yield PolynomialPiece(begin, end - begin, PlaneState, rows)


@pytest.mark.parametrize("cuts", [[], [0.4], [0.4, 0.5]])
def test_what_is_met_after_the_limit_is_not_met(cuts):
    """The height falls through zero at 0.9 s, on the piece on which the limit lies."""
    floor = make("ground", (0.0,), PlaneState(0.0, 1.0, 0.0, 0.0), DOUBLES)
    for limit, wanted in [(0.45, None), (0.8, None), (0.95, 0.9), (2.0, 0.9)]:
        met = event.first_met(falling_and_rising(0.01, cuts), [floor], limit, 1e-14, DOUBLES)
        assert (met and met.time) == (wanted and pytest.approx(wanted, abs=1e-14))
    with pytest.raises(Undecided, match="in the time limit"):
        event.first_met(falling_and_rising(0.01, cuts), [floor], 0.9, 1e-14, DOUBLES)


@pytest.mark.parametrize("near", [0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-3])
def test_no_dip_is_lost_where_pieces_join(near):
    """Cut at the turning point, close to it, and where the value falls through zero."""
    rng = np.random.default_rng(2)
    floor = make("ground", (0.0,), PlaneState(0.0, 1.0, 0.0, 0.0), DOUBLES)
    for depth in np.geomspace(1e-3, 1e-17, 29):
        for sign in (1, -1):
            for middle in (1.0, 1.0 - math.sqrt(depth), 1.0 + math.sqrt(depth)):
                cuts = (middle + near * rng.uniform(-1, 1, rng.integers(1, 4))).tolist()
                pieces = falling_and_rising(sign * depth, cuts)
                try:
                    met = event.first_met(pieces, [floor], 2.0, 1e-14, DOUBLES)
                except Undecided:
                    assert depth < 2e-14
                    continue
                assert (met is not None) == (sign > 0), (depth, cuts)
                if met is not None:
                    off = 1e-14 / math.sqrt(depth)  # the error of the height, over the speed
                    assert met.time == pytest.approx(1 - math.sqrt(depth), abs=off)


@pytest.mark.parametrize(
    ("height", "options", "wanted"),
    [
        # from a launch, whose value is exact
        ([0.0, -1.0, 0.0], {"launch": True}, 0.0),
        ([0.0, 1.0, 0.0], {"launch": True}, None),
        ([0.0, 1.0, -1.0], {"launch": True}, 1.0),
        ([0.0, 0.0, 0.0], {"launch": True}, 0.0),
        ([0.0, 0.0, 0.0], {"launch": True, "stays": False}, None),
        ([0.0, -1.0, 0.0], {"launch": True, "stays": False}, 0.0),
        ([0.5, -1.0, 0.0], {"launch": True}, 0.5),
        ([1e-15, -1.0, 0.0], {"launch": True}, 1e-15),
        ([1e-15, 1.0, 0.0], {"launch": True}, None),
        # later, where a value is known to the error
        ([1e-15, -1.0, 0.0], {}, 1e-15),
        ([1e-15, 1.0, 0.0], {}, Undecided),
        ([1e-13, 1.0, 0.0], {}, None),
        ([1.5e-14, 1.0, -1.0], {}, 1.0 + 1.5e-14),
        ([1.0 + 1e-15, -2.0, 1.0], {}, Undecided),
        ([1.0 + 1e-15, -2.0, 1.0], {"question": None}, None),
        ([1.0 + 1e-13, -2.0, 1.0], {}, None),
        ([1.0, -0.5, 0.0], {}, None),  # within the error at the end: the next piece tells
    ],
)
def test_a_value_falls_from_where_it_is_known_to_be(height, options, wanted):
    """A height of some coefficients in t, up to 2 s, which is known to 1e-14 m but for a launch."""
    rows = np.array([[0.0] * 3, height, [0.0] * 3, [height[1], 2 * height[2], 0.0]])
    curve = PolynomialPiece(0.0, 2.0, PlaneState, rows).curve(lambda state: state.z)
    asked = {"question": "it falls", "numbers": DOUBLES} | options
    if wanted is Undecided:
        with pytest.raises(Undecided, match="whether it falls"):
            event.first_fall(curve, 2.0, 1e-14, **asked)
    else:
        found = event.first_fall(curve, 2.0, 1e-14, **asked)
        assert found == (wanted and pytest.approx(wanted, abs=5e-16))


# --- ties -----------------------------------------------------------------------------------------

# Under 8 m/s² from rest, 16 m high, it lands after 2 s; all numbers of it are doubles.
FALL = Case({"gravity": 8.0}, (0.0, 16.0, 4.0, 0.0), "ground", (0.0,), 60.0)


def stop_of(case, engine, *more):
    """Event that stops a flight, among others; "" if it is undecided."""
    try:
        return fly(case, engine, *more).stop
    except Undecided:
        return ""


@ENGINES
def test_two_events_at_once_are_not_told_apart(engine):
    """Ground and plate, 8 m away."""
    for above in (-1e-3, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-3):
        case = replace(FALL, at=(above,))
        wanted = {-1: "plate", 0: "", 1: "ground"}[(above > 0) - (above < 0)]
        assert stop_of(case, engine, ("plate", (8.0, -1.0))) == wanted


def test_the_enclosure_tells_the_closest_doubles_apart():
    for x, wanted in ((math.nextafter(8, 7), "plate"), (math.nextafter(8, 9), "ground")):
        assert stop_of(FALL, ENCLOSURE, ("plate", (x, -1.0))) == wanted
        assert stop_of(FALL, IVP, ("plate", (x, -1.0))) == ""


@ENGINES
def test_an_event_at_the_time_limit_is_not_decided(engine):
    for late in (-1e-3, -1e-12, 0.0, 1e-12, 1e-3):
        wanted = {-1: "time", 0: "", 1: "ground"}[(late > 0) - (late < 0)]
        assert stop_of(replace(FALL, limit=2.0 + late), engine) == wanted


def test_the_enclosure_tells_the_closest_time_limits_apart():
    for limit, wanted in ((math.nextafter(2, 1), "time"), (math.nextafter(2, 3), "ground")):
        assert stop_of(replace(FALL, limit=limit), ENCLOSURE) == wanted
        assert stop_of(replace(FALL, limit=limit), IVP) == ""


@ENGINES
@pytest.mark.parametrize("height", [0.0, 16.0, -0.3])
def test_a_launch_from_the_ground(engine, height):
    """It has landed if it does not rise, and otherwise flies."""
    for air in ({"gravity": 8.0}, {"gravity": 8.0, "drag": 0.0075, "lift": 0.00375}):
        for w, landed in ((-5.0, True), (-1e-300, True), (-0.0, True), (1e-3, False), (5.0, False)):
            case = Case(air, (0.0, height, 4.0, w), "ground", (height,), 60.0)
            flight = fly(case, engine)
            assert flight.stop == "ground"
            assert (flight.time == 0) is landed
            if not landed:
                assert float(flight.time) == pytest.approx(2 * w / 8, rel=0.1)


@ENGINES
@pytest.mark.parametrize("above", [1e-16, 1e-13, 1e-9])
def test_a_launch_just_above_the_ground_is_above_it(engine, above):
    """However little: a launch is exact."""
    case = Case({"gravity": 8.0}, (0.0, above, 4.0, 4.0), "ground", (0.0,), 60.0)
    flight = fly(case, engine)
    assert float(flight.time) == pytest.approx(1.0, abs=above + 1e-14)
    falling = fly(replace(case, start=(0.0, above, 4.0, -4.0)), engine)
    assert float(falling.time) == pytest.approx(above / 4, rel=1e-6, abs=1e-15)


@ENGINES
def test_a_pitch_released_at_the_plate_crosses_it_unless_it_flies_away(engine):
    for cos, stop in ((-1.0, "plate"), (1.0, "time")):
        case = Case({"gravity": 8.0}, (0.0, 16.0, 4.0, 0.0), "plate", (0.0, cos), 1.0)
        flight = fly(case, engine)
        assert flight.stop == stop
        assert (flight.time == 0) is (stop == "plate")


# --- scenes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["ivp", "batch", "enclosure", "multiprecision"])
def test_a_circle_that_comes_back_to_the_ground_where_it_left_it_is_not_decided(name):
    """Without gravity and drag the path is a circle, here one that the ground is a tangent to."""
    launch = {"position": [0, 0, 0], "velocity": [45, 0, 0]}
    air = {"drag_coefficient": 0, "lift_coefficient": 0.7}
    line = {"kind": "flight", "gravity": 0, "air": air, "launch": launch}
    found = solve(parse_scene(json.dumps(line)), create(name))
    assert found.code == "undecided"
    assert "whether the ball touches the ground cannot be decided" in found.error


def test_a_batted_ball_whose_direction_is_left_open_is_not_taken_for_a_vertical_one():
    """A ball of 1e18 kg in 20 digits: the error of its rebound is far more than its slow side."""
    scene = random_scene("extreme", 23943, 20)
    raw, _ = solve_once(scene, Enclosure(20))
    assert raw.code == "undecided"
    assert float(solve(scene, ENCLOSURE).landing.distance) == pytest.approx(2.2139, abs=0.01)


def test_a_number_with_its_rate_follows_the_rules_of_derivatives() -> None:
    assert (1.0 - Dual(3.0, 2.0)) * Dual(5.0, 7.0) == Dual(-10.0, -24.0)


@pytest.mark.parametrize(("u", "w", "size"), [(0.3, 0.2, 0.5), (-0.3, -0.2, 0.5), (30.0, 9.0, 1.0)])
def test_the_scale_of_a_slow_ball_is_its_speed(u, w, size):
    start = PlaneState(0.0, 1.0, u, w)
    assert event.vertical(start, DOUBLES).size == size
