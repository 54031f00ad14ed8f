"""The oblique impact in every engine: exact results, and an independent formulation in vectors."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from longball.engines import create
from longball.engines.certify import certify
from longball.engines.chain import solve
from longball.model.readings import Reading
from longball.model.scene import (
    Air,
    AtBatScene,
    Ball,
    Bat,
    ImpactScene,
    Incoming,
    InvalidScene,
    Pitch,
    Rotation,
    Swing,
    parse_scene,
)
from tests.strategies import between

ENGINES = {name: create(name) for name in ("ivp", "batch", "verlet", "enclosure")}
# Golden data have oblique impacts for all engines but Verlet's.
EVERY_ENGINE = pytest.mark.parametrize("engine", [ENGINES["ivp"], ENGINES["verlet"]], ids=str)
NATHAN = Reading(bat_ball_restitution="nathan")

# Some forty roundings of terms that are as large as the largest speed, in an impact that may
# magnify them a few times.
ROUNDED = 1e-13


def touching(angle, y, bat, ball, **more):
    reach = ball.radius + bat.radius
    position = (reach * math.cos(angle), y, 1.0 + reach * math.sin(angle))
    return Incoming(position=position, bat_height=1.0, **more)


@st.composite
def rough_impacts(draw, **bat):
    """Balls that spin and hit a rough bat anywhere, of any tilt and support."""
    ball = Ball(
        mass=draw(between(0.1, 0.2)),
        radius=draw(between(0.02, 0.05)),
        restitution=draw(between(0.1, 0.9)),
        inertia_factor=draw(between(0.2, 2 / 3)),
    )
    numbers = {
        "friction": draw(between(0.01, 2)),
        "tangential_restitution": draw(between(-1, 1)),
        "support": draw(st.sampled_from(["pivot", "free"])),
    }
    bat = Bat(
        mass=draw(between(0.5, 2)),
        length=draw(between(0.8, 1.1)),
        radius=draw(between(0.02, 0.04)),
        **numbers | bat,
    )
    angle = draw(between(-1, 1))
    speeds = st.tuples(between(-60, -20), between(-40, 40), between(-15, 15))
    incoming = touching(
        angle,
        draw(between(-0.39, 0.39)),
        bat,
        ball,
        velocity=draw(speeds),
        spin=draw(st.tuples(*[between(-400, 400)] * 3)),
    )
    swing = Rotation(angular_speed=draw(between(0, 45)), tilt=draw(between(-0.5, 0.5)))
    return ImpactScene(
        id="rough", ball=ball, bat=bat, swing=swing, incoming=incoming, reading=NATHAN
    )


def struck(scene, engine):
    result = solve(scene, engine)
    assert result.error is None
    return result


def vector(numbers):
    return np.array([float(x) for x in numbers])


# --- an independent formulation -------------------------------------------------------------------


def vectors(scene):
    """Return all about the contact as vectors and 3x3 matrices in space."""
    ball, bat, swing, incoming = scene.ball, scene.bat, scene.swing, scene.incoming
    x = np.array(incoming.position)
    axis = np.array([0, x[1], incoming.bat_height])
    n = (x - axis) / np.linalg.norm(x - axis)
    p = x - ball.radius * n
    end = np.array([0, bat.length / 2, incoming.bat_height])
    centre = np.array([0, 0, incoming.bat_height])
    rotation = swing.angular_speed * np.array([-math.sin(swing.tilt), 0, math.cos(swing.tilt)])
    free = bat.support == "free"
    r = p - (centre if free else end)
    along = bat.mass * bat.length**2 / (12 if free else 3) + bat.mass * bat.radius**2 / 4
    inertia = np.diag([along, bat.mass * bat.radius**2 / 2, along])
    turn = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    k = (
        np.eye(3) / ball.mass
        + (np.eye(3) - np.outer(n, n)) / (ball.inertia_factor * ball.mass)
        + turn.T @ np.linalg.inv(inertia) @ turn
        + (np.eye(3) / bat.mass if free else 0)
    )
    v, spin = np.array(incoming.velocity), np.array(incoming.spin)
    g = v + np.cross(spin, -ball.radius * n) - np.cross(rotation, p - end)
    return n, k, v, spin, g


def by_matrices(scene):
    """Return impulse and mode, by solving K P = … in space."""
    n, k, _, _, g = vectors(scene)
    e, bat = scene.ball.restitution, scene.bat
    normal = (g @ n) * n
    grip = np.linalg.solve(k, -(1 + e) * normal - (1 + bat.tangential_restitution) * (g - normal))
    tangential = grip - (grip @ n) * n
    margin = 1 - np.linalg.norm(tangential) / (bat.friction * (grip @ n))
    if margin > 0:
        return grip, "grip", margin
    way = (g - normal) / np.linalg.norm(g - normal)
    along = n - bat.friction * way
    return -(1 + e) * (g @ n) / (n @ k @ along) * along, "slide", margin


@given(rough_impacts())
def test_the_impulse_is_that_of_vectors_and_matrices(scene):
    result = solve(scene, ENGINES["ivp"])
    assume(result.outcome == "struck")
    n, k, v, spin, g = vectors(scene)
    push, mode, margin = by_matrices(scene)
    assume(abs(margin) > 1e-9)
    impact, ball = result.impact, scene.ball
    assert impact.mode == mode
    size = np.linalg.norm(g) * ball.mass
    assert impact.friction_margin == pytest.approx(margin, abs=ROUNDED * (1 + abs(margin)) * 100)
    assert impact.impulse == pytest.approx(push @ n, abs=ROUNDED * size)
    assert vector(impact.velocity) == pytest.approx(v + push / ball.mass, abs=ROUNDED * size * 10)
    turned = np.cross(n, push) / (ball.inertia_factor * ball.mass * ball.radius)
    limit = ROUNDED * size / (ball.mass * ball.radius)
    assert vector(impact.spin) == pytest.approx(spin - turned, abs=limit)
    energy = push @ (g + k @ push / 2)
    assert impact.energy_change == pytest.approx(energy, abs=ROUNDED * ball.mass * (g @ g))


# --- exact results in every engine ----------------------------------------------------------------


@EVERY_ENGINE
def test_sliding_does_not_depend_on_how_fast_the_ball_slides(engine):
    """Once it slides far, its impulse depends on the direction of the slip alone."""
    bat = Bat(friction=0.1)
    results = [
        struck(
            ImpactScene(
                id="slide",
                bat=bat,
                swing=Rotation(angular_speed=0.0),
                incoming=touching(0.0, 0.2, bat, Ball(), velocity=(-40.0, 3.0 * f, 4.0 * f)),
            ),
            engine,
        ).impact
        for f in (8.0, 16.0)
    ]
    assert [impact.mode for impact in results] == ["slide"] * 2
    assert float(results[0].impulse) == pytest.approx(float(results[1].impulse), rel=1e-14)
    assert vector(results[0].spin) == pytest.approx(vector(results[1].spin), rel=1e-14)


@EVERY_ENGINE
@pytest.mark.parametrize(
    "reading", [{}, {"bat_ball_restitution": "nathan"}, {"inertia": "thin_rod"}]
)
def test_without_friction_the_impact_is_the_papers(engine, reading):
    """In the limit, under any reading of μ."""
    incoming = touching(0.3, 0.1, Bat(), Ball(), velocity=(-38.0, 1.0, -3.0))
    scene = ImpactScene(id="p", incoming=incoming, reading=Reading(**reading))
    paper = struck(scene, engine).impact
    rough = struck(scene.model_copy(update={"bat": Bat(friction=1e-20)}), engine).impact
    assert rough.mode == "slide"
    assert paper.mode is None
    assert float(rough.impulse) == pytest.approx(float(paper.impulse), rel=1e-15)
    assert vector(rough.velocity) == pytest.approx(vector(paper.velocity), rel=1e-14)
    assert float(rough.energy_change) == pytest.approx(float(paper.energy_change), rel=1e-13)
    assert vector(rough.spin) == pytest.approx(0, abs=1e-15)


@EVERY_ENGINE
@pytest.mark.parametrize("e_t", [0.0, 0.3])
def test_the_threshold_of_gripping_on_a_heavy_bat(engine, e_t):
    """|g_t|/|g_n| = μ_f (1 + e)(1 + 1/β)/(1 + e_T): 7/2 μ_f (1 + e)/(1 + e_T) of a solid sphere."""
    ball, speed, friction = Ball(restitution=0.5), 40.0, 0.25
    bat = Bat(mass=1e20, friction=friction, tangential_restitution=e_t)
    threshold = 3.5 * friction * 1.5 / (1 + e_t) * speed
    for beyond, mode in ((-1e-9, "grip"), (1e-9, "slide")):
        incoming = touching(0.0, 0.2, bat, ball, velocity=(-speed, 0.0, threshold * (1 + beyond)))
        still = Rotation(angular_speed=0.0)
        scene = ImpactScene(
            id="t", ball=ball, bat=bat, swing=still, incoming=incoming, reading=NATHAN
        )
        impact = struck(scene, engine).impact
        assert impact.mode == mode
        assert float(impact.friction_margin) == pytest.approx(-beyond, rel=1e-5)


@EVERY_ENGINE
def test_the_final_direction_joins_grip_and_slide(engine):
    """A ball that all but grips leaves as one that grips, under the reading `final` alone."""
    bat = Bat(friction=0.5, tangential_restitution=0.3)
    incoming = touching(
        0.4, -0.3, bat, Ball(), velocity=(-38.0, 14.0, 9.0), spin=(0.0, -200.0, 0.0)
    )

    def impact(friction, direction):
        rough = bat.model_copy(update={"friction": friction})
        reading = Reading(bat_ball_restitution="nathan", slide_direction=direction)
        scene = ImpactScene(id="j", bat=rough, incoming=incoming, reading=reading)
        return struck(scene, engine).impact

    needed = 0.5 * (1 - float(impact(0.5, "initial").friction_margin))
    for direction, joins in (("final", True), ("initial", False)):
        grips, slides = (impact(needed * (1 + x), direction) for x in (1e-9, -1e-9))
        assert (grips.mode, slides.mode) == ("grip", "slide")
        apart = np.abs(vector(grips.velocity) - vector(slides.velocity)).max()
        assert bool(apart < 1e-7) is joins


@EVERY_ENGINE
def test_jamming_is_an_error(engine):
    """It takes a disc: no ball jams on a bat that yields more across its axis than along it."""
    disc = Bat(mass=0.01, length=0.05, radius=1.0, friction=0.6)
    still = Rotation(angular_speed=0.0)

    def impact(friction):
        bat = disc.model_copy(update={"friction": friction})
        incoming = touching(0.0, -0.0249, bat, Ball(), velocity=(-1.0, 100.0, 100.0))
        return ImpactScene(id="jam", bat=bat, swing=still, incoming=incoming, reading=NATHAN)

    result = solve(impact(0.6), engine)
    assert "ball and bat jam" in result.error
    assert result.impact is None
    assert struck(impact(0.3), engine).impact.mode == "slide"
    assert struck(impact(2.0), engine).impact.mode == "grip"
    jammed, slid = ENGINES["batch"].solve_all([impact(0.6)] * 20 + [impact(0.3)] * 20)[19:21]
    assert jammed.error is not None
    assert slid.impact.mode == "slide"


@pytest.mark.parametrize(("mass", "told"), [(50.0, True), (2e5, False)])
def test_a_ball_too_heavy_for_the_bat_is_not_gripped_in_doubles(mass, told):
    """K is singular to a part in 1e2 or in 1e6: by as much a rounding shows in the impulse."""
    ball, bat = Ball(mass=mass), Bat(mass=0.4, length=0.2, friction=30.0)
    incoming = touching(0.8, 0.0, bat, ball, velocity=(0.0, 0.3, -2.0), spin=(-16.0, -10.0, -6.0))
    reading = Reading(bat_ball_restitution="nathan", reduced_mass="effective_mass")
    scene = ImpactScene(id="heavy", ball=ball, bat=bat, incoming=incoming, reading=reading)
    truth = struck(scene, ENGINES["enclosure"]).impact
    assert truth.mode == "grip"
    for name in ("ivp", "batch"):
        result = solve(scene, ENGINES[name])
        if told:
            assert result.impact.impulse == pytest.approx(float(truth.impulse), rel=1e-12)
        else:
            assert result.code == "out_of_range"
            assert "too heavy" in result.error


@EVERY_ENGINE
def test_a_frictionless_bat_leaves_the_spin(engine):
    incoming = touching(0.3, 0.1, Bat(), Ball(), velocity=(-38.0, 1.0, -3.0), spin=(1.0, 2.0, 3.0))
    scene = ImpactScene(id="s", incoming=incoming)
    impact = struck(scene, engine).impact
    assert impact.mode == "frictionless"
    assert vector(impact.spin).tolist() == [1, 2, 3]
    bare = scene.model_copy(update={"incoming": incoming.model_copy(update={"spin": None})})
    without = struck(bare, engine).impact
    assert without.model_dump(include={"velocity", "impulse"}) == impact.model_dump(
        include={"velocity", "impulse"}
    )
    assert "spin" not in struck(bare, engine).line()


def test_oblique_impacts_are_certified():
    for scene in many_impacts():
        result = solve(scene, ENGINES["ivp"])
        found = certify(scene, result)
        assert found.certificate is None
        assert found.impact.mode == result.impact.mode
        assert all(float(x.radius) < 1e-10 for x in found.impact.spin)


def test_a_flight_with_the_spin_of_an_impact_is_proven():
    """That spin is a ball of numbers, and no step is better than it: the steps are no shorter."""
    scene = AtBatScene(
        id="batted",
        pitch=Pitch(spin=(10.0, 200.0, 30.0)),
        bat=Bat(friction=0.5),
        swing=Swing(height_offset=-0.02),
        air=Air(lift_coefficient={"law": "rational"}),
    )
    proven, found = (solve(scene, ENGINES[name]).landing for name in ("enclosure", "ivp"))
    assert float(proven.distance.radius) < 1e-15
    assert found.distance == pytest.approx(float(proven.distance.value), rel=1e-13)


# --- at-bats, and columns -------------------------------------------------------------------------


@EVERY_ENGINE
def test_a_rough_bat_gives_backspin_and_a_lower_launch(engine):
    """Through the whole chain: friction pulls an undercut ball down, and it spins backwards."""
    engine = replace(engine, dt=1e-3) if hasattr(engine, "dt") else engine
    swing = Swing(height_offset=-0.02)
    smooth, rough = (
        struck(AtBatScene(id="ab", swing=swing, bat=bat), engine)
        for bat in (Bat(), Bat(friction=0.5))
    )
    assert float(rough.impact.velocity[2]) < float(smooth.impact.velocity[2])
    assert float(rough.impact.spin[1]) < -100
    assert smooth.impact.spin is None
    assert rough.landing is not None
    assert rough.plate == smooth.plate


def many_impacts():
    rng = np.random.default_rng(14)
    for i in range(40):
        bat = Bat(friction=float(rng.uniform(0.02, 0.6)), support=("free", "pivot")[i % 2])
        yield ImpactScene(
            id=str(i),
            bat=bat,
            incoming=touching(
                float(rng.uniform(-1, 1)),
                float(rng.uniform(-0.4, 0.4)),
                bat,
                Ball(),
                velocity=(-40.0, float(rng.uniform(-9, 9)), float(rng.uniform(-9, 9))),
                spin=tuple(rng.uniform(-300, 300, 3).tolist()),
            ),
        )


# --- scenes ---------------------------------------------------------------------------------------


def test_a_scene_without_the_new_keys_is_written_as_ever():
    line = ImpactScene(
        id="old", incoming=touching(0.0, 0.0, Bat(), Ball(), velocity=(-1.0, 0.0, 0.0))
    ).line()
    for key in ("spin", "friction", "support", "inertia_factor", "tangential_restitution"):
        assert key not in line
    rough = parse_scene(line.replace('"bat": {', '"bat": {"friction": 0.5, "support": "free", '))
    assert parse_scene(rough.line()) == rough
    assert '"friction": 0.5' in rough.line()


@pytest.mark.parametrize(
    ("bat", "reading", "message"),
    [
        ('"tangential_restitution": 0.3', "", "bat: tangential_restitution needs friction"),
        ('"friction": 0', "", "bat.friction"),
        ('"friction": 1, "tangential_restitution": 1.5', "", "bat.tangential_restitution"),
        ('"support": "held"', "", "bat.support"),
        ('"support": "free"', '"effective_mass": "as_printed"', "bat.support = free has no"),
    ],
)
def test_bad_keys_are_named(bat, reading, message):
    line = f'{{"id": "x", "kind": "at-bat", "bat": {{{bat}}}, "reading": {{{reading}}}}}'
    with pytest.raises(InvalidScene, match=message):
        parse_scene(line)
