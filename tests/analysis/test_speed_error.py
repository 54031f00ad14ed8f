"""Speed against error: that the errors, the work and the peers are what the study says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.speed_error import contenders, laws
from analysis.speed_error.contenders import Answers
from analysis.speed_error.measuring import difference, errors, ratio
from analysis.speed_error.work import Work, at_bats, flights, truth
from longball.model.result import Bounded, Result

pytestmark = pytest.mark.nightly  # of a study alone


@pytest.fixture(scope="module")
def struck() -> tuple[Work, list[Result]]:
    work = at_bats(12)
    return work, truth(work)


def test_a_distance_is_compared_beyond_the_digits_of_doubles() -> None:
    true = Bounded(value="100.00000000000000000001", radius="1e-30")
    assert difference(100.0, true) == pytest.approx(1e-20)
    assert difference(Bounded(value="100.00000000000000000001", radius="1e-30"), true) == 0.0


def test_what_misses_the_bat_is_counted(struck: tuple[Work, list[Result]]) -> None:
    work, true = struck
    batted = sum(result.outcome == "batted" for result in true)
    assert batted > 0
    nothing = [None] * len(work)
    nobody = errors(Answers(["missed"] * len(work), nothing, nothing), true)
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


def test_short_steps_find_the_bat(struck: tuple[Work, list[Result]]) -> None:
    work, true = struck
    by_setting = {entrant.name: entrant for entrant in contenders.plain_scipy(work)}
    found = errors(by_setting[contenders.SHORTEST].solve(work), true)
    plain = errors(by_setting["scipy DOP853, 1e-09"].solve(work), true)
    assert found.missed < plain.missed


def test_a_ratio_is_that_of_each_round() -> None:
    assert ratio([2.0, 40.0, 6.0], [1.0, 20.0, 2.0]) == 2.0
    assert np.isnan(errors(Answers([""], [None], [None]), truth(at_bats(1))).worst)
