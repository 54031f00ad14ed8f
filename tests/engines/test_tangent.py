"""Derivatives in jets: against closed forms, differences of proven results, and golden data.

A golden derivative is a difference good to a thousandth, rounded to three digits: 6 in the third
digit at most. What is proven to 40 digits at two inputs 2^-49 apart has a slope of 20 digits, so
that a difference from it is the derivative's own error; that is held against 1e-12 of the size of
the quantity for an input that changes by its size, as a derivative that is zero has no relative
error.
"""

from __future__ import annotations

import json
import math
import operator
import re
from decimal import Decimal
from itertools import product

import numpy as np
import pytest

import longball as lb
from longball import golden
from longball.engines.batch.columns import NUMBERS
from longball.engines.batch.slopes import ColumnJet, ColumnJets
from longball.engines.chain import solve
from longball.engines.enclosure import Enclosure
from longball.engines.engine import CannotSolve
from longball.engines.ivp import Ivp
from longball.engines.multiprecision import Multiprecision
from longball.engines.tangent import Jet, Jets, Kink, Seed, derivatives_by, derivatives_of
from longball.golden.case import ROUNDING, decisions
from longball.golden.condition import magnitudes
from longball.model.inputs import STEP, inputs, with_input
from longball.model.numbers import DOUBLES, Undecided
from longball.model.quantities import numbers_of
from longball.model.scene import FlightScene, parse_scene
from tests.calls import check_wrong_calls
from tests.scenes import FAMILIES, case_of, cases_of

THREE_DIGITS, GOOD = 6e-3, 1e-12

# The launch is 1e-12 from a node of a table, and a rounding of the airspeed a hundredth of it: how
# the result depends on the node is known to two digits.
AT_A_NODE = re.compile(r"flight-kinks-.*-node-.*-1e-12")

# One number of each of these is at a corner; a golden derivative there is a difference across it.
AT_A_CORNER = {
    "the pitch passes the bat's axis": ("edges-tip-out", "swing.height_offset", "contact.margin"),
    "the launch is at the height where the wind sets in": (
        "flight-kinks-on-height-down",
        "launch.position[2]",
        "landing.distance",
    ),
    "the launch is from the ground, along it": (
        "hard-ground-along-vacuum",
        "launch.position[2]",
        "landing.distance",
    ),
}


@pytest.mark.nightly
@pytest.mark.parametrize("family", FAMILIES)
def test_derivatives_are_those_of_the_golden_cases(family):
    compared, faults = 0, []
    for case in cases_of(family):
        if case.condition is None or AT_A_NODE.fullmatch(case.id):
            continue
        sizes = {name: abs(q.double) for name, q in case.quantities.items()}
        for name, x in inputs(case.scene).items():
            try:
                found = derivatives_by(case.scene, name, Ivp())
            except (CannotSolve, Undecided):
                continue
            for quantity, row in case.condition.derivatives.items():
                known, slope = row[name], found[quantity]
                if known is None or math.isnan(slope):
                    continue
                least = GOOD * (1 + sizes[quantity]) / (abs(x) or 1.0)
                off = THREE_DIGITS * abs(known) + least
                compared += 1
                right = abs(slope - known) <= off
                if not (right or is_proven(case.scene, name, quantity, slope, least)):
                    faults.append((case.id, name, quantity, slope, known))
    assert faults == []
    assert compared > 50


def is_proven(scene, name: str, quantity: str, slope: float, least: float) -> bool:
    """True if proven slopes say otherwise than a golden one, whose differences may be wider.

    They differ to the left and to the right; or they agree with the derivative.
    """
    left, right = (one_sided(scene, name, side) for side in (-1, 1))
    if left is None or right is None or is_corner(scene, name):
        return True
    proven = (left[quantity] + right[quantity]) / 2
    return math.isclose(slope, proven, rel_tol=1e-9, abs_tol=least)


def is_corner(scene, name: str) -> bool:
    """True where proven slopes to the left and to the right differ."""
    left, right = (one_sided(scene, name, side) for side in (-1, 1))
    return left is None or any(
        not math.isclose(left[q], right[q], rel_tol=1e-3, abs_tol=1e-9) for q in left
    )


