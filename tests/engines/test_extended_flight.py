"""The extended model of flight by Verlet's scheme, and what has no answer in any engine.

Golden data and the oracle (`test_golden.py`, `test_against_oracle.py`) hold the other engines to
all laws, winds and readings. They do not ask the scheme, whose law is another print of the same
formulas: here it has exact results.
"""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.optimize

from longball.engines.batch import Batch
from longball.engines.chain import solve, solve_with_path
from longball.engines.enclosure import Enclosure
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.verlet import Verlet
from longball.model.scene import FlightScene

SPIN = (20.0, -250.0, 60.0)
RATIONAL = {"law": "rational"}
CRISIS = {"law": "crisis", "per_spin": 7.4e-5}
TABLE = {"law": "table", "of": "speed", "at": (20.0, 30.0, 40.0), "values": (0.5, 0.45, 0.33)}

# Error of a position, relative to a flight of 100 m: Δt² times a few hundred m/s².
SCHEME, ERROR = Verlet(1e-3, forces="implicit"), 3e-6


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


def test_the_magnus_force_does_no_work():
    """V²/2 + g z is kept where nothing drags."""
    air = {"drag_coefficient": 0.0, "lift_coefficient": RATIONAL}
    flight = scene(spin=SPIN, air=air)
    found = landing(flight, SCHEME)
    kept = np.dot(found.velocity, found.velocity) / 2
    start = np.dot(flight.launch.velocity, flight.launch.velocity) / 2 + 9.8 * 1.0
    assert kept == pytest.approx(start, rel=10 * ERROR)


def test_spin_decays_along_the_path():
    air = {"lift_coefficient": RATIONAL, "spin_decay_length": 150.0, "wind": (4.0, 0.0, 0.0)}
    found = landing(scene(spin=SPIN, air=air), SCHEME)
    assert found.spin == pytest.approx(np.array(SPIN) * math.exp(-found.path / 150.0), rel=1e-14)
    assert 80.0 < found.path < 150.0


def test_a_constant_wind_carries_the_flight_along():
    """r(t; v, W) = r(t; v - W, 0) + W t: the hang time is that of v - W, with a level wind."""
    air = {"lift_coefficient": RATIONAL, "drag_coefficient": CRISIS}
    windy = landing(scene((40.0, 3.0, 20.0), SPIN, air=air | {"wind": (6.0, -3.0, 0.0)}), SCHEME)
    calm = landing(scene((34.0, 6.0, 20.0), SPIN, air=air), SCHEME)
    assert windy.time == pytest.approx(calm.time, rel=10 * ERROR)
    carried = calm.position + np.array([6.0, -3.0, 0.0]) * calm.time
    assert windy.position == pytest.approx(carried, abs=1000 * ERROR)


def test_a_helix():
    """Without gravity and drag: radius sin²α/(k C_L), rate k C_L V / sin α about the spin."""
    flight = scene(
        (30.0, 0.0, 40.0), (0.0, 0.0, 50.0), air={"drag_coefficient": 0.0}, gravity=0.0,
        position=(0.0, 0.0, 1.0), time_limit=3.0,
    )  # fmt: skip
    k = 1.29 * 0.2 * math.pi * 0.0366**2 / (2 * 0.145)
    sine = 0.6
    rate, radius, t = k * 50.0 / sine, sine**2 / k, 3.0
    wanted = [radius * math.sin(rate * t), radius * (1 - math.cos(rate * t)), 1.0 + 40.0 * t]
    found, _ = state_at(flight, SCHEME, t)
    assert found == pytest.approx(wanted, abs=1000 * ERROR)


def test_braking_and_turning_without_gravity():
    """V = V0/(1 + κt); with c2/(c0 + c1 S) the heading is a logarithm."""
    air = {"drag_coefficient": 0.4, "lift_coefficient": RATIONAL}
    spin, speed, t = 250.0, 40.0, 2.0
    flight = scene((speed, 0.0, 0.0), (0.0, 0.0, spin), air=air, gravity=0.0, time_limit=t)
    per_metre = 1.29 * math.pi * 0.0366**2 / (2 * 0.145)
    κ = per_metre * 0.4 * speed
    c0, c1, c2, surface = 0.583, 2.333, 1.12, 0.0366 * spin
    turned = c2 / (c1 * 0.4) * math.log1p(c1 * surface * κ * t / (c0 * speed + c1 * surface))
    _, velocity = state_at(flight, SCHEME, t)
    assert np.linalg.norm(velocity) == pytest.approx(speed / (1 + κ * t), rel=10 * ERROR)
    heading = math.atan2(velocity[1], velocity[0])
    assert heading == pytest.approx(turned, rel=10 * ERROR)


def test_the_paper_is_level_spin_of_any_size():
    """Constant C_L and spin across the launch: today's equations; no spin: no lift."""
    velocity = (40.0, 0.0, 20.0)
    plain = landing(scene(velocity), SCHEME)
    spun = landing(scene(velocity, (0.0, -123.0, 0.0)), SCHEME)
    assert spun.position == pytest.approx(plain.position, abs=1e-9)
    still = landing(scene(velocity, (0.0, 0.0, 0.0)), SCHEME)
    bare = landing(scene(velocity, air={"lift_coefficient": 0.0}), SCHEME)
    assert still.position.tolist() == bare.position.tolist()


# --- where it is not smooth -----------------------------------------------------------------------


def test_where_the_wind_sets_in_airspeeds_jump_over_nodes():
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
    found = landing(flight, SCHEME)
    # It takes the step that passes the height by the law above it: Δt times 10 m/s.
    error = 1e-2
    assert found.time == pytest.approx(met + left, abs=error)
    assert found.position == pytest.approx(
        20 / 21 * (above + 10.0) * np.array([1, 0, 0]), abs=error
    )


@pytest.mark.parametrize("engine", [Ivp(), Batch()], ids=["ivp", "batch"])
def test_a_flight_in_too_many_pieces_is_declined(engine, monkeypatch):
    monkeypatch.setattr("longball.engines.path_engine._MOST_PIECES", 3)
    result = solve(scene(air={"drag_coefficient": TABLE}), engine)
    assert result.code == "too_long"
    assert "over 3 steps; try a shorter time_limit" in result.error


@pytest.mark.parametrize(
    "engine", [Ivp(), Enclosure(20), Multiprecision(20), Batch(), Verlet(1e-3)]
)
def test_what_has_no_direction_is_declined(engine):
    result = solve(scene((0.0, 0.0, 0.0), SPIN, air={"lift_coefficient": RATIONAL}), engine)
    assert result.error is not None
    assert result.landing is None
