"""The propagation of uncertainty, against closed forms and Monte Carlo."""

import math
import warnings

import numpy as np
import pandas as pd
import pytest

import longball as lb
from longball.model.quantities import nested
from tests.calls import check_wrong_calls


def vacuum(angle):
    v = 40.0
    velocity = [v * math.cos(angle), 0, v * math.sin(angle)]
    return lb.Flight(air=None, launch={"position": [0, 0, 0], "velocity": velocity})


def test_a_parabola_has_the_uncertainty_of_its_closed_form():
    # d = v² sin 2θ / g
    found = lb.uncertainty(vacuum(0.5), {"launch.speed": 0.01, "gravity": 0.001})
    d = 1600 * math.sin(1.0) / 9.8
    assert found["landing.distance"] == pytest.approx(
        d * math.hypot(2 * 0.01 / 40, 0.001 / 9.8), rel=1e-12
    )


def test_correlations_count():
    by_rows = {
        "launch.speed": {"launch.speed": 1e-4, "gravity": 9e-6},
        "gravity": {"launch.speed": 9e-6, "gravity": 1e-6},
    }
    a, b = 2 / 40, -1 / 9.8
    d = 1600 * math.sin(1.0) / 9.8
    expected = d * math.sqrt(a * a * 1e-4 + 2 * a * b * 9e-6 + b * b * 1e-6)
    for covariance in (by_rows, pd.DataFrame(by_rows)):
        found = lb.uncertainty(vacuum(0.5), covariance, quantities=["landing.distance"])
        assert found["landing.distance"] == pytest.approx(expected, rel=1e-12)
        assert [*found] == ["landing.distance"]


def test_numbers_may_change_together():
    """A gravity that falls as the speed grows: their effects on d = v² sin 2θ / g add up."""
    speed, gravity = 0.01, -0.001
    rows = {"launch.speed": speed, "gravity": gravity}
    found = lb.uncertainty(
        vacuum(0.5), {i: {j: a * b for j, b in rows.items()} for i, a in rows.items()},
        quantities=["landing.distance"],
    )  # fmt: skip
    d = 1600 * math.sin(1.0) / 9.8
    expected = d * (2 * speed / 40 - gravity / 9.8)
    assert found["landing.distance"] == pytest.approx(expected, rel=1e-9)


LAUNCH = {
    "kind": "flight",
    "launch.position[0]": 0.0, "launch.position[1]": 0.0, "launch.position[2]": 1.0,
    "launch.velocity[0]": 38.0, "launch.velocity[1]": 0.0, "launch.velocity[2]": 16.0,
}  # fmt: skip
SPINNING = LAUNCH | {
    "launch.spin[0]": 20.0, "launch.spin[1]": -200.0, "launch.spin[2]": 30.0,
    "air.density": 1.1, "air.lift_coefficient.law": "rational",
    "air.wind[0]": 2.0, "air.wind[1]": 1.0, "air.wind[2]": 0.0,
}  # fmt: skip
AT_BAT = {"kind": "at-bat", "pitch.speed": 38.6, "swing.height_offset": -0.03, "swing.tilt": 0.14}
SMALL = [
    (
        LAUNCH | {"air.drag_coefficient": 0.4},
        {"launch.velocity[0]": 0.4, "launch.velocity[2]": 0.4, "air.drag_coefficient": 0.01},
        ["landing.distance", "landing.time"],
    ),
    (
        SPINNING,
        {"launch.spin[1]": 10.0, "air.density": 0.02, "air.wind[0]": 0.5},
        ["landing.distance", "landing.position[1]", "apex.position[2]"],
    ),
    (
        AT_BAT,
        {"pitch.speed": 0.3, "swing.height_offset": 2e-4, "swing.tilt": 0.002},
        ["landing.distance", "impact.velocity[0]", "plate.time"],
    ),
]


def sampled(base, spread, n):
    """Results of n scenes that are drawn, and of the one that they are drawn about."""
    draws = np.random.default_rng(1).normal(size=(len(spread), n))
    columns = {
        name: base[name] + sigma * draws[i] for i, (name, sigma) in enumerate(spread.items())
    }
    return lb.solve_many(base | columns, engine="batch"), nested(base)


@pytest.mark.parametrize(("base", "spread", "quantities"), SMALL)
def test_where_the_second_order_is_small_monte_carlo_agrees(base, spread, quantities, nightly):
    n = 1_000_000 if nightly else 20_000
    solved, scene = sampled(base, spread, n)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = lb.uncertainty(scene, spread, quantities=quantities)
    assert solved["error"].isna().all()
    for name in quantities:
        # The sample's own error is σ/√(2n); five of them, and what the second order adds.
        drawn = solved[name].std()
        second = found.second[name] ** 2 / (2 * found[name])
        assert abs(drawn - found[name]) < 5 * found[name] / math.sqrt(2 * n) + 2 * second
        mean = solved[name].mean() - found.value[name]
        assert abs(mean - found.shift[name]) < 5 * found[name] / math.sqrt(n) + second


def test_where_the_second_order_is_large_it_is_said():
    # At 45° the distance does not change with the angle, but for -2 d δ².
    with pytest.warns(UserWarning, match=r"landing\.distance: the second-order term is large"):
        found = lb.uncertainty(
            vacuum(math.pi / 4), {"launch.angle": 0.05}, quantities=["landing.distance"]
        )
    d = 1600 / 9.8
    assert found["landing.distance"] < 1e-10
    # ½ d'' σ² = -2 d σ², by finite steps of a cosine: 1 - cos 2σ
    assert found.shift["landing.distance"] == pytest.approx(d * (math.cos(0.1) - 1), rel=1e-9)


def test_another_outcome_nearby_is_said():
    scene = lb.Flight(launch=lb.launch(speed=44.0, angle=0.5), fence={"radius": 110.0})
    with pytest.warns(UserWarning, match="instead of"):
        lb.uncertainty(scene, {"launch.speed": 10.0}, quantities=["landing.distance"])


WRONG = """
spread({"launch.sped": 1.0}) -> did you mean launch.speed
spread({"launch.speed": 0.0}) -> must be positive
spread({}) -> no number of the scene is uncertain
spread({"gravity": {"gravity": 1.0, "launch.speed": 0.0}}) -> names of its columns
spread({"gravity": {"gravity": 1, "time_limit": 2}, "time_limit": {"gravity": 2, "time_limit": 1}})
    -> negative variance
lb.uncertainty(GROUND, {"launch.position[0]": 0.01}) -> ends where it starts
"""


GROUND = lb.Flight(launch={"position": [0, 0, 0], "velocity": [30, 0, 0]})


def spread(sigma):
    return lb.uncertainty(vacuum(0.5), sigma)


def test_what_is_no_spread_or_has_no_derivative_is_refused():
    check_wrong_calls(WRONG, globals())