def one_sided(scene, name: str, side: int) -> dict[str, float] | None:
    x = inputs(scene)[name]
    moved = x + side * STEP * (abs(x) or 1.0)
    there = with_input(scene, name, moved)
    engine = Enclosure(40)
    here, beyond = solve(scene, engine), there and solve(there, engine)
    if beyond is None or decisions(here) != decisions(beyond):
        return None
    ends = zip(numbers_of(here), numbers_of(beyond), strict=True)
    width = Decimal(moved) - Decimal(x)
    return {q: float((Decimal(b.value) - Decimal(a.value)) / width) for (q, a), (_, b) in ends}


PROVEN = [
    pytest.param("flight-real-0003", 12, marks=pytest.mark.nightly),
    ("at-bat-real-0002", 10),
    pytest.param("combined-at-bat-0001", 12, marks=pytest.mark.nightly),
    ("impact-oblique-0004", 3),
    ("fence-stepped-0000", 6),
    pytest.param("flight-kinks-moving-table-time", 5, marks=pytest.mark.nightly),
    ("hard-graze-plus-1e-06", 5),
    ("hard-dip-phugoid-under-1e-06", 4),
]


@pytest.mark.parametrize(("identity", "every"), PROVEN)
@pytest.mark.sampled(every=4)
def test_derivatives_have_twelve_digits(identity, every, nightly):
    case = case_of(identity)
    names = [*inputs(case.scene)]
    compared, faults = twelve_digits(case, names if nightly else names[1::every])
    assert faults == []
    assert compared > 10


def twelve_digits(case: golden.Case, names: list[str]) -> tuple[int, list[tuple[object, ...]]]:
    """Compare derivatives with differences of proven results; return how many, and those off."""
    compared, faults = 0, []
    sizes = magnitudes(case.expected)
    for name in names:
        left, right = (one_sided(case.scene, name, side) for side in (-1, 1))
        try:
            found = derivatives_by(case.scene, name, Ivp())
        except (CannotSolve, Undecided):
            continue
        if left is None or right is None:
            continue
        x = abs(inputs(case.scene)[name]) or 1.0
        for quantity in found.keys() & sizes.keys():
            slope = found[quantity]
            truth = (left[quantity] + right[quantity]) / 2
            off = GOOD * (abs(truth) + sizes[quantity] / x)
            if quantity == "contact.margin":
                off += turned(case) * abs(found["plate.time"]) * sizes["plate.velocity[0]"]
            compared += not math.isnan(slope)
            if not (abs(slope - truth) <= off or math.isnan(slope)):
                faults.append((case.id, name, quantity, slope, truth))
    return compared, faults


def turned(case: golden.Case) -> float:
    """Return by how much, rad, doubles turn the direction from the bat's axis to the ball.

    By roundings of the way from the mound, over the distance from the axis. A margin changes by
    that much of the way by which an input moves the ball.
    """
    reach = case.scene.bat.radius + case.scene.ball.radius
    away = reach - case.quantities["contact.margin"].double
    return case.scene.pitch.release[0] * 8 * ROUNDING / away


@pytest.mark.parametrize("of", AT_A_CORNER)
def test_there_is_no_derivative_at_a_corner(of):
    identity, name, quantity = AT_A_CORNER[of]
    scene = case_of(identity).scene
    derivatives = derivatives_of(scene, [quantity], [name], Ivp())
    assert math.isnan(derivatives[quantity][name])
    assert is_corner(scene, name)


def test_a_refusal_has_its_reason():
    scene = case_of("flight-kinks-on-height-down").scene
    derivatives = derivatives_of(scene, ["landing.time"], ["gravity", "air.wind.above"], Ivp())
    assert derivatives["landing.time"]["gravity"] < 0
    (reason,) = derivatives.refused.values()
    assert "the ball passes the height above which the wind blows" in reason


def test_a_ball_that_grazes_the_ground_is_refused():
    # v²/(2g) above its lowest point: it only touches the ground, z = 0, there.
    scene = FlightScene.model_validate(
        {
            "air": {"density": 1.25, "drag_coefficient": 0.0, "lift_coefficient": 0.0},
            "launch": {"position": (0, 0, 0), "velocity": (30.0, 0, 0)},
        }
    )
    with pytest.raises(Kink):
        derivatives_by(scene, "launch.velocity[2]", Ivp())


