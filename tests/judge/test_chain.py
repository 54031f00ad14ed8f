"""The judge's chain as data, held to proven results of every family."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from longball import golden
from longball.engines.chain import solve
from longball.engines.ivp import Ivp
from longball.engines.verlet import PUSHES, TREATMENTS, Verlet
from longball.judge.cases import decidable, solved
from longball.judge.diagnosis.chain import ACCELERATION, CHAIN, LAW, OWN, RATE, SPEED, U, u
from longball.judge.diagnosis.diagnose import prepared
from longball.judge.diagnosis.expression import NONE, constant, evaluate, norm, ordered, substitute
from longball.judge.diagnosis.residual import compared, follow, seen, specialised_to
from longball.model.scene import Bat, Ground, ImpactScene, Incoming, Swing
from tests.judge.material import known, right, truth

FAMILIES = [
    "flight-vertical", "flight-both", "flight-spin-lift", "flight-spin-drag", "flight-spin-decay",
    "flight-wind", "flight-weather", "flight-side", "flight-real", "pitch", "impact",
    "impact-oblique", "at-bat", "at-bat-real", "fence",
]  # fmt: skip

# In a few scenes of these families the ball touches a kink of the law, or follows one: the judge
# cannot fly those.
BENT = ["edges", "flight-kinks", "combined", "various", "various-real"]


@pytest.mark.parametrize("family", FAMILIES + BENT)
def test_every_stage_follows_from_the_true_values_before_it(family):
    data = truth(known(family))
    chain = specialised_to(data)
    if family in BENT:
        data = seen(chain, data)
        assert sum(map(len, data.blind.values())) <= 4  # tables and jumps are flown
    _, found = follow(chain, data)
    for one in found:
        which = one.beyond if family in BENT else one.wrong
        ids = [data.cases[i].id for i in one.some[which]]
        assert not ids, (one.stage.name, ids)
    # Something was compared: every quantity that the family has is a stage's.
    compared = {q for one in found if one.checked.any() for q in one.stage.quantities}
    told = {q for q in OWN if np.isfinite(data.given[q]).any()}
    clocks = {"plate.time", "contact.time", "landing.hang_time", "fence.time"}
    assert told - compared - clocks <= {"contact.margin"}


@pytest.mark.parametrize("family", [*FAMILIES, "various-real"])
def test_every_form_of_a_formula_has_its_values(family):
    cases = known(family)
    data = truth(cases[:: max(1, len(cases) // 6)])
    chain = specialised_to(data)
    columns, _ = follow(chain, data)
    # In the first other form, k C_L U² ê × u/|ê × u|, |ê × u| = U holds only for motion in a plane.
    sideways = "air.wind", "air.side_coefficient", "earth"
    plane = np.all([columns[key] == "none" for key in sideways], axis=0)
    for stage in chain:
        here = np.isin(columns["kind"], stage.scenes)
        for name, forms in stage.forms.items():
            for i, form in enumerate(forms):
                other = replace(stage, roots={**stage.roots, name: form})
                some = np.flatnonzero(here & plane if (name, i) == ("law", 0) else here)
                found, _ = compared(other, data, columns, some)
                assert not found.beyond.any(), (stage.name, form)


@pytest.mark.parametrize("family", ["impact", "flight-both", "at-bat", "fence"])
def test_a_value_moved_by_a_millionth_does_not_follow(family):
    data = truth(known(family))
    chain = specialised_to(data)
    for quantity in OWN:
        if not np.isfinite(data.given[quantity]).any() or quantity in ("contact.margin",):
            continue
        moved = data.given[quantity] * (1 + 1e-6) + 1e-6
        other = data.__class__(**{**vars(data), "given": {**data.given, quantity: moved}})
        _, found = follow(chain, other)
        assert any(one.wrong.any() for one in found), quantity


def test_formulas_have_the_dimension_of_their_quantity():
    for stage in CHAIN:
        if stage.kind == "formula":
            (value,), (quantity,) = stage.roots.values(), stage.quantities
            assert (value.dimension, value.vector) == (
                OWN[quantity].dimension, OWN[quantity].vector,
            ), stage.name  # fmt: skip
        if stage.kind == "flight":
            dimensions = [stage.roots[name].dimension for name in ("place", "velocity", "spin")]
            assert dimensions == [(1, 0, 0), SPEED, RATE]
            assert stage.roots["law"].dimension == ACCELERATION


def test_sums_have_one_dimension():
    for root in (root for stage in CHAIN for root in stage.roots.values()):
        for node in ordered([root]):
            if node.op in ("sum", "where", "switch"):
                options = node.args[-2:] if node.op == "where" else node.args
                kinds = {(x.dimension, x.vector) for x in options}
                # Numbers such as 273.15 in formulas of the weather have the unit of their table.
                assert len(kinds) == 1 or all(d == NONE for d, _ in kinds), node


def test_drag_and_lift_have_one_airspeed():
    """So that a program that takes another size for it in both is one edit away."""
    changed = substitute(LAW, U, constant(1.0, SPEED))
    assert norm(u) in ordered([LAW])
    assert norm(u) not in ordered([changed])


def in_steps(engine, scenes):
    """Right answers of the paper's scheme: the data, and what follows from them."""
    cases = [case for case in solved(scenes, engine) if decidable(case)]
    data, chain = prepared(cases, right(cases), engine)
    assert not sum(map(len, data.blind.values()))
    return data, *follow(chain, data)


