"""The oracle against exact results: what the engines are held to has to be true.

Its steps are good to 1e-13 each, and a flight takes at most some hundred. What follows from no law
of physics, such as tables and weather, `oracle_check.py` compares with proven values.
"""

import ast
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests import extrapolation, oracle

CLOSE = 1e-12  # ten steps' errors, of values of order 1 to 100

# Every force at once; spin across the motion and along it.
AIR = {
    "density": {"temperature": 300.0, "humidity": 0.6, "elevation": 500.0},
    "drag_coefficient": {"law": "crisis", "per_spin": 1e-4},
    "lift_coefficient": {"law": "rational"},
    "spin_decay_length": 300.0,
}
LAUNCH = {"position": [0.0, 0.0, 1.0], "velocity": [35.0, 8.0, 20.0], "spin": [60.0, -200.0, 50.0]}


def flight(**changes):
    return {"kind": "flight", "launch": LAUNCH, "air": AIR} | changes


def flown(scene, time):
    """State of a flight after a time."""
    launch = scene["launch"]
    law = oracle.Law(oracle.filled(scene), launch["velocity"], launch.get("spin"))
    start = (*launch["position"], *launch["velocity"])
    return oracle.Flight(law, start, -math.inf, time).at(time)


def impact(**changes):
    bat = {"friction": 0.5, "tangential_restitution": 0.2} | changes.pop("bat", {})
    incoming = {"velocity": [-35.0, 1.0, -6.0], "spin": [30.0, 150.0, -80.0], "bat_height": 1.0}
    incoming["position"] = [0.0696 * math.cos(0.4), 0.1, 1 + 0.0696 * math.sin(0.4)]
    return {"kind": "impact", "bat": bat, "incoming": incoming} | changes


def modules_of(module):
    tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
    modules = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
    return modules | {a.name for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names}


def test_it_imports_nothing_of_longball():
    modules = modules_of(oracle)
    known = {"bisect", "itertools", "math", "mpmath", "numpy", "scipy.integrate", "scipy.optimize"}
    assert modules == known | {"typing", "tests"}
    assert {"bisect", "mpmath"} == modules_of(extrapolation)


# ---- flight --------------------------------------------------------------------------------------


def test_a_constant_wind_carries_the_air():
    """r(t; v₀, W) = r(t; v₀ - W, 0) + W t, and the spin decays alike."""
    wind = [4.0, -3.0, 0.5]
    blown = flown(flight(air=AIR | {"wind": wind}), 2.0)
    launch = LAUNCH | {"velocity": list(np.subtract(LAUNCH["velocity"], wind))}
    calm = flown(flight(launch=launch), 2.0)
    assert blown[:3] == pytest.approx(calm[:3] + 2 * np.array(wind), rel=CLOSE)
    assert blown[6] == pytest.approx(calm[6], rel=CLOSE)


def test_speed_and_spin_without_gravity():
    """V = V₀/(1 + κt) with κ = k C_D V₀, and ω/ω₀ = (V/V₀)^{1/(k C_D L)}."""
    air = {
        "drag_coefficient": 0.3,
        "lift_coefficient": {"law": "linear"},
        "spin_decay_length": 50.0,
    }
    scene = flight(air=air, gravity=0.0)
    y = flown(scene, 3.0)
    k, speed = 1.29 * math.pi * 0.0366**2 / (2 * 0.145) * 0.3, oracle.length(LAUNCH["velocity"])
    slower = 1 / (1 + 3 * k * speed)
    assert oracle.length(y[3:6]) == pytest.approx(speed * slower, rel=CLOSE)
    assert math.exp(-y[6] / 50) == pytest.approx(slower ** (1 / (k * 50)), rel=CLOSE)


