"""The fence in every engine: exact results, corners, ties, and curved flights."""

import json
import math

import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings

from longball.engines import create
from longball.engines.batch import solve_columns
from longball.engines.certify import certify
from longball.engines.chain import MODEL, Model, solve, solve_with_path
from longball.engines.event import ground
from longball.engines.fence import chords, falls, first_crossing, stop_at
from longball.engines.ivp import Ivp
from longball.model import quantities
from longball.model.frame import Frame
from longball.model.law import Force, PlaneState, SpaceState, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import FlightScene, InvalidScene, parse_scene
from tests.strategies import between

ENGINES = {
    "ivp": create("ivp"),
    "batch": create("batch"),
    "verlet": create("verlet", dt=1e-3),
}
ENCLOSURE = create("enclosure")
# Golden data have flights over fences for all engines but Verlet's.
EVERY_ENGINE = pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
SMOOTH = pytest.mark.parametrize(
    "engine", [ENGINES["ivp"], ENGINES["batch"], ENCLOSURE], ids=["ivp", "batch", "enclosure"]
)
PARK = [[70, 70, 2.4], [122, 0, 2.4], [70, -70, 2.4]]


def flight(velocity, fence, position=(0.0, 0.0, 1.0), **more):
    line = {
        "kind": "flight",
        "id": "f",
        "launch": {"position": position, "velocity": velocity},
        "fence": fence if isinstance(fence, dict) else {"polyline": fence},
    }
    return parse_scene(json.dumps(line | more))


def answer(scene, engine, model=MODEL):
    result = solve(scene, engine, model)
    assert result.error is None
    return result


# --- exact results --------------------------------------------------------------------------------


@EVERY_ENGINE
def test_the_height_at_the_fence_in_a_vacuum(engine):
    """z = z0 + d tan θ - g d²/(2 v² cos²θ) at x = d."""
    d, v, angle = 100.0, 40.0, 0.7
    velocity = (v * math.cos(angle), 0.0, v * math.sin(angle))
    fence = [[d, 120, 3.0], [d, -120, 3.0]]
    result = answer(flight(velocity, fence, air=None), engine)
    height = 1 + d * math.tan(angle) - 9.8 * d * d / (2 * (v * math.cos(angle)) ** 2)
    assert result.outcome == "home_run"
    assert float(result.fence.position[0]) == pytest.approx(d, abs=1e-12)
    # Verlet is exact for constant forces, but on chords: g dt²/8 at most.
    limit = 2e-6 if "verlet" in engine.description else 1e-11
    assert float(result.fence.clearance) == pytest.approx(height - 3, abs=limit)
    assert float(result.fence.time) == pytest.approx(d / velocity[0], abs=1e-12)
    assert float(result.fence.margin) == pytest.approx(120, abs=1e-9)
    assert result.landing.fair is True


def test_the_top_rises_along_a_chord():
    """Half way along, of a chord from 2 m to 12 m, it is 7 m."""
    scene = flight((40.0, 0.0, 25.0), [[100, 50, 2.0], [100, -50, 12.0]], air=None)
    fence = answer(scene, Ivp()).fence
    assert fence.position[2] - fence.clearance == pytest.approx(7.0, abs=1e-12)
    surface = scene.model_copy(
        update={"reading": scene.reading.model_copy(update={"fence_clearance": "surface"})}
    )
    assert answer(surface, Ivp()).fence.clearance == fence.clearance - 0.0366


def turned(vertices, angle):
    cos, sin = math.cos(angle), math.sin(angle)
    return [[cos * x - sin * y, sin * x + cos * y, *rest] for x, y, *rest in vertices]


@settings(max_examples=30)
@given(between(-0.7, 0.7), between(-3, 3), between(25, 50), between(10, 35))
def test_a_turned_park_and_a_mirrored_one(heading, angle, out, up):
    """Rotation about z of everything, and reflection in y = 0: the same crossing."""
    velocity = (out * math.cos(heading), out * math.sin(heading), up)
    fence = [[60, 65, 5.0], [90, 40, 2.0], [120, 5, 8.0], [95, -40, 8.0], [60, -65, 1.0]]
    here = answer(flight(velocity, fence), Ivp())
    ((vx, vy),) = turned([velocity[:2]], angle)
    there = answer(flight((vx, vy, up), turned(fence, angle)), Ivp())
    mirrored = [[x, -y, h] for x, y, h in reversed(fence)]
    other = answer(flight((velocity[0], -velocity[1], up), mirrored), Ivp())
    if here.fence is None:
        assert there.fence is other.fence is None
        return
    for result in (there, other):
        assert result.fence.clearance == pytest.approx(here.fence.clearance, abs=1e-9)
        assert result.fence.margin == pytest.approx(here.fence.margin, abs=1e-9)
        assert result.fence.time == pytest.approx(here.fence.time, abs=1e-9)
    assert other.outcome == here.outcome
    assert there.fence.segment == here.fence.segment
    assert other.fence.segment == 3 - here.fence.segment


