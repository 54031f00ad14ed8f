"""The batch engine: held to high precision, to the ivp engine, and to itself, bit for bit."""

from __future__ import annotations

import math
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
from longball.engines.batch.expansion import Layout
from longball.engines.batch.jit import call, unowned_views
from longball.engines.batch.roots import NEVER
from longball.engines.batch.writer import WIDTH, aligned
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.series import recurrence
from longball.model import trace
from longball.model.law import Law, law_with
from longball.model.numbers import DOUBLES
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    FlightScene,
    Launch,
    Pitch,
    PitchScene,
    Scene,
    Swing,
    parse_scene,
)

# What only compiled functions can call, for Python to call.
first_fall, curvature, downward, differentiate = (
    numba.njit(function.py_func, error_model="numpy")  # type: ignore[attr-defined]
    for function in (
        roots.first_fall,
        roots.curvature,
        roots.downward,
        roots.differentiate,
    )
)

PAPER = {"drag": 0.0074867, "lift": 0.0037433, "gravity": 9.8}


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
    layout = Layout(law.program)
    x = layout.allocate(order)
    x[: len(states), 0] = states
    for i, name in enumerate(law.program.parameters):
        x[layout.parameters, i] = law.strengths[name]
    functions = aligned(1, len(states) + 2, WIDTH)

    @numba.njit
    def step(address: int, x: Any, functions: Any, order: int, rows: int) -> int:
        at = unowned_views((x, functions))
        return call(address, (at[0], at[1], order, rows, 1, 1e-14))

    step(expansion.step(law.program).address, x.ravel(), functions.ravel(), order, x.shape[1])
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
    step = Layout(law.program).step
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


# --- roots ----------------------------------------------------------------------------------------


def slope_of(p: Any) -> Any:
    """Return the derivative of a polynomial, with a zero behind it."""
    slope = np.full(len(p), math.nan)
    differentiate(p, len(p) - 1, slope)
    return slope


@given(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=6), st.floats(0.1, 2.0))
def test_no_curvature_is_beyond_its_bounds(coefficients: list[float], end: float) -> None:
    slope = np.array(coefficients)
    times = np.linspace(0.0, end, 50)
    bends = np.polynomial.polynomial.polyval(times, np.polynomial.polynomial.polyder(slope))
    rounding = 1e-14 * (np.abs(slope) * np.arange(len(slope)) * max(1.0, end) ** 5).sum()
    assert np.abs(bends).max() <= curvature(slope, len(slope) - 1, end) + rounding
    assert -bends.min() <= downward(slope, len(slope) - 1, end) + rounding
    assert downward(slope, 0, end) == 0.0


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


@pytest.mark.parametrize("up", [0.0, 10.0])
def test_a_ball_that_starts_on_the_ground_is_not_left_to_the_scalar_engine(up: float) -> None:
    """It ends where it starts, or after 2 w/g."""
    launch = Launch(position=(0.0, 0.0, 0.0), velocity=(30.0, 0.0, up))
    found = solve(FlightScene(id="low", air=None, gravity=10.0, launch=launch), Batch())
    assert str(found.engine).startswith("batch")
    assert found.landing is not None
    assert found.landing.time == pytest.approx(up / 5, rel=1e-15)


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
