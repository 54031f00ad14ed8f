"""``longball spin``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from longball.cli.messages import note, refusing
from longball.cli.pitches import answers, pitches_of, show_each, show_types
from longball.pitches.models import Model, model_of
from longball.pitches.statcast import RPM
from longball.questions.spin import measured_spin


def spin(
    table: str = "-",
    example: bool = False,
    model: Model = "nathan",
    games: Path | None = None,
    column: list[str] | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    json_: bool = False,
    quiet: bool = False,
) -> None:
    """Compute the spin that causes the movement of measured pitches, and its active share.

    The force perpendicular to the path gives C_L in the weather of each game, and the model's law
    of lift gives the spin. Text output has the medians of each pitch type, JSON output a line for
    each pitch, in SI units.
    """
    law = model_of(model)
    pitches = pitches_of(table, example, games, column, spin=True)
    with refusing(f"--model {model}: "):
        found = answers(measured_spin, pitches, law, workers=workers, scheduler=scheduler)
    if json_:
        show_each(pitches, found)
    else:
        shown = {
            "C_D": found["drag_coefficient"],
            "C_L": found["lift_coefficient"],
            "across, rpm": found["transverse"] / RPM,
            "active share": found["active_share"],
        }
        show_types(pitches, shown)
    above, beyond = (found["active_share"] > 1.0).sum(), np.isnan(found["transverse"]).sum()
    # Both are findings on the table, and no failures: the rows have their numbers, or NaN.
    if above:
        note(f"the active share of {above} pitches is above 1: they move more than their spin can")
    if beyond:
        note(
            f"the C_L of {beyond} pitches is beyond what the law of lift reaches: no spin is given"
        )
