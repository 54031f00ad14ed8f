"""How fast the batch engine is, next to its peers: ratios, measured side by side.

``python -m analysis.bench`` takes some four minutes. The contenders are some of those of the
study `analysis.speed_error`, on the same flights and at-bats; so are the measures of time and
error.
"""

from collections.abc import Iterator

from analysis.speed_error import contenders, laws
from analysis.speed_error.contenders import Contender
from analysis.speed_error.measuring import machine, measure, ratio, versions
from analysis.speed_error.work import at_bats, flights, known
from longball.engines.batch import Batch

TURNS = 15
TRUE = 50  # flights and at-bats of which the truth is found
LAW_ROUNDS, LAW_TRUE = 5, 10  # the same under other laws of flight


def entrants() -> Iterator[Contender]:
    """Yield who is timed, the measure of all first; a peer that is not installed is left out."""
    yield contenders.batch(Batch().tolerance)
    yield contenders.batch(1e-8)
    yield contenders.plain("DOP853", 1e-12)
    tightest = {peer.family: peer for peer in contenders.installed_peers()}
    yield from tightest.values()


def main() -> None:
    """Measure, and print a table."""
    print(f"{machine()}; {versions()}")
    for package in contenders.missing_peers():
        print(f"{package} is not installed: left out")
    print(f"{'':42} µs each    ratio   max error of D, m   contacts missed")
    works = [known(flights(contenders.COMPILED), TRUE), known(at_bats(contenders.COMPILED), TRUE)]
    turns = [(entrant, given) for given in works for entrant in entrants()]
    units: dict[str, list[float]] = {}
    for (_, given), found in zip(turns, measure(turns, TURNS), strict=True):
        kind, wrong = given.base.kind, found.errors
        unit = units.setdefault(kind, found.seconds)
        missed = f"{wrong.missed} of {wrong.contacts}" if wrong.contacts else ""
        print(
            f"{kind}: {found.contender.name:34} {found.microseconds:7.2f} "
            f"{ratio(found.seconds, unit):8.2f}   {wrong.worst:.1e}             {missed}"
        )
    print(f"an at-bat takes as long as {ratio(units['at-bat'], units['flight']):.2f} flights")
    of_laws = laws.compared(LAW_ROUNDS, LAW_TRUE)
    first = next(iter(laws.LAWS))
    print(f"{'':56} µs each    ratio to the first law, to batch   max error of D, m")
    for (law, method), found in of_laws.items():
        beside = [
            ratio(found.seconds, of_laws[x].seconds) for x in ((first, method), (law, "batch"))
        ]
        print(
            f"{law:40} {method:13} {found.microseconds:10.2f} "
            f"{beside[0]:8.2f} {beside[1]:8.2f}   {found.errors.worst:.1e}"
        )


if __name__ == "__main__":
    main()
