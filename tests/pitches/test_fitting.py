"""The fits of Sec. II: known answers, honest errors, and the paper's own numbers given back."""

import json
import math

import numpy as np
import pandas as pd
import pytest

from longball.pitches import (
    EXAMPLE,
    Columns,
    PitchTypes,
    TableError,
    as_text,
    fit_pitches,
    load_fitted,
)
from longball.pitches.fitting import (
    INTEGRAL_AS_PRINTED,
    _normal_through,
    _OnePeak,
    normal,
    r_squared,
)

# Table II with its headings exchanged, p, and Fig. 3; km/h and cells.
PRINTED = {
    "straight_mean": 139.1,
    "straight_spread": 4.58,
    "breaking_mean": 127.8,
    "breaking_spread": 7.80,
    "p": 0.45,
    "left_mean": 2.0,
    "right_mean": 4.0,
    "spread": 0.77,
    "q": 0.52,
}
SPEEDS = ("straight_mean", "straight_spread", "breaking_mean", "breaking_spread")
METRES = Columns(
    pitch_type="kind", speed="kmh", speed_unit="km/h", speed_resolution=0.0,
    across="cell", height=None, place_unit="m", view="pitcher", cell_width=0.144,
)  # fmt: skip
CELLS = METRES.model_copy(update={"place_unit": "cell"})
KINDS = PitchTypes(straight=("straight",), breaking=("breaking",), left_out=())


def draw(count, seed, columns):
    """Pitches drawn from what the paper prints, by numpy alone."""
    random = np.random.default_rng(seed)
    straight = random.random(count) < 0.45
    speed = np.where(straight, random.normal(139.1, 4.58, count), random.normal(127.8, 7.80, count))
    place = np.where(random.random(count) < 0.52, 2.0, 4.0) + random.normal(0.0, 0.77, count)
    across = (
        np.clip(np.rint(place), 1, 5) if columns.place_unit == "cell" else (place - 3.0) * 0.144
    )
    kind = np.where(straight, "straight", "breaking")
    return pd.DataFrame({"kind": kind, "kmh": speed, "cell": across})


def numbers(fitted, method):
    """Value and error of every fitted number, in the paper's units."""
    speed, aim = getattr(fitted.speed, method), getattr(fitted.aim, method)
    found = {
        name: (3.6 * each.value, 3.6 * each.standard_error)
        for name in SPEEDS
        for each in [getattr(speed, name)]
    }
    found["p"] = (speed.weight.value, speed.weight.standard_error)
    for name in ("left_mean", "right_mean", "spread"):
        each = getattr(aim, name)
        found[name] = (each.value, each.standard_error)
    found["q"] = (aim.weight.value, aim.weight.standard_error)
    return found


# ---- the paper's numbers, given back -------------------------------------------------------------


@pytest.mark.nightly
@pytest.mark.parametrize("columns", [METRES, CELLS], ids=["places", "cells"])
def test_1548_pitches_give_the_printed_numbers_back_within_their_errors(columns):
    seeds = 40
    deviations = {name: [] for name in PRINTED}
    for seed in range(seeds):
        fitted = fit_pitches(draw(1548, seed, columns), columns, KINDS, replicates=2)
        for name, (value, error) in numbers(fitted, "maximum_likelihood").items():
            deviations[name].append((value - PRINTED[name]) / error)
    for name, each in deviations.items():
        z = np.array(each)
        # Each bound is one that 40 standard normal numbers break in about one case of 2,000.
        assert abs(z.mean()) < 3.5 / math.sqrt(seeds), name
        assert 0.62 < z.std() < 1.42, name
        assert np.sum(np.abs(z) < 1.96) >= 32, name


@pytest.mark.nightly
def test_so_does_the_histogram_if_its_bins_are_narrow():
    seeds = 12
    deviations = {name: [] for name in (*SPEEDS, "p")}
    for seed in range(seeds):
        table = draw(1548, seed, METRES)
        fitted = fit_pitches(table, METRES, KINDS, bin_width=1.0, replicates=24)
        found = numbers(fitted, "least_squares")
        for name, each in deviations.items():
            each.append((found[name][0] - PRINTED[name]) / found[name][1])
    for name, each in deviations.items():
        z = np.array(each)
        assert abs(z.mean()) < 3.5 / math.sqrt(seeds), name
        # One in 2,000 either way for 12 numbers; the errors themselves are known to 14 %.
        assert 0.35 < z.std() < 1.9, name