# --- outcomes -------------------------------------------------------------------------------------


@EVERY_ENGINE
@pytest.mark.parametrize(
    ("velocity", "outcome", "fair"),
    [
        ((44.0, 3.0, 26.0), "home_run", True),
        ((44.0, 3.0, 18.0), "wall", None),
        ((24.0, 3.0, 16.0), "landed", True),
        ((15.0, 26.0, 16.0), "landed", False),
        ((30.0, 42.0, 26.0), "landed", False),  # over the fence, beyond the pole
    ],
)
@pytest.mark.sampled(every=4)
def test_outcomes(engine, velocity, outcome, fair):
    park = [[20, 80, 2.4], *PARK]
    result = answer(flight(velocity, park), engine)
    assert result.outcome == outcome
    assert (result.landing is None) is (outcome == "wall")
    assert result.landing is None or result.landing.fair is fair
    assert (result.fence is None) is (velocity[:2] in {(24.0, 3.0), (15.0, 26.0)})
    if result.fence:
        assert (float(result.fence.clearance) > 0) is (outcome != "wall")


def test_a_home_run_lands_where_it_would_without_a_fence():
    scene = flight((44.0, 3.0, 26.0), PARK)
    bare = scene.model_copy(update={"fence": None})
    for name, engine in ENGINES.items():
        over, alone = answer(scene, engine).landing, answer(bare, engine).landing
        assert float(over.distance) == pytest.approx(float(alone.distance), abs=1e-11), name
        assert float(over.time) == pytest.approx(float(alone.time), abs=1e-12)
        assert alone.fair is None


def test_the_way_of_a_ball_ends_at_the_wall_and_goes_on_over_the_fence():
    for up, outcome in ((26.0, "home_run"), (18.0, "wall")):
        result, way = solve_with_path(flight((44.0, 3.0, up), PARK), Ivp())
        assert result.outcome == outcome
        end = result.landing.time if outcome == "home_run" else result.fence.time
        assert way.end == pytest.approx(end, abs=1e-12)
        position, _ = way.at(result.fence.time)
        assert position == pytest.approx(result.fence.position, abs=1e-9)


@EVERY_ENGINE
@pytest.mark.sampled(every=3)
def test_a_ball_still_in_the_air_beyond_the_fence_is_a_home_run(engine):
    result = answer(flight((44.0, 3.0, 26.0), PARK, time_limit=5.0), engine)
    assert result.outcome == "home_run"
    assert result.landing is None
    assert answer(flight((44.0, 3.0, 26.0), PARK, time_limit=4.0), engine).outcome == "airborne"


def test_the_first_of_several_crossings_counts():
    """A fence with a bay: the ball leaves the field, comes in again and leaves once more."""
    bay = [[60, 60, 1], [60, 2, 5], [80, 2, 5], [80, -2, 5], [60, -2, 5], [60, -60, 1]]
    through = answer(flight((40.0, 0.5, 20.0), bay), Ivp()).fence
    assert through.position[0] == pytest.approx(80)
    assert through.segment == 2
    beside = answer(flight((40.0, 3.0, 20.0), bay), Ivp()).fence
    assert beside.position[0] == pytest.approx(60)
    zigzag = [[50, 50, 1], [50, -1, 1], [60, -1, 1], [60, 1, 1], [70, 1, 1], [70, -50, 1]]
    first = answer(flight((40.0, 0.0, 20.0), zigzag), Ivp()).fence
    assert (first.position[0], first.segment) == (pytest.approx(50), 0)


# --- corners --------------------------------------------------------------------------------------


@EVERY_ENGINE
def test_a_corner_of_one_height_is_no_question(engine):
    result = answer(flight((44.0, 0.0, 26.0), PARK), engine)
    assert result.outcome == "home_run"
    assert float(result.fence.margin) == pytest.approx(0, abs=1e-12)


