"""Fits and aims: closed forms without air, round trips, and what cannot be had."""

import math
import random
import re

import numpy as np
import pytest

import longball as lb
from longball.model.inputs import value_of, with_values
from tests.calls import check_wrong_calls

RECOVERED = 1e-10  # relative; of unknowns, from what is computed of a scene in doubles


def flight(speed=46.0, angle=0.45, **blocks):
    return lb.Flight(launch=lb.launch(speed=speed, angle=angle), **blocks)


def real(seed):
    draw = random.Random(seed)
    launch = lb.launch(
        speed=draw.uniform(35, 50),
        angle=draw.uniform(0.2, 0.8),
        direction=draw.uniform(-0.6, 0.6),
        backspin=draw.uniform(100, 300),
        side_spin=draw.uniform(-150, 150),
    )
    air = {
        "density": draw.uniform(0.95, 1.25),
        "drag_coefficient": draw.uniform(0.25, 0.45),
        "lift_coefficient": {"law": "rational"},
        "wind": [draw.uniform(-4, 4), draw.uniform(-4, 4), 0.0],
    }
    return lb.Flight(launch=launch, air=air)


UNKNOWNS = [
    "launch.speed",
    "launch.angle",
    "launch.direction",
    "launch.backspin",
    "launch.side_spin",
    "air.drag_coefficient",
]


def off(scene, unknowns):
    """Return the scene with unknowns some percent off."""
    return with_values(
        scene, {n: value_of(scene, n) * (1.05 if i % 2 else 0.96) for i, n in enumerate(unknowns)}
    )


def recovered(found, scene, unknowns):
    return max(
        abs(found[name] - value_of(scene, name)) / max(1e-1, abs(value_of(scene, name)))
        for name in unknowns
    )


# A thousand random scenes at night, in pieces that `pytest -n` shares out; by day some of them.
PIECES = pytest.mark.parametrize("first", range(0, 1000, 50))


def seeds(first, nightly):
    return range(first, first + (50 if nightly else 2))


@PIECES
@pytest.mark.sampled(every=20)
def test_a_path_gives_its_scene_back(first, nightly):
    for seed in seeds(first, nightly):
        scene = real(seed)
        seen = lb.solve(scene).path.sample(25)
        found = lb.fit(seen, off(scene, UNKNOWNS), unknowns=UNKNOWNS, sigma=0.01)
        assert recovered(found, scene, UNKNOWNS) < RECOVERED


@PIECES
@pytest.mark.sampled(every=4)
def test_a_landing_gives_its_launch_back(first, nightly):
    names = ["landing.position[0]", "landing.position[1]", "landing.hang_time"]
    unknowns = UNKNOWNS[:3]
    for seed in seeds(first, nightly):
        scene = real(seed)
        result = lb.solve(scene)
        seen = {name: result[name] for name in names}
        found = lb.fit(seen, off(scene, unknowns), unknowns=unknowns)
        assert recovered(found, scene, unknowns) < RECOVERED


def test_errors_are_those_of_least_squares():
    # x = x₀ + u t without air: the variance of u from n points is σ²/Σ(t - t̄)²
    times = np.linspace(0.0, 1.0, 11)
    scene = lb.Flight(
        air=None, launch={"position": [0, 0, 10], "velocity": [30, 0, 5]}, gravity=9.8
    )
    noise = 0.01 * np.array([1, -1, 0, 1, 0, -1, 1, 0, -1, 1, -1])
    points = np.column_stack([times, 30 * times + noise, np.full((11, 2), math.nan)])
    unknowns = ["launch.position[0]", "launch.velocity[0]"]
    found = lb.fit(points, scene, unknowns=unknowns, sigma=0.01)
    spread = np.square(times - times.mean()).sum()
    slope, constant = np.polyfit(times, points[:, 1], 1)
    assert found["launch.velocity[0]"] == pytest.approx(slope, rel=1e-12)
    assert found["launch.position[0]"] == pytest.approx(constant, abs=1e-12)
    assert found.sigma["launch.velocity[0]"] == pytest.approx(0.01 / math.sqrt(spread), rel=1e-9)
    assert found.freedom == 9
    left = (points[:, 1] - slope * times - constant) / 0.01
    assert found.chi_squared == pytest.approx(left @ left, rel=1e-9)
    assert np.isnan(found.residuals[:, 1:]).all()
    # without sigma the residuals say how large it is; columns after x, y, z are not read
    free = lb.fit(np.column_stack([points, times]), scene, unknowns=unknowns)
    scale = math.sqrt(left @ left / 9)
    assert free.sigma["launch.velocity[0]"] == pytest.approx(
        scale * found.sigma["launch.velocity[0]"], rel=1e-9
    )


