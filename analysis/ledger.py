"""The ledger of readings, as it stands in the package."""

from pathlib import Path

from analysis.writing import render
from longball.model.readings import LEDGER


def run(report: Path, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    return render(report, "ledger", {"LEDGER": LEDGER})
