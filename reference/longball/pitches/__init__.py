"""The paper's data analysis (Sec. II) on any table of pitches."""

from longball.pitches.fitted import (
    AimMixture,
    FittedPitches,
    PitchDistributions,
    SpeedMixture,
    as_text,
    load_fitted,
)
from longball.pitches.fitting import fit_pitches
from longball.pitches.table import EXAMPLE, Columns, PitchesError, PitchTypes, read_pitches

__all__ = [
    "EXAMPLE",
    "AimMixture",
    "Columns",
    "FittedPitches",
    "PitchDistributions",
    "PitchTypes",
    "PitchesError",
    "SpeedMixture",
    "as_text",
    "fit_pitches",
    "load_fitted",
    "read_pitches",
]
