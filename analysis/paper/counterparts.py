"""Every number of the paper that can be had again: printed, ours, the difference, and why."""

import math
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from analysis.paper import argument, distances, home_run_figures, pitch_fits, printed
from analysis.paper.home_run_figures import Reproduced
from analysis.writing import render
from longball.pitches import EXAMPLE, fit_pitches

WHICH = "**reproduced**", "**by the nearest reading only**", "**by the default reading only**"
NO = "**not reproduced**"


class Counterpart(NamedTuple):
    """A printed number, and what the default and the nearest reading give."""

    place: str
    what: str
    printed: float
    default: float
    nearest: float
    noise: float  # standard error of the printed number; of a rounding, half the last digit over √3
    digits: int  # decimals shown
    same: str  # why, if the nearest reading has it
    other: str  # why, if none has

    @property
    def verdict(self) -> str:
        """Say which of the two readings gives the printed number within twice its noise."""
        by_default, by_nearest = (
            abs(ours - self.printed) <= 2 * self.noise for ours in (self.default, self.nearest)
        )
        if by_nearest:
            return f"{WHICH[not by_default]}: {self.same}"
        return f"{WHICH[2] if by_default else NO}: {self.other}"


def flat_noise(one: Reproduced) -> float:
    """Return by how much 1,000 samples scatter a bin over another, where the paper says flat.

    The largest over the smallest of four equal bins is about two such deviations above 1.
    """
    density = one.density[max(printed.PEAKS)][home_run_figures.CALLED_FLAT]
    return math.sqrt(2 / (printed.SAMPLES * distances.BIN * float(density.mean())))


def run(report: Path, full: bool) -> str:
    """Write the section; `full` takes more draws of pitches."""
    default, nearest = home_run_figures.reproduced()
    draws = pitch_fits.FULL_DRAWS if full else pitch_fits.DRAWS
    return render(
        report, "counterparts", vars(home_run_figures) | globals(), default=default,
        nearest=nearest, found=argument.everything(), noise=printed.noise,
        determination=pd.DataFrame(pitch_fits.determine(draws)),
        heights=fit_pitches(EXAMPLE, replicates=2).height,
        pitches=[x for x in pitch_fits.compared() if x["method"] == "maximum_likelihood"],
    )  # fmt: skip
