"""The batch engine: held to high precision, to the ivp engine, and to itself, bit for bit."""

from __future__ import annotations

import math
from itertools import pairwise, product
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from longball.engines import create
from longball.engines.batch import (
    Batch,
    expansion,
    roots,
    solve_columns,
    solve_columns_with_restitutions,
)
from longball.engines.batch.expansion import kernel
from longball.engines.batch.jit import call, unowned_view
from longball.engines.batch.roots import NEVER
from longball.engines.batch.writer import WIDTH, aligned
from longball.engines.chain import solve, solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.engine import Engine
from longball.engines.event import ground
from longball.engines.ivp import Ivp
from longball.engines.path import Flight
from longball.engines.series import recurrence
from longball.model import trace
from longball.model.law import Law, PlaneState, SpaceState, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Launch,
    Pitch,
    PitchScene,
    Scene,
    Swing,
    parse_scene,
)

# What only compiled functions can call, for Python to call.
first_fall, two_values, curvature, downward, first_zero, differentiate, root_value = (
    numba.njit(function.py_func, error_model="numpy")  # type: ignore[attr-defined]
    for function in (
        roots.first_fall,
        roots.two_values,
        roots.curvature,
        roots.downward,
        roots.first_zero,
        roots.differentiate,
        roots.value,
    )
)

PAPER = {"drag": 0.0074867, "lift": 0.0037433, "gravity": 9.8}


def landing(strengths: dict[str, float], start: PlaneState, *forces: Any) -> Flight:
    """Fly to the ground."""
    surface = ground(0.0, start, DOUBLES)
    return Batch().fly(law_with(strengths, forces), start, [surface], 60.0)


# --- exact results --------------------------------------------------------------------------------


def test_a_heading_that_all_share_may_be_none() -> None:
    up = Launch(position=(0.0, 0.0, 1.0), velocity=(0.0, 0.0, 20.0))
    scene = FlightScene(id="up", launch=up)
    columns = {"launch.position[2]": [1.0, 2.0]}
    found = solve_columns(scene, columns)
    assert found["landing.time"][0] == solve(scene, Batch()).landing.time


# --- the same bits --------------------------------------------------------------------------------


def test_what_is_zero_in_some_scenes_of_a_list_changes_no_bit_of_others() -> None:
    """Winds and spins with and without parts that are zero, and so are not computed."""
    winds = ((0.0, 0.0, 0.0), (5.0, 0.0, 0.0))
    scenes: list[Scene] = [
        FlightScene(
            id=str(i),
            launch=Launch(
                position=(0.0, 0.0, 1.0),
                velocity=(40 + i / 25, i % 3 * 2.0, 25.0),
                spin=(0.0, -spin, spin / 3),
            ),
            air=Air(drag_coefficient=0.35, lift_coefficient=0.2, wind=winds[i % 2]),
        )
        for i, spin in enumerate([0.0, 0.0, 150.0, 150.0] * 12)
    ]
    engine = Batch()
    assert engine.solve_all(scenes) == [solve(scene, engine) for scene in scenes]


def test_balls_that_share_their_pitch_have_the_bits_of_their_own() -> None:
    scene = AtBatScene(id="base")
    rng = np.random.default_rng(5)
    columns = {
        "pitch.speed": rng.uniform(5, 45, 5000),
        "swing.height_offset": rng.normal(0, 0.04, 5000),
    }
    shared = solve_columns_with_restitutions(scene, columns, (0.2, 0.9), threads=2)
    for e, table in zip((0.2, 0.9), shared, strict=True):
        alone = solve_columns(scene, columns | {"ball.restitution": np.full(5000, e)})
        assert table.keys() == alone.keys()
        assert {"batted", "missed", "grounded"} <= set(table["outcome"])
        for name in table:
            np.testing.assert_array_equal(table[name], alone[name])


def test_neither_order_nor_number_nor_threads_change_a_bit() -> None:
    rng = np.random.default_rng(4)
    n = 9000  # three blocks
    columns = {
        "pitch.speed": rng.normal(37, 2, n),
        "pitch.aim[0]": rng.normal(0, 0.2, n),
        "swing.height_offset": rng.normal(0, 0.0366, n),
        "swing.tilt": rng.uniform(0, 0.17, n),
        "ball.restitution": rng.uniform(0.41, 0.45, n),
    }
    scene = AtBatScene(id="any")
    whole = solve_columns(scene, columns)
    assert set(whole["outcome"]) >= {"batted", "missed"}
    order = rng.permutation(n)
    mixed = solve_columns(scene, {k: v[order] for k, v in columns.items()}, threads=2)
    few = solve_columns(scene, {k: v[100:107] for k, v in columns.items()})
    for name, column in whole.items():
        assert np.array_equal(mixed[name], column[order], equal_nan=column.dtype.kind == "f"), name
        assert np.array_equal(few[name], column[100:107], equal_nan=column.dtype.kind == "f"), name


