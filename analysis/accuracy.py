"""Error of the reference engine in whole at-bats, quantity by quantity."""

from analysis.speed_error import measuring, work
from analysis.writing import Report
from longball.model.quantities import at

COUNT, FULL_COUNT = 60, 600  # at-bats that are batted
SEED = 7


def run(report: Report, full: bool) -> str:
    """Measure on batted balls of the paper's distributions."""
    struck, results = work.batted(FULL_COUNT if full else COUNT, SEED)
    pairs = list(zip(results, work.truth(struck), strict=True))
    return report.render(
        "accuracy", globals(), count=len(pairs),
        worst=lambda x: max(measuring.difference(at(a, x), at(b, x)) for a, b in pairs),
    )  # fmt: skip
