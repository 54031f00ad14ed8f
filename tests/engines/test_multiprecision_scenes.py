"""Scenes solved with any number of digits: closed forms, other solvers, grazes."""

import mpmath
import numpy as np
import pytest

from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.model.readings import Reading
from longball.model.result import Bounded
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    FlightScene,
    Ground,
    Launch,
    Pitch,
    PitchScene,
    Swing,
)

ENGINE = Multiprecision(30)
NUMBERS = ENGINE.numbers
mp = NUMBERS.context
exact = NUMBERS.exact
ALWAYS_UP = Reading(lift_direction="always_up")


def flight(velocity, position=(0.0, 0.0, 1.0), **blocks):
    return FlightScene(id="f", launch=Launch(position=position, velocity=velocity), **blocks)


def numbers_of(block):
    """Every number of a result, by the way to it, as it was written."""
    if isinstance(block, Bounded):
        return {"": block.value}
    if isinstance(block, float):
        return {"": block}
    if isinstance(block, tuple):
        parts = enumerate(block)
    elif block is None or isinstance(block, str):
        return {}
    else:
        parts = ((name, getattr(block, name)) for name in type(block).model_fields)
    return {f"{k}.{way}": x for k, part in parts for way, x in numbers_of(part).items()}


def printed(x, digits=30):
    """The truth `x`, as the engine writes it if all of its digits are right."""
    return mp.nstr(x, digits, strip_zeros=False)


def random_at_bats(seed, count):
    """At-bats of the paper's kind."""
    rng = np.random.default_rng(seed)
    return [
        AtBatScene(
            id=f"{seed}-{i}",
            pitch=Pitch(speed=float(rng.normal(37, 2)), aim=(float(rng.normal(0, 0.2)), 1.8)),
            swing=Swing(
                tilt=float(rng.uniform(0, 0.17)), height_offset=float(rng.normal(0, 0.0366))
            ),
        )
        for i in range(count)
    ]


# ---- closed forms: every digit -------------------------------------------------------------------


def test_parabola():
    landing = solve(flight((30.0, 0.0, 20.0), air=None), ENGINE).landing
    g = exact(9.8)
    time = (20 + mp.sqrt(400 + 2 * g)) / g
    assert landing.time.value == printed(time)
    assert landing.distance.value == printed(30 * time)
    assert landing.velocity[2].value == printed(20 - g * time)
    assert landing.position[2].value == "0.0"


@pytest.mark.parametrize("speed", [30.0, 0.0])
def test_vertical_flight_with_drag(speed):
    """tan on the way up, tanh on the way down from rest; the apex between them is a kink."""
    air = Air(lift_coefficient=0.0)
    landing = solve(flight((0.0, 0.0, speed), air=air), ENGINE).landing
    ball = Ball()
    area = mp.pi * exact(ball.radius) ** 2
    k = exact(air.density) * exact(air.drag_coefficient) * area / (2 * exact(ball.mass))
    g = exact(9.8)
    terminal = mp.sqrt(g / k)
    rise = terminal / g * mp.atan(speed / terminal)
    height = 1 + mp.log(1 + (speed / terminal) ** 2) / (2 * k)
    fall = terminal / g * mp.acosh(mp.exp(k * height))
    assert landing.time.value == printed(rise + fall)
    assert landing.velocity[2].value == printed(-terminal * mp.sqrt(-mp.expm1(-2 * k * height)))


# ---- other solvers, other precisions -------------------------------------------------------------