@pytest.mark.parametrize("columns", [METRES, CELLS], ids=["places", "cells"])
@pytest.mark.nightly
def test_a_million_pitches_give_them_back_to_three_digits(columns):
    fitted = fit_pitches(draw(1_000_000, 1, columns), columns, KINDS, replicates=2)
    for name, (value, error) in numbers(fitted, "maximum_likelihood").items():
        # Half a unit in the third digit is up to 0.5 %.
        assert value == pytest.approx(PRINTED[name], rel=5e-3), name
        assert abs(value - PRINTED[name]) < 4.0 * error, name


def test_shares_that_are_the_printed_density_give_figure_3_back():
    """The paper's fit on its own density: the share of cell j is ψ(j)."""

    def psi(y):
        left, right = (math.exp(-(((y - mean) / 0.77) ** 2) / 2) for mean in (2, 4))
        return (0.52 * left + 0.48 * right) / (math.sqrt(2 * math.pi) * 0.77)

    total = sum(psi(y) for y in range(1, 6))
    counts = [round(1548 * psi(y) / total) for y in range(1, 6)]
    cells = np.repeat([1, 2, 3, 4, 5], counts)
    table = draw(len(cells), 0, CELLS).assign(cell=cells)
    fitted = fit_pitches(table, CELLS, KINDS, replicates=2)
    at_edges = fitted.aim.least_squares_at_edges
    assert at_edges.weight.value == pytest.approx(0.52, abs=0.005)
    assert at_edges.spread.value == pytest.approx(0.77 * total, abs=0.01)  # ψ(1..5) adds to 0.98
    assert (at_edges.left_mean.value, at_edges.right_mean.value) == (2.0, 4.0)
    assert at_edges.left_mean.standard_error == 0.0
    assert at_edges.r_squared > 0.99


# ---- known answers -------------------------------------------------------------------------------


def test_likeliest_normals_by_hand():
    speeds = {"straight": [140.0, 144.0] * 15, "breaking": [120.0, 120.0, 126.0] * 20}
    table = pd.DataFrame(
        [(kind, kmh, 3) for kind, each in speeds.items() for kmh in each],
        columns=["kind", "kmh", "cell"],
    )
    fit = fit_pitches(table, CELLS, KINDS, replicates=2).speed.maximum_likelihood
    assert fit.straight_mean.value * 3.6 == pytest.approx(142.0)
    assert fit.straight_spread.value * 3.6 == pytest.approx(2.0)
    assert fit.straight_mean.standard_error * 3.6 == pytest.approx(2.0 / math.sqrt(30))
    # Two points have the fourth moment 1: the spread does not vary to first order.
    assert fit.straight_spread.standard_error == pytest.approx(0.0, abs=1e-9)
    assert fit.breaking_mean.value * 3.6 == pytest.approx(122.0)
    assert fit.breaking_spread.value * 3.6 == pytest.approx(math.sqrt(8.0))
    # Fourth moment (2 · 2⁴ + 4⁴)/3 / 8² = 1.5.
    expected = math.sqrt(8.0) * math.sqrt(0.5 / (4 * 60))
    assert fit.breaking_spread.standard_error * 3.6 == pytest.approx(expected)
    assert fit.weight.value == pytest.approx(1 / 3)
    assert fit.weight.standard_error == pytest.approx(math.sqrt(2 / 9 / 90))


@pytest.mark.parametrize(("factor", "integral"), [(2, 1.0), (1, INTEGRAL_AS_PRINTED)])
def test_equation_2_with_and_without_its_2(factor, integral):
    v = np.linspace(-60.0, 60.0, 24001)
    y = np.exp(-((v - 1.0) ** 2) / (factor * 4.58**2)) / (math.sqrt(2 * math.pi) * 4.58)
    assert np.trapezoid(y, v) == pytest.approx(integral, rel=1e-9)
    assert normal(v, 1.0, 4.58 * integral, integral) == pytest.approx(y, rel=1e-12)
    found = _normal_through(v[::50], y[::50], (0.0, 6.0), integral)
    assert found == pytest.approx((1.0, 4.58 * integral), rel=1e-7)


