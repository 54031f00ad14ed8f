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
    unit: list[float] = []
    for kind, work in (
        ("flights", flights(contenders.COMPILED)),
        ("at-bats", at_bats(contenders.COMPILED)),
    ):
        some = work.first(TRUE)
        true = truth(some)
        everyone = list(entrants(work))
        times = seconds(everyone, work, TURNS)
        for entrant, mine in zip(everyone, times, strict=True):
            found = errors(entrant.solve(some), true)
            missed = f"{found.missed} of {found.contacts}" if found.contacts else ""
            print(
                f"{kind}: {entrant.name:33} {1e6 * statistics.median(mine):7.2f} "
                f"{ratio(mine, times[0]):8.2f}   {found.worst:.1e}             {missed}"
            )
        if unit:
            print(f"an at-bat takes as long as {ratio(times[0], unit):.2f} flights")
        unit = times[0]


if __name__ == "__main__":
    main()