def test_a_ball_that_is_dropped_with_a_spin_is_refused():
    # The velocity across the spin is zero: its direction, that of the lift, is none.
    scene = case_of("hard-rest-dropped-air-spin").scene
    with pytest.raises(Kink, match="at rest in the air"):
        derivatives_by(scene, "ball.mass", Ivp())


def vacuum(gravity=9.8, x=0.5, z=1.25, u=31.0, w=22.0, ground=0.25) -> FlightScene:
    return FlightScene.model_validate(
        {
            "air": None,
            "gravity": gravity,
            "launch": {"position": (x, 0, z), "velocity": (u, 0, w)},
            "ground": {"height": ground},
        }
    )


@pytest.mark.parametrize("engine", [Ivp(), Multiprecision(20), Enclosure(20)], ids=repr)
def test_a_parabola_has_the_derivatives_of_its_closed_form(engine):
    # t = (w + √D)/g, D = w² + 2 g (z - h); d = x + u t
    g, u, w, drop = 9.8, 31.0, 22.0, 1.0
    root = math.sqrt(w * w + 2 * g * drop)
    t = (w + root) / g
    expected = {
        "launch.position[0]": 1.0,
        "launch.position[2]": u / root,
        "launch.velocity[0]": t,
        "launch.velocity[2]": u * (1 + w / root) / g,
        "gravity": u * (drop / (g * root) - t / g),
        "ground.height": -u / root,
    }
    for name, slope in expected.items():
        found = derivatives_by(vacuum(), name, engine)["landing.distance"]
        assert float(found) == pytest.approx(slope, rel=1e-14)


def test_what_trackers_give_has_the_derivatives_of_its_closed_form():
    scene = vacuum(z=0.25)
    v, angle = math.hypot(31.0, 22.0), math.atan2(22.0, 31.0)
    # d - x = v² sin 2θ / g
    by = {
        "launch.speed": 2 * v * math.sin(2 * angle) / 9.8,
        "launch.angle": 2 * v * v * math.cos(2 * angle) / 9.8,
        "launch.direction": 0.0,
    }
    for name, slope in by.items():
        found = derivatives_by(scene, name, Ivp())
        assert found["landing.distance"] == pytest.approx(slope, rel=1e-13, abs=1e-12)
    aside = derivatives_by(scene, "launch.direction", Ivp())["landing.position[1]"]
    assert aside == pytest.approx(v * v * math.sin(2 * angle) / 9.8, rel=1e-13)


# Dimensions of the inputs: powers of kg, m, s.
DIMENSIONS = {
    "ball.mass": (1, 0, 0),
    "ball.radius": (0, 1, 0),
    "air.density": (1, -3, 0),
    "gravity": (0, 1, -2),
    "launch.position": (0, 1, 0),
    "launch.velocity": (0, 1, -1),
    "launch.spin": (0, 0, -1),
    "air.wind": (0, 1, -1),
    "air.density_scale_height": (0, 1, 0),
    "ground.height": (0, 1, 0),
}


def test_other_units_change_a_distance_as_euler_says():
    # Σ (power of a unit in x) x ∂d/∂x is that power of d, for each unit; no form of the air's laws
    # below has a constant with a dimension.
    scene = parse_scene(
        '{"kind": "flight", "launch": {"position": [0.5, 0.1, 1], "velocity": [38, 6, 21], '
        '"spin": [20, -180, 40]}, "air": {"density": 1.2, "drag_coefficient": 0.35, '
        '"lift_coefficient": {"law": "rational"}, "wind": [3, -1, 0.25], '
        '"density_scale_height": 9000}, "ground": {"height": 0.25}}'
    )
    sums, sizes = [0.0] * 3, [0.0] * 3
    for name, x in inputs(scene).items():
        slope = derivatives_by(scene, name, Ivp())["landing.distance"]
        for unit, power in enumerate(DIMENSIONS.get(name.partition("[")[0], (0, 0, 0))):
            sums[unit] += power * x * slope
            sizes[unit] += abs(power * x * slope)
    distance = solve(scene, Ivp()).landing.distance
    for total, size, power in zip(sums, sizes, (0, 1, 0), strict=True):
        assert size > 0
        assert total == pytest.approx(power * distance, abs=GOOD * size)


