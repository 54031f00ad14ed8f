"""Printed numbers on home runs and distances, and two figures of the ball's makers.

What it prints about pitches stands in `analysis.paper.pitch_fits`, the numbers of its model in
`longball.home_run` and `longball.model.scene`.
"""

import math
from typing import Any, NamedTuple

from longball.home_run import paper_at_bats
from longball.model.readings import SamplingReading
from longball.model.scene import AtBatScene

# Its at-bats by the default readings: what is the same in all, and the distributions of the rest.
BASE, AT_BATS = AtBatScene(id="base"), paper_at_bats(SamplingReading())

SAMPLES = 1_000  # behind each density of Fig. 6 and each point of Fig. 7 (Sec. IV)
PEAKS = {0.41: 75.0, 0.45: 125.0}  # m, highest peak of Fig. 6 by restitution (Sec. IV)
FLAT = (40.0, 80.0)  # m, where the density at e = 0.45 is called almost the same (Sec. V)
P_TEXT = (0.42, 0.17)  # P(0.42) ≈ 0.17 (Sec. V)
UZR_SPAN, UZR_SHARE = (91.44, 121.92), 0.179  # m; share of batted balls found there (Sec. V)


def noise(p: Any) -> Any:
    """Return the standard error of shares of the paper's samples."""
    return (p * (1 - p) / SAMPLES) ** 0.5


class Season(NamedTuple):
    """A line of Table I."""

    year: int
    restitution: float
    home_runs: int


# Seasons that Table I invites to compare: a livelier ball, and a duller one.
PAIRS = (
    (Season(2010, 0.418, 1605), Season(2011, 0.408, 939)),
    (Season(2013, 0.416, 1311), Season(2012, 0.408, 881)),
)


class Carry(NamedTuple):
    """Change of the carry of a ball with its restitution, by another source."""

    who: str
    slope: float  # dD/de, m
    slope_error: float  # m, standard error, of the rounding of the change or of both carries


# The league's carries are 109.4 m and 110.4 m. The maker gives 20 cm for 0.001, for a pitch of
# 144 km/h, a swing of 126 km/h and a launch at 27° (Mizuno, notice of 12 June 2013).
CARRIES = (
    Carry("the league", (110.4 - 109.4) / (0.417 - 0.4134), 0.1 / math.sqrt(3) / (0.417 - 0.4134)),
    Carry("the maker of the ball", 0.20 / (0.417 - 0.416), 0.05 / math.sqrt(3) / (0.417 - 0.416)),
)
