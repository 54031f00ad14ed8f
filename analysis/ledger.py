"""The ledger of readings, as it stands in the package."""

from analysis.writing import Report
from longball.model.readings import LEDGER


def run(report: Report, full: bool) -> str:
    """Return the section; nothing is measured, so `full` changes nothing."""
    return report.render("ledger", {"LEDGER": LEDGER})
