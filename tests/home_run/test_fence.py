"""Home runs over a fence."""

import numpy as np
import pytest

from longball.engines.batch import Batch
from longball.engines.ivp import Ivp
from longball.home_run import estimate, integrals, monte_carlo, paper_at_bats
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene, Fence

# A reading under which balls fly far enough.
BASE = AtBatScene(id="base", reading=Reading(inertia="about_centre"))
PAPER = paper_at_bats(SamplingReading())
PARK = Fence(polyline=((70.0, 70.0, 3.0), (122.0, 0.0, 3.0), (70.0, -70.0, 3.0)))


def fenced(**fence):
    return BASE.model_copy(update={"fence": Fence(**fence)})


@pytest.mark.parametrize("engine", [Batch(), Ivp()], ids=["batch", "ivp"])
@pytest.mark.sampled(every=2)
def test_a_circle_of_150_m_is_the_papers_rule(engine, nightly):
    """The same balls are home runs, and as many at every e."""
    count = 4000 if isinstance(engine, Batch) else 150 if nightly else 60
    e = (0.41, 0.45)
    free, over = (
        monte_carlo(base, PAPER, e, count, seed=5, engine=engine)
        for base in (BASE, fenced(radius=150.0))
    )
    for paper, fence in zip(free, over, strict=True):
        np.testing.assert_array_equal(fence.home_run, paper.distance >= 150)
        assert estimate(0.4, fence) == estimate(0.4, paper)
        assert estimate(0.4, paper).home_runs > count / 20
        np.testing.assert_allclose(fence.distance, paper.distance, rtol=1e-12)


def test_a_park_of_chords():
    """Both engines; a ball that hits the wall stays there, and is batted."""
    base = BASE.model_copy(update={"fence": PARK})
    batch, ivp = (
        monte_carlo(base, PAPER, (0.45,), 150, seed=5, engine=engine)[0]
        for engine in (Batch(), Ivp())
    )
    np.testing.assert_array_equal(batch.home_run, ivp.home_run)
    np.testing.assert_allclose(batch.x, ivp.x, rtol=1e-9)
    free = monte_carlo(BASE, PAPER, (0.45,), 150, seed=5)[0]
    np.testing.assert_array_equal(batch.batted, free.batted)
    assert 0 < np.count_nonzero(batch.home_run) < np.count_nonzero(free.fair)
    assert not np.any(batch.home_run & ~free.fair)


def test_quadrature_knows_no_fence():
    with pytest.raises(ValueError, match="not a fence"):
        integrals(fenced(radius=150.0), PAPER, [0.42])
