"""The fence: ways that end at it, and turns within the error of a state.

Outcomes, corners and ties in every engine are in the golden data (`fence`).
"""

import json
import math

import numpy as np
import pytest

from longball.engines import create
from longball.engines.batch import Batch
from longball.engines.chain import solve, solve_with_path
from longball.engines.fence import at_stop, chords, first_crossing
from longball.engines.ivp import Ivp
from longball.engines.polynomial import PolynomialPiece
from longball.model.frame import Frame
from longball.model.law import SpaceState
from longball.model.numbers import DOUBLES
from longball.model.scene import parse_scene

ENGINES = {name: create(name) for name in ("ivp", "enclosure")}
ENCLOSURE = ENGINES["enclosure"]
SMOOTH = pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
PARK = [[70, 70, 2.4], [122, 0, 2.4], [70, -70, 2.4]]


def flight(velocity, fence, position=(0.0, 0.0, 1.0), **more):
    line = {
        "kind": "flight",
        "id": "f",
        "launch": {"position": position, "velocity": velocity},
        "fence": fence if isinstance(fence, dict) else {"polyline": fence},
    }
    return parse_scene(json.dumps(line | more))


# --- outcomes -------------------------------------------------------------------------------------


def test_the_way_of_a_ball_ends_at_the_wall_and_goes_on_over_the_fence():
    for up, outcome in ((26.0, "home_run"), (18.0, "wall")):
        result, way = solve_with_path(flight((44.0, 3.0, up), PARK), Ivp())
        assert result.outcome == outcome
        end = result.landing.time if outcome == "home_run" else result.fence.time
        assert way.end == pytest.approx(end, abs=1e-12)
        position, _ = way.at(result.fence.time)
        assert position == pytest.approx(result.fence.position, abs=1e-9)


@pytest.mark.parametrize("engine", [Ivp(), Batch(), ENCLOSURE])
@pytest.mark.parametrize("turned", [0.0, 1.5, -1.5, 3.0])
@pytest.mark.parametrize("right", [True, False])
def test_the_end_of_a_fence_is_passed_on_one_side_or_the_other(engine, turned, right):
    """Nearer to the end than doubles resolve, only the enclosure decides; at the end, nobody."""
    cos, sin = math.cos(turned), math.sin(turned)

    def at(ahead, left):
        return cos * ahead - sin * left, sin * ahead + cos * left

    ends = [(30, 20), (30, 0)] if right else [(30, 0), (30, -20)]
    fence = [[*at(*end), 1.0] for end in ends]
    for inside in (-1e-3, -1e-16, 0.0, 1e-16, 1e-3):
        velocity = *at(30.0, 30 * inside * (1 if right else -1)), 9.0
        found = solve(flight(velocity, fence, air={"lift_coefficient": 0.0}), engine)
        if abs(inside) == 1e-3:
            assert (found.fence is not None) is (inside > 0)
        elif engine is not ENCLOSURE or turned == inside == 0.0:
            assert found.code == "undecided"


# --- each part by itself --------------------------------------------------------------------------


def line(x, y, u, v, bend=0.0):
    """A piece in space at a height of 5 m, from a place in a straight line, or bent in y."""
    rows = np.zeros((6, 3))
    rows[0], rows[1], rows[2, 0] = (x, u, 0.0), (y, v, -bend), 5.0
    rows[3, 0], rows[4] = u, (v, -2 * bend, 0.0)
    return PolynomialPiece(2.0, 10.0, SpaceState, rows)


HERE = Frame(0.0, 0.0, 1.0, 0.0)


def over(piece, fence, error=1e-12, end=100.0):
    scene = flight((1.0, 0.0, 1.0), fence)
    return first_crossing(scene.fence, HERE, iter([piece]), end, 0.0, error, DOUBLES)


@pytest.mark.parametrize(("x", "y"), [(0.0, 80.0), (-70.0, 9.0), (60.0, 20.0)])
@pytest.mark.parametrize(("share", "doubtful"), [(0.9, True), (1.1, False)])
def test_a_turn_within_the_error_of_a_state_is_doubtful(x, y, share, doubtful):
    """It turns inside a wall, at a distance of the error times 1 + |x| + |y| where it starts."""
    error = 1e-3
    away = share * error * (1 + abs(x) + abs(y))
    bend = 0.0625
    top = y + 0.25 / bend * 0.25  # of y + t/2 - t²/16, at t = 4
    wall = top + away
    met = over(line(x, y, 0.125, 0.5, bend), [[-400.0, wall, 1.0], [400.0, wall, 1.0]], error)
    assert (met is not None) is doubtful
    if met is not None:
        assert met.doubtful
        assert met.time == pytest.approx(2.0 + 4.0)


@pytest.mark.parametrize(("away", "doubtful"), [(-0.2, False), (0.05, True), (0.2, None)])
def test_a_turn_close_to_a_circle_may_not_reach_it(away, doubtful):
    """It turns 81 m away after 4 s; states are off by a thousandth of 1 + |x| + |y|: 0.08 m."""
    met = over(line(0.0, 80.0, 0.0, 0.5, 0.0625), {"radius": 81.0 + away}, 1e-3)
    assert (met and met.doubtful) is doubtful


def test_a_ball_that_still_rises_at_the_wall_has_no_apex_in_columns():
    scene = flight((50.0, 0.0, 20.0), [[40, 40, 30], [60, 0, 30], [40, -40, 30]])
    results = [solve(scene, Ivp()), *Batch().solve_all([scene] * 2)]
    assert [(one.outcome, one.apex) for one in results] == [("wall", None)] * 3


def test_a_point_of_a_chord_is_measured_to_its_nearer_end():
    """Chords of 10 m whose height rises by 1 m; the second is a step higher."""
    first, second = chords([[0, 0, 1], [0, 10, 2], [0, 10, 5], [0, 20, 6]], DOUBLES)
    for y, margin in ((2.5, 2.5), (9.0, 1.0), (0.0, 0.0)):
        place = first.passed((0.0, y, 3.0), 1e-9, DOUBLES)
        assert (place.height, place.segment, place.margin) == (1 + y / 10, 0, margin)
        assert (place.to_break, place.slope) == (margin, 0.1)
    (whole, joined) = chords([[0, 0, 1], [0, 10, 2], [5, 20, 2]], DOUBLES)
    assert whole.passed((0.0, 9.0, 3.0), 1e-9, DOUBLES).to_break == 9.0  # it goes on at b
    assert joined.passed((0.5, 11.0, 3.0), 1e-9, DOUBLES).to_break == pytest.approx(
        9 * math.sqrt(1.25)
    )
    assert second.segment == 2
    assert first.passed((0.0, 10.1, 3.0), 1e-9, DOUBLES) is None
    assert first.passed((0.0, 10.1, 3.0), 0.2, DOUBLES) is not None
    assert first.passed((0.0, -0.1, 3.0), 1e-9, DOUBLES) is None
    assert first.inside((1.0, 5.0)) == -first.inside((-1.0, 5.0)) == 10.0


@pytest.mark.parametrize(("s", "size"), [(80.0, 80.0), (-80.0, 80.0), (0.5, 1.0)])
def test_a_stop_at_the_fence_is_as_large_as_its_distance_or_a_metre(s, size):
    assert at_stop("fence", s, 1, DOUBLES).size == size
