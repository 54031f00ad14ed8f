"""Struck balls agree with `longball.home_run` and with the formulas."""

import math

import numpy as np
import pytest

from analysis.paper.balls import SPACES, Base, Share, strike, strike_in_steps
from longball.engines.verlet import Verlet
from longball.home_run import draw, monte_carlo, paper_at_bats
from longball.model.readings import Reading
from longball.model.scene import AtBatScene

pytestmark = pytest.mark.nightly  # of the paper's analysis alone, and slow

# The inertia about the centre has home runs enough for small samples.
BASE = Base(AtBatScene(id="base", reading=Reading(inertia="about_centre")))
COUNT = 2_000
AT_BATS = paper_at_bats(BASE.sampling)


@pytest.fixture(scope="module")
def balls():
    return strike(BASE, draw(AT_BATS, COUNT, 5), [0.42, 0.45])


def test_the_landings_are_those_of_monte_carlo(balls):
    for ours, theirs in zip(
        balls, monte_carlo(BASE.scene, AT_BATS, [0.42, 0.45], COUNT, 5), strict=True
    ):
        np.testing.assert_array_equal(ours.x, theirs.x)
        np.testing.assert_array_equal(ours.y, theirs.y)


def test_flies_are_some_of_the_batted_balls(balls):
    trials = [space.estimate(0.42, balls[0]).trials for space in SPACES]
    pitches, batted, fair, flies, fair_flies, *beyond = trials
    assert pitches == COUNT > batted > max(fair, flies) > fair_flies > 0
    assert len(SPACES[4].distances(balls[0])) == fair_flies
    # Batted and fair, beyond ever more metres.
    assert batted > beyond[0] > beyond[2] > beyond[4] > 0
    assert fair > beyond[1] > beyond[3] > beyond[5] > 0


@pytest.mark.parametrize("contact_force", ["carried", "early"])
def test_another_contact_force_is_its_limit_without_steps(contact_force):
    """The impulse is multiplied; the same balls are batted, as by the scheme in short steps."""
    base = BASE._replace(contact_force=contact_force)
    samples = BASE.drawn(200, 5)
    (usual,), (other,) = (strike(one, samples, [0.42]) for one in (BASE, base))
    (stepped,) = strike_in_steps(base, samples, [0.42], Verlet(2e-4))
    assert (usual.batted == other.batted).all()
    (livelier,) = strike(BASE, samples, [{"carried": 0.775, "early": 0.065}[contact_force]])
    np.testing.assert_allclose(other.distance, livelier.distance, rtol=1e-9)
    both = other.batted & stepped.batted
    assert np.median(np.abs(stepped.exit_speed[both] - other.exit_speed[both])) < 0.1
    assert np.median(np.abs(stepped.distance[both] - other.distance[both])) < 0.5


def test_the_error_of_a_share_is_binomial(balls):
    for space in SPACES:
        share, row = space.share(balls[0]), space.estimate(0.42, balls[0])
        nothing = Share(0.0, np.zeros(COUNT))
        value, error = share.above(nothing)
        assert value == share.p
        assert error == pytest.approx(math.sqrt(row.p * (1 - row.p) / row.trials), rel=1e-9)


def test_a_difference_of_the_same_at_bats_is_known_better(balls):
    low, high = (SPACES[0].share(one) for one in balls)
    rise, error = high.above(low)
    # With the same at-bats only those count that became home runs.
    changed = ((balls[1].distance >= 150) & ~(balls[0].distance >= 150)).sum()
    assert rise == pytest.approx(changed / COUNT)
    assert error == pytest.approx(math.sqrt(rise * (1 - rise) / COUNT), rel=1e-9)


def test_the_printed_scheme_sees_few_of_the_balls(balls):
    (stepped,) = strike_in_steps(BASE, BASE.drawn(1_000, 5), [0.42], Verlet(0.05))
    (fine,) = strike_in_steps(BASE, BASE.drawn(200, 5), [0.42], Verlet(2e-4))
    assert 0.0 < stepped.batted.mean() < 0.1
    exact = balls[0].batted[:200]
    # A ball passes 7 mm in a step: the thinnest grazes alone are overlooked.
    assert (fine.batted & ~exact).sum() == 0
    assert (exact & ~fine.batted).sum() <= 0.02 * 200
    both = exact & fine.batted
    assert np.median(np.abs(fine.exit_speed[both] - balls[0].exit_speed[:200][both])) < 0.1