# --- the printed step -----------------------------------------------------------------------------


def headwind(motion: Any, p: Any) -> Any:
    """Drag of a coefficient that is logistic in the speed, with exp and division."""
    share = 1.0 / (1.0 + trace.exp(p.slope * motion.speed + p.middle))
    return tuple(-p.share * share * x for x in motion.velocity)


def thinning(motion: Any, p: Any) -> Any:
    """A push whose size depends on the height, with log and division by what moves."""
    _, _, z = motion.position
    u, _, w = motion.velocity
    return p.push * trace.log(1.0 + z * z), p.aside * u / (1.0 + w * w), p.push * motion.speed


LAWS: dict[str, Law] = {
    "paper": law_with(PAPER),
    "exp": law_with(PAPER | {"slope": -0.2, "middle": 6.0, "share": 0.1}, (headwind,)),
    "log": law_with(PAPER | {"push": 0.3, "aside": 0.0}, (thinning,)),
    "space": law_with(PAPER | {"push": 0.1, "aside": 2.0}, (thinning,)),
}


def expand_lanes(law: Law, states: Any, order: int) -> Any:
    """Expand states, a column a lane, by `step`."""
    code = kernel(law.program)
    x = code.layout.allocate(order)
    x[: len(states), 0] = states
    for i, name in enumerate(law.program.parameters):
        x[code.layout.parameters, i] = law.strengths[name]
    functions = aligned(1, len(states) + 2, WIDTH)

    @numba.njit
    def step(address: int, x: Any, functions: Any, order: int, rows: int) -> int:
        at = unowned_view(x), unowned_view(functions)
        return call(address, (at[0], at[1], order, rows, 1, 1e-14))

    step(code.code.address, x.ravel(), functions.ravel(), order, x.shape[1])
    return x


@pytest.mark.parametrize("count", [1, 8, 9, 1000])
def test_lanes_begin_on_a_cache_line(count: int) -> None:
    kept = [aligned(count, 3) for _ in range(20)]  # at once, so that they lie in several places
    for zeros in kept:
        assert zeros.shape == (count, 3)
        assert not zeros.any()
        assert zeros.ctypes.data % 64 == 0


@pytest.mark.parametrize("name", LAWS)
def test_lanes_follow_the_recurrence(name: str) -> None:
    """The sums are taken in another order, so that the last digits may differ."""
    order, rng, law = 20, np.random.default_rng(8), LAWS[name]
    variables = law.program.variables
    assert len(variables) == (6 if name in ("log", "space") else 4)
    states = rng.uniform(-40, 40, (len(variables), WIDTH))
    x = expand_lanes(law, states, order)
    series = recurrence(law.program)
    strengths = [law.strengths[parameter] for parameter in law.program.parameters]
    step = kernel(law.program).layout.step
    half = len(variables) // 2
    for lane in range(WIDTH):
        rows = [[0.0] * (order + 2) for _ in series.rows]
        for row, start in zip(rows, states[:, lane].tolist(), strict=False):
            row[0] = start
        series.function(DOUBLES.functions)(rows, order, *strengths)
        length = x[step, len(variables) + expansion.LENGTH, lane]
        speed = math.hypot(*states[half:, lane])
        for i, row in enumerate(rows[: len(variables)]):
            known = np.array(row[: order + 2 if i < half else order + 1])
            found = x[i, : len(known), lane]
            scale = length ** -np.arange(len(known), dtype=float)
            size = max(1.0, speed, abs(states[i, lane]))
            assert (abs(found - known) <= 1e-12 * size * scale).all()
            end = np.polynomial.polynomial.polyval(length, known)
            assert x[step, i, lane] == pytest.approx(end, rel=0, abs=1e-13 * size)
            if i >= half:
                assert max(abs(known[-2:]) * length ** np.array([order - 1, order])) < 2e-14 * speed
            else:
                reach = x[step, len(variables) + expansion.RANGES + i, lane]
                assert reach == pytest.approx(
                    sum(abs(c) * length**k for k, c in enumerate(known) if k), rel=1e-12
                )


