"""The extended model of flight: spin, laws of the coefficients, wind, weather, the Earth.

Exact results and symmetries. That the law is the formula is seen in the golden data and, with all
keys and readings, in `test_against_oracle.py`, by an oracle that shares no line with it.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.optimize

from longball.engines.batch import Batch, solve_columns
from longball.engines.chain import solve, solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import Verlet
from longball.model.scene import FlightScene

SPIN = (20.0, -250.0, 60.0)
RATIONAL = {"law": "rational"}
SPIN_DRAG = {"law": "spin"}
CRISIS = {"law": "crisis", "per_spin": 7.4e-5}
TABLE = {"law": "table", "of": "speed", "at": (20.0, 30.0, 40.0), "values": (0.5, 0.45, 0.33)}

# Engines that evaluate the law each in its own way; `test_golden.py` compares the others. Each has
# the error of a position, relative to a flight of 100 m: what the engine states, and of Verlet's
# scheme Δt² times a few hundred m/s².
ENGINES = [
    pytest.param(Ivp(), 1e-13, id="ivp"),
    pytest.param(Batch(), 1e-13, id="batch"),
    pytest.param(Verlet(1e-3, forces="implicit"), 3e-6, id="verlet"),
]
all_engines = pytest.mark.parametrize(("engine", "error"), ENGINES)


def scene(velocity=(40.0, 3.0, 20.0), spin=None, position=(0.5, 0.1, 1.0), **keys):
    keys = {name: value for name, value in keys.items() if value is not None}
    launch = {"position": position, "velocity": velocity, "spin": spin}
    return FlightScene(id="x", launch=launch, **keys)


def landing(flight, engine):
    result = solve(flight, engine)
    assert result.error is None
    found = result.landing
    return SimpleNamespace(
        time=float(found.time),
        position=np.array([*map(float, found.position)]),
        velocity=np.array([*map(float, found.velocity)]),
        spin=None if found.spin is None else np.array([*map(float, found.spin)]),
        path=None if found.path is None else float(found.path),
    )


def state_at(flight, engine, time):
    _, path = solve_with_path(flight, engine)
    position, velocity = path.at(engine.numbers.exact(time))
    return np.array([*map(float, position)]), np.array([*map(float, velocity)])


# --- exact results --------------------------------------------------------------------------------


@pytest.mark.parametrize("drag", [0.35, TABLE], ids=["one form", "table"])
def test_steps_that_end_below_the_ground_of_a_logarithmic_wind(drag):
    """There the profile has no value. The flight before it converges to the true one."""
    wind = {"velocity": (4.0, -3.0, 0.0), "height": 10.0, "roughness": 0.01}
    flight = scene(spin=SPIN, air={"drag_coefficient": drag, "wind": wind})
    truth = landing(flight, Ivp())
    for dt, error in ((0.05, 5e-2), (2e-3, 5e-4)):
        found = landing(flight, Verlet(dt, forces="predicted_recomputed"))
        assert found.position == pytest.approx(truth.position, abs=error)
        assert found.velocity == pytest.approx(truth.velocity, abs=error)


@all_engines
def test_the_magnus_force_does_no_work(engine, error):
    """V²/2 + g z is kept where nothing drags."""
    air = {"drag_coefficient": 0.0, "lift_coefficient": RATIONAL}
    flight = scene(spin=SPIN, air=air)
    found = landing(flight, engine)
    kept = np.dot(found.velocity, found.velocity) / 2
    start = np.dot(flight.launch.velocity, flight.launch.velocity) / 2 + 9.8 * 1.0
    assert kept == pytest.approx(start, rel=10 * error)


@all_engines
def test_spin_decays_along_the_path(engine, error):
    air = {"lift_coefficient": RATIONAL, "spin_decay_length": 150.0, "wind": (4.0, 0.0, 0.0)}
    found = landing(scene(spin=SPIN, air=air), engine)
    assert found.spin == pytest.approx(np.array(SPIN) * math.exp(-found.path / 150.0), rel=1e-14)
    assert 80.0 < found.path < 150.0


@all_engines
def test_a_constant_wind_carries_the_flight_along(engine, error):
    """r(t; v, W) = r(t; v - W, 0) + W t: the hang time is that of v - W, with a level wind."""
    air = {"lift_coefficient": RATIONAL, "drag_coefficient": CRISIS}
    windy = landing(scene((40.0, 3.0, 20.0), SPIN, air=air | {"wind": (6.0, -3.0, 0.0)}), engine)
    calm = landing(scene((34.0, 6.0, 20.0), SPIN, air=air), engine)
    assert windy.time == pytest.approx(calm.time, rel=10 * error)
    carried = calm.position + np.array([6.0, -3.0, 0.0]) * calm.time
    assert windy.position == pytest.approx(carried, abs=1000 * error)


@all_engines
def test_mirror_and_rotation(engine, error):
    air = {"lift_coefficient": RATIONAL, "drag_coefficient": SPIN_DRAG}
    plain = landing(scene(spin=SPIN, air=air | {"wind": (3.0, 2.0, 0.5)}), engine)
    x, y, z = SPIN
    mirrored = scene(
        (40.0, -3.0, 20.0), (-x, y, -z), (0.5, -0.1, 1.0), air=air | {"wind": (3.0, -2.0, 0.5)}
    )
    assert landing(mirrored, engine).position * (1, -1, 1) == pytest.approx(
        plain.position, abs=1000 * error
    )
    cos, sin = math.cos(0.7), math.sin(0.7)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])

    def turned(vector):
        return tuple((turn @ vector).tolist())

    rotated = scene(
        turned((40.0, 3.0, 20.0)),
        turned(SPIN),
        turned((0.5, 0.1, 1.0)),
        air=air | {"wind": turned((3.0, 2.0, 0.5))},
    )
    assert landing(rotated, engine).position == pytest.approx(
        turn @ plain.position, abs=1e-12 + 1000 * error
    )


@all_engines
def test_scaling(engine, error):
    """Lengths λ, times √λ, k/λ: U_c, δ and W as √λ, L_ω as λ; R ω as √λ with the same R."""
    λ = 4.0
    root = 2.0

    def flight(λ, root):
        air = {
            "density": 1.29 / λ,
            "lift_coefficient": RATIONAL,
            "drag_coefficient": CRISIS
            | {"speed": 31.4 * root, "width": 3.0 * root, "per_spin": 7.4e-5 / root},
            "wind": (3.0 * root, 2.0 * root, 0.0),
            "spin_decay_length": 300.0 * λ,
        }
        velocity = (40.0 * root, 3.0 * root, 20.0 * root)
        spin = tuple(x * root for x in SPIN)
        return scene(velocity, spin, (0.5 * λ, 0.1 * λ, 1.0 * λ), air=air)

    if isinstance(engine, Verlet):
        pytest.skip("a fixed step does not scale with the times")
    plain, scaled = landing(flight(1.0, 1.0), engine), landing(flight(λ, root), engine)
    assert scaled.position == pytest.approx(plain.position * λ, abs=1e-11)
    assert scaled.time == pytest.approx(plain.time * root, rel=1e-12)


@all_engines
def test_a_helix(engine, error):
    """Without gravity and drag: radius sin²α/(k C_L), rate k C_L V / sin α about the spin."""
    flight = scene(
        (30.0, 0.0, 40.0), (0.0, 0.0, 50.0), air={"drag_coefficient": 0.0}, gravity=0.0,
        position=(0.0, 0.0, 1.0), time_limit=3.0,
    )  # fmt: skip
    k = 1.29 * 0.2 * math.pi * 0.0366**2 / (2 * 0.145)
    sine = 0.6
    rate, radius, t = k * 50.0 / sine, sine**2 / k, 3.0
    wanted = [radius * math.sin(rate * t), radius * (1 - math.cos(rate * t)), 1.0 + 40.0 * t]
    found, _ = state_at(flight, engine, t)
    assert found == pytest.approx(wanted, abs=1e-12 + 1000 * error)


@all_engines
def test_braking_and_turning_without_gravity(engine, error):
    """V = V0/(1 + κt); with c2/(c0 + c1 S) the heading is a logarithm."""
    air = {"drag_coefficient": 0.4, "lift_coefficient": RATIONAL}
    spin, speed, t = 250.0, 40.0, 2.0
    flight = scene((speed, 0.0, 0.0), (0.0, 0.0, spin), air=air, gravity=0.0, time_limit=t)
    per_metre = 1.29 * math.pi * 0.0366**2 / (2 * 0.145)
    κ = per_metre * 0.4 * speed
    c0, c1, c2, surface = 0.583, 2.333, 1.12, 0.0366 * spin
    turned = c2 / (c1 * 0.4) * math.log1p(c1 * surface * κ * t / (c0 * speed + c1 * surface))
    _, velocity = state_at(flight, engine, t)
    assert np.linalg.norm(velocity) == pytest.approx(speed / (1 + κ * t), rel=10 * error + 1e-14)
    heading = math.atan2(velocity[1], velocity[0])
    assert heading == pytest.approx(turned, rel=1e-13 + 10 * error)


@all_engines
def test_gyro_spin_straight_up_does_nothing(engine, error):
    air = {"lift_coefficient": RATIONAL, "drag_coefficient": 0.4}
    spun = landing(scene((0.0, 0.0, 30.0), (0.0, 0.0, 200.0), air=air), engine)
    plain = landing(scene((0.0, 0.0, 30.0), air=air | {"lift_coefficient": 0.0}), engine)
    assert spun.time == pytest.approx(plain.time, rel=1e-14)
    assert spun.velocity == pytest.approx(plain.velocity, rel=1e-14)


@all_engines
def test_a_launch_from_the_ground_at_the_speed_of_a_wind_that_rises(engine, error):
    """At rest in the air it falls there by ln cosh(√(g k) t)/k, while the air rises."""
    rise, k = 6.0, 1.29 * 0.4 * math.pi * 0.0366**2 / (2 * 0.145)
    air = {"lift_coefficient": 0.0, "wind": (0.0, 0.0, rise)}
    found = landing(scene((0.0, 0.0, rise), position=(0.0, 0.0, 0.0), air=air), engine)
    time = scipy.optimize.brentq(
        lambda t: rise * t - math.log(math.cosh(math.sqrt(9.8 * k) * t)) / k, 0.5, 3.0, xtol=1e-14
    )
    assert found.time == pytest.approx(time, rel=1e-13 + 10 * error)


@all_engines
def test_the_final_speed_in_a_drag_crisis(engine, error):
    """k C_D(U) U² = g."""
    drag = {"law": "crisis"}
    fall = scene(
        (0.0, 0.0, -30.0), position=(0.0, 0.0, 3000.0), time_limit=200.0,
        air={"drag_coefficient": drag, "lift_coefficient": 0.0},
    )  # fmt: skip
    speed = -landing(fall, engine).velocity[2]
    value = 0.33 + (0.5 - 0.33) / (1.0 + math.exp((speed - 31.4) / 3.0))
    per_metre = 1.29 * math.pi * 0.0366**2 / (2 * 0.145)
    assert per_metre * value * speed**2 == pytest.approx(9.8, rel=1e-9)


@all_engines
def test_the_paper_is_level_spin_of_any_size(engine, error):
    """Constant C_L and spin across the launch: today's equations; no spin: no lift."""
    velocity = (40.0, 0.0, 20.0)
    plain = landing(scene(velocity), engine)
    spun = landing(scene(velocity, (0.0, -123.0, 0.0)), engine)
    assert spun.position == pytest.approx(plain.position, abs=1e-12 + 1e-9 * (error > 1e-9))
    still = landing(scene(velocity, (0.0, 0.0, 0.0)), engine)
    bare = landing(scene(velocity, air={"lift_coefficient": 0.0}), engine)
    assert still.position.tolist() == bare.position.tolist()


