"""The fits of Sec. II: known answers, honest errors, and the paper's own numbers given back."""

import json
import math
from functools import partial

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


def numbers(fitted):
    """Value and error of every fitted number, in the paper's units."""
    speed, aim = fitted.speed, fitted.aim
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
        fitted = fit_pitches(draw(1548, seed, columns), columns, KINDS, replicates=50)
        for name, (value, error) in numbers(fitted).items():
            deviations[name].append((value - PRINTED[name]) / error)
    for name, each in deviations.items():
        z = np.array(each)
        # Each bound is one that 40 standard normal numbers break in about one case of 2,000.
        assert abs(z.mean()) < 3.5 / math.sqrt(seeds), name
        assert 0.62 < z.std() < 1.42, name
        assert np.sum(np.abs(z) < 1.96) >= 32, name


# ---- known answers -------------------------------------------------------------------------------


@pytest.mark.nightly
def test_likeliest_normals_by_hand():
    speeds = {"straight": [140.0, 144.0] * 15, "breaking": [120.0, 120.0, 126.0] * 20}
    table = pd.DataFrame(
        [(kind, kmh, 3) for kind, each in speeds.items() for kmh in each],
        columns=["kind", "kmh", "cell"],
    )
    fit = fit_pitches(table, CELLS, KINDS).speed
    # The errors are those of 200 replicates, known to 5 %: a fifth is four times that.
    close = partial(pytest.approx, rel=0.2)
    assert fit.straight_mean.value * 3.6 == pytest.approx(142.0)
    assert fit.straight_spread.value * 3.6 == pytest.approx(2.0)
    assert fit.straight_mean.standard_error * 3.6 == close(2.0 / math.sqrt(30))
    # Two points have the fourth moment 1: the spread does not vary to first order.
    assert fit.straight_spread.standard_error * 3.6 < 0.1
    assert fit.breaking_mean.value * 3.6 == pytest.approx(122.0)
    assert fit.breaking_spread.value * 3.6 == pytest.approx(math.sqrt(8.0))
    # Fourth moment (2 · 2⁴ + 4⁴)/3 / 8² = 1.5.
    expected = math.sqrt(8.0) * math.sqrt(0.5 / (4 * 60))
    assert fit.breaking_spread.standard_error * 3.6 == close(expected)
    assert fit.weight.value == pytest.approx(1 / 3)
    assert fit.weight.standard_error == close(math.sqrt(2 / 9 / 90))


def test_speeds_in_coarse_steps_give_the_same_spread():
    table = draw(200_000, 5, CELLS)
    coarse = table.assign(kmh=5.0 * (table.kmh / 5.0).round())
    columns = CELLS.model_copy(update={"speed_resolution": 5.0})
    fine, rough = (
        fit_pitches(each, how, KINDS, replicates=2).speed
        for each, how in ((table, CELLS), (coarse, columns))
    )
    # Steps as wide as the spread itself: without the correction it would be 5 % more.
    assert rough.straight_spread.value == pytest.approx(fine.straight_spread.value, rel=2e-3)
    assert rough.straight_mean.value == pytest.approx(fine.straight_mean.value, rel=2e-4)


def test_one_normal_across_the_plate_is_told_from_two():
    random = np.random.default_rng(8)
    table = draw(4000, 8, METRES)
    one = fit_pitches(
        table.assign(cell=random.normal(0.0, 0.2, len(table))), METRES, KINDS, replicates=2
    ).aim
    assert one.peaks == 1
    two = fit_pitches(table, METRES, KINDS, replicates=2).aim
    assert two.peaks == 2


def test_a_number_at_the_end_of_its_range_has_no_error():
    aim = fit_pitches(EXAMPLE, replicates=2).aim
    assert aim.right_mean.value == pytest.approx(5.5, abs=1e-3)
    assert aim.right_mean.standard_error is None
    assert aim.right_mean.status == "at_bound"
    assert aim.left_mean.standard_error > 0.0
    assert aim.left_mean.status == "fitted"


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


def test_the_same_seed_gives_the_same_errors(example):
    assert fit_pitches(EXAMPLE, replicates=20, seed=4) == example
    other = fit_pitches(EXAMPLE, replicates=20, seed=5)
    assert other.speed != example.speed  # in its errors
    assert other.distributions() == example.distributions()


def test_a_fit_is_read_back_as_it_was_written(example, tmp_path):
    path = tmp_path / "fitted.json"
    path.write_text(example.model_dump_json(), encoding="utf-8")
    assert load_fitted(path) == example


def test_a_fit_that_is_none_is_refused_by_key(example, tmp_path):
    path = tmp_path / "fitted.json"
    data = json.loads(example.model_dump_json())
    data["speed"]["weight"]["value"] = "half"
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(TableError, match=r"speed\.weight\.value"):
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
    assert "omitted: 2, plate_x is missing (row 7, 10)" in text
    assert "straight: 1448 (FF 1443, FA 5)" in text
    assert "5.500 (at bound)" in text
    assert all(len(line) <= 100 for line in text.splitlines())


def test_a_bootstrap_of_one_is_none():
    with pytest.raises(TableError, match="replicates = 1"):
        fit_pitches(EXAMPLE, replicates=1)


def test_what_equal_and_empty_cells_leave_undetermined():
    table = draw(1000, 0, CELLS).assign(cell=[1, 2, 3, 4, 5] * 200, height=[1, 2, 3, 4] * 250)
    columns = CELLS.model_copy(update={"height": "height"})
    fitted = fit_pitches(table, columns, KINDS, replicates=2)
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