@pytest.mark.parametrize("offset", [0.3, -0.2])
def test_the_margin_of_a_miss_has_the_derivatives_that_are_proven(offset):
    """It is taken at a time that changes with the scene, and that makes no difference."""
    scene = parse_scene(json.dumps({"kind": "at-bat", "swing": {"height_offset": offset}}))
    names = ["swing.height_offset", "pitch.speed", "pitch.release[2]", "ball.mass"]
    found, proven = (
        derivatives_of(scene, ["contact.margin"], names, engine)["contact.margin"]
        for engine in (Ivp(), Enclosure(30))
    )
    for name in names:
        assert found[name] == pytest.approx(float(proven[name].value), abs=5 * GOOD)


FORMULAS = [
    lambda x, y, n: x + y - 2 * x * y / 5 + x / y - (7 - y) + 3 / x + abs(1 - x),
    lambda x, y, n: n.sqrt(x * x + y * y) + n.angle(y, x) + n.angle(-y, 2 * x),
    lambda x, y, n: n.functions["exp"](x / y) * n.functions["log"](x * y),
    lambda x, y, n: n.cos_sin(x)[0] * n.cos_sin(y)[1] + n.functions["unit"](x, n.sqrt(y)),
]


@pytest.mark.parametrize("jets", [Jets(DOUBLES), ColumnJets(NUMBERS)], ids=["one", "columns"])
@pytest.mark.parametrize("formula", FORMULAS)
def test_jets_follow_the_rules_of_derivatives(formula, jets):
    columns, h = isinstance(jets, ColumnJets), 1e-5
    for x, y, dx, dy in ((3.0, 5.0, 0.5, -2.0), (0.5, 0.25, -1.0, 0.5)):
        parts = [
            ColumnJet(np.array([a]), np.array([[da]])) if columns else Jet(a, da)
            for a, da in ((x, dx), (y, dy))
        ]
        found = formula(*parts, jets)
        assert np.ravel(found.value).item() == pytest.approx(formula(x, y, DOUBLES), rel=1e-15)
        ends = [formula(x + sign * h * dx, y + sign * h * dy, DOUBLES) for sign in (1, -1)]
        assert np.ravel(found.rate).item() == pytest.approx((ends[0] - ends[1]) / (2 * h), rel=1e-7)


def test_seeds_add_as_numbers_do():
    total = 1.0 + (Seed(3.0, 0.5) + Seed(5.0, -2.0))
    assert (total, total.rate) == (9.0, -1.5)


def test_jets_compare_as_their_numbers():
    for a, b in product((1.0, 2.0), repeat=2):
        for compare in (operator.lt, operator.le, operator.gt, operator.ge):
            assert compare(Jet(a, 5.0), Jet(b, 3.0)) == compare(Jet(a, 5.0), b) == compare(a, b)


# --- as `lb.solve` gives them ---------------------------------------------------------------------


def test_a_solution_has_them_if_asked():
    scene = vacuum()
    result = lb.solve(scene, derivatives=True)
    assert set(result.derivatives["landing.distance"]) == set(inputs(scene))
    assert set(result.derivatives) >= {"landing.time", "landing.velocity[2]"}
    some = lb.solve(scene, derivatives=["gravity"]).derivatives
    assert some["landing.time"] == {"gravity": result.derivatives["landing.time"]["gravity"]}
    with pytest.raises(KeyError, match=r"the nearest are landing\.distance"):
        some["landing.distnce"]
    with pytest.raises(ValueError, match="derivatives=True"):
        _ = lb.solve(scene).derivatives


WRONG = """
lb.solve(vacuum(), derivatives=["launch.sped"]) -> did you mean launch.speed
lb.solve(vacuum(), derivatives="gravity") -> a list of names is needed
lb.solve(vacuum(), derivatives=True, engine="verlet") -> take ivp, multiprecision or enclosure
lb.solve(vacuum(), derivatives=True, certify=True) -> enclosure
"""


def test_what_has_no_derivatives_is_refused():
    check_wrong_calls(WRONG, globals())