# --- where it is not smooth -----------------------------------------------------------------------


@all_engines
def test_where_the_wind_sets_in_airspeeds_jump_over_nodes(engine, error):
    """Without weight, along a wind aloft that ends in still air: 1/U grows by κ a second."""
    radius, mass, fall, blows, above = 0.0366, 0.145, 29.0, 10.0, 10.0
    way = np.array([20.0, 0.0, -21.0]) / fall
    # From U = 19, below both nodes, to beyond both, and towards them from there.
    drag = {"law": "table", "of": "speed", "at": (20.0, 22.0), "values": (0.6, 0.2)}
    flight = scene(
        tuple(fall * way),
        position=(0.0, 0.0, above + 10.0),
        ball={"mass": mass, "radius": radius},
        gravity=0.0,
        air={
            "density": 1.2,
            "drag_coefficient": drag,
            "lift_coefficient": 0.0,
            "wind": {"velocity": tuple(blows * way), "above": above},
        },
    )
    unit = 1.2 * math.pi * radius**2 / (2 * mass)
    slow, fast = 0.6 * unit, 0.2 * unit

    def drifted(t):
        return math.log1p(slow * (fall - blows) * t) / slow + blows * t - 10.0 / -way[2]

    met = scipy.optimize.brentq(drifted, 0.0, 1.0, xtol=1e-15, rtol=1e-15)
    speed = (fall - blows) / (1 + slow * (fall - blows) * met) + blows
    left = math.expm1(fast * above / -way[2]) / (fast * speed)
    assert speed > speed / (1 + fast * speed * left) > 22.0
    found = landing(flight, engine)
    # Verlet's scheme takes the step that passes the height by the law above it: Δt times 10 m/s.
    error = 1e-2 if isinstance(engine, Verlet) else 100 * error
    assert found.time == pytest.approx(met + left, abs=error)
    assert found.position == pytest.approx(
        20 / 21 * (above + 10.0) * np.array([1, 0, 0]), abs=error
    )