AIR = ["air.density", "air.drag_coefficient", "air.lift_coefficient"]


def test_a_direction_that_is_not_determined_is_named():
    # Drag is ½ρ C_D A/m: a path knows the product of density and coefficient alone.
    scene = flight()
    seen = lb.solve(scene).path.sample(10)
    known = ["launch.speed", "gravity", "ball.mass", *AIR]
    with pytest.raises(lb.CannotSolve) as refused:
        lb.fit(seen, scene, unknowns=known)
    assert "do not determine" in str(refused.value)
    assert "air.density" in str(refused.value)
    assert "launch.speed" not in str(refused.value)
    with pytest.raises(lb.CannotSolve, match=r"do not depend on ball\.restitution"):
        lb.fit(seen, scene, unknowns=["launch.speed", "ball.restitution"])


WRONG_FITS = r"""
lb.fit(FAR, flight(), unknowns="launch.speed") -> a list of names is needed
lb.fit(FAR, flight(), unknowns=SPEED, sigma="small") -> sigma = 'small': a number
lb.fit(FAR, flight(), unknowns=SPEED, sigma=[1, 2, 3]) -> sigma = .*one number is needed
lb.fit(FAR, flight(), unknowns=SPEED, sigma=0.0) -> must be positive
lb.fit(FAR, flight(), unknowns=SPEED, sigma={"landing.time": 1.0}) -> no value for
lb.fit(FAR, flight(), unknowns=["launch.speed", "launch.angle"]) -> 1 numbers cannot
lb.fit(FAR, flight(), unknowns=["launch.sped"]) -> did you mean launch.speed
lb.fit(FAR, flight(), unknowns=[]) -> name at least one
lb.fit({"landing.distance": math.nan}, flight(), unknowns=SPEED) -> a finite number is needed
lb.fit([[0.0, 1.0]], flight(), unknowns=SPEED) -> rows of t, x, y, z
lb.fit([[-1.0, 1.0, 0.0, 2.0]], flight(), unknowns=SPEED) -> a time since the start
lb.fit({"t": [0.0], "x": [1.0]}, flight(), unknowns=SPEED) -> a column y is missing
lb.fit({"landing.distance": 9e4}, flight(), unknowns=SPEED) -> no scene fits: .* misses landing.dist
lb.fit({"landing.distance": -99.0}, flight(), unknowns=SPEED) -> no scene fits
lb.fit({"plate.time": 0.4}, flight(), unknowns=SPEED)
    -> plate\.time is not the name of a number here
"""
FAR, SPEED = {"landing.distance": 100.0}, ["launch.speed"]


def test_what_is_no_measurement_is_refused():
    check_wrong_calls(WRONG_FITS, globals())


# --- aim ------------------------------------------------------------------------------------------


def vacuum(speed=40.0, position=(0.0, 0.0, 0.5), **keys):
    launch = {"position": position, "velocity": [speed, 0, 0]}
    return lb.Flight(air=None, launch=launch, **{"gravity": 9.8} | keys)


def angles(x, z, v=40.0, g=9.8):
    root = math.sqrt(v**4 - g * (g * x * x + 2 * z * v * v))
    return [math.atan((v * v + sense * root) / (g * x)) for sense in (-1, 1)]


@pytest.mark.parametrize("bearing", [0.4, 2.9, -2.9])
@pytest.mark.parametrize("point", [[], [12.0], [0.0]], ids=["place", "point", "on the ground"])
def test_a_target_is_hit_low_and_high_as_the_closed_form_says(bearing, point):
    x, y, z = 3.0, -2.0, 0.5
    target = [x + 70.0 * math.cos(bearing), y + 70.0 * math.sin(bearing), *point]
    hits = lb.aim(vacuum(position=(x, y, z)), target)
    for hit, angle in zip(hits, angles(70.0, sum(point) - z), strict=True):
        u, v, w = hit.launch.velocity
        assert math.atan2(w, math.hypot(u, v)) == pytest.approx(angle, rel=1e-12)
        assert math.remainder(math.atan2(v, u) - bearing, math.tau) == pytest.approx(0, abs=1e-12)


def test_a_distance_counts_from_the_plate():
    for hit, angle in zip(
        lb.aim(vacuum(position=(3.0, -20.0, 0.5)), 85.0),
        angles(math.sqrt(85.0**2 - 20.0**2) - 3.0, -0.5),
        strict=True,
    ):
        assert math.atan2(*hit.launch.velocity[::-2]) == pytest.approx(angle, rel=1e-12)


