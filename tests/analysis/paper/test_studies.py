"""The pure functions of the studies on cases with known answers."""

import math
from statistics import NormalDist

import numpy as np
import pytest

from analysis.__main__ import PAGES, chosen
from analysis.paper.argument import density_at_fence, line, width
from analysis.paper.balls import SPACES, Base
from analysis.paper.combinations import COLLISIONS, bases
from analysis.paper.counterparts import Counterpart
from analysis.paper.home_run_figures import curve_share, fit_noise
from analysis.paper.numbers import PARAMETERS, drawn
from analysis.paper.printed import SAMPLES
from analysis.paper.switches import options, turned_to
from analysis.paper.variance import indices
from longball.home_run import PAPER_CURVES, RESTITUTIONS, Curve, Estimate, fit
from longball.model.readings import Reading
from longball.model.scene import AtBatScene

BASE = Base(AtBatScene(id="base"))


# ---- Sobol's indices -----------------------------------------------------------------------------


def test_indices_of_a_sum_and_of_a_product():
    generator = np.random.default_rng(1)
    n = 10_000
    one, other = generator.standard_normal((2, 2, n))
    mixed = [np.array([other[0], one[1]]), np.array([one[0], other[1]])]

    def both(f):
        return indices(f(one), f(other), np.array([f(each) for each in mixed]), seed=2)

    # x + 2y: variances 1 and 4, each alone. xy: none alone, both in all of it.
    total = both(lambda x: x[0] + 2 * x[1])
    product = both(lambda x: x[0] * x[1])
    for found, error, true in (
        (total.first, total.first_error, [0.2, 0.8]),
        (total.total, total.total_error, [0.2, 0.8]),
        (product.first, product.first_error, [0.0, 0.0]),
        (product.total, product.total_error, [1.0, 1.0]),
    ):
        assert (np.abs(found - true) < 4 * error).all()
        assert (error < 0.05).all()


# ---- the argument --------------------------------------------------------------------------------


def test_a_normal_density_has_its_own_height_and_width_at_the_fence():
    normal = NormalDist(120.0, 45.0)
    d = np.array([normal.inv_cdf((i + 0.5) / 200_000) for i in range(200_000)])
    # The bins of 5 m take off 5²/24 · p''/p < 0.05 %.
    assert density_at_fence(d) == pytest.approx(normal.pdf(150.0), rel=2e-3)
    assert width(d) == pytest.approx(45.0, rel=1e-2)


def test_a_line_and_its_power():
    x = np.linspace(40.0, 60.0, 21)
    straight, square = line(x, 3 * x - 30), line(x, x * x)
    assert (straight.slope, straight.intercept) == (pytest.approx(3.0), pytest.approx(-30.0))
    assert straight.off == pytest.approx(0.0, abs=1e-9)
    assert straight.power == pytest.approx(150 / 120)
    assert square.power == pytest.approx(2.0)
    assert square.off > 10.0


# ---- Table I, Figs. 6 and 7 ----------------------------------------------------------------------


def test_the_scatter_of_a_fit_is_that_of_fits():
    generator = np.random.default_rng(3)
    curve = PAPER_CURVES["caption"]
    p = np.array([curve(e) for e in RESTITUTIONS])
    # Many times the paper's samples: the error of first order then holds, and falls with 1/√n.
    more = 100
    n = more * SAMPLES
    found = []
    for _ in range(200):
        drawn_p = generator.binomial(n, p) / n
        half = 1.96 * np.sqrt(drawn_p * (1 - drawn_p) / n)
        fitted = fit(
            [
                Estimate(e, 0, n, 0, q, q - h, q + h)
                for e, q, h in zip(RESTITUTIONS, drawn_p, half, strict=True)
            ]
        )
        found.append((fitted.curve.c1, fitted.curve.sigma))
    # A standard deviation of 200 numbers is known to 5 %.
    assert np.std(found, axis=0) * math.sqrt(more) == pytest.approx(fit_noise(curve), rel=0.2)


def test_shares_of_a_curve():
    curve = Curve(300.0, 50.0)
    assert curve_share(curve, 0.4, 70.0, 170.0) == pytest.approx(math.erf(1 / math.sqrt(2)))
    assert curve_share(curve, 0.4, 150.0, 1e9) == pytest.approx(curve(0.4))


@pytest.mark.parametrize(
    ("default", "nearest", "verdict"),
    [
        (1.1, 0.9, "**reproduced**: yes"),
        (2.0, 0.9, "by the nearest reading only: yes"),
        (1.1, 2.0, "by the default reading only: no"),
        (2.0, math.nan, "**not reproduced**: no"),
    ],
)
def test_verdicts_follow_from_twice_the_noise(default, nearest, verdict):
    one = Counterpart("Fig. 0", "x", 1.0, default, nearest, 0.1, 2, "yes", "no")
    assert one.verdict == verdict


# ---- readings ------------------------------------------------------------------------------------


def test_every_switch_is_turned_to_every_other_option():
    turned = [(switch, option) for switch, option, _, _ in options(BASE, SPACES[0])]
    assert ("inertia", "about_centre") in turned
    assert ("inertia", "solid_cylinder") not in turned
    assert ("offset_spread", "0.0732") in turned
    assert ("samples", "fair flies") in turned
    assert ("ball.radius", "0.0183") in turned
    assert len(turned) == len(set(turned))


def test_what_the_ledger_forbids_is_no_reading():
    base = Base(AtBatScene(id="base", reading=Reading(reduced_mass="effective_mass")))
    assert turned_to(base, "bat_ball_restitution", "plain") is None
    assert turned_to(base, "inertia", "thin_rod").scene.reading == Reading(
        reduced_mass="effective_mass", inertia="thin_rod"
    )
    assert turned_to(base, "cell_width", "0.2") == base.replaced({"cell_width": 0.2})
    carried = base._replace(contact_force="carried")
    assert turned_to(base, "contact_force", "carried") == carried
    assert turned_to(carried, "inertia", "thin_rod").contact_force == "carried"


def test_combinations_differ():
    found = [(base.scene.line(), *base[1:]) for base in bases()]
    # Contact forces, spreads of the offset, radii and widths of a cell.
    assert len(found) == len(set(found)) == len(COLLISIONS) * 3 * 2 * 2 * 6


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda one: one.name)
def test_a_parameter_is_scaled_and_nothing_random_moves(parameter):
    problem = drawn(BASE, 50)
    other = parameter.scaled(problem, 1.5)
    assert parameter.value(problem) > 0
    if parameter.name != "largest tilt":  # its value stands in the distribution, not in the draws
        assert parameter.value(other) == pytest.approx(1.5 * parameter.value(problem))
    for column in ("speed", "aim", "offset", "tilt"):
        before, after = (getattr(each[1], column) for each in (problem, other))
        ratio = after / before
        assert ratio == pytest.approx(ratio[0])
        assert ratio[0] == pytest.approx(1.0) or ratio[0] == pytest.approx(1.5)


# ---- the command line ----------------------------------------------------------------------------


def test_a_page_stands_for_its_studies():
    assert chosen(["paper"]) == list(PAGES["paper"].studies)
    assert chosen(["readings", "at_bats"]) == ["readings", "at_bats"]
    assert set(chosen([])) < set(PAGES["report"].studies)
