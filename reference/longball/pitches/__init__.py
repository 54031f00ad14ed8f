"""Tables of measured pitches and batted balls: the paper's analysis, and predictions."""

from longball.pitches.chart import Columns, PitchTypes, read_pitches
from longball.pitches.fitted import FittedPitches, as_text, load_fitted
from longball.pitches.fitting import fit_pitches
from longball.pitches.prediction import measured
from longball.pitches.table import EXAMPLE, TableError

__all__ = [
    "EXAMPLE",
    "Columns",
    "FittedPitches",
    "PitchTypes",
    "TableError",
    "as_text",
    "fit_pitches",
    "load_fitted",
    "measured",
    "read_pitches",
]