@EVERY_ENGINE
@pytest.mark.parametrize("fence", [[[99, 50, 1], [99, 0, 1], [99, 0, 9], [99, -50, 9]], PARK[:2]])
@pytest.mark.sampled(every=3)
def test_a_corner_of_two_heights_or_an_end_is_told_or_not_decided(engine, fence):
    """By 1e-9 to either side it is told; over the corner itself it is not."""
    for aside, told in ((1e-9, True), (-1e-9, True), (0.0, False)):
        result = solve(flight((44.0, aside, 26.0), fence), engine)
        if told:
            assert result.error is None
            assert (result.fence is None) is (aside < 0 and len(fence) == 2)
        else:
            assert result.code == "undecided"
            assert "vertex where the fence ends or has two heights" in result.error


@SMOOTH
def test_how_near_a_corner_is_told(engine):
    told = []
    for power in range(8, 20):
        aside = 10.0**-power
        scene = flight((44.0, aside, 26.0), [[99, 50, 1], [99, 0, 1], [99, 0, 60], [99, -50, 60]])
        result = solve(scene, engine)
        if result.error is None:
            assert result.outcome == "home_run"
            told.append(power)
    assert told == list(range(8, 8 + len(told)))
    assert len(told) == 12 if engine is ENCLOSURE else 3 <= len(told) <= 7


def test_a_clearance_within_the_error_is_not_decided():
    low = flight((44.0, 3.0, 26.0), [[100, 50, 1], [100, -50, 1]])
    top = answer(low, Ivp()).fence.position[2]
    for higher, outcome in ((-1e-9, "home_run"), (0.0, None), (1e-9, "wall")):
        fence = [[100, 50, top + higher], [100, -50, top + higher]]
        for engine in (Ivp(), ENGINES["batch"]):
            result = solve(flight((44.0, 3.0, 26.0), fence), engine)
            assert result.outcome == outcome
            assert outcome or "whether the ball clears the fence" in result.error


# --- curved flights -------------------------------------------------------------------------------


def pushed(left):
    """Constant accelerations to the left and back, m/s²: a wind that pushes all the same."""

    def strengths(scene, frame, numbers):
        return {"left": numbers.exact(left), "back": numbers.exact(0.5)}

    def push(motion, p):
        return -p.back, p.left if left else 0, 0

    return Model(forces=(Force(strengths, push),))


AGAINST, SLIGHTLY, CURVED = pushed(0.0), pushed(0.2), pushed(2.0)


@EVERY_ENGINE
@pytest.mark.sampled(every=2)
def test_a_curved_flight_crosses_where_the_parabola_does(engine):
    """x = 40 t - t²/4 and y = -20 t + t²: over a chord at x = 99 that it meets at its own time."""
    scene = flight((40.0, 0.0, 25.0), [[99, 50, 1], [99, 4, 9], [99, -50, 9]], air=None)
    t = (40 - math.sqrt(1600 - 99)) * 2
    result = answer(scene, engine, CURVED)
    rough = "verlet" in engine.description
    assert float(result.fence.time) == pytest.approx(t, abs=2e-6 if rough else 1e-12)
    assert vector(result.fence.position) == pytest.approx(
        [99, t * t, 1 + 25 * t - 4.9 * t * t], abs=2e-5 if rough else 1e-10
    )
    assert result.fence.segment == 0
    circle = answer(flight((40.0, 0.0, 25.0), {"radius": 99.0}, air=None), engine, CURVED).fence
    away = math.hypot(*vector(circle.position)[:2])
    assert away == pytest.approx(99, abs=1e-5 if rough else 1e-10)


def vector(numbers):
    return [float(x) for x in numbers]


@EVERY_ENGINE
@pytest.mark.parametrize("model", [AGAINST, SLIGHTLY], ids=["plane", "space"])
@pytest.mark.sampled(every=3)
def test_a_ball_over_the_fence_and_blown_back(engine, model):
    """It turns 100 m away, half a metre beyond the fence, and comes down before it."""
    scene = flight((10.0, 0.0, 120.0), [[99.5, 500, 3], [99.5, -500, 3]], air=None, gravity=8.0)
    result = answer(scene, engine, model)
    t = 20 - math.sqrt(2.0)
    assert result.outcome == "home_run"
    assert float(result.fence.time) == pytest.approx(t, abs=1e-5)
    assert float(result.landing.position[0]) < 98
    short = flight((10.0, 0.0, 120.0), [[100.5, 500, 3], [100.5, -500, 3]], air=None, gravity=8.0)
    assert answer(short, engine, model).outcome == "landed"


