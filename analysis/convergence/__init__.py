"""What the paper's time step does: to a flight, to an at-bat, to the contact, to P(e).

Pieces that take long are kept in `report/.resume` as they come, under the fingerprint of the code
that made them: an interrupted study goes on where it was. On two cores the study takes about two
minutes; `--full`, with thirty times as many pieces, about forty.
"""

from __future__ import annotations

from pathlib import Path

from analysis.convergence import budget, flights, science, tunnelling

HEAD = """## The paper's scheme, and what its time step does

Velocity Verlet as the paper prints it (`longball solve --engine verlet`), in every reading of
what it leaves open. Flights are held against 20 proven digits, at-bats against the reference
engine.
"""


def run(report: Path, full: bool) -> str:
    """Run the four studies."""
    studies = (flights, budget, tunnelling, science)
    return "\n".join([HEAD, *(study.run(report, full) for study in studies)])