def test_a_helix_without_gravity_and_drag():
    """A constant lift turns v about ω by k C_L V t/sin α."""
    spin = np.array([0.0, 0.0, 100.0])
    air = {"drag_coefficient": 0.0, "lift_coefficient": 0.25}
    launch = LAUNCH | {"spin": list(spin)}
    y = flown(flight(air=air, gravity=0.0, launch=launch), 2.0)
    x, across, up = LAUNCH["velocity"]
    speed, level = oracle.length(LAUNCH["velocity"]), math.hypot(x, across)
    angle = 1.29 * math.pi * 0.0366**2 / (2 * 0.145) * 0.25 * speed * 2 * speed / level
    turned = [
        x * math.cos(angle) - across * math.sin(angle),
        x * math.sin(angle) + across * math.cos(angle),
        up,
    ]
    assert y[3:6] == pytest.approx(turned, rel=CLOSE)


def test_at_the_pole_the_velocity_turns_backwards():
    """Without air, by 2 Ω t."""
    y = flown(flight(air=None, earth={"latitude": math.pi / 2}), 3.0)
    x, across, up = LAUNCH["velocity"]
    angle = -2 * 7.292115e-5 * 3
    assert y[3] == pytest.approx(x * math.cos(angle) - across * math.sin(angle), rel=CLOSE)
    assert y[4] == pytest.approx(x * math.sin(angle) + across * math.cos(angle), rel=CLOSE)
    assert y[5] == pytest.approx(up - 9.8 * 3, rel=CLOSE)


def test_energy_is_lost_to_drag_alone():
    """In air that thins with the height, whatever turns the ball: d(V²/2 + g z) = -k C_D V³ dt."""
    air = AIR | {"drag_coefficient": 0.0, "density_scale_height": 900.0}
    y = flown(flight(air=air, earth={"latitude": 0.7, "azimuth": 1.0}), 3.0)
    start = oracle.length(LAUNCH["velocity"]) ** 2 / 2 + 9.8 * 1.0
    assert oracle.length(y[3:6]) ** 2 / 2 + 9.8 * y[2] == pytest.approx(start, rel=CLOSE)


# The wind jumps below the ball, so that the spin of the present airspeed is that in the wind.
PRESENT = {
    "contact": {
        "kind": "at-bat",
        "air": {
            "wind": {"velocity": [10, 0, 0], "above": 0.1},
            "lift_coefficient": {"law": "linear"},
            "spin_decay_length": 300,
        },
        "pitch": {"velocity": [-40, 0, 0], "spin": [0, -100, 0]},
        "reading": {"spin_decay": "nathan"},
    },
    "landing": {
        "kind": "flight",
        "launch": {"position": [0, 0, 2], "velocity": [20, 0, 20], "spin": [0, -100, 0]},
        "ground": {"height": 1.0},
        "air": {
            "lift_coefficient": {"law": "linear"},
            "wind": {"velocity": [15, 0, 0], "above": 0.5},
            "spin_decay_length": 100,
        },
        "reading": {"spin_decay": "nathan"},
    },
    "table": {
        "kind": "flight",
        "launch": {"position": [0, 0, 1], "velocity": [30, 0, 20], "spin": [0, -150, 0]},
        "air": {
            "lift_coefficient": {
                "law": "table",
                "of": "spin_parameter",
                "at": [0.05, 0.1, 0.2, 0.3],
                "values": [0.1, 0.3, 0.1, 0.3],
            },
            "wind": {"velocity": [8, 0, 0], "above": 5},
            "spin_decay_length": 100,
        },
        "reading": {"spin_decay": "nathan"},
    },
}


def test_the_present_airspeed_is_that_in_the_wind():
    """As other solvers have it, to the digits that they gave: the last is a plain RK4 of 0.2 ms."""
    found = {name: oracle.solve(scene).result for name, scene in PRESENT.items()}
    assert found["contact"]["impact"]["spin"][1] == pytest.approx(-93.00753, abs=1e-5)
    assert found["contact"]["landing"]["distance"] == pytest.approx(48.27145, abs=1e-5)
    assert found["landing"]["landing"]["spin"][1] == pytest.approx(-48.7215, abs=1e-4)
    assert found["table"]["landing"]["distance"] == pytest.approx(96.2172, abs=1e-4)