@pytest.mark.parametrize("name", ["ivp", "batch"])
@pytest.mark.parametrize("forward", [31.1, 44.9])
@pytest.mark.sampled(every=3)
def test_a_ball_that_comes_down_at_the_foot_of_the_fence_in_space(name, forward):
    """On a ground of another height than 0: certain at 1e-10 m, and never wrong by an ulp."""
    raised = {"air": None, "position": (0.0, 0.0, 4.0), "ground": {"height": 3.0}}

    def answered(x, engine):
        fence = [[x, 50, 5], [x, -50, 5]]
        return solve(flight((forward, 0.0, 25.0), fence, **raised), engine, CURVED)

    foot = float(answered(900.0, ENCLOSURE).landing.position[0])
    assert answered(foot - 1e-10, ENGINES[name]).outcome == "wall"
    assert answered(foot + 1e-10, ENGINES[name]).outcome == "landed"
    for ulps in range(-3, 4):
        x = foot + ulps * math.ulp(foot)
        result = answered(x, ENGINES[name])
        assert result.outcome in (None, answered(x, ENCLOSURE).outcome)
        assert result.outcome or "before it touches the ground" in result.error


@SMOOTH
def test_dips_beyond_a_chord_in_space_are_found_or_declined(engine):
    """y = w t - a t²/2 is most w²/(2 a), exactly, at t = w/a: a wall along the flight beside it."""
    numbers = engine.numbers
    rng = np.random.default_rng(9)
    decided = total = 0
    for _ in range(6):
        push, across = (float(x) for x in rng.uniform([0.5, 2], [2, 8]))
        top = arb(across) * arb(across) / (2 * arb(push))
        for sign in (1, -1):
            for depth in np.geomspace(1e-3, 1e-13, 6).tolist():
                y = float(top - arb(sign * depth))
                total += 1
                beyond = top - arb(y)
                with numbers.arithmetic():
                    found = crossed(engine, push, across, y)
                if found is None:
                    assert abs(beyond) < 1e-11
                    continue
                decided += 1
                assert found is bool(beyond > 0), (push, across, y)
    assert total == 72
    assert decided == total if engine is ENCLOSURE else decided > 50


def crossed(engine, push, across, y):
    """True if a flight that is pushed back in y crosses a wall at y; None if it is not told."""
    numbers = engine.numbers
    exact = numbers.exact
    strengths = {"left": exact(push), "gravity": exact(9.8)}
    law = law_with(strengths, (lambda motion, p: (0, -p.left, 0),))
    start = law.state_of(PlaneState(exact(0.0), exact(1.0), exact(30.0), exact(40.0)))
    start = start._replace(v=exact(across))
    end = 1.2 * across / push
    way = engine.fly(law, start, [ground(exact(-1e6), start, numbers)], exact(end)).path
    # The wall is given in the flight's own frame: its left side, seen from a, is outside.
    frame = Frame(exact(0.0), exact(0.0), exact(1.0), exact(0.0))
    fence = parse_scene(
        json.dumps(
            {
                "kind": "flight",
                "launch": {"position": [0, 0, 1], "velocity": [1, 0, 1]},
                "id": "x",
                "fence": {"polyline": [[-400, y, 1], [900, y, 1]]},
            }
        )
    ).fence
    error = exact(engine.flight_error)
    met = first_crossing(fence, frame, way.pieces(), exact(end), exact(0.0), error, numbers)
    if met is None:
        return False
    return None if met.place.to_break == 0 else True


def test_fences_are_certified():
    for up in (26.0, 18.0, 10.0):
        scene = flight((44.0, 3.0, up), PARK)
        found = certify(scene, answer(scene, Ivp()))
        assert found.certificate is None
        for block in (found.fence, found.landing):
            for name, number in () if block is None else quantities.numbers(block):
                assert name == "segment" or float(number.radius) < 1e-11
    other = answer(scene, Ivp())
    foul = other.model_copy(update={"landing": other.landing.model_copy(update={"fair": False})})
    assert "landing.fair is proven to be True, not False" in certify(scene, foul).certificate