def test_a_lane_has_the_same_bits_whatever_its_neighbours_hold(nightly: bool) -> None:
    rng = np.random.default_rng(9)
    states = rng.uniform(-40, 40, (4, WIDTH))
    whole = expand_lanes(LAWS["paper"], states, 20)
    for lane in range(WIDTH) if nightly else (0, WIDTH // 2, WIDTH - 1):
        others = np.full((4, WIDTH), math.nan)
        others[:, (lane + 5) % WIDTH] = states[:, lane]
        alone = expand_lanes(LAWS["paper"], others, 20)[..., (lane + 5) % WIDTH]
        np.testing.assert_array_equal(alone, whole[..., lane])


@pytest.mark.parametrize("name", LAWS)
def test_a_new_force_flies_as_in_the_ivp_engine(name: str) -> None:
    law = LAWS[name]
    start = law.state_of(PlaneState(0.0, 1.5, 31.0, 22.0))
    surface = ground(0.0, start, DOUBLES)
    expected = Ivp().fly(law, start, [surface], 60.0)
    found = Batch().fly(law, start, [surface], 60.0)
    assert (found.stop, found.time) == ("ground", pytest.approx(expected.time, rel=1e-13))
    assert list(found.state) == pytest.approx(list(expected.state), rel=1e-12, abs=1e-12)
    assert isinstance(found.state, SpaceState) == (len(found.state) == 6)


@pytest.mark.parametrize("w", [0.0, 20.0])
def test_the_path_has_the_states_of_the_flight(w: float) -> None:
    """From rest, straight up, and on a curve; its steps join."""
    for u, lift in ((0.0, 0.0), (25.0, PAPER["lift"])):
        start = PlaneState(0.0, 5.0, u, w)
        flight = landing(PAPER | {"lift": lift}, start)
        assert flight.path.at(0.0) == start
        assert list(flight.path.at(flight.time)) == pytest.approx(list(flight.state), abs=1e-13)
        pieces = list(flight.path.pieces())
        for before, after in pairwise(pieces):
            assert list(before.at(before.length)) == pytest.approx(list(after.at(0.0)), abs=1e-13)


# --- roots ----------------------------------------------------------------------------------------


def slope_of(p: Any) -> Any:
    """Return the derivative of a polynomial, with a zero behind it."""
    slope = np.full(len(p), math.nan)
    differentiate(p, len(p) - 1, slope)
    return slope


def polynomial(*roots: float, scale: float = 1.0) -> tuple[Any, Any, int]:
    """Return a polynomial of some roots, positive at 0; its derivative and degree."""
    p = np.polynomial.polynomial.polyfromroots(roots) * scale
    p = p if p[0] > 0 else -p
    return p, slope_of(p), len(p) - 1


@given(st.floats(1e-3, 0.9), st.lists(st.floats(0.05, 2.0), max_size=4))
def test_the_first_root_is_found(first: float, further: list[float]) -> None:
    p, slope, degree = polynomial(first, *(first + distance for distance in further))
    for bound in (curvature, downward):
        bend = bound(slope, degree - 1, 1.0)
        found = first_zero(p, slope, degree, 1.0, 0.0, 0.0, 1.0, bend)
        assert found == pytest.approx(first, abs=1e-9)


@given(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=6), st.floats(0.1, 2.0))
def test_no_curvature_is_beyond_its_bounds(coefficients: list[float], end: float) -> None:
    slope = np.array(coefficients)
    times = np.linspace(0.0, end, 50)
    bends = np.polynomial.polynomial.polyval(times, np.polynomial.polynomial.polyder(slope))
    rounding = 1e-14 * (np.abs(slope) * np.arange(len(slope)) * max(1.0, end) ** 5).sum()
    assert np.abs(bends).max() <= curvature(slope, len(slope) - 1, end) + rounding
    assert -bends.min() <= downward(slope, len(slope) - 1, end) + rounding
    assert downward(slope, 0, end) == 0.0