def test_equation_2_as_printed_cannot_have_given_the_printed_r_squared():
    """Its integral is 1/√2: through a histogram of all pitches it cannot reach 0.9942."""
    for seed in range(5):
        speed = fit_pitches(draw(1548, seed, METRES), METRES, KINDS, replicates=2).speed
        assert speed.least_squares.r_squared > 0.975
        assert speed.least_squares_as_printed.r_squared < 0.9


def test_wide_bins_widen_the_histogram_fit_as_sheppard_says():
    table = draw(200_000, 3, CELLS)
    for width in (1.0, 5.0):
        fit = fit_pitches(table, CELLS, KINDS, bin_width=width, replicates=2).speed.least_squares
        expected = math.sqrt(4.58**2 + width**2 / 12)
        # The rule is of second order in width/σ; the next term is 0.5 % at 5 km/h.
        assert fit.straight_spread.value * 3.6 == pytest.approx(expected, rel=0.01)


def test_speeds_in_coarse_steps_give_the_same_spread():
    table = draw(200_000, 5, CELLS)
    coarse = table.assign(kmh=5.0 * (table.kmh / 5.0).round())
    columns = CELLS.model_copy(update={"speed_resolution": 5.0})
    fine, rough = (
        fit_pitches(each, how, KINDS, bin_width=5.0, replicates=2).speed.maximum_likelihood
        for each, how in ((table, CELLS), (coarse, columns))
    )
    # Steps as wide as the spread itself: without the correction it would be 5 % more.
    assert rough.straight_spread.value == pytest.approx(fine.straight_spread.value, rel=2e-3)
    assert rough.straight_mean.value == pytest.approx(fine.straight_mean.value, rel=2e-4)


def test_bins_lie_between_the_speeds_that_are_written():
    table = draw(1548, 0, CELLS)
    whole = table.assign(kmh=table.kmh.round())
    columns = CELLS.model_copy(update={"speed_resolution": 1.0})
    histogram = fit_pitches(whole, columns, KINDS, bin_width=2.9, replicates=2).speed.histogram
    edges = np.array(histogram.edges) * 3.6
    assert np.diff(edges) == pytest.approx(3.0)
    assert edges % 1.0 == pytest.approx(0.5)
    assert edges[0] < whole.kmh.min() < edges[1]
    assert edges[-2] < whole.kmh.max() < edges[-1]
    assert sum(histogram.straight) + sum(histogram.breaking) == 1548


def test_r_squared_by_hand():
    assert r_squared(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 4.0])) == 0.5
    assert r_squared(np.array([1.0, 2.0, 3.0]), np.array([2.0, 2.0, 2.0])) == 0.0


def test_one_normal_across_the_plate_is_told_from_two():
    random = np.random.default_rng(8)
    table = draw(4000, 8, METRES)
    one = fit_pitches(
        table.assign(cell=random.normal(0.0, 0.2, len(table))), METRES, KINDS, replicates=2
    ).aim
    assert one.maximum_likelihood.peaks == 1
    assert one.gain_over_one_normal < 10.0
    assert one.gain_over_one_peak == 0.0
    assert not one.two_peaks_supported
    two = fit_pitches(table, METRES, KINDS, replicates=2).aim
    assert two.maximum_likelihood.peaks == 2
    assert two.gain_over_one_normal > 100.0
    assert two.gain_over_one_peak > 20.0
    assert two.two_peaks_supported


@pytest.mark.parametrize("half", [1.0, 1.2, 1.6, 2.0])
@pytest.mark.parametrize("side", [-1, 1])
def test_the_edge_between_one_and_two_peaks(half, side):
    edge = _OnePeak(3.0, half, 0.5).aim(side)
    y = np.linspace(-2.0, 8.0, 100_001)

    def maxima(weight):
        falls = np.diff(edge._replace(weight=weight).density(y)) < 0.0
        return np.sum(~falls[:-1] & falls[1:])

    lesser = 1.0 - edge.weight
    assert maxima(1.0 - 0.98 * lesser) == 1
    # At d = 1 every weight gives one peak; the lesser part's share is the edge beyond.
    assert maxima(1.0 - 1.02 * lesser) == (1 if half == 1.0 else 2)


