"""The oblique impulse that the judge puts together from parts is the engines' own."""

from dataclasses import fields

import pytest

from longball.engines.chain import MODEL, solve
from longball.engines.chain.collision import Impact, collide
from longball.engines.ivp import Ivp
from longball.golden import load
from longball.judge.contact_mistakes import _PIVOT, IMPACT, Parts, _struck
from longball.model.numbers import dot

KEPT = [
    case
    for case in load("impact-oblique")
    if case.expected.impact is not None and case.scene.bat.friction is not None
]


def struck(case, seen):
    """Solve a scene, and keep its contact and impact."""

    def collision(cases, contact, error, *carried):
        made = collide(cases, contact, error, *carried)
        seen.append((contact, made[1]))
        return made

    return solve(case.scene, Ivp(), MODEL.__class__(MODEL.forces, collision))


@pytest.mark.parametrize("case", KEPT, ids=lambda case: case.id)
def test_with_the_usual_parts_it_is_that_of_the_chain(case):
    seen = []
    if struck(case, seen).impact is None:  # doubles do not decide it
        return
    ((contact, right),) = seen
    made = _struck(case.scene, contact, Parts())
    for quantity in fields(Impact):
        wanted, found = getattr(right, quantity.name), getattr(made, quantity.name)
        assert found == (wanted if wanted is None or isinstance(wanted, str) else
                         pytest.approx(wanted, rel=1e-9, abs=1e-12))  # fmt: skip


def test_each_mistake_changes_an_impact():
    for mistake in (m for m in IMPACT if m.remedy != _PIVOT and m.name != "spin-of-release"):
        model = mistake.change.model(MODEL)
        results = (
            (solve(case.scene, Ivp()), solve(mistake.change.scene(case.scene), Ivp(), model))
            for case in KEPT
        )
        assert any(
            right.impact and wrong.impact and dot(right.impact.velocity, right.impact.velocity)
            != dot(wrong.impact.velocity, wrong.impact.velocity) for right, wrong in results
        ), mistake.name  # fmt: skip