def test_agrees_with_a_taylor_solver():
    """mpmath's own, flown over the same time: it must come down where this engine lands."""
    at_bat = AtBatScene(id="t", swing=Swing(height_offset=-0.02))
    result = solve(at_bat, ENGINE)
    taylor = mpmath.MPContext()
    taylor.dps = 35

    air, ball = at_bat.air, at_bat.ball
    per_metre = (
        taylor.mpf(air.density)
        * taylor.pi
        * taylor.mpf(ball.radius) ** 2
        / 2
        / taylor.mpf(ball.mass)
    )
    drag, lift = (taylor.mpf(c) * per_metre for c in (air.drag_coefficient, air.lift_coefficient))
    gravity = taylor.mpf(at_bat.gravity)

    def motion(_, y):
        _, _, u, w = y
        speed = taylor.hypot(u, w)
        return [u, w, -speed * (drag * u + lift * w), -speed * (drag * w - lift * u) - gravity]

    x0, _, z0 = (taylor.mpf(p.value) for p in result.contact.position)
    u0, _, w0 = (taylor.mpf(v.value) for v in result.impact.velocity)
    assert at_bat.pitch.aim[0] == 0.0  # so that the flight is in the plane y = 0, along +x
    path = taylor.odefun(motion, 0, [x0, z0, u0, w0], degree=45)
    x, z, u, w = path(taylor.mpf(result.landing.hang_time.value))
    # The launch was read from 30 printed digits, and so is 1e-30 of a hundred metres off at most.
    for end, (found, truth) in {
        "x": (result.landing.position[0], x),
        "u": (result.landing.velocity[0], u),
        "w": (result.landing.velocity[2], w),
    }.items():
        assert abs(taylor.mpf(found.value) / truth - 1) < taylor.mpf(10) ** -28, end
    assert abs(z) < taylor.mpf(10) ** -27


def rounds_to(longer, shorter, digits):
    """Whether `shorter` is `longer` rounded; or cut differently where the next digits are 49999…"""
    unit = mpmath.mpf(10)
    with mpmath.workdps(60):
        longer, shorter = mpmath.mpf(longer), mpmath.mpf(shorter)
        if longer == shorter:
            return True
        unit = unit ** (mpmath.floor(mpmath.log10(abs(longer))) + 1 - digits)
        return abs(longer - shorter) <= unit * (0.5 + 1e-6)


@pytest.mark.parametrize("scene", random_at_bats(seed=50, count=3), ids=lambda scene: scene.id)
def test_all_printed_digits_are_those_of_more_digits(scene):
    few, many = (solve(scene, Multiprecision(digits)) for digits in (30, 40))
    assert few.outcome == many.outcome
    few, many = numbers_of(few), numbers_of(many)
    assert few.keys() == many.keys()
    assert len(few) > 0
    for way in few:
        assert rounds_to(many[way], few[way], 30), way


def test_a_ball_that_almost_comes_to_rest_loses_no_digit():
    """V falls to 1e-9 m/s at the apex: the path is smooth, but only just."""
    scene = flight((1e-9, 0.0, 3.0), air=Air(lift_coefficient=0.0))
    few, many = (numbers_of(solve(scene, Multiprecision(digits))) for digits in (20, 30))
    for way in few:
        assert rounds_to(many[way], few[way], 20), way


@pytest.mark.parametrize("scene", random_at_bats(seed=11, count=20), ids=lambda scene: scene.id)
def test_agrees_with_the_ivp_engine(scene):
    found, other = solve(scene, ENGINE), solve(scene, Ivp())
    assert found.outcome == other.outcome
    found, other = numbers_of(found), numbers_of(other)
    assert found.keys() == other.keys()
    # The ivp engine lands within 1e-12 m of a given launch; the collision may magnify it tenfold.
    for way, value in found.items():
        assert float(value) == pytest.approx(other[way], rel=1e-11, abs=1e-11), way


# ---- events, by the same rules as in the ivp engine ----------------------------------------------

LIFTED = Air(lift_coefficient=2.0)

