"""Monte Carlo."""

from __future__ import annotations

import numpy as np
import pytest

from longball.engines.batch import Batch
from longball.engines.ivp import Ivp
from longball.home_run import draw, monte_carlo, paper_at_bats
from longball.home_run.simulation import COLUMNS
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

BASE = AtBatScene(id="base")
PAPER = paper_at_bats(SamplingReading())


class TestMonteCarlo:
    @pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
    def test_workers_change_no_bit(self, engine):
        one, two = (
            monte_carlo(BASE, PAPER, (0.41, 0.45), 70, seed=1, engine=engine, workers=n)
            for n in (1, 2)
        )
        for a, b in zip(one, two, strict=True):
            np.testing.assert_array_equal(a.x, b.x)
            np.testing.assert_array_equal(a.y, b.y)

    def test_fewer_are_the_first_of_more(self):
        few, many = (
            monte_carlo(BASE, PAPER, (0.41, 0.45), n, seed=1) for n in (COLUMNS + 9, 2 * COLUMNS)
        )
        for a, b in zip(few, many, strict=True):
            np.testing.assert_array_equal(a.x, b.x[: COLUMNS + 9])

    def test_a_ball_that_is_never_pitched_is_no_failure(self):
        at_bats = paper_at_bats(SamplingReading(speed_table="as_printed"))
        (struck,) = monte_carlo(BASE, at_bats, (0.42,), 200, seed=1)
        never = ~draw(at_bats, 200, seed=1).pitched
        assert never.any()
        assert not (struck.batted | struck.failed)[never].any()

    def test_what_the_engine_cannot_tell_has_failed(self):
        # Released within the bat's reach of the plate, a ball starts inside the bat or misses it.
        pitch = BASE.pitch.model_copy(update={"release": (0.05, 0.0, 1.8)})
        base = BASE.model_copy(update={"pitch": pitch})
        (batch,), (ivp,) = (
            monte_carlo(base, PAPER, (0.42,), 60, seed=1, engine=engine)
            for engine in (Batch(), Ivp())
        )
        assert batch.failed.any()
        np.testing.assert_array_equal(batch.failed, ivp.failed)