@pytest.mark.nightly
def test_few_samples_with_one_peak_support_two():
    random = np.random.default_rng(2)
    edge = _OnePeak(2.0, 1.6, 0.6).aim(1)  # the worst case: a second peak is about to come
    samples = 16
    fitted = supported = 0
    for _ in range(samples):
        place = np.where(random.random(1548) < edge.weight, edge.left, edge.right)
        table = draw(1548, 1, METRES)
        table["cell"] = (place + random.normal(0.0, edge.spread, 1548) - 3.0) * 0.144
        aim = fit_pitches(table, METRES, KINDS, replicates=2).aim
        fitted += aim.maximum_likelihood.peaks == 2
        supported += aim.two_peaks_supported
    assert fitted > samples / 4  # the fit alone finds two peaks in every other sample
    assert supported <= 3  # 16 samples at 5 % have more in 0.7 of 100 cases


def test_a_number_at_the_end_of_its_range_has_no_error():
    aims = fit_pitches(EXAMPLE, replicates=2).aim
    aim = aims.maximum_likelihood
    assert aim.right_mean.value == pytest.approx(5.5, abs=1e-3)
    assert aim.right_mean.standard_error is None
    assert aim.right_mean.status == "at_bound"
    assert aim.left_mean.standard_error > 0.0
    assert aim.left_mean.status == "fitted"
    assert aims.least_squares_at_edges.left_mean.status == "held"


def test_a_weight_at_the_end_of_its_range_has_no_error():
    # Few straight balls, and a gap in the speeds of the others where they lie.
    speed = {
        "straight": [138.0, 139.0, 140.0] * 10,
        "breaking": [*range(120, 135), *range(144, 159)] * 12,
    }
    rows = [
        (kind, kmh, 0.05 * (i % 5)) for kind, each in speed.items() for i, kmh in enumerate(each)
    ]
    table = pd.DataFrame(rows, columns=["kind", "kmh", "cell"])
    weight = fit_pitches(table, METRES, KINDS, replicates=2).speed.least_squares.weight
    assert weight.value in (0.0, 1.0)
    assert (weight.status, weight.standard_error) == ("at_bound", None)


def test_heights_by_hand():
    heights = [1] * 30 + [2] * 20 + [3] * 30 + [4] * 20 + [5] * 25
    table = draw(len(heights), 2, CELLS).assign(height=heights)
    columns = CELLS.model_copy(update={"height": "height"})
    found = fit_pitches(table, columns, KINDS, replicates=2).height
    assert found.cells == (30, 20, 30, 20, 25)
    assert found.shares[4].value == 0.2
    assert found.shares[4].standard_error == pytest.approx(math.sqrt(0.2 * 0.8 / 125))
    assert found.chi_squared_of_lower_four == pytest.approx(4 * 25 / 25)
    # Survival function of χ² with 3 degrees of freedom at 4: erfc(√2) + √(8/π) e⁻².
    expected = math.erfc(math.sqrt(2)) + math.sqrt(8 / math.pi) * math.exp(-2)
    assert found.p_value_of_lower_four == pytest.approx(expected)


# ---- what is handed on ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def example():
    return fit_pitches(EXAMPLE, replicates=20, seed=4)


def test_the_example_agrees_with_pandas(example):
    frame = pd.read_csv(EXAMPLE)
    straight = frame.pitch_type.isin(["FF", "FA"])
    mixture, _ = example.distributions()
    for index, chosen in enumerate((straight, ~straight)):
        speed = frame.release_speed[chosen] * 0.44704
        assert mixture.parts[index][0] == pytest.approx(chosen.mean(), rel=1e-12)
        assert mixture.means[index] == pytest.approx(speed.mean(), rel=1e-12)
        spread = math.sqrt(speed.var(ddof=0) - (0.1 * 0.44704) ** 2 / 12)  # written to 0.1 mph
        assert mixture.deviations[index] == pytest.approx(spread, rel=1e-12)