# --- columns --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [MODEL, CURVED], ids=["plane", "space"])
def test_columns_in_plane_and_space(model):
    scene = flight((40.0, 0.0, 25.0), PARK, air=None)
    speeds = np.linspace(20, 60, 9)
    table = solve_columns(scene, {"launch.velocity[0]": speeds}, ENGINES["batch"], model=model)
    assert set(table["outcome"]) == {"landed", "home_run"}
    for i, speed in enumerate(speeds):
        alone = flight((float(speed), 0.0, 25.0), PARK, air=None)
        result = answer(alone, ENGINES["batch"], model)
        assert table["outcome"][i] == result.outcome
        assert table["landing.distance"][i] == result.landing.distance
        if result.fence:
            assert table["fence.clearance"][i] == result.fence.clearance


# --- scenes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fence", "message"),
    [
        ({}, "fence: a fence has a radius or a polyline"),
        ({"radius": 100, "polyline": PARK}, "one of the two"),
        ({"radius": 0}, "fence.radius"),
        ({"polyline": [[1, 2, 3]]}, "fence: polyline needs at least two vertices"),
        ({"polyline": [[1, 2, 3], [1, 2, 5]]}, "at different places"),
        ({"polyline": PARK[::-1]}, "fence: polyline goes the wrong way round"),
        (
            {"polyline": [[70, 70, 1], [122, 0, 1], [120, 20, 1], [80, 0, 1]]},
            "fence: polyline crosses itself",
        ),
        ({"polyline": [[70, 70, 1], [70, -70, 1], [70, 10, 1]]}, "crosses itself"),
        ({"polyline": [[70, 70, 1], [100, 40, 1], [90, 50, 1]]}, "crosses itself"),
        ({"polyline": [[70, 70], [122, 0]]}, r"fence.polyline\[0\]\[2\]: is missing"),
        ({"height": 3}, "fence.height: unknown key; the keys here are radius, polyline"),
        ({"radius": 0.5}, "launch.position is outside"),
    ],
)
def test_a_bad_fence_is_named(fence, message):
    with pytest.raises(InvalidScene, match=message):
        flight((40.0, 0.0, 20.0), fence, position=(0.0, 0.6, 1.0))


@pytest.mark.parametrize(
    "polyline",
    [
        [[70, 70, 1], [100, 40, 1], [110, 30, 1], [90, -60, 1]],  # straight on
        [[10, 60, 1], [20, 60, 1], [30, 60, 1], [60, -60, 1]],
        [[40, 20, 1], [80, 20, 1], [120, 20, 1], [120, -60, 1]],
        [[10, 2, 1], [11, 1, 1], [11.3, 1, 1], [10.6, 1.6, 1], [60, -40, 1]],  # back, 0.1 m beside
    ],
)
def test_a_fence_that_only_comes_near_to_itself_is_one(polyline):
    scene = flight((40.0, 0.0, 20.0), {"polyline": polyline}, position=(0.0, 0.0, 1.0))
    assert len(scene.fence.polyline) == len(polyline)


def test_a_scene_without_a_fence_is_written_as_ever():
    scene = flight((40.0, 0.0, 20.0), PARK)
    assert parse_scene(scene.line()) == scene
    assert "fence" not in scene.model_copy(update={"fence": None}).line()
    assert isinstance(scene, FlightScene)
    with pytest.raises(InvalidScene, match="fence: unknown key"):
        parse_scene('{"id": "p", "kind": "pitch", "fence": {"radius": 100}}')


# --- each part by itself --------------------------------------------------------------------------


class Line:
    """A piece in space, from a place in a straight line but for z; or bent in y."""

    begin, length = 2.0, 10.0

    def __init__(self, x, y, u, v, bend=0.0):
        self.x = np.array([x, u, 0.0])
        self.y = np.array([y, v, -bend])

    def at(self, t):
        x, y = (float(np.polynomial.polynomial.polyval(t, p)) for p in (self.x, self.y))
        return SpaceState(x, y, 5.0, 0.0, 0.0, 0.0)

    def curve(self, value):
        return Values(lambda t: value(self.at(t)), self.length)