@pytest.mark.parametrize("degree", range(1, 8))
def test_sums_of_whole_coefficients_are_exact(degree: int) -> None:
    """Values and rates; and the bounds on p'' term by term, of which the lowest keeps its sign."""
    p = np.array([3.0, -5.0, 2.0, 7.0, -1.0, 4.0, -6.0, 2.0])[: degree + 1]
    series = np.polynomial.Polynomial(p)
    slope = slope_of(p)
    assert slope.tolist() == [*series.deriv().coef.tolist(), 0.0]
    for t in (0.0, 0.5, 2.0):
        assert root_value(p, degree, t) == series(t)
        assert two_values(p, slope, degree, t) == (series(t), series.deriv()(t))
        bends = [k * abs(slope[k]) * t ** (k - 1) for k in range(1, degree)]
        assert curvature(slope, degree - 1, t) == sum(bends)
        if degree > 1:
            assert downward(slope, degree - 1, t) == sum(bends[1:]) - slope[1]


@pytest.mark.parametrize("begin", [0.0, 0.25, 0.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("level", [0.0, 0.125])
def test_a_root_is_looked_for_from_a_time_on_and_at_a_level(
    begin: float, sign: float, level: float
) -> None:
    """Of a parabola that is least at 1: ``sign p = (t - 1)² - 1/4 + level``, zero at 1/2, 3/2."""
    p = sign * np.array([0.75 + level, -2.0, 1.0])
    slope = slope_of(p)
    for upper in (-2.0, -1.0, 2.0):  # -sign p'' is -2
        found = first_zero(p, slope, 2, sign, level, begin, 3.0, upper)
        assert found == pytest.approx(0.5, abs=1e-15)
    # From below zero on the fall is there at once, on the rise it is none.
    assert first_zero(p, slope, 2, sign, level, 0.75, 3.0, 2.0) == 0.75
    assert first_zero(p, slope, 2, sign, level, 1.25, 3.0, 0.0) == NEVER
    assert first_zero(p, slope, 2, sign, level, 1.75, 3.0, 2.0) == NEVER
    assert first_zero(p, slope, 2, sign, level, 0.0, 0.49, 2.0) == NEVER


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=7), st.floats(1e-12, 0.3))
def test_the_first_fall_is_that_of_a_search_on_a_grid(
    coefficients: list[float], error: float
) -> None:
    """Before what is found nothing is below the error's other side; there it is."""
    p = np.array([abs(coefficients[0]) + 2 * error, *coefficients[1:]])
    degree, slope = len(p) - 1, slope_of(p)
    time = first_fall(p, slope, degree, 1.0, error)
    times = np.linspace(0.0, 1.0, 2001)
    heights = np.polynomial.polynomial.polyval(times, p)
    slack = 1e-12 + 1e-6 * error
    if math.isnan(time):
        assert heights.min() <= error + slack
        return
    if time == NEVER:
        assert (heights[:-1] >= -error - slack).all() or heights[-1] <= slack
        return
    assert heights[times < time].min(initial=math.inf) >= -error - slack
    there = float(np.polynomial.polynomial.polyval(time, p))
    assert abs(there) <= slack
    assert float(np.polynomial.polynomial.polyval(time, slope)) <= 1e-5


@pytest.mark.parametrize("off", [-0.3, -0.05, -5e-6, 5e-6, 0.05, 0.3])
@pytest.mark.parametrize(
    ("turns", "lowest"),
    [
        ((1.0, 4.0), 4.0),  # it rises first
        ((3.0,), 3.0),  # it falls first
        ((0.0, 2.0), 2.0),  # it falls from a turning point
        ((0.0, 1.0, 3.0), 3.0),  # it rises from one
    ],
)
def test_a_fall_between_turning_points_is_told_doubtful_or_none(
    turns: tuple[float, ...], lowest: float, off: float
) -> None:
    """Of a polynomial that turns at given times, and is `off` at its lowest."""
    antiderivative = np.polynomial.Polynomial.fromroots(turns).integ()
    p = (antiderivative - antiderivative(lowest) + off).coef
    degree, error = len(p) - 1, 1e-5
    slope = slope_of(p)
    time = first_fall(p, slope, degree, lowest + 1.0, error)
    if off > error:
        assert time == NEVER
    elif off > -error:
        assert math.isnan(time)
    else:
        roots = np.polynomial.polynomial.polyroots(p)
        assert time == pytest.approx(roots[(abs(roots.imag) < 1e-9) & (roots.real > 0)].real.min())