FORCES = zip(TREATMENTS, itertools.cycle(PUSHES))


@pytest.mark.parametrize(("forces", "push"), [*FORCES, ("old_carried", "early")])
def test_every_stage_and_form_of_the_papers_scheme_follows(forces, push):
    engine = Verlet(dt=0.01, forces=forces, contact_force=push)
    data, columns, found = in_steps(engine, [case.scene for case in golden.load("at-bat")[::4]])
    assert not any(one.beyond.any() for one in found)
    (met,) = (one for one in found if one.stage.name == "contact time")
    assert met.checked.sum() > 5
    (form,) = met.stage.forms["value"]
    other, _ = compared(replace(met.stage, roots={"value": form}), data, columns, met.some)
    assert not other.beyond.any()


def test_balls_that_land_while_they_are_pushed():
    """Balls struck downwards, 0.2 m above the ground."""
    engine, low = Verlet(dt=0.02), []
    for case in golden.load("at-bat"):
        result = solve(case.scene, engine)
        if result.outcome == "batted" and float(result.impact.velocity[2]) < -5:
            ground = Ground(height=float(result.contact.position[2]) - 0.2)
            low.append(case.scene.model_copy(update={"ground": ground}))
    data, _, found = in_steps(engine, low)
    assert (data.given["landing.hang_time"] < 2 * engine.dt).sum() > 4
    assert not any(one.beyond.any() for one in found)


def test_a_contact_at_a_step_is_pushed_from_there():
    """0.29 s are 28.999999999999996 steps of 0.01 s: the push does not begin a step before."""
    engine = Verlet(dt=0.01)
    data, columns, _ = in_steps(engine, [case.scene for case in golden.load("at-bat")[::9]])
    (stage,) = (stage for stage in specialised_to(data) if stage.name == "flight")
    columns = stage.with_spin(columns)
    time = str(OWN["contact.time"].data)

    def landed(contact):
        found, _ = data.ways["flight"](stage, {**columns, time: np.full(len(data.cases), contact)})
        return found["landing.position"]

    assert np.array_equal(landed(0.29), landed(0.0), equal_nan=True)
    assert not np.array_equal(landed(0.289), landed(0.0), equal_nan=True)


@pytest.mark.parametrize("along", [60.0, -60.0])
def test_a_ball_slides_that_would_have_to_be_pulled_to_grip(along):
    """A slow ball that flies along the bat: P_n of the gripping impulse is negative in one case."""
    scene = ImpactScene(
        id="slow",
        swing=Swing(angular_speed=0.0),
        bat=Bat(friction=0.3),
        incoming=Incoming(
            position=(0.0696, 0.0, 1.0), bat_height=1.0, velocity=(-0.05, along, 0.0)
        ),
    )
    data = truth(solved([scene], Ivp()))
    _, found = follow(specialised_to(data), data)
    assert data.given["impact.friction_margin"] < -100
    assert not [one.stage.name for one in found if one.beyond.any()]


def test_definitions_of_other_programs_give_the_properties_of_air():
    """Moist air at 20 °C and 1013.25 hPa with half of the vapour that it can hold (CIPM-2007)."""
    weather = {"T": 293.15, "p": 101325.0, "φ": 0.5, "h": 0.0}
    columns = {**weather, "reading.pressure": np.array(["station"])}
    stage = next(stage for stage in CHAIN if stage.kind == "flight")
    found = [
        float(np.squeeze(evaluate(node, columns)))
        for node in stage.pool
        if {x.data for x in ordered([node]) if x.op == "symbol"} <= weather.keys()
    ]
    pressure, density, sound = 2339.3, 1.19886, 343.37  # Pa, kg/m³, m/s (of dry air)
    assert sorted(found) == pytest.approx([density, sound, *[pressure] * 3], rel=3e-3)