class Values:
    """A value along a piece by its samples: every turn on a grid of 1/64 s is found."""

    def __init__(self, value, length):
        self.value, self.length = value, length

    def __call__(self, t):
        return self.value(t)

    def positive(self, a, b):
        return all(self(t) > self(a) / 2 for t in np.linspace(a, b, 641))

    def turns(self, a, b):
        times = np.linspace(a, b, 641)
        values = [self(t) for t in times]
        return [
            float(t)
            for t, left, here, right in zip(times[1:], values, values[1:], values[2:], strict=False)
            if (here - left) * (right - here) < 0
        ]

    def zero(self, a, b):
        for _ in range(100):
            middle = (a + b) / 2
            a, b = (middle, b) if self(middle) > 0 else (a, middle)
        return b


HERE = Frame(0.0, 0.0, 1.0, 0.0)


def over(piece, fence, error=1e-12, end=100.0):
    scene = flight((1.0, 0.0, 1.0), fence)
    return first_crossing(scene.fence, HERE, iter([piece]), end, 0.0, error, DOUBLES)


def test_a_line_in_space_crosses_a_chord_at_a_share_of_it():
    met = over(Line(0.0, 0.0, 10.0, 5.0), [[30.0, 40.0, 2.0], [30.0, -10.0, 12.0]])
    assert met.time == pytest.approx(2.0 + 3.0, rel=1e-14)
    assert (met.state.s, met.state.y) == pytest.approx((30.0, 15.0), rel=1e-14)
    place = met.place
    assert (place.segment, place.height) == (0, pytest.approx(7.0, rel=1e-14))
    assert (place.margin, place.to_break) == pytest.approx((25.0, 25.0), rel=1e-13)
    assert place.slope == pytest.approx(0.2, rel=1e-14)
    assert over(Line(0.0, 0.0, 10.0, 15.0), [[30.0, 40.0, 2.0], [30.0, -10.0, 12.0]]) is None
    assert over(Line(0.0, 0.0, 10.0, -5.0), [[30.0, 40.0, 2.0], [30.0, -10.0, 12.0]]) is None


@pytest.mark.parametrize("y", [40.0, -16.0])
def test_a_crossing_at_an_end_of_the_fence_is_a_break_and_past_it_is_none(y):
    """At x = 32 after 4 s, and within and beyond the error of the place."""
    fence = [[32.0, 40.0, 2.0], [32.0, -16.0, 12.0]]
    out = math.copysign(1e-9, y)
    for off in (0.0, out / 100, -out / 100):
        met = over(Line(0.0, 0.0, 8.0, (y + off) / 4), fence, error=1e-11)
        assert met.place.to_break == pytest.approx(0.0, abs=2e-11)
    assert over(Line(0.0, 0.0, 8.0, (y + out) / 4), fence, error=1e-11) is None


def test_a_chord_that_goes_on_has_no_break_there():
    park = [[30.0, 40.0, 2.0], [30.0, -10.0, 12.0], [0.0, -90.0, 12.0], [-9.0, -90.0, 4.0]]
    met = over(Line(0.0, 0.0, 10.0, 2.0), park)
    assert met.place.to_break == pytest.approx(34.0)
    assert met.place.margin == pytest.approx(16.0)
    made = chords(flight((1.0, 0.0, 1.0), park).fence.polyline, DOUBLES)
    assert [(c.segment, c.open_a, c.open_b) for c in made] == [
        (0, True, False),
        (1, False, False),
        (2, False, True),
    ]


@pytest.mark.parametrize(("end", "found"), [(5.5, True), (4.5, False)])
def test_a_crossing_after_the_end_is_none(end, found):
    met = over(Line(0.0, 0.0, 10.0, 0.0), {"radius": 30.0}, end=end)
    assert (met is not None) is found


@pytest.mark.parametrize("turned", [False, True])
def test_the_first_of_two_chords_that_are_crossed_on_a_piece(turned):
    """Out at x = 30, in again at x = 45 and out at x = 60, whichever the fence names first."""
    fence = [[60, 50, 9], [60, -5, 9], [45, -5, 9], [45, 5, 1], [30, 5, 1], [30, -50, 1]]
    if turned:
        fence = [[x, -y, h] for x, y, h in fence[::-1]]
    met = over(Line(0.0, 0.0, 10.0, 0.0), fence)
    assert met.time == pytest.approx(2.0 + 3.0)
    assert met.place.height == 1.0


