"""The law of motion: traced, it is the sum of its forces in space, and only what is named."""

import itertools
from types import SimpleNamespace

import pytest
import sympy as sp

from longball.engines.path_engine import branches_at, form_at
from longball.model.air import WindProfile
from longball.model.frame import Frame
from longball.model.law import (
    Force,
    PlaneState,
    SpaceState,
    law_of,
    law_with,
)
from longball.model.numbers import DOUBLES
from longball.model.scene import Air, FlightScene, Launch
from longball.model.trace import ZERO

K_D, K_L, G = sp.symbols("k_D k_L g", positive=True)
U, W = sp.symbols("u w", real=True)
ALONG_X = Frame(0.0, 0.0, 1.0, 0.0)
SYMBOLS = SimpleNamespace(functions={"sqrt": sp.sqrt})


def scene(air=Air(), gravity=9.8):  # noqa: B008  (frozen)
    launch = Launch(position=(0.0, 0.0, 1.0), velocity=(30.0, 0.0, 10.0))
    return FlightScene(id="x", launch=launch, air=air, gravity=gravity)


@pytest.mark.parametrize(
    ("drag", "lift", "gravity"), [*itertools.product([None, K_D], [None, K_L], [None, G])]
)
def test_the_law_is_that_of_space(drag, lift, gravity):
    """a = -k_D V v + k_L V (ŝ × v) + g, ŝ level and to the right of the flight."""
    strengths = {"drag": drag, "lift": lift, "gravity": gravity}
    law = law_with({name: k for name, k in strengths.items() if k is not None})
    assert law.is_paper
    rates = law.rates(SYMBOLS)(*sp.symbols("s z"), U, W)
    velocity, speed = sp.Matrix([U, 0, W]), sp.sqrt(U**2 + W**2)
    wanted = (
        -(drag or 0) * speed * velocity
        + (lift or 0) * speed * sp.Matrix([0, -1, 0]).cross(velocity)
        - (gravity or 0) * sp.Matrix([0, 0, 1])
    )
    assert law.state is PlaneState
    assert rates[:2] == (U, W)
    found = sp.Matrix([rates[2], 0, rates[3]])
    assert (found - wanted).applyfunc(sp.simplify) == sp.zeros(3, 1)


@pytest.mark.parametrize(
    ("air", "gravity", "named"),
    [
        (None, 9.8, {"gravity"}),
        (None, 0.0, set()),
        (Air(density=0.0), 9.8, {"gravity"}),
        (Air(drag_coefficient=0.0), 0.0, {"lift"}),
        (Air(lift_coefficient=0.0), 0.0, {"drag"}),
        (Air(lift_coefficient=-0.1), 9.8, {"drag", "lift", "gravity"}),
    ],
)
def test_only_what_the_scene_names_is_there(air, gravity, named):
    law = law_of(scene(air, gravity), ALONG_X, DOUBLES)
    assert set(law.strengths) == named


def test_what_is_absent_is_not_computed():
    vacuum = law_with({"gravity": 9.8}).program
    assert all(node.static or node.kind == "variable" for node in vacuum.nodes)
    with_drag = law_with({"drag": 0.01}).program
    products = [n for n in with_drag.nodes if n.kind == "product" and not n.static]
    assert len(products) == 4  # u², w², V u, V w


def sideways(motion, p):
    return ZERO, p.push, ZERO


def test_a_force_across_takes_the_flight_out_of_its_plane():
    push = Force(lambda scene, frame, numbers: {"push": 0.5}, sideways)
    law = law_of(scene(), ALONG_X, DOUBLES, (push,))
    assert law.state is SpaceState
    start = law.state_of(PlaneState(0.0, 1.0, 30.0, 10.0))
    assert start == SpaceState(0.0, 0.0, 1.0, 30.0, 0.0, 10.0)
    ds, dy, dz, du, dv, dw = law.rates(DOUBLES)(*start)
    planar = law_of(scene(), ALONG_X, DOUBLES).rates(DOUBLES)(0.0, 1.0, 30.0, 10.0)
    assert (ds, dz, du, dw) == pytest.approx(planar, rel=1e-15)
    assert (dy, dv) == (0.0, 0.5)


def test_a_force_that_asks_for_what_it_does_not_have_is_told():
    misspelt = Force(lambda scene, frame, numbers: {"pushed": 0.5}, sideways)
    with pytest.raises(AttributeError, match="push"):
        law_of(scene(), ALONG_X, DOUBLES, (misspelt,))


def test_without_a_force():
    law = law_of(scene(), ALONG_X, DOUBLES)
    assert law.without("lift") == law_of(scene(Air(lift_coefficient=0.0)), ALONG_X, DOUBLES)


def test_a_straight_flight_has_no_root():
    """V = w on the way up, -w on the way down; with lift there is no straight flight."""
    law = law_with({"drag": 0.1, "gravity": 9.8})
    for sense, w in ((1.0, 5.0), (-1.0, -5.0)):
        straight = law.straight(sense)
        assert straight.rates(DOUBLES)(0.0, 0.0, 0.0, w) == law.rates(DOUBLES)(0.0, 0.0, 0.0, w)
        assert all(node.kind != "sqrt" for node in straight.program.nodes)
    assert law_with({"lift": 0.1}).straight(1.0) is None


def test_a_ball_drifts_straight_in_a_wind_that_is_the_same_everywhere_alone():
    """Where it grows with the height, a ball that rises with it is blown on."""
    forces = {"lift_coefficient": 0.0, "wind": (3.0, 0.0, 0.0)}
    law = law_of(scene(Air(**forces)), ALONG_X, DOUBLES)
    straight = law.straight(1.0)
    assert straight.rates(DOUBLES)(0.0, 9.0, 3.0, 5.0) == law.rates(DOUBLES)(0.0, 9.0, 3.0, 5.0)
    grows = Air(**forces | {"wind": WindProfile(velocity=(3.0, 0.0, 0.0), height=10.0)})
    assert law_of(scene(grows), ALONG_X, DOUBLES).straight(1.0) is None


ABOVE = {"velocity": (12.0, 0.0, 0.0), "above": 2.0}


def test_a_law_of_several_forms_computes_nothing_before_one_is_chosen():
    """So that no quantity is computed by a form that is not valid in its state."""
    law = law_of(scene(Air(lift_coefficient=0.0, wind=ABOVE)), ALONG_X, DOUBLES)
    state = PlaneState(0.0, 3.0, 20.0, 1.0)
    assert law.state_of(state) == state
    for ask in (
        lambda: law.program,
        lambda: law.rates(DOUBLES),
        lambda: law.jacobian(DOUBLES),
        lambda: law.straight(1.0),
        lambda: law.spin_left(state, DOUBLES),
    ):
        with pytest.raises(TypeError, match=r"law\.on\(branches\)"):
            ask()
    below = state._replace(z=1.0)
    for there, branch, wind in ((state, 1, 12.0), (below, 0, 0.0)):
        blown = law_of(scene(Air(lift_coefficient=0.0, wind=(wind, 0.0, 0.0))), ALONG_X, DOUBLES)
        wanted = blown.rates(DOUBLES)(*there)
        assert branches_at(law, there, DOUBLES) == [branch]
        assert law.on([branch]).rates(DOUBLES)(*there) == wanted
        assert form_at(law, there, DOUBLES).rates(DOUBLES)(*there) == wanted
        assert law.on([branch]).drift(0.0) == (wind, 0.0, 0.0)