def test_distributions_of_both_methods(example):
    for method in ("maximum_likelihood", "least_squares"):
        speed, aim = example.distributions(method)
        fitted = getattr(example.aim, method)
        assert speed.weight == getattr(example.speed, method).weight.value
        assert aim.weight == fitted.weight.value
        assert aim.means[0] <= aim.means[1]
        assert aim.means[1] == pytest.approx((fitted.right_mean.value - 3) * 0.144)
        assert aim.deviations == (pytest.approx(fitted.spread.value * 0.144),) * 2
    assert example.distributions() == example.distributions("maximum_likelihood")


def test_the_same_seed_gives_the_same_errors(example):
    assert fit_pitches(EXAMPLE, replicates=20, seed=4) == example
    other = fit_pitches(EXAMPLE, replicates=20, seed=5)
    assert other.speed.least_squares != example.speed.least_squares
    assert other.distributions() == example.distributions()
    assert other.distributions("least_squares") == example.distributions("least_squares")


def test_a_fit_is_read_back_as_it_was_written(example, tmp_path):
    path = tmp_path / "fitted.json"
    path.write_text(example.model_dump_json(), encoding="utf-8")
    assert load_fitted(path) == example


def test_a_fit_that_is_none_is_refused_by_key(example, tmp_path):
    path = tmp_path / "fitted.json"
    data = json.loads(example.model_dump_json())
    data["speed"]["maximum_likelihood"]["weight"]["value"] = "half"
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(TableError, match=r"speed\.maximum_likelihood\.weight\.value"):
        load_fitted(path)
    path.write_text(json.dumps(data | {"extra": 1}), encoding="utf-8")
    with pytest.raises(TableError, match="extra: unknown key"):
        load_fitted(path)
    with pytest.raises(TableError, match="cannot be read"):
        load_fitted(tmp_path / "nothing.json")


def test_the_text_says_what_was_used_and_what_was_not():
    table = pd.read_csv(EXAMPLE)
    table.loc[[6, 9], "plate_x"] = np.nan
    text = as_text(fit_pitches(table, replicates=2))
    assert "4416 pitches used of 4418 rows" in text
    assert "left out: 2, plate_x is missing (row 7, 10)" in text
    assert "straight: 1448 (FF 1443, FA 5)" in text or "straight: 14" in text
    assert "straight: 1448 (FF 1443, FA 5)" in text
    assert "4.000 (held)" in text
    assert "5.500 (at bound)" in text
    assert "2, unsupported" in text
    assert "The data do not support two peaks" in text
    assert all(len(line) <= 100 for line in text.splitlines())


@pytest.mark.parametrize(
    ("width", "sentence"),
    [
        (0.0, "a bin has a positive width"),
        (math.nan, "a bin has a positive width"),
        (40.0, "bin_width = 40 km/h puts these speeds into 2 bins; it takes 5 to 1000"),
        (1e-6, "it takes 5 to 1000"),
    ],
)
def test_bins_that_are_none(width, sentence):
    with pytest.raises(TableError, match=sentence):
        fit_pitches(draw(1548, 0, METRES), METRES, KINDS, bin_width=width)


def test_a_bootstrap_of_one_is_none():
    with pytest.raises(TableError, match="replicates = 1"):
        fit_pitches(EXAMPLE, replicates=1)


def test_what_equal_and_empty_cells_leave_undetermined():
    table = draw(1000, 0, CELLS).assign(cell=[1, 2, 3, 4, 5] * 200, height=[1, 2, 3, 4] * 250)
    columns = CELLS.model_copy(update={"height": "height"})
    fitted = fit_pitches(table, columns, KINDS, replicates=2)
    assert fitted.aim.least_squares.r_squared is None
    assert fitted.height.shares[4].value == 0.0
    assert fitted.height.shares[4].standard_error is None
    assert "0.0000 ± ?" in as_text(fitted)


def test_a_handful_of_pitches_is_not_fitted():
    table = pd.DataFrame({"kind": ["straight"] * 5 + ["breaking"] * 30, "kmh": 140.0, "cell": 3})
    with pytest.raises(TableError, match="kind: only 5 straight balls"):
        fit_pitches(table, CELLS, KINDS)
    table = pd.DataFrame({"kind": ["straight", "breaking"] * 30, "kmh": 140.0, "cell": 3})
    with pytest.raises(TableError, match="kmh: the 30 straight balls differ no more than"):
        fit_pitches(table, CELLS, KINDS)