@given(st.floats(0.1, 3.0), st.floats(-3.0, 3.0), st.floats(1e-12, 1e-5))
def test_what_rises_from_zero_falls_only_later(rate: float, bend: float, error: float) -> None:
    """As from the ground, whether it curves up or down: of ``t (rate + bend t - t²)``."""
    p = np.array([0.0, rate, bend, -1.0])
    zero = (bend + math.sqrt(bend * bend + 4.0 * rate)) / 2.0
    slope = slope_of(p)
    time = first_fall(p, slope, 3, zero + 1.0, error)
    assert time == pytest.approx(zero, rel=1e-9)


def test_a_root_where_the_bound_on_the_curvature_vanishes() -> None:
    """Of ``1/10 - t + t²/2 - t³/6``, of which -p'' = t - 1 is at most 0 up to 1."""
    p = np.array([0.1, -1.0, 0.5, -1 / 6])
    slope = slope_of(p)
    assert downward(slope, 2, 1.0) == 0.0
    time = first_fall(p, slope, 3, 1.0, 1e-13)
    truth = np.polynomial.polynomial.polyroots(p)
    assert time == pytest.approx(truth[abs(truth.imag) < 1e-9].real.min(), rel=1e-12)


def test_a_root_beyond_the_end_is_none() -> None:
    p, slope, degree = polynomial(1.01, 1.5, -2.0)
    bend = curvature(slope, degree - 1, 1.0)
    assert first_zero(p, slope, degree, 1.0, 0.0, 0.0, 1.0, bend) == NEVER


def test_three_roots_in_one_are_refused() -> None:
    p, slope, degree = polynomial(0.5, 0.5, 0.5)
    bend = curvature(slope, degree - 1, 1.0)
    assert math.isnan(first_zero(p, slope, degree, 1.0, 0.0, 0.0, 1.0, bend))


def test_a_dip_within_the_error_is_in_doubt() -> None:
    p, slope, degree = polynomial(1.0, 1.0, -2.0)
    for lift, verdict in ((1e-3, NEVER), (1e-9, math.nan), (-1e-9, math.nan), (-1e-3, 0.98174)):
        raised = p.copy()
        raised[0] += lift
        time = first_fall(raised, slope, degree, 2.0, 1e-6)
        assert time == pytest.approx(verdict, abs=1e-4, nan_ok=True)


def test_without_an_error_nothing_is_in_doubt() -> None:
    """A value that only touches zero falls to it there; three roots in one are told as such."""
    p, slope, degree = polynomial(0.5, 0.5)
    assert first_fall(p, slope, degree, 1.0, 0.0) == pytest.approx(0.5, abs=1e-7)
    p, slope, degree = polynomial(0.5, 0.5, 0.5)
    assert math.isnan(first_fall(p, slope, degree, 1.0, 0.0))


def test_the_second_dip_counts_when_the_first_is_too_shallow() -> None:
    p, slope, degree = polynomial(0.5, 0.5, 1.5, 1.6)
    p[0] += 1e-4
    time = first_fall(p, slope, degree, 2.0, 1e-6)
    assert time == pytest.approx(1.5, abs=0.01)


# --- accuracy, asked for and delivered ------------------------------------------------------------


def test_landings_of_every_tolerance_lie_that_close_to_proven_ones(nightly: bool) -> None:
    """Within the tolerance and, for the rounding, the engine's own statement of its error.

    Nor are they much closer than a tolerance that is coarse: digits would be paid for and not used.
    """
    rng, n = np.random.default_rng(6), 40 if nightly else 8
    speeds, rises = rng.uniform(15, 55, n), np.radians(rng.uniform(-5, 89, n))
    scenes: list[Scene] = [
        FlightScene(
            id="any",
            launch=Launch(
                position=(0.0, 0.0, 1.0),
                velocity=(speed * math.cos(rise), 0.0, speed * math.sin(rise)),
            ),
        )
        for speed, rise in zip(speeds, rises, strict=True)
    ]

    def distances(results: Any) -> Any:
        return np.array([float(result.landing.distance) for result in results])

    truth = distances(solve(scene, Enclosure(20)) for scene in scenes)
    rounding = Batch(1e-14).flight_error
    for tolerance in 10.0 ** -np.arange(4.0, 15.0, 1.0 if nightly else 2.0):
        error = np.abs(distances(Batch(tolerance).solve_all(scenes)) - truth)
        assert (error < tolerance + rounding * truth).all(), tolerance
        assert tolerance < 1e-11 or error.max() > tolerance / 1e4, tolerance


# --- what has no answer ---------------------------------------------------------------------------


