"""Changes of sign along lines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from longball.home_run.crossings import _may_turn, crossings

GRID = np.tile(np.linspace(0.0, 10.0, 21), (2, 1))

# Roots are bracketed to 1e-13, or to where the function is below 1e-10 (slopes here are about 1).
NEAR = 1e-9


def found(function):
    lines = np.repeat([0, 1], GRID.shape[1])
    values = function(GRID.ravel(), lines).reshape(GRID.shape)
    return crossings(function, GRID, values)


def test_every_root_of_every_line_is_found_with_its_direction():
    every = found(lambda x, line: np.where(line == 0, np.sin(x), np.cos(x)))
    # sin is positive at the first sample, 0, which is no change of sign.
    expected = [math.pi, 2 * math.pi, 3 * math.pi]
    expected += [math.pi / 2, 3 * math.pi / 2, 5 * math.pi / 2]
    np.testing.assert_allclose(every.place, expected, atol=NEAR)
    assert every.line.tolist() == [0, 0, 0, 1, 1, 1]
    assert every.rises.tolist() == [False, True, False, False, True, False]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_pair_between_two_samples_is_found(sign: float):
    # Zero 0.03 on either side of 5.2; the samples are 0.5 apart.
    every = found(lambda x, line: sign * ((x - 5.2) ** 2 - 0.03**2) + 0.0 * line)
    np.testing.assert_allclose(every.place, [5.17, 5.23] * 2, atol=1e-8)  # a slope of 0.06
    assert every.rises.tolist() == [sign < 0, sign > 0] * 2


def test_a_turn_that_stays_on_its_side_is_none():
    assert len(found(lambda x, line: (x - 5.2) ** 2 + 0.01 + 0.0 * line).place) == 0


def test_a_jump_is_halved_to_its_place():
    every = found(lambda x, line: np.where(x < math.e, -150.0, 75.0 + line))
    np.testing.assert_allclose(every.place, [math.e, math.e], atol=1e-11)
    assert every.rises.all()
    assert every.jumps.all()


def test_a_steep_crossing_is_no_jump():
    every = found(lambda x, line: 1e4 * (x - math.e) + 0.0 * line)
    assert not every.jumps.any()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("three", "turns"),
    [((3.0, 0.9, 2.0), True), ((3.0, 2.0, 1.0), False), ((1.0, 0.5, 0.6), False)],
)
def test_a_turn_is_sought_between_larger_samples_that_are_far_enough(sign, three, turns):
    """The middle one is below its neighbours, and below half of their differences from it."""
    values = sign * np.array([three])
    found = _may_turn(values, values >= 0.0)
    assert found.tolist() == [[False, turns, False]]