def test_a_launch_of_the_grid_that_hits_exactly_counts_once():
    """Level, 4 m high, under 8 m/s²: it lands after 1 s."""
    level, high = lb.aim(vacuum(position=(0.0, 0.0, 4.0), gravity=8.0), 40.0)
    assert level.launch.velocity == pytest.approx((40.0, 0.0, 0.0), abs=1e-12)
    assert math.atan2(*high.launch.velocity[::-2]) == pytest.approx(
        angles(40.0, -4.0, g=8.0)[1], rel=1e-12
    )


def test_a_curved_ball_lands_where_it_is_aimed(monkeypatch):
    """Straight behind it, a gale across takes it from the one end of the angles to the other.

    As soon as a secant's error is the product of the two before it.
    """
    monkeypatch.setattr("longball.questions.aiming._CORRECTED", 6)
    scene = with_values(real(3), {"air.wind[0]": 1.0, "air.wind[1]": 15.0})
    target = [-60.0, 0.0]
    hits = lb.aim(scene, target)
    assert len(hits) == 2
    for hit in hits:
        landing = lb.solve(hit).landing.position
        assert landing == pytest.approx((*target, 0.0), abs=1e-9)
        assert hit.launch.position == scene.launch.position


@PIECES
@pytest.mark.sampled(every=20)
def test_random_scenes_say_how_far_they_get(first, nightly):
    for seed in seeds(first, nightly)[:: 10 if nightly else 2]:
        scene = real(seed)
        with pytest.raises(lb.CannotSolve) as refused:
            lb.aim(scene, 1000.0)
        sentence = r"gets at most (\S+) m of 1000 m, at launch\.angle = (\S+)$"
        told = re.search(sentence, str(refused.value))
        gets, angle = map(float, told.groups())
        farthest = lb.solve(with_values(scene, {"launch.angle": angle}))
        assert farthest.landing.distance == pytest.approx(gets, rel=1e-5)
        low, *_, high = lb.aim(scene, 0.99 * gets)
        for hit in (low, high):
            assert lb.solve(hit).landing.distance == pytest.approx(0.99 * gets, abs=1e-9)
        assert low.launch.velocity[2] < high.launch.velocity[2]


@pytest.mark.parametrize("distance", [0.35, 15.0, 31.0])
def test_a_speed_is_found(distance):
    (hit,) = lb.aim(vacuum(), distance, unknowns=["launch.speed"])
    # level, from h = 0.5 m: v = d √(g/(2 h)), of 1.1 to 97 m/s
    assert hit.launch.velocity[0] == pytest.approx(distance * math.sqrt(9.8), rel=1e-12)


def test_beyond_reach_it_says_how_far_it_gets():
    v, g, h = 40.0, 9.8, 0.5
    farthest = v / g * math.sqrt(v * v + 2 * g * h)
    with pytest.raises(lb.CannotSolve, match=f"the ball gets at most {farthest:.6g} m of 200 m"):
        lb.aim(vacuum(), 200.0)
    # the envelope: z = v²/2g - g x²/2v²
    high = h + v * v / (2 * g) - g * 60.0**2 / (2 * v * v)
    with pytest.raises(lb.CannotSolve, match=f"is at most {high:.6g} m high"):
        lb.aim(vacuum(), [60.0, 0.0, 90.0])
    # the fastest, level: v √(2 h/g)
    fastest = 100.0 * math.sqrt(2 * h / g)
    with pytest.raises(lb.CannotSolve, match=rf"{fastest:.6g} m of 50 m, at launch\.speed = 100$"):
        lb.aim(vacuum(), 50.0, unknowns=["launch.speed"])


WRONG_AIMS = """
lb.aim({"kind": "pitch"}, 1.0) -> must be .flight. here
lb.aim(vacuum(), [1, 2, 3, 4]) -> a distance is needed
lb.aim(vacuum(), math.inf) -> must be finite
lb.aim(vacuum(), 0.0) -> a distance must be positive
lb.aim(vacuum(), [[90.0, 0.0]]) -> a distance is needed
lb.aim(vacuum(0.1, (50, 0, 1)), 49.5) -> beyond the target at every launch.angle from -1.571 on
lb.aim(vacuum(time_limit=1e-3), 10.0) -> no launch lands, at any launch.angle from -1.571 to 1.571
lb.aim(vacuum(), 1.0, unknowns=["launch.angel"]) -> did you mean launch.angle
lb.aim(vacuum(), 1.0, unknowns=["launch.angle", "launch.direction"])
    -> a distance takes one, launch.angle
"""


def test_what_is_no_target_is_refused():
    check_wrong_calls(WRONG_AIMS, globals())
