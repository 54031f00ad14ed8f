"""``longball movement``."""

from __future__ import annotations

import numpy as np

from longball.cli.options import Options
from longball.cli.tables import answers, pitches_of, show_each, show_types
from longball.pitches.statcast import INCH
from longball.questions.movement import PFX, clock, measured_movement


def movement(o: Options) -> None:
    """Compute the movement of measured pitches, and their angles at the plate.

    Movement is the deflection from a flight under gravity alone, counted from the release, by the
    nine parameters of each pitch: across to the catcher's left, and up. Text output has the medians
    of each pitch type (absolute values for across). JSON output has a line for each pitch, in SI
    units, with the direction on the pitcher's clock.
    """
    pitches = pitches_of(o, spin=False)
    since = PFX if o.pfx else None
    columns = answers(o, measured_movement, pitches, since)
    if o.json:
        clocks = [*map(clock, columns["across"].tolist(), columns["up"].tolist())]
        show_each(pitches, columns | {"clock": np.array(clocks)})
        return
    # Absolute values: left- and right-handers' pitches break to opposite sides, and would cancel.
    shown = {
        "across, in": abs(columns["across"]) / INCH,
        "up, in": columns["up"] / INCH,
        "VAA, °": np.degrees(columns["vertical"]),
        "HAA (size), °": np.degrees(abs(columns["horizontal"])),
    }
    show_types(pitches, shown)
