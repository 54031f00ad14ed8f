"""High precision against exact results: what the other tests call truth has to be it."""

import ast
from pathlib import Path

import mpmath
import pytest
from flint import arb

from tests import precise

SMALL = 1e-38  # of 40 digits


def path(position, velocity, drag="0.0075", lift="0.00375", gravity="9.8"):
    constants = [arb(constant) for constant in (drag, lift, gravity)]
    return precise.Path(precise.vector(position), precise.vector(velocity), constants)


@pytest.fixture(autouse=True)
def _digits():
    with precise.in_digits(precise.DIGITS):
        yield


def test_it_imports_nothing_of_longball():
    tree = ast.parse(Path(precise.__file__).read_text(encoding="utf-8"))
    imports = [ast.unparse(n) for n in ast.walk(tree) if isinstance(n, ast.Import | ast.ImportFrom)]
    assert sorted(imports) == ["from flint import arb", "from operator import mul", "import flint"]


def test_the_parabola():
    flight = path((0, 0, 1), (3, 4, 20), drag="0", lift="0")
    time = flight.landing(arb(0), arb(60))
    exact = (20 + (400 + 2 * arb("9.8")).sqrt()) / arb("9.8")
    assert abs(time - exact) < SMALL
    r, v = flight.at(time)
    assert precise.length([r[0] - 3 * exact, r[1] - 4 * exact, r[2]]) < SMALL
    assert abs(v[2] - (20 - arb("9.8") * exact)) < SMALL


def test_the_weightless_circle():
    """Turning by 90 degrees takes the ball to (1, 1)/k_L; V t = ln(1 + k_D V₀ t)/k_D."""
    drag, lift = arb("0.01"), arb("0.02")
    flight = path((0, 0, 0), (30, 0, 0), "0.01", "0.02", "0")
    way = arb.pi() / 2 / lift
    time = (drag * way).expm1() / (30 * drag)
    r, v = flight.at(time.mid())
    assert precise.length([r[0] - 1 / lift, r[1], r[2] - 1 / lift]) < SMALL * 50
    assert precise.length([v[0], v[1], v[2] - 30 * (-drag * way).exp()]) < SMALL * 30


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 30.0), (0.0, 0.0, -20.0)])
def test_straight_up_and_down(velocity):
    """tan and tanh, before the apex is reached."""
    k, g, t = arb("0.0075"), arb("9.8"), arb(1)
    r, v = path((0, 0, 100), velocity, lift="0").at(t)
    terminal, tau = (g / k).sqrt(), t * (g * k).sqrt()
    if velocity[2] > 0:
        exact = terminal * ((velocity[2] / terminal).atan() - tau).tan()
    else:
        exact = -terminal * ((-velocity[2] / terminal).atanh() + tau).tanh()
    assert abs(v[2] - exact) < SMALL * 30
    assert r[0] == r[1] == 0


def test_energy_and_phugoid_through_a_loop():
    """Past the vertical and on."""
    lift, g = arb("0.05"), arb("9.8")
    flight = path((0, 0, 50), (40, 0, 0), "0", "0.05")

    def invariants(time):
        r, v = flight.at(time)
        speed = precise.length(v)
        return g * r[2] + speed**2 / 2, lift * speed**3 / 3 - g * v[0]

    energy, phugoid = invariants(arb(0))
    for tenths in range(1, 60):
        now = invariants(arb(tenths) / 10)
        assert abs(now[0] - energy) < SMALL * 2000
        assert abs(now[1] - phugoid) < SMALL * 2000
    assert any(flight.at(arb(tenths) / 10)[1][0] < 0 for tenths in range(60))


def test_the_equations_in_space_against_mpmath():
    """Everything on, across the axes, by mpmath's own Taylor method from the written equations."""
    k, lift, g = 0.0075, 0.00375, 9.8
    with mpmath.workdps(25):
        heading = mpmath.matrix([3, 4]) / 5

        def slopes(_, y):
            vx, vy, vz = y[3:]
            speed = mpmath.sqrt(vx * vx + vy * vy + vz * vz)
            forward = heading[0] * vx + heading[1] * vy
            # In the plane of the launch the lift is the velocity turned by a right angle, upwards.
            return [
                vx,
                vy,
                vz,
                -k * speed * vx - lift * speed * heading[0] * vz,
                -k * speed * vy - lift * speed * heading[1] * vz,
                -k * speed * vz + lift * speed * forward - g,
            ]

        start = [mpmath.mpf(x) for x in (1, 2, 3, 18, 24, 15)]
        wanted = mpmath.odefun(slopes, 0, start)(1)
        constants = [arb(constant) for constant in (k, lift, g)]
        r, v = precise.Path(precise.vector((1, 2, 3)), precise.vector((18, 24, 15)), constants).at(
            arb(1)
        )
        for found, true in zip([*r, *v], wanted, strict=True):
            assert abs(mpmath.mpf(found.str(30, radius=False)) - true) < 1e-20


def test_more_digits_change_nothing_that_was_given():
    scene = {
        "id": "a",
        "kind": "at-bat",
        "reading": {},
        "ball": {"mass": 0.145, "radius": 0.0366, "restitution": 0.42},
        "air": {"density": 1.29, "drag_coefficient": 0.4, "lift_coefficient": 0.2},
        "gravity": 9.8,
        "time_limit": 60.0,
        "pitch": {"speed": 37.0, "release": [18.44, 0.0, 1.8], "aim": [0.1, 1.8]},
        "bat": {"mass": 0.9, "length": 1.0, "radius": 0.033},
        "swing": {"angular_speed": 34.0, "tilt": 0.1, "height_offset": -0.03},
        "ground": {"height": 0.0},
    }
    few, many = precise.solve(scene, 25), precise.solve(scene, 45)
    assert few["outcome"] == many["outcome"] == "batted"
    for block in ("plate", "contact", "impact", "landing"):
        for name, value in few[block].items():
            pairs = [(value, more := many[block][name])]
            if isinstance(value, list):
                pairs = zip(value, more, strict=True)
            if isinstance(value, dict):
                pairs = [(value[key], more[key]) for key in value]
            assert all(abs(a - b) < 1e-21 for a, b in pairs)


def test_an_offset_is_found_for_a_margin():
    pitch = {"speed": 37.0, "release": [18.44, 0.0, 1.8], "aim": [0.1, 1.8]}
    air = {"density": 1.29, "drag_coefficient": 0.4, "lift_coefficient": 0.2}
    ball = {"mass": 0.145, "radius": 0.0366}
    throw = precise.Throw(
        {"pitch": pitch, "air": air, "ball": ball, "gravity": 9.8, "bat": {"radius": 0.033}}
    )
    for side in (-1, 1):
        for margin in (1e-3, -1e-9):
            offset = throw.offset_for(margin, side)
            assert offset * side > 0
            # Half an ulp of the offset is 7e-18 m.
            assert abs(throw.margin(offset) - arb(margin)) < 1e-17
