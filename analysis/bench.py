"""How fast the batch engine is, next to its peers: ratios, measured side by side.

``python -m analysis.bench`` takes less than three minutes. The contenders are some of those of the
study `analysis.speed_error`, on the same flights and at-bats; so are the measures of time and
error.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator

from analysis.speed_error import contenders
from analysis.speed_error.contenders import Contender
from analysis.speed_error.measuring import errors, machine, ratio, seconds, versions
from analysis.speed_error.work import Work, at_bats, flights, truth
from longball.engines.batch import Batch

TURNS = 15
TRUE = 50  # flights and at-bats of which the truth is found


def entrants(work: Work) -> Iterator[Contender]:
    """Yield who is timed, the measure of all first; a peer that is not installed is left out."""
    yield contenders.batch(Batch().tolerance)
    yield contenders.batch(1e-8)
    yield contenders.plain(work, "DOP853", 1e-12)
    tightest = {peer.family: peer for peer in contenders.installed_peers(work)}
    yield from tightest.values()


def main() -> None:
    """Measure, and print a table."""
    print(f"{machine()}; {versions()}")
    for package in contenders.missing_peers():
        print(f"{package} is not installed: left out")
    print(f"{'':42} µs each    ratio   max error of D, m   contacts missed")
    works = [flights(contenders.COMPILED), at_bats(contenders.COMPILED)]
    known = {work.base.kind: (work.first(TRUE), truth(work.first(TRUE))) for work in works}
    turns = [(entrant, work) for work in works for entrant in entrants(work)]
    units: dict[str, list[float]] = {}
    for (entrant, work), mine in zip(turns, seconds(turns, TURNS), strict=True):
        kind = work.base.kind
        unit = units.setdefault(kind, mine)
        some, true = known[kind]
        found = errors(entrant.solve(some), true)
        missed = f"{found.missed} of {found.contacts}" if found.contacts else ""
        print(
            f"{kind}: {entrant.name:34} {1e6 * statistics.median(mine):7.2f} "
            f"{ratio(mine, unit):8.2f}   {found.worst:.1e}             {missed}"
        )
    print(f"an at-bat takes as long as {ratio(units['at-bat'], units['flight']):.2f} flights")


if __name__ == "__main__":
    main()
