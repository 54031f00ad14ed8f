"""P(e) by quadrature, and by scrambled points."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import special, stats

from longball import golden
from longball.engines.batch import Batch, solve_columns
from longball.home_run import (
    Mixture,
    Samples,
    estimate,
    integrals,
    monte_carlo,
    paper_at_bats,
    quadrature,
    scrambled,
)
from longball.home_run.clearance import Clearance
from longball.home_run.crossings import Crossings
from longball.home_run.quadrature import Nodes, Share, _Intervals, rule_of, share_over_offsets
from longball.model.quantities import replaced
from longball.model.readings import Reading, SamplingReading
from longball.model.scene import AtBatScene

GOLDEN = {case.id: case for case in golden.probabilities().cases}
BASE = AtBatScene(id="base")
PAPER = paper_at_bats(SamplingReading())


@pytest.fixture
def coarse(monkeypatch) -> None:
    """Two rules that take seconds."""
    monkeypatch.setattr("longball.home_run.quadrature.LEVELS", (Nodes(2, 1), Nodes(4, 2)))


@pytest.fixture
def coarsest(monkeypatch) -> None:
    """Two rules for what does not hang on how many nodes there are."""
    monkeypatch.setattr("longball.home_run.quadrature.LEVELS", (Nodes(1, 1), Nodes(2, 1)))


class TestMixture:
    mixture = Mixture(0.3, (1.0, 4.0), (0.5, 2.0))
    values = np.linspace(-5.0, 12.0, 40)

    def test_is_that_of_two_normal_distributions(self):
        first, second = stats.norm(1.0, 0.5), stats.norm(4.0, 2.0)
        below = 0.3 * first.cdf(self.values) + 0.7 * second.cdf(self.values)
        density = 0.3 * first.pdf(self.values) + 0.7 * second.pdf(self.values)
        found = self.mixture.distribution
        np.testing.assert_allclose(found.cdf(self.values), below, rtol=1e-13)
        np.testing.assert_allclose(found.pdf(self.values), density, rtol=1e-13)


class TestRuleOfADensity:
    def test_of_a_normal_density_is_gauss_and_hermites(self):
        x, w = special.roots_hermitenorm(8)
        places, weights = rule_of(stats.norm(40.0, 0.9).pdf, 30.0, 50.0, 100, 8)
        np.testing.assert_allclose(places, 40.0 + 0.9 * x, rtol=1e-13)
        np.testing.assert_allclose(weights, w / w.sum(), rtol=1e-10, atol=1e-16)

    def test_is_exact_for_the_moments_of_two_peaks(self):
        places, weights = rule_of(TestMixture.mixture.distribution.pdf, -20.0, 25.0, 400, 3)
        # E(x⁴) of N(μ, σ): μ⁴ + 6 μ²σ² + 3 σ⁴
        fourth = 0.3 * (1 + 6 * 0.25 + 3 * 0.0625) + 0.7 * (256 + 6 * 16 * 4 + 3 * 16)
        assert weights @ places**4 == pytest.approx(fourth, rel=1e-12)

    def test_of_no_density_weighs_nothing(self):
        _, weights = rule_of(np.zeros_like, 0.0, 1.0, 20, 3)
        np.testing.assert_array_equal(weights, np.zeros(3))


class TestClearance:
    clearance = Clearance(BASE, 0.42, Batch())
    inputs = Samples(*np.array([[36.0, 41.0], [-0.3, 0.1], [-0.03, 0.02], [0.1, 0.02]]))

    def test_is_the_way_beyond_150_m(self):
        table = solve_columns(
            BASE,
            {
                "pitch.speed": self.inputs.speed,
                "pitch.aim[0]": self.inputs.aim,
                "swing.height_offset": self.inputs.offset,
                "swing.tilt": self.inputs.tilt,
            },
        )
        np.testing.assert_array_equal(
            self.clearance(self.inputs), table["landing.distance"] - 150.0
        )

    @pytest.mark.parametrize("release_y", [0.0, 0.6])  # m
    def test_pitches_touch_the_bat_at_the_given_y(self, release_y: float):
        base = replaced(BASE, {"pitch.release[1]": release_y})
        aim = Clearance(base, 0.42, Batch()).aim_to_touch(-0.45, self.inputs)
        table = solve_columns(
            base,
            {
                "pitch.speed": self.inputs.speed,
                "pitch.aim[0]": aim,
                "swing.height_offset": self.inputs.offset,
                "swing.tilt": self.inputs.tilt,
            },
        )
        np.testing.assert_allclose(table["contact.position[1]"], -0.45, rtol=0, atol=1e-8)

    def test_the_window_is_where_the_bat_touches(self):
        (half,) = self.clearance.window(np.array([36.0]))
        offset = np.linspace(-half, half, 1001)
        every = Samples(np.full(1001, 36.0), np.zeros(1001), offset, np.zeros(1001))
        batted = self.clearance(every) > -150.0
        # Wider than the touching by its margin of 5 % on either side, and no more than twice that.
        assert 0.9 < np.mean(batted) < 0.96
        assert not batted[:5].any()
        assert not batted[-5:].any()


def test_the_speeds_of_pitches_that_arrive():
    """In a vacuum a level pitch falls by g/2 (18.44/v)², 1.8 m at most."""
    base = AtBatScene(id="base", air=None)
    law = Mixture(1.0, (30.0, 30.0), (1.0, 1.0))
    (low,), (high,) = quadrature._speeds(Clearance(base, 0.42, Batch()), law)
    assert low == pytest.approx(18.44 * math.sqrt(9.8 / 3.6), rel=1e-9)
    assert high == 30.0 + quadrature.FARTHEST


class TestIntervalsOfAims:
    def test_they_are_sought_between_the_ends_of_the_bat(self):
        clearance, inputs = TestClearance.clearance, TestClearance.inputs
        grid = _Intervals.of(clearance, inputs).grid
        ends = np.array([clearance.aim_to_touch(y, inputs) for y in (-0.5, 0.5)])
        # Contacts on the last 1e-8 of the bat are left out.
        np.testing.assert_allclose(grid[:, [0, -1]], ends.T, rtol=2e-8)
        np.testing.assert_allclose(np.diff(grid, n=2), 0.0, atol=1e-15)  # roundings of 0.5 m

    def test_their_kind_tells_where_they_begin_how_many_end_and_which_jump(self):
        signs = [[1, -1, -1], [-1, -1, 1], [-1, -1, 1], [1, -1, 1], [-1, -1, -1]]
        line, jumps = np.array([0, 1, 2, 3, 3]), np.array([False, False, True, False, False])
        ends = Crossings(line, 0.5 + 0.0 * line, jumps, jumps)
        grid, values, solved = np.zeros((5, 3)), np.array(signs, float), np.zeros(5, dtype=bool)
        clearance, inputs = TestClearance.clearance, TestClearance.inputs
        kinds = _Intervals(clearance, inputs, grid, values, ends, solved).kind.tolist()
        assert len({*kinds}) == len(kinds)


def test_the_pairs_of_speed_and_tilt_share_the_tolerance(monkeypatch):
    def allowed(clearance, at_bats, speed, tilt, tolerance):
        return np.array([np.ones_like(speed), tilt, tolerance, tolerance])

    monkeypatch.setattr(quadrature, "share_over_offsets", allowed)
    home_runs = Clearance(BASE, 0.42, Batch())
    found = quadrature._over_speeds(home_runs, PAPER, Nodes(5, 2), 1e-3, 1)
    # Each of n pairs may take 1/n of it, and those of large weight the whole of it.
    assert 0.5e-3 < found.error < 2e-3


class TestQuadrature:
    # The default reading is in test_cli.py, too.
    @pytest.mark.parametrize("name", GOLDEN)
    @pytest.mark.usefixtures("coarse")
    def test_its_error_covers_the_distance_to_a_finer_rule(self, name):
        case = GOLDEN[name]
        row = case.rows[0]
        at_bats = paper_at_bats(case.sampling)
        (rough,) = integrals(
            case.scene,
            at_bats,
            [row.e],
            sample_space=case.sampling.sample_space,
            tolerance=1e-3,
            workers=-1,
        )
        assert abs(rough.p - row.p) < rough.error + row.error
        assert abs(rough.slope - row.slope) < rough.slope_error + row.slope_error
        # Coarse as they are, these rules are right to some per cent.
        assert rough.error < 0.1 * row.p + 1e-9

    @pytest.mark.parametrize(
        "case",
        [
            pytest.param(case, id=name, marks=pytest.mark.nightly if i % 8 else ())
            for i, (name, case) in enumerate(GOLDEN.items())
        ],
    )
    def test_the_golden_values_agree_with_monte_carlo(self, case):
        count = 40_000
        scene, sampling = case.scene, case.sampling
        rows = case.rows[:: len(case.rows) - 1]
        struck = monte_carlo(
            scene, paper_at_bats(sampling), [row.e for row in rows], count, seed=5, workers=-1
        )
        for row, one in zip(rows, struck, strict=True):
            counted = estimate(row.e, one, sampling.sample_space)
            # 4.5 standard deviations: one in 150,000.
            noise = math.sqrt(row.p * (1 - row.p) / counted.trials)
            assert abs(counted.p - row.p) <= 4.5 * noise

    def test_the_golden_values_have_the_promised_errors(self):
        for case in GOLDEN.values():
            for row in case.rows:
                assert row.error <= 1e-6
                assert row.slope_error <= (1e-6 if case.id == "probability-default" else 1e-5)
                second = row.confirmation
                # Student's t with 15 degrees of freedom: 5 is one in 6,000.
                assert abs(second.p - row.p) <= 5 * second.standard_error
                # 16 scrambles of 1,024 lines each; a sample of as many pitches has 1e-3.
                assert second.standard_error < 5e-5

    # Under about_centre some just clear the ground: their interval of aims ends where D jumps.
    @pytest.mark.parametrize(
        "inertia",
        ["solid_cylinder", pytest.param("about_centre", marks=pytest.mark.nightly)],
    )
    def test_the_slope_over_offsets_is_that_of_the_share(self, inertia):
        base = AtBatScene(id="base", reading=Reading(inertia=inertia))

        def share(e):
            home_runs = Clearance(base, e, Batch())
            found = share_over_offsets(home_runs, PAPER, *np.array([[38.0], [0.08], [1e-6]]))
            return Share(*(values.item() for values in found))

        here, step = share(0.42), 1e-3
        difference = (share(0.42 + step).p - share(0.42 - step).p) / (2 * step)
        # Truncation is below 1e-6, and errors of P grow by 1/step.
        near = here.slope_error + 1e-5 + here.error / step
        assert abs(here.slope - difference) < near
        assert near < 0.02 * here.slope

    @pytest.mark.usefixtures("coarsest")
    def test_threads_change_no_bit(self, monkeypatch):
        monkeypatch.setattr("longball.home_run.quadrature._PAIRS", 1)  # so that both have some
        one, two = (integrals(BASE, PAPER, [0.42], tolerance=1e-2, workers=n) for n in (1, 2))
        assert one == two

    @pytest.mark.usefixtures("coarse")
    def test_a_bat_at_rest_hits_no_home_run(self):
        swing = BASE.swing.model_copy(update={"angular_speed": 0.0})
        base = BASE.model_copy(update={"swing": swing})
        seen: list[int] = []
        for row in integrals(base, PAPER, [0.41, 0.45], progress=seen.append):
            assert row.p == row.slope == 0.0
            assert row.low <= 0.0 <= row.high < 1e-9
        assert seen == [1, 2]

    @pytest.mark.usefixtures("coarse")
    def test_without_a_sample_space_there_is_no_number(self):
        # Pitched too slowly to arrive.
        slow = Mixture(1.0, (5.0, 5.0), (0.1, 0.1))
        at_bats = replace(PAPER, speed=slow)
        (row,) = integrals(BASE, at_bats, [0.42], sample_space="batted")
        assert math.isnan(row.p)
        (other,) = scrambled(BASE, at_bats, [0.42], 16, seed=1, sample_space="batted")
        assert math.isnan(other.p)

    @pytest.mark.nightly
    @pytest.mark.usefixtures("coarsest")
    def test_what_the_engine_cannot_tell_is_in_the_error(self):
        # Released within the bat's reach of the plate, a ball starts inside the bat or misses it.
        pitch = BASE.pitch.model_copy(update={"release": (0.05, 0.0, 1.8)})
        base = BASE.model_copy(update={"pitch": pitch})
        (row,) = integrals(base, PAPER, [0.42], tolerance=1e-2)
        assert row.error > 0.1


class TestRandomised:
    def test_agrees_with_the_quadrature(self):
        row = GOLDEN["probability-default"].rows[-1]
        (found,) = scrambled(BASE, PAPER, [row.e], 64, seed=9, workers=-1)
        assert abs(found.p - row.p) < 5 * found.standard_error
        # A sample of as many pitches has 4e-3.
        assert found.standard_error < 4e-4

    def test_threads_change_no_bit(self):
        one, two = (scrambled(BASE, PAPER, [0.42], 64, seed=1, workers=n) for n in (1, 2))
        assert one == two
