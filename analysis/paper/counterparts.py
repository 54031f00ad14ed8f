"""Every number of the paper that can be had again: printed, ours, the difference, and why."""

from typing import NamedTuple

import pandas as pd

from analysis.paper import argument, combinations, home_run_figures, pitch_fits, printed
from analysis.writing import Report
from longball.pitches import EXAMPLE, fit_pitches

WHICH = "**reproduced**", "by the nearest reading only", "by the default reading only"
# The nearest reading was chosen by Figs. 6 and 7, so that these say nothing for it.
CHOSEN = "fitted: the nearest reading was chosen by it"
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
    chosen: bool = False  # whether the nearest reading was chosen by it

    @property
    def verdict(self) -> str:
        """Say which of the two readings gives the printed number within twice its noise."""
        by_default, by_nearest = (
            abs(ours - self.printed) <= 2 * self.noise for ours in (self.default, self.nearest)
        )
        if by_nearest and self.chosen and not by_default:
            return f"{CHOSEN}; {self.same}"
        if by_nearest:
            return f"{WHICH[not by_default]}: {self.same}"
        return f"{WHICH[2] if by_default else NO}: {self.other}"


def run(report: Report, full: bool) -> str:
    """Write the section; `full` takes more draws of pitches."""
    default, nearest = home_run_figures.reproduced()
    draws = pitch_fits.FULL_DRAWS if full else pitch_fits.DRAWS
    brief = report.render("in_brief", vars(combinations), found=combinations.study())
    return brief + report.render(
        "counterparts", vars(home_run_figures) | globals(), default=default,
        nearest=nearest, found=argument.everything(), noise=printed.noise,
        determination=pd.DataFrame(pitch_fits.determine(draws)),
        heights=fit_pitches(EXAMPLE, replicates=2).height,
        pitches=[x for x in pitch_fits.compared() if x["method"] == "maximum_likelihood"],
    )  # fmt: skip
