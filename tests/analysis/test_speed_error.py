"""Speed against error: that the errors, the work and the peers are what the study says."""

from __future__ import annotations

import math

import pytest

from analysis.speed_error import contenders, laws
from analysis.speed_error.contenders import Answers
from analysis.speed_error.measuring import errors
from analysis.speed_error.work import Work, at_bats, flights, truth
from longball.model.result import Result

pytestmark = pytest.mark.nightly  # of a study alone


@pytest.fixture(scope="module")
def struck() -> tuple[Work, list[Result]]:
    work = at_bats(12)
    return work, truth(work)


def test_what_misses_the_bat_is_counted(struck: tuple[Work, list[Result]]) -> None:
    work, true = struck
    batted = sum(result.outcome == "batted" for result in true)
    assert batted > 0
    nobody = errors(Answers(["missed"] * len(work), [None] * len(work)), true)
    assert (nobody.contacts, nobody.missed, nobody.unanswered) == (batted, batted, 0)
    assert math.isnan(nobody.worst)
    everybody = errors(contenders.batch(1e-13).solve(work), true)
    assert everybody.missed == 0
    # Half ulps of a touching, 1e-16 m, grow a hundred-thousandfold to the landing of a graze.
    assert everybody.worst < 1e-11


def test_plain_scipy_lands_where_the_batch_engine_does() -> None:
    work = flights(4)
    true = truth(work)
    # A thousand times its tolerance at 100 m: events are roots of an interpolant.
    assert errors(contenders.plain("DOP853", 1e-12).solve(work), true).worst < 1e-8


@pytest.mark.parametrize("law", laws.LAWS)
def test_batch_and_plain_scipy_land_alike_under_a_law(law: str) -> None:
    work = laws.works(2)[law]
    true = truth(work)
    # Rounding, 2e-16 of 100 m a step, in some ten steps; a thousand tolerances, as above.
    for entrant, bound in (
        (contenders.batch(1e-13), 2e-13),
        (contenders.plain("DOP853", 1e-12), 1e-8),
    ):
        assert errors(entrant.solve(work), true).worst < bound


def test_heyoka_lands_as_exactly_in_batch_mode(struck: tuple[Work, list[Result]]) -> None:
    pytest.importorskip("heyoka")
    work = flights(20)  # a batch and a part of one
    for mode in contenders.heyoka():
        # Rounding, 2e-16 of 100 m a step, in some ten steps.
        assert errors(mode.solve(work), truth(work)).worst < 2e-13
    at_bat, true = struck
    scalar, batch = (errors(mode.solve(at_bat), true) for mode in contenders.heyoka())
    assert scalar.missed == batch.missed == 0
    # As for the batch engine above: a touching's half ulps grow to the landing.
    assert max(scalar.worst, batch.worst) < 1e-11
