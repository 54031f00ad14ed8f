"""Mistakes in one formula of the chain, planted in right answers, are named again.

A name counts if the formula with it gives the planted numbers in scenes that the search has not
seen; its words do not count.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from longball.judge.diagnosis.chain import I, Kind, Stage, v, v0, μ
from longball.judge.diagnosis.expression import (
    Node,
    axes,
    constant,
    function,
    matrix,
    ordered,
    substitute,
    words,
)
from longball.judge.diagnosis.operators import Edit
from longball.judge.diagnosis.residual import Data, specialised_to, values
from longball.judge.diagnosis.search import OF_OPTION, PAIRS, Explanation, Named
from longball.model.scene import AtBatScene
from tests.judge.material import known, off, planted, truth

USUAL: Any = AtBatScene(id="usual")


@cache
def right(*families: str) -> tuple[tuple[Stage, ...], Data, Data]:
    """The chain of some families, and right answers in two thirds of the scenes."""
    chain = specialised_to(truth(known(*families)))
    return chain, *(truth(known(*families)[first::3]) for first in (0, 1))


def dot(a: Any, b: Any) -> Any:
    return (a * b).sum(axis=0)


def size(a: Any) -> Any:
    return np.sqrt(dot(a, a))


def numbers(columns: dict[str, Any]) -> Any:
    """The columns of impact scenes, by the letters of the model."""
    c = SimpleNamespace(**columns)
    c.V, c.w, c.after = columns["incoming.velocity"], columns["Ṽ·n"], columns["V⁺"]
    c.x, c.y, c.z = columns["contact.position"]
    c.away = np.array([c.x, 0 * c.x, c.z - columns["incoming.bat_height"]])
    c.swing, c.tilt, c.length = columns["ω_bat"], columns["θ"], columns["L"]
    c.lever = c.length / 2 - c.y
    c.bounce, c.kept = columns["ẽ"], columns["e"]
    # m/M_eff is in e(1 + m/M_eff) + m/M_eff; 0 under readings without it. M_eff is I/r̃² or I/r̃.
    c.ratio = (c.bounce - c.kept) / (1 + c.kept)
    c.power = np.where(columns["reading.effective_mass"] == "as_printed", 1, 2)
    return c


def swung(speed: Any, c: Any, tilt: Any = None) -> Any:
    tilt = c.tilt if tilt is None else tilt
    return speed * np.array([np.cos(tilt), 0 * tilt, np.sin(tilt)])


def struck(c: Any, mass: Any) -> Any:
    return -mass * (1 + c.bounce) * c.w


def lost(c: Any, mass: Any = None, share: Any = None) -> Any:
    """The energy that the impact takes; μ from the impulse."""
    mass = -c.J / ((1 + c.bounce) * c.w) if mass is None else mass
    share = 1 - c.bounce**2 if share is None else share
    return -mass * share * c.w**2 / 2


# Formulas of programs with a mistake, by the quantity that they compute, in impact scenes.
FORMULAS: dict[str, list[Callable[[Any], Any]]] = {
    "contact.normal": [
        lambda c: c.away,
        lambda c: (o := c.away + np.array([0, 1, 0])[:, None] * c.y) / size(o),
        lambda c: c.n * np.array([[1], [1], [-1]]),
        lambda c: c.n[[2, 1, 0]],
        lambda c: c.away / c.R,
        lambda c: -c.n,
        lambda c: -c.away / c.R,  # two mistakes
    ],
    "contact.bat_velocity": [
        lambda c: swung(c.swing * c.length / 2, c),
        lambda c: swung(c.swing * (c.length / 2 + c.y), c),
        lambda c: swung(-c.swing * c.y, c),
        lambda c: swung(c.swing * (c.length / 2 - abs(c.y)), c),
        lambda c: c.V_b + c.r_b * np.cross(
            c.swing * np.array([-np.sin(c.tilt), 0 * c.tilt, np.cos(c.tilt)]), c.n, axis=0
        ),
        lambda c: swung(c.swing * c.lever, c, np.radians(c.tilt)),
        lambda c: c.swing * c.lever * np.array([np.sin(c.tilt), 0 * c.tilt, np.cos(c.tilt)]),
        lambda c: c.swing * c.lever * np.array([1 + 0 * c.tilt, 0 * c.tilt, c.tilt]),
        lambda c: swung(c.swing**2 * c.lever, c),
        lambda c: swung(c.swing * c.lever, c, -c.tilt),
        lambda c: swung(c.swing * c.lever, c, np.round(c.tilt, 2)),
        lambda c: swung(c.swing * np.minimum(c.lever, 0.42), c),
        lambda c: swung(USUAL.swing.angular_speed * c.lever, c),
        lambda c: swung(31.7 * c.lever, c),
        lambda c: swung(c.swing * c.lever * np.pi / 30, c),
        lambda c: swung(1.07 * c.swing * c.lever, c),
        lambda c: swung(c.swing * (c.lever + 0.05), c),
        lambda c: swung(c.swing / c.lever, c),
        # Two mistakes
        lambda c: swung(1.07 * c.swing * (c.length / 2 + c.y), c),
        lambda c: swung(1.07 * c.swing * c.length / 2, c),
    ],
    "contact.normal_speed": [
        lambda c: dot(c.V, c.n),
        lambda c: dot(c.V + c.V_b, c.n),
        lambda c: -size(c.V - c.V_b),
        lambda c: abs(c.w),
        lambda c: c.w - 2 * c.n[2] * (c.V - c.V_b)[2],
        lambda c: c.w - c.n[0] * (c.V - c.V_b)[0] + c.n[2] * (c.V - c.V_b)[0],
        lambda c: (c.V - c.V_b)[0],
    ],
    "impact.restitution": [
        lambda c: c.kept,
        lambda c: c.kept + (1 + c.kept) * c.ratio * ((c.length / 2 + c.y) / c.lever) ** c.power,
        lambda c: c.kept + (1 + c.kept) * c.ratio * (c.y / c.lever) ** c.power,
    ],
    "impact.impulse": [
        lambda c: struck(c, c.m),
        lambda c: struck(c, (c.m + c.M) / 2),
        lambda c: struck(c, c.m + c.M),
        lambda c: struck(c, c.m * c.M / (c.m + c.M)),
        lambda c: struck(c, c.m * c.M / np.sqrt(c.m**2 + c.M**2)),
        lambda c: c.J / (1 + c.bounce),
        lambda c: c.J * (1 - c.bounce) / (1 + c.bounce),
        lambda c: c.J * (1 + c.kept) / (1 + c.bounce),
        lambda c: -c.J,
        lambda c: c.J * c.w,
        lambda c: c.J / c.w * dot(c.V, c.n),
        lambda c: c.J / c.w * -size(c.V - c.V_b),
        lambda c: 1.013 * c.J,
    ],
    "impact.velocity": [
        lambda c: c.V - c.J / c.m * c.n,
        lambda c: c.V + c.J / c.M * c.n,
        lambda c: c.V + c.J * (c.m + c.M) / (c.m * c.M) * c.n,
        lambda c: c.V + c.J * c.n,
        lambda c: -c.bounce * c.V,
        lambda c: -c.kept * c.V,
        lambda c: c.V - (1 + c.bounce) * dot(c.V, c.n) * c.n,
        lambda c: c.V - (1 + c.bounce) * c.w * c.n,
        lambda c: c.V_b + c.J / c.m * c.n,
        lambda c: c.J / c.m * c.n,
        lambda c: c.after * np.array([[1], [0], [1]]),
        lambda c: c.V + c.J / c.m * np.array([[1], [0], [0]]),
    ],
    "impact.energy_change": [
        lambda c: lost(c, c.m),
        lambda c: lost(c, c.m * c.M / (c.m + c.M)),
        lambda c: lost(c) * dot(c.after - c.V_b, c.n) ** 2 / c.w**2,
        lambda c: 2 * lost(c),
        lambda c: lost(c, share=1 - c.bounce),
        lambda c: lost(c, share=1 + c.bounce**2),
        lambda c: lost(c, share=-(c.bounce**2)),
        lambda c: lost(c, share=1 - c.kept**2),
        lambda c: lost(c, share=1),
        lambda c: lost(c) / c.w,
        lambda c: c.m * (dot(c.after, c.after) - dot(c.V, c.V)) / 2,
    ],
}  # fmt: skip


@np.errstate(all="ignore")  # as `diagnose`
def check(stage: Stage, given: Callable[[Any], Any], *families: str) -> None:
    """Assert that the edit which gives these values of a stage is named, and holds elsewhere."""
    chain, some, others = right(*families)
    data, columns = planted(some, chain, given)
    wrong = off(stage, data, columns)
    assert wrong.beyond.sum() > 5
    found = Explanation(chain, stage, data, columns, wrong, pairs=PAIRS[stage.kind]).explain()
    assert isinstance(found, Named), found.nearest
    for edit in found.edits:
        (stage,) = edit.apply([stage])
    assert not off(stage, *planted(others, chain, given)).beyond.any()


@pytest.mark.parametrize(
    ("quantity", "number"), [(q, i) for q, some in FORMULAS.items() for i in range(len(some))]
)
def test_a_wrong_formula_of_an_impact_is_named(quantity: str, number: int):
    (stage,) = (s for s in right("impact")[0] if s.quantities[0] == quantity)
    mistake = FORMULAS[quantity][number]
    check(stage, lambda columns: {quantity: mistake(numbers(columns))}, "impact")


def level(a: Any) -> Any:
    return a * np.array([[1], [1], [0]])


def to_the_fence(c: Any) -> Any:
    """The point on the fence, if its distance is linear in the bearing."""
    chord = c["chord.a"], c["chord.b"], c["fence.position"]
    bearings = [np.arctan2(x[1], x[0]) for x in chord]
    a, b, at = (size(level(x)) for x in chord)
    far = (a + (bearings[2] - bearings[0]) / (bearings[1] - bearings[0]) * (b - a)) / at
    far = np.where(np.isfinite(far), far, 1.0)  # a circle has no chords
    return c["fence.position"] * np.array([far, far, far**0])


# Mistakes in other formulas and at the ends of flights: the family, the stage's kind, the quantity,
# and the program's formula for it.
OTHERS: list[tuple[str, Kind, str, Callable[[Any], Any]]] = [
    ("impact-oblique", "formula", "impact.friction_margin", lambda c: c["friction_margin"] - 1),
    ("impact-oblique", "formula", "impact.spin", lambda c: -c["ω⁺"]),
    ("flight-both", "formula", "landing.distance", lambda c: c["landing.position"][0]),
    ("flight-both", "formula", "landing.distance", lambda c: size(c["landing.position"])),
    ("flight-both", "formula", "landing.distance",
     lambda c: size(level(c["landing.position"] - c["launch.position"]))),
    ("flight-both", "formula", "landing.distance",
     lambda c: dot(c["landing.position"] - c["launch.position"], level(c["launch.velocity"]))
     / size(level(c["launch.velocity"]))),
    ("flight-both", "formula", "landing.distance",
     lambda c: size(level(c["landing.position"])) / 0.3048),
    ("flight-both", "formula", "landing.distance",
     lambda c: dot(level(c["landing.position"]), c["landing.velocity"])
     / size(c["landing.velocity"])),
    ("at-bat-real", "formula", "landing.path",
     lambda c: c["landing.path"] + np.nan_to_num(c["the pitch's path"])),
    ("at-bat", "formula", "landing.time", lambda c: c["landing.time"] - c["contact.time"]),
    ("at-bat", "formula", "landing.time",
     lambda c: c["landing.time"] - c["contact.time"] + c["plate.time"]),
    ("at-bat", "formula", "contact.margin", lambda c: -c["margin"]),
    ("at-bat", "formula", "contact.margin", lambda c: c["margin"] - c["r_b"]),
    ("at-bat", "formula", "contact.margin", lambda c: c["R"] + c["r_b"] - abs(c["σ_b"])),
    ("at-bat", "formula", "contact.margin",  # of a search that ends at the plate
     lambda c: np.where(
         c["σ_b"] * c["plate.velocity"][2] > 0, c["R"] + c["r_b"] - abs(c["σ_b"]), c["margin"]
     )),
    ("fence", "formula", "fence.clearance", lambda c: c["fence.clearance"] - c["R"]),
    ("fence", "formula", "fence.clearance", lambda c: c["fence.position"][2]),
    ("fence", "event", "fence.position", to_the_fence),
    ("fence", "formula", "fence.margin",
     lambda c: size(level(c["chord.b"] - c["chord.a"]))),
    ("fence", "formula", "fence.margin", lambda c: c["fence.margin"] / 2),
    ("flight-both", "event", "landing.position",
     lambda c: c["landing.position"] + c["R"] * np.array([[0], [0], [1]])),
    ("flight-both", "event", "landing.position",
     lambda c: c["landing.position"] - c["ground"] * np.array([[0], [0], [1]])),
    ("pitch", "event", "plate.position",
     lambda c: c["plate.position"] + 0.4318 * np.array([[1], [0], [0]])),
    ("pitch", "event", "plate.position",
     lambda c: c["plate.position"] + c["R"] * np.array([[1], [0], [0]])),
    ("at-bat", "event", "contact.position",
     lambda c: c["contact.position"] - c["R"] * c["n"]),
]  # fmt: skip


@pytest.mark.parametrize(("family", "kind", "quantity", "given"), OTHERS)
def test_another_wrong_formula_is_named(
    family: str, kind: Kind, quantity: str, given: Callable[[Any], Any]
):
    (stage,) = (s for s in right(family)[0] if (s.quantities[0], s.kind) == (quantity, kind))
    check(stage, lambda columns: {quantity: given(columns)}, family)


# Mistakes in the law and the launch of flights: the family, a node of the law by its words ("" for
# all of it), and the node that replaces it.
displaced = I["ρ_0"] * (I["R"] * I["R"] * I["R"]) * (4 / 3 * np.pi) / I["m"]
FLIGHTS: dict[str, tuple[str, str, Callable[[Node], Node]]] = {
    "no U": ("flight-both", "U", lambda U: constant(1.0, U.dimension)),
    "U of the launch": ("flight-both", "U", lambda U: substitute(U, v, v0)),
    "y backwards": ("flight-both", "dr/dt", lambda u: axes(u, ASIDE, "own axes")),
    "a growing spin": ("flight-spin-decay", "path", lambda path: -path),
    "the aim": ("pitch", "aim_y", lambda _: I["aim_z"]),
    "buoyancy": ("flight-both", "g", lambda g: g * (1.0 - displaced)),
    "added mass": ("flight-both", "", lambda law: law / (1.0 + displaced / 2.0)),
    "Magnus": (
        "flight-weather",
        "p_s",
        lambda _: 611.2 * function("exp", 17.62 * (I["T"] - 273.15) / (I["T"] - 30.03)),
    ),
}
ASIDE = (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize("mistake", FLIGHTS)
def test_a_wrong_law_is_named(mistake: str):
    family, text, new = FLIGHTS[mistake]
    stage = next(s for s in right(family)[0] if s.kind == "flight")
    nodes = ordered([stage.roots["law"], *stage.roots.values()])
    old = next((node for node in nodes if words(node) == text), stage.roots["law"])
    wrong = stage.edited(old, new(old))
    check(stage, lambda columns: values(wrong, columns), family)


def test_a_mistake_in_the_matrix_of_the_friction_is_named():
    stage = next(s for s in right("impact-oblique")[0] if s.name == "friction margin")
    (K,) = (node for node in ordered(stage.roots.values()) if node.op == "matrix")
    turned = next(node for node in ordered(K.args[:1]) if words(node) == "r × a")
    other = matrix("K", substitute(K.args[0], turned, -turned))
    wrong = stage.edited(K, other)
    check(stage, lambda columns: values(wrong, columns), "impact-oblique")


def test_a_number_for_a_matrix_is_named():
    """The energy with P/μ for K P."""
    chain = right("impact-oblique")[0]
    (energy,) = (s for s in chain if s.name == "energy")
    (P,) = (x for x in ordered(energy.roots.values()) if x.data == "P")
    turned = [x for x in ordered(energy.roots.values()) if x.op == "times" and x.args[1] is P]
    (sum_of,) = (x for x in ordered(energy.roots.values()) if x.op == "sum" and x.args[0] in turned)
    wrong = energy.edited(sum_of, P / μ)
    check(energy, lambda columns: values(wrong, columns), "impact-oblique")


@pytest.mark.parametrize("breaks", [False, True])
@np.errstate(all="ignore")
def test_an_edit_that_explains_a_part_of_the_errors_and_breaks_no_scene(breaks: bool):
    chain, some, _ = right("impact")
    (stage,) = (s for s in chain if s.quantities[0] == "impact.energy_change")

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        c = numbers(columns)
        other = lost(c) if breaks else lost(c) ** 3 * c.y + 1.0  # right, or what nobody writes
        return {"impact.energy_change": np.where(c.y > np.median(c.y), lost(c, c.m), other)}

    data, columns = planted(some, chain, given)
    wrong = off(stage, data, columns)
    found = Explanation(chain, stage, data, columns, wrong).explain()
    if breaks:
        assert not isinstance(found, Named)
    else:
        assert isinstance(found, Named)
        y = columns["contact.position"][1]
        assert found.mends == (wrong.beyond & (y > np.median(y))).sum()
        after = off(found.edits[0].apply([stage])[0], data, columns)
        assert after.beyond.sum() == wrong.beyond.sum() - found.mends


@np.errstate(all="ignore")
def test_a_mistake_in_one_option_costs_the_choice_of_the_option():
    """One of n or none of those that all wrong scenes share, log2(1 + n): here of one, 1 bit."""
    chain, some, _ = right("impact")
    (stage,) = (s for s in chain if s.name == "impulse")
    key, option = "reading.effective_mass", "as_printed"

    def given(columns: dict[str, Any]) -> dict[str, Any]:
        return {"impact.impulse": np.where(columns[key] == option, -1.0, 1.0) * columns["J"]}

    data, columns = planted(some, chain, given)
    wrong = off(stage, data, columns)
    like = np.flatnonzero(columns[key][wrong.some] == option)
    there = Explanation(chain, stage, data, columns, wrong.of(like), OF_OPTION).explain()
    search = Explanation(chain, stage, data, columns, wrong)
    # Among edits of equal bits, those of the option come before those of nodes that all scenes use.
    (root,) = stage.roots.values()
    (chosen,) = (node for node in ordered([root]) if node.op == "switch" and node.data[0] == key)
    arm = chosen.args[chosen.data[1].index(option)]
    bits = [search.rank(Edit(node, -node, 1.0, "")) for node in (arm, chosen, root)]
    other = substitute(root, arm, constant(1.0, arm.dimension))
    within = search.rank(Edit(root, other, 1.0, ""))
    assert max(bits[0], within) < bits[1] < bits[2]
    found = search.of_one_option()
    assert isinstance(there, Named)
    assert isinstance(found, Named)
    assert found.evidence == pytest.approx(there.evidence - 1.0)
    edited = chain
    for edit in found.edits:
        edited = edit.apply(edited)
    (stage,) = (s for s in edited if s.name == "impulse")
    assert not off(stage, data, columns).beyond.any()