@pytest.mark.parametrize(("x", "y"), [(0.0, 80.0), (-70.0, 9.0), (60.0, 20.0)])
@pytest.mark.parametrize(("share", "doubtful"), [(0.9, True), (1.1, False)])
def test_a_turn_within_the_error_of_a_state_is_doubtful(x, y, share, doubtful):
    """It turns inside a wall, at a distance of the error times 1 + |x| + |y| where it starts."""
    error = 1e-3
    away = share * error * (1 + abs(x) + abs(y))
    bend = 0.0625
    top = y + 0.25 / bend * 0.25  # of y + t/2 - t²/16, at t = 4
    wall = top + away
    met = over(Line(x, y, 0.125, 0.5, bend), [[-400.0, wall, 1.0], [400.0, wall, 1.0]], error)
    assert (met is not None) is doubtful
    if met is not None:
        assert met.doubtful
        assert met.time == pytest.approx(2.0 + 4.0)


@pytest.mark.parametrize(("away", "doubtful"), [(-0.2, False), (0.05, True), (0.2, None)])
def test_a_turn_close_to_a_circle_may_not_reach_it(away, doubtful):
    """It turns 81 m away after 4 s; states are off by a thousandth of 1 + |x| + |y|: 0.08 m."""
    met = over(Line(0.0, 80.0, 0.0, 0.5, 0.0625), {"radius": 81.0 + away}, 1e-3)
    assert (met and met.doubtful) is doubtful


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        ((1.0, -1.0), [(1.0, False)]),
        ((-1.0, 1.0), []),
        ((0.5, 0.5, -1.0), [(1.0, False)]),
        ((9.0, -6.0, 1.0 + 1e-4), [(3.0, True)]),
        ((9.0, -6.0, 1.0 + 1e-1), []),
        ((5.0,), []),
        ((0.018, -0.017, 0.0085), [(1.0, True)]),  # never below half of what it is first
    ],
)
def test_falls_of_a_value(coefficients, expected):
    curve = Values(lambda t: float(np.polynomial.polynomial.polyval(t, coefficients)), 4.0)
    found = list(falls(curve, 4.0, 1e-2, None))
    assert [doubtful for _, doubtful in found] == [doubtful for _, doubtful in expected]
    assert [t for t, _ in found] == pytest.approx([t for t, _ in expected], abs=0.02)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_a_plane_meets_a_chord_where_the_two_lines_cross(sense, angle):
    """From (1, 2) along the heading, or back: cut by Cramer's rule."""
    cos, sin = math.cos(angle), math.sin(angle)
    fence = [[30.0, 40.0, 2.0], [30.0, -40.0, 10.0], [-30.0, -40.0, 3.0], [-30.0, 40.0, 7.0]]
    frame = Frame(1.0, 2.0, cos, sin)
    stop = stop_at(flight((1.0, 0.0, 1.0), fence).fence, frame, 0.0, sense, 1e-14, DOUBLES)
    x = 30.0 * sense
    s = (x - 1.0) / cos
    y = 2.0 + s * sin
    assert stop.s == pytest.approx(s, rel=1e-14)
    share = (40.0 - y) / 80.0 if sense > 0 else (y + 40.0) / 80.0
    low, high = (2.0, 10.0) if sense > 0 else (3.0, 7.0)
    assert stop.place.height == pytest.approx(low + share * (high - low), rel=1e-14)
    assert stop.place.segment == (0 if sense > 0 else 2)
    assert stop.place.slope == pytest.approx((high - low) / 80.0, rel=1e-14)
    assert stop.place.margin == pytest.approx(80.0 * min(share, 1 - share), rel=1e-13)
    # The fence ends at y = 40 on both sides; seen from the flight it is that far aside.
    ahead = 80.0 * (share if sense > 0 else 1 - share) * cos
    assert stop.place.to_break == pytest.approx(ahead, rel=1e-13)


def test_a_plane_leaves_a_circle_ahead_and_back():
    """x = 1 + s cos, y = 2 + s sin: s² + 2 (cos + 2 sin) s = r² - 5."""
    fence = flight((1.0, 0.0, 1.0), {"radius": 50.0}).fence
    frame = Frame(1.0, 2.0, 0.6, 0.8)
    for sense in (1, -1):
        stop = stop_at(fence, frame, 0.0, sense, 1e-14, DOUBLES)
        assert sense * stop.s > 0
        away = math.hypot(1.0 + 0.6 * stop.s, 2.0 + 0.8 * stop.s)
        assert away == pytest.approx(50.0, rel=1e-15)
        assert (stop.place.height, stop.place.margin, stop.place.segment) == (0.0, None, 0)
        assert stop.place.to_break > 1e20
