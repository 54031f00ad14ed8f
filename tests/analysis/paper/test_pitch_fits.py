"""The verdicts of the study of pitches follow from the numbers, whichever way these fall."""

import pytest

from analysis.paper.pitch_fits import (
    PRINTED,
    Printed,
    draw_pitches,
    verdict,
)

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


def test_drawn_pitches_are_written_as_the_source_does():
    table = draw_pitches(500, seed=1)
    assert (table.speed_kmh % 1 == 0).all()
    assert set(table.y) == {1, 2, 3, 4, 5}
    assert [printed.value for printed in PRINTED] == [
        139.1, 4.58, 127.8, 7.80, 0.45, 2, 4, 0.77, 0.52,
    ]  # fmt: skip
