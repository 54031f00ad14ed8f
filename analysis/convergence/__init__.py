"""Effects of the paper's time step on a flight, an at-bat, the contact and P(e).

Pieces that take long are kept in `report/.resume` as they come, under the fingerprint of the code
that made them: an interrupted study goes on where it was. On two cores the study takes about two
minutes; `--full`, with thirty times as many pieces, about forty.
"""

from analysis.convergence import budget, flights, pushes, science, tunnelling
from analysis.writing import Report


def run(report: Report, full: bool) -> str:
    """Run the studies."""
    studies = [study.run(report, full) for study in (flights, budget, pushes, tunnelling, science)]
    return report.render("convergence", {}, studies=studies)