def test_a_graze_is_an_error_with_its_margin() -> None:
    """Where the pitch is all but level, the touching ends at an offset of R + r_b."""
    low, high = 0.06, 0.08
    while True:
        offset = (low + high) / 2
        scene = AtBatScene(id="graze", swing=Swing(height_offset=offset))
        (result,) = Batch().solve_all([scene])
        if result.error is not None:
            break
        low, high = (low, offset) if result.outcome == "missed" else (offset, high)
    assert "cannot be decided in double precision" in result.error
    assert result.plate is not None
    assert result.contact is not None
    assert abs(result.contact.margin) < 1e-14
    alone = solve_columns(AtBatScene(id="any"), {"swing.height_offset": [offset, 0.0]})
    assert list(alone["outcome"]) == ["", "batted"]


@pytest.mark.parametrize(
    ("height", "outcome"), [(1e-17, None), (1.9e-14, None), (2.1e-14, "airborne")]
)
@pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
def test_a_ball_that_glides_within_the_error_of_the_ground_is_an_error(
    engine: Engine, height: float, outcome: str | None
) -> None:
    """Level and without gravity; the error after 60 s is said to be 2e-14 m."""
    scene = FlightScene(
        id="glide",
        gravity=0.0,
        air=None,
        launch=Launch(position=(0.0, 0.0, height), velocity=(30.0, 0.0, 0.0)),
    )
    result = solve(scene, engine)
    assert result.outcome == outcome
    assert outcome or "lies within its error 2e-14" in str(result.error)


@pytest.mark.parametrize(
    ("rise", "later", "outcome"),
    [
        (4.9, -5e-15, "airborne"),  # 2.5e-14 m above the ground
        (4.9, -3e-15, None),
        (4.9, 0.0, None),
        (4.9, 1.9e-14, None),
        (4.9, 2.1e-14, "landed"),
        (19.6, -3e-15, "airborne"),
        (19.6, -1e-15, None),
        (19.6, 7e-14, None),
        (19.6, 9e-14, "landed"),
    ],
)
@pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
def test_a_parabola_that_ends_within_the_error_of_the_time_limit_is_an_error(
    engine: Engine, rise: float, later: float, outcome: str | None
) -> None:
    """It takes 1 s, or 4 s; the errors are 2e-14 m, and as large a part of the time limit."""
    scene = FlightScene(
        id="tie",
        air=None,
        time_limit=rise / 4.9 + later,
        launch=Launch(position=(0.0, 0.0, 0.0), velocity=(3.0, 0.0, rise)),
    )
    result = solve(scene, engine)
    assert result.outcome == outcome
    assert outcome or "the ground in the time limit cannot be decided" in str(result.error)


@pytest.mark.parametrize(("share", "outcome"), [(0.2, None), (1.5, "landed")])
@pytest.mark.parametrize("sink", [1e-3, 1e-4])
def test_a_ball_that_sinks_slowly_at_the_time_limit_is_an_error(
    sink: float, share: float, outcome: str | None
) -> None:
    """Of its way of 200 m eight half ulps are kept in the height, which it sinks through in time.

    Those of the place where its last step begins, which is not quite as far.
    """
    scene = FlightScene(
        id="sink",
        gravity=0.0,
        air=Air(lift_coefficient=0.0),
        launch=Launch(position=(0.0, 0.0, 4 * sink), velocity=(60.0, 0.0, -sink)),
    )
    landing = solve(scene, Batch()).landing
    assert landing is not None
    kept = 8 * 2.0**-53 * float(landing.position[0]) / abs(float(landing.velocity[2]))
    limit = float(landing.time) + share * kept
    result = solve(scene.model_copy(update={"time_limit": limit}), Batch())
    assert result.outcome == outcome
    assert outcome or "in the time limit cannot be decided" in str(result.error)


def test_a_circle_that_comes_back_to_the_ground_where_it_left_it_is_an_error() -> None:
    """Without gravity the path is a circle, here one that the ground is a tangent to."""
    scene = FlightScene(
        id="circle",
        gravity=0.0,
        air=Air(drag_coefficient=0.0, lift_coefficient=0.7),
        launch=Launch(position=(0.0, 0.0, 0.0), velocity=(45.0, 0.0, 0.0)),
    )
    (result,) = Batch().solve_all([scene])
    assert result.error is not None
    assert "whether the ball touches the ground cannot be decided" in result.error