@all_engines
def test_a_table_of_one_value_is_a_constant(engine, error):
    flat = TABLE | {"values": (0.4, 0.4, 0.4)}
    plain, table = (landing(scene(air={"drag_coefficient": drag}), engine) for drag in (0.4, flat))
    assert table.position == pytest.approx(plain.position, abs=1e-11)


@pytest.mark.parametrize("engine", [Ivp(), Batch()], ids=["ivp", "batch"])
def test_a_flight_in_too_many_pieces_is_declined(engine, monkeypatch):
    monkeypatch.setattr("longball.engines.path_engine._MOST_PIECES", 3)
    result = solve(scene(air={"drag_coefficient": TABLE}), engine)
    assert result.code == "too_long"
    assert "over 3 steps; try a shorter time_limit" in result.error


@pytest.mark.parametrize("engine", [Ivp(), Enclosure(20), Multiprecision(20), Batch()])
def test_a_ball_that_drifts_with_the_wind(engine):
    """It falls as it would in still air."""
    air = {"wind": (8.0, 0.0, 0.0), "lift_coefficient": 0.0}
    drifting = landing(scene((8.0, 0.0, 5.0), air=air), engine)
    still = landing(scene((0.0, 0.0, 5.0), air={"lift_coefficient": 0.0}), engine)
    assert drifting.time == still.time
    assert drifting.position[0] == pytest.approx(0.5 + 8.0 * still.time, rel=1e-15)


