"""The paper's data analysis (Sec. II) on any table of pitches."""

from longball.pitches.fitted import (
    FittedPitches,
    as_text,
    load_fitted,
)
from longball.pitches.fitting import fit_pitches
from longball.pitches.table import EXAMPLE, Columns, PitchesError, PitchTypes, read_pitches

__all__ = [
    "EXAMPLE",
    "Columns",
    "FittedPitches",
    "PitchTypes",
    "PitchesError",
    "as_text",
    "fit_pitches",
    "load_fitted",
    "read_pitches",
]