# ---- events --------------------------------------------------------------------------------------


def test_a_dip_between_samples_is_found():
    doubt = oracle.Doubt()
    sampled = SimpleNamespace(times=[0.0, 1.0], sharp=float, root=brentq)
    for depth, found in ((1e-6, [0.5 - 1e-3]), (-1e-6, [])):
        value = lambda t, depth=depth: (t - 0.5) ** 2 - depth  # noqa: E731
        times = oracle.falls(sampled, value, lambda t: t - 0.5, doubt, "a dip")
        assert list(times) == pytest.approx(found)
    assert doubt.least == pytest.approx(1e-6)
    assert doubt.question == "a dip"


def test_a_fence_in_a_vacuum():
    """z at the chord x = 60 is z₀ + w t - g t²/2; the chord's height there is 4 m."""
    fence = {"polyline": [[60.0, 60.0, 2.0], [60.0, -60.0, 6.0]]}
    found = oracle.solve(flight(air=None, fence=fence)).result
    time = 60 / 35
    height = 6 - 4 * (8 * time + 60) / 120
    clearance = 1 + 20 * time - 4.9 * time**2 - height
    assert found["outcome"] == "home_run"
    assert found["fence"]["clearance"] == pytest.approx(clearance, rel=CLOSE)
    assert found["fence"]["margin"] == pytest.approx(60 - 8 * time, rel=CLOSE)


# ---- impact --------------------------------------------------------------------------------------


@pytest.mark.parametrize("support", ["pivot", "free"])
@pytest.mark.parametrize("friction", [0.05, 5.0])
def test_the_ball_keeps_its_angular_momentum_about_the_contact(support, friction):
    """β R ω + n × V, since the impulse acts at that point."""
    scene = impact(bat={"support": support, "friction": friction})
    result = oracle.solve(scene).result
    assert result["impact"]["mode"] == ("slide" if friction < 1 else "grip")
    n, incoming = result["contact"]["normal"], scene["incoming"]

    def momentum(spin, velocity):
        return 0.4 * 0.0366 * np.array(spin) + np.cross(n, velocity)

    before = momentum(incoming["spin"], incoming["velocity"])
    after = momentum(result["impact"]["spin"], result["impact"]["velocity"])
    assert after == pytest.approx(before, rel=CLOSE)


@pytest.mark.parametrize("tangential", [-1.0, 1.0])
def test_a_perfect_grip_keeps_the_energy(tangential):
    """With the bat's own K: e = 1, no reading that creates energy, and a normal without coupling.

    Against a bat struck in its middle, with the normal level, K does not couple slip and normal.
    """
    scene = impact(
        bat={"support": "free", "friction": 1e3, "tangential_restitution": tangential},
        ball={"restitution": 1.0},
        reading={"bat_ball_restitution": "nathan"},
    )
    scene["incoming"] |= {"position": [0.0696, 0.0, 1.0]}
    found = oracle.solve(scene).result["impact"]
    assert found["mode"] == "grip"
    assert found["energy_change"] == pytest.approx(0.0, abs=100 * CLOSE)


def test_the_restitution_is_that_of_bodies():
    """By `nathan`, ball and bat part with e times the speed at which they met."""
    scene = impact(reading={"bat_ball_restitution": "nathan"})
    del scene["bat"]["friction"], scene["bat"]["tangential_restitution"]
    result = oracle.solve(scene).result
    arm = 0.4
    effective = 0.9 * (1 / 3 + 0.033**2 / 4) / arm**2
    contact, found = result["contact"], result["impact"]
    bat_after = -found["impulse"] / effective
    parting = oracle.dot(
        oracle.minus(found["velocity"], contact["bat_velocity"]), contact["normal"]
    )
    assert parting - bat_after == pytest.approx(-0.42 * contact["normal_speed"], rel=CLOSE)