@pytest.mark.parametrize(
    "engine", [Ivp(), Enclosure(20), Multiprecision(20), Batch(), Verlet(1e-3)]
)
def test_what_has_no_direction_is_declined(engine):
    result = solve(scene((0.0, 0.0, 0.0), SPIN, air={"lift_coefficient": RATIONAL}), engine)
    assert result.error is not None
    assert result.landing is None


@pytest.mark.parametrize("engine", [Ivp(), Batch()], ids=["ivp", "batch"])
def test_a_spin_along_the_launch_is_flown(engine):
    """ω ∥ u at the launch alone: lift and drag have a corner there, and not beyond."""
    flight = scene((40.0, 0.0, 20.0), (80.0, 0.0, 40.0), air={"lift_coefficient": RATIONAL})
    assert landing(flight, engine).position == pytest.approx(
        landing(flight, Enclosure(20)).position, abs=1e-11
    )


def test_columns_are_scenes():
    air = {"lift_coefficient": RATIONAL, "wind": (3.0, 2.0, 0.5)}
    flight = scene(spin=SPIN, air=air)
    table = solve_columns(flight, {"launch.spin[1]": [-200.0, -100.0], "air.wind[0]": [0.0, 3.0]})
    for i, (spin, wind) in enumerate(((-200.0, 0.0), (-100.0, 3.0))):
        one = scene(spin=(20.0, spin, 60.0), air=air | {"wind": (wind, 2.0, 0.5)})
        alone = landing(one, Batch())
        assert [table[f"landing.position[{k}]"][i] for k in range(3)] == alone.position.tolist()
