"""The verdicts of the study of pitches follow from the numbers, whichever way these fall."""

import pytest

from analysis.paper.histograms import curves
from analysis.paper.pitch_fits import (
    PRINTED,
    Fits,
    Found,
    Printed,
    draw_pitches,
    verdict,
    write,
)
from analysis.writing import Report
from longball.pitches import EXAMPLE, fit_pitches, read_pitches

pytestmark = pytest.mark.nightly  # of the paper's analysis alone

WIDENED = Printed("spread", "cells", 0.77, "aim", "spread", 1.0, 1.0)


@pytest.mark.parametrize(
    ("method", "value", "error", "sentence"),
    [
        ("maximum_likelihood", 0.80, 0.02, "given back"),
        ("maximum_likelihood", 0.82, 0.02, "off by 2.5 standard errors: chance"),
        ("maximum_likelihood", 0.87, 0.02, "off by 5.0 standard errors, unexplained"),
        ("maximum_likelihood", 0.80, None, "not determined by these pitches"),
        # √(0.77² + 1/12) = 0.822
        ("least_squares", 0.83, 0.02, "too wide by its bins: Sheppard's rule gives 0.822"),
        ("least_squares", 0.87, 0.02, "biased: a density at a cell's number is not its share"),
    ],
)
def test_verdicts(method, value, error, sentence):
    assert verdict(WIDENED, method, value, error) == sentence


def row(what, width, low, high):
    middle = (low + high) / 2
    return {
        "what": what, "bin_width": width, "draws": 9, "low": low, "median": middle, "high": high,
    }  # fmt: skip


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return a function that writes the section for given quantiles of R²."""
    pitches = read_pitches(EXAMPLE)
    example = Fits(fit_pitches(EXAMPLE, replicates=2), curves(pitches, replicates=2))
    aims = [row("aim", 1.0, 0.9, 0.99), row("aim on the curve", 1.0, 0.9, 0.95)]
    coverage = [{"draws": 9, "within_1.96": 0.95}]

    def section(*r_squared):
        found = Found([], coverage, [*r_squared, *aims], [], [])
        return write(Report(tmp_path_factory.mktemp("report")), example, example, found)

    return section


NARROW, WIDE = row("speed", 1.0, 0.95, 0.98), row("speed", 3.0, 0.98, 0.998)
LOW, HIGH = row("speed as printed", 3.0, 0.8, 0.86), row("speed as printed", 3.0, 0.8, 0.999)


def test_equation_2_as_printed_is_judged_by_what_it_reaches(written):
    assert "It is **not** the curve" in written(NARROW, LOW)
    assert "cannot be told" in written(NARROW, HIGH)


def test_the_printed_r_squared_is_judged_by_the_widths_that_give_it(written):
    assert "bins of 3 km/h give: **consistent**" in written(NARROW, WIDE, LOW)
    assert "gives the printed 0.9942: **not reproduced**" in written(NARROW, LOW)


def test_places_are_judged_by_their_own_r_squared(written):
    section = written(NARROW, LOW)
    assert "give 0.945 (0.900 to 0.990): **consistent**" in section
    assert "give 0.925 (0.900 to 0.950): **not reproduced**" in section


def test_drawn_pitches_are_written_as_the_source_does():
    table = draw_pitches(500, seed=1)
    assert (table.speed_kmh % 1 == 0).all()
    assert set(table.y) == {1, 2, 3, 4, 5}
    assert [printed.value for printed in PRINTED] == [
        139.1, 4.58, 127.8, 7.80, 0.45, 2, 4, 0.77, 0.52,
    ]  # fmt: skip