@pytest.mark.parametrize("size", [1e20, 1e30, 1e10])
@pytest.mark.sampled(every=3)
def test_sizes_that_overflow_have_the_same_answer_in_a_list_as_alone(
    size: float, nightly: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not nightly:  # what takes over 20,000 steps takes over 300
        monkeypatch.setattr("longball.engines.ivp._MANY_STEPS", 150)
        monkeypatch.setattr("longball.engines.ivp._MOST_STEPS", 300)
    flying = {"position": (0.0, 0.0, 1.0), "velocity": (size, 0.0, size)}
    scenes: list[Scene] = [
        FlightScene(id="fast", launch=Launch(**flying)),
        FlightScene(id="free", air=None, launch=Launch(**flying)),
        FlightScene(id="thick", air=Air(density=size), launch=Launch(**flying)),
        PitchScene(id="thrown", pitch=Pitch(speed=size)),
        AtBatScene(id="batted", pitch=Pitch(speed=size)),
        AtBatScene(id="swung", swing=Swing(angular_speed=size)),
        AtBatScene(id="heavy", ball=Ball(mass=size)),
    ]
    assert Batch().solve_all(scenes) == [solve(scene, Batch()) for scene in scenes]


@pytest.mark.parametrize(
    ("scene", "error"),
    [
        # It flies at 79° to the bat: where it touches, it is 0.3 m from the plate's plane.
        (AtBatScene(id="beside", pitch=Pitch(speed=60.0, release=(2.0, -10.0, 1.8))), 1e-13),
        # The search begins 0.25 m before the plate; from 0.24 m the ball has passed that place.
        *(
            (AtBatScene(id="near", pitch=Pitch(release=(x, 0.0, 1.8), aim=(0.0, 1.8))), 1e-13)
            for x in (0.24, 0.25, 0.26)
        ),
        # From there the square of a reach of 2e-8 m is below all roundings. A height of 1.8 m is
        # known to 2e-16 m, which is 1e-8 of the reach; some times over.
        (
            AtBatScene(
                id="thin",
                ball=Ball(radius=1e-8),
                bat=Bat(radius=1e-8),
                swing=Swing(height_offset=1e-8),
            ),
            2e-7,
        ),
    ],
)
def test_where_the_search_for_the_bat_begins(scene: AtBatScene, error: float) -> None:
    result, proven = solve(scene, Batch()), solve(scene, Enclosure(20))
    found, truth = result.contact, proven.contact
    assert result.outcome == proven.outcome
    assert found is not None
    assert truth is not None
    assert found.time == pytest.approx(float(truth.time), rel=min(error, 1e-13))
    assert found.normal == pytest.approx([*map(float, truth.normal)], abs=error)


@pytest.mark.parametrize("sideways", [1e-10, 1e-15, 1e-20, 1e-30])
@pytest.mark.parametrize("up", [40.0, 0.0])
@pytest.mark.parametrize("lift", [0.0, 0.2])
@pytest.mark.sampled(every=5)
def test_a_ball_that_is_all_but_vertical(sideways: float, up: float, lift: float) -> None:
    """cos(π/2) is 6e-17: at the apex the ball has that part of its speed."""
    scene = FlightScene(
        id="pop-up",
        air=Air(lift_coefficient=lift),
        launch=Launch(position=(0.0, 0.0, 50.0), velocity=(sideways, 0.0, up)),
    )
    truth = solve(scene, Enclosure(18)).landing
    assert truth is not None
    heights = []
    for engine in (Batch(), Ivp()):
        result, way = solve_with_path(scene, engine)
        assert result.landing is not None
        assert result.landing.time == pytest.approx(float(truth.time), rel=3e-15)
        assert result.landing.distance == pytest.approx(float(truth.distance), rel=1e-14)
        heights.append([way.at(part * float(truth.time))[0][2] for part in (0.2, 0.5, 0.9)])
    assert heights[0] == pytest.approx(heights[1], rel=1e-13)
    assert Batch().solve_all([scene] * 20) == [solve(scene, Batch())] * 20


def test_straight_up_and_down() -> None:
    """Up for atan(r)/√(g k), r = √(k/g) V, and down for asinh(r)/√(g k), to V/√(1 + r²)."""
    for speed, density, g in product((0.5, 1.0, 20.0), (1.29, 1000.0), (1e-8, 9.8, 1e6)):
        air = Air(density=density, lift_coefficient=0.0)
        pace = speed * math.sqrt(g / 9.8)  # the same flight at another pace
        launch = Launch(position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, pace))
        scene = FlightScene(id="up", air=air, gravity=g, launch=launch, time_limit=1e6)
        found = solve(scene, Batch()).landing
        k = density * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
        r = math.sqrt(k / g) * pace
        assert found is not None
        time = (math.atan(r) + math.asinh(r)) / math.sqrt(g * k)
        assert found.time == pytest.approx(time, rel=1e-14)
        assert found.velocity == (0.0, 0.0, pytest.approx(-pace / math.hypot(1.0, r), rel=1e-13))


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 30.0), (0.0, 0.0, 0.0), (1e-30, 0.0, 20.0)])
def test_a_flight_through_rest_is_left_to_the_scalar_engine(velocity: Any) -> None:
    """The result names it, alone, in a list and in columns."""
    launch = Launch(position=(0.0, 0.0, 50.0), velocity=velocity)
    scene = FlightScene(id="rests", air=Air(lift_coefficient=0.0), launch=launch)
    expected = solve(scene, Ivp())
    assert expected.engine == "ivp Taylor"
    assert Batch().solve_all([scene] * 20) == [expected] * 20
    table = solve_columns(scene, {"launch.position[2]": [50.0, 51.0]})
    assert table["engine"].tolist() == ["ivp Taylor"] * 2
    assert expected.landing is not None
    assert table["landing.time"][0] == expected.landing.time