SCENES = {
    "rests on the floor": flight((30.0, 0.0, 0.0), position=(0.0, 0.0, 0.0)),
    "rises from the floor": flight((30.0, 0.0, 10.0), position=(0.0, 0.0, 0.0)),
    "is lifted from the floor": flight((90.0, 0.0, 0.0), position=(0.0, 0.0, 0.0), air=LIFTED),
    "dips under the ground": flight((60.0, 0.0, -20.0), air=LIFTED),
    "dips and comes back": flight((60.0, 0.0, -2.0), air=LIFTED),
    "loops": flight((40.0, 0.0, 30.0), air=Air(drag_coefficient=0.1, lift_coefficient=4.0)),
    "lands on its surface": flight((1.0, 2.0, 3.0), reading=Reading(ground_contact="surface")),
    "lands below the plate": flight((30.0, 0.0, 0.0), ground=Ground(height=-5.0)),
    "turns vertical": flight((3.0, 1.0, 30.0), reading=ALWAYS_UP),
    "starts vertical": flight((0.0, 0.0, 30.0), reading=ALWAYS_UP),
    "starts downwards": flight((0.0, 0.0, -30.0), position=(0.0, 0.0, 30.0), reading=ALWAYS_UP),
    "drops from rest": flight((0.0, 0.0, 0.0)),
    "is still in the air": flight((30.0, 0.0, 30.0), time_limit=2.0),
    "pitch crosses": PitchScene(id="p"),
    "pitch is grounded": PitchScene(id="p", pitch=Pitch(speed=15.0)),
    "pitch stays in the air": PitchScene(id="p", time_limit=0.25),
    "pitch turns back": PitchScene(id="p", air=Air(lift_coefficient=4.0)),
    "misses above": AtBatScene(id="a", swing=Swing(height_offset=-0.08)),
    "beyond the bat": AtBatScene(id="a", pitch=Pitch(aim=(0.7, 1.8))),
    "separates": AtBatScene(id="a", swing=Swing(angular_speed=-100.0)),
    "bat under the ground": AtBatScene(id="a", swing=Swing(height_offset=-1.12)),
    "starts inside the bat": AtBatScene(id="a", pitch=Pitch(release=(0.05, 0.0, 1.8))),
    "passes while it falls": AtBatScene(
        id="a", pitch=Pitch(speed=2.0, release=(0.3, 0.0, 1.8)), swing=Swing(height_offset=0.01)
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_events_follow_the_rules_of_the_ivp_engine(name):
    found, other = solve(SCENES[name], ENGINE), solve(SCENES[name], Ivp())
    assert (found.outcome, found.error) == (other.outcome, other.error)
    found, other = numbers_of(found), numbers_of(other)
    assert found.keys() == other.keys()
    for way, value in found.items():
        assert float(value) == pytest.approx(other[way], rel=1e-10, abs=1e-10), way


def test_contact_at_the_release():
    """Sums of powers of two, in a vacuum without weight: the ball is released touching the bat."""
    scene = AtBatScene(
        id="a",
        ball=Ball(radius=0.03125),
        bat=Bat(radius=0.03125),
        air=None,
        gravity=0.0,
        pitch=Pitch(speed=32.0, release=(0.0625, 0.0, 1.5), aim=(0.0, 1.5)),
    )
    result = solve(scene, ENGINE)
    assert result.outcome == "batted" or result.outcome == "airborne"
    assert result.contact.time.value == "0.0"
    assert result.contact.margin.value == printed(mp.mpf(0.0625))


# ---- grazes --------------------------------------------------------------------------------------


def grazing(offset):
    """A level swing over a pitch that falls: where they graze, the bat closes in on the ball."""
    return AtBatScene(id="g", swing=Swing(tilt=0.0, height_offset=offset))


@pytest.fixture(scope="module", params=[1e-15, -1e-15])
def graze(request):
    """A margin, m, and the scene that has it as nearly as the offset's double allows."""
    aim, near, far = request.param, 0.0695, 0.0697
    for _ in range(3):  # the secant method, on what is nearly a straight line
        at_near, at_far = (
            exact(0.0) + mp.mpf(solve(grazing(offset), ENGINE).contact.margin.value)
            for offset in (near, far)
        )
        near, far = far, float(far + (aim - at_far) * (far - near) / (at_far - at_near))
    return aim, grazing(far)


def test_a_graze_is_decided(graze):
    aim, scene = graze
    result = solve(scene, ENGINE)
    # The offset is a multiple of 2^-56 = 1.4e-17 m.
    assert float(result.contact.margin.value) == pytest.approx(aim, abs=1e-17)
    assert result.outcome == ("batted" if aim > 0 else "missed")
    assert solve(scene, Ivp()).outcome is None  # doubles cannot tell


def test_a_graze_loses_no_printed_digit(graze):
    """The guard digits are for this: time of touching and all that follows hang on √margin."""
    _, scene = graze
    few, many = (numbers_of(solve(scene, Multiprecision(digits))) for digits in (30, 50))
    for way in few:
        assert rounds_to(many[way], few[way], 30), way


def test_engines_of_different_digits_do_not_meet():
    scene = AtBatScene(id="a")
    alone = solve(scene, Multiprecision(20))
    few, many = Multiprecision(20), Multiprecision(40)
    before = mpmath.mp.prec
    between = [solve(scene, engine) for engine in (few, many, few)]
    assert between[0] == between[2] == alone
    assert len(between[1].plate.time.value) == len("0.") + 40
    assert mpmath.mp.prec == before
