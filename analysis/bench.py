"""Speed of the batch engine beside its peers: ratios, measured side by side.

``python -m analysis.bench`` takes some four minutes. The contenders are some of those of the
study `analysis.speed_error`, on the same flights and at-bats; so are the measures of time and
error.
"""

from analysis.__main__ import REPORT
from analysis.speed_error import contenders, laws, measuring
from analysis.speed_error.measuring import measure
from analysis.speed_error.work import at_bats, flights, known
from analysis.writing import Report
from longball.engines.batch import Batch

TURNS = 15
TRUE = 50  # flights and at-bats of which the truth is found
LAW_ROUNDS, LAW_TRUE = 5, 10  # the same under other laws of flight


def main() -> None:
    """Measure, and print tables."""
    works = [known(flights(contenders.COMPILED), TRUE), known(at_bats(contenders.COMPILED), TRUE)]
    tightest = {peer.family: peer for peer in contenders.installed_peers()}
    # The measure of all first.
    ours = contenders.batch(Batch().tolerance), contenders.batch(1e-8)
    entrants = (*ours, contenders.plain("DOP853", 1e-12), *tightest.values())
    turns = [(entrant, given) for given in works for entrant in entrants]
    found = list(zip(turns, measure(turns, TURNS), strict=True))
    # The first of each kind.
    units = {given.base.kind: one.seconds for (_, given), one in reversed(found)}
    of_laws = laws.compared(LAW_ROUNDS, LAW_TRUE)
    there = vars(measuring) | globals()
    print(Report(REPORT).render("bench", there, found=found, units=units, of_laws=of_laws), end="")


if __name__ == "__main__":
    main()