def test_a_fall_from_rest_that_outlasts_the_time_limit() -> None:
    """It falls by ln cosh(√(g k) t)/k."""
    height, k = 3000.0, 1.29 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    scene = FlightScene(
        id="drop",
        air=Air(lift_coefficient=0.0),
        launch=Launch(position=(0.0, 0.0, height), velocity=(0.0, 0.0, 0.0)),
    )
    result, way = solve_with_path(scene, Batch())
    assert result.outcome == "airborne"
    fall = math.log(math.cosh(math.sqrt(9.8 * k) * 60.0)) / k
    assert way.at(60.0)[0][2] == pytest.approx(height - fall, rel=1e-13)
    assert {found.outcome for found in Batch().solve_all([scene] * 20)} == {"airborne"}


@pytest.mark.parametrize("gravity", [1e-3, 0.5, 9.8])
@pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
def test_a_hop_in_little_gravity(engine: Engine, gravity: float) -> None:
    """Without air it is over after 2 w/g."""
    rise = 1e-4 * gravity
    launch = Launch(position=(0.0, 0.0, 0.0), velocity=(1.0, 0.0, rise))
    scene = FlightScene(id="hop", air=None, gravity=gravity, launch=launch)
    found = solve(scene, engine).landing
    assert found is not None
    assert found.time == pytest.approx(2 * rise / gravity, rel=1e-12)


def test_a_ball_that_all_but_rests_in_the_air_is_solved_or_refused_never_wrong() -> None:
    """At its apex the ball has a millionth of its speed; the steps shrink, and grow again."""
    strengths = {"drag": 0.0074867, "gravity": 9.8}
    straight = landing(strengths, PlaneState(0.0, 0.0, 0.0, 20.0))
    for u in (1e-3, 1e-6, 1e-9, 1e-12):
        end = landing(strengths, PlaneState(0.0, 0.0, u, 20.0))
        assert end.time == pytest.approx(straight.time, abs=u * u + 1e-13)
        assert 0.0 < end.state.s < 4.0 * u


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"pitch.sped": [36.0]}, "the nearest are pitch.speed"),
        ({"pitch.speed": [36.0, math.nan]}, "finite"),
        ({"pitch.speed": [36.0, 37.0], "swing.tilt": [0.1]}, "2 finite numbers"),
    ],
)
def test_columns_that_are_none_are_refused(columns: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        solve_columns(AtBatScene(id="any"), columns)


def test_a_flight_that_ends_nowhere_is_not_airborne():
    # Thrown into air as dense as a star, straight up by the lift: at last the series overflow.
    scene = parse_scene(
        '{"id":"x","kind":"pitch","reading":{"lift_direction":"always_up"},"gravity":7.8e25,'
        '"ball":{"mass":2.4e-6,"radius":0.0062},"pitch":{"speed":9.4e13,'
        '"release":[3e-8,0.14,0.0063],"aim":[2e19,217506]},'
        '"air":{"density":3.8e6,"drag_coefficient":0.033,"lift_coefficient":0.51}}'
    )
    assert solve(scene, create("batch")).outcome != "airborne"
