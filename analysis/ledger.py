"""The ledger of readings, as it stands in the package."""

from __future__ import annotations

from pathlib import Path

from analysis.writing import markdown_table
from longball.model.readings import LEDGER


def run(report: Path, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    rows = [[f"`{x.switch}`", x.belongs, ", ".join(x.options), x.place, x.why] for x in LEDGER]
    return "\n".join(
        [
            "## The ledger of readings\n",
            "Every place where the paper is silent, ambiguous or wrong is a switch: of a scene's "
            "`reading`, of the sampling of at-bats, of the scheme (the engine `verlet`) or of the "
            "figure that P(e) is held against. The default is the first option. What each one does "
            "to P(e), and which ones come nearest to the paper's numbers, is in "
            "[the paper, reproduced](paper.md#which-reading-gives-the-papers-numbers).\n",
            markdown_table(["switch", "belongs to", "options", "place in the paper", "why"], rows),
        ]
    )
